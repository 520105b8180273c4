"""The machine as motions of a space need it: as the slides, the tool tip or the face see it."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from postproc.machine import poses
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.machine.polar import PolarMachine
from postproc.machine.tip import TipMachine
from postproc.spaces import Space


def seen_in(machine: Machine, length: np.ndarray, space: Space | None, oriented: bool) -> Machine:
    """The machine with a tool of length (A,) mm, as motions of a space need it; without a space it
    is the machine itself. In a space no axis has a table, a travel or a side of its own: those are
    the slides'."""
    base = poses.with_length(machine, length)
    if space is None:
        return base
    given = {f.name: getattr(base, f.name) for f in fields(Machine)}
    letters = (*XYZ, "C") if space.polar else tuple(XYZ)
    travel = {x: (-np.inf, np.inf) if x in letters else a.travel for x, a in base.axes.items()}
    axes = {x: replace(a.bare, travel=travel[x], uncertainty=None) for x, a in base.axes.items()}
    given |= {"axes": axes, "square": {}, "effects": ()}
    given |= {"base": base, "anchor": machine.tool, "space": space}
    if space.polar:
        return PolarMachine(**given)
    return TipMachine(**given, oriented=oriented and space.held)
