"""What depends on the direction of the motion: lost motion, wind-up, glitches (ISO 230-2, -4)."""

from __future__ import annotations

import numpy as np

from . import moving_plans, rest_plans
from .base import Array, Fields, log_uniform, pick
from .case import Case, Hidden
from .recordings import Recording


def backlash(c: Case, form: str) -> Hidden:
    """Lost motion, the same everywhere (ISO 230-2); size: um, of both sides."""
    a, r = c.axis(), c.r
    how = r.random()
    if form == "ballbar steps":
        c.once(moving_plans.ballbar, *c.plane(a))
    elif how < 0.6:
        style = pick(r, ["iso", "outback", "lunch", "feeds"])
        c.once(rest_plans.linear, a, both_ways=True, style=style)
    elif how < 0.75:
        c.once(rest_plans.stairs, a)
    elif how < 0.87:
        axes, kind = c.both(a), pick(r, ["circles", "pocket", "strokes"])
        c.once(moving_plans.trace, axes, sees="tool", kind=kind, rate=pick(r, [50, 100, 250, 500]))
    else:
        c.once(moving_plans.ballbar, *c.plane(a))
    length = log_uniform(r, 0.005, 0.02)
    presliding = form == "reached after 0.05 mm pre-sliding"
    uneven: dict[str, Array] = {}

    def field(rec: Recording, size: float) -> Fields:
        if presliding:
            return rec.project({a: rec.relaxing(a, lambda sense: -sense * size / 2, length)})
        y = -rec.side(a, abs(size)) * size / 2
        if form == "play with 6 % scatter per reversal":
            if rec.name not in uneven:
                of = np.random.default_rng(int(rec.t[0] * 10) + 7)
                uneven[rec.name] = 1 + 0.06 * of.normal(size=len(rec.way_t))
            y = y * uneven[rec.name][rec.turns[a][3][rec.taken]]
        return rec.project({a: y})

    return Hidden("backlash", a, form, field, params={"lambda_mm": length if presliding else 0})


def backlash_position(c: Case, form: str) -> Hidden:
    """Lost motion that depends on the place; size: um."""
    a, r = c.axis(), c.r
    c.once(rest_plans.linear, a, both_ways=True, style=pick(r, ["iso", "outback", "lunch"]))
    worn, width, loose = r.uniform(0.3, 0.6), r.uniform(0.12, 0.2), r.uniform(0.35, 0.65)

    def field(rec: Recording, size: float) -> Fields:
        u = c.share(a, rec)
        play = {
            "nut play where the screw is worn": np.exp(-0.5 * ((u - worn) / width) ** 2),
            "grows toward the chuck end": (1 - u) ** 1.5,
            "rack with one loose segment": 1.0 * (u > loose),
        }[form]
        return rec.project({a: -rec.side(a, 0.6 * abs(size)) * size / 2 * (0.1 + play)})

    return Hidden("backlash_position", a, form, field)


def windup(c: Case, form: str) -> Hidden:
    """Dahl, A solid friction model, 1968: before it slides, a contact gives way by a length."""
    a, r = c.axis(), c.r
    travel = c.machine.length(a)
    if form == "Dahl pre-sliding of box ways, 1 mm":
        length = log_uniform(r, 0.3, 1.5)
    elif form == "long screw winds up (exponential, mm)":
        length = log_uniform(r, 3, min(40, 0.08 * travel + 3.5))
    else:
        length = log_uniform(r, 0.5, min(20, 0.06 * travel + 1))
    if r.random() < 0.7:
        c.once(rest_plans.stairs, a)
    else:
        c.once(moving_plans.ballbar, *c.plane(a))

    def slips(rec: Recording, size: float) -> Fields:
        return rec.project({a: rec.play(a, size, 2 * length)})

    def relaxes(rec: Recording, size: float) -> Fields:
        return rec.project({a: rec.relaxing(a, lambda sense: -sense * size / 2, length)})

    if form == "belt stretch, linear then slips":
        return Hidden("windup", a, form, slips, params={"length_mm": 2 * length})
    return Hidden("windup", a, form, relaxes, params={"lambda_mm": length})


def reversal_spike(c: Case, form: str) -> Hidden:
    """A glitch behind a turn (ISO 230-4); size: um."""
    a, r = c.axis(), c.r
    dies = form == "quadrant glitch, dies with arc length"
    if r.random() < 0.6 or dies:
        c.once(moving_plans.ballbar, *c.plane(a))
        time = r.uniform(0.04, 0.12)
    else:
        axes, kind = c.both(a), pick(r, ["circles", "strokes", "p2p"])
        c.once(moving_plans.trace, axes, kind=kind, rate=pick(r, [250, 500, 1000]))
        time = r.uniform(0.02, 0.08)
    length = r.uniform(0.15, 0.6)

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind == "targets":
            return {}
        t = rec.since_s[a]
        if dies:
            y = np.exp(-rec.since_mm[a] / length) * (1 - np.exp(-np.maximum(t, 0) / 0.005))
        elif form == "late glitch in time (integrator catches up)":
            y = np.where(t < 12 * time, np.exp(-0.5 * ((t - 2 * time) / time) ** 2), 0)
        else:
            both_sides = t / time * np.exp(1 - t / time) * (1 - t / (2.5 * time))
            y = np.where(t < 12 * time, both_sides, 0)
        return rec.project({a: -rec.sense_of[a] * size * y}, servo=True)

    return Hidden("reversal_spike", a, form, field, params={"T_s": time, "d_mm": length})
