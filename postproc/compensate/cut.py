"""From strokes to pieces: take-ups where an axis turns back, straight strokes cut at nodes, arcs
kept or halved."""

from __future__ import annotations

import numpy as np

from postproc.compensate import cutter, fit, leading, nodes, uncut
from postproc.compensate.arc_rows import Fitter, Rows
from postproc.compensate.arcs import points
from postproc.compensate.batch import Batch, written_centre
from postproc.compensate.increments import increments, rounded
from postproc.errors import MotionFault
from postproc.flags import all_of, any_of
from postproc.motions import CLOCKWISE, COUNTER, FEED, FREE, RAPID, THREAD
from postproc.pieces import Packed, Pieces
from postproc.records import names
from postproc.units import TICKS_PER_MM

Cuts = tuple[np.ndarray, np.ndarray, np.ndarray]  # stroke (K,), share (K,), command (A, K) mm
IN_STEP = 0.5  # mm of a thread along which an axis is taken over its play where none is put in
NO_TIMES, FEEDS = np.zeros(0), np.array(FEED, np.int8)  # without axes: postproc.units


def take_ups(b: Batch) -> Packed | None:
    """A piece for every stroke that must be begun elsewhere than the last one ended, or two
    (Batch.lead_beyond)."""
    led, moved = b.beyond != b.begin, b.begin != b.before
    if not (any_of(led) or any_of(moved)):
        return None
    over = led.any(axis=0)
    which = ((b.turning & moved.any(axis=0)) | over).nonzero()[0]
    if not len(which):
        return None
    two = over.nonzero()[0]
    stroke = np.concatenate([two, which])
    start = np.concatenate(
        [b.before.take(two, axis=1), np.where(over, b.beyond, b.before).take(which, axis=1)], axis=1
    )
    end = np.concatenate([b.beyond.take(two, axis=1), b.begin.take(which, axis=1)], axis=1)
    order = np.repeat([-2, -1], [len(two), len(which)])
    # behind the rapid that leads to a thread no F may be in force
    code = np.where(b.code.take(stroke) == THREAD, RAPID, FEED)
    return pack(b, stroke, order, code, start, end, np.zeros(len(stroke)),
                     _begin_ticks(b, stroke), take_up=True)  # fmt: skip


def _begin_ticks(b: Batch, which: np.ndarray) -> np.ndarray:
    ticks: np.ndarray = np.rint(b.begin_nominal.take(which, axis=1) * TICKS_PER_MM)
    return ticks.astype(np.int64)


def pack(
    b: Batch,
    stroke: np.ndarray,
    order: np.ndarray,
    code: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
    share: np.ndarray,
    nominal: np.ndarray,
    take_up: bool = False,
    arc: np.ndarray | None = None,
    centre: np.ndarray | None = None,
    radius: np.ndarray | None = None,
) -> Packed:
    n, motion = len(stroke), b.motion[stroke]
    arc_of, turns = np.empty(n, np.int64), np.empty(n, bool)
    arc_of.fill(-1)
    turns.fill(take_up)
    pieces = Pieces(
        motion=motion,
        code=np.asarray(code, np.int8),
        start=start,
        end=end,
        share=share,
        arc=arc_of if arc is None else arc,
        centre=np.zeros((2, n), np.int64) if centre is None else centre,
        radius=np.zeros(n, np.int64) if radius is None else radius,
        nominal=nominal,
        take_up=turns,
        corrected=b.free[motion],
        bottom=b.bottom[motion],
    )
    return (stroke, order), pieces


