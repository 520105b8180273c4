"""How fast the axes of a machine can go: velocity, acceleration and jerk of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from postproc.machine.model import Machine

SLIDES, ROTARY = "XYZ", "ABC"
VELOCITY = 10_000.0 / 60.0  # mm/s and degrees/s, where the machine states none
ACCELERATION = 1000.0  # mm/s2 and degrees/s2, where the machine states none


@dataclass(frozen=True)
class Limits:
    """(A,) of each axis: velocity mm/s, acceleration mm/s2, jerk mm/s3 (inf: none; degrees for
    rotary axes). assumed: the axes whose velocity or acceleration is not stated."""

    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    assumed: tuple[str, ...] = ()

    @property
    def smooth(self) -> bool:
        """Whether any jerk is limited."""
        return bool(np.isfinite(self.jerk).any())

    def tiled(self, extra: int) -> Limits:
        """The same with axes behind them that are no slides and bound nothing."""
        # a printer's E: a place that goes along and bounds nothing
        more = np.full(extra, np.inf)
        return replace(
            self,
            velocity=np.append(self.velocity, more),
            acceleration=np.append(self.acceleration, more),
            jerk=np.append(self.jerk, more),
        )


def of(machine: Machine, stated: Mapping[str, Mapping[str, Any]]) -> Limits:
    """The limits that the [axes.X] sections of a machine.toml state: max_velocity mm/min,
    max_acceleration mm/s2, max_jerk mm/s3 (degrees for rotary axes). stated: axis to its
    section."""
    rows, assumed = [], []
    for x in machine.letters:
        section = stated.get(x, {})
        if x not in SLIDES + ROTARY:
            rows.append((np.inf, np.inf, np.inf))
            continue
        if "max_velocity" not in section or "max_acceleration" not in section:
            assumed.append(x)
        rows.append(
            (
                float(section.get("max_velocity", VELOCITY * 60.0)) / 60.0,
                float(section.get("max_acceleration", ACCELERATION)),
                float(section.get("max_jerk", np.inf)),
            )
        )
    velocity, acceleration, jerk = np.array(rows).T
    return Limits(velocity, acceleration, jerk, tuple(assumed))
