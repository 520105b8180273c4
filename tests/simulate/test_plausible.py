"""The ranges hold every machine that there is, and no absurdity."""

from __future__ import annotations

import pytest

from postproc import effects

REAL = [  # an old router, a grinder, a large mill
    ("backlash", "size_um", (1000.0, 2.0, -30.0)),
    ("backlash_position", "b0_um", (1000.0, 5.0)),
    ("windup", "size_um", (600.0, 0.5)),
    ("scale", "ppm", (900.0, -350.0, 5.0)),
    ("cosine", "ppm", (-112.0, -0.5)),
    ("pitch_shape", "c1_um", (1500.0, 5.0)),
    ("screw_heat", "alpha_ppm_K", (23.0, 11.5, 8.0)),
    ("screw_heat", "grown_ppm", (250.0, 60.0)),
    ("servo_lag", "tau_ms", (200.0, 60.0, 0.1)),
    ("inertia", "um_per_mm_s2", (-1.0, -0.002)),
    ("spindle_growth", "um_per_1000_rpm", (40.0, 3.0)),
    ("structure_drift", "size_um", (120.0, 5.0)),
    ("tool_wear", "rate_um", (37.0, 1.0)),
    ("squareness", "urad", (3300.0, 12.0)),
    ("force_compliance", "um_per_N", (5.0, 0.005)),
    ("abbe", "arm_mm", (400.0,)),
]
ABSURD = [
    ("cosine", "ppm", -1000.0),
    ("scale", "ppm", 25_400.0),
    ("screw_heat", "alpha_ppm_K", 100.0),
    ("inertia", "um_per_mm_s2", -30.0),
    ("servo_lag", "tau_ms", 400.0),
    ("spindle_growth", "um_per_1000_rpm", 90.0),
    ("pitch_shape", "c4_um", 3000.0),
    ("tool_wear", "rate_um", 400.0),
    ("dead_path", "um_K", 50.0),
]


@pytest.mark.parametrize(("name", "parameter", "values"), REAL)
def test_real_machines_are_plausible(name, parameter, values):
    low, high = effects.load(name).PLAUSIBLE[parameter]
    assert all(low <= v <= high for v in values)


@pytest.mark.parametrize(("name", "parameter", "value"), ABSURD)
def test_absurd_values_are_not(name, parameter, value):
    low, high = effects.load(name).PLAUSIBLE[parameter]
    assert not low <= value <= high


def test_limits_are_of_parameters():
    for name in effects.names():
        module = effects.load(name)
        limits = getattr(module, "PLAUSIBLE", {})
        assert set(limits) <= set(module.PARAMETERS) and all(
            low < high for low, high in limits.values()
        )


def test_a_head_grows_by_so_much_and_no_more():
    growth = effects.load("spindle_growth")
    assert growth.sensible(um_per_1000_rpm=40.0, housing_um=0.0, fastest_rpm=6000.0)
    assert not growth.sensible(um_per_1000_rpm=40.0, housing_um=0.0, fastest_rpm=20_000.0)


def test_a_kelvin_moves_a_frame_by_less_than_a_day_does():
    drift = effects.load("structure_drift")
    assert drift.sensible(size_um=20.0, tau_s=-1000.0) and not drift.sensible(
        size_um=200.0, tau_s=-1000.0
    )
    assert drift.sensible(size_um=200.0, tau_s=8100.0)
