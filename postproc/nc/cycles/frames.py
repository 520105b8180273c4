"""Motions in turned, scaled or mirrored coordinates as motions in the coordinates beneath, whatever
the control.

A block keeps its text but for the words that change: all axes that a turn mixes are named, arcs get
their centre words turned and, where the map mirrors their plane, the other sense; the side of
cutter radius compensation follows. What sets such a map, and in which order, is in rotation.py,
scaling.py and polar.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from postproc.nc.cycles.affine import AXES, Affine, point
from postproc.nc.cycles.block import Block, Word, number_of
from postproc.nc.cycles.scene import CENTRES, CLOCKWISE, COUNTER, Scene

SWAPPED = {20: b"G3", 30: b"G2", 410: b"G42", 420: b"G41"}
SIDES = (410, 420)
CORNERS = ("RND", "RNDM", "CHF", "CHR")
# motion codes whose axis words are places
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
            p = dict(zip(AXES, self.map.inverse(point(places)), strict=True))
            self.at.update({x: p[x] for x in mixed})
        return self.at[axis]

    def forget(self) -> None:
        """Something went by that moves axes in a way not followed here."""
        self.at, self.residue = {}, {}

    def set_map(self, new: Affine) -> None:
        """Another map holds from here on; the machine stands where it stands."""
        if self.scene.code("cutter") in (410, 411, 420, 421):
            raise self.scene.fault(
                "the coordinates change with cutter radius compensation on", "end it before: G40"
            )
        if not self.active:
            self.motion = self.written = self.scene.tracker.code("motion")
        self.map = new
        self.forget()

    # -- a block -----------------------------------------------------------------------------------

    def take(self, block: Block) -> list[bytes]:
        """A plain block in programmed coordinates, in those of the output."""
        scene, changed = self.scene, {}
        factor = self.factor()
        for i, w in enumerate(block.words):
            number = number_of(w)
            if number in SIDES and factor is not None and factor < 0:
                changed[i] = SWAPPED[number]
            if number is not None and scene.group_of(number) == "motion":
                self.motion = number
        words = {w.letter: (i, w) for i, w in enumerate(block.words) if w.letter in AXES}
        arc = self.motion in (CLOCKWISE, COUNTER)
        centres = [(i, w) for i, w in enumerate(block.words) if w.letter in "IJK"] if arc else []
        if not words and not centres:
            return [self._named(block, changed, [], False)]
        if self.motion not in FOLLOWED and not self.map.identity:
            raise scene.fault(
                f"G{self.motion / 10:g} within {self.why}", "write it out, or end the frame before"
            )
        if scene.is_diameter("X") and not self.map.leaves("X"):
            raise scene.fault(
                f"X is a diameter within {self.why}", "write the program out with X as a radius"
            )
        new: list[bytes] = []
        place = len(block.words)
        for mixed in self._groups(words):
            if self._stays(mixed, words):
                continue
            texts = self._axes(mixed, {x: words[x][1] for x in mixed if x in words})
            for axis, text in texts.items():
                if axis in words:
                    changed[words[axis][0]] = text
                else:
                    new.append(text)
                    beside = min(words[x][0] for x in mixed if x in words)
                    place = beside + (axis > block.words[beside].letter)
        if arc and not self.map.identity:
            new += self._arc(block, centres, factor, changed)
        return [self._named(block, changed, new, True, place)]

    def _stays(self, mixed: list[str], words: dict[str, tuple[int, Word]]) -> bool:
        """Whether the words of these axes stay as they are written."""
        if not all(self.map.leaves(x) for x in mixed):
            return False
        for x in mixed:
            if x in self.loose and (self.scene.incremental or words[x][1].mode == "IC"):
                raise self.scene.fault(
                    f"the first {x} behind {self.why} is a distance",
                    f"controls differ on where {x} stands: name it in G90",
                )
            self.loose.discard(x)
            self.at.pop(x, None)
        return True

    def _groups(self, words: dict[str, tuple[int, Word]]) -> list[list[str]]:
        groups: list[list[str]] = []
        for axis in words:
            mixed = self.map.partners(axis)
            if mixed not in groups:
                groups.append(mixed)
        return groups

    def _axes(self, mixed: list[str], words: dict[str, Word]) -> dict[str, bytes]:
        """The words of axes that belong together."""
        scene = self.scene
        distance = {
            x: w.mode == "IC" or (scene.incremental and w.mode != "AC") for x, w in words.items()
        }
        if (
            scene.incremental
            and all(distance.values())
            and not (self.strict and self.loose & set(mixed))
        ):
            by = point({x: w.value for x, w in words.items()})
            out = dict(zip(AXES, self.map.turned(by), strict=True))
            for x in mixed:
                if x in self.at:
                    self.at[x] += by[AXES.index(x)]
            return {x: self._by(x, out[x]) for x in mixed}
        before = {x: self.known(x) for x in mixed}
        unnamed = [x for x in mixed if x not in words or distance[x]]
        sized = next((w for w in scene.block.words if w.letter in CORNERS), None)
        if sized and self.factor() not in (1.0, -1.0):
            raise scene.fault(
                f"{sized.letter} within {self.why}",
                "a corner does not keep its size: write it out",
                sized,
            )
        for x in unnamed:
            if x in self.loose:
                given = "a distance" if scene.incremental else f"{' and '.join(words)} alone"
                raise scene.fault(
                    f"the first block behind {self.why} names {given}",
                    f"controls differ on where {x} stands then: name {' and '.join(mixed)} in it,"
                    " in G90",
                )
            if before[x] is None:
                scene.at(x)
        to = {
            x: scene.length(words[x], x) + ((before[x] or 0.0) if distance[x] else 0.0)
            for x in words
        }
        p = point({**before, **to})
        q = dict(zip(AXES, self.map(p), strict=True))
        self.loose -= set(mixed)
        self.at.update({x: p[AXES.index(x)] for x in mixed})
        if not scene.incremental:
            for x in mixed:
                self.residue[x] = q[x] - scene.rounded(x, q[x])
            return {x: scene.text(x, q[x]) for x in mixed}
        old = dict(zip(AXES, self.map(point(before)), strict=True))
        return {x: self._by(x, q[x] - old[x]) for x in mixed}

    def _by(self, axis: str, distance: float) -> bytes:
        """A distance, with what rounding has kept back so far."""
        exact = distance + self.residue.get(axis, 0.0)
        self.residue[axis] = exact - self.scene.rounded(axis, exact)
        return self.scene.text(axis, exact)

    # -- arcs --------------------------------------------------------------------------------------

    def factor(self) -> float | None:
        """By how much lengths of the plane grow, below 0 where it is mirrored; None: unlike in its
        two axes."""
        first, second, _ = self.scene.plane
        return self.map.similarity(first, second)

    def _arc(
        self,
        block: Block,
        centres: list[tuple[int, Word]],
        factor: float | None,
        changed: dict[int, bytes],
    ) -> list[bytes]:
        """Centre words or R of an arc: changed ones, and those that come in."""
        scene = self.scene
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
        given = {w.letter: w for _, w in centres}
        base: list[float] = []
        for axis in AXES:
            word = given.get(CENTRES[axis])
            whole = absolute or (word is not None and word.mode == "AC")
            if whole and word is None:
                base.append(0.0)
            elif whole and word is not None and not absolute:
                raise scene.fault(
                    f"an absolute centre word within {self.why}", "write I J K as distances", word
                )
            else:
                base.append(scene.length(word, axis) if word else 0.0)
        place = base[0], base[1], base[2]
        moved = dict(
            zip(AXES, self.map(place) if absolute else self.map.turned(place), strict=True)
        )
        text = {CENTRES[x]: scene.text(CENTRES[x], moved[x]) for x in (first, second)}
        mixed = self.map.partners(first) == self.map.partners(second)
        new = []
        for letter, written in text.items():
            at = next((i for i, w in centres if w.letter == letter), None)
            if at is not None:
                changed[at] = written
            elif mixed:
                new.append(written)
        return new

    def _named(
        self,
        block: Block,
        changed: dict[int, bytes],
        new: list[bytes],
        moves: bool,
        place: int | None = None,
    ) -> bytes:
        """The text, with the motion code that the output needs."""
        factor = self.factor()
        turned = factor is not None and factor < 0
        wanted = {20: 30, 30: 20}.get(self.motion, self.motion) if turned else self.motion
        named = False
        for i, w in enumerate(block.words):
            if number_of(w) in (CLOCKWISE, COUNTER) and turned:
                changed[i] = SWAPPED[number_of(w) or 20]
            named = named or (
                number_of(w) is not None and self.scene.group_of(number_of(w) or 0) == "motion"
            )
        sep = b" " if block.spaced else b""
        if moves and not named and wanted != self.written and wanted in (CLOCKWISE, COUNTER):
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
