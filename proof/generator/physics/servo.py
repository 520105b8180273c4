"""What the drives do: friction in a servo loop, lag, a flexible slide, oscillation. The axis' own
scale sees all of it."""

from __future__ import annotations

import numpy as np

from proof.generator.machines import XYZ
from proof.generator.mechanics import loop_response, lugre, second_order, slip_steps
from proof.generator.physics import Effect, Scene, Shift, along, dynamic, own
from proof.generator.streams import log_uniform
from proof.generator.tracks import Track


def _friction(
    name: str, scene: Scene, axis: str, rng: np.random.Generator, forward: float, reverse: float
) -> Effect:
    """LuGre friction in a position loop with an integral: a burst after every reversal, away by the
    loop's own time."""
    peak, stribeck, bristle = (
        rng.uniform(1.0, 1.6),
        log_uniform(rng, 0.5, 6.0),
        log_uniform(rng, 0.003, 0.02),
    )
    integral, mechanical = log_uniform(rng, 0.012, 0.12), rng.uniform(0.002, 0.006)

    def response(dt, x, v):
        return loop_response(
            dt, lugre(dt, v, forward, reverse, peak, stribeck, bristle), integral, mechanical
        )

    return Effect(
        name,
        axis,
        own(axis, lambda track: dynamic(track, axis, response), scale=True),
        signed=False,
    )


