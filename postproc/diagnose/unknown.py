"""What is left when every name has been tried: how large it is, what it goes with, and a map of it
that nobody has to believe.

The map is of cell means over the rows that took part; what it is worth is shown on those that took
none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.diagnose.rows import Rows

CELLS = 16
TARGETS = 64  # places that readings at rest stand at
FEWEST = 2  # rows of a cell


@dataclass(frozen=True)
class Cell:
    """Rows between two places (mm) or times (s), from one side or any (0): how many, their mean and
    its standard error, mm."""

    low: float
    high: float
    approach: int
    rows: int
    mean: float
    error: float


@dataclass(frozen=True)
class Unknown:
    """signal: its number; rms mm that repeats; share of what was there in that signal; along: the
    axis of the map, or "time";
    depends: "position", "direction", "time"; before, after: rms in mm of rows that took no part,
    without and with the map, None where there are none."""

    signal: int
    rms: float
    share: float
    along: str
    depends: tuple[str, ...]
    cells: tuple[Cell, ...]
    before: float | None
    after: float | None


def mapped(
    rows: Rows, held: np.ndarray, signal: int, size: float, share: float, rest: np.ndarray
) -> Unknown:
    """The map of the rest (N,), mm, that explains most where it took no part (held (N,) bool);
    where every row took part, most of what it was made of."""
    which, state = rows.signal == signal, rows.state
    axis = max(state.position, key=lambda x: float(np.ptp(state.position[x][which])))
    place, side = state.position[axis], np.sign(state.approach[axis]).astype(int)
    train, held = which & ~held, which & held
    # What it may go with, the richest first: of two that predict alike the first is kept, and each
    # cell costs (the factor below). (along, what depends, value, side)
    ways = (
        (axis, ("position", "direction"), place, side),
        (axis, ("position",), place, np.zeros_like(side)),
        (axis, ("direction",), np.zeros(len(place)), side),
        ("time", ("time",), state.time, np.zeros_like(side)),
    )
    best = None
    for along, depends, value, way in ways:
        cells = _cells(value[train], way[train], rest[train])
        judged = held if held.any() else train
        after = rest[judged] - predicted(cells, value[judged], way[judged])
        after = after - after.mean() + rest[judged].mean()  # a zero is nothing that a map explains
        # Where nothing was held out the map is judged on what it was made of: a cell more always
        # helps there, by about 1 / rows of the variance.
        worth = float(np.mean(after**2)) * (1 + len(cells) / max(int(train.sum()), 1))
        if best is None or worth < best[0]:
            before = float(np.sqrt(np.mean(rest[judged] ** 2)))
            seen = (before, float(np.sqrt(np.mean(after**2)))) if held.any() else (None, None)
            best = (worth, Unknown(signal, size, share, along, depends, cells, *seen))
    assert best is not None
    return best[1]


def _cells(value: np.ndarray, way: np.ndarray, residual: np.ndarray) -> tuple[Cell, ...]:
    result = []
    for w in np.unique(way):
        own = way == w
        places, number = np.unique(np.round(value[own], 2), return_inverse=True)
        if len(places) <= TARGETS:  # every target is a cell
            low = high = places
        else:
            edges = np.unique(np.quantile(value[own], np.linspace(0, 1, CELLS + 1)))
            number = np.clip(
                np.searchsorted(edges, value[own], side="right") - 1, 0, len(edges) - 2
            )
            low, high = edges[:-1], edges[1:]
        for k in np.unique(number):
            y = residual[own][number == k]
            if len(y) >= FEWEST:
                error = float(np.std(y, ddof=1) / np.sqrt(len(y)))
                result.append(
                    Cell(float(low[k]), float(high[k]), int(w), len(y), float(y.mean()), error)
                )
    return tuple(result)


def predicted(cells: tuple[Cell, ...], value: np.ndarray, way: np.ndarray) -> np.ndarray:
    """(N,) mm: what a map says, linear between the middles of its cells, level beyond them; 0 where
    it knows nothing."""
    result = np.zeros(len(value))
    for w in np.unique(way):
        own = [c for c in cells if c.approach == w]
        if own:
            result[way == w] = np.interp(
                value[way == w], [(c.low + c.high) / 2 for c in own], [c.mean for c in own]
            )
    return result
