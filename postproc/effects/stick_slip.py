"""Stick-slip: saw-tooth motion at low feed; the slide waits, then jumps.

While it sticks the drive is wound up by the way that it goes on, and a slip lets that go in a part
of the cycle (Bowden and Tabor, The Friction and Lubrication of Solids, 1950; Rabinowicz, Friction
and Wear of Materials, 1965). Above a critical speed it slides evenly (Armstrong-Helouvry, Dupont,
Canudas de Wit, Automatica 30, 1994, 1083), so that below it the slide lags in the mean, too, where
no integrator of the drive takes that back. The way of a cycle is found from the spectrum of what is
left over the way since the last turn. Where the jumps are too short for the samples only their mean
is seen: while the axis creeps it lags by half a tooth and more.
"""

import numpy as np

from postproc.effects import ENDLESS, State, along, grid
from postproc.effects._named import by_name

PARAMETERS = {
    "period_mm": "mm, way that it is driven on while it sticks; 0, too short to be told apart",
    "size_um": "um, how far it lags before it jumps",
    "fastest_mm_s": "mm/s, speed above which it slides evenly; 0, none",
    "slip_ms": "ms, time of a slip; 0, it jumps at once",
    "mean_um": "um, mean lag while it creeps with jumps that are told apart",
    "scatter": "1, standard deviation of the ways of its cycles over their mean; 0, all are alike",
}
SIZES = ("size_um", "mean_um")
OPTIONAL = {"fastest_mm_s": 0.0, "slip_ms": 0.0, "mean_um": 0.0, "scatter": 0.0}
PLAIN = {"slip_ms": 0.0, "scatter": 0.0}
SHORTEST = 0.2  # of period_mm: a cycle that is drawn
SEED = 1994
SLIPS = (0.1, 0.25, 0.4)  # of a cycle at the usual speed
SLOWEST, CRITICAL, SPEEDS = 0.5, 12.0, 8  # mm/s: critical speeds of slideways
STILL = 1e-9  # mm
FEWEST = 8  # rows that creep
# The mean lies within the tooth: beyond, it is friction that rises at low speed.
WITHIN = (-0.1, 1.1)
# What sticks lags. The drive's stiffness bounds by how much (unverified).
PLAUSIBLE = {"size_um": (0.0, 500.0)}  # beyond, it is something else
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("distance", "velocity", "approach"), ("tool", "scale")
TEXT = (
    "The slide sticks and jumps at low feed. "
    "Lubrication, guideway material, a higher feed; a program can not correct it."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    slow = [v for v in limits(state, axis) if v > 0]
    return [{"period_mm": 0.0, "fastest_mm_s": v} | PLAIN for v in slow]


def limits(state: State, axis: str) -> list[float]:
    """mm/s: critical speeds that these rows tell from each other; 0, it jumps at every speed."""
    speed = np.abs(state.velocity[axis])
    found, last = [0.0], 0
    for v in grid(SLOWEST, CRITICAL, SPEEDS):
        number = int(np.count_nonzero((speed > 0) & (speed < v)))
        if number > max(FEWEST, last) and np.any(speed > 1.5 * v):
            found.append(v)
            last = number
    return found


def creeps(state: State, axis: str, fastest_mm_s: float) -> np.ndarray:
    """(N,) bool: rows that move, and slower than the critical speed, if there is one."""
    speed = np.abs(state.velocity[axis])
    return (speed > 0) & ((speed < fastest_mm_s) | (fastest_mm_s <= 0))


def ways(state: State, axis: str) -> np.ndarray:
    """(W, N) mm since the last turn, or since a motion began of which no turn is known, of the
    samples of each row."""
    samples, since = state.inside.get(axis), state.distance[axis].copy()
    endless = since >= ENDLESS
    for passage in np.unique(state.passage[endless]) if len(state.passage) else ():
        own = endless & (state.passage == passage) & (passage >= 0)
        place = state.position[axis][own]
        since[own] = np.abs(place - place[:1])
    if samples is None:
        return since[None]
    gone = (samples - state.position[axis]) * state.approach[axis]
    return np.clip(since + gone, 0.0, ENDLESS)


def _since_slip(
    state: State, axis: str, period_mm: float, fastest_mm_s: float, scatter: float
) -> np.ndarray:
    """(N,) mm driven on since the last slip of cycles that differ: as it was seen, else drawn."""
    if axis in state.slipped:
        return state.slipped[axis]
    low, high = state.travel[axis]
    since = state.distance.get(axis, np.full(len(state), ENDLESS))
    # without a turn before it a motion is taken to have come from the end of the travel
    from_end = np.where(state.approach[axis] < 0, high, low)
    way = np.where(since < ENDLESS, since, np.abs(state.position[axis] - from_end))
    number = int(way.max(initial=0.0) / (SHORTEST * period_mm)) + 2
    # a fixed seed: the same parameters give the same cycles in every run
    drawn = 1 + scatter * np.random.default_rng(SEED).standard_normal(number)
    ends = np.cumsum(period_mm * np.maximum(drawn, SHORTEST))
    last = np.concatenate([[0.0], ends])[np.searchsorted(ends, way, side="right")]
    creep = creeps(state, axis, fastest_mm_s)
    return np.where(creep, way - last, np.nan)


def fuller(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same cycle, at the usual speed of what creeps, with a slip that takes a part of it."""
    if shape["scatter"]:
        return []
    speed = np.abs(state.velocity[axis])[creeps(state, axis, shape["fastest_mm_s"])]
    usual, cycle = float(np.median(speed)), shape["period_mm"]
    return [
        shape | {"period_mm": (1 - slip) * cycle, "slip_ms": 1e3 * slip * cycle / usual}
        for slip in SLIPS
    ]


def sensible(period_mm: float, size_um: float, mean_um: float = 0.0, **_: float) -> bool:
    """Whether the mean lag lies within the tooth."""
    low, high = sorted(share * size_um for share in WITHIN)
    return period_mm <= 0 or low <= mean_um <= high


def columns(
    state: State,
    axis: str,
    period_mm: float,
    fastest_mm_s: float = 0.0,
    slip_ms: float = 0.0,
    scatter: float = 0.0,
) -> np.ndarray:
    lag = -state.approach[axis] * creeps(state, axis, fastest_mm_s)
    if period_mm <= 0:
        return along(axis, 0.5 * lag)
    if scatter:
        sawtooth = _since_slip(state, axis, period_mm, fastest_mm_s, scatter) / period_mm - 0.5
        known = np.isfinite(sawtooth)
        lag = np.where(known & (lag == 0), -state.approach[axis], lag)
        return along(axis, np.where(known, sawtooth, 0.0) * lag, lag)
    creep = np.flatnonzero(lag)
    driven_on = np.abs(state.velocity[axis][creep]) * slip_ms * 1e-3
    #    lag ^    /|    /|       the drive goes on by period_mm while the slide sticks (1 - 0), and
    #        |  /  |  /  |       by driven_on while it slips (its height falls back in a line)
    #        |/    |/    |
    #        +-----+-----+---> way since the turn
    #          period driven_on
    way = ways(state, axis)[:, creep] % (period_mm + driven_on)
    height = way / period_mm
    if slip_ms:
        let_go = (period_mm + driven_on - way) / np.maximum(driven_on, STILL)
        height = np.minimum(height, let_go)
    sawtooth = np.zeros(len(lag))
    sawtooth[creep] = np.nanmean(height, axis=0) - 0.5
    return along(axis, sawtooth * lag, lag)


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    return SIZES if named["period_mm"] > 0 else SIZES[:1]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted)
