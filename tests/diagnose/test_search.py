"""Which member of a set is dropped, on scores by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose.search import Search
from postproc.diagnose.sets import Found

FRICTION, LAG = 0, 1


def found(members: tuple[int, ...], score: float) -> Found:
    fit = cast(Any, SimpleNamespace(on=frozenset(), members=members))
    return Found(fit, score, np.zeros(1), members)


class Scored:
    """Sets with these scores; a member fits unless (members, member) is in `unfit`."""

    def __init__(self, scores: dict[tuple[int, ...], float], unfit: set[tuple]):
        self.scores, self.unfit = scores, unfit

    def at_own_form(self, state: Found) -> Found:
        return state

    def without(self, state: Found, k: int) -> Found:
        rest = tuple(c for c in state.members if c != k)
        return found(rest, self.scores[rest])

    def fits(self, fit: Any, k: int) -> bool:
        return (fit.members, k) not in self.unfit


@pytest.mark.parametrize(
    "scores, unfit, left",
    [
        # Beside a lag of another sign friction is too large; alone it is not, and says far more.
        ({(FRICTION,): 300.0, (LAG,): 200.0}, {((FRICTION, LAG), FRICTION)}, (FRICTION,)),
        # What fits stays, though what is of no plausible size alone says more.
        (
            {(FRICTION,): 200.0, (LAG,): 300.0},
            {((FRICTION, LAG), LAG), ((LAG,), LAG)},
            (FRICTION,),
        ),
        # All are of plausible size: the one that is worth less than 8 goes.
        ({(FRICTION,): 296.0, (LAG,): 200.0}, set(), (FRICTION,)),
        ({(FRICTION,): 290.0, (LAG,): 200.0}, set(), (FRICTION, LAG)),
        # None is of plausible size.
        (
            {(FRICTION,): 290.0, (LAG,): 200.0},
            {((FRICTION, LAG), LAG), ((LAG,), LAG), ((FRICTION,), FRICTION)},
            (),
        ),
    ],
)
def test_of_members_that_do_not_fit_the_one_is_dropped_that_leaves_most(scores, unfit, left):
    sets = Scored(scores | {(): 0.0, (FRICTION, LAG): 301.0}, unfit)
    search = Search(cast(Any, sets))
    assert search._dropped(found((FRICTION, LAG), 301.0)).members == left
