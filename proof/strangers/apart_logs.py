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


def lines(r: Rng, m: Machine, feeds: list[float], poor: bool) -> list[tuple[Array, float]]:
    """Goals (mm from the middle) and feeds (mm/min): each axis to and fro by itself, twice, then
    both at once, at each feed in turn; one axis alone if poor."""
    use = [int(a) for a in r.permutation(m.axes)][: 1 if poor else 2]
    out: list[tuple[Array, float]] = []
    for feed in feeds:
        for way in ([a] for a in use) if poor else ([use[0]], [use[1]], use):
            e = np.eye(3)[way].sum(0) / len(way)
            half = min(0.3 * min(float(np.ptp(m.travel[a])) for a in way), feed / 60 * 1.5, 150.0)
            out += [(s * half * e, feed) for s in (1, -1, 1, -1)] + [(0 * e, feed)]
    return out


def log(r: Rng, m: Machine, sees: str, feeds: list[float], poor: bool, t0: float, name: str) -> Rec:
    """Samples of a control (or of a grid encoder) on `lines`, again and again, 20 to 60 s."""
    fs, at = float(pick(r, [100, 250, 500])), inside(m, r, 0.42, 0.58)
    n = int(np.clip(fs * r.uniform(20, 60), 2000, 10000)) // (3 if poor else 1)
    acc, here, p = m.amax * r.uniform(0.3, 0.8), at, [np.tile(at, (int(fs * 0.5), 1))]
    rest = int(fs * r.uniform(0.1, 0.4))
    moves = lines(r, m, feeds, poor)
    while sum(map(len, p)) < n:
        for way, feed in moves:
            d = float(np.linalg.norm(at + way - here))
            step = ramp(d, feed / 60, acc, 1 / fs) if d > 1e-6 else np.zeros(0)
            p.append(here + np.outer(step / max(d, 1e-9), at + way - here))
            here = at + way
            p.append(np.tile(here, (rest, 1)))
    pos = np.round(np.concatenate(p)[:n], 6)
    t, win = np.round(t0 + np.arange(n) / fs, 5), np.ones(max(1, int(0.02 * fs)))
    vel = np.gradient(pos, 1 / fs, axis=0)
    flat = np.apply_along_axis(np.convolve, 0, vel, win / len(win), "same")
    tool = "control" if sees == "scale" else "grid encoder"
    meta = header_meta(m, sees=sees, instrument=tool, rate=fs, path="lines", feed=max(feeds))
    state = (pos, vel, np.gradient(flat, 1 / fs, axis=0), np.ones(n, int))
    top = np.full(n, max(feeds))
    return Rec(name, "trace", t, *state, pos, t, np.arange(n), top, meta).finish()


def logs(r: Rng, m: Machine, sees: str, poor: bool) -> list[Make]:
    """Two logs of lines at two to four feeds each and a circle, both ways; one log of one feed if
    poor."""
    most = min(m.vmax, 10000.0)
    if poor:
        return [partial(log, r, m, sees, [float(round(most * r.uniform(0.1, 0.6)))], True)]
    shares = np.sort(r.choice([0.05, 0.1, 0.2, 0.4, 0.7, 1.0], int(r.integers(2, 5)), False))
    feeds = [float(round(most * s)) for s in shares]
    round_ = {"path": "circle", "rate": float(pick(r, [100, 250])), "rows": 6000}
    round_["feed"] = feeds[-1] / 2
    one = partial(log, r, m, sees, feeds, False)
    return [one, one, partial(_round, r, m, sees, round_)][: int(r.integers(2, 4))]


def _round(r: Rng, m: Machine, sees: str, force: dict, t: float, name: str) -> Rec:
    return trace(r, m, t, name, sees, force=force)


def crawl(r: Rng, m: Machine, sees: str, poor: bool) -> list[Make]:
    """Logs at two or three feeds of 30 to 300 mm/min, one or two of them."""
    feeds = [30.0, 60.0, 100.0, 200.0, 300.0]
    some = [float(f) for f in np.sort(r.choice(feeds, 1 if poor else int(r.integers(2, 4)), False))]
    return [partial(log, r, m, sees, some, poor)] * (1 if poor else int(r.integers(1, 3)))
