"""Weighted least squares in which the nuisances are known by their size only: set-up zeros, centres, the map's own error.

With W = 1 / sigma^2 and nuisance columns U of prior variance L, P = W - W U (1/L + U'W U)^-1 U'W; a block of columns D is
worth b' A^-1 b with b = D'P y, A = D'P D: the fall of chi squared if it were let in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postproc.diagnose import wander
from postproc.diagnose.rows import XYZ, Rows
from postproc.effects import legendre

SAME = 1e-7  # of a column's power: what is left of one that says the same as others
FREE = 1e3  # mm: a zero that nobody knows
MAP_UM = 0.3  # um: by how much each smooth term of a measured map is usually wrong (design of the experiment: 0.25 um)
TOLD, FEWEST_TERMS, WORSE, MOST_WORSE = 0.3, 8, 1.25, 4.0
DEGREES = range(1, 7)
CENTRE = 0.1  # mm
BAR = 0.01  # mm: by how much a bar may grow while it turns
PART = 5e-4  # mm
STYLUS = 3e-4  # mm: what a measuring machine's stylus, set at a reference sphere, is off by at every wall (unverified: a usual figure)
ALIGNED = 0.1  # rad: how the line of a straightness optic may lie, nobody knows
FEATURE = 5e-4  # mm: of a feature's own, beside what the map is off by at its two places (unverified)
WALK = 5e-4  # mm: by how much the zero of a laser or a probe wanders during a run
WALK_RAD = 5e-7  # rad: the same of an angle
SQUARE = 1.5e-6  # rad


def nuisances(rows: Rows, map_um: float = MAP_UM) -> tuple[np.ndarray, np.ndarray]:
    """(N, Q) columns and (Q,) prior standard deviations."""
    columns: list[np.ndarray] = []
    size: list[float] = []

    def add(column: np.ndarray, sd: float) -> None:
        if np.abs(column).max(initial=0.0) > 0:
            columns.append(column)
            size.append(sd)

    seen = np.isin(rows.sees, ("laser", "tool"))
    for signal in range(len(rows.signals)):
        which = rows.signal == signal
        # A feature has no set-up zero of its own, only what the map does not know at its place; a step has none that is known.
        placed = bool(np.all(rows.sees[which] == "part")) and "step" not in rows.signals[signal]
        add(which.astype(float), FEATURE if placed else FREE)
    for file, kind in enumerate(rows.kinds):
        if kind == "ballbar":
            for i in range(3):
                add(np.where(rows.file == file, rows.direction[:, i], 0.0), CENTRE)
            own = rows.file == file  # the bar warms in the hand and on the machine
            t = rows.state.time[own]
            share = 2 * (t - t.min()) / max(float(np.ptp(t)), 1e-9) - 1
            for degree in (1, 2, 3):
                longer = np.zeros(len(rows))
                longer[own] = legendre(share, degree)
                add(longer, BAR)
    for file, kind in enumerate(rows.kinds):
        if kind != "targets":
            continue
        own = rows.file == file
        usual = WALK_RAD if rows.sees[own][:1] == "angle" else WALK
        walk = wander.of_runs(rows.residual[own], rows.run[own], _places(rows, own), usual)
        for run in np.unique(rows.run[own]):  # an instrument's zero wanders
            which = own & (rows.run == run)
            if which.sum() >= 4:
                late = np.zeros(len(rows))
                late[which] = _share(rows.state.time[which]) / 2
                add(which.astype(float), walk)
                add(late, walk)
    for file, kind in enumerate(rows.kinds):
        if kind != "targets":
            continue
        straight = (rows.file == file) & (rows.sees == "tool")
        for p in rows.state.position.values():  # a straightness reading knows its line up to the optics' alignment
            if straight.any() and np.ptp(p[straight]) > 1e-3:
                add(np.where(straight, p - p[straight].mean(), 0.0), ALIGNED)
    part = rows.sees == "part"
    for file, kind in enumerate(rows.kinds):
        if kind == "features":
            add(np.where(part & (rows.file == file), rows.state.channels.get("wall", np.ones(len(rows))), 0.0), STYLUS)
    for number in np.unique(rows.run[part]):  # every part lies a little differently in its fixture
        for i in range(3):
            add(
                np.where(
                    part & (rows.run == number),
                    rows.direction[:, i] * rows.state.channels.get("wall", np.ones(len(rows))),
                    0.0,
                ),
                PART,
            )
    for x, _ in rows.state.position.items():
        u = np.clip(rows.state.share(x), -1.2, 1.2)
        for along in range(3):
            enters = np.where(seen, rows.direction[:, along], 0.0)
            for degree in DEGREES:
                if along == XYZ.index(x) or degree > 1:
                    shape = enters * legendre(u, degree)
                    if along == XYZ.index(x):  # features see the same map, at the two places of their walls
                        shape = shape + np.where(part, rows.direction[:, along], 0.0) * _between(rows, x, degree)
                    add(shape, map_um * 1e-3)
            if along != XYZ.index(x):
                add(enters * rows.state.position[x], SQUARE)
    return np.stack(columns, axis=1), np.array(size)


def set_ups(u: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """(N, M) orthonormal columns of the zeros that nobody knows beforehand."""
    q, r = np.linalg.qr(u[:, prior >= FREE])
    size = np.abs(np.diag(r))
    return q[:, size > 1e-9 * size.max(initial=0.0)]


def _between(rows: Rows, axis: str, degree: int) -> np.ndarray:
    """(N,) difference of a smooth term of the map at the two walls of features; of a diameter on a lathe, at its radius."""
    here = legendre(np.clip(rows.state.share(axis), -1.2, 1.2), degree)
    if axis not in rows.other:
        return here
    low, high = rows.state.travel[axis]
    other = rows.other[axis]
    there = legendre(np.clip(2 * (np.nan_to_num(other) - low) / (high - low) - 1, -1.2, 1.2), degree)
    return here - np.where(np.isnan(other), 0.0, there)


def _share(t: np.ndarray) -> np.ndarray:
    """(N,) -1 to 1 from the first of these times to the last; times that were not recorded: in the order of rows."""
    t = t if np.ptp(t) > 0 else np.arange(len(t), dtype=float)
    return 2 * (t - t.mean()) / max(float(np.ptp(t)), 1e-9)


def _places(rows: Rows, own: np.ndarray) -> np.ndarray:
    """(N,) number of the target at which each of these rows was read."""
    columns = [np.round(p[own], 3) for p in rows.state.position.values()]
    columns += [np.sign(s[own]) for s in rows.state.approach.values()]
    return np.unique(np.stack(columns), axis=1, return_inverse=True)[1].ravel()


@dataclass
class Projector:
    """What is left of columns when the nuisances, and what was chosen before, are taken out. w (N,) 1/sigma^2; u (N, Q);
    inner (Q, Q) the inverse in P."""

    w: np.ndarray
    u: np.ndarray
    inner: np.ndarray

    @staticmethod
    def of(sigma: np.ndarray, u: np.ndarray, prior: np.ndarray) -> Projector:
        w = 1.0 / sigma**2
        inner = np.diag(1.0 / prior**2) + (u * w[:, None]).T @ u
        return Projector(w, u, np.linalg.inv(inner))

    def __call__(self, columns: np.ndarray) -> np.ndarray:
        """P D for (N,) or (N, K)."""
        weighted = columns * (self.w if columns.ndim == 1 else self.w[:, None])
        return weighted - (self.u * self.w[:, None]) @ (self.inner @ (self.u.T @ weighted))

    def chi2(self, y: np.ndarray) -> float:
        return float(y @ self(y))

    def nuisance(self, y: np.ndarray) -> np.ndarray:
        """(N,) the nuisances' own part of y."""
        return self.u @ (self.inner @ (self.u.T @ (self.w * y)))


