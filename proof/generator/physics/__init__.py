"""Effects by the names of the contract, each a family in a module here. None knows another, none
knows the tool.

A family module has DRAW: effect name to a function (scene, axis, rng) -> Effect or None where the
experiment can not show it. An Effect has a size of one; what its truth is worth in um follows from
the peak that was asked for.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from proof.generator.designs import Design
from proof.generator.machines import XYZ
from proof.generator.tracks import Track
from proof.generator.world import World


@dataclass
class Shift:
    """What an effect does to one track; all optional. tool (N, 3) um of the tool against the work;
    scale (N, 3) um that the axes' own scales see of it; reading (rows,) um or urad that the
    instrument adds; turn (N, 3) urad; current: axis to (N,) A."""

    tool: np.ndarray | None = None
    scale: np.ndarray | None = None
    reading: np.ndarray | None = None
    turn: np.ndarray | None = None
    current: dict[str, np.ndarray] = field(default_factory=dict)

    def times(self, size: float) -> Shift:
        tool, scale, reading, turn = (
            None if v is None else v * size
            for v in (self.tool, self.scale, self.reading, self.turn)
        )
        return Shift(tool, scale, reading, turn, {x: v * size for x, v in self.current.items()})


@dataclass
class Effect:
    """on: track to Shift for a size of one; parameters: size to the parameters that have a meaning
    for others too; gap: of lost motion, its dead travel for a size of one at positions (N,) mm of
    the axis, for who must follow the slide through it."""

    name: str
    axis: str | None
    on: Callable[[Track], Shift | None]
    parameters: Callable[[float], dict[str, float]] = lambda size: {}
    signed: bool = True  # whether a negative size makes sense
    largest: float = np.inf  # size beyond which it is no longer this effect
    gap: Callable[[np.ndarray], np.ndarray] | None = None


@dataclass
class Scene:
    """What an effect may look at when it is drawn."""

    design: Design
    world: World

    @property
    def machine(self):
        return self.design.machine


def along(n: int, axis: str, value: np.ndarray | float) -> np.ndarray:
    result = np.zeros((n, 3))
    result[:, XYZ.index(axis)] = value
    return result


def own(
    axis: str, value: Callable[[Track], np.ndarray | None], scale: bool = False
) -> Callable[[Track], Shift | None]:
    """An effect along its own axis; scale: the axis' scale sees it too."""

    def on(track: Track) -> Shift | None:
        found = value(track)
        if found is None:
            return None
        moved = along(len(found), axis, found)
        return Shift(tool=moved, scale=moved if scale else None)

    return on


def history(track: Track, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """All positions (M,) of an axis in order, also between the rows, and where the rows are among
    them."""
    i = XYZ.index(axis)
    if track.kind == "targets":
        return track.way[:, i], track.stop
    if track.kind == "features":  # every point approached from 20 mm away
        near = track.position[:, i]
        before = near - 20.0 * track.direction[:, i]
        return np.c_[before, near].ravel(), 1 + 2 * np.arange(len(near))
    begun, ways, picks = 0, [], []
    for sweep in track.sweeps:
        ways.append(sweep.position[:, i])
        picks.append(begun + sweep.pick)
        begun += len(sweep.time)
    return np.concatenate(ways), np.concatenate(picks)


def dynamic(
    track: Track, axis: str, response: Callable[[float, np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray | None:
    """(N,) of response(dt, position, speed) on the fine grid of each sweep; None for a track at
    rest."""
    if not track.sweeps:
        return None
    i = XYZ.index(axis)
    found = np.zeros(len(track.time))
    known: dict[bytes, np.ndarray] = {}
    for sweep in track.sweeps:
        dt = float(sweep.time[1] - sweep.time[0])
        x = sweep.position[:, i]
        key = np.round(x[:: max(1, len(x) // 50)], 6).tobytes()
        if key not in known:  # a run that repeats another moves alike
            known[key] = response(dt, x, np.gradient(x, dt))[sweep.pick]
        found[sweep.rows] = known[key]
    return found


def share(scene: Scene, track: Track, axis: str) -> np.ndarray:
    """(N,) position over the travel, 0 to 1."""
    span = scene.machine.axes[axis]
    return (track.position[:, XYZ.index(axis)] - span.low) / span.length


def names() -> dict[str, Callable]:
    """Every effect of the modules here, by name."""
    found: dict[str, Callable] = {}
    for module in pkgutil.iter_modules(__path__):
        if module.name != "aliens":
            found |= importlib.import_module(f"{__name__}.{module.name}").DRAW
    return found


def unnamed() -> dict[str, Callable]:
    """Physics that no contract names."""
    return dict(importlib.import_module(f"{__name__}.aliens").DRAW)
