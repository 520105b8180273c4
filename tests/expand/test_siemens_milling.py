"""CYCLE71, CYCLE76 and CYCLE77 of Sinumerik: levels, ends and sense by hand from the manuals; what
the tool passes measured on its ways by another arithmetic."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.pocket_judge import from_wall
from tests.expand.test_siemens_pockets import way, written


def test_the_face_of_the_manual_by_hand():
    """Cycles (11/2006), the example of CYCLE71 with its angle taken out: 11 deep in two depths of
    5.5 (MID 6), to and fro along the first axis. With a radius of 10 the first way lies on the edge
    (MIDA 10 less 10), the last one 10 less FDP1 2 within the other: 32 in 4 steps of 8. They begin
    and end FDP 5 and the radius outside."""
    lines = written("CYCLE71(10,0,2,-11,100,100,60,40,0,6,10,5,0,4000,31,2)", radius=10.0)
    one = [
        "G1 X175. Y108.", "G1 X85. Y108.", "G1 X85. Y116.", "G1 X175. Y116.",
        "G1 X175. Y124.", "G1 X85. Y124.", "G1 X85. Y132.", "G1 X175. Y132.",
    ]  # fmt: skip
    assert lines == [
        "G0 X85. Y100.", "G0 Z2.", "G0 Z-5.5", "G1 X175. Y100. F4000.", *one, "G0 Z2.",
        "G0 X85. Y100.", "G0 Z-11.", "G1 X175. Y100.", *one, "G0 Z-3.5",
        "G0 Z10.", "F77",
    ]  # fmt: skip


def test_one_way_along_the_second_axis_from_a_corner_on_the_right():
    """Finishing, along Y, towards -X: drawn out to FALD and SDIS above the bottom."""
    lines = written("CYCLE71(10,0,2,-3,0,0,-12,40,0,2,7,5,.5,400,22,0)")
    assert lines == [
        "G0 X-2. Y-10.", "G0 Z2.", "G0 Z-3.", "G1 X-2. Y50. F400.", "G0 Z-0.5",
        "G0 X-7. Y-10.", "G0 Z-3.", "G1 X-7. Y50.", "G0 Z-0.5",
        "G0 Z10.", "F77",
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(12))
def test_the_face_is_cut_all_over(seed):
    rng = random.Random(seed)
    radius, kind = rng.uniform(3, 15), rng.choice([11, 21, 31, 41])
    long, wide = (rng.choice([-1, 1]) * rng.uniform(5, 80) for _ in range(2))
    turn, x, y = rng.uniform(0, 180), rng.uniform(-50, 50), rng.uniform(-50, 50)
    step = rng.choice([0.0, rng.uniform(0.5, 2.0) * radius])
    lines = written(
        f"CYCLE71(10,0,2,-3,{x:.4f},{y:.4f},{long:.4f},{wide:.4f},{turn:.4f},2,{step:.4f},3,.5,"
        f"400,{kind},1)",
        radius=radius,
    )
    places = way(lines, 0.2)
    assert sorted(set(places[:, 2].round(6))) == [-2.5, -1.25]
    low = places[np.abs(places[:, 2] + 2.5) < 1e-6][:, :2] - [x, y]
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    low = low @ np.array([[c, -s], [s, c]])
    u, v = np.random.default_rng(seed).uniform(0, 1, (2, 300))
    surface = np.c_[u * long, v * wide]
    assert max(np.hypot(*(low - p).T).min() for p in surface) < radius + 0.02
    out = radius + 3 + 1e-3
    for axis, size in enumerate((long, wide)):
        assert np.abs(low[:, axis] - size / 2).max() <= abs(size) / 2 + max(out, 2 * radius)


PART = "M30\nPART:\nG1 X10 Y20\nY50\nG2 X20 Y60 I10 J0\nG1 X50\nPARTE:\n"
PATH = 'CYCLE72("PART:PARTE",10,0,2,-4,2,{fal},0.2,400,150,{kind},{side},{first},8,900,{last},6)'


def path(side: int, first: int, last: int, kind: int = 2, fal: float = 0.0) -> list[str]:
    call = PATH.format(fal=fal, kind=kind, side=side, first=first, last=last)
    return written(call + "\n" + PART)


def test_a_path_by_hand():
    """To the left of a way up: with a radius of 5 and LP1 8 the quarter has a radius of 13 for the
    tool's edge, about X-3, and begins at Y7; the half circle behind, of 6 and 5, ends at Y82, where
    the tool's middle stands at Y77."""
    one = [
        "G3 X10. Y20. I0. J13. F400.", "G1 X10. Y50.", "G2 X20. Y60. I10. J0.", "G1 X50. Y60.",
        "G3 X50. Y82. I0. J11.", "G0 Z10.", "G0 G40 X50. Y77.",
    ]  # fmt: skip
    begin = ["G0 G41 X-3. Y7.", "G0 Z2."]
    lines = path(41, 2, 3)
    assert lines == [
        "G0 Z10.", *begin, "G1 Z-2. F150.", *one, *begin, "G1 Z-4. F150.", *one, "F77",
    ]  # fmt: skip


