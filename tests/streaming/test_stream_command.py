"""`gcomp stream` as a process on a pseudo-terminal, with the model behind it in real time."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc import cli  # noqa: E402
from postproc.recordings import ReadingOptions, Source, contract  # noqa: E402
from postproc.streaming import journal  # noqa: E402
from tests.api.schemas import held  # noqa: E402
from tests.pages import drawn  # noqa: E402
from tests.streaming.bench import Faults  # noqa: E402
from tests.streaming.grbl_model import GrblModel  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
MILL = ("--machine", "example-mill", "--dialect", "grbl")
PATIENCE = 60.0  # s


def program(n: int = 60, feed: int = 3000) -> str:
    rows = ["(part)", "G90 G21 G94 G17", "G54", "G0 X0 Y0 Z20", f"G1 Z10 F{feed}"]
    rows += [f"G1 X{i % 7 + i / 10:.3f} Y{(i * 3) % 11:.3f} F{feed}" for i in range(n)]
    return "\n".join([*rows, "G0 Z20", "M30", ""])


@pytest.fixture
def place(tmp_path):
    (tmp_path / "job.nc").write_text(program())
    return tmp_path


def model(**how) -> GrblModel:
    made = GrblModel(**how)
    made.stored["G54"] = [0.0, 0.0, -200.0]
    return made


def start(
    place: Path, host: PtyHost | None, *arguments: str, machine=MILL, stdin=subprocess.DEVNULL
):
    port = ("--port", host.path) if host else ()
    return subprocess.Popen(
        [
            sys.executable,
            "-m",
            "postproc",
            "stream",
            *machine,
            *port,
            "--check-first",
            "never",
            *arguments,
        ],
        cwd=place,
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "HOME": str(place),
            "XDG_CONFIG_HOME": str(place),
        },
    )


def stream(place: Path, host: PtyHost | None, *arguments: str, **how) -> tuple[int, str, str]:
    process = start(place, host, *arguments, **how)
    out, err = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in err, err
    return process.returncode, out, err


def wire_rows(place: Path, name: str = "job.nc", *more: str) -> list[str]:
    """What `gcomp` writes to a file, as GRBL takes it."""
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "postproc",
            *MILL,
            "--offset",
            "G54=X0,Y0,Z-200",
            "--start",
            "X0,Y0,Z0",
            *more,
            name,
        ],
        cwd=place,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    return [
        row.replace(" ", "") for row in done.stdout.split("\n") if row and not row.startswith("(")
    ]


def sent_rows(host: PtyHost) -> list[str]:
    return [row for row in host.model.received if not row.startswith("$")]


@contextlib.contextmanager
def running(place: Path, host: PtyHost, after: int, *arguments: str):
    """A job of which `after` lines have arrived."""
    process = start(place, host, *arguments)
    deadline = time.monotonic() + PATIENCE
    while len(sent_rows(host)) < after and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.005)
    assert process.poll() is None, process.communicate()
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def test_A1_A16_the_model_gets_the_files_bytes_and_done_is_said_last(place):
    with PtyHost(model(), speed=4.0) as host:
        status, out, err = stream(
            place,
            host,
            "job.nc",
            "--record",
            "run.csv",
            "--report",
            "run.html",
            "--json",
            "run.json",
        )
    assert status == 0, err
    told, page = (
        json.loads((place / "run.json").read_text()),
        (place / "run.html").read_text("utf-8"),
    )
    held(told)
    assert told["outcome"] == "done" and told["answered"] == told["sent"] == told["lines"]
    curves = drawn.curves(page, "lines")
    assert curves["answered"]["y"] == sorted(curves["answered"]["y"]) and drawn.outside(page) == []
    assert f"{told['sent']} lines sent and accepted" in page
    assert sent_rows(host) == wire_rows(place)
    assert host.model.dropped == 0 and host.model.state == "Idle"
    lines = [json.loads(line) for line in out.splitlines()]
    assert {line["event"] for line in lines} == {"progress", "outcome"}
    assert {"eta_s", "position_mm", "feed_mm_min", "buffer_bytes", "source_line"} <= set(lines[-2])
    assert lines[-1]["outcome"] == "done" and lines[-1]["exit_status"] == 0
    recording = contract.read(Source("run.csv", (place / "run.csv").read_bytes()), ReadingOptions())
    assert recording.kind == "trace" and recording.axes == ("X", "Y", "Z") and len(recording) > 5
    assert abs(recording.columns["X_act_mm"] - recording.columns["X_cmd_mm"]).max() < 0.002
    past = journal.read((place / "job.nc.journal").read_bytes(), "j")
    assert past.outcome == "done" and past.answered == past.sent == len(sent_rows(host))


def test_A17_the_journal_replayed_is_the_file(place):
    """Every wire line is in it, in order, with its source line, the piece it is, and what was
    corrected."""
    (place / "job.nc").write_text(
        program(20).replace("G0 Z20\nM30", "G0 X150 Y120\nG1 X0 Y0 F6000\nG0 Z20\nM30")
    )
    with PtyHost(model(), speed=4.0) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 0, err
    entries = [json.loads(line) for line in (place / "job.nc.journal").read_text().splitlines()]
    sent = [entry for entry in entries if "sent" in entry]
    assert [entry["text"].replace(" ", "") for entry in sent] == wire_rows(place) == sent_rows(host)
    source = (place / "job.nc").read_text().split("\n")
    assert sum(entry["piece"] > 0 for entry in sent) > 2  # blocks that were cut
    for entry in sent:
        own = source[entry["source"] - 1]
        if entry["piece"] == 0:
            assert {word[0] for word in own.split()} <= {word[0] for word in entry["text"].split()}
    assert any(any(entry["correction_um"]) for entry in sent)
    answered = [entry["answered"] for entry in entries if "answered" in entry]
    assert answered == [entry["sent"] for entry in sent] == list(range(1, len(sent) + 1))


def test_A18_a_pipe_is_streamed_without_a_terminal(place):
    with PtyHost(model(), speed=4.0) as host, open(place / "job.nc") as source:
        status, out, err = stream(
            place, host, "-", "--no-journal", "--compact", "--quiet", stdin=source
        )
        assert status == 0, err
    assert out == "" and host.model.state == "Idle"
    assert len(sent_rows(host)) == len(wire_rows(place))
    assert sum(map(len, sent_rows(host))) < 0.8 * sum(map(len, wire_rows(place)))


def test_a_fault_in_a_pipe_ends_the_job_behind_what_was_good(place):
    (place / "bad.nc").write_text(program(20).replace("G0 Z20\nM30", "G0 X9999\nM30"))
    with PtyHost(model(), speed=4.0) as host, open(place / "bad.nc") as source:
        status, _, err = stream(place, host, "-", "--no-journal", stdin=source)
    assert status == 2 and "<stdin>:26" in err and "still" in err
    assert len(sent_rows(host)) > 20 and host.model.state == "Idle"


def test_A5_an_error_names_source_and_wire_line(place):
    text = program().split("\n")
    text[20] = "G1 X5 Y5 H7"
    (place / "job.nc").write_text("\n".join(text))
    (place / "m").mkdir()
    with PtyHost(model()) as host:
        status, out, err = stream(
            place, host, "job.nc", machine=("--machine", "perfect", "--dialect", "linuxcnc")
        )
    assert status == 10, err
    assert "source line 21, sent as wire line 20: G1 X5 Y5 H7" in err and "error:20" in err
    assert host.model.state == "Hold"


def test_A8_ctrl_c_holds_and_again_stops(place):
    (place / "job.nc").write_text(program(400, 600))
    with PtyHost(model(), speed=3.0) as host, running(place, host, 20, "job.nc") as process:
        pressed = time.monotonic()
        process.send_signal(signal.SIGINT)
        while not host.times and time.monotonic() - pressed < 5:
            time.sleep(0.001)
        assert host.times[0][1] == ord("!") and host.times[0][0] - pressed < 0.5
        time.sleep(0.5)
        assert host.model.state == "Hold"
        before = len(host.model.received)
        process.send_signal(signal.SIGUSR1)
        while len(host.model.received) < before + 3 and time.monotonic() - pressed < 20:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130, err
        assert "stopped by the user" in err and "may have been executed" in err
    assert [value for _, value in host.times] == [ord("!"), ord("~"), ord("!"), 0x18]
    rows = sent_rows(host)
    assert rows == wire_rows(place)[: len(rows)]


def test_A18_sigterm_holds_and_stops(place):
    (place / "job.nc").write_text(program(400, 600))
    with PtyHost(model(), speed=3.0) as host, running(place, host, 20, "job.nc") as process:
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130 and "SIGTERM" in err
    assert [value for _, value in host.times] == [ord("!"), 0x18]


@pytest.mark.parametrize(("options", "seen"), [((), True), (("--no-watch",), False)])
def test_the_watch_over_the_path_has_a_switch_of_its_own(place, options, seen):
    """A coordinate altered on the wire to a controller without echo, and set right by the next
    line."""
    (place / "job.nc").write_text(
        "G90 G21 G94 G17\nG54\nG0 X0 Y0\n" + "G1 X2 F600\nG1 X7 Y7\nG1 X3 Y3\n" * 5 + "M30\n"
    )
    with PtyHost(model(), speed=2.0) as host:
        write = host.model.write
        host.model.write = lambda data, now: write(data.replace(b"X7 Y7", b"X7 Y9"), now)
        machine = ("--machine", "perfect", "--dialect", "grbl")
        status, _, err = stream(place, host, "job.nc", *options, machine=machine)
    assert (status, "beside the path" in err) == ((15, True) if seen else (0, False)), err


def test_A10_a_port_that_goes_away(place):
    (place / "job.nc").write_text(program(400, 600))
    with PtyHost(model(), speed=5.0, hang_up_after=40) as host:
        status, _, err = stream(place, host, "job.nc", "--report", "broken.html")
    assert status == 13 and "the connection is lost" in err
    # What is certain, and the way out, stand on the page too, not on the terminal alone.
    page = (place / "broken.html").read_text("utf-8")
    assert "may have been executed" in page and "check where it stands" in page


def test_A10_a_controller_that_falls_silent(place):
    (place / "job.nc").write_text(program(400, 600))
    with PtyHost(model(), speed=5.0, silent_after=40) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 13 and "said nothing" in err


def test_A9_a_restart_of_the_controller(place):
    (place / "job.nc").write_text(program(400, 600))
    with PtyHost(model(), speed=4.0) as host, running(place, host, 30, "job.nc") as process:
        host.model.restart()
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 12 and "restarted" in err
    last = (place / "job.nc.journal").read_text().splitlines()[-1]
    assert json.loads(last)["position"] == "unknown"


def test_A10_A11_killed_and_resumed_from_the_journal(place):
    (place / "job.nc").write_text(program(200, 1200))
    with PtyHost(model(), speed=10.0) as host:
        with running(place, host, 80, "job.nc") as process:
            process.kill()
        past = journal.read((place / "job.nc.journal").read_bytes(), "j")
        assert 0 < past.answered <= past.sent and past.certain > 20
        assert len(sent_rows(host)) >= past.answered
        deadline = time.monotonic() + PATIENCE
        while host.model.state != "Idle" and time.monotonic() < deadline:  # it executes what it has
            time.sleep(0.05)
        arrived = len(host.model.received)
        status, _, err = stream(place, host, "job.nc", "--resume-from", "job.nc.journal")
        assert status == 2 and "say --yes" in err and "G53 G0 Z-180" in err
        status, _, err = stream(place, host, "job.nc", "--resume-from", "job.nc.journal", "--yes")
        assert status == 0, err
    line = int(re.search(r"beginning again with line (\d+)", err)[1])
    # it stands where the last line that it got ends, which the journal alone could not say
    assert line > past.certain
    rows = [row for row in host.model.received[arrived:] if not row.startswith("$")]
    whole = wire_rows(place)
    assert rows[2].startswith("G53G0Z")
    assert rows[-60:] == whole[-60:] or [r[:4] for r in rows[-60:]] == [r[:4] for r in whole[-60:]]
    status, _, err = stream(
        place, None, "job.nc", "--resume-from", "job.nc.journal", "--port", "/dev/null"
    )
    assert status == 2 and "the job was done" in err


def test_a_restart_waits_for_a_zero_that_is_certain(place):
    """A controller that lost its power believes that it stands at zero; --yes does not answer for
    that, homing or a person does."""
    (place / "job.nc").write_text(program(200, 1200))
    resume = ("job.nc", "--resume-from", "job.nc.journal", "--yes")
    with PtyHost(model(settings={"22": "1"}), speed=10.0) as host:
        host.model.state = "Idle"
        with running(place, host, 80, "job.nc") as process:
            process.kill()
        host.model.power()
        arrived = len(sent_rows(host))
        for more, says in (((), "locked (alarm)"), (("--unlock",), "the zero may be lost")):
            status, _, err = stream(place, host, *resume, *more)
            assert status == 2 and says in err, err
        assert len(sent_rows(host)) == arrived and host.model.lost != [0.0, 0.0, 0.0]
        status, _, err = stream(place, host, *resume, "--home")
        assert status == 0, err
    assert host.model.lost == [0.0, 0.0, 0.0]


def test_a_line_s_number_is_no_proof_of_the_zero(place):
    with PtyHost(model(), speed=10.0) as host:
        status, _, err = stream(place, host, "job.nc", "--resume-from", "30", "--yes")
        assert status == 2 and "no journal of this program" in err and not sent_rows(host)
        status, _, err = stream(
            place, host, "job.nc", "--resume-from", "30", "--yes", "--zero-is-right"
        )
        assert status == 0, err


def test_A15_check_mode(place):
    text = program().split("\n")
    text[20] = "G1 X5 Y5 H7"
    (place / "job.nc").write_text("\n".join(text))
    with PtyHost(model()) as host:
        status, _, err = stream(
            place,
            host,
            "job.nc",
            "--check",
            machine=("--machine", "perfect", "--dialect", "linuxcnc"),
        )
    assert status == 10 and "1 of " in err and "source line 21" in err
    assert host.model.state == "Idle" and host.model.place == [0, 0, 0]
    assert not (place / "job.nc.journal").exists()


def test_a_stated_zero_that_is_not_the_controllers_is_refused(place):
    with PtyHost(model()) as host:
        status, _, err = stream(place, host, "job.nc", "--offset", "G54=X0,Y0,Z-190")
    assert (
        status == 2 and "G54 is stated with Z = -190 mm, and the controller has Z = -200 mm" in err
    )
    assert not sent_rows(host)


def test_a_locked_controller_is_refused_and_homed_on_request(place):
    with PtyHost(model(homing=True), speed=6.0) as host:
        status, _, err = stream(place, host, "job.nc")
        assert status == 2 and "locked" in err
        status, _, err = stream(place, host, "job.nc", "--home")
        assert status == 0, err
    assert host.model.received.count("$H") == 1


def test_a_control_that_compensates_is_refused(place):
    made = model(
        settings={"160": "0.050"},
        version="1.1f.20240101:]\r\n[FIRMWARE:grblHAL",
        options="VN,35,{rx},3,0",
    )
    with PtyHost(made) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 2 and "compensates by itself: backlash of X, 50 um ($160)" in err


def test_a_fault_of_the_program_is_told_before_its_first_byte(place):
    (place / "job.nc").write_text(program().replace("G0 Z20\nM30", "G0 X9999\nM30"))
    with PtyHost(model()) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 2 and "job.nc:66" in err and not sent_rows(host)


def test_A19_the_warning_names_rates(place):
    rows = ["G90 G21 G94 G17 G54", "G0 X0 Y0 Z20"] + [
        f"G1 X{i * 0.1:.4f} Y{i % 2 * 0.01:.4f} F6000" for i in range(200)
    ]
    (place / "job.nc").write_text("\n".join(rows) + "\nM30\n")
    with PtyHost(model()) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 0 and "lines/s of" in err and "the link carries" in err


def test_nobody_there_and_other_usage(place):
    master, slave = os.openpty()
    status, _, err = stream(
        place, None, "job.nc", "--port", os.ttyname(slave), "--protocol", "grbl"
    )
    assert status == 2 and "nobody answers" in err
    for arguments, says in (
        (("job.nc",), "--port is missing"),
        (("job.nc", "--port", "/dev/no-such-port"), "can not be opened"),
        (("no.nc", "--port", "x"), "no such file"),
        (
            ("job.nc", "--port", "x", "--expand", "--resume-from", "3"),
            "write the program out first",
        ),
        (("job.nc", "--port", os.ttyname(slave), "--protocol", "no"), "there is no protocol 'no'"),
        (("--port", "x", "--resume-from", "3"), "needs the program as a file"),
        (("job.nc", "--port", "x", "--compact", "--on-error", "continue"), "--compact"),
    ):
        status, _, err = stream(place, None, *arguments)
        assert status == 2 and says in err, err
    os.close(master), os.close(slave)


def test_a_flaky_link_is_no_success(place):
    """A byte lost on the way back, through the proxy."""
    with PtyHost(
        model(), speed=4.0, faults=Faults(back={700: "drop", 703: "drop", 706: "drop", 709: "drop"})
    ) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status in (0, 14), err
    assert (status == 0) == (host.model.accepted[-1] == "M30" and "still" in err)


class Alters(Faults):
    """One coordinate on its way to the controller."""

    def pass_on(self, way: str, data: bytes) -> bytes:
        return data.replace(b"X5.8", b"X9.8") if way == "to" else super().pass_on(way, data)


def test_A5_an_altered_coordinate_is_seen_in_the_reports_of_a_controller_without_echo(place):
    """Exit 15 with the lines and the distance; the journal keeps where to look."""
    rows = [
        "G90 G21 G94 G17",
        "G54",
        "G0 X0 Y0 Z20",
        "G1 X5.8 Y0 F600",
        *(f"G1 X5.8 Y{i}" for i in range(1, 60)),
        "M30",
    ]
    (place / "job.nc").write_text("\n".join(rows) + "\n")
    with PtyHost(model(), faults=Alters(), speed=2.0) as host:
        status, out, err = stream(
            place, host, "job.nc", machine=("--machine", "perfect", "--dialect", "grbl")
        )
    assert status == 15 and "beside the path" in err and "source lines" in err, err
    assert (
        host.times[0][1] == ord("!")
        and json.loads(out.strip().split("\n")[-1])["exit_status"] == 15
    )
    assert '"position":"known"' in (place / "job.nc.journal").read_text()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--report", "nowhere/run.html"), "nowhere is not there"),
        (("--json", "nowhere/run.json"), "nowhere is not there"),
        (("--report", "run", "--json", "./run"), "two things are to be written to run"),
        (("--report", "."), "is a folder"),
    ],
)
def test_where_a_report_can_not_go_is_said_before_the_first_byte(place, capsys, words, says):
    with contextlib.chdir(place):
        status = cli.main(["stream", *MILL, "--port", "/dev/null", *words, "job.nc"])
    assert status == 2 and says in capsys.readouterr().err
