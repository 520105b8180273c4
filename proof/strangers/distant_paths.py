"""Files of the distant family: at rest and in motion. Do not read while working on the judged tool.

Sources: ISO 230-2:2014 (five runs in both directions, targets at unlike distances; step and pilgrim
cycles), ISO 10791-4 and ISO/TR 230-11 (reversal and smallest motion: steps after a reversal), ISO
230-3:2020 (clause 5: standing instrument in the environment alone; clause 7: an axis at work), ISO
230-1:2012 (lines at several places of the other axes; loads put on), ISO 230-6 (diagonals), ISO
230-4 (circles, their feeds), Altintas and Erkorkmaz 2001 (High speed CNC system design, part II:
jogs at many speeds to tell friction), Knapp 1997 (cross grid encoder: corners, circles, spirals).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Rec, Rng, logu, pick
from .designs import ballbar, captures, features, header_meta, inside, targets
from .machines import Machine
from .motion import ramp

Make = Callable[[float, str], Rec]
Leg = tuple[float, float, float]  # u, v (mm from the middle), feed (mm/min)


def room_of(m: Machine, ax: int) -> tuple[float, float]:
    """What is left of a travel when every overrun stays within it, mm."""
    lo, hi = m.travel[ax]
    return lo + 0.035 * (hi - lo), hi - 0.035 * (hi - lo)


def scattered(r: Rng, m: Machine, ax: int, n: int) -> Array:
    """Targets over the travel, each off an even row by up to a third of a step (ISO 230-2), mm."""
    lo, hi = room_of(m, ax)
    step = (hi - lo) / n
    return np.round(lo + step * (np.arange(n) + 0.5 + r.uniform(-0.33, 0.33, n)), 3)


def line(r: Rng, m: Machine, ax: int, quantity: str = "displacement", **force: object) -> Make:
    """Targets along an axis; `force` as in targets, by default 5 runs in both directions."""
    n = int(force.pop("n", r.integers(9, 22)))  # type: ignore[call-overload]
    full = {
        "n": n,
        "positions": scattered(r, m, ax, n),
        "runs": 5,
        "pattern": "iso",
        "at": inside(m, r, 0.2, 0.8),
        "laser": True,
        **force,
    }
    full["n"] = len(full["positions"])
    return lambda t, name: targets(r, m, ax, t, name, quantity, force=full)


def parallel_lines(r: Rng, m: Machine, ax: int) -> list[Make]:
    """The same targets along an axis with another one near either end of its travel, and the angle
    that makes these two differ."""
    later = m.order()[m.order().index(ax) + 1 :]  # these change its arm
    to = int(pick(r, later or [a for a in m.axes if a != ax]))
    (lo, hi), at, out = room_of(m, to), inside(m, r, 0.3, 0.7), []
    p, runs = scattered(r, m, ax, int(r.integers(9, 18))), int(r.integers(2, 4))
    for share in (0.05, 0.95):
        here = at.copy()
        here[to] = round(lo + share * (hi - lo), 1)
        out.append(line(r, m, ax, positions=p, runs=runs, at=here))
    about = 1 if len(m.axes) == 2 else 3 - ax - to
    return [*out, line(r, m, ax, "angle", positions=p, runs=2, about=about)]


def heading(m: Machine, sens: Array, ax: int, tool: str, what: str) -> dict:
    """Header of a file of displacements at rest."""
    zero = np.zeros(3)
    head = {"quantity": "displacement", "sensitive": sens, "rotvec": zero, "along": ax}
    return header_meta(m, **head, instrument=tool, pattern=what)


def after_a_reversal(r: Rng, m: Machine, ax: int) -> Make:
    """Readings 2 um to 3 mm behind a reversal, both ways, about two or three places."""
    at, unit, (lo, hi) = inside(m, r, 0.3, 0.7), np.eye(3)[ax], room_of(m, ax)
    steps = np.unique(np.round(np.geomspace(0.002, 3.0, int(r.integers(8, 13))), 3))
    tool = str(pick(r, ["laser interferometer", "capacitive sensor", "inductive probe"]))
    pts = []
    for k, s in enumerate(r.uniform(0.15, 0.85, int(r.integers(2, 4))), 1):
        c = at.copy()
        c[ax] = round(lo + s * (hi - lo), 2)
        for d in (1.0, -1.0):
            pts += [(np.round(c - d * 0.5 * unit, 4), 0), (np.round(c + d * 4 * unit, 4), 0)]
            pts += [(c.copy(), k)] + [(np.round(c - d * x * unit, 4), k) for x in steps]
    meta = heading(m, unit, ax, tool, "reversal")
    return lambda t, name: captures(m, name, pts, 150.0, t, float(r.uniform(2, 5)), meta, r)


def standing(r: Rng, m: Machine, ax: int, every: float, n: int, light: bool) -> Make:
    """One place, read again and again; nothing moves.  `light`: perhaps by a laser."""
    at = inside(m, r, 0.3, 0.7)
    before = at - np.where(np.isin([0, 1, 2], m.axes), 1.5, 0.0)
    tools = ["capacitive sensor", "inductive probe", "laser interferometer"]
    tool = str(pick(r, tools if light else tools[:2]))
    meta = heading(m, np.eye(3)[ax], ax, tool, "standing")
    pts = [(before, 0), *[(at, 1)] * n]
    return lambda t, name: captures(m, name, pts, 800.0, t, every, meta, r)


def heat_run(r: Rng, m: Machine, ax: int, share: float | None = None) -> Make:
    """Two to five targets every few minutes; the axis works for a share of the time and stands for
    the rest."""
    n, (lo, hi) = int(r.integers(2, 6)), room_of(m, ax)
    at_work = r.uniform(0.45, 0.9) if share is None else share
    s = np.sort(r.choice(np.arange(1, 24), n, False)) / 24
    s[0], s[-1] = min(s[0], 0.15), max(s[-1], 0.85)
    make = line(
        r,
        m,
        ax,
        positions=np.round(lo + (hi - lo) * s, 1),
        runs=int(r.integers(10, 21)),
        gap=float(pick(r, [180.0, 300.0, 600.0])),
        at=inside(m, r, 0.3, 0.7),
    )

    def run(t: float, name: str) -> Rec:
        q = make(t, name)
        stop = q.t[0] + at_work * np.ptp(q.t)
        q.activity = [x for x in q.activity if x[0] < stop]
        return q

    return run


def close_by(r: Rng, m: Machine, ax: int) -> Make:
    """Two and a half leads in steps that never fall on the same angle of the screw."""
    (lo, hi), lead = room_of(m, ax), m.lead[ax]
    step = lead / float(r.uniform(10.2, 16.8))
    n = min(42, int(2.5 * lead / step), int(0.95 * (hi - lo) / step))
    first = lo + (hi - lo - n * step) * r.uniform(0.05, 0.95)
    runs = int(r.integers(1, 4))
    return line(r, m, ax, positions=np.round(first + step * np.arange(n), 3), runs=runs)


def body_diagonals(r: Rng, m: Machine) -> list[Make]:
    """Four body diagonals (two of a lathe's plane), there and back once or twice."""
    n, feed, out, runs = int(r.integers(8, 17)), logu(r, 800, m.vmax), [], int(r.integers(1, 3))
    flips = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)][: 4 if len(m.axes) == 3 else 2]
    s = (np.arange(n) + 0.5 + r.uniform(-0.3, 0.3, n)) / n
    for flip in flips:
        base, d = inside(m, r, 0.3, 0.7), np.zeros(3)
        for a, sign in zip(m.axes, flip, strict=False):
            lo, hi = room_of(m, a)
            base[a], d[a] = (lo, hi - lo) if sign > 0 else (hi, lo - hi)
        pts = []
        for k in range(1, runs + 1):
            way = [(0.0, 0), *[(x, k) for x in s], (1.0, 0), *[(x, k) for x in s[::-1]]]
            pts += [(np.round(base + x * d, 4), j) for x, j in way]
        unit = d / np.linalg.norm(d)
        meta = heading(m, unit, m.axes[0], "laser interferometer", "diagonal")
        out.append(
            lambda t, name, pts=pts, meta=meta: captures(m, name, pts, feed, t, 3.0, meta, r)
        )
    return out


