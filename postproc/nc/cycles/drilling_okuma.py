"""Drilling cycles of Okuma mills (OSP): Z R P Q as on Fanuc, and M53 M54 for the way back.

As Autodesk's `okuma.cps` writes them: G71 Z names the return level, M53 in the cycle's block goes
back to it, M54 to R; R is a place in G90; P of a cycle are milliseconds, F of G4 seconds. M52, to
the upper limit, and a block without any of the three are refused: where they end is not in the
program.

G73 has I, its peck, and J, the depth behind which it draws out to R. Assumed: it backs off like
Fanuc's.
"""

from __future__ import annotations

from dataclasses import replace

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.drilling import KIND, WORDS, Action, Hole, Job, bore, drill, pecks
from postproc.nc.cycles.drilling_fanuc import FanucDrilling
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form, named

OKUMA: dict[int, Action] = {730: drill, 810: drill, 820: drill, 830: pecks, 850: bore, 890: bore}
TAPS = (740, 840, 2730, 2830, 2840)
LEVEL = 710
TO_LEVEL, TO_R = 53, 54
NEAR = 1e-9
MILLISECONDS = 1000.0  # P of a cycle, in a second of G4 F


class OkumaDrilling(FanucDrilling):
    """`level`: that of G71."""

    tapping, refused = TAPS, {}
    words, repeats = "RPQIJ", ""
    dwells = (730, 820, 830, 850, 890)
    back = 0  # M53 or M54, as last named

    def __init__(self, synchronised: bool = False):
        self.actions = OKUMA | dict.fromkeys(TAPS, bore) | {730: self._chips}
        super().__init__(synchronised)
        self.level: float | None = None

    def hole_form(self, code: int) -> Form:
        takes = named(WORDS, "XYZR") | ({"P": WORDS["P"]} if code in self.dwells else {})
        takes |= {"Q": WORDS["Q"]} if code == 830 else {}
        takes |= (
            {"I": "depth of a peck", "J": "behind how much it draws out"} if code == 730 else {}
        )
        return Form(KIND, takes, axes=True)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        # M53 and M54 hold from hole to hole until G80 (`end`).
        found = [m for m in block.m_codes() if m in (52, TO_LEVEL, TO_R)]
        self.back = found[-1] if found else self.back
        # A cycle that is written out ends by itself where M53 and M54 lead; a tap keeps its own.
        if code not in self.tapping and found:
            own = {i for i, w in enumerate(block.words) if w.letter == "M" and w.value in found}
            scene.block = block = Block.of(block.written(own), scene.dialect.grammar)
        return super().run(scene, block, code)

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        if self.back not in (TO_LEVEL, TO_R):
            raise scene.fault(
                f"G{code / 10:g} without M53 or M54 goes back to a limit of the machine",
                "where that is is not in the program: write M53 with G71 Z before it, or M54",
            )
        if self.back == TO_LEVEL and self.level is None:
            raise scene.fault(
                "M53 goes back to the level of G71, and none was named",
                "write G71 Z before the cycle",
            )
        job = super().job(scene, block, code)
        back = job.hole.r if self.back == TO_R else float(self.level or 0.0)
        # P1000 of a cycle becomes G4 F1.
        dwell = f"{float(job.hole.p) / MILLISECONDS:.6g}" if job.hole.p else ""
        return replace(job, hole=replace(job.hole, back=back, p=dwell))

    def letter_of(self, held: str, axis: str, code: int) -> str:
        return "I" if held == "Q" and code == 730 else super().letter_of(held, axis, code)

    def _chips(self, m: Moves, hole: Hole, scene: Scene) -> None:
        """G73: back a little behind every peck, out to R where J is reached."""
        out = hole.r
        for depth in hole.depths(scene):
            m.move("G1", {hole.axis: depth})
            # NEAR: 2 - 3 * 0.1 is 1.7000000000000002, and a J of 0.3 would draw out a peck too
            # late.
            if "out" in self.held and abs(depth - out) >= self.held["out"] - NEAR:
                m.move("G0", {hole.axis: hole.r})
                out = depth
            m.move("G0", {hole.axis: depth - hole.down * hole.retract})
        drill(m, hole, scene)

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        super()._hold(scene, block, axis)
        for letter in "IJ":
            word = block.word(letter)
            if word is not None:
                self.held["Q" if letter == "I" else "out"] = abs(scene.length(word, axis))

    def end(self) -> None:
        super().end()
        self.back = 0


class ReturnLevel(Cycle):
    """G71 Z: the level to which M53 goes back."""

    codes = (LEVEL,)
    form = Form(KIND, {"Z": "level to go back to"})

    def __init__(self, holes: OkumaDrilling):
        self.holes = holes

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        word = block.word("Z")
        if word is None:
            raise scene.fault("G71 without Z", "name the level to which M53 goes back")
        if scene.incremental:
            raise scene.fault(
                "G71 Z in G91", "write G90 before it: from where its Z counts is not certain"
            )
        self.holes.level = scene.length(word, "Z")
        return Outcome(Moves(scene, own_words(block, "Z", {LEVEL})).finish())