def test_a_path_to_the_right_with_straight_lines_and_between_its_depths_at_ff3():
    lines = path(42, 1, 1, kind=12)
    assert lines[:4] == ["G0 Z10.", "G0 G42 X10. Y12.", "G0 Z2.", "G1 Z-2. F150."]
    assert lines[4:6] == ["G1 X10. Y20. F400.", "G1 X10. Y50."]
    assert lines[8:12] == ["G1 X56. Y60.", "G0 Z10.", "G0 G40 X56. Y55.", "G1 G42 X10. Y12. F900."]


def test_a_path_on_the_middle_has_no_compensation():
    lines = path(40, 1, 1)
    assert lines[1:5] == ["G0 X10. Y12.", "G0 Z2.", "G1 Z-2. F150.", "G1 X10. Y20. F400."]
    assert not any("G4" in line for line in lines)


@pytest.mark.parametrize(("side", "sense"), [(41, 1), (42, -1)])
def test_roughing_leaves_the_allowances_beside_a_path(side, sense):
    """0.5 beside the contour, and 0.2 above the bottom: -1.9 and -3.8."""
    places = way(path(side, 1, 1, kind=1, fal=0.5), 0.1)
    assert places[:, 2].min() == -3.8
    for z in (-1.9, -3.8):
        level = places[np.abs(places[:, 2] - z) < 1e-6][:, :2]
        inside = level[(level[:, 1] > 20) & (level[:, 0] < 50)]
        away = np.where(
            (inside[:, 0] < 20) & (inside[:, 1] > 50),
            np.hypot(*(inside - [20, 50]).T) - 10,
            np.maximum(10 - inside[:, 0], inside[:, 1] - 60),
        )
        assert sense * away == pytest.approx(0.5, abs=1e-3)


SPIGOTS = [
    ("CYCLE77(10,0,2,-6,,20,40,30,3,0.5,0.2,400,150,{way},{kind},{blank})",
     ((40, 30), (20, 20), 20, 0)),
    ("CYCLE76(10,0,2,,6,40,30,3,40,30,{turn},3,0.5,0.2,400,150,{way},{kind},{blank},40)",
     ((40, 30), (20, 15), 3, 0)),
    ("CYCLE76(10,0,2,-6,,40,30,0,40,30,{turn},3,0.5,0.2,400,150,{way},{kind},{blank},40)",
     ((40, 30), (20, 15), 0, 30)),
]  # fmt: skip


