"""A written program on a machine whose axes have real lost motion, laid against the path of the
nominal program.

Written from the contract (section Meaning), to judge the product: it imports nothing of it. Every
axis has a play operator on its commanded slide position, over all motions of the written program in
the order of execution:

    y = clip(y, c - W/2, c + W/2),     s = (c - y) / (W/2)

c is the command and y the nut; s runs from -1 (it came from above) over 0 (unknown) to +1 (it
came from below). W is the lost motion B = reverse - forward of the axis' own positioning there, or
the way of a pre-travel if that is longer. Every component of the axis, its positioning and what
else was measured in two directions, is

    (forward + reverse) / 2 + s (forward - reverse) / 2,

so that without pre-travel the slide stands at y + (forward + reverse) / 2. Where W is 0, s is the
sign of the last commanded motion. Before the first known position nothing is known: there y = c.

The program's motions are assigned to the nominal motions as in `evaluate`, by where the tool really
is. Counted are

- feeds and arcs: the distance of every sample from the path of the nominal motion, by its length;
  and the distance of the last end from the end point;
- take-ups (a short piece at which the nominal motion does not advance): their end alone, without a
  length;
- rapids, and motions whose start is unknown: their end point alone, without a length.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from .evaluate import KINDS, Judge, Misaligned, check_lengths
from .interpreter import run
from .machine import ROTATIONS, TRANSLATIONS, UM, UNIT, rotation

# mm; a piece up to this, or 1.2 times the play in every axis, can be a take-up
SHORTEST_TAKE_UP = 0.02
NEWTON = 6  # steps; the foot of a point on an arc converges by (distance / radius) a step
NEVER = 1e3  # mm: the distance of a point from a motion whose ends are unknown


@dataclass
class Followed:
    """What came out. Distances in mm; weights: mm of path that each of `distances` stands for."""

    largest_mm: float = 0.0  # over samples, ends of take-ups, end points of motions and of rapids
    where: tuple | None = None  # (nominal line, output line, what it is) of largest_mm
    distances: np.ndarray = field(default_factory=lambda: np.zeros(0))
    weights: np.ndarray = field(default_factory=lambda: np.zeros(0))
    take_ups: int = 0
    nominal_motions: int = 0
    output_motions: int = 0
    unmeasured: list = field(default_factory=list)  # nominal lines whose end is unknown

    @property
    def rms(self):
        total = self.weights.sum()
        return math.sqrt(float((self.weights * self.distances**2).sum() / total)) if total else 0.0

    def quantile(self, part):
        """mm that `part` of the path's length does not exceed."""
        return weighted_quantile(self.distances, self.weights, part)

    def share(self, bound):
        """How much of the path's length lies within `bound` mm."""
        total = self.weights.sum()
        return float(self.weights[self.distances <= bound].sum() / total) if total else 1.0


def weighted_quantile(values, weights, part):
    if not weights.sum():
        return 0.0
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order][min(np.searchsorted(reached, part * reached[-1]), len(values) - 1)])


# The slide ----------------------------------------------------------------------------------------


def side_of_play(command, width):
    """s of one axis: (n,) commanded positions (nan = unknown) and play, mm -> (n,) in -1..+1."""
    side = np.zeros(len(command))
    nut, before, sign = math.nan, math.nan, 0.0
    for k, (c, half) in enumerate(zip(command.tolist(), (width / 2).tolist())):
        if math.isnan(c) or math.isnan(before):
            nut, sign = c, 0.0
        elif c != before:
            sign = 1.0 if c > before else -1.0
        nut, before = min(max(nut, c - half), c + half), c
        side[k] = (c - nut) / half if half > 0.0 else sign
    return side


def table(axis, name, positions):
    """(forward, reverse) of a component at positions, mm or rad; held past the ends."""
    zero = np.zeros_like(positions)
    if name not in axis.components:
        return zero, zero
    return tuple(np.interp(positions, axis.nodes, column) for column in axis.components[name])


