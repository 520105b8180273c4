"""How a job ends, byte by byte: when the spindle may be stopped, which end counts, and how often a
controller must say that it rests."""

from __future__ import annotations

import pytest

from postproc.streaming.endings import stopped
from postproc.streaming.limits import AGAIN
from postproc.streaming.lines import WireLine
from postproc.streaming.protocols.marlin import Marlin
from postproc.streaming.sender import HALTING, HELD, Sender
from tests.streaming.bench import lines_of, new_sender, run
from tests.streaming.grbl_model import GrblModel
from tests.streaming.test_holds import BAD

SPINDLE_STOP = b"\x9e"


def refused_line(**how) -> Sender:
    """A sender whose one line was refused, and whose bytes have left."""
    sender = new_sender(GrblModel(), **how)
    sender.give([WireLine(1, 1, 0, b"G1X1Q9")])
    sender.end()
    sender.tick(0.0)
    sender.bytes_out()
    sender.receive(b"error:20\r\n", 0.1)
    sender.bytes_out()
    sender.bytes_out()
    return sender


def test_the_spindle_stops_when_the_machine_stands_and_not_while_it_brakes():
    """GRBL 1.1, interface.md: Hold:0 stands, Hold:1 is still moving; 0x9E in a cut breaks the
    tool."""
    sender = refused_line(spindle_off=True)
    assert sender.state == HALTING and sender.outcome is None
    sender.receive(b"<Hold:1|MPos:0.500,0.000,0.000|FS:300,0>\r\n", 0.2)
    assert SPINDLE_STOP not in sender.urgent_out() and sender.outcome is None
    sender.receive(b"<Hold:0|MPos:0.600,0.000,0.000|FS:0,0>\r\n", 0.3)
    assert SPINDLE_STOP in sender.urgent_out()


@pytest.mark.parametrize(("spindle_off", "state"), [(False, "Hold:0"), (True, "Idle")])
def test_the_spindle_stops_in_a_hold_alone_and_where_it_is_asked_for(spindle_off, state):
    sender = refused_line(spindle_off=spindle_off)
    sender.receive(f"<{state}|MPos:0.600,0.000,0.000|FS:0,0>\r\n".encode(), 0.3)
    assert SPINDLE_STOP not in sender.urgent_out()


