"""The whole question: recordings and a machine in, findings out.

In order: rows, data faults, what is held out; noise; locate without names; the most probable set of
effects; equivalent names, what could not have been seen; the fit on what took no part; what no name
explains.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from postproc.diagnose import (
    causes,
    drive,
    findings,
    held_out,
    isolated,
    judge,
    library,
    locate,
    mains,
    map_agreement,
    noise,
    nuisances,
    part_place,
    plausibility,
    shared_jump,
    telegraph,
    unobservable,
)
from postproc.diagnose.answer import Diagnosis, Finding
from postproc.diagnose.assembly import of
from postproc.diagnose.block import Block
from postproc.diagnose.evidence import Evidence, Fit
from postproc.diagnose.explained import of_others, scatter, shares
from postproc.diagnose.jumps import without
from postproc.diagnose.noise import Unit
from postproc.diagnose.nuisances import FREE, Group
from postproc.diagnose.parts import inverted
from postproc.diagnose.rows import Rows
from postproc.diagnose.search import Search
from postproc.diagnose.sets import Found, Sets
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

Jumps = list[tuple[shared_jump.SharedJump, np.ndarray]]  # with its columns (N, K)

MOST = 2.0  # times what repetitions and neighbours scatter by: more is no white noise
ALONE, DROPPED = 2.5, 6.0  # how many times the noise: counts less, is left out
SEED = 20131
FEW_TERMS = 3  # of a curve over the place: more could be the map of another machine
ROUNDS, STEPS = 2, 6  # in which noise is told from what comes back
MAP_WORSE = 1.8  # times its usual size
SHORTEST = 1.0  # mm: over less nothing leans


@dataclass(frozen=True)
class Options:
    """held_out: "run=3", or "" for the middle run of every recording that has three at least;
    progress: called with a word on each step."""

    held_out: str = ""
    progress: Callable[[str], None] = field(default=lambda word: None)


# Whole: the order of a diagnosis, a line to a step.
def diagnose(
    recordings: list[Recording], machine: Machine, options: Options | None = None
) -> Diagnosis:
    """Raises RecordingError or UsageError for what can not be compared."""
    options = options or Options()
    options.progress("reading")
    recordings, left_out = plausibility.connected(recordings)
    usable = plausibility.checked(recordings, machine)
    rows, stood = part_place.placed(of(usable.recordings, machine), machine)
    disagreements = map_agreement.disagreements(usable.recordings, rows, machine)
    rows, units, faults = _cleaned(rows)
    held, held_name = held_out.of(rows, options.held_out, recordings)
    # What was asked to be kept apart is not looked at; else all readings name, and a run that is
    # left out of the fit judges the sizes.
    train = ~held if options.held_out else np.ones(len(rows), bool)
    jumps = _jumps(rows, units, train)
    options.progress("learning the noise")
    evidence = _learned(rows, machine, units, train, jumps)
    options.progress("building the dictionary")
    search = Search(Sets(rows, evidence, _shown(library.blocks(rows), train)))
    if not evidence.blocks and not np.isin(rows.sees, ("part", "angle")).any():
        raise RecordingError(
            f"no effect could show in {', '.join(r.file for r in recordings)}: no axis moves, and"
            " nothing that could drive one was recorded",
            "record at several places, from both sides; gcomp simulate --test writes such a"
            " program",
        )
    options.progress("calibrating")
    search.calibrate(np.random.default_rng(SEED))
    options.progress("locating")
    places = _places(rows, evidence, search.sets.null().fit, train)
    options.progress("forces and currents")
    driven = drive.drives(usable.recordings)
    options.progress("choosing")
    state = causes.attributed(search, search.run(), driven)
    state = causes.leaning(search, state, machine)
    options.progress("showing")
    found = [findings.of_member(search, state, k) for k in state.members]
    # Anew, from what is usual: what a search carried from set to set depends on its way there.
    last = evidence.learn(state.fit.chosen, None, state.fit.on, STEPS)
    said = shares(evidence, last)
    scattered = of_others(scatter(evidence, last, said), rows, evidence)
    said["noise"] = of_others(said["noise"], rows, evidence)
    # Without a name wander would grow to say what the names say: it stays as it usually is
    # (steps=0), and the map's error is the same on both sides, so that before and after differ by
    # the names.
    alone = shares(evidence, evidence.learn((), None, steps=0)) | {"map": said["map"]}
    before, after = evidence.y - _fixed(alone), evidence.y - _fixed(said) - said["effects"]
    if held.any() and train.all():
        before[held], after[held] = _predicted(search, state, held)
    # they stand behind the map's terms
    at = evidence.shared.shape[1] - sum(columns.shape[1] for _, columns in jumps)
    for jump, columns in jumps:
        own = slice(at, at + columns.shape[1])
        at, value = own.stop, state.fit.mean[own]
        before = before + columns @ search.sets.null().fit.mean[own]
        found.insert(0, findings.of_jump(jump, rows, columns, value, said["noise"], held, machine))
        places = [*shared_jump.places(jump, rows, columns @ value), *places]
    places = locate.measured(places, rows, before)
    spots = unobservable.spots(
        rows, [b for k, b in enumerate(evidence.blocks) if k not in evidence.fixed]
    )
    unseen = {f"{name}:{axis}" for name, axis, _ in spots}
    limits = {
        key: size for key, size in findings.limits(search, state).items() if key not in unseen
    }
    sigma = np.hypot(said["noise"], findings.form(search.sets, state))
    diagnosis = Diagnosis(
        machine,
        recordings,
        rows,
        held,
        held_name,
        before,
        after,
        sigma,
        found,
        places,
        limits,
        spots,
        usable.faults + faults,
        search.least,
        said["noise"],
        notices=[
            *left_out,
            *usable.notices,
            *stood,
            *telegraph.notices(rows, units),
            *mains.notices(rows, units),
            *_notices(machine, state.fit, evidence),
            *_leaning(rows, evidence, found),
        ],
        disagreements=map_agreement.remaining(disagreements, rows, machine, _formed(rows, found)),
        scatter=scattered,
    )
    diagnosis.unknown = judge.judged(diagnosis, search.sets, state)
    diagnosis.drives = driven
    return diagnosis


def _predicted(search: Search, state: Found, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(H,) mm, (H,) mm: what is left of the readings that are held out without and with the effects
    that were found, everything fitted to the others; what no other run predicts (its own jumps,
    the phase of an oscillation) as it was found."""
    whole, fit = search.sets.evidence, state.fit
    y = whole.y.copy()
    own = np.zeros(len(y))
    for k in state.members:
        if not judge.predictable(whole.blocks[k]):
            own += whole.blocks[k].columns @ search.sets.value(fit, k)
    units = [p.whole for p in whole.parts]
    groups = [
        _without_processes(p.groups, {kind for k, kind in fit.on if k == u})
        for u, p in enumerate(whole.parts)
    ]
    rest = Evidence(y - own, units, groups, whole.groups, ~held)
    left = [k for k, p in enumerate(whole.parts) if not held[p.whole.rows].all()]
    on = frozenset((left.index(u), kind) for u, kind in fit.on if u in left)
    chosen: list[int] = []
    for k in fit.chosen:
        if judge.predictable(whole.blocks[k]):
            stated = float(whole.slab_of((k,))[0]) if k in whole.fixed else 0.0
            chosen += rest.add([whole.blocks[k]], stated)
    said = shares(rest, rest.learn(tuple(chosen), None, on, STEPS))
    # zeros that know of no name
    plain = Evidence(y, units, groups, whole.groups, ~held) if own.any() else rest
    alone = shares(plain, plain.learn((), None, steps=0)) | {"map": said["map"]}
    return (y - _fixed(alone))[held], (y - own - _fixed(said) - said["effects"])[held]


