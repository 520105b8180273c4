"""Verify inside G41 G42: nominal and corrected contour are both shifted by the tool's radius, and
their centres compared.

The corrected centre is where the slides are sent; with the deviation there it must lie on the
nominal centre's path. Both are followed with LinuxCNC's rules (postproc.nc.shifted); a contour that
is entered by an arc is not followed, nor is one without a stated radius: those are measured at the
contour.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil

import numpy as np

from postproc.errors import GcompError
from postproc.machine.model import Machine
from postproc.machine.seen import seen_in
from postproc.machine.tip import TipMachine
from postproc.motions import ENTRY, FREE, Motions
from postproc.nc.beside_corrected import LIMIT
from postproc.nc.beside_refusals import block_of, follower
from postproc.nc.shifted import Gouge, Shifted, Way
from postproc.pieces import Pieces
from postproc.units import TICKS_PER_MM, UM
from postproc.verify.largest import Largest

# as along paths outside (verify/__init__.py)
STEP_MM = 2.0
PLAY_MM = 0.01  # an axis that moves less has not turned back
NEAR = 1e-4  # of a way, to both sides: there a slide's direction is looked at
FEWEST, MOST = 5, 65  # samples of one way


@dataclass
class Contour:
    """One of the two programs while it is inside. ways: of the centre, final; approach (A,): as of
    the last of them."""

    shifted: Shifted
    approach: np.ndarray
    ways: list[Way] = field(default_factory=list)

    def take(self) -> None:
        """The ways that are final, from the follower."""
        self.ways += self.shifted.done
        self.shifted.done = []


class CentreVerifier:
    """Takes each batch. `corrected`, `uncorrected`: the largest distances so far; `refused`: what
    LinuxCNC refuses in the nominal program itself, and where."""

    def __init__(self, machine: Machine, directed: bool):
        self.machine, self.directed = machine, directed
        self.corrected, self.uncorrected = Largest(), Largest()
        self.refused = ""
        self.nominal: Contour | None = None
        self.run: Contour | None = None
        self.lines: dict[int, int] = {}
        self.count = 0

    def check(
        self, motions: Motions, back: Motions, pieces: Pieces, weights: np.ndarray, line: np.ndarray
    ) -> np.ndarray:
        """(N,) bool: nominal motions whose centres were followed. Raises GcompError where the
        correction makes a corner that the control refuses."""
        followed = np.zeros(len(motions), bool)
        inside = np.flatnonzero(motions.cutter != FREE)
        first = np.searchsorted(pieces.motion, np.arange(len(motions) + 1))
        entry, radius = motions.cutter == ENTRY, motions.radius
        # a radius of nan is one that nobody stated: those contours are measured as written
        enters = entry & (radius != 0) & np.isfinite(radius)
        leaves = entry & (radius == 0)
        for i in inside.tolist():
            if enters[i]:
                self._enter(motions, i, weights)
            if self.nominal is None or self.run is None:
                continue
            followed[i] = True
            self.lines[self.count + i] = int(line[i])
            if self._step_nominal(self.nominal, motions, i, int(line[i])):
                pieces_of = range(int(first[i]), int(first[i + 1]))
                self._step_run(self.run, back, pieces_of, motions, i, int(line[i]))
                if leaves[i]:
                    self.finish()
        self._compare()
        self.count += len(motions)
        return followed

    def _step_nominal(self, nominal: Contour, motions: Motions, i: int, line: int) -> bool:
        """One motion of the nominal program; False where LinuxCNC refuses it."""
        try:
            self._step(nominal.shifted, motions, i, motions, i)
        except Gouge as gouge:
            self.refused = self.refused or f"{gouge} (line {line})"
            self.nominal = self.run = None
            return False
        return True

    def _step_run(
        self, run: Contour, back: Motions, pieces: range, motions: Motions, i: int, line: int
    ) -> None:
        """The pieces of one motion. Raises GcompError where LinuxCNC refuses them."""
        try:
            for piece in pieces:
                self._step(run.shifted, back, piece, motions, i)
        except Gouge as gouge:
            raise GcompError(
                f"the corrected contour of line {line} is one that LinuxCNC refuses,"
                f" and the nominal is not: {gouge}",
                LIMIT,
            ) from None

    def finish(self) -> None:
        """No more blocks of this contour."""
        for contour in (self.nominal, self.run):
            if contour is not None:
                contour.shifted.flush()
        self._compare(last=True)
        self.nominal = self.run = None
        self.lines.clear()

    def _enter(self, motions: Motions, i: int, weights: np.ndarray) -> None:
        self.finish()
        nominal, run = follower(motions, i), follower(motions, i)
        if nominal is None or run is None:
            return
        self.nominal = Contour(nominal, weights[:, i].copy())
        self.run = Contour(run, weights[:, i].copy())
        space, tool = motions.spaces[int(motions.space[i])], motions.length[:, i] / TICKS_PER_MM
        self.at_work = seen_in(self.machine, tool, space, False)

    def _step(self, shifted: Shifted, of: Motions, row: int, nominal: Motions, i: int) -> None:
        """One motion of a program, which belongs to nominal motion i."""
        block = block_of(of, row, self.count + i)
        if nominal.cutter[i] != ENTRY:
            shifted.follow(block)
        elif nominal.radius[i]:
            shifted.enter(of.start[:, row] / TICKS_PER_MM, block)
        else:
            shifted.leave(block)

    # -- distances ---------------------------------------------------------------------------------

    def _compare(self, last: bool = False) -> None:
        """Measure the ways whose neighbours on the nominal path are final."""
        if self.nominal is None or self.run is None:
            return
        self.nominal.take()
        self.run.take()
        # A way is final only when the follower has seen its corner: the last one still waits for
        # the next block, and with it its neighbour, against which ways are measured as well.
        waiting = self.nominal.shifted.queue
        limit = (waiting[0].owner if waiting else self.count) - 1
        if last:
            limit = self.count + 10**9
        self._measure_until(limit, self.run, self.nominal.ways, self.corrected)
        self._measure_until(limit, self.nominal, self.nominal.ways, self.uncorrected)
        self.run.ways = [w for w in self.run.ways if w.owner >= limit]
        for way in self.nominal.ways:
            way.measured = way.owner < limit
        self.nominal.ways = [w for w in self.nominal.ways if w.owner >= limit - 2]

    def _measure_until(
        self, limit: int, contour: Contour, nominal: list[Way], into: Largest
    ) -> None:
        """Ways of motions before `limit`, against those of the nominal path beside them."""
        for way in contour.ways:
            if way.owner < limit and not way.measured:
                # A corner of the corrected contour may be cut a little before or behind the nominal
                # one: the ways of the motions before and behind count too, and the nearest is
                # taken.
                near = [w for w in nominal if abs(w.owner - way.owner) <= 1]
                self._measure(contour, way, near, into)

    def _measure(self, contour: Contour, way: Way, near: list[Way], into: Largest) -> None:
        #   contour   nominal    ------>     shifted by the radius     nominal centre  . . . .
        #             corrected  ~~~~~~>     shifted by the radius     where the slides are sent
        # With the deviation there the centre comes to `actual`: its distance from the dotted line
        # is what the part is off by. A rapid cuts nothing: its end alone counts.
        t = (
            np.ones(1)
            if way.rapid
            else np.linspace(0.0, 1.0, min(max(ceil(_length(way) / STEP_MM) + 1, FEWEST), MOST))
        )
        point = _points(way, t)
        weight = self._approach(contour, way, t)
        actual = point + self.at_work.deviation(point, weight)
        rows = list(self.at_work.corrected)
        distance = (
            np.min([_distance(w, actual, rows) for w in near], axis=0) if near else np.zeros(len(t))
        )
        worst = int(np.argmax(distance))
        # of the worst place the author's line, by the motion that the way belongs to
        into.take(float(distance[worst]), self.lines.get(way.owner, 0))

    def _approach(self, contour: Contour, way: Way, t: np.ndarray) -> np.ndarray:
        """(A, K) -1 to 1: in which direction each axis moves or has moved last."""
        if isinstance(self.at_work, TipMachine):  # the slides' own ways
            both = (self.at_work.slides(_points(way, np.clip(t + d, 0, 1))) for d in (-NEAR, NEAR))
            # where it stands a little later less a little earlier: the slides' direction there
            ways = -np.subtract(*both)
            weight = np.where(np.abs(ways) > PLAY_MM * NEAR, np.sign(ways), 0.0)
            return weight if self.directed else np.zeros_like(weight)
        travel = way.end - way.start
        turned = np.where(np.abs(travel) > PLAY_MM, np.sign(travel), contour.approach)
        weight = np.repeat(turned[:, None], len(t), axis=1)
        if way.centre is not None:
            # just inside: at its ends an arc may touch the place where an axis turns back
            angle = _angle(way) + way.sweep * np.clip(t, 1e-6, 1 - 1e-6)
            sense = np.sign(way.sweep)
            weight[way.plane[0]], weight[way.plane[1]] = (
                -np.sin(angle) * sense,
                np.cos(angle) * sense,
            )
            weight[list(way.plane)] = np.sign(weight[list(way.plane)])
        contour.approach = weight[:, -1].copy()
        return weight if self.directed else np.zeros_like(weight)

    def report(self, allowed: float) -> str:
        """What a person should know of it, or nothing."""
        self.finish()
        said = ""
        if self.uncorrected.deviation:
            over = (
                ", more than the tolerance, as nothing may be put in there"
                if self.corrected.deviation > allowed
                else ""
            )
            said += (
                f"; inside G41 G42 along the tool's centre {self.corrected.deviation / UM:.2f} um"
                f" (line {self.corrected.line}), uncorrected {self.uncorrected.deviation / UM:.2f}"
                f" um{over}"
            )
        if self.refused:
            said += f"; LinuxCNC refuses a contour of the program itself: {self.refused}"
        return said


def _angle(way: Way) -> float:
    assert way.centre is not None
    first, second = way.plane
    return float(np.arctan2(way.start[second] - way.centre[1], way.start[first] - way.centre[0]))


def _radii(way: Way) -> tuple[float, float]:
    assert way.centre is not None
    first, second = way.plane
    of = [
        float(np.hypot(p[first] - way.centre[0], p[second] - way.centre[1]))
        for p in (way.start, way.end)
    ]
    return of[0], of[1]


def _length(way: Way) -> float:
    straight = float(np.linalg.norm(way.end - way.start))
    return straight if way.centre is None else max(straight, abs(way.sweep) * max(_radii(way)))


def _points(way: Way, t: np.ndarray) -> np.ndarray:
    """(A, K) mm at t."""
    point = way.start[:, None] + (way.end - way.start)[:, None] * t
    if way.centre is not None:
        begin, end = _radii(way)
        radius, angle = begin + (end - begin) * t, _angle(way) + way.sweep * t
        point[way.plane[0]] = way.centre[0] + radius * np.cos(angle)
        point[way.plane[1]] = way.centre[1] + radius * np.sin(angle)
    return point


def _distance(way: Way, actual: np.ndarray, rows: list[int]) -> np.ndarray:
    """(K,) mm from points (A, K) to a way, in some axes."""
    if way.centre is None:
        travel = (way.end - way.start)[rows]
        square = float(travel @ travel)
        t = ((actual[rows] - way.start[rows, None]) * travel[:, None]).sum(axis=0) / (square or 1.0)
    else:
        first, second = way.plane
        angle = np.arctan2(actual[second] - way.centre[1], actual[first] - way.centre[0])
        # The turn nearest to where the other axes say it is; the middle of the arc where they rest.
        t = np.full(actual.shape[1], 0.5)
        other = [
            row
            for row in rows
            if row not in way.plane and abs(way.end[row] - way.start[row]) > PLAY_MM
        ]
        for row in other:
            t = (actual[row] - way.start[row]) / (way.end[row] - way.start[row])
        expected = _angle(way) + way.sweep * t
        # off the expected angle by less than half a turn, whole turns taken out
        t = t + np.angle(np.exp(1j * (angle - expected))) / way.sweep
    point = _points(way, np.clip(t, 0.0, 1.0))
    return np.linalg.norm((actual - point)[rows], axis=0)
