"""Instruments that err, and faults of the data (lasers: ISO 230-1 and -2; air: Edlen, 1966)."""

from __future__ import annotations

import numpy as np

from . import moving_plans, rest_plans, slow_plans
from .base import Array, Fields, pick
from .case import Case, Hidden
from .readings import COMPARATOR, DIAL, DIAL_10, LASER, PROBE, STEP_GAUGE
from .recordings import Recording

AIR = 0.93  # um/m/K
PRESSURE = 0.27  # um/m/hPa


def _longest(c: Case) -> str:
    return max(c.machine.axes, key=c.machine.length)


def _lasers(c: Case, a: str, n: int, style: str) -> list[Recording]:
    """Sweeps by laser in several hours; the beam begins at the low end."""
    found = []
    for k in range(n):
        runs, what = int(c.r.integers(2, 4)), f"{a.lower()}_laser{k + 1}"
        rec = rest_plans.linear(
            c, a, style, runs=runs, instrument=LASER, what=what, air=True, walk=0.0
        )
        found.append(rec)
        c.t += c.r.uniform(1800, 7200)
    return found


def laser_air(c: Case, form: str) -> Hidden:
    """A laser whose air is not what was entered; size: um/m/K, or um/m/hPa."""
    a, r = _longest(c), c.r
    c.notes_air = True
    c.warming = r.uniform(1.5, 4) * pick(r, [-1, 1])
    low, before = c.machine.travel[a][0], r.uniform(100, 300)  # mm, of the beam before the travel
    recs = _lasers(c, a, int(r.integers(2, 4)), "iso")
    what = f"{a.lower()}_comparator"
    rest_plans.linear(c, a, "iso", instrument=COMPARATOR, what=what, air=True)
    rise = r.uniform(2, 4) * pick(r, [-1, 1])
    barometer = form == "barometer moved, nobody entered it"

    def pressure(rec: Recording) -> Array:
        return 1.5 * rise * (rec.t - recs[0].t[0]) / 3600

    for rec in recs:
        rec.head["beam_from"] = "low end"
        if barometer:
            rec.more["P_air_hPa"] = np.round(1013 + pressure(rec), 1)

    def field(rec: Recording, size: float) -> Fields:
        if rec not in recs:
            return {}
        if barometer:
            change = -pressure(rec)
        else:
            assumed = 20.0 if form == "all readings at 20 C settings" else c.mean
            change = c.air(rec.t) - assumed
        path = rec.pos[a] - low + before
        return {"reading_um": -size * change * path * 1e-3 * rec.sensitive[a]}

    size = PRESSURE if barometer else AIR
    return Hidden("laser_air", a, form, field, size=size, axes_too=[""], natural=True)


def dead_path(c: Case, form: str) -> Hidden:
    """The size is the path before the travel, mm."""
    a, r = _longest(c), c.r
    c.notes_air = True
    c.warming = r.uniform(2.5, 5) * pick(r, [-1, 1])
    if form == "far reflector, one place watched":
        recs = [slow_plans.dwell(c, a, hours=2.0, instrument=LASER, n=60)]
        recs[0].more["T_air_C"] = c.read_air(recs[0])
    else:
        recs = _lasers(c, a, 2, "lunch")
    slow_plans.dwell(c, a, hours=1.2, instrument=PROBE, n=40)

    def field(rec: Recording, size: float) -> Fields:
        if rec not in recs:
            return {}
        change = c.air(rec.t) - c.air(rec.t[0])
        return {"reading_um": -size * (AIR * 1e-3) * change * rec.sensitive[a]}

    return Hidden("dead_path", a, form, field, size=1500.0, most=4500.0, axes_too=[""])


def cosine(c: Case, form: str) -> Hidden:
    """A beam or a gauge askew: too short or too long in proportion; size: um/m."""
    a = _longest(c)
    laser = form == "laser beam not parallel"
    instrument, second = LASER if laser else STEP_GAUGE, COMPARATOR
    if c.machine.coarse:
        instrument, second = DIAL, DIAL_10
    what = f"{a.lower()}_first_setup"
    rec = rest_plans.linear(c, a, "iso", instrument=instrument, what=what, walk=0.0)
    rest_plans.linear(c, a, "iso", instrument=second, what=f"{a.lower()}_second_setup")
    low, sign = c.machine.travel[a][0], -1.0 if laser else 1.0

    def field(of: Recording, size: float) -> Fields:
        if of is not rec:
            return {}
        return {"reading_um": sign * size * 1e-3 * (rec.pos[a] - low) * rec.sensitive[a]}

    return Hidden("cosine", a, form, field, size=10.0, axes_too=[""])


