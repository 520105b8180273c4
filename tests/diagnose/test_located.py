"""A region that noise does not explain and no name takes is unknown, whatever else was found."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import judge, locate

PLACES = np.arange(0.0, 400.0, 10.0)  # mm
NOISE = 3e-4  # mm


def region(p: float) -> locate.Place:
    """X from 100 to 190 mm."""
    rms = peak = 3e-3
    return locate.Place(0, 0, "X", 100.0, 190.0, "both", (1,), (0.0, 1e4), (1, 99), rms, peak, p)


def left(p: float, off_um: float, named_um: float = 0.0, dense: bool = False) -> list:
    """What is unknown, of readings off by that in the region beside names that explain so much."""
    n = len(PLACES)
    within = (PLACES >= 100.0) & (PLACES <= 190.0)
    after = np.where(within, off_um * 1e-3, 0.0)
    named = named_um * 1e-3 * np.where(np.arange(n) % 2, 1.0, -1.0)
    state = SimpleNamespace(
        position={"X": PLACES}, approach={"X": np.ones(n)}, time=np.arange(float(n))
    )
    rows = {"state": state, "signal": np.zeros(n, int)}
    unit = SimpleNamespace(dense=dense, sees="laser", rows=np.arange(n))
    sets = SimpleNamespace(evidence=SimpleNamespace(parts=[SimpleNamespace(unit=unit, whole=unit)]))

    class Rows(SimpleNamespace):
        def __len__(self) -> int:
            return n

    d = SimpleNamespace(
        rows=Rows(**rows),
        places=[region(p)],
        after=after,
        before=after + named,
        noise=np.full(n, NOISE),
        scatter=np.zeros(0),
    )
    return judge._located(cast(Any, d), cast(Any, sets))


def test_a_region_that_no_draw_of_the_noise_reaches_is_unknown():
    ((times, rms, unit),) = left(1 / (locate.DRAWS + 1), 3.0)
    assert rms == pytest.approx(np.sqrt(3.0**2 - 0.3**2) * 1e-3) and unit == 0
    assert times == pytest.approx(rms / 1e-3)


@pytest.mark.parametrize(
    "how",
    [
        {"p": 2 / (locate.DRAWS + 1), "off_um": 3.0},  # a draw reaches it
        {"p": 1 / (locate.DRAWS + 1), "off_um": 0.9},  # not worth a word
        {"p": 1 / (locate.DRAWS + 1), "off_um": 3.0, "named_um": 13.0},  # an error of their form
        {"p": 1 / (locate.DRAWS + 1), "off_um": 3.0, "dense": True},  # a trace wanders
    ],
)
def test_what_is_no_unknown_region(how):
    assert left(**how) == []
