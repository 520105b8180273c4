"""Forms of place, load and tool of the sealed family.  Do not read while working on the judged
tool.

Conventions as in forms_place.  Sources: ISO 3408-3 (ball screws: specified travel, deviation within
300 mm), ISO 3408-4 (axial rigidity of a screw held at both ends), Slocum 1992 (Precision Machine
Design: couplings, Airy points, beams, angular errors that follow from straightness), Airy 1846
(supports of a bar), Ekinci and Mayer 2007 (Relationships between straightness and angular kinematic
errors in machines), Boyes 1980 (Synchro and resolver conversion: harmonics of inductive scales),
Harris (Rolling bearing analysis: preloaded pairs, deflection as load to the power of 2/3), Bryan
1990 (a column that warms up leans), Altintas 2012 (Manufacturing automation: tool wear, inserts).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from .base import AX, Array, Part, Rec, Rng, Shape, pick
from .forms_place import across
from .registry import along, sealed, tool_only, unit_place
from .world import World


@sealed("scale")
def specified_travel(w: World, r: Rng, ax: int) -> Shape:
    """Specified travel: a slope, and within each 300 mm up to 8 % of it more or less (ISO
    3408-3)."""
    lo, hi = w.machine.travel[ax]
    sign, n = pick(r, [-1.0, 1.0]), max(2, int(np.ceil((hi - lo) / 300)))
    x = lo + (hi - lo) * np.linspace(0, 1, n + 1)
    y = np.r_[0.0, np.cumsum(np.diff(x) * (1 + r.uniform(-0.08, 0.08, n)))]
    return tool_only(ax, lambda q: sign * np.interp(q.pos[:, ax], x, y) / 1e3)


@sealed("pitch_shape")
def ground_turn_by_turn(w: World, r: Rng, ax: int) -> Shape:
    """Lead errors that add up at random and are right again at the end, where the screw was
    adjusted to its specified travel (ISO 3408-3)."""
    n = int(r.integers(8, 20))
    y = np.r_[0.0, np.cumsum(r.normal(size=n))]
    y = y - np.linspace(0, 1, n + 1) * y[-1]
    f = PchipInterpolator(np.linspace(0, 1, n + 1), y, extrapolate=True)
    return tool_only(ax, lambda q: f(unit_place(w, ax, q)))


@sealed("pitch_shape")
def two_grindings(w: World, r: Rng, ax: int) -> Shape:
    """A thread ground in two set-ups: beyond the joint it has gained a little, in an S (logistic)
    of a nut's length (a simple picture, from no book)."""
    c, d, sign = r.uniform(0.25, 0.75), r.uniform(0.03, 0.1), pick(r, [-1.0, 1.0])
    return tool_only(ax, lambda q: sign / (1 + np.exp(-(unit_place(w, ax, q) - c) / d)))


@sealed("cyclic")
def universal_joint(w: World, r: Rng, ax: int) -> Shape:
    """Coupling with crossed pins at an angle: tan(out) = tan(in) cos(bend), twice a turn; half the
    lead (Hooke's joint; Slocum 1992, couplings)."""
    p, ph, bend = w.machine.lead[ax], r.uniform(0, 6.28), r.uniform(0.05, 0.5)
    one = np.linspace(0, np.pi, 721)

    def slip(th: Array) -> Array:
        y = np.arctan2(np.sin(th) * np.cos(bend), np.cos(th)) - th
        return (y + np.pi) % (2 * np.pi) - np.pi

    top = float(slip(one).max())
    return tool_only(
        ax,
        lambda q: slip(2 * np.pi * q.pos[:, ax] / p + ph) / top,
        params=lambda a: {"period_mm": p / 2, "amplitude_um": a},
    )


