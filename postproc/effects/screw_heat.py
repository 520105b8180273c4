"""Screw heat: the screw grows with its own temperature, from the bearing that holds it.

The temperature of the screw where it is recorded, else heat that comes with time, or with the axis'
travel. A test of warming up (ISO 230-3, 7.4) runs the axis between its readings and then lets it
rest: heat comes until then, and goes with the same time constant. Who reads it cold and warm runs
it in a pause between two readings: then heat comes in that pause.
"""

from itertools import compress

import numpy as np

from postproc.effects import State, along, first_timed, sampled, temperature_rise
from postproc.effects._named import by_name
from postproc.effects.structure_drift import QUICKEST

PARAMETERS = {
    "alpha_ppm_K": "um/(m K), expansion by the recorded temperature; 0 where none is recorded",
    "grown_ppm": "um/m, expansion that it tends to while heated, where no temperature is recorded",
    "fixed_um_K": "um per K, growth of what holds the screw; um where no temperature is recorded",
    "tau_s": "s, 0: by the recorded temperature, else the time in which the heat comes",
    "by_travel": (
        "1, the heat comes with the axis' own travel and goes when it rests; 0, it comes with time"
    ),
    "held_at_mm": "mm, where the screw is held: it grows from there",
    "free": "1, what holds it grows too; 0, what holds it does not grow",
    "warm_ppm": (
        "um/m, by how much it was longer already at the first reading than when the map was made"
    ),
    "warm": "1, it was warm at the first reading, from a use that was not recorded; 0, it was not",
    "until_s": (
        "s, after the first reading, when the axis came to rest and cooled, heated with the time"
        " until then; 0, heat came to the end"
    ),
    "from_s": "s, after the first reading, when a pause began in which the axis was run warm",
    "to_s": "s, after the first reading, when that pause ended and it cooled; 0, there was none",
}
SIZES = ("alpha_ppm_K", "grown_ppm", "fixed_um_K", "warm_ppm")
OPTIONAL = {
    "alpha_ppm_K": 0.0, "grown_ppm": 0.0, "by_travel": 0.0, "held_at_mm": 0.0, "free": 1.0,
    "fixed_um_K": 0.0, "warm_ppm": 0.0, "warm": 0.0, "until_s": 0.0, "from_s": 0.0, "to_s": 0.0,
}  # fmt: skip
CONTINUOUS = {"tau_s": (60.0, 30000.0), "until_s": (60.0, 1e6)}
TAUS = (600.0, 1800.0, 5400.0)  # s
RESTS = (0.3, 0.5, 0.7)  # of what was recorded
PAUSES, LONG, TIMES = 2, 300.0, 5.0  # at most; s at least; times the usual pause between readings
ALL_THE_TIME = {"until_s": 0.0, "from_s": 0.0, "to_s": 0.0}
EXPECTED = {"alpha_ppm_K": 1, "grown_ppm": 1}
# Steel 11.5, glass 8, aluminium 23 ppm/K, and a thermometer that does not lie on the screw itself.
# A screw gets 25 K warmer at the
# most (unverified): 290 ppm of steel. What holds it is no longer than 1 m of aluminium or 2 m of
# steel.
PLAUSIBLE = {  # beyond, it is something else
    "alpha_ppm_K": (-30.0, 30.0),
    "grown_ppm": (-300.0, 300.0),
    "warm_ppm": (-300.0, 300.0),
    "fixed_um_K": (-25.0, 25.0),
}
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position", "time"), ("tool", "part")
WALLS = True  # features are wider where both their walls are farther apart
TEXT = (
    "The screw grows with its own heat. "
    "Warm up, a scale instead of the motor's encoder, or compensation by the screw's temperature."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    if not len(state.time):
        return []
    low, high = state.travel[axis]
    ends = [(low, 0.0), (high, 0.0), (0.0, 1.0)]
    known = state.channel(f"T_screw_{axis}_C", f"T_scale_{axis}_C") is not None
    # A thermometer that is coarse, that hangs, or that lies elsewhere does not say it: heat that
    # comes with time or travel stands beside.
    heats = [
        *([(0.0, 0.0)] if known else []),
        *((v, w) for v in TAUS for w in (0.0, 1.0) if _lasts(state, w)),
    ]
    held = [{"held_at_mm": end, "free": free} for end, free in ends]
    plain = [
        {"tau_s": t, "by_travel": w, "warm": warm} | ALL_THE_TIME
        for t, w in heats
        for warm in ((0.0,) if known else (0.0, 1.0))
    ]
    rested = [
        {"tau_s": t, "by_travel": 0.0, "warm": 0.0} | ALL_THE_TIME | when
        for t in TAUS
        for when in _rests(state) + _pauses(state)
    ]
    return [shape | end for shape in plain + rested for end in held]


def _lasts(state: State, by_travel: float) -> bool:
    """Whether heat can have come: with the travel of one recording, or with time over them all."""
    own = [state.time[state.file == f] for f in np.unique(state.file)] if by_travel else []
    span = max((float(np.ptp(t)) for t in own or [state.time]), default=0.0)
    return not 0 < span <= QUICKEST


def _rests(state: State) -> list[dict[str, float]]:
    """until_s of tests in which the axis was run warm and cooled."""
    times = [share * float(np.ptp(state.time)) for share in RESTS]
    return [{"until_s": t} for t in times if t > CONTINUOUS["until_s"][0]]


def _pauses(state: State) -> list[dict[str, float]]:
    """from_s and to_s of pauses in which an axis could be run warm, the longest first."""
    first = state.time[first_timed(state)]
    t = np.unique(state.time[~sampled(state) & (state.time >= first)])
    gaps = np.diff(t)
    if not len(gaps):
        return []
    least = max(LONG, TIMES * float(np.median(gaps)))
    longest = np.argsort(-gaps, kind="stable")[:PAUSES]
    return [
        {"from_s": float(t[k] - first), "to_s": float(t[k + 1] - first)}
        for k in longest
        if gaps[k] > least
    ]


def columns(
    state: State,
    axis: str,
    tau_s: float,
    by_travel: float = 0.0,
    held_at_mm: float = 0.0,
    free: float = 1.0,
    warm: float = 0.0,
    until_s: float = 0.0,
    from_s: float = 0.0,
    to_s: float = 0.0,
) -> np.ndarray:
    heat = temperature_rise(state, axis, tau_s, by_travel)
    if end := max(until_s, to_s):
        gone = state.time - state.time[first_timed(state)]
        #    heat ^       .-.            comes from from_s to `end`, and goes from there on,
        #         |     .'   '.          with the same time constant
        #         | __.'       '-.__
        #           from_s  end         t
        heated = np.clip(gone, from_s, end) - from_s
        cooled = np.maximum(gone - end, 0.0)
        heat = -np.expm1(-heated / tau_s) * np.exp(-cooled / tau_s)
    # mm times ppm is 1e-3 um; the screw grows from where it is held, to both sides
    place = (state.position[axis] - held_at_mm) * 1e-3
    return along(axis, heat * place, *([heat] if free else []), *([place] if warm else []))


def _as_driven(named: dict[str, float]) -> dict[str, float]:
    """The expansion under the name that it has by its driver, whichever it was stated by."""
    heat = named["alpha_ppm_K"] + named["grown_ppm"]
    by_time = named["tau_s"] > 0
    return named | {"alpha_ppm_K": 0.0 if by_time else heat, "grown_ppm": heat if by_time else 0.0}


def _fitted(named: dict[str, float]) -> list[str]:
    there = (named["tau_s"] <= 0, named["tau_s"] > 0, named["free"], named["warm"])
    return list(compress(SIZES, there))


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted, first=_as_driven)
