"""What the machine's file says that readings are, apart from their zeros."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.diagnose import library
from postproc.diagnose.rows import Rows, diameters, pick_state, second_place
from postproc.effects import State
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine


def angles_of(machine: Machine, letter: str, state: State) -> np.ndarray | None:
    """(3, N) rad: the measured rotations of an axis at the rows, None where no table has any."""
    table = machine.tables.get(letter)
    if table is None or not any(row >= 3 for row in table.rows):
        return None
    parts = table.evaluate(state.position[letter], state.approach[letter])
    return np.stack([np.zeros(len(state)) if v is None else v for v in parts[3:]])


def predicted(rows: Rows, machine: Machine) -> np.ndarray:
    """(N,) mm: what the machine's file says these readings are, apart from their zeros."""
    result = np.zeros(len(rows))
    tool = np.isin(rows.sees, ("laser", "tool")) | diameters(rows)
    # Tables, squareness and arms first, without effects of the library: these are read below, with
    # the speeds and times that the rows have.
    bare = replace(machine, effects=tuple(e for e in machine.effects if e.module is None))
    if tool.any():
        part = pick_state(rows.state, tool)
        result[tool] = (deviation_at(bare, part) * rows.direction[tool].T).sum(axis=0)
    part = (rows.sees == "part") & ~diameters(rows)
    if part.any():
        near, far = pick_state(rows.state, part), second_place(rows, part)
        # a size is the difference of two places: what both walls share is no error of it
        between = deviation_at(bare, near) - deviation_at(bare, far)
        result[part] = (between * rows.direction[part].T).sum(axis=0)
    # with their history: what a place alone decides is only what a program can correct
    for term in machine.effects:
        if term.module is not None and library.needed(rows, term.module, term.axis):
            value, shape = term.module.coefficients(**term.parameters)
            result += library.read(rows, term.module, term.axis, shape) @ value
    for axis, angle in rows.state.angles.items():
        if angles_of(machine, axis, rows.state) is None:
            continue  # they come from the very readings
        turned = (rows.sees == "angle") & _moving(rows, axis)
        result[turned] += (angle[:, turned] * rows.direction[turned].T).sum(axis=0)
    return result


def _moving(rows: Rows, axis: str) -> np.ndarray:
    """(N,) whether the axis moves in the row's signal."""
    moves = np.zeros(len(rows), bool)
    for signal in np.unique(rows.signal):
        which = rows.signal == signal
        moves[which] = np.ptp(rows.state.position[axis][which]) > 1e-6
    return moves


def deviation_at(machine: Machine, state: State) -> np.ndarray:
    """(3, N) mm of the machine's model; axes that were not recorded stand at zero."""
    n = len(state)
    places = {x: state.channels.get(f"{x}_deg", np.zeros(n)) for x in machine.letters}
    position = np.stack([(places | state.position)[x] for x in machine.letters])
    approach = np.stack([state.approach.get(x, np.zeros(n)) for x in machine.letters])
    deviation = machine.deviation(position, approach)
    result = np.zeros((3, n))
    for i, x in enumerate(machine.letters):
        if x in XYZ:
            result[XYZ.index(x)] = deviation[i]
    return result
