"""Where measured and simulated differ, before anything has a name: places, directions, runs and
times that stand out.

Every signal is cut into cells along position, by direction of approach, and along time; the window
of cells whose mean departs most from zero is found, and the chance that noise alone makes one as
large is counted on draws of the noise and of the nuisances (Kulldorff's scan statistic, in one
dimension). A stretch of the way is narrowed to a stretch of the time where that is told by more
than noise would: what comes with heat stands out at one place, and not always.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from postproc.diagnose.fit import Projector
from postproc.diagnose.rows import Rows
from postproc.machine.chain import XYZ

# Cells of one signal, n = 2 along, and windows over them, of "-", of "+" or of both alike:
#
#     cell    0    1    2  ... along-1 | along  along+1  ... 2 along-1
#     approached in -                  | approached in + (or from a side that nobody knows)
#     window       [a,       b)        |        [along+a,      along+b)
#
Scanned = tuple[np.ndarray, float, np.ndarray]  # rows, score, the highest of each draw

CELLS = 12
TARGETS = 30  # places of their own: no more of them than that are each a cell
DRAWS = 199
PARTS = 8  # of rows and of draws: of all at once every copy takes as much memory as they do
SIGNIFICANT = 0.01
OWN = 0.9  # of the reading is taken along one axis: it is that axis'
FAR = 0.1  # of what the farthest axis goes: it moves
TIE = 1e-3  # of the highest score


@dataclass(frozen=True)
class Place:
    """One region of one signal: file, axis, from, to mm; approach "+", "-" or "both"; runs, times
    and lines of its rows; rms and peak of the readings there in mm; p; program: first and last line
    of the program, where it was recorded; timed: whether it stands out then, and not at other times
    at the same place."""

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
    timed: bool = False


@dataclass(frozen=True)
class _Looked:
    """What stands out most in one signal. which (M,): its rows; side, cell (M,); own, later: of
    these the window along the way and in time, value, worth: their scores; nulls (DRAWS,): the
    higher of both of each draw; test: of signals that are tested together."""

    signal: int
    which: np.ndarray
    axis: str
    side: np.ndarray
    cell: np.ndarray
    own: np.ndarray
    value: float
    later: np.ndarray
    worth: float
    nulls: np.ndarray
    test: int


def _looked(rows: Rows, projector: Projector, evidence: np.ndarray, signal: int) -> _Looked:
    which = np.flatnonzero(rows.signal == signal)
    axis = axis_of(rows, which)
    place, side = rows.state.position[axis][which], np.sign(rows.state.approach[axis][which])
    cell, along = _cells(place, side)
    windows = _windows(along, int(cell.max()) + 1)
    own, value, nulls = _scan(projector, evidence, which, cell, windows)
    later, worth, chances = _in_time(projector, evidence, which, rows.state.time[which])
    test = -1 - int(rows.file[which[0]]) if rows.sees[which[0]] == "part" else signal
    both = np.maximum(nulls, chances)
    return _Looked(signal, which, axis, side, cell, own, value, later, worth, both, test)


def regions(rows: Rows, sigma: np.ndarray, u: np.ndarray, prior: np.ndarray) -> list[Place]:
    """The region of every signal that noise does not explain, the clearest first."""
    # Zeros are nobody's fault; what the map may be wrong by is among the draws: more than that is a
    # mismatch.
    # mm. Wander, runs and the map's error are smaller, and drawn; zeros, centres and the growth of
    # a bar are larger, and fitted.
    free = prior >= 0.005
    projector = Projector.of(sigma, u[:, free], prior[free])
    rng = np.random.default_rng(99)
    y = rows.residual
    left = y - projector.nuisance(y)
    evidence = np.empty((len(y), 1 + DRAWS))
    evidence[:, 0], draws = y, evidence[:, 1:]
    draws[:] = u @ (np.where(free, 0.0, prior)[:, None] * rng.normal(size=(len(prior), DRAWS)))
    for part, sd in zip(np.array_split(draws, PARTS), np.array_split(sigma, PARTS), strict=True):
        part += sd[:, None] * rng.normal(size=part.shape)
    for part in np.array_split(evidence, PARTS, axis=1):
        part[:] = projector(part)
    looked = [_looked(rows, projector, evidence, int(k)) for k in np.unique(rows.signal)]
    # features of a part are one test: the largest of all of them
    nulls: dict[int, np.ndarray] = {}
    for seen in looked:
        nulls[seen.test] = np.maximum(seen.nulls, nulls.get(seen.test, 0.0))
    found = []
    for seen in looked:
        signal, which, axis, own = seen.signal, seen.which, seen.axis, seen.own
        side, cell, time = seen.side, seen.cell, rows.state.time[which]
        value, later, worth = seen.value, seen.later, seen.worth
        # A draw counts that departs as far anywhere, so the search over windows is paid for. The
        # readings count as one of DRAWS + 1: no p is 0.
        p = (1 + int((nulls[seen.test] >= max(value, worth)).sum())) / (DRAWS + 1)
        if p > SIGNIFICANT:
            continue
        timed = worth > value and _elsewhen(cell, later) and np.ptp(time) > 0
        if timed:
            own = later
        elif len(short := _at_times(projector, evidence, which, own, time)):
            own, timed = own[short], True
        inside = which[own]
        sides = np.unique(side[own])
        approach = (
            "both" if len(np.unique(side)) == 1 or len(sides) > 1 else "-" if sides[0] < 0 else "+"
        )
        pick = rows.state.position[axis][inside]
        found.append(
            Place(
                int(rows.file[inside[0]]),
                signal,
                axis,
                float(pick.min()),
                float(pick.max()),
                approach,
                tuple(int(r) for r in np.unique(rows.run[inside])[:50]),
                (float(rows.state.time[inside].min()), float(rows.state.time[inside].max())),
                (int(rows.line[inside].min()), int(rows.line[inside].max())),
                float(np.sqrt(np.mean(left[inside] ** 2))),
                float(np.abs(left[inside]).max()),
                p,
                _program(rows, inside),
                timed,
            )
        )
    return sorted(found, key=lambda f: -f.rms)


def axis_of(rows: Rows, which: np.ndarray) -> str:
    """The axis along which a signal's rows are looked at: the one that it reads, where that moves,
    else the one that moves most."""
    went = {x: float(np.ptp(p[which])) for x, p in rows.state.position.items()}
    most = max(went, key=lambda x: went[x])
    if rows.sees[which[0]] == "angle":  # about an axis, and not along it
        return most
    reads = np.abs(rows.direction[which]).mean(axis=0)
    own = XYZ[int(np.argmax(reads))]
    return own if reads.max() > OWN and went.get(own, 0.0) > FAR * went[most] else most


def inside(place: Place, rows: Rows) -> np.ndarray:
    """(N,) bool: the readings of a region."""
    at, side, time = (
        rows.state.position[place.axis],
        np.sign(rows.state.approach[place.axis]),
        rows.state.time,
    )
    own = (rows.signal == place.signal) & (at >= place.low) & (at <= place.high)
    own &= (time >= place.times[0]) & (time <= place.times[1])
    inside: np.ndarray = (
        own if place.approach == "both" else own & ((side >= 0) == (place.approach == "+"))
    )
    return inside


def measured(places: list[Place], rows: Rows, before: np.ndarray) -> list[Place]:
    """Regions with the rms and the peak that readings have there without any effect, (N,) mm, the
    largest first."""
    found = []
    for place in places:
        off = before[inside(place, rows)]
        found.append(
            replace(place, rms=float(np.sqrt(np.mean(off**2))), peak=float(np.abs(off).max()))
        )
    return sorted(found, key=lambda f: -f.rms)


def _in_time(
    projector: Projector, evidence: np.ndarray, which: np.ndarray, time: np.ndarray
) -> Scanned:
    """As `_scan`, of stretches of the time."""
    edges = np.unique(np.quantile(time, np.linspace(0, 1, CELLS + 1)))
    cell = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, max(len(edges) - 2, 0))
    return _scan(projector, evidence, which, cell, _stretches(int(cell.max()) + 1))


def _elsewhen(cell: np.ndarray, own: np.ndarray) -> bool:
    """Whether most of the places of the rows `own` were visited at other times too."""
    others = np.delete(cell, own)
    return float(np.mean(np.isin(np.unique(cell[own]), others))) > 0.5


def _at_times(
    projector: Projector, evidence: np.ndarray, which: np.ndarray, own: np.ndarray, time: np.ndarray
) -> np.ndarray:
    """Which rows of the stretch `own` of the way belong to the visits in a row in which it stands
    out, or none where it does at all of them: by how much chi squared falls if these had a mean of
    their own, beside one of the whole stretch and all nuisances, against the same of the draws."""
    order = np.argsort(time, kind="stable")
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    turn = np.argsort(rank[own], kind="stable")
    visit = np.empty(len(own), int)
    # Rows of the stretch in the order of time: where others come between two of them, a new visit.
    visit[turn] = np.cumsum(np.diff(rank[own][turn], prepend=-1) > 1) - 1
    visit -= visit.min()
    n = int(visit.max()) + 1
    if n < 2 or np.ptp(time[own]) == 0:
        return own[:0]
    cell = visit * min(n, CELLS) // n
    windows = _stretches(min(n, CELLS))[:-1]
    member = np.zeros((len(evidence), windows.shape[1]))
    member[which[own], cell] = 1.0
    # Sums over cells, once; a window's are those of its cells added up (wide), for all windows and
    # draws.
    normal, projected = member.T @ projector(member), member.T @ evidence
    whole = normal.sum(axis=0)
    share = whole / max(float(whole.sum()), 1e-30)
    normal, beside = (
        normal - np.outer(share, whole),
        projected - np.outer(share, projected.sum(axis=0)),
    )
    wide = windows.astype(float)
    power = np.einsum("wi,ij,wj->w", wide, normal, wide)
    seen = power > 1e-9 * max(float(np.trace(normal)), 1e-30)
    score = (wide @ beside) ** 2 / np.where(seen, power, np.inf)[:, None]
    most = float(score[:, 0].max())
    if 1 + int((score[:, 1:].max(axis=0) >= most).sum()) > SIGNIFICANT * (DRAWS + 1):
        return own[:0]
    # a stretch and all the other visits tell the same: where it departs farther is meant
    alike = np.flatnonzero(score[:, 0] >= (1 - TIE) * most)
    mean = np.abs(wide @ projected[:, 0])[alike] / (wide @ member.sum(axis=0))[alike]
    return np.flatnonzero(windows[alike[np.argmax(mean)]][cell])


def _stretches(n: int) -> np.ndarray:
    """(W, n) bool: one cell to all of them in a row, the whole last."""
    pairs = [(a, b) for a in range(n) for b in range(a + 1, n + 1)]
    pairs.sort(key=lambda pair: pair[1] - pair[0])
    return np.stack([(np.arange(n) >= a) & (np.arange(n) < b) for a, b in pairs])


def _scan(
    projector: Projector,
    evidence: np.ndarray,
    which: np.ndarray,
    cell: np.ndarray,
    windows: np.ndarray,
) -> Scanned:
    """Which of the rows are in the window with the highest score, that score, and the highest of
    each draw: by how much chi squared falls if the window had a mean of its own, beside all
    nuisances."""
    n = windows.shape[1]
    member = np.zeros((len(evidence), n))
    member[which, cell] = 1.0
    normal = _sums(projector(member)[which], cell, n)
    wide = windows.astype(float)
    power = np.einsum("wi,ij,wj->w", wide, normal, wide)
    determined = power > 1e-9 * max(float(np.trace(normal)), 1e-30)
    # (m'P y)^2 / m'P m, m the window's 0 and 1: chi squared of a mean of its own. A window that
    # zeros and set-ups take up whole has m'P m = 0.
    score = (wide @ _sums(evidence[which], cell, n)) ** 2 / np.where(determined, power, np.inf)[
        :, None
    ]
    # Beside a free zero a stretch and all the rest of the way tell the same: the shorter one is
    # meant.
    most = float(score[:, 0].max())
    alike = np.flatnonzero(score[:, 0] >= (1 - TIE) * most)
    size = (windows[alike] @ member.sum(axis=0)).astype(int)
    return np.flatnonzero(windows[alike[np.argmin(size)]][cell]), most, score[:, 1:].max(axis=0)


def _sums(value: np.ndarray, cell: np.ndarray, n: int) -> np.ndarray:
    """(n, K) sums of the rows (M, K) of each cell (M,)."""
    result = np.zeros((n, value.shape[1]))
    order = np.argsort(cell, kind="stable")
    there, first = np.unique(cell[order], return_index=True)
    result[there] = np.add.reduceat(value[order], first)
    return result


def _program(rows: Rows, which: np.ndarray) -> tuple[int, int] | None:
    line = rows.state.channels.get("program_line", np.full(len(rows), np.nan))[which]
    known = line[np.isfinite(line)]
    return (int(np.floor(known.min())), int(np.ceil(known.max()))) if len(known) else None


def _cells(place: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, int]:
    """(N,) cell of each row: along the position, first those approached in -, then the others; and
    how many there are along."""
    targets = np.unique(np.round(place, 1))
    if len(targets) <= TARGETS:
        edges = np.concatenate([[-np.inf], (targets[1:] + targets[:-1]) / 2, [np.inf]])
    else:
        edges = np.unique(np.quantile(place, np.linspace(0, 1, CELLS + 1)))
    along = max(len(edges) - 1, 1)
    cell = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, along - 1)
    return cell + np.where(side < 0, 0, along), along


def _windows(along: int, n: int) -> np.ndarray:
    """(W, n) bool: which cells are in a window: one cell to all of them along the way, of either
    direction or of both."""
    result = [np.ones(n, bool)]
    for a in range(along):
        for b in range(a + 1, along + 1):
            back, forth = np.zeros(n, bool), np.zeros(n, bool)
            back[a:b] = True
            forth[along + a : along + b] = True
            result += [back | forth, back, forth] if forth.any() else [back]
    return np.stack(result)
