"""A case: a machine, a test of it, and the room around both."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rng, log_uniform, pick
from .machines import Machine
from .noise import Noise, wander
from .recordings import Recording


class Room:
    """The air of the room, degrees C, as a function of time, s (ISO 230-3: environment)."""

    def __init__(self, r: Rng, span: float, swing: float, conditioned: bool = False) -> None:
        """span: s; swing: K, slow and random; conditioned: with an air conditioner's cycles."""
        t = np.linspace(0, span * 1.02 + 60, 2000)
        offset = r.normal() * 0.4
        period = log_uniform(r, 0.6, 2.0) * max(span, 1800)
        waves = swing * np.sin(2 * np.pi * t / period + r.uniform(0, 6.28))
        waves = waves + 0.35 * swing * wander(r, t, 1.0, 0.15 * span + 300)
        if conditioned:
            waves = waves + 0.3 * swing * np.sin(2 * np.pi * t / r.uniform(500, 1200))
        self.t, self.dt, self.values = t, t[1], 20 + offset + waves
        # The weather's pressure was once drawn here: what is drawn later keeps its place.
        r.normal(size=2)
        wander(r, t, 1, span / 3 + 1)

    def air(self, t: Array | float) -> Any:
        return np.interp(t, self.t, self.values)

    def lag(self, t: Array | float, tau: float) -> Any:
        """What follows the air with a time constant, s."""
        p = np.exp(-self.dt / tau)
        y = lfilter([1 - p], [1, -p], self.values, zi=[p * self.values[0]])[0]
        return np.interp(t, self.t, y)


class Case:
    """plan: name of the test; axis, other: the axes that it is about, and their pair; peak: um,
    that a hidden effect shall reach; resting: on which side an axis stands that is not moved."""

    room: Room
    noises: list[Noise]

    def __init__(self, r: Rng, plan: str, need: dict[str, float]) -> None:
        """need: what the machine must have, as `Machine` takes it."""
        self.plan = plan
        self.machine = Machine(r, **need)  # type: ignore[arg-type]
        self.resting = {a: int(pick(r, [1, -1])) for a in self.machine.axes}
        self.recs: list[Recording] = []
        self.axis = self.other = self.pair = ""
        self.peak, self.bed_tau = 0.0, 0.0
        self.wrong_rows: tuple[str, list[int]] = ("", [])

    def extent(self, a: str) -> tuple[float, float]:
        """mm: where the test goes."""
        low = min(rec.pos[a].min() for rec in self.recs)
        return low, max(max(rec.pos[a].max() for rec in self.recs), low + 1e-9)

    def place(self, rec: Recording, a: str) -> Array:
        """-1 to 1 over the test's extent."""
        low, high = self.extent(a)
        return 2 * (rec.pos[a] - low) / (high - low) - 1

    def share(self, rec: Recording, a: str) -> Array:
        """0 to 1 over the test's extent."""
        return (self.place(rec, a) + 1) / 2

    @property
    def span(self) -> float:
        """s."""
        return max(rec.t.max() for rec in self.recs)

    def add(self, rec: Recording, n: int) -> None:
        rec.finish(self.machine.name, n)
        self.recs.append(rec)

    def add_room(
        self, r: Rng, swing: float = 0.1, conditioned: bool = False, noted: float = 0.6
    ) -> None:
        """The room's air, and, with a probability, thermometers in recordings at rest."""
        self.room = Room(r, max(self.span, 60), swing, conditioned)
        self.bed_tau = log_uniform(r, 1500, 9000)
        for rec in self.recs:
            if rec.kind != "targets":
                continue
            for name, odds in (("T_air_C", noted), ("T_bed_C", noted * 0.5)):
                if r.random() < odds:
                    air = name == "T_air_C"
                    true = self.room.air(rec.t) if air else self.room.lag(rec.t, self.bed_tau)
                    rec.more[name] = true + r.normal() * 0.05 + r.normal(0, 0.02, rec.n)


def planes(m: Machine) -> list[tuple[str, str]]:
    return [(a, b) for i, a in enumerate(m.axes) for b in m.axes[i + 1 :]]


def somewhere(r: Rng, m: Machine) -> dict[str, float]:
    """mm: a place in the middle eight tenths of every travel."""
    found = {}
    for a in m.axes:
        low, high = m.travel[a]
        inner = low + 0.1 * (high - low), high - 0.1 * (high - low)
        found[a] = float(np.round(r.uniform(*inner)))
    return found


def duration(distance: Array | float, feed: float, acceleration: float) -> Array:
    """s, of a move: mm, mm/min, mm/s2; a trapezoid of speed, or a triangle."""
    v = feed / 60
    short = 2 * np.sqrt(np.maximum(distance, 0) / acceleration)
    return np.where(distance > v * v / acceleration, distance / v + v / acceleration, short)
