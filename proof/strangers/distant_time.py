"""Heat, drift, spindle and instrument of the distant family. Do not read while working on the
judged tool.

Conventions as in forms_time. Sources: ISO 230-3:2020 (axes at work, clause 7; environment, clause
5; spindle, clause 6), Mayr et al. 2012 (Thermal issues in machine tools; CIRP Annals 61), Li et al.
1997 (a nut as moving source), Huang 1995 (screws: nut and bearings as sources), Bryan 1990
(gradients), Harris and Kotzalas 2006 and Palmgren 1959 (friction of bearings: speed to the power of
5/3; cooling by rotation), Abele, Altintas and Brecher 2010 (Machine tool spindle units; CIRP Annals
59: rotors shorten as they spin), Bobroff 1993 (Recent advances in displacement measuring
interferometry: layers of air, dead path), ISO 230-2 annex A and Birch and Downs 1993 (index of air
by temperature and pressure), Agilent's manual of the 5530 (dead path, cosine error), Steinmetz 1990
(alignment), Erkorkmaz and Altintas 2001 (filters in the loop), IEEE 1588 and Allan 1987 (clocks),
Lyons 2011 (moving averages, buffers).

Each form says in one line what tells it from its neighbours.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick, stream
from .forms_time import sensed
from .registry import distant, tool_only
from .world import World, lowpass


@distant("screw_heat")
def bearing_block_too(w: World, r: Rng, ax: int) -> Shape:
    """A screw that grows from its fixed bearing, whose block grows as well, a few minutes later
    (Huang 1995).  Tells: growth with place that comes with work and goes with rest."""
    lo, hi = w.machine.travel[ax]
    flip, k = r.random() < 0.5, r.uniform(0.03, 0.12) * (hi - lo)
    late = lowpass(w.screw[ax], float(w.grid[1]), logu(r, 200, 900), 0.0)

    def f(q: Rec) -> Array:
        d = (q.pos[:, ax] - hi - 60) if flip else (q.pos[:, ax] - lo + 60)
        block = k * w.at(late, q.t) * (-1 if flip else 1)
        return 0.0115 * (w.at(w.screw[ax], q.t) * d + block)

    return tool_only(ax, f, most=1.5)


@distant("screw_heat")
def worked_stretch(w: World, r: Rng, ax: int) -> Shape:
    """A screw warm where the nut works and cool beyond: growth within that stretch, a shift behind
    it, nothing before it (Li et al. 1997).  Tells: growth that comes with work and goes with rest,
    in part of the travel."""
    lo, hi = w.machine.travel[ax]
    a, b = r.uniform(0.05, 0.25), r.uniform(0.75, 0.95)
    flip, soft = r.random() < 0.5, r.uniform(0.03, 0.08)
    x = np.linspace(-0.1, 1.1, 481)
    warm = 1 / (1 + np.exp((a - x) / soft)) - 1 / (1 + np.exp((b - x) / soft))
    grow = np.cumsum(warm) * (x[1] - x[0]) * (hi - lo)
    grow = grow - (grow[-1] if flip else 0.0)

    def f(q: Rec) -> Array:
        s = (q.pos[:, ax] - lo) / (hi - lo)
        return 0.0115 * w.at(w.screw[ax], q.t) * np.interp(s, x, grow)

    return tool_only(ax, f, most=1.5)


@distant("screw_heat")
def cools_better_when_hot(w: World, r: Rng, ax: int) -> Shape:
    """The whole screw warm alike, but the rise of its core flattens against that of its surface, as
    an oil bath takes more (Mayr et al. 2012).  Tells: as the others; it saturates."""
    lo, hi = w.machine.travel[ax]
    fix = hi + 40 if r.random() < 0.5 else lo - 40
    top = max(float(w.screw[ax].max()), 1e-9)
    k = r.uniform(0.3, 1.0)

    def f(q: Rec) -> Array:
        u = w.at(w.screw[ax], q.t) / top
        return 0.0115 * top * u * (1 + k) / (1 + k * u) * (q.pos[:, ax] - fix)

    return tool_only(ax, f, most=1.5)


def _drift(course) -> None:
    @distant("structure_drift")
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, series = sensed(w, r), course(w, r)
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


def _tank(w: World, r: Rng) -> Array:
    """Coolant that a pump warms from the start flushes a bed: two lags in a row, an S (ISO 230-3).
    Tells: slow, the same wherever the axes stand, from standing files too."""
    dt, tau = float(w.grid[1]), r.uniform(0.06, 0.25) * float(w.grid[-1])
    return 3 * lowpass(lowpass(np.ones(len(w.grid)), dt, tau, 0.0), dt, tau, 0.0)


def _gradient(w: World, r: Rng) -> Array:
    """A column that bends as its skin is warmer than its core: what air does within minutes less
    what the frame does within hours (Bryan 1990).  Tells: it follows the air, and comes back."""
    return lowpass(w.air, float(w.grid[1]), logu(r, 200, 900)) - w.frame


def _after_the_shift(w: World, r: Rng) -> Array:
    """A machine that worked before the test and cools down, quickly in its thin and slowly in its
    thick parts (Mayr et al. 2012).  Tells: largest slope at the start, whatever the axes do."""
    g, end, k = w.grid, float(w.grid[-1]), r.uniform(0.3, 0.7)
    tau = r.uniform(0.05, 0.2) * end
    return 3 * (k * np.exp(-g / tau) + (1 - k) * np.exp(-g / (5 * tau)))


_drift(_tank)
_drift(_gradient)
_drift(_after_the_shift)


def _along_the_spindle(w: World, r: Rng, lean: float) -> Array:
    """Where a nose goes: along its axis (Z; some grinders' X), and by `lean` across."""
    if len(w.machine.axes) == 2:
        main, side = (0, 2) if w.machine.kind == "grinder" and r.random() < 0.5 else (2, 0)
    else:
        main, side = 2, int(r.integers(0, 2))
    d = np.zeros(3)
    d[main], d[side] = -1.0, lean * r.normal()
    return d


@distant("spindle_growth")
def blown_cool(w: World, r: Rng, ax: int) -> Shape | None:
    """Heat by speed to the power of 5/3; while it turns it cools itself and has one time constant,
    while it stands another, two to four times as long (Palmgren; Harris).  Tells: it follows the
    speed's programme, up sooner than down."""
    if not w.rpm.any():
        return None
    d, dt = _along_the_spindle(w, r, 0.2), float(w.grid[1])
    up = logu(r, 300, 1500)
    down, y, out = up * r.uniform(2, 4), 0.0, []
    for heat in ((w.rpm / 8000) ** (5 / 3)).tolist():
        y += (heat - y) * min(dt / (up if heat > 0 else down), 1.0)
        out.append(y)
    series = np.array(out)
    return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=80.0)


