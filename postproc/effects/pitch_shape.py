"""Pitch shape: a smooth positioning error that is more than a line: Legendre polynomials over the
travel."""

import numpy as np

from postproc.effects import State, Table, along, legendre, one_way

MOST = 9
PARAMETERS = {
    **{
        f"c{k}_um": f"um, share of the Legendre polynomial of degree {k}"
        for k in range(1, MOST + 1)
    },
    "degree": "1, the highest degree; below zero: without the line",
}
OPTIONAL = {f"c{k}_um": 0.0 for k in range(1, MOST + 1)} | {"degree": 0.0}
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
    return [{"degree": -5.0}, {"degree": 5.0}, {"degree": float(MOST)}]


def degrees(degree: float) -> range:
    """Of the polynomials."""
    return range(2 if degree < 0 else 1, int(abs(degree)) + 1)


def columns(state: State, axis: str, degree: float) -> np.ndarray:
    u = state.share(axis)
    return along(axis, *(legendre(u, k) for k in degrees(degree)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    named = dict(OPTIONAL) | {"degree": shape["degree"]}
    return named | {
        f"c{k}_um": float(c) for k, c in zip(degrees(shape["degree"]), coefficients, strict=True)
    }


def coefficients(
    c1_um: float = 0.0,
    c2_um: float = 0.0,
    c3_um: float = 0.0,
    c4_um: float = 0.0,
    c5_um: float = 0.0,
    c6_um: float = 0.0,
    c7_um: float = 0.0,
    c8_um: float = 0.0,
    c9_um: float = 0.0,
    degree: float = 0.0,
) -> tuple[np.ndarray, dict[str, float]]:
    shares = [c1_um, c2_um, c3_um, c4_um, c5_um, c6_um, c7_um, c8_um, c9_um]
    if not degree:
        degree = float(MOST) if any(shares[5:]) else 5.0 if c1_um else -5.0
    return np.array([shares[k - 1] for k in degrees(degree)]), {"degree": degree}


def tables(axis: str, travel: tuple[float, float], **named: float) -> list[Table]:
    shares, shape = coefficients(**named)

    def of(p: np.ndarray) -> np.ndarray:
        u = 2 * (p - travel[0]) / (travel[1] - travel[0]) - 1
        terms = (c * legendre(u, k) for k, c in zip(degrees(shape["degree"]), shares, strict=True))
        return sum(terms, np.zeros(len(p)))

    return [one_way(axis, f"E{axis}", travel, 241, of)]
