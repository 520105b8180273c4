"""Forms of place and tool of the apart family.  Do not read while working on the judged tool.

Conventions as in forms_place.  Sources: ISO 230-1:2012, ISO 230-2:2014 and ISO/TR 16907 (components
of error as lines, polynomials and Fourier series over the travel), Schwenke et al. 2008 (CIRP
Annals 57/2), Donmez et al. 1986 (Precision Engineering 8: polynomials of low order), Slocum 1992
(Precision machine design: misaligned ways, beams, Bryan's principle), THK's, NSK's and Steinmeyer's
screw catalogues (representative travel line, variation within a turn; JIS B 1192), Heidenhain
(Linear encoders for numerically controlled machine tools; Encoders for servo drives: deviations
within a signal period, eccentric graduations), Weck and Brecher 2006 (rotations of carriages on two
guideways), Roark (beams), Altintas 2012 (Manufacturing automation: tool life in three zones),
Kline, DeVor and Shareef 1982 (walls milled by a tool that gives way).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .base import AX, Array, Part, Rec, Rng, Shape, pick
from .forms_place import across
from .registry import along, apart, tool_only, unit_place
from .world import World


@apart("scale")
def wrong_unit_length(w: World, r: Rng, ax: int) -> Shape:
    """A straight line through the reference mark, somewhere on the travel (ISO 230-2; Slocum)."""
    (lo, hi), sign = w.machine.travel[ax], pick(r, [-1.0, 1.0])
    home = float(pick(r, [lo, hi, (lo + hi) / 2]))
    return tool_only(ax, lambda q: sign * (q.pos[:, ax] - home) / 1e3)


@apart("scale")
def travel_line(w: World, r: Rng, ax: int) -> Shape:
    """Representative travel line of a screw with a tenth or so of it as variation: two slow waves
    about the line, nothing at the ends (THK, NSK: E and e)."""
    sign, k, ph = pick(r, [-1.0, 1.0]), r.uniform(0.01, 0.035, 2), pick(r, [-1.0, 1.0])
    size = float(np.ptp(w.machine.travel[ax])) / 1e3

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        wave = k[0] * np.sin(2 * np.pi * s) + ph * k[1] * np.sin(4 * np.pi * s)
        return sign * size * (s + wave)

    return tool_only(ax, f)


@apart("pitch_shape")
def cubic(w: World, r: Rng, ax: int) -> Shape:
    """A polynomial of the third order that is right at both ends and once between (Donmez)."""
    c, sign = r.uniform(-0.35, 0.35), pick(r, [-1.0, 1.0])

    def f(q: Rec) -> Array:
        u = 2 * unit_place(w, ax, q) - 1
        return sign * (1 - u**2) * (u - c)

    return tool_only(ax, f)


@apart("pitch_shape")
def fourier(w: World, r: Rng, ax: int) -> Shape:
    """Four half waves over the travel, amplitudes as one over their order (Schwenke et al.)."""
    c = r.normal(size=4) / np.arange(1, 5)

    def f(q: Rec) -> Array:
        return np.sin(np.pi * np.outer(unit_place(w, ax, q), np.arange(1, 5))) @ c

    return tool_only(ax, f)


@apart("cyclic")
def within_a_turn(w: World, r: Rng, ax: int) -> Shape:
    """Variation within one turn of the screw: a sine of its lead (ISO 230-2; NSK, e 2 pi)."""
    p, ph = w.machine.lead[ax], r.uniform(0, 6.28)
    return tool_only(
        ax,
        lambda q: np.sin(2 * np.pi * q.pos[:, ax] / p + ph),
        params=lambda a: {"period_mm": p, "amplitude_um": a},
    )


@apart("cyclic")
def collar_and_coupling(w: World, r: Rng, ax: int) -> Shape:
    """Once a turn from a collar that is not square, a fifth to a half of it twice a turn from the
    coupling (Slocum)."""
    p, ph, k = w.machine.lead[ax], r.uniform(0, 6.28, 2), r.uniform(0.2, 0.5)

    def f(q: Rec) -> Array:
        th = 2 * np.pi * q.pos[:, ax] / p
        return np.sin(th + ph[0]) + k * np.sin(2 * th + ph[1])

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


def _in_the_trace(ax: int, y: Callable[[Rec], Array], told: dict[str, float]) -> Shape:
    """What the axis's own sensor reads wrong, told by a trace of it alone."""

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace" or q.meta["sees"] == "tool":
            return Part()
        return Part(reading=along(q, ax, a * y(q)))

    return Shape(field, AX[ax], lambda a: told)


