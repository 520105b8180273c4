"""At the ends of a two-way run the slide must go past the last target before it comes back, or
nothing is reversed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration

SHARE = 0.25  # of the reversal next to it: an end with less has probably not been reversed
LEAST = 0.3  # um or urad of difference: below it nothing is seen


def check(calibration: Calibration) -> Iterator[Finding]:
    for name, component in calibration.measured.items():
        if not component.two_way or len(component.nodes) < 5:
            continue
        unit, one = unit_of(name)
        for end, near in ((0, [1, 2, 3]), (-1, [-2, -3, -4])):
            at = f"{component.letter} = {component.nodes[end]:g} {place_name(component.letter)}"
            b = component.reversal / one
            if not np.isfinite(b[end]):
                text = (
                    f"{name}: {at} was read in one direction only (no overrun?); the reversal of"
                    " the next target is taken"
                )
                yield Finding("overrun", "doubt", name, text)
                continue
            beside = float(np.median(b[near]))
            u = component.u[:, end].max() / one
            limit = max(LEAST, 3 * (u if np.isfinite(u) else 0.0) * np.sqrt(2))
            if abs(b[end]) < SHARE * abs(beside) and abs(b[end] - beside) > limit:
                text = (
                    f"{name} reverses by {b[end]:+.1f} {unit} at {at}, and by {beside:+.1f} beside"
                    " it: was the target overrun before coming back?"
                )
                yield Finding(
                    "overrun",
                    "doubt",
                    name,
                    text,
                    {f"B_{unit}": float(b[end]), f"beside_{unit}": beside},
                )
