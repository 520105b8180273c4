"""TinyG and g2core: footers, echoes, reports, windows (A1, A2, A4, A5, A8, A9, A10, A12, A16 of
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
    Status,
)
from postproc.streaming.greeting import Greeting, unfit
from postproc.streaming.lines import Unsendable
from postproc.streaming.live import read
from postproc.streaming.protocols.g2core import G2core
from postproc.streaming.protocols.tinyg import TinyG, checksum
from postproc.streaming.sender import Sender
from tests.streaming.bench import Faults, lines_of, zigzag
from tests.streaming.models_tinyg import TinyGModel, java_hash
from tests.streaming.models_wire import greet, run


def job(
    text: str,
    model: TinyGModel,
    faults: Faults | None = None,
    counting: bool = True,
    ends=None,
    protocol=TinyG,
    **how,
):
    """With the echo switched on, as the greeting does it."""
    model.verbosity = 5
    sender = Sender(protocol(counting))
    seconds = run(sender, model, lines_of(text, ends), faults, **how)
    return sender, seconds


def blocks(n: int, seed: int = 1, feed: int = 6000) -> tuple[str, list]:
    text, ends = zigzag(n, seed, feed)
    return text.replace(" ", ""), ends


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ('{"r":{"xjm":5000000000.000},"f":[1,0,11', 6649),
        ('{"r":{"2":{"ma":1,"sa":1.800,"tr":36.540,"mi":8,"po":1,"pm":1}},"f":[1,0,9', 2423),
        ('{"r":{"n":20},"f":[1,0,9', 5362),
    ],
)
def test_the_footers_checksum_is_that_of_the_documented_answers(text, value):
    """synthetos/TinyG wiki, "JSON Operation": the answers printed there."""
    assert checksum(text) == value == java_hash(text)


@pytest.mark.parametrize("counting", [True, False])
@pytest.mark.parametrize("protocol", [TinyG, G2core])
def test_A1_every_block_is_executed_once_and_in_order(counting, protocol):
    text, ends = blocks(400)
    model = TinyGModel(g2=protocol is G2core)
    sender, _ = job(text, model, counting=counting, ends=ends, protocol=protocol)
    assert sender.outcome.kind == "done", sender.outcome
    assert model.executed == text.split("\n")
    assert model.dropped == 0


def test_A2_the_buffer_is_filled_and_never_beyond_xoff():
    text, ends = blocks(800, seed=4)
    model = TinyGModel(reports=False)
    sender, _ = job(text, model, ends=ends)
    assert sender.outcome.kind == "done" and model.dropped == 0
    assert 150 < sender.tally.peak <= 200 and model.peak <= 0.8 * 254


def test_A2_a_buffer_that_is_smaller_drops_and_that_is_no_success():
    text, ends = blocks(400, seed=4, feed=900)
    model = TinyGModel(rx=100, flow=False)
    sender, _ = job(text, model, ends=ends)
    assert model.dropped > 0 and sender.outcome.kind != "done"


def test_xoff_is_obeyed_and_no_part_of_an_answer():
    protocol = TinyG()
    protocol.send(1, b"G1X1")
    protocol.receive(b'{"r":{"gc":"G1\x13')
    assert protocol.release() == 0
    text = b'{"r":{"gc":"G1X1"},"f":[1,0,5'
    assert protocol.receive(b'X1"},"f":[1,0,5,%d]}\n\x11' % checksum(text.decode())) == [
        Accepted(1)
    ]
    assert protocol.release() > 0


def test_g2core_has_a_few_lines_on_the_way():
    text, ends = blocks(200)
    model = TinyGModel(g2=True)
    sender, _ = job(text, model, ends=ends, protocol=G2core)
    most = 0
    protocol = G2core()
    while protocol.ready(b"G1X1") and most < 20:
        protocol.send(most, b"G1X1")
        most += 1
    assert (sender.outcome.kind, most) == ("done", 4)


@pytest.mark.parametrize("what", ["flip", "drop", "double"])
@pytest.mark.parametrize("at", [40, 900, 2000])
def test_A4_a_byte_lost_on_the_way_is_found_by_the_echo(what, at):
    text, _ = blocks(200)
    model = TinyGModel()
    sender, _ = job(text, model, Faults(to={at: what}))
    assert sender.outcome.kind in ("altered", "error", "stalled"), sender.outcome
    assert model.executed != text.split("\n")


def heard(*texts: bytes):
    protocol = TinyG()
    protocol.send(1, b"G1X1")
    protocol.send(2, b"G1X2")
    return protocol, [event for text in texts for event in protocol.receive(text)]


def answer(block: str, status: int = 0, size: int | None = None, good: bool = True) -> bytes:
    text = f'{{"r":{{"gc":"{block}"}},"f":[1,{status},{len(block) + 1 if size is None else size}'
    return f"{text},{checksum(text) + (not good)}]}}\n".encode()


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        (answer("G1X1"), [Accepted(1)]),
        (answer("g1 x1", size=5), [Accepted(1)]),
        (answer("G1X1", status=65), [Rejected(1, "status 65", "two codes of one modal group")]),
        (answer("G1X9"), [Altered(1, "G1X9")]),
        (answer("G1X1", size=4), [Altered(1, "G1X1, 4 bytes")]),
        (answer("G1X2"), [Altered(1, "G1X2")]),
    ],
)
def test_A4_what_answers_mean(said, meant):
    assert heard(said)[1] == meant


@pytest.mark.parametrize(
    "said",
    [
        answer("G1X1", good=False),
        b'{"r":{"gc":"G1X1"}}\n',
        b'{"qr":20}\n',
        b"ok\n",
        b"[1]\n",
        b'{"r":1,"f":[1,0]}\n',
        b"tinyg [mm] ok>\n",
    ],
)
def test_A4_what_is_no_answer_counts_for_none(said):
    protocol, events = heard(said)
    assert protocol.outstanding() == [1, 2] and not [
        e for e in events if not isinstance(e, Message)
    ]


@given(st.lists(st.integers(1, 9), max_size=60))
def test_A4_answers_may_be_cut_anywhere(sizes):
    data = (
        b'{"sr":{"posx":1.000,"stat":5}}\n'
        + answer("G1X1")
        + b'{"qr":28}\n'
        + answer("G1X2", status=61)
    )
    protocol, _ = heard()
    events, at = [], 0
    for size in [*sizes, len(data)]:
        events += protocol.receive(data[at : at + size])
        at += size
    assert [e for e in events if isinstance(e, Accepted)] == [Accepted(1), Accepted(2)]
    assert [e for e in events if isinstance(e, Busy)]


def test_reports_alarms_and_restarts():
    _, events = heard(b'{"sr":{"posx":1.5,"vel":300.0,"stat":5}}\n')
    assert Status("run", feed=300.0) in events
    assert isinstance(heard(b'{"sr":{"stat":2}}\n')[1][0], Alarm)
    assert (
        heard(b'{"er":{"fb":440.20,"st":203,"msg":"Limit switch hit"}}\n')[1][0].meaning
        == "Limit switch hit"
    )
    model = TinyGModel()
    model.advance(1.0)
    protocol, events = heard(model.read(1.0))
    assert isinstance(events[0], Restarted) and protocol.outstanding() == []


def test_A5_a_refused_block_holds():
    text, _ = blocks(200, feed=600)
    text = text.replace("\nG1X", "\nG77X", 1)
    model = TinyGModel()
    sender, _ = job(text, model)
    assert (sender.outcome.kind, sender.outcome.exit_status) == ("error", 10)
    assert "G77" in sender.outcome.message and model.state() in (6, 3)


def test_A8_hold_resume_and_stop():
    text, ends = blocks(200, feed=1200)
    model = TinyGModel()
    states = []
    actions = [
        (1.0, lambda s, now: s.hold(now)),
        (2.0, lambda s, now: states.append(model.state())),
        (4.0, lambda s, now: s.resume(now)),
    ]
    sender, _ = job(text, model, ends=ends, actions=actions)
    assert states == [6] and sender.outcome.kind == "done" and model.executed == text.split("\n")
    model = TinyGModel()
    sender, _ = job(text, model, actions=[(1.0, lambda s, now: s.stop(now))])
    assert sender.outcome.kind == "aborted" and not model.moves.ends


def test_A9_A10_restart_and_closed_port():
    text, _ = blocks(200, feed=1200)
    assert job(text, TinyGModel(), Faults(reset=1.0))[0].outcome.kind == "reset"
    assert job(text, TinyGModel(), Faults(cut=1.0))[0].outcome.kind == "disconnected"


def test_A12_silence_is_a_stall_and_a_long_move_is_none():
    text, _ = blocks(100, feed=1200)
    sender, seconds = job(text, TinyGModel(), Faults(stall=(0.5, 1e9)))
    assert sender.outcome.kind == "stalled" and seconds < 15
    sender, seconds = job(
        "G21G90F60\nG1X2\n" + "\n".join(f"G1X{i % 5}" for i in range(40)), TinyGModel()
    )
    assert sender.outcome.kind == "done" and seconds > 60


@pytest.mark.parametrize("protocol", [TinyG, G2core])
def test_A12_a_dwell_is_no_stall(protocol):
    """It reports nothing while it dwells: 10 s of that ended the job."""
    text = "G21G90F600\nG1X2\nG4P25\n" + "\n".join(f"G1X{i % 5}" for i in range(60))
    sender, seconds = job(text, TinyGModel(g2=protocol is G2core), protocol=protocol)
    assert sender.outcome.kind == "done" and seconds > 25
    sender, seconds = job("G21G90F600\nG1X2\nG4P90", TinyGModel(g2=protocol is G2core))
    assert sender.outcome.kind == "done" and seconds > 90


def test_zeros_come_in_the_unit_in_force_and_the_place_in_mm():
    """In G20 g54 is in inches (config_app.c): 100 mm were read as 3.937 mm."""
    model = TinyGModel()
    model.moves.place, model.work["g54"] = [1.0, 2.0, 3.0], [100.0, 0.0, -50.0]
    model.modes |= {"unit": 0, "dist": 1}
    greeting = greet(Greeting("tinyg"), model)
    assert greeting.fault is None and greeting.protocol is not None
    live = read(greeting.protocol.controller, greeting.status, ("X", "Y", "Z"))
    assert live.work["G54"] == pytest.approx({"X": 100.0, "Y": 0.0, "Z": -50.0}, abs=0.013)
    assert live.place == {"X": 1.0, "Y": 2.0, "Z": 3.0}
    assert live.modal == ("G20", "G91", "G17", "G54")


@pytest.mark.parametrize("reports", [True, False])
def test_A16_done_is_said_when_it_stands_and_where_it_should(reports):
    model = TinyGModel(reports=reports)
    sender, seconds = job("G21G90\nG1X2F60", model, ends=[(0, 0, 0), (2, 0, 0)])
    assert sender.outcome.kind == "done" and seconds > 2.0
    sender, _ = job("G21G90\nG1X2F600", TinyGModel(), ends=[(0, 0, 0), (2.5, 0, 0)])
    assert sender.outcome.kind == "altered" and "0.500 mm" in sender.outcome.message


@pytest.mark.parametrize(
    ("name", "g2"), [("auto", False), ("tinyg", False), ("auto", True), ("g2core", True)]
)
def test_the_greeting_learns_zeros_place_and_verbosity(name, g2):
    model = TinyGModel(g2=g2)
    model.moves.place, model.work["g55"] = [1.0, 2.0, 3.0], [5.0, 0.0, -1.0]
    greeting = greet(Greeting(name), model)
    assert greeting.fault is None, greeting.fault
    protocol = greeting.protocol
    assert protocol.title == ("g2core" if g2 else "TinyG")
    assert (
        "[G55:5.000,0.000,-1.000]" in protocol.controller.offsets
        and len(protocol.controller.offsets) == 7
    )
    assert model.verbosity == 5 and b'{"jv":3}' in protocol.closing
    assert unfit(protocol, greeting.status) is None
    sender = Sender(protocol)
    run(sender, model, lines_of("G21G90\nG1X2F600"))
    assert sender.outcome.kind == "done" and model.verbosity == 3


def test_their_words_are_recognised_and_by_nobody_else():
    assert protocols.recognised(READY_TINYG) == ["tinyg"]
    assert protocols.recognised(READY_TINYG.replace("440.20", "100.26")) == ["g2core"]


READY_TINYG = (
    '{"r":{"fv":0.970,"fb":440.20,"hp":1,"hv":8,"id":"3X3566-YMB","msg":"SYSTEM'
    ' READY"},"f":[1,0,0,5816]}'
)


def test_A7_lines_are_cleaned_or_refused():
    protocol = TinyG()
    assert protocol.prepare(b" g1 x1 (50% done!) ; ~") == b"G1X1"
    assert protocol.prepare(b"(only)") == b""
    for bad in (b"G1 X1 !", b"G1 X1 %", b"$jv=5", b'{"jv":1}', b"G1 X\xb5", b"G1 X" + b"1" * 220):
        with pytest.raises(Unsendable):
            protocol.prepare(bad)
