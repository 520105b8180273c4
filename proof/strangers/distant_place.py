"""Forms of place and geometry of the distant family. Do not read while working on the judged tool.

Conventions as in forms_place. Sources: Bryan 1984 (nominal differential expansion) and ISO/TR 16015
(a part or scale that is not at 20 C), Heidenhain's notes on long sealed scales (spliced tapes),
Weck and Brecher 2006 (Werkzeugmaschinen 2 and 5: compensation tables that are too coarse; racks in
lengths; belts between motor and screw; rams), Dudley 1994 (Gear handbook: once a tooth, once a turn
of a pinion), Farrand's notes on Inductosyn scales and Heidenhain's on eccentric graduations, ISO
230-1:2012 (squareness and straightness), Knapp 1983 (circles run both ways), Slocum 1992 (rails
drawn on by bolts; Airy and Bessel points; saddles that cock in their gibs), Ekinci and Mayer 2007
(Relationships between straightness and angular kinematic errors; IJMTM 47), Schwenke et al. 2008
(Geometric error measurement and compensation; CIRP Annals 57), Roark (beams with built-in ends;
overhangs).

Each form says in one line what tells it from its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from .base import AX, Array, Part, Rec, Rng, Shape, pick
from .registry import along, distant, tool_only, unit_place
from .world import World


def way(w: World, r: Rng, ax: int) -> float:
    """Sign of a slope: long where one set-up of one beam is all that sees the axis, for a beam that
    is not aligned reads short; else either."""
    seen = [q for q in w.recs if q.outside and ax in q.moving]
    return 1.0 if len(seen) == 1 and seen[0].laser else float(pick(r, [-1.0, 1.0]))


@distant("scale")
def part_not_at_twenty(w: World, r: Rng, ax: int) -> Shape:
    """A scale away from 20 C whose room goes on to change: a slope that the frame's temperature
    alters by up to a tenth (Bryan 1984).  Tells: the slope is all there in the first row."""
    sign, lo, k = way(w, r, ax), w.machine.travel[ax][0], r.uniform(0.03, 0.1)
    course = w.frame - w.frame[0]
    course = course / max(float(np.abs(course).max()), 1e-9)

    def f(q: Rec) -> Array:
        return sign * (q.pos[:, ax] - lo) / 1e3 * (1 + k * w.at(course, q.t))

    return tool_only(ax, f, most=200.0)


@distant("scale")
def spliced_tape(w: World, r: Rng, ax: int) -> Shape:
    """A tape in two lengths under unlike tension: slopes that differ by up to a sixth of the mean.
    Tells: the kink leaves a few per cent of what the slope does."""
    sign, c, k = way(w, r, ax), r.uniform(0.35, 0.65), r.uniform(-0.08, 0.08)
    lo, hi = w.machine.travel[ax]

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return sign * (hi - lo) / 1e3 * (s + k * np.abs(s - c))

    return tool_only(ax, f, most=200.0)


@distant("pitch_shape")
def coarse_table(w: World, r: Rng, ax: int) -> Shape:
    """A smooth error less the straight lines of a table with 4 to 7 intervals: lobes of unlike
    height between places of no error (Weck and Brecher 2006).  Tells: lobes that are long against
    a lead and none like the next."""
    n = int(r.integers(4, 8))
    knots = np.linspace(-0.02, 1.02, n + 1)
    g = CubicSpline(np.linspace(-0.1, 1.1, n + 3), r.normal(size=n + 3))

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return g(s) - np.interp(s, knots, g(knots))

    return tool_only(ax, f)


@distant("pitch_shape")
def rack_in_lengths(w: World, r: Rng, ax: int) -> Shape:
    """Two to four racks, each with its own pitch, ends matched: a broken line whose corners the
    pinion rounds (Weck and Brecher 2006).  Tells: no line through all of it, the same both ways."""
    n = int(r.integers(2, 5))
    edge = np.r_[-0.1, (np.arange(1, n) + r.uniform(-0.25, 0.25, n - 1)) / n, 1.1]
    slope = np.abs(r.normal(size=n)) * (-1.0) ** np.arange(n) + 0.2 * r.normal()
    level = np.r_[0.0, np.cumsum(slope * np.diff(edge))]
    x = np.linspace(-0.1, 1.1, 241)
    y = np.convolve(np.pad(np.interp(x, edge, level), 5, "edge"), np.ones(11) / 11, "valid")
    return tool_only(ax, lambda q: np.interp(unit_place(w, ax, q), x, y))


def _waves(p: float, harmonics: dict[float, float], phase: Array) -> Callable[[Array], Array]:
    """Sum of sines of place (mm); keys count waves in one period p."""

    def f(x: Array) -> Array:
        pairs = zip(harmonics.items(), phase, strict=False)
        return sum(h * np.sin(2 * np.pi * n * x / p + f0) for (n, h), f0 in pairs)

    return f


@distant("cyclic")
def belt_pulley(w: World, r: Rng, ax: int) -> Shape:
    """A pulley on the motor that runs out, its belt geared down 3:2, 2:1 or 3:1, and a little of
    the one on the screw (Weck and Brecher 2006).  Tells: whole waves in each turn of the motor."""
    lead, ratio = w.machine.lead[ax], float(pick(r, [1.5, 2.0, 2.0, 3.0]))
    g = _waves(lead, {ratio: 1.0, 1.0: float(r.uniform(0.0, 0.3))}, r.uniform(0, 6.28, 2))
    return tool_only(ax, lambda q: g(q.pos[:, ax]), params=lambda a: {"period_mm": lead / ratio})


@distant("cyclic")
def seat_of_the_bearing(w: World, r: Rng, ax: int) -> Shape:
    """A bearing's seat out of square with the screw: once a turn as a rounded saw, quick on one
    side and slow on the other (Slocum 1992).  Tells: the period is the lead, the same all along."""
    p, ph, skew = w.machine.lead[ax], r.uniform(0, 6.28), r.uniform(0.2, 0.7) * pick(r, [-1, 1])

    def f(q: Rec) -> Array:
        th = 2 * np.pi * q.pos[:, ax] / p + ph
        return np.sin(th + skew * np.sin(th))

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


@distant("cyclic")
def pinion_teeth(w: World, r: Rng, ax: int) -> Shape:
    """A pinion's teeth that mesh with a rack, pi times module 1 to 3 mm, more on one side of the
    pinion than on the other (Dudley 1994).  Tells: a fixed period that no lead explains."""
    module, teeth = float(pick(r, [1.0, 1.5, 2.0, 3.0])), int(pick(r, [18, 20, 24]))
    p, k, ph = np.pi * module, r.uniform(0.1, 0.4), r.uniform(0, 6.28, 2)

    def f(q: Rec) -> Array:
        x = 2 * np.pi * q.pos[:, ax] / p
        return (1 + k * np.sin(x / teeth + ph[1])) * np.sin(x + ph[0])

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


def _recorded(w: World, ax: int, p: float, g: Callable[[Array], Array]) -> Shape | None:
    """A sensor's own error g(x) of period p (mm) where it is recorded; the table does not move so.
    None where the readings of a period are too few to show it."""
    seen = [q for q in w.recs if q.kind == "trace" and not q.outside and ax in q.moving]
    if not any(
        np.median(np.abs(q.vel[np.abs(q.vel[:, ax]) > 1e-3, ax])) / q.meta["rate"] < p / 4
        for q in seen
    ):
        return None

    def field(q: Rec, a: float) -> Part:
        mine = q.kind == "trace" and not q.outside
        return Part(reading=along(q, ax, a * g(q.pos[:, ax]))) if mine else Part()

    return Shape(field, AX[ax], lambda a: {"period_mm": p})


@distant("encoder_cyclic")
def inductive_scale(w: World, r: Rng, ax: int) -> Shape | None:
    """An inductive scale of 2 or 2.54 mm pitch: twice a pitch (unlike gains), four times, and less
    of it once (Farrand).  Tells: the scale's own log alone shows it, no instrument at the tool."""
    p = float(pick(r, [2.0, 2.54]))
    h = {2.0: 1.0, 4.0: float(r.uniform(0.05, 0.3)), 1.0: float(r.uniform(0.0, 0.3))}
    return _recorded(w, ax, p / 2, _waves(p, h, r.uniform(0, 6.28, 3)))


