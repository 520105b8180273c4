"""Coulomb friction: the axis stays behind by the friction over the stiffness of its drive, in
motion and after it.

A drive without integral action does not make up for it, and holds it at rest; one with it lets it
go as soon as the axis stands. After a turn the friction is taken up over a little way
(pre-sliding), or as fast as the position loop settles. At slow speeds, where the film of oil is
thin, it is higher (Stribeck 1902; Armstrong-Helouvry et al., Automatica 30, 1994, 1083).
"""

from itertools import product

import numpy as np

from postproc.effects import State, along, followed, lost_motion_share, sampled, settling
from postproc.effects._named import by_name

PARAMETERS = {
    "size_um": "um, difference between the two directions",
    "play_mm": "mm, way after a turn over which the friction turns round",
    "settle_ms": "ms, time constant with which the loop settles after a turn, a start or a stop",
    "released": "1, at rest the axis does not lag; 0, it does",
    "stribeck_um": "um, by how much the difference is larger at the slowest speeds",
    "stribeck_mm_s": "mm/s, speed at which that has fallen to a third; 0, none",
}
SIZES = ("size_um", "stribeck_um")
OPTIONAL = {
    "play_mm": 0.0,
    "settle_ms": 0.0,
    "released": 0.0,
    "stribeck_um": 0.0,
    "stribeck_mm_s": 0.0,
}
STRIBECK = (2.0, 6.0, 18.0)  # mm/s
WITHOUT = {"play_mm": 0.0, "settle_ms": 0.0, "released": 0.0, "stribeck_mm_s": 0.0}
# of the friction at speed: what breaks away is up to twice of it (Armstrong-Helouvry 1994)
MOST_STRIBECK = 1.0
SMALL = 0.05  # mm
SOON = 0.05  # s
# Friction over the stiffness of a loop: what a belt gives, see windup.
PLAUSIBLE = {"size_um": (-1000.0, 1000.0)}  # beyond, it is something else
EXPECTED = {"size_um": 1}
CONTINUOUS = {"settle_ms": (0.5, 250.0)}
KIND, USE, PER = "machine", "simulate", "axis"
ALONG = True
NEEDS, SEES = ("velocity",), ("tool", "scale")
TEXT = (
    "Friction holds the axis back while it moves. Lubrication and preload; friction compensation in"
    " the drive."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    ways = (0.01, 0.03, 0.1) if np.any(state.distance.get(axis, np.inf) < SMALL) else ()
    times = (4.0, 8.0, 16.0, 32.0) if np.any(state.since.get(axis, np.inf) < SOON) else ()
    found = [{"play_mm": v} for v in (0.0, *ways)] + [{"settle_ms": v} for v in times]
    stands = bool(np.any(sampled(state) & (state.velocity[axis] == 0)))
    _, *more = product((0.0, 1.0)[: 1 + stands], (0.0, *STRIBECK))
    found += [{"released": r, "stribeck_mm_s": v} for r, v in more]
    return [WITHOUT | shape for shape in found]


def fuller(shape: dict[str, float], state: State, axis: str) -> list[dict[str, float]]:
    """The same of a loop that takes its time."""
    return settling(shape, state, axis) if shape["play_mm"] == 0 else []


def columns(
    state: State,
    axis: str,
    play_mm: float = 0.0,
    settle_ms: float = 0.0,
    released: float = 0.0,
    stribeck_mm_s: float = 0.0,
) -> np.ndarray:
    # at rest: none (the loop lets go), or that of the last motion (it holds)
    side = np.sign(state.velocity[axis]) if released else state.approach[axis]
    side = side * lost_motion_share(state, axis, play_mm)
    if settle_ms > 0:
        side = followed(state, side, settle_ms * 1e-3)
    lag = -side / 2 * sampled(state)
    if stribeck_mm_s <= 0:
        return along(axis, lag)
    return along(axis, lag, lag * np.exp(-((state.velocity[axis] / stribeck_mm_s) ** 2)))


def _fitted(named: dict[str, float]) -> tuple[str, ...]:
    return SIZES if named["stribeck_mm_s"] > 0 else SIZES[:1]


parameters, coefficients = by_name(PARAMETERS, OPTIONAL, *SIZES, of=_fitted)


def sensible(size_um: float, stribeck_um: float, **others: float) -> bool:
    """Whether it is friction at all speeds, and more at slow ones: the other way round it is
    another effect."""
    return stribeck_um * size_um >= 0 and abs(stribeck_um) <= MOST_STRIBECK * abs(size_um)