@distant("spindle_growth")
def rotor_shortens(w: World, r: Rng, ax: int) -> Shape | None:
    """A nose drawn in at once as the square of speed, and then out with heat (Abele et al. 2010).
    Tells: a step at each change of speed against the growth that follows."""
    if not w.rpm.any():
        return None
    d, dt, k = _along_the_spindle(w, r, 0.15), float(w.grid[1]), r.uniform(0.1, 0.3)
    n = w.rpm / 8000
    series = lowpass(n ** r.uniform(1.2, 1.7), dt, logu(r, 400, 1800), 0.0) - k * n**2
    return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=80.0)


def beams(w: World, ax: int) -> list[Rec]:
    """Files of a laser that senses an axis; gauges and probes have no beam."""
    return [
        q
        for q in w.recs
        if q.laser and "laser" in q.meta["instrument"] and abs(q.meta["sensitive"][ax]) > 0.1
    ]


def has_beam(q: Rec) -> bool:
    """Whether a file's readings are those of a beam of light."""
    return q.laser and "laser" in q.meta["instrument"]


def path_of(q: Rec, far: bool, gap: float = 40.0) -> Array:
    """Signed length (mm) of the beam, + if the reading grows with it."""
    x = q.pos @ q.meta["sensitive"]
    return x - x.max() - gap if far else x - x.min() + gap


def index(air: Array, hpa: Array) -> Array:
    """Part of the index of air that goes with temperature (K above 20 C) and pressure (hPa above
    the usual), 1e-3 each um per mm: -0.93 and +0.268 ppm (Birch and Downs 1993)."""
    return (-0.93 * air + 0.268 * hpa) * 1e-3