@pytest.mark.parametrize("reports", [True, False])
def test_the_first_line_waits_for_a_report_of_where_the_machine_stands(reports):
    """Where the path is watched; but no longer than a report may take."""
    sender = new_sender(GrblModel(), watched=True)
    sender.give([WireLine(1, 1, 0, b"G1X1F100", (1.0, 0.0, 0.0))])
    left = {}
    for k in range(40):
        now = 10.0 + 0.05 * k
        if reports and k == 2:
            sender.receive(b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n", now)
        sender.tick(now)
        left |= {sender.bytes_out(): now}
    assert left[b"G1X1F100\n"] == pytest.approx(10.1 if reports else 10.0 + AGAIN, abs=0.06)


def test_a_stop_by_the_user_counts_more_than_the_end_that_was_under_way():
    sender = refused_line(spindle_off=True)
    sender.stop(0.2)
    sender.receive(b"\r\nGrbl 1.1h ['$' for help]\r\n", 0.3)
    wanted = stopped("stopped by the user", sender.protocol)
    assert sender.outcome.kind == wanted.kind and sender.outcome.exit_status == wanted.exit_status


def test_a_button_at_the_machine_is_no_answer_to_a_question_of_gcomp():
    """While a refused line is asked about, cycle start at the machine goes on with what it has; no
    further line leaves until a person has answered."""
    model = GrblModel()
    sender = new_sender(model, on_error="ask")
    seen = []
    run(
        sender,
        model,
        lines_of(BAD),
        actions=[
            (8.0, lambda s, now: model.write(b"~", now)),
            (20.0, lambda s, now: seen.append((s.state, bool(s.asks), s.tally.sent))),
            (40.0, lambda s, now: seen.append((s.state, bool(s.asks), s.tally.sent))),
            (40.1, lambda s, now: s.decide(False, now)),
        ],
    )
    assert seen[0] == seen[1] and seen[0][:2] == (HELD, True) and seen[0][2] < 41


IDLE, BUTTON = b"Idle", b"Hold:0"  # the second by a button at the machine


@pytest.mark.parametrize(
    "states, done",
    [
        ([IDLE], False),
        ([IDLE, IDLE], True),
        ([IDLE, BUTTON, IDLE, IDLE], False),  # the first report behind a hold ends the hold
        ([IDLE, BUTTON, IDLE, IDLE, IDLE], True),
    ],
)
def test_one_report_of_rest_is_not_the_end(states, done):
    """A report may have been on its way before the last motion began: two, asked for behind the
    last answer, and behind a hold two again."""
    sender = new_sender(GrblModel())
    sender.give([WireLine(1, 1, 0, b"G1X1F600")])
    sender.end()
    now = 0.0
    sender.tick(now)
    while sender.bytes_out():
        pass
    sender.receive(b"ok\r\n", 0.01)
    reports = 0
    while reports < len(states) and now < 5.0:
        now = round(now + 0.02, 3)
        sender.tick(now)
        if b"?" in sender.urgent_out() and now > 0.5:
            report = b"<%s|MPos:1.000,0.000,0.000|FS:0,0>\r\n" % states[reports]
            sender.receive(report, now + 0.005)
            reports += 1
    assert reports == len(states) and (sender.outcome is not None) == done


def emptied(sender: Sender) -> bytes:
    """All that the sender wants to write now."""
    return b"".join(iter(sender.bytes_out, b""))


@pytest.mark.parametrize("watched, at", [(True, 1.0), (False, 0.0)])
def test_where_the_path_is_watched_no_line_leaves_before_the_first_report(watched, at):
    """It says where the path begins; one that does not come is waited for for a second."""
    sender = new_sender(GrblModel(), watched=watched)
    sender.give([WireLine(1, 1, 0, b"G1X1F600")])
    left = []
    for k in range(60):
        sender.tick(k * 0.02)
        if b"G1X1F600" in emptied(sender):
            left.append(k * 0.02)
    assert left == [pytest.approx(at)]


def test_where_the_path_is_watched_the_first_report_lets_lines_leave():
    sender = new_sender(GrblModel(), watched=True)
    sender.give([WireLine(1, 1, 0, b"G1X1F600")])
    sender.tick(0.0)
    assert emptied(sender) == b"?"
    sender.receive(b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 0.02)
    sender.tick(0.03)
    assert b"G1X1F600" in emptied(sender)


def test_a_stop_waits_for_its_answer_though_the_computer_slept():
    """Its grace of a second is no time in which nobody looked: the answer was there to be read."""
    sender = new_sender(GrblModel())
    sender.give([WireLine(1, 1, 0, b"G1X1F600")])
    sender.tick(0.0)
    emptied(sender)
    sender.stop(0.1)
    sender.tick(0.12)
    sender.tick(7.12)
    assert sender.outcome is None
    sender.receive(b"\r\nGrbl 1.1h ['$' for help]\r\n", 7.13)
    assert sender.outcome.kind == "aborted" and "confirm" not in sender.outcome.text()


def test_each_pause_of_a_controller_is_reported():
    """Marlin says so again and again while it waits; an answer between two is the end of one."""
    sender = Sender(Marlin())
    sender.give([WireLine(k, k, 0, b"G1 X%d" % k) for k in (1, 2, 3)])
    now = 0.0
    for answer in (b"echo:busy: paused for user\n", b"echo:busy: paused for user\n", b"ok\n") * 2:
        sender.tick(now)
        emptied(sender)
        sender.receive(answer, now := now + 0.1)
    assert len([what for kind, what, _ in sender.log if kind == "hold"]) == 2


def test_a_check_says_nothing_of_where_the_tool_is():
    """In check mode nothing moves: no line may be executed, none is over."""
    sender = new_sender(GrblModel(), check=True)
    sender.give([WireLine(k, k, 0, b"G1X%d" % k, (k, 0.0, 0.0)) for k in (1, 2)])
    sender.tick(0.0)
    emptied(sender)
    sender.receive(b"[MSG:Enabled]\r\nok\r\n", 0.1)
    sender.tick(0.1)
    emptied(sender)
    sender.receive(b"ok\r\n<Check|MPos:0.000,0.000,0.000|FS:0,0>\r\n", 0.2)
    sender.lost("the port was closed", 0.3)
    assert sender.outcome.last_certain == 1
    assert (sender.outcome.at, sender.outcome.unsure) == (None, None)


def test_a_job_that_breaks_off_says_where_the_tool_is_and_what_may_not_be_over():
    """The last report lies on the second line's path, and that line was not answered."""
    sender = new_sender(GrblModel())
    lines = [WireLine(k, k, 0, b"G1X%d" % k, (k, 0.0, 0.0)) for k in (1, 2)]
    sender.give(lines)
    sender.tick(0.0)
    emptied(sender)
    sender.receive(b"ok\r\n<Run|MPos:1.500,0.000,0.000|FS:600,0>\r\n", 0.2)
    sender.lost("the port was closed", 0.3)
    assert sender.outcome.last_certain == 1
    assert (sender.outcome.at, sender.outcome.unsure) == (lines[1], lines[0])
    assert f"the tool is in {lines[1].where()}, by its last report" in sender.outcome.text()
    assert f"surely over is all before {lines[0].where()}" in sender.outcome.text()
