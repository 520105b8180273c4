"""Where measured and simulated differ, before anything has a name: places, directions, runs and times that stand out.

Every signal is cut into cells along position, by direction of approach, and along time; the window of cells whose mean
departs most from zero is found, and the chance that noise alone makes one as large is counted on draws of the noise and of
the nuisances (Kulldorff's scan statistic, in one dimension).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.diagnose.fit import Projector
from postproc.diagnose.rows import Rows

CELLS = 12
DRAWS = 199
SIGNIFICANT = 0.01


@dataclass(frozen=True)
class Place:
    """One region of one signal: file, axis, from, to mm; approach "+", "-" or "both"; runs, times and lines of its rows;
    rms and peak in mm; p; program: first and last line of the
    program, where it was recorded."""

    file: int
    signal: int
    axis: str
    low: float
    high: float
    approach: str
    runs: tuple[int, ...]
    times: tuple[float, float]
    lines: tuple[int, int]
    rms: float
    peak: float
    p: float
    program: tuple[int, int] | None = None


def regions(rows: Rows, sigma: np.ndarray, u: np.ndarray, prior: np.ndarray) -> list[Place]:
    """The region of every signal that noise does not explain, the clearest first."""
    # Zeros are nobody's fault; what the map may be wrong by is among the draws: more than that is a mismatch.
    free = prior >= 0.005
    projector = Projector.of(sigma, u[:, free], prior[free])
    rng = np.random.default_rng(99)
    y = rows.residual
    left = y - projector.nuisance(y)
    draws = (u * np.where(free, 0.0, prior)) @ rng.normal(size=(len(prior), DRAWS))
    draws += sigma[:, None] * rng.normal(size=(len(y), DRAWS))
    evidence = projector(np.concatenate([y[:, None], draws], axis=1))
    found = []
    for signal in np.unique(rows.signal):
        which = np.flatnonzero(rows.signal == signal)
        axis = max(rows.state.position, key=lambda x: float(np.ptp(rows.state.position[x][which])))
        place, side = rows.state.position[axis][which], np.sign(rows.state.approach[axis][which])
        cell = _cells(place, side)
        windows = _windows(int(cell.max()) + 1)
        value, at, nulls = _scan(projector, evidence, which, cell, windows)
        p = (1 + int((nulls >= value).sum())) / (DRAWS + 1)
        if p > SIGNIFICANT:
            continue
        a, b = windows[at]
        inside = which[(cell >= a) & (cell < b)]
        half = (int(cell.max()) + 1) // 2
        approach = "both" if (side == side[0]).all() or (a < half < b) else "-" if b <= half else "+"
        pick = rows.state.position[axis][inside]
        found.append(
            Place(
                int(rows.file[inside[0]]), int(signal), axis, float(pick.min()), float(pick.max()), approach,
                tuple(int(r) for r in np.unique(rows.run[inside])[:50]),
                (float(rows.state.time[inside].min()), float(rows.state.time[inside].max())),
                (int(rows.line[inside].min()), int(rows.line[inside].max())), float(np.sqrt(np.mean(left[inside] ** 2))),
                float(np.abs(left[inside]).max()), p, _program(rows, inside),
            )
        )  # fmt: skip
    return sorted(found, key=lambda f: -f.rms)


def _scan(projector: Projector, evidence: np.ndarray, which: np.ndarray, cell: np.ndarray, windows):
    """The highest score of a window, which it is, and the highest of each draw: by how much chi squared falls if the window
    had a mean of its own, beside all nuisances."""
    n = int(cell.max()) + 1
    member = np.zeros((len(evidence), n))
    member[which, cell] = 1.0
    normal = member.T @ projector(member)
    sums = member.T @ evidence
    along = np.concatenate([np.zeros((1, sums.shape[1])), np.cumsum(sums, axis=0)])
    block = np.zeros((n + 1, n + 1))
    block[1:, 1:] = normal.cumsum(axis=0).cumsum(axis=1)
    best, where = np.zeros(sums.shape[1]), 0
    for k, (a, b) in enumerate(windows):
        power = block[b, b] - block[a, b] - block[b, a] + block[a, a]
        if power <= 1e-9 * max(float(np.trace(normal)), 1e-30):
            continue
        score = (along[b] - along[a]) ** 2 / power
        if score[0] > best[0]:
            where = k
        best = np.maximum(best, score)
    return float(best[0]), where, best[1:]


def _program(rows: Rows, which: np.ndarray) -> tuple[int, int] | None:
    line = rows.state.channels.get("program_line")
    return None if line is None else (int(np.floor(line[which].min())), int(np.ceil(line[which].max())))


def _cells(place: np.ndarray, side: np.ndarray) -> np.ndarray:
    """(N,) cell of each row: along the position, first those approached in -, then the others."""
    edges = np.unique(np.quantile(place, np.linspace(0, 1, CELLS + 1)))
    cell = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, max(len(edges) - 2, 0))
    return cell + np.where(side < 0, 0, CELLS)


def _windows(n: int) -> list[tuple[int, int]]:
    """Windows of one cell to a whole direction, and of everything."""
    result = [(0, n)]
    for first, stop in ((0, min(CELLS, n)), (CELLS, n)):
        for a in range(first, stop):
            for b in range(a + 1, stop + 1):
                result.append((a, b))
    return result


def shared(rows: Rows, left: np.ndarray, sigma: np.ndarray, which: np.ndarray) -> float:
    """mm: size of what several runs show alike at the same places, from products of different runs; of a single run from
    products of neighbours."""
    where = np.flatnonzero(which)
    axis = max(rows.state.position, key=lambda x: float(np.ptp(rows.state.position[x][where])))
    side = np.sign(rows.state.approach[axis][where])
    bins = np.round(rows.state.position[axis][where] / max(np.ptp(rows.state.position[axis][where]) / 40, 1e-9)).astype(
        int
    )
    _, cell = np.unique(np.stack([bins, side]), axis=1, return_inverse=True)
    cell = cell.ravel()
    runs = np.unique(rows.run[where])
    means = np.full((len(runs), cell.max() + 1), np.nan)
    for k, r in enumerate(runs):
        own = rows.run[where] == r
        count = np.bincount(cell[own], minlength=means.shape[1])
        total = np.bincount(cell[own], left[where][own], minlength=means.shape[1])
        means[k] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    products = []
    for k in range(1, len(runs)):
        both = means[k] * means[k - 1]
        products.append(both[np.isfinite(both)])
    flat = np.concatenate(products) if products else np.zeros(0)
    if len(flat) < 6:
        values = left[where][np.argsort(rows.state.time[where], kind="stable")]
        flat = values[1:] * values[:-1]
    if not len(flat):
        return 0.0
    middle = np.clip(flat, *np.quantile(flat, [0.02, 0.98]))
    return float(np.sqrt(max(middle.mean(), 0.0)))
