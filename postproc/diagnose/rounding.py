"""How coarsely a log rounds its positions, and what that does to readings.

A log has a fixed number of decimals or of significant digits; with the latter a position above 100
mm may be known to 1 mm and one below 10 mm to 0.01. Rounding by q is an error of q / sqrt(12), the
same one as long as the axis stays within q.
"""

from __future__ import annotations

import numpy as np

MOST_DIGITS = 6  # significant digits that are still a rounding worth to be looked for
FEW = 3  # values: fewer tell no rounding, an axis that stands at 205 mm may be known to 0.1 um
HEAD = 1000  # values that are looked at first: most are told by them
COARSE = 2e-3  # mm: finer rounding is lost in what else scatters


def step(values: np.ndarray) -> np.ndarray:
    """(N,) by how much each value is rounded, in its unit; 0 where values have more than six
    significant digits."""
    known = np.abs(values[np.isfinite(values) & (values != 0)])
    if len(np.unique(known[:HEAD])) < FEW and len(np.unique(known)) < FEW:
        return np.zeros(len(values))
    for digits in range(1, MOST_DIGITS + 1):
        # 205.3 and 4.7 at four digits: scale is the last digit's unit of each value, 0.1 and 0.001
        if _has_digits(known[:HEAD], digits) and _has_digits(known, digits):
            size = np.maximum(np.abs(values), known.min())
            by_digits = 10.0 ** (np.floor(np.log10(size) + 1e-12) - digits + 1)
            step: np.ndarray = np.maximum(by_digits, _decimals(known))
            return step
    unit = _decimals(known)
    return np.full(len(values), unit if unit > 1e-6 else 0.0)


def _has_digits(known: np.ndarray, digits: int) -> bool:
    """Whether no value has more significant digits."""
    scale = 10.0 ** (np.floor(np.log10(known) + 1e-12) - digits + 1)
    return bool(np.all(np.abs(known / scale - np.round(known / scale)) < 1e-6))


def _decimals(known: np.ndarray) -> float:
    """The power of ten that all values are multiples of; 0 where there is none down to 1e-6."""
    for power in range(1, -7, -1):
        unit = 10.0**power
        if _multiples(known[:HEAD], unit) and _multiples(known, unit):
            return unit
    return 0.0


def _multiples(known: np.ndarray, unit: float) -> bool:
    off = np.abs(known / unit - np.round(known / unit))
    return bool(np.all(off < 1e-6 * max(1.0, 1e-6 / unit)))


def noise(commanded: np.ndarray, actual: np.ndarray) -> np.ndarray:
    """(N,) standard deviation that rounding gives to actual minus commanded. A log writes both with
    one format: commanded places that are multiples of more than actual ones are so by the program
    (20 mm/s every 20 ms: 0.4 mm)."""
    read = step(actual)
    noise: np.ndarray = np.hypot(np.minimum(step(commanded), read), read) / np.sqrt(12.0)
    return noise


def alike(commanded: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(N,) bool: samples that a coarse log can not tell from the one before: all of such a row
    together are one reading."""
    same = np.diff(commanded, prepend=commanded[:1]) == 0
    same[:1] = False
    alike: np.ndarray = same & (noise > COARSE)
    return alike
