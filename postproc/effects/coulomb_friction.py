"""Coulomb friction: the axis stays behind by the friction over the stiffness of its drive, in motion and after it.

A drive without integral action does not make up for it. After a turn the friction is taken up over a little way (pre-sliding),
or as fast as the position loop settles.
"""

import numpy as np

from postproc.effects import State, along, sampled, settled, taken_up

PARAMETERS = {
    "size_um": "um, difference between the two directions",
    "play_mm": "mm, way after a turn over which the friction turns round",
    "settle_ms": "ms, time constant with which the loop settles after a turn",
}
OPTIONAL = {"play_mm": 0.0, "settle_ms": 0.0}
SMALL = 0.05  # mm
SOON = 0.05  # s
# Friction over the stiffness of a loop: what a belt gives, see windup.
PLAUSIBLE = {"size_um": (-1000.0, 1000.0)}  # beyond, it is something else
EXPECTED = {"size_um": 1}
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = "Friction holds the axis back while it moves. Lubrication and preload; friction compensation in the drive."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near, since = state.distance.get(axis), state.since.get(axis)
    ways = (0.0, 0.01, 0.03, 0.1) if near is not None and np.any(near < SMALL) else (0.0,)
    times = (4.0, 8.0, 16.0, 32.0) if since is not None and np.any(since < SOON) else ()
    return [{"play_mm": v, "settle_ms": 0.0} for v in ways] + [{"play_mm": 0.0, "settle_ms": v} for v in times]


def columns(state: State, axis: str, play_mm: float = 0.0, settle_ms: float = 0.0) -> np.ndarray:
    share = taken_up(state, axis, play_mm) if play_mm > 0 else settled(state, axis, settle_ms)
    return along(axis, -state.approach[axis] / 2 * share * sampled(state))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    return {"size_um": float(coefficients[0]), "play_mm": shape["play_mm"], "settle_ms": shape["settle_ms"]}


def coefficients(size_um: float, play_mm: float = 0.0, settle_ms: float = 0.0) -> tuple[np.ndarray, dict[str, float]]:
    return np.array([size_um]), {"play_mm": play_mm, "settle_ms": settle_ms}
