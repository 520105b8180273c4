"""One likelihood for noise, nuisances and effects: how much more probable are the readings with a
set of effects than without.

Readings of every unit are y = F c + B b + e: columns F that all units share (the map's error and
the effects), B that are its own (zeros, set-ups, wander), e its white noise after the
autoregression is taken out. All coefficients are normal with mean zero, so the evidence is closed
form for given standard deviations; these are learned beside every set by MacKay's fixed point
(Bayesian interpolation, Neural Computation 4, 1992, 415), so that wander and drift, map and effect
compete as equals.

Sizes: N rows in all, n of a unit, q own columns, f shared columns, K columns of the dictionary. mm.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from postproc.diagnose.block import Block
from postproc.diagnose.dictionary import Products
from postproc.diagnose.factors import factors, likeliest_size
from postproc.diagnose.layout import Layout, square
from postproc.diagnose.noise import Unit
from postproc.diagnose.nuisances import FREE, Group
from postproc.diagnose.parts import (
    SURE,
    Part,
    Reduced,
    cholesky,
    inverted,
    solved,
    solved_back,
    surprise,
)

# mm: the usual size of an effect, at its largest reading (the recordings of ISO 230 tests show 1 to
# 50 um)
SLAB = 8e-3
# a map's uncertainty is stated, or usual: a few terms do not overrule it
MAP_SURE, MAP_MOST = 60.0, 3.0
STEPS = 8
SCALES = (0.03, 1000.0)  # of the usual size of an effect
NOTHING = 1e-12  # mm: of what is not there
QUIETEST = 0.05  # of the variance of white noise as it was found first

On = frozenset[tuple[int, str]]  # units that have a process of their own, and of what


@dataclass
class Fit:
    """A set of blocks, fitted. value: twice the logarithm of the evidence, but for a constant; mean
    (f,) of the shared coefficients, root (f, f): Cholesky factor (lower) of the inverse of their
    covariance; shared: learned standard deviations of the map's groups; scale: of each block, what
    its usual size is multiplied by; parts: its units; likeliest: of other blocks, the likeliest
    such factor of those tried."""

    chosen: tuple[int, ...]
    on: On
    value: float
    mean: np.ndarray
    root: np.ndarray
    shared: np.ndarray
    scale: dict[int, float]
    parts: list[Reduced]
    likeliest: dict[int, float] = field(default_factory=dict)

    @cached_property
    def covariance(self) -> np.ndarray:
        """(f, f) of the shared coefficients."""
        inverse = inverted(self.root)
        return np.asarray(inverse.T @ inverse)


class Evidence:
    """The readings y (N,) mm and everything that may explain them."""

    def __init__(
        self,
        y: np.ndarray,
        units: list[Unit],
        own: list[list[Group]],
        shared: list[Group],
        train: np.ndarray,
    ):
        self.y, self.groups = y, shared
        self.shared = (
            np.concatenate([g.columns for g in shared], axis=1) if shared else np.zeros((len(y), 0))
        )
        self.shared_of = np.repeat(np.arange(len(shared)), [g.columns.shape[1] for g in shared])
        self.shared_usual = np.array([g.sd for g in shared])
        self.shared_learned = np.array([g.learned for g in shared], bool)
        self.shared_free = self.shared_usual[self.shared_of] > FREE / 10
        self.parts = [
            Part(u, train, g, self.shared, y)
            for u, g in zip(units, own, strict=True)
            if train[u.rows].any()
        ]
        self.blocks: list[Block] = []
        self.fixed: set[int] = set()  # blocks whose size is stated: of no use as further members
        self.first: list[int] = []  # columns of the others, -1 of those
        self.width = 0
        self.slab = np.zeros(0)
        self._slab: list[np.ndarray] = []  # of each block
        self._again = deque[Block]()
        self.pairs = np.zeros((2, 0), int)  # columns of one block

    # -- the dictionary ----------------------------------------------------------------------------

    def add(self, blocks: list[Block], sd: float = 0.0) -> list[int]:
        """Let blocks in, which forget their columns then; their numbers. sd: stated standard
        deviation of each coefficient; 0: learned, from that of which SLAB is how large it is where
        it is largest."""
        if not blocks:
            return []
        begin, before = len(self.blocks), self.pairs.shape[1]
        self.blocks = [*self.blocks, *blocks]
        numbers = list(range(begin, len(self.blocks)))
        self._slab += [np.full(b.width, sd) if sd else SLAB / b.largest for b in blocks]
        for b in blocks:
            self.first.append(-1 if sd else self.width)
            self.width += 0 if sd else b.width
        for part in self.parts:
            part.dictionary.add([(k, self.first[k], self.blocks[k]) for k in numbers])
        for block in blocks:
            block.let_go(self._again)
        if sd:
            self.fixed |= set(numbers)
            return numbers
        self.slab = np.concatenate([self.slab, *self._slab[begin:]])
        pairs = [np.stack(np.triu_indices(self.blocks[k].width)) + self.first[k] for k in numbers]
        self.pairs = np.concatenate([self.pairs, *pairs], axis=1)
        for part in self.parts:
            part.dictionary.index(numbers, self.pairs[:, before:], before)
        return numbers

    def slab_of(self, chosen: tuple[int, ...]) -> np.ndarray:
        """(w,) usual standard deviations of the coefficients of blocks."""
        return np.concatenate([np.zeros(0), *(self._slab[k] for k in chosen)])

    # -- a set of blocks ---------------------------------------------------------------------------

    # Whole: what is kept of a like fit and what is learned anew are one state.
    def learn(
        self,
        chosen: tuple[int, ...],
        like: Fit | None,
        on: On = frozenset(),
        steps: int = STEPS,
        least: np.ndarray | None = None,
        afresh: bool = False,
    ) -> Fit:
        """The evidence of a set of blocks, with what is learned beside it. like: a fit that differs
        by little, of which units that see no difference are kept; on: units with a process of their
        own; least: variance of each unit that is there in any case (1: of its white noise), for
        want of the exact form of what is explained; afresh: the others begin at what is usual, not
        at what was learned before."""
        least = np.full(len(self.parts), QUIETEST) if least is None else least
        shown = [tuple(c for c in chosen if c in p.dictionary.which) for p in self.parts]
        kinds = [frozenset(kind for u, kind in on if u == k) for k in range(len(self.parts))]
        shared = self.shared_usual if like is None else like.shared
        bare = like or (self.learn((), None, on, 0, least) if chosen else None)
        scale = {k: self._first_scale(bare, k) for k in chosen if bare}
        parts: list[Reduced] = []
        touched = []
        for k, part in enumerate(self.parts):
            old = like.parts[k] if like else None
            # Units in which nothing changes are kept as they were, sizes and sums: a set and one
            # with a member more differ in the few instruments in which that shows.
            same = old and old.shown == shown[k] and old.asked.own.kinds == kinds[k]
            if old and same and old.sigma2 >= least[k]:
                parts.append(old)
                continue
            sigma2, sd = (old.sigma2, old.sd) if old and not afresh else (1.0, part.usual)
            asked = old.asked if old and same else part.asked(shown[k], kinds[k])
            parts.append(part.reduced(asked, max(sigma2, float(least[k])), sd))
            touched.append(k)
        layout = self._layout(chosen, parts)
        kept = self._summed(layout, [k for k in range(len(parts)) if k not in touched], parts)
        fit = self._joined(layout, on, shared, scale, parts, touched, kept)
        for _ in range(steps):
            shared, scale = self._renewed_shared(fit), self._renewed_scale(layout, fit)
            parts = list(fit.parts)
            for k in touched:
                at = layout.at[k]
                sigma2, sd = self.parts[k].renewed(
                    parts[k], fit.mean[at], fit.covariance[square(at)], float(least[k])
                )
                parts[k] = self.parts[k].reduced(parts[k].asked, sigma2, sd)
            fit = self._joined(layout, on, shared, scale, parts, touched, kept)
        for k in touched:
            fit.parts[k].let_go()
        fit.__dict__.pop("covariance", None)
        return fit

    def _first_scale(self, like: Fit, k: int) -> float:
        """Where learning a block's size begins: as it was learned, else the likeliest of those
        tried, not below the usual. Noise learned without a large effect holds on to it."""
        if k in like.scale or k in self.fixed:
            return float(like.scale.get(k, 1.0))
        if k not in like.likeliest:
            like.likeliest[k] = likeliest_size(*self.among(like, (k,)), self.slab_of((k,)))
        return like.likeliest[k]

    def _layout(self, chosen: tuple[int, ...], parts: list[Reduced]) -> Layout:
        width = np.array([self.blocks[k].width for k in chosen], int)
        whole = len(self.shared_of) + int(width.sum())
        at: list[slice | np.ndarray] = [
            slice(None) if len(old.along) == whole else self.shared_at(k, chosen)
            for k, old in enumerate(parts)
        ]
        slab, of = self.slab_of(chosen), np.repeat(np.arange(len(chosen)), width)
        return Layout(chosen, slab, of, width, at)

    def shared_at(self, k: int, chosen: tuple[int, ...]) -> np.ndarray:
        """Where the shared columns that show in a unit stand among all shared ones."""
        which, at = self.parts[k].dictionary.which, self.shared.shape[1]
        found = [self.parts[k].shows]
        for c in chosen:
            if c in which:
                found.append(at + which[c])
            at += self.blocks[c].width
        return np.concatenate(found)

    def _summed(
        self, layout: Layout, which: list[int], parts: list[Reduced]
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """(f, f), (f,) and a number: what some units tell of the shared coefficients."""
        f = len(self.shared_of) + len(layout.of)
        a, b, value = np.zeros((f, f)), np.zeros(f), 0.0
        for k in which:
            a[square(layout.at[k])] += parts[k].inside
            b[layout.at[k]] += parts[k].along
            value += parts[k].value
        return a, b, value

    def _joined(
        self,
        layout: Layout,
        on: On,
        shared: np.ndarray,
        scale: dict[int, float],
        parts: list[Reduced],
        touched: list[int],
        kept: tuple[np.ndarray, np.ndarray, float],
    ) -> Fit:
        """All units together: those that were touched, and the sums of those that were kept."""
        chosen, now = layout.chosen, np.array([scale[k] for k in layout.chosen])
        sd = np.concatenate([shared[self.shared_of], now[layout.of] * layout.slab])
        a, b, value = self._summed(layout, touched, parts)
        a, b, value = a + kept[0], b + kept[1], value + kept[2]
        # The step that took each unit's own columns out, once more for the shared ones: a is the
        # precision of their coefficients, readings and prior together, and twice the logarithm of
        # the evidence gains |root^-1 b|^2 - log det a - log det sd^2.
        a[np.diag_indices(len(sd))] += 1.0 / sd**2
        root = cholesky(a)
        half = solved(root, b[:, None])
        value += float(np.sum(half**2))
        value -= 2.0 * float(np.log(root.diagonal()).sum() + np.log(sd).sum())
        learned, free = self.shared_learned, [k not in self.fixed for k in chosen]
        value -= float(np.sum(surprise(shared[learned], self.shared_usual[learned])))
        value -= float(np.sum(surprise(now[np.array(free, bool)], 1.0)))
        mean = solved_back(root, half)[:, 0]
        return Fit(chosen, on, value, mean, root, shared, scale, parts)

    def _renewed_shared(self, fit: Fit) -> np.ndarray:
        new, of, learned = fit.shared.copy(), self.shared_of, self.shared_learned
        many, usual = len(new), self.shared_usual[learned]
        # MacKay's gamma: of so many coefficients as many count as the readings determine, the
        # others are as wide as they were before (variance sd^2 each). The fixed point is sd^2 = sum
        # of squares / gamma; MAP_SURE coefficients of the usual size stand beside them.
        spread = np.bincount(of, fit.covariance.diagonal()[: len(of)], many) / fit.shared**2
        dof = np.maximum(np.bincount(of, minlength=many) - spread, 0.0)[learned]
        power = np.bincount(of, fit.mean[: len(of)] ** 2, many)[learned]
        now = np.sqrt((power + MAP_SURE * usual**2) / (dof + MAP_SURE))
        new[learned] = np.clip(now, 0.3 * usual, MAP_MOST * usual)
        return new

    def _renewed_scale(self, layout: Layout, fit: Fit) -> dict[int, float]:
        """The sizes of blocks: the terms of a curve tell each other how large they are."""
        z, many = len(self.shared_of), len(layout.chosen)
        scale = np.array([fit.scale[k] for k in layout.chosen])
        spread = fit.covariance.diagonal()[z:] / layout.slab**2
        dof = np.maximum(layout.width - np.bincount(layout.of, spread, many) / scale**2, 0.0)
        power = np.bincount(layout.of, (fit.mean[z:] / layout.slab) ** 2, many)
        now = np.clip(np.sqrt((power + SURE) / (dof + SURE)), *SCALES)
        return {
            k: 1.0 if k in self.fixed else float(v) for k, v in zip(layout.chosen, now, strict=True)
        }

    # -- the whole dictionary beside a set ---------------------------------------------------------

    def scan(self, fit: Fit, draws: np.ndarray | None = None) -> Any:
        """Every block beside a fitted set, its sizes as they are. (B,) twice the logarithm of the
        Bayes factor, -inf of those whose size is stated; (K,) coefficients of the others and their
        standard deviations. With draws (N, R) of readings instead: (B, R), None, None."""
        many = 1 if draws is None else draws.shape[1]
        f = len(fit.mean)
        fy, fd = np.zeros((f, many)), np.zeros((f, self.width))
        dy, dd = np.zeros((self.width, many)), np.zeros(len(self.pairs[0]))
        for k, (part, old) in enumerate(zip(self.parts, fit.parts, strict=True)):
            s2 = old.sigma2
            at = self.shared_at(k, fit.chosen)
            part.looked_at(old)
            words, beside = part.dictionary, part.beside(old)
            # Draws take the place of the readings: their products with the columns anew, all else
            # as it is.
            y_f, y_d = old.along[:, None], beside.yd[:, None]
            if draws is not None:
                white = part.unit.whitened(draws[part.unit.rows])
                hy = solved(old.root, (part.b.T @ white)[old.use] / s2)
                y_f = np.concatenate(
                    [part.z.T @ white, *(words.white(c).T @ white for c in old.shown)]
                )
                y_f = y_f / s2 - old.hf.T @ hy
                y_d = words.along(white) / s2 - part.half(old).T @ hy
            fy[at] += y_f
            dy[words.columns] += y_d
            fd[np.ix_(at, words.columns)] += beside.fd
            dd[words.pairs.number] += beside.dd
        if f:
            half_d, half_y = solved(fit.root, fd), solved(fit.root, fy)
            dy -= half_d.T @ half_y
            by_column = half_d.T
            # Of each block what the set says already is taken off, by the same step (Schur
            # complement): what is left tells its own coefficients, the set learned beside it.
            dd -= np.einsum("pf,pf->p", *(by_column[number] for number in self.pairs))
        tried = [k for k in range(len(self.blocks)) if k not in self.fixed]
        widths = np.array([self.blocks[k].width for k in tried], int)
        scores = np.full((len(self.blocks), many), -np.inf)
        scores[tried], coefficients, spread = factors(widths, self.slab, dy, dd)
        return (scores[:, 0], coefficients, spread) if draws is None else (scores, None, None)

    def beside(self, fit: Fit, columns: np.ndarray, but: int = -1) -> tuple[np.ndarray, np.ndarray]:
        """(K, K) X'PX and (K,) X'Py of columns X (N, K) that are not in the dictionary: all else of
        the fit taken out, but for one of its members."""
        found = [
            part.dictionary.products(
                np.take(columns.T, part.unit.rows, axis=1).T, old.shown, old.use
            )
            for part, old in zip(self.parts, fit.parts, strict=True)
        ]
        return self._beside(fit, found, columns.shape[1], but)

    def among(self, fit: Fit, numbers: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
        """The same of the columns of blocks of the dictionary, whose products are known."""
        width = [self.blocks[k].width for k in numbers]
        found = [
            part.dictionary.own_beside(numbers, width, old.shown)
            for part, old in zip(self.parts, fit.parts, strict=True)
        ]
        return self._beside(fit, found, sum(width))

    def _beside(
        self, fit: Fit, found: list[Products | None], many: int, but: int = -1
    ) -> tuple[np.ndarray, np.ndarray]:
        f, root = len(fit.mean), fit.root
        if but >= 0:
            root = self._root_without(fit, but)
        fy, fx, xx, xy = np.zeros(f), np.zeros((f, many)), np.zeros((many, many)), np.zeros(many)
        for k, (old, x) in enumerate(zip(fit.parts, found, strict=True)):
            at, s2 = self.shared_at(k, fit.chosen), old.sigma2
            fy[at] += old.along
            if x is None:
                continue
            self.parts[k].looked_at(old)
            hx = solved(old.root, x.own[old.use] / s2)
            fx[at] += x.shared / s2 - old.hf.T @ hx
            xx += x.within / s2 - hx.T @ hx
            xy += x.along / s2 - hx.T @ old.hy
        if f:
            half = solved(root, np.column_stack([fy, fx]))
            xx -= half[:, 1:].T @ half[:, 1:]
            xy -= half[:, 1:].T @ half[:, 0]
        return xx, xy

    def _root_without(self, fit: Fit, but: int) -> np.ndarray:
        """The root of a fit as if a member were of no size."""
        layout = self._layout(fit.chosen, fit.parts)
        a, _, _ = self._summed(layout, list(range(len(fit.parts))), fit.parts)
        own = np.array([fit.scale[k] for k in fit.chosen])[layout.of] * layout.slab
        # a prior so narrow that the member can not be but 0, in the place of a fit without it
        own[np.array(fit.chosen)[layout.of] == but] = NOTHING
        a[np.diag_indices(len(a))] += 1.0 / np.append(fit.shared[self.shared_of], own) ** 2
        return cholesky(a)
