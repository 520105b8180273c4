"""Cycles 8 and 10 of Heidenhain Klartext, written out: the places of a program within them are
those of the program without, turned and mirrored here by hand.

HEIDENHAIN TNC 640 and iTNC 530 user's manuals, cycle programming, "Mirroring", "Rotation".
"""

from __future__ import annotations

import math
import random

import pytest

from postproc.errors import ProgramError
from tests.expand.test_klartext import places, plain

HEAD = "TOOL CALL 1 Z S1000|L X+0 Y+0 Z+10 R0 FMAX M3|"
BODY = (
    "L X+20 Y+5 FMAX|L Z-2 F200|L X+30|L IY+12.5 F400|CC X+30 Y+20|C X+27.5 Y+20 DR-|L IX-3 IY-4|"
    "CYCL DEF 200 DRILL ~|Q200=+2 ~|Q201=-5 ~|Q206=+90 ~|Q202=+5 ~|Q203=+0 ~|Q204=+10|"
    "L X+40 Y+10 FMAX M99|L IX+8 FMAX M99|L X+5 Y+6 Z+10 FMAX"
)


def turned(point: tuple[float, ...], degrees: float) -> tuple[float, ...]:
    x, y, z = point
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return x * c - y * s, x * s + y * c, z


def assert_same(found: list[tuple[float, ...]], wanted: list[tuple[float, ...]]) -> None:
    assert len(found) == len(wanted)
    for a, b in zip(found, wanted, strict=True):
        assert a == pytest.approx(b, abs=2e-4)


@pytest.mark.parametrize("degrees", [90, -90, 180, 30, -7.25])
def test_places_are_turned_about_the_datum(degrees):
    """The arc of 2.5 is written as lines before it is turned: the same ones."""
    lines = plain(f"{HEAD}CYCL DEF 10.0 ROTATION|CYCL DEF 10.1 ROT{degrees:+}|{BODY}")
    without = places(plain(HEAD + BODY))
    assert "CYCL DEF 10.1 ROT+0" in lines
    kept = len(places(plain(HEAD)))
    wanted = without[:kept] + [turned(p, degrees) for p in without[kept:]]
    assert_same(places(lines), wanted)


def test_four_sides_of_a_plate_by_one_label():
    """By hand: the corner X-50 Y+30 takes the label as it is, X+50 Y+30 turned by -90 degrees."""
    program = (
        HEAD + "CYCL DEF 7.0 D|CYCL DEF 7.1 X-50|CYCL DEF 7.2 Y+30|CALL LBL 1|"
        "CYCL DEF 7.0 D|CYCL DEF 7.1 X+50|CYCL DEF 10.0 R|CYCL DEF 10.1 ROT-90|CALL LBL 1|"
        "CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+0|CYCL DEF 7.0 D|CYCL DEF 7.1 X+0|CYCL DEF 7.2 Y+0|"
        "L X+1|L M30|LBL 1|L X-12 Y+12 FMAX|L Z-3 F99|L X-1 Y-26 RL|L X+26 Y+1|L X-12 Y+12 R0|LBL 0"
    )
    lines = plain(program)
    at = lines.index("CYCL DEF 10.1 ROT+0")
    assert lines[at + 1 : at + 6] == [
        "L X+12 Y+12 FMAX", "L Z-3 F99", "L X-26 Y+1 RL", "L X+1 Y-26", "L X+12 Y+12 R0",
    ]  # fmt: skip
    assert "L X+1" in lines, "behind it lines stay as they are"


def test_angles_add_up():
    """The manual's example: a label that turns by IROT+45 each time, then ROT+0."""
    lines = plain(
        HEAD + "LBL 1|CYCL DEF 10.0 R|CYCL DEF 10.1 IROT+45|L X+10 Y+0 F99|CALL LBL 1 REP 2|"
        "CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+0"
    )
    found = [p[:2] for p in places(lines)[2:]]
    c = math.sqrt(50)
    assert found == [pytest.approx(p, abs=1e-4) for p in [(c, c), (0, 10), (-c, c)]]


@pytest.mark.parametrize(
    ("axes", "x", "y", "side"), [("X", -1, 1, "RR"), ("Y", 1, -1, "RR"), ("X Y", -1, -1, "RL")]
)
def test_a_mirror_of_one_axis_turns_the_sense_round(axes, x, y, side):
    lines = plain(
        f"{HEAD}CYCL DEF 8.0 MIRROR|CYCL DEF 8.1 {axes}|L X+5 Y+5 RL F99|L IX+2|L Y-7|L X+0 Y+0 R0|"
        "CYCL DEF 8.0 MIRROR|CYCL DEF 8.1|L X+3"
    )
    found = [p[:2] for p in places(lines)[2:]]
    assert found == [(5 * x, 5 * y), (7 * x, 5 * y), (7 * x, -7 * y), (0, 0), (3, 0)]
    assert [line.split()[3] for line in lines if line.startswith("L") and " R" in line][1] == side


def test_small_steps_do_not_drift():
    """1,000 distances of 0.01 under 30 degrees end where one of 10 does, to a least increment."""
    steps = "|".join(["L IX+0.01 F99"] * 500)
    lines = plain(HEAD + "CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+30|L X+0 Y+0 FMAX|" + steps)
    assert places(lines)[-1][:2] == pytest.approx(turned((5, 0, 0), 30)[:2], abs=1.01e-4)


