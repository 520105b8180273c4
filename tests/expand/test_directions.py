"""G43.5 of Fanuc: rotary words that give the tool the direction of I J K, by the machine's exact
transforms."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.filter import setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter

MACHINE = read_machine(Path(__file__).resolve().parents[2] / "machines" / "example-five-axis")
OFFSETS = {"G54": {}, "H1": {"Z": 100.0}}
START = dict.fromkeys(MACHINE.letters, 0.0)


def plain(program: str, offsets=OFFSETS, start=START, integers="") -> list[str]:
    setup = replace(setup_of(MACHINE, offsets, start), integers=integers)
    interpreter = Interpreter(dialects.load("fanuc-mill"), setup)
    text = ("G90 G54|" + program + "|M30|").replace("|", "\n").encode()
    return (
        b"".join(Written(Program("part.nc", text), interpreter, Limits()))
        .decode()
        .split("\n")[1:-2]
    )


def test_directions_by_hand():
    """A turns about X, C about Z, of the tool as the part sees it (ISO 841): A-30 leans the tool by
    sin 30 towards +Y. The frame is that of the table as it stands at the call (A-79348E): at C90
    the same direction is the same tilt. Behind, 45 degrees aside, C goes the shorter way; at the
    pole A goes to 0 and C stays."""
    lines = plain(
        "G0 A0. C90.|G43.5 H1 P0|G1 X1. J.5 K.8660254 F100.|X2.|I.5 J.5 K.70710678|K1.|G49|I1."
    )
    assert lines == [
        "G0 A0. C90.",
        "G43.4 H1 P0",
        "G1 X1. A-30. F100.",
        "X2.",
        "A-45. C45.",
        "A0.",
        "G49",
        "I1.",
    ]


@pytest.mark.parametrize("seed", range(20))
def test_the_tool_has_the_direction_that_is_written(seed):
    rng = random.Random(seed)
    kinematics = setup_of(MACHINE, OFFSETS, START).kinematics
    c = rng.choice([0.0, 0.0, 30.0, -75.0])
    vectors = [(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.1, 1)) for _ in range(8)]
    blocks = "|".join(f"X{n}. I{i:.7f} J{j:.7f} K{k:.7f}" for n, (i, j, k) in enumerate(vectors))
    here = {"A": 0.0, "C": c}
    turn = np.radians(c)
    about = np.array(
        [[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    for line, vector in zip(
        plain(f"G0 A0. C{c}|G43.5 H1|G1 F100.|{blocks}")[3:], vectors, strict=True
    ):
        before = dict(here)
        here |= {x: float(v) for x, v in re.findall(r"([AC])(-?[0-9.]+)", line)}
        assert "I" not in line and abs(here["C"] - before["C"]) <= 180.001
        pose = np.array([here.get(x, 0.0) for x in MACHINE.letters])
        exact = about @ np.array(vector) / np.linalg.norm(vector)
        assert np.linalg.norm(kinematics.tool_axis(pose) - exact) < np.radians(0.001)


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("G43.5 H1 I0 J0 K1.", "I0 in the block of G43.5"),
        ("G43.5 H1 Q2.", "Q2. in the block"),
        ("G43.5 H1 P1", "P1 in the block"),
        ("G43.5 H1|G2 X5. I5. F9", "an arc under G43.5"),
        ("G43.5 H1|G91 G1 K1. F9", "in G91"),
        ("G43.5 H1|G1 K0 F9", "have no direction"),
        ("G43.5 H1|G1 K-1. F9", "no pose within the travels"),
    ],
)
def test_what_is_not_followed_is_refused(program, message):
    with pytest.raises(ProgramError, match=message):
        plain("G0 A0. C0.|" + program)


def test_components_that_count_increments_are_written_alike():
    """K1 of 0.001 beside I.001 is 45 degrees, and beside I1. none to speak of."""
    program = "G0 A0. C90.|G43.5 H1 P0|G1 X1. {} F100."
    counted = {"integers": "least increments"}
    alike = [plain(program.format(words), **counted)[-1] for words in ("J1. K1.", "J1 K1", "J7 K7")]
    assert alike == ["G1 X1. A-45. F100."] * 3
    assert plain(program.format("I0 J0.5 K.5"), **counted)[-1] == alike[0]
    with pytest.raises(ProgramError, match=r"K1 of a direction has no decimal point"):
        plain(program.format("J1. K1"), **counted)
    assert plain(program.format("J1. K1"))[-1] == alike[0]


def test_where_the_tool_turns_from_must_be_known():
    with pytest.raises(ProgramError, match="where the rotary axes stand, and that is not known"):
        plain("G43.5 H1|G1 X1. J1. K9. F9", start={})


def test_a_notice_says_that_there_are_two_poses():
    interpreter = Interpreter(dialects.load("fanuc-mill"), setup_of(MACHINE, OFFSETS, START))
    written = Written(
        Program("part.nc", b"G90 G54\nG43.5 H1\nG1 J1. K9. F9\nM30\n"), interpreter, Limits()
    )
    b"".join(written)
    assert [n.code for n in written.notices] == ["G43.5"]
