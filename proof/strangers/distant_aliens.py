"""Physics without a name in the contract, distant family. Do not read while working on the judged
tool.

Sources: Slocum 1992 and Bassani and Piccigallo 1992 (slides that float up with speed; central
oilers that lift them for a while), Weck and Brecher 2006 (chips on a table; clamped slides; bimetal
beds), Olsson and Astrom 2001 (Friction generated limit cycles; IEEE Trans. Control Systems
Technology 9), Schneeberger's and SKF's notes on crossed rollers (cage creep, undone by a full
stroke), ISO 230-3 (spindles: what comes with a change of speed), Bryan 1990 (a bed bends with the
difference of its temperatures), ISO 230-2 (dwell: what has not settled goes with the length of the
last move), ISO 8526-1 (pallets; two fixtures by turns), Rivin 2003 (a floor that tips under what
drives past).

Each says why no name of the contract stands for it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import Array, Part, Rec, Rng, Shape, logu, pick, stream
from .forms_time import sensed
from .registry import FORMS, Form, both, tool_only, unit_place
from .world import World


def alien(f: Form) -> Form:
    """Decorator that files an alien of the distant family under a number."""
    k = 1 + sum(n.startswith("alien:distant-") for n in FORMS)
    FORMS[f"alien:distant-{k}"] = [(f"distant-{k}", "distant", f)]
    return f


def everywhere(d: Array, f: Callable[[Rec], Array], most: float = np.inf) -> Shape:
    """a * f(q) along d, at the tool alone."""
    return Shape(lambda q, a: Part(tool=a * f(q)[:, None] * d), "", most=most)


def at_rest(w: World, ax: int, least: int = 3) -> list[Rec]:
    """Files at rest of lengths in which an axis goes to `least` places or more."""
    return [
        q
        for q in w.recs
        if q.kind == "targets"
        and q.meta["quantity"] != "angle"
        and len(np.unique(np.round(q.pos[:, ax], 2))) >= least
    ]


def sampled(w: World, ax: int, outside: bool = False) -> list[Rec]:
    """Traces in which an axis moves."""
    return [
        q for q in w.recs if q.kind == "trace" and ax in q.moving and (q.outside or not outside)
    ]


@alien
def oiler(w: World, r: Rng, ax: int) -> Shape | None:
    """A central oiler lifts the slides every few minutes; they sink back within one.  No
    `structure_drift` goes up and down so: pulses in time, the same at all places."""
    files = [q for q in w.recs if q.kind == "targets" and np.ptp(q.t) > 600 and q.n_obs >= 30]
    if not files:
        return None
    d, start = sensed(w, r), r.uniform(0, 1)
    span = float(np.ptp(pick(r, files).t))
    every = span / r.uniform(4, 9)
    sinks = every * r.uniform(0.08, 0.25)

    def f(q: Rec) -> Array:
        u = ((q.t / every + start) % 1.0) * every
        return np.exp(-u / sinks)

    return everywhere(d, f)


@alien
def heap_of_chips(w: World, r: Rng, ax: int) -> Shape | None:
    """A heap of hot chips warms the table beneath it: a hump at one place that grows in the course
    of the test.  `pitch_shape` and `bow` stay, `screw_heat` grows from one end with the motion."""
    files = [q for q in at_rest(w, ax, 5) if len(np.unique(q.run)) > 1]
    if not files:
        return None
    q0 = pick(r, files)
    x = q0.pos[:, ax]
    c = x.min() + np.ptp(x) * r.uniform(0.25, 0.75)
    wide, d = np.ptp(x) * r.uniform(0.1, 0.22), sensed(w, r)
    at, tau = q0.t[0] + np.ptp(q0.t) * r.uniform(0.0, 0.4), np.ptp(q0.t) * r.uniform(0.2, 0.5)

    def f(q: Rec) -> Array:
        grown = -np.expm1(-np.maximum(q.t - at, 0) / tau)
        return grown * np.exp(-0.5 * ((q.pos[:, ax] - c) / wide) ** 2)

    return everywhere(d, f, 60.0)


@alien
def hunts_at_rest(w: World, r: Rng, ax: int) -> Shape | None:
    """Integral action against static friction: the slide hunts to and fro while it should stand,
    at intervals that vary, and is right in motion (Olsson and Astrom).  `vibration` has one
    frequency and goes on in motion, `stick_slip` needs a creep."""
    files = [q for q in sampled(w, ax) if (np.abs(q.vel[:, ax]) < 1e-3).mean() > 0.05]
    if not files:
        return None
    key, mean = int(r.integers(2**62)), logu(r, 0.08, 0.5)
    fs = max(q.meta["rate"] for q in files)

    def f(q: Rec) -> Array:
        if q.kind != "trace":
            return np.zeros(len(q.t))
        g = stream(key, q.name)
        flips = np.cumsum(mean * g.uniform(0.5, 1.5, int(4 * np.ptp(q.t) / mean) + 9))
        state = 1.0 - 2 * (np.searchsorted(flips, q.t - q.t[0]) % 2)
        still = (np.abs(q.vel[:, ax]) < 1e-3) * state
        n = max(2, int(0.15 * mean * fs))
        return np.convolve(still, np.ones(n) / n, "same")

    return both(ax, f)


@alien
def floats_with_speed(w: World, r: Rng, ax: int) -> Shape | None:
    """A slide on an oil film floats up with its speed, across its way, whichever way it goes
    (Stribeck).  Friction of any name acts along the axis; `bow` and `sag` know no speed."""
    files = sampled(w, ax, True)
    if not files:
        return None
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))
    v0 = logu(r, 3, 40)

    def f(q: Rec) -> Array:
        if q.kind not in ("trace", "ballbar"):
            return np.zeros(len(q.t))
        v = np.abs(q.vel[:, ax])
        return v / (v + v0)

    return tool_only(to, f, axis="")


@alien
def cage_creeps(w: World, r: Rng, ax: int) -> Shape | None:
    """The cage of crossed rollers creeps a little with every stroke until it meets its stop and is
    pushed back: steps that add up and fall back, by strokes and not by time.  `structure_drift` is
    a course of time, `step_loss` comes once."""
    files = [q for q in w.recs if ax in q.moving and q.outside and q.kind in ("targets", "trace")]
    files = [q for q in files if np.sum(np.diff(q.sgn[:, ax]) != 0) > 8]
    if not files:
        return None
    d, key = sensed(w, r), int(r.integers(2**62))
    strokes = int(np.sum(np.diff(files[0].sgn[:, ax]) != 0))
    n = max(3, int(strokes / r.uniform(1.6, 4.5)))

    def f(q: Rec) -> Array:
        if ax not in q.moving or q.kind not in ("targets", "trace"):
            return np.zeros(len(q.t))
        k = np.cumsum(np.abs(np.diff(q.sgn[:, ax], prepend=q.sgn[0, ax])) > 0)
        return ((k + stream(key, q.name).integers(n)) % n) / n

    return everywhere(d, f)


@alien
def kicks_with_the_speed(w: World, r: Rng, ax: int) -> Shape | None:
    """A headstock on soft feet that turns back as its spindle speeds up and nods as it is braked,
    and creeps home within minutes: it goes with the change of speed, not with speed.
    `spindle_growth` stays as long as the spindle turns."""
    jump = np.diff(w.rpm, prepend=w.rpm[0])
    files = [q for q in w.recs if q.kind == "targets" and q.meta["quantity"] != "angle"]
    seen = [t for t in w.grid[jump != 0] if any(q.t[0] < t < q.t[-1] for q in files)]
    if not seen:
        return None
    d, dt = sensed(w, r), float(w.grid[1])
    tau = max(logu(r, 60, 500), 3 * dt)
    y, out = 0.0, []
    for j in jump.tolist():
        y = y * np.exp(-dt / tau) + j / 4000
        out.append(y)
    series = np.array(out)
    return everywhere(d, lambda q: w.step(series, q.t))


@alien
def bimetal_bed(w: World, r: Rng, ax: int) -> Shape | None:
    """A bed of two materials, or warm above and cool below: it arches to one side and the other as
    air and frame differ.  `bow` stays, `structure_drift` is the same at all places, `screw_heat`
    goes with the axis's own work."""
    files = [q for q in at_rest(w, ax, 4) if np.ptp(q.t) > 600]
    if not files:
        return None
    course = w.air - w.frame
    course = course - np.mean([w.at(course, q.t).mean() for q in files])
    if max(float(np.std(w.at(course, q.t))) for q in files) < 0.05:
        return None
    d, c = sensed(w, r), r.uniform(-0.1, 0.1)

    def f(q: Rec) -> Array:
        u = 2 * unit_place(w, ax, q) - 1 - c
        return w.at(course, q.t) * (1 - u**2)

    return everywhere(d, f, 40.0)


