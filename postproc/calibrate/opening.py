"""By how much the axes' own angles open the angle between two axes, at the place where a squareness
was measured.

The squareness of a machine's file holds where its tables are zero. A square stands elsewhere: there
the axis that carries another is turned by its own angle, and the other one with it (EBZ(z) adds to
the lean of X on a machine whose Z carries X). So the line that the tables make of each arm of the
square comes off its slope, and what is left is the same wherever the square stood.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from postproc.calibrate import square
from postproc.machine.chain import XYZ

if TYPE_CHECKING:
    from postproc.calibrate.calibration import Calibration


def slope(line: np.ndarray, value: np.ndarray, kind: str) -> float:
    """rad: of the reference line of values (N,) mm at positions (N,) mm; kind: as Options.line."""
    if kind == "end-points":
        first, last = int(np.argmin(line)), int(np.argmax(line))
        return float((value[last] - value[first]) / (line[last] - line[first]))
    return float(np.polyfit(line, value, 1)[0])


def of_line(
    calibration: Calibration, component: str, nodes: np.ndarray, at: Mapping[str, float]
) -> float:
    """rad: slope that the tables give a straightness (EXZ: X read while Z moves over nodes (N,) mm)
    with the other axes at `at`, mm (0 where none is named)."""
    # in the mean of both directions, as a line is laid through means
    machine, kind = calibration.machine, calibration.options.line
    position = machine.at({**at, component[2]: nodes}, len(nodes))
    off = machine.deviation(position, np.zeros_like(position))
    return slope(nodes, off[machine.letters.index(component[1])], kind)


def opened(calibration: Calibration, name: str, at: Mapping[str, float]) -> float:
    """rad: what the tables add to a squareness for who measures it with the axes at `at`, mm."""
    a, b = tuple(square.pair_of(name))
    lines = [
        of_line(calibration, f"E{other}{moving}", _nodes(calibration, moving), at)
        for moving, other in ((a, b), (b, a))
    ]
    return square.sign(name) * sum(lines)


def farthest(calibration: Calibration, name: str) -> float:
    """rad: the largest `opened` among the corners of the travel."""
    axes = [x for x in calibration.options.chain.axes if x in XYZ]
    corners = itertools.product(*(calibration.travel(x) for x in axes))
    return max(abs(opened(calibration, name, dict(zip(axes, c, strict=True)))) for c in corners)


def known_to(calibration: Calibration, name: str, at: Mapping[str, float], moving: str) -> float:
    """rad: standard uncertainty that the angles of the axes at rest bring to the slope along
    `moving`."""
    total = 0.0
    for x in calibration.options.chain.axes:
        angle = calibration.components.get(f"E{name[0]}{x}")
        arm = calibration.options.chain.arm(x, calibration.optics.get(x, ""))
        # an angle of x acts on `moving` where x carries it: the other axes' angles do not turn its
        # line
        if angle is not None and x != moving and moving in arm:
            u = np.nan_to_num(angle.u).max(axis=0)
            # u of the angle where its axis stood: the larger of both directions
            total += float(np.interp(at.get(x, 0.0), angle.nodes, u)) ** 2
    return total**0.5


def _nodes(calibration: Calibration, letter: str) -> np.ndarray:
    if letter in calibration.axes():
        return calibration.nodes(letter)
    return np.array(calibration.travel(letter))
