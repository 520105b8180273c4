"""Servo, inertia, vibration, lost steps, loads and tools of the distant family. Do not read while
working on the judged tool.

Signs as in forms_motion and forms_place. Sources: Groß, Hamann and Wiegärtner 2001 (Elektrische
Vorschubantriebe: gain that is lowered from a speed on; gains of axes that are not alike), Tustin
1947 and Erkorkmaz and Altintas 2001 (following error as a series of speed and acceleration),
Biagiotti and Melchiorri 2008 (set points smoothed by moving means), Schmitz et al. 2008 (contouring
errors), ISO/TR 230-8 and Andolfatto et al. 2011 (relative vibration; a bed that recoils), Altintas
et al. 2011 (screws: stiffness by length), Rivin 2003 (mounts), Weck and Brecher 2006 (couplings
that slip; cross compliance), Acarnley 2002 (steps lost at a reversal), Hertz 1882 and Levina 1971
(joints that stiffen), Flugge 1975 (creep of polymer concrete and glued joints), Taylor 1907 and
Altintas 2012 (wear by the length cut; walls by the stiffness across them), Malkin and Guo 2008
(wheels that collapse), ISO 230-3 (tool and holder warm up over the first parts).

Each form says in one line what tells it from its neighbours.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_servo import pair_of, resonate
from .registry import along, both, distant, tool_only, unit_place
from .world import World, lowpass


def in_motion(q: Rec) -> bool:
    """Whether a file is sampled in motion."""
    return q.kind in ("trace", "ballbar")


def speeds(w: World, ax: int) -> bool:
    """Whether a file shows an axis at unlike speeds beside another axis: one speed tells no lag
    from a zero, one axis no lag from a delay."""
    for q in w.recs:
        v = np.abs(q.vel[:, ax])
        v = v[v > 0.05 * max(float(v.max()), 1e-9)]
        if q.kind == "trace" and len(q.moving) > 1 and len(v) > 200 and v.std() > 0.2 * v.mean():
            return True
    return False


@distant("servo_lag")
def gain_lowered_when_fast(w: World, r: Rng, ax: int) -> Shape | None:
    """A loop's gain that is set lower from a speed on: a line with a knee, 8 to 25 % steeper
    beyond; tau is that below it (Groß et al. 2001).  Tells: as speed, one axis only, 0 at rest."""
    if not speeds(w, ax):
        return None
    k, share = r.uniform(0.08, 0.25), r.uniform(0.4, 0.8)
    top = max(float(np.abs(q.vel[:, ax]).max()) for q in w.recs if q.kind == "trace")

    def f(q: Rec) -> Array:
        v = q.vel[:, ax]
        return -(v + k * np.sign(v) * np.maximum(np.abs(v) - share * top, 0))

    return both(ax, f, params=lambda a: {"tau_ms": a})


@distant("servo_lag")
def series_of_two(w: World, r: Rng, ax: int) -> Shape | None:
    """Following error as speed, less acceleration by 1 to 6 ms of it (Tustin 1947; Erkorkmaz and
    Altintas 2001).  Tells: as speed; ramps of it a little early."""
    if not speeds(w, ax):
        return None
    t2 = logu(r, 0.001, 0.006)
    return both(ax, lambda q: -(q.vel[:, ax] - t2 * q.acc[:, ax]), params=lambda a: {"tau_ms": a})


def smoothed(q: Rec, ax: int, span: float) -> Array:
    """Speed (mm/s) behind two moving means of `span` and half of it (s); circles are steady."""
    v = q.vel[:, ax]
    if q.kind != "trace":
        return v
    for s in (span, span / 2):
        n = max(1, round(s * q.meta["rate"]))
        v = lfilter(np.ones(n) / n, [1.0], v)
    return v


@distant("servo_lag")
def smoothed_set_points(w: World, r: Rng, ax: int) -> Shape | None:
    """A lag behind set points that two moving means of 8 to 60 ms have rounded (Biagiotti and
    Melchiorri 2008).  Tells: as speed, one axis only; no overshoot at its corners."""
    if not speeds(w, ax):
        return None
    span = logu(r, 0.008, 0.06)
    return both(ax, lambda q: -smoothed(q, ax, span), params=lambda a: {"tau_ms": a})


def _unlike(w: World, r: Rng, ax: int, one: float, lag) -> Shape | None:
    """Two axes that lag by `one` and by 1 - `one` of a difference, in opposite senses (in a trace
    about alike, for it would tell the lag of a single axis); None where
    neither circles run both ways nor a trace with both axes in motion shows it."""
    pair = pair_of(w, r, ax)
    circles = [q for q in w.recs if q.kind == "ballbar" and sorted(q.meta["plane"]) == pair]
    turns = any(len(np.unique(q.meta["sense"])) > 1 for q in circles)
    if not turns and not any(q.kind == "trace" and set(pair) <= set(q.moving) for q in w.recs):
        return None
    if any(q.kind == "trace" and set(pair) & set(q.moving) for q in w.recs):
        one = 0.35 + 0.3 * one  # else a trace tells the lag of one axis
    sign = pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        if not in_motion(q):
            return Part()
        v = along(q, pair[0], sign * a * one * lag(q, pair[0]))
        v -= along(q, pair[1], sign * a * (1 - one) * lag(q, pair[1]))
        return Part(tool=v, scale=v)

    return Shape(field, AX[pair[0]] + AX[pair[1]], lambda a: {"delta_tau_ms": sign * a})


@distant("servo_mismatch")
def over_and_under(w: World, r: Rng, ax: int) -> Shape | None:
    """One axis fed forward too much and the other too little, a fifth to four fifths each (Schmitz
    et al. 2008).  Tells: ovals at 45 degrees that turn over with the sense of the circle; both
    axes off at speed, to opposite sides."""
    return _unlike(w, r, ax, r.uniform(0.2, 0.8), lambda q, a: q.vel[:, a])


@distant("servo_mismatch")
def behind_unlike_filters(w: World, r: Rng, ax: int) -> Shape | None:
    """As much behind moving means of 8 to 40 ms, one axis taking most of it (Biagiotti and
    Melchiorri 2008).  Tells: as the other one; rounded corners."""
    span, one = logu(r, 0.008, 0.04), float(pick(r, [0.0, 1.0, 0.1, 0.9]))
    return _unlike(w, r, ax, one, lambda q, a: smoothed(q, a, span))


def feeds_differ(w: World) -> bool:
    """Whether accelerations differ: a trace, or circles at two feeds."""
    circles = {q.meta["feed"] for q in w.recs if q.kind == "ballbar"}
    return any(q.kind == "trace" for q in w.recs) or len(circles) > 1


@distant("inertia")
def screw_by_length(w: World, r: Rng, ax: int) -> Shape | None:
    """Mass over a screw that is the softer the longer: 0.5 to 1.5 times as much at its far end; the
    scale sees some of it (Altintas et al. 2011).  Tells: as acceleration, the square of feeds."""
    if not feeds_differ(w):
        return None
    k, share = r.uniform(0.5, 1.5), r.uniform(0.2, 0.6)

    def field(q: Rec, a: float) -> Part:
        v = along(q, ax, -a * q.acc[:, ax] * (1 + k * unit_place(w, ax, q)))
        return Part(tool=v, scale=share * v) if in_motion(q) else Part()

    return Shape(field, AX[ax], most=0.06)


@distant("inertia")
def bed_recoils(w: World, r: Rng, ax: int) -> Shape | None:
    """A bed on its mounts that gives way to the force of a slide, through a well damped mode at 8
    to 25 Hz; no scale sees it (ISO/TR 230-8; Rivin 2003).  Tells: as acceleration, at the tool
    alone."""
    if not feeds_differ(w) or not any(in_motion(q) and q.outside for q in w.recs):
        return None
    hz, zeta = logu(r, 8, 25), r.uniform(0.35, 0.7)

    def f(q: Rec) -> Array:
        a = q.acc[:, ax]
        if q.kind == "trace" and q.meta["rate"] > 4 * hz:
            dt = 1 / q.meta["rate"]
            gain = resonate(np.ones(int(3 / dt)), dt, hz, zeta)[-1]
            a = resonate(a, dt, hz, zeta) / gain
        return -a if in_motion(q) else np.zeros(len(q.t))

    return tool_only(ax, f, most=0.06)


def rate_of(q: Rec) -> float:
    """Samples a second of a file in motion, 0 at rest."""
    return 1 / float(np.median(np.diff(q.t))) if in_motion(q) else 0.0


def highest(w: World, share: float) -> float:
    """A frequency (Hz) that some file in motion samples at least 1 / share times a period."""
    return max(rate_of(q) for q in w.recs) * share


def shown(q: Rec, hz: float) -> bool:
    """Whether a file shows a tone; slower ones average it away."""
    return rate_of(q) > 2.6 * hz


@distant("vibration")
def mode_of_a_ram(w: World, r: Rng, ax: int) -> Shape | None:
    """A motor out of balance at a fixed speed shakes a slide, 0.4 to 1 by the place of another axis
    (Weck and Brecher 2006).  Tells: one frequency in time whatever the feed, at rest as well."""
    top = highest(w, 1 / 4)
    if top < 3:
        return None
    hz, ph, k = logu(r, 2.5, min(top, 60.0)), r.uniform(0, 6.28), r.uniform(0.2, 0.6)
    other = int(pick(r, [a for a in w.machine.axes if a != ax]))

    def f(q: Rec) -> Array:
        far = 1 - k + k * unit_place(w, other, q)
        return far * np.sin(2 * np.pi * hz * q.t + ph) * shown(q, hz)

    make = both if r.random() < 0.6 else tool_only
    return make(ax, f, params=lambda a: {"frequency_hz": hz})


@distant("vibration")
def compressor(w: World, r: Rng, ax: int) -> Shape | None:
    """A chiller's compressor that runs for a half to nine tenths of each cycle; its tone and some
    of its second (ISO/TR 230-8).  Tells: one frequency, on and off with no regard to motion."""
    top = highest(w, 1 / 5)
    if top < 3:
        return None
    hz, ph, k = logu(r, 2.5, min(top, 30.0)), r.uniform(0, 6.28, 2), r.uniform(0, 0.4)
    cycle, on, at = logu(r, 6, 60), r.uniform(0.5, 0.9), r.uniform(0, 1)

    def f(q: Rec) -> Array:
        u = (q.t / cycle + at) % 1.0
        gate = np.clip(u / 0.04, 0, 1) * np.clip((on - u) / 0.04, 0, 1)
        th = 2 * np.pi * hz * q.t
        return gate * (np.sin(th + ph[0]) + k * np.sin(2 * th + ph[1])) * shown(q, 2 * hz)

    make = both if r.random() < 0.4 else tool_only
    return make(ax, f, params=lambda a: {"frequency_hz": hz})


def _slips(w: World, r: Rng, ax: int, turn: bool, rows: int) -> Shape | None:
    """A jump within one file, at a reversal of the axis (`turn`) or where it is fastest, spread
    over some rows; it stays in what follows."""
    live = [
        q
        for q in w.recs
        if ax in q.moving
        and q.kind in ("targets", "trace")
        and q.n_obs > 20
        and (q.kind == "trace" or q.meta["quantity"] == "displacement")
    ]
    if not live:
        return None
    q0 = pick(r, live)
    n, step = len(q0.t), np.abs(np.diff(q0.sgn[:, ax], prepend=q0.sgn[0, ax]))
    if not turn:
        step = np.abs(np.diff(q0.pos[:, ax], prepend=q0.pos[0, ax]))
        step = step * (step > np.quantile(step, 0.8))
    mid = np.flatnonzero(step > 0)
    mid = mid[(mid > n // 5) & (mid < n - n // 5)]
    if not mid.size:
        return None
    i = int(pick(r, mid))
    j = min(i + rows, n - 1)
    t0, t1, sign = float(q0.t[i - 1] + q0.t[i]) / 2, float(q0.t[j]), pick(r, [-1.0, 1.0])

    def f(q: Rec) -> Array:
        return sign * np.clip((q.t - t0) / max(t1 - t0, 1e-3), 0, 1) * (q.t > t0)

    return both(ax, f, params=lambda a: {"jump_um": sign * a, "t_s": round((t0 + t1) / 2, 3)})


@distant("step_loss")
def slips_as_it_turns(w: World, r: Rng, ax: int) -> Shape | None:
    """A coupling on its cone or a stepper that slips as the axis turns round (Acarnley 2002).
    Tells: one step that stays, at all places alike."""
    return _slips(w, r, ax, True, 0)


@distant("step_loss")
def creeps_through(w: World, r: Rng, ax: int) -> Shape | None:
    """A clamping ring that gives way in the course of one or two fast moves (Weck and Brecher
    2006).  Tells: within a few rows, then it stays."""
    return _slips(w, r, ax, False, int(r.integers(1, 4)))


@distant("force_compliance")
def gives_way_askew(w: World, r: Rng, ax: int) -> Shape:
    """A slide that gives way along the load and, a tenth to a half as much, across it (Weck and
    Brecher 2006).  Tells: as the load's column, in two directions."""
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))
    k = r.uniform(0.1, 0.5) * pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        n = a * w.force(q, ax)
        return Part(tool=along(q, ax, n) + along(q, to, k * n))

    return Shape(field, AX[ax], lambda a: {"um_per_N": a}, most=2.0)


