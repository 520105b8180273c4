"""Physics for which no name of the contract stands. Every function plans a test that shows it; its
docstring is its name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import moving_plans, rest_plans, slow_plans
from .base import TURN, Array, Fields, log_uniform, pick
from .case import Case, Hidden
from .geometry import along
from .recordings import Recording
from .rest_plans import LINEAR, Move, nodes

Value = Callable[[Recording], Any]


def at_rest(d: str, value: Value) -> Callable[[Recording, float], Fields]:
    """A field that targets alone see, um."""
    field = along(d, value)
    return lambda rec, size: field(rec, size) if rec.kind == "targets" else {}


def moving(d: str, value: Value) -> Callable[[Recording, float], Fields]:
    """A field that traces alone see, an axis's own scale, too; um."""

    def field(rec: Recording, size: float) -> Fields:
        return rec.project({d: size * value(rec)}, servo=True) if rec.kind == "trace" else {}

    return field


def two_seats(c: Case) -> Hidden:
    """bistable seating of a loose gib"""
    a = c.axis()
    c.once(rest_plans.linear, a, runs=5, n=12)
    often, seed = c.r.uniform(0.25, 0.5), int(c.r.integers(1 << 30))

    def seated(rec: Recording) -> Array:
        return np.random.default_rng([seed, int(rec.t[0])]).random(rec.n) < often

    return alien(a, two_seats, at_rest(a, seated))


def lost_motion_closes(c: Case) -> Hidden:
    """play that opens and shuts as the nut's preload follows the temperature"""
    a = c.axis()
    c.once(rest_plans.linear, a, both_ways=True, style=pick(c.r, ["iso", "lunch"]), runs=7)
    period = 0.5 * (c.recs[-1].t[-1] - c.recs[0].t[0])

    def lost(rec: Recording) -> Array:
        return -rec.sense_of[a] / 2 * np.sin(TURN * rec.t / period)

    return alien(a, lost_motion_closes, along(a, lost))


def oil_film(c: Case) -> Hidden:
    """sinks through the oil film after a stop"""
    a, r = c.axis(), c.r
    tau = r.uniform(8, 25)
    x = nodes(c, a, 8)
    moves = [
        Move({a: xi}, 1500.0, float(np.round(log_uniform(r, 1, 60), 1)), run)
        for run in range(1, 7)
        for xi in r.permutation(x)
    ]
    rest_plans.targets(c, moves, {a: 1.0}, LINEAR, f"{a.lower()}_mixed_waits")
    c.plan.append(f"targets of {a} with waits of 1 to 60 s")
    return alien(a, oil_film, at_rest(a, lambda rec: np.exp(-rec.dwell / tau)))


def stop_overshoot(c: Case) -> Hidden:
    """stop position depends on the square of the approach feed"""
    a = c.axis()
    c.feeds_vary = c.notes_feed = True
    c.once(rest_plans.linear, a, style="feeds", runs=8, both_ways=True)
    field = at_rest(a, lambda rec: rec.sense_of[a] * (rec.feed / 5000) ** 2)
    return alien(a, stop_overshoot, field)


def shrinking_period(c: Case) -> Hidden:
    """ripple whose period shrinks along the travel"""
    a = c.axis()
    waves = c.r.uniform(4, 8)
    c.once(rest_plans.linear, a, n=40, style="iso", runs=3)

    def ripple(rec: Recording) -> Array:
        u = c.share(a, rec)
        return np.sin(TURN * waves * (u + 1.2 * u**2))

    return alien(a, shrinking_period, along(a, ripple))


def speed_order(c: Case) -> Hidden:
    """unbalance order while the spindle runs up"""
    a = c.axis()
    trace = c.once(moving_plans.trace, c.both(a), rate=1000, kind="p2p")
    t = trace.t - trace.t[0]
    slow, fast = c.r.uniform(8, 20), c.r.uniform(90, 200)  # Hz
    trace.more["spindle_rpm"] = np.round(60 * (slow + (fast - slow) * t / t[-1]), 0)
    turned = np.sin(TURN * (slow * t + 0.5 * (fast - slow) / t[-1] * t**2))
    field = moving(a, lambda rec: turned)
    return alien(a, speed_order, lambda rec, size: field(rec, size) if rec is trace else {})