@alien
def two_pallets(w: World, r: Rng, ax: int) -> Shape | None:
    """Two pallets by turns, one of them warmer: lengths of every second part are long, those of
    the others right.  `scale` is the same in all parts, `tool_wear` and `tool_size` are the same
    in all lengths."""
    files = [q for q in w.recs if q.kind == "features" and q.meta["part"].max() >= 4]
    if not files:
        return None
    odd, sign = int(r.integers(2)), pick(r, [-1.0, 1.0])

    def f(q: Rec) -> Array:
        size = np.array([i[3] for i in q.meta["info"]])
        return sign * size / 100 * ((q.meta["part"] % 2 == odd) - 0.5)

    return Shape(lambda q, a: Part(reading=a * f(q)) if q.kind == "features" else Part(), "")


@alien
def clamped_when_it_stands(w: World, r: Rng, ax: int) -> Shape | None:
    """A slide that a hydraulic clamp takes a quarter to one second after it has stopped, and pushes
    aside by always the same.  Friction has the sign of the motion; `step_loss` stays."""
    files = [q for q in sampled(w, ax, True) if (np.abs(q.vel[:, ax]) < 1e-3).mean() > 0.05]
    if not files:
        return None
    wait, take = r.uniform(0.05, 0.4), r.uniform(0.01, 0.05)
    to = int(pick(r, w.machine.axes))

    def f(q: Rec) -> Array:
        if q.kind != "trace":
            return np.zeros(len(q.t))
        moves = np.abs(q.vel[:, ax]) > 1e-3
        last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), -1))
        stood = np.where(last >= 0, q.t - q.t[np.maximum(last, 0)], q.t - q.t[0] + 1.0)
        return np.where(moves, 0.0, -np.expm1(-np.maximum(stood - wait, 0) / take))

    return tool_only(to, f, axis="")


