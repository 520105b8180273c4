"""How long a sender waits before it draws a conclusion."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """s: how often a status is asked for; how long silence, a standstill with lines unanswered, and an ordered stop may last.
    off_mm: how far the machine may stand from where the last line ends."""

    poll: float = 0.2
    silence: float = 2.0
    stall: float = 2.0
    grace: float = 1.0
    off_mm: float = 0.02
