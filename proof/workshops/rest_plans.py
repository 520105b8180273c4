"""Tests at rest along one axis, a plane or a diagonal (ISO 230-1, -2, -6), as workshops make them.

Every plan adds its recordings to the case and returns them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .base import Array, log_uniform, pick
from .case import Case
from .readings import (
    BLOCKS,
    CAPACITIVE,
    COMPARATOR,
    INSTRUMENTS,
    LASER,
    PROBE,
    STEP_GAUGE,
    STRAIGHTEDGE,
    add,
    choose,
)
from .recordings import Recording

LINEAR = [LASER, COMPARATOR, STEP_GAUGE, BLOCKS]
STAIRS = [0.005, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 4, 8, 15, 30, 50]  # mm behind a turn


@dataclass
class Move:
    """to: mm of the axes that move; feed: mm/min; dwell: s; run: of the reading, 0 where none is
    taken; more: further columns of the reading."""

    to: dict[str, float]
    feed: float = 1000.0
    dwell: float = 2.0
    run: int = 0
    more: dict[str, float] = field(default_factory=dict)


def name(c: Case, what: str) -> str:
    """Of the case's next recording."""
    return f"{len(c.recs) + 1:02d}_{what}.csv"


def targets(
    c: Case,
    moves: Sequence[Move],
    sensitive: dict[str, float],
    instruments: list[str],
    what: str,
    air: bool = False,
    instrument: str | None = None,
    walk: float | None = None,
    start: dict[str, float] | None = None,
) -> Recording:
    """Readings at rest after moves. sensitive: axis -> weight; air: with a thermometer; walk: um,
    drawn where None; start: mm, the middle where None."""
    r, m = c.r, c.machine
    rec = Recording("targets", name(c, what))
    rec.set_way(*_way(c, moves, start or {a: round(m.middle(a), 3) for a in m.axes}))
    rec.sensitive = {a: float(sensitive.get(a, 0.0)) for a in m.axes}
    readings = [move for move in moves if move.run]
    rec.run = np.array([move.run for move in readings])
    rec.feed = np.array([move.feed for move in readings], float)
    rec.dwell = np.array([move.dwell for move in readings], float)
    c.t = round(c.t + r.uniform(60, 900), 1)
    instrument = instrument or choose(c, instruments)
    rec.step, sizes = INSTRUMENTS[instrument]
    noise = float(r.uniform(*sizes)) * (2 if m.coarse and rec.step < 10 else 1)
    rec.head |= {"instrument": instrument, "quantity": "displacement"}
    if r.random() < 0.75:
        rec.head["u_um"] = round(float(np.sqrt(noise**2 + rec.step**2 / 12)), 3)
    if c.notes_feed:
        rec.more["feed_mm_min"] = rec.feed
    if c.notes_air or air:
        rec.more["T_air_C"] = c.read_air(rec)
    for column in sorted({k for move in readings for k in move.more}):
        rec.more[column] = np.array([move.more.get(column, 0.0) for move in readings])
    if walk is None:
        walk = noise * r.uniform(0.2, 0.5) if r.random() < 0.35 else 0.0
    add(c, rec, noise, walk=walk)
    return rec


def _way(
    c: Case, moves: Sequence[Move], start: dict[str, float]
) -> tuple[list[float], dict[str, list[float]], list[int]]:
    """Times, places, and which of them are read; a move takes 0.3 s longer than at its feed. The
    case's time goes on."""
    axes, travel = c.machine.axes, c.machine.travel
    at, t = dict(start), c.t
    times, way, taken = [t], {a: [at[a]] for a in axes}, []
    for move in moves:
        to = at | {a: round(float(np.clip(x, *travel[a])), 4) for a, x in move.to.items()}
        distance = np.sqrt(sum((to[a] - at[a]) ** 2 for a in axes))
        t += distance / (move.feed / 60.0) + 0.3 * (distance > 0)
        stops = [t] if distance > 0 else []
        t += move.dwell
        for stop in [*stops, t]:
            times.append(stop)
            for a in axes:
                way[a].append(to[a])
        at = to
        if move.run:
            taken.append(len(times) - 1)
    c.t = t
    return times, way, taken


def nodes(c: Case, a: str, n: int | None = None) -> Array:
    """mm: targets over the travel, evenly or not."""
    r, m = c.r, c.machine
    n = n or int(r.integers(6, 22))
    x = np.linspace(0.03, 0.97, n)
    how = pick(r, ["equal", "jitter", "jitter", "uneven"])
    if how == "jitter":
        x[1:-1] += r.uniform(-0.3, 0.3, n - 2) * (x[1] - x[0])
    elif how == "uneven":
        x = np.sort(np.r_[0.03, 0.97, r.uniform(0.03, 0.97, n - 2)])
    digits = 0 if how == "equal" and m.length(a) > 5 * n else 2
    return np.unique(np.round(m.travel[a][0] + m.length(a) * x, digits))


