"""Forms of place, load and tool of the unseen family.  Do not read while working on the judged
tool.

Conventions as in forms_place.  Sources: ISO 230-2 (scales away from 20 C), ISO 3408-3 (travel of
ball screws), Weck and Brecher 2006 (Werkzeugmaschinen 5: pitch tables of controls), Slocum 1992
(Precision machine design: geared drives, beds on their feet), Ernst 1998 (Digital linear and
angular metrology: eccentric discs), ISO 230-1:2012 (squareness; compliance), Bryan 1979 (The Abbe
principle revisited), Roark (beam held at one end, propped at the other), Altintas 2012 (static
compliance; flank wear), ISO 8688-2 (tool life in milling).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from .base import AX, Array, Part, Rec, Rng, Shape, pick
from .forms_place import across
from .registry import along, tool_only, unit_place, unseen
from .world import World


@unseen("scale")
def scale_not_at_20(w: World, r: Rng, ax: int) -> Shape:
    """A scale that is not at 20 C: a slope, up to a tenth more or less as the frame's temperature
    goes on (ISO 230-2, nominal differential expansion)."""
    sign, k, lo = pick(r, [-1.0, 1.0]), r.uniform(-0.1, 0.1), w.machine.travel[ax][0]
    warm = (w.frame - w.frame[0]) / max(float(np.abs(w.frame - w.frame[0]).max()), 1e-9)
    return tool_only(ax, lambda q: sign * (q.pos[:, ax] - lo) / 1e3 * (1 + k * w.at(warm, q.t)))


@unseen("pitch_shape")
def progressive(w: World, r: Rng, ax: int) -> Shape:
    """Lead that grows along the screw: a parabola with a smaller cubic part (ISO 3408-3)."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(-0.6, 0.6)

    def f(q: Rec) -> Array:
        u = 2 * unit_place(w, ax, q) - 1
        return sign * (u**2 + k * (u**3 - 0.6 * u))

    return tool_only(ax, f)


@unseen("pitch_shape")
def coarse_table(w: World, r: Rng, ax: int) -> Shape:
    """Pitch table of 6 to 10 points of which two that follow each other are wrong: straight lines
    between them (Weck and Brecher 2006)."""
    n = int(r.integers(6, 11))
    y = np.zeros(n)
    i = int(r.integers(1, n - 2))
    y[i : i + 2] = pick(r, [-1.0, 1.0]) * np.r_[1.0, r.uniform(0.4, 1.0)]
    return tool_only(ax, lambda q: np.interp(unit_place(w, ax, q), np.linspace(0, 1, n), y))


@unseen("cyclic")
def geared_motor(w: World, r: Rng, ax: int) -> Shape:
    """A motor geared down 1.5 to 4 times: its pulley's run-out once a turn of the motor (Slocum
    1992)."""
    p, ph = w.machine.lead[ax] / float(pick(r, [1.5, 2.0, 2.5, 3.0, 4.0])), r.uniform(0, 6.28)
    return tool_only(
        ax,
        lambda q: np.sin(2 * np.pi * q.pos[:, ax] / p + ph),
        params=lambda a: {"period_mm": p, "amplitude_um": a},
    )


@unseen("cyclic")
def wobbling_nut(w: World, r: Rng, ax: int) -> Shape:
    """Run-out of the screw once a turn, that the nut feels more the nearer it is to the middle of
    the free length (ISO 3408-3, run-out)."""
    p, ph, k = w.machine.lead[ax], r.uniform(0, 6.28), r.uniform(0.2, 0.6)

    def f(q: Rec) -> Array:
        gain = (1 - k) + k * np.sin(np.pi * np.clip(unit_place(w, ax, q), 0, 1))
        return gain * np.sin(2 * np.pi * q.pos[:, ax] / p + ph)

    return tool_only(ax, f, params=lambda a: {"period_mm": p})


@unseen("encoder_cyclic")
def eccentric_disc(w: World, r: Rng, ax: int) -> Shape:
    """Disc of a motor's encoder that sits off its centre: once a turn, and a little twice (Ernst
    1998); seen where the axis's own readings are recorded."""
    p, ph, k = w.machine.lead[ax], r.uniform(0, 6.28, 2), r.uniform(0.0, 0.25)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "trace" or q.meta["sees"] == "tool":
            return Part()
        th = 2 * np.pi * q.pos[:, ax] / p
        y = np.sin(th + ph[0]) + k * np.sin(2 * th + ph[1])
        return Part(reading=along(q, ax, a * y))

    return Shape(field, AX[ax], lambda a: {"period_mm": p})


