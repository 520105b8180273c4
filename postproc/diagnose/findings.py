"""From what was chosen to findings: sizes with their intervals, other names for the same, what would have been seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.diagnose import intervals, restless, shared_jump, unrecorded
from postproc.diagnose.answer import Finding
from postproc.diagnose.library import Block
from postproc.diagnose.rows import Rows
from postproc.diagnose.select import MATERIAL, Model, Selector
from postproc.machine.model import Machine

ALIKE = 0.97  # of the best score: explains as well
NEEDLESS = 0.5  # of its score: what remains of it beside another name for the same


def of_jump(jump, rows: Rows, columns: np.ndarray, value: np.ndarray, sigma, held, machine: Machine) -> Finding:
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


def of_block(rows: Rows, selector: Selector, model: Model, k: int, chosen: list[int], every: list[Block]) -> Finding:
    block = model.blocks[k]
    value = model.coefficients[model.part(k)]
    rest = [c for j, c in enumerate(chosen) if j != k]
    scores = selector.scores(rest, model.sigma)
    named, ci = intervals.of(selector, model, k, chosen, scores)
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
    contribution = every[chosen[k]].columns @ value
    alike = alike[:6] + [n for n in unrecorded.names(rows, block, contribution) if n not in alike[:6]]
    return Finding(block, named, ci, contribution, own, fall, alike)


def of_creep(creep: restless.Creep, n: int) -> Finding:
    """What nobody can foretell sample by sample explains nothing of a single reading, only how they spread."""
    module, shape, value = restless.named(creep)
    block = Block(module, creep.axis, tuple(sorted(shape.items())), np.zeros((n, 1)))
    return Finding(block, value, {name: (v, v) for name, v in value.items()}, np.zeros(n), creep.fall, creep.fall, [])


def limits(selector: Selector, chosen: list[int]) -> dict[str, float]:
    """effect:axis to mm: from which size on it would have been seen: where its fall reaches the threshold and twice its root."""
    p = selector.projector(chosen, selector.sigma)
    result: dict[str, float] = {}
    wanted = selector.least + 2 * np.sqrt(selector.least)
    _, _, power_of, _ = selector.stack.after(p, selector.sigma, selector.y)
    for block, penalty, part in zip(selector.blocks, selector.penalty, selector.stack.parts, strict=True):
        power, peak = power_of[part.start], float(np.abs(selector.stack.columns[part.start]).max(initial=0.0))
        if power <= 0:
            continue
        size = np.sqrt((wanted + penalty) / power) * peak
        result[block.key] = min(result.get(block.key, np.inf), max(size, MATERIAL))
    return result
