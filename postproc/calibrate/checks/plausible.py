"""Is a component as large as such things are? A factor of a thousand is a unit, not a machine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import place_name, unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component

# What readings of machine tools span, um or urad over the travel: a screw of the cheapest kind
# strays 500 um in 300 mm (ISO 3408-3, class 10: 210 um), a slide that turns by 2 mrad would rattle,
# and no instrument resolves 0.02 um or urad.
LARGEST = {"um": 2000.0, "urad": 2000.0}
LEAST = 0.02
INCH_MM = 25.4


def check(calibration: Calibration) -> Iterator[Finding]:
    for name, component in calibration.measured.items():
        unit, one = unit_of(name)
        raw = component.cells.mean[np.isfinite(component.cells.mean)] / one
        span = float(np.ptp(raw))
        if 0 < span < LEAST:
            likely = "mm" if unit == "um" else "mm/m (mrad) or degrees"
            text = (
                f"{name} spans {span:.3g} {unit} in all: less than an instrument resolves. Are the"
                f" readings {likely}?"
            )
        elif span > LARGEST[unit]:
            likely = (
                "um read as mm, nm, or increments of a counter"
                if unit == "um"
                else "um/m times the length, or nrad"
            )
            text = (
                f"{name} spans {span:,.0f} {unit}: more than a machine tool strays. Are the"
                f" readings {likely}?"
            )
        elif span == 0:
            text = f"{name} is {raw[0]:g} {unit} at every target: was anything recorded?"
        else:
            yield from _positions(calibration, component)
            continue
        yield Finding("unit", "doubt", name, text, {f"span_{unit}": span})


def _positions(calibration: Calibration, component: Component) -> list[Finding]:
    """Positions in inches or in diameters, where a travel is stated."""
    if component.letter not in calibration.options.travel:
        return []
    low, high = calibration.options.travel[component.letter]
    reach, largest = max(abs(low), abs(high)), float(np.abs(component.nodes).max())
    unit = place_name(component.letter)
    numbers = {f"largest_{unit}": largest, f"travel_{unit}": reach}
    diameter = component.letter in calibration.options.diameter
    # up to twice the travel, and 1 % for what the tables stretch beyond it
    if diameter and reach < largest <= 2.02 * reach:
        text = (
            f"targets of {component.name} reach {largest:g} mm, the travel {reach:g}: are they"
            " diameters? Slide positions (radius) are wanted"
        )
        return [Finding("unit", "doubt", component.name, text, numbers)]
    if unit == "mm" and largest * INCH_MM <= 1.02 * reach and largest < reach / 10:
        text = (
            f"targets of {component.name} reach {largest:g}, the travel {reach:g} mm: are they"
            " inches?"
        )
        return [Finding("unit", "doubt", component.name, text, numbers)]
    return []
