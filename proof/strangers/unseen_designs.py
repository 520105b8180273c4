"""Machines and campaigns of the unseen family.  Do not read while working on the judged tool.

What a metrologist records on a visit: positioning in both directions, 3 to 5 runs over 10 to 40
targets that are no multiples of each other (ISO 230-2:2014, standard cycle, 4.3.2), straightness
and angles of the same axis, circles at two feeds in both senses (ISO 230-4), face and body
diagonals (ISO 230-6), drift at one place and axes that warm up (ISO 230-3, clauses 5 and 7), parts
(ISO 10791-7), and what the control logs at several feeds, at creep and on a contour (Erkorkmaz and
Altintas 2001; NAS 979).  One to six files, one after another.
Machines: C-frame machining centres, bridge mills, surface grinders, slant-bed lathes, and the usual
ones.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from .base import Array, Rec, Rng, logu, pick
from .designs import ballbar, captures, features, header_meta, inside, targets
from .machines import CHAINS, TRAVEL, Machine
from .motion import ramp

CHAINS |= {
    "machining centre": ("XYZ", ["w-X-Y-b-Z-t"], ["fanuc-mill", "haas", "siemens"]),
    "bridge mill": ("XYZ", ["w-X-b-Y-Z-t"], ["heidenhain-iso", "siemens"]),
    "surface grinder": ("XYZ", ["w-X-b-Z-Y-t"], ["fanuc-mill", "siemens"]),
    "slant-bed lathe": ("XZ", ["w-b-Z-X-t"], ["fanuc-lathe", "siemens", "haas"]),
}
TRAVEL |= {
    "machining centre": {"X": (500, 1100), "Y": (400, 650), "Z": (400, 650)},
    "bridge mill": {"X": (1000, 2000), "Y": (800, 1600), "Z": (400, 800)},
    "surface grinder": {"X": (400, 1000), "Y": (250, 450), "Z": (250, 500)},
    "slant-bed lathe": {"X": (150, 300), "Z": (300, 1100)},
}
Make = Callable[[float, str], Rec]


def machine_kind(r: Rng, kind: str | None) -> str:
    """A machine that mills if parts are to be cut, else any."""
    mills = ["machining centre", "machining centre", "bridge mill", "mill"]
    return str(pick(r, mills if kind else [*mills, "surface grinder", "slant-bed lathe", "lathe"]))


def usable(m: Machine, ax: int) -> tuple[float, float]:
    """What is left of a travel when every overrun stays within it, mm."""
    lo, hi = m.travel[ax]
    return lo + 0.03 * (hi - lo), hi - 0.03 * (hi - lo)


def positioning(r: Rng, m: Machine, ax: int, quantity: str = "displacement") -> Make:
    """ISO 230-2: at equal steps, each by a part of a lead of its own more or less."""
    full = quantity == "displacement"
    n = int(r.integers(10, 41 if full else 22))
    lo, hi = usable(m, ax)
    gap = (hi - lo) / n
    shift = r.uniform(-0.5, 0.5, n) * min(m.lead[ax], 0.6 * gap)
    force = {
        "n": n,
        "runs": int(r.integers(3, 6) if full else r.integers(2, 4)),
        "pattern": "iso",
        "positions": lo + gap * (np.arange(n) + 0.5) + shift,
        "at": inside(m, r, 0.3, 0.7),
        "laser": True,
    }
    return lambda t, name: targets(r, m, ax, t, name, quantity, force=force)


def warm_up(r: Rng, m: Machine, ax: int) -> Make:
    """ISO 230-3, clause 7: a few targets every 5 to 20 minutes, the axis worked in between."""
    n, (lo, hi) = int(r.integers(3, 8)), usable(m, ax)
    force = {
        "n": n,
        "runs": int(r.integers(6, 15)),
        "pattern": "iso",
        "positions": np.linspace(lo, hi, n),
        "at": inside(m, r, 0.3, 0.7),
        "laser": True,
        "gap": pick(r, [300.0, 600.0, 1200.0]),
    }
    return lambda t, name: targets(r, m, ax, t, name, force=force)


def meta_of(m: Machine, sens: Array, along: int, quantity: str, tool: str, pattern: str) -> dict:
    """Header of a file of targets."""
    return header_meta(
        m,
        quantity=quantity,
        sensitive=sens,
        rotvec=np.zeros(3),
        along=along,
        instrument=tool,
        pattern=pattern,
    )


def drift_test(r: Rng, m: Machine, ax: int) -> Make:
    """ISO 230-3, clause 5: a laser at one place, read every 1 to 4 minutes for hours."""
    n, at = int(r.integers(60, 180)), inside(m, r, 0.3, 0.7)
    before = at.copy()
    before[m.axes] -= 2.0
    meta = meta_of(m, np.eye(3)[ax], ax, "displacement", "laser interferometer", "standing")
    pts, dwell = [(before, 0), *[(at, 1)] * n], float(pick(r, [60.0, 120.0, 240.0]))
    return lambda t, name: captures(m, name, pts, 1000.0, t, dwell, meta, r)


def diagonals(r: Rng, m: Machine) -> list[Make]:
    """ISO 230-6: both diagonals of a face or the four of the body, there and back, 2 or 3 runs."""
    body = len(m.axes) == 3 and r.random() < 0.4
    use = m.axes if body else sorted(int(a) for a in r.permutation(m.axes)[:2])
    n, runs, feed = int(r.integers(8, 25)), int(r.integers(2, 4)), logu(r, 500, m.vmax)
    at, out = inside(m, r, 0.3, 0.7), []
    for flips in ((1, 1, 1), (1, -1, 1), (1, 1, -1), (1, -1, -1))[: 4 if body else 2]:
        base, d = at.copy(), np.zeros(3)
        for a, s in zip(use, flips, strict=False):
            (lo, hi), size = usable(m, a), np.ptp(usable(m, a))
            base[a], d[a] = (lo, size) if s > 0 else (hi, -size)
        x = np.linspace(0.02, 0.98, n)
        way = [(0.0, 0), *[(s, 1) for s in x], (1.0, 0), *[(s, 1) for s in x[::-1]]]
        pts = [
            (np.round(base + s * d, 4), k if hit else 0)
            for k in range(1, runs + 1)
            for s, hit in way
        ]
        unit = d / np.linalg.norm(d)
        meta = meta_of(m, unit, use[0], "displacement", "laser interferometer", "diagonal")
        out.append(
            lambda t, name, pts=pts, meta=meta: captures(m, name, pts, feed, t, 3.0, meta, r)
        )
    return out


def circles(r: Rng, m: Machine, plane: list[int]) -> list[Make]:
    """ISO 230-4: one bar, one centre, slow and fast, counter-clockwise and clockwise."""
    room = min(m.travel[a][1] - m.travel[a][0] for a in plane)
    force = {
        "plane": plane,
        "radius": float(pick(r, [x for x in (50, 100, 150) if x < room * 0.45] or [30])),
        "centre": inside(m, r, 0.48, 0.52),
        "arc": 360.0,
        "senses": [1, -1],
        "reps": int(pick(r, [1, 1, 2])),
    }
    feeds = pick(r, [(500.0, 2000.0), (1000.0, 3000.0), (300.0, 1500.0), (1000.0, 5000.0)])
    return [
        lambda t, name, feed=feed: ballbar(r, m, t, name, force={**force, "feed": feed})
        for feed in feeds
    ]


Goal = tuple[float, float, float]  # mm, mm, mm/min


def at_feeds(r: Rng, room: float, top: float) -> list[Goal]:
    """To and fro along one axis at five feeds, and on."""
    feeds = np.tile(np.repeat(top * np.array([0.1, 0.25, 0.5, 0.75, 1.0]), 2), 20)
    side = np.minimum(room, feeds / 60 * 2.5) / 2
    return [
        (float(d if k % 2 else -d), 0.0, float(f))
        for k, (d, f) in enumerate(zip(side, feeds, strict=True))
    ]


def at_creep(r: Rng, room: float, top: float) -> list[Goal]:
    """A few millimetres to and fro at 20 to 200 mm/min."""
    feeds = np.array([20.0, 50.0, 100.0, 200.0])
    return [
        (float(min(room, f / 60 * 8) / 2 * (1 if k % 2 else -1)), 0.0, float(f))
        for k, f in enumerate(np.tile(np.repeat(feeds, 2), 12))
    ]


def contour(r: Rng, room: float, top: float) -> list[Goal]:
    """A square, its diamond and back, as a test piece has them."""
    side = min(room, top / 60 * 3) / 2
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
    diamond = [(0, -1), (1, 0), (0, 1), (-1, 0), (0, -1)]
    way = [*square, *diamond] * 12
    return [
        (float(x * side), float(y * side), top * (1.0, 0.5)[i // 20 % 2])
        for i, (x, y) in enumerate(way)
    ]


PATHS = {"feeds": at_feeds, "creep": at_creep, "contour": contour}


def log(r: Rng, m: Machine, sees: str, t0: float, name: str) -> Rec:
    """What a control or a grid encoder samples on one of the paths at 50 to 200 Hz, for half a
    minute or more."""
    kind = str(pick(r, ["feeds", "feeds", "creep", "contour"]))
    use, at = [int(a) for a in r.permutation(m.axes)], inside(m, r, 0.45, 0.55)
    room = min(float(np.ptp(m.travel[a])) for a in use[:2]) * 0.4
    fs, top = float(pick(r, [50, 100, 200])), min(float(pick(r, [1000, 2000, 4000])), m.vmax)
    n = int(np.clip(fs * r.uniform(25, 60), 2000, 8000))
    acc, e = m.amax * r.uniform(0.3, 0.8), np.eye(3)[use[:2]]
    p, here = [np.tile(at, (max(1, int(fs * 0.4)), 1))], at
    for x, y, feed in PATHS[kind](r, room, top):
        goal = at + np.array([x, y]) @ e
        d = float(np.linalg.norm(goal - here))
        if d > 1e-6:
            p.append(here + np.outer(ramp(d, feed / 60, acc, 1 / fs) / d, goal - here))
        p.append(np.tile(goal, (int(fs * r.uniform(0.1, 0.4)), 1)))
        here = goal
        if sum(map(len, p)) >= n:
            break
    pos = np.concatenate(p)[:n]
    pos = np.round(np.concatenate([pos, np.tile(pos[-1], (n - len(pos), 1))]), 6)
    dt, tt = 1 / fs, np.round(t0 + np.arange(n) / fs, 5)
    vel, win = np.gradient(pos, dt, axis=0), max(1, int(0.02 * fs))
    flat = np.apply_along_axis(np.convolve, 0, vel, np.ones(win) / win, "same")
    tool = pick(r, ["grid encoder", "R-test"]) if sees == "tool" else "control"
    meta = header_meta(m, sees=sees, instrument=tool, rate=fs, path=kind, feed=top)
    return Rec(
        name,
        "trace",
        tt,
        pos,
        vel,
        np.gradient(flat, dt, axis=0),
        np.ones(n, int),
        pos,
        tt,
        np.arange(n),
        np.full(n, top),
        meta,
    ).finish()


def planes(m: Machine) -> list[list[int]]:
    """Planes of circles."""
    return [[0, 2]] if len(m.axes) == 2 else [[0, 1], [0, 2], [1, 2]]


def visit(r: Rng, m: Machine, plan: str) -> list[Make]:
    """The files of a campaign."""
    axes = [int(a) for a in r.permutation(m.axes)]
    some, plane = axes[: int(r.integers(1, len(axes) + 1))], pick(r, planes(m))
    sides = [partial(positioning, r, m, axes[0], what) for what in ("straightness", "angle")]
    logs = [partial(log, r, m, "tool" if plan == "trace_tool" else "scale")]
    if plan == "laser":
        extra = pick(r, [[], [side() for side in sides], circles(r, m, plane)])
        return [*(positioning(r, m, a) for a in some), *extra]
    if plan == "straight":
        first = [sides[0](), sides[0](), sides[1]()]
        return [*first[: int(r.integers(1, 4))], *(positioning(r, m, a) for a in some[:2])]
    if plan == "diag":
        return [*diagonals(r, m), *(positioning(r, m, a) for a in some[: int(r.integers(0, 3))])]
    if plan == "ballbar":
        chosen = planes(m)[: int(r.integers(1, 4))] if r.random() < 0.5 else [plane]
        return [make for x in chosen for make in circles(r, m, x)]
    if plan == "mix":
        outside = partial(log, r, m, pick(r, ["tool", "scale"]))
        return [positioning(r, m, axes[0]), *circles(r, m, plane), outside]
    if plan == "long":
        still = [drift_test(r, m, a) for a in axes[: int(r.integers(0, 3))]]
        return [*still, *(warm_up(r, m, a) for a in some[:2])]
    if plan == "features":
        parts = partial(features, r, m)
        return [[parts], [parts, parts], [positioning(r, m, axes[0]), parts]][int(r.integers(3))]
    return [*logs * int(r.integers(1, 3)), *pick(r, [[], circles(r, m, plane)])]


def campaign(r: Rng, m: Machine, plan: str, t: float) -> list[Rec]:
    """The files in order of time, with a while between two of them."""
    recs: list[Rec] = []
    for i, make in enumerate(visit(r, m, plan)):
        recs.append(make(t, f"r{i + 1}"))
        wait = pick(r, [120.0, 600.0, 1800.0, 3600.0]) * r.uniform(0.7, 1.5)
        t = float(np.round(float(recs[-1].t[-1]) + wait, 1))
    return recs
