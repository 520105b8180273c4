"""Heat, drift, spindle and instrument of the later family.  Do not read while working on the judged
tool.

Conventions as in forms_time.  Sources: Weck and Brecher 2006 and Mayr et al. 2012 (hollow screws
that oil flows through; yielding bearings on both sides), Bryan 1968 (International status of
thermal error research: rooms whose control switches), Ramesh, Mannan and Poo 2000 (two thermal
masses), ISO 230-3:2020 (spindles whose chiller switches; directions that warm up with unlike time
constants), Edlen 1966 and Ciddor 1996 (index of air), Renishaw's notes on the XL-80 and XC-80 (a
sensor of air in the wrong place; values that are entered by hand; dead path; a head
that warms its surroundings), ISO 230-1:2012 and Steinmetz 1990 (alignment, stands that sink),
Bessel filters (Thomson 1949: constant delay), Mills
1991 (clocks that are slewed), Allan 1987 (quartz in a room that warms and cools).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import bilinear, lfilter

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .forms_time import beam, lasers, sensed
from .registry import later, tool_only
from .sealed_time import edlen
from .world import World, lowpass


@later("screw_heat")
def oil_flows_through(w: World, r: Rng, ax: int) -> Shape:
    """A hollow screw whose oil comes in cool at the fixed bearing and is warmed on its way: the
    rise goes with the length, the growth with its square (Weck and Brecher 2006)."""
    lo, hi = w.machine.travel[ax]
    flip, rest = r.random() < 0.5, r.uniform(0.1, 0.4)

    def f(q: Rec) -> Array:
        d = (hi + 50 - q.pos[:, ax]) if flip else (q.pos[:, ax] - lo + 50)
        grow = rest * d + (1 - rest) * d**2 / (hi - lo + 50)
        return 0.0115 * w.at(w.screw[ax], q.t) * grow * (-1 if flip else 1)

    return tool_only(ax, f, most=3.0)


@later("screw_heat")
def yields_on_both_sides(w: World, r: Rng, ax: int) -> Shape:
    """A screw between two bearings that both give way: it grows to either side of a place between
    a fifth and four fifths of its length, a little late (Mayr et al. 2012)."""
    lo, hi = w.machine.travel[ax]
    still, held = lo + r.uniform(0.2, 0.8) * (hi - lo), r.uniform(0.6, 1.0)
    warm = lowpass(w.screw[ax], float(w.grid[1]), logu(r, 60, 600), 0.0)
    return tool_only(
        ax, lambda q: 0.0115 * held * w.at(warm, q.t) * (q.pos[:, ax] - still), most=4.0
    )


def _drift(course) -> None:
    @later("structure_drift")
    def f(w: World, r: Rng, ax: int) -> Shape:
        d, series = sensed(w, r), course(w, r)
        return Shape(lambda q, a: Part(tool=a * w.at(series, q.t)[:, None] * d), "", most=15.0)


def _two_masses(w: World, r: Rng) -> Array:
    """A thin and a heavy part of a frame that warm up with a switch-on some way into the test."""
    end, dt = float(w.grid[-1]), float(w.grid[1])
    on = (w.grid > r.uniform(0, 0.25) * end) * 1.0
    fast, k = r.uniform(0.02, 0.1) * end, r.uniform(0.3, 0.6)
    return 3 * (k * lowpass(on, dt, fast, 0.0) + (1 - k) * lowpass(on, dt, 8 * fast, 0.0))


def _switched_room(w: World, r: Rng) -> Array:
    """A room that is heated up to one limit and cools to another: unlike ramps by turns, as a
    frame follows them (Bryan 1968)."""
    end, up = float(w.grid[-1]), r.uniform(0.2, 0.5)
    period = end / r.uniform(1.5, 5)
    u = (w.grid / period + r.uniform(0, 1)) % 1.0
    tri = np.where(u < up, u / up, (1 - u) / (1 - up)) * 3
    return lowpass(tri, float(w.grid[1]), r.uniform(0.05, 0.2) * period)


_drift(_two_masses)
_drift(_switched_room)


def _nose(w: World, r: Rng) -> Array:
    """Direction in which a spindle's nose grows, mostly along its axis."""
    if len(w.machine.axes) == 2:
        return np.array([-1.0, 0.0, 0.3 * r.normal()] if r.random() < 0.4 else [0.2, 0.0, -1.0])
    return np.array([0.1 * r.normal(), 0.2 * r.normal(), -1.0])


