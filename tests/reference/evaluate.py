"""What is left: a program and its compensated form, run on the reference machine and laid against
the nominal path.

Both texts are run by the reference interpreter. Every motion of the compensated program is assigned
to the nominal motion that it belongs to (dynamic programming on the actual end points), then
sampled, carried through the machine, and its distance from the nominal path is the residual. Of a
component that was measured in two directions holds the one in which its slide was last commanded,
in the program that is laid against the path, its take-ups included; a slide that turns back by no
more than the machine's hysteresis (and an increment, to which its words were rounded) keeps its
side, and before it has moved, or when it comes from an unknown place, the mean holds. Counted are

- feeds and arcs: samples between the ends, the ends of all pieces, and the distance of the last end
  from the end point;
- take-ups (a short piece at which the nominal motion does not advance): their end alone;
- rapids, and motions whose start is unknown: their end point alone;
- G53, G28, G30: nothing, they are only matched; and nothing where a machine axis is unknown.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from .interpreter import run
from .machine import UNIT
from .motion import GOLDEN, Motion, Slide

BEHIND = 1e-4  # mm, what a short piece behind the end of a motion is taken to be farther off
CAME = 2e-3  # mm from the end of a motion, where a piece came to it
KINDS = {"rapid": ("rapid",), "feed": ("feed",), "arc": ("arc", "feed"), "machine": ("machine",)}


class Misaligned(AssertionError):
    """The compensated program does not do what the nominal one does; says where."""


@dataclass
class BlockResult:
    """One nominal motion: where it came out."""

    line: int
    kind: str
    output_lines: list
    largest_mm: float = 0.0  # over all that counts
    path_mm: float = 0.0  # distance from the path alone
    end_mm: float | None = None  # distance of the last end from the end point
    take_ups: int = 0
    samples: int = 0
    where: tuple | None = None  # (output line, {axis: commanded mm}) of largest_mm


@dataclass
class Report:
    """The residual of a program."""

    largest_mm: float
    where: tuple | None  # (nominal line, output line, {axis: commanded mm})
    uncompensated_mm: float  # the same measure of the nominal program as it is
    uncompensated_where: tuple | None
    by_block: list
    end_points: list  # (nominal line, nominal (3,), actual (3,)), tool point, mm
    nominal_motions: int = 0
    output_motions: int = 0
    take_ups: int = 0
    unmeasured: list = field(default_factory=list)  # nominal lines with unknown coordinates
    # (nominal line, output line, nominal feed, output feed)
    feed_changes: list = field(default_factory=list)
    outside_travel: list = field(default_factory=list)  # (output line, axis, mm)


class Judge:
    """The machine and the settings of one judgement."""

    def __init__(self, machine, samples_per_mm, clamp, take_up, near):
        self.machine, self.axes = machine, list(machine.axes)
        self.per_mm, self.clamp, self.take_up, self.near = samples_per_mm, clamp, take_up, near
        self.columns = [int(np.argmax(UNIT[axis])) for axis in self.axes]
        self.sides = {}  # of the blocks of `execute`

    def motions(self, blocks):
        """The blocks that move, each with the number of other events before it; and those
        events."""
        marks, moving = [], []
        for block in blocks:
            if block.kind in KINDS:
                moving.append((block, len(marks)))
            elif block.kind == "dwell":
                marks.append(("dwell", block.dwell))
            else:
                marks.extend(block.codes)
        return moving, marks

    def nominal(self, blocks):
        """[Motion] of a nominal program."""
        return [Motion(block, self.axes, marks) for block, marks in self.motions(blocks)[0]]

    def execute(self, blocks):
        """A whole program in its order: from now on `approach` knows its blocks."""
        slides = [
            Slide(axis, self.machine.hysteresis + self.machine.axes[axis].least_increment)
            for axis in self.axes
        ]
        for block, _ in self.motions(blocks)[0]:
            self.sides[id(block)] = {slide.axis: slide.along(block) for slide in slides}

    def approach(self, block, t=1.0):
        """{axis: the direction that holds at t of an executed block}."""
        return {
            axis: next(side for begin, side in reversed(changes) if begin <= t)
            for axis, changes in self.sides[id(block)].items()
        }

    def actual(self, block, t=1.0, margin=0.0, clamp=None):
        """(n,) mm: the actual point at t of a block, in the machine's axes, tool taken off, to be
        laid against slides."""
        clamp = self.clamp if clamp is None else clamp
        command = block.end if t == 1.0 else block.point(t)
        point = (
            self.machine.actual(command, self.approach(block, t), clamp=clamp, margin=margin)
            - self.machine.tool
        )
        return point[self.columns]

    # Alignment ------------------------------------------------------------------------------------

    def align(self, motions, outputs):
        """For each nominal motion the output blocks that belong to it.

        Least sum of squares of what the pieces (end and middle) are off the nominal path and their
        last end off the end point, among the assignments in order in which every last end lies
        within `near` of the end point, no motion is left out (but one that goes nowhere), and the
        events between the motions stay in their place.
        """
        states, trail = {-1: 0.0}, []
        for j, (block, marks) in enumerate(outputs):
            new, back = {}, {}
            for i, cost in states.items():
                steps = [(i, cost)] if i >= 0 else []
                closing = self.closing(motions[i], outputs[j - 1][0]) if i >= 0 else 0.0
                if closing is not None:
                    k = i + 1
                    while k < len(motions):
                        steps.append((k, cost + closing + 1e-4 * (k - i - 1)))
                        if not motions[k].empty:
                            break
                        k += 1
                for k, so_far in steps:
                    if k in new and new[k] <= so_far:
                        continue
                    price = self.price(motions[k], block) if motions[k].marks == marks else None
                    if price is not None and so_far + price < new.get(k, math.inf):
                        new[k], back[k] = so_far + price, i
            if not new:
                lines = sorted({motions[max(i, 0)].block.line for i in states})
                raise Misaligned(
                    f"output line {block.line} ({block.kind} to {block.end}) continues none of the "
                    f"nominal lines {lines} and does not begin what follows them"
                )
            states = new
            trail.append(back)
        finals = {}
        for i, cost in states.items():
            if all(motion.empty for motion in motions[i + 1 :]):
                closing = self.closing(motions[i], outputs[-1][0]) if i >= 0 else 0.0
                if closing is not None:
                    finals[i] = cost + closing
        if not finals:
            raise Misaligned(
                f"the output ends within nominal line {motions[max(max(states), 0)].block.line}; "
                f"the last motion is in line {motions[-1].block.line}"
            )
        i = min(finals, key=finals.get)
        groups = [[] for _ in motions]
        for j in range(len(outputs) - 1, -1, -1):
            groups[i].insert(0, outputs[j][0])
            i = trail[j][i]
        return groups

    def end_miss(self, motion, block):
        """mm between the ends of an output block and of the motion; None = too far."""
        ends = [(block.end[axis], motion.block.end[axis]) for axis in self.axes]
        if any((a is None) != (b is None) for a, b in ends):
            return None
        if motion.end_known:
            end = np.array([b for _, b in ends])
            miss = float(np.linalg.norm(self.actual(block, clamp=True) - end))
        else:
            miss = math.hypot(*(a - b for a, b in ends if a is not None))
        slide = max((abs(a - b) for a, b in ends if a is not None), default=0.0)
        return miss if slide <= self.near else None

    def closing(self, motion, block):
        miss = self.end_miss(motion, block)
        return None if miss is None else miss**2

    def price(self, motion, block):
        """What it costs to call a block a piece of a motion, mm²; None when it cannot be one."""
        short = block.kind in ("rapid", "feed") and block.known and block.length <= self.take_up
        fits = block.kind in KINDS[motion.block.kind]
        if not fits and not (short and motion.block.kind != "machine"):
            return None
        if not motion.known:
            return self.closing(motion, block)
        if None in block.end.values():
            return None
        places = [motion.nearest(self.actual(block, clamp=True))]
        if motion.block.kind != "rapid" and block.known:
            places.append(motion.nearest(self.actual(block, 0.5, clamp=True)))
        if max(distance for _, distance in places) > 2 * self.near:
            return None
        # What is only done behind the end belongs to the motion that follows, if that is as near.
        behind = short and not motion.empty and all(t == 1.0 for t, _ in places)
        return sum(distance**2 for _, distance in places) + (BEHIND**2 if behind else 0.0)

    # Measurement ----------------------------------------------------------------------------------

    def measure(self, motion, pieces, margin, result, end_points):
        """Fill `result` for one nominal motion; append to end_points what it reached."""

        def count(distance, block, command, path=True):
            result.samples += 1
            if path:
                result.path_mm = max(result.path_mm, distance)
            if distance > result.largest_mm or result.where is None:
                result.largest_mm, result.where = (
                    max(distance, result.largest_mm),
                    (block.line, dict(command)),
                )

        last = pieces[-1]
        if motion.known and motion.block.kind != "rapid":
            t = 0.0
            for block in pieces:
                if not block.known:
                    raise Misaligned(
                        f"output line {block.line} begins at an unknown point, nominal line "
                        f"{motion.block.line} does not"
                    )
                t = self.measure_piece(motion, block, t, pieces, margin, count, result)
        end = np.array([motion.block.end[axis] for axis in self.axes])
        reached = self.actual(last, margin=margin)
        result.end_mm = float(np.linalg.norm(reached - end))
        count(result.end_mm, last, last.end, path=False)
        if motion.known and motion.block.kind == "rapid":
            result.take_ups = sum(b.known and b.length <= self.take_up for b in pieces[:-1])
        tool_point = self.machine.actual(
            last.end, self.approach(last), clamp=self.clamp, margin=margin
        )
        end_points.append((motion.block.line, self.machine.nominal(motion.block.end), tool_point))

    def measure_piece(self, motion, block, t, pieces, margin, count, result):
        """One output block that begins at t of the nominal motion; returns where it ends."""
        length = block.length
        t_end = 1.0
        if len(pieces) > 1:
            hint = min(t + length / motion.length, 1.0) if motion.length else 0.0
            reached, distance = motion.nearest(self.actual(block, margin=margin), hint)
            if (t - reached) * motion.length > self.near:
                raise Misaligned(
                    f"output line {block.line} goes back by {(t - reached) * motion.length:.3f} mm"
                    f" on nominal line {motion.block.line}"
                )
            if length <= self.take_up and (reached - t) * motion.length <= length / 2:
                result.take_ups += 1
                count(distance, block, block.end)
                return t
            t_end = max(t, reached) if block is not pieces[-1] else 1.0
        steps = max(math.ceil(length * self.per_mm), 5) if length else 0
        for u in [(k + GOLDEN) / steps for k in range(steps)] + [1.0]:
            reached = self.actual(block, u, margin)
            count(motion.nearest(reached, t + u * (t_end - t))[1], block, block.point(u))
        return t_end


def judged(judge, motions, groups, margin):
    """(results, end_points, unmeasured) of an alignment."""
    results, end_points, unmeasured = [], [], []
    for motion, pieces in zip(motions, groups):
        result = BlockResult(motion.block.line, motion.block.kind, [block.line for block in pieces])
        results.append(result)
        if not pieces or motion.block.kind == "machine":
            continue
        if not motion.end_known:
            unmeasured.append(motion.block.line)
            continue
        judge.measure(motion, pieces, margin, result, end_points)
    return results, end_points, unmeasured


def worst(results):
    """(mm, (nominal line, output line, position)) of the largest."""
    result = max((r for r in results if r.where), key=lambda r: r.largest_mm, default=None)
    return (result.largest_mm, (result.line, *result.where)) if result else (0.0, None)


def check_lengths(motion, pieces, judge):
    """The pieces together are as long as the motion: a whole turn that became a sliver is found
    here."""
    if not motion.known or not pieces or any(not block.known for block in pieces):
        return
    total = sum(block.length for block in pieces)
    without_short = sum(block.length for block in pieces if block.length > judge.take_up)
    room = judge.near + 0.02 * motion.length
    if total < motion.length - room or without_short > motion.length + room:
        raise Misaligned(
            f"nominal line {motion.block.line} is {motion.length:.6f} mm long, its pieces in lines "
            f"{[block.line for block in pieces]} together {total:.6f} mm"
        )


def feed_changes(motion, pieces, judge):
    """(nominal line, output line, nominal feed, output feed) where a cutting piece has another
    feed. What is short behind a piece that came to the end leads to the next motion, at its
    feed."""
    if motion.block.kind not in ("feed", "arc"):
        return []
    misses = [(b, judge.end_miss(motion, b)) for b in pieces if b.known]
    last = next((b for b, miss in misses if miss is not None and miss < CAME), pieces[-1])
    cutting = [
        b
        for b in pieces
        if len(pieces) == 1 or not b.known or b.length > judge.take_up or b is last
    ]
    wanted = (motion.block.feed_mode, motion.block.feed)
    if (
        motion.block.feed_mode == "G93"
        and motion.block.feed
        and all(b.feed and b.feed_mode == "G93" for b in pieces)
    ):
        whole = 1.0 / sum(1.0 / b.feed for b in pieces)  # the times of the pieces add up
        return (
            []
            if abs(whole / motion.block.feed - 1.0) < 0.01
            else [(motion.block.line, pieces[0].line, wanted[1], whole)]
        )
    return [
        (motion.block.line, b.line, wanted[1], b.feed)
        for b in cutting
        if (b.feed_mode, b.feed) != wanted
    ]


def residual(
    nominal_text,
    compensated_text,
    dialect,
    machine,
    *,
    samples_per_mm=5.0,
    clamp=False,
    diameter=None,
    offsets=None,
    block_delete=False,
    start={},
    take_up_mm=0.5,
    near_mm=None,
):
    """Report on a compensated program; Misaligned when it does not do what the nominal program
    does.

    clamp, or the machine's outside = "clamp": hold the tables' end values at nominal points outside
    them, else ValueError. Corrected points may always
    pass the ends by the machine's max_correction. diameter, offsets: the machine's, unless given.
    near_mm: how far an end may lie from the nominal end in any axis (default: the machine's
    max_correction).
    """
    near = machine.max_correction if near_mm is None else near_mm
    judge = Judge(machine, samples_per_mm, clamp or machine.outside == "clamp", take_up_mm, near)
    settings = dict(
        axes=judge.axes,
        diameter=machine.diameter if diameter is None else diameter,
        offsets=machine.offsets if offsets is None else offsets,
        block_delete=block_delete,
        start=start,
    )
    nominal, output = (
        run(nominal_text, dialect, **settings),
        run(compensated_text, dialect, **settings),
    )

    motions = judge.nominal(nominal)
    judge.execute(nominal)
    judge.execute(output)
    before, _, _ = judged(judge, motions, [[motion.block] for motion in motions], 0.0)
    uncompensated, uncompensated_where = worst(before)

    outputs, marks = judge.motions(output)
    _, wanted_marks = judge.motions(nominal)
    if marks != wanted_marks:
        at = next(
            (k for k, (a, b) in enumerate(zip(marks, wanted_marks)) if a != b),
            min(len(marks), len(wanted_marks)),
        )
        raise Misaligned(
            f"blocks that do not move: the nominal program has {wanted_marks[at : at + 3]}, "
            f"the output {marks[at : at + 3]}"
        )
    if len(outputs) < sum(not motion.empty for motion in motions):
        raise Misaligned(f"{len(motions)} nominal motions, only {len(outputs)} in the output")
    groups = judge.align(motions, outputs) if motions or outputs else []
    report = Report(
        0.0, None, uncompensated, uncompensated_where, [], [], len(motions), len(outputs)
    )
    for motion, pieces in zip(motions, groups):
        if not pieces and not motion.empty:
            raise Misaligned(f"nominal line {motion.block.line} has no motion in the output")
        codes = sorted(code for block in pieces for code in block.codes)
        if pieces and codes != sorted(motion.block.codes):
            raise Misaligned(
                f"nominal line {motion.block.line} has {motion.block.codes}, its pieces {codes}"
            )
        check_lengths(motion, pieces, judge)
        report.feed_changes += feed_changes(motion, pieces, judge)
    report.by_block, report.end_points, report.unmeasured = judged(judge, motions, groups, near)
    report.largest_mm, report.where = worst(report.by_block)
    report.take_ups = sum(result.take_ups for result in report.by_block)
    for block, _ in outputs:
        for axis, value in block.end.items():
            low, high = machine.axes[axis].travel
            if value is not None and not low <= value <= high:
                report.outside_travel.append((block.line, axis, value))
    return report
