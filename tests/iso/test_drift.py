"""ISO 230-3: slides at rest. Ranges by hand, tilt by hand, drift per kelvin against a line that is known."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.iso import IsoError, Options, choose
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
    """4 um of cosine over 24 h: range 8 um; in its worst hour, around the steepest place, 8 sin(pi / 24) = 1.044 um."""
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
    """30 um (1 - exp(-t / 30 min)) for 4 h: after 60 min 30 (1 - exp(-2)) = 25.94 um, after all 29.99 um."""
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
    """A frame of 5 um/K beside a wander that nobody recorded: the interval holds it in at least nine of ten draws."""
    rng, held = np.random.default_rng(2), 0
    for _ in range(60):
        air = 20 + np.cumsum(rng.normal(size=len(T))) * 0.02
        wander = np.cumsum(rng.normal(size=len(T)))
        wander = 0.3 * (wander - np.linspace(0, wander[-1], len(T))) / wander.std()
        (result,) = of(recording(5 * (air - 20) + wander, T, T_air_C=air))
        p = result["per K of T_air_C"]
        held += abs(p.value - 5 * UM) <= p.U
    assert held >= 54, held


def test_without_time_or_along_two_axes_it_is_refused():
    with pytest.raises(IsoError, match="no axis moves"):
        of(recording(T[:5], 0 * T[:5]))
    with pytest.raises(IsoError, match="at rest, and read along"):
        of(recording(T, T, head={"sensitive": {"X": 0.6, "Z": 0.8}}))
