"""Reversal error that varies along the travel: a worn stretch of the screw (where most parts are
cut), a preload that is not even."""

import numpy as np

from postproc.effects import UM, State, Table, along, legendre, lost_motion_share
from postproc.effects._curve import ENDS, curve_ends, place_in, reached
from postproc.effects._named import by_name

PARAMETERS = {
    "b0_um": "um, mean lost motion",
    "b1_um": "um, its change from the middle to the end of the travel",
    "b2_um": "um, share of its second Legendre polynomial",
    "b3_um": "um, share of its third",
    "b4_um": "um, share of its fourth",
    "b5_um": "um, share of its fifth",
    "b6_um": "um, share of its sixth",
    "play_mm": "mm, way after a turn over which it is taken up",
    "degree": "1, 2 or 6, of the highest polynomial; 0 where one stretch is worn",
    "worn_um": "um, by how much it is more in the middle of a worn stretch",
    "worn_mm": "mm, how far that middle is from the low end of the travel",
    "wide_mm": "mm, how wide the stretch is; 0, there is none",
    "from_mm": "mm, where the polynomials begin; 0 here and in to_mm: over the travel",
    "to_mm": "mm, where they end; beyond, it is as there",
    "flank": (
        "1, the flank is worn that carries when the axis comes in +, where all of worn_um shows;"
        " -1, that one is worn that carries when it comes in -; 0, both, and each direction shows"
        " half"
    ),
}
SHARES = tuple(f"b{k}_um" for k in range(7))
OPTIONAL = {
    "b2_um": 0.0, "b3_um": 0.0, "b4_um": 0.0, "b5_um": 0.0, "b6_um": 0.0, "play_mm": 0.0,
    "degree": 2.0, "worn_um": 0.0, "worn_mm": 0.0, "wide_mm": 0.0, "from_mm": 0.0, "to_mm": 0.0,
    "flank": 0.0,
}  # fmt: skip
HIGHEST_DEGREE = {"degree": len(SHARES) - 1}
FLANKS = (0.0, 1.0, -1.0)
WIDTHS, STEPS = (0.1, 0.2, 0.35), 12  # of the travel; places of a worn stretch along it
# of what is lost elsewhere, more in a worn stretch; of that, with the other sign (unverified)
CLEARLY, SLIGHTLY = 0.5, 0.2
SMALL = 0.02  # mm
# As backlash; what differs along the travel is no more than the whole.
PLAUSIBLE = {
    "b0_um": (-1000.0, 2000.0),
    **{f"b{k}_um": (-1000.0, 1000.0) for k in range(1, 7)},
    "worn_um": (-1000.0, 1000.0),
}  # beyond, it is something else
# mm: over which it is taken up; where a worn stretch is, and how wide
CONTINUOUS = {"play_mm": (0.001, 0.05), "worn_mm": (1.0, 20000.0), "wide_mm": (10.0, 5000.0)}
KIND, USE, PER = "machine", "compensate", "axis"
ALONG = True
NEEDS, SEES = ("position", "approach"), ("tool", "part")
TEXT = (
    "The lost motion differs along the travel: a worn stretch of the screw. A two-way table"
    " corrects it; one backlash number can not. Look at the screw where it is largest."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near = state.distance.get(axis)
    fine = near is not None and bool(np.any(near < SMALL))
    plain = {"worn_mm": 0.0, "wide_mm": 0.0} | curve_ends(state, axis)
    curved = [
        {"play_mm": v, "degree": d, "flank": 0.0} | plain
        for v in ((0.0, 0.004, 0.008, 0.016) if fine else (0.0,))
        for d in (1.0, 2.0, 6.0)
    ]
    worn = {"play_mm": 0.0, "degree": 0.0} | dict.fromkeys(ENDS, 0.0)
    return curved + [
        worn | {"worn_mm": at, "wide_mm": wide, "flank": f}
        for at, wide in _stretches(state, axis)
        for f in FLANKS
        if f == 0.0 or _seen(state, axis, at, wide, f)
    ]


def _stretches(state: State, axis: str) -> list[tuple[float, float]]:
    """mm: middles and widths of stretches of which readings tell, within what they reach."""
    (low, high), seen = state.travel[axis], reached(state, axis)
    return [
        (round(float(at - low), 3), round(wide * (high - low), 3))
        for wide in WIDTHS
        for at in np.linspace(low, high, STEPS + 1)
        if seen[0] < at < seen[1]
    ]


def _seen(state: State, axis: str, worn_mm: float, wide_mm: float, flank: float) -> bool:
    """Whether readings from one side stand in a stretch."""
    off = state.position[axis] - state.travel[axis][0] - worn_mm
    return bool(np.any((np.abs(off) < wide_mm / 2) & (state.approach[axis] == flank)))


def columns(
    state: State,
    axis: str,
    play_mm: float = 0.0,
    degree: float = 2.0,
    worn_mm: float = 0.0,
    wide_mm: float = 0.0,
    from_mm: float = 0.0,
    to_mm: float = 0.0,
    flank: float = 0.0,
) -> np.ndarray:
    u = place_in(state.position[axis], state.travel[axis], from_mm, to_mm)
    half = -state.approach[axis] / 2 * lost_motion_share(state, axis, play_mm)
    curves = [half * legendre(u, k) for k in range(int(degree) + 1)]
    if wide_mm > 0:
        # In + approach is +1 and half -1/2. A flank that carries in + alone moves all of the wear
        # to that side (-1 there, 0 in -); one that carries in - has 0 and +1.
        half = half - flank / 2
        curves.append(half * _worn(state.position[axis] - state.travel[axis][0], worn_mm, wide_mm))
    return along(axis, *curves)


def _worn(place: np.ndarray, middle: float, wide: float) -> np.ndarray:
    """Share (N,) of the wear at places (N,) mm: flat in the middle, soft at its ends, half of it
    there."""
    return np.exp(-np.log(2.0) * ((place - middle) / (wide / 2)) ** 4)


def _with_degree(named: dict[str, float]) -> dict[str, float]:
    """With the degree that its sizes need, where a lower one is stated."""
    b, worn = [named[name] for name in SHARES], named["wide_mm"] > 0
    shown = 6.0 if any(b[3:]) else 2.0 if b[2] else 1.0 if b[1] or not worn else 0.0
    return named | {"degree": max(0.0 if worn else named["degree"], shown)}


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    shares = SHARES[: int(named["degree"]) + 1]
    return (*shares, "worn_um") if named["wide_mm"] > 0 else shares


parameters, coefficients = by_name(
    PARAMETERS, OPTIONAL, *SHARES, "worn_um", of=_fitted, first=_with_degree
)


def further_cost(axis: str, shape: dict[str, float]) -> float:
    """A curve and a worn stretch are as likely, though there are many more places of the second."""
    more = 1 + STEPS * len(FLANKS)
    return 2 * float(np.log(2.0 if shape["wide_mm"] > 0 else 2.0 / more))


def special(play_mm: float, **_: float) -> tuple[str, dict[str, float]]:
    """The effect that is its special case, in which shape."""
    return "backlash", {"play_mm": play_mm, "pushed": 0.0, "around": 0.0}


def sensible(b0_um: float, worn_um: float = 0.0, wide_mm: float = 0.0, **_: float) -> bool:
    """Whether a worn stretch loses clearly more than the rest, and of the same sign: else it is
    plain lost motion, or a curve."""
    return wide_mm <= 0 or -SLIGHTLY * worn_um**2 < b0_um * worn_um < worn_um**2 / CLEARLY


def ramp_mm(b0_um: float, play_mm: float = 0.0, **others: float) -> float:
    """mm that the slide itself goes while the lost motion builds up over play_mm of its command."""
    return max(play_mm - abs(b0_um) * UM, 0.0)


def tables(axis: str, travel: tuple[float, float], **named: float) -> list[Table]:
    # Chords of 1/120 of the travel leave 0.7 % of the sixth polynomial at most; a worn stretch has
    # steeper ends than any polynomial here.
    nodes = np.linspace(*travel, 121 if named.get("wide_mm", 0.0) <= 0 else 541)
    shares, shape = coefficients(**named)
    u = place_in(nodes, travel, shape["from_mm"], shape["to_mm"])
    wide = named.get("wide_mm", 0.0)
    worn = (
        shares[-1] * _worn(nodes - travel[0], named["worn_mm"], wide)
        if wide > 0
        else np.zeros(len(u))
    )
    shares = shares[:-1] if wide > 0 else shares
    half = sum((c * legendre(u, k) for k, c in enumerate(shares)), np.zeros(len(u))) * UM / 2
    # both are sizes: approached in + it stops short, which is below zero
    forward, reverse = (half + worn * UM / 2 * (1.0 + s * shape["flank"]) for s in (1.0, -1.0))
    return [(f"E{axis}", axis, nodes, -forward, reverse)]
