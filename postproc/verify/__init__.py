"""Replay the output as the control would, run it through the machine's model, and measure what is
left.

The output's own text is read again by an interpreter of its own; its motions are sampled between
the nodes, each commanded point is given its deviation, and the distance of that actual point from
the nominal path is the result: once with the tables of the direction in which each slide was last
commanded to move, and once with lost motion as such (slides.py). Ends of rapids count, their ways
do not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from postproc.errors import BlockFault, GcompError, Place
from postproc.filter import Filter
from postproc.machine.poses import axes_of
from postproc.machine.rotary import cross
from postproc.machine.tip import TipMachine, tool_directions
from postproc.motions import FREE, HOLE, RAPID, SPLINE, THREAD, Motions
from postproc.nc.beside_corrected import LIMIT
from postproc.nc.columns import hold_last
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import Words, lex
from postproc.nc.state import ModalState
from postproc.pieces import Pieces
from postproc.slides import Led, Slides
from postproc.trace import Trace
from postproc.units import TICKS_PER_MM
from postproc.verify import kept
from postproc.verify.distance import PLACES, all_known, points_of
from postproc.verify.figures import Figures
from postproc.verify.holes import holes_of
from postproc.verify.kept import begins_of
from postproc.verify.largest import Largest
from postproc.verify.machines import Machines, Warm
from postproc.verify.turning import Turning

STEP_MM = 2.0  # a sample at least every 2 mm
MOST_SAMPLES = 20_000
REPORT_IT = "this is an error of gcomp: please report the program"

NOTHING, END, PATH = 0, 1, 2  # what of a piece counts


class Verifier(Figures):
    """Takes each batch and its output."""

    def __init__(self, filter_: Filter):
        super().__init__(filter_)
        self.name = filter_.name
        # an interpreter and slides of its own: the filter's have gone on by the time a batch is
        # looked at
        self.interpreter = Interpreter(filter_.dialect, filter_.setup)
        self.state: ModalState = self.interpreter.initial()
        filter_.watchers.append(self.check)
        self.nominal_slides, self.slides = (Slides(self.machine, self.hysteresis) for _ in range(2))
        # Line and file that a line of a program that was written out came from; None: it is the
        # program itself.
        self.source: Callable[[int], tuple[int, str]] | None = None
        self.warm = Warm(filter_)
        self.machines = Machines(self.machine, self.oriented, self.warm)
        self.away = 0  # 1: the last rapid was not brought back from a tool change (see _leave)
        self.threads = set[int]()  # their lines
        self.trace: Trace | None = None  # for who wants to draw what is measured

    def check(
        self, words: Words, motions: Motions, pieces: Pieces, output: bytes, first_line: int
    ) -> None:
        """Compare a batch with its output. Raises GcompError when the output can not be read back
        or lost a motion."""
        #    text in  --> motions --> pieces --> text out        the filter
        #                  |           |           |
        #               nominal     counted      read back by an interpreter of its own: measured is
        #                                        what the control will read, not what was planned
        lexed, back = self._read_back(output, first_line)
        for i in np.flatnonzero(back.reason)[:1] if not self.machine.is_zero else ():
            why = back.reasons[int(back.reason[i])][0]
            raise GcompError(
                f"the output can not be followed: {why}",
                LIMIT if why == self.state.beside.fault else REPORT_IT,
                self._near(words, motions, pieces, int(i), first_line),
            )
        # Piece by piece: a block that the control would read as another motion, or not at all,
        # shows here before any distance is measured.
        if len(back) != len(pieces) or (back.code != pieces.code).any():
            most = min(len(back), len(pieces))
            differ = np.append(np.flatnonzero(back.code[:most] != pieces.code[:most]), most)
            raise GcompError(
                f"the output has {len(back)} motions where {len(pieces)} were planned",
                REPORT_IT,
                self._near(words, motions, pieces, int(differ[0]), first_line),
            )
        self.tips |= bool(motions.space.any())
        self.splines |= bool((motions.code == SPLINE).any())
        self.warm.see(words, motions, lexed, back)
        self.motions_in += len(motions)
        self.motions_out += len(back)
        if len(motions):
            grid = motions.grid[list(self.machine.corrected)].max()
            self.grid = max(self.grid, float(grid) / TICKS_PER_MM)
            line = self._own(first_line + words.line[motions.block] + 1)
            self.threads.update(line[motions.code == THREAD].tolist())
            if self.trace:
                self.trace.begin(words, motions, line, first_line)
            near = lambda piece: self._near(words, motions, pieces, piece, first_line)  # noqa: E731
            kept.check(self.machine, motions, pieces, back, self.oriented, near)
            self._measure_both(motions, back, pieces, line)
            if self.trace:
                self.trace.end(words, pieces, output, lexed.line[back.block])

    def _read_back(self, output: bytes, first_line: int) -> tuple[Words, Motions]:
        """Words and motions of the output. Raises GcompError."""
        lexed = lex(output, self.interpreter.dialect.grammar, self.interpreter.setup.block_delete)
        try:
            back, self.state, _ = self.interpreter.run(lexed, self.state)
            if lexed.fault and not self.state.ended:
                raise lexed.fault
        except BlockFault as fault:
            at = int(lexed.line[fault.block]) if fault.block < lexed.blocks else -1
            shown = output.split(b"\n")[at].decode("latin-1")
            raise GcompError(
                f"the output can not be read back: {fault.message}",
                REPORT_IT,
                Place(self.name, int(self._own(np.array([first_line + 1]))[0]), shown),
            ) from None
        return lexed, back

    def _measure_both(
        self, motions: Motions, back: Motions, pieces: Pieces, line: np.ndarray
    ) -> None:
        """What is left of the deviation, and what there was of it in the nominal program."""
        every, one = np.arange(len(motions)), np.ones(len(motions))
        self._leave(motions)
        led, own = self.slides.run(back), self.nominal_slides.run(motions)
        owner, begin = pieces.motion, begins_of(pieces)
        ends = np.where(self.slides.has_play(pieces.start, pieces.end), END, NOTHING)
        # PATH: every place of it; END: a take-up, of which the slides alone count, where it has
        # brought them; NOTHING: a piece that was left as written, or a take-up after which nothing
        # says a side.
        counts = np.where(pieces.corrected, np.where(pieces.take_up, ends, PATH), NOTHING)
        end, sense = begin + pieces.share, own.way(own.leg(every, one))
        there = self.machines.slides(
            motions, every, np.where(motions.target_known, motions.target / TICKS_PER_MM, 0.0)
        )
        ends = own.at(every, one, there, sense, motions.code == RAPID)[0]
        followed = self.centre.check(motions, back, pieces, ends * self.follows, line)
        # inside G41 G42 the words are the contour's: what was followed there is measured along the
        # centre
        inside = motions.cutter != FREE
        beside, both = inside & ~followed, (own, own)
        for into, of in ((self.uncorrected, every >= 0), (self.as_written, beside)):
            some = np.where(of, PATH, NOTHING)
            self._measure(motions, every, 0 * one, one, motions, both, line, into, some)
        for into, of in ((self.corrected, ~inside[owner]), (self.at_contour, beside[owner])):
            some = np.where(of, counts, NOTHING)
            self._measure(motions, owner, begin, end, back, (own, led), line, into, some)
        self._measure_holes(motions, motions, own, line, *[self.uncorrected] * 3)
        self._measure_holes(motions, back, led, line, self.corrected, self.holes, self.taps)

    def _leave(self, motions: Motions) -> None:
        """Tell which rapids are not brought back from a tool change, and which feeds come right
        behind: these begin where a rapid left the axis."""
        away = motions.changed & (motions.word < 0) & (motions.code == RAPID)
        self.left: np.ndarray = away.any(axis=0)
        moves = (motions.target != motions.start).any(axis=0)
        moves[motions.arcs.motion] = True
        # 1: a rapid was left where it was; 0: something moved since; -1: nothing did, so the last
        # one holds, over the end of a batch as well.
        held = hold_last(np.where(self.left, 1, np.where(moves, 0, -1)), self.away)
        self.returns = np.append(self.away, held[:-1]).astype(bool) & ~self.left
        self.away = int(held[-1])

    def _near(
        self, words: Words, motions: Motions, pieces: Pieces, piece: int, first_line: int
    ) -> Place:
        """The program's line that a piece was made of; of one too many, the line of the last."""
        if not len(pieces):
            return Place(self.name, int(self._own(np.array([first_line + 1]))[0]))
        motion = int(pieces.motion[min(piece, len(pieces) - 1)])
        line = first_line + words.line[motions.block[motion : motion + 1]] + 1
        return Place(self.name, int(self._own(line)[0]))

    def _own(self, lines: np.ndarray) -> np.ndarray:
        """Lines as the program's author counts them."""
        if self.source is None:
            return lines
        return np.array([self.source(int(n))[0] for n in lines])

    @property
    def in_thread(self) -> bool:
        """Whether the largest deviation is in a thread."""
        return self.corrected.line in self.threads

    def at_line(self, lines: Iterable[int]) -> bool:
        """Whether the largest deviation is in one of these lines of what was read."""
        return self.corrected.line in self._own(np.array(list(lines), dtype=int))

    def _measure_holes(
        self,
        nominal: Motions,
        run: Motions,
        led: Led,
        line: np.ndarray,
        ends: Largest,
        axes: Largest,
        taps: Largest,
    ) -> None:
        """The axis of each hole from R to its bottom sideways (`axes`, `taps`), and the bottom
        along it (`ends`)."""
        for hole in holes_of(self.machine, nominal, run):
            motion = hole.motion
            self.compared = True
            for slides, weight in enumerate(hole.weights(led)):
                weight = weight * self.follows
                if ends is self.corrected and not slides:
                    lengths = run.length[:, hole.of] / TICKS_PER_MM
                    self.map.see(hole.command, weight, lengths, line[0 * hole.of + motion])
                off = self.machines.deviation(run, (hole.of, hole.t), hole.command, weight)
                deep, aside, bend = hole.off(hole.command + off, list(self.machine.corrected))
                if hole.row in self.machine.corrected:
                    ends.take(deep, int(line[motion]), bool(slides))
                (taps if hole.tap else axes).take(aside, int(line[motion]), bool(slides), bend)

    def _measure(
        self,
        nominal: Motions,
        owner: np.ndarray,
        t0: np.ndarray,
        t1: np.ndarray,
        run: Motions,
        led: tuple[Led, Led],
        line: np.ndarray,
        into: Largest,
        counts: np.ndarray,
    ) -> None:
        """Sample the motions `run`, each standing for t0..t1 of the nominal motion `owner`. led:
        the slides of the nominal program and of this one. counts: PATH; END of a take-up, which
        counts for the slides alone; or NOTHING."""
        known = all_known(self.machine, run.target_known)
        known &= all_known(self.machine, nominal.target_known)[owner] & ~nominal.alone[owner]
        known &= ~self.left[owner]
        # a rapid that was cut has one end: only its last piece has the end that counts
        known &= (run.code != HOLE) & ((run.code != RAPID) | (t1 > 1.0 - 1e-9))
        whole = (
            all_known(self.machine, run.start_known)
            & all_known(self.machine, nominal.start_known)[owner]
            & (run.code != RAPID)
            & ~(self.returns[owner] & (t0 < 1e-9))
        )
        # a thread in one block is corrected at its ends, as a notice says
        whole &= ~nominal.whole[owner]
        # a motion that goes nowhere cuts nothing; an arc may end where it begins and still go all
        # round
        moves = (nominal.target != nominal.start).any(axis=0) | ~all_known(
            self.machine, nominal.start_known
        )
        moves[nominal.arcs.motion] = True
        known &= (counts != NOTHING) & moves[owner]
        path = counts == PATH
        length = np.sqrt((((run.target - run.start) / TICKS_PER_MM) ** 2).sum(axis=0))
        curved, nominal_curved = np.full(len(run), -1), np.full(len(nominal), -1)
        curved[run.arcs.motion] = np.arange(len(run.arcs))
        nominal_curved[nominal.arcs.motion] = np.arange(len(nominal.arcs))
        arc_length = np.abs(run.arcs.sweep * run.arcs.radius)
        length[run.arcs.motion] = arc_length
        count = np.where(
            whole & known & path, np.clip(np.ceil(length / STEP_MM), 4, len(PLACES)), 0
        ).astype(np.int64)
        group = (np.cumsum(count + 1) - 1) // MOST_SAMPLES
        turning = Turning(self.machines, nominal, owner, run, led[1], self.settings.overshoots)
        # so many at a time that memory stays flat
        for g in range(int(group[-1]) + 1 if len(group) else 0):
            which = np.flatnonzero(group == g)
            row = np.repeat(which, count[which])
            # the first PLACES of each piece: of any number of them the golden section leaves no
            # large gap
            place = PLACES[
                np.arange(len(row))
                - np.repeat(np.cumsum(count[which]) - count[which], count[which])
            ]
            ends = which[known[which]]
            begins = which[count[which] > 0]  # where a take-up has brought the slides
            row = np.concatenate([row, ends, begins])
            place = np.concatenate([place, np.ones(len(ends)), np.zeros(len(begins))])
            if not len(row):
                continue
            self.compared = True
            command = points_of(run, curved, row, place)
            t = t0[row] + (t1 - t0)[row] * place
            # A piece may begin or end where an axis turns back: it begins in the direction of the
            # way ahead, and its end is reached in the direction it had before.
            inside = t0[row] + (t1 - t0)[row] * np.clip(place, 1e-6, 1 - 1e-6)
            sense = led[0].way(led[0].leg(owner[row], inside))
            weights = led[1].at(
                row, place, self.machines.slides(run, row, command), sense, run.code[row] == RAPID
            )
            if into is self.corrected:
                lengths = run.length[:, row] / TICKS_PER_MM
                self.map.see(
                    self.machines.slides(run, row, command),
                    weights[0] * self.follows,
                    lengths,
                    line[owner[row]],
                )
            if self.machine.chain.rotary:
                self._lean(nominal, run, (row, owner[row], t), (command, weights[0]), line, into)
            for slides, weight in enumerate(weights if self.machine.two_way.any() else weights[:1]):
                actual = command + self.machines.deviation(
                    run, (row, place), command, weight * self.follows
                )
                on_path = (nominal_curved, owner[row], t)
                distance = self._distance(nominal, on_path, actual, path[row], bool(slides))
                if self.trace and not slides and into is not self.as_written:
                    nominal_at = points_of(nominal, nominal_curved, owner[row], t)
                    places = (nominal_at, command, actual, distance)
                    self._trace(run, row, (owner[row], t), places, weights[0], into, path[row])
                beyond = (distance > self.tolerance) & self.couples & (not slides)
                aside = turning.aside(beyond, (row, place), command, weight)
                # The farthest place need not be the one that fails: what a side of another axis
                # explains (aside) is let pass, and a smaller distance without such an excuse may be
                # the worse.
                for worst in np.argmax(distance), np.argmax(distance - aside):
                    of = int(line[owner[row[worst]]])
                    into.take(float(distance[worst]), of, bool(slides), float(aside[worst]))

    def _distance(
        self, nominal: Motions, where: Any, actual: np.ndarray, path: np.ndarray, slides: bool
    ) -> np.ndarray:
        """(K,) mm from actual points (A, K) to the nominal path. where: arcs, motions and t of
        nominal motions; path (K,): False where a take-up stands, which counts for the slides
        alone."""
        curved, owner, t = where
        distance = self.machines.to_path(nominal, owner, t, actual)
        turns = np.flatnonzero(~path)
        # a take-up stands where the path turns: ahead or behind is off there too
        if len(turns):
            there = points_of(nominal, curved, owner[turns], t[turns])
            off = self.machines.corrected_part(nominal, owner[turns], actual[:, turns] - there)
            distance[turns] = np.linalg.norm(off, axis=0) if slides else 0.0
        return distance

    def _trace(
        self,
        run: Motions,
        row: Any,
        where: Any,
        there: Any,
        weight: np.ndarray,
        into: Largest,
        path: np.ndarray,
    ) -> None:
        """Tell the trace of places: motions of the run and t of nominal motions, and there
        (nominal, command, actual, distance). path (K,): whether it is one of the way, not of a
        take-up."""
        assert self.trace is not None

        def u(some: np.ndarray) -> np.ndarray:
            rows = row[path][some]
            slides = self.machines.slides(run, rows, there[1][:, path][:, some])
            return self.map.at(
                slides, weight[:, path][:, some] * self.follows, run.length[:, rows] / TICKS_PER_MM
            )

        name = "before" if into is self.uncorrected else "after"
        motion, t = (column[path] for column in where)
        self.trace.see(
            name, motion, t, run.code[row[path]] != RAPID, tuple(a[..., path] for a in there), u
        )

    def _lean(
        self,
        nominal: Motions,
        run: Motions,
        which: tuple[np.ndarray, np.ndarray, np.ndarray],
        commands: tuple[np.ndarray, np.ndarray],
        line: np.ndarray,
        into: Largest,
    ) -> None:
        """How far the tool leans at commands (A, K) reached with weights (A, K), away from its
        nominal direction. which: (K,) motions of the run, those of the nominal program, and t
        there."""
        (row, owner, t), (command, weight) = which, commands
        start = (nominal.start / TICKS_PER_MM)[:, owner]
        target = (nominal.target / TICKS_PER_MM)[:, owner]
        moves = all_known(self.machine, nominal.start_known)[owner] & (nominal.code[owner] != RAPID)
        # of a rapid only the end counts, so its tool is looked at as it stands there
        should = axes_of(self.machine, np.where(moves, start + (target - start) * t, target))[1]
        actual = np.zeros_like(should)
        for machine, of in self.machines.each(run, row):
            base = machine.base if isinstance(machine, TipMachine) else machine
            slides = self.machines.slides(run, row[of], command[:, of])
            actual[:, of] = tool_directions(base, slides, weight[:, of] * self.follows)
        lean = np.linalg.norm(cross(should, actual), axis=0)
        worst = int(np.argmax(lean))
        if lean[worst] > into.lean:
            into.lean, into.lean_line = float(lean[worst]), int(line[owner[worst]])
