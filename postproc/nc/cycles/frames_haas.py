"""Turned, scaled and mirrored coordinates of Haas mills: as Fanuc's, and G101 G100, the mirror
about the work zero.

Haas mill operator's manual, "G100 Cancel Mirror Image, G101 Enable Mirror Image": the axes that the
block names are mirrored about their work zero, or no longer; one is required. Refused: a place
other than 0, for what it means is not said; rotary axes.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.frames_fanuc import CODES, FORMS, TAKERS, FanucFrames
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

OFF, ON = 1000, 1010
NAME = "name the axes: G10{} X0 Y0"


class HaasFrames(FanucFrames):
    """The frames in force."""

    codes, takers = (*CODES, OFF, ON), (*TAKERS, OFF, ON)
    counts = False
    forms = FORMS | dict.fromkeys((OFF, ON), Form("a mirror", dict.fromkeys("XYZ", "its axis")))

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.sets |= {ON: self._mirror_here, OFF: self._no_mirror_here}

    def _mirror_here(self, block: Block) -> None:
        away = next((w for w in block.words if w.letter in "XYZ" and w.value), None)
        if away:
            raise self.scene.fault(
                f"{away.letter}{away.raw} in G101",
                f"the mirror stands in the work zero: write {away.letter}0",
                away,
            )
        if not any(w.letter in "XYZ" for w in block.words):
            raise self.scene.fault("G101 without an axis", NAME.format(1))
        self._mirror(block)

    def _no_mirror_here(self, block: Block) -> None:
        if self.mirror and not any(w.letter in "XYZ" for w in block.words):
            raise self.scene.fault("G100 without an axis", NAME.format(0))
        self._no_mirror(block)
