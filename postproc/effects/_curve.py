"""Over what a curve of polynomials runs: the travel, or what was measured of it."""

import numpy as np

from postproc.effects import State

# of the travel: a curve over less than the second has its own range; over less than the first no
# screw differs by more than a line (unverified)
PART = 0.1, 0.5
ENDS = "from_mm", "to_mm"


def reached(state: State, axis: str) -> tuple[float, float]:
    """mm: between which places rows tell from which side their axis came; low > high: nowhere."""
    place = state.position[axis][state.approach[axis] != 0]
    low, high = state.travel[axis]
    return (float(place.min()), float(place.max())) if len(place) else (high, low)


def curve_ends(state: State, axis: str) -> dict[str, float]:
    """from_mm and to_mm of a curve: where targets end, where these reach over such a part of the
    travel that a polynomial over all of it is a line, a parabola and little else there; 0, the
    travel. A circle or a log of a few mm tells no curve of a screw."""
    (low, high), travel = reached(state, axis), state.travel[axis]
    moving = state.passage[state.approach[axis] != 0] >= 0 if len(state.passage) else False
    # between PART[0] and PART[1] of the travel a curve gets a range of its own: from_mm to to_mm
    part = (high - low) / (travel[1] - travel[0])
    if np.any(moving) or not PART[0] < part < PART[1]:
        return dict.fromkeys(ENDS, 0.0)
    return dict(zip(ENDS, (round(low, 4), round(high, 4)), strict=True))


def place_in(
    place: np.ndarray, travel: tuple[float, float], from_mm: float, to_mm: float
) -> np.ndarray:
    """(N,): places (N,) mm as -1 to +1 of the travel, or of a curve's own range where it has one;
    beyond that as at its ends."""
    if from_mm < to_mm:
        # beyond its range a polynomial of degree nine would leave all bounds: held at its ends
        return np.clip(2 * (place - from_mm) / (to_mm - from_mm) - 1, -1.0, 1.0)
    return 2 * (place - travel[0]) / (travel[1] - travel[0]) - 1
