"""ISO 230-3: slides at rest. Ranges by hand, tilt by hand, drift per kelvin against a line that is
known."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.iso import IsoError, Options, Stated, choose
from postproc.recordings import Recording
from postproc.units import UM, URAD


def recording(reading, t, rpm=0.0, letter="Z", name="a.csv", **more) -> Recording:
    head = {"quantity": "displacement", "sensitive": {letter: 1.0}, "u_um": 0.1} | more.pop(
        "head", {}
    )
    columns = {
        "t_s": t,
        "X_mm": 0 * t,
        "Z_mm": 0 * t + 5,
        "reading_um": reading,
        "spindle_rpm": 0 * t + rpm,
    } | more
    return Recording("targets", head, columns, name, np.arange(len(t)) + 2)


def of(*recordings):
    found, left = choose.results(recordings, Options())
    assert not left
    return found


T = np.arange(0.0, 24 * 3600 + 1, 60.0)


def test_a_day_of_the_room_by_hand():
    """4 um of cosine over 24 h: range 8 um; in its worst hour, around the steepest place, 8 sin(pi
    / 24) = 1.044 um."""
    (result,) = of(
        recording(
            4 * np.cos(2 * np.pi * T / 86400), T, T_air_C=20 + 0.5 * np.cos(2 * np.pi * T / 86400)
        )
    )
    assert result.test == "ETVE" and result.standard == "ISO 230-3" and result.subject == "ETVE_Z"
    assert result["ETVE_Z"].value == pytest.approx(8 * UM, rel=1e-6)
    assert result["ETVE_Z,1h"].value == pytest.approx(8 * np.sin(np.pi / 24) * UM, rel=1e-4)
    assert result["end"].value == pytest.approx(0, abs=1e-12)
    assert result["ETVE_Z"].U == pytest.approx(2 * np.sqrt(2) * 0.1 * UM)
    assert result["per K of T_air_C"].value == pytest.approx(8 * UM, rel=1e-9)


def test_a_spindle_that_turns_by_hand():
    """30 um (1 - exp(-t / 30 min)) for 4 h: after 60 min 30 (1 - exp(-2)) = 25.94 um, after all
    29.99 um."""
    t = np.arange(0.0, 4 * 3600 + 1, 60.0)
    (result,) = of(recording(30 * (1 - np.exp(-t / 1800)), t, rpm=6000.0))
    assert result.test == "rotating spindle" and result.subject == "dZ"
    assert result["dZ,60"].value == pytest.approx(30 * (1 - np.exp(-2)) * UM)
    assert result["dZ"].value == pytest.approx(30 * (1 - np.exp(-8)) * UM)


def test_two_pickups_tell_a_tilt_by_hand():
    """X drifts by 6 um at the nose and by 9 um 100 mm farther along the tool: 30 urad about Y."""
    near = recording(6 * T / T[-1], T, letter="X", head={"arm_mm": 0.0})
    far = recording(9 * T / T[-1], T, letter="X", name="b.csv", head={"arm_mm": 100.0})
    results = of(near, far)
    assert [r.subject for r in results] == ["ETVE_X", "ETVE_X", "ETVE_B"]
    assert results[-1]["ETVE_B"].value == pytest.approx(30 * URAD)
    assert results[-1]["ETVE_B"].U == pytest.approx(2 * np.sqrt(2) * np.hypot(0.1, 0.1) * UM / 100)


def test_the_interval_of_drift_per_kelvin_holds():
    """A frame of 5 um/K beside a wander that nobody recorded: the interval holds it in at least
    nine of ten draws."""
    rng, held = np.random.default_rng(2), 0
    for _ in range(60):
        air = 20 + np.cumsum(rng.normal(size=len(T))) * 0.02
        wander = np.cumsum(rng.normal(size=len(T)))
        wander = 0.3 * (wander - np.linspace(0, wander[-1], len(T))) / wander.std()
        (result,) = of(recording(5 * (air - 20) + wander, T, T_air_C=air))
        p = result["per K of T_air_C"]
        held += abs(p.value - 5 * UM) <= p.U
    assert held >= 54, held


@pytest.mark.parametrize(
    ("steps", "noise", "change", "hours"),
    [(0.1, 0.0, 1.0, 4), (0.5, 0.0, 5.0, 24), (0.0, 0.05, 1.0, 4), (0.1, 0.0, 0.4, 4)],
)
def test_a_thermometer_with_an_error_of_its_own_does_not_make_the_drift_small(
    steps, noise, change, hours
):
    """5 um/K; the thermometer reads in steps, or with noise. Forty parts of the time said 1.63 +-
    0.76, 1.30 +- 0.72 and 2.09 +- 1.07. Where it is told the interval holds it, or none is told."""
    t = np.arange(0.0, hours * 3600 + 1, 60.0)
    rng, told, held = np.random.default_rng(7), 0, 0
    for k in range(30):
        s = t / t[-1]
        air = 20 + rng.uniform() * steps + change * (s if k % 2 else np.sin(np.pi * s))
        shown = air + noise * rng.normal(size=len(t))
        shown = np.round(shown / steps) * steps if steps else shown
        moved = 5 * (air - 20) + 0.05 * rng.normal(size=len(t))
        (result,) = of(recording(moved, t, T_air_C=np.round(shown, 4)))
        p = next((p for p in result.parameters if p.name == "per K of T_air_C"), None)
        told += p is not None
        if p is not None:
            held += abs(p.value - 5 * UM) <= p.U
            assert p.U < 3 * UM
        else:
            assert any("no coefficient per kelvin" in n for n in result.notices)
    assert held >= 0.93 * told
    assert told == 30 if change > 0.5 else told <= 30


@pytest.mark.parametrize("number", [3, 5])
def test_three_readings_tell_nothing_per_kelvin(number):
    """0, 1, 2 um at 20, 20.5, 21 C were told as 0.0000 um/K."""
    n = np.arange(number, dtype=float)
    (result,) = of(recording(n, 600 * n, T_head_C=20 + 0.5 * n))
    assert not [p for p in result.parameters if p.name.startswith("per K")]
    assert any(
        "T_head_C" in text and "no coefficient per kelvin" in text for text in result.notices
    )


def test_thermometers_that_stand_still_are_named_in_one_sentence():
    n = np.arange(5, dtype=float)
    (result,) = of(recording(n, 600 * n, T_air_C=20 + 0.0 * n, T_bed_C=20 + 0.01 * n))
    assert "T_air_C, T_bed_C changed by 0.04 K at most: no coefficient per kelvin follows" in (
        result.notices
    )


def test_the_device_that_is_said_gives_the_tilt_its_u(recwarn):
    """0.2 um a reading, four of them, 100 mm apart: 2 sqrt(4) 0.2 / 100 mm = 8 urad. A column
    spindle_rpm without a number is none."""
    both = [
        recording(v * T / T[-1], T, rpm=np.nan, letter="X", name=n, head={"arm_mm": arm})
        for v, n, arm in ((6, "a.csv", 0.0), (9, "b.csv", 100.0))
    ]
    for one in both:
        del one.head["u_um"]
    results, _ = choose.results(both, Options(budget=Stated(device=0.2 * UM)))
    assert results[-1].subject == "ETVE_B"
    assert results[-1]["ETVE_B"].U == pytest.approx(8 * URAD)
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]


def test_without_time_or_along_two_axes_it_is_refused():
    with pytest.raises(IsoError, match="no axis moves"):
        of(recording(T[:5], 0 * T[:5]))
    with pytest.raises(IsoError, match="at rest, and read along"):
        of(recording(T, T, head={"sensitive": {"X": 0.6, "Z": 0.8}}))