@distant("force_compliance")
def joints_stiffen(w: World, r: Rng, ax: int) -> Shape:
    """Joints that close as they are loaded: n / (1 + |n| / n0) (Hertz; Levina 1971).  Tells: as the
    load's column, odd in it, less than in proportion."""
    k = r.uniform(0.5, 2.0)

    def f(q: Rec) -> Array:
        n, top = w.force(q, ax), max(float(np.abs(w.load[ax]).max()), 1.0)
        return n * (1 + k) / (1 + k * np.abs(n) / top)

    return tool_only(ax, f, most=2.0)


@distant("force_compliance")
def creeps_under_load(w: World, r: Rng, ax: int) -> Shape:
    """Glue and polymer concrete: 60 to 90 % at once, the rest within 1 to 10 minutes, back likewise
    (Flugge 1975).  Tells: as the load's column, with a tail."""
    k, tau = r.uniform(0.1, 0.4), logu(r, 60, 600)
    late = lowpass(w.load[ax], float(w.grid[1]), tau, 0.0)
    return tool_only(ax, lambda q: (1 - k) * w.force(q, ax) + k * w.at(late, q.t), most=2.0)


def _radial(amount, told=lambda a: {}) -> Shape:
    """What a tool's radius does to parts: a * amount(q) for each reading, times `radial`."""

    def field(q: Rec, a: float) -> Part:
        return Part(reading=a * amount(q) * q.meta["radial"]) if q.kind == "features" else Part()

    return Shape(field, "", told)


