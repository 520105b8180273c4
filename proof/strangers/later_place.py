"""Forms of place, load and tool of the later family.  Do not read while working on the judged tool.

Conventions as in forms_place.  Sources: ISO 3408-3 (deviation within 300 mm), Bryan 1990 and ISO
230-2 (scales on days of unlike temperature), Slocum 1992 (screws ground warm; pads on a rail;
bolted ways; screws with a free end; thrust collars), Weck and Brecher 2006 (Werkzeugmaschinen 2 and
5: tables of controls; gantries; joints that slip a little), Boyes 1980 (resolvers with several pole
pairs), Lenz and Edelstein 2006 (magnetic sensors that saturate), Schlesinger 1927 and ISO 1708
(beds of lathes wear before the chuck), Roark (slope under a load that travels along a beam),
Hetenyi 1946 (Beams on elastic foundation), Timoshenko 1955 (continuous beams: two spans), Masing
1926, Malkin and Guo 2008 (Grinding technology: wheels that are dressed), Trent and Wright 2000
(Metal cutting: built-up edge), Altintas 2012 (engagement and deflection), DIN 69871 and ISO 12164
(tapers: repeatability of a clamped tool).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import erf

from .base import AX, Array, Part, Rec, Rng, Shape, pick, stream
from .forms_motion import maxwell
from .forms_place import across
from .registry import along, later, tool_only, unit_place
from .world import World


@later("scale")
def days(w: World, r: Rng, ax: int) -> Shape:
    """A slope that each file, each day, has at its own temperature: up to an eighth more or less
    (Bryan 1990)."""
    sign, key, lo = pick(r, [-1.0, 1.0]), int(r.integers(2**62)), w.machine.travel[ax][0]

    def f(q: Rec) -> Array:
        return sign * (q.pos[:, ax] - lo) / 1e3 * (1 + stream(key, q.name).uniform(-0.12, 0.12))

    return tool_only(ax, f)


@later("scale")
def with_waves(w: World, r: Rng, ax: int) -> Shape:
    """A slope and waves of 300 mm that take up to an eighth of it off and on (ISO 3408-3, V300)."""
    sign, k, ph = pick(r, [-1.0, 1.0]), r.uniform(0.03, 0.12), r.uniform(0, 6.28)
    lo, u = w.machine.travel[ax][0], 2 * np.pi / 300

    def f(q: Rec) -> Array:
        x = q.pos[:, ax] - lo
        return sign * (x + k / u * np.sin(u * x + ph)) / 1e3

    return tool_only(ax, f)


@later("pitch_shape")
def ground_warm(w: World, r: Rng, ax: int) -> Shape:
    """A screw that was warm in one stretch while it was ground, its ends adjusted: the integral of
    a bell less its chord (Slocum 1992)."""
    c, d, sign = r.uniform(0.3, 0.7), r.uniform(0.06, 0.2), pick(r, [-1.0, 1.0])
    a, b = (erf((x - c) / d) for x in (0.0, 1.0))
    return tool_only(
        ax,
        lambda q: sign * (erf((unit_place(w, ax, q) - c) / d) - a - (b - a) * unit_place(w, ax, q)),
    )


@later("pitch_shape")
def shifted_table(w: World, r: Rng, ax: int) -> Shape:
    """A control's table that was entered an interval or two beside its place: a smooth error less
    itself, shifted (Weck and Brecher 2006)."""
    n, d = int(r.integers(5, 8)), r.uniform(0.04, 0.1) * pick(r, [-1.0, 1.0])
    g = CubicSpline(np.linspace(-0.2, 1.2, n), r.normal(size=n))
    return tool_only(ax, lambda q: (g(unit_place(w, ax, q)) - g(unit_place(w, ax, q) - d)) / abs(d))


@later("cyclic")
def three_lobed_collar(w: World, r: Rng, ax: int) -> Shape:
    """A thrust collar that rests on three high spots: three times a turn (Slocum 1992)."""
    p, ph = w.machine.lead[ax] / 3, r.uniform(0, 6.28)
    return tool_only(
        ax,
        lambda q: np.sin(2 * np.pi * q.pos[:, ax] / p + ph),
        params=lambda a: {"period_mm": p, "amplitude_um": a},
    )


@later("cyclic")
def free_end(w: World, r: Rng, ax: int) -> Shape:
    """A screw with a free end that runs out the more the farther from its bearing the nut is, as
    the square, over what the bearing itself does once a turn (Slocum 1992)."""
    p, ph, rest, flip = (
        w.machine.lead[ax],
        r.uniform(0, 6.28),
        r.uniform(0.3, 0.7),
        r.random() < 0.5,
    )

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        gain = rest + (1 - rest) * (1 - s if flip else s) ** 2
        return gain * np.sin(2 * np.pi * q.pos[:, ax] / p + ph)

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


def _own_reading(ax: int, p: float, harmonics: dict[int, float], phase: Array) -> Shape:
    """A sensor's own error of period p (mm), seen where its readings are recorded."""

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace" or q.meta["sees"] == "tool":
            return Part()
        th = 2 * np.pi * q.pos[:, ax] / p
        y = sum(h * np.sin(n * th + f) for (n, h), f in zip(harmonics.items(), phase, strict=False))
        return Part(reading=along(q, ax, a * y))

    main = max(harmonics, key=lambda n: harmonics[n])
    return Shape(field, AX[ax], lambda a: {"period_mm": p / main})


