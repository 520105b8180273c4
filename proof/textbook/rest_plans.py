"""Tests at rest along one axis or a diagonal: targets by ISO 230-2 (linear and step cycles),
straightness by ISO 230-1, diagonals by ISO 230-6, a gauge under a probe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .base import Array, Rng, log_uniform, pick
from .case import Case, duration, planes, somewhere
from .machines import Machine
from .recordings import Recording

LASER = "laser interferometer"


@dataclass
class Cycle:
    """targets: mm (or 0 to 1 of a diagonal); runs; mode: linear, step, or one_way; over: mm, by
    which the axis passes the last target; dwell: s; feed: mm/min."""

    targets: Array
    runs: int
    mode: str
    over: float
    dwell: float
    feed: float

    def rows(self) -> list[tuple[float, int, int, float]]:
        """(target, approach, run, mm since the reversal), in the order of measuring (ISO 230-2)."""
        x, over = self.targets, self.over
        runs = range(1, self.runs + 1)
        if self.mode == "step":
            return [(xi, side, k, over) for xi in x for k in runs for side in (1, -1)]
        found = []
        for k in runs:
            found += [(xi, 1, k, over + xi - x[0]) for xi in x]
            if self.mode == "linear":
                found += [(xi, -1, k, over + x[-1] - xi) for xi in x[::-1]]
        return found

    def travel(self, x: Array, side: Array) -> Array:
        """mm (or of the diagonal) to each row from the one before."""
        distance = np.abs(np.diff(x, prepend=x[0] - self.over))
        turned = np.concatenate([[True], side[1:] != side[:-1]])
        distance = distance + np.where(turned | (self.mode == "step"), 2 * self.over, 0)
        if self.mode == "one_way":
            back = np.concatenate([[False], np.diff(x) < 0])
            distance = np.where(back, distance + 2 * self.over, distance)
        return distance


def measure(
    c: Case,
    r: Rng,
    name: str,
    cycle: Cycle,
    where: dict[str, float],
    begin: float = 0.0,
    seen: dict[str, float] | None = None,
    quantity: str = "displacement",
    lines: dict[str, tuple[float, float, int]] | None = None,
) -> Recording:
    """A laser's recording of a cycle along the case's axis, or along a diagonal: lines: axis ->
    (start and length, mm; sign), the targets being its share. where: mm, of the other axes; begin:
    s; seen: axis -> weight in the reading, the axis itself where not given."""
    m, rows = c.machine, cycle.rows()
    x = np.array([row[0] for row in rows])
    side = np.array([row[1] for row in rows], float)
    since = np.array([row[3] for row in rows])
    distance = cycle.travel(x, side)
    pause = cycle.dwell * r.uniform(0.97, 1.15, len(rows))
    t = begin + np.cumsum(duration(distance, cycle.feed, m.maxa[c.axis]) + pause)
    rec = at_rest(c, name, t, np.array([row[2] for row in rows]), where, seen, quantity)
    for a, (start, length, way) in (lines or {c.axis: (0.0, 1.0, 1)}).items():
        rec.pos[a] = start + length * (x if way > 0 else 1 - x)
        rec.sense_of[a], rec.since_mm[a] = side * way, since * length
        rec.path[a] = np.cumsum(distance * length)
    c.add(rec, len(rows))
    if r.random() < 0.6:
        rec.more["feed_mm_min"] = np.full(rec.n, cycle.feed)
    rec.head["instrument"], rec.step = LASER, 0.01
    return rec


def at_rest(
    c: Case,
    name: str,
    t: Array,
    run: Array,
    where: dict[str, float],
    seen: dict[str, float] | None = None,
    quantity: str = "displacement",
) -> Recording:
    """A recording of targets where every axis rests so far; not yet finished."""
    axes = c.machine.axes
    rec = Recording(name, "targets", axes, t=t, run=run)
    rec.sensitive = seen or only(c, c.axis)
    rec.head = {"quantity": quantity, "sensitive": rec.sensitive}
    for a in axes:
        rec.pos[a], rec.sense_of[a] = where[a], c.resting[a]
    return rec


def only(c: Case, axis: str) -> dict[str, float]:
    """An instrument along one axis."""
    return {a: 1.0 if a == axis else 0.0 for a in c.machine.axes}


def iso_targets(r: Rng, m: Machine, axis: str, n: int | None = None) -> tuple[Array, float]:
    """Targets, mm, at steps that are no multiples of each other (ISO 230-2), and the overrun."""
    low, high = m.travel[axis]
    length = high - low
    n = n or int(np.clip(round(length / 1000 * r.uniform(6, 25)), 6, 26))
    over = min(pick(r, [1.0, 2.0, 3.0, 5.0]), 0.01 * length)
    first, last = low + over + 0.02 * length, high - over - 0.02 * length
    step = (last - first) / (n - 1) / 1.12
    step = max(round(step), 1) if step > 3 else round(step, 1)
    x = first + np.arange(n) * step + r.uniform(-0.25, 0.25, n) * step * 0.3
    return np.clip(x, first, last).round(3), over


def pace(r: Rng) -> dict[str, Any]:
    return {
        "dwell": float(pick(r, [3, 4, 5, 8])),
        "feed": float(pick(r, [1000, 2000, 3000, 5000])),
    }


def laser(r: Rng, plan: str = "laser", long: bool = False, swing: float = 0.1) -> Case:
    """Positioning by laser or scale; long: over the longest axis, with slow dwells."""
    c = Case(r, plan, {"min_travel": 700 if long else 0})
    m = c.machine
    c.axis = pick(r, m.axes)
    if long:
        c.axis = max(m.axes, key=lambda a: m.travel[a][1] - m.travel[a][0])
    x, over = iso_targets(r, m, c.axis)
    k = pace(r)
    if long:
        k["dwell"] = float(r.uniform(8, 25))
    mode = "step" if r.random() < 0.2 and not long else "linear"
    cycle = Cycle(x, int(r.integers(3, 6)), mode, over, **k)
    rec = measure(c, r, f"pos_{c.axis}.csv", cycle, somewhere(r, m))
    if not long and r.random() >= 0.8:
        rec.head["instrument"], rec.step = "comparator scale", 0.05
    c.add_room(r, swing, swing > 0.5, noted=0.9 if long else 0.6)
    return c


def laser_in_warming_room(r: Rng) -> Case:
    swing = log_uniform(r, 0.8, 3.0)
    return laser(r, "laser_temp", True, swing)


def fine(r: Rng) -> Case:
    """Two to four leads of the screw in small steps (ISO 230-2: periodic error)."""
    c = Case(r, "laser_fine", {})
    m = c.machine
    c.axis = pick(r, m.axes)
    low, high = m.travel[c.axis]
    n = int(r.integers(41, 72))
    length = m.lead * pick(r, [2, 3, 4])
    start = r.uniform(low + 10, high - length - 10)
    x = np.round(start + np.linspace(0, length, n), 3)
    cycle = Cycle(x, int(r.integers(2, 4)), "linear", 1.0, 2.0, 1000.0)
    measure(c, r, f"fine_{c.axis}.csv", cycle, somewhere(r, m))
    c.add_room(r)
    return c


def several_lines(r: Rng, plan: str = "laser_multi", three: bool = False) -> Case:
    """One axis on two or three lines, at places of the axis that it carries."""
    c = Case(r, plan, {"angles": True, "three": three})
    while len(c.machine.tool_side) < 2:
        c.machine = Machine(r, angles=True, three=three)
        c.resting = dict.fromkeys(c.machine.axes, 1)
    m = c.machine
    i = int(r.integers(len(m.tool_side) - 1))
    c.axis, c.other = m.tool_side[i], m.tool_side[i + 1]
    x, over = iso_targets(r, m, c.axis, int(r.integers(7, 13)))
    k, where = pace(r), somewhere(r, m)
    low, high = m.travel[c.other]
    begin = 0.0
    for j, part in enumerate([0.05, 0.95] if r.random() < 0.5 else [0.05, 0.5, 0.95]):
        where[c.other] = float(np.round(low + part * (high - low)))
        cycle = Cycle(x, int(r.integers(2, 4)), "linear", over, **k)
        name = f"pos_{c.axis}_at_{c.other}{j + 1}.csv"
        rec = measure(c, r, name, cycle, where, begin)
        begin = rec.t[-1] + r.uniform(600, 1800)
    c.add_room(r)
    return c


def straightness(r: Rng, vertical: bool = False) -> Case:
    """ISO 230-1: across an axis, by straightedge or laser."""
    c = Case(r, "straight_v" if vertical else "straight", {"three": vertical})
    m = c.machine
    if vertical:
        c.axis, c.other = pick(r, ["X", "Y"]), "Z"
    else:
        c.axis = pick(r, m.axes)
        c.other = pick(r, [a for a in m.axes if a != c.axis])
    x, over = iso_targets(r, m, c.axis, int(r.integers(9, 22)))
    mode = pick(r, ["linear", "linear", "one_way"])
    runs, where = int(r.integers(2, 6)), somewhere(r, m)
    rec = measure(
        c,
        r,
        f"straight_{c.axis}_{c.other}.csv",
        Cycle(x, runs, mode, over, **pace(r)),
        where,
        seen=only(c, c.other),
        quantity="straightness",
    )
    rec.head["instrument"] = pick(
        r,
        [
            "straightness laser (Wollaston prism)",
            "straightedge and dial gauge",
            "capacitive probe on straightedge",
        ],
    )
    rec.step = pick(r, [0.1, 0.5, 1.0]) if "dial" in rec.head["instrument"] else 0.02
    c.add_room(r)
    return c


def diagonals(r: Rng) -> Case:
    """ISO 230-6: both diagonals of a plane."""
    c = Case(r, "diag", {})
    m = c.machine
    a, b = sorted(pick(r, planes(m)))
    c.pair, c.axis, c.other = a + b, a, b
    n, runs, k = int(r.integers(7, 14)), int(r.integers(3, 6)), pace(r)
    lengths = {q: m.travel[q][1] - m.travel[q][0] for q in (a, b)}
    whole = np.hypot(0.9 * lengths[a], 0.9 * lengths[b])
    begin, where = 0.0, somewhere(r, m)
    share = np.round(np.linspace(0, 1, n), 6)
    for letter, signs in (("P", (1, 1)), ("N", (1, -1))):
        ways = dict(zip((a, b), signs, strict=True))
        seen = {q: float(way * (0.9 * lengths[q]) / whole) for q, way in ways.items()}
        lines = {
            q: (m.travel[q][0] + 0.05 * lengths[q], 0.9 * lengths[q], way)
            for q, way in ways.items()
        }
        rec = measure(
            c,
            r,
            f"diag_{c.pair}_P{letter}.csv",
            Cycle(share, runs, "linear", 0.004, **k),
            where,
            begin,
            {q: seen.get(q, 0.0) for q in m.axes},
            lines=lines,
        )
        begin = rec.t[-1] + r.uniform(600, 1800)
    c.add_room(r)
    return c


def probing(r: Rng) -> Case:
    """A step gauge or gauge blocks under a probe or a dial gauge."""
    c = Case(r, "probing", {})
    m = c.machine
    c.axis = pick(r, m.axes)
    low, high = m.travel[c.axis]
    length = high - low
    pitch = pick(r, [10.0, 20.0, 50.0])
    n = int(np.clip(0.8 * length // pitch, 6, 25))
    pitch = pitch if n * pitch <= 0.9 * length else np.floor(0.85 * length / n)
    start = round(r.uniform(low + 6, max(high - 6 - (n - 1) * pitch, low + 7)), 2)
    x = np.round(start + np.arange(n) * pitch, 4)
    runs, mode = int(r.integers(3, 6)), pick(r, ["linear", "step"])
    cycle = Cycle(x, runs, mode, 3.0, float(r.uniform(2, 6)), 1500.0)
    rec = measure(c, r, f"stepgauge_{c.axis}.csv", cycle, somewhere(r, m))
    steps = {
        "touch probe on step gauge": 0.1,
        "dial gauge on gauge blocks": 1.0,
        "comparator scale": 0.05,
    }
    rec.head["instrument"] = pick(r, list(steps))
    rec.step = steps[rec.head["instrument"]]
    c.add_room(r)
    return c
