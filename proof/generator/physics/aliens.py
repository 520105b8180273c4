"""Physics that no name of the contract stands for. The right answer to these is that something
unknown is there."""

from __future__ import annotations

import numpy as np

from proof.generator.machines import XYZ
from proof.generator.mechanics import second_order
from proof.generator.physics import Effect, Scene, Shift, along, dynamic, own, share
from proof.generator.streams import log_uniform
from proof.generator.tracks import Track
from proof.generator.world import STEP, delayed


def chatter_bursts(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Bursts of oscillation at random times, each with a frequency and a length of its own."""
    seed = int(rng.integers(1 << 30))

    def value(track: Track) -> np.ndarray | None:
        if not track.sweeps:
            return None
        draw = np.random.default_rng([seed, int(track.time[0])])
        t, found = track.time, np.zeros(len(track.time))
        for run in np.unique(track.run):
            here = t[track.run == run]
            for _ in range(draw.poisson(4) + 1):
                begun, lasts = (
                    draw.uniform(here[0], here[-1]),
                    draw.uniform(0.03, 0.12) * np.ptp(here),
                )
                inside = (t > begun) & (t < begun + lasts)
                envelope = np.sin(np.pi * (t - begun) / lasts) ** 2 * draw.uniform(0.4, 1)
                found += inside * envelope * np.sin(2 * np.pi * draw.uniform(9, 60) * (t - begun))
        return found

    return Effect("alien:chatter_bursts", axis, own(axis, value, scale=True))


def coolant_bend(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Coolant that comes and goes, unrecorded, bends the table one way quickly and lets it back
    slowly and not all the way."""
    world = scene.world
    on_for, off_for = rng.uniform(400, 1500), rng.uniform(300, 1200)
    flowing = ((world.clock + rng.uniform(0, 2000)) % (on_for + off_for)) < on_for
    state, set_in, bend = 0.0, 0.0, np.empty(len(flowing))
    for k, wet in enumerate(flowing.tolist()):
        state += STEP / (250.0 if wet else 1500.0) * ((1.0 if wet else 0.0) - state)
        set_in = max(set_in, 0.5 * state)
        bend[k] = max(state, set_in)

    def value(track: Track) -> np.ndarray:
        u = share(scene, track, axis)
        return world.at(bend, track.time) * np.sin(1.3 * np.pi * u) * (1 + u)

    return Effect("alien:coolant_bend", axis, own(axis, value))


def gib_rock(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A loose gib: the slide tips over when the drive changes from pushing to pulling, and comes to
    rest tipped."""
    turn, soft = rng.uniform(50, 400), rng.uniform(15, 60)
    across = str(rng.choice([x for x in scene.machine.axes if x != axis]))
    wave, phase = rng.uniform(25, 90), rng.uniform(0, 6)

    def tipped(dt, x, v):
        push = second_order(dt, np.gradient(v, dt), 2 * np.pi * soft, 0.7)
        return np.tanh(push / turn) * (1 + 0.5 * np.sin(2 * np.pi * x / wave + phase))

    def on(track: Track) -> Shift | None:
        found = dynamic(track, axis, tipped)
        if found is None:
            return None
        return Shift(
            tool=along(len(found), axis, found) + along(len(found), across, -0.6 * np.abs(found))
        )

    return Effect("alien:gib_rock", axis, on)


def interpolation_jumps(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A dirty scale: at some places the interpolation slips by a whole step, and back somewhere
    else."""
    span = scene.machine.axes[axis]
    places = np.sort(
        rng.uniform(
            span.low + 0.05 * span.length, span.high - 0.05 * span.length, int(rng.integers(5, 10))
        )
    )
    jumps = rng.choice([-1.0, 1.0], len(places))

    def value(track: Track) -> np.ndarray:
        x = track.position[:, XYZ.index(axis)]
        return (x[:, None] > places) @ jumps

    return Effect("alien:interpolation_jumps", axis, own(axis, value))


def belt_beat(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A toothed belt and its pulley, whose periods beat, and whose teeth are no sine."""
    tooth, pulley = rng.uniform(3.0, 9.0), rng.uniform(1.06, 1.14)
    phase = rng.uniform(0, 2 * np.pi, 2)

    def value(track: Track) -> np.ndarray:
        x = 2 * np.pi * track.position[:, XYZ.index(axis)] / tooth
        return np.sin(x + phase[0] + 0.9 * np.sin(x)) * np.abs(
            np.sin(x / pulley + phase[1])
        ) - 0.5 * np.cos(x / pulley)

    return Effect("alien:belt_beat", axis, own(axis, value))


def speed_resonance(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Balls of the nut shake the slide: a frequency that follows the speed, strong where it meets
    the frame's own."""
    pitch, frame, sharp = rng.uniform(0.4, 2.5), rng.uniform(12, 40), rng.uniform(0.08, 0.25)

    def shaken(dt, x, v):
        rate = np.abs(v) / pitch
        ratio = rate / frame
        strength = 1 / np.sqrt((1 - ratio**2) ** 2 + (2 * sharp * ratio) ** 2) - 1 / (1 + ratio**2)
        return np.clip(strength, 0, None) * (rate > 0.3 * frame) * np.sin(2 * np.pi * x / pitch)

    return Effect(
        "alien:speed_resonance", axis, own(axis, lambda t: dynamic(t, axis, shaken), scale=True)
    )


def way_cover(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A way cover that jams: over part of the travel it pulls the slide back, more and more, until
    it snaps loose."""
    begun, snap = rng.uniform(0.15, 0.4), rng.uniform(0.12, 0.2)
    only = float(rng.choice([-1.0, 1.0]))

    def value(track: Track) -> np.ndarray:
        u = share(scene, track, axis) - begun
        inside = (u > 0) & (u < 2.6 * snap) & (track.direction[:, XYZ.index(axis)] == only)
        return -only * inside * (u % snap) / snap

    return Effect("alien:way_cover", axis, own(axis, value))


def tide_tilt(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """The foundation tilts to and fro in an hour or two, and the frame with it: more, the farther
    the slide is out."""
    world, period = scene.world, rng.uniform(2000, 6000)
    across = str(rng.choice([x for x in scene.machine.axes if x != axis]))
    turn = 2 * np.pi * world.clock / period
    tilt = delayed(np.sin(turn + rng.uniform(0, 6)) + 0.4 * np.sin(turn / 0.37), 120.0)

    def on(track: Track) -> Shift:
        now = world.at(tilt, track.time)
        u, w = share(scene, track, axis), share(scene, track, across)
        return Shift(
            tool=along(len(now), axis, now * (2 * u - 1 + 0.5 * w))
            + along(len(now), across, -now * (2 * u - 1))
        )

    return Effect("alien:tide_tilt", axis, on)


def speed_product(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """An error with the product of two axes' speeds: none where only one moves."""
    pair = "XY" if scene.machine.form == "mill" else "XZ"
    soft = rng.uniform(0.5, 3.0)

    def on(track: Track) -> Shift | None:
        first, second = (dynamic(track, x, lambda dt, p, v: v) for x in pair)
        if first is None or second is None or not set(pair) <= set(track.moving):
            return None
        product = first * second / (soft + np.hypot(first, second))
        return Shift(tool=along(len(product), axis, product))

    return Effect("alien:speed_product", axis, on)


def crossed_wave(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A grid plate that was ruled with a wave across it: periodic in a mixture of both axes, not in
    one of them."""
    machine = scene.machine
    other = str(rng.choice([x for x in machine.axes if x != axis]))
    period, mix, phase = log_uniform(rng, 18, 70), rng.uniform(0.7, 1.4), rng.uniform(0, 6)

    def value(track: Track) -> np.ndarray:
        x, y = track.position[:, XYZ.index(axis)], track.position[:, XYZ.index(other)]
        return np.sin(2 * np.pi * (x + mix * y) / period + phase) * np.cos(
            2 * np.pi * (x - mix * y) / (2.7 * period)
        )

    return Effect("alien:crossed_wave", axis, own(axis, value))


DRAW = {
    f.__name__: f
    for f in (
        chatter_bursts,
        coolant_bend,
        gib_rock,
        interpolation_jumps,
        belt_beat,
        speed_resonance,
        way_cover,
        tide_tilt,
        speed_product,
        crossed_wave,
    )
}
