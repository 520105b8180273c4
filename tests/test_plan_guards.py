"""What a line like one before may not take over from it: each guard of plans, by lines that go
wrong without it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import ModalState
from postproc.records import names, replace
from postproc.units import TICKS_PER_MM
from tests.small_machines import write_mill
from tests.test_plans import outcome

ROOT = Path(__file__).resolve().parents[1]
MILL = "G21 G90 G17 G54 G94 F900|G0 X10. Y10. Z30.|G1 X12. Y11. Z29.5|"
LATHE = "G21 G0 X40. Z100.|"
TILTED = "G90 G54 G17|G0 X0. Y0. Z30. A0. C0.|G68.2 X0. Y0. Z0. I0. J30. K0.|G53.1|G1 X5. F100.|"
CONTOUR = "G41 D1 X20. Y11.|X30.|Y{}|X25.|G40 X12. Y11.|"
LENGTHS = {"T1": {"R": 1.0}, "T01100": {"X": 0.0, "Z": 7.0}}


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    folder = tmp_path_factory.mktemp("guards") / "mill"
    found = {x: read_machine(ROOT / "machines" / x) for x in ("studer-s36", "example-five-axis")}
    return found | {"mill": read_machine(write_mill(folder, False))}


def blocks(text: str) -> list[bytes]:
    return [line.encode() + b"\n" for line in text.split("|")]


def filter_of(machine, dialect: str, **how) -> Filter:
    zeros = dict.fromkeys(machine.letters, 0.0)
    setup = setup_of(machine, {"G54": zeros} | LENGTHS, **how)
    return Filter(machine, dialects.load(dialect), setup)


# fmt: off
LINES = {
    # name: how the control is set, and the program
    "letters": ({}, MILL + "G1 X13.|G1 Y14."),
    "values": ({}, MILL + "G1 X13.|G0 X14.|G1 X1.|G1 X10."),
    "decimals of values": ({}, MILL + "G54|X13.|G5.4|X14."),
    "modes": ({}, MILL + "X13.|G91|X14.|G1 X.1"),
    "modes beside other values": ({}, MILL + "G1 X13.|G91|G1 X.14"),
    "where it stands": ({}, MILL + "X13.|Y14.|X15.|M8|Y16.|M8|Y17.|M8|G91|Y1."),
    "block delete on": ({"block_delete": True}, MILL + "(none)|/X14.|Y20."),
    "block delete off": ({}, MILL + "X13.|/X14.|Y20."),
    "block delete within": ({"dialect": "haas"}, MILL + "X13. Y14.|X14. / Y16.|Z20."),
    "increments that are counted": ({"integers": "least increments"}, MILL + "X13.|X14000|X15."),
    "a point that is missed": ({"dialect": "fanuc-mill"}, MILL + "X13.|X15"),
    "digits of T": ({"dialect": "okuma-lathe"}, LATHE + "T0100|T01100|T0100|T1100|G1 X41. Z9. F9"),
    "indentation": (
        {"dialect": "reprap"}, "G21 G90 G0 X10 Y10 Z30|G1 X12 F900|G1 X13|if move.axes[0].homed"
        "|  M117|G1 X14|if move.axes[0].homed|  G1 X14|G1 X15"
    ),
    "arcs": ({}, MILL + "G2 X14. R5.|G2 X17. R5.|G2 X21. R5."),
    "the level of a cycle": (
        {}, MILL + "G98|G81|G80|G1 Z31.|G81|G80|G1 Z36.|G81|X20. Z5. R20.|G80|G91|G1 X1. Z-1."
    ),
    "G10 writes a length": ({}, MILL + "G10 L1 P1 Z5.|G10 L1 P1 Z5.|G10 L1 P1 Z17.|G43 H1|G1 Z10."),
    "contours": ({}, MILL + "".join(CONTOUR.format(y) for y in ("15.", "16.", "11.5"))),
    "a tool change beside a motion": ({}, MILL + "T1 M6|G1 X19.|G1 X20. M6|G1 X20. M6|G0 Y20."),
    "behind a tool change": ({}, MILL + "T1 M6|G1 X20.|T1 M6|G1 X20.|G0 Y20."),
}  # fmt: on


@pytest.mark.parametrize("name", LINES)
def test_lines_one_by_one_are_what_they_are_at_once(machines, name):
    how, program = LINES[name]
    how = {"dialect": "linuxcnc"} | how
    machine = machines["studer-s36" if "lathe" in how["dialect"] else "mill"]
    one, other = filter_of(machine, **how), filter_of(machine, **how)
    lines = blocks(program)
    found, whole = outcome(one, lines), outcome(other, [b"".join(lines)])
    assert found[:3] == whole[:3]


def test_numbers_without_a_point_where_no_notice_is_given(machines):
    """Controls that count increments say so today, which is no rule."""
    silent = replace(dialects.load("haas"), integer_notice="")
    lines = blocks(MILL + "X13.|X14000|X15.")
    one, other = (replace(filter_of(machines["mill"], "haas"), dialect=silent) for _ in range(2))
    assert outcome(one, lines)[:3] == outcome(other, [b"".join(lines)])[:3]


def test_two_lines_at_once_are_no_line_of_their_words(machines):
    parts = [b"X13.\nY14.\n", b"X14. Y15.\n", b"X15.\nY16.\n"]
    head = b"".join(blocks(MILL[:-1]))
    one, other = filter_of(machines["mill"], "linuxcnc"), filter_of(machines["mill"], "linuxcnc")
    assert outcome(one, [head, *parts])[:3] == outcome(other, [head, b"".join(parts)])[:3]


def told(thing: object) -> object:
    """All that a batch says, to be compared."""
    if isinstance(thing, np.ndarray):
        return thing.dtype, thing.shape, thing.tobytes()
    if hasattr(type(thing), "_names"):
        return [told(getattr(thing, x)) for x in names(type(thing)) if x != "alike"]
    if isinstance(thing, list | tuple):
        return [told(x) for x in thing]
    return repr(thing)


def elsewhere(state: ModalState) -> ModalState:
    return state.at(state.position + TICKS_PER_MM, state.feed / 2)


# fmt: off
ONCE_MORE = {
    # name: machine, dialect, the lines before, a line, and one like it, both run from one state
    "G92": ("mill", "linuxcnc", MILL, "G92 X5.", "G92 X7."),
    "G43.1": ("mill", "linuxcnc", MILL, "G43.1 Z5.", "G43.1 Z7."),
    "a notice": ("mill", "linuxcnc", MILL, "M77", "M77"),
    "F": ("mill", "linuxcnc", MILL, "F100", "F20.5"),
    "F of a motion": ("mill", "linuxcnc", MILL, "X13. F100", "X14. F20.5"),
    "F before it": ("mill", "linuxcnc", MILL, "X13.", "X14."),
    "a dwell": ("mill", "linuxcnc", MILL, "G4 P1", "G4 P.5"),
    "a tilted plane": ("example-five-axis", "fanuc-mill", TILTED, "X6.", "X7."),
    "a reference point": ("mill", "linuxcnc", MILL, "G28 X3.", "G28 X4."),
    "an axis at no known place": ("mill", "linuxcnc", "G21 G90 G54 F900|G1 X3. Y4.", "X3.", "X5."),
}  # fmt: on


@pytest.mark.parametrize("name", ONCE_MORE)
def test_a_line_says_what_it_says_whatever_was_run_before(machines, name):
    """An interpreter holds no state: what it makes of a line hangs on the state it is given, also
    on one that comes back elsewhere, which no program may bring about."""
    which, dialect, before, line, like_it = ONCE_MORE[name]
    filter_ = filter_of(machines[which], dialect)
    setup = replace(filter_.setup, home=dict.fromkeys(machines[which].letters, 1.0))
    one, new = (Interpreter(filter_.dialect, setup) for _ in range(2))
    new.plans.none = True
    state = one.initial()
    for part in blocks(before):
        state = one.run(lex(part, filter_.dialect.grammar), state)[1]
    one.run(lex(line.encode(), filter_.dialect.grammar), state)
    for place in (state, elsewhere(state)):
        words = [lex(like_it.encode(), filter_.dialect.grammar) for _ in range(2)]
        assert told(one.run(words[0], place)) == told(new.run(words[1], place))
