"""A program that changes on the disk while its job runs changes nothing of the job; and it is
told."""

from __future__ import annotations

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc import ports  # noqa: E402
from postproc.errors import UsageError  # noqa: E402
from postproc.streaming import journal  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import (  # noqa: E402
    PATIENCE,
    model,
    program,
    running,
    sent_rows,
    start,
    stream,
    wire_rows,
)

NOTICE = "was changed while the job ran; what was sent is the program as it was when the job began"


@pytest.mark.parametrize("how", ["rewritten", "replaced", "removed"])
def test_a_program_that_changes_on_the_disk_is_not_seen(place, how):
    """In the middle of the job, long before its lines are read for sending: 700 lines, of which 40
    have arrived."""
    (place / "job.nc").write_text(program(700, 60000))
    rows = wire_rows(place)
    with (
        PtyHost(model(), speed=8.0) as host,
        running(place, host, 40, "job.nc", "--quiet") as process,
    ):
        file = place / "job.nc"
        if how == "rewritten":
            with open(file, "r+b") as writer:
                writer.write(program(700, 60000).replace("G1 X", "G1 Z").encode())
        elif how == "replaced":
            (place / "new").write_text(program(10))
            (place / "new").rename(file)
        else:
            file.unlink()
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0 and NOTICE in err, err
        assert sent_rows(host) == rows


def test_a_subprogram_that_changes_is_not_seen_either(place):
    whole = (
        "G90 G21 G94 G17 G54\nG0 X0 Y0 Z20\nG1 Z10 F30000\n"
        + "o<side> call\n" * 120
        + "G0 Z20\nM2\n"
    )
    (place / "job.nc").write_text(whole)
    side = "o<side> sub\nG1 X5 Y1\nG1 X0 Y2\nG1 X1 Y3\no<side> endsub\n"
    (place / "side.ngc").write_text(side)
    options = ("--expand", "--quiet")
    machine = ("--machine", "perfect", "--dialect", "linuxcnc", "--protocol", "grbl")
    with PtyHost(model(), speed=8.0) as host:
        process = start(place, host, "job.nc", *options, machine=machine)
        while len(sent_rows(host)) < 20:
            assert process.poll() is None, process.communicate()
        (place / "side.ngc").write_text(side.replace("X5", "X50"))
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0, err
        assert sum("X5" in row for row in sent_rows(host)) == 120
        assert not any("X50" in row for row in sent_rows(host))


def test_the_journal_is_of_what_was_sent(place):
    """So a restart of another program by it is refused."""
    (place / "job.nc").write_text(program(700, 60000))
    with (
        PtyHost(model(), speed=8.0) as host,
        running(place, host, 40, "job.nc", "--quiet") as process,
    ):
        digest = ports.Copy(str(place / "job.nc")).digest
        (place / "job.nc").write_text(program(10))
        process.kill()
        past = journal.read((place / "job.nc.journal").read_bytes(), "j")
        assert past.head["sha256"] == digest != ports.Copy(str(place / "job.nc")).digest
        status, _, err = stream(place, host, "job.nc", "--resume-from", "job.nc.journal", "--yes")
    assert status == 2 and "was changed since" in err


def test_a_program_that_is_being_written_is_refused(tmp_path, monkeypatch):
    file = tmp_path / "job.nc"
    file.write_text(program())
    taken = ports.chunks

    def chunks(source, live):
        for data in taken(source, live):
            yield data
            file.write_text(program(70))

    monkeypatch.setattr(ports, "chunks", chunks)
    with pytest.raises(UsageError, match="is being written"):
        ports.Copy(str(file))
