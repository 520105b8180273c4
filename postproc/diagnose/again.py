"""What is left in the readings of one run after the other: what runs of one path agree about, and what a run that took no part shows.

The first needs no noise: a ripple that is finer than the smoothing by which the noise was found counts as noise there, but noise
does not come again. The second needs no fit: what bends with the runs that took part does not bend with the one between them.
"""

from __future__ import annotations

import numpy as np

from postproc.diagnose import fit, structure
from postproc.diagnose.rows import Rows
from postproc.diagnose.structure import LEAST_MM, SHARE, Left

CELLS = (24, 96)  # of each axis' way: what is long stands out of few cells, what is fine needs many
FEWEST = 12  # cells that were passed twice
AGREED, AFRESH = 10.0, 10.0  # times its own spread
FAR = 4.0  # times the scatter: one reading that lies off does not decide


def left(
    rows: Rows, before: tuple[np.ndarray, ...], after: np.ndarray, sigma: np.ndarray, held: np.ndarray, told: np.ndarray
) -> list[Left]:
    """Structure that no name explains and that comes again. before: what was there, (N,) mm in each of several ways, the least
    counts; after, sigma (N,) mm; held (N,) bool: took no part; told (N,) bool: what the names foretell, so that what is left there
    of rows held out is unexplained."""
    found: list[Left] = []

    def note(how: str, value: float, likely: float, sure: float, was: list[float]) -> None:
        there = max(min(was), value, explained)
        if likely > sure and value > max(LEAST_MM[kind] ** 2, SHARE**2 * there):
            found.append(Left(signal, how, float(np.sqrt(value)), value / there))

    for signal in range(len(rows.signals)):
        which = rows.signal == signal
        kind = str(rows.sees[which][0]) if which.any() else "part"
        alone, shared = which & held & told, which & (~held | told)
        if kind == "part" or np.count_nonzero(shared) < structure.FEWEST:
            continue
        level = [levelled(rows, y, sigma, alone) for y in (after, *before)]
        # What swings in time comes again in no run, and its form error is small beside it all the same.
        explained = float(np.var((before[0] - after)[shared]))
        if rows.state.passage[np.flatnonzero(which)[0]] >= 0:
            for cells in CELLS:
                value, likely = agreed(rows, tame(after, shared), shared, cells)
                note("runs", value, likely, AGREED, [agreed(rows, y, shared, cells)[0] for y in before])
        elif alone.any():
            value, likely = structure.excess(rows, level[0], sigma, shared)["place"]
            note("runs", value, likely, structure.LIKELY["place"], [_place(rows, y, sigma, shared) for y in level[1:]])
        if np.count_nonzero(alone) >= structure.FEWEST:
            # Of neighbours in time: of a place there is one reading, and one may be an outlier.
            value, likely = structure.excess(rows, level[0], sigma, alone)["time"]
            was = [structure.excess(rows, y, sigma, alone)["time"][0] for y in level[1:]]
            note("afresh", value, likely, AFRESH, was)
    return found


def _place(rows: Rows, left: np.ndarray, sigma: np.ndarray, which: np.ndarray) -> float:
    """mm2: what readings share, of places or of neighbours in time, whichever is more."""
    return max(value for value, _ in structure.excess(rows, left, sigma, which).values())


def agreed(rows: Rows, left: np.ndarray, which: np.ndarray, cells: int) -> tuple[float, float]:
    """(mm2 that the runs of one signal's rows (N,) bool share at the same places from the same sides, how many times its spread where
    they share nothing); (0, 0) where no path was passed twice. The mean product of two runs' means has no part of their noise."""
    at = np.flatnonzero(which)
    run = np.unique(rows.run[at], return_inverse=True)[1].ravel()
    keys = []
    for x, p in rows.state.position.items():
        way = float(np.ptp(p[at]))
        if way > 1e-6:
            keys.append(np.sign(rows.state.approach[x][at]))
            keys.append(np.floor((p[at] - p[at].min()) / way * 0.9999 * cells))
    if not keys or run.max() == 0:
        return 0.0, 0.0
    place = np.unique(np.stack(keys), axis=1, return_inverse=True)[1].ravel()
    count, total = (np.zeros((place.max() + 1, run.max() + 1)) for _ in range(2))
    np.add.at(count, (place, run), 1.0)
    np.add.at(total, (place, run), left[at])
    mean = total / np.maximum(count, 1.0)
    runs = np.count_nonzero(count, axis=1)
    mean, runs = mean[runs > 1], runs[runs > 1]
    if len(runs) < FEWEST:
        return 0.0, 0.0
    square = (mean**2).sum(axis=1)
    product = (mean.sum(axis=1) ** 2 - square) / (runs * (runs - 1))
    single = float(np.mean(square / runs))
    spread = np.sqrt(np.sum(2.0 * single**2 / (runs * (runs - 1)))) / len(runs)
    return float(product.mean()), float(product.mean() / max(spread, 1e-30))


def tame(left: np.ndarray, which: np.ndarray) -> np.ndarray:
    """(N,) mm: without what lies so far off that a few readings would decide."""
    limit = FAR * 1.4826 * float(np.median(np.abs(left[which])))
    return np.clip(left, -limit, limit)


def levelled(rows: Rows, left: np.ndarray, sigma: np.ndarray, which: np.ndarray) -> np.ndarray:
    """(N,) mm: without the zero of each run and its walk, as far as an instrument wanders and a bar warms."""
    result = left.copy()
    for file in np.unique(rows.file[which]):
        if rows.kinds[file] not in ("targets", "ballbar"):
            continue
        for run in np.unique(rows.run[which & (rows.file == file)]):
            at = np.flatnonzero(which & (rows.file == file) & (rows.run == run))
            t = rows.state.time[at]
            late = (t - t.mean()) / max(float(np.ptp(t)), 1e-9)
            p = fit.Projector.of(sigma[at], np.stack([np.ones(len(at)), late], axis=1), np.full(2, fit.WALK))
            result[at] -= p.nuisance(left[at])
    return result
