"""What a controller would refuse in the cut is found before the first byte of the program: by its
settings, and by its own check mode."""

from __future__ import annotations

import json

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc.commands.stream.first_pass import changes  # noqa: E402
from postproc.streaming.lines import WireLine  # noqa: E402
from postproc.streaming.live import Live  # noqa: E402
from postproc.streaming.precheck import Precheck  # noqa: E402
from postproc.streaming.protocols import Controller  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import model, sent_rows, stream  # noqa: E402

PERFECT = ("--machine", "perfect", "--dialect", "grbl")
RAW = ("--machine", "perfect", "--dialect", "linuxcnc", "--protocol", "grbl")
HEAD = "G21 G90 G94 G17 G54\nG0 X-1 Y-1 Z-1\n"
LIMITS = {"20": "1", "130": "200.000", "131": "150.000", "132": "80.000"}


def job(folder, body: str, host: PtyHost, *options: str, machine=PERFECT) -> tuple[int, str]:
    (folder / "job.nc").write_text(HEAD + body)
    status, _, err = stream(
        folder, host, "job.nc", "--offset", "G54=X0,Y0,Z0", *options, machine=machine
    )
    return status, err


def made(**how):
    one = model(**how)
    one.stored["G54"] = [0.0, 0.0, 0.0]
    return one


@pytest.mark.parametrize(
    ("body", "machine", "says"),
    [
        (
            "G1 X5 F600\nG1 Y-150.5\nM2\n",
            PERFECT,
            "job.nc:3: nothing was sent: X 5.000 (machine coordinates) is beyond",
        ),
        # the arc's top
        (
            "G1 X-5 F600\nG3 X-15 Y-1 I-5 J0\nG1 X-199\nM2\n",
            PERFECT,
            "job.nc:4: nothing was sent: Y",
        ),
        ("G1 X-5\nM2\n", PERFECT, "job.nc:3: nothing was sent: a feed (G1, G2, G3) before any F"),
        ("X-7\nG1\nF100\nX-3\nG93\nX-4 F2\nM2\n", PERFECT, ""),
        # under G93 each line wants its own F, and G94 behind it forgets them
        ("G93\nG1 X-3 F9\nX-4\nM2\n", PERFECT, "job.nc:5: nothing was sent: a feed (G1, G2, G3) w"),
        ("G1 X-3 F100\nG93 X-4 F9\nG94\nX-5\nM2\n", PERFECT, "job.nc:6: nothing was sent: a feed"),
        ("G1 X-3 F100\nG93 X-4 F9\nG94 X-5 F90\nX-6\nM2\n", PERFECT, ""),
        ("T2 M6\nG1 X-5 F600\nM2\n", RAW, "job.nc:3: M6 changes the tool"),
    ],
)
def test_travel_feeds_and_tool_changes(place, body, machine, says):
    with PtyHost(made(settings=LIMITS), speed=20.0) as host:
        status, err = job(place, body, host, machine=machine)
        assert (status, says in err) == ((2, True) if says else (0, True)), err
        assert bool(sent_rows(host)) == (not says)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("G1 X199 Y-149 F900\nM2\n", ""),
        ("G1 X-5 F900\nM2\n", "X -5.000"),
        ("G1 Y5 F900\nM2\n", "Y 5.000"),
    ],
)
def test_a_zero_at_the_near_end_where_the_controller_was_built_so(place, body, says):
    """HOMING_FORCE_SET_ORIGIN: Z in $I; X homes in the negative direction ($23)."""
    made = model(settings=LIMITS | {"23": "1"}, options="VZ,15,{rx}")
    made.stored["G54"] = [0.0, 0.0, 0.0]
    head = HEAD.replace("X-1", "X1")
    with PtyHost(made, speed=20.0) as host:
        (place / "job.nc").write_text(head + body)
        status, _, err = stream(place, host, "job.nc", "--offset", "G54=X0,Y0,Z0", machine=PERFECT)
    assert (status, f"{says} (machine coordinates) is beyond" in err) == (
        (2, True) if says else (0, False)
    ), err


def test_more_way_than_the_machine_has_is_reported_before_the_job(place):
    with PtyHost(made(settings=LIMITS | {"20": "0"}), speed=400.0) as host:
        status, err = job(place, "G0 X250\nG0 X0\nM2\n", host)
    assert status == 0 and "moves X over 251.0 mm, and the controller has 200 mm ($130)" in err
    assert err.index("moves X over") < err.index("lines sent")


@pytest.mark.parametrize(("how", "rows"), [("pause", ["T2M0"]), ("ignore", ["T2"])])
def test_a_tool_change_waits_for_a_person_or_is_left_out(place, how, rows):
    with PtyHost(made(), speed=10.0) as host:
        if how == "pause":
            host.model.advance_, told = host.model.advance, []

            def advance(now):
                host.model.advance_(now)
                if host.model.state == "Hold":
                    told.append(now)
                    if now > told[0] + 8.0:  # so that it was reported, and told
                        host.press(b"~")

            host.model.advance = advance
        status, err = job(
            place, "M5\nT2 M6\nG1 X-5 F600\nM2\n", host, "--tool-change", how, machine=RAW
        )
        assert status == 0, err
        assert [row for row in sent_rows(host) if "T2" in row] == rows
        assert ("the program stops here, source line 4" in err) == (how == "pause")


