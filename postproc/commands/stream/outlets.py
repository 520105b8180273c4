"""What is told: standard output and standard error, each written by a thread of its own, so that
nobody who does not read, no terminal that stands (Ctrl-S) and no full pipe can hold up the loop
that holds the machine.
"""

from __future__ import annotations

import contextlib
import os
import select
import stat
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, TextIO

MOST = 10_000  # lines that wait for a reader; beyond, the newest are dropped
PATIENCE = 2.0  # s that the end waits for a reader


class Outlet:
    """say() and refresh() never wait. gone: why nothing can be written any more (the reader has
    closed), or ""; closed: whether that is because nobody reads, and not because a disk is full.
    show: what draws the newest state on a terminal; lines: what writes a line where something is
    drawn, False: nothing is."""

    def __init__(
        self,
        stream: TextIO | None,
        show: Callable[[Any], None] | None = None,
        lines: Callable[[str], bool] | None = None,
    ):
        self._fd = _number(stream)
        self.gone = "" if self._fd is not None else "it is closed"
        self.closed = False
        self._show, self._lines = show, lines
        self._texts: deque[str] = deque(maxlen=MOST)
        self._state: Any = None
        self._news = threading.Condition()
        self._ends = self._busy = False
        self._reader = _reader(self._fd)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def say(self, text: str) -> None:
        """A line, in its turn."""
        with self._news:
            if len(self._texts) < MOST:
                self._texts.append(text)
            self._news.notify()

    def refresh(self, state: Any) -> None:
        """The newest state: only the last one is of interest, and lines that wait come first."""
        with self._news:
            self._state = state
            self._news.notify()

    def stalls(self) -> bool:
        """Whether something is waiting to be read."""
        return self._busy

    def unread(self) -> bool:
        """Whether nobody can read it any more: the other end of a pipe is closed, which the system
        knows before anything is written (not on Windows: there the next line finds it)."""
        if not self.closed and self._reader is not None and self._reader.poll(0):
            self.closed = True
        return self.closed

    def close(self, last: Callable[[], None] | None = None) -> None:
        """Wait for what is left, PATIENCE s at most. last: what then gives the terminal back."""
        with self._news:
            self._ends = True
            self._news.notify()
        self._thread.join(PATIENCE)
        if last is not None and not self._thread.is_alive():
            with contextlib.suppress(OSError, ValueError):  # the terminal is gone
                last()

    def _run(self) -> None:
        while True:
            text, state = None, None
            with self._news:
                self._busy = False
                self._news.wait_for(lambda: self._texts or self._state is not None or self._ends)
                if self._ends and not self._texts:
                    return
                self._busy = True
                if self._texts:
                    text = self._texts.popleft()
                else:
                    state, self._state = self._state, None
            if self.gone:
                continue
            try:
                self._put(text, state)
            except (OSError, ValueError) as error:
                self.gone = getattr(error, "strerror", None) or str(error)
                self.closed = isinstance(error, BrokenPipeError)

    def _put(self, text: str | None, state: Any) -> None:
        """A line, or where there is none the state."""
        if text is None:
            if self._show is not None:
                self._show(state)
        elif self._lines is None or not self._lines(text):
            self._write(text)

    def _write(self, text: str) -> None:
        data = (text + "\n").encode("utf-8", "backslashreplace")
        while data and self._fd is not None:
            data = data[os.write(self._fd, data) :]


def _number(stream: TextIO | None) -> int | None:
    """The file behind it, with what it holds already written; None: there is none."""
    try:
        if stream is None:
            return None
        stream.flush()
        return stream.fileno()
    except (OSError, ValueError):
        return None


def _reader(fd: int | None) -> Any:
    """What says whether the other end of a pipe or socket is closed; None where nothing can."""
    if fd is None or not hasattr(select, "poll"):
        return None
    mode = os.fstat(fd).st_mode
    if not (stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)):
        return None
    found = select.poll()
    found.register(fd, 0)  # errors and the hang-up are always reported
    return found
