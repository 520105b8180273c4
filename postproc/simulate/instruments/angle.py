"""Angular optics or a level: rotation of the axis that travels, about a direction, captured at
rest.

The rotation is the one of that axis' table, and what effects turn it by.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.errors import GcompError
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, channel_names
from postproc.simulate.instruments import _targets as targets

TITLE = "angular interferometer"
SETTINGS = {
    **targets.SETTINGS,
    "about": "Y: axis of the rotation (Y, where Z or X travels; X, where Y does)",
}


def measure(reality: Reality, settings: Settings) -> Signal:
    """urad at every rest. Raises GcompError where no axis travels, UsageError for no direction."""
    found = targets.captures(reality, settings)
    if not found.moving:
        raise GcompError(
            "the axes never move between two captures: whose angle?", "a program that travels"
        )
    moving = found.moving[0]
    vector = settings.direction("about")
    if vector is None:
        vector = np.array([float(x == ("X" if moving == "Y" else "Y")) for x in "XYZ"])
    turned = found.state.angles.get(moving, np.zeros((3, len(found.piece))))
    # effects give these rows rad instead of mm (State.turned)
    angular = replace(found.state, turned=np.ones(len(found.piece), bool))
    turned = turned + reality.error(angular, ("angle",), found.piece, tables=False)
    columns = found.columns()
    columns["reading_urad"] = vector @ turned * 1e6
    head = {
        "instrument": TITLE, "quantity": "angle",
        "sensitive": {x: float(v) for x, v in zip("XYZ", vector, strict=True) if v},
    }  # fmt: skip
    return Signal(
        "targets", head, columns, {"reading_urad": 1.0}, found.state, channel_names(found.state)
    )
