"""Arcs cut by the compiled kernel, where it was built: what `postproc.compensate.fit` makes of
them, to the last bit.

It knows the plainest arcs only: those along which nothing but the map bends the command, by a
centre word, in their plane, of less than a turn, and not so flat that there is more than one centre
to try. What else a row needs, it leaves to `fit`.
"""

from __future__ import annotations

import ctypes

import numpy as np

from postproc import kernel
from postproc.compensate.arc_rows import Fitter, Rows
from postproc.compensate.nodes import spread
from postproc.compensate.prove import SMALLEST_RADIUS
from postproc.compensate.samples import Samples
from postproc.units import TICKS_PER_MM

MOST = 16  # pieces of a row
COUNTS = ("rows", "samples", "beside", "most")
COLUMNS = (
    *("t", "unit", "place", "radial", "smooth", "across", "turn", "command", "axes"),
    *("first", "last", "begin", "end", "zero", "step", "base", "grid", "t0", "t1", "centre"),
    *("radius", "grown", "sweep", "limit", "plane", "own"),
)
# int64 there, whatever a computer of 32 bits numbers its samples by; the others are float64
WHOLE = {"axes", "first", "last", "begin", "end", "zero", "step", "base", "grid"}
NUMBERS = ("mismatch", "smallest", "flat", "followed")
RESULTS = ("count", "low", "high", "found")
NONE = 9.0  # rad: more than the kernel takes


class Work(ctypes.Structure):
    """As in kernel.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in COUNTS),
        *((name, ctypes.c_void_p) for name in COLUMNS),
        *((name, ctypes.c_double) for name in NUMBERS),
        *((name, ctypes.c_void_p) for name in RESULTS),
    )


def settle(f: Fitter, rows: Rows, samples: Samples) -> tuple[list[Rows], np.ndarray]:
    """Pieces of those rows that the kernel could cut, and (K,) the others. All of rows without the
    kernel, and where more than the map bends the command."""
    library = kernel.library()
    if library is None or not f.plain[rows.arc[0]]:
        return [], np.arange(len(rows))
    n = len(rows)
    columns = {
        name: np.ascontiguousarray(value, np.int64 if name in WHOLE else np.float64)
        for name, value in _columns(f, rows, samples).items()
    }
    results = {
        "count": np.empty(n, np.int64),
        "low": np.empty((n, MOST), np.int64),
        "high": np.empty((n, MOST), np.int64),
        "found": np.empty((n, MOST, 2), np.int64),
    }
    library.settle(
        ctypes.byref(
            Work(
                *(n, len(samples.t), len(samples.beside), MOST),
                *(columns[name].ctypes.data for name in COLUMNS),
                *(f.mismatch, SMALLEST_RADIUS, f.tolerance / 8, len(f.followed)),
                *(results[name].ctypes.data for name in RESULTS),
            )
        )
    )
    count, low, high, found = results.values()
    row, nth = spread(np.maximum(count, 0))
    at = row * MOST + nth
    done = _pieces(f, rows.pick(row), samples.pick(row), low.take(at), high.take(at))
    for k in range(2):
        done.centre[k] = found.take(2 * at + k)
    return [done], np.flatnonzero(count < 0)


def _columns(f: Fitter, rows: Rows, s: Samples) -> dict[str, np.ndarray]:
    """COLUMNS, of kernel.c."""
    arcs, arc = f.arcs, rows.arc
    grid = arcs.grid.take(arc, axis=1)
    half = np.minimum(*grid) / TICKS_PER_MM / 2
    other = arcs.by_radius.take(arc) != 0
    for axis in s.beside:  # a helix
        other |= f.moves[axis].take(arc)
    zero, step = (column.take(rows.stroke, axis=1) for column in f.increments)
    return {
        **{name: getattr(s, name) for name in COLUMNS[:8]},
        "axes": np.array([s.first, s.second, *s.beside]),
        "first": s.begin, "last": s.last, "begin": rows.begin, "end": rows.end,
        "zero": zero, "step": step, "base": f.base.take(arc, axis=1), "grid": grid,
        "t0": rows.t0, "t1": rows.t1, "centre": arcs.centre.take(arc, axis=1),
        "radius": arcs.radius.take(arc), "grown": f.grown.take(arc),
        "sweep": np.where(other, NONE / (rows.t1 - rows.t0), arcs.sweep.take(arc)),
        "limit": f.total + half - s.rest, "plane": f.tolerance + half,
        "own": f.tolerance_across
        + f.step.take(arc, axis=1)[list(s.beside)] / TICKS_PER_MM / 2,
    }  # fmt: skip


def _pieces(f: Fitter, rows: Rows, s: Samples, low: np.ndarray, high: np.ndarray) -> Rows:
    """Rows from sample low to sample high (R,), those of one row side by side."""
    inner = high != s.last
    exact = s.command.take(high, axis=1)
    end = np.where(inner, f.round_to(rows.stroke, exact), rows.end)
    t1 = np.where(inner, s.t.take(high), rows.t1)
    further = low != s.begin  # they begin where the one before ends
    begin = np.where(further, np.roll(end, 1, axis=1), rows.begin)
    t0 = np.where(further, np.roll(t1, 1), rows.t0)
    centre = np.empty((2, len(rows)), np.int64)
    return Rows(rows.arc, rows.stroke, t0, t1, begin, end, centre, rows.radius, rows.chord)
