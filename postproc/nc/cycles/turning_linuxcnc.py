"""LinuxCNC's G70, G71 and G72 over a shape in a subroutine, as measured on its interpreter 2.9.

LinuxCNC "G codes", G70 and G71 G72; src/emc/rs274ngc/interp_g7x.cc. The subroutine runs as any
other, only that its motions make the shape; A and C in it finish corners (corners_linuxcnc.py). The
first cut lies at the start point's own depth; each cut
ends on the shape, leaves it at 45 degrees by R (less where the cut is shorter than twice R),
returns, and steps in; behind the last one the tool goes along the shape and out to the depth it
started from, and stays there. D (G70: from D to E in P passes) keeps a distance and rounds outer
corners. Pockets, and the codes that choose them (G71.1 G71.2 G72.1 G72.2): see pockets_linuxcnc.py.
Refused: U and W.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

from postproc.nc.cycles.block import Block, Word, number_of, without
from postproc.nc.cycles.corners_linuxcnc import Finish, finished
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.offset import offset
from postproc.nc.cycles.pockets_linuxcnc import roughing, turning_back
from postproc.nc.cycles.profile import Element, Profile, TooMany, shape
from postproc.nc.cycles.roughing_fanuc import Pen
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene
from postproc.nc.cycles.words import Form

LETTERS = "XZPQDERIUW"
KIND = "a turning cycle"
BEGIN = {"Q": "subroutine of the shape", "X": "start point", "Z": "start point"}
FINISH = BEGIN | {
    "D": "distance of the first pass",
    "E": "distance of the last one",
    "P": "how many passes",
}
ROUGH = BEGIN | {"D": "distance left", "I": "depth of a cut", "R": "escape from a cut"}
MOVES = {"U": "it moves the shape", "W": "it moves the shape"}
ENDLESS = "LinuxCNC never ends with it"
MOST_PASSES = 10_000
NEAR = 1e-6


def _corners(profile: Profile) -> dict[int, Finish]:
    """A and C of the blocks by their numbers; they are taken out."""
    found = {}
    for row, block in enumerate(profile.texts):
        word = next((w for w in block.words if w.letter in "AC"), None)
        if word is not None:
            found[row] = Finish(word.letter, word.value or 0.0)
            profile.texts[row] = without(block, "AC")
    return found


def _straight_in(elements: list[Element], along: int) -> list[Element]:
    """The way in begins beside its first point where it goes against the cuts (g7x::monotonic)."""
    first, last = elements[0], elements[-1]
    sense = 1 if last.end[along] > first.end[along] else -1
    if (first.end[along] - first.start[along]) * sense >= 0:
        return elements
    #         o begin . o start    A way in that comes from beyond the first point would go against
    #  <-cuts-o first point        the cuts: it begins straight above that point instead.
    begin = list(first.start)
    begin[along] = first.end[along]
    return [replace(first, start=(begin[0], begin[1])), *elements[1:]]


def _written(scene: Scene, number: int) -> list[bytes]:
    """The lines of a subroutine as they stand in the program."""
    lines = scene.lines()
    name = rb"[ \t]*[oO][ \t]*<?[ \t]*%d[ \t]*>?[ \t]*" % number
    begin, end = (
        next((i for i, text in enumerate(lines) if re.match(name + word, text, re.I)), -1)
        for word in (b"sub", b"endsub")
    )
    if begin < 0 or end < begin:
        raise scene.fault(
            f"there is no subroutine O{number} in this file",
            "write the shape as O.. sub to O.. endsub",
        )
    return lines[begin + 1 : end]


def _no_motion(word: Word) -> bool:
    number = number_of(word)
    return number is not None and number not in (0, 10, CLOCKWISE, COUNTER)


class LinuxcncTurning(Cycle):
    """G70, G71, G72."""

    codes = (700, 710, 711, 712, 720, 721, 722)

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of the cycle (convert_g7x of the interpreter)."""
        if code == 722:
            return (Form(KIND, never=ENDLESS),)
        return (Form(KIND, FINISH) if code == 700 else Form(KIND, ROUGH, refused=MOVES, zero="UW"),)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of the block. Raises ProgramError."""
        self._check(scene, block, code)
        begin = {x: block.get(x) if block.get(x) is not None else scene.at(x) for x in "XZ"}
        corner = begin["Z"] or 0.0, (begin["X"] or 0.0) / scene.double("X")
        profile = self._subroutine(scene, block, begin)
        corners = _corners(profile)
        elements = shape(scene, profile, corner, scene.code("motion"))
        if len(elements) < 2:
            raise scene.fault(
                "the shape has one block", "it needs one to its first point, and the shape"
            )
        m = Moves(scene, own_words(block, LETTERS, {code}))
        pen = Pen(scene, m)
        pen.to("G0", corner)
        along = self._along(scene, elements) if code == 700 else int(code >= 720)
        elements = finished(scene, elements, corners, along)
        elements = _straight_in(elements, along)
        if code == 700:
            self._finish(scene, block, elements, pen, along)
        else:
            self._rough(scene, block, elements, pen, code)
        return Outcome(m.finish())

    @staticmethod
    def _along(scene: Scene, elements: list[Element]) -> int:
        """The direction in which G70 measures a distance: z, or x where the shape turns back."""
        rest = elements[1:]
        for deep in (1, 0):
            if all(p.goes_on for p in roughing(rest, deep, 1.0, 1.0).pieces[: len(rest)]):
                return 1 - deep
        raise scene.fault(
            "the shape of G70 turns back in z and in x", "LinuxCNC refuses it: divide it"
        )

    def _check(self, scene: Scene, block: Block, code: int) -> None:
        name = f"G{code / 10:g}"
        if code == 722:
            raise scene.fault(
                f"{name}: {ENDLESS}", "write G72, or the pockets as shapes of their own"
            )
        if scene.incremental:
            raise scene.fault(f"{name} in G91", "LinuxCNC wants G90")
        if scene.code("plane") != 180:
            raise scene.fault(f"{name} outside the ZX plane", "write G18 before")
        if scene.compensated:
            raise scene.fault(f"{name} with cutter radius compensation on", "end it before: G40")

    @staticmethod
    def _closes(scene: Scene, e: Element) -> None:
        if e.is_arc and abs(math.dist(e.start, e.centre) - math.dist(e.end, e.centre)) > NEAR:
            raise scene.fault(
                "an arc of the shape misses its own end",
                "LinuxCNC moves the end then: write I K finer",
            )

    def _at(
        self, scene: Scene, elements: list[Element], distance: float, along: int
    ) -> list[Element]:
        """The shape at a distance from itself, on the side of the start point."""
        if not distance:
            return elements
        first, rest = elements[0], elements[1:]
        for e in rest:
            self._closes(scene, e)
        # The side of the start point, by the cross product of the shape's way with the way in:
        # above 0 it lies to the left.
        way = rest[-1].start[0] - rest[0].start[0], rest[-1].start[1] - rest[0].start[1]
        aside = first.start[0] - first.end[0], first.start[1] - first.end[1]
        side = way[0] * aside[1] - way[1] * aside[0]
        moved = (
            offset(rest, distance, 1 if side > 0 else -1, along)
            if distance > 0 and abs(side) > NEAR
            else None
        )
        if moved is None:
            raise scene.fault(
                f"a distance of {distance:g} to this shape",
                "its elements are too short for it, or meet in no corner",
            )
        return [replace(first, end=moved[0].start), *moved]

    def _subroutine(self, scene: Scene, block: Block, begin: dict[str, float | None]) -> Profile:
        """The blocks of the subroutine that Q names."""
        q = block.get("Q")
        if q is None or q != int(q):
            raise scene.fault(
                "a turning cycle without the subroutine of its shape", "write Q and its number"
            )
        words = [scene.text(x, value) for x, value in begin.items() if value is not None]
        lines = scene.tracker.shape(int(q), b" ".join([b"G0", *words]))
        if lines is None:
            lines = _written(scene, int(q))
        texts = [Block.of(text, scene.dialect.grammar) for text in lines]
        for part in texts:
            if not part.plain:
                raise scene.fault(
                    "the shape has more than words and numbers:"
                    f" {part.text[:40].decode('latin-1').strip()!r}",
                    "write it out in the subroutine",
                )
            self._followed(scene, part)
        return Profile(texts, 0, 0)

    @staticmethod
    def _followed(scene: Scene, part: Block) -> None:
        """LinuxCNC passes over what is none of its motions, and takes an arc without G2 or G3 for
        clockwise: that is refused, and distances."""
        strange = next(
            (w for w in part.words if w.letter not in "NGXZIKRFSAC" or _no_motion(w)), None
        )
        if strange and strange.letter in "UW":
            raise scene.fault(
                f"{strange.letter}{strange.raw} in the shape of a cycle is a distance",
                "write X and Z",
            )
        if strange:
            raise scene.fault(
                f"{strange.letter}{strange.raw} in the shape of a cycle: LinuxCNC passes over it",
                "take it out of the subroutine",
            )
        if part.word("A") and part.word("C"):
            raise scene.fault("A and C at one corner of the shape", "write one of them")
        if any(part.word(x) for x in "IKR") and not any(
            c in (CLOCKWISE, COUNTER) for c in part.codes
        ):
            raise scene.fault(
                "an arc of the shape without G2 or G3",
                "LinuxCNC takes it for G2: name it in each block",
            )

    def _finish(
        self, scene: Scene, block: Block, elements: list[Element], pen: Pen, along: int
    ) -> None:
        """G70: along the shape, P times, from distance D to E."""
        p, d, e = (block.get(x) for x in "PDE")
        times, e = 1.0 if p is None else p, e or 0.0
        d = e if times == 1 else d or 0.0  # one pass goes along at E
        if times != int(times) or not 1 <= times <= MOST_PASSES:
            raise scene.fault(f"P{times:g} is no number of passes", "write a whole number")
        if abs(elements[-1].end[1 - along] - elements[0].end[1 - along]) < NEAR and (d or e):
            raise scene.fault(
                f"a distance to a shape of one {'XZ'[along]}",
                "LinuxCNC takes the wrong side of it: write it out",
            )
        # Pass k lies E + (k - 1) (D - E) / P off: the last one at E, the first one nearer than D.
        for k in range(int(times), 0, -1):
            path = self._at(scene, elements, (k - 1) * (d - e) / times + e, along)
            pen.to("G0", path[0].start)
            pen.to("G0", path[0].end)
            for x in path[1:]:
                pen.centred(x, "G1")

    def _roughed(
        self, scene: Scene, block: Block, elements: list[Element], deep: int
    ) -> tuple[list[Element], bool]:
        """The shape at the distance D, and whether levels are cut before it."""
        first, rest, d = elements[0], elements[1:], block.get("D") or 0.0
        # A shape of one depth has no side by its ends: LinuxCNC moves it by D towards +X (-Z) then,
        # whatever side the stock is on, and a single line is followed so.
        flat = d > 0 and abs(rest[-1].end[deep] - first.end[deep]) < NEAR
        line = len(rest) == 1 and not rest[0].is_arc and math.dist(first.start, first.end) > NEAR
        if (flat and not line) or abs(rest[-1].end[1 - deep] - first.end[1 - deep]) < NEAR:
            raise scene.fault(
                "the shape does not vary in both X and Z",
                "LinuxCNC takes the wrong side of it: write it out",
            )
        if not flat:
            return self._at(scene, elements, d, 1 - deep), True
        by = (0.0, d) if deep else (-d, 0.0)
        moved = [replace(first, end=rest[0].moved(by).start), rest[0].moved(by)]
        levels = (first.start[deep] - moved[0].end[deep]) * by[deep] > NEAR * d
        if not levels:
            said = (
                f"D{d:g} leaves nothing on this shape of one line: LinuxCNC cuts by that beyond it,"
                " towards " + ("+X" if deep else "-Z") + ", and is followed"
            )
            scene.tell("distance of a line", said)
        return moved, levels

    def _rough(
        self, scene: Scene, block: Block, elements: list[Element], pen: Pen, code: int
    ) -> None:
        """G71 and G72, with pockets, without, or pockets alone."""
        deep = 1 if code < 720 else 0
        elements, levels = self._roughed(scene, block, elements, deep)
        if not levels:
            pen.to("G0", elements[0].start)
            for e in elements:
                pen.to("G1", e.end)
            return
        step = block.get("I")
        retract = block.get("R")
        step, retract = 1.0 if step is None else step, 0.5 if retract is None else retract
        if (
            step <= 0
            or retract <= 0
            or abs(elements[0].end[deep] - elements[0].start[deep]) / step > MOST_PASSES
        ):
            raise scene.fault(
                f"I{step:g} R{retract:g}",
                f"I, the depth of a cut, and R are above 0 ({MOST_PASSES:,} cuts at most)",
            )
        #   x ^
        #     |  --.  / R, at 45 degrees   start
        #     |     \/                     |
        #     |      *<-------- G1 --------+
        #     |       \  /                 | I
        #     |        \/                  |
        #     |         *<----- G1 --------+
        #     |   shape  `----------.
        #     +-------------------------------> z
        rough = roughing(elements, deep, step, retract)
        if any(turning_back(rough.pieces)):
            raise scene.fault(
                "the shape turns back along its cuts", "LinuxCNC refuses it: not monotonic"
            )
        try:
            way = rough.way(code % 10)
        except TooMany:
            raise scene.fault(
                "this shape is never roughed out", "LinuxCNC does not end with it: write it out"
            ) from None
        pen.steps(way)
