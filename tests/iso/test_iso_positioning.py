"""ISO 230-2 by hand, and what must hold for any readings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iso_made import UM, along, runs_of, targets

from postproc.iso import Options, choose
from postproc.iso.positioning import MEANS, aliases, evaluate, spacing

# By hand, three runs each way at two targets, um:
#   at 0:   + 1 2 3: mean 2, s 1;   - -1 -1 -1: mean -1, s 0;  B_1 = 3;  middle 0.5
#   at 100: + 4 6 8: mean 6, s 2;   - 1 3 2:    mean 2,  s 1;  B_2 = 4;  middle 4
POSITION = np.tile([0.0, 100.0], 6)
APPROACH = np.repeat([1.0, -1.0], 6)
READING = np.array([1, 4, 2, 6, 3, 8, -1, 1, -1, 3, -1, 2], float)
BY_HAND = {
    "E+": 4,  # 6 - 2
    "E-": 3,  # 2 - (-1)
    "E": 7,  # 6 - (-1)
    "M": 3.5,  # 4 - 0.5
    "B": 4,  # max(3, 4)
    "Bm": 3.5,  # (3 + 4) / 2
    "R+": 8,  # 4 * 2
    "R-": 4,  # 4 * 1
    "R": 10,  # at 0: max(2*1 + 2*0 + 3, 4, 0) = 5; at 100: max(2*2 + 2*1 + 4, 8, 4) = 10
    "A+": 10,  # max(2 + 2, 6 + 4) - min(2 - 2, 6 - 4) = 10 - 0
    "A-": 5,  # max(-1, 2 + 2) - min(-1, 2 - 2) = 4 - (-1)
    "A": 11,  # max(4, 10, -1, 4) - min(0, 2, -1, 0) = 10 - (-1)
}


@pytest.mark.parametrize("name", BY_HAND)
def test_every_parameter_by_hand(name):
    assert evaluate(POSITION, APPROACH, READING * UM).values[name] == pytest.approx(
        BY_HAND[name] * UM, abs=1e-12
    )


def test_means_and_s_of_every_target_by_hand():
    test = evaluate(POSITION, APPROACH, READING * UM)
    assert test.mean / UM == pytest.approx(np.array([[2, 6], [-1, 2]]))
    assert test.s / UM == pytest.approx(np.array([[1, 2], [0, 1]]))
    assert test.reversal / UM == pytest.approx([3, 4])
    assert test.repeatability / UM == pytest.approx(np.array([[4, 8], [0, 4], [5, 10]]))
    assert set(BY_HAND) == set(MEANS)


def test_repeatability_of_one_direction_can_be_the_larger():
    # + -5 5: s = 7.071, R+ = 28.28; - 0 0: s = 0, B = 0: 2 * 7.071 + 0 + 0 = 14.14 is less than R+.
    values = evaluate(np.zeros(4), np.array([1, 1, -1, -1]), np.array([-5.0, 5, 0, 0])).values
    assert values["R"] == values["R+"] == pytest.approx(4 * np.sqrt(50))


def test_one_direction_defines_no_two_way_parameter():
    up = APPROACH > 0
    values = evaluate(POSITION[up], APPROACH[up], READING[up]).values
    assert {n for n, v in values.items() if v is None} == {
        "E",
        "E-",
        "M",
        "B",
        "Bm",
        "R",
        "R-",
        "A",
        "A-",
    }
    assert (values["E+"], values["R+"], values["A+"]) == (4, 8, 10)


def test_pure_reversal_is_all_that_is_found():
    # An axis 4 um behind when it comes from above: B = E = 4, R = |B| = 4, M = 0, R+ = R- = 0 (ISO
    # 230-2).
    values = evaluate(
        np.tile([0.0, 50, 100], 4), np.repeat([1, -1, 1, -1], 3), np.repeat([0, -4, 0, -4], 3) * 1.0
    ).values
    assert (values["B"], values["Bm"], values["E"], values["R"]) == (4, 4, 4, 4)
    assert values["M"] == values["R+"] == values["R-"] == values["A+"] == 0


def test_an_axis_longer_than_two_metres_has_no_scatter():
    position, approach = np.tile([0.0, 1000, 2001], 4), np.repeat([1, -1, 1, -1], 3)
    values = evaluate(position, approach, np.arange(12.0)).values
    assert {n for n, v in values.items() if v is None} == {"R", "R+", "R-", "A", "A+", "A-"}
    shorter = evaluate(position * 0.99, approach, np.arange(12.0)).values
    assert None not in shorter.values()


def test_a_lone_reading_at_one_target_leaves_scatter_undefined():
    # two runs + at 0: still defined
    values = evaluate(POSITION[1:], APPROACH[1:], READING[1:]).values
    assert values["A+"] is not None
    values = evaluate(
        np.delete(POSITION, [0, 2]), np.delete(APPROACH, [0, 2]), np.delete(READING, [0, 2])
    ).values
    assert values["A+"] is values["A"] is values["R"] is None and values["A-"] == 5


def test_readings_without_direction_are_left_out():
    added = evaluate(np.append(POSITION, 0), np.append(APPROACH, 0), np.append(READING, 1e6)).values
    assert added == evaluate(POSITION, APPROACH, READING).values
    with pytest.raises(ValueError):
        evaluate(POSITION, 0 * APPROACH, READING)


some = st.integers(0, 2**32 - 1)


def drawn(seed):
    generator = np.random.default_rng(seed)
    m, n = int(generator.integers(2, 8)), int(generator.integers(2, 6))
    position = np.sort(generator.choice(1000, m, replace=False)).astype(float)
    return runs_of(position, generator.normal(size=(2, m)), generator.normal(size=(2, n, m)))


def near(one, two):
    return all(one[n] == pytest.approx(two[n], rel=1e-9, abs=1e-9) for n in MEANS)


@settings(max_examples=60, deadline=None)
@given(some, st.floats(-100, 100), st.floats(0.1, 10))
def test_shift_scale_and_order(seed, shift, scale):
    position, approach, reading, _ = drawn(seed)
    values = evaluate(position, approach, reading).values
    assert near(evaluate(position, approach, reading + shift).values, values)
    assert near(evaluate(position + shift, approach, reading).values, values)
    scaled = evaluate(position, approach, reading * scale).values
    assert near(scaled, {n: v * scale for n, v in values.items()})
    order = np.random.default_rng(seed).permutation(len(position))
    assert near(evaluate(position[order], approach[order], reading[order]).values, values)


@settings(max_examples=60, deadline=None)
@given(some)
def test_turning_the_direction_of_travel_negates_the_reversal(seed):
    position, approach, reading, _ = drawn(seed)
    test, turned = evaluate(position, approach, reading), evaluate(position, -approach, reading)
    assert turned.reversal == pytest.approx(-test.reversal)
    assert turned.values["Bm"] == pytest.approx(-test.values["Bm"])
    for name, other in (
        ("E", "E"),
        ("R", "R"),
        ("A", "A"),
        ("M", "M"),
        ("B", "B"),
        ("E+", "E-"),
        ("R-", "R+"),
        ("A+", "A-"),
    ):
        assert turned.values[name] == pytest.approx(test.values[other])


@settings(max_examples=60, deadline=None)
@given(some)
def test_parameters_contain_each_other(seed):
    position, approach, reading, _ = drawn(seed)
    v = evaluate(position, approach, reading).values
    assert (
        v["M"] <= v["E"] + 1e-12
        and max(v["E+"], v["E-"]) <= v["E"] + 1e-12
        and v["E"] <= v["A"] + 1e-12
    )
    assert (
        v["B"] <= v["R"] + 1e-12
        and abs(v["Bm"]) <= v["B"] + 1e-12
        and max(v["A+"], v["A-"]) <= v["A"] + 1e-12
    )


def test_more_noise_does_not_lower_accuracy_in_expectation():
    generator = np.random.default_rng(2)
    position, means = (
        np.arange(0, 300, 30.0),
        np.stack([np.linspace(0, 5, 10), np.linspace(-1, 3, 10)]),
    )
    noises = generator.normal(size=(300, 2, 5, 10))
    expected = [
        np.mean([evaluate(*runs_of(position, means, s * one)).values["A"] for one in noises])
        for s in (0, 0.3, 1, 3)
    ]
    assert np.all(np.diff(expected) > 0.3)


def test_lead_that_the_targets_hide():
    equal = np.arange(0, 301, 30.0)
    assert spacing(equal) == 30
    assert spacing(equal + np.array([0, 3, 1, 0, 7, 2, 4, 1, 9, 0, 0])) is None
    # 30 mm are 3 turns of a 10 mm lead, and 6, 9, 12 of its parts; of a 20 mm lead 1.5, 3, 4.5, 6
    # turns.
    assert [(k, words.split(":")[0]) for k, words in aliases(equal, 10)] == [
        (k, "invisible") for k in (1, 2, 3, 4)
    ]
    assert [(k, words.split()[0].strip(":")) for k, words in aliases(equal, 20)] == [
        (1, "a"),
        (2, "invisible"),
        (3, "a"),
        (4, "invisible"),
    ]
    # 30 mm in a 25 mm lead are 1.2 turns: it looks like a wave of 30 / 0.2 = 150 mm.
    assert aliases(equal, 25)[0] == (1, "looks like a wave of 150 mm")
    assert aliases(equal + np.random.default_rng(1).uniform(0, 10, 11), 10) == []


def said(recording, **options):
    (result,), _ = choose.results([recording], Options(**options))
    return "\n".join(result.notices)


def test_departures_from_the_standard_are_said():
    few = along("X", np.arange(0, 301, 30.0), np.zeros((2, 11)))
    assert "equidistant, 30 mm apart" in said(few)
    assert "period 10 mm (the lead of 10 mm): invisible" in said(few, leads={"X": 10})
    assert "period" not in said(few, leads={"Z": 7}).replace("errors with a period", "")
    assert "3 targets on 100 mm: the standard asks for 5" in said(
        along("X", [0, 40, 100], np.zeros((2, 3)))
    )
    position, approach, reading, run = runs_of(
        np.array([0.0, 31, 62, 90, 120]), np.zeros((2, 5)), np.ones((2, 3, 5))
    )
    assert "n = 3 runs each way, the standard asks for 5" in said(
        targets({"X": position}, reading, approach, {"X": 1.0}, run=run)
    )
    up = approach > 0
    assert "approached in + only" in said(
        targets({"X": position[up]}, reading[up], approach[up], {"X": 1.0})
    )
    assert "longer than 2 m" in said(along("X", np.linspace(0, 2500, 11), np.zeros((2, 11))))
    gone = np.delete(np.arange(30), -1)
    whole = targets({"X": position}, reading, approach, {"X": 1.0}).pick(gone)
    assert "between 2 and 3 runs" in said(whole)
    lone = targets({"X": position}, reading, approach, {"X": 1.0})
    assert "one direction only at 120" in said(lone.pick(~((position == 120) & (approach < 0))))


def test_a_rotary_axis_is_evaluated_in_its_own_units():
    position, approach, reading, run = runs_of(
        np.arange(0, 360, 45.0), np.arange(16.0).reshape(2, 8)
    )
    recording = targets({"C": position}, reading, approach, {"C": 1.0}, "angle", run)
    (result,), _ = choose.results([recording], Options())
    assert (result.test, result.subject.split(",")[0], result.unit) == ("rotary", "ECC", "urad")
    assert result["E"].value == pytest.approx(15e-6) and result["B"].value == pytest.approx(8e-6)