@sealed("cyclic")
def toothed_belt(w: World, r: Rng, ax: int) -> Shape:
    """Pulley of 16 to 40 teeth that runs out, and the mesh of each tooth (2, 3 or 5 mm)."""
    tooth, n = float(pick(r, [2.0, 3.0, 5.0])), int(pick(r, [16, 20, 24, 32, 40]))
    p, k, ph = tooth * n, r.uniform(0.1, 0.35), r.uniform(0, 6.28, 2)

    def f(q: Rec) -> Array:
        x = q.pos[:, ax]
        return np.sin(2 * np.pi * x / p + ph[0]) + k * np.sin(2 * np.pi * x / tooth + ph[1])

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


def _own_reading(w: World, ax: int, y, p: float) -> Shape:
    """What the axis's own sensor reads wrong by y(q), seen where its readings are recorded."""

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace" or q.meta["sees"] == "tool":
            return Part()
        return Part(reading=along(q, ax, a * y(q)))

    return Shape(field, AX[ax], lambda a: {"period_mm": p})


@sealed("encoder_cyclic")
def inductive(w: World, r: Rng, ax: int) -> Shape:
    """Inductive scale of 1 to 5 mm: second and fourth harmonic of its pitch beside the first
    (Boyes 1980)."""
    p = float(pick(r, [1.0, 2.0, 2.54, 5.0]))
    h, ph = np.r_[1.0, r.uniform(0.2, 0.7), r.uniform(0.1, 0.5)], r.uniform(0, 6.28, 3)
    return _own_reading(
        w,
        ax,
        lambda q: sum(
            g * np.sin(2 * np.pi * k * q.pos[:, ax] / p + f)
            for g, k, f in zip(h, (1, 2, 4), ph, strict=True)
        ),
        p,
    )


@sealed("encoder_cyclic")
def uneven_gap(w: World, r: Rng, ax: int) -> Shape:
    """Error within a signal period that grows where the head runs too close or too far: its size
    follows the place (Heydemann's second
    order left out; a simple picture)."""
    p = float(pick(r, [0.04, 0.1, 0.2, 0.4, 1.0, 2.0]))
    ph, c, k = r.uniform(0, 6.28), r.uniform(0.2, 0.8), r.uniform(1.0, 4.0)

    def y(q: Rec) -> Array:
        gain = (1 + k * (unit_place(w, ax, q) - c) ** 2) / (1 + k * max(c, 1 - c) ** 2)
        return gain * np.sin(2 * np.pi * q.pos[:, ax] / p + ph)

    return _own_reading(w, ax, y, p)


@sealed("squareness")
def warming_column(w: World, r: Rng, ax: int) -> Shape:
    """A column that leans, and as the frame warms up by up to a quarter more or less (Bryan
    1990)."""
    m = w.machine
    pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
    _, unit, lean = m.lean(pair)
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(-0.25, 0.25)
    warm = (w.frame - w.frame[0]) / max(float(np.abs(w.frame - w.frame[0]).max()), 1e-9)

    def field(q: Rec, a: float) -> Part:
        own = along(q, lean, q.pos[:, lean] * (1 + k * w.at(warm, q.t)))
        return Part(tool=np.cross(unit * sign * a, own) * 1e-3)

    return Shape(field, pair)


def on_two_supports(s: Array, at: float) -> Array:
    """Deflection (up +, unit E I = load = length = 1) of a bar under its own weight on supports at
    `at` and 1 - `at` (Airy 1846; 0 gives the beam held at its ends, -5/384 in its middle)."""

    def raw(x: Array) -> Array:
        left, right = np.maximum(x - at, 0), np.maximum(x - 1 + at, 0)
        return -(x**4) / 24 + (left**3 + right**3) / 12

    ends = raw(np.array([at, 1 - at]))
    slope = (ends[1] - ends[0]) / (1 - 2 * at)
    return raw(s) - ends[0] - slope * (s - at)


@sealed("bow")
def airy(w: World, r: Rng, ax: int) -> Shape:
    """Bed on two supports a fifth to a quarter inside its ends: its overhangs droop too."""
    to, at, sign = across(w, r, ax), r.uniform(0.1, 0.26), pick(r, [-1.0, 1.0])
    top = float(np.ptp(on_two_supports(np.linspace(0, 1, 201), at)))
    return tool_only(
        to, lambda q: sign * on_two_supports(unit_place(w, ax, q), at) / top, axis=AX[ax]
    )


