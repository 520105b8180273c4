"""Spindle growth: the spindle and its head grow with speed and time (ISO 230-3).

What bearings turn into heat goes with speed where the load rubs, and with speed to 5/3 where the oil does (Palmgren: torque with
speed to 2/3).
"""

from itertools import pairwise

import numpy as np

from postproc.effects import State, along, grid

PARAMETERS = {
    "um_per_1000_rpm": "um per 1000 rpm, growth when it is warm",
    "tau_s": "s, the time in which it warms",
    "housing_um": "um per 1000 rpm, growth of the housing, which follows later",
    "housing_s": "s, the time in which the housing follows; 0, it does not",
    "power": "1, heat goes with speed; 5/3, with that power of it, and um per 1000 rpm holds at the fastest",
    "fastest_rpm": "1/min, the fastest speed",
}
OPTIONAL = {"housing_um": 0.0, "housing_s": 0.0, "power": 1.0, "fastest_rpm": 1000.0}
# 0.7 m of head and spindle of steel, 35 K warmer, are 280 um; those who grow 50 um at 1000 rpm do not turn ten times as fast.
MOST_UM = 300.0  # at the fastest
PLAUSIBLE = {"um_per_1000_rpm": (-50.0, 50.0), "housing_um": (-50.0, 50.0)}  # beyond, it is something else (unverified)
CONTINUOUS = {"tau_s": (200.0, 7200.0), "power": (1.0, 2.0)}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("time", "spindle_rpm"), ("tool", "part")
RESTING = True
TEXT = "The spindle grows while it runs. Warm it up before the zero is touched, or compensate by speed and time."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    if not state.channels["spindle_rpm"].any():
        return []
    fastest = float(state.channels["spindle_rpm"].max())
    several = len(np.unique(state.channels["spindle_rpm"])) > 2  # beside standing still
    return [
        {"tau_s": v, "housing_s": h, "power": p, "fastest_rpm": fastest}
        for v in grid(300.0, 4800.0, 4) for h in ((0.0, 3600.0) if v < 1000 else (0.0,)) for p in ((1.0, 5 / 3) if several else (1.0,))
    ]  # fmt: skip


def sensible(um_per_1000_rpm: float, housing_um: float, fastest_rpm: float, **_: float) -> bool:
    """Whether it grows by no more than a head can."""
    return max(abs(um_per_1000_rpm), abs(housing_um)) * fastest_rpm / 1000.0 <= MOST_UM


def columns(
    state: State, axis: str, tau_s: float, housing_s: float = 0.0, power: float = 1.0, fastest_rpm: float = 1000.0
) -> np.ndarray:
    rpm, t = state.channels["spindle_rpm"] / 1000.0, state.time
    rpm = rpm * (1000.0 * rpm / fastest_rpm) ** (power - 1.0) if fastest_rpm > 0 else rpm
    order = np.argsort(t, kind="stable")
    warm, late = np.zeros(len(t)), np.zeros(len(t))
    level = slow = 0.0
    for before, k in pairwise(order):
        gone = t[k] - t[before]
        level += (rpm[before] - level) * (1.0 - np.exp(-gone / tau_s))
        warm[k] = level
        if housing_s > 0:
            slow += (level - slow) * (1.0 - np.exp(-gone / housing_s))
            late[k] = slow
    return along(axis, warm, late) if housing_s > 0 else along(axis, warm)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    housing = float(coefficients[1]) if len(coefficients) > 1 else 0.0
    return {
        "um_per_1000_rpm": float(coefficients[0]),
        "housing_um": housing,
        "power": 1.0,
        "fastest_rpm": 1000.0,
    } | shape


def coefficients(
    um_per_1000_rpm: float, tau_s: float, housing_um: float = 0.0, housing_s: float = 0.0, power: float = 1.0,
    fastest_rpm: float = 1000.0,
) -> tuple[np.ndarray, dict[str, float]]:  # fmt: skip
    value = np.array([um_per_1000_rpm, housing_um] if housing_s > 0 else [um_per_1000_rpm])
    return value, {"tau_s": tau_s, "housing_s": housing_s, "power": power, "fastest_rpm": fastest_rpm}