@unseen("squareness")
def first_axis_leans(w: World, r: Rng, ax: int) -> Shape:
    """The same angle as a lean, but the other axis of the pair is the one that is off (ISO 230-1:
    squareness has no reference of its own)."""
    m = w.machine
    pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
    _, unit, lean = m.lean(pair)
    other = next(AX.index(p) for p in pair if AX.index(p) != lean)
    sign = pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        return Part(tool=np.cross(-unit * sign * a, along(q, other, q.pos[:, other])) * 1e-3)

    return Shape(field, pair, lambda a: {"urad": sign * a})


@unseen("bow")
def bed_on_feet(w: World, r: Rng, ax: int) -> Shape:
    """A bed levelled on three to five feet, not all at one height, bends as a spline through them
    (Slocum 1992)."""
    to, n = across(w, r, ax), int(r.integers(3, 6))
    x, y = np.linspace(0, 1, n), r.normal(size=n)
    y = y - np.polyval(np.polyfit(x, y, 1), x)
    f = CubicSpline(x, y / np.abs(y).max(), bc_type="natural")
    return tool_only(to, lambda q: f(unit_place(w, ax, q)), axis=AX[ax])


@unseen("abbe")
def even_curve(w: World, r: Rng, ax: int) -> Shape:
    """A bed bent evenly: the carriage turns in proportion to its way, times the arm (Bryan 1979);
    not in the tables."""
    m, sign = w.machine, pick(r, [-1.0, 1.0])
    about = 1 if len(m.axes) == 2 else int(r.integers(0, 3))

    def field(q: Rec, a: float) -> Part:
        rot = np.zeros((len(q.t), 3))
        rot[:, about] = sign * a * (2 * unit_place(w, ax, q) - 1)
        return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3, rot=rot)

    return Shape(field, AX[ax], most=300.0)


@unseen("sag")
def propped_beam(w: World, r: Rng, ax: int) -> Shape:
    """A saddle on a beam held at one end and propped at the other: s^3 (1 - s)^2 (4 - s) under the
    load (Roark; 7/768 in the middle of a unit beam, here over 12)."""
    to, flip = across(w, r, ax), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, ax, q)
        return -propped(1 - s if flip else s) / propped(np.linspace(0, 1, 201)).max()

    return tool_only(to, f, axis=AX[ax])


def propped(s: Array) -> Array:
    """Deflection under a unit load at s from the held end, E I = length = 1."""
    return s**3 * (1 - s) ** 2 * (4 - s) / 12


@unseen("force_compliance")
def coupled(w: World, r: Rng, ax: int) -> Shape:
    """A linear compliance that also moves the tool across by 0.1 to 0.4 of it (ISO 230-1:2012;
    Altintas 2012, cross compliance)."""
    to = int(pick(r, [a for a in w.machine.axes if a != ax]))
    k = r.uniform(0.1, 0.4) * pick(r, [-1.0, 1.0])

    def field(q: Rec, a: float) -> Part:
        n = w.force(q, ax)
        return Part(tool=along(q, ax, a * n) + along(q, to, a * k * n))

    return Shape(field, AX[ax], lambda a: {"um_per_N": a}, most=2.0)


@unseen("force_compliance")
def quill_out(w: World, r: Rng, ax: int) -> Shape:
    """A ram or quill pushed aside gives way with the cube of its overhang over what does not depend
    on it (Slocum 1992)."""
    far = w.machine.axes[-1]
    rest, flip = r.uniform(0.4, 1.0), r.random() < 0.5

    def f(q: Rec) -> Array:
        s = unit_place(w, far, q)
        return w.force(q, ax) * (rest + (1 - s if flip else s) ** 3) / (rest + 1)

    return tool_only(ax, f, most=2.0)


@unseen("tool_wear")
def by_length_cut(w: World, r: Rng, ax: int) -> Shape:
    """Flank wear that runs in and then goes in proportion to the length cut, feature by feature
    (ISO 8688-2; Altintas 2012)."""
    first = r.uniform(0.0, 0.25)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        info, part = q.meta["info"], q.meta["part"]
        size = {i[0]: i[3] for i in info}
        length = np.array([size[k] for k in sorted(size)])
        done = (np.cumsum(length) - length / 2) / length.sum()
        k = np.where(part >= q.meta["change"], part - q.meta["change"], part - 1.0)
        s = (k + done[np.array([i[0] for i in info]) - 1]) / 8
        y = first * (1 - np.exp(-s / 0.05)) + (1 - first) * s
        return Part(reading=-2 * a * y * q.meta["radial"])

    return Shape(field, "")


@unseen("tool_size")
def pushed_off(w: World, r: Rng, ax: int) -> Shape:
    """A wrong diameter, a few per cent less of it on the axis along which the wall gives way
    (Altintas 2012)."""
    sign, k = pick(r, [-1.0, 1.0]), r.uniform(0.9, 1.0, 3)

    def field(q: Rec, a: float) -> Part:
        if q.kind != "features":
            return Part()
        return Part(reading=sign * a * q.meta["radial"] * k[[i[2] for i in q.meta["info"]]])

    return Shape(field, "")