def _without_processes(groups: list[Group], but: set[str]) -> list[Group]:
    """The groups of a unit, of processes only those of some kinds."""
    return [g for g in groups if g.kind not in nuisances.PROCESSES or g.kind in but]


def _shown(blocks: Iterable[Block], train: np.ndarray) -> Iterator[Block]:
    """Blocks all of whose columns show in the rows that take part; in all rows all of them do."""
    for b in blocks:
        if train.all() or (np.abs(b.columns[train]).max(axis=0, initial=0.0) > 1e-9).all():
            yield b


def _fixed(said: dict[str, np.ndarray]) -> np.ndarray:
    """(N,) mm: what is the same in a run that took no part: zeros, set-ups, the map's error and
    jumps."""
    return sum(
        (said[name] for name in ("zero", "set-up", "map", "feature") if name in said),
        np.zeros(len(said["noise"])),
    )


def _cleaned(rows: Rows) -> tuple[Rows, list[Unit], list[tuple[int, int, str, float]]]:
    """Rows without isolated outliers, their instruments, and what was left out."""
    units = noise.units(rows)
    sigma = np.empty(len(rows))
    for unit in units:
        sigma[unit.rows] = unit.r
    departure, off = isolated.isolated(rows, rows.residual, sigma)
    for unit in units:
        if unit.dense:  # what a turn sets off may last for one sample
            size = isolated.in_motion(rows.residual[unit.rows], rows.run[unit.rows])
            off[unit.rows] = size * ~telegraph.near_turns(rows, unit)
            departure[unit.rows] = np.where(off[unit.rows] > 0, np.inf, 0.0)
    faults = [
        (int(rows.file[k]), int(rows.line[k]), "outlier", float(off[k]))
        for k in np.flatnonzero(departure >= DROPPED)
    ]
    keep = departure < DROPPED
    rows, inflation = (
        rows.pick(keep),
        np.maximum(1.0, departure[keep] / 2) * (departure[keep] > ALONE)
        + (departure[keep] <= ALONE),
    )
    units = noise.units(rows)
    for unit in units:
        unit.r = unit.r * inflation[unit.rows]
    return rows, units, faults


