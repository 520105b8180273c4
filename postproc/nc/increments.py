"""Numbers without a decimal point, where a control counts least increments of them."""

from __future__ import annotations

import numpy as np

from postproc.nc.batch import LINEAR, Batch
from postproc.nc.queries import words_of


def count_increments(b: Batch) -> None:
    """A number without a decimal point counts least increments: X1000 is X1.000 where they are
    0.001. On a Haas they are that whatever the machine resolves, and 0.0001 inch (Haas, "Help with
    the decimal points", setting 162)."""
    w = b.words
    own = b.dialect.counts
    least = {x: own or b.setup.least_increment.get(b.measured(x), 1e-4) for x in b.rows}
    places = {x: -round(np.log10(size)) for x, size in least.items()}
    # I J K and R may lie along any of the slides: where these differ the coarsest counts
    linear = min((places[x] for x in b.rows if x in LINEAR), default=4)
    if b.polar:
        places |= {"Y": places["C"], "C": places["C"]}
    axis_of = {u: x for u, x in b.dialect.increments.items() if x in places}
    by_letter = {**places, **{u: places[x] for u, x in axis_of.items()}}
    inch = np.broadcast_to(b.held("units"), b.n) == 200
    for letter in {*by_letter, *"IJKR"}:
        place = words_of(b, letter)
        place = place[~w.pointed[place]]
        axis = axis_of.get(letter, letter)  # H of a lathe is an increment of C: degrees
        more = inch[w.block[place]] & (axis not in b.rows or b.measured(axis) in LINEAR)
        w.decimals[place] = by_letter.get(letter, linear) + more  # the lexer's copy for this batch
