"""From strokes to pieces: take-ups where an axis turns back, straight strokes cut at nodes, arcs kept or halved."""

from __future__ import annotations

import numpy as np

from postproc.compensate import cutter, nodes
from postproc.compensate.arcs import Fitter, Rows, points
from postproc.compensate.batch import Batch, written_centre
from postproc.errors import MotionFault
from postproc.motions import CLOCKWISE, COUNTER, FEED, RAPID
from postproc.pieces import Pieces
from postproc.units import TICKS_PER_MM


def take_ups(b: Batch):
    """A piece for every stroke that must be begun elsewhere than the last one ended."""
    if not b.turning.any():
        return None
    which = (b.turning & (b.begin != b.before).any(axis=0)).nonzero()[0]
    if not len(which):
        return None
    return pack(b, which, np.full(len(which), -1), np.full(len(which), FEED), b.before[:, which], b.begin[:, which],
                     np.zeros(len(which)), _begin_ticks(b, which), take_up=True)  # fmt: skip


def _begin_ticks(b: Batch, which: np.ndarray) -> np.ndarray:
    return np.rint(b.begin_nominal[:, which] * TICKS_PER_MM).astype(np.int64)


def pack(b: Batch, stroke, order, code, start, end, share, nominal, take_up=False, arc=None, centre=None):
    n = len(stroke)
    pieces = Pieces(
        motion=b.motion[stroke], code=np.asarray(code, np.int8), start=start, end=end, share=share,
        arc=np.full(n, -1) if arc is None else arc, centre=np.zeros((2, n), np.int64) if centre is None else centre,
        nominal=nominal, take_up=np.full(n, take_up), corrected=b.free[b.motion[stroke]], bottom=b.bottom[b.motion[stroke]],
    )  # fmt: skip
    return np.stack([stroke, order], axis=1), pieces


def straight_pieces(b: Batch):
    """Straight strokes: whole, or cut where the map asks for it."""
    m, motion = b.m, b.motion
    code = m.code[motion]
    straight = (((code != CLOCKWISE) & (code != COUNTER)) | ~b.free[motion]).nonzero()[0]
    if not len(straight):
        return None
    may = (code[straight] == FEED) | (b.options.cut_rapids & (code[straight] == RAPID))
    may &= b.free[motion[straight]] & b.known_before[straight] & (cutter.margin(b, motion[straight]) < np.inf)
    chosen = straight[may]
    if b.c.mode != "ramp":
        chosen = chosen[nodes.may_bend(b.machine, b.begin_nominal[:, chosen], b.end_nominal[:, chosen], b.c.slack)]
    owner, t, exact = _cuts(b, chosen)
    if not len(owner) and len(straight) == len(motion):
        return pack(
            b, straight, np.zeros(len(straight), np.int64), code, b.begin, b.end, np.ones(len(straight)), b.nominal_end
        )
    if not len(owner):
        return pack(b, straight, np.zeros(len(straight), np.int64), code[straight], b.begin[:, straight], b.end[:, straight],
                         np.ones(len(straight)), b.nominal_end[:, straight])  # fmt: skip
    # Cuts come before the end of their own stroke; both are in order already.
    cut = chosen[owner]
    of = np.searchsorted(straight, cut)
    place_cut = of + np.arange(len(of))
    place_end = np.arange(len(straight)) + np.cumsum(np.bincount(of, minlength=len(straight)))
    n = len(straight) + len(cut)
    stroke, time = np.empty(n, np.int64), np.ones(n)
    stroke[place_end], stroke[place_cut], time[place_cut] = straight, cut, t
    end, nominal = b.end[:, stroke], b.nominal_end[:, stroke]
    end[:, place_cut] = b.grid(cut, exact)
    nominal[:, place_cut] = np.rint(b.nominal(motion[cut], t) * TICKS_PER_MM).astype(np.int64)
    for (
        row
    ) in b.fixed:  # axes that are only carried along end where they were told, and pass the cuts on whole increments
        end[row, place_end] = nominal[row, place_end]
    # An axis that stands still keeps still in the middle too; a piece of no length is none.
    first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
    start = _starts(b, stroke, first, end)
    none = (start == end).all(axis=0) & (time < 1.0)
    if none.any():
        stroke, time, end, nominal = stroke[~none], time[~none], end[:, ~none], nominal[:, ~none]
        first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
        start = _starts(b, stroke, first, end)
    share = time.copy()
    share[1:] -= np.where(first[1:], 0.0, time[:-1])
    return pack(b, stroke, np.arange(len(stroke)), m.code[motion[stroke]], start, end, share, nominal)


