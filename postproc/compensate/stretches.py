"""Where along arcs the command is smooth, and how closely it must be looked at there.

Between its nodes a table is straight, so along an arc the command bends but where an axis passes a
node, and where it leaves what lost motion holds. Those places part the arc into smooth stretches,
and each stretch has equal parts, two at least. What a smooth curve f does between samples h apart
is known from three of them but for a third derivative: with d the step from one to the next, and D
the second difference at either,

    |f| <= larger of both ends + (|D| / 2 - |d|)^2 / (2 |D|) + h^3 |f''' + f'| / (9 sqrt 3)

where the second term, the top of the parabola, counts while |d| < |D| / 2, and the third is what
interpolation leaves. Waves of one per turn, which a shift of the centre makes, are interpolated
without a rest by themselves (f''' = -f'); with these in the place of parabolas the second term
needs |D| / cos h, and the third is 1.026 times as large for h = 0.5. In place the deviation is
linear, with slopes S per mm of way, so the image of a circle of radius r is a conic: beside waves
of one its radial part has waves of two per turn of sizes up to r S / 2, which leaves 6 r S / 2 at
most, as the axes beside the plane, with waves of one up to r S, leave r S; the products of an angle
and an arm, `twist` x y, add a third wave. h follows from that, and what is left goes off the
tolerance.

Arcs for which that does not hold (inside cutter radius compensation, spirals, ramps of lost motion,
axes that turn) are sampled so densely that an eighth of the tolerance hides at most: a piecewise
linear map misses its chord by kink * step / 4.
"""

from __future__ import annotations

import numpy as np

from postproc.compensate.arc_rows import Fitter, Rows
from postproc.compensate.arcs import direction, height, points
from postproc.compensate.inverse import command
from postproc.compensate.nodes import spread
from postproc.records import columns
from postproc.units import TICKS_PER_MM

TURN = 2 * np.pi
WIDEST = 0.5  # rad between two samples
REMAINDER = 1 / (9 * np.sqrt(3))
SHARE = 1 / 16  # of the tolerance that the remainder may take


@columns
class Stretches:
    """G smooth stretches of rows, in order. row (G,); t, step (G,): where it begins, and from
    sample to sample; parts (G,). steep (R,) mm/mm and rest (R,) mm of the rows; shift (2, A, R)
    mm: `_ends`."""

    row: np.ndarray
    t: np.ndarray
    step: np.ndarray
    parts: np.ndarray
    steep: np.ndarray
    rest: np.ndarray
    shift: np.ndarray


def stretches(f: Fitter, rows: Rows) -> Stretches:
    """Where samples lie."""
    arcs, arc = f.arcs, rows.arc
    plain = f.plain[arc]
    sweep = np.abs(arcs.sweep[arc])
    radius = np.maximum(arcs.radius, arcs.radius_end)[arc]
    # Nodes so near to one another, or to an end, that next to nothing bends between them.
    near = f.total * SHARE / 4 / max(f.machine.bounds.kink, 1e-12)
    near = near / np.maximum(np.maximum(radius * sweep, f.beside[arc]), 1e-9)
    shift = _ends(f, rows)
    passed = _crossings(f, rows, shift) if plain.any() else []
    owner = np.concatenate([np.arange(len(rows)), *(o for o, _ in passed)])
    t = np.concatenate([rows.t0, *(at for _, at in passed)])
    # One sort for all rows: the share of the way, halved, stays below the step between two rows.
    share = (t - rows.t0.take(owner)) / (rows.t1 - rows.t0).take(owner)
    order = np.argsort(owner + share / 2, kind="stable")
    owner, t = owner.take(order), t.take(order)
    first = np.concatenate([[True], owner[1:] != owner[:-1]])
    keep = first.copy()
    least, end = near.take(owner[1:]), rows.t1.take(owner[1:])
    keep[1:] |= (t[1:] - t[:-1] > least) & (end - t[1:] > least)
    owner, t, first = owner.compress(keep), t.compress(keep), first.compress(keep)
    until = np.append(t[1:], 0.0)
    final = np.append(first[1:], True)
    until[final] = rows.t1.take(owner.compress(final))
    steep, third = np.zeros(len(t)), np.full(len(t), 1e-12)
    if plain.any():
        steep, third = _steepness(f, rows, owner, (t + until) / 2, shift)
    turn = sweep.take(owner) * (until - t)
    # h from h^3 |third| / (9 sqrt 3) = SHARE of the tolerance, the remainder that is left between.
    wide = np.minimum(np.cbrt(f.total * SHARE / (REMAINDER * third)), WIDEST)
    parts = np.where(plain[owner], np.maximum(np.ceil(turn / wide), 2), 0).astype(np.int64)
    dense = np.flatnonzero(~plain)
    if len(dense):
        # Even: one sample is the middle.
        parts[~plain[owner]] = density(f, rows.pick(dense)) // 2 * 2
    left = REMAINDER * third * (turn / parts) ** 3 + f.total * SHARE / 4
    left = np.where(plain[owner], left, (f.tolerance**2 + f.tolerance_across**2) ** 0.5 / 8)
    at = np.flatnonzero(first)
    return Stretches(
        owner, t, (until - t) / parts, parts, np.maximum.reduceat(steep, at),
        np.maximum.reduceat(left, at), shift,
    )  # fmt: skip


