"""A recording: the whole commanded way, where it was read, and what its instrument sees."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .base import LONG_AGO, Array, Fields


def _none() -> Array:
    return np.zeros(0)


@dataclass(eq=False)
class Recording:
    """kind: targets, ballbar, trace or features (the contract's). way_t, s, and way, mm by axis:
    all way points; taken: which of them were read; turns: of the way, what `reversals` gives. By
    axis, one value a reading: pos, mm; sense_of, the sign of the last motion; since_mm, since_s
    since the reversal; vel, mm/s; acc, mm/s2. sees: a trace's end, scale or tool. sensitive: a
    targets' direction. feed (mm/min), dwell (s): of targets. unit, radius (mm), sense: a ballbar's.
    axes, step_of_scale (um): a trace's. parts: columns of features. step: um, of the readings.
    noise, rho: um, and the correlation of readings with the same long-run variance, by channel;
    zero, white, walk (um), memory, tails: how noise is drawn. read: um by channel."""

    kind: str
    name: str
    n: int = 0
    head: dict[str, Any] = field(default_factory=dict)
    more: dict[str, Array] = field(default_factory=dict)  # further columns of the file
    way_t: Array = field(default_factory=_none)
    way: Fields = field(default_factory=dict)
    taken: Array = field(default_factory=_none)
    turns: dict[str, tuple[Array, Array, Array, Array]] = field(default_factory=dict)
    t: Array = field(default_factory=_none)
    t_written: Array | None = None  # by a clock that goes wrong
    run: Array = field(default_factory=_none)
    pos: Fields = field(default_factory=dict)
    sense_of: Fields = field(default_factory=dict)
    since_mm: Fields = field(default_factory=dict)
    since_s: Fields = field(default_factory=dict)
    vel: Fields = field(default_factory=dict)
    acc: Fields = field(default_factory=dict)
    sees: str = "tool"
    sensitive: dict[str, float] = field(default_factory=dict)
    feed: Array = field(default_factory=_none)
    dwell: Array = field(default_factory=_none)
    unit: Fields = field(default_factory=dict)
    radius: float = 0.0
    sense: Array = field(default_factory=_none)
    axes: list[str] = field(default_factory=list)
    step_of_scale: float = 0.0
    parts: dict[str, Array] = field(default_factory=dict)
    step: float = 0.1
    noise: dict[str, float] = field(default_factory=dict)
    rho: dict[str, float] = field(default_factory=dict)
    zero: dict[str, float] = field(default_factory=dict)
    white: float = 0.0
    walk: float = 0.0
    memory: float = 0.0
    tails: bool = False
    read: Fields = field(default_factory=dict)
    _sides: dict[tuple[str, float], Array] = field(default_factory=dict)

    def set_way(self, t: Any, way: Mapping[str, Any], taken: Any) -> None:
        """t: s; way: mm by axis; taken: index of the way points that were read."""
        self.way_t, self.taken = np.asarray(t, float), np.asarray(taken, int)
        self.way = {a: np.asarray(x, float) for a, x in way.items()}
        self.t, self.n = self.way_t[self.taken], len(self.taken)
        for a, x in self.way.items():
            self.pos[a], self.turns[a] = x[self.taken], reversals(self.way_t, x)
            columns = (column[self.taken] for column in self.turns[a][:3])
            self.sense_of[a], self.since_mm[a], self.since_s[a] = columns
            self.vel[a] = self.acc[a] = np.zeros(self.n)
            if self.kind != "targets":
                v = np.gradient(x, self.way_t)
                self.vel[a] = v[self.taken]
                self.acc[a] = np.gradient(v, self.way_t)[self.taken]

    @property
    def channels(self) -> list[str]:
        """Of its readings."""
        of = {"targets": ["reading_um"], "ballbar": ["radial_um"], "features": ["measured"]}
        return of.get(self.kind) or [f"{a}_act" for a in self.way]

    @property
    def sees_tables(self) -> bool:
        """Whether errors of the map show."""
        return self.kind in ("targets", "ballbar") or (self.kind == "trace" and self.sees == "tool")

    def project(self, moved: Mapping[str, Any], servo: bool = False) -> Fields:
        """A deviation, direction -> um, as the instrument's channels see it; parts see none. servo:
        the axis's own scale sees it, too."""
        none = np.zeros(self.n)
        if self.kind == "trace":
            seen = servo or self.sees == "tool"
            return {f"{d}_act": e + none for d, e in moved.items()} if seen else {}
        if self.kind == "features":
            return {}
        weight: Mapping[str, Any] = self.unit if self.kind == "ballbar" else self.sensitive
        seen_of = (weight[d] * e for d, e in moved.items() if d in weight)
        return {self.channels[0]: sum(seen_of, none)}

    def less_zeros(self, y: Array) -> Array:
        """Less what the instrument can not know: its zero, and a ballbar's centre."""
        if self.kind == "features":
            return y
        zeros = np.stack([np.ones(self.n), *self.unit.values()], axis=1)
        return y - zeros @ np.linalg.lstsq(zeros, y, rcond=None)[0]

    def relaxing(self, a: str, target: Callable[[Any], Any], length: float) -> Array:
        """What relaxes to target(sign of the motion) over a travel, mm, after each reversal."""
        sense, since, _, began = self.turns[a]
        y = np.empty(len(sense))
        starts = np.unique(began)
        last = target(sense[starts[0]])
        for i, j in zip(starts, [*starts[1:], len(sense)], strict=True):
            goal = target(sense[i])
            gone = np.minimum(since[i:j], 50 * length) / length
            y[i:j] = goal + (last - goal) * np.exp(-gone)
            last = y[j - 1]
        return y[self.taken]

    def play(self, a: str, size: float, width: float) -> Array:
        """Behind the motion by size / 2, um: a play of a width, mm, that is carried along; linear
        within it."""
        half = width / 2
        x = self.way[a].tolist()
        at = x[0] - self.turns[a][0][0] * half
        y = np.empty(len(x))
        for i, xi in enumerate(x):
            at = min(max(at, xi - half), xi + half)
            y[i] = at - xi
        return (y / half * size / 2)[self.taken]

    def side(self, a: str, lost: float) -> Array:
        """-1 to 1: the side of the play on which the nut lies; crossed over as much travel, um."""
        key = a, round(lost, 4)
        if key not in self._sides:
            at_rest = self.kind == "targets" or lost < 0.05
            self._sides[key] = self.sense_of[a] if at_rest else -self.play(a, 2.0, lost * 1e-3)
        return self._sides[key]


def reversals(t: Array, x: Array) -> tuple[Array, Array, Array, Array]:
    """Of every way point: sign of the motion that led there, travel (mm) and time (s) since its
    reversal, index of the reversal. Before the first motion its sign holds."""
    moved = np.diff(x, prepend=x[0])
    sign = np.sign(np.where(np.abs(moved) < 1e-7, 0, moved))
    index = np.arange(len(x))
    last = np.maximum.accumulate(np.where(sign != 0, index, -1))
    sense = np.where(last >= 0, sign[np.maximum(last, 0)], 0)
    sense = np.where(sense == 0, sense[sense != 0][0] if np.any(sense != 0) else 1.0, sense)
    turned = np.r_[False, np.diff(sense) != 0]
    since = np.maximum.accumulate(np.where(turned, index, -1))
    began = np.maximum(since, 0)
    travel = np.cumsum(np.abs(moved))
    before, t_before = np.r_[0, travel[:-1]], np.r_[t[0], t[:-1]]
    gone = np.where(since >= 0, travel - before[began], travel + LONG_AGO)
    time = np.where(since >= 0, t - t_before[began], t - t[0] + LONG_AGO)
    return sense, gone, time, began
