"""Pitch shape: a smooth positioning error that is more than a line: Legendre polynomials of degree 2 to 5 over the travel."""

import numpy as np

from postproc.effects import State, along, legendre, one_way

PARAMETERS = {
    "c2_um": "um, share of the Legendre polynomial of degree 2",
    "c3_um": "um, share of the Legendre polynomial of degree 3",
    "c4_um": "um, share of the Legendre polynomial of degree 4",
    "c5_um": "um, share of the Legendre polynomial of degree 5",
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = "The screw's or scale's error is a smooth curve. Measure the axis again at more targets and write the table."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{}]


def columns(state: State, axis: str) -> np.ndarray:
    u = state.share(axis)
    return along(axis, *(legendre(u, k) for k in (2, 3, 4, 5)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {f"c{k}_um": float(c) for k, c in zip((2, 3, 4, 5), coefficients, strict=True)}


def coefficients(c2_um: float, c3_um: float, c4_um: float, c5_um: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([c2_um, c3_um, c4_um, c5_um]), {}


def tables(axis: str, travel: tuple[float, float], **terms: float):
    def shape(p: np.ndarray) -> np.ndarray:
        u = 2 * (p - travel[0]) / (travel[1] - travel[0]) - 1
        return sum((terms[f"c{k}_um"] * legendre(u, k) for k in (2, 3, 4, 5)), np.zeros(len(p)))

    return [one_way(axis, f"E{axis}", travel, 241, shape)]
