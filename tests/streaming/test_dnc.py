"""Drip feed over RS-232: go and stop in our own loop, frames, and what may be claimed (A7, A10, A14
of design/streaming.md)."""

from __future__ import annotations

import pytest

from postproc.streaming import protocols
from postproc.streaming.events import Alarm, Message
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols.dnc import DC1, DC3, DC4, Dnc
from postproc.streaming.protocols.dnc_haas import DncHaas
from postproc.streaming.protocols.dnc_siemens import DncSiemens
from postproc.streaming.sender import Sender
from tests.streaming.bench import Faults, lines_of, zigzag
from tests.streaming.models_dnc import DncModel
from tests.streaming.models_wire import run


def job(text: str, model: DncModel, faults: Faults | None = None, protocol=Dnc, **how):
    sender = Sender(protocol())
    seconds = run(sender, model, lines_of(text), faults, **how)
    return sender, seconds


def finish(model: DncModel) -> None:
    """Let it read what is still on the way."""
    model.advance(model.now + 600.0)


def program(n: int, seed: int = 1) -> str:
    return "O1234\n" + zigzag(n, seed)[0] + "\nM30"


@pytest.mark.parametrize("baud", [1200, 4800, 9600, 19200])
def test_A14_every_byte_arrives_and_none_too_many_after_stop(baud):
    text = program(120)
    model = DncModel(baud=baud)
    sender, _ = job(text, model)
    finish(model)
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("sent", 17)
    assert model.received == text.split("\n")
    assert (model.dropped, model.alarm, model.ended) == (0, "", True)
    assert sender.protocol.stops > 3 or baud == 1200
    assert model.most_after <= 16


@pytest.mark.parametrize("seed", range(20))
def test_A14_stop_at_random_bytes(seed):
    """Thresholds and standstills drawn at random; after DC3 at most 16 bytes."""
    import random

    r = random.Random(seed)
    high = r.randint(20, 200)
    pauses = {r.randrange(2000): r.uniform(0.1, 30.0) for _ in range(6)}
    model = DncModel(
        rx=high + 18, high=high, low=r.randint(0, high - 1), rate=r.uniform(50, 900), pauses=pauses
    )
    text = program(80, seed)
    sender, _ = job(text, model)
    finish(model)
    assert sender.outcome.kind == "sent" and model.received == text.split("\n")
    assert model.most_after <= 16 and not model.alarm


def test_A14_the_model_catches_a_sender_that_does_not_obey():
    class Deaf(Dnc):
        def release(self) -> int:
            return 16

    model = DncModel()
    job(program(120), model, protocol=Deaf)
    finish(model)
    assert model.alarm == "087" and model.dropped > 0 and model.early > 0


def test_A14_nothing_leaves_before_the_control_says_go():
    model = DncModel(begins=30.0)
    sender, seconds = job(program(40), model)
    assert sender.outcome.kind == "sent" and seconds > 30 and model.early == 0


def test_A14_a_stop_of_ten_minutes_is_no_stall():
    model = DncModel(pauses={300: 600.0})
    text = program(60)
    sender, seconds = job(text, model)
    finish(model)
    assert sender.outcome.kind == "sent" and seconds > 600 and model.received == text.split("\n")


def test_A14_only_capital_letters_of_seven_bits():
    protocol = Dnc()
    assert protocol.prepare(b"n10 g1 x1.5 (to the edge) ; end") == b"N10 G1 X1.5 (TO THE EDGE)"
    assert protocol.prepare("G1 X1 (größer)".encode()) == b"G1 X1"
    assert protocol.prepare(b"% part 7") == b"" == protocol.prepare(b"  ")
    for bad in (b"G1 X\x11", b"G1 X1 \x13", b"G1 X\xb5", b"G1 %", b"G1 X" + b"1" * 300):
        with pytest.raises(Unsendable):
            protocol.prepare(bad)
    model = DncModel()
    text = program(30).lower()
    sender = Sender(Dnc())
    lines = [
        line
        for line in lines_of(
            "\n".join(sender.protocol.prepare(row.encode()).decode() for row in text.split("\n"))
        )
    ]
    run(sender, model, lines)
    finish(model)
    assert model.odd == [] and model.received == text.upper().split("\n")


