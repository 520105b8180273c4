"""One batch of motions to its pieces; what the next batch must know goes along as a Carry.

In order: refuse what can not be trusted, cut motions where an axis turns back, follow the side of
approach with the command of every end, take up the lost motion, keep still what stands still, cut
the ways between, check the limits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise

import numpy as np

from postproc.compensate import (
    approach,
    cut,
    cutter,
    holes,
    leading,
    levels,
    limits,
    splines,
    threads,
)
from postproc.compensate.batch import Batch, written_centre
from postproc.compensate.settings import Carry, Options, Settings
from postproc.errors import MachineError, MotionFault, Notice
from postproc.machine import growth, poses, seen
from postproc.machine.model import Machine
from postproc.motions import THREAD, Motions
from postproc.pieces import Pieces, in_order, joined, without_rests
from postproc.records import replace
from postproc.spaces import Space
from postproc.units import TICKS_PER_MM

WHOLE = (0.0, 1.0)  # of a motion, from begin to end
MOST_KEPT = 200  # machines with a tool, in a space, at a temperature
FEW = 32  # motions that are worked out at once behind one that is left as it is


class Compensator(Settings):
    """A machine and the options, ready to correct batches. Holds no state."""

    def __init__(self, machine: Machine, options: Options = Options()):
        super().__init__(machine, options)
        self.by_tool: dict[tuple[Space | None, tuple[int, ...], tuple[int, ...]], Compensator] = {}

    def initial(self, stands: np.ndarray | None = None) -> Carry:
        """Before the first motion. stands (A,): ticks, where the slides stand (0 where that
        is unknown), which is their last command: distances count from there."""
        zero = np.zeros(len(self.machine.axes), np.int64)
        stands = zero if stands is None else stands
        return Carry(approach.initial(len(zero)), stands, zero, stands)

    def run(self, motions: Motions, carry: Carry) -> tuple[Pieces, Carry, list[Notice]]:
        """Pieces of a batch. Raises MotionFault for the first motion that must not be written."""
        if not len(motions):
            return _none(len(self.machine.axes)), carry, []
        if self.machine.is_zero:
            return _untouched(motions), carry, []
        turned = self.machine.turns and np.count_nonzero(motions.length) > 0
        spaced = np.count_nonzero(motions.space) > 0
        if turned or spaced or carry.frame[0] is not None or self.machine.growth:
            return self._by_tool(motions, carry)
        return self._run(motions, carry)

    def _by_tool(self, motions: Motions, carry: Carry) -> tuple[Pieces, Carry, list[Notice]]:
        """The same where tools have lengths: every run of motions on the machine with its own tool,
        in its own space."""
        parts, notices = [], []
        for first, stop, span, heat in self._alike(motions):
            one = motions.part(first, stop)
            space, length = one.spaces[int(one.space[0])], one.length[:, 0]
            try:
                space = self._beside(carry, space, one)
                carry = self._transformed(carry, space, length, one)
                # where the machine stands is no longer what the nominal position needs
                if carry.heat != heat:
                    carry = replace(carry, heat=heat, sure=carry.sure and span[0] > 0.0)
                pieces, carry, more = self._of_tool(length, space, heat)._run(one, carry, span)
            except MotionFault as fault:
                fault.motion += first
                raise
            except MachineError as fault:  # a pose at which no slide helps
                raise MotionFault(first, fault.message, fault.advice) from None
            parts.append(_counted_on(pieces, first, motions))
            notices += [replace(n, line=n.line + first) for n in more]
        return joined(parts), carry, notices

    def _alike(
        self, motions: Motions
    ) -> Iterator[tuple[int, int, tuple[float, float], tuple[int, ...]]]:
        """Runs of motions of one tool, in one space, equally warm: the first and the one behind the
        last, from where to where in t, and how warm. A motion that lasts long is one by itself for
        each of its spells."""
        both = np.concatenate([motions.length, motions.space[None], *_heat_rows(motions.heat)])
        spells = motions.spells
        edges = (both[:, 1:] != both[:, :-1]).any(axis=0)
        long = np.zeros(len(motions), bool)
        long[spells.motion] = True
        edges |= long[1:] | long[:-1]
        places = [0, *(np.flatnonzero(edges) + 1).tolist(), len(motions)]
        for first, stop in pairwise(places):
            heat = tuple(motions.heat[:, first].tolist()) if len(motions.heat) else ()
            if not long[first]:
                yield first, stop, WHOLE, heat
                continue
            begin = 0.0
            for k in np.flatnonzero(spells.motion == first):
                end = float(spells.until[k])
                yield first, stop, (begin, end), tuple(spells.heat[:, k].tolist())
                begin = end

    def _beside(self, carry: Carry, space: Space | None, one: Motions) -> Space | None:
        """A space of polar interpolation with how far Y was led beside its nominal place before;
        there nothing moves it."""
        if space is None or not space.polar or "Y" not in self.machine.letters:
            return space
        frame, had = carry.frame
        if frame is not None and replace(frame, beside=0.0) == space:
            return frame
        row = self.machine.letters.index("Y")
        length = np.array(had or (0,) * len(carry.issued)) / TICKS_PER_MM
        slides = poses.out_of(self.machine, frame, length, carry.issued[:, None] / TICKS_PER_MM)
        return replace(space, beside=float(slides[row, 0] - one.start[row, 0] / TICKS_PER_MM))

    def _transformed(
        self, carry: Carry, space: Space | None, length: np.ndarray, motions: Motions
    ) -> Carry:
        """The carry with `issued` told in a space, with a tool of `length` (A,) ticks; sides are
        the slides' own."""
        one, had = carry.frame
        frame = (space, tuple(length.tolist()))
        if one is None and space is None:
            return replace(carry, frame=frame)
        if carry.frame == frame:
            return carry
        before = np.array(had or (0,) * len(length)) / TICKS_PER_MM
        slides = poses.out_of(self.machine, one, before, carry.issued[:, None] / TICKS_PER_MM)
        place = poses.into(self.machine, space, length / TICKS_PER_MM, slides)[:, 0]
        issued = np.rint(place * TICKS_PER_MM).astype(np.int64)
        if one is not None and one.polar:  # C is not led back to where it would stand uncorrected
            c = self.machine.letters.index("C")
            issued[c] = motions.start[c, 0]
        return replace(carry, issued=issued, frame=frame, way=np.zeros_like(carry.way), sure=False)

    def _of_tool(
        self, length: np.ndarray, space: Space | None = None, heat: tuple[int, ...] = ()
    ) -> Compensator:
        """The machine with a tool of this `length` (A,), ticks, in a space, as warm as these whole
        steps (D,) say."""
        key = (space, tuple(length.tolist()), heat)
        if key not in self.by_tool:
            machine = self.machine
            if machine.growth:
                values = np.array(heat or (0,) * len(machine.growth)) * np.array(
                    self.options.heat_step
                )
                machine = growth.grown(machine, machine.growth, values)
            machine = seen.seen_in(machine, length / TICKS_PER_MM, space, self.options.orientation)
            while len(self.by_tool) >= MOST_KEPT:  # heat does not come back: memory stays flat
                del self.by_tool[next(iter(self.by_tool))]
            self.by_tool[key] = Compensator(machine, self.options)
        return self.by_tool[key]

    def keeps(self, motions: Motions) -> bool:
        """Whether the holes among these motions of one tool can stay with their cycles under
        --expand: each bends by less than the tolerance of holes, as it was asked for, so that 0
        keeps none."""
        if self.machine.is_zero or not len(motions.holes):
            return self.straightness > 0
        turned = self.machine.turns and motions.length.any()
        with_tool = self._of_tool(motions.length[:, 0]) if turned else self
        try:
            return holes.straight(with_tool, motions, self.straightness)
        except MotionFault:  # said where the motions themselves are corrected
            return False

    def _run(
        self, motions: Motions, carry: Carry, span: tuple[float, float] = WHOLE
    ) -> tuple[Pieces, Carry, list[Notice]]:
        """span: from where to where in t, of one motion."""
        goes_back = self.follows or motions.holes.flush.any() or motions.holes.higher.any()
        if goes_back and len(cuts := _before_holes(motions)):
            return self._in_parts(motions, carry, cuts)
        b = self._worked_out(motions, carry, span)
        if self.options.passes_unknown and limits.at_stop(b).any():
            return self._with_stops(motions, carry, span)
        return self._finished(b, carry)

    def _in_parts(
        self, motions: Motions, carry: Carry, cuts: np.ndarray
    ) -> tuple[Pieces, Carry, list[Notice]]:
        """The same, one part after the other."""
        parts, notices = [], []
        for first, stop in pairwise([0, *cuts.tolist(), len(motions)]):
            try:
                pieces, carry, more = self._run(motions.part(first, stop), carry)
            except MotionFault as fault:
                fault.motion += first
                raise
            parts.append(_counted_on(pieces, first, motions))
            notices += [replace(n, line=n.line + first) for n in more]
        return joined(parts), carry, notices

    def _with_stops(
        self, motions: Motions, carry: Carry, span: tuple[float, float]
    ) -> tuple[Pieces, Carry, list[Notice]]:
        """The same where motions begin or end at the end of an axis' travel: those that lead beyond
        are left as they are, one after the other, since each changes where the next one begins."""
        parts, notices, first, size = [], [], 0, FEW
        while first < len(motions):
            try:
                pieces, carry, more, done, stops = self._to_a_stop(
                    motions, first, size, carry, span
                )
            except MotionFault as fault:
                fault.motion += first
                raise
            parts.append(_counted_on(pieces, first, motions))
            notices += [replace(n, line=n.line + first) for n in more]
            first, size = first + done, FEW if stops else 2 * size
        return joined(parts), carry, notices

    def _to_a_stop(
        self, motions: Motions, first: int, size: int, carry: Carry, span: tuple[float, float]
    ) -> tuple[Pieces, Carry, list[Notice], int, bool]:
        """The next motions from `first` on, `size` at most, up to one that leads beyond a stop, or
        such a one alone; how many they are, and whether there is such a one."""
        one = motions.part(first, min(first + size, len(motions)))
        b = self._worked_out(one, carry, span)
        hit = limits.at_stop(b)
        if hit[0]:
            one = one.part(0, 1)
            b = self._worked_out(replace(one, alone=one.alone | True), carry, span)
            b.notices.append(Notice("stop", limits.AT_STOP, 0, counts=(1,)))
        elif hit.any():
            one = one.part(0, int(hit.argmax()))
            b = self._worked_out(one, carry, span)
        return *self._finished(b, carry), len(one), bool(hit.any())

    def _finished(self, b: Batch, carry: Carry) -> tuple[Pieces, Carry, list[Notice]]:
        """The pieces of a batch that is worked out."""
        spline = None if b.plain else splines.check(b)
        parts = [cut.take_ups(b), cut.straight_pieces(b), cut.arc_pieces(b)]
        pieces = without_rests(in_order([p for p in parts if p is not None]))
        largest = limits.check_limits(b)
        issued = b.end[:, -1].copy()
        after = Carry(
            sides=b.sides, issued=issued, way=b.way,
            level=levels.initial(b) if len(b.m.holes) else issued, sure=bool(b.sure_after[-1]),
            heading=cutter.heading(b), largest=max(carry.largest, largest), frame=carry.frame,
            heat=carry.heat, spline=spline, threading=int(b.code[-1]) == THREAD,
        )  # fmt: skip
        return pieces, after, b.notices

    def _worked_out(self, motions: Motions, carry: Carry, span: tuple[float, float]) -> Batch:
        """The batch with where every stroke begins and ends."""
        b = Batch(self, motions, carry, span)
        for step in OF_LINES if b.plain else EVERY:
            step(b)
        return b


