"""The whole question: recordings and a machine in, findings out.

In order: rows, noise, data faults, what is held out; locate without names; choose on the rest; equivalent names, what could
not have been seen; the fit on what took no part; what no name explains.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from postproc import effects
from postproc.diagnose import fit, library, likeness, locate, noise, restless, sound, structure, stuck, unrecorded
from postproc.diagnose.library import Block
from postproc.diagnose.rows import Rows, of
from postproc.diagnose.select import MATERIAL, Model, Selector
from postproc.errors import UsageError
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

ALONE, DROPPED = 2.5, 6.0  # how many times the noise: counts less, is left out
ALIKE = 0.97  # of the best score: explains as well
CURVES, MANY = ("cyclic", "pitch_shape"), 3  # a curve that takes so many names has none
CONCERNS = 0.3  # of what is left in a signal
SEED = 20131
STEP = 0.5  # of an instrument's step: its rounding is the same in every run
FAR_OFF, NO_BETTER = 2.5, 0.5  # of the noise, of what it was before: then runs held out do not bear the names out


@dataclass(frozen=True)
class Options:
    """held_out: "run=3", or "" for the last run of every recording that has three at least; draws: nulls that calibrate the
    threshold; told: called with a word on each step."""

    held_out: str = ""
    draws: int = 200
    told: Callable[[str], None] = field(default=lambda word: None)


@dataclass
class Finding:
    """One accepted effect."""

    block: Block
    value: dict[str, float]
    ci95: dict[str, tuple[float, float]]
    contribution: np.ndarray
    score: float
    delta_chi2: float
    equivalent: list[str]
    status: str = "accepted"


@dataclass
class Diagnosis:
    """All that was found. rows: every reading that was used; held (N,) bool: took no part; before, after (N,) mm; sigma (N,)
    mm; places: where the mismatch is; limits: effect:axis to mm; blind: effects that can not be seen here; faults: (file,
    line, what, mm); alike (N,): by how much sigma was inflated
    for neighbours that are alike; unknown: None or what is left."""

    machine: Machine
    recordings: list[Recording]
    rows: Rows
    held: np.ndarray
    held_name: str
    before: np.ndarray
    after: np.ndarray
    sigma: np.ndarray
    findings: list[Finding]
    places: list[locate.Place]
    limits: dict[str, float]
    blind: list[tuple[str, str, str]]
    faults: list[tuple[int, int, str, float]]
    least: float
    alike: np.ndarray
    unknown: dict | None = None
    notices: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)

    @property
    def verdict(self) -> str:
        if any(f.status == "accepted" for f in self.findings):
            return "left-out-physics"
        return "unknown" if self.unknown or self.doubts else "nothing-left-out"


def diagnose(recordings: list[Recording], machine: Machine, options: Options | None = None) -> Diagnosis:
    """Raises RecordingError or UsageError for what can not be compared."""
    options = options or Options()
    options.told("reading")
    usable = sound.checked(recordings, machine)
    rows = of(usable.recordings, machine)
    doubts = likeness.doubts(usable.recordings, rows, machine)
    rows, sigma, alike, faults = _cleaned(rows)
    held, held_name = _held(rows, options.held_out)
    u, prior = fit.nuisances(rows)
    options.told("locating")
    train = np.flatnonzero(~held)
    part = rows.pick(train)
    options.told("building the dictionary")
    every = library.blocks(rows)
    blocks = [replace(b, columns=b.columns[train]) for b in every]
    live = [k for k, b in enumerate(blocks) if (np.abs(b.columns).max(axis=0) > 1e-9).all()]
    every, blocks = [every[k] for k in live], [blocks[k] for k in live]
    if not blocks:
        raise RecordingError(
            f"no effect could show in {', '.join(r.file for r in recordings)}: no axis moves, and nothing that could drive one was recorded",
            "record at several places, from both sides; gcomp simulate --test writes such a program",
        )
    selector, model, places = _chosen(part, sigma[train], u[train], prior, blocks, options)
    creep = restless.creeping(part, _left(part, selector, model), sigma[train], alike[train])
    if creep and any(
        b.axis == creep.axis and b.name in restless.LIKE and score > creep.fall
        for b, score in zip(model.blocks, model.scores, strict=True)
    ):
        creep = None
    if creep:  # what nobody can foretell there is noise to all that can be foretold
        sigma = np.hypot(sigma, creep.rms * alike * restless.rows_of(rows, creep))
        selector, model, places = _chosen(part, sigma[train], u[train], prior, blocks, options)
    chosen = [selector.blocks.index(b) for b in model.blocks]
    # What was found on the way has columns of the rows that took part only: read them of all rows. A passage that took no
    # part swings in a phase that nobody knows.
    for b in selector.blocks[len(blocks) :]:
        columns = library.read(rows, b.module, b.axis, dict(b.shape))
        every.append(replace(b, columns=columns[:, np.abs(columns[train]).max(axis=0) > 1e-9]))
    options.told("showing")
    before, after = _residuals(rows, sigma, u, prior, held, every, chosen, model)
    findings = [_finding(rows, selector, model, k, chosen, every) for k in range(len(chosen))]
    if creep:
        findings.append(_restless(creep, len(rows)))
    diagnosis = Diagnosis(
        machine, recordings, rows, held, held_name, before, after, sigma, findings, places, _limits(selector, chosen),
        _blind(rows, every), usable.faults + faults, selector.least, alike, notices=usable.notices, doubts=doubts,
    )  # fmt: skip
    _unknown(diagnosis)
    _doubted(diagnosis)
    return diagnosis


def _chosen(rows: Rows, sigma: np.ndarray, u: np.ndarray, prior: np.ndarray, blocks: list[Block], options: Options):
    """The selector, what it chose, and where the mismatch is."""
    selector = Selector(rows, rows.residual, sigma, u, prior, blocks)
    options.told("calibrating")
    if options.draws:
        selector.calibrate(np.random.default_rng(SEED), options.draws)
    places = locate.regions(rows, sigma, u, prior)
    options.told("choosing")
    return selector, selector.run(), places


def _left(rows: Rows, selector: Selector, model: Model) -> np.ndarray:
    """(N,) mm that nuisances and the chosen leave."""
    left = rows.residual - model.explained
    return left - fit.Projector.of(model.sigma, selector.u, selector.prior).nuisance(left)


def _cleaned(rows: Rows) -> tuple[Rows, np.ndarray, np.ndarray, list[tuple[int, int, str, float]]]:
    """Rows without lone outliers, their noise and by how much it was inflated, and what was left out."""
    sigma, alike = noise.of(rows, rows.residual)
    sigma = np.maximum(sigma, np.maximum(rows.grain, stuck.step(rows.y, rows.signal) * STEP))
    lone = noise.isolated(rows, rows.residual, sigma)
    faults = [
        (int(rows.file[k]), int(rows.line[k]), "outlier", float(lone[k] * sigma[k]))
        for k in np.flatnonzero(lone >= DROPPED)
    ]
    sigma = sigma * np.where(lone > ALONE, np.maximum(1.0, lone / 2), 1.0)
    keep = lone < DROPPED
    return rows.pick(keep), sigma[keep], alike[keep], faults


def _held(rows: Rows, wanted: str) -> tuple[np.ndarray, str]:
    """(N,) which rows take no part, and what they are called."""
    held = np.zeros(len(rows), bool)
    if wanted:
        name, _, value = wanted.partition("=")
        if name != "run" or not value.lstrip("-").isdigit():
            raise UsageError(f"--holdout {wanted} is not understood", "--holdout run=3")
        held = rows.run == int(value)
        if not held.any() or held.all():
            raise UsageError(
                f"--holdout {wanted}: there is {'nothing' if not held.any() else 'no other run than'} {wanted}"
            )
        return held, f"run {int(value)}"
    for file in range(len(rows.files)):
        which = rows.file == file
        runs = np.unique(rows.run[which])
        if len(runs) >= 3 and rows.kinds[file] != "features":
            held |= which & (rows.run == runs[len(runs) // 2])  # in the middle: heat and wear lie between what is known
    return held, "the middle run of every recording that has three at least" if held.any() else ""


def _residuals(rows, sigma, u, prior, held, every, chosen, model):
    """(N,) mm before and after, set-up zeros and the like taken out as the rows that took part tell them; of rows held out
    nothing is fitted but the zero of their own set-up."""
    y = rows.residual
    explained = sum(
        (every[c].columns @ model.coefficients[model.part(k)] for k, c in enumerate(chosen)), np.zeros(len(rows))
    )
    # Set-up zeros and the map's own error once, from the fit with everything in it: what is shown before and after differs by
    # the accepted effects alone.
    train = ~held
    p = fit.Projector.of(model.sigma if chosen else sigma[train], u[train], prior)
    coefficient = p.inner @ (p.u.T @ (p.w * (y - explained)[train]))
    return y - u @ coefficient, y - explained - u @ coefficient


def _finding(rows: Rows, selector: Selector, model: Model, k: int, chosen: list[int], every: list[Block]) -> Finding:
    block, part = model.blocks[k], model.part(k)
    value = model.coefficients[part]
    covariance = model.covariance[part, part]
    named, ci = _intervals(block, value, covariance)
    rest = [c for j, c in enumerate(chosen) if j != k]
    scores = selector.scores(rest, model.sigma)
    own = float(scores[chosen[k]]) if np.isfinite(scores[chosen[k]]) else float(model.scores[k])
    best: dict[str, float] = {}
    for other, score in enumerate(scores):
        key = selector.blocks[other].key
        if key != block.key:
            best[key] = max(best.get(key, -np.inf), float(score))
    alike = sorted((key for key, s in best.items() if s >= ALIKE * own - 10 and s > 0), key=lambda key: -best[key])
    fall = own + float(selector.penalty[chosen[k]])
    contribution = every[chosen[k]].columns @ value
    alike = alike[:6] + [n for n in unrecorded.names(rows, block, contribution) if n not in alike[:6]]
    return Finding(block, named, ci, contribution, own, fall, alike)


def _restless(creep: restless.Creep, n: int) -> Finding:
    """What nobody can foretell sample by sample explains nothing of a single reading, only how they spread."""
    module, shape, value = restless.named(creep)
    block = Block(module, creep.axis, tuple(sorted(shape.items())), np.zeros((n, 1)))
    return Finding(block, value, {name: (v, v) for name, v in value.items()}, np.zeros(n), creep.fall, creep.fall, [])


def _intervals(block: Block, value: np.ndarray, covariance: np.ndarray):
    """Named parameters and their 95 % intervals, through the derivative of each by the coefficients."""
    shape = dict(block.shape)
    named = block.module.parameters(value, shape)
    step = 1e-4 * np.maximum(np.sqrt(np.diag(covariance)), 1e-9)
    slopes = {name: np.zeros(len(value)) for name in named}
    for i in range(len(value)):
        moved = value.copy()
        moved[i] += step[i]
        for name, v in block.module.parameters(moved, shape).items():
            slopes[name][i] = (v - named[name]) / step[i]
    ci = {}
    for name, v in named.items():
        sd = float(np.sqrt(max(slopes[name] @ covariance @ slopes[name], 0.0)))
        ci[name] = (v - 1.96 * sd, v + 1.96 * sd)
    return named, ci


def _limits(selector: Selector, chosen: list[int]) -> dict[str, float]:
    """effect:axis to mm: from which size on it would have been seen: where its fall reaches the threshold and twice its root."""
    p = selector.projector(chosen, selector.sigma)
    result: dict[str, float] = {}
    wanted = selector.least + 2 * np.sqrt(selector.least)
    first = selector.stack[:, [part.start for part in selector.slices]]
    powers = p.powers(first)
    for block, penalty, power, peak in zip(
        selector.blocks, selector.penalty, powers, np.abs(first).max(axis=0, initial=0.0), strict=True
    ):
        if power <= 0:
            continue
        size = np.sqrt((wanted + penalty) / power) * float(peak)
        result[block.key] = min(result.get(block.key, np.inf), max(size, MATERIAL))
    return result


def _blind(rows: Rows, every: list[Block]) -> list[tuple[str, str, str]]:
    """Effect, axis and why it can not be seen in these recordings."""
    seen = {(b.name, b.axis) for b in every}
    result = []
    for name in effects.names():
        module = effects.load(name)
        for axis in library.axes_of(rows, module):
            if name == "cyclic" and (even := _even(rows, axis)):
                result.append(
                    (name, axis, f"targets at even steps of {even:g} mm: a period that divides them can not be seen")
                )
                continue
            if (name, axis) in seen:
                continue
            if name in library.FOUND and library.visible(rows, module).any() and library.needed(rows, module, axis):
                continue  # it would have been looked for in the spectrum
            if not library.visible(rows, module).any():
                why = f"it shows only to {', '.join(module.SEES)}: no such recording"
            elif not library.needed(rows, module, axis):
                why = "its driver was not recorded, or did not change: " + ", ".join(module.NEEDS)
            else:
                why = "these places and times can not tell it from a zero"
            result.append((name, axis, why))
    return result


def _even(rows: Rows, axis: str) -> float:
    """mm: the step of targets along an axis, where they stand at even steps and nothing but targets was recorded; else 0."""
    moving = [s for s in np.unique(rows.signal) if np.ptp(rows.state.position[axis][rows.signal == s]) > 1e-3]
    steps = []
    for signal in moving:
        which = rows.signal == signal
        if rows.state.passage[which][0] >= 0:
            return 0.0
        gaps = np.diff(np.unique(np.round(rows.state.position[axis][which], 3)))
        if len(gaps) < 3 or np.ptp(gaps) > 0.02:
            return 0.0
        steps.append(float(np.median(gaps)))
    return round(min(steps), 3) if steps else 0.0


def _unknown(d: Diagnosis) -> None:
    """Structure that is left, and a curve that takes many names: those names are no answer."""
    shapes = Counter(f.block.axis for f in d.findings if f.block.name in CURVES)
    many = {axis for axis, n in shapes.items() if n >= MANY}
    left = structure.unexplained(d.rows, d.before, d.after, d.sigma, ~d.held)
    for f in d.findings:
        if f.block.name in CURVES and f.block.axis in many:
            f.status = "tentative"
        for there in left:
            which = (d.rows.signal == there.signal) & ~d.held
            if float(np.std(f.contribution[which])) > CONCERNS * there.rms:
                f.status = "tentative"
    if left:
        d.unknown = {"signal": left[0].signal, "rms": left[0].rms, "share": left[0].share}
    elif many:
        worst = max((f for f in d.findings if f.block.axis in many), key=lambda f: float(np.std(f.contribution)))
        signals = [float(np.std(worst.contribution[d.rows.signal == s])) for s in range(len(d.rows.signals))]
        signal = int(np.argmax(signals))
        d.unknown = {"signal": signal, "rms": signals[signal], "share": 1.0}


def _doubted(d: Diagnosis) -> None:
    """No name is accepted where the recordings can not be trusted, or where the runs that took no part do not bear the names out."""
    accepted = [f for f in d.findings if f.status == "accepted"]
    if accepted and d.held.any():
        before, after = (float(np.sqrt(np.mean(v[d.held] ** 2))) for v in (d.before, d.after))
        ground = float(np.sqrt(np.mean((d.sigma / d.alike)[d.held] ** 2)))
        if after > FAR_OFF * ground and after > NO_BETTER * before:
            d.doubts.append(
                f"the runs that took no part are {after * 1e3:.2f} um off with these effects and {before * 1e3:.2f} um without, where their noise is "
                f"{ground * 1e3:.2f} um: the recordings contradict each other, or something changed between them"
            )
    if d.doubts:
        for f in accepted:
            f.status = "tentative"
