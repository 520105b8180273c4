"""Forms of place, load and tool of the fresh family.  Do not read while working on the judged tool.

Conventions as in forms_place.  Sources: Schwenke et al. 2008 (CIRP Annals 57/2), Slocum 1992
(Precision Machine Design: racks, rails, beams), Heydemann 1981 (quadrature signals), Roark (beam
under a load that travels), ISO 230-1:2012 (squareness), Usui 1984 and ISO 3685 (wear).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import interp1d

from .base import AX, Array, Part, Rec, Rng, Shape, pick
from .forms_place import across
from .registry import along, fresh, tool_only, unit_place
from .world import World


@fresh("scale")
def spliced_scale(w: World, r: Rng, ax: int) -> Shape:
    """A scale of two lengths, each stretched by its own amount (up to 15 % apart)."""
    sign, c, k = pick(r, [-1.0, 1.0]), r.uniform(0.25, 0.75), r.uniform(-0.15, 0.15)
    lo, hi = w.machine.travel[ax]
    return tool_only(
        ax,
        lambda q: (
            sign
            * (hi - lo)
            / 1e3
            * (unit_place(w, ax, q) + k * np.maximum(unit_place(w, ax, q) - c, 0))
        ),
    )


@fresh("pitch_shape")
def taped_scale(w: World, r: Rng, ax: int) -> Shape:
    """A tape scale glued or clamped at four to seven points: a polygon."""
    n = int(r.integers(4, 8))
    x = np.r_[-0.1, np.sort(r.uniform(0.08, 0.92, n - 2)), 1.1]
    f = interp1d(x, np.cumsum(r.normal(size=n)), fill_value="extrapolate")
    return tool_only(ax, lambda q: f(unit_place(w, ax, q)))


@fresh("pitch_shape")
def lapped_screw(w: World, r: Rng, ax: int) -> Shape:
    """Lead that tapers off towards both ends of a ground thread."""
    d, e, k, sign = (
        r.uniform(0.05, 0.25),
        r.uniform(0.05, 0.25),
        r.uniform(-1, 1),
        pick(r, [-1.0, 1.0]),
    )

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return sign * (np.exp(-s / d) + k * np.exp(-(1 - s) / e))

    return tool_only(ax, f)


@fresh("cyclic")
def rack(w: World, r: Rng, ax: int) -> Shape:
    """Tooth of a rack, pi times a module, or of a belt."""
    p = float(pick(r, [*np.pi * np.array([1.0, 1.5, 2.0, 2.5, 3.0]), 3.0, 5.0, 8.0]))
    ph = r.uniform(0, 6.28)
    return tool_only(
        ax,
        lambda q: np.sin(2 * np.pi * q.pos[:, ax] / p + ph),
        params=lambda a: {"period_mm": p, "amplitude_um": a},
    )


@fresh("cyclic")
def wobbling_screw(w: World, r: Rng, ax: int) -> Shape:
    """Triangle wave of the lead, fading with distance from the coupling that wobbles."""
    p, ph, flip, fade = w.machine.lead[ax], r.uniform(0, 1), pick(r, [0, 1]), r.uniform(0, 0.7)

    def f(q: Rec) -> Array:
        u = (q.pos[:, ax] / p + ph) % 1.0
        return (4 * np.abs(u - 0.5) - 1) * (1 - fade * np.abs(unit_place(w, ax, q) - flip))

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


@fresh("encoder_cyclic")
def quadrature(w: World, r: Rng, ax: int) -> Shape:
    """Offsets, unequal gain and phase of the two signals of the axis's own scale (Heydemann
    1981)."""
    p = float(pick(r, [0.02, 0.04, 0.1, 0.2, 0.5, 1.0, 2.0]))
    o1, o2, g, e = r.uniform(-0.15, 0.15, 4)

    def error(th: Array) -> Array:
        y = np.arctan2((1 + g) * np.sin(th + e) + o2, np.cos(th) + o1) - th
        return (y + np.pi) % (2 * np.pi) - np.pi

    one = np.linspace(0, 2 * np.pi, 400)
    mean, top = error(one).mean(), np.ptp(error(one)) / 2

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace" or q.meta["sees"] == "tool":
            return Part()
        return Part(reading=along(q, ax, a * (error(2 * np.pi * q.pos[:, ax] / p) - mean) / top))

    return Shape(field, AX[ax], lambda a: {"period_mm": p})


@fresh("squareness")
def shear(w: World, r: Rng, ax: int) -> Shape:
    """The angle between two axes shared by both: each leans by half of it against the reference."""
    m = w.machine
    pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
    _, unit, lean = m.lean(pair)
    other = next(AX.index(p) for p in pair if AX.index(p) != lean)
    sign = pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        own, rest = along(q, lean, q.pos[:, lean]), along(q, other, q.pos[:, other])
        return Part(tool=np.cross(unit * sign * a / 2, own - rest) * 1e-3)

    return Shape(field, pair, lambda a: {"urad": sign * a})


@fresh("squareness")
def racking(w: World, r: Rng, ax: int) -> Shape:
    """A gantry that lags on one side: the angle is larger on the way out than on the way back."""
    m = w.machine
    pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
    _, unit, lean = m.lean(pair)
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.05, 0.25)

    def field(q: Rec, a: float) -> Part:
        x = q.pos[:, lean] * (1 + k * q.sgn[:, lean])
        return Part(tool=np.cross(unit * sign * a, along(q, lean, x)) * 1e-3)

    return Shape(field, pair)


@fresh("bow")
def bolted_rail(w: World, r: Rng, ax: int) -> Shape:
    """A bent rail that its bolts, 60 to 120 mm apart, draw down (Majda 2012)."""
    to, sign = across(w, r, ax), pick(r, [-1.0, 1.0])
    p, k, ph = float(pick(r, [60.0, 80.0, 100.0, 120.0])), r.uniform(0.05, 0.2), r.uniform(0, 6.28)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return sign * (4 * s * (1 - s) + k * np.cos(2 * np.pi * q.pos[:, ax] / p + ph))

    return tool_only(to, f, axis=AX[ax])


@fresh("bow")
def beam_bow(w: World, r: Rng, ax: int) -> Shape:
    """Clamped beam under its own weight: quartic, flat at both ends."""
    to, sign = across(w, r, ax), pick(r, [-1.0, 1.0])
    return tool_only(
        to,
        lambda q: sign * 16 * (unit_place(w, ax, q) * (1 - unit_place(w, ax, q))) ** 2,
        axis=AX[ax],
    )


@fresh("abbe")
def rail_joint(w: World, r: Rng, ax: int) -> Shape:
    """Rotation that is not in the tables: the carriage tips over a joint of two rails."""
    m, sign, c, d = w.machine, pick(r, [-1.0, 1.0]), r.uniform(0.3, 0.7), r.uniform(0.05, 0.2)
    about = 1 if len(m.axes) == 2 else int(r.integers(0, 3))

    def field(q: Rec, a: float) -> Part:
        rot = np.zeros((len(q.t), 3))
        rot[:, about] = sign * a * np.tanh((unit_place(w, ax, q) - c) / d)
        return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3, rot=rot)

    return Shape(field, AX[ax], most=300.0)


@fresh("sag")
def cross_rail(w: World, r: Rng, ax: int) -> Shape:
    """Rail clamped at both ends under a saddle that travels: cube of s(1 - s), at the load
    (Roark)."""
    to = across(w, r, ax)
    return tool_only(
        to, lambda q: -64 * (unit_place(w, ax, q) * (1 - unit_place(w, ax, q))) ** 3, axis=AX[ax]
    )


@fresh("sag")
def overhang(w: World, r: Rng, ax: int) -> Shape:
    """Table whose mass runs out beyond its saddle: nothing first, then a parabola."""
    to, c, flip = across(w, r, ax), r.uniform(0.2, 0.5), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return -((np.maximum((1 - s if flip else s) - c, 0) / (1 - c)) ** 2)

    return tool_only(to, f, axis=AX[ax])


@fresh("force_compliance")
def stiffening(w: World, r: Rng, ax: int) -> Shape:
    """Rollers and joints that stiffen as they are pressed: n / (1 + |n| / n0)."""
    k = r.uniform(0.3, 1.5)

    def f(q: Rec) -> Array:
        n = w.force(q, ax)
        return n / (1 + k * np.abs(n) / max(float(np.abs(w.load[ax]).max()), 1.0))

    return tool_only(ax, f, most=2.0)


def _wear(curve) -> None:
    @fresh("tool_wear")
    def f(w: World, r: Rng, ax: int) -> Shape:
        def field(q: Rec, a: float) -> Part:
            if q.kind != "features":
                return Part()
            k = q.meta["part"] - 1.0
            k = np.where(q.meta["part"] >= q.meta["change"], k - q.meta["change"] + 1, k)
            return Part(reading=-2 * a * curve((k + 0.5) / 8) * q.meta["radial"])

        return Shape(field, "")


_wear(lambda s: np.expm1(1.8 * s) / np.expm1(1.8))  # heat speeds wear up, wear makes heat (Usui)
_wear(lambda s: np.log1p(5 * s) / np.log(6))  # run-in of a coating


@fresh("tool_size")
def bent_tool(w: World, r: Rng, ax: int) -> Shape:
    """A tool that bends away: less error at walls met from outside than at those from within."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.7, 0.95)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        rad = q.meta["radial"]
        return Part(reading=sign * a * np.where(rad < 0, k * rad, rad))

    return Shape(field, "")


@fresh("tool_size")
def plain_tool(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter, with the tool warm from the second part on by a little more."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.0, 0.08)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        return Part(reading=sign * a * q.meta["radial"] * (1 + k * (q.meta["part"] > 1)))

    return Shape(field, "", lambda a: {"diameter_um": sign * a})
