"""Which experiment is made when something is suspected, and the tests that are blind to it."""

from __future__ import annotations

import numpy as np

from . import (
    apart_designs,
    distant_designs,
    fresh_designs,
    later_designs,
    sealed_designs,
    unseen_designs,
)
from .base import AX, Rec, Rng, pick
from .designs import ballbar, diagonal, features, inside, targets
from .machines import Machine, draw_machine
from .motion import trace

PLACE = ["laser", "laser", "diag", "mix", "trace_tool"]
SLOW = ["long", "long", "long", "laser"]
FAST = ["trace_scale", "trace_tool", "mix"]
PLANS: dict[str, list[str]] = {
    "scale": [*PLACE, "features"],
    "pitch_shape": PLACE,
    "cyclic": PLACE,
    "backlash": [*PLACE, "ballbar", "features"],
    "backlash_position": PLACE,
    "windup": [*PLACE, "ballbar"],
    "reversal_spike": [*FAST, "ballbar"],
    "stick_slip": FAST,
    "friction_asymmetry": FAST,
    "viscous_friction": FAST,
    "coulomb_friction": FAST,
    "servo_lag": FAST,
    "servo_mismatch": [*FAST, "ballbar", "ballbar"],
    "inertia": [*FAST, "ballbar"],
    "vibration": [*FAST, "ballbar"],
    "encoder_cyclic": [*FAST, "laser"],
    "screw_heat": SLOW,
    "structure_drift": SLOW,
    "spindle_growth": SLOW,
    "squareness": ["ballbar", "diag", "straight", "trace_tool"],
    "bow": ["straight", "straight", "diag", "trace_tool", "ballbar"],
    "abbe": ["laser", "diag", "straight"],
    "sag": ["straight", "diag", "trace_tool"],
    "force_compliance": ["laser", "trace_tool", "mix"],
    "tool_wear": ["features"],
    "tool_size": ["features"],
    "step_loss": ["laser", "mix", "trace_scale", "trace_tool"],
    "laser_air": SLOW,
    "dead_path": SLOW,
    "cosine": ["laser", "diag"],
    "delay": FAST,
    "clock_skew": ["trace_scale", "trace_tool"],
}
EFFECTS = sorted(PLANS)
OWN = {
    "later": later_designs,
    "apart": apart_designs,
    "distant": distant_designs,
}  # families with experiments of their own
# families that try what a plan is for
MADE_FOR = {"unseen": PLANS} | {family: of.PLANS for family, of in OWN.items()}


def experiment(
    r: Rng, suspect: str, family: str, masked: bool
) -> tuple[Machine, list[Rec], dict, str]:
    """Machine, files in order of time, drivers asked for, and the plan's name."""
    if family in OWN:
        return OWN[family].experiment(r, suspect, masked)
    plan = pick(r, PLANS.get(suspect, ["laser", "long", "mix", "trace_tool", "straight", "diag"]))
    held = family == "held"
    draw = {"fresh": fresh_designs.draw, "sealed": sealed_designs.draw}.get(family)
    if (held and plan == "diag") or (masked and plan in ("features", "trace_scale")):
        plan = "diag" if plan == "diag" else "laser"
    kind = None
    if plan == "features":
        kind = pick(r, ["mill", "router"])
    if family == "sealed":
        kind = sealed_designs.machine_kind(r, kind)
    if family == "unseen":
        kind = unseen_designs.machine_kind(r, kind)
    m = draw_machine(r, masked, kind, flat=plan == "features")
    drivers = {
        "load": suspect == "force_compliance" or r.random() < 0.15,
        "spindle": suspect == "spindle_growth" or r.random() < 0.2,
        "T": suspect in ("screw_heat", "structure_drift", "laser_air") and r.random() < 0.8,
        "current": plan in ("trace_scale", "trace_tool") and r.random() < 0.4,
    }
    t, recs = float(np.round(r.uniform(0, 60), 1)), []
    if family == "unseen":
        return m, unseen_designs.campaign(r, m, plan, t), drivers, plan
    for i, kind in enumerate(files(r, plan)):
        made = draw(r, m, kind, t, f"r{i + 1}") if draw else None
        recs.append(made or one(r, m, kind, t, f"r{i + 1}", held, plan))
        t = float(recs[-1].t[-1]) + pick(r, [120.0, 600.0, 1800.0, 5400.0]) * r.uniform(0.7, 1.5)
        t = float(np.round(t, 1))
    return m, recs, drivers, plan


