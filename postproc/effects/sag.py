"""Sag: a structure bends with the place of a mass on another axis.

What is held at one end gives with the square of the mass' reach. A beam on two supports is lowered at s by a mass at a by the
sum over n of sin(n pi a) sin(n pi s) / n^4 (Timoshenko, Vibration Problems in Engineering, simply supported beam).
"""

import numpy as np

from postproc.effects import XYZ, State
from postproc.effects import along as towards

PARAMETERS = {
    "size_um": "um, at the end of the other axis' travel; of a beam at the middle of both",
    "along": "0, 1, 2: X, Y, Z, the direction of the error",
    "lever": "1, it grows with the place of the next axis too; 0, it does not",
    "beam": "0, 1, 2: X, Y, Z, the axis that runs along the beam; -1, what gives is held at one end",
    "overhang": "1, by how much of the travel the beam is longer at each end",
}
OPTIONAL = {"lever": 0.0, "beam": -1.0, "overhang": 0.0}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position",), ("tool",)
TEXT = (
    "A moving mass bends what carries it. "
    "Measure the straightness with the mass at both ends; a table over two axes corrects it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    others = [float(XYZ.index(x)) for x in state.position if x != axis and x in XYZ]
    # Without a second axis what is held at one end is a bow and an angle: those names say as much.
    held = [{"along": a, "lever": 1.0, "beam": -1.0, "overhang": 0.0} for a in others if len(others) > 1]
    return held + [
        {"along": a, "lever": 0.0, "beam": b, "overhang": o} for a in others for b in others for o in (0.05, 0.2)
    ]


def columns(
    state: State, axis: str, along: float, lever: float = 0.0, beam: float = -1.0, overhang: float = 0.0
) -> np.ndarray:
    reach = (state.share(axis) + 1) / 2
    if beam >= 0:
        over = XYZ[int(beam)]
        if over not in state.position:
            return towards(XYZ[int(along)], np.zeros(len(reach)))
        a, s = ((overhang + u) / (1 + 2 * overhang) for u in (reach, (state.share(over) + 1) / 2))
        n = np.arange(1, 5)[:, None]
        bent = (np.sin(n * np.pi * a) * np.sin(n * np.pi * s) / n**4).sum(axis=0)
        return towards(XYZ[int(along)], -bent)
    others = [x for x in state.position if x != axis and x != XYZ[int(along)]]
    arm = (state.share(others[0]) + 1) / 2 if others and lever else 1.0
    return towards(XYZ[int(along)], reach**2 * arm)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0])} | {k: shape.get(k, d) for k, d in {"along": 0.0, **OPTIONAL}.items()}


def coefficients(
    size_um: float, along: float, lever: float = 0.0, beam: float = -1.0, overhang: float = 0.0
) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"along": along, "lever": lever, "beam": beam, "overhang": overhang}