def play_of(axis, positions):
    """(n,) mm: the commanded way in which the side changes. A map in which forward lies beyond
    reverse is no play: a control that takes up too much does so at once when its command turns
    round."""
    forward, reverse = table(axis, axis.name, positions)
    return np.maximum(np.maximum(reverse - forward, 0.0), axis.play_mm)


def widest_play(machine):
    """mm, of all axes."""
    return max(float(play_of(axis, np.array(axis.nodes)).max()) for axis in machine.axes.values())


# The machine --------------------------------------------------------------------------------------


def turned(vectors, angles):
    """(n, 3) turned about (n, 3) rad: Rodrigues, exact."""
    angle = np.linalg.norm(angles, axis=1)[:, None]
    once = np.cross(angles, vectors)
    half = np.sinc(angle / (2 * np.pi))
    return vectors + np.sinc(angle / np.pi) * once + 0.5 * half**2 * np.cross(angles, once)


def tool_points(machine, command, side):
    """(n, 3) mm: the actual tool point; command, side: (n, axes), in the order of machine.axes."""
    point = np.tile(machine.tool, (len(command), 1))
    for k, axis in reversed(list(enumerate(machine.axes.values()))):
        s, value = side[:, k], {}
        for name in (*TRANSLATIONS, *ROTATIONS):
            forward, reverse = table(axis, name, command[:, k])
            value[name] = (forward + reverse) / 2 + s * (forward - reverse) / 2
        shift = np.stack([value[name] for name in TRANSLATIONS], axis=1)
        angles = np.stack([value[name] for name in ROTATIONS], axis=1)
        way = command[:, k, None] * (rotation(axis.lean)[:3, :3] @ UNIT[axis.name])
        if axis.side == "workpiece":
            point = point + way
        point = axis.measured_at + shift + turned(point - axis.measured_at, angles)
        if axis.side == "tool":
            point = point + way
    return point


# The paths ----------------------------------------------------------------------------------------


def places(block, axes, t):
    """(n, axes) mm: positions of a motion with known ends at t in [0, 1]."""
    start, end = (np.array([point[axis] for axis in axes]) for point in (block.start, block.end))
    place = start + np.outer(t, end - start)
    if block.kind == "arc":
        angle, radius = polar(block, t)
        for axis, centre, unit in zip(
            block.plane_axes, block.centre, (np.cos(angle), np.sin(angle))
        ):
            place[:, axes.index(axis)] = centre + radius * unit
    # to the digit: where an axis has no play the last of its ways, however short, says its side
    place[t == 0.0], place[t == 1.0] = start, end
    return place


def polar(block, t):
    (angle, first), (_, last) = block.polar(0), block.polar(1)
    return angle + block.sweep * t, first + (last - first) * t


def slopes(block, axes, t):
    """(n, axes) mm: derivative of `places`."""
    slope = np.tile([block.end[axis] - block.start[axis] for axis in axes], (len(t), 1))
    if block.kind == "arc":
        angle, radius = polar(block, t)
        growth = block.polar(1)[1] - block.polar(0)[1]
        for axis, unit, normal in zip(
            block.plane_axes, (np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))
        ):
            slope[:, axes.index(axis)] = growth * unit + radius * block.sweep * normal
    return slope


def turns_at(block):
    """t at which an axis of an arc's plane turns back."""
    if block.kind != "arc" or not block.sweep:
        return []
    angle = block.polar(0)[0]
    low, high = sorted((angle, angle + block.sweep))
    quarters = range(math.ceil(low / (math.pi / 2)), math.floor(high / (math.pi / 2)) + 1)
    return [min(max((k * math.pi / 2 - angle) / block.sweep, 0.0), 1.0) for k in quarters]


