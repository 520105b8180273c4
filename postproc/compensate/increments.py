"""To which whole increments commands are rounded."""

from __future__ import annotations

import numpy as np

from postproc.compensate.columns import Columns
from postproc.units import TICKS_PER_MM


def increments(b: Columns, stroke: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two (A, K) ticks: where the increments of strokes count from, the nominal place wherever a
    difference of two places may be written, else zero; and their size."""
    m, motion = b.m, b.motion[stroke]
    near = m.incremental.take(motion, axis=1) | (b.travel.take(stroke, axis=1) == 0)
    zero = np.where(near, m.start.take(motion, axis=1), m.origin.take(motion, axis=1))
    return zero, m.grid.take(motion, axis=1)


def rounded(exact: np.ndarray, zero: np.ndarray, step: np.ndarray) -> np.ndarray:
    """(A, K) ticks: exact mm to the nearest of such increments, half to even."""
    rounded: np.ndarray = (
        zero + np.rint((exact * TICKS_PER_MM - zero) / step).astype(np.int64) * step
    )
    return rounded
