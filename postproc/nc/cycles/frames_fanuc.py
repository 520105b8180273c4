"""G68 G69, G51 G50, G51.1 G50.1 and G16 G15 of Fanuc and Haas mills.

Fanuc B-64304EN-2 and B-63944EN-2, "Coordinate system rotation", "Scaling", "Programmable mirror
image", "Polar coordinate command"; Haas mill operator's manual, G51 and G68. A motion is scaled
first, then turned; the centre of the turn is scaled too, its angle is not. G51 stands outside: G51,
G68, G69, G50.

Assumed: G51 scales X, Y and Z (parameter 5401 bit 0); its P, I, J, K without a point count 0.001
(5400 bit 7).
Refused: a mirror together with scaling or a turn, a turn in space, what rests on parameters (R, P
left out), and axes whose place the manual leaves open behind G68 and G69.
"""

from __future__ import annotations

from collections.abc import Callable

from postproc.nc.codes import FRAME_KEYS
from postproc.nc.cycles.affine import AXES, Affine, Point, point, rotation, scaling
from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.frame_control import FrameControl
from postproc.nc.cycles.moves import own_words
from postproc.nc.cycles.polar import Polar
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

CODES = (501, 511, 500, 510, 680, 690, 150, 160)
MIRROR_OFF, MIRROR_ON, SCALE_OFF, SCALE_ON, TURN_ON, TURN_OFF, POLAR_OFF, POLAR_ON = CODES
# Tool lengths move the axis across the plane, which a turn leaves as it is.
LENGTHS = {"length", "length words", "length more", "length minus", "no length"}
SHIFTS = {*FRAME_KEYS} - LENGTHS - {"data"}
TAKERS = (TURN_ON, SCALE_ON, MIRROR_ON, MIRROR_OFF)
SMALLEST = 1e-6  # of factors that can be undone
ONE = 0.001  # what 1 without a point means as a factor
CANCEL = "end it before (G69, G50, G50.1)"
CENTRE = dict.fromkeys("XYZ", "centre")
FORMS = {
    TURN_ON: Form("a rotation", CENTRE | {"R": "angle"} | dict.fromkeys("IJK", "axis in space")),
    SCALE_ON: Form("a scaling", CENTRE | dict.fromkeys("PIJK", "factor")),
    MIRROR_ON: Form("a mirror", dict.fromkeys("XYZ", "its place")),
    MIRROR_OFF: Form("a mirror", dict.fromkeys("XYZ", "its axis")),
}


