"""Which member of a set is dropped, on scores by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import processes, shapes
from postproc.diagnose import search as search_module
from postproc.diagnose.block import Block
from postproc.diagnose.search import Search
from postproc.diagnose.sets import Found, Sets
from postproc.effects import UM, load

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

    def everywhere(self, state: Found) -> bool:
        return True


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
        # Of what is left when one goes, a set of no plausible size stands for nothing.
        ({(FRICTION,): 305.0, (LAG,): 295.0}, {((FRICTION,), FRICTION)}, (LAG,)),
        ({(FRICTION,): 305.0, (LAG,): 200.0}, {((FRICTION,), FRICTION)}, (FRICTION, LAG)),
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


class Dictionary(Scored):
    """With blocks of these names, axes and shapes."""

    def __init__(self, *blocks: tuple[str, str, dict[str, float], bool]):
        self.blocks = [
            Block(
                load(name),
                axis,
                tuple(sorted(shape.items())),
                lambda: np.zeros((1, 1)),
                apart=apart,
            )
            for name, axis, shape, apart in blocks
        ]


@pytest.mark.parametrize(
    "one, other, allowed",
    [
        (("backlash", "X", {}, False), ("backlash", "X", {}, False), False),
        (("backlash", "X", {}, False), ("backlash", "Y", {}, False), True),
        (("backlash", "X", {}, False), ("backlash_position", "X", {}, False), False),
        (("backlash", "X", {}, False), ("backlash_position", "Y", {}, False), True),
        # A laser is set up anew for every recording, a frame is not.
        (("cosine", "", {"file": 0.0}, False), ("cosine", "", {"file": 1.0}, False), True),
        (("cosine", "", {"file": 0.0}, False), ("cosine", "", {"file": 0.0}, False), False),
        (("cosine", "", {"file": -1.0}, False), ("cosine", "", {"file": 1.0}, False), False),
        (
            ("structure_drift", "X", {"file": 0.0}, False),
            ("structure_drift", "X", {"file": 1.0}, False),
            False,
        ),
        # Where each lag shows by itself, a lag and a mismatch are two lags.
        (("servo_lag", "X", {}, False), ("servo_mismatch", "XZ", {}, True), False),
        (("servo_lag", "Y", {}, False), ("servo_mismatch", "XZ", {}, True), True),
        (("servo_lag", "X", {}, False), ("servo_mismatch", "XZ", {}, False), True),
    ],
)
def test_what_may_stand_beside_a_member(one, other, allowed):
    search = Search(cast(Any, Dictionary(one, other)))
    assert search._allowed((0,), 1) is allowed
    assert search._allowed((), 1)


def test_a_process_that_is_worth_nothing_after_one_step_is_not_learned_to_the_end():
    """Of three kinds two promise something, of which the second more."""
    promised = {"place": 3.0, "turn": 0.0, "drift": 40.0}
    kinds = {kind: np.ones(1, bool) for kind in promised}

    class Promising(Scored):
        evidence = SimpleNamespace(
            parts=[SimpleNamespace(processes=kinds)],
            learn=lambda chosen, fit, on, steps, least: SimpleNamespace(
                value=fit.value + sum(promised[kind] for _, kind in on)
            ),
        )

        def of(self, members, on, like):
            return on

    fit = cast(Any, SimpleNamespace(on=frozenset(), members=(), chosen=(), value=-7.0))
    sets = cast(Any, Promising({}, set()))
    sets.hopeless = set()
    found = processes.more(sets, Found(fit, 0.0, np.zeros(1)), 5)
    assert found == [frozenset({(0, "drift")}), frozenset({(0, "place")})]
    assert sets.hopeless == {((), (0, "turn"))}
    sets.hopeless.add(((), (0, "place")))
    assert processes.more(sets, Found(fit, 0.0, np.zeros(1)), 5) == [frozenset({(0, "drift")})]


def test_a_search_that_begins_again_does_not_look_for_the_same_shapes_again(monkeypatch):
    calls = []
    monkeypatch.setattr(shapes, "polished", lambda sets, fit, k: calls.append(k) or k + 10)
    search, fit = Search(cast(Any, Scored({}, set()))), cast(Any, SimpleNamespace())
    assert [search._polish(fit, k) for k in (1, 2, 1, 2)] == [11, 12, 11, 12]
    assert calls == [1, 2]


def test_the_likeliest_of_some_shapes_is_taken_where_it_is_worth_more(monkeypatch):
    worth = {1.0: 5.0, 2.0: 9.0, 3.0: 7.0, 4.0: 11.0}
    blocks = {t: Block(load("scale"), "X", (("t", t),), lambda: np.zeros((3, 1))) for t in worth}
    blocks[4.0] = replace(blocks[4.0], make=lambda: np.zeros((3, 2)))  # of more terms
    monkeypatch.setattr(shapes, "at", lambda sets, block, shape: blocks.get(shape["t"]))
    told = lambda sets, fit, tried: [worth[dict(b.shape)["t"]] for b in tried]  # noqa: E731
    monkeypatch.setattr(shapes, "worths", told)
    around = [{"t": t} for t in (2.0, 3.0, 4.0, 5.0)]
    none = cast(Any, None)
    assert shapes._likeliest(none, none, blocks[1.0], 5.0, around) == (blocks[2.0], 9.0)
    for most in (9.0, 9.0 - 1e-9):  # what differs by rounding is the same
        assert shapes._likeliest(none, none, blocks[1.0], most, around) == (blocks[1.0], most)


@pytest.mark.parametrize("second, named", [(-8e-3, False), (6e-3, True)])
def test_several_jumps_are_looked_for_among_those_to_one_side(second, named):
    """Of five moments at two of which 60 readings jump, by 8 um and by 6; to and fro is none."""
    moments = (10, 20, 30, 40, 50)
    steps = np.stack([np.arange(60) >= t for t in moments], axis=1) * UM
    y = 8 * steps[:, 1] + second / UM * steps[:, 3]
    precision = 1 / 5e-4**2
    products = precision * steps.T @ steps, precision * steps.T @ y
    sets = SimpleNamespace(
        blocks=[
            Block(load("step_loss"), "X", (("t_s", t),), partial(np.reshape, c, (-1, 1)))
            for t, c in zip(moments, steps.T, strict=True)
        ],
        evidence=SimpleNamespace(among=lambda fit, own: products),
    )
    found = shapes._jumps(cast(Any, sets), cast(Any, None), (0, 1, 2, 3, 4), 59)
    assert (found == [1, 3]) == named


def test_a_name_of_exactly_its_form_is_not_charged_for_an_error_of_it():
    """A process explains 90; a name 80 with terms for an error of its form and 99 without them."""
    worth = {("forms",): 80.0, (LAG,): 99.0, (): 90.0}

    class Sets:
        evidence = SimpleNamespace(learn=lambda chosen, *_: chosen)

        @staticmethod
        def at_own_form(state: Any) -> Any:
            return state

        @staticmethod
        def worth_of(chosen: Any) -> float:
            return worth[chosen]

        @staticmethod
        def fits(fit: Any, k: int) -> bool:
            return True

        @staticmethod
        def everywhere(state: Any) -> bool:
            return True

    def state(members: tuple[int, ...], chosen: tuple, on: frozenset) -> Any:
        fit = SimpleNamespace(chosen=chosen, on=on)
        return SimpleNamespace(
            key=(members, on), members=members, score=0.0, least=np.zeros(1), fit=fit
        )

    named = state((LAG,), ("forms",), frozenset())
    process = state((), (), frozenset({(0, "lever")}))
    assert Search(cast(Any, Sets()))._likeliest([process, named]) is named


@pytest.mark.parametrize("middle, least", [(10.0, 19.2), (-10.0, search_module.LEAST)])
def test_a_member_must_be_worth_more_than_noise_reaches_in_one_of_a_hundred(
    monkeypatch, middle, least
):
    """Of a Gumbel distribution at m with a scale of 2 the hundredth part lies beyond m - 2 ln(-ln
    0.99) = m + 9.2; two blocks of other prices, of which the first is the better one in each null.
    Never less than the odds that are asked for anyway."""
    n, cost = search_module.NULLS, np.array([3.0, 5.0])
    best = middle - 2.0 * np.log(-np.log((np.arange(n) + 0.5) / n))
    worth = np.stack([best + cost[0], best - 1.0 + cost[1]])
    monkeypatch.setattr(search_module, "drawn", lambda evidence, fit, rng, nulls: nulls)
    sets = SimpleNamespace(
        null=lambda: SimpleNamespace(fit=None),
        evidence=SimpleNamespace(scan=lambda fit, draws: (worth[:, :draws], None, None)),
        cost=cost,
    )
    search = Search(cast(Any, sets))
    search.calibrate(np.random.default_rng(1))
    assert search.least == pytest.approx(least, abs=0.5)


def test_a_member_is_worth_what_the_set_loses_without_it():
    sets = Scored({(LAG,): 200.0}, set())
    assert Sets.worth(cast(Any, sets), found((FRICTION, LAG), 301.0), FRICTION) == 101.0


@pytest.mark.parametrize("borne_out", [True, False])
def test_a_jump_has_to_be_borne_out_and_nothing_else(monkeypatch, borne_out):
    monkeypatch.setattr(search_module.abrupt, "borne_out", lambda *_: borne_out)
    blocks = [SimpleNamespace(name=name) for name in (search_module.abrupt.NAME, "backlash")]
    search = Search(cast(Any, SimpleNamespace(blocks=blocks, fits=lambda fit, k: True)))
    assert [search._fits(found((k,), 1.0), k) for k in (0, 1)] == [borne_out, True]


@pytest.mark.parametrize(
    "formed, other, exact",
    [(80.0, 60.0, True), (95.0, 60.0, False), (80.0, 95.0, False)],
)
def test_a_set_says_it_all_where_neither_terms_of_form_nor_another_set_come_near(
    formed, other, exact
):
    """100 at its own form; within 8 of it nothing may come: not the same with terms for an error
    of form, not the terms of another set."""
    worth = {(0,): 100.0, (0, 8): formed, (1,): 50.0, (1, 9): other}
    states = []
    for members, chosen in (((0,), (0, 8)), ((1,), (1, 9))):
        fit = cast(Any, SimpleNamespace(on=frozenset(), chosen=chosen))
        states.append(Found(fit, 0.0, np.zeros(1), members))
    sets = SimpleNamespace(
        at_own_form=lambda state: state,
        evidence=SimpleNamespace(learn=lambda chosen, *_: chosen),
        worth_of=worth.__getitem__,
        fits=lambda fit, k: True,
        everywhere=lambda state: True,
    )
    assert Search(cast(Any, sets))._exact(states) is (states[0] if exact else None)


@pytest.mark.parametrize(
    "same, on, told",
    [
        ({(1,), (2,)}, (), (1,)),  # the commonest of those that say the same
        ({(2,)}, (), (2,)),
        (set(), (), (0,)),  # the commoner ones say something else
        ({(1,), (2,)}, ((0, "place"),), (0,)),  # beside a process it is another answer
    ],
)
def test_of_sets_that_say_the_same_the_commonest_is_reported(monkeypatch, same, on, told):
    """A sag (4 beyond the odds of any name), a bow (2), a squareness (-2); special cases apart."""
    shapes_of = [("sag", "X"), ("squareness", "XY"), ("bow", "X")]

    class Same(Dictionary):
        def says_the_same(self, best: Found, other: Found) -> bool:
            return other.members in same

    plain = {"beam": -1.0, "lever": 1.0, "usual_N": 0.0, "rails": -1.0, "turns": 0.0}
    sets = Same(*((name, axis, plain, False) for name, axis in shapes_of))
    sets.scores, sets.unfit = {(): 0.0}, set()
    search = Search(cast(Any, sets))
    monkeypatch.setattr(search, "children", lambda rest, names, like: [])
    monkeypatch.setattr(search, "_special", lambda state: [])
    best = found((0,), 90.0)
    others = [found((k,), 80.0) for k in (1, 2)]
    for other in others:
        other.fit.on = frozenset(on)
    assert search._commonest(best, [best, *others]).members == told


@pytest.mark.parametrize("process", [True, False])
def test_members_are_settled_beside_a_process_that_comes_behind_them(monkeypatch, process):
    """Friction and a lag are found first; beside a process of places friction is worth nothing,
    and the lag with that process is looked at though no step of the growth led there."""
    on = frozenset({(0, "place")})

    def state(members: tuple[int, ...], score: float, on: frozenset = frozenset()) -> Found:
        one = found(members, score)
        one.fit.on = on
        return one

    null, named = state((), 0.0), state((FRICTION, LAG), 90.0)
    beside, settled = state((FRICTION, LAG), 95.0, on), state((LAG,), 99.0, on)
    sets = Scored({}, set())
    sets.null, sets.evidence, sets.seen = lambda: null, None, {}
    search = Search(cast(Any, sets))

    def grown(start: Found, way: Any, ahead: int = 0) -> list[Found]:
        if way == search.children:
            return [start, named] if start is null else [start]
        return [start, beside] if process and start is named else [start]

    monkeypatch.setattr(search_module, "wandered", lambda *_: False)
    monkeypatch.setattr(search, "_grown", grown)
    monkeypatch.setattr(search, "_settled", lambda one: settled if one is beside else one)
    monkeypatch.setattr(search, "_special", lambda one: [])
    monkeypatch.setattr(search, "_likeliest", lambda states: max(states, key=lambda s: s.score))
    monkeypatch.setattr(search, "_commonest", lambda best, states: best)
    monkeypatch.setattr(search, "_dropped", lambda best: best)
    assert search._chosen() is (settled if process else named)


def test_sets_that_were_seen_on_the_way_are_looked_at_again_but_for_empty_and_barred_ones(
    monkeypatch,
):
    """Beside the ends of the growth: of what was fitted on the way the best, with members or a
    process, none of whose members is barred."""
    sets: Any = Dictionary(("backlash", "X", {}, False), ("servo_lag", "X", {}, False))
    nothing, at_another_form = found((), 0.0), found((), 70.0)
    process = found((), 20.0)
    process.fit.on = frozenset({(0, "place")})
    friction, barred = found((FRICTION,), 50.0), found((LAG,), 60.0)
    every = [at_another_form, process, friction, barred, nothing]
    sets.seen, sets.null, sets.evidence = dict(enumerate(every)), lambda: nothing, None
    search, looked = Search(sets), []
    search._barred = {sets.blocks[LAG].key}
    monkeypatch.setattr(search_module, "wandered", lambda evidence, fit: False)
    monkeypatch.setattr(search, "_grown", lambda start, children, ahead=0: [start])
    monkeypatch.setattr(search, "_settled", lambda state: state)
    monkeypatch.setattr(search, "_special", lambda state: [])
    monkeypatch.setattr(search, "_likeliest", lambda states: looked.extend(states) or states[0])
    for step in ("_commonest", "_dropped"):
        monkeypatch.setattr(search, step, lambda state, *_: state)
    search._chosen()
    assert [state for state in looked if state is not nothing] == [friction, process]
