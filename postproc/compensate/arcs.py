"""Arcs stay arcs where that is provable, else they are halved, and where they get too short they become chords.

A circle stays a circle only under a similarity; a map that stretches X and Z differently makes it an ellipse. So each arc
is sampled so densely that nothing can hide between two samples (the chord of a piecewise linear map misses it by at most
kink * step / 4), a circle through its two commanded ends is fitted, its centre rounded as it will be written, and the
distance of every sample from that circle measured. Radii of start and end keep the difference that they had.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from postproc.machine.model import Machine
from postproc.motions import Arcs
from postproc.units import TICKS_PER_MM

LARGEST_SWEEP = np.radians(300.0)  # beyond, centre and radius are ill-determined: quarter it
MOST_SAMPLES = 20_000
SHALLOWEST = 1e-6  # mm
SMALLEST_RADIUS = 0.002  # mm: controls take less for none
SHORTEST = 3  # least increments: a shorter arc is a chord
HALVINGS = 14
NEIGHBOURS = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3))).reshape(2, 25)


@dataclass(frozen=True)
class Rows:
    """R parts of arcs. arc (R,): row of Arcs; stroke (R,); t0, t1 (R,): part of the arc; begin, end (A, R): ticks
    commanded; accepted as an arc with centre (2, R) ticks from begin, or as a chord where chord (R,)."""

    arc: np.ndarray
    stroke: np.ndarray
    t0: np.ndarray
    t1: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    centre: np.ndarray
    chord: np.ndarray

    def pick(self, which: np.ndarray) -> Rows:
        return Rows(**{f: getattr(self, f)[..., which] for f in Rows.__dataclass_fields__})

    def __len__(self) -> int:
        return len(self.arc)


def points(arcs: Arcs, start: np.ndarray, target: np.ndarray, arc: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(A, K) mm: nominal points of arcs at t from 0 to 1. start, target (A, n) mm of all arcs; spirals and helices linear."""
    p = start[:, arc] + (target - start)[:, arc] * t
    angle = arcs.angle[arc] + arcs.sweep[arc] * t
    radius = arcs.radius[arc] + (arcs.radius_end - arcs.radius)[arc] * t
    column = np.arange(len(arc))
    inner = (t > 0) & (t < 1)  # ends stay as programmed, to the bit
    for axis, value in (
        (arcs.first[arc], arcs.centre[0, arc] + radius * np.cos(angle)),
        (arcs.second[arc], arcs.centre[1, arc] + radius * np.sin(angle)),
    ):
        p[axis[inner], column[inner]] = value[inner]
    return p


def quadrants(arcs: Arcs) -> tuple[np.ndarray, np.ndarray]:
    """(K,) arc and (K,) t of the places where a plane axis turns back."""
    quarter = np.pi / 2
    low = np.minimum(arcs.angle, arcs.angle + arcs.sweep) + 1e-9
    high = np.maximum(arcs.angle, arcs.angle + arcs.sweep) - 1e-9
    first = np.ceil(low / quarter).astype(np.int64)
    count = np.maximum(np.floor(high / quarter).astype(np.int64) - first + 1, 0)
    arc = np.repeat(np.arange(len(arcs)), count)
    index = first[arc] + np.arange(len(arc)) - np.repeat(np.cumsum(count) - count, count)
    t = (index * quarter - arcs.angle[arc]) / arcs.sweep[arc]
    order = np.lexsort((t, arc))
    return arc[order], t[order]


