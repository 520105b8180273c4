"""What a control draws of an arc as it will be written, and whether that is near enough to what
is wanted.

A circle through the two commanded ends is fitted, and the distance of every sample from the
circle that the control will draw measured: about the centre that it computes from R and the ends
as written where the arc is written with R (the programmed number if that will do, else a new
one), else about I J rounded as they will be written. R near half a turn moves the centre by many
times its own rounding: the same proof sends such arcs to I J. Radii of start and end keep the
difference that they had, and a full circle ends where it begins to the last digit or is cut.

The distance in the plane and that along the third axis stand at right angles, so it is both
together that must stay within the tolerance. A slide that lost motion holds back (by the
hysteresis at most) is off already, so that there each of both keeps to its own share."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from postproc.compensate.arc_rows import Fitter, Rows
from postproc.compensate.arcs import direction, height
from postproc.compensate.samples import Samples, bent, beyond
from postproc.motions import centre_by_radius
from postproc.records import replace
from postproc.units import TICKS_PER_MM

TURN = 2 * np.pi
SAME_ANGLE = 1e-9  # rad: below what two ends one tick apart make of any arc within travel
EXACT = 1e-9  # mm: what a square root leaves of half a turn
SMALLEST_RADIUS = 0.002  # mm: controls take less for none
FLAT = 16  # least increments of bow: half of one at both ends changes the radius by a sixteenth
LARGEST_SWEEP = np.radians(300.0)  # of an arc inside cutter radius compensation
# Sixteenths of a run, whose samples its centre is fitted to: nearly evenly spaced.
FITTED, SIXTEENTH = np.array([[3], [5], [8], [11], [13]]), np.array(4)
ANYWHERE, TURNED = np.array([[1.0], [0.0]]), np.array([[-1.0], [1.0]])
NEIGHBOURS = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3))).reshape(2, 25)


def turns(sweep: np.ndarray) -> np.ndarray:
    """(R,) full turns before the last one, which may be full itself: what P counts beyond the
    first."""
    turns: np.ndarray = np.maximum(np.ceil(np.abs(sweep) / TURN - SAME_ANGLE) - 1, 0)
    return turns


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products of (2, ...) vectors."""
    dot: np.ndarray = a[0] * b[0] + a[1] * b[1]
    return dot


def _multiple(value: np.ndarray, part: np.ndarray, weighed: np.ndarray) -> np.ndarray:
    """(R,) how many times parts (K, R) come nearest to values (K, R), by least squares; weighed:
    the parts times their weights."""
    size = (part * weighed).sum(axis=0)
    result: np.ndarray = (value * weighed).sum(axis=0) / np.where(size > 0, size, 1.0)
    return result


Most = float | np.ndarray


