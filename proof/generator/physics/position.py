"""What depends on where the slides stand: pitch, waves, leaning axes, bent rails, arms, sagging
beams."""

from __future__ import annotations

import numpy as np

from proof.generator.machines import ABC, XYZ
from proof.generator.physics import Effect, Scene, Shift, along, own, share
from proof.generator.tracks import Track


def _at(track: Track, axis: str) -> np.ndarray:
    return track.position[:, XYZ.index(axis)]


def scale(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A scale that is too long. size: ppm."""
    span = scene.machine.axes[axis]
    fixed = span.low + rng.uniform(0, 1) * span.length
    return Effect(
        "scale",
        axis,
        own(axis, lambda t: (_at(t, axis) - fixed) * 1e-3),
        lambda size: {"ppm": size},
    )


def pitch_shape(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A worn or bent screw: a step that is washed out, a bump, or an arch that leans."""
    form = rng.choice(["step", "bump", "arch"])
    centre, width = rng.uniform(0.25, 0.75), rng.uniform(0.08, 0.2)
    lean = rng.uniform(-0.4, 0.4)

    def value(track: Track) -> np.ndarray:
        u = share(scene, track, axis)
        if form == "step":
            return np.tanh((u - centre) / width) - (u - 0.5) * 1.2
        if form == "bump":
            return np.exp(-(np.abs((u - centre) / (1.5 * width)) ** 2.5))
        return np.sin(np.pi * u ** np.exp(lean))

    return Effect("pitch_shape", axis, own(axis, value))


def cyclic(scene: Scene, axis: str, rng: np.random.Generator, lead: float | None = None) -> Effect:
    """A screw whose bearing wobbles: once a turn, a little twice a turn, more where the nut is far
    from the bearing; with a given lead exactly alike in every turn."""
    part = float(rng.choice([1.0, 0.5, 2.0], p=[0.7, 0.15, 0.15]))
    second, grow, phase = (
        rng.uniform(0, 0.25),
        rng.uniform(-0.15, 0.15),
        rng.uniform(0, 2 * np.pi, 2),
    )
    period = scene.machine.axes[axis].screw_lead * part
    if lead is not None:
        period, grow = lead, 0.0

    def value(track: Track) -> np.ndarray:
        turn = 2 * np.pi * _at(track, axis) / period
        waves = np.sin(turn + phase[0]) + second * np.sin(2 * turn + phase[1])
        return waves * (1 + grow * (2 * share(scene, track, axis) - 1))

    return Effect(
        "cyclic",
        axis,
        own(axis, value),
        lambda size: {"period_mm": period, "amplitude_um": abs(size)},
        signed=False,
    )


def squareness(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """An axis that leans against another. size: urad of the rotation in its name; written under the
    pair, as by how much the angle between the two is more than a right one: a turn about Y closes
    the angle of Z with X, all others named here open it."""
    machine = scene.machine
    pairs = (
        {"C0Y": "XY", "B0Z": "XZ", "A0Z": "YZ"}
        if "Y" in machine.axes
        else {next(iter(machine.square)): "XZ"}
    )
    name = str(rng.choice([n for n, pair in pairs.items() if axis in pair] or [""]))
    if not name:
        return None

    def on(track: Track) -> Shift:
        return Shift(tool=machine.lean(name, track.position))

    opens = -1.0 if name == "B0Z" else 1.0
    return Effect("squareness", pairs[name], on, lambda size: {"urad": opens * size})


def bow(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A rail bent by its own weight, or clamped at both ends: sideways or up, no line in it."""
    across = str(rng.choice([x for x in scene.machine.axes if x != axis]))
    form = rng.choice(["free", "clamped", "end"])

    def on(track: Track) -> Shift:
        u = share(scene, track, axis)
        if form == "free":
            shape = (u - 2 * u**3 + u**4) * 3.2
        elif form == "clamped":
            shape = 16 * u**2 * (1 - u) ** 2
        else:
            shape = u**2 * (3 - u) / 2 - 0.75 * u
        return Shift(tool=along(len(u), across, shape))

    return Effect("bow", axis, on)


def abbe(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """An arm that is longer than the map believes, times the rotation that the map holds. size: mm
    of arm."""
    machine = scene.machine
    turning = [
        c
        for c in machine.components()
        if c[1] in ABC and c[2] == axis and ABC.index(c[1]) != XYZ.index(axis)
    ]
    if not turning:
        return None
    component = str(rng.choice(turning))
    a, x = ABC.index(component[1]), XYZ.index(axis)
    lever = np.zeros(3)
    lever[3 - a - x] = 1.0  # the arm that turns the rotation into an error along the axis

    def on(track: Track) -> Shift:
        rotation = machine.column(component, track.position[:, x], track.direction[:, x])
        rotation = rotation + machine.errors[component] @ machine.waves(axis, track.position[:, x])
        turn = np.zeros((len(rotation), 3))
        turn[:, a] = rotation * 1e-3
        return Shift(tool=np.cross(turn, lever))

    return Effect("abbe", axis, on, lambda size: {"arm_mm": size}, largest=900.0)


def sag(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A beam on two supports: the slide on it is lowered by the mass of another slide (axis), by
    the beam's own rule."""
    machine = scene.machine
    other = str(rng.choice([x for x in machine.axes if x != axis]))
    down = str(rng.choice([x for x in machine.axes if x != axis]))
    reach = rng.uniform(0.05, 0.2)

    def on(track: Track) -> Shift:
        a = np.clip(reach + (1 - 2 * reach) * share(scene, track, axis), 0, 1)
        s = np.clip(reach + (1 - 2 * reach) * share(scene, track, other), 0, 1)
        low, high = np.minimum(s, a), np.maximum(s, a)
        # Euler-Bernoulli, load at a, looked at in s
        shape = low * (1 - high) * (2 * high - high**2 - low**2)
        return Shift(tool=along(len(a), down, -6 * shape))

    return Effect("sag", axis, on, signed=False)


DRAW = {f.__name__: f for f in (scale, pitch_shape, cyclic, squareness, bow, abbe, sag)}
