r"""The way of the tool's centre that LinuxCNC makes of a contour under G41 G42, with its rules of
gouging.

A follower of its own, block by block: an outside corner is an arc around the corner, an inside
corner the place where the shifted blocks meet, and a bend of less than CORNER is none. A block is
kept in a queue until the next one that moves in the plane says where it ends, as in the control, so
that blocks along the tool between two of the contour end there too.

    outside: around             inside: meet

                                     |  ||          --   way of the centre
    --------c.                       |  ||          ==   contour
    ========op \                 ----+..c|          op   corner, as programmed
            ||  |                =======op          c    where the centre's block would end, beside
            ||  |                                        op, did the next one not say otherwise

Source: LinuxCNC, src/emc/rs274ngc/interp_convert.cc (convert_straight_comp1 and 2,
convert_arc_comp2), interp_queue.cc (move_endpoint_and_flush); the names of angles are theirs.
"""

from __future__ import annotations

from dataclasses import field
from math import acos, asin, atan2, cos, hypot, pi, sin, tan

import numpy as np

from postproc.records import mutable, replace

CORNER = 0.05  # rad: TOLERANCE_CONCAVE_CORNER
LONGER = 0.0254  # rad: by how much an arc may grow, as measured: 0.022 is accepted, 0.036 refused
AGAINST = 0.002  # mm: what rounding makes
LEFT, RIGHT = 1, -1
GOUGE = "cannot be reached by the tool without gouging"
Point = tuple[float, float]


class Gouge(Exception):
    """The control refuses the contour; the sentence is LinuxCNC's."""


@mutable
class Way:
    """A straight way or an arc of the centre. owner: the motion that it belongs to; start, end
    (A,): mm; plane: rows of the two axes; centre: mm in the plane, turns and sweep: rad, signed, of
    an arc, else 0; direction: of the contour's block,
    and programmed: rad, size of the sweep of its arc;
    measured: for those who read it."""

    owner: int
    start: np.ndarray
    end: np.ndarray
    plane: tuple[int, int]
    centre: Point | None = None
    turns: int = 0
    direction: Point = (0.0, 0.0)
    rapid: bool = False
    sweep: float = 0.0
    programmed: float = 0.0
    measured: bool = False


@mutable
class Block:
    """A motion of the contour: its number, its end (A,) mm, whether it is a rapid, and an arc's
    centre and turns: + for counter-clockwise, more than 1 for more than a turn."""

    owner: int
    end: np.ndarray
    rapid: bool = False
    centre: Point | None = None
    turns: int = 0


