"""G70 to G73 of Fanuc and Haas lathes, over a shape that stands in the program.

Fanuc B-64304EN-1, "Multiple repetitive cycle"; the order of motions and which of them are rapids also in the lathe
maker Robur's concise guide to Fanuc, pages 48 and 57.

Assumed: the depths of G71 and G72 count from the start point moved by the finishing allowances; the cut that would
reach the depth of the shape's first point, or go beyond it, is left to the last one along the shape; the tool escapes
at 45 degrees in rapid, and returns to the start point in one rapid. RETRACT stands for parameter 5133 where R does
not say it.

G41 G42 in the shape: G70 runs its blocks as they stand, so they hold there, and must end within it (G40). The roughing
of Fanuc passes over them (P. Smid, CNC Programming Handbook, "Tool nose radius offset" of G71), which a notice says;
B-64304EN-1 itself wants them before the cycle. Haas' roughs with them (lathe operator's manual, "TNC with a G71 Roughing
Canned Cycle"): the last cut, along the shape, has them here, and the cuts before it end on the shape as programmed, which
a notice says too. There a last block that rapids back along the cuts, as such shapes have it for G40, is no part of the
shape; Fanuc's stops at it. R1 of Haas, and a first block in X and Z, choose type II: a shape without pockets is the same in
both, and each cut begins on the first block. I K of G71 G72, the allowance of a rough finishing pass, and pockets are refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from postproc.errors import Notice
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.drilling import UNDEFINED, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.profile import NOSE, Element, Profile, find, shape
from postproc.nc.cycles.scene import CLOCKWISE, Scene
from postproc.nc.cycles.words import Form

RETRACT = {False: 0.5, True: 0.02}  # mm, inch, radius
MOST_PASSES = 10_000
OWN = "XZUWPQRDIK"
KIND = "a turning cycle"
SHAPE = {"P": "first block of the shape", "Q": "last block of the shape"}
ALLOWANCE = {"U": "allowance along X, a diameter", "W": "allowance along Z"}
ESCAPE = {"R": "escape from a cut"}
ROUGH_FINISH = "the allowance of a rough finishing pass"
NOT_WRITTEN = {"I": ROUGH_FINISH, "K": ROUGH_FINISH}
TYPE_II = {
    True: {"R": "a type other than 1"},
    False: {"R": "it chooses type II on a Haas"},
}  # whether it is Haas'


@dataclass
class Repetitive:
    """G70 to G73 of one lathe. `roles`: ten times the G number to what it is: finish, rough, face, repeat."""

    roles: dict[int, str]
    haas: bool = False
    held: dict[str, dict[str, float]] = field(default_factory=dict)
    modal = False

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of one role: of the first of two blocks, and of the second one or of one alone."""
        role = self.roles[code]
        if role == "finish":
            return (Form(KIND, SHAPE),)
        first, second = "first of two blocks", "second block, or one alone"
        if role == "repeat":
            whole = {
                "U": "distance of the first cut along X, a radius",
                "W": "the same along Z",
                "R": "how many cuts",
            }
            alone = {"I": "as U of the first block", "K": "as W of it", "D": "as R of it"}
            return Form(KIND, whole, name=first, unless="PQ"), Form(
                KIND, SHAPE | ALLOWANCE | alone, name=second
            )
        depth = {"U" if role == "rough" else "W": "depth of a cut"}
        alone, one = {"D": "depth of a cut"}, "R" * self.haas
        return (
            Form(KIND, depth | ESCAPE, name=first, unless="PQ"),
            Form(
                KIND,
                SHAPE | ALLOWANCE | alone,
                refused=NOT_WRITTEN | TYPE_II[self.haas],
                one=one,
                name=second,
            ),
        )

    def end(self) -> None:
        return

    def wants(self, scene: Scene, block: Block) -> bool:
        return False

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        role = self.roles[code]
        if scene.code("cutter") in (410, 420):
            raise scene.fault(
                f"G{code / 10:g} with nose radius compensation on", "write G40 before it"
            )
        own = own_words(block, OWN, {code})
        if role != "finish" and not any(block.word(x) for x in "PQ"):
            self._hold(scene, block, role)
            return Outcome(Moves(scene, own).finish())
        begin, end = (self._number(scene, block, code, x) for x in "PQ")
        after = 0 if role == "finish" else scene.source
        profile = find(scene, scene.lines(), begin, end, after)
        m = Moves(scene, own)
        if role == "finish":
            return self._finish(scene, block, profile, m)
        nose = self._nose(scene, code, profile)
        start = (scene.at("Z"), scene.at("X") / _half(scene))
        elements = shape(scene, profile, start, scene.code("motion"))
        allowance = (_word(scene, block, "W", "Z"), _word(scene, block, "U", "X") / _half(scene))
        if role == "repeat":
            self._repeat(scene, block, elements, allowance, start, m)
        else:
            self._rough(scene, block, role, elements, allowance, start, m, nose)
        return Outcome(m.finish(), skip=(profile.first, profile.last), then=UNDEFINED)

    def _number(self, scene: Scene, block: Block, code: int, letter: str) -> int:
        """P or Q, the number of a block."""
        word = block.word(letter)
        if word is None or word.value is None or word.value != int(word.value) or word.value < 0:
            raise scene.fault(
                f"G{code / 10:g} without the number of a block in {letter}",
                "P and Q name the first and last block of the shape: write both, as whole numbers",
                word or block.word("PQ".replace(letter, "")),
            )
        return int(word.value)

    def _nose(self, scene: Scene, code: int, profile: Profile) -> str:
        """G41 or G42 in the shape of a roughing, if the roughing goes by it; else ""."""
        side = next((c for b in profile.texts for c in b.codes if c in NOSE and c != 400), None)
        if side is None:
            return ""
        name = f"G{side // 10} in the shape of G{code / 10:g}"
        if self.haas and self.roles[code] == "repeat":
            raise scene.fault(
                name, "give the roughing a shape of its own without it, and G70 the one with it"
            )
        said = (
            "holds in the cut along the shape: those before it end on the shape as programmed, by as much as the nose differs"
            if self.haas
            else "holds in G70 alone: the roughing is written out without it (newer controls stop there, and want it named "
            "before the cycle)"
        )
        scene.notices.append(Notice(f"nose {code}", f"{name} {said}", scene.source))
        return f" G{side // 10}" if self.haas else ""

    def _hold(self, scene: Scene, block: Block, role: str) -> None:
        """The first of two blocks: depth of cut, escape, divisions."""
        if not any(block.word(x) for x in "UWR"):
            raise scene.fault(
                "a turning cycle without its words", "P and Q name the blocks of its shape"
            )
        kept = self.held.setdefault(role, {})
        for word in block.words:
            if word.letter in "UWR" and word.value is not None:
                kept[word.letter] = (
                    word.value
                    if role == "repeat" and word.letter == "R"
                    else scene.length(word, "X")
                )

    # -- G71 G72 -------------------------------------------------------------------------------------------------------

    def _rough(
        self, scene: Scene, block: Block, role: str, elements: list[Element], allowance: tuple[float, float],
        start: tuple[float, float], m: Moves, nose: str,
    ) -> None:  # fmt: skip
        """Cuts parallel to Z (G71) or X (G72), then one along the shape."""
        deep, along = (
            (1, 0) if role == "rough" else (0, 1)
        )  # which of (z, x) is gone down in, and which is cut along
        word = block.word("D")
        letter = "U" if role == "rough" else "W"
        depth = scene.counted(word, "X") if word else self.held.get(role, {}).get(letter, 0.0)
        escape = self.held.get(role, {}).get("R", RETRACT[scene.inch])
        if depth <= 0:
            raise scene.fault(
                f"the depth of cut is not in the program ({letter} in a block before)",
                f"the control takes it from a parameter: write {letter} above 0",
            )
        first, *rest = (e.moved(allowance) for e in elements)
        if first.is_arc or first.start[deep] == first.end[deep]:
            raise scene.fault(
                f"the first block of the shape does not go to its depth in {'ZX'[deep]}",
                "let it be G0 or G1 to the first point of the shape",
            )
        if not rest:
            raise scene.fault(
                "the shape has one block", "it needs one to its first point, and the shape"
            )
        if (
            self.haas
            and len(rest) > 1
            and rest[-1].code == 0
            and _turns([e.end[along] - e.start[along] for e in rest])
        ):
            rest.pop()  # it draws the tool out
        self._monotonic(scene, rest, along)
        if (rest[-1].end[deep] - rest[0].start[deep]) * (
            first.end[deep] - first.start[deep]
        ) > 1e-9:
            raise scene.fault(
                f"the shape goes deeper in {'ZX'[deep]} behind its first block",
                "its first block must go to the greatest depth: other shapes, with pockets, are not written out",
            )
        c = [start[0] + allowance[0], start[1] + allowance[1]]
        target = rest[0].start[deep]
        sense = 1 if target > c[deep] else -1
        side = 1 if rest[-1].end[along] > c[along] else -1
        infeed = "G0" if first.code == 0 else "G1"
        self._to(scene, m, "G0", c[0], c[1])
        level = c[deep]
        passes = int(abs(target - c[deep]) / depth) + 1
        if passes > MOST_PASSES:
            raise scene.fault(
                f"{passes:,} cuts of {depth:g} (limit {MOST_PASSES:,})", "check the depth of cut"
            )
        for k in range(1, passes + 1):
            level = c[deep] + sense * k * depth
            if (target - level) * sense <= 1e-9:
                break
            stop = next(
                (v for e in rest if (v := e.crossing(deep, level)) is not None), rest[-1].end[along]
            )
            begin = first.crossing(deep, level)  # on the first block, where it moves both axes too
            assert begin is not None
            self._to(scene, m, infeed, *((begin, level) if deep else (level, begin)))
            self._axis(scene, m, "G1", along, stop)
            out = [0.0, 0.0]
            out[deep], out[along] = level - sense * escape, stop - side * escape
            self._to(scene, m, "G0", *out)
            self._axis(scene, m, "G0", along, begin)
        self._to(scene, m, infeed + nose, *first.end)
        for e in rest:
            self._element(scene, m, e)
        self._to(scene, m, "G0 G40" if nose else "G0", *start)

    def _monotonic(self, scene: Scene, elements: list[Element], along: int) -> None:
        """Type I: neither Z nor X turns back, also not in a last block that only draws the tool out."""
        for axis in (0, 1):
            ways = [e.end[axis] - e.start[axis] for e in elements]
            if not _turns(ways):
                continue
            if axis == along and not _turns(ways[:-1]):
                raise scene.fault(
                    f"the last block of the shape takes {'ZX'[axis]} back",
                    "that is no part of the contour: end the shape before it, the cycle goes back by itself",
                )
            raise scene.fault(
                f"{'ZX'[axis]} turns back within the shape",
                "such a shape (type II, pockets) is not written out",
            )
        if not all(e.monotonic for e in elements):
            raise scene.fault(
                "an arc of the shape goes beyond a quadrant",
                "such a shape (type II) is not written out",
            )

    # -- G73 G70 -------------------------------------------------------------------------------------------------------

    def _repeat(
        self, scene: Scene, block: Block, elements: list[Element], allowance: tuple[float, float],
        start: tuple[float, float], m: Moves,
    ) -> None:  # fmt: skip
        """The whole shape, nearer each time."""
        kept = self.held.get("repeat", {})
        words = [block.get(x) for x in "IKD"]
        x, z, times = (
            w if w is not None else kept.get(c) for w, c in zip(words, "UWR", strict=True)
        )
        if times is None or times != int(times) or not 1 <= times <= MOST_PASSES:
            raise scene.fault(
                "how often the shape is cut is not in the program",
                "write R in the block before: a whole number",
            )
        for k in range(int(times)):
            share = (times - 1 - k) / (times - 1) if times > 1 else 0.0
            by = (allowance[0] + share * (z or 0.0), allowance[1] + share * (x or 0.0))
            self._to(scene, m, "G0", start[0] + by[0], start[1] + by[1])
            for e in elements:
                self._element(scene, m, e.moved(by))
        self._to(scene, m, "G0", *start)

    def _finish(self, scene: Scene, block: Block, profile: Profile, m: Moves) -> Outcome:
        """G70: the blocks of the shape as they stand, and back to the start point."""
        start = {x: scene.at(x) for x in "XZ"}
        texts = [text for text in m.finish() if text.strip(b" \t\r/")]
        scene.forget()
        texts += [b.text for b in profile.texts]
        back = [b"G0", *(scene.text(x, value) for x, value in start.items())]
        if scene.incremental or any(910 in b.codes for b in profile.texts):
            raise scene.fault(
                "G70 in G91", "write the shape in absolute words: the way back is not known here"
            )
        nose = [c for b in profile.texts for c in b.codes if c in NOSE]
        if nose and nose[-1] != 400:
            raise scene.fault(
                f"G{nose[-1] // 10} is still on at the end of the shape of G70",
                "write G40 in its last block: controls differ on the way back with it",
            )
        motions = [c for b in profile.texts for c in b.codes if scene.group_of(c) == "motion"]
        return Outcome([*texts, b" ".join(back)], then=motions[-1] if motions else None)

    # -- motions -------------------------------------------------------------------------------------------------------

    def _to(self, scene: Scene, m: Moves, code: str, z: float, x: float) -> None:
        m.move(code, {"X": x * _half(scene), "Z": z})

    def _axis(self, scene: Scene, m: Moves, code: str, axis: int, value: float) -> None:
        m.move(code, {"X": value * _half(scene)} if axis else {"Z": value})

    def _element(self, scene: Scene, m: Moves, e: Element) -> None:
        to = {"X": e.end[1] * _half(scene), "Z": e.end[0]}
        if e.is_arc:
            m.move("G2" if e.code == CLOCKWISE else "G3", to, *e.words)
        else:
            m.move("G0" if e.code == 0 else "G1", to)


def _half(scene: Scene) -> float:
    return 2.0 if scene.is_diameter("X") else 1.0


def _word(scene: Scene, block: Block, letter: str, axis: str) -> float:
    word = block.word(letter)
    return scene.length(word, axis) if word else 0.0


def _turns(ways: list[float]) -> bool:
    return min(ways) < -1e-9 and max(ways) > 1e-9
