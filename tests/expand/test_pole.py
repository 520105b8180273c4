"""Heidenhain's arcs about a pole, and by R, as straight lines: every end lies on the circle, every
chord within the tolerance."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

TOLERANCE = 0.001


def plain(program: str) -> list[str]:
    setup = Setup(
        axes=("X", "Y", "Z"), least_increment=dict.fromkeys("XYZ", 1e-4), offsets={"G54": {}},
        start=dict.fromkeys("XYZ", 0.0),
    )  # fmt: skip
    text = "*\n".join(["%PART G71 ", *program.split("|"), ""]).encode()
    written = Written(
        Program("part.i", text), Interpreter(dialects.load("heidenhain-iso"), setup), Limits()
    )
    return b"".join(written).decode().split("\n")[1:-1]


def path(lines: list[str], start: tuple[float, float], letters: str = "XY") -> np.ndarray:
    here, found = dict(zip(letters, start, strict=True)), [start]
    for line in lines:
        for letter, value in re.findall(rf"([{letters}])([-+]?[\d.]+)", line):
            here[letter] = float(value)
        found.append(tuple(here.values()))
    return np.array(found)


def swept(points: np.ndarray, centre: tuple[float, float]) -> float:
    """Degrees about the centre, against the clock."""
    angles = np.arctan2(*(points - centre).T[::-1])
    return math.degrees(
        sum(math.remainder(b - a, math.tau) for a, b in zip(angles, angles[1:], strict=False))
    )


@pytest.mark.parametrize(
    ("arc", "start", "centre", "degrees"),
    [
        ("G00 G90 X+50 Y+20|I+50 J+50|G03 X+80 Y+50 F100", (50, 20), (50, 50), 90),
        ("G00 G90 X+50 Y+20|I+50 J+50|G02 X+80 Y+50 F100", (50, 20), (50, 50), -270),
        ("G00 G90 X+50 Y+20|G02 X+50 Y+20 I+50 J+50 F100", (50, 20), (50, 50), -360),
        ("G00 G90 X+50 Y+50|G29|G00 X+20|G03 X+80 F100", (20, 50), (50, 50), 180),
        ("G00 G90 X+50 Y+20|G91 I+0 J+30|G90 G03 X+80 Y+50 F100", (50, 20), (50, 50), 90),
        ("G00 G90 X+50 Y+20|I+50 J+50|G91 G03 X+30 Y+30 F100", (50, 20), (50, 50), 90),
        ("G00 G90 X+50 Y+20|G03 X+80 Y+50 R+30 F100", (50, 20), (50, 50), 90),
        ("G00 G90 X+50 Y+20|G03 X+80 Y+50 R-30 F100", (50, 20), (80, 20), 270),
        ("G00 G90 X+50 Y+20|G02 X+80 Y+50 R+30 F100", (50, 20), (80, 20), -90),
        ("G00 G90 X+50 Y+20|G02 X+80 Y+50 R-30 F100", (50, 20), (50, 50), -270),
        ("G00 G90 X+50 Y+20|I+50 J+50|G13 H+0 F100", (50, 20), (50, 50), 90),
        ("G00 G90 X+50 Y+20|I+50 J+50|G12 H+0 F100", (50, 20), (50, 50), -270),
        ("G00 G90 X+50 Y+20|I+50 J+50|G13 H+270 F100", (50, 20), (50, 50), 360),
        ("G00 G90 X+50 Y+20|I+50 J+50|G13 G91 H+810 F100", (50, 20), (50, 50), 810),
        ("G00 G90 X+50 Y+20|I+50 J+50|G12 G91 H-30 F100", (50, 20), (50, 50), -30),
    ],
)
def test_an_arc_becomes_chords_of_its_circle(arc, start, centre, degrees):
    lines = plain(arc)
    first = next(i for i, line in enumerate(lines) if "F100" in line)
    assert lines[first].startswith(("G01", "G91 G01", "G90 G01")) and all(
        line.endswith("*") for line in lines
    )
    chords = lines[first:]
    if "G91 G03" in arc or "G91 H" in arc:
        words = [dict(re.findall(r"([XY])([-+]?[\d.]+)", line)) for line in chords]
        steps = [(float(w.get("X", 0)), float(w.get("Y", 0))) for w in words]
        points = np.cumsum([start, *steps], axis=0)
    else:
        points = path(chords, start)
    radius = math.dist(start, centre)
    assert np.hypot(*(points - centre).T) == pytest.approx(radius, abs=2e-4)
    assert swept(points, centre) == pytest.approx(degrees, abs=0.01)
    middles = (points[1:] + points[:-1]) / 2
    assert radius - np.hypot(*(middles - centre).T).min() <= TOLERANCE + 2e-4


def test_arcs_hold_and_the_other_words_stay():
    lines = plain(
        "G00 G90 X+50 Y+20|I+50 J+50|N7 G03 X+80 Y+50 F100 M8|N8 X+50 Y+80|N9 G01 X+0 I+1"
        " J+2|G40 M2"
    )
    assert lines[2].startswith("N7 G01 X") and lines[2].endswith(" F100 M8*")
    [eight] = [line for line in lines if line.startswith("N8")]
    assert re.match(r"N8 G01 X[\d.]+ Y[\d.]+\*$", eight)
    assert lines[-2:] == ["N9 G01 X+0*", "G40 M2*"]


def test_the_plane_of_g18_is_z_x():
    lines = plain("G18|G00 G90 Z+50 X+20|K+50 I+50|G03 Z+80 X+50 F100")
    points = path(lines[3:], (50.0, 20.0), "ZX")
    assert swept(points, (50, 50)) == pytest.approx(90, abs=0.01)


def test_a_helix_rises_with_its_angle():
    """The manual's helix: G13 with an incremental H and Z, two and a half turns and 5 mm up; then
    on to H+0 and Z+9 in G90, three quarters of a turn."""
    lines = plain("G00 G90 X+50 Y+20 Z-1|I+50 J+50|G13 G91 H+900 Z+5 F100|G90 H+0 Z+9")[2:]
    second = next(k for k, line in enumerate(lines) if "G90" in line)
    here, found = np.array([50.0, 20.0, -1.0]), []
    for k, line in enumerate(lines):
        for letter, value in re.findall(r"([XYZ])([-+]?[\d.]+)", line):
            axis = "XYZ".index(letter)
            here[axis] = float(value) + (here[axis] if k < second else 0.0)
        found.append(here.copy())
    points = np.array(found)
    assert points[second - 1] == pytest.approx([50, 80, 4], abs=1e-4)
    assert points[-1] == pytest.approx([80, 50, 9], abs=1e-4)
    assert np.hypot(*(points[:, :2] - 50).T) == pytest.approx(30, abs=2e-4)
    degrees = np.array([swept(points[: k + 1, :2], (50, 50)) for k in range(0, second, 97)])
    assert degrees - degrees[0] == pytest.approx(
        (points[0:second:97, 2] - points[0, 2]) * 180, abs=0.05
    )
    tail = points[second - 1 :]
    assert swept(tail[:, :2], (50, 50)) == pytest.approx(-90 % 360, abs=0.01)
    assert (np.diff(tail[:, 2]) > 0).all()


def test_polar_words_become_places():
    """R 30 about the pole 50, 50 at 0, 90 and 210 degrees, by cosine and sine."""
    lines = plain(
        "G00 G90 X+0 Y+0 Z-1|I+50 J+50|N4 G10 R+30 H+0 M3|G11 R+30 H+90 Z-2 F100|R+30 H+210|G01 X+0"
    )
    assert lines[2] == "N4 G00 X80 Y50 M3*"
    assert lines[3] == "G01 X50 Y80 Z-2 F100*"
    assert lines[4:] == ["G01 X24.0192 Y35*", "G01 X+0*"]


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("G00 G90 X+50 Y+20|G03 X+80 Y+50", "an arc, and no pole is set"),
        (
            "G00 G90 X+50 Y+20|I+50 J+51|G03 X+80 Y+50",
            "start and end lie 31.0000 and 30.0167 from the pole",
        ),
        ("G00 G90 X+50 Y+20|I+50 J+50|G03 X+80 Y+50 Z-5", "Z in an arc"),
        (
            "G00 G90 X+50 Y+20|I+50 J+50|L1,3|G03 X+80 Y+50",
            "a decimal point, not a comma|is not part of a plain NC block",
        ),
        ("G00 G90 X+50 Y+20|G13 H+5", "an arc, and no pole is set"),
        ("G00 G90 X+50 Y+20|I+1 J+1|G13 X+5", "G12 or G13 without H"),
        ("G00 G90 X+50 Y+20|I+1 J+1|G91 G12 H+5", "turns the other way"),
        ("G00 G90 X+50 Y+20|G11 R+5 H+5", "polar words, and no pole is set"),
        ("G00 G90 X+50 Y+20|I+1 J+1|G11 R+5", "polar words without R and H"),
        ("G00 G90 X+50 Y+20|I+1 J+1|G91 G11 R+5 H+3", "polar words in G91"),
        ("G00 G90 X+50 Y+20|G03 X+80 Y+50 R+3", "R3 makes no arc"),
        (
            "G00 G90 X+50 Y+20|I+50 J+50|G03 X+80 Y+50|X+Q1",
            "an arc to a place that Q parameters say",
        ),
    ],
)
def test_what_is_no_arc_is_refused(program, says):
    with pytest.raises(ProgramError, match=says):
        plain(program)


HOLE = (
    "G00 G90 X+5 Y+6 Z+50|G01 X+6 F900|N14 G200 Q200=2 Q201=-5 Q206=150 Q202=3 Q210=0 Q203=+1"
    " Q204={} Q211=0.5|N15 G00 X+50 Y+50 M13|{}|X+60"
)


@pytest.mark.parametrize("call", ["N16 G79 M8", "N16 X+50 M99 M8"])
def test_a_drilling_cycle_is_written_out_where_it_is_called(call):
    """Surface 1, clearance 2, pecks of 3: by hand from the manual's cycle 200."""
    lines = plain(HOLE.format("20", call))
    at = next(k for k, line in enumerate(lines) if "M13" in line)
    first = "N16 M8*" if "G79" in call else "N16 X+50 M8*"
    assert lines[at + 1 :] == [
        first, "G00 Z+3*", "G01 Z-2 F150*", "G00 Z+3*", "G00 Z+0*", "G01 Z-4 F150*", "G04 F0.5*",
        "G00 Z+3*", "G00 Z+21*", "G00 F900*", "X+60*",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("program", "says"),
    [
        (HOLE.format("20", "L1,2|G79"), "program that calls labels"),
        (HOLE.format("20", "G91|G79"), "in G91, or not along Z"),
        (HOLE.format("20", "I+55 J+50|G03 X+60 Y+50|G79"), "neither G00 nor G01"),
        (HOLE.format("20", "G79").replace("G200", "G254"), "cycle 254 is called"),
        ("G00 G90 X+5|G79", "none is defined"),
    ],
)
def test_a_cycle_that_can_not_be_written_out_is_refused(program, says):
    with pytest.raises(ProgramError, match=says):
        plain(program)
