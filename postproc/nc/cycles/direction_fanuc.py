"""G43.5 of Fanuc: the tool's direction as I J K under tool centre point control, written as rotary
words under G43.4.

Fanuc A-79348E, "Tool center point control (type 2)", page 11, and B-63323EN-1, 10.4.10: I J K are
the direction of the tool at the end of the block as the programming coordinate system has it, which
is fixed on the table as it stands at G43.5; one that is left out is 0, a block without any of them
keeps the direction; a rotary axis goes the shorter way, 180 degrees at most. Tip and direction are
the same under G43.4 with rotary words, and so is the way between: rotary axes go evenly.

Refused: Q, the inclination; P1, posture control; I J K in the block of G43.5 itself, which tables
do not allow; arcs, G91.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.direction import Directions
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene
from postproc.nc.expand import Line

ON, LENGTHS = 435, ("tool length",)
BY_CAM = "let the CAM program write the rotary axes, under G43.4"


class ToolDirections(Directions):
    """`on`: whether G43.5 holds."""

    codes = (ON,)
    name, letters = "G43.5", ("I", "J", "K")

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.on = False

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        # A quick look, since every line of a program comes here: 43 stands in G43.5 whatever zeros
        # lead it.
        return self.on or b"43" in line.text

    def written(self, block: Block) -> list[bytes]:
        """The block as G43.4 would have it. Raises ProgramError."""
        if ON in block.codes:
            return [self._begin(block)]
        # G43 or G49: another code of this group has taken over.
        if self.on and any(self.scene.group_of(c) in LENGTHS for c in block.codes):
            self.on = False
        vector = self.vector(block)
        if not self.on or vector is None:
            return [block.text]
        self._alike(block)
        if self.scene.code_of(block, "motion") in (CLOCKWISE, COUNTER):
            raise self.scene.fault(
                "an arc under G43.5, whose I J K could be a centre or a direction", BY_CAM
            )
        return [self.directed(block, vector)]

    def _alike(self, block: Block) -> None:
        """Raises ProgramError where some components have a decimal point and others have none: only
        their ratios matter, so that one way or the other is understood, a mixture not."""
        given = [w for w in block.words if w.letter in self.letters and w.value]
        bare = next((w for w in given if "." not in w.raw), None)
        if self.scene.tracker.counts and bare and any("." in w.raw for w in given):
            raise self.scene.fault(
                f"{bare.letter}{bare.raw} of a direction has no decimal point, and others have one",
                "write I J K alike",
                bare,
            )

    def _begin(self, block: Block) -> bytes:
        """G43.5 as G43.4."""
        scene = self.scene
        # A machine that can not turn the tool is refused here, not at the first vector.
        self.kinematics()
        wrong = next(
            (w for w in block.words if w.letter in "QIJK" or (w.letter == "P" and w.value)), None
        )
        if wrong is not None:
            raise scene.fault(
                f"{wrong.letter}{wrong.raw} in the block of G43.5",
                "an inclination, posture control and a direction there are not followed: " + BY_CAM,
                wrong,
            )
        self.on = True
        return block.written(set(), changed={min(own_words(block, "", (ON,))): b"G43.4"})
