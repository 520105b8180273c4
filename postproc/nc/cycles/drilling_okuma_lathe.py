"""G181 of Okuma lathes: a hole by a live tool, in the face (with K) or in the side (with I), at
each C, until G180.

Okuma OSP-P200L / P20L programming manual 5238-E, P-139: in a face X is where the cycle starts and Z
where it ends, K by how much it goes on in rapid before it feeds; in a side Z is where it starts and
X where it ends, and I that way; E dwells at the end, in seconds; Q holes stand evenly around C,
from the angle of the block on. From where the tool stands the control turns to C, goes to the
place, in, and back in rapid to where it stood. The way on in rapid lies along the hole, so no place
depends on it: I counts as a diameter, the shorter of the two.
Assumed: Y, where the lathe has that axis, goes with X (Z) to the place; the Q holes follow in the
positive sense (M16 makes them in the other order). Refused: R, neither or both of I and K, G91,
G182 G183 G189, whose ways back are in no page that was found.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

KIND = "a drilling cycle"
PLACES = {"X": "place, or bottom", "Y": "place", "Z": "bottom, or place", "C": "angle"}
SHIFTS = {"K": "on in rapid along Z", "I": "on in rapid along X"}
WORDS = PLACES | SHIFTS | {"E": "dwell at the bottom"}
AROUND = {"Q": "how many holes, evenly round"}
REFUSED = {"R": "the first stroke"}
MOST_HOLES = 1000


class LiveDrilling(Cycle):
    """Its words hold until G180."""

    codes = (1810,)
    form = Form(KIND, WORDS | AROUND, refused=REFUSED)
    modal = True

    def __init__(self) -> None:
        self.held: dict[str, float] = {}

    def end(self) -> None:
        """G180."""
        self.held = {}

    def wants(self, scene: Scene, block: Block) -> bool:
        return any(block.get(x) is not None for x in PLACES)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a hole. Raises ProgramError."""
        if scene.incremental:
            raise scene.fault("G181 in G91", "write G90 before it")
        for word in block.words:
            if word.letter in WORDS:
                axis = {"I": "X", "K": "Z"}.get(word.letter, word.letter)
                held = word.value or 0.0 if axis == "E" else scene.length(word, axis)
                self.held[word.letter] = held
        m = Moves(scene, own_words(block, "".join(WORDS | AROUND), {code}))
        # G181 with shifts alone makes no hole: the words are kept for the places behind it.
        if not self.wants(scene, block):
            return Outcome(m.finish())
        angle = self.held.get("C", 0.0)
        for k, turned in enumerate(self._angles(scene, block, angle)):
            if k:
                self.held["C"] = turned
            self._hole(scene, m)
        return Outcome(m.finish())

    def _angles(self, scene: Scene, block: Block, first: float) -> list[float]:
        """Where the holes of a block stand around C, from 0 to 360 behind the first one."""
        holes, word = block.get("Q"), block.word("Q")
        if holes is None or word is None:
            return [first]
        if "C" not in self.held or holes != int(holes) or not 1 <= holes <= MOST_HOLES:
            raise scene.fault(
                f"G181 with Q{word.raw}",
                f"write C, and a whole number of holes from 1 to {MOST_HOLES:,}",
                word,
            )
        return [first, *((first + 360.0 * k / holes) % 360.0 for k in range(1, int(holes)))]

    def _hole(self, scene: Scene, m: Moves) -> None:
        """In and out at the place that is held. Raises ProgramError."""
        along = self._axis(scene)
        start = scene.at(along)
        bottom = self.held.get(along)
        if bottom is None:
            raise scene.fault(f"G181 without {along}", "write where the hole ends")
        # All words that hold, not the block's alone: X stays where only C is named again.
        place = {x: v for x, v in self.held.items() if x in PLACES and x != along}
        # C first and then the place, as the manual has it.
        m.move("G0", {x: place.pop(x) for x in "C" if x in place})
        m.move("G0", place)
        # Not beyond the bottom: I and K may be larger than the way, and a rapid must not end in the
        # stock.
        shift = min(abs(self.held["K" if along == "Z" else "I"]), abs(start - bottom))
        if shift:
            m.move("G0", {along: start - shift * (1 if start > bottom else -1)})
        m.move("G1", {along: bottom})
        if self.held.get("E"):
            m.line(b"G4 " + scene.text("F", self.held["E"]))
        m.move("G0", {along: start})

    def _axis(self, scene: Scene) -> str:
        named = [x for x in SHIFTS if x in self.held]
        if len(named) != 1:
            raise scene.fault(
                "G181 with neither or both of I and K",
                "write K for a hole in the face, I for one in the side",
            )
        return "Z" if named == ["K"] else "X"
