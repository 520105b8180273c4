"""G93 in a block that was cut: every piece takes its part of the time."""

from __future__ import annotations

import numpy as np

from postproc.motions import RAPID
from postproc.nc.writing import Writing


def inverse_time(b: Writing) -> None:
    """G93: every piece takes its part of the time. A take-up goes as fast as the motion it
    precedes."""
    m, p = b.m, b.p
    for i in map(int, (m.inverse[p.motion] & b.several & (p.code != RAPID)).nonzero()[0]):
        motion = p.motion[i]
        share = p.share[i] or _take_up_share(b, i)
        text = _plain(m.feed[motion] / share)
        b.feed(i, text)


def _take_up_share(b: Writing, i: int) -> float:
    """Length of a take-up over the length of its motion."""
    p = b.p
    own = np.linalg.norm((p.end[:, i] - p.start[:, i]).astype(float))
    same = (p.motion == p.motion[i]).nonzero()[0]
    whole = sum(
        np.linalg.norm((p.end[:, j] - p.start[:, j]).astype(float))
        for j in same
        if not p.take_up[j]
    )
    return float(own / whole) if whole else 1.0


def _plain(value: float) -> bytes:
    """A feed with seven digits, no exponent."""
    return f"{value:.{max(0, 6 - len(str(int(abs(value)))) + 1)}f}".encode()
