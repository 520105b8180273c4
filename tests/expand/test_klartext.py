"""Heidenhain Klartext, run and written out: labels, Q parameters, arcs about a pole, drilling.

By hand from HEIDENHAIN's TNC 640 and iTNC 530 user's manuals: Klartext programming ("Path
contours", "Subprograms and program section repeats", "Q parameters") and cycle programming (200,
201, 203, 240).
"""

from __future__ import annotations

import math
import re

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


def plain(program: str, files: dict[str, str] | None = None) -> list[str]:
    """The statements between BEGIN and END."""
    text = "\n".join(["BEGIN PGM A MM", *program.split("|"), "END PGM A MM", ""]).encode()
    library = {name: t.replace("|", "\n").encode() for name, t in (files or {}).items()}
    written = Written(
        Program("a.h", text, library.get),
        Interpreter(dialects.load("heidenhain"), SETUP),
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
        ("L X+30 Y+25|CC X+25 Y+25|CP IPA-1800 IZ-5 DR-", (30, 25), (25, 25), -1800, -5),
        ("L X+3 Y+4|CC|L X+13|CC IX-10|CP IPA+90 DR+ Z-2", (13, 4), (3, 4), 90, -2),
    ],
)
def test_arcs(arc, start, centre, degrees, depth):
    """Every place on the circle, every chord within the tolerance, the whole turn, Z evenly."""
    found = places(plain(arc))
    points = found[found.index((*start, 0)) :]
    assert all(math.dist(p[:2], centre) == pytest.approx(math.dist(start, centre), abs=3e-4)
               for p in points)  # fmt: skip
    angles = [math.atan2(p[1] - centre[1], p[0] - centre[0]) for p in points]
    steps = [math.remainder(b - a, math.tau) for a, b in zip(angles, angles[1:], strict=False)]
    assert math.degrees(sum(steps)) == pytest.approx(degrees, abs=2e-3)
    radius = math.dist(start, centre)
    assert all(radius * (1 - math.cos(s / 2)) <= TOLERANCE * 1.01 for s in steps)
    for k, point in enumerate(points):
        assert point[2] == pytest.approx(depth * k / (len(points) - 1), abs=1e-4)


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
    ],
)  # fmt: skip
def test_formulas(formula, value):
    assert Formula(formula, {"1": 2.0}).value() == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("formula", ["1 +", "SQRT -1", "1 / 0", "Q9", "(1", "FOO 1", "(" * 99])
def test_what_is_no_formula_is_said(formula):
    with pytest.raises(FormulaError):
        Formula(formula, {}).value()


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


@pytest.mark.parametrize("cycle", ["206", "207", "209"])
@pytest.mark.parametrize("call", ["L X+10 FMAX M99", "L X+10 FMAX|CYCL CALL"])
def test_a_tap_stays_and_is_called_at_its_clearance(cycle, call):
    """Between places of the tool axis that are known: surface -1, clearances 2 and 50."""
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
        ("LBL 3|CALL LBL 3", "deep"),
        ("LBL 3|Q1 = 1|FN 9: IF +Q1 EQU +1 GOTO LBL 3", "1,000 statements"),
        ("CALL PGM TNC:\\X\\NONE", "no program NONE"),
        ("L X+10|C X-10 Y+0 DR+", "no pole"),
        ("CC X+0 Y+0|L X+10|C X-11 Y+0 DR+", "11.0000 from the pole"),
        ("CC X+0 Y+0|L X+10|C X-10 Y+0", "without DR"),
        ("CC X+0 Y+0|L X+10|C X-10 Y+0 Z+1 DR+", "Z in C"),
        ("CC X+0 Y+0|L X+10|CP IPA+90 DR-", "different signs"),
        ("CC X+0 Y+0|L X+10|CP PR+5 IPA+90 DR+", "PR in CP"),
        ("L X+10|CR X+50 R+2 DR+", "makes no arc"),
        ("L X+10|CT X+50", "CT"),
        ("L X+10 FMAX M99", "none is defined"),
        ("CYCL DEF 252 POCKET ~|  Q201=-5|L X+10 FMAX M99", "252 is called"),
        ("CYCL DEF 203 ~| Q200=+2 ~|Q201=-5 ~|Q206=+9 ~|Q203=+0 ~|Q213=+2|L X+1 M99", "Q213"),
        ("CYCL DEF 200 ~| Q201=-5|L X+10 FMAX M99", "without a number in Q200"),
        ("CYCL DEF 200 ~| Q200=+2 ~|Q201=+5 ~|Q206=+9 ~|Q203=+0|L X+1 M99", "Q201 above 0"),
    ],
)
def test_what_can_not_be_written_out_is_said(program, said):
    with pytest.raises(ProgramError, match=re.escape(said)):
        plain(program)
