"""Waves in rows that are means of samples, and how sure a named parameter is."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from postproc import recordings
from postproc.diagnose import intervals, library, rounding, spectra
from postproc.diagnose.analysis import diagnose
from postproc.diagnose.noise import _locally as locally
from postproc.effects import State, cyclic, waves_of
from postproc.machine import places
from postproc.machine.file import read_machine

MILL = read_machine(Path(__file__).parents[2] / "machines" / "example-mill")
MAP = places.load(Path(__file__).parents[2] / "machines" / "example-mill")


@pytest.fixture
def rng() -> np.random.Generator:
    """Of each test its own: what one draws depends on no other."""
    return np.random.default_rng(11)


def sampled(step: np.ndarray, each: int = 4) -> np.ndarray:
    """(W, N) mm: places of samples that are so far apart, each four a row."""
    return np.cumsum(np.repeat(step, each)).reshape(-1, each).T


def test_a_row_shows_the_mean_of_its_samples():
    """Samples a third of a mm apart of a wave of nearly that length stand in nearly one phase:
    their mean keeps most of it, where an even average over 1.33 mm would keep 0.05 of it."""
    place = np.arange(4)[:, None] / 3 + np.zeros((1, 1))
    state = State(
        position={"X": place.mean(axis=0)},
        approach={"X": np.ones(1)},
        travel={"X": (0.0, 9.0)},
        inside={"X": place},
    )
    amplitude = np.hypot(*waves_of(state, "X", 1 / 0.313))
    phase = np.pi / 3 / 0.313
    # the sum of a geometric series
    assert amplitude == pytest.approx(abs(np.sin(4 * phase) / (4 * np.sin(phase))))
    assert amplitude > 0.85 > 0.06 > abs(np.sinc(4 / 3 / 0.313))


def test_samples_beyond_the_number_of_a_row_count_for_nothing():
    place = np.array([[1.0], [2.0], [np.nan]])
    state = State(
        position={"X": np.array([1.5])},
        approach={"X": np.ones(1)},
        travel={"X": (0.0, 9.0)},
        inside={"X": place},
    )
    assert waves_of(state, "X", 0.2)[0] == pytest.approx(
        np.mean(np.cos(2 * np.pi * 0.2 * np.array([1.0, 2.0])))
    )


@pytest.mark.parametrize("period", [0.12, 0.313, 1.7])
def test_periods_shorter_than_a_row_are_found_in_its_samples(rng, period):
    """Fast, slow and turning: rows reach over 0.04 to 1.6 mm."""
    place = sampled(
        np.concatenate(
            [np.full(400, 0.01), np.full(500, 0.33), np.full(300, 0.4), np.full(400, 0.013)]
        )
    )
    row = np.mean(np.cos(2 * np.pi * place / period + 0.7), axis=0) + rng.normal(
        0, 0.3, place.shape[1]
    )
    best, *_ = spectra._fine(place, row, np.ones(len(row)))
    assert 1 / best == pytest.approx(1 / period, abs=0.5 / np.ptp(place))


def at_targets(places: np.ndarray, value: np.ndarray) -> list[float]:
    """mm: the periods that are found in readings (um) at places of one signal along X."""
    rows = SimpleNamespace(
        state=SimpleNamespace(position={"X": places}, passage=np.full(len(places), -1)),
        signal=np.zeros(len(places), int),
    )
    gaps = [float(np.median(np.diff(places)))]
    return spectra._between_targets(rows, "X", value, np.ones(len(places)), 0.02, gaps)


def test_a_wave_much_finer_than_the_gaps_is_found_at_targets_at_odd_places():
    """1.6 mm at 22 targets 20 to 30 mm apart (ISO 230-2: no multiple of a period)."""
    rng = np.random.default_rng(5)
    places = np.cumsum(rng.uniform(20.0, 30.0, 22))
    wave = 40.0 + 8.0 * np.cos(2 * np.pi * places / 1.6 + 0.4)
    assert at_targets(places, wave + rng.normal(0.0, 0.4, 22)) == [pytest.approx(1.6, abs=5e-4)]


def test_no_fine_wave_is_found_where_some_wave_fits_as_well_by_chance():
    """White noise of 8 to 22 targets: some wave of 5,000 takes half of it and more."""
    rng = np.random.default_rng(6)
    for number in (8, 12, 22) * 10:
        places = np.cumsum(rng.uniform(20.0, 30.0, number))
        assert at_targets(places, rng.normal(0.0, 5.0, number)) == []


def test_of_even_targets_no_wave_is_distinguished_from_a_slow_curve():
    places = 25.0 * np.arange(22)
    assert at_targets(places, 8.0 * np.cos(2 * np.pi * places / 1.5625)) == []  # one phase
    assert at_targets(places, 8.0 * np.cos(2 * np.pi * places * (0.64 + 0.5 / 525))) == []


def test_samples_of_an_axis_that_stands_hide_no_wave():
    """250 samples over 50 mm show 3 mm; 10,000 at one place, as sure, leave it as it is."""
    place = np.concatenate([np.full(10_000, 40.0), np.linspace(40.0, 90.0, 250)])
    moves = np.arange(len(place)) >= 10_000
    rows = SimpleNamespace(
        state=SimpleNamespace(
            position={"X": place},
            velocity={"X": 30.0 * moves},
            passage=np.zeros(len(place)),
            inside={},
        ),
        signal=np.zeros(len(place), int),
    )
    wave = 2.0 * np.cos(2 * np.pi * place / 3.0) * moves
    best, *_ = spectra.in_place(rows, "X", wave, np.ones(len(place)))
    assert best == pytest.approx(3.0, abs=0.01)


def test_a_wave_of_many_samples_is_no_burst_of_noise(rng):
    """Of 0.3 um of white noise, a wave of 5 um and 25 samples a period in a tenth of the samples
    scatters no more; white noise of 5 um does."""
    noise, burst = rng.normal(0.0, 0.3, 3000), np.arange(3000) >= 2700
    wave = 5.0 * np.cos(2 * np.pi * np.arange(3000) / 25.0) * burst
    steady = np.zeros(3000)
    assert np.median(locally(noise + wave, steady, True)[burst]) < 1.5
    assert np.median(locally(noise + rng.normal(0.0, 5.0, 3000) * burst, steady, True)[burst]) > 9


def test_what_comes_with_a_wave_is_small_beside_it():
    assert cyclic.sensible(amplitude_um=4.0, second_um=1.0, grows_um=0.5)
    assert cyclic.sensible(amplitude_um=4.0, second_um=0.0, grows_um=4.0)  # none at one end
    assert not cyclic.sensible(amplitude_um=4.0, second_um=5.0, grows_um=0.0)
    assert not cyclic.sensible(amplitude_um=4.0, second_um=0.0, grows_um=5.0)


def test_the_interval_of_one_shape_is_that_of_a_normal_distribution():
    assert intervals._ends([(1.0, 5.0, 2.0)]) == pytest.approx((5 - 1.96 * 2, 5 + 1.96 * 2))


def test_two_shapes_as_likely_hold_half_of_the_rest_each():
    """Far apart, each has 5 % of its own beyond the interval: 1.645 standard deviations."""
    low, high = intervals._ends([(3.0, 0.0, 1.0), (3.0, 100.0, 2.0)])
    assert (low, high) == pytest.approx((-1.645, 100 + 2 * 1.645), abs=0.01)


def test_a_shape_that_is_unlikely_widens_little():
    low, high = intervals._ends([(1.0, 0.0, 1.0), (0.001, 3.0, 1.0)])
    assert -1.97 < low < -1.95 and 1.96 <= high < 2.0


def test_an_axis_that_stands_tells_no_rounding(rng):
    """Commanded 205.0000 all the time is no log that is rounded to 1 mm; positions that change in
    whole mm are."""
    still, noisy = np.full(50, 205.0), 205.0 + rng.integers(-9, 9, 50) * 1e-4
    assert rounding.noise(still, noisy) == pytest.approx(np.full(50, 1e-4 / np.sqrt(12)))
    whole = np.arange(150.0, 200.0)
    assert rounding.step(whole) == pytest.approx(np.ones(50))


def test_a_cosine_that_has_lost_its_sine_is_no_wave():
    """At every half period of a wave only one of the two shows: the other, and with it the phase,
    is not there."""
    place = np.arange(10) * 5.0
    wave = np.stack([np.cos(2 * np.pi * place / 10), np.sin(2 * np.pi * place / 10)], axis=1)
    other = np.stack([np.cos(place), np.sin(place)], axis=1)
    assert library.harmonic_pairs(np.concatenate([wave, other], axis=1)).tolist() == [
        False,
        False,
        True,
        True,
    ]


HEAD = [
    'format = "gcomp-recording/1"',
    'kind = "targets"',
    'machine = "example-mill"',
    'instrument = "laser"',
    'quantity = "displacement"',
    "sensitive = { X = 1.0 }",
]


def read_targets(
    places: np.ndarray, off_um, noise_um: float, runs: int = 3, u_um: float | None = None
) -> list[recordings.Recording]:
    """Runs there and back over targets at these places (mm) of X; u_um: stated, of one reading."""
    stated = [] if u_um is None else [f"u_um = {u_um}"]
    lines = [f"# {line}" for line in HEAD + stated] + [
        "run,t_s,X_mm,Y_mm,Z_mm,approach_X,approach_Y,approach_Z,reading_um"
    ]
    noise, t = np.random.default_rng(4), 0.0
    for run in range(1, runs + 1):
        for way in (1, -1):
            for x in places[::way]:
                t += 5.0
                off = off_um(x, way) + noise.normal(0, noise_um)
                lines.append(f"{run},{t},{x:.3f},0,0,{way},1,1,{off:.2f}")
    return [recordings.read(recordings.Source("a.csv", "\n".join([*lines, ""]).encode()))]


def test_targets_at_every_half_period_are_answered():
    """Two runs there and back over targets 20 mm apart, every other one 6 um off."""
    even = 20.0 * np.arange(-14, 15)
    d = diagnose(read_targets(even, lambda x, way: 6.0 * (-1) ** round(x / 20), 0.3), MILL)
    assert d.findings or d.unknown or d.places


def test_targets_in_step_with_a_lead_show_no_cyclic_error():
    """At every 30.08 mm a lead of 5 mm is a slow wave (aliasing): nothing tells that it is one,
    and at uneven distances the lead is asked for."""
    even = 30.08 * np.arange(-9, 10)
    uneven = even + 2.5 * np.cos(37.0 * np.arange(len(even)))

    def slow(x: float, way: int) -> float:
        place, approach = np.array([[x], [0.0], [0.0]]), np.array([[way], [1.0], [1.0]])
        known = 1e3 * MAP.deviation(place, approach.astype(float))[0, 0]
        return known + 8.0 * np.cos(2 * np.pi * x / 5)

    def names(places: np.ndarray) -> list[str]:
        return [f.block.key for f in diagnose(read_targets(places, slow, 0.3), MILL).findings]

    assert names(uneven) == ["cyclic:X"]
    assert "cyclic:X" not in names(even)


@pytest.mark.parametrize("height, verdict", [(6.0, True), (0.0, False)])
def test_a_sawtooth_in_time_is_no_white_noise(height, verdict):
    """6 um over every five and a half readings, whatever the place: 1.7 um rms that comes back in
    time; without it nothing is left out."""
    reading = iter(range(10_000))

    def off(x: float, way: int) -> float:
        place, approach = np.array([[x], [0.0], [0.0]]), np.array([[way], [1.0], [1.0]])
        known = 1e3 * MAP.deviation(place, approach.astype(float))[0, 0]
        return known + height * (next(reading) / 5.5 % 1.0)

    uneven = 30.0 * np.arange(-9, 10) + 2.5 * np.cos(37.0 * np.arange(19))
    d = diagnose(read_targets(uneven, off, 0.3, runs=1), MILL)
    assert (d.unknown is not None) == verdict
    assert not [f for f in d.findings if f.status == "accepted"]


@pytest.mark.parametrize(
    "noise_um, u_um, verdict",
    [
        (1.8, 0.4, True),
        (1.8, 1.5, False),
        (1.8, None, False),
        (4.0, None, True),
        (4.0, 3.0, False),
        (0.8, 0.1, False),
    ],
)
def test_readings_scatter_by_no_more_than_is_stated_or_usual(noise_um, u_um, verdict):
    """Scatter by more than two and a half times the standard uncertainty that a file states, or
    1 um where it states none, is unknown; what is below 1 um is none."""
    uneven = 30.0 * np.arange(-9, 10) + 2.5 * np.cos(37.0 * np.arange(19))

    def exact(x: float, way: int) -> float:
        place, approach = np.array([[x], [0.0], [0.0]]), np.array([[way], [1.0], [1.0]])
        return 1e3 * float(MAP.deviation(place, approach.astype(float))[0, 0])

    d = diagnose(read_targets(uneven, exact, noise_um, u_um=u_um), MILL)
    assert (d.unknown is not None) == verdict
    assert not [f for f in d.findings if f.status == "accepted"]
