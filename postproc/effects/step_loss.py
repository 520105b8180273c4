"""Step loss: jumps that stay, of lost steps, a slipped coupling or belt; up to three in an
experiment, all to one side."""

import numpy as np

from postproc.effects import State, along

PARAMETERS = {
    "jump_um": "um, the jump",
    "t_s": "s, when it happened",
    "second_um": "um, a second jump",
    "second_s": "s, when; 0, there was none",
    "third_um": "um, a third jump",
    "third_s": "s, when; 0, there was none",
}
OPTIONAL = {"second_um": 0.0, "second_s": 0.0, "third_um": 0.0, "third_s": 0.0}
MOMENTS = ("t_s", "second_s", "third_s")
# um: instruments jump by less (a fringe miscounted, a probe that settles), and no full step is so
# short
SMALLEST = 1.5
# of the largest: others may be as small (a stepping motor loses whole multiples of four steps)
SHARE = 1 / 3
KIND, USE, PER = "machine", "simulate", "axis"
NEEDS, SEES = ("time",), ("tool", "scale")
TEXT = (
    "The axis has lost its place by a jump. Home the machine again; look at load, acceleration,"
    " coupling and belt."
)


def shapes(state: State, axis: str) -> list[dict[str, float]]:
    return []  # between any two readings, see diagnose


def columns(
    state: State, axis: str, t_s: float, second_s: float = 0.0, third_s: float = 0.0
) -> np.ndarray:
    moments = [t_s, *(t for t in (second_s, third_s) if t)]
    return along(axis, *((state.time > t).astype(float) for t in moments))


def sensible(
    jump_um: float | np.ndarray,
    second_um: float | np.ndarray = 0.0,
    third_um: float | np.ndarray = 0.0,
    **moments: float,
) -> np.ndarray:
    """Whether they are more than an instrument's own, or beside such a one not much smaller than
    it, and all go one way: what jumps to and fro is as well an instrument that switches. um, each
    a number or an array; a bool of that shape."""
    jumps = np.stack(np.broadcast_arrays(jump_um, second_um, third_um))
    there = jumps != 0
    one_way = np.abs(np.sign(jumps).sum(axis=0)) == there.sum(axis=0)
    smallest = np.where(there, np.abs(jumps), np.inf).min(axis=0)
    largest = np.abs(jumps).max(axis=0)
    # beside a jump that is clearly no instrument's, smaller ones of the same kind are believed
    enough = np.minimum(SMALLEST, SHARE * largest)
    return np.asarray(one_way & (largest >= SMALLEST) & (smallest >= enough))


def parameters(coefficients: np.ndarray, shape: dict[str, float]) -> dict[str, float]:
    jumps = [*(float(c) for c in coefficients), 0.0, 0.0][:3]
    named: dict[str, float] = {}
    for name, jump, moment in zip(
        ("jump_um", "second_um", "third_um"), jumps, MOMENTS, strict=True
    ):
        named |= {name: jump, moment: shape.get(moment, 0.0)}
    return named


def coefficients(
    jump_um: float,
    t_s: float,
    second_um: float = 0.0,
    second_s: float = 0.0,
    third_um: float = 0.0,
    third_s: float = 0.0,
) -> tuple[np.ndarray, dict[str, float]]:
    jumps = [(jump_um, "t_s", t_s)]
    later = ((second_um, "second_s", second_s), (third_um, "third_s", third_s))
    jumps += [one for one in later if one[2]]
    return np.array([jump for jump, _, _ in jumps]), {name: t for _, name, t in jumps}
