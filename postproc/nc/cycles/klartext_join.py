"""APPR and DEP of Heidenhain Klartext: how a contour is joined and left.

HEIDENHAIN TNC 640, TNC 620, iTNC 530, TNC 410 user's manuals, Klartext programming, "Contour
approach and departure": APPR LT, LN, CT, LCT go to the first point of the contour, whose way is the
way of the first element there; DEP goes on from the last point. Both stay as they are written
(klartext.py), for their ways lie beside the tool by its radius. In polar coordinates (APPR PLT and
its kin, DEP PLCT) they are written with X and Y.

An arc that is written out as lines begins and ends along its tangent between APPR and DEP, so that
the ways that join it are those of the arc: the first and last line touch it, and leave it by half
the tolerance.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from postproc.nc.cycles.klartext_lines import places
from postproc.nc.cycles.pole_arc import Arc, Point
from postproc.nc.cycles.scene import Scene

POLAR = re.compile(rb"(APPR|DEP)[ \t]+P(LT|LN|CT|LCT)(?![A-Z])")
WORDS = re.compile(rb"(?<![A-Z])(I?)(PR|PA)[ \t]*([-+]?[0-9]*\.?[0-9]+)[ \t]*")
PART_OF_A_LINE = 0.4  # of the angle of a line, at most: where the first one leaves its arc
Pole = Callable[[], Point]


class Joined:
    """Whether the program is between APPR and DEP."""

    def __init__(self, scene: Scene):
        self.scene, self.inside = scene, False

    def take(self, code: bytes, pole: Pole) -> bytes:
        """The statement, in X and Y. Raises ProgramError."""
        self.inside = code.startswith(b"APPR")
        found = POLAR.match(code)
        if found is None:
            return code
        words = {name: (bool(step), float(value)) for step, name, value in WORDS.findall(code)}
        if set(words) != {b"PR", b"PA"} or any(step for step, _ in words.values()):
            name = found[1].decode()
            raise self.scene.fault(
                f"{name} in polar coordinates without PR and PA as places",
                "write PR and PA, or X and Y",
            )
        centre, radius, angle = pole(), words[b"PR"][1], math.radians(words[b"PA"][1])
        to = centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)
        rest = WORDS.sub(b"", code[found.end() :]).strip()
        return b" ".join((found[1], found[2], *places(self.scene, to), rest)).rstrip()

    def touching(self, arc: Arc, points: list[Point]) -> list[Point]:
        """The ends of the lines of an arc, with one more at either end, on its tangents."""
        if not self.inside:
            return points
        first = self._along(arc, arc.at, points[0], 1.0)
        last = self._along(arc, arc.to, points[-2] if len(points) > 1 else arc.at, -1.0)
        return [first, *points[:-1], last, arc.to]

    def _along(self, arc: Arc, end: Point, other: Point, way: float) -> Point:
        """A place on the tangent at an end of an arc; `other`: the other end of the line there."""
        arm = end[0] - arc.centre[0], end[1] - arc.centre[1]
        radius = math.hypot(*arm)
        step = 2 * math.asin(min(math.dist(end, other) / 2 / radius, 1.0))
        # A tangent of length s ends s^2 / 2 R beside its circle: half the tolerance where s^2 = R
        # chord. Not more than 0.4 of a line, since the tangents of both ends may meet on one line.
        reach = min(math.sqrt(radius * self.scene.chord), PART_OF_A_LINE * step * radius)
        # The arm, turned by a quarter in the sense of the arc, is the way; `way` -1 goes back along
        # it.
        share = way * arc.turn * reach / radius
        return end[0] - share * arm[1], end[1] + share * arm[0]
