"""Threads (G76) and turning (G70 to G72) of LinuxCNC written out: the motions of its own
interpreter, to 1e-9 mm; other turning is refused."""

from __future__ import annotations

import re

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import BEGIN, MILL, needs_oracle, program_of, same_motions, text_of
from tests.linuxcnc import oracle

THREADS = [
    "G18 G76 Z-10 P1 I-.5 J.3 K1",
    "G18 G76 Z-10 P1 I-.5 J.3 K1 R2 Q29.5 H2",
    "G18 G76 Z-10 P1 I-.5 J.3 K1 R1.5 Q29.5 H1 E2 L1",
    "G18 G76 Z-10 P1 I.5 J.3 K1 R1.5 Q29.5 H1 E2 L3",
    "G18 G76 Z-10 P1 I-.5 J.3 K1 E2 L2",
    "G91 G18 G76 Z-10 P1 I-.5 J.3 K1",
    "G18 G76 Z10 P1 I-.5 J.3 K1 R1.5 Q20 E1 L3",
    "G18 G76 X4 Z-10 P1 I-.5 J.3 K1 R1.5 Q20",
    "G76 Z-10 P1 I-.5 J.3 K1 R.5",
    "G20 G0 X1 Z.1|G76 Z-1 P.05 I-.1 J.01 K.05 E.1 L3 R2 Q29.5",
    "M4|G18 G33 Z-10 K1|G0 X2",
]


@needs_oracle()
@pytest.mark.parametrize("program", THREADS)
def test_every_pass_of_a_thread_is_linuxcncs(program):
    same_motions(program_of(program), oracle.motions(program_of(program)))


def test_a_thread_is_written_as_synchronised_passes():
    lines = text_of(BEGIN + "G18 G76 Z-10 P1.5 I-.5 J.6 K1 E2 L3", "linuxcnc")
    cuts = [line for line in lines if "K" in line]
    along = 1.5 * (2**2 + 1) ** 0.5 / 2
    assert len(cuts) == 8 and cuts[0] == f"G33 X4.9 K{round(along, 8):.8f}".rstrip("0")
    assert cuts[2] == "Z-8. K1.5" and cuts[3].startswith("X4.9 Z-10. K1.67")


def test_a_thread_in_diameters_stays():
    assert text_of(BEGIN + "G7 G18 G76 Z-10 P1 I-.5 J.3 K1", "linuxcnc")[-2:] == [
        "G7",
        "G18 G76 Z-10 P1 I-.5 J.3 K1",
    ]


SHAPES = [
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|G2 X5 Z-7 I1|G1 X7|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G71"
        " Q100 I2.5 R.3|M2|"
    ),
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|G2 X5 Z-7 I1|G1 X12|O100 ENDSUB|F100|S100 M3|G18 G0 X10"
        " Z1|G71 Q100|M2|"
    ),
    (
        "O100 SUB|G0 X20|G1 Z-4|X15 Z-6|G1 X8|O100 ENDSUB|F100|S100 M3|G18 G0 X5 Z1|G71 Q100 I4"
        " R.3|M2|"
    ),
    "O100 SUB|G0 X20|G1 Z6|X15 Z8|O100 ENDSUB|F100|S100 M3|G18 G0 X5 Z1|G71 Q100 I4 R.3|M2|",
    (
        "O100 SUB|G0 Z-10|G1 X8|X6 Z-5|G3 X4 Z-3 R2|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G72 Q100"
        " I2.5 R.3|M2|"
    ),
    "O100 SUB|G0 X3|G1 Z-4|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G71 Q100 I2.5 R5|M2|",
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|G2 X5 Z-7 I1|G1 X7|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G70"
        " Q100|M2|"
    ),
    (
        "O100 SUB|G0 X4|G1 Z-4|X8 Z-6|X12|O100 ENDSUB|F100|S100 M3|G18 G7 G0 X20 Z1|G71 Q100 I2.5"
        " R.3|M2|"
    ),
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|X6|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G71 Q100 X20 Z3"
        " I2.5 R.3|M2|"
    ),
]


@needs_oracle()
@pytest.mark.parametrize("program", SHAPES)
def test_turning_without_pockets_is_linuxcncs(program):
    text = program.replace("|", "\n")
    reached = re.sub(r"(?s)O100 SUB.*?ENDSUB\n", lambda m: "\n" * m[0].count("\n"), text)
    same_motions(text, oracle.motions(text), reached)


@pytest.mark.parametrize(
    ("cycle", "why"),
    [
        ("G71.1", "without the subroutine"),
        ("G71", "without the subroutine"),
        ("G72.2 Q100", "never ends"),
        ("G71 Q101", "no subroutine"),
        ("G91 G71 Q100", "wants G90"),
        ("G17 G71 Q100", "ZX plane"),
    ],
)
def test_other_turning_of_linuxcnc_is_refused(cycle, why):
    program = Program("part", b"O100 SUB\nG0 X2\nG1 Z-4\nX4 Z-6\nO100 ENDSUB\n")
    resolver = Resolver(program, Tracker(Interpreter(dialects.load("linuxcnc"), MILL)))
    resolver.take(Line(b"G18 G0 X10 Z1 F100", 6))
    with pytest.raises(ProgramError, match=why):
        resolver.take(Line(cycle.encode(), 7))
