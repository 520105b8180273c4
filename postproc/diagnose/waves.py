"""A wave that was found in a spectrum, as well as the readings tell it: its period, a second wave of half the period, a swing that
grows along the travel."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from postproc.diagnose import library
from postproc.diagnose.fit import Projector, solve
from postproc.diagnose.library import FOUND, Block, refined

if TYPE_CHECKING:
    from postproc.diagnose.select import Selector

WORTH = 2.0  # score that what comes with a wave must add
WITHIN, TRIED, ROUNDS = 0.6, 5, 3  # of what the span resolves; periods tried each time


def polished(selector: Selector, chosen: list[int], k: int, sigma: np.ndarray) -> int:
    """The number of the block, or of one at a likelier period, or with what comes with such a wave."""
    block = selector.blocks[k]
    if block.name not in FOUND:
        return k
    better = refined(selector.rows, block, selector.projector(chosen, sigma)(selector.y), sigma)
    if better.columns.shape[1] == block.columns.shape[1]:
        k = _best(selector, chosen, k, better, sigma, 0.0)
    if not hasattr(block.module, "fuller"):
        return k
    k = _best(selector, chosen, k, _nearby(selector, chosen, selector.blocks[k], sigma), sigma, 0.0)
    plain = selector.blocks[k]
    for shape in plain.module.fuller(dict(plain.shape)):
        fuller = _at(selector, plain, shape)
        if fuller is not None:
            k = _best(selector, chosen, k, _nearby(selector, chosen, fuller, sigma), sigma, WORTH)
    return k


def _best(selector: Selector, chosen: list[int], k: int, other: Block, sigma: np.ndarray, by: float) -> int:
    new = selector.let_in(other)
    return new if selector.worth(chosen, new, sigma) > selector.worth(chosen, k, sigma) + by else k


def _at(selector: Selector, block: Block, shape: dict[str, float]) -> Block | None:
    """The block in another shape; None where these readings do not show all of it."""
    columns = library.read(selector.rows, block.module, block.axis, shape)
    if not (np.abs(columns).max(axis=0) > 1e-9).all():
        return None
    return replace(block, shape=tuple(sorted(shape.items())), columns=columns)


def _nearby(selector: Selector, chosen: list[int], block: Block, sigma: np.ndarray) -> Block:
    """The block at the likeliest period near its own: what comes with a wave moves the period that fits best."""
    p = selector.projector(chosen, sigma)
    place = selector.rows.state.position[block.axis][np.any(block.columns != 0, axis=1)]
    within = WITHIN / max(float(np.ptp(place)), 1e-9)
    best, most = block, _fall(p, block, selector.y)
    for _ in range(ROUNDS):
        middle = 1 / dict(best.shape)["period_mm"]
        for f in middle + within * np.linspace(-1.0, 1.0, TRIED):
            tried = _at(selector, block, {**dict(block.shape), "period_mm": float(1 / f)}) if f > 0 else None
            if tried is not None and (fall := _fall(p, tried, selector.y)) > most:
                best, most = tried, fall
        within /= (TRIED - 1) / 2
    return best


def _fall(p: Projector, block: Block, y: np.ndarray) -> float:
    """Of chi squared, with this block besides."""
    value, _ = solve(p, block.columns, y)
    return float(value @ (block.columns.T @ p(y)))
