"""Programs with cycles and frames as plain lines, and the motions of these lines: what several
tests of them need. Our interpreter reads the plain lines; where LinuxCNC judges, its own
interpreter runs the original program.

Numbers are written with ten decimals there, so that the comparison is as sharp as for plain
programs.
"""

from __future__ import annotations

import re

import pytest

from postproc.nc import dialects
from postproc.nc.expand import Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import CLOSE, plain, setup_for

MILL = setup_for({})
LATHE = Setup(
    axes=("X", "Z", "C"), diameter=frozenset("X"), least_increment=dict.fromkeys("XZC", 1e-3),
    start={"X": 0.0, "Z": 0.0, "C": 0.0},
)  # fmt: skip


class Exact(Tracker):
    """A tracker whose numbers are written to a tick."""

    def decimals(self, letter: str) -> int:
        return 12 if self.inch else 10


def expand(
    text: str, dialect: str = "linuxcnc", setup: Setup = MILL, tracker=Tracker, **options
) -> list[Line]:
    """The plain lines of a program, one source line after the other (no language stage before)."""
    resolver = Resolver(
        Program("part", text.encode()),
        tracker(Interpreter(dialects.load(dialect), setup)),
        **options,
    )
    return [
        plain
        for n, one in enumerate(text.split("\n"), 1)
        for plain in resolver.take(Line(one.encode(), n))
    ]


def text_of(program: str, dialect: str, setup: Setup = MILL) -> list[str]:
    """The plain text of a program written with | between its lines."""
    return [line.text.decode() for line in expand(program.replace("|", "\n"), dialect, setup)]


def motions(lines: list[Line], dialect: str = "linuxcnc", setup: Setup = MILL) -> list[dict]:
    """What our interpreter makes of plain lines."""
    interpreter = Interpreter(dialects.load(dialect), setup)
    words = lex(b"\n".join(line.text for line in lines) + b"\n", interpreter.dialect.grammar)
    assert words.fault is None, words.fault
    return plain(interpreter.run(words, interpreter.initial())[0], words, 0)


def same_motions(text: str, theirs: list[oracle.Motion], source: str | None = None) -> None:
    """Assert that the text written out moves as LinuxCNC does when it runs the original. `source`:
    what the language stage hands on, where that is not the text itself."""
    program = Program("part", text.encode())
    resolver = Resolver(
        program, Exact(Interpreter(dialects.load("linuxcnc"), MILL)), synchronised=True
    )
    lines = [
        plain
        for n, one in enumerate((source or text).split("\n"), 1)
        for plain in resolver.take(Line(one.encode(), n))
    ]
    mine = motions(lines)
    moved = [m for m in theirs if m.kind == "arc" or (m.kind != "dwell" and _length(m) > CLOSE)]
    written = "\n".join(line.text.decode() for line in lines)
    assert [(lines[a["line"] - 1].source, a["kind"]) for a in mine] == [
        (b.line, b.kind) for b in moved
    ], written
    for a, b in zip(mine, moved, strict=True):
        assert not a["reason"][0], (a, written)
        assert a["end"] == pytest.approx(list(b.end), abs=CLOSE), (a, b, written)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b, written)
            assert (a["sweep"] > 0) == (b.turns > 0)
    dwells = [m.seconds for m in theirs if m.kind == "dwell" and m.seconds]
    assert [float(p) for p in re.findall(r"G4 ?P([\d.]+)", written)] == dwells


def _length(motion: oracle.Motion) -> float:
    return max(abs(a - b) for a, b in zip(motion.start, motion.end, strict=True))


def needs_oracle():
    return pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))


BEGIN = "F100|S100 M3|G0 X5 Z5|"


def program_of(holes: str) -> str:
    """Blocks with | between them as a whole program of LinuxCNC."""
    return (BEGIN + holes + "|M2|").replace("|", "\n")


def lathe(program: str, dialect: str = "fanuc-lathe-a") -> list[str]:
    """As text_of, on the lathe."""
    return text_of(program, dialect, LATHE)
