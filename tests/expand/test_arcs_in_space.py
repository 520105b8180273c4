"""Arcs whose plane a turn tilts, written out as lines: against the arcs of LinuxCNC's own
interpreter in coordinates that are not turned, carried along by the turn as its emccanon.cc does
(ARC_FEED: end, centre and axis are turned alike); Sinumerik's by hand."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from tests.expand.frame_lines import moved
from tests.expand.plain_lines import Exact, expand, motions, needs_oracle
from tests.linuxcnc import oracle

CHORD = 0.001  # mm, what lines may leave a curve by where nobody says it
PLANES = {"ZX": ("G18", 2, 0, 1), "YZ": ("G19", 1, 2, 0)}


def _program(draw: random.Random, plane: str) -> str:
    """Lines and arcs in one plane, by R and by centre words, with helices, in G90 and G91."""
    code, first, second, third = PLANES[plane]
    letters, centres = "XYZ", "IJK"
    at = np.array([draw.uniform(-9, 9) for _ in range(3)])
    lines = [f"G0 X{at[0]:.4f} Y{at[1]:.4f} Z{at[2]:.4f}", "F100"]
    at = at.round(4)
    for _ in range(6):
        by = np.array([draw.uniform(-9, 9) for _ in range(3)])
        sense, incremental = draw.choice("23"), draw.random() < 0.5
        if draw.random() < 0.5:
            by[third] = 0.0
        half = math.hypot(by[first], by[second]) / 2
        if draw.random() < 0.5:
            how = f"R{draw.choice([-1, 1]) * (half + draw.uniform(0.1, 5)):.4f}"
        else:  # a centre as far from both ends
            away = draw.uniform(-5, 5) / half / 2
            i = by[first] / 2 - by[second] * away
            j = by[second] / 2 + by[first] * away
            how = f"{centres[first]}{i:.5f} {centres[second]}{j:.5f}"
        by = by.round(4)
        place = by if incremental else (at + by).round(4)
        words = " ".join(f"{x}{value:.4f}" for x, value in zip(letters, place, strict=True))
        lines.append(f"{'G91' if incremental else 'G90'} {code} G{sense} {words} {how}")
        at = at + by
    return "\n".join(lines)


def _turned(place: np.ndarray, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([c * place[0] - s * place[1], s * place[0] + c * place[1], place[2]])


@needs_oracle()
@pytest.mark.parametrize("plane", PLANES)
def test_random_arcs_across_a_turned_work_offset_are_linuxcncs(plane):
    _, first, second, third = PLANES[plane]
    draw, compared = random.Random(7), 0
    for _ in range(20):
        text, degrees = _program(draw, plane), draw.uniform(-170, 170)
        lines = expand(f"G10 L2 P1 R{degrees}\n{text}\nM2\n", tracker=Exact)
        mine = [_turned(np.array(m["end"][:3]), -degrees) for m in motions(lines)]
        at = mine.pop(0)
        for theirs in oracle.motions(f"{text}\nM2\n")[1:]:
            end, centre = np.array(theirs.end[:3]), np.array(theirs.centre)
            radius = math.dist((at[first], at[second]), centre)
            count = next(n for n, p in enumerate(mine) if np.abs(p - end).max() < 2e-6)
            piece, mine = [at, *mine[: count + 1]], mine[count + 1 :]
            arms = [np.array([p[first], p[second]]) - centre for p in piece]
            assert [math.hypot(*arm) for arm in arms] == pytest.approx(
                [radius] * len(arms), abs=2e-4
            )
            angles = np.unwrap([math.atan2(arm[1], arm[0]) for arm in arms])
            steps = np.diff(angles) * theirs.turns
            assert (steps > 0).all() and steps.sum() <= math.tau + 1e-9
            assert (radius * (1 - np.cos(steps / 2)) <= CHORD + 1e-9).all()
            shares = (angles - angles[0]) / (angles[-1] - angles[0])
            across = at[third] + (end[third] - at[third]) * shares
            assert [p[third] for p in piece] == pytest.approx(across, abs=2e-5)
            at, compared = end, compared + 1
        assert not mine
    assert compared > 100


def test_an_arc_in_a_plane_that_sinumerik_has_turned_about_x():
    """ROT X30: a half circle of radius 5 about (5, 0) in X and the turned Y."""
    made = moved("G0 X0 Y0 Z0|ROT X30|G1 X0 Y0 Z0 F100|G2 X10 Y0 I5 J0|G1 X12 Y0 Z0", "siemens")
    ends = np.array([m["end"][:3] for m in made])[1:-1]
    assert all(m["kind"] != "arc" for m in made)
    across, along = ends[:, 0] - 5, ends[:, 1] / math.cos(math.radians(30))
    assert np.hypot(across, along) == pytest.approx(5, abs=1e-4)
    assert ends[:, 2] == pytest.approx(along * math.sin(math.radians(30)), abs=1e-5)
    assert (along[1:-1] > 0).all()  # G2: with the clock, over the top
    assert ends[-1] == pytest.approx((10, 0, 0), abs=1e-6)


def test_what_stands_beside_an_arc_goes_with_its_first_or_last_line():
    """F and M8 hold from the start, M30 ends the program behind the arc, the next arc has its own
    code again."""
    texts = [
        line.text.decode()
        for line in expand(
            "G0 X1 Y0 Z5\nG10 L2 P1 R90\nG0 X1 Y0 Z5\n/G18 G2 X3 Z3 I2 K0 F99 M8 M30", "linuxcnc"
        )
    ]
    first, last = texts[2], texts[-1]
    assert first.startswith("/G18 G1 X") and first.endswith(" F99 M8")
    assert all(text.startswith("/") for text in texts[2:])
    assert last == "/X0. Y3. Z3. M30"
    back = expand("G10 L2 P1 R90\nG0 X1 Y0 Z5\nF9\nG18 G3 X3 Z5 R1\nG17\nX5 Y0 R1")
    assert back[-1].text == b"G3 X0. Y5. R1."
