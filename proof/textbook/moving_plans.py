"""Tests in motion: circles by ballbar (ISO 230-4), and traces of the drives or of a grid encoder,
on lines, circles and at creeping speed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.signal import lfilter

from .base import Array, Rng, log_uniform, pick
from .case import Case, planes, somewhere
from .machines import Machine
from .recordings import Recording, reversals, set_state, state

RADII = (50.0, 100.0, 150.0, 250.0, 300.0)  # mm, of a bar with its extensions
MOST_ROWS = 9000
Move = tuple[float, float, float]  # mm, mm/min, s of rest after it
State = dict[str, list[Array]]
Turn = tuple[Array, State, int]  # times, states, and 1 where it is counter-clockwise, else -1
# Hz; of every turn its times and what is added to them, s; states over all turns
Path = tuple[float, list[tuple[Array, list[float]]], State]


def ballbar(r: Rng) -> Case:
    """Counter-clockwise and clockwise about one centre, at one feed or two; a file for both senses,
    or for each."""
    c = Case(r, "ballbar", {})
    m = c.machine
    plane = _plane(c, r)
    radius = _bar(r, _shorter_travel(m, plane))
    inner = {a: (m.travel[a][0] + radius + 1, m.travel[a][1] - radius - 1) for a in plane}
    centre = {a: float(round(r.uniform(*inner[a]), 1)) for a in plane}
    where = somewhere(r, m)
    slow = float(pick(r, [500, 1000, 1500, 2000]))
    feeds = [slow, slow * 3][: 1 + (r.random() < 0.4)]
    apart = r.random() < 0.5 and len(feeds) == 1
    start = pick(r, [0.0, np.pi / 4, np.pi / 2, np.pi, -np.pi / 4, 1.5 * np.pi])
    begin = 0.0
    for feed in feeds:
        turns: list[Turn] = []
        for way in (1, -1):
            turns.append(_turn(plane, radius, feed, start, way, begin))
            begin = turns[-1][0][-1] + r.uniform(4, 10)
        for group in [turns[:1], turns[1:]] if apart else [turns]:
            tag = {1: "_ccw", -1: "_cw"}[group[0][2]] if apart else ""
            rec = Recording(f"ballbar_{c.pair}_{feed:.0f}{tag}.csv", "ballbar", m.axes)
            _set_circle(rec, group, centre, where, radius)
            rec.head["feed_mm_min"] = feed
            rec.step = pick(r, [0.01, 0.1])
            c.add(rec, len(rec.t))
        begin += r.uniform(30, 120)
    c.add_room(r)
    return c


def _shorter_travel(m: Machine, plane: tuple[str, str]) -> float:
    return min(m.travel[a][1] - m.travel[a][0] for a in plane)


def _bar(r: Rng, shortest: float) -> float:
    """mm: a radius that the shorter travel allows."""
    longest = max([q for q in RADII if 2 * q + 4 < shortest] or [0.4 * shortest])
    return pick(r, [q for q in RADII[:3] if q <= longest] or [longest])


def _plane(c: Case, r: Rng) -> tuple[str, str]:
    plane = pick(r, planes(c.machine))
    i = int(r.integers(2))
    c.axis, c.other, c.pair = plane[i], plane[1 - i], "".join(plane)
    return plane


def _turn(
    plane: tuple[str, str], radius: float, feed: float, start: float, way: int, begin: float
) -> Turn:
    """One turn about zero, with half a turn before it that is not recorded."""
    omega = feed / 60 / radius
    rate = max(min(900 / (2 * np.pi / omega), 250), 5)
    n = int(2 * np.pi / omega * rate)
    before = int(n / 2)
    t = np.arange(-before, n) / rate
    angle = start + way * omega * t
    # G18 is seen from +Y: counter-clockwise is from Z to X
    first, second = plane[::-1] if plane == ("X", "Z") else plane
    path = {first: radius * np.cos(angle), second: radius * np.sin(angle)}
    states = {a: [q[before:] for q in state(t, path[a])] for a in plane}
    return t[before:] + begin + 8.0, states, way


def _set_circle(
    rec: Recording,
    turns: list[Turn],
    centre: dict[str, float],
    where: dict[str, float],
    radius: float,
) -> None:
    rec.t = np.concatenate([t for t, _, _ in turns])
    rec.run = np.concatenate([np.full(len(t), 1 if way > 0 else 2) for t, _, way in turns])
    rec.sense = np.concatenate([np.full(len(t), way) for t, _, way in turns])
    rec.plane, rec.radius = list(centre), radius
    rec.head = {"instrument": "telescoping ballbar", "centre": centre, "radius_mm": radius}
    rec.pos = dict(where)
    for a in rec.plane:
        place, *others = (np.concatenate([s[a][j] for _, s, _ in turns]) for j in range(6))
        set_state(rec, a, [place + centre[a], *others])
    rec.unit = {a: (rec.pos[a] - centre[a]) / radius for a in rec.plane}


def trace(r: Rng, what: str, sees: str, currents: bool | None = None) -> Case:
    """what: lin, circ or slow; sees: scale or tool; currents: with those of the drives, drawn where
    not given."""
    c = Case(r, f"t{sees[0]}_{what}", {})
    m = c.machine
    with_current = (r.random() < 0.35) if currents is None else currents
    where = somewhere(r, m)
    paths = _circles(c, r) if what == "circ" else _line(c, r, what)
    begin = 0.0
    for k, (rate, turns, states) in enumerate(paths, 1):
        rec = Recording(f"trace_{what}{k}.csv", "trace", m.axes, sees=sees)
        rec.t = np.concatenate([sum(after, t + begin) for t, after in turns])
        rec.run = np.concatenate([np.full(len(t), i) for i, (t, _) in enumerate(turns, 1)])
        rec.pos = dict(where)
        for a, columns in states.items():
            set_state(rec, a, columns)
        rec.moving, rec.rate = list(states), rate
        rec.head = {"sees": sees, "instrument": _recorder(r, what, sees)}
        rec.step = pick(r, [0.001, 0.01, 0.1])
        c.add(rec, len(rec.t))
        if with_current:  # a linear motor on air or rolling guides: the force of inertia alone
            gain = log_uniform(r, 0.0006, 0.003)  # A for 1 mm/s2
            rec.current = {a: gain * lfilter([1 / 3] * 3, [1], rec.acc[a]) for a in states}
        begin = rec.t[-1] + r.uniform(5, 20)
    c.add_room(r)
    return c


def _recorder(r: Rng, what: str, sees: str) -> str:
    if sees == "scale":
        return "servo trace"
    on_line = pick(r, ["grid encoder", "laser interferometer, dynamic"])
    return "grid encoder" if what == "circ" else on_line


def _circles(c: Case, r: Rng) -> Iterator[Path]:
    """Each file: a turn one way, and one the other."""
    travel = c.machine.travel
    plane = _plane(c, r)
    radius = min(pick(r, [10.0, 20.0, 25.0, 50.0]), 0.4 * _shorter_travel(c.machine, plane))
    centre = {a: float(round(np.mean(travel[a]))) for a in plane}
    start = float(r.uniform(0, 6.28))
    feeds = [float(pick(r, [1000, 2000, 3000])), float(pick(r, [4000, 6000]))]
    for feed in feeds[: int(r.integers(1, 3))]:
        omega = feed / 60 / radius
        rate = float(pick(r, [100, 200, 250, 500]))
        period = 2 * np.pi / omega
        while 2 * period * rate > MOST_ROWS:
            rate /= 2
        n, before = int(1.0 * period * rate), int(0.6 * period * rate)
        t = np.arange(-before, n) / rate
        turns = []
        for way in (1, -1):
            angle = start + way * omega * t
            path = {plane[0]: radius * np.cos(angle), plane[1]: radius * np.sin(angle)}
            turns.append({a: [q[before:] for q in state(t, path[a])] for a in plane})
        t = t[before:]
        gap = r.uniform(1.5, 4)
        states = {}
        for a in plane:
            place, *others = map(np.concatenate, zip(*(turn[a] for turn in turns), strict=True))
            states[a] = [place + centre[a], *others]
        yield rate, [(t, []), (t, [t[-1], gap])], states


def _line(c: Case, r: Rng, what: str) -> Iterator[Path]:
    """A line, there and back."""
    m = c.machine
    c.axis = pick(r, m.axes)
    low, high = m.travel[c.axis]
    length = high - low
    rate, moves, acceleration = _creep(r) if what == "slow" else _jogs(c, r, length)
    t, x, v = _profile(moves, rate, acceleration)
    inner = low + 0.1 * length, high - 0.1 * length - abs(moves[0][0])
    x = x + round(r.uniform(*inner), 2)
    held, since_mm, since_s = reversals(t, x)
    held[held == 0] = 1.0
    states = {c.axis: [x, held, since_mm, since_s, v, np.gradient(v, t)]}
    yield rate, [(t, [])], states


def _creep(r: Rng) -> tuple[float, list[Move], float]:
    feed, distance = log_uniform(r, 6, 60), log_uniform(r, 2, 12)
    rate = float(pick(r, [100, 200, 500]))
    if r.random() < 0.5:
        feed = log_uniform(r, 3, 15)
    distance = max(min(distance, feed / 60 * 10000 / (4 * rate)), 0.5)
    return rate, [(distance, feed, 0.3), (-distance, feed, 0.3)] * 2, 50.0


def _jogs(c: Case, r: Rng, length: float) -> tuple[float, list[Move], float]:
    rate = float(pick(r, [200, 250, 500, 1000]))
    distance = min(log_uniform(r, 30, 200), 0.6 * length)
    rest = 0.35
    if r.random() < 0.2:
        rate, rest = 2000.0, 0.12
    feeds = [f for f in (1000, 2500, 5000, 10000) if f <= c.machine.maxv[c.axis]]
    moves: list[Move] = []
    for f in sorted(r.choice(feeds, min(len(feeds), 3), replace=False)):
        moves += [(distance, f, rest), (-distance, f, rest)] * 2
    total = sum(abs(q[0]) / (q[1] / 60) + q[2] for q in moves)
    while total * rate > MOST_ROWS and 200 < rate < 2000:
        rate /= 2
    if total * rate > MOST_ROWS:
        moves = _shorter(moves, total, MOST_ROWS / rate)
    return rate, moves, c.machine.maxa[c.axis]


def _shorter(moves: list[Move], total: float, wanted: float) -> list[Move]:
    """Moves that last as long as is wanted, not the total, s."""
    rests = sum(q[2] for q in moves)
    share = min(max(wanted - rests, 1) / max(total - rests, 1e-9), 1)
    return [(q[0] * share, q[1], q[2]) for q in moves]


def _profile(moves: list[Move], rate: float, acceleration: float) -> tuple[Array, Array, Array]:
    """Times (s), places (mm) from zero and speeds (mm/s): trapezoids of speed, smoothed over 20 ms
    as a limit of jerk would do."""
    speeds = []
    for signed, feed, rest in moves:
        v, way, distance = feed / 60, np.sign(signed), abs(signed)
        if v * v / acceleration > distance:
            v = float(np.sqrt(distance * acceleration))
        ramp, steady = v / acceleration, distance / v - v / acceleration
        n = max(int((2 * ramp + steady) * rate), 3)
        t = (np.arange(n) + 0.5) / rate
        up, down = t * acceleration, (2 * ramp + steady - t) * acceleration
        speeds.append(way * np.clip(np.minimum(up, down), 0, v))
        speeds.append(np.zeros(int(rest * rate)))
    k = max(int(0.02 * rate), 1)
    smooth = np.convolve(np.concatenate(speeds), np.ones(k) / k, "same")
    return np.arange(len(smooth)) / rate, np.cumsum(smooth) / rate, smooth