def _jumps(rows: Rows, units: list[Unit], train: np.ndarray) -> Jumps:
    """Where several readings leave their lines together each target has a value of its own: no
    smooth shape is asked to bend so. The jump and its columns (N, K)."""
    sigma = np.empty(len(rows))
    for unit in units:
        sigma[unit.rows] = unit.r
    own = np.flatnonzero(train)
    part = rows.pick(own)
    return [
        (jump, shared_jump.columns(jump, rows))
        for jump in shared_jump.find(part, part.residual, sigma[own])
    ]


def _learned(
    rows: Rows, machine: Machine, units: list[Unit], train: np.ndarray, jumps: Jumps
) -> Evidence:
    """The model of the readings; what scatters in each unit told from what wanders and from what
    comes back."""
    y = rows.residual.copy()
    for unit in units:
        if unit.sees != "part":
            y[unit.rows] -= np.median(y[unit.rows])
    own = [
        groups + nuisances.processes(rows, u)
        for groups, u in zip(nuisances.of_all(rows, units), units, strict=True)
    ]
    shared = [
        *nuisances.of_map(rows, machine),
        *(Group("jump", columns, FREE) for _, columns in jumps),
    ]
    most = [MOST * float(np.median(unit.r)) for unit in units]
    stationary = [_without_processes(groups, set(nuisances.RECURRENT)) for groups in own]
    own = [[g for g in groups if g.kind not in nuisances.NAMED] for groups in own]
    plain = _without_jumps(y, rows, units)
    for _ in range(ROUNDS):
        left, posterior = _unexplained(Evidence(plain, units, stationary, shared, train))
        for unit, at_most in zip(units, most, strict=True):
            noise.learned(
                unit,
                left[unit.rows],
                rows.rounding[unit.rows],
                train[unit.rows],
                at_most,
                posterior.get(int(unit.rows[0])),
            )
    return Evidence(y, units, own, shared, train)


def _unexplained(evidence: Evidence) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """(N,) mm: what zeros, set-ups, wander and what comes back leave of the readings; and of each
    unit of samples (n, q) mm, by its first row: a root of the covariance that is left to what they
    explain."""
    on = frozenset(
        (k, kind)
        for k, p in enumerate(evidence.parts)
        for kind in nuisances.RECURRENT
        if p.processes[kind].any()
    )
    fit = evidence.learn((), None, on, STEPS)
    said = shares(evidence, fit)
    explained = sum((v for name, v in said.items() if name != "noise"), np.zeros(len(evidence.y)))
    posterior = {
        int(part.whole.rows[0]): part.raw[:, old.use] @ inverted(old.root).T
        for part, old in zip(evidence.parts, fit.parts, strict=True)
        if part.whole.dense
    }
    return np.asarray(evidence.y - explained), posterior


