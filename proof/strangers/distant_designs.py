"""Plans of tests and missing columns of the distant family. Do not read while working on the judged
tool.

What a calibration laboratory and a dynamics group do. The laboratory: an axis by five runs (ISO
230-2) and its angles; the same line at both ends of another axis; step, pilgrim and random orders;
two and a half turns of a screw; steps after a reversal; an axis at work and at rest (ISO 230-3,
clause 7), a standing instrument (clause 5) and a running spindle (clause 6); straightness both ways
and angle (ISO 230-1); diagonals (ISO 230-6); loads put on; the same axis on another day; parts of a
batch on a CMM (ISO 10791-7). The group: circles in all planes or at several feeds (ISO 230-4), logs
of the control over many speeds and at a creep, the same route on a grid plate, an acceptance with
one of each.

What tells an effect from its neighbours has to be in a plan that is offered for it: two axes in
motion and several speeds for lags and delays; currents for viscous friction; circles in both
senses; lines at two arms for angles; a thermometer, work and rest for heat. Machines are drawn as
the generator draws them.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from .base import AX, Rec, Rng, pick
from .distant_paths import (
    Make,
    after_a_reversal,
    batch,
    body_diagonals,
    circle,
    close_by,
    heat_run,
    line,
    parallel_lines,
    route,
    sampled,
    standing,
)
from .machines import Machine, draw_machine

PLANS: dict[str, list[str]] = {
    "scale": [
        "calibration",
        "calibration",
        "orders",
        "diagonals",
        "days",
        "again",
        "parts",
        "two_lines",
    ],
    "pitch_shape": ["calibration", "calibration", "orders", "days", "again", "two_lines"],
    "cyclic": ["turns", "turns", "grid"],
    "backlash": [
        "calibration",
        "reversals",
        "all_planes",
        "orders",
        "acceptance",
        "heat",
        "two_lines",
    ],
    "backlash_position": ["calibration", "calibration", "orders", "days", "again"],
    "windup": ["reversals", "reversals", "grid"],
    "reversal_spike": ["all_planes", "circle_feeds", "log", "grid"],
    "stick_slip": ["creep"],
    "friction_asymmetry": ["log", "grid"],
    "viscous_friction": ["log", "grid"],
    "coulomb_friction": ["log", "grid", "creep"],
    "servo_lag": ["log", "log", "grid"],
    "servo_mismatch": ["all_planes", "circle_feeds", "log", "grid"],
    "inertia": ["circle_feeds", "log", "grid", "grid"],
    "vibration": ["log", "grid", "circle_feeds"],
    "encoder_cyclic": ["log", "grid"],
    "screw_heat": ["heat"],
    "structure_drift": ["environment", "environment", "heat", "spindle"],
    "spindle_growth": ["spindle"],
    "squareness": ["all_planes", "circle_feeds", "diagonals", "grid", "acceptance"],
    "bow": ["straight", "straight", "grid"],
    "abbe": ["two_lines", "two_lines", "straight"],
    "sag": ["straight"],
    "force_compliance": ["loads", "loads", "grid"],
    "tool_wear": ["parts"],
    "tool_size": ["parts"],
    "step_loss": ["calibration", "orders", "log", "grid"],
    "laser_air": ["heat"],
    "dead_path": ["heat", "environment"],
    "cosine": ["again", "again", "calibration"],
    "delay": ["log", "grid", "grid"],
    "clock_skew": ["log", "grid"],
}
ALIENS = [  # plans that show the aliens
    *["heat", "grid", "environment", "orders", "straight", "log", "parts", "spindle"] * 3,
    *["loads", "creep", "calibration"] * 2,
]
LOGGED = ("log", "grid", "creep", "acceptance")  # plans with a control's log
LAPS = ("screw_heat", "structure_drift", "laser_air", "dead_path")  # need thermometers


def laboratory(r: Rng, m: Machine, plan: str, axes: list[int]) -> list[Make] | None:
    """Files of the plans at rest."""
    ax, some = axes[0], axes[: int(r.integers(1, len(axes) + 1))]
    if plan == "calibration":
        runs = int(pick(r, [3, 5, 5]))
        lines = [line(r, m, a, runs=runs) for a in some]
        return [*lines, *([line(r, m, ax, "angle", runs=2)] * (r.random() < 0.5))]
    if plan == "two_lines":
        return parallel_lines(r, m, ax)
    if plan == "orders":
        n, kinds = int(r.integers(10, 25)), r.permutation(["iso", "pilgrim", "step", "random"])
        return [line(r, m, ax, n=n, runs=2, pattern=str(k)) for k in kinds[: r.integers(2, 4)]]
    if plan == "turns":
        whole = [line(r, m, ax, runs=2, n=int(r.integers(18, 40)))]
        return [close_by(r, m, ax), close_by(r, m, ax), *(whole * (r.random() < 0.6))]
    if plan == "reversals":
        return [*(after_a_reversal(r, m, a) for a in some[:2]), line(r, m, ax, runs=2)]
    if plan == "heat":
        return [heat_run(r, m, a) for a in axes[: int(r.integers(1, 3))]]
    if plan == "environment":
        n, every = int(r.integers(60, 160)), float(pick(r, [30.0, 60.0, 90.0]))
        return [*(standing(r, m, a, every, n, False) for a in axes[:2]), heat_run(r, m, ax, 0.0)]
    if plan == "spindle":
        n, every = int(r.integers(70, 180)), float(pick(r, [30.0, 60.0]))
        last = [m.axes[-1], *r.permutation(m.axes[:-1])]
        return [standing(r, m, int(a), every, n, True) for a in last[: int(r.integers(1, 3))]]
    if plan == "straight":
        side = [line(r, m, ax, "straightness", across=a, runs=2) for a in m.axes if a != ax]
        more = [line(r, m, ax, "straightness", across=m.axes[-1 if ax != m.axes[-1] else 0])]
        return [*side, line(r, m, ax, "angle", runs=2), *(more * (len(side) == 1))]
    if plan == "diagonals":
        return [*body_diagonals(r, m), *(line(r, m, a, runs=2) for a in axes[:2])][:6]
    if plan == "loads":
        return [line(r, m, a, n=int(r.integers(5, 12)), runs=5) for a in some[:2]]
    if plan in ("days", "again"):
        p = line(r, m, ax, runs=int(r.integers(2, 5))) if plan == "days" else None
        own = partial(line, r, m, ax, n=int(r.integers(9, 20)), runs=int(r.integers(3, 5)))
        return [p or own() for _ in range(int(r.integers(2, 4)))]
    if plan == "parts":
        return [batch(r, m, 4)] * int(r.integers(1, 3))
    return None


def dynamics(r: Rng, m: Machine, plan: str, axes: list[int], amps: bool) -> list[Make]:
    """Files of the plans in motion."""
    flat = [[0, 2]] if len(m.axes) == 2 else [[0, 1], [0, 2], [1, 2]]
    feed = float(pick(r, [600.0, 1000.0, 2000.0, 3000.0]))
    if plan == "all_planes":
        first = [circle(r, m, p, feed) for p in flat]
        return [*first, *([circle(r, m, flat[0], 2.5 * feed)] * (r.random() < 0.5))]
    if plan == "circle_feeds":
        plane = list(pick(r, flat))
        return [circle(r, m, plane, f, reps=1) for f in (300.0, 1500.0, 5000.0)]
    kind = "creep" if plan == "creep" else str(pick(r, ["speeds", "speeds", "slants", "pieces"]))
    way = route(r, m, kind)
    scale, tool = (sampled(m, *way, s, kind, amps) for s in ("scale", "tool"))
    if plan == "grid":
        return [scale, tool, *([circle(r, m, flat[0], feed)] * (r.random() < 0.3))]
    if plan == "creep":
        return [scale, tool] if r.random() < 0.5 else [scale]
    if plan == "acceptance":
        return [line(r, m, axes[0]), circle(r, m, flat[0], feed), scale]
    other = sampled(m, *route(r, m, "speeds"), "scale", "speeds", amps)
    return [scale, other] if r.random() < 0.6 else [other]


def campaign(r: Rng, m: Machine, plan: str, suspect: str, amps: bool, t: float) -> list[Rec]:
    """The files in order of time; a day or more lies between those of a plan of days."""
    axes = [int(a) for a in r.permutation(m.axes)]
    if suspect in ("laser_air", "screw_heat", "cosine"):  # what goes with length needs some
        axes.sort(key=lambda a: -float(np.ptp(m.travel[a])))
    if suspect == "abbe":  # the axis at the tool has no arm that another one changes
        axes.sort(key=lambda a: a == m.order()[-1])
    if suspect == "sag":  # a mass that goes along a beam, not up and down
        axes.sort(key=lambda a: (a == 2) == (len(m.axes) == 3))
    recs: list[Rec] = []
    for i, make in enumerate(laboratory(r, m, plan, axes) or dynamics(r, m, plan, axes, amps)):
        recs.append(make(t, f"r{i + 1}"))
        wait = float(pick(r, [240.0, 900.0, 2400.0])) * r.uniform(0.7, 1.4)
        if plan == "days":
            wait = 86400.0 * int(r.integers(1, 4)) * r.uniform(0.85, 1.1)
        t = float(np.round(float(recs[-1].t[-1]) + wait, 1))
    return recs


def experiment(r: Rng, suspect: str, masked: bool) -> tuple[Machine, list[Rec], dict, str]:
    """Machine, files in order of time, drivers asked for, and the plan's name; a suspect of ALIENS
    is a plan itself."""
    alien = suspect in ALIENS
    plan = suspect if alien else str(pick(r, PLANS[suspect]))
    if masked and plan in ("parts", "log", "creep"):  # none of them shows the machine's map
        plan = "acceptance" if "acceptance" in PLANS[suspect] else "grid"
    kind = str(pick(r, ["mill", "router"])) if plan == "parts" else None
    m = draw_machine(r, masked, kind, flat=plan == "parts")
    friction = suspect in ("viscous_friction", "coulomb_friction", "friction_asymmetry")
    amps = plan in LOGGED and r.random() < (0.85 if friction else 0.4)
    drivers = {
        "load": plan == "loads" or suspect == "force_compliance" or r.random() < 0.1,
        "spindle": plan == "spindle" or r.random() < 0.1,
        "T": suspect in LAPS or plan == "heat" or r.random() < 0.3,
        "current": amps,
    }
    start = float(np.round(r.uniform(0, 90), 1))
    return m, campaign(r, m, plan, suspect, amps, start), drivers, plan


def absent(r: Rng, m: Machine, suspect: str) -> set[str]:
    """Thermometers that nobody put there; those that the suspect needs mostly are there."""
    kept = 0.95 if suspect == "screw_heat" else 0.6
    out = {f"T_screw_{AX[a]}_C" for a in m.axes if r.random() > kept}
    return out | ({"T_spindle_C"} if r.random() < 0.25 else set())
