"""Lost motion has a sign: a slide with play lags behind its command, so that of its own positioning
reverse - forward is above zero.

Approached in + it stops short (deviation below), approached in - it stops short of the other side
(above). Below zero the slide goes beyond its command: the control takes up more play than there is,
or a sign of the numbers is turned.
"""

from __future__ import annotations

import numpy as np

from postproc.machine.chain import LINEAR, XYZ, along
from postproc.machine.model import Machine
from postproc.units import UM, URAD

# of the median: less is what few runs scatter by; 5 urad is one second of arc
LEAST = {"um": 0.5, "urad": 5.0}
WAYS_OUT = (
    "play makes a slide lag, and is above zero. Is the file negated (corrections, or read towards -"
    " of the axis)? Are its directions exchanged (--first)? Else the control takes up more backlash"
    " than there is: lower it there"
)


def sentence(component: str, lost: np.ndarray, known_to: float = 0.0) -> str:
    """What is to be said of a component's lost motion, empty where it lags as it should.

    component: EXX; lost (K,) mm or rad: reverse - forward at each target, NaN where one direction
    was not read; known_to: mm or rad, U (95 %) of its median.
    """
    unit, one = ("um", UM) if component[1] in XYZ else ("urad", URAD)
    lost = lost[np.isfinite(lost)] / one
    if not len(lost):
        return ""
    limit, middle = max(LEAST[unit], known_to / one), float(np.median(lost))
    #    command ----->|        approached in +: stops short, forward < 0
    #              |<----- command     approached in -: stops short, reverse > 0
    #    lost motion = reverse - forward > 0; the reversal B of ISO 230-2 is its negative
    if middle > -limit:
        return ""
    return (
        f"{component} goes beyond its command where the axis reverses: reverse - forward is"
        f" {lost.min():+.1f} to {lost.max():+.1f} {unit}, {middle:+.1f} in the median, below zero"
        f" at {int((lost < 0).sum())} of {len(lost)} targets; {WAYS_OUT}"
    )


def of_axis(machine: Machine, letter: str) -> np.ndarray:
    """(K,) mm or rad: reverse - forward of an axis' own positioning at all its nodes, tables,
    effects and what depends on a second axis together."""
    row = along(letter) if letter in LINEAR else 3 + "ABC".index(letter)
    tables = [table for x, table in machine.every_table if x == letter and np.any(table.half[row])]
    grids = [grid for grid in machine.grids_of[letter] if np.any(grid.half[row])]
    if not tables and not grids:
        return np.zeros(0)
    nodes = np.unique(np.concatenate([t.nodes for t in tables] + [g.nodes for g in grids]))
    total = np.zeros((len(nodes), 1))
    for table in tables:
        # half is (forward - reverse) / 2: lost motion is -2 half, as in Machine._play
        total[:, 0] -= 2 * np.interp(nodes, table.nodes, table.half[row])
    for grid in grids:  # at all nodes of their second axes
        by = 2 * np.asarray(grid.half_of(row, nodes[:, None], grid.others))
        total = (total[:, :, None] - by[:, None]).reshape(len(nodes), -1)
    return total.ravel()


def found(machine: Machine, letters: str = "") -> list[str]:
    """Sentences about the axes of a machine, or about some of them."""
    every = [x for x in machine.letters if not letters or x in letters]
    said = [
        sentence(f"E{XYZ[along(x)] if x in LINEAR else x}{x}", of_axis(machine, x)) for x in every
    ]
    return [text for text in said if text]
