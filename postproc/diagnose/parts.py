"""One instrument's readings, whitened, with the products that every set of effects asks for, and
its own columns taken out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri, dtrtrs

from postproc.diagnose.dictionary import Dictionary
from postproc.diagnose.noise import Unit
from postproc.diagnose.nuisances import PROCESSES, Group

SURE = 1.0  # readings that a usual standard deviation counts as, when the readings' own is learned
MOST_WHITE = 6.0  # times the white noise that neighbours and repeats show: more is no noise
LEAST = 1e-3  # of a usual standard deviation
RECENT = 4  # sets whose products with the dictionary are kept: few are asked for later again
WHOLE = 12  # sets whose factors are kept


@dataclass(frozen=True)
class Counted:
    """The own columns B of a unit that count. kinds: of its processes; use (q,): their numbers; of
    (q,): group of each; learned: groups of them whose size is learned; bb (q, q): B'B, whitened."""

    kinds: frozenset[str]
    use: np.ndarray
    of: np.ndarray
    learned: np.ndarray
    bb: np.ndarray

    def root(self, sigma2: float, sd: np.ndarray) -> np.ndarray:
        """(q, q): Cholesky factor (lower) of 1/sd^2 + B'B/sigma2; sd: of each group."""
        m = self.bb / sigma2
        m[np.diag_indices(len(self.of))] += 1.0 / sd[self.of] ** 2
        return cholesky(m)


@dataclass(frozen=True)
class Asked:
    """What one unit is asked for a set: the products that its sizes do not change. shown: blocks of
    the set that show in it; own: its own columns B; right (q, f + 1), ff (f, f), fy (f,): B'F and
    B'y behind each other, F'F and F'y, of the shared columns F and the readings y, whitened."""

    shown: tuple[int, ...]
    own: Counted
    right: np.ndarray
    ff: np.ndarray
    fy: np.ndarray


@dataclass(eq=False)  # one is not another: what is kept of it is found by itself
class Reduced:
    """One unit with its own columns taken out. asked: of which set; sigma2 (1: as its white noise
    was found), sd of each group; inside (f, f), along (f,): F'C^-1F, F'C^-1y; value: its part of
    twice the log evidence."""

    asked: Asked
    sigma2: float
    sd: np.ndarray
    inside: np.ndarray
    along: np.ndarray
    value: float

    @cached_property
    def root(self) -> np.ndarray:
        """(q, q): Cholesky factor of its own columns' precision."""
        return self.asked.own.root(self.sigma2, self.sd)

    @cached_property
    def half(self) -> np.ndarray:
        """(q, f + 1): root^-1 B'F/sigma2, and of y."""
        return solved(self.root, self.asked.right / self.sigma2)

    @property
    def hf(self) -> np.ndarray:
        """(q, f): of the shared columns."""
        return self.half[:, :-1]

    @property
    def hy(self) -> np.ndarray:
        """(q,): of the readings."""
        return self.half[:, -1]

    def let_go(self) -> None:
        """Forget what is made again in no time: of most sets it is not asked again."""
        for name in ("root", "half"):
            self.__dict__.pop(name, None)

    @property
    def shown(self) -> tuple[int, ...]:
        return self.asked.shown

    @property
    def use(self) -> np.ndarray:
        """(q,) numbers of the own columns that count."""
        return self.asked.own.use


class Beside(NamedTuple):
    """The dictionary's columns D beside a unit as a set has it: fd (f, K) F'C^-1D, yd (K,) y'C^-1D,
    dd (P,) D'C^-1D of pairs of columns of one block."""

    fd: np.ndarray
    yd: np.ndarray
    dd: np.ndarray


