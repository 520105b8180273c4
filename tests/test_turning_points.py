"""Where an axis turns back inside an arc, and where its command passes nodes, by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.compensate import stretches
from postproc.compensate.arcs import turning_points

ROUNDING = 1e-5  # rad: 0.5 pm beside a quadrant of 10 mm, and 0.1 um along it


def turns(begin: float, sweep: float) -> list[float]:
    """t of the turning points of an arc of 10 mm about (3, 4)."""
    arcs = SimpleNamespace(
        first=np.array([0]), second=np.array([1]), centre=np.array([[3.0], [4.0]]),
        angle=np.array([begin]), sweep=np.array([sweep]),
        radius=np.array([10.0]), radius_end=np.array([10.0]),
    )  # fmt: skip
    start, target = (
        np.array([[3 + 10 * np.cos(a)], [4 + 10 * np.sin(a)]]) for a in (begin, begin + sweep)
    )
    arc, t = turning_points(cast(Any, arcs), start, target)
    assert (arc == 0).all()
    return t.tolist()


def test_an_arc_turns_back_at_its_quadrants():
    """From 45 degrees over 180: at 90 and at 180; with the clock at 0 and at -90."""
    assert turns(np.pi / 4, np.pi) == pytest.approx([0.25, 0.75])
    assert turns(np.pi / 4, -np.pi) == pytest.approx([0.25, 0.75])
    assert turns(0.1, 0.2) == []


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("quadrant", [0, 1, 2, 3])
def test_a_quadrant_that_rounding_missed_is_no_turn(sense, quadrant):
    """A quarter that ends 0.1 um behind its quadrant, or begins so before it: the axis that turns
    there does so by less than a pm; the other one goes on. By a tenth of a degree it is one."""
    at = quadrant * np.pi / 2
    assert turns(at - sense * np.pi / 2, sense * (np.pi / 2 + ROUNDING)) == []
    assert turns(at - sense * ROUNDING, sense * (np.pi / 2 + ROUNDING)) == []
    behind = turns(at - sense * np.pi / 4, sense * (np.pi / 4 + 2e-3))
    assert behind == pytest.approx([np.pi / 4 / (np.pi / 4 + 2e-3)])


def crossed(rise: float) -> list[tuple[int, float]]:
    """Row and t at which a quarter of 10 mm about zero, from X10 to Y10, with Z going up by `rise`,
    passes nodes at every 4 mm of X and of Z."""
    arcs = SimpleNamespace(
        first=np.array([0]), second=np.array([1]), centre=np.array([[0.0], [0.0]]),
        angle=np.array([0.0]), sweep=np.array([np.pi / 2]), radius=np.array([10.0]),
    )  # fmt: skip
    nodes = np.arange(-20.0, 21.0, 4.0)
    f = SimpleNamespace(
        arcs=arcs, plain=np.array([True]), followed=np.array([], int),
        machine=SimpleNamespace(
            letters="XYZ",
            bounds=SimpleNamespace(cells={"X": (nodes,), "Z": (nodes,)}),
        ),
        start=np.array([[10.0], [0.0], [0.0]]), target=np.array([[0.0], [10.0], [rise]]),
    )  # fmt: skip
    rows = SimpleNamespace(
        arc=np.array([0]), t0=np.array([0.0]), t1=np.array([1.0]),
        begin=np.zeros((3, 1)), end=np.zeros((3, 1)),
    )  # fmt: skip
    found = stretches._crossings(cast(Any, f), cast(Any, rows), np.zeros((2, 3, 1)))
    pairs = ((r.tolist(), t.tolist()) for r, t in found)
    return sorted((r, t) for rs, ts in pairs for r, t in zip(rs, ts, strict=True))


def test_nodes_of_the_plane_are_passed_on_the_circle_and_those_beside_it_in_step():
    """X passes 8 and 4 where the cosine is 0.8 and 0.4, and not where its chord does; Z passes 4
    and 8 at 40 and 80 % of the angle."""
    circle = [np.arccos(c) * 2 / np.pi for c in (0.8, 0.4)]
    assert [t for _, t in crossed(0.0)] == pytest.approx(circle)
    assert [t for _, t in crossed(10.0)] == pytest.approx(sorted([*circle, 0.4, 0.8]))
