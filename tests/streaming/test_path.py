"""The path under watch: an altered coordinate is seen where the machine is, and nothing else is
taken for one."""

from __future__ import annotations

import pytest

from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.streaming import live as lives
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.path import CLEAR, LOOK, OFF, Path
from postproc.streaming.protocols import Controller
from postproc.streaming.protocols.grbl import Grbl
from postproc.streaming.source import Source
from tests.streaming.bench import Faults, new_sender, run
from tests.streaming.grbl_model import GrblModel

ALL = """G21 G90 G94 G17 G54
G0 X20 Y20 Z5
G1 Z1 F{feed}
G2 X40 Y40 I20 J0
G3 X20 Y20 Z3 R20
G18 G3 X40 Z3 I10 K0
G17
G91
G1 X5 Y-5
X5 Y-5
G90
G4 P0.2
G53 G0 Z-150
G20
G1 X2 Y2 Z0.5
G21
G55
G1 X1 Y2 Z3
G92 X0 Y0
G1 X7 Y7
G92.1
G54
G43.1 Z2
G1 X11 Y11 Z9
G49
G28 G91 Z0
G90
G0 X30 Y30 Z9
G1 X50
M3 S1000
G1 X60 Y60
G1 X30 Y60
M2
"""


def wire(
    program: str, model: GrblModel, machine: str = "perfect", sampled: float = 0.005
) -> list[WireLine]:
    language = dialects.load("grbl")
    loaded = places.load(machine).carrying(language.carried)
    stored = {name: dict(zip("XYZ", place, strict=True)) for name, place in model.stored.items()}
    filter_ = Filter(loaded, language, setup_of(loaded, stored))
    status = Status("idle", place=tuple(model.place))
    lives.stand(filter_, lives.read(Controller(), status, loaded.letters))
    source = Source(filter_, Grbl().prepare, sampled=sampled)
    return source.feed(program.encode()) + source.finish()


def model(**settings: str) -> GrblModel:
    made = GrblModel(settings={f"1{k[1:]}" if k[0] == "_" else k: v for k, v in settings.items()})
    made.stored["G54"], made.stored["G55"] = [0.0, 0.0, -200.0], [10.0, 20.0, -190.0]
    made.place, made.target = [1.0, 2.0, -170.0], [1.0, 2.0, -170.0]
    return made


@pytest.mark.parametrize("feed", [300, 2000, 9000])
@pytest.mark.parametrize("counting", [True, False])
@pytest.mark.parametrize("how", [{}, {"_3": "1"}, {"_0": "2"}, {"_0": "2", "_3": "1"}])
def test_whatever_a_program_does_is_no_alarm(how, counting, feed):
    """Arcs in two planes and by radius, inches, increments, G53, shifts, tool length, G28; reports
    in inch, and of work places."""
    made = model(**how)
    sender = new_sender(made, counting=counting, watched=True)
    run(sender, made, wire(ALL.format(feed=feed), made), limit=3000)
    assert sender.outcome.kind in ("done", "altered") and sender.outcome.kind == "done", (
        sender.outcome
    )
    assert not [what for kind, what, _ in sender.log if kind in ("hold", "resumed")]
    assert sender.path.watched


@pytest.mark.parametrize("how", [{}, {"_3": "1"}, {"_0": "2"}])
@pytest.mark.parametrize(
    "old_new", [("X7 Y7", "X7 Y9"), ("I20", "I2"), ("Y40 I20", "Y40 I10"), ("X2 Y2 Z0", "X1 Y2 Z0")]
)
def test_an_altered_coordinate_is_seen_where_the_machine_is(how, old_new):
    """Slowly enough for a report to meet it: held, named with the lines and how far; nothing more
    leaves."""
    made = model(**how)
    lines = wire(ALL.format(feed=600).replace("G28 G91 Z0\n", ""), made)
    old, new = old_new
    sender = new_sender(made, watched=True)
    arrives = [made.write]

    def write(data: bytes, now: float) -> None:
        arrives[0](data.replace(old.encode(), new.encode()), now)

    made.write = write
    run(sender, made, lines, limit=3000)
    outcome = sender.outcome
    assert (
        outcome.exit_status == 15
        and "beside the path" in outcome.message
        and "source lines" in outcome.message
    ), outcome
    assert sender.path.distance > 0.05 and "told to hold" in outcome.advice
    assert made.state == "Hold"


@pytest.mark.parametrize("machine", ["perfect", "example-mill"])
def test_axes_that_the_first_block_does_not_name_stay_where_the_controller_stands(machine):
    """As at the head of a restart. They were taken for 0, and a report on the second motion for 7.9
    mm beside the path."""
    made = model()
    made.place = made.target = [9.704, 8.989, -190.005]
    lines = wire("G21 G90 G94\nG54\nG53 G0 Z-180\nG0 X6.4 Y0\nG53 G0 Z-170\n", made, machine)
    ends = [line.end[:3] for line in lines]
    assert ends[2] == (9.704, 8.989, -180.0) and lines[2].correction[:2] == (0.0, 0.0)
    assert ends[3] == pytest.approx((6.4, 0.0, -180.0), abs=0.02)
    assert ends[4] == (*ends[3][:2], -170.0)


