"""Patterns of points of Heidenhain Klartext, cycles 220 and 221, and pecking as in old controls,
cycle 1.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, cycle programming, "Polar pattern", "Linear
pattern": where it is defined, the cycle that was defined last is made at every point, with Q200,
Q203 and Q204 of the pattern. First the tool axis goes to the second clearance; between the points
it stays at the set-up clearance (Q301 0) or at the second one (1). 220: Q241 points about Q216 Q217
on the circle of Q244, from Q245 by Q247, or all around where Q247 is 0. 221: Q242 columns, Q237
apart, in Q243 lines, Q238 apart, from Q225 Q226, every second line backwards, turned by Q224 about
the first point. Behind the last point the tool is drawn back to the second clearance.

TNC 426, TNC 407 user's manuals, "Pecking (cycle 1)": from where the tool stands, which is 1.1 above
the surface, pecks of 1.3 down to 1.2 at 1.5, each drawn out to the beginning and back to 0.6 mm
above what is drilled (from 30 mm on a fiftieth of the depth, 7 mm at most), 1.4 seconds at the
bottom.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from postproc.nc.cycles.scene import Scene

POLAR, PECKING = 220, 1
NUMBER = re.compile(rb"([-+]?[0-9]*\.?[0-9]+)[ \t]*\Z")
MOST = 10_000
NEAR = 1e-9
Value = Callable[..., float]  # of a datum by its number, with a default


def points(scene: Scene, cycle: int, value: Value) -> list[tuple[float, float]]:
    """The places of a pattern, in their order. Raises ProgramError."""
    count = value(241) if cycle == POLAR else value(242) * value(243)
    if not 1 <= count <= MOST or count % 1:
        raise scene.fault(f"{count:g} points in cycle {cycle}", "check how many it makes")
    return _polar(scene, value) if cycle == POLAR else _linear(value)


def _polar(scene: Scene, value: Value) -> list[tuple[float, float]]:
    count, step, begin = int(value(241)), value(247), value(245)
    # With Q247 0 the points lie 360 / n apart, all the way round; a part of the circle is refused.
    around = abs(value(246) - begin)
    if abs(step) < NEAR and count > 1:
        if abs(around - 360) > NEAR:
            raise scene.fault("cycle 220 on a part of a circle by Q246", "write its step as Q247")
        step = math.copysign(360 / count, value(246) - begin)
    if value(365, 0.0):
        raise scene.fault("cycle 220 with Q365, along the circle", "write Q365=+0: straight on")
    radius, x, y = value(244) / 2, value(216), value(217)
    angles = [math.radians(begin + k * step) for k in range(count)]
    return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]


def _linear(value: Value) -> list[tuple[float, float]]:
    #  9  8  7    to and fro: the shortest way; Q237 from column to column, Q238 from line to
    #  4  5  6    line, all of it turned by Q224 about point 1 (Q225 Q226)
    #  3  2  1
    turn, found = math.radians(value(224, 0.0)), []
    for line in range(int(value(243))):
        columns = range(int(value(242)))
        for column in columns if line % 2 == 0 else reversed(columns):
            a, b = column * value(237), line * value(238)
            x = value(225) + a * math.cos(turn) - b * math.sin(turn)
            found.append((x, value(226) + a * math.sin(turn) + b * math.cos(turn)))
    return found


def pecks(scene: Scene, data: dict[int, float]) -> list[tuple[float, bool]]:
    """Cycle 1: each place of the tool axis, and whether it goes there at the feed. `data`: 1.1 to
    1.5 by the number behind the point. Raises ProgramError."""
    if not {1, 2, 3, 5} <= set(data) or data[2] >= 0 or not data[3]:
        raise scene.fault(
            "cycle 1 without its depth below 0, its pecks or its feed", "write 1.1 to 1.5"
        )
    top, depth, step = scene.at("Z"), -data[2], abs(data[3])
    if depth / step > MOST:
        raise scene.fault("cycle 1 with too many pecks", "check 1.2 and 1.3")
    unit = scene.unit
    deep = depth * unit
    # 0.6 mm and 30 mm are millimetres in inch programs too.
    stop = (0.6 if deep <= 30 else min(deep / 50, 7.0)) / unit
    surface, reached, found = top - abs(data[1]), 0.0, []
    while reached < depth - NEAR:
        if reached:
            found += [(top, False), (min(surface - reached + stop, top), False)]
        reached = min(reached + step, depth)
        found.append((surface - reached, True))
    return found