class Part:
    """What one unit contributes: its columns, whitened, and their products."""

    def __init__(
        self, whole: Unit, keep: np.ndarray, groups: list[Group], shared: np.ndarray, y: np.ndarray
    ):
        self.whole = whole
        unit = self.unit = whole.pick(keep)
        self.use = use = keep[whole.rows]
        self.kinds = [g.kind for g in groups]
        width = [g.columns.shape[1] for g in groups]
        self.of = np.repeat(np.arange(len(groups)), width)
        self.usual = np.array([g.sd for g in groups])
        self.learned = np.array([g.learned for g in groups], bool)
        self.most = np.array([g.most for g in groups])
        b = (
            np.concatenate([g.columns for g in groups], axis=1)
            if groups
            else np.zeros((len(unit), 0))
        )
        self.raw = b
        edges = np.cumsum([0, *width])
        self.groups = [  # a part of the whole, not a second copy
            replace(g, columns=b[:, i:j]) for g, (i, j) in zip(groups, pairwise(edges), strict=True)
        ]
        self.b = unit.whitened(b if use.all() else b[use])
        mine = shared[unit.rows]
        self.shows = np.flatnonzero(mine.any(axis=0))  # of the shared columns
        self.z = unit.whitened(mine[:, self.shows])
        self.y = unit.whitened(y[unit.rows])
        self.bb, self.by = self.b.T @ self.b, self.b.T @ self.y
        self.bz, self.zz, self.zy = self.b.T @ self.z, self.z.T @ self.z, self.z.T @ self.y
        self.yy = float(self.y @ self.y)
        self.dictionary = Dictionary(unit, self.b, self.z, self.y)
        self.processes = {
            kind: np.isin(self.of, [k for k, g in enumerate(groups) if g.kind == kind])
            for kind in PROCESSES
        }
        self.usually = ~np.any(list(self.processes.values()), axis=0)
        self._counted: dict[frozenset[str], Counted] = {}
        self._beside: dict[Reduced, Beside] = {}  # the last ones, the last one last
        self._whole: dict[Reduced, None] = {}  # those of which root and half are kept, as well
        self._asked: WeakValueDictionary[tuple[object, ...], Asked] = WeakValueDictionary()

    def counted(self, kinds: frozenset[str]) -> Counted:
        """Its own columns with those of some kinds of processes."""
        if kinds not in self._counted:
            counts = self.usually
            for kind in kinds:
                counts = counts | self.processes[kind]
            use = np.flatnonzero(counts)
            of = self.of[use]
            groups = np.flatnonzero(np.bincount(of))
            learned = groups[self.learned[groups]]
            self._counted[kinds] = Counted(kinds, use, of, learned, self.bb[np.ix_(use, use)])
        return self._counted[kinds]

    def asked(self, shown: tuple[int, ...], kinds: frozenset[str]) -> Asked:
        """The products of a set; shown: blocks that show in this unit; kinds: of its processes."""
        known = self._asked.get((shown, kinds))
        if known is None:
            known = self._asked[shown, kinds] = self._products(shown, kinds)
        return known

    def _products(self, shown: tuple[int, ...], kinds: frozenset[str]) -> Asked:
        own, words = self.counted(kinds), self.dictionary
        use, z, kept = own.use, len(self.zy), words.kept(shown)
        f = z + len(kept.dy)
        right = np.empty((len(use), f + 1), order="F")
        right[:, :z], right[:, z:-1], right[:, -1] = self.bz[use], kept.bd[use], self.by[use]
        ff = np.empty((f, f))
        ff[:z, :z], ff[:z, z:], ff[z:, z:] = self.zz, kept.zd, words.within(shown)
        ff[z:, :z] = ff[:z, z:].T
        return Asked(shown, own, right, ff, np.concatenate([self.zy, kept.dy]))

    def reduced(self, asked: Asked, sigma2: float, sd: np.ndarray) -> Reduced:
        """The unit with its own columns taken out, at these sizes."""
        own, root = sd[asked.own.of], asked.own.root(sigma2, sd)
        # y = F c + B b + e with b of mean zero and deviations sd, integrated out (Woodbury):
        #     C^-1 = 1/s2 - B M^-1 B' / s2^2,   M = B'B / s2 + sd^-2 = root root',
        # so that with half = root^-1 B' [F y] / s2 each product X'C^-1Y is X'Y / s2 - half_X'
        # half_Y, and log det C = n log s2 + log det M + log det sd^2.
        half = solved(root, asked.right / sigma2)
        hf, hy = half[:, :-1], half[:, -1]
        value = -len(self.y) * np.log(sigma2) - self.yy / sigma2 + float(hy @ hy)
        value -= 2.0 * float(np.log(root.diagonal()).sum() + np.log(own).sum())
        free = asked.own.learned
        value -= float(
            np.sum(surprise(sd[free], self.usual[free]) + (2 * sd[free] / self.most[free]) ** 2)
        ) + float(surprise(np.sqrt(sigma2), 1.0))
        value -= float(sigma2) * (2 / MOST_WHITE) ** 2
        inside, along = asked.ff / sigma2 - hf.T @ hf, asked.fy / sigma2 - hf.T @ hy
        result = Reduced(asked, sigma2, sd, inside, along, value)
        result.root, result.half = root, half
        return result

    def looked_at(self, old: Reduced) -> None:
        """Keep what is made of a unit as a set has it, and forget that of others."""
        self._whole.pop(old, None)
        self._whole[old] = None
        if len(self._whole) > WHOLE:
            first = next(iter(self._whole))
            del self._whole[first]
            first.let_go()

    def beside(self, old: Reduced) -> Beside:
        """All of the dictionary that shows here beside the unit as a set has it."""
        words, s2, nothing = self.dictionary, old.sigma2, np.zeros(0)
        done = self._beside.pop(old, Beside(np.zeros((len(old.along), 0)), nothing, nothing))
        known = len(done.yd)
        if known < len(words.columns):
            new = self.half(old, known)
            crossed = [words.zd[:, known:], *(words.crossed(c)[:, known:] for c in old.shown)]
            fd = np.concatenate(crossed) / s2 - old.hf.T @ new
            yd = words.dy[known:] / s2 - new.T @ old.hy
            _, i, j, own = (column[len(done.dd) :] for column in words.pairs)
            by_column = new.T
            inside = np.einsum("pq,pq->p", by_column[i - known], by_column[j - known])
            done = Beside(
                np.concatenate([done.fd, fd], axis=1),
                np.append(done.yd, yd),
                np.append(done.dd, own / s2 - inside),
            )
        self._beside[old] = done
        if len(self._beside) > RECENT:
            del self._beside[next(iter(self._beside))]
        return done

    def half(self, old: Reduced, known: int = 0) -> np.ndarray:
        """(q, K): root^-1 B'D/sigma2 of the columns D of the dictionary behind the known ones."""
        return solved(old.root, self.dictionary.bd[:, known:][old.use] / old.sigma2)

    def renewed(
        self, old: Reduced, mean: np.ndarray, covariance: np.ndarray, least: float
    ) -> tuple[float, np.ndarray]:
        """Its variance and standard deviations, by MacKay's fixed point. mean, covariance: of its
        shared coefficients."""
        asked, counted, sd = old.asked, old.asked.own, old.sd.copy()
        # Mean of its own coefficients b, given the shared ones c at their mean: M b = B'(y - F c) /
        # s2. Their spread has two parts: M^-1 with c known, and what c itself may be off by (law of
        # total variance).
        inverse = inverted(old.root)
        own = inverse.T @ (old.hy - old.hf @ mean)
        along = inverse.T @ old.hf
        spread = np.einsum("ij,ij->j", inverse, inverse)
        spread += np.einsum("ij,ij->i", along @ covariance, along)
        many = len(self.groups)
        # As in the shared ones (Evidence._renewed_shared): so many coefficients are determined by
        # readings.
        of_group = np.bincount(counted.of, spread, many) / old.sd**2
        dof = np.maximum(np.bincount(counted.of, minlength=many) - of_group, 0.0)
        power, free = np.bincount(counted.of, own**2, many), counted.learned
        usual, most = self.usual[free], self.most[free]
        now = _size(power[free], dof[free], usual, most)
        sd[free] = np.clip(now, LEAST * usual, most)
        left = float(dof.sum()) + float(np.einsum("ij,ij->", covariance, old.inside))
        # The square of y - F c - B b written out in the products that are kept: n, thousands, does
        # not enter. right is B'[F y], so its product with (c, -1) is B'(F c - y).
        e = self.yy - 2 * mean @ asked.fy + own @ (counted.bb @ own) + mean @ (asked.ff @ mean)
        e += 2 * own @ (asked.right @ np.append(mean, -1.0))
        return float(np.clip((e + SURE) / max(len(self.y) - left + SURE, 1.0), least, 1e4)), sd


