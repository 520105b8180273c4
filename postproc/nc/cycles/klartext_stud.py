"""Studs of Heidenhain Klartext, cycles 256 (rectangular) and 257 (circular), written out as L.

HEIDENHAIN TNC 640 (34059x-01), TNC 620, TNC 320, Cycle Programming, "Rectangular stud (cycle 256)",
"Circular stud (cycle 257)": from the middle the tool goes along X beside the unmachined stud (Q424
by Q425; 257: Q222 across, in the direction Q376), 2 mm away; from the set-up clearance Q200 above
the surface Q203 it plunges by Q202 at Q206, goes on a semicircle that touches the side to the stud
(Q218 by Q219, corners of Q220; 257: Q223 across; Q368 left over), once around it at Q207, "if the
finished dimension cannot be machined with one revolution, performs a stepover with the current
factor" (Q370 times the tool's radius) and goes around again, and on a semicircle back to where it
plunged, down to the depth Q201. At the end it is drawn out to the second clearance Q204 where that
is higher, and stays there beside the stud. Q224 turns the stud about the place of the call, Q367
says which place of the stud that is. Q351 +1 is climb milling (with M3 with the clock), -1 up-cut.

The 2 mm lie between the blank and the tool's edge. Revolutions share out evenly what is to go; from
one to the next the tool steps where it has come around. 257 goes on a spiral on the control: here
around and in, beside the same stud. Refused: another approach (Q437), no Q351, a spindle that does
not turn by M3.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from postproc.nc.cycles.klartext_bore import Tool
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_lines import Lines
from postproc.nc.cycles.pole_arc import Arc, Point, along, ends
from postproc.nc.cycles.rounded import Rounded
from postproc.nc.cycles.scene import Scene

RECTANGLE, CIRCLE = 256, 257
STUDS = (RECTANGLE, CIRCLE)
BESIDE_MM = 2.0
MOST_DEPTHS, MOST_TURNS = 10_000, 1_000
NEAR = 1e-9
# the middle of the stud from the place of the call, in half sides, by Q367
MIDDLE = {0: (0, 0), 1: (1, 1), 2: (-1, 1), 3: (-1, -1), 4: (1, -1)}
Value = Callable[..., float]


def stud(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """The cycle where the tool stands. Raises ProgramError."""
    cycle, value = data.cycle, data.value
    way = _path(scene, tool, cycle, value)
    depths = _depths(scene, cycle, value)
    top, clear = value(203), value(200)
    high = top + max(clear, value(204, clear))
    place = _placed(scene, cycle, value)

    lines = Lines(scene)
    lines.to(None, high)
    lines.to(place(way[-1]), None)
    lines.to(None, top + clear)
    for depth in depths:
        lines.anew(None, top - depth, data.feed(206))
        lines.anew(place(way[0]), None, data.feed(207))
        for point in way[1:]:
            lines.to(place(point), None, lines.fed)
    lines.to(None, high)
    return lines.texts


def _path(scene: Scene, tool: Tool, cycle: int, value: Value) -> list[Point]:
    """The ends of the lines of the revolutions at one depth about a stud whose middle is zero, from
    the start and back to it."""
    if value(437, 0.0):
        raise scene.fault("cycle 256 with Q437, another approach", "write Q437=+0, or the way as L")
    way = value(351, 0.0)
    tool.check_sense(cycle, way)
    return _turns(scene, tool, cycle, value, way)


# Whole: one line of arithmetic to a size; round and square differ in each.
def _turns(scene: Scene, tool: Tool, cycle: int, value: Value, way: float) -> list[Point]:
    """The revolutions that take what stands beyond the finished sizes, from outside inwards. Raises
    ProgramError where the sizes do not fit each other."""
    radius, left = tool.radius(cycle), value(368, 0.0)
    numbers = ((223, 223), (222, 222)) if cycle == CIRCLE else ((218, 219), (424, 425))
    a, b = (value(n) / 2 + left + radius for n in numbers[0])
    outside = [value(n) / 2 + radius for n in numbers[1]]
    # What stands beyond the finished sizes on each side, shared out evenly over the revolutions:
    # the last one goes around the finished stud.
    more = [max(o - side, 0.0) for o, side in zip(outside, (a, b), strict=True)]
    step = radius * (value(370, 1.0) or 1.0)
    corner = a if cycle == CIRCLE else value(220, 0.0) + left + radius
    start = outside[0] + BESIDE_MM / scene.unit
    fits = min(a, b) >= corner - NEAR and start > a and step > NEAR
    if not fits or max(more) / step > MOST_TURNS:
        sizes = "Q222 and Q223" if cycle == CIRCLE else "Q218 to Q425"
        raise scene.fault(
            f"the sizes of cycle {cycle} do not fit each other", f"check {sizes}, and Q370"
        )
    count = max(math.ceil(max(more) / step - NEAR), 1)
    wider = [[m * (count - k) / count for m in more] for k in range(1, count + 1)]
    grows = 1.0 if cycle == CIRCLE else 0.0  # its corners are its sides
    turns = [((a + x, b + y), corner + grows * x) for x, y in wider]
    return _revolutions(scene, turns, start, way)


def _revolutions(
    scene: Scene, turns: list[tuple[tuple[float, float], float]], start: float, way: float
) -> list[Point]:
    """From the start around, once for each pair of half sides and their corner, and back; with the
    clock where way is 1."""

    #    .---->----.             From the start s on a semicircle to the right side, around with the
    #    |  stud   |  .-<-.      clock, and back on another: both touch the way around, so that the
    #    |         |  v    \     tool leaves no mark where it comes on.
    #    '----<----'   '->--s
    def across(first: float, last: float) -> list[Point]:
        middle = ((first + last) / 2, 0.0)
        return ends(scene, Arc((first, 0.0), (last, 0.0), middle, 1.0, math.pi))

    found = across(start, turns[0][0][0])
    for sides, corner in turns:
        found += [(sides[0], 0.0), *_around(scene, sides, corner)]
    found += across(turns[-1][0][0], start)
    if way < 0:
        # Up-cut: the picture mirrored about X, which turns every sense round.
        found = [(x, -y) for x, y in found]
    return [
        p for p, q in zip(found, [(start, 0.0), *found], strict=False) if math.dist(p, q) > NEAR
    ]


def _around(scene: Scene, sides: tuple[float, float], corner: float) -> list[Point]:
    """Once, with the clock, from the middle of the right side and back to it."""
    return [(x, -y) for x, y in along(scene, Rounded(*sides, corner).ring())]


def _depths(scene: Scene, cycle: int, value: Value) -> list[float]:
    """Below the surface."""
    depth, step = -value(201), abs(value(202))
    if depth <= 0 or step < NEAR or depth / step > MOST_DEPTHS:
        raise scene.fault(
            f"cycle {cycle} without its depth below 0 or its plunges", "check Q201, Q202"
        )
    count = math.ceil(depth / step - NEAR)
    return [min(k * step, depth) for k in range(1, count + 1)]


def _placed(scene: Scene, cycle: int, value: Value) -> Callable[[Point], Point]:
    """From the stud's own coordinates to the program's."""
    call, round_ = (scene.at("X"), scene.at("Y")), cycle == CIRCLE
    turn = math.radians(max(value(376, 0.0), 0.0) if round_ else value(224, 0.0))
    side = MIDDLE[0] if round_ else MIDDLE.get(int(value(367, 0.0)))
    if side is None:
        raise scene.fault(f"cycle 256 with Q367 {value(367):g}", "write 0 to 4")
    away = (0.0, 0.0) if round_ else (side[0] * value(218) / 2, side[1] * value(219) / 2)
    cos, sin = math.cos(turn), math.sin(turn)

    def place(point: Point) -> Point:
        x, y = point[0] + away[0], point[1] + away[1]
        return call[0] + x * cos - y * sin, call[1] + x * sin + y * cos

    return place
