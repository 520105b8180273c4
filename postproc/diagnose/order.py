"""Rows in the order of time, and from which side each place was reached."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.errors import Place
from postproc.machine.chain import XYZ
from postproc.recordings import Recording, RecordingError

# of the steps within runs: then it is no disorder but a column that runs the other way
BACKWARDS = 0.9
AGAINST = 0.2  # of the steps of each way may contradict their sign of approach


def by_time(recording: Recording) -> tuple[Recording, np.ndarray, str]:
    """The rows in order, the lines of rows that were copies, and what was done, or "". Without
    times the order is the file's.

    Raises RecordingError where time stands still or runs backwards.
    """
    time = recording.columns.get("t_s")
    if time is None or len(time) < 3:
        return recording, np.zeros(0, int), ""
    run = recording.columns.get("run", np.zeros(len(time)))
    within = np.diff(run) == 0
    step = np.diff(time)
    if np.ptp(time) == 0:
        if recording.kind != "targets":
            raise RecordingError(
                f"t_s = {time[0]:g} in all {len(time)} rows", "samples in motion need their times",
                Place(recording.file, int(recording.lines[0])),
            )  # fmt: skip
        # Targets at rest can do without times, in the order of the file; of samples in motion every
        # velocity would be wrong.
        columns = {k: v for k, v in recording.columns.items() if k != "t_s"}
        return (
            replace(recording, columns=columns),
            np.zeros(0, int),
            f"t_s = {time[0]:g} in all rows: not used",
        )
    back = within & (step < 0)
    notice = ""
    if back.any():
        first = int(np.flatnonzero(back)[0])
        if back.sum() > BACKWARDS * max(int(within.sum()), 1):
            raise RecordingError(
                f"t_s runs backwards: {time[first + 1]:g} after {time[first]:g}, and so on",
                "rows stand in the order in which they were taken, and t_s counts up",
                Place(recording.file, int(recording.lines[first + 1])),
            )
        recording = recording.pick(_order(time, run))
        notice = (
            f"rows are not in the order of t_s ({int(back.sum())} steps back, the first in line"
            f" {int(recording.lines.min()) + first + 1}): they were put in order"
        )
        time, run = recording.columns["t_s"], recording.columns.get("run", np.zeros(len(time)))
    copy = np.concatenate([[False], (np.diff(time) == 0) & (np.diff(run) == 0)])
    for value in recording.columns.values() if copy.any() else ():
        same = value[1:] == value[:-1]
        if value.dtype != object:
            # two empty fields are the same reading, too: NaN == NaN is false
            same = same | (np.isnan(value[1:]) & np.isnan(value[:-1]))
        copy[1:] &= same
    return (
        (recording.pick(~copy), recording.lines[copy], notice)
        if copy.any()
        else (recording, recording.lines[copy], notice)
    )


def _order(time: np.ndarray, run: np.ndarray) -> np.ndarray:
    """(N,) indices: run after run, each by its time; runs as they follow each other in time, or in
    the file where they overlap."""
    numbers, first, which = np.unique(run, return_index=True, return_inverse=True)
    low = np.array([time[which == k].min() for k in range(len(numbers))])
    high = np.array([time[which == k].max() for k in range(len(numbers))])
    # Clocks may begin anew with each run, and then all runs overlap: their times put them in no
    # order.
    by_start = np.argsort(low)
    apart = bool(np.all(high[by_start][:-1] <= low[by_start][1:]))
    rank = np.empty(len(numbers))
    rank[by_start if apart else np.argsort(first)] = np.arange(len(numbers))
    return np.lexsort((time, rank[which]))


def approaches(recording: Recording) -> tuple[Recording, list[str]]:
    """Targets with the side of each approach: from the order of the targets where it was not
    recorded.

    Raises RecordingError where the recorded sides contradict the order.
    """
    notices = []
    columns = dict(recording.columns)
    for letter in (x for x in recording.axes if x in XYZ):
        place, side = recording.position(letter), recording.approach(letter)
        step = np.concatenate([[0.0], np.diff(place)])
        way = np.where(np.abs(step) > 1e-6, np.sign(step), 0.0)
        if not way.any():
            continue
        if not side.any():
            columns[f"approach_{letter}"] = _from_steps(way)
            notices.append(
                f"approach_{letter} was not recorded: taken from the order of the targets"
            )
            continue
        wrong = (way != 0) & (side != 0) & (way != side)
        up, down = wrong & (way > 0), wrong & (way < 0)
        # Contradictions one way alone are no disorder: targets may have been passed before they
        # were approached from the stated side, or all approached from one.
        if up.sum() > AGAINST * max((way > 0).sum(), 1) and down.sum() > AGAINST * max(
            (way < 0).sum(), 1
        ):
            k = int(np.flatnonzero(wrong)[0])
            raise RecordingError(
                f"approach_{letter} = {side[k]:+g}, and {letter} comes from {place[k - 1]:g} to"
                f" {place[k]:g} mm; {int(wrong.sum())} of {int((way != 0).sum())} rows are so",
                "rows stand in the order in which they were taken; approach is the sign of the last"
                " move",
                Place(recording.file, int(recording.lines[k])),
            )
        if np.ptp(side) == 0 and min((way > 0).sum(), (way < 0).sum()) > AGAINST * (way != 0).sum():
            notices.append(
                f"approach_{letter} is {side[0]:+g} in all rows, and the targets go both ways: it"
                " is believed, what differs with the direction can not be seen"
            )
    return replace(recording, columns=columns), notices


def _from_steps(way: np.ndarray) -> np.ndarray:
    """(N,) sign of the last move; of a place that was not left, that of the next one: it was
    overrun before the turn."""
    result = way.copy()
    for k in range(len(way) - 2, -1, -1):
        if result[k] == 0:
            result[k] = result[k + 1]
    for k in range(1, len(way)):
        if result[k] == 0:
            result[k] = result[k - 1]
    return result
