"""Arcs about a pole, of Heidenhain's Klartext and DIN/ISO, as the ends of straight lines.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, "Path contours": start and end may lie 0.016
mm unlike far from the pole (MP7431); an end at the start is a full circle; R above 0 is the shorter
arc, below 0 the longer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from postproc.nc.cycles.pocket_path import Piece
from postproc.nc.cycles.scene import Scene

MISMATCH_MM = 0.016
NEAR = 1e-9
MOST_LINES = 100_000
Point = tuple[float, float]


class Arc(NamedTuple):
    """From `at` to `to` about `centre`, in the program's unit; `turn`: 1 against the clock, -1 with
    it; `sweep`: radians, None where the ends say it."""

    at: Point
    to: Point
    centre: Point
    turn: float
    sweep: float | None = None


def centre_of(start: Point, end: Point, radius: float, turn: float) -> Point:
    """The centre of the arc of this radius, counter-clockwise where `turn` is above 0: the shorter
    one, with a radius below 0 the longer. One too small for its chord is half of that."""
    #        centre        away^2 = R^2 - (chord / 2)^2. i (b - a) points to the left of the chord:
    #       R / |           the shorter arc has its centre there if it runs against the clock, the
    #        /  | away      longer one if it runs with it
    #       a---+---b
    a, b = complex(*start), complex(*end)
    length = abs(b - a)
    away = math.sqrt(max(radius * radius - length * length / 4, 0.0))
    side = 1 if (turn > 0) == (radius > 0) else -1
    centre = (a + b) / 2 + side * away * 1j * (b - a) / length
    return centre.real, centre.imag


def by_radius(
    scene: Scene, at: Point, to: Point, radius: float, turn: float, name: str = "R"
) -> Arc:
    """The arc of this radius, which the program has behind `name`. Raises ProgramError where there
    is none."""
    length = math.dist(at, to)
    if length < NEAR or (length / 2 - abs(radius)) * scene.unit > MISMATCH_MM:
        address = name.rstrip("=")
        raise scene.fault(
            f"{name}{radius:g} makes no arc to a place {length:.4g} away",
            f"check {address} and the end",
        )
    return Arc(at, to, centre_of(at, to, radius, turn), turn)


def along(scene: Scene, pieces: Iterable[Piece]) -> list[Point]:
    """The ends of lines along lines and arcs. Raises ProgramError."""
    found: list[Point] = []
    for p in pieces:
        arc = Arc(p.start, p.end, p.centre, float(p.turn))
        found += ends(scene, arc) if p.turn else [p.end]
    return found


def ends(scene: Scene, arc: Arc) -> list[Point]:
    """The ends of lines of equal angles that leave the arc by the scene's chord at most. Raises
    ProgramError where start and end lie too unlike far from the pole."""
    centre = arc.centre
    arms = [(p[0] - centre[0], p[1] - centre[1]) for p in (arc.at, arc.to)]
    radii = [math.hypot(*arm) for arm in arms]
    if min(radii) < NEAR or abs(radii[0] - radii[1]) * scene.unit > MISMATCH_MM:
        raise scene.fault(
            f"start and end lie {radii[0]:.4f} and {radii[1]:.4f} from the pole",
            "the control refuses more than 0.016 mm between them: check the pole",
        )
    begin, sweep = math.atan2(arms[0][1], arms[0][0]), arc.sweep
    if sweep is None:
        sweep = (math.atan2(arms[1][1], arms[1][0]) - begin) * arc.turn % math.tau
        sweep = math.tau if math.dist(arc.at, arc.to) < NEAR or sweep < NEAR else sweep
    # The chord of an angle 2 h leaves its arc by r (1 - cos h) in the middle. Four chords at least
    # are a circle: of two the direction of the cut would be lost.
    flat = max(1.0 - scene.chord / max(radii), math.cos(math.pi / 4))
    count = max(1, math.ceil(sweep / (2 * math.acos(flat))))
    if count > MOST_LINES:
        raise scene.fault(f"the arc would take {count:,} lines", "a larger --tolerance")
    places = []
    for k in range(1, count):
        # ends unlike far from the pole: the control lets the radius grow with the angle
        angle = begin + arc.turn * sweep * k / count
        radius = radii[0] + (radii[1] - radii[0]) * k / count
        places.append((centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)))
    return [*places, arc.to]
