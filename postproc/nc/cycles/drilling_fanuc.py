"""Drilling cycles of Fanuc mills and lathes, and of Haas mills.

Fanuc B-64304EN-2, "Canned cycle for drilling" (mill), B-64304EN-1 the same for lathes; Haas mill
operator's manual. Data hold until G80, also from one cycle to the next. The place is gone to on the
level where the axis stands, then R level; in G98 the way back ends where the axis stood when the
first cycle began. A mill drills without R from there.

Assumed: the hole lies across the plane (parameter 5101 bit 0); what G73 and G83 back off a chip is
RETRACT in place of parameters 5114 and 5115 - on the axis of the hole, so the hole is the same; a
lathe's G83 and G87 with Q go out to R level (5101 bit 2), and its G85 and G89 come out at the feed
they went in with (5149).
"""

from __future__ import annotations

from dataclasses import replace

from postproc.nc.cycles.block import Block, Word, without
from postproc.nc.cycles.drilling import (
    KIND,
    R_LEVEL,
    WORDS,
    Action,
    Drilling,
    Hole,
    Job,
    bore,
    bore_standing,
    chips,
    drill,
    pecks,
)
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form, named
from postproc.nc.holes import SUNK, SUNK_ADVICE, WITHOUT_R

MILL: dict[int, Action] = {
    730: chips, 740: bore, 810: drill, 820: drill, 830: pecks, 840: bore, 842: bore, 843: bore,
    850: bore, 860: bore_standing, 890: bore,
}  # fmt: skip
MILL_TAPPING: tuple[int, ...] = (740, 840, 842, 843)
SHIFT = "it leaves the wall in a direction that a parameter holds"
MILL_REFUSED = {760: SHIFT, 870: SHIFT, 880: "the operator draws the tool out by hand"}
MILL_WHOLE: tuple[int, ...] = (760, 880)
DWELLS = (820, 880, 890, 740, 840)
LATHE: dict[int, Action] = {830: pecks, 840: bore, 850: bore, 870: pecks, 880: bore, 890: bore}
LATHE_TAPPING = (840, 880)
ALONG_X = (870, 880, 890)
HAAS_PECKS = {"I": "first peck", "J": "how much less each one is", "K": "least peck"}
RETRACT = {False: 0.5, True: 0.02}  # mm, inch
# M5 and M9 in the block of a hole act behind it, M3 and M8 before.
AFTER_MOTION = (5, 9)
# M codes that every lathe has for something else: any other one beside a hole clamps C.
NO_CLAMPS = (0, 1, 2, 3, 4, 5, 7, 8, 9, 30)


