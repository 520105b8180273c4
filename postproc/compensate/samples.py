"""What the slides must do along arcs, as samples that lie where postproc.compensate.stretches says.

Each arc is looked at once, all arcs of a batch together: rows of as many samples and of the same
plane share one table (K samples, R rows), whose size does not depend on what else is in the batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from postproc.compensate.inverse import command
from postproc.compensate.stretches import SHARE, stretches

if TYPE_CHECKING:
    from postproc.compensate.fit import Fitter, Rows

MOST_SAMPLES = 80_000  # worked on at once: more leave the processor's cache, and take memory


@dataclass(frozen=True)
class Samples:
    """K samples of R rows, all in one plane of the axes `first` and `second`; behind a row's last
    one it is repeated. t (K, R): on the arc; unit (2, K, R): outwards from the nominal centre;
    place (2, K, R): mm from that centre, the exact command in the plane; radial (K, R): mm, how
    far outside the nominal path it lies; across (C, K, R) mm: the command of the other corrected
    axes `beside` (C,), and bow (C, K, R) mm how far it can lie beyond two samples between them;
    command (A, K, every) mm: in all axes, this row's in `column` (R,); last (R,): the last
    sample; smooth (K, R): 0.125 at samples whose neighbours on both sides lie as far away and on
    the same smooth stretch, else 0; rest (R,): mm that can hide beyond what second differences
    tell."""

    first: int
    second: int
    beside: tuple[int, ...]
    command: np.ndarray
    column: np.ndarray
    t: np.ndarray
    unit: np.ndarray
    place: np.ndarray
    radial: np.ndarray
    across: np.ndarray
    bow: np.ndarray
    last: np.ndarray
    smooth: np.ndarray
    rest: np.ndarray

    def pick(self, which: np.ndarray) -> Samples:
        """Some rows alone."""
        columns = {name: getattr(self, name)[..., which] for name in _COLUMNS}
        return replace(self, **columns)

    def commanded(self, at: np.ndarray) -> np.ndarray:
        """(A, R) mm commanded at sample `at` (R,) of each row."""
        result: np.ndarray = self.command[:, at, self.column]
        return result


_COLUMNS = ("column", "t", "unit", "place", "radial", "across", "bow", "last", "smooth", "rest")


def bend(value: np.ndarray, smooth: np.ndarray) -> np.ndarray:
    """(K, R) how far (K, R) values can lie beyond the larger of two neighbours between these."""
    bow = np.zeros_like(value)
    inner = bow[1:-1]
    np.add(value[:-2], value[2:], out=inner)
    inner -= value[1:-1]
    inner -= value[1:-1]
    np.abs(inner, out=inner)
    bow *= smooth
    wide = bow.copy()
    np.maximum(wide[1:], bow[:-1], out=wide[1:])
    np.maximum(wide[:-1], bow[1:], out=wide[:-1])
    return wide


def taken(f: Fitter, rows: Rows) -> Iterator[tuple[np.ndarray, Samples]]:
    """Rows in sets, by their numbers, with their samples."""
    way = stretches(f, rows)
    row = np.repeat(way.row, way.parts)
    index = np.arange(len(row)) - np.repeat(np.cumsum(way.parts) - way.parts, way.parts)
    t = np.repeat(way.t, way.parts) + np.repeat(way.step, way.parts) * index
    last = np.bincount(way.row, weights=way.parts, minlength=len(rows)).astype(np.int64)
    nth = np.arange(len(row)) - np.repeat(np.cumsum(last) - last, last)
    size = _size(last + 1)
    plain = f.plain[rows.arc]
    arc, begin = rows.arc, 0
    kind = (f.arcs.first[arc] * len(f.start) + f.arcs.second[arc]) * 2 + plain
    order = np.lexsort((size, kind))
    size, kind = size[order], kind[order]
    # Where the t of each row goes: columns of sets that lie one behind the other.
    edges = _sets(size, kind)
    at, wide = np.zeros(len(rows), np.int64), np.zeros(len(rows), np.int64)
    offsets = []
    for low, high in edges:
        at[order[low:high]] = begin + np.arange(high - low)
        wide[order[low:high]] = high - low
        offsets.append(begin)
        begin += int(size[low]) * (high - low)
    every, smooth = np.empty(begin), np.zeros(begin)
    for (low, high), offset in zip(edges, offsets, strict=True):
        stop = offset + int(size[low]) * (high - low)
        every[offset:stop].reshape(-1, high - low)[:] = rows.t1[order[low:high]]
    to = at[row] + nth * wide[row]
    every[to] = t
    smooth[to[(index > 0) & plain[row]]] = 0.125
    for (low, high), offset in zip(edges, offsets, strict=True):
        which, shape = order[low:high], (int(size[low]), high - low)
        part = slice(offset, offset + shape[0] * shape[1])
        one = rows.pick(which)
        yield (
            which,
            _samples(
                f,
                one,
                every[part].reshape(shape),
                smooth[part].reshape(shape),
                last[which],
                way.rest[which],
                way.steep[which],
                way.shift[..., which],
            ),
        )


def _size(count: np.ndarray) -> np.ndarray:
    """(R,) counts, rounded up so that rows of similar length share one table, whatever else is in
    the batch."""
    power: np.ndarray = 2 ** np.maximum(np.ceil(np.log2(count - 1)).astype(np.int64), 4)
    return power + 1


def _sets(size: np.ndarray, kind: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of each set: of one size and kind, MOST_SAMPLES at most."""
    edges = np.flatnonzero((size[1:] != size[:-1]) | (kind[1:] != kind[:-1])) + 1
    found = []
    for low, high in zip([0, *edges.tolist()], [*edges.tolist(), len(size)], strict=True):
        each = max(1, MOST_SAMPLES // int(size[low]))
        found += [(k, min(k + each, high)) for k in range(low, high, each)]
    return found


def _samples(
    f: Fitter,
    rows: Rows,
    t: np.ndarray,
    smooth: np.ndarray,
    last: np.ndarray,
    rest: np.ndarray,
    steep: np.ndarray,
    shift: np.ndarray,
) -> Samples:
    """Samples of rows of one plane at t (K, R)."""
    arcs, arc = f.arcs, rows.arc
    first, second = int(arcs.first[arc[0]]), int(arcs.second[arc[0]])
    angle = arcs.angle[arc] + arcs.sweep[arc] * t
    unit = np.stack([np.cos(angle), np.sin(angle)])
    radius = arcs.radius[arc] + (arcs.radius_end - arcs.radius)[arc] * t
    start, target = f.start[:, arc], f.target[:, arc]
    nominal = start[:, None] + (target - start)[:, None] * t
    begun, over = t[0] == 0.0, t == 1.0
    for axis, which in ((first, 0), (second, 1)):  # ends stay as programmed, to the bit
        round_ = arcs.centre[which, arc] + radius * unit[which]
        round_[0] = np.where(begun, start[axis], round_[0])
        nominal[axis] = np.where(over, target[axis], round_)
    if f.plain[arc[0]]:
        exact, miss = _commands(f, rows, t, nominal, shift)
        rest = rest + f.total * SHARE / 8 + 2 * steep * miss
    else:
        row = np.broadcast_to(np.arange(len(rows)), t.shape).ravel()
        every = nominal.reshape(len(nominal), -1)
        exact = f.needed(rows, row, t.ravel(), every).reshape(nominal.shape)
    place = exact[[first, second]] - arcs.centre[:, arc][:, None]
    radial = unit[0] * place[0] + unit[1] * place[1] - radius
    beside = tuple(k for k in f.machine.corrected if k not in (first, second))
    bow = np.stack([bend(exact[k], smooth) for k in beside]) if beside else np.zeros((0, *t.shape))
    column = np.arange(len(rows))
    return Samples(
        first,
        second,
        beside,
        exact,
        column,
        t,
        unit,
        place,
        radial,
        exact[list(beside)],
        bow,
        last,
        smooth,
        rest,
    )


def _commands(
    f: Fitter, rows: Rows, t: np.ndarray, nominal: np.ndarray, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(A, K, R) mm exact commands of nominal places, and (R,) mm by which they were foreseen
    wrongly at most.

    Between the ends, whose commands are known, the shift is nearly linear, so one look at the map
    tells it: looked up beside the true place by d, it is wrong by `steepest` d."""
    machine = f.machine
    share = (t - rows.t0) / (rows.t1 - rows.t0)
    guess = shift[0][:, None] + (shift[1] - shift[0])[:, None] * share
    weight = np.broadcast_to(f.weight(rows)[:, None], nominal.shape)
    flat = (len(nominal), -1)
    found = -machine.deviation((nominal + guess).reshape(flat), weight.reshape(flat))
    found = found.reshape(nominal.shape)
    miss = np.abs(found - guess).max(axis=0)
    exact = nominal + found
    again = miss * machine.bounds.steepest > f.total * SHARE / 8
    if again.any():
        motion = np.broadcast_to(f.arcs.motion[rows.arc], t.shape)[again]
        exact[:, again] = command(machine, nominal[:, again], weight[:, again], motion)
    if len(f.followed):
        row = np.broadcast_to(np.arange(len(rows)), t.shape).ravel()
        exact = f.led(rows, row, exact.reshape(flat)).reshape(nominal.shape)
    return exact, miss.max(axis=0)
