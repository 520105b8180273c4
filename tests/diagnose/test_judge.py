"""Whether a curve says what targets read that took no part in its fit, by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose.explained import of_others
from postproc.diagnose.judge import _left_out
from tests.diagnose.test_workshop import HEAD, diagnosed


@pytest.mark.parametrize("noise", [0.5, 1.0])
def test_each_fifth_of_the_targets_is_left_out_once_and_judged_over_the_noise(noise):
    """Ten targets, one zero: the first and the sixth read 1, the others 0. Without a curve the mean
    of the other eight stands for two: 0 for the two that read 1, 2 of 8 for four times two that
    read 0."""
    y, own = np.zeros(10), np.arange(10)
    y[[0, 5]] = 1.0
    block = SimpleNamespace(columns=np.linspace(-1.0, 1.0, 10)[:, None])
    f = SimpleNamespace(block=block, contribution=np.zeros(10))
    d = SimpleNamespace(
        rows=SimpleNamespace(signal=np.zeros(10, int)), after=y, noise=np.full(10, noise)
    )
    without = _left_out(cast(Any, d), cast(Any, f), own, own)[1]
    assert without == pytest.approx((2 * 1.0**2 + 8 * 0.25**2) / noise**2)


def test_who_took_no_part_scatters_as_others_like_it_do():
    """X of a second file as X of the first (3 um, not 9 um of its Y), what has another name as what
    sees the same, what sees what nobody saw as all; who took part as it was found."""
    signals = ("X_act_mm", "Y_act_mm", "X_act_mm", "Z_act_mm", "probe_mm")
    signal = np.repeat(np.arange(5), 2)
    sees = np.array(["scale", "scale", "scale", "scale", "part"])[signal]
    rows = SimpleNamespace(signals=signals, signal=signal, sees=sees)
    values = np.array([2.0, 4.0, 9.0, 9.0, 0, 0, 0, 0, 0, 0])
    parts = [SimpleNamespace(whole=SimpleNamespace(rows=np.array(r))) for r in ([0, 1], [2, 3])]

    class Rows(SimpleNamespace):
        def __len__(self):
            return len(self.signal)

    found = of_others(
        values, cast(Any, Rows(**vars(rows))), cast(Any, SimpleNamespace(parts=parts))
    )
    assert found.tolist() == [2.0, 4.0, 9.0, 9.0, 3.0, 3.0, 6.5, 6.5, 6.5, 6.5]


def lagging(run: int) -> str:
    """A trace of X to and fro by 20 mm in 4 s, 10 ms behind its command, with 2 um of noise."""
    t = np.arange(160) / 20.0
    place, speed = 120 - 20 * np.cos(np.pi * t / 2), 10 * np.pi * np.sin(np.pi * t / 2)
    off = -0.01 * speed + 0.002 * np.random.default_rng(run).standard_normal(len(t))
    rows = zip(t, place, place + off, strict=True)
    return (
        HEAD.format("trace", "scale")
        + '# sees = "scale"\nrun,t_s,X_cmd_mm,X_act_mm\n'
        + "".join(f"{run},{s:.3f},{c:.4f},{a:.5f}\n" for s, c, a in rows)
    )


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_recording_that_took_no_part_has_noise_and_bears_a_name_out(tmp_path):
    """Run 2 is a file of its own: its noise was taken as none, and its readings were divided by
    it."""
    answer = diagnosed(tmp_path, *(lagging(run) for run in (1, 2)), options=("--holdout", "run=2"))
    assert [(e["effect"], e["axis"], e["status"]) for e in answer["effects"]] == [
        ("servo_lag", "X", "accepted")
    ]
    fit = answer["fit"]
    assert fit["held_out"] == "run 2"
    assert fit["rms_before_um"] > 100 and fit["rms_after_um"] < 5
    assert 1.0 < fit["noise_floor_um"] < 5.0 and fit["coverage95"] > 0.9
