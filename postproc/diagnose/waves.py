"""Waves over the place of an axis that the samples of a motion show plainly: noise has none, so that
none is learned from them."""

from __future__ import annotations

import numpy as np

from postproc.diagnose import spectra
from postproc.diagnose.noise import Unit
from postproc.diagnose.rows import ENTERS, Rows
from postproc.effects import waves_of
from postproc.machine.chain import XYZ

# Of the squares of the differences from sample to sample, which wander hardly moves: of N samples
# of white noise the best of all waves says some 2 ln(N) / N.
PLAIN = 0.2
MOST = 4  # waves of an axis
FEWEST = 64  # samples of its motion
MOVES = 1e-3  # mm/s


def without(rows: Rows, y: np.ndarray, unit: Unit) -> np.ndarray:
    """(n,) mm: readings y (n,) of an instrument less such waves, each with its half period."""
    left = y.copy()
    for axis, velocity in rows.state.velocity.items():
        enters = rows.direction[unit.rows, XYZ.index(axis)]
        moving = (np.abs(velocity[unit.rows]) > MOVES) & (np.abs(enters) > ENTERS)
        if np.count_nonzero(moving) < FEWEST:
            continue
        for _ in range(MOST):
            wave = _plainest(rows, left, unit, axis, enters * moving)
            if wave is None:
                break
            left -= wave
    return left


def _plainest(
    rows: Rows, y: np.ndarray, unit: Unit, axis: str, enters: np.ndarray
) -> np.ndarray | None:
    """(n,) mm: the wave of an axis that says most of the differences between samples in motion;
    None where none says enough."""
    weighted, power = np.zeros(len(rows)), np.zeros(len(rows))
    weighted[unit.rows] = (y - np.median(y)) * enters / unit.r**2
    power[unit.rows] = enters**2 / unit.r**2
    moving = enters != 0
    both = moving[1:] & moving[:-1]
    now = np.diff(y)[both]
    best, most = None, PLAIN
    for period in spectra.in_place(rows, axis, weighted, power):
        waves = [w for n in (1, 2) for w in waves_of(rows.state, axis, n / period)]
        columns = np.stack(waves)[:, unit.rows].T * enters[:, None]
        value = np.linalg.lstsq(np.diff(columns, axis=0)[both], now, rcond=None)[0]
        wave = columns @ value
        says = 1.0 - np.sum((now - np.diff(wave)[both]) ** 2) / max(float(now @ now), 1e-30)
        if says > most:
            best, most = wave, says
    return best
