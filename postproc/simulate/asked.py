"""What a test is asked for, and the program that it becomes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from postproc.errors import UsageError

GOLDEN = 0.6180339887498949
MOST = 100_000  # targets


@dataclass(frozen=True)
class Test:
    """A program, the instrument that it is meant for, and how that is to be set."""

    __test__ = False

    text: str
    instrument: str
    settings: dict[str, str]
    title: str


@dataclass(frozen=True)
class Ask:
    """What --test says: the axes, and key=value."""

    axes: str
    given: Mapping[str, float]

    def of(self, key: str, default: float) -> float:
        """A setting, mm, s or mm/min. Raises UsageError for one that must be above zero."""
        value = self.given.get(key, default)
        if (
            key
            in (
                "feed",
                "dwell",
                "step",
                "radius",
                "rate",
                "hours",
                "period",
                "overrun",
                "way",
                "slow",
            )
            and value <= 0
        ):
            raise UsageError(f"{key} = {value:g} is not above zero")
        return value

    def count(self, key: str, default: int) -> int:
        """A whole number of 1 to 10,000. Raises UsageError for another."""
        value = self.given.get(key, default)
        if value != int(value) or not 1 <= value <= 10_000:
            raise UsageError(f"{key} = {value:g} is no number of 1 to 10000")
        return int(value)


def targets(low: float, high: float, step: float, even: bool) -> np.ndarray:
    """Places of targets: at even steps, or each moved by up to a quarter of a step, as ISO 230-2
    wants it, so that no period of a screw stays hidden."""
    if (high - low) / step > MOST:
        raise UsageError(
            f"{high - low:g} mm in steps of {step:g} mm are more than {MOST:,} targets",
            "a larger step",
        )
    number = max(round((high - low) / step), 2)
    places = low + (high - low) * np.arange(number + 1) / number
    if even:
        return np.round(low + step * np.arange(int((high - low) / step + 1e-9) + 1), 4)
    # By up to a quarter of a step either way, by multiples of the golden section: targets lie at
    # unlike phases of any period, and the same test has the same targets every time.
    moved = places + 0.5 * ((np.arange(number + 1) * GOLDEN) % 1.0 - 0.5) * (high - low) / number
    moved[0], moved[-1] = low, high
    return np.round(moved, 3)
