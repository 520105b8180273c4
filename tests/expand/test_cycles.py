"""What holds for canned cycles whatever the control: lines without them stay, comments and block
delete stay with their block, real programs come out hole by hole, and no bytes end in anything but
lines or a sentence."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles.block import Block, blocks
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import LATHE, MILL, expand, text_of

CORPUS = Path(__file__).resolve().parents[3] / "shared" / "corpus" / "fanuc"

CONTROLS = [
    "linuxcnc",
    "fanuc-mill",
    "haas",
    "fanuc-lathe",
    "fanuc-lathe-a",
    "fanuc-lathe-c",
    "siemens",
    "grbl",
]


@pytest.mark.parametrize("dialect", CONTROLS)
def test_a_program_without_cycles_and_frames_comes_out_unchanged(dialect):
    text = (
        "%\n(a)\nN10 G0 X1. Y2. Z5 ; b\n/G1X3.Y-.5F100\n\tG2 X4 Y1 I0.5 J.5\r\nM3 S100\nG4"
        " P1\nM5\n\nM30\n%\n"
    )
    lines = expand(text, dialect)
    assert [line.text for line in lines] == [line.encode() for line in text.split("\n")]
    assert [line.source for line in lines] == list(range(1, len(lines) + 1))


def test_several_blocks_in_a_line_become_several_lines():
    assert blocks(b"G1 X1 (;) ; X2;", dialects.load("fanuc-mill").grammar) == [
        b"G1 X1 (;) ",
        b" X2",
    ]
    lines = expand("G0 Z9; G99 G81 X1. Z-1. R2.; X2.; G80", "fanuc-mill")
    assert [line.source for line in lines] == [1] * len(lines)
    assert [line.text for line in lines][1:] == [
        b" G99 G0 X1.", b"Z2.", b"G1 Z-1.", b"G0 Z2.", b" G0 X2.", b"G1 Z-1.", b"G0 Z2.", b" G80",
    ]  # fmt: skip


def test_comments_stay_and_end_a_number():
    block = Block.of(b"N1 G81 X1 (hole 1) Y2(b)Z-3 R1", dialects.load("linuxcnc").grammar)
    assert [w.raw for w in block.words] == ["1", "81", "1", "2", "-3", "1"]
    assert block.written({1, 4, 5}, b"G0") == b"N1 G0 X1 (hole 1) Y2(b)"


def test_block_delete_marks_every_line_that_a_marked_block_becomes():
    lines = text_of("G0 Z9|/G99 G81 X1. Z-1. R2.|G80", "fanuc-mill")
    assert lines == ["G0 Z9", "/G99 G0 X1.", "/Z2.", "/G1 Z-1.", "/G0 Z2.", "G80"]
    skipped = replace(MILL, block_delete=True)
    assert (
        text_of("G0 Z9|/G99 G81 X1. Z-1. R2.|G80", "fanuc-mill", skipped)[1]
        == "/G99 G81 X1. Z-1. R2."
    )


@pytest.mark.skipif(not CORPUS.exists(), reason="no corpus of real programs here")
@pytest.mark.parametrize("name", ["G81", "G81_G91", "G82", "G83"])
def test_real_programs_are_written_out_hole_by_hole(name):
    text = (CORPUS / f"{name}.NC").read_bytes()
    interpreter = Interpreter(dialects.load("fanuc-mill"), replace(MILL, start={}, offsets={}))
    out = b"".join(Written(Program(name, text), interpreter, Limits()))
    assert not re.search(rb"G8[1-9]", out)
    # G91: Z counts from R, 2 mm above zero
    bottom = rb"G1\s*Z-(118|120)\." if name == "G81_G91" else rb"G1\s*Z-20\."
    assert len(re.findall(bottom, out)) == 12


WORDS = """G81 G82 G83 G73 G84 G85 G86 G89 G76 G70 G71 G72 G74 G75 G77 G78 G79 G90 G91 G92 G94 G98 G99 G80 G0 G1 G2 G3
G17 G18 G19 G20 G21 G24 G68 G69 G51 G50 G51.1 G50.1 G15 G16 G10 L2 P1 P10 Q20 N10 N20 G54 G55 G43 H1 G49 G4 G28 G53 M3
M5 M30 T1 T0101 ROT AROT TRANS ATRANS MIRROR SCALE ASCALE AMIRROR G110 G111 AP=30 RP=5 RPL=30 CR=3 X=IC(3) I=AC(2) G7
G90.1 G41 G40 G93 (c) ;x / % ( $1 #1 [ * " \x00 \xe9 1e5 X99999999999999999999""".split()  # noqa: E501


@pytest.mark.parametrize("seed", range(8))
def test_no_bytes_make_it_stumble(seed):
    """Only sentences for the user may come out, whatever goes in."""
    draw = random.Random(seed)
    for _ in range(150):
        dialect = draw.choice(CONTROLS)
        text = draw.choice(["", "G90 G0 X50 Y1 Z5\n", "G0 X50. Z5.\nM3 S100\nF10\n"])
        for _ in range(draw.randint(1, 12)):
            words = [
                (
                    draw.choice(WORDS)
                    if draw.random() < 0.5
                    else draw.choice("XYZXYZUWIJKRQPFDEHLC")
                    + draw.choice([f"{draw.uniform(-20, 20):.3f}", ".5", "0", "", "-1"])
                )
                for _ in range(draw.choice([0, 1, 2, 3, 3, 4, 6]))
            ]
            text += draw.choice([" ", ""]).join(words) + "\n"
        try:
            expand(text, dialect, draw.choice([MILL, LATHE]))
        except ProgramError as error:
            assert error.message and error.place is not None, text
