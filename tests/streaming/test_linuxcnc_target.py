"""LinuxCNC as a target of `gcomp stream`: what linuxcncrsh says, by word, and jobs on LinuxCNC
itself."""

from __future__ import annotations

import re
import signal
import time

import numpy as np
import pytest

from postproc.streaming.events import Accepted, Alarm, Rejected, Restarted, Status
from postproc.streaming.lines import Unsendable
from postproc.streaming.protocols import linuxcnc
from tests.linuxcnc import remote
from tests.streaming.real_grbl import in_order, start

WHY = remote.available()
REAL = (pytest.mark.real, pytest.mark.skipif(bool(WHY), reason=str(WHY)))
LINES = [b"G21 G90", b"G1 X1 F600", b"G1 X2", b"M5", b"G0 X2", b"M2"]


def started(n: int = len(LINES)) -> linuxcnc.Linuxcnc:
    """A connection on which a program runs."""
    protocol = linuxcnc.PROTOCOL()
    protocol.hand_over("job.ngc")
    for number, text in zip((-1, -2, -3), protocol.opening, strict=True):
        assert protocol.ready(text) and protocol.send(number, text) == text + b"\r\n"
        assert not protocol.ready(b"G1 X1")
        key = text.split()[1].decode().upper()
        assert protocol.receive(f"SET {key} ACK\n\r".encode()) == [Accepted(number)]
    for number, text in enumerate(LINES[:n], 1):
        assert protocol.ready(text) and protocol.send(number, text) == b""
    return protocol


def report(protocol, line, state="RUNNING", error="OK", display="OK", machine="ON"):
    """What one question for the status is answered with, and the events that come of it."""
    said = f"ERROR {error}\r\nOPERATOR_DISPLAY {display}\r\nOPERATOR_TEXT OK\r\n"
    said += f"MACHINE {machine}\r\nPROGRAM_LINE {line}\r\nPROGRAM_STATUS {state}\r\n"
    said += "ABS_ACT_POS 1.000000 0.000000 0.000000 0.000000 0.000000 0.000000\r\n"
    return [e for e in protocol.receive(said.encode()) if not isinstance(e, Status)]


def test_the_file_keeps_the_numbers_of_the_wire():
    text = b"".join(linuxcnc.PROTOCOL().file_of(LINES)).split(b"\n")
    assert text[: len(LINES)] == [b"%", *LINES[:-1]]
    mark = b"(MSG," + linuxcnc.DONE.encode() + b")"
    assert text[len(LINES) :] == [b"G4 P1", mark, b"M2", b"%", b""]
    assert b"(MSG," in b"".join(linuxcnc.PROTOCOL().file_of([b"G1 X1"]))


def test_lines_are_over_when_the_line_in_execution_is_behind_them():
    """The first report behind the order may still say the last line of the program before: the
    lower one of two counts."""
    protocol = started()
    assert report(protocol, 104) == []
    assert report(protocol, 3) == [Accepted(1)]
    assert report(protocol, 4) == []
    assert report(protocol, 4) == [Accepted(2)]
    assert report(protocol, 4, "IDLE", display=linuxcnc.DONE) == [Accepted(n) for n in (3, 4, 5, 6)]


def test_a_program_that_was_ended_at_the_panel_is_never_done():
    protocol = started()
    report(protocol, 3)
    report(protocol, 3)
    assert report(protocol, 104, "IDLE") == []
    events = report(protocol, 104, "IDLE")
    assert [type(e) for e in events] == [Alarm] and "before its end" in events[0].meaning


def test_where_another_panel_takes_the_message_the_last_motion_must_have_been_seen():
    protocol = started()
    report(protocol, 6)
    report(protocol, 6)
    assert report(protocol, 8, "IDLE")[-1] == Accepted(6)


def test_what_it_refuses_is_reported_with_the_line_where_it_says_one():
    events = report(started(), 3, error="Linear move on line 4 would exceed X's positive limit")
    assert [type(e) for e in events] == [Rejected] and events[0].number == 3
    events = report(started(), 3, error="Unknown word starting with r")
    assert [type(e) for e in events] == [Alarm] and "Unknown word" in events[0].meaning
    events = report(started(), 3, machine="OFF")
    assert [type(e) for e in events] == [Alarm] and events[0].code == "off"


