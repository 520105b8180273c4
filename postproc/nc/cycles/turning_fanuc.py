"""G70 to G73 of Fanuc and Haas lathes, over a shape that stands in the program.

Fanuc B-64304EN-1, "Multiple repetitive cycle"; the order of motions and which of them are rapids
also in the lathe maker Robur's concise guide to Fanuc, pages 48 and 57.

F, S, T and M in the shape are the finishing's (30i B-63944EN-1, 4.2.1, notes 3 and 4: those between
the points A and B "are ineffective", "M and second auxiliary functions are treated in the same way
as F, S, and T functions", and so are G96 and G97).

A roughing takes the first block with the number P behind it; the control keeps where P and Q are,
so G70 with the same numbers means that shape ("Storing P and Q blocks"), whatever else has them.

Assumed: the depths of G71 and G72 count from the start point moved by the finishing allowances; the
cut that would reach the depth of the shape's first point, or go beyond it, is left to the last one
along the shape; the tool escapes at 45 degrees in rapid, and returns to the start point in one
rapid. RETRACT stands for parameter 5133 where R does not say it.

G41 G42 in the shape: G70 runs its blocks as they stand, so they hold there, and must end within it
(G40). The roughing of Fanuc passes over them (P. Smid, CNC Programming Handbook, "Tool nose radius
offset" of G71), which a notice says. G41 G42 before the cycle, as B-64304EN-1 wants them: they go
on through G70 and through the last cut of a roughing, start in its first block, rest on the way
back to the start point and hold behind it ("offset is temporarily canceled"). Haas' roughs with
them (lathe operator's manual, "TNC with a G71 Roughing Canned Cycle"): the last cut, along the
shape, has them here, and the cuts before it end on the shape as programmed, which a notice says
too. There a last block that rapids back along the cuts, as such shapes have it for G40, is no part
of the shape; Fanuc's stops at it. R1 of Haas, and a first block in X and Z, choose type II: a shape
without pockets is the same in both, and each cut begins on the first block; with pockets:
pockets_fanuc.py. I K of G71 G72, the allowance of a rough finishing pass, are refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from postproc.errors import ProgramError
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import UNDEFINED, Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.profile import NOSE, Element, Point, Profile, find, shape
from postproc.nc.cycles.roughing_fanuc import MOST_PASSES, Pen, Roughing, draws_out
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene
from postproc.nc.cycles.words import Form

RETRACT = {False: 0.5, True: 0.02}  # mm, inch, radius
OWN = "XZUVWPQRDIK"
KIND = "a turning cycle"
OF_SHAPE = "the shape"  # in sentences on what the words of the shape lead to
SHAPE = {"P": "first block of the shape", "Q": "last block of the shape"}
ALLOWANCE = {"U": "allowance along X, a diameter", "W": "allowance along Z"}
ESCAPE = {"R": "escape from a cut"}
ALONG = (
    "holds in the cut along the shape: those before it end on the shape as programmed, by"
    " as much as the nose differs"
)
ROUGH_FINISH = "the allowance of a rough finishing pass"
NOT_WRITTEN = {"I": ROUGH_FINISH, "K": ROUGH_FINISH}
# whether it is Haas'
TYPE_II = {True: {"R": "a type other than 1"}, False: {"R": "it chooses type II on a Haas"}}


@dataclass(frozen=True)
class Way:
    """A shape, where the tool stands before the cycle, and what the finishing leaves: (z, x
    radius)."""

    pen: Pen
    elements: list[Element]
    start: Point
    allowance: Point


@dataclass
class Repetitive(Cycle):
    """G70 to G73 of one lathe. `roles`: ten times the G number to what it is: finish, rough, face,
    repeat."""

    roles: dict[int, str]
    haas: bool = False
    held: dict[str, dict[str, float]] = field(default_factory=dict)
    shapes: dict[tuple[int, int], int] = field(default_factory=dict)  # P, Q: the line of P

    def __post_init__(self) -> None:
        self.codes = self.roles

    @property
    def finishing(self) -> str:
        """The code that finishes a shape: G70, in system C G72."""
        return next(f"G{code / 10:g}" for code, role in self.roles.items() if role == "finish")

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of one role: of the first of two blocks, and of the second one or of one
        alone."""
        role = self.roles[code]
        if role == "finish" and self.haas:  # written beside those of G71 by hand: they say nothing
            return (Form(KIND, SHAPE, zero="UW", idle="D"),)
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
                zero="V" * (not self.haas),
                one=one,
                name=second,
            ),
        )

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        role, before = self.roles[code], self._before(scene, code)
        own = own_words(block, OWN, {code})
        if role != "finish" and not any(block.word(x) for x in "PQ"):
            self._hold(scene, block, role)
            return Outcome(Moves(scene, own).finish())
        begin, end = (self._number(scene, block, code, x) for x in "PQ")
        # A roughing means the P behind its own line; G70 may stand anywhere behind the shape, and
        # means the one that a roughing with these numbers found.
        after = 0 if role == "finish" else scene.source
        profile = find(scene, scene.lines(), begin, end, after, self.shapes.get((begin, end), 0))
        self.shapes[begin, end] = profile.first
        m = Moves(scene, own)
        if before and any(c in NOSE for b in profile.texts for c in b.codes):
            raise scene.fault(
                f"G40 G41 G42 in the shape, and{before} before G{code / 10:g}",
                "the control stops there: name it in one of the two places",
            )
        if role == "finish":
            if block.word("D"):
                said = "D in G70 is passed over: the cut along the shape has no depth"
                scene.tell("depth of G70", said)
            return self._finish(scene, profile, m, before)
        nose = self._nose(scene, code, profile, before)
        start = (scene.at("Z"), scene.at("X") / scene.double("X"))
        elements = shape(scene, self._moving(scene, code, profile), start, scene.code("motion"))
        allowance = (
            scene.length_in(block, "W", "Z"),
            scene.length_in(block, "U", "X") / scene.double("X"),
        )
        way = Way(Pen(scene, m), elements, start, allowance)
        if before:
            m.line(b"G40")
        if role == "repeat":
            self._repeat(block, way, nose)
        else:
            self._rough(block, role, profile, way, nose)
        # G41 or G42 rests during the cuts, and holds again behind the way back to the start point.
        texts = [*m.finish(), *([before.encode().strip()] if before else [])]
        # The shape's blocks are the cycle's data: behind a roughing the control goes on behind Q.
        return Outcome(texts, skip=(profile.first, profile.last), then=UNDEFINED)

    def _moving(self, scene: Scene, code: int, profile: Profile) -> Profile:
        """A shape without its M words, which are the finishing's; Haas' stay, and are refused.
        code: of the roughing, which says so; 0: of none."""
        held = [(b, w) for b in profile.texts for w in b.words if w.letter == "M"]
        if self.haas or not held or any(w.value in scene.dialect.m_refuses for _, w in held):
            return profile
        if code:
            said = f"M{held[0][1].raw} in the shape of G{code / 10:g} is executed in"
            scene.tell(f"M of a shape {code}", f"{said} {self.finishing} alone")
        texts = [
            replace(b, words=tuple(w for w in b.words if w.letter != "M")) for b in profile.texts
        ]
        return replace(profile, texts=texts)

    def _before(self, scene: Scene, code: int) -> str:
        """G41 or G42 in force at the cycle, " G42", else ""."""
        side = scene.code("cutter")
        if side not in (410, 420):
            return ""
        if self.haas:
            raise scene.fault(
                f"G{code / 10:g} with G{side // 10} on",
                f"write G40 before it, and G{side // 10} in the first block of the shape",
            )
        return f" G{side // 10}"

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

    def _nose(self, scene: Scene, code: int, profile: Profile, before: str) -> str:
        """G41 or G42 in the shape of a roughing or before it, if it goes by it; else ""."""
        if before:
            said = f"{before.strip()} before G{code / 10:g} {ALONG}"
            scene.tell(f"nose {code}", said)
            return before
        side = next((c for b in profile.texts for c in b.codes if c in NOSE and c != 400), None)
        if side is None:
            return ""
        name = f"G{side // 10} in the shape of G{code / 10:g}"
        if self.haas and self.roles[code] == "repeat":
            raise scene.fault(
                name, "give the roughing a shape of its own without it, and G70 the one with it"
            )
        said = (
            ALONG
            if self.haas
            else (
                f"holds in {self.finishing} alone: the roughing is written out without it (newer"
                " controls stop there, and want it named before the cycle)"
            )
        )
        scene.tell(f"nose {code}", f"{name} {said}")
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
                    else scene.length(word, "Z" if word.letter == "W" else "X")
                )

    # -- G71 G72 -----------------------------------------------------------------------------------

    def _rough(self, block: Block, role: str, profile: Profile, way: Way, nose: str) -> None:
        """Cuts parallel to Z (G71) or X (G72), then one along the shape."""
        scene, deep = way.pen.scene, 1 if role == "rough" else 0
        word = block.word("D")
        letter = "U" if role == "rough" else "W"
        # D of one block counts least increments, U or W of a block before is a length.
        depth = scene.counted(word, "X") if word else self.held.get(role, {}).get(letter, 0.0)
        escape = self.held.get(role, {}).get("R", RETRACT[scene.inch])
        if depth < 0:
            raise scene.fault(
                f"{word.letter if word else letter} {depth:g} as the depth of a cut",
                "a depth has no sign: write it above 0",
            )
        if depth == 0:
            raise scene.fault(
                f"the depth of cut is not in the program ({letter} in a block before)",
                f"the control takes it from a parameter: write {letter} above 0",
            )
        first, *rest = (e.moved(way.allowance) for e in way.elements)
        if not rest:
            raise scene.fault(
                "the shape has one block", "it needs one to its first point, and the shape"
            )
        # The G40 of such a shape stands in its last block, a rapid back: the rough cuts have no use
        # for it.
        if self.haas and draws_out(rest, 1 - deep):
            rest.pop()
        both = self._both(profile)
        stops = not self.haas
        cut = Roughing(
            way.pen, first, rest, deep, way.start, way.allowance, depth, escape, nose, stops
        )
        try:
            cut.write(both or block.get("R") == 1)
        except ProgramError as error:
            if OF_SHAPE in error.message:
                error.advice = _pointless(scene, profile) or error.advice
            raise

    def _both(self, profile: Profile) -> bool:
        """Whether the first block of a shape names X and Z. Haas' may have its number alone in a
        block before."""
        named = ({w.letter for w in block.words} & set("XZUW") for block in profile.texts)
        first = next(filter(None, named), set()) if self.haas else next(named)
        return bool(first & {"X", "U"}) and bool(first & {"Z", "W"})

    # -- G73 G70 -----------------------------------------------------------------------------------

    def _repeat(self, block: Block, way: Way, nose: str) -> None:
        """The whole shape, nearer each time."""
        scene, kept = way.pen.scene, self.held.get("repeat", {})
        x = scene.length_in(block, "I", "X", kept.get("U", 0.0))
        z = scene.length_in(block, "K", "Z", kept.get("W", 0.0))
        times = kept.get("R") if (d := block.word("D")) is None else d.value
        if times is None or times != int(times) or not 1 <= times <= MOST_PASSES:
            raise scene.fault(
                "how often the shape is cut is not in the program",
                "write D here, or R in the block before: a whole number",
            )
        for k in range(int(times)):
            #   k = 0       the shape, moved by U and W of the first block and by the allowance
            #   ...         evenly nearer
            #   k = R - 1   the shape, moved by the allowance alone
            share = (times - 1 - k) / (times - 1) if times > 1 else 0.0
            by = (way.allowance[0] + share * z, way.allowance[1] + share * x)
            way.pen.to("G0", (way.start[0] + by[0], way.start[1] + by[1]))
            for n, e in enumerate(way.elements):
                way.pen.element(e.moved(by), "" if n else nose)
            if nose:
                way.pen.to("G0 G40", (way.start[0] + by[0], way.start[1] + by[1]))
        way.pen.to("G0", way.start)

    # Whole: a list of refusals between the lines that they guard.
    def _finish(self, scene: Scene, profile: Profile, m: Moves, before: str) -> Outcome:
        """G70: the blocks of the shape as they stand, and back to the start point."""
        start = {x: scene.at(x) for x in "XZ"}
        texts = [text for text in m.finish() if text.strip(b" \t\r/")]
        scene.forget()
        if profile.drawn(scene):
            texts += self._drawn(scene, profile, self._moving(scene, 0, profile))
        else:
            texts += [b.text for b in profile.texts]
        # In one rapid; G41 and G42 before the cycle rest on the way (G40) and are named again
        # behind it.
        back = [b"G0", *[b"G40"] * bool(before), *(scene.text(x, v) for x, v in start.items())]
        codes = [c for b in profile.texts for c in b.codes]
        if scene.incremental or 910 in codes:
            raise scene.fault(
                f"{self.finishing} in G91",
                "write the shape in absolute words: the way back is not known here",
            )
        nose = [c for c in codes if c in NOSE]
        if nose and nose[-1] != 400:
            raise scene.fault(
                f"G{nose[-1] // 10} is still on at the end of the shape of {self.finishing}",
                "write G40 in its last block: controls differ on the way back with it",
            )
        motions = [c for c in codes if scene.group_of(c) == "motion"]
        texts += [b" ".join(back), *[before.encode().strip()] * bool(before)]
        return Outcome(texts, then=motions[-1] if motions else None)

    def _drawn(self, scene: Scene, profile: Profile, moving: Profile) -> list[bytes]:
        """The blocks of a shape with corners or angles, each with the ends of its own elements."""
        half = scene.double("X")
        here = (scene.at("Z"), scene.at("X") / half)
        elements = shape(scene, moving, here, scene.code("motion"))
        texts = []
        for row, block in enumerate(profile.texts):
            # A corner belongs to the block before it (its row), so F and G41 of a block stay with
            # its own ends.
            own = [e for e in elements if e.row == row]
            letters = "XZUWCRAIK" if own else ""
            out = own_words(block, letters, {0, 10, CLOCKWISE, COUNTER})
            lines = [
                b" ".join(
                    [
                        b"G%d" % (e.code // 10),
                        scene.text("X", e.end[1] * half),
                        scene.text("Z", e.end[0]),
                        *e.words,
                    ]
                )
                for e in own
            ]
            texts += [block.written(out, lines[0]), *lines[1:]] if own else [block.text]
        return texts


def _pointless(scene: Scene, profile: Profile) -> str:
    """The way out where a place of the shape has no decimal point and counts least increments."""
    words = (w for block in profile.texts for w in block.words if w.letter in "XZUW")
    bare = next((w for w in words if w.value and "." not in w.raw), None)
    if bare is None or not scene.tracker.counts:
        return ""
    said = f"{bare.letter}{bare.raw}"
    return (
        f"{said} has no decimal point and counts least increments here: write {said}., or say"
        " --integers units"
    )
