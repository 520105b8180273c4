"""What a drive pushes with is judged by halves of its motion, each of which holds some."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from postproc.diagnose import answer, drive


def motion(passage: list[int]) -> drive.Motion:
    values = np.arange(len(passage), dtype=float)
    return drive.Motion(*[values] * 9, passage=np.array(passage, float))


@pytest.mark.parametrize("passage", [[0] * 8, [1] * 8, [0] * 3 + [2] * 5, [4, 4, 7, 7, 7, 9, 9, 9]])
def test_neither_half_is_empty(passage):
    """Of passages in which the axis hardly moved nothing is left: the others are what there is."""
    second = drive._halves(motion(passage))
    assert 0 < second.sum() < len(passage)
    if len(set(passage)) > 1:  # a passage is not cut
        assert all(len(set(second[np.array(passage) == p])) == 1 for p in set(passage))


@pytest.mark.parametrize(("after", "named"), [(5.21, True), (7.4, False)])
def test_a_force_that_is_mostly_another_one_names_nothing(after, named):
    """The spread of a real mill's current, 8.62 A, is told to 5.21 A by its dry friction; of a
    force that is told to 7.4 of 8.62 most is cutting or drift."""
    term = SimpleNamespace(term=SimpleNamespace(name="coulomb_friction"))
    one = SimpleNamespace(axis="Y", fitted=(term,), raw=8.62, after=after)
    found = list(answer.felt(SimpleNamespace(findings=[], drives=[one])))
    assert found == ([(one, term)] if named else [])
