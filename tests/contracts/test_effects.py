"""Laws for every effect of the library."""

from __future__ import annotations

import numpy as np
import pytest

from postproc import effects

NAMES = effects.names()
N = 7
POSE = effects.Pose(
    position={x: np.linspace(0.0, 100.0, N) for x in "XYZ"},
    approach={x: np.array([-1, 1, 0, 1, -1, 0.5, -0.5]) for x in "XYZ"},
)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("axis", "XYZ")
def test_gives_one_vector_a_pose(name, axis):
    module = effects.load(name)
    value = module.deviation(POSE, axis, **dict.fromkeys(module.PARAMETERS, 3.0))
    assert value.shape == (3, N)
    assert np.isfinite(value).all()


@pytest.mark.parametrize("name", NAMES)
def test_says_what_it_is(name):
    module = effects.load(name)
    assert module.USE in ("compensate", "simulate", "recording")
    assert module.__doc__
    for parameter, meaning in module.PARAMETERS.items():
        assert "," in meaning, f"{parameter}: unit, then meaning"


@pytest.mark.parametrize("name", NAMES)
def test_the_batch_does_not_matter(name):
    module = effects.load(name)
    parameters = dict.fromkeys(module.PARAMETERS, 3.0)
    whole = module.deviation(POSE, "X", **parameters)
    for i in range(N):
        one = effects.Pose(
            {x: v[i : i + 1] for x, v in POSE.position.items()}, {x: v[i : i + 1] for x, v in POSE.approach.items()}
        )
        assert (module.deviation(one, "X", **parameters)[:, 0] == whole[:, i]).all()


def test_zero_backlash_is_none():
    assert not effects.load("backlash").deviation(POSE, "X", size_um=0.0).any()
