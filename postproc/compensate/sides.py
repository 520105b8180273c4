"""The side on which each slide bears, stroke by stroke, and where the lost motion of the machine
then wants its command.

The wanted place of a slide is where the nominal path asks for it, all errors taken off but its own
lost motion; approach.py turns its course into sides. It depends a little on the sides themselves,
because the straightness and the angles of an axis may have been measured both ways. So each stroke
is decided in steps from what was before it: with the sides that the nominal motion alone gives,
then with the sides that follow from that. A whole batch is repeated until nothing changes; since a
stroke depends on earlier ones only, the answer is the same however the input is cut.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from postproc.compensate import levels
from postproc.compensate.approach import Sides, bear, hold_last, ramp
from postproc.compensate.columns import Columns
from postproc.compensate.cutter import commands
from postproc.compensate.depths import axis_of, down
from postproc.flags import all_of, any_of
from postproc.machine.tip import TipMachine
from postproc.motions import RAPID, THREAD
from postproc.records import replace
from postproc.units import TICKS_PER_MM, in_ticks

NOWHERE = np.array(2**61)  # ticks: no place to look at
TWO = np.array(2.0)


class Course:
    """How the two-way axes (T of them) of one batch are led: which strokes say their side by
    themselves, and which leave an axis where it is. `side` and `middle` (T, S) of approach.py;
    `exact` (A, S) mm, commands for these sides; `behind` (T, S) ticks, by how much a slide is held
    beside its wanted place because it has not turned by the hysteresis; `twice` (T, S): it bears
    otherwise where the stroke begins than along it; `against` (T, S) ticks: by how much it is taken
    back there against the way along it, since another axis changes its side."""

    begin: np.ndarray
    end: np.ndarray

    def __init__(self, b: Columns):
        self.b, self.rows = b, b.c.two_way
        self.band = b.c.band.take(self.rows)
        self.travel = b.travel.take(self.rows, axis=0)
        self.couples = b.machine.lateral > 0
        self._given()
        self.carry = self._begin()

    def _given(self) -> None:
        """Where a side is known whatever was before: a hole's axis has come up last; what comes
        from nowhere has none. `anew` (T, S): nor has what something else (G28) has taken elsewhere,
        until it goes on from there."""
        b, m = self.b, self.b.m
        sense, given = np.zeros(b.travel.shape, np.int64), b.forget | b.jumps
        if len(m.holes):
            sense[m.holes.axis, b.hole] = np.sign(m.holes.level - m.holes.bottom)
            given = given.copy()
            given[m.holes.axis, b.hole] = True
        # arcs inside G41 G42, not cut where an axis turns back: as their last part
        led = b.turns != b.travel
        if any_of(led) or any_of(b.jumps):
            sense = np.where(b.jumps | led, np.sign(b.turns), sense)
            given = given | led
        self.sense, self.given = sense.take(self.rows, axis=0), given.take(self.rows, axis=0)
        self.anew = (b.jumps & ~b.forget).take(self.rows, axis=0)
        if any_of(self.anew):
            self.start = b.m.start.take(self.rows, axis=0).take(b.motion, axis=1)
        stays = b.left if b.every else ~b.of(m.target_known) | b.left
        # Where forward lies beyond reverse an axis turns by being led beyond its place and back,
        # which no rapid does.
        if any_of(b.c.overshoots):
            stays = stays | (b.travel == 0) & (b.code == RAPID) & b.c.overshoots[:, None]
        # Before a thread that goes on from another nothing is put in: what rests is as it was.
        thread = (b.code == THREAD) & ~b.cutting
        if any_of(thread):
            stays = stays | (b.travel == 0) & thread
        self.stays = stays.take(self.rows, axis=0) & ~self.given
        self.ramped, self.given = self.given, self.given & ~self.anew

    def _begin(self) -> Sides:
        """The carry of these rows; an axis that has not stood anywhere yet begins where its first
        stroke does."""
        whole, rows = self.b.carry.sides, self.rows
        carry = Sides(
            side=whole.side.take(rows), middle=whole.middle.take(rows),
            taken=whole.taken.take(rows), located=whole.located.take(rows),
        )  # fmt: skip
        if all_of(carry.located):
            return carry
        place = in_ticks(self.b.end_nominal[rows, 0]) - self.travel[:, 0]
        return replace(carry, middle=np.where(carry.located, carry.middle, place))

    def before(self, column: np.ndarray, first: np.ndarray) -> np.ndarray:
        """(T, S) what a column (T, S) was before each stroke."""
        result = np.empty_like(column)
        result[:, 0], result[:, 1:] = first, column[:, :-1]
        return result

    @cached_property
    def leads(self) -> tuple[np.ndarray, np.ndarray]:
        """Two (T, S): the side that the nominal motion of a stroke gives by itself, and whether it
        gives one."""
        moves = (np.abs(self.travel) > self.band[:, None]) & ~self.stays
        way = np.sign(self.travel)
        if not any_of(self.given):
            return way, moves
        return np.where(self.given, self.sense, way), moves | self.given

    def spread(self, side: np.ndarray) -> np.ndarray:
        """(A, K) float sides of all axes."""
        if len(self.rows) == len(self.b.travel):
            return side.astype(float)
        every = np.zeros((len(self.b.travel), side.shape[1]))
        every[self.rows] = side
        return every

    def commands(self, at: np.ndarray, side: np.ndarray) -> np.ndarray:
        """(A, K) mm of strokes `at` (K,) for sides (T, K)."""
        b = self.b
        if b.plain and len(at) == len(b.motion):
            return commands(b, at, b.t1, b.end_nominal, self.spread(side))
        result = b.end_nominal.take(at, axis=1)
        free = b.moved.take(at).nonzero()[0]
        if len(free):
            at, weight = at.take(free), self.spread(side.take(free, axis=1))
            found = commands(b, at, b.t1.take(at), b.end_nominal.take(at, axis=1), weight)
            correctable = b.correctable.take(at, axis=1)
            if not all_of(correctable):
                found = np.where(correctable, found, result.take(free, axis=1))
            result[:, free] = found
        return result

    def places(
        self, at: np.ndarray, side: np.ndarray, before: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`exact` (A, K), `begin` and `end` (T, K) ticks of strokes `at` (K,) for sides (T, K)
        behind sides `before` (T, K): the commands, and where the slides are to stand at the begin
        and at the end, which is the command without their own lost motion. Where no axis changes
        its side, or all of them can not move one another, the begin is the end before, and not
        looked at, but for where nothing was corrected before; nor is it in rapids, which take
        nothing up."""
        b = self.b
        exact = self.commands(at, side)
        if len(b.hole):
            self._down(at, side, exact)
        begin = np.empty(side.shape, np.int64)
        begin.fill(NOWHERE)
        turned = ~b.sure.take(at)
        if self.couples:
            turned |= np.logical_or.reduce(side != before, axis=0)
        here = (turned & (b.cutting & b.known_before).take(at)).nonzero()[0]
        if len(here):
            there, led = at.take(here), side.take(here, axis=1)
            nominal, weight = b.begin_nominal.take(there, axis=1), self.spread(led)
            first = commands(b, there, b.t0.take(there), nominal, weight)
            begin[:, here] = self._without_play(led, first)
        end = self._without_play(side, exact)
        if len(b.hole):
            self._up(at, side, exact, end)
        return exact, begin, end

    def _down(self, at: np.ndarray, side: np.ndarray, exact: np.ndarray) -> None:
        """The others are held over the depth of a hole, for the middle of what corrects them along
        it: in `exact` (A, K) of strokes `at` (K,) for sides (T, K)."""
        b, holes = self.b, self.b.m.holes
        which = (holes.place & b.free[holes.motion]).nonzero()[0]
        for k in which[np.isin(b.hole[which], at)].tolist():
            n = at.searchsorted(b.hole[k])
            target, found = down(b, k, self.spread(side[:, n : n + 1]))
            axis = axis_of(b.machine, found, target, int(holes.axis[k]))
            exact[axis.across, n] = b.end_nominal[axis.across, b.hole[k]] + axis.middle

    @cached_property
    def back(self) -> np.ndarray:
        """(S,) mm commanded of the axis of each hole behind it."""
        back = np.zeros(len(self.b.motion))
        back[self.b.hole] = levels.back(self.b) / TICKS_PER_MM
        return back

    def _up(self, at: np.ndarray, side: np.ndarray, exact: np.ndarray, end: np.ndarray) -> None:
        """Behind a hole its axis stands where the control goes back to, for which nothing corrects
        it: in `end` (T, K) of strokes `at` (K,) for sides (T, K) with commands `exact` (A, K)."""
        b, holes = self.b, self.b.m.holes
        own = np.zeros(b.travel.shape, bool)
        own[holes.axis, b.hole] = True
        own = (own & b.moved).take(self.rows, axis=0).take(at, axis=1)
        up = own.any(axis=0).nonzero()[0]
        if len(up):
            own, place = own.take(up, axis=1), exact.take(up, axis=1)
            place[self.rows] = np.where(own, self.back[at.take(up)], place[self.rows])
            above = self._without_play(side.take(up, axis=1), place)
            end[:, up] = np.where(own, above, end.take(up, axis=1))

    def _without_play(self, side: np.ndarray, exact: np.ndarray) -> np.ndarray:
        play = self.b.machine.lost_motion(exact, self.rows)
        return in_ticks(exact.take(self.rows, axis=0) - side * play / TWO)

    def once(self, at: np.ndarray, before: np.ndarray, middle: np.ndarray) -> np.ndarray:
        """(T, K) the side of each stroke `at` (K,) by itself, from side and state (T, K) before
        it."""
        half, r, led = (self.band // 2)[:, None], middle, before
        if any_of(self.anew):
            anew = self.anew.take(at, axis=1)
            r, led = np.where(anew, self.start.take(at, axis=1), r), np.where(anew, 0, led)
        begin, end = self.begin.take(at, axis=1), self.end.take(at, axis=1)
        stays = self.stays.take(at, axis=1)
        for where, here in ((begin, begin != NOWHERE), (end, True)):
            now = np.where(here, np.minimum(np.maximum(r, where - half), where + half), r)
            way = np.sign(now - r)
            led, r = np.where((way != 0) & ~stays, way, led), now
        return np.where(self.given.take(at, axis=1), self.sense.take(at, axis=1), led)

    def bear(self) -> tuple[np.ndarray, np.ndarray]:
        """(T, S) side and state behind each stroke, of wanted places at begins and ends."""
        begin, end = self.begin, self.end
        self.twice, self.against = np.zeros(end.shape, bool), np.zeros_like(end)
        anew = any_of(self.anew)
        if not (anew or any_of(begin != NOWHERE)):
            return bear(end, self.band, self.sense, self.given, self.stays, self.carry)
        none = np.zeros_like(self.given)
        # of each stroke: place, sense, given, stays, where it begins and where it ends
        steps = [(begin, self.sense, none, begin == NOWHERE), (end, self.sense, self.given, none)]
        if anew:
            steps.insert(0, (self.start, 0 * self.sense, self.anew, ~self.anew))
        n = len(steps)
        place, sense, given, stays = (
            np.stack(p, axis=2).reshape(len(self.rows), -1) for p in zip(*steps, strict=True)
        )
        stays |= np.repeat(self.stays, n, axis=1)
        side, middle = bear(place, self.band, sense, given, stays, self.carry)
        led, there = side[:, n - 1 :: n], middle[:, n - 2 :: n]
        before = middle[:, ::n] if anew else self.before(middle[:, 1::2], self.carry.middle)
        own = (begin != NOWHERE) & ~self.given
        self.twice = (side[:, n - 2 :: n] != led) & own
        off = there - before
        self.against = np.where(own & (off * led < 0), off, 0)
        return led, middle[:, n - 1 :: n]

    def settle(self) -> None:
        """Decide side, middle, exact and behind: first all strokes as the nominal motion leads
        them; then, until nothing changes, those that bear otherwise or come after another side or
        state than was thought."""
        led = hold_last(*self.leads, self.carry.side)
        before, every = self.before(led, self.carry.side), np.arange(led.shape[1])
        self.led, (self.exact, self.begin, self.end) = led, self.places(every, led, before)
        side, middle = self.bear()
        off = side != led
        open_ = off.any(axis=0) if any_of(off) else np.zeros(0, bool)
        open_ = open_ | _behind(open_) if len(open_) else open_
        while any_of(open_):
            self._decide(open_.nonzero()[0], side, middle)
            found, now = self.bear()
            open_ = _behind(((found != side) | (now != middle)).any(axis=0))
            side, middle = found, now
        other = side != self.led
        if any_of(other):
            at = other.any(axis=0).nonzero()[0]
            self.exact[:, at] = self.commands(at, side.take(at, axis=1))
        self.side, self.middle = side, middle
        held = middle + side * (self.band // 2)[:, None]
        self.behind = held - self.end
        if any_of(self.given) or any_of(self.stays):
            self.behind = np.where(self.given | self.stays, 0, self.behind)

    def _decide(self, at: np.ndarray, side: np.ndarray, middle: np.ndarray) -> None:
        """The sides of strokes `at` (K,) from sides and states (T, S): first as its nominal motion
        leads each, then as often as it leads elsewhere."""
        before, r = (
            self.before(column, first).take(at, axis=1)
            for column, first in ((side, self.carry.side), (middle, self.carry.middle))
        )
        sign, leads = (column.take(at, axis=1) for column in self.leads)
        led = np.where(leads, sign, before)
        for _ in range(len(self.rows) + 1):  # as many as axes can move one another, in turn
            self.led[:, at] = led
            self.exact[:, at], self.begin[:, at], self.end[:, at] = self.places(at, led, before)
            found = self.once(at, before, r)
            on = (found != led).any(axis=0).nonzero()[0]
            if not len(on):
                break
            at = at.take(on)
            before, r, led = (column.take(on, axis=1) for column in (before, r, found))


def _behind(which: np.ndarray) -> np.ndarray:
    """(S,) bool: the strokes behind some (S,)."""
    result = np.zeros(len(which), bool)
    result[1:] = which[:-1]
    return result


def of_slides(b: Columns) -> tuple[np.ndarray, Sides]:
    """(A, S) sides where words are places of the tool tip, and what the next batch must know: each
    slide's own way, its errors taken off but its lost motion, as `follow` has it of words that are
    places of slides."""
    assert isinstance(b.machine, TipMachine)
    ends = b.known[b.motion]
    given = ~(b.known_before & ends) | b.jumps.any(axis=0)
    place = np.zeros(b.travel.shape, np.int64)
    which = ends.nonzero()[0]
    if len(which):
        nominal = b.end_nominal.take(which, axis=1)
        wanted = commands(b, which, b.t1[which], nominal, np.zeros_like(nominal))
        place[:, which] = np.rint(b.machine.slides(wanted) * TICKS_PER_MM).astype(np.int64)
    carry = b.carry.sides
    if not carry.located.all() and b.known_before[0]:
        begin = np.rint(b.machine.slides(b.begin_nominal[:, :1])[:, 0] * TICKS_PER_MM).astype(
            np.int64
        )
        carry = replace(carry, middle=np.where(carry.located, carry.middle, begin))
    lost = np.broadcast_to(given, place.shape)
    side, middle = bear(place, b.c.band, np.zeros_like(place), lost, np.zeros_like(lost), carry)
    side = np.where(b.machine.two_way[:, None], side, 0)
    located = carry.located | bool(ends.any())
    return side.astype(float), replace(
        carry, side=side[:, -1], middle=middle[:, -1], located=located
    )


def nominal_sides(b: Columns) -> tuple[np.ndarray, Sides]:
    """(A, S) sides from the nominal motion alone, without hysteresis, and what the next batch must
    know (mode off)."""
    course = Course(b)
    course.begin = np.full(course.travel.shape, NOWHERE)
    course.end = np.rint(b.end_nominal[course.rows] * TICKS_PER_MM).astype(np.int64)
    course.band = np.zeros_like(course.band)
    side, middle = course.bear()
    return course.spread(side), carried(b, course, side, middle)


def carried(
    b: Columns,
    course: Course,
    side: np.ndarray,
    middle: np.ndarray,
    taken: np.ndarray | None = None,
) -> Sides:
    """What the next batch must know."""
    s = b.carry.sides
    after = [s.side.copy(), s.middle.copy(), s.taken.copy()]
    for whole, part in zip(after, (side, middle, taken), strict=True):
        if part is not None:
            whole[course.rows] = part[:, -1]
    located = s.located
    if not all_of(located):
        located = located | b.m.target_known.any(axis=1)
    return Sides(side=after[0], middle=after[1], taken=after[2], located=located)


def follow(b: Columns) -> tuple[np.ndarray, np.ndarray, np.ndarray, Sides]:
    """Of each stroke: (A, S) share of the lost motion at its begin and at its end, -1 to +1, and
    (A, S) mm the command of its end, as if nothing were held still; and what the next batch must
    know."""
    course = Course(b)
    course.settle()
    side = course.spread(course.side)
    begin, end, taken = side, side, None
    if b.c.ramped:
        begin, end, taken = _ramps(b, course, side)
        which = b.free[b.motion].nonzero()[0]
        exact = b.end_nominal.copy()
        nominal = b.end_nominal.take(which, axis=1)
        exact[:, which] = commands(b, which, b.t1[which], nominal, end.take(which, axis=1))
        course.exact = exact
    exact = course.exact
    b.twice, b.against = np.zeros(side.shape, bool), np.zeros_like(b.travel)
    # An axis that moves by less than it is taken back by does not come to its side along a stroke;
    # where nothing was corrected before, the way to the first corrected place turns any.
    ways = np.maximum(course.band[:, None], np.abs(course.against))
    alone = course.twice & ((np.abs(course.travel) <= ways) | ~b.sure)
    b.against[course.rows] = np.where(alone, 0, course.against)
    b.twice[course.rows] = alone | (course.against != 0)
    if np.count_nonzero(course.behind):
        holds = (b.c.reach[course.rows] == 0)[:, None] & b.moved
        exact[course.rows] += np.where(holds, course.behind, 0) / TICKS_PER_MM
    return begin, end, exact, carried(b, course, course.side, course.middle, taken)


def _ramps(
    b: Columns, course: Course, side: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares of the axes that take lost motion up over some travel of their own. Where the option
    alone asks for a ramp, an axis that rests is taken up at once: there its motor moves alone, and
    nothing is cut."""
    rows, reach = course.rows, b.c.reach[course.rows]
    rests = (course.travel == 0) & ~course.stays & (b.c.mode == "ramp")
    value = np.where(rests, course.side, course.sense) * reach[:, None]
    taken = ramp(course.travel, course.ramped | rests, value, reach, course.carry.taken)
    before = np.where(rests, taken, course.before(taken, course.carry.taken))
    unit = 1.0 / np.maximum(reach, 1)[:, None]
    begin, end = side.copy(), side.copy()
    ramped = reach > 0
    begin[rows[ramped]] = (before * unit)[ramped]
    end[rows[ramped]] = (taken * unit)[ramped]
    return begin, end, taken
