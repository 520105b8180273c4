"""Pockets and slots of Heidenhain Klartext, cycles 251, 252 and 253, written out as L.

HEIDENHAIN TNC 640 (34059x-01), TNC 620, iTNC 530, Cycle Programming, "Rectangular pocket (cycle
251)", "Circular pocket (cycle 252)", "Slot milling (cycle 253)": Q215 0 roughing and finishing, 1
roughing, 2 finishing. Roughing: at the middle from the set-up clearance Q200 above the surface Q203
down by Q202, "from the inside out" with ways of Q370 times the tool's radius, up to the allowances
Q368 at the wall and Q369 above the bottom; back to the middle at the set-up clearance above that
depth. Finishing: the wall, where Q368 is not 0, by Q338 (0: at once), joined along its tangent;
then the bottom, where Q369 is not 0. Then to the second clearance Q204 and to where the cycle was
called. 251: Q218 by Q219, corners of Q220 (the tool's radius at least), turned by Q224, Q367 says
which place of the pocket that is; 252: Q223 across; 253: Q218 by Q219, turned by Q374, Q367 its
middle, an end or the middle of an end. Q351 +1 is climb milling, -1 up-cut.

    Q204  - - - - - - - - - - - - - - - - -      second clearance, where it begins and ends
    Q200  - - - - - - v - - - - - - - - - -      set-up clearance above the surface
    Q203  ========.   |              .=====      surface
                  |   v______  Q202  |           each depth: rings from the middle out
                  |   v______  Q202  | Q368      allowance at the wall
                  |..................| Q369      allowance above the bottom
    Q201          '------------------'

Wall, bottom and sense are those of the manual. Inside: rings, closer than Q370 where their corners
are sharp. The angle at which the tool plunges (Q366 1, on a helix, 2 to and fro) is in the tool
table: here a slope of 3 degrees. Refused: no Q351, a spindle that does not turn by M3, a tool that
does not fit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from postproc.nc.cycles.klartext_bore import Tool
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_lines import FAST, Lines
from postproc.nc.cycles.klartext_stud import MIDDLE
from postproc.nc.cycles.pocket_path import Piece, Point
from postproc.nc.cycles.pole_arc import Arc, along, ends
from postproc.nc.cycles.rounded import Rounded, step_of
from postproc.nc.cycles.scene import Scene

RECTANGLE, CIRCLE, SLOT = 251, 252, 253
POCKETS = (RECTANGLE, CIRCLE, SLOT)
SLOPE = math.tan(math.radians(3.0))
JOIN_MM = 2.0
MOST_DEPTHS = 1000
NEAR = 1e-6


def pocket(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """The cycle where the tool stands. Raises ProgramError."""
    work = data.value(215, 0.0)
    if work not in (0, 1, 2):
        raise scene.fault(f"cycle {data.cycle} with Q215 {work:g}", "write 0, 1 or 2")
    cut = _Cut(scene, tool, data)
    if work != 2:
        cut.rough()
    if work != 1:
        cut.finish()
    return cut.end()


@dataclass
class _Cut:
    """Writes one pocket."""

    scene: Scene
    tool: Tool
    data: Holes

    def __post_init__(self) -> None:
        scene, value = self.scene, self.data.value
        self.lines = Lines(scene)
        self.cycle, self.value, self.feed = self.data.cycle, value, self.data.feed
        self.sense = value(351, 0.0)
        self.tool.check_sense(self.cycle, self.sense)
        self.radius = self.tool.radius(self.cycle)
        self.top, self.clear = value(203), value(200)
        self.depth, self.side, self.floor = -value(201), value(368, 0.0), value(369, 0.0)
        if not self.clear >= 0 <= self.floor < self.depth or self.side < 0:
            raise scene.fault(
                f"cycle {self.cycle} without its depth below 0, or with an allowance below 0",
                "check Q200, Q201, Q368 and Q369",
            )
        # Half sides and corner of the wall itself; `less` brings the tool's middle inside of it.
        wall = self._wall()
        if min(wall.a, wall.b) < self.radius + self.side - NEAR:
            raise scene.fault(
                f"the tool of cycle {self.cycle}, {self.radius:g} with Q368 {self.side:g}, does not"
                " fit in it",
                "check the tool's radius and the sizes of the pocket",
            )
        # Where the tool's middle goes: roughing stays Q368 off the wall, finishing runs along it.
        self.inside, self.way = wall.less(self.radius + self.side), wall.less(self.radius)
        self.middle, self.turn = self._placed(wall)
        self.high = self.top + max(self.clear, value(204, self.clear))
        self._down(self.high)
        self._to((0.0, 0.0))
        self._down(self.top + self.clear)

    def _wall(self) -> Rounded:
        value = self.value
        if self.cycle == CIRCLE:
            r = value(223) / 2
            return Rounded(r, r, r)
        a, b = value(218) / 2, value(219) / 2
        if self.cycle == SLOT:
            return Rounded(a, b, min(a, b))
        return Rounded(a, b, min(max(value(220, 0.0), self.radius), a, b))

    def _placed(self, wall: Rounded) -> tuple[Point, tuple[float, float]]:
        """The middle, and cosine and sine of the turn."""
        scene, value = self.scene, self.value
        angle = value(374 if self.cycle == SLOT else 224, 0.0) if self.cycle != CIRCLE else 0.0
        side = int(value(367, 0.0)) if self.cycle != CIRCLE else 0
        if side not in MIDDLE:
            raise scene.fault(f"cycle {self.cycle} with Q367 {side}", "write 0 to 4")
        away = MIDDLE[side][0] * wall.a, MIDDLE[side][1] * wall.b
        if self.cycle == SLOT:
            away = (
                {0: 0.0, 1: wall.a, 2: wall.a - wall.b, 3: wall.b - wall.a, 4: -wall.a}[side],
                0.0,
            )
        cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        x, y = away[0] * cos - away[1] * sin, away[0] * sin + away[1] * cos
        # In the pocket's own coordinates, whose zero is its middle: the place of the call.
        self.called = -away[0], -away[1]
        return (scene.at("X") + x, scene.at("Y") + y), (cos, sin)

    # -- roughing and finishing --------------------------------------------------------------------

    def rough(self) -> None:
        rings = self._rings(self.inside)
        high = self.top + self.clear
        for z in self._depths(self.depth - self.floor, abs(self.value(202))):
            self._enter(high, z)
            for ring in rings:
                self._around(ring.ring(), ring.start, self.feed(207))
            # Out of the depth by the clearance only: what lies above is cut.
            high = min(z + self.clear, high)
            self._down(high)
            self._to((0.0, 0.0))

    def finish(self) -> None:
        """The wall and the bottom, as far as something was left on them."""
        feed = self.feed(385 if 385 in self.data.data else 207)
        for z in self._depths(self.depth - self.floor, abs(self.value(338, 0.0))):
            if not self.side:
                break
            self._down(z, self.feed(206))
            self._join(feed)
        if self.floor:
            self._down(self.top - self.depth, self.feed(206))
            for ring in self._rings(self.way):
                self._around(ring.ring(), ring.start, feed)
            self._down(min(self.top - self.depth + self.clear, self.top + self.clear))
            self._to((0.0, 0.0))

    def _join(self, feed: bytes) -> None:
        """Once along the wall, joined and left on a quarter circle, and back to the middle."""
        pieces = self.way.joined(JOIN_MM / self.scene.unit)
        self._around(pieces, pieces[0].start if pieces else self.way.start, feed)
        self._to((0.0, 0.0), feed)

    def end(self) -> list[bytes]:
        """Out, and to where it was called."""
        self._down(self.high)
        if self.called != (0.0, 0.0):
            self._to(self.called)
        return self.lines.texts

    def _rings(self, shape: Rounded) -> list[Rounded]:
        factor = self.value(370, 1.0) or 1.0
        try:
            wide = min(abs(factor), 2.0) * self.radius
            return shape.rings(step_of(shape, wide, self.radius))
        except ValueError:
            raise self.scene.fault(
                f"cycle {self.cycle} takes too many ways", "check Q370"
            ) from None

    def _depths(self, total: float, step: float) -> Iterator[float]:
        if step and total / step > MOST_DEPTHS:
            raise self.scene.fault(f"cycle {self.cycle} takes too many depths", "check Q202, Q338")
        count = math.ceil(total / step - NEAR) if step > NEAR else 1
        return (
            self.top - min(k * step if step > NEAR else total, total) for k in range(1, count + 1)
        )

    def _enter(self, high: float, z: float) -> None:
        """Into a depth: straight down, on a helix, or to and fro."""
        how, feed = self.value(366, 1.0), self.feed(206)
        if how not in (0, 1, 2):
            raise self.scene.fault(f"cycle {self.cycle} with Q366 {how:g}", "write 0, 1 or 2")
        # A helix of a tenth of the tool's radius is a plunge in the middle: straight down instead.
        r, least = min(self.inside.a, self.inside.b, self.radius), 0.1 * self.radius
        if how == 1 and r > least:
            half = ((r, 0.0), (-r, 0.0)), ((-r, 0.0), (r, 0.0))
            arcs = [Arc(a, b, (0.0, 0.0), 1.0) for a, b in half]
            points = [p for arc in arcs for p in ends(self.scene, arc)]
            self._ramp(points, math.tau * r, (high, z), feed)
        elif how and self.inside.a > least:
            a = self.inside.a
            self._ramp([(-a, 0.0), (a, 0.0)], 4 * a, (high, z), feed)
        else:
            self._down(z, feed)

    def _ramp(
        self, points: list[Point], way: float, heights: tuple[float, float], feed: bytes
    ) -> None:
        """Down along ways that come back to where they began, and once more at the depth."""
        high, z = heights
        self._to(points[-1], self.feed(207))
        #  high '-.             A round goes down by `way` times the slope at most; one more at the
        #          '-.          depth takes away the ramp itself.
        #  z       ___'-.___
        rounds = math.ceil((high - z) / (way * SLOPE) - NEAR)
        count = max(rounds, 1) * len(points)
        if count > 100 * MOST_DEPTHS:
            raise self.scene.fault(f"cycle {self.cycle} takes too many depths", "check Q202, Q338")
        for k in range(1, count + 1):
            self._to(points[(k - 1) % len(points)], feed, high + (z - high) * k / count)
        for point in points:
            self._to(point, feed)

    # -- lines -------------------------------------------------------------------------------------

    def _around(self, ring: list[Piece], start: Point, feed: bytes) -> None:
        """Along pieces that run counter-clockwise, in the sense that is asked for."""
        self._to(self._sensed(start), feed)
        for point in along(self.scene, ring):
            self._to(self._sensed(point), feed)

    def _sensed(self, point: Point) -> Point:
        # Rings run counter-clockwise, which in a pocket is climb milling: mirrored they run the
        # other way.
        return point[0], point[1] * self.sense

    def _to(self, place: Point, feed: bytes = FAST, z: float | None = None) -> None:
        (cos, sin), (x, y) = self.turn, place
        to = self.middle[0] + x * cos - y * sin, self.middle[1] + x * sin + y * cos
        self.lines.to(to, z, feed)

    def _down(self, z: float, feed: bytes = FAST) -> None:
        self.lines.to(None, z, feed)
