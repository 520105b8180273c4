"""Heidenhain Klartext, run and written out: labels, Q parameters, arcs about a pole, drilling.

By hand from HEIDENHAIN's TNC 640 and iTNC 530 user's manuals: Klartext programming ("Path
contours", "Subprograms and program section repeats", "Q parameters") and cycle programming (200,
201, 203, 240).
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.klartext_formulas import Formula, FormulaError
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

TOLERANCE = 0.001
SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    offsets={"G54": {}},
    start=dict.fromkeys("XYZ", 0.0),
)


def plain(
    program: str, files: dict[str, str] | None = None, scaling: str = "", unit: str = "MM"
) -> list[str]:
    """The statements between BEGIN and END."""
    text = "\n".join([f"BEGIN PGM A {unit}", *program.split("|"), f"END PGM A {unit}", ""]).encode()
    library = {name: t.replace("|", "\n").encode() for name, t in (files or {}).items()}
    written = Written(
        Program("a.h", text, library.get),
        Interpreter(dialects.load("heidenhain"), replace(SETUP, scaling=scaling)),
        Limits(steps=1000, depth=8),
        tolerance=TOLERANCE,
    )
    return b"".join(written).decode().split("\n")[1:-2]


def places(lines: list[str], start=(0.0, 0.0, 0.0)) -> list[tuple[float, ...]]:
    here, found = dict(zip("XYZ", start, strict=True)), [start]
    for line in lines:
        for step, letter, value in re.findall(r"(I?)([XYZ])([-+]?[\d.]+)", line):
            here[letter] = float(value) + (here[letter] if step else 0.0)
        if re.search(r"[XYZ][-+]?\d", line):
            found.append(tuple(here.values()))
    return found


@pytest.mark.parametrize(
    ("arc", "start", "centre", "degrees", "depth"),
    [
        # the examples of the manual: C about CC, a full circle, CR of four kinds, CP
        ("L X+45 Y+25|CC X+25 Y+25|C X+45 Y+25 DR+", (45, 25), (25, 25), 360, 0),
        ("L X+0 Y+50|CC X+50 Y+50|C X+0 DR- F100", (0, 50), (50, 50), -360, 0),
        ("L X+40 Y+40|CR X+70 Y+40 R+20 DR-", (40, 40), (55, 40 - math.sqrt(175)), -97.180756, 0),
        ("L X+40 Y+40|CR X+70 Y+40 R+20 DR+", (40, 40), (55, 40 + math.sqrt(175)), 97.180756, 0),
        ("L X+40 Y+40|CR X+70 Y+40 R-20 DR-", (40, 40), (55, 40 + math.sqrt(175)), -262.819244, 0),
        ("L X+40 Y+40|CR X+70 Y+40 R-20 DR+", (40, 40), (55, 40 - math.sqrt(175)), 262.819244, 0),
        ("CC X+25 Y+25|LP PR+20 PA+0|CP PA+180 DR+", (45, 25), (25, 25), 180, 0),
        # to an angle the other way round, by the long way
        ("L X+25 Y+45|CC X+25 Y+25|CP PA+0 DR+", (25, 45), (25, 25), 270, 0),
        ("L X+25 Y+45|CC X+25 Y+25|CP PA+180 DR-", (25, 45), (25, 25), -270, 0),
        ("L X+30 Y+25|CC X+25 Y+25|CP IPA-1800 IZ-5 DR-", (30, 25), (25, 25), -1800, -5),
        ("L X+3 Y+4|CC|L X+13|CC IX-10|CP IPA+90 DR+ Z-2", (13, 4), (3, 4), 90, -2),
    ],
)
def test_arcs(arc, start, centre, degrees, depth):
    """Every place on the circle, every chord within the tolerance, the whole turn, all evenly."""
    found = places(plain(arc))
    points = found[found.index((*start, 0)) :]
    assert all(math.dist(p[:2], centre) == pytest.approx(math.dist(start, centre), abs=3e-4)
               for p in points)  # fmt: skip
    angles = [math.atan2(p[1] - centre[1], p[0] - centre[0]) for p in points]
    steps = [math.remainder(b - a, math.tau) for a, b in zip(angles, angles[1:], strict=False)]
    assert math.degrees(sum(steps)) == pytest.approx(degrees, abs=2e-3)
    assert steps == pytest.approx([steps[0]] * len(steps), abs=1e-4)
    radius = math.dist(start, centre)
    assert all(radius * (1 - math.cos(s / 2)) <= TOLERANCE * 1.01 for s in steps)
    for k, point in enumerate(points):
        assert point[2] == pytest.approx(depth * k / (len(points) - 1), abs=1e-4)


@pytest.mark.parametrize(
    ("before", "to", "centre", "degrees"),
    [
        # lines along X: a quarter to each side, half a circle, more than half
        ("L X+0 Y+0|L X+10", "X+15 Y+5", (10, 5), 90),
        ("L X+0 Y+0|L IX+10", "X+15 Y-5", (10, -5), -90),
        ("L X+0 Y+0|L X+10 Y+0", "IX+0 IY+8", (10, 4), 180),
        ("L X+0 Y+0|L X+10 Y+0", "X+6 Y+4", (10, 4), 270),
        # the manual: L X+0 Y+25, L X+25 Y+30, CT X+45 Y+20
        ("L X+0 Y+25|L X+25 Y+30", "X+45 Y+20", (28.571429, 12.142857), -75.749967),
        # along an arc, and along one another
        ("L X+10 Y+0|CC X+0 Y+0|C X+0 Y+10 DR+", "X-5 Y+5", (0, 5), 90),
        ("L X+0 Y+0|L X+10 Y+0|CT X+15 Y+5", "X+20 Y+10", (20, 5), -90),
        ("CC X+0 Y+0|L X+2 Y+0|LP PR+10 PA+0", "X+15 Y+5", (10, 5), 90),
    ],
)
def test_arcs_that_go_on(before, to, centre, degrees):
    lines = plain(f"{before}|M8|CT {to} F100 M9")
    begin = next(k for k, line in enumerate(lines) if "M8" in line)
    found = [p[:2] for p in places(lines[:begin])[-1:]]
    found += [p[:2] for p in places(lines[begin:], (*found[0], 0.0))[1:]]
    radius = math.dist(found[0], centre)
    assert all(math.dist(p, centre) == pytest.approx(radius, abs=3e-4) for p in found)
    angles = [math.atan2(p[1] - centre[1], p[0] - centre[0]) for p in found]
    steps = [math.remainder(b - a, math.tau) for a, b in zip(angles, angles[1:], strict=False)]
    assert math.degrees(sum(steps)) == pytest.approx(degrees, abs=5e-3)
    assert all(radius * (1 - math.cos(s / 2)) <= TOLERANCE * 1.01 for s in steps)


def test_words_of_an_arc_stay_with_it():
    lines = plain("CC X+0 Y+0|L X+10 Y+0 RL F300|C X-10 Y+0 DR+ F100 M9")
    assert lines[0] == "L X+10 Y+0 RL F300"
    assert lines[1].endswith(" F100")
    assert lines[-1].endswith(" M9")
    assert lines[-1].startswith("L X-10 Y+0")


@pytest.mark.parametrize(
    ("program", "steps"),
    [
        ("LBL 1|L IX+1|CALL LBL 1 REP 2|L IY+1", "XXXY"),
        ("CALL LBL 1|L IY+1|CALL LBL 1|L Z+5 M30|LBL 1|L IX+1|LBL 0", "XYXZ"),
        ('CALL LBL "A"|L Z+5 M2|LBL "A"|CALL LBL 2|L IX+1|LBL 0|LBL 2|L IY+1|LBL 0', "YXZ"),
        ("LBL 1|L IX+1|LBL 2|L IY+1|CALL LBL 2 REP 1/1|CALL LBL 1 REP 1", "XYYXYY"),
        ("Q1 = 0|LBL 1|L IX+1|FN 1: Q1 = +Q1 + +1|FN 12: IF +Q1 LT +3 GOTO LBL 1|L IY+1", "XXXY"),
        ("FN 0: Q1 = +2|FN 9: IF +Q1 EQU +2 GOTO LBL 9|L IX+1|LBL 9|L IY+1", "Y"),
        ("L IX+1|CALL PGM SUB|L IX+1", "XYX"),
    ],
)
def test_the_order_of_labels_and_jumps(program, steps):
    lines = plain(program, {"SUB.h": "0 BEGIN PGM SUB MM|1 L IY+1 M30|2 END PGM SUB MM"})
    moves = [m[1] for line in lines if (m := re.match(r"L I?([XYZ])", line))]
    assert "".join(moves) == steps


def test_parameters_become_numbers_and_stay_set():
    lines = plain("Q1 = 3 + 4 * 2|FN 0: QL2 =-5|L X+Q1 Y-Q1 ZQL2 FQ1|L IX-QL2 M3")
    assert lines == ["Q1 = 3 + 4 * 2", "FN 0: QL2 =-5", "L X+11 Y-11 Z-5 F11", "L IX+5 M3"]


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("+Q1 + -5", -3.0), ("+4 DIV +Q1", 2.0), ("3 * -2 ^ 2", 12.0), ("SQRT 16 + 1", 5.0),
        ("+3 LEN +4", 5.0), ("SIN 30", 0.5), ("COS(60) * (1 + 1)", 1.0), ("ATAN 1", 45.0),
        ("INT -2.7", -2.0), ("FRAC 2.75", 0.75), ("NEG ABS -3", -3.0), ("PI - PI", 0.0),
        ("-2^2", 4.0), ("2 ^ 3 ^ 2", 512.0), ("SQ 2 ^ 3", 64.0), ("2 ^ -1", 0.5), ("-(2^2)", -4.0),
        ("INT (SIN 30 * 2 + 0.0001)", 1.0), ("INT (0.1 * 30)", 3.0), ("INT -7", -7.0),
    ],
)  # fmt: skip
def test_formulas(formula, value):
    assert Formula(formula, {"1": 2.0}).value() == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    "formula", ["1 +", "SQRT -1", "1 / 0", "Q9", "(1", "FOO 1", "(" * 99, "-2 ^ 0.5"]
)
def test_what_is_no_formula_is_said(formula):
    with pytest.raises(FormulaError):
        Formula(formula, {}).value()


@pytest.mark.parametrize("formula", ["INT (SIN 30 * 2)", "FRAC (2.3 * 100)", "INT (0.3 / 0.1)"])
def test_what_rounding_decides_is_not_cut(formula):
    """TNC 640, "Programming notes": numbers are binary and have round-off errors, to be kept in
    mind; a whole number more or less is another path."""
    with pytest.raises(FormulaError, match="is one but for rounding"):
        Formula(formula, {}).value()


@pytest.mark.parametrize(("plane", "first", "second"), [("ZX", 2, 0), ("YZ", 1, 2), ("XY", 0, 1)])
def test_the_two_axes_of_the_pole_are_the_plane(plane, first, second):
    """From 10 along the first axis a quarter against the clock is 10 along the second one."""
    a, b = plane
    lines = plain(
        f"L {a}+13 {b}+4 F9|CC {a}+3 {b}+4|CP IPA+90 DR+|LP PR+5 PA+180|C {b}+9 {a}+3 DR+"
    )
    found = [(p[first], p[second]) for p in places(lines)]
    assert (3.0, 14.0) in found
    assert (-2.0, 4.0) in found
    assert found[-1] == (3.0, 9.0)
    assert all(round(math.dist(p, (3, 4)), 3) in (5, 10) for p in found[1:])


def test_an_arc_of_a_real_program_in_zx():
    """Autodesk's post leads in from the side: the line behind goes on where the arc ends."""
    lines = plain("L X+221 Y-25 Z+131 F9|CC X+213 Z+131|CP IPA+90 DR+ F1000|L X+209.01 Z+123")
    assert lines[-2] == "L X+213 Z+123"
    assert all("Y" not in line for line in lines[1:])


