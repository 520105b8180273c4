"""Structure drift: the whole frame creeps with the room or with time, wherever the slides stand
(ISO 230-3).

What comes with time comes as a body warms up, with a time constant; a column whose front warms up
before its back bends out and part of the way back, with two (Bryan, International status of thermal
error research, CIRP Annals 39, 1990, 645; Mayr and others, Thermal issues in machine tools, CIRP
Annals 61, 2012, 771).
"""

from functools import wraps

import numpy as np

from postproc.effects import (
    State,
    along,
    amplitude_and_phase,
    first_timed,
    grid,
    harmonic_coefficients,
    low_pass,
)
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": (
        "um per K, drift over the temperature of bed or room; where none is recorded um at the end"
    ),
    "tau_s": (
        "s, 0: by the recorded temperature of the bed; below zero: by that of the air, so many"
        " seconds late; else the time in which it comes"
    ),
    "from_s": "s, when it begins, for what comes with time",
    "file": "number of the one recording in which it goes with its time, 0 the first; -1: all",
    "bend_um": "um, its share with the square of that time",
    "creep": (
        "1, with the logarithm of 1 + time over tau_s, as castings and clamps settle; 0, not so"
    ),
    "cycle_s": (
        "s, period of a room's heating or cooling that switches; 0, none; size_um is then its"
        " amplitude (zero to peak)"
    ),
    "phase_deg": "degrees, of a cosine at t = 0",
    "back_um": "um, at the end, of what follows later",
    "back_s": "s, the time in which that comes; 0, there is none",
}
OPTIONAL = {
    "back_um": 0.0, "back_s": 0.0, "from_s": -1.0, "file": -1.0, "bend_um": 0.0, "creep": 0.0,
    "cycle_s": 0.0, "phase_deg": 0.0,
}  # fmt: skip
CYCLES = (
    600.0,
    3600.0,
    12,
)  # s: rooms' heating and cooling switch every 10 min to 1 h (ISO/TR 16015: variations of the room)
CONTINUOUS = {"cycle_s": CYCLES[:2], "tau_s": (60.0, 30000.0)}
TAUS = (0.05, 0.2, 0.7)  # of what was recorded
# s: the thinnest walls of a machine follow heat within minutes, beds within hours (Mayr 2012); what
# comes within a shorter test is no drift of a frame (ISO 230-3 records for hours)
QUICKEST, SHORTEST = 60.0, 300.0
BACK = 4.0  # times the time constant: in which the back follows
SWINGS = 1.5  # of a cycle: fewer are a drift
FRAME = ("T_bed_C", "T_frame_C", "T_base_C", "T_column_C")
CREEPS = (300.0, 3000.0)  # s
# 2 m of steel grow by 23 um for 1 K, of aluminium by 46; what comes with time is that of some K.
MOST_K = 50.0  # um per K
PLAUSIBLE = {
    "size_um": (-300.0, 300.0),
    "bend_um": (-300.0, 300.0),
    "back_um": (-300.0, 300.0),
}  # beyond, it is something else
NONE = {"tau_s": 1.0, "from_s": -1.0, "file": -1.0, "creep": 0.0, "cycle_s": 0.0, "back_s": 0.0}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("time",), ("tool", "part")
RESTING = True
TEXT = (
    "The frame moves with the room's temperature or with time. "
    "A steady room, a warm-up, probing of the zero between cuts."
)


# Whole: a list of shapes, a condition to each.
def shapes(state: State, axis: str) -> list[dict[str, float]]:
    if not len(state.time):
        return []
    files = np.unique(state.file)
    first = float(state.time[first_timed(state)])
    starts = sorted({float(state.time[state.file == f].min()) for f in files})
    begins = [-1.0, *(t for t in starts if t > first)]
    ways = [(0.0, -1.0, -1.0)] if state.channel(*FRAME) is not None else []
    if state.channel("T_air_C") is not None:
        ways += [(-v, -1.0, -1.0) for v in (QUICKEST, 1000.0, 3000.0, 9000.0)]
    lasts = float(np.ptp(state.time))
    if 0 < lasts < SHORTEST:
        return []
    taus = [share * lasts for share in TAUS if share * lasts > QUICKEST]
    # 1e6 s, longer than any test: heat that has only begun to come, a line
    ways += [(v, b, -1.0) for b in begins for v in (*taus, 1e6)]
    ways += [(1e6, -1.0, float(f)) for f in files if len(files) > 1]
    found = [NONE | {"tau_s": tau, "from_s": begin, "file": file} for tau, begin, file in ways]
    found += [NONE | {"tau_s": v, "creep": 1.0} for v in CREEPS]
    found += [NONE | {"tau_s": v, "back_s": BACK * v} for v in taus[:-1]]
    return found + [NONE | {"cycle_s": v} for v in grid(*CYCLES) if SWINGS * v < lasts]


