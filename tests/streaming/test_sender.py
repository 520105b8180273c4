"""How a job ends, each way by itself (A5, A6, A8, A9, A10, A12, A15, A16 of
design/streaming.md)."""

from __future__ import annotations

import pytest

from postproc.streaming.events import Status
from postproc.streaming.limits import Limits
from postproc.streaming.outcome import STATUS
from postproc.streaming.protocols.marlin import Marlin
from postproc.streaming.protocols.tinyg import TinyG
from postproc.streaming.sender import Sender
from tests.streaming.bench import Faults, lines_of, new_sender, run, zigzag
from tests.streaming.grbl_model import GrblModel

SLOW = "\n".join(["G21G90G94F600", *(f"G1X{i}" for i in range(1, 41))])  # 0.1 s a line


def test_A16_done_is_said_when_the_machine_stands_still_and_not_before():
    model = GrblModel()
    sender = new_sender(model)
    seconds = run(sender, model, lines_of("G21G90G94F60\nG1X1\nG1X2"))
    assert seconds > 2.0  # 2 mm at 60 mm/min
    assert (sender.outcome.kind, sender.outcome.exit_status, model.place) == ("done", 0, [2, 0, 0])
    assert sender.tally.answered == sender.tally.sent == 3 and not sender.waiting


def test_gcomps_own_lines_are_numbered_below_zero():
    """0 stands for no line, lines of the program begin at 1."""
    sender = Sender(Marlin())
    sender.tick(0.0)
    sender.bytes_out()
    assert [(line.number, line.text) for line in sender.waiting] == [(-1, b"M110 N0")]


def test_A16_every_end_has_its_own_exit_status():
    assert len(set(STATUS.values())) == len(STATUS) and STATUS["done"] == 0


def test_A16_a_machine_that_stands_elsewhere_is_no_success():
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of("G21G90G94F600\nG1X1", ends=[(0, 0, 0), (1.5, 0, 0)]))
    assert sender.outcome.kind == "altered" and "0.500 mm" in sender.outcome.message


def test_behind_a_line_whose_end_is_not_known_no_place_is_judged():
    """G28 in the middle of a job, or a macro's probe: what the line before said of the end says
    nothing any more."""
    model = GrblModel()
    sender = new_sender(model)
    run(
        sender,
        model,
        lines_of("G21G90G94F600\nG1X1\nG28X0\nM30", ends=[(0, 0, 0), (1, 0, 0), (), ()]),
    )
    assert (sender.outcome.kind, model.place) == ("done", [0.0, 0.0, 0.0])


def test_A5_an_error_holds_at_once_and_nothing_more_leaves():
    text = SLOW.replace("G1X20", "G1X20Q9Q9")
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of(text))
    outcome = sender.outcome
    assert (outcome.kind, outcome.exit_status) == ("error", 10)
    assert (
        "source line 21, sent as wire line 21: G1X20Q9Q9" in outcome.message
        and "error:20" in outcome.message
    )
    assert model.state == "Hold"
    behind = [line.number for line in outcome.unanswered]
    # named, and nothing behind them has left
    assert behind == list(range(22, 22 + len(behind))) and behind
    assert f"it had {len(behind)} more lines" in outcome.advice
    assert sender.tally.sent == 21 + len(behind)


def test_A5_hold_leaves_within_50_ms_of_the_error():
    model = GrblModel()
    sender = new_sender(model)
    sender.give(lines_of("G21\nG77"))
    sender.end()
    sender.tick(0.0)
    while sender.bytes_out():
        pass
    sender.receive(b"ok\r\nerror:20\r\n", 0.5)
    assert sender.bytes_out() == b"!"


def test_A5_on_error_continue_goes_to_the_end_and_is_no_success():
    text = SLOW.replace("G1X20", "G1X20Q9").replace("G1X30", "G77X1")
    model = GrblModel()
    sender = new_sender(model, on_error="continue")
    run(sender, model, lines_of(text))
    assert (sender.outcome.kind, len(sender.outcome.rejected)) == ("error", 2)
    assert "source line 31" in sender.outcome.message and model.place[0] == 40
    assert len(model.received) == sender.tally.answered == 41


def test_A8_hold_resume_loses_and_doubles_nothing():
    text, ends = zigzag(300, feed=1200)
    model = GrblModel()
    sender = new_sender(model)
    states = []

    def look(sender, now):
        states.append((model.state, len(model.received)))

    actions = [
        (0.5, lambda s, now: s.hold(now)),
        (1.2, look),
        (2.5, look),
        (2.6, lambda s, now: s.resume(now)),
    ]
    run(sender, model, lines_of(text, ends), actions=actions)
    assert states[0][0] == states[1][0] == "Hold"
    assert (sender.outcome.kind, model.dropped) == ("done", 0)
    assert model.received == [line.replace(" ", "") for line in text.split("\n")]


