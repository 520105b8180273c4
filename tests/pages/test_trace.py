"""What a page is drawn from: largest values, lengths and lines are those of all places, however few
are kept."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gcomp
from postproc.api.programs import defaults
from postproc.commands import reading
from postproc.filter import Filter
from postproc.trace import CLASSES, MOST, Series, Trace, larger_of_two
from postproc.verify import Verifier

ROOT = Path(__file__).resolve().parents[2]
CASES = [
    ("shaft.nc", "studer-s36"),
    ("pocket_mill.ngc", "example-mill"),
    ("diagonal_one_block.nc", "studer-s36"),
]


def traced(
    text: bytes, machine: str, most: int = MOST, size: int = 1 << 20
) -> tuple[Filter, Verifier, Trace]:
    """A program, corrected and verified in pieces of so many bytes, with a trace."""
    filter_ = reading.filter_of(defaults(), gcomp.load_machine(machine))
    verifier = Verifier(filter_)
    verifier.trace = Trace(filter_.machine, most)
    for k in range(0, len(text), size):
        filter_.feed(text[k : k + size])
    filter_.finish()
    return filter_, verifier, verifier.trace


def sample(name: str) -> bytes:
    return (ROOT / "sample_programs" / name).read_bytes()


@pytest.mark.parametrize("name, machine", CASES)
@pytest.mark.parametrize("most", [20, MOST])
def test_the_largest_are_drawn_however_few_places_are_kept(name, machine, most):
    _, verifier, trace = traced(sample(name), machine, most)
    before, after = trace.before.places(), trace.after.places()
    assert before.distance.max() == verifier.uncorrected.deviation
    assert after.distance.max() == verifier.corrected.deviation
    assert after.line[np.argmax(after.distance)] == verifier.corrected.line
    assert max(len(before), len(after)) <= most
    assert trace.worst()[0].line == verifier.corrected.line


@pytest.mark.parametrize("name, machine", CASES)
def test_any_cut_of_the_program_gives_the_same_trace(name, machine):
    whole, pieces = (traced(sample(name), machine, size=size)[2] for size in (1 << 20, 40))
    for series in ("before", "after"):
        one, other = (getattr(t, series).places() for t in (whole, pieces))
        np.testing.assert_allclose(one.s, other.s, atol=1e-9)
        np.testing.assert_array_equal(one.line, other.line)
        np.testing.assert_allclose(one.distance, other.distance, atol=2e-8)
        np.testing.assert_allclose(whole.histogram[series], pieces.histogram[series], atol=1e-9)
    assert (whole.cuts, whole.take_ups, whole.text) == (pieces.cuts, pieces.take_ups, pieces.text)
    assert [w.line for w in whole.worst()] == [w.line for w in pieces.worst()]


def test_by_hand_a_straight_line_with_a_squareness_error():
    """X is 400 urad out of square in Y: Y is off by 0.0004 * X, so 40 um at X100 and half of the
    path over 20 um."""
    text = b"G21 G90\nG0 X0 Y0 Z0\nG1 X100 F100\n"
    machine = gcomp.load_machine("perfect")
    leaning = replace(machine, square={"X": np.array([0.0, 0.0, 400e-6])})
    filter_ = reading.filter_of(defaults(), leaning)
    verifier = Verifier(filter_)
    verifier.trace = trace = Trace(leaning)
    filter_.feed(text)
    before, after = trace.before.places(), trace.after.places()
    assert trace.length == pytest.approx(100.0)
    x, y = (machine.letters.index(a) for a in "XY")
    np.testing.assert_allclose(np.abs(before.off[y]), 400e-6 * before.point[x], atol=1e-12)
    np.testing.assert_allclose(
        after.command[y], -before.off[y][-1] * after.point[x] / 100.0, atol=2e-3
    )
    assert before.distance.max() == pytest.approx(0.04)
    assert after.distance.max() < 1e-3
    half = trace.histogram["before"][np.searchsorted(CLASSES, 0.0201) + 1 :].sum()
    assert 35.0 < half < 55.0
    assert trace.text[3][0] == "G1 X100 F100"


def test_lengths_of_path_add_up_to_what_is_cut():
    _, _, trace = traced(sample("shaft.nc"), "studer-s36")
    for counts in trace.histogram.values():
        assert counts.sum() == pytest.approx(482.4615, abs=1e-3)


def test_blocks_added_are_cuts_and_take_ups():
    filter_, _, trace = traced(sample("pocket_mill.ngc"), "example-mill")
    assert trace.cuts + trace.take_ups == filter_.summary.added
    assert len(trace.turns) == trace.take_ups > 0  # as few as here are all kept


def test_what_became_of_a_line_stands_with_it():
    _, _, trace = traced(sample("shaft.nc"), "studer-s36")
    own, became = trace.text[17]
    assert (
        own == "N120 Z190. F80."
        and became[0].startswith("N120 Z")
        and "F80." in became[0]
        and len(became) == 5
    )


def test_of_a_long_program_all_parts_are_drawn_alike():
    """Back and forth 2,000 times: each tenth of the path has its tenth of the places, however the
    program was cut."""
    text = b"G90 G21 G18\nG0 X20. Z10.\nG1 F500\n" + b"".join(
        b"X%d. Z%d.\n" % (20 + i % 2 * 40, 20 + i % 2) for i in range(2000)
    )
    for size in (1 << 20, 3000):
        _, verifier, trace = traced(text, "studer-s36", 200, size)
        for series in (trace.before, trace.after):
            places = series.places()
            counts = np.histogram(places.s, 10, (0, trace.length))[0]
            assert 100 <= len(places) <= 200 and counts.min() > 0.5 * counts.mean(), counts
        assert trace.after.places().distance.max() == verifier.corrected.deviation
        at = np.array([s for s, _ in trace.turns])
        assert len(at) <= 600 and np.histogram(at, 10, (0, trace.length))[0].min() > 0


def test_of_two_neighbours_the_larger_stays():
    assert larger_of_two(np.array([1.0, 2.0, 5.0, 4.0, 3.0])).tolist() == [1, 2, 4]
    assert larger_of_two(np.array([])).tolist() == []


def test_a_series_of_nothing_is_empty():
    assert len(Series(3, 10).places()) == 0
