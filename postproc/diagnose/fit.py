"""Weighted least squares in which the nuisances are known by their size only.

With W = 1 / sigma^2 and nuisance columns U of prior variance L, P = W - W U (1/L + U'W U)^-1 U'W is
what is left of W when the nuisances are taken out. For a first look (locate); names are chosen by
their evidence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Projector:
    """What is left of columns when the nuisances, and what was chosen before, are taken out. w (N,)
    1/sigma^2; u (N, Q); inner (Q, Q) the inverse in P."""

    w: np.ndarray
    u: np.ndarray
    inner: np.ndarray

    @staticmethod
    def of(sigma: np.ndarray, u: np.ndarray, prior: np.ndarray) -> Projector:
        w = 1.0 / sigma**2
        # Woodbury's identity: P is the inverse of sigma^2 + U L U', with a (Q, Q) matrix in the
        # place of an (N, N) one.
        inner = np.diag(1.0 / prior**2) + (u * w[:, None]).T @ u
        return Projector(w, u, np.linalg.inv(inner))

    def __call__(self, columns: np.ndarray) -> np.ndarray:
        """P D for (N,) or (N, K)."""
        w = self.w if columns.ndim == 1 else self.w[:, None]
        # Never P itself: two thin products, with U' and with U.
        result: np.ndarray = columns * w
        result -= w * (self.u @ (self.inner @ (self.u.T @ result)))
        return result

    def nuisance(self, y: np.ndarray) -> np.ndarray:
        """(N,) the nuisances' own part of y."""
        # inner U'W y is the mean of the coefficients given y, where y held nothing but nuisances
        # and noise
        nuisance: np.ndarray = self.u @ (self.inner @ (self.u.T @ (self.w * y)))
        return nuisance