def _without_jumps(y: np.ndarray, rows: Rows, units: list[Unit]) -> np.ndarray:
    """(N,) mm: readings y without the few clear jumps of samples in motion, and without the teeth
    of a slide that sticks and slips: a level that changes at once is neither noise nor wander. What
    changes where an axis turns is the machine's."""
    plain = y.copy()
    for unit in units:
        if not unit.dense:
            continue
        turns = telegraph.near_turns(rows, unit)
        for a, b in pairwise(unit.edges):
            plain[unit.rows[a:b]] = without(y[unit.rows[a:b]], turns[a:b])
    for sawtooth in library.sawtooths(rows):
        plain -= sawtooth * float(sawtooth @ plain / (sawtooth @ sawtooth))
    return plain


def _places(rows: Rows, evidence: Evidence, fit: Fit, train: np.ndarray) -> list[locate.Place]:
    """Where measured and simulated differ, beside zeros, set-ups, the map's error and the slowest
    wander."""
    own_of, sd = [], [fit.shared[evidence.shared_of]]
    for k, part in enumerate(evidence.parts):
        slow = [g for g, kind in enumerate(part.kinds) if kind == "wander"][:1]
        use = np.isin(part.of, slow) | (
            part.usually
            & ~np.isin(part.of, [g for g, kind in enumerate(part.kinds) if kind == "wander"])
        )
        own_of.append((part.whole.rows, part.raw[:, use]))
        sd.append(fit.parts[k].sd[part.of[use]])
    prior = np.concatenate(sd)
    wide, at = np.zeros((len(rows), len(prior))), evidence.shared.shape[1]
    wide[:, :at] = evidence.shared
    for number, columns in own_of:
        wide[number, at : (at := at + columns.shape[1])] = columns
    noise_of = shares(evidence, fit)["noise"]
    if train.all():
        return locate.regions(rows, noise_of, wide, prior)
    return locate.regions(rows.pick(train), noise_of[train], wide[train], prior)


def _notices(machine: Machine, fit: Fit, evidence: Evidence) -> list[str]:
    if not len(fit.shared) or not evidence.shared_learned.any():
        return []
    worse = float(np.max((fit.shared / evidence.shared_usual)[evidence.shared_learned]))
    if worse < MAP_WORSE:
        return []
    return [
        f"the map of {machine.name} is about {worse:.1f} times as wrong as maps usually are; small"
        " effects hide behind that"
    ]


def _formed(rows: Rows, found: Iterable[Finding]) -> np.ndarray:
    """(N,) mm: what was named, without curves of many terms over the place."""
    named = [
        f.contribution for f in found if abs(dict(f.block.shape).get("degree", 0.0)) <= FEW_TERMS
    ]
    return sum(named, np.zeros(len(rows)))


def _leaning(rows: Rows, evidence: Evidence, found: Iterable[Finding]) -> list[str]:
    """One line for each file of straightness readings in which what was named leans: its line
    counts as the machine's."""
    named = sum((f.contribution for f in found), np.zeros(len(rows)))
    lines = []
    for own in (
        p.whole.rows for p in evidence.parts if p.whole.sees == "tool" and not p.whole.dense
    ):
        for axis, place in rows.state.position.items():
            if np.ptp(place[own]) < SHORTEST:
                continue
            lean = float(np.polyfit(place[own], named[own], 1)[0])
            if abs(lean) > 2 * nuisances.ALIGNED:
                name = Path(rows.files[rows.file[own[0]]]).name
                lines.append(
                    f"{name}: what was named leans by {lean * 1e6:.0f} urad along {axis}; if"
                    " nothing squares the line of this optic to an axis, take the line out of the"
                    " readings and diagnose again"
                )
    return lines