def map_worse(u: np.ndarray, prior: np.ndarray, sigma: np.ndarray, y: np.ndarray) -> float:
    """By how much the map is worse than maps usually are, 1 where nothing speaks for it: the spread of all its terms that these
    readings (y, (N,) mm) tell. By their median, since an effect that is left out makes a few of them large."""
    terms = np.flatnonzero(prior == MAP_UM * 1e-3)
    p = Projector.of(sigma, u, prior)
    told = prior[terms] ** 2 - np.diag(p.inner)[terms]
    sure = told > TOLD * prior[terms] ** 2
    if sure.sum() < FEWEST_TERMS:
        return 1.0
    found = (p.inner @ (u.T @ (p.w * y)))[terms][sure] / np.sqrt(told[sure])
    spread = float(np.median(np.abs(found))) * 1.4826
    return min(spread, MOST_WORSE) if spread > WORSE else 1.0


def solve(projector: Projector, columns: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K,) coefficients and (K, K) covariance of columns (N, K)."""
    after = projector(columns)
    covariance = inverse(columns.T @ after, np.einsum("ij,ij,i->j", columns, columns, projector.w), SAME)
    return covariance @ (after.T @ y), covariance


def inverse(a: np.ndarray, own: np.ndarray, least: float) -> np.ndarray:
    """(K, K) inverse of D'P D without the directions of which less than that share of the columns' own power, (K,) D'W D, is left:
    there is nothing but the rounding of numbers in them."""
    size = np.sqrt(np.maximum(own, 1e-30))
    power, way = np.linalg.eigh(a / np.outer(size, size))
    keep = power > least
    return (way[:, keep] / power[keep]) @ way[:, keep].T / np.outer(size, size)
