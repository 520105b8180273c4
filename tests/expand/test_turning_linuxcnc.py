"""Threads (G76) and turning (G70 to G72) of LinuxCNC written out: the motions of its own
interpreter, to 1e-9 mm; other turning is refused."""

from __future__ import annotations

import math
import re

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Line, Program, linuxcnc
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import (
    BEGIN,
    MILL,
    Exact,
    motions,
    needs_oracle,
    program_of,
    same_motions,
    text_of,
)
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


# a facing, a cylinder: from each side, beside it, with the stock on the side where D goes and not
LINES = {
    "G72": (
        "G1 X10 Z0|G1 X0 Z0",
        ("X10 Z1", "X12 Z1", "X8 Z1", "X10 Z-1", "X12 Z-1.3", "X10 Z-.2"),
    ),
    "G71": ("G1 X5 Z0|G1 X5 Z-9", ("X7 Z1", "X7 Z-3", "X3 Z1", "X3 Z-20", "X5 Z1", "X5.1 Z1")),
}


@needs_oracle()
@pytest.mark.parametrize("diameter", ["G7", "G8"])
@pytest.mark.parametrize(
    ("code", "shape", "start"), [(c, x, s) for c, (x, starts) in LINES.items() for s in starts]
)
def test_a_distance_to_one_line_goes_where_linuxcnc_takes_it(code, shape, start, diameter):
    """+X of a cylinder, -Z of a face: a facing from the front is D too deep, which is said."""
    head = f"G18 G21 {diameter} F100|O100 SUB|{shape}|O100 ENDSUB|G0 X14 Z15|"
    text = f"{head}{code} Q100 {start} D.2 I.4 R.3|M2|".replace("|", "\n")
    moved = [m for m in oracle.motions(text) if math.dist(m.start, m.end) > 1e-9]
    assert [(a["kind"], pytest.approx(list(a["end"]), abs=1e-6)) for a in motions(_run(text))] == [
        (b.kind, list(b.end)) for b in moved
    ]


# lines and arcs shorter than twice D; False: one vanishes in an inner corner
SHORT = {
    "G0 X0 Z0|G1 X9|X10 Z-1|Z-30|X16|X50 Z-60": True,
    "G0 X4 Z0|G1 Z-1.2|X5.5|Z-8|X12": True,
    "G0 X2 Z0|G1 Z-5|X3.6|X4 Z-5.4|Z-9|X9": True,
    "G0 X4 Z0|G1 Z-5|X6|G3 X6.5 Z-5.5 K-.5|G1 Z-9|X9": True,  # small arcs that grow
    "G0 X4 Z0|G1 Z-5|G2 X10 Z-11 I6|G1 X14": True,
    "G0 X4 Z0|G1 Z-.5|X5|Z-8|X12": False,
    "G0 X4 Z0|G1 Z-5|X5.2|G3 X5.7 Z-5.5 K-.5|G1 Z-5.6|X9": False,
    "G0 X2 Z0|G1 Z-5|X2.3 Z-5.3|X3|X9 Z-7": False,
}


@needs_oracle()
@pytest.mark.parametrize("shape", SHORT)
def test_a_distance_to_short_lines_is_linuxcncs(shape):
    text = f"G18 G21 F100|O100 SUB|{shape}|O100 ENDSUB|G0 X60 Z5|G71 Q100 D1 I4 R.3|M2|"
    text = text.replace("|", "\n")
    if not SHORT[shape]:
        with pytest.raises(ProgramError, match="a distance of 1"):
            _run(text)
        return
    moved = [m for m in oracle.motions(text) if math.dist(m.start, m.end) > 1e-9]
    assert [(a["kind"], pytest.approx(list(a["end"]), abs=1e-6)) for a in motions(_run(text))] == [
        (b.kind, list(b.end)) for b in moved
    ]


