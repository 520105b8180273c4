"""Channels beside the readings (temperatures, forces, loads, speeds): what a sensor can not read is
taken as not recorded, and listed; the rows stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.diagnose import thermometers
from postproc.recordings import Recording

CHANNELS = ("T_", "force_", "load_", "spindle_rpm", "feed_mm_min")
WARM = (-60.0, 150.0)  # degrees Celsius that a sensor on a machine can read
LARGEST = 1e7  # N, rpm, mm/min

Faults = list[tuple[int, str]]  # line of the recording, and what is wrong there


# Whole: a list of faults, a condition to each.
def readable(recording: Recording) -> tuple[Recording, Faults]:
    """The recording with the channels as far as sensors can have read them; one of which nothing is
    left is gone."""
    columns = dict(recording.columns)
    faults: Faults = []
    for name, value in recording.columns.items():
        if value.dtype == object or not name.startswith(CHANNELS):
            continue
        low, high = WARM if name.startswith("T_") else (-LARGEST, LARGEST)
        bad = np.isfinite(value) & ((value < low) | (value > high))
        if bad.any():
            first = int(np.flatnonzero(bad)[0])
            columns[name] = np.where(bad, np.nan, value)
            said = (
                f"{name} = {value[first]:.4g}, which no sensor reads; {int(bad.sum())} such values"
                " are taken as not recorded"
            )
            faults.append((int(recording.lines[first]), said))
    warm = [n for n in columns if n.startswith("T_") and columns[n].dtype != object]
    if "t_s" in columns and recording.kind != "features":
        for name in warm:
            faults += _drifted(recording, columns, name)
    gone = [n for n in warm if not np.isfinite(columns[n]).any()]
    return replace(recording, columns={n: v for n, v in columns.items() if n not in gone}), faults


def _drifted(recording: Recording, columns: dict[str, np.ndarray], name: str) -> Faults:
    """Take out of a temperature what its thermometer shows wrongly in time; what was taken out."""
    faults: Faults = []
    order = np.argsort(columns["t_s"], kind="stable")
    # one fault after the other: behind the first the channel may show another
    while found := thermometers.faulty(columns[name][order], columns["t_s"][order]):
        rows = order[found[0]]
        said = f"sensor_drift: {name} {found[1]}; it is taken as not recorded"
        faults.append((int(recording.lines[rows[0]]), said))
        columns[name] = columns[name].copy()
        columns[name][rows] = np.nan
    return faults
