"""Compensated lines ahead of the link, so that neither a slow pipe nor a hard block starves it; in
flat memory."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator

from postproc.errors import GcompError
from postproc.streaming.lines import WireLine

AHEAD = 16  # batches of lines


class Prefetch:
    """Runs `lines` in a thread. take() gives what is ready, without waiting; `finished` when all
    was taken; `fault`: what stopped it, behind the lines that came before it."""

    def __init__(self, lines: Callable[[], Iterator[list[WireLine]]]):
        # None: no more will come. The thread waits where the queue is full: memory stays flat.
        self._queue: queue.Queue[list[WireLine] | None] = queue.Queue(AHEAD)
        self._lines = lines
        self._stop = False
        self.finished = False
        self.fault: GcompError | None = None
        self.crash: BaseException | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> Prefetch:
        self._thread.start()
        return self

    def _run(self) -> None:
        try:
            for batch in self._lines():
                if batch and not self._put(batch):
                    return
        except GcompError as error:
            self.fault = error
        except BaseException as error:
            self.crash = error
        self._put(None)

    def _put(self, batch: list[WireLine] | None) -> bool:
        while not self._stop:
            try:
                self._queue.put(batch, timeout=0.2)
                return True
            except queue.Full:
                continue
        return False

    def take(self) -> list[WireLine]:
        """The next batch, or nothing."""
        try:
            batch = self._queue.get_nowait()
        except queue.Empty:
            return []
        if batch is None:
            self.finished = True
            if self.crash is not None:
                raise self.crash
            return []
        return batch

    def close(self) -> None:
        self._stop = True
