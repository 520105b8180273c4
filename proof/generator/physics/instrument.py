"""Faults of instruments: light in warm air, a beam aslant, late clocks, sensors whose scale waves.
The machine is well."""

from __future__ import annotations

import numpy as np

from proof.generator.machines import XYZ
from proof.generator.physics import Effect, Scene, Shift, along, dynamic
from proof.generator.streams import log_uniform
from proof.generator.tracks import Track


def refractive(celsius: np.ndarray, hectopascal: np.ndarray) -> np.ndarray:
    """(n - 1) of dry air in ppm, Edlen's equation as modified by Birch and Downs (1993), dispersion
    at 633 nm."""
    standard = 8342.54 + 2406147 / (130 - 2.4966) + 15998 / (38.9 - 2.4966)
    pascal = hectopascal * 100
    value = (
        standard
        * pascal
        / 96095.43
        * (1 + 1e-8 * (0.601 - 0.00972 * celsius) * pascal)
        / (1 + 0.0036610 * celsius)
    )
    return value * 1e-2


def _beam(track: Track) -> np.ndarray:
    """(N,) mm of beam beyond the first target."""
    along_line = track.position @ track.sensitive
    return np.abs(along_line - along_line[0])


def _lasers(scene: Scene, axis: str) -> list[Track]:
    return [t for t in scene.design.tracks if t.laser and abs(t.sensitive[XYZ.index(axis)]) > 0.2]


def _air(scene: Scene, track: Track) -> np.ndarray:
    """(N,) ppm by which a length reads long, since the instrument was set."""
    world = scene.world
    ppm = refractive(world.air, world.pressure)
    return world.at(ppm, track.time) - world.at(ppm, track.time[:1])


def laser_air(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Counts for the air of the first minute while the air changes: every length reads with the
    wrong wavelength."""
    if not _lasers(scene, axis):
        return None
    # ppm: the compensator was told of other air
    wrong = rng.uniform(-4.0, 4.0) if rng.random() < 0.5 else 0.0

    def on(track: Track) -> Shift | None:
        if not track.laser:
            return None
        ends = track.position @ track.sensitive
        sign = 1.0 if ends[np.argmax(_beam(track))] >= ends[0] else -1.0
        return Shift(reading=sign * _beam(track) * 1e-3 * (_air(scene, track) + wrong))

    return Effect("laser_air", _single(scene), on, signed=False, largest=15.0)


def _single(scene: Scene) -> str | None:
    """The axis that alone was measured by laser, or None."""
    moving = {t.moving for t in scene.design.tracks if t.laser}
    only = next(iter(moving)) if len(moving) == 1 else ""
    return only if len(only) == 1 else None


def dead_path(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Beam between interferometer and the place where it was zeroed, not told to the compensator.
    size: 100 mm of it."""
    seen = _lasers(scene, axis)
    if not seen:
        return None
    one = seen[int(rng.integers(len(seen)))]

    def on(track: Track) -> Shift | None:
        return Shift(reading=0.1 * _air(scene, track)) if track is one else None

    return Effect(
        "dead_path", one.moving if len(one.moving) == 1 else None, on, signed=False, largest=40.0
    )


def cosine(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """A beam aslant in one set-up: every displacement reads short. size: ppm."""
    seen = _lasers(scene, axis)
    if not seen:
        return None
    one = seen[int(rng.integers(len(seen)))]

    def on(track: Track) -> Shift | None:
        if track is not one:
            return None
        ends = track.position @ track.sensitive
        slant = np.sqrt(2e-6)
        return Shift(reading=(ends - ends[0]) * (np.cos(slant) - 1) * 1e3)

    return Effect(
        "cosine",
        one.moving if len(one.moving) == 1 else None,
        on,
        lambda size: {"ppm": -size},
        signed=False,
    )


def delay(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """The recorder is late, for all axes alike. size: ms."""
    if not any(t.kind == "trace" for t in scene.design.tracks):
        return None

    def on(track: Track) -> Shift | None:
        return _late(track) if track.kind == "trace" else None

    return Effect("delay", None, on, lambda size: {"delay_ms": size}, signed=False)


def clock_skew(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Commands and readings are stamped by two clocks, one of them fast: later and later. size: ms
    over the file."""
    if not any(t.kind == "trace" for t in scene.design.tracks):
        return None

    def on(track: Track) -> Shift | None:
        if track.kind != "trace":
            return None
        share = (track.time - track.time[0]) / np.ptp(track.time)
        moved = _behind(track) * share[:, None]
        return Shift(tool=moved, scale=moved)

    return Effect("clock_skew", None, on, signed=False)


def _late(track: Track) -> Shift:
    moved = _behind(track)
    return Shift(tool=moved, scale=moved)


def _behind(track: Track) -> np.ndarray:
    """(N, 3) um that a reading is behind for every ms that it is late."""
    moved = np.zeros((len(track.time), 3))
    for x in track.moving:
        speed = dynamic(track, x, lambda dt, p, v: v)
        moved -= along(len(moved), x, 0.0 if speed is None else speed)
    return moved


def encoder_cyclic(scene: Scene, axis: str, rng: np.random.Generator) -> Effect | None:
    """Sine and cosine of a sensor that are not equal: twice and once a signal period, in the log of
    that sensor only."""
    seen = [
        t
        for t in scene.design.tracks
        if t.kind == "trace" and t.head["sees"] == "scale" and axis in t.moving
    ]
    if not seen:
        return None
    period = log_uniform(rng, 0.1, 2.0)
    once, phase = rng.uniform(0.0, 0.3), rng.uniform(0, 2 * np.pi, 2)

    def on(track: Track) -> Shift | None:
        if track not in seen:
            return None
        turn = 2 * np.pi * track.position[:, XYZ.index(axis)] / period
        wave = np.sin(turn + phase[0]) + once * np.sin(2 * turn + phase[1])
        return Shift(scale=along(len(wave), axis, wave))

    return Effect(
        "encoder_cyclic",
        axis,
        on,
        lambda size: {"period_mm": period, "amplitude_um": abs(size)},
        signed=False,
    )


DRAW = {f.__name__: f for f in (laser_air, dead_path, cosine, delay, clock_skew, encoder_cyclic)}
