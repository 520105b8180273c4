"""`gcomp stream` with a person at the keyboard: refused lines are asked for, holds of others are
told (A5, A8)."""

from __future__ import annotations

import contextlib
import os
import threading
import time

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import PATIENCE, model, program, sent_rows, start, stream  # noqa: E402

AS_IT_IS = ("--machine", "perfect", "--dialect", "linuxcnc")


class Person:
    """Reads standard error, and types on the terminal that is standard input."""

    def __init__(self, folder, host, *arguments, machine=AS_IT_IS):
        self.keyboard, slave = os.openpty()
        self.process = start(folder, host, *arguments, machine=machine, stdin=slave)
        os.close(slave)
        self.text = ""
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        self._out = threading.Thread(target=self.process.stdout.read, daemon=True)
        self._out.start()

    def _read(self) -> None:
        for line in self.process.stderr:
            self.text += line

    def until(self, words: str, count: int = 1) -> None:
        deadline = time.monotonic() + PATIENCE
        while self.text.count(words) < count:
            assert time.monotonic() < deadline and self.process.poll() is None, self.text
            time.sleep(0.005)

    def types(self, text: str) -> None:
        os.write(self.keyboard, text.encode())

    def end(self) -> int:
        try:
            return self.process.wait(PATIENCE)
        finally:
            self.process.kill()
            self._thread.join(5)
            with contextlib.suppress(OSError):
                os.close(self.keyboard)


def bad(place, *rows: int) -> None:
    text = program().split("\n")
    for row in rows:
        text[row - 1] = f"G1 X5 Y{row % 9} H7"
    (place / "job.nc").write_text("\n".join(text))


def test_A5_ask_continue_goes_on_without_the_line(place):
    bad(place, 21, 41)
    with PtyHost(model(), speed=4.0) as host:
        person = Person(place, host, "job.nc", "--on-error", "ask")
        person.until("c goes on")
        assert (
            "source line 21, sent as wire line 20: G1 X5 Y3 H7" in person.text
            and "error:20" in person.text
        )
        assert host.soon(lambda: host.model.state == "Hold") and host.times[0][1] == ord("!")
        before = len(sent_rows(host))
        person.types("whatever\n")
        person.until("c goes on", 2)
        assert len(sent_rows(host)) == before < len(program().split("\n")) - 10
        person.types("c")
        person.until("source line 41")
        person.until("c goes on", 3)
        person.types("c")
        assert person.end() == 10, person.text
    assert "2 of " in person.text and host.model.state == "Idle"
    rows = (place / "job.nc").read_text().split("\n")
    assert sent_rows(host) == [
        row.replace(" ", "") for row in rows if row and not row.startswith("(")
    ]
    assert host.orders() == [ord("!"), ord("~"), ord("!"), ord("~")]


@pytest.mark.parametrize("typed", ["s", "\x04"])
def test_A5_ask_stop_or_a_keyboard_that_is_gone_ends_in_a_hold(place, typed):
    bad(place, 21)
    with PtyHost(model(), speed=4.0) as host:
        person = Person(place, host, "job.nc", "--on-error", "ask")
        person.until("c goes on")
        person.types(typed)
        assert person.end() == 10, person.text
    assert host.model.state == "Hold" and "M30" not in sent_rows(host)
    assert "resume (~) executes what it has" in person.text.rsplit("c goes on", 1)[1]


def test_A5_ask_without_a_terminal_is_refused_before_anything_is_sent(place):
    with PtyHost(model()) as host:
        status, _, err = stream(place, host, "job.nc", "--on-error", "ask")
        assert (
            status == 2
            and "standard input is none" in err
            and "--on-error stop, or --on-error continue" in err
        )
        with open(place / "job.nc") as source:
            status, _, err = stream(place, host, "-", "--on-error", "ask", stdin=source)
        assert status == 2 and "needs the program as a file" in err
        assert not host.heard
        person = Person(place, host, "job.nc", "--on-error", "ask", "--compact")
        assert person.end() == 2 and "--compact" in person.text
        assert not host.heard


def test_A8_a_button_at_the_machine_is_reported_and_a_key_goes_on(place):
    (place / "job.nc").write_text(program(120, 1200))
    with PtyHost(model(), speed=4.0) as host:
        person = Person(place, host, "job.nc")
        while len(sent_rows(host)) < 20 and person.process.poll() is None:
            time.sleep(0.005)
        host.press(b"!")
        person.until("not by gcomp's order")
        assert host.soon(lambda: host.model.state == "Hold")
        person.types("\n \x1b[A7")  # by mistake
        person.until("r goes on, s stops")
        assert host.model.state == "Hold"
        person.types("r")
        assert person.end() == 0, person.text
    assert sent_rows(host)[-1] == "M30" and host.orders() == [ord("~")]


def test_A8_keys_hold_override_and_stop_without_enter(place):
    (place / "job.nc").write_text(program(200, 600))
    with PtyHost(model(), speed=4.0) as host:
        person = Person(place, host, "job.nc")
        while len(sent_rows(host)) < 20 and person.process.poll() is None:
            time.sleep(0.005)
        person.types("rs?")  # nothing holds: neither resumes nor stops anything
        person.until("h holds the feed")
        person.types("+1<")
        person.until("override: spindle-")
        # Feed 10 % up, rapids 25 %, spindle 10 % down: GRBL's realtime bytes.
        assert host.soon(lambda: bytes(b for b in host.heard if b > 127) == b"\x91\x97\x9b")
        assert not host.times
        person.types("h")
        person.until("r goes on, s stops the job here, x resets")
        person.types("s")
        assert person.end() == 130, person.text
    assert (
        host.orders()
        == [
            ord("!"),
            0x18,
        ]
        and "stopped by the user" in person.text
    )
    assert host.model.state == "Idle"  # it stood before it was reset: no alarm, no lost step
