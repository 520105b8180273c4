"""G12 and G13 of Haas mills: circular pockets, clockwise and counter-clockwise, from the centre out
and back.

Haas mill operator's manual, "G12 Circular Pocket Milling CW / G13 CCW", and VF series manual (June
1999), page 237: the tool stands in the centre, goes down to Z at F, cuts a circle of radius I, or
circles from I by Q up to K, each less the tool's radius that D names (D0: the tool's centre), and
ends in the centre at depth; in G91 Z is a distance, and L how often. The cut is made of arcs alone
(P. Smid, CNC Programming Handbook: half a circle in, the circle, half a circle out).

Assumed: circles begin on the X axis, and half circles lead from each to the next. Whatever the
control does there lies within the same pocket. Refused: a centre X Y in the block, for how it is
gone to is not certain; other planes.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

CLOCKWISE, COUNTER = 120, 130
MOST_CIRCLES, MOST_DEPTHS = 1000, 1000
WORDS = {
    "I": "radius of the first circle",
    "K": "radius of the last circle",
    "Q": "how much wider each one is",
    "D": "the tool's radius",
    "Z": "depth",
    "L": "how often, each time deeper",
}
NEAR = 1e-9


class CircularPocket(Cycle):
    """G12 G13."""

    codes = (CLOCKWISE, COUNTER)
    form = Form("a pocket cycle", WORDS)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a pocket. Raises ProgramError."""
        name = f"G{code // 10}"
        if scene.code("plane") != 170:
            raise scene.fault(f"{name} outside the XY plane", "write G17 before it")
        if scene.code("cutter") in (410, 420):
            raise scene.fault(
                f"{name} with cutter radius compensation on",
                "write G40 before it: D says the radius",
            )
        radii = self._radii(scene, block, name)
        depth, times = block.word("Z"), block.word("L")
        count = int(times.value or 0) if times else 1
        # With Z a place every round would cut at one depth: repeats are followed in G91 alone,
        # where the manual has them.
        if not 1 <= count <= MOST_DEPTHS or (count > 1 and not (scene.incremental and depth)):
            raise scene.fault(
                f"L{count} of {name}", "it repeats with Z in G91: write G91 and Z, or no L", times
            )
        m = Moves(scene, own_words(block, "".join(WORDS), {code}))
        at, z = scene.at("X"), scene.at("Z")
        down = scene.length(depth, "Z") if depth else 0.0
        for k in range(1, count + 1):
            if depth:
                m.move("G1", {"Z": z + k * down if scene.incremental else down})
            self._arcs(scene, m, "G2" if code == CLOCKWISE else "G3", at, radii)
        return Outcome(m.finish())

    def _arcs(self, scene: Scene, m: Moves, arc: str, centre: float, radii: list[float]) -> None:
        """Half circles about points of the X axis, from the centre out and back."""
        # In by half a circle to r, around by two halves (a block whose end is its start would be a
        # full circle, or nothing), and by half a circle to the other side of the next one:
        #
        #   -r2 . . . -r1 . . . 0 . . . r1 . . . r2
        #     (_________________________)             of diameter r1 + r2: it touches the circle of
        #                                             r2 at its end and lies within it
        side, ends = 1.0, [0.0]
        for radius in radii:
            ends += [side * radius, -side * radius, side * radius]
            side = -side
        y = scene.at("Y")
        for one, other in zip(ends, [*ends[1:], 0.0], strict=True):
            half = scene.text("I", (other - one) / 2)
            m.move(arc, {"X": centre + other, "Y": y}, half, b"J0.")

    def _radii(self, scene: Scene, block: Block, name: str) -> list[float]:
        """The radii of the tool's centre, program's unit."""
        first, last, step = (self._length(scene, block.word(x)) for x in "IKQ")
        if first is None:
            raise scene.fault(f"the first circle of {name} has no radius", "write it as I")
        if (last is None) != (step is None):
            raise scene.fault(
                f"{name} with one of K and Q",
                "write both, or I alone",
                block.word("K") or block.word("Q"),
            )
        radii = [first]
        while last is not None and step is not None and radii[-1] < last - NEAR:
            if step <= 0 or len(radii) > MOST_CIRCLES:
                raise scene.fault(
                    f"Q{step:g} takes {name} in more than {MOST_CIRCLES:,} circles to K",
                    "write it above 0",
                )
            # The last step is what is left up to K.
            radii.append(min(radii[-1] + step, last))
        tool = self._tool(scene, block, name)
        if radii[0] <= tool:
            raise scene.fault(
                f"I{first:g} of {name} is no wider than the tool, {tool:g}",
                "write I above the tool's radius",
            )
        return [radius - tool for radius in radii]

    @staticmethod
    def _length(scene: Scene, word: Word | None) -> float | None:
        return None if word is None else scene.length(word, "X")

    @staticmethod
    def _tool(scene: Scene, block: Block, name: str) -> float:
        """The radius that D names, program's unit."""
        number = block.get("D")
        if number is None:
            raise scene.fault(
                f"the tool of {name} has no radius",
                "name it by D, or D0 for the path of its centre",
            )
        return scene.tool_radius(name, block) if number else 0.0