def reversal_spike(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    return _friction("reversal_spike", scene, axis, rng, 1.0, 1.0)


def friction_asymmetry(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """Twice and more the friction in one direction, dry and in the grease. A loop with an integral
    shows it after reversals and stops; one without lags all the time by what is rubbing."""
    ratio = rng.uniform(1.8, 3.5)
    forward, reverse = (1.0, 1 / ratio) if rng.random() < 0.5 else (1 / ratio, 1.0)
    if rng.random() < 0.4:
        return _friction("friction_asymmetry", scene, axis, rng, forward, reverse)
    bristle, mechanical, wet = (
        log_uniform(rng, 0.002, 0.01),
        rng.uniform(0.003, 0.008),
        rng.uniform(0.5, 1.5),
    )

    def response(dt, x, v):
        dry = lugre(dt, v, forward, reverse, 1.1, 2.0, bristle)
        level = np.where(v >= 0, forward, reverse)
        return loop_response(dt, dry + wet * level * v / 60.0, None, mechanical)

    felt = own(axis, lambda track: dynamic(track, axis, response), scale=True)
    return Effect("friction_asymmetry", axis, felt, signed=False)


def coulomb_friction(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """A stiff loop without integral: the table stays behind by friction over stiffness, and the
    motor's current shows it."""
    if not _current(scene, axis):
        return None
    bristle, mechanical = log_uniform(rng, 0.002, 0.01), rng.uniform(0.003, 0.008)

    def force(dt, x, v):
        return lugre(dt, v, 1.0, 1.0, 1.05, 2.0, bristle)

    return _felt("coulomb_friction", axis, force, mechanical, rng.uniform(0.15, 0.4))


def viscous_friction(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Grease: force with speed, a little less than in proportion; the motor's current shows it."""
    if not _current(scene, axis):
        return None
    power, mechanical = rng.uniform(0.92, 1.0), rng.uniform(0.003, 0.008)

    def force(dt, x, v):
        return np.sign(v) * np.abs(v / 50.0) ** power

    return _felt("viscous_friction", axis, force, mechanical, rng.uniform(0.15, 0.4))


def _felt(name, axis, force, mechanical, ampere) -> Effect:
    def on(track: Track) -> Shift | None:
        error = dynamic(
            track, axis, lambda dt, x, v: loop_response(dt, force(dt, x, v), None, mechanical)
        )
        if error is None:
            return None
        pull = dynamic(track, axis, force)
        moved = along(len(error), axis, error)
        return Shift(
            tool=moved,
            scale=moved,
            current={axis: ampere * pull} if track.channels.get("current") else {},
        )

    return Effect(name, axis, on, signed=False)


def _current(scene: Scene, axis: str) -> bool:
    return any(t.channels.get("current") and axis in t.moving for t in scene.design.tracks)


def _lag(rng: np.random.Generator):
    omega, zeta = rng.uniform(60, 250), rng.uniform(0.6, 1.0)
    return lambda dt, x, v: -second_order(dt, v, omega, zeta)


def servo_lag(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A position loop of the second order: it follows a ramp late by tau. size: tau in ms."""
    late = _lag(rng)
    felt = own(axis, lambda track: dynamic(track, axis, late), scale=True)
    return Effect("servo_lag", axis, felt, lambda size: {"tau_ms": size}, signed=False)


def servo_mismatch(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Both loops late, one more than the other. Only circles tell nothing but the difference, so
    only there it is drawn."""
    bars = [t for t in scene.design.tracks if t.kind == "ballbar" and axis in t.moving]
    if not bars or any(t.kind == "trace" for t in scene.design.tracks):
        return None
    pair = bars[0].moving
    late, common = _lag(rng), rng.uniform(0.5, 3.0)

    def on(track: Track) -> Shift | None:
        first, second = (dynamic(track, x, late) for x in pair)
        if first is None or second is None:
            return None
        moved = along(len(first), pair[0], (common + 0.5) * first) + along(
            len(first), pair[1], (common - 0.5) * second
        )
        return Shift(tool=moved, scale=moved)

    return Effect("servo_mismatch", pair, on, lambda size: {"delta_tau_ms": size})


def inertia(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """The slide on the spring of its drive: it stays behind by acceleration over the square of its
    frequency."""
    omega, zeta = 2 * np.pi * rng.uniform(14, 40), rng.uniform(0.08, 0.4)

    def response(dt, x, v):
        return -second_order(dt, np.gradient(v, dt), omega, zeta) * 1e-3

    return Effect(
        "inertia",
        axis,
        own(axis, lambda track: dynamic(track, axis, response), scale=True),
        signed=False,
    )


def vibration(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """A pump or a fan: one frequency, its strength waxing and waning, its phase another in every
    run."""
    frequency = log_uniform(rng, 3.0, 45.0)
    depth, beat = rng.uniform(0.0, 0.25), rng.uniform(0.03, 0.3)
    phases = rng.uniform(0, 2 * np.pi, 64)

    def value(track: Track) -> np.ndarray | None:
        if not track.sweeps:
            return None
        t = track.time
        strength = (1 + depth * np.sin(2 * np.pi * beat * t + phases[0])) / (1 + depth)
        return strength * np.sin(2 * np.pi * frequency * t + phases[track.run % 64])

    return Effect(
        "vibration",
        axis,
        own(axis, value, scale=True),
        lambda size: {"frequency_hz": frequency},
        signed=False,
    )


def stick_slip(scene: Scene, axis: str, rng: np.random.Generator) -> Effect:
    """The slide waits until the drive pulls hard enough, then jumps; not above a certain speed."""
    fastest, slide = rng.uniform(1.0, 4.0), rng.uniform(0.55, 0.75)
    seed = int(rng.integers(1 << 30))

    def value(track: Track) -> np.ndarray | None:
        if not track.sweeps:
            return None
        own_rng = np.random.default_rng([seed, int(track.time[0])])
        found = np.zeros(len(track.time))
        for sweep in track.sweeps:
            # it holds for 6 um whatever the size: that scales the saw-tooth, not its pitch
            x = sweep.position[:, XYZ.index(axis)] * 1000 / 6.0
            v = np.gradient(sweep.position[:, XYZ.index(axis)], sweep.time)
            found[sweep.rows] = slip_steps(x, v, 1.0, slide, fastest, own_rng)[sweep.pick]
        return found

    return Effect("stick_slip", axis, own(axis, value, scale=True), signed=False)


DRAW = {
    f.__name__: f
    for f in (
        reversal_spike,
        friction_asymmetry,
        coulomb_friction,
        viscous_friction,
        servo_lag,
        servo_mismatch,
        inertia,
        vibration,
        stick_slip,
    )
}
