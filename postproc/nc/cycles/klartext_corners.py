"""RND and CHF of Heidenhain Klartext: the corner between two straight lines, written out as L.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, Klartext programming, "Rounded corners RND"
and "Inserting a chamfer between two straight lines": the corner lies at the end of the line before;
RND R is the radius of an arc that touches both, CHF how far the chamfer begins and ends from the
corner, which is not part of the contour; F behind them holds in the corner alone. Both lie in the
working plane.

The statement comes here in front of the line whose end it makes (expand/klartext.py). Refused:
arcs beside a corner, FMAX, lines that leave the plane, a corner that is
longer than its lines.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from postproc.nc.cycles.bend import NEAR, bent
from postproc.nc.cycles.klartext_lines import places
from postproc.nc.cycles.pole_arc import Arc, Point, ends
from postproc.nc.cycles.scene import Scene

CORNER = re.compile(
    rb"(RND|CHF)[ \t]*(?:R[ \t]*)?([+]?[0-9]*\.?[0-9]+)[ \t]*(?:F[ \t]*([0-9]*\.?[0-9]+))?[ \t]*"
)
PLACE = re.compile(rb"(?<![A-Z])(I?)([XY])[ \t]*([-+]?[0-9]*\.?[0-9]+)[ \t]*")
ELSEWHERE = re.compile(rb"(?<![A-Z])I?[ZABCUVW][ \t]*[-+]?[.0-9]")
BETWEEN = re.compile(rb"Q|FN|\*|\Z")  # may stand between two paths
FAST = re.compile(rb"F[ \t]*MAX")
WRITE = "write the corner out as L and CR"


@dataclass
class Held:
    """A line whose end waits for the next one: its other words, its ends, and its corner."""

    words: bytes
    start: Point
    end: Point
    name: str
    size: float
    feed: bytes  # of the corner alone, b"": that in force


class Corners:
    """Holds a line with a corner back until the next line is known."""

    def __init__(self, scene: Scene):
        self.scene = scene
        # the corner of the next line: its name, size and feed
        self.coming: tuple[str, float, bytes] | None = None
        self.held: Held | None = None

    @property
    def at_work(self) -> bool:
        """Whether the next statement must be a straight line."""
        return self.coming is not None or self.held is not None

    def define(self, code: bytes) -> None:
        """RND or CHF. Raises ProgramError."""
        found = CORNER.fullmatch(code)
        name = code[:3].decode()
        if found is None:
            raise self.scene.fault(f"{name} with more than its size", WRITE)
        if float(found[2]) <= 0:
            raise self.scene.fault(f"{name} with no size", "write a size above 0")
        self.coming = name, float(found[2]), found[3] or b""

    def beside(self) -> Exception:
        """What stands between a line and the next one is none."""
        name = self.coming[0] if self.coming else self.held.name if self.held else ""
        return self.scene.fault(f"{name} beside something else than a straight line", WRITE)

    def finish(self) -> list[bytes]:
        """A line whose corner has no other side."""
        held, self.held = self.held, None
        return [] if held is None else [self._line(held.end, held.words)]

    def line(self, code: bytes) -> list[tuple[bytes, bool]]:
        """The lines that are known now, and whether each has the feed of a corner. Raises
        ProgramError."""
        held, coming = self.held, self.coming
        name = coming[0] if coming else held.name if held else ""
        body = code[1:]
        start = held.end if held else (self.scene.at("X"), self.scene.at("Y"))
        end = self._end(name, body, start)
        if coming and FAST.search(body):
            raise self.scene.fault(f"{name} at FMAX", "write a feed")
        # F, M and R0 stay with the line whose place is written anew.
        words = b" ".join(PLACE.sub(b" ", body).split())
        lines: list[tuple[bytes, bool]] = []
        if held is not None:
            start, points = self.cut(held, end, held.name)
            lines.append((self._line(start, held.words), False))
            own = b"F" + held.feed if held.feed else b""
            for k, start in enumerate(points):
                lines.append((self._line(start, b"" if k else own), bool(own)))
        #  RND R5           coming: comes here in front of the line whose end it makes
        #  L X+50 Y+0       held: where it ends the corner and the next line say
        #  L X+50 Y+40      known now: the first line up to the arc, the arc, and this one
        self.held = self.coming = None
        if coming is None:
            return [*lines, (self._line(end, words), False)]
        self.held = Held(words, start, end, *coming)
        return lines

    def _end(self, name: str, body: bytes, start: Point) -> Point:
        if ELSEWHERE.search(body):
            raise self.scene.fault(f"{name} at a line that leaves the plane", WRITE)
        place = list(start)
        for step, axis, value in PLACE.findall(body):
            k = b"XY".index(axis)
            place[k] = float(value) + (start[k] if step else 0.0)
        if math.dist(place, start) < NEAR:
            raise self.scene.fault(f"{name} at a line without length", WRITE)
        return place[0], place[1]

    def _line(self, to: Point, words: bytes) -> bytes:
        return b" ".join(part for part in (b"L", *places(self.scene, to), words) if part)

    def cut(self, held: Held, end: Point, name: str) -> tuple[Point, list[Point]]:
        """Where the line ends then, and the ends of the lines of its corner; name: of the corner.
        Raises ProgramError."""
        scene, round_ = self.scene, held.name == "RND"
        bend = bent(held.start, held.end, end)
        if bend.straight:
            return held.end, []
        if bend.back:
            raise scene.fault(f"{name} where the line runs back", WRITE)
        # A rounding has its radius, a chamfer the way from the corner.
        away = bend.away(held.size) if round_ else held.size
        if away > bend.length + NEAR:
            raise scene.fault(
                f"{name} {held.size:g} begins {away:.4g} before the corner, and a line there"
                f" has {bend.length:.4g}",
                "the control stops at it: make the corner smaller",
            )
        first, second = bend.ends(away)
        arc = Arc(first, second, bend.centre(held.size), 1.0 if bend.left else -1.0)
        return first, ends(scene, arc) if round_ else [second]