@pytest.mark.parametrize("to", [(30, 20), (12, 25), (0, 30), (35, -4), (55, 33)])
@pytest.mark.parametrize("corner", ["RND R2", "CHF 2"])
def test_corners(to, corner):
    """An arc that touches both lines, a chamfer that lies alike far from the corner on both."""
    lines = plain(f"L X+5 Y+0 F9|L X+40 Y+0 RL F500|{corner}|L X+{to[0]} Y{to[1]:+} M9")
    assert lines[-1] == f"L X+{to[0]} Y{to[1]:+} M9"
    assert lines[1].endswith("Y+0 RL F500")
    found = [complex(*p[:2]) for p in places(lines)][2:-1]
    direction = complex(to[0] - 40, to[1])
    direction /= abs(direction)
    first, last = found[0], found[-1]
    assert first.imag == 0
    assert abs(40 - first - abs(40 - first)) < 1e-3
    assert abs((last - 40) / direction - abs(last - 40)) < 1e-3
    assert abs(first - 40) == pytest.approx(abs(last - 40), abs=3e-4)
    if corner.startswith("CHF"):
        assert abs(first - 40) == pytest.approx(2, abs=1e-4)
        assert len(found) == 2
        return
    centre = first + math.copysign(2, to[1]) * 1j
    assert all(abs(p - centre) == pytest.approx(2, abs=3e-4) for p in found)
    assert abs(((last - centre) / direction).real) < 1e-3, "it touches"


