"""LinuxCNC's drilling cycles, as measured on its interpreter 2.9
(tests/expand/test_holes_linuxcnc.py).

R and the depth hold as the *numbers* they were written as, and in G91 count from the initial level:
that is where the axis stood when the first cycle behind any other motion began. An R above that is
gone to at the old place; from R level or below, the place is gone to in one rapid with the axis of
the hole. Before G98 or G99 is named, G99 holds. R and Q are radii where X is a diameter.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.drilling import (
    INITIAL_LEVEL,
    KIND,
    WORDS,
    Action,
    Drilling,
    Hole,
    Job,
    bore,
    bore_far,
    bore_standing,
    chips,
    drill,
    pecks,
)
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form, named

ACTIONS: dict[int, Action] = {
    730: chips, 740: bore_far, 810: drill, 820: drill, 830: pecks, 840: bore_far, 850: bore,
    860: bore_standing, 890: bore_far,
}  # fmt: skip
TAPPING = (740, 840)
UNDEFINED = "LinuxCNC's manual calls it unimplemented, and what it does undefined"
REFUSED = {870: UNDEFINED, 880: UNDEFINED}
# where the cycle begins; later ones hold
NEEDS = {730: "Q", 820: "P", 830: "Q", 860: "P", 890: "P"}
STOPS = (860,)
PECKS = (730, 830)
DWELLS = (740, 820, 840, 860, 890)
# mm, inch: how far G73 and G83 stay off the bottom of the last peck
RETRACT = {False: 0.254, True: 0.010}


class LinuxcncDrilling(Drilling):
    """As rs274ngc does it: `held` has R and the bottom as radii; in G91 R counts from the initial
    level, the bottom from R."""

    actions, tapping, refused = ACTIONS, TAPPING, REFUSED
    words = "RPQL"

    def hole_form(self, code: int) -> Form:
        """P and Q only where 2.9 takes them (check_other_codes of its interpreter)."""
        own = "P" * (code in DWELLS) + "Q" * (code in PECKS)
        return Form(KIND, named(WORDS, "XYZRL" + own))

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        """The hole by the words that hold; first to R level where the tool stands below it. Raises
        ProgramError."""
        axis = scene.plane[2]
        self._check(scene, block, code, axis)
        half = scene.double(axis)  # all that holds is a radius
        for word in block.words:
            self._hold(scene, word, axis, half)
        if self.initial is None:
            self.initial = scene.at(axis) / half
        r, bottom = self.held["R"], self.held["depth"]
        if scene.incremental:
            r += self.initial
            bottom += r
        if r < bottom:
            raise scene.fault(
                f"R is at {r * half:g}, below the bottom of the hole at {bottom * half:g}",
                "R must lie above it",
                block.word("R"),
            )
        up = scene.code("return") == INITIAL_LEVEL
        here = scene.at(axis) / half
        if not scene.differs(axis, r * half):
            here = r  # not by a rounding above or below it
        top = max(r, self.initial) if up else r
        #  initial above R:  o. . .+    across where it stands, then down to R
        #                          |
        #  R level           - - - +
        #  at R or below:    o.' ' '    one rapid, across and to the level of the way back
        #  initial below R:  up to R first, then across
        first, level = ((r * half,), r) if self.initial < r else ((), here if here > r else top)
        hole = Hole(
            axis, r * half, bottom * half, back=top * half,
            p=self.p if code in DWELLS else "", first=self.held.get("Q", 0.0) * half,
            retract=RETRACT[scene.inch] * half,
        )  # fmt: skip
        if code in PECKS and hole.first <= 0:
            raise scene.fault(
                f"Q is {hole.first:g}, and no peck can be that deep",
                "write Q above 0",
                block.word("Q"),
            )
        place = [w for w in block.words if w.letter in "XYZ" and w.letter != axis]
        return Job(code, hole, self.times(scene, block, "L", 1), place, first, level * half)

    def _check(self, scene: Scene, block: Block, code: int, axis: str) -> None:
        """Raises ProgramError where LinuxCNC makes no hole, or not without more words."""
        if code in STOPS and scene.spindle not in (3, 4):
            raise scene.fault(
                "G86 starts the spindle as it turned before, and it does not turn",
                "start it before: S, M3",
            )
        if not self.wants(scene, block):
            raise scene.fault(
                "a drilling cycle without X, Y or Z",
                "LinuxCNC wants one of them in every such block",
            )
        needed = "R" + axis + NEEDS.get(code, "") if code != self.code else ""
        if missing := [x for x in needed if block.get(x) is None]:
            raise scene.fault(
                f"G{code / 10:g} begins without {' and '.join(missing)}",
                "LinuxCNC keeps these words only within one cycle: write them where it begins",
            )

    def _hold(self, scene: Scene, word: Word, axis: str, half: float) -> None:
        """Remember a word for the holes to come."""
        if word.letter == "P":
            if word.value is not None and word.value < 0:
                raise scene.fault(f"a dwell of {word.raw} s", "write P from 0 on", word)
            self.p = word.raw
        elif word.letter in ("R", "Q", axis) and word.value is not None:
            if word.letter == axis:
                self.held["depth"] = word.value / half
            else:
                self.held[word.letter] = word.value

    def passed_on(self, scene: Scene, block: Block, job: Job) -> list[bytes]:
        """The control itself counts from where the axis stands when its own first cycle begins.
        Raises ProgramError where that lies above the initial level."""
        axis = job.hole.axis
        initial = (self.initial or 0.0) * scene.double(axis)
        counts = scene.incremental or scene.code("return") == INITIAL_LEVEL
        if self.stays or not counts or not scene.differs(axis, initial):
            return [block.text]
        if scene.at(axis) > initial:
            raise scene.fault(
                f"tapping begins at {axis}{scene.at(axis):g}, above the initial level {initial:g}"
                " of the holes before",
                f"end them first: G80 and G0 {axis}{initial:g}",
            )
        word = scene.text(axis, initial - scene.at(axis) if scene.incremental else initial)
        return [(b"/" if block.skip else b"") + b"G0 " + word, block.text]
