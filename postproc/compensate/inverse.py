"""The inverse, once: the command whose deviation lands it on the target."""

from __future__ import annotations

import numpy as np

from postproc.errors import MotionFault
from postproc.machine.model import Machine

CLOSE = 1e-6  # mm: a hundredth of the usual least increment
ROUNDS = 12


def command(
    machine: Machine, target: np.ndarray, approach: np.ndarray, motion: np.ndarray | None = None
) -> np.ndarray:
    """(A, N) mm: the command p - e(command) for each target p, with the direction of approach held
    fixed.

    target, approach: (A, N). Each point is repeated until it is within CLOSE by its own step, never
    by its neighbours', so that the batch does not matter. The deviation changes by
    `machine.bounds.steepest` per mm (0.003 on a real grinder): two rounds do, since each makes what
    is missing smaller by that factor at least (Banach's fixed point): 10 um, 0.03 um, 0.1 nm.
    `steepest` times the last step is what the next round can still change. Newton's method would
    need slopes, which jump at nodes. Raises MotionFault
    (with `motion` (N,) naming it) where it does not settle: such a map is a data fault.
    """
    if not target.shape[1]:
        return target
    result: np.ndarray = target - machine.deviation(target, approach)
    after = target - machine.deviation(result, approach)
    steps = np.abs(after - result)
    result = after
    if steps.max() * machine.bounds.steepest <= CLOSE:
        return result
    step = steps.max(axis=0)
    for _ in range(ROUNDS):
        open_ = np.flatnonzero(step * machine.bounds.steepest > CLOSE)
        if not len(open_):
            return result
        after = target[:, open_] - machine.deviation(result[:, open_], approach[:, open_])
        step[open_] = np.abs(after - result[:, open_]).max(axis=0)
        result[:, open_] = after
    worst = int(np.argmax(step))
    raise MotionFault(
        int(motion[worst]) if motion is not None else 0,
        f"the correction does not settle: it still changes by {step[worst] * 1000:.3f} um after"
        f" {ROUNDS} rounds",
        "the error map is too steep here to be true: look at its nodes",
    )