def test_an_abort_that_gcomp_ordered_is_no_alarm():
    protocol = started()
    report(protocol, 3)
    assert [type(e) for e in protocol.receive(b"SET ABORT ACK\n\r")] == [Restarted]
    assert report(protocol, 104, "IDLE") == [] and report(protocol, 104, "IDLE") == []


def test_its_zeros_are_read_from_its_parameters():
    protocol = linuxcnc.PROTOCOL()
    question = b"get operator_display"
    work = "G54 -10.000000 2.000000 -30.500000 G59.1 0.000000 0.000000 1.000000"
    others = "G92 1.000000 2.000000 3.000000 TLO 0.000000 0.000000 12.500000 on 0.000000"
    for said in (work, others):
        protocol.learn(question, [f"OPERATOR_DISPLAY {said}"])
    assert protocol.controller.offsets == [
        "[G54:-10.000000,2.000000,-30.500000]",
        "[G59.1:0.000000,0.000000,1.000000]",
        "[TLO:12.500000]",
    ]


def test_a_path_that_linuxcncrsh_can_not_hold_is_refused():
    """It keeps a command in 256 bytes and does not look whether it fits."""
    with pytest.raises(Unsendable, match="too long for linuxcncrsh"):
        linuxcnc.PROTOCOL().hand_over("/" + "x" * 260)


# -- LinuxCNC itself -----------------------------------------------------------------------------

ZERO = (-10.0, -20.0, -30.0)
CORNERS = [(0.5 * (i % 2) + i * 0.4, 1.0 * (i % 2)) for i in range(30)]
JOB = ["G21 G90 G94 G17 G61", "G54", "G0 Z5", "G0 X0 Y0", "G1 Z-1 F900"]
JOB += [f"G1 X{x:.3f} Y{y:.3f} F1200\nG4 P0.25" for x, y in CORNERS]
JOB += ["G0 Z5", "G0 X0 Y0", "G0 Z5", "M2"]


def stream(place, port, *arguments):
    how = ("--dialect", "linuxcnc", "--protocol", "linuxcnc", "--quiet")
    return start(place, port.path, "job.nc", *how, *arguments)


def passed(port) -> int:
    """How many of the corners the joints stood at, in order, within a micrometre: 250 ms each, so
    that a busy computer sees them too (of 50 ms it saw 11 and 19 of 30)."""
    way = np.array(port.joints())[:, 1:]
    return in_order(way, np.array([(x, y, -1.0) for x, y in CORNERS]) + ZERO, 0.001)


@pytest.mark.parametrize("how", ["held", "stopped"])
@REAL[0]
@REAL[1]
def test_a_job_on_linuxcnc_itself(tmp_path, how):
    """Held and resumed; stopped, and begun again from its journal: every corner, in order."""
    (tmp_path / "job.nc").write_text("\n".join(JOB) + "\n")
    journal = tmp_path / "job.nc.journal"
    with remote.Remote({5221: ZERO[0], 5222: ZERO[1], 5223: ZERO[2]}) as port:
        process = stream(tmp_path, port)
        deadline = time.monotonic() + 60
        while not (journal.exists() and b'"answered":20' in journal.read_bytes()):
            assert time.monotonic() < deadline and process.poll() is None, process.communicate()
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        time.sleep(1.0)
        held = port.joints()
        time.sleep(0.3)
        assert port.joints() == held
        process.send_signal(signal.SIGUSR1 if how == "held" else signal.SIGINT)
        _, said = process.communicate(timeout=60)
        if how == "stopped":
            assert process.returncode == 130 and "told to abort" in said, said
            resume = ("--resume-from", "job.nc.journal", "--yes", "--zero-is-right")
            process = stream(tmp_path, port, *resume)
            _, said = process.communicate(timeout=60)
        assert process.returncode == 0 and re.search("the machine stands still", said), said
        assert passed(port) == len(CORNERS)
