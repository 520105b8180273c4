"""The fit whose largest residual is smallest (Chebyshev): exact, by the simplex method on the dual problem.

The reference points carry weights that balance; the point with the largest residual takes the place of one of them.
Bland's rule ends what would go round in circles where points coincide (Bland, Math. Oper. Res. 2, 1977, 103).
"""

from __future__ import annotations

import numpy as np

ROUNDS = 5000


def minimax(basis: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients (p,) and h: max |value - basis @ coefficients| = h is the least possible. basis (N, p), value (N,).

    Raises ValueError where the basis does not determine the coefficients.
    """
    count, p = basis.shape
    if count < p:
        raise ValueError("fewer points than coefficients")
    middle, scale = float(np.mean(value)), float(np.ptp(value))
    if scale == 0:
        scale = 1.0
    size = np.abs(basis).max(axis=0)
    size[size == 0] = 1.0
    y = (value - middle) / scale
    one = basis / size
    # Columns of the dual: +point i, -point i; rows: the weights balance in every basis function, and add up to one.
    columns = np.concatenate([np.vstack([one.T, np.ones(count)]), np.vstack([-one.T, np.ones(count)])], axis=1)
    cost = np.concatenate([y, -y])
    base = _start(one, columns)
    right = np.zeros(p + 1)
    right[p] = 1.0
    stalled = 0
    best = -np.inf
    for _ in range(ROUNDS):
        matrix = columns[:, base]
        price = np.linalg.solve(matrix.T, cost[base])
        gain = cost - price @ columns
        gain[base] = 0.0
        if gain.max() < 1e-13:
            break
        stalled = 0 if price[p] > best + 1e-14 else stalled + 1
        best = max(best, float(price[p]))
        enter = int(np.argmax(gain)) if stalled < 20 else int(np.argmax(gain > 1e-13))
        weight = np.linalg.solve(matrix, right)
        change = np.linalg.solve(matrix, columns[:, enter])
        falling = change > 1e-11
        if not falling.any():
            break
        ratio = np.where(falling, np.maximum(weight, 0.0) / np.where(falling, change, 1.0), np.inf)
        ties = np.flatnonzero(ratio <= ratio.min() + 1e-15)
        leave = ties[np.argmin(base[ties])]
        base[leave] = enter
    coefficients = _with_middle(price[:p] * scale / size, basis, middle)
    return coefficients, float(np.abs(value - basis @ coefficients).max())


def _start(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """A first reference: one point with both signs, and p - 1 others that make it regular."""
    count, p = basis.shape
    chosen = [0]
    rest = basis - np.outer(basis @ basis[0], basis[0]) / (basis[0] @ basis[0])
    for _ in range(p - 1):
        lengths = np.linalg.norm(rest, axis=1)
        next_one = int(np.argmax(lengths))
        if lengths[next_one] < 1e-9:
            raise ValueError("the points do not determine the fit")
        direction = rest[next_one] / lengths[next_one]
        rest = rest - np.outer(rest @ direction, direction)
        chosen.append(next_one)
    return np.array([chosen[0], chosen[0] + count, *chosen[1:]])


def _with_middle(coefficients: np.ndarray, basis: np.ndarray, middle: float) -> np.ndarray:
    """The mean that was taken off the values goes back into the constant, which is the first function."""
    assert np.all(basis[:, 0] == basis[0, 0])
    coefficients = coefficients.copy()
    coefficients[0] += middle / basis[0, 0]
    return coefficients
