"""A3= B3= C3= of Sinumerik: rotary words that give the tool the direction of the vector."""

from __future__ import annotations

import random
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.filter import setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from tests.reference.tool_point import random_truth
from tests.test_tool_point import corrected, load

FIVE = places.load("example-five-axis")
OFFSETS = {"G54": {}, "D1": {"Z": 100.0}}
HEAD = "G90 G54 T1 D1|"


def plain(program: str, machine=FIVE, start=None) -> list[str]:
    start = dict.fromkeys(machine.letters, 0.0) if start is None else start
    interpreter = Interpreter(dialects.load("siemens"), setup_of(machine, OFFSETS, start))
    text = (HEAD + program + "|M30|").replace("|", "\n").encode()
    return (
        b"".join(Written(Program("part.mpf", text), interpreter, Limits()))
        .decode()
        .split("\n")[1:-2]
    )


def test_the_vector_of_the_manual_is_its_rotary_words(tmp_path):
    """SINUMERIK, Manual, 5-axis machining, page 11: "N100 G1 X0 Y0 Z0 A3=1 B3=1 C3=1" is
    "B=54.73561 C=45" on a machine whose table turns about Z and whose head about Y."""
    truth = random_truth(np.random.default_rng(1), "w-C-b-X-Y-Z-B-t")
    machine = load(truth, tmp_path, "siemens")
    lines = plain("G0 B0 C0|TRAORI|N100 G1 X0 Y0 Z0 A3=1 B3=1 C3=1 F500", machine)
    assert lines[-1] == "N100 G1 X0 Y0 Z0 B54.73561 C45. F500"


def test_directions_by_hand():
    """A-30 leans the tool by sin 30 towards +Y; a component that is left out is 0; a block without
    a vector keeps the direction; at the pole A goes to 0 and C stays; behind TRAFOOF A3 is none."""
    lines = plain(
        "G0 A0 C0|TRAORI|G1 X1 B3=.5 C3=.8660254 F100 ; lean|X2|A3=.5 B3=.5 C3=.70710678|C3=9"
        "|TRAFOOF"
    )
    assert lines == [
        "G0 A0 C0",
        "TRAORI",
        "G1 X1 A-30. F100 ; lean",
        "X2",
        "A-45. C-45.",
        "A0.",
        "TRAFOOF",
    ]


def test_values_may_be_expressions_and_keep_their_digits():
    lines = plain("G0 A0 C0|TRAORI|R1=0.123456789|G1 X1 B3=R1 C3=SQRT(1-R1*R1) F100")
    angle = float(re.search(r"A(-[0-9.]+)", lines[-1])[1])
    assert angle == pytest.approx(-np.degrees(np.arcsin(0.123456789)), abs=2e-5)


@pytest.mark.parametrize("seed", range(10))
def test_the_tool_has_the_direction_that_is_written(seed):
    rng = random.Random(seed)
    kinematics = setup_of(FIVE, OFFSETS, dict.fromkeys(FIVE.letters, 0.0)).kinematics
    vectors = [(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.1, 1)) for _ in range(8)]
    blocks = "|".join(
        f"X{n} A3={i:.7f} B3={j:.7f} C3={k:.7f}" for n, (i, j, k) in enumerate(vectors)
    )
    here = {"A": 0.0, "C": 0.0}
    for line, vector in zip(plain(f"G0 A0 C0|TRAORI|G1 F100|{blocks}")[3:], vectors, strict=True):
        here |= {x: float(v) for x, v in re.findall(r"([AC])(-?[0-9.]+)", line)}
        assert "=" not in line
        pose = np.array([here.get(x, 0.0) for x in FIVE.letters])
        exact = np.array(vector) / np.linalg.norm(vector)
        assert np.linalg.norm(kinematics.tool_axis(pose) - exact) < np.radians(0.001)


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("G1 X1 C3=1 F9", "does not stand behind TRAORI"),
        ("TRAORI|TRAFOOF|G1 X1 C3=1 F9", "does not stand behind TRAORI"),
        ("TRAORI C3=1", "does not stand behind TRAORI"),
        ("TRAORI|ORIMKS|G1 X1 C3=1 F9", "in the machine's coordinates"),
        ("TRAORI|G91 G1 X1 C3=1 F9", "in G91"),
        ("TRAORI|G1 X1 C3=0 F9", "have no direction"),
        ("TRAORI|G1 X1 A5 C3=1 F9", "beside the word of a rotary axis"),
        ("TRAORI|ROT Z30|G0 X1 Y1 Z1|G1 X1 B3=1 C3=2 F9", "turned, scaled or mirrored"),
        ("TRAORI|G1 X1 C3=-1 F9", "no pose within the travels"),
    ],
)
def test_what_is_not_followed_is_refused(program, message):
    with pytest.raises(ProgramError, match=message):
        plain("G0 A0 C0|" + program)


@pytest.mark.parametrize("words", ["A2=10 B2=5", "LEAD=3 TILT=1", "A4=1 C5=1"])
def test_angles_and_normals_are_refused(words):
    with pytest.raises(ProgramError, match="by angles|from the surface's normal"):
        corrected(FIVE, "siemens", f"G90 G54 T1 D1\nTRAORI\nG1 X1 {words} F9\nM30\n", OFFSETS)


def test_where_the_tool_turns_from_must_be_known():
    with pytest.raises(ProgramError, match="where the rotary axes stand, and that is not known"):
        plain("TRAORI|G1 X1 C3=1 F9", start={})
