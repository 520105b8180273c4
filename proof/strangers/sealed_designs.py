"""Machines and target designs of the sealed family.  Do not read while working on the judged tool.

At rest: ISO 230-2:2014 (axes beyond 2 m: targets 250 mm apart; a fine series within a few pitches
for periodic errors), many runs over five targets (capability studies), the golden sequence (Weyl
1916), Latin squares balanced for what is left over from the place before (Williams 1949), the Union
Jack of surface plates (Moody 1955), a machine that stands for hours (ISO 230-3, environmental
variation).
Circles: short arcs, odd radii, one after another in the same sense.  In motion: smallest steps
(ASME B5.54), a swept sine, a ladder of speeds (Erkorkmaz and Altintas 2001), figures of eight,
loops that grow, a square at an angle (NAS 979).
Machines: portals of up to 9 m, horizontal centres, printers, small machines, vertical lathes and
lathes whose spindle rides on Z.
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, logu, pick
from .designs import ORDERS, captures, header_meta, inside, targets
from .machines import CHAINS, TRAVEL, Machine
from .motion import ramp

CHAINS |= {
    "portal": ("XYZ", ["w-b-X-Y-Z-t", "w-X-b-Y-Z-t"], ["siemens", "heidenhain-iso", "fanuc-mill"]),
    "horizontal": ("XYZ", ["w-Z-b-X-Y-t", "w-X-b-Z-Y-t"], ["fanuc-mill", "siemens", "haas"]),
    "printer": ("XYZ", ["w-Y-b-Z-X-t", "w-Z-b-Y-X-t"], ["marlin"]),
    "small": ("XYZ", ["w-X-Y-b-Z-t", "w-Y-X-b-Z-t"], ["linuxcnc", "grbl"]),
    "vertical lathe": ("XZ", ["w-b-X-Z-t"], ["siemens", "fanuc-lathe"]),
    "gang lathe": ("XZ", ["w-Z-b-X-t"], ["fanuc-lathe", "linuxcnc"]),
}
TRAVEL |= {
    "portal": {"X": (2500, 9000), "Y": (1500, 4000), "Z": (400, 1200)},
    "horizontal": {"X": (500, 1000), "Y": (400, 900), "Z": (400, 900)},
    "printer": {"X": (180, 420), "Y": (180, 420), "Z": (180, 500)},
    "small": {"X": (100, 160), "Y": (100, 140), "Z": (100, 120)},
    "vertical lathe": {"X": (400, 2000), "Z": (300, 1200)},
    "gang lathe": {"X": (100, 300), "Z": (100, 300)},
}
PARTS = ["mill", "router", "horizontal", "printer", "small"]
OTHERS = ["portal", "horizontal", "printer", "small", "vertical lathe", "gang lathe"]


def machine_kind(r: Rng, kind: str | None) -> str | None:
    """A machine for parts if one is asked for, else in two of three cases one of the new ones."""
    if kind:
        return str(pick(r, PARTS))
    return str(pick(r, OTHERS)) if r.random() < 2 / 3 else None


def williams(p: Array, k: int, over: float) -> list[tuple[float, int]]:
    """Row k of a Latin square 0, 1, n-1, 2, n-2 ...; every second square is its mirror."""
    n = len(p)
    first = [(i + 1) // 2 if i % 2 else (n - i // 2) % n for i in range(n)]
    row = [(i + (k - 1) // 2) % n for i in first]
    return [(p[0] - over, 0), *[(float(p[i]), k) for i in (row if k % 2 else row[::-1])]]


def golden(p: Array, k: int, over: float) -> list[tuple[float, int]]:
    """Places in the order of the multiples of the golden ratio, each run from another one on."""
    n = len(p)
    rank = np.argsort((np.arange(n) + k) * 0.6180339887498949 % 1.0)
    return [(p[0] - over, 0), *[(float(p[i]), k) for i in rank]]


ORDERS["williams"], ORDERS["golden"] = williams, golden


def usable(m: Machine, ax: int) -> tuple[float, float]:
    """What is left of a travel when every overrun stays within it, mm."""
    lo, hi = m.travel[ax]
    return lo + 0.03 * (hi - lo), hi - 0.03 * (hi - lo)


def fine_series(r: Rng, m: Machine, ax: int) -> dict:
    """Two to five places with 8 to 20 targets each within one or two leads."""
    lo, hi = usable(m, ax)
    places, n, p = int(r.integers(2, 6)), int(r.integers(8, 21)), m.lead[ax]
    width = min(p * pick(r, [1.0, 2.0]), 0.8 * (hi - lo) / places)
    start = np.linspace(lo, hi - width, places)
    x = np.sort((start[:, None] + np.linspace(0, width, n)).ravel())
    return {"positions": np.unique(np.round(x, 3)), "n": places * n, "runs": int(r.integers(1, 4))}


def at_rest(r: Rng, m: Machine, kind: str, ax: int) -> dict:
    """What to force on a run of targets."""
    lo, hi = usable(m, ax)
    choices = ["fine", "few", "williams", "golden"] + ["far"] * 2 * (hi - lo > 1900)
    what = pick(r, choices if kind != "long" else ["few", "williams", "golden"])
    if what == "fine":
        return {**fine_series(r, m, ax), "pattern": pick(r, ["iso", "uni"])}
    if what == "few":
        n = int(r.integers(3, 7))
        return {"n": n, "runs": int(r.integers(10, 31)), "pattern": pick(r, ["iso", "uni"])}
    if what == "far":
        n = int((hi - lo) / 250) + 1
        return {
            "positions": lo + 250.0 * np.arange(n) + np.round(r.uniform(0, 12, n), 1),
            "n": n,
            "runs": int(r.integers(1, 6)),
            "pattern": "iso",
        }
    return {"n": round(logu(r, 5, 40)), "runs": int(r.integers(2, 9)), "pattern": what}


def union_jack(r: Rng, m: Machine, t0: float, name: str) -> Rec:
    """Four sides, two diagonals and two middle lines of a rectangle, height read across; a line is
    a run."""
    up = int(pick(r, m.axes))
    a, b = [x for x in m.axes if x != up]
    n, at = int(r.integers(5, 14)), inside(m, r)
    (x0, x1), (y0, y1) = (usable(m, a), usable(m, b))
    x0, x1 = x0 + (x1 - x0) * r.uniform(0, 0.3), x1 - (x1 - x0) * r.uniform(0, 0.3)
    y0, y1 = y0 + (y1 - y0) * r.uniform(0, 0.3), y1 - (y1 - y0) * r.uniform(0, 0.3)
    xm, ym = (x0 + x1) / 2, (y0 + y1) / 2
    lines = [
        ((x0, y0), (x1, y1)),
        ((x1, y0), (x0, y1)),
        ((x0, y0), (x1, y0)),
        ((x0, y1), (x1, y1)),
        ((x0, y0), (x0, y1)),
        ((x1, y0), (x1, y1)),
        ((x0, ym), (x1, ym)),
        ((xm, y0), (xm, y1)),
    ]
    pts = []
    for k, (p, q) in enumerate(lines, 1):
        for s in np.linspace(-0.01, 1, n + 1):
            place = at.copy()
            place[a], place[b] = np.round(np.array(p) + max(s, 0.0) * (np.array(q) - p), 3)
            if s < 0:  # from a little before the line's first target
                place[a], place[b] = np.round(np.array(p) - 0.01 * (np.array(q) - p), 3)
            pts.append((place, k if s >= 0 else 0))
    sens = np.zeros(3)
    sens[up] = 1.0
    meta = header_meta(
        m,
        quantity="straightness",
        sensitive=sens,
        rotvec=np.zeros(3),
        along=a,
        instrument="straightness interferometer",
        pattern="union jack",
    )
    return captures(m, name, pts, logu(r, 300, m.vmax), t0, r.uniform(2, 5), meta, r)


def standing(r: Rng, m: Machine, t0: float, name: str) -> Rec:
    """One to three places, each stood at for a long time, one after another; between two of them
    the axis is worked."""
    ax = int(pick(r, m.axes))
    lo, hi = usable(m, ax)
    places, n, at = int(r.integers(1, 4)), int(r.integers(12, 70)), inside(m, r)
    runs = places * int(r.integers(1, 4))
    xs, pts = np.round(np.linspace(lo, hi, places + 1)[1:], 3), []
    for k in range(1, runs + 1):
        p = at.copy()
        p[ax] = xs[(k - 1) % places]
        before = p.copy()
        before[ax] -= 0.01 * (hi - lo)
        pts += [(before, 0), *[(p, k)] * n]
    sens = np.zeros(3)
    sens[ax if r.random() < 0.7 else pick(r, m.axes)] = 1.0
    meta = header_meta(
        m,
        quantity="displacement",
        sensitive=sens,
        rotvec=np.zeros(3),
        along=ax,
        instrument="laser interferometer",
        pattern="standing",
    )
    feed = logu(r, 500, m.vmax)
    gaps = dict.fromkeys(range(2, runs + 1), float(r.uniform(200, 1800)))
    cycle = (ax, feed / 60 * r.uniform(0.3, 0.9))
    return captures(m, name, pts, feed, t0, logu(r, 20, 240), meta, r, gaps, cycle)


def circle(r: Rng, m: Machine, t0: float, name: str) -> Rec:
    """Arcs of 90 to 720 degrees, senses in blocks, radii that no kit has."""
    plane = [0, 2] if len(m.axes) == 2 else pick(r, [[0, 1], [0, 2], [1, 2]])
    room = min(m.travel[a][1] - m.travel[a][0] for a in plane)
    radius = float(pick(r, [x for x in (7.5, 12.7, 30, 75, 125, 200, 250, 500) if x < room * 0.44]))
    arc = float(pick(r, [90, 120, 270, 360, 720]))
    feed = float(round(logu(r, 100, 6000)))
    senses = pick(r, [[1, 1, -1, -1], [-1, 1], [1, 1, 1], [-1, -1, 1], [1, -1, -1, 1]])
    n, speed = int(pick(r, [240, 400, 600, 900])), feed / 60
    centre, first = inside(m, r, 0.47, 0.53), 90.0 * int(r.integers(4)) + r.uniform(-5, 5)
    u, t, rows = np.linspace(0, arc, n), t0, []
    for run, s in enumerate(senses, 1):
        phi = np.radians(first + (0 if s > 0 else arc) + s * u)
        tt = t + np.radians(u) * radius / speed
        rows.append((tt, phi, np.full(n, run), np.full(n, s)))
        t = tt[-1] + r.uniform(5, 60)
    tt, phi, runs, sense = (np.concatenate(x) for x in zip(*rows, strict=True))
    unit, tang = np.zeros((len(tt), 3)), np.zeros((len(tt), 3))
    unit[:, plane[0]], unit[:, plane[1]] = np.cos(phi), np.sin(phi)
    tang[:, plane[0]], tang[:, plane[1]] = -np.sin(phi), np.cos(phi)
    pos = centre + radius * unit
    meta = header_meta(
        m,
        plane=plane,
        unit=unit,
        centre=centre,
        radius=radius,
        feed=feed,
        sense=sense,
        instrument="ballbar",
        arc=arc,
    )
    return Rec(
        name,
        "ballbar",
        np.round(tt, 4),
        pos,
        speed * sense[:, None] * tang,
        -(speed**2) / radius * unit,
        runs,
        pos,
        tt,
        np.arange(len(tt)),
        np.full(len(tt), feed),
        meta,
    ).finish()


def sweep(t: Array, room: float, top: float) -> Array:
    """A swept sine (mm) of at most `room` mm and about `top` mm/s that fades in."""
    dur, step = float(t[-1]), float(t[1])
    f0 = 2 / dur
    f1 = min(6 * f0 + 2.0, 0.05 / step)
    rate = f0 * (max(f1, 2 * f0) / f0) ** (t / dur)
    size = np.minimum(room, top / (2 * np.pi * rate)) * np.clip(t * f0, 0, 1) ** 2
    return size * np.sin(2 * np.pi * np.cumsum(rate) * step)


def eight(t: Array, room: float, top: float) -> tuple[Array, Array]:
    """Both axes (mm) of a figure of eight that grows during its first turn."""
    dur = float(t[-1])
    size = min(room, top * dur / 20)
    f = min(6 / dur, top / (2 * np.pi * size))
    grow = np.clip(t * f, 0, 1)
    th, size = 2 * np.pi * f * t, size * grow**2 * (3 - 2 * grow)
    return size * np.sin(th), size / 2 * np.sin(2 * th)


Goal = tuple[float, float, float]  # places along two axes from the middle, mm; feed, mm/min


def steps(r: Rng, room: float, top: float, dur: float) -> list[Goal]:
    """Ten steps up and ten down, of 1 to 100 um, another size every time."""
    size = 10 ** r.uniform(-3, -1, 20)
    k = np.arange(400)
    x = np.cumsum(size[k // 20] * np.where(k // 10 % 2 == 0, 1, -1))
    return [(float(v), 0.0, 100.0) for v in x]


def ladder(r: Rng, room: float, top: float, dur: float) -> list[Goal]:
    """To and fro at one speed after another, twelve of them up to the top one, and again."""
    speeds = top * (1 + np.arange(120) // 2 % 12) / 12
    side = np.minimum(room, speeds * dur / 14) / 2
    return [
        (float(d if k % 2 else -d), 0.0, float(60 * v))
        for k, (v, d) in enumerate(zip(speeds, side, strict=True))
    ]


def growing(r: Rng, room: float, top: float, dur: float) -> list[Goal]:
    """To and fro, each time by a third more, from 0.02 mm on; then all over again."""
    n = 2 + int(np.log(max(room, 1.0) / 0.02) / np.log(1.35))
    return [
        (float(min(0.02 * 1.35 ** (k % n), room) * (1 if k % 2 else -1)), 0.0, 15 * top)
        for k in range(200)
    ]


def square(r: Rng, room: float, top: float, dur: float) -> list[Goal]:
    """Four sides at an angle of 3 to 40 degrees to the axes."""
    side, th = min(room, top * dur / 12), np.radians(r.uniform(3, 40))
    corner = side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) - side / 2
    turn = np.array([[np.cos(th), np.sin(th)], [-np.sin(th), np.cos(th)]])
    way = (corner @ turn)[np.arange(200) % 4]
    return [(float(x), float(y), 60 * top) for x, y in way]


STOPS = {"steps": steps, "ladder": ladder, "growing": growing, "square": square}


def motion_path(r: Rng, m: Machine, kind: str, fs: float, n: int, acc: float) -> Array:
    """n places of a path; one that is too short goes on at rest at its end."""
    use, at = [int(a) for a in r.permutation(m.axes)], inside(m, r, 0.4, 0.6)
    room = min(float(np.ptp(m.travel[a])) for a in use[:2]) * 0.25
    e0, e1, t, top = np.eye(3)[use[0]], np.eye(3)[use[1]], np.arange(n) / fs, logu(r, 5, 100)
    if kind == "sweep":
        return at + np.outer(sweep(t, room, top), e0)
    if kind == "eight":
        x, y = eight(t, room, top)
        return at + np.outer(x, e0) + np.outer(y, e1)
    p, here = [np.tile(at, (max(1, int(fs * 0.4)), 1))], at
    for x, y, feed in STOPS[kind](r, room, top, n / fs):
        goal = at + x * e0 + y * e1
        d = float(np.linalg.norm(goal - here))
        if d > 1e-6:
            p.append(here + np.outer(ramp(d, feed / 60, acc, 1 / fs) / d, goal - here))
        p.append(np.tile(goal, (int(fs * r.uniform(0.1, 0.6)), 1)))
        here = goal
        if sum(map(len, p)) >= n:
            break
    whole = np.concatenate(p)[:n]
    return np.concatenate([whole, np.tile(whole[-1], (n - len(whole), 1))])


def in_motion(r: Rng, m: Machine, t0: float, name: str, sees: str) -> Rec:
    """Samples of one of six paths at rates that the other families do not have."""
    kind = pick(r, ["sweep", "eight", *STOPS])
    fs, n = float(pick(r, [25, 40, 80, 125, 250, 400])), int(logu(r, 2000, 9000))
    pos = np.round(motion_path(r, m, kind, fs, n, m.amax * r.uniform(0.2, 0.8)), 6)
    for a in m.axes:
        pos[:, a] = np.clip(pos[:, a], *m.travel[a])
    dt, tt = 1 / fs, np.round(t0 + np.arange(n) / fs, 5)
    vel = np.gradient(pos, dt, axis=0)
    win = max(1, int(0.02 * fs))
    flat = np.apply_along_axis(np.convolve, 0, vel, np.ones(win) / win, "same")
    feed = max(float(np.linalg.norm(vel, axis=1).max()) * 60, 1.0)
    tool = pick(r, ["grid encoder", "R-test", "laser in motion"]) if sees == "tool" else "control"
    meta = header_meta(m, sees=sees, instrument=tool, rate=fs, path=kind, feed=feed)
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
        np.full(n, feed),
        meta,
    ).finish()


def draw(r: Rng, m: Machine, kind: str, t0: float, name: str) -> Rec | None:
    """A file of a new design in three of four cases; None leaves it to the old ones."""
    if kind in ("features", "diagonal") or r.random() < 0.25:
        return None
    if kind == "ballbar":
        return circle(r, m, t0, name)
    if kind.startswith("trace"):
        return in_motion(r, m, t0, name, kind[6:])
    if kind == "straightness" and len(m.axes) == 3 and r.random() < 0.4:
        return union_jack(r, m, t0, name)
    if kind == "long" and r.random() < 0.35:
        return standing(r, m, t0, name)
    ax = int(pick(r, m.axes))
    force = at_rest(r, m, kind, ax)
    if kind == "long":
        force |= {"laser": True, "gap": pick(r, [240.0, 450.0, 900.0, 3000.0])}
        force["runs"] = min(int(force["runs"]), 14)
    return targets(r, m, ax, t0, name, "displacement" if kind == "long" else kind, force=force)
