"""Straightness optics: deviation across the travel of one axis, captured at rest."""

from __future__ import annotations

import numpy as np

from postproc.errors import UsageError
from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, channel_names
from postproc.simulate.instruments import _targets as targets

TITLE = "straightness interferometer"
SETTINGS = {
    **targets.SETTINGS,
    "across": "X: direction of the deviation (the first axis that does not travel)",
}


def measure(reality: Reality, settings: Settings) -> Signal:
    """um along `across` at every rest. Raises UsageError where no axis rests."""
    found = targets.captures(reality, settings)
    vector = settings.direction("across", reality.machine.letters)
    if vector is None:
        still = [x for x in reality.machine.letters if x in "XYZ" and x not in found.moving]
        if not still:
            raise UsageError("every axis travels: across what?", "--set across=X")
        vector = np.array([float(x == still[0]) for x in "XYZ"])
    columns = found.columns()
    columns["reading_um"] = vector @ reality.error(found.state, ("tool",), found.piece) * 1e3
    return Signal(
        "targets", targets.head(found, vector, "straightness", TITLE), columns, {"reading_um": 1.0},
        found.state, channel_names(found.state),
    )  # fmt: skip
