"""The whole question: recordings and a machine in, findings out.

In order: rows, noise, data faults, what is held out; locate without names; choose on the rest; equivalent names, what could
not have been seen; the fit on what took no part; what no name explains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from postproc.diagnose import (
    blind,
    doubt,
    drive,
    findings,
    fit,
    held_out,
    library,
    likeness,
    locate,
    noise,
    restless,
    shared_jump,
    sound,
    stuck,
)  # fmt: skip
from postproc.diagnose.answer import Diagnosis
from postproc.diagnose.library import Block
from postproc.diagnose.rows import Rows, of
from postproc.diagnose.select import Model, Selector
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

ALONE, DROPPED = 2.5, 6.0  # how many times the noise: counts less, is left out
CYCLE_MS = 5.0  # ms: a control's position cycle is shorter
SEED = 20131
STEP = 0.5  # of an instrument's step: its rounding is the same in every run


@dataclass(frozen=True)
class Options:
    """held_out: "run=3", or "" for the middle run of every recording that has three at least; draws: nulls that calibrate the
    threshold; told: called with a word on each step."""

    held_out: str = ""
    draws: int = 200
    told: Callable[[str], None] = field(default=lambda word: None)


def diagnose(recordings: list[Recording], machine: Machine, options: Options | None = None) -> Diagnosis:
    """Raises RecordingError or UsageError for what can not be compared."""
    options = options or Options()
    options.told("reading")
    usable = sound.checked(recordings, machine)
    rows = of(usable.recordings, machine)
    doubts = likeness.doubts(usable.recordings, rows, machine)
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
    if not blocks and not np.any(rows.sees == "part"):
        raise RecordingError(
            f"no effect could show in {', '.join(r.file for r in recordings)}: no axis moves, and nothing that could drive one was recorded",
            "record at several places, from both sides; gcomp simulate --test writes such a program",
        )
    places = locate.regions(part, sigma[train], u[train], prior)
    selector, model = _chosen(part, sigma[train], u[train], prior, blocks, options)
    notices = list(usable.notices)
    worse = fit.map_worse(u[train], prior, model.sigma, part.residual - model.explained)
    if worse > 1 and model.blocks:
        prior = np.where(prior == fit.MAP_UM * 1e-3, worse * prior, prior)
        notices.append(
            f"the map of {machine.name} is about {worse:.1f} times as wrong as maps usually are; small effects hide behind that"
        )
        selector, model = _chosen(part, sigma[train], u[train], prior, blocks, options)
    creep = restless.creeping(part, _left(part, selector, model), sigma[train], alike[train])
    if creep:  # what nobody can foretell there is noise to all that can be foretold
        restless_sigma = np.hypot(sigma, creep.rms * alike * restless.rows_of(rows, creep))
        other, again = _chosen(part, restless_sigma[train], u[train], prior, blocks, options)
        smooth_turns = any(b.axis == creep.axis and b.name in restless.LIKE for b in model.blocks)
        ways = ((_left(part, selector, model), model.sigma), (_left(part, other, again), again.sigma))
        if smooth_turns and restless.misfit(*ways[0], alike[train]) < restless.misfit(*ways[1], alike[train]):
            creep = None
        else:
            sigma, selector, model = restless_sigma, other, again
    model, late = _of_each_axis(selector, model, part)
    chosen = [selector.blocks.index(b) for b in model.blocks]
    # What was found on the way has columns of the rows that took part only: read them of all rows. A passage that took no
    # part swings in a phase that nobody knows.
    for b in selector.blocks[len(blocks) :]:
        columns = library.read(rows, b.module, b.axis, dict(b.shape))
        shows = library.swings(columns[train]) if b.name in library.FOUND else np.ones(columns.shape[1], bool)
        every.append(replace(b, columns=columns[:, shows]))
    options.told("showing")
    before, after, alone, coefficient = _residuals(rows, sigma, u, prior, held, every, chosen, model)
    found = [findings.of_block(rows, selector, model, k, chosen, every) for k in range(len(chosen))]
    if creep:
        found.append(findings.of_creep(creep, len(rows)))
    for f in found:
        if late and f.block.name == "servo_lag" and "delay:" not in f.equivalent:
            f.equivalent.insert(0, "delay:")
    for jump in jumps:
        columns = shared_jump.columns(jump, rows)
        value = coefficient[smooth : smooth + columns.shape[1]]
        smooth += columns.shape[1]
        before = before + columns @ value
        found.insert(0, findings.of_jump(jump, rows, columns, value, sigma, held, machine))
        places = [*shared_jump.places(jump, rows, columns @ value), *places]
    spots = blind.spots(rows, every)
    unseen = {f"{name}:{axis}" for name, axis, _ in spots}
    limits = {key: size for key, size in findings.limits(selector, chosen).items() if key not in unseen}
    diagnosis = Diagnosis(
        machine, recordings, rows, held, held_name, before, after, sigma, found, places, limits, spots,
        usable.faults + faults, selector.least, alike, alone, notices=notices, doubts=doubts,
    )  # fmt: skip
    doubt.doubted(diagnosis)
    diagnosis.unknown = doubt.unknown(diagnosis)
    options.told("forces and currents")
    diagnosis.drives = drive.drives(usable.recordings)
    return diagnosis


def _chosen(rows: Rows, sigma: np.ndarray, u: np.ndarray, prior: np.ndarray, blocks: list[Block], options: Options):
    """The selector and what it chose."""
    selector = Selector(rows, rows.residual, sigma, u, prior, blocks)
    options.told("calibrating")
    if options.draws and blocks:
        selector.calibrate(np.random.default_rng(SEED), options.draws)
    options.told("choosing")
    return selector, selector.run()


def _left(rows: Rows, selector: Selector, model: Model) -> np.ndarray:
    """(N,) mm that nuisances and the chosen leave."""
    left = rows.residual - model.explained
    return left - fit.Projector.of(model.sigma, selector.u, selector.prior).nuisance(left)


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
    sigma = np.maximum(sigma, np.maximum(rows.grain, stuck.step(rows.y, rows.signal) * STEP))
    lone, off = noise.isolated(rows, rows.residual, sigma)
    faults = [(int(rows.file[k]), int(rows.line[k]), "outlier", float(off[k])) for k in np.flatnonzero(lone >= DROPPED)]
    sigma = sigma * np.where(lone > ALONE, np.maximum(1.0, lone / 2), 1.0)
    keep = lone < DROPPED
    return rows.pick(keep), sigma[keep], alike[keep], faults


def _residuals(rows, sigma, u, prior, held, every, chosen, model):
    """(N,) mm before and after, set-up zeros and the like taken out as the rows that took part tell them; of rows held out
    nothing is fitted but the zero of their own set-up. What zeros and the like leave where they alone are fitted. And their
    coefficients."""
    y = rows.residual
    explained = sum(
        (every[c].columns @ model.coefficients[model.part(k)] for k, c in enumerate(chosen)), np.zeros(len(rows))
    )
    # Set-up zeros and the map's own error once, from the fit with everything in it: what is shown before and after differs by
    # the accepted effects alone.
    train = ~held
    p = fit.Projector.of(model.sigma if chosen else sigma[train], u[train], prior)
    coefficient = p.inner @ (p.u.T @ (p.w * (y - explained)[train]))
    alone = y - u @ (p.inner @ (p.u.T @ (p.w * y[train])))
    return y - u @ coefficient, y - explained - u @ coefficient, alone, coefficient
