"""Laser interferometer: displacement along a direction (positioning of one axis, a diagonal of
several), captured at rest."""

from __future__ import annotations

import numpy as np

from postproc.simulate.actual import Reality
from postproc.simulate.instruments import Settings, Signal, channel_names
from postproc.simulate.instruments import _targets as targets

TITLE = "laser interferometer"
SETTINGS = {**targets.SETTINGS, "along": "Z or X1,Z3: direction of the beam (along the travel)"}


def measure(reality: Reality, settings: Settings) -> Signal:
    """um along the beam at every rest."""
    found = targets.captures(reality, settings)
    vector = targets.direction(found, settings)
    state = targets.along(found, vector)
    line, space = reality.reading(state, ("laser",))
    error = reality.error(state, ("tool",), found.piece) + space
    columns = found.columns()
    columns["reading_um"] = (vector @ error + line) * 1e3
    columns["feed_mm_min"] = found.feed
    if np.isnan(found.feed).all():
        del columns["feed_mm_min"]
    return Signal(
        "targets", targets.head(found, vector, "displacement", TITLE), columns, {"reading_um": 1.0},
        state, channel_names(state),
    )  # fmt: skip
