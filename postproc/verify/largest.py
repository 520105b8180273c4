"""The largest of many distances, and the line it belongs to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Largest:
    """The largest distance in mm, and the input line it belongs to; `slide`, `slide_line`: the same
    with lost motion as such; `lean`, `lean_line`: rad, by how much the tool leans away from its
    nominal direction in the part."""

    deviation: float = 0.0
    line: int = 0
    slide: float = 0.0
    slide_line: int = 0
    lean: float = 0.0
    lean_line: int = 0

    def take(self, deviation: float, line: int, slides: bool = False) -> None:
        if slides and deviation > self.slide:
            self.slide, self.slide_line = deviation, line
        if not slides and deviation > self.deviation:
            self.deviation, self.line = deviation, line
