"""Conditions and loops that a control runs by itself, told by indentation: RepRapFirmware's if,
elif, else and while.

Which of their lines run, and how often, is known at the machine alone. What moves nothing may stand
there; behind homing and levelling no place is known; what moves, or changes what words mean, can
not be followed.

Source: Duet3D/RepRapFirmware, GCodes/GCodeBuffer/StringParser.cpp (CheckMetaCommand,
ProcessConditionalGCode): a block ends where a line is indented no further than the line that began
it.
"""

from __future__ import annotations

import re

import numpy as np

from postproc.expressions import expression
from postproc.nc.batch import Batch
from postproc.nc.state import NONE

FLOW = expression(rb"[ \t]*(?:if|elif|else|while)\b", re.IGNORECASE)
GROUP = "condition"  # of the modal state: the indentation of the line that began it
WAY_OUT = "write the lines that shall run, without the condition"


def conditionals(b: Batch) -> None:
    """Look for lines inside conditions, and what they do; sets b.condition for the next batch."""
    text, held = b.words.text, b.state.codes.get(GROUP, NONE)
    starts, stops = b.words.block_start, b.words.block_stop
    if held == NONE and (
        not b.n or not re.search(rb"(?i)\b(?:if|while)\b", text[starts[0] : stops[-1]])
    ):
        return
    inside = np.zeros(b.n, bool)
    for block, (start, stop) in enumerate(zip(starts.tolist(), stops.tolist(), strict=True)):
        line = text[start:stop].rstrip()
        if line.lstrip()[:1] not in (b"", b";"):
            held = _held_by(line, held)
            inside[block] = held != NONE
    b.condition = held
    _judge(b, inside)


def _held_by(line: bytes, held: int) -> int:
    """The indentation of the condition in which a line stands, NONE for none. held: of the line
    before."""
    #   if x < 5        0     held NONE -> 0
    #     G1 X5         2     deeper than 0: inside
    #   else            0     goes on the same condition: held stays 0
    #   G1 X0           0     the condition has ended
    indent = len(line) - len(line.lstrip())
    flow = bool(FLOW.match(line))
    if held != NONE and indent <= held and not (flow and indent == held):
        held = NONE
    return indent if held == NONE and flow else held


def _judge(b: Batch, inside: np.ndarray) -> None:
    moved = inside & b.has_axis & ~b.taken
    # a modal code inside would hold behind it too, but only where the condition was true
    for column in b.given.values():
        moved |= inside & (column != NONE)
    for block in b.single.values():
        b.loses[block[inside[block]]] = True
    b.single = {
        number: block[~inside[block]]
        for number, block in b.single.items()
        if not inside[block].all()
    }
    b.loses |= inside & b.taken
    b.foreign |= moved
    b.blame(
        np.flatnonzero(moved), "a line that moves, or changes modes, inside if or while", WAY_OUT
    )
