"""A table that changes faster than the limit is a slip or a wrong unit more often than a
machine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration

WARN = 1.0  # um/mm, ours: the grinder measured for this project has 1.7 at its worst


def check(calibration: Calibration) -> Iterator[Finding]:
    for name, component in calibration.components.items():
        unit, one = unit_of(name)
        if component.angle:
            continue
        steep = np.abs(np.diff(component.value) / np.diff(component.nodes)) / one
        way, at = np.unravel_index(int(np.argmax(steep)), steep.shape)
        worst, limit = float(steep[way, at]), calibration.options.max_slope * 1e3
        # 1e-6: a slope at the limit itself, as numbers in a file often are, is not over it
        if worst <= min(WARN, limit) + 1e-6:
            continue
        mm = place_name(component.letter)
        where = (
            f"between {component.letter} = {component.nodes[at]:g} and {component.nodes[at + 1]:g}"
            f" {mm}, approached in {'+-'[way]}"
        )
        text = f"{name} changes by {worst:.2f} {unit}/{mm} {where}"
        if worst > limit:
            text += (
                f": over the limit of {limit:g} {unit}/{mm}. A slip, or a wrong unit; if it is"
                " true, --accept-slope"
            )
        yield Finding(
            "slope", "doubt", name, text, {"slope_um_per_mm": worst, "limit_um_per_mm": limit}
        )