def since_change(q: Rec) -> Array:
    """Number of the part since the tool was new, 0 for the first, for each reading."""
    k = q.meta["part"] - 1.0
    return np.where(q.meta["part"] >= q.meta["change"], k - q.meta["change"] + 1, k)


@distant("tool_wear")
def by_length_cut(w: World, r: Rng, ax: int) -> Shape:
    """Wear by the length that has been cut, feature by feature within a part as well (Taylor 1907).
    Tells: walls in and out go apart, from part to part, back at the change."""
    first = r.uniform(0.0, 0.4)

    def amount(q: Rec) -> Array:
        size = {i[0]: i[3] for i in q.meta["info"]}
        before = dict(zip(size, np.cumsum([0.0, *size.values()][:-1]), strict=True))
        done = np.array([before[i[0]] + i[3] / 2 for i in q.meta["info"]]) / sum(size.values())
        s = (since_change(q) + done) / 8
        return -2 * (s + first * -np.expm1(-s / 0.05) * 0.3)

    return _radial(amount)


@distant("tool_wear")
def wheel_collapses(w: World, r: Rng, ax: int) -> Shape:
    """Wear that runs away at the end of a tool's or a wheel's life (Malkin and Guo 2008).  Tells: a
    ramp that steepens from part to part, back at the change."""
    k = r.uniform(1.0, 3.5)

    def amount(q: Rec) -> Array:
        return -2 * np.expm1(k * (since_change(q) + 0.5) / 8) / np.expm1(k)

    return _radial(amount)


@distant("tool_size")
def holder_warms_up(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter, of which a twentieth to a fifth is not yet there in the first parts (ISO
    230-3).  Tells: bores and pockets off one way, bosses the other, whatever their size."""
    sign, k, n = pick(r, [-1.0, 1.0]), r.uniform(0.05, 0.2), r.uniform(0.7, 2.0)
    return _radial(
        lambda q: sign * (1 - k * np.exp(-(q.meta["part"] - 1) / n)),
        lambda a: {"diameter_um": sign * a},
    )


@distant("tool_size")
def stiffer_one_way(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter; the tool bends from walls, and does so 5 to 15 % more across one axis than
    across the other (Altintas 2012).  Tells: as the other one, both axes nearly alike."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.05, 0.15) * pick(r, [-1.0, 1.0])

    def amount(q: Rec) -> Array:
        axis = np.array([i[2] for i in q.meta["info"]])
        return sign * (1 + k * np.where(axis == axis.min(), 1.0, -1.0))

    return _radial(amount, lambda a: {"diameter_um": sign * a})