def sweep(
    c: Case,
    a: str,
    x: Array,
    run: int,
    both_ways: bool = True,
    feed: float | None = None,
    over: float | None = None,
    at: dict[str, float] | None = None,
) -> list[Move]:
    """A run of ISO 230-2, with overrun beyond its ends. feed: mm/min; over: mm; at: mm, of other
    axes."""
    feed = feed or c.feed(a)
    over = over if over is not None else c.over(a)
    low, high = c.machine.travel[a]
    at = at or {}
    moves = [Move({**at, a: max(low, x[0] - over)}, feed, 0.5)]
    moves += [Move({**at, a: xi}, feed, c.dwell, run) for xi in x]
    if both_ways:
        moves.append(Move({a: min(high, x[-1] + over)}, feed, 0.5))
        moves += [Move({a: xi}, feed, c.dwell, run) for xi in x[::-1]]
    return moves


def linear(
    c: Case,
    a: str,
    style: str | None = None,
    n: int | None = None,
    runs: int | None = None,
    instrument: str | None = None,
    what: str | None = None,
    both_ways: bool | None = None,
    air: bool = False,
    walk: float | None = None,
) -> Recording:
    """Positioning. style: iso, feeds (another in every run), lunch (a pause in the midst), warmcold
    (many strokes in the midst), shuffled, outback (few places, from both sides)."""
    r = c.r
    styles = ["iso", "iso", "shuffled", "lunch", "outback", "feeds", "warmcold"]
    style = style or pick(r, styles)
    both_ways = bool(r.random() < 0.75) if both_ways is None else both_ways
    runs = runs or int(r.integers(2, 6))
    x = nodes(c, a, n)
    if style == "shuffled":
        moves = [
            Move({a: xi}, c.feed(a), c.dwell, k + 1) for k in range(runs) for xi in r.permutation(x)
        ]
    elif style == "outback":
        moves = _out_and_back(c, a, x, runs + 2)
    else:
        moves = _sweeps(c, a, x, runs, style, both_ways)
    ways = "bidirectional" if both_ways else "one direction"
    c.plan.append(f"targets {style} along {a}, reading {a}, {ways}")
    what = what or f"{a.lower()}_{style}"
    return targets(c, moves, {a: 1.0}, LINEAR, what, air, instrument, walk)


def _sweeps(c: Case, a: str, x: Array, runs: int, style: str, both_ways: bool) -> list[Move]:
    r, fastest = c.r, c.machine.vmax[a]
    moves = []
    for k in range(runs):
        feed = log_uniform(r, 200, fastest) if style == "feeds" else c.feed(a)
        if style in ("lunch", "warmcold") and k == (runs + 1) // 2:
            pause = r.uniform(1500, 4000)
            if style == "lunch":
                moves.append(Move({}, dwell=pause))
            else:
                strokes = [Move({a: end}, fastest * 0.6, 0.2) for end in (x[-1], x[0])]
                moves += strokes * int(r.integers(40, 120))
        moves += sweep(c, a, x, k + 1, both_ways, feed)
    return moves


def _out_and_back(c: Case, a: str, x: Array, runs: int) -> list[Move]:
    r = c.r
    few = np.sort(r.choice(x, min(len(x), int(r.integers(3, 6))), replace=False))
    away = float(pick(r, [0.5, 2.0, 5.0, 10.0]))
    moves = []
    for run in range(1, runs + 1):
        for xi in few:
            for side in (-1, 1):
                moves.append(Move({a: xi + side * away}, c.feed(a), 0.5))
                moves.append(Move({a: xi}, c.feed(a), c.dwell, run))
    return moves


def straight(c: Case, a: str, d: str) -> Recording:
    """Straightness of an axis, read along another (ISO 230-1)."""
    r = c.r
    x = nodes(c, a, int(r.integers(8, 22)))
    moves = []
    for run in range(1, int(r.integers(2, 5)) + 1):
        moves += sweep(c, a, x, run, bool(r.random() < 0.5))
    c.plan.append(f"straightness of {a} read in {d}")
    what = f"{a.lower()}_straight_{d.lower()}"
    rec = targets(c, moves, {d: 1.0}, [STRAIGHTEDGE, PROBE, LASER], what)
    rec.head["quantity"] = "straightness"
    return rec


def square(c: Case, a: str, d: str) -> Recording:
    """A granite square: the axis that leans, read along the other. Made beside a straightness of
    the same."""
    return straight(c, a, d)


