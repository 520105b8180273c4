"""Holes, whatever the control: what each cycle does between R level and its return, and how a block
becomes lines.

NIST RS274/NGC 3.5.16. What a control makes of the words, and what it remembers from hole to hole,
is in drilling_linuxcnc.py and drilling_fanuc.py.

                G83, pecks                   G73, chips

    R level     |   +---+   +---+   +        |            +     | feed   : rapid
                |   :   :   :   :   :        |            :
                v   :   :   :   :   :        v            :
    peck 1      +---+   :*  :   :   :        +-+*         :     * `retract` above the last depth
                        v   :   :   :          v          :
    peck 2              +---+   :*  :          +-+*       :
                                v   :            v        :
    bottom                      +---+            +--------+     then G98: to the initial level
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from postproc.errors import ProgramError
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

MOST_PECKS, MOST_HOLES = 10_000, 10_000
INITIAL_LEVEL, R_LEVEL = 980, 990


@dataclass(frozen=True)
class Hole:
    """One hole along `axis`, programmed coordinates: the level `r`, the `bottom`, where to go
    `back` to; the dwell `p` as it is written, pecks of `first`, each `less` than the one before,
    none below `least`; `retract` of a chip."""

    axis: str
    r: float
    bottom: float
    back: float
    p: str = ""
    first: float = 0.0
    less: float = 0.0
    least: float = 0.0
    retract: float = 0.0

    @property
    def down(self) -> int:
        """The sign of the way in: -1 towards smaller coordinates."""
        return -1 if self.bottom <= self.r else 1

    def depths(self, scene: Scene) -> list[float]:
        """Where each peck ends, but for the last one. Raises ProgramError for too many."""
        depths: list[float] = []
        peck, depth = self.first, self.r
        while peck > 0:
            depth = depth + self.down * peck
            if (self.bottom - depth) * self.down <= 0:
                break
            depths.append(depth)
            # I J K of Haas: the first peck I, each one J less than that before, none below K.
            peck = max(peck - self.less, self.least) if self.less else peck
            if len(depths) > MOST_PECKS:
                raise scene.fault(
                    f"this hole would take more than {MOST_PECKS:,} pecks of {self.first:g}",
                    "check the depths of the pecks and of the hole",
                )
        return depths


@dataclass(frozen=True)
class Job:
    """What a block asks for: the cycle `code`, the `hole`, how many `times`, the words of its
    `place`; levels to go to `first`, and the `level` at which the place is gone to (None: where it
    stands). `drops`: other letters and `codes` that belong to the cycle; `clamp`: the M word that
    holds the place before a hole, the next M code frees it behind (its source was not seen)."""

    code: int
    hole: Hole
    times: int
    place: list[Word]
    first: tuple[float, ...] = ()
    level: float | None = None
    drops: str = ""
    codes: tuple[int, ...] = ()
    clamp: Word | None = None


# -- what each cycle does between R level and its return -------------------------------------------


def drill(m: Moves, hole: Hole, scene: Scene) -> None:
    """G81 G82: feed down, dwell where P says so, rapid back."""
    m.move("G1", {hole.axis: hole.bottom})
    _dwell(m, hole)
    m.move("G0", {hole.axis: hole.back})


def pecks(m: Moves, hole: Hole, scene: Scene) -> None:
    """G83: out to R level behind every peck, and back down to `retract` above it."""
    for depth in hole.depths(scene):
        m.move("G1", {hole.axis: depth})
        m.move("G0", {hole.axis: hole.r})
        m.move("G0", {hole.axis: depth - hole.down * hole.retract})
    drill(m, hole, scene)


def chips(m: Moves, hole: Hole, scene: Scene) -> None:
    """G73: back by `retract` behind every peck."""
    for depth in hole.depths(scene):
        m.move("G1", {hole.axis: depth})
        m.move("G0", {hole.axis: depth - hole.down * hole.retract})
    drill(m, hole, scene)


def bore(m: Moves, hole: Hole, scene: Scene) -> None:
    """G85 G89: feed down, dwell where P says so, feed back to R level."""
    m.move("G1", {hole.axis: hole.bottom})
    _dwell(m, hole)
    m.move("G1", {hole.axis: hole.r})
    m.move("G0", {hole.axis: hole.back})


def bore_far(m: Moves, hole: Hole, scene: Scene) -> None:
    """LinuxCNC's G89: as G85, but the feed goes all the way back."""
    m.move("G1", {hole.axis: hole.bottom})
    _dwell(m, hole)
    m.move("G1", {hole.axis: hole.back})


