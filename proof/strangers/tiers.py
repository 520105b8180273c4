"""Draws a case: machine and experiment from one stream, what is hidden from another."""

from __future__ import annotations

import numpy as np

from . import (  # noqa: F401
    aliens,
    apart_aliens,
    apart_motion,
    apart_noise,
    apart_place,
    apart_servo,
    apart_time,
    distant_aliens,
    distant_motion,
    distant_noise,
    distant_place,
    distant_servo,
    distant_time,
    forms_motion,
    forms_place,
    forms_servo,
    forms_time,
    fresh_aliens,
    fresh_motion,
    fresh_noise,
    fresh_place,
    fresh_servo,
    fresh_time,
    later_aliens,
    later_motion,
    later_noise,
    later_place,
    later_servo,
    later_time,
    sealed_aliens,
    sealed_motion,
    sealed_noise,
    sealed_place,
    sealed_servo,
    sealed_time,
    unseen_aliens,
    unseen_motion,
    unseen_noise,
    unseen_place,
    unseen_servo,
    unseen_time,
)
from .base import AX, Case, Part, Rec, Rng, digest, observe, pick, stream
from .hidden import ALIKE, Hidden, hide, hide_blind, peak_of, tell
from .machines import draw_map_error, map_error, stated
from .noise import LATER, Noise, draw_noise
from .oracle import Oracle
from .plans import EFFECTS, MADE_FOR, OWN, blind, experiment
from .registry import FAMILIES, FORMS
from .world import World, draw_world
from .write import machine_files, recording

TIERS = ["null", "adversarial", "single", "pair", "triple", "masked", "withheld", "alien", "blind"]
HIDDEN = {
    "screw_heat": {"T"},
    "structure_drift": {"T"},
    "laser_air": {"T"},
    "dead_path": {"T"},
    "spindle_growth": {"rpm", "T"},
    "force_compliance": {"load"},
}
MASKED = [
    "scale",
    "pitch_shape",
    "backlash",
    "backlash_position",
    "windup",
    "cyclic",
    "squareness",
    "bow",
    "abbe",
    "sag",
    "screw_heat",
    "structure_drift",
    "force_compliance",
    "step_loss",
    "servo_mismatch",
]


def plan_names(r: Rng, tier: str, suspect: str, family: str, plan: str) -> list[list[str]]:
    """For each hidden effect the names to try in turn; families of MADE_FOR try none that the
    experiment is not made for."""
    fits = [e for e in EFFECTS if family not in MADE_FOR or plan in MADE_FOR[family][e]]

    def tries(first: str | None, pool: list[str], n: int) -> list[str]:
        names = [first] * 4 if first and r.random() < 0.6 else []
        return names + [pick(r, pool) for _ in range(n)] + [str(x) for x in r.permutation(pool)]

    if tier in ("null", "adversarial"):
        return []
    if tier == "single":
        return [tries(suspect, fits, 14)]
    if tier == "masked":
        return [tries(suspect, [e for e in MASKED if e in fits], 14)]
    if tier == "withheld":
        return [[suspect] * 8 + [str(x) for x in r.permutation(sorted(HIDDEN) * 3)]]
    if tier == "alien":
        names = [n for n in FORMS if n.startswith("alien:")]
        of = {f: [n for n in names if FORMS[n][0][1] == f] for f in FAMILIES}
        pools = [of[family]] + ([of["held"], of["open"]] if family == "held" else [])
        return [[pick(r, pick(r, pools)) for _ in range(25)]]
    count = 2 if tier == "pair" else 3
    if r.random() < 0.5:
        mates = [b if a == suspect else a for a, b in ALIKE if suspect in (a, b)]
        mates = [e for e in mates if e in fits] or fits
        out = [
            [suspect] * 6 + tries(None, fits, 4),
            [pick(r, mates) for _ in range(12)] + tries(None, fits, 4),
        ]
    else:
        out = [tries(suspect, fits, 10), tries(None, fits, 20)]
    return out + [tries(None, fits, 20) for _ in range(count - 2)]


