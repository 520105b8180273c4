"""Least squares over all readings at once: the unknown errors, what belongs to the set-ups, and the covariance of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from postproc.machine.chain import XYZ
from postproc.units import UM
from postproc.volumetric import VolumetricError
from postproc.volumetric.observations import Rows, angle_columns, nominal_tip, to_machine, unit_of
from postproc.volumetric.unknowns import Group, Unknowns

FIRST = 1.0  # um or urad: of readings that state none, until their own scatter is known
ROUNDS = 4


@dataclass(frozen=True)
class Fit:
    """numbers (P,), covariance (P, P): of the unknowns; rows with their u; left: residuals of each, mm or rad; chi: square of the
    residuals in units of u per degree of freedom; free: that number."""

    unknowns: Unknowns
    numbers: np.ndarray
    covariance: np.ndarray
    rows: tuple[Rows, ...]
    left: tuple[np.ndarray, ...]
    chi: float
    free: int
    widened: bool = False

    def values(self, group: Group) -> tuple[np.ndarray, np.ndarray]:
        """(K,) at its nodes (or the one number), and (K,) their standard uncertainty; mm or rad."""
        where = self.unknowns.slices[self.unknowns.groups.index(group)]
        u = np.sqrt(
            np.maximum(
                np.einsum("km,mn,kn->k", group.basis, self.covariance[where, where], group.basis),
                0.0,
            )
        )
        return group.basis @ self.numbers[where], u

    def at(
        self, q: np.ndarray, approach: np.ndarray, tool: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """(3, N) mm deviation of the tip by what was found, and (3, N) its standard uncertainty, covariances and all."""
        columns = self.unknowns.columns(q, approach, tool)
        off = np.einsum("p,pin->in", self.numbers, columns)
        return off, np.sqrt(
            np.maximum(np.einsum("pin,pr,rin->in", columns, self.covariance, columns), 0.0)
        )


def fit(rows: Sequence[Rows], unknowns: Unknowns) -> Fit:
    """Raises VolumetricError where there are fewer readings than unknowns of the set-ups alone."""
    own = sum(len(r.start) for r in rows)
    number = sum(map(len, rows))
    if number <= own:
        raise VolumetricError(
            f"{number} readings, and the set-ups alone have {own} unknowns",
            "more readings in each set-up",
        )
    said = [not np.isnan(r.u) for r in rows]
    rows = [r if s else replace(r, u=FIRST * unit_of(r)) for r, s in zip(rows, said, strict=True)]
    fixed = [_Fixed.of(r, unknowns) for r in rows]
    start = np.concatenate([np.zeros(unknowns.number), *(r.start for r in rows)])
    for _ in range(1 if all(said) else ROUNDS):
        x, jacobian, residual = _solved(rows, fixed, unknowns, start)
        parts = np.split(residual[:number], np.cumsum([len(r) for r in rows])[:-1])
        again = []
        for r, s, part in zip(rows, said, parts, strict=True):
            taken = _leverage(jacobian, rows, r)
            u = r.u if s else r.u * float(np.sqrt((part @ part) / max(len(r) - taken, 1.0)))
            again.append(replace(r, u=max(u, 1e-6 * UM)))
        if all(said):
            break
        rows, start = again, x
    free = max(number - own - round(_leverage_all(jacobian, unknowns, number)), 1)
    data = residual[:number]
    chi = float(data @ data) / free
    covariance = np.linalg.inv(jacobian.T @ jacobian)[: unknowns.number, : unknowns.number]
    # Readings that scatter more than they say: what was found is known as much worse.
    widened = all(said) and chi > 1 + 3 * np.sqrt(2 / free)
    if widened:
        covariance = covariance * chi
    left = tuple(part * r.u for part, r in zip(parts, rows, strict=True))
    return Fit(unknowns, x[: unknowns.number], covariance, tuple(rows), left, chi, free, widened)


@dataclass(frozen=True)
class _Fixed:
    """What of a set-up does not change while the unknowns do: columns (P, 3, N), angles (P, N), nominal and known (3, N) mm."""

    columns: np.ndarray
    angles: np.ndarray
    nominal: np.ndarray
    known: np.ndarray

    @classmethod
    def of(cls, r: Rows, unknowns: Unknowns) -> _Fixed:
        columns, known = (
            unknowns.columns(r.q, r.approach, r.tool),
            unknowns.already(r.q, r.approach, r.tool),
        )
        if r.kind == "shift" and unknowns.bare.chain.rotary:
            turn = to_machine(unknowns.bare, r.q)
            columns, known = (
                np.einsum("ijn,pjn->pin", turn, columns),
                np.einsum("ijn,jn->in", turn, known),
            )
        return cls(
            columns, angle_columns(unknowns, r), nominal_tip(unknowns.bare, r.q, r.tool), known
        )


def _solved(
    rows, fixed: list[_Fixed], unknowns: Unknowns, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers and nuisances, and Jacobian and residuals there, in units of u; the prior stands below."""
    p = unknowns.number
    edges = p + np.cumsum([0, *(len(r.start) for r in rows)])
    stated = np.concatenate([r.start for r in rows])
    loose = np.concatenate([r.loose if len(r.loose) else np.zeros(len(r.start)) for r in rows])

    def residual(x: np.ndarray) -> np.ndarray:
        found = []
        for k, (r, f) in enumerate(zip(rows, fixed, strict=True)):
            off = f.known + np.einsum("p,pin->in", x[:p], f.columns)
            angle = x[:p] @ f.angles if f.angles.shape[1] else np.zeros(r.q.shape[1])
            found.append(r.residual(off, x[edges[k] : edges[k + 1]], f.nominal, angle) / r.u)
        return np.concatenate([*found, x[:p] / unknowns.prior, (x[p:] - stated) * loose])

    def jacobian(x: np.ndarray) -> np.ndarray:
        made = np.zeros((sum(map(len, rows)) + len(x), len(x)))
        at = 0
        for k, (r, f) in enumerate(zip(rows, fixed, strict=True)):
            off = f.known + np.einsum("p,pin->in", x[:p], f.columns)
            by, more = r.slopes(f.columns, off, x[edges[k] : edges[k + 1]], f.nominal, f.angles)
            made[at : at + len(r), :p] = by / r.u
            made[at : at + len(r), edges[k] : edges[k + 1]] = more / r.u
            at += len(r)
        made[at:] = np.diag(np.concatenate([1 / unknowns.prior, loose]))
        return made

    scale = np.concatenate([unknowns.prior, np.ones(len(start) - p)])
    done = least_squares(
        residual, start, jacobian, x_scale=scale, method="trf", xtol=1e-12, ftol=1e-12, gtol=1e-12
    )
    return done.x, np.asarray(done.jac), done.fun


