"""Put new text in place of old, a whole batch at once: what is not named keeps its bytes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from postproc import kernel
from postproc.flags import any_of
from postproc.nc.compiled import Edits, spliced
from postproc.nc.numbers import decimal_cells, decimal_text

if TYPE_CHECKING:
    from ctypes import CDLL

    from numpy.typing import ArrayLike

FEW = 32  # numbers that are written one by one
PORTION = 4096  # runs of text put together at once: their indices stay in the cache


class Splice:
    """Collects edits of one text. An edit replaces text[start:stop]; edits at one place keep the
    order of their rank, insertions first."""

    def __init__(self, text: bytes):
        self.text = text
        self._pool: list[bytes] = []
        self._pool_size = 0
        self._edits: list[Edits] = []
        self._library: CDLL | None = None  # which writes the numbers of some edits

    def constants(self, start: np.ndarray, stop: np.ndarray, rank: np.ndarray, text: bytes) -> None:
        """The same new text at each of (T,) places."""
        n = len(start)
        if n and (text or (np.asarray(stop) > np.asarray(start)).any()):
            self._add(text, start, stop, rank, np.zeros(n, np.int64), np.full(n, len(text)))

    def texts(self, start: ArrayLike, stop: ArrayLike, rank: ArrayLike, texts: list[bytes]) -> None:
        """Their own new text at each of (T,) places."""
        if len(texts):
            size = np.array([len(t) for t in texts], np.int64)
            self._add(b"".join(texts), start, stop, rank, np.cumsum(size) - size, size)

    def numbers(
        self,
        start: np.ndarray,
        stop: np.ndarray,
        rank: np.ndarray,
        value: np.ndarray,
        decimals: np.ndarray,
        prefix: np.ndarray | None = None,
    ) -> None:
        """value / 10**decimals at each of (T,) places, after `prefix` (T, k) uint8, whose zeros are
        left out. Those at one place need ranks of their own."""
        if len(value) <= FEW:
            texts = [*map(decimal_text, value.tolist(), decimals.tolist())]
            if prefix is not None:
                marks = (row.tobytes().replace(b"\0", b"") for row in prefix)
                texts = [mark + text for mark, text in zip(marks, texts, strict=True)]
            self.texts(start, stop, rank, texts)
            return
        self._library = kernel.library()
        if self._library is not None:
            n, room = (len(value), 0) if prefix is None else prefix.shape
            at, size = np.arange(n) * room, np.full(n, room)
            text = b"" if prefix is None else prefix.tobytes()
            self._add(text, start, stop, rank, at, size, value, decimals)
            return
        few = np.bincount(decimals).nonzero()[0].tolist()
        for d in few:
            of = slice(None) if len(few) == 1 else (decimals == d).nonzero()[0]
            room = 0 if prefix is None else prefix.shape[1]
            cell, begin, end = decimal_cells(value[of], d, room)
            line = np.arange(len(begin)) * cell.shape[1]
            begin += line
            if prefix is not None:
                flat = cell.reshape(-1)
                for mark in prefix[of].T[::-1]:
                    flat[begin - 1] = mark  # what is zero is written over, or left out
                    begin -= mark != 0
            size = line + end - begin
            self._add(cell.tobytes(), start[of], stop[of], rank[of], begin, size)

    def _add(
        self,
        text: bytes,
        start: ArrayLike,
        stop: ArrayLike,
        rank: ArrayLike,
        at: np.ndarray,
        *more: np.ndarray,
    ) -> None:
        place = np.asarray(start, np.int64), np.asarray(stop, np.int64), np.asarray(rank, np.int64)
        self._edits.append((*place, at + self._pool_size, *more))
        self._pool.append(text)
        self._pool_size += len(text)

    def result(self) -> bytes:
        """The text with all edits made."""
        if not self._edits:
            return self.text
        if self._library is not None:
            return spliced(self._library, self.text, b"".join(self._pool), self._edits, _in_order)
        start, stop, _, at, size = _in_order(self._edits)
        source = np.frombuffer(self.text + b"".join(self._pool), np.uint8)
        #   text    kept | old | kept | old | kept   `source` is the text with the pool of all
        #   pool    new new                          that is new behind it; runs are copied from it.
        # Alternate: kept text, new text, kept text, ..., kept text.
        n = len(start)
        begin = np.empty(2 * n + 1, np.int64)
        length = np.empty(2 * n + 1, np.int64)
        begin[0], begin[2::2] = 0, stop
        length[0:-1:2], length[-1] = start, len(self.text)
        length[0::2] -= begin[0::2]
        begin[1::2], length[1::2] = at + len(self.text), size
        np.maximum(length, 0, out=length)  # two words that go may take the blank between them along
        out = []
        for k in range(0, len(begin), PORTION):
            here, many = begin[k : k + PORTION], length[k : k + PORTION]
            # runs 7..9 and 2..3: the n-th byte to write comes from n + 7, of the second run from n
            # + (2 - 3)
            index: np.ndarray = (here - (many.cumsum() - many)).repeat(many)  # of the byte to take
            index += np.arange(len(index))
            out.append(source.take(index).tobytes())
        return b"".join(out)


def _in_order(lists: list[Edits]) -> Edits:
    """All edits, in the order in which they are made."""
    edits = lists[0]
    if len(lists) > 1:
        edits = tuple(np.concatenate(columns) for columns in zip(*lists, strict=True))
    start, stop, rank = edits[:3]
    # What is put in at a place stands before what is taken out from there on.
    place = 2 * start + (stop > start)
    if any_of(place[1:] <= place[:-1]):
        # Edits come as a few ascending runs, which two stable sorts merge much faster than lexsort
        # does.
        order = rank.argsort(kind="stable")
        order = order.take(place.take(order).argsort(kind="stable"))
        edits = tuple(column.take(order) for column in edits)
    return edits
