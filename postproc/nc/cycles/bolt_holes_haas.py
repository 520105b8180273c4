"""G70 and G71 of Haas mills: holes on a circle and on an arc, at each of which the canned cycle in
force is called. They become the places, as blocks of that cycle.

                3     2
             4     +     1   <- the first hole: at radius I, at angle J from X+
                5     6         G70: L holes, 360 / L apart; G71: L holes, K apart

Haas mill operator's manual, "G70 Bolt Hole Circle", "G71 Bolt Hole Arc", and helmancnc.com, "G71
Bolt Hole Arc": I is the radius, J the angle of the first hole, counter-clockwise from 3 o'clock, K
of G71 the angle from hole to hole, L how many; the tool stands in the centre, or X Y of the block
lead there; the cycle is in force (L0 in its block keeps the centre free), or stands in the block.
Refused: other planes; L below 1; G73 and G83 in the same block, for I J K are their words too. Not
followed: G72, for manuals do not say whether the first hole lies where the tool stands.
"""

from __future__ import annotations

import math
import re

from postproc.nc.cycles.before import Before
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.drilling_fanuc import HAAS_PECKS, HaasDrilling
from postproc.nc.cycles.drilling_fanuc import MILL as DRILLING
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.expand import Line

CIRCLE, ARC = 700, 710
PECKING = (730, 830)  # whose I J K are pecks
MOST_HOLES = 10_000
NEAR = 1e-6
NO_HOLE = re.compile(rb"L[ \t]*0+\.?(?![0-9.])", re.IGNORECASE)
MARK = re.compile(rb"G[ \t]*0*7[ \t]*[01](?![ \t]*[0-9.])", re.IGNORECASE)


class BoltHoles(Before):
    """Patterns of holes; `holes`: the canned cycles of the control."""

    codes = (CIRCLE, ARC)
    holes: HaasDrilling

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.aside: dict[str, float] = {}  # places in blocks with L0, which nothing moved to

    def wants(self, line: Line) -> bool:
        """Whether a line must go through here."""
        return bool(self.aside or MARK.search(line.text) or NO_HOLE.search(line.text))

    def written(self, block: Block) -> list[bytes]:
        """A block to each hole. Raises ProgramError."""
        code = next((c for c in block.codes if c in self.codes), 0)
        if not code:
            self._note(block)
            # A place beside L0 is read by the control, but no hole is made: whether the tool goes
            # there is in no text that was found. So it is kept aside, and asked for where a centre
            # would rest on it.
            return [block.text]
        self._check(block, code)
        words = self._words(block, code)
        # The first hole stands in the block itself, so a cycle that is named in it begins there.
        return [block.written(own_words(block, "IJKLXY", (code,)), words[0]), *words[1:]]

    def _note(self, block: Block) -> None:
        """Keep the places that a block with L0 names, until a block without it names others."""
        for axis in "XY":
            word = block.word(axis)
            if word is None:
                continue
            self.aside.pop(axis, None)
            if block.get("L") == 0:
                by = self.scene.at(axis) if self._incremental(block) else 0.0
                self.aside[axis] = by + self.scene.length(word, axis)

    def _incremental(self, block: Block) -> bool:
        """Whether words of a block are distances."""
        own = next((c for c in block.codes if c in (900, 910)), 0)
        return own == 910 if own else self.scene.incremental

    # Whole: a list of refusals, a condition to each.
    def _check(self, block: Block, code: int) -> None:
        scene, name = self.scene, f"G{code // 10}"
        drilling = next((c for c in block.codes if c in DRILLING), 0)
        if scene.code("plane") != 170:
            raise scene.fault(f"{name} outside the XY plane", "write G17 before it")
        if not (drilling or self.holes.code):
            raise scene.fault(
                f"{name} without a canned cycle",
                "write the cycle of one hole before it, with L0: G81 Z-5. R2. L0",
            )
        if drilling in PECKING:
            raise scene.fault(
                f"G{drilling // 10} in the block of {name}: both have {' '.join(HAAS_PECKS)}",
                f"write the cycle into a block before, with L0, and {name} alone",
            )
        for letter in "IJL" if code == CIRCLE else "IJKL":
            if block.get(letter) is None:
                raise scene.fault(f"{name} without {letter}", f"write {letter} and its number")
        for angle in (w for w in block.words if w.letter in "JK"):
            scene.angle(angle)
        count = block.get("L") or 0
        if count != int(count) or not 1 <= count <= MOST_HOLES:
            raise scene.fault(
                f"L{count:g} of {name}", f"a whole number of holes, 1 to {MOST_HOLES:,}"
            )

    def _words(self, block: Block, code: int) -> list[bytes]:
        """X and Y of each hole."""
        scene, incremental = self.scene, self._incremental(block)
        centre, here = self._centre(block, incremental)
        radius = scene.length(next(w for w in block.words if w.letter == "I"), "X")
        count = int(block.get("L") or 0)
        step = 360.0 / count if code == CIRCLE else block.get("K") or 0.0
        found = []
        for k in range(count):
            # From the first angle and not from hole to hole: steps of 360 / 7 would add up their
            # rounding.
            turn = math.radians((block.get("J") or 0.0) + k * step)
            place = (centre[0] + radius * math.cos(turn), centre[1] + radius * math.sin(turn))
            texts = [scene.text(axis, place[i] - here[i]) for i, axis in enumerate("XY")]
            if incremental:  # what is written counts from what was written
                here = [here[i] + float(texts[i][1:]) for i in (0, 1)]
            found.append(b" ".join(texts))
        return found

    def _centre(self, block: Block, incremental: bool) -> tuple[list[float], list[float]]:
        """X and Y of the centre, and from where the words of the holes count. Raises
        ProgramError."""
        scene = self.scene
        centre, here = [], []
        for axis in "XY":
            word = block.word(axis)
            at = scene.at(axis) if word is None or incremental else 0.0
            if word is None and abs(self.aside.get(axis, at) - at) > NEAR:
                raise scene.fault(
                    f"{axis}{self.aside[axis]:g} stands in a block with L0: whether it is the"
                    " centre is not certain",
                    "write X and Y of the centre into this block",
                )
            here.append(at if incremental else 0.0)
            said = scene.length(word, axis) if word else 0.0
            centre.append(at + said)
        self.aside = {}
        return centre, here
