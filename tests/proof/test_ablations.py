"""Every part that can be taken out is there to be taken out, and taken back."""

from __future__ import annotations

import pytest

from postproc.diagnose import (
    abrupt,
    isolated,
    map_agreement,
    noise,
    nuisances,
    search,
    sets,
    shapes,
    shared_jump,
    telegraph,
    thermometers,
)
from proof import ablations

PLACES = (
    abrupt,
    isolated,
    map_agreement,
    noise,
    nuisances,
    search,
    search.Search,
    sets,
    sets.Sets,
    shapes,
    shared_jump,
    telegraph,
    thermometers,
)


@pytest.mark.parametrize("part", ablations.PARTS)
def test_a_part_is_taken_out_and_put_back(part):
    before = [dict(vars(place)) for place in PLACES]
    with ablations.without(part):
        inside = [dict(vars(place)) for place in PLACES]
    assert (inside == before) == (part == "the whole")
    assert [dict(vars(place)) for place in PLACES] == before


def test_a_case_is_judged_without_a_part():
    found = ablations.one("without a search: the single best name", "dev14", "open", ("single", 10))
    assert found is not None and found.truths == ["delay:"] and len(found.names) <= 1
