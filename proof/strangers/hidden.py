"""What is hidden in a case: effects drawn by form and size, whether the oracle sees them, and what
the truth says of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .base import AX, Array, Rec, Rng, Shape, logu, observe, pick, stream
from .oracle import Oracle, alone
from .registry import ALONE, NUMBERED, allowed
from .world import World

SEEN = 40.0  # energy from which the oracle calls an effect visible
ALIKE = [
    ("backlash", "windup"),
    ("scale", "screw_heat"),
    ("structure_drift", "spindle_growth"),
    ("bow", "squareness"),
    ("servo_mismatch", "squareness"),
    ("servo_lag", "delay"),
    ("pitch_shape", "cyclic"),
    ("cosine", "scale"),
    ("laser_air", "screw_heat"),
    ("dead_path", "structure_drift"),
    ("backlash", "backlash_position"),
    ("coulomb_friction", "backlash"),
    ("viscous_friction", "servo_lag"),
    ("sag", "bow"),
    ("abbe", "pitch_shape"),
    ("tool_size", "tool_wear"),
    ("step_loss", "structure_drift"),
    ("cyclic", "encoder_cyclic"),
    ("inertia", "vibration"),
    ("tool_size", "scale"),
    ("reversal_spike", "backlash"),
    ("friction_asymmetry", "coulomb_friction"),
    ("laser_air", "scale"),
    ("abbe", "scale"),
    ("clock_skew", "delay"),
    ("servo_lag", "servo_mismatch"),
    ("stick_slip", "vibration"),
]


@dataclass
class Hidden:
    """One effect as drawn: its shape and amplitude and what it does to each file."""

    effect: str
    form: str
    family: str
    shape: Shape
    amp: float
    mu: list[Array]
    peak: float


def effect_of(shape: Shape, recs: list[Rec], amp: float) -> list[Array]:
    """Readings (channels x n) of every file."""
    return [np.nan_to_num(observe(q, shape.field(q, amp))) for q in recs]


def peak_of(mu: list[Array], recs: list[Rec]) -> float:
    """Largest reading after taking out each channel's mean (parts on a CMM: as they are)."""
    top = 0.0
    for x, q in zip(mu, recs, strict=False):
        if q.kind == "targets" and q.meta["quantity"] == "angle":
            continue
        y = x if q.kind == "features" else x - x.mean(1, keepdims=True)
        top = max(top, float(np.abs(y).max()))
    return top


def draw_effect(
    r: Rng,
    w: World,
    recs: list[Rec],
    effect: str,
    target: float,
    axis: int | None = None,
    kinds: set[str] | None = None,
) -> Hidden | None:
    """A form of an effect scaled to a peak (um); None where it can not reach 60 % of it.

    `kinds` names the forms to draw from, open ones whatever the family."""
    forms = allowed(effect, w.family)
    if kinds:
        simple = [*allowed(effect, "open"), *forms]
        forms = [f for f in dict.fromkeys(simple) if f[0] in kinds] or forms
    own = [f for f in forms if f[1] != "open"]
    # two of three: what an effect usually is stays in
    if own and w.family in NUMBERED and len(own) < len(forms):
        own = pick(r, [own, own, [f for f in forms if f not in own]])
    name, family, fn = pick(r, own or forms)
    live = sorted({a for q in recs for a in q.moving}) or w.machine.axes
    shape = fn(w, r, axis if axis is not None else pick(r, live))
    if shape is None:
        return None
    amp = shape.start
    for _ in range(1 if shape.linear else 4):
        p = peak_of(effect_of(shape, recs, amp), recs)
        if p < 1e-6:
            return None
        amp = min(amp * target / p, shape.most)
    mu = effect_of(shape, recs, amp)
    p = peak_of(mu, recs)
    return Hidden(effect, name, family, shape, amp, mu, p) if p > 0.6 * target else None


