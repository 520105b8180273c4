"""What a page about a program draws: places along its path, with the deviation before and after
correction.

A trace sits in the verifier and keeps some of the places that are measured there. However long the
program is, it keeps at most `most` of each series: of two neighbours the one that is farther off
stays, so what is largest is never lost. Lengths of path in each size of deviation and the worst
lines are counted from all places.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from postproc.machine.model import Machine
from postproc.motions import Motions
from postproc.nc.lexer import Words
from postproc.pieces import Pieces
from postproc.units import TICKS_PER_MM

# places of a series: more can not be told apart on a screen, and a page stays below 3 MB
MOST = 4000
TURNS = 600  # take-ups
WORST = 10  # lines
KEPT = 5 * WORST  # of which so many are remembered
SHOWN = 8  # lines that a line became
LONGEST = 200  # characters of a line
# mm: deviations are counted in classes from 1 nm to 10 mm, ten for each power of ten.
CLASSES = 10.0 ** np.arange(-6.0, 1.05, 0.1)


@dataclass(frozen=True)
class Places:
    """N places in the order of the path. s (N,): mm of nominal path before it; point, off, command
    (A, N): mm, the nominal place, actual - nominal, command - nominal; distance (N,): mm from the
    nominal path; u (N,): mm, of the map (95 %);
    line, plain (N,): line of the author's program, and of the one that was corrected; feed (N,):
    whether the way to it cuts."""

    s: np.ndarray
    point: np.ndarray
    off: np.ndarray
    command: np.ndarray
    distance: np.ndarray
    u: np.ndarray
    line: np.ndarray
    plain: np.ndarray
    feed: np.ndarray
    order: np.ndarray

    def __len__(self) -> int:
        return len(self.s)

    def pick(self, which: np.ndarray) -> Places:
        """These of them."""
        return Places(
            **{name: getattr(self, name)[..., which] for name in Places.__dataclass_fields__}
        )

    @staticmethod
    def joined(parts: list[Places]) -> Places:
        """All of several, in the order of the path."""
        columns = {
            name: np.concatenate([getattr(p, name) for p in parts], axis=-1)
            for name in Places.__dataclass_fields__
        }
        whole = Places(**columns)
        # order: number of the motion, and its t; of two at one place the nearer one first
        return whole.pick(np.lexsort((whole.distance, whole.order[1], whole.order[0])))

    @staticmethod
    def none(axes: int) -> Places:
        """No place on a machine of so many axes."""
        flat, tall = np.zeros(0), np.zeros((axes, 0))
        return Places(
            flat, tall, tall, tall, flat, flat, flat.astype(int), flat.astype(int), flat > 0,
            np.zeros((2, 0)),
        )  # fmt: skip


@dataclass
class Series:
    """Places of one run, thinned while they come, alike from beginning to end. step: how many
    places each one that is left stands for."""

    axes: int
    most: int
    step: int = 1
    parts: list[Places] = field(default_factory=list)

    def chosen(self, order: np.ndarray, size: np.ndarray) -> np.ndarray:
        """Which of new places stay: indices in the order of the path, and the size (K,) of all."""
        step = 1
        #    all          a b c d e f g h      of two neighbours the one that is farther off stays.
        #    step 2       b   c   f   h        A batch that comes late is thinned as often as what
        #    step 4       b       f            is there: one density from beginning to end.
        while step < self.step or len(order) > 2 * self.most:
            order, step = order[larger_of_two(size[order])], step * 2
        while self.step < step:
            self._halve()
        return order

    def add(self, places: Places) -> None:
        """Places that `chosen` has left."""
        self.parts.append(places)
        while sum(map(len, self.parts)) > 2 * self.most:
            self._halve()

    def places(self) -> Places:
        """Those that are kept, at most as many as were asked for."""
        while sum(map(len, self.parts)) > self.most:
            self._halve()
        return self._joined()

    def _joined(self) -> Places:
        return Places.joined(self.parts) if self.parts else Places.none(self.axes)

    def _halve(self) -> None:
        whole = self._joined()
        self.parts, self.step = [whole.pick(larger_of_two(whole.distance))], self.step * 2


def larger_of_two(size: np.ndarray) -> np.ndarray:
    """Of each two neighbours the index of the larger one; of an odd number the last one stays."""
    even = len(size) // 2 * 2
    first = np.arange(0, even, 2)
    return np.concatenate([first + (size[1:even:2] > size[:even:2]), np.arange(even, len(size))])


@dataclass(frozen=True)
class Worst:
    """A line and the largest distance from the nominal path on it, mm, before and after."""

    line: int
    before: float
    after: float
    plain: int


@dataclass
class _Batch:
    """What is known of the batch that is being measured. first: lines before it."""

    first: int
    plain: np.ndarray  # (N,) of the corrected program, from 1, line of each motion
    line: np.ndarray
    begin: np.ndarray  # mm of path before each motion
    length: np.ndarray
    before: dict[int, float] = field(default_factory=dict)
    after: dict[int, float] = field(default_factory=dict)


class Trace:
    """before, after: Series of the program as it was and as corrected; length: mm of nominal path;
    turns: (s, line) where a slide's lost motion is taken up, of many some; cuts, take_ups: blocks
    put in; histogram: name to mm of path in each class; text: plain line to itself and what became
    of it."""

    def __init__(self, machine: Machine, most: int = MOST):
        self.machine = machine
        self.before, self.after = (Series(len(machine.letters), most) for _ in range(2))
        self.length = 0.0
        self.turns: list[tuple[float, int]] = []
        self._turned, self._every = 0, 1
        self.cuts = self.take_ups = self.motions = 0
        self.histogram = {name: np.zeros(len(CLASSES) + 1) for name in ("before", "after")}
        self.text: dict[int, tuple[str, tuple[str, ...]]] = {}
        self._worst: dict[int, Worst] = {}
        self._batch: _Batch | None = None

    def begin(self, words: Words, motions: Motions, line: np.ndarray, first_line: int) -> None:
        """A batch follows. line (N,): of the author's program."""
        way = (motions.target - motions.start) / TICKS_PER_MM
        rows = [k for k, x in enumerate(self.machine.letters) if x not in self.machine.chain.rotary]
        known = (motions.start_known & motions.target_known)[rows]
        length = np.sqrt((np.where(known, way[rows], 0.0) ** 2).sum(axis=0))
        # the way round, not the chord; what a helix rises is left out
        length[motions.arcs.motion] = np.abs(motions.arcs.sweep * motions.arcs.radius)
        begin = self.length + np.cumsum(length) - length
        self._batch = _Batch(
            first_line, first_line + words.line[motions.block] + 1, line, begin, length
        )
        self.length += float(length.sum())

    def see(
        self,
        name: str,
        motion: np.ndarray,
        t: np.ndarray,
        feed: np.ndarray,
        places: tuple[np.ndarray, ...],
        u: Callable[[np.ndarray], np.ndarray],
    ) -> None:
        """Places at t (K,) of nominal motions (K,). places: nominal (A, K), command (A, K), actual
        (A, K) mm and distance (K,) mm. u(which): that of the map at some of them."""
        batch = self._batch
        assert batch is not None
        nominal, command, actual, distance = places
        self._count(name, batch, motion, distance, feed)
        series = self.before if name == "before" else self.after
        # The last digits of t depend on how the program was cut.
        which = series.chosen(np.lexsort((np.round(t, 9), motion)), distance)
        own = motion[which]
        part = Places(
            batch.begin[own] + batch.length[own] * t[which], nominal[:, which],
            (actual - nominal)[:, which], (command - nominal)[:, which], distance[which], u(which),
            batch.line[own], batch.plain[own], feed[which],
            np.stack([self.motions + own, np.round(t[which], 9)]),
        )  # fmt: skip
        series.add(part)

    def _count(
        self, name: str, batch: _Batch, motion: np.ndarray, distance: np.ndarray, feed: np.ndarray
    ) -> None:
        """All places: how much path there is of each size, and the largest of each line."""
        each = np.bincount(motion[feed], minlength=len(batch.length))
        # each place stands for as much of its motion's length as its neighbours: mm of path, not
        # counts
        share = batch.length / np.maximum(each, 1)
        sizes = np.searchsorted(CLASSES, distance[feed])
        self.histogram[name] += np.bincount(sizes, share[motion[feed]], len(CLASSES) + 1)
        order = np.argsort(batch.line[motion], kind="stable")
        lines, first = np.unique(batch.line[motion][order], return_index=True)
        # lines as sorted: each begins at `first`, and reduceat takes the largest up to the next
        largest = np.maximum.reduceat(distance[order], first) if len(first) else distance[:0]
        into = batch.before if name == "before" else batch.after
        for line, size in zip(lines.tolist(), largest, strict=True):
            into[line] = max(into.get(line, 0.0), float(size))

    def end(self, words: Words, pieces: Pieces, output: bytes, lines: np.ndarray) -> None:
        """The batch was measured. output: its text; lines (P,): from 0, of the output, where each
        piece stands."""
        batch = self._batch
        assert batch is not None
        self.motions += len(batch.line)
        self.take_ups += int(pieces.take_up.sum())
        self.cuts += len(pieces) - len(batch.line) - int(pieces.take_up.sum())
        done = np.cumsum(pieces.share) - pieces.share  # of the motion, before each piece
        first = np.flatnonzero(np.diff(pieces.motion, prepend=-1))
        # shares count from the motion's own first piece
        done -= np.repeat(done[first], np.diff(first, append=len(pieces)))
        for k in np.flatnonzero(pieces.take_up).tolist():
            if self._turned % self._every == 0:
                motion = int(pieces.motion[k])
                place = float(batch.begin[motion] + batch.length[motion] * done[k])
                self.turns.append((place, int(batch.line[motion])))
            self._turned += 1
        while len(self.turns) > TURNS:
            # as the places: every second, and from now on every second of those that come
            self.turns, self._every = self.turns[::2], self._every * 2
        plain = dict(zip(batch.line.tolist(), batch.plain.tolist(), strict=True))
        for line, after in batch.after.items():
            known = self._worst.get(line)
            if known is None or known.after < after:
                self._worst[line] = Worst(line, batch.before.get(line, 0.0), after, plain[line])
        self._worst = {
            w.line: w for w in sorted(self._worst.values(), key=lambda w: -w.after)[:KEPT]
        }
        self._texts(words, pieces, output, lines)
        self._batch = None

    def worst(self) -> list[Worst]:
        """The lines that are farthest off after correction, the worst first."""
        return list(self._worst.values())[:WORST]

    def _wanted(self) -> np.ndarray:
        """Lines of the program that are drawn or told."""
        drawn = [p.plain for s in (self.before, self.after) for p in s.parts]
        named = np.array([w.plain for w in self._worst.values()], int)
        return np.unique(np.concatenate([*drawn, named]))

    def _texts(self, words: Words, pieces: Pieces, output: bytes, lines: np.ndarray) -> None:
        """Keep the text of lines that are drawn or told, and let go of those that no longer are."""
        batch = self._batch
        assert batch is not None
        wanted = self._wanted()
        if len(self.text) > 4 * MOST:
            self.text = {n: self.text[n] for n in wanted.tolist() if n in self.text}
        new = np.intersect1d(wanted, batch.plain)
        if not len(new):
            return
        own, made = words.text.split(b"\n"), output.split(b"\n")
        of_piece = batch.plain[pieces.motion]
        low, high = (np.searchsorted(of_piece, new, side) for side in ("left", "right"))
        for n, i, j in zip(new.tolist(), low.tolist(), high.tolist(), strict=True):
            became = [
                _shown(made[k]) for k in np.unique(lines[i:j])[:SHOWN].tolist() if k < len(made)
            ]
            self.text[n] = (_shown(own[n - 1 - batch.first]), tuple(became))


def _shown(line: bytes) -> str:
    """A line of a program for a person."""
    return line.decode("utf-8", "replace").strip()[:LONGEST]
