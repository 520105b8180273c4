"""The journal, and the way back into a program (A9, A10, A11 of design/streaming.md)."""

from __future__ import annotations

import json
import random

import pytest

from postproc.errors import GcompError, UsageError
from postproc.streaming import journal, restart, resumable, zero
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.live import Live
from postproc.streaming.outcome import Outcome
from postproc.streaming.protocols import Controller
from postproc.streaming.protocols.grbl import Grbl
from postproc.streaming.source import Source
from tests.streaming.bench import new_sender, run
from tests.streaming.grbl_model import GrblModel
from tests.streaming.test_source import filter_

PROGRAM = b"""G21 G90 G17 G94
G54
G0 X0 Y0 Z20
M3 S8000
M8
G0 X10 Y10
G1 Z2 F200
G1 X40 F600
G91
G1 Y5
G1 X-10
G90
G2 X20 Y25 I-5 J5
X10 Y15 I0 J-10
G20
G1 X1 F20
G21
G0 Z20
M5
M30
"""


def state_before(
    line: int, program: bytes = PROGRAM, machine: str = "example-mill", dialect: str = "grbl"
):
    filter = filter_(machine, dialect)
    before, rest = restart.read_before(filter, program.splitlines(keepends=True), line)
    return filter, before, rest


def blocks(line: int, safe: float | None = None, **how) -> list[str]:
    filter, before, rest = state_before(line, **how)
    resumable.refuse(filter, rest, line)
    return [
        x.decode() for x in restart.preamble(filter, before, None if safe is None else {"Z": safe})
    ]


def test_A11_the_preamble_lifts_first_and_brings_back_what_holds():
    assert blocks(11) == [
        "G21 G90 G17 G94",
        "G54",
        "G53 G0 Z-180.0000",
        "G0 X40.0000 Y15.0000",
        "M3 S8000",
        "G4 P4",
        "M8",
        "G1 Z2.0000 F200",
        "G17 G21 G91 G94",
        "F600",
        "G1",
    ]


def test_A11_inches_and_a_safe_z_of_the_users():
    lines = blocks(17, -150.0)
    assert lines[2] == "G53 G0 Z-150.0000" and lines[3] == "G0 X25.4000 Y15.0000"
    assert lines[-4:] == ["G1 Z2.0000 F200", "G17 G20 G90 G94", "F20", "G1"]


@pytest.mark.parametrize(
    ("line", "program", "says"),
    [
        (14, PROGRAM, "an arc whose G2 or G3 stands in a line before"),
        (21, PROGRAM + b"G0 X1\n", "has ended"),
        (
            4,
            b"G21 G91\nG1 X5 F100\nG1 X5\nG1 X5\n",
            "X, Y, Z stands before it is not known in incremental distance",
        ),
        (4, b"G21 G90 G54\nG0 X1 Y1 Z1\nG92 X0\nG1 X5 F100\n", "shifted its zero"),
        (4, b"G21 G90 G54\nG0 X1 Y1 Z1\nG10 L2 P1 X5\nG1 X5 F100\n", "has written offsets (G54)"),
        (4, b"G21 G90 G54\nG0 X1 Y1 Z1\nG28 X0\nG1 X5 F100\n", "not known"),
        (40, PROGRAM, "beyond the program's 20 lines"),
    ],
)
def test_A11_what_can_not_be_restarted_is_refused(line, program, says):
    with pytest.raises(GcompError) as error:
        blocks(
            line,
            program=program,
            machine="perfect" if b"G91\nG1 X5 F" in program else "example-mill",
        )
    assert says in str(error.value) and error.value.advice


@pytest.mark.parametrize(
    ("program", "dialect", "says"),
    [
        (
            b"G21 G90 G54 G17\nG0 X1 Y1 Z1\nG81 X1 Y1 Z-5 R1 F100\nX5 Y5\n",
            "grblhal",
            "canned cycle",
        ),
        (b"G21 G90 G54 G17\nG0 X1 Y1 Z1\nG41 D1 G1 X5 F100\nX9 Y5\n", "linuxcnc", "cutter radius"),
    ],
)
def test_A11_cycles_and_cutter_compensation_are_refused(program, dialect, says):
    with pytest.raises(GcompError) as error:
        blocks(4, program=program, machine="perfect", dialect=dialect)
    assert says in str(error.value)


