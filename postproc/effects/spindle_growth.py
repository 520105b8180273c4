"""Spindle growth: the spindle and its head grow with speed and time (ISO 230-3).

What bearings turn into heat goes with speed where the load rubs, and with speed to 5/3 where the
oil does (Palmgren: torque with speed to 2/3). With the square of the speed the balls of angular
contact bearings press outwards and shift the shaft, at once (Abele, Altintas and Brecher, Machine
tool spindle units, CIRP Annals 59 (2010) 781). Where the head's temperature is recorded, growth may
go with it.
"""

import math
from itertools import compress
from typing import Any

import numpy as np

from postproc.effects import State, along, first_timed, grid, recurrence
from postproc.effects._named import by_name

PARAMETERS = {
    "tau_s": "s, 0: by the recorded temperature, else the time in which it warms",
    "um_per_1000_rpm": "um per 1000 rpm, growth when it is warm",
    "um_per_K": "um/K, growth by the recorded temperature of spindle or head",
    "housing_um": "um per 1000 rpm, growth of the housing, which follows later",
    "housing_s": "s, the time in which the housing follows; 0, it does not",
    "shift_um": (
        "um, shift of the shaft at the fastest speed, at once and with the square of the speed"
    ),
    "shift": "1, the shaft shifts; 0, it does not",
    "power": (
        "1, the power of the speed that heat goes with; above 1, um per 1000 rpm holds at the"
        " fastest"
    ),
    "fastest_rpm": "1/min, the fastest speed, above 0",
}
SIZES = ("um_per_1000_rpm", "um_per_K", "housing_um", "shift_um")
OPTIONAL = {
    "um_per_1000_rpm": 0.0, "um_per_K": 0.0, "housing_um": 0.0, "housing_s": 0.0, "shift_um": 0.0,
    "shift": 0.0, "power": 1.0, "fastest_rpm": 1000.0,
}  # fmt: skip
PLACES = ("T_spindle_C", "T_head_C", "T_headstock_C")
# 0.7 m of head and spindle of steel, 35 K warmer, are 280 um; those who grow 50 um at 1000 rpm do
# not turn ten times as fast.
MOST_UM = 300.0  # at the fastest
ALIKE = 1e-4  # of a time constant
SEVERAL = 1.2  # times the slowest speed: another one
LATER = 4.0  # times the spindle's own: in which its housing follows
# The head that grows by its own temperature is no longer than 1 m of aluminium; a shaft shifts by
# its bearings' preload (unverified).
PLAUSIBLE = {  # beyond, it is something else (unverified)
    "um_per_1000_rpm": (-50.0, 50.0),
    "housing_um": (-50.0, 50.0),
    "um_per_K": (-25.0, 25.0),
    "shift_um": (-50.0, 50.0),
}
CONTINUOUS = {"tau_s": (200.0, 7200.0), "power": (1.0, 2.0)}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("time", "spindle_rpm"), ("tool", "part")
RESTING = True
TEXT = (
    "The spindle grows while it runs. Warm it up before the zero is touched, or compensate by speed"
    " and time."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    speed = np.abs(state.channels["spindle_rpm"])  # counter-clockwise a log may write it below zero
    if not speed.any():
        return []
    fastest = float(speed.max())
    turning = speed[speed > 0.05 * fastest]
    # beside standing still; a speed as it was recorded is never quite the same
    several = len(np.unique(speed)) > 2 and float(turning.min()) * SEVERAL < fastest
    powers = (1.0, 5 / 3) if several else (1.0,)
    ways = [(v, h, p) for v in grid(300.0, 4800.0, 4) for h in (0.0, LATER * v) for p in powers]
    if state.channel(*PLACES) is not None:
        # tau 0: a thermometer knows the lag, no time constant is looked for
        ways.append((0.0, 0.0, 1.0))
    return [
        {"tau_s": v, "housing_s": h, "shift": shift, "power": p, "fastest_rpm": fastest}
        for v, h, p in ways
        for shift in (0.0, 1.0)
    ]


def sensible(
    fastest_rpm: float, um_per_1000_rpm: float = 0.0, housing_um: float = 0.0, **_: float
) -> bool:
    """Whether it grows by no more than a head can."""
    return max(abs(um_per_1000_rpm), abs(housing_um)) * fastest_rpm / 1000.0 <= MOST_UM


def columns(
    state: State,
    axis: str,
    tau_s: float,
    housing_s: float = 0.0,
    shift: float = 0.0,
    power: float = 1.0,
    fastest_rpm: float = 1000.0,
) -> np.ndarray:
    rpm = state.channels["spindle_rpm"]
    share = np.abs(rpm) / max(fastest_rpm, 1.0)
    # the press of the balls is there with the speed, and goes with it; no lag
    at_once = [share**2] if shift else []
    if tau_s == 0:
        head = state.channel(*PLACES)
        return along(
            axis, np.zeros(len(rpm)) if head is None else head - head[first_timed(state)], *at_once
        )
    heat = share**power * fastest_rpm / 1000.0  # rpm / 1000 where power is 1
    warm, later = _warmed(state.time, heat, tau_s, housing_s)
    return along(axis, warm, *([later] if housing_s > 0 else []), *at_once)


def _warmed(
    t: np.ndarray, heat: np.ndarray, tau_s: float, housing_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """(N,), (N,): heat as it comes through the spindle, and on through its housing, solved from
    reading to reading, between which the heat stays."""
    order = np.argsort(t, kind="stable")
    warm, second_lag = np.zeros(len(t)), np.zeros(len(t))
    gone, hot, housing = np.diff(t[order]), heat[order[:-1]], apart(tau_s, housing_s)
    kept = np.exp(-gone / tau_s)
    level = recurrence(kept, (1.0 - kept) * hot)
    if len(t):
        warm[order] = level
    if housing > 0 and len(t):
        _, added = _lag(level[:-1], 0.0, hot, gone, tau_s, housing, np.exp)
        second_lag[order] = recurrence(np.exp(-gone / housing), added)
    return warm, second_lag


def apart(tau_s: float, housing_s: float) -> float:
    """The housing's time constant: two equal ones have another solution, and one a little longer is
    as near."""
    alike = housing_s > 0 and abs(housing_s / tau_s - 1.0) < ALIKE
    return tau_s * (1.0 + ALIKE) if alike else housing_s


def lagged(
    gone: np.ndarray, heat: np.ndarray, before: tuple[float, float], tau_s: float, housing_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """(N + 1,), (N + 1,): two first-order lags, one behind the other, from `before` on and behind
    each of N steps of `gone` (N,) s, in which the heat (N,) stays: solved exactly."""
    housing = apart(tau_s, housing_s)
    level, slow = before
    warm, second_lag = [level], [slow]
    for seconds, hot in zip(gone.tolist(), heat.tolist(), strict=True):
        level, slow = _lag(level, slow, hot, seconds, tau_s, housing, math.exp)
        warm.append(level)
        second_lag.append(slow)
    return np.array(warm), np.array(second_lag)


def later(
    level: np.ndarray,
    slow: np.ndarray,
    heat: np.ndarray,
    gone: np.ndarray,
    tau_s: float,
    housing_s: float,
) -> tuple[np.ndarray, np.ndarray]:
    """(K,), (K,): what becomes of K states of both lags, each after its own time (K,) s at its own
    heat (K,)."""
    housing = apart(tau_s, housing_s)
    return _lag(level, slow, heat, gone, tau_s, housing, np.exp)


def _lag(
    level: Any, slow: Any, heat: Any, gone: Any, tau_s: float, housing: float, exp: Any
) -> tuple[Any, Any]:
    """Both lags one step later."""
    above, first = level - heat, exp(-gone / tau_s)
    if housing > 0:
        second = exp(-gone / housing)
        #    heat --> [ spindle, tau ] -- level --> [ housing, h ] -- slow
        # slow' = (slow - level) / -h with level = heat + above exp(-t / tau): the particular
        # solution has the factor tau / (tau - h), which is why equal time constants are kept apart
        # (`apart`).
        through = above * tau_s / (tau_s - housing) * (first - second)
        slow = heat + through + (slow - heat) * second
    return heat + above * first, slow


def _as_driven(named: dict[str, float]) -> dict[str, float]:
    """The growth under the name that it has by its driver, whichever it was stated by."""
    warm = named["um_per_1000_rpm"] + named["um_per_K"]
    by_time = named["tau_s"] > 0
    sizes = {"um_per_1000_rpm": warm if by_time else 0.0, "um_per_K": 0.0 if by_time else warm}
    return named | sizes | {"shift": named["shift"] or float(named["shift_um"] != 0.0)}


def _fitted(named: dict[str, float]) -> list[str]:
    there = (named["tau_s"] > 0, named["tau_s"] <= 0, named["housing_s"] > 0, named["shift"])
    return list(compress(SIZES, there))


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted, first=_as_driven)
