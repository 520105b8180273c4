"""Step diagonals: one axis after the other moves by its share of a diagonal, and the displacement
along it is read each time, by a laser and a plane mirror that the tool carries.

Each step tells of one axis alone, so the stair parts what the diagonal adds up (C. Wang, Rev. Sci.
Instrum. 71 (2000) 3933). Two things belong to it that a diagonal has not. The tool moves aside, so
the beam meets another place of the mirror, and rotations act there, on the beam's own line. And a
mirror that leans adds its lean times every motion aside: two numbers of each set-up, which take
from the stair what it seems to tell of scales (M. A. V. Chapman, Precision Engineering 27 (2003)
401). Where the lean is known, the recording's head says how well: mirror_u_urad.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from postproc.errors import Place
from postproc.recordings import Recording, RecordingError
from postproc.units import URAD

ALONG = 0.045  # sine of 2.6 degrees: a beam that leans less lies along one axis
STEP = 0.1  # mm: words of a diagonal are rounded to micrometres, steps are millimetres


def is_diagonal(along: np.ndarray) -> bool:
    """Whether a beam (3,) lies along several axes."""
    return int((np.abs(along) > ALONG).sum()) > 1


def aside(place: np.ndarray, along: np.ndarray) -> np.ndarray:
    """(3, N) mm by which places (3, N) lie beside the line along (3,) through the first of them."""
    way = place - place[:, :1]
    #         .-' end      beam along the diagonal; after a step of X alone the tool stands `aside`
    #    X .-'|            of it, and the beam meets the mirror there
    #     *---o
    return way - along[:, None] * (along @ way)


def is_stepped(sideways: np.ndarray) -> bool:
    """Whether these are steps, and not a straight diagonal."""
    return bool(np.abs(sideways).max(initial=0.0) > STEP)


def across(sideways: np.ndarray) -> np.ndarray:
    """(M, 3): unit vectors of the directions in which the tool moves aside (3, N): two, or one of a
    stair in a plane."""
    # The mirror may lean about both directions across the beam, but only those that the stair moved
    # in change a reading: the others would be numbers without a reading.
    directions, sizes, _ = np.linalg.svd(sideways, full_matrices=False)
    return directions[:, : len(sizes)][:, sizes > STEP].T


def mirror_weights(recording: Recording, leans: int) -> np.ndarray:
    """(1 + leans,): how much the zero and the leans are held at zero: 1/rad of the leans where the
    head says how well the mirror stands across the beam, else nothing. Raises RecordingError."""
    said = recording.head.get("mirror_u_urad")
    if said is None:
        return np.zeros(1 + leans)
    if not isinstance(said, int | float) or isinstance(said, bool) or not 0 < said < np.inf:
        raise RecordingError(
            f"mirror_u_urad = {said!r} is no angle above zero",
            "like mirror_u_urad = 50.0: how well the mirror stands across the beam, urad",
            Place(recording.file, 1),
        )
    return np.array([0.0] + [1 / (said * URAD)] * leans)


def on_the_beam(
    effect: Callable[[np.ndarray], np.ndarray], tool: np.ndarray, sideways: np.ndarray
) -> np.ndarray:
    """(..., 3, N) of the place where the beam meets the mirror. effect(tool): (..., 3, N) of a
    tool's point (3,) mm. It goes straight with the arm, so four points tell it."""
    at = effect(tool)
    result = at.copy()
    for i, e in enumerate(np.eye(3)):
        # minus: where the tool has moved aside, the beam's own line lies that much the other way
        result -= (effect(tool + e) - at) * sideways[i]
    return result
