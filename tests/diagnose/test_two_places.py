"""Near and far place by turns while the machine warms up (ISO 230-3): what both do alike is no
noise of the instrument."""

from __future__ import annotations

import numpy as np
import pytest

from tests.diagnose.test_strangers_forms import names
from tests.diagnose.test_workshop import HEAD, diagnosed


def test_a_drift_of_two_places_read_by_turns(tmp_path):
    """12 um towards a level with 12 minutes, at six times; the laser scatters by 0.05 um."""
    rng, rows = np.random.default_rng(6), []
    for run, t in enumerate((60, 540, 1230, 1800, 2460, 3020), 1):
        for late, x in ((0, 100), (8, 450)):
            off = -12.0 * (1 - np.exp(-(t + late) / 720.0)) + 0.05 * rng.standard_normal()
            rows.append(f"{run},{t + late},{x},1,{off:.3f}")
    head = HEAD.format("targets", "laser interferometer") + '# quantity = "displacement"\n'
    head += "# sensitive = { X = 1.0 }\nrun,t_s,X_mm,approach_X,reading_um\n"
    answer = diagnosed(tmp_path, head + "\n".join(rows) + "\n")
    assert names(answer) == ["structure_drift:X"] and answer["unknown"] is None
    assert answer["fit"]["noise_floor_um"] == pytest.approx(0.05, abs=0.05)