class FanucDrilling(Drilling):
    """`held`: "R" and "depth" as programmed coordinates, "Q" I J K as written."""

    actions, tapping, refused = MILL, MILL_TAPPING, MILL_REFUSED
    whole, after_motion = MILL_WHOLE, AFTER_MOTION
    words, repeats = "RPQKL", "KL"
    dwells: tuple[int, ...] = DWELLS
    pecking: tuple[int, ...] = (730, 830)

    def wants(self, scene: Scene, block: Block) -> bool:
        axes = [*scene.tracker.setup.axes, *scene.dialect.increments, "R"]
        return 40 not in block.codes and any(block.get(x) is not None for x in axes)

    def hole_form(self, code: int) -> Form:
        """P and Q that a cycle itself has no use for hold for those behind it."""
        used = {"P": code in self.dwells, "Q": code in self.pecking}
        takes = named(WORDS, "XYZR" + self.repeats) | named(
            WORDS, "".join(x for x in used if used[x])
        )
        return Form(KIND, takes, named(WORDS, "".join(x for x in used if not used[x])), axes=True)

    def axis_of(self, scene: Scene, code: int) -> str:
        """The axis of the hole."""
        return scene.plane[2]

    def r_level(self, scene: Scene, word: Word, axis: str) -> float:
        """R in G90 is a place, in G91 a distance from the initial level."""
        value = scene.length(word, axis)
        return self.start(scene, axis) + value if scene.incremental else value

    def start(self, scene: Scene, axis: str) -> float:
        """The initial level. Raises ProgramError where it is unknown."""
        if self.initial is None and self.code:
            raise scene.fault(
                f"the initial level is where {axis} stood when the cycles began, and that is not"
                " known",
                f"move {axis} to an absolute position before the cycles, or say where it stands:"
                f" --start {axis}0",
            )
        if self.initial is None:
            self.initial = scene.at(axis)
        return self.initial

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        axis = self.axis_of(scene, code)
        if not self.code:
            self.initial = scene.known(axis)
        if not self.wants(scene, block):
            idle = next((w for w in block.words if w.letter in self.words), None)
            if idle:
                raise scene.fault(
                    f"{idle.letter} in a block that makes no hole",
                    "controls differ on whether it holds: name a place beside it",
                    idle,
                )
            return Job(code, Hole(axis, 0.0, 0.0, 0.0), 0, [])
        self._hold(scene, block, axis)
        place = [w for w in block.words if self.is_place(scene, w, axis)]
        # G0 to G3 before the cycle's own code in one block: the cycle holds, as the last code.
        gone = tuple(n for n in block.codes if n in (0, 10, 20, 30))
        return Job(
            code,
            self._hole(scene, block, code, axis),
            self.times(scene, block, self.repeats, 0),
            place,
            codes=gone,
            drops=self.drops(scene, axis),
        )

    def _hole(self, scene: Scene, block: Block, code: int, axis: str) -> Hole:
        """By the words that hold. Raises ProgramError where one is missing."""
        #   initial level   o- - ->o       o- - -   G98: back to where the axis stood when the first
        #                          :       ^        cycle began, which the next one keeps
        #   R level                +    +- -        G99: back to R
        #                          |    ^
        #   bottom                 v- - +
        for letter, name in (("R", "R level"), ("depth", "bottom")):
            if letter not in self.held:
                word = self.letter_of(letter, axis, code)
                raise scene.fault(
                    f"G{code / 10:g} without its {name} ({word})",
                    "write it in the first block of the cycle",
                )
        r, bottom = self.held["R"], self.held["depth"]
        back = r if scene.code("return") == R_LEVEL else self.start(scene, axis)
        # R above the level where the tool stands, in G98: controls differ on where the way back
        # ends.
        below = scene.rounded(axis, bottom) < scene.rounded(axis, back) < scene.rounded(axis, r)
        if below and not scene.dialect.level_from_start:
            raise scene.fault(SUNK, SUNK_ADVICE)
        half = scene.double(axis)
        q = self.held.get("Q", 0.0) * half
        if code in self.pecking and q <= 0 and "I" not in self.held:
            letter = self.letter_of("Q", axis, code)
            raise scene.fault(
                f"G{code / 10:g} without {letter}",
                "write the depth of a peck, above 0",
                block.word(letter),
            )
        return Hole(
            axis,
            r,
            bottom,
            back,
            p=self.p if self.p and code in self.dwells else "",
            first=self.held.get("I", q),
            less=self.held.get("J", 0.0),
            least=self.held.get("K", 0.0),
            # Not more than a peck, or behind the first one the next rapid would end above R level.
            retract=min(RETRACT[scene.inch] * half, q or self.held.get("I", 0.0)),
        )

    def letter_of(self, held: str, axis: str, code: int) -> str:
        """The word that says what is held: "R", "depth" or "Q"."""
        return axis if held == "depth" else held

    def drops(self, scene: Scene, axis: str) -> str:
        """Further letters that a block of a hole loses: increments along its axis."""
        return ""

    def is_place(self, scene: Scene, word: Word, axis: str) -> bool:
        """Whether a word says where the hole is."""
        meant = scene.dialect.increments.get(word.letter, word.letter)
        return meant in scene.tracker.setup.axes and meant != axis

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        """Remember the words for the holes to come."""
        r, depth = block.word("R"), block.word(axis)
        if r:
            # In G91 the bottom lies below R: with a new R alone it would move along on one control
            # and stay on another.
            if depth is None and "relative" in self.held:
                raise scene.fault(
                    f"a new R behind a {axis} that counts from R (G91)",
                    f"controls differ on the bottom: write {axis} too",
                    r,
                )
            self.held["R"] = self.r_level(scene, r, axis)
        elif scene.dialect.hole_from_start and "R" not in self.held:
            self.r_from_start(scene, axis)
            scene.tell("without R", WITHOUT_R)
        if depth:
            value = scene.length(depth, axis)
            self.held.pop("relative", None)
            if scene.incremental:
                self.held["relative"] = value
                if "R" not in self.held:
                    raise scene.fault(
                        f"{axis} counts from R level here (G91), and there is no R",
                        "write R",
                        depth,
                    )
                value += self.held["R"]
            self.held["depth"] = value
        for word in block.words:
            if word.letter == "P":
                self.p = word.raw
            elif word.letter == "Q" and word.value is not None:
                self.held["Q"] = self.peck(scene, word, axis)

    def r_from_start(self, scene: Scene, axis: str) -> None:
        """Without R the hole begins where the axis stands."""
        if "R" not in self.held:
            self.held["R"] = self.start(scene, axis)

    def peck(self, scene: Scene, word: Word, axis: str) -> float:
        """Q as a length without a sign."""
        return abs(scene.length(word, axis))

    def passed_on(self, scene: Scene, block: Block, job: Job) -> list[bytes]:
        """With the words that the control would still hold, and from the initial level it would
        still know."""
        #   G81 X0 Z-9. R2. F100    written out: the control has never been in G81
        #   G84 X5.                 passed on as G84 X5. R2. Z-9., from the level where G81 began
        if self.stays or not self.code or "R" not in self.held or "depth" not in self.held:
            return [block.text]
        axis, add = job.hole.axis, []
        lines = self.from_initial(scene, block, axis)
        if block.get("R") is None and (level := self.as_written(scene, axis)) is not None:
            add.append(scene.text("R", level))
        if not any(block.get(x) is not None for x in axis + self.drops(scene, axis)):
            add.append(
                scene.text(
                    axis, self.held["depth"] - (self.held["R"] if scene.incremental else 0.0)
                )
            )
        if block.get("P") is None and self.p:
            add.append(b"P" + self.p.encode())
        sep = b" " if block.spaced else b""
        return [
            *lines,
            block.written(set(), sep.join(add), len(block.words)) if add else block.text,
        ]

    def from_initial(self, scene: Scene, block: Block, axis: str) -> list[bytes]:
        """The way to the initial level that the control would still know, where there is one."""
        level = self.initial
        if level is None or scene.code("return") == R_LEVEL or not scene.differs(axis, level):
            return []
        here = scene.at(axis) if scene.incremental else 0.0
        return [(b"/" if block.skip else b"") + b"G0 " + scene.text(axis, level - here)]

    def as_written(self, scene: Scene, axis: str) -> float | None:
        """R level as an R word has it, None: it needs none."""
        return self.held["R"] - (self.start(scene, axis) if scene.incremental else 0.0)