@apart("encoder_cyclic")
def signal_period(w: World, r: Rng, ax: int) -> Shape:
    """Deviation within a signal period of 0.2 to 2 mm (inductive and magnetic scales): offsets give
    its first, unlike amplitudes and phases its second harmonic (Heidenhain; Heydemann)."""
    p, ph, k = float(pick(r, [0.2, 0.4, 1.0, 1.0, 2.0])), r.uniform(0, 6.28, 2), r.uniform(0.1, 0.6)

    def y(q: Rec) -> Array:
        th = 2 * np.pi * q.pos[:, ax] / p
        return np.sin(th + ph[0]) + k * np.sin(2 * th + ph[1])

    return _in_the_trace(ax, y, {"period_mm": p})


@apart("encoder_cyclic")
def graduation_off_centre(w: World, r: Rng, ax: int) -> Shape:
    """A rotary encoder on the screw whose graduation is off its centre: one sine a turn
    (Heidenhain, Encoders for servo drives)."""
    p, ph = w.machine.lead[ax], r.uniform(0, 6.28)
    return _in_the_trace(ax, lambda q: np.sin(2 * np.pi * q.pos[:, ax] / p + ph), {"period_mm": p})


@apart("squareness")
def out_of_square(w: World, r: Rng, ax: int) -> Shape:
    """An angle between two axes that is not the assumed one (ISO 230-1)."""
    return _angle(w, r, ax, lambda q, lean: q.pos[:, lean], True)


@apart("squareness")
def chord_of_a_bowed_way(w: World, r: Rng, ax: int) -> Shape:
    """An angle of the line through a way's ends, the way itself bowed by up to a thirtieth of what
    it leans (ISO 230-1: reference straight lines)."""
    k, lo_hi = r.uniform(-0.03, 0.03), w.machine.travel

    def course(q: Rec, lean: int) -> Array:
        s = unit_place(w, lean, q)
        return q.pos[:, lean] + 4 * k * float(np.ptp(lo_hi[lean])) * s * (1 - s)

    return _angle(w, r, ax, course, False)


def _angle(w: World, r: Rng, ax: int, course: Callable[[Rec, int], Array], told: bool) -> Shape:
    """Rotation vector of the pair times the leaning axis's way course(q, lean), mm."""
    pair = pick(r, [p for p in w.machine.pairs() if AX[ax] in p])
    _, unit, lean = w.machine.lean(pair)
    sign = pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        return Part(tool=np.cross(unit * sign * a, along(q, lean, course(q, lean))) * 1e-3)

    return Shape(field, pair, lambda a: {"urad": sign * a} if told else {})


@apart("bow")
def circular_arc(w: World, r: Rng, ax: int) -> Shape:
    """A way that is part of a large circle, its top within a tenth of the middle (ISO 230-1)."""
    to, sign, c = across(w, r, ax), pick(r, [-1.0, 1.0]), r.uniform(0.4, 0.6)

    def f(q: Rec) -> Array:
        return sign * (1 - ((unit_place(w, ax, q) - c) / max(c, 1 - c)) ** 2)

    return tool_only(to, f, axis=AX[ax])


@apart("bow")
def arc_and_s(w: World, r: Rng, ax: int) -> Shape:
    """Half a wave over the travel and a fifth to a half of it as a whole wave (Schwenke et al.)."""
    to, sign = across(w, r, ax), pick(r, [-1.0, 1.0])
    k = r.uniform(0.2, 0.5) * pick(r, [-1.0, 1.0])

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return sign * (np.sin(np.pi * s) + k * np.sin(2 * np.pi * s))

    return tool_only(to, f, axis=AX[ax])


