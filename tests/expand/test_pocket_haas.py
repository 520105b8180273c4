"""G150 of Haas mills: golden lines of the manual's square pocket by hand, its pockets with islands,
and what any shape must fulfil: the tool keeps its distance from the wall and leaves nothing.

Haas Mill Operator's Manual (2017), "G150 General Purpose Pocket Milling": O61501 to O61509, in mm
here (25 times as large), so that the tool of 0.5 inch is one of 12.5 mm.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles import pocket_path
from postproc.nc.cycles.pocket_path import DoesNotFit, Piece
from postproc.nc.expand import Limits, Line, Program
from postproc.nc.expand.fanuc import lines as executed
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.campaigns import cases
from tests.expand.plain_lines import MILL, motions

HEAD = "G21|G90 G17 G54|G0 X0. Y37.5|Z25.|"
TAIL = "|G40 G1 X0. Y37.5|G0 Z25.|M30|"
CALL = "G150 P{} Z-2. Q2. R1. J{} K{} G41 D1 F100."
SQUARE = "G90 G1 Y62.5|X-62.5|Y-62.5|X62.5|Y62.5|X0."
INCREMENTAL = "G91 G1 Y25.|X-62.5|Y-125.|X125.|Y125.|X-62.5|G90"
# O61507 and O61509 of the manual
ISLAND = "G1 Y25.|X150.|Y150.|X25.|Y80.|X68.75|Y106.25|X106.25|Y68.75|X68.75|Y95.|X25.|Y25.|X50."
ROUND_ISLAND = (
    "G1 Y25.|X150.|Y150.|X25.|Y87.5|X62.5|G2 I25.|G2 X87.5 Y112.5 R25.|G1 Y150.|X25.|Y25.|X50."
)
SETUP = replace(
    MILL,
    offsets={**MILL.offsets, "G54": {}, "D1": {"R": 6.25}},
    start=dict.fromkeys("XYZ", 0.0),
)


def written(program: str, setup=SETUP) -> list[str]:
    """The plain lines of a program with | between its lines."""
    part = Program("part", program.replace("|", "\n").encode())
    tracker = Tracker(Interpreter(dialects.load("haas"), setup))
    resolver = Resolver(part, tracker)
    found = [one for line in executed(part, tracker, Limits()) for one in resolver.take(line)]
    return [line.text.decode() for line in found]


def part(shape: str, call: str, head: str = HEAD, tail: str = TAIL) -> str:
    return f"{head}{call}{tail}O7|{shape}|M99|"


def test_the_manuals_square_by_hand():
    """5 inch by 25: +-62.5, the centre 6.25 and 0.25 within: +-56. Strokes 12 apart, from the
    side where the shape begins; Z-1 and Z-2 from R1 by Q2; then the wall itself."""
    lines = written(part(SQUARE, CALL.format(7, 12.0, 0.25)))
    begin = lines.index("G0 Z1. F100.")
    assert lines[begin + 1 : begin + 8] == [
        "G1 Z-1.",
        "Y56.",
        "X-56.",
        "Y-56.",
        "X56.",
        "Y56.",
        "X0.",
    ]
    # strokes: Y-56 + 12 k, from Y52 down
    assert lines[begin + 8 : begin + 14] == ["X-56.", "Y52.", "X56.", "Y40.", "X-56.", "Y28."]
    depth = lines.index("Z-2.")
    assert lines[depth - 1] == "Y37.5" and lines[depth + 1 : depth + 3] == ["Y56.", "X-56."]
    last = lines.index("G41 D1 X0. Y62.5")
    assert lines[last - 1] == "Y37.5"
    assert lines[last + 1 : last + 6] == ["X-62.5", "Y-62.5", "X62.5", "Y62.5", "X0."]
    assert lines[last + 6 : last + 8] == ["G40 G1 X0. Y37.5", "G0 Z25."]


def test_the_shape_may_be_incremental_a_program_or_behind_an_n_number():
    """The manual's O61504 and O61505; P is an N number of the program first."""
    call = CALL.format(7, 12.0, 0.25)
    wanted = written(part(SQUARE, call))
    assert written(part(INCREMENTAL, call)) == wanted
    assert written(f"{HEAD}{call}{TAIL}N7 {SQUARE}|M99|") == wanted
    both = f"{HEAD}{call}{TAIL}N7 {SQUARE}|M99|O7|G1 Y40.|X9.|Y30.|X0.|Y40.|M99|"
    assert written(both) == wanted


