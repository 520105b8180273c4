"""Cases by tier: null, adversarial, single, pair, alien; what is hidden in each, and which other
names would do for it."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

# the modules of forms write themselves down in the registry
from . import aliens, geometry, heat, instruments, motion, servo  # noqa: F401
from .adversity import NAMES, harm
from .base import Fields, Redraw, Rng, log_uniform, pick
from .case import Case
from .files import machine_files, recording_file
from .noise import draw_noise, make_noise
from .plans import NULL_PLANS, PLANS
from .registry import ALIENS, FORMS, NUISANCES, Form, Hidden
from .visible import peak, visibility

TIERS = ("null", "adversarial", "single", "pair", "alien")
LEAST = 6.0  # standard deviations by which what is hidden stands out
LEAST_ALIEN = 1.5 * LEAST
SIZES = (2.0, 16.0)  # um
OF_AIR = {"laser_air", "dead_path", "structure_drift"}  # no two of them in a pair
ALIKE = (  # tests whose forms are held against each other
    {"laser", "laser_long", "laser_temp", "probing", "laser_fine"},
    {"straight", "straight_v"},
    {"laser_multi", "multi_v"},
)


@dataclass
class Made:
    """files: machine/... and recordings/...: the text; truth: what is hidden in them, as JSON."""

    name: str
    files: dict[str, str]
    truth: dict[str, Any]


@dataclass
class Drawn:
    """shapes: of every hidden effect, the fields of every recording, um."""

    case: Case
    shapes: list[list[Fields]] = field(default_factory=list)
    truths: list[dict[str, Any]] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)


def build(r: Rng, plan: str) -> Case:
    """A machine, a test of it, and the noise of its instruments."""
    c = PLANS[plan](r)
    c.noises = [draw_noise(r, rec) for rec in c.recs]
    for noise in c.noises:
        noise["white"] = max(noise["white"], 0.02)
    return c


def hide(c: Case, form: Form, r: Rng, size: float) -> tuple[list[Fields], Hidden, float]:
    """A form with a peak of a size, um: its fields in every recording, and the factor for it."""
    c.peak = size
    hidden = form.draw(c, r)
    shapes = [{k: np.asarray(v, float) for k, v in hidden.field(rec).items()} for rec in c.recs]
    largest = peak(c.recs, shapes)
    if not np.isfinite(largest) or largest < 1e-9:
        raise Redraw
    factor = size / largest
    if factor > hidden.most or factor < hidden.least:
        raise Redraw
    return [{k: factor * v for k, v in shape.items()} for shape in shapes], hidden, factor


def _seen(c: Case, shape: list[Fields], others: list[list[Fields]], r: Rng) -> float:
    modes = [c.machine.unknown_modes(rec) for rec in c.recs if rec.sees_tables]
    tables = [
        (mode[0][0], [rec.project(moved) for rec, (_, moved) in zip(c.recs, mode, strict=True)])
        for mode in zip(*modes, strict=True)
    ]
    return visibility(c.recs, c.noises, shape, others, r, tables)


def _nuisances(c: Case, effect: str) -> list[list[Fields]]:
    if effect not in NUISANCES:
        return []
    by_rec = [NUISANCES[effect](c, rec) for rec in c.recs]
    longest = max(map(len, by_rec))
    return [[of[j] if j < len(of) else {} for of in by_rec] for j in range(longest)]


def _after(c: Case, *hidden: tuple[Hidden, float]) -> None:
    for one, factor in hidden:
        if one.after:
            for rec in c.recs:
                one.after(rec, factor)


def null(r: Rng) -> Drawn:
    """Nothing hidden; at times with physics that the user knows, and has declared."""
    c = build(r, pick(r, NULL_PLANS))
    if r.random() >= 0.25:
        return Drawn(c)
    if c.plan in ("laser", "laser_fine", "probing", "ballbar"):
        width = round(log_uniform(r, 2, 12), 2)
        c.machine.declared = [{"name": "backlash", "axis": c.axis, "size_um": width}]
        shape = [rec.project({c.axis: motion.play(rec, c.axis, width)}) for rec in c.recs]
    elif c.plan in ("ts_lin", "ts_circ"):
        tau = round(log_uniform(r, 0.05, 0.5), 3)
        moving = c.recs[0].moving
        c.machine.declared = [{"name": "servo_lag", "axis": a, "tau_ms": tau} for a in moving]
        shape = [rec.project({a: -rec.vel[a] * tau for a in moving}) for rec in c.recs]
    else:
        return Drawn(c)
    for effect in c.machine.declared:
        effect["source"] = "earlier diagnosis"
    return Drawn(c, [shape], more={"declared": c.machine.declared})


def adversarial(r: Rng) -> Drawn:
    """Nothing hidden, but readings, clocks and thermometers that go wrong."""
    while True:
        c = build(r, pick(r, NULL_PLANS))
        extra, words = harm(c, r)
        if words:
            tolerated = set[str]().union(*(NAMES[word] for word in words))
            more = {"tolerated": sorted(tolerated), "harsh": sorted(words)}
            return Drawn(c, [extra], more=more)


def single(r: Rng, effect: str) -> Drawn:
    """One effect, that can be seen."""
    for _ in range(60):
        try:
            form = pick(r, FORMS[effect])
            c = build(r, pick(r, form.plans))
            shape, hidden, factor = hide(c, form, r, log_uniform(r, *SIZES))
            z = _seen(c, shape, _nuisances(c, effect), r)
            if z < LEAST:
                raise Redraw
        except Redraw:
            continue
        _after(c, (hidden, factor))
        return Drawn(c, [shape], [_truth(c, form, shape, z)])
    raise RuntimeError(f"no visible draw of {effect}")


def pair(r: Rng) -> Drawn:
    """Two effects in one test, each to be seen beside the other."""
    for _ in range(400):
        try:
            one, plan = _form_of_any(r)
            two, _ = _form_of_any(r, plan)
            if one.effect == two.effect or {one.effect, two.effect} <= OF_AIR:
                raise Redraw
            c = build(r, plan)
            c2 = copy.copy(c)
            if plan in ("ballbar", "ts_circ", "tt_circ") and r.random() < 0.5:
                c2.axis, c2.other = c.other, c.axis
            shape, hidden, factor = hide(c, one, r, log_uniform(r, *SIZES))
            shape2, hidden2, factor2 = hide(c2, two, r, log_uniform(r, *SIZES))
            z = _seen(c, shape, [*_nuisances(c, one.effect), shape2], r)
            z2 = _seen(c, shape2, [*_nuisances(c2, two.effect), shape], r)
            if min(z, z2) < LEAST:
                raise Redraw
        except Redraw:
            continue
        _after(c, (hidden, factor), (hidden2, factor2))
        truths = [_truth(c, one, shape, z), _truth(c2, two, shape2, z2)]
        return Drawn(c, [shape, shape2], truths)
    raise RuntimeError("no visible pair")


def _form_of_any(r: Rng, plan: str | None = None) -> tuple[Form, str]:
    """A form that a plan shows, and a plan."""
    effect = pick(r, sorted(FORMS))
    fit = [f for f in FORMS[effect] if plan is None or plan in f.plans]
    if not fit:
        raise Redraw
    form = pick(r, fit)
    return form, plan or pick(r, form.plans)


def alien(r: Rng, form: Form) -> Drawn:
    """Physics without a name, that no name would do for."""
    for _ in range(100):
        try:
            c = build(r, pick(r, form.plans))
            shape, hidden, factor = hide(c, form, r, log_uniform(r, *SIZES))
            z = _seen(c, shape, [], r)
            if z < LEAST_ALIEN:
                raise Redraw
            if equivalent(c, "", shape, c.peak, np.random.default_rng(int(r.integers(1 << 31)))):
                raise Redraw
        except Redraw:
            continue
        _after(c, (hidden, factor))
        size = round(peak(c.recs, shape), 3)
        return Drawn(
            c, [shape], more={"alien": {"form": form.name, "peak_um": size, "z": round(z, 1)}}
        )
    raise RuntimeError(f"no visible alien {form.name}")


def _truth(c: Case, form: Form, shape: list[Fields], z: float) -> dict[str, Any]:
    """z: standard deviations by which it stands out."""
    effect = form.effect
    found: dict[str, Any] = {
        "effect": effect,
        "axis": form.axis(c),
        "peak_um": round(peak(c.recs, shape), 3),
        "form": form.name,
        "z": round(z, 1),
    }
    if effect in ("structure_drift", "spindle_growth"):
        found["direction"] = c.axis
    if effect == "bow":
        found["direction"] = c.other
    if effect == "sag":
        found["direction"] = "Z" if c.plan == "straight_v" else c.axis
    if effect == "outlier":
        name, rows = c.wrong_rows
        found["rows"] = {name: rows}
    return found


def equivalent(c: Case, effect: str, shape: list[Fields], size: float, r: Rng) -> list[str]:
    """Other names, effect:axis, of which three draws, free in size, take a shape up: all but 4
    standard deviations, or a seventh. A lower bound."""
    plans = {c.plan}.union(*(alike for alike in ALIKE if c.plan in alike))

    def left(others: list[list[Fields]]) -> float:
        return visibility(c.recs, c.noises, shape, others, r, [])

    whole, found = left([]), []
    for name in sorted(FORMS):
        if name in (effect, "outlier"):
            continue
        for form in FORMS[name]:
            others = _draws(c, form, r, size) if plans & set(form.plans) else []
            if others and left(others) < max(4.0, 0.15 * whole):
                found.append(f"{name}:{form.axis(c)}")
                break
    return found


def _draws(c: Case, form: Form, r: Rng, size: float) -> list[list[Fields]]:
    c, found = copy.copy(c), []
    for _ in range(3):
        # the test of a form alike may lack what the form needs
        try:
            found.append(hide(c, form, r, size)[0])
        except (Redraw, KeyError, AttributeError, TypeError, IndexError):
            continue
    return found


def make(seed: int, tier: str, number: int, alike: bool = True) -> Made:
    """A case of a tier. Effects and aliens come round in an order that the seed shuffles. alike:
    with the names that would do as well, for every truth."""
    t = TIERS.index(tier)
    r = np.random.default_rng([seed, t, number])
    drawn = _drawer(seed, tier, number)(r)
    c = drawn.case
    if alike:
        _add_alike(drawn, np.random.default_rng([seed, t, number, 5]))
    truth = {
        "tier": tier,
        "truth": drawn.truths,
        "noise": sorted({k for noise in c.noises for k in noise["kinds"]}),
        "plan": c.plan,
        "machine": c.machine.kind,
        **drawn.more,
    }
    return Made(f"{tier}_{number:03d}", _files(c, _signals(r, c, drawn.shapes), r), truth)


def _add_alike(drawn: Drawn, r: Rng) -> None:
    c = drawn.case
    for truth, shape in zip(drawn.truths, drawn.shapes if drawn.truths else [], strict=True):
        turned, of_other = copy.copy(c), c.other and truth["axis"] == c.other
        if len(drawn.truths) > 1 and of_other and truth["effect"] != "sag":
            turned.axis, turned.other = c.other, c.axis
        truth["confusable"] = equivalent(turned, truth["effect"], shape, truth["peak_um"], r)


def _drawer(seed: int, tier: str, number: int) -> Callable[[Rng], Drawn]:
    if tier == "single":
        names = sorted(FORMS)
        order = np.random.default_rng([seed, 999]).permutation(len(names))
        return partial(single, effect=names[order[number % len(names)]])
    if tier == "alien":
        order = np.random.default_rng([seed, 998]).permutation(len(ALIENS))
        return partial(alien, form=ALIENS[order[number % len(ALIENS)]])
    return {"null": null, "adversarial": adversarial, "pair": pair}[tier]


def _signals(r: Rng, c: Case, shapes: list[list[Fields]]) -> list[Fields]:
    """Tables as they are, what is hidden, noise, and the instrument's zero and centre."""
    signals = []
    for i, rec in enumerate(c.recs):
        base = rec.project(c.machine.deviation(rec)) if rec.sees_tables else {}
        signal = {}
        for channel in rec.channels:
            y = base.get(channel, np.zeros(rec.n)) + make_noise(r, rec.t, c.noises[i])
            for shape in shapes:
                y = y + shape[i].get(channel, 0.0)
            if rec.sees_tables:
                y = y + r.normal() * 4
            if rec.plane:
                y = y + sum(r.normal() * 8 * rec.unit[a] for a in rec.plane)
            signal[channel] = y
        signals.append(signal)
    return signals


def _files(c: Case, signals: list[Fields], r: Rng) -> dict[str, str]:
    files = {f"machine/{name}": text for name, text in machine_files(c.machine).items()}
    for rec, noise, signal in zip(c.recs, c.noises, signals, strict=True):
        if r.random() < 0.5:
            rec.head["u_um"] = float(f"{np.hypot(noise['white'], rec.step / 3.46):.2g}")
        files[f"recordings/{rec.name}"] = recording_file(rec, signal, r)
    return files
