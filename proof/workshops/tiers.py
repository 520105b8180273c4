"""Cases by tier: null, adversarial, single, pair, alien; what is hidden in each, and how far it
stands out."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import adversity, moving_plans, rest_plans, slow_plans
from .aliens import ALIENS
from .base import Array, Redraw, Rng, log_uniform, pick
from .case import Case, Hidden, stacked
from .files import machine_files, recording_file
from .forms import BUILDS, FORMS, FRAME, IN_PARTS, LONG, PARTS, RAM, SERVO
from .machines import Machine

TIERS = ("null", "adversarial", "single", "pair", "alien")
LEAST = 6.0  # standard deviations by which what is hidden stands out beside the rest
SIZES = (1.9, 17.0)  # um
COARSE_SIZES = (9.0, 210.0)  # um, where gauges have 10 um
MILLS = ["mill", "router", "gantry", "rotary-table-mill", "surface-grinder"]
RAMS = ["mill", "gantry", "rotary-table-mill", "lathe"]
# what is asked to be hidden: (effect, form), or (alien, "")
Wanted = list[tuple[str, str]]
ALIEN_OF = {build.__name__: build for build in ALIENS}


@dataclass
class Made:
    """files: machine/... and recordings/...: the text; truth: what is hidden in them, as JSON."""

    name: str
    files: dict[str, str]
    truth: dict[str, Any]


def make(seed: int, counts: dict[str, int]) -> Iterator[Made]:
    """The cases of a seed; counts: tier -> cases. A name tells nothing of the tier; forms of an
    effect come in turn. What can not be made is said, and missing."""
    order = np.random.default_rng([seed, 99])
    asked = _asked(order, counts)
    places = order.permutation(len(asked))
    used: Counter[str] = Counter()
    for place, (tier, number, effects) in zip(places, asked, strict=True):
        c = None
        for attempt in range(60):
            r = np.random.default_rng([seed, TIERS.index(tier), number, attempt])
            wanted = [
                (effect, _form(effect, used[effect] + attempt // 12 + seed)) for effect in effects
            ]
            if tier == "pair" and attempt >= 24:  # they can not be shown together
                partner = pick(r, [effect for effect in BUILDS if effect != effects[0]])
                wanted[1] = partner, pick(r, FORMS[BUILDS[partner]])
            try:
                c = build(r, tier, wanted)
                break
            except Redraw:
                continue
        if c is None:
            print("workshops: no case for", tier, effects, file=sys.stderr)
            continue
        if tier in ("single", "pair"):
            used.update(effect for effect, _ in wanted)
        yield Made(f"shop-{place + 1:04d}", files(c), truth(c, tier))


def _asked(r: Rng, counts: dict[str, int]) -> list[tuple[str, int, list[str]]]:
    """Tier, number, and names of effects, aliens or harms; all of them before one comes again."""
    names = {
        "adversarial": [harm.__name__ for harm in adversity.HARMS],
        "single": list(BUILDS),
        "pair": list(BUILDS),
        "alien": list(ALIEN_OF),
    }
    found = []
    for tier in TIERS:
        bag: list[str] = []
        for number in range(counts.get(tier, 0)):
            of: list[str] = []
            while tier != "null" and len(of) < (2 if tier == "pair" else 1):
                if not bag:
                    bag = [names[tier][k] for k in r.permutation(len(names[tier]))]
                name = bag.pop()
                if name in of:
                    bag.insert(0, name)
                else:
                    of.append(name)
            found.append((tier, number, of))
    return found


def _form(name: str, turn: int) -> str:
    if name not in BUILDS:
        return ""
    forms = FORMS[BUILDS[name]]
    return forms[turn % len(forms)]


def build(r: Rng, tier: str, wanted: Wanted) -> Case:
    """A case with its readings; Redraw where it can not be built, or what is hidden not be seen."""
    if tier in ("null", "adversarial"):
        return _null(r, wanted)
    names, forms = [name for name, _ in wanted], {form for _, form in wanted}
    c = Case(r, _machine(r, names, forms))
    for name, form in wanted:
        hidden = ALIEN_OF[name](c) if tier == "alien" else BUILDS[name](c, form)
        c.hidden.append(hidden)
    of_parts = any(rec.kind == "features" for rec in c.recs)
    if of_parts and any(not h.parts and h.effect not in SERVO for h in c.hidden):
        raise Redraw("parts do not show it")
    if r.random() < 0.3:
        more = "trace" if of_parts else pick(r, ["lin", "ballbar", "trace", "dwell"])
        add_test(c, more)
    _scaled(c)
    _declare(c, "backlash" not in names)
    c.measure()
    _rough(c)
    return c


def _null(r: Rng, wanted: Wanted) -> Case:
    of_parts = r.random() < 0.1
    c = Case(r, Machine(r, flat=of_parts))
    for _ in range(int(pick(r, [1, 1, 2, 3]))):
        add_test(c, of_parts=of_parts)
    harm = getattr(adversity, wanted[0][0]) if wanted else None
    if harm:
        need = adversity.NEEDS.get(harm, "targets")
        if not [rec for rec in c.recs if rec.kind == need]:
            add_test(c, "lin" if need == "targets" else need)
    _declare(c)
    if not c.recs:
        raise Redraw("no test")
    c.measure()
    if harm:
        c.noise.append({"harsh": harm.__name__, "text": harm(c)})
    else:
        _rough(c)
    return c


def _machine(r: Rng, names: list[str], forms: set[str]) -> Machine:
    """A machine on which the effects can be."""
    kinds = None
    if "tool_size" in names or ("sag" in names and forms != {RAM}):
        kinds = MILLS
    if forms & {RAM, FRAME}:
        kinds = RAMS
    flat = bool(PARTS & {*names}) or IN_PARTS in forms
    fine = {"laser_air", "dead_path", "encoder_cyclic"} & {*names}
    return Machine(r, bool(LONG & {*names}), flat, kinds, False if fine else None)


def add_test(c: Case, kind: str | None = None, of_parts: bool = False) -> None:
    """A test that has no effect in mind. of_parts: mostly parts are measured."""
    r, m = c.r, c.machine
    a = pick(r, m.axes)
    kinds = ["lin", "lin", "lin", "straight", "grid", "dwell", "ballbar", "ballbar", "trace"]
    kinds += ["trace", "trace", "load", "spindle", "diag", "stagger", "fine"]
    kinds += ["features"] * 30 if of_parts else []
    kind = kind or pick(r, kinds)
    plans: dict[str, Callable[[], object]] = {
        "lin": lambda: rest_plans.linear(c, a),
        "straight": lambda: rest_plans.straight(c, a, c.other(a)),
        "grid": lambda: rest_plans.grid(c, a, c.other(a), pick(r, m.axes)),
        "dwell": lambda: slow_plans.dwell(c, a),
        "ballbar": lambda: moving_plans.ballbar(c, *c.plane()),
        "trace": lambda: moving_plans.trace(c, sees=pick(r, ["scale", "scale", "scale", "tool"])),
        "load": lambda: slow_plans.load(c, a),
        "spindle": lambda: c.speeds or slow_plans.spindle(c, "Z"),
        "diag": lambda: rest_plans.diagonals(c, *c.plane()),
        "stagger": lambda: rest_plans.stairs(c, a),
        "fine": lambda: rest_plans.fine(c, a, m.lead[a]),
        "features": lambda: moving_plans.features(c),
    }
    plans[kind]()


def _scaled(c: Case) -> None:
    """Gives what is hidden its size, and how far it stands out of noise beside the others."""
    least, most = COARSE_SIZES if c.machine.coarse else SIZES
    shapes = []
    for hidden in c.hidden:
        shapes.append(_fitted(c, hidden, _size(c)))
        if not least <= hidden.peak <= most:
            raise Redraw("physics makes it too small or too large")
    for k, (hidden, shape) in enumerate(zip(c.hidden, shapes, strict=True)):
        rest = shape.copy()
        for other in shapes[:k] + shapes[k + 1 :]:
            rest = rest - other * (other @ rest) / (other @ other + 1e-12)
        hidden.stands_out = float(np.sqrt(rest @ rest))
        if hidden.stands_out < LEAST:
            raise Redraw("not to be seen")


def _size(c: Case) -> float:
    """um."""
    if not c.machine.coarse:
        return log_uniform(c.r, 2, 16)
    return log_uniform(c.r, 20, 200) if c.r.random() < 0.5 else log_uniform(c.r, 12, 90)


def _fitted(c: Case, hidden: Hidden, peak: float) -> Array:
    """Scales so that the largest change of a reading is `peak`, um; what `stacked` gives."""
    for _ in range(0 if hidden.natural else hidden.rounds):
        _, largest = stacked(c, hidden)
        if largest <= 0 or not np.isfinite(largest):
            raise Redraw("no reading shows it")
        hidden.size *= peak / largest
    if hidden.most and abs(hidden.size) > hidden.most:
        raise Redraw("more than physics allows")
    shape, hidden.peak = stacked(c, hidden)
    if hidden.believable and not hidden.believable():
        raise Redraw("not believable")
    return shape


def _declare(c: Case, may: bool = True) -> None:
    """In a tenth of the cases the file knows of lost motion, where the tables have none."""
    r, m = c.r, c.machine
    if r.random() < 0.1 and may:
        a = pick(r, m.axes)
        if not m.flat and f"E{a}{a}_um" in m.known[a]:
            m.declared.append({"axis": a, "size_um": round(float(m.U * r.uniform(5, 20)), 1)})


def _rough(c: Case) -> None:
    """In some cases the noise is larger for a while."""
    if c.r.random() < 0.08 and any(rec.kind == "targets" for rec in c.recs):
        c.noise.append({"harsh": "traffic", "text": adversity.traffic(c)})


def files(c: Case) -> dict[str, str]:
    """machine/... and recordings/...: the text."""
    found = {f"machine/{name}": text for name, text in machine_files(c.machine).items()}
    return found | {f"recordings/{rec.name}": recording_file(rec) for rec in c.recs}


def truth(c: Case, tier: str) -> dict[str, Any]:
    """What is hidden in a case, its noise and its tests, as JSON."""
    m = c.machine
    found = {
        "tier": tier,
        "truth": [
            {
                "effect": hidden.effect,
                "axis": str(hidden.axis),
                "peak_um": round(hidden.peak, 3),
                "form": hidden.form,
                "snr": round(hidden.stands_out, 1),
                "parameter": float(hidden.size),
                "axis_also": hidden.axes_too,
                "effect_also": hidden.names_too,
                "params": {
                    k: round(v, 6) if isinstance(v, float) else v for k, v in hidden.params.items()
                },
            }
            for hidden in c.hidden
        ],
        "noise": c.noise,
        "plan": c.plan,
        "machine": {
            "kind": m.kind,
            "coarse": m.coarse,
            "travel": m.travel,
            "known": m.declared,
        },
    }
    return json.loads(json.dumps(found, default=lambda value: value.item()))
