"""A3= B3= C3= of Sinumerik, the tool's direction under TRAORI, written as words of the rotary axes.

SINUMERIK 840D sl, Job Planning (03/2006), 7.2.4, and NC Programming (12/2019), page 671: the vector
points from the tip to the tool adapter, its length means nothing, components that are left out are
0, a block without any of them keeps the direction. It counts in the workpiece's coordinate system
(ORIWKS). The direction at the end of a block is the same with rotary words, and the tip goes
straight either way; between, the control turns the tool as ORIVECT or ORIAXES say.

Refused: ORIMKS beside a vector; A2 B2 C2, whose order of turns is a machine datum; LEAD and TILT,
which need the surface's normal; vectors without TRAORI, beside a rotary word, or within ROT and its
kin; G91.
"""

from __future__ import annotations

import re

from postproc.nc.codes import code_number
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.direction import Directions
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line
from postproc.spaces import Space

VECTOR = re.compile(rb"(?<![A-Za-z0-9_$])[ABC]3[ \t]*=", re.IGNORECASE)
WORDS = re.compile(rb"(?<![A-Za-z0-9_$])(?:TRA[A-Z]+|ORI[MW]KS)(?![A-Za-z0-9_])", re.IGNORECASE)
ON, MACHINE = code_number("TRAORI"), code_number("ORIMKS")
FRAMES = (MACHINE, code_number("ORIWKS"))


class SiemensDirections(Directions):
    """`on`: whether TRAORI holds; `machine`: whether ORIMKS does."""

    name, letters = "TRAORI", ("A3", "B3", "C3")

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.on = self.machine = False

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        text = line.text
        if b"=" in text and VECTOR.search(text):
            return True
        # TRAORI, ORIWKS and their kin all have an R; the expression is asked of few lines.
        return b"R" in text.upper() and bool(WORDS.search(text))

    def written(self, block: Block) -> list[bytes]:
        """The block with rotary words in the place of a vector. Raises ProgramError."""
        # Modes hold from their block on, with a vector beside them or not.
        for code in block.codes:
            if self.scene.group_of(code) == "transformation":
                self.on = code == ON
            elif code in FRAMES:
                self.machine = code == MACHINE
        vector = self.vector(block)
        if vector is None:
            return [block.text]
        self._check(block)
        return [self.directed(block, vector)]

    def space(self) -> Space:
        """That of the words: a swivelled plane turns the vector too."""
        frame = self.scene.tracker.state.frame
        return (frame.space if frame else None) or Space()

    def _check(self, block: Block) -> None:
        scene, kinematics = self.scene, self.kinematics()
        # In the block of TRAORI itself the transformation is not in force yet.
        if not self.on or ON in block.codes:
            raise scene.fault(
                "a direction A3 B3 C3 that does not stand behind TRAORI",
                "write TRAORI in a block before it",
            )
        if self.machine:
            raise scene.fault(
                "a direction A3 B3 C3 in the machine's coordinates (ORIMKS)",
                "write ORIWKS before it, or let the CAM program write the rotary axes",
            )
        if scene.turned:
            raise scene.fault(
                "a direction A3 B3 C3 within turned, scaled or mirrored coordinates",
                "let the CAM program write the rotary axes",
            )
        if any(w.letter in kinematics.rotary for w in block.words):
            raise scene.fault(
                "a direction A3 B3 C3 beside the word of a rotary axis", "write one of the two"
            )