@alien
def not_settled(w: World, r: Rng, ax: int) -> Shape | None:
    """A slide that still creeps towards its target as it is read: short by a share of the last
    move, whatever its place.  `backlash` and `windup` go with the direction and the way from the
    reversal; the same direction with another length of move is the same for them."""
    files = at_rest(w, ax, 4)

    def move(q: Rec) -> Array:
        before = q.via[np.maximum(q.row_at - 1, 0), ax]
        return q.pos[:, ax] - before

    def rich(q: Rec) -> bool:
        x = np.abs(move(q))
        return bool(np.ptp(q.sgn[:, ax]) > 0 and x.std() > 0.45 * x.mean())

    if not any(rich(q) for q in files):
        return None

    def f(q: Rec) -> Array:
        return -move(q) / 100 if q.kind == "targets" else np.zeros(len(q.t))

    return tool_only(ax, f, axis="", most=40.0)


@alien
def lorry_drives_past(w: World, r: Rng, ax: int) -> Shape | None:
    """A floor that tips as something heavy drives past, one way and back the other, five to twelve
    times in the test, at odd moments: a derivative of a bell.  `structure_drift` is slow,
    `vibration` goes on."""
    files = [q for q in w.recs if q.kind == "targets" and q.n_obs > 60 and np.ptp(q.t) > 900]
    if not files:
        return None
    q0, d = pick(r, files), sensed(w, r)
    span = float(np.ptp(q0.t))
    at = q0.t[0] + span * np.sort(r.uniform(0.02, 0.98, int(r.integers(5, 13))))
    wide = max(2.5 * float(np.median(np.diff(q0.t))), r.uniform(6, 25))
    size = r.uniform(0.5, 1.0, len(at))

    def f(q: Rec) -> Array:
        if q.kind != "targets":
            return np.zeros(len(q.t))
        u = (q.t[:, None] - at) / wide
        return (-u * np.exp(0.5 - u**2 / 2)) @ size

    return everywhere(d, f)


