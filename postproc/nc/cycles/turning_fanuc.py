"""Turning cycles of Fanuc lathes: G90 G94 (G77 G79), and G70 to G75 over a shape that stands in the program.

Fanuc B-64304EN-1, "Canned cycle" and "Multiple repetitive cycle"; the order of motions and which of them are rapids
also in the lathe maker Robur's concise guide to Fanuc, pages 48 and 57. Threads (G76, G92) have a run-out that
parameters shape (5130, 5131), and stay.

Assumed: the depths of G71 and G72 count from the start point moved by the finishing allowances; the cut that would
reach the depth of the shape's first point, or go beyond it, is left to the last one along the shape; the tool escapes
at 45 degrees in rapid, and returns to the start point in one rapid. RETRACT stands for parameters 5133 (G71 G72) and
5139 (G74 G75) where R does not say it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.drilling import UNDEFINED, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.profile import Element, Profile, find, shape
from postproc.nc.cycles.scene import CLOCKWISE, Scene

RETRACT = {False: 0.5, True: 0.02}  # mm, inch, radius
MOST_PASSES = 10_000
OWN = "XZUWPQRDIK"


class Turn:
    """G90 (G77), straight or tapered along Z, and G94 (G79) along X: in, cut, out, back. Its words hold."""

    modal = True

    def __init__(self, facing: bool):
        self.facing = facing
        self.end()

    def end(self) -> None:
        self.to: dict[str, float] = {}
        self.taper = 0.0

    def wants(self, scene: Scene, block: Block) -> bool:
        return any(block.get(x) is not None for x in "XZUWR")

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        m = Moves(scene, own_words(block, "XZUWR", {code}))
        if not self.wants(scene, block):
            return Outcome(m.finish())
        start = {x: scene.at(x) for x in "XZ"}
        for axis in "XZ":
            absolute, increment = block.word(axis), block.word("U" if axis == "X" else "W")
            if increment:
                self.to[axis] = start[axis] + scene.length(increment, axis)
            elif absolute:
                value = scene.length(absolute, axis)
                self.to[axis] = start[axis] + value if scene.incremental else value
        missing = [x for x in "XZ" if x not in self.to]
        if missing:
            raise scene.fault(f"G{code / 10:g} without {missing[0]}", "name X and Z in the first block of the cycle")
        taper = block.word("R")
        if taper:
            self.taper = scene.length(taper, "X")
        x, z = self.to["X"], self.to["Z"]
        if self.facing:
            m.move("G0", {"Z": z + self.taper})
            m.move("G1", {"X": x, "Z": z})
            m.move("G1", {"Z": start["Z"]})
            m.move("G0", {"X": start["X"]})
        else:
            m.move("G0", {"X": x + self.taper * _half(scene)})
            m.move("G1", {"X": x, "Z": z})
            m.move("G1", {"X": start["X"]})
            m.move("G0", {"Z": start["Z"]})
        return Outcome(m.finish())


class Stays:
    """A thread: it begins and ends in its start point, and stays as it is written."""

    def __init__(self, modal: bool):
        self.modal = modal

    def end(self) -> None:
        return

    def wants(self, scene: Scene, block: Block) -> bool:
        return any(block.get(x) is not None for x in "XZUWR")

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        told = Moves(scene, own_words(block, OWN, {code})).finish()
        return Outcome([block.text], told)


@dataclass
class Repetitive:
    """G70 to G75 of one lathe. `roles`: ten times the G number to what it is: finish, rough, face, repeat, peck,
    groove."""

    roles: dict[int, str]
    held: dict[str, dict[str, float]] = field(default_factory=dict)
    modal = False

    def end(self) -> None:
        return

    def wants(self, scene: Scene, block: Block) -> bool:
        return False

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        role = self.roles[code]
        if scene.code("cutter") in (410, 420):
            raise scene.fault(f"G{code / 10:g} with nose radius compensation on", "write G40 before it")
        own = own_words(block, OWN, {code})
        if role in ("peck", "groove"):
            return self._pecks(scene, block, role, Moves(scene, own))
        if block.get("P") is None or block.get("Q") is None:
            self._hold(scene, block, role)
            return Outcome(Moves(scene, own).finish())
        begin, end = (int(block.get(x) or 0) for x in "PQ")
        after = 0 if role == "finish" else scene.source
        profile = find(scene, scene.lines(), begin, end, after)
        m = Moves(scene, own)
        if role == "finish":
            return self._finish(scene, block, profile, m)
        start = (scene.at("Z"), scene.at("X") / _half(scene))
        elements = shape(scene, profile, start, scene.code("motion"))
        allowance = (_word(scene, block, "W", "Z"), _word(scene, block, "U", "X") / _half(scene))
        if role == "repeat":
            self._repeat(scene, block, elements, allowance, start, m)
        else:
            self._rough(scene, block, role, elements, allowance, start, m)
        return Outcome(m.finish(), skip=(profile.first, profile.last), then=UNDEFINED)

    def _hold(self, scene: Scene, block: Block, role: str) -> None:
        """The first of two blocks: depth of cut, escape, divisions."""
        kept = self.held.setdefault(role, {})
        for word in block.words:
            if word.letter in "UWR" and word.value is not None:
                kept[word.letter] = word.value if role == "repeat" and word.letter == "R" else scene.length(word, "X")

    # -- G71 G72 -------------------------------------------------------------------------------------------------------

    def _rough(
        self, scene: Scene, block: Block, role: str, elements: list[Element], allowance: tuple[float, float],
        start: tuple[float, float], m: Moves,
    ) -> None:  # fmt: skip
        """Cuts parallel to Z (G71) or X (G72), then one along the shape."""
        deep, along = (1, 0) if role == "rough" else (0, 1)  # which of (z, x) is gone down in, and which is cut along
        word = block.word("D")
        letter = "U" if role == "rough" else "W"
        depth = scene.counted(word, "X") if word else self.held.get(role, {}).get(letter, 0.0)
        escape = self.held.get(role, {}).get("R", RETRACT[scene.inch])
        if depth <= 0:
            raise scene.fault(
                f"the depth of cut is not in the program ({letter} in a block before)",
                f"the control takes it from a parameter: write {letter} above 0",
            )
        first, rest = elements[0], [e.moved(allowance) for e in elements[1:]]
        name = "ZX"[along]
        if first.is_arc or first.start[along] != first.end[along]:
            raise scene.fault(
                f"the first block of the shape moves {name}",
                f"that is type II, with pockets, which is not written out: let it move {'ZX'[deep]} alone",
            )
        if not rest:
            raise scene.fault("the shape has one block", "it needs one to its first point, and the shape")
        self._monotonic(scene, rest)
        c = [start[0] + allowance[0], start[1] + allowance[1]]
        target = rest[0].start[deep]
        sense = 1 if target > c[deep] else -1
        side = 1 if rest[-1].end[along] > c[along] else -1
        infeed = "G0" if first.code == 0 else "G1"
        self._to(scene, m, "G0", c[0], c[1])
        level = c[deep]
        passes = int(abs(target - c[deep]) / depth) + 1
        if passes > MOST_PASSES:
            raise scene.fault(f"{passes:,} cuts of {depth:g} (limit {MOST_PASSES:,})", "check the depth of cut")
        for k in range(1, passes + 1):
            level = c[deep] + sense * k * depth
            if (target - level) * sense <= 1e-9:
                break
            stop = next((v for e in rest if (v := e.crossing(deep, level)) is not None), rest[-1].end[along])
            self._axis(scene, m, infeed, deep, level)
            self._axis(scene, m, "G1", along, stop)
            out = [0.0, 0.0]
            out[deep], out[along] = level - sense * escape, stop - side * escape
            self._to(scene, m, "G0", *out)
            self._axis(scene, m, "G0", along, c[along])
        self._axis(scene, m, infeed, deep, target)
        for e in rest:
            self._element(scene, m, e)
        self._to(scene, m, "G0", *start)

    def _monotonic(self, scene: Scene, elements: list[Element]) -> None:
        """Type I: neither Z nor X turns back."""
        for axis, name in ((0, "Z"), (1, "X")):
            ways = [e.end[axis] - e.start[axis] for e in elements]
            if min(ways) < -1e-9 and max(ways) > 1e-9:
                raise scene.fault(
                    f"{name} turns back within the shape", "such a shape (type II, pockets) is not written out"
                )
        if not all(e.monotonic for e in elements):
            raise scene.fault("an arc of the shape goes beyond a quadrant", "such a shape (type II) is not written out")

    # -- G73 G70 -------------------------------------------------------------------------------------------------------

    def _repeat(
        self, scene: Scene, block: Block, elements: list[Element], allowance: tuple[float, float],
        start: tuple[float, float], m: Moves,
    ) -> None:  # fmt: skip
        """The whole shape, nearer each time."""
        kept = self.held.get("repeat", {})
        words = [block.get(x) for x in "IKD"]
        x, z, times = (w if w is not None else kept.get(c) for w, c in zip(words, "UWR", strict=True))
        if times is None or times != int(times) or not 1 <= times <= MOST_PASSES:
            raise scene.fault(
                "how often the shape is cut is not in the program", "write R in the block before: a whole number"
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
            raise scene.fault("G70 in G91", "write the shape in absolute words: the way back is not known here")
        named = [c for b in profile.texts for c in b.codes if scene.group_of(c) == "motion"]
        return Outcome([*texts, b" ".join(back)], then=named[-1] if named else None)

    # -- G74 G75 -------------------------------------------------------------------------------------------------------

    def _pecks(self, scene: Scene, block: Block, role: str, m: Moves) -> Outcome:
        """In by pecks, out, over by a step, and again."""
        moves = any(block.get(x) is not None for x in "XZUW")
        if not moves:
            self._hold(scene, block, role)
            return Outcome(m.finish())
        shift = block.word("R")
        if shift and shift.value:
            raise scene.fault(
                f"R{shift.raw} draws the tool aside at the bottom",
                "whether at the first cut too differs: take it out",
                shift,
            )
        deep, over = ("Z", "X") if role == "peck" else ("X", "Z")
        start = {x: scene.at(x) for x in "XZ"}
        to = dict(start)
        for axis in "XZ":
            absolute, increment = block.word(axis), block.word("U" if axis == "X" else "W")
            if increment:
                to[axis] = start[axis] + scene.length(increment, axis)
            elif absolute:
                to[axis] = scene.length(absolute, axis) + (start[axis] if scene.incremental else 0.0)
        step = {"X": block.word("P"), "Z": block.word("Q")}
        by = {x: scene.counted(w, x) * (_half(scene) if x == "X" else 1.0) if w else 0.0 for x, w in step.items()}
        escape = self.held.get(role, {}).get("R", RETRACT[scene.inch]) * (_half(scene) if deep == "X" else 1.0)
        places = _steps(scene, start[over], to[over], by[over])
        depths = _steps(scene, start[deep], to[deep], by[deep])[1:] or [to[deep]]
        if len(places) * len(depths) > 10 * MOST_PASSES:
            raise scene.fault(f"{len(places):,} cuts of {len(depths):,} pecks each", "check P and Q")
        back = escape if to[deep] < start[deep] else -escape
        for k, place in enumerate(places):
            if k:
                m.move("G0", {over: place})
            for depth in depths:
                m.move("G1", {deep: depth})
                if depth != depths[-1]:
                    m.move("G0", {deep: depth + back})
            m.move("G0", {deep: start[deep]})
        m.move("G0", {over: start[over]})
        return Outcome(m.finish())

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


def _steps(scene: Scene, start: float, end: float, by: float) -> list[float]:
    """Places from `start` to `end`, `by` apart but for the last."""
    if by <= 0 or start == end:
        return [start, end] if start != end else [start]
    count = int(abs(end - start) / by + 1e-9)
    if count > MOST_PASSES:
        raise scene.fault(
            f"{count:,} steps of {by:g} (limit {MOST_PASSES:,})", "check P and Q: they count least increments"
        )
    sense = 1 if end > start else -1
    places = [start + sense * by * k for k in range(count + 1)]
    return [*places, end] if abs(places[-1] - end) > 1e-9 else places