def test_the_controller_reads_the_program_before_it_moves(place):
    """Its own check mode: an error in the last line is known before the first motion; without one
    the job begins, alike."""
    body = "".join(f"G1 X-{i % 50} Y-{i % 7} F6000\n" for i in range(60))
    with PtyHost(made(), speed=4.0) as host:
        words = ("--check-first", "auto", "--report", "run.html", "--json", "run.json")
        status, err = job(place, body + "G1 X-5 H7\nM2\n", host, *words, machine=RAW)
        assert (
            status == 10
            and "nothing has moved: in the controller's check mode" in err
            and "source line 63" in err
        ), err
        assert not host.model.ends and host.model.state == "Idle"
        said = json.loads((place / "run.json").read_text())
        assert said["exit_status"] == 10 and said["message"].startswith("nothing has moved: in")
        assert "Nothing has moved: in the controller" in (place / "run.html").read_text("utf-8")
    with PtyHost(made(), speed=4.0) as host:
        status, err = job(place, body + "M2\n", host, "--check-first", "auto")
        assert status == 0, err
        assert host.model.received.count("$C") == 2 and len(host.model.ends) == 61
        rows = [row for row in sent_rows(host)]
        assert rows[: len(rows) // 2] == rows[len(rows) // 2 :]


def test_a_second_job_behind_the_first(place):
    """M30 leaves G1 and the feed in force (gcode.c, PROGRAM_FLOW_COMPLETED), and the reset behind a
    check pass G0 and none: read first where the program says both itself, and not where it goes
    by them."""
    with PtyHost(made(), speed=10.0) as host:
        for checks, body in (
            (2, "G1 X-5 F600\nM30\n"),
            (4, "G1 X-3 F600\nM30\n"),
            (4, "G1 X-6\nM30\n"),
        ):
            status, err = job(place, body, host, "--check-first", "auto")
            assert status == 0 and "the machine stands still" in err, err
            assert host.model.received.count("$C") == checks
    assert [end[0] for end in host.model.ends[-1:]] == [-6.0]


@pytest.mark.parametrize(
    ("in_force", "rows", "fits"),
    [
        ("G0 M5 M9 F0 S0", "G1 X1 F100", True),
        ("G1 M5 M9 F0 S0", "G0 X1", True),
        ("G1 M5 M9 F900 S0", "F800\nX1", False),
        ("G0 M5 M9 F900 S0", "G0 X1\nG1 X2", False),
        ("G0 M5 M9 F900 S0", "G4 P1\nG1 X2 F100\nX3", True),
        ("G0 M5 M9 F0 S500", "M3\nG0 X1", False),
        ("G0 M5 M9 F0 S500", "M3 S400\nG0 X1", True),
        ("G0 M3 M9 F0 S500", "G0 X1", False),
        ("G0 M5 M8 F0 S0", "G0 X1", False),
        ("G0 M5 M9 F0 S0", "G10 L2 P1 X0", False),
    ],
)
def test_what_a_program_goes_by_from_before_it_is_not_checked_away(in_force, rows, fits):
    controller = Controller(modal=["G54", "G17", "G21", "G90", "G94", *in_force.split()])
    known = Precheck(controller, ("X",), (0,), "job.nc", grbl=True)
    for n, row in enumerate(rows.split("\n"), 1):
        known.look(WireLine(n, n, 0, row.encode()))
    assert known.checkable() == fits


def test_what_a_reset_has_changed_is_said_and_no_more():
    zeros = {"G54": {"X": 1.0, "Y": 2.0}, "G55": {"X": 3.0}}
    before = Live(zeros, {}, {"X": 0.0}, ("G1", "G54", "G21"))
    assert changes(before, Live(zeros, {}, {"X": 0.0}, ("G0", "G54", "G21"))) == ""
    now = Live({**zeros, "G55": {"X": 4.0}}, {}, {"X": 0.5}, ("G0", "G54", "G20"))
    assert changes(before, now) == (
        "the modes were G21 G54 and are G20 G54; G55 was X3 and is X4; its place was X0 and is X0.5"
    )


def test_a_check_that_would_drop_a_zero_is_left_out(place):
    with PtyHost(made(), speed=10.0) as host:
        host.model.preset = [1.0, 0.0, 0.0]
        status, err = job(place, "G1 X-5 F600\nM2\n", host, "--check-first", "auto")
        assert status == 0 and "$C" not in host.model.received, err
        status, err = job(place, "G1 X-5 F600\nM2\n", host, "--check-first", "always")
        assert status == 2 and "would drop a G92" in err
