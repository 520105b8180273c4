"""What comes again in other runs: found without knowing the noise, and never where each run has its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from postproc import recordings
from postproc.cli import main
from postproc.diagnose import again
from postproc.diagnose.rows import Rows, of
from postproc.machine.file import read_machine

STUDER = Path(__file__).resolve().parents[2] / "machines" / "studer-s36"
UM = 1e-3


def rows_of(folder: Path, test: str) -> Rows:
    file = folder / "r.csv"
    wanted = ["simulate", "--test", test, "--machine", str(STUDER), "--noise", "0.3", "--seed", "4", "-o", str(file)]
    assert main([*wanted, "--quiet"]) == 0
    read = recordings.read(recordings.Source(str(file), file.read_bytes()), options=recordings.ReadingOptions())
    return of([read], read_machine(STUDER))


@pytest.fixture(scope="module")
def circles(tmp_path_factory) -> Rows:
    return rows_of(tmp_path_factory.mktemp("circles"), "ballbar:XZ,runs=4")


@pytest.fixture(scope="module")
def targets(tmp_path_factory) -> Rows:
    return rows_of(tmp_path_factory.mktemp("targets"), "positioning:Z,runs=3")


def ripple(rows: Rows, phase: np.ndarray) -> np.ndarray:
    """2 um, a wave each 11 mm of X and Z together."""
    way = rows.state.position["X"] + 0.7 * rows.state.position["Z"]
    return 2 * UM * np.sin(2 * np.pi * way / 11.0 + phase)


def test_what_all_runs_share_has_its_own_size_whatever_the_noise_is(circles):
    rng = np.random.default_rng(8)
    every = np.ones(len(circles), bool)
    for noise in (0.2, 1.0, 3.0):
        y = ripple(circles, np.zeros(len(circles))) + rng.normal(0, noise * UM, len(circles))
        value, likely = again.agreed(circles, y, every, 96)
        assert likely > again.AGREED
        assert value == pytest.approx((2 * UM) ** 2 / 2, rel=0.15)


def test_what_each_run_has_for_itself_is_not_shared(circles):
    """Noise whose neighbours are alike, and a ripple that starts anew in each run."""
    every = np.ones(len(circles), bool)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        rough = rng.normal(0, UM, len(circles) + 4)
        own = rng.uniform(0, 2 * np.pi, 40)[circles.run] + np.pi * circles.run
        y = np.convolve(rough, np.ones(5) / 5, "valid")
        assert again.agreed(circles, y, every, 96)[1] < again.AGREED
        alone = np.unique(circles.run)[:2]
        two = np.isin(circles.run, alone)
        quarter = ripple(circles, np.where(circles.run == alone[0], own[two][0], own[two][0] + np.pi / 2))
        assert again.agreed(circles, quarter + y, two, 96)[1] < again.AGREED


def test_one_pass_shares_nothing_with_itself(circles):
    alone = circles.run == circles.run[0]
    assert again.agreed(circles, ripple(circles, np.zeros(len(circles))), alone, 24) == (0.0, 0.0)


def test_a_zero_that_wanders_is_no_structure_of_a_run_that_took_no_part(targets):
    """Half a micrometre and as much along the run: what is left of it is far below the noise; a dent of 4 um stays."""
    held = targets.run == np.unique(targets.run)[1]
    t = targets.state.time
    wander = np.where(held, 0.5 * UM + 0.5 * UM * (t - t[held].min()) / np.ptp(t[held]), 0.0)
    sigma = np.full(len(targets), 0.3 * UM)
    assert np.abs(again.levelled(targets, wander, sigma, held)[held]).max() < 0.1 * UM
    noise = np.random.default_rng(3).normal(0, 0.3 * UM, len(targets))
    all_told = np.ones(len(targets), bool)
    assert not again.left(targets, (noise + wander,), noise + wander, sigma, held, all_told)
    z = targets.state.position["Z"]
    dent = np.where(held & (z > np.quantile(z, 0.3)) & (z < np.quantile(z, 0.7)), 4 * UM, 0.0)
    there = again.left(targets, (noise + dent,), noise + dent, sigma, held, all_told)
    assert [one.how for one in there] == ["afresh"] and 1 * UM < there[0].rms < 4 * UM
    assert not again.left(targets, (noise + dent,), noise + dent, sigma, held, ~held)