@pytest.mark.parametrize("line", [7, 8, 10, 11, 13, 16, 18])
def test_A11_interrupted_and_resumed_ends_where_the_whole_run_ends(line):
    """The model as judge: same end, same words in force, and every line from the restart on goes to
    the same places."""

    def ends(feed_to, lines):
        model = GrblModel(baud=0)
        model.stored["G54"] = [0.0, 0.0, -200.0]
        sender = new_sender(model)
        run(sender, model, lines, limit=1e4, tick=0.01)
        assert sender.outcome.kind == "done", sender.outcome
        return model

    whole = Source(filter_(), Grbl().prepare)
    all_lines = whole.feed(PROGRAM)
    filter, before, rest = state_before(line)
    resumable.refuse(filter, rest, line)
    again = Source(filter_(), Grbl().prepare)
    lines = again.feed(b"\n".join(restart.preamble(filter, before)) + b"\n")
    again.filter.summary.lines = line - 1
    lines += again.feed(b"".join(PROGRAM.splitlines(keepends=True)[line - 1 :]))
    first, second = ends(None, all_lines), ends(None, lines)
    assert second.place == pytest.approx(
        first.place, abs=0.008
    )  # slides may come from the other side: reversal of 6 um
    assert second.modal == first.modal and second.rate == first.rate
    last = {x.source: x.end for x in all_lines}
    for x in lines:
        if x.source >= line:
            resumed = [y for y in lines if y.source == x.source][-1]
            assert resumed.end == pytest.approx(last[x.source], abs=0.02)


# -- the journal -----------------------------------------------------------------------------------


def written(n: int, answered: int, executed: int = 0) -> bytes:
    text = journal.head("a.nc", "abc", "m", "d", 21, place=(0.0, 0.0))
    for i in range(1, n + 1):
        line = WireLine(
            i, 10 + i // 3, i % 3, b"G1X%d" % (i // 2), (i // 2, 0.0), correction=(0.001, 0.0)
        )
        text += journal.record("sent", line, i * 0.01)
        if i <= answered:
            text += journal.record("answered", line, i * 0.01 + 0.005)
        if i == executed:
            text += journal.record("status", Status("run", place=(3.0, 0.0)), i * 0.01, executed)
    return text


def test_A10_a_journal_names_the_first_line_that_may_not_be_executed():
    """Every second line moves: line 73 may not be over, three motions before it are lines 68, 70
    and 72."""
    past = journal.read(written(100, 90, 72), "j")
    assert (past.sent, past.answered, past.executed) == (100, 90, 72)
    assert past.certain == 10 + 68 // 3
    way = journal.way(past)
    assert way[0] == (71, [(36.0, 0.0)]) and way[-1] == (99, [(49.0, 0.0), (50.0, 0.0)])
    assert journal.read(written(100, 5), "j").certain == 10  # wire line 1
    assert journal.read(written(0, 0), "j").certain == 1


def test_A10_a_journal_cut_anywhere_is_read_up_to_the_cut():
    text = written(60, 50)
    r = random.Random(1)
    for _ in range(200):
        cut = r.randrange(text.index(b"\n") + 1, len(text))
        past = journal.read(text[:cut], "j")
        assert past.answered <= 50 and past.sent <= 60
    with pytest.raises(UsageError, match="empty"):
        journal.read(text[:30], "j")


@pytest.mark.parametrize(
    ("now", "words"),
    [
        ({"G54": {"X": 10.0005}}, ""),  # controllers report whole um
        ({"G54": {"X": 10.001}}, "G54 had X = 10 mm when the job began, and has X = 10.001 mm now"),
        ({"G54": {"X": 10.0}, "G92": {"Z": -1.0}}, "G92 had Z = 0 mm when the job began"),
        ({}, "G54 had X = 10 mm when the job began, and has X = 0 mm now"),
    ],
)
def test_a_work_offset_that_was_changed_is_a_lost_zero_though_it_was_homed(now, words):
    past = journal.Past({"offsets": {"G54": {"X": 10.0}}})
    live, controller = Live(now, {}, {}, ()), Controller()
    said = zero.zero_lost(past, live, ("X", "Y", "Z"), controller, True, zero.HOMED)
    assert said.startswith(words) and bool(said) == bool(words)


def test_a_journal_that_is_none_is_refused_with_its_line():
    with pytest.raises(UsageError, match="no journal"):
        journal.read(b'{"a": 1}\n{"b": 2}\n', "j")
    with pytest.raises(UsageError, match="no line of a journal"):
        journal.read(journal.head("a", "", "", "", 1) + b"rubbish\n" + b'{"a":1}\n', "j")


@pytest.mark.parametrize(
    ("kind", "position"),
    [("reset", "unknown"), ("done", "known"), ("error", "known"), ("alarm", "unknown")],
)
def test_A9_the_journal_says_whether_the_position_is_known(kind, position):
    assert json.loads(journal.end(Outcome(kind, "m"), 1.0))["position"] == position
