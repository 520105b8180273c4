"""The effects of the contract of answers, and the forms that each has in workshops."""

from __future__ import annotations

from collections.abc import Callable

from . import geometry, instruments, reversal, servo, slow, waves
from .case import Case, Hidden

Build = Callable[[Case, str], Hidden]

# The order is part of a seed's cases.
FORMS: dict[Build, list[str]] = {
    geometry.scale: [
        "wrong steps/mm",
        "screw warmer than 20 C",
        "wrong steps/mm in parts",
        "one axis stretched, ballbar",
    ],
    geometry.pitch_shape: [
        "worn screw in the middle third",
        "stretched between fixed bearings (parabola)",
        "S curve of a rolled screw",
        "ground in two settings (kink)",
    ],
    reversal.backlash: [
        "dead play of the nut",
        "reached after 0.05 mm pre-sliding",
        "ballbar steps",
        "play with 6 % scatter per reversal",
    ],
    reversal.backlash_position: [
        "nut play where the screw is worn",
        "grows toward the chuck end",
        "rack with one loose segment",
    ],
    reversal.windup: [
        "Dahl pre-sliding of box ways, 1 mm",
        "long screw winds up (exponential, mm)",
        "belt stretch, linear then slips",
    ],
    reversal.reversal_spike: [
        "quadrant glitch, dies with arc length",
        "late glitch in time (integrator catches up)",
        "two-sided glitch (overshoot)",
    ],
    waves.stick_slip: ["regular saw-tooth", "irregular steps"],
    servo.friction_asymmetry: [
        "wiper pulls more one way (Coulomb)",
        "viscous, differs with direction",
    ],
    servo.viscous_friction: ["thick grease", "grease gets thinner while it works"],
    servo.coulomb_friction: ["dry, constant", "with Stribeck rise at low speed"],
    servo.servo_lag: ["first order loop (Kv)", "pure v tau (partial feed-forward)"],
    servo.servo_mismatch: ["pure delay difference", "first order loops of different Kv"],
    servo.inertia: [
        "acceleration times mass over stiffness",
        "acceleration seen through the loop's filter",
    ],
    waves.vibration: [
        "hydraulic pump",
        "floor, beating of two presses",
        "fan or unbalance",
        "structure rings after each start",
    ],
    waves.cyclic: [
        "screw runs out once per turn",
        "once and twice per turn",
        "rack pinion / belt tooth",
    ],
    waves.encoder_cyclic: [
        "resolver twice per turn in the servo log",
        "interpolation error of a grating or magnetic strip",
        "gauge's own gear, other instrument clean",
    ],
    slow.screw_heat: [
        "fixed bearing at the low end",
        "fixed bearing at the high end",
        "hot in the middle where the nut works",
    ],
    slow.structure_drift: [
        "after switching on (exponential)",
        "room over the day, late by the frame",
        "linear with the hours",
    ],
    slow.spindle_growth: ["one time constant", "two time constants (bearing, head)"],
    geometry.squareness: [
        "granite square and dial",
        "ballbar ellipse at 45 degrees",
        "face diagonals",
    ],
    geometry.bow: [
        "hogged guideway (parabola)",
        "S-shaped guideway (cubic)",
        "bed worn near the chuck",
    ],
    geometry.abbe: [
        "tool longer than stated, rotation known",
        "pitch over a hump of the bed, several heights",
        "bed twisted by its levelling feet, several arms",
    ],
    geometry.sag: [
        "ram out, tip droops (cantilever)",
        "cross beam under the head, two supports",
        "overhanging table tilts",
    ],
    slow.force_compliance: ["linear stiffness", "joint that stiffens under load"],
    slow.tool_wear: [
        "linear with parts, reset at tool change",
        "break-in, then linear (Taylor)",
        "probed on the machine after each cut",
    ],
    slow.tool_size: [
        "cutter ground under size, pockets and bosses",
        "measured only on bores and bosses",
    ],
    slow.step_loss: [
        "lost full steps at high acceleration",
        "hidden in one run of a step gauge",
        "belt tooth jumps while one place is watched",
    ],
    instruments.laser_air: [
        "all readings at 20 C settings",
        "air warmed since the set-up",
        "barometer moved, nobody entered it",
    ],
    instruments.dead_path: [
        "far reflector, one place watched",
        "far reflector, sweeps in two hours",
    ],
    instruments.cosine: [
        "laser beam not parallel",
        "step gauge askew, probed along its own line",
    ],
    instruments.delay: ["constant", "held until the next bus cycle"],
    instruments.clock_skew: ["quartz of the logger", "logger loses samples"],
    instruments.sensor_drift: [
        "linear zero drift of the amplifier",
        "amplifier warms up (exponential)",
    ],
    instruments.outlier: ["misread or knocked reading", "spikes on the log"],
}
BUILDS = {build.__name__: build for build in FORMS}
LONG = {"laser_air", "dead_path", "cosine"}  # shown on an axis of 1 m or more
PARTS = {"tool_size", "tool_wear", "pallets"}  # shown by parts, of which a map says nothing
IN_PARTS = "wrong steps/mm in parts"
RAM = "ram out, tip droops (cantilever)"
FRAME = "room over the day, late by the frame"
# of drives and of data: may stand beside parts, which do not show them
SERVO = {
    "servo_lag",
    "inertia",
    "viscous_friction",
    "coulomb_friction",
    "friction_asymmetry",
    "stick_slip",
    "delay",
    "clock_skew",
    "outlier",
    "sensor_drift",
    "vibration",
}
