"""Whether a jump that was named is one: the readings beside its moment bear it out, and the signal
does not jump as far at other moments too.

A step between two levels explains a part of every slow change. A lost step is abrupt and seldom;
what changes over many readings is wander, and what jumps again and again is the instrument, or
physics of another kind.
"""

from __future__ import annotations

import numpy as np

from postproc.diagnose import jumps
from postproc.diagnose.explained import shares
from postproc.diagnose.jumps import WINDOW
from postproc.diagnose.sets import Found, Sets
from postproc.diagnose.telegraph import MANY
from postproc.effects.step_loss import MOMENTS

NAME = "step_loss"
# times the noise of the readings around it: the step that these show; times what was named
SHOWN, LEAST, MOST = 4.0, 0.4, 2.5
COMPARABLE = 0.5  # of the smallest jump that was named: what counts as another one


def borne_out(sets: Sets, state: Found, k: int) -> bool:
    """Whether every jump of a member shows in the readings beside its moment, by about its size,
    and no signal jumps about as far so often that a drive would not be run on."""
    said = shares(sets.evidence, state.fit)
    ground = ("zero", "set-up", "map", "feature")
    left = sets.evidence.y - said["effects"]
    for name in ground:
        left = left - said.get(name, 0.0)
    columns = sets.blocks[k].columns
    sizes = sets.value(state.fit, k)
    for column, size in zip(columns.T, sizes, strict=True):
        times, sure = _step(sets, left + column * size, column, said["noise"])
        # A drift has a step of its own size over a whole run and hardly any between two neighbours.
        if not (sure > SHOWN and LEAST < times / size < MOST):
            return False
    # coefficients of a jump are um (columns of 1 um), what is left is mm
    least = COMPARABLE * 1e-3 * float(np.abs(sizes).min())
    shape = dict(sets.blocks[k].shape)
    moments = [shape[name] for name in MOMENTS if name in shape]
    return _others(sets, left, np.any(columns != 0, axis=1), moments, least) + len(sizes) < MANY


def _step(
    sets: Sets, left: np.ndarray, column: np.ndarray, sigma: np.ndarray
) -> tuple[float, float]:
    """The coefficient of a jump by the readings of a window on either side of it alone, and how
    many times its standard deviation that is. left, sigma (N,) mm; column (N,)."""
    along = square = 0.0
    for own in _signals(sets, column != 0):
        at = int(np.argmax(column[own] != 0))
        window = own[max(0, at - WINDOW) : at + WINDOW]
        if not sigma[window].all():  # readings that take no part
            continue
        #     WINDOW before | WINDOW behind
        # About its mean: a zero of the window is no part of the step.
        x = column[window] - column[window].mean()
        weight = 1.0 / float(np.mean(sigma[window])) ** 2
        along += weight * float(x @ left[window])
        square += weight * float(x @ x)
    return (along / square, abs(along) / np.sqrt(square)) if square else (0.0, 0.0)


def _others(
    sets: Sets, left: np.ndarray, shown: np.ndarray, moments: list[float], least: float
) -> int:
    """How often that signal of those that were read before and behind a jump (moments, s) that does
    so most changes by more than `least` (mm) in what is left."""
    number, time = 0, sets.rows.state.time
    for own in _signals(sets, shown):
        through = any(time[own[0]] < t < time[own[-1]] for t in moments)
        if through and len(own) > 3 * WINDOW:
            number = max(number, int(np.count_nonzero(jumps.changes(left[own])[1] > least)))
    return number


def _signals(sets: Sets, shown: np.ndarray) -> list[np.ndarray]:
    """Rows of each signal in which a jump shows, in the order of time."""
    rows = sets.rows
    found = [np.flatnonzero(rows.signal == s) for s in np.unique(rows.signal[shown])]
    return [own[np.argsort(rows.state.time[own], kind="stable")] for own in found]
