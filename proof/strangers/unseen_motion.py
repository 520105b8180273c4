"""Friction and lost motion of the unseen family.  Do not read while working on the judged tool.

Signs and what sees what as in forms_motion.  Sources: ISO 230-2 (reversal value), Renishaw's manual
of the QC20-W ballbar (backlash steps, reversal spikes), Slocum 1992 (stiffness of a screw along its
length), Prandtl 1928 and Iwan 1966 (yield points spread evenly), Al-Bender, Lampaert and Swevers
2005 (The generalized Maxwell-slip model; IEEE Trans. Automatic Control 50: power law before
sliding), Armstrong-Helouvry 1991 (Control of machines with friction), Bowden and Tabor 1950
(stick-slip of a mass on a spring), Harris (Rolling bearing analysis: moment as speed to the power
of 2/3).
"""

from __future__ import annotations

import numpy as np

from .base import Array, Rec, Rng, Shape, logu
from .forms_motion import maxwell
from .registry import both, moving, tool_only, unit_place, unseen
from .world import World


@unseen("backlash")
def step(w: World, r: Rng, ax: int) -> Shape:
    """The whole loss at once: a step at every reversal (ISO 230-2; ballbar manual)."""
    return tool_only(ax, lambda q: -0.5 * q.sgn[:, ax], params=lambda a: {"size_um": a})


@unseen("backlash")
def overcompensated(w: World, r: Rng, ax: int) -> Shape:
    """A control that puts in more than the play there is: the slide leads (ballbar manual, negative
    backlash)."""
    return tool_only(ax, lambda q: 0.5 * q.sgn[:, ax])


@unseen("backlash_position")
def soft_middle(w: World, r: Rng, ax: int) -> Shape:
    """Friction over the stiffness of a screw held at both ends: most in the middle, 4 s (1 - s)
    over a rest that is the nut's (Slocum 1992)."""
    rest = r.uniform(0.15, 0.6)

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return -0.5 * q.sgn[:, ax] * (rest + 4 * s * (1 - s))

    return tool_only(ax, f)


@unseen("backlash_position")
def work_area(w: World, r: Rng, ax: int) -> Shape:
    """Wear where the work is: a raised cosine over a third to two thirds of the travel, as new
    outside (Slocum 1992)."""
    half, new = r.uniform(0.16, 0.34), r.uniform(0.1, 0.35)
    c = r.uniform(half, 1 - half)

    def f(q: Rec) -> Array:
        u = np.clip((unit_place(w, ax, q) - c) / half, -1, 1)
        return -0.5 * q.sgn[:, ax] * (new + 0.5 + 0.5 * np.cos(np.pi * u))

    return tool_only(ax, f)


@unseen("windup")
def even_yield(w: World, r: Rng, ax: int) -> Shape:
    """Yield points spread evenly up to one way: branches are parabolas (Prandtl, Iwan)."""
    reach = logu(r, 0.03, 1.5) * (np.arange(12) + 0.5) / 12
    return tool_only(ax, lambda q: -maxwell(q.via[:, ax], reach, np.full(12, 1 / 12))[q.row_at])


def power_law(s0: float, p: float, n: int = 14) -> tuple[Array, Array]:
    """Reaches (mm) and shares of slip elements whose virgin curve is (x / s0)^p up to s0.

    The slope falls at a reach u by share / u; what is left of it at s0, p / s0, yields there.
    """
    edge = np.geomspace(1e-3, 1.0, n + 1)
    share = (1 - p) * np.diff(np.r_[0.0, edge[1:]] ** p)
    return s0 * np.r_[np.sqrt(edge[1:] * edge[:-1]), 1.0], np.r_[share, p]


@unseen("windup")
def before_sliding(w: World, r: Rng, ax: int) -> Shape:
    """Maxwell-slip elements with a power law of 0.4 to 0.7 before sliding (Al-Bender et al.)."""
    reach, share = power_law(logu(r, 0.05, 2.0), r.uniform(0.4, 0.7))
    return tool_only(ax, lambda q: -maxwell(q.via[:, ax], reach, share)[q.row_at])


@unseen("reversal_spike")
def half_sine(w: World, r: Rng, ax: int) -> Shape:
    """A glitch of a tenth to half a second: half a sine in time (ballbar manual)."""
    t0 = logu(r, 0.1, 0.5)
    return both(
        ax,
        lambda q: -q.sgn[:, ax] * np.sin(np.pi * np.minimum(q.revt[:, ax] / t0, 1.0)),
    )


@unseen("reversal_spike")
def integral_action(w: World, r: Rng, ax: int) -> Shape:
    """The loop holds on at once and its integral lets go: an exponential in time (Armstrong-
    Helouvry 1991)."""
    ti = logu(r, 0.04, 0.4)
    return both(ax, lambda q: -q.sgn[:, ax] * np.exp(-q.revt[:, ax] / ti))


@unseen("stick_slip")
def mass_on_spring(w: World, r: Rng, ax: int) -> Shape:
    """A spring wound up while it sticks and let go in a slip of a set time: the length of a cycle
    is that of the stick and what is driven on during the slip (Bowden and Tabor)."""
    seg, slip, top = logu(r, 0.05, 0.8), logu(r, 0.02, 0.1), logu(r, 3, 10)

    def f(q: Rec) -> Array:
        v = np.abs(q.vel[:, ax])
        on = (v > 1e-4) & (v < top)
        back = np.minimum(v, top) * slip
        u = q.since[:, ax] % (seg + back)
        down = 0.5 + 0.5 * np.cos(np.pi * np.clip((u - seg) / np.maximum(back, 1e-9), 0, 1))
        return -q.sgn[:, ax] * on * np.where(u < seg, u / seg, down)

    return both(ax, f)


def _friction(effect: str, law) -> None:
    """Files law(q, world, axis, constants 0..1) of an axis's friction, with its motor current."""

    @unseen(effect)
    def f(w: World, r: Rng, ax: int) -> Shape:
        c = r.uniform(0, 1, 3)

        def shape(q: Rec) -> Array:
            return -law(q, w, ax, c)

        out = both(ax, shape)
        out.current = lambda q, a: -a * shape(q) * w.machine.stiffness[ax] / 400  # type: ignore
        return out


def _tight_end(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Coulomb friction of a screw whose preload is tighter at one end, up to a fifth (Slocum)."""
    return np.tanh(q.vel[:, ax] / 0.1) * (1 + 0.4 * (c[0] - 0.5) * (unit_place(w, ax, q) - 0.5))


def _grease_and_seals(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Viscous share of the ways and grease of the balls as speed to the power of 2/3 (Harris)."""
    u = q.vel[:, ax] / max(w.machine.vmax / 60, 1e-9)
    k = 0.2 + 0.4 * c[0]
    return (1 - k) * u + k * np.sign(u) * np.abs(u) ** (2 / 3)


def _two_ways(q: Rec, w: World, ax: int, c: Array) -> Array:
    """Unlike levels in the two directions, both with one Stribeck fall (Armstrong-Helouvry)."""
    s = moving(q, ax)
    fall = 1 + (0.1 + 0.3 * c[0]) * np.exp(-((q.vel[:, ax] / (1 + 9 * c[1])) ** 2))
    return np.where(s > 0, 1.0, np.where(s < 0, -0.35 - 0.3 * c[2], 0.0)) * fall


for _e, _law in (
    ("coulomb_friction", _tight_end),
    ("viscous_friction", _grease_and_seals),
    ("friction_asymmetry", _two_ways),
):
    _friction(_e, _law)