def grid(c: Case, a: str, b: str, d: str) -> Recording:
    """Sweeps of a at several places of b, read along d."""
    r, m = c.r, c.machine
    x = nodes(c, a, int(r.integers(6, 14)))
    n = int(r.integers(2, 5))
    places = np.round(m.travel[b][0] + m.length(b) * np.linspace(0.1, 0.9, n), 1)
    if r.random() < 0.3:
        places = r.permutation(places)
    moves, run = [], 0
    for _ in range(int(r.integers(1, 3))):
        for place in places:
            run += 1
            moves += sweep(c, a, x, run, bool(r.random() < 0.6), at={b: float(place)})
    c.plan.append(f"grid: {a} swept at {n} places of {b}, read in {d}")
    what = f"{a.lower()}_at_{b.lower()}"
    return targets(c, moves, {d: 1.0}, [LASER, PROBE, COMPARATOR], what)


def diagonals(c: Case, a: str, b: str) -> list[Recording]:
    """Both diagonals of a face (ISO 230-6), at most 1 : 2."""
    r, m = c.r, c.machine
    w = np.array([m.length(a), m.length(b)])
    if w.max() / w.min() > 3:
        w = np.minimum(w, 2 * w.min())
    w = w * 0.9
    u = w / np.hypot(*w)
    n = int(r.integers(8, 16))
    found = []
    for side in (1, -1):
        shares = np.linspace(-1, 1, n)
        places = [
            {a: m.middle(a) + k * w[0] / 2, b: m.middle(b) + side * k * w[1] / 2} for k in shares
        ]
        ends = [
            {a: places[i][a] + way * u[0] * 2, b: places[i][b] + way * side * u[1] * 2}
            for i, way in ((0, -1), (-1, 1))
        ]
        moves = []
        for run in range(1, int(r.integers(2, 4)) + 1):
            moves.append(Move(ends[0], dwell=1.0))
            moves += [Move(place, dwell=3.0, run=run) for place in places]
            if r.random() < 0.6:
                moves.append(Move(ends[1], dwell=1.0))
                moves += [Move(place, dwell=3.0, run=run) for place in places[::-1]]
        along = {a: float(u[0]), b: float(side * u[1])}
        what = f"diag_{a.lower()}{b.lower()}_{'p' if side > 0 else 'm'}"
        found.append(targets(c, moves, along, [LASER, BLOCKS], what))
    c.plan.append(f"face diagonals {a}{b}")
    return found


def stairs(c: Case, a: str) -> Recording:
    """At few places: a turn, then on in small and larger steps."""
    r, m = c.r, c.machine
    low, length = m.travel[a][0], m.length(a)
    steps = [step for step in STAIRS if step < 0.3 * length]
    moves = []
    for run in range(1, int(r.integers(2, 4)) + 1):
        for share in r.choice([0.2, 0.4, 0.6, 0.8], int(r.integers(1, 3)), replace=False):
            x = low + 0.12 * length + share * 0.5 * length
            for side in (1, -1):
                moves.append(Move({a: x - side * 0.1 * length}, c.feed(a), 0.5))
                moves.append(Move({a: x}, c.feed(a), 1.0))
                moves += [Move({a: x - side * step}, c.feed(a), 2.0, run) for step in steps]
    c.plan.append(f"staggered steps after reversals of {a}")
    instruments = [COMPARATOR, PROBE, CAPACITIVE, LASER]
    return targets(c, moves, {a: 1.0}, instruments, f"{a.lower()}_reversal_steps")


def fine(c: Case, a: str, period: float) -> Recording:
    """Small steps over some periods, mm (ISO 230-2: periodic error)."""
    r, m = c.r, c.machine
    length = m.length(a)
    periods = min(6.0, 0.8 * length / period)
    n = int(r.integers(25, 60))
    low = m.travel[a][0] + 0.1 * length + r.uniform(0, 0.05) * length
    x = low + np.linspace(0, periods * period, n)
    if r.random() < 0.5:
        x[1:-1] += r.uniform(-0.3, 0.3, n - 2) * (x[1] - x[0])
    x = np.round(x, 3 if period < 2 else 2)
    moves, over = [], min(1.0, 0.2 * period + 0.5)
    for run in range(1, int(r.integers(1, 4)) + 1):
        moves += sweep(c, a, x, run, bool(r.random() < 0.5), over=over)
    c.plan.append(f"fine steps along {a} over some {periods * period:.3g} mm")
    return targets(c, moves, {a: 1.0}, [LASER, COMPARATOR, PROBE], f"{a.lower()}_fine")
