"""A set of effects: errors of its form, and the recordings in which it should show, by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.diagnose import sets as sets_module
from postproc.diagnose.block import Block
from postproc.diagnose.library import FOUND
from postproc.diagnose.sets import Sets, _amplitude, _later, _terms
from postproc.effects import UM, load
from tests.diagnose.test_search import LAG, found


@pytest.mark.parametrize("wave", [False, True])
def test_terms_by_which_a_form_may_be_wrong(wave):
    """By the place, at most 1.2 times; by the time; a sample later in the same motion, where it is
    no wave; while it builds up after a turn, before which there is none."""
    part = np.array([2.0, 2.0, 4.0, 7.0])
    since = np.array([9.0, 0.0, 0.05, 0.1])
    rows = SimpleNamespace(
        signal=np.zeros(4),
        state=SimpleNamespace(
            position={"X": None},
            share=lambda x: np.array([-2.0, -0.5, 0.5, 2.0]),
            time=np.array([10.0, 11.0, 12.0, 14.0]),
            since={"X": since},
            passage=np.array([-1, 0, 0, 0]),
        ),
    )
    module = load(next(iter(FOUND)) if wave else "backlash")
    block = Block(module, "X", (), lambda: part[:, None] / 2)
    after = [[0.0, *(5 * part * np.exp(-since / tau))[1:]] for tau in (0.01, 0.05, 0.2)]
    later = [] if wave else [[0.0, 0.0, 2.0, 3.0]]
    by_hand = [[-2.4, -1.0, 2.0, 8.4], [-2.0, -1.0, 0.0, 7.0], *later, *after]
    assert _terms(cast(Any, rows), block, np.array([2.0])).T == pytest.approx(np.array(by_hand))


@pytest.mark.parametrize(
    "again, dense, everywhere",
    [
        (0.5, False, True),  # of what is said of the second recording
        (0.3, False, False),
        (-1.0, False, False),
        (0.3, True, True),  # motions may differ by their feeds
    ],
)
def test_a_name_is_in_each_recording_in_which_it_should_show(again, dense, everywhere):
    """8 um in two recordings, of which the terms of its form leave a share in the second."""
    size, form = np.array([8.0, -8.0, 8.0, -8.0]), np.array([0.0, 0.0, 1.0, -1.0])
    blocks = [SimpleNamespace(columns=v[:, None] * UM) for v in (size, form)]
    parts = [
        SimpleNamespace(unit=SimpleNamespace(rows=np.array(own), dense=dense))
        for own in ((0, 1), (2, 3))
    ]
    state = found((0,), 0.0)
    state.fit.chosen = (0, 1)
    sets = SimpleNamespace(
        rows=range(4),
        blocks=blocks,
        evidence=SimpleNamespace(parts=parts),
        at_own_form=lambda state: state,
        value=lambda fit, k: np.array([1.0, 8.0 * (again - 1)])[[k]],
        _of_form={1: 0},
    )
    assert Sets.everywhere(cast(Any, sets), state) is everywhere


@pytest.mark.parametrize(
    "grown, afresh, likelier",
    [
        (0.5, 9.0, False),  # nothing has grown: what was learned before is right, and is not left
        (1.5, 9.0, True),
        (1.5, 3.0, False),
    ],
)
def test_sizes_are_learned_afresh_where_what_was_learned_before_has_grown(grown, afresh, likelier):
    """Beside a set of which something grew beyond what is usual the likelier of two fits is taken:
    from its sizes (worth 5), and from the usual ones."""
    evidence = SimpleNamespace(
        parts=[],
        shared_usual=np.ones(1),
        learn=lambda *_, afresh=False: fits[afresh],
    )
    fits = {False: SimpleNamespace(value=5.0), True: SimpleNamespace(value=afresh)}
    like = found((), 0.0)
    like.fit.parts, like.fit.shared = [], np.array([2 * grown])
    sets = cast(Any, SimpleNamespace(evidence=evidence))
    least = np.zeros(0)
    assert Sets._learned(sets, (LAG,), like, frozenset(), least) is fits[likelier]


def test_a_spike_is_as_large_as_its_second_reading_and_in_long_traces_as_one_in_two_thousand():
    assert _amplitude(np.array([1.0, -5.0, 4.0])) == 4.0
    assert _amplitude(np.array([-3.0])) == 3.0
    assert _amplitude(np.arange(8000.0)) == 7996.0  # of four readings


def test_what_comes_later_is_taken_from_sample_to_sample_of_one_motion():
    """Passages 0 and 1 of one signal, samples of no motion (-1), and another signal."""
    passage = np.array([0, 0, 0, 1, 1, -1, -1, 1, 1])
    signal = np.array([0, 0, 0, 0, 0, 0, 0, 0, 1])
    rows = SimpleNamespace(state=SimpleNamespace(passage=passage), signal=signal)
    part = np.array([1.0, 3.0, 4.0, 9.0, 7.0, 5.0, 6.0, 2.0, 1.0])
    assert _later(rows, part).tolist() == [0.0, 2.0, 1.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("noise", [0.5 * UM, 2 * UM])
def test_the_error_of_form_of_the_largest_member_counts_over_the_noise(monkeypatch, noise):
    """A tenth of 8 um, and of 3 um beside it, in one unit: (0.8 um / noise)^2 is its variance."""
    monkeypatch.setattr(sets_module, "QUIETEST", 0.0)
    columns = [size * UM * np.array([[1.0], [-1.0], [1.0], [-1.0]]) for size in (3.0, 8.0)]
    sets = SimpleNamespace(
        blocks=[SimpleNamespace(columns=c, module=SimpleNamespace(FORM=0.1)) for c in columns],
        evidence=SimpleNamespace(
            parts=[SimpleNamespace(unit=SimpleNamespace(rows=np.arange(4), r=np.full(4, noise)))]
        ),
        members=lambda fit: (0, 1),
        value=lambda fit, k: np.ones(1),
        _open=[np.zeros((4, 0))],
    )
    variance = Sets.form(cast(Any, sets), cast(Any, None))
    assert variance == pytest.approx([(0.8 * UM / noise) ** 2])


@pytest.mark.parametrize(
    ("sees", "size", "fits"),
    [
        ("length", 1.1e-3, True), ("length", 0.9e-3, False),
        ("angle", 1.1e-6, True), ("angle", 0.9e-6, False),
    ],
)  # fmt: skip
def test_a_member_matters_from_one_um_on_or_one_urad(monkeypatch, sees, size, fits):
    """Where noise is none, and no other member stands beside it."""
    monkeypatch.setattr(sets_module, "plausible", lambda block, value: True)
    unit = SimpleNamespace(rows=np.arange(2), r=np.full(2, 1e-12), sees=sees)
    sets = SimpleNamespace(
        blocks=[SimpleNamespace(columns=np.array([[size], [-size]]))],
        evidence=SimpleNamespace(parts=[SimpleNamespace(unit=unit)]),
        members=lambda fit: (0,),
        value=lambda fit, k: np.ones(1),
        _open=[np.zeros((2, 0))],
    )
    assert Sets.fits(cast(Any, sets), cast(Any, None), 0) is fits
