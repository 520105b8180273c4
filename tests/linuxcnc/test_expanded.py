"""Programs written out by --expand against LinuxCNC's own interpreter, which runs them as they
stand: the same motions.

O-words, variables and canned cycles are run on both sides; numbers are written out with ten
decimals here, so that the comparison is as sharp as for plain programs. Line numbers differ,
positions may not.
"""

from __future__ import annotations

import math

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import lines_of
from postproc.nc.interpreter import Interpreter
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import (
    CLOSE,
    EXPANDED,
    full_turns,
    initial_state,
    ours,
    reference_lines,
    setup_for,
)

# parameters: work offsets that are turned already; gcomp takes none such
ROTATIONS = range(5230, 5391, 20)


def is_stored(path) -> bool:
    """Whether the program depends on what was stored before it: turned work offsets, values of
    plain variables."""
    parameters = oracle.load(path)[1].get("parameters") or {}
    return any(parameters.get(n) for n in ROTATIONS) or any(n < 5000 for n in parameters)


PROGRAMS = [
    p
    for p in sorted(oracle.PROGRAMS.glob("*.ngc"))
    if p.stem.startswith(EXPANDED) and not is_stored(p)
]


class Exact(Tracker):
    """A tracker whose numbers are written to a tick."""

    def decimals(self, letter: str) -> int:
        return 12


def written_out(text: str, kwargs) -> str:
    """The plain text of a program."""
    interpreter = Interpreter(dialects.load("linuxcnc"), setup_for(kwargs))
    tracker = Exact(interpreter)
    tracker._state = initial_state(tracker._state, kwargs)
    program = Program("part.ngc", text.encode())
    resolver = Resolver(program, tracker, synchronised=True)
    lines = [
        plain.text
        for line in lines_of("linuxcnc", program, tracker, Limits())
        for plain in resolver.take(line)
    ]
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
    sentence = REFUSED.get(path.stem, "")
    try:
        plain = written_out(text, kwargs)
        mine = ours(plain, kwargs)
    except ProgramError as error:
        assert sentence, error
        assert sentence in str(error)
        return
    reasons = [m["reason"][0] for m in mine if m["reason"][0]]
    if reasons:
        assert sentence, reasons
        assert sentence in reasons[0]
        return
    assert not sentence, f"{path.stem} is followed now: take it out of REFUSED"
    if path.stem in STAY:
        assert STAY[path.stem] in plain
        return
    lost = reference_lines(text)
    moved = [
        m
        for m in expected
        if m.line not in lost and m.kind != "dwell" and (m.kind == "arc" or length(m) > CLOSE)
    ]
    assert [m["kind"] for m in mine] == [m.kind for m in moved], plain
    close = COARSE.get(path.stem, CLOSE)
    for a, b in zip(mine, moved, strict=True):
        for axis in range(6):
            if a["end"][axis] is not None:
                assert a["end"][axis] == pytest.approx(b.end[axis], abs=close), (a, b)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b)
            assert math.copysign(1, a["sweep"]) == math.copysign(1, b.turns)
            assert full_turns(a["sweep"]) == abs(b.turns), (a, b)


def length(motion) -> float:
    return max(abs(a - b) for a, b in zip(motion.start, motion.end, strict=True))


# What goes to the control as it is, even with --expand.
STAY = {"sync_g76_diameter": "G76 P1 Z-10 I-1 J.2 K.8 Q30"}

# mm: where LinuxCNC cuts two circles that touch, its square root of nothing is no zero.
COARSE = {"turn_g70_passes": 1e-6}

# What is refused even with --expand, and what the sentence says.
REFUSED: dict[str, str] = {
    "cycle_g87": "G87 can not be written out: LinuxCNC's manual calls it unimplemented, ",
    "cycle_g88": "G88 can not be written out: LinuxCNC's manual calls it unimplemented, ",
    "oword_g92_assigned": "#5211 belongs to the control",
    "oword_m70_m72_offsets": "M72",
    "oword_m70_m72_tool": "M72",
    "oword_m99_main": "M99 in the main program: it begins again without end",
    "oword_system_assigned": "#5220 belongs to the control",
    "oword_system_g92": "#5210 is not known: nothing in the program before this line says it",
    "oword_system_modes": "#<_rpm> is known to the machine only",
    "oword_system_offsets": "#5230 is not known, because G10 R has turned coordinates",
    "oword_system_position_tool_rotation": (
        "#5420 is not known, because G10 R has turned coordinates"
    ),
    "oword_system_reference": "#5161 is not known, because G28.1 has changed it",
    "oword_system_reference_set": "#5161 belongs to the control",
    "oword_system_tool": "#5410 is known to the machine only",
    "oword_work_offset_assigned": "#5221 belongs to the control",
    "rotate_and_g52": "G92 or G52 within a turned work offset (G10 L2 R)",
    "rotate_and_g92": "G92 or G52 within a turned work offset (G10 L2 R)",
    "rotate_and_l10": "G10 L10 within a turned work offset (G10 L2 R)",
    "rotate_and_l20": "G10 L20 within a turned work offset (G10 L2 R)",
    "rotate_and_reference": "G28 over a place within a turned work offset (G10 L2 R)",
    "rotate_and_reference_stored": "G28 over a place within a turned work offset (G10 L2 R)",
    "rotate_diameter": "X is a diameter within a turned work offset (G10 L2 R)",
}
