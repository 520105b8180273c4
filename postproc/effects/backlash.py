"""Lost motion: the axis lags behind by half the play, on the side it came from. Pockets come out
smaller by it, bosses larger.

Positive when it stops short in either direction; negative when the control over-compensates (ISO
230-2 reversal).
"""

import numpy as np

from postproc.effects import UM, State, Table, along, by_name, lost_motion_share

PARAMETERS = {
    "size_um": "um, lost motion between the two directions of approach",
    "play_mm": "mm, way after a turn over which it is taken up",
}
OPTIONAL = {"play_mm": 0.0}
SMALL = 0.02  # mm
# An old router's nut of plastic has 1 mm; a control's own compensation, for which there is no other
# sign, takes out less than it is.
PLAUSIBLE = {"size_um": (-1000.0, 2000.0)}  # beyond, it is something else (unverified)
EXPECTED = {"size_um": 1}
CONTINUOUS = {"play_mm": (0.001, 0.05)}  # mm, over which it is taken up
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("approach",), ("tool", "part")
TEXT = (
    "Lost motion in nut, bearing or coupling: the same gap wherever the axis turns back. "
    "Set the control's backlash or let the compensator take it up; a growing value is wear."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near = state.distance.get(axis)
    fine = near is not None and bool(np.any(near < SMALL))
    return [{"play_mm": v} for v in (0.0, 0.004, 0.008, 0.016)] if fine else [{"play_mm": 0.0}]


def columns(state: State, axis: str, play_mm: float = 0.0) -> np.ndarray:
    return along(axis, -state.approach[axis] / 2 * lost_motion_share(state, axis, play_mm))


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um")


def ramp_mm(size_um: float, play_mm: float = 0.0) -> float:
    """mm that the slide itself goes while the lost motion builds up over play_mm of its command."""
    return max(play_mm - abs(size_um) * UM, 0.0)


def tables(
    axis: str, travel: tuple[float, float], size_um: float, play_mm: float = 0.0
) -> list[Table]:
    nodes = np.array(travel)
    return [(f"E{axis}", axis, nodes, np.full(2, -size_um * UM / 2), np.full(2, size_um * UM / 2))]