class HaasDrilling(FanucDrilling):
    """Haas: L repeats; I J K of G73 and G83 are a first peck, what each one is less, and the least
    one, and their P is a dwell behind the last one (Haas mill operator's manual, G73, G83). K
    beside Q is another way to peck: refused."""

    words, repeats = "RPQLIJK", "L"
    dwells: tuple[int, ...] = (730, 820, 830, 840, 890)

    def hole_form(self, code: int) -> Form:
        own = "P" * (code in self.dwells)
        pecks = HAAS_PECKS | named(WORDS, "Q") if code in self.pecking else {}
        return Form(KIND, named(WORDS, "XYZRL" + own) | pecks, axes=True)

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        job = super().job(scene, block, code)
        given = [x for x in "QIJK" if x in self.held]
        if code in self.pecking and given not in ([], ["Q"], ["I"], ["I", "J", "K"], ["I", "K"]):
            raise scene.fault(
                f"{' and '.join(given)} of G{code / 10:g} together",
                "write Q alone, or I, or I, J and K: how other pecks go is not certain",
            )
        return job

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        super()._hold(scene, block, axis)
        for word in block.words:
            if word.letter in "IJK" and word.value is not None:
                self.held[word.letter] = abs(scene.length(word, axis))


class LatheDrilling(FanucDrilling):
    """A lathe: G83 G84 G85 along Z, G87 G88 G89 along X. R is a distance from the initial level, a
    radius; Q counts least increments where it has no point; U V W H are distances. M is the code
    that clamps the C axis at the place of a hole ("M code for C-axis clamp", cncprograming.blogspot
    "Drilling cycle G83 or G87"); that the control sends the next one, which frees it, behind the
    way back, was not seen in a manual."""

    actions, tapping, refused = LATHE, LATHE_TAPPING, {}
    dwells = tuple(LATHE)
    pecking = ()  # without Q they drill in one go

    def hole_form(self, code: int) -> Form:
        own, kept = (
            (named(WORDS, "Q"), {}) if self.actions[code] is pecks else ({}, named(WORDS, "Q"))
        )
        return Form(KIND, named(WORDS, "XZRPKL") | own, kept, axes=True, increments=True)

    def axis_of(self, scene: Scene, code: int) -> str:
        return "X" if code in ALONG_X else "Z"

    def r_level(self, scene: Scene, word: Word, axis: str) -> float:
        return self.start(scene, axis) + scene.length(word, axis) * scene.double(axis)

    def as_written(self, scene: Scene, axis: str) -> float | None:
        return (self.held["R"] - self.start(scene, axis)) / scene.double(axis) or None

    def peck(self, scene: Scene, word: Word, axis: str) -> float:
        return scene.counted(word, axis)

    def drops(self, scene: Scene, axis: str) -> str:
        return "".join(u for u, x in scene.dialect.increments.items() if x == axis)

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        job = super().job(scene, block, code)
        clamp = next((w for w in block.words if w.letter == "M" and w.value not in NO_CLAMPS), None)
        if clamp is None or not job.times:
            return job
        # Once for a program: a clamp at each of a hundred holes is one thing to know.
        if code not in self.tapping and all(n.code != "clamp" for n in scene.notices):
            said = (
                f"M{clamp.raw} in a lathe's drilling cycle clamps the C axis before a hole, and"
                f" M{int(clamp.value or 0) + 1} frees it behind: both are written out beside it"
            )
            scene.tell("clamp", said)
        return replace(job, clamp=clamp)

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        for u, x in scene.dialect.increments.items():
            word = block.word(u)
            if x == axis and word:
                super()._hold(scene, without(block, u), axis)
                self.r_from_start(scene, axis)
                self.held["depth"] = self.held["R"] + scene.length(word, axis)
                return
        super()._hold(scene, block, axis)
        self.r_from_start(scene, axis)
