"""What looks at lines before cycles and frames do, one behind the other."""

from __future__ import annotations

from typing import Any

from postproc.nc.expand import Line


class Chain:
    """Several of them as one: what one hands on, the next one takes. `codes`: those that they write
    out."""

    codes: tuple[int, ...] = ()

    def __init__(self, *parts: Any):
        self.parts = parts
        self.rigid = False

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        return any(part.wants(line) for part in self.parts)

    def take(self, line: Line) -> list[Line]:
        """Lines that can be followed. Raises ProgramError."""
        self.rigid = False
        return self._through([line], 0)

    def finish(self) -> list[Line]:
        """What is still to come where the program ends."""
        lines: list[Line] = []
        for k, part in enumerate(self.parts):
            lines += self._through(part.finish(), k + 1)
        return lines

    def _through(self, lines: list[Line], first: int) -> list[Line]:
        for part in self.parts[first:]:
            lines = [new for line in lines for new in self._one(part, line)]
        return lines

    def _one(self, part: Any, line: Line) -> list[Line]:
        if not part.wants(line):
            return [line]
        lines: list[Line] = part.take(line)
        self.rigid |= part.rigid
        return lines