def _starts(b: Batch, stroke: np.ndarray, first: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(A, K) ticks at which pieces begin: where the one before ended, or where their stroke is begun."""
    start = np.empty_like(end)
    start[:, 1:] = end[:, :-1]
    start[:, first] = b.begin[:, stroke[first]]
    return start


def _cuts(b: Batch, chosen: np.ndarray):
    """(K,) index into chosen, (K,) t, (A, K) exact command mm of every cut inside the chosen strokes."""
    if not len(chosen):
        return np.zeros(0, np.int64), np.zeros(0), np.zeros((len(b.machine.axes), 0))
    start, target = b.begin_nominal[:, chosen], b.end_nominal[:, chosen]
    beside = cutter.centre(b, chosen, np.ones(len(chosen))) if b.reads_beside else 0.0
    owner, t, axis = nodes.candidates(b.machine, start + beside, target + beside, b.c.slack)
    for more, at in _ramp_ends(b, chosen):
        owner, t, axis = (
            np.concatenate([owner, more]),
            np.concatenate([t, at]),
            np.concatenate([axis, np.full(len(at), -1)]),
        )
    if b.inside:
        may = cutter.may_cut(b, chosen, owner, t)
        more, at = cutter.edges(b, chosen)
        owner, t = np.concatenate([owner[may], more]), np.concatenate([t[may], at])
        axis = np.concatenate([axis[may], np.full(len(more), -1)])
    exact = _along(b, chosen, owner, t)
    # It is the command that passes the node, not the nominal point: step back by the correction.
    node = (axis >= 0).nonzero()[0]
    way = (target - start)[axis[node], owner[node]]
    there = start[axis[node], owner[node]] + way * t[node]
    t[node] = np.clip(t[node] - (exact[axis[node], node] - there) / way, 1e-9, 1 - 1e-9)
    exact[:, node] = _along(b, chosen, owner[node], t[node])
    correction = exact - (start[:, owner] + (target - start)[:, owner] * t)
    # The ends are settled already, rounding and all.
    every = np.arange(len(chosen))
    begin, end = b.begin[:, chosen] / TICKS_PER_MM - start, b.end[:, chosen] / TICKS_PER_MM - target
    owner, t = np.concatenate([owner, every, every]), np.concatenate([t, np.zeros(len(every)), np.ones(len(every))])
    correction, exact = np.concatenate([correction, begin, end], axis=1), np.concatenate([exact, start, target], axis=1)
    order = nodes.tidy(owner, t)
    owner, t, correction, exact = owner[order], t[order], correction[:, order], exact[:, order]
    tolerance = np.where(b.travel[:, chosen] == 0, b.c.chord / 2, b.c.chord)
    rows = b.rows
    cut = nodes.merge(owner, t, correction[rows], tolerance[rows])
    if b.machine.chain.rotary:
        return _on_increments(b, chosen, owner[cut], t[cut], exact[:, cut])
    return owner[cut], t[cut], exact[:, cut]


def _on_increments(b: Batch, chosen: np.ndarray, owner: np.ndarray, t: np.ndarray, exact: np.ndarray):
    """Cuts moved to where the rotary axis that turns most stands on a whole increment: half of one is 2 um at 200 mm."""
    rows = [b.machine.letters.index(x) for x in b.machine.chain.rotary]
    way = (b.end_nominal - b.begin_nominal)[:, chosen[owner]]
    row = np.array(rows)[np.argmax(np.abs(way[rows]), axis=0)] if len(owner) else np.zeros(0, np.int64)
    k = np.arange(len(owner))
    turns = way[row, k] != 0
    start, step = b.begin_nominal[row, chosen[owner]], b.m.grid[row, b.motion[chosen[owner]]] / TICKS_PER_MM
    moved = (start + np.rint(way[row, k] * t / step) * step - start) / np.where(turns, way[row, k], 1.0)
    t = np.where(turns, moved, t)
    same = np.concatenate([[False], (owner[1:] == owner[:-1]) & (t[1:] <= t[:-1])])
    keep = ~same & (t > 0) & (t < 1)
    owner, t = owner[keep], t[keep]
    return owner, t, _along(b, chosen, owner, t)


def _along(b: Batch, chosen: np.ndarray, owner: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(A, K) mm exact commands at t along straight strokes."""
    start = b.begin_nominal[:, chosen[owner]]
    nominal = start + (b.end_nominal[:, chosen[owner]] - start) * t
    return b.needed(chosen[owner], nominal, b.weight(chosen[owner], nominal), t)


def _ramp_ends(b: Batch, chosen: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where a ramp ends inside a stroke: there the correction bends."""
    result = []
    if b.c.mode == "ramp":
        for row in range(len(b.travel)):
            way = b.travel[row, chosen] / b.c.limit
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (np.sign(way) - b.weight_begin[row, chosen]) / way
            inside = ((t > 0) & (t < 1)).nonzero()[0]
            result.append((inside, t[inside]))
    return result


def arc_pieces(b: Batch):
    """Strokes of arcs: kept, halved, or chords."""
    m, motion, arcs = b.m, b.motion, b.m.arcs
    if not len(arcs):
        return None
    which = ((b.arc_of[motion] >= 0) & b.free[motion]).nonzero()[0]
    if not len(which):
        return None
    for i in which[~b.known_before[which]][:1]:
        raise MotionFault(
            int(motion[i]),
            "an arc that begins at an unknown place",
            "move every axis to an absolute position first, or say --start",
        )
    rows = Rows(
        arc=b.arc_of[motion[which]], stroke=which, t0=b.t0[which], t1=b.t1[which], begin=b.begin[:, which],
        end=b.end[:, which], centre=np.zeros((2, len(which)), np.int64), chord=np.zeros(len(which), bool),
    )  # fmt: skip
    written = written_centre(m)
    fitter = Fitter(
        machine=b.machine, arcs=arcs, start=b.arc_start, target=b.arc_target, tolerance=b.c.plane,
        tolerance_across=b.c.chord, mismatch=b.options.arc_mismatch, base=written, step=m.grid[:, arcs.motion],
        needed=lambda r, row, t, p: b.needed(r.stroke[row], p, b.weight(r.stroke[row], p), t),
        round_to=lambda r, row, exact: b.grid(r.stroke[row], exact),
        **cutter.arcs_inside(b),
    )  # fmt: skip
    rows = fitter.settle(rows)
    order = np.rint((rows.t0 - b.t0[rows.stroke]) * 2**30).astype(np.int64)
    code = np.where(rows.chord, FEED, m.code[motion[rows.stroke]])
    nominal = np.rint(points(arcs, b.arc_start, b.arc_target, rows.arc, rows.t1) * TICKS_PER_MM).astype(np.int64)
    none = (rows.begin == rows.end).all(axis=0) & rows.chord & (rows.t1 < 1)
    key, pieces = pack(b,
        rows.stroke, order, code, rows.begin, rows.end, rows.t1 - rows.t0, nominal,
        arc=np.where(rows.chord, -1, rows.arc), centre=rows.centre,
    )  # fmt: skip
    if none.any():
        fields = Pieces.__dataclass_fields__
        pieces = Pieces(**{f: getattr(pieces, f)[..., ~none] for f in fields})
        key = key[~none]
    return key, pieces