def circle(r: Rng, m: Machine, plane: list[int], feed: float, **force: object) -> Make:
    """A circle in both senses, radius by what the travels leave."""
    room = min(float(np.ptp(m.travel[a])) for a in plane)
    radii = [x for x in (25, 50, 100, 150, 200, 300) if x < room * 0.44] or [25]
    full = {
        "plane": plane,
        "radius": float(pick(r, radii[-2:])),
        "centre": inside(m, r, 0.48, 0.52),
        "arc": 360.0,
        "senses": [1, -1],
        "reps": int(r.integers(1, 3)),
        "feed": feed,
        **force,
    }
    return lambda t, name: ballbar(r, m, t, name, force=full)


def batch(r: Rng, m: Machine, least: int) -> Make:
    """Parts of one batch: 12 readings or more of `least` parts or more, some of them with walls."""

    def make(t: float, name: str) -> Rec:
        while True:
            q = features(r, m, t, name)
            walls = int((q.meta["radial"] != 0).sum())
            again = max(i[5] for i in q.meta["info"]) > 1 or r.random() < 0.4
            if q.n_obs >= 12 and walls >= 6 and q.meta["part"].max() >= least and again:
                return q

    return make


def steps_of_speed(r: Rng, room: float, top: float) -> list[Leg]:
    """Along u and v by turns at speeds in a random order, both ways."""
    out: list[Leg] = []
    for _ in range(4):
        for s in r.permutation([0.03, 0.06, 0.12, 0.25, 0.5, 0.8, 1.0]):
            d = min(room, top * s / 60 * 2.5) / 2
            out += [(d, 0.0, top * s), (-d, 0.0, top * s), (0.0, 0.0, top * s)]
            out += [(0.0, 0.6 * d, top * s), (0.0, -0.6 * d, top * s), (0.0, 0.0, top * s)]
    return out


