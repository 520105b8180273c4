"""POLY of Sinumerik: the manual's own example, its polynomials evaluated by their formula, and how
far the lines leave them."""

from __future__ import annotations

import random
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.test_corners import plain
from tests.expand.test_splines import away

START = "G90 G0 X10 Y0 Z0|G1 X10 F100|"


def ends(lines: list[str]) -> np.ndarray:
    """(N, 3) where the feeds end, from X10 Y0 Z0."""
    here, found = {"X": 10.0, "Y": 0.0, "Z": 0.0}, []
    for line in lines:
        words = dict(re.findall(r"([XYZ])(-?[0-9.]+)", line))
        here |= {x: float(v) for x, v in words.items()}
        found.append([here[x] for x in "XYZ"])
    return np.array(found)


def test_a_denominator_makes_the_quarter_circle_of_the_manual():
    """Programming Guide Advanced 04.00, page 167: X = 10 (1 - p^2) / (1 + p^2), Y = 20 p / (1 +
    p^2), p from 0 to 1."""
    lines = plain(START + "N7 PO[X]=(0,-10) PO[Y]=(10) PO[]=(2,1) POLY F50 ; round")
    assert lines[2].startswith("N7 G1 X") and lines[2].endswith("F50 ; round")
    places = np.vstack([[10.0, 0.0, 0.0], ends(lines[2:])])
    assert np.hypot(places[:, 0], places[:, 1]) == pytest.approx(10.0, abs=2e-6)
    assert places[-1].tolist() == [0.0, 10.0, 0.0]
    chords = np.linalg.norm(np.diff(places, axis=0), axis=1)
    sagitta = 10.0 - np.sqrt(100.0 - chords**2 / 4)
    assert sagitta.max() <= 1e-3 and len(lines) < 400


def polynomial(start: float, values: list[float], length: float, p: np.ndarray) -> np.ndarray:
    """f(p) = a0 + a1 p + a2 p^2 + ..., a1 so that f(PL) is the end: page 163."""
    high = sum(a * length**k for k, a in enumerate(values[1:], 2))
    a1 = (values[0] - start - high) / length
    return start + a1 * p + sum(a * p**k for k, a in enumerate(values[1:], 2))


@pytest.mark.parametrize("seed", range(20))
def test_the_lines_leave_the_curve_by_the_tolerance_at_most(seed):
    rng = random.Random(seed)
    length = rng.choice([1.0, 0.5, 1.5, 3.0, 10.0])
    degree = rng.randint(1, 4)
    values = {
        x: (
            [rng.uniform(-20, 20)]
            + [rng.uniform(-9, 9) / length**k for k in range(2, 2 + rng.randint(0, degree))]
        )
        for x in "XYZ"
    }
    words = " ".join(f"PO[{x}]=({','.join(f'{v:.6f}' for v in values[x])})" for x in "XYZ")
    lines = plain(START + f"POLY {words} PL={length}")[2:]
    p = np.linspace(0.0, length, 3001)
    curve = np.column_stack(
        [
            polynomial(at, [float(f"{v:.6f}") for v in values[x]], length, p)
            for x, at in zip("XYZ", (10.0, 0.0, 0.0), strict=True)
        ]
    )
    corners = np.vstack([[10.0, 0.0, 0.0], ends(lines)])
    assert away(curve, corners) <= 1e-3 + 2e-6
    assert corners[-1] == pytest.approx(curve[-1], abs=2e-6)


def test_a_plain_axis_goes_evenly_and_blocks_without_polynomials_are_straight():
    lines = plain(START + "POLY PO[X]=(20,0,0) Y5|X30|M8|PO[Y]=(9)|G0 X1|X2")
    assert lines[2:] == ["G1 X20. Y5.", "G1 X30", "M8", "G1 Y9.", "G0 X1", "X2"]


def test_values_may_be_expressions():
    assert plain("R1=5|" + START + "POLY PO[X]=(R1*4,0) PO[Y]=(R1)")[2:] == ["G1 X20. Y5."]


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("PO[X]=(20,1)", "PO. . without POLY"),
        ("G1 POLY PO[X]=(20,1)", "beside another motion code"),
        ("G91 POLY PO[X]=(20,1)", "in G91"),
        ("POLY PO[A]=(20,1)", "the axis A in a polynomial"),
        ("POLY PO[X]=(20,1) PO[]=(2,1) Y5", "a plain axis beside a denominator"),
        ("POLY PO[X]=(20,1) PO[]=(-1)", "denominator whose poles"),
        ("POLY PO[X]=(20,1) PL=0", "PL=0"),
        ("G1 X20 RND=1|POLY PO[X]=(20,1)", "beside corners"),
    ],
)
def test_what_is_not_followed_is_refused(program, message):
    with pytest.raises(ProgramError, match=message):
        plain(START + program)