def _leverage(jacobian: np.ndarray, rows: Sequence[Rows], which: Rows) -> float:
    """How many unknowns the readings of one set-up decide."""
    at = 0
    for r in rows:
        if r is which:
            break
        at += len(r)
    part = jacobian[at : at + len(which)]
    return float(np.trace(np.linalg.solve(jacobian.T @ jacobian, part.T @ part)))


def _leverage_all(jacobian: np.ndarray, unknowns: Unknowns, number: int) -> float:
    """How many of the unknowns the readings decide, and not the prior."""
    prior = jacobian[number : number + unknowns.number]
    return unknowns.number - float(
        np.trace(np.linalg.solve(jacobian.T @ jacobian, prior.T @ prior))
    )


def corners(fitted: Fit, tool: np.ndarray) -> float:
    """mm: the largest standard uncertainty of the deviation at the corners and the middle of the travels."""
    m = fitted.unknowns.bare
    slides = [x for x in XYZ if x in m.letters]
    ends = np.array(
        np.meshgrid(
            *[[m.axes[x].travel[0], sum(m.axes[x].travel) / 2, m.axes[x].travel[1]] for x in slides]
        )
    )
    q = np.zeros((len(m.letters), ends[0].size))
    for x, row in zip(slides, ends.reshape(len(slides), -1), strict=True):
        q[m.letters.index(x)] = row
    u = fitted.at(q, np.zeros_like(q), tool)[1]
    return float(np.sqrt((u**2).sum(axis=0)).max())