def foot(block, axes, points):
    """((n,) t, (n,) mm): the nearest point of a motion's path, and its distance."""
    slope = slopes(block, axes, np.zeros(1))[0]
    if block.kind != "arc":
        square = float(slope @ slope)
        start = np.array([block.start[axis] for axis in axes])
        t = (
            np.clip((points - start) @ slope / square, 0.0, 1.0)
            if square
            else np.zeros(len(points))
        )
        return t, np.linalg.norm(places(block, axes, t) - points, axis=1)
    u, v = (
        points[:, axes.index(axis)] - centre for axis, centre in zip(block.plane_axes, block.centre)
    )
    turn = 2 * math.pi / abs(block.sweep)
    first = (np.arctan2(v, u) - block.polar(0)[0]) / block.sweep % turn - turn
    best, least = np.zeros(len(points)), np.full(len(points), np.inf)
    for k in range(math.floor(1.0 / turn) + 3):
        t = np.clip(first + k * turn, 0.0, 1.0)
        for _ in range(NEWTON):
            slope = slopes(block, axes, t)
            miss = places(block, axes, t) - points
            t = np.clip(t - (miss * slope).sum(axis=1) / (slope * slope).sum(axis=1), 0.0, 1.0)
        distance = np.linalg.norm(places(block, axes, t) - points, axis=1)
        best, least = np.where(distance < least, t, best), np.minimum(distance, least)
    return best, least


# The written program ------------------------------------------------------------------------------


class Execution:
    """The written program as it is lived: samples of all its motions in the order of execution.

    part[j] is the slice of the samples of motion j, whose last is its end; unknown positions are
    nan.
    """

    def __init__(self, blocks, machine, density):
        self.axes, self.machine = list(machine.axes), machine
        rows, self.part, self.t, begin = [], [], [], 0
        for block in blocks:
            t = self._grid(block, density)
            rows.append(places(block, self.axes, t) if block.known else self._end(block))
            self.t.append(t)
            self.part.append(slice(begin, begin + len(t)))
            begin += len(t)
        self.command = np.concatenate(rows) if rows else np.zeros((0, len(self.axes)))
        self.side = np.empty_like(self.command)
        for k, axis in enumerate(machine.axes.values()):
            self.side[:, k] = side_of_play(self.command[:, k], play_of(axis, self.command[:, k]))
        columns = [int(np.argmax(UNIT[axis])) for axis in self.axes]
        self.actual = (tool_points(machine, self.command, self.side) - machine.tool)[:, columns]

    def _grid(self, block, density):
        if not block.known:
            return np.ones(1)
        steps = max(math.ceil(block.length * density), 6) if block.length else 1
        return np.unique(
            [*(np.arange(1, steps + 1) / steps), *(t for t in turns_at(block) if t > 0.0)]
        )

    def _end(self, block):
        return np.array(
            [[math.nan if block.end[axis] is None else block.end[axis] for axis in self.axes]]
        )


