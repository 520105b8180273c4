"""Errors of the machine's geometry (ISO 230-1): scales, pitch, squareness, straightness, angles,
weight. Every function plans a test that shows the effect, and gives it; form: of `forms.FORMS`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import moving_plans, rest_plans
from .base import TURN, Array, Redraw, levelled, pick
from .case import Case, Hidden
from .recordings import Recording

SQUARE_TO = {"C0Y": "X", "B0Z": "X", "A0Z": "Y", "B0X": "Z"}  # where the axis at the end leans to
SENSE = {"C0Y": -1, "B0Z": 1, "A0Z": -1, "B0X": -1}


def along(d: str, value: Callable[[Recording], Array]) -> Callable[..., dict[str, Array]]:
    """A field: size times a value in a direction, um."""
    return lambda rec, size: rec.project({d: size * value(rec)})


def scale(c: Case, form: str) -> Hidden:
    """Too far in proportion to the place (ISO 230-2); size: um/mm."""
    parts = form == "wrong steps/mm in parts"
    among = ["X"] if len(c.machine.axes) == 2 else ["X", "Y"]
    a = c.axis(among if parts else None)
    zero = pick(c.r, [0.0, c.machine.travel[a][0], c.machine.middle(a)])
    names = ["cosine"]
    if parts:
        c.once(moving_plans.features)
        names = []
    elif form == "one axis stretched, ballbar":
        c.once(moving_plans.ballbar, *c.plane(a))
        # the bar's own length is free: only a second measurement tells which of the two axes it is
        c.once(rest_plans.linear, a, n=5, runs=2)
        names = []
    else:
        c.once(rest_plans.linear, a)
    return Hidden(
        "scale",
        a,
        form,
        along(a, lambda rec: rec.pos[a] - zero),
        parts=lambda rec: (rec.parts["axis"] == a) * rec.parts["nominal_mm"],
        size=0.01,
        most=0.3 if form == "screw warmer than 20 C" else 0.8,
        names_too=names,
    )


def pitch_shape(c: Case, form: str) -> Hidden:
    """A screw whose pitch changes along the travel; size: um, of the curve without its line."""
    a, r = c.axis(), c.r
    c.once(rest_plans.linear, a)
    begin, end, periods = r.uniform(0.25, 0.4), r.uniform(0.55, 0.75), r.uniform(0.9, 1.6)
    phase, kink = r.uniform(0, 6.28), r.uniform(0.35, 0.65)

    def curve(u: Array) -> Array:
        if form == "worn screw in the middle third":
            hump = np.sin(np.pi * (u - begin) / (end - begin)) ** 2
            return np.where((u > begin) & (u < end), hump, 0)
        if form == "stretched between fixed bearings (parabola)":
            return 4 * u * (1 - u)
        if form == "S curve of a rolled screw":
            return np.sin(TURN * periods * u + phase)
        return -np.abs(u - kink)

    shape = levelled(curve)
    return Hidden("pitch_shape", a, form, along(a, lambda rec: shape(c.share(a, rec))))


def squareness(c: Case, form: str) -> Hidden:
    """An axis that leans towards another (ISO 230-1); size: urad."""
    m = c.machine
    names = list(m.square)
    name = pick(c.r, names)
    bar = form == "ballbar ellipse at 45 degrees"
    if bar and len(m.axes) == 3:
        wide = [n for n in names if min(m.length(n[2]), m.length(SQUARE_TO[n])) >= 60]
        name = pick(c.r, wide or ["C0Y"])
    leans, to = name[2], SQUARE_TO[name]
    pair = sorted((leans, to))
    if form == "granite square and dial":
        c.once(rest_plans.square, leans, to)
    else:
        c.once(moving_plans.ballbar if bar else rest_plans.diagonals, *pair)
    sense = SENSE[name]
    return Hidden(
        "squareness",
        "".join(pair),
        form,
        lambda rec, size: rec.project({to: size * sense * 1e-3 * rec.pos[leans]}),
        size=20.0,
        most=2000.0 if m.coarse else 500.0,
        axes_too=["".join(pair[::-1])],
        params={"name": name},
    )


def bow(c: Case, form: str) -> Hidden:
    """A guideway that is not straight (ISO 230-1); size: um."""
    a = c.axis()
    d = c.other(a)
    c.once(rest_plans.straight, a, d)
    worn, width = c.r.uniform(0.25, 0.45), c.r.uniform(0.1, 0.2)

    def curve(u: Array) -> Array:
        if form == "hogged guideway (parabola)":
            return 4 * u * (1 - u)
        if form == "S-shaped guideway (cubic)":
            return 10.4 * (u - 0.5) * (u - 0.2) * (u - 0.8)
        return -np.exp(-0.5 * ((u - worn) / width) ** 2)

    shape = levelled(curve)
    return Hidden("bow", a, form, along(d, lambda rec: shape(c.share(a, rec))))


def abbe(c: Case, form: str) -> Hidden:
    """A rotation at an arm (Abbe; ISO 230-1): of a tool that is longer than stated, size: mm; or
    of a rotation that nobody measured, at several arms, size: urad."""
    m = c.machine
    a, name, s, d = pick(c.r, _arms(c))
    about = "ABC".index(name[1])
    # about x s is d, or against it
    sense = 1.0 if "XYZ".index(s) == (about + 1) % 3 else -1.0
    if form == "tool longer than stated, rotation known":
        if d == a:
            c.once(rest_plans.linear, a, style=pick(c.r, ["iso", "shuffled"]))
        else:
            c.once(rest_plans.straight, a, d)

        def longer(rec: Recording, size: float) -> dict[str, Array]:
            angle = np.interp(rec.pos[a], m.nodes[a], m.known[a][name])
            return rec.project({d: size * sense * 1e-3 * angle})

        params = {"component": name, "arm_along": s}
        return Hidden("abbe", a, form, longer, size=100.0, most=600.0, params=params)
    hump, width = c.r.uniform(0.3, 0.7), c.r.uniform(0.15, 0.3)
    c.once(rest_plans.grid, a, s, d)

    def turned(rec: Recording, size: float) -> dict[str, Array]:
        u = c.share(a, rec)
        if form == "pitch over a hump of the bed, several heights":
            angle = np.exp(-0.5 * ((u - hump) / width) ** 2)
        else:
            angle = (u - 0.5) * 2 + 0.3 * np.sin(3 * u)
        arm = m.tool.get(s, 0.0) + rec.pos[s] - m.measured_at[a][s]
        return rec.project({d: size * sense * 1e-3 * angle * arm})

    params = {"component": name[:3], "arm_along": s}
    return Hidden("abbe", a, form, turned, size=30.0, most=600.0, params=params)


def _arms(c: Case) -> list[tuple[str, str, str, str]]:
    """Axis, its measured rotation, the direction of an arm that changes, and of what it moves."""
    m, found = c.machine, []
    for a in m.axes:
        for name, y in m.known[a].items():
            if not (name.endswith("urad") and np.ptp(y) > 1.5):
                continue
            about = "XYZ"["ABC".index(name[1])]
            for s in m.carried(a):
                if s != about:
                    (d,) = set("XYZ") - {about, s}
                    found += [(a, name, s, d)] if d in m.axes else []
    if not found:
        raise Redraw("no axis that turns carries another")
    return found


def sag(c: Case, form: str) -> Hidden:
    """A ram, a beam or a table that bends by its weight (beam theory); size: um."""
    m = c.machine
    two = len(m.axes) == 2
    if form == "ram out, tip droops (cantilever)":
        a = "X" if two else m.tool_axes[-1]  # the last carriage is the ram
        d = "Y" if a == "Z" else c.other(a)
        c.once(rest_plans.straight, a, d)
        share = c.r.uniform(0, 0.4)

        def drooped(rec: Recording) -> Array:
            u = c.share(a, rec)
            return -((1 - share) * u**3 + share * u**4)

        field = along(d, drooped)
        return Hidden("sag", a, form, field, names_too=["bow"], params={"direction": d})
    if two:
        raise Redraw("no beam and no table that overhangs")
    a, b = ("Y", "X") if m.kind == "gantry" else ("X", "Y")
    if form == "cross beam under the head, two supports":
        c.once(rest_plans.straight, a, "Z")
        field = along("Z", lambda rec: -16 * (c.share(a, rec) * (1 - c.share(a, rec))) ** 2)
        return Hidden("sag", a, form, field, names_too=["bow"], params={"direction": "Z"})
    # the table overhangs: its tilt goes with its place, times the place on the table
    c.once(rest_plans.grid, b, a, "Z")
    field = along("Z", lambda rec: -(2 * c.share(a, rec) - 1) * (2 * c.share(b, rec) - 1))
    params = {"direction": "Z"}
    return Hidden("sag", a, form, field, axes_too=[b], names_too=["abbe"], params=params)
