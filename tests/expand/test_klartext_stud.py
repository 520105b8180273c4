"""Cycle 256 of Heidenhain Klartext by "Cycle run" of the TNC 640's Cycle Programming manual; every
figure by hand."""

from __future__ import annotations

import math
import random
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.test_klartext import TOLERANCE, places, plain

STUD = (
    "TOOL DEF 5 L+0 R+3|TOOL CALL 5 Z S1000 DR+1|L X+50 Y+20 Z+40 R0 F900 M3|CYCL DEF 256 STUD ~|"
    "Q218=+20 ~|Q424=+26 ~|Q219=+10 ~|Q425=+16 ~|Q220=+2 ~|Q368=+0 ~|Q224=+0 ~|Q367=+0 ~|"
    "Q207=+500 ~|Q351=+1 ~|Q201=-9 ~|Q202=+6 ~|Q206=+150 ~|Q200=+2 ~|Q203=+1 ~|Q204=+30 ~|"
    "Q370=+1 ~|Q437=+0|CYCL CALL|L X+90"
)


def from_stud(point, middle=(50.0, 20.0), sides=(10.0, 5.0), corner=2.0, turn=0.0) -> float:
    """How far outside of the stud a place lies."""
    x, y = point[0] - middle[0], point[1] - middle[1]
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    u, v = abs(x * c + y * s) - sides[0] + corner, abs(y * c - x * s) - sides[1] + corner
    inner = min(max(u, v), 0.0)
    return math.hypot(max(u, 0.0), max(v, 0.0)) + inner - corner


def cut(program: str, start=(50.0, 20.0, 40.0)) -> list[tuple[float, ...]]:
    """The places in the material."""
    return [p for p in places(plain(program), start) if p[2] < 1]


def test_the_heights_and_the_feeds():
    """Radius 4; the blank ends at 13, so the start lies at 50 + 13 + 2 + 4. Depths 6 and 9."""
    lines = plain(STUD)
    at = next(i for i, line in enumerate(lines) if line.startswith("L Z+31"))
    assert lines[at : at + 4] == [
        "L Z+31 FMAX", "L X+69 Y+20 FMAX", "L Z+3 FMAX", "L Z-5 F150",
    ]  # fmt: skip
    assert lines[at + 4].endswith("F500")
    assert [line for line in lines if line.startswith("L Z")][-2:] == ["L Z-8 F150", "L Z+31 FMAX"]
    assert lines[-1] == "L X+90 F900"
    assert lines[-3].startswith("L X+69 Y+20"), "back at the start before it is drawn out"


@pytest.mark.parametrize(("way", "turn"), [(1, 0), (-1, 0), (1, 30)])
def test_the_tool_touches_the_stud_all_around_and_never_enters_it(way, turn):
    """Climb milling with M3 goes with the clock; one whole turn at each depth."""
    program = STUD.replace("Q351=+1", f"Q351={way:+}").replace("Q224=+0", f"Q224={turn}")
    found = cut(program)
    away = [from_stud(p, turn=turn) for p in found]
    assert min(away) > 4 - TOLERANCE
    around = [p for p, d in zip(found, away, strict=True) if d < 4 + 1e-3 and p[2] == -8]
    angles = [math.atan2(p[1] - 20, p[0] - 50) for p in around]
    steps = [math.remainder(b - a, math.tau) for a, b in zip(angles, angles[1:], strict=False)]
    assert sum(steps) == pytest.approx(-way * math.tau, abs=1e-6)
    assert all(step * way < 1e-6 for step in steps)
    middles = [
        ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in zip(found, found[1:], strict=False)
    ]
    assert min(from_stud(p, turn=turn) for p in middles) > 4 - 1.01 * TOLERANCE


def test_it_is_joined_and_left_along_its_side():
    """The semicircles stand across 15 to 19 from the middle of the stud: their middle is 66.5."""
    found = [p for p in cut(STUD) if p[2] == -5]
    joined = [p for p in found if p[0] > 64.001]
    assert all(math.dist(p[:2], (66.5, 20)) == pytest.approx(2.5, abs=2e-3) for p in joined)
    assert joined[1][1] > 20 > joined[-2][1]


ROUND = (
    STUD.replace("256", "257")
    .replace("Q218=+20 ~|Q424=+26 ~|Q219=+10 ~|Q425=+16 ~|Q220=+2", "Q223=+20 ~|Q222=+44")
    .replace("Q367=+0 ~|", "Q376=+30 ~|")
)


@pytest.mark.parametrize(
    ("program", "stud_", "blank"),
    [
        (STUD.replace("Q424=+26", "Q424=+45"), ((10, 5), 2), (22.5, 8)),
        (STUD.replace("Q424=+26", "Q424=+31").replace("Q425=+16", "Q425=+38"), ((10, 5), 2), None),
        (ROUND, ((10, 10), 10), None),
        (ROUND.replace("Q370=+1", "Q370=+0.4"), ((10, 10), 10), None),
    ],
)
def test_a_wide_blank_takes_several_revolutions(program, stud_, blank):
    """By Q370 radii of 4 at most from one to the next; all of the blank beside the stud is cut, and
    nothing of the stud. By hand: 22.5 + 4 - 14 is 12.5, so four of 3.125."""
    sides, corner = stud_
    found = [p for p in cut(program) if p[2] == -8]
    away = [from_stud(p, sides=sides, corner=corner) for p in found]
    assert min(away) > 4 - TOLERANCE
    if blank:
        on_x = {round(p[0] - 50, 3) for p in found if abs(p[1] - 20) < 1e-6 and p[0] > 50}
        assert {14.0, 17.125, 20.25, 23.375} <= on_x
    reach = blank or ((15.5, 19) if corner == 2 else (22, 22))
    rng = random.Random(1)
    ends = np.array(found)[:, :2]
    share = np.linspace(0, 1, 21)[:, None, None]
    way = (ends[:-1] + np.diff(ends, axis=0) * share).reshape(-1, 2)
    for _ in range(400):
        place = tuple(m + rng.uniform(-r, r) for m, r in zip((50, 20), reach, strict=True))
        round_ = math.dist(place, (50, 20)) < 22 or corner == 2
        if round_ and from_stud(place, sides=sides, corner=corner) > 0.05:
            assert np.hypot(*(way - place).T).min() < 4.01


def test_a_corner_of_the_stud_at_the_place_of_the_call():
    """Q367 1: the tool stands over the lower left corner."""
    found = cut(STUD.replace("Q367=+0", "Q367=+1"))
    assert min(from_stud(p, (60.0, 25.0)) for p in found) == pytest.approx(4, abs=1e-3)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("TOOL DEF 5 L+0 R+3", "STOP", "not stated"),
        ("Q351=+1", "Q351=+0", "without Q351"),
        ("F900 M3", "F900 M4", "M3"),
        ("Q437=+0", "Q437=+2", "another approach"),
        ("Q367=+0", "Q367=+7", "with Q367 7"),
        ("Q424=+26", "Q424=+10", "do not fit"),
        ("Q201=-9", "Q201=+9", "depth below 0"),
        ("Q202=+6", "Q202=+0", "its plunges"),
    ],
)
def test_what_is_not_written_out_is_said(old, new, said):
    with pytest.raises(ProgramError, match=re.escape(said)):
        plain(STUD.replace(old, new))