def straight_pieces(b: Batch) -> Packed | None:
    """Straight strokes: whole, or cut where the map asks for it."""
    m, motion = b.m, b.motion
    if len(m.arcs):
        straight = (((b.code != CLOCKWISE) & (b.code != COUNTER)) | ~b.moved).nonzero()[0]
    else:
        straight = np.arange(len(motion))
    if not len(straight):
        return None
    chosen = _may_be_cut(b, straight)
    owner, t, exact = _cuts(b, chosen) if len(chosen) else (chosen, NO_TIMES, b.exact)
    if not len(owner):
        parts = [b.begin, b.end, b.nominal_end, b.t1 - b.t0, b.code]
        if len(straight) < len(motion):
            parts = [column.take(straight, axis=-1) for column in parts]
        start, end, nominal, share, code = parts
        none = np.zeros(len(straight), np.int64)
        return pack(b, straight, none, code, start, end, share, nominal)
    # Cuts come before the end of their own stroke; both are in order already. Two cuts of the first
    # of two strokes, one of the second:
    #     stroke     0 0 0 1 1
    #     place_cut  0 1   3
    #     place_end      2   4
    cut = chosen[owner]
    of = np.searchsorted(straight, cut)
    place_cut = of + np.arange(len(of))
    place_end = np.arange(len(straight)) + np.cumsum(np.bincount(of, minlength=len(straight)))
    n = len(straight) + len(cut)
    stroke, time = np.empty(n, np.int64), np.ones(n)
    stroke[place_end], stroke[place_cut], time[place_cut] = straight, cut, t
    end, nominal = b.end.take(stroke, axis=1), b.nominal_end.take(stroke, axis=1)
    end[:, place_cut] = b.grid(cut, exact)
    nominal[:, place_cut] = np.rint(
        b.nominal(motion[cut], _of_motion(b, cut, t)) * TICKS_PER_MM
    ).astype(np.int64)
    for row in b.fixed:  # axes that are only carried along pass the cuts on whole increments
        end[row, place_end] = b.end[row, straight]
    # An axis that stands still keeps still in the middle too; a piece of no length is none.
    first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
    start = _starts(b, stroke, first, end)
    none = (start == end).all(axis=0) & (time < 1.0)
    if none.any():
        kept = (~none).nonzero()[0]
        stroke, time = stroke[kept], time[kept]
        end, nominal = end.take(kept, axis=1), nominal.take(kept, axis=1)
        first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
        start = _starts(b, stroke, first, end)
    share = time.copy()
    share[1:] -= np.where(first[1:], 0.0, time[:-1])
    share *= (b.t1 - b.t0)[stroke]
    return pack(
        b, stroke, np.arange(len(stroke)), m.code[motion[stroke]], start, end, share, nominal
    )


def _may_be_cut(b: Batch, straight: np.ndarray) -> np.ndarray:
    """(K,) those of straight strokes that can bend and may be cut."""
    code, motion = b.code.take(straight), b.motion.take(straight)
    may = code == FEEDS
    if b.options.cut_rapids:
        may |= code == RAPID
    if not all_of(may):
        may |= (code == THREAD) & ~b.m.whole[motion]
    if not b.every:
        may &= b.free[motion] & b.known_before[straight]
    if b.inside:
        may &= cutter.margin(b, motion) < np.inf
    chosen: np.ndarray = straight[may]
    if b.c.ramped or not len(chosen):
        return chosen
    bends = b.may_bend(chosen, b.c.slack)
    if len(b.c.followed):
        bends = bends | (leading.waiting(b, chosen) > 0).any(axis=0)
    bends[_in_chain(b, chosen)[0]] = True
    chosen = chosen[bends]
    return chosen[~uncut.proven(b, chosen)] if len(chosen) else chosen