def test_a_clockwise_shape_goes_with_g42():
    mirrored = SQUARE.replace("X-62.5", "X_").replace("X62.5", "X-62.5").replace("X_", "X62.5")
    call = CALL.format(7, 12.0, 0.25).replace("G41", "G42")
    lines = written(part(mirrored, call))
    assert "G42 D1 X0. Y62.5" in lines and "X56." in lines


# -- any shape -------------------------------------------------------------------------------------


def rounded(choose: random.Random) -> list[Piece]:
    """A counter-clockwise shape of lines with rounded corners, some of them re-entrant."""
    a, b = choose.uniform(60, 120), choose.uniform(60, 120)
    cut_x, cut_y = choose.uniform(0.3, 0.6) * a, choose.uniform(0.3, 0.6) * b
    corners = [(0, 0), (a, 0), (a, b - cut_y), (a - cut_x, b - cut_y), (a - cut_x, b), (0, b)]
    if choose.random() < 0.3:
        corners = [(0, 0), (a, 0), (a, b), (0, b)]
    r = choose.uniform(7, 12)
    pieces: list[Piece] = []
    n = len(corners)
    tangents = []
    for k, v in enumerate(corners):
        before, after = corners[k - 1], corners[(k + 1) % n]
        s = [(v[i] - before[i]) / math.dist(v, before) for i in (0, 1)]
        t = [(after[i] - v[i]) / math.dist(v, after) for i in (0, 1)]
        tangents.append((
            (v[0] - r * s[0], v[1] - r * s[1]),
            (v[0] + r * t[0], v[1] + r * t[1]),
            1 if s[0] * t[1] - s[1] * t[0] > 0 else -1,
            (v[0] - r * s[0] + r * t[0], v[1] - r * s[1] + r * t[1]),
        ))  # fmt: skip
    middle = tuple((tangents[0][1][i] + tangents[1][0][i]) / 2 for i in (0, 1))
    here = (middle[0], middle[1])
    first = here
    for k in [*range(1, n), 0]:
        one, other, turn, centre = tangents[k]
        pieces += [Piece(0, here, one), Piece(turn, one, other, centre)]
        here = other
    return [*pieces, Piece(0, here, first)]


def sampled(way: list[Piece]) -> np.ndarray:
    return np.array([p.at(s) for p in way for s in np.linspace(0.0, 1.0, 41)])


def away(pieces: list[Piece], places: np.ndarray) -> np.ndarray:
    """(N,) the distance of each of (N, 2) places from the next piece."""
    return np.min([pocket_path._distance(p, places) for p in pieces], axis=0)


@pytest.mark.parametrize("seed", range(cases(12, 60)))
def test_no_shape_is_left_standing_and_none_is_cut(seed):
    choose = random.Random(seed)
    shape, axis = rounded(choose), seed % 2
    distance, step = 6.5, choose.uniform(3.0, 12.0)
    contour = pocket_path.beside(shape, distance, 1)
    way = contour + pocket_path.clearing(contour, axis, step)
    for a, b in zip(way, way[1:], strict=False):  # one way, without a gap
        assert math.dist(a.end, b.start) < 1e-6
    assert math.dist(way[-1].end, contour[0].start) < 1e-6
    places = sampled(way)
    assert pocket_path.nearest(shape, places) > distance - 1e-5
    low, high = places.min(axis=0), places.max(axis=0)
    grid = np.array([(x, y) for x in np.linspace(low[0], high[0], 25)
                     for y in np.linspace(low[1], high[1], 25)])  # fmt: skip
    grid = grid[away(shape, grid) > distance]
    free = np.array([pocket_path._around(shape, (x, y)) == 1 for x, y in grid])
    assert free.sum() > 50
    assert away(way, grid[free]).max() <= step / 2 + 1e-6


