"""Friction and lost motion of the later family.  Do not read while working on the judged tool.

Signs and what sees what as in forms_motion.  Sources: ISO 3408-4 and Weck and Brecher 2006
(Werkzeugmaschinen 2: contact of balls, deflection as load to the power of 2/3), Armstrong-
Helouvry, Dupont and Canudas de Wit 1994 (Automatica 30: break-away, relaxation at rest), Slocum
1992 (rack and pinion; racks in sections), Dahl 1976 (Solid friction damping of mechanical
vibrations; AIAA J. 14: exponent i), Jenkins 1962 (a spring and a slider in series), Tarng, Kao and
Lin 1997 and Erkorkmaz and Altintas 2001 (quadrant glitches and the acceleration at the reversal),
Renishaw's manual of the QC20-W ballbar (spikes that are compensated too much), Derjaguin, Push and
Tolstoi 1957 (stick-slip that falls with the logarithm of speed), Ibrahim 1994 (friction-induced
vibration: slips that ring), Makkar et al. 2005 (A new continuously differentiable friction model),
Moore 1959 (thixotropy: structure that is broken by shear and heals), Merritt 1967 (Hydraulic
control systems: orifices, unlike areas).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, Shape, logu, pick
from .forms_motion import maxwell
from .registry import both, later, moving, tool_only, unit_place
from .world import World


@later("backlash")
def balls_take_over(w: World, r: Rng, ax: int) -> Shape:
    """Balls that are pressed on anew from the other side over 2 to 20 um: way as the power of 2/3
    of the force that rises with the motor's way (ISO 3408-4)."""
    s0 = logu(r, 0.002, 0.02)

    def f(q: Rec) -> Array:
        return -0.5 * q.sgn[:, ax] * (2 * np.minimum(q.since[:, ax] / s0, 1.0) ** (2 / 3) - 1)

    return tool_only(ax, f, params=lambda a: {"size_um": a})


@later("backlash")
def eases_at_rest(w: World, r: Rng, ax: int) -> Shape:
    """The whole loss in motion; at rest a twentieth to a fifth of it has been shaken out
    (Armstrong-Helouvry et al. 1994, relaxation)."""
    k = r.uniform(0.05, 0.2)
    still = {q.kind in ("targets", "features") for q in w.recs if q.outside}

    def f(q: Rec) -> Array:
        return -0.5 * q.sgn[:, ax] * (1 - k if q.kind in ("targets", "features") else 1.0)

    def size(a: float) -> dict[str, float]:
        return {"size_um": a * (1 - k if True in still else 1.0)} if len(still) == 1 else {}

    return tool_only(ax, f, params=size)


@later("backlash_position")
def eccentric_pinion(w: World, r: Rng, ax: int) -> Shape:
    """A pinion that runs out against its rack: the play between them rises and falls once a turn,
    pi times module times teeth (Slocum 1992)."""
    turns = [np.pi * m * z for m in (1.5, 2.0, 3.0, 4.0) for z in (16, 20, 25, 32)]
    fits = [p for p in turns if 0.25 < p / np.ptp(w.machine.travel[ax]) < 0.9] or [turns[0]]
    p, ph, k = float(pick(r, fits)), r.uniform(0, 6.28), r.uniform(0.4, 0.9)

    def f(q: Rec) -> Array:
        return -0.5 * q.sgn[:, ax] * (1 + k * np.sin(2 * np.pi * q.pos[:, ax] / p + ph))

    return tool_only(ax, f)


@later("backlash_position")
def rack_in_sections(w: World, r: Rng, ax: int) -> Shape:
    """Three to five racks in a row, each set to its own play (Slocum 1992)."""
    n = int(r.integers(3, 6))
    edge = (np.arange(1, n) + r.uniform(-0.2, 0.2, n - 1)) / n
    play = r.permutation(np.linspace(0.15, 1.0, n))

    def f(q: Rec) -> Array:
        return -0.5 * q.sgn[:, ax] * play[np.searchsorted(edge, unit_place(w, ax, q))]

    return tool_only(ax, f)


