"""Runs that lie above each other in order of time: the set-up drifted, and the scatter contains it
(ISO 230-3)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.calibrate import Finding
from postproc.calibrate.assign import Series, unit_of
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.statistics import cells_of

TIMES = 5.0


def check(calibration: Calibration) -> Iterator[Finding]:
    for name, component in calibration.measured.items():
        for series in component.series:
            yield from _drift(name, series)


def _drift(name: str, series: Series) -> list[Finding]:
    cells = cells_of(series.position, series.approach, series.reading)
    used = cells.index >= 0
    runs = np.unique(series.run[used])
    if len(runs) < 3:
        return []
    k = len(cells.nodes)
    mean = cells.mean.ravel() if cells.two_way else cells.mean[0]
    left = series.reading - mean[np.minimum(cells.index, 2 * k - 1)]
    height = np.array([left[used & (series.run == r)].mean() for r in runs])
    within = np.concatenate(
        [left[used & (series.run == r)] - h for r, h in zip(runs, height, strict=True)]
    )
    # scatter of the mean of one run: that within the runs by the root of readings a run
    each = float(
        np.sqrt(within @ within / max(1, len(within) - len(runs)) / (len(within) / len(runs)))
    )
    unit, one = unit_of(name)
    span = float(np.ptp(height))
    if each == 0 or span < TIMES * each * np.sqrt(2) or span / one < 0.2:
        return []
    text = (
        f"{series.file}: the {len(runs)} runs of {name} lie up to {span / one:.1f} {unit} apart as"
        f" wholes ({span / each:.0f} times their own scatter): the set-up drifted, and u"
        " contains it"
    )
    return [Finding("drift", "doubt", name, text, {f"apart_{unit}": span / one})]
