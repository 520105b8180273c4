"""One cause that is said of all axes, or two of one axis that say it better: what a search of single steps passes by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from postproc.diagnose.select import Selector

CLEARLY = 15.0  # by how much two must be better than one: as much as one may be worse than two that it stands for


def parted(selector: Selector, chosen: list[int], sigma: np.ndarray, most: int) -> list[int]:
    """Chosen blocks, with one of several sizes and of no axis replaced by two others that are clearly better together."""
    for place, k in enumerate(chosen):
        block = selector.blocks[k]
        if block.module.PER != "all" or block.columns.shape[1] < 2 or len(chosen) >= most:
            continue
        rest = chosen[:place] + chosen[place + 1 :]
        first = _best(selector, rest, sigma, block.key)
        second = _best(selector, first, sigma, block.key) if len(first) > len(rest) else first
        if len(second) < len(rest) + 2 or _worth(selector, second, sigma) < _worth(selector, chosen, sigma) + CLEARLY:
            continue
        if all(selector.worth([c for c in second if c != new], new, sigma) >= selector.least for new in second[-2:]):
            return second
    return chosen


def _best(selector: Selector, chosen: list[int], sigma: np.ndarray, but: str) -> list[int]:
    """Chosen and the best block beside them that has another name; chosen where none is worth it."""
    score = selector.scores(chosen, sigma)
    for k in map(int, np.argsort(-score)):
        if score[k] < selector.least:
            break
        if selector.blocks[k].key != but and selector.fits(chosen, k, sigma):
            return [*chosen, k]
    return chosen


def _worth(selector: Selector, chosen: list[int], sigma: np.ndarray) -> float:
    """Fall of chi squared less penalties, but for what all have in common."""
    return -selector.projector(chosen, sigma).chi2(selector.y) - float(selector.penalty[chosen].sum())
