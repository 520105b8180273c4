"""Clock skew: the clock of the recording runs faster or slower than the control's; it comes to be
late, in all axes alike.

A clock that is set right at even times, over a network or by a pulse, is late as a saw-tooth
(Mills, Internet time synchronization: the network time protocol, IEEE Trans. Communications 39,
1991, 1482). The rate of a quartz changes as it warms up or is slewed back: then it is late by the
square of the time as well (Allan, Time and frequency characterization of precision clocks, IEEE
Trans. UFFC 34, 1987, 647).
"""

from itertools import product

import numpy as np

from postproc.effects import State, along, grid, sampled
from postproc.effects._named import by_name
from postproc.effects.delay import PLAUSIBLE as PLAUSIBLE_DELAY

PARAMETERS = {
    "ppm": "us per s, how much slower the recording's clock runs",
    "whole": "1, the clocks were set alike at the start of the experiment; 0, of each recording",
    "every_s": "s, after which the recording's clock is set right; 0, it is not",
    "gone": "1, share of that time that is gone at the start of each recording",
    "drift_us_s2": "us per s2, half of what its rate changes by",
    "drifts": "1, its rate changes; 0, it does not",
}
OPTIONAL = {"whole": 0.0, "every_s": 0.0, "gone": 0.0, "drift_us_s2": 0.0, "drifts": 0.0}
SETS, GONE = (1.25, 4.5, 7), (0.05, 0.2, 0.4, 0.6, 0.8)  # times in the longest recording
CONTINUOUS = {"every_s": (0.1, 1e5), "gone": (0.01, 0.99)}
# Quartzes differ by 100 ppm, clocks of software by a few hundred (unverified).
PLAUSIBLE = {"ppm": (-1000.0, 1000.0)}  # beyond, it is something else
LATEST = PLAUSIBLE_DELAY["delay_ms"][1]  # ms, just before it is set right: no more than a delay
KIND, USE, PER = "data", "recording", "all"
NEEDS, SEES = ("velocity", "time"), ("scale", "trace")
TEXT = (
    "The two clocks do not run alike. Align the recording with reversals at its start and its end;"
    " correct the recording, not the machine."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    never = {"every_s": 0.0, "gone": 0.0, "drifts": 0.0}
    found = [{"whole": 0.0} | never]
    found += [{"whole": 1.0} | never] if len(np.unique(state.file)) > 1 else []
    moving = state.file[state.passage >= 0] if len(state.passage) else np.zeros(0)
    longest = max(
        (float(np.ptp(state.time[state.file == f])) for f in np.unique(moving)), default=0
    )
    # late in all axes alike: of one that moves alone a saw-tooth of time may be anything
    alike = sum(bool(np.any(v[sampled(state)])) for v in state.velocity.values()) > 1
    ways = product(grid(*SETS), GONE) if longest > 0 and alike else ()
    return found + [
        {"whole": 0.0, "every_s": longest / n, "gone": g, "drifts": 0.0} for n, g in ways
    ]


def fuller(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same clock with a rate that changes, where each recording begins on time and nothing
    sets it right."""
    own = not shape["whole"] and not shape["every_s"] and not shape["drifts"]
    return [shape | {"drifts": 1.0}] if own else []


def sensible(ppm: float, every_s: float = 0.0, **_: float) -> bool:
    """Whether a clock that is set right comes to be no later than a recording may be."""
    return abs(ppm) * every_s * 1e-3 <= LATEST


def columns(
    state: State,
    axis: str,
    whole: float = 0.0,
    every_s: float = 0.0,
    gone: float = 0.0,
    drifts: float = 0.0,
) -> np.ndarray:
    elapsed = state.time.astype(float)
    for file in () if whole else np.unique(state.file):
        own = state.file == file
        elapsed[own] -= state.time[own].min()
    if every_s > 0:
        #    late ^   /|   /|   /|      a saw-tooth: `gone` says where in it the recording begins
        #         | /  | /  | /  |
        #         +----+----+----+-->  every_s
        times = elapsed / every_s + gone
        # what is never set right in a recording is a rate and a delay
        elapsed = every_s * (times % 1.0) * bool(times.max(initial=0.0) >= 1.0)
    powers = [elapsed, elapsed**2] if drifts else [elapsed]
    return sum(
        # us times mm/s is 1e-3 um. What is recorded late stands where the axis was before: behind,
        # against the speed.
        (along(x, *(-v * p * 1e-3 for p in powers)) for x, v in state.velocity.items()),
        np.zeros((len(powers), 3, len(state))),
    )


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, "ppm", "drift_us_s2", second_if="drifts")
