"""Whether any or all of a column of bools holds, of any shape and of none."""

import numpy as np
import pytest

from postproc.flags import all_of, any_of


@pytest.mark.parametrize("shape", [(0,), (1,), (7,), (3, 0), (3, 1), (2, 50)])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_any_and_all_are_those_of_numpy(shape, share):
    flags = np.random.default_rng(5).random(shape) < share
    for view in (flags, flags.T, flags[..., ::2], ~flags):
        assert any_of(view) is bool(view.any())
        assert all_of(view) is bool(view.all())