def path(lines: list[str]) -> np.ndarray:
    """(N, 2) places of the feeds at the bottom before the finish pass, as our interpreter reads
    them."""
    finish = next(k for k, line in enumerate(lines) if "G41" in line)
    program = [Line(line.encode(), k) for k, line in enumerate(lines[:finish])]
    pieces = [
        Piece(
            0 if m["kind"] == "feed" else int(np.sign(m["sweep"])),
            (m["start"][0], m["start"][1]),
            (m["end"][0], m["end"][1]),
            m.get("centre", (0.0, 0.0)),
        )
        for m in motions(program, "haas", SETUP)
        if m["kind"] != "rapid" and m["end"][2] == -2.0 and m["start"][2] == -2.0
    ]
    return sampled(pieces)


@pytest.mark.parametrize("shape", [ISLAND, ROUND_ISLAND])
@pytest.mark.parametrize("step", ["J7.5", "I7.5"])
def test_the_manuals_islands_stay(shape, step):
    """The pocket is 25 to 150 along X and Y; an island, 37.5 wide, or round, 25 the radius, stands
    in its middle, joined to the wall by what the shape crosses twice. The tool's centre stays 6.5
    away from both, and comes within half a step of every other place that it may reach."""
    call = CALL.format(7, 7.5, 0.25).replace("J7.5", step)
    head, tail = HEAD.replace("X0. Y37.5", "X50. Y50."), TAIL.replace("X0. Y37.5", "X50. Y50.")
    places = path(written(part(shape, call, head, tail)))
    away = np.abs(places - 87.5)
    if shape == ISLAND:
        island = np.hypot(*np.maximum(away - 18.75, 0.0).T)
    else:
        island = np.hypot(*away.T) - 25.0
    assert island.min() > 6.5 - 1e-3
    assert places.min() > 31.5 - 1e-3 and places.max() < 143.5 + 1e-3
    for place in [(35.0, 35.0), (140.0, 140.0), (120.0, 60.0), (60.0, 130.0), (87.5, 40.0)]:
        assert np.hypot(*(places - place).T).min() < 7.5


@pytest.mark.parametrize("distance", [13.0, 30.0])
def test_a_tool_that_does_not_fit_is_reported(distance):
    with pytest.raises(DoesNotFit):
        pocket_path.beside(rounded(random.Random(1)), distance, 1)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("J12.0", ""), "neither I nor J"),
        (("J12.0", "I9. J12.0"), "with I and J"),
        (("J12.0", "J13."), "the tool is 12.5 wide"),
        (("G41", ""), "without G41 or G42"),
        (("G41", "G42"), "outside of its shape"),
        (("Q2.", ""), "without Q"),
        (("R1.", ""), "without R"),
        (("Q2.", "Q0."), "by Q0"),
        (("Z-2.", "Z2."), "from R1 to Z2"),
        (("D1", ""), "has no radius"),
        (("D1", "D9"), "D9 of G150 is not stated"),
        (("P7", "P8"), "there is no N8 and no program O8"),
        (("P7", ""), "without P"),
        (("K0.25", "K60."), "does not reach"),
        (("G150", "G91 G150"), "G150 in G91"),
        (("G150", "G18 G150"), "outside the XY plane"),
        (("G150", "G41 D1 X1.|G150"), "with cutter radius compensation on"),
        (("|X0.|M99", "|X5.|M99"), "is not closed"),
        (("|X0.|M99", "|X0.|G91|M99"), "leaves G91 in force"),
        (("X-62.5|", "X#1|"), "can not be followed"),
        (("X-62.5|", "X-62.5 F9.|"), "can not be followed"),
        (("X-62.5|", "G3 X-62.5 I9.|G1|"), "misses its own end"),
        (("G90 G1 Y62.5|", "G90 G1 X-62.5 Y62.5|"), "is not closed"),
        (("X-62.5|Y-62.5", "X-62.5|" + "Y1.|Y0.|" * 20 + "Y-62.5"), "motions in the shape"),
    ],
)  # fmt: skip
def test_what_the_manual_leaves_open_is_refused(change, said):
    program = part(SQUARE, CALL.format(7, 12.0, 0.25))
    assert change[0] in program
    with pytest.raises(ProgramError, match=said):
        written(program.replace(*change))


