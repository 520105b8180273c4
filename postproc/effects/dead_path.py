"""Dead path: the air between interferometer and zero changed; the same error at every place.

By the temperature of the air where it was recorded (Edlen), and by a pressure that nobody recorded,
which changes in proportion to time while a recording lasts (Steinmetz, Sub-micron position
measurement and control on precision machine tools with laser interferometry, Precision Engineering
12, 1990, 12). A mirror that stands shows it too.
"""

import numpy as np

from postproc.effects import State, first_timed, low_pass
from postproc.effects._named import by_name

PARAMETERS = {
    "um_K": "um per K, reading over the temperature of the air",
    "file": "number of the recording, 0 the first; -1: all",
    "late_s": (
        "s, time constant of the sensor that compensates for the air; 0, the air is not"
        " compensated for"
    ),
    "um_h": "um per hour, what the pressure made of it",
    "pressure": "1, the pressure changed; 0, it did not",
}
OPTIONAL = {"file": -1.0, "late_s": 0.0, "um_h": 0.0, "pressure": 0.0}
HOUSING_TAU = 1800.0  # s: a sensor in a heavy housing
# 0.93 ppm/K of air (Edlen), and 10 m of it; 0.27 ppm/hPa, and 10 hPa in an hour.
PLAUSIBLE = {"um_K": (-10.0, 10.0), "um_h": (-27.0, 27.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
LIGHT = True
TEXT = (
    "The dead path of the laser was not compensated. "
    "Set the interferometer close to the reflector's zero; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    lit = np.unique(state.file[(state.channels.get("lit", 1.0) > 0) & (state.passage < 0)])
    files = [float(f) for f in lit] + ([-1.0] if len(lit) > 1 else [])
    ways = ((0.0, 0.0), (HOUSING_TAU, 0.0), (0.0, 1.0))
    return [{"file": f, "late_s": v, "pressure": p} for f in files for v, p in ways]


def columns(
    state: State, axis: str, file: float = -1.0, late_s: float = 0.0, pressure: float = 0.0
) -> np.ndarray:
    air = state.channels["T_air_C"]
    own = (state.file == file) | (file < 0)
    changed = air - air[first_timed(state)]
    if late_s > 0:
        # a sensor that follows late has compensated for what it shows: the rest is left
        changed = changed - low_pass(state, changed, late_s)
    found = [changed * own]
    if pressure:
        gone = np.zeros(len(state))
        for f in np.unique(state.file[own]):
            here = state.file == f
            gone[here] = (state.time[here] - state.time[here].min()) / 3600.0
        found.append(gone)
    return np.stack(found) * 1e-3


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "um_K", "um_h", second_if="pressure")