@pytest.mark.parametrize("seed", range(20))
def test_random_lines(seed):
    """Absolute places and distances in any mixture."""
    rng = random.Random(seed)
    steps = ["L X+1 Y+1 F99"]
    for _ in range(30):
        words = [
            f"{rng.choice(['', 'I'])}{axis}{rng.uniform(-30, 30):+.3f}"
            for axis in "XYZ"
            if rng.random() < 0.6
        ]
        steps.append("L " + " ".join(words or ["X+5"]))
    degrees, body = rng.uniform(-180, 180), "|".join(steps)
    lines = plain(f"{HEAD}CYCL DEF 10.0 R|CYCL DEF 10.1 ROT{degrees:+.3f}|{body}")
    wanted = [turned(p, round(degrees, 3)) for p in places(plain(HEAD + body))[2:]]
    assert_same(places(lines)[2:], wanted)


def test_a_preset_ends_them():
    lines = plain(
        HEAD + "CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+90|L X+5 Y+0 F99|CYCL DEF 247 P ~|Q339=+1|"
        "L X+5 Y+2"
    )
    assert places(lines)[-1][:2] == (5, 2)


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+30|L X+5", "does not name X and Y"),
        ("CYCL DEF 10.0 R|CYCL DEF 10.1 ROT+30|L X+5 Y+1|CYCL DEF 7.1 X+5", "a datum shift within"),
        ("CYCL DEF 10.1 ROT+30|TRANS DATUM AXIS X+5", "a datum shift within"),
        ("CYCL DEF 10.1 ROT+30|CYCL DEF 8.1 X", "a mirror and a turn"),
        ("CYCL DEF 8.1 Z", "only X and Y"),
        ("CYCL DEF 10.1 ROT+30|L X+1 Y+1|APPR LT X+5 Y+5 LEN5 RL F99", "APPR within turned"),
    ],
)
def test_refused(program, said):
    with pytest.raises(ProgramError) as error:
        plain(HEAD + program)
    assert said in f"{error.value.message} {error.value.advice}"


SPACE = {"plane": (2.0, 2.0, 1.0), "space": (2.0, 2.0, 2.0)}


@pytest.mark.parametrize("how", SPACE)
def test_a_factor_of_cycle_11_by_hand(how):
    """Every place of the body twice as far from the datum; along Z as the machine is set."""
    body = "L X+1 Y+1 Z+8 FMAX|" + BODY  # an axis that is not named stays
    lines = plain(f"{HEAD}CYCL DEF 11.0 SCALING|CYCL DEF 11.1 SCL 2|{body}", scaling=how)
    without = places(plain(HEAD + body))
    assert "CYCL DEF 11.1 SCL 1" in lines
    kept = len(places(plain(HEAD)))
    wanted = [tuple(c * f for c, f in zip(p, SPACE[how], strict=True)) for p in without[kept:]]
    found = places(lines)[kept:]
    assert_same(found, wanted)


def test_a_factor_and_a_turn_by_hand():
    """X+10 twice as far, turned by 90 degrees, whichever is defined first."""
    turn, factor = "CYCL DEF 10.1 ROT+90|", "CYCL DEF 11.1 SCL 2|"
    for both in (turn + factor, factor + turn):
        lines = plain(f"{HEAD}{both}L X+10 Y+0 FMAX|L IX+1 IY+0", scaling="plane")
        assert places(lines)[-2:] == [(0.0, 20.0, 10.0), (0.0, 22.0, 10.0)]


def test_a_factor_per_axis_about_a_point_by_hand():
    """X = 15 + 1.4 (10 - 15) = 8, Y = 20 + 0.5 (40 - 20) = 30; then X by 1.4, alone."""
    lines = plain(
        f"{HEAD}CYCL DEF 26.0 AXIS-SPECIFIC SCALING|CYCL DEF 26.1 X1.4 Y0.5 CCX+15 CCY+20|"
        "L X+10 Y+40 F90|L IX+10|CYCL DEF 26.1 X1 Y1|L X+10 Y+40"
    )
    ways = [line for line in lines if line.startswith("L ")]
    assert places(ways)[-3:] == [(8.0, 30.0, 10.0), (22.0, 30.0, 10.0), (10.0, 40.0, 10.0)]


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("CYCL DEF 11.1 SCL 2", "--scaling plane"),
        ("CYCL DEF 11.1 SCL 0", "not above 0"),
        ("CYCL DEF 26.1 X20", "not above 0"),
        ("CYCL DEF 10.1 ROT+30|CYCL DEF 26.1 X2", "cycle 26 within"),
        ("CYCL DEF 26.1 X2|CYCL DEF 7.1 X+5", "a datum shift within"),
        # its diameter would be scaled on the control
        ("CYCL DEF 262 ~|Q200=2 ~|Q203=0 ~|Q204=5|CYCL DEF 26.1 X2|L X+1 M99", "cycle 262 in"),
        ("CYCL DEF 207 ~|Q200=2 ~|Q203=0 ~|Q204=5|CYCL DEF 26.1 Z2|L X+1 M99", "cycle 207 in"),
        # RL would be RR there, Q214 another direction
        ("CYCL DEF 202 ~|Q200=2 ~|Q203=0 ~|Q204=5|CYCL DEF 8.1 X|L X+1 M99", "cycle 202 in"),
    ],
)
def test_factors_that_are_refused(program, said):
    with pytest.raises(ProgramError) as error:
        plain(HEAD + program)
    assert said in f"{error.value.message} {error.value.advice}"