@mutable
class Shifted:
    """Follows a contour with a tool. plane: rows of its axes; radius: mm; side: LEFT or RIGHT;
    nose: mm in the plane from the centre to the point that the control drives. `done`: ways that
    will not change any more; backwards: whether one ran against its block."""

    plane: tuple[int, int]
    radius: float
    side: int
    nose: Point = (0.0, 0.0)
    done: list[Way] = field(default_factory=list)
    queue: list[Way] = field(default_factory=list)
    programmed: Point = (0.0, 0.0)
    current: Point = (0.0, 0.0)
    at: np.ndarray = field(default_factory=lambda: np.zeros(0))
    driven: np.ndarray = field(default_factory=lambda: np.zeros(0))
    endpoint: Point | None = None
    backwards: bool = False

    def enter(self, start: np.ndarray, block: Block) -> None:
        """The first block: from where the tool stands to beside its end."""
        # with a way in of at most the radius the centre could not come from there to beside the end
        c, p = self._in_plane(start), self._in_plane(block.end)
        if hypot(p[0] - c[0], p[1] - c[1]) <= self.radius:
            raise Gouge(
                "Length of cutter compensation entry move is not greater than the tool radius"
            )
        self.at = self.driven = start.copy()
        alpha = atan2(p[1] - c[1], p[0] - c[0]) + self.side * pi / 2
        end = self._beside(p, alpha)
        self.endpoint = c
        self._enqueue(block, end, (p[0] - c[0], p[1] - c[1]))
        self.programmed, self.current = p, end

    def follow(self, block: Block) -> None:
        """Any other block. Raises Gouge."""
        if block.centre is not None:
            self._arc(block)
        else:
            self._straight(block)

    def leave(self, block: Block) -> None:
        """The first block behind G40: to its end, whether it names both axes of the plane or not.
        Raises Gouge: what waits must reach its own end (convert_cutter_compensation_off)."""
        # What waits has no next block to say otherwise: it ends beside its own end, and the way out
        # begins there.
        self._move_end(self.current)
        self.nose = (0.0, 0.0)
        self._enqueue(block, self._in_plane(block.end), (0.0, 0.0))
        self.flush()

    def flush(self) -> None:
        """What stands in the queue is sure now."""
        for way in self.queue:
            # now only: the end of the way before may have been moved
            way.start = self.at
            if way.centre is not None:
                way.sweep = self._sweep(way)
            self._look_back(way)
            self.at = way.end
            self._drive(way)
            self.done.append(way)
        self.queue, self.endpoint = [], None

    def _look_back(self, way: Way) -> None:
        """Note a straight way that runs against its block: LinuxCNC does not refuse it, but it cuts
        where nobody meant to."""
        first, second = self.plane
        # direction is the block's own way, not of length 1, and so is what the product is compared
        # with
        way_back = way.direction[0] * (way.end[first] - way.start[first]) + way.direction[1] * (
            way.end[second] - way.start[second]
        )
        self.backwards |= way_back < -AGAINST * hypot(*way.direction)

    def _drive(self, way: Way) -> None:
        """From the centre of the nose to the point that the control drives; the way in begins with
        that point."""
        way.start, way.end = self.driven, way.end.copy()
        for k, row in enumerate(self.plane):
            way.end[row] += self.nose[k]
        if way.centre is not None:
            way.centre = way.centre[0] + self.nose[0], way.centre[1] + self.nose[1]
        self.driven = way.end

    # -- straight blocks ---------------------------------------------------------------------------

    def _straight(self, block: Block) -> None:
        """A straight block: how the way before it goes on is told by the turn between both."""
        p, op, c = self._in_plane(block.end), self.programmed, self.current
        if p == op:
            self._enqueue(block, c, (0.0, 0.0))
            return
        # theta: from the corner op to the centre c beside it, at right angles to the way before;
        # alpha: the heading of this block. Straight on theta is alpha + side * 90 degrees, and beta
        # is 0.
        theta, alpha = atan2(c[1] - op[1], c[0] - op[0]), atan2(p[1] - op[1], p[0] - op[0])
        beta = self.side * (theta - alpha) % (2 * pi) - pi / 2
        gamma = self.side * pi / 2
        end, mid = self._beside(p, alpha + gamma), self._beside(op, alpha + gamma)
        front = self.queue[0] if self.queue else None
        over = (
            beta > pi - CORNER
            and front is not None
            and front.centre is not None
            and front.turns * self.side < 0
        )
        # beta: the turn of the heading, + away from the tool:
        #     -pi/2 .. 0       about 0          0 .. pi            beyond pi
        #     inside: meet     straight on      outside: around    inside, by more than 90 degrees
        if beta < -CORNER or beta > pi + CORNER or over:
            self._move_end(self._meet(p, theta, beta))
        elif beta > CORNER:
            self._move_end(c)
            self._around(block, op, mid)
        else:
            self.flush()
            self.endpoint = c
        self._enqueue(block, end, (p[0] - op[0], p[1] - op[1]))
        self.programmed, self.current = p, end

    def _meet(self, p: Point, theta: float, beta: float) -> Point:
        """Where the way before and a straight one towards p meet."""
        front = self.queue[0] if self.queue else None
        r = self.radius
        op = self.programmed
        c = self.current
        if front is None or front.centre is None:
            # The shifted lines cross `back` before c, on the way that led there (theta + gamma
            # leads against it): of the angle pi + beta between the blocks at the corner half has r
            # / back as its tangent. At a right angle beta is -pi / 2, and back is r.
            half = (beta + pi) / 2
            if half == 0.0:
                raise Gouge("Zero degree inside corner is invalid for cutter compensation")
            back, gamma = r / tan(half), self.side * pi / 2
            return c[0] + back * cos(theta + gamma), c[1] + back * sin(theta + gamma)
        old = hypot(
            front.centre[1] - self._in_plane(front.end)[1],
            front.centre[0] - self._in_plane(front.end)[0],
        )
        inside = front.turns * self.side > 0
        sense = 1 if front.turns > 0 else -1
        theta = atan2(p[1] - op[1], p[0] - op[0]) + sense * pi / 2
        phi = atan2(front.centre[1] - op[1], front.centre[0] - op[0])
        # The corner lies on the contour's circle, whose radius is that of the centre's one, `old`,
        # with the tool's; d is how far the new line lies from the circle's centre. Its shifted line
        # lies r nearer or farther, and that over `old` is the cosine of the angle at which both
        # meet.
        d = (old + r if inside else old - r) * cos(theta - phi)
        cosine = (d - r if inside else d + r) / old
        if not -1.0 <= cosine <= 1.0:
            raise Gouge(
                "Arc to straight motion makes a corner the compensated tool can't fit in without"
                " gouging"
            )
        angle = theta + pi + (-sense if inside else sense) * acos(cosine)
        return front.centre[0] + old * cos(angle), front.centre[1] + old * sin(angle)

    # -- arcs --------------------------------------------------------------------------------------

    # Whole: LinuxCNC's own function, kept in its order to be compared with it.
    def _arc(self, block: Block) -> None:
        """The same of an arc, by its heading where it begins."""
        assert block.centre is not None
        p, op, c, m = self._in_plane(block.end), self.programmed, self.current, block.centre
        sense = 1 if block.turns > 0 else -1
        # inside: the tool runs on the side of the arc's centre, and its own arc is the smaller one.
        # Here theta is the heading before; delta leads from the corner to the arc's centre, and
        # with delta - sense * 90 degrees the arc sets out.
        inside, radius = sense * self.side > 0, hypot(m[0] - p[0], m[1] - p[1])
        theta = atan2(c[1] - op[1], c[0] - op[0]) - self.side * pi / 2
        delta = atan2(m[1] - op[1], m[0] - op[0])
        beta = self.side * (theta - (delta - sense * pi / 2))
        beta = beta - 2 * pi if beta > 1.5 * pi else beta + 2 * pi if beta < -pi / 2 else beta
        if inside and radius <= self.radius:
            raise Gouge("Tool radius not less than arc radius with comp")
        gamma = atan2(m[1] - p[1], m[0] - p[0]) + (0.0 if inside else pi)
        end = self._beside(p, gamma)  # on the radius through the arc's end
        if beta < -CORNER or beta > pi + CORNER or (abs(beta - pi) < CORNER and not inside):
            front = self.queue[0] if self.queue else None
            met = (
                self._meet_arc
                if front is not None and front.centre is not None
                else self._meet_line
            )
            self._move_end(met(block, theta, beta, radius, inside))
        elif beta > CORNER:
            self.flush()
            self._around(block, op, self._beside(op, delta if inside else delta + pi))
        else:
            self.flush()
            self.endpoint = c
        self._enqueue(block, end, (0.0, 0.0), m, block.turns)
        self.programmed, self.current = p, end

    def _meet_line(
        self, block: Block, theta: float, beta: float, radius: float, inside: bool
    ) -> Point:
        """Where a straight way before and an arc meet."""
        assert block.centre is not None
        sense, r = 1 if block.turns > 0 else -1, self.radius
        # Inside: seen from the arc's centre the line before passes `away` towards the tool's side
        # and its shifted one `across`. On the circle of the tool's centre, of radius `distance`,
        # that is the sine of the angle from the line's heading. Outside all is turned round.
        away = radius * sin(beta - pi / 2)
        across, distance = (away + r, radius - r) if inside else (away - r, radius + r)
        if distance == 0.0 or not -1.0 <= across / distance <= 1.0:
            raise Gouge(f"Arc move in concave corner {GOUGE}")
        turn = asin(across / distance)
        angle = theta + sense * turn if inside else theta + pi - sense * turn
        return block.centre[0] + distance * cos(angle), block.centre[1] + distance * sin(angle)

    def _meet_arc(
        self, block: Block, theta: float, beta: float, radius: float, inside: bool
    ) -> Point:
        """Where the arc before and an arc meet."""
        front = self.queue[0]
        assert block.centre is not None and front.centre is not None
        end, m, f = self._in_plane(front.end), block.centre, front.centre
        old = hypot(f[1] - end[1], f[0] - end[0])
        new = radius - self.radius if inside else radius + self.radius
        apart = hypot(f[1] - m[1], f[0] - m[0])
        if old == 0 or apart == 0:
            raise Gouge("Arc to arc motion is invalid because the arcs have the same center")
        # Law of cosines in the triangle of both centres and the place where the shifted circles
        # meet: a is the cosine at the first centre, between the way to the other one and to that
        # place.
        a = (old**2 + apart**2 - new**2) / (2 * old * apart)
        if not -1.0 <= a <= 1.0:
            raise Gouge(
                "Arc to arc motion makes a corner the compensated tool can't fit in without gouging"
            )
        sense = 1 if block.turns > 0 else -1
        within = front.turns * self.side > 0
        angle = atan2(m[1] - f[1], m[0] - f[0]) + (sense if within else -sense) * acos(a)
        return f[0] + old * cos(angle), f[1] + old * sin(angle)

    # -- the queue ---------------------------------------------------------------------------------

    def _around(self, block: Block, corner: Point, end: Point) -> None:
        """An arc around an outside corner; a rapid cuts it."""
        # along the tool the arc around the corner stays where the block before ends
        height = replace(block, end=self.queue[-1].end if self.queue else self.at)
        if block.rapid:
            self._enqueue(height, end, (0.0, 0.0))
        else:
            self._enqueue(height, end, (0.0, 0.0), corner, -self.side)
        self.flush()
        self.endpoint = end

    def _enqueue(
        self,
        block: Block,
        end: Point,
        direction: Point,
        centre: Point | None = None,
        turns: int = 0,
    ) -> None:
        target = block.end.copy()
        target[list(self.plane)] = end
        way = Way(block.owner, self.at, target, self.plane, centre, turns, direction, block.rapid)
        if block.centre is not None:
            # what the contour's arc turns: the centre's may turn by LONGER more (_check_arc)
            way.programmed = abs(
                _sweep(self.programmed, self._in_plane(block.end), block.centre, block.turns)
            )
        self.queue.append(way)

    def _move_end(self, place: Point) -> None:
        """All that waits ends at another place (move_endpoint_and_flush)."""
        for way in self.queue:
            if way.centre is not None:
                self._check_arc(way, place)
            elif self.endpoint is not None:
                dot = way.direction[0] * (place[0] - self.endpoint[0]) + way.direction[1] * (
                    place[1] - self.endpoint[1]
                )
                if dot < 0:
                    raise Gouge(
                        f"Straight {'traverse' if way.rapid else 'feed'} in concave corner {GOUGE}"
                    )
            way.end = way.end.copy()
            way.end[list(self.plane)] = place
        waited = bool(self.queue)
        self.flush()
        if waited:
            self.endpoint = place

    def _check_arc(self, way: Way, place: Point) -> None:
        assert way.centre is not None
        moved = way.end.copy()
        moved[list(self.plane)] = place
        if not way.programmed or self.endpoint is None:
            return
        if abs(self._sweep(replace(way, start=self.at, end=moved))) > way.programmed + LONGER:
            raise Gouge(f"Arc move in concave corner {GOUGE}")

    def _sweep(self, way: Way) -> float:
        """rad of an arc from where it starts to where it ends."""
        assert way.centre is not None
        return _sweep(self._in_plane(way.start), self._in_plane(way.end), way.centre, way.turns)

    def _in_plane(self, point: np.ndarray) -> Point:
        return float(point[self.plane[0]]), float(point[self.plane[1]])

    def _beside(self, point: Point, angle: float) -> Point:
        return point[0] + self.radius * cos(angle), point[1] + self.radius * sin(angle)


def _sweep(start: Point, end: Point, centre: Point, turns: int) -> float:
    """rad, signed, of an arc."""
    turn = atan2(end[1] - centre[1], end[0] - centre[0]) - atan2(
        start[1] - centre[1], start[0] - centre[0]
    )
    sense = 1 if turns > 0 else -1
    turn = sense * turn % (2 * pi)
    # an end at the start is a full circle, never nothing
    if turn < 1e-9:
        turn = 2 * pi
    return sense * (turn + 2 * pi * (abs(turns) - 1))
