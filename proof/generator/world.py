"""What goes on while an experiment lasts: room, screws that warm along their length, spindle,
cutting, tool changes.

Screws are rods of nodes that the nut heats where it runs and the bearing at one end; the
thermometer sits at one place. The room swings, walks and is heated at some time. Temperatures in
degrees Celsius, time in s on a grid of STEP.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from proof.generator.designs import Design

STEP = 15.0
NODES = 28
STEEL = 13.0  # mm2/s, thermal diffusivity of steel


@dataclass
class World:
    """design: the experiment; rng: the stream from which the room takes its walk."""

    design: Design
    rng: np.random.Generator

    @cached_property
    def clock(self) -> np.ndarray:
        return np.arange(0.0, self.design.end + 3 * STEP, STEP)

    @cached_property
    def air(self) -> np.ndarray:
        room, t = self.design.room, self.clock
        walk = np.cumsum(self.rng.normal(0, room["walk"] * np.sqrt(STEP / 3600), len(t)))
        swing = room["swing"] * (
            np.sin(2 * np.pi * t / room["period"] + room["phase"]) - np.sin(room["phase"])
        )
        heated = room["heating"] * (
            1 - np.exp(-np.maximum(t - room["heating_at"], 0) / room["heating_tau"])
        )
        return room["start"] + swing + heated + walk

    @cached_property
    def bed(self) -> np.ndarray:
        return delayed(self.air, 7000.0)

    @cached_property
    def pressure(self) -> np.ndarray:
        """hPa, slow weather that nobody writes down."""
        t = self.clock
        return 1013.0 + 2.0 * np.sin(2 * np.pi * t / 50000 + self.design.room["phase"])

    @cached_property
    def nodes(self) -> dict[str, np.ndarray]:
        """Axis to the positions of its screw's nodes, mm."""
        return {x: np.linspace(a.low, a.high, NODES) for x, a in self.design.machine.axes.items()}

    @cached_property
    def screws(self) -> dict[str, np.ndarray]:
        """Axis to (T, NODES) temperatures of its screw."""
        room, t = self.design.room, self.clock
        found = {}
        for x, nodes in self.nodes.items():
            spacing = nodes[1] - nodes[0]
            chain = np.zeros((NODES, NODES))
            for k in range(NODES):
                for m in (k - 1, k + 1):
                    if 0 <= m < NODES:
                        chain[k, m] += STEEL / spacing**2
                        chain[k, k] -= STEEL / spacing**2
            chain -= np.eye(NODES) / room["screw_tau"]
            forward = np.linalg.inv(np.eye(NODES) - STEP * chain)
            power = np.zeros((len(t), NODES))
            for track in self.design.tracks:
                for begun, ended, letter, low, high, speed in track.active:
                    if letter != x or ended <= begun:
                        continue
                    share = np.clip(
                        (np.minimum(ended, t + STEP) - np.maximum(begun, t)) / STEP, 0, 1
                    )
                    under = np.exp(
                        -(np.maximum(np.maximum(low - nodes, nodes - high), 0) ** 2)
                        / (2 * (2 * spacing) ** 2)
                    )
                    where = under + room["bearing"] * np.exp(-(nodes - nodes[0]) / 60.0)
                    power += np.outer(share * min(speed, 40.0) / 20.0, where)
            power *= room["screw_rise"] / room["screw_tau"]
            state = np.full(NODES, self.air[0])
            rows = np.empty((len(t), NODES))
            for k in range(len(t)):
                rows[k] = state
                state = forward @ (state + STEP * (power[k] + self.air[k] / room["screw_tau"]))
            found[x] = rows
        return found

    def sensor(self, axis: str) -> np.ndarray:
        """(T,) what the thermometer of a screw shows: one place of it, late by a minute."""
        share = self.design.room["sensor"]
        return delayed(self.screws[axis][:, int(share * (NODES - 1))], 60.0)

    @cached_property
    def rpm(self) -> np.ndarray:
        value = np.zeros(len(self.clock))
        for track in self.design.tracks:
            for begun, ended, speed in track.spindle:
                value[(self.clock >= begun) & (self.clock < ended)] = speed
        return value

    @cached_property
    def changes(self) -> np.ndarray:
        return np.array(sorted(t for track in self.design.tracks for t in track.changes))

    @cached_property
    def cut(self) -> np.ndarray:
        """(T,) h of cutting since the last change of the tool."""
        cutting = np.cumsum((self.rpm > 0) * STEP / 3600)
        last = np.zeros(len(self.clock))
        for t in self.changes:
            last = np.where(self.clock >= t, np.interp(t, self.clock, cutting), last)
        return cutting - last

    def at(self, series: np.ndarray, t: np.ndarray) -> np.ndarray:
        return np.interp(t, self.clock, series)

    def steps_at(self, series: np.ndarray, t: np.ndarray) -> np.ndarray:
        """A series that jumps, as it stands at t."""
        return series[np.clip((np.asarray(t) // STEP).astype(int), 0, len(series) - 1)]


def delayed(series: np.ndarray, tau: float) -> np.ndarray:
    """A first-order lag on the grid, from rest."""
    share = 1 - np.exp(-STEP / tau)
    result = np.empty(len(series))
    state = series[0]
    for k, value in enumerate(series.tolist()):
        state += share * (value - state)
        result[k] = state
    return result
