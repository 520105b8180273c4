"""LinuxCNC programs written out, and what LinuxCNC's own interpreter makes of the original: what
their tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.linuxcnc import lines
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import (
    CLOSE,
    full_turns,
    initial_state,
    ours,
    setup_for,
)

PROGRAMS = sorted((Path(__file__).parent / "linuxcnc").glob("*.ngc"))
LIMITS = Limits(steps=100_000, depth=20)


class Fine(Tracker):
    """Writes numbers so that a nanometre's thousandth can be told."""

    def decimals(self, letter: str) -> int:
        return 12


def run(text, kwargs=None, library=None, tracker=Tracker, limits=LIMITS, setup=None):
    """The lines, as the driver takes them."""
    kwargs = kwargs or {}
    follower = tracker(Interpreter(dialects.load("linuxcnc"), setup or setup_for(kwargs)))
    if setup is None:
        follower._state = initial_state(follower.state, kwargs)
    text = text.encode("latin-1") if isinstance(text, str) else text
    found = []
    for line in lines(Program("main.ngc", text, (library or {}).get), follower, limits):
        found.append(line)
        follower.take(line.text)
    return found


def texts(text, **more):
    return [line.text.decode("latin-1") for line in run(text, **more)]


def value(expression, before=""):
    """What an expression is, by what stands behind X."""
    [text] = texts(f"{before}\nX[{expression}]".lstrip("\n"), tracker=Fine)
    return float(text[1:])


def refused(text, **more):
    with pytest.raises(ProgramError) as caught:
        run(text, **more)
    return caught.value


def by_oracle(programs):
    """What LinuxCNC makes of programs (text, keywords)."""
    reason = oracle.available()
    if reason:
        pytest.skip(reason)
    return oracle.motions_of_many(programs)


def check(text, kwargs, expected):
    """The motions of the program as written out are those of the original in LinuxCNC."""
    assert isinstance(expected, list), expected
    plain = (
        "\n".join(line.text.decode("latin-1") for line in run(text, kwargs, tracker=Fine)) + "\n"
    )
    mine = ours(plain, kwargs)
    expected = [
        m
        for m in expected
        if m.kind != "dwell"
        and (
            m.kind == "arc" or max(abs(a - b) for a, b in zip(m.start, m.end, strict=True)) > CLOSE
        )
    ]
    assert [m["kind"] for m in mine] == [m.kind for m in expected], plain
    for a, b in zip(mine, expected, strict=True):
        assert not a["reason"][0], (a, plain)
        for axis in range(6):
            assert a["end"][axis] == pytest.approx(b.end[axis], abs=CLOSE), (a, b, plain)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b)
            assert full_turns(a["sweep"]) == abs(b.turns), (a, b)
