"""What is rounding, or a few outliers, is no evidence; and friction opposes motion."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.diagnose.fit import Projector, inverse, solve
from postproc.effects import friction_asymmetry


def test_columns_that_nuisances_make_alike_have_no_evidence_of_rounding():
    """Two columns that differ by a nuisance of unknown size: together they fall by what one of them does."""
    rng = np.random.default_rng(2)
    n = 400
    zero, slope, bend = np.ones(n), np.linspace(-1, 1, n), rng.normal(size=n)
    p = Projector.of(np.full(n, 1e-3), np.stack([zero, slope], axis=1), np.full(2, 1e3))
    y = 0.03 * zero - 0.02 * slope + rng.normal(0, 1e-3, n)
    both = np.stack([bend, bend + 50 * slope], axis=1)
    falls = []
    for columns in (both, bend[:, None]):
        _, covariance = solve(p, columns, y)
        b = columns.T @ p(y)
        falls.append(float(b @ covariance @ b))
    assert falls[0] == pytest.approx(falls[1], abs=0.01) and falls[1] < 10


def test_the_inverse_is_that_of_a_well_posed_fit():
    rng = np.random.default_rng(5)
    d = rng.normal(size=(50, 3)) * [1.0, 1e-4, 1e3]
    a = d.T @ d
    assert inverse(a, np.diag(a), 1e-12) == pytest.approx(np.linalg.inv(a), rel=1e-9)


@pytest.mark.parametrize(
    ("size", "slope", "difference", "holds"),
    [(6.7, 8.7, -4.2, True), (0.0, 10.0, 10.0, True), (0.1, 0.1, 20.0, False), (0.0, 10.0, 0.5, False)],
)
def test_friction_opposes_motion_in_both_directions(size, slope, difference, holds):
    """A lag of 10 and none is friction of one direction; a push along one of them is none; and alike it has another name."""
    assert (
        friction_asymmetry.sensible(
            size_um=size, slope_um=slope, difference_um=0.0, difference_slope_um=difference, tau_ms=0.0
        )
        is holds
    )
