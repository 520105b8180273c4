"""Tests at one place: over hours (ISO 230-3), under a load, and the same places again."""

from __future__ import annotations

import numpy as np

from .base import pick
from .case import Case
from .readings import CAPACITIVE, DIAL, PROBE
from .recordings import Recording
from .rest_plans import Move, targets


def dwell(
    c: Case,
    d: str,
    hours: float | None = None,
    instrument: str | None = None,
    n: int | None = None,
    out_and_back: bool | None = None,
) -> Recording:
    """One place for a long time, read along d; in half of the tests left before each reading."""
    r, m = c.r, c.machine
    whole = 3600 * (hours or r.uniform(0.7, 3))
    n = n or int(r.integers(30, 120))
    pauses = r.exponential(1, n) + 0.3 if r.random() < 0.4 else np.ones(n)
    pauses = pauses / pauses.sum() * whole
    home = {a: round(m.middle(a) + r.uniform(-0.3, 0.3) * m.length(a), 1) for a in m.axes}
    out_and_back = bool(r.random() < 0.5) if out_and_back is None else out_and_back
    moves = []
    for k, pause in enumerate(pauses):
        if out_and_back:
            moves.append(Move({d: home[d] - 5.0}, 1500.0, 0.2))
        moves.append(Move(home, 1500.0, pause, 1 + k // 20))
    c.plan.append(f"one place for {whole / 3600:.1f} h, read in {d}")
    what = f"dwell_{d.lower()}"
    instruments = [PROBE, CAPACITIVE, DIAL]
    return targets(
        c, moves, {d: 1.0}, instruments, what, instrument=instrument, walk=0.0, start=home
    )


def spindle(c: Case, d: str) -> Recording:
    """A mandrel and a probe while the spindle runs and stops (ISO 230-3)."""
    r = c.r
    top = float(pick(r, [3000, 6000, 8000, 12000]))
    speeds, t = [(c.t, 0.0)], c.t + r.uniform(120, 600)
    for _ in range(int(r.integers(1, 4))):
        speeds.append((t, round(top * r.uniform(0.3, 1))))
        t += r.uniform(900, 3600)
    if r.random() < 0.7:
        speeds.append((t, 0.0))
        t += r.uniform(600, 2400)
    c.speeds = speeds
    rec = dwell(c, d, hours=(t - c.t) / 3600)
    rec.more["spindle_rpm"] = c.rpm(rec.t)
    c.plan[-1] = f"spindle growth test read in {d}"
    return rec


def load(c: Case, a: str) -> Recording:
    """The slide pushed by a jack with a load cell."""
    r, m = c.r, c.machine
    most = float(pick(r, [100, 200, 500, 1000]))
    moves = []
    for run in range(1, int(r.integers(2, 5)) + 1):
        x = round(m.middle(a) + r.uniform(-0.35, 0.35) * m.length(a), 1)
        up = np.linspace(0, most, int(r.integers(4, 8)))
        down = np.linspace(most, -most * (r.random() < 0.6), int(r.integers(5, 9)))
        moves += [Move({a: x - 5}), Move({a: x})]
        for force in [0, *up, *down, 0]:
            read = round(float(force + r.normal() * 0.004 * most), 1)
            moves.append(Move({a: x}, dwell=20.0, run=run, more={f"force_{a}_N": read}))
    c.plan.append(f"static load on {a}")
    what = f"load_{a.lower()}"
    return targets(c, moves, {a: 1.0}, [PROBE, DIAL, CAPACITIVE], what, walk=0.0)


def again(rec: Recording) -> list[Move]:
    """The way of a recording once more."""
    run_of = dict(zip(rec.taken.tolist(), rec.run.tolist(), strict=True))
    moves = []
    for i in range(1, len(rec.way_t)):
        run = run_of.get(i, 0)
        moves.append(Move({a: x[i] for a, x in rec.way.items()}, dwell=2 if run else 0.3, run=run))
    return moves
