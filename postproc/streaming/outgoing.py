"""Bytes that wait for the port: realtime bytes pass all others, and of a link without answers it is
known which lines have left whole."""

from __future__ import annotations

from collections import deque

from postproc.streaming.lines import WireLine


class Outgoing:
    """urgent: realtime bytes, to be written before anything else; left: others that have left."""

    def __init__(self) -> None:
        self.urgent = b""
        self.left = 0
        self._waiting = b""
        self._put = 0  # bytes that have ever been put in
        # lines that are marked, by where their last byte stands
        self._marks: deque[tuple[int, WireLine]] = deque()
        self._marked: WireLine | None = None

    def __len__(self) -> int:
        """Bytes that wait, without the realtime ones."""
        return len(self._waiting)

    def put(self, data: bytes, mark: WireLine | None = None) -> None:
        """Behind the others. mark: the line that has left with the last of them."""
        self._put += len(data)
        self._waiting += data
        if mark is not None:
            self._marks.append((self._put, mark))
            self.written()

    def take_urgent(self) -> bytes:
        """The realtime bytes, which are forgotten."""
        data, self.urgent = self.urgent, b""
        return data

    def take(self, most: int) -> bytes:
        """So many bytes at most, which have left."""
        n = min(most, len(self._waiting))
        data, self._waiting = self._waiting[:n], self._waiting[n:]
        self.left += n
        return data

    def give_back(self, data: bytes) -> None:
        """Bytes that the port did not take: they go first next time."""
        self._waiting = data + self._waiting
        self.left -= len(data)

    def drop(self) -> None:
        """Nothing that waits shall leave."""
        self._waiting = b""

    def written(self) -> WireLine | None:
        """The last marked line of which all bytes have left."""
        while self._marks and self._marks[0][0] <= self.left:
            line = self._marks.popleft()[1]
            self._marked = line if line.number > 0 else self._marked
        return self._marked
