"""Names of the tests."""

from __future__ import annotations

from collections.abc import Callable

from . import moving_plans, rest_plans, slow_plans
from .base import Rng
from .case import Case

PLANS: dict[str, Callable[[Rng], Case]] = {
    "laser": rest_plans.laser,
    "laser_long": lambda r: rest_plans.laser(r, "laser_long", long=True),
    "laser_temp": rest_plans.laser_in_warming_room,
    "laser_fine": rest_plans.fine,
    "laser_multi": rest_plans.several_lines,
    "multi_v": lambda r: rest_plans.several_lines(r, "multi_v", True),
    "straight": rest_plans.straightness,
    "straight_v": lambda r: rest_plans.straightness(r, True),
    "diag": rest_plans.diagonals,
    "heatrun": slow_plans.heat_run,
    "thermal_spindle": lambda r: slow_plans.drift(r, spindle=True),
    "thermal_etve": slow_plans.drift,
    "thermal_etve0": lambda r: slow_plans.drift(r, quiet=True),
    "probing": rest_plans.probing,
    "load": slow_plans.load,
    "ballbar": moving_plans.ballbar,
    "ts_lin": lambda r: moving_plans.trace(r, "lin", "scale"),
    "ts_circ": lambda r: moving_plans.trace(r, "circ", "scale"),
    "ts_slow": lambda r: moving_plans.trace(r, "slow", "scale"),
    "ts_lin_cur": lambda r: moving_plans.trace(r, "lin", "scale", True),
    "tt_lin": lambda r: moving_plans.trace(r, "lin", "tool"),
    "tt_circ": lambda r: moving_plans.trace(r, "circ", "tool"),
    "tt_slow": lambda r: moving_plans.trace(r, "slow", "tool"),
    "features": slow_plans.parts,
}
# of cases without an effect; a name twice is drawn twice as often
NULL_PLANS = [
    *("laser", "laser", "laser_long", "laser_fine", "laser_multi", "straight", "diag"),
    *("thermal_etve0", "thermal_spindle", "probing", "load", "ballbar", "ballbar"),
    *("ts_lin", "ts_circ", "ts_slow", "tt_lin", "tt_circ", "features", "heatrun"),
]
