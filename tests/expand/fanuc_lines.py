"""Fanuc and Haas programs written out: what their tests share."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from postproc.errors import ProgramError
from postproc.nc.dialects import load
from postproc.nc.expand import Limits, Line, Program
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import lines_of
from postproc.nc.grammar import PLAIN
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

LEAST = dict.fromkeys("XYZ", 0.001)
ZERO = dict.fromkeys("XYZ", 0.0)
MILL = Setup(("X", "Y", "Z"), least_increment=LEAST, offsets={"G54": ZERO}, start=ZERO)
LATHE = Setup(
    ("X", "Z"),
    frozenset("X"),
    {"X": 0.001, "Z": 0.001},
    {"G54": {"X": 0.0, "Z": 0.0}},
    {"X": 10.0, "Z": 0.0},
)


def run(
    text, dialect="fanuc-mill", setup=MILL, library=None, limits=Limits(), **grammar
) -> list[Line]:
    dialect = load(dialect)
    if grammar:
        dialect = replace(dialect, grammar=replace(PLAIN, **grammar))
    tracker = Tracker(Interpreter(dialect, setup))
    data = text if isinstance(text, bytes) else text.encode("latin-1")
    out = []
    for line in lines_of("fanuc", Program("p.nc", data, (library or {}).get), tracker, limits):
        tracker.take(line.text)
        out.append(line)
    return out


def plain(text, *more, **kw) -> list[str]:
    return [line.text.decode("latin-1") for line in run(text, *more, **kw)]


def value(expression: str, before: str = "", **kw) -> float:
    """An expression's value, as the X word that it leaves; nan: the word goes."""
    found = re.search(
        r"X(-?[\d.]+)", " ".join(plain(f"O1\n{before}\nG1 X[{expression}] Z1.\n", **kw)[1:])
    )
    return float(found[1]) if found else math.nan


def refused(text, *parts, **kw) -> ProgramError:
    with pytest.raises(ProgramError) as caught:
        run(text, **kw)
    for part in parts:
        assert part in str(caught.value)
    assert caught.value.advice
    return caught.value
