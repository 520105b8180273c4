"""A tool's direction that a block names as a vector, under tool centre point control, written as
words of the rotary axes.

Of two poses with one direction the one is written whose axis nearest to the part has the shorter
way, within the travels; at a pole an axis stays where it stands. Which one the control would take
is a matter of its parameters, and a notice says so; the words that are written leave it no choice.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import Scene
from postproc.spaces import Kinematics, Space
from postproc.units import TICKS_PER_MM

# 1e-7 rad is 0.02 arcsec: finer than a rotary axis' least increment (0.001 degrees is 1.7e-5 rad)
# and far above the rounding of the poses.
NEAR = 1e-7  # rad: such directions are one


class Directions(Before):
    """What the controls share. `name`: the call, `letters`: of the vector's words."""

    name: str
    letters: Collection[str]

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.said = False

    def kinematics(self) -> Kinematics:
        """Of the machine. Raises ProgramError where it can not turn the tool."""
        scene = self.scene
        kinematics = scene.tracker.setup.kinematics
        if kinematics is None:
            raise scene.fault(
                f"{self.name} on a machine without rotary axes", "choose the right --machine"
            )
        if kinematics.lacking:
            raise scene.fault(
                f"{self.name} turns the tool, and {kinematics.lacking[0]}", kinematics.lacking[1]
            )
        return kinematics

    def space(self) -> Space:
        """The frame in which the vector is told."""
        frame = self.scene.tracker.state.frame
        return (frame.tip if frame else None) or Space()

    def vector(self, block: Block) -> np.ndarray | None:
        """(3,) the direction that a block names, a missing component as 0; None: it names none."""
        named = [block.get(x) for x in self.letters]
        return np.array([v or 0.0 for v in named]) if any(v is not None for v in named) else None

    def directed(self, block: Block, vector: np.ndarray) -> bytes:
        """The block with the words of the rotary axes in the place of the vector's. Raises
        ProgramError."""
        scene = self.scene
        if scene.code_of(block, "distance") == 910:
            raise scene.fault(
                f"a direction {' '.join(self.letters)} in G91",
                "write G90: the rotary axes are written as places",
            )
        size = float(np.linalg.norm(vector))
        if not size:
            raise scene.fault(
                f"{' '.join(self.letters)} have no direction", "write one that is not 0"
            )
        kinematics = self.kinematics()
        state = scene.tracker.state
        rows = [scene.tracker.setup.axes.index(x) for x in kinematics.rotary]
        if not state.known[rows].all():
            raise scene.fault(
                "the tool turns from where the rotary axes stand, and that is not known",
                "move them to absolute places before, or say where they stand: --start"
                f" {kinematics.rotary[0]}0",
            )
        # (A,) mm, and degrees for rotary axes; the vector in the words' frame becomes one of the
        # machine.
        here = state.position / TICKS_PER_MM
        pose = self._pose(kinematics, self.space().matrix @ vector / size, here)
        words = []
        for x, row in sorted(zip(kinematics.rotary, rows, strict=True), key=lambda one: one[1]):
            place = scene.coordinate(x, round(float(pose[row]) * TICKS_PER_MM), state)
            if scene.rounded(x, place) != scene.rounded(
                x, scene.coordinate(x, int(state.position[row]), state)
            ):
                words.append(scene.text(x, place))
        own = own_words(block, self.letters)
        return block.written(own, (b" " if block.spaced else b"").join(words), max(own))

    def _pose(self, kinematics: Kinematics, normal: np.ndarray, here: np.ndarray) -> np.ndarray:
        """The position whose tool has this direction of the part, of several that with the shortest
        way."""
        poses = kinematics.aligned(normal, here)
        if not poses:
            raise self.scene.fault(
                "no pose within the travels gives the tool this direction",
                f"check {' '.join(self.letters)}, and the travels",
            )
        # At a pole many poses have one direction: where the tool has it already, nothing shall
        # turn.
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
                f"{self.name}: of the poses with one direction that with the shorter way is"
                " written; a parameter of the control might choose another"
            )
            self.scene.tell(self.name, what)
        return best