@distant("encoder_cyclic")
def eccentric_disc(w: World, r: Rng, ax: int) -> Shape | None:
    """A disc that runs out on the motor: once a turn, with some of twice as its coupling bends
    (Heidenhain).  Tells: in the log alone; the period is the lead or a half or third of it."""
    p = w.machine.lead[ax] / float(pick(r, [1.0, 1.0, 2.0, 3.0]))
    return _recorded(
        w, ax, p, _waves(p, {1.0: 1.0, 2.0: float(r.uniform(0, 0.25))}, r.uniform(0, 6.28, 2))
    )


def _angle(w: World, r: Rng, ax: int, gain: Callable[[Rec, int], Array]) -> Shape:
    """An angle between two axes; gain(q, other) is about 1, other being the axis that stands."""
    m = w.machine
    pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
    _, unit, lean = m.lean(pair)
    other = next(AX.index(c) for c in pair if AX.index(c) != lean)
    sign = pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        own = along(q, lean, q.pos[:, lean] * gain(q, other))
        return Part(tool=np.cross(unit * sign * a, own) * 1e-3)

    return Shape(field, pair, lambda a: {"urad": sign * a}, most=400.0)


@distant("squareness")
def column_in_the_draught(w: World, r: Rng, ax: int) -> Shape:
    """An angle that the frame's temperature alters by up to an eighth (ISO 230-1, 230-3).  Tells:
    ovals at 45 degrees that stay whichever way round and however fast."""
    k, course = r.uniform(0.03, 0.12), w.frame - w.frame.mean()
    course = course / max(float(np.abs(course).max()), 1e-9)
    return _angle(w, r, ax, lambda q, other: 1 + k * w.at(course, q.t))


