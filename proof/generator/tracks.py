"""Recordings as they are planned: what is commanded, when, and which points the readings belong to.

A Track knows nothing of errors. Positions are (N, 3) mm in the order X Y Z; an axis that the
machine lacks stays zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from proof.generator.machines import XYZ, Machine


@dataclass(eq=False)
class Sweep:
    """One uninterrupted motion on a fine grid: time (M,) s, position (M, 3), where the rows are in
    it, and which rows of the track they are."""

    time: np.ndarray
    position: np.ndarray
    pick: np.ndarray
    rows: slice


@dataclass(eq=False)
class Track:
    """kind: of the contract; head: keys of the file's head; run, time (N,); position, direction (N,
    3): direction is that of each axis' last motion; moving: axes that move. Of targets: sensitive
    (3,), way (K, 3) all points at which the slide turned or stopped and where the rows are in it
    (stop). Of dynamic kinds: sweeps. Of features: part_rows."""

    kind: str
    head: dict[str, Any]
    moving: str
    run: np.ndarray
    time: np.ndarray
    position: np.ndarray
    direction: np.ndarray
    feed: float = 0.0
    sensitive: np.ndarray = field(default_factory=lambda: np.zeros(3))
    way: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    stop: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    sweeps: list[Sweep] = field(default_factory=list)
    force: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    sense: np.ndarray = field(default_factory=lambda: np.zeros(0))
    # from, to, axis, low, high, mm/s: where and when the slides work
    active: list[tuple[float, float, str, float, float, float]] = field(default_factory=list)
    spindle: list[tuple[float, float, float]] = field(default_factory=list)  # from, to, rpm
    changes: list[float] = field(default_factory=list)  # times of tool changes
    features: list[dict[str, Any]] = field(default_factory=list)
    noise: dict[str, float] = field(default_factory=dict)
    channels: dict[str, bool] = field(default_factory=dict)

    @property
    def quantity(self) -> str:
        return self.head.get("quantity", "displacement")

    @property
    def laser(self) -> bool:
        return self.head.get("instrument") == "laser interferometer"

    @property
    def end(self) -> float:
        return float(self.time[-1])


def targets(
    rng: np.random.Generator,
    machine: Machine,
    head: dict,
    line: np.ndarray,
    lines: list[dict[str, float]],
    *,
    runs: int,
    feed: float,
    start: float,
    dwell: tuple[float, float],
    gap: tuple[float, float],
    both: bool,
    over: float,
    strokes: bool,
    loads: list[float],
    sensitive: np.ndarray,
) -> Track:
    """Captures at rest along `line` (K, 3) there and back. lines: where the other axes stand, in
    turn over the runs; over: mm by which the slide goes past the first and the last target;
    strokes: the axis works in the gaps between the runs."""
    step = line[1:] - line[:-1]
    going = np.sign(step[0])
    unit = step[0] / np.linalg.norm(step[0])
    moving = "".join(x for i, x in enumerate(XYZ) if going[i])
    time, run, position, direction, way, stop, active, force = [], [], [], [], [], [], [], []
    now = start + rng.uniform(40, 75)
    first_gap = rng.uniform(*gap)
    for r in range(runs):
        shifted = line.copy()
        for letter, value in lines[r * len(lines) // runs].items():
            shifted[:, XYZ.index(letter)] = value
        there = [(p, going) for p in shifted]
        sides = [[(shifted[0] - over * unit, None), *there]]
        if both:
            sides.append([(shifted[-1] + over * unit, None), *((p, -going) for p in shifted[::-1])])
        begun, last = now, None
        for side in sides:
            for point, approach in side:
                now += 0.0 if last is None else float(np.linalg.norm(point - last)) / feed * 60
                last = point
                way.append(point)
                if approach is None:
                    continue
                now += rng.uniform(*dwell)
                stop.append(len(way) - 1)
                time.append(now)
                run.append(r + 1)
                position.append(point)
                direction.append(np.where(approach == 0, 1.0, approach))
                force.append(loads[r])
        for x in moving:
            i = XYZ.index(x)
            active.append((begun, now, x, *sorted((line[0, i], line[-1, i])), feed / 60 * 0.15))
        if r < runs - 1:
            pause = first_gap * rng.uniform(0.98, 1.02)
            if strokes:
                for x in moving:
                    i = XYZ.index(x)
                    active.append(
                        (
                            now,
                            now + 0.95 * pause,
                            x,
                            *sorted((line[0, i], line[-1, i])),
                            feed / 60 * 0.7,
                        )
                    )
            now += pause
    forces = np.zeros((len(time), 3))
    forces[:, XYZ.index(moving[0])] = force
    return Track(
        "targets",
        head,
        moving,
        np.array(run),
        np.round(time, 3),
        np.round(position, 3),
        np.array(direction),
        feed,
        sensitive,
        np.array(way),
        np.array(stop),
        force=forces,
        active=active,
    )


def ballbar(
    rng: np.random.Generator,
    machine: Machine,
    head: dict,
    plane: str,
    centre: np.ndarray,
    radius: float,
    feed: float,
    start: float,
    senses: list[int],
    count: int,
    theta: float,
    lead: float,
) -> Track:
    """Full circles, one a run, after `lead` rad of feed-in that is not recorded."""
    i, j = XYZ.index(plane[0]), XYZ.index(plane[1])
    speed = feed / 60
    each = 2 * np.pi * radius / speed / count
    fine = int(np.clip(np.ceil(each / 0.004), 1, 60))
    dt = each / fine
    before = int(np.ceil(lead * radius / speed / dt))
    sweeps, run, time, position, direction, sense = [], [], [], [], [], []
    now = start + rng.uniform(5, 9)
    for r, d in enumerate(senses):
        k = np.arange(-before, (count - 1) * fine + 1)
        angle = theta + d * k * (dt * speed / radius)
        where = np.tile(centre, (len(k), 1))
        where[:, i] += radius * np.cos(angle)
        where[:, j] += radius * np.sin(angle)
        clock = now + k * dt
        pick = before + np.arange(count) * fine
        sweeps.append(Sweep(clock, where, pick, slice(r * count, (r + 1) * count)))
        going = np.ones((count, 3))
        going[:, i] = _sign(-d * np.sin(angle[pick]))
        going[:, j] = _sign(d * np.cos(angle[pick]))
        run += [r + 1] * count
        time.append(clock[pick])
        position.append(where[pick])
        direction.append(going)
        sense += [d] * count
        now = clock[-1] + 8.0 + before * dt
    active = [
        (
            s.time[0],
            s.time[-1],
            x,
            centre[XYZ.index(x)] - radius,
            centre[XYZ.index(x)] + radius,
            speed * 0.64,
        )
        for s in sweeps
        for x in plane
    ]
    return Track(
        "ballbar",
        head,
        plane,
        np.array(run),
        np.concatenate(time),
        np.concatenate(position),
        np.concatenate(direction),
        feed,
        sweeps=sweeps,
        sense=np.array(sense),
        active=active,
    )


def trace(
    rng: np.random.Generator,
    machine: Machine,
    head: dict,
    pair: str,
    centre: np.ndarray,
    start: float,
    runs: int,
    speeds: dict[str, float],
    cut: np.ndarray,
    rate: float,
) -> Track:
    """A test program in motion: creeping and brisk reversals, long moves, circles, a cut under load
    (cut (2,) N mean)."""
    moves = list(_program(machine, pair, centre, speeds))
    grip = 0.55 * min(machine.axes[x].acceleration for x in pair)
    where, loaded = _sampled(moves, centre, pair, grip, rate)
    n = len(where)
    runs = max(1, min(runs, 24900 // n))
    where = np.round(where, 4)
    direction = _last_direction(where)
    now = start + rng.uniform(5, 9)
    i, j = XYZ.index(pair[0]), XYZ.index(pair[1])
    sweeps, time, force = [], [], []
    for r in range(runs):
        clock = now + np.arange(n) / rate
        sweeps.append(Sweep(clock, where, np.arange(n), slice(r * n, (r + 1) * n)))
        time.append(clock)
        now = clock[-1] + 1 / rate
        f = np.zeros((n, 3))
        grow = np.cumsum(loaded) / max(loaded.sum(), 1)  # the cut gets deeper in three steps
        depth = loaded * (0.4 + 0.3 * np.floor(3 * np.clip(grow, 0, 0.999)))
        ripple = 1 + 0.07 * np.sin(np.cumsum(rng.normal(0, 0.05, n)))
        f[:, i], f[:, j] = depth * ripple * cut[0], depth * ripple * cut[1]
        force.append(f)
    travel = {x: (where[:, XYZ.index(x)].min(), where[:, XYZ.index(x)].max()) for x in pair}
    active = [(sweeps[0].time[0], sweeps[-1].time[-1], x, *travel[x], 25.0) for x in pair]
    return Track(
        "trace",
        head,
        pair,
        np.repeat(np.arange(1, runs + 1), n),
        np.concatenate(time),
        np.tile(where, (runs, 1)),
        np.tile(direction, (runs, 1)),
        sweeps=sweeps,
        force=np.concatenate(force),
        active=active,
    )


def _program(
    machine: Machine, pair: str, centre: np.ndarray, speeds: dict[str, float]
) -> Iterator[tuple]:
    """Moves: ("dwell", s), ("to", offset (2,), mm/min, loaded), ("turn", radius, sense, mm/min)."""
    yield "dwell", 0.5
    for axis in (0, 1):
        for feed, reach, back in ((speeds["creep"], 0.4, 0.0), (speeds["brisk"], 4.0, -4.0)):
            for value in (reach, back, 0.0) if back else (reach, 0.0):
                yield "to", _at(axis, value), feed, False
    for axis in (0, 1):
        span = machine.axes[pair[axis]]
        here = centre[XYZ.index(pair[axis])]
        low = max(-(here - span.low) * 0.86, -210.0)
        high = min((span.high - here) * 0.86, 210.0)
        for value in (low, high, 0.0):
            yield "to", _at(axis, value), speeds["long"], False
    for sense in (1, -1):
        yield "turn", speeds["radius"], sense, speeds["circle"]
    away = np.array([0.85, 0.5]) * speeds["radius"]
    yield "to", away, speeds["cut"], True
    yield "to", np.zeros(2), speeds["long"], False
    yield "dwell", 0.3


def _at(axis: int, value: float) -> np.ndarray:
    point = np.zeros(2)
    point[axis] = value
    return point


def _sampled(
    moves: list[tuple], centre: np.ndarray, pair: str, grip: float, rate: float
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (N, 3) at the rate, and where the cut is. Speed rises and falls linearly along
    every move, by `grip` mm/s2."""
    i, j = XYZ.index(pair[0]), XYZ.index(pair[1])
    here, parts, loads = np.zeros(2), [], []
    for move in moves:
        if move[0] == "dwell":
            parts.append(np.tile(here, (int(move[1] * rate), 1)))
            loads.append(np.zeros(len(parts[-1])))
            continue
        if move[0] == "turn":
            _, radius, sense, feed = move
            length = 2 * np.pi * radius
            s = _ramp(length, feed / 60, grip, rate)
            parts.append(
                np.c_[radius * (1 - np.cos(s / radius)), sense * radius * np.sin(s / radius)]
            )
            loads.append(np.zeros(len(s)))
            continue
        _, goal, feed, loaded = move
        length = float(np.linalg.norm(goal - here))
        s = _ramp(length, feed / 60, grip, rate)
        parts.append(here + np.outer(s / length, goal - here))
        loads.append(np.full(len(s), float(loaded)))
        here = goal
    flat = np.concatenate(parts)
    where = np.tile(centre, (len(flat), 1))
    where[:, i] += flat[:, 0]
    where[:, j] += flat[:, 1]
    return where, np.concatenate(loads)


def _ramp(length: float, speed: float, grip: float, rate: float) -> np.ndarray:
    """Way (N,) along a move from rest to rest, trapezoid of speed."""
    speed = min(speed, float(np.sqrt(grip * length)))
    rise = speed / grip
    total = length / speed + rise
    t = np.minimum(np.arange(1, int(np.ceil(total * rate)) + 1) / rate, total)
    up = 0.5 * grip * np.minimum(t, rise) ** 2
    flat = speed * np.clip(t - rise, 0, total - 2 * rise)
    late = np.clip(t - (total - rise), 0, rise)
    return np.minimum(up + flat + speed * late - 0.5 * grip * late**2, length)


def _sign(value: np.ndarray) -> np.ndarray:
    return np.where(value >= 0, 1.0, -1.0)


def _last_direction(where: np.ndarray) -> np.ndarray:
    """(N, 3): the sign of each axis' last motion; before it has moved, +1."""
    step = np.vstack([np.zeros(3), np.sign(np.diff(where, axis=0))])
    at = np.maximum.accumulate(np.where(step != 0, np.arange(len(step))[:, None], -1), axis=0)
    return np.where(at < 0, 1.0, np.take_along_axis(step, np.maximum(at, 0), axis=0))
