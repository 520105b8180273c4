"""Lost steps in the log of an axis, three of them and of different sizes, and a noisy log recorded
later. The readings are written out here by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.diagnose.test_workshop import HEAD, diagnosed

RATE, STROKES, FAST = 50.0, 6, 20.0  # Hz; there and back; mm/s
JUMPS = ((12.13, -3.0), (14.55, -1.4), (31.07, -2.7))  # s, um


def log(start: float, noise_um: float, seed: int, kept: float = 0.0) -> str:
    """X to and fro over 60 mm by its scale, 0.4 mm from sample to sample. kept: correlation of the
    noise from one to the next."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, STROKES * 6.0, 1 / RATE)
    share = (t * FAST / 60.0) % 2.0
    x = 200.0 + 60.0 * np.where(share < 1.0, share, 2.0 - share)
    noise, now = np.empty(len(t)), 0.0
    for k, e in enumerate(rng.standard_normal(len(t))):
        now = kept * now + noise_um * np.sqrt(1 - kept**2) * e
        noise[k] = now
    off = noise + sum(size * (t + start > moment) for moment, size in JUMPS)
    rows = [
        f"1,{s:.3f},{c:.4f},{c + d * 1e-3:.5f}" for s, c, d in zip(t + start, x, off, strict=True)
    ]
    head = HEAD.format("trace", "scale") + f'# sees = "scale"\n# rate_hz = {RATE}\n'
    return head + "run,t_s,X_cmd_mm,X_act_mm\n" + "\n".join(rows) + "\n"


def answered(folder: Path, *texts: str) -> list[dict]:
    """The effects that are accepted."""
    found: list[dict] = diagnosed(folder, *texts)["effects"]
    return [e for e in found if e["status"] == "accepted"]


def jumps_of(effect: dict) -> list[tuple[float, float]]:
    value = {name: p["value"] for name, p in effect["parameters"].items()}
    moments, sizes = ("t_s", "second_s", "third_s"), ("jump_um", "second_um", "third_um")
    return [(value[t], value[um]) for t, um in zip(moments, sizes, strict=True)]


@pytest.mark.parametrize("later", [False, True])
def test_three_jumps_and_a_noisy_log_later(tmp_path, later):
    """What a log that was begun later scatters by is no jump of the first one."""
    texts = [log(0.0, 0.06, 1), *([log(500.0, 1.0, 2, 0.8)] if later else [])]
    (lost,) = answered(tmp_path, *texts)
    assert (lost["effect"], lost["axis"]) == ("step_loss", "X")
    for (t, um), (moment, size) in zip(jumps_of(lost), JUMPS, strict=True):
        assert t == pytest.approx(moment, abs=1.1 / RATE)
        assert um == pytest.approx(size, abs=0.1)