class Follower(Judge):
    """The alignment of `evaluate`, by where the tool really is."""

    def __init__(self, machine, outputs, density, near, take_up):
        super().__init__(machine, density, True, take_up, near)
        self.execution = Execution(outputs, machine, density)
        self.number = {id(block): j for j, block in enumerate(outputs)}
        part = self.execution.part
        self.ends = (
            self.execution.actual[[piece.stop - 1 for piece in part]]
            if part
            else np.zeros((0, len(self.axes)))
        )
        middle = [(piece.start + piece.stop - 1) // 2 for piece in part]
        self.middles = self.execution.actual[middle] if part else self.ends
        self.cache = {}

    def distances(self, motion):
        """(2, outputs) mm: of the ends and the middles of all outputs from the path of a motion."""
        if id(motion) not in self.cache:
            both = [
                foot(motion.block, self.axes, np.nan_to_num(points, nan=NEVER))[1]
                for points in (self.ends, self.middles)
            ]
            self.cache[id(motion)] = np.array(both)
        return self.cache[id(motion)]

    def end_miss(self, motion, block):
        """mm between the ends; None when they lie too far apart."""
        ends = [(block.end[axis], motion.block.end[axis]) for axis in self.axes]
        if any((a is None) != (b is None) for a, b in ends):
            return None
        if max((abs(a - b) for a, b in ends if a is not None), default=0.0) > self.near:
            return None
        if not motion.end_known:
            return math.hypot(*(a - b for a, b in ends if a is not None))
        return float(np.linalg.norm(self.ends[self.number[id(block)]] - [b for _, b in ends]))

    def price(self, motion, block):
        """As in `evaluate`: what it costs to call a block a piece of a motion, mm²; None when it
        cannot be one."""
        short = block.kind in ("rapid", "feed") and block.known and block.length <= self.take_up
        if block.kind not in KINDS[motion.block.kind] and not (
            short and motion.block.kind != "machine"
        ):
            return None
        if not motion.known:
            return self.closing(motion, block)
        if None in block.end.values():
            return None
        end, middle = self.distances(motion)[:, self.number[id(block)]]
        if motion.block.kind == "rapid" or not block.known:
            middle = 0.0
        return None if max(end, middle) > 2 * self.near else float(end**2 + middle**2)

    # What counts ----------------------------------------------------------------------------------

    def judge(self, motion, pieces, report):
        """Count one nominal motion: [(distances, weights)]."""
        counted = []

        def largest(distances, line, what):
            k = int(np.argmax(distances))
            if report.where is None or distances[k] > report.largest_mm:
                report.largest_mm, report.where = (
                    float(distances[k]),
                    (motion.block.line, line, what),
                )

        if motion.known and motion.block.kind != "rapid":
            t = 0.0
            for block in pieces:
                part = self.execution.part[self.number[id(block)]]
                feet, distances = foot(motion.block, self.axes, self.execution.actual[part])
                advance = (feet[-1] - t) * motion.length
                if (
                    len(pieces) > 1
                    and block.length <= self.take_up
                    and abs(advance) <= block.length / 2
                ):
                    report.take_ups += 1
                    largest(distances[-1:], block.line, "the end of a take-up")
                    continue
                t = feet[-1]
                largest(distances, block.line, "on the path")
                counted.append(
                    (
                        distances,
                        block.length
                        * np.diff(self.execution.t[self.number[id(block)]], prepend=0.0),
                    )
                )
        end = np.array([motion.block.end[axis] for axis in self.axes])
        reached = self.ends[self.number[id(pieces[-1])]]
        largest(np.linalg.norm(reached - end, keepdims=True), pieces[-1].line, "the end point")
        return counted


def follow(
    nominal_text,
    written_text,
    dialect,
    machine,
    *,
    density=2.0,
    diameter=None,
    offsets=None,
    start={},
    take_up_mm=None,
    near_mm=None,
):
    """Followed: a written program on a machine with lost motion; Misaligned when it does not do
    what the nominal one does.

    density: samples per mm of path. The tables are held past their ends. near_mm: how far an end
    may lie from the nominal end in any axis (default: the machine's max_correction). take_up_mm:
    the longest piece that can be a take-up (default: 1.2 times the widest play in every axis at
    once, at least SHORTEST_TAKE_UP).
    """
    longest = 1.2 * math.sqrt(len(machine.axes)) * widest_play(machine) + 2 * UM
    take_up = max(longest, SHORTEST_TAKE_UP) if take_up_mm is None else take_up_mm
    settings = dict(
        axes=list(machine.axes),
        diameter=machine.diameter if diameter is None else diameter,
        offsets=machine.offsets if offsets is None else offsets,
        start=start,
    )
    nominal, output = (run(text, dialect, **settings) for text in (nominal_text, written_text))
    near = machine.max_correction if near_mm is None else near_mm
    plain = Judge(machine, density, True, take_up, near)
    motions = plain.nominal(nominal)
    outputs, marks = plain.motions(output)
    if marks != plain.motions(nominal)[1]:
        raise Misaligned("blocks that do not move are not the same in both programs")
    follower = Follower(machine, [block for block, _ in outputs], density, near, take_up)
    report = Followed(nominal_motions=len(motions), output_motions=len(outputs))
    counted = []
    for motion, pieces in zip(motions, follower.align(motions, outputs) if outputs else []):
        if not pieces and not motion.empty:
            raise Misaligned(f"nominal line {motion.block.line} has no motion in the output")
        check_lengths(motion, pieces, follower)
        if not motion.end_known and motion.block.kind != "machine":
            report.unmeasured.append(motion.block.line)
        if pieces and motion.end_known:
            counted += follower.judge(motion, pieces, report)
    if counted:
        report.distances, report.weights = (np.concatenate(column) for column in zip(*counted))
    return report
