"""Between the coefficients of a fit with their shape and the named parameters of an effect, for all
effects whose coefficients are parameters as they stand."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence

import numpy as np


def by_name(
    parameters: Mapping[str, str],
    optional: Mapping[str, float],
    *linear: str,
    of: Callable[[dict[str, float]], Sequence[str]] | None = None,
    first: Callable[[dict[str, float]], dict[str, float]] = dict,
    second_if: str = "",
) -> tuple[Callable[..., dict[str, float]], Callable[..., tuple[np.ndarray, dict[str, float]]]]:
    """`parameters` and `coefficients` of an effect whose coefficients are the parameters `linear`,
    in this order, and whose shape is all the others.

    of: which of `linear` there are, by the whole of the parameters, where not all of them are;
    first: what is made of parameters that were stated before they are taken apart; second_if: a
    parameter of the shape that says whether the second of `linear` is there, which is so too where
    that was stated."""
    kinds = [
        inspect.Parameter(
            n, inspect.Parameter.KEYWORD_ONLY, default=optional.get(n, inspect._empty)
        )
        for n in parameters
    ]
    # bound by the parameters' own names: a missing or misspelt one is a TypeError, not a size of 0
    signature = inspect.Signature(kinds)

    def fitted(whole: dict[str, float]) -> Sequence[str]:
        if second_if:
            return linear[: 2 if whole[second_if] else 1]
        return of(whole) if of else linear

    def named(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
        whole = {n: shape.get(n, optional.get(n, 0.0)) for n in parameters}
        return whole | dict(zip(fitted(whole), map(float, coefficients), strict=True))

    def coefficients(**values: float) -> tuple[np.ndarray, dict[str, float]]:
        bound = signature.bind(**values)
        bound.apply_defaults()
        whole = first(bound.arguments)
        if second_if:
            whole[second_if] = whole[second_if] or float(whole[linear[1]] != 0.0)
        shape = {n: v for n, v in whole.items() if n not in linear}
        return np.array([whole[n] for n in fitted(whole)]), shape

    coefficients.__signature__ = signature  # type: ignore[attr-defined]
    return named, coefficients
