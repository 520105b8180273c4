"""Friction and lost motion of the apart family.  Do not read while working on the judged tool.

Signs and what sees what as in forms_motion.  Sources: ISO 230-2:2014 (reversal value of each
target), ISO 230-4 with Kakino, Ihara and Nakatsu 1993 (Accuracy inspection of NC machine tools by
double ball bar method: lost motion and stick motion at quadrants) and Renishaw's manual of the QC20
(backlash that the control needs time to take up, reversal spikes), Armstrong-Helouvry, Dupont and
Canudas de Wit 1994 (Automatica 30: Coulomb, viscous, Stribeck, stick-slip), Prandtl 1928 and
Al-Bender, Lampaert and Swevers 2005 (IEEE TAC 50: generalised Maxwell slip of a few elements), Dahl
1968, Slocum 1992 (wind-up of screws, wear of nuts), THK and NSK (torsion of the shaft; drag of
nuts), Palmgren 1959 and SKF's catalogue (no-load friction as speed to the power of 2/3), Erkorkmaz
and Altintas 2001 (friction of feed drives identified for each direction), Rabinowicz 1958.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, logu, stream
from .forms_motion import dahl, maxwell, play
from .registry import along, apart, both, moving, tool_only, unit_place
from .world import World


@apart("backlash")
def dead_band(w: World, r: Rng, ax: int) -> Shape:
    """Clearance that is crossed before the table follows: a dead band (ISO 230-2; Slocum)."""
    return Shape(
        lambda q, a: Part(tool=along(q, ax, 1e3 * play(q.via[:, ax], a / 1e3)[q.row_at])),
        AX[ax],
        lambda a: {"size_um": a},
        linear=False,
        start=6.0,
    )


@apart("backlash")
def taken_up_in_time(w: World, r: Rng, ax: int) -> Shape:
    """A step at every reversal that the drive takes 10 to 60 ms to make (QC20 manual; Kakino)."""
    tau = logu(r, 0.010, 0.060)

    def f(q: Rec) -> Array:
        return -0.5 * q.sgn[:, ax] * (1 - 2 * np.exp(-q.revt[:, ax] / tau))

    return tool_only(ax, f, params=lambda a: {"size_um": a})


@apart("backlash_position")
def torsion_of_the_shaft(w: World, r: Rng, ax: int) -> Shape:
    """Lost motion of the nut and of the shaft's twist, in proportion to the distance from its
    motor: the far end has two to six times what the near one has (THK; ISO 230-2, B i)."""
    near, flip = r.uniform(0.15, 0.5), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return -0.5 * q.sgn[:, ax] * (near + (1 - near) * (1 - s if flip else s))

    return tool_only(ax, f)


@apart("backlash_position")
def worn_by_use(w: World, r: Rng, ax: int) -> Shape:
    """Wear as often as each place was used, a beta distribution over a base (Slocum)."""
    p, c, base = r.uniform(3, 8), r.uniform(0.3, 0.7), r.uniform(0.1, 0.35)
    a, b = p * c, p * (1 - c)

    def f(q: Rec) -> Array:
        s = np.clip(unit_place(w, ax, q), 0, 1)
        use = (s / c) ** a * ((1 - s) / (1 - c)) ** b
        return -0.5 * q.sgn[:, ax] * (base + (1 - base) * use)

    return tool_only(ax, f)


@apart("windup")
def elastic_then_sliding(w: World, r: Rng, ax: int) -> Shape:
    """One spring with a slider: the drive winds up by 20 um to 1 mm in a straight line and then
    slides (Prandtl; Slocum)."""
    reach = np.array([logu(r, 0.02, 1.0)])
    return tool_only(ax, lambda q: -maxwell(q.via[:, ax], reach, np.ones(1))[q.row_at])


@apart("windup")
def exponential(w: World, r: Rng, ax: int) -> Shape:
    """Dahl's exponential, its length 30 um to 2 mm (Dahl 1968)."""
    s0 = logu(r, 0.03, 2.0)
    return tool_only(ax, lambda q: -dahl(q.via[:, ax], s0)[q.row_at])


@apart("windup")
def four_elements(w: World, r: Rng, ax: int) -> Shape:
    """Generalised Maxwell slip of four elements whose reaches double, of equal stiffness (so that
    each takes twice the force of the one before it)."""
    reach = logu(r, 0.01, 0.2) * 2.0 ** np.arange(4)
    return tool_only(ax, lambda q: -maxwell(q.via[:, ax], reach, reach / reach.sum())[q.row_at])


@apart("reversal_spike")
def quadrant_glitch(w: World, r: Rng, ax: int) -> Shape:
    """Stick motion in time: it rises within 5 to 30 ms and is gone after some 40 to 250 ms, as the
    integral of the speed loop overcomes the friction (Kakino)."""
    up, down = logu(r, 0.005, 0.03), logu(r, 0.04, 0.25)
    u = np.linspace(0, 6 * down, 4000)
    top = float(((1 - np.exp(-u / up)) * np.exp(-u / down)).max())

    def f(q: Rec) -> Array:
        t = q.revt[:, ax]
        return -q.sgn[:, ax] * (1 - np.exp(-t / up)) * np.exp(-t / down) / top

    return both(ax, f)


