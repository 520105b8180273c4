"""Face milling of Heidenhain Klartext, cycle 232, written out as L.

HEIDENHAIN TNC 640 (34059x-01), Cycle Programming, "Face milling (cycle 232)", page 236:
beside the surface, the tool's radius and Q357 from its edge, at the second clearance Q204 above
Q227, down at Q253 to the first depth; along the first axis at Q207 to a place as far outside of the
other edge. Q389 0: over to the next line at Q253 and back; 2: up by Q200, at Q253 to where the next
line begins, down again, and on in the same direction. The lines lie Q370 times the tool's radius
apart at most, all alike; the depths, Q202 at most, share out what Q369 leaves of the way from Q227
to Q386. "The surface is then machined in reverse direction" at the next depth; the last one, at
Q385, takes Q369. At the end FMAX to the second clearance. The signs of Q218 and Q219 say to which
side of Q225 Q226 the surface lies.

That page has strategies 1 and 2; the ends of 0 are those that 2 and cycle 233 (9/2015, page 175)
have. Edges and depths are those of the manual. How far the first line lies within the edge it
leaves open: here the strips of the lines share out the width. All of it lies in one plane. Refused:
Q389 1 (where its lines end within the surface is not certain).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from postproc.nc.cycles.klartext_bore import Tool
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_lines import Lines
from postproc.nc.cycles.pole_arc import Point
from postproc.nc.cycles.scene import Scene

FACE = 232
TO_AND_FRO, ONE_WAY = 0, 2
MOST_DEPTHS, MOST_LINES = 1_000, 10_000
NEAR = 1e-6


def face(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """The cycle; its surface does not depend on where the tool stands. Raises ProgramError."""
    value, kind = data.value, data.value(389, float(ONE_WAY))
    if kind not in (TO_AND_FRO, ONE_WAY):
        raise scene.fault(
            f"cycle 232 with Q389 {kind:g}",
            "write Q389=+0 or Q389=+2, whose lines end outside of the surface, or the ways as L",
        )
    rows = _rows(scene, data, tool.radius(FACE))
    high = value(227) + max(value(200), value(204, 0.0))
    above, between = (scene.known("Z") or high) > high, data.feed(253)
    lines = Lines(scene)
    if not above:
        lines.to(None, high)
    lines.to(rows[0][0], None)
    if above:
        lines.to(None, high)
    for z, feed in _depths(scene, data):
        for k, (start, end) in enumerate(rows):
            if k and kind == ONE_WAY:
                lines.to(None, z + value(200), between)
            if k:
                lines.to(start, None, between)
            if not k or kind == ONE_WAY:
                lines.to(None, z, between)
            lines.to(end, None, feed)
        # The next depth runs the other way: it begins where this one has ended.
        rows = [(end, start) for start, end in reversed(rows)]
    lines.to(None, high)
    return lines.texts


def _rows(scene: Scene, data: Holes, radius: float) -> list[tuple[Point, Point]]:
    """From and to where the tool's middle goes, of the first depth."""
    value = data.value
    long, wide = value(218), value(219)
    step = radius * min(value(370, 1.0) or 1.0, 2.0)
    if step <= NEAR or not long or not wide or abs(wide) / step > MOST_LINES:
        raise scene.fault(
            "cycle 232 without the sizes of its surface, or with too many lines",
            "check Q218, Q219, Q370 and the tool's radius",
        )
    count = max(math.ceil(abs(wide) / step - NEAR), 1)
    out = math.copysign(radius + value(357, 0.0), long)
    x, y = value(225), value(226)
    ends = (x - out, x + long + out)
    # The middles of strips of equal width: the tool, wider than a strip, reaches over both edges.
    rows = [y + wide * (k + 0.5) / count for k in range(count)]
    #  Q389 2  o---------->    All lines end beside the surface, by the tool's radius and Q357; from
    #          o---------->    one to the next the tool goes up and back (2), or over at the edge
    #  Q389 0  o----------.    (0).
    #          .----------'
    if value(389, float(ONE_WAY)) == ONE_WAY:
        return [((ends[0], row), (ends[1], row)) for row in rows]
    return [((ends[k % 2], row), (ends[1 - k % 2], row)) for k, row in enumerate(rows)]


# Whole: refusals first, then one line of arithmetic to a figure.
def _depths(scene: Scene, data: Holes) -> Iterator[tuple[float, bytes]]:
    """Each with its feed."""
    value = data.value
    top, floor, step = value(227), value(369, 0.0), abs(value(202))
    total = top - value(386) - floor
    if total < 0 or floor < 0 or value(200) < 0 or value(357, 0.0) < 0:
        raise scene.fault(
            "cycle 232 with Q386 above Q227, or an allowance or clearance below 0",
            "check Q227, Q386, Q369, Q200 and Q357",
        )
    if step <= NEAR < total or (step and total / step > MOST_DEPTHS):
        raise scene.fault("cycle 232 takes too many depths", "check Q202")
    #  Q227  - - - - - -    `count` depths, all alike, down to Q369 above the floor, then Q369 in
    #  Q202  -----------    one cut of its own; where Q369 is all there is, that cut alone.
    #        -----------
    #  Q386  ===========
    count = max(math.ceil(total / step - NEAR), 0 if floor else 1) if step else 0
    depths = [top - total * k / count for k in range(1, count + 1)]
    depths += [top - total - floor] if floor or not depths else []
    last = data.feed(385 if 385 in data.data else 207)
    return ((z, last if z == depths[-1] else data.feed(207)) for z in depths)