@alien
def bumped_by_the_other(w: World, r: Rng, ax: int) -> Shape | None:
    """An axis that is pushed aside each time another one starts or stops, and is back within a
    tenth of a second or a few.  `reversal_spike` and `inertia` go with the axis's own motion."""
    others = [a for a in w.machine.axes if a != ax and sampled(w, a)]
    if not others:
        return None
    to, tau = int(pick(r, others)), logu(r, 0.04, 0.3)
    side = pick(r, [-1.0, 1.0])

    def f(q: Rec) -> Array:
        if q.kind != "trace":
            return np.zeros(len(q.t))
        moves = (np.abs(q.vel[:, to]) > 1e-3) * 1
        change = np.diff(moves, prepend=moves[0])
        last = np.maximum.accumulate(np.where(change != 0, np.arange(len(moves)), -1))
        u = (q.t - q.t[np.maximum(last, 0)]) / tau
        way = np.where(change[np.maximum(last, 0)] > 0, 1.0, -0.8)
        return np.where(last >= 0, side * way * u * np.exp(1 - u), 0.0)

    return both(ax, f, axis="")


@alien
def valves_slam(w: World, r: Rng, ax: int) -> Shape | None:
    """A tool changer's valves that slam at odd moments: kicks to one side, each gone within half a
    second, at rest and in motion.  `vibration` has a frequency, `reversal_spike` a reversal."""
    if not sampled(w, ax):
        return None
    key, mean, tau = int(r.integers(2**62)), logu(r, 0.8, 4), logu(r, 0.05, 0.4)

    def f(q: Rec) -> Array:
        if q.kind != "trace":
            return np.zeros(len(q.t))
        g = stream(key, q.name)
        n = int(3 * np.ptp(q.t) / mean) + 9
        at, size = np.cumsum(mean * g.uniform(0.3, 1.7, n)), g.uniform(0.4, 1.0, n)
        t = q.t - q.t[0]
        last = np.searchsorted(at, t, "right") - 1
        since = t - at[np.maximum(last, 0)]
        return np.where(last >= 0, size[np.maximum(last, 0)] * np.exp(-since / tau), 0.0)

    return both(ax, f, axis="")


@alien
def cools_on_the_table(w: World, r: Rng, ax: int) -> Shape | None:
    """Parts that come warm to the CMM and cool as they are read: lengths are long in the first
    readings of each part and right in the last.  `scale` is the same in all readings."""
    files = [q for q in w.recs if q.kind == "features"]
    if not any(max(i[5] for i in q.meta["info"]) > 1 for q in files):
        return None
    fade = r.uniform(0.15, 0.5)

    def f(q: Rec) -> Array:
        size = np.array([i[3] for i in q.meta["info"]])
        read = np.array([i[5] for i in q.meta["info"]])
        return size / 100 * fade ** (read - 1) * (read.max() > 1)  # else they lay there overnight

    return Shape(lambda q, a: Part(reading=a * f(q)) if q.kind == "features" else Part(), "")


@alien
def warms_while_it_is_cut(w: World, r: Rng, ax: int) -> Shape | None:
    """A part that warms up as it is cut: what is cut later in it comes out short, in every part
    anew.  `scale` does not know the order, `tool_wear` goes on over the parts and knows walls."""
    files = [q for q in w.recs if q.kind == "features"]

    def f(q: Rec) -> Array:
        order = np.array([i[0] for i in q.meta["info"]])
        size = np.array([i[3] for i in q.meta["info"]])
        return -size / 100 * (order > order.max() / 2)

    for q in files:  # a pattern that lengths and walls tell as well is none
        y, rad = f(q), q.meta["radial"]
        known = np.c_[rad, np.array([i[3] for i in q.meta["info"]])]
        rest = y - known @ np.linalg.lstsq(known, y, rcond=None)[0]
        if (rest**2).mean() < 0.3 * (y**2).mean():
            return None
    if not files:
        return None
    return Shape(lambda q, a: Part(reading=a * f(q)) if q.kind == "features" else Part(), "")