@distant("squareness")
def cocked_saddle(w: World, r: Rng, ax: int) -> Shape:
    """A saddle that cocks in its gib as it turns round: the angle is up to a tenth more one way
    than the other (Slocum 1992).  Tells: both ways lean to the same side."""
    k = r.uniform(0.03, 0.1) * pick(r, [-1.0, 1.0])
    return _angle(w, r, ax, lambda q, other: 1 + k * q.sgn[:, other])


def sides(w: World, ax: int) -> list[int]:
    """Directions across an axis that a file with it in motion senses."""
    seen: set[int] = set()
    for q in w.recs:
        if ax not in q.moving or not q.outside or q.kind == "features":
            continue
        if q.kind == "targets":
            seen |= {a for a in q.axes if abs(q.meta["sensitive"][a]) > 0.9}
        else:
            seen |= set(q.meta["plane"] if q.kind == "ballbar" else q.axes)
    return sorted(seen - {ax})


@distant("bow")
def bolted_rail(w: World, r: Rng, ax: int) -> Shape:
    """An arc of a bed that was ground warm, and up to a tenth of it drawn down at each bolt of its
    rail, 60 to 120 mm apart (Slocum 1992).  Tells: an arc to the side, or up."""
    to = sides(w, ax) or [a for a in w.machine.axes if a != ax]
    three = len(w.machine.axes) == 3
    to = [a for a in to if a != 2 or not three] or to
    p, k = float(pick(r, [60, 80, 105, 120])), r.uniform(0.02, 0.1)
    sign, ph, c = pick(r, [-1.0, 1.0]), r.uniform(0, 6.28), r.uniform(-0.15, 0.15)
    sign = -sinking(w, ax) if three and to == [2] else sign  # crowned: what sinks is a sag

    def f(q: Rec) -> Array:
        u = 2 * unit_place(w, ax, q) - 1 - c
        return sign * (1 - u**2 + k * np.cos(2 * np.pi * q.pos[:, ax] / p + ph))

    return tool_only(pick(r, to), f, axis=AX[ax], most=120.0)


