"""What moves the tool moves machined walls too: lost motion makes pockets smaller and bosses
larger."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postproc import effects, recordings
from postproc.diagnose import assembly, library
from postproc.machine.file import read_machine

MACHINES = Path(__file__).parents[2] / "machines"
MILL = read_machine(MACHINES / "example-mill")
STUDER = read_machine(MACHINES / "studer-s36")


def parts(machine, features: list[tuple[str, str, float]]):
    """Rows of one reading of each feature: kind, axis, nominal mm."""
    head = [
        '# format = "gcomp-recording/1"',
        '# kind = "features"',
        f'# machine = "{machine.name}"',
    ]
    head += [
        '# instrument = "coordinate measuring machine"',
        "feature,kind,axis,nominal_mm,measured_mm,part,reading",
    ]
    lines = [
        f"F{k},{kind},{axis},{size},{size},1,1" for k, (kind, axis, size) in enumerate(features)
    ]
    read = recordings.read(recordings.Source("parts.csv", "\n".join([*head, *lines, ""]).encode()))
    return assembly.of([read], machine)


def shown(readings, name: str, axis: str, **parameters: float) -> np.ndarray:
    """(N,) um."""
    module = effects.load(name)
    value, shape = module.coefficients(**parameters)
    return library.read(readings, module, axis, shape) @ value * 1e3


KINDS = [("pocket_size", "X", 40.0), ("bore_diameter", "X", 30.0), ("boss_diameter", "X", 50.0)]
OTHERS = [("centre_distance", "X", 60.0), ("pocket_size", "Y", 40.0)]


@pytest.mark.parametrize("name", ["backlash", "windup", "backlash_position"])
def test_a_pocket_is_smaller_by_the_lost_motion_and_a_boss_larger(name):
    """Either wall is short of its place by half of it; what is reached from an unknown place, and
    another axis, show nothing."""
    sizes = {
        "backlash": {"size_um": 8.0},
        "windup": {"size_um": 8.0, "length_mm": 0.5},
        "backlash_position": {"b0_um": 8.0, "b1_um": 0.0, "b2_um": 0.0},
    }
    found = shown(parts(MILL, KINDS + OTHERS), name, "X", **sizes[name])
    assert found == pytest.approx([-8.0, -8.0, 8.0, 0.0, 0.0])


def test_lost_motion_of_a_lathe_is_all_in_the_diameter():
    found = shown(
        parts(STUDER, [("boss_diameter", "X", 50.0), ("bore_diameter", "X", 30.0)]),
        "backlash",
        "X",
        size_um=8.0,
    )
    assert found == pytest.approx([8.0, -8.0])


def test_a_distance_shows_what_its_two_ends_differ_by():
    readings = parts(MILL, KINDS + OTHERS)
    low, high = MILL.axes["X"].travel
    a, b = (low + high) / 2 + 30.0, (low + high) / 2 - 30.0
    wave = [np.cos(2 * np.pi * p / 7.3 - 0.5) for p in (a, b)]
    found = shown(
        readings, "cyclic", "X", period_mm=7.3, amplitude_um=4.0, phase_deg=np.degrees(0.5)
    )
    assert found[3] == pytest.approx(4.0 * (wave[0] - wave[1]))
    u = 60.0 / (high - low)
    line = shown(readings, "pitch_shape", "X", c1_um=10.0, c3_um=2.0)
    assert line[3] == pytest.approx(20.0 * u + 2.0 * (5 * u**3 - 3 * u))
    assert line[4] == 0.0


def test_the_far_wall_is_read_at_its_own_place_beside_averaged_samples_too():
    """Where other recordings have rows that are means of samples, a part's have one sample: at the
    wall itself."""
    readings = parts(MILL, OTHERS)
    n = len(readings)
    inside = {x: np.stack([p, np.full(n, np.nan)]) for x, p in readings.state.position.items()}
    beside = replace(readings, state=replace(readings.state, inside=inside))
    plain, other = (
        shown(r, "cyclic", "X", period_mm=7.3, amplitude_um=4.0, phase_deg=10.0)
        for r in (readings, beside)
    )
    assert other == pytest.approx(plain) and abs(plain[0]) > 0.1


def test_a_sensors_own_wave_is_in_its_own_signal_alone():
    """A loop that follows a scale moves the table, the other way: that is `cyclic`, of the
    machine."""
    assert effects.load("encoder_cyclic").SEES == ("scale",)
    assert "scale" not in effects.load("cyclic").SEES
