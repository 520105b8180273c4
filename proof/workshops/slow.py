"""What comes with heat (ISO 230-3), force, wear, and steps that are lost."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from . import moving_plans, rest_plans, slow_plans
from .base import Array, Fields, Redraw, log_uniform, pick
from .case import Case, Hidden
from .geometry import along
from .readings import LASER, PROBE, STEP_GAUGE
from .recordings import Recording
from .rest_plans import Move

STEEL = 11.7e-3  # um/mm/K
WARMEST = 20.0  # K, of a screw
SURFACES = {"boss_diameter": 1.0, "bore_diameter": -1.0, "pocket_size": -1.0}  # a worn tool's


def screw_heat(c: Case, form: str) -> Hidden:
    """A screw that warms up by its motion (ISO 230-3); size: um for 1 mm/s over the travel."""
    a, r, m = c.axis(), c.r, c.machine
    tau = log_uniform(r, 600, 3000)
    low, high = m.travel[a]
    if r.random() < 0.75:
        runs, n = int(r.integers(4, 9)), int(r.integers(4, 10))
        c.anew(rest_plans.linear, a, style="warmcold", runs=runs, n=n)
    else:
        c.anew(rest_plans.linear, a, style="iso")
        c.unseen.append((c.t, c.t + 2400, a, m.vmax[a] / 60 * 0.4))
        c.t += 2460
        rest_plans.linear(c, a, style="iso", runs=3)
    fixed = high if form == "fixed bearing at the high end" else low
    thermometer = r.random() < 0.6

    @lru_cache(None)
    def warm(rec: Recording) -> Array:
        return c.heat(a, rec.t, tau)

    def field(rec: Recording, size: float) -> Fields:
        if form == "hot in the middle where the nut works":
            grown = np.tanh((c.share(a, rec) - 0.5) / 0.25) / 2 + 0.5
            return rec.project({a: size * warm(rec) * grown})
        return rec.project({a: size * warm(rec) * (rec.pos[a] - fixed) / m.length(a)})

    found = Hidden("screw_heat", a, form, field, params={"tau_s": tau})

    def believable() -> bool:
        warmest = max(warm(rec).max() for rec in c.recs if rec.kind != "features")
        return bool(found.size * warmest / (STEEL * m.length(a)) < WARMEST)

    def columns(rec: Recording) -> None:
        if rec.kind == "targets":
            kelvin = found.size / (STEEL * m.length(a)) * warm(rec)
            rec.more[f"T_screw_{a}_C"] = c.mean + kelvin + r.normal(size=rec.n) * 0.05

    found.believable = believable
    found.columns = columns if thermometer else None
    return found


def structure_drift(c: Case, form: str) -> Hidden:
    """A frame that grows (ISO 230-3): after switching on, size: um; with the room, um/K;
    with the hours, um/h."""
    r, d = c.r, c.axis()
    tau = 0.0
    if form == "after switching on (exponential)":
        tau = log_uniform(r, 1200, 6000)
    elif form == "room over the day, late by the frame":
        c.swing, c.period = r.uniform(1, 3), r.uniform(6e3, 2e4)
        c.notes_air = True
        tau = log_uniform(r, 600, 3000)
    else:
        c.warming = r.uniform(0.5, 1.5)
        c.notes_air = bool(r.random() < 0.7)

    def drifted(rec: Recording) -> Array:
        if form == "after switching on (exponential)":
            return 1 - np.exp(-rec.t / tau)
        if form == "room over the day, late by the frame":
            return c.late(lambda t: c.air(t) - c.air(0), rec.t, tau)
        return rec.t / 3600

    if r.random() < 0.5:
        c.once(slow_plans.dwell, d)
    else:
        c.once(rest_plans.linear, d, style="lunch", runs=6, n=6)
    if not c.notes_air or r.random() < 0.5:
        # a second instrument sees the same: not a gauge that drifts
        slow_plans.dwell(c, d, hours=1.2, instrument=None if c.machine.coarse else LASER)
    most = (60.0 if c.machine.coarse else 12.0) if form.startswith("room") else None
    return Hidden("structure_drift", d, form, along(d, drifted), most=most, axes_too=[""])


def spindle_growth(c: Case, form: str) -> Hidden:
    """A spindle that grows with its speed (ISO 230-3); size: um at 6000 rpm."""
    r = c.r
    d = pick(r, ["Z", "X"]) if len(c.machine.axes) == 2 else "Z"
    if not c.speeds:
        c.once(slow_plans.spindle, d)
    bearing, head = log_uniform(r, 120, 500), log_uniform(r, 1500, 4000)
    share, power = r.uniform(0.3, 0.6), pick(r, [1.0, 1.0, 1.5])

    def drive(t: Array) -> Array:
        return (c.rpm(t) / 6000) ** power

    @lru_cache(None)
    def grown(rec: Recording) -> Array:
        y = c.late(drive, rec.t, bearing)
        if form == "two time constants (bearing, head)":
            y = share * y + (1 - share) * c.late(drive, rec.t, head)
        return -y if d == "Z" else y

    return Hidden("spindle_growth", d, form, along(d, grown), axes_too=[""])


def force_compliance(c: Case, form: str) -> Hidden:
    """A slide that gives way to a load; size: um/N."""
    a = c.axis()
    c.once(slow_plans.load, a)
    knee = c.r.uniform(60, 200)

    def field(rec: Recording, size: float) -> Fields:
        force = rec.more.get(f"force_{a}_N")
        if force is None or rec.kind != "targets":
            return {}
        if form == "linear stiffness":
            return rec.project({a: size * force})
        gap = np.sign(force) * knee * np.log1p(np.abs(force) / knee)
        return rec.project({a: size * (gap + 0.3 * force)})

    return Hidden("force_compliance", a, form, field, size=0.01)


def tool_wear(c: Case, form: str) -> Hidden:
    """A tool that gets smaller and is changed (Taylor, 1907); size: um, on a radius."""
    r = c.r
    turning = c.machine.turning
    n = int(r.integers(12, 30))
    changed = int(r.integers(5, n - 2))  # the last part of the first tool
    share = r.uniform(0.3, 0.6)
    params = {"reset_after": changed}
    if form == "probed on the machine after each cut":
        d = "X" if turning else pick(r, c.machine.axes)
        length = _probe_parts(c, d, n, changed)

        def proud(rec: Recording, size: float) -> Fields:
            if "cut_length_m" not in rec.more:
                return {}
            return rec.project({d: -size * rec.more["cut_length_m"] / (n * length)})

        return Hidden("tool_wear", d, form, proud, axes_too=[""], params=params)
    kinds = ["boss_diameter", "bore_diameter", *([] if turning else ["pocket_size"])]
    rec = moving_plans.features(c, n=n, kinds=kinds, repeats=1)
    part = rec.parts["part"]
    cut = np.where(part > changed, part - changed, part)
    rec.more["cut_length_m"] = cut * r.uniform(2, 8)
    rec.more["tool_no"] = 1.0 + (part > changed)
    c.plan[-1] += f", tool changed after part {changed}"
    worn = cut.astype(float) / n
    if form == "break-in, then linear (Taylor)":
        worn = share * (1 - np.exp(-cut / 1.5)) + (1 - share) * cut / n

    def parts(of: Recording) -> Array:
        if of is not rec:
            return np.zeros(of.n)
        return 2 * np.array([SURFACES.get(k, 0.0) for k in of.parts["kind"]]) * worn

    axes = ["", "X", "Y"]
    axis = "X" if turning else ""
    return Hidden("tool_wear", axis, form, _nowhere, parts, axes_too=axes, params=params)


def _nowhere(rec: Recording, size: float) -> Fields:
    return {}


def _probe_parts(c: Case, d: str, n: int, changed: int) -> float:
    """Every part is probed twice after its cut; returns the cut of a part, m."""
    r = c.r
    length = r.uniform(2, 8)
    home = {d: round(c.machine.middle(d), 1)}
    moves = []
    for k in range(1, n + 1):
        cut = k if k <= changed else k - changed
        more = {"cut_length_m": round(cut * length, 2), "tool_no": 1.0 + (k > changed)}
        for reading in range(2):
            pause = 0.5 if reading else r.uniform(100, 200)
            moves.append(Move({d: home[d] - 3.0}, 1500.0, pause))
            moves.append(Move(home, 1500.0, 2.0, k, more))
    slow_plans.targets(c, moves, {d: 1.0}, [PROBE, STEP_GAUGE], f"part_probe_{d.lower()}", walk=0.0)
    c.plan.append(f"part probed after every cut, tool changed after {changed}")
    return length


def tool_size(c: Case, form: str) -> Hidden:
    """A tool that is larger than stated; size: um, on the diameter."""
    if c.machine.turning:
        raise Redraw("a turning tool has no size")
    kinds = ["bore_diameter", "boss_diameter"]
    if form == "cutter ground under size, pockets and bosses":
        kinds = ["pocket_size", "boss_diameter", "centre_distance", "step"]
    c.once(moving_plans.features, kinds=kinds)

    def parts(rec: Recording) -> Array:
        return np.array([-SURFACES.get(k, 0.0) for k in rec.parts["kind"]])

    return Hidden("tool_size", "", form, _nowhere, parts, size=-5.0, axes_too=["X", "Y", "XY"])


def step_loss(c: Case, form: str) -> Hidden:
    """From some reading on the axis is elsewhere; size: um."""
    a, r = c.axis(), c.r
    if form == "lost full steps at high acceleration":
        axes, kind = c.both(a), pick(r, ["p2p", "strokes", "pocket"])
        rec = c.once(moving_plans.trace, axes, kind=kind, rate=pick(r, [50, 100, 250]))
        middle = slice(int(0.25 * rec.n), int(0.75 * rec.n))
        t = rec.t[middle][int(np.argmax(np.abs(rec.acc[a][middle])))]
    else:
        if form == "hidden in one run of a step gauge":
            style = pick(r, ["iso", "outback", "shuffled"])
            rec = c.once(rest_plans.linear, a, style=style)
        else:
            rec = c.once(slow_plans.dwell, a, hours=0.7, out_and_back=True)
        t = rec.t[int(r.uniform(0.25, 0.75) * rec.n)] - 0.1

    # Whether the operator set zero again for the next file does not matter: a constant is not seen.
    def field(rec: Recording, size: float) -> Fields:
        return rec.project({a: size * (rec.t >= t)}, servo=True)

    params = {"t_s": round(float(t), 2)}
    return Hidden("step_loss", a, form, field, size=pick(r, [-1.0, 1.0]), params=params)
