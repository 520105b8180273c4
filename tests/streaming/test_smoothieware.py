"""Smoothieware: numbered lines, an ok a code, halts, reports (A1, A4, A5, A8, A9, A12, A13, A16 of
design/streaming.md)."""

from __future__ import annotations

import pytest

from postproc.streaming import protocols
from postproc.streaming.events import Accepted, Alarm, Status, Write
from postproc.streaming.greeting import Greeting, unfit
from postproc.streaming.live import read
from postproc.streaming.protocols.marlin import Marlin
from postproc.streaming.protocols.smoothieware import Smoothieware
from postproc.streaming.sender import Sender
from tests.streaming.bench import Faults, lines_of, zigzag
from tests.streaming.models_smoothie import SmoothieModel
from tests.streaming.models_wire import greet, run


def job(text: str, model: SmoothieModel, faults: Faults | None = None, ends=None, **how):
    """With what the greeting learns about oks."""
    protocol = Smoothieware()
    protocol._each = not model.per_line
    sender = Sender(protocol)
    seconds = run(sender, model, lines_of(text, ends), faults, **how)
    return sender, seconds


def program(model: SmoothieModel) -> list[str]:
    return [text for text in model.executed if text != "M400"]


MIXED = "G21G90\n" + "\n".join(
    f"G0X{i}Y{i}\nG1X{i}F6000M8\nG90G1Y{i}\nM3S1000G4P1" for i in range(30)
)


@pytest.mark.parametrize("per_line", [True, False])
@pytest.mark.parametrize("glued", [True, False])
def test_A1_every_line_is_executed_once_whatever_its_oks(per_line, glued):
    text, ends = zigzag(200)
    for rows, where in ((text, ends), (MIXED, None)):
        model = SmoothieModel(per_line=per_line, glued=glued)
        sender, _ = job(rows, model, ends=where)
        assert sender.outcome.kind == "done", sender.outcome
        assert (
            program(model) == [row.replace(" ", "") for row in rows.split("\n")]
            and model.dropped == 0
        )


@pytest.mark.parametrize("what", ["flip", "drop", "double"])
@pytest.mark.parametrize("at", [20, 333, 1500])
def test_A13_a_damaged_line_is_sent_again(what, at):
    text, ends = zigzag(150)
    model = SmoothieModel()
    sender, _ = job(text, model, Faults(to={at: what}), ends=ends)
    assert sender.outcome.kind in ("done", "altered", "alarm")
    assert sender.outcome.kind != "done" or program(model) == [
        row.replace(" ", "") for row in text.split("\n")
    ]


def test_A13_rs_is_answered_with_the_line():
    protocol = Smoothieware()
    protocol.send(-1, b"M110 N0")
    protocol.receive(b"ok\r\n")
    data = protocol.send(1, b"G1X1")
    assert Write(data) in protocol.receive(b"rs N1\r\n")
    assert protocol.receive(b"ok\r\n") == [Accepted(1)]  # a request has no ok of its own here


def test_A4_an_ok_behind_a_report_without_a_line_end_counts():
    protocol = Smoothieware()
    protocol.send(1, b"G1X1")
    events = protocol.receive(
        b"<Run|MPos:1.0000,2.0000,3.0000|WPos:0.0000,2.0000,3.0000|F:1.0>ok\r\n"
    )
    assert (
        isinstance(events[0], Status)
        and events[0].place == (1.0, 2.0, 3.0)
        and events[1] == Accepted(1)
    )
    assert protocol.controller.offsets == ["[G54:1.000,0.000,0.000]"]


@pytest.mark.parametrize(
    "said",
    [
        b"!!\r\n",
        b"error:Alarm lock\n",
        b"ALARM: Hard limit +X\n",
        b"Error: unknown\r\n",
        b"Entering Alarm/Halt state\n",
    ],
)
def test_halts_are_alarms(said):
    assert isinstance(Smoothieware().receive(said)[0], Alarm)


def test_A5_a_refused_line_halts_it():
    text = zigzag(60)[0].replace("\nG1X", "\nG77X", 1).replace("\nG1 X", "\nG77 X", 1)
    sender, _ = job(text, SmoothieModel())
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("alarm", 11)


