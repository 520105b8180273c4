"""The talk before a job, and what it tells the filter: protocol, zeros, tool length, modal
state."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.commands.stream import loop
from postproc.commands.stream.port import Lost
from postproc.errors import UsageError
from postproc.streaming import live as lives
from postproc.streaming.events import Status
from postproc.streaming.greeting import Greeting, unfit
from postproc.streaming.orders import HOME, Order
from postproc.streaming.protocols import Controller
from postproc.streaming.protocols.grbl import Grbl
from postproc.streaming.source import Source
from postproc.units import TICKS_PER_MM
from tests.streaming.bench import lines_of, new_sender, run
from tests.streaming.grbl_model import GrblModel
from tests.streaming.test_source import filter_


def greet(
    greeting: Greeting, model: GrblModel | None, begin: float = 0.0, limit: float = 400.0
) -> float:
    """Until it has ended; `begin`: how long the model has been on. Returns simulated s."""
    now = begin
    while not greeting.done and greeting.fault is None:
        assert now - begin < limit
        greeting.tick(now)
        data = greeting.bytes_out()
        now += 0.005
        if model is not None:
            model.write(data, now)
            model.advance(now)
            greeting.receive(model.read(now), now)
    return now - begin


def heard_before(model: GrblModel) -> float:
    """Its banner is long gone."""
    model.advance(5.0)
    model.read(5.0)
    return 5.0


class Fluid(GrblModel):
    banner = "\r\nGrbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]\r\n"


@pytest.mark.parametrize("silent", [True, False])
@pytest.mark.parametrize(
    ("made", "how", "title", "window"),
    [
        (GrblModel, {}, "GRBL 1.1", 128),
        (GrblModel, {"rx": 255}, "GRBL 1.1", 255),
        (
            GrblModel,
            {
                "rx": 1024,
                "version": "1.1f.20240101:]\r\n[FIRMWARE:grblHAL",
                "options": "VNMSL,100,{rx},3,0",
            },
            "grblHAL",
            1023,
        ),
        (Fluid, {"version": "3.7 FluidNC v3.7.8:", "options": "PHS"}, "FluidNC", 128),
    ],
)
def test_a_controller_is_found_whether_it_greets_or_not(made, how, title, window, silent):
    model = made(**how)
    greeting = Greeting("auto")
    greet(greeting, model, heard_before(model) if silent else 0.0)
    assert greeting.fault is None
    assert (
        greeting.protocol.controller.name == title and greeting.protocol.controller.window == window
    )
    assert greeting.status.state == "idle" and unfit(greeting.protocol, greeting.status) is None
    assert greeting.protocol.outstanding() == []  # the count begins at zero
    assert model.dropped == 0 and all(x.startswith("$") for x in model.received)


def test_a_banner_in_the_middle_of_the_questions_begins_them_anew():
    model = GrblModel()
    greeting = Greeting("grbl")
    now = heard_before(model)
    while not model.received:
        greeting.tick(now)
        model.write(greeting.bytes_out(), now)
        model.advance(now := now + 0.005)
        greeting.receive(model.read(now), now)
    model.restart()
    greet(greeting, model, now)
    assert greeting.done and greeting.protocol.controller.modal[:2] == ["G0", "G54"]


@pytest.mark.parametrize(
    ("heard", "soon"),
    [
        ("\r\nGrbl 1.1h ['$' for help]\r\n", True),
        ("\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n", True),
        ("\r\nGrbl 1.1h ['$' for help]", False),
        ("\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'", False),
        ("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n", False),
    ],
)
def test_a_whole_greeting_is_not_waited_behind_for_long(heard, soon):
    greeting = Greeting("auto")
    greeting.tick(0.0)
    greeting.receive(heard.encode(), 0.1)
    greeting.tick(0.25)
    assert greeting.bytes_out() == (b"$I\n" if soon else b"")
    greeting.tick(0.45)
    assert greeting.bytes_out() == (b"" if soon else b"$I\n")


def test_nobody_and_somebody_else():
    greeting = Greeting("auto")
    assert greet(greeting, None) < 7
    assert "no answer on" in str(greeting.fault)
    greeting = Greeting("auto")
    greeting.tick(0.0)
    greeting.receive(b"login: ", 0.1)
    greet(greeting, None, 0.2)
    assert "no controller that gcomp knows: 'login:'" in str(greeting.fault)


def test_a_port_that_never_pauses_is_no_controller_whatever_protocol_is_said():
    greeting, now = Greeting("grbl"), 0.0
    while greeting.fault is None and now < 100.0:
        greeting.tick(now := now + 0.1)
        greeting.receive(b"<Idle|MPos:1,1,1|FS:0,0>\r\n", now)
    assert "sends without a pause: '<Idle|" in str(greeting.fault)


def test_homing_is_waited_for_and_a_job_can_follow():
    model = GrblModel(homing=True)
    greeting = Greeting("grbl", first=(b"$H",))
    assert greet(greeting, model) > 3.0
    assert greeting.fault is None and unfit(greeting.protocol, greeting.status) is None
    sender = new_sender(model)
    run(sender, model, lines_of("G21G90G94F600\nG1X1"), ready=False)
    assert sender.outcome.kind == "done"


@pytest.mark.parametrize("state", ["alarm", "run", "hold", "check", "door"])
def test_a_controller_that_is_not_idle_is_not_given_a_job(state):
    assert unfit(Grbl(), Status(state)).advice


@pytest.mark.parametrize("state", ["Hold", "Sleep", ""])
def test_a_controller_that_answers_no_line_is_named_by_its_state(state):
    """As a real GRBL in a hold, or asleep: it takes no line, and answers ? all the same. One that
    says nothing is told as that."""
    greeting, now = Greeting("grbl"), 0.0
    greeting.receive(b"Grbl 1.1h ['$' for help]\r\n", now)
    while greeting.fault is None and now < 30.0:
        greeting.tick(now := now + 0.05)
        if b"?" in greeting.bytes_out() and state:
            greeting.receive(f"<{state}|MPos:0.000,0.000,0.000|FS:0,0>\r\n".encode(), now)
    said = str(greeting.fault)
    assert (
        (f"not idle. {state.lower()}: it" in said and "gcomp control" in said)
        if state
        else "did not answer $I" in said
    )


CONTROLLER = Controller(
    offsets=[
        "[G54:-100.000,-50.000,-20.000]",
        "[G55:1.000,2.000,3.000]",
        "[G92:0.000,0.000,0.000]",
        "[TLO:-7.500]",
        "[PRB:0,0,0:0]",
    ],
    modal=["G1", "G55", "G17", "G20", "G91", "G94", "M5", "F0"],
)


def test_what_the_controller_says_becomes_zeros_length_place_and_modes():
    live = lives.read(CONTROLLER, Status("idle", place=(5.0, 6.0, -7.0)), ("X", "Y", "Z"))
    assert live.work["G54"] == {"X": -100, "Y": -50, "Z": -20} and "G92" not in live.work
    assert live.length == {"Z": -7.5} and live.place == {"X": 5, "Y": 6, "Z": -7}
    filter = filter_("perfect", offsets=live.work)
    lives.stand(filter, live)
    lines = Source(filter, Grbl().prepare).feed(b"X1\nG90 X1 Y1 Z1\nG21 G54 G1 X1 Y1 Z1 F100\n")
    assert lines[0].end[0] == pytest.approx(5 + 25.4)
    assert lines[1].end[:3] == pytest.approx(
        (1 + 25.4, 2 + 25.4, 3 + 25.4 - 7.5)
    )  # G55, and the length that is in force
    assert lines[2].end[:3] == pytest.approx((-99, -49, -26.5))
    assert filter.modal.frame.length[2] == -7.5 * TICKS_PER_MM


def test_the_correction_is_that_of_where_the_part_stands():
    """The same program under another zero is corrected by what the map says there."""
    ends = []
    for zero in (-200.0, -150.0):
        filter = filter_(offsets={"G54": {"X": 0.0, "Y": 0.0, "Z": zero}})
        line = Source(filter, Grbl().prepare).feed(b"G21 G90 G54 G17\nG0 X100 Y100 Z0\n")[-1]
        nominal = np.array([[100.0], [100.0], [zero]])
        deviation = filter.machine.deviation(nominal, np.zeros((3, 1)))[:, 0]
        assert np.allclose(line.correction, -deviation, atol=0.01)
        ends.append(line.correction)
    assert not np.allclose(ends[0], ends[1], atol=1e-4)


def test_other_zeros_than_the_controllers_are_refused():
    live = lives.read(CONTROLLER, Status("idle", place=(5.0, 6.0, -7.0)), ("X", "Y", "Z"))
    lives.conflicts(live, {"G54": {"X": -100.0, "Y": -50.0003}, "G59": {"X": 3.0}}, {"X": 5.0})
    with pytest.raises(
        UsageError, match=r"G54 is stated with Y = -51 mm, and the controller has Y = -50 mm"
    ):
        lives.conflicts(live, {"G54": {"Y": -51.0}}, {})
    with pytest.raises(
        UsageError, match="--start says X = 4 mm, and the controller stands at X = 5 mm"
    ):
        lives.conflicts(live, {}, {"X": 4.0})
    offsets, notices = lives.merged(live, {"G54": {"X": 0.0}, "G58": {"X": 9.0}})
    assert offsets["G54"]["X"] == -100 and offsets["G58"] == {"X": 9.0} and len(notices) == 1


def test_inches_are_read_as_inches():
    controller = Controller(offsets=["[G54:1.0000,0.0000,0.0000]", "[TLO:0.5000]"], inches=True)
    live = lives.read(controller, None, ("X", "Y", "Z"))
    assert live.work["G54"]["X"] == 25.4 and live.length["Z"] == 12.7


class Unplugged:
    """A port whose cable is pulled while it is listened to."""

    url = "/dev/ttyUSB0"

    def write(self, data: bytes) -> int:
        return len(data)

    def read(self, timeout: float) -> bytes:
        raise Lost("the device is gone")


@pytest.mark.parametrize(
    ("talk", "says"),
    [(Greeting("auto"), " nothing that moves it was sent"), (Order(Grbl(), HOME, [], None), "")],
)
def test_a_cable_that_is_pulled_before_the_job_leaves_no_doubt_that_nothing_moved(talk, says):
    with pytest.raises(UsageError, match="/dev/ttyUSB0 was closed: the device is gone") as caught:
        loop.carry(Unplugged(), talk)
    assert caught.value.advice == f"is the controller still plugged in?{says}"
