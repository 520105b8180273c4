"""Dead path: the air between interferometer and zero changed; the same error at every place."""

import numpy as np

from postproc.effects import State, by_name, first_timed, low_pass

PARAMETERS = {
    "um_K": "um per K, reading over the temperature of the air",
    "file": "number of the recording, 0 the first; -1: all",
    "late_s": (
        "s, by which the sensor that compensates for the air is late; 0, the air is not"
        " compensated for"
    ),
}
OPTIONAL = {"file": -1.0, "late_s": 0.0}
LATE = 1800.0  # s: a sensor in a heavy housing
# 0.93 ppm/K of air (Edlen), and 10 m of it.
PLAUSIBLE = {"um_K": (-10.0, 10.0)}  # beyond, it is something else
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = ("time", "T_air_C"), ("laser",)
TEXT = (
    "The dead path of the laser was not compensated. "
    "Set the interferometer close to the reflector's zero; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    lit = np.unique(state.file[state.beam > 0])
    files = [float(f) for f in lit] + ([-1.0] if len(lit) > 1 else [])
    return [{"file": f, "late_s": v} for f in files for v in (0.0, LATE)]


def columns(state: State, axis: str, file: float = -1.0, late_s: float = 0.0) -> np.ndarray:
    air = state.channels["T_air_C"]
    own = (state.file == file) | (file < 0)
    changed = air - air[first_timed(state)]
    if late_s > 0:
        changed = changed - low_pass(state, changed, late_s)
    return (changed * own * 1e-3)[None]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "um_K")
