"""Arcs stay arcs where that is provable, else they are halved, and where they get too short they
become chords.

A circle stays a circle only under a similarity; a map that stretches X and Z differently makes it
an ellipse. So each arc is sampled so densely that nothing can hide between two samples (the chord
of a piecewise linear map misses it by at most kink * step / 4), a circle through its two commanded
ends is fitted, and the distance of every sample from the circle that the control will draw
measured: about the centre that it computes from R and the ends as written where the arc is written
with R (the programmed number if that will do, else a new one), else about I J rounded as they will
be written. R near half a turn moves the centre by many times its own rounding: the same proof sends
such arcs to I J. Radii of start and end keep the difference that they had, and a full circle ends
where it begins to the last digit or is halved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from postproc.compensate.arcs import points
from postproc.machine.model import Machine
from postproc.motions import Arcs, centre_by_radius
from postproc.units import TICKS_PER_MM

TURN = 2 * np.pi
SAME_ANGLE = 1e-9  # rad: below what two ends one tick apart make of any arc within travel
MOST_SAMPLES = 20_000
EXACT = 1e-9  # mm: what a square root leaves of half a turn
SMALLEST_RADIUS = 0.002  # mm: controls take less for none
SHORTEST = 3  # least increments: a shorter arc is a chord
LARGEST_SWEEP = np.radians(300.0)  # of an arc inside cutter radius compensation
NEIGHBOURS = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3))).reshape(2, 25)
HALVINGS = 14


@dataclass(frozen=True)
class Rows:
    """R parts of arcs. arc (R,): row of Arcs; stroke (R,); t0, t1 (R,): part of the arc; begin, end
    (A, R): ticks commanded; accepted as an arc with centre (2, R) ticks from begin, written as
    radius (R,) ticks, the R word, where that is not 0, or as a chord where chord (R,)."""

    arc: np.ndarray
    stroke: np.ndarray
    t0: np.ndarray
    t1: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    centre: np.ndarray
    radius: np.ndarray
    chord: np.ndarray

    def pick(self, which: np.ndarray) -> Rows:
        return Rows(**{f: getattr(self, f)[..., which] for f in Rows.__dataclass_fields__})

    def __len__(self) -> int:
        return len(self.arc)


def joined(parts: Sequence[Rows]) -> Rows:
    """Several sets of rows in one."""
    return Rows(**{f: np.concatenate([getattr(r, f) for r in parts], axis=-1) for f in Rows.__dataclass_fields__})


Needed = Callable[[Rows, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Samples:
    """K samples of R rows. row (K,): whose; first, last (R,): the samples at its ends; share (K,):
    part of the row's way; unit (2, K): outwards from the nominal centre; nominal, wanted (2, K): mm
    in the plane, the point and its exact command; command (A, K): mm, that command in all axes.
    begin, end (2, R): mm, as written; sweep (R,): rad, nominal."""

    row: np.ndarray
    first: np.ndarray
    last: np.ndarray
    share: np.ndarray
    unit: np.ndarray
    nominal: np.ndarray
    wanted: np.ndarray
    command: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    sweep: np.ndarray

    def total(self, value: np.ndarray) -> np.ndarray:
        """(R,) sums of (K,) values."""
        result: np.ndarray = np.add.reduceat(value, self.first)
        return result

    def largest(self, value: np.ndarray) -> np.ndarray:
        """(R,) largest of (K,) distances."""
        result: np.ndarray = np.maximum.reduceat(np.abs(value), self.first)
        return result


def turns(sweep: np.ndarray) -> np.ndarray:
    """(R,) full turns before the last one, which may be full itself: what P counts beyond the
    first."""
    return np.maximum(np.ceil(np.abs(sweep) / TURN - SAME_ANGLE) - 1, 0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(K,) scalar products of (2, K) vectors."""
    return a[0] * b[0] + a[1] * b[1]


