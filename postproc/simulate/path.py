"""Steps to a path: straight pieces and curves along each of which every axis goes one way, joined
as the control joins them.

A curve is c + axial t + r(t) (e1 cos phi + e2 sin phi), t from 0 to 1: an arc, spiral or helix of
the program, or the arc by which a corner between two feeds is cut. A corner is cut by `corner` mm
at most, and takes no more than 0.45 of either side; where it is not cut, the control slows down in
it (plan.py). All curves are cut where an axis turns back.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from postproc.simulate.program import Steps

XYZ = "XYZ"
STRAIGHT = 1e-6  # rad: less is no corner
BACK = np.pi - 0.05  # rad: sharper corners are stopped in
SHALLOWEST = 1e-6  # mm: a curve that turns an axis back by less does not
# ten points: 1e-6 mm of a spiral that begins in its centre, the last digits of others
NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)


@dataclass(frozen=True)
class Curves:
    """n curves. base, axial, e1, e2 (A, n) mm; phi, sweep (n,) rad; r0, r1 (n,) mm: as above."""

    base: np.ndarray
    axial: np.ndarray
    e1: np.ndarray
    e2: np.ndarray
    phi: np.ndarray
    sweep: np.ndarray
    r0: np.ndarray
    r1: np.ndarray

    def pick(self, which: np.ndarray) -> Curves:
        """These of them: (K,) rows, or (n,) bool."""
        return Curves(
            **{name: getattr(self, name)[..., which] for name in Curves.__dataclass_fields__}
        )

    def __len__(self) -> int:
        return len(self.phi)

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(A, n) place, first and second derivative by t, at t (n,)."""
        phi = self.phi + self.sweep * t
        r = self.r0 + (self.r1 - self.r0) * t
        dr = self.r1 - self.r0
        w = self.sweep
        # place = base + axial t + r out; out' = w along, along' = -w out, r' = dr
        out = self.e1 * np.cos(phi) + self.e2 * np.sin(phi)
        along = self.e2 * np.cos(phi) - self.e1 * np.sin(phi)
        return (
            self.base + self.axial * t + r * out,
            self.axial + dr * out + r * w * along,
            2 * dr * w * along - r * w**2 * out,
        )

    @property
    def rise(self) -> np.ndarray:
        """(n,) mm: length of the axial way."""
        return np.sqrt((self.axial**2).sum(axis=0))

    def pace(self, t: np.ndarray) -> np.ndarray:
        """(..., n) ds/dt, mm."""
        r, dr = self.r0 + (self.r1 - self.r0) * t, self.r1 - self.r0
        return np.sqrt(dr**2 + (r * self.sweep) ** 2 + self.rise**2)

    def length(self, t: np.ndarray) -> np.ndarray:
        """(n,) mm from 0 to t."""
        x = 0.5 * t * (NODES[:, None] + 1.0)
        return 0.5 * t * (WEIGHTS[:, None] * self.pace(x)).sum(axis=0)

    def parameter(self, s: np.ndarray, length: np.ndarray) -> np.ndarray:
        """(n,) t at which s (n,) mm are gone."""
        # exact for arcs and helices; on spirals the pace changes along t, and Newton's steps find
        # it
        t = s / length
        for _ in range(6 if np.any(self.r0 != self.r1) else 0):
            t = np.clip(t - (self.length(t) - s) / self.pace(t), 0.0, 1.0)
        return t

    def part(self, t0: np.ndarray, t1: np.ndarray) -> Curves:
        """The parts from t0 to t1 (n,)."""
        dt, dr = t1 - t0, self.r1 - self.r0
        return replace(
            self, base=self.base + self.axial * t0, axial=self.axial * dt,
            phi=self.phi + self.sweep * t0, sweep=self.sweep * dt, r0=self.r0 + dr * t0,
            r1=self.r0 + dr * t1,
        )  # fmt: skip