def test_A8_hold_passes_lines_that_wait_in_a_blocked_writer():
    model = GrblModel()
    sender = new_sender(model)
    sender.give(lines_of(SLOW))
    sender.tick(0.0)
    data = sender.bytes_out()  # the status request
    data = sender.bytes_out()
    sender.unwritten(data[5:])
    sender.hold(0.01)
    assert sender.bytes_out() == b"!"
    assert data[5:].startswith(sender.bytes_out()[:1])


def test_A8_stop_resets_and_names_what_is_not_certain():
    model = GrblModel()
    sender = new_sender(model)
    seconds = run(
        sender,
        model,
        lines_of(SLOW),
        actions=[(1.0, lambda s, now: s.hold(now)), (1.5, lambda s, now: s.stop(now))],
    )
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("aborted", 130)
    assert seconds < 2.6 and sender.outcome.unanswered and model.state == "Idle"


def test_A9_a_restart_in_the_middle_stops_everything():
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of(SLOW), Faults(reset=1.0))
    outcome = sender.outcome
    assert (outcome.kind, outcome.exit_status) == ("reset", 12)
    assert (
        "restarted" in outcome.message and outcome.unanswered[0].number == outcome.last_certain + 1
    )
    assert sender.bytes_out() in (b"", b"?")  # nothing is sent again


def test_A10_a_closed_port_and_a_silent_controller_are_known_within_two_seconds():
    model = GrblModel()
    sender = new_sender(model)
    assert run(sender, model, lines_of(SLOW), Faults(cut=1.0)) < 1.1
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("disconnected", 13)
    model = GrblModel()
    sender = new_sender(model)
    assert run(sender, model, lines_of(SLOW), Faults(stall=(1.0, 1e9))) < 1.0 + 2.0 + 0.3
    assert sender.outcome.kind == "disconnected" and "said nothing" in sender.outcome.message


def test_A10_a_pause_that_is_shorter_is_none():
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of(SLOW), Faults(stall=(1.0, 1.5)))
    assert sender.outcome.kind == "done" and model.place[0] == 40


@pytest.mark.parametrize("text", ["ALARM:1\r\n", "<Alarm|MPos:0.000,0.000,0.000|FS:0,0>\r\n"])
def test_an_alarm_ends_the_job(text):
    model = GrblModel()
    sender = new_sender(model)
    run(
        sender, model, lines_of(SLOW), actions=[(1.0, lambda s, now: s.receive(text.encode(), now))]
    )
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("alarm", 11)


@pytest.mark.parametrize("begins", [0.3, 0.8, 1.3])
def test_A12_a_computer_that_slept_hears_no_silence_and_sees_no_stall(begins):
    """Its own loop stood for 7 s: the answers of that time were there to be read, and nothing is
    concluded before they are."""
    text, ends = zigzag(120, feed=600)
    made = GrblModel()
    sender = new_sender(made, watched=True)
    run(sender, made, lines_of(text, ends), Faults(asleep=(begins, 7.0)))
    assert sender.outcome.kind == "done", sender.outcome
    assert made.accepted == [line.replace(" ", "") for line in text.split("\n")]


def test_A12_a_lost_ok_is_a_stall_with_its_lines_and_nothing_is_sent_again():
    model = GrblModel()
    sender = new_sender(model)
    lost = []

    def lose(sender, now):  # the next answer vanishes
        original = sender.protocol.receive

        def receive(data):
            if b"ok\r\n" in data and not lost:
                lost.append(1)
                data = data.replace(b"ok\r\n", b"", 1)
            return original(data)

        sender.protocol.receive = receive

    run(sender, model, lines_of(SLOW), actions=[(1.0, lose)])
    outcome = sender.outcome
    assert (outcome.kind, outcome.exit_status) == ("stalled", 14)
    assert "stands still (idle)" in outcome.message and "wire line" in outcome.message
    assert model.received == SLOW.split("\n")  # each once


@pytest.mark.parametrize("line", ["G4P20", "G1X100F300", "G1X40F120"])
def test_A12_a_long_dwell_or_motion_is_no_stall(line):
    model = GrblModel()
    sender = new_sender(model)
    seconds = run(sender, model, lines_of(f"G21G90G94F600\nG1X1\n{line}\nG4P0\nG1X2F6000"))
    assert sender.outcome.kind == "done" and seconds > 15


def test_a_stop_of_the_program_waits_for_the_person():
    model = GrblModel()
    sender = new_sender(model)
    run(
        sender,
        model,
        lines_of("G21G90F600\nG1X1\nM0\nG1X2"),
        actions=[(30.0, lambda s, now: s.resume(now))],
    )
    assert sender.outcome.kind == "done" and model.place[0] == 2


