"""G74 and G75 of Fanuc and Haas lathes (C: G76 G77): in by pecks, out, over by a step, and again.

    X ^   end              start       G75; in G74 X and Z change places
      |    +<. . . +<. . . +           over in rapid, by Q, the last step to the end
      |    |       |       |
      |    |       |       | P         in at F by P, back by the retract behind each peck
      |    |       |       |
      +----v-------v-------v----> Z    out in rapid to where the tool stood

Fanuc B-64304EN-1, "End face peck drilling cycle (G74)", "Outer diameter / internal diameter
drilling cycle (G75)": two blocks, the first with R, the second with P along X and Q along Z, which
count least increments; and "Series 10/11 program format": one block, I along X and K along Z. Haas
lathe operator's manual 96-8900, G74, G75: one block, I and K likewise, back by setting 22 behind
each peck, and two cycles at least where the other axis is named. P and I are radii.

R of the second block, and D of one alone, draw the tool aside at the bottom, against the step
(Fanuc: "relief amount of the tool at the cutting bottom"). Fanuc does not say whether at the first
cut too; controls of its kind do not (ADTECH CNC4620, programming manual 3.6.6), and there the tool
may stand in the material on both sides: the first cut is drawn out straight, which a notice says.
Without steps the sign of R says which way, so it is refused there, as Haas' D is everywhere.

Assumed: RETRACT in place of parameter 5139, or of setting 22.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

RETRACT = {False: 0.5, True: 0.02}  # mm, inch, radius
MOST_STEPS = 10_000
KIND = "a grooving cycle"
PLACES = {"X": "end", "Z": "end", "U": "end, from the start", "W": "end, from the start"}
AXES = "XZUW"
ASIDE = "it draws the tool aside at the bottom"
ASIDE_LATER = (
    "{} draws the tool aside at the bottom of the second cut and those behind it; the first one is"
    " drawn out straight (controls differ there)"
)


@dataclass
class Grooving(Cycle):
    """One of the two: it pecks along `deep`, and steps along the other axis. `escape`: back
    behind a peck, a radius, as the first of two blocks said it."""

    codes: Iterable[int]
    deep: str
    haas: bool = False
    escape: float | None = None

    @property
    def over(self) -> str:
        """The axis along which the cuts stand beside each other."""
        return "X" if self.deep == "Z" else "Z"

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of the first of two blocks, and of the second one or of one alone."""
        meaning = {x: "depth of a peck" if x == self.deep else "step" for x in "XZ"}
        alone = {"I": meaning["X"], "K": meaning["Z"]}
        if self.haas:
            return (Form(KIND, PLACES | alone, refused={"D": ASIDE}, zero="D", increments=True),)
        counted = {"P": meaning["X"], "Q": meaning["Z"]}
        return (
            Form(KIND, {"R": "back behind a peck"}, name="first of two blocks", unless=AXES),
            Form(
                KIND,
                PLACES | counted | alone | dict.fromkeys("RD", "how far aside at the bottom"),
                increments=True,
                name="second block, or one alone",
            ),
        )

    # Whole: the cuts in the order in which the tool makes them.
    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        refuse_nose(scene, code)
        m = Moves(scene, own_words(block, AXES + "PQRIKD", {code}))
        if not any(block.word(x) for x in AXES):
            self._hold(scene, block, code)
            return Outcome(m.finish())
        half = {"X": scene.double("X"), "Z": 1.0}
        start = {x: scene.at(x) for x in "XZ"}
        # All lengths as X's words have them, diameters on most lathes; P, Q and R are radii, hence
        # `half`.
        to = start | named_end(scene, block, start)
        by = {x: self._step(scene, block, x) * half[x] for x in "XZ"}
        # What the first of two blocks said holds on, as the parameter would that it sets.
        escape = (RETRACT[scene.inch] if self.escape is None else self.escape) * half[self.deep]
        deep, over = self.deep, self.over
        places = steps(scene, start[over], to[over], by[over])
        depths = steps(scene, start[deep], to[deep], by[deep])[1:] or [to[deep]]
        if len(places) * len(depths) > 10 * MOST_STEPS:
            raise scene.fault(
                f"{len(places):,} cuts of {len(depths):,} pecks each", "check the step and the peck"
            )
        back = escape if to[deep] < start[deep] else -escape
        aside = self._aside(scene, block, code, places if to[deep] != start[deep] else [])
        for k, place in enumerate(places):
            if k:
                m.move("G0", {over: place})
            for depth in depths:
                m.move("G1", {deep: depth})
                # From the bottom the tool goes out all the way, so no chip needs breaking there.
                if depth != depths[-1]:
                    m.move("G0", {deep: depth + back})
            if k and aside:
                m.move("G0", {over: place + aside * half[over]})
            m.move("G0", {deep: start[deep]})
        m.move("G0", {over: start[over]})
        return Outcome(m.finish())

    def _aside(self, scene: Scene, block: Block, code: int, places: list[float]) -> float:
        """How far the tool goes over at the bottom, against the step; X a radius."""
        word = block.word("R") or block.word("D")
        size = abs(scene.length(word, self.over)) if word else 0.0
        if not word or not size:
            return 0.0
        name = f"{word.letter}{word.raw}"
        if len(places) < 2 or (word.value or 0) < 0:
            raise scene.fault(
                f"{name} in {KIND} (G{code / 10:g}): {ASIDE}, and without steps, or with a sign,"
                " which way is not certain",
                f"write the cycle without {word.letter}, or with steps and {word.letter} above 0",
                word,
            )
        scene.tell("aside", ASIDE_LATER.format(name))
        # Back towards the cut before, where the material is gone.
        return size if places[0] > places[1] else -size

    def _hold(self, scene: Scene, block: Block, code: int) -> None:
        """The first of two blocks."""
        word = block.word("R")
        if word is None:
            raise scene.fault(f"G{code / 10:g} without X and Z", "name where it ends")
        self.escape = scene.length(word, self.deep)

    @staticmethod
    def _step(scene: Scene, block: Block, axis: str) -> float:
        """A peck or step along an axis; 0: in one go."""
        counted, word = (block.word(x) for x in ("PI" if axis == "X" else "QK"))
        if counted and word:
            raise scene.fault(
                f"{counted.letter} and {word.letter} both say a step along {axis}",
                "write one of them",
                word,
            )
        # I and K are lengths; P and Q count least increments where they have no point.
        if word:
            return abs(scene.length(word, axis))
        return abs(scene.counted(counted, axis)) if counted else 0.0


