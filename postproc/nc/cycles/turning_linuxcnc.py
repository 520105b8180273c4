"""LinuxCNC's G70, G71 and G72 over a shape in a subroutine, as measured on its interpreter 2.9.

LinuxCNC "G codes", G70 and G71 G72. The first cut lies at the start point's own depth; each cut
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

from postproc.nc.cycles.block import Block, Word, number_of
from postproc.nc.cycles.drilling import Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.offset import offset
from postproc.nc.cycles.pockets_linuxcnc import TooMany, roughing, turning_back
from postproc.nc.cycles.profile import Element, Profile, shape
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


def _no_motion(word: Word) -> bool:
    number = number_of(word)
    return number is not None and number not in (0, 10, CLOCKWISE, COUNTER)


class LinuxcncTurning:
    """G70, G71, G72."""

    modal = False

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of the cycle (convert_g7x of the interpreter)."""
        if code == 722:
            return (Form(KIND, never=ENDLESS),)
        return (Form(KIND, FINISH) if code == 700 else Form(KIND, ROUGH, refused=MOVES, zero="UW"),)

    def end(self) -> None:
        return

    def wants(self, scene: Scene, block: Block) -> bool:
        return False

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of the block. Raises ProgramError."""
        self._check(scene, block, code)
        profile = self._subroutine(scene, block)
        half = 2 if scene.is_diameter("X") else 1
        begin = {x: block.get(x) if block.get(x) is not None else scene.at(x) for x in "XZ"}
        corner = begin["Z"] or 0.0, (begin["X"] or 0.0) / half
        elements = shape(scene, profile, corner, scene.code("motion"))
        if len(elements) < 2:
            raise scene.fault(
                "the shape has one block", "it needs one to its first point, and the shape"
            )
        m = Moves(scene, own_words(block, LETTERS, {code}))
        if code == 700:
            self._finish(scene, block, elements, m)
        else:
            self._rough(scene, block, elements, m, code)
        return Outcome(m.finish())

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
        way = rest[-1].end[0] - rest[0].start[0], rest[-1].end[1] - rest[0].start[1]
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

    def _subroutine(self, scene: Scene, block: Block) -> Profile:
        """The blocks of the subroutine that Q names."""
        q = block.get("Q")
        if q is None or q != int(q):
            raise scene.fault(
                "a turning cycle without the subroutine of its shape", "write Q and its number"
            )
        lines = scene.lines()
        name = rb"[ \t]*[oO][ \t]*<?[ \t]*%d[ \t]*>?[ \t]*" % int(q)
        begin = next(
            (i for i, text in enumerate(lines) if re.match(name + rb"[sS][uU][bB]", text)), None
        )
        end = next(
            (
                i
                for i, text in enumerate(lines)
                if re.match(name + rb"[eE][nN][dD][sS][uU][bB]", text)
            ),
            None,
        )
        if begin is None or end is None or end < begin:
            raise scene.fault(
                f"there is no subroutine O{q:g} in this file",
                "write the shape as O.. sub to O.. endsub",
            )
        texts = []
        for text in lines[begin + 1 : end]:
            part = Block.of(text, scene.dialect.grammar)
            if not part.plain and (worked := scene.tracker.rendered(text)) is not None:
                part = Block.of(worked, scene.dialect.grammar)
            if not part.plain:
                raise scene.fault(
                    "the shape has more than words and numbers:"
                    f" {text[:40].decode('latin-1').strip()!r}",
                    "write it out in the subroutine",
                )
            self._followed(scene, part)
            texts.append(part)
        return Profile(texts, begin + 2, end)

    @staticmethod
    def _followed(scene: Scene, part: Block) -> None:
        """LinuxCNC passes over all words of the shape but those of its motions and of rotary axes,
        which it moves, and takes an arc without G2 or G3 for clockwise: all that is refused."""
        strange = next(
            (w for w in part.words if w.letter not in "NGXZIKRFS" or _no_motion(w)), None
        )
        if strange:
            if strange.letter in "ABC":
                raise scene.fault(
                    f"{strange.letter}{strange.raw} in the shape of a cycle: when LinuxCNC moves"
                    " that axis is not followed",
                    "take it out of the subroutine",
                )
            raise scene.fault(
                f"{strange.letter}{strange.raw} in the shape of a cycle: LinuxCNC passes over it",
                "take it out of the subroutine",
            )
        if any(part.word(x) for x in "IKR") and not any(
            c in (CLOCKWISE, COUNTER) for c in part.codes
        ):
            raise scene.fault(
                "an arc of the shape without G2 or G3",
                "LinuxCNC takes it for G2: name it in each block",
            )

    def _finish(self, scene: Scene, block: Block, elements: list[Element], m: Moves) -> None:
        """G70: along the shape, P times, from distance D to E."""
        p, d, e = (block.get(x) for x in "PDE")
        times, e = 1.0 if p is None else p, e or 0.0
        d = e if times == 1 else d or 0.0  # one pass goes along at E
        if times != int(times) or not 1 <= times <= MOST_PASSES:
            raise scene.fault(f"P{times:g} is no number of passes", "write a whole number")
        first, flat = elements[0], abs(elements[-1].end[1] - elements[0].end[1]) < NEAR
        if flat and (d or e):
            raise scene.fault(
                "a distance to a shape of one X",
                "LinuxCNC takes the wrong side of it: write it out",
            )
        oblique = min(abs(first.end[i] - first.start[i]) for i in (0, 1)) > NEAR
        if any(x.end[0] > x.start[0] + NEAR for x in elements) and (times > 1 or d or e or oblique):
            raise scene.fault(
                "G70 along a shape that goes towards +Z",
                "only one pass is written out, without E, behind a first "
                "block that moves X or Z alone",
            )
        for k in range(int(times), 0, -1):
            path = self._at(scene, elements, (k - 1) * (d - e) / times + e, 0)
            self._to(m, "G0", path[0].start)
            self._to(m, "G0", path[0].end)
            for x in path[1:]:
                self._element(m, x)

    def _rough(
        self, scene: Scene, block: Block, elements: list[Element], m: Moves, code: int
    ) -> None:
        """G71 and G72, with pockets, without, or pockets alone."""
        deep = 1 if code < 720 else 0
        along = 1 - deep
        flat = abs(elements[-1].end[deep] - elements[0].end[deep]) < NEAR
        if (flat and block.get("D")) or abs(
            elements[-1].end[along] - elements[0].end[along]
        ) < NEAR:
            raise scene.fault(
                "the shape does not vary in both X and Z",
                "LinuxCNC takes the wrong side of it: write it out",
            )
        side = 1 if elements[-1].end[along] > elements[0].start[along] else -1
        # it begins beside its first point then
        if (elements[0].end[along] - elements[0].start[along]) * side < 0:
            begin = list(elements[0].start)
            begin[along] = elements[0].end[along]
            elements = [replace(elements[0], start=(begin[0], begin[1])), *elements[1:]]
        elements = self._at(scene, elements, block.get("D") or 0.0, along)
        for e in elements[1:]:
            self._closes(scene, e)
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
        for s in way:
            if s.code in ("G0", "G1"):
                self._to(m, s.code, s.end)
            else:
                self._arc(m, s.code, s.end, s.centre)

    @staticmethod
    def _to(m: Moves, code: str, to: tuple[float, float]) -> None:
        half = 2 if m.scene.is_diameter("X") else 1
        m.move(code, {"X": to[1] * half, "Z": to[0]})

    def _element(self, m: Moves, e: Element) -> None:
        if e.is_arc:
            self._arc(m, "G2" if e.code == CLOCKWISE else "G3", e.end, e.centre)
        else:
            self._to(m, "G1", e.end)

    @staticmethod
    def _arc(m: Moves, code: str, end: tuple[float, float], centre: tuple[float, float]) -> None:
        """An arc from where the last motion ended."""
        scene = m.scene
        half = 2 if scene.is_diameter("X") else 1
        words = [
            scene.text("I", centre[1] - scene.at("X") / half),
            scene.text("K", centre[0] - scene.at("Z")),
        ]
        m.move(code, {"X": end[1] * half, "Z": end[0]}, *words)