def turning_points(arcs: Arcs, start: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) arc and (K,) t inside arcs where a plane axis turns back; start, target (A, n) mm of the arcs.

    An arc that is meant to begin or end at a quadrant, and misses it by the rounding of its words, turns back by less
    than a nanometre there: that is none.
    """
    arc, t = quadrants(arcs)
    inside = (t > 0) & (t < 1)
    arc, t = arc[inside], t[inside]
    index = np.rint((arcs.angle[arc] + arcs.sweep[arc] * t) / (np.pi / 2)).astype(np.int64)
    axis = np.where(index % 2 == 0, arcs.first[arc], arcs.second[arc])  # the axis that is at its extreme there
    place = points(arcs, start, target, arc, t)[axis, np.arange(len(arc))]
    deep = np.abs(place - start[axis, arc]) > SHALLOWEST
    deep &= np.abs(place - target[axis, arc]) > SHALLOWEST
    whole = np.abs(arcs.sweep[arc]) > 1.5 * np.pi  # the far end may lie at the same place by going round
    first = np.concatenate([[True], arc[1:] != arc[:-1]])
    final = np.concatenate([arc[1:] != arc[:-1], [True]]) if len(arc) else first[:0]
    deep |= whole & ~(first[: len(arc)] | final)
    return arc[deep], t[deep]


Needed = Callable[[Rows, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Fitter:
    """What the fit must know. start, target (A, n) mm of the arcs; tolerance mm in the plane, and along the third axis;
    needed(rows, row, t, nominal) -> (A, K) mm: the exact command at a place; round_to(rows, row, command) -> ticks."""

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
    inside: np.ndarray  # (n,) bool: inside cutter radius compensation (postproc.compensate.cutter)
    shortest: np.ndarray  # (n,) mm: a piece of such an arc has at least this way
    tool: np.ndarray  # (n,) mm: radius of a tool on the arc's inside, 0 for one on its outside, nan: not stated

    def samples(self, rows: Rows) -> np.ndarray:
        """(R,) how many steps make each part's samples dense enough: between two of them at most an eighth of the
        tolerance may hide, from nodes (kink * step / 4) and from the ellipse that a stretched circle is."""
        arcs = self.arcs
        sweep = np.abs(arcs.sweep[rows.arc] * (rows.t1 - rows.t0))
        radius = np.maximum(arcs.radius, arcs.radius_end)[rows.arc]
        sagitta = radius * (1 - np.cos(np.minimum(sweep, 2 * np.pi) / 2))
        ends = [points(arcs, self.start, self.target, rows.arc, t) for t in (rows.t0, rows.t1)]
        kink, steep = self.machine.bounds.local(np.minimum(*ends) - sagitta, np.maximum(*ends) + sagitta)
        slack = self.tolerance / 8
        travel = np.linalg.norm((self.target - self.start)[:, rows.arc], axis=0) * (rows.t1 - rows.t0)
        by_kink = np.hypot(sweep * radius, travel) * kink / (4 * slack)
        by_ellipse = sweep * np.sqrt(radius * steep / (4 * slack))
        return np.clip(np.ceil(np.maximum(by_kink, by_ellipse)), 4, 20000).astype(np.int64)

    def settle(self, rows: Rows) -> Rows:
        """Accept, halve or turn to chords until every part is within tolerance; in no particular order."""
        done: list[Rows] = []
        wide = np.abs(self.arcs.sweep[rows.arc] * (rows.t1 - rows.t0)) > LARGEST_SWEEP
        moved = (
            rows.begin != np.round(points(self.arcs, self.start, self.target, rows.arc, rows.t0) * TICKS_PER_MM)
        ).any(axis=0)
        moved |= (
            rows.end != np.round(points(self.arcs, self.start, self.target, rows.arc, rows.t1) * TICKS_PER_MM)
        ).any(axis=0)
        force = wide & (moved | self.inside[rows.arc])
        for halving in range(HALVINGS + 1):
            if not len(rows):
                break
            good, straight, rows, middle = self.fit_all(rows)
            good &= ~force
            tiny, flat = self._short(rows)
            short = tiny | (flat & straight) | (halving == HALVINGS)
            done.append(rows.pick(good))
            done.append(replace(rows.pick(~good & short), chord=np.ones(int((~good & short).sum()), bool)))
            rows, middle = rows.pick(~good & ~short), middle[:, ~good & ~short]
            half = (rows.t0 + rows.t1) / 2
            left, right = replace(rows, t1=half, end=middle), replace(rows, t0=half, begin=middle)
            rows = Rows(
                **{f: np.concatenate([getattr(left, f), getattr(right, f)], axis=-1) for f in Rows.__dataclass_fields__}
            )
            most = np.where(self.inside[rows.arc], LARGEST_SWEEP, LARGEST_SWEEP / 2)
            wide = np.abs(self.arcs.sweep[rows.arc] * (rows.t1 - rows.t0)) > most
            force = wide & np.concatenate([force[~good & ~short]] * 2)
        return Rows(**{f: np.concatenate([getattr(r, f) for r in done], axis=-1) for f in Rows.__dataclass_fields__})

    def _short(self, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
        """(R,) parts not to be halved again: shorter than the control resolves well, and flatter than a share of the tolerance."""
        sweep = np.abs(self.arcs.sweep[rows.arc] * (rows.t1 - rows.t0))
        radius = self.arcs.radius[rows.arc]
        sagitta = radius * (1 - np.cos(np.minimum(sweep, np.pi) / 2))
        tiny = sweep * radius < SHORTEST * self.arcs.grid[:, rows.arc].max(axis=0) / TICKS_PER_MM
        return tiny, sagitta < self.tolerance / 8

    def fit_all(self, rows: Rows) -> tuple[np.ndarray, np.ndarray, Rows, np.ndarray]:
        """(R,) whether an arc will do, and whether all axes are straight enough for a chord;
        the rows with their centres; (A, R) ticks commanded at the middle of each."""
        count = self.samples(rows) // 2 * 2 + 1  # odd: one sample is the middle
        group = (np.cumsum(count) - count) // MOST_SAMPLES
        parts = []
        for g in range(int(group[-1]) + 1):  # so many at a time that memory stays flat
            which = np.flatnonzero(group == g)
            if len(which):
                parts.append(self.fit(rows.pick(which), count[which]))
        good, straight, fitted, middle = zip(*parts, strict=True)
        joined = Rows(
            **{f: np.concatenate([getattr(r, f) for r in fitted], axis=-1) for f in Rows.__dataclass_fields__}
        )
        return np.concatenate(good), np.concatenate(straight), joined, np.concatenate(middle, axis=1)

    def _as_wide(self, rows: Rows, exact: np.ndarray, centre: np.ndarray, chord: np.ndarray) -> np.ndarray:
        """(2, R) ticks: centres that leave an arc inside cutter radius compensation wide enough for the tool on its inside
        (`tool`; where that is not known, as wide as it is). chord (2, R): ticks from begin to end."""
        held = np.flatnonzero(self.inside[rows.arc])
        if not len(held):
            return centre
        arcs, arc = self.arcs, rows.arc[held]
        grid, chord, exact = arcs.grid[:, arc], chord[:, held], exact[:, held]
        tool, step = self.tool[arc] * TICKS_PER_MM, grid.max(axis=0)
        radius = np.minimum(arcs.radius, arcs.radius_end)[arc] * TICKS_PER_MM
        found = np.minimum(np.hypot(*exact), np.hypot(*(chord - exact)))
        least = np.where(np.isfinite(tool), np.minimum(radius, np.where(tool > 0, tool + step, 0.0)), radius)
        narrow = found < least - step
        angle = arcs.angle[arc] + arcs.sweep[arc] * rows.t0[held]
        exact = np.where(narrow, -radius * np.stack([np.cos(angle), np.sin(angle)]), exact)  # moved as it is
        near = np.where(narrow, np.rint(exact / grid) * grid, centre[:, held]).astype(np.int64)
        tried = near[:, None] + NEIGHBOURS[:, :, None] * grid[:, None]
        fits = np.minimum(np.hypot(*tried), np.hypot(*(chord[:, None] - tried))) >= least - 0.5
        cost = np.where(fits, np.hypot(*(tried - exact[:, None])), np.inf)
        best, column = np.argmin(cost, axis=0), np.arange(len(held))
        centre = centre.copy()
        centre[:, held] = np.where(np.isfinite(cost[best, column]), tried[:, best, column], centre[:, held])
        return centre

    def fit(self, rows: Rows, count: np.ndarray) -> tuple[np.ndarray, np.ndarray, Rows, np.ndarray]:
        """The same for a few rows with `count` (R,) samples each."""
        arcs = self.arcs
        row = np.repeat(np.arange(len(rows)), count)
        first = np.cumsum(count) - count
        step = np.arange(len(row)) - first[row]
        t = rows.t0[row] + (rows.t1 - rows.t0)[row] * step / (count - 1)[row]
        nominal = points(arcs, self.start, self.target, rows.arc[row], t)
        wanted = self.needed(rows, row, t, nominal)
        column, a, b = np.arange(len(row)), arcs.first[rows.arc], arcs.second[rows.arc]
        begin, end = rows.begin / TICKS_PER_MM, rows.end / TICKS_PER_MM
        k = np.arange(len(rows))
        begin2, end2 = np.stack([begin[a, k], begin[b, k]]), np.stack([end[a, k], end[b, k]])
        point2 = np.stack([wanted[a[row], column], wanted[b[row], column]])
        nominal2 = np.stack([nominal[a[row], column], nominal[b[row], column]])
        angle = arcs.angle[rows.arc][row] + arcs.sweep[rows.arc][row] * t
        unit = np.stack([np.cos(angle), np.sin(angle)])
        unit0, unit1 = unit[:, first], unit[:, first + count - 1]
        shift0, shift1 = begin2 - nominal2[:, first], end2 - nominal2[:, first + count - 1]
        chord = unit1 - unit0
        length = np.hypot(*chord)
        along = chord / np.where(length > 0, length, 1.0)
        across = np.stack([-along[1], along[0]])
        radial0 = (unit0 * shift0).sum(axis=0)
        fixed = np.where(
            length > 1e-9, ((unit1 * shift1).sum(axis=0) - radial0) / np.where(length > 1e-9, length, 1.0), 0.0
        )
        arm = unit - unit0[:, row]
        g = (arm * across[:, row]).sum(axis=0)
        h = (unit * (point2 - nominal2)).sum(axis=0) - radial0[row] - (arm * along[:, row]).sum(axis=0) * fixed[row]
        gg, gh = np.add.reduceat(g * g, first), np.add.reduceat(g * h, first)
        move = along * fixed + across * np.where(gg > 0, gh / np.where(gg > 0, gg, 1.0), 0.0)
        exact = (arcs.centre[:, rows.arc] + move - begin2) * TICKS_PER_MM
        base = np.where(rows.t0 == 0, self.base[:, rows.arc], 0)
        grid = arcs.grid[:, rows.arc]
        centre = base + np.rint((exact - base) / grid).astype(np.int64) * grid
        centre = self._as_wide(rows, exact, centre, (end2 - begin2) * TICKS_PER_MM)
        middle_at = begin2 + centre / TICKS_PER_MM
        radius0, radius1 = np.hypot(*(begin2 - middle_at)), np.hypot(*(end2 - middle_at))
        share = step / (count - 1)[row]
        off = np.hypot(*(point2 - middle_at[:, row])) - (radius0[row] + (radius1 - radius0)[row] * share)
        turned = np.arctan2(*(end2 - middle_at)[::-1]) - np.arctan2(*(begin2 - middle_at)[::-1])
        sweep = arcs.sweep[rows.arc] * (rows.t1 - rows.t0)
        turned = np.where(sweep > 0, turned % (2 * np.pi), -(-turned % (2 * np.pi)))
        helix = np.zeros(len(rows), bool)
        for axis in self.machine.corrected:
            helix |= (a != axis) & (b != axis) & (self.start[axis, rows.arc] != self.target[axis, rows.arc])
        if (
            helix.any()
        ):  # the other axes are tied to the angle: being ahead of it is as wrong as being beside the circle
            angle = np.arctan2(*(begin2 - middle_at)[::-1])[row] + turned[row] * share
            there = middle_at[:, row] + (radius0[row] + (radius1 - radius0)[row] * share) * np.stack(
                [np.cos(angle), np.sin(angle)]
            )
            off = np.where(helix[row], np.hypot(*(point2 - there)), off)
        worst = np.maximum.reduceat(np.abs(off), first)
        good = worst <= self.tolerance + 0.5 * grid.min(axis=0) / TICKS_PER_MM
        whole = np.abs(sweep) > 2 * np.pi - 0.1  # a full circle that was not moved
        kept = self.inside[rows.arc] & (np.abs(sweep) * arcs.radius[rows.arc] < 2 * self.shortest[rows.arc])
        good |= kept
        good &= whole | (np.abs(turned - sweep) < 0.5 * np.abs(sweep))  # rounding must not turn a sliver into a circle
        good &= np.minimum(radius0, radius1) > SMALLEST_RADIUS
        was = np.abs(arcs.radius_end - arcs.radius)[rows.arc] * (rows.t1 - rows.t0)
        good &= np.abs(radius1 - radius0) <= was + self.mismatch
        straight = np.ones(len(rows), bool)
        for axis in self.machine.corrected:
            bow = wanted[axis] - (begin[axis][row] + (end - begin)[axis][row] * share)
            half = self.step[axis, rows.arc] / TICKS_PER_MM / 2  # the ends are rounded already
            linear = np.maximum.reduceat(np.abs(bow), first) <= self.tolerance_across + half
            good &= linear | (a == axis) | (b == axis) | kept
            straight &= linear  # a chord leaves the plane's axes no bow either
        middle = first + (count - 1) // 2
        halfway = self.round_to(rows, np.arange(len(rows)), wanted[:, middle])
        return good, straight, replace(rows, centre=centre), halfway
