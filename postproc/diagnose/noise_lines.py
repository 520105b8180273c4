"""Sharp lines of a spectrum: an oscillation is no noise."""

from __future__ import annotations

import numpy as np

SPECTRUM = 31  # bins on either side of one
LINE = 25.0  # times the power around: an oscillation, no noise


def around(power: np.ndarray) -> np.ndarray:
    """(n,) the median power (n,) around each bin of a spectrum."""
    medians = [
        np.median(power[max(0, k - SPECTRUM) : k + SPECTRUM + 1])
        for k in range(0, len(power), SPECTRUM)
    ]
    level: np.ndarray = np.repeat(medians, SPECTRUM)[: len(power)]
    return level


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
