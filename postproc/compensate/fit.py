"""Arcs stay arcs where that is provable, else they are cut, and where they get too short they
become chords.

A circle stays a circle only under a similarity; a map that stretches X and Z differently makes it
an ellipse. So each arc is sampled so that nothing can hide between two samples
(postproc.compensate.samples), once, and every piece is a run of these samples: all of the arc if
that will do, else both halves, else as much at a time as will do. `Proof` says what will do.

    samples          .  .  .  .  .  .  .  .  .  .  .  .  .
    all              |-----------------------------------|
    both halves      |-----------------|-----------------|
    the longest run  |-----------|                            then the rest, in the same way
    one interval     |--|                                     is looked at closer, with new samples
"""

from __future__ import annotations

import numpy as np

from postproc.compensate import compiled
from postproc.compensate.arc_rows import Fitter, Rows, joined
from postproc.compensate.prove import Proof
from postproc.compensate.samples import Samples, taken
from postproc.records import replace

NEARLY = 100  # a run is the longest that will do if one longer by a sixth of its samples will not
LEVELS = 14  # times that what one sample interval is too long for is looked at closer


def settle(f: Fitter, rows: Rows) -> Rows:
    """Accept, cut or turn to chords until every part is within tolerance; in no particular
    order."""
    done: list[Rows] = []
    closer = replace(f, plain=np.zeros_like(f.plain))
    for level in range(LEVELS + 1):
        if not len(rows):
            break
        rest: list[Rows] = []
        fitter = f if level == 0 else closer
        for which, samples in taken(fitter, rows):
            some = rows.pick(which)
            pieces, left = compiled.settle(fitter, some, samples)
            done += pieces
            if len(left):
                some, samples = some.pick(left), samples.pick(left)
                Cutting(f, some, samples, done, rest).run(level == LEVELS)
        rows = joined(rest) if rest else rows.pick(np.zeros(0, np.int64))
    return joined(done)