def _size(power: np.ndarray, dof: np.ndarray, usual: np.ndarray, most: np.ndarray) -> np.ndarray:
    """The most probable standard deviation of dof coefficients whose squares sum to power: where
    its prior density is inverse gamma at small sizes and normal at large ones, with half of `most`
    for its standard deviation."""
    a, b, c = 4 / most**2, dof + SURE, power + SURE * usual**2
    return np.asarray(np.sqrt((np.sqrt(b * b + 4 * a * c) - b) / (2 * a)))


def surprise(sd: np.ndarray | float, usual: np.ndarray | float) -> Any:
    """Minus twice the logarithm of the prior density of a learned standard deviation, but for a
    constant (inverse gamma)."""
    ratio = (np.asarray(usual) / np.asarray(sd)) ** 2
    return SURE * (ratio - np.log(ratio) - 1.0)


def cholesky(m: np.ndarray) -> np.ndarray:
    """The lower Cholesky factor."""
    if not len(m):
        return m
    root, info = dpotrf(m.T, lower=1, clean=1)  # symmetric: as it lies in the memory
    if info:
        # Columns that are nearly alike may make it indefinite by rounding: 1e-10 of the diagonal is
        # far below what readings tell.
        root, info = dpotrf(m + 1e-10 * np.diag(np.diag(m)), lower=1, clean=1)
    if info:
        raise np.linalg.LinAlgError(f"the {info}. leading minor is not positive")
    return np.asarray(root)


def solved(root: np.ndarray, b: np.ndarray) -> np.ndarray:
    """root^-1 b, of a lower triangle (q, q) and b (q, K)."""
    return dtrtrs(root, b, lower=1)[0] if len(root) and b.size else b


def solved_back(root: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of the transposed root."""
    return dtrtrs(root, b, lower=1, trans=1)[0] if len(root) and b.size else b


def inverted(root: np.ndarray) -> np.ndarray:
    """root^-1 (q, q), a lower triangle."""
    return dtrtri(root, lower=1)[0] if len(root) else root