def slants(r: Rng, room: float, top: float) -> list[Leg]:
    """A star of lines at odd angles, each to and fro at one of three feeds."""
    out: list[Leg] = []
    for k in range(40):
        a, s = 2.39996 * k, float(pick(r, [0.2, 0.5, 1.0]))
        d = min(room / 2, top * s / 60 * 2)
        out += [(d * np.cos(a), d * np.sin(a), top * s), (0.0, 0.0, top * s)]
    return out


def creeping_steps(r: Rng, room: float, top: float) -> list[Leg]:
    """Ways at 15 to 400 mm/min, there at one feed, back at another."""
    out: list[Leg] = []
    for _ in range(10):
        for f in r.permutation([15.0, 40.0, 90.0, 180.0, 400.0]):
            d = min(room / 2, f / 60 * 6)
            out += [(d, 0.0, f), (0.0, 0.0, f * float(pick(r, [1.0, 2.0])))]
    return out


def pieces(r: Rng, room: float, top: float) -> list[Leg]:
    """A contour of short blocks, a rounded square that is run both ways round."""
    phi = np.linspace(0, 2 * np.pi, 49)
    q = np.sign(np.c_[np.cos(phi), np.sin(phi)]) * np.abs(np.c_[np.cos(phi), np.sin(phi)]) ** 0.6
    way = 0.4 * min(room, top / 60 * 4) * q
    out: list[Leg] = []
    for k in range(8):
        feed = top * float(pick(r, [0.3, 0.6, 1.0]))
        out += [(float(u), float(v), feed) for u, v in (way if k % 2 == 0 else way[::-1])]
    return out


PATHS = {"speeds": steps_of_speed, "slants": slants, "creep": creeping_steps, "pieces": pieces}


def route(r: Rng, m: Machine, kind: str) -> tuple[Array, float, float]:
    """Commanded positions (n,3) mm, sampling rate Hz, programmed feed mm/min."""
    use, at = [int(a) for a in r.permutation(m.axes)][:2], inside(m, r, 0.42, 0.58)
    room = min(min(float(np.ptp(m.travel[a])) for a in use) * 0.3, 150.0)
    fs = float(pick(r, [100.0, 125.0, 200.0, 250.0]))
    top = min(float(pick(r, [2000.0, 4000.0, 8000.0])), 0.95 * m.vmax)
    n = int(np.clip(fs * r.uniform(20, 50), 2500, 9000))
    acc, e, here = m.amax * r.uniform(0.3, 0.9), np.eye(3)[use], at
    p = [np.tile(at, (int(fs * r.uniform(0.5, 1.5)), 1))]
    for u, v, feed in PATHS[kind](r, room, top):
        goal = at + np.array([u, v]) @ e
        d = float(np.linalg.norm(goal - here))
        if d > 1e-6:
            p.append(here + np.outer(ramp(d, feed / 60, acc, 1 / fs) / d, goal - here))
        rest = 0.0 if kind == "pieces" else r.uniform(0.05, 0.6)
        p.append(np.tile(goal, (int(fs * rest), 1)))
        here = goal
        if sum(map(len, p)) >= n:
            break
    pos = np.concatenate(p)[:n]
    return np.round(np.concatenate([pos, np.tile(pos[-1], (n - len(pos), 1))]), 6), fs, top


def sampled(
    m: Machine, pos: Array, fs: float, top: float, sees: str, what: str, amps: bool
) -> Make:
    """A route as a control or a grid plate samples it; `amps`: the control logs its currents."""
    tool = "grid encoder" if sees == "tool" else "control"
    meta = header_meta(m, sees=sees, instrument=tool, rate=fs, path=what, feed=top, amps=amps)
    vel, win = np.gradient(pos, 1 / fs, axis=0), np.ones(max(1, int(0.02 * fs)))
    flat = np.apply_along_axis(np.convolve, 0, vel, win / len(win), "same")
    acc = np.gradient(flat, 1 / fs, axis=0)
    n = len(pos)

    def make(t0: float, name: str) -> Rec:
        t = np.round(t0 + np.arange(n) / fs, 5)
        one = np.ones(n, int)
        args = (t, pos, vel, acc, one, pos, t, np.arange(n), np.full(n, top), dict(meta))
        return Rec(name, "trace", *args).finish()

    return make
