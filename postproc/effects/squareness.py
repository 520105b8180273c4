"""Squareness: two axes do not stand at the assumed angle; one leans against the other (ISO 230-1).

With play in the guides a slide also yaws as it turns, and the angle has a value in each direction.
That is tried where the axis that moves came from both sides.
"""

import numpy as np

from postproc.effects import UM, State, Table, along

PARAMETERS = {
    "urad": "urad, change of the angle: positive where it is more than a right one",
    "leans": (
        "0, the first axis of the pair leans as the second moves; 1, the second leans as the first"
        " moves"
    ),
    "turn_urad": (
        "urad, of which the angle is more as the axis that moves comes from below than as it comes"
        " from above"
    ),
    "turn_um": (
        "um, what goes with it at the zero of the axis that moves: it yaws about another place"
    ),
}
OPTIONAL = {"leans": 0.0, "turn_urad": 0.0, "turn_um": 0.0}
# A router that was put up by eye: 1 mm on 200 mm (unverified).
# Play of 0.05 mm in guides that are 50 mm apart (unverified).
PLAUSIBLE = {
    "urad": (-5000.0, 5000.0),
    "turn_urad": (-1000.0, 1000.0),
    "turn_um": (-1000.0, 1000.0),
}  # beyond, it is something else
# Twice the logarithm of how much seldomer a slide yaws as it turns than it just stands askew:
# it is seldomer than lost motion, which an angle of this kind looks like along a line.
YAWS = 4.0
LONG = 0.5  # um per urad: an arm of 500 mm
KIND, USE, PER = "machine", "compensate", "pair"
NEEDS, SEES = ("position",), ("tool",)
RESTING = True
TEXT = "Two axes are not square. Write it into the machine's squareness; a program compensates it."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    plain = [{"leans": leans, "turns": 0.0} for leans in (0.0, 1.0)]
    came = [np.unique(np.sign(state.approach[_axes(axis, shape["leans"])[1]])) for shape in plain]
    turned = [{**p, "turns": 1.0} for p, c in zip(plain, came, strict=True) if -1 in c and 1 in c]
    return plain + turned


def further_cost(axis: str, shape: dict[str, float]) -> float:
    """Twice the logarithm of how much seldomer a shape is than the others of this effect."""
    return YAWS if shape["turns"] else 0.0


def sensible(urad: float, turn_urad: float = 0.0, turn_um: float = 0.0, **_: float) -> bool:
    """Whether it is an angle first: what changes as the slide turns is the smaller part."""
    return max(abs(turn_urad), abs(turn_um) / LONG) <= abs(urad)


def _axes(axis: str, leans: float) -> tuple[str, str]:
    """The axis that leans and the one that moves."""
    return (axis[1], axis[0]) if leans else (axis[0], axis[1])


def columns(state: State, axis: str, leans: float = 0.0, turns: float = 0.0) -> np.ndarray:
    first, second = _axes(axis, leans)
    #    Y ^   / urad < 0      More than a right angle leans towards - of the first axis: at the
    #      |  /               place y of the second it is off by -urad * y, um of 1e-3 urad mm.
    #      | /
    #      +------> X
    way = -state.position[second] * 1e-3
    if not turns:
        return along(first, way)
    half = state.approach[second] / 2
    return along(first, way, half * way, half)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    urad, turn_urad, turn_um = [*(float(c) for c in coefficients), 0.0, 0.0][:3]
    return {"urad": urad, "leans": shape["leans"], "turn_urad": turn_urad, "turn_um": turn_um}


def coefficients(
    urad: float, leans: float = 0.0, turn_urad: float = 0.0, turn_um: float = 0.0
) -> tuple[np.ndarray, dict[str, float]]:
    if not turn_urad and not turn_um:
        return np.array([urad]), {"leans": leans, "turns": 0.0}
    return np.array([urad, turn_urad, turn_um]), {"leans": leans, "turns": 1.0}


def moving(axis: str, leans: float = 0.0, **named: float) -> str:
    """The axis whose travel moves the tool along the other."""
    return axis[0] if leans else axis[1]


def tables(
    axis: str,
    travel: tuple[float, float],
    urad: float,
    leans: float = 0.0,
    turn_urad: float = 0.0,
    turn_um: float = 0.0,
) -> list[Table]:
    """travel: of the axis that moves the tool along the other."""
    driver = moving(axis, leans)
    nodes = np.array(travel)
    mean, half = -urad * nodes * 1e-3 * UM, (turn_um - turn_urad * nodes * 1e-3) * UM / 2
    return [(f"E{axis.replace(driver, '')}", driver, nodes, mean + half, mean - half)]
