"""What looks at lines before cycles and frames do, one behind the other."""

from __future__ import annotations

from collections.abc import Sequence

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line


class Before:
    """`codes`: those that it writes out; `rigid`: whether what it wrote last has a size of its own,
    which no frame may scale."""

    codes: tuple[int, ...] = ()
    rigid = False

    def __init__(self, scene: Scene):
        self.scene = scene

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        return True

    def take(self, line: Line) -> list[Line]:
        """Lines that can be followed: what stands for its block. Raises ProgramError."""
        if self.scene.passes(line.text):
            return [line]
        block = self.scene.block = Block.of(line.text, self.scene.dialect.grammar)
        return [line._replace(text=text) for text in self.written(block)]

    def written(self, block: Block) -> list[bytes]:
        """The blocks that stand for one. Raises ProgramError."""
        raise NotImplementedError

    def finish(self) -> list[Line]:
        """What is still held back where the program ends."""
        return []


class Chain(Before):
    """Several of them as one: what one hands on, the next one takes."""

    def __init__(self, parts: Sequence[Before]):
        self.parts = parts

    def wants(self, line: Line) -> bool:
        return any(part.wants(line) for part in self.parts)

    def take(self, line: Line) -> list[Line]:
        # What holds for one line says nothing of the next; `_one` collects it over all parts.
        self.rigid = False
        return self._through([line], 0)

    def finish(self) -> list[Line]:
        lines: list[Line] = []
        for k, part in enumerate(self.parts):
            # A part has seen its own lines already: they go on to those behind it alone.
            lines += self._through(part.finish(), k + 1)
        return lines

    def _through(self, lines: list[Line], first: int) -> list[Line]:
        for part in self.parts[first:]:
            lines = [new for line in lines for new in self._one(part, line)]
        return lines

    def _one(self, part: Before, line: Line) -> list[Line]:
        if not part.wants(line):
            return [line]
        # `wants` is asked again for each line: what a part before has written may concern the next
        # one.
        lines = part.take(line)
        self.rigid |= part.rigid
        return lines
