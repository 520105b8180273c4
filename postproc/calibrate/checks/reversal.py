"""One column for two directions: half the reversal is left in each, and which half depends on the
program."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import unit_of
from postproc.calibrate.calibration import Calibration

WORTH = 1.0  # um or urad: less than this no control takes up


def check(calibration: Calibration) -> Iterator[Finding]:
    for name, component in calibration.components.items():
        unit, one = unit_of(name)
        if not component.two_way:
            way = {1: "in + only", -1: "in - only", 0: "in a direction that is not recorded"}[
                component.cells.one_way
            ]
            text = (
                f"{name} was approached {way}: its reversal is not known, and the table holds for"
                " both directions"
            )
            yield Finding("one-way", "note", name, text)
            continue
        b = float(np.nanmax(np.abs(component.reversal))) / one
        u = component.largest_u / one if np.isfinite(component.largest_u) else 0.0
        if calibration.options.mean and b > max(WORTH, 3 * u):
            text = (
                f"{name} is written as the mean of both directions, and they differ by up to"
                f" {b:.1f} {unit}: up to {b / 2:.1f} {unit} stays, with either sign"
            )
            yield Finding("mean-map", "doubt", name, text, {f"B_{unit}": b})
