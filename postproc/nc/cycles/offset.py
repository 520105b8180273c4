"""A lathe's shape at a distance: lines and arcs moved sideways, joined by arcs round outer corners,
cut off in inner ones."""

from __future__ import annotations

import math
from dataclasses import replace

from postproc.nc.cycles.profile import Element
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER

NEAR = 1e-9
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
        turn = _cross(tangent(before, True), tangent(after, False))
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
            corner = meeting(last, new)
            if corner is None:
                return None
            result[-1], new = replace(last, end=corner), replace(new, start=corner)
            if not (_goes_on(result[-1], before) and _goes_on(new, after)):
                return None
        result.append(new)
    return result


def _size(arc: Element) -> float:
    return min(math.dist(arc.start, arc.end), math.dist(arc.start, arc.centre))


def _goes_on(cut: Element, whole: Element) -> bool:
    """Whether an element still has a length, in its own direction, between its corners."""
    if whole.is_arc:
        return TOUCHING < _sweep(cut) <= _sweep(whole) + NEAR
    t = tangent(whole, False)
    return (cut.end[0] - cut.start[0]) * t[0] + (cut.end[1] - cut.start[1]) * t[1] > TOUCHING


def _sweep(e: Element) -> float:
    """The angle of an arc, rad."""
    a, b = (math.atan2(p[1] - e.centre[1], p[0] - e.centre[0]) for p in (e.start, e.end))
    return (b - a if e.code == COUNTER else a - b) % math.tau


def _cross(a: tuple[float, float], b: tuple[float, float]) -> float:
    return a[0] * b[1] - a[1] * b[0]


def tangent(e: Element, at_end: bool) -> tuple[float, float]:
    """The direction of travel, length 1."""
    if not e.is_arc:
        v = e.end[0] - e.start[0], e.end[1] - e.start[1]
    else:
        p = e.end if at_end else e.start
        arm = p[0] - e.centre[0], p[1] - e.centre[1]
        v = (-arm[1], arm[0]) if e.code == COUNTER else (arm[1], -arm[0])
    size = math.hypot(*v)
    return v[0] / size, v[1] / size


def moved_aside(e: Element, left: float) -> Element | None:
    if not e.is_arc:
        t = tangent(e, False)
        return e.moved((-t[1] * left, t[0] * left))
    radius = math.dist(e.start, e.centre)
    new = radius - left * (1 if e.code == COUNTER else -1)
    if new <= 1e-3:
        return None
    scale = new / radius
    ends = [
        (e.centre[0] + (p[0] - e.centre[0]) * scale, e.centre[1] + (p[1] - e.centre[1]) * scale)
        for p in (e.start, e.end)
    ]
    return replace(e, start=ends[0], end=ends[1], words=())


def meeting(a: Element, b: Element) -> tuple[float, float] | None:
    """Where two moved elements meet; None: nowhere, or of two arcs. A line that misses an arc by a
    rounding touches it."""
    if a.is_arc and b.is_arc:
        return None
    if not a.is_arc and not b.is_arc:
        s, t = tangent(a, True), tangent(b, False)
        if abs(_cross(s, t)) < NEAR:
            return None
        k = _cross((b.start[0] - a.end[0], b.start[1] - a.end[1]), t) / _cross(s, t)
        return a.end[0] + k * s[0], a.end[1] + k * s[1]
    line, arc = (b, a) if a.is_arc else (a, b)
    t = tangent(line, False)
    to = arc.centre[0] - line.start[0], arc.centre[1] - line.start[1]
    foot = to[0] * t[0] + to[1] * t[1]
    beside = _cross(t, to)
    half = math.sqrt(max(math.dist(arc.end, arc.centre) ** 2 - beside**2, 0.0))
    places = [
        (line.start[0] + k * t[0], line.start[1] + k * t[1]) for k in (foot - half, foot + half)
    ]
    return min(places, key=lambda p: math.dist(p, b.start))