def dahl_power(cmd: Array, s0: float, i: float) -> Array:
    """Dahl's state in -1..1 with exponent i (not 1): du/dx = -u^i / s0, u = 1 - z sign(dx)."""
    z, out = 0.0, []
    for h in np.diff(cmd, prepend=cmd[0]).tolist():
        if h:
            d = 1.0 if h > 0 else -1.0
            u = max(1 - d * z, 1e-12) ** (1 - i) + (i - 1) * abs(h) / s0
            z = d * (1 - (u ** (1 / (1 - i)) if u > 0 else 0.0))
        out.append(z)
    return np.array(out)


@later("windup")
def brittle_or_ductile(w: World, r: Rng, ax: int) -> Shape:
    """Dahl's own exponent: 0.5 (yields at a set way, as what is brittle) or 1.5 to 2 (long tails,
    as what is ductile)."""
    s0, i = logu(r, 0.02, 1.5), float(pick(r, [0.5, 1.5, 2.0]))
    return tool_only(ax, lambda q: -dahl_power(q.via[:, ax], s0, i)[q.row_at])


@later("windup")
def balls_and_wipers(w: World, r: Rng, ax: int) -> Shape:
    """Two springs with sliders: balls that let go after 10 to 60 um, lips of wipers after 0.3 to
    3 mm (Jenkins 1962)."""
    reach, k = np.array([logu(r, 0.01, 0.06), logu(r, 0.3, 3.0)]), r.uniform(0.3, 0.7)
    return tool_only(ax, lambda q: -maxwell(q.via[:, ax], reach, np.array([k, 1 - k]))[q.row_at])


def jolt(q: Rec, ax: int) -> Array:
    """Acceleration (mm/s2) of the axis at its last reversal, for each row in motion."""
    at = np.searchsorted(q.t, q.t - q.revt[:, ax] - 1e-9)
    return np.abs(q.acc[np.clip(at, 0, len(q.t) - 1), ax])


@later("reversal_spike")
def with_acceleration(w: World, r: Rng, ax: int) -> Shape:
    """A bell some way after the reversal, that is the higher the harder the axis turns: a power of
    0.2 to 0.5 of its acceleration (Tarng et al. 1997)."""
    wide, p = logu(r, 0.01, 0.3), r.uniform(0.2, 0.5)
    late = wide * r.uniform(1.5, 2.5)

    def f(q: Rec) -> Array:
        if q.kind not in ("trace", "ballbar"):
            return np.zeros(len(q.t))
        a = jolt(q, ax)
        gain = np.clip(a / max(float(a.max()), 1e-9), 0.01, 1) ** p
        return -q.sgn[:, ax] * gain * np.exp(-0.5 * ((q.since[:, ax] - late) / wide) ** 2)

    return both(ax, f)


@later("reversal_spike")
def cut_in(w: World, r: Rng, ax: int) -> Shape:
    """A control's pulse that is too long: the slide hangs back first and then leads by a tenth to
    a third (ballbar manual)."""
    s0, c = logu(r, 0.03, 0.8), r.uniform(0.9, 1.8)
    return both(
        ax,
        lambda q: -q.sgn[:, ax] * (1 - q.since[:, ax] / s0 / c) * np.exp(-q.since[:, ax] / s0),
    )


def creeping(q: Rec, ax: int, top: float) -> Array:
    """1 where the axis creeps at less than `top` mm/s, 0 where it stands or is fast."""
    v = np.abs(q.vel[:, ax])
    return ((v > 1e-4) & (v < top)) * 1.0


@later("stick_slip")
def ringing_slip(w: World, r: Rng, ax: int) -> Shape:
    """A saw whose every slip rings three to five times (Ibrahim 1994)."""
    seg, top, n = logu(r, 0.08, 1.0), logu(r, 3, 10), r.uniform(3, 5)
    k = r.uniform(0.2, 0.5)

    def f(q: Rec) -> Array:
        u = (q.since[:, ax] / seg) % 1.0
        ring = k * np.exp(-u / 0.2) * np.sin(2 * np.pi * n * u)
        return -q.sgn[:, ax] * creeping(q, ax, top) * (u - ring)

    return both(ax, f)


