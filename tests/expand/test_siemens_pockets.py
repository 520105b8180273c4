"""POCKET3 and POCKET4 of Sinumerik: wall, bottom, depths and sense by the Programming Guide Cycles,
measured on the lines by another arithmetic: no place nearer to the wall than the tool's radius, and
nothing inside that the tool has not passed."""

from __future__ import annotations

import math
import random
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup
from tests.expand.pocket_judge import assert_cleared, from_wall

RADIUS = 5.0
RECTANGLE = "POCKET3(10,0,2,-6,40,30,6,32,40,0,3,0.3,0.2,400,150,0,{kind},6)"
CIRCLE = "POCKET4(10,0,2,-6,12,75,40,3,0.3,0.2,400,150,0,{kind},6,,,3,2)"


def written(call: str, head: str = "G17 G90 G94", radius: float = RADIUS, spindle=3) -> list[str]:
    """What is written for the cycle."""
    axes = ("X", "Y", "Z")
    offsets = {"G54": {}, "D1": {"Z": 0.0, "R": radius}}
    interpreter = Interpreter(
        dialects.load("siemens"),
        Setup(axes, least_increment=dict.fromkeys(axes, 1e-4), offsets=offsets),
    )
    text = f"{head}\nT1 M6\nG0 X0 Y0 Z50\nS900 M{spindle} F77\n{call}\nM30\n".encode()
    lines = b"".join(Written(Program("A.MPF", text), interpreter, Limits(steps=99, depth=8)))
    return lines.decode().splitlines()[4:-1]


def way(lines: list[str], step: float = 0.05) -> np.ndarray:
    """Places along the feeds, (N, 3)."""
    here, found = np.zeros(3), [np.zeros((0, 3))]
    for line in lines:
        words = dict(re.findall(r"([XYZIJ])(-?[\d.]+)", line))
        to = np.array([float(words.get(a, v)) for a, v in zip("XYZ", here, strict=True)])
        if line.startswith(("G2", "G3")):
            centre = here[:2] + [float(words["I"]), float(words["J"])]
            arm, end = here[:2] - centre, to[:2] - centre
            assert math.hypot(*arm) == pytest.approx(math.hypot(*end), abs=3e-4)
            sense = 1 if line.startswith("G3") else -1
            sweep = sense * (math.atan2(end[1], end[0]) - math.atan2(arm[1], arm[0])) % math.tau
            n = max(2, math.ceil(sweep * math.hypot(*arm) / step))
            turn = math.atan2(arm[1], arm[0]) + sense * np.linspace(0, sweep, n)
            places = centre + math.hypot(*arm) * np.array([np.cos(turn), np.sin(turn)]).T
            found.append(np.c_[places, np.linspace(here[2], to[2], n)])
        elif line.startswith("G1"):
            n = max(2, math.ceil(float(np.abs(to - here).max()) / step))
            found.append(np.linspace(here, to, n))
        here = to
    return np.vstack(found)


@pytest.mark.parametrize("kind", [1, 11, 21])
@pytest.mark.parametrize(
    ("call", "wall"),
    [
        (RECTANGLE + "", ((32, 40), (20, 15), 6, 0)),
        (RECTANGLE.replace(",40,0,3", ",40,30,3"), ((32, 40), (20, 15), 6, 30)),
        (CIRCLE, ((75, 40), (12, 12), 12, 0)),
    ],
)
def test_roughing_clears_the_pocket_but_for_the_allowances(call, wall, kind):
    """-6 with 0.2 left is 5.8 deep, by 3 at most: -2.9 and -5.8."""
    call = call.replace(",6)", ",6,,,,3,2)").format(kind=kind)
    lines = written(call)
    places = way(lines)
    assert sorted(set(places[:, 2].round(6)))[:1] == [-5.8]
    for z in (-2.9, -5.8):
        assert_cleared(places[np.abs(places[:, 2] - z) < 1e-6], wall, RADIUS, 0.3)
    assert from_wall(places[:, :2], *wall).min() >= RADIUS + 0.3 - 1e-3
    assert lines[:3] == ["G0 Z10.", f"G0 X{wall[0][0]}. Y{wall[0][1]}.", "G0 Z2."]
    assert lines[-2:] == ["G0 Z10.", "F77"], "the feed is what it was"


