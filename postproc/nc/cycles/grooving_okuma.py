"""G73 and G74 of Okuma lathes: in by pecks along X (G73) or Z (G74), over by a step, and again.

Okuma OSP-P200L / P20L programming manual 5238-E, fixed cycles, as NC-PB/gEdit sums it up
(docs/planning/syntax/syntax-okuma.md, 6.1): X and Z the target, I and K the step along X (a
diameter) and Z, D a peck (of G73 a diameter), L the depth behind which the tool goes out all the
way, E the dwell at the bottom in seconds, T the offset with which the target is reached. A hole in
the middle has X0 and no I.

Assumed: RELIEF in place of the parameter behind each peck (it lies on the way in); between two cuts
the tool goes out to where it stood, and behind the last one there and back over. T must be the
offset in force, or one of the same place: which end the other one moves is in no page that was
found. Refused: DA=, the other step's word, a target beside the start without a step.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.grooving_fanuc import refuse_nose, steps
from postproc.nc.cycles.lap_okuma import RELIEF
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form
from postproc.nc.zeros import lathe_tool

KIND = "a grooving cycle"
CODES = (730, 740)
STEP = {"X": "I", "Z": "K"}


@dataclass
class OkumaGrooving(Cycle):
    """One of the two: it pecks along `deep`, and steps along the other axis."""

    codes: Iterable[int]
    deep: str

    @property
    def over(self) -> str:
        return "X" if self.deep == "Z" else "Z"

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of the cycle."""
        words = {"X": "end", "Z": "end", STEP[self.over]: "step", "D": "depth of a peck"}
        words |= {"L": "depth behind which it goes out", "E": "dwell at the bottom"}
        return (Form(KIND, words),)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        name = f"G{code / 10:g}"
        if scene.incremental:
            raise scene.fault(f"{name} in G91", "write G90 before it")
        refuse_nose(scene, code)
        m = Moves(scene, own_words(block, "XZIKDLE", {code}))
        deep, over = self.deep, self.over
        start = {x: scene.at(x) for x in "XZ"}
        to = {x: scene.length_in(block, x, x, start[x]) for x in "XZ"}
        step = abs(scene.length_in(block, STEP[over], over))
        if to[over] != start[over] and not step:
            raise scene.fault(
                f"{name} to another {over} and no {STEP[over]}",
                f"write the step {STEP[over]}, or {over} where the tool stands",
            )
        if to[deep] == start[deep]:
            raise scene.fault(f"{name} without its depth ({deep})", "name where it ends")
        places = steps(scene, start[over], to[over], step)
        depths = self._depths(scene, block, start[deep], to[deep])
        dwell = block.word("E")
        # Each cut: in by pecks, the dwell at the bottom, all the way out; then over by a step.
        for k, place in enumerate(places):
            if k:
                m.move("G0", {over: place})
            for depth, back in depths:
                m.move("G1", {deep: depth})
                for rest in back:
                    m.move("G0", {deep: rest})
            if dwell and dwell.value:
                m.line(b"G4 " + scene.text("F", dwell.value))
            m.move("G0", {deep: start[deep]})
        m.move("G0", {over: start[over]})
        return Outcome(m.finish())

    def _depths(
        self, scene: Scene, block: Block, start: float, end: float
    ) -> list[tuple[float, list[float]]]:
        """Where each peck ends, and the ways back and on behind it."""
        peck = abs(scene.length_in(block, "D", self.deep))
        out = abs(scene.length_in(block, "L", self.deep))
        ends = steps(scene, start, end, peck)[1:]
        relief = RELIEF * scene.double(self.deep) * (1 if end < start else -1)
        found, since = [], start
        #  start |   +---+      L: out all the way where so much has been drilled since it was out
        #        v   :   :      last, and back to RELIEF above the bottom; behind the other pecks
        #  D     +-+ :   v      back by RELIEF alone.
        #  D       +-+   +-+
        for depth in ends:
            back = [depth + relief]
            if out and abs(depth - since) >= out - 1e-9:
                back, since = [start, depth + relief], depth
            found.append((depth, [] if depth == ends[-1] else back))
        return found


def without_offset(scene: Scene, block: Block) -> bytes | None:
    """A block of G73 or G74 without its T, None: it has none. Raises ProgramError where T is no
    offset of the place of that in force."""
    word = block.word("T")
    code = next((c for c in block.codes if c in CODES), None)
    if code is None or word is None or word.value is None:
        return None
    tracker = scene.tracker
    other, here = lathe_tool(scene.dialect, int(word.value)), tracker.state.tool
    # The target is reached with the other offset: the same place if both offsets lie alike.
    for axis in "XZ":
        places = [tracker.offset(x, axis) if x else 0.0 for x in (here, other)]
        if here != other and (None in places or places[0] != places[1]):
            raise scene.fault(
                f"G{code // 10} with the offset {other} at its end",
                "write its cuts as G0 and G1, with T before them; or say that both offsets have one"
                f" place: --offset {other}=X0,Z0",
                word,
            )
    return block.written({block.words.index(word)})
