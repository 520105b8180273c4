"""Which positions the deviation of which axis depends on: what must be known before an axis can be
corrected."""

from __future__ import annotations

import numpy as np

from postproc.machine.chain import XYZ, along, leans
from postproc.machine.stated import Stated


def direct(machine: Stated) -> np.ndarray:
    """(A, A) bool: [i, j], whether the deviation along axis i changes with the position of axis j;
    by which components the tables hold."""
    letters, chain = machine.letters, machine.chain
    result = np.zeros((len(letters),) * 2, bool)
    if chain.rotary:  # what turns is turned by every axis between it and the part
        if not machine.is_zero:
            result[np.ix_(machine.corrected, machine.chained)] = True
        return result
    for x in chain.axes:
        for component, by in _components(machine, x):
            for i, arm in _acts(machine, x, component):
                for y in (x, *by, *arm):
                    result[i, letters.index(y)] = True
        for i, _ in leans(x, machine.square.get(x, np.zeros(3))):
            if XYZ[i] in letters:
                result[letters.index(XYZ[i]), letters.index(x)] = True
    return result


def _acts(machine: Stated, letter: str, component: int) -> list[tuple[int, tuple[str, ...]]]:
    """Rows along which a component of an axis acts, and the slides whose places are its arm there;
    no row without an arm."""
    if component < 3:
        return (
            [(machine.letters.index(XYZ[component]), ())]
            if XYZ[component] in machine.letters
            else []
        )
    found: list[tuple[int, tuple[str, ...]]] = []
    for i in (i for i in range(3) if i != component - 3 and XYZ[i] in machine.letters):
        # A rotation about r moves along i by the arm along the third direction, 3 - i - r. Where
        # the arm is zero and no slide adds to it the rotation does nothing: EBX of a lathe measured
        # at the tool.
        stays, slides = machine.arms[letter][3 - i - (component - 3)]
        if stays or slides:
            found.append((machine.letters.index(XYZ[i]), slides))
    return found


def closed(direct: np.ndarray) -> np.ndarray:
    """(A, A) bool: the same through the commands of other axes, which are corrected themselves; and
    an axis that is corrected depends on its own place."""
    # X is off by Z, and Z by Y: the command of X is found with Z's command, which needs Y. As many
    # rounds as there are axes reach the end of the longest such chain.
    result = direct | np.diag(direct.any(axis=1))
    for _ in range(len(result)):
        result = result | (result.astype(np.int64) @ result.astype(np.int64) > 0)
    return result


def _components(machine: Stated, letter: str) -> list[tuple[int, tuple[str, ...]]]:
    """Components of an axis that are not zero everywhere, and the second axes on which they
    depend."""
    found: list[tuple[int, tuple[str, ...]]] = []
    for x, table in machine.every_table:
        found += [(i, ()) for i in table.rows if x == letter]
    for grid in machine.grids_of[letter]:
        found += [(i, (grid.other,)) for i in grid.rows]
    if letter in machine.expansions:
        found.append((along(letter), ()))
    return found