def _letter(w: World) -> str:
    """Letter of the axis if the beams look along one only, else nothing."""
    seen = {
        AX[a]
        for q in w.recs
        if has_beam(q)
        for a in w.machine.axes
        if abs(q.meta["sensitive"][a]) > 0.1
    }
    return seen.pop() if len(seen) == 1 else ""


@distant("laser_air")
def layers_along_the_beam(w: World, r: Rng, ax: int) -> Shape | None:
    """The hall's air moves and no sensor follows; it moves more the farther from the head, towards
    the machine (Bobroff 1993).  Tells: with the length of the beam and the air of that minute."""
    if not beams(w, ax):
        return None
    far, k = r.random() < 0.5, r.uniform(0.2, 0.8)
    n = index(w.air, w.pressure)

    def field(q: Rec, a: float) -> Part:
        if not has_beam(q):
            return Part()
        d = path_of(q, far)
        more = 1 + k * (np.abs(d) / max(float(np.abs(d).max()), 1e-9) - 0.5)
        return Part(reading=a * w.at(n, q.t) * d * more)

    return Shape(field, _letter(w), most=1.3)


@distant("laser_air")
def sensor_not_soaked(w: World, r: Rng, ax: int) -> Shape | None:
    """A sensor of air that came in from the cold or from a warm case and takes 10 to 40 minutes to
    be right, and a barometer that is read once a file.  Tells: with the length of the beam, most at
    the start, gone by the end, without any work of the axes."""
    mine = beams(w, ax)
    if not mine:
        return None
    far, tau, off = r.random() < 0.5, r.uniform(600, 2400), pick(r, [-1, 1]) * r.uniform(3, 10)
    start = min(float(q.t[0]) for q in mine)
    if not any(q.t[0] < start + 60 and q.t[-1] > start + 1.2 * tau for q in mine):
        return None  # that it fades is not seen
    once = {q.name: float(w.at(w.pressure, q.t[:1])[0]) for q in w.recs if has_beam(q)}

    def field(q: Rec, a: float) -> Part:
        if not has_beam(q):
            return Part()
        wrong = off * np.exp(-np.maximum(q.t - start, 0) / tau)
        n = index(wrong, w.at(w.pressure, q.t) - once[q.name])
        return Part(reading=a * n * path_of(q, far))

    return Shape(field, _letter(w), most=1.3)


@distant("dead_path")
def zeroed_now_and_then(w: World, r: Rng, ax: int) -> Shape | None:
    """A dead path of 1 to 3.5 m whose reading is zeroed anew every four to eight runs (Agilent).
    Tells: at all places alike, nothing after a zero, with the air of that minute."""
    mine = beams(w, ax)
    if not mine or not any(len(np.unique(q.run)) > 3 and np.ptp(q.t) > 900 for q in mine):
        return None
    side, dead, n = pick(r, [-1.0, 1.0]), r.uniform(1000, 3500), index(w.air, w.pressure)
    every = int(r.integers(4, 9))

    def field(q: Rec, a: float) -> Part:
        if not has_beam(q):
            return Part()
        y = w.at(n, q.t)
        first = np.searchsorted(q.run, q.run - (q.run - 1) % every)
        return Part(reading=a * side * dead * (y - y[first]))

    return Shape(field, "", most=1.3)


@distant("dead_path")
def over_a_warm_bed(w: World, r: Rng, ax: int) -> Shape | None:
    """A dead path over the machine's own bed: its air is half the hall's and half the frame's, with
    a little of the screw's (Bobroff 1993).  Tells: at all places alike, in files of a beam alone,
    a few um for each metre and kelvin."""
    if not beams(w, ax):
        return None
    side, dead, k = pick(r, [-1.0, 1.0]), r.uniform(1000, 3500), r.uniform(0.3, 0.7)
    air = k * w.air + (1 - k) * w.frame + 0.15 * w.screw[ax]
    n = index(air, w.pressure)

    def field(q: Rec, a: float) -> Part:
        if not has_beam(q):
            return Part()
        y = w.at(n, q.t)
        return Part(reading=a * side * dead * (y - y[0]))

    return Shape(field, "", most=1.3)


