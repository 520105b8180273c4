"""Replay the output as the control would, run it through the machine's model, and measure what is left.

The output's own text is read again by an interpreter of its own; its motions are sampled between the nodes, each
commanded point is given its deviation, and the distance of that actual point from the nominal path is the result.
Direction of approach comes from the nominal motion, as everywhere. Ends of rapids count, their ways do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.compensate import approach
from postproc.compensate.arcs import points, turning_points
from postproc.errors import BlockFault, GcompError, Place
from postproc.filter import Filter
from postproc.motions import CLOCKWISE, COUNTER, FREE, HOLE, RAPID, Motions
from postproc.nc.beside_corrected import LIMIT
from postproc.nc.interpreter import Interpreter, ModalState
from postproc.nc.lexer import Words, lex
from postproc.pieces import Pieces
from postproc.units import TICKS_PER_MM, UM
from postproc.verify_cutter import CentreVerifier

STEP_MM = 2.0  # a sample at least every 2 mm
MOST_SAMPLES = 20_000
PLACES = (np.arange(1, 129) * 0.6180339887498949) % 1.0  # golden section: never in step with the nodes


@dataclass
class Largest:
    """The largest distance in mm, and the input line it belongs to."""

    deviation: float = 0.0
    line: int = 0


class Verifier:
    """Takes each batch and its output. `corrected` and `uncorrected`: Largest of both programs so far."""

    def __init__(self, filter_: Filter):
        self.machine, self.name, self.mode = filter_.machine, filter_.name, filter_.compensator.mode
        self.tolerance = filter_.compensator.tolerance
        self.interpreter = Interpreter(filter_.dialect, filter_.setup)
        self.state: ModalState = self.interpreter.initial()
        self.limit = 0 if self.mode == "mean" else 1
        self.grid = max(axis.least_increment for axis in self.machine.axes.values())  # mm, larger in inch blocks
        filter_.watchers.append(self.check)
        self.turn = np.zeros(len(self.machine.axes), np.int64)
        self.corrected, self.uncorrected = Largest(), Largest()
        self.at_contour = Largest()  # inside cutter radius compensation, where the centre is not followed
        self.centre = CentreVerifier(self.machine, bool(self.limit))
        self.motions_in = self.motions_out = 0

    def check(self, words: Words, motions: Motions, pieces: Pieces, output: bytes, first_line: int) -> None:
        """Compare a batch with its output. Raises GcompError when the output can not be read back or lost a motion."""
        again = lex(output, self.interpreter.dialect.grammar, self.interpreter.setup.block_delete)
        try:
            back, self.state, _ = self.interpreter.run(again, self.state)
            if again.fault and not self.state.ended:
                raise again.fault
        except BlockFault as fault:
            line = output.split(b"\n")[int(again.line[fault.block]) if fault.block < again.blocks else -1].decode(
                "latin-1"
            )
            raise GcompError(
                f"the output can not be read back: {fault.message}",
                "this is an error of gcomp: please report the program",
                Place(self.name, first_line + 1, line),
            ) from None
        for i in np.flatnonzero(back.reason)[:1] if not self.machine.is_zero else ():
            why = back.reasons[int(back.reason[i])][0]
            raise GcompError(
                f"the output can not be followed: {why} (near line {first_line + 1})",
                LIMIT if why == self.state.beside.fault else "this is an error of gcomp: please report the program",
            )
        if len(back) != len(pieces) or (back.code != pieces.code).any():
            raise GcompError(
                f"the output has {len(back)} motions where {len(pieces)} were planned (near line {first_line + 1})",
                "this is an error of gcomp: please report the program",
            )
        if len(motions):
            self.grid = max(self.grid, float(motions.grid[list(self.machine.corrected)].max()) / TICKS_PER_MM)
        self.motions_in += len(motions)
        self.motions_out += len(back)
        if len(motions):
            line = first_line + words.line[motions.block] + 1
            self._measure(
                motions,
                np.arange(len(motions)),
                np.zeros(len(motions)),
                np.ones(len(motions)),
                motions,
                line,
                self.uncorrected,
                None,
            )
            owner = pieces.motion
            begin = np.cumsum(pieces.share) - pieces.share
            first = np.concatenate([[True], owner[1:] != owner[:-1]])
            begin -= begin[first][np.cumsum(first) - 1]
            followed = self.centre.check(motions, back, pieces, self.weights, line)
            counts, inside = ~pieces.take_up & pieces.corrected, (motions.cutter != FREE)[owner]
            for into, of in ((self.corrected, ~inside), (self.at_contour, inside & ~followed[owner])):
                self._measure(motions, owner, begin, begin + pieces.share, back, line, into, counts & of)
            self._measure_holes(motions, motions, line, self.uncorrected)
            self._measure_holes(motions, back, line, self.corrected)
            self.turn = self.after

    def _measure_holes(self, nominal: Motions, run: Motions, line, into: Largest) -> None:
        """The axis of each hole from R to its bottom, sideways, and the bottom along it too."""
        holes, drilled = nominal.holes, run.holes
        counts = (
            self._all(nominal.target_known)[holes.motion] & ~nominal.alone[holes.motion]
            if len(holes)
            else holes.initial
        )
        for k in np.flatnonzero(counts):
            row, motion = int(holes.axis[k]), int(holes.motion[k])
            t = np.concatenate([PLACES[:32], [1.0]])
            command = np.repeat(run.target[:, [drilled.motion[k]]] / TICKS_PER_MM, len(t), axis=1)
            top, bottom = drilled.level[k] / TICKS_PER_MM, drilled.bottom[k] / TICKS_PER_MM
            command[row] = top + (bottom - top) * t
            weight = np.repeat(self.weights[:, [motion]], len(t), axis=1)
            weight[row] = np.sign(bottom - top) if self.limit else 0.0
            off = command + self._deviation(run, np.full(len(t), drilled.motion[k]), command, weight)
            off -= nominal.target[:, [motion]] / TICKS_PER_MM
            off[row, :-1] = 0.0
            off[row, -1] += (nominal.target[row, motion] - holes.bottom[k]) / TICKS_PER_MM
            distance = np.linalg.norm(off[list(self.machine.corrected)], axis=0)
            if distance.max() > into.deviation:
                into.deviation, into.line = float(distance.max()), int(line[motion])

    def _measure(self, nominal: Motions, owner, t0, t1, run: Motions, line, into: Largest, counts) -> None:
        """Sample the motions `run`, each standing for t0..t1 of the nominal motion `owner`."""
        known = self._all(run.target_known)
        known &= self._all(nominal.target_known)[owner] & ~nominal.alone[owner]
        known &= run.code != HOLE
        whole = self._all(run.start_known) & self._all(nominal.start_known)[owner] & (run.code != RAPID)
        if counts is not None:
            known &= counts
        length = np.sqrt((((run.target - run.start) / TICKS_PER_MM) ** 2).sum(axis=0))
        curved = np.full(len(run), -1)
        curved[run.arcs.motion] = np.arange(len(run.arcs))
        arc_length = np.abs(run.arcs.sweep * run.arcs.radius)
        length[run.arcs.motion] = arc_length
        count = np.where(whole & known, np.clip(np.ceil(length / STEP_MM), 4, len(PLACES)), 0).astype(np.int64)
        weights = self._follow(nominal)
        group = (np.cumsum(count + 1) - 1) // MOST_SAMPLES
        for g in range(int(group[-1]) + 1 if len(group) else 0):  # so many at a time that memory stays flat
            which = np.flatnonzero(group == g)
            row = np.repeat(which, count[which])
            place = PLACES[np.arange(len(row)) - np.repeat(np.cumsum(count[which]) - count[which], count[which])]
            ends = which[known[which]]
            begins = which[count[which] > 0]  # where a take-up has brought the slides
            row = np.concatenate([row, ends, begins])
            place = np.concatenate([place, np.ones(len(ends)), np.zeros(len(begins))])
            if not len(row):
                continue
            command = self._points(run, curved, row, place)
            t = t0[row] + (t1 - t0)[row] * place
            # The end of a piece may be where an axis turns back: it is still reached in the direction it had before.
            weight = self._weight(
                nominal, weights, owner[row], t0[row] + (t1 - t0)[row] * np.clip(place, 1e-6, 1 - 1e-6)
            )
            actual = command + self._deviation(run, row, command, weight)
            distance = self._distance(nominal, owner[row], t, actual)
            worst = int(np.argmax(distance))
            if distance[worst] > into.deviation:
                into.deviation, into.line = float(distance[worst]), int(line[owner[row[worst]]])

    def _deviation(self, run: Motions, row: np.ndarray, command: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """(A, K) mm at commands that belong to motions `row`, each with the tool that it had."""
        if not self.machine.turns or not run.length.any():
            return self.machine.deviation(command, weight)
        result = np.zeros_like(command)
        lengths, which = np.unique(run.length[:, row], axis=1, return_inverse=True)
        for k, length in enumerate(lengths.T):
            of = which.ravel() == k
            tool = [
                length[self.machine.letters.index(x)] / TICKS_PER_MM if x in self.machine.letters else 0.0
                for x in "XYZ"
            ]
            result[:, of] = self.machine.with_tool((tool[0], tool[1], tool[2])).deviation(command[:, of], weight[:, of])
        return result

    def _all(self, known: np.ndarray) -> np.ndarray:
        return np.all(known[list(self.machine.chained)], axis=0)

    @staticmethod
    def _points(motions: Motions, curved, row, t) -> np.ndarray:
        """(A, K) mm: points of motions at t."""
        start, target = motions.start / TICKS_PER_MM, motions.target / TICKS_PER_MM
        result = start[:, row] + (target - start)[:, row] * t
        result = np.where(t == 1.0, target[:, row], result)
        on = curved[row] >= 0
        if on.any():
            of = motions.arcs.motion
            result[:, on] = points(motions.arcs, start[:, of], target[:, of], curved[row[on]], t[on])
        return result

    def _follow(self, nominal: Motions) -> np.ndarray:
        """(A, N) weight of approach of nominal motions, from the sign of each axis' last move; arcs: at their end."""
        travel = np.where(nominal.start_known & nominal.target_known, nominal.target - nominal.start, 0)
        holes = nominal.holes
        if len(holes):
            travel[holes.axis, holes.motion] = holes.level - holes.bottom
        forget = ~nominal.start_known & nominal.target_known & (nominal.word >= 0)
        arcs = nominal.arcs
        if len(arcs):
            n = len(arcs)
            for axes in (arcs.first, arcs.second):
                travel[axes, arcs.motion] = self._sense(nominal, axes, np.arange(n), np.ones(n))
        _, after = approach.follow(travel, forget, self.turn, self.limit)
        self.after = after[:, -1].copy()
        self.weights: np.ndarray = after.astype(float)
        return self.weights

    def _sense(self, nominal: Motions, axis, arc, t) -> np.ndarray:
        """(K,) sign of the way that an axis goes in the part of an arc, between two turning points, that t lies in."""
        arcs = nominal.arcs
        start, target = nominal.start[:, arcs.motion] / TICKS_PER_MM, nominal.target[:, arcs.motion] / TICKS_PER_MM
        where, at = turning_points(arcs, start, target)
        n = np.arange(len(arcs))
        owner, edge = np.concatenate([n, where, n]), np.concatenate([0.0 * n, at, 0.0 * n + 1.0])
        order = np.lexsort((edge, owner))
        owner, edge = owner[order], edge[order]
        right = np.maximum(np.searchsorted(2.0 * owner + edge, 2.0 * arc + np.clip(t, 1e-12, 1.0)), 1)
        column = np.arange(len(arc))
        ends = [points(arcs, start, target, arc, edge[k])[axis, column] for k in (right - 1, right)]
        return np.sign(ends[1] - ends[0]).astype(np.int64)

    def _weight(self, nominal: Motions, weights: np.ndarray, owner, t) -> np.ndarray:
        """(A, K) weight of approach at t of nominal motions; on arcs from the direction there."""
        arcs = nominal.arcs
        weight = weights[:, owner]
        curved = np.full(len(nominal), -1)
        curved[arcs.motion] = np.arange(len(arcs))
        on = np.flatnonzero(curved[owner] >= 0)
        if len(on) and self.limit:
            arc = curved[owner[on]]
            for axes in (arcs.first, arcs.second):
                sense = self._sense(nominal, axes[arc], arc, t[on])
                weight[axes[arc], on] = np.where(
                    sense == 0, weight[axes[arc], on], sense
                )  # at rest it keeps its direction
        return weight

    def _distance(self, nominal: Motions, owner, t, actual) -> np.ndarray:
        """(K,) mm from actual points to their nominal path, in the corrected axes."""
        rows = list(self.machine.corrected)
        start, target = (nominal.start / TICKS_PER_MM)[:, owner], (nominal.target / TICKS_PER_MM)[:, owner]
        point = actual[rows]
        way = (target - start)[rows]
        rapid = (nominal.code[owner] == RAPID) | ~self._all(nominal.start_known)[owner]
        square = (way**2).sum(axis=0)
        along = np.where(square > 0, ((point - start[rows]) * way).sum(axis=0) / np.where(square > 0, square, 1.0), 1.0)
        turning = [self.machine.letters.index(x) for x in self.machine.chain.rotary]
        if turning:  # while the part or the tool turns, being ahead on the path is as wrong as being beside it
            along = np.where((target - start)[turning].any(axis=0), t, along)
        along = np.where(rapid | (t == 1.0), 1.0, np.clip(along, 0.0, 1.0))
        distance = np.sqrt(((point - start[rows] - way * along) ** 2).sum(axis=0))
        at_target = np.sqrt(((point - target[rows]) ** 2).sum(axis=0))
        distance = np.where(along == 1.0, at_target, distance)
        curved = np.isin(nominal.code[owner], (CLOCKWISE, COUNTER)) & (t < 1.0) & ~rapid
        if curved.any():
            arc_of = np.full(len(nominal), -1)
            arc_of[nominal.arcs.motion] = np.arange(len(nominal.arcs))
            k = np.flatnonzero(curved)
            distance[k] = self._from_arc(nominal, arc_of[owner[k]], t[k], actual[:, k], start[:, k], target[:, k])
        return distance

    def _from_arc(self, nominal: Motions, arc, t, actual, start, target) -> np.ndarray:
        """(K,) mm from points to a circle, spiral or helix: across in the plane, and along the other axes."""
        arcs, column = nominal.arcs, np.arange(len(arc))
        first, second = arcs.first[arc], arcs.second[arc]
        arm = np.stack([actual[first, column], actual[second, column]]) - arcs.centre[:, arc]
        angle = np.arctan2(arm[1], arm[0])
        expected = arcs.angle[arc] + arcs.sweep[arc] * t
        t = t + np.angle(np.exp(1j * (angle - expected))) / arcs.sweep[arc]
        t = np.clip(t, 0.0, 1.0)
        radius = arcs.radius[arc] + (arcs.radius_end - arcs.radius)[arc] * t
        # From the nominal point at t: outwards, and what is left of the way ahead and along once the helix' own
        # direction is taken out.
        outwards = (np.hypot(*arm) - radius) ** 2
        turn = radius * np.angle(np.exp(1j * (angle - arcs.angle[arc] - arcs.sweep[arc] * t)))
        pace = radius * arcs.sweep[arc]
        square, along, length = turn**2, turn * pace, pace**2
        for row in self.machine.corrected:
            way = np.where((first != row) & (second != row), (target - start)[row], 0.0)
            off = np.where((first != row) & (second != row), actual[row] - start[row] - way * t, 0.0)
            square, along, length = square + off**2, along + off * way, length + way**2
        square = outwards + np.maximum(square - along**2 / np.maximum(length, 1e-30), 0.0)
        return np.sqrt(square)

    @property
    def passed(self) -> bool:
        """Whether the output keeps the tolerance; ramp and off spread reversals by choice, and are only measured,
        as is what stays inside cutter radius compensation, where nothing may be put in: there it must not get worse."""
        self.centre.finish()
        allowed, centre = self.tolerance + self.grid / 2 + 1e-9, self.centre
        better = centre.corrected.deviation <= max(allowed, centre.uncorrected.deviation)
        return better and (self.mode in ("ramp", "off") or self.corrected.deviation <= allowed)

    def _beside(self) -> str:
        said = self.centre.report(self.tolerance + self.grid / 2)
        if self.at_contour.deviation:
            said += (
                f"; inside G41 G42, at the contour, where no centre is followed, {self.at_contour.deviation / UM:.2f} um "
                f"(line {self.at_contour.line})"
            )
        return said

    def report(self) -> str:
        """One line for a person: before, after, and their ratio."""
        before, after = self.uncorrected.deviation, self.corrected.deviation
        ratio = f", {before / after:.0f} times less" if after > 0 and before > after else ""
        return (
            f"largest deviation from the nominal path {after / UM:.2f} um (line {self.corrected.line}), "
            f"uncorrected {before / UM:.2f} um (line {self.uncorrected.line}){ratio}; tolerance {self.tolerance / UM:g} um; "
            f"{self.motions_in} motions in, {self.motions_out} out{self._beside()}"
        )
