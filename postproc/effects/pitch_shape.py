"""Pitch shape: a smooth positioning error that is more than a line: Legendre polynomials over the
travel, or over what was measured of it."""

import numpy as np

from postproc.effects import State, Table, along, legendre, one_way
from postproc.effects._curve import curve_ends, place_in
from postproc.effects._named import by_name

MOST = 9
PARAMETERS = {
    **{
        f"c{k}_um": f"um, share of the Legendre polynomial of degree {k}"
        for k in range(1, MOST + 1)
    },
    "degree": "1, the highest degree; below zero: without the line",
    "from_mm": "mm, where the polynomials begin; 0 here and in to_mm: over the travel",
    "to_mm": "mm, where they end; beyond, it is as there",
}
OPTIONAL = dict.fromkeys(PARAMETERS, 0.0)
HIGHEST_DEGREE = {"degree": MOST}
# A rolled trapezoidal screw is wrong by 0.3 mm on 300 mm (unverified: makers' catalogues): as a
# line 1000 ppm of 2 m either side of the middle. What is more than a line is less: a ball screw of
# ISO 3408-3 grade 10 goes 0.21 mm to and fro on 300 mm.
PLAUSIBLE = {
    "c1_um": (-2000.0, 2000.0),
    **{f"c{k}_um": (-500.0, 500.0) for k in range(2, MOST + 1)},
}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool", "part")
TEXT = (
    "The screw's or scale's error is a smooth curve. Measure the axis again at more targets and"
    " write the table."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    ends = curve_ends(state, axis)
    return [{"degree": d} | ends for d in (-5.0, 5.0, float(MOST))]


def degrees(degree: float) -> range:
    """Of the polynomials."""
    return range(2 if degree < 0 else 1, int(abs(degree)) + 1)


def columns(
    state: State, axis: str, degree: float, from_mm: float = 0.0, to_mm: float = 0.0
) -> np.ndarray:
    # Legendre polynomials, not powers: over evenly spread targets they hardly depend on each other,
    # so a further degree changes little of those before it.
    u = place_in(state.position[axis], state.travel[axis], from_mm, to_mm)
    return along(axis, *(legendre(u, k) for k in degrees(degree)))


def _with_degree(named: dict[str, float]) -> dict[str, float]:
    """With the degree that its sizes need, where none is stated."""
    high = any(named[f"c{k}_um"] for k in range(6, MOST + 1))
    needed = float(MOST) if high else 5.0 if named["c1_um"] else -5.0
    return named | {"degree": named["degree"] or needed}


def _fitted(named: dict[str, float]) -> list[str]:
    return [f"c{k}_um" for k in degrees(named["degree"])]


parameters, coefficients = by_name(
    PARAMETERS, OPTIONAL, *list(PARAMETERS)[:MOST], of=_fitted, first=_with_degree
)


def tables(axis: str, travel: tuple[float, float], **named: float) -> list[Table]:
    shares, shape = coefficients(**named)

    def of(p: np.ndarray) -> np.ndarray:
        u = place_in(p, travel, shape["from_mm"], shape["to_mm"])
        terms = (c * legendre(u, k) for k, c in zip(degrees(shape["degree"]), shares, strict=True))
        return sum(terms, np.zeros(len(p)))

    # chords of 1/240 of the travel leave 0.8 % of the ninth polynomial at most, at its very ends
    return [one_way(axis, f"E{axis}", travel, 241, of)]
