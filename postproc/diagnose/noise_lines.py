"""Sharp lines of a spectrum: an oscillation is no noise."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

SPECTRUM = 31  # bins on either side of one
LINE = 25.0  # times the power around: an oscillation, no noise


def around(power: np.ndarray) -> np.ndarray:
    """(n,) the median power (n,) around each bin of a spectrum."""
    at = np.arange(0, len(power), SPECTRUM)
    whole = (at >= SPECTRUM) & (at + SPECTRUM < len(power))
    medians = np.empty(len(at))
    if whole.any():
        windows = sliding_window_view(power, 2 * SPECTRUM + 1)
        medians[whole] = np.median(windows[at[whole] - SPECTRUM], axis=1)
    for k in np.flatnonzero(~whole):  # cut off at either end
        medians[k] = np.median(power[max(0, at[k] - SPECTRUM) : at[k] + SPECTRUM + 1])
    return np.repeat(medians, SPECTRUM)[: len(power)]


def without_lines(values: np.ndarray) -> np.ndarray:
    """What is left of values (n,) when the sharpest lines of their spectrum are taken out."""
    spectrum = np.fft.rfft(values)
    power = np.abs(spectrum) ** 2
    if len(power) < 2 * SPECTRUM:
        return values
    level = around(power)
    line = power > LINE * np.maximum(level, 1e-30)
    wide = line | np.concatenate([line[1:], [False]]) | np.concatenate([[False], line[:-1]])
    spectrum[wide] *= np.sqrt(np.minimum(level[wide] / np.maximum(power[wide], 1e-30), 1.0))
    return np.fft.irfft(spectrum, len(values))
