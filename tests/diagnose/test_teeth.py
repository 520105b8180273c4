"""Teeth behind turns: their length is found in what is left, by the way or time since then."""

import numpy as np
from pytest import approx

from postproc.diagnose import spectra


def left(length: float) -> tuple[np.ndarray, np.ndarray]:
    """Ways since turns (four times 12 mm) and what is left there: teeth of 2 um in noise of 0.3."""
    rng = np.random.default_rng(3)
    way = np.tile(np.arange(1500) * 0.008, 4)
    return way, 2.0 * ((way / length) % 1.0) + rng.normal(0, 0.3, len(way))


def test_the_length_of_teeth_is_found_between_the_lines_of_a_spectrum():
    for length in (0.107, 0.4321, 1.37):
        way, y = left(length)
        found = spectra.after_turns(way, (y - y.mean()) / 0.3**2, np.full(len(way), 1 / 0.3**2))
        assert found[0] == approx(length, rel=2e-3)


def test_teeth_the_other_way_up_are_no_teeth():
    """The slide waits and then jumps on; it does not jump back."""
    way, y = left(0.4321)
    power = np.full(len(way), 1 / 0.3**2)
    assert not any(
        abs(length / 0.4321 - 1) < 2e-3
        for length in spectra.after_turns(way, -(y - y.mean()) / 0.3**2, power)
    )


def test_too_few_rows_have_no_teeth():
    few = np.linspace(0.0, 1.0, 20)
    assert spectra.after_turns(few, few, few) == []
