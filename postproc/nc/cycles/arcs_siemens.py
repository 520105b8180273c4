"""AR= of Sinumerik: an arc by its opening angle and its end, or its centre, written with both.

Siemens, SINUMERIK NC Programming Manual, "Circular interpolation with opening angle and centre
point (G2/G3, X... Y... Z.../ I... J... K..., AR)": AR is the angle between start and end as seen
from the centre, above 0 and below 360 degrees. With an end point the radius follows from the chord;
with a centre (I J K from the start, or AC) the end does. An end across the plane makes it a helix.
"""

from __future__ import annotations

import math
import re

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, PLANES, Scene
from postproc.nc.expand import Line

FOUND = re.compile(rb"(?<![A-Za-z0-9_$])AR[ \t]*=", re.IGNORECASE)
NEAR = 1e-9
WRITE = "write the arc with its end and its centre I J K"


class Openings(Before):
    """Writes AR= out."""

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.plane = PLANES[170]  # the axes of the block at hand
        self.incremental = False  # whether its words are distances

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        return b"=" in line.text and bool(FOUND.search(line.text))

    def take(self, line: Line) -> list[Line]:
        """The line as it can be followed. Raises ProgramError."""
        if not FOUND.search(line.text.split(b";", 1)[0]) or self.scene.passes(line.text):
            return [line]
        return [line._replace(text=self._written(line))]

    def _written(self, line: Line) -> bytes:
        scene = self.scene
        block = Block.of(line.text, scene.dialect.grammar)
        scene.block = block
        opening = block.word("AR")
        code = self.scene.code_of(block, "motion")
        self.plane = PLANES.get(self.scene.code_of(block, "plane"), PLANES[170])
        self.incremental = self.scene.code_of(block, "distance") == 910
        if opening is None or any(w.letter in ("AP", "RP") for w in block.words):
            return line.text  # polar words: frames_siemens.py says what AR is beside them
        if code not in (CLOCKWISE, COUNTER):
            raise scene.fault("AR= at a motion that is no arc", "write G2 or G3 before it", opening)
        if scene.diameter_in_g90:
            raise scene.fault("AR= under DIAM90", "write DIAMON or DIAMOF before it", opening)
        angle = math.radians(opening.value or 0.0)
        if not NEAR < angle < math.tau - NEAR:
            raise scene.fault(
                f"AR={opening.raw} is no opening angle",
                "it lies between 0 and 360 degrees",
                opening,
            )
        return self._opened(block, opening, angle if code == COUNTER else -angle)

    def _opened(self, block: Block, opening: Word, turn: float) -> bytes:
        """An arc that turns by `turn`, rad, written by its end and its centre. Raises
        ProgramError."""
        scene = self.scene
        names = self.plane[:2]
        start = complex(*(scene.at(x) / self.scene.double(x) for x in names))
        own = [block.word(x) for x in names]
        centre = [block.word(CENTRES[x]) for x in names]
        if any(own) and any(centre):
            raise scene.fault("AR= beside an end and a centre", "keep one of the two", opening)
        if any(own):
            end = complex(*(self._place(w, x) for w, x in zip(own, names, strict=True)))
            if abs(end - start) < NEAR:
                raise scene.fault("an arc by AR= that ends where it begins", WRITE, opening)
            #    + centre    Half the chord, and from its middle square to it |chord| / 2 over the
            #    |\          tangent of half the angle: to the left where the arc turns to the left.
            #  --o--> end    Above 180 degrees the tangent is below 0, and the centre on the other
            #                side.
            half = complex(0.5, 0.5 / math.tan(turn / 2))  # of the chord, from start to centre
            return self._with(block, {}, (end - start) * half)
        if not any(centre):
            raise scene.fault("AR= without an end or a centre", WRITE, opening)
        middle = complex(
            *(
                self._centre(w, x, at)
                for w, x, at in zip(centre, names, (start.real, start.imag), strict=True)
            )
        )
        # The radius from the centre to the start, turned by the opening angle.
        end = middle + (start - middle) * complex(math.cos(turn), math.sin(turn))
        return self._with(
            block, dict(zip(names, (end.real, end.imag), strict=True)), middle - start
        )

    def _with(self, block: Block, end: dict[str, float], middle: complex) -> bytes:
        """The block with its end and with the centre, from the start, in place of AR."""
        scene, names = self.scene, self.plane[:2]
        out = own_words(block, ("AR", *(CENTRES[x] for x in names)))
        words = []
        for x, value in end.items():
            value *= self.scene.double(x)
            words.append(scene.text(x, value - scene.at(x) if self.incremental else value))
        words += [
            scene.text(CENTRES[x], v)
            for x, v in zip(names, (middle.real, middle.imag), strict=True)
        ]
        return block.written(out, b" ".join(words), min(out))

    def _place(self, word: Word | None, axis: str) -> float:
        here = self.scene.at(axis) / self.scene.double(axis)
        if word is None:
            return here
        value = (word.value or 0.0) / self.scene.double(axis)
        by = word.mode == "IC" or (self.incremental and word.mode != "AC")
        return here + value if by else value

    def _centre(self, word: Word | None, axis: str, here: float) -> float:
        """A centre counts from the start, but for AC."""
        if word is None:
            return here
        value = word.value or 0.0
        return value / self.scene.double(axis) if word.mode == "AC" else here + value
