"""FB= of Sinumerik, a feed for its own block alone, written out as F, and the F that held before it
as a block behind it.

SINUMERIK NC Programming Manual, "Feedrate for one block (FB)".
"""

from __future__ import annotations

import re

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line
from postproc.nc.expand.siemens_modal import code_of, feed_of

NUMBER = rb"[ \t]*([0-9]*\.?[0-9]+)"
FOR_ONE_BLOCK = re.compile(rb"(?<![A-Za-z0-9_])FB[ \t]*=" + NUMBER, re.IGNORECASE)


class BlockFeed(Before):
    """Follows F."""

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.feed = b""  # as the program wrote it last
        self.due = False  # whether another one is in force now

    def wants(self, line: Line) -> bool:
        """Lines that name a feed, and the one behind FB."""
        return self.due or b"F" in line.text.upper()

    def take(self, line: Line) -> list[Line]:
        """The line, and F before it. Raises ProgramError."""
        code = code_of(line.text)
        if self.scene.passes(line.text) or not code.strip():
            return [line]
        #  N1 G1 X10 F200     N1 G1 X10 F200
        #  N2 X20 FB=50       N2 X20 F50
        #  N3 X30             F200, and N3 X30: the feed that held before is due
        own = FOR_ONE_BLOCK.search(code)
        feed = feed_of(code)
        before: list[Line] = []
        if self.due and not own and not feed:
            if not self.feed:
                self.scene.block = Block.of(line.text, self.scene.dialect.grammar)
                raise self.scene.fault(
                    "a block behind FB, and no F was in force before it", "write F before FB"
                )
            before = [line._replace(text=b"F" + self.feed)]
        self.due = own is not None
        if own is not None:
            new = line.text[: own.start()] + b"F" + own[1] + line.text[own.end() :]
            return [line._replace(text=new)]
        self.feed = feed or self.feed
        return [*before, line]
