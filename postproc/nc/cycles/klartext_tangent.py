"""CT of Heidenhain Klartext: the arc that goes on along the element before it.

HEIDENHAIN TNC 640, TNC 620, iTNC 530 user's manuals, Klartext programming, "Circular path CT with
tangential connection": the arc begins at the end of the line or arc before, along it, and ends at
the place that it names. The element before stands directly before it.
"""

from __future__ import annotations

import math
import re

from postproc.nc.cycles.pole_arc import Arc, Point
from postproc.nc.cycles.scene import Scene

PLACE = re.compile(rb"(?<![A-Z])(I?)([XY])[ \t]*([-+]?[0-9]*\.?[0-9]+)")
MOVED = re.compile(rb"(?<![A-Z])M[ \t]*0*(?:9[12]|140)(?![0-9])")
NEAR = 1e-9
KNOWN = "write two lines with X and Y before it, or the arc as CR"


class Heading:
    """The way of the last path in XY, as far as its own words say it."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.here: dict[bytes, float] = {}
        self.way: Point | None = None

    def lose(self) -> None:
        """Something else went by."""
        self.here, self.way = {}, None

    def line(self, code: bytes) -> None:
        """A straight line."""
        if MOVED.search(code):
            self.lose()
            return
        before, moves = dict(self.here), False
        for step, axis, value in PLACE.findall(code):
            moves = True
            if step and axis not in before:
                self.here.pop(axis, None)
            else:
                self.here[axis] = float(value) + (before[axis] if step else 0.0)
        if not moves:
            return
        self.way = None
        if len(before) == 2 and len(self.here) == 2:
            self.way = self.here[b"X"] - before[b"X"], self.here[b"Y"] - before[b"Y"]

    def arc(self, arc: Arc) -> None:
        """An arc in XY: the way at its end."""
        arm = arc.to[0] - arc.centre[0], arc.to[1] - arc.centre[1]
        self.way = -arc.turn * arm[1], arc.turn * arm[0]
        self.here = {b"X": arc.to[0], b"Y": arc.to[1]}

    def tangent(self, at: Point, to: Point) -> Arc:
        """CT. Raises ProgramError."""
        if self.way is None or math.hypot(*self.way) < NEAR:
            raise self.scene.fault("CT, and the way of the element before is not known", KNOWN)
        chord = to[0] - at[0], to[1] - at[1]
        length = math.hypot(*chord)
        if length < NEAR:
            raise self.scene.fault("CT that ends where it begins", "check its end")
        #       to         Between the way and the chord lies half of the arc's sweep, so the chord
        #     . /          is 2 R sin(angle) (Euclid III.32). The centre stands square to the way,
        #    . / angle     on the side to which the chord lies.
        #   at----> way
        way = self.way[0] / math.hypot(*self.way), self.way[1] / math.hypot(*self.way)
        across = way[0] * chord[1] - way[1] * chord[0]
        if abs(across) < NEAR * length:
            raise self.scene.fault("CT straight on or back", "write L, or check its end")
        turn = 1.0 if across > 0 else -1.0
        angle = math.atan2(abs(across), way[0] * chord[0] + way[1] * chord[1])
        radius = length / 2 / math.sin(angle)
        centre = at[0] - turn * radius * way[1], at[1] + turn * radius * way[0]
        return Arc(at, to, centre, turn, 2 * angle)
