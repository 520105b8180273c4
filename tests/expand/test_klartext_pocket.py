"""Cycles 251, 252 and 253 of Heidenhain Klartext: wall, bottom, depths and sense by "Cycle run" of
the TNC 640's Cycle Programming manual, measured on the lines."""

from __future__ import annotations

import math
import random
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.pocket_judge import assert_cleared, from_wall
from tests.expand.test_klartext import TOLERANCE, plain

HEAD = "TOOL DEF 5 L+0 R+5|TOOL CALL 5 Z S1000|L X+50 Y+20 Z+40 R0 F900 M3|"
COMMON = (
    "Q207=+500 ~|Q351=+1 ~|Q201=-9 ~|Q202=+4 ~|Q369=+0.2 ~|Q206=+150 ~|Q338=+0 ~|Q200=+2 ~|"
    "Q203=+1 ~|Q204=+30 ~|Q368=+0.3 ~|Q370=+1 ~|Q366=+1 ~|Q385=+700 ~|Q215=+0|CYCL CALL|L X+90"
)
RECTANGLE = "CYCL DEF 251 P ~|Q218=+60 ~|Q219=+30 ~|Q220=+7 ~|Q224=+0 ~|Q367=+0 ~|"
CIRCLE = "CYCL DEF 252 P ~|Q223=+32 ~|"
SLOT = "CYCL DEF 253 P ~|Q218=+60 ~|Q219=+12 ~|Q374=+0 ~|Q367=+0 ~|"
WALLS = {
    RECTANGLE: ((50, 20), (30, 15), 7, 0),
    CIRCLE: ((50, 20), (16, 16), 16, 0),
    SLOT: ((50, 20), (30, 6), 6, 0),
}


def way(lines: list[str], step: float = 0.05) -> np.ndarray:
    """Places along the feeds, (N, 3)."""
    here, found = np.array([50.0, 20.0, 40.0]), [np.zeros((0, 3))]
    for line in lines:
        words = dict(re.findall(r"([XYZ])([-+][\d.]+)", line))
        to = np.array([float(words.get(a, v)) for a, v in zip("XYZ", here, strict=True)])
        if line.startswith("L") and "FMAX" not in line and np.abs(to - here).max() > 0:
            n = max(2, math.ceil(float(np.abs(to - here).max()) / step))
            found.append(np.linspace(here, to, n))
        here = to
    return np.vstack(found)


def at(places: np.ndarray, z: float) -> np.ndarray:
    return places[np.abs(places[:, 2] - z) < 1e-6]


@pytest.mark.parametrize("plunge", [0, 1, 2])
@pytest.mark.parametrize("cycle", [RECTANGLE, CIRCLE, SLOT])
def test_roughing_clears_it_but_for_the_allowances(cycle, plunge):
    """Surface 1, depth 9 less 0.2, by 4: -3, -7, -7.8."""
    data = COMMON.replace("Q215=+0", "Q215=+1").replace("Q366=+1", f"Q366=+{plunge}")
    lines = plain(HEAD + cycle + data)
    places = way(lines)
    cut = places[places[:, 2] < 1]
    assert cut[:, 2].min() == -7.8
    assert from_wall(cut[:, :2], *WALLS[cycle]).min() >= 5.3 - TOLERANCE
    for z in (-3.0, -7.0, -7.8):
        assert_cleared(at(places, z), WALLS[cycle], 5.0, 0.3)
    assert lines[-2:] == ["L Z+31 FMAX", "L X+90 F900"]
    begin = next(i for i, line in enumerate(lines) if line == "L Z+3 FMAX")
    assert lines[begin - 2 : begin] == ["L Z+31 FMAX", "L X+50 Y+20 FMAX"]


def test_a_helix_goes_down_by_three_degrees_at_most():
    lines = plain(HEAD + RECTANGLE + COMMON.replace("Q215=+0", "Q215=+1"))
    down = way(lines)
    down = down[(down[:, 2] < 3) & (down[:, 2] > -3)]
    steps = np.diff(down, axis=0)
    flat = np.hypot(steps[:, 0], steps[:, 1])
    assert (-steps[:, 2] <= math.tan(math.radians(3)) * flat + 1e-3).all()


