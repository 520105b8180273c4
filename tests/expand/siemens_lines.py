"""Sinumerik programs written out with a stand-in for the tracker: what their tests share."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.siemens import lines

AXES = ("X", "Y", "Z", "A", "B", "C", "E", "ELX")


class Follower:
    """Stands in for the tracker: follows plain absolute words, IC( ), TRANS and ATRANS, and nothing
    else."""

    inch = False
    WORD = re.compile(r"([A-Z]+)\s*=?\s*(IC\()?\s*([+-]?(?:\d+\.?\d*|\.\d+))(?![A-Z])")

    def __init__(self, axes=AXES, block_delete=False):
        self.setup = SimpleNamespace(axes=axes, block_delete=block_delete)
        self.dialect = SimpleNamespace(carried=(), grammar=dialects.load("siemens").grammar)
        self.local, self.trans, self.place = {}, {}, {}
        self.rows = []

    def take(self, line: bytes) -> None:
        text = line.decode("latin-1").split(";")[0].upper()
        words = [
            (a, bool(ic), float(v)) for a, ic, v in self.WORD.findall(text) if a in self.setup.axes
        ]
        frame = re.search(r"\b(TRANS|ATRANS|ROT)\b", text)
        if frame:
            old = self.trans if frame[1] == "ATRANS" else {}
            self.trans = {**old, **{a: old.get(a, 0) + v for a, _, v in words}}
            return
        for axis, by, value in words:
            self.local[axis] = value + (self.local.get(axis, 0) if by else 0)
            self.place[axis] = self.local[axis] + self.trans.get(axis, 0)
        if words:
            self.rows.append(dict(self.place))

    def work(self, axis):
        return self.place[axis] - self.trans.get(axis, 0) if axis in self.place else None

    def machine(self, axis):
        return self.place.get(axis)

    def code(self, group):
        return -1

    def decimals(self, letter):
        return 5 if letter in "XYZABCUVWIJKRE" else 6


def run(text, library=None, tracker=None, limits=Limits(steps=100_000, depth=20), name="MAIN.MPF"):
    """The lines, as the driver takes them."""
    tracker = tracker or Follower()
    program = Program(
        name, text.encode("latin-1") if isinstance(text, str) else text, (library or {}).get
    )
    found = []
    for line in lines(program, tracker, limits):
        found.append(line)
        tracker.take(line.text)
    return found


def texts(text, **more):
    return [line.text.decode("latin-1") for line in run(text, **more)]


def value(expression, before=""):
    """What an expression is, by what stands behind X (5 decimals)."""
    last = texts(f"{before}\nX={expression}")[-1]
    assert last.startswith("X="), last
    return float(last[2:])


def refused(text, message, advice="", **more):
    """The refusal, with parts of its sentences."""
    with pytest.raises(ProgramError) as e:
        run(text, **more)
    assert re.search(message, e.value.message), e.value.message
    assert e.value.advice and re.search(advice, e.value.advice), e.value.advice
    assert e.value.place is not None and e.value.place.line >= 1
    return e.value
