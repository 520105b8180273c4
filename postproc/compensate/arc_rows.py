"""Parts of arcs that are to be fitted, and what the fit must know of the arcs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from postproc.compensate.arcs import height
from postproc.machine.model import Machine
from postproc.motions import Arcs
from postproc.records import columns, names
from postproc.units import TICKS_PER_MM

SHORTEST = 3  # least increments: a shorter arc is a chord


@columns
class Rows:
    """R parts of arcs. arc (R,): row of Arcs; stroke (R,); t0, t1 (R,): part of the arc; begin, end
    (A, R): ticks commanded; accepted as an arc with centre (2, R) ticks from begin, written as
    radius (R,) ticks, the R word, where that is not 0, or as a chord where chord (R,)."""

    arc: np.ndarray
    stroke: np.ndarray
    t0: np.ndarray
    t1: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    centre: np.ndarray
    radius: np.ndarray
    chord: np.ndarray

    def pick(self, which: np.ndarray) -> Rows:
        if which.dtype == bool:
            which = which.nonzero()[0]
        fields = names(Rows)
        return Rows(**{f: getattr(self, f).take(which, axis=-1) for f in fields})

    def __len__(self) -> int:
        return len(self.arc)


def joined(parts: Sequence[Rows]) -> Rows:
    """Several sets of rows in one."""
    fields = names(Rows)
    return Rows(**{f: np.concatenate([getattr(r, f) for r in parts], axis=-1) for f in fields})


Needed = Callable[[Rows, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@columns
class Fitter:
    """What is asked of the fit. start, target (A, n) mm of the arcs; tolerance mm in the plane, and
    along the third axis, and total in all; needed(rows, row, t, nominal) -> (A, K) mm: the exact
    command at a place; weight(rows) -> (A, R): side of approach along plain ones;
    led(rows, row, command) -> (A, K) mm: not beyond where lost motion holds the axes `followed`;
    round_to(stroke, command) -> ticks, by the `increments` of strokes, two (A, S); plain (n,):
    arcs along which only the map bends the command; single (n,): arcs that nothing stands before in
    their own block, where the word that counts turns is."""

    machine: Machine
    arcs: Arcs
    start: np.ndarray
    target: np.ndarray
    tolerance: float
    tolerance_across: float
    total: float
    mismatch: float
    needed: Needed
    weight: Callable[[Rows], np.ndarray]
    led: Callable[[Rows, np.ndarray, np.ndarray], np.ndarray]
    round_to: Callable[[np.ndarray, np.ndarray], np.ndarray]
    increments: tuple[np.ndarray, np.ndarray]
    plain: np.ndarray
    followed: np.ndarray
    base: np.ndarray  # (2, n) ticks of the written centre words, from the start
    step: np.ndarray  # (A, n) ticks of a least increment of each axis' word
    single: np.ndarray
    inside: np.ndarray  # (n,) bool: inside cutter radius compensation (postproc.compensate.cutter)
    shortest: np.ndarray  # (n,) mm: a piece of such an arc has at least this way
    builds: np.ndarray  # (A,) mm/mm: how steeply lost motion builds up with an axis' way
    tool: np.ndarray  # (n,) mm: radius of a tool on the arc's inside, 0: outside, nan: not stated

    @cached_property
    def moves(self) -> np.ndarray:
        """(A, n) bool: axes that move along arcs."""
        moves: np.ndarray = self.start != self.target
        return moves

    @cached_property
    def beside(self) -> np.ndarray:
        """(n,) mm that arcs go along the axis that moves farthest beside their planes."""
        way, every = np.abs(self.target - self.start), np.arange(len(self.arcs))
        way[self.arcs.first, every] = way[self.arcs.second, every] = 0.0
        farthest: np.ndarray = way.max(axis=0)
        return farthest

    @cached_property
    def grown(self) -> np.ndarray:
        """(n,) mm by which the radius grows along arcs."""
        grown: np.ndarray = self.arcs.radius_end - self.arcs.radius
        return grown

    @cached_property
    def kinds(self) -> tuple[bool, bool, bool]:
        """Whether there are arcs written with R, those that take no centre, and those inside cutter
        radius compensation."""
        each = (self.arcs.by_radius, self.arcs.radius_alone, self.inside)
        return tuple(bool(np.count_nonzero(column)) for column in each)  # type: ignore[return-value]

    def short(self, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
        """(R,) parts not to be cut again: shorter than the control resolves well, also beside the
        plane or so that next to nothing bends there; and flatter than a share of the tolerance."""
        sweep = np.abs(self.arcs.sweep[rows.arc] * (rows.t1 - rows.t0))
        radius = self.arcs.radius[rows.arc]
        sagitta = radius * height(np.minimum(sweep, np.pi))
        tiny = (
            sweep * radius
            < SHORTEST * self.arcs.grid.take(rows.arc, axis=1).max(axis=0) / TICKS_PER_MM
        )
        beside = self.beside[rows.arc] * (rows.t1 - rows.t0)
        tiny &= self.machine.bounds.kink * beside / 4 < self.tolerance / 8
        return tiny, sagitta < self.tolerance / 8