@later("encoder_cyclic")
def resolver(w: World, r: Rng, ax: int) -> Shape:
    """A resolver of 1 to 4 pole pairs on the motor: twice a turn of its field (unlike amplitudes),
    and less of it once (offsets); a few minutes of arc (Boyes 1980)."""
    p = w.machine.lead[ax] / int(r.integers(1, 5))
    return _own_reading(ax, p, {2: 1.0, 1: float(r.uniform(0.1, 0.4))}, r.uniform(0, 6.28, 2))


@later("encoder_cyclic")
def magnetic_tape(w: World, r: Rng, ax: int) -> Shape:
    """Magnetic tape of 2 or 5 mm poles whose head saturates: once and three times a pole (Lenz)."""
    p = float(pick(r, [2.0, 2.0, 5.0]))
    return _own_reading(ax, p, {1: 1.0, 3: float(r.uniform(0.1, 0.5))}, r.uniform(0, 6.28, 2))


def _angle(w: World, r: Rng, ax: int, course, told: bool) -> Shape:
    """An angle between two axes; course(q, lean) is the leaning axis's way (mm) that it acts on."""
    m = w.machine
    pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
    _, unit, lean = m.lean(pair)
    sign = pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        own = along(q, lean, course(q, lean))
        return Part(tool=np.cross(unit * sign * a, own) * 1e-3)

    return Shape(field, pair, lambda a: {"urad": sign * a} if told else {})


@later("squareness")
def gantry_homed_anew(w: World, r: Rng, ax: int) -> Shape:
    """A gantry of two drives whose two sides are homed before each file: the angle comes back to
    within an eighth (Weck and Brecher 2006)."""
    key = int(r.integers(2**62))
    return _angle(
        w,
        r,
        ax,
        lambda q, lean: q.pos[:, lean] * (1 + stream(key, q.name).uniform(-0.12, 0.12)),
        False,
    )


@later("squareness")
def bolted_at_an_angle(w: World, r: Rng, ax: int) -> Shape:
    """A way bolted down at an angle that its bolts draw into a slight S, up to a twentieth of its
    rise (Slocum 1992)."""
    k = r.uniform(-0.3, 0.3)

    def course(q: Rec, lean: int) -> Array:
        s, size = unit_place(w, lean, q), float(np.ptp(w.machine.travel[lean]))
        return q.pos[:, lean] + k * size * np.sin(2 * np.pi * s) / (2 * np.pi)

    return _angle(w, r, ax, course, True)


