"""Means, scatter and what few runs cost; outliers against the runs and against the neighbours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import Options, outliers
from postproc.calibrate.assign import assign
from postproc.calibrate.run import calibrate
from postproc.calibrate.statistics import cells_of, chi_squared, nodes_of, t_factor
from postproc.machine.chain import parse
from postproc.units import UM
from tests.calibrate import seed
from tests.calibrate.simulation import recording, slide, two_axes

GRINDER = parse("w-b-Z-X-t")


@pytest.mark.parametrize(
    "dof, t",
    [(1, 13.97), (2, 4.53), (4, 2.87), (9, 2.32), (11, 2.25), (45, 2.06), (100, 2.025), (1e9, 2.0)],
)
def test_coverage_factors_are_those_of_the_gum(dof, t):
    """JCGM 100:2008, table G.2, column 95.45 %."""
    assert t_factor(dof) == approx(t, abs=0.006)


@pytest.mark.parametrize(
    "dof, median, limit",
    [(3, 2.366, 7.815), (4, 3.357, 9.488), (9, 8.343, 16.919), (35, 34.336, 49.802)],
)
def test_quantiles_of_chi_squared(dof, median, limit):
    """Tables of chi-squared, 50 and 95 %."""
    assert chi_squared(dof, 0.5) == approx(median, abs=6e-4)
    assert chi_squared(dof) == approx(limit, abs=6e-4)


def test_means_and_scatter_by_hand():
    """At 10 in +: 1, 2, 3, so mean 2 and s 1; at 10 in -: 5 and 9, so 7 and sqrt(8); at 0 only in
    -."""
    position = np.array([10, 10, 10, 10, 10, 0.0])
    approach = np.array([1, 1, 1, -1, -1, -1])
    cells = cells_of(position, approach, np.array([1, 2, 3, 5, 9, 4.0]))
    assert cells.nodes == approx([0, 10])
    assert cells.mean[:, 1] == approx([2, 7])
    assert cells.s[:, 1] == approx([1, np.sqrt(8)])
    assert np.isnan(cells.mean[0, 0]) and cells.mean[1, 0] == 4 and cells.n[1, 0] == 1


def test_targets_that_differ_by_less_than_a_slide_can_are_one():
    nodes, index = nodes_of(np.array([0.0, 100.001, 99.999, 50.0, 0.002]))
    assert nodes == approx([0.001, 50.0, 100.0])
    assert list(index) == [0, 2, 2, 1, 0]


def test_one_scatter_for_all_targets_where_chance_explains_their_differences():
    rng = np.random.default_rng(5)
    position, approach = np.tile(np.arange(20.0), 10), np.tile(np.repeat([1, -1], 20), 5)
    even = cells_of(position, approach, rng.normal(0, 1, 200)).scatter
    assert even.pooled
    assert even.s == approx(np.full((2, 20), even.s[0, 0]))
    assert even.dof[0, 0] == 160
    uneven = cells_of(
        position, approach, rng.normal(0, 1, 200) * np.where(position > 15, 10, 1)
    ).scatter
    assert not uneven.pooled
    assert uneven.dof[0, 0] == 4
    assert uneven.s[:, 16:].mean() > 5 * uneven.s[:, :16].mean()


# -- outliers --------------------------------------------------------------------------------------


def test_the_slip_of_the_measured_grinder_is_found_and_nothing_else():
    """Table 6.2, straightness, reverse, X = 90: -31.5 between -31.1 and -38.2 um."""
    found = calibrate(seed.all_recordings(), Options(GRINDER)).outliers
    assert [(o.component, o.position, o.approach, o.against) for o in found] == [
        ("EZX", 90.0, -1, "neighbours")
    ]
    assert found[0].value == approx(-31.5 * UM)
    assert found[0].off == approx(3.2 * UM, abs=0.2 * UM)
    assert found[0].line == seed.FIRST_LINE + 18 + 8


def test_the_slip_is_left_out_only_where_that_is_asked_for():
    parts = [seed.recording("EZX"), seed.recording("EXX")]
    how = {"keep_lines": True, "keep_zero": True}
    kept = calibrate(parts, Options(GRINDER, **how)).components["EZX"]
    gone = calibrate(parts, Options(GRINDER, drop_outliers=True, **how)).components["EZX"]
    assert kept.value[1, 9] == approx(-31.5 * UM)
    assert gone.value[1, 9] == approx((-31.1 - 38.2) / 2 * UM)  # on the line between its neighbours
    assert gone.filled == ((1, 9),)
    assert np.isnan(gone.reversal[9])
    rest = np.arange(18) != 9
    assert gone.value[:, rest] == approx(kept.value[:, rest])


@pytest.mark.parametrize("runs, size", [(1, 10.0), (3, 5.0), (5, 5.0)])
@pytest.mark.parametrize("trial", range(5))
def test_a_slip_is_found_with_its_line(runs, size, trial):
    """Noise 0.3 um. One reading among several runs, or one alone in its direction, where an axis
    that bends by several um between targets hides smaller ones."""
    rng = np.random.default_rng(100 * runs + trial)
    data = recording(rng, two_axes(rng)["Z"], "EZZ", {"X": 0.0}, runs=runs)
    row = 18 * 2 * (runs - 1) + 3 + 2 * trial
    data.columns["reading_um"][row] += size
    series = assign(data)
    found = outliers.find(series, cells_of(series.position, series.approach, series.reading))
    assert [(o.row, o.line) for o in found] == [(row, int(data.lines[row]))]
    assert found[0].off == approx(size * UM, abs=1.6 * UM)


@pytest.mark.parametrize("runs", [1, 2, 3, 5])
def test_noise_alone_is_no_outlier(runs):
    rng = np.random.default_rng(runs)
    for _ in range(60):
        data = recording(rng, two_axes(rng)["Z"], "EZZ", {"X": 0.0}, runs=runs)
        series = assign(data)
        assert not outliers.find(series, cells_of(series.position, series.approach, series.reading))


def test_below_an_instrument_s_noise_a_slip_of_twice_its_uncertainty_is_found():
    """Five runs that agree better than the stated u: a tenth of it is taken for their scatter."""
    rng = np.random.default_rng(3)
    data = recording(rng, two_axes(rng)["Z"], "EZZ", {"X": 0.0}, runs=5, noise=0.0)
    data.columns["reading_um"][40] += 2.0
    series = replace(assign(data), u=1.0 * UM)
    found = outliers.find(series, cells_of(series.position, series.approach, series.reading))
    assert [o.row for o in found] == [40]


def test_a_bump_that_both_directions_show_is_the_machine():
    rng = np.random.default_rng(2)
    axis = slide(rng, "Z", np.linspace(0, 510, 18), ("EZZ",))
    for side in (axis.forward, axis.reverse):
        side["EZZ"] = side["EZZ"] + np.where(np.arange(18) == 8, 6.0, 0.0)
    series = assign(recording(rng, axis, "EZZ", {"X": 0.0}, runs=1, noise=0.05))
    assert not outliers.find(series, cells_of(series.position, series.approach, series.reading))
