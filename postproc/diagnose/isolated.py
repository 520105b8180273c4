"""Readings that lie off alone: at rest neither the other runs at their place nor their neighbours
bear them out; of samples in motion neither neighbour goes along."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from postproc.diagnose import outliers
from postproc.diagnose.noise import place_of
from postproc.diagnose.rows import Rows

ASIDE = 3  # neighbours on one side that bear a reading out: a level begins or ends with it
# samples around one; times their usual departure: a sample that lies off; of them all: more are no
# outliers but a kind of noise
AROUND, FAR_OFF, SELDOM = 31, 10.0, 0.002


# Whole: a rule to each kind of recording, over the same columns.
def isolated(rows: Rows, residual: np.ndarray, sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) how many times the noise a reading at rest lies off, alone: neither the other runs at
    its place nor its neighbours bear it out; and (N,) mm by how much. 0 for samples in motion, of
    which `in_motion` tells, and where there is nothing to compare with."""
    result, size = np.zeros(len(rows)), np.zeros(len(rows))
    for signal in range(len(rows.signals)):
        which = np.flatnonzero(rows.signal == signal)
        if not len(which) or rows.kinds[rows.file[which[0]]] not in ("targets", "features"):
            continue
        which = which[np.lexsort((rows.state.time[which], rows.run[which]))]
        place, run = place_of(rows, which), rows.run[which]
        if rows.kinds[rows.file[which[0]]] == "targets" and np.median(np.bincount(place)) < 3:
            passages = _passages(rows, which)
            if passages is not None:
                for part, p in passages:
                    times, size[part] = outliers.departures(p, residual[part], sigma[part])
                    result[part] = np.abs(times)
                    end, off = outliers.at_ends(
                        p,
                        residual[part],
                        _elsewhere(rows, residual, which, part, place),
                        sigma[part],
                    )
                    result[part], size[part] = (
                        np.where(end > 0, end, result[part]),
                        np.where(end > 0, off, size[part]),
                    )
                continue
        # without its zero: what is shared at a place has none either
        y = residual[which] - np.median(residual[which])
        shared = np.bincount(place)[place] > 2
        for p in np.unique(place[shared]):  # what all runs share at a place is no outlier
            y[place == p] -= np.median(y[place == p])
        for k in range(len(which)):
            near = [
                j
                for j in range(max(0, k - 3), min(len(which), k + 4))
                if j != k and run[j] == run[k]
            ]
            if not near and not shared[k]:  # nothing to compare with: its zero is no departure
                continue
            sides = [[j for j in near if j < k], [j for j in near if j > k]]
            around = [
                float(np.median(y[near])) if near else 0.0,
                *(float(np.median(y[side])) for side in sides if len(side) == ASIDE),
                *_went_on(y, same := np.flatnonzero(place == place[k]), k),
                *y[same[run[same] != run[k]]],
            ]
            # the kindest of all that it is held against: one that bears it out is enough
            off = min((y[k] - level for level in around), key=abs)
            result[which[k]] = abs(off) / sigma[which[k]]
            size[which[k]] = off
    return result, np.abs(size)


def in_motion(y: np.ndarray, run: np.ndarray) -> np.ndarray:
    """(n,) mm by how much each sample y (n,) mm of a motion lies off alone, 0 where it does not:
    far from the median of the two on either side, while its neighbours are not (Hampel's
    identifier: Davies and Gather, The identification of multiple outliers, Journal of the American
    Statistical Association 88, 1993, 782). None where so many do that it is a kind of noise, or
    within two samples of the ends of a run (n,)."""
    inside = np.all([np.roll(run, k) == run for k in (-2, 2)], axis=0)
    inside[:2] = inside[-2:] = False
    if len(y) < AROUND or not inside.any():
        return np.zeros(len(y))
    # without the sample itself, which must not speak for itself
    beside = np.median([np.roll(y, k) for k in (-2, -1, 1, 2)], axis=0)
    off = np.abs(y - beside) * inside
    usual = np.maximum(median_filter(off, AROUND), np.median(off[inside])) * outliers.MAD
    alone = (off > FAR_OFF * np.maximum(usual, 1e-9)) & (
        off > 2 * np.maximum(np.roll(off, 1), np.roll(off, -1))
    )
    return off * alone if np.count_nonzero(alone) <= max(1, SELDOM * len(y)) else np.zeros(len(y))


def _went_on(y: np.ndarray, same: np.ndarray, k: int) -> list[float]:
    """mm that reading k would have as the others at its place go on in time: between those before
    and behind it, and on the line of the two before or behind. What warms up is no outlier, however
    few readings it takes to."""
    at = int(np.searchsorted(same, k))
    before, behind = y[same[max(at - 2, 0) : at]], y[same[at + 1 : at + 3]]
    levels = [float(before[-1] + behind[0]) / 2] if len(before) and len(behind) else []
    levels += [float(2 * before[1] - before[0])] if len(before) == 2 else []
    return levels + ([float(2 * behind[0] - behind[1])] if len(behind) == 2 else [])


def _elsewhere(
    rows: Rows, residual: np.ndarray, which: np.ndarray, part: np.ndarray, place: np.ndarray
) -> np.ndarray:
    """(M,) median of what other runs read at the places of the rows `part`, nan where there were
    none; place: of the rows `which`."""
    number = dict(zip(which.tolist(), place.tolist(), strict=True))
    found = np.full(len(part), np.nan)
    for k, row in enumerate(part.tolist()):
        others = which[(place == number[row]) & (rows.run[which] != rows.run[row])]
        if len(others):
            found[k] = float(np.median(residual[others]))
    return found


def _passages(rows: Rows, which: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Rows and places of every run in every direction, along the axis that moves most; None where
    one comes to a place twice, or none moves."""
    axis = max(rows.state.position, key=lambda x: float(np.ptp(rows.state.position[x][which])))
    place, side = rows.state.position[axis][which], np.sign(rows.state.approach[axis][which])
    if np.ptp(place) < 1e-3:
        return None
    parts = [
        (which[own], place[own])
        for r in np.unique(rows.run[which])
        for s in np.unique(side)
        if (own := (rows.run[which] == r) & (side == s)).any()
    ]
    return parts if all(len(np.unique(p)) == len(p) for _, p in parts) else None