class Cutting:
    """R rows with their samples, from sample `low` (R,) on still to be cut; into `done` go pieces,
    into `rest` intervals of two samples of which no arc can be made."""

    def __init__(self, f: Fitter, rows: Rows, samples: Samples, done: list[Rows], rest: list[Rows]):
        self.f, self.rows, self.samples = f, rows, samples
        self.done, self.rest = done, rest
        self.low = samples.begin

    def pick(self, which: np.ndarray) -> None:
        """Go on with some rows alone."""
        self.rows = self.rows.pick(which)
        self.samples = self.samples.pick(which)
        self.low = self.low[which]

    def run(self, final: bool) -> None:
        """Cut all; final: what is no arc is made a chord."""
        good, proof = self.tried(self.low, self.samples.last)
        self.done.append(proof.rows.pick(good))
        if good.all():
            return
        tiny, flat = self.f.short(self.rows)
        chord = ~good & (tiny | final)
        if (flat & ~good & ~chord).any():
            chord |= ~good & flat & proof.straight()
        self.done.append(replace(self.rows.pick(chord), chord=np.ones(int(chord.sum()), bool)))
        self.pick(~good & ~chord)
        while len(self.rows):
            self._halve_inside()
            self._intervals()
            if not len(self.rows):
                break
            best, reach, over, excess = self._halves()
            if len(self.rows):
                self._longest(best, reach, over, excess)
                good, proof = self.tried(self.low, self.samples.last)
                self.done.append(proof.rows.pick(good))
                self.pick(~good)

    def tried(
        self, low: np.ndarray, high: np.ndarray, which: np.ndarray | slice = slice(None)
    ) -> tuple[np.ndarray, Proof]:
        """(R,) whether the runs from sample low to sample high (R,) of rows will do as arcs, and
        their proof."""
        rows, samples = self.rows, self.samples
        if not isinstance(which, slice):
            rows, samples = rows.pick(which), samples.pick(which)
        begins, ends = low > self.low[which], high < samples.last
        begin, end = rows.begin, rows.end
        if begins.any():
            begin = np.where(begins, self._ticks(rows, low), begin)
        if ends.any():
            end = np.where(ends, self._ticks(rows, high), end)
        t0, t1 = samples.t[low], np.where(ends, samples.t[high], rows.t1)
        proof = Proof(self.f, replace(rows, t0=t0, t1=t1, begin=begin, end=end), samples, low, high)
        return proof.run(), proof

    def _ticks(self, rows: Rows, at: np.ndarray) -> np.ndarray:
        """(A, R) ticks commanded at samples (R,) of rows."""
        return self.f.round_to(rows.stroke, self.samples.command.take(at, axis=1))

    def _halve_inside(self) -> None:
        """Inside cutter radius compensation pieces have a least length: both halves are looked at
        anew."""
        inside = self.f.inside[self.rows.arc]
        if inside.any():
            rows, samples = self.rows.pick(inside), self.samples.pick(inside)
            half = (samples.begin + samples.last) // 2
            ticks, t = self._ticks(rows, half), samples.t[half]
            self.rest += [replace(rows, t1=t, end=ticks), replace(rows, t0=t, begin=ticks)]
            self.pick(~inside)

    def _intervals(self) -> None:
        """What is one interval of samples and no arc is to be looked at closer."""
        single = self.low + 1 == self.samples.last
        if single.any():
            self.rest.append(self.rows.pick(single))
            self.pick(~single)

    def _halves(self) -> tuple[Rows, np.ndarray, np.ndarray, np.ndarray]:
        """Take both halves of a row where both will do. Of the others: the longest first run that
        is known to do, the samples (R,) that it reaches and that it does not, and how much too
        far from the path (R,) a run to there is, 0: not known."""
        low, last, n = self.low, self.samples.last, len(self.rows)
        half = (low + last) // 2
        every = np.arange(n)
        good, proof = self.tried(
            np.concatenate([low, half]),
            np.concatenate([half, last]),
            np.concatenate([every, every]),
        )
        before, both = good[:n], good[:n] & good[n:]
        self.done.append(proof.rows.pick(np.concatenate([both, both])))
        rest = np.flatnonzero(~both)
        reach, over = np.where(before, half, low)[rest], np.where(before, last, half)[rest]
        self.pick(rest)
        return proof.rows.pick(rest), reach, over, np.where(before, 0.0, proof.excess[:n])[rest]

    def _longest(self, best: Rows, reach: np.ndarray, over: np.ndarray, excess: np.ndarray) -> None:
        """Take the longest first run of each row that will do, which ends between two samples
        (R,), or leave its first interval to be looked at closer. What is too far from the path by
        `excess` is so with the square of its length."""
        while True:
            which = np.flatnonzero(over - reach > np.maximum((reach - self.low) // NEARLY, 1))
            if not len(which):
                break
            low, least, most = self.low[which], reach[which], over[which]
            t = self.samples.t
            # What is off by `excess` limits over a way t is off by one over t / sqrt(excess).
            far = t[low] + (t[most] - t[low]) / np.sqrt(np.maximum(excess[which], 1.0))
            near = self.samples.until(low, most, np.nextafter(far, 2.0)) - 1
            middle = np.where(excess[which] > 1.0, near, (least + most) // 2)
            middle = np.clip(middle, least + 1, most - 1)
            good, proof = self.tried(low, middle, which)
            reach[which], over[which] = np.where(good, middle, least), np.where(good, most, middle)
            excess[which] = np.where(good, 0.0, proof.excess)
            for name in ("t1", "end", "centre", "radius"):
                getattr(best, name)[..., which[good]] = getattr(proof.rows, name)[..., good]
        found = reach > self.low
        self.done.append(best.pick(found))
        at = np.maximum(reach, self.low + 1)
        ticks, t = self._ticks(self.rows, at), self.samples.t[at]
        self.rest.append(replace(self.rows, end=ticks, t1=t).pick(~found))
        self.rows, self.low = replace(self.rows, begin=ticks, t0=t), at