def make(seed: str, tier: str, number: int, family: str = "open") -> Case:
    """Draws case `number` of a tier; deterministic in all arguments."""
    if tier not in TIERS or family not in FAMILIES:
        raise ValueError(f"unknown tier or family: {tier} {family}")
    key = digest(seed, tier, number, family)
    rx, rn, rh, rt = (stream(key, k) for k in ("experiment", "noise", "hidden", "text"))
    later = family != "open"
    # circles and long tests show most of that family's aliens
    more = ["squareness"] * 4 + ["screw_heat"] * 3 if family == "unseen" else []
    strange = OWN[family].ALIENS if family in OWN else MASKED[:13] + more
    pools = {"masked": MASKED, "withheld": sorted(HIDDEN), "alien": strange}
    suspect = pick(rx, pools.get(tier, EFFECTS))
    spot, follow, info = "", [], {}
    if tier == "blind":
        spot = pick(rx, ["lead_multiples", "one_direction", "one_arm", "one_sense"])
        m, recs, extra, ax, suspects, words = blind(rx, spot)
        follow, drivers, plan = [extra], {}, "blind"
        info = {"spot": spot, "suspects": suspects, "test": words}
    else:
        m, recs, drivers, plan = experiment(rx, suspect, family, tier == "masked")
    harsh = tier == "adversarial"
    w = draw_world(rx, m, recs + follow, family, drivers)
    factor = rn.uniform(2, 3) if harsh and rn.random() < 0.5 else 1.0
    draw_map_error(m, rn, factor)
    for q in recs + follow:
        q.meta["zero_by_run"] = bool(harsh and q.kind == "targets" and rn.random() < 0.15)
    noises = [
        draw_noise(rn, q, w, later and (i == 0 or rn.random() < 0.5), harsh)
        for i, q in enumerate(recs + follow)
    ]
    oracle = Oracle(m, recs, noises[: len(recs)], factor)
    if tier == "blind":
        found = hide_blind(rh, w, recs + follow, suspects, ax)
    else:
        found = hide(rh, w, recs, oracle, plan_names(rh, tier, suspect, family, plan), tier)
    truth = tell(w, recs, oracle, found, key) if found else []
    if follow:
        after = Oracle(m, follow, noises[len(recs) :], factor)
        part = [
            Hidden(
                h.effect,
                h.form,
                h.family,
                h.shape,
                h.amp,
                h.mu[len(recs) :],
                peak_of(h.mu[len(recs) :], follow),
            )
            for h in found
        ]
        info["follow_up"] = tell(w, follow, after, part, key) if part else []
    hidden = (
        set().union(*(HIDDEN.get(h.effect, set()) for h in found)) if tier == "withheld" else set()
    )
    if tier == "withheld":
        hidden |= HIDDEN[suspect]
    if family in OWN:
        hidden |= OWN[family].absent(rt, m, suspect)
    files, notes = machine_files(m), {}
    out_follow: dict[str, str] = {}
    for i, q in enumerate(recs + follow):
        body, notes[q.name] = put(w, q, i, noises[i], found, rt, rn, hidden, drivers)
        (files if i < len(recs) else out_follow)[q.name + ".csv"] = body
    details = {
        "seed": seed,
        "tier": tier,
        "number": number,
        "family": family,
        "machine": m.kind,
        "chain": m.chain,
        "plan": plan,
        "noise": notes,
        "map_u_um": round(m.u, 3),
        "map_factor": round(factor, 2),
        "hidden": sorted(hidden),
        "files": {
            q.name: (
                q.kind + (":" + str(q.meta.get("sees") or q.meta.get("quantity") or "")).rstrip(":")
            )
            for q in recs + follow
        },
        "targets": int(sum(len(np.unique(q.pos, axis=0)) for q in recs if q.kind == "targets")),
        "rows": int(sum(q.n_obs - missing(n[0]) for q, n in zip(recs, noises, strict=False))),
        "held": sorted(
            {h.form for h in found if h.family != "open"}
            | {
                s["kind"]
                for x in noises
                for n in x
                for s in n.spec
                if s["kind"] in LATER.get(family, {}).get("all", [])
            }
        ),
    }
    if info:
        details["blind"] = info
    return Case("s" + key[:8], files, truth, details, out_follow)


def missing(n: Noise) -> int:
    """Rows that a file lacks."""
    return 0 if n.gone is None else int(n.gone.sum())


def put(
    w: World,
    q: Rec,
    i: int,
    noise: list,
    found: list[Hidden],
    rt: Rng,
    rn: Rng,
    hidden: set[str],
    drivers: dict,
) -> tuple[str, dict]:
    """Text of one file: tables + map error + effects + noise + zero, rounded as it is read."""
    tool, rot = stated(w.machine, q.pos, q.sgn)
    more, rot2 = map_error(w.machine, q.pos)
    y = observe(q, Part(tool=tool + more, rot=rot + rot2))
    for h in found:
        y = y + h.mu[i]
    wide = rn.random() < 0.25
    for c, n in enumerate(noise):
        y[c] = y[c] + n.values
        if q.kind == "ballbar":
            shift = rn.normal(0, 8, 3)
            y[c] += q.meta["unit"][:, q.meta["plane"]] @ shift[:2] + shift[2]
        elif q.kind == "targets" and q.meta["zero_by_run"]:
            y[c] += rn.normal(0, 200, int(q.run.max()) + 1)[q.run]
        elif q.kind != "features":
            y[c] += rn.normal(0, 300 if wide else 2)
        if n.quant:
            y[c] = np.round(y[c] / n.quant) * n.quant
    current = {}
    if q.kind == "trace" and drivers.get("current"):
        for a in q.axes:
            c = rn.normal(0, 0.05, len(q.t))
            for h in found:
                if hasattr(h.shape, "current") and AX[a] == h.shape.axis:
                    c = c - h.shape.current(q, h.amp)
            current[a] = c
    u = float(np.hypot(noise[0].spec[0]["sd_um"], noise[0].quant / 12**0.5))
    u = u if rn.random() < 0.5 else None
    kinds = (
        noise[0].spec
        + ([{"kind": "wide_zero"}] if wide else [])
        + ([{"kind": "zero_by_run"}] if q.meta["zero_by_run"] else [])
    )
    body, thermo = recording(q, w, y, u, rt, hidden, current, noise[0].gone)
    return body, {"signal": kinds, "thermometers": thermo}