def test_A8_hold_resume_and_stop():
    text, ends = zigzag(200, feed=1200)
    model = SmoothieModel()
    held = []
    actions = [
        (1.0, lambda s, now: s.hold(now)),
        (2.0, lambda s, now: held.append(model._hold)),
        (4.0, lambda s, now: s.resume(now)),
    ]
    sender, _ = job(text, model, ends=ends, actions=actions)
    assert (
        held == [True]
        and sender.outcome.kind == "done"
        and program(model) == [row.replace(" ", "") for row in text.split("\n")]
    )
    model = SmoothieModel()
    sender, _ = job(text, model, actions=[(1.0, lambda s, now: s.stop(now))])
    assert sender.outcome.kind == "aborted" and model.halted


def test_A9_A10_A12_restart_closed_port_and_silence():
    text, _ = zigzag(200, feed=1200)
    assert job(text, SmoothieModel(), Faults(reset=1.0))[0].outcome.kind == "reset"
    assert job(text, SmoothieModel(), Faults(cut=1.0))[0].outcome.kind == "disconnected"
    assert job(text, SmoothieModel(), Faults(stall=(1.0, 1e9)))[0].outcome.kind == "disconnected"


@pytest.mark.parametrize("per_line", [True, False])
@pytest.mark.parametrize("name", ["auto", "smoothieware"])
def test_the_greeting_learns_how_it_answers(per_line, name):
    model = SmoothieModel(per_line=per_line)
    model.zero = [1.0, 0.0, 0.0]
    greeting = greet(Greeting(name), model)
    assert greeting.fault is None, greeting.fault
    protocol = greeting.protocol
    assert (
        protocol.title == "Smoothieware"
        if hasattr(protocol, "title")
        else protocol.controller.name == "Smoothieware"
    )
    assert protocol._each is not per_line and protocol.controller.version == "edge-abc123"
    assert protocol.controller.offsets == ["[G54:1.000,0.000,0.000]"]
    assert unfit(protocol, greeting.status) is None


@pytest.mark.parametrize("inches", [False, True])
def test_places_come_in_the_unit_in_force(inches):
    """Kernel.cpp: robot->from_millimeters(mpos): in G20 50.8 mm are reported as 2.0."""
    model = SmoothieModel()
    model.inches, model.moves.place, model.zero = inches, [50.8, 0.0, 25.4], [25.4, 0.0, 0.0]
    greeting = greet(Greeting("smoothieware"), model)
    assert greeting.fault is None and greeting.protocol is not None
    live = read(greeting.protocol.controller, greeting.status, ("X", "Y", "Z"))
    assert live.place == pytest.approx({"X": 50.8, "Y": 0.0, "Z": 25.4})
    assert live.work["G54"] == pytest.approx({"X": 25.4, "Y": 0.0, "Z": 0.0})
    assert live.modal[:4] == ("G0", "G54", "G17", "G20" if inches else "G21")


def test_an_older_build_does_not_say_its_modes():
    model = SmoothieModel()
    model.says_modes = False
    greeting = greet(Greeting("smoothieware"), model)
    assert greeting.fault is None and greeting.protocol.controller.modal == []


def test_A16_done_is_said_of_a_program_in_inches():
    """It ends at X2 inches, which is where its last line ends: 50.8 mm."""
    sender, _ = job("G20\nG90\nG1 X2 F100", SmoothieModel(), ends=[(0, 0, 0)] * 2 + [(50.8, 0, 0)])
    assert sender.outcome.kind == "done", sender.outcome


def test_A12_a_dwell_may_last():
    assert Smoothieware().patience(b"G4 S200") == 230.0
    assert Marlin().patience(b"G04 S60") == 90.0 and Marlin().patience(b"G4 P2000") == 32.0


def test_oks_of_lines_with_several_codes():
    """GcodeDispatch.cpp: an ok for each code, up to and with a G1, which is answered before it is
    planned."""
    protocol = Smoothieware()
    protocol._each = True
    counts = {
        b"G1X1": 1,
        b"G90G21": 2,
        b"G90G1X1M8": 2,
        b"G1X1M8": 1,
        b"M3S100": 1,
        b"G53G0X1": 1,
        b"G0X1M5M9": 3,
    }
    assert {text: protocol.answers(text) for text in counts} == counts


@pytest.mark.parametrize(
    "banner",
    [
        "Smoothie\r\nok\r\n",
        "FIRMWARE_NAME:Smoothieware, X",
        "<Idle|MPos:0.0,0.0,0.0|WPos:0.0,0.0,0.0>",
        "Build version: edge-94de12c, Build date: Oct 28 2019",
    ],
)
def test_its_names_are_recognised_and_by_nobody_else(banner):
    assert protocols.recognised(banner) == ["smoothieware"]