@pytest.mark.parametrize(
    ("protocol", "end"), [(Dnc, b"\n"), (DncHaas, b"\r\n"), (DncSiemens, b"\r\n")]
)
def test_A14_frames_of_controls(protocol, end):
    connection = protocol()
    data = (
        connection.send(-1, connection.opening[0])
        + connection.send(1, b"G1X1")
        + connection.send(-2, connection.closing[0])
    )
    assert data == b"%" + end + b"G1X1" + end + b"%" + end
    link = protocol.link
    assert (link.bits, link.parity, link.stop) == {
        Dnc: (7, "E", 2),
        DncHaas: (7, "E", 1),
        DncSiemens: (8, "N", 1),
    }[protocol]
    model = DncModel(begins=None if not link.waits else 1.0)
    text = program(60)
    sender, _ = job(text, model, protocol=protocol)
    finish(model)
    assert sender.outcome.kind == "sent" and model.received == text.split("\n")


def test_leader_and_trailer_are_data():
    from dataclasses import replace

    class Tape(Dnc):
        link = replace(Dnc.link, leader=b"\0" * 20 + b"\x12", trailer=b"\x14" + b"\0" * 20)

    connection = Tape()
    assert connection.send(-1, b"%") == b"\0" * 20 + b"\x12%\n"
    assert connection.send(1, b"G1X1") == b"G1X1\n"
    assert connection.send(-2, b"%") == b"%\n\x14" + b"\0" * 20


def test_what_the_control_says():
    protocol = Dnc()
    assert protocol.release() == 0
    assert protocol.receive(bytes((DC1,))) == [] and protocol.release() == 16
    # parity bit left in by the port
    assert protocol.receive(bytes((DC3 | 0x80,))) == [] and protocol.release() == 0
    assert protocol.receive(bytes((DC1 | 0x80,))) == [] and protocol.release() == 16
    assert protocol.receive(b"hi\r\n") == [Message("hi")]
    assert isinstance(protocol.receive(bytes((DC4,)))[0], Alarm)
    protocol.send(-1, b"%")
    protocol.send(-2, b"%")
    assert protocol.receive(bytes((DC3, DC4))) == []  # the end, as it should be


def test_A10_reset_at_the_control_and_a_closed_port_end_the_job():
    model = DncModel()
    sender, _ = job(program(200), model, Faults(reset=8.0))
    assert sender.outcome.kind == "alarm" and "DC4" in sender.outcome.message
    sender, _ = job(program(200), DncModel(), Faults(cut=5.0))
    assert sender.outcome.kind == "disconnected"


def test_a_person_can_stop_a_job_that_waits():
    sender, seconds = job(
        program(20), DncModel(begins=1e9), actions=[(100.0, lambda s, now: s.stop(now))]
    )
    assert (sender.outcome.kind, seconds < 102) == ("aborted", True)


def test_memory_stays_flat_however_long_the_control_waits():
    sender = Sender(Dnc())
    sender.give(lines_of(program(2000)))
    for k in range(50):
        sender.tick(k * 0.1)
    assert len(sender.out) < 700 and sender.queued > 1900


def test_a_control_that_is_fed_is_never_recognised():
    assert protocols.recognised("\x11\x13 G1 X1 %") == []


def test_success_is_never_claimed():
    assert {p.confirms for p in (Dnc, DncHaas, DncSiemens)} == {"nothing"}


def test_what_has_left_is_counted_and_what_is_waited_for_is_said():
    sender = Sender(Dnc())
    protocol = sender.protocol
    sender.give(lines_of("G21\nG1 X1\nG1 X22\n"))
    sender.tick(0.0)
    assert (protocol.waits, sender.bytes_out(), sender.written()) == (
        "waiting for DC1",
        b"",
        (0, None),
    )
    sender.receive(bytes([DC1]), 0.1)
    assert (protocol.waits, sender.bytes_out()) == ("", b"%\nG21\nG1 X1\nG1 X")
    left, line = sender.written()
    assert (left, line.number, line.text) == (16, 2, b"G1 X1")
    sender.receive(bytes([DC3]), 0.2)
    assert (protocol.waits, sender.bytes_out()) == ("stopped by the control (DC3)", b"")
