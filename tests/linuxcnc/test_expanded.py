"""Programs written out by --expand against LinuxCNC's own interpreter, which runs them as they stand: the same motions.

O-words, variables and canned cycles are run on both sides; numbers are written out with ten decimals here, so that the
comparison is as sharp as for plain programs. Line numbers differ, positions may not.
"""

from __future__ import annotations

import math

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program, lines_of
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import CLOSE, EXPANDED, full_turns, initial_state, ours, setup_for

PROGRAMS = [p for p in sorted(oracle.PROGRAMS.glob("*.ngc")) if p.stem.startswith(EXPANDED)]


class Exact(Tracker):
    """A tracker whose numbers are written to a tick."""

    def decimals(self, letter: str) -> int:
        return 10


def written_out(text: str, kwargs) -> str:
    """The plain text of a program."""
    interpreter = Interpreter(dialects.load("linuxcnc"), setup_for(kwargs))
    tracker = Exact(interpreter)
    tracker._state = initial_state(tracker._state, kwargs)
    program = Program("part.ngc", text.encode())
    resolver = Resolver(program, tracker, synchronised=True)
    lines = [plain.text for line in lines_of("linuxcnc", program, tracker, Limits()) for plain in resolver.take(line)]
    return b"\n".join(lines).decode() + "\n"


@pytest.fixture(scope="module")
def theirs():
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    loaded = {path: oracle.load(path) for path in PROGRAMS}
    return dict(zip(loaded, oracle.motions_of_many(list(loaded.values())), strict=True))


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_written_out_it_moves_as_linuxcnc_does(path, theirs):
    expected = theirs[path]
    assert isinstance(expected, list), expected
    text, kwargs = oracle.load(path)
    try:
        plain = written_out(text, kwargs)
    except ProgramError as error:
        if path.stem in REFUSED:
            assert REFUSED[path.stem] in str(error)
            return
        raise
    mine = ours(plain, kwargs)
    moved = [m for m in expected if m.kind != "dwell" and (m.kind == "arc" or length(m) > CLOSE)]
    assert [m["kind"] for m in mine] == [m.kind for m in moved], plain
    for a, b in zip(mine, moved, strict=True):
        assert not a["reason"][0], a
        for axis in range(6):
            if a["end"][axis] is not None:
                assert a["end"][axis] == pytest.approx(b.end[axis], abs=CLOSE), (a, b)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b)
            assert math.copysign(1, a["sweep"]) == math.copysign(1, b.turns)
            assert full_turns(a["sweep"]) == abs(b.turns), (a, b)


def length(motion) -> float:
    return max(abs(a - b) for a, b in zip(motion.start, motion.end, strict=True))


# What is refused even with --expand, and what the sentence says.
REFUSED: dict[str, str] = {}
