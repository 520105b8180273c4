"""Columns are kept in the instruments that show them, and only as long as they are asked for: the
products are those of whole columns."""

from __future__ import annotations

from functools import partial
from types import ModuleType, SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import shapes
from postproc.diagnose.block import KEPT, Block
from postproc.diagnose.dictionary import RECENT as ASIDE
from postproc.diagnose.evidence import SLAB, Evidence
from postproc.diagnose.nuisances import Group
from postproc.diagnose.parts import RECENT
from postproc.diagnose.sets import AT_ONCE, Sets
from tests.diagnose.test_evidence import (
    NOISE,
    N,
    block,
    twice_log_density,
    two_instruments,
    unit,
)

FIRST, SECOND = slice(0, N), slice(N, 2 * N)


def drawn(rng: np.random.Generator) -> list[np.ndarray]:
    """Columns (2N, K) of a dozen blocks; each column shows in one instrument, or in both."""
    wide = [rng.normal(size=(2 * N, int(rng.integers(1, 5)))) for _ in range(12)]
    for columns in wide:
        for column, where in zip(columns.T, rng.integers(0, 3, columns.shape[1]), strict=True):
            if where < 2:
                column[(FIRST, SECOND)[where]] = 0.0
    return wide


@pytest.mark.parametrize("seed", range(10))
def test_products_are_those_of_whole_columns(seed):
    rng = np.random.default_rng(seed)
    evidence, _ = two_instruments(rng)
    wide = drawn(rng)
    numbers = [
        *evidence.add([block(*columns.T) for columns in wide[:7]]),
        *evidence.add([block(*columns.T) for columns in wide[7:]]),
    ]
    whole = np.concatenate(wide, axis=1)
    of = np.repeat(numbers, [columns.shape[1] for columns in wide])
    first, second = evidence.pairs
    assert np.array_equal(of[first], of[second])
    for part in evidence.parts:
        d, words = part.unit.whitened(whole[part.unit.rows]), part.dictionary
        kept = words.columns
        assert np.array_equal(kept, np.flatnonzero(d.any(axis=0)))
        assert words.bd == pytest.approx(part.b.T @ d[:, kept])
        assert words.zd == pytest.approx(part.z.T @ d[:, kept])
        assert words.dy == pytest.approx(d[:, kept].T @ part.y)
        assert words.along(part.b) == pytest.approx(d[:, kept].T @ part.b)
        for k in words.where:
            own = d[:, kept][:, of[kept] == k]
            assert words.crossed(k) == pytest.approx(own.T @ d[:, kept])
            assert words.within((k,)) == pytest.approx(own.T @ own)
        products = np.zeros(len(first))
        products[words.pairs.number] = words.pairs.product
        assert products == pytest.approx(np.einsum("np,np->p", d[:, first], d[:, second]))


@pytest.mark.parametrize("seed", range(10))
def test_a_set_is_worth_the_same_by_whole_columns(seed):
    """A look at the dictionary, blocks of it asked for by number, and columns that are in none;
    the set has a block of which one column shows in the first instrument and one in the second."""
    rng = np.random.default_rng(100 + seed)
    evidence, covariance = two_instruments(rng)
    parted = np.zeros((2, 2 * N))
    parted[0, FIRST], parted[1, SECOND] = rng.normal(size=(2, N))
    wide = [parted.T, *drawn(rng)]
    evidence.add([block(*columns.T) for columns in wide])
    null = evidence.learn((), None, steps=0)
    fit = evidence.learn((0, 3), null, steps=0)
    both = np.concatenate([wide[0], wide[3]], axis=1)
    scale = np.repeat([fit.scale[0], fit.scale[3]], [2, wide[3].shape[1]])
    usual = both * SLAB / np.abs(both).max(axis=0) * scale
    ratio = np.array([fit.scale[0], fit.scale[3]])
    surprise = float(np.sum(1 / ratio**2 - np.log(1 / ratio**2) - 1))
    wanted = twice_log_density(evidence.y, covariance + usual @ usual.T) - surprise
    wanted -= twice_log_density(evidence.y, covariance)
    assert fit.value - null.value == pytest.approx(wanted, rel=1e-6, abs=1e-6)
    for numbers in ((1,), (2, 5, 7)):
        asked = np.concatenate([wide[k] for k in numbers], axis=1)
        for one, other in zip(
            evidence.among(fit, numbers), evidence.beside(fit, asked), strict=True
        ):
            assert one == pytest.approx(other, rel=1e-9, abs=1e-6)


