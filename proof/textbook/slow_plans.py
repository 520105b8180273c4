"""Tests that last: axes that warm up, drift of the frame and of the spindle (ISO 230-3), loads; and
parts that were cut and measured."""

from __future__ import annotations

import numpy as np

from .base import Array, Rng, log_uniform, pick
from .case import Case, Room, duration, somewhere
from .recordings import Recording
from .rest_plans import LASER, at_rest, only

SPEEDS = ((0.05, 0.25, 0.5), (0.25, 0.45, 1.0), (0.45, 0.6, 0.25), (0.6, 0.8, 0.75))


def heat_run(r: Rng) -> Case:
    """A few targets again and again, the axis worked in between, then left to cool (ISO 230-3)."""
    c = Case(r, "heatrun", {})
    m = c.machine
    c.axis = pick(r, m.axes)
    low, high = m.travel[c.axis]
    margin = 0.06 * (high - low)
    x = np.round(np.linspace(low + margin, high - margin, int(r.integers(3, 7))), 3)
    feed = float(pick(r, [5000, 8000]))
    cycles = int(r.integers(16, 34))
    warm = int(cycles * r.uniform(0.5, 0.75))
    pause = float(pick(r, [90, 120, 180, 240]))
    rows = _heat_rows(x, feed, m.maxa[c.axis], cycles, warm, pause)
    t, at, side, run, since, path = rows.T
    rec = at_rest(c, f"heat_{c.axis}.csv", t, run.astype(int), somewhere(r, m))
    rec.pos[c.axis], rec.sense_of[c.axis] = at, side
    rec.since_mm[c.axis], rec.path[c.axis] = since, path
    rec.head["instrument"], rec.step = LASER, 0.01
    c.add(rec, len(rows))
    if r.random() < 0.7:
        rec.more["feed_mm_min"] = np.full(rec.n, feed)
    c.add_room(r, noted=0.7)
    return c


def _heat_rows(
    x: Array, feed: float, acceleration: float, cycles: int, warm: int, pause: float
) -> Array:
    """(time, target, approach, cycle, mm since the reversal, mm travelled) of every reading."""
    over, dwell = 2.0, 3.0
    rows, t, path = [], 0.0, 0.0
    for k in range(cycles):
        if k:
            t += pause
            path += (pause if k < warm else 0.0) * feed / 60 * 0.8
        for side, targets in ((1, x), (-1, x[::-1])):
            for j, at in enumerate(targets):
                d = over if j == 0 else abs(targets[j] - targets[j - 1])
                t += float(duration(d, feed, acceleration)) + dwell
                path += d
                rows.append((t, at, side, k + 1, over + abs(at - targets[0]), path))
    return np.array(rows)


def drift(r: Rng, spindle: bool = False, quiet: bool = False) -> Case:
    """ISO 230-3: probes at one place, for hours; with a spindle's programme, or in a room whose air
    swings."""
    c = Case(r, "thermal_spindle" if spindle else "thermal_etve", {})
    m = c.machine
    end = r.uniform(2, 5) * 3600 if spindle else r.uniform(4, 12) * 3600
    dt = float(pick(r, [60, 120, 180])) if spindle else float(pick(r, [180, 300]))
    t = np.arange(dt, end, dt)
    rpm = _speeds(r, t, end) if spindle else np.zeros(len(t))
    where = somewhere(r, m)
    order = list(m.axes)
    r.shuffle(order)
    order.sort(key=lambda a: a != "Z")  # Z first, the others as drawn
    c.axis = order[0]
    for a in order[: int(r.integers(1, len(order) + 1))]:
        rec = at_rest(c, f"drift_{a}.csv", t.copy(), np.ones(len(t), int), where, only(c, a))
        probes = ["capacitive probe", "capacitive probe", "eddy current probe"]
        rec.head["instrument"], rec.step, rec.rpm = pick(r, probes), 0.02, rpm
        c.add(rec, len(t))
        if spindle:
            rec.more["spindle_rpm"] = rpm
    swing = 0.15 if spindle else log_uniform(r, *((0.05, 0.3) if quiet else (0.8, 3.0)))
    c.add_room(r, swing, not spindle, noted=0.8)
    return c


