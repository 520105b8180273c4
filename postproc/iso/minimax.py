"""The fit whose largest residual is smallest (Chebyshev), by linear programming
(scipy.optimize.linprog, HiGHS).

The least h with -h <= value - basis c <= h is looked for. HiGHS keeps its constraints to 1e-7 of
the scale; the points that carry weight at its answer, one more than there are coefficients, give it
to the last digit.
"""

from __future__ import annotations

import numpy as np

WEIGHT = 1e-9  # of the largest: a point with less carries none


def minimax(basis: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients (p,) and h: max |value - basis @ coefficients| = h is the least possible. basis
    (N, p), value (N,).

    Raises ValueError where the basis does not determine the coefficients.
    """
    from scipy.optimize import linprog

    count, p = basis.shape
    if count < p:
        raise ValueError("fewer points than coefficients")
    size = np.abs(basis).max(axis=0)
    one = basis / np.where(size == 0, 1.0, size)
    if np.linalg.matrix_rank(one, tol=1e-9 * np.sqrt(count)) < p:
        raise ValueError("the points do not determine the fit")
    # What least squares leave is of the size of h: the programme's numbers are then all about one.
    first = np.linalg.lstsq(one, value, rcond=None)[0]
    left = value - one @ first
    scale = float(np.abs(left).max())
    if scale == 0:
        return first / np.where(size == 0, 1.0, size), 0.0
    y = left / scale
    #    minimise h   with    one c - h <=  y          unknowns: c (p,), then h
    #                        -one c - h <= -y
    ends = np.vstack(
        [np.hstack([one, -np.ones((count, 1))]), np.hstack([-one, -np.ones((count, 1))])]
    )
    found = linprog(
        [0.0] * p + [1.0], A_ub=ends, b_ub=np.concatenate([y, -y]),
        bounds=[(None, None)] * p + [(0, None)], method="highs",
    )  # fmt: skip
    if found.x is None:
        raise ValueError(f"the points do not determine the fit: {found.message}")
    steps = [found.x[:p]]
    weight = -found.ineqlin.marginals
    # The p + 1 points that touch +-h decide c and h: solved as equations they are exact, which
    # HiGHS's own answer is to 1e-7. Where more points touch (equal readings) the equations may be
    # singular, and its answer is kept; of both the better one is taken.
    carry = np.flatnonzero(weight > WEIGHT * weight.max())
    if len(carry) == p + 1 and np.linalg.matrix_rank(ends[carry]) == p + 1:
        steps.append(np.linalg.solve(ends[carry], np.concatenate([y, -y])[carry])[:p])
    step = min(steps, key=lambda c: float(np.abs(y - one @ c).max()))
    coefficients = (first + scale * step) / np.where(size == 0, 1.0, size)
    return coefficients, float(np.abs(value - basis @ coefficients).max())