@later("bow")
def turned_down_ends(w: World, r: Rng, ax: int) -> Shape:
    """A way that was lapped or scraped: flat in its middle, ends turned down as a power of 3 to 6
    of the distance from it (Slocum 1992)."""
    to, sign, n = across(w, r, ax), pick(r, [-1.0, 1.0]), r.uniform(3, 6)
    c = r.uniform(-0.2, 0.2)

    def f(q: Rec) -> Array:
        return -sign * np.abs(2 * unit_place(w, ax, q) - 1 - c) ** n / (1 + abs(c)) ** n

    return tool_only(to, f, axis=AX[ax])


@later("bow")
def worn_before_the_chuck(w: World, r: Rng, ax: int) -> Shape:
    """A bed worn before the chuck: deepest at a fifth or so of its length, as new at its far end,
    s (1 - s)^n (Schlesinger)."""
    to, n, flip = across(w, r, ax), r.uniform(2.5, 6), r.random() < 0.5
    top = n**n / (n + 1) ** (n + 1)

    def f(q: Rec) -> Array:
        s = np.clip(unit_place(w, ax, q), 0, 1)
        s = 1 - s if flip else s
        return -s * (1 - s) ** n / top

    return tool_only(to, f, axis=AX[ax])


def _unmapped(w: World, r: Rng, ax: int, angle) -> Shape:
    """A rotation angle(s), s 0..1, that is not in the tables, times the arm (Bryan 1979)."""
    m, sign = w.machine, pick(r, [-1.0, 1.0])
    about = 1 if len(m.axes) == 2 else int(r.integers(0, 3))

    def field(q: Rec, a: float) -> Part:
        rot = np.zeros((len(q.t), 3))
        rot[:, about] = sign * a * angle(unit_place(w, ax, q))
        return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3, rot=rot)

    return Shape(field, AX[ax], most=300.0)


@later("abbe")
def own_weight_on_a_beam(w: World, r: Rng, ax: int) -> Shape:
    """A carriage pitches as the beam bends under it: slope under a load that travels between two
    supports, s (1 - s) (1 - 2 s) (Roark)."""
    share = r.uniform(-0.2, 0.2)
    return _unmapped(w, r, ax, lambda s: 10.4 * s * (1 - s) * (1 - 2 * s) + share)


@later("abbe")
def pads_on_a_step(w: World, r: Rng, ax: int) -> Shape:
    """Two pads at a distance pass a step between two rails: the carriage is tipped while one has
    and the other has not (Slocum 1992)."""
    c, base, edge = r.uniform(0.25, 0.75), r.uniform(0.12, 0.35), r.uniform(0.01, 0.04)
    return _unmapped(
        w,
        r,
        ax,
        lambda s: (np.tanh((s - c + base / 2) / edge) - np.tanh((s - c - base / 2) / edge)) / 2,
    )


@later("sag")
def on_soft_ground(w: World, r: Rng, ax: int) -> Shape:
    """A bed on a soft foundation sinks under the slide, more at its ends than between: hyperbolic
    cosine of the distance from the middle (Hetenyi 1946)."""
    to, k, off = across(w, r, ax), r.uniform(1.5, 4.0), r.uniform(-0.1, 0.1)

    def f(q: Rec) -> Array:
        u = k * (2 * unit_place(w, ax, q) - 1 - off)
        return -(np.cosh(u) - 1) / (np.cosh(k * (1 + abs(off))) - 1)

    return tool_only(to, f, axis=AX[ax])


def two_spans(s: Array, c: float) -> Array:
    """Deflection (down +, largest 1 within 1 %) under a load that travels over a beam on supports
    at 0, c and 1: Timoshenko's moment over the middle support."""
    left = s < c
    x, long = np.where(left, s, 1 - s), np.where(left, c, 1 - c)
    simple = (x * (long - x)) ** 2 / (3 * long)
    turn = x * (long**2 - x**2) / (6 * long)  # slope over the middle support of the loaded span
    y = simple - 3 * turn**2
    return y / float(max(_span_top(c), _span_top(1 - c)))


