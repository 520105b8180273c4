"""Force compliance: a deflection with the load or cutting force along the axis, whichever was
recorded; where both were, either of them or their sum.

Bolted and guided joints give in proportion; rolling contacts less for every newton more: as the
load to 2/3 (Hertz), and what is made of both in between.
"""

import numpy as np

from postproc.effects import State, along, loads
from postproc.effects._named import by_name

PARAMETERS = {
    "um_per_N": "um per N, deflection along the axis at the usual load",
    "power": "1, the power of the load by which it grows: 1 a spring, 2/3 a ball between planes",
    "usual_N": "N, the usual load",
    "by": (
        "0, the force; 1, the load; 2, both together; where only one of them was recorded, that one"
    ),
}
OPTIONAL = {"power": 1.0, "usual_N": 1.0, "by": 0.0}
# A light router gives 1 mm for 100 N at its tool; a machine of steel 0.001 to 0.1 um per N.
# beyond, it is something else (unverified: usual stiffnesses)
PLAUSIBLE = {"um_per_N": (-10.0, 10.0)}
SEVERAL = 1.2  # times the smallest load: another one
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("force",), ("tool",)
RESTING = True
TEXT = (
    "The axis gives way under load. Less force, a stiffer set-up; part of it can be measured with a"
    " weight."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    result = []
    for by in (0.0, 1.0, 2.0) if len(loads(state, axis)) > 1 else (0.0,):
        load = np.abs(_load(state, axis, by))
        pressed = load[load > 0.05 * float(load.max(initial=0.0))]
        usual = float(np.median(pressed)) if len(pressed) else 1.0
        # one load and none tell a size, and by which power it grows they do not
        several = len(pressed) > 0 and float(pressed.max()) > SEVERAL * float(pressed.min())
        powers = (1.0, 0.8, 2 / 3) if several else (1.0,)
        result += [{"power": p, "usual_N": usual, "by": by} for p in powers]
    return result


def _load(state: State, axis: str, by: float) -> np.ndarray:
    """(N,) N: what pushes."""
    force, load = f"force_{axis}_N", f"load_{axis}_N"
    if by == 2 and force in state.channels and load in state.channels:
        return state.channels[force] + state.channels[load]
    if load in state.channels and (by == 1 or not np.any(state.channels.get(force, 0.0))):
        return state.channels[load]
    return state.channels[force]


def columns(
    state: State, axis: str, power: float = 1.0, usual_N: float = 1.0, by: float = 0.0
) -> np.ndarray:
    load = _load(state, axis, by)
    # the power is taken of load / usual, so that the size stays um per N at the usual load
    return along(axis, np.sign(load) * usual_N * (np.abs(load) / usual_N) ** power)


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "um_per_N")
