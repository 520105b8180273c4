"""Threading cycles of lathes (G76, G92, G78): they stay as they are, in step with the spindle.

Their passes are the control's, and each begins at the same angle of the spindle. They end where
they began, so what stands behind them is corrected as if they were not there; what they cut is not,
which a notice says. Sources: Fanuc B-64304EN-1, "Multiple thread cutting cycle", "Thread cutting
cycle"; Haas lathe operator's manual, G76, G92. G184 of Okuma taps at each C: 5238-E, P-139.
Sinumerik's cycles (CYCLE97, CYCLE840) end elsewhere: no place is known behind a thread, nor along a
tapped hole. G76 of LinuxCNC stays under G7 alone, where releases differ on I J K, and ends
elsewhere too.
"""

from __future__ import annotations

import numpy as np

from postproc.flags import any_of
from postproc.nc.batch import Batch
from postproc.nc.codes import KEYWORD, Code
from postproc.nc.columns import spread
from postproc.nc.holes import ACROSS
from postproc.nc.queries import names, tell

DIAMETER = 70  # ten times G7
TURNS = 1840  # G184 of Okuma lathes turns C from hole to hole


def left_as_they_are(b: Batch, motion: np.ndarray) -> None:
    """Take their axis words, and say so."""
    for number, code in b.dialect.stays.items():
        mask = np.zeros(b.n, bool)
        if code.group:
            mask = motion == number
        else:
            mask[b.single.get(number, [])] = True
        if not any_of(mask):
            continue
        if code.refuses:
            mask &= b.has_axis & ~_by_radius(b, code, mask)
        # cycles that are words (CYCLE97), and those that are refused but for this mode
        if number >= KEYWORD or code.refuses:
            _ends_elsewhere(b, code.does, mask)
        else:
            mask &= b.has_axis
        if np.count_nonzero(mask):
            b.taken |= mask
            if number == TURNS and "C" in b.rows:
                b.loses[mask & names(b, "CQ")] = True
            said = (
                f"{code.word} ({code.meaning}) stays as it is, in step with the spindle: its thread"
                " is cut uncorrected"
            )
            tell(b, f"left {code.word}", said, int(mask.argmax()))


def _by_radius(b: Batch, code: Code, mask: np.ndarray) -> np.ndarray:
    """(B,) bool: the cycles where X is a radius, which --expand writes out."""
    by_radius: np.ndarray = mask & (spread(b.held("diameter"), b.n) != DIAMETER)
    if np.count_nonzero(by_radius):
        b.foreign |= by_radius
        b.reason[by_radius] = b.because(f"{code.word} ({code.meaning})", code.refuses)
    return by_radius


def _ends_elsewhere(b: Batch, does: str, mask: np.ndarray) -> None:
    """Cycles that are words: where X and Z end behind a thread is not said, nor the axis of a
    hole behind a tap without its retraction plane."""
    if not np.count_nonzero(mask):
        return
    plane = spread(b.held("plane"), b.n)
    for axis in "XYZ":
        here = mask & (axis != "Y")
        if does == "tapping cycle":
            here = mask & np.isin(plane, [n for n, across in ACROSS.items() if across == axis])
        b.gone[axis] = b.gone.get(axis, np.zeros(b.n, bool)) | here