def _rotation(w: World, r: Rng, ax: int, angle: Callable[[Array], Array]) -> Shape:
    """A rotation angle(s) over the travel, s 0..1, not in the tables, times the arm (Bryan)."""
    m, sign = w.machine, pick(r, [-1.0, 1.0])
    about = 1 if len(m.axes) == 2 else int(r.integers(0, 3))

    def field(q: Rec, a: float) -> Part:
        rot = np.zeros((len(q.t), 3))
        rot[:, about] = sign * a * angle(unit_place(w, ax, q))
        return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3, rot=rot)

    return Shape(field, AX[ax], most=300.0)


@apart("abbe")
def pitch_of_a_carriage(w: World, r: Rng, ax: int) -> Shape:
    """A carriage on a way that is an arc turns in proportion to its place, and by a tenth or so of
    that as the cube (Weck and Brecher; polynomials as of Donmez)."""
    k, c = r.uniform(-0.3, 0.3), r.uniform(-0.3, 0.3)
    return _rotation(w, r, ax, lambda s: (2 * s - 1) + k * (2 * s - 1) ** 3 + c)


@apart("abbe")
def yaw_in_a_wave(w: World, r: Rng, ax: int) -> Shape:
    """Half a wave to a wave and a half of rotation, nothing at the start (Schwenke et al.)."""
    n = r.uniform(0.5, 1.5)
    return _rotation(w, r, ax, lambda s: np.sin(2 * np.pi * n * s))


@apart("sag")
def ram_of_a_cantilever(w: World, r: Rng, ax: int) -> Shape:
    """A ram that runs out with its head's weight, from a root that is a twentieth to a third of the
    travel inside: cube of the overhang (Roark; Slocum)."""
    to, root, flip = across(w, r, ax), r.uniform(0.05, 0.33), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        out = (1 - s if flip else s) + root
        return -((out / (1 + root)) ** 3)

    return tool_only(to, f, axis=AX[ax])


@apart("sag")
def cross_rail(w: World, r: Rng, ax: int) -> Shape:
    """A cross rail on two columns that stand a little outside the travel, under its saddle: the
    square of the product of both distances (Roark)."""
    to, a, b = across(w, r, ax), r.uniform(0.05, 0.25), r.uniform(0.05, 0.25)

    def f(q: Rec) -> Array:
        s = (unit_place(w, ax, q) + a) / (1 + a + b)
        return -16 * (s * (1 - s)) ** 2

    return tool_only(to, f, axis=AX[ax])


def _cutter(amount: Callable[[Rec], Array], told: bool, sign: float = 1.0) -> Shape:
    """What a tool's diameter does to parts: a * amount(q) for each reading, times `radial`."""

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        return Part(reading=sign * a * amount(q) * q.meta["radial"])

    return Shape(field, "", lambda a: {"diameter_um": sign * a} if told else {})


def cut(q: Rec) -> Array:
    """Length cut since the last change of tool, in lives of eight parts."""
    part, change = q.meta["part"] - 1.0, q.meta["change"]
    return (np.where(part + 1 >= change, part - change + 1, part) + 0.5) / 8


@apart("tool_wear")
def steady_wear(w: World, r: Rng, ax: int) -> Shape:
    """Wear in proportion to the length cut, nothing after a change (Altintas; ISO 8688-2)."""
    return _cutter(lambda q: -2 * cut(q), False)


@apart("tool_wear")
def three_zones(w: World, r: Rng, ax: int) -> Shape:
    """Initial, steady and rapid wear in one curve: a fast start, a line and a cubic end
    (Altintas)."""
    first, last, tau = r.uniform(0.1, 0.3), r.uniform(0.3, 0.8), r.uniform(0.05, 0.15)

    def amount(q: Rec) -> Array:
        s = cut(q)
        return -2 * (first * -np.expm1(-s / tau) + s + last * s**3)

    return _cutter(amount, False)


@apart("tool_size")
def wrong_offset(w: World, r: Rng, ax: int) -> Shape:
    """A diameter in the tool table that is not the tool's (Altintas)."""
    return _cutter(lambda q: np.ones(q.n_obs), True, pick(r, [-1.0, 1.0]))


@apart("tool_size")
def walls_give_way(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter; bores that are milled round show up to a tenth less of it than straight
    walls, as the tool is pressed off them (Kline et al.)."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.03, 0.1)

    def amount(q: Rec) -> Array:
        return np.where([i[1] == "bore_diameter" for i in q.meta["info"]], 1 - k, 1.0)

    return _cutter(amount, False, sign)
