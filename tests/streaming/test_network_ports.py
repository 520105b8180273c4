"""`gcomp stream` over a network: raw bytes, and RFC 2217 with a server that nobody here wrote (A1,
A8, A10)."""

from __future__ import annotations

import signal
import socket
import time

import pytest

pytest.importorskip("pty", reason="processes and signals as POSIX has them")

from tests.streaming.models_dnc import DncModel  # noqa: E402
from tests.streaming.net_host import NetHost  # noqa: E402
from tests.streaming.stream_process import model, program, running, sent_rows, stream, wire_rows  # noqa: E402

BOTH = pytest.mark.parametrize("rfc2217", [False, True], ids=["socket", "rfc2217"])


@BOTH
def test_A1_A16_a_job_over_a_network(place, rfc2217):
    with NetHost(model(), rfc2217, speed=4.0) as host:
        status, _, err = stream(place, None, "job.nc", "--port", host.path, "--baud", "57600")
    assert status == 0, err
    assert (
        sent_rows(host) == wire_rows(place)
        and host.model.dropped == 0
        and host.model.state == "Idle"
    )
    assert host.wire.baudrate == (57600 if rfc2217 else 9600)


def test_the_line_behind_an_rfc2217_server_is_set_as_asked_for(place):
    """Frame and DTR reach the far end."""
    with NetHost(model(), rfc2217=True, speed=4.0) as host:
        options = ("--frame", "7E2", "--baud", "19200", "--no-reset-on-open")
        status, _, err = stream(place, None, "job.nc", "--port", host.path, *options)
    assert status == 0, err
    wire = host.wire
    assert (wire.baudrate, wire.bytesize, wire.parity, wire.stopbits, wire.dtr, wire.rts) == (
        19200,
        7,
        "E",
        2,
        False,
        False,
    )
    assert not wire.xonxoff and not wire.rtscts


def test_A14_rts_and_cts_are_switched_on(place):
    with NetHost(model(), rfc2217=True, speed=4.0) as host:
        status, _, err = stream(place, None, "job.nc", "--port", host.path, "--rtscts")
    assert status == 0, err
    assert host.wire.rtscts and not host.wire.xonxoff


@BOTH
def test_A8_ctrl_c_over_a_network(place, rfc2217):
    (place / "job.nc").write_text(program(400, 600))
    with (
        NetHost(model(), rfc2217, speed=3.0) as host,
        running(place, host, 20, "job.nc") as process,
    ):
        process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + 20
        while host.model.state != "Hold" and time.monotonic() < deadline:
            time.sleep(0.01)
        assert host.model.state == "Hold"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        assert process.returncode == 130 and "Ctrl-X" in err


@BOTH
def test_A10_a_server_that_goes_away(place, rfc2217):
    (place / "job.nc").write_text(program(400, 600))
    with NetHost(model(), rfc2217, speed=5.0, hang_up_after=40) as host:
        status, _, err = stream(place, None, "job.nc", "--port", host.path)
    assert status == 13 and "the connection is lost" in err, err


@BOTH
def test_nobody_listens(place, rfc2217):
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]
    port = f"{'rfc2217' if rfc2217 else 'socket'}://127.0.0.1:{number}"
    status, _, err = stream(place, None, "job.nc", "--port", port)
    assert status == 2 and f"{port} can not be opened: Connection refused\n" in err, err
    assert "is no other program connected to it" in err


def test_a_server_that_is_no_rfc2217_is_refused(place):
    with NetHost(model(), rfc2217=False) as host:
        status, _, err = stream(
            place, None, "job.nc", "--port", host.path.replace("socket", "rfc2217")
        )
    assert status == 2 and "can not be opened" in err and not sent_rows(host), err


@BOTH
def test_A14_dnc_over_a_device_server(place, rfc2217):
    """A control behind a box on the network: it waits for DC1 (its operator presses start when the
    port is open), and the program arrives whole: it reads more slowly than the line, and its buffer
    overflows where DC3 is not obeyed, or a whole program is put into the box at once."""
    rows = [f"N{i} G1 X{i % 40}.5 Z-{i % 7}.25 F200" for i in range(1, 61)]
    (place / "job.nc").write_text("\n".join(["%", "O0001", "G21 G90 G94", *rows, "M30", "%", ""]))
    with NetHost(DncModel(baud=9600, rx=700, rate=200.0, begins=8.0), rfc2217, speed=4.0) as host:
        how = ("--machine", "perfect", "--dialect", "fanuc-mill", "--protocol", "dnc")
        job = ("job.nc", *how, "--no-journal", "--baud", "19200")
        status, _, err = stream(place, None, *job, "--port", host.path)
        deadline = time.monotonic() + 20
        while not host.model.ended and time.monotonic() < deadline:
            time.sleep(0.05)
    assert status == 17 and "tells nothing of what became of them" in err, err
    assert host.model.ended and not host.model.alarm and not host.model.odd
    assert "the tool is" not in err
    assert [row for row in host.model.received if row.startswith("N")] == rows