def _span_top(long: float) -> float:
    x = np.linspace(0, long, 201)
    turn = x * (long**2 - x**2) / (6 * long)
    return float(((x * (long - x)) ** 2 / (3 * long) - 3 * turn**2).max())


@later("sag")
def three_supports(w: World, r: Rng, ax: int) -> Shape:
    """A cross rail on three supports sags between them under its saddle (Timoshenko 1955)."""
    to, c = across(w, r, ax), r.uniform(0.35, 0.65)
    return tool_only(to, lambda q: -two_spans(np.clip(unit_place(w, ax, q), 0, 1), c), axis=AX[ax])


@later("force_compliance")
def push_and_pull(w: World, r: Rng, ax: int) -> Shape:
    """A thrust bearing of two balls one way and one the other: unlike stiffness for push and pull
    (Slocum 1992)."""
    k = r.uniform(0.4, 0.8) ** pick(r, [-1, 1])

    def f(q: Rec) -> Array:
        n = w.force(q, ax)
        return np.where(n > 0, n, k * n)

    return tool_only(ax, f, most=2.0)


@later("force_compliance")
def joints_slip(w: World, r: Rng, ax: int) -> Shape:
    """A linear compliance and joints that slip a little: a tenth to a third of it follows the load
    as a spring with a slider (Masing 1926; Weck and Brecher 2006)."""
    k, reach = r.uniform(0.1, 0.3), r.uniform(0.2, 0.6)

    def f(q: Rec) -> Array:
        n, top = w.force(q, ax), max(float(np.abs(w.load[ax]).max()), 1.0)
        slip = maxwell(np.r_[0.0, n / top], np.array([reach]), np.ones(1))[1:]
        return (1 - k) * n + k * top * slip

    return tool_only(ax, f, most=2.0)


def _radial(w: World, amount, told=lambda a: {}) -> Shape:
    """What a tool's radius does to parts: a * amount(q) for each reading, times `radial`."""

    def field(q: Rec, a: float) -> Part:
        return Part(reading=a * amount(q) * q.meta["radial"]) if q.kind == "features" else Part()

    return Shape(field, "", told)


@later("tool_wear")
def dressed(w: World, r: Rng, ax: int) -> Shape:
    """A wheel that loses in proportion to what it grinds, and is dressed and set anew after every 2
    to 4 parts and at the change (Malkin and Guo 2008)."""
    every = int(r.integers(2, 5))

    def amount(q: Rec) -> Array:
        k, change = q.meta["part"] - 1.0, q.meta["change"]
        k = np.where(q.meta["part"] >= change, k - change + 1, k)
        return -2 * ((k % every) + 0.5) / 8

    return _radial(w, amount)


@later("tool_wear")
def built_up_edge(w: World, r: Rng, ax: int) -> Shape:
    """An edge that first builds up, so that the tool cuts large, and then wears as usual (Trent and
    Wright 2000)."""
    k, top = r.uniform(0.1, 0.35), r.uniform(0.08, 0.2)

    def amount(q: Rec) -> Array:
        n, change = q.meta["part"] - 1.0, q.meta["change"]
        n = np.where(q.meta["part"] >= change, n - change + 1, n)
        s = (n + 0.5) / 8
        return -2 * (s - k * s / top * np.exp(1 - s / top))

    return _radial(w, amount)


@later("tool_size")
def clamped_anew(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter; the tool is taken from its magazine for each part and runs out by a little
    more or less: within a tenth of it, 0 in the mean (ISO 12164)."""
    sign, key = pick(r, [-1.0, 1.0]), int(r.integers(2**62))

    def amount(q: Rec) -> Array:
        part = q.meta["part"].astype(int)
        each = stream(key, q.name).uniform(-0.1, 0.1, int(part.max()) + 1)
        return sign * (1 + each[part] - each[1:].mean())

    return _radial(w, amount, lambda a: {"diameter_um": sign * a})
