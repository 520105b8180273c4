"""Which other names explain the same readings as well: what the recordings can not decide, nobody
shall be blamed for.

Only names that are as simple as the truth count (a dead travel is no worse explained by sliders
that give way at once, but nobody would say so). The rest of a case is held to be known.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import legval

from proof.generator import oracle, physics
from proof.generator.physics import Effect, Scene, Shift, along, share
from proof.generator.readings import project
from proof.generator.streams import stream
from proof.generator.tracks import Track

NEAR: dict[str, tuple[str, ...]] = {
    "scale": ("cosine", "screw_heat", "laser_air", "squareness"),
    "cosine": ("scale", "screw_heat", "laser_air"),
    "laser_air": ("scale", "cosine", "screw_heat", "pitch_shape"),
    "screw_heat": ("scale", "laser_air", "pitch_shape", "structure_drift"),
    "dead_path": ("structure_drift", "laser_air", "step_loss"),
    "structure_drift": ("dead_path", "spindle_growth", "screw_heat", "step_loss"),
    "spindle_growth": ("structure_drift", "tool_wear"),
    "tool_wear": ("structure_drift", "spindle_growth"),
    "step_loss": ("structure_drift", "force_compliance"),
    "force_compliance": ("step_loss", "structure_drift"),
    "backlash": ("coulomb_friction",),
    "backlash_position": ("backlash", "pitch_shape"),
    "windup": ("backlash",),
    "coulomb_friction": ("backlash",),
    "viscous_friction": ("servo_lag",),
    "friction_asymmetry": ("reversal_spike", "backlash"),
    "reversal_spike": ("friction_asymmetry", "windup"),
    "servo_lag": ("delay", "servo_mismatch", "squareness"),
    "servo_mismatch": ("servo_lag", "squareness"),
    "delay": ("servo_lag",),
    "clock_skew": ("delay",),
    "squareness": ("bow", "scale", "servo_lag"),
    "bow": ("squareness", "sag", "abbe"),
    "sag": ("bow", "abbe"),
    "abbe": ("pitch_shape", "bow"),
    "pitch_shape": ("scale", "abbe", "bow"),
    "inertia": ("servo_lag",),
    "cyclic": (),
    "encoder_cyclic": (),
    "vibration": (),
    "stick_slip": ("reversal_spike",),
    "tool_size": ("backlash",),
}
MOVABLE = {
    "scale",
    "backlash",
    "windup",
    "structure_drift",
    "step_loss",
    "servo_lag",
    "screw_heat",
    "reversal_spike",
    "force_compliance",
}


def found(
    scene: Scene, judge: oracle.Oracle, effect: Effect, rows: oracle.Rows, others: list[oracle.Rows]
) -> tuple[float, list[str]]:
    """The least energy that any alternative leaves, and the alternatives that leave less than a
    tool must see."""
    least, same = np.inf, []
    for name, axis in _candidates(scene, effect):
        shapes, label = _block(scene, name, axis)
        if not shapes:
            continue
        block = [[project(scene.machine, t, on(t)) for t in judge.tracks] for on in shapes]
        left = judge.energies([rows, *others, *block])[0]
        least = min(least, left)
        if left < oracle.VISIBLE:
            same.append(label)
    return least, sorted(set(same))


def _candidates(scene: Scene, effect: Effect) -> list[tuple[str, str]]:
    letters = [x for x in effect.axis or "".join(scene.design.moving) if x in scene.machine.axes]
    found = [(name, x) for name in NEAR.get(effect.name, ()) for x in letters]
    if effect.name in MOVABLE:
        found += [(effect.name, x) for x in scene.design.moving if x != effect.axis]
    return found


def _block(scene: Scene, name: str, axis: str) -> tuple[list[Callable[[Track], Shift | None]], str]:
    """Signals that stand for a name, and how it is written: of shapes that are free any smooth one,
    else two draws."""
    if name == "pitch_shape":
        return [_smooth(scene, axis, axis, k) for k in range(1, 14)], f"{name}:{axis}"
    if name == "bow":
        return [
            _smooth(scene, axis, x, k) for x in scene.machine.axes if x != axis for k in range(2, 5)
        ], f"{name}:{axis}"
    if name == "servo_mismatch":
        pairs = sorted(
            {t.moving for t in scene.design.tracks if t.kind == "ballbar" and axis in t.moving}
        )
        if not pairs:
            return [], ""
        return (
            _block(scene, "servo_lag", next(x for x in pairs[0] if x != axis))[0],
            f"{name}:{pairs[0]}",
        )
    drawn = [physics.names()[name](scene, axis, stream("twin", name, axis, k)) for k in range(2)]
    made = [e for e in drawn if e is not None]
    return [e.on for e in made], f"{name}:{made[0].axis}" if made and made[0].axis else name


def _smooth(scene: Scene, axis: str, along_axis: str, order: int) -> Callable[[Track], Shift]:
    def on(track: Track) -> Shift:
        u = 2 * share(scene, track, axis) - 1
        return Shift(tool=along(len(u), along_axis, legval(u, [0] * order + [1])))

    return on
