"""What a circular test begins with (ISO 230-4): an axis that rests at a quadrant may turn there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import nuisances


@pytest.mark.parametrize("begin_deg, quadrant", [(0.0, True), (90.0, True), (45.0, False)])
def test_a_circle_that_begins_at_a_quadrant_begins_with_what_fades(begin_deg, quadrant):
    """Two circles of 10 s; after 0.2 s 1/e of what fades in 0.2 s is left; each fades by itself."""
    time = np.r_[np.linspace(5.0, 15.0, 101), np.linspace(20.0, 30.0, 101)]
    run = np.repeat([1.0, 2.0], 101)
    angle = np.radians(begin_deg) + 2 * np.pi * np.tile(np.linspace(0.0, 1.0, 101), 2)
    velocity = {"X": -np.sin(angle), "Y": np.cos(angle)}
    rows = SimpleNamespace(run=run, state=SimpleNamespace(velocity=velocity))
    unit = SimpleNamespace(rows=np.arange(202), time=time)
    groups = nuisances._at_quadrants(cast(Any, rows), cast(Any, unit))
    assert len(groups) == (2 if quadrant else 0)
    for own, group in zip((slice(0, 101), slice(101, 202)), groups, strict=False):
        fades = group.columns[:, nuisances.FADES.index(0.2)]
        assert fades[own][[0, 2]] == pytest.approx([1.0, np.exp(-1)])
        assert fades.sum() == pytest.approx(fades[own].sum())
