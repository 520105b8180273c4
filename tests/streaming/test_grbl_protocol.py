"""GRBL's rules at the level of bytes: window, answers, lines, numbers of design/streaming.md (A2,
A4, A6, A7)."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from postproc.streaming import protocols
from postproc.streaming.events import (
    Accepted,
    Alarm,
    Altered,
    Message,
    Rejected,
    Restarted,
    Status,
    Stray,
)
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols.grbl import Grbl
from tests.streaming.bench import lines_of, new_sender, run, zigzag
from tests.streaming.grbl_model import GrblModel


def heard(data: bytes, sizes, lines: int = 3) -> list:
    """Events of bytes that come in pieces, after `lines` lines were sent."""
    protocol = Grbl()
    for number in range(1, lines + 1):
        protocol.send(number, b"G1X%d" % number)
    events, at = [], 0
    for size in sizes:
        events += protocol.receive(data[at : at + size])
        at += size
    return events + protocol.receive(data[at:])


@pytest.mark.parametrize("rx", [127, 128, 255, 1024])
def test_A2_nothing_is_dropped_and_the_buffer_is_kept_full(rx):
    text, ends = zigzag(1500, seed=rx)
    model = GrblModel(rx=rx)
    sender = new_sender(model)
    run(sender, model, lines_of(text, ends))
    assert sender.outcome.kind == "done"
    assert model.dropped == 0
    assert model.received == [line.replace(" ", "") for line in text.split("\n")]
    assert rx - 28 < sender.tally.peak <= rx
    assert model.peak > 0.7 * rx


def test_A2_lines_of_79_characters_fit():
    rows = ["G21G90G94"] + ["G1" + f"X{i % 7}.{'0' * 60}F6000".ljust(60)[:77] for i in range(60)]
    rows = [
        row if i == 0 else "G1X" + f"{i % 7}." + "0" * 68 + "F600" for i, row in enumerate(rows)
    ]
    assert max(map(len, rows)) == 77
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of("\n".join(rows)))
    assert (sender.outcome.kind, model.dropped) == ("done", 0)


def test_A2_the_model_catches_a_window_that_is_too_large():
    """The model is the judge: 200 bytes on a buffer of 128 lose some, and that is no success."""
    text, ends = zigzag(400)
    model = GrblModel()
    sender = new_sender(model, window=200)
    run(sender, model, lines_of(text, ends))
    assert model.dropped > 0
    assert sender.outcome.kind != "done"


def test_A2_the_window_is_read_from_the_controller():
    protocol = Grbl()
    assert protocol.controller.window == 127
    protocol.learn(b"$I", ["[VER:1.1h.20190825:]", "[OPT:V,15,128]"])
    assert (protocol.controller.window, protocol.controller.planner) == (128, 16)
    hal = protocols.load("grblhal").PROTOCOL()
    hal.learn(b"$I", ["[VER:1.1f.20240101:]", "[OPT:VNMSL,100,1024,3,0]", "[FIRMWARE:grblHAL]"])
    assert hal.controller.window == 1023


ANSWERS = [
    (b"ok\r\n", Accepted),
    (b"error:20\r\n", Rejected),
    (b"[MSG:Caution: Unlocked]\r\n", Message),
    (b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n", Status),
    (b"<Run|WPos:1.000,2.000,3.000|Bf:15,128|Ln:7|FS:100,0|WCO:0.000,0.000,1.000>\r\n", Status),
    (b"ALARM:1\r\n", Alarm),
    (b">G54G20:ok\r\n", Message),
    (b"[echo: G1X1]\r\n", Altered),
    (b"okok\r\n", Message),
    (b"<Idle|MPos:0.0\r\n", Message),
    (b"xok\r\n", Message),
    (b"ok \x80\r\n", Message),
    (b"\r\n", None),
    (b"$10=255\r\n", Message),
]


@given(st.lists(st.sampled_from(ANSWERS), max_size=12), st.randoms(use_true_random=False))
def test_A4_only_whole_answers_count_wherever_they_are_cut(answers, chance):
    data = b"".join(text for text, _ in answers)
    sizes = [chance.randint(1, 7) for _ in range(len(data))]
    events = heard(data, sizes, lines=40)
    expected = [kind for _, kind in answers if kind]
    first_waits, echoes, echoed = True, False, False
    for event, kind in zip(events, expected, strict=True):
        answer = kind in (Accepted, Rejected)
        if kind is Altered:
            echoes = echoed = True
            kind = Message if first_waits else Altered  # it echoes the line that waits
        elif kind is Accepted and echoes and not echoed:
            kind = Altered  # one that echoes does so for every line
        first_waits, echoed = first_waits and not answer, echoed and not answer
        assert isinstance(event, kind), (event, kind)
    assert events == heard(data, [len(data)], lines=40)


def test_A4_an_answer_that_nobody_waits_for_is_no_answer():
    assert heard(b"ok\r\n" * 4, []) == [Accepted(1), Accepted(2), Accepted(3), Stray("ok")]


def test_A4_the_greeting_voids_what_was_sent():
    protocol = Grbl()
    protocol.send(1, b"G1X1")
    assert protocol.receive(b"\r\nGrbl 1.1h ['$' for help]\r\n") == [
        Restarted("Grbl 1.1h ['$' for help]")
    ]
    assert protocol.outstanding() == [] and protocol.used == 0
    assert protocol.receive(b"ok\r\n") == [Stray("ok")]


def test_a_report_of_work_positions_becomes_machine_coordinates():
    protocol = Grbl()
    assert protocol.receive(b"<Idle|WPos:1,2,3|FS:0,0>\n")[0].place is None
    protocol.receive(b"<Idle|WPos:1,2,3|WCO:10,0,-5>\n")
    assert protocol.receive(b"<Idle|WPos:1,2,3|FS:0,0>\n")[0].place == (11, 2, -2)
    protocol.learn(b"$$", ["$13=1", "$22=0"])
    assert protocol.receive(b"<Run:2|MPos:1,0,0|F:10>\n")[0] == Status(
        "run", "2", (25.4, 0, 0), 254.0, shift=(10, 0, -5)
    )


def test_A4_a_line_that_is_echoed_otherwise_is_reported():
    protocol = Grbl()
    protocol.send(7, b"G1 X10")
    assert protocol.receive(b"[echo: G1X10]\n") == [Message("[echo: G1X10]")]
    assert protocol.receive(b"[echo: G1X1]\n") == [Altered(7, "G1X1")]


@pytest.mark.parametrize(
    "line",
    ["G10L2P1X1", "G28.1", "G 54", "G28", "$100=250", "$X", "M30", "G30.1", "g10 l20 p0 x0", "G59"],
)
def test_A6_lines_that_touch_the_EEPROM_go_alone(line):
    protocol = Grbl()
    text = line.encode()
    protocol.send(1, b"G1X1")
    assert not protocol.ready(text)
    protocol.receive(b"ok\n")
    assert protocol.ready(text)
    protocol.send(2, text)
    assert not protocol.ready(b"G1X2")
    protocol.receive(b"ok\n")
    assert protocol.ready(b"G1X2")


@pytest.mark.parametrize("line", ["G1X10", "G100", "X5.4", "G17", "M3S1000", "G0Z28", "G1X54"])
def test_A6_other_lines_do_not(line):
    assert not Grbl().alone(line.encode())


def test_A6_no_byte_is_lost_while_the_EEPROM_is_written():
    chance = random.Random(6)
    rows = ["G21G90G94"]
    for i in range(300):
        rows.append(f"G1X{chance.uniform(0, 3):.3f}Y{i * 0.01:.2f}F6000")
        if i % 9 == 0:
            rows += chance.choice(
                [
                    ["G10L2P2X1.5"],
                    ["G28.1"],
                    ["G4P0.01", "$100=800"],
                    ["G55"],
                    ["G54"],
                    ["G10 L20 P3 X0"],
                ]
            )
    model = GrblModel()
    sender = new_sender(model)
    run(sender, model, lines_of("\n".join(rows)))
    assert (sender.outcome.kind, model.dropped) == ("done", 0)
    assert model.received == [row.replace(" ", "") for row in rows]


def test_A6_the_model_would_lose_them():
    """The model is the judge: the same lines pushed without care lose bytes."""
    model = GrblModel()
    model.advance(1.0)
    for row in ["G10L2P2X1.5", "G1X1F600", "G1X2"]:
        model.write(row.encode() + b"\n", 1.0)
    model.advance(2.0)
    assert model.dropped > 0


def test_A7_comments_blanks_and_block_delete_are_taken_out():
    prepare = Grbl().prepare
    assert prepare(b"N10 G1 X5 (what! is? this~ \xc3\xa4\x85) Y2 ; !\r\n") == b"N10 G1 X5  Y2"
    assert prepare(b"( " + b"x" * 300 + b" )") == b""
    assert prepare(b"%\n") == b"" and prepare(b"\r\n") == b"" and prepare(b" ; nothing") == b""
    assert prepare(b"/G1 X5") == b"G1 X5"


def test_A7_a_long_line_loses_its_blanks_or_is_refused():
    prepare = Grbl().prepare
    row = b"G1 X" + b"1" * 36 + b" Y" + b"2" * 36 + b" F1"
    assert len(row) > 79 and len(row.replace(b" ", b"")) <= 79
    assert prepare(row) == row.replace(b" ", b"")
    with pytest.raises(Unsendable, match="characters"):
        prepare(b"G1X" + b"1" * 80)
    assert protocols.load("grblhal").PROTOCOL().prepare(b"G1X" + b"1" * 80)


def test_a_line_that_never_fits_the_buffer_is_refused():
    """With its end it would take 51 of 50 bytes: it would wait for ever."""
    made = Grbl()
    made.controller.window = 50
    assert made.prepare(b"G1X" + b"1" * 46)
    with pytest.raises(Unsendable, match="characters"):
        made.prepare(b"G1X" + b"1" * 47)


@given(st.binary(max_size=90))
def test_A7_no_realtime_byte_ever_leaves_in_a_line(data):
    try:
        wire = Grbl().prepare(data)
    except Unsendable:
        return
    assert not any(c in b"!?~\x18\n\r" or c >= 0x80 for c in wire.strip(b"\r\n"))
    assert len(wire) < 127


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("\r\nGrbl 1.1h ['$' for help]\r\n", "grbl"),
        ("GrblHAL 1.1f ['$' or '$HELP' for help]", "grblhal"),
        ("Grbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]", "fluidnc"),
        ("[VER:1.1f.20240101:]\n[OPT:VNMSL,100,1024,3,0]\n[FIRMWARE:grblHAL]", "grblhal"),
        ("[VER:3.7 FluidNC v3.7.8:]\n[OPT:PHS]", "fluidnc"),
        ("<Idle|MPos:0.000,0.000,0.000|FS:0,0>", "grbl"),
    ],
)
def test_a_controller_is_known_by_what_it_says(text, name):
    assert protocols.recognised(text) == [name]


@pytest.mark.parametrize("name", protocols.names())
def test_every_protocol_keeps_the_interface(name):
    module = protocols.load(name)
    assert module.TITLE and isinstance(module.POKE, bytes)
    assert not module.recognises("") and not module.recognises("hello, world")
    protocol = module.PROTOCOL(counting=False)
    interface = {*vars(protocols.Protocol), *protocols.Protocol.__annotations__}
    assert not [x for x in interface if x[0] != "_" and not hasattr(protocol, x)]
    assert {"hold", "stop"} <= set(protocol.does)
    assert protocol.confirms in ("idle", "answers", "nothing")
    assert protocol.prepare(b"G1 X1.5\r\n").strip() == protocol.prepare(b"G1 X1.5\r\n")
    assert isinstance(protocol.urgent("no such thing"), bytes)
    assert protocol.receive(b"\xff\x00 nonsense \n") is not None
    assert protocol.outstanding() == []


def test_grblhal_says_that_it_compensates():
    protocol = protocols.load("grblhal").PROTOCOL()
    protocol.learn(b"$+", ["$160=0.000", "$161=0.020", "$22=1"])
    assert protocol.controller.compensates == ["backlash of Y, 20 um ($161)"]
    assert protocol.controller.homing is True


def test_a_dwell_may_last_longer_than_it_says():
    """GRBL counts it in a loop that reports make longer: G4 P60 took 60.4 s on its real image."""
    assert Grbl().patience(b"G4 P600") > 600 * 60.4 / 60 + 2
