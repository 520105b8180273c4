"""Errors that belong to the place of the slides, to loads and to tools.

All are seen by outside instruments and by parts.  Squareness follows ISO 230-1 (rotation vector
x travel) on top of the value in machine.toml.  Straightness and sag act across the moving axis.
A load in + pushes the tool to +.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from .base import AX, Array, Part, Rec, Rng, Shape, logu, pick
from .registry import along, form, tool_only, unit_place
from .world import World


def _scale(kind: str, family: str) -> None:
    @form("scale", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        sign = pick(r, [-1.0, 1.0])
        lo, hi = w.machine.travel[ax]

        def shape(q: Rec) -> Array:
            x = q.pos[:, ax]
            s = (x - lo) / (hi - lo)
            bend = {
                "linear": 0.0,
                "nearly_linear": 0.06 * s * (1 - s),
                "ramp_ends": -0.02 * np.exp(-s / 0.03),
            }[kind]
            return sign * ((x - lo) / 1e3 + bend * (hi - lo) / 1e3)

        return tool_only(ax, shape)


for _k, _f in (("linear", "open"), ("nearly_linear", "open"), ("ramp_ends", "held")):
    _scale(_k, _f)


def _pitch(kind: str, family: str) -> None:
    @form("pitch_shape", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        c, d, k = r.uniform(0.25, 0.75), r.uniform(0.08, 0.25), r.uniform(0.5, 2.2)
        ph, y, sign = r.uniform(0, 6.28), r.normal(size=7), pick(r, [-1.0, 1.0])
        spline = CubicSpline(np.linspace(-0.05, 1.05, 7), y)
        legs = r.normal(size=3)

        def shape(q: Rec) -> Array:
            s = unit_place(w, ax, q)
            if kind == "spline":
                return spline(s)
            if kind == "bump":
                return sign * np.exp(-0.5 * ((s - c) / d) ** 2)
            if kind == "arch":
                return sign * np.sin(np.pi * k * s + ph)
            return np.polynomial.legendre.legval(2 * s - 1, np.r_[0, 0, legs])

        return tool_only(ax, shape)


for _k, _f in (("spline", "open"), ("bump", "open"), ("arch", "open"), ("legendre", "held")):
    _pitch(_k, _f)


def _cyclic(kind: str, family: str) -> None:
    @form("cyclic", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        p, ph = w.machine.lead[ax], r.uniform(0, 6.28, 3)
        h = np.r_[1.0, r.uniform(0.1, 0.5), r.uniform(0, 0.3)]
        c, m = r.uniform(0.2, 0.8), pick(r, [-1, 1])
        drift = r.uniform(0.2, 0.6)

        def shape(q: Rec) -> Array:
            x, s = q.pos[:, ax], unit_place(w, ax, q)
            y = np.sin(2 * np.pi * x / p + ph[0])
            if kind == "harmonics":
                y = sum(a * np.sin(2 * np.pi * (i + 1) * x / p + ph[i]) for i, a in enumerate(h))
            elif kind == "modulated":
                y = y * (1 + 0.7 * m * (s - c) / 0.5)
            elif kind == "directional":
                y = np.sin(2 * np.pi * x / p + ph[0] + drift * q.sgn[:, ax])
            return y

        full = kind in ("pure", "harmonics")
        return tool_only(
            ax, shape, params=lambda a: {"period_mm": p, **({"amplitude_um": a} if full else {})}
        )


for _k, _f in (
    ("pure", "open"),
    ("harmonics", "open"),
    ("modulated", "open"),
    ("directional", "held"),
):
    _cyclic(_k, _f)


def _encoder(kind: str, family: str) -> None:
    @form("encoder_cyclic", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        p, ph = logu(r, 0.1, 4.0), r.uniform(0, 6.28)
        lissajous = r.uniform(0.1, 0.5)

        def field(q: Rec, a: float) -> Part:
            x = q.pos[:, ax]
            y = np.sin(2 * np.pi * x / p + ph)
            if kind == "lissajous":
                y = y + lissajous * np.sin(4 * np.pi * x / p)
            v = along(q, ax, a * y)
            if kind == "in_loop":  # the control follows the wrong scale
                return Part(tool=-v)
            if q.kind == "trace" and (kind == "instrument") == (q.meta["sees"] == "tool"):
                return Part(reading=v)
            if kind == "instrument" and q.laser:
                return Part(reading=v @ q.meta["sensitive"])
            return Part()

        return Shape(
            field,
            AX[ax],
            lambda a: (
                {"period_mm": p, "amplitude_um": a} if kind != "lissajous" else {"period_mm": p}
            ),
        )


for _k, _f in (
    ("own_sensor", "open"),
    ("instrument", "open"),
    ("in_loop", "open"),
    ("lissajous", "held"),
):
    _encoder(_k, _f)


def _square(kind: str, family: str) -> None:
    @form("squareness", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        m = w.machine
        pair = pick(r, [p for p in m.pairs() if AX[ax] in p])
        _name, unit, lean = m.lean(pair)
        sign = pick(r, [-1.0, 1.0])
        lo, hi = m.travel[lean]

        def field(q: Rec, a: float) -> Part:
            x = q.pos[:, lean]
            if kind == "column_flexes":
                x = x + 0.1 * (x - lo) * (hi - x) / (hi - lo)
            if kind == "varies":
                other = next(c for c in (AX.index(p) for p in pair) if c != lean)
                x = x * (0.7 + 0.6 * unit_place(w, other, q))
            own = along(q, lean, x)
            return Part(tool=np.cross(unit * sign * a, own) * 1e-3)

        return Shape(field, pair, lambda a: {"urad": sign * a} if kind == "lean" else {})


for _k, _f in (("lean", "open"), ("column_flexes", "open"), ("varies", "held")):
    _square(_k, _f)


def across(w: World, r: Rng, ax: int) -> int:
    """A direction across an axis, one that some file can see if there is one."""
    seen = set()
    for q in w.recs:
        if ax not in q.moving:
            continue
        if q.kind == "targets":
            seen |= {i for i in q.axes if abs(q.meta["sensitive"][i]) > 0.1}
        elif q.kind == "ballbar":
            seen |= set(q.meta["plane"])
        elif q.kind == "trace" and q.outside:
            seen |= set(q.axes)
    return pick(r, sorted(seen - {ax}) or [a for a in w.machine.axes if a != ax])


def _bow(kind: str, family: str) -> None:
    @form("bow", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        to, sign, c3 = across(w, r, ax), pick(r, [-1.0, 1.0]), r.uniform(-1, 1)
        c = r.uniform(0.3, 0.7)

        def shape(q: Rec) -> Array:
            s = unit_place(w, ax, q)
            y = 4 * s * (1 - s)
            if kind == "second_third":
                y = y + c3 * 10 * s * (s - 0.5) * (s - 1)
            if kind == "sine":
                y = np.sin(np.pi * s)
            if kind == "kinked_joint":
                y = np.minimum(s / c, (1 - s) / (1 - c))
            return sign * y

        return tool_only(to, shape, axis=AX[ax])


for _k, _f in (
    ("parabola", "open"),
    ("second_third", "open"),
    ("sine", "open"),
    ("kinked_joint", "held"),
):
    _bow(_k, _f)


def _abbe(kind: str, family: str) -> None:
    @form("abbe", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape | None:
        m, sign = w.machine, pick(r, [-1.0, 1.0])
        comps = [c for c in m.tables[ax] if c[1] in "ABC"]
        offset = np.zeros(3)
        offset[pick(r, list(m.axes))] = sign
        about = 1 if len(m.axes) == 2 else int(r.integers(0, 3))
        g, base = r.uniform(0.6, 1.6), r.uniform(0, 6.28)
        if kind in ("arm", "arm_with_drop") and not comps:
            return None
        from .machines import lookup

        def field(q: Rec, a: float) -> Part:
            rot = np.zeros((len(q.t), 3))
            s = unit_place(w, ax, q)
            if kind in ("arm", "arm_with_drop"):
                for c in comps:
                    rot[:, "ABC".index(c[1])] = lookup(m, ax, c, q.pos, q.sgn)
                arm = np.tile(offset, (len(q.t), 1))
                if kind == "arm_with_drop":
                    arm = arm * (1 + 0.3 * (s - 0.5))[:, None]
                return Part(tool=np.cross(rot, arm) * 1e-3 * a)
            y = np.sin(np.pi * g * s + base) if kind == "unmapped_pitch" else s * s
            rot[:, about] = y
            return Part(tool=np.cross(rot, m.arm(ax, q.pos)) * 1e-3 * a, rot=rot * a)

        return Shape(
            field,
            AX[ax],
            lambda a: {"arm_mm": sign * a} if kind == "arm" else {},
            most=400.0 if kind in ("arm", "arm_with_drop") else 300.0,
        )


for _k, _f in (
    ("arm", "open"),
    ("unmapped_pitch", "open"),
    ("unmapped_parabola", "open"),
    ("arm_with_drop", "held"),
):
    _abbe(_k, _f)


def _sag(kind: str, family: str) -> None:
    @form("sag", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        to = across(w, r, ax)

        def shape(q: Rec) -> Array:
            s, u = unit_place(w, ax, q), unit_place(w, to, q)
            y = {
                "cantilever": s * s * (3 - s) / 2,
                "simply_supported": 16 * (s * (1 - s)) ** 2,
                "column_tilt": s * u * 1.0,
                "settling_bed": s**1.5,
            }[kind]
            return -y

        return tool_only(to, shape, axis=AX[ax])


for _k, _f in (
    ("cantilever", "open"),
    ("simply_supported", "open"),
    ("column_tilt", "open"),
    ("settling_bed", "held"),
):
    _sag(_k, _f)


def _force(kind: str, family: str) -> None:
    @form("force_compliance", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        gap = r.uniform(0.1, 0.4)

        def shape(q: Rec) -> Array:
            n = w.force(q, ax)
            top = max(float(np.abs(w.load[ax]).max()), 1.0)
            y = {
                "linear": n,
                "hertz": np.sign(n) * np.abs(n / top) ** (2 / 3) * top,
                "screw_length": n * (0.4 + 1.2 * unit_place(w, ax, q)),
                "preload_lost": np.where(np.abs(n) > gap * top, n, 0.35 * n),
            }[kind]
            return y

        return tool_only(
            ax, shape, params=lambda a: {"um_per_N": a} if kind == "linear" else {}, most=2.0
        )


for _k, _f in (
    ("linear", "open"),
    ("hertz", "open"),
    ("screw_length", "open"),
    ("preload_lost", "held"),
):
    _force(_k, _f)


def _wear(kind: str, family: str) -> None:
    @form("tool_wear", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        def field(q: Rec, a: float) -> Part:
            if q.kind != "features":
                return Part()
            k = q.meta["part"] - 1.0
            k = np.where(q.meta["part"] >= q.meta["change"], k - q.meta["change"] + 1, k)
            s = (k + 0.5) / 8
            y = {
                "linear": s,
                "taylor": s**0.6,
                "three_stage": (
                    0.3 * (1 - np.exp(-s / 0.08)) + 0.4 * s + 0.6 * np.maximum(s - 0.7, 0)
                ),
                "chipping": s + 0.5 * (k >= 2),
            }[kind]
            return Part(reading=-2 * a * y * q.meta["radial"])

        return Shape(field, "")


for _k, _f in (
    ("linear", "open"),
    ("taylor", "open"),
    ("three_stage", "open"),
    ("chipping", "held"),
):
    _wear(_k, _f)


def _size(kind: str, family: str) -> None:
    @form("tool_size", kind, family)
    def f(w: World, r: Rng, ax: int) -> Shape:
        sign = pick(r, [-1.0, 1.0])
        r.integers(2**62)  # a draw that keeps the ones after it as they are

        def field(q: Rec, a: float) -> Part:
            if q.kind != "features":
                return Part()
            y = q.meta["radial"].copy()
            if kind == "runout":  # bores come out larger than pockets by the run-out
                y = y * np.where([i[1] == "bore_diameter" for i in q.meta["info"]], 1.25, 1.0)
            if kind == "regrind":
                y = y * np.where(q.meta["part"] >= q.meta["change"], 0.5, 1.0)
            return Part(reading=sign * a * y)

        return Shape(field, "", lambda a: {"diameter_um": sign * a} if kind == "plain" else {})


for _k, _f in (("plain", "open"), ("runout", "open"), ("regrind", "held")):
    _size(_k, _f)
