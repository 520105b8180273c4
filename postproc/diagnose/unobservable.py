"""What these recordings can not show, and why."""

from __future__ import annotations

import numpy as np

from postproc import effects
from postproc.diagnose import library
from postproc.diagnose.block import Block
from postproc.diagnose.rows import ENTERS, Rows
from postproc.machine.chain import XYZ

SENSES = ("servo_mismatch", "squareness")  # one turns over with the sense, the other does not
SAME = 0.98  # cosine between two effects that nothing tells apart


# Whole: a list of reasons in their order of precedence.
def spots(rows: Rows, every: list[Block]) -> list[tuple[str, str, str]]:
    """Effect, axis and why it can not be seen in these recordings."""
    seen = {(b.name, b.axis) for b in every}
    unread = {b.axis for b in every if b.name == "abbe" and not dict(b.shape)["known"]}
    result = []
    for name in effects.names():
        module = effects.load(name)
        if getattr(module, "LISTED", False):
            continue  # the rows themselves are looked at
        for axis in library.axes_of(rows, module):
            if name == "cyclic" and (even := _even(rows, axis)):
                result.append(
                    (
                        name,
                        axis,
                        (
                            f"targets at even steps of {even:g} mm: a period that divides them can"
                            " not be seen"
                        ),
                    )
                )
                continue
            if name == "abbe" and _on_one_line(rows, axis) and axis not in unread:
                why = (
                    f"no readings at rest along {axis} on two lines that lie apart: a rotation of"
                    f" {axis} that the machine's file lacks is not told from an error of its"
                    " position"
                )
                result.append((name, axis, why))
                continue
            if name == "servo_mismatch" and _one_sense(rows, axis, every):
                why = (
                    "all circles were run in one sense at one feed: the ellipse of two axes that"
                    " lag is that of two that are not square"
                )
                result.append((name, axis, why))
                continue
            if (name, axis) in seen:
                continue
            if (
                name in library.FOUND
                and library.visible(rows, module).any()
                and library.needed(rows, module, axis)
            ):
                continue  # it would have been looked for in the spectrum
            if not library.visible(rows, module).any():
                why = f"it shows only to {', '.join(module.SEES)}: no such recording"
            elif not library.needed(rows, module, axis):
                why = "its driver was not recorded, or did not change: " + ", ".join(module.NEEDS)
            else:
                why = "these places and times can not tell it from a zero"
            result.append((name, axis, why))
    return result


def _even(rows: Rows, axis: str) -> float:
    """mm: the step of targets along an axis, where they stand at even steps and nothing but targets
    was recorded; else 0."""
    moving = [
        s
        for s in np.unique(rows.signal)
        if np.ptp(rows.state.position[axis][rows.signal == s]) > 1e-3
    ]
    steps = []
    for signal in moving:
        which = rows.signal == signal
        # samples of a motion lie at all places: one such signal is enough
        if rows.state.passage[which][0] >= 0:
            return 0.0
        gaps = np.diff(np.unique(np.round(rows.state.position[axis][which], 3)))
        if len(gaps) < 3 or np.ptp(gaps) > 0.02:
            return 0.0
        steps.append(float(np.median(gaps)))
    return round(min(steps), 3) if steps else 0.0


def _on_one_line(rows: Rows, axis: str) -> bool:
    """Whether the tool's way along an axis was read, and nowhere at rest on two lines that lie
    apart."""
    along = np.isin(rows.sees, ("laser", "tool")) & (
        np.abs(rows.direction[:, XYZ.index(axis)]) > ENTERS
    )
    read = along.any() and np.ptp(rows.state.position[axis][along]) > 1e-3
    return bool(read) and not rows.state.lines.get(axis)


def _one_sense(rows: Rows, pair: str, every: list[Block]) -> bool:
    """Whether what two axes that lag differently add to these readings is what squareness adds, up
    to a factor."""
    shown = {
        name: [b.columns[:, 0] for b in every if b.name == name and b.axis == pair]
        for name in SENSES
    }
    return any(_alike(rows, a, b) for a in shown[SENSES[0]] for b in shown[SENSES[1]])


def _alike(rows: Rows, one: np.ndarray, other: np.ndarray) -> bool:
    """Beside what each set-up leaves open: a zero, and where the centre of a circle lies."""
    # servo_mismatch and squareness both read as sin(2 angle) on a circle; the first turns its sign
    # with the sense and grows with the feed. With one sense and one feed they are one column and
    # its multiple.
    both = np.stack([one, other], axis=1)
    for signal in np.unique(rows.signal):
        which = rows.signal == signal
        free = np.column_stack([np.ones(which.sum()), rows.direction[which]])
        both[which] -= free @ np.linalg.lstsq(free, both[which], rcond=1e-9)[0]
    size = np.linalg.norm(both, axis=0)
    return bool(abs(both[:, 0] @ both[:, 1]) > SAME * size[0] * size[1] > 0.0)
