"""Which names a driver that nobody recorded leaves open: what goes with a temperature, a load or a
speed may look like anything that goes with time, and what goes with an angle like anything that
goes with the place."""

from __future__ import annotations

import numpy as np

from postproc import effects
from postproc.diagnose import library
from postproc.diagnose.block import Block
from postproc.diagnose.rows import Rows
from postproc.effects import structure_drift

LEFT = 0.5  # of the squares of a curve: a line that leaves more does not look like it
TIME = (
    "structure_drift", "spindle_growth", "force_compliance", "dead_path", "screw_heat", "laser_air",
)  # fmt: skip
LENGTH = ("screw_heat", "laser_air", "cosine")
PLACE = ("abbe",)
DRIVERS = {
    "screw_heat": ("T_screw_{}_C", "T_scale_{}_C"),
    "structure_drift": ("T_air_C", *structure_drift.FRAME),
    "laser_air": ("T_air_C",),
}
LOOKS = {
    "step_loss": TIME, "structure_drift": TIME, "spindle_growth": TIME, "force_compliance": TIME,
    "tool_wear": TIME, "dead_path": TIME, "screw_heat": TIME, "laser_air": LENGTH,
    "scale": LENGTH + PLACE, "cosine": LENGTH + PLACE, "pitch_shape": LENGTH + PLACE, "bow": PLACE,
    "squareness": PLACE,
}  # fmt: skip


def names(rows: Rows, block: Block, contribution: np.ndarray) -> list[str]:
    """effect:axis of what would look like this block if its driver, which is not among the
    recordings, were such."""
    shown = np.abs(contribution) > 0.1 * np.abs(contribution).max(initial=0.0)
    result = []
    looks = LOOKS.get(block.name, ())
    if block.name == "pitch_shape" and not _straight(rows, block.axis, contribution):
        looks = PLACE
    for name in looks:
        module = effects.load(name)
        able = library.visible(rows, module)
        if not np.all(able[shown]):  # it would not show where this shows
            continue
        for axis in [""] if module.PER == "all" else list(block.axis)[:1]:
            known = rows.state.channel(*(c.format(axis) for c in DRIVERS.get(name, ())))
            missing = not library.needed(rows, module, axis) or (name in DRIVERS and known is None)
            # no measured rotation, and none that could be fitted
            missing |= name == "abbe" and not module.shapes(rows.state, axis)
            if name != block.name and missing:
                result.append(f"{name}:{axis}")
    if dict(block.shape).get("warm"):  # what was there from the first reading on may be no heat
        result.append(f"scale:{block.axis}")
    return result


def _straight(rows: Rows, axis: str, contribution: np.ndarray) -> bool:
    """Whether a line over the place, as a length that is wrong makes it, takes most of the squares
    of a contribution (N,) mm."""
    own = contribution != 0
    place, value = rows.state.position[axis][own], contribution[own] - contribution[own].mean()
    line = np.column_stack([np.ones(len(place)), place - place.mean()])
    left = value - line @ np.linalg.lstsq(line, value, rcond=None)[0]
    return bool(left @ left < LEFT * (value @ value))
