"""Real Sinumerik programs, written out and followed by the one interpreter: the positions of the
tables beside them."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "corpus" / "sinumerik"
PROGRAMS = sorted(FOLDER.glob("*.mpf")) if FOLDER.is_dir() else []
AXES = "XYZABCE"
CLOSE = 0.00051  # mm: the tables have three decimals
# What is refused, by the sentence; the tables of these hold what an unset variable or an unknown
# call would do.
REFUSED = {
    "arrays": "nn",
    "axis_index_assignment": "ACC",
    "custom_vars": "AA",
    "edge_cases": "ELX",
    "simple": "two X words",
    "spline": "spline",
}
# from the file of defaults that the tables' producer reads first
START = {"increment": {"Y": 900.0}}


def table(path: Path) -> tuple[list[str], list[tuple[float, ...]]]:
    """Axes and the different places, one after the other, of the table beside a program."""
    source = path.with_suffix(".csv")
    source = source if source.exists() else path.with_name(path.stem + "_raw.csv")
    rows = list(csv.DictReader(source.read_text().splitlines()))
    axes = [name for name in (rows[0] if rows else {}) if name in AXES]
    here: dict[str, float] = dict.fromkeys(axes, 0.0) | START.get(path.stem, {})
    places = []
    for row in rows:
        if any(row[x] for x in axes):
            here |= {x: float(row[x]) for x in axes if row[x]}
            places.append(tuple(here[x] for x in axes))
    return axes, places


def followed(path: Path, axes: list[str]) -> list[tuple[float, ...]]:
    """The places that the program reaches, as the interpreter sees them."""
    letters = tuple(axes)
    start = dict.fromkeys(letters, 0.0) | START.get(path.stem, {})
    setup = Setup(
        axes=letters,
        least_increment=dict.fromkeys(letters, 1e-4),
        start=start,
        offsets={"G54": dict.fromkeys(letters, 0.0)},
    )
    interpreter = Interpreter(dialects.load("siemens"), setup)
    text = b"".join(
        Written(Program(path.name, path.read_bytes()), interpreter, Limits(100_000, 10))
    )
    words = lex(text, interpreter.dialect.grammar)
    if words.fault:
        raise words.fault
    motions, _, _ = interpreter.run(words, interpreter.initial())
    for reason in motions.reason:
        if "spline" in motions.reasons[int(reason)][0]:
            raise ProgramError(motions.reasons[int(reason)][0])
    return [tuple(column / TICKS_PER_MM) for column in motions.target.T]


def different(places: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    result: list[tuple[float, ...]] = []
    for place in places:
        if not result or max(abs(a - b) for a, b in zip(place, result[-1], strict=True)) > CLOSE:
            result.append(place)
    return result


@pytest.mark.skipif(not PROGRAMS, reason="the corpus is not here")
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_positions_are_those_of_the_table(path):
    axes, expected = table(path)
    if not axes:
        return
    if path.stem in REFUSED:
        with pytest.raises(Exception, match=REFUSED[path.stem]):
            followed(path, axes)
        return
    mine = different(followed(path, axes))
    expected = different(expected)
    start = tuple((dict.fromkeys(axes, 0.0) | START.get(path.stem, {}))[x] for x in axes)
    for places in (mine, expected):
        if places and max(abs(a - b) for a, b in zip(places[0], start, strict=True)) <= CLOSE:
            places.pop(0)
    assert len(mine) == len(expected), (mine[:5], expected[:5])
    for a, b in zip(mine, expected, strict=True):
        assert a == pytest.approx(b, abs=CLOSE)