def refuse_nose(scene: Scene, code: int) -> None:
    """Raises ProgramError for a cycle of a lathe within G41 or G42."""
    if scene.code("cutter") in (410, 420):
        raise scene.fault(f"G{code / 10:g} with nose radius compensation on", "write G40 before it")


def named_end(scene: Scene, block: Block, start: dict[str, float]) -> dict[str, float]:
    """Where X U and Z W of a block lead from a place, as far as they are named; X as its words
    are."""
    to = {}
    for axis, letter in (("X", "U"), ("Z", "W")):
        absolute, increment = block.word(axis), block.word(letter)
        if increment:
            to[axis] = start[axis] + scene.length(increment, axis)
        elif absolute:
            value = scene.length(absolute, axis)
            to[axis] = start[axis] + value if scene.incremental else value
    return to


def steps(scene: Scene, start: float, end: float, by: float) -> list[float]:
    """Places from `start` to `end`, `by` apart but for the last, which is `end`. Raises
    ProgramError where they are too many."""
    if by <= 0 or start == end:
        return [start, end] if start != end else [start]
    count = int(abs(end - start) / by + 1e-9)
    if count > MOST_STEPS:
        raise scene.fault(
            f"{count:,} steps of {by:g} (limit {MOST_STEPS:,})",
            "check them: a number without a decimal point may count least increments",
        )
    sense = 1 if end > start else -1
    places = [start + sense * by * k for k in range(count + 1)]
    # Else a rounding would make one more cut, where the last one was.
    return [*places, end] if abs(places[-1] - end) > 1e-9 else places
