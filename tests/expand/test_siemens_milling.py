"""CYCLE71 and CYCLE77 of Sinumerik: levels, ends and sense by hand; what
the tool passes measured on its ways by another arithmetic."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.pocket_judge import from_wall
from tests.expand.test_siemens_pockets import way, written


def test_a_face_by_hand():
    """The call of the manual's example with its angle taken out: 11 deep in two depths of
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


SPIGOTS = [
    ("CYCLE77(10,0,2,-6,,20,40,30,3,0.5,0.2,400,150,{way},{kind},{blank})",
     ((40, 30), (20, 20), 20, 0)),
]  # fmt: skip


@pytest.mark.parametrize(("call", "wall"), SPIGOTS)
@pytest.mark.parametrize("kind", [1, 2])
@pytest.mark.parametrize(
    ("cdir", "spindle", "sense"), [(0, 3, -1), (1, 3, 1), (0, 4, 1), (2, 3, -1), (3, 4, 1)]
)
def test_the_tool_goes_once_around_the_spigot_at_each_depth(call, wall, kind, cdir, spindle, sense):
    """Climb milling with M3 goes with the clock around a spigot. Roughing leaves 0.5 and 0.2."""
    lines = written(call.format(way=cdir, kind=kind, blank=50), spindle=spindle)
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
        ("CYCLE77(10,0,2,-6,,20,40,30,3,0,0,400,150,0,1,25)", "25 across, and the spigot 40"),
        ("CYCLE77(10,0,2,,,20,40,30,3,0,0,400,150,0,1)", "CYCLE77 without DP"),
        ("CYCLE77(10,0,2,-6,,20,40,30,3,0,0,0,150,0,1)", "without its feeds"),
        ("G91\nCYCLE77(10,0,2,-6,,20,40,30,3,0,0,400,150,0,1)", "in G91 or in diameters"),
    ],
)
def test_what_is_not_followed_is_refused(call, message):
    with pytest.raises(ProgramError, match=message):
        written(call)
