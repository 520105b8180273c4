"""The judge: hand-made answers to hand-made truths."""

from __future__ import annotations

import json

import numpy as np
import pytest

from proof import score, trial_run, trial_tests
from proof.score import judge, same, spotted
from proof.score_table import lines, quantile, share, table, wilson


def truth(effect, axis="X", peak=5.0, visible=True, **more):
    return {
        "effect": effect,
        "axis": axis,
        "peak_um": peak,
        "visible": visible,
        "parameters": {},
        "twins": [],
    } | more


def said(*effects, unknown=None, fit=None, blank=()):
    return {
        "effects": list(effects),
        "unknown": unknown,
        "verdict": "",
        "fit": fit,
        "not_visible": list(blank),
    }


def effect(
    name, axis="X", rms=1.0, status="accepted", equivalent=(), parameters=None, next_test=None
):
    return {
        "effect": name,
        "axis": axis,
        "status": status,
        "rms_explained_um": rms,
        "equivalent": list(equivalent),
        "parameters": parameters or {},
        "next_test": next_test,
    }


def test_names_are_the_same_by_effect_and_axis():
    assert same("squareness:XZ", "squareness:ZX") and same("backlash:X", "backlash:X")
    assert not same("backlash:X", "backlash:Z") and not same("backlash:X", "windup:X")
    assert same("laser_air:Z", "laser_air:") and not same("cosine:Z", "cosine:X")
    assert same("cosine:Z", "cosine:")  # of a beam along a diagonal


def test_the_first_name_is_the_one_that_explains_most():
    o = judge(
        "c",
        "single",
        [truth("backlash")],
        said(effect("scale", rms=0.2), effect("backlash", rms=2.0)),
    )
    assert o.names == ["backlash:X", "scale:X"] and o.top == [True] and o.wrong == ["scale:X"]
    o = judge(
        "c",
        "single",
        [truth("backlash")],
        said(effect("scale", rms=3.0), effect("backlash", rms=2.0)),
    )
    assert o.top == [False] and o.named == [True]


def test_only_accepted_names_count_and_sets_are_distinguished_from_names():
    o = judge(
        "c",
        "single",
        [truth("windup")],
        said(effect("windup", status="tentative"), effect("backlash", equivalent=["windup:X"])),
    )
    assert o.names == ["backlash:X"] and (o.top, o.named, o.in_set) == ([False], [False], [True])


def test_an_invisible_truth_asks_for_nothing_and_naming_it_is_no_mistake():
    o = judge("c", "pair", [truth("scale"), truth("bow", visible=False)], said(effect("bow")))
    assert o.truths == ["scale:X"] and o.named == [False] and o.wrong == []


def test_no_answer_is_a_failure_and_no_name():
    o = judge("c", "single", [truth("scale")], None)
    assert o.failed and o.names == [] and o.top == [False]


def test_parameters_are_held_against_the_truth_and_their_intervals():
    found = {
        "size_um": {"value": 9.1, "ci95": [8.7, 9.5]},
        "play_mm": {"value": 0.01, "ci95": [0.01, 0.01]},
    }
    right = truth("backlash", parameters={"size_um": 10.0, "play_mm": 0.02})
    o = judge("c", "single", [right], said(effect("backlash", parameters=found)))
    assert o.errors == [("backlash", pytest.approx(0.09))]
    assert o.inside == [False]  # an interval of no width is none


def test_the_same_name_twice_is_one_name_and_the_larger_part_tells_its_size():
    parts = [{"amplitude_um": {"value": v, "ci95": [v - 0.1, v + 0.1]}} for v in (6.0, 1.5)]
    both = [effect("cyclic", rms=r, parameters=p) for r, p in zip((4.0, 1.0), parts, strict=True)]
    o = judge(
        "c", "single", [truth("cyclic", parameters={"amplitude_um": 6.05})], said(*reversed(both))
    )
    assert (
        o.names == ["cyclic:X"]
        and o.errors == [("cyclic", pytest.approx(0.05 / 6.05))]
        and o.inside == [True]
    )


