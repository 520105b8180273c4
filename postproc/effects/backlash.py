"""Lost motion: the axis lags behind by half the play, on the side it came from. Pockets come out
smaller by it, bosses larger.

Positive when it stops short in either direction; negative when the control over-compensates (ISO
230-2 reversal). An outside force that is larger than the friction of the slide pushes it to the
other side of the play, whichever way it came.
"""

import numpy as np

from postproc.effects import UM, State, Table, along, by_name, loads, lost_motion_share

PARAMETERS = {
    "size_um": "um, lost motion between the two directions of approach",
    "play_mm": "mm, way after a turn over which it is taken up",
    "pushed": "1, a force on the slide takes it to the side that it pushes to; 0, it does not",
}
OPTIONAL = {"play_mm": 0.0, "pushed": 0.0}
PUSHES = 0.5  # of the largest force: so much overcomes the friction
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
    plays = (0.0, 0.004, 0.008, 0.016) if fine else (0.0,)
    found = [{"play_mm": v, "pushed": 0.0} for v in plays]
    push = _push(state, axis)
    both = push.min(initial=0.0) < 0 < push.max(initial=0.0)
    return [*found, {"play_mm": 0.0, "pushed": 1.0}] if both else found


def _push(state: State, axis: str) -> np.ndarray:
    """(N,) -1 or +1: to which side a recorded force pushes the slide, 0 where it is too small."""
    force = sum(loads(state, axis), np.zeros(len(state)))
    return np.sign(force) * (np.abs(force) > PUSHES * np.abs(force).max(initial=0.0))


def columns(state: State, axis: str, play_mm: float = 0.0, pushed: float = 0.0) -> np.ndarray:
    lag = -state.approach[axis] / 2 * lost_motion_share(state, axis, play_mm)
    if pushed:
        push = _push(state, axis)
        lag = np.where(push != 0, push / 2, lag)
    return along(axis, lag)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um")


def ramp_mm(size_um: float, play_mm: float = 0.0, pushed: float = 0.0) -> float:
    """mm that the slide itself goes while the lost motion builds up over play_mm of its command."""
    return max(play_mm - abs(size_um) * UM, 0.0)


def tables(
    axis: str,
    travel: tuple[float, float],
    size_um: float,
    play_mm: float = 0.0,
    pushed: float = 0.0,
) -> list[Table]:
    nodes = np.array(travel)
    return [(f"E{axis}", axis, nodes, np.full(2, -size_um * UM / 2), np.full(2, size_um * UM / 2))]