def sensible(size_um: float, tau_s: float, file: float = -1.0, **_: float) -> bool:
    """Whether a frame can be so large."""
    return abs(size_um) <= MOST_K or tau_s > 0 or file >= 0


def columns(
    state: State,
    axis: str,
    tau_s: float,
    from_s: float = -1.0,
    file: float = -1.0,
    creep: float = 0.0,
    cycle_s: float = 0.0,
    back_s: float = 0.0,
) -> np.ndarray:
    if cycle_s > 0:
        angle = 2 * np.pi * state.time / cycle_s
        return along(axis, np.cos(angle) * _timed(state), np.sin(angle) * _timed(state))
    bed, air = state.channel(*FRAME), state.channel("T_air_C")
    if file >= 0:
        own = state.file == file
        t = state.time[own]
        # parts have no times: their numbers stand for them, in equal steps
        if not len(t):  # of a recording that is not among these
            return along(axis, np.zeros(len(own)), np.zeros(len(own)))
        if not np.ptp(t):  # parts that were turned one after the other
            t = np.where(_turned(state)[own], state.channels.get("part", state.time)[own], np.nan)
        gone = np.zeros(len(own))
        if np.isfinite(t).any():
            gone[own] = np.nan_to_num(
                (t - np.nanmin(t)) / max(float(np.nanmax(t) - np.nanmin(t)), 1.0)
            )
        return along(axis, gone, gone**2)
    if tau_s < 0 and air is not None:
        return along(axis, low_pass(state, air - air[first_timed(state)], -tau_s) * _timed(state))
    if tau_s == 0 and bed is not None:
        return along(axis, (bed - bed[first_timed(state)]) * _timed(state))
    tau = max(tau_s, 1.0)
    gone = np.maximum(state.time - (state.time[first_timed(state)] if from_s < 0 else from_s), 0.0)
    if creep:
        return along(axis, np.log1p(gone / tau) / np.log1p(max(float(gone.max()), 1.0) / tau))
    # Divided by its value at the end, so that the size is um at the end whatever the time constant:
    # of 1e6 s it is a straight line.
    end = max(float(gone.max()), 1.0)
    taus = (tau, back_s) if back_s > 0 else (tau,)
    return along(axis, *((1.0 - np.exp(-gone / t)) / (1.0 - np.exp(-end / t)) for t in taus))


def _timed(state: State) -> np.ndarray:
    """(N,) bool: all but parts, whose temperature when they were cut is unknown."""
    return state.channels.get("wall", np.zeros(len(state))) == 0


def _turned(state: State) -> np.ndarray:
    """(N,) bool: diameters of a lathe, which are twice what its slide is off by; what lies between
    two walls keeps its size."""
    wall, material = (
        state.channels.get(name, np.zeros(len(state))) for name in ("wall", "material")
    )
    return (wall != 0) & (material == 0)


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    if named["cycle_s"] > 0:
        return "size_um", "phase_deg"
    if named["back_s"] > 0:
        return "size_um", "back_um"
    return ("size_um", "bend_um") if named["file"] >= 0 else ("size_um",)


_named, _taken = by_name(
    PARAMETERS, OPTIONAL, "size_um", "bend_um", "phase_deg", "back_um", of=_fitted
)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    if shape.get("cycle_s", 0.0) > 0:
        coefficients = np.array([*amplitude_and_phase(coefficients).values()])
    return _named(coefficients, shape)


@wraps(_taken)
def coefficients(**named: float) -> tuple[np.ndarray, dict[str, float]]:
    value, shape = _taken(**named)
    return (harmonic_coefficients(*value) if shape["cycle_s"] > 0 else value), shape