def _steepness(
    f: Fitter, rows: Rows, row: np.ndarray, t: np.ndarray, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(G,) mm/mm how steep the deviation is at most in the cell of the tables where t lies, and
    (G,) mm per cubic radian |f''' + f'| of the path there, a thirtieth more than it can be."""
    arcs, arc = f.arcs, rows.arc[row]
    bounds, radius = f.machine.bounds, np.maximum(arcs.radius, arcs.radius_end).take(arc)
    angle = arcs.angle.take(arc) + arcs.sweep.take(arc) * t
    steep, held = np.full(len(row), bounds.even), np.zeros(len(row), bool)
    share = (t - rows.t0.take(row)) / (rows.t1 - rows.t0).take(row)
    axes = arcs.first.take(arc), arcs.second.take(arc)
    planes = tuple(zip(axes, direction(angle), arcs.centre, strict=True))
    for k, letter in enumerate(f.machine.letters):
        if letter not in bounds.cells:
            continue
        nodes, slopes = bounds.cells[letter]
        for axis, part, centre in planes:
            on = axis == k
            if on.any():
                beside = shift[0, k].take(row) + (shift[1, k] - shift[0, k]).take(row) * share
                place = centre.take(arc) + radius * part + beside
                steep += np.where(on, slopes.take(nodes.searchsorted(place)), 0.0)
                if k in f.followed:
                    ends = rows.begin[k, row] / TICKS_PER_MM, rows.end[k, row] / TICKS_PER_MM
                    held |= on & ((place < np.minimum(*ends)) | (place > np.maximum(*ends)))
        moves = (f.start[k] != f.target[k]).take(arc) & (axes[0] != k) & (axes[1] != k)
        if moves.any():
            steep += np.where(moves, slopes.max(), 0.0)
    twist = float(bounds.twist.sum())
    return steep, 3.1 * radius * steep + 13.5 * twist * radius**2 + 2 * radius * held + 1e-12


def _ends(f: Fitter, rows: Rows) -> np.ndarray:
    """(2, A, R) mm from the nominal places at both ends of rows to their exact commands."""
    plain = np.flatnonzero(f.plain[rows.arc])
    result = np.zeros((2, *rows.begin.shape))
    weight = f.weight(rows).take(plain, axis=1)
    for k, (ticks, t) in enumerate(((rows.begin, rows.t0), (rows.end, rows.t1))):
        nominal = points(f.arcs, f.start, f.target, rows.arc.take(plain), t.take(plain))
        exact = ticks.take(plain, axis=1) / TICKS_PER_MM
        if len(f.followed):  # lost motion may hold it elsewhere
            exact = command(f.machine, nominal, weight, f.arcs.motion[rows.arc[plain]])
        exact -= nominal
        if len(plain) == len(rows):
            result[k] = exact
        else:
            result[k][:, plain] = exact
    return result


def _crossings(f: Fitter, rows: Rows, shift: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """(N,) rows and (N,) t at which the command of an axis passes a node of its tables, or leaves
    where lost motion holds it, of plain rows; shift (2, A, R) mm: `_ends`."""
    arcs, cells, found = f.arcs, f.machine.bounds.cells, []
    plain = np.flatnonzero(f.plain[rows.arc])
    for k, letter in enumerate(f.machine.letters):
        if letter not in cells:  # without a table, so without lost motion
            continue
        nodes, held = cells[letter][0], k in f.followed
        for axes, role in ((arcs.first, 0), (arcs.second, 1)):
            on = plain[axes[rows.arc[plain]] == k]
            if len(on):
                middle = arcs.centre[role, rows.arc[on]] + shift[:, k].take(on, axis=1).mean(axis=0)
                radius = arcs.radius[rows.arc[on]]
                row, node = _between(on, middle - radius, middle + radius, nodes)
                if held:
                    row = np.concatenate([row, on, on])
                    ends = rows.begin[k, on] / TICKS_PER_MM, rows.end[k, on] / TICKS_PER_MM
                    node = np.concatenate([node, *ends])
                found.append(_on_circle(f, rows, row, node, role, shift[:, k].take(row, axis=1)))
        beside = (arcs.first[rows.arc[plain]] != k) & (arcs.second[rows.arc[plain]] != k)
        moves = plain[(f.start[k] != f.target[k])[rows.arc[plain]] & beside]
        if len(moves):
            found.append(_on_line(f, rows, moves, nodes, k, shift[:, k].take(moves, axis=1)))
    return found


def _between(
    which: np.ndarray, low: np.ndarray, high: np.ndarray, nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) of `which` (R,) and (N,) the nodes between low and high (R,), mm."""
    first = nodes.searchsorted(low, side="right")
    one, index = spread(np.maximum(nodes.searchsorted(high, side="left") - first, 0))
    return which.take(one), nodes.take(first.take(one) + index)


def _on_circle(
    f: Fitter, rows: Rows, row: np.ndarray, node: np.ndarray, role: int, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N,) rows and (N,) t where the command of the plane's first (role 0) or second axis passes
    nodes (N,) mm; shift (2, N) mm: how far it is beside the nominal place at both ends."""
    arcs, arc = f.arcs, rows.arc.take(row)
    centre, radius, sweep = (x.take(arc) for x in (arcs.centre[role], arcs.radius, arcs.sweep))
    t0, way = rows.t0.take(row), (rows.t1 - rows.t0).take(row)
    first, turns, per = arcs.angle.take(arc), np.sign(sweep) / TURN, TURN / np.abs(sweep)
    result = []
    for side in (1.0, -1.0):
        share, t = np.full(len(row), 0.5), t0
        for _ in range(3):  # the shift there is known when the place is
            beside = shift[0] + (shift[1] - shift[0]) * share
            # Two places of a circle have this coordinate, at +angle and -angle from the first axis;
            # the second axis sees a sine, which is the cosine from its own direction.
            cosine = (node - beside - centre) / radius
            angle = np.arccos(np.minimum(np.maximum(cosine, -1.0), 1.0)) * side
            if role:
                angle = np.pi / 2 - angle
            turned = (angle - first) * turns
            t = (turned - np.floor(turned)) * per
            share = np.minimum(np.maximum((t - t0) / way, 0.0), 1.0)
        inside = (t > t0) & (t < rows.t1.take(row))
        result.append((row.compress(inside), t.compress(inside)))
    return np.concatenate([r for r, _ in result]), np.concatenate([at for _, at in result])


def _on_line(
    f: Fitter, rows: Rows, which: np.ndarray, nodes: np.ndarray, k: int, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The same of an axis that moves beside the plane, in step with the angle."""
    arc = rows.arc[which]
    start, way = f.start[k, arc], (f.target - f.start)[k, arc]
    one, two = start + way * rows.t0[which] + shift[0], start + way * rows.t1[which] + shift[1]
    at, node = _between(np.arange(len(which)), np.minimum(one, two), np.maximum(one, two), nodes)
    share = (node - one[at]) / np.where(two == one, 1.0, two - one)[at]
    t = rows.t0[which[at]] + (rows.t1 - rows.t0)[which[at]] * share
    inside = (share > 0) & (share < 1)
    return which[at[inside]], t[inside]


def density(f: Fitter, rows: Rows) -> np.ndarray:
    """(R,) how many steps make samples dense enough without knowing where nodes are passed:
    between two of them at most an eighth of the tolerance may hide, from nodes and where lost
    motion has built up (kink * step / 4), and from the ellipse that a stretched circle is."""
    arcs = f.arcs
    sweep = np.abs(arcs.sweep[rows.arc] * (rows.t1 - rows.t0))
    radius = np.maximum(arcs.radius, arcs.radius_end)[rows.arc]
    sagitta = radius * height(np.minimum(sweep, TURN))
    ends = [points(arcs, f.start, f.target, rows.arc, t) for t in (rows.t0, rows.t1)]
    kink, steep = f.machine.bounds.local(np.minimum(*ends) - sagitta, np.maximum(*ends) + sagitta)
    builds = f.weight(rows) * np.sign(ends[1] - ends[0]) < (ends[1] != ends[0])
    kink = kink + (f.builds[:, None] * builds).sum(axis=0)
    slack = f.tolerance / 8
    travel = np.linalg.norm((f.target - f.start).take(rows.arc, axis=1), axis=0) * (
        rows.t1 - rows.t0
    )
    by_kink = np.hypot(sweep * radius, travel) * kink / (4 * slack)
    by_ellipse = sweep * np.sqrt(radius * steep / (4 * slack))
    density: np.ndarray = np.clip(np.ceil(np.maximum(by_kink, by_ellipse)), 4, 20000).astype(
        np.int64
    )
    return density
