"""Single keys from the terminal, without Enter: as a POSIX terminal and a Windows console give
them."""

from __future__ import annotations

import contextlib
import os
import select
import sys
from types import TracebackType
from typing import Any

RESUME, STOP, RESET, HOLD, SKIP, HELP = "r", "s", "x", "h", "c", "?"
OVERRIDES = {
    "+": "feed+", "-": "feed-", "=": "feed 100", "1": "rapid 25", "2": "rapid 50", "3": "rapid 100",
    ">": "spindle+", "<": "spindle-", "/": "spindle 100",
}  # fmt: skip
OVER = "feed + - =, rapids 1 2 3 (25 50 100 %), spindle > < /"
IN_REFUSAL = "c goes on without it, s stops the job here, x resets at once"
IN_HOLD = "r goes on, s stops the job here, x resets at once"


def terminal() -> bool:
    """Whether a person can press keys."""
    return sys.stdin is not None and sys.stdin.isatty()


class Keys:
    """pressed() within a `with`: the keys since the last time, without waiting; None when the
    terminal is gone."""

    def __init__(self) -> None:
        self._old: Any = None
        self._gone = False

    def __enter__(self) -> Keys:
        if os.name == "posix":
            import termios
            import tty

            with contextlib.suppress(termios.error, OSError, ValueError):
                self._fd = sys.stdin.fileno()
                self._old = termios.tcgetattr(self._fd)
                tty.setcbreak(self._fd, termios.TCSANOW)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._old is not None:
            import termios

            with contextlib.suppress(termios.error, OSError, ValueError):
                termios.tcsetattr(self._fd, termios.TCSANOW, self._old)

    def pressed(self) -> str | None:
        if os.name != "posix":
            return _console()
        if self._gone or self._old is None:
            return None
        with contextlib.suppress(OSError, ValueError):
            if not select.select([self._fd], [], [], 0)[0]:
                return ""
            data = os.read(self._fd, 1024)
            if data and data != b"\x04":
                return data.decode("utf-8", "replace")
        self._gone = True
        return None


def _console() -> str:
    """Of a Windows console."""
    import importlib

    msvcrt: Any = importlib.import_module("msvcrt")
    found = ""
    while msvcrt.kbhit():
        key = msvcrt.getwch()
        if key in "\x00\xe0":  # an arrow or a function key: its second half says which
            msvcrt.getwch()
        else:
            found += key
    return found
