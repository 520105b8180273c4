"""What comes back: by the place, by the time, and by the way since the slide stuck."""

from __future__ import annotations

import numpy as np

from . import moving_plans, rest_plans, slow_plans
from .base import TURN, Array, Fields, Rng, log_uniform, pick
from .case import Case, Hidden
from .readings import DIAL, LASER
from .recordings import Recording


def cyclic(c: Case, form: str) -> Hidden:
    """ISO 230-2: periodic error. Once a turn of a screw, a pinion or a pulley."""
    a, r, m = c.axis(), c.r, c.machine
    pinion = pick(r, [2.0, 3.0, np.pi, 2 * np.pi])
    period = pinion if form == "rack pinion / belt tooth" else m.lead[a]
    period = min(period, m.length(a) / 6)
    phase, second, phase_2 = r.uniform(0, TURN), r.uniform(0.4, 0.8), r.uniform(0, TURN)
    how = r.random()
    if how < 0.65:
        c.once(rest_plans.fine, a, period)
    elif how < 0.85:
        c.once(moving_plans.ballbar, *c.plane(a))
    else:
        axes, rate = c.both(a), pick(r, [100, 250, 500])
        c.once(moving_plans.trace, axes, kind="p2p", sees="tool", rate=rate, top=period * 5)

    def field(rec: Recording, size: float) -> Fields:
        y = np.sin(TURN * rec.pos[a] / period + phase)
        if form == "once and twice per turn":
            y = y + second * np.sin(2 * TURN * rec.pos[a] / period + phase_2)
        return rec.project({a: size * y})

    return Hidden("cyclic", a, form, field, params={"period_mm": period})


def encoder_cyclic(c: Case, form: str) -> Hidden:
    """What the scale or the gauge repeats and the axis does not do; size: um. Another instrument
    does not show it."""
    a, r, m = c.axis(), c.r, c.machine
    phase = r.uniform(0, TURN)
    if form == "gauge's own gear, other instrument clean":
        return _gauge_gear(c, a, phase, form)
    if form == "resolver twice per turn in the servo log":
        period, second = m.lead[a] / 2, 0.0
        axes, kind = c.both(a), pick(r, ["p2p", "strokes"])
        rate, top = pick(r, [100, 250, 500]), period * 8
    else:
        period, second = pick(r, [0.1, 0.2, 0.5, 1.0, 2.0]), 0.3
        axes, kind = c.both(a), pick(r, ["p2p", "contour"])
        rate, top = pick(r, [500, 1000, 2000]), period * 30
    c.once(moving_plans.trace, axes, kind=kind, rate=rate, top=top)

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind != "trace" or rec.sees != "scale":
            return {}
        y = np.sin(TURN * rec.pos[a] / period + phase)
        y = y + second * np.sin(2 * TURN * rec.pos[a] / period)
        return rec.project({a: size * y}, servo=True)

    return Hidden("encoder_cyclic", a, form, field, params={"period_mm": period})


def _gauge_gear(c: Case, a: str, phase: float, form: str) -> Hidden:
    """The gauge's, and not the machine's: another instrument on the same moves does not show it."""
    period = pick(c.r, [1.0, 2.0])
    rec = rest_plans.fine(c, a, period)
    instrument = DIAL if c.machine.coarse else LASER
    moves, what = slow_plans.again(rec), f"{a.lower()}_fine_again"
    rest_plans.targets(c, moves, {a: 1.0}, [], what, instrument=instrument)
    c.plan.append("the same places once more with another instrument")

    def field(of: Recording, size: float) -> Fields:
        if of is not rec:
            return {}
        return rec.project({a: size * np.sin(TURN * rec.pos[a] / period + phase)})

    params = {"period_mm": period}
    return Hidden("encoder_cyclic", a, form, field, axes_too=[""], params=params)


def vibration(c: Case, form: str) -> Hidden:
    """By the time; size: um (of what rings, um s2/mm of the excitation)."""
    a, r = c.axis(), c.r
    f = {  # Hz
        "hydraulic pump": pick(r, [24.3, 24.8, 49.1]),
        "floor, beating of two presses": r.uniform(4, 12),
        "fan or unbalance": r.uniform(12, 80),
        "structure rings after each start": r.uniform(8, 40),
    }[form]
    rings = form == "structure rings after each start"
    if rings or r.random() < 0.6:
        rate = pick(r, [q for q in (250, 500, 1000, 2000) if q > 5 * f])
        axes, kind = c.both(a), pick(r, ["p2p", "strokes", "contour", "circles"])
        c.once(moving_plans.trace, axes, rate=rate, kind=kind, sees=pick(r, ["scale", "tool"]))
    else:
        plane = c.plane(a)
        f = min(f, 9.0)
        c.once(moving_plans.ballbar, *plane, feeds=[float(pick(r, [500, 1000, 3000]))])
    phase, beat = r.uniform(0, TURN), r.uniform(0.2, 0.5)

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind == "targets" or (rings and rec.kind == "ballbar"):
            return {}
        y = np.sin(TURN * f * rec.t + phase)
        if form == "floor, beating of two presses":
            y = y * (0.6 + 0.4 * np.sin(TURN * beat * rec.t))
        if rings:
            y = ringing(rec.acc[a], 1 / (rec.way_t[1] - rec.way_t[0]), f)
        return rec.project({a: size * y}, servo=True)

    return Hidden("vibration", a, form, field, params={"frequency_hz": f})


def ringing(acceleration: Array, rate: float, f: float) -> Array:
    """What an acceleration, mm/s2, excites: a resonance at f, damped by 3 %; both in Hz."""
    w, t = TURN * f, np.arange(int(1.2 * rate)) / rate
    response = np.exp(-0.03 * w * t) * np.sin(w * t)
    return np.convolve(acceleration, response)[: len(acceleration)] / 200.0


def stick_slip(c: Case, form: str) -> Hidden:
    """A slide that sticks while it is slow, and jumps; size: um."""
    a, r = c.axis(), c.r
    length, slow = (
        log_uniform(r, 0.02, 0.15),
        r.uniform(1.0, 3.0),
    )  # mm; mm/s, below which it sticks
    axes, kind = c.both(a), pick(r, ["strokes", "p2p"])
    rate, top = pick(r, [100, 250, 500]), slow * r.uniform(0.5, 2)
    sees = pick(r, ["scale", "tool"])
    c.once(moving_plans.trace, axes, kind=kind, rate=rate, top=top, sees=sees)
    seed = int(r.integers(1 << 30))
    stuck = _even if form == "regular saw-tooth" else _uneven

    def field(rec: Recording, size: float) -> Fields:
        if rec.kind != "trace":
            return {}
        way = np.cumsum(np.abs(np.diff(rec.pos[a], prepend=rec.pos[a][0])))
        sticks = 1 / (1 + (np.abs(rec.vel[a]) / slow) ** 4)
        y = stuck(way, length, np.random.default_rng(seed))
        return rec.project({a: -rec.sense_of[a] * size * y * sticks}, servo=True)

    return Hidden("stick_slip", a, form, field, params={"step_mm": length, "v_mm_s": slow})


def _even(way: Array, length: float, r: Rng) -> Array:
    """0 to 1 over every step of a length."""
    return (way / length) % 1.0


def _uneven(way: Array, length: float, r: Rng) -> Array:
    steps = length * r.lognormal(0, 0.45, int(way[-1] / length * 2) + 20)
    edges = np.r_[0, np.cumsum(steps)]
    k = np.clip(np.searchsorted(edges, way, side="right") - 1, 0, len(edges) - 2)
    return (way - edges[k]) / length
