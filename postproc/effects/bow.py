"""Bow: the way of an axis is curved; the tool leaves the line across the motion (straightness, ISO
230-1)."""

import numpy as np

from postproc.effects import XYZ, State, Table, along, legendre, one_way
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": "um, second Legendre polynomial over the travel",
    "across": "0, 1, 2: X, Y, Z, the direction of the error",
    "third_um": "um, the third",
    "degree": "number of the highest polynomial, 2 to 4",
    "fourth_um": "um, the fourth",
}
SIZES = ("size_um", "third_um", "fourth_um")
OPTIONAL = {"third_um": 0.0, "degree": 3.0, "fourth_um": 0.0}
# A beam under its own weight bends as a polynomial of the fourth degree, on supports or clamped
# (Young, Budynas, Roark's Formulas for Stress and Strain, table 8.1).
HIGHEST = (2.0, 3.0, 4.0)
# A router's rail of 2 m, bolted to a frame of welded tube, is 1 mm off at its middle (unverified).
# beyond, it is something else
PLAUSIBLE = dict.fromkeys(SIZES, (-1000.0, 1000.0))
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = (
    "The guideway is bowed. Measure the straightness and write the table; check the machine's"
    " level."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    ways = [float(XYZ.index(x)) for x in state.position if x != axis and x in XYZ]
    return [{"across": way, "degree": degree} for way in ways for degree in HIGHEST]


def columns(state: State, axis: str, across: float, degree: float = 3.0) -> np.ndarray:
    u, way = state.share(axis), XYZ[int(across)]
    # from the second on: a constant is the zero, a line the alignment or the squareness
    return along(way, *(legendre(u, d) for d in range(2, int(degree) + 1)))


def _within(named: dict[str, float]) -> dict[str, float]:
    return named | {"degree": float(np.clip(named["degree"], HIGHEST[0], HIGHEST[-1]))}


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    return SIZES[: int(named["degree"]) - 1]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted, first=_within)


def tables(axis: str, travel: tuple[float, float], across: float, **named: float) -> list[Table]:
    values, _ = coefficients(across=across, **named)

    def shape(p: np.ndarray) -> np.ndarray:
        u = 2 * (p - travel[0]) / (travel[1] - travel[0]) - 1
        terms = (c * legendre(u, d) for d, c in enumerate(values, 2))
        return sum(terms, np.zeros(len(p)))

    # chords of 1/160 of the travel leave 0.1 % of the fourth polynomial at most
    return [one_way(axis, f"E{XYZ[int(across)]}", travel, 161, shape)]
