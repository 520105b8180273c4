"""G43.5 of Fanuc: the tool's direction as I J K under tool centre point control, written as rotary
words under G43.4.

Fanuc A-79348E, "Tool center point control (type 2)", page 11, and B-63323EN-1, 10.4.10: I J K are
the direction of the tool at the end of the block as the programming coordinate system has it, which
is fixed on the table as it stands at G43.5; one that is left out is 0, a block without any of them
keeps the direction; a rotary axis goes the shorter way, 180 degrees at most. Tip and direction are
the same under G43.4 with rotary words, and so is the way between: rotary axes go evenly.

Of two poses with one direction the one is written whose axis nearest to the part has the shorter
way, within the travels; at a pole an axis stays where it stands. Which one the control would take
is a matter of its parameters, and a notice says so. Refused: Q, the inclination; P1, posture
control; I J K in the block of G43.5 itself, which tables do not allow; arcs, G91.
"""

from __future__ import annotations

import numpy as np

from postproc.errors import Notice
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene
from postproc.nc.expand import Line
from postproc.spaces import Kinematics, Space
from postproc.units import TICKS_PER_MM

ON, LENGTHS = 435, ("tool length",)
NEAR = 1e-7  # rad: such directions are one
BY_CAM = "let the CAM program write the rotary axes, under G43.4"


class ToolDirections:
    """`on`: whether G43.5 holds."""

    codes: tuple[int, ...] = (ON,)
    rigid = False

    def __init__(self, scene: Scene):
        self.scene = scene
        self.on = False
        self.said = False

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        return self.on or b"43" in line.text

    def finish(self) -> list[Line]:
        return []

    def take(self, line: Line) -> list[Line]:
        """The line as G43.4 would have it. Raises ProgramError."""
        scene = self.scene
        if scene.passes(line.text):
            return [line]
        block = Block.of(line.text, scene.dialect.grammar)
        scene.block = block
        begins = ON in block.codes
        if begins:
            return [line._replace(text=self._begin(block))]
        if self.on and any(scene.group_of(c) in LENGTHS for c in block.codes):
            self.on = False
        vector = [block.get(x) for x in "IJK"]
        if not self.on or all(v is None for v in vector):
            return [line]
        return [line._replace(text=self._directed(block, np.array([v or 0.0 for v in vector])))]

    def _begin(self, block: Block) -> bytes:
        """G43.5 as G43.4."""
        scene = self.scene
        kinematics = scene.tracker.setup.kinematics
        if kinematics is None:
            raise scene.fault(
                "G43.5 on a machine without rotary axes", "choose the right --machine"
            )
        if kinematics.lacking:
            raise scene.fault(
                f"G43.5 turns the tool, and {kinematics.lacking[0]}", kinematics.lacking[1]
            )
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
        at = next(
            i
            for i, w in enumerate(block.words)
            if w.letter == "G" and round((w.value or 0) * 10) == ON
        )
        return block.written(set(), changed={at: b"G43.4"})

    def _directed(self, block: Block, vector: np.ndarray) -> bytes:
        """The block with the words of the rotary axes in the place of I J K."""
        scene = self.scene
        if scene.code_of(block, "motion") in (CLOCKWISE, COUNTER):
            raise scene.fault(
                "an arc under G43.5, whose I J K could be a centre or a direction", BY_CAM
            )
        if scene.code_of(block, "distance") == 910:
            raise scene.fault(
                "a direction I J K in G91", "write G90: the rotary axes are written as places"
            )
        size = float(np.linalg.norm(vector))
        if not size:
            raise scene.fault("I J K have no direction", "write one that is not 0")
        kinematics = scene.tracker.setup.kinematics
        assert kinematics is not None
        state = scene.tracker.state
        rows = [scene.tracker.setup.axes.index(x) for x in kinematics.rotary]
        if not state.known[rows].all():
            raise scene.fault(
                "the tool turns from where the rotary axes stand, and that is not known",
                "move them to absolute places before, or say where they stand: --start"
                f" {kinematics.rotary[0]}0",
            )
        space = (state.frame.tip if state.frame else None) or Space()
        here = state.position / TICKS_PER_MM
        pose = self._pose(kinematics, space.matrix @ vector / size, here)
        words = []
        for x, row in sorted(zip(kinematics.rotary, rows, strict=True), key=lambda one: one[1]):
            place = scene.coordinate(x, round(float(pose[row]) * TICKS_PER_MM), state)
            if scene.rounded(x, place) != scene.rounded(
                x, scene.coordinate(x, int(state.position[row]), state)
            ):
                words.append(scene.text(x, place))
        own = own_words(block, "IJK", set())
        return block.written(own, (b" " if block.spaced else b"").join(words), max(own))

    def _pose(self, kinematics: Kinematics, normal: np.ndarray, here: np.ndarray) -> np.ndarray:
        """The position whose tool has this direction of the part, of several that with the shortest
        way."""
        poses = kinematics.aligned(normal, here)
        if not poses:
            raise self.scene.fault(
                "no pose within the travels gives the tool this direction",
                "check I J K, and the travels",
            )
        if np.linalg.norm(kinematics.tool_axis(here) - normal) < NEAR:
            return here
        best = poses[0]
        for x in kinematics.rotary:  # at a pole an axis turns nothing, and stays
            row = self.scene.tracker.setup.axes.index(x)
            still = best.copy()
            still[row] = here[row]
            if np.linalg.norm(kinematics.tool_axis(still) - normal) < NEAR:
                best = still
        if not self.said:
            self.said = True
            what = (
                "G43.5: of the poses with one direction that with the shorter way is written; a"
                " parameter of the control might choose another"
            )
            self.scene.notices.append(Notice("G43.5", what, self.scene.source))
        return best
