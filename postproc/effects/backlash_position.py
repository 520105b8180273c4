"""Reversal error that varies along the travel: a worn stretch of the screw, a preload that is not
even."""

import numpy as np

from postproc.effects import UM, State, Table, along, legendre, lost_motion_share

PARAMETERS = {
    "b0_um": "um, mean lost motion",
    "b1_um": "um, its change from the middle to the end of the travel",
    "b2_um": "um, share of its second Legendre polynomial",
    "b3_um": "um, share of its third",
    "b4_um": "um, share of its fourth",
    "b5_um": "um, share of its fifth",
    "b6_um": "um, share of its sixth",
    "play_mm": "mm, way after a turn over which it is taken up",
    "degree": "1, 2 or 6, of the highest polynomial",
}
OPTIONAL = {
    "b2_um": 0.0,
    "b3_um": 0.0,
    "b4_um": 0.0,
    "b5_um": 0.0,
    "b6_um": 0.0,
    "play_mm": 0.0,
    "degree": 2.0,
}
SMALL = 0.02  # mm
# As backlash; what differs along the travel is no more than the whole.
PLAUSIBLE = {
    "b0_um": (-1000.0, 2000.0),
    **{f"b{k}_um": (-1000.0, 1000.0) for k in range(1, 7)},
}  # beyond, it is something else
CONTINUOUS = {"play_mm": (0.001, 0.05)}  # mm, over which it is taken up
KIND, USE, PER = "machine", "compensate", "axis"
NEEDS, SEES = ("position", "approach"), ("tool", "part")
TEXT = (
    "The lost motion differs along the travel: a worn stretch of the screw. A two-way table"
    " corrects it; one backlash number can not. Look at the screw where it is largest."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    near = state.distance.get(axis)
    fine = near is not None and bool(np.any(near < SMALL))
    return [
        {"play_mm": v, "degree": d}
        for v in ((0.0, 0.004, 0.008, 0.016) if fine else (0.0,))
        for d in (1.0, 2.0, 6.0)
    ]


def columns(state: State, axis: str, play_mm: float = 0.0, degree: float = 2.0) -> np.ndarray:
    u = state.share(axis)
    half = -state.approach[axis] / 2 * lost_motion_share(state, axis, play_mm)
    return along(axis, *(half * legendre(u, k) for k in range(int(degree) + 1)))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    shares = [*(float(c) for c in coefficients), *[0.0] * 5][:7]
    return {f"b{k}_um": c for k, c in enumerate(shares)} | {
        "play_mm": shape["play_mm"],
        "degree": shape["degree"],
    }


def coefficients(
    b0_um: float,
    b1_um: float,
    b2_um: float = 0.0,
    b3_um: float = 0.0,
    b4_um: float = 0.0,
    b5_um: float = 0.0,
    b6_um: float = 0.0,
    play_mm: float = 0.0,
    degree: float = 2.0,
) -> tuple[np.ndarray, dict[str, float]]:
    shares = [b0_um, b1_um, b2_um, b3_um, b4_um, b5_um, b6_um]
    degree = max(degree, 6.0 if any(shares[3:]) else 2.0 if b2_um else 1.0)
    return np.array(shares[: int(degree) + 1]), {"play_mm": play_mm, "degree": degree}


def ramp_mm(b0_um: float, play_mm: float = 0.0, **others: float) -> float:
    """mm that the slide itself goes while the lost motion builds up over play_mm of its command."""
    return max(play_mm - abs(b0_um) * UM, 0.0)


def tables(axis: str, travel: tuple[float, float], **named: float) -> list[Table]:
    nodes = np.linspace(*travel, 121)
    shares, _ = coefficients(**named)
    u = np.linspace(-1, 1, len(nodes))
    half = sum((c * legendre(u, k) for k, c in enumerate(shares)), np.zeros(len(u))) * UM / 2
    return [(f"E{axis}", axis, nodes, -half, half)]
