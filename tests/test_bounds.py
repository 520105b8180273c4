"""Bounds of the deviation, by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.machine.bounds import Bounds


def test_a_table_of_two_axes_may_change_by_twice_its_size_and_a_line_counts_twice():
    """5 um and 10 urad in a table of two axes, whatever the way; a line that lies 12 um and 20 urad
    off."""
    machine = SimpleNamespace(
        every_table=[],
        grids_of={"X": [SimpleNamespace(sizes=np.array([0.003, 0.004, 0.0, 0.0, 0.0, 1e-5]))]},
        locations={"X": np.array([0.0, 0.0, 0.012, 0.0, 2e-5, 0.0])},
    )
    shift, lean, rise, turn = Bounds(cast(Any, machine))._sizes("X", np.array([0.0, 7.0]))
    assert (shift, lean) == pytest.approx((0.005 + 2 * 0.012, 1e-5 + 2 * 2e-5))
    assert rise == pytest.approx([0.01, 0.01]) and turn == pytest.approx([2e-5, 2e-5])


def test_what_a_slide_grows_by_is_turned_by_every_angle():
    """30 urad in all turn 10 um of X and what it grows by, 110 um/m over twice its 500 mm, and the
    arms: 530 mm at 10 urad, 40 mm at 20."""
    sizes = {"X": (0.01, 1e-5), "B": (0.0, 2e-5)}
    bounds = SimpleNamespace(
        machine=SimpleNamespace(
            chain=SimpleNamespace(axes=("X", "B")), expansions={"X": SimpleNamespace(rate=-1.1e-4)}
        ),
        _sizes=lambda x, way: (*sizes[x], way, way),
        _travel=lambda x: 500.0,
        reach=lambda x: {"X": 30.0, "B": 40.0}[x],
    )
    turned = 0.01 + 0.11 + 1e-5 * 530 + 2e-5 * 40
    assert Bounds.second_order.func(cast(Any, bounds)) == pytest.approx(3e-5 * turned)
