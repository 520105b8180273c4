"""Physics that the contract of answers has no name for: to be called unknown."""

from __future__ import annotations

import numpy as np

from .base import Array, Rng, pick, relaxed, sign
from .case import Case
from .recordings import Recording
from .registry import Hidden, alien, along, read


@alien("laser probing laser_long straight")
def loose_clamp(c: Case, r: Rng) -> Hidden:
    """loose scale clamp, sticks at either of two positions"""
    end, n = c.span, int(r.integers(5, 11))
    switches = np.sort(r.uniform(0.05, 0.95, n)) * end
    s = sign(r)
    seen = next(a for a, weight in c.recs[0].sensitive.items() if weight)
    return along(seen, lambda rec: s * (np.searchsorted(switches, rec.t) % 2).astype(float))


@alien("ts_lin tt_lin")
def hunting_loop(c: Case, r: Rng) -> Hidden:
    """hunting loop: triangular limit cycle of wandering frequency, at standstill only"""
    first = c.recs[0]
    rate, speed = first.sample_rate, abs(first.vel[c.axis])
    base = r.uniform(4, 9)  # Hz
    drift = np.cumsum(r.normal(size=first.n)) * 0.25 / np.sqrt(rate)
    phase = np.cumsum(base * np.exp(np.clip(drift, -0.7, 0.7))) / rate
    y = np.where(speed < 0.02 * speed.max(), 4 * abs((phase % 1) - 0.5) - 1, 0)
    return along(c.axis, lambda rec: y)


@alien("laser probing straight")
def chip(c: Case, r: Rng) -> Hidden:
    """chip under the artefact for one run: lifted and tilted, then washed away"""
    first = c.recs[0]
    runs = np.unique(first.run).tolist()
    run = pick(r, runs[1:-1] if len(runs) > 2 else runs[1:])
    tilt = r.uniform(-0.6, 0.6)
    t = first.t[first.run == run]
    begin = t[0] + r.uniform(0, 0.3) * np.ptp(t)
    end = t[-1] - r.uniform(0, 0.3) * np.ptp(t)
    return read(lambda rec: ((rec.t >= begin) & (rec.t <= end)) * (1 + tilt * c.place(rec, c.axis)))


@alien("straight laser_fine laser")
def cable_chain(c: Case, r: Rng) -> Hidden:
    """cable chain: its links pull sideways, only when it is pulled, not pushed"""
    link = np.ptp(c.recs[0].pos[c.axis]) / r.uniform(2.2, 4.5)
    phase = r.uniform(0, 6.28)

    def value(rec: Recording) -> Array:
        wave = np.sin(2 * np.pi * rec.pos[c.axis] / link + phase)
        return np.where(rec.sense_of[c.axis] > 0, abs(wave) ** 3, 0.15 * wave)

    return read(value)


@alien("laser_long thermal_etve straight probing")
def crane(c: Case, r: Rng) -> Hidden:
    """foundation tilts when the crane passes (trapezoids in time)"""
    span, n = c.span, int(r.integers(2, 5))
    middles, widths = r.uniform(0.05, 0.9, n) * span, r.uniform(0.03, 0.09, n) * span
    heights = r.uniform(0.5, 1, n) * np.sign(r.normal(size=n))
    passes = list(zip(middles, widths, heights, strict=True))

    def value(rec: Recording) -> Array:
        y = sum(h * np.clip(1.5 - abs(rec.t - at) / w, 0, 1) for at, w, h in passes)
        return y * (1 + 0.5 * c.place(rec, c.axis) if np.ptp(rec.pos[c.axis]) > 0 else 1.0)

    return read(value)


@alien("laser_fine ts_lin tt_lin")
def magnetic_leakage(c: Case, r: Rng) -> Hidden:
    """magnetic leakage of the linear motor at the scale's ends: pole pitch under an end envelope"""
    length = np.ptp(c.recs[0].pos[c.axis])
    pitch, w = length / r.uniform(6, 11), length * r.uniform(0.08, 0.16)
    phase, s = r.uniform(0, 6.28), r.uniform(0.3, 1)
    low, high = c.extent(c.axis)

    def value(rec: Recording) -> Array:
        x = rec.pos[c.axis]
        ends = np.exp(-(x - low) / w) + s * np.exp(-(high - x) / w)
        return np.sin(2 * np.pi * x / pitch + phase) * ends

    return along(c.axis, value)


