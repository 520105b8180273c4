"""What moves the tool tip beyond the geometric tables. One file an effect, found by its name.

A module holds PARAMETERS (name with unit to meaning), USE ("compensate", "simulate" or "recording") and
`deviation(pose, axis, **parameters) -> (3, N)` in mm.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from types import ModuleType

import numpy as np


@dataclass(frozen=True)
class Pose:
    """All that an effect may see. position, approach: axis letter to (N,), mm and -1..+1."""

    position: dict[str, np.ndarray]
    approach: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(next(iter(self.position.values())))


def names() -> list[str]:
    """The effects that there are."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def load(name: str) -> ModuleType:
    """The effect's module. Raises KeyError for a name that there is not."""
    if name not in names():
        raise KeyError(name)
    return importlib.import_module(f"{__name__}.{name}")
