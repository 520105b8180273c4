"""Threading cycles of lathes (G76, G92, G78): they stay as they are, in step with the spindle.

Their passes are the control's, and each begins at the same angle of the spindle. They end where
they began, so what stands behind them is corrected as if they were not there; what they cut is not,
which a notice says. Sources: Fanuc B-64304EN-1, "Multiple thread cutting cycle", "Thread cutting
cycle"; Haas lathe operator's manual, G76, G92.
"""

from __future__ import annotations

import numpy as np

from postproc.errors import Notice
from postproc.nc.batch import Batch


def left_as_they_are(b: Batch, motion: np.ndarray) -> None:
    """Take their axis words, and say so."""
    for number, code in b.dialect.stays.items():
        mask = np.zeros(b.n, bool)
        if code.group:
            mask = motion == number
        else:
            mask[b.single.get(number, [])] = True
        mask &= b.has_axis
        if mask.any():
            b.taken |= mask
            said = (
                f"{code.word} ({code.meaning}) stays as it is, in step with the spindle: its thread"
                " is cut uncorrected"
            )
            b.notices.append(Notice(f"left {code.word}", said, int(b.words.line[mask.argmax()])))