@distant("cosine")
def along_a_curved_way(w: World, r: Rng, ax: int) -> Shape | None:
    """A beam that is off the way by an angle that the way's own curve takes on or off: short by the
    integral of its square; one set-up of two or more (Steinmetz 1990).  Tells: short, and not in
    the other set-ups of the axis."""
    mine = beams(w, ax)
    if len(mine) < 2:
        return None
    one, k = pick(r, mine).name, r.uniform(-0.25, 0.25)

    def field(q: Rec, a: float) -> Part:
        if q.name != one:
            return Part()
        x = q.pos @ q.meta["sensitive"]
        u = (x - x.min()) / max(float(np.ptp(x)), 1e-9)
        return Part(reading=-a * float(np.ptp(x)) / 1e3 * (u + k * u**2 + (k * u) ** 2 * u / 3))

    return Shape(field, AX[ax])


@distant("cosine")
def set_right_between_runs(w: World, r: Rng, ax: int) -> Shape | None:
    """A beam that somebody sets right between two runs: short before, a tenth of that after
    (Agilent).  Tells: a slope that ends at a run's start, with no heat about."""
    mine = [q for q in beams(w, ax) if len(np.unique(q.run)) > 1]
    if not mine:
        return None
    q0, rest = pick(r, mine), r.uniform(0.0, 0.12)
    last = int(pick(r, np.unique(q0.run)[:-1]))

    def field(q: Rec, a: float) -> Part:
        if q.name != q0.name:
            return Part()
        x = q.pos @ q.meta["sensitive"]
        return Part(reading=-a * (x - x.min()) / 1e3 * np.where(q.run <= last, 1.0, rest))

    return Shape(field, AX[ax])


def several_in_motion(w: World) -> bool:
    """Whether a file samples two axes or more in motion: one axis alone tells no lag from a
    delay."""
    return any(q.kind == "trace" and len(q.moving) > 1 for q in w.recs)


def _late(effect: str, field) -> None:
    """Files field(q, a, c) (um, n x 3) of traces; c holds constants 0..1."""

    @distant(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not several_in_motion(w):
            return None
        c = r.uniform(0, 1, 4)
        return Shape(
            lambda q, a: Part(reading=field(q, a, c)) if q.kind == "trace" else Part(),
            "",
            lambda a: {"delay_ms": a} if effect == "delay" else {},
        )


def _moving_mean(q: Rec, a: float, c: Array) -> Array:
    """A logger's moving mean of 4 to 40 ms, late by a (Lyons).  Tells: all axes late alike, in
    every feed; corners of the speed are rounded."""
    n = max(2, round((0.004 + 0.036 * c[0]) * q.meta["rate"]))
    return -a * lfilter(np.ones(n) / n, [1.0], q.vel, axis=0)


def _bus(q: Rec, a: float, c: Array) -> Array:
    """Samples that wait for a bus whose cycle is not theirs: late by 0.8 to 1.2 of the mean, a saw
    in time.  Tells: all axes late alike."""
    p = 0.3 + 4 * c[0]
    saw = (q.t / p + c[1]) % 1.0 - 0.5
    return -a * q.vel * (1 + 0.4 * saw)[:, None]


def _dropped(q: Rec, a: float, c: Array) -> Array:
    """Samples lost at 3 to 8 odd moments: later by unlike steps, never earlier.  Tells: all axes
    alike, nothing at the start, all of it at the end."""
    g = stream("dropped", *c.tolist(), q.name)
    n = 3 + int(6 * c[0])
    at, size = np.sort(g.uniform(0.05, 0.9, n)), g.uniform(0.3, 1.0, n)
    u = (q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9)
    return -a * q.vel * ((u[:, None] > at) @ size / size.sum())[:, None]


def _quartz_warms(q: Rec, a: float, c: Array) -> Array:
    """A clock whose rate is off and settles as its quartz warms up (Allan 1987).  Tells: all axes
    alike, later and later, most so at first."""
    u = (q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9)
    k, tau = 0.2 + 0.6 * c[0], 0.1 + 0.3 * c[1]
    return -a * q.vel * ((1 - k) * u + k * -np.expm1(-u / tau) / -np.expm1(-1 / tau))[:, None]


_late("delay", _moving_mean)
_late("delay", _bus)
_late("clock_skew", _dropped)
_late("clock_skew", _quartz_warms)
