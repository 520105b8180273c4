"""B-splines in the text, each block of which names one control point: BSPLINE of Sinumerik.

Siemens, "NC programming" 12/2019 (6FC5398-2EP40-0BA0), pages 594 and 600, and "Job planning"
07/2010: the points are those of the control polygon, which the curve does not run through; PW,
their weight, is 0 to 3; SD, the degree, is 3, or 2 where it is written; PL is the interval between
two knots, which the control calculates "suitably" where it is not written. A spline may hold
further axes, named or not. Nothing but where the control points lie is read here: the curve lies in
their hull whatever the knots and weights are (postproc/compensate/splines.py).
"""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.motions import SPLINE
from postproc.nc.batch import Batch
from postproc.nc.columns import spread
from postproc.nc.queries import names

INTERVAL = "Q"  # the letter under which PL is read


def refuse_splines(
    b: Batch, motion: np.ndarray, moving: np.ndarray, centre_words: dict[str, np.ndarray]
) -> None:
    """Control points that are not followed. motion (B,): the code in force; moving (B,); words of
    centres and corners by their letter."""
    #      P1 o- - - -o P2           The curve stays within the hull of its control points and
    #        / .-'''-. \             touches none between: each is corrected as the end of a line
    #    P0 o'         `o P3         would be, and none is ever put in.
    spline = moving & (b.dialect.kind[np.maximum(motion, 0)] == SPLINE)
    if not any_of(spline):
        return
    beside = np.isin(spread(b.held("cutter"), b.n), b.dialect.beside)
    b.blame(
        (spline & beside).nonzero()[0],
        "a B-spline with cutter radius compensation on",
        "let the CAM program write the tool centre path, and G40 before it",
    )
    b.blame(
        (spline & b.machine).nonzero()[0],
        "a control point in machine coordinates",
        "write it in those of the others",
    )
    if b.frame.space is not None:
        b.blame(
            spline.nonzero()[0],
            "a B-spline of the tool tip, or in a tilted plane",
            "let the CAM program write short lines there",
        )
    for letter, place in centre_words.items():
        block = b.words.block[place]
        b.blame(
            block[spline[block]],
            f"{'a corner' if letter == 'R' else letter} in a block of a B-spline",
            "it belongs to lines and arcs: take it out",
        )


def spaced_column(b: Batch, block: np.ndarray, code: np.ndarray) -> np.ndarray:
    """(N,) bool whether the block of a control point says the interval of its knots. code (N,):
    kind."""
    spaced = np.zeros(len(block), bool)
    if any_of(code == SPLINE):
        spaced = (code == SPLINE) & names(b, INTERVAL)[block]
    return spaced
