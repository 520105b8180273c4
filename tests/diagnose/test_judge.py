"""Whether a curve says what targets read that took no part in its fit, by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose.judge import _left_out


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
