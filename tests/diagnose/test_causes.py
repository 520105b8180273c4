"""A lag in proportion to the speed, and the force of the drive that tells whose it is. The motion
is written out here by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.diagnose.test_strangers_forms import names
from tests.diagnose.test_workshop import HEAD, diagnosed

MASS, GREASE = 200.0, 100.0  # kg, N s/m
RATE, BEGINS = 200.0, 0.08  # Hz, s


def log(late_ms: float, grease: float, noise_um: float = 0.3, a_N: float = 0.0) -> str:
    """X to and fro over 100 mm at 20, 60 and 150 mm/s, late by so many ms, and its force; or its
    current, of so many A/N."""
    rng = np.random.default_rng(5)
    parts = []
    for speed in (20.0, 60.0, 150.0):
        for way in (1, -1):
            n = int(100.0 / speed * RATE)
            parts += [np.full(n, way * speed), np.zeros(int(0.4 * RATE))]
    asked = np.concatenate([np.zeros(40), *parts])
    wide = int(BEGINS * RATE)
    v = np.convolve(asked, np.ones(wide) / wide)[: len(asked)]
    t = np.arange(len(v)) / RATE
    place = 250.0 + np.cumsum(v) / RATE
    force = MASS * np.gradient(v, t) * 1e-3 + grease * v * 1e-3 + rng.standard_normal(len(t))
    off = -late_ms * v + noise_um * rng.standard_normal(len(t))
    rows = [
        f"1,{s:.3f},{c:.5f},{c + d * 1e-3:.6f},{f * (a_N or 1.0):.5g}"
        for s, c, d, f in zip(t, place, off, force, strict=True)
    ]
    head = HEAD.format("trace", "scale") + '# sees = "scale"\n'
    signal = "X_current_A" if a_N else "force_X_N"
    return head + f"run,t_s,X_cmd_mm,X_act_mm,{signal}\n" + "\n".join(rows) + "\n"


# 5 N/um, as a drive has it; 0.01 N/um, as none has it; no friction in the force
@pytest.mark.parametrize(
    "late_ms,grease,name",
    [(0.02, GREASE, "viscous_friction"), (10.0, GREASE, "servo_lag"), (0.02, 0.0, "servo_lag")],
)
@pytest.mark.parametrize("a_N", [0.0, 0.002, 0.02])
def test_the_force_or_the_current_tells_whose_a_lag_is(tmp_path, late_ms, grease, name, a_N):
    answer = diagnosed(tmp_path, log(late_ms, grease, a_N=a_N))
    assert names(answer)[0] == f"{name}:X"
    first = answer["effects"][0]
    size = first["parameters"]["tau_ms" if name == "servo_lag" else "um_s_mm"]["value"]
    assert size == pytest.approx(late_ms, rel=0.1)
    assert ("servo_lag:X" in first["equivalent"]) == (name == "viscous_friction")