def sinking(w: World, ax: int) -> float:
    """Sign of what a slide's sinking does: the tool goes down (-) or, on the workpiece's side, the
    workpiece does (+)."""
    return -1.0 if ax in w.machine.tool_side() else 1.0


def on_two_supports(s: Array, a: float) -> Array:
    """Line of a beam under its own weight on supports at a and 1 - a, down negative, largest 1:
    E I y'' is the moment, -s^2/2 outside and (s - a)/2 - s^2/2 between (Roark)."""
    x = np.linspace(0, 1, 801)
    bend = -(x**2) / 2 + np.maximum(x - a, 0) / 2 + np.maximum(x - 1 + a, 0) / 2
    h = x[1] - x[0]
    slope = np.r_[0.0, np.cumsum((bend[1:] + bend[:-1]) / 2) * h]
    y = np.r_[0.0, np.cumsum((slope[1:] + slope[:-1]) / 2) * h]
    left, right = np.interp([a, 1 - a], x, y)
    y = y - left - (right - left) * (x - a) / (1 - 2 * a)
    return np.interp(s, x, y / np.abs(y).max())


@distant("bow")
def beam_on_two_supports(w: World, r: Rng, ax: int) -> Shape:
    """A rail that lies on two supports a sixth to a third from its ends: it hangs between and at
    its ends (Airy, Bessel).  Tells: three arches, which no single mass bends."""
    to = sides(w, ax) or [a for a in w.machine.axes if a != ax]
    to = [2] if 2 in to and len(w.machine.axes) == 3 else to
    a, sign = r.uniform(0.15, 0.32), sinking(w, ax)
    return tool_only(
        pick(r, to),
        lambda q: -sign * on_two_supports(np.clip(unit_place(w, ax, q), 0, 1), a),
        axis=AX[ax],
        most=120.0,
    )


def _turned(w: World, r: Rng, ax: int, angle: Callable[[Array, Rec], Array]) -> Shape | None:
    """A rotation angle(s, q) that no table holds, times the arm; None where nothing tells it: no
    file of angles of the axis, and not two lines of it at unlike arms."""
    mine = [q for q in w.recs if q.kind == "targets" and q.meta["along"] == ax]
    angles = [q for q in mine if q.meta["quantity"] == "angle"]
    lines = {tuple(np.round(np.delete(q.pos[0], ax), 1)) for q in mine if q.laser}
    if not angles and len(lines) < 2:
        return None
    m, sign = w.machine, pick(r, [-1.0, 1.0])
    about = int(np.argmax(np.abs(pick(r, angles).meta["rotvec"]))) if angles else 1
    if len(m.axes) == 2:
        about = 1

    def field(q: Rec, a: float) -> Part:
        rot = np.zeros((len(q.t), 3))
        rot[:, about] = sign * a * angle(unit_place(w, ax, q), q)
        return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3, rot=rot)

    return Shape(field, AX[ax], most=300.0)


@distant("abbe")
def carriage_on_a_wave(w: World, r: Rng, ax: int) -> Shape | None:
    """A carriage follows a way that is not straight: its angle is the difference of the way's
    heights under its two ends, over its length (Ekinci and Mayer 2007).  Tells: the angle's file,
    and lines that differ as their arms do."""
    g, base = CubicSpline(np.linspace(-0.4, 1.4, 9), r.normal(size=9)), r.uniform(0.15, 0.4)
    return _turned(w, r, ax, lambda s, q: (g(s + base / 2) - g(s - base / 2)) / base)


@distant("abbe")
def twisted_bed(w: World, r: Rng, ax: int) -> Shape | None:
    """A bed that one foot twists: an angle that grows from that foot on, and a sixth of it more one
    way than the other (Schwenke et al. 2008).  Tells: as the other one."""
    c, k, n = r.uniform(0.0, 0.5), r.uniform(0.0, 0.15), r.uniform(1.2, 2.2)
    return _turned(
        w, r, ax, lambda s, q: np.maximum(s - c, 0) ** n / (1 - c) ** n * (1 + k * q.sgn[:, ax])
    )


