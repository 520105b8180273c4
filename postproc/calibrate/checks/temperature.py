"""Temperature: how much it moved while measuring, and whether a length looks like an expansion left
in or taken twice."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import Series
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.component import Component
from postproc.units import UM

WORTH_K = 0.5
ALIKE = 0.3  # share by which a slope may differ from the expansion and still look like it
REFERENCE = 20.0  # degrees Celsius, ISO 1


def check(calibration: Calibration) -> Iterator[Finding]:
    bare = []
    for name, component in calibration.measured.items():
        for series in component.series:
            columns = {
                n: c[np.isfinite(c)]
                for n, c in series.columns.items()
                if re.fullmatch(r"T_\w+_C", n)
            }
            columns = {n: c for n, c in columns.items() if len(c)}
            if not columns:
                bare.append(name)
                continue
            yield from _span(calibration, component, series, columns)
            if name == f"E{component.letter}{component.letter}":
                yield from _expansion(calibration, component, columns)
    if bare:
        text = (
            f"no temperature was recorded with {', '.join(dict.fromkeys(bare))}: what the machine"
            " grew meanwhile is not known"
        )
        yield Finding("temperature", "note", "", text)


def _span(
    calibration: Calibration, component: Component, series: Series, columns: dict[str, np.ndarray]
) -> list[Finding]:
    place, span = max(((n, float(np.ptp(c))) for n, c in columns.items()), key=lambda p: p[1])
    length = float(np.ptp(component.nodes))
    if span <= WORTH_K or component.angle or component.letter not in "XYZ":
        return []
    growth = calibration.options.expansion * span * length / UM
    text = (
        f"{series.file}: {place} changed by {span:.1f} K while {component.name} was measured; steel"
        f" grows {growth:.1f} um over {length:g} mm by that"
    )
    return [
        Finding("temperature", "doubt", component.name, text, {"span_K": span, "growth_um": growth})
    ]


def _expansion(
    calibration: Calibration, component: Component, columns: dict[str, np.ndarray]
) -> list[Finding]:
    """A slope of the size and sign of an expansion."""
    letter = component.letter
    # the axis' own scale or screw, else all thermometers there were
    own = [n for n in columns if re.search(rf"_{letter}_C$", n)] or list(columns)
    at = float(np.mean([columns[n].mean() for n in own])) - REFERENCE
    expected = calibration.options.expansion * at
    slope = component.slope
    if abs(at) < 1.0 or letter not in "XYZ" or not np.isfinite(slope):
        return []
    for sign, says in (
        (
            1.0,
            (
                "the readings look as if the expansion was not taken out: is the map meant for this"
                " temperature only?"
            ),
        ),
        (
            -1.0,
            (
                "the readings look as if it was taken out twice (the instrument had normalised them"
                " already)"
            ),
        ),
    ):
        # + expected: nobody has taken the expansion out; - expected: it was taken out twice
        if abs(slope - sign * expected) < ALIKE * abs(expected):
            text = (
                f"{component.name} has a slope of {slope * 1e6:+.1f} um/m; at {at + REFERENCE:.1f}"
                f" C steel expands by {expected * 1e6:+.1f} um/m: {says}"
            )
            return [
                Finding(
                    "expansion",
                    "doubt",
                    component.name,
                    text,
                    {"slope_um_per_m": slope * 1e6, "expansion_um_per_m": expected * 1e6},
                )
            ]
    return []
