"""Motions in turned, scaled or mirrored coordinates as motions in the coordinates beneath, whatever
the control.

A block keeps its text but for the words that change: all axes that a turn mixes are named, arcs get
their centre words turned and, where the map mirrors their plane, the other sense; the side of
cutter radius compensation follows. What sets such a map, and in which order, is in rotation.py,
scaling.py and polar.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from postproc.nc.codes import SPLINE_KEYS
from postproc.nc.cycles.affine import AXES, Affine, Point, point
from postproc.nc.cycles.arcs_in_space import check, lines
from postproc.nc.cycles.block import Block, Word, number_of
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, Scene

# codes that a mirrored plane swaps: the sense of an arc, the side of radius compensation
SENSES = {CLOCKWISE: b"G3", COUNTER: b"G2"}
SIDES = {410: b"G42", 420: b"G41"}
CORNERS = ("RND", "RNDM", "CHF", "CHR")
# motion codes whose axis words are places
# none yet, G0 to G3, threads (G32 G33), G80 and taps, whose place is a word like any other
FOLLOWED = (-1, 0, 10, 20, 30, 320, 330, 740, 800, 840, 842, 843)


@dataclass
class Frames:
    """The map in force and what following it needs. `at`: programmed coordinates as far as they are
    known here;
    `residue`: what rounding has kept back, added to the next distance; `loose`: axes whose
    programmed coordinate the control's manual does not define until a block names it (behind G68
    and G69 of Fanuc)."""

    scene: Scene
    map: Affine = field(default_factory=Affine)
    at: dict[str, float] = field(default_factory=dict)
    residue: dict[str, float] = field(default_factory=dict)
    loose: set[str] = field(default_factory=set)
    motion: int = -1  # the motion code as programmed
    written: int = -1  # and as the output has it
    why: str = "turned or scaled coordinates"
    strict: bool = False  # whether a distance from a place that is not defined is refused too

    @property
    def active(self) -> bool:
        """Whether blocks must be looked at."""
        return not self.map.identity or bool(self.loose) or self.motion != self.written

    def known(self, axis: str) -> float | None:
        """The programmed coordinate at which an axis stands."""
        if axis not in AXES or self.map.identity:
            return self.scene.work(axis)
        if axis in self.loose:
            return None
        if axis not in self.at:
            mixed = self.map.partners(axis)
            places = {x: self.scene.work(x) for x in mixed}
            if any(value is None for value in places.values()):
                return None
            # Of all axes that are mixed: one unknown among them leaves all of them unknown.
            p = dict(zip(AXES, self.map.inverse(point(places)), strict=True))
            self.at.update({x: p[x] for x in mixed})
        return self.at[axis]

    def forget(self) -> None:
        """Something went by that moves axes in a way not followed here."""
        self.at, self.residue = {}, {}

    def set_map(self, new: Affine) -> None:
        """Another map holds from here on; the machine stands where it stands. Raises
        ProgramError."""
        if self.scene.compensated:
            raise self.scene.fault(
                "the coordinates change with cutter radius compensation on", "end it before: G40"
            )
        if not self.active:
            # From here on G2 as programmed may be G3 as written; before, both were one.
            self.motion = self.written = self.scene.tracker.code("motion")
        self.map = new
        self.forget()

    # -- a block -----------------------------------------------------------------------------------

    def take(self, block: Block) -> list[bytes]:
        """A plain block in programmed coordinates, in those of the output."""
        #  no X Y Z I J K           only G41 G42 G2 G3 change, under a mirror
        #  an arc, plane tilted     becomes lines, each of which comes here again
        #  else                     words of axes that are mixed, all of them, and the centre's
        motions, changed = self.scene.own_codes(block, "motion"), self._swapped(block, SIDES)
        self.motion = motions[-1] if motions else self.motion
        words = {w.letter: w for w in block.words if w.letter in AXES}
        arc = self.motion in SENSES
        centres = {w.letter: w for w in block.words if arc and w.letter in "IJK"}
        if not words and not centres:
            return [self._named(block, changed, [], False)]
        self._check()
        if arc and self.factor() is None and self.map.turns:
            return self._in_space(block, centres)
        new, place = self._straight(block, words, changed)
        if arc and not self.map.identity:
            new += self._arc(block, centres, changed)
        return [self._named(block, changed, new, True, place)]

    def _straight(
        self, block: Block, words: dict[str, Word], changed: dict[int, bytes]
    ) -> tuple[list[bytes], int]:
        """Axis words: changed ones, those that come in, and behind how many words these stand."""
        new: list[bytes] = []
        place, at = len(block.words), {w.letter: i for i, w in enumerate(block.words)}
        # Each set of mixed axes once: in a turn about Z the words X and Y are one change, Z is
        # none.
        for mixed in dict.fromkeys(tuple(self.map.partners(x)) for x in words):
            if self._stays(mixed, words):
                continue
            own = {x: words[x] for x in mixed if x in words}
            texts = self._axes(mixed, own)
            changed |= {at[x]: texts.pop(x) for x in own}
            new += texts.values()
            if texts:
                # A word that comes in stands beside its partners, in front of F and M, in the order
                # X Y Z.
                beside = min(at[x] for x in own)
                place = beside + (max(texts) > block.words[beside].letter)
        return new, place

    def _check(self) -> None:
        """Raises ProgramError for motions that are not followed under this map."""
        code = self.scene.table.get(self.motion)
        # every mean of control points turns with them; how knots are spaced, a factor may change
        spline = code is not None and code.does in SPLINE_KEYS and self.map.turns
        if self.motion not in FOLLOWED and not (self.map.identity or spline):
            name = code.word if code else f"G{self.motion / 10:g}"
            raise self.scene.fault(
                f"{name} within {self.why}", "write it out, or end the frame before"
            )
        if self.scene.is_diameter("X") and not self.map.leaves("X"):
            raise self.scene.fault(
                f"X is a diameter within {self.why}", "write the program out with X as a radius"
            )

    def _stays(self, mixed: tuple[str, ...], words: dict[str, Word]) -> bool:
        """Whether the words of these axes stay as they are written."""
        if not all(self.map.leaves(x) for x in mixed):
            return False
        for x in mixed:
            if x in self.loose and (self.scene.incremental or words[x].mode == "IC"):
                raise self.scene.fault(
                    f"the first {x} behind {self.why} is a distance",
                    f"controls differ on where {x} stands: name it in G90",
                )
            self.loose.discard(x)
            self.at.pop(x, None)
        return True

    # Whole: absolute and incremental words share every place between.
    def _axes(self, mixed: tuple[str, ...], words: dict[str, Word]) -> dict[str, bytes]:
        """The words of axes that belong together."""
        scene = self.scene
        counted = ("IC", "") if scene.incremental else ("IC",)
        distances = {x for x, w in words.items() if w.mode in counted}
        # Distances need no place: they are turned alone. On a `strict` control the first block
        # behind a change names places, for where the axes stand then is not defined.
        defined = not (self.strict and self.loose & set(mixed))
        if scene.incremental and len(distances) == len(words) and defined:
            return self._distances(mixed, words)
        before = self._before(mixed, words, distances)
        start = {x: before[x] or 0.0 for x in distances}
        to = {x: scene.length(w, x) + start.get(x, 0.0) for x, w in words.items()}
        p = point({**before, **to})
        q = dict(zip(AXES, self.map(p), strict=True))
        self.loose -= set(mixed)
        self.at.update({x: p[AXES.index(x)] for x in mixed})
        if not scene.incremental:
            # What this place was rounded by, for a distance that goes on from it.
            self.residue |= {x: q[x] - scene.rounded(x, q[x]) for x in mixed}
            return {x: scene.text(x, q[x]) for x in mixed}
        old = dict(zip(AXES, self.map(point(before)), strict=True))
        return {x: self._by(x, q[x] - old[x]) for x in mixed}

    def _distances(self, mixed: tuple[str, ...], words: dict[str, Word]) -> dict[str, bytes]:
        by = point({x: self.scene.length(w, x) for x, w in words.items()})
        out = dict(zip(AXES, self.map.turned(by), strict=True))
        for x in mixed:
            if x in self.at:
                self.at[x] += by[AXES.index(x)]
        return {x: self._by(x, out[x]) for x in mixed}

    def _before(
        self, mixed: tuple[str, ...], words: dict[str, Word], distances: set[str]
    ) -> dict[str, float | None]:
        """Where the axes set out. Raises ProgramError where that counts and is not known."""
        scene, before = self.scene, {x: self.known(x) for x in mixed}
        sized = next((w for w in scene.block.words if w.letter in CORNERS), None)
        if sized and self.factor() not in (1.0, -1.0):
            raise scene.fault(
                f"{sized.letter} within {self.why}",
                "a corner does not keep its size: write it out",
                sized,
            )
        for x in (x for x in mixed if x not in words or x in distances):
            if x in self.loose:
                given = "a distance" if scene.incremental else f"{' and '.join(words)} alone"
                raise scene.fault(
                    f"the first block behind {self.why} names {given}",
                    f"controls differ on where {x} stands then: name {' and '.join(mixed)} in it,"
                    " in G90",
                )
            if before[x] is None:
                scene.at(x)
        return before

    def _by(self, axis: str, distance: float) -> bytes:
        """A distance, with what rounding has kept back so far."""
        # Three times X1 in G91, turned by 30 degrees, is three times X.866, 2.598 of 2.59808 mm:
        # what was kept back each time goes into the next word, so the sum is never off by more than
        # half a digit.
        exact = distance + self.residue.get(axis, 0.0)
        self.residue[axis] = exact - self.scene.rounded(axis, exact)
        return self.scene.text(axis, exact)

    # -- arcs --------------------------------------------------------------------------------------

    def factor(self) -> float | None:
        """By how much lengths of the plane grow, below 0 where it is mirrored; None: unlike in its
        two axes."""
        first, second, _ = self.scene.plane
        return self.map.similarity(first, second)

    def _in_space(self, block: Block, centres: dict[str, Word]) -> list[bytes]:
        """An arc whose plane the map tilts, as lines."""
        motion, scene = self.motion, self.scene
        check(scene, block, self.why)
        mixed = [x for x in AXES if not self.map.leaves(x)]
        centre = None
        if centres:
            absolute = scene.code("arc centre") == 901
            start = {x: 0.0 if absolute else scene.at(x) for x in AXES}
            # I J K count from the start; in G90.1 they are a place.
            by = self._centre(centres, absolute)
            centre = point({x: by[i] + start[x] for i, x in enumerate(AXES)})
        texts = list(lines(scene, block, motion, centre, mixed))
        grammar = scene.dialect.grammar
        made = [line for text in texts for line in self.take(Block.of(text, grammar))]
        self.motion = motion
        return made

    @property
    def _mirrored(self) -> bool:
        return (self.factor() or 0.0) < 0

    def _swapped(self, block: Block, codes: dict[int, bytes]) -> dict[int, bytes]:
        """These codes of a block, the other way round where the map mirrors its plane."""
        numbers = enumerate(map(number_of, block.words)) if self._mirrored else ()
        return {i: codes[n] for i, n in numbers if n in codes}

    def _arc(
        self, block: Block, centres: dict[str, Word], changed: dict[int, bytes]
    ) -> list[bytes]:
        """Centre words or R of an arc: changed ones, and those that come in."""
        scene, factor = self.scene, self.factor()
        first, second, _ = scene.plane
        if factor is None:
            raise scene.fault(
                f"an arc within {self.why} that makes an ellipse of it",
                "let the CAM program write it out as short straight lines",
            )
        radius = next(((i, w) for i, w in enumerate(block.words) if w.letter in ("R", "CR")), None)
        if radius and radius[1].value is not None:
            i, w = radius
            head = w.letter if w.letter == "R" else w.letter + "="
            changed[i] = head.encode() + scene.text("R", scene.length(w, first) * abs(factor))[1:]
        if not centres:
            return []
        absolute = scene.code("arc centre") == 901
        place = self._centre(centres, absolute)
        # A distance has no shift: the matrix alone.
        moved = self.map(place) if absolute else self.map.turned(place)
        mixed = self.map.partners(first) == self.map.partners(second)
        new = []
        for axis in (first, second):
            letter = CENTRES[axis]
            written = scene.text(letter, moved[AXES.index(axis)])
            if letter in centres:
                changed[block.words.index(centres[letter])] = written
            # In a turn the centre of I alone has a J as well.
            elif mixed:
                new.append(written)
        return new

    def _centre(self, given: dict[str, Word], absolute: bool) -> Point:
        """I J K as programmed: distances, or a place where `absolute`. Raises ProgramError."""
        lengths: dict[str, float | None] = {}
        for axis, letter in CENTRES.items():
            word = given.get(letter)
            if word and word.mode == "AC" and not absolute:
                raise self.scene.fault(
                    f"an absolute centre word within {self.why}", "write I J K as distances", word
                )
            lengths[axis] = self.scene.length(word, axis) if word else 0.0
        return point(lengths)

    def _named(
        self,
        block: Block,
        changed: dict[int, bytes],
        new: list[bytes],
        moves: bool,
        place: int | None = None,
    ) -> bytes:
        """The text, with the motion code that the output needs."""
        changed |= self._swapped(block, SENSES)
        # The code in force behind the last written block may be the other sense than this one
        # needs, though the program names neither.
        wanted = {20: 30, 30: 20}.get(self.motion, self.motion) if self._mirrored else self.motion
        named = bool(self.scene.own_codes(block, "motion"))
        sep = b" " if block.spaced else b""
        if moves and not named and wanted != self.written and wanted in SENSES:
            at = next((i for i, w in enumerate(block.words) if w.letter not in "NG"), 0)
            changed[at] = (
                f"G{wanted // 10}".encode()
                + sep
                + changed.get(at, block.text[block.words[at].start : block.words[at].stop])
            )
            named = True
        if named:
            self.written = wanted
        if not new and not changed:
            return block.text
        return block.written(set(), sep.join(new), place, changed)