def test_wilson_as_published():
    """Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3: 81 of 263, and 0 of 20."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(0, 0) == (0.0, 1.0)


def test_quantiles_are_those_of_numpy():
    values = [3.0, 1.0, 7.0, 2.0]
    assert [quantile(values, q) for q in (0.0, 0.5, 0.9)] == pytest.approx(
        np.quantile(values, (0.0, 0.5, 0.9)).tolist()
    )


def row(rows, start):
    return next(r for r in rows if r.name.startswith(start))


def test_the_table_counts_what_it_says():
    outcomes = [
        judge("n1", "null", [], said()),
        judge("n2", "null", [], said(effect("scale"))),
        judge("a1", "adversarial", [], said(unknown={})),
        judge("s1", "single", [truth("scale", peak=9.0)], said(effect("scale"), unknown={})),
        judge("s2", "single", [truth("scale", peak=9.0)], said(effect("bow"))),
        judge("s3", "single", [truth("scale", peak=3.0)], said()),
        judge(
            "p1",
            "pair",
            [truth("scale"), truth("screw_heat")],
            said(effect("scale"), effect("sag")),
        ),
        judge(
            "w1", "withheld", [truth("abbe")], said(effect("pitch_shape", equivalent=["abbe:X"]))
        ),
        judge("x1", "alien", [truth("alien:x")], said(effect("scale"), unknown={})),
    ]
    rows = lines(outcomes, [])
    assert (row(rows, "nulls with any").hits, row(rows, "nulls with any").count) == (1, 2)
    assert row(rows, "nulls with any").met is False and row(rows, "adversarial").met is True
    assert (row(rows, "one effect, 8").hits, row(rows, "one effect, 8").count) == (1, 2)
    assert row(rows, "one effect, 2").value == 0.0 and row(rows, "one effect, 4").met is None
    assert (row(rows, "one effect: right").hits, row(rows, "one effect: right").count) == (1, 2)
    assert (
        row(rows, "pairs and triples: precision").hits,
        row(rows, "pairs and triples: recall").hits,
    ) == (1, 1)
    assert row(rows, "  of these").count == 2  # screw_heat and scale are confusable
    assert (
        row(rows, "driver withheld").value == 1.0
        and row(rows, "alien physics: called").value == 1.0
    )
    assert (
        row(rows, "alien physics: library").value == 1.0
        and row(rows, "one effect, well named").value == 1.0
    )
    assert any(
        "s2 (single) scale:X of 9.0 um: said bow:X" in text
        for text in row(rows, "one effect, 8").failures
    )
    assert "| nulls with any name | 2 | 0.500 |" in table(rows) and "no case" in table(rows)


def test_a_target_of_at_most_lists_the_hits_as_failures():
    line = share("x", [(True, "bad"), (False, "good")], most=0.1)
    assert line.failures == ["bad"] and line.met is False


BLIND = {
    "spot": "one_arm",
    "suspects": ["abbe:X", "pitch_shape:X"],
    "test": "the same line at a second arm",
}


def test_a_blind_spot_is_named_as_not_visible_or_in_a_set():
    later = judge("b", "follow-up", [truth("abbe")], said(effect("abbe")))
    blank = [
        {
            "effect": "abbe",
            "axis": "X",
            "why": "one line",
            "next_test": "gcomp simulate --test positioning:X",
        }
    ]
    assert score.openly(said(blank=blank), BLIND) == (True, ["gcomp simulate --test positioning:X"])
    one_of_two = said(effect("pitch_shape", equivalent=["abbe:X"], next_test="t"))
    found = spotted("b", BLIND, one_of_two, [True], later)
    assert found.named and found.tested and found.hidden and found.followed
    assert not spotted("b", BLIND, said(effect("pitch_shape")), [], later).named
    assert not spotted("b", BLIND, one_of_two, [False], later).tested


def test_with_one_direction_every_kind_of_lost_motion_must_be_named():
    blind = {"spot": "one_direction", "suspects": ["backlash:X", "windup:X"]}
    blank = [{"effect": "backlash", "axis": "X", "next_test": "t"}]
    assert not score.openly(said(blank=blank), blind)[0]
    assert score.openly(
        said(blank=[*blank, {"effect": "windup", "axis": "X", "next_test": "t"}]), blind
    )[0]


def targets(x, approach=None, **more):
    columns = {"X_mm": np.array([f"{v:.3f}" for v in x])}
    columns["approach_X"] = np.array(["1"] * len(x) if approach is None else approach)
    return columns | {k: np.array([f"{v:.3f}" for v in values]) for k, values in more.items()}


def test_whether_a_test_would_show_the_spot_is_judged_by_where_it_goes():
    lead = {"spot": "lead_multiples", "suspects": ["cyclic:X"]}
    assert not trial_tests.seen(lead, "", targets(np.arange(0, 200, 10.0)))
    assert not trial_tests.seen(lead, "", targets(np.arange(0, 200, 5.0)))
    assert trial_tests.seen(lead, "", targets(np.arange(0, 200, 7.3)))
    lost = {"spot": "one_direction", "suspects": ["backlash:X"]}
    assert not trial_tests.seen(lost, "", targets([1, 2, 3]))
    assert trial_tests.seen(lost, "", targets([1, 2, 1], ["1", "1", "-1"]))
    assert not trial_tests.seen(lost, "", {"Z_mm": np.array(["1", "2"])})
    assert not trial_tests.seen(BLIND, "", targets([1, 2, 3], Z_mm=[5, 5, 5]))
    assert trial_tests.seen(BLIND, "", targets([1, 2, 3], Z_mm=[5, 5, 60]))
    sense = {"spot": "one_sense", "suspects": ["squareness:XZ"]}
    circle = {"X_cmd_mm": np.array(["0", "1"]), "Z_cmd_mm": np.array(["0", "1"])}
    assert not trial_tests.seen(sense, "", circle | {"sense": np.array(["1", "1"])})
    assert trial_tests.seen(sense, "", circle | {"sense": np.array(["1", "-1"])})


def test_a_fit_that_its_residuals_do_not_bear_out_is_reported(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(
        "recording,row,signal,measured_um,before_um,after_um,held_out\na,1,s,0,0,3.0,1\na,2,s,0,0,4.0,1\na,3,s,0,0,9,0\n"
    )
    assert trial_run.believed({"fit": {"rms_after_um": 12.5**0.5}}, path) == ""
    assert "states 1.0" in trial_run.believed({"fit": {"rms_after_um": 1.0}}, path)
    assert trial_run.believed({"fit": {"rms_after_um": None}}, path) == ""


def test_a_kept_score_is_the_same_again_with_a_line_for_each_case():
    found = {
        "now": [{"case": "a", "names": []}, {"case": "b", "names": ["scale:X"]}],
        "failures": "none",
        "blind": [],
    }
    text = score.kept(found)
    assert json.loads(text) == found and text.count("\n") == 8