@pytest.mark.parametrize(("call", "wall"), SPIGOTS)
@pytest.mark.parametrize("kind", [1, 2])
@pytest.mark.parametrize(
    ("cdir", "spindle", "sense"), [(0, 3, -1), (1, 3, 1), (0, 4, 1), (2, 3, -1), (3, 4, 1)]
)
def test_the_tool_goes_once_around_the_spigot_at_each_depth(call, wall, kind, cdir, spindle, sense):
    """Climb milling with M3 goes with the clock around a spigot. Roughing leaves 0.5 and 0.2."""
    lines = written(call.format(turn=wall[3], way=cdir, kind=kind, blank=50), spindle=spindle)
    start = 50 / 2 + 5 + 2
    c, s = math.cos(math.radians(wall[3])), math.sin(math.radians(wall[3]))
    words = f"X{40 + start * c:.6f} Y{30 + start * s:.6f}".replace(".000000", ".")
    assert lines[:3] == ["G0 Z10.", f"G0 {words}", "G0 Z2."]
    places = way(lines)
    bottom, left = (-5.8, 0.5) if kind == 1 else (-6.0, 0.0)
    assert places[:, 2].min() == bottom
    for z in (bottom / 2, bottom):
        level = places[np.abs(places[:, 2] - z) < 1e-6]
        away = -from_wall(level[:, :2], *wall)
        assert away.min() >= 5 + left - 2e-3
        around = level[away < 5 + left + 2e-3]
        angle = np.unwrap(np.arctan2(around[:, 1] - 30, around[:, 0] - 40))
        assert angle[-1] - angle[0] == pytest.approx(sense * math.tau, abs=0.02)
        assert np.hypot(*(level[-1, :2] - level[0, :2])) < 1e-3, "back where it plunged"


def test_without_a_blank_the_start_lies_beside_the_tool_on_the_spigot():
    lines = written(SPIGOTS[0][0].format(way=0, kind=2, blank=""))
    assert lines[1] == "G0 X67. Y30."


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("CYCLE71(10,0,2,-3,0,0,60,40,0,2,12,5,0,400,11,2)", "MIDA of CYCLE71 is 12"),
        ("CYCLE71(10,0,2,-3,0,0,60,40,0,2,8,5,0,400,51,2)", "VARI=51"),
        ("CYCLE71(10,0,2,3,0,0,60,40,0,2,8,5,0,400,11,2)", "planes of CYCLE71 are not in order"),
        ("CYCLE71(10,0,2,-3,0,0,0,40,0,2,8,5,0,400,11,2)", "without LENG and WID"),
        ("CYCLE77(10,0,2,-6,,20,40,30,3,0,0,400,150,7,1)", "CDIR of CYCLE77 is 7"),
        ("CYCLE77(10,0,2,,,20,40,30,3,0,0,400,150,0,1)", "CYCLE77 without DP"),
        ("CYCLE77(10,0,2,-6,,20,40,30,3,0,0,0,150,0,1)", "without its feeds"),
        ("CYCLE76(10,0,2,-6,,-40,30,0,40,30,0,3,0,0,400,150,0,1)", "LENG=-40"),
        (PATH.format(fal=0, kind=2, side=41, first=12, last=1) + "\n" + PART, "AS1=12"),
        (PATH.format(fal=0, kind=2, side=40, first=2, last=1) + "\n" + PART, "RL=40 and AS1=2"),
        (PATH.format(fal=1, kind=1, side=40, first=1, last=1) + "\n" + PART, "FAL=1"),
        (PATH.format(fal=11, kind=1, side=42, first=1, last=1) + "\n" + PART, "no room for FAL"),
        (PATH.format(fal=40, kind=1, side=42, first=1, last=1) + "\n" + PART, "no room for FAL"),
        ('CYCLE72("PART:PARTE",10,0,2,-4,2,0,0,0,150,1,41,1,8)\n' + PART, "without its feeds"),
        ("CYCLE72(,10,0,2,-4,2,0,0,400,150,1,41,1,8)", "without a contour"),
        ("G91\nCYCLE77(10,0,2,-6,,20,40,30,3,0,0,400,150,0,1)", "in G91 or in diameters"),
    ],
)
def test_what_is_not_followed_is_refused(call, message):
    with pytest.raises(ProgramError, match=message):
        written(call)
