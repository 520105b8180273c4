r"""LinuxCNC's G76, threading in many passes, as its passes: G33 with the rapids between.

LinuxCNC "G codes", G76; convert_threading_cycle of its interpreter, and measured on 2.9. All
motions of a pass stay synchronised with the spindle from one G33 to the next, so a tapered entry or
exit is a G33 of its own, with the pitch along the taper.

    drive line  - - - - - - - - - - - -   between passes the tool goes back by I + K
                         | I
    peak        _________|__       ____
                         |  \  1  /       pass n is J n^(1/R) deep: with R 1 all are as deep as the
                       K |   \ 2 /        first, with R 2 all cut as much metal; each begins depth *
                         |    \3/         tan(Q) farther along, so that one flank cuts
    bottom      . . . . .|. . .v

Where X is a diameter the block stays as it is: 2.9 takes I, J and K for a quarter of what its
manual says.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

MOST_PASSES = 10_000
WORDS = {
    "X": "where the tool goes back to",
    "Z": "end of the drive line",
    "P": "pitch",
    "I": "thread's peak beside the drive line",
    "J": "depth of the first cut",
    "K": "full depth",
    "R": "degression",
    "Q": "compound angle",
    "H": "spring passes",
    "L": "which ends are tapered",
    "E": "length of the tapers",
}
LETTERS = "".join(WORDS)
ENTRY, EXIT = 1, 2  # bits of L


@dataclass(frozen=True)
class Thread:
    """A thread, program's unit, X as a radius: from `start` to `end` (x, z); the peak lies `offset`
    beside the drive line, +1 or -1 `out` of it; the first `cut`, the full `depth`; `angle` in
    radians; `taper` along Z."""

    start: tuple[float, float]
    end: tuple[float, float]
    offset: float
    out: int
    cut: float
    depth: float
    pitch: float
    degression: float
    angle: float
    taper: float
    ends: int
    springs: int

    def depths(self) -> list[float]:
        """How deep each pass goes below the peak."""
        # LinuxCNC, "G76", R: the n-th pass is J n^(1/R) deep. The groove is a V, so its area grows
        # by the square of the depth, and R2 takes off the same area in each pass; R1 the same
        # depth.
        result: list[float] = []
        n, depth = 1, self.cut
        while depth < self.depth and len(result) <= MOST_PASSES:
            result.append(depth)
            n += 1
            depth = self.cut * n ** (1 / self.degression)
        return result + [self.depth] * (self.springs + 1)


class LinuxcncThread(Cycle):
    """G76."""

    codes = (760,)
    form = Form("a threading cycle", WORDS)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The passes of a thread. Raises ProgramError."""
        thread = self._read(scene, block)
        half = scene.double("X")
        if half == 2:  # 2.9 halves I, J and K twice here, other releases once
            m = Moves(scene, own_words(block, LETTERS, {code}))
            m.move("G0", {"X": thread.end[0] * half, "Z": thread.end[1]})
            return Outcome([block.text], m.finish())
        depths = thread.depths()
        if len(depths) > MOST_PASSES:
            raise scene.fault(
                f"the thread takes more than {MOST_PASSES:,} passes", "check J, K and R"
            )
        m = Moves(scene, own_words(block, LETTERS, {code}))
        (x0, z0), (x1, z1) = thread.start, thread.end
        # Q, the compound slide: a pass d deep is moved by d tan(Q) against the feed, so that the
        # tool cuts with one flank; the full depth ends at Z. Entry and exit tapers go along a slope
        # on which K, the way of a revolution, counts along the slope: Z keeps the pitch.
        far = z1 + thread.depth * math.tan(thread.angle)
        along = [b"K" + scene.text("K", thread.pitch)[1:]]
        slope = math.hypot(thread.taper, thread.depth) / abs(thread.taper) if thread.taper else 1.0
        slanted = [b"K" + scene.text("K", thread.pitch * slope)[1:]]
        for depth in depths:
            below = depth * math.tan(thread.angle)
            bottom = x0 + thread.out * (thread.offset + depth)
            top = bottom - thread.out * thread.depth
            clear = bottom - thread.out * (thread.depth + thread.offset)
            m.move("G0", {"X": clear, "Z": z0 - below})
            if thread.taper and thread.ends & ENTRY:
                m.move("G33", {"X": top}, *slanted)
                m.move("G33", {"X": bottom, "Z": z0 - below - thread.taper}, *slanted)
            else:
                m.move("G0", {"X": bottom})
            if thread.taper and thread.ends & EXIT:
                m.move("G33", {"Z": far - below + thread.taper}, *along)
                m.move("G33", {"X": top, "Z": far - below}, *slanted)
            else:
                m.move("G33", {"Z": far - below}, *along)
            m.move("G0", {"X": clear})
        m.move("G0", {"X": x1, "Z": z1})
        return Outcome(m.finish())

    # Whole: a word of G76 to a line, with LinuxCNC's refusals.
    def _read(self, scene: Scene, block: Block) -> Thread:
        """The words of the block. Raises ProgramError where LinuxCNC refuses them."""
        self._check(scene, block)
        pitch, i, j, k, q, r, h, e, flags = (block.get(x) or 0.0 for x in "PIJKQRHEL")
        half = scene.double("X")
        if i == 0 or j <= 0 or k <= j:
            raise scene.fault(
                f"I{i:g} J{j:g} K{k:g} make no thread",
                "I is not 0, J above 0, and K, the full depth, above J",
            )
        if h != int(h) or not 0 <= h <= MOST_PASSES or flags != int(flags) or flags < 0:
            raise scene.fault(
                f"H{h:g} L{flags:g}", "H is a whole number of spring passes, L is 0, 1, 2 or 3"
            )
        end = {}
        for axis in "XZ":
            value = block.get(axis)
            here = scene.at(axis)
            end[axis] = here if value is None else here + value if scene.incremental else value
        # Seen from the start: the thread runs to -Z with 1, and `below` and the tapers turn with
        # it.
        sign = -1 if end["Z"] > scene.at("Z") else 1
        return Thread(
            start=(scene.at("X") / half, scene.at("Z")),
            end=(end["X"] / half, end["Z"]),
            offset=abs(i) / half,
            out=1 if i > 0 else -1,
            cut=j / half,
            depth=k / half,
            pitch=pitch,
            degression=max(r or 1.0, 1.0),
            angle=math.radians(q) * sign,
            taper=max(e, 0.0) * sign,
            ends=int(flags),
            springs=int(h),
        )

    def _check(self, scene: Scene, block: Block) -> None:
        """Raises ProgramError where LinuxCNC cuts no thread, or not without more words."""
        if scene.compensated:
            raise scene.fault("G76 with cutter radius compensation on", "end it before: G40")
        if scene.spindle not in (3, 4):
            raise scene.fault(
                "G76 cuts a thread, and the spindle does not turn",
                "start it before: S and M3 or M4",
            )
        if block.get("X") is None and block.get("Z") is None:
            raise scene.fault("G76 without Z", "write where the thread ends")
        if missing := [x for x in "PIJK" if block.get(x) is None]:
            raise scene.fault(
                f"G76 without {' and '.join(missing)}", "LinuxCNC wants P, I, J and K"
            )
