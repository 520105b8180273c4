"""What the slides must do along arcs, as samples that lie where postproc.compensate.stretches says.

Each arc is looked at once, all arcs of a batch together, the samples of one behind those of the
other.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.compensate.arc_rows import Fitter, Rows
from postproc.compensate.arcs import direction
from postproc.compensate.inverse import ROUNDS
from postproc.compensate.laid import Laid
from postproc.compensate.laid import laid as by_kernel
from postproc.compensate.nodes import spread
from postproc.compensate.stretches import SHARE, WIDEST, Stretches, stretches
from postproc.records import columns, replace

BENT = 0.5 / np.cos(WIDEST)  # of a second difference: postproc.compensate.stretches
NOTHING = 1e-30  # mm
MOST_SAMPLES = 100_000  # worked on at once: more leave the processor's cache, and take memory


@columns
class Samples:
    """N samples of R rows, all in one plane of the axes `first` and `second`, row behind row. t
    (N,): on the arc; unit (2, N): outwards from the nominal centre; place (2, N): mm from that
    centre, the exact command in the plane; radial (N,): mm, how far outside the nominal path it
    lies; across (C, N) mm: the command of the other corrected axes `beside` (C,), and turn (C, N)
    mm how it bends from each sample to the next (`bent`); command (A, N) mm: in all axes; smooth
    (N,): BENT at samples whose neighbours on both sides lie as far away and on the same smooth
    stretch, else 0. begin, last (R,): the first and the last sample of each row; rest (R,): mm
    that can hide beyond what second differences tell."""

    first: int
    second: int
    beside: tuple[int, ...]
    command: np.ndarray
    t: np.ndarray
    unit: np.ndarray
    place: np.ndarray
    radial: np.ndarray
    across: np.ndarray
    turn: np.ndarray
    smooth: np.ndarray
    begin: np.ndarray
    last: np.ndarray
    rest: np.ndarray

    def pick(self, which: np.ndarray) -> Samples:
        """Those of some rows alone."""
        begin, last, rest = self.begin[which], self.last[which], self.rest[which]
        return replace(self, begin=begin, last=last, rest=rest)

    def at(self, which: np.ndarray) -> Samples:
        """Some samples (N,) alone, whatever rows they are of."""
        return replace(self, **{name: getattr(self, name).take(which, axis=-1) for name in EACH})

    def until(self, low: np.ndarray, high: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(R,) the first sample from `low` on that lies at t (R,) or behind it, `high` at most."""
        low, high = low.copy(), high.copy()
        while (low < high).any():
            middle = (low + high) // 2
            before = (self.t[middle] < t) & (low < high)
            low, high = np.where(before, middle + 1, low), np.where(before, high, middle)
        return low


EACH = ("t", "place", "across", "turn", "smooth")  # what a proof looks at in each


def bent(value: np.ndarray, smooth: np.ndarray) -> np.ndarray:
    """(..., N) how much values bend from each sample to the next: half the second difference at
    either of both, the larger one, where they have one."""
    step = value[..., 1:] - value[..., :-1]
    turn = np.zeros_like(value)
    inner = turn[..., 1:-1]
    np.subtract(step[..., 1:], step[..., :-1], out=inner)
    np.abs(inner, out=inner)
    turn *= smooth
    np.maximum(turn[..., :-1], turn[..., 1:], out=turn[..., :-1])
    return turn


