"""Where samples lie along arcs, by the compiled kernel where it was built: what `samples.laid`
makes of rows, to the last bit."""

from __future__ import annotations

import ctypes

import numpy as np

from postproc import kernel
from postproc.compensate.arc_rows import Fitter, Rows
from postproc.compensate.stretches import Stretches

COUNTS = ("rows", "samples", "axes", "first", "second")
COLUMNS = (
    *("stretch", "count", "parts", "way", "step", "t0", "t1", "angle", "sweep", "radius"),
    *("grown", "centre", "start", "travel", "shift", "tangent"),
)
RESULTS = ("t", "smooth", "unit", "wide", "nominal", "guess")
# (N,) t and smooth, (2, N) unit, (N,) mm radius, (A, N) mm nominal and guess
Laid = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class Laying(ctypes.Structure):
    """As in kernel.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in COUNTS),
        ("bent", ctypes.c_double),
        *((name, ctypes.c_void_p) for name in (*COLUMNS, *RESULTS)),
    )


def laid(
    f: Fitter, rows: Rows, which: np.ndarray, count: np.ndarray, way: Stretches, bent: float
) -> Laid | None:
    """`samples.laid` of plain rows; None without the kernel."""
    library = kernel.library()
    if library is None:
        return None
    arcs, arc, n = f.arcs, rows.arc, int(count.sum())
    shape = len(f.start), n
    start = f.start.take(arc, axis=1)
    columns = (
        *(way.row.searchsorted(which), count, way.parts, way.t, way.step, rows.t0, rows.t1),
        *(column.take(arc) for column in (arcs.angle, arcs.sweep, arcs.radius, f.grown)),
        *(arcs.centre.take(arc, axis=1), start, f.target.take(arc, axis=1) - start),
        *(way.shift.take(which, axis=2), np.empty(n)),
    )
    columns = tuple(
        np.ascontiguousarray(column, np.int64 if column.dtype.kind in "iu" else np.float64)
        for column in columns
    )
    results = (
        *(np.empty(n), np.empty(n), np.empty((2, n)), np.empty(n)),
        *(np.empty(shape), np.empty(shape)),
    )
    counts = len(rows), n, len(f.start), int(arcs.first[arc[0]]), int(arcs.second[arc[0]])
    work = Laying(*counts, bent, *(column.ctypes.data for column in (*columns, *results)))
    library.lay(ctypes.byref(work))
    half = columns[-1]
    np.tan(half, out=half)  # the kernel's may have other bits
    library.aim(ctypes.byref(work))
    return results
