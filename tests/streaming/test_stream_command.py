"""`gcomp stream` as a process on a pseudo-terminal, with the model behind it in real time: jobs
that run, holds and stops, judged by the bytes that the model took and the journal."""

from __future__ import annotations

import json
import re
import signal

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc.recordings import ReadingOptions, Source, contract  # noqa: E402
from postproc.streaming import journal  # noqa: E402
from tests.api.schemas import held  # noqa: E402
from tests.pages import drawn  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import (  # noqa: E402
    PATIENCE,
    model,
    program,
    running,
    sent_rows,
    stream,
    wire_rows,
)


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
    # the figure ends as the job does, and not with the last report while it ran
    ends = {name: (curves[name]["x"][-1], curves[name]["y"][-1]) for name in list(curves)[:3]}
    assert ends == {
        "sent": (told["seconds"], told["sent"]),
        "answered": (told["seconds"], told["answered"]),
        "surely over": (told["seconds"], told["executed"]),
    }
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
        process.send_signal(signal.SIGINT)
        assert host.soon(lambda: host.model.state == "Hold")  # how soon: test_hold_always.py
        before = len(host.model.received)
        process.send_signal(signal.SIGUSR1)
        assert host.soon(lambda: len(host.model.received) >= before + 3)
        process.send_signal(signal.SIGINT)
        assert host.soon(lambda: len(host.times) >= 3)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130, err
        assert "stopped by the user" in err
    assert host.orders() == [ord("!"), ord("~"), ord("!"), 0x18]
    rows = sent_rows(host)
    assert rows == wire_rows(place)[: len(rows)]
    # what is not answered is said to be open; all may be, of a sender that had no time to send more
    last = int(re.search(r"last line answered: wire line (\d+)", err)[1])
    assert ("may have been executed" in err) == (last < len(rows)), err


def test_A18_sigterm_holds_and_stops(place):
    (place / "job.nc").write_text(program(400, 600))
    with PtyHost(model(), speed=3.0) as host, running(place, host, 20, "job.nc") as process:
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130 and "SIGTERM" in err
    assert host.orders() == [ord("!"), 0x18]


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


def test_A19_the_warning_names_rates(place):
    rows = ["G90 G21 G94 G17 G54", "G0 X0 Y0 Z20"] + [
        f"G1 X{i * 0.1:.4f} Y{i % 2 * 0.01:.4f} F6000" for i in range(200)
    ]
    (place / "job.nc").write_text("\n".join(rows) + "\nM30\n")
    with PtyHost(model()) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 0 and "lines/s of" in err and "the link carries" in err