@later("stick_slip")
def fading_with_speed(w: World, r: Rng, ax: int) -> Shape:
    """A saw as high as the logarithm of speed tells: all of it at 0.3 mm/s, none at the speed from
    which the slide runs smoothly (Derjaguin et al. 1957)."""
    seg, top = logu(r, 0.05, 0.6), logu(r, 4, 12)

    def f(q: Rec) -> Array:
        v = np.clip(np.abs(q.vel[:, ax]), 0.3, top)
        high = np.log(top / v) / np.log(top / 0.3)
        return -q.sgn[:, ax] * creeping(q, ax, top) * high * ((q.since[:, ax] / seg) % 1.0)

    return both(ax, f)


def _friction(effect: str, law) -> None:
    """Files law(q, world, axis, constants 0..1) of an axis's friction, with its motor current."""

    @later(effect)
    def f(w: World, r: Rng, ax: int) -> Shape:
        c = r.uniform(0, 1, 3)

        def shape(q: Rec) -> Array:
            return -law(q, w, ax, c)

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


def _makkar(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb with a smooth rise to its break-away and a fall behind it: differences of tanh
    (Makkar et al. 2005)."""
    v = q.vel[:, ax]
    fall = np.tanh(v / 0.05) - np.tanh(v / (1 + 6 * c[0]))
    return np.tanh(v / 0.05) + (0.1 + 0.25 * c[1]) * fall


def _break_away(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb, and after each reversal up to a third more that is gone within 0.1 to 1 s."""
    t0 = 0.1 * 10 ** c[0]
    return moving(q, ax) * (1 + (0.1 + 0.25 * c[1]) * np.exp(-q.revt[:, ax] / t0))


def _thixotropy(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Grease that stands thick and is worked thin: its structure heals in 20 to 200 s and is broken
    within 0.2 to 2 m of way (Moore 1959)."""
    heal, way, more = 20 * 10 ** c[0], 200 * 10 ** c[1], 0.2 + 0.5 * c[2]
    v = q.vel[:, ax]
    dt = np.diff(q.t, prepend=q.t[0])
    lam, out = 1.0, np.empty(len(v))
    for i, (x, h) in enumerate(zip(np.abs(v).tolist(), dt.tolist(), strict=True)):
        lam += min(h / heal, 1.0) * (1 - lam) - min(h * x / way, 1.0) * lam
        out[i] = lam
    return v * (1 + more * out)


def _cover(q: Rec, w: World, ax: int, c: Array) -> Array:
    """A cover that is pushed together in + and pulls along in -: the more the farther out."""
    s, u = moving(q, ax), np.clip(unit_place(w, ax, q), 0, 1)
    push, pull = 1 + (0.3 + 0.6 * c[0]) * u, 0.3 + 0.3 * c[1] - 0.2 * c[2] * u
    return np.where(s > 0, push, np.where(s < 0, -pull, 0.0))


def _balance(q: Rec, w: World, ax: int, c: Array) -> Array:
    """A balancing cylinder: oil is pressed out through an orifice in one direction (as the square
    of speed) and sucked in freely in the other; packings rub alike (Merritt 1967)."""
    s = moving(q, ax)
    u = np.abs(q.vel[:, ax]) / max(float(np.abs(q.vel[:, ax]).max()), 1e-9)
    out, back = 0.8 + 0.6 * c[0] * u**2, 0.25 + 0.25 * c[1]
    return np.where(s > 0, out, np.where(s < 0, -back, 0.0))


for _e, _law in (
    ("coulomb_friction", _makkar),
    ("coulomb_friction", _break_away),
    ("viscous_friction", _thixotropy),
    ("friction_asymmetry", _cover),
    ("friction_asymmetry", _balance),
):
    _friction(_e, _law)
