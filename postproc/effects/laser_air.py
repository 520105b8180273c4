"""Laser air: light is faster in warm air, so a length reads short by 0.93 ppm per K and long by
0.27 ppm per hPa (Edlen).

One cause in every set-up of a laser, along whatever axis: by the temperature of the air where it
was recorded, else by what the air did while each recording lasted; and by what the laser was told
wrong from the first reading on, or by all that the air differs from 20 degrees.
"""

import numpy as np

from postproc.effects import State
from postproc.effects._named import by_name

REFERENCE = 20.0  # degrees C (ISO 1)
FILES = 8  # recordings of a laser whose air may change, each in its own way
PARAMETERS = {
    "ppm_K": (
        "um/(m K), reading over beam length and the air's temperature since the recording's first"
        " reading, or above 20 degrees (by = 2)"
    ),
    "wrong_ppm": ("um/m, error of the air that was set in the laser, from the first reading on"),
    "told": "1, other air was set in the laser; 0, the right one",
    "by": (
        "1, the air changed with its recorded temperature; 2, the laser was left at 20 degrees in"
        " all recordings, whatever the air's recorded temperature; 0, it did not change; below"
        " zero: it changed with the time, in each of the laser's recordings in its own way"
    ),
    **{
        f"ppm_h_{k}": f"um/(m h), by which the air changed in the laser's recording {k}"
        for k in range(1, FILES + 1)
    },
}
EXPECTED = {"ppm_K": -1}
PLAUSIBLE = {"ppm_K": (-30.0, 30.0), "wrong_ppm": (-150.0, 150.0)}  # beyond, it is something else
RATES = tuple(f"ppm_h_{k}" for k in range(1, FILES + 1))
OPTIONAL = {"ppm_K": 0.0, "told": 0.0, "wrong_ppm": 0.0, "by": 1.0} | dict.fromkeys(RATES, 0.0)
KIND, USE, PER = "instrument", "recording", "all"
NEEDS, SEES = (), ("laser",)
LIGHT = True
TEXT = (
    "The air along the beam changed, or was not the air that is set in the laser. "
    "Use the laser's weather station; correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    lit = _lit(state)
    air = state.channel("T_air_C")
    known = air is not None and all(np.ptp(air[state.file == f]) > 0 for f in lit)
    lasting = 0 < len(lit) <= FILES and all(np.ptp(state.time[state.file == f]) > 0 for f in lit)
    # A thermometer that lags, and the pressure that nobody records: the air may change as the time
    # goes, too.
    own = np.isin(state.file, lit)
    several = air is not None and len(lit) > 1 and np.ptp(air[own]) > 0
    ways = [
        *([1.0] if known else []),
        *([2.0] if several else []),
        *([-float(len(lit))] if lasting else []),
    ]
    return [{"told": t, "by": by} for by in ways for t in (0.0, 1.0)] + [{"told": 1.0, "by": 0.0}]


def _lit(state: State) -> np.ndarray:
    """The recordings in which a beam of light grows longer."""
    return np.unique(state.file[light(state) > 0])


def light(state: State) -> np.ndarray:
    """(N,) mm: length of the beam, of what reads by light."""
    return state.beam * state.channels.get("lit", 1.0)


def columns(state: State, axis: str, told: float = 0.0, by: float = 1.0) -> np.ndarray:
    found = []
    if by == 2:
        found.append(state.channels["T_air_C"] - REFERENCE)
    if by == 1:
        grown = np.zeros(len(state))
        for file in np.unique(state.file):
            grown += _since(state, state.channels["T_air_C"], file)
        found.append(grown)
    if by < 0:
        lit = _lit(state)[: int(-by)]
        found += [_since(state, state.time / 3600.0, file) for file in lit]
        # a rate that a recording without light has: no column may be missing, as coefficients count
        # them
        found += [np.zeros(len(state))] * (int(-by) - len(lit))
    # ppm of the beam's length, mm: the reading, not the tool, is off
    beam = light(state) * 1e-6
    return np.stack([v * beam for v in found] + ([beam] if told else []))


def _since(state: State, driver: np.ndarray, file: float) -> np.ndarray:
    """(N,) what a driver (N,) changed by since the first reading of a recording; elsewhere zero."""
    own = np.flatnonzero(state.file == file)
    changed = np.zeros(len(state))
    changed[own] = driver[own] - driver[own[np.argmin(state.time[own])]]
    return changed


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    drifts = ("ppm_K",) if named["by"] > 0 else RATES[: int(-named["by"])]
    return (*drifts, "wrong_ppm") if named["told"] else drifts


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "ppm_K", *RATES, "wrong_ppm", of=_fitted)