def test_a_corner_that_is_none_and_corners_in_a_row():
    """Straight on; a square with three corners."""
    assert plain("L X+5 F9|RND R2|L X+9") == ["L X+5 Y+0 F9", "L X+9 Y+0"]
    square = "L X+20 F9|CHF 3 ; one|;|L IY+20|CHF 3|L IX-20|CHF 3|L IY-20"
    assert [p[:2] for p in places(plain(square))] == [
        (0, 0), (17, 0), (20, 3), (20, 17), (17, 20), (3, 20), (0, 17), (0, 0),
    ]  # fmt: skip


def test_a_comment_that_goes_on():
    lines = plain("7 ;  the table and Z on the~| Head|L X+1")
    assert lines == [";  the table and Z on the~", "; Head", "L X+1"]


BORE = (
    "TOOL DEF 5 L+0 R+3|TOOL CALL 5 Z S900 DR+1|L X+40 Y+25 Z+60 R0 FMAX M3|CYCL DEF 208 ~|"
    "  Q200=+2 ~|  Q201=-10 ~|  Q206=+90 ~|  Q334=+2.5 ~|  Q203=+1 ~|  Q204=+30 ~|"
    "  Q335=+20 ~|  Q342=+0 ~|  Q351={}|L X+50 IY-5 FMAX M99|L X+20 F300"
)