def alternatives(w: World, recs: list[Rec], h: Hidden, key: str) -> list[Hidden]:
    """Simple shapes of look-alike effects, to see whether one of them explains `h` as well."""
    names = [b if a == h.effect else a for a, b in ALIKE if h.effect in (a, b)]
    out = []
    for e in dict.fromkeys(names):
        ax = AX.index(h.shape.axis[0]) if h.shape.axis else None
        tries = [ax] if ax is not None else w.machine.axes
        for k in tries:
            x = draw_effect(
                stream(key, e, k),
                w,
                recs,
                e,
                max(h.peak, 1.0),
                k,
                {
                    "linear",
                    "sign",
                    "tanh",
                    "dahl",
                    "lumped",
                    "frame",
                    "lean",
                    "pure",
                    "parabola",
                    "direct",
                    "taylor",
                    "fixture",
                    "temperature",
                    "plain",
                    "one",
                    "cantilever",
                    "rigid",
                    "one_constant",
                    "own_sensor",
                },
            )
            if x:
                out.append(x)
    return out


def state(h: Hidden, energy: float, apart: float, twins: list[str]) -> dict[str, Any]:
    """One entry of the truth."""
    out = {
        "effect": h.effect,
        "axis": h.shape.axis,
        "parameters": {k: float(f"{v:.6g}") for k, v in h.shape.params(h.amp).items()},
        "peak_um": round(h.peak, 4),
        "visible": bool(apart >= SEEN),
        "energy": float(f"{energy:.5g}"),
        "apart": float(f"{apart:.5g}"),
        "form": h.form,
    }
    if twins:
        out["twins"] = twins
    return out


def hide(
    r: Rng, w: World, recs: list[Rec], oracle: Oracle, plans: list[list[str]], tier: str
) -> list[Hidden]:
    """Effects for a tier; each try must be seen by the oracle, the last one is kept anyway."""
    found: list[Hidden] = []
    lo, hi = (2.0, 8.0) if tier == "masked" else (2.0, 16.0)
    for names in plans:
        last, checks = None, 0
        lax = tier in ("pair", "triple") and r.random() < 0.1
        for i, e in enumerate(names * 2):
            if i == len(names):  # nothing reached its size: once more, small
                if last:
                    break
                hi = lo * 1.2
            if not allowed(e, w.family):
                continue
            h = draw_effect(r, w, recs, e, logu(r, lo, hi))
            if h is None or any(
                (h.effect, h.shape.axis) == (x.effect, x.shape.axis) for x in found
            ):
                continue
            last, checks = h, checks + 1
            gram = oracle.gram([x.mu for x in [*found, h]])
            if lax or alone(gram, len(found)) >= SEEN or checks >= 7:
                break
        if last:
            found.append(last)
    return found


def hide_blind(r: Rng, w: World, recs: list[Rec], suspects: list[str], ax: int) -> list[Hidden]:
    """One of the suspects, or nothing in three of ten cases; sized by the follow-up."""
    if r.random() < 0.3:
        return []
    for _ in range(12):
        name = pick(r, [s for s in suspects if "position" not in s]).split(":")[0]
        kinds = {
            "abbe": {"unmapped_pitch", "unmapped_parabola"},
            "cyclic": {"pure", "harmonics"},
        }.get(name)
        kinds = None if w.family in ALONE else kinds
        h = draw_effect(r, w, recs, name, logu(r, 3, 16), ax, kinds)
        # numbered families: but for circles in one sense, which show two suspects alike, the test
        # sees nothing
        seen = (
            w.family in NUMBERED
            and len(suspects) != 2
            and h is not None
            and peak_of(h.mu[:1], recs[:1]) > 0.2
        )
        if h and not seen and f"{h.effect}:{h.shape.axis}" in suspects:
            return [h]
    return []


def tell(w: World, recs: list[Rec], oracle: Oracle, found: list[Hidden], key: str) -> list[dict]:
    """Truth entries with energies; twins are look-alikes that leave less than 12 of the energy."""
    gram = oracle.gram([h.mu for h in found])
    out = []
    for i, h in enumerate(found):
        apart, twins = alone(gram, i), []
        if apart >= SEEN:
            other = alternatives(w, recs, h, key)
            if other:
                rest = [x.mu for j, x in enumerate(found) if j != i]
                g = oracle.gram([h.mu] + rest + [x.mu for x in other])
                n = 1 + len(rest)
                for j, x in enumerate(other):
                    keep = [*range(n), n + j]
                    if alone(g[np.ix_(keep, keep)], 0) < 12:
                        twins.append(f"{x.effect}:{x.shape.axis}".rstrip(":"))
        out.append(state(h, max(float(gram[i, i]), 0.0), apart, sorted(set(twins))))
    return out
