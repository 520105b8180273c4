"""The evidence of a set of effects is the marginal likelihood that a dense normal distribution
gives; rounding is no evidence."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import ModuleType, SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import shapes
from postproc.diagnose.block import Block
from postproc.diagnose.evidence import SLAB, Evidence
from postproc.diagnose.explained import _colored
from postproc.diagnose.factors import TRIED
from postproc.diagnose.noise import Unit
from postproc.diagnose.nuisances import FREE, WANDER, Group
from postproc.diagnose.parts import surprise

N = 80
NOISE = 4e-4


def unit(rows: np.ndarray, ar: tuple[float, ...] = ()) -> Unit:
    n = len(rows)
    return Unit(
        rows,
        "laser",
        True,
        np.array([0, n]),
        np.arange(n) * 1.0,
        np.full(n, NOISE),
        np.array(ar),
        1 - 0.25 * len(ar),
    )


def block(*columns: np.ndarray) -> Block:
    return Block(ModuleType("some.effect"), "X", (), partial(np.stack, columns, axis=1))


def two_instruments(rng: np.random.Generator) -> tuple[Evidence, np.ndarray]:
    """Their model, and the (2N, 2N) covariance of their readings without any effect."""
    first, second = np.arange(N), np.arange(N, 2 * N)
    units = [unit(first), unit(second, (0.5,))]
    own = [
        [Group("zero", np.ones((N, 1)), 0.1), Group("set-up", rng.normal(size=(N, 2)), 1e-3)],
        [Group("zero", np.ones((N, 1)), 0.1)],
    ]
    shared = [Group("map", rng.normal(size=(2 * N, 3)), 3e-4)]
    y = rng.normal(0, 1e-3, 2 * N)
    evidence = Evidence(y, units, own, shared, np.ones(2 * N, bool))
    covariance = (shared[0].columns * 3e-4**2) @ shared[0].columns.T
    for u, groups in zip(units, own, strict=True):
        back = np.linalg.inv(u.whitened(np.eye(N)))
        at = np.ix_(u.rows, u.rows)
        covariance[at] += back @ back.T
        for g in groups:
            covariance[at] += (g.columns * g.sd**2) @ g.columns.T
    return evidence, covariance


def twice_log_density(y: np.ndarray, covariance: np.ndarray) -> float:
    return -float(np.linalg.slogdet(covariance)[1] + y @ np.linalg.solve(covariance, y))


def test_it_is_the_marginal_likelihood_of_a_normal_distribution():
    """Two instruments, one with an autoregression, a map that both share, and two effects of which
    the second shows in one of them."""
    rng = np.random.default_rng(3)
    evidence, without = two_instruments(rng)
    both, alone = rng.normal(size=2 * N), np.r_[np.zeros(N), rng.normal(size=N)]
    numbers = evidence.add([block(both), block(alone, alone**2)])
    null = evidence.learn((), None, steps=0)
    base = twice_log_density(evidence.y, without)
    for chosen in ((0,), (1,), (0, 1)):
        covariance = without.copy()
        for k in chosen:
            columns = evidence.blocks[numbers[k]].columns
            columns = columns * SLAB / np.abs(columns).max(axis=0)
            covariance += columns @ columns.T
        wanted = twice_log_density(evidence.y, covariance) - base
        found = evidence.learn(tuple(numbers[k] for k in chosen), null, steps=0).value - null.value
        assert found == pytest.approx(wanted, rel=1e-6, abs=1e-6)


def test_a_look_at_the_whole_dictionary_says_the_same_as_one_after_the_other():
    rng = np.random.default_rng(4)
    evidence, without = two_instruments(rng)
    evidence.add([block(rng.normal(size=2 * N)), block(*rng.normal(size=(2, 2 * N)))])
    null = evidence.learn((), None, steps=0)
    scores, _, _ = evidence.scan(null)
    base = twice_log_density(evidence.y, without)
    for k, b in enumerate(evidence.blocks):
        usual = b.columns * SLAB / np.abs(b.columns).max(axis=0)
        wanted = (
            max(
                twice_log_density(evidence.y, without + s**2 * usual @ usual.T) - surprise(s, 1.0)
                for s in TRIED
            )
            - base
        )
        assert scores[k] == pytest.approx(wanted, rel=1e-6, abs=1e-6)


def test_blocks_that_are_let_in_after_a_look_are_looked_at_as_those_from_the_beginning():
    """Forty of one to three columns, a third of which show in one instrument alone; what is known
    of the first is kept."""
    rng = np.random.default_rng(5)
    wide = [rng.normal(size=(2 * N, 1 + k % 3)) for k in range(40)]
    for columns in wide[::3]:
        columns[:N] = 0.0
    blocks = [block(*columns.T) for columns in wide]
    at_once, later = (two_instruments(np.random.default_rng(3))[0] for _ in range(2))
    at_once.add(blocks)
    later.add(blocks[:7])
    for begin, end in ((7, 8), (8, 40), (40, 40)):
        fit = later.learn((1,), None, steps=0)
        later.scan(fit)
        later.add(blocks[begin:end])
        found, wanted = later.scan(fit), at_once.scan(at_once.learn((1,), None, steps=0))
        for one, other in zip(found, wanted, strict=True):
            assert one == pytest.approx(other[: len(one)], rel=1e-9, abs=1e-12)
    given = later.scan(fit, np.stack([later.y, 0 * later.y], axis=1))[0]
    assert given[:, 0] == pytest.approx(found[0]) and np.all(given[:, 1] <= 0)


def test_sizes_are_the_same_whether_a_unit_is_kept_or_summed_with_the_others():
    """A block that shows in the second instrument: the first is as it was. The coefficients are
    those of a normal distribution at the sizes that were learned."""
    rng = np.random.default_rng(6)
    evidence, without = two_instruments(rng)
    both, alone = rng.normal(size=2 * N), np.r_[np.zeros(N), rng.normal(size=N)]
    evidence.add([block(both), block(alone)])
    before = evidence.learn((0,), None, steps=0)
    after = evidence.learn((0, 1), before, steps=3)
    assert after.parts[0] is before.parts[0] and after.parts[1] is not before.parts[1]
    for k, own in ((0, np.arange(N)), (1, np.arange(N, 2 * N))):
        back = np.linalg.inv(evidence.parts[k].unit.whitened(np.eye(N)))
        without[np.ix_(own, own)] += (after.parts[k].sigma2 - 1.0) * back @ back.T
    without -= (evidence.shared * 3e-4**2) @ evidence.shared.T
    columns = np.column_stack([evidence.shared, both, alone])
    usual = SLAB / np.abs(columns[:, 3:]).max(axis=0) * [after.scale[0], after.scale[1]]
    sd = np.r_[np.full(3, after.shared[0]), usual]
    told = np.linalg.solve(without, np.column_stack([columns, evidence.y]))
    covariance = np.linalg.inv(columns.T @ told[:, :-1] + np.diag(1 / sd**2))
    assert after.covariance == pytest.approx(covariance, rel=1e-6, abs=1e-15)
    assert after.mean == pytest.approx(covariance @ columns.T @ told[:, -1], rel=1e-6)


def test_a_shape_that_is_tried_is_worth_what_it_is_worth_in_the_dictionary():
    rng = np.random.default_rng(8)
    evidence, _ = two_instruments(rng)
    tried = [block(*rng.normal(size=(w, 2 * N))) for w in (1, 3, 2)]
    evidence.add(tried)
    fit = evidence.learn((0,), None, steps=2)
    sets = SimpleNamespace(evidence=evidence)
    found = shapes.worths(cast(Any, sets), fit, tried)
    assert found == pytest.approx(list(evidence.scan(fit)[0]), rel=1e-6, abs=1e-6)


def test_columns_that_nuisances_make_alike_have_no_evidence_of_rounding():
    """Two columns that differ by a nuisance of unknown size: together they are worth no more than
    one of them."""
    rng = np.random.default_rng(2)
    slope, bend = np.linspace(-1, 1, N), rng.normal(size=N)
    nuisance = Group("zero", np.stack([np.ones(N), slope], axis=1), FREE)
    y = 0.03 - 0.02 * slope + rng.normal(0, NOISE, N)
    evidence = Evidence(y, [unit(np.arange(N))], [[nuisance]], [], np.ones(N, bool))
    evidence.add([block(bend), block(bend, bend + 50 * slope), block(bend, bend * (1 + 1e-13))])
    scores, *_ = evidence.scan(evidence.learn((), None, steps=0))
    assert scores[1] < scores[0] + 0.1 and scores[2] < scores[0] + 3.0 and scores[0] < 10


@pytest.mark.parametrize("size", [5e-5, 1e-3])
def test_what_an_instrument_wanders_is_learned(size):
    rng = np.random.default_rng(7)
    columns = np.repeat(np.eye(20), N // 20, axis=0)
    y = columns @ rng.normal(0, size, 20) + rng.normal(0, NOISE, N)
    evidence = Evidence(
        y, [unit(np.arange(N))], [[Group("wander", columns, WANDER, 3e-3)]], [], np.ones(N, bool)
    )
    fit = evidence.learn((), None, steps=30)
    learned = float(fit.parts[0].sd[0])
    assert learned < 2.5e-4 if size < NOISE / 4 else learned == pytest.approx(size, rel=0.4)
    assert np.sqrt(fit.parts[0].sigma2) * NOISE == pytest.approx(NOISE, rel=0.25)


def test_few_readings_scatter_as_others_do():
    """Of five readings 5 um apart beside others that scatter by 0.2 um: 5 (0.2/5)^(6/11) = 0.86 um;
    of sixty, what they scatter by."""
    few = Unit(
        np.arange(5), "laser", False, np.array([0, 5]), np.arange(5.0), np.full(5, 5e-3), usual=2e-4
    )
    assert few.shrunk(5e-3) == pytest.approx(0.864e-3, rel=1e-2)
    assert unit(np.arange(60)).shrunk(5e-3) == 5e-3


@pytest.mark.parametrize("noise", [NOISE, 0.2])
def test_the_sizes_that_are_learned_are_the_most_probable_ones(noise):
    """At the fixed point the evidence falls to both sides of every size, where readings tell much
    and where they tell little; one term of the block wanders too."""
    rng = np.random.default_rng(9)
    columns = np.repeat(np.eye(20), N // 20, axis=0)
    terms = np.column_stack([rng.normal(size=(N, 3)), columns @ rng.normal(size=20)])
    y = terms @ rng.normal(0, 3e-2, 4) + columns @ rng.normal(0, 1e-3, 20)
    y += rng.normal(0, 1.5 * noise, N)
    own = [Group("zero", np.ones((N, 1)), FREE), Group("wander", columns, WANDER, 3e-3)]
    readings = replace(unit(np.arange(N)), r=np.full(N, noise))
    evidence = Evidence(y, [readings], [own], [], np.ones(N, bool))
    evidence.add([block(*terms.T)])
    best = evidence.learn((0,), None, steps=200)
    part, old = evidence.parts[0], best.parts[0]
    for by in (0.95, 1.05):
        others = [
            replace(best, scale={0: best.scale[0] * by}),
            replace(best, parts=[part.reduced(old.asked, old.sigma2 * by, old.sd)]),
            replace(best, parts=[part.reduced(old.asked, old.sigma2, old.sd * [1.0, by])]),
        ]
        for other in others:
            assert evidence.learn((0,), other, steps=0).value < best.value


def test_samples_are_whitened_passage_by_passage():
    """Of the first two of each nothing is predicted; readings that are drawn are the reverse."""
    rng = np.random.default_rng(11)
    ar, innovation = np.array([0.5, 0.2]), 0.6
    edges = np.array([0, 5, 12])
    some = Unit(
        np.arange(12), "laser", True, edges, np.arange(12.0), np.full(12, 2.0), ar, innovation
    )
    x = rng.normal(size=(12, 3))
    white = some.whitened(x)
    for k in range(12):
        predicted = ar[0] * x[k - 1] + ar[1] * x[k - 2]
        wanted = x[k] if k in (0, 1, 5, 6) else (x[k] - predicted) / np.sqrt(innovation)
        assert white[k] == pytest.approx(wanted / 2.0)
        assert some.whitened(x[:, 0])[k] == pytest.approx(white[k, 0])
    one = replace(some, edges=np.array([0, 12]), r=np.ones(12))
    drawn = _colored(one, x.copy())
    assert drawn[1] == pytest.approx(np.sqrt(innovation) * (x[1] + ar[0] * x[0]))
    assert one.whitened(drawn)[2:] == pytest.approx(x[2:])