RUN = [  # shapes that only a run of the subroutine gives; corners, each direction of the cuts
    "G0 X0 Z-10|O1 REPEAT [3]|G1 X[#<_x>+5] Z[#<_z>+3]|G1 X[#<_x>+5]|O1 ENDREPEAT",
    "#1=3|G0 X#1|G1 Z-4|O1 IF [#1 GT 2]|X[#1+4] Z-6|O1 ELSE|X9|O1 ENDIF|G1 X9",
    "G0 X2|G1 Z-4 A.5|X6 Z-4|G2 X8 Z-6 K-2 A.3|G1 X10 C.4|Z-9|X12",
    "G0 X2 Z0|G1 X4 C.3|Z-5 A1|X8 A.7|Z-9 C.5|X12 Z-13",
    "G0 X2 Z0|G1 X4 C.3|Z5 A1|X8 A.7|Z9 C.5|X12 Z13",
    "G0Z-12X14|G1Z-10X14|G1 X10 Z-10|G3 K5 I0 X5 Z-5|G1 X5 Z0|X-1|Z2",
    "G0 X5|G1 Z9|X9",  # G70 measures its distance along X here
    "G0 X3|G1 Z-4|G2 X5.001 Z-6.001 I2.001|G1 Z-8|X9",
]
CYCLES = ["G71 Q100 I1.5 R.3", "G72 Q100 I1.5 R.3", "G70 Q100", "G70 Q100 D.4 P2", "G71.1 Q100"]


@needs_oracle()
@pytest.mark.parametrize("cycle", CYCLES)
@pytest.mark.parametrize("shape", RUN)
def test_a_shape_runs_as_a_subroutine_does(shape, cycle):
    text = f"G18 G21 F100|O100 SUB|{shape}|O100 ENDSUB|G0 X14 Z15|{cycle} X15 Z2|M2|"
    text = text.replace("|", "\n")
    try:
        theirs = oracle.motions(text)
    except oracle.ProgramError:
        with pytest.raises(ProgramError):
            motions(_run(text))
        return
    try:
        mine = motions(_run(text))
    except ProgramError as refused:
        assert "a distance" in refused.message
        return
    moved = [m for m in theirs if math.dist(m.start, m.end) > 1e-9]
    assert [(a["kind"], pytest.approx(list(a["end"]), abs=1e-6)) for a in mine] == [
        (b.kind, list(b.end)) for b in moved
    ]
    for a, b in zip(mine, moved, strict=True):
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=1e-6)
            assert (a["sweep"] > 0) == (b.turns > 0)


def _run(text):
    """The lines of a program that its language stage and its cycles leave."""
    program = Program("part", text.encode())
    resolver = Resolver(program, Exact(Interpreter(dialects.load("linuxcnc"), MILL)))
    return [
        plain
        for line in linuxcnc.lines(program, resolver.tracker, Limits(steps=10_000))
        for plain in resolver.take(line)
    ]


@pytest.mark.parametrize(
    ("block", "why"),
    [
        ("G1 Z-4 U2", "U2 in the shape of a cycle is a distance"),
        ("G1 Z-4 A1 C1", "A and C at one corner"),
        ("G1 Z-4 M8", "LinuxCNC passes over it"),
        ("G1 Z-4 A20|X9", "A20 in a corner of the shape: it is longer"),
        ("G1 Z-4 A.005|X9", "on which side LinuxCNC"),
        ("G2 X3 Z-1 I1 A1|G1 X9", "an arc beside it is smaller|longer"),
        ("O1 DO|Z#<x>|O1 WHILE [1]", "not set|has not been|no value"),
    ],
)
def test_what_a_shape_must_not_have_is_refused(block, why):
    text = f"G18 G21 F100|O100 SUB|G0 X2|{block}|O100 ENDSUB|G0 X14 Z0|G71 Q100|M2|"
    with pytest.raises(ProgramError, match=why) as caught:
        motions(_run(text.replace("|", "\n")))
    assert caught.value.advice


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