def _speeds(r: Rng, t: Array, end: float) -> Array:
    """rpm: one speed, or four."""
    rpm = np.zeros(len(t))
    most = float(pick(r, [3000, 6000, 8000, 12000]))
    if r.random() < 0.5:
        rpm[(t > 0.05 * end) & (t < 0.65 * end)] = most
        return rpm
    for begin, stop, part in SPEEDS:
        rpm[(t >= begin * end) & (t < stop * end)] = part * most
    return rpm


def load(r: Rng) -> Case:
    """A force that rises and falls in steps, at one place or three."""
    c = Case(r, "load", {})
    m = c.machine
    a = c.axis = pick(r, m.axes)
    largest = log_uniform(r, 200, 2000)
    up = np.linspace(0, 1, int(r.integers(5, 9)))
    both = [-up[1:], -up[-2::-1]] if r.random() < 0.5 else []
    profile = np.concatenate([up, up[-2::-1], *both])
    where = somewhere(r, m)
    spots = [where[a]]
    if r.random() >= 0.6:
        low, high = np.array(m.travel[a]) * 0.8 + 0.1 * sum(m.travel[a])
        spots = np.round(np.linspace(low, high, 3), 1).tolist()
    rows, t = [], 0.0
    runs = int(r.integers(3, 6))
    for k in range(len(spots) * runs):
        for part in profile:
            t += r.uniform(12, 25)
            rows.append((t, spots[k // runs], part * largest, k + 1))
    times, at, force, run = np.array(rows).T
    rec = at_rest(c, f"load_{a}.csv", times, run.astype(int), where)
    rec.pos[a], rec.force = at, {a: force}
    rec.head["instrument"] = pick(r, ["dial gauge, load cell", "capacitive probe, load cell"])
    rec.step = 0.5 if "dial" in rec.head["instrument"] else 0.02
    c.add(rec, len(rows))
    rec.more[f"force_{a}_N"] = force + r.normal(0, 0.003 * largest, rec.n)
    c.add_room(r)
    return c


def parts(r: Rng) -> Case:
    """Measured features of a series of parts, cut where the tables are zero."""
    c = Case(r, "features", {"flat": True})
    c.axis = "X"
    turned = c.machine.kind in ("lathe", "grinder")
    features = _turned(r) if turned else _milled(r, c.machine.axes)
    n_parts, n_readings = int(r.integers(6, 26)), int(r.integers(1, 4))
    rows = [(*f, p + 1, k + 1) for p in range(n_parts) for f in features for k in range(n_readings)]
    names = ("feature", "kind", "axis", "nominal", "part", "reading")
    rec = Recording("parts.csv", "features", c.machine.axes, t=np.arange(len(rows), dtype=float))
    rec.parts = {name: np.array([row[i] for row in rows]) for i, name in enumerate(names)}
    rec.pos, rec.turned = dict.fromkeys(rec.axes, 0.0), turned
    rec.head["instrument"] = pick(r, ["CMM", "CMM", "bore gauge and micrometer"])
    rec.step = 0.1 if rec.head["instrument"] == "CMM" else 1.0
    c.add(rec, len(rows))
    c.room, c.bed_tau = Room(r, 100, 0.1), 3000.0
    return c


Feature = tuple[str, str, str, float]  # name, kind, axis, nominal size in mm


def _turned(r: Rng) -> list[Feature]:
    found: list[Feature] = []
    for name, kind, axis, most, low, high in (
        ("OD", "boss_diameter", "X", 5, 20, 120),
        ("ID", "bore_diameter", "X", 3, 20, 80),
        ("L", "step", "Z", 4, 5, 150),
    ):
        for i in range(int(r.integers(2 if name == "OD" else 1, most))):
            found.append((f"{name}{i + 1}", kind, axis, float(r.integers(low, high))))
    return found


def _milled(r: Rng, axes: list[str]) -> list[Feature]:
    found: list[Feature] = []
    for a in axes[:2]:
        for i in range(int(r.integers(1, 4))):
            found.append((f"C{a}{i + 1}", "centre_distance", a, float(r.integers(3, 28)) * 10))
        for i in range(int(r.integers(1, 3))):
            found.append((f"P{a}{i + 1}", "pocket_size", a, float(r.integers(20, 90))))
    found.append(("B1", "boss_diameter", "X", float(r.integers(20, 90))))
    found.append(("H1", "bore_diameter", "X", float(r.integers(15, 60))))
    found.append(("R1", "circularity", "", 0.0))
    if "Z" in axes:
        found.append(("S1", "step", "Z", float(r.integers(3, 30))))
    return found
