"""The model behind a pseudo-terminal, in real time: what gcomp as a process meets. Faults by a
seeded plan on the way."""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import struct
import termios
import threading
import time
import tty
from collections.abc import Callable

from tests.streaming.bench import Faults
from tests.streaming.grbl_model import GrblModel

PATIENCE = 60.0  # s
LAST_BYTES = 0.03  # s that what was written last may take on the model's wire
SHORT, LONG = 0.001, 0.01  # s between two looks at the model: by when something happens in it


class PtyHost:
    """`path` is the port. speed: how many model seconds pass in a second. die_after: received lines
    after which it hangs up."""

    def __init__(
        self,
        model: GrblModel,
        faults: Faults | None = None,
        speed: float = 1.0,
        hang_up_after: int = 0,
        silent_after: int = 0,
    ):
        self.model, self.faults, self.speed = model, faults or Faults(), speed
        self.hang_up_after, self.silent_after = hang_up_after, silent_after
        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave = slave
        self._stop = False
        self.heard = bytearray()
        self.times: list[tuple[float, int]] = []
        self._pressed = b""
        self._powered = False
        self._taking = False
        self._stood = 0.0  # s for which its loop stood still at most
        self._failed: BaseException | None = None
        self._thread = threading.Thread(target=self._live, daemon=True)

    def __enter__(self) -> PtyHost:
        self._thread.start()
        return self

    def __exit__(self, kind, error: BaseException | None, *_) -> None:
        self._stop = True
        self._thread.join(5)
        with contextlib.suppress(OSError):
            os.close(self.master)
        with contextlib.suppress(OSError):
            os.close(self._slave)
        if error is not None:
            alive = "lives on" if self._thread.is_alive() else "ended"
            error.add_note(f"the model {alive}; it stood still for {self._stood:.2f} s at most")
        if self._failed is not None:
            raise AssertionError(f"the model failed: {self._failed!r}") from self._failed

    def soon(self, holds: Callable[[], bool]) -> bool:
        """Whether it holds, or does soon: the model takes a byte some time after it was
        written."""
        end = time.monotonic() + PATIENCE
        while not holds() and time.monotonic() < end:
            time.sleep(0.002)
        return holds()

    def orders(self) -> list[int]:
        """Feed holds, resumes and resets, in the order in which they came."""
        return [value for _, value in self.times]

    def read_all(self) -> bool:
        """Whether the model has read all that was written, and done with it."""
        unread = fcntl.ioctl(self.master, termios.FIONREAD, struct.pack("i", 0))
        return struct.unpack("i", unread)[0] == 0 and not self._taking

    def idle(self) -> bool:
        """The same, and executed it."""
        return self.read_all() and self.model.state == "Idle"

    def press(self, data: bytes) -> None:
        """Buttons at the machine: realtime bytes that come from nobody's port."""
        self._pressed += data

    def power(self) -> None:
        """The power goes and comes, between two turns of the loop that the model runs in: in the
        middle of one, lines that it holds would still count as received."""
        self._powered = True
        assert self.soon(lambda: not self._powered)

    def _live(self) -> None:
        """Until the end, or until the model fails, which is no silence of a controller."""
        try:
            self._run()
        except Exception as error:
            self._failed = error

    def _run(self) -> None:
        started = heard = time.monotonic()
        pause, turn = SHORT, time.monotonic()
        while True:
            self._taking = False
            ready = select.select([self.master], [], [], pause)[0]
            last, turn = turn, time.monotonic()
            self._stood = max(self._stood, turn - last)
            self._taking = bool(ready)  # before the bytes leave the terminal, see read_all
            if self._stop and not ready and time.monotonic() - heard > LAST_BYTES:
                return
            now = (time.monotonic() - started) * self.speed
            if ready:
                heard = time.monotonic()
                try:
                    data = os.read(self.master, 4096)
                except OSError:
                    return
                for value in data:
                    if value in b"!~\x18":
                        self.times.append((time.monotonic(), value))
                self.heard += data
                self.model.write(self.faults.pass_on("to", data), now)
            if self._powered:
                self.model.power()
                self._powered = False
            if self._pressed:
                data, self._pressed = self._pressed, b""
                self.model.write(data, now)
            self.model.advance(now)
            pause = min(max((self.model.due() - now) / self.speed, SHORT), LONG)
            back = self.faults.pass_on("back", self.model.read(now))
            n = len(self.model.received)
            if self.silent_after and n >= self.silent_after:
                continue
            if self.hang_up_after and n >= self.hang_up_after:
                os.close(self._slave)
                os.close(self.master)
                return
            if back:
                with contextlib.suppress(OSError):
                    os.write(self.master, back)
