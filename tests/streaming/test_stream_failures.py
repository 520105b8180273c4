"""`gcomp stream` as a process when something fails: the port, the controller, the link or the
process itself, and how a job goes on."""

from __future__ import annotations

import json
import re

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc.streaming import journal, protocols  # noqa: E402
from tests.streaming.bench import Faults  # noqa: E402
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
        assert host.soon(host.idle)  # it executes what it has
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
        assert host.soon(host.read_all)
        host.power()
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


def test_an_axis_that_was_jogged_since_goes_back_to_where_the_journal_had_it(place):
    """The program names no Y: it stood at 150 when it began, and somebody moved it to 20."""
    whole = ["G21 G90 G94 G17 G54", "G0 Z20", "G0 X10", "M3 S9000", "G1 Z2 F300"]
    whole += [f"G1 X{10 + i % 7}" for i in range(60)]
    (place / "job.nc").write_text("\n".join([*whole, "G0 Z20", "M30", ""]))
    made = model()
    made.place[1] = made.target[1] = 150.0
    with PtyHost(made, speed=10.0) as host:
        with running(place, host, 30, "job.nc") as process:
            process.kill()
        assert host.soon(host.idle)
        made.place[1] = made.target[1] = 20.0
        resume = ("job.nc", "--resume-from", "40", "--yes", "--zero-is-right")
        status, _, err = stream(place, host, *resume)
        assert status == 0, err
        assert made.place[1] == pytest.approx(150.0, abs=0.1)
        (place / "job.nc.journal").unlink()
        status, _, err = stream(place, host, *resume)
        assert status == 2 and "where Y stands before it is not known" in err, err


def test_what_asks_a_late_controller_is_no_row_of_the_job():
    """Marlin's question begins with an empty line, which a GRBL that greets late receives, too."""
    with PtyHost(model()) as host:
        for poke in protocols.pokes():
            host.press(poke)
        assert host.soon(lambda: "M115" in host.model.received and host.read_all())
        assert host.soon(lambda: "VERSION" in host.model.received)
        assert "" in host.model.received and sent_rows(host) == []


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
