"""Holds: ordered, made by somebody else, and lost on the way; questions about refused lines; what a
stop really did (A5, A8)."""

from __future__ import annotations

import pytest

from postproc.streaming import protocols
from postproc.streaming.endings import stopped
from postproc.streaming.holds import AGAIN, FOREIGN, RESUMED, Hold
from postproc.streaming.sender import HELD, RUNNING, Sender
from tests.streaming.bench import lines_of, new_sender, run
from tests.streaming.grbl_model import GrblModel
from tests.streaming.models_marlin import MarlinModel
from tests.streaming.models_smoothie import SmoothieModel
from tests.streaming.models_tinyg import TinyGModel

SLOW = "\n".join(["G21G90G94F600", *(f"G1X{i}" for i in range(1, 41))])  # 0.1 s a line
BAD = SLOW.replace("G1X20", "G1X20Q9").replace("G1X30", "G77X1")


def job(text: str, model, protocol: str, **how):
    sender = Sender(protocols.load(protocol).PROTOCOL())
    return sender, run(sender, model, lines_of(text), **how)


def said(sender, kind: str) -> list[str]:
    return [what for name, what, _ in sender.log if name == kind]


def test_A5_on_error_ask_holds_and_waits_for_the_answer():
    model = GrblModel()
    sender = new_sender(model, on_error="ask")
    seen = []

    def look(sender, now):
        seen.append(
            (
                model.state,
                sender.state,
                [line.source for line, _ in sender.asks],
                len(model.received),
                sender.outcome,
            )
        )

    asked = [(t, look) for t in (8.0, 30.0)]
    run(sender, model, lines_of(BAD), actions=[*asked, (30.1, lambda s, now: s.decide(True, now)),
        (50.0, look), (50.1, lambda s, now: s.decide(True, now))])  # fmt: skip
    first, later, second = seen
    assert first == later and first[:3] == ("Hold", HELD, [21]) and first[4] is None
    assert second[:3] == ("Hold", HELD, [31])
    assert sender.outcome.kind == "error" and [
        line.source for line, _ in sender.outcome.rejected
    ] == [21, 31]
    assert model.received == BAD.split("\n") and model.place[0] == 40


def test_A5_on_error_ask_stop_ends_as_without_asking():
    model = GrblModel()
    sender = new_sender(model, on_error="ask")
    run(sender, model, lines_of(BAD), actions=[(10.0, lambda s, now: s.decide(False, now))])
    plain = new_sender(other := GrblModel())
    run(plain, other, lines_of(BAD))
    assert sender.outcome.kind == "error" and model.state == "Hold" and not sender.asks
    assert (
        sender.outcome.message == plain.outcome.message
        and "source line 21" in sender.outcome.message
    )
    assert "it had" in sender.outcome.advice and model.accepted == other.accepted


def test_A5_the_last_line_refused_is_asked_for_before_the_end():
    model = GrblModel()
    sender = new_sender(model, on_error="ask")
    seconds = run(
        sender,
        model,
        lines_of("G21G90G94F600\nG1X1\nG77"),
        actions=[(9.0, lambda s, now: s.decide(True, now))],
    )
    assert seconds > 9.0 and sender.outcome.kind == "error"


def test_A8_a_hold_by_a_button_is_reported_and_no_stall_and_the_button_goes_on():
    model = GrblModel()
    sender = new_sender(model)
    seconds = run(
        sender,
        model,
        lines_of(SLOW),
        actions=[
            (1.0, lambda s, now: model.write(b"!", now)),
            (40.0, lambda s, now: model.write(b"~", now)),
        ],
    )
    assert seconds > 40.0 and sender.outcome.kind == "done" and model.received == SLOW.split("\n")
    assert len(said(sender, "hold")) == 1 and "not by gcomp's order" in said(sender, "hold")[0]
    assert len(said(sender, "resumed")) == 1


def test_A8_a_hold_by_a_button_can_be_ended_here():
    model = GrblModel()
    sender = new_sender(model)
    run(
        sender, model, lines_of(SLOW),
        actions=[(1.0, lambda s, now: model.write(b"!", now)), (9.0, lambda s, now: s.resume(now))],
    )  # fmt: skip
    assert sender.outcome.kind == "done" and model.received == SLOW.split("\n")
    assert len(said(sender, "hold")) == 1 and not said(sender, "resumed")


def test_it_is_held_from_the_order_on_and_by_a_button_from_the_report_on():
    """What is sent, and how long it takes, counts a hold before the machine says that it stands."""
    model = GrblModel()
    sender = new_sender(model)
    seen = []

    def look(sender, now):
        seen.append(sender.held)

    run(
        sender, model, lines_of(SLOW),
        actions=[(0.9, look), (1.0, lambda s, now: s.hold(now)), (1.0, look), (5.0, look),
                 (6.0, lambda s, now: s.resume(now)), (7.0, look),
                 (8.0, lambda s, now: model.write(b"!", now)), (10.0, look),
                 (11.0, lambda s, now: s.resume(now))],
    )  # fmt: skip
    assert seen == [False, True, True, False, True] and sender.outcome.kind == "done"


