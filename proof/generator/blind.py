"""Tests that can not show what is hidden, or not tell it from something else; and the follow-up
that can."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from proof.generator import designs, tracks
from proof.generator.designs import Design
from proof.generator.machines import XYZ, Machine
from proof.generator.physics import Effect, Scene, Shift, position, reversal, servo, share
from proof.generator.tracks import Track

SPOTS = ("lead_multiples", "one_direction", "one_arm", "one_sense")


@dataclass
class Spot:
    """design: first the blind files, then `later` follow-up files; hidden: names to draw; suspects:
    what the blind spot is about, whatever is hidden; test: what has to be asked for."""

    name: str
    design: Design
    later: int
    hidden: dict[str, Callable]
    axis: str
    suspects: list[str]
    test: str


def draw(rng: np.random.Generator, machine: Machine) -> Spot:
    """One of SPOTS on the machine. The map keeps no rotation where the arm is the question."""
    spot = str(rng.choice(SPOTS))
    axis = str(rng.choice(list(machine.axes)))
    if spot == "one_arm":
        axis = "Z" if machine.form != "mill" else str(rng.choice(["X", "Y"]))
    if spot == "one_sense":
        axis = "X"
    base = designs.draw(rng, machine)
    design = replace(base, tracks=[])
    if spot == "lead_multiples":
        lead = float(rng.choice([5.0, 10.0]))
        first = designs.axis_line(
            rng, machine, axis, axis, 0.0, base.channels, how="round", both=True
        )
        span = machine.axes[axis]
        count = int(min(40, 0.9 * span.length / 7.3))
        second = _pitched(rng, machine, axis, first, 7.3, count)

        def hidden(scene, x, r):
            return position.cyclic(scene, axis, r, lead=lead)

        return Spot(
            spot,
            replace(design, tracks=[first, second]),
            1,
            {"cyclic": hidden},
            axis,
            [f"cyclic:{axis}"],
            "targets that are no multiples of the lead, over two leads",
        )
    if spot == "one_direction":
        first = designs.axis_line(rng, machine, axis, axis, 0.0, base.channels, both=False)
        second = designs.axis_line(
            rng, machine, axis, axis, first.end + 900, base.channels, both=True
        )
        names = {n: reversal.DRAW[n] for n in ("backlash", "backlash_position", "windup")}
        return Spot(
            spot,
            replace(design, tracks=[first, second]),
            1,
            names,
            axis,
            [f"{n}:{axis}" for n in names],
            "the same targets from both directions",
        )
    if spot == "one_arm":
        first = designs.axis_line(
            rng, machine, axis, axis, 0.0, base.channels, both=True, two=False
        )
        second = designs.axis_line(
            rng, machine, axis, axis, first.end + 900, base.channels, both=True, two=True
        )
        turn = unmeasured_turn(machine, axis, rng)
        return Spot(
            spot,
            replace(design, tracks=[first, second]),
            1,
            {"abbe": turn},
            axis,
            [f"abbe:{axis}", f"pitch_shape:{axis}"],
            "the same line at a second arm",
        )
    plane = "XY" if machine.form == "mill" else "XZ"
    feed = float(rng.choice([1500.0, 2000.0]))
    seen = designs.ballbars(rng, machine, plane, [1, 1], [feed], 0.0, count=720)
    more = designs.ballbars(
        rng, machine, plane, [1, -1, 1, -1], [500.0, 3000.0], seen[-1].end + 900, count=720
    )
    pair: dict[str, Callable] = {
        "squareness": position.squareness,
        "servo_mismatch": servo.servo_mismatch,
    }
    return Spot(
        spot,
        replace(design, tracks=[*seen, *more]),
        2,
        pair,
        "X",
        [f"squareness:{plane}", f"servo_mismatch:{plane}"],
        "the circle in both senses and at two feeds",
    )


def _pitched(rng, machine: Machine, axis: str, track: Track, pitch: float, count: int) -> Track:
    """The same set-up with targets at a pitch of their own."""
    span = machine.axes[axis]
    line = np.zeros((count, 3))
    line[:, XYZ.index(axis)] = np.round(span.share(0.04) + pitch * np.arange(count), 3)
    made = tracks.targets(
        rng,
        machine,
        track.head,
        line,
        [{x: machine.axes[x].share(0.5) for x in machine.axes if x != axis}],
        runs=3,
        feed=2000.0,
        start=track.end + 900,
        dwell=(3.5, 5.5),
        gap=(150, 300),
        both=True,
        over=3.0,
        strokes=False,
        loads=[0.0] * 3,
        sensitive=track.sensitive,
    )
    made.noise, made.channels = track.noise, track.channels
    return made


def unmeasured_turn(machine: Machine, axis: str, rng: np.random.Generator) -> Callable:
    """A rotation that nobody measured, with the arm at which the other axes stand. Named abbe."""

    def draw_one(scene: Scene, _axis: str, inner: np.random.Generator) -> Effect:
        others = [x for x in scene.machine.axes if x != axis]
        arm = others[0] if len(others) == 1 else str(inner.choice(others))
        place = scene.machine.axes[arm]
        zero = place.low - 0.2 * place.length
        centre, width, lean = (
            inner.uniform(0.3, 0.7),
            inner.uniform(0.15, 0.3),
            inner.uniform(-1, 1),
        )

        def on(track: Track) -> Shift:
            u = share(scene, track, axis)
            turn = np.tanh((u - centre) / width) + 0.4 * np.sin(2 * np.pi * u + 3 * lean)
            found = np.zeros((len(u), 3))
            found[:, XYZ.index(axis)] = turn * (track.position[:, XYZ.index(arm)] - zero) * 1e-3
            rotation = np.zeros((len(u), 3))
            about = 3 - XYZ.index(axis) - XYZ.index(arm)
            sign = np.cross(np.eye(3)[about], np.eye(3)[XYZ.index(arm)])[XYZ.index(axis)]
            rotation[:, about] = sign * turn
            return Shift(tool=found, turn=rotation)

        return Effect("abbe", axis, on)

    return draw_one
