"""Which readings take no part in naming and fitting: a run that was asked for, or the middle one of
those that were repeated."""

from __future__ import annotations

import numpy as np

from postproc.diagnose.rows import Rows
from postproc.errors import UsageError
from postproc.recordings import Recording

DRIVERS = ("force_", "load_", "spindle_rpm")


def of(rows: Rows, wanted: str, recordings: list[Recording]) -> tuple[np.ndarray, str]:
    """(N,) which rows take no part, and what they are called."""
    held = np.zeros(len(rows), bool)
    if wanted:
        name, _, value = wanted.partition("=")
        if name != "run" or not value.lstrip("-").isdigit():
            raise UsageError(f"--holdout {wanted} is not understood", "--holdout run=3")
        held = rows.run == int(value)
        if not held.any() or held.all():
            raise UsageError(
                f"--holdout {wanted}: there is"
                f" {'nothing' if not held.any() else 'no other run than'} {wanted}"
            )
        return held, f"run {int(value)}"
    # The middle run and not the last: heat and wear go on after all that was fitted, and a run
    # there would judge how far they go on, not whether the names are right. --holdout asks for
    # another.
    said = []
    for file in range(len(rows.files)):
        which = rows.file == file
        runs = np.unique(rows.run[which])
        if rows.kinds[file] == "features":
            again = _last_readings(rows, file, recordings[file])
            if again.any():
                held |= again
                said.append("the last reading of every feature")
        # with two, one would be left: nothing tells what scatters from run to run
        elif len(runs) >= 3:
            held |= which & (rows.run == _between_others(rows, which, runs))
            said.append("the middle run of every recording that has three at least")
    return held, ", ".join(dict.fromkeys(said))


def _between_others(rows: Rows, which: np.ndarray, runs: np.ndarray) -> float:
    """The run of a recording (rows `which`) that the others predict: in the middle, for heat and
    wear lie there between what is known, and under no load or spindle speed that no other run
    had."""
    drivers = [v for name, v in rows.state.channels.items() if name.startswith(DRIVERS)]

    def alone(run: float) -> bool:
        own, others = which & (rows.run == run), which & (rows.run != run)
        return any(
            v[own].min() > v[others].max() or v[own].max() < v[others].min() for v in drivers
        )

    middle = len(runs) // 2
    # of 1 2 3 4 5: 3 2 4 1 5
    order = sorted(runs, key=lambda run: abs(int(np.searchsorted(runs, run)) - middle))
    return float(next((run for run in order if not alone(run)), runs[middle]))


def _last_readings(rows: Rows, file: int, recording: Recording) -> np.ndarray:
    """(N,) bool: the last reading of features that were all read three times on each part; none
    else."""
    reading = recording.columns.get("reading")
    own = np.flatnonzero(rows.file == file)
    result = np.zeros(len(rows), bool)
    if reading is None or len(recording.lines) != len(recording) or not len(own):
        return result
    number = dict(zip(recording.lines.tolist(), reading.tolist(), strict=True))
    read = np.array([number.get(int(k), np.nan) for k in rows.line[own]])
    each = {
        (s, r): set(read[(rows.signal[own] == s) & (rows.run[own] == r)])
        for s, r in zip(rows.signal[own], rows.run[own], strict=True)
    }
    if min(len(values) for values in each.values()) >= 3 and np.isfinite(read).all():
        # of readings at one place of one part: the others say all of it but the noise
        result[own[read == read.max()]] = True
    return result
