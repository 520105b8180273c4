"""How the columns of one batch are worked out: strokes, sides of approach, where each begins and
ends."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from postproc.compensate import cutter, levels, sides, turning
from postproc.compensate.approach import resting
from postproc.compensate.arcs import points, quadrants
from postproc.compensate.columns import Columns
from postproc.compensate.increments import increments, rounded
from postproc.compensate.inverse import command
from postproc.flags import all_of, any_of
from postproc.machine.tip import TipMachine
from postproc.motions import CUTS, FREE, HOLE, RAPID, THREAD, Motions
from postproc.units import TICKS_PER_MM, in_mm, in_ticks

TICKS, ONE = np.array(float(TICKS_PER_MM)), np.array(1.0)  # without axes: postproc.units
NONE: np.ndarray = np.zeros(0, np.int64)  # no strokes


def _leashed(kept: int, own: int, most: int) -> int:
    """Ticks at which a stroke ends along which the correction of an axis may change by `most` only;
    as it was it would end at `kept`, and by its own at `own`."""
    return kept + min(max(own - kept, -most), most)


def written_centre(motions: Motions) -> np.ndarray:
    """(2, n) ticks from the start of each arc to its centre, exactly as written where it was
    written as I J K."""
    arcs = motions.arcs
    k = np.arange(len(arcs))
    rows = (np.maximum(axis, 0) for axis in (arcs.first, arcs.second))
    start = np.stack([motions.start[row, arcs.motion[k]] for row in rows])
    centre: np.ndarray = np.rint(arcs.centre * TICKS_PER_MM).astype(np.int64) - start
    return centre


class Batch(Columns):
    """The columns of one batch, and how each is worked out from others of them."""

    @cached_property
    def extremes(self) -> tuple[np.ndarray, np.ndarray]:
        """(Q,) the first stroke, and (A, Q) mm the place, of where corrected arcs lead farthest
        along an axis of their plane."""
        arcs = self.m.arcs
        arc, t = quadrants(arcs)
        inside = (t > 0) & (t < 1) & self.free.take(arcs.motion).take(arc)
        arc, t = arc.compress(inside), np.clip(t.compress(inside), 1e-12, 1 - 1e-12)
        place = points(arcs, self.arc_start, self.arc_target, arc, t)
        return np.searchsorted(self.motion, arcs.motion.take(arc)), place

    def strokes(self) -> None:
        """Motions, cut where a two-way axis turns back inside them: motion, t0, t1 (S,), travel (A,
        S) ticks."""
        m, whole = self.m, self.motion
        self.begin_nominal, self.end_nominal, self.passed = in_mm(m.start), in_mm(m.target), None
        if self.c.follows:
            self.motion, self.t0, self.t1 = turning.divided(self)
        if self.span != (0.0, 1.0):
            self.motion, self.t0, self.t1 = turning.within(self.motion, self.t0, self.t1, self.span)
        self.undivided = self.motion is whole
        if not self.undivided:
            self.passed = None
            self.begin_nominal = self.nominal(self.motion, self.t0)
            self.end_nominal = self.nominal(self.motion, self.t1)
        self._travel()
        if self.undivided:
            m.recall(self, (self.c, "strokes"), self._kinds)
        else:
            self._kinds()
        self.turns = cutter.last_way(self, self.travel) if self.inside else self.travel
        self.sure = np.empty(len(self.motion), bool)
        self.sure[:1], self.sure[1:] = self.carry.sure, self.sure_after[:-1]
        if self.leaps:
            self.sure &= ~self.jumps.any(axis=0)
        thread = self.code == THREAD
        if any_of(thread):
            self.cutting = self.cutting | self._led_to(thread)
        self.left = self.left_alone()

    def _led_to(self, thread: np.ndarray) -> np.ndarray:
        """(S,) bool: threads, of `thread` (S,), before which lost motion may be taken up by rapids:
        those that name their code; one behind another goes on in step with it."""
        m, behind = self.m, np.empty(len(thread), bool)
        behind[0], behind[1:] = self.carry.threading, thread[:-1]
        alone = self.of(m.inverse | (m.code_word < 0) | (m.cutter != FREE))
        led_to: np.ndarray = thread & self.moved & ~behind & ~alone
        return led_to

    def _kinds(self) -> None:
        """What strokes are, wherever they lead."""
        m = self.m
        self.last, self.code = self.t1 == ONE, self.of(m.code)
        self.inside = bool(np.count_nonzero(m.cutter))
        self.reads_beside = self.inside and cutter.reads_beside(self)
        self.known_before = self.of(self.start_known)
        # Strokes that begin where the last one did not end: something else (G28) moved the axis.
        self.jumps = self.of(self.jumped)
        if not self.undivided:
            self.known_before = self.known_before | (self.t0 > 0)
            self.jumps = self.jumps & (self.t0 == 0)
        self.hole = self.motion.searchsorted(m.holes.motion) if len(m.holes) else NONE
        # A motion that is left as it is moves the axes that it names; the others stay where they
        # were sent last.
        self.moved = free = self.of(self.free)
        sure = free & (self.code != HOLE) if len(m.holes) else free
        self.sure_after = sure & ~cutter.leaves_at_rest(self) if self.inside else sure
        # Strokes before which lost motion may be taken up.
        self.cutting = free & CUTS.take(self.code)
        if self.inside:
            self.cutting &= self.of(m.cutter) == FREE
        self.correctable = self.of(self.places.rows)  # (A, S) axes whose correction can be told

    def _travel(self) -> None:
        """`travel` (A, S) ticks, 0 where an end is not known; `forget` (A, S): axes that come from
        nowhere to a place that is known."""
        m = self.m
        travel = self.of(m.target - m.start)
        parts = (self.t1 - self.t0 != 1.0).nonzero()[0] if not self.undivided else ()
        if len(parts):
            way = self.end_nominal.take(parts, axis=1) - self.begin_nominal.take(parts, axis=1)
            travel[:, parts] = in_ticks(way)
        self.travel, self.forget = travel, self.of(self.places.wanting)
        if not self.places.every:
            sure = self.of(m.start_known & m.target_known)
            self.travel = np.where(sure, travel, 0)
            self.forget = ~sure & self.of(m.target_known & (m.word >= 0))

    def approach(self) -> None:
        """`weight_begin`, `weight_end` (A, S): sides of approach, -1 to +1, and `exact` (A, S) mm:
        the command of each stroke's end, as if nothing were held still. `sides`: what the next
        batch must know."""
        self.twice, self.against = np.zeros(self.travel.shape, bool), np.zeros_like(self.travel)
        if self.tip and self.c.follows:
            self.weight_end, self.sides = sides.of_slides(self)
        elif self.c.mode in ("step", "ramp"):
            self.weight_begin, self.weight_end, self.exact, self.sides = sides.follow(self)
            return
        else:
            self.weight_end, self.sides = np.zeros(self.travel.shape), self.carry.sides
        if self.c.mode == "off":
            self.weight_end, self.sides = sides.nominal_sides(self)
        self.weight_begin = self.weight_end
        which = self.moved.nonzero()[0]
        self.exact = self.end_nominal.copy()
        nominal = self.end_nominal.take(which, axis=1)
        weight = self.weight_end.take(which, axis=1)
        self.exact[:, which] = cutter.commands(self, which, self.t1[which], nominal, weight)

    def needed(
        self, stroke: np.ndarray, nominal: np.ndarray, weight: np.ndarray, t: np.ndarray
    ) -> np.ndarray:
        """(A, K) mm: exact commands at t (of the motion) along strokes.

        In mode off what differs at a stroke's begin fades along it: the reversal is spread over the
        block. In mode step an axis whose lost motion is followed goes from its begin to its end
        without turning back on the way.
        """
        if self.inside:
            weight = cutter.approach_on_arcs(self, stroke, t, weight)
        exact = cutter.commands(self, stroke, t, nominal, weight)
        if self.c.mode == "off":
            rest = (self.t1[stroke] - t) / (self.t1 - self.t0)[stroke]
            exact += self.differs.take(stroke, axis=1) * rest
        return self.led(stroke, exact)

    def led(self, stroke: np.ndarray, exact: np.ndarray) -> np.ndarray:
        """(A, K) mm: exact commands along strokes, an axis whose lost motion is followed not beyond
        its begin or end."""
        if len(self.c.followed):
            exact = exact.copy()
        for row in self.c.followed:
            one, two = self.begin[row, stroke] / TICKS_PER_MM, self.end[row, stroke] / TICKS_PER_MM
            held = np.minimum(np.maximum(exact[row], np.minimum(one, two)), np.maximum(one, two))
            exact[row] = np.where(self.m.cutter[self.motion[stroke]] == FREE, held, exact[row])
        return exact

    def grid(self, stroke: np.ndarray, exact: np.ndarray) -> np.ndarray:
        """(A, K) ticks: exact commands mm rounded once, half to even, to the least increment of
        each axis' word."""
        return rounded(exact, *increments(self, stroke))

    def ends(self) -> None:
        """`end` (A, S) ticks commanded at each stroke's end, as if nothing were held still."""
        m, free, step = self.m, self.moved, self.of(self.m.grid)
        correction = self.exact - self.end_nominal
        whole = np.rint(correction * TICKS / step.astype(float)).astype(np.int64) * step
        nominal_ticks = self.of(m.target)
        inner = NONE if self.undivided else (~self.last).nonzero()[0]
        if len(inner):
            nominal_ticks = np.where(self.last, nominal_ticks, in_ticks(self.end_nominal))
        self.nominal_end = nominal_ticks
        # A programmed word keeps its own decimals: its correction is rounded, not its sum.
        self.end = nominal_ticks + whole
        if len(inner):
            self.end[:, inner] = self.grid(inner, self.exact.take(inner, axis=1))
            on = np.array(self.fixed, np.int64)[:, None]
            self.end[on, inner] = self.grid(inner, self.end_nominal.take(inner, axis=1))[self.fixed]
        for row in self.fixed:
            self.end[row, self.last] = nominal_ticks[row, self.last]
        if not self.every:
            self.end = np.where(self.correctable & free, self.end, nominal_ticks)
        self.before = np.empty_like(self.end)
        self.before[:, 0], self.before[:, 1:] = self.carry.issued, self.end[:, :-1]
        if self.leaps:
            self.before = np.where(self.jumps, self.of(m.start), self.before)

    @cached_property
    def flipped(self) -> np.ndarray:
        """(A, S) bool: two-way axes that bear otherwise where a stroke begins, or along it, than
        behind the one before."""
        flipped: np.ndarray = self.turned | self.twice
        return flipped

    def starts(self) -> None:
        """`wanted` (A, S) ticks: where a stroke must be begun, for strokes (`turning`) whose start
        may differ."""
        self.turning = self.cutting & self.known_before
        if self.c.mode in ("mean", "off"):
            self.turning &= ~self.sure & (self.t0 == 0)
        else:
            self.turning &= np.logical_or.reduce(self.flipped, axis=0) | ~self.sure
        self.wanted = self.before
        which = self.turning.nonzero()[0]
        if not len(which):
            return
        exact = command(
            self.machine,
            self.begin_nominal.take(which, axis=1),
            self.weight_begin.take(which, axis=1),
            self.motion[which],
        )
        self.wanted = np.zeros(self.end.shape, np.int64)
        self.wanted[:, which] = self.grid(which, exact)
        for row in self.fixed:
            self.wanted[row] = self.before[row]
        self.wanted = np.where(self.correctable, self.wanted, self.before)

    # Whole: each row's ends hang on what the row before has settled.
    def settle_ends(self) -> None:
        """Hold still what stands still: an axis without nominal travel moves only when its
        correction has changed by more than half the tolerance. Sets `begin` (A, S), where each
        stroke is begun, and the final `before` and `end`."""
        free, known = self.moved, self.known_before
        held = np.logical_or.reduce(self.travel == 0, axis=1)
        self.leash = cutter.leash(self) if self.inside else None
        unknown = not self.every and not (all_of(known) and all_of(self.correctable))
        moved = any_of(self.turning) or any_of(self.left)
        if not (unknown or moved or any_of(held.take(self.c.at)) or self.leash is not None):
            self.begin = self.before
            return
        self.hold, rapid = np.full(len(free), self.c.hold * TICKS_PER_MM), self.code == RAPID
        if any_of(rapid):  # axes that rest may be left beside their places by all of the tolerance
            resting = np.maximum((self.travel[self.rows] == 0).sum(axis=0), 1)
            self.hold[rapid] = (self.c.inner / np.sqrt(resting) * TICKS_PER_MM)[rapid]
        # A slide that keeps its side is not moved back. Where lost motion builds up over a travel,
        # and in mode off, the side does not tell: there only the program's own motion is taken to
        # turn an axis.
        keeps = self.machine.two_way & (self.c.reach == 0) & (self.c.mode != "off")
        self.bound = keeps[:, None] & ~self.flipped & self.sure
        if isinstance(self.machine, TipMachine):
            self.bound &= self.machine.direct[:, None]
        if any_of(rapid) and any_of(self.c.overshoots):
            self.bound &= ~(self.c.overshoots[:, None] & rapid)
        self.begin = self.before.copy()
        for row in range(len(self.end)):
            end = self.end[row]
            if row in self.rows and (held[row] or any_of(self.left[row]) or self.leash is not None):
                rests = (self.travel[row] == 0) & free & known & (self.sure | self.turning)
                if len(self.m.holes):  # it goes down, and back to R
                    rests[self.hole[self.m.holes.axis == row]] = False
                if self.leash is not None:
                    rests |= (self.leash[row] < cutter.FREELY) & free & known
                still = (rests | self.left[row]).nonzero()[0]
                end[still] = self._held(row, still, end)
            before = self.before[row]
            before[0], before[1:] = self.carry.issued[row], end[:-1]
            if not self.every or self.leaps:
                lost = ~self.m.start_known[row].take(self.motion) | self.jumps[row]
                lost &= self.t0 == 0
                before[lost] = self._nominal_begin(row)[lost]
            self.begin[row] = before
            if any_of(self.turning):
                taken = self._taken_up(row, before)
                self.begin[row, taken] = self.wanted[row, taken]

    def _taken_up(self, row: int, before: np.ndarray) -> np.ndarray:
        """(S,) bool: strokes that an axis must begin elsewhere than `before` (S,): one of which
        forward lies beyond reverse goes back too if it hardly moves."""
        off = self.wanted[row] - before
        along = np.abs(off) > self.c.band[row]
        along &= self.c.overshoots[row] & (np.abs(self.travel[row]) <= self.c.band[row])
        back = self.bound[row] & ~along
        # Where forward lies beyond reverse the slide itself would go on beyond its turn by that. A
        # feed that leads along the axis, or nearly, says its side: it stays, and is beside no way.
        way = np.abs(self.travel.astype(float))
        across = np.sqrt(np.maximum((way[self.c.slides] ** 2).sum(axis=0) - way[row] ** 2, 0.0))
        along_it = across * np.abs(off) <= way[row] * self.c.chord * TICKS_PER_MM
        along_it &= way[row] > 2 * np.abs(off)  # it comes to where it stands
        back |= self.c.overshoots[row] & ~along & along_it & (self.code != THREAD)
        back &= off * self.weight_begin[row] < 0
        far: np.ndarray = self.turning & (np.abs(off) > self.c.chord * TICKS_PER_MM) & ~back
        return far

    # Whole: one loop in which each end rests where the one before left it.
    def _held(self, row: int, still: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(K,) ticks at which strokes `still` end, one after the other, since each rests where the
        one before left it."""
        turning = self.turning[still]
        before = np.where(still > 0, end[still - 1], self.carry.issued[row])
        onward = still > still[:1]
        if self.leaps:
            jumped = self.jumps[row, still]
            before = np.where(jumped, self.m.start[row, self.motion[still]], before)
            onward &= ~jumped
        onward[1:] &= still[1:] == still[:-1] + 1
        exact, hold = self.exact[row, still] * TICKS_PER_MM, self.hold[still]
        stays = self.left[row, still]
        side = self.bound[row, still] * self.weight_begin[row, still]
        # It rests where it is between these; what keeps its side is not moved back.
        low = np.where(stays | (side < 0), -np.inf, exact - hold)
        high = np.where(stays | (side > 0), np.inf, exact + hold)
        freely = np.full(len(still), cutter.FREELY)
        leash = freely if self.leash is None else self.leash[row, still]
        leashed = (leash < cutter.FREELY) & ~stays
        columns = onward, before, end[still], low, high, turning | leashed
        back = levels.origins(self, row) if len(self.m.holes) else {}
        if not (back or any_of(columns[-1])):
            return resting(*columns[:-1])
        value: list[int] = []
        here, enough = 0, self.c.chord * TICKS_PER_MM
        for goes_on, start, own, least, most, special in zip(
            *(column.tolist() for column in columns), strict=True
        ):
            if not goes_on:
                here = start
            k = len(value) if special or back else 0
            if back and int(still[k]) in back:
                here = levels.level(self, row, back[int(still[k])], still, value, end)
            if special and leashed[k]:
                here = _leashed(here + int(self.travel[row, still[k]]), own, int(leash[k]))
            else:
                if special:
                    wanted = int(self.wanted[row, still[k]])
                    off = wanted - here
                    if abs(off) > enough and off * side[k] >= 0:
                        here = wanted
                if not least <= here <= most:
                    here = own
            value.append(here)
        return np.array(value, np.int64)

    def _nominal_begin(self, row: int) -> np.ndarray:
        inside: np.ndarray = np.rint(self.begin_nominal[row] * TICKS_PER_MM).astype(np.int64)
        return np.where(self.t0 == 0, self.m.start[row, self.motion], inside)

    def spread_reversals(self) -> None:
        """Mode off: `differs` (A, S) mm, by how much each stroke's begin misses the command that it
        needs."""
        if self.c.mode == "off":
            which = (self.known_before & self.free[self.motion]).nonzero()[0]
            exact = command(
                self.machine,
                self.begin_nominal.take(which, axis=1),
                self.weight_begin.take(which, axis=1),
                self.motion[which],
            )
            self.differs = np.zeros_like(self.exact)
            self.differs[:, which] = self.begin.take(which, axis=1) / TICKS_PER_MM - exact