@pytest.mark.parametrize("way", [1, -1])
def test_bore_milling(way):
    """Radius 10 less 4; from 2 above the surface at 1 down to -9 in five turns of 2.4, one more at
    the bottom, back to the middle, out to the second clearance."""
    lines = plain(BORE.format(f"{way:+}"))
    found = places(lines)[1:]
    wall = [p for p in found if math.dist(p[:2], (50, 20)) > 1e-3 and p[2] < 60]
    wall = [p for p in wall if p[0] not in (20, 40)]
    assert all(math.dist(p[:2], (50, 20)) == pytest.approx(6, abs=2e-4) for p in wall)
    angles = [math.atan2(p[1] - 20, p[0] - 50) for p in wall]
    steps = [math.remainder(b - a, math.tau) for a, b in zip(angles, angles[1:], strict=False)]
    assert sum(steps) == pytest.approx(way * 6 * math.tau, abs=1e-3)
    assert all(6 * (1 - math.cos(s / 2)) <= TOLERANCE * 1.01 for s in steps)
    heights = [p[2] for p in wall]
    assert heights[0] == 3
    assert min(heights) == -9
    assert [h for h, s in zip(heights[1:], steps, strict=True)] == sorted(heights[1:], reverse=True)
    assert heights.count(-9) == len(steps) / 6 + 1
    assert lines[-4:] == ["L X+50 Y+20", "L Z+3 FMAX", "L Z+31 FMAX", "L X+20 F300"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("TOOL DEF 5 L+0 R+3", "STOP", "not stated"),
        ("Q335=+20", "Q335=+8", "8 wide, and the tool 8"),
        ("Q351=+1", "Q351=+0", "without Q351"),
        ("FMAX M3", "FMAX M4", "M3"),
        ("Q334=+2.5", "Q334=+0", "too many turns"),
        ("Q335=+20 ~|", "", "without a number in Q335"),
    ],
)
def test_bores_that_can_not_be_written_out(old, new, said):
    with pytest.raises(ProgramError, match=re.escape(said)):
        plain(BORE.format("+1").replace(old, new))


OLD = (
    "L X+5 Y+6 Z+3 F900|CYCL DEF 1.0 PECKING|CYCL DEF 1.1 SET UP 2|CYCL DEF 1.2 DEPTH {}|"
    "CYCL DEF 1.3 PECKG -6|CYCL DEF 1.4 DWELL {}|CYCL DEF 1.5 F100|L X+10 Z+2 FMAX M99|L X+20"
)


@pytest.mark.parametrize(
    ("depth", "dwell", "lines"),
    [
        # the surface lies 2 below the place of the call, at 0; 0.6 mm above what is drilled
        ("-10", "0", "Z-6 F100|Z+2 FMAX|Z-5.4 FMAX|Z-10 F100|Z+2 FMAX"),
        ("-3", "1", "Z-3 F100|DWELL 1|Z+2 FMAX"),
        # 40 mm deep: a fiftieth is 0.8
        ("-40", "0", "".join(f"Z-{d} F100|Z+2 FMAX|Z-{d - 0.8:g} FMAX|" for d in range(6, 40, 6))
         + "Z-40 F100|Z+2 FMAX"),
    ],
)  # fmt: skip
def test_pecking_of_old_controls(depth, dwell, lines):
    *found, last = drilled(plain(OLD.format(depth, dwell)))
    found = [x.removeprefix("L ").replace("CYCL DEF 9.1 ", "") for x in found if "9.0" not in x]
    assert found == lines.split("|")
    assert last == "L X+20 F900"


@pytest.mark.parametrize("cycle", ["2", "17"])
def test_an_old_tap_comes_back_to_where_it_is_called(cycle):
    program = f"L Z+3 F900|CYCL DEF {cycle}.0 TAP|CYCL DEF {cycle}.1 SET UP 2|L X+10 IZ-1 FMAX M99"
    assert drilled(plain(program)) == ["CYCL CALL", "L Z+2 FMAX"]


