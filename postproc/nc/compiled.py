"""Edits of a text made by the compiled kernel (splice.c): the bytes that `Splice.result` makes of
them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np

LONGEST = 24  # bytes of a number and more
COLUMNS = ("start", "stop", "rank", "at", "size", "value", "decimals")
# (T,) start, stop, rank, where new text lies in the pool and its size, and, where numbers follow
# it, these and their decimals
Edits = tuple[np.ndarray, ...]


class List(ctypes.Structure):
    """Edits, of splice.c."""

    _fields_ = (("n", ctypes.c_int64), *((name, ctypes.c_void_p) for name in COLUMNS))


class Splicing(ctypes.Structure):
    """As in splice.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("lists", "length", "written")),
        ("list", ctypes.POINTER(List)),
        *((name, ctypes.c_char_p) for name in ("text", "pool")),
        ("out", ctypes.c_void_p),
    )


def spliced(
    library: ctypes.CDLL,
    text: bytes,
    pool: bytes,
    lists: list[Edits],
    in_order: Callable[[list[Edits]], Edits],
) -> bytes:
    """The text with all edits made. in_order: what makes one list of many, or of one that is not in
    order, which the kernel does not."""
    lists = [*map(_complete, lists)]
    # at most: the whole text, all new text, and a number behind each edit
    room = len(text) + sum(int(edits[4].sum()) + LONGEST * len(edits[0]) for edits in lists)
    out = np.empty(room, np.uint8)
    written = _written(library, text, pool, lists, out)
    if written < 0:
        written = _written(library, text, pool, [in_order(lists)], out)
    return out[:written].tobytes()


def _written(
    library: ctypes.CDLL, text: bytes, pool: bytes, lists: list[Edits], out: np.ndarray
) -> int:
    """How many bytes there are of it; -1 where a list is not in order, or there are many."""
    tables = (List * len(lists))(
        *(List(len(edits[0]), *(column.ctypes.data for column in edits)) for edits in lists)
    )
    work = Splicing(len(lists), len(text), 0, tables, text, pool, out.ctypes.data)
    library.splice(ctypes.byref(work))
    return int(work.written)


def _complete(edits: Edits) -> Edits:
    """The same with columns of numbers, as the kernel takes them; decimals of -1 say that none
    follows."""
    n = len(edits[0])
    if len(edits) < len(COLUMNS):
        edits = *edits, np.zeros(n, np.int64), np.full(n, -1)
    return tuple(np.ascontiguousarray(column, np.int64) for column in edits)
