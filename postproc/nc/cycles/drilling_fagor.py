"""Drilling cycles of Fagor mills: G81 G83 G85 by Z, the reference plane, and I, the bottom.

Fagor CNC 8055 M & EN programming manual, pages 162 (G81) and 177 (G85): Z is a place, or in G91 a
distance from the initial plane, without it the plane where the tool stands; I is a place, or in G91
a distance from the reference plane; K dwells; G98 goes back to the initial plane, G99 to the
reference plane. G83 as Autodesk's `fagor.cps` writes it: I is the distance of a peck with its sign,
J how many there are, G90 or not.

Assumed: G85 comes out at the feed it went in with; pecks of G83 go out to the reference plane. A
following block names places only. Within the cycles and behind G80 no motion code is taken to hold:
these controls go on with the cycle behind G0 and G1.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.drilling import KIND, Action, Job, bore, drill, pecks
from postproc.nc.cycles.drilling_fanuc import FanucDrilling
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

FAGOR: dict[int, Action] = {810: drill, 830: pecks, 850: bore}
TAP = 840
PECKS = 830


class FagorDrilling(FanucDrilling):
    """`held`: "R" and "depth" as programmed coordinates, as on Fanuc; "Q" the peck."""

    actions, tapping, refused = FAGOR | {TAP: bore}, (TAP,), {}
    words, repeats = "ZIJK", ""
    dwells = (810, 850)
    pecking = (PECKS,)

    def hole_form(self, code: int) -> Form:
        takes = {"X": "place", "Y": "place", "Z": "reference plane"}
        if code == PECKS:
            takes |= {"I": "peck, with its sign", "J": "how many pecks"}
        else:
            takes |= {"I": "bottom", "K": "dwell at the bottom"}
        return Form(KIND, takes, axes=True)

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        axis = self.axis_of(scene, code)
        strange = next((w for w in block.words if w.letter in (axis, *"IJK")), None)
        if strange is not None and code not in block.codes:
            raise scene.fault(
                f"{strange.letter}{strange.raw} in a block within G{code / 10:g} that does not"
                " name it",
                "what it changes is not certain: write the cycle's code with all its words",
                strange,
            )
        return super().job(scene, block, code)

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        code = next((c for c in block.codes if c in self.actions), None)
        if code is None:
            return
        level, depth, count, dwell = (block.word(x) for x in (axis, "I", "J", "K"))
        #  initial plane     - - - -     In G91 Z counts from the initial plane and I from the
        #  reference plane  ---------    reference plane; I of G83, one of J pecks, counts with its
        #  bottom            - - - -     sign from there always.
        start = self.start(scene, axis) if scene.incremental or level is None else 0.0
        self.held = {"R": start + (scene.length(level, axis) if level else 0.0)}
        self.p = dwell.raw if dwell else ""
        # No bottom: `_hole` refuses it.
        if depth is None:
            return
        value = scene.length(depth, axis)
        if code == PECKS:
            times = self._count(scene, count)
            self.held |= {"Q": abs(value), "depth": self.held["R"] + value * times}
        else:
            self.held["depth"] = value + (self.held["R"] if scene.incremental else 0.0)

    def letter_of(self, held: str, axis: str, code: int) -> str:
        return axis if held == "R" else "I"

    def _count(self, scene: Scene, word: Word | None) -> int:
        value = word.value if word else None
        if value is None or value != int(value) or value < 1:
            raise scene.fault(
                "G83 without J", "write how many pecks there are, a whole number from 1", word
            )
        return int(value)

    def passed_on(self, scene: Scene, block: Block, job: Job) -> list[bytes]:
        """With all its words, from the initial plane that the control would still know."""
        if self.stays or not self.code:
            return [block.text]
        return [*self.from_initial(scene, block, job.hole.axis), block.text]