HOLE = "L X+5 Y+6 Z+60 F900|CYCL DEF 200 ~|Q200=+9 ~|Q201=-4 ~|Q206=+70 ~|Q203=+7 ~|Q204=+8|"
RING = (
    HOLE + "CYCL DEF 220 POLAR ~| Q216=+50 ~| Q217=-50 ~| Q244=+80 ~| Q245={} ~| Q246={} ~|"
    " Q247={} ~| Q241={} ~| Q200=+2 ~| Q203=+1 ~| Q204=+20 ~| Q301={}|L X+1"
)
GRID = (
    HOLE + "CYCL DEF 221 LINEAR ~| Q225=+15 ~| Q226=+10 ~| Q237=+10 ~| Q238=+8 ~| Q242=+3 ~|"
    " Q243=+2 ~| Q224={} ~| Q200=+2 ~| Q203=+1 ~| Q204=+20 ~| Q301=+1|L X+1"
)


@pytest.mark.parametrize(
    ("data", "angles"),
    [
        (("+0", "+360", "+0", "+8", "+1"), range(0, 360, 45)),
        (("+90", "+360", "+30", "+5", "+0"), range(90, 240, 30)),
        (("+10", "-350", "-0", "+3", "+0"), (10, -110, -230)),
        (("+90", "+0", "-45", "+3", "+1"), (90, 45, 0)),
    ],
)
def test_a_polar_pattern(data, angles):
    """The manual's examples: radius 40 about (50, -50)."""
    lines = plain(RING.format(*data))
    found = places(lines[lines.index("L Z+21 FMAX") :], (5, 6, 60))
    holes = [p for p in found if p[2] == -3]
    assert len(holes) == len(angles)
    for angle, hole in zip(angles, holes, strict=True):
        at = 50 + 40 * math.cos(math.radians(angle)), -50 + 40 * math.sin(math.radians(angle))
        assert hole[:2] == pytest.approx(at, abs=1e-4)
    between = {p[2] for a, p in zip(found[2:], found[3:], strict=False) if a[:2] != p[:2]}
    assert between == ({21} if data[-1] == "+1" else {21, 3})
    assert lines[-2:] == ["L Z+21 FMAX", "L X+1 F900"]
    assert "L Z-3 F70" in lines


def test_a_pattern_that_block_delete_takes_out():
    lines = plain(
        RING.format("+0", "+360", "+0", "+2", "+1").replace("CYCL DEF 220", "/ CYCL DEF 220")
    )
    made = lines[lines.index("/ L Z+21 FMAX") : -1]
    assert len(made) > 8
    assert all(line.startswith("/ L") for line in made)


@pytest.mark.parametrize(("turn", "unit"), [("+0", 1), ("+90", 1j)])
def test_a_linear_pattern(turn, unit):
    """Every second line backwards."""
    lines = plain(GRID.format(turn))
    holes = [p for p in places(lines[lines.index("L Z+21 FMAX") :]) if p[2] == -3]
    grid = [0, 10, 20, 20 + 8j, 10 + 8j, 8j]
    found = [complex(*p[:2]) for p in holes]
    assert found == pytest.approx([15 + 10j + unit * g for g in grid], abs=1e-4)


CYCLE = (
    "L X+5 Y+6 Z+60 FMAX|L Z+50 F900|CYCL DEF {} ~|  Q200=+2 ;CLEARANCE ~|  Q201={} ;DEPTH ~|"
    "  Q206=+250 ;FEED ~|  Q202=+6 ~|  Q210=+0 ~|  Q203=-1 ;SURFACE ~|  Q204={} ;SECOND ~|"
    "  Q211={} ~|  Q208=+80|L X+10 FMAX M99|L X+20"
)


def drilled(lines: list[str]) -> list[str]:
    return lines[next(k for k, x in enumerate(lines) if "X+10" in x) + 1 :]


