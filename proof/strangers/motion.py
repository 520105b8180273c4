"""Trajectories for traces: jogs, circles, rasters, creep, sinusoids, with bounded acceleration.

Rest-to-rest moves use a trapezoid of speed smoothed by the sampling (textbook: Biagiotti and
Melchiorri, Trajectory Planning, 2008).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, logu, pick
from .designs import header_meta, inside
from .machines import Machine


def ramp(dist: float, v: float, a: float, dt: float) -> Array:
    """Distances (mm) at each sample of a smooth rest-to-rest move with peak speed v, acc a."""
    v = min(v, np.sqrt(dist * a * 0.8))
    ta = v / a
    total = dist / v + ta
    t = np.arange(dt, total + dt, dt)
    up = np.clip(t / ta, 0, 1)
    down = np.clip((t - (total - ta)) / ta, 0, 1)

    def area(u: Array) -> Array:
        return ta * (u**3 - u**4 / 2)  # integral of the smooth step 3u^2 - 2u^3

    s = v * (area(up) + np.maximum(t - ta, 0) - area(down) - np.maximum(t - total, 0))
    return np.clip(s * dist / max(s[-1], 1e-12), 0, dist)


def trace(
    r: Rng,
    m: Machine,
    t0: float,
    name: str,
    sees: str,
    held: bool = False,
    force: dict | None = None,
) -> Rec:
    """Samples in motion, 2000 to about 13000 rows."""
    o = force or {}
    fs = float(o.get("rate", pick(r, [20, 50, 100, 200, 500, 1000])))
    n = int(o.get("rows", logu(r, 2000, 13000)))
    dt, dur = 1 / fs, n / fs
    kind = o.get("path", pick(r, ["jog", "jog", "circle", "raster", "creep", "sine", "path"]))
    use = list(r.permutation(m.axes))
    ax = int(use[0])
    at = inside(m, r, 0.35, 0.6)
    room = {a: m.travel[a][1] - m.travel[a][0] for a in m.axes}
    feed = float(o.get("feed", logu(r, 20, 300) if kind == "creep" else logu(r, 200, 6000)))
    v, acc = feed / 60, m.amax * r.uniform(0.2, 0.8)
    pos = np.tile(at, (n, 1))
    t = np.arange(n) * dt
    if kind in ("circle", "sine"):
        radius = min(room[use[0]], room[use[1]]) * r.uniform(0.05, 0.3)
        radius = min(radius, max(2.0, v * dur / 6 / np.pi))
        w = v / radius
        if kind == "circle":
            half = n // 2 if r.random() < 0.7 else n
            s = ramp(v * dt * half * 0.85, v, acc, dt)[:half]
            s = np.r_[s, np.full(half - len(s), s[-1])]
            ang = np.r_[s, s[::-1], np.full(n, s[0])][:n] / radius
            pos[:, use[0]] += radius * np.cos(ang)
            pos[:, use[1]] += radius * np.sin(ang)
        else:
            grow = np.clip(t * w / np.pi, 0, 1)
            grow = grow * grow * (3 - 2 * grow)
            f1, f2 = w / 2 / np.pi * np.array([1.0, r.uniform(0.4, 2.2)])
            pos[:, use[0]] += radius * grow * np.sin(2 * np.pi * f1 * t)
            if r.random() < 0.5:
                pos[:, use[1]] += radius * grow * 0.5 * np.sin(2 * np.pi * f2 * t)
    else:
        i = int(fs * 0.5)
        here, step = at.copy(), 0
        sides = dict.fromkeys(m.axes, 1.0)
        many = int(r.integers(4, 14))
        while i < n:
            goal = here.copy()
            if kind == "raster" and step % 2 and len(use) > 1:
                goal[use[1]] += room[use[1]] * 0.25 / many * (1 if step < 2 * many else -1)
                goal[use[1]] = np.clip(
                    goal[use[1]], at[use[1]] - room[use[1]] * 0.2, at[use[1]] + room[use[1]] * 0.2
                )
            elif kind == "path":
                for a in m.axes:
                    goal[a] = at[a] + room[a] * r.uniform(-0.2, 0.2)
            else:
                sides[ax] = -sides[ax]
                goal[ax] = at[ax] + sides[ax] * min(room[ax] * 0.25, v * dur / 8)
            d = float(np.linalg.norm(goal - here))
            step += 1
            if d > 1e-6:
                vv = v * (pick(r, [0.3, 0.6, 1.0]) if held else 1.0)
                s = ramp(d, vv, acc, dt)
                k = min(len(s), n - i)
                pos[i : i + k] = here + np.outer(s[:k] / d, goal - here)
                i, here = i + k, pos[i + k - 1].copy()
            k = min(n - i, int(fs * r.uniform(0.05, 1.0)))
            pos[i : i + k] = here
            i += k
    pos = np.round(pos, 6)
    vel = np.gradient(pos, dt, axis=0)
    win = max(1, int(0.02 * fs))
    accel = np.gradient(
        np.apply_along_axis(np.convolve, 0, vel, np.ones(win) / win, "same"), dt, axis=0
    )
    tool = ["grid encoder", "R-test", "laser in motion"] if sees == "tool" else ["control"]
    meta = header_meta(m, sees=sees, instrument=pick(r, tool), rate=fs, path=kind, feed=feed)
    tt = np.round(t0 + t, 5)
    return Rec(
        name,
        "trace",
        tt,
        pos,
        vel,
        accel,
        np.ones(n, int),
        pos,
        tt,
        np.arange(n),
        np.full(n, feed),
        meta,
    ).finish()
