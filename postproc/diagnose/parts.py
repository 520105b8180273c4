"""One instrument's readings, whitened, with the products that every set of effects asks for, and
its own columns taken out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri, dtrtrs

from postproc.diagnose.noise import Unit
from postproc.diagnose.nuisances import PROCESSES, Group

SURE = 1.0  # readings that a usual standard deviation counts as, when the readings' own is learned
MOST_WHITE = 6.0  # times the white noise that neighbours and repeats show: more is no noise
LEAST = 1e-3  # of a usual standard deviation


@dataclass
class Reduced:
    """One unit with its own columns taken out. shown: blocks of the set that show in it; kinds: of
    its processes; sigma2 (1: as its white noise was found), sd of each group; use (q,): own columns
    that count; root (q, q): Cholesky factor (lower) of 1/sd^2 + B'B/sigma2; hf (q, f), hy (q,):
    root^-1 B'F/sigma2, of y; inside (f, f), along (f,): F'C^-1F, F'C^-1y; value: its part of twice
    the log evidence; bf, ff, fy: products.
    hd, fd, dd: the same of the dictionary, when it was asked for."""

    shown: tuple[int, ...]
    kinds: frozenset[str]
    sigma2: float
    sd: np.ndarray
    use: np.ndarray
    root: np.ndarray
    hf: np.ndarray
    hy: np.ndarray
    inside: np.ndarray
    along: np.ndarray
    value: float
    bf: np.ndarray
    ff: np.ndarray
    fy: np.ndarray
    hd: np.ndarray | None = None
    fd: np.ndarray | None = None
    dd: np.ndarray | None = None


class Products(NamedTuple):
    """Of columns x (n, K), whitened, with what a unit has: own (q, K) with its own columns, shared
    (f, K) with those that it shares, within (K, K), along (K,) with its readings."""

    own: np.ndarray
    shared: np.ndarray
    within: np.ndarray
    along: np.ndarray


class Part:
    """What one unit contributes: its columns, whitened, and their products."""

    def __init__(
        self, whole: Unit, keep: np.ndarray, groups: list[Group], shared: np.ndarray, y: np.ndarray
    ):
        self.whole = whole
        unit = self.unit = whole.pick(keep)
        self.use = use = keep[whole.rows]
        self.groups = groups
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
        self.b = unit.whitened(b[use])
        self.z = unit.whitened(shared[unit.rows])
        self.y = unit.whitened(y[unit.rows])
        self.bb, self.by = self.b.T @ self.b, self.b.T @ self.y
        self.bz, self.zz, self.zy = self.b.T @ self.z, self.z.T @ self.z, self.z.T @ self.y
        self.yy = float(self.y @ self.y)
        self.d = np.zeros((len(unit), 0))
        self.columns = np.zeros(0, int)  # numbers of the dictionary's columns that show here
        self.bd, self.zd, self.dy = (
            np.zeros((len(b.T), 0)),
            np.zeros((self.z.shape[1], 0)),
            np.zeros(0),
        )
        self._crossed: dict[int, np.ndarray] = {}
        self._within: dict[tuple[int, ...], np.ndarray] = {}
        self.where: dict[int, slice] = {}  # block to its columns here
        self.processes = {
            kind: np.isin(self.of, [k for k, g in enumerate(groups) if g.kind == kind])
            for kind in PROCESSES
        }
        self.usually = ~np.any(list(self.processes.values()), axis=0)

    def add(self, numbers: list[int], blocks: list[np.ndarray], first: list[int]) -> None:
        """Blocks of the dictionary, (n, K) each, that show in this unit; first: number of the first
        column of each."""
        if not blocks:
            return
        new = self.unit.whitened(np.concatenate(blocks, axis=1))
        at = self.d.shape[1]
        cols = []
        for number, block, start in zip(numbers, blocks, first, strict=True):
            self.where[number] = slice(at, at + block.shape[1])
            cols.append(np.arange(start, start + block.shape[1]))
            at += block.shape[1]
        self.d = np.concatenate([self.d, new], axis=1)
        self.columns = np.concatenate([self.columns, *cols])
        self.bd = np.concatenate([self.bd, self.b.T @ new], axis=1)
        self.zd = np.concatenate([self.zd, self.z.T @ new], axis=1)
        self.dy = np.concatenate([self.dy, new.T @ self.y])

    def crossed(self, k: int) -> np.ndarray:
        """(w, K) products of a block's columns with all of the dictionary that show here."""
        known = self._crossed.get(k, np.zeros((self.where[k].stop - self.where[k].start, 0)))
        if known.shape[1] < self.d.shape[1]:
            new = self.d[:, self.where[k]].T @ self.d[:, known.shape[1] :]
            known = self._crossed[k] = np.concatenate([known, new], axis=1)
        return known

    def products(self, raw: np.ndarray, shown: tuple[int, ...]) -> Products | None:
        """Of columns raw (n, K) that are not in the dictionary; None: they do not show here."""
        if not raw.any():
            return None
        x = self.unit.whitened(raw)
        shared = [self.z.T @ x, *(self.d[:, self.where[c]].T @ x for c in shown)]
        return Products(self.b.T @ x, np.concatenate(shared), x.T @ x, x.T @ self.y)

    def own_beside(
        self, numbers: tuple[int, ...], width: list[int], shown: tuple[int, ...]
    ) -> Products | None:
        """The same of blocks of the dictionary, `width` columns each."""
        shows = [k in self.where for k in numbers]
        if not any(shows):
            return None
        here = np.repeat(shows, width)
        at = np.concatenate([np.r_[self.where[k]] for k in numbers if k in self.where])
        if numbers not in self._within:
            self._within[numbers] = self.d[:, at].T @ self.d[:, at]
        shared = np.concatenate([self.zd[:, at], *(self.crossed(c)[:, at] for c in shown)])
        own, many = len(self.by), len(here)
        empty = [np.zeros((n, many)) for n in (own, len(shared), many)]
        result = Products(empty[0], empty[1], empty[2], np.zeros(many))
        result.own[:, here], result.shared[:, here] = self.bd[:, at], shared
        result.within[np.ix_(here, here)] = self._within[numbers]
        result.along[here] = self.dy[at]
        return result

    def own_products(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """(P,) products of pairs of own columns of the dictionary."""
        own_products: np.ndarray = np.einsum("np,np->p", self.d[:, first], self.d[:, second])
        return own_products

    def reduced(
        self, shown: tuple[int, ...], sigma2: float, sd: np.ndarray, kinds: frozenset[str]
    ) -> Reduced:
        """The unit with its own columns taken out; shown: blocks that show in it; kinds: of its
        processes."""
        z = len(self.zy)
        at = (
            np.concatenate([np.arange(self.where[c].start, self.where[c].stop) for c in shown])
            if shown
            else np.zeros(0, int)
        )
        f = z + len(at)
        bf, fy, ff = np.empty((len(self.by), f)), np.empty(f), np.empty((f, f))
        bf[:, :z], fy[:z], ff[:z, :z] = self.bz, self.zy, self.zz
        if len(at):
            own = self.d[:, at]
            bf[:, z:], fy[z:] = self.bd[:, at], self.dy[at]
            ff[:z, z:] = self.zd[:, at]
            ff[z:, :z], ff[z:, z:] = ff[:z, z:].T, own.T @ own
        counts = self.usually
        for kind in kinds:
            counts = counts | self.processes[kind]
        use = np.flatnonzero(counts)
        m = self.bb[np.ix_(use, use)] / sigma2
        m[np.diag_indices(len(use))] += 1.0 / sd[self.of[use]] ** 2
        root = cholesky(m)
        half = solved(root, np.column_stack([bf[use], self.by[use]]) / sigma2)
        hf, hy = half[:, :-1], half[:, -1]
        value = -len(self.y) * np.log(sigma2) - self.yy / sigma2 + float(hy @ hy)
        value -= 2.0 * float(np.log(np.diag(root)).sum() + np.log(sd[self.of[use]]).sum())
        groups = np.unique(self.of[use])
        groups = groups[self.learned[groups]]
        value -= float(
            np.sum(
                surprise(sd[groups], self.usual[groups]) + (2 * sd[groups] / self.most[groups]) ** 2
            )
        ) + float(surprise(np.sqrt(sigma2), 1.0))
        value -= float(sigma2) * (2 / MOST_WHITE) ** 2
        return Reduced(
            shown,
            kinds,
            sigma2,
            sd,
            use,
            root,
            hf,
            hy,
            ff / sigma2 - hf.T @ hf,
            fy / sigma2 - hf.T @ hy,
            value,
            bf,
            ff,
            fy,
        )

    def renewed(
        self, old: Reduced, mean: np.ndarray, covariance: np.ndarray, least: float
    ) -> tuple[float, np.ndarray]:
        """Its variance and standard deviations, by MacKay's fixed point. mean, covariance: of its
        shared coefficients."""
        use, sd = old.use, old.sd.copy()
        inverse = inverted(old.root)
        own = inverse.T @ (old.hy - old.hf @ mean)
        along = inverse.T @ old.hf
        spread = (inverse**2).sum(axis=0) + ((along @ covariance) * along).sum(axis=1)
        of, left = self.of[use], 0.0
        for g in np.unique(of):
            which = of == g
            dof = max(int(which.sum()) - float(spread[which].sum()) / old.sd[g] ** 2, 0.0)
            left += dof
            if self.learned[g]:
                usual = self.usual[g]
                now = _size(float((own[which] ** 2).sum()), dof, usual, self.most[g])
                sd[g] = float(np.clip(now, LEAST * usual, self.most[g]))
        left += float(np.sum(covariance * old.inside))
        e = (
            self.yy
            - 2 * (own @ self.by[use] + mean @ old.fy)
            + own @ (self.bb[np.ix_(use, use)] @ own)
        )
        e += 2 * own @ (old.bf[use] @ mean) + mean @ old.ff @ mean
        return float(np.clip((e + SURE) / max(len(self.y) - left + SURE, 1.0), least, 1e4)), sd


def _size(power: float, dof: float, usual: float, most: float) -> float:
    """The most probable standard deviation of dof coefficients whose squares sum to power: where
    its prior density is inverse gamma at small sizes and normal at large ones, with half of `most`
    for its standard deviation."""
    a, b, c = 4 / most**2, dof + SURE, power + SURE * usual**2
    return float(np.sqrt((np.sqrt(b * b + 4 * a * c) - b) / (2 * a)))


def factor(within: np.ndarray, along: np.ndarray, slab: np.ndarray, scale: float) -> float:
    """Twice the logarithm of the Bayes factor of columns with products within (w, w) and along (w,)
    whose coefficients have the standard deviations slab (w,) times scale."""
    sd = scale * slab
    a = within * np.outer(sd, sd) + np.eye(len(sd))
    gain = float(along * sd @ np.linalg.solve(a, along * sd))
    return gain - float(np.linalg.slogdet(a)[1]) - float(surprise(scale, 1.0))


def surprise(sd: np.ndarray | float, usual: np.ndarray | float) -> Any:
    """Minus twice the logarithm of the prior density of a learned standard deviation, but for a
    constant (inverse gamma)."""
    ratio = (np.asarray(usual) / np.asarray(sd)) ** 2
    return SURE * (ratio - np.log(ratio) - 1.0)


def cholesky(m: np.ndarray) -> np.ndarray:
    """The lower Cholesky factor."""
    if not len(m):
        return m
    root: np.ndarray
    root, info = dpotrf(m, lower=1, clean=1)
    if info:
        root, info = dpotrf(m + 1e-10 * np.diag(np.diag(m)), lower=1, clean=1)
    if info:
        raise np.linalg.LinAlgError(f"the {info}. leading minor is not positive")
    return root


def solved(root: np.ndarray, b: np.ndarray) -> np.ndarray:
    return dtrtrs(root, b, lower=1)[0] if len(root) and b.size else b


def inverted(root: np.ndarray) -> np.ndarray:
    return dtrtri(root, lower=1)[0] if len(root) else root