def test_a_shape_that_begins_in_a_corner_is_refused():
    corner = "G1 X62.5 Y62.5|X-62.5|Y-62.5|X62.5|Y62.5"
    with pytest.raises(ProgramError, match="begins in a corner"):
        written(part(corner, CALL.format(7, 12.0, 0.25)))


def test_the_ends_of_an_element_divide_it_nowhere():
    """Of a line and of a quarter circle: a place between its ends has a share, an end has none."""
    line = Piece(0, (0.0, 0.0), (10.0, 0.0))
    quarter = Piece(1, (5.0, 0.0), (0.0, 5.0), (0.0, 0.0))
    assert [line.share_of(p) for p in ((0.0, 0.0), (10.0, 0.0), (4.0, 1.0))] == [None] * 3
    assert line.share_of((4.0, 0.0)) == pytest.approx(0.4)
    assert [quarter.share_of(p) for p in ((5.0, 0.0), (0.0, 5.0), (3.0, 3.0))] == [None] * 3
    assert quarter.share_of((5 * math.sqrt(0.5), 5 * math.sqrt(0.5))) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("centre", "radius", "met"),
    [
        (3.0, 2.0, [(5.0, 0.0)]),  # touches from within
        (7.0, 2.0, [(5.0, 0.0)]),  # and from outside
        (2.0, 2.0, []),
        (8.0, 2.0, []),
        (6.0, 5.0, [(3.0, 4.0), (3.0, -4.0)]),
        (0.0, 5.0, []),  # the same circle
    ],
)
def test_where_two_circles_meet_by_hand(centre, radius, met):
    """One of radius 5 about the zero, the other about a place on X."""
    one = Piece(1, (5.0, 0.0), (-5.0, 0.0), (0.0, 0.0))
    other = Piece(1, (centre + radius, 0.0), (centre - radius, 0.0), (centre, 0.0))
    found = {(round(x, 9), round(y, 9)) for x, y in pocket_path._circles(one, other)}
    assert found == {(x, y + 0.0) for x, y in met}


def test_an_arc_in_inches_that_misses_its_end_by_20_micrometres_is_refused():
    """0.0008 inch; the control takes 0.01 mm."""
    shape = "G1 Y2.5|X-2.|G3 X-2.5{} Y2. J-.5|G1 Y-2.5|X2.5|Y2.5|X0."
    head = HEAD.replace("G21", "G20").replace("37.5", "1.5").replace("25.", "1.")
    call = CALL.format(7, ".4", ".01").replace("R1.", "R.1").replace("-2. Q2.", "-.1 Q.2")
    assert written(part(shape.format(""), call, head))
    with pytest.raises(ProgramError, match="misses its own end"):
        written(part(shape.format("008"), call, head))


@pytest.mark.parametrize(
    ("before", "place"),
    [
        ("G10 L12 P1 R4.|", {"R": 6.25}),  # neither what is stated nor twice that
        ("", {"Z": 6.25}),
    ],
)
@pytest.mark.parametrize("call", ["G12 I20. D1 F100.", "G13 I20. D1 F100."])
def test_a_circle_with_a_radius_that_is_not_known_is_refused(before, place, call):
    """The radius that G10 writes holds from there on, and no other number is taken for it."""
    setup = replace(SETUP, offsets={**SETUP.offsets, "D1": place})
    known = replace(SETUP, offsets={**SETUP.offsets, "D1": {"R": 4.0}})
    program = f"{HEAD}{{}}Z-2.|{call}|M30"
    assert len(written(program.format("G10 L12 P1 R4.|"), known)) > 5
    with pytest.raises(ProgramError, match="radius D1 of G1. is not stated"):
        written(program.format(before), setup)
