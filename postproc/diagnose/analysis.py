"""The whole question: recordings and a machine in, findings out.

In order: rows, noise, data faults, what is held out; locate without names; choose on the rest; equivalent names, what could
not have been seen; the fit on what took no part; what no name explains.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from postproc import effects
from postproc.diagnose import drive, fit, held_out, library, locate, noise, shared_jump
from postproc.diagnose.library import Block
from postproc.diagnose.rows import Rows, of
from postproc.diagnose.select import MATERIAL, Model, Selector
from postproc.machine.model import Machine
from postproc.recordings import Recording

ALONE, DROPPED = 2.5, 6.0  # how many times the noise: counts less, is left out
ALIKE = 0.97  # of the best score: explains as well
CYCLE_MS = 5.0  # ms: a control's position cycle is shorter
NEEDLESS = 0.5  # of its score: what remains of it beside another name for the same
UNEXPLAINED = 1.3
TENTATIVE = 0.5
SEED = 20131


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
    text: str = ""  # where the effect's own sentence would say too little
    next_test: str = ""


@dataclass
class Diagnosis:
    """All that was found. rows: every reading that was used; held (N,) bool: took no part; before, after (N,) mm; sigma (N,)
    mm; places: where the mismatch is; limits: effect:axis to mm; blind: effects that can not be seen here; faults: (file,
    line, what, mm); alike (N,): by how much sigma was inflated
    for neighbours that are alike; unknown: None or what is left; drives: what forces and currents ask for."""

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
    drives: list[drive.Drive] = field(default_factory=list)

    @property
    def verdict(self) -> str:
        if any(f.status == "accepted" for f in self.findings) or any(felt(self)):
            return "left-out-physics"
        return "unknown" if self.unknown else "nothing-left-out"


def diagnose(recordings: list[Recording], machine: Machine, options: Options | None = None) -> Diagnosis:
    """Raises RecordingError or UsageError for what can not be compared."""
    options = options or Options()
    options.told("reading")
    rows = of(recordings, machine)
    rows, sigma, alike, faults = _cleaned(rows)
    held, held_name = held_out.of(rows, options.held_out, recordings)
    u, prior = fit.nuisances(rows)
    options.told("locating")
    train = np.flatnonzero(~held)
    part = rows.pick(train)
    # Where several readings leave their lines together, each target has a value of its own: no smooth shape is asked to bend so.
    jumps = shared_jump.find(part, part.residual, sigma[train])
    smooth = u.shape[1]
    for jump in jumps:
        own = shared_jump.columns(jump, rows)
        u, prior = np.concatenate([u, own], axis=1), np.concatenate([prior, np.full(own.shape[1], fit.FREE)])
    options.told("building the dictionary")
    every = library.blocks(rows)
    blocks = [replace(b, columns=b.columns[train]) for b in every]
    live = [k for k, b in enumerate(blocks) if (np.abs(b.columns).max(axis=0) > 1e-9).all()]
    every, blocks = [every[k] for k in live], [blocks[k] for k in live]
    selector = Selector(part, part.residual, sigma[train], u[train], prior, blocks)
    options.told("calibrating")
    if options.draws and blocks:
        selector.calibrate(np.random.default_rng(SEED), options.draws)
    places = locate.regions(part, sigma[train], u[train], prior)
    options.told("choosing")
    model, late = _of_each_axis(selector, selector.run(), part)
    chosen = [selector.blocks.index(b) for b in model.blocks]
    # What was found on the way has columns of the rows that took part only: read them of all rows. A passage that took no
    # part swings in a phase that nobody knows.
    for b in selector.blocks[len(blocks) :]:
        columns = library.read(rows, b.module, b.axis, dict(b.shape))
        every.append(replace(b, columns=columns[:, np.abs(columns[train]).max(axis=0) > 1e-9]))
    options.told("showing")
    before, after, coefficient = _residuals(rows, sigma, u, prior, held, every, chosen, model)
    findings = [_finding(selector, model, k, chosen, every) for k in range(len(chosen))]
    for f in findings:
        if late and f.block.name == "servo_lag" and "delay:" not in f.equivalent:
            f.equivalent.insert(0, "delay:")
    for jump in jumps:
        columns = shared_jump.columns(jump, rows)
        value = coefficient[smooth : smooth + columns.shape[1]]
        smooth += columns.shape[1]
        before = before + columns @ value
        findings.insert(0, _jump(jump, rows, columns, value, sigma, held, machine))
        places = [*shared_jump.places(jump, rows, columns @ value), *places]
    diagnosis = Diagnosis(
        machine, recordings, rows, held, held_name, before, after, sigma, findings, places, _limits(selector, chosen),
        _blind(rows, every), faults, selector.least, alike,
    )  # fmt: skip
    _unknown(diagnosis)
    options.told("forces and currents")
    diagnosis.drives = drive.drives(recordings)
    return diagnosis


def felt(d: Diagnosis) -> Iterator[tuple[drive.Drive, drive.Fitted]]:
    """What forces and currents show of the effects that the contract knows, where the positions do not say it already."""
    said = {f.block.key for f in d.findings if f.status == "accepted"}
    for one in d.drives:
        for term in one.fitted:
            if term.term.name in drive.NAMES and f"{term.term.name}:{one.axis}" not in said:
                yield one, term


def _of_each_axis(selector: Selector, model: Model, rows: Rows) -> tuple[Model, bool]:
    """The model, with a lag of every axis that shows one in the place of a delay that no control's own log has: command and
    scale are read in one cycle. Loops that interpolate are set alike, so equal lags are no sign of a late recording. And
    whether that was done."""
    late = [k for k, b in enumerate(model.blocks) if b.name == "delay"]
    seen = library.visible(rows, model.blocks[late[0]].module) if late else np.zeros(0, bool)
    if not late or abs(model.coefficients[model.part(late[0])][0]) < CYCLE_MS or np.any(rows.sees[seen] != "scale"):
        return model, False
    rest = [selector.blocks.index(b) for k, b in enumerate(model.blocks) if k not in late and b.name != "servo_lag"]
    lags = [k for k, b in enumerate(selector.blocks) if b.name == "servo_lag"]
    own = [k for k in lags if selector.worth([*rest, *(j for j in lags if j != k)], k, model.sigma) >= selector.least]
    return (selector.fitted([*rest, *own]), True) if own else (model, False)


def _cleaned(rows: Rows) -> tuple[Rows, np.ndarray, np.ndarray, list[tuple[int, int, str, float]]]:
    """Rows without lone outliers, their noise and by how much it was inflated, and what was left out."""
    sigma, alike = noise.of(rows, rows.residual)
    lone, off = noise.isolated(rows, rows.residual, sigma)
    faults = [(int(rows.file[k]), int(rows.line[k]), "outlier", float(off[k])) for k in np.flatnonzero(lone >= DROPPED)]
    sigma = sigma * np.where(lone > ALONE, np.maximum(1.0, lone / 2), 1.0)
    keep = lone < DROPPED
    return rows.pick(keep), sigma[keep], alike[keep], faults


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
    return y - u @ coefficient, y - explained - u @ coefficient, coefficient


def _jump(jump, rows: Rows, columns: np.ndarray, value: np.ndarray, sigma, held, machine: Machine) -> Finding:
    """A jump that several readings share, as a finding: certain itself, its cause one of a set."""
    named = jump.parameters()
    error = 1.96 * jump.ratio_error
    ci = {name: (v - error, v + error) if name == "ratio" else (v, v) for name, v in named.items()}
    contribution = columns @ value
    fall = float(np.sum((contribution[~held] / sigma[~held]) ** 2))
    score = fall - columns.shape[1] * float(np.log((~held).sum()))
    first, second = (Path(rows.files[rows.file[rows.signal == p.signal][0]]).name for p in (jump.first, jump.second))
    return Finding(
        Block(shared_jump, jump.axis, (), columns), named, ci, contribution, score, fall, shared_jump.causes(jump),
        text=shared_jump.words(jump, (first, second)), next_test=shared_jump.next_test(jump, machine.name),
    )  # fmt: skip


def _finding(selector: Selector, model: Model, k: int, chosen: list[int], every: list[Block]) -> Finding:
    block, part = model.blocks[k], model.part(k)
    value = model.coefficients[part]
    covariance = model.covariance[part, part]
    named, ci = _intervals(block, value, covariance)
    rest = [c for j, c in enumerate(chosen) if j != k]
    scores = selector.scores(rest, model.sigma)
    own = float(scores[chosen[k]]) if np.isfinite(scores[chosen[k]]) else float(model.scores[k])
    best: dict[str, tuple[float, int]] = {}
    for other, score in enumerate(scores):
        key = selector.blocks[other].key
        if key != block.key:
            best[key] = max(best.get(key, (-np.inf, -1)), (float(score), other))
    alike = sorted(
        (key for key, (s, _) in best.items() if s >= ALIKE * own - 10 and s > 0), key=lambda key: -best[key][0]
    )
    # What explains something else besides is no other name for this: with it this must lose most of what it is worth.
    alike = [key for key in alike if selector.worth([*rest, best[key][1]], chosen[k], model.sigma) < NEEDLESS * own]
    fall = own + float(selector.penalty[chosen[k]])
    return Finding(block, named, ci, every[chosen[k]].columns @ value, own, fall, alike[:6])


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
    for block, penalty in zip(selector.blocks, selector.penalty, strict=True):
        column = block.columns[:, 0]
        power = float(column @ p(column))
        if power <= 0:
            continue
        size = np.sqrt((wanted + penalty) / power) * float(np.abs(column).max())
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


def _left_of_feature(d: Diagnosis, which: np.ndarray) -> float:
    """mm: what several readings of one feature have in common, over the parts, less three times what chance gives; 0 where it
    was read once a part."""
    products, chance = [], 0.0
    for part in np.unique(d.rows.run[which]):
        own = which & (d.rows.run == part)
        y, n = d.after[own], int(own.sum())
        if n > 1:
            products.append((y.sum() ** 2 - (y**2).sum()) / (n * (n - 1)))
            chance += 2 / (n * (n - 1)) * float(np.mean(floor(d)[own] ** 2)) ** 2
    if not products:
        return 0.0
    return float(np.sqrt(max(np.mean(products) - 3 * np.sqrt(chance) / len(products), 0.0)))


def floor(d: Diagnosis) -> np.ndarray:
    """(N,) mm: the noise of single readings, without what was added for neighbours that are alike."""
    return d.sigma / d.alike


def _unknown(d: Diagnosis) -> None:
    """Structure that is left: runs that agree with each other about what nothing explains."""
    worst: tuple[float, int, float] = (0.0, -1, 0.0)
    for signal in range(len(d.rows.signals)):
        which = d.rows.signal == signal
        if not which.any():
            continue
        of_part = d.rows.sees[which][0] == "part"
        left = _left_of_feature(d, which) if of_part else locate.shared(d.rows, d.after, d.sigma, which)
        explained = sum((f.contribution for f in d.findings), np.zeros(len(d.rows)))[which]
        ground = np.hypot(
            1e-3 if of_part or d.rows.kinds[d.rows.file[which][0]] == "targets" else 5e-4,
            0.3 * float(np.sqrt(np.mean(explained**2)) if of_part else np.std(explained)),
        )
        ground = np.hypot(ground, float(np.sqrt(np.mean(d.rows.rounding[which] ** 2))))
        if of_part:  # a part is measured by something that is not exact either
            ground = np.hypot(ground, d.recordings[int(d.rows.file[which][0])].u or 0.0)
        if left / ground > worst[0]:
            worst = (left / ground, signal, left)
    if worst[0] > UNEXPLAINED:
        which = d.rows.signal == worst[1]
        total = float((d.before**2 / d.sigma**2)[~d.held].sum())
        rest = float((d.after**2 / d.sigma**2)[~d.held].sum())
        d.unknown = {"signal": worst[1], "rms": worst[2], "share": rest / max(total, 1e-9)}
        if rest > TENTATIVE * total:
            for f in d.findings:
                f.status = "tentative"