@alien("ts_lin ts_circ")
def spindle_emc(c: Case, r: Rng) -> Hidden:
    """EMC: spikes on the encoder while the spindle runs in a band of speeds"""
    span = c.span
    r.uniform(0.2, 0.35)  # a ramp that is not used any more: what is drawn later keeps its place
    most = pick(r, [8000, 12000, 18000])  # rpm
    share, seed = r.uniform(0.04, 0.12), int(r.integers(1 << 30))
    low = r.uniform(0.3, 0.5)
    high = low + r.uniform(0.15, 0.3)
    noted = r.random() < 0.6

    def speed(rec: Recording) -> Array:
        return np.clip(1.5 * (rec.t / span - 0.05), 0, 1)

    def value(rec: Recording) -> Array:
        q, x = np.random.default_rng(seed + rec.n), speed(rec)
        y = (q.random(rec.n) < share) * q.choice([-1, 1], rec.n) * q.uniform(0.4, 1, rec.n)
        return y * ((x > low) & (x < high))

    def after(rec: Recording, size: float) -> None:
        if noted:
            rec.more["spindle_rpm"] = np.round(most * speed(rec))

    return along(c.axis, value, after=after)


@alien("laser_long straight heatrun")
def sunlight(c: Case, r: Rng) -> Hidden:
    """sunlight in the afternoon bends the bed (bell in time, parabola in position)"""
    when, w = r.uniform(0.35, 0.75) * c.span, r.uniform(0.1, 0.22) * c.span
    s, k = sign(r), r.uniform(0.3, 0.8)

    def value(rec: Recording) -> Array:
        bell = s * np.exp(-(((rec.t - when) / w) ** 2))
        return bell * (1 - k * c.place(rec, c.axis) ** 2)

    return read(value)


@alien("laser laser_long thermal_etve probing straight")
def hydraulic_pump(c: Case, r: Rng) -> Hidden:
    """hydraulic pump cycles: square wave in time, rounded edges"""
    period = c.span / r.uniform(4, 9)
    on = r.uniform(0.25, 0.5)
    # oil is asked for at no fixed period
    edges = np.cumsum(period * r.uniform(0.6, 1.4, 40)) - r.uniform(0, period)
    edges = np.concatenate([[edges[0] - period], edges])
    counts = np.arange(len(edges))

    def value(rec: Recording) -> Array:
        phase = np.interp(rec.t, edges, counts)
        return np.tanh(6 * (np.cos(2 * np.pi * phase) - np.cos(np.pi * on)))

    return read(value)


@alien("thermal_etve heatrun laser_long")
def coolant(c: Case, r: Rng) -> Hidden:
    """coolant switched on and off, tank cools in between (saw-like exponentials)"""
    switches = np.cumsum(r.uniform(0.08, 0.22, 12)) * c.span
    tau = r.uniform(0.02, 0.06) * c.span

    def value(rec: Recording) -> Array:
        t = np.linspace(0, rec.t[-1], 3000)
        on = (np.searchsorted(switches, t) % 2).astype(float)
        cold = relaxed(on, np.full(len(t), t[1] - t[0]), tau)
        return -np.interp(rec.t, t, cold)

    return read(value)


@alien("laser_fine ts_lin tt_lin")
def dirty_scale(c: Case, r: Rng) -> Hidden:
    """dirt on the scale: a narrow glitch at one place, the reading head climbs and falls"""
    low, high = c.extent(c.axis)
    at = low + r.uniform(0.2, 0.8) * (high - low)
    w = (high - low) * r.uniform(0.015, 0.035)
    s = sign(r)

    def value(rec: Recording) -> Array:
        z = (rec.pos[c.axis] - at) / w
        return s * ((1 - z * z) * np.exp(-z * z / 2))

    return along(c.axis, value)


@alien("ballbar tt_circ")
def rotary_joint(c: Case, r: Rng) -> Hidden:
    """play in a rotary head joint: bistable with the quadrant of the force (flips at 45 degrees)"""
    offset = r.uniform(0.4, 1.1)

    def value(rec: Recording) -> Array:
        x, y = rec.pos[c.axis], rec.pos[c.other]
        middle = [np.mean([q.max(), q.min()]) for q in (y, x)]
        angle = np.arctan2(y - middle[0], x - middle[1])
        return np.tanh(8 * np.cos(angle - offset)) * np.tanh(8 * np.cos(2 * (angle + offset)))

    return along(c.axis, value)