def lubrication(c: Case) -> Hidden:
    """lubrication pulses lift the slide"""
    d = c.axis()
    rec = c.once(slow_plans.dwell, d, hours=1.5, n=240)
    pulses = rec.t[0] + np.cumsum(c.r.uniform(350, 1100, 30))
    tau = c.r.uniform(60, 150)

    def lifted(of: Recording) -> Any:
        gone = (np.clip(of.t - pulse, 0, 1e4) / tau for pulse in pulses)
        return sum(
            np.where(of.t > pulse, np.exp(-x), 0) for pulse, x in zip(pulses, gone, strict=True)
        )

    return alien(d, lubrication, at_rest(d, lifted))


def last_move(c: Case) -> Hidden:
    """reading remembers the length of the last move"""
    a = c.axis()
    c.once(rest_plans.linear, a, style="shuffled", runs=6, n=14)

    def remembered(rec: Recording) -> Array:
        moved = np.r_[0, np.diff(rec.way[a])]
        last = np.where(np.abs(moved) > 1e-6, np.arange(len(moved)), 0)
        return (moved[np.maximum.accumulate(last)] / c.machine.length(a))[rec.taken] ** 3

    return alien(a, last_move, at_rest(a, remembered))


def midband(c: Case) -> Hidden:
    """mid-band resonance of a stepper, only within a band of speeds"""
    a = c.axis()
    axes, kind = c.both(a), pick(c.r, ["p2p", "strokes"])
    trace = c.once(moving_plans.trace, axes, rate=2000, kind=kind)
    speed = np.abs(trace.vel[a])
    centre = float(np.quantile(speed[speed > 0.1 * speed.max()], c.r.uniform(0.4, 0.7)))

    def resonant(rec: Recording) -> Array:
        v = np.abs(rec.vel[a])
        band = np.exp(-0.5 * ((v - centre) / (0.12 * centre)) ** 2)
        hertz = np.minimum(60 + 80 * v / centre, 400)
        return band * np.sin(np.cumsum(np.r_[0, np.diff(rec.t)] * hertz) * TURN)

    return alien(a, midband, moving(a, resonant))


def supply_sags(c: Case) -> Hidden:
    """supply sags when both axes accelerate"""
    a = c.axis()
    b = c.other(a)
    axes, kind = sorted((a, b)), pick(c.r, ["contour", "p2p"])
    c.once(moving_plans.trace, axes, kind=kind, rate=pick(c.r, [250, 500, 1000]))

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind != "trace":
            return {}
        return rec.project({a: -size * rec.acc[a] * np.abs(rec.acc[b])}, servo=True)

    return alien(a, supply_sags, field, size=1e-4)


def cup_lobes(c: Case) -> Hidden:
    """ballbar socket with lobes"""
    c.once(moving_plans.ballbar, *c.plane())
    n, phase = pick(c.r, [3, 5]), c.r.uniform(0, 6.28)

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind != "ballbar":
            return {}
        x, y = rec.unit.values()
        return {"radial_um": size * np.cos(n * np.arctan2(y, x) + phase)}

    found = alien("", cup_lobes, field)
    found.form = f"ballbar socket with {n} lobes"
    return found


def pallets(c: Case) -> Hidden:
    """pallet A and B differ, feature by feature"""
    rec = c.once(moving_plans.features, n=8)
    a = pick(c.r, sorted(set(rec.parts["axis"])))
    seed = int(c.r.integers(1 << 30))
    names = sorted(set(rec.parts["feature"]))
    askew = dict(zip(names, np.random.default_rng(seed).normal(size=len(names)), strict=True))

    def parts(of: Recording) -> Array:
        side = np.where(of.parts["part"] % 2, 1, -1)
        return np.array([askew[name] for name in of.parts["feature"]]) * side

    found = alien(a, pallets, lambda rec, size: {})
    found.parts = parts
    return found


def alien(
    axis: str,
    build: Callable[[Case], Hidden],
    field: Callable[[Recording, float], Fields],
    size: float = 1.0,
) -> Hidden:
    """What such a function gives. size: of the field, um unless it says otherwise."""
    return Hidden("alien", axis, str(build.__doc__), field, size=size)


ALIENS = (
    two_seats,
    lost_motion_closes,
    oil_film,
    stop_overshoot,
    shrinking_period,
    speed_order,
    lubrication,
    last_move,
    midband,
    supply_sags,
    cup_lobes,
    pallets,
)
