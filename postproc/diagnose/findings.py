"""From what was chosen to findings: sizes with their intervals, other names for the same, what
would have been seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.diagnose import intervals, shapes, shared_jump, unrecorded
from postproc.diagnose.answer import Finding
from postproc.diagnose.block import Block
from postproc.diagnose.factors import TRIED
from postproc.diagnose.prior import rarity
from postproc.diagnose.rows import Rows
from postproc.diagnose.search import NAMES, Search
from postproc.diagnose.sets import MATERIAL, Found, Sets
from postproc.machine.model import Machine

CYCLE_MS = 5.0  # a control's position cycle is shorter: its own log is not later
LIKELY = 6.0  # twice ln(20): a name with a twentieth of the probability stands in the set
OF_EFFECT = 0.1  # of what an effect explains, single readings may be of another form
TELLS = 0.1  # of what is believed beforehand: a reading that tells less tells nothing
NEEDLESS = 0.5  # of its score: what remains of it beside another name for the same


def of_jump(
    jump: shared_jump.SharedJump,
    rows: Rows,
    columns: np.ndarray,
    value: np.ndarray,
    sigma: np.ndarray,
    held: np.ndarray,
    machine: Machine,
) -> Finding:
    """A jump that several readings share, as a finding: certain itself, its cause one of a set."""
    named = jump.parameters()
    error = 1.96 * jump.ratio_error
    ci = {name: (v - error, v + error) if name == "ratio" else (v, v) for name, v in named.items()}
    contribution = columns @ value
    fall = float(np.sum((contribution[~held] / sigma[~held]) ** 2))
    # ln n for each target that has a value of its own (Bayesian information criterion)
    score = fall - columns.shape[1] * float(np.log((~held).sum()))
    first, second = (
        Path(rows.files[rows.file[rows.signal == p.signal][0]]).name
        for p in (jump.first, jump.second)
    )
    causes = shared_jump.causes(jump)
    return Finding(
        Block(shared_jump, jump.axis, (), lambda: columns),
        named,
        ci,
        contribution,
        score,
        fall,
        causes,
        text=shared_jump.words(jump, (first, second)),
        next_test=shared_jump.next_test(jump, machine.name),
        names={cause: 1 / len(causes) for cause in causes},
    )


def of_member(search: Search, state: Found, k: int) -> Finding:
    """A member of the set that was found."""
    sets = search.sets
    block, value = sets.blocks[k], sets.value(state.fit, k)
    rest = sets.without(state, k)
    scores = sets.scores(rest)
    named, ci = intervals.of(sets, state, k, scores)
    periods = shapes.aliases(sets, rest.fit, block, LIKELY)
    if periods:
        low, high = ci["period_mm"]
        ci["period_mm"] = (min(low, *periods), max(high, *periods))
    own = sets.worth(state, k)
    less = _alike(search, state, k, rest)
    contribution = block.columns @ value
    if block.name == "servo_lag" and named["tau_ms"] > CYCLE_MS and "delay:" not in less:
        # of a log that is late by more than a control's cycle nobody can tell
        less = {"delay:": 0.0} | less
    for name in unrecorded.names(sets.rows, block, contribution):
        less.setdefault(name, 0.0)
    power, along = sets.evidence.beside(state.fit, block.columns, but=k)
    # chi squared by the columns alone, without a prior; pinv, for curves that targets can not tell
    # apart are columns that are alike
    fall = float(along @ np.linalg.pinv(power, rcond=1e-9, hermitian=True) @ along)
    return Finding(
        block,
        named,
        ci,
        contribution,
        own,
        fall,
        list(less),
        names=probable(block.key, less),
        aliases=periods,
    )


def _alike(search: Search, state: Found, k: int, rest: Found) -> dict[str, float]:
    """Other names for a member, the likeliest first, and by how much less each is believed, twice
    the logarithm of a probability: names whose curves say the same differ by how common they are,
    the others by their scores."""
    sets, block = search.sets, search.sets.blocks[k]
    best, own = sets.at_own_form(state).score, sets.worth(state, k)
    children = sorted(search.children(rest, NAMES, state), key=lambda child: child.score)
    others = {sets.blocks[c.added_to(rest)].key: c for c in children}  # the best of each name
    others.pop(block.key, None)
    result = {}
    for key, child in sorted(others.items(), key=lambda item: -item[1].score):
        other = child.added_to(rest)
        same = sets.says_the_same(state, child)
        # What explains something else besides is no other name for this: with it this must lose
        # most of what it is worth.
        if (same or child.score > best - LIKELY) and _needless(sets, rest, other, k, own):
            rarer = rarity(sets.blocks[other]) - rarity(block)
            result[key] = max(0.0, rarer if same else best - child.score)
    return result


def probable(own: str, less: dict[str, float]) -> dict[str, float]:
    """Names to probabilities. less: by how much less each other name is believed, twice the
    logarithm of a probability."""
    weight = {own: 1.0} | {name: float(np.exp(-fall / 2)) for name, fall in less.items()}
    whole = sum(weight.values())
    return {name: w / whole for name, w in sorted(weight.items(), key=lambda item: -item[1])}


def _needless(sets: Sets, rest: Found, other: int, k: int, own: float) -> bool:
    """Whether a member is worth little beside another name for the same."""
    instead = sets.of((*rest.members, other), rest.fit.on, rest)
    both = sets.of((*rest.members, other, k), rest.fit.on, rest)
    return both.score - instead.score < NEEDLESS * own


def form(sets: Sets, state: Found) -> np.ndarray:
    """(N,) mm: by how much the found effects may be of another form than the library's."""
    total = np.zeros(len(sets.rows))
    for k in state.members:
        total += (OF_EFFECT * sets.blocks[k].columns @ sets.value(state.fit, k)) ** 2
    return np.sqrt(total)


def limits(search: Search, state: Found) -> dict[str, float]:
    """effect:axis to mm: from which size on it would have been seen: where its worth reaches the
    threshold and twice its root."""
    sets = search.sets
    _, _, spread = sets.evidence.scan(state.fit)
    result: dict[str, float] = {}
    wanted = search.least + 2 * np.sqrt(search.least)
    for k, block in enumerate(sets.blocks):
        if k in sets.evidence.fixed:
            continue
        first = sets.evidence.first[k]
        slab = float(sets.evidence.slab[first])
        # spread is that of readings and prior together (factors.py); without a prior it would be
        # without bound where no reading tells anything
        # what the readings tell: the prior of the spread is the largest size tried
        power = 1 / float(spread[first]) ** 2 - 1 / (TRIED[-1] * slab) ** 2
        peak = float(block.largest[0])
        if power * slab**2 > TELLS:
            size = np.sqrt((wanted + sets.cost[k] + np.log1p(power * slab**2)) / power) * peak
            result[block.key] = min(result.get(block.key, np.inf), max(size, MATERIAL))
    return result
