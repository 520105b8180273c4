"""The columns of one batch while its commands are worked out: strokes, directions of approach, where each begins and ends.

A stroke is a motion, or the part of an arc between two places where a two-way axis turns back.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from postproc.compensate import approach, cutter
from postproc.compensate.arcs import points, turning_points
from postproc.compensate.inverse import command
from postproc.errors import Notice
from postproc.motions import COUNTER, FEED, FREE, HOLE, Motions
from postproc.units import TICKS_PER_MM

if TYPE_CHECKING:
    from postproc.compensate.compensator import Carry, Compensator


def written_centre(motions: Motions) -> np.ndarray:
    """(2, n) ticks from the start of each arc to its centre, exactly as written where it was written as I J K."""
    arcs = motions.arcs
    k = np.arange(len(arcs))
    start = np.stack([motions.start[np.maximum(axis, 0), arcs.motion[k]] for axis in (arcs.first, arcs.second)])
    return np.rint(arcs.centre * TICKS_PER_MM).astype(np.int64) - start


def row_of(letter: str) -> int:
    """Which of an axis' components is its positioning."""
    return "XYZ".index(letter)


class Batch:
    """The columns of one batch while they are worked out. S strokes; every stroke belongs to one motion."""

    def __init__(self, compensator: Compensator, motions: Motions, carry: Carry):
        self.c, self.m, self.carry = compensator, motions, carry
        self.machine, self.options = compensator.machine, compensator.options
        self.rows = list(self.machine.corrected)
        self.fixed = [i for i in range(len(self.machine.axes)) if i not in self.rows]
        self.notices: list[Notice] = []
        chained = list(self.machine.chained)
        self.known: np.ndarray = np.all(motions.target_known[chained], axis=0)
        self.start_known: np.ndarray = np.all(motions.start_known[chained], axis=0)
        self.free = self.known & ~motions.alone  # motions whose end is corrected
        self.jumped = motions.sent & motions.start_known  # (A, N) G28 has taken the axis elsewhere meanwhile
        self.bottom = np.zeros(len(motions), np.int64)  # (N,) ticks commanded at the bottom of a hole

    def strokes(self) -> None:
        """Motions, and arcs cut where a two-way axis turns back: motion, t0, t1 (S,), travel (A, S)."""
        m, arcs = self.m, self.m.arcs
        motion, t0, t1 = np.arange(len(m)), np.zeros(len(m)), np.ones(len(m))
        self.arc_of = np.full(len(m), -1)
        self.arc_of[arcs.motion] = np.arange(len(arcs))
        self.arc_start, self.arc_target = (
            m.start[:, arcs.motion] / TICKS_PER_MM,
            m.target[:, arcs.motion] / TICKS_PER_MM,
        )
        turning = (
            self.machine.two_way[arcs.first] | self.machine.two_way[arcs.second] if len(arcs) else np.zeros(0, bool)
        )
        if len(arcs) and m.cutter.any():
            turning &= m.cutter[arcs.motion] == FREE
        if self.c.limit and turning.any():
            arc, t = turning_points(arcs, self.arc_start, self.arc_target)
            arc, t = arc[turning[arc]], t[turning[arc]]
            motion = np.concatenate([motion, arcs.motion[arc]])
            t0 = np.concatenate([t0, t])
            order = np.lexsort((t0, motion))
            motion, t0 = motion[order], t0[order]
            t1 = np.where(np.concatenate([motion[1:] == motion[:-1], [False]]), np.concatenate([t0[1:], [1.0]]), 1.0)
        self.motion, self.t0, self.t1 = motion, t0, t1
        self.last = t1 == 1.0
        self.begin_nominal, self.end_nominal = self.nominal(motion, t0), self.nominal(motion, t1)
        if len(arcs):
            travel = np.rint((self.end_nominal - self.begin_nominal) * TICKS_PER_MM).astype(np.int64)
            whole = self.arc_of[motion] < 0
            travel[:, whole] = (m.target - m.start)[:, motion[whole]]
        else:
            travel = m.target - m.start
        sure = (m.start_known & m.target_known)[:, motion]
        forget = np.zeros_like(sure)
        if not sure.all():
            travel = np.where(sure, travel, 0)
            forget = ~sure & m.target_known[:, motion] & (m.word >= 0)[:, motion]
        self.travel = travel
        self.inside = bool(m.cutter.any())
        self.reads_beside = self.inside and cutter.reads_beside(self)
        turns = cutter.last_way(self, travel) if self.inside else travel
        if len(m.holes):  # the axis that drills has come back up last
            turns = turns.copy()
            self.hole = np.searchsorted(motion, m.holes.motion)
            turns[m.holes.axis, self.hole] = m.holes.level - m.holes.bottom
        before, after = approach.follow(turns, forget, self.carry.turn, self.c.limit)
        self.turn_after = after
        if self.c.mode in ("step", "off"):
            before = np.where(turns != 0, after, before)
        unit = 1.0 / max(self.c.limit, 1)
        self.weight_begin, self.weight_end = before * unit, after * unit

    def nominal(self, motion: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(A, K) mm nominal point of motions at t; ends exactly as programmed."""
        m = self.m
        if (t == 1.0).all() or (t == 0.0).all():
            return (m.target if t[:1] == 1.0 else m.start)[:, motion] / TICKS_PER_MM
        start, target = m.start[:, motion] / TICKS_PER_MM, m.target[:, motion] / TICKS_PER_MM
        result = np.where(t == 1.0, target, np.where(t == 0.0, start, start + (target - start) * t))
        on_arc = (self.arc_of[motion] >= 0) & (t > 0) & (t < 1)
        if on_arc.any():
            result[:, on_arc] = points(m.arcs, self.arc_start, self.arc_target, self.arc_of[motion[on_arc]], t[on_arc])
        return result

    def weight(self, stroke: np.ndarray, nominal: np.ndarray) -> np.ndarray:
        """(A, K) approach at places along strokes."""
        if self.c.mode != "ramp":
            return self.weight_begin[:, stroke]
        way = (nominal - self.begin_nominal[:, stroke]) * (TICKS_PER_MM / self.c.limit)
        return np.clip(self.weight_begin[:, stroke] + way, -1.0, 1.0)

    def needed(self, stroke: np.ndarray, nominal: np.ndarray, weight: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(A, K) mm: exact commands at t (of the motion) along strokes.

        In mode off what differs at a stroke's begin fades along it: the reversal is spread over the block.
        """
        if self.inside:
            weight = cutter.approach_on_arcs(self, stroke, t, weight)
        exact = self.command(stroke, t, nominal, weight)
        if self.c.mode == "off" and self.c.limit:
            rest = (self.t1[stroke] - t) / (self.t1 - self.t0)[stroke]
            exact += self.differs[:, stroke] * rest
        return exact

    def command(self, stroke: np.ndarray, t: np.ndarray, nominal: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """(A, K) mm: commands at t along strokes, the map read where the tool's centre is."""
        if not self.reads_beside:
            return command(self.machine, nominal, weight, self.motion[stroke])
        beside = cutter.centre(self, stroke, t)
        return command(self.machine, nominal + beside, weight, self.motion[stroke]) - beside

    def grid(self, stroke: np.ndarray, exact: np.ndarray) -> np.ndarray:
        """(A, K) ticks: exact commands mm rounded once, half to even, to the least increment of each axis' word."""
        m, motion = self.m, self.motion[stroke]
        # Whole increments from the nominal place, wherever a difference of two places may be written; else from zero.
        near = m.incremental[:, motion] | (self.travel[:, stroke] == 0)
        zero = np.where(near, m.start[:, motion], m.origin[:, motion])
        step = m.grid[:, motion]
        return zero + np.rint((exact * TICKS_PER_MM - zero) / step).astype(np.int64) * step

    def ends(self) -> None:
        """`end` (A, S) ticks commanded at each stroke's end, as if nothing were held still; `exact` (A, S) mm."""
        m, motion, n = self.m, self.motion, len(self.motion)
        free = self.free[motion]
        which = free.nonzero()[0]
        if free.all():
            self.exact = self.command(which, self.t1, self.end_nominal, self.weight_end)
        else:
            self.exact = self.end_nominal.copy()
            self.exact[:, which] = self.command(
                which, self.t1[which], self.end_nominal[:, which], self.weight_end[:, which]
            )
        step = m.grid[:, motion]
        correction = self.exact - self.end_nominal
        whole = np.rint(correction * TICKS_PER_MM / step).astype(np.int64) * step
        nominal_ticks = m.target[:, motion]
        if not self.last.all():
            inside = np.rint(self.end_nominal * TICKS_PER_MM).astype(np.int64)
            nominal_ticks = np.where(self.last, nominal_ticks, inside)
        self.nominal_end = nominal_ticks
        # A programmed word keeps its own decimals: its correction is rounded, not its sum.
        self.end = nominal_ticks + whole
        inner = (~self.last).nonzero()[0]
        if len(inner):
            self.end[:, inner] = self.grid(inner, self.exact[:, inner])
        self.end[self.fixed] = nominal_ticks[self.fixed]
        if not free.all():
            self.end[:, ~free] = nominal_ticks[:, ~free]
        self.before = np.concatenate([self.carry.issued[:, None], self.end[:, :-1]], axis=1)
        if self.jumped.any():
            self.before = np.where(self._jumps(), m.start[:, motion], self.before)
        self.sure_after = free & (m.code[motion] != HOLE)
        self.sure = np.concatenate([[self.carry.sure], self.sure_after[:-1]]) if n else free
        if self.jumped.any():
            self.sure &= ~self._jumps().any(axis=0)
        self.known_before = self.start_known[motion] | (self.t0 > 0)

    def _jumps(self) -> np.ndarray:
        """(A, S) bool: strokes that begin where the last one did not end, since something else has moved the axis."""
        return self.jumped[:, self.motion] & (self.t0 == 0)

    def starts(self) -> None:
        """`wanted` (A, S) ticks: where a stroke must be begun, for strokes (`turning`) whose start may differ."""
        m, motion = self.m, self.motion
        code = m.code[motion]
        cutting = (code >= FEED) & (code <= COUNTER) & (m.cutter[motion] == FREE)
        weight_before = np.concatenate(
            [(self.carry.turn / max(self.c.limit, 1))[:, None], self.weight_end[:, :-1]], axis=1
        )
        turned: np.ndarray = np.any((weight_before != self.weight_begin) & self.machine.two_way[:, None], axis=0)
        self.turning = cutting & self.free[motion] & self.known_before & (turned | ~self.sure)
        if self.c.mode != "step":
            self.turning &= ~self.sure & (self.t0 == 0) & (self.c.mode != "off")
        self.wanted = np.zeros_like(self.end)
        which = self.turning.nonzero()[0]
        if len(which):
            exact = command(self.machine, self.begin_nominal[:, which], self.weight_begin[:, which], motion[which])
            self.wanted[:, which] = self.grid(which, exact)
        self.wanted[self.fixed] = self.before[self.fixed]

    def settle_ends(self) -> None:
        """Hold still what stands still: an axis without nominal travel moves only when its correction has changed by
        more than half the tolerance. Sets `begin` (A, S), where each stroke is begun, and the final `before` and `end`."""
        hold = self.c.hold * TICKS_PER_MM
        free, known = self.free[self.motion], self.known_before
        turning, all_known = self.turning.any(), known.all()
        held = (self.travel == 0).any(axis=1)
        # A motion that is left as it is moves the axes that it names; the others stay where they were sent last.
        left = np.zeros(held.shape + free.shape, bool) if free.all() else ~free & (self.m.word[:, self.motion] < 0)
        holes = self.m.holes
        if len(holes):  # the cycle brings the axis back to where it was
            left[holes.axis[holes.initial], self.hole[holes.initial]] = True
        self.leash = cutter.leash(self) if self.inside else None
        if all_known and not turning and not held[self.rows].any() and not left.any() and self.leash is None:
            self.begin = self.before
            return
        self.begin = self.before.copy()
        for row in range(len(self.end)):
            end = self.end[row]
            if row in self.rows and (held[row] or left[row].any() or self.leash is not None):
                rests = (self.travel[row] == 0) & free & known & (self.sure | self.turning)
                if self.leash is not None:
                    rests |= (self.leash[row] < cutter.FREELY) & free & known
                still = (rests | left[row]).nonzero()[0]
                end[still] = self._held(row, still, end, left[row, still])
            before = np.concatenate([self.carry.issued[row : row + 1], end[:-1]])
            known_here = (self.m.start_known[row, self.motion] & ~self.jumped[row, self.motion]) | (self.t0 > 0)
            before = np.where(known_here, before, self._nominal_begin(row))
            self.before[row] = before
            differs = self.turning & (np.abs(self.wanted[row] - before) > hold)
            self.begin[row] = np.where(differs, self.wanted[row], before)
            self._notice_induced(row)

    def _held(self, row: int, still: np.ndarray, end: np.ndarray, left: np.ndarray) -> np.ndarray:
        """(K,) ticks at which strokes `still` end, one after the other, since each rests where the one before left it.
        left (K,): strokes that do not move the axis at all."""
        hold = self.c.hold * TICKS_PER_MM
        before = np.where(still > 0, end[still - 1], self.carry.issued[row])
        jumped = self._jumps()[row, still]
        before = np.where(jumped, self.m.start[row, self.motion[still]], before).tolist()
        value, exact = end[still].tolist(), (self.exact[row, still] * TICKS_PER_MM).tolist()
        wanted, turning = self.wanted[row, still].tolist(), self.turning[still].tolist()
        stays, last = left.tolist(), -2
        most = self.leash[row, still].tolist() if self.leash is not None else [cutter.FREELY] * len(value)
        way = self.travel[row, still].tolist()
        for k, i in enumerate(still.tolist()):
            here = value[k - 1] if i == last + 1 and not jumped[k] else before[k]
            if most[k] < cutter.FREELY and not stays[k]:  # by how much its correction may change along the stroke
                value[k] = here + way[k] + min(max(value[k] - here - way[k], -most[k]), most[k])
                last = i
                continue
            if turning[k] and abs(wanted[k] - here) > hold:
                here = wanted[k]
            if stays[k] or abs(exact[k] - here) <= hold:
                value[k] = here
            last = i
        return np.array(value, np.int64)

    def _notice_induced(self, row: int) -> None:
        """Say where a correction moves a resting axis back by less than its own reversal: the slide may not follow."""
        table = self.machine.tables.get(self.machine.letters[row])
        if row not in self.rows or table is None or not self.c.limit:
            return
        play = 2 * float(np.abs(table.half[row_of(self.machine.letters[row])]).max()) * TICKS_PER_MM
        creep = self.end[row] - self.begin[row]
        back = (
            (self.travel[row] == 0)
            & self.free[self.motion]
            & self.known_before
            & (creep * self.weight_end[row] < 0)
            & (np.abs(creep) < play)
        )
        if back.any():
            i = int(np.argmax(np.where(back, np.abs(creep), 0)))
            letter = self.machine.letters[row]
            self.notices.append(Notice(
                f"induced {letter}", f"{letter} rests on the path, and its correction moves it back by {abs(creep[i]) / TICKS_PER_MM * 1000:.2f} um, less than "
                f"its own reversal of {play / TICKS_PER_MM * 1000:.1f} um: the slide may not follow", int(self.motion[i]),
            ))  # fmt: skip

    def _nominal_begin(self, row: int) -> np.ndarray:
        return np.where(
            self.t0 == 0,
            self.m.start[row, self.motion],
            np.rint(self.begin_nominal[row] * TICKS_PER_MM).astype(np.int64),
        )

    def spread_reversals(self) -> None:
        """Mode off: `differs` (A, S) mm, by how much each stroke's begin misses the command that it needs."""
        if self.c.mode == "off" and self.c.limit:
            which = (self.known_before & self.free[self.motion]).nonzero()[0]
            exact = command(self.machine, self.begin_nominal[:, which], self.weight_begin[:, which], self.motion[which])
            self.differs = np.zeros_like(self.exact)
            self.differs[:, which] = self.begin[:, which] / TICKS_PER_MM - exact