def test_A8_an_ordered_hold_that_the_machines_button_ends_goes_on():
    model = GrblModel()
    sender = new_sender(model)
    run(
        sender, model, lines_of(SLOW),
        actions=[(1.0, lambda s, now: s.hold(now)), (6.0, lambda s, now: model.write(b"~", now))],
    )  # fmt: skip
    assert (
        sender.outcome.kind == "done"
        and sender.state == RUNNING
        and len(said(sender, "resumed")) == 1
    )
    assert not said(sender, "hold")


def test_a_stop_of_the_program_is_reported_as_such():
    model = GrblModel()
    sender = new_sender(model)
    run(
        sender,
        model,
        lines_of("G21G90F600\nG1X1\nM0\nG1X2"),
        actions=[(9.0, lambda s, now: s.resume(now))],
    )
    assert sender.outcome.kind == "done"
    assert len(said(sender, "hold")) == 1 and said(sender, "hold")[0].startswith(
        "the program stops here, source line 3"
    )


def test_A8_a_tinyg_that_is_held_at_the_machine_does_not_stall():
    text = "\n".join(["G21", "G90", *(f"G1 X{i} F600" for i in range(1, 41))])
    model = TinyGModel()
    sender, _ = job(
        text,
        model,
        protocol="tinyg",
        actions=[
            (1.0, lambda s, now: model.write(b"!", now)),
            (60.0, lambda s, now: model.write(b"~", now)),
        ],
    )
    assert (
        sender.outcome.kind == "done"
        and len(said(sender, "hold")) == len(said(sender, "resumed")) == 1
    )


def test_the_states_of_a_hold():
    hold = Hold()
    assert (
        hold.reported("run", 1.0) == ""
        and hold.reported("hold", 2.0) == FOREIGN
        and hold.reported("hold", 2.2) == ""
    )
    assert hold.reported("run", 3.0) == RESUMED and not hold.foreign
    hold.order(4.0)
    assert hold.reported("run", 3.9) == ""  # asked for before the order
    assert hold.reported("run", 4.1) == AGAIN  # the order was lost
    assert (
        hold.reported("hold", 4.3) == ""
        and hold.reported("run", 4.5) == RESUMED
        and not hold.ordered
    )
    hold.order(5.0)
    hold.reported("hold", 5.1)
    hold.release(6.0)
    assert hold.reported("hold", 5.9) == "" and hold.reported("run", 6.1) == ""


@pytest.mark.parametrize("name", protocols.names())
def test_every_protocol_says_what_its_hold_and_stop_do(name):
    """Bytes are named where there are some, and "no" is said where there are none."""
    protocol = protocols.load(name).PROTOCOL()
    named = {
        b"!": "(!)",
        b"\x18": "Ctrl-X",
        b"\x04": "Ctrl-D",
        b"!%": "(!%)",
        b"\nM410\nM410\n": "M410",
        b"set pause\r\n": "told to pause",
        b"set abort\r\n": "told to abort",
    }
    for what in ("hold", "stop"):
        data, text = protocol.urgent(what), protocol.does[what]
        assert (
            (named[data] in text)
            if data
            else f"no {'feed hold' if what == 'hold' else 'stop'}" in text
        )
    assert stopped("why", protocol).advice == protocol.does["stop"]


@pytest.mark.parametrize(
    ("name", "made", "says", "not_said"),
    [
        ("marlin", MarlinModel, "M410", "reset"),
        ("smoothieware", SmoothieModel, "halts", "reset"),
        ("tinyg", TinyGModel, "keeps its position", "reset"),
        ("g2core", lambda: TinyGModel(g2=True), "Ctrl-D", "reset"),
    ],
)
def test_A8_a_stop_says_what_was_done(name, made, says, not_said):
    text = "\n".join(["G21", "G90", *(f"G1 X{i} F600" for i in range(1, 201))])
    sender, _ = job(text, made(), protocol=name, actions=[(2.0, lambda s, now: s.stop(now))])
    assert sender.outcome.kind == "aborted"
    assert says in sender.outcome.advice and not_said not in sender.outcome.advice
    assert "not confirmed" not in sender.outcome.advice


def test_A8_a_stop_that_is_not_confirmed_says_so():
    model = GrblModel()
    sender = new_sender(model)
    sender.give(lines_of(SLOW))
    sender.tick(0.0)
    sender.stop(0.1)
    sender.tick(0.2)
    assert sender.outcome is None
    for tenth in range(3, 14):
        sender.tick(tenth / 10)
    assert (
        sender.outcome.kind == "aborted"
        and "has not confirmed that within 1 s" in sender.outcome.advice
    )
    sender = new_sender(model)
    run(sender, model, lines_of(SLOW), actions=[(1.0, lambda s, now: s.stop(now))])
    assert "Ctrl-X" in sender.outcome.advice and "not confirmed" not in sender.outcome.advice
