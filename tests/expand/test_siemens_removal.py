"""CYCLE95 of Sinumerik by the sequence of operations of the Programming and Operating Manual
(Turning) of the SINUMERIK 808D; every number by hand."""

from __future__ import annotations

import math
import random
import re

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

STEP = "AA: G1 X20 Z0|Z-10|X30|BB: Z-20"
CONE = "AA: G1 X20 Z0|BB: X40 Z-20"


def turned(
    call: str, shape: str = STEP, head: str = "G18 G90 DIAMON F0.3", files=None
) -> list[str]:
    """What is written for the cycle between X60 and M30."""
    axes = ("X", "Z")
    interpreter = Interpreter(
        dialects.load("siemens"),
        Setup(axes, least_increment=dict.fromkeys(axes, 0.001), offsets={"G54": {}}),
    )
    text = f"{head}|G0 X60 Z5|{call}|M30|{shape}".replace("|", "\n").encode()
    library = {name: t.replace("|", "\n").encode() for name, t in (files or {}).items()}
    program = Program("MAIN.MPF", text, library.get)
    lines = b"".join(Written(program, interpreter, Limits(steps=1000, depth=8))).decode()
    return lines.splitlines()[2:-1]


def test_a_step_is_roughed_and_finished():
    """From diameter 30 to 20 in two cuts of 2.5; allowances 0.1 along Z, 0.2 along X (0.4 across);
    1 mm off. The start: 30.4 + 2 across, 0.1 + 1 in front."""
    rough = [
        "G0 X32.4 Z1.1",
        "G0 X25.4", "G1 Z-9.9 F0.25", "G1 X30.4", "G1 Z-19.9",
        "G0 X32.4 Z-18.9", "G0 Z1.1",
        "G0 X20.4", "G1 Z0.1 F0.25", "G1 Z-9.9", "G1 X25.4",
        "G0 X27.4 Z-8.9", "G0 Z1.1",
        "G0 X32.4",
    ]  # fmt: skip
    finish = [
        "G0 X32.4", "G0 Z1.1", "G0 G42 X20. Z0.", "G1 Z-10. F0.1", "G1 X30.", "G1 Z-20.",
        "G0 G40 X32.4 Z1.1",
    ]  # fmt: skip
    modes = ["F0.3"]
    assert turned('CYCLE95("AA:BB",2.6,0.1,0.2,,0.25,,0.1,1,,,1)') == rough + modes
    assert turned('CYCLE95("AA:BB",2.6,0.1,0.2,,0.25,,0.1,5,,,1)') == finish + modes
    both = turned('CYCLE95("AA:BB",2.6,0.1,0.2,,0.25,,0.1,9,,,1)')
    assert both == rough + finish[2:] + modes, "it stands at the start between the two"


def test_the_other_ways():
    """A cone along X, outside: cuts towards the axis, a quarter of the depth each; a bore from
    inside; FAL counts along both axes."""
    face = turned('CYCLE95("AA:BB",6,,,,0.2,,0.1,2,,,1)', "AA: G1 X40 Z-20|BB: X20 Z0")
    assert face[:6] == [
        "G0 X42. Z1.", "G0 Z-5.", "G1 X25. F0.2", "G1 X20. Z0.", "G0 X22. Z1.", "G0 X42.",
    ]  # fmt: skip
    bore = turned('CYCLE95("AA:BB",6,,,0.5,0.2,,0.1,3,,,1)', "AA: G1 X40 Z0|Z-10|BB: X20")
    assert bore == [
        "G0 X17. Z1.5",
        *("G0 X29.", "G1 Z-9.5 F0.2", "G1 X19.", "G0 X17. Z-8.5", "G0 Z1.5"),
        *("G0 X39.", "G1 Z0.5 F0.2", "G1 Z-9.5", "G1 X29.", "G0 X27. Z-8.5", "G0 Z1.5"),
        *("G0 X17.", "F0.3"),
    ]
    inside = turned('CYCLE95("AA:BB",,,,,,,0.1,7,,,1)', "AA: G1 X40 Z0|Z-10|BB: X20")
    assert inside[2] == "G0 G41 X40. Z0."


def test_arcs_are_cut_where_a_depth_meets_them():
    """A quarter of radius 5 about X20 Z-5: at the diameter 24.142 (radius 12.071) it stands at
    Z -5 + 5 cos(asin(2.0711 / 5))."""
    shape = "AA: G1 X20 Z0|BB: G3 X30 Z-5 CR=5"
    lines = turned('CYCLE95("AA:BB",2.5,,,,0.2,,0.1,1)', shape)
    z = -5 + math.sqrt(25 - 2.5**2)
    assert lines[1:4] == ["G0 X25.", f"G1 Z{z:.5f} F0.2", "G3 X30. Z-5. CR=5."]
    assert f"G3 X25. Z{z:.5f} CR=5." in lines


def test_subprograms_variables_and_corners_are_contours():
    """A name is a program beside this one; its expressions and roundings are worked out."""
    step = turned('CYCLE95("AA:BB",2.6,,,,0.25,,0.1,1)')
    files = {"SHAPE": "PROC SHAPE|G1 X=R1 Z0 ; begin|Z-10|X30|Z-20|M17"}
    head = "R1=20|G18 G90 DIAMON F0.3"
    assert turned('CYCLE95("SHAPE",2.6,,,,0.25,,0.1,1)', "", head, files) == step
    rounded = turned('CYCLE95("AA:BB",9,,,,0.2,,0.1,5)', "AA: G1 X20 Z0|Z-10 RND=2|X30|BB: Z-20")
    assert "G2 X24. Z-10. CR=2." in rounded