@sealed("abbe")
def wavy_rail(w: World, r: Rng, ax: int) -> Shape:
    """Two blocks at a distance on a wavy rail: the carriage pitches by the difference of its
    heights over that distance (Ekinci and Mayer 2007); not in the tables."""
    m, sign = w.machine, pick(r, [-1.0, 1.0])
    n, ph, base = r.uniform(0.7, 2.5), r.uniform(0, 6.28), r.uniform(0.08, 0.3)
    about = 1 if len(m.axes) == 2 else int(r.integers(0, 3))

    def height(s: Array) -> Array:
        return np.sin(2 * np.pi * n * s + ph) + 0.4 * np.sin(4.6 * np.pi * n * s - ph)

    def field(q: Rec, a: float) -> Part:
        s, rot = unit_place(w, ax, q), np.zeros((len(q.t), 3))
        rot[:, about] = sign * a * (height(s + base / 2) - height(s - base / 2)) / base / 10
        return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3, rot=rot)

    return Shape(field, AX[ax], most=300.0)


@sealed("sag")
def ram(w: World, r: Rng, ax: int) -> Shape:
    """Ram that slides out: its head bends it with the cube of the overhang, its own weight with the
    fourth power (Slocum 1992, beams)."""
    to, own = across(w, r, ax), r.uniform(0.2, 0.8)
    base, flip = r.uniform(0.05, 0.3), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        out = (base + (1 - s if flip else s)) / (1 + base)
        return -((1 - own) * out**3 + own * out**4)

    return tool_only(to, f, axis=AX[ax])


@sealed("force_compliance")
def held_at_both_ends(w: World, r: Rng, ax: int) -> Shape:
    """Screw held at both ends: softest in the middle, 4 s (1 - s) over a rest that is the nut's and
    the bearings' (ISO 3408-4)."""
    rest = r.uniform(0.3, 1.0)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return w.force(q, ax) * (rest + 4 * s * (1 - s)) / (rest + 1)

    return tool_only(ax, f, most=2.0)


def pair_gives(n: Array, preload: float) -> Array:
    """Deflection of two contacts pressed together by `preload`, in units of load (slope 1 at 0).

    Each follows load = d^1.5; together they carry (1 + d)^1.5 - (1 - d)^1.5 until one lets go at
    2^1.5 times the preload (Harris, preloaded pairs).
    """
    d = np.linspace(0, 6, 1500)
    load = (1 + d) ** 1.5 - np.maximum(1 - d, 0) ** 1.5
    return np.sign(n) * np.interp(np.abs(n) / preload, load, d) * 3 * preload


@sealed("force_compliance")
def preloaded_pair(w: World, r: Rng, ax: int) -> Shape:
    """Double nut or bearing pair with a preload of 0.2 to 1 of the largest load."""
    share = r.uniform(0.2, 1.0)

    def f(q: Rec) -> Array:
        return pair_gives(w.force(q, ax), share * max(float(np.abs(w.load[ax]).max()), 1.0))

    return tool_only(ax, f, most=2.0)


@sealed("tool_wear")
def saturating(w: World, r: Rng, ax: int) -> Shape:
    """Wear that starts fast and slows down, a hyperbola of the length cut (Altintas 2012, the first
    two zones of a wear curve)."""
    c = r.uniform(0.25, 1.2)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        k = q.meta["part"] - 1.0
        k = np.where(q.meta["part"] >= q.meta["change"], k - q.meta["change"] + 1, k)
        s = (k + 0.5) / 8
        return Part(reading=-2 * a * s * (1 + c) / (s + c) * q.meta["radial"])

    return Shape(field, "")


@sealed("tool_size")
def new_insert(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter whose indexed insert seats anew at the change: a tenth more or less of it
    from there on (Altintas 2012)."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.88, 1.12)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        after = np.where(q.meta["part"] >= q.meta["change"], k, 1.0)
        return Part(reading=sign * a * q.meta["radial"] * after)

    return Shape(field, "")
