"""The rectangular stud of Heidenhain Klartext, cycle 256, written out as L.

HEIDENHAIN TNC 640 (34059x-01), TNC 620, TNC 320, Cycle Programming, "Rectangular stud (cycle 256)":
from the middle the tool goes along X beside the unmachined stud (Q424 by Q425), 2 mm away; from the
set-up clearance Q200 above the surface Q203 it plunges by Q202 at Q206, goes on a semicircle that
touches the side to the stud (Q218 by Q219, corners of Q220, Q368 left over), once around it at
Q207, and on a semicircle back to where it plunged, down to the depth Q201. At the end it is drawn
out to the second clearance Q204 where that is higher, and stays there beside the stud. Q224 turns
the stud about the place of the call, Q367 says which place of the stud that is. Q351 +1 is climb
milling (with M3 with the clock), -1 up-cut.

The 2 mm lie between the blank and the tool's edge. Refused: a blank that takes more than one
revolution (wider by more than the radius times Q370 a side: how the tool steps between them is not
in the manual), another approach (Q437), no Q351, a spindle that does not turn by M3.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from postproc.nc.cycles.klartext_bore import Tool
from postproc.nc.cycles.klartext_holes import signed
from postproc.nc.cycles.pole_arc import Arc, Point, ends
from postproc.nc.cycles.scene import Scene

CYCLE = 256
BESIDE_MM = 2.0
MOST_DEPTHS = 10_000
NEAR = 1e-9
# the middle of the stud from the place of the call, in half sides, by Q367
MIDDLE = {0: (0, 0), 1: (1, 1), 2: (-1, 1), 3: (-1, -1), 4: (1, -1)}
WRITE = "let the CAM program write this stud out as L"
Value = Callable[..., float]


def stud(scene: Scene, tool: Tool, value: Value, feed: Callable[[int], bytes]) -> list[bytes]:
    """The cycle where the tool stands; `value`, `feed`: its data by number. Raises ProgramError."""
    way = _path(scene, tool, value)
    depths = _depths(scene, value)
    top, clear = value(203), value(200)
    high = top + max(clear, value(204, clear))
    place = _placed(scene, value)

    def to(point: Point, end: bytes = b"") -> bytes:
        words = [signed(scene, axis, v) for axis, v in zip("XY", place(point), strict=True)]
        return b"L " + b" ".join(words) + end

    def down(z: float, end: bytes) -> bytes:
        return b"L " + signed(scene, "Z", z) + end

    start = way[-1]
    lines = [down(high, b" FMAX"), to(start, b" FMAX"), down(top + clear, b" FMAX")]
    for depth in depths:
        lines.append(down(top - depth, feed(206)))
        lines += [to(point, b"" if k else feed(207)) for k, point in enumerate(way)]
    return [*lines, down(high, b" FMAX")]


def _path(scene: Scene, tool: Tool, value: Value) -> list[Point]:
    """The ends of the lines of one revolution about a stud whose middle is zero, from the start and
    back to it."""
    if value(437, 0.0):
        raise scene.fault("cycle 256 with Q437, another approach", "write Q437=+0, or the way as L")
    way = value(351, 0.0)
    if way not in (1.0, -1.0):
        raise scene.fault(
            "cycle 256 without Q351, the way that it turns",
            "write Q351=+1 for climb milling, Q351=-1 for up-cut",
        )
    if tool.turn != 1:
        raise scene.fault("cycle 256 where the spindle does not turn by M3", "write M3 before it")
    radius, left = tool.radius(CYCLE), value(368, 0.0)
    a, b = (value(n) / 2 + left + radius for n in (218, 219))
    outside = [value(n) / 2 + radius for n in (424, 425)]
    more = max(o - side for o, side in zip(outside, (a, b), strict=True))
    if more > radius * value(370, 1.0) + NEAR:
        raise scene.fault(
            f"the blank of cycle 256 is {more:g} wider a side than its stud, and one revolution"
            f" takes {radius * value(370, 1.0):g}",
            WRITE,
        )
    corner, start = value(220, 0.0) + left + radius, outside[0] + BESIDE_MM / _unit(scene)
    if min(a, b) < corner - NEAR or start <= a:
        raise scene.fault("the sizes of cycle 256 do not fit each other", "check Q218 to Q425")
    return _revolution(scene, (a, b), corner, start, way)


def _revolution(
    scene: Scene, sides: tuple[float, float], corner: float, start: float, way: float
) -> list[Point]:
    """Around with the clock where way is 1."""
    a, b = sides
    middle = ((start + a) / 2, 0.0)
    found = ends(scene, Arc((start, 0.0), (a, 0.0), middle, 1.0, math.pi))
    for x, y in ((1, -1), (-1, -1), (-1, 1), (1, 1)):
        centre = x * (a - corner), y * (b - corner)
        first, last = (x * a, centre[1]), (centre[0], y * b)
        if x * y > 0:
            first, last = last, first
        found += [first, *ends(scene, Arc(first, last, centre, -1.0))]
    found += [(a, 0.0), *ends(scene, Arc((a, 0.0), (start, 0.0), middle, 1.0, math.pi))]
    if way < 0:
        found = [(x, -y) for x, y in found]
    return [
        p for p, q in zip(found, [(start, 0.0), *found], strict=False) if math.dist(p, q) > NEAR
    ]


def _depths(scene: Scene, value: Value) -> list[float]:
    """Below the surface."""
    depth, step = -value(201), abs(value(202))
    if depth <= 0 or step < NEAR or depth / step > MOST_DEPTHS:
        raise scene.fault("cycle 256 without its depth below 0 or its plunges", "check Q201, Q202")
    count = math.ceil(depth / step - NEAR)
    return [min(k * step, depth) for k in range(1, count + 1)]


def _placed(scene: Scene, value: Value) -> Callable[[Point], Point]:
    """From the stud's own coordinates to the program's."""
    call, turn = (scene.at("X"), scene.at("Y")), math.radians(value(224, 0.0))
    side = MIDDLE.get(int(value(367, 0.0)))
    if side is None:
        raise scene.fault(f"cycle 256 with Q367 {value(367):g}", "write 0 to 4")
    away = side[0] * value(218) / 2, side[1] * value(219) / 2
    cos, sin = math.cos(turn), math.sin(turn)

    def place(point: Point) -> Point:
        x, y = point[0] + away[0], point[1] + away[1]
        return call[0] + x * cos - y * sin, call[1] + x * sin + y * cos

    return place


def _unit(scene: Scene) -> float:
    return 25.4 if scene.inch else 1.0
