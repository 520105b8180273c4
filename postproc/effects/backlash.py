"""Lost motion: the axis lags behind by half the play, on the side it came from.

Positive when it stops short in either direction; negative when the control over-compensates (ISO 230-2 reversal).
"""

import numpy as np

from postproc.effects import Pose
from postproc.units import UM

PARAMETERS = {"size_um": "um, lost motion between the two directions of approach"}
USE = "compensate"
TWO_WAY = True


def deviation(pose: Pose, axis: str, size_um: float) -> np.ndarray:
    """(3, N) mm: -size/2 along the axis when it was reached in +, +size/2 in -, 0 before it has moved."""
    result = np.zeros((3, len(pose)))
    result["XYZ".index(axis)] = -size_um * UM / 2 * pose.approach[axis]
    return result
