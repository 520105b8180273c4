"""Where on the machine the steps of a part were cut.

A recording of features says how large they are, not where the part stood: it is taken to have
stood in the middle of the travel. Steps are lengths from one face, the datum, which may stand
elsewhere. Where the machine's map says clearly more of their readings with a datum somewhere on the
travel than with each step in the middle, that is where they are taken to begin.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from postproc.diagnose.predicted import predicted
from postproc.diagnose.rows import Rows
from postproc.effects import State
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine

PLACES = 101  # of a datum, evenly over the travel
FEWEST = 2  # steps
# mm: by how much a step differs from a good map (unverified: parts on a measuring machine repeat to
# 1 um)
SIZE = 1e-3
SURE = 3.0  # ln(20): by how much likelier a datum must be, beside the number of places tried
FITS = 2.0  # times SIZE: what is off by more fits nowhere
STEP = " step"  # the contract's kind, at the end of the name of a signal


def placed(rows: Rows, machine: Machine) -> tuple[Rows, list[str]]:
    """The rows with their steps where they most likely stood, and what to say of it."""
    notices = []
    steps = np.array([name.endswith(STEP) for name in rows.signals])[rows.signal]
    for file in np.unique(rows.file[steps]):
        for x in rows.other:
            own = steps & (rows.file == file) & (rows.direction[:, XYZ.index(x)] != 0)
            datum = _datum(rows.pick(own), machine, x) if own.any() else None
            if datum is None:
                continue
            rows = _moved(rows, own, x, datum)
            rows = replace(rows, known=predicted(rows, machine))
            notices.append(
                f"{Path(rows.files[file]).name}: where its part stood was not recorded; its steps"
                f" fit the map where they begin at {x} = {datum:.0f} mm, not in the middle of the"
                " travel: so they are taken"
            )
    return rows, notices


def _datum(part: Rows, machine: Machine, x: str) -> float | None:
    """mm: where all steps begin; None for the middle of the travel."""
    signals, of = np.unique(part.signal, return_inverse=True)
    low, high = part.state.travel[x]
    last = high - float(np.max(part.state.position[x] - part.other[x]))
    if len(signals) < FEWEST or not np.isfinite(low + high) or last <= low:
        return None

    def off(rows: Rows) -> np.ndarray:
        """Means of the steps' readings beside what the map says, times SIZE."""
        return np.bincount(of, rows.y - predicted(rows, machine)) / np.bincount(of) / SIZE

    every = np.ones(len(part), bool)
    places = np.linspace(low, last, PLACES)
    # (places, steps), of SIZE: where the map says of each step what was read, all are small
    # together
    left = np.array([off(_moved(part, every, x, place)) for place in places])
    # the logarithms of their likelihoods, with long tails (Cauchy)
    worth = -np.log1p(left**2).sum(axis=1)
    best = int(np.argmax(worth))
    middle = -float(np.log1p(off(part) ** 2).sum())
    likelier = worth[best] > middle + np.log(PLACES) + SURE
    return float(places[best]) if likelier and np.median(np.abs(left[best])) < FITS else None


def _moved(rows: Rows, own: np.ndarray, x: str, datum: float) -> Rows:
    """The rows with the steps `own` (N,) along x from `datum` mm on."""
    size = rows.state.position[x] - rows.other[x]
    here, other = rows.state.position[x].copy(), rows.other[x].copy()
    here[own], other[own] = datum + size[own], datum
    return replace(rows, state=_at(rows.state, x, here), other=dict(rows.other) | {x: other})


def _at(state: State, x: str, position: np.ndarray) -> State:
    inside = dict(state.inside)
    if x in inside:
        moved = position != state.position[x]
        inside[x] = inside[x].copy()
        inside[x][0, moved] = position[moved]
    return replace(state, position=dict(state.position) | {x: position}, inside=inside)