@distant("abbe")
def probe_beside_the_point(w: World, r: Rng, ax: int) -> Shape | None:
    """A functional point that is not where [tool] says, across in one direction and at most half as
    much in another: the stated angles times that arm.  Tells: it goes as the stated angle."""
    m = w.machine
    comps = [c for c in m.tables[ax] if c[1] in "ABC"]
    if not comps or not any(np.ptp(m.tables[ax][c][0]) > 0 for c in comps):
        return None
    arm, (one, two) = np.zeros(3), r.permutation(m.axes)[:2]
    arm[one], arm[two] = pick(r, [-1.0, 1.0]), r.uniform(-0.5, 0.5)

    def field(q: Rec, a: float) -> Part:
        rot = np.zeros((len(q.t), 3))
        for c in comps:
            fwd, rev = m.tables[ax][c]
            x, mean = q.pos[:, ax], (fwd + rev) / 2
            half = np.interp(x, m.nodes[ax], (fwd - rev) / 2)
            rot[:, "ABC".index(c[1])] = np.interp(x, m.nodes[ax], mean) + half * q.sgn[:, ax]
        return Part(tool=np.cross(rot, np.tile(arm * a, (len(q.t), 1))) * 1e-3)

    return Shape(field, AX[ax], most=200.0)


def _sinks(w: World, ax: int, tool: bool, line: Callable[[Array], Array]) -> Shape | None:
    """line(s), down positive, of a beam under a mass on axis `ax`: Z sinks, or on two axes X (a
    slant bed under its carriage).  None where no file senses that or the axis is on the other
    side of the machine than the beam."""
    to = 2 if len(w.machine.axes) == 3 else 0
    if to == ax or to not in sides(w, ax) or tool != (ax in w.machine.tool_side()):
        return None
    sign = sinking(w, ax)

    def f(q: Rec) -> Array:
        return sign * line(np.clip(unit_place(w, ax, q), 0, 1))

    return tool_only(to, f, axis=AX[ax], most=120.0)


@distant("sag")
def built_in_rail(w: World, r: Rng, ax: int) -> Shape | None:
    """A cross rail built in at both ends sags under its saddle: s^3 (1 - s)^3, flat at its ends
    (Roark).  Tells: down, and flat where it is held."""
    hold = r.uniform(0.0, 0.06)

    def rail(s: Array) -> Array:
        u = (s + hold) / (1 + 2 * hold)
        return 64 * (u * (1 - u)) ** 3

    return _sinks(w, ax, True, rail)


@distant("sag")
def table_beyond_its_saddle(w: World, r: Rng, ax: int) -> Shape | None:
    """A table that reaches beyond its saddle at either end droops there as the square to cube of
    how far (Slocum 1992).  Tells: nothing in the middle, down at both ends."""
    c, n, k = r.uniform(0.15, 0.45), r.uniform(2, 3), r.uniform(0.6, 1.0)

    def droop(s: Array) -> Array:
        u = 2 * s - 1
        far = np.maximum(np.abs(u) - c, 0) / (1 - c)
        return far**n * np.where(u > 0, 1.0, k)

    return _sinks(w, ax, False, droop)


@distant("sag")
def ram(w: World, r: Rng, ax: int) -> Shape | None:
    """A ram that comes out of its carriage: it tips its guide (as the way out) and bends (as the
    cube) (Weck and Brecher 2006).  Tells: steeper the farther out, down."""
    k, flip = r.uniform(0.2, 0.5), r.random() < 0.5
    g = PchipInterpolator(
        np.linspace(0, 1, 21), k * np.linspace(0, 1, 21) ** 2 + (1 - k) * np.linspace(0, 1, 21) ** 3
    )
    return _sinks(w, ax, True, lambda s: g(1 - s if flip else s))
