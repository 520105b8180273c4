"""How far an instrument's zero goes from one run to the next: where there are many runs, they say so themselves."""

from __future__ import annotations

import numpy as np

FEWEST = 10  # runs
LEAST = 0.25  # of what is usual: less is believed of none
MAD = 1.4826


def of_runs(residual: np.ndarray, run: np.ndarray, place: np.ndarray, usual: float) -> float:
    """mm (standard deviation) of a run's own zero, no more than usual; usual where the runs are too few to tell.

    From second differences of the means of successive runs, by their median: what comes slowly is not in them, and what comes
    at once is in few. What the readings of a run scatter by is taken off. residual, run, place: (N,) of one recording; runs that
    do not visit the same places are not compared.
    """
    runs, number = np.unique(run, return_inverse=True)
    if len(runs) < FEWEST:
        return usual
    for p in np.unique(place):
        same = place == p
        residual = np.where(same, residual - np.median(residual[same]), residual)
    count = np.bincount(number)
    mean = np.bincount(number, residual) / count
    scatter = (
        MAD * float(np.median(np.abs(residual - mean[number]))) * np.sqrt(count.mean() / max(count.mean() - 1, 1.0))
    )
    step = MAD * float(np.median(np.abs(np.diff(mean, 2)))) / np.sqrt(6.0)
    return float(np.clip(np.sqrt(max(step**2 - scatter**2 / count.mean(), 0.0)), LEAST * usual, usual))
