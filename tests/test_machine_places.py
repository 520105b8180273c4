"""At how many places a machine's map is looked at for its largest deviation."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc.commands import machine_facts


@pytest.mark.parametrize("letters", ["X", "XZ", "XYZ", "XYZAC"])
@pytest.mark.parametrize("nodes", [7, 5000])
def test_the_map_is_looked_at_in_a_bounded_number_of_places(letters, nodes):
    tables = dict.fromkeys(letters, SimpleNamespace(nodes=np.linspace(0.0, 300.0, nodes)))
    grid = machine_facts._grid(SimpleNamespace(letters=letters, tables=tables))
    assert grid.shape == (len(letters), min(nodes ** len(letters), grid.shape[1]))
    assert min(nodes ** len(letters), 7**5) <= grid.shape[1] <= machine_facts.PLACES
    assert grid.min() == 0.0 and grid.max() == 300.0
