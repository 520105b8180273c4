"""The uncertainty of the parameters: each term by hand, and whether U covers the truth as often as
it says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from iso_made import UM, along, runs_of, seed, targets

from postproc.iso import Options, Stated, choose, straightness
from postproc.iso.chance import chi_squared_tail, f_tail, student
from postproc.iso.positioning import evaluate
from postproc.iso.sampling import noise_of
from postproc.iso.uncertainty import of_positioning, rectangular
from tests.campaigns import cases


def test_distributions_against_printed_tables():
    """JCGM 100:2008 table G.2; F(0.05; 3, 10) = 3.708, chi-squared(0.05; 5) = 11.070 of any
    statistics table."""
    for dof, t in ((1, 13.97), (2, 4.53), (4, 2.87), (10, 2.28), (50, 2.05)):
        assert student(dof) == pytest.approx(t, abs=0.006)
    assert student(4, 0.95) == pytest.approx(2.776, abs=5e-4) and student(1e9) == pytest.approx(
        2.0, abs=1e-3
    )
    assert f_tail(3.708, 3, 10) == pytest.approx(0.05, abs=5e-5)
    assert chi_squared_tail(11.070, 5) == pytest.approx(0.05, abs=2e-5)


BUDGET = Stated(
    device=0.2 * UM,
    misalignment=1e-3,
    alpha=11.5e-6,
    u_alpha=1e-6,
    temperature=23.0,
    u_temperature=0.5,
    drift=1.2 * UM,
    square=5e-6,
)
BY_HAND = {  # um, k = 1, over 500 mm
    "device": 0.2828,  # sqrt 2 * 0.2
    "misalignment": 0.07217,  # 500 (1 - cos 0.001) = 0.00025 mm = 0.25 um, / (2 sqrt 3)
    "temperature": 2.875,  # 11.5e-6 * 500 mm * 0.5 K
    "expansion": 1.5,  # 500 mm * 3 K * 1e-6
    "drift": 0.3464,  # 1.2 / (2 sqrt 3)
}


def one_run(**options):
    recording = along(
        "X", np.linspace(0, 500, 11), np.stack([np.arange(11.0), np.arange(11.0) - 1])
    )
    (result,), _ = choose.results([recording], Options(**options))
    return result


def test_every_term_by_hand():
    result = one_run(budget=BUDGET)
    assert {t.name: t.u / UM for t in result.terms} == pytest.approx(BY_HAND, rel=1e-3)
    # E: all of them; 2 sqrt(0.2828^2 + 0.07217^2 + 2.875^2 + 1.5^2 + 0.3464^2) = 6.548.
    assert result["E"].U / UM == pytest.approx(6.548, abs=2e-3)
    # B: what grows with length cancels; 2 sqrt(0.2828^2 + 0.3464^2) = 0.894. R is not defined.
    assert result["B"].U / UM == pytest.approx(0.894, abs=1e-3)
    assert result["R"].U is None and result["E"].runs is None
    assert not any("not stated" in n for n in result.notices)


def test_rectangular_by_hand():
    # ISO/TR 230-9: U = 2u = 0.58 of the range.
    assert 2 * rectangular(1.0) == pytest.approx(0.577, abs=1e-3)


def test_what_is_not_stated_is_named_and_nothing_stated_is_no_zero():
    result = one_run()
    assert result["E"].U is None and not result.terms
    assert any(
        "not in U, since not stated: the device, drift, misalignment, temperature, expansion" in n
        for n in result.notices
    )
    recording = along("X", [0, 100, 200], np.zeros((2, 3)), u_um=0.5)
    (result,), _ = choose.results([recording], Options())
    assert result["E"].U == pytest.approx(2 * math.sqrt(2) * 0.5 * UM)
    assert "the recording's head" in result.terms[0].said


def test_lengths_play_no_part_in_straightness_and_angles():
    one = along("X", [0, 100, 200, 300], np.zeros((2, 4)), {"Y": 1.0}, "straightness")
    two = along("Y", [0, 100, 200, 300], np.zeros((2, 4)), {"X": 1.0}, "straightness")
    found, _ = choose.results([one, two], Options(budget=BUDGET))
    assert {t.name for t in found[0].terms} == {"device", "drift"}
    # squareness: the square 5 urad, and sqrt 2 * 0.2 um over 300 mm = 0.943 urad from each run; 2
    # sqrt(25 + 2 * 0.889) = 10.35.
    assert found[2]["C0Y"].U == pytest.approx(10.35e-6, abs=1e-8)
    angle = along("X", [0, 100, 200], np.zeros((2, 3)), {"Z": 1.0}, "angle", u_um=0.4)
    (result,), _ = choose.results([angle], Options(budget=BUDGET))
    assert (result.subject.split(",")[0], result["E"].U) == (
        "ECX",
        pytest.approx(2 * math.sqrt(2) * 0.4e-6),
    )


def test_scatter_with_clear_extremes_is_student_s_t_of_two_means():
    """Two targets far apart, s = 1 at each, n = 5, 16 degrees of freedom: U = t(95 %, 16) sqrt(2/5)
    = 2.120 * 0.6325 = 1.341."""
    noise = np.array([-1.2649, -0.63246, 0, 0.63246, 1.2649])  # mean 0, s 1
    noise = np.tile(noise[None, :, None], (2, 1, 2))
    test = evaluate(*runs_of(np.array([0.0, 100]), np.array([[0, 90.0], [5, 100.0]]), noise))
    runs = of_positioning(test)
    assert runs["E"] == pytest.approx(1.341, rel=0.05)  # 1000 draws
    assert runs["E+"] == pytest.approx(1.341, rel=0.05) and runs["B"] == pytest.approx(
        1.341, rel=0.05
    )
    # Bm: mean of two differences, u = sqrt(2/5) / sqrt 2 = 0.4472, t(95.45 %, 16) = 2.17: 0.970.
    assert runs["Bm"] == pytest.approx(0.970, abs=2e-3)
    # R+: u(s) = 1 / sqrt 8 = 0.3536; U = 2 * 4 * 0.3536 = 2.828. A: 2 sqrt(2 (1/5 + 4/8)) = 2.366.
    assert (runs["R+"], runs["A"]) == pytest.approx((2.828, 2.366), abs=2e-3)


def test_no_scatter_is_no_uncertainty_and_one_run_is_not_known():
    same = evaluate(*runs_of(np.arange(5.0), np.ones((2, 5)) * [[1], [2]], np.zeros((2, 3, 5))))
    assert set(of_positioning(same).values()) == {0.0}
    assert of_positioning(evaluate(*runs_of(np.arange(5.0), np.ones((2, 5))))) == {}


def test_a_cell_that_scatters_more_keeps_a_scatter_of_its_own():
    n = np.full((2, 4), 5)
    even = noise_of(np.array([[1, 1.3, 0.9, 1.1], [0.8, 1, 1.2, 1]]), n)
    assert even.pooled and np.ptp(even.u) == 0 and even.dof[0, 0] == 32
    odd = noise_of(np.array([[1, 1, 1, 9.0], [1, 1, 1, 1]]), n)
    # common variance (7 + 81) / 8 = 11; of the odd cell (4 * 81 + 4 * 11) / 8 = 46, of the others
    # (4 + 44) / 8 = 6.
    assert (
        not odd.pooled
        and odd.u[0] == pytest.approx(np.sqrt(np.array([6, 6, 6, 46]) / 5))
        and odd.dof[0, 0] == 8
    )
    assert noise_of(np.full((2, 4), np.nan), np.ones((2, 4))) is None


TESTS = cases(500, 2000)
NEAR = 0.02 * math.sqrt(2000 / TESTS)  # of the share covered: four standard deviations


def coverage(position, means, s, n=5, tests=TESTS):
    """Share of the tests in which U of the scatter covers the true value."""
    true = evaluate(*runs_of(position, means)).values
    generator = np.random.default_rng(230)
    hits = dict.fromkeys(("E", "B", "Bm", "M"), 0)
    for _ in range(tests):
        test = evaluate(*runs_of(position, means, s * generator.normal(size=(2, n, len(position)))))
        runs = of_positioning(test)
        for name in hits:
            hits[name] += abs(test.values[name] - true[name]) <= runs[name]
    return {name: hit / tests for name, hit in hits.items()}


@pytest.mark.parametrize("column", ["dzz", "dxx", "dzx"])
def test_coverage_on_the_seed_s_axes(column):
    """Tests of n = 5 runs, s = 1 um, the seed's means as the truth: U is to cover it in 95 % of
    them."""
    position, means = seed(column)
    found = coverage(position, means, 1.0 * UM)
    assert all(abs(found[name] - 0.95) <= NEAR for name in ("E", "B", "Bm")), found


def test_coverage_where_every_target_competes():
    """A plain step of 2 um at 20 targets: the largest of 20 noisy reversals is far above the true
    one in every test."""
    means = np.stack([np.ones(20), -np.ones(20)]) * UM
    found = coverage(np.arange(20) * 25.0, means, 1.0 * UM)
    assert all(abs(share - 0.95) <= NEAR for share in found.values()), found


@pytest.mark.parametrize(
    ("kind", "tests", "least"),
    [("least-squares", 1000, 0.93), ("end-point", 1000, 0.93), ("minimum-zone", 60, 0.88)],
)
def test_coverage_of_straightness_and_slope(kind, tests, least):
    """On the seed's dxz with s = 0.5 um. The narrowest zone is slow to draw again: 60 tests, chance
    alone is +-5.5 %."""
    position, means = seed("dxz")
    truth = straightness.evaluate(kind, evaluate(*runs_of(position, means)))
    generator, hits = np.random.default_rng(1), np.zeros(2)
    for _ in range(tests):
        test = evaluate(
            *runs_of(position, means, 0.5 * UM * generator.normal(size=(2, 5, len(position))))
        )
        found, runs = (
            straightness.evaluate(kind, test),
            straightness.from_runs(kind, test, "straightness"),
        )
        hits[0] += abs(found.errors["straightness"] - truth.errors["straightness"]) <= runs[0]
        hits[1] += (
            abs(found.lines["straightness"].slope - truth.lines["straightness"].slope) <= runs[1]
        )
    assert np.all((hits / tests >= least) & (hits / tests <= (0.975 if tests > 100 else 1.0))), (
        hits / tests
    )


def test_terms_are_said_with_what_they_act_on():
    position, approach, reading, run = runs_of(
        np.arange(0, 501, 100.0), np.zeros((2, 6)), np.random.default_rng(1).normal(size=(2, 5, 6))
    )
    (result,), _ = choose.results(
        [targets({"X": position}, reading, approach, {"X": 1.0}, run=run)], Options(budget=BUDGET)
    )
    acts = {t.name: t.of for t in result.terms}
    assert (
        "B" not in acts["device"] and "B" not in acts["temperature"] and {"B", "R"} <= acts["drift"]
    )
    for p in result.parameters:
        parts = [(2 * t.u) ** 2 for t in result.terms if p.name in t.of] + [p.runs**2]
        assert p.U == pytest.approx(math.sqrt(sum(parts)))