def bore_standing(m: Moves, hole: Hole, scene: Scene) -> None:
    """G86: feed down, dwell where P says so, stop the spindle, rapid back, start it again."""
    m.move("G1", {hole.axis: hole.bottom})
    _dwell(m, hole)
    m.line(b"M5")
    m.move("G0", {hole.axis: hole.back})
    m.line(b"M4" if scene.spindle == 4 else b"M3")


def _dwell(m: Moves, hole: Hole) -> None:
    if hole.p:
        m.line(b"G4", m.scene.dialect.dwell[0].encode() + hole.p.encode())


# -- the cycles of a control -----------------------------------------------------------------------

Action = Callable[[Moves, Hole, Scene], None]
WRITE_OUT = "let the CAM program write this hole out as G0 and G1"
KIND = "a drilling cycle"
TAPPING = Form("tapping", stays=True)
WORDS = {
    "X": "place, or bottom",
    "Y": "place, or bottom",
    "Z": "bottom, or place",
    "R": "R level",
    "P": "dwell at the bottom",
    "Q": "depth of a peck",
    "K": "how often",
    "L": "how often",
}


class Drilling(Cycle):
    """The drilling cycles of one control, and their data that hold from hole to hole.

    `actions`: ten times the G number to what is done; `tapping`: those that are followed and stay;
    `refused`: those that can not be written out, and why; `whole`:
    those of them that stay where their hole may. `words`: letters that belong to a cycle
    beside the axes; `after_motion`: M codes that the control executes behind the motion.
    `synchronised`: tapping is written out as feeds too, which no machine may be given (for
    tests)."""

    actions: dict[int, Action]
    tapping: tuple[int, ...] = ()
    refused: Mapping[int, str] = MappingProxyType({})
    whole: tuple[int, ...] = ()
    words: str
    after_motion: tuple[int, ...] = ()
    modal = True

    def __init__(self, synchronised: bool = False):
        self.synchronised = synchronised
        self.codes = (*self.actions, *self.refused)
        self.end()

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of a cycle."""
        if code in self.refused:
            return (Form(KIND, never=self.refused[code], whole=code in self.whole),)
        return (TAPPING,) if code in self.tapping else (self.hole_form(code),)

    def hole_form(self, code: int) -> Form:
        """The words of a hole that is written out."""
        raise NotImplementedError

    def wants(self, scene: Scene, block: Block) -> bool:
        """Whether a block without a motion code is another hole."""
        return any(block.get(x) is not None for x in "XYZ")

    def end(self) -> None:
        """G80 or another motion: nothing is remembered."""
        self.p = ""  # the dwell as it is written
        self.code = 0  # the cycle in force, 0: none
        # where the hole's axis stood when the cycles began
        self.initial: float | None = None
        self.held: dict[str, float] = {}
        self.stays = False  # the last block was passed on, so the control itself is in the cycle
        self.kept = True  # every block of the cycles was, so the tracker is in them too

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a block. Raises ProgramError."""
        if code in self.refused and code not in self.whole:
            raise self._refusal(scene, code)
        if scene.compensated:
            raise scene.fault(
                "a drilling cycle with cutter radius compensation on", "end it before: G40"
            )
        if scene.code("feed mode") == 930:
            raise scene.fault("a drilling cycle with inverse time feed (G93)", "write G94 before")
        if 40 in block.codes:
            raise scene.fault("a dwell and a hole in one block", "write G4 in a block of its own")
        job = self.job(scene, block, code)
        if self._can_stay(scene, block, job):
            self.stays, self.code = True, code
            return Outcome([block.text], stays=True)
        if code in self.refused:
            raise self._refusal(scene, code)
        self.kept = False
        stays = code in self.tapping and not self.synchronised
        text = self.passed_on(scene, block, job) if stays else []
        self.stays, self.code = stays, code
        lines = self.lines(scene, block, job)
        # A tap stays the control's, which goes in step with the spindle; the tracker hears its way
        # as feeds.
        return Outcome(text, lines) if stays else Outcome(lines)

    def _refusal(self, scene: Scene, code: int) -> ProgramError:
        return scene.fault(
            f"G{code / 10:g} can not be written out: {self.refused[code]}", WRITE_OUT
        )

    def _can_stay(self, scene: Scene, block: Block, job: Job) -> bool:
        """Whether a block may stay the cycle that it is: the filter follows it and finds the same
        hole in it as we do, and that hole may (a tap always, which is no feed).

        Behind a hole that was written out none may, since the control has left its cycle. In G91
        none may: the filter takes places and distances in one series for a fault.
        """
        if (
            scene.keeps is None
            or not self.kept
            or scene.incremental
            or scene.unsure
            or job.codes
            or job.times != 1
        ):
            return False
        # The other reader of this block is the filter. Only where both find the same level, bottom
        # and way back may it stay; else the corrected cycle would drill another hole than the one
        # judged here.
        found = scene.tracker.ahead(block.text)
        if found is None:
            return False
        motions, state = found
        holes, hole = motions.holes, job.hole
        if len(motions) != 1 or len(holes) != 1 or motions.reason.any():
            return False
        row = int(holes.axis[0])
        read = (holes.level[0], holes.bottom[0], motions.target[row, 0])
        least = 10.0 ** -scene.decimals(hole.axis)
        same = scene.tracker.setup.axes[row] == hole.axis and all(
            abs(scene.coordinate(hole.axis, int(ticks), state) - value) <= least
            for ticks, value in zip(read, (hole.r, hole.bottom, hole.back), strict=True)
        )
        return same and (job.code in self.tapping or scene.keeps(motions))

    def job(self, scene: Scene, block: Block, code: int) -> Job:
        """What the block asks for. Raises ProgramError."""
        raise NotImplementedError

    def passed_on(self, scene: Scene, block: Block, job: Job) -> list[bytes]:
        """A tapping block as the control shall read it, when all cycles around it are written
        out."""
        return [block.text]

    # Whole: the motions of a hole in their order, with what stands between them.
    def lines(self, scene: Scene, block: Block, job: Job) -> list[bytes]:
        """G0 to the place and to R level, and the cycle's own motions, as often as L or K says.
        Raises ProgramError."""
        hole = job.hole
        # Before anything is written: 10,000 holes of 10,000 pecks would fill the memory.
        if job.times * len(hole.depths(scene)) > MOST_PECKS * 10:
            raise scene.fault(
                f"{job.times:,} holes of {len(hole.depths(scene)):,} pecks each",
                "check how often it is made, and the depths of the pecks and of the hole",
            )
        letters = "".join(w.letter for w in job.place) + hole.axis + self.words + job.drops
        own, clamp = own_words(block, letters, {job.code, *job.codes}), job.clamp
        m = Moves(
            scene, own | {i for i, w in enumerate(block.words) if w is clamp}, self.after_motion
        )
        # LinuxCNC: from below R level the axis goes up before anything moves across.
        for level in job.first:
            m.move("G0", {hole.axis: level})
        for k in range(job.times):
            # In G91 a place is a distance, which each repeat goes once more; in G90 repeats lie in
            # one place.
            words = (
                [block.text[w.start : w.stop] for w in job.place]
                if k == 0 or scene.incremental
                else []
            )
            # The text of these words is passed on unread: where they lead only the tracker knows.
            for w in job.place:
                scene.lose(w.letter)
            if k == 0 and job.level is not None and scene.differs(hole.axis, job.level):
                words.append(m.word(hole.axis, job.level))
            if words:
                m.words("G0", *words)
            if clamp:
                m.line(b"M" + clamp.raw.encode())
            m.move("G0", {hole.axis: hole.r})
            self.actions[job.code](m, hole, scene)
            if clamp:
                m.line(b"M%d" % (int(clamp.value or 0) + 1))
        return m.finish()

    def times(self, scene: Scene, block: Block, letters: str, least: int) -> int:
        """How often the hole is made: `least` to MOST_HOLES, 1 where no word says it. Raises
        ProgramError."""
        found = [w for w in block.words if w.letter in letters]
        if len(found) > 1:
            raise scene.fault(
                f"{found[0].letter} and {found[1].letter} both say how often",
                "write one of them",
                found[1],
            )
        if not found:
            return 1
        word = found[0]
        if (
            word.value is None
            or word.value != int(word.value)
            or not least <= word.value <= MOST_HOLES
        ):
            raise scene.fault(
                f"{word.letter}{word.raw} is no number of holes ({least} to {MOST_HOLES:,})",
                "write a whole number",
                word,
            )
        return int(word.value)
