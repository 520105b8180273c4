"""Cosine error: the beam, the scale or the step gauge was not parallel to the motion; readings are
too short in proportion. Faces of a step gauge that stands askew lie farther apart along the motion:
readings are too long.

In one set-up, in all of them along an axis (a fixture that stands askew), or until the beam was
aligned anew between two runs (ISO 230-1, alignment of the beam).
"""

import numpy as np

from postproc.effects import State
from postproc.effects._named import by_name

PARAMETERS = {
    "ppm": "um/m, never above zero: minus half the square of the angle",
    "file": "number of the recording, 0 the first; -1: all",
    "last": "number of the last run before the beam was aligned anew, 0: it was not",
    "touched": (
        "1, a step gauge stood askew: readings are too long; 0, a beam or a scale: too short"
    ),
}
# A reflector that goes d off sends the beam back 2 d off, and of a beam of 6 mm less than 4 mm off
# is still seen: d = 2 mm. On the shortest travel that is measured so, 100 mm, that is an angle of
# 0.02, and half its square 200 ppm; on 1 m 2 ppm.
PLAUSIBLE = {"ppm": (-200.0, 0.0)}  # beyond, it is something else
OPTIONAL = {"file": -1.0, "last": 0.0, "touched": 0.0}
# twice the logarithm of how much likelier a beam is aligned once for all runs than anew
ONCE = 2.0
MOST_RUNS = 8  # of a recording in which an alignment between two of them is looked for
PLAIN = {"last": 0.0, "touched": 0.0}
KIND, USE, PER = "instrument", "recording", "axis"
LINE = True  # of a line along which several axes move it belongs to none
NEEDS, SEES = ("position",), ("laser",)
TEXT = (
    "What measured the length was not parallel to the axis. "
    "Align it over the whole travel; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    read = np.unique(state.file[state.beam > 0])
    moving = {f: _along(state, state.file == f) for f in read}
    own = [f for f in read if moving[f] == [axis] or (not axis and len(moving[f]) != 1)]
    found = [{"file": float(f)} | PLAIN for f in own]
    found += [{"file": -1.0} | PLAIN] if 1 < len(own) == len(read) else []
    for f in own:
        here = state.file == f
        if np.any(state.channels.get("faces", 0.0) * here > 0):
            found.append({"file": float(f), "last": 0.0, "touched": 1.0})
        lit = np.any(state.channels.get("lit", 1.0) * here > 0)
        runs = np.unique(state.run[here])
        anew = runs[:-1] if lit and len(runs) <= MOST_RUNS else runs[:0]
        found += [{"file": float(f), "last": float(k), "touched": 0.0} for k in anew]
    return found


def further_cost(axis: str, shape: dict[str, float]) -> float:
    """Twice the logarithm of how much seldomer a shape is than the others of this effect."""
    return 0.0 if shape["last"] else -ONCE


def _along(state: State, own: np.ndarray) -> list[str]:
    """The axes that move with the beam's length; what changes from line to line does not."""
    # 0.7 of a correlation: along a diagonal of two axes each goes with the beam by all of it, an
    # axis that steps from line to line by nothing.
    beam = state.beam[own] - state.beam[own].mean()
    found = []
    for x, p in state.position.items():
        way = p[own] - p[own].mean()
        if np.ptp(way) > 1e-6 and abs(float(beam @ way)) > 0.7 * float(
            np.linalg.norm(beam) * np.linalg.norm(way)
        ):
            found.append(x)
    return found


def columns(
    state: State, axis: str, file: float = -1.0, last: float = 0.0, touched: float = 0.0
) -> np.ndarray:
    own = ((state.file == file) | (file < 0)) & ((state.run <= last) | (last <= 0))
    return (state.beam * own * (-1e-6 if touched else 1e-6))[None]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "ppm")