def test_a_block_makes_its_columns_again_when_it_is_asked():
    calls = []
    wide = np.random.default_rng(1).normal(size=(2 * N, 2))
    wide[FIRST] = 0.0
    made = Block(ModuleType("some.effect"), "X", (), lambda: calls.append(1) or wide)
    evidence, _ = two_instruments(np.random.default_rng(2))
    evidence.add([made])
    assert "columns" not in vars(made) and len(calls) == 1
    assert made.width == 2 and made.shown == N
    assert made.largest == pytest.approx(np.abs(wide).max(axis=0)) and len(calls) == 1
    assert np.array_equal(made.columns, wide) and len(calls) == 2


def test_of_a_dictionary_few_blocks_have_their_columns_at_once():
    rng = np.random.default_rng(3)
    evidence, _ = two_instruments(rng)
    module = cast(Any, SimpleNamespace(__name__="some.effect"))
    most, made = [], list[Block]()

    def columns(k: int) -> np.ndarray:
        most.append(sum("columns" in vars(b) for b in made))
        return np.roll(np.eye(2 * N)[:, :1], k, axis=0)

    def blocks():
        for k in range(3 * AT_ONCE + 5):
            made.append(Block(module, "X", (("k", float(k)),), partial(columns, k)))
            _ = made[-1].columns
            yield made[-1]

    sets = Sets(cast(Any, None), evidence, blocks())
    assert len(sets.blocks) == 3 * AT_ONCE + 5 and max(most) < AT_ONCE
    assert not any("columns" in vars(b) for b in made)


def test_what_was_forgotten_of_a_set_is_the_same_when_it_is_asked_again():
    """More sets than are kept; others are looked at between two looks at the first."""
    rng = np.random.default_rng(4)
    evidence, _ = two_instruments(rng)
    evidence.add([block(*columns.T) for columns in drawn(rng)])
    fits = [evidence.learn((k,), None, steps=1) for k in range(RECENT + 3)]
    looks = [evidence.scan(fit) for fit in fits]
    assert all(len(part._beside) == RECENT for part in evidence.parts)
    assert not any("root" in vars(part) for part in evidence.learn((0,), None, steps=1).parts)
    for found, wanted in zip(evidence.scan(fits[0]), looks[0], strict=True):
        assert np.array_equal(found, wanted)


def test_an_empty_dictionary_says_nothing():
    evidence, _ = two_instruments(np.random.default_rng(5))
    assert isinstance(evidence, Evidence) and evidence.add([]) == []
    assert evidence.scan(evidence.learn((), None, steps=0))[0].shape == (0,)


def test_terms_of_a_stated_size_are_members_but_are_not_looked_at():
    """More of them than are kept whitened: those that were forgotten are the same again."""
    rng = np.random.default_rng(6)
    evidence, covariance = two_instruments(rng)
    wide = rng.normal(size=(2 * N, 2))
    evidence.add([block(*wide.T)])
    columns = [part.dictionary.columns for part in evidence.parts]
    terms = [rng.normal(size=2 * N) for _ in range(ASIDE + 3)]
    stated = evidence.add([block(term) for term in terms], 1e-4)
    null = evidence.learn((), None, steps=0)
    scores, coefficients, _ = evidence.scan(null)
    assert np.isfinite(scores[0]) and np.all(scores[stated] == -np.inf) and len(coefficients) == 2
    for part, before in zip(evidence.parts, columns, strict=True):
        assert np.array_equal(part.dictionary.columns, before)
        assert stated[0] not in part.dictionary._white
    base = twice_log_density(evidence.y, covariance)
    for chosen in ((stated[0],), (stated[1], stated[-1])):
        known = [terms[k - stated[0]] for k in chosen]
        wanted = covariance + sum(np.outer(term, term) * 1e-8 for term in known)
        fit = evidence.learn(chosen, null, steps=0)
        found = fit.value - null.value
        assert found == pytest.approx(twice_log_density(evidence.y, wanted) - base, rel=1e-6)
        one, other = evidence.among(fit, (0,)), evidence.beside(fit, wide)
        evidence.scan(fit)
        for products in (other, evidence.among(fit, (0,))):
            assert products[0] == pytest.approx(one[0]) and products[1] == pytest.approx(one[1])


