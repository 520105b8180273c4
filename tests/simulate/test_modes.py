"""A mode of a machine: a narrow band of frequencies, or what every jump of the acceleration
rings."""

from __future__ import annotations

import numpy as np
import pytest

from postproc import effects
from postproc.effects import State, vibration

RATE, F = 500.0, 23.0


def state(acceleration: np.ndarray, passages: int = 1, **more) -> State:
    n = len(acceleration)
    t = np.arange(n) / RATE
    return State(
        {"X": np.linspace(0.0, 100.0, n)},
        {"X": np.ones(n)},
        {"X": (0.0, 100.0)},
        velocity={"X": np.ones(n)},
        acceleration={"X": acceleration},
        since={"X": t},
        time=t,
        run=np.ones(n),
        file=np.zeros(n),
        passage=np.floor(np.arange(n) * passages / n),
        **more,
    )


def trapezoid(smooth: int = 1) -> np.ndarray:
    """mm/s2: jumps of 800 at 1 s, -800 at 1.4 s, -500 at 3 s and 500 at 3.5 s; told from places,
    they take a while."""
    a = np.zeros(2500)
    a[500:700], a[1500:1750] = 800.0, -500.0
    return np.convolve(np.pad(a, smooth, mode="edge"), np.ones(smooth) / smooth, "same")[
        smooth:-smooth
    ]


@pytest.mark.parametrize("smooth", [1, 15])
def test_the_jumps_of_the_acceleration_are_found(smooth):
    a = trapezoid(smooth)
    when, size = vibration.jumps(np.arange(len(a)) / RATE, a)
    assert when == pytest.approx([1.0, 1.4, 3.0, 3.5], abs=2.5 / RATE)
    assert size == pytest.approx([800.0, -800.0, -500.0, 500.0], rel=0.02)


def test_a_circle_and_the_noise_of_places_are_no_jumps():
    t = np.arange(5000) / RATE
    a = 11.0 * np.cos(0.33 * t) + np.random.default_rng(1).normal(0, 0.3, len(t))
    assert not len(vibration.jumps(t, a)[0])


# Of critical: welded steel, bolted machine, guideways with much friction.
@pytest.mark.parametrize("damping", [0.01, 0.03, 0.1])
def test_what_rings_down_is_the_sum_over_the_jumps(damping):
    at = state(trapezoid())
    when, size = vibration.jumps(at.time, at.acceleration["X"])
    w, wanted = 2 * np.pi * F, np.zeros((2, len(at)))
    for t, jump in zip(when, size, strict=True):
        gone = np.maximum(at.time - t, 0.0)
        fade = np.exp(-damping * w * gone) * (at.time >= t) * jump / 1000.0
        wanted += fade * np.cos(w * gone), fade * np.sin(w * gone)
    found = vibration.columns(at, "X", F, damping=damping)
    assert found[:, 0] * 1e3 == pytest.approx(wanted, abs=1e-9)
    assert not found[:, 1:].any() and not found[:, 0, at.time < 0.99].any()


def test_means_over_samples_show_the_mean_of_what_rings():
    fine = state(trapezoid())
    rung = vibration.columns(fine, "X", F, damping=0.03)[:, 0]
    every = slice(None, None, 5)
    time = np.mean(fine.time.reshape(-1, 5), axis=1)
    coarse = state(fine.acceleration["X"][every], inside={"time": fine.time.reshape(-1, 5).T})
    coarse = State(**{**vars(coarse), "time": time})
    found = vibration.columns(coarse, "X", F, damping=0.03)[:, 0]
    assert found == pytest.approx(rung.reshape(2, -1, 5).mean(axis=2), abs=0.1 * np.abs(rung).max())


def test_a_resonance_that_noise_drives_is_a_band():
    """White noise through a mode of 0.2 % damping, ten columns a passage: a band holds far more of
    it than one wave does."""
    n, rng = 2500, np.random.default_rng(3)
    pole = np.exp((2j * np.pi * F - 0.002 * 2 * np.pi * F) / RATE)
    y, z = np.zeros(n), 0j
    for k, kick in enumerate(rng.normal(size=n + 4000)):
        z = z * pole + kick
        if k >= 4000:
            y[k - 4000] = z.real
    at = state(np.zeros(n))
    left = []
    for shape in ({"passages": 1.0}, {"passages": 1.0, "band": 1.0}):
        d = vibration.columns(at, "X", F, **shape)[:, 0].T
        left.append(np.var(y - d @ np.linalg.lstsq(d, y, rcond=None)[0]) / np.var(y))
    assert left[1] < 0.1 and left[1] < 0.3 * left[0]


def test_many_passages_have_one_wave_each():
    at = state(np.zeros(2600), passages=13)
    assert len(vibration.columns(at, "X", F, passages=1.0, band=1.0)) == 2 * 13
    assert (
        len(vibration.columns(state(np.zeros(2600), passages=3), "X", F, passages=1.0, band=1.0))
        == 10 * 3
    )


@pytest.mark.parametrize(
    "shape", [{"passages": 1.0, "band": 1.0}, {"passages": 0.0, "damping": 0.03}]
)
def test_shapes_name_their_parameters(shape):
    at = state(trapezoid())
    columns = vibration.columns(at, "X", F, **shape)
    value = np.zeros(len(columns))
    value[:2] = 3.0, 4.0
    named = vibration.parameters(value, {"frequency_hz": F} | shape)
    assert set(named) == set(vibration.PARAMETERS) and named["amplitude_um"] == pytest.approx(5.0)
    if "damping" in shape:
        again = effects.deviation(vibration, at, "X", **named)
        assert again == pytest.approx(np.tensordot(value, columns, axes=1))
    else:
        assert vibration.coefficients(**named)[1] == {"frequency_hz": F, "passages": 0.0}
