"""G90 and G94 of Fanuc and Haas lathes (B: G77 G79, C: G20 G24), one cut each, and the threads
beside them.

Fanuc B-64304EN-1, "Canned cycle (G90, G92, G94)" and "Series 10/11 program format"; Haas lathe
operator's manual 96-8900, G90, G94. Threads (G76, G92) have a run-out that parameters shape
(5130, 5131), and stay.
"""

from __future__ import annotations

from collections.abc import Iterable

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.grooving_fanuc import named_end, refuse_nose
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

KIND = "a turning cycle"
OWN = "XZUWPQRDIKA"
PLACES = {"X": "end", "Z": "end", "U": "end, from the start", "W": "end, from the start"}


class Turn(Cycle):
    """G90 (G77), straight or tapered along Z, and G94 (G79) along X: in, cut, out, back. Its words
    hold.

    The taper is R, or in the one-block format of Series 10/11 and on Haas I (G90) and K (G94)."""

    modal = True

    def __init__(self, codes: Iterable[int], facing: bool, haas: bool = False):
        self.codes, self.facing = codes, facing
        self.tapers = ("K" if facing else "I") + "R" * (not haas)
        self.form = Form(KIND, PLACES | dict.fromkeys(self.tapers, "taper"), increments=True)
        self.end()

    def end(self) -> None:
        self.to: dict[str, float] = {}
        self.taper = 0.0

    def wants(self, scene: Scene, block: Block) -> bool:
        return any(block.get(x) is not None for x in "XZUW" + self.tapers)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        refuse_nose(scene, code)
        m = Moves(scene, own_words(block, "XZUW" + self.tapers, {code}))
        if not self.wants(scene, block):
            return Outcome(m.finish())
        start = {x: scene.at(x) for x in "XZ"}
        # X or Z of the block before holds on where a block names the other alone.
        self.to |= named_end(scene, block, start)
        missing = [x for x in "XZ" if x not in self.to]
        if missing:
            raise scene.fault(
                f"G{code / 10:g} without {missing[0]}",
                "name X and Z in the first block of the cycle",
            )
        tapers = [w for w in block.words if w.letter in self.tapers]
        if len(tapers) > 1:
            raise scene.fault(
                f"{tapers[0].letter} and {tapers[1].letter} both say the taper",
                "write one",
                tapers[1],
            )
        if tapers:
            self.taper = scene.length(tapers[0], "Z" if self.facing else "X")
        #  o---- G0 ---> start    G90 (G77): the taper lies where the cut begins, a radius; below 0
        #  ^             :        the part thickens towards the end. G94 (G79): X and Z change
        #  G1            G0       places, the taper along Z.
        #  |             v
        #  X Z <-- G1 -- X + R
        half = scene.double("X")
        x, z = self.to["X"], self.to["Z"]
        if self.facing:
            m.move("G0", {"Z": z + self.taper})
            m.move("G1", {"X": x, "Z": z})
            m.move("G1", {"Z": start["Z"]})
            m.move("G0", {"X": start["X"]})
        else:
            m.move("G0", {"X": x + self.taper * half})
            m.move("G1", {"X": x, "Z": z})
            m.move("G1", {"X": start["X"]})
            m.move("G0", {"Z": start["Z"]})
        return Outcome(m.finish())


class Stays(Cycle):
    """A thread: it begins and ends in its start point, and stays as it is written."""

    form = Form("a threading cycle", stays=True)
    modal = False

    def __init__(self, codes: Iterable[int], modal: bool):
        self.codes, self.modal = codes, modal

    def wants(self, scene: Scene, block: Block) -> bool:
        return any(block.get(x) is not None for x in "XZUWR")

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        heard = Moves(scene, own_words(block, OWN, {code})).finish()
        return Outcome([block.text], heard)
