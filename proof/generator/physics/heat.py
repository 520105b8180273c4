"""Heat and time: screws that grow where they are warm, frames that follow the room, spindles that
push."""

from __future__ import annotations

import numpy as np

from proof.generator.machines import XYZ
from proof.generator.physics import Effect, Scene, own
from proof.generator.tracks import Track
from proof.generator.world import STEP, delayed


def screw_heat(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """The screw's own growth between the fixed bearing and the nut, from the temperatures of its
    nodes. size: ppm/K."""
    world = scene.world
    nodes, heat = world.nodes[axis], world.screws[axis]
    fixed = 0 if rng.random() < 0.7 else len(nodes) - 1
    spacing = nodes[1] - nodes[0]

    def value(track: Track) -> np.ndarray:
        k = np.clip(track.time / STEP, 0, len(heat) - 1.001)
        low = k.astype(int)
        rise = heat - heat[0]
        grown = np.cumsum((rise[:, 1:] + rise[:, :-1]) / 2 * spacing, axis=1) * 1e-3
        grown = np.c_[np.zeros(len(heat)), grown]
        grown -= grown[:, [fixed]]
        where = np.clip(
            (track.position[:, XYZ.index(axis)] - nodes[0]) / spacing, 0, len(nodes) - 1.001
        )
        left = where.astype(int)
        f, g = where - left, k - low

        def corner(i, j):
            return grown[low + i, left + j]

        return (1 - g) * ((1 - f) * corner(0, 0) + f * corner(0, 1)) + g * (
            (1 - f) * corner(1, 0) + f * corner(1, 1)
        )

    return Effect(
        "screw_heat",
        axis,
        own(axis, value),
        lambda size: {"alpha_ppm_K": size},
        signed=False,
        largest=45.0,
    )


def structure_drift(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Two bodies of the frame follow the room, one soon and one late, or the machine warms from
    switching on."""
    world = scene.world
    fast, slow, part = rng.uniform(900, 2400), rng.uniform(5000, 14000), rng.uniform(0.3, 0.7)
    driver = world.air - world.air[0]
    if rng.random() < 0.4 or np.ptp(driver) < 0.8:
        driver = np.full(len(world.clock), 1.0)
        driver[0] = 0.0
    drift = part * delayed(driver, fast) + (1 - part) * delayed(driver, slow)
    drift = drift / max(np.ptp(drift), 1e-9)
    return Effect("structure_drift", axis, own(axis, lambda track: world.at(drift, track.time)))


def spindle_growth(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Bearings warm with speed, the housing with the bearings; both push the spindle out."""
    world = scene.world
    if not any(t.spindle for t in scene.design.tracks if t.kind == "targets"):
        return None
    bearing = delayed((world.rpm / 3000.0) ** 1.4, rng.uniform(250, 700))
    housing = delayed(bearing, rng.uniform(2000, 5000))
    grown = rng.uniform(0.4, 0.7) * bearing + rng.uniform(0.3, 0.6) * housing
    return Effect("spindle_growth", axis, own(axis, lambda track: world.at(grown, track.time)))


DRAW = {f.__name__: f for f in (screw_heat, structure_drift, spindle_growth)}
