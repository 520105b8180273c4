"""Servo mismatch: two axes follow with different lags; a circle becomes an ellipse at 45 degrees
that turns over with the sense (ISO 230-4).

A circle shows the difference alone. Where each axis shows by itself one leads and the other lags,
by no equal amounts: their mean is the lag of both. Two axes that both lag are two lags.
"""

import numpy as np

from postproc.effects import State, along, followed, settling
from postproc.effects._named import by_name

PARAMETERS = {
    "delta_tau_ms": "ms, lag of the first axis minus that of the second",
    "mean_tau_ms": "ms, mean lag of both",
    "unequal": "1, they lag in the mean; 0, one leads by as much as the other lags",
    "settle_ms": "ms, time constant with which the lags come and go; 0: at once",
}
OPTIONAL = {"mean_tau_ms": 0.0, "unequal": 0.0, "settle_ms": 0.0}
CONTINUOUS = {"settle_ms": (0.5, 250.0)}
FORM = 0.05  # see servo_lag
# No more than the lag of one of the axes, of which the other has at least half on any machine that
# can go round (unverified).
PLAUSIBLE = {"delta_tau_ms": (-125.0, 125.0)}  # beyond, it is something else
fuller = settling
KIND, USE, PER = "machine", "simulate", "pair"
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = "Two axes follow with different lags. Match the position gains of the two drives."


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return [{"unequal": u, "settle_ms": 0.0} for u in (0.0, 1.0)]


def sensible(delta_tau_ms: float, mean_tau_ms: float = 0.0, **_: float) -> bool:
    """Whether one leads and the other lags."""
    return 2 * abs(mean_tau_ms) <= abs(delta_tau_ms)


def columns(state: State, axis: str, unequal: float = 0.0, settle_ms: float = 0.0) -> np.ndarray:
    speeds = (state.velocity[x] for x in axis)
    if settle_ms > 0:
        speeds = (followed(state, v, settle_ms * 1e-3) for v in speeds)
    first, second = (along(x, -v) for x, v in zip(axis, speeds, strict=True))
    # + half of the difference of the first, - half of the second: their mean is no part of it
    half = (first - second) / 2
    return np.concatenate([half, first + second]) if unequal else half


parameters, coefficients = by_name(
    PARAMETERS, OPTIONAL, "delta_tau_ms", "mean_tau_ms", second_if="unequal"
)