@later("spindle_growth")
def chiller_switches(w: World, r: Rng, ax: int) -> Shape | None:
    """Growth towards a level that goes as a power of speed, with a tenth to a quarter more and less
    of it as the chiller switches every 3 to 10 minutes (ISO 230-3)."""
    if not w.rpm.any():
        return None
    d, dt = _nose(w, r), float(w.grid[1])
    y = lowpass((w.rpm / 8000) ** r.uniform(1.0, 1.6), dt, logu(r, 400, 1500), 0.0)
    saw = 2 * ((w.grid / r.uniform(180, 600)) % 1.0) - 1
    y = y * (1 + r.uniform(0.1, 0.25) * lowpass(saw, dt, 20.0))
    return Shape(lambda q, a: Part(tool=a * w.at(y, q.t)[:, None] * d), "", most=80.0)


@later("spindle_growth")
def shaft_and_headstock(w: World, r: Rng, ax: int) -> Shape | None:
    """The shaft grows along its axis with minutes, the headstock lifts or leans across with the
    better part of an hour (ISO 230-3)."""
    if not w.rpm.any():
        return None
    d, dt, loss = _nose(w, r), float(w.grid[1]), (w.rpm / 8000) ** r.uniform(1.2, 2.0)
    tau = logu(r, 200, 900)
    soon, late = lowpass(loss, dt, tau, 0.0), lowpass(loss, dt, tau * r.uniform(3, 6), 0.0)
    main = int(np.argmax(np.abs(d)))
    side = np.zeros(3)
    side[pick(r, [a for a in w.machine.axes if a != main])] = r.uniform(0.2, 0.6) * pick(r, [-1, 1])

    def field(q: Rec, a: float) -> Part:
        along = w.at(soon, q.t)[:, None] * d
        return Part(tool=a * (along + w.at(late, q.t)[:, None] * side))

    return Shape(field, "", most=80.0)


def _lit(w: World) -> str:
    """Letter of the axis if the lasers look along one only, else nothing."""
    seen = {
        AX[a]
        for q in w.recs
        if q.laser
        for a in w.machine.axes
        if abs(q.meta["sensitive"][a]) > 0.1
    }
    return seen.pop() if len(seen) == 1 else ""


@later("laser_air")
def sensor_in_the_cabinet(w: World, r: Rng, ax: int) -> Shape | None:
    """The sensor of air lies on the machine and shows half frame, half air: the index of the air
    between them is left (note on the XC-80; Edlen's index)."""
    if not lasers(w, ax):
        return None
    far, share = r.random() < 0.5, r.uniform(0.4, 0.9)
    shown = (1 - share) * w.air + share * (w.frame + 0.3 * w.screw[ax])
    left = (edlen(w.air, w.pressure) - edlen(shown, w.pressure)) * 1e-3

    def field(q: Rec, a: float) -> Part:
        return Part(reading=a * w.at(left, q.t) * beam(w, q, far)) if q.laser else Part()

    return Shape(field, _lit(w), most=4.0)


def dead_band(x: Array, band: float) -> Array:
    """What is shown of x by something that is renewed once x has gone `band` away from it."""
    shown, out = float(x[0]), np.empty(len(x))
    for i, v in enumerate(x.tolist()):
        if abs(v - shown) > band:
            shown = v
        out[i] = shown
    return out


@later("laser_air")
def renewed_by_hand(w: World, r: Rng, ax: int) -> Shape | None:
    """Air that is typed in anew when somebody sees the thermometer to have gone one to
    two and a half kelvin away, and the barometer 1 to 4 hPa (XL-80; Edlen's index)."""
    if not lasers(w, ax):
        return None
    far = r.random() < 0.5
    air = dead_band(w.air, r.uniform(1.0, 2.5))
    weight = dead_band(w.pressure, r.uniform(1.0, 4.0))
    left = (edlen(w.air, w.pressure) - edlen(air, weight)) * 1e-3

    def field(q: Rec, a: float) -> Part:
        return Part(reading=a * w.at(left, q.t) * beam(w, q, far)) if q.laser else Part()

    return Shape(field, _lit(w), most=4.0)


