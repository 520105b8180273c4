"""Known machines, simulated recordings: the truth lies within the stated uncertainty as often as it
says.

200 machines of each kind: benchmarks/calibration.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import Options
from postproc.calibrate.run import calibrate
from postproc.machine.chain import parse
from tests.calibrate.simulation import coverage, everything, three_axes, two_axes

UM, URAD = 1e-3, 1e-6
MACHINES = {
    "grinder": (two_axes, Options(parse("w-b-Z-X-t")), {"X": 80.0, "Z": 200.0}),
    "mill": (three_axes, Options(parse("w-X-Y-b-Z-t")), {"X": 200.0, "Y": 150.0, "Z": -100.0}),
}


@pytest.mark.parametrize("runs, machines", [(5, 40), (3, 25), (2, 25)])
@pytest.mark.parametrize("name", MACHINES)
def test_the_truth_lies_within_two_u_in_95_of_100(name, runs, machines):
    """Two-way, noise 0.3 um and 0.3 urad; 25 machines are 4000 values or more, whose share strays
    by 0.4 %."""
    make, options, rest = MACHINES[name]
    inside, count, spread, _ = coverage(
        make, options.chain, rest, options, calibrate, machines, seed=runs, runs=runs
    )
    assert count >= 4000
    assert 0.93 <= inside / count <= 0.97
    # neither too wide nor too narrow: errors have the size of u
    assert spread == approx(1.0, abs=0.06)


def test_more_runs_make_it_smaller():
    make, options, rest = MACHINES["grinder"]
    few, many = (
        coverage(make, options.chain, rest, options, calibrate, 3, seed=1, runs=r)[3]
        for r in (3, 12)
    )
    assert many == approx(few / 2, rel=0.05)


@pytest.mark.parametrize("name", MACHINES)
def test_the_calibrated_machine_deviates_as_the_true_one(name):
    """Anywhere in the space, both directions, but for what a set-up can not see: a shift and a turn
    of the whole.

    30 runs of 0.1 um, straightness lines and zeros of the truth kept out by fitting a rigid motion
    and shear to the difference.
    """
    make, options, rest = MACHINES[name]
    rng = np.random.default_rng(12)
    machine = make(rng)
    model = calibrate(everything(rng, machine, rest, runs=30, noise=0.1), options).machine
    letters = model.letters
    low = np.array([machine[x].targets[0] for x in letters])
    high = np.array([machine[x].targets[-1] for x in letters])
    places = rng.uniform(low, high, (300, len(letters))).T
    ways = rng.choice([-1.0, 1.0], places.shape)
    true = np.zeros((3, 300))
    for i in range(300):
        at = dict(zip(letters, places[:, i], strict=True))
        for row, x in enumerate(letters):
            true[:, i] += machine[x].lateral(int(ways[row, i]), places[row : row + 1, i], at)[:, 0]
    rows = [("XYZ").index(x) for x in letters]
    difference = (model.deviation(places, ways) - true[rows]) / UM
    terms = np.column_stack([places.T, np.ones(300)])
    left = difference.T - terms @ np.linalg.lstsq(terms, difference.T, rcond=None)[0]
    size = np.abs(true).max() / UM
    assert size > 8
    assert np.abs(left).max() < 0.02 * size + 0.15
