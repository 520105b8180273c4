"""Arcs and polar places of Heidenhain Klartext, written out as L.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, Klartext programming, "Path contours": C about
the pole CC, CR by its radius, LP and CP in polar coordinates, CP with an axis across the plane a
helix (the geometry of arcs: pole_arc.py). The two axes of CC are the plane: angles count from X in
XY, from Y in YZ, from Z in ZX. Lines leave the circle by the tolerance at most. Corners:
klartext_corners.py, tangents: klartext_tangent.py, APPR and DEP: klartext_join.py; holes, bores,
patterns, studs, pockets and faces: klartext_called.py.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from postproc.nc.comments import uncommented
from postproc.nc.cycles.before import Before
from postproc.nc.cycles.klartext_bore import Tool
from postproc.nc.cycles.klartext_called import called
from postproc.nc.cycles.klartext_corners import BETWEEN, Corners
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_join import Joined
from postproc.nc.cycles.klartext_lines import FAST, places, signed, without_own_feed
from postproc.nc.cycles.klartext_patterns import points
from postproc.nc.cycles.klartext_tangent import Heading
from postproc.nc.cycles.pole_arc import Arc, Point, by_radius, ends
from postproc.nc.cycles.scene import PLANES, Scene
from postproc.nc.expand import Line
from postproc.nc.grammar import KLARTEXT
from postproc.nc.klartext import CYCLE, HEAD, PATTERNS, TURNS

STATEMENT = re.compile(
    rb"(APPR|DEP|CC|CR|CP|CT|C|LP|L|RND|CHF|CYCL[ \t]+CALL|CYCL[ \t]+DEF|TOOL|M)(?![A-Z])[ \t]*"
)
WORD = re.compile(
    rb"(?<![A-Z])(I?)(X|Y|Z|PR|PA|R|DR)(?:[ \t]*([-+]?[0-9]*\.?[0-9]+)|([-+])(?![0-9.]))"
)
# R0, RL and RR are no radius: they are hidden (as \0) while words are read, and come back.
SIDES = re.compile(rb"(?<![A-Z])R[0LR](?![0-9.])")
MARKED = re.compile(rb"\0([0LR])")
CALLED = re.compile(rb"[ \t]*(?<![A-Z])M[ \t]*0*99(?![0-9])")
FEED = re.compile(rb"(?<![A-Z])F[ \t]*([0-9]*\.?[0-9]+|AUTO|MAX)")
AFTER_MOTION = re.compile(rb"(?<![A-Z])M[ \t]*[0-9]")
SHIFTED = re.compile(rb"[ \t]*(I?)([XYZ])[ \t]*([-+]?[0-9]*\.?[0-9]+)[ \t]*")
WITH_PARTS = (1, 2, 17)  # whose data stand behind a point
DATA_ONLY = (9, 13, 14, 32, 247, *TURNS)  # defined beside a drilling cycle, which holds on
XY = ("X", "Y", "Z")  # two axes of the plane, and the one across
Words = dict[str, tuple[bool, float]]


class KlartextPaths(Before):
    """Follows pole, feed and the cycle that is defined, and writes out what depends on them."""

    codes = (20, 30)

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self.holes = Holes(scene)
        self.corners, self.tool, self.heading = Corners(scene), Tool(scene), Heading(scene)
        self.joined = Joined(scene)
        self.pole: dict[str, float] = {}
        self.plane = XY  # of the pole
        self.at_line: Line | None = None  # the last one
        self.shift: dict[str, float] = {}  # by cycle 7
        self.feed = b""  # as the program wrote it last
        self.due = False  # whether another feed is in force than the program's
        self.goes_on = False  # a definition, in the next line
        self.pattern: Holes | None = None  # while it is defined
        self.lead = b""  # "/ " where its definition begins so

    def finish(self) -> list[Line]:
        """A line with a corner that has no other side."""
        return [self.at_line._replace(text=text) for text in self.corners.finish() if self.at_line]

    # Whole: the kinds of lines in their order of precedence.
    def take(self, line: Line) -> list[Line]:
        """The line, or the lines that it becomes. Raises ProgramError."""
        self.scene.forget()
        head = HEAD.match(line.text)
        assert head is not None
        code = uncommented(line.text, KLARTEXT)[head.end() :].rstrip(b" \t\r~")
        if self.scene.passes(line.text):
            return [line]
        found = STATEMENT.match(code)
        on = line.text.rstrip(b" \t\r").endswith(b"~")
        if found is None and not BETWEEN.match(code):
            self.heading.lose()
            if self.corners.at_work:
                raise self.corners.beside()
        lead = b"/ " if head[1] else b""
        if self.pattern is not None:
            self.pattern.datum(code)
            self.goes_on = on
            lead = self.lead
            return [] if on else [line._replace(text=lead + text) for text in self._pattern()]
        if self.goes_on or found is None:
            self.holes.datum(code)
            self.goes_on = self.goes_on and on
            return [line]
        if head[1] and (self.corners.at_work or code.startswith((b"RND", b"CHF"))):
            raise self.scene.fault("a corner in blocks that / may take out", "take the / out")
        return self._statement(line, code, found, lead, on)

    def _statement(
        self, line: Line, code: bytes, found: re.Match[bytes], lead: bytes, on: bool
    ) -> list[Line]:
        """A line that begins with a word of the language. lead: what its lines begin with; on: its
        data go on in the next line."""
        self.at_line = line
        self.tool.note(code)
        kind, rest = found[1].split()[-1], code[found.end() :]
        self.goes_on = kind == b"DEF" and on
        new = self._of(kind, code, rest)
        if self.pattern is not None:
            self.lead = lead
            if not on:
                raise self.scene.fault("a pattern without its data", "write ~ at the end of a line")
            return []
        if new == [code]:
            return [line]
        return [line._replace(text=lead + text) for text in new]

    def _of(self, kind: bytes, code: bytes, rest: bytes) -> list[bytes]:
        """The statements that stand for one."""
        if kind in (b"RND", b"CHF"):
            self.corners.define(code)
            return []
        if self.corners.at_work:
            self.heading.lose()
            return self._cornered(kind, code)
        if kind == b"DEF":
            self.heading.lose()
            return self._define(code)
        if kind == b"CC":
            self._set(rest)
            return []
        if kind in (b"APPR", b"DEP"):
            self.heading.lose()
            return self._fed(b"L", self.joined.take(code, self._centre))
        calls = kind == b"CALL" or CALLED.search(code) is not None
        if kind == b"L":
            self.heading.line(code)
        elif kind in (b"CALL", b"TOOL"):
            self.heading.lose()
        if kind == b"CALL":
            lines = [rest.strip()] if rest.strip() else []
        elif kind in (b"L", b"TOOL", b"M"):
            bare = CALLED.sub(b"", code)
            lines = self._fed(kind, bare) if bare.strip() else []
        else:
            lines = self._path(kind, CALLED.sub(b"", rest))
        if not calls:
            return lines
        self._note(lines)
        return lines + self._called()

    def _note(self, lines: list[bytes]) -> None:
        """Where the tool stands behind straight lines that nobody has taken yet."""
        for line in lines:
            if not line.startswith(b"L"):
                continue
            words = self._words(line[1:])
            named = {axis: self._place(words, axis) for axis in "XYZ" if axis in words}
            for axis, place in named.items():
                self.scene.moved(axis, place)

    def _called(self) -> list[bytes]:
        """The cycle that is defined, where the tool stands."""
        if self.holes.stays:
            return self.holes.kept()
        lines = called(self.scene, self.tool, self.holes)
        # A cycle has left its own feed: the program's must be named again where it feeds on.
        self.due = self.due or bool(lines)
        return lines

    def _pattern(self) -> list[bytes]:
        """Cycle 220 or 221, at the end of its definition."""
        pattern, self.pattern = self.pattern, None
        assert pattern is not None
        kept, scene = dict(self.holes.data), self.scene
        clear, top, between = pattern.value(200), pattern.value(203), pattern.value(301, 1.0)
        second = max(pattern.value(204, clear), clear)
        if self.holes.cycle in WITH_PARTS:
            raise scene.fault(f"a pattern of cycle {self.holes.cycle}", "define cycle 200 or 207")
        # The pattern's clearance, surface and level replace those of the cycle: Q301 0 stays low
        # between.
        own = {200: clear, 203: top, 204: second if between else 0.0}
        self.holes.data |= {n: f"{v:+.6f}".encode() for n, v in own.items()}
        high = b"L " + signed(scene, "Z", top + second) + FAST
        lines = [high]
        for place in points(scene, pattern.cycle, pattern.value):
            lines.append(b"L " + b" ".join(places(scene, place)) + FAST)
            for axis, v in zip("XY", place, strict=True):
                scene.moved(axis, v)
            lines += self._called()
        self.holes.data = kept
        return [*lines, high]

    def _cornered(self, kind: bytes, code: bytes) -> list[bytes]:
        """A line with a corner at one of its ends."""
        if kind != b"L" or CALLED.search(code):
            raise self.corners.beside()
        lines: list[bytes] = []
        for new, own in self.corners.line(code):
            lines += [new] if own else self._fed(b"L", new)
            self.due = self.due or own
        return lines

    # -- feeds and definitions ---------------------------------------------------------------------

    def _fed(self, kind: bytes, code: bytes) -> list[bytes]:
        """A straight line or a tool call: the feed that holds from there on, and the program's own
        again behind what a cycle fed with."""
        feed = FEED.search(without_own_feed(code))
        if feed is not None and feed[1] != b"MAX":
            self.feed, self.due = b"F" + feed[1], False
        elif feed is None and self.due and kind == b"L" and WORD.search(SIDES.sub(b"", code)):
            if not self.feed:
                raise self.scene.fault("the feed behind a cycle is not known", "write F here")
            self.due = False
            # F stands before M, which may have words of its own behind it (M103 F..).
            after_motion = AFTER_MOTION.search(code)
            place = after_motion.start() if after_motion else len(code)
            words = code[:place].rstrip(), self.feed, code[place:]
            return [b" ".join(word for word in words if word)]
        return [code]

    def _define(self, code: bytes) -> list[bytes]:
        """CYCL DEF: its number, and the values in the same line."""
        found = CYCLE.match(code)
        if found is None:
            return [code]
        number = int(found[1])
        if number == 247:
            self.shift = {}
        if number == 7:
            return self._shifted(code[: found.end()], code[found.end() :]) or [code]
        if number in PATTERNS:
            self.pattern = Holes(self.scene, number)
            return []
        if number in WITH_PARTS and found[2] not in (None, b"0"):
            self.holes.part(number, int(found[2]), code[found.end() :])
        elif number not in DATA_ONLY and found[2] in (None, b"0"):
            self.holes.define(number)
        self.holes.datum(code[found.end() :])
        return [code]

    def _shifted(self, head: bytes, rest: bytes) -> list[bytes]:
        """Cycle 7: an increment counts from the shift in force."""
        found = SHIFTED.fullmatch(rest)
        if found is None:
            return []
        axis, value = found[2].decode(), float(found[3])
        self.shift[axis] = value + (self.shift.get(axis, 0.0) if found[1] else 0.0)
        return [head + b" " + signed(self.scene, axis, self.shift[axis])] if found[1] else []

    # -- paths -------------------------------------------------------------------------------------

    def _words(self, text: bytes) -> Words:
        """Whether each word is an increment, and its value; DR: 1 against the clock, -1 with it."""
        found: Words = {}
        for match in WORD.finditer(SIDES.sub(b"", text)):
            name = match[2].decode()
            if name in found:
                raise self.scene.fault(f"two {name} words in one block", "keep one")
            found[name] = bool(match[1]), float(match[3] or match[4] + b"1")
        return found

    def _place(self, words: Words, axis: str) -> float:
        """Where an axis goes."""
        if axis not in words:
            return self.scene.at(axis)
        step, value = words[axis]
        return value + (self.scene.at(axis) if step else 0.0)

    def _set(self, rest: bytes) -> None:
        """CC: the pole, and the plane that its axes are; without words where the tool stands."""
        words = self._words(rest)
        named = [axis for axis in "XYZ" if axis in words]
        if len(named) == 3 or (len(named) == 1 and named[0] not in self.plane[:2]):
            raise self.scene.fault(
                f"the pole {' '.join(named)} is in no plane", "name its two axes: CC X Y"
            )
        if len(named) == 2:
            self.plane = next(p for p in PLANES.values() if set(p[:2]) == set(named))
        for axis in named or self.plane[:2]:
            self.pole[axis] = self._place(words, axis)

    def _path(self, kind: bytes, rest: bytes) -> list[bytes]:
        """C, CR, CP and LP."""
        scene, words = self.scene, self._words(rest)
        plane = XY if kind in (b"CR", b"CT") else self.plane
        polar, across = kind in (b"CP", b"LP"), plane[2]
        at = self._from(kind, words, plane)
        if across in words and not polar:
            raise scene.fault(f"{across} in {kind.decode()}", "write a helix as CP with IPA")
        turn = words.get("DR", (False, 0.0))[1]
        if kind not in (b"LP", b"CT") and not turn:
            raise scene.fault(f"{kind.decode()} without DR", "DR+ or DR- says which way it turns")
        # LP to PR and PA needs no start: an arc of no length about the pole carries its end.
        here = at or self._centre()
        arc = self._polar(kind, here, words) if polar else self._round(kind, here, words, plane)
        self._go_on(kind, arc, plane, at is not None)
        points = [arc.to] if kind == b"LP" else ends(scene, arc)
        if across not in words:
            if kind != b"LP":
                points = self.joined.touching(arc, points)
            return self._written([(point, None) for point in points], rest, plane)
        low, depth = scene.at(across), self._place(words, across)
        heights = [low + (depth - low) * k / len(points) for k in range(1, len(points) + 1)]
        return self._written(list(zip(points, heights, strict=True)), rest, plane)

    def _from(self, kind: bytes, words: Words, plane: tuple[str, str, str]) -> Point | None:
        """Where a path begins; None: not known, and LP to a place does not ask."""
        both_named = kind == b"LP" and all(not words.get(x, (True, 0.0))[0] for x in ("PR", "PA"))
        if both_named and None in (self.scene.known(plane[0]), self.scene.known(plane[1])):
            return None
        return self.scene.at(plane[0]), self.scene.at(plane[1])

    def _go_on(self, kind: bytes, arc: Arc, plane: tuple[str, str, str], start_known: bool) -> None:
        """The way at the end of a path; start_known: where it began is known."""
        if plane != XY or not start_known:
            self.heading.lose()
        elif kind == b"LP":
            self.heading.way = arc.to[0] - arc.at[0], arc.to[1] - arc.at[1]
            self.heading.here = dict(zip((b"X", b"Y"), arc.to, strict=True))
        else:
            self.heading.arc(arc)

    def _round(self, kind: bytes, at: Point, words: Words, plane: tuple[str, str, str]) -> Arc:
        """C and CR: to a place."""
        to = self._place(words, plane[0]), self._place(words, plane[1])
        if kind == b"CT":
            return self.heading.tangent(at, to)
        turn = words["DR"][1]
        if kind == b"CR":
            return by_radius(self.scene, at, to, words.get("R", (False, 0.0))[1], turn)
        return Arc(at, to, self._centre(), turn)

    def _centre(self) -> Point:
        a, b = self.plane[:2]
        if a not in self.pole or b not in self.pole:
            raise self.scene.fault("an arc or a polar place, and no pole is set", "write CC before")
        return self.pole[a], self.pole[b]

    def _polar(self, kind: bytes, at: Point, words: Words) -> Arc:
        """LP and CP: to a radius and an angle about the pole."""
        centre, turn = self._centre(), words.get("DR", (False, 0.0))[1]
        radius = math.dist(at, centre)
        begin = math.degrees(math.atan2(at[1] - centre[1], at[0] - centre[0]))
        step, angle = words.get("PA", (True, 0.0))
        end = begin + angle if step else angle
        if "PR" in words:
            if kind == b"CP":
                raise self.scene.fault("PR in CP", "the radius of CP is that of its start")
            more, value = words["PR"]
            radius = radius + value if more else value
        place = math.radians(end)
        to = centre[0] + radius * math.cos(place), centre[1] + radius * math.sin(place)
        if step and angle * turn < 0:
            raise self.scene.fault("IPA and DR of CP have different signs", "write both alike")
        #  CC + . . .    Angles count from the plane's first axis, PR is the radius of LP. IPA goes
        #     |\  PA     on from the start, and may go around more than once; PA names the end
        #     | \ PR     alone: there in the sense of DR, by 360 where it is the start.
        #     |  o to
        sweep = abs(angle) if step else (end - begin) * turn % 360 or 360.0
        return Arc(at, to, centre, turn, math.radians(sweep))

    def _written(
        self, ways: Sequence[tuple[Point, float | None]], rest: bytes, plane: tuple[str, str, str]
    ) -> list[bytes]:
        """L through places; the statement's own words at its first line, M at the last."""
        words = MARKED.sub(rb"R\1", WORD.sub(b"", SIDES.sub(lambda m: b"\0" + m[0][1:], rest)))
        words = b" ".join(words.split())
        at = AFTER_MOTION.search(words)
        words, after_motion = (
            (words[: at.start()].rstrip(), words[at.start() :]) if at else (words, b"")
        )
        fast = FAST.strip() if re.search(rb"F[ \t]*MAX", words) else b""
        lines = []
        for k, (place, z) in enumerate(ways):
            values = dict(zip(plane, (*place, z), strict=True))
            to = [signed(self.scene, axis, v) for axis in "XYZ" if (v := values[axis]) is not None]
            own = [fast if k else words, after_motion if k == len(ways) - 1 else b""]
            lines.append(b" ".join([b"L", *to, *(text for text in own if text)]))
        return [*self._fed(b"L", lines[0]), *lines[1:]]
