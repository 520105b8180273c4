"""Laser interferometer and a plane mirror that the tool carries, its face towards the beam: step
diagonals.

A retroreflector loses the beam when it moves aside; a plane mirror may move aside and still sends
it back. So the place of the mirror that the beam meets wanders over its face: rotations of the
slides act there, on the beam's own line, and not at the tool's point; and a mirror that leans adds
its lean times every motion aside (Chapman, Precision Engineering 27 (2003) 401).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.errors import GcompError
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, channel_names
from postproc.simulate.instruments import _targets as targets

TITLE = "laser interferometer and plane mirror"
SETTINGS = {
    **targets.SETTINGS,
    "along": "X1,Y1,Z1: direction of the beam",
    "lean": "X20,Y-10,Z0: urad by which the mirror's normal leans away from the beam (0)",
}
XYZ = "XYZ"
PPM = 1e-6


def measure(reality: Reality, settings: Settings) -> Signal:
    """um along the beam at every rest. Raises GcompError for a beam along one axis."""
    found = targets.captures(reality, settings)
    vector = targets.direction(found, settings)
    if (np.abs(vector) > 1e-9).sum() < 2:
        raise GcompError(
            "a plane mirror is for steps along a diagonal",
            "the instrument laser, for a single axis",
        )
    state = targets.along(found, vector)
    line, space = reality.reading(state, ("laser",))
    place = np.array([state.position.get(x, np.zeros(len(found.piece))) for x in XYZ])
    way = place - place[:, :1]
    # what the stair has moved beside the beam since the first target
    aside = way - vector[:, None] * (vector @ way)
    error = _where_the_beam_meets(reality, found, -aside) + space
    lean = np.array([settings.place("lean").get(x, 0.0) for x in XYZ]) * PPM
    # only what lies across the beam turns a plane mirror out of it
    lean -= vector * (vector @ lean)
    columns = found.columns()
    columns["reading_um"] = (vector @ error + lean @ aside + line) * 1e3
    head = targets.head(found, vector, "displacement", TITLE)
    return Signal("targets", head, columns, {"reading_um": 1.0}, state, channel_names(state))


def _where_the_beam_meets(
    reality: Reality, found: targets.Captures, beside: np.ndarray
) -> np.ndarray:
    """(3, N) mm: the error of a point that is fixed to the tool, `beside` (3, N) mm from its own
    point. It goes straight with the arm, so four tools tell it."""

    def of(arm: np.ndarray) -> np.ndarray:
        machine = replace(reality.machine, tool=reality.machine.tool + arm)
        there = replace(reality, timeline=replace(reality.timeline, machine=machine))
        return there.error(found.state, ("tool",), found.piece)

    at = of(np.zeros(3))
    # a difference over the whole reach: over 1 mm it would be made of the last digits
    reach = float(np.abs(beside).max(initial=0.0)) or 1.0
    for i, unit in enumerate(np.eye(3)):
        at = at + (of(unit * reach) - of(np.zeros(3))) / reach * beside[i]
    return at