@apart("reversal_spike")
def triangle(w: World, r: Rng, ax: int) -> Shape:
    """A triangle over 50 um to 1 mm of way, its top at a tenth to a half (QC20 manual)."""
    long, top = logu(r, 0.05, 1.0), r.uniform(0.1, 0.5)

    def f(q: Rec) -> Array:
        u = q.since[:, ax] / long
        return -q.sgn[:, ax] * np.clip(np.minimum(u / top, (1 - u) / (1 - top)), 0, 1)

    return both(ax, f)


def slow(q: Rec, ax: int, limit: float) -> Array:
    """1 where an axis moves at less than `limit` mm/s."""
    v = np.abs(q.vel[:, ax])
    return ((v > 1e-4) & (v < limit)) * 1.0


@apart("stick_slip")
def even_slips(w: World, r: Rng, ax: int) -> Shape:
    """The slide sticks while its drive winds up, and slips back by as much, each time after the
    same 0.1 to 1.2 mm; the mean is held by the loop (Armstrong-Helouvry et al.)."""
    seg, limit = logu(r, 0.1, 1.2), logu(r, 3, 9)

    def f(q: Rec) -> Array:
        return -q.sgn[:, ax] * slow(q, ax, limit) * (2 * ((q.since[:, ax] / seg) % 1.0) - 1)

    return both(ax, f)


@apart("stick_slip")
def uneven_slips(w: World, r: Rng, ax: int) -> Shape:
    """Slips of uneven length, a fifth or so more or less; the longer it stuck the higher it climbed
    (Rabinowicz)."""
    seg, limit, key = logu(r, 0.1, 1.2), logu(r, 3, 9), int(r.integers(2**62))
    spread = r.uniform(0.1, 0.3)

    def f(q: Rec) -> Array:
        way = q.since[:, ax]
        n = int(way.max() / seg * 2) + 10
        edge = np.cumsum(seg * stream(key, q.name).normal(1, spread, n).clip(0.3, 2))
        start = np.r_[0.0, edge][np.searchsorted(edge, way, "right")]
        return -q.sgn[:, ax] * slow(q, ax, limit) * (way - start) / seg

    return both(ax, f)


Law = Callable[[Rec, World, int, Array], Array]


def _friction(effect: str, law: Law) -> None:
    """Files law(q, world, axis, constants 0..1) of an axis's friction, with its motor current."""

    @apart(effect)
    def f(w: World, r: Rng, ax: int) -> Shape:
        c = r.uniform(0, 1, 3)

        def shape(q: Rec) -> Array:
            return -law(q, w, ax, c)

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


def _coulomb(q: Rec, w: World, ax: int, c: Array) -> Array:
    """The sign of speed, smooth within 0.02 to 0.2 mm/s of rest."""
    return np.tanh(q.vel[:, ax] / (0.02 * 10 ** c[0]))


def _stribeck(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb and up to 60 % more near rest, gone as exp(-v / vs) (Armstrong-Helouvry et al.)."""
    v, vs = q.vel[:, ax], 1.0 + 9.0 * c[0]
    return moving(q, ax) * (1 + (0.15 + 0.45 * c[1]) * np.exp(-np.abs(v) / vs))


def _viscous(q: Rec, w: World, ax: int, c: Array) -> Array:
    """In proportion to speed."""
    return q.vel[:, ax]


def _no_load(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Rolling bearings and nuts: speed to the power of 2/3, a third to two thirds of it; the rest,
    the ways' oil, in proportion (Palmgren; both are one at full speed)."""
    v, top = q.vel[:, ax], w.machine.vmax / 60
    k = 0.33 + 0.33 * c[0]
    return top * (k * np.sign(v) * np.abs(v / top) ** (2 / 3) + (1 - k) * v / top)


def _each_way(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb friction of one value in + and of another in -, a fourth to three fourths of it
    (Erkorkmaz and Altintas)."""
    s, low = moving(q, ax), 0.25 + 0.5 * c[0]
    up, down = (1.0, low) if c[1] > 0.5 else (low, 1.0)
    return np.where(s > 0, up, np.where(s < 0, -down, 0.0))


def _each_way_stribeck(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Stribeck's curve with constants of its own in each direction (Erkorkmaz and Altintas)."""
    v = q.vel[:, ax]
    curve = moving(q, ax) * (1 + 0.3 * np.exp(-np.abs(v) / 3.0))
    low = 0.25 + 0.4 * c[0]
    other = low * moving(q, ax) * (1 + 0.6 * c[2] * np.exp(-np.abs(v) / 8.0))
    return np.where((v > 0) == (c[1] > 0.5), curve, other)


for _e, _law in (
    ("coulomb_friction", _coulomb),
    ("coulomb_friction", _stribeck),
    ("viscous_friction", _viscous),
    ("viscous_friction", _no_load),
    ("friction_asymmetry", _each_way),
    ("friction_asymmetry", _each_way_stribeck),
):
    _friction(_e, _law)
