"""How long a sender waits before it draws a conclusion."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """s: how often a status is asked for; how long silence, a standstill with lines unanswered, and
    an ordered stop may last.
    watch: the same where the
    path is watched; soon: and where an answer is late. off_mm: how far the machine may stand from
    where the last line ends; path_mm: from the path while it runs, beside the steps of its
    motors."""

    poll: float = 0.2
    silence: float = 2.0
    stall: float = 2.0
    grace: float = 1.0
    off_mm: float = 0.02
    path_mm: float = 0.05
    watch: float = 0.1
    soon: float = 0.05
