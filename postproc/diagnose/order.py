"""Rows in the order of time, from which side each place was reached, and the numbers of parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.errors import Place
from postproc.machine.chain import XYZ
from postproc.recordings import Recording, RecordingError

# of the steps within runs: then it is no disorder but a column that runs the other way
BACKWARDS = 0.9
# of the samples of a motion have the time of the one before: it was written too coarsely for them
COARSE = 0.05
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
    # a table by targets: the runs stand beside each other
    mixed = np.count_nonzero(~within) >= len(np.unique(run)) and bool(np.any(step < 0))
    back = (within | mixed) & (step < 0)
    notice = ""
    if back.any():
        first = int(np.flatnonzero(back)[0])
        if not mixed and back.sum() > BACKWARDS * max(int(within.sum()), 1):
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
    notice = "; ".join(filter(None, [notice, _anew(time, run)]))
    copy = _copies(recording, time, run)
    alike = np.count_nonzero((np.diff(time) == 0) & (np.diff(run) == 0) & ~copy[1:])
    if recording.kind != "targets" and alike > COARSE * len(time):
        # there a row that is as the one before is a sample of an axis that rests
        said = f"{alike} samples have the time of the one before: they are taken at even distances"
        spread = replace(recording, columns=recording.columns | {"t_s": _spread(time, run)})
        return spread, recording.lines[:0], "; ".join(filter(None, [notice, said]))
    return (
        (recording.pick(~copy), recording.lines[copy], notice)
        if copy.any()
        else (recording, recording.lines[copy], notice)
    )


def _anew(time: np.ndarray, run: np.ndarray) -> str:
    """What is told of a clock that begins anew with a run."""
    first = np.flatnonzero((np.diff(run) != 0) & (np.diff(time) < 0)) + 1
    if not len(first):
        return ""
    more = f" and {len(first) - 1} more" if len(first) > 1 else ""
    return (
        f"t_s begins anew in run {run[first[0]]:g}{more}: runs seem to be at the same time, and"
        " what comes with time (heat, drift) may get another name; t_s counts from the start of"
        " the experiment"
    )


def _copies(recording: Recording, time: np.ndarray, run: np.ndarray) -> np.ndarray:
    """(N,) bool: rows that are the same in every column as the one before."""
    copy = np.concatenate([[False], (np.diff(time) == 0) & (np.diff(run) == 0)])
    for value in recording.columns.values() if copy.any() else ():
        same = value[1:] == value[:-1]
        if value.dtype != object:
            # two empty fields are the same reading, too: NaN == NaN is false
            same = same | (np.isnan(value[1:]) & np.isnan(value[:-1]))
        copy[1:] &= same
    return copy


def _spread(time: np.ndarray, run: np.ndarray) -> np.ndarray:
    """(N,) s: times that were written too coarsely for their samples: of each run on a line where
    that is as good as they are written, else evenly from one time to the next."""
    result = time.astype(float)
    for own in np.split(np.arange(len(time)), np.flatnonzero(np.diff(run) != 0) + 1):
        stamps, at, many = np.unique(time[own], return_inverse=True, return_counts=True)
        if len(stamps) < 2:
            continue
        step = float(np.median(np.diff(stamps)))
        number = np.arange(len(own))
        line = np.polyval(np.polyfit(number, time[own], 1), number)
        if np.abs(line - time[own]).max() < step:
            result[own] = line
            continue
        gap = np.minimum(np.append(np.diff(stamps), step), step)
        first = np.cumsum(many) - many
        result[own] = time[own] + (gap / many)[at] * (number - first[at])
    return result


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


def parts(names: np.ndarray) -> np.ndarray:
    """(N,) numbers of parts: their own, 0 where none is written; where one of them is no number
    they are counted from 1 in the order in which they come."""
    said = [str(name).strip() for name in names]
    own = _own_numbers(said)
    if own is not None:
        return own
    each = {name: float(k) for k, name in enumerate(dict.fromkeys(said), 1)}
    return np.array([each[name] for name in said])


def _own_numbers(said: list[str]) -> np.ndarray | None:
    try:
        numbers = np.array([float(name or 0) for name in said])
    except ValueError:
        return None
    return None if np.isinf(numbers).any() else np.nan_to_num(numbers)


def named_parts(names: np.ndarray) -> str:
    """What is told of parts that have names; "" where they have numbers."""
    said = [str(name).strip() for name in names]
    if _own_numbers(said) is not None:
        return ""
    each = [f"{name} = {k}" for k, name in enumerate(list(dict.fromkeys(said))[:3], 1)]
    return f"parts have names: they are counted in the order of the rows, {', '.join(each)}"
