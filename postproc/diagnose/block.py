"""One way to explain the readings: an effect on an axis, in a shape.

Its columns are as long as all rows. A dictionary has a thousand and more of them, and what a search
asks for most are products (dictionary.py), which keeps them instrument by instrument. So a block
makes its columns when it is asked, and those of a dictionary let them go when they are in it; of
those that make them again the last ones keep them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType

import numpy as np

NOTHING = 1e-12  # mm
KEPT = 64  # blocks that keep the columns that they made again


@dataclass(frozen=True)
class Block:
    """An effect, its axis, its shape, and what makes the (N, K) mm that it would add to the
    readings. siblings: shapes that it is one of; apart: of two axes, each of which shows by
    itself."""

    module: ModuleType
    axis: str
    shape: tuple[tuple[str, float], ...]
    make: Callable[[], np.ndarray]
    siblings: int = 1
    apart: bool = False

    @cached_property
    def columns(self) -> np.ndarray:
        """(N, K) mm; made anew after they were let go."""
        again: deque[Block] | None = self.__dict__.get("again")
        if again is not None:
            again.append(self)
            if len(again) > KEPT:
                again.popleft().__dict__.pop("columns", None)
        return self.make()

    def having(self, columns: np.ndarray) -> Block:
        """The block with its columns (N, K) at hand, as `make` would make them."""
        self.__dict__["columns"] = columns
        return self

    def let_go(self, again: deque[Block]) -> None:
        """Forget the columns, but not how many they are, where they show and how large. again: the
        last blocks that made them again."""
        # worked out while the columns are there: what a scan and a search ask for of all blocks
        _ = self.width, self.shown, self.largest
        self.__dict__.pop("columns", None)
        self.__dict__["again"] = again

    @cached_property
    def width(self) -> int:
        """K."""
        return int(self.columns.shape[1])

    @cached_property
    def shown(self) -> int:
        """Rows in which it shows."""
        return int(np.count_nonzero(self.columns.any(axis=1)))

    @cached_property
    def largest(self) -> np.ndarray:
        """(K,) mm, at its largest reading."""
        shown = np.abs(self.columns).max(axis=0, initial=0.0)
        largest: np.ndarray = np.maximum(shown, NOTHING)
        return largest

    @cached_property
    def name(self) -> str:
        return self.module.__name__.rsplit(".", 1)[1]

    @cached_property
    def key(self) -> str:
        """effect:axis, as the contract writes it."""
        return f"{self.name}:{self.axis}"