def test_how_it_gets_into_a_depth():
    """_VARI 1 in rapid traverse, 11 at FFD, 21 on a helix of RAD1 by DP1 a turn."""
    assert written(RECTANGLE.format(kind=1))[3] == "G0 Z-2.9"
    assert written(RECTANGLE.format(kind=11))[3] == "G1 Z-2.9 F150."
    helix = written(CIRCLE.format(kind=21))[3:10]
    assert helix[0] == "G1 X78. Y40. F400."
    assert helix[1].startswith("G3 X72. Y40.") and helix[1].endswith("I-3. J0. F150.")
    depths = [float(m[1]) for line in helix if (m := re.search(r"Z(-?[\d.]+)", line))]
    assert all(a - b <= 1 + 1e-6 for a, b in zip([2, *depths], depths, strict=False))


def test_finishing_goes_once_along_the_wall_and_over_the_bottom():
    lines = written(RECTANGLE.format(kind=2))
    places = way(lines)
    wall = ((32, 40), (20, 15), 6, 0)
    assert from_wall(places[:, :2], *wall).min() == pytest.approx(RADIUS, abs=1e-3)
    side = places[(np.abs(places[:, 2] + 5.8) < 1e-6)]
    near = side[np.abs(from_wall(side[:, :2], *wall) - RADIUS) < 1e-3][:, :2] - (32, 40)
    turn = np.unwrap(np.arctan2(near[:, 1], near[:, 0]))
    assert turn[-1] - turn[0] == pytest.approx(math.tau, abs=0.02), "climb: against the clock"
    assert_cleared(places[np.abs(places[:, 2] + 6) < 1e-6], wall, RADIUS, 0.0)


@pytest.mark.parametrize(
    ("direction", "spindle", "sense"),
    [(0, 3, 1), (1, 3, -1), (2, 3, -1), (3, 3, 1), (0, 4, -1), (2, 4, -1)],
)
def test_the_sense(direction, spindle, sense):
    lines = written(CIRCLE.replace("150,0,", f"150,{direction},").format(kind=2), spindle=spindle)
    arcs = {line[:2] for line in lines if line.startswith(("G2", "G3"))}
    assert arcs == {"G3" if sense > 0 else "G2"}


@pytest.mark.parametrize("seed", range(12))
def test_random_pockets(seed):
    """Sides, corners, turns and tools of any size."""
    rng = random.Random(seed)
    radius = rng.uniform(2, 8)
    a, b = (rng.uniform(radius + 0.6, 40) for _ in "ab")
    corner, turn = rng.uniform(0, min(a, b)), rng.uniform(-90, 90)
    wide = rng.choice([0, rng.uniform(0.3, 1.6) * radius])
    call = (
        f"POCKET3(10,0,2,-4,{2 * a:.4f},{2 * b:.4f},{corner:.4f},5,-7,{turn:.4f},,0.5,,400,150,"
        f"{rng.randrange(4)},11,{wide:.4f})"
    )
    places = way(written(call, radius=radius), 0.1)
    places = places[np.abs(places[:, 2] + 4) < 1e-6]
    assert_cleared(places, ((5, -7), (a, b), corner, turn), radius, 0.5)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (RECTANGLE.format(kind=31), "VARI=31"),
        (RECTANGLE.format(kind=1).replace("40,30", "-40,30"), "LENG=-40"),
        (RECTANGLE.format(kind=1).replace(",6)", ",6,5)"), "AP1=5"),
        (RECTANGLE.format(kind=1).replace("40,30", "9,30"), "does not fit"),
        (RECTANGLE.format(kind=21), "without RAD1"),
        (CIRCLE.format(kind=21).replace("3,2)", "9,2)"), "RAD1 9 by DP1 2"),
        (RECTANGLE.format(kind=2).replace("0.3,0.2", "0,0"), "finishes nothing"),
        (RECTANGLE.format(kind=1).replace("10,0,2,-6", "10,0,2,6"), "not in order"),
        ("G91\n" + RECTANGLE.format(kind=1), "G17 G90"),
    ],
)
def test_refused(call, said):
    with pytest.raises(ProgramError) as error:
        written(call)
    assert said in str(error.value)