def test_of_blocks_that_make_their_columns_again_the_last_ones_keep_them():
    evidence, _ = two_instruments(np.random.default_rng(7))
    evidence.add([block(column) for column in np.eye(2 * N)[:, : KEPT + 5].T])
    assert not any("columns" in vars(b) for b in evidence.blocks)
    for b in evidence.blocks:
        _ = b.columns
    assert ["columns" in vars(b) for b in evidence.blocks] == [False] * 5 + [True] * KEPT


def test_an_instrument_has_the_shared_columns_that_show_in_it():
    rng = np.random.default_rng(8)
    units = [unit(np.arange(N)), unit(np.arange(N, 2 * N))]
    wide = rng.normal(size=(2 * N, 3))
    wide[FIRST, 0] = wide[SECOND, 1] = 0.0
    y = rng.normal(0, 1e-3, 2 * N)
    shared, every = [Group("map", wide, 3e-4)], np.ones(2 * N, bool)
    evidence = Evidence(y, units, [[], []], shared, every)
    assert [part.z.shape[1] for part in evidence.parts] == [2, 2]
    effect = rng.normal(size=2 * N)
    evidence.add([block(effect)], 2e-4)
    white = NOISE**2 * np.eye(2 * N) + (wide * 3e-4**2) @ wide.T
    null = evidence.learn((), None, steps=0)
    found = evidence.learn((0,), null, steps=0).value - null.value
    wanted = twice_log_density(y, white + np.outer(effect, effect) * 4e-8)
    assert found == pytest.approx(wanted - twice_log_density(y, white), rel=1e-6)


def test_where_learning_of_a_size_begins_is_found_once(monkeypatch):
    rng = np.random.default_rng(9)
    evidence, _ = two_instruments(rng)
    evidence.add([block(rng.normal(size=2 * N))])
    null, asked = evidence.learn((), None, steps=0), []
    among = evidence.among
    monkeypatch.setattr(evidence, "among", lambda *of: asked.append(of) or among(*of))
    first, again = (evidence.learn((0,), null, steps=1, afresh=new) for new in (False, True))
    assert len(asked) == 1 and first.value == pytest.approx(again.value, abs=1.0)
    assert "covariance" not in vars(first)


def test_a_shape_that_is_tried_again_is_not_read_again(monkeypatch):
    calls = []

    def read(rows: object, module: object, axis: str, shape: dict[str, float]) -> np.ndarray:
        calls.append(shape["tau_ms"])
        return np.full((N, 1), shape["tau_ms"])

    monkeypatch.setattr(shapes.library, "read", read)
    sets = cast(Any, SimpleNamespace(rows=None, tried={}))
    module = cast(Any, SimpleNamespace(__name__="some.effect"))
    made = Block(module, "X", (("tau_ms", 1.0),), lambda: np.ones((N, 1)))
    for tau in (2.0, 3.0, 2.0, 0.0, 0.0):
        found = shapes.at(sets, made, {"tau_ms": tau})
        assert (found is None) == (tau == 0.0)
        assert found is None or (found.columns == tau).all()
    assert calls == [2.0, 3.0, 0.0]
    for k in range(shapes.KEPT):
        shapes.at(sets, made, {"tau_ms": 10.0 + k})
    assert len(sets.tried) == shapes.KEPT and shapes.at(sets, made, {"tau_ms": 2.0}) is not None
    assert calls[-1] == 2.0
