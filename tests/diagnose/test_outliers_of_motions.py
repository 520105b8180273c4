"""One wrong reading in a passage that was measured once is found with its size; bends and noise are
none."""

from __future__ import annotations

import numpy as np
from pytest import approx

from postproc.diagnose import outliers

PLACE = np.arange(18) * 10.0


def largest(value: np.ndarray, sigma: float) -> tuple[int, float, float]:
    times, size = outliers.departures(PLACE, value, np.full(len(value), sigma))
    worst = int(np.abs(times).argmax())
    return worst, abs(float(times[worst])), float(size[worst])


def test_a_slip_on_a_curve_is_found_with_its_size():
    curve = 5 * np.sin(PLACE / 40) + np.random.default_rng(2).normal(0, 0.1, 18)
    curve[7] += 2.0
    worst, times, size = largest(curve, 0.1)
    assert worst == 7 and times > outliers.DROPPED and size == approx(2.0, abs=0.4)


def test_a_kink_and_a_step_are_no_slips():
    noise = np.random.default_rng(3).normal(0, 0.1, 18)
    for shape in (
        np.maximum(0, PLACE - 120),
        20.0 * (PLACE > 85),
        np.where(PLACE > 135, 0.02 * (PLACE - 135) ** 2, 0),
    ):
        assert largest(shape + noise, 0.1)[1] < outliers.DROPPED


def test_noise_is_seldom_called_a_slip():
    rng = np.random.default_rng(4)
    called = sum(largest(rng.normal(size=18), 1.0)[1] >= outliers.DROPPED for _ in range(1000))
    assert called <= 10


def test_too_few_places_say_nothing():
    assert not np.any(
        outliers.departures(PLACE[:6], np.array([0, 0, 9, 0, 0, 0.0]), np.full(6, 0.1))[0]
    )
