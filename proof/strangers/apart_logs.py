"""Logs of a control or of a grid encoder, plans of tests of the apart family.  Do not read while
working on the judged tool.

Lines to and fro at several feeds (Erkorkmaz and Altintas 2001), circles (ISO 230-4) and crawls, at
sampling rates of controllers' own oscilloscopes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from .base import Array, Rec, Rng, pick
from .designs import header_meta, inside
from .machines import Machine
from .motion import ramp, trace

Make = Callable[[float, str], Rec]


def lines(
    r: Rng, m: Machine, feeds: list[float], hold: float, ways: int
) -> list[tuple[Array, float]]:
    """Goals (mm from the middle) and feeds (mm/min), at each feed in turn: one axis to and fro
    twice, the other one, then both at once (`ways` 1 to 3 of these); a move lasts `hold` s."""
    use = [int(a) for a in r.permutation(m.axes)][:2]
    out: list[tuple[Array, float]] = []
    for feed in feeds:
        for way in ([use[0]], [use[1]], use)[:ways]:
            e = np.eye(3)[way].sum(0) / np.sqrt(len(way))
            room = 0.3 * min(float(np.ptp(m.travel[a])) for a in way)
            half = min(room, feed / 60 * hold / 2, 150.0)
            out += [(s * half * e, feed) for s in (1, -1, 1, -1, 0)]
    return out


def log(
    r: Rng, m: Machine, sees: str, feeds: list[float], hold: float, ways: int, t0: float, name: str
) -> Rec:
    """Samples of a control (or of a grid encoder) on `lines`, once or as often as fits 20 s, at
    100 to 500 Hz, at most 12000."""
    at, acc = inside(m, r, 0.42, 0.58), m.amax * r.uniform(0.3, 0.8)
    moves, rest = lines(r, m, feeds, hold, ways), r.uniform(0.1, 0.4)
    about = max(20.0, len(moves) * (hold + rest + 0.1))
    fs = float(pick(r, [f for f in (100, 250, 500) if f * about < 12000] or [100]))
    here, p = at, [np.tile(at, (int(fs * 0.5), 1))]
    while sum(map(len, p)) < fs * 20:
        for way, feed in moves:
            d = float(np.linalg.norm(at + way - here))
            step = ramp(d, feed / 60, acc, 1 / fs) if d > 1e-6 else np.zeros(0)
            p.append(here + np.outer(step / max(d, 1e-9), at + way - here))
            here = at + way
            p.append(np.tile(here, (int(fs * rest), 1)))
    pos = np.round(np.concatenate(p)[:12000], 6)
    n, win = len(pos), np.ones(max(1, int(0.02 * fs)))
    t, vel = np.round(t0 + np.arange(n) / fs, 5), np.gradient(pos, 1 / fs, axis=0)
    flat = np.apply_along_axis(np.convolve, 0, vel, win / len(win), "same")
    tool = "control" if sees == "scale" else "grid encoder"
    meta = header_meta(m, sees=sees, instrument=tool, rate=fs, path="lines", feed=max(feeds))
    state = (pos, vel, np.gradient(flat, 1 / fs, axis=0), np.ones(n, int))
    top = np.full(n, max(feeds))
    return Rec(name, "trace", t, *state, pos, t, np.arange(n), top, meta).finish()


def logs(r: Rng, m: Machine, sees: str, poor: bool) -> list[Make]:
    """One or two logs of lines at two to four feeds each and a circle, both ways; one axis at one
    feed if poor."""
    most = min(m.vmax, 10000.0)
    if poor:
        feed = float(round(most * r.uniform(0.1, 0.6)))
        return [partial(log, r, m, sees, [feed], 1.0, 1)]
    shares = np.sort(r.choice([0.05, 0.1, 0.2, 0.4, 0.7, 1.0], int(r.integers(2, 5)), False))
    feeds = [float(round(most * s)) for s in shares]
    turn = {"path": "circle", "rate": float(pick(r, [100, 250])), "rows": 6000}
    one = partial(log, r, m, sees, feeds, 1.0, 3)
    last = partial(_round, r, m, sees, {**turn, "feed": feeds[-1] / 2})
    return [one, last] if r.random() < 0.5 else [one, one, last]


def _round(r: Rng, m: Machine, sees: str, force: dict, t: float, name: str) -> Rec:
    return trace(r, m, t, name, sees, force=force)


def crawl(r: Rng, m: Machine, sees: str, poor: bool) -> list[Make]:
    """One or two logs of two axes, one at a time, at two or three feeds of 50 to 300 mm/min; one
    axis at one feed if poor."""
    feeds, n = [50.0, 100.0, 150.0, 200.0, 300.0], 1 if poor else int(r.integers(2, 4))
    some = [float(f) for f in np.sort(r.choice(feeds, n, False))]
    one = partial(log, r, m, sees, some, 3.0, 1 if poor else 2)
    return [one] * (1 if poor else int(r.integers(1, 3)))
