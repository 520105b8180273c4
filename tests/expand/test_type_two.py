"""Type II of G71 and G72: the tool never cuts into the shape, no rapid goes through stock, and what
stays before the cut along the shape is less than one cut."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from itertools import pairwise

import pytest

from postproc.errors import ProgramError
from postproc.nc.cycles.pockets_fanuc import TypeTwo, quarters
from postproc.nc.cycles.profile import Element
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER
from tests.expand.plain_lines import LATHE, text_of

DEPTH, ESCAPE = 2.0, 0.5


def line(a, b, code=10):
    return Element(code, a, b)


def arc(a, b, centre, code):
    return Element(code, a, b, (), centre)


def height(pieces, z):
    """The least x radius that the tool may go to at z: the shape's own."""
    found = []
    for e in pieces:
        low, high = sorted((e.start[0], e.end[0]))
        if low - 1e-9 <= z <= high + 1e-9:
            if abs(e.start[0] - e.end[0]) < 1e-9:
                found += [e.start[1], e.end[1]]
            else:
                found.append(e.crossing(0, z) if not e.is_arc else _on_arc(e, z))
    return min(found)


def _on_arc(e, z):
    radius = math.dist(e.start, e.centre)
    rise = math.sqrt(max(radius**2 - (z - e.centre[0]) ** 2, 0))
    low, high = sorted((e.start[1], e.end[1]))
    return min((e.centre[1] + s * rise for s in (1, -1)), key=lambda x: max(low - x, x - high, 0))


def points(a, b, centre, code):
    if centre is None:
        return [(a[0] + (b[0] - a[0]) * k / 20, a[1] + (b[1] - a[1]) * k / 20) for k in range(21)]
    first = math.atan2(a[1] - centre[1], a[0] - centre[0])
    sign = 1 if code == "G3" else -1
    sweep = sign * (math.atan2(b[1] - centre[1], b[0] - centre[0]) - first) % math.tau
    radius = math.dist(a, centre)
    turns = [first + sign * sweep * k / 20 for k in range(21)]
    return [(centre[0] + radius * math.cos(t), centre[1] + radius * math.sin(t)) for t in turns]


def cut(pieces, steps, begin, top):
    """What is left of a stock of radius `top` over each place, in 0.05: no rapid within it, and no
    motion below the shape."""
    grid = [-k * 0.05 - 0.013 for k in range(int(-pieces[-1].end[0] / 0.05) - 1)]
    stock = dict.fromkeys(grid, top)
    floor = {z: height(pieces[1:], z) for z in grid}
    at = begin
    for step in steps:
        code = step.code or "G0"
        way = points(at, step.end, step.centre, code)
        for a, b in pairwise(way):
            low, high = sorted((a[0], b[0]))
            for z in grid:
                if not low <= z <= high:
                    continue
                share = 0.5 if high - low < 1e-12 else (z - a[0]) / (b[0] - a[0])
                x = a[1] + share * (b[1] - a[1])
                assert x >= floor[z] - 1e-3, (step, z, x, floor[z])
                if code == "G0":
                    assert x >= stock[z] - 1e-3, (step, z, x, stock[z])
                else:
                    stock[z] = min(stock[z], x)
        at = step.end
    return max(stock[z] - max(floor[z], 0) for z in grid if floor[z] < top)


def roughed(pieces, top):
    whole = [pieces[0], *(p for e in pieces[1:] for p in quarters(e))]
    steps = TypeTwo(whole, 1, -1, top, DEPTH, ESCAPE).way((2.0, top))
    return cut(whole, steps, (2.0, top), top)


def shape(*places, top=50.0):
    pieces = [line((2.0, top), places[0], 0)]
    for place in places[1:]:
        pieces.append(line(pieces[-1].end, place))
    return pieces


@pytest.mark.parametrize(
    "pieces",
    [
        shape((2, 40), (-10, 40), (-15, 20), (-30, 20), (-30, 45), (-50, 48)),
        shape((2, 45), (0, 45), (0, 30), (-20, 30), (-20, 45), (-30, 45), (-35, 25), (-45, 49)),
        shape((2, 20), (-10, 20), (-10, 35), (-20, 24), (-30, 44), (-35, 30), (-40, 30), (-40, 50)),
        shape((2, 31), (-9, 31), (-12, 30), (-18, 30), (-18, 31), (-22, 31), (-22, 28), (-30, 50)),
        [
            line((2.0, 50.0), (2.0, 40.0), 0), line((2.0, 40.0), (-10.0, 40.0)),
            arc((-10.0, 40.0), (-30.0, 40.0), (-20.0, 40.0 + 5.0), CLOCKWISE),
            line((-30.0, 40.0), (-40.0, 50.0)),
        ],
    ],
)  # fmt: skip
def test_pockets_are_roughed_to_less_than_a_cut(pieces):
    assert roughed(pieces, 50.0) < DEPTH * 1.5


