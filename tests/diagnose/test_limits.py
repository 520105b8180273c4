"""From which size on an effect would have been seen, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from postproc.diagnose.factors import factors
from postproc.diagnose.findings import limits
from postproc.diagnose.sets import MATERIAL

SLAB = 8e-3  # mm, the usual size of the block's coefficient
LEAST, COST = 9.0, 5.0


def detection_limit(told: float) -> dict[str, float]:
    """Of one block of one column whose readings tell `told` times as much of its coefficient as a
    normal distribution of deviation SLAB does."""
    spread = factors(np.array([1]), np.array([SLAB]), np.zeros((1, 1)), np.array([told / SLAB**2]))[
        2
    ]
    block = SimpleNamespace(key="cyclic:X", largest=np.array([1.0]))
    evidence = SimpleNamespace(
        scan=lambda fit: (None, None, spread), fixed=set(), first=[0], slab=np.array([SLAB])
    )
    sets = SimpleNamespace(evidence=evidence, blocks=[block], cost=np.array([COST]))
    return limits(SimpleNamespace(sets=sets, least=LEAST), SimpleNamespace(fit=None))


@pytest.mark.parametrize("told", [0.5, 1.2, 10.0, 100.0])
def test_the_detection_limit_is_where_the_bayes_factor_reaches_the_threshold(told):
    # A size a is worth a^2 told / slab^2 - ln(1 + told) - cost (MacKay 1992): that is to be the
    # threshold and twice its root.
    wanted = LEAST + 2 * math.sqrt(LEAST)
    by_hand = SLAB * math.sqrt((wanted + COST + math.log1p(told)) / told)
    assert detection_limit(told)["cyclic:X"] == pytest.approx(max(by_hand, MATERIAL), rel=1e-6)


def test_an_effect_of_which_the_readings_tell_nothing_has_no_limit():
    assert detection_limit(0.05) == {}
