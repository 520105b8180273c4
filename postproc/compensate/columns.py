"""The columns of one batch while its commands are worked out.

A stroke is a motion, or a part of one between two places where a two-way axis turns back.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from postproc.compensate import nodes
from postproc.compensate.approach import Sides
from postproc.compensate.arcs import points
from postproc.compensate.known import known
from postproc.compensate.settings import Carry, Settings
from postproc.errors import Notice
from postproc.flags import all_of, any_of
from postproc.machine.tip import TipMachine
from postproc.motions import FEED, RAPID, Motions
from postproc.units import TICKS_PER_MM, in_mm


class Columns:
    """S strokes; every stroke belongs to one motion. What each column says stands where it is
    worked out, in batch.py."""

    motion: np.ndarray
    undivided: bool
    t0: np.ndarray
    t1: np.ndarray
    arc_of: np.ndarray
    begin_nominal: np.ndarray
    end_nominal: np.ndarray
    nominal_end: np.ndarray
    passed: np.ndarray | None  # (S,) whether each passes a node, once all were asked
    last: np.ndarray
    code: np.ndarray
    moved: np.ndarray
    forget: np.ndarray
    travel: np.ndarray
    turns: np.ndarray
    known_before: np.ndarray
    hole: np.ndarray
    jumps: np.ndarray
    sure: np.ndarray
    cutting: np.ndarray
    correctable: np.ndarray
    left: np.ndarray
    twice: np.ndarray
    against: np.ndarray
    turning: np.ndarray
    wanted: np.ndarray
    before: np.ndarray
    begin: np.ndarray
    beyond: np.ndarray
    way: np.ndarray
    weight_begin: np.ndarray
    weight_end: np.ndarray
    sides: Sides
    exact: np.ndarray
    end: np.ndarray
    tip: bool
    plain: bool
    inside: bool
    reads_beside: bool

    def __init__(
        self,
        settings: Settings,
        motions: Motions,
        carry: Carry,
        span: tuple[float, float] = (0.0, 1.0),
    ):
        """span: from where to where in t, of one motion that is corrected in parts."""
        self.c, self.m, self.carry, self.span = settings, motions, carry, span
        self.machine, self.options = settings.machine, settings.options
        self.rows, self.fixed = settings.rows, settings.fixed
        self.notices: list[Notice] = []
        self.downs: dict[tuple[int, bytes], tuple[np.ndarray, np.ndarray]] = {}  # of holes
        motions.recall(self, settings, self._whole)

    def _whole(self) -> None:
        """What is known of the motions, each of them one stroke; nothing of it depends on their
        places, where all of these are known."""
        motions = self.m
        self.tip = isinstance(self.machine, TipMachine)
        self.places = known(self.machine, motions)
        self.known, self.start_known = self.places.end, self.places.start
        # motions whose end is corrected
        self.free = self.known & ~(motions.alone | self.places.idle)
        # (A, N) G28 has taken the axis elsewhere meanwhile
        self.jumped = motions.sent & motions.start_known
        self.leaps = any_of(self.jumped)
        # every place is known, and every motion corrected
        self.every = self.places.every and all_of(self.free)
        # whether nothing but lines of slides whose places are known is there
        self.plain = (
            self.every
            and len(motions) > 0
            and not (
                self.tip or len(motions.arcs) or len(motions.holes) or self.options.orientation
            )
            and self.c.mode != "off"
            and not np.count_nonzero(motions.cutter)
            and not np.count_nonzero(motions.reason)
            and all_of(motions.code <= FEED)
        )
        # (N,) ticks commanded at the bottom of a hole
        self.bottom = np.zeros(len(motions), np.int64)
        self.arc_of = np.empty(len(motions), np.int64)
        self.arc_of.fill(-1)
        self.arc_of[motions.arcs.motion] = np.arange(len(motions.arcs))
        self.motion, self.t0 = np.arange(len(motions)), np.zeros(len(motions))
        self.t1 = np.ones(len(motions))

    @cached_property
    def turned(self) -> np.ndarray:
        """(A, S) bool: two-way axes that bear otherwise along a stroke than behind the one
        before."""
        first = self.carry.sides.side.astype(float)
        if self.c.ramped:
            ramped = self.c.reach > 0
            first[ramped] = self.carry.sides.taken[ramped] / self.c.reach[ramped]
        before = np.empty(self.weight_end.shape)
        before[:, 0], before[:, 1:] = first, self.weight_end[:, :-1]
        turned: np.ndarray = before != self.weight_begin
        if len(self.c.two_way) < len(before):
            turned &= self.machine.two_way[:, None]
        return turned

    @cached_property
    def arc_start(self) -> np.ndarray:
        """(A, n) mm where each arc begins."""
        return in_mm(self.m.start.take(self.m.arcs.motion, axis=1))

    @cached_property
    def arc_target(self) -> np.ndarray:
        """(A, n) mm where each arc ends."""
        return in_mm(self.m.target.take(self.m.arcs.motion, axis=1))

    def of(self, column: np.ndarray) -> np.ndarray:
        """(..., S) a column (..., N) of the motions for every stroke; not to be written to."""
        return column if self.undivided else column.take(self.motion, axis=-1)

    def nominal(self, motion: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(A, K) mm nominal point of motions at t; ends exactly as programmed."""
        m, n = self.m, len(t)
        for end, column in ((1.0, m.target), (0.0, m.start)):
            if np.count_nonzero(t == end) == n:
                return in_mm(column.take(motion, axis=1))
        start = in_mm(m.start.take(motion, axis=1))
        target = in_mm(m.target.take(motion, axis=1))
        result = np.where(t == 1.0, target, start + (target - start) * t)
        on_arc = (self.arc_of[motion] >= 0) & (t > 0) & (t < 1)
        if on_arc.any():
            result[:, on_arc] = points(
                m.arcs, self.arc_start, self.arc_target, self.arc_of[motion[on_arc]], t[on_arc]
            )
        return result

    def may_bend(self, which: np.ndarray, slack: float) -> np.ndarray:
        """(K,) whether the deviation can bend between the ends of straight strokes `which` (K,), in
        order: at a node, or by product terms, which bend it by `slack` mm at least. What all pass
        is looked up once."""
        begin, end, clamped = self.begin_nominal, self.end_nominal, self.c.outside == "clamp"
        if len(which) == begin.shape[1]:
            if self.passed is None:
                self.passed = nodes.passes(self.machine, begin, end, clamped)
            passed = self.passed
        else:
            begin, end = begin.take(which, axis=1), end.take(which, axis=1)
            passed = nodes.passes(self.machine, begin, end, clamped)
        may_bend: np.ndarray = passed | self.machine.bounds.bends(begin, end, slack)
        return may_bend

    def left_alone(self) -> np.ndarray:
        """(A, S) bool: axes that stay where they were sent last: in a motion that is left as it is
        and does not name them, and where the nominal path does not move at all."""
        m, free = self.m, self.moved
        left = self.of(m.changed)
        if any_of(left) or not self.every:
            left = ~(free & self.correctable) | self.of(m.changed & (m.code == RAPID))
            left &= self.of(m.word < 0)  # no rapid brings an axis back from a tool change
        rests = ~np.logical_or.reduce(self.travel, axis=0)
        if any_of(rests):
            rests &= (self.t1 - self.t0 == 1.0) & (self.code <= FEED) & free & self.sure
            # the first feed brings an axis back from a tool change, though it goes nowhere
            rests &= (self.code == RAPID) | ~self.of(m.changed).any(axis=0)
            left = left | rests & self.of(m.start_known & m.target_known).all(axis=0)
        if len(m.holes):  # the cycle brings the axis back to where it was
            left = left.copy()
            left[m.holes.axis[m.holes.initial], self.hole[m.holes.initial]] = True
            left[:, self.hole[~m.holes.place]] = True
        return left

    def weight(self, stroke: np.ndarray, nominal: np.ndarray) -> np.ndarray:
        """(A, K) side of approach at places along strokes."""
        begin = self.weight_begin.take(stroke, axis=1)
        ramped = self.c.reach > 0
        if not any_of(ramped):
            return begin
        reach = np.where(ramped, self.c.reach, 1)[:, None]
        way = (nominal - self.begin_nominal.take(stroke, axis=1)) * (TICKS_PER_MM / reach)
        moved = np.minimum(np.maximum(begin + way, -1.0), 1.0)
        return np.where(ramped[:, None], moved, begin)