def _tell_held(b: Batch) -> None:
    """Say what cutter radius compensation holds."""
    if b.leash is not None:
        cutter.tell_held(b, b.leash)


# What is worked out of a batch, in order; and the part of it that lines and feeds ask for whose
# places are all known, outside cycles and cutter radius compensation, where slides are programmed.
EVERY: tuple[Callable[[Batch], None], ...] = (
    limits.refuse, limits.refuse_turning_arcs, limits.check_unknown, limits.check_pole,
    cutter.tell, Batch.strokes, limits.check_inside, limits.check_poses, Batch.approach,
    Batch.ends, holes.settle, Batch.starts, Batch.settle_ends, _tell_held,
    Batch.spread_reversals, leading.lead_beyond, leading.tell, limits.check_ended_poses,
    threads.say, limits.tell_orientation, limits.tell_play,
)  # fmt: skip
OF_LINES = (
    Batch.strokes, limits.check_inside, Batch.approach, Batch.ends, Batch.starts,
    Batch.settle_ends, leading.lead_beyond, leading.tell,
)  # fmt: skip


def _before_holes(motions: Motions) -> np.ndarray:
    """Motions at which holes begin behind others, or along another axis: their axis goes back to
    the command before them, which is known to the digit only once that is written."""
    holes = motions.holes
    begins = np.ones(len(holes), bool)
    begins[1:] = (np.diff(holes.motion) > 1) | (np.diff(holes.axis) != 0)
    return holes.motion[begins & (holes.motion > 0)]


