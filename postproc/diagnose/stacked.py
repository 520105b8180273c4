"""The columns of the whole dictionary, and what of them need not be reckoned again while the noise stays what it is.

For a choice P = W - W U (..)^-1 U'W (see fit): U'W D and D'W D of the nuisances U and of every block's own columns D are the same
for every choice at one noise; only the few chosen columns come in anew.
"""

from __future__ import annotations

import numpy as np

from postproc.diagnose.fit import Projector


class Stack:
    """columns (K, N), a row for each column of a block; parts: which rows are whose."""

    def __init__(self, u: np.ndarray):
        self.u = u
        self.columns = np.zeros((0, len(u)))
        self.parts: list[slice] = []
        self._known: list[tuple[np.ndarray, np.ndarray, list[np.ndarray]]] = []

    def add(self, blocks: list[np.ndarray]) -> None:
        """More blocks, (N, K) each."""
        first = len(self.columns)
        self.columns = np.concatenate([self.columns, *(b.T for b in blocks)]) if blocks else self.columns
        for b in blocks:
            self.parts.append(slice(first, first + b.shape[1]))
            first += b.shape[1]

    def _under(self, sigma: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
        """(Q, K) U'W D, and D'W D of every block."""
        crossed, own = np.zeros((self.u.shape[1], 0)), []
        for known, before, products in self._known:
            if known is sigma:
                crossed, own = before, products
        if crossed.shape[1] < len(self.columns):
            new = self.columns[crossed.shape[1] :]
            crossed = np.concatenate([crossed, (self.u * w[:, None]).T @ new.T], axis=1)
            own = own + [(c * w) @ c.T for c in (self.columns[part] for part in self.parts[len(own) :])]
            self._known = [*[k for k in self._known if k[0] is not sigma][-2:], (sigma, crossed, own)]
        return crossed, own

    def after(
        self, p: Projector, sigma: np.ndarray, y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray]]:
        """(K, ...) D'P y; (K,) D'W D of each column alone; (K,) D'P D of each alone; (k, k) D'P D of every block. p: of the
        nuisances and of what was chosen beside them, at the noise sigma; y (N,) or (N, R)."""
        crossed, own = self._under(sigma, p.w)
        more = p.u[:, self.u.shape[1] :]
        if more.shape[1]:
            crossed = np.concatenate([crossed, (more * p.w[:, None]).T @ self.columns.T])
        inside = p.inner @ crossed
        weighted = y * (p.w if y.ndim == 1 else p.w[:, None])
        left = self.columns @ weighted - crossed.T @ (p.inner @ (p.u.T @ weighted))
        alone = np.concatenate([np.diag(a) for a in own]) if own else np.zeros(0)
        power = alone - np.einsum("ij,ij->j", crossed, inside)
        inner = [a - crossed[:, part].T @ inside[:, part] for a, part in zip(own, self.parts, strict=True)]
        return left, alone, power, inner
