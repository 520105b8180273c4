"""`gcomp control`: what is needed between jobs, and what every state of a controller asks for."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from postproc.cli import main  # noqa: E402
from postproc.commands.stream import ports_found  # noqa: E402
from postproc.errors import UsageError  # noqa: E402
from postproc.streaming import orders  # noqa: E402
from postproc.streaming.events import Status  # noqa: E402
from postproc.streaming.protocols.grbl import Grbl  # noqa: E402
from tests.api.schemas import held  # noqa: E402
from tests.streaming import real_grbl  # noqa: E402
from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.real_grbl import STEPS, RealGrbl  # noqa: E402
from tests.streaming.stream_process import ROOT, model  # noqa: E402

WHY = real_grbl.missing()


def control(port: str, *words: str) -> tuple[int, str]:
    """As a process of its own would, without the time that one takes to begin."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(["control", "--port", port, *words])
    assert "Traceback" not in err.getvalue(), err.getvalue()
    return status, out.getvalue() + err.getvalue()


def test_its_state_may_be_asked_for_by_name():
    """As `gcomp control --help` names it first of all that it does."""
    with PtyHost(model()) as host:
        assert control(host.path, "state") == control(host.path)


def test_an_order_is_over_when_the_controller_rests_in_two_reports():
    """A report may have been on its way when the order was answered: it does not count; nor do two
    between which the machine moved."""
    order = orders.Order(Grbl(), orders.HOME, [], None)
    order.begin(0.0)
    assert order.bytes_out() == b"$H\n"
    order.receive(b"ok\r\n", 0.1)
    over = []
    for state in (b"Idle", b"Idle", b"Home", b"Idle", b"Idle"):
        order.receive(b"<%s|MPos:0.000,0.000,0.000|FS:0,0>\r\n" % state, 0.2)
        over.append(order.done)
    assert over == [False, False, False, False, True]


def test_as_a_process():
    with PtyHost(model()) as host:
        done = subprocess.run(
            [sys.executable, "-m", "postproc", "control", "--port", host.path],
            capture_output=True,
            text=True,
            timeout=60,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
    assert (done.returncode, done.stdout, done.stderr) == (
        0,
        "idle: it stands, and takes a job\n",
        "",
    )


@pytest.mark.skipif(bool(WHY), reason=WHY)
@pytest.mark.real
def test_a_real_grbl_by_orders_alone(tmp_path):
    """Hold, run, check, alarm, sleep are named with the order that helps; jog, zero, send do what
    they say, by the motors' steps."""
    with RealGrbl(tmp_path) as real:
        path = real.path
        assert control(path, "jog", "X5", "F1500")[0] == 0
        assert real.steps()[-1].tolist() == [5 * STEPS, 0, 0]
        assert control(path, "zero", "X")[0] == 0
        status, said = control(path, "send", "$#")
        assert status == 0 and "[G54:5.000," in said
        assert control(path, "send", "G1", "X-2", "F900")[0] == 0
        assert real.steps()[-1].tolist() == [3 * STEPS, 0, 0]
        real.talk("G1 X40 F100", "!", seconds=0.3)
        status, said = control(path)
        assert status == 0 and said.startswith("hold:0: it holds the feed. Resume goes on"), said
        assert said.endswith(f": gcomp control --port {path} resume | reset\n"), said
        status, said = control(path, "jog", "X1")
        assert status == 2 and "a jog needs an idle controller" in said
        status, said = control(path, "resume")
        assert status == 0 and said.startswith("run"), said
        assert "wait; or reset" in control(path)[1].lower()
        real.talk("!", seconds=0.5)
        status, said = control(path, "reset")
        assert status == 0 and "Grbl 1.1h" in said and "idle: it stands" in said
        real.talk("$C")
        assert "check: it is in check mode. Reset ends that" in control(path)[1]
        assert "idle" in control(path, "reset")[1]
        real.talk("G1 X90 F100", seconds=0.3)  # half a minute, whatever else is running
        assert control(path, "reset")[0] == 0  # in motion: it locks
        assert "alarm: it is locked" in control(path)[1]
        status, said = control(path, "send", "G0 X1")
        assert status == 2 and "home it; or unlock" in said.lower()
        assert control(path, "unlock")[0] == 0 and "idle" in control(path)[1]
        status, said = control(path, "home")
        assert status == 10 and "refused it: error:5" in said  # its homing is switched off
        real.talk("$SLP")
        assert "sleep: it sleeps. Reset wakes it" in control(path)[1]


def test_homing_and_nothing_to_resume(tmp_path):
    with PtyHost(model(homing=True), speed=5.0) as host:
        assert "alarm: it is locked" in control(host.path)[1]
        status, said = control(host.path, "home")
        assert status == 0 and "idle" in said
        for words in ((), ("send", "G4 P0.01")):
            status, _ = control(host.path, *words, "--json", str(tmp_path / "found.json"))
            found = json.loads((tmp_path / "found.json").read_text())
            held(found)
            assert status == 0 and found["state"]["name"] == "idle"
        status, said = control(host.path, "resume")
        assert status == 2 and "there is nothing to resume: the controller is idle" in said


@pytest.mark.parametrize(
    ("order", "words", "line"),
    [
        ("jog", ["x10", "Y-.5", "f800"], b"$J=G91 G21 X10 Y-.5 F800"),
        ("zero", ["x", "Z"], b"G10 L20 P0 X0 Z0"),
        ("send", ["$10=1"], b"$10=1"),
        ("home", [], b"$H"),
        ("reset", [], b""),
    ],
)
def test_the_lines_of_orders(order, words, line):
    assert orders.line_of(order, words) == line


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ("jog", []),
        ("jog", ["F100"]),
        ("jog", ["10"]),
        ("jog", ["X1", "F0"]),
        ("zero", []),
        ("zero", ["X0"]),
        ("send", []),
        ("send", ["!"]),
        ("home", ["X"]),
    ],
)
def test_orders_that_are_none(order, words):
    with pytest.raises(UsageError):
        orders.line_of(order, words)


def test_every_state_names_a_way():
    for state in (*orders.STATES, "idle", "strange"):
        words = orders.in_words(Status(state), "P")
        helps = bool(orders.STATES.get(state, orders.STRANGE)[2]) and state != "idle"
        assert words.startswith(state) and ("gcomp control --port P" in words) == helps


def test_ports_by_name(monkeypatch, capfd):
    usb = [
        SimpleNamespace(
            device=f"/dev/ttyUSB{i}",
            description="CNC",
            manufacturer="Maker",
            serial_number=f"A{i}",
            vid=1,
            hwid="x",
        )
        for i in range(2)
    ]
    empty = SimpleNamespace(
        device="/dev/ttyS0",
        description="n/a",
        manufacturer=None,
        serial_number=None,
        vid=None,
        hwid="n/a",
    )
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [empty, *usb])
    assert ports_found.listed().splitlines()[1] == "/dev/ttyUSB1  CNC, Maker, serial number A1"
    assert main(["control", "--list-ports", "--json", "-"]) == 0
    held(json.loads(capfd.readouterr().out))
    assert ports_found.chosen("COM3") == "COM3"
    with pytest.raises(UsageError, match="there are 2 ports"):
        ports_found.chosen("auto")
    with pytest.raises(UsageError, match="--port is missing"):
        ports_found.chosen(None)
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [empty, usb[0]])
    assert ports_found.chosen("auto") == "/dev/ttyUSB0"
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [empty])
    with pytest.raises(UsageError, match="no serial port is plugged in"):
        ports_found.chosen("auto")
