"""Marlin: numbers, checksums, resends, busy, windows (A1, A4, A8, A9, A10, A12, A13, A16 of
design/streaming.md)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from postproc.streaming import protocols
from postproc.streaming.events import (
    Accepted,
    Alarm,
    Altered,
    Busy,
    Message,
    Rejected,
    Restarted,
    Stray,
    Write,
)
from postproc.streaming.greeting import Greeting, unfit
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols._numbered import checksum
from postproc.streaming.protocols.marlin import Marlin
from postproc.streaming.sender import Sender
from tests.streaming.bench import Faults, lines_of, zigzag
from tests.streaming.models_marlin import MarlinModel
from tests.streaming.models_wire import greet, run

OWN = ["M110 N0", "M400", "M114"]


def job(
    text: str,
    model: MarlinModel,
    faults: Faults | None = None,
    counting: bool = True,
    ends=None,
    **how,
):
    sender = Sender(Marlin(counting))
    seconds = run(sender, model, lines_of(text, ends), faults, **how)
    return sender, seconds


def program(model: MarlinModel) -> list[str]:
    """What it executed of the program."""
    return [text for text in model.executed if text not in OWN]


def one_command_lines(n: int, seed: int = 1, feed: int = 6000) -> str:
    text, _ = zigzag(n, seed, feed)
    return (
        text.replace("G21G90G94", "G90")
        .replace("G1X", "G1 X")
        .replace("G1Y", "G1 Y")
        .replace("G1Z", "G1 Z")
    )


def test_checksum_is_the_xor_of_what_stands_before_the_star():
    """By hand, as Marlin's documentation of serial checksums prints it: N3 T0*57, N4 G92 E0*67
    (RepRap wiki, "G-code")."""
    assert (checksum(b"N3 T0"), checksum(b"N4 G92 E0")) == (57, 67)


def test_A13_a_lost_line_end_never_makes_two_lines_look_like_one():
    """The checksum of `a*c` + `b*d` read as one line is c ^ xor("*c") ^ d; equal to d it would have
    to be xor("*c") == c."""
    assert not [c for c in range(256) if checksum(b"*%d" % c) == c]


@pytest.mark.parametrize("counting", [True, False])
@pytest.mark.parametrize("advanced", [True, False])
def test_A1_every_line_is_executed_once_and_in_order(counting, advanced):
    text = one_command_lines(400)
    model = MarlinModel(advanced=advanced)
    sender, _ = job(text, model, counting=counting)
    assert sender.outcome.kind == "done", sender.outcome
    assert program(model) == text.split("\n")
    assert (model.dropped, model.unchecked) == (0, [])


def test_A13_the_window_is_what_advanced_ok_says_and_never_more():
    text = one_command_lines(300)
    for slots in (2, 4, 8):
        model = MarlinModel(advanced=True, slots=slots)
        sender, _ = job(text, model)
        assert sender.outcome.kind == "done"
        assert 1 < sender.tally.peak <= slots - 1 or slots == 2
        assert model.dropped == 0 and model.peak <= 127
    plain = MarlinModel()
    sender, _ = job(text, plain)
    assert sender.tally.peak == 1


def test_A3_advanced_ok_is_faster_than_one_line_at_a_time():
    text = one_command_lines(400, feed=60000)
    seconds = {}
    for advanced in (True, False):
        model = MarlinModel(advanced=advanced)
        sender, seconds[advanced] = job(text, model, tick=0.001)
        assert sender.outcome.kind == "done"
    assert seconds[True] < 0.8 * seconds[False]


def flips(text: str, line: int, what: str) -> Faults:
    """A fault on a byte in the middle of a line on its way to the printer."""
    before = sum(
        len(f"N{i} {row}*99\n") for i, row in enumerate(["M110 N0", *text.split("\n")[: line - 1]])
    )
    return Faults(to={before + 6: what})


@pytest.mark.parametrize("line", [1, 2, 57, 100])
@pytest.mark.parametrize("what", ["flip", "drop", "double"])
@pytest.mark.parametrize("kind", ["plain", "advanced", "no ok behind a request"])
def test_A13_resend_at_any_line(line, what, kind):
    text = one_command_lines(100)
    model = MarlinModel(advanced=kind == "advanced", own_ok=kind != "no ok behind a request")
    sender, _ = job(text, model, flips(text, line, what))
    assert sender.outcome.kind == "done", sender.outcome
    assert program(model) == text.split("\n")


def heard(*texts: bytes, lines: int = 3, counting: bool = True, advanced: bool = False):
    """Events after a greeting of M110 and some lines that were sent and answered, the last one
    not."""
    protocol = Marlin(counting)
    ok = b"ok N%d P15 B3\n" if advanced else b"ok\n"
    protocol.send(-1, b"M110 N0")
    protocol.receive(ok % 0 if advanced else ok)
    for number in range(1, lines + 1):
        protocol.send(number, b"G1 X%d" % number)
        if number < lines:
            protocol.receive(ok % number if advanced else ok)
    return protocol, [protocol.receive(text) for text in texts]


def test_A13_a_request_is_answered_with_the_line_and_its_own_ok_is_none():
    protocol, events = heard(b"Error:checksum mismatch, Last Line: 2\nResend: 3\nok\n", b"ok\n")
    body = b"N3 G1 X3"
    assert [e for e in events[0] if isinstance(e, Write)] == [
        Write(body + b"*%d\n" % checksum(body))
    ]
    assert not [e for e in events[0] if isinstance(e, Accepted)]
    assert events[1] == [Accepted(3)] and protocol.outstanding() == []


def test_A13_two_requests_for_one_line():
    _, events = heard(
        b"Error:checksum mismatch, Last Line: 2\nResend: 3\nok\nError:checksum mismatch, Last Line:"
        b" 2\nrs 3\nok\n",
        b"ok\n",
    )
    assert len([e for e in events[0] if isinstance(e, Write)]) == 2
    assert events[1] == [Accepted(3)]


@pytest.mark.parametrize(
    "said",
    [
        b"Resend: 34497\nok\n",
        b"Resend: 40\n",
        b"rs 0\n",
        b"Error:checksum mismatch, Last Line: 2\nResend: 2\n",
    ],
)
def test_A13_a_number_that_can_not_be_meant_is_not_followed(said):
    """OctoPrint issue 4671: 34497 was read where 134497 was asked for."""
    protocol, events = heard(said)
    assert (
        not [e for e in events[0] if isinstance(e, Write | Altered | Accepted)] or said == b"rs 0\n"
    )
    assert protocol.outstanding() == [3]


def test_A13_requests_in_a_row_are_bounded():
    _, events = heard(b"Error:checksum mismatch, Last Line: 2\nResend: 3\nok\n" * 11)
    assert len([e for e in events[0] if isinstance(e, Write)]) == 10
    assert isinstance(events[0][-1], Message | Altered) and [
        e for e in events[0] if isinstance(e, Altered)
    ]


def test_A13_a_request_for_a_line_that_was_answered_ends_the_job():
    """It was executed without its number, or its answer was another's: sent again it might be
    executed twice."""
    _, events = heard(b"Error:Line Number is not Last Line Number+1, Last Line: 1\nResend: 2\nok\n")
    assert isinstance(events[0][-2], Altered) or isinstance(events[0][1], Altered)


def test_A13_a_request_for_the_next_line_says_that_this_one_is_there():
    protocol, events = heard(
        b"Error:Line Number is not Last Line Number+1, Last Line: 3\nResend: 4\nok\n"
    )
    assert [e for e in events[0] if isinstance(e, Accepted)] == [Accepted(3)]
    assert protocol.outstanding() == [] and not [e for e in events[0] if isinstance(e, Stray)]


def test_A4_other_words_are_no_answers():
    text = (
        b"echo:busy: processing\n T:21.3 /0.0 B:20.0 /0.0 @:0\n//action:pause\necho:SD init"
        b" fail\nokay\nok?\nxok\nX:1.00 Y:2.00 Z:3.00 E:0 Count X:80 Y:160 Z:1200\n\n\r\nwait\n"
    )
    protocol, events = heard(text)
    assert not [e for e in events[0] if isinstance(e, Accepted | Stray | Write)]
    assert [e for e in events[0] if isinstance(e, Busy)]
    assert protocol.outstanding() == [3]


@given(st.lists(st.integers(1, 9), max_size=60))
def test_A4_answers_may_be_cut_anywhere(sizes):
    data = (
        b"echo:busy: processing\nError:checksum mismatch, Last Line: 2\nResend: 3\nok\n T:20"
        b" /0\nok\n"
    )
    protocol, _ = heard()
    events, at = [], 0
    for size in [*sizes, len(data)]:
        events += protocol.receive(data[at : at + size])
        at += size
    assert [e for e in events if isinstance(e, Accepted)] == [Accepted(3)]


def test_A12_wait_twice_sends_the_numbered_line_again():
    protocol, events = heard(b"wait\n", b"wait\n")
    assert events[0] == [] and isinstance(events[1][0], Write)
    assert protocol.receive(
        b"Error:Line Number is not Last Line Number+1, Last Line: 3\nResend: 4\nok\n"
    )[1:2] == [Accepted(3)]


@pytest.mark.parametrize("says_wait", [True, False])
def test_A12_a_lost_ok_is_found_and_nothing_is_executed_twice(says_wait):
    text = one_command_lines(60)
    model = MarlinModel(says_wait=says_wait)
    sender, seconds = job(text, model, Faults(back={90: "drop"}))
    assert sender.outcome.kind == "done", sender.outcome
    assert program(model) == text.split("\n")
    assert seconds < 45


def test_A12_a_long_command_is_no_stall():
    model = MarlinModel()
    sender, seconds = job("G90\nG28\nG1 X5 F600\nG4 S120\nG1 X100 F60\nG1 X90 F600", model)
    assert sender.outcome.kind == "done" and seconds > 200
    assert program(model) == ["G90", "G28", "G1 X5 F600", "G4 S120", "G1 X100 F60", "G1 X90 F600"]


def test_A12_silence_ends_the_job():
    model = MarlinModel()
    sender, seconds = job(one_command_lines(60), model, Faults(stall=(0.1, 1e9)))
    assert sender.outcome.kind == "stalled" and sender.outcome.unanswered and seconds < 200


def test_A9_start_in_the_middle_of_a_job():
    model = MarlinModel()
    sender, _ = job(one_command_lines(200, feed=1200), model, Faults(reset=1.0))
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("reset", 12)


def test_A10_a_closed_port():
    model = MarlinModel()
    sender, seconds = job(one_command_lines(200), model, Faults(cut=0.5))
    assert sender.outcome.kind == "disconnected" and seconds < 0.6


@pytest.mark.parametrize(
    "said",
    [
        "Error:Printer halted. kill() called!\n",
        "!! Lost communication with MCU\n",
        "Error:Heating failed, system stopped!\n",
    ],
)
def test_a_firmware_that_stops_is_an_alarm(said):
    model = MarlinModel()
    sender, _ = job(
        one_command_lines(200), model, actions=[(0.5, lambda s, now: s.receive(said.encode(), now))]
    )
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("alarm", 11)
    protocol = Marlin()
    assert [type(e) for e in protocol.receive(said.encode())] == [Alarm]


@pytest.mark.parametrize("advanced", [True, False])
def test_A5_an_unknown_command_is_a_refused_line(advanced):
    text = one_command_lines(40).replace("\n", "\nG77 X1\n", 1)
    model = MarlinModel(advanced=advanced)
    sender, _ = job(text, model)
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("error", 10)
    assert "source line 2" in sender.outcome.message and "G77 X1" in sender.outcome.message
    assert len(program(model)) <= 5


def test_a_line_that_lost_its_n_is_sent_again_and_not_taken_for_refused():
    protocol, events = heard(b'echo:Unknown command: "3 G1 X3"\n', b"ok\n", b"ok\n")
    assert [e for e in events[0] if isinstance(e, Write)]
    assert not [e for e in events[0] + events[1] if isinstance(e, Accepted | Rejected)]
    assert events[2] == [Accepted(3)] and protocol.outstanding() == []


def test_A8_hold_sends_nothing_more_and_resume_goes_on():
    text = one_command_lines(300, feed=1200)
    model = MarlinModel()
    seen = []
    actions = [
        (1.0, lambda s, now: s.hold(now)),
        (1.1, lambda s, now: seen.append(s.tally.sent)),
        (20.0, lambda s, now: seen.append(s.tally.sent)),
        (20.1, lambda s, now: s.resume(now)),
    ]
    sender, _ = job(text, model, actions=actions)
    assert seen[0] == seen[1] and sender.outcome.kind == "done"
    assert program(model) == text.split("\n")


def test_A8_a_stop_of_the_program_goes_on_with_resume():
    model = MarlinModel()
    sender, seconds = job(
        "G90\nG1 X1 F600\nM0\nG1 X2", model, actions=[(30.0, lambda s, now: s.resume(now))]
    )
    assert sender.outcome.kind == "done" and seconds > 30 and program(model)[-1] == "G1 X2"


def test_A8_stop_stops_what_is_planned():
    model = MarlinModel()
    sender, seconds = job(
        one_command_lines(300, feed=60), model, actions=[(2.0, lambda s, now: s.stop(now))]
    )
    assert (sender.outcome.kind, seconds < 3.5) == ("aborted", True)
    model.advance(model.now + 1)
    assert not model.moves.ends


def test_A16_the_place_at_the_end_is_compared():
    model = MarlinModel()
    sender, _ = job("G90\nG1 X1 F600", model, ends=[(0, 0, 0), (1, 0, 0)])
    assert sender.outcome.kind == "done"
    sender = Sender(Marlin())
    sender.protocol._steps = (80.0, 80.0, 400.0)
    run(sender, MarlinModel(), lines_of("G90\nG1 X1 F600", [(0, 0, 0), (2, 0, 0)]))
    assert sender.outcome.kind == "altered" and "1.000 mm" in sender.outcome.message


def test_A16_done_is_said_when_the_motion_has_ended():
    model = MarlinModel()
    sender, seconds = job("G90\nG1 X2 F60", model)
    assert sender.outcome.kind == "done" and seconds > 2.0


# -- what it says of itself ------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["auto", "marlin"])
def test_the_greeting_learns_name_place_and_zero(name):
    model = MarlinModel()
    model.moves.place, model.zero = [10.0, 20.0, 5.0], [10.0, 0.0, 0.0]
    greeting = greet(Greeting(name), model)
    assert greeting.fault is None, greeting.fault
    controller = greeting.protocol.controller
    assert (controller.name, controller.version) == ("Marlin", "2.1.2")
    assert greeting.status.place == (10.0, 20.0, 5.0)
    assert controller.offsets == ["[G54:10.000,0.000,0.000]"]
    assert unfit(greeting.protocol, greeting.status) is None


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("M420 S1 Z0.00", "levelling"),
        ("M425 F1.00 S0.00 X0.05 Y0.00 Z0.00", "backlash of X, 50 um"),
        ("M852 I0.0010 J0.0 K0.0", "square"),
    ],
)
def test_a_firmware_that_compensates_is_refused(line, said):
    greeting = greet(Greeting("marlin"), MarlinModel(settings=(line,)))
    fault = unfit(greeting.protocol, greeting.status)
    assert fault is not None and said in fault.message


@pytest.mark.parametrize(
    "banner",
    [
        "FIRMWARE_NAME:Marlin 2.1.2 (x)",
        "FIRMWARE_NAME:Virtual Marlin 1.0 PROTOCOL_VERSION:1.0",
        "start\nMarlin 1.1.9\n",
    ],
)
def test_its_names_are_recognised_and_by_nobody_else(banner):
    assert protocols.recognised(banner) == ["marlin"]


def test_A7_lines_are_cleaned_or_refused():
    protocol = Marlin()
    assert protocol.prepare(b"N10 g1 x1 (to the edge; yes) ; all of it") == b"G1 X1"
    assert protocol.prepare(b"M117 Hello") == b"M117 Hello"
    assert protocol.prepare(b"; only") == b"" == protocol.prepare(b"%")
    for bad in (b"G1 X1*7", b"G1 X\xb5", b"M117 a\\b", b"M110 N5", b"M28 x.g", b"G1 X" + b"1" * 90):
        with pytest.raises(Unsendable):
            protocol.prepare(bad)


def test_restarted_voids_what_was_sent():
    protocol, events = heard(b"start\n")
    assert isinstance(events[0][0], Restarted) and protocol.outstanding() == []


@pytest.mark.parametrize(
    ("unit", "place"), [("G21    ; (mm)", (10.0, 0.0, 5.0)), ("G20 ; (in)", None)]
)
def test_steps_of_a_firmware_in_inches_say_no_place(unit, place):
    """M92.cpp: LINEAR_UNIT divides 80 steps/mm by 25.4 under G20: X 10 mm would be 254 mm."""
    protocol = Marlin()
    steps = "X80.00 Y80.00 Z400.00" if place else "X3.15 Y3.15 Z15.75"
    protocol.learn(b"M503 S0", [f"echo:  {unit}", f"echo:  M92 {steps}"])
    assert protocol.place((0.0, 0.0, 0.0), " E:0.00 Count X:800 Y:0 Z:2000") == place
    assert protocol.controller.modal == ([] if place else ["G20"])
