"""New digits in old text: numbers, order, and everything else untouched."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from postproc.nc.numbers import decimal_cells, decimal_text
from postproc.nc.splice import Splice


@given(
    st.lists(st.integers(-(10**15), 10**15), min_size=1, max_size=20),
    st.integers(1, 9),
    st.integers(0, 6),
)
def test_numbers_are_written_exactly(values, decimals, room):
    cells, begin, end = decimal_cells(np.array(values), decimals, room)
    for value, cell, b in zip(values, cells, begin, strict=True):
        assert b >= room
        assert cell[b:end].tobytes() == decimal_text(value, decimals)
        digits = f"{abs(value):0{decimals + 1}d}"
        assert (
            cell[b:end].tobytes().decode()
            == ("-" if value < 0 else "") + digits[:-decimals] + "." + digits[-decimals:]
        )


@given(st.binary(max_size=60), st.data())
def test_edits_land_where_they_belong(text, data):
    cuts = sorted(data.draw(st.lists(st.integers(0, len(text)), max_size=8, unique=True)))
    edits = [
        (a, b, data.draw(st.binary(max_size=5)))
        for a, b in zip(cuts[::2], cuts[1::2], strict=False)
    ]
    splice = Splice(text)
    for order in data.draw(st.permutations(range(len(edits)))):
        a, b, new = edits[order]
        splice.texts([a], [b], [0], [new])
    expected, last = b"", 0
    for a, b, new in edits:
        expected, last = expected + text[last:a] + new, b
    assert splice.result() == expected + text[last:]


def test_edits_at_one_place_keep_their_rank():
    splice = Splice(b"ab")
    splice.texts([1, 1, 1], [1, 1, 1], [5, -3, 0], [b"3", b"1", b"2"])
    assert splice.result() == b"a123b"


def test_what_is_put_in_stands_before_what_is_taken_out_from_there_on():
    splice = Splice(b"Z80. R5.\n")
    splice.constants([4], [8], [0], b"")
    splice.constants([4], [4], [20], b" I5")
    assert splice.result() == b"Z80. I5\n"


def test_two_words_that_go_may_take_the_blank_between_them_along():
    splice = Splice(b"G2 I0 J9 X1\n")
    splice.constants(np.array([3, 5]), np.array([6, 8]), np.array([0, 0]), b"")
    assert splice.result() == b"G2  X1\n"
