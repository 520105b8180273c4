"""Tool size: the tool's diameter is not the one that was assumed; every wall is off by half of the
difference."""

import numpy as np

from postproc.effects import State
from postproc.effects._named import by_name

PARAMETERS = {
    "diameter_um": "um, how much larger the tool is",
    "change": "number of the part before which it was ground or changed, 0: never",
    "then_um": "um, how much larger it is from that part on",
    "bores": "1, it makes the bores too; 0, another tool does, such as a drill or a boring head",
}
SIZES = ("diameter_um", "then_um")
OPTIONAL = {"change": 0.0, "then_um": 0.0, "bores": 1.0}
# A cutter that was ground again; beyond, it is another tool (unverified).
PLAUSIBLE = {"diameter_um": (-1000.0, 1000.0), "then_um": (-1000.0, 1000.0)}
KIND, USE, PER = "machine", "compensate", "all"
NEEDS, SEES = ("material",), ("part",)
TEXT = "The tool's diameter is not what the control believes. Measure the tool and set its radius."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    walls = state.channels["material"] != 0
    parts = np.unique(state.channels.get("part", np.zeros(1))[walls])
    holes = state.channels.get("hole", np.zeros(len(walls)))[walls] > 0
    bores = (1.0, 0.0) if holes.any() and not holes.all() else (1.0,)
    return [{"change": float(p), "bores": b} for p in (0.0, *parts[1:]) for b in bores]


def columns(state: State, axis: str, change: float = 0.0, bores: float = 1.0) -> np.ndarray:
    """Half a diameter towards the wall: of a pocket it grows, of a boss it shrinks; on a lathe the
    same by the tool's nose."""
    walls = state.channels["material"].copy()
    turned = (walls == 0) & (state.channels.get("wall", walls) != 0)
    # material: +1 of a pocket or bore, -1 of a boss, whose size grows or shrinks by half a diameter
    # at each wall. A turned size is read as twice the slide, of which the nose asks half.
    walls[turned] = np.where(state.channels.get("bore", walls)[turned] > 0, 0.5, -0.5)
    if not bores:
        walls[state.channels.get("hole", np.zeros(len(walls))) > 0] = 0.0
    if not change:
        return np.broadcast_to(walls * 1e-3, (1, 3, len(state))).copy()
    then = state.channels.get("part", walls) >= change
    return np.repeat(np.stack([walls * ~then, walls * then])[:, None] * 1e-3, 3, axis=1)


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    return SIZES if named["change"] else SIZES[:1]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted)