@pytest.mark.parametrize(
    ("cycle", "lines"),
    [
        (
            ("200 DRILLING", "-15", "+50", "0.5"),
            "Z+1 FMAX|Z-7 F250|Z+1 FMAX|Z-5 FMAX|Z-13 F250|Z+1 FMAX|Z-11 FMAX|Z-16 F250|DWELL 0.5|"
            "Z+1 FMAX|Z+49 FMAX",
        ),
        (("200 DRILLING", "-5", "+0", "0"), "Z+1 FMAX|Z-6 F250|Z+1 FMAX"),
        (("201 REAMING", "-15", "+50", "0"), "Z+1 FMAX|Z-16 F250|Z+1 F80|Z+49 FMAX"),
        (
            ("203 UNIVERSAL", "-7", "+0", "0"),
            "Z+1 FMAX|Z-7 F250|Z+1 FMAX|Z-5 FMAX|Z-8 F250|Z+1 F80",
        ),
        (
            ("203 UNIVERSAL ~| Q213=+1 ~| Q256=+0.5", "-20", "+0", "0"),
            "Z+1 FMAX|Z-7 F250|Z-6.5 FMAX|Z-13 F250|Z+1 FMAX|Z-11 FMAX|Z-19 F250|Z-18.5 FMAX|"
            "Z-21 F250|Z+1 F80",
        ),
        (
            ("203 UNIVERSAL ~| Q212=+1 ~| Q205=+4.5", "-20", "+0", "0"),
            "Z+1 FMAX|Z-7 F250|Z+1 FMAX|Z-5 FMAX|Z-12 F250|Z+1 FMAX|Z-10 FMAX|Z-16.5 F250|"
            "Z+1 FMAX|Z-14.5 FMAX|Z-21 F250|Z+1 F80",
        ),
        (
            ("205 PECKING ~| Q258=+0.6 ~| Q259=+0.2 ~| Q257=+4 ~| Q256=+0.3", "-17", "+0", "0"),
            "Z+1 FMAX|Z-5 F250|Z-4.7 FMAX|Z-7 F250|Z+1 FMAX|Z-6.4 FMAX|Z-11 F250|Z-10.7 FMAX|"
            "Z-13 F250|Z+1 FMAX|Z-12.8 FMAX|Z-17 F250|Z-16.7 FMAX|Z-18 F250|Z+1 F80",
        ),
        (("240 CENTRING", "-7", "+0", "0"), "Z+1 FMAX|Z-8 F250|Z+1 FMAX"),
        (("200 DRILLING", "0", "+0", "0"), ""),
    ],
)
def test_drilling(cycle, lines):
    """And the program's own feed is in force again behind it."""
    *found, last = drilled(plain(CYCLE.format(*cycle)))
    found = [x.removeprefix("L ").replace("CYCL DEF 9.1 ", "") for x in found if "9.0" not in x]
    assert found == [x for x in lines.split("|") if x]
    assert last == ("L X+20 F900" if lines else "L X+20")


@pytest.mark.parametrize("cycle", ["202", "204", "206", "207", "209", "241", "262", "265", "267"])
@pytest.mark.parametrize("call", ["L X+10 FMAX M99", "L X+10 FMAX|CYCL CALL"])
def test_what_goes_by_the_spindle_stays_and_is_called_at_its_clearance(cycle, call):
    """TNC 640 user's manual, cycles: each begins at Q200 and ends at Q204 above Q203. Between
    places of the tool axis that are known: surface -1, clearances 2 and 50."""
    lines = plain(CYCLE.format(cycle, "-15", "+50", "0").replace("L X+10 FMAX M99", call))
    assert drilled(lines) == ["L Z+1 FMAX", "CYCL CALL", "L Z+49 FMAX", "L X+20"]


def test_a_cycle_is_called_by_itself_and_its_words_stay():
    lines = plain(CYCLE.format("200", "-5", "+0", "0").replace("FMAX M99", "FMAX|CYCL CALL M8"))
    assert drilled(lines)[:2] == ["M8", "L Z+1 FMAX"]


