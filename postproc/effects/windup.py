"""Windup: a reversal error that builds up with the distance after the reversal (pre-sliding friction, an elastic drive).

After a long way and one turn it is Dahl's model (A solid friction model, 1968): 1 - 2 exp(-way / length). That is a drive of plays
(Prandtl-Ishlinskii) whose thresholds r are as frequent as exp(-2 r / length), and such a drive has Masing's rules: every way since a
turn, until it is as long as the one before, adds its own size * (1 - exp(-way / length)) to what was remembered
(Al-Bender, Lampaert, Swevers, The generalized Maxwell-slip model, IEEE Trans. Automatic Control 50, 2005).
"""

import numpy as np

from postproc.effects import UM, State, along, grid

PARAMETERS = {
    "size_um": "um, lost motion when it is fully built up",
    "length_mm": "mm, distance over which it builds up",
}
# Twice the friction over the stiffness: 50 N on a belt of 100 N/mm are 1 mm, on a screw of 50 N/um 2 um.
PLAUSIBLE = {"size_um": (0.0, 1000.0)}  # beyond, it is something else (unverified: usual belts)
EXPECTED = {"size_um": 1}
CONTINUOUS = {"length_mm": (0.05, 15.0)}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("approach", "distance"), ("tool", "part")
TEXT = (
    "The drive winds up before the slide follows. "
    "A staircase of small reversals shows its length; the compensator takes it up over three of them (reversal = ramp)."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"length_mm": v} for v in grid(0.1, 10.0, 9)]


def columns(state: State, axis: str, length_mm: float) -> np.ndarray:
    if axis not in state.path:  # the last turn alone
        built = 1 - 2 * np.exp(-state.distance[axis] / length_mm)
        return along(axis, -state.approach[axis] / 2 * built)
    ways = state.path[axis]
    each = np.sign(ways) * -np.expm1(-np.abs(ways) / length_mm)
    return along(axis, each[0] / 2 - each.sum(axis=0))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "length_mm": shape["length_mm"]}


def coefficients(size_um: float, length_mm: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"length_mm": length_mm}


def ramp_mm(size_um: float, length_mm: float) -> float:
    """mm of travel after a turn over which a compensator takes it up: 3 lengths, when 0.9 of it has come. Taken up at the turn
    it would be all there before the slide asks for it, and leave twice what it leaves uncorrected."""
    return 3.0 * length_mm


def tables(axis: str, travel: tuple[float, float], size_um: float, length_mm: float):
    """Fully built up; ramp_mm says over which way after a turn."""
    nodes = np.array(travel)
    return [(f"E{axis}", axis, nodes, np.full(2, -size_um * UM / 2), np.full(2, size_um * UM / 2))]