def _heat_rows(heat: np.ndarray) -> list[np.ndarray]:
    return [heat] if len(heat) else []


def _bottoms(motions: Motions) -> np.ndarray:
    bottom = np.zeros(len(motions), np.int64)
    bottom[motions.holes.motion] = motions.holes.bottom
    return bottom


def _radii(motions: Motions) -> np.ndarray:
    radius = np.zeros(len(motions), np.int64)
    radius[motions.arcs.motion] = motions.arcs.by_radius
    return radius


def _counted_on(pieces: Pieces, first: int, motions: Motions) -> Pieces:
    """Pieces of the motions from `first` on, with the numbers that motions and arcs have in the
    whole."""
    arcs = int(np.searchsorted(motions.arcs.motion, first))
    return replace(
        pieces, motion=pieces.motion + first, arc=np.where(pieces.arc >= 0, pieces.arc + arcs, -1)
    )


@cache
def _none(axes: int) -> Pieces:
    """No pieces."""
    i, places, no = np.zeros(0, np.int64), np.zeros((axes, 0), np.int64), np.zeros(0, bool)
    centre, share = np.zeros((2, 0), np.int64), np.zeros(0)
    return Pieces(i, i, places, places, share, i, centre, i, places, no, no, i)


def _untouched(motions: Motions) -> Pieces:
    n = len(motions)
    arc = np.full(n, -1)
    arc[motions.arcs.motion] = np.arange(len(motions.arcs))
    return Pieces(
        motion=np.arange(n),
        code=motions.code,
        start=motions.start,
        end=motions.target,
        share=np.ones(n),
        arc=arc,
        centre=(
            written_centre(motions)[:, np.maximum(arc, 0)]
            if len(motions.arcs)
            else np.zeros((2, n), np.int64)
        ),
        radius=_radii(motions),
        nominal=motions.target,
        take_up=np.zeros(n, bool),
        corrected=np.zeros(n, bool),
        bottom=_bottoms(motions),
    )
