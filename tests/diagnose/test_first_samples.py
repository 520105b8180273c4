"""The first sample of a run: the axes have not moved yet, so that they stand where the run before
left them, on the other side of their lost motion."""

from __future__ import annotations

import numpy as np
import pytest

from tests.diagnose.test_strangers_forms import names
from tests.diagnose.test_workshop import HEAD, diagnosed

RADIUS, FEED, STEPS = 100.0, 3000.0, 800  # mm, mm/min, samples of a circle


def circles(size_um: float) -> str:
    """Four circles about X300 Y200, by turns clockwise and counter-clockwise, from 30 degrees; the
    gap in X is taken up at once by the first step of another direction."""
    rng, rows, t, side = np.random.default_rng(4), [], 0.0, 1.0
    gap = 2 * np.pi * RADIUS / STEPS / (FEED / 60)
    for run in range(1, 5):
        sense = 1 if run % 2 else -1
        angle = np.radians(30.0) + sense * 2 * np.pi * np.arange(STEPS + 1) / STEPS
        x, y = 300 + RADIUS * np.cos(angle), 200 + RADIUS * np.sin(angle)
        for k, (a, cx, cy) in enumerate(zip(angle, x, y, strict=True)):
            if k and abs(cx - x[k - 1]) > 1e-9:
                side = np.sign(cx - x[k - 1])
            off = -0.5 * size_um * side * np.cos(a) + 0.1 * rng.standard_normal()
            rows.append(f"{run},{t:.5f},{cx:.6f},{cy:.6f},{off:.4f},{sense}")
            t += gap
        t += 5.0
    head = HEAD.format("ballbar", "ballbar") + f"# radius_mm = {RADIUS}\n# feed_mm_min = {FEED}\n"
    head += "# centre = { X = 300.0, Y = 200.0 }\n"
    return head + "run,t_s,X_cmd_mm,Y_cmd_mm,radial_um,sense\n" + "\n".join(rows) + "\n"


def test_a_change_of_sense_leaves_nothing_unexplained(tmp_path):
    """12 um of play at the first sample of each circle, at 30 degrees, is no other physics."""
    answer = diagnosed(tmp_path, circles(12.0))
    assert names(answer) == ["backlash:X"] and answer["unknown"] is None
    (found,) = (e for e in answer["effects"] if e["effect"] == "backlash")
    assert found["parameters"]["size_um"]["value"] == pytest.approx(12.0, abs=0.1)
    assert answer["fit"]["rms_after_um"] == pytest.approx(0.1, abs=0.03)
