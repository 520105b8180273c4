"""A slide that goes beyond its command where it reverses: a turned sign, or a control that takes up
too much."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component
from postproc.machine import overshoot


def check(calibration: Calibration) -> Iterator[Finding]:
    for name, component in calibration.measured.items():
        if name != f"E{component.letter}{component.letter}" or not component.two_way:
            continue
        # reversal B is forward less reverse (ISO 230-2); lost motion reverse less forward
        lost = -component.reversal
        if text := overshoot.sentence(name, lost, _known_to(component)):
            unit, one = unit_of(name)
            numbers = {f"lost_motion_{unit}": float(np.nanmedian(lost)) / one}
            yield Finding("overshoot", "doubt", name, f"{component.file}: {text}", numbers)


def _known_to(component: Component) -> float:
    """mm or rad: U of the median over the targets from the scatter of the runs; a median of many
    has a standard error 1.25 times that of their mean."""
    if not component.cells.scatter.known:
        return 0.0
    u = component.cells.scatter.s / np.sqrt(np.maximum(component.cells.n, 1))
    return float(2 * 1.25 * np.sqrt(np.nanmean(u**2) * 2 / u.shape[1]))
