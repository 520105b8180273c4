"""Recordings at rest and on circles: laser, straightness, angle, diagonals, ballbar, parts.

Target orders: ISO 230-2:2014 standard cycle with overrun, its step cycle, pilgrim step, random
order, one direction only.  Diagonals: ISO 230-6; step diagonal (held): Wang 2000.  Circles:
ISO 230-4.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Rec, Rng, logu, pick
from .machines import Machine

# orders filed elsewhere
ORDERS: dict[str, Callable[[Array, int, float], list[tuple[float, int]]]] = {}


def header_meta(m: Machine, **kw: object) -> dict:
    """Common entries of Rec.meta."""
    return {"axes": m.axes, **kw}


def inside(m: Machine, r: Rng, lo: float = 0.1, hi: float = 0.9) -> Array:
    """A random place within the travels, mm."""
    p = np.zeros(3)
    for a in m.axes:
        s, e = m.travel[a]
        p[a] = round(float(s + (e - s) * r.uniform(lo, hi)), 1)
    return p


def order(r: Rng, p: Array, pattern: str, runs: int, over: float) -> list[tuple[float, int]]:
    """Positions along one axis with run number (0 = pass without capture)."""
    out: list[tuple[float, int]] = []
    for k in range(1, runs + 1):
        if pattern == "iso":
            out += [(p[0] - over, 0)] + [(x, k) for x in p] + [(p[-1] + over, 0)]
            out += [(x, k) for x in p[::-1]]
        elif pattern == "uni":
            out += [(p[0] - over, 0)] + [(x, k) for x in p]
        elif pattern == "pilgrim":
            out += [(p[0] - over, 0), (p[0], k)]
            for i in range(len(p) - 1):
                out += [(p[i + 1], k), (p[i], k), (p[i + 1], k)]
        elif pattern == "random":
            out += [(p[0] - over, 0)] + [(x, k) for x in r.permutation(p)]
        elif pattern in ORDERS:
            out += ORDERS[pattern](p, k, over)
        else:
            for x in p:
                out += [(x - over, 0), (x, k), (x + over, 0), (x, k)]
    keep = [out[0]]
    for q in out[1:]:
        if abs(q[0] - keep[-1][0]) > 1e-9:
            keep.append(q)
    return keep


def captures(
    m: Machine,
    name: str,
    points: list[tuple[Array, int]],
    feed: float | Array,
    t0: float,
    dwell: float,
    meta: dict,
    r: Rng,
    gaps: dict[int, float] | None = None,
    cycle: tuple[int, float] | None = None,
) -> Rec:
    """A targets file from places with run numbers; feed mm/min; gap s before a run starts.

    cycle = (axis, mm/s): the axis is exercised during those gaps (ISO 230-3, clause 7).
    """
    park = inside(m, r) + np.where(np.isin([0, 1, 2], m.axes), 0.037, 0.0)
    via, via_t, rows, run, feeds, activity = [park], [t0], [], [], [], []
    t, last = t0, 1
    for i, (p, k) in enumerate(points):
        if k > last:
            wait = (gaps or {}).get(k, 0.0)
            if cycle and wait > 60:
                activity.append((t, t + wait, cycle[0], cycle[1]))
            t, last = t + wait, k
        f = feed[i] if isinstance(feed, np.ndarray) else feed
        t += np.linalg.norm(p - via[-1]) / (f / 60) + 0.3
        via.append(p)
        if k:
            t += dwell * r.uniform(0.9, 1.2)
            rows.append(len(via) - 1)
            run.append(k)
            feeds.append(f)
        via_t.append(t)
    v, vt, idx = np.array(via), np.array(via_t), np.array(rows)
    n = len(idx)
    return Rec(
        name,
        "targets",
        np.round(vt[idx], 2),
        v[idx],
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        np.array(run),
        v,
        vt,
        idx,
        np.array(feeds),
        meta,
        activity=activity,
    ).finish()


def targets(
    r: Rng,
    m: Machine,
    ax: int,
    t0: float,
    name: str,
    quantity: str = "displacement",
    held: bool = False,
    force: dict | None = None,
) -> Rec:
    """A run along one axis; `force` overrides draws (pattern, n, runs, gap, positions, at)."""
    o = force or {}
    lo, hi = m.travel[ax]
    n = int(o.get("n", 5 if held and r.random() < 0.4 else round(logu(r, 5, 200))))
    runs = int(o.get("runs", max(1, min(5, int(r.integers(1, 6)), 1200 // n))))
    pattern = o.get("pattern", pick(r, ["iso", "iso", "iso", "uni", "pilgrim", "random", "step"]))
    over = round(min(logu(r, 0.3, 8), (hi - lo) * 0.02), 2)
    a, b = sorted(r.uniform([0.03, 0.75], [0.2, 0.97]))
    p = np.linspace(lo + (hi - lo) * a, lo + (hi - lo) * b, n)
    if r.random() < 0.6:
        p = p + r.uniform(-0.3, 0.3, n) * (p[1] - p[0])
    edge = 0.022 * (hi - lo)
    p = np.round(o.get("positions", np.clip(p, lo + edge, hi - edge)), 3)
    at = o.get("at", inside(m, r))
    pts = []
    for x, k in order(r, p, pattern, runs, over):
        q = at.copy()
        q[ax] = x
        pts.append((q, k))
    others = [c for c in m.axes if c != ax]
    sens, rot = np.zeros(3), np.zeros(3)
    if quantity == "displacement":
        sens[ax] = 1.0
    elif quantity == "straightness":
        sens[o.get("across", pick(r, others))] = 1.0
    else:
        rot[o.get("about", 1 if len(m.axes) == 2 else pick(r, [0, 1, 2]))] = 1.0
    tool = {
        "displacement": ["laser interferometer", "laser tracer", "step gauge"],
        "straightness": ["straightedge and probe", "laser straightness optics"],
        "angle": ["autocollimator", "electronic level"],
    }[quantity]
    meta = header_meta(
        m,
        quantity=quantity,
        sensitive=sens,
        rotvec=rot,
        along=ax,
        instrument=tool[0] if o.get("laser") else pick(r, tool),
        pattern=pattern,
    )
    feed = logu(r, 300, m.vmax)
    f: float | Array = feed
    if held and r.random() < 0.5:
        f = feed * r.choice([0.3, 0.6, 1.0], len(pts))
    gaps = {k: o.get("gap", 0.0) * float(r.uniform(0.7, 1.3)) for k in range(2, runs + 1)}
    cycle = (ax, feed / 60 * r.uniform(0.3, 0.9)) if o.get("gap", 0) > 0 else None
    return captures(m, name, pts, f, t0, r.uniform(2, 5), meta, r, gaps, cycle)


def diagonal(r: Rng, m: Machine, t0: float, name: str, step: bool = False) -> Rec:
    """Body or face diagonal; `step` moves one axis at a time and captures after each move."""
    use = m.axes if r.random() < 0.6 else sorted(r.permutation(m.axes)[:2])
    flip = np.where(r.random(3) < 0.5, -1.0, 1.0)
    n, runs = int(r.integers(5, 41)), int(r.integers(1, 4))
    base, d = inside(m, r), np.zeros(3)
    for a in use:
        lo, hi = m.travel[a]
        d[a] = flip[a] * (hi - lo) * 0.8
        base[a] = lo + (hi - lo) * (0.1 if flip[a] > 0 else 0.9)
    pts = []
    for k in range(1, runs + 1):
        pts.append((np.round(base - 0.03 * d, 4), 0))
        if step:
            p = base.copy()
            for _ in range(n):
                for a in use:
                    p = p.copy()
                    p[a] += d[a] / n
                    pts.append((np.round(p, 4), k))
        else:
            s = np.linspace(0, 1, n)
            pts += [(np.round(base + x * d, 4), k) for x in s]
            if r.random() < 0.7:
                pts.append((np.round(base + 1.03 * d, 4), 0))
                pts += [(np.round(base + x * d, 4), k) for x in s[::-1]]
    unit = d / np.linalg.norm(d)
    meta = header_meta(
        m,
        quantity="displacement",
        sensitive=unit,
        rotvec=np.zeros(3),
        along=use[0],
        instrument="laser interferometer",
        pattern="step-diagonal" if step else "diagonal",
    )
    return captures(m, name, pts, logu(r, 500, m.vmax), t0, r.uniform(2, 5), meta, r)


def ballbar(
    r: Rng, m: Machine, t0: float, name: str, held: bool = False, force: dict | None = None
) -> Rec:
    """A circular test in one plane, one or both senses, 1-3 repeats."""
    o = force or {}
    flat = [[0, 2]] if len(m.axes) == 2 else [[0, 1], [0, 1], [0, 2], [1, 2]]
    plane = o["plane"] if "plane" in o else pick(r, flat)
    room = min(m.travel[a][1] - m.travel[a][0] for a in plane)
    radius = float(pick(r, [x for x in (20, 50, 100, 150, 300) if x < room * 0.45] or [20]))
    radius = float(o.get("radius", radius))
    arc = 180.0 if held and r.random() < 0.5 else float(pick(r, [360, 360, 360, 220]))
    arc = float(o.get("arc", arc))
    feed = float(o.get("feed", round(logu(r, 200, 5000))))
    senses = o.get("senses", pick(r, [[1, -1], [1, -1], [1, -1], [1], [-1]]))
    n = int(pick(r, [360, 500, 720, 1000, 1440]))
    centre, reps, first = inside(m, r, 0.47, 0.53), int(r.integers(1, 4)), r.uniform(0, 360)
    centre, reps = o.get("centre", centre), int(o.get("reps", reps))
    t, rows, run = t0, [], 0
    speed = feed / 60
    for _ in range(reps):
        for s in senses:
            run += 1
            phi = np.radians(first + (0 if s > 0 else arc) + s * np.linspace(0, arc, n))
            w = s * speed / radius
            tt = t + np.radians(np.linspace(0, arc, n)) * radius / speed
            rows.append((tt, phi, np.full(n, w), np.full(n, run), np.full(n, s)))
            t = tt[-1] + r.uniform(5, 30)
    tt, phi, w, runs, sense = (np.concatenate(x) for x in zip(*rows, strict=False))
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
        sense=sense.astype(int),
        instrument="ballbar",
        arc=arc,
    )
    return Rec(
        name,
        "ballbar",
        np.round(tt, 4),
        pos,
        radius * w[:, None] * tang,
        -radius * w[:, None] ** 2 * unit,
        runs,
        pos,
        tt,
        np.arange(len(tt)),
        np.full(len(tt), feed),
        meta,
    ).finish()


def features(r: Rng, m: Machine, t0: float, name: str) -> Rec:
    """Parts cut one after another and measured on a CMM; two contact states for each reading.

    Pocket and bore walls are met moving outwards, boss walls moving inwards, holes of a
    centre distance all from one side.  `radial` is how often a tool diameter error enters.
    """
    parts, reads = int(r.integers(2, 9)), int(r.integers(1, 4))
    use = m.axes[:2] if len(m.axes) == 3 else m.axes
    kinds = ["centre_distance", "pocket_size", "boss_diameter", "bore_diameter", "step"]
    kinds = ["centre_distance", *r.permutation(kinds[1:])[: int(r.integers(1, 4))]]
    plan = []
    for kind in kinds:
        for a in use if kind != "step" else [m.axes[-1]]:
            lo, hi = m.travel[a]
            for _ in range(int(r.integers(1, 4 if kind == "centre_distance" else 3))):
                size = round((hi - lo) * r.uniform(0.05, 0.6), 0) or 10.0
                size = min(size, 60.0) if "diameter" in kind or kind == "step" else size
                plan.append((kind, a, size, round(lo + (hi - lo) * r.uniform(0.1, 0.35), 1)))
    via, vt, t = [inside(m, r)], [t0], t0
    idx, rows, info = [], [], []
    cut = logu(r, 3, 30)
    gap = float(pick(r, [60.0, 300.0, 1200.0]))
    for part in range(1, parts + 1):
        for f, (kind, a, size, start) in enumerate(plan):
            for end, x in ((-1, start), (1, start + size)):
                out = {"pocket_size": end, "bore_diameter": end, "boss_diameter": -end}
                s = out.get(kind, 1 if kind == "centre_distance" else -1)
                p = via[-1].copy()
                p[a] = x - s * 4.0
                via.append(p)
                p = p.copy()
                p[a] = x
                via.append(p)
                t += r.uniform(8, 40)
                vt += [t - 2, t]
                idx.append(len(via) - 1)
            for k in range(1, reads + 1):
                rows.append((len(idx) - 2, len(idx) - 1))
                rad = {"pocket_size": 1, "bore_diameter": 1, "boss_diameter": -1}.get(kind, 0)
                info.append((f + 1, kind, a, size, part, k, rad))
        t += gap * r.uniform(0.8, 1.2)
    v, vta = np.array(via), np.array(vt)
    row_at = np.array(idx)[np.array(rows).ravel()]
    n, d = len(row_at), np.zeros((len(rows), 3))
    d[np.arange(len(rows)), [i[2] for i in info]] = 1.0
    part_no = np.array([i[4] for i in info])
    change = int(r.integers(2, parts + 1)) if r.random() < 0.6 else parts + 1
    meta = header_meta(
        m,
        info=info,
        direction=d,
        instrument="coordinate measuring machine",
        cut=cut,
        change=change,
        part=part_no,
        radial=np.array([i[6] for i in info], float),
    )
    return Rec(
        name,
        "features",
        np.round(vta[row_at], 1),
        v[row_at],
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        np.ones(n, int),
        v,
        vta,
        row_at,
        np.full(n, 800.0),
        meta,
    ).finish()
