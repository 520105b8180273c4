"""What the text layer is told of the machine, and what one batch of blocks hands to the next."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

NONE = -1  # no code of that group yet


@dataclass(frozen=True)
class Setup:
    """What the text must be told of the machine: its axes, which words are diameters, least increments (mm), work and
    tool offsets (mm by axis, by name "G54", "T0101"), where it stands at the start (mm, machine coordinates), and how
    block delete and arc centres are read (None: as the dialect does)."""

    axes: tuple[str, ...]
    diameter: frozenset[str] = frozenset()
    least_increment: dict[str, float] = field(default_factory=dict)
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)
    start: dict[str, float] = field(default_factory=dict)
    block_delete: bool = False
    arc_centre: str = "incremental"


@dataclass(frozen=True)
class ModalState:
    """All that one batch hands to the next: a code per modal group, position (A,) ticks and whether it is known, the
    tool offset and F in force, whether the program has ended, and whether a motion code was
    named since the last motion. origin (A,): ticks, where the zero of absolute words lies behind the batch; offsets: work and
    tool offsets that the program itself has set, mm, beside those of the Setup."""

    codes: dict[str, int]
    position: np.ndarray
    known: np.ndarray
    tool: str = ""
    feed: float = float("nan")
    ended: bool = False
    renamed: bool = False
    origin: np.ndarray | None = None
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)
