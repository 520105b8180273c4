"""Which component a recording is, by what moved and in which direction it was read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import CalibrationError, Options
from postproc.calibrate.assign import Diagonal, assign
from postproc.calibrate.run import calibrate
from postproc.machine.chain import parse
from postproc.recordings import Recording


def targets(
    moving: dict[str, np.ndarray], sensitive: dict[str, float], quantity: str, rest=None, **columns
) -> Recording:
    n = len(next(iter(moving.values())))
    places = {f"{x}_mm": np.asarray(q, float) for x, q in moving.items()}
    places |= {f"{x}_mm": np.full(n, at) for x, at in (rest or {}).items()}
    places |= {f"approach_{x}": np.ones(n) for x in moving}
    reading = "reading_urad" if quantity == "angle" else "reading_um"
    head = {"quantity": quantity, "sensitive": sensitive}
    return Recording(
        "targets", head, places | {reading: np.arange(n) * 1.0} | columns, "r.csv", np.arange(n) + 7
    )


Q = np.linspace(0, 400, 9)


@pytest.mark.parametrize("moving", "XYZ")
@pytest.mark.parametrize("along", "XYZ")
def test_translations_are_named_direction_first(moving, along):
    quantity = "displacement" if along == moving else "straightness"
    others = {x: 5.0 for x in "XYZ" if x != moving}
    series = assign(targets({moving: Q}, {along: 1.0}, quantity, others))
    assert (series.component, series.rest) == (f"E{along}{moving}", others)
    assert series.straight == (along != moving)
    assert series.reading == approx(np.arange(9) * 1e-3)


@pytest.mark.parametrize("about, letter", [("X", "A"), ("Y", "B"), ("Z", "C")])
def test_an_angle_is_named_by_its_axis_of_rotation(about, letter):
    series = assign(targets({"Y": Q}, {about: 1.0}, "angle"))
    assert series.component == f"E{letter}Y"
    assert series.angle and series.reading == approx(np.arange(9) * 1e-6)


def test_a_reading_along_the_negative_direction_is_turned_round():
    series = assign(targets({"Z": Q}, {"Z": -1.0}, "displacement"))
    assert series.reading == approx(-np.arange(9) * 1e-3)


def test_a_displacement_across_the_axis_is_a_straightness_and_said_so():
    series = assign(targets({"X": Q}, {"Z": 1.0}, "displacement"))
    assert series.component == "EZX"
    assert "straightness" in series.notices[0]


def test_a_rotary_axis_has_components_too():
    n = 13
    recording = Recording(
        "targets",
        {"quantity": "angle", "sensitive": {"Z": 1.0}},
        {"C_deg": np.linspace(0, 360, n), "approach_C": np.ones(n), "reading_urad": np.zeros(n)},
        "c.csv",
        np.arange(n),
    )
    assert assign(recording).component == "ECC"


WRONG = {
    "nothing moves": (targets({"X": np.full(5, 3.0)}, {"X": 1.0}, "displacement"), "no axis moves"),
    "oblique": (targets({"X": Q}, {"X": 0.6, "Z": 0.8}, "displacement"), "oblique"),
    "straightness along itself": (targets({"X": Q}, {"X": 1.0}, "straightness"), "along X itself"),
    "length about C": (targets({"X": Q}, {"C": 1.0}, "displacement"), "rotary"),
    "two axes at an angle": (targets({"X": Q, "Z": Q}, {"X": 1.0}, "displacement"), "45.0 degrees"),
    "two axes and an angle": (
        targets({"X": Q, "Z": Q}, {"X": 0.70710678, "Z": 0.70710678}, "angle"),
        "angle",
    ),
    "two axes in a curve": (
        targets({"X": Q, "Z": Q**2 / 400}, {"X": 0.70710678, "Z": 0.70710678}, "displacement"),
        "straight line",
    ),
    "a circle": (replace(targets({"X": Q}, {"X": 1.0}, "displacement"), kind="ballbar"), "ballbar"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_fits_nothing_is_refused_with_the_reason(name):
    recording, says = WRONG[name]
    with pytest.raises(CalibrationError, match=says) as caught:
        assign(recording)
    assert caught.value.place.file == "r.csv"
    assert caught.value.advice or name == "straightness along itself"


def test_axes_that_move_in_proportion_make_a_diagonal():
    diagonal = assign(
        targets({"X": Q, "Z": 300 - 0.75 * Q}, {"X": 0.8, "Z": -0.6}, "displacement", {"Y": 20.0})
    )
    assert isinstance(diagonal, Diagonal)
    assert diagonal.direction == approx({"X": 0.8, "Z": -0.6})
    assert (diagonal.name, diagonal.rest) == ("+X-Z", {"Y": 20.0})
    assert (diagonal.approach == 1).all()


def test_what_is_refused_does_not_stop_the_others():
    good = targets({"Z": Q}, {"Z": 1.0}, "displacement", {"X": 0.0})
    bad, foreign = WRONG["oblique"][0], targets({"Y": Q}, {"Y": 1.0}, "displacement")
    result = calibrate([bad, good, foreign], Options(parse("w-b-Z-X-t")))
    assert list(result.components) == ["EZZ"]
    assert "oblique" in result.refused[0].message
    assert "no Y" in result.refused[1].message


def test_nothing_usable_is_an_error():
    with pytest.raises(CalibrationError, match="oblique"):
        calibrate([WRONG["oblique"][0]], Options(parse("w-b-Z-X-t")))


def test_rows_that_do_not_say_their_direction_are_not_used_in_silence():
    n = 18
    columns = {"approach_Z": np.r_[np.zeros(1), np.ones(8), -np.ones(9)]}
    recording = targets({"Z": np.r_[Q, Q[::-1]]}, {"Z": 1.0}, "displacement", {"X": 0.0}, **columns)
    assert len(recording) == n
    result = calibrate([recording], Options(parse("w-b-Z-X-t")))
    assert any("of 1 of its readings" in f.message for f in result.findings)
    assert result.components["EZZ"].filled == ((0, 0),)


def test_without_a_column_of_the_direction_the_reversal_is_said_to_be_unknown():
    whole = targets({"Z": Q}, {"Z": 1.0}, "displacement")
    less = {name: column for name, column in whole.columns.items() if name != "approach_Z"}
    said = assign(replace(whole, columns=less)).notices
    assert [s for s in said if "no column approach_Z" in s] and not assign(whole).notices
