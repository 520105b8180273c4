"""The largest of many distances, and the line it belongs to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Largest:
    """The largest distance in mm, the input line it belongs to, and how much of it no take-up can
    bring about there (`aside`: turning.py); `rest`, `rest_line`: the largest of what is beyond
    that; `slide`, `slide_line`: the distance with lost motion as such; `lean`, `lean_line`: rad, by
    how much the tool leans away from its nominal direction in the part."""

    deviation: float = 0.0
    line: int = 0
    aside: float = 0.0
    rest: float = 0.0
    rest_line: int = 0
    slide: float = 0.0
    slide_line: int = 0
    lean: float = 0.0
    lean_line: int = 0

    def take(self, deviation: float, line: int, slides: bool = False, aside: float = 0.0) -> None:
        """A deviation, mm, of a line; slides: with lost motion as such; aside: mm of it that no
        take-up can bring about."""
        if slides and deviation > self.slide:
            self.slide, self.slide_line = deviation, line
        if not slides and deviation > self.deviation:
            self.deviation, self.line, self.aside = deviation, line, aside
        if not slides and deviation - aside > self.rest:
            self.rest, self.rest_line = deviation - aside, line
