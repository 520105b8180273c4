"""Spindle growth: the spindle and its head grow with speed and time (ISO 230-3)."""

from itertools import pairwise

import numpy as np

from postproc.effects import State, along, grid

PARAMETERS = {
    "um_per_1000_rpm": "um per 1000 rpm, growth when it is warm",
    "tau_s": "s, the time in which it warms",
}
PLAUSIBLE = {"um_per_1000_rpm": (-200.0, 200.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("time", "spindle_rpm"), ("tool", "part")
TEXT = "The spindle grows while it runs. Warm it up before the zero is touched, or compensate by speed and time."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"tau_s": v} for v in grid(300.0, 4800.0, 4)] if state.channels["spindle_rpm"].any() else []


def columns(state: State, axis: str, tau_s: float) -> np.ndarray:
    rpm, t = state.channels["spindle_rpm"] / 1000.0, state.time
    order = np.argsort(t, kind="stable")
    level, value = 0.0, np.zeros(len(t))
    for before, k in pairwise(order):
        level += (rpm[before] - level) * (1.0 - np.exp(-(t[k] - t[before]) / tau_s))
        value[k] = level
    return along(axis, value)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"um_per_1000_rpm": float(coefficients[0]), "tau_s": shape["tau_s"]}


def coefficients(um_per_1000_rpm: float, tau_s: float) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([um_per_1000_rpm]), {"tau_s": tau_s}