def files(r: Rng, plan: str) -> list[str]:
    """Kinds of the 1 to 6 files of a plan."""
    n = int(r.integers(1, 4))
    if plan == "laser":
        return ["displacement"] * n + [
            pick(r, ["straightness", "angle", "displacement"]) for _ in range(int(r.integers(0, 3)))
        ]
    if plan == "straight":
        return ["straightness"] * n + [
            pick(r, ["straightness", "angle", "displacement"]) for _ in range(int(r.integers(0, 3)))
        ]
    if plan == "diag":
        return ["diagonal"] * int(r.integers(1, 4)) + ["displacement"] * int(r.integers(0, 3))
    if plan == "mix":
        return [
            "displacement",
            pick(r, ["ballbar", "trace_tool"]),
            pick(r, ["trace_scale", "trace_tool"]),
        ]
    if plan == "ballbar":
        return ["ballbar"] * int(r.integers(1, 5))
    if plan == "long":
        return ["long"] * int(r.integers(1, 4))
    return [plan] * (int(r.integers(1, 3)))


def one(r: Rng, m: Machine, kind: str, t: float, name: str, held: bool, plan: str) -> Rec:
    """One file."""
    ax = pick(r, m.axes)
    if kind == "diagonal":
        return diagonal(r, m, t, name, step=held and r.random() < 0.5)
    if kind == "ballbar":
        return ballbar(r, m, t, name, held)
    if kind.startswith("trace"):
        return trace(r, m, t, name, kind[6:], held)
    if kind == "features":
        return features(r, m, t, name)
    if kind == "long":
        force = {
            "n": int(r.integers(3, 25)),
            "runs": int(r.integers(4, 13)),
            "laser": True,
            "gap": pick(r, [300.0, 600.0, 1200.0, 2400.0]),
            "pattern": pick(r, ["iso", "iso", "uni", "pilgrim"]),
        }
        return targets(r, m, ax, t, name, "displacement", held, force)
    return targets(r, m, ax, t, name, kind, held)


def blind(r: Rng, spot: str) -> tuple[Machine, list[Rec], Rec, int, list[str], str]:
    """A test that can not show something: machine, files, follow-up, axis, suspects, text."""
    kind = "mill" if spot == "one_arm" else None
    m = draw_machine(r, kind=kind)
    ax = pick(r, m.axes)
    t0, gap = 10.0, 900.0
    if spot == "one_sense":
        plane = [0, 2] if len(m.axes) == 2 else [0, 1]
        feed = float(r.uniform(500, 3000))
        s = pick(r, [1, -1])
        a = ballbar(r, m, t0, "r1", force={"plane": plane, "feed": feed, "senses": [s]})
        b = ballbar(
            r,
            m,
            float(np.round(a.t[-1] + gap, 1)),
            "f1",
            force={"plane": plane, "feed": feed, "senses": [-s]},
        )
        pair = AX[plane[0]] + AX[plane[1]]
        return (
            m,
            [a],
            b,
            plane[0],
            [f"servo_mismatch:{pair}", f"squareness:{pair}"],
            f"circular test in the {pair} plane in one sense only",
        )
    lo, hi = m.travel[ax]
    n, force = int(r.integers(8, 26)), {"laser": True, "runs": int(r.integers(2, 5))}
    if spot == "lead_multiples":
        p = m.lead[ax]
        k = np.arange(np.ceil((lo + 5) / p), np.floor((hi - 5) / p))
        k = k[:: max(1, len(k) // n)]
        a = targets(r, m, ax, t0, "r1", force={**force, "positions": k * p, "n": len(k)})
        f = {"positions": float(k[len(k) // 2] * p) + p * np.arange(0, 2, 0.125), "n": 16}
        suspects, words = [f"cyclic:{AX[ax]}"], f"targets at multiples of the {p:g} mm lead"
    elif spot == "one_direction":
        a = targets(r, m, ax, t0, "r1", force={**force, "n": n, "pattern": "uni"})
        f = {"n": n, "pattern": "iso"}
        suspects = [f"{e}:{AX[ax]}" for e in ("backlash", "backlash_position", "windup")]
        words = "targets approached from one side only"
    else:
        side = m.order()
        ax = side[0]
        m.tool[:] = 0.0
        at = inside(m, r)
        for j in side[1:]:
            at[j] = m.measured[ax][j] = round(float(np.mean(m.travel[j])), 1)
        up = at.copy()
        for j in side[1:]:
            up[j] = round(at[j] + 0.35 * np.ptp(m.travel[j]), 1)
        a = targets(r, m, ax, t0, "r1", force={**force, "n": n, "pattern": "iso", "at": at})
        f = {"n": n, "pattern": "iso", "at": up}
        suspects, words = [f"abbe:{AX[ax]}"], "measured at one arm only, where the map was made"
    b = targets(r, m, ax, float(np.round(a.t[-1] + gap, 1)), "f1", force={**force, **f})
    return m, [a], b, ax, suspects, words