def beyond(value: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(..., N) how far values that bend by `turn` (..., N) can lie beyond the larger of a sample
    and either neighbour between these: as far as a parabola does, whose top lies there."""
    over = value[..., 1:] - value[..., :-1]
    np.abs(over, out=over)
    np.subtract(turn[..., :-1], over, out=over)
    np.maximum(over, 0.0, out=over)
    over *= over
    size = turn[..., :-1] * 4.0
    size += NOTHING
    over /= size
    wide = np.zeros_like(value)
    wide[..., :-1] = over
    np.maximum(wide[..., 1:], over, out=wide[..., 1:])
    return wide


def taken(f: Fitter, rows: Rows) -> Iterator[tuple[np.ndarray, Samples]]:
    """Rows in sets of one plane, by their numbers, with their samples."""
    way, arc = stretches(f, rows), rows.arc
    count = np.bincount(way.row, weights=way.parts, minlength=len(rows)).astype(np.int64) + 1
    kind = (f.arcs.first[arc] * len(f.start) + f.arcs.second[arc]) * 2 + f.plain[arc]
    order = np.argsort(kind, kind="stable")
    part = np.cumsum(count[order]) // MOST_SAMPLES
    edges = (np.diff(kind[order]) != 0) | (np.diff(part) != 0)
    for which in np.split(order, np.flatnonzero(edges) + 1):
        yield which, _samples(f, rows.pick(which), which, count[which], way)


def _placed(
    rows: Rows, which: np.ndarray, count: np.ndarray, way: Stretches
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) t of the samples of rows `which`, `count` (R,) each, and (N,) whether a sample lies
    inside its stretch."""
    begin = way.row.searchsorted(which)
    owner, nth = spread(way.row.searchsorted(which, side="right") - begin)
    stretch = begin[owner] + nth
    parts = way.parts[stretch]
    parts[np.append(np.flatnonzero(np.diff(owner)), len(owner) - 1)] += 1  # the end of the row
    owner, index = spread(parts)
    t = (way.t[stretch])[owner] + way.step[stretch][owner] * index
    last = np.cumsum(count) - 1
    t[last] = rows.t1
    inside = index > 0
    inside[last] = False
    return t, inside


def laid(f: Fitter, rows: Rows, which: np.ndarray, count: np.ndarray, way: Stretches) -> Laid:
    """(N,) t and smooth, (2, N) unit of the samples, as of Samples; (N,) mm the nominal radius and
    (A, N) mm place there; and (A, N) mm by which the exact command will lie beside that, as far as
    can be foreseen: between the ends, whose commands are known, the shift is nearly linear."""
    arcs, arc = f.arcs, rows.arc
    if f.plain[arc[0]]:
        compiled = by_kernel(f, rows, which, count, way, BENT)
        if compiled is not None:
            return compiled
    t, inside = _placed(rows, which, count, way)
    smooth = np.where(inside & f.plain[arc[0]], BENT, 0.0)

    def each(value: np.ndarray) -> np.ndarray:
        return value.repeat(count, axis=-1)

    angle = each(arcs.angle[arc]) + each(arcs.sweep[arc]) * t
    unit = direction(angle)
    radius = each(arcs.radius[arc]) + each(f.grown[arc]) * t
    start, target = f.start.take(arc, axis=1), f.target.take(arc, axis=1)
    nominal = each(target - start)
    nominal *= t
    nominal += each(start)
    for k, axis in enumerate((arcs.first[arc[0]], arcs.second[arc[0]])):
        nominal[axis] = each(arcs.centre[k].take(arc)) + radius * unit[k]
    shift = way.shift.take(which, axis=-1)
    guess = each(shift[1] - shift[0])
    guess *= (t - each(rows.t0)) / each(rows.t1 - rows.t0)
    guess += each(shift[0])
    return t, smooth, unit, radius, nominal, guess


def _samples(
    f: Fitter, rows: Rows, which: np.ndarray, count: np.ndarray, way: Stretches
) -> Samples:
    """The samples of rows of one plane, which are those numbered `which` (R,) of `way`, `count`
    (R,) each."""
    arcs, arc = f.arcs, rows.arc
    first, second = int(arcs.first[arc[0]]), int(arcs.second[arc[0]])
    t, smooth, unit, radius, nominal, guess = laid(f, rows, which, count, way)
    last = np.cumsum(count) - 1
    begin = last - count + 1
    row = np.repeat(np.arange(len(rows)), count)
    rest = way.rest[which]
    if f.plain[arc[0]]:
        exact, miss = _commands(f, rows, nominal, guess, row, count)
        miss = np.maximum.reduceat(miss, begin)
        rest = rest + f.total * SHARE / 8 + 2 * way.steep[which] * miss
    else:
        exact = f.needed(rows, row, t, nominal)
    place = exact.take((first, second), axis=0)
    place -= arcs.centre.take(arc, axis=1).repeat(count, axis=1)
    radial = unit[0] * place[0]
    radial += unit[1] * place[1]
    radial -= radius
    beside = tuple(k for k in f.machine.corrected if k not in (first, second))
    across = exact[list(beside)]
    return Samples(
        first, second, beside, exact, t, unit, place, radial, across, bent(across, smooth), smooth,
        begin, last, rest,
    )  # fmt: skip


def _commands(
    f: Fitter,
    rows: Rows,
    nominal: np.ndarray,
    guess: np.ndarray,
    row: np.ndarray,
    count: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """(A, N) mm exact commands of nominal places of rows `row` (N,), `count` (R,) each, and (N,) mm
    by which they were foreseen wrongly, of `guess` (A, N) mm, which is overwritten.

    One look at the map where the command was foreseen tells it: looked up beside the true place by
    d, it is wrong by `steepest` d, and by as much less again after each further look, which are
    taken where that is too much."""
    machine = f.machine
    weight = f.weight(rows).repeat(count, axis=1)
    found = machine.deviation(nominal + guess, weight)
    guess += found
    miss = np.abs(guess, out=guess).max(axis=0)
    exact = np.subtract(nominal, found, out=found)
    wrong = miss
    for _ in range(ROUNDS):
        wrong = wrong * machine.bounds.steepest
        at = (wrong > f.total * SHARE / 8).nonzero()[0]
        if not len(at):
            break
        found = machine.deviation(exact.take(at, axis=1), weight.take(at, axis=1))
        exact[:, at] = nominal.take(at, axis=1) - found
    return (f.led(rows, row, exact) if len(f.followed) else exact), miss