class Proof:
    """R runs of samples, from `low` to `high` (R,), to be written as arcs `rows`. All places are
    mm from the nominal centre: begin, end (2, R) as written. The samples stand run behind run, each
    with one more on both sides, which tells how much the command bends at its ends. excess (R,):
    the farthest place of what was tried, as a share of the limit, 0: not known."""

    def __init__(self, f: Fitter, rows: Rows, samples: Samples, low: np.ndarray, high: np.ndarray):
        self.f, self.rows, self.low, self.high = f, rows, low, high
        self.samples = samples
        arcs, arc = f.arcs, rows.arc
        self.arc, self.centre = arc, arcs.centre.take(arc, axis=1)
        axes = (samples.first, samples.second)
        self.begin = rows.begin.take(axes, axis=0) / TICKS_PER_MM - self.centre
        self.end = rows.end.take(axes, axis=0) / TICKS_PER_MM - self.centre
        self.unit0, self.unit1 = samples.unit.take(low, axis=1), samples.unit.take(high, axis=1)
        self.part = rows.t1 - rows.t0
        self.sweep, self.grown = arcs.sweep.take(arc) * self.part, f.grown.take(arc)
        self.turns, self.whole = turns(self.sweep), (rows.t0 == 0) & (rows.t1 == 1)
        self.radius, self.grid = arcs.radius.take(arc), arcs.grid.take(arc, axis=1)
        self.written = f.kinds[0] and bool(np.count_nonzero(arcs.by_radius.take(arc)))
        self.inside = f.kinds[2] and bool(np.count_nonzero(f.inside.take(arc)))
        self.count = high - low + 1
        whole = low[0] == 0 and high[-1] == len(samples.t) - 1
        if whole and np.array_equal(low[1:], high[:-1] + 1):  # all samples: nothing lies beside
            self.s, self.edges, self.runs = samples, low, 1
        else:
            self.s, self.runs = self._taken(samples), 2
        self.share = self.s.t - self._each(rows.t0)
        self.share *= self._each(1.0 / self.part)
        self.half = np.minimum(*self.grid) / TICKS_PER_MM / 2
        self.limit = f.total + self.half - samples.rest  # below 0: more may hide than is allowed
        self.excess = np.zeros(len(rows))

    def _taken(self, samples: Samples) -> Samples:
        """The samples of the runs, with those beside them; sets `count` and `edges`."""
        self.count += 2
        behind = np.cumsum(self.count)
        begin = behind - self.count
        self.edges = np.stack([begin + 1, behind - 1], axis=1).ravel()
        at = np.arange(behind[-1]) + self._each(self.low - 1 - begin)
        at[begin] = np.maximum(self.low - 1, samples.begin)
        at[behind - 1] = np.minimum(self.high + 1, samples.last)
        taken = samples.at(at)
        taken.smooth[begin] = taken.smooth[behind - 1] = 0.0  # these lie beside another run
        taken.turn[:, self.edges - 1] = 0.0  # from the last of each run and from beside it
        return taken

    def _each(self, value: np.ndarray) -> np.ndarray:
        """(..., N) the value (..., R) of its run for each sample."""
        return value.repeat(self.count, axis=-1)

    def run(self) -> np.ndarray:
        """(R,) whether an arc will do; `rows` then have its centre and its R word."""
        rows = self.rows
        good, radius = np.zeros(len(rows), bool), np.zeros(len(rows), np.int64)
        centre = np.zeros((2, len(rows)), np.int64)
        for there, word, most, kept in self._candidates():
            tried = ~good & np.isfinite(there[0])
            if not np.count_nonzero(tried):
                continue
            held, excess = self._holds(there, most, kept)
            # of a run that needs no more of it, or has none of it, the others must not tell
            self.excess = np.where(tried, excess, self.excess)
            holds = (~good & held).nonzero()[0]
            way = there.take(holds, axis=1) - self.begin.take(holds, axis=1)
            centre[:, holds] = np.rint(way * TICKS_PER_MM).astype(np.int64)
            radius[holds], good[holds] = word[holds], True
            if np.count_nonzero(good) == len(good):
                break
        self.rows = replace(rows, centre=centre, radius=radius)
        return good

    def straight(self) -> np.ndarray:
        """(R,) whether every axis stays near enough to the straight line between its ends for a
        chord."""
        straight, s = np.ones(len(self.rows), bool), self.s
        in_plane = zip((s.first, s.second), s.place + self._each(self.centre), strict=True)
        for axis, command in (*in_plane, *zip(s.beside, s.across, strict=True)):
            half = self.f.step[axis, self.arc] / TICKS_PER_MM / 2  # the ends are rounded already
            bow = self._largest(np.abs(self._bow(axis, command)))
            straight &= bow <= self.f.tolerance_across + half
        return straight

    def _bow(self, axis: int, command: np.ndarray) -> np.ndarray:
        """(N,) mm by which the command (N,) of an axis leaves the straight line between its
        ends."""
        begin, end = self.rows.begin[axis] / TICKS_PER_MM, self.rows.end[axis] / TICKS_PER_MM
        bow = self._each(begin - end)
        bow *= self.share
        bow += command
        bow -= self._each(begin)
        return bow

    def _largest(self, value: np.ndarray) -> np.ndarray:
        """(R,) largest of (N,) sizes over each run."""
        return np.maximum.reduceat(value, self.edges)[:: self.runs]

    def _candidates(self) -> Iterator[tuple[np.ndarray, np.ndarray, Most, np.ndarray]]:
        """(2, R) mm centres as the control will have them, nan for none, (R,) the R words that make
        them, the mm that each may miss the samples in the plane, and (R,) whether it is taken
        whatever it misses; best first: R as programmed,
        held like an axis at rest while that costs half of the tolerance at most, R as fitted, the
        centre as fitted, and the one that keeps the radius (in an arc so short that a micrometre of
        rounding outweighs its whole bow the fit knows no radius)."""
        f, exact, none = self.f, self._fitted(), np.zeros(len(self.rows), np.int64)
        never = none.astype(bool)
        if self.written:
            programmed, fitted = self._radius_words(exact)
            yield self._drawn(programmed), programmed, f.tolerance / 2 + self.half, never
            yield self._drawn(fitted), fitted, np.inf, never
        if f.kinds[1]:  # where that is so, no arc by a centre is there
            yield self._drawn(programmed), programmed, np.inf, self._kept()
            alone = f.arcs.radius_alone[self.arc]
            exact = np.where(alone, np.nan, exact)
        yield self._rounded(exact), none, np.inf, never
        if self.inside:
            kept = self._kept()
            yield self._as_wide(exact), none, np.inf, kept
            yield self._rounded(exact), none, np.inf, kept
        flat = ~np.isnan(exact[0]) & (
            self._sagitta() < FLAT * np.maximum(*self.grid) / TICKS_PER_MM
        )
        if not flat.any():
            return
        radius = self.radius * np.where(np.abs(self.sweep) > np.pi, -1, 1)
        same = centre_by_radius(self.begin, self.end, radius, self.sweep > 0)
        yield np.where(flat, self._rounded(same), np.nan), none, np.inf, never

    def _sagitta(self) -> np.ndarray:
        """(R,) mm by which each run leaves its chord."""
        sweep = np.minimum(np.abs(self.sweep), TURN)
        bow: np.ndarray = self.radius * height(sweep)
        return bow

    def _rounded(self, centre: np.ndarray) -> np.ndarray:
        """(2, R) mm: centres as I J K will say them: whole increments from the programmed words."""
        base = np.where(self.rows.t0 == 0, self.f.base.take(self.arc, axis=1), 0)
        grid = self.grid
        way = base + np.rint(((centre - self.begin) * TICKS_PER_MM - base) / grid) * grid
        result: np.ndarray = self.begin + way / TICKS_PER_MM
        return result

    def _fitted(self) -> np.ndarray:
        """(2, R) mm: the centre whose circle through the written begin passes five samples
        between best, by least squares in the radial shifts; where the row ends elsewhere than it
        begins, it passes the written end too."""
        s, rows = self.samples, self.rows
        at = self.low + ((self.high - self.low) * FITTED >> SIXTEENTH)
        way, left = s.unit.take(at, axis=1), s.radial.take(at)
        way -= self.unit0[:, None]
        places = (self.unit0, self.begin, rows.t0), (self.unit1, self.end, rows.t1)
        ends = [dot(one, place) - self.radius - self.grown * t for one, place, t in places]
        chord = self.unit1 - self.unit0
        length = np.sqrt(dot(chord, chord))
        open_ = length > SAME_ANGLE
        closed = np.count_nonzero(open_) < len(open_)
        safe = np.where(open_, length, 1.0) if closed else length
        along = np.where(open_, chord / safe, ANYWHERE) if closed else chord / safe
        across = along[::-1] * TURNED
        g = dot(across, way)
        left -= ends[0]
        move_along = (ends[1] - ends[0]) / safe
        if closed:
            f, which = dot(along, way), ~open_
            pairs = (f, f), (g, g), (f, g), (f, left), (g, left)
            ff, gg, fg, fh, gh = ((a * b).sum(axis=0) for a, b in pairs)
            free = ff * gg - fg**2
            move_along[which] = ((fh * gg - gh * fg) / np.where(free > 0, free, 1.0))[which]
        moved = along * move_along
        left -= dot(moved, way)
        off = _multiple(left, g, g)
        # Once more, a miss counting by its size: nearer to the least largest one (C. L. Lawson).
        off = _multiple(left, g, g * (np.abs(left - off * g) + EXACT))
        result: np.ndarray = moved + across * off
        return result

    def _radius_words(self, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(R,) ticks twice: what R may be, 0 in arcs that have none: the programmed number, and the
        fitted one as rounded."""
        own = self.f.arcs.by_radius[self.arc]
        sign = np.where(self.whole, np.sign(own), np.where(np.abs(self.sweep) > np.pi, -1, 1))
        sign *= own != 0
        step = np.maximum(*self.grid)
        exact = np.hypot(*(self.begin - centre)) * TICKS_PER_MM
        rounded = np.abs(own) + np.rint((exact - np.abs(own)) / step).astype(np.int64) * step
        return sign * np.abs(own), sign * rounded

    def _drawn(self, word: np.ndarray) -> np.ndarray:
        """(2, R) mm: the centre that a control computes from R `word` (R,) ticks and the written
        ends; nan where it has none, or where R is shorter than half the way by more than the
        programmed one was."""
        half = np.hypot(*(self.end - self.begin)) / 2
        radii = [self.radius + self.grown * t for t in (self.rows.t0, self.rows.t1)]
        nominal = np.hypot(*(radii[1] * self.unit1 - radii[0] * self.unit0)) / 2
        short = np.maximum(nominal - np.abs(self.f.arcs.by_radius[self.arc]) / TICKS_PER_MM, EXACT)
        radius = word / TICKS_PER_MM
        reaches = (word != 0) & (half > 0) & (half - np.abs(radius) <= short)
        centre = centre_by_radius(self.begin, self.end, radius, self.sweep > 0)
        return np.where(reaches, centre, np.nan)

    def _kept(self) -> np.ndarray:
        """(R,) bool: inside cutter radius compensation, and too short to be cut, whatever that
        leaves."""
        way = np.abs(self.sweep) * self.radius
        result: np.ndarray = self.f.inside[self.arc] & (way < 2 * self.f.shortest[self.arc])
        return result

    def _least(self) -> np.ndarray:
        """(R,) ticks that the radius must have at least: inside cutter radius compensation the
        tool must fit on the inside of an arc; where its radius is not known, as it did."""
        arcs, arc = self.f.arcs, self.arc
        step, tool = np.maximum(*self.grid), self.f.tool[arc] * TICKS_PER_MM
        radius = np.minimum(arcs.radius, arcs.radius_end)[arc] * TICKS_PER_MM
        least = np.minimum(radius, np.where(tool > 0, tool + step, 0.0))
        least = np.where(np.isfinite(tool), least, radius)
        return np.where(self.f.inside[arc], least - 0.5, 0.0)

    def _as_wide(self, centre: np.ndarray) -> np.ndarray:
        """(2, R) mm: centres near the fitted ones that leave arcs inside cutter radius
        compensation wide enough; nan for other arcs and where there is none."""
        arcs, arc = self.f.arcs, self.arc
        grid, chord = self.grid, (self.end - self.begin) * TICKS_PER_MM
        exact, least = (centre - self.begin) * TICKS_PER_MM, self._least()
        radius = np.minimum(arcs.radius, arcs.radius_end)[arc] * TICKS_PER_MM
        narrow = np.minimum(np.hypot(*exact), np.hypot(*(chord - exact))) < least - grid.max(axis=0)
        exact = np.where(narrow, -radius * self.unit0, exact)  # moved as it is
        tried = (np.rint(exact / grid) * grid)[:, None] + NEIGHBOURS[:, :, None] * grid[:, None]
        fits = np.minimum(np.hypot(*tried), np.hypot(*(chord[:, None] - tried))) >= least
        cost = np.where(fits & self.f.inside[arc], np.hypot(*(tried - exact[:, None])), np.inf)
        best, column = np.argmin(cost, axis=0), np.arange(len(arc))
        found = self.begin + tried[:, best, column] / TICKS_PER_MM
        return np.where(np.isfinite(cost[best, column]), found, np.nan)

    def _holds(
        self, centre: np.ndarray, most: Most, kept: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """(R,) whether the arcs about `centre` (2, R) mm through the written ends keep the
        tolerance, and `most` mm in the plane, or are `kept` (R,) whatever that leaves, and are
        arcs to a control; and (R,) the farthest place as a share of the limit."""
        f, there = self.f, np.isfinite(centre[0])
        centre = np.where(there, centre, 0.0)  # one run must not reach into the next
        radius0, radius1 = (np.sqrt(dot(a, a)) for a in (self.begin - centre, self.end - centre))
        turned, closed = self._turned(centre)
        good, excess = self._near(centre, radius0, radius1, turned, most)
        good = (good | kept) & there
        # Rounding must not turn a sliver into a circle, nor a circle into a sliver.
        good &= np.abs(turned - self.sweep) < np.minimum(0.5 * np.abs(self.sweep), np.pi)
        full = np.abs(self.sweep / TURN - np.rint(self.sweep / TURN)) < SAME_ANGLE
        good &= closed | ~full
        good &= (self.turns == 0) | (f.single[self.arc] & self.whole)
        good &= np.minimum(radius0, radius1) > SMALLEST_RADIUS
        if self.inside:
            wide = np.minimum(radius0, radius1) * TICKS_PER_MM >= self._least()
            good &= wide | kept
            good &= ~(f.inside[self.arc] & (np.abs(self.sweep) > LARGEST_SWEEP))
        was = np.abs(self.grown) * self.part
        # Together they must stay below the control's limit, twice the mismatch; what misses by more
        # already, by no more.
        good &= np.abs(radius1 - radius0) <= np.where(was <= f.mismatch, was + f.mismatch, was)
        return good, excess

    def _near(
        self,
        centre: np.ndarray,
        radius0: np.ndarray,
        radius1: np.ndarray,
        turned: np.ndarray,
        most: Most,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(R,) whether what is drawn stays within the tolerance of what is wanted, between
        samples too, and (R,) the farthest place as a share of the limit."""
        s, helix = self.s, self._helix()
        some = np.count_nonzero(helix) > 0
        away = self._each(centre)
        x, y = np.subtract(s.place, away, out=away)
        radius = self._each(radius1 - radius0)
        radius *= self.share
        radius += self._each(radius0)
        if some:
            # The other axes are tied to the angle: being ahead is as wrong as being beside.
            begin = np.arctan2(*(self.begin - centre)[::-1])
            angle = self._each(begin) + self._each(turned) * self.share
            cosine, sine = direction(angle)
            ahead = np.hypot(x - radius * cosine, y - radius * sine)
        x *= x
        y *= y
        x += y
        off = np.sqrt(x, out=x)
        off -= radius
        if some:
            off = np.where(self._each(helix), ahead, off)
        turn = bent(off, s.smooth)
        turn[self.edges - 1] = 0.0
        off = np.abs(off) + beyond(off, turn)
        good = np.ones(len(self.rows), bool)
        if np.ndim(most) or most < np.inf:
            good &= self._largest(off) <= most
        if len(self.f.followed):
            good &= self._largest(off) <= self.f.tolerance + self.half
            for axis, bow in zip(s.beside, self._bows, strict=True):
                half = self.f.step[axis, self.arc] / TICKS_PER_MM / 2
                good &= self._largest(bow) <= self.f.tolerance_across + half
        off *= off
        for bow in self._bows:
            off += bow * bow
        excess = np.sqrt(self._largest(off)) / np.maximum(self.limit, EXACT)
        return good & (excess <= 1.0), excess

    @cached_property
    def _bows(self) -> list[np.ndarray]:
        """(N,) mm by which each axis beside the plane leaves its straight line at most, between
        samples too."""
        found = []
        for axis, command, turn in zip(self.s.beside, self.s.across, self.s.turn, strict=True):
            bow = self._bow(axis, command)
            found.append(np.abs(bow) + beyond(bow, turn))
        return found

    def _turned(self, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(R,) rad that a control turns about `centre`, and whether it ends where it begins: then
        it makes a full turn."""
        closed = (self.begin[0] == self.end[0]) & (self.begin[1] == self.end[1])
        counter = np.where(self.sweep > 0, 1.0, -1.0)
        (x0, y0), (x1, y1) = self.begin - centre, self.end - centre
        way = np.arctan2(counter * (x0 * y1 - y0 * x1), x0 * x1 + y0 * y1)
        last = np.where(closed, TURN, np.where(way < 0, way + TURN, way))
        return counter * (last + self.turns * TURN), closed

    def _helix(self) -> np.ndarray:
        """(R,) whether a corrected axis beside the plane moves."""
        result = np.zeros(len(self.arc), bool)
        for axis in self.s.beside:
            result |= self.f.moves[axis].take(self.arc)
        return result