@later("dead_path")
def warm_head(w: World, r: Rng, ax: int) -> Shape | None:
    """A dead path before a laser's head that was switched on late and warms its air by 1 to 3 K
    within half an hour or so, and what the hall's air does besides (Edlen's index)."""
    if not lasers(w, ax):
        return None
    side, dead = pick(r, [-1.0, 1.0]), r.uniform(400, 2000)
    start = min(float(q.t[0]) for q in w.recs if q.laser) - r.uniform(0, 600)
    rise = r.uniform(1, 3) * -np.expm1(-np.maximum(w.grid - start, 0) / logu(r, 500, 2500))
    index = edlen(w.air + rise, w.pressure) * 1e-3

    def field(q: Rec, a: float) -> Part:
        if not q.laser:
            return Part()
        n = w.at(index, q.t)
        return Part(reading=a * side * dead * (n - n[0]))

    return Shape(field, "", most=3.0)


@later("cosine")
def each_set_up(w: World, r: Rng, ax: int) -> Shape | None:
    """Each set-up of the axis by itself is a little off, and so are diagonals: short by amounts as
    the squares of its angles (ISO 230-1)."""
    mine = lasers(w, ax)
    if not mine:
        return None
    off = {q.name: 1.0 if i == 0 else r.uniform(0.2, 1.0) for i, q in enumerate(mine)}

    def field(q: Rec, a: float) -> Part:
        if q.name not in off:
            return Part()
        x = q.pos @ q.meta["sensitive"]
        return Part(reading=-a * off[q.name] * (x - x.min()) / 1e3)

    return Shape(field, AX[ax])


@later("cosine")
def sinking_stand(w: World, r: Rng, ax: int) -> Shape | None:
    """A stand whose beam was off from the start and sinks further: short by the square of an angle
    that grows by up to a fifth in the file (Steinmetz 1990)."""
    mine = lasers(w, ax)
    if not mine:
        return None
    one, k = pick(r, mine).name, r.uniform(-0.15, 0.2)

    def field(q: Rec, a: float) -> Part:
        if not q.laser or q.name != one:
            return Part()
        x, u = q.pos @ q.meta["sensitive"], (q.t - q.t[0]) / max(float(np.ptp(q.t)), 1e-9)
        return Part(reading=-a * (x - x.min()) / 1e3 * (1 + k * u) ** 2)

    return Shape(field, AX[ax])


def _late(effect: str, field, linear: bool = True) -> None:
    """Files field(q, a, c) (um, n x 3) of traces; c holds constants 0..1."""

    @later(effect)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        if not any(q.kind == "trace" for q in w.recs):
            return None
        c = r.uniform(0, 1, 3)
        return Shape(
            lambda q, a: Part(reading=field(q, a, c)) if q.kind == "trace" else Part(),
            "",
            lambda a: {"delay_ms": a} if effect == "delay" else {},
            linear=linear,
        )


def _bessel(q: Rec, a: float, c: Array) -> Array:
    """An instrument's Bessel filter of the second order: 3 / (s^2 + 3 s + 3), delay 1."""
    tau = max(a, 1e-3) / 1e3
    num, den = bilinear([3.0], [tau**2, 3 * tau, 3.0], q.meta["rate"])
    return -a * lfilter(num, den, q.vel, axis=0)


def share_of(q: Rec) -> Array:
    """Time within the file, 0..1."""
    return (q.t - q.t[0]) / max(float(q.t[-1] - q.t[0]), 1e-9)


def _slewed(q: Rec, a: float, c: Array) -> Array:
    """A clock that runs away for a half to three quarters of the file and is slewed back."""
    top, u = 0.45 + 0.3 * c[0], share_of(q)
    return -a * q.vel * np.minimum(u / top, 1 - (0.4 + 0.6 * c[1]) * (u - top) / (1 - top))[:, None]


def _warm_and_cool(q: Rec, a: float, c: Array) -> Array:
    """A quartz whose rate swings with the temperature: it runs away in steps without corners."""
    u, n = share_of(q), 1 + 3 * c[0]
    swing = (0.4 + 0.5 * c[1]) / (2 * np.pi * n)
    return -a * q.vel * (u - swing * np.sin(2 * np.pi * n * u))[:, None]


_late("delay", _bessel, linear=False)
_late("clock_skew", _slewed)
_late("clock_skew", _warm_and_cool)
