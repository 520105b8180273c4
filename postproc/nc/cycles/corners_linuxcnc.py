"""Corners in the shape of LinuxCNC's G70 to G72: A rounds the corner at the end of its block with
this radius, C cuts it off between the same two places.

src/emc/rs274ngc/interp_g7x.cc of LinuxCNC 2.9 (corner_finish): both elements are moved aside by the
size; where they meet then is the centre, and the places nearest to it on the elements are the ends
of the corner. On which side, it finds by trying; a corner in which both sides would do, and one
between two arcs, is refused here. A corner at the end of the last block is none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from postproc.nc.cycles.offset import SMALLEST_GAP, TOUCHING, meeting, moved_aside
from postproc.nc.cycles.pocket_path import across
from postproc.nc.cycles.profile import Element, Point
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene

LINE = 10
WRITE = "write the corner as a block of its own"


class Finish(NamedTuple):
    """`letter` A or C, and its size."""

    letter: str
    size: float


def finished(
    scene: Scene, elements: list[Element], corners: Mapping[int, Finish], along: int
) -> list[Element]:
    """The shape with its corners, each at the end of the block (`Element.row`) that has it;
    `along`: 0 for cuts along z, 1 along x. Raises ProgramError."""
    #    before
    #   --------a - - +       c: where both elements meet once they are moved aside by the size
    #           :  .  :       a, b: the places nearest to it on them, where the corner begins and
    #           c - - b       ends
    #                 |       A is the arc from a to b about c, C the line from a to b
    #                 |after
    back = elements[-1].end[along] <= elements[0].end[along]
    result = [elements[0]]
    for after in elements[1:]:
        finish = corners.get(result[-1].row)
        if finish is None or after.row == result[-1].row:
            result.append(after)
            continue
        before = result.pop()
        centre = _centre(scene, before, after, finish, along, 1 if back else -1)
        ends = _nearest(before, centre), _nearest(after, centre)
        if not (_within(before, ends[0]) and _within(after, ends[1])):
            raise _refused(scene, finish, "it is longer than an element beside it")
        before, after = replace(before, end=ends[0]), replace(after, start=ends[1])
        code = LINE
        if finish.letter == "A":
            code = COUNTER if across(before.piece, after.piece) > 0 else CLOCKWISE
        result += [before, Element(code, ends[0], ends[1], (), centre, before.row), after]
    return result


def _centre(
    scene: Scene, before: Element, after: Element, finish: Finish, along: int, sense: int
) -> Point:
    """Of the corner's arc."""
    sides = []
    for side in (finish.size, -finish.size):
        pair = moved_aside(before, side), moved_aside(after, side)
        if pair[0] is None or pair[1] is None:
            raise _refused(scene, finish, "an arc beside it is smaller")
        # on the inner side of a corner the moved elements overlap, on the outer one a gap opens
        if (pair[0].end[along] - pair[1].start[along]) * sense <= SMALLEST_GAP:
            sides.append((pair[0], pair[1]))
    place = meeting(*sides[0]) if len(sides) == 1 else None
    if place is None:
        raise _refused(scene, finish, "on which side LinuxCNC puts it is not certain")
    return place


def _refused(scene: Scene, finish: Finish, why: str) -> Exception:
    return scene.fault(f"{finish.letter}{finish.size:g} in a corner of the shape: {why}", WRITE)


def _nearest(e: Element, centre: Point) -> Point:
    """The place on an element that is nearest to a centre."""
    if e.is_arc:
        # On the ray from its own centre through the corner's: both circles touch there.
        share = math.dist(e.start, e.centre) / math.dist(centre, e.centre)
        return (
            e.centre[0] + (centre[0] - e.centre[0]) * share,
            e.centre[1] + (centre[1] - e.centre[1]) * share,
        )
    t = e.piece.tangent(False)
    way = (centre[0] - e.start[0]) * t[0] + (centre[1] - e.start[1]) * t[1]
    return e.start[0] + way * t[0], e.start[1] + way * t[1]


def _within(e: Element, place: Point) -> bool:
    """Whether a place on the line or circle of an element lies on it."""
    if not e.is_arc:
        way = math.dist(e.start, place) + math.dist(place, e.end)
        return way - math.dist(e.start, e.end) < TOUCHING
    sign = 1 if e.code == COUNTER else -1
    # Angles of start, place and end about the arc's centre, counted in its own sense from the
    # start.
    first, here, last = (
        math.atan2(p[1] - e.centre[1], p[0] - e.centre[0]) for p in (e.start, place, e.end)
    )
    return (sign * (here - first)) % math.tau <= (sign * (last - first)) % math.tau
