"""Ctrl-C, SIGTERM, a terminal that is closed: as counts while a job runs; before it, at once."""

from __future__ import annotations

import contextlib
import signal
import socket
from collections.abc import Callable, Iterator

STOPS = ("SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")
WORDS = {"SIGHUP": "SIGHUP: the terminal, or the connection to it, is gone"}


class Interrupted(BaseException):
    """Somebody stopped gcomp before the job: what was told to the controller, in words."""


class Signals:
    """presses: of Ctrl-C; holds: of Ctrl-Z, which shall not leave a machine moving with nobody at
    its wire; resumes: SIGUSR1; ends: which signal ends the job, "" none. at_once: what is to be
    done when one comes before a job runs; None: they are counted alone. wakes: readable once one
    has come, for a wait that would go on behind its handler (PEP 475)."""

    def __init__(self) -> None:
        self.wakes: socket.socket | None = None
        self.presses = self.holds = self.resumes = 0
        self.ends = ""
        self.at_once: Callable[[str], None] | None = None

    @contextlib.contextmanager
    def caught(self) -> Iterator[Signals]:
        wanted = {
            "SIGINT": "presses",
            "SIGTSTP": "holds",
            "SIGUSR1": "resumes",
            **dict.fromkeys(STOPS, "ends"),
        }
        old = {}
        for name, what in wanted.items():
            number = getattr(signal, name, None)
            # nohup
            if number is None or (name == "SIGHUP" and signal.getsignal(number) is signal.SIG_IGN):
                continue
            with contextlib.suppress(ValueError):
                old[number] = signal.signal(number, self._handler(name, what))
        # set_wakeup_fd writes a byte there at each signal; the port's select looks at it beside the
        # device
        self.wakes, end = socket.socketpair()
        with self.wakes, end:
            before = _woken_by(end)
            try:
                yield self
            finally:
                if before is not None:
                    signal.set_wakeup_fd(before)
                for number, handler in old.items():
                    signal.signal(number, handler)

    def _handler(self, name: str, what: str) -> Callable:
        def handler(number, frame) -> None:
            if what == "ends":
                self.ends = WORDS.get(name, name)
            else:
                setattr(self, what, getattr(self, what) + 1)
            if self.at_once is not None and what != "resumes":
                self.at_once(WORDS.get(name, name))

        return handler


def _woken_by(end: socket.socket) -> int | None:
    """Let each signal write a byte there; the file that was written before. None: this is a thread,
    which no signal reaches."""
    end.setblocking(False)
    with contextlib.suppress(ValueError):
        return signal.set_wakeup_fd(end.fileno(), warn_on_full_buffer=False)
    return None
