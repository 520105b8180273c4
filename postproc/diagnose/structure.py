"""How much of what is left is no noise: means of readings that belong together are farther from zero than noise makes them.

Readings belong together at one place, reached from one side; in one stretch of time; and a stretch of time may be rougher than
the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.diagnose.rows import Rows

CELLS = 48
FEWEST = 12
STRETCHES = 40
MEDIAN = np.pi / 2  # variance of a median over that of a mean
# Smaller is not worth a word: a wave that swings by 0.7 um, which is what matters, has an rms of 0.25 um.
LEAST_MM = {"laser": 4e-4, "angle": 4e-7, "tool": 2.5e-4, "scale": 2.5e-4}
LIKELY = {"place": 6.0, "time": 6.0, "pace": 5.0}  # times its own spread
SHARE = 0.2  # of what was there before


@dataclass(frozen=True)
class Left:
    """Structure in a signal that nothing explains: "place" or "time"; rms mm; share of what was there before."""

    signal: int
    how: str
    rms: float
    share: float


def unexplained(
    rows: Rows, before: tuple[np.ndarray, ...], after: np.ndarray, sigma: np.ndarray, use: np.ndarray
) -> list[Left]:
    """Where the readings (use, (N,) bool) agree with each other about something that no accepted effect explains, the
    largest first. before: what was there, (N,) mm in each of several ways; the least counts."""
    found = []
    for signal in range(len(rows.signals)):
        which = (rows.signal == signal) & use
        kind = str(rows.sees[which][0]) if which.any() else "part"
        if kind == "part" or np.count_nonzero(which) < FEWEST:  # a feature has one place: nothing to agree about
            continue
        now = excess(rows, after, sigma, which)
        there = max(min(max(v for v, _ in excess(rows, b, sigma, which).values()) for b in before), 1e-30)
        for how, (value, likely) in now.items():
            if likely > LIKELY[how] and value > LEAST_MM[kind] ** 2 and value > SHARE**2 * there:
                found.append(Left(signal, how, float(np.sqrt(value)), float(min(1.0, value / there))))
    return sorted(found, key=lambda left: -left.rms)


def excess(rows: Rows, left: np.ndarray, sigma: np.ndarray, which: np.ndarray) -> dict[str, tuple[float, float]]:
    """ "place" and "time" to (mm2 of variance beyond the noise, how many times its own spread under noise alone). left,
    sigma (N,) mm; which (N,) bool: the rows of one signal."""
    at = np.flatnonzero(which)
    at = at[np.lexsort((rows.state.time[at], rows.run[at]))]
    result = {}
    for name, group in (("place", _places(rows, at)), ("time", _stretches(rows, at))):
        order = np.lexsort((left[at], group))
        count = np.bincount(group)
        edge = np.cumsum(count) - count
        several = count > 1  # one reading agrees with nobody
        n, first = count[several], edge[several]
        if not len(n):
            result[name] = (0.0, 0.0)
            continue
        low, high = first + (n - 1) // 2, first + n // 2
        value = left[at][order]
        middle = (value[low] + value[high]) / 2  # one reading that lies far off is an outlier, not structure
        noise = np.bincount(group, sigma[at] ** 2)[several] / n**2 * np.where(n > 2, MEDIAN, 1.0)
        # Of two that lie on one side the nearer says what they share; as often by chance as two on different sides take away.
        a, b = value[first], value[first + 1]
        shared = np.where(n > 2, middle**2 - noise, np.sign(a * b) * np.minimum(np.abs(a), np.abs(b)) ** 2)
        total = float((n * shared).sum() / n.sum())
        spread = float(np.sqrt(2.0 * (n**2 * noise**2).sum()) / n.sum())
        result[name] = (total, total / max(spread, 1e-30))
    if rows.state.passage[at[0]] >= 0:
        result["pace"] = _rough(left[at], _stretches(rows, at))
    return result


def _rough(left: np.ndarray, group: np.ndarray) -> tuple[float, float]:
    """Stretches that are rougher than most: (mm2 of variance beyond that of the quiet ones, of the roughest tenth of all rows, how
    many times its own spread)."""
    second = np.zeros(len(left))
    second[1:-1] = (left[1:-1] - (left[2:] + left[:-2]) / 2) / np.sqrt(1.5)
    inside = np.concatenate([[False], (group[1:-1] == group[2:]) & (group[1:-1] == group[:-2]), [False]])
    limit = 6.0 * 1.4826 * float(np.median(np.abs(second[inside]))) if inside.any() else 0.0
    square = np.clip(second[inside], -limit, limit) ** 2
    count = np.bincount(group[inside])
    n = count[count > 4]
    if len(n) < 10:
        return 0.0, 0.0
    variance = (np.bincount(group[inside], square)[count > 4]) / n
    quiet = float(np.median(variance))
    loud = np.sort(variance)[-max(2, len(variance) // 10) :]
    size = float(loud.min() - quiet)
    return float(loud.mean() - quiet) * len(loud) / len(variance), size / max(
        quiet * np.sqrt(4.0 / float(np.median(n))), 1e-30
    )


def _places(rows: Rows, at: np.ndarray) -> np.ndarray:
    """(M,) number of the place and side of each row."""
    keys = []
    dense = rows.state.passage[at[0]] >= 0
    for x, p in rows.state.position.items():
        if np.ptp(p[at]) < 1e-6:
            continue
        keys.append(np.sign(rows.state.approach[x][at]))
        if dense:
            keys.append(np.floor((p[at] - p[at].min()) / np.ptp(p[at]) * 0.999 * CELLS / 2))
        else:
            keys.append(np.round(p[at], 2))
    if not keys:
        return np.zeros(len(at), int)
    return np.unique(np.stack(keys), axis=1, return_inverse=True)[1].ravel()


def _stretches(rows: Rows, at: np.ndarray) -> np.ndarray:
    """(M,) number of the stretch of time of each row: some neighbours of one run."""
    run = rows.run[at]
    starts = np.concatenate([[True], run[1:] != run[:-1]])
    first = np.maximum.accumulate(np.where(starts, np.arange(len(at)), 0))
    width = max(5, len(at) // STRETCHES)
    number = np.cumsum(starts) * 10**6 + (np.arange(len(at)) - first) // width
    return np.unique(number, return_inverse=True)[1].ravel()