def test_increments_of_the_datum_add_up():
    lines = plain("CYCL DEF 7.1 X+5|CYCL DEF 7.1 IX+2|CYCL DEF 7.2 IY-1|L X+0")
    assert lines[:3] == ["CYCL DEF 7.1 X+5", "CYCL DEF 7.1 X+7", "CYCL DEF 7.2 Y-1"]


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("L X+Q7", "Q7 has no value"),
        ("Q7 = Q8|L X+Q7", "Q7 has no value"),
        ("FN 18: SYSREAD Q1 = ID270 NR1 IDX1|L X+Q1", "Q1 has no value"),
        ("FN 9: IF +Q1 EQU +2 GOTO LBL 9", "Q1 has no value"),
        ("Q1 = 0|FN 9: IF +Q1 EQU +0 GOTO LBL 9", "no LBL 9"),
        ("CALL LBL 3", "no LBL 3"),
        ("LBL 3|LBL 3", "LBL 3 stands twice"),
        ("LBL 3|CALL LBL 3", "nested in each other"),
        ("LBL 3|Q1 = 1|FN 9: IF +Q1 EQU +1 GOTO LBL 3", "more than 1,000 lines were executed"),
        ("CALL PGM TNC:\\X\\NONE", "no program NONE"),
        ("L X+10|C X-10 Y+0 DR+", "no pole"),
        ("CC X+0 Y+0|L X+10|C X-11 Y+0 DR+", "11.0000 from the pole"),
        ("CC X+0 Y+0|L X+10|C X-10 Y+0", "without DR"),
        ("CC X+0 Y+0|L X+10|C X-10 Y+0 Z+1 DR+", "Z in C"),
        ("CC X+0 Y+0|L X+10|CP IPA+90 DR-", "different signs"),
        ("CC X+0 Y+0|L X+10|CP PR+5 IPA+90 DR+", "PR in CP"),
        ("L X+10|CR X+50 R+2 DR+", "makes no arc"),
        ("L X+10|CT X+50", "not known"),
        ("L X+0 Y+0|L X+10 Y+0|L Z+0 FMAX M91|CT X+50 Y+9", "not known"),
        ("L X+0 Y+0|L X+10 Y+0|CYCL DEF 7.1 X+5|CT X+50 Y+9", "not known"),
        ("L X+0 Y+0|L X+10 Y+0|TRANS DATUM AXIS X+5|CT X+50 Y+9", "not known"),
        ("L X+0 Y+0|L X+10 Y+0|CT X+50", "straight on or back"),
        ("L X+0 Y+0|L X+10 Y+0|CT X+10", "ends where it begins"),
        ("L X+0 Y+0|L X+10 Y+0|CT X+12 Y+2 Z+1", "Z in CT"),
        ("L X+10 FMAX M99", "none is defined"),
        ("CYCL DEF 254 SLOT ~|  Q201=-5|L X+10 FMAX M99", "254 is called"),
        ("CYCL DEF 205 ~| Q200=+2 ~|Q201=-5 ~|Q206=+9 ~|Q203=+0 ~|Q379=+2|L X+1 M99", "Q379"),
        ("CC X+0 Y+0 Z+0|L X+1", "in no plane"),
        (
            "CYCL DEF 220 ~|Q216=+0 ~|Q217=+0 ~|Q244=+9 ~|Q245=+0 ~|Q246=+90 ~|Q247=+0 ~|Q241=+3 ~|"
            "Q200=+1 ~|Q203=+0",
            "on a part of a circle",
        ),
        (
            "CYCL DEF 220 ~|Q216=+0 ~|Q217=+0 ~|Q244=+9 ~|Q245=+0 ~|Q246=+360 ~|Q247=+0 ~|"
            "Q241=+3 ~|Q365=+1 ~|Q200=+1 ~|Q203=+0",
            "Q365",
        ),
        ("CYCL DEF 220 ~|Q241=+0 ~|Q200=+1 ~|Q203=+0", "0 points"),
        ("CYCL DEF 220|Q241=+0", "without its data"),
        ("CYCL DEF 1.0 A|CYCL DEF 1.1 2|CYCL DEF 220 ~|Q200=+1 ~|Q203=+0", "a pattern of cycle 1"),
        ("CYCL DEF 1.0 A|CYCL DEF 1.1 2|L X+1 M99", "cycle 1 without"),
        (
            "CYCL DEF 1.0 A|CYCL DEF 1.1 2|CYCL DEF 1.2 -5|CYCL DEF 1.3 .0001|CYCL DEF 1.5 F9|"
            "L X+1 M99",
            "too many pecks",
        ),
        ("CC Z+0|L X+1", "in no plane"),
        ("RND R5", "behind no straight line"),
        ("/ L X+10 F9|RND R5|L Y+10", "/ may take out"),
        ("L X+10 F9|/ RND R5|L Y+10", "/ may take out"),
        ("L X+10 F9|RND R5|/ L Y+10", "/ may take out"),
        ("L X+10 F9|RND R5|CR X+20 Y+0 R9 DR+", "beside something else"),
        ("L X+10 F9|RND R5|M9", "beside something else"),
        ("L X+10 F9|RND R5|PLANE RESET STAY", "beside something else"),
        ("L X+10 F9|RND R5", "beside something else"),
        ("L X+10 F9|RND R5 M8|L Y+10", "more than its size"),
        ("L X+10 F9|CHF 0|L Y+10", "no size"),
        ("L X+10 FMAX|CHF 2|L Y+10", "at FMAX"),
        ("L X+10 Z-1 F9|CHF 2|L Y+10", "leaves the plane"),
        ("L X+10 F9|CHF 2|L X+10 Y+0", "without length"),
        ("L X+10 F9|CHF 2|L X+5", "runs back"),
        ("L X+10 F9|CHF 11|L Y+20", "begins 11 before"),
        ("CYCL DEF 200 ~| Q201=-5|L X+10 FMAX M99", "without a number in Q200"),
        ("CYCL DEF 200 ~| Q200=+2 ~|Q201=+5 ~|Q206=+9 ~|Q203=+0|L X+1 M99", "Q201 above 0"),
    ],
)
def test_what_can_not_be_written_out_is_said(program, said):
    with pytest.raises(ProgramError, match=re.escape(said)):
        plain(program)