def test_A15_check_mode_lists_every_error_and_moves_nothing():
    rows = SLOW.split("\n")
    rows[5], rows[17] = "G1X5Q1", "G77"
    model = GrblModel()
    sender = new_sender(model, check=True)
    run(sender, model, lines_of("\n".join(rows)))
    outcome = sender.outcome
    assert [line.source for line, _ in outcome.rejected] == [6, 18]
    assert outcome.kind == "error" and "source line 18" in outcome.message
    assert model.received[0] == model.received[-1] == "$C"
    assert model.state == "Idle" and model.place == [0, 0, 0]


def test_A15_check_mode_without_errors():
    model = GrblModel()
    sender = new_sender(model, check=True)
    run(sender, model, lines_of(SLOW))
    assert (
        sender.outcome.kind == "done"
        and "none refused" in sender.outcome.message
        and model.state == "Idle"
    )


def test_A4_an_answer_too_many_is_found():
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of(SLOW), actions=[(1.0, lambda s, now: s.receive(b"ok\r\n", now))])
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("drift", 15)


def test_A17_the_log_gives_back_what_was_sent():
    text, ends = zigzag(200)
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of(text, ends))
    sent = [what for kind, what, _ in sender.log if kind == "sent"]
    answered = [what for kind, what, _ in sender.log if kind == "answered"]
    assert b"\n".join(line.text for line in sent).decode() == text
    assert sent == answered
    assert any(isinstance(what, Status) for _, what, _ in sender.log)


def test_the_log_has_every_line_with_its_answer_and_what_the_controller_says():
    sender = new_sender(GrblModel())
    lines = lines_of("G21\nG77\nG90")
    sender.give(lines)
    sender.tick(0.0)
    sender.receive(b"ok\r\nerror:20\r\n[MSG:Check Door]\r\n", 0.5)
    assert sender.log[:3] == [("sent", line, 0.0) for line in lines]
    assert sender.log[3:5] == [("answered", lines[0], 0.5), ("rejected", lines[1], 0.5)]
    assert [what for what, text, _ in sender.log[5:] if "Check Door" in str(text)] == ["told"]


@pytest.mark.parametrize(("counting", "least"), [(True, 0.95), (False, 0.80)])
def test_A3_the_wire_is_full_at_115200_baud(counting, least):
    """30 bytes a line: 384 lines/s are the wire; one at a time adds the answer's 4 bytes: 339
    lines/s, and the bench's tick."""
    rows = ["G21G90G94"] + [
        f"G1X{i % 10 / 10:.4f}Y{i % 7 / 10:.5f}Z0.00{i % 9}F60000" for i in range(600)
    ]
    model = GrblModel()
    sender = new_sender(model, counting)
    run(sender, model, lines_of("\n".join(rows)), tick=0.0005)
    times = [t for kind, _, t in sender.log if kind in ("sent", "answered")]
    part = sender.tally.bytes / (times[-1] - times[0]) / 11520
    assert sender.outcome.kind == "done" and least <= part <= 1.0


def test_after_the_end_of_a_job_no_order_writes_anything():
    model = GrblModel()
    sender = new_sender(model)
    now = run(sender, model, lines_of("G21G90G94F600\nG1X1")) + 5.0
    ended = sender.outcome
    for order in (sender.hold, sender.resume, sender.stop, lambda t: sender.give_up("gone", t)):
        order(now)
        sender.tick(now)
        assert sender.outcome is ended and not sender.bytes_out() and not sender.urgent_out()


def test_reading_nothing_is_no_sign_of_life():
    sender = new_sender(GrblModel())
    sender.give(lines_of("G21G90G94F600\nG1X1"))
    now = 0.0
    while sender.outcome is None and now < 60.0:
        sender.tick(now)
        sender.bytes_out()
        sender.receive(b"", now)
        now += 0.05
    assert sender.outcome is not None and sender.outcome.kind == "disconnected"


def test_a_line_that_comes_late_through_a_pipe_is_waited_for_from_then_on():
    """Before it nothing was sent, so that nothing was due."""
    sender = Sender(TinyG(), Limits())
    patience = sender.protocol.patience(b"G1X1")
    ticks = int((patience + 10.0) / 0.05)
    for k in range(ticks):
        sender.tick(k * 0.05)
    sender.give(lines_of("G1X1"))
    written = b""
    for k in range(ticks, ticks + 20):
        sender.tick(k * 0.05)
        written += sender.bytes_out()
    assert written == b"G1X1\n" and sender.waiting and sender.outcome is None