@dataclass(frozen=True)
class Fitter:
    """What the fit must know. start, target (A, n) mm of the arcs; tolerance mm in the plane, and
    along the third axis; needed(rows, row, t, nominal) -> (A, K) mm: the exact command at a place;
    round_to(rows, row, command) -> ticks; single (n,): arcs that nothing stands before in their own
    block, where the word that counts turns is."""

    machine: Machine
    arcs: Arcs
    start: np.ndarray
    target: np.ndarray
    tolerance: float
    tolerance_across: float
    mismatch: float
    needed: Needed
    round_to: Callable[[Rows, np.ndarray, np.ndarray], np.ndarray]
    base: np.ndarray  # (2, n) ticks of the written centre words, from the start
    step: np.ndarray  # (A, n) ticks of a least increment of each axis' word
    single: np.ndarray
    inside: np.ndarray  # (n,) bool: inside cutter radius compensation (postproc.compensate.cutter)
    shortest: np.ndarray  # (n,) mm: a piece of such an arc has at least this way
    tool: np.ndarray  # (n,) mm: radius of a tool on the arc's inside, 0 for one on its outside, nan: not stated

    def density(self, rows: Rows) -> np.ndarray:
        """(R,) how many steps make each part's samples dense enough: between two of them at most an
        eighth of the tolerance may hide, from nodes (kink * step / 4) and from the ellipse that a
        stretched circle is."""
        arcs = self.arcs
        sweep = np.abs(arcs.sweep[rows.arc] * (rows.t1 - rows.t0))
        radius = np.maximum(arcs.radius, arcs.radius_end)[rows.arc]
        sagitta = radius * (1 - np.cos(np.minimum(sweep, TURN) / 2))
        ends = [points(arcs, self.start, self.target, rows.arc, t) for t in (rows.t0, rows.t1)]
        kink, steep = self.machine.bounds.local(np.minimum(*ends) - sagitta, np.maximum(*ends) + sagitta)
        slack = self.tolerance / 8
        travel = np.linalg.norm((self.target - self.start)[:, rows.arc], axis=0) * (rows.t1 - rows.t0)
        by_kink = np.hypot(sweep * radius, travel) * kink / (4 * slack)
        by_ellipse = sweep * np.sqrt(radius * steep / (4 * slack))
        return np.clip(np.ceil(np.maximum(by_kink, by_ellipse)), 4, 20000).astype(np.int64)

    def settle(self, rows: Rows) -> Rows:
        """Accept, halve or turn to chords until every part is within tolerance; in no particular
        order."""
        done: list[Rows] = []
        for halving in range(HALVINGS + 1):
            if not len(rows):
                break
            good, straight, rows, middle = self.fit_all(rows)
            tiny, flat = self._short(rows)
            short = tiny | (flat & straight) | (halving == HALVINGS)
            done.append(rows.pick(good))
            done.append(replace(rows.pick(~good & short), chord=np.ones(int((~good & short).sum()), bool)))
            rows, middle = rows.pick(~good & ~short), middle[:, ~good & ~short]
            half = (rows.t0 + rows.t1) / 2
            rows = joined([replace(rows, t1=half, end=middle), replace(rows, t0=half, begin=middle)])
        return joined(done)

    def _short(self, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
        """(R,) parts not to be halved again: shorter than the control resolves well, and flatter
        than a share of the tolerance."""
        sweep = np.abs(self.arcs.sweep[rows.arc] * (rows.t1 - rows.t0))
        radius = self.arcs.radius[rows.arc]
        sagitta = radius * (1 - np.cos(np.minimum(sweep, np.pi) / 2))
        tiny = sweep * radius < SHORTEST * self.arcs.grid[:, rows.arc].max(axis=0) / TICKS_PER_MM
        return tiny, sagitta < self.tolerance / 8

    def fit_all(self, rows: Rows) -> tuple[np.ndarray, np.ndarray, Rows, np.ndarray]:
        """(R,) whether an arc will do, and whether all axes are straight enough for a chord;
        the rows with their centres; (A, R) ticks commanded at the middle of each."""
        count = self.density(rows) // 2 * 2 + 1  # odd: one sample is the middle
        group = (np.cumsum(count) - count) // MOST_SAMPLES
        parts = []
        for g in range(int(group[-1]) + 1):  # so many at a time that memory stays flat
            which = np.flatnonzero(group == g)
            if len(which):
                parts.append(self.fit(rows.pick(which), count[which]))
        good, straight, fitted, middle = zip(*parts, strict=True)
        return np.concatenate(good), np.concatenate(straight), joined(fitted), np.concatenate(middle, axis=1)

    def fit(self, rows: Rows, count: np.ndarray) -> tuple[np.ndarray, np.ndarray, Rows, np.ndarray]:
        """The same for a few rows with `count` (R,) samples each."""
        s = self.samples(rows, count)
        good, radius = np.zeros(len(rows), bool), np.zeros(len(rows), np.int64)
        centre = np.zeros((2, len(rows)), np.int64)
        for there, word, tolerance in self._candidates(rows, s):
            holds = ~good & self._proven(rows, s, there, tolerance)
            ticks = np.rint(np.where(holds, there - s.begin, 0.0) * TICKS_PER_MM).astype(np.int64)
            good, radius, centre = good | holds, np.where(holds, word, radius), np.where(holds, ticks, centre)
            if good.all():
                break
        bent = self._bent(rows, s)
        in_plane = np.zeros((len(self.start), len(rows)), bool)
        k = np.arange(len(rows))
        in_plane[self.arcs.first[rows.arc], k] = in_plane[self.arcs.second[rows.arc], k] = True
        good &= ~(bent & ~in_plane).any(axis=0) | self._kept(rows, s)
        middle = s.first + (count - 1) // 2
        halfway = self.round_to(rows, k, s.command[:, middle])
        # A chord leaves the plane's axes no bow either.
        return good, np.logical_not(bent.any(axis=0)), replace(rows, centre=centre, radius=radius), halfway

    def _candidates(self, rows: Rows, s: Samples) -> Iterator[tuple[np.ndarray, np.ndarray, float | np.ndarray]]:
        """(2, R) mm centres as the control will have them, nan for none, (R,) the R words that make
        them, and the mm that each may miss the samples; best first: R as programmed, held like an
        axis at rest while that costs half of the tolerance at most, R as fitted, the centre as
        fitted, and the one that keeps the radius (in an arc so short that a micrometre of rounding
        outweighs its whole bow the fit knows no radius)."""
        exact, none = self._centre(rows, s), np.zeros(len(rows), np.int64)
        if self.arcs.by_radius[rows.arc].any():
            programmed, fitted = self._radius_words(rows, s, exact)
            yield self._drawn(rows, s, programmed), programmed, self.tolerance / 2
            yield self._drawn(rows, s, fitted), fitted, self.tolerance
        yield self._rounded(rows, s, exact), none, self.tolerance
        if self.inside[rows.arc].any():
            tolerance = np.where(self._kept(rows, s), np.inf, self.tolerance)
            yield self._as_wide(rows, s, exact), none, tolerance
            yield self._rounded(rows, s, exact), none, tolerance
        radius = self.arcs.radius[rows.arc] * np.where(np.abs(s.sweep) > np.pi, -1, 1)
        same = centre_by_radius(s.begin, s.end, radius, s.sweep > 0)
        yield self._rounded(rows, s, same), none, self.tolerance

    def _rounded(self, rows: Rows, s: Samples, centre: np.ndarray) -> np.ndarray:
        """(2, R) mm: centres as I J K will say them: whole increments from the programmed words."""
        base = np.where(rows.t0 == 0, self.base[:, rows.arc], 0)
        grid = self.arcs.grid[:, rows.arc]
        way = base + np.rint(((centre - s.begin) * TICKS_PER_MM - base) / grid) * grid
        result: np.ndarray = s.begin + way / TICKS_PER_MM
        return result

    def samples(self, rows: Rows, count: np.ndarray) -> Samples:
        """`count` (R,) samples of each row, in equal parts."""
        arcs = self.arcs
        row = np.repeat(np.arange(len(rows)), count)
        first = np.cumsum(count) - count
        step = np.arange(len(row)) - first[row]
        t = rows.t0[row] + (rows.t1 - rows.t0)[row] * step / (count - 1)[row]
        nominal = points(arcs, self.start, self.target, rows.arc[row], t)
        wanted = self.needed(rows, row, t, nominal)
        a, b = arcs.first[rows.arc], arcs.second[rows.arc]
        k, column = np.arange(len(rows)), np.arange(len(row))
        angle = arcs.angle[rows.arc][row] + arcs.sweep[rows.arc][row] * t
        return Samples(
            row=row, first=first, last=first + count - 1, share=step / (count - 1)[row],
            unit=np.stack([np.cos(angle), np.sin(angle)]),
            nominal=np.stack([nominal[a[row], column], nominal[b[row], column]]),
            wanted=np.stack([wanted[a[row], column], wanted[b[row], column]]), command=wanted,
            begin=np.stack([rows.begin[a, k], rows.begin[b, k]]) / TICKS_PER_MM,
            end=np.stack([rows.end[a, k], rows.end[b, k]]) / TICKS_PER_MM,
            sweep=arcs.sweep[rows.arc] * (rows.t1 - rows.t0),
        )  # fmt: skip

    def _centre(self, rows: Rows, s: Samples) -> np.ndarray:
        """(2, R) mm: the centre whose circle through the written begin passes the samples best, by
        least squares in the radial shifts; where the row ends elsewhere than it begins, it passes
        the written end too."""
        unit0, unit1 = s.unit[:, s.first], s.unit[:, s.last]
        radial0 = dot(unit0, s.begin - s.nominal[:, s.first])
        radial1 = dot(unit1, s.end - s.nominal[:, s.last])
        length = np.hypot(*(unit1 - unit0))
        open_ = length > SAME_ANGLE
        safe = np.where(open_, length, 1.0)
        along = np.where(open_, (unit1 - unit0) / safe, np.array([[1.0], [0.0]]))
        across = np.stack([-along[1], along[0]])
        arm = s.unit - unit0[:, s.row]
        f, g = dot(arm, along[:, s.row]), dot(arm, across[:, s.row])
        h = dot(s.unit, s.wanted - s.nominal) - radial0[s.row]
        ff, fg, gg = s.total(f * f), s.total(f * g), s.total(g * g)
        fh, gh = s.total(f * h), s.total(g * h)
        free = ff * gg - fg**2
        free = (fh * gg - gh * fg) / np.where(free > 0, free, 1.0)
        move_along = np.where(open_, (radial1 - radial0) / safe, free)
        move_across = (gh - fg * move_along) / np.where(gg > 0, gg, 1.0)
        return self.arcs.centre[:, rows.arc] + along * move_along + across * move_across

    def _radius_words(self, rows: Rows, s: Samples, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(R,) ticks twice: what R may be, 0 in arcs that have none: the programmed number, and the
        fitted one as rounded."""
        own = self.arcs.by_radius[rows.arc]
        whole = (rows.t0 == 0) & (rows.t1 == 1)
        sign = np.where(whole, np.sign(own), np.where(np.abs(s.sweep) > np.pi, -1, 1)) * (own != 0)
        step = self.arcs.grid[:, rows.arc].max(axis=0)
        exact = np.hypot(*(s.begin - centre)) * TICKS_PER_MM
        rounded = np.abs(own) + np.rint((exact - np.abs(own)) / step).astype(np.int64) * step
        return sign * np.abs(own), sign * rounded

    def _drawn(self, rows: Rows, s: Samples, word: np.ndarray) -> np.ndarray:
        """(2, R) mm: the centre that a control computes from R `word` (R,) ticks and the written
        ends; nan where it has none, or where R is shorter than half the way by more than the
        programmed one was."""
        half = np.hypot(*(s.end - s.begin)) / 2
        nominal = np.hypot(*(s.nominal[:, s.last] - s.nominal[:, s.first])) / 2
        short = np.maximum(nominal - np.abs(self.arcs.by_radius[rows.arc]) / TICKS_PER_MM, EXACT)
        radius = word / TICKS_PER_MM
        reaches = (word != 0) & (half > 0) & (half - np.abs(radius) <= short)
        return np.where(reaches, centre_by_radius(s.begin, s.end, radius, s.sweep > 0), np.nan)

    def _kept(self, rows: Rows, s: Samples) -> np.ndarray:
        """(R,) bool: inside cutter radius compensation, and too short to be cut, whatever that leaves."""
        way = np.abs(s.sweep) * self.arcs.radius[rows.arc]
        result: np.ndarray = self.inside[rows.arc] & (way < 2 * self.shortest[rows.arc])
        return result

    def _least(self, rows: Rows) -> np.ndarray:
        """(R,) ticks that the radius must have at least: inside cutter radius compensation the tool must fit on the inside of
        an arc; where its radius is not known, as it did."""
        arcs, arc = self.arcs, rows.arc
        step, tool = arcs.grid[:, arc].max(axis=0), self.tool[arc] * TICKS_PER_MM
        radius = np.minimum(arcs.radius, arcs.radius_end)[arc] * TICKS_PER_MM
        least = np.where(np.isfinite(tool), np.minimum(radius, np.where(tool > 0, tool + step, 0.0)), radius)
        return np.where(self.inside[arc], least - 0.5, 0.0)

    def _as_wide(self, rows: Rows, s: Samples, centre: np.ndarray) -> np.ndarray:
        """(2, R) mm: centres near the fitted ones that leave arcs inside cutter radius compensation wide enough; nan for
        other arcs and where there is none."""
        arcs, arc = self.arcs, rows.arc
        grid, chord = arcs.grid[:, arc], (s.end - s.begin) * TICKS_PER_MM
        exact, least = (centre - s.begin) * TICKS_PER_MM, self._least(rows)
        radius = np.minimum(arcs.radius, arcs.radius_end)[arc] * TICKS_PER_MM
        narrow = np.minimum(np.hypot(*exact), np.hypot(*(chord - exact))) < least - grid.max(axis=0)
        exact = np.where(narrow, -radius * s.unit[:, s.first], exact)  # moved as it is
        tried = (np.rint(exact / grid) * grid)[:, None] + NEIGHBOURS[:, :, None] * grid[:, None]
        fits = np.minimum(np.hypot(*tried), np.hypot(*(chord[:, None] - tried))) >= least
        cost = np.where(fits & self.inside[arc], np.hypot(*(tried - exact[:, None])), np.inf)
        best, column = np.argmin(cost, axis=0), np.arange(len(arc))
        found = s.begin + tried[:, best, column] / TICKS_PER_MM
        return np.where(np.isfinite(cost[best, column]), found, np.nan)

    def _proven(self, rows: Rows, s: Samples, centre: np.ndarray, tolerance: float | np.ndarray) -> np.ndarray:
        """(R,) whether the arcs about `centre` (2, R) mm through the written ends keep the
        tolerance, mm, and are arcs to a control."""
        arcs, row = self.arcs, s.row
        radius0, radius1 = np.hypot(*(s.begin - centre)), np.hypot(*(s.end - centre))
        radius = radius0[row] + (radius1 - radius0)[row] * s.share
        off = np.hypot(*(s.wanted - centre[:, row])) - radius
        turned, closed = self._turned(s, centre)
        helix = self._helix(rows)
        if helix.any():
            # The other axes are tied to the angle: being ahead of it is as wrong as being beside the circle.
            angle = np.arctan2(*(s.begin - centre)[::-1])[row] + turned[row] * s.share
            there = centre[:, row] + radius * np.stack([np.cos(angle), np.sin(angle)])
            off = np.where(helix[row], np.hypot(*(s.wanted - there)), off)
        good = s.largest(off) <= tolerance + 0.5 * arcs.grid[:, rows.arc].min(axis=0) / TICKS_PER_MM
        # Rounding must not turn a sliver into a circle, nor a circle into a sliver.
        good &= np.abs(turned - s.sweep) < np.minimum(0.5 * np.abs(s.sweep), np.pi)
        full = np.abs(s.sweep / TURN - np.rint(s.sweep / TURN)) < SAME_ANGLE
        good &= closed | ~full
        good &= (turns(s.sweep) == 0) | (self.single[rows.arc] & (rows.t0 == 0) & (rows.t1 == 1))
        good &= np.minimum(radius0, radius1) > SMALLEST_RADIUS
        wide = np.minimum(radius0, radius1) * TICKS_PER_MM >= self._least(rows)
        good &= wide | np.isinf(tolerance)
        good &= ~(self.inside[rows.arc] & (np.abs(s.sweep) > LARGEST_SWEEP))
        was = np.abs(arcs.radius_end - arcs.radius)[rows.arc] * (rows.t1 - rows.t0)
        # Together they must stay below the control's limit, twice the mismatch; what misses by more already, by no more.
        good &= np.abs(radius1 - radius0) <= np.where(was <= self.mismatch, was + self.mismatch, was)
        return good

    def _turned(self, s: Samples, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(R,) rad that a control turns about `centre`, and whether it ends where it begins: then
        it makes a full turn."""
        closed = (s.begin == s.end).all(axis=0)
        counter = np.where(s.sweep > 0, 1.0, -1.0)
        way = np.arctan2(*(s.end - centre)[::-1]) - np.arctan2(*(s.begin - centre)[::-1])
        return counter * (np.where(closed, TURN, counter * way % TURN) + turns(s.sweep) * TURN), closed

    def _helix(self, rows: Rows) -> np.ndarray:
        """(R,) whether a corrected axis beside the plane moves."""
        moves = (self.start != self.target)[:, rows.arc]
        k = np.arange(len(rows))
        moves[self.arcs.first[rows.arc], k] = moves[self.arcs.second[rows.arc], k] = False
        result: np.ndarray = moves[list(self.machine.corrected)].any(axis=0)
        return result

    def _bent(self, rows: Rows, s: Samples) -> np.ndarray:
        """(A, R) whether a corrected axis leaves the straight line between its ends by more than
        its tolerance."""
        begin, end = rows.begin / TICKS_PER_MM, rows.end / TICKS_PER_MM
        bent = np.zeros(begin.shape, bool)
        for axis in self.machine.corrected:
            bow = s.command[axis] - (begin[axis][s.row] + (end - begin)[axis][s.row] * s.share)
            half = self.step[axis, rows.arc] / TICKS_PER_MM / 2  # the ends are rounded already
            bent[axis] = s.largest(bow) > self.tolerance_across + half
        return bent
