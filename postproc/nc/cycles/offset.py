"""A lathe's shape at a distance: lines and arcs moved sideways, joined by arcs round outer corners,
cut off in inner ones."""

from __future__ import annotations

import math
from dataclasses import replace

from postproc.nc.cycles.pocket_path import DoesNotFit, Point, across, aside, with_line
from postproc.nc.cycles.profile import Element
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER

NEAR = 1e-9
LEAST_RADIUS = 1e-3  # of an arc that was moved
TOUCHING = 1e-6  # ends of arcs that near meet halfway
# rad: where a line meets an arc so flatly, a rounding decides on which of two places
NEARLY_TANGENT = 0.02
# LinuxCNC rounds an outer corner where the gap along its cuts is wider, and cuts it off else
SMALLEST_GAP = 1e-2


# Whole: the ways that two elements meet, in their order of precedence.
def offset(elements: list[Element], distance: float, side: int, along: int) -> list[Element] | None:
    """The elements `distance` to the left (`side` 1) or right (-1) of their way, (z, x); `along`: 0
    z, 1 x, the direction of the cuts. None where an element is too short to say what becomes of
    it."""
    if not distance:
        return elements
    moved: list[Element] = []
    for e in elements:
        new = moved_aside(e, distance * side)
        if new is None:
            return None
        moved.append(new)
    result = [moved[0]]
    for before, after, new in zip(elements, elements[1:], moved[1:], strict=False):
        #     .--a         |      Elements end at a, the next begin at b. Outside of a corner a gap
        #  ---+   \      --b-a    opens, which an arc about the old corner closes; inside they
        #     |    b       |      overlap, and are cut off where they meet.
        turn = across(before.piece, after.piece)
        last = result[-1]
        if (before.is_arc or after.is_arc) and math.dist(last.end, new.start) < TOUCHING:
            middle = ((last.end[0] + new.start[0]) / 2, (last.end[1] + new.start[1]) / 2)
            result[-1], new = replace(last, end=middle), replace(new, start=middle)
        elif any(
            e.is_arc and (abs(turn) < NEARLY_TANGENT or distance > _size(e) / 2)
            for e in (before, after)
        ):
            return None
        elif turn * side < 0 and abs(last.end[along] - new.start[along]) > SMALLEST_GAP:
            result.append(
                Element(COUNTER if turn > 0 else CLOCKWISE, last.end, new.start, (), before.end)
            )
        else:
            met = meeting(last, new)
            if met is None:
                return None
            result[-1], new = replace(last, end=met), replace(new, start=met)
            if not (_goes_on(result[-1], before) and _goes_on(new, after)):
                return None
        result.append(new)
    return result


def _size(arc: Element) -> float:
    return min(math.dist(arc.start, arc.end), arc.piece.radius)


def _goes_on(cut: Element, whole: Element) -> bool:
    """Whether an element still has a length, in its own direction, between its corners."""
    if whole.is_arc:
        return TOUCHING < cut.piece.sweep <= whole.piece.sweep + NEAR
    t = whole.piece.tangent(False)
    return (cut.end[0] - cut.start[0]) * t[0] + (cut.end[1] - cut.start[1]) * t[1] > TOUCHING


def moved_aside(e: Element, left: float) -> Element | None:
    """The element moved sideways; None: an arc that is too small."""
    try:
        p = aside(e.piece, left, LEAST_RADIUS)
    except DoesNotFit:
        return None
    return replace(e, start=p.start, end=p.end, words=())


def meeting(a: Element, b: Element) -> Point | None:
    """Where two moved elements meet; None: nowhere, or of two arcs. A line that misses an arc by a
    rounding touches it."""
    straight = not a.is_arc and not b.is_arc
    if (a.is_arc and b.is_arc) or (straight and abs(across(a.piece, b.piece)) < NEAR):
        return None
    return min(with_line(a.piece, b.piece, True), key=lambda p: math.dist(p, b.start))
