"""Friction that differs with the direction: after a turn the axis is held back more one way than
the other.

Like the spike of a reversal, with another height for each direction; where both are alike it is a
plain spike. A drive without integral action does not make up for it: then the axis lags all the
time, by what is rubbing in that direction; a film of grease rubs with a power of the speed below
one (see viscous_friction).
"""

import numpy as np

from postproc.effects import State, along, followed, grid, reversal_spike, sampled, settling
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": "um, mean height of the excursion after a turn",
    "slope_um": "um, its share that rises first",
    "difference_um": "um, by how much it is higher in +",
    "difference_slope_um": "um, its share that rises first",
    "tau_ms": (
        "ms, how long it lasts; 0, as long as it moves: then heights are lags, um, and slopes um"
        " per 100 mm/s"
    ),
    "released": (
        "1, at rest the axis does not lag, and what it lags more in one direction shows; 0, it does"
    ),
    "power": "1, of the speed that its slopes go with: then um at 100 mm/s; below 1 for grease",
    "length_mm": "mm, over which way it lasts, at any speed; 0, for a time, or as long as it moves",
    "settle_ms": "ms, time constant with which the loop settles, where it lags as long as it moves",
}
SIZES = ("size_um", "slope_um", "difference_um", "difference_slope_um")
OPTIONAL = {"released": 0.0, "power": 1.0, "length_mm": 0.0, "settle_ms": 0.0}
CONTINUOUS = {
    "tau_ms": (4.0, 600.0),
    "power": (0.3, 0.9),
    "length_mm": (0.01, 4.0),
    "settle_ms": (0.5, 250.0),
}
PLAUSIBLE = reversal_spike.PLAUSIBLE | {"difference_um": (-500.0, 500.0)}
UNLIKE = 0.15
# times the mean: friction opposes motion both ways, a weight that is not balanced pushes one way
OPPOSES = 3.0
POWERS = (1.0, 0.5)
ONE_WAY = 0.9  # of the mean: a spike after the turns of one direction alone is no friction
LIKE_SLOPE = 3.0  # a height that is there at all speeds holds as much at 33 mm/s as this slope
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("since", "approach", "velocity"), ("tool", "scale")
TEXT = (
    "Friction differs with the direction of motion. "
    "Balance weight, wiper, guideway strip; more integral action in the drive."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    plain = {"tau_ms": 0.0} | OPTIONAL
    found = [plain | {"tau_ms": v} for v in grid(6.0, 400.0, 9)]
    found += [plain | {"power": power} for power in POWERS]
    found += [plain | {"length_mm": v} for v in reversal_spike.ways(state, axis)]
    stands = np.any(sampled(state) & (state.velocity[axis] == 0))
    return [*found, plain | {"released": 1.0}] if stands else found


def fuller(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same of a loop that takes its time, or of friction that builds up over a way in it."""
    if shape["tau_ms"] <= 0 and shape["length_mm"] <= 0:
        return settling(shape, state, axis)
    like = {"rebounds": 0.0, "tau_ms": shape["tau_ms"], "length_mm": shape["length_mm"]}
    found = reversal_spike.fuller(like, state, axis)
    return [shape | {k: v for k, v in one.items() if k != "rebounds"} for one in found]


def columns(
    state: State,
    axis: str,
    tau_ms: float,
    released: float = 0.0,
    power: float = 1.0,
    length_mm: float = 0.0,
    settle_ms: float = 0.0,
) -> np.ndarray:
    s = state.approach[axis]
    if length_mm > 0 and tau_ms > 0:
        left, second_order = reversal_spike.of_loop(state, axis, tau_ms, length_mm)
        return along(axis, -left, -second_order, -left * s, -second_order * s)
    if length_mm > 0:
        q = np.minimum(state.distance[axis] / length_mm, 50.0)
        fade = np.exp(-q)
        return along(axis, -fade * s, -q * fade * s, -fade, -q * fade)
    v = state.velocity[axis] / 100.0
    if tau_ms <= 0 and power != 1.0:
        v = np.sign(v) * np.abs(v) ** power
    # Even and odd parts: what goes with the direction (s, v) is friction alike both ways, what does
    # not (1, |v|) is what differs between them.
    # how much more it lags in one direction whatever its speed is an unknown zero
    lags = (np.sign(v), np.sign(np.abs(v))) if released else (s * sampled(state), v, np.abs(v))
    if tau_ms <= 0:
        tau_s = settle_ms * 1e-3
        return along(axis, *(-(followed(state, u, tau_s) if tau_s > 0 else u) for u in lags))
    q = state.since[axis] / (tau_ms * 1e-3)
    fade = np.where(v != 0, np.exp(-np.minimum(q, 50.0)), 0.0)
    return along(axis, -fade * s, -q * fade * s, -fade, -q * fade)


def special(tau_ms: float, length_mm: float, **_: float) -> tuple[str, dict[str, float]] | None:
    """The effect that is its special case, in which shape: alike in both directions."""
    if tau_ms <= 0 and length_mm <= 0:
        return None
    return "reversal_spike", {"tau_ms": tau_ms, "rebounds": 0.0, "length_mm": length_mm}


def sensible(
    size_um: float,
    slope_um: float,
    difference_um: float,
    difference_slope_um: float,
    tau_ms: float,
    released: float = 0.0,
    length_mm: float = 0.0,
    **other: float,
) -> bool:
    """Alike in both directions it is a plain lag and a plain friction; and friction opposes motion
    in either of them."""
    if tau_ms > 0 or length_mm > 0:
        mean, difference = _rms(size_um, slope_um), _rms(difference_um, difference_slope_um)
        # larger than what two spikes alike differ by, and not so large that one direction has none
        return UNLIKE * mean < difference <= ONE_WAY * mean
    if released:
        return UNLIKE * abs(size_um) < abs(difference_um) <= OPPOSES * abs(size_um)
    opposes = abs(slope_um) + LIKE_SLOPE * abs(size_um)
    at_100_mm_s = abs(slope_um) + abs(size_um)
    return UNLIKE * at_100_mm_s < abs(difference_slope_um) <= OPPOSES * opposes


def _rms(size: float, slope: float) -> float:
    """Of (size + slope q) exp(-q) over q, the times or ways since a turn."""
    # the integral of (size + slope q)**2 exp(-2 q) from 0 on: size**2 / 2 + size slope / 2 +
    # slope**2 / 4
    return float(np.sqrt(size**2 / 2 + size * slope / 2 + slope**2 / 4))


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    """The parameters that enter linearly. Of a plain lag the mean at rest is an unknown zero."""
    if named["tau_ms"] > 0 or named["length_mm"] > 0:
        return SIZES
    return (SIZES[0], SIZES[2]) if named["released"] else (*SIZES[:2], SIZES[3])


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted)