class FanucFrames(FrameControl):
    """`counts`: whether factors without a point count ONE (Haas: they are refused); `forms`: the
    words of its codes."""

    codes: tuple[int, ...] = CODES
    takers: tuple[int, ...] = TAKERS
    counts = True
    forms = FORMS

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.polar = Polar(scene, self.frames)
        self.scale: Affine | None = None
        self.turn: Affine | None = None
        self.mirror: dict[str, float] = {}
        self.plane = 170
        self.sets: dict[int, Callable[[Block], None]] = {
            TURN_ON: self._turn,
            TURN_OFF: self._no_turn,
            SCALE_ON: self._scale,
            SCALE_OFF: self._no_scale,
            MIRROR_ON: self._mirror,
            MIRROR_OFF: self._no_mirror,
            POLAR_ON: lambda b: self.polar.begin(),
            POLAR_OFF: lambda b: setattr(self.polar, "on", False),
        }

    @property
    def active(self) -> bool:
        return self.polar.on or self.frames.active

    def _holders(self) -> tuple[object, ...]:
        return *super()._holders(), self.polar

    def take(self, block: Block) -> list[bytes]:
        own = [c for c in block.codes if c in self.codes]
        # it ends the tilted plane too, which stays in the program
        if TURN_OFF in own and self._tilted:
            self._no_turn(block)
            return [block.text]
        for code in own:
            block = self._set(block, code)
        if own and not block.words and not block.text.strip(b" \t\r/"):
            return []
        if not self.active:
            return [block.text]
        self._check(block)
        if self._taken(block):
            self.frames.forget()
            self.polar.forget()
            return [block.text]
        if self.polar.on:
            # These words are turned and rounded once more; without a map they are what leaves.
            self.scene.extra_decimals = 0 if self.frames.map.identity else 4
            block = self.polar.take(block)
            self.scene.extra_decimals = 0
        return self.frames.take(block)

    @property
    def _tilted(self) -> bool:
        """Whether a tilted plane (G68.2) is in force."""
        row = self.scene.table.get(self.scene.tracker.code("rotation"))
        return row is not None and row.does == "plane"

    def _taken(self, block: Block) -> bool:
        """Whether another code takes the axis words, or they are machine coordinates."""
        table = self.scene.table
        # X of G4 is a time, and G53 speaks of the machine: neither is turned.
        return any(c in (40, 530) or (c in table and table[c].takes) for c in block.codes)

    # Whole: the codes that the manual forbids, a condition to each.
    def _check(self, block: Block) -> None:
        """Codes that the manual forbids while the coordinates are turned or scaled."""
        scene = self.scene
        if self.frames.map.identity:
            return
        named = [
            w for w in block.words if w.letter in AXES and not self.frames.map.leaves(w.letter)
        ]
        for code in block.codes:
            row = scene.table.get(code)
            if row is None or (row.does == "local" and self._idle(named)):
                continue
            moves = row.does in SHIFTS and (named or not row.takes)
            if row.group in ("work offset", "units") or moves:
                raise scene.fault(f"{row.word} ({row.meaning}) within {self.frames.why}", CANCEL)
            if row.group == "plane" and row.number != self.plane:
                raise scene.fault(f"another plane within {self.frames.why}", CANCEL)
            homes = code in (280, 300) and not _axes(block)
            if (code == 530 or row.takes) and (named or homes):
                raise scene.fault(
                    f"{row.word} names {named[0].letter if named else 'no axis'} within"
                    f" {self.frames.why}",
                    CANCEL,
                )

    def _idle(self, words: list[Word]) -> bool:
        """Whether a G52 with these words leaves local coordinates that are none."""
        frame, axes = self.scene.tracker.state.frame, self.scene.tracker.setup.axes
        return all(
            w.value == 0 and (frame is None or not frame.local[axes.index(w.letter)])
            for w in words
            if w.letter in axes
        )

    # -- what the codes set ------------------------------------------------------------------------

    def _set(self, block: Block, code: int) -> Block:
        """Let a code hold; the block without what belongs to it."""
        form = self.forms.get(code, Form(""))
        # Of two of these codes in one block each would take the other's words for strange ones.
        if code in self.forms and sum(c in self.forms for c in block.codes) == 1:
            form.check(self.scene, block, code)
        letters = "".join(form.takes)
        rest = Block.of(
            block.written(own_words(block, letters, {code})), self.scene.dialect.grammar
        )
        self.sets[code](block)
        return rest

    def _hold(self) -> None:
        # From the inside out: what a word says is mirrored or scaled first, then turned.
        total = scaling(dict.fromkeys(self.mirror, -1.0), point(self.mirror))
        for part in (self.scale, self.turn):
            total = part.after(total) if part else total
        self.plane = self.scene.code("plane")
        self.frames.why = (
            " and ".join(
                name
                for name, on in (
                    ("mirrored coordinates", self.mirror),
                    ("scaling (G51)", self.scale),
                    ("the rotation (G68)", self.turn),
                )
                if on
            )
            or self.frames.why
        )
        self.frames.set_map(total)
        self.polar.forget()

    def _alone(self, others: bool, what: str) -> None:
        if others:
            raise self.scene.fault(
                f"{what} together with a mirror",
                "the manual leaves the centre open: write one of them out",
            )

    def _turn(self, block: Block) -> None:
        """G68: the rotation that holds from here on. Raises ProgramError."""
        scene = self.scene
        self._alone(bool(self.mirror), "a rotation (G68)")
        first, second, _ = scene.plane
        if space := next((w for w in block.words if w.letter in "IJK"), None):
            raise scene.fault(
                "G68 with I J K turns in space",
                "only turns within the plane are written out",
                space,
            )
        angle = self._angle(block)
        if self.turn and scene.incremental:
            raise scene.fault(
                "G68 in G91 within a rotation",
                "whether R adds up is a parameter: write G69 or G90 before",
            )
        out = (w for w in block.words if w.letter in AXES and w.letter not in (first, second))
        if across := next(out, None):
            raise scene.fault(
                f"{across.letter} in a rotation (G68): it lies across the plane",
                "take it out of the block",
                across,
            )
        pivot = self._pivot(block)
        self.turn = rotation(first, second, angle, pivot)
        self._hold()
        # Where the axes stand in the turned coordinates, before a block names them, the manual
        # leaves open; a turn by 0 leaves nothing open.
        self.frames.loose |= {first, second} if angle % 360 else set()

    def _pivot(self, block: Block) -> Point:
        """The centre of a rotation, in the coordinates beneath it. Raises ProgramError."""
        scene, (first, second, _) = self.scene, self.scene.plane
        given = [w for w in block.words if w.letter in (first, second)]
        if len(given) == 1:
            raise scene.fault(
                f"G68 with {given[0].letter} alone",
                "name both coordinates of the centre, or none",
                given[0],
            )
        if not given:
            return point({x: self._stands(x) for x in (first, second)})
        pivot = point({w.letter: scene.length(w, w.letter) for w in given})
        #         scaled first          then turned about the scaled centre
        #   p ---- scale ----> s(p) ---- turn about s(pivot) ----> q
        return self.scale(pivot) if self.scale else pivot

    def _angle(self, block: Block) -> float:
        """Of G68, in degrees."""
        scene, angle = self.scene, block.word("R")
        if angle is None or angle.value is None:
            raise scene.fault(
                "G68 without its angle R",
                "the control takes it from a parameter or a setting: write R",
            )
        return scene.angle(angle)

    def _no_turn(self, block: Block) -> None:
        if self.turn is None:
            return
        first, second, _ = self.scene.plane
        loose = self.frames.loose | ({first, second} if not self.turn.identity else set())
        self.turn = None
        self._hold()
        self.frames.loose = loose
        self.frames.why = "the rotation (G68)"

    def _scale(self, block: Block) -> None:
        """G51: the factors that hold from here on; an axis that it does not name is scaled about
        where it stands. Raises ProgramError."""
        scene = self.scene
        self._alone(bool(self.mirror), "scaling (G51)")
        if self.turn:
            raise scene.fault("G51 within a rotation", "the manual wants G51 before G68")
        whole = block.word("P")
        each = next((w for w in block.words if w.letter in "IJK"), None)
        if whole and each:
            raise scene.fault(
                f"P and {each.letter} both say a factor of G51", "write P alone, or I J K", each
            )
        if whole:
            factors = dict.fromkeys(AXES, self._factor(whole))
        else:
            factors = {
                x: self._factor(w) for x, c in zip(AXES, "IJK", strict=True) if (w := block.word(c))
            }
            if len(factors) < 3:
                raise scene.fault(
                    "G51 without P, and without all of I J K", "the rest are parameters: write them"
                )
        centre = {w.letter: scene.length(w, w.letter) for w in block.words if w.letter in AXES}
        self.scale = None
        self._hold()
        for x in AXES:
            if x not in centre and factors[x] != 1.0:
                centre[x] = self._stands(x)
        self.scale = scaling(factors, point(centre))
        self._hold()

    def _factor(self, word: Word) -> float:
        value = word.value or 0.0
        if "." not in word.raw:
            if not self.counts:
                raise self.scene.fault(
                    f"the factor {word.letter}{word.raw} has no decimal point",
                    f"write {word.letter}{word.raw}.",
                    word,
                )
            value *= ONE
        if not SMALLEST <= abs(value) <= 1 / SMALLEST:
            raise self.scene.fault(
                f"a factor of {value:g}", f"factors are {SMALLEST:g} to {1 / SMALLEST:g}", word
            )
        return value

    def _no_scale(self, block: Block) -> None:
        if self.turn:
            raise self.scene.fault("G50 within a rotation", "the manual wants G69 before G50")
        self.scale = None
        self._hold()

    def _mirror(self, block: Block) -> None:
        self._alone(bool(self.scale or self.turn), "scaling or a rotation")
        named = {w.letter: self.scene.length(w, w.letter) for w in block.words if w.letter in AXES}
        if not named:
            raise self.scene.fault(
                "G51.1 without an axis", "name the axis and where the mirror stands: G51.1 X0"
            )
        # Axes add up: G51.1 X0 behind G51.1 Y0 mirrors both.
        self.mirror = {**self.mirror, **named}
        self._hold()

    def _no_mirror(self, block: Block) -> None:
        named = _axes(block)
        # G50.1 X0 ends the mirror of X, G50.1 without an axis all of them.
        self.mirror = {x: v for x, v in self.mirror.items() if named and x not in named}
        self._hold()

    def _stands(self, axis: str) -> float:
        value = self.scene.work(axis)
        if value is None:
            raise self.scene.fault(
                f"the centre is where the tool stands, and {axis} is not known",
                f"name the centre, or say where {axis} stands: --start {axis}0",
            )
        return value


def _axes(block: Block) -> list[str]:
    return [w.letter for w in block.words if w.letter in AXES]