def test_a_jog_before_the_first_line_is_no_alarm():
    made = model()
    lines = wire(
        "G21 G90 G94\nG54\n" + "".join(f"G1 X{x} Y{x} Z5 F600\n" for x in range(1, 30)), made
    )
    made.place, made.target = [0.0, 30.0, -100.0], [0.0, 30.0, -100.0]
    sender = new_sender(made, watched=True)
    run(sender, made, lines)
    assert sender.outcome.kind == "done", sender.outcome


def test_one_damaged_report_holds_for_a_look_and_goes_on():
    made = model()
    lines = wire(
        "G21 G90 G94\nG54\nG0 X0 Y0 Z5\n" + "".join(f"G1 X{x} F600\n" for x in range(1, 30)), made
    )
    sender = new_sender(made, watched=True)
    told: list[float] = []
    receive = sender.receive

    def damaged(data: bytes, now: float) -> None:
        if now > 2.5 and b"<Run|MPos:" in data and not told:
            told.append(now)
            data = data.replace(b"MPos:", b"MPos:4")
        receive(data, now)

    sender.receive = damaged
    run(sender, made, lines)
    said = [str(what) for kind, what, _ in sender.log if kind == "resumed"]
    assert (
        told and sender.outcome.kind == "done" and len(said) == 1 and "beside the path" in said[0]
    ), (told, said)
    assert made.accepted == [line.text.decode().replace(" ", "") for line in lines]


def test_behind_a_refused_line_nothing_is_concluded():
    made = model()
    program = "G21 G90 G94\nG54\nG0 X0 Y0 Z5\n" + "".join(
        f"G1 X{x} Y{x % 3} F600\n" for x in range(1, 30)
    )
    sender = new_sender(made, watched=True, on_error="continue")
    faults = Faults(to={program.index("G1 X5") + 1: "drop"})
    run(sender, made, wire(program, made), faults)
    assert (
        sender.outcome.kind == "error"
        and len(sender.outcome.rejected) >= 1
        and not sender.path.watched
    )


# -- the path by itself ----------------------------------------------------------------------------

TWO = Controller(planner=3, segments=1)


def moves(path: Path, *places: tuple[float, ...], **how) -> None:
    for i, place in enumerate(places, 1):
        path.account.sent(WireLine(i, i, 0, b"G1 X1", place, **how))


def at(*place: float, state: str = "run", detail: str = "") -> Status:
    return Status(state, detail, place)


def standing() -> Path:
    path = Path(TWO)
    path.judge(at(0.0, 0.0, state="idle"))
    return path


def test_what_is_over_is_no_path_any_more_and_what_may_not_be_is():
    """A planner of 3 and a segment: of motions 1 to 9, all answered, 6 to 9 may be in execution."""
    path = standing()
    moves(path, *((float(i), 0.0 if i < 6 else 50.0) for i in range(1, 10)))
    for i in range(1, 10):
        path.account.answered(i)
    assert [line.number for line in path.lines()] == [6, 7, 8, 9]
    assert path.judge(at(5.5, 25.0)) == "" and path.judge(at(3.0, 0.0)) == LOOK
    assert path.distance == pytest.approx(2.0, abs=0.05) and path.nearest.number == 6


def test_motions_without_length_push_nothing_out():
    path = standing()
    moves(path, (100.0, 0.0), *((100.0 + i * 1e-4, 0.0) for i in range(1, 60)))
    for i in range(1, 61):
        path.account.answered(i)
    assert path.judge(at(50.0, 0.0)) == ""


def test_seen_twice_is_off_and_seen_once_is_clear():
    path = standing()
    moves(path, (10.0, 0.0))
    assert path.judge(at(5.0, 0.04)) == ""  # within the limit
    assert (
        path.judge(at(5.0, 1.0)) == LOOK
        and path.judge(at(5.0, 1.0, state="hold", detail="0")) == OFF
    )
    path.off_path = 0
    assert (
        path.judge(at(5.0, 1.0)) == LOOK
        and path.judge(at(6.0, 0.0, state="hold", detail="1")) == ""
    )
    assert (
        path.judge(at(6.0, 0.0, state="hold", detail="0")) == CLEAR
        and path.judge(at(6.0, 0.0)) == ""
    )


@pytest.mark.parametrize(
    "what", ["cycle", "M6", "unknown end", "unknown axis", "jogging", "not reported"]
)
def test_where_the_path_is_not_known_nothing_is_said(what):
    path = standing()
    nan = float("nan")
    end = {"unknown end": (), "unknown axis": (10.0, nan)}.get(what, (10.0, 0.0))
    path.account.sent(
        WireLine(1, 1, 0, b"T1 M6" if what == "M6" else b"G1 X1", end, straight=what != "cycle")
    )
    if what == "jogging":
        assert path.judge(at(3.0, 3.0, state="jog")) == ""
    place = (5.0,) if what == "not reported" else (5.0, 9.0)
    assert path.judge(at(*place)) == ""


def test_steps_of_the_motors_and_an_unknown_planner_are_allowed_for():
    coarse = Path(Controller(settings={"100": "20.000", "101": "800"}))
    assert coarse.limit == pytest.approx(0.05 + 2 * 0.05) and Path(TWO).limit == pytest.approx(0.05)
    path = Path(Controller())
    path.judge(at(0.0, 0.0, state="idle"))
    moves(path, (10.0, 0.0), *((10.0, float(i)) for i in range(1, 100)))
    for i in range(1, 101):
        path.account.answered(i)
    assert path.judge(at(5.0, 0.0)) == ""
