"""`gcomp stream` as a process: what is refused or said before the first byte."""

from __future__ import annotations

import contextlib
import os

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc import cli  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import MILL, model, program, sent_rows, stream  # noqa: E402


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


def test_a_fault_of_the_program_is_reported_before_its_first_byte(place):
    (place / "job.nc").write_text(program().replace("G0 Z20\nM30", "G0 X9999\nM30"))
    with PtyHost(model()) as host:
        status, _, err = stream(place, host, "job.nc")
    assert status == 2 and "job.nc:66" in err and not sent_rows(host)


def test_nobody_there_and_other_usage(place):
    master, slave = os.openpty()
    status, _, err = stream(
        place, None, "job.nc", "--port", os.ttyname(slave), "--protocol", "grbl"
    )
    assert status == 2 and "no answer on" in err
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