def test_a_contour_is_joined_along_the_tangent_of_its_arc():
    """APPR and DEP in polar coordinates become X and Y; the lines next to them lie on the tangents
    of the arc, and none leaves it by more than the tolerance."""
    lines = plain(
        "L X-40 Y+50|CC X+50 Y+50|APPR PLCT PR+50 PA+180 R5 RL F300|C X+0 Y+50 DR-|"
        "DEP PLCT PR+90 PA+180 R+5 F500|CC X+0 Y+0|C X-40 Y+50 DR+"
    )
    assert lines[1] == "APPR LCT X+0 Y+50 R5 RL F300"
    end = next(i for i, line in enumerate(lines) if line.startswith("DEP"))
    assert lines[end] == "DEP LCT X-40 Y+50 R+5 F500"
    found = places(lines[2:end], (0.0, 50.0, 0.0))
    assert [found[1][0], found[-2][0]] == [0, 0]
    assert found[1][1] - 50 == pytest.approx(math.sqrt(50 * TOLERANCE), abs=1e-4)
    assert found[-1][:2] == (0, 50)
    ways = [b for a, b in zip(found, found[1:], strict=False) if a != b]
    middles = [
        ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in zip(found, found[1:], strict=False)
    ]
    for place in (*ways, *middles):
        assert abs(math.dist(place[:2], (50, 50)) - 50) <= TOLERANCE * 1.01 + 1e-4
    behind = places(lines[end + 1 :], (-40.0, 50.0, 0.0))
    assert behind[1][0] != -40, "no tangent where no contour is joined"


def test_a_pole_is_needed_by_its_polar_approach():
    for text, said in (
        ("L X+1 Y+1|APPR PLT PR+5 PA+3 LEN5 RL", "no pole is set"),
        ("CC X+0 Y+0|APPR PLT PR+5 LEN5 RL", "without PR and PA"),
        ("CC X+0 Y+0|APPR PLT IPR+5 PA+1 LEN5 RL", "without PR and PA"),
    ):
        with pytest.raises(ProgramError, match=said):
            plain(text)


def test_a_corner_has_a_feed_of_its_own():
    """RND and CHF with F: it holds in the corner alone, the one before holds on behind it."""
    lines = plain("L X+10 F300|CHF 2 F99|L Y+10|L X+0|RND R1 F150|L Y+0")
    assert lines[:3] == ["L X+8 Y+0 F300", "L X+10 Y+2 F99", "L X+10 Y+10 F300"]
    assert lines[3] == "L X+1 Y+10"
    assert [line for line in lines[4:] if "F" in line] == [lines[4], lines[-1]]
    assert lines[4].endswith(" F150")
    assert lines[-1] == "L X+0 Y+0 F300"


def test_a_polar_place_does_not_ask_where_the_tool_comes_from():
    setup = Setup(axes=("X", "Y", "Z"), least_increment=dict.fromkeys("XYZ", 1e-4))
    text = b"CC X+50 Y+50\nLP PR+60 PA+180 R0 FMAX\nLP PA+90\n"
    interpreter = Interpreter(dialects.load("heidenhain"), setup)
    written = Written(Program("a.h", text), interpreter, Limits(9, 1), tolerance=TOLERANCE)
    assert b"".join(written) == b"L X-10 Y+50 R0 FMAX\nL X+50 Y+110\n"
    step = Written(Program("a.h", b"CC X+0 Y+0\nLP IPR+1 PA+0\n"), interpreter, Limits(9, 1))
    with pytest.raises(ProgramError, match="where X stands"):
        list(step)


def test_decimal_commas_are_points_and_those_of_names_and_remarks_stay():
    lines = plain('Q1 = 0,5 + 1|TOOL CALL "A1,5" Z S100|L X+1,5 Y+Q1 F90,5 ; 1,5|L IX+0,25')
    assert lines == ["Q1 = 0.5 + 1", 'TOOL CALL "A1,5" Z S100', "L X+1.5 Y+1.5 F90.5 ; 1,5",
                     "L IX+0.25"]  # fmt: skip


@pytest.mark.parametrize(("unit", "mm"), [("MM", 1.0), ("INCH", 25.4)])
def test_a_radius_may_be_too_short_by_as_much_in_inches(unit, mm):
    """The ends lie 1 apart: R 0.5 less 0.015 mm is taken as half of that, less 0.017 mm is not
    (0.016 mm, MP7431)."""
    program = "L X+0 Y+0 Z+1 R0 F100|CR X+1 Y+0 R+{:.6f} DR+"
    assert plain(program.format(0.5 - 0.015 / mm), unit=unit)
    for short in (0.017, 0.254):
        with pytest.raises(ProgramError, match="makes no arc to a place 1 away"):
            plain(program.format(0.5 - short / mm), unit=unit)
