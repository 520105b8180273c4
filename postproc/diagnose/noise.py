"""How large the noise of every signal is, from differences that can not contain what is looked for.

Targets: the same place approached from the same side in several runs; what changes smoothly along a run is taken out by
the difference of neighbours. Samples in motion: the same path run twice, less what changes slowly along it; where no path
was repeated, second differences. Neighbours that resemble each other count for less: the inflation is that of a first-order
autoregression.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from postproc.diagnose import slips
from postproc.diagnose.rows import Rows

FLOOR = {"laser": 1e-4, "angle": 1e-7, "tool": 1e-4, "scale": 5e-5, "part": 3e-4}  # mm, rad: resolution
MAD = 1.4826
LARGEST_RHO = 0.9
COARSE = 1.0  # times the scatter of neighbours: beyond, a log's rounding is its noise
LINE = 25.0  # times the power around


def of(rows: Rows, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) mm: standard deviation of each row's noise, inflated for neighbours that are alike, and (N,) by how much."""
    sigma, alike = np.empty(len(rows)), np.ones(len(rows))
    for signal in range(len(rows.signals)):
        which = np.flatnonzero(rows.signal == signal)
        if len(which):
            kind = str(rows.sees[which[0]])
            dense = rows.kinds[rows.file[which[0]]] in ("ballbar", "trace")
            repeated = None if dense else _repeated(rows, residual, rows.file[which[0]])
            if repeated is not None:
                size, rho = repeated, 0.0
            else:
                size, rho = _dense(rows, residual, which) if dense else _sparse(rows, residual, which)
            coarse = rows.rounding[which]
            if dense and np.sqrt(np.mean(coarse**2)) > COARSE * size:
                # The log's rounding is what it is wrong by; what comes on top is what its finest part scatters by.
                fine = coarse <= np.quantile(coarse, 0.25)
                size = min(size, float(np.sqrt(np.mean(coarse[fine] ** 2))))
                sigma[which] = np.hypot(max(size, FLOOR[kind]), coarse)
                continue
            alike[which] = np.sqrt((1 + rho) / (1 - rho))
            sigma[which] = max(size, FLOOR[kind]) * alike[which]
    for file in range(len(rows.files)):  # one gauge measures all features of a part: few of each, many together
        own = (rows.file == file) & (rows.sees == "part")
        each = [float(sigma[own & (rows.signal == s)][0]) for s in np.unique(rows.signal[own])]
        if each:
            sigma[own] = float(np.median(each))
    return sigma, alike


def spread(values: np.ndarray) -> float:
    """Standard deviation by the median of absolute deviations."""
    return float(MAD * np.median(np.abs(values - np.median(values)))) if len(values) else 0.0


def _place(rows: Rows, which: np.ndarray) -> np.ndarray:
    """Rows at the same place from the same side have the same number."""
    columns = [np.round(p[which], 3) for p in rows.state.position.values()]
    columns += [np.sign(s[which]) for s in rows.state.approach.values()]
    if rows.other:
        columns += [np.round(np.nan_to_num(v[which]), 3) for v in rows.other.values()]
    _, number = np.unique(np.stack(columns), axis=1, return_inverse=True)
    return number.ravel()


def _sparse(rows: Rows, residual: np.ndarray, which: np.ndarray) -> tuple[float, float]:
    """Targets and features: differences between runs at a place, and of those between neighbours of a run."""
    place, run = _place(rows, which), rows.run[which]
    y = residual[which]
    differences = []
    runs = np.unique(run)
    for a, b in pairwise(runs):
        first = {int(p): float(v) for p, v in zip(place[run == a], y[run == a], strict=True)}
        pairs = [float(v) - first[int(p)] for p, v in zip(place[run == b], y[run == b], strict=True) if int(p) in first]
        if len(pairs) > 2:
            differences.append(np.diff(pairs) / 2.0)
        elif pairs:
            differences.append(np.array(pairs) / np.sqrt(2.0))
    if differences:
        flat = np.concatenate(differences)
        return spread(flat) if len(flat) > 3 else float(np.std(flat)), 0.0
    order = np.lexsort((rows.state.time[which], run))
    second = np.diff(y[order], 2) / np.sqrt(6.0)
    return spread(second) if len(second) > 3 else float(np.std(y)), 0.0


def _repeated(rows: Rows, residual: np.ndarray, file: int) -> float | None:
    """Features that were measured several times on each part: what the readings of one scatter by, over all of a file; None
    where fewer than four readings say so."""
    if rows.kinds[file] != "features":
        return None
    own = np.flatnonzero(rows.file == file)
    _, group = np.unique(np.stack([rows.signal[own], rows.run[own]]), axis=1, return_inverse=True)
    group = group.ravel()
    count = np.bincount(group)
    free = len(own) - len(count)
    if free < 4:
        return None
    mean = np.bincount(group, residual[own]) / count
    return float(np.sqrt(np.sum((residual[own] - mean[group]) ** 2) / free))


