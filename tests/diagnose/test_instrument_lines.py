"""What an instrument picks up while it is read in motion: the mains' frequency, and single samples
that slip. Neither is physics of the machine."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.cli import main
from postproc.diagnose import isolated
from tests.diagnose.test_workshop import HEAD, diagnosed


def circle(seen_um, rate: float, seed: int = 1, noise_um: float = 0.15) -> str:
    """A ball bar's circle of 150 mm about (300, 200), 1.5 times each way. seen_um(t) um is added to
    what the bar reads."""
    rng = np.random.default_rng(seed)
    rows = []
    for run, sense in ((1, 1), (2, -1)):
        t = 40.0 * run + np.arange(int(24 * rate)) / rate
        angle = sense * 2 * np.pi * (t - t[0]) / 16.0
        read = seen_um(t) + noise_um * rng.standard_normal(len(t))
        rows += [
            f"{run},{a:.4f},{300 + 150 * np.cos(w):.6f},{200 + 150 * np.sin(w):.6f},{r:.3f},{sense}"
            for a, w, r in zip(t, angle, read, strict=True)
        ]
    head = (
        HEAD.format("ballbar", "ball bar")
        + "# radius_mm = 150.0\n# centre = { X = 300.0, Y = 200.0 }\n"
    )
    return head + "run,t_s,X_cmd_mm,Y_cmd_mm,radial_um,sense\n" + "\n".join(rows) + "\n"


def named(answer: dict) -> list[str]:
    return [f"{e['effect']}:{e['axis']}" for e in answer["effects"] if e["status"] == "accepted"]


@pytest.mark.parametrize("rate,mains", [(250.0, 49.98), (36.7, 60.02), (25.43, 49.97)])
def test_the_mains_are_the_instruments_also_at_an_alias(tmp_path, rate, mains):
    answer = diagnosed(tmp_path, circle(lambda t: 1.5 * np.cos(2 * np.pi * mains * t + 1), rate))
    assert (named(answer), answer["verdict"]) == ([], "nothing-left-out")


@pytest.mark.parametrize("frequency", [48.9, 51.3])
def test_a_motor_that_slips_behind_the_mains_is_a_vibration(tmp_path, frequency):
    answer = diagnosed(
        tmp_path, circle(lambda t: 1.5 * np.cos(2 * np.pi * frequency * t + 1), 250.0)
    )
    assert {name.split(":")[0] for name in named(answer)} == {"vibration"}


def test_a_person_is_told_of_the_mains(tmp_path, capsys):
    diagnosed(tmp_path, circle(lambda t: 1.5 * np.cos(2 * np.pi * 49.98 * t), 250.0))
    main(["diagnose", str(tmp_path / "r0.csv"), "--machine", str(tmp_path / "machine")])
    assert "holds the mains' frequency, 49.98 Hz" in capsys.readouterr().out


def test_one_sample_that_slips_is_left_out_and_no_lost_step(tmp_path):
    def slipped(t):
        return 16.0 * (np.arange(len(t)) == 700) * (t[0] > 60)

    answer = diagnosed(tmp_path, circle(slipped, 40.0))
    assert (named(answer), answer["verdict"]) == ([], "nothing-left-out")
    (fault,) = answer["data_faults"]
    assert (fault["fault"], fault["size_um"]) == ("outlier", pytest.approx(16.0, abs=1.0))


def test_two_samples_that_differ_are_no_slip(tmp_path):
    def slipped(t):
        return 16.0 * np.isin(np.arange(len(t)), (700, 701)) * (t[0] > 60)

    assert not diagnosed(tmp_path, circle(slipped, 40.0))["data_faults"]


@pytest.mark.filterwarnings("error")
def test_runs_of_a_few_samples_have_no_lone_one():
    assert not isolated.in_motion(np.arange(40.0) ** 2, np.arange(40) // 4).any()