@pytest.mark.parametrize("seed", range(12))
def test_no_cut_enters_the_contour_and_none_is_deeper_than_mid(seed):
    rng = random.Random(seed)
    z, x, points = 0.0, rng.uniform(5, 20), []
    for _ in range(rng.randint(1, 7)):
        points.append((z, x))
        z -= rng.choice([0.0, rng.uniform(0.5, 9)])
        x += rng.choice([0.0, rng.uniform(0.5, 6)])
    points.append((z - 1, x + 1))
    dz, dx, deep = rng.uniform(0, 0.5), rng.uniform(0, 0.5), rng.uniform(0.7, 3)
    words = [f"X{2 * px:.4f} Z{pz:.4f}" for pz, px in points]
    shape = "|".join(["AA: G1 " + words[0], *words[1:-1], "BB: " + words[-1]])
    lines = turned(f'CYCLE95("AA:BB",{deep:.4f},{dz:.4f},{dx:.4f},,0.2,,0.1,1)', shape)
    moved = [(pz + dz, px + dx) for pz, px in points]

    def least(at: float) -> float:
        """How far out the contour lies at z: its least radius there."""
        if at > moved[0][0]:
            return -math.inf
        for (a, b), (c, d) in zip(moved, moved[1:], strict=False):
            if a >= at >= c:
                return b if a == c else b + (d - b) * (a - at) / (a - c)
        return moved[-1][1]

    here, levels = [0.0, 60.0], []
    for line in lines:
        there = list(here)
        for letter, value in re.findall(r"([ZX])([-\d.]+)", line):
            there["ZX".index(letter)] = float(value) / (1 if letter == "Z" else 2)
        for t in (k / 20 for k in range(1, 21)):
            at = [a + (b - a) * t for a, b in zip(here, there, strict=True)]
            assert at[1] >= least(at[0] + 1e-3) - 2e-3, line
        if line.startswith("G0 X") and " Z" not in line and there[1] < moved[-1][1]:
            levels.append(there[1])
        here = there
    steps = [a - b for a, b in zip([moved[-1][1], *levels], levels, strict=False)]
    assert max(steps) <= deep + 1e-3 and max(steps) - min(steps) < 2e-3


@pytest.mark.parametrize(
    ("call", "shape", "message"),
    [
        ('CYCLE95("AA:BB",2,,,,0.2)', STEP, "VARI of CYCLE95 is 0"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,13)', STEP, "VARI of CYCLE95 is 13"),
        ('CYCLE95("AA:BB",,,,,0.2,,,1)', STEP, "without MID"),
        ('CYCLE95("AA:BB",2,,,,,,,1)', STEP, "without FF1"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,9)', STEP, "without FF3"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,1,,5)', STEP, "with DAM"),
        ("CYCLE95(,2,,,,0.2,,,1)", STEP, "without a contour"),
        ('CYCLE95("SHAPE",2,,,,0.2,,,1)', STEP, "SHAPE is neither a command"),
        ('G91|CYCLE95("AA:BB",2,,,,0.2,,,1)', STEP, "in G91"),
        ('G17|CYCLE95("AA:BB",2,,,,0.2,,,1)', STEP, "another plane"),
        ('G42|CYCLE95("AA:BB",2,,,,0.2,,,1)', STEP, "roughs while"),
        ('G41|CYCLE95("AA:BB",2,,,,,,0.1,5)', STEP, "the other side"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,1)', "AA: G1 X20|Z-10|BB: X30", "does not begin"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,1)', "AA: G1 X20 Z0|BB: X20", "has no way"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,1)', "AA: G1 X20 Z0|Z-9|X18|BB: Z-20", "turns back in X"),
        ('CYCLE95("AA:BB",2,,,,0.2,,,1)', "AA: G1 X20 Z0|X30|Z-9|BB: X40 Z-8", "turns back in Z"),
        (
            'CYCLE95("AA:BB",2,,,,0.2,,,1)',
            "AA: G1 X20 Z0|IF R1>0 GOTOF BB|BB: X40 Z-8",
            "more than",
        ),
        ('CYCLE95("AA:BB",0.0001,,,,0.2,,,1)', STEP, "more than 10,000 cuts"),
    ],
)
def test_what_is_not_written_out_is_said(call, shape, message):
    with pytest.raises(ProgramError, match=message):
        turned(call, shape)


def test_a_side_that_is_on_stays_on():
    """G42 before a finishing that selects it: the same cut, and it holds on behind."""
    lines = turned('G42|CYCLE95("AA:BB",,,,,,,0.1,5,,,1)')
    assert lines[3:-1] == ["G0 X20. Z0.", "G1 Z-10. F0.1", "G1 X30.", "G1 Z-20.", "G0 X32. Z1."]


@pytest.mark.parametrize("kind", [1, 5, 9])
def test_diam90_means_diameters_in_g90(kind):
    """As DIAMON where all is absolute, whatever the machine's words are by themselves."""
    call = f'CYCLE95("AA:BB",2.6,0.1,0.2,,0.25,,0.1,{kind},,,1)'
    assert turned(call, head="G18 G90 DIAM90 F0.3") == turned(call)