@dataclass(frozen=True)
class Path:
    """P pieces in order. begin, end (A, P) mm; length (P,) mm along the path, of a rotary motion
    degrees; step (P,); curve (P,): row in curves, or -1; turns (P,): whether only rotary axes move;
    letters: of the A axes."""

    letters: tuple[str, ...]
    begin: np.ndarray
    end: np.ndarray
    length: np.ndarray
    step: np.ndarray
    curve: np.ndarray
    curves: Curves
    turns: np.ndarray
    steps: Steps = field(repr=False)

    @property
    def rests(self) -> np.ndarray:
        """(P,) whether nothing moves."""
        return ~np.isnan(self.steps.wait[self.step])

    def tangents(self) -> tuple[np.ndarray, np.ndarray]:
        """(A, P) direction at the beginning and at the end of each piece, per mm of path."""
        first = (self.end - self.begin) / np.where(self.length > 0, self.length, 1.0)
        last = first.copy()
        of = np.flatnonzero(self.curve >= 0)
        c = self.curves.pick(self.curve[of])
        for t, into in ((np.zeros(len(of)), first), (np.ones(len(of)), last)):
            into[:, of] = c.at(t)[1] / c.pace(t)
        return first, last

    def at(self, piece: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(A, K) place, direction and curvature (second derivative by the path) where s (K,) mm of
        a piece are gone."""
        length = self.length[piece]
        share = np.where(length > 0, s / np.where(length > 0, length, 1.0), 0.0)
        way = (self.end - self.begin)[:, piece]
        place = self.begin[:, piece] + way * share
        direction = way / np.where(length > 0, length, 1.0)
        bend = np.zeros_like(place)
        of = np.flatnonzero(self.curve[piece] >= 0)
        if len(of):
            c = self.curves.pick(self.curve[piece[of]])
            t = c.parameter(s[of], length[of])
            place[:, of], first, second = c.at(t)
            pace = c.pace(t)
            direction[:, of] = first / pace
            bend[:, of] = (
                second - direction[:, of] * (second * direction[:, of]).sum(axis=0)
            ) / pace**2
        return place, direction, bend


def of(steps: Steps, letters: tuple[str, ...], corner: float) -> Path:
    """The path of a program whose corners are cut by `corner` mm at most; 0: kept as they are."""
    end = steps.end
    # an arc is a row of curves, a line a row of lines; `key` brings both back into the order of
    # steps
    begin = np.concatenate([steps.begin[:, None], end[:, :-1]], axis=1)
    linear = np.array([x in XYZ for x in letters])
    way = end - begin
    length = np.sqrt((way[linear] ** 2).sum(axis=0))
    round_about = np.sqrt((way**2).sum(axis=0))
    turns = (length == 0) & (round_about > 0) & (steps.arc < 0)
    length = np.where(turns, round_about, length)
    arc = np.flatnonzero(steps.arc >= 0)
    curves = _arcs(steps, begin, end, arc)
    straight = np.flatnonzero((steps.arc < 0) & ((length > 0) | ~np.isnan(steps.wait)))
    lines = {
        "begin": begin[:, straight],
        "end": end[:, straight],
        "step": straight,
        "key": straight.astype(float),
    }
    owner, key = arc, arc.astype(float)
    if corner > 0:
        cut, cut_owner = _cut_corners(lines, steps, length, turns, linear, corner)
        curves = Curves(
            **{
                n: np.concatenate([getattr(curves, n), getattr(cut, n)], axis=-1)
                for n in Curves.__dataclass_fields__
            }
        )
        # a cut corner comes behind its step, and before the next: + 0.5
        owner, key = np.append(owner, cut_owner), np.append(key, cut_owner + 0.5)
    which, t0, t1 = _turning(curves)
    curves = curves.pick(which).part(t0, t1)
    n, m = len(straight), len(curves)
    ends = [curves.at(np.full(m, t))[0] for t in (0.0, 1.0)]
    step = np.concatenate([lines["step"], owner[which]])
    order = np.lexsort(
        (np.concatenate([np.zeros(n), t0]), np.concatenate([lines["key"], key[which]]))
    )
    gone = np.sqrt(((lines["end"] - lines["begin"])[linear] ** 2).sum(axis=0))
    gone = np.where(turns[straight], length[straight], gone)
    path = Path(
        letters=letters, begin=np.concatenate([lines["begin"], ends[0]], axis=1)[:, order],
        end=np.concatenate([lines["end"], ends[1]], axis=1)[:, order],
        length=np.concatenate([gone, curves.length(np.ones(m))])[order],
        step=step[order].astype(np.int64),
        curve=np.concatenate([np.full(n, -1), np.arange(m)])[order], curves=curves,
        turns=np.concatenate([turns[straight], np.zeros(m, bool)])[order], steps=steps,
    )  # fmt: skip
    return path


def _arcs(steps: Steps, begin: np.ndarray, end: np.ndarray, of: np.ndarray) -> Curves:
    """The arcs of the program: their radii are those of start and end, what is not in their plane
    goes along evenly."""
    arcs, row, n, a = steps.arcs, steps.arc[of], len(of), len(begin)
    first, second, column = arcs.first[row], arcs.second[row], np.arange(n)
    base, axial = begin[:, of].copy(), (end - begin)[:, of].copy()
    e1, e2 = np.zeros((a, n)), np.zeros((a, n))
    for axis, unit, centre in ((first, e1, arcs.centre[0, row]), (second, e2, arcs.centre[1, row])):
        unit[axis, column] = 1.0
        base[axis, column] = centre
        axial[axis, column] = 0.0
    return Curves(
        base, axial, e1, e2, arcs.angle[row], arcs.sweep[row], arcs.radius[row],
        arcs.radius_end[row],
    )  # fmt: skip


def _cut_corners(
    lines: dict,
    steps: Steps,
    length: np.ndarray,
    turns: np.ndarray,
    linear: np.ndarray,
    corner: float,
):
    """Arcs for the corners between feeds, and the step that each follows; the lines are shortened
    by what they take."""
    step = lines["step"]
    k = np.arange(len(step) - 1)
    feeds = np.isnan(steps.wait[step]) & ~steps.rapid[step] & ~turns[step]
    feeds &= np.abs(lines["end"] - lines["begin"])[~linear].sum(axis=0) == 0
    joined = feeds[k] & feeds[k + 1] & (steps.arc[step[k] + 1] < 0) & ~steps.stop[step[k]]
    # arcs before each: none may lie between
    gap = np.searchsorted(np.flatnonzero(steps.arc >= 0), step)
    joined &= gap[k] == gap[k + 1]
    k = k[joined]
    size = length[step]
    d = (lines["end"] - lines["begin"]) / np.where(size > 0, size, 1.0)
    d1, d2 = d[:, k], d[:, k + 1]
    # by half angles: of nearly equal directions arccos of their product has no digits left
    angle = 2 * np.arctan2(np.linalg.norm(d1 - d2, axis=0), np.linalg.norm(d1 + d2, axis=0))
    cut = (angle > STRAIGHT) & (angle < BACK)
    k, d1, d2, angle = k[cut], d1[:, cut], d2[:, cut], angle[cut]
    #     d1  ----o......+  corner      trim: o to +, r tan(angle / 2), of either side at most 0.45
    #              '.  off:             off: from + to the arc, r (1 / cos(angle / 2) - 1), here
    #                 '.  :             without the cancellation of small angles
    #                    'o
    #                     |  d2
    reach = 0.45 * np.minimum(size[k], size[k + 1])
    # how far a circle of radius 1 misses the corner
    off = 2 * np.sin(angle / 4) ** 2 / np.cos(angle / 2)
    r = np.minimum(corner / off, reach / np.tan(angle / 2))
    trim = r * np.tan(angle / 2)
    normal = (d2 - d1 * np.cos(angle)) / np.sin(angle)
    begin = lines["end"][:, k] - d1 * trim
    lines["end"][:, k] = begin
    lines["begin"][:, k + 1] += d2 * trim
    zero = np.zeros(len(k))
    return Curves(begin + normal * r, np.zeros_like(begin), -normal, d1, zero, angle, r, r), step[k]


def _turning(curves: Curves) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(K,) curve, and (K,) t where each part of it begins and ends between places where an axis
    turns back."""
    n = len(curves)
    owners, places = [np.arange(n)], [np.zeros(n)]
    span = np.where(curves.sweep != 0, curves.sweep, 1.0)
    for a, b in zip(curves.e1, curves.e2, strict=True):
        # a cos(phi) + b sin(phi) = size cos(phi - extreme): the axis turns back at extreme + k pi
        size = np.hypot(a, b)
        extreme = np.arctan2(b, a)
        low = np.minimum(curves.phi, curves.phi + curves.sweep)
        high = np.maximum(curves.phi, curves.phi + curves.sweep)
        first = np.ceil((low - extreme) / np.pi)
        count = np.where(
            size > 0, np.maximum(np.floor((high - extreme) / np.pi) - first + 1, 0), 0
        ).astype(np.int64)
        owner = np.repeat(np.arange(n), count)
        index = first[owner] + np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        t = (extreme[owner] + index * np.pi - curves.phi[owner]) / span[owner]
        depth = curves.r0[owner] * size[owner]
        # A curve that ends a hair behind an extreme would be cut into a piece of no length, and its
        # axis turn back by less than anything can show.
        deep = [
            depth * (1 - np.cos(np.minimum(np.abs(span[owner]) * u, np.pi))) > SHALLOWEST
            for u in (t, 1 - t)
        ]
        keep = (t > 0) & (t < 1) & deep[0] & deep[1]
        owners.append(owner[keep])
        places.append(t[keep])
    owner, t0 = np.concatenate(owners), np.concatenate(places)
    order = np.lexsort((t0, owner))
    owner, t0 = owner[order], t0[order]
    same = np.ones(len(owner), bool)
    same[1:] = (owner[1:] != owner[:-1]) | (t0[1:] - t0[:-1] > 1e-12)
    owner, t0 = owner[same], t0[same]
    t1 = np.append(t0[1:], 1.0)
    t1[np.flatnonzero(owner[1:] != owner[:-1])] = 1.0
    return owner, t0, t1
