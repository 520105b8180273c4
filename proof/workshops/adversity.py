"""Adversarial nulls: nothing is hidden in the machine, the circumstances are bad. Every function
spoils the readings of a case and says what it did."""

from __future__ import annotations

import numpy as np

from .base import Redraw, pick
from .case import Case
from .readings import to_scale
from .recordings import Recording


def _of(c: Case, kind: str) -> list[Recording]:
    found = [rec for rec in c.recs if rec.kind == kind]
    if not found:
        raise Redraw(f"no {kind}")
    return found


def _one(c: Case, kind: str) -> Recording:
    return pick(c.r, _of(c, kind))


def misread(c: Case) -> str:
    """One or two readings with a wrong digit."""
    rec, r = _one(c, "targets"), c.r
    n = int(r.integers(1, 3))
    rows = r.choice(rec.n, n, replace=False)
    noise = rec.noise["reading_um"]
    digit = pick(r, [10, 10, 100]) * rec.step
    if digit <= 8 * noise:
        digit = 20 * rec.step * max(1, round(noise / rec.step))
    rec.read["reading_um"][rows] += r.choice([-1, 1], n) * digit
    return f"misread digit at rows {sorted(rows.tolist())} of {rec.name}, {digit:g} um"


def stuck(c: Case) -> str:
    """A gauge that stays where it was for some readings."""
    rec, r = _one(c, "targets"), c.r
    row, n = int(r.integers(0, rec.n - 6)), int(r.integers(3, 6))
    y = rec.read["reading_um"]
    y[row : row + n] = y[row]
    return f"gauge stuck for {n} readings from row {row} of {rec.name}"


def wrong_zero(c: Case) -> str:
    """One run with another zero."""
    rec, r = _one(c, "targets"), c.r
    runs = sorted(set(rec.run.tolist()))
    run = pick(r, runs)
    size = r.uniform(1.5, 5) * pick(r, [-1, 1]) * (8 if c.machine.coarse else 1)
    if len(runs) < 3:
        raise Redraw("too few runs")
    step = float(np.round(size / rec.step) * rec.step)
    rec.read["reading_um"][rec.run == run] += step
    return f"wrong zero in run {run} of {rec.name}: {step:g} um"


def warm_bar(c: Case) -> str:
    """A ballbar that warms up in the hand."""
    bars = _of(c, "ballbar")
    size = c.r.uniform(0.5, 2.0) * (3 if c.machine.coarse else 1)
    for rec in bars:
        longer = size * (1 - np.exp(-(rec.t - bars[0].t[0]) / 200.0))
        y = rec.read["radial_um"] + longer
        rec.read["radial_um"] = np.round(y / rec.step) * rec.step
    return f"ballbar in a warm hand: {size:.2f} um longer, 200 s"


def clock(c: Case) -> str:
    """A clock that is fast by some ppm, for command and answer alike."""
    rec = _one(c, "trace")
    fast = c.r.uniform(1e-6, 2e-5)
    rec.t_written = rec.t[0] + (rec.t - rec.t[0]) * (1 + fast)
    ppm = f"{fast * 1e6:.1f} ppm"
    return f"all time stamps of {rec.name} run {ppm} fast (commanded and actual alike)"


def jitter(c: Case) -> str:
    """Times that are not even, and coarse places."""
    rec = _one(c, "trace")
    late = c.r.uniform(-0.4, 0.4, rec.n) * (rec.t[1] - rec.t[0])
    rec.t_written = np.round(rec.t + late, 5)
    step = max(rec.step_of_scale, 1.0)
    for a, pos in rec.pos.items():
        rec.read[f"{a}_act"] = to_scale(pos, rec.read[f"{a}_act"], step)
    return f"time stamps of {rec.name} jitter by 0.4 periods, positions in steps of {step:g} um"


def thermometer(c: Case) -> str:
    """A thermometer that reads too much, or one in the light of a lamp."""
    r = c.r
    read = [rec for rec in c.recs if "T_air_C" in rec.more]
    for rec in read:
        trouble = np.where(r.random(rec.n) < 0.05, 12.0, 0)
        rec.more["T_air_C"] = np.round(rec.more["T_air_C"] + 4.5 + trouble, 2)
    if read:
        return "thermometer 4.5 C wrong with contact trouble"
    rec = _of(c, "targets")[0]
    a = pick(r, c.machine.axes)
    share = (rec.t - rec.t[0]) / max(1, rec.t[-1] - rec.t[0])
    warm = np.round(20 + 6 * share + 0.1 * r.normal(size=rec.n), 2)
    rec.more[f"T_screw_{a}_C"] = warm
    return f"thermometer at screw {a} warms by 6 C beside a lamp, the screw does not"


def bumped(c: Case) -> str:
    """A stand that was bumped between two runs."""
    rec, r = _one(c, "targets"), c.r
    runs = sorted(set(rec.run.tolist()))
    if len(runs) < 2:
        raise Redraw("one run")
    run = runs[len(runs) // 2]
    size = r.uniform(2, 12) * pick(r, [-1, 1]) * (5 if c.machine.coarse else 1)
    step = float(np.round(size / rec.step) * rec.step)
    rec.read["reading_um"][rec.run >= run] += step
    return f"stand bumped before run {run} of {rec.name}: {step:g} um"


def traffic(c: Case) -> str:
    """More noise in a quarter of the readings."""
    rec, r = _one(c, "targets"), c.r
    n = rec.n // 4
    row = int(r.integers(0, max(1, rec.n - n)))
    y, noise = rec.read["reading_um"], rec.noise["reading_um"]
    shaken = y[row : row + n] + 2.5 * noise * r.normal(size=n)
    y[row : row + n] = np.round(shaken / rec.step) * rec.step
    where = f"rows {row} to {row + n} of {rec.name}"
    return f"forklift traffic: noise 2.7 times as large at {where}"


HARMS = (misread, stuck, wrong_zero, warm_bar, clock, jitter, thermometer, bumped, traffic)
NEEDS = {
    warm_bar: "ballbar",
    clock: "trace",
    jitter: "trace",
}  # kinds of recordings; others targets