def test_random_shapes():
    pick = random.Random(5)
    for _ in range(40):
        z, places = 0.0, [(2.0, pick.uniform(10, 48))]
        places.append((0.0, places[0][1]))
        for _ in range(pick.randint(2, 9)):
            z -= pick.choice([0.0, pick.uniform(1, 12)])
            places.append((z, pick.uniform(10, 49)))
        if z < 0:
            roughed(shape(*places), 50.0)


def test_an_arc_is_cut_where_it_turns_back():
    half = arc((0.0, 20.0), (-20.0, 20.0), (-10.0, 20.0), COUNTER)
    parts = quarters(half)
    assert [p.end for p in parts] == [pytest.approx((-10.0, 30.0)), pytest.approx((-20.0, 20.0))]
    bulge = arc((0.0, 20.0), (0.0, 40.0), (0.0, 30.0), COUNTER)
    assert [p.end for p in quarters(bulge)] == [
        pytest.approx((10.0, 30.0)), pytest.approx((0.0, 40.0))
    ]  # fmt: skip


def test_a_trough_by_hand():
    """Cuts at X36, 32 and 28, a trough to X26 whose walls stand at Z-5 and Z-10."""
    program = (
        "G0 X40. Z2.|G71 U2. R1.|G71 P10 Q20 F.2|N10 G0 X36. Z2.|G1 Z-5.|X26.|Z-10.|X36.|N20 Z-12."
    )
    # Each cut: in along the wall, along Z, out along the wall to the cut before, an escape more.
    assert text_of(program, "fanuc-lathe-a", LATHE) == [
        "G0 X40. Z2.",
        *["G0 Z-5. F.2", "G1 X36.", "Z-10.", "Z-12.", "G0 X40.", "Z-5."],
        *["G1 X36.", "X32.", "Z-10.", "X36.", "G0 X38.", "Z-5."],
        *["G1 X32.", "X28.", "Z-10.", "X32.", "G0 X34.", "X40.", "Z2."],
        *["X36.", "G1 Z-5.", "X26.", "Z-10.", "X36.", "Z-12.", "G0 X40. Z2."],
    ]


def test_a_place_without_a_point_is_named_where_it_made_the_shape_small():
    """X40 counts 0.04 mm where lengths without a point count least increments: X turns back."""
    setup = replace(LATHE, integers="least increments")
    before = "G18 G0 X60. Z2.|G71 U2. R1.|G71 P1 Q2 F.2|N1 G0 X20.|G1 Z-5.|"
    with pytest.raises(ProgramError, match="goes deeper in X|X turns back") as caught:
        text_of(f"{before}X40 Z-9.|N2 X58.", "fanuc-lathe-a", setup)
    assert caught.value.advice.startswith("X40 has no decimal point")
    assert text_of(f"{before}X40. Z-9.|N2 X58.", "fanuc-lathe-a", setup)
    with pytest.raises(ProgramError, match="X turns back") as caught:
        text_of(f"{before}X10. Z-9.|N2 X58.", "fanuc-lathe-a", setup)
    assert "decimal point" not in caught.value.advice


def test_the_number_of_a_haas_shape_may_stand_alone():
    """N3 in a block before the one that names X and Z chooses type II as well."""
    shape = "|Z-20.|X36. Z-30.|Z-40.|N4 X60."
    own, one = (
        text_of(f"G0 X60. Z2.|G71 P3 Q4 D2. U.5 F.2|{first}{shape}", "haas-lathe", LATHE)
        for first in ("N3|G1 X40. W0", "N3 G1 X40. W0")
    )
    assert own == one and len(own) > 20
    with pytest.raises(ProgramError, match="turns back"):
        text_of(f"G0 X60. Z2.|G71 P3 Q4 D2. U.5 F.2|N3|G1 X40.{shape}", "haas-lathe", LATHE)


def test_a_cycle_asks_for_both_places_that_it_needs():
    """One of them alone led to a sentence on an offset that nobody has left out."""
    lost = replace(LATHE, start={})
    program = "G50 X44. Z2.|G71 U1.5 R1.|G71 P10 Q60 U1. W.5|N10 G0 X10.|N60 G1 Z-10. F.2"
    with pytest.raises(ProgramError) as caught:
        text_of(program, "fanuc-lathe-a", lost)
    assert caught.value.advice.endswith("--start X0,Z0")