def _late(c: Case, effect: str, form: str, size: float | None) -> Hidden:
    """What was logged is of another time than it says. size: s, or a share of the time; a share of
    either sign where None."""
    r = c.r
    kind = pick(r, ["circles", "contour", "p2p", "pocket"])
    rec = c.once(moving_plans.trace, None, kind=kind, sees=pick(r, ["scale", "scale", "tool"]))
    cycle = pick(r, [0.002, 0.004, 0.008])  # s
    pick(
        r, [1500, 3000]
    )  # once the samples between two lost ones: what is drawn later keeps its place

    def field(of: Recording, size: float) -> Fields:
        if of is not rec:
            return {}
        t = rec.t
        if form == "constant":
            true = t - size
        elif form == "held until the next bus cycle":
            true = t - size * (1 + 0.5 * (((t - t[0]) % cycle) / cycle - 0.5))
        elif form == "quartz of the logger":
            true = t[0] + (t - t[0]) * (1 + size)
        else:  # a sample is lost now and then, and not told
            true = np.minimum(t + size * np.floor(np.arange(rec.n) / (rec.n / 6.0)), t[-1])
        pos = rec.pos
        return {f"{a}_act": (np.interp(true, t, pos[a]) - pos[a]) * 1e3 for a in rec.axes}

    axes = [*c.machine.axes, "".join(rec.axes)]
    size = pick(r, [-1e-4, 1e-4]) if size is None else size
    return Hidden(effect, "", form, field, size=size, axes_too=axes, rounds=5)


def delay(c: Case, form: str) -> Hidden:
    """A log that is late; size: s."""
    return _late(c, "delay", form, 1e-3)


def clock_skew(c: Case, form: str) -> Hidden:
    """A log whose clock goes wrong: size: share of the time, or s for each of six losses."""
    return _late(c, "clock_skew", form, None if form == "quartz of the logger" else 5e-4)


def sensor_drift(c: Case, form: str) -> Hidden:
    """A gauge that drifts, while another does not; size: um."""
    r, d, m = c.r, c.axis(), c.machine
    if r.random() < 0.5:
        rec = slow_plans.dwell(c, d, instrument=None if m.coarse else PROBE)
        slow_plans.dwell(c, d, hours=1.0, instrument=None if m.coarse else LASER)
    else:
        rec = rest_plans.linear(c, d, "iso", runs=6, what=f"{d.lower()}_gauge", walk=0.0)
        rest_plans.linear(c, d, "lunch", runs=4, what=f"{d.lower()}_check")
    span, t = rec.t[-1] - rec.t[0], rec.t - rec.t[0]
    tau = span * r.uniform(0.15, 0.4)
    linear = form == "linear zero drift of the amplifier"
    drifted = t / span if linear else 1 - np.exp(-t / tau)

    def field(of: Recording, size: float) -> Fields:
        return {"reading_um": size * drifted} if of is rec else {}

    axes, size = list(m.axes), pick(r, [-1.0, 1.0])
    return Hidden("sensor_drift", "", form, field, size=size, axes_too=axes)


def outlier(c: Case, form: str) -> Hidden:
    """One to three readings; none less than 0.8 of the size, six standard deviations at least."""
    r, a = c.r, c.axis()
    if form == "spikes on the log":
        rec = c.once(moving_plans.trace, c.both(a), rate=pick(r, [100, 250, 500]))
        axis, channel = a, f"{a}_act"
    else:
        rec = c.once(rest_plans.linear, a)
        axis, channel = "", "reading_um"
    n = int(r.integers(1, 4))
    rows = r.choice(np.arange(2, rec.n - 2), n, replace=False)
    shape = np.zeros(rec.n)
    shape[rows] = r.choice([-1, 1], n) * r.uniform(0.8, 1.2, n)

    def field(of: Recording, size: float) -> Fields:
        return {channel: size * shape} if of is rec else {}

    params = {"file": rec.name, "rows": sorted(rows.tolist())}
    found = Hidden("outlier", axis, form, field, axes_too=["", *c.machine.axes], params=params)
    found.believable = lambda: 0.8 * found.size >= 6 * max(rec.noise.values())
    return found
