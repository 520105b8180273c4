"""Lost motion: the axis lags behind by half the play, on the side it came from. Pockets come out
smaller by it, and bosses whose walls are reached from the outside larger; a boss that is milled in
a circle is smaller too: where it is widest the axis turns, having come outwards.

Positive when it stops short in either direction; negative when the control over-compensates (ISO
230-2 reversal). An outside force that is larger than the friction of the slide pushes it to the
other side of the play, whichever way it came.
"""

import numpy as np

from postproc.effects import UM, State, Table, along, loads, lost_motion_share
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": "um, lost motion between the two directions of approach",
    "play_mm": "mm, way after a turn over which it is taken up",
    "around": "1, bosses are milled in circles; 0, their walls are reached from the outside",
    "pushed": "1, a force on the slide takes it to the side that it pushes to; 0, it does not",
}
OPTIONAL = {"play_mm": 0.0, "around": 0.0, "pushed": 0.0}
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
    ways = (0.0, 1.0) if _bosses(state).any() else (0.0,)
    found = [{"play_mm": v, "around": w, "pushed": 0.0} for v in plays for w in ways]
    push = _push(state, axis)
    both = push.min(initial=0.0) < 0 < push.max(initial=0.0)
    return [*found, {"play_mm": 0.0, "around": 0.0, "pushed": 1.0}] if both else found


def _bosses(state: State) -> np.ndarray:
    """(N,) bool: walls of bosses, but for those that are turned."""
    return np.asarray(state.channels.get("material", np.zeros(len(state))) < 0)


def _push(state: State, axis: str) -> np.ndarray:
    """(N,) -1 or +1: to which side a recorded force pushes the slide, 0 where it is too small."""
    force = sum(loads(state, axis), np.zeros(len(state)))
    return np.sign(force) * (np.abs(force) > PUSHES * np.abs(force).max(initial=0.0))


def columns(
    state: State, axis: str, play_mm: float = 0.0, around: float = 0.0, pushed: float = 0.0
) -> np.ndarray:
    #         |<--- size --->|
    #    ---->o      |       o<----     approached in + it stops half of the size short of the
    #              command              command, in - half of it above: their mean is the command
    lag = -state.approach[axis] / 2 * lost_motion_share(state, axis, play_mm)
    if around:
        lag = np.where(_bosses(state), -lag, lag)
    if pushed:
        push = _push(state, axis)
        lag = np.where(push != 0, push / 2, lag)
    return along(axis, lag)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "size_um")


def ramp_mm(size_um: float, play_mm: float = 0.0, **others: float) -> float:
    """mm that the slide itself goes while the lost motion builds up over play_mm of its command."""
    return max(play_mm - abs(size_um) * UM, 0.0)


def tables(axis: str, travel: tuple[float, float], size_um: float, **others: float) -> list[Table]:
    nodes = np.array(travel)
    return [(f"E{axis}", axis, nodes, np.full(2, -size_um * UM / 2), np.full(2, size_um * UM / 2))]
