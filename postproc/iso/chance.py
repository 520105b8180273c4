"""Student's t, Fisher's F and chi-squared, of scipy.stats, which is imported where one is asked
for."""

from __future__ import annotations

from functools import cache

K2 = 0.9545  # the probability of k = 2 on a normal distribution (JCGM 100)
MANY = 1e6  # degrees of freedom: more change nothing


def f_tail(value: float, dof1: float, dof2: float) -> float:
    """Probability that F with these degrees of freedom is larger than `value`."""
    from scipy.stats import f

    return float(f.sf(value, dof1, dof2))


@cache
def student(dof: float, probability: float = K2) -> float:
    """t such that a share `probability` lies within +-t: 2.87 at 4 degrees of freedom, 2.00 at very
    many."""
    from scipy.stats import t

    return float(t.isf((1 - probability) / 2, min(dof, MANY)))


def chi_squared_tail(value: float, dof: float) -> float:
    """Probability that chi-squared is larger than `value`."""
    from scipy.stats import chi2

    return float(chi2.sf(value, dof))
