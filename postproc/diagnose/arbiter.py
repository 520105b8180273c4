"""Which of two names, where the readings that took part do not tell them apart: what the others say.

A run between two others tells a jump from a drift, and it is the one that is held out. Half of its readings, every second one,
are asked then; what is shown as held out is the other half. Nothing is fitted to either, and no name comes in that the
readings that took part do not bear out as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.diagnose.fit import Projector, solve
from postproc.diagnose.library import Block
from postproc.diagnose.rows import Rows
from postproc.diagnose.select import FORM, FORM_OF_LARGEST, WIDE, Model, Selector, plausible

ALIKE, MARGIN = 0.97, 10.0  # of the score: no better than that among the rows that took part
CLEAR = 8.0  # score by which the others must prefer another name


@dataclass(frozen=True)
class Asked:
    """chosen: numbers of the blocks; model: their fit to the rows that took part; held (N,): rows that stay untouched; said: a
    sentence for each name that was changed."""

    chosen: list[int]
    model: Model
    held: np.ndarray
    said: list[str]


def asked(
    rows: Rows, sigma: np.ndarray, u: np.ndarray, prior: np.ndarray, held: np.ndarray, selector: Selector, model: Model,
    every: list[Block],
) -> Asked:  # fmt: skip
    """The names, exchanged where half of the held rows prefer another one. sigma (N,), u (N, Q) and the columns of `every` are
    of all rows, the selector's of those that took part."""
    chosen = [selector.blocks.index(b) for b in model.blocks]
    half = _half(rows, held)
    both = ~held | half
    said = []
    untouched = held
    for place in range(len(chosen)):
        rest = chosen[:place] + chosen[place + 1 :]
        score = selector.scores(rest, model.sigma)
        own = float(score[chosen[place]])
        alike = [
            int(k) for k in np.flatnonzero(score >= min(ALIKE * own, own) - MARGIN) if k not in rest and k < len(every)
        ]
        if not np.isfinite(own) or len(alike) < 2 or not half.any():
            continue
        noise = _noise(rows, sigma, model, chosen, every, held)[both]
        columns = [every[k].columns[both] for k in rest]
        wide = [np.full(c.shape[1], WIDE / max(1e-12, float(np.abs(c).max()))) for c in columns]
        p = Projector.of(noise, np.concatenate([u[both], *columns], axis=1), np.concatenate([prior, *wide]))
        y = rows.residual[both]
        worth = {k: _worth(p, every[k], every[k].columns[both], y) - float(selector.penalty[k]) for k in alike}
        best = max(worth, key=lambda k: worth[k])
        if worth[best] < worth[chosen[place]] + CLEAR or not selector.counts([*rest, best]):
            continue
        exchanged = [*chosen[:place], best, *chosen[place + 1 :]]
        fitted = selector.fitted(exchanged)
        if min(fitted.scores) < selector.least:  # beside it another name is no finding any more, or not plausible
            continue
        before, after = every[chosen[place]].key, every[best].key
        if before != after:
            said.append(
                f"{after} is named in the place of {before}, which explains the rest as well: "
                "every second reading of the runs that took no part says so"
            )
        untouched = held & ~half
        chosen, model = exchanged, fitted
    return Asked(chosen, model, untouched, said)


def _half(rows: Rows, held: np.ndarray) -> np.ndarray:
    """(N,) bool: every second held row of each signal."""
    half = np.zeros(len(held), bool)
    for signal in np.unique(rows.signal[held]):
        half[np.flatnonzero(held & (rows.signal == signal))[::2]] = True
    return half


def _noise(
    rows: Rows, sigma: np.ndarray, model: Model, chosen: list[int], every: list[Block], held: np.ndarray
) -> np.ndarray:
    """(N,) noise with the form error of what is explained; of rows that took part as the choice had it."""
    extra = np.zeros(len(sigma))
    for k, c in enumerate(chosen):
        part = every[c].columns @ model.coefficients[model.part(k)]
        for signal in np.unique(rows.signal):
            own = rows.signal == signal
            middle = part[own] - np.median(part[own])
            extra[own] += (FORM * middle) ** 2 + (FORM_OF_LARGEST * np.abs(middle).max()) ** 2
    result = np.sqrt(sigma**2 + extra)
    result[~held] = model.sigma
    return result


def _worth(p: Projector, block: Block, columns: np.ndarray, y: np.ndarray) -> float:
    value, covariance = solve(p, columns, y)
    if not plausible(block, value):
        return -np.inf
    b = columns.T @ p(y)
    return float(b @ covariance @ b)
