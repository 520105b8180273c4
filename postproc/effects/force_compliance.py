"""Force compliance: a deflection with the load or cutting force along the axis.

Bolted and guided joints give in proportion; rolling contacts less for every newton more: as the load to 2/3 (Hertz), and what is
made of both in between.
"""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "um_per_N": "um per N, deflection along the axis at the usual load",
    "power": "1, the power of the load by which it grows: 1 a spring, 2/3 a ball between planes",
    "usual_N": "N, the usual load",
}
OPTIONAL = {"power": 1.0, "usual_N": 1.0}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("force",), ("tool",)
TEXT = "The axis gives way under load. Less force, a stiffer set-up; part of it can be measured with a weight."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    load = np.abs(state.channels[f"force_{axis}_N"])
    pressed = load[load > 0.05 * float(load.max(initial=0.0))]
    usual = float(np.median(pressed)) if len(pressed) else 1.0
    return [{"power": p, "usual_N": usual} for p in (1.0, 0.8, 2 / 3)]


def columns(state: State, axis: str, power: float = 1.0, usual_N: float = 1.0) -> np.ndarray:
    load = state.channels[f"force_{axis}_N"]
    return along(axis, np.sign(load) * usual_N * (np.abs(load) / usual_N) ** power)


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"um_per_N": float(coefficients[0]), "power": shape.get("power", 1.0), "usual_N": shape.get("usual_N", 1.0)}


def coefficients(um_per_N: float, power: float = 1.0, usual_N: float = 1.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([um_per_N]), {"power": power, "usual_N": usual_N}
