"""A program as steps: motions of the slides, waits between them, and how fast the spindle turns
meanwhile.

The filter reads the text, as it does for a correction, on the machine without errors: so a program
is understood alike here and there. What the control works out by itself (cycles, cutter radius,
threads) is not simulated but refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace

import numpy as np

from postproc import marks
from postproc.errors import GcompError, Notice, Place
from postproc.filter import Filter
from postproc.machine.model import Machine
from postproc.motions import FREE, HOLE, RAPID, SPLINE, THREAD, Arcs, Motions
from postproc.nc import pace
from postproc.nc.codes import AFTER_MOTION
from postproc.nc.columns import hold_last_float
from postproc.nc.lexer import Words
from postproc.units import TICKS_PER_MM

HALTS = (0, 1, 2, 3, 4, 5, 6, 19, 30, 60)  # M codes for which the slides come to rest


@dataclass(frozen=True)
class Steps:
    """N steps in the order in which they are done; positions are slide positions, mm and degrees, A
    axes.

    end (A, N): where a step ends; begin (A,): where the first begins. wait (N,) s: a rest of so
    long, nan of a motion. rapid (N,); feed (N,) mm/s along the path, or 1/s where inverse (N,): nan
    of rapids and rests. stop (N,): whether the slides come to rest at its end. line (N,): of the
    program. rpm (N,): the spindle's turns per minute. part (N,): 1, 2, ...
    arc (N,): its row in arcs, or -1. length (A, N) mm: of the tool in use."""

    begin: np.ndarray
    end: np.ndarray
    wait: np.ndarray
    rapid: np.ndarray
    feed: np.ndarray
    inverse: np.ndarray
    stop: np.ndarray
    line: np.ndarray
    rpm: np.ndarray
    part: np.ndarray
    arc: np.ndarray
    arcs: Arcs
    length: np.ndarray

    def __len__(self) -> int:
        return len(self.line)


class Reader:
    """Reads a program, once for each part that is made of it."""

    def __init__(
        self,
        machine: Machine,
        make: Callable[[Machine, dict[str, float]], Filter],
        name: str,
        feed: float = np.nan,
    ):
        """make(machine, start) gives a filter for a machine that stands at `start`. feed: mm/s,
        before the first F."""
        self.feed = feed
        self.machine, self.make, self.name = without_errors(machine), make, name
        self.columns: list[dict[str, np.ndarray]] = []
        self.arcs: list[Arcs] = []
        self.notices: list[Notice] = []
        self.corrected = False
        self.spoken = pace.Spoken()

    def read(
        self, text: Iterable[bytes], part: int = 1, start: dict[str, float] | None = None
    ) -> dict[str, float]:
        """One part's program; returns where the axes stand behind it. Raises ProgramError and
        GcompError."""
        filter_ = self.make(self.machine, start or {})
        filter_.name = self.name
        self.dialect, self.letters, self.part = filter_.dialect, filter_.machine.letters, part
        filter_.watchers.append(
            lambda words, motions, pieces, output, lines: self._batch(words, motions, lines)
        )
        for portion in text:
            # The filter refuses its own output, so that none is corrected twice. Here that is
            # wanted: the mark is hidden from it in the same number of bytes.
            self.corrected |= bool(marks.PROGRAM[0].search(portion))
            filter_.feed(marks.PROGRAM[0].sub(lambda found: found[0].replace(b" ", b"_"), portion))
        filter_.finish()
        # the other parts would say the same again
        if part == 1:
            self.notices += filter_.notices
        known = filter_.modal.known
        return {
            x: float(filter_.modal.position[i]) / TICKS_PER_MM
            for i, x in enumerate(self.letters)
            if known[i] and x in self.machine.letters
        }

    def _fault(self, line: int, message: str, advice: str) -> GcompError:
        return GcompError(message, advice, Place(self.name, int(line)))

    def _batch(self, words: Words, motions: Motions, lines: int) -> None:
        """Steps of one batch of the filter. lines: those before it. Blocks that only wait, turn the
        spindle or stop are steps of their own."""
        spindle, self.spoken = pace.spindle(words, self.dialect, self.spoken)
        events = self._events(words)
        if not len(motions) and not events:
            return
        line = words.line[motions.block] + lines + 1
        self._refuse(motions, line)
        n, a = len(motions), len(self.letters)
        feed = self._feed(motions, spindle, line)
        arc = np.full(n, -1, np.int64)
        arc[motions.arcs.motion] = np.arange(len(motions.arcs)) + sum(map(len, self.arcs))
        self.arcs.append(motions.arcs)
        target = np.where(motions.target_known, motions.target / TICKS_PER_MM, np.nan)
        #    3 b          3 b + 1       3 b + 2       of block b: one sort brings motions and rests
        #    M3, M6       its motion    G4, M0, M5    into the order in which they are done
        order = [3.0 * b + 1.0 for b in motions.block.tolist()]
        columns = {
            "end": target,
            "wait": np.full(n, np.nan),
            "rapid": motions.code == RAPID,
            "feed": np.where(motions.code == RAPID, np.nan, feed),
            "inverse": motions.inverse & (motions.code != RAPID),
            "stop": motions.stop > 0,
            "line": line,
            "rpm": spindle.rpm[motions.block],
            "arc": arc,
            "sent": motions.sent.any(axis=0),
            "length": motions.length / TICKS_PER_MM,
        }
        if events:
            m = len(events)
            at = np.array([block for block, _, _ in events])
            rest = {
                "end": np.full((a, m), np.nan), "wait": np.array([s for _, _, s in events]),
                "rapid": np.zeros(m, bool), "feed": np.full(m, np.nan),
                "inverse": np.zeros(m, bool), "stop": np.ones(m, bool),
                "line": words.line[at] + lines + 1, "rpm": spindle.rpm[at], "arc": np.full(m, -1),
                "sent": np.zeros(m, bool), "length": np.full((a, m), np.nan),
            }  # fmt: skip
            order += [3.0 * block + place for block, place, _ in events]
            sort = np.argsort(order, kind="stable")
            columns = {
                k: np.concatenate([columns[k], rest[k]], axis=-1)[..., sort] for k in columns
            }
        columns["part"] = np.full(len(columns["line"]), self.part)
        self.columns.append(columns)

    def _feed(self, motions: Motions, spindle: pace.Spindle, line: np.ndarray) -> np.ndarray:
        """(N,) mm/s, of inverse time 1/s. Raises GcompError for a motion without one."""
        feed = motions.feed * pace.unit_of_feed(motions) / 60.0
        feed = np.where(np.isnan(feed), self.feed, feed)
        # G93: F is blocks a minute, whatever their length
        feed = np.where(motions.inverse, motions.feed / 60.0, feed)
        turning, cuts = spindle.rpm[motions.block], motions.code != RAPID
        by_turn = (spindle.mode[motions.block] == pace.PER_TURN) & cuts
        for k in np.flatnonzero(by_turn & ((turning == 0) | spindle.surface[motions.block]))[:1]:
            raise self._fault(
                line[k],
                "feed per turn (G95), and the spindle's speed is not known",
                "M3 and S in rpm before it, or G94",
            )
        feed = np.where(by_turn, feed * turning, feed)
        for k in np.flatnonzero(cuts & ~(feed > 0))[:1]:
            raise self._fault(
                line[k], "the motion has no feed", "an F above zero before it, or --feed"
            )
        return feed

    def _refuse(self, motions: Motions, line: np.ndarray) -> None:
        """What the slides do there is not what the words say."""
        for k in np.flatnonzero(motions.reason)[:1]:
            message, advice = motions.reasons[int(motions.reason[k])]
            raise self._fault(line[k], message, advice)
        # refused rather than approximated: a simulated recording is taken for what the machine does
        for which, what, advice in (
            (
                motions.code == HOLE,
                "a canned cycle is not simulated as it stands",
                "--expand writes it out as plain blocks",
            ),
            (
                motions.code == THREAD,
                "a thread is not simulated: its feed hangs on the spindle",
                "write it as G1",
            ),
            (
                motions.code == SPLINE,
                "a B-spline is not simulated: where its knots are, the control knows",
                "write lines or arcs, or PL alike in each of its blocks and --expand",
            ),
            (
                motions.space > 0,
                "X Y Z are places of the tool tip or of a tilted plane, which is not simulated",
                "write the places of the slides",
            ),
            (
                motions.cutter != FREE,
                "under cutter radius compensation the slides go beside the words",
                "program the tool centre path",
            ),
        ):
            for k in np.flatnonzero(which)[:1]:
                raise self._fault(line[k], what, advice)

    def _events(self, words: Words) -> list[tuple[int, int, float]]:
        """(block, 0 before its motion or 2 behind it, seconds) of everything for which the slides
        rest."""
        events: list[tuple[int, int, float]] = []
        live = pace.live(words, self.dialect)
        events += [(block, 2, self._seconds(words, block)) for block in pace.dwells(words)]
        for k in np.flatnonzero(words.letter == ord("M")):
            code = int(words.mantissa[k])
            if words.decimals[k] == 0 and code in HALTS:
                events.append((int(words.block[k]), 2 if code in AFTER_MOTION else 0, 0.0))
        return [e for e in events if e[0] <= live]

    def _seconds(self, words: Words, block: int) -> float:
        """How long a G4 block waits."""
        seconds = pace.seconds(words, block, self.dialect)
        if seconds < 0 or seconds > pace.LONGEST:
            raise self._fault(
                words.line[block] + 1, f"a dwell of {seconds:g} s", "is the unit right?"
            )
        if np.isnan(seconds):
            raise self._fault(
                words.line[block] + 1,
                f"how long this dwell lasts on {self.dialect.title} is not known",
                pace.told_by(self.dialect),
            )
        return seconds

    def steps(self, rest: dict[str, float]) -> Steps:
        """All that was read. rest: mm, where an axis stands that the program never places."""
        if not self.columns:
            raise GcompError(f"{self.name} moves nothing", "a program with motions is wanted")
        c = {k: np.concatenate([p[k] for p in self.columns], axis=-1) for k in self.columns[0]}
        end, begin = c["end"], np.zeros(len(self.letters))
        for i, x in enumerate(self.letters):
            # Before its first word an axis stands where that word will find it: nothing is known,
            # and nothing moves.
            known = np.flatnonzero(~np.isnan(end[i]))
            begin[i] = end[i, known[0]] if len(known) else rest.get(x, 0.0)
            end[i] = hold_last_float(end[i], begin[i])
            c["length"][i] = hold_last_float(c["length"][i], 0.0)
        for k in np.flatnonzero(c.pop("sent"))[:1]:
            self.notices.append(
                Notice(
                    "sent",
                    "behind G28 or G30 an axis is taken to come from where it stood before",
                    int(c["line"][k]),
                )
            )
        arcs = Arcs(
            **{
                f.name: np.concatenate([getattr(a, f.name) for a in self.arcs], axis=-1)
                for f in fields(Arcs)
            }
        )
        return Steps(begin=begin, arcs=arcs, **c)


def without_errors(machine: Machine) -> Machine:
    """The machine as its control believes it to be."""
    return replace(machine.bare, control_tables=())
