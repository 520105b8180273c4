"""A recording: the whole commanded state of every reading, and what its instrument sees of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .base import LONG_AGO, Array, Fields

STATE = {  # what is not set
    "sense_of": 0.0,
    "vel": 0.0,
    "acc": 0.0,
    "since_mm": LONG_AGO,
    "since_s": LONG_AGO,
    "path": 0.0,
}


@dataclass(eq=False)
class Recording:
    """kind: targets, ballbar, trace or features (the contract's). By axis, one value a reading:
    pos, mm; sense_of, the sign of the last motion; since_mm, since_s, travel and time since the
    reversal; vel, mm/s; acc, mm/s2; path, mm travelled before. sees: a trace's end, scale or tool.
    sensitive: a targets' direction. plane, radius (mm), unit, sense: a ballbar's. moving, rate
    (Hz), current (A): a trace's. parts: columns of features. step: um, of the readings."""

    name: str
    kind: str
    axes: list[str]
    t: Array = field(default_factory=lambda: np.zeros(0))
    run: Array = field(default_factory=lambda: np.zeros(0))
    sees: str = ""
    step: float = 0.0
    head: dict[str, Any] = field(default_factory=dict)
    pos: dict[str, Any] = field(default_factory=dict)
    sense_of: dict[str, Any] = field(default_factory=dict)
    vel: dict[str, Any] = field(default_factory=dict)
    acc: dict[str, Any] = field(default_factory=dict)
    since_mm: dict[str, Any] = field(default_factory=dict)
    since_s: dict[str, Any] = field(default_factory=dict)
    path: dict[str, Any] = field(default_factory=dict)
    more: dict[str, Array] = field(default_factory=dict)  # further columns of the file
    sensitive: dict[str, float] = field(default_factory=dict)
    plane: list[str] = field(default_factory=list)
    radius: float = 0.0
    unit: Fields = field(default_factory=dict)
    sense: Array = field(default_factory=lambda: np.zeros(0))
    moving: list[str] = field(default_factory=list)
    rate: float | None = None
    current: Fields = field(default_factory=dict)
    force: Fields = field(default_factory=dict)
    rpm: Array = field(default_factory=lambda: np.zeros(0))
    parts: dict[str, Any] = field(default_factory=dict)
    turned: bool = False
    t_written: Array | None = None  # by a clock that goes wrong

    def finish(self, machine: str, n: int) -> None:
        """Give every axis a value at each of n readings."""
        self.n = n
        # before what the plan has put into the head
        self.head = {
            "format": "gcomp-recording/1",
            "kind": self.kind,
            "machine": machine,
            **self.head,
        }
        for a in self.axes:
            self.pos[a] = _spread(self.pos[a], n)
            for name, default in STATE.items():
                by_axis = getattr(self, name)
                by_axis[a] = _spread(by_axis.get(a, default), n)

    @property
    def channels(self) -> list[str]:
        return list(self.axes) if self.kind == "trace" else ["r"]

    @property
    def sees_tables(self) -> bool:
        return self.kind in ("targets", "ballbar") or (self.kind == "trace" and self.sees == "tool")

    @property
    def sample_rate(self) -> float:
        """Hz, at the median of the readings."""
        return self.rate if self.rate is not None else 1 / np.median(np.diff(self.t))

    def project(self, moved: Mapping[str, Any]) -> Fields:
        """A deviation, direction -> um, as the instrument's channels see it; parts see none."""
        if self.kind == "trace":
            return {a: _spread(e, self.n) for a, e in moved.items()}
        weight: Mapping[str, Any] = self.unit if self.kind == "ballbar" else self.sensitive
        parts = (weight[a] * np.asarray(e) for a, e in moved.items() if a in weight)
        return {"r": sum(parts, np.zeros(self.n))}

    def zeros(self) -> list[Array]:
        """What the instrument can not know: its zero, and a ballbar's centre."""
        if self.kind == "features":
            return []
        return [np.ones(self.n), *(self.unit[a] for a in self.plane)]


def _spread(value: Any, n: int) -> Array:
    return np.broadcast_to(np.asarray(value, float), (n,)).copy()


def reversals(t: Array, x: Array) -> tuple[Array, Array, Array]:
    """Sign of the motion, travel (mm) and time (s) since the reversal, of a sampled path."""
    n = len(x)
    v = np.gradient(x, t)
    fastest = max(abs(v).max(), 1e-12)
    signs = np.sign(np.where(abs(v) < 1e-6 * fastest + 1e-12, 0, v))
    moved = np.where(signs != 0, np.arange(n), -1)
    last = np.maximum.accumulate(moved)
    held = np.where(last >= 0, signs[np.maximum(last, 0)], 0)
    change = np.flatnonzero(np.diff(held)) + 1
    since = np.zeros(n, int)
    since[change] = change
    since = np.maximum.accumulate(since)
    first = since == 0
    travel = np.where(first, LONG_AGO, abs(x - x[since]))
    return held, travel, np.where(first, LONG_AGO, t - t[since])


def state(t: Array, x: Array) -> list[Array]:
    """A path's place, reversals, speed and acceleration, in the order of `set_state`."""
    v = np.gradient(x, t)
    return [x, *reversals(t, x), v, np.gradient(v, t)]


def set_state(rec: Recording, a: str, columns: list[Array]) -> None:
    rec.pos[a], rec.sense_of[a], rec.since_mm[a], rec.since_s[a], rec.vel[a], rec.acc[a] = columns


def round_to(y: Array, step: float) -> Array:
    return np.round(y / step) * step
