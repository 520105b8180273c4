"""Student's t, Fisher's F and chi-squared, from the incomplete beta and gamma functions (Abramowitz and Stegun 26.5, 26.7)."""

from __future__ import annotations

import math

K2 = 0.9545  # the probability of k = 2 on a normal distribution (JCGM 100)


def incomplete_beta(a: float, b: float, x: float) -> float:
    """Regularised I_x(a, b), by its continued fraction (Abramowitz and Stegun 26.5.8), to about 1e-14."""
    if x <= 0 or x >= 1:
        return 0.0 if x <= 0 else 1.0
    if x > (a + 1) / (a + b + 2):
        return 1.0 - incomplete_beta(b, a, 1 - x)
    front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)) / a
    tiny = 1e-300
    c, d = 1.0, 1.0 / _away(1.0 - (a + b) * x / (a + 1), tiny)
    h = d
    for m in range(1, 2000):
        for step in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1.0 / _away(1.0 + step * d, tiny)
            c = _away(1.0 + step / c, tiny)
            h *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    return front * h


def _away(x: float, tiny: float) -> float:
    return x if abs(x) > tiny else tiny


def f_tail(value: float, dof1: float, dof2: float) -> float:
    """Probability that F with these degrees of freedom is larger than `value`."""
    return incomplete_beta(dof2 / 2, dof1 / 2, dof2 / (dof2 + dof1 * value))


def student(dof: float, probability: float = K2) -> float:
    """t such that a share `probability` lies within +-t: 2.87 at 4 degrees of freedom, 2.00 at very many."""
    if dof > 1e6:
        dof = 1e6
    low, high = 0.0, 1e4
    for _ in range(100):
        t = (low + high) / 2
        if incomplete_beta(dof / 2, 0.5, dof / (dof + t * t)) > 1 - probability:
            low = t
        else:
            high = t
    return (low + high) / 2


def chi_squared_tail(value: float, dof: float) -> float:
    """Probability that chi-squared is larger than `value`: F with a denominator of 1e7 degrees of freedom, to about 1e-6."""
    return f_tail(value / dof, dof, 1e7)
