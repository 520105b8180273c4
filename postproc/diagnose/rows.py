"""Rows: what was measured, what the machine's file predicts, and the state that every effect may
look at.

A reading is the part of the tool's deviation along a direction, or of an axis' own scale; a feature
of a part is the difference of two places. assembly makes rows of recordings.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from postproc.diagnose.creep import Slips
from postproc.effects import State
from postproc.machine.chain import XYZ

ENTERS = 0.2  # of a reading


@dataclass(frozen=True)
class Rows:
    """N rows. y, known (N,) mm: measured, predicted by the machine's file; direction (N, 3): how
    the tool's deviation enters; sees: per row what kind of signal it is ("laser", "angle", "tool",
    "scale", "part"); file, run, signal, line (N,); state: of the rows; signals, files, kinds:
    names of signals and files, and of which kind each recording is; other: axis to mm (N,), the
    second place of features, nan where it is not known, empty where no row is of a part; grain (N,)
    mm: what the noise of single samples leaves in an averaged row, 0 elsewhere; rounding (N,) mm:
    what the log's own rounding gives; fast_hz: oscillations that samples show and rows, which are
    their averages, do not resolve; slips: axis to slips that its samples show."""

    y: np.ndarray
    known: np.ndarray
    direction: np.ndarray
    sees: np.ndarray
    file: np.ndarray
    run: np.ndarray
    signal: np.ndarray
    line: np.ndarray
    state: State
    signals: tuple[str, ...]
    files: tuple[str, ...]
    kinds: tuple[str, ...]
    other: dict[str, np.ndarray] = field(default_factory=dict)
    grain: np.ndarray = field(default_factory=lambda: np.zeros(0))
    rounding: np.ndarray = field(default_factory=lambda: np.zeros(0))
    fast_hz: tuple[float, ...] = ()
    slips: dict[str, Slips] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.y)

    @property
    def residual(self) -> np.ndarray:
        """(N,) mm: measured minus predicted."""
        residual: np.ndarray = self.y - self.known
        return residual

    @cached_property
    def _of_kind(self) -> dict[str, np.ndarray]:
        return {str(kind): self.sees == kind for kind in np.unique(self.sees)}

    def seen(self, kinds: Iterable[str]) -> np.ndarray:
        """(N,) bool: rows whose signal is of one of these kinds."""
        result = np.zeros(len(self), bool)
        for kind in kinds:
            if kind in self._of_kind:
                result |= self._of_kind[kind]
        return result

    @cached_property
    def _along(self) -> dict[str, tuple[np.ndarray, State]]:
        return {}

    def along(self, axis: str) -> tuple[np.ndarray, State]:
        """(M,) numbers of the rows whose reading has a part along an axis, and their state."""
        if axis not in self._along:
            # exactly zero: a laser along Z sees nothing of X, however large
            own = np.flatnonzero(self.direction[:, XYZ.index(axis)])
            state = self.state if len(own) == len(self) else pick_state(self.state, own)
            self._along[axis] = own, state
        return self._along[axis]

    def pick(self, which: np.ndarray) -> Rows:
        """Some of the rows."""
        arrays = ("y", "known", "direction", "sees", "file", "run", "signal", "line", "grain")
        return replace(
            self,
            state=pick_state(self.state, which),
            other={x: v[which] for x, v in self.other.items()},
            rounding=self.rounding[which],
            **{name: getattr(self, name)[which] for name in arrays},
        )


def pick_state(state: State, which: np.ndarray) -> State:
    """Some of the rows."""

    def of_each(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {k: v[..., which] for k, v in values.items()}

    # By place, in the order of State's fields: one that is added there and not here would be empty
    # in every part of the rows, without an error.
    return State(
        of_each(state.position),
        of_each(state.approach),
        state.travel,
        of_each(state.velocity),
        of_each(state.acceleration),
        of_each(state.distance),
        of_each(state.since),
        state.time[which],
        state.run[which],
        of_each(state.channels),
        of_each(state.angles),
        state.beam[which],
        state.passage[which],
        state.file[which],
        state.width[which],
        state.lines,
        of_each(state.inside),
        of_each(state.path),
        of_each(state.slipped),
        of_each(state.arms),
        state.on_arm,
        state.turned[which] if len(state.turned) else state.turned,
    )


def second_place(rows: Rows, which: np.ndarray) -> State:
    """The state at the other wall of features: its own place, reached from the other side."""
    # Both walls are reached outwards from the middle of a pocket (inwards on a boss): one in +, the
    # other in -. So lost motion adds up in a size, and ways since a turn change their sign.
    there = pick_state(rows.state, which)
    position = {x: np.nan_to_num(rows.other[x][which]) for x in there.position}
    inside = dict(there.inside)
    for x in inside.keys() & position.keys():
        inside[x] = np.full_like(inside[x], np.nan)
        inside[x][:1] = position[x]
    return replace(
        there,
        position=position,
        inside=inside,
        approach={x: -a for x, a in there.approach.items()},
        path={x: -ways for x, ways in there.path.items()},
        arms={},
    )


def diameters(rows: Rows) -> np.ndarray:
    """(N,) bool: diameters of a lathe, whose place on the slide is known."""
    if not rows.other:
        return np.zeros(len(rows), bool)
    diameters: np.ndarray = (rows.sees == "part") & np.any(
        [np.isnan(v) for v in rows.other.values()], axis=0
    )
    return diameters
