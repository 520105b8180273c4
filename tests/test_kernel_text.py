"""The compiled kernel puts edits into a text as numpy does, to the byte: numbers of any size, many
lists, out of order, at one place."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from postproc import kernel
from postproc.compensate import Options
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects, splice
from postproc.nc.splice import Splice
from tests.small_machines import write_mill
from tests.test_kernel import KINDS, ZERO, needs_compiler

BIG = 2**63 - 1
NUMBERS = st.one_of(
    st.integers(-BIG, BIG), st.integers(-20, 20), st.sampled_from([10**k for k in range(19)])
)


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> ctypes.CDLL:
    target = tmp_path_factory.mktemp("kernel") / "kernel-built.so"
    assert kernel.build(str(target)) == ""
    return ctypes.CDLL(str(target))


class Counted:
    """The kernel, and how often it made edits, or left them to be put in order."""

    def __init__(self, library: ctypes.CDLL):
        self.library, self.made, self.left = library, 0, 0

    def __getattr__(self, name: str):
        return getattr(self.library, name)

    def splice(self, work) -> None:
        self.library.splice(work)
        written = work._obj.written
        self.made += written >= 0
        self.left += written < 0


def both(text: bytes, calls: list[tuple], library: ctypes.CDLL) -> tuple[bytes, Counted]:
    """What edits make of a text; without the kernel, and with it, that is the same."""
    results, counted = [], Counted(library)
    with pytest.MonkeyPatch.context() as m:
        m.setattr(splice, "FEW", 0)
        for one in (None, counted):
            m.setattr(kernel, "library", lambda one=one: one)
            made = Splice(text)
            for name, *arguments in calls:
                getattr(made, name)(*arguments)
            results.append(made.result())
    assert results[0] == results[1]
    return results[0], counted


@st.composite
def edits(draw, length: int) -> tuple:
    """One call of a Splice, in order or not."""
    n = draw(st.integers(1, 6))
    starts = draw(st.lists(st.integers(0, length), min_size=n, max_size=n))
    if draw(st.booleans()):
        starts = sorted(starts)
    stops = [min(s + draw(st.sampled_from([0, 0, 1, 3])), length) for s in starts]
    ranks = draw(st.lists(st.integers(-4, 4), min_size=n, max_size=n, unique=True))
    place = np.array(starts), np.array(stops), np.array(ranks)
    kind = draw(st.sampled_from(["numbers", "numbers", "texts", "constants"]))
    if kind == "constants":
        return kind, *place, draw(st.binary(max_size=4))
    if kind == "texts":
        return kind, *place, draw(st.lists(st.binary(max_size=4), min_size=n, max_size=n))
    value = np.array(draw(st.lists(NUMBERS, min_size=n, max_size=n)))
    decimals = np.array(draw(st.lists(st.integers(0, 9), min_size=n, max_size=n)))
    if not draw(st.booleans()):
        return kind, *place, value, decimals
    k = draw(st.integers(1, 6))
    prefix = draw(st.lists(st.sampled_from(b"\0 X="), min_size=n * k, max_size=n * k))
    return kind, *place, value, decimals, np.array(prefix, np.uint8).reshape(n, k)


@needs_compiler
@given(st.data())
def test_edits_are_made_as_numpy_makes_them(library, data):
    text = data.draw(st.binary(max_size=30))
    calls = data.draw(st.lists(edits(len(text)), min_size=1, max_size=9))
    both(text, calls, library)


@needs_compiler
@given(st.lists(NUMBERS, min_size=1, max_size=5), st.integers(0, 9))
@example([-BIG, BIG, 0, -1, 10**18], 9)
@example([-5, 5], 0)
def test_numbers_are_written_as_they_are(library, values, decimals):
    n = len(values)
    place = np.arange(n)
    call = ("numbers", place, place, place, np.array(values), np.full(n, decimals))
    out, counted = both(b"\n" * n, [call], library)
    assert counted.made == 1 and not counted.left
    for value, line in zip(values, out.decode().split("\n"), strict=False):
        digits = f"{abs(value):0{decimals + 1}d}"
        whole, part = digits[: len(digits) - decimals], digits[len(digits) - decimals :]
        assert line == ("-" if value < 0 else "") + whole + "." + part


@needs_compiler
@pytest.mark.parametrize("lists, left", [(31, 0), (32, 0), (33, 1)])
def test_more_lists_than_it_takes_become_one(library, lists, left):
    place = np.arange(3)
    calls = [
        ("numbers", place, place + k % 2, place - k, place * k, np.full(3, k % 4))
        for k in range(lists)
    ]
    _, counted = both(b"abc", calls, library)
    assert (counted.made, counted.left) == (1, left)


@needs_compiler
@pytest.mark.parametrize("start, rank", [([3, 1], [0, 0]), ([1, 1], [1, 0])])
def test_a_list_that_is_not_in_order_is_put_in_order(library, start, rank):
    call = ("numbers", np.array(start), np.array(start), np.array(rank), np.array([1, 2]),
            np.array([0, 0]))  # fmt: skip
    out, counted = both(b"abcd", [call], library)
    assert out == {3: b"a2.bc1.d", 1: b"a2.1.bcd"}[start[0]]
    assert (counted.made, counted.left) == (1, 1)


@needs_compiler
def test_edits_at_one_place_keep_the_order_in_which_they_came(library):
    """Of one rank; what is put in stands before what is taken out, whatever its rank."""
    one, two = np.array([1]), np.array([2])
    calls = [
        ("numbers", one, two, one * -9, one * 9, one),
        *(("numbers", one, one, one, one * k, one * 0) for k in (5, 3, 4)),
        ("constants", one, one, one, b"c"),
        ("numbers", one, one, one * 0, one * 7, one * 0),
    ]
    out, counted = both(b"abc", calls, library)
    assert out == b"a7.5.3.4.c0.9c"
    assert not counted.left


@needs_compiler
def test_columns_of_any_kind_and_that_do_not_lie_in_one_piece_are_taken(library):
    n = 7
    place = np.arange(2 * n, dtype=np.int32)[::2]
    value = (np.arange(3 * n) * 1000 - 4000)[::3]
    prefix = np.full((n, 4), ord("X"), np.uint8)[:, ::2]
    call = ("numbers", place, place, np.zeros(n), value, np.full(n, 3, np.int8), prefix)
    out, counted = both(b"." * 2 * n, [call], library)
    assert out.startswith(b"XX-4.000..XX-1.000..XX2.000") and counted.made == 1


@needs_compiler
@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "haas", "siemens", "grbl"])
@pytest.mark.parametrize("kind", ["arcs", "by R", "helices", "other planes"])
def test_programs_have_the_same_bytes(tmp_path, monkeypatch, library, dialect, kind):
    machine = read_machine(write_mill(tmp_path / "mill", False))
    text = str(KINDS[kind](1)).replace("M2", "M30").replace("X100 Y0 Z0", "X100. Y0. Z0.")
    if dialect == "siemens":
        text = text.replace("G21", "G71").replace(" R", " CR=")
    outs, counted = [], Counted(library)
    for one in (None, counted):
        monkeypatch.setattr(kernel, "library", lambda one=one: one)
        filter_ = Filter(
            machine, dialects.load(dialect), setup_of(machine, ZERO), Options(tolerance=0.001)
        )
        outs.append(filter_.feed(text.encode()) + filter_.finish())
    assert outs[0] == outs[1] != text.encode()
    assert counted.made