@pytest.mark.parametrize("cycle", [RECTANGLE, CIRCLE, SLOT])
def test_finishing_goes_along_the_wall_and_over_the_bottom(cycle):
    lines = plain(HEAD + cycle + COMMON.replace("Q215=+0", "Q215=+2"))
    places = way(lines)
    places = places[places[:, 2] < 1]
    wall = WALLS[cycle]
    assert from_wall(places[:, :2], *wall).min() >= 5 - TOLERANCE
    side = at(places, -7.8)
    near = side[from_wall(side[:, :2], *wall) < 5 + 2 * TOLERANCE][:, :2] - (50, 20)
    turn = np.unwrap(np.arctan2(near[:, 1], near[:, 0]))
    assert turn[-1] - turn[0] == pytest.approx(math.tau, abs=0.15), "climb: against the clock"
    assert_cleared(at(places, -8.0), wall, 5.0, 0.0)
    assert any(line.endswith("F700") for line in lines)


def test_both_are_one_after_the_other():
    """Q215 0; without allowances nothing is finished."""
    both, rough = (cut(COMMON.replace("Q215=+0", f"Q215=+{n}")) for n in (0, 1))
    assert both[: len(rough) - 2] == rough[:-2] and len(both) > len(rough)
    data = COMMON.replace("Q368=+0.3", "Q368=+0").replace("Q369=+0.2", "Q369=+0")
    assert cut(data) == cut(data.replace("Q215=+0", "Q215=+1"))


def cut(data: str) -> list[str]:
    """The lines behind the definition."""
    lines = plain(HEAD + RECTANGLE + data)
    return lines[lines.index("L Z+31 FMAX") :]


@pytest.mark.parametrize(
    ("cycle", "place", "turn", "middle"),
    [
        (RECTANGLE, 1, 0, (80, 35)), (RECTANGLE, 3, 0, (20, 5)), (RECTANGLE, 1, 90, (35, 50)),
        (SLOT, 1, 0, (80, 20)), (SLOT, 2, 0, (74, 20)), (SLOT, 3, 0, (26, 20)),
        (SLOT, 4, 90, (50, -10)),
    ],
)  # fmt: skip
def test_the_place_of_the_call_is_a_corner_or_an_end(cycle, place, turn, middle):
    """By hand: half sides 30 by 15 and 30 by 6."""
    angle = "Q374" if cycle == SLOT else "Q224"
    text = cycle.replace("Q367=+0", f"Q367=+{place}").replace(f"{angle}=+0", f"{angle}=+{turn}")
    lines = plain(HEAD + text + COMMON.replace("Q215=+0", "Q215=+1"))
    _, sides, corner, _ = WALLS[cycle]
    assert_cleared(at(way(lines), -7.8), (middle, sides, corner, turn), 5.0, 0.3)
    assert lines[-2] == "L X+50 Y+20 FMAX", "back to where it was called"


@pytest.mark.parametrize("seed", range(12))
def test_random_pockets(seed):
    rng = random.Random(seed)
    a, b, turn = rng.uniform(6, 40), rng.uniform(6, 40), rng.uniform(-90, 90)
    corner, wide = rng.uniform(0, min(a, b)), rng.uniform(0.2, 1.9)
    text = (
        f"CYCL DEF 251 P ~|Q218={2 * a:+.4f} ~|Q219={2 * b:+.4f} ~|Q220={corner:+.4f} ~|"
        f"Q224={turn:+.4f} ~|Q367=+0 ~|"
    )
    data = COMMON.replace("Q370=+1", f"Q370={wide:+.3f}").replace("Q202=+4", "Q202=+99")
    data = data.replace("Q351=+1", f"Q351={rng.choice([1, -1]):+}").replace("=+0|CYCL", "=+1|CYCL")
    places = at(way(plain(HEAD + text + data), 0.1), -7.8)
    assert_cleared(places, ((50, 20), (a, b), max(corner, 5.0), turn), 5.0, 0.3)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("Q351=+1", "Q351=+0", "without Q351"),
        ("Q215=+0", "Q215=+3", "Q215 3"),
        ("Q366=+1", "Q366=+7", "Q366 7"),
        ("Q219=+30", "Q219=+9", "does not fit"),
        ("Q201=-9", "Q201=+9", "depth below 0"),
        ("M3|", "M4|", "by M3"),
        ("Q367=+0", "Q367=+9", "Q367 9"),
    ],
)
def test_refused(old, new, said):
    with pytest.raises(ProgramError) as error:
        plain((HEAD + RECTANGLE + COMMON).replace(old, new))
    assert said in error.value.message
