"""Stick-slip against a friction that comes again: the likelihood of the whole fit decides."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.diagnose.restless import misfit

N = 400
RNG = np.random.default_rng(6)
NOISE = np.full(N, 1e-4)
SLOW = np.arange(N) % 8 == 0


@pytest.mark.parametrize("alike", [1.0, 2.0])
def test_a_spread_that_nobody_can_foretell_is_paid_for_and_a_curve_that_fits_is_not(alike):
    """A hold of 3 um that comes at random is no curve: half of it is left by the best one. A spike that comes again the same is one:
    then room for a spread of 3 um in every slow row costs more than it gains."""
    inflated = NOISE * alike
    room = np.where(SLOW, 3e-3 * alike, inflated)
    quiet = RNG.normal(0, 1, N) * NOISE
    held = quiet + SLOW * RNG.normal(0, 3e-3, N)
    ones = np.full(N, alike)
    assert misfit(held, room, ones) < misfit(held / 2, inflated, ones)
    assert misfit(quiet, inflated, ones) < misfit(quiet, room, ones)


def test_it_is_minus_twice_the_logarithm_of_a_normal_density():
    left, sigma = RNG.normal(size=5), np.array([0.5, 1.0, 2.0, 3.0, 0.1])
    density = np.exp(-((left / sigma) ** 2) / 2) / sigma  # but for a factor that is the same for all
    assert misfit(left, sigma, np.ones(5)) == pytest.approx(-2 * float(np.sum(np.log(density))))
