"""One batch of motions to its pieces; what the next batch must know goes along as a Carry.

In order: refuse what can not be trusted, cut arcs where an axis turns back, follow the direction of approach, find the
command of every end, take up the reversal, keep still what stands still, cut the ways between, check the limits.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from postproc.compensate import approach, lines
from postproc.compensate.arcs import Fitter, Rows, points, quadrants
from postproc.compensate.inverse import command
from postproc.pieces import Pieces, in_order
from postproc.errors import MotionFault, Notice
from postproc.machine.model import Machine
from postproc.motions import CLOCKWISE, COUNTER, FEED, FOREIGN, RAPID, Motions
from postproc.units import TICKS_PER_MM

EDGE = 1e-6  # mm: how far outside a table or a travel counts as on its end


@dataclass(frozen=True)
class Options:
    """tolerance: mm that the actual path may miss the nominal one (None: one least increment, 0.5 um at least);
    outside: "error" or "clamp"; reversal: a mode of approach.py; ramp: mm of travel; cut_rapids: cut G0 too;
    arc_mismatch: mm that radii of start and end may come to differ by."""

    tolerance: float | None = None
    outside: str | None = None
    reversal: str | None = None
    ramp: float | None = None
    cut_rapids: bool = False
    arc_mismatch: float = 0.005


@dataclass(frozen=True)
class Carry:
    """turn (A,): approach state; issued (A,): ticks last commanded; sure: whether `issued` is where the machine stands
    and is what the nominal position needs; told: notices already given."""

    turn: np.ndarray
    issued: np.ndarray
    sure: bool = False
    largest: float = 0.0
    induced: np.ndarray = field(default_factory=lambda: np.zeros(0))


class Compensator:
    """A machine and the options, ready to correct batches. Holds no state."""

    def __init__(self, machine: Machine, options: Options = Options()):
        self.machine, self.options = machine, options
        least = [axis.least_increment for axis in machine.axes.values()]
        rounding = np.array([a.least_increment / (2 if x in machine.diameter else 1) for x, a in machine.axes.items()])
        self.tolerance = options.tolerance if options.tolerance is not None else max(max(least), 0.0005)
        self.mode = options.reversal or machine.reversal
        self.outside = options.outside or machine.limits.outside
        n = max(1, len(machine.corrected))
        # Rounding may take half a least increment in one axis beyond the tolerance; several axes together take more.
        beyond = max(0.0, float(np.linalg.norm(rounding[list(machine.corrected)] / 2)) - max(least) / 2) if machine.corrected else 0.0
        inner = max(self.tolerance - beyond, self.tolerance / 2)
        self.slack = inner / 8
        self.chord = (inner - self.slack) / np.sqrt(n)
        self.plane = (inner - self.slack) * (1.0 if n == 2 else np.sqrt(2 / n))
        self.hold = self.chord / 2
        self.limit = approach.reach(self.mode if machine.two_way.any() else "mean", options.ramp or self._ramp())

    def _ramp(self) -> float:
        """mm: ten times the largest reversal, half a millimetre at least."""
        largest = 0.0
        for letter, table in self.machine.tables.items():
            largest = max(largest, 2 * float(np.abs(table.half[:3]).max()))
        for term in self.machine.effects:
            if term.name == "backlash":
                largest = max(largest, abs(term.parameters["size_um"]) * 1e-3)
        return max(10 * largest, 0.5)

    def initial(self) -> Carry:
        zero = np.zeros(len(self.machine.axes), np.int64)
        return Carry(zero, zero, False, 0.0, np.zeros(len(zero)))

    def run(self, motions: Motions, carry: Carry) -> tuple[Pieces, Carry, list[Notice]]:
        """Pieces of a batch. Raises MotionFault for the first motion that must not be written."""
        if not len(motions):
            return _untouched(motions), carry, []
        if self.machine.is_zero:
            return _untouched(motions), carry, []
        return _Batch(self, motions, carry).pieces()


def _untouched(motions: Motions) -> Pieces:
    n = len(motions)
    arc = np.full(n, -1)
    arc[motions.arcs.motion] = np.arange(len(motions.arcs))
    return Pieces(
        motion=np.arange(n), code=motions.code, start=motions.start, end=motions.target, share=np.ones(n), arc=arc,
        centre=_written_centre(motions)[:, np.maximum(arc, 0)] if len(motions.arcs) else np.zeros((2, n), np.int64),
        nominal=motions.target, take_up=np.zeros(n, bool), corrected=np.zeros(n, bool),
    )  # fmt: skip


def _written_centre(motions: Motions) -> np.ndarray:
    """(2, n) ticks from the start of each arc to its centre, exactly as written where it was written as I J K."""
    arcs = motions.arcs
    k = np.arange(len(arcs))
    start = np.stack([motions.start[np.maximum(axis, 0), arcs.motion[k]] for axis in (arcs.first, arcs.second)])
    return np.rint(arcs.centre * TICKS_PER_MM).astype(np.int64) - start


class _Batch:
    """The columns of one batch while they are worked out. S strokes; every stroke belongs to one motion."""

    def __init__(self, compensator: Compensator, motions: Motions, carry: Carry):
        self.c, self.m, self.carry = compensator, motions, carry
        self.machine, self.options = compensator.machine, compensator.options
        self.rows = list(self.machine.corrected)
        self.fixed = [i for i in range(len(self.machine.axes)) if i not in self.rows]
        self.notices: list[Notice] = []

    def pieces(self) -> tuple[Pieces, Carry, list[Notice]]:
        m = self.m
        self.refuse()
        self.known = m.target_known[self.rows].all(axis=0)
        self.start_known = m.start_known[self.rows].all(axis=0)
        self.free = self.known & ~m.alone  # motions whose end is corrected
        self.check_unknown()
        self.strokes()
        self.check_inside()
        self.ends()
        self.starts()
        self.settle_ends()
        self.spread_reversals()
        parts = [self.take_ups(), self.lines(), self.arcs()]
        pieces = in_order([p for p in parts if p is not None])
        self.check_limits()
        return pieces, self.next_carry(), self.notices

    # -- what is refused -----------------------------------------------------------------------------------------------

    def refuse(self) -> None:
        bad = np.flatnonzero(self.m.reason)
        if len(bad):
            raise MotionFault(int(bad[0]), *self.m.reasons[int(self.m.reason[bad[0]])])

    def check_unknown(self) -> None:
        """A feed to an unknown place can not be corrected; a rapid is left as it is, and said."""
        lost = ~self.known & ~self.m.alone
        for i in np.flatnonzero(lost & (self.m.code != RAPID))[:1]:
            axes = " ".join(x for k, x in enumerate(self.machine.letters) if k in self.rows and not self.m.target_known[k, i])
            raise MotionFault(int(i), f"where {axes} stands is not known here, and the correction depends on it", f"move {axes} to an absolute position first, or say where it is: --start {axes.split()[0]}100")
        for i in np.flatnonzero(lost)[:1]:
            self.notices.append(Notice("rapid", "rapids before every axis has its position are left as they are", int(i)))
        for i in np.flatnonzero(self.free & ~self.start_known & (self.m.code == FEED))[:1]:
            self.notices.append(Notice("first feed", "a feed from an unknown place: its end is corrected, its way is not", int(i)))

    # -- strokes -------------------------------------------------------------------------------------------------------

    def strokes(self) -> None:
        """Motions, and arcs cut where a two-way axis turns back: motion, t0, t1 (S,), travel (A, S)."""
        m, arcs = self.m, self.m.arcs
        motion, t0, t1 = np.arange(len(m)), np.zeros(len(m)), np.ones(len(m))
        self.arc_of = np.full(len(m), -1)
        self.arc_of[arcs.motion] = np.arange(len(arcs))
        self.arc_start, self.arc_target = m.start[:, arcs.motion] / TICKS_PER_MM, m.target[:, arcs.motion] / TICKS_PER_MM
        turning = self.machine.two_way[arcs.first] | self.machine.two_way[arcs.second] if len(arcs) else np.zeros(0, bool)
        if self.c.limit and turning.any():
            arc, t = quadrants(arcs)
            keep = turning[arc] & (t > 1e-9) & (t < 1 - 1e-9)
            arc, t = arc[keep], t[keep]
            motion = np.concatenate([motion, arcs.motion[arc]])
            t0 = np.concatenate([t0, t])
            order = np.lexsort((t0, motion))
            motion, t0 = motion[order], t0[order]
            t1 = np.where(np.concatenate([motion[1:] == motion[:-1], [False]]), np.concatenate([t0[1:], [1.0]]), 1.0)
        self.motion, self.t0, self.t1 = motion, t0, t1
        self.last = t1 == 1.0
        self.begin_nominal, self.end_nominal = self.nominal(motion, t0), self.nominal(motion, t1)
        if len(arcs):
            travel = np.rint((self.end_nominal - self.begin_nominal) * TICKS_PER_MM).astype(np.int64)
            whole = self.arc_of[motion] < 0
            travel[:, whole] = (m.target - m.start)[:, motion[whole]]
        else:
            travel = m.target - m.start
        sure = (m.start_known & m.target_known)[:, motion]
        forget = np.zeros_like(sure)
        if not sure.all():
            travel = np.where(sure, travel, 0)
            forget = ~sure & m.target_known[:, motion] & (m.word >= 0)[:, motion]
        self.travel = travel
        before, after = approach.follow(travel, forget, self.carry.turn, self.c.limit)
        self.turn_after = after
        if self.c.mode in ("step", "off"):
            before = np.where(travel != 0, after, before)
        unit = 1.0 / max(self.c.limit, 1)
        self.weight_begin, self.weight_end = before * unit, after * unit

    def nominal(self, motion: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(A, K) mm nominal point of motions at t; ends exactly as programmed."""
        m = self.m
        if (t == 1.0).all() or (t == 0.0).all():
            return (m.target if t[:1] == 1.0 else m.start)[:, motion] / TICKS_PER_MM
        start, target = m.start[:, motion] / TICKS_PER_MM, m.target[:, motion] / TICKS_PER_MM
        result = np.where(t == 1.0, target, np.where(t == 0.0, start, start + (target - start) * t))
        on_arc = (self.arc_of[motion] >= 0) & (t > 0) & (t < 1)
        if on_arc.any():
            result[:, on_arc] = points(m.arcs, self.arc_start, self.arc_target, self.arc_of[motion[on_arc]], t[on_arc])
        return result

    def weight(self, stroke: np.ndarray, nominal: np.ndarray) -> np.ndarray:
        """(A, K) approach at places along strokes."""
        if self.c.mode != "ramp":
            return self.weight_begin[:, stroke]
        way = (nominal - self.begin_nominal[:, stroke]) * (TICKS_PER_MM / self.c.limit)
        return np.clip(self.weight_begin[:, stroke] + way, -1.0, 1.0)

    def needed(self, stroke: np.ndarray, nominal: np.ndarray, weight: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(A, K) mm: exact commands at t (of the motion) along strokes.

        In mode off what differs at a stroke's begin fades along it: the reversal is spread over the block.
        """
        exact = command(self.machine, nominal, weight, self.motion[stroke])
        if self.c.mode == "off" and self.c.limit:
            rest = (self.t1[stroke] - t) / (self.t1 - self.t0)[stroke]
            exact += self.differs[:, stroke] * rest
        return exact

    def grid(self, stroke: np.ndarray, exact: np.ndarray) -> np.ndarray:
        """(A, K) ticks: exact commands mm rounded once, half to even, to the least increment of each axis' word."""
        m, motion = self.m, self.motion[stroke]
        zero = np.where(m.incremental[:, motion], self.before[:, stroke], m.origin[:, motion])
        step = m.grid[:, motion]
        return zero + np.rint((exact * TICKS_PER_MM - zero) / step).astype(np.int64) * step

    # -- ends and starts -----------------------------------------------------------------------------------------------

    def check_inside(self) -> None:
        """Nominal points must lie in the tables, unless they may be held at the ends."""
        if self.c.outside == "clamp":
            return
        free = self.free[self.motion]
        for row, letter in enumerate(self.machine.letters):
            table = self.machine.tables.get(letter)
            if table is None:
                continue
            low, high = table.nodes[0] - EDGE, table.nodes[-1] + EDGE
            value = self.end_nominal[row]
            bad = free & ((value < low) | (value > high))
            extent = self._arc_extent(row)
            bad |= (extent[0] < low) | (extent[1] > high)
            for i in np.flatnonzero(bad)[:1]:
                worst = value[i] if not low <= value[i] <= high else extent[0, i] if extent[0, i] < low else extent[1, i]
                raise MotionFault(
                    int(self.motion[i]), f"{letter} = {worst:.4f} mm lies outside the error table of {letter} ({table.nodes[0]:g} to {table.nodes[-1]:g} mm)",
                    "stay inside it, measure further out, or hold the end value with --outside clamp",
                )  # fmt: skip

    def _arc_extent(self, row: int) -> np.ndarray:
        """(2, S) lowest and highest place on each stroke that is part of an arc; 0, 0 inside any table elsewhere."""
        table = self.machine.tables[self.machine.letters[row]]
        result = np.full((2, len(self.motion)), table.nodes[0])
        arcs = self.m.arcs
        if len(arcs):
            arc, t = quadrants(arcs)
            value = points(arcs, self.arc_start, self.arc_target, arc, np.clip(t, 1e-12, 1 - 1e-12))[row]
            first = np.searchsorted(self.motion, arcs.motion[arc])
            value = np.where((t > 0) & (t < 1) & self.free[arcs.motion[arc]], value, table.nodes[0])
            np.minimum.at(result[0], first, value)
            np.maximum.at(result[1], first, value)
        return result

    def ends(self) -> None:
        """`end` (A, S) ticks commanded at each stroke's end, as if nothing were held still; `exact` (A, S) mm."""
        m, motion, n = self.m, self.motion, len(self.motion)
        free = self.free[motion]
        self.exact = self.end_nominal.copy()
        which = np.flatnonzero(free)
        self.exact[:, which] = command(self.machine, self.end_nominal[:, which], self.weight_end[:, which], motion[which])
        step = m.grid[:, motion]
        correction = self.exact - self.end_nominal
        whole = np.rint(correction * TICKS_PER_MM / step).astype(np.int64) * step
        nominal_ticks = np.where(self.last, m.target[:, motion], np.rint(self.end_nominal * TICKS_PER_MM).astype(np.int64))
        self.nominal_end = nominal_ticks
        # A programmed word keeps its own decimals: its correction is rounded, not its sum.
        self.end = nominal_ticks + whole
        self.before = np.concatenate([self.carry.issued[:, None], self.end[:, :-1]], axis=1)
        inner = np.flatnonzero(~self.last)
        if len(inner):
            self.end[:, inner] = self.grid(inner, self.exact[:, inner])
        # A word that is not there is written on the grid of its own zero.
        bare = m.word < 0
        row, absent = np.nonzero(self.last & (bare & ~m.incremental)[:, motion]) if bare.any() else (np.zeros(0, np.int64),) * 2
        zero, step = m.origin[row, motion[absent]], step[row, absent]
        on_grid = zero + np.rint((self.exact[row, absent] * TICKS_PER_MM - zero) / step).astype(np.int64) * step
        loose = (on_grid - self.end[row, absent]) % step != 0  # the nominal place itself is off the grid
        self.end[row[loose], absent[loose]] = on_grid[loose]
        self.end[self.fixed] = nominal_ticks[self.fixed]
        if not free.all():
            self.end[:, ~free] = nominal_ticks[:, ~free]
        self.sure = np.concatenate([[self.carry.sure], free[:-1]]) if n else free
        self.known_before = self.start_known[motion] | (self.t0 > 0)

    def starts(self) -> None:
        """`wanted` (A, S) ticks: where a stroke must be begun, for strokes (`turning`) whose start may differ."""
        m, motion = self.m, self.motion
        cutting = (m.code[motion] != RAPID) & (m.code[motion] != FOREIGN)
        weight_before = np.concatenate([(self.carry.turn / max(self.c.limit, 1))[:, None], self.weight_end[:, :-1]], axis=1)
        turned = ((weight_before != self.weight_begin) & self.machine.two_way[:, None]).any(axis=0)
        self.turning = cutting & self.free[motion] & self.known_before & (turned | ~self.sure)
        if self.c.mode != "step":
            self.turning &= ~self.sure & (self.t0 == 0) & (self.c.mode != "off")
        which = np.flatnonzero(self.turning)
        self.wanted = np.zeros_like(self.end)
        exact = command(self.machine, self.begin_nominal[:, which], self.weight_begin[:, which], motion[which])
        self.wanted[:, which] = self.grid(which, exact)
        self.wanted[self.fixed] = self.before[self.fixed]

    def settle_ends(self) -> None:
        """Hold still what stands still: an axis without nominal travel moves only when its correction has changed by
        more than half the tolerance. Sets `begin` (A, S), where each stroke is begun, and the final `before` and `end`."""
        hold = self.c.hold * TICKS_PER_MM
        free, known = self.free[self.motion], self.known_before
        turning, all_known = self.turning.any(), known.all()
        self.induced = self.carry.induced
        held = (self.travel == 0).any(axis=1)
        if all_known and not turning and not held[self.rows].any():
            self.begin = self.before
            return
        self.begin = self.before.copy()
        for row in range(len(self.end)):
            end = self.end[row]
            if row in self.rows and held[row]:
                still = np.flatnonzero((self.travel[row] == 0) & free & known & (self.sure | self.turning))
                if len(still):
                    value, exact = end.tolist(), (self.exact[row, still] * TICKS_PER_MM).tolist()
                    wanted, turning = self.wanted[row, still].tolist(), self.turning[still].tolist()
                    first = int(self.carry.issued[row])
                    for k, i in enumerate(still.tolist()):
                        here = value[i - 1] if i else first
                        if turning[k] and abs(wanted[k] - here) > hold:
                            here = wanted[k]
                        if abs(exact[k] - here) <= hold:
                            value[i] = here
                    end = np.array(value, np.int64)
                    self.end[row] = end
            before = np.concatenate([self.carry.issued[row : row + 1], end[:-1]])
            before = np.where(known, before, self._nominal_begin(row))
            self.before[row] = before
            differs = self.turning & (np.abs(self.wanted[row] - before) > hold)
            self.begin[row] = np.where(differs, self.wanted[row], before)

    def _nominal_begin(self, row: int) -> np.ndarray:
        return np.where(self.t0 == 0, self.m.start[row, self.motion], np.rint(self.begin_nominal[row] * TICKS_PER_MM).astype(np.int64))

    # -- pieces --------------------------------------------------------------------------------------------------------

    def spread_reversals(self) -> None:
        """Mode off: `differs` (A, S) mm, by how much each stroke's begin misses the command that it needs."""
        if self.c.mode == "off" and self.c.limit:
            which = np.flatnonzero(self.known_before & self.free[self.motion])
            exact = command(self.machine, self.begin_nominal[:, which], self.weight_begin[:, which], self.motion[which])
            self.differs = np.zeros_like(self.exact)
            self.differs[:, which] = self.begin[:, which] / TICKS_PER_MM - exact

    def take_ups(self):
        """A piece for every stroke that must be begun elsewhere than the last one ended."""
        which = np.flatnonzero(self.turning & (self.begin != self.before).any(axis=0))
        if not len(which):
            return None
        return self.pack(which, np.full(len(which), -1), np.full(len(which), FEED), self.before[:, which], self.begin[:, which],
                         np.zeros(len(which)), self._begin_ticks(which), take_up=True)  # fmt: skip

    def _begin_ticks(self, which: np.ndarray) -> np.ndarray:
        return np.rint(self.begin_nominal[:, which] * TICKS_PER_MM).astype(np.int64)

    def pack(self, stroke, order, code, start, end, share, nominal, take_up=False, arc=None, centre=None):
        n = len(stroke)
        pieces = Pieces(
            motion=self.motion[stroke], code=np.asarray(code, np.int8), start=start, end=end, share=share,
            arc=np.full(n, -1) if arc is None else arc, centre=np.zeros((2, n), np.int64) if centre is None else centre,
            nominal=nominal, take_up=np.full(n, take_up), corrected=self.free[self.motion[stroke]],
        )  # fmt: skip
        return np.stack([stroke, order], axis=1), pieces

    def lines(self):
        """Straight strokes: whole, or cut where the map asks for it."""
        m, motion = self.m, self.motion
        code = m.code[motion]
        straight = np.flatnonzero((code == RAPID) | (code == FEED) | (code == FOREIGN) | ~self.free[motion])
        if not len(straight):
            return None
        may = (code[straight] == FEED) | (self.options.cut_rapids & (code[straight] == RAPID))
        may &= self.free[motion[straight]] & self.known_before[straight]
        chosen = straight[may]
        if self.c.mode != "ramp":
            chosen = chosen[lines.may_bend(self.machine, self.begin_nominal[:, chosen], self.end_nominal[:, chosen], self.c.slack)]
        owner, t, exact = self._cuts(chosen)
        if not len(owner):
            return self.pack(straight, np.zeros(len(straight), np.int64), code[straight], self.begin[:, straight], self.end[:, straight],
                             np.ones(len(straight)), self.nominal_end[:, straight])  # fmt: skip
        # Cuts come before the end of their own stroke; both are in order already.
        cut = chosen[owner]
        of = np.searchsorted(straight, cut)
        place_cut = of + np.arange(len(of))
        place_end = np.arange(len(straight)) + np.cumsum(np.bincount(of, minlength=len(straight)))
        n = len(straight) + len(cut)
        stroke, time = np.empty(n, np.int64), np.ones(n)
        stroke[place_end], stroke[place_cut], time[place_cut] = straight, cut, t
        end, nominal = self.end[:, stroke], self.nominal_end[:, stroke]
        end[:, place_cut] = self.grid(cut, exact)
        nominal[:, place_cut] = np.rint(self.nominal(motion[cut], t) * TICKS_PER_MM).astype(np.int64)
        end[self.fixed] = nominal[self.fixed]
        # An axis that stands still keeps still in the middle too; a piece of no length is none.
        first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
        start = self._starts(stroke, first, end)
        none = (start == end).all(axis=0) & (time < 1.0)
        if none.any():
            stroke, time, end, nominal = stroke[~none], time[~none], end[:, ~none], nominal[:, ~none]
            first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
            start = self._starts(stroke, first, end)
        share = time.copy()
        share[1:] -= np.where(first[1:], 0.0, time[:-1])
        return self.pack(stroke, np.arange(len(stroke)), m.code[motion[stroke]], start, end, share, nominal)

    def _starts(self, stroke: np.ndarray, first: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(A, K) ticks at which pieces begin: where the one before ended, or where their stroke is begun."""
        start = np.empty_like(end)
        start[:, 1:] = end[:, :-1]
        start[:, first] = self.begin[:, stroke[first]]
        return start

    def _cuts(self, chosen: np.ndarray):
        """(K,) index into chosen, (K,) t, (A, K) exact command mm of every cut inside the chosen strokes."""
        if not len(chosen):
            return np.zeros(0, np.int64), np.zeros(0), np.zeros((len(self.machine.axes), 0))
        start, target = self.begin_nominal[:, chosen], self.end_nominal[:, chosen]
        owner, t, axis = lines.candidates(self.machine, start, target, self.c.slack)
        for more, at in self._ramp_ends(chosen):
            owner, t, axis = np.concatenate([owner, more]), np.concatenate([t, at]), np.concatenate([axis, np.full(len(at), -1)])
        exact = self._along(chosen, owner, t)
        # It is the command that passes the node, not the nominal point: step back by the correction.
        node = np.flatnonzero(axis >= 0)
        way = (target - start)[axis[node], owner[node]]
        there = start[axis[node], owner[node]] + way * t[node]
        t[node] = np.clip(t[node] - (exact[axis[node], node] - there) / way, 1e-9, 1 - 1e-9)
        exact[:, node] = self._along(chosen, owner[node], t[node])
        order = lines.tidy(owner, t)
        owner, t, exact = owner[order], t[order], exact[:, order]
        correction = exact - (start[:, owner] + (target - start)[:, owner] * t)
        first = np.concatenate([[True], owner[1:] != owner[:-1]])
        final = np.concatenate([owner[1:] != owner[:-1], [True]])
        correction[:, first] = self.begin[:, chosen] / TICKS_PER_MM - start
        correction[:, final] = self.end[:, chosen] / TICKS_PER_MM - target
        tolerance = np.where(self.travel[:, chosen] == 0, self.c.chord / 2, self.c.chord)
        rows = self.rows
        cut = lines.merge(owner, t, correction[rows], tolerance[rows])
        return owner[cut], t[cut], exact[:, cut]

    def _along(self, chosen: np.ndarray, owner: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(A, K) mm exact commands at t along straight strokes."""
        start = self.begin_nominal[:, chosen[owner]]
        nominal = start + (self.end_nominal[:, chosen[owner]] - start) * t
        return self.needed(chosen[owner], nominal, self.weight(chosen[owner], nominal), t)

    def _ramp_ends(self, chosen: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Where a ramp ends inside a stroke: there the correction bends."""
        result = []
        if self.c.mode == "ramp":
            for row in range(len(self.travel)):
                way = self.travel[row, chosen] / self.c.limit
                with np.errstate(divide="ignore", invalid="ignore"):
                    t = (np.sign(way) - self.weight_begin[row, chosen]) / way
                inside = np.flatnonzero((t > 0) & (t < 1))
                result.append((inside, t[inside]))
        return result

    def arcs(self):
        """Strokes of arcs: kept, halved, or chords."""
        m, motion, arcs = self.m, self.motion, self.m.arcs
        which = np.flatnonzero((self.arc_of[motion] >= 0) & self.free[motion])
        if not len(which):
            return None
        for i in which[~self.known_before[which]][:1]:
            raise MotionFault(int(motion[i]), "an arc that begins at an unknown place", "move every axis to an absolute position first, or say --start")
        rows = Rows(
            arc=self.arc_of[motion[which]], stroke=which, t0=self.t0[which], t1=self.t1[which], begin=self.begin[:, which],
            end=self.end[:, which], centre=np.zeros((2, len(which)), np.int64), chord=np.zeros(len(which), bool),
        )  # fmt: skip
        written = _written_centre(m)
        fitter = Fitter(
            machine=self.machine, arcs=arcs, start=self.arc_start, target=self.arc_target, tolerance=self.c.plane,
            tolerance_across=self.c.chord, mismatch=self.options.arc_mismatch, base=written,
            needed=lambda r, row, t, p: self.needed(r.stroke[row], p, self.weight(r.stroke[row], p), t),
            round_to=lambda r, row, exact: self.grid(r.stroke[row], exact),
        )  # fmt: skip
        rows = fitter.settle(rows)
        order = np.rint((rows.t0 - self.t0[rows.stroke]) * 2**30).astype(np.int64)
        code = np.where(rows.chord, FEED, m.code[motion[rows.stroke]])
        nominal = np.rint(points(arcs, self.arc_start, self.arc_target, rows.arc, rows.t1) * TICKS_PER_MM).astype(np.int64)
        none = (rows.begin == rows.end).all(axis=0) & rows.chord & (rows.t1 < 1)
        key, pieces = self.pack(
            rows.stroke, order, code, rows.begin, rows.end, rows.t1 - rows.t0, nominal,
            arc=np.where(rows.chord, -1, rows.arc), centre=rows.centre,
        )  # fmt: skip
        if none.any():
            fields = Pieces.__dataclass_fields__
            pieces = Pieces(**{f: getattr(pieces, f)[..., ~none] for f in fields})
            key = key[~none]
        return key, pieces

    # -- afterwards ----------------------------------------------------------------------------------------------------

    def check_limits(self) -> None:
        free = self.free[self.motion]
        correction = np.abs(self.end - self.nominal_end)[self.rows] / TICKS_PER_MM
        largest = self.machine.limits.max_correction
        over = np.flatnonzero(free & (correction > largest).any(axis=0))
        faults = [(int(i), "over") for i in over[:1]]
        for row in self.rows:
            low, high = self.machine.axes[self.machine.letters[row]].travel
            value = self.end[row] / TICKS_PER_MM
            faults += [(int(i), self.machine.letters[row]) for i in np.flatnonzero(free & ((value < low - EDGE) | (value > high + EDGE)))[:1]]
        if not faults:
            self.largest = max(self.carry.largest, float(correction[:, free].max(initial=0.0)))
            return
        i, what = min(faults)
        if what == "over":
            row = int(np.argmax(correction[:, i]))
            letter = self.machine.letters[self.rows[row]]
            raise MotionFault(int(self.motion[i]), f"the correction of {letter} is {correction[row, i]:.4f} mm (limit max_correction = {largest:g} mm)", "is the map in the right unit, and the work offset right? else raise max_correction in machine.toml")
        axis = self.machine.axes[what]
        value = self.end[self.machine.letters.index(what), i] / TICKS_PER_MM
        raise MotionFault(int(self.motion[i]), f"{what} = {value:.4f} mm (nominal and correction) is beyond the travel of {what} ({axis.travel[0]:g} to {axis.travel[1]:g} mm)", "the slide can not go there: move the part or the work offset")

    def next_carry(self) -> Carry:
        return Carry(
            turn=self.turn_after[:, -1].copy(), issued=self.end[:, -1].copy(), sure=bool(self.free[self.motion[-1]]),
            largest=self.largest, induced=self.induced,
        )  # fmt: skip


__all__ = ["CLOCKWISE", "COUNTER", "Carry", "Compensator", "Options"]