def _dense(rows: Rows, residual: np.ndarray, which: np.ndarray) -> tuple[float, float]:
    """Samples in motion: noise and how much neighbours are alike."""
    y, run = residual[which], rows.run[which]
    rough = []
    for r in np.unique(run):
        part = y[run == r]
        if len(part) > 8:
            rough.append(_without_lines(part - _smooth(part)))
    if not rough:
        return float(np.std(y)), 0.0
    flat = np.concatenate(rough)
    size = spread(flat)
    rho = np.mean([_alike(part) for part in rough])
    return size * np.sqrt(15.0 / 14.0), float(np.clip(rho, 0.0, LARGEST_RHO))


def _without_lines(values: np.ndarray) -> np.ndarray:
    """What is left when the sharpest lines of the spectrum are taken out: an oscillation is no noise."""
    spectrum = np.fft.rfft(values)
    power = np.abs(spectrum) ** 2
    width = 31
    if len(power) < 2 * width:
        return values
    around = np.array([np.median(power[max(0, k - width) : k + width + 1]) for k in range(0, len(power), width)])
    level = np.repeat(around, width)[: len(power)]
    line = power > LINE * np.maximum(level, 1e-30)
    wide = line | np.concatenate([line[1:], [False]]) | np.concatenate([[False], line[:-1]])
    spectrum[wide] = 0.0
    return np.fft.irfft(spectrum, len(values))


def _smooth(values: np.ndarray, width: int = 15) -> np.ndarray:
    """Running line fit of a few neighbours: mean of a window, ends mirrored oddly."""
    half = width // 2
    half = min(half, len(values) - 1)
    head, tail = 2 * values[0] - values[half:0:-1], 2 * values[-1] - values[-2 : -half - 2 : -1]
    wide = np.concatenate([head, values, tail])
    total = np.concatenate([[0.0], np.cumsum(wide)])
    return (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)


def _alike(values: np.ndarray) -> float:
    """Correlation of neighbours; a running mean of 15 that was taken out makes it lower by about a seventh."""
    clipped = np.clip(values, -4 * spread(values), 4 * spread(values))
    square = float((clipped**2).sum())
    return float((clipped[1:] * clipped[:-1]).sum() / square) + 1 / 7 if square > 0 else 0.0


def isolated(rows: Rows, residual: np.ndarray, sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) how many times the noise a reading at rest lies off, alone: neither the other runs at its place nor its
    neighbours bear it out; and (N,) mm by how much. 0 for samples in motion, and where there is nothing to compare with."""
    result, size = np.zeros(len(rows)), np.zeros(len(rows))
    for signal in range(len(rows.signals)):
        which = np.flatnonzero(rows.signal == signal)
        if not len(which) or rows.kinds[rows.file[which[0]]] not in ("targets", "features"):
            continue
        which = which[np.lexsort((rows.state.time[which], rows.run[which]))]
        place, run = _place(rows, which), rows.run[which]
        if rows.kinds[rows.file[which[0]]] == "targets" and np.median(np.bincount(place)) < 3:
            passages = _passages(rows, which)
            if passages is not None:
                for part, p in passages:
                    times, size[part] = slips.departures(p, residual[part], sigma[part])
                    result[part] = np.abs(times)
                    end, off = slips.at_ends(
                        p, residual[part], _elsewhere(rows, residual, which, part, place), sigma[part]
                    )
                    result[part], size[part] = np.where(end > 0, end, result[part]), np.where(end > 0, off, size[part])
                continue
        y = residual[which].copy()
        for p in np.unique(place):  # what all runs share at a place is no outlier
            same = place == p
            y[same] -= np.median(y[same]) if same.sum() > 2 else 0.0
        for k in range(len(which)):
            near = [j for j in range(max(0, k - 3), min(len(which), k + 4)) if j != k and run[j] == run[k]]
            around = float(np.median(y[near])) if near else 0.0
            result[which[k]] = abs(y[k] - around) / sigma[which[k]]
            size[which[k]] = y[k] - around
    return result, np.abs(size)


def _elsewhere(rows: Rows, residual: np.ndarray, which: np.ndarray, part: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(M,) median of what other runs read at the places of the rows `part`, nan where there were none; place: of the rows `which`."""
    number = dict(zip(which.tolist(), place.tolist(), strict=True))
    found = np.full(len(part), np.nan)
    for k, row in enumerate(part.tolist()):
        others = which[(place == number[row]) & (rows.run[which] != rows.run[row])]
        if len(others):
            found[k] = float(np.median(residual[others]))
    return found


def _passages(rows: Rows, which: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Rows and places of every run in every direction, along the axis that moves most; None where one comes to a place
    twice, or none moves."""
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