def _of_motion(b: Batch, stroke: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(K,) t of whole motions, of t of strokes."""
    t0, t1 = b.t0[stroke], b.t1[stroke]
    motion: np.ndarray = np.where(t == 1.0, t1, t0 + (t1 - t0) * t)
    return motion


def _starts(b: Batch, stroke: np.ndarray, first: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(A, K) ticks at which pieces begin: where the one before ended, or where their stroke is
    begun."""
    start = np.empty_like(end)
    start[:, 1:] = end[:, :-1]
    start[:, first] = b.begin.take(stroke[first], axis=1)
    return start


def _cuts(b: Batch, chosen: np.ndarray) -> Cuts:
    """(K,) index into chosen, (K,) t, (A, K) exact command mm of every cut inside the chosen
    strokes."""
    start, target = b.begin_nominal.take(chosen, axis=1), b.end_nominal.take(chosen, axis=1)
    beside = cutter.centre(b, chosen, np.ones(len(chosen))) if b.reads_beside else 0.0
    owner, t, axis = nodes.candidates(b.machine, start + beside, target + beside, b.c.slack)
    for more, at in (*_ramp_ends(b, chosen), *_waited(b, chosen), _in_chain(b, chosen)):
        owner = np.concatenate([owner, more])
        t = np.concatenate([t, at])
        axis = np.concatenate([axis, np.full(len(at), -1)])
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
    written = (b.grid(chosen[owner], exact) / TICKS_PER_MM) - exact
    correction = exact - (start.take(owner, axis=1) + (target - start).take(owner, axis=1) * t)
    # The ends are settled already, rounding and all.
    every = np.arange(len(chosen))
    begin = b.begin.take(chosen, axis=1) / TICKS_PER_MM - start
    end = b.end.take(chosen, axis=1) / TICKS_PER_MM - target
    owner = np.concatenate([owner, every, every])
    t = np.concatenate([t, np.zeros(len(every)), np.ones(len(every))])
    correction = np.concatenate([correction, begin, end], axis=1)
    exact = np.concatenate([exact, start, target], axis=1)
    written = correction + np.concatenate(
        [written, np.zeros((len(written), 2 * len(every)))], axis=1
    )
    order = nodes.tidy(owner, t)
    owner = owner[order]
    t = t[order]
    correction = correction.take(order, axis=1)
    exact = exact.take(order, axis=1)
    onward = _onward(b, chosen[owner], t, exact)
    correction = correction + onward
    exact = exact + onward
    written = written.take(order, axis=1) + onward
    tolerance, rows = uncut.allowed(b, chosen)[0], b.rows
    cut = nodes.merge(owner, t, correction[rows], written[rows], tolerance[rows]).nonzero()[0]
    if b.machine.turning:
        return _on_increments(b, chosen, owner[cut], t[cut])
    return owner[cut], t[cut], exact.take(cut, axis=1)


def _onward(b: Batch, stroke: np.ndarray, t: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """(A, K) mm to be added to exact commands along strokes, in order, so that no slide turns back
    inside a stroke by less than the hysteresis (what turns back by more has been made a stroke of
    its own)."""
    more = np.zeros_like(exact)
    inner = (t > 0) & (t < 1)
    which = np.cumsum(np.concatenate([[True], stroke[1:] != stroke[:-1]])) - 1
    for row in b.c.followed:
        side = b.weight_begin[row, stroke]
        course = np.where(inner, exact[row], b.begin[row, stroke] / TICKS_PER_MM)
        ahead = np.rint(side * course * TICKS_PER_MM).astype(np.int64)
        ahead = np.where(t == 1.0, ahead[np.searchsorted(which, which)], ahead)
        first = ahead[np.searchsorted(which, which)]
        # One running maximum for all strokes: each is lifted above all that came before, by more
        # than any of them spans, and let down again.
        lift = which * (2 * int(np.abs(ahead - first).max(initial=0)) + 1)
        led = np.maximum.accumulate(ahead - first + lift) - lift + first
        end = np.rint(side * b.end[row, stroke]).astype(np.int64)
        led = np.minimum(led, np.maximum(end, first))
        free = inner & (side != 0) & (b.m.cutter[b.motion[stroke]] == FREE)
        more[row] = np.where(free, side * led / TICKS_PER_MM - course, 0.0)
    return more


def _on_increments(b: Batch, chosen: np.ndarray, owner: np.ndarray, t: np.ndarray) -> Cuts:
    """Cuts moved to where the rotary axis that turns most stands on a whole increment: half of one
    is 2 um at 200 mm."""
    rows = list(b.machine.turning)
    way = (b.end_nominal - b.begin_nominal).take(chosen[owner], axis=1)
    row = (
        np.array(rows)[np.argmax(np.abs(way[rows]), axis=0)]
        if len(owner)
        else np.zeros(0, np.int64)
    )
    k = np.arange(len(owner))
    turns = way[row, k] != 0
    start = b.begin_nominal[row, chosen[owner]]
    step = b.m.grid[row, b.motion[chosen[owner]]] / TICKS_PER_MM
    moved = (start + np.rint(way[row, k] * t / step) * step - start) / np.where(
        turns, way[row, k], 1.0
    )
    t = np.where(turns, moved, t)
    same = np.concatenate([[False], (owner[1:] == owner[:-1]) & (t[1:] <= t[:-1])])
    keep = ~same & (t > 0) & (t < 1)
    owner, t = owner[keep], t[keep]
    return owner, t, _along(b, chosen, owner, t)


def _along(b: Batch, chosen: np.ndarray, owner: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(A, K) mm exact commands at t along straight strokes."""
    stroke = chosen[owner]
    start = b.begin_nominal.take(stroke, axis=1)
    nominal = start + (b.end_nominal.take(stroke, axis=1) - start) * t
    t = _of_motion(b, stroke, t)
    return b.needed(stroke, nominal, b.weight(stroke, nominal), t)


def _ramp_ends(b: Batch, chosen: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where a ramp ends inside a stroke: there the correction bends."""
    result = []
    for row in np.flatnonzero(b.c.reach):
        way = b.travel[row, chosen] / b.c.reach[row]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (np.sign(way) - b.weight_begin[row, chosen]) / way
        inside = ((t > 0) & (t < 1)).nonzero()[0]
        result.append((inside, t[inside]))
    return result


def _waited(b: Batch, chosen: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where axes have waited that began ahead of their places: from there on they go along."""
    share = leading.waiting(b, chosen)
    least, result = _in_step(b, chosen), []
    for row in b.c.followed:
        at = np.where(share[row] > 0, np.maximum(share[row], least), 0.0)
        inside = ((at > 0) & (at < 1)).nonzero()[0]
        result.append((inside, at[inside]))
    return result


def _in_step(b: Batch, chosen: np.ndarray) -> np.ndarray:
    """(K,) share of strokes that no cut at their begin may be shorter than: IN_STEP of threads."""
    share, thread = np.zeros(len(chosen)), (b.code.take(chosen) == THREAD).nonzero()[0]
    if len(thread):
        way = (b.end_nominal - b.begin_nominal)[b.rows][:, chosen[thread]]
        share[thread] = IN_STEP / np.maximum(np.sqrt((way**2).sum(axis=0)), IN_STEP)
    return share


def _in_chain(b: Batch, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where axes have been taken over their play that turn where a taper goes on from another
    thread."""
    share = _in_step(b, chosen)
    inside = ((share > 0) & (share < 0.5)).nonzero()[0]
    if len(inside):
        stroke = chosen[inside]
        over = ~b.cutting[stroke] & b.flipped[:, stroke].any(axis=0)
        inside = inside[over & (np.count_nonzero(b.travel[:, stroke], axis=0) > 1)]
    return inside, share[inside]


def _plain(b: Batch) -> np.ndarray:
    """(n,) bool: arcs along which nothing but the map bends the command
    (postproc.compensate.samples)."""
    arcs = b.m.arcs
    if b.tip or b.machine.chain.rotary or b.c.mode == "off" or b.c.reach.any():
        return np.zeros(len(arcs), bool)
    round_ = np.abs(arcs.radius_end - arcs.radius) <= b.options.arc_mismatch
    result: np.ndarray = (
        round_ & (np.abs(arcs.sweep) <= 2 * np.pi + 1e-9) & (b.m.cutter[arcs.motion] == FREE)
    )
    return result


def arc_pieces(b: Batch) -> Packed | None:
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
        arc=b.arc_of[motion[which]], stroke=which, t0=b.t0[which], t1=b.t1[which],
        begin=b.begin.take(which, axis=1), end=b.end.take(which, axis=1),
        centre=np.zeros((2, len(which)), np.int64), radius=np.zeros(len(which), np.int64),
        chord=np.zeros(len(which), bool),
    )  # fmt: skip
    written = written_centre(m)
    every = increments(b, np.arange(len(motion)))
    single = np.zeros(len(arcs), bool)
    single[b.arc_of[motion[which]]] = (b.begin == b.before).all(axis=0)[which]
    fitter = Fitter(
        machine=b.machine, arcs=arcs, start=b.arc_start, target=b.arc_target, tolerance=b.c.plane,
        tolerance_across=b.c.chord, total=b.c.inner, mismatch=b.options.arc_mismatch, base=written,
        step=m.grid.take(arcs.motion, axis=1), single=single, plain=_plain(b),
        needed=lambda r, row, t, p: b.needed(r.stroke[row], p, b.weight(r.stroke[row], p), t),
        weight=lambda r: b.weight_begin.take(r.stroke, axis=1),
        led=lambda r, row, exact: b.led(r.stroke[row], exact), followed=b.c.followed,
        round_to=lambda stroke, exact: rounded(
            exact, *(column.take(stroke, axis=1) for column in every)
        ),
        increments=every, builds=b.c.builds, **cutter.arcs_inside(b),
    )  # fmt: skip
    rows = fit.settle(fitter, rows)
    order = np.rint((rows.t0 - b.t0[rows.stroke]) * 2**30).astype(np.int64)
    code = np.where(rows.chord, FEED, m.code[motion[rows.stroke]])
    nominal = np.rint(
        points(arcs, b.arc_start, b.arc_target, rows.arc, rows.t1) * TICKS_PER_MM
    ).astype(np.int64)
    none = (rows.begin == rows.end).all(axis=0) & rows.chord & (rows.t1 < 1)
    key, pieces = pack(
        b, rows.stroke, order, code, rows.begin, rows.end, rows.t1 - rows.t0, nominal,
        arc=np.where(rows.chord, -1, rows.arc), centre=rows.centre,
        radius=np.where(rows.chord, 0, rows.radius),
    )  # fmt: skip
    if none.any():
        fields = names(Pieces)
        pieces = Pieces(**{f: getattr(pieces, f)[..., ~none] for f in fields})
        key = key[0][~none], key[1][~none]
    return key, pieces
