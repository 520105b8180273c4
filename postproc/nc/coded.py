"""Words of codes to the numbers by which the tables of a dialect have them."""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.nc.codes import KEYWORD
from postproc.nc.grammar import KEYWORD_LETTER
from postproc.nc.lexer import Words

Coded = tuple[np.ndarray, np.ndarray]  # (K,) words of codes, (K,) their numbers


def written_codes(w: Words, place: np.ndarray, known: Coded | None = None) -> np.ndarray:
    """(n,) ten times the number behind each G, KEYWORD and more for keywords; -1 for what no code
    can be. known: the same of all codes of a batch, where it was asked before."""
    if known is not None and len(known[0]) == len(place):  # none was left out
        return known[1]
    mantissa, decimals = w.mantissa[place], w.decimals[place]
    # In tenths, for codes have one decimal: G54.10 is 541, G54.15 is 541.5 and so no code, which
    # must not be read as G54.1.
    number: np.ndarray = mantissa * 10
    if any_of(decimals != 0):
        power = 10 ** np.minimum(decimals, 17)
        number = np.where(decimals > 0, number // power, number)
        number = np.where((decimals < 18) & (number * power == mantissa * 10), number, -1)
    number[(number < 0) | (number >= KEYWORD)] = -1
    keyword = w.letter[place] == KEYWORD_LETTER
    number[keyword] = KEYWORD + mantissa[keyword]
    return number
