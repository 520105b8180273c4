"""Geometry: scale, pitch, squareness, straightness, angles and arms, sag, and compliance.

Names of components and their signs by ISO 230-1; bending lines of beams by Euler and Bernoulli; the
press of two bodies by Hertz. `forward` is the side from which a slide moves towards plus.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from .base import ABOUT, AT, SQUARENESS, Array, Redraw, Rng, perpendicular, pick, sign
from .case import Case
from .recordings import Recording
from .registry import NUISANCES, Hidden, along, form, moved

POSITIONING = "laser laser_long probing"
STRAIGHT, VERTICAL, LINES = "straight", "straight_v", "laser_multi multi_v"
PLANE = "ballbar diag tt_circ"
EXPANSION = 11.5e-3  # um in 1 mm for 1 K, of steel

NUISANCES["pitch_shape"] = lambda c, rec: [rec.project({c.axis: rec.pos[c.axis]})]
NUISANCES["squareness"] = lambda c, rec: (
    [rec.project({c.axis: rec.vel[c.axis]})] if rec.kind == "ballbar" else []
)
NUISANCES["bow"] = lambda c, rec: [rec.project({c.other: rec.pos[c.axis]})]


@form("scale", f"{POSITIONING} diag ballbar features")
def constant_factor(c: Case, r: Rng) -> Hidden:
    """lead or scale graduation wrong by a constant factor"""
    s = sign(r)
    of_axis = along(c.axis, lambda rec: s * rec.pos[c.axis])
    return Hidden(
        lambda rec: {"r": _of_parts(rec, c.axis)} if rec.kind == "features" else of_axis.field(rec)
    )


def _of_parts(rec: Recording, axis: str) -> Array:
    """Lengths along an axis that grow with its scale: a pocket's by the cutter's way alone."""
    y = np.zeros(rec.n)
    parts = rec.parts
    for i in range(rec.n):
        kind, nominal = parts["kind"][i], parts["nominal"][i]
        if parts["axis"][i] != axis:
            continue
        if kind in ("centre_distance", "step") or (rec.turned and kind.endswith("diameter")):
            y[i] = nominal
        elif kind == "pocket_size":
            y[i] = nominal - 10
    return y


@form("scale", f"{POSITIONING} diag ballbar")
def steady_temperature(c: Case, r: Rng) -> Hidden:
    """scale of another expansion coefficient at a steady temperature that is not 20 C"""
    fixed = pick(r, c.machine.travel[c.axis])
    warmer = r.uniform(2, 6) * sign(r)  # K
    noted, seed = r.random() < 0.5, int(r.integers(1 << 30))

    def after(rec: Recording, size: float) -> None:
        if noted and rec.kind == "targets":
            q = np.random.default_rng(seed)
            name = f"T_scale_{c.axis}_C"
            rec.more[name] = 20 + warmer * size + q.normal() * 0.1 + q.normal(0, 0.03, rec.n)

    return along(
        c.axis,
        lambda rec: EXPANSION * warmer * (rec.pos[c.axis] - fixed),
        after=after,
        most=12 / abs(warmer),
    )


@form("pitch_shape", POSITIONING)
def polynomial(c: Case, r: Rng) -> Hidden:
    """quadratic plus cubic of the travel"""
    a, b = r.normal(size=2)

    def value(rec: Recording) -> Array:
        x = c.place(rec, c.axis)
        return a * x**2 + b * (x**3 - 0.6 * x)

    return along(c.axis, value)


@form("pitch_shape", POSITIONING)
def half_sine(c: Case, r: Rng) -> Hidden:
    """half sine (pre-stretched screw, scale bowed between its ends)"""
    s, k = sign(r), pick(r, [1, 1, 2, 1.5])
    return along(c.axis, lambda rec: s * np.sin(np.pi * k * c.share(rec, c.axis)))


@form("pitch_shape", POSITIONING)
def kink(c: Case, r: Rng) -> Hidden:
    """two pieces of scale with another slope (kink)"""
    s, k = sign(r), r.uniform(-0.4, 0.4)
    return along(c.axis, lambda rec: s * np.maximum(c.place(rec, c.axis) - k, 0))


@form("pitch_shape", POSITIONING)
def accumulated(c: Case, r: Rng) -> Hidden:
    """accumulated lead variation, smoothed random walk"""
    at = np.linspace(-1, 1, 9)
    y = np.cumsum(r.normal(size=9))
    y -= np.polyval(np.polyfit(at, y, 1), at)
    curve = CubicSpline(at, y)
    return along(c.axis, lambda rec: curve(c.place(rec, c.axis)))


@form("squareness", PLANE, "pair")
def second_leans(c: Case, r: Rng) -> Hidden:
    """second axis leans"""
    of_xz = pick(r, ["B0X", "B0Z"])
    name = of_xz if c.pair == "XZ" else SQUARENESS[c.pair]
    s = sign(r)
    return moved(lambda rec: c.machine.by_squareness(rec.pos, name, s))


@form("squareness", PLANE, "pair")
def both_lean(c: Case, r: Rng) -> Hidden:
    """both axes lean by half (hinged frame)"""
    a, b = c.pair[0], c.pair[1]
    about, s = perpendicular(a, b), sign(r)

    def value(rec: Recording) -> dict[str, Array]:
        one = c.machine.by_squareness(rec.pos, f"{about}0{a}", -s / 2)
        two = c.machine.by_squareness(rec.pos, f"{about}0{b}", s / 2)
        return {d: one[d] + two[d] for d in one}

    return moved(value)


@form("bow", STRAIGHT)
def bow_parabola(c: Case, r: Rng) -> Hidden:
    """parabola (guide bent)"""
    s = sign(r)
    return along(c.other, lambda rec: s * (1 - c.place(rec, c.axis) ** 2))


@form("bow", STRAIGHT)
def bow_sine(c: Case, r: Rng) -> Hidden:
    """half sine (guide on two supports)"""
    s, k = sign(r), pick(r, [1, 1, 1.5])
    return along(c.other, lambda rec: s * np.sin(np.pi * k * c.share(rec, c.axis)))


@form("bow", STRAIGHT)
def bow_on_feet(c: Case, r: Rng) -> Hidden:
    """bed on Bessel-like feet: fourth order beam line"""
    s, k = sign(r), r.uniform(0.3, 0.9)

    def value(rec: Recording) -> Array:
        x = c.place(rec, c.axis)
        return s * (x**4 - k * x**2)

    return along(c.other, value)


@form("abbe", LINES)
def unstated_arm(c: Case, r: Rng) -> Hidden:
    """yaw of the table times an arm nobody stated"""
    name = f"E{perpendicular(c.axis, c.other)}{c.axis}_urad"
    if name not in c.machine.true[c.axis]:
        raise Redraw
    yaw = c.machine.true[c.axis][name][0]
    if np.ptp(yaw) < 10:
        raise Redraw
    arm = r.uniform(60, 250) * sign(r)  # mm
    side = np.cross(np.eye(3)[ABOUT[name[1]]], np.eye(3)[AT[c.other]])[AT[c.axis]]

    def value(rec: Recording) -> Array:
        at = np.interp(rec.pos[c.axis], c.machine.nodes[c.axis], yaw)
        return side * at * arm * 1e-3

    return along(c.axis, value, most=500 / abs(arm))  # mm


@form("abbe", LINES)
def unknown_yaw(c: Case, r: Rng) -> Hidden:
    """guide bent to a parabola: unknown yaw linear in position, times the arm of the carried
    axis"""
    at = c.machine.measured_at[c.axis].get(c.other, 0.0)
    s, k = sign(r), r.normal() * 0.5

    def value(rec: Recording) -> Array:
        x = c.place(rec, c.axis)
        return s * (x + k * x**2) * (rec.pos[c.other] - at) * 0.01

    return along(c.axis, value)


@form("sag", VERTICAL)
def cantilever(c: Case, r: Rng) -> Hidden:
    """cantilever: droop with the run-out of the carriage"""
    turned = pick(r, [0, 1])

    def value(rec: Recording) -> Array:
        u = c.share(rec, c.axis)
        u = 1 - u if turned else u
        return -(u**2) * (3 - u) / 2

    return along("Z", value)


@form("sag", VERTICAL)
def bridge(c: Case, r: Rng) -> Hidden:
    """bridge on two columns under a rolling mass"""
    share = c.share
    return along("Z", lambda rec: -16 * share(rec, c.axis) ** 2 * (1 - share(rec, c.axis)) ** 2)


@form("sag", LINES, "other")
def slope_by_mass(c: Case, r: Rng) -> Hidden:
    """positioning slope that follows the mass on the carried axis"""
    s, p = sign(r), pick(r, [1, 2])
    return along(c.axis, lambda rec: s * c.place(rec, c.axis) * c.share(rec, c.other) ** p)


@form("force_compliance", "load")
def spring(c: Case, r: Rng) -> Hidden:
    """linear spring"""
    return along(c.axis, lambda rec: rec.force[c.axis] * 1e-2)


@form("force_compliance", "load")
def hertz(c: Case, r: Rng) -> Hidden:
    """Hertz contact, F to the power 2/3"""

    def value(rec: Recording) -> Array:
        force = rec.force[c.axis]
        return np.sign(force) * abs(force) ** (2 / 3) * 1e-1

    return along(c.axis, value)


@form("force_compliance", "load")
def lost_preload(c: Case, r: Rng) -> Hidden:
    """preload lost: soft until the gap is closed, then stiff"""
    k, w = r.uniform(1.5, 4), r.uniform(0.15, 0.35)

    def value(rec: Recording) -> Array:
        force = rec.force[c.axis]
        part = force / abs(force).max()
        return part + (k - 1) * np.clip(part, -w, w)

    return along(c.axis, value)
