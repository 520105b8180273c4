"""The way down a hole of a canned cycle, along which X and Y are held: what corrects each place of
it, and how far one command can."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from postproc.compensate.columns import Columns
from postproc.compensate.inverse import command
from postproc.machine.model import Machine
from postproc.machine.tip import TipMachine
from postproc.motions import Holes
from postproc.units import TICKS_PER_MM

DEPTHS = 33  # places down a hole that lies along no slide


class Axis(NamedTuple):
    """A hole's axis. across: rows of the axes that are held; middle (len(across),): mm that
    corrects them for the middle; bend: mm that the axis stays off that middle; depth: mm that
    corrects the bottom."""

    across: list[int]
    middle: np.ndarray
    bend: float
    depth: float


def down(b: Columns, k: int, side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two (A, K) mm, wanted and commanded, down hole k of a batch that is reached with sides
    (A, 1)."""
    holes = b.m.holes
    if (found := b.downs.get(asked := (k, side.tobytes()))) is not None:
        return found
    target = depths(b.machine, holes, k, b.end_nominal[:, b.hole[k]])
    weight = weights(b.c.follows, holes, k, side, target.shape[1])
    exact = command(b.machine, target, weight, np.full(target.shape[1], holes.motion[k]))
    b.downs[asked] = target, exact
    return target, exact


def axis_of(machine: Machine, exact: np.ndarray, target: np.ndarray, row: int) -> Axis:
    """Of the (A, K) mm commanded and wanted down a hole along axis `row`."""
    across = [r for r in machine.corrected if r != row]
    aside = (exact - target)[across]
    low, high = aside.min(axis=1, initial=np.inf), aside.max(axis=1, initial=-np.inf)
    bend = float(np.linalg.norm((high - low) / 2)) if across else 0.0
    return Axis(across, (low + high) / 2, bend, float(exact[row, -1] - target[row, -1]))


def depths(machine: Machine, holes: Holes, k: int, place: np.ndarray) -> np.ndarray:
    """(A, K) mm down hole k at `place` (A,), from R to the bottom with every node between."""
    row = int(holes.axis[k])
    top, bottom = holes.level[k] / TICKS_PER_MM, holes.bottom[k] / TICKS_PER_MM
    inner = np.unique(np.concatenate([np.zeros(0), *machine.knots.get(machine.letters[row], [])]))
    if isinstance(machine, TipMachine):  # it passes nodes of several slides: looked at all along
        inner = np.linspace(min(top, bottom), max(top, bottom), DEPTHS)
    inner = inner[(inner > min(top, bottom)) & (inner < max(top, bottom))]
    depth = np.concatenate([[top], inner if bottom > top else inner[::-1], [bottom]])
    target = np.repeat(place[:, None], len(depth), axis=1)
    target[row] = depth
    return target


def weights(follows: bool, holes: Holes, k: int, sides: np.ndarray, count: int) -> np.ndarray:
    """(A, S * count) approach at `count` places down hole k: `sides` (A, S), but for the axis that
    drills."""
    weight = np.repeat(sides, count, axis=1)
    if follows:
        weight[holes.axis[k]] = np.sign(holes.bottom[k] - holes.level[k])
    return weight
