"""Where G28 and G30 send the axes: which of them, to what place, and where that is not known."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.nc.batch import Batch
from postproc.nc.grammar import AXES, BARE
from postproc.nc.queries import words_of
from postproc.nc.zeros import homed, second_home
from postproc.units import TICKS_PER_MM


def sending(b: Batch) -> dict[int, np.ndarray]:
    """By number, ten times G28 and G30: the blocks that send axes away. Where the code does
    something else (a corner of the blank, in Heidenhain's DIN/ISO) nothing moves."""
    return {
        number: b.single[number]
        for number in (280, 300)
        if number in b.single and not b.dialect.by_number[number].does
    }


def away(
    b: Batch, letter: str, position: np.ndarray, named: np.ndarray, forget: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(B,) positions, events and lost places where G28 and G30 send an axis away, and (B,) bool
    where they do."""
    drop = forget.copy()
    away = np.zeros(b.n, bool)
    for number, block_of in sending(b).items():
        # First every axis that the code takes is lost; one whose reference point is stated comes
        # back.
        gone = drop.copy()
        _reference(b, number, letter, gone)
        away[block_of] = gone[block_of]
        reference = homed(b) if number == 280 else second_home(b)
        place = None
        if reference is None or letter not in reference:
            drop = gone
        else:
            unsure = _bare(b, number) if b.dialect.home_named else np.zeros(b.n, bool)
            if number == 300:
                unsure[_further(b)] = True
            elsewhere = unsure[block_of]
            drop[block_of[elsewhere]] = gone[block_of[elsewhere]]
            block_of = block_of[~elsewhere]
            drop[block_of] = False
            there = block_of[gone[block_of]]
            place = round(reference[letter] * TICKS_PER_MM)
            position, named = _sent(position, named, there, place)
        if number == 280 and letter in b.dialect.home_z_over:
            drop = _taken_along(b, letter, place, position, drop)
    return position, named, drop, away


def _further(b: Batch) -> np.ndarray:
    """Blocks with a P that is not 2: G30 P3 goes to the third reference point."""
    place = words_of(b, "P")
    w = b.words
    further: np.ndarray = w.block[place[(w.mantissa[place] != 2) | (w.decimals[place] != 0)]]
    return further


def _taken_along(
    b: Batch, letter: str, place: int | None, position: np.ndarray, drop: np.ndarray
) -> np.ndarray:
    """(B,) lost places, with those of an axis that homing Z alone may take along; one that is at
    home stays there."""
    own, z = np.zeros(b.n, bool), np.zeros(b.n, bool)
    _reference(b, 280, letter, own)
    _reference(b, 280, "Z", z)
    for block in np.flatnonzero(z & ~own):
        # where the block before has left it
        before = position[block - 1] if block else b.state.position[b.rows[letter]]
        if place is None or before != place:
            drop = drop.copy()
            drop[block] = True
    return drop


def _sent(
    position: np.ndarray, named: np.ndarray, there: np.ndarray, place: int
) -> tuple[np.ndarray, np.ndarray]:
    """(B,) positions and events where blocks `there` send the axis to a place: what follows counts
    from it."""
    #   block      G0 X10   G28 X0   G91 X5   X5   G90 X20     reference point 400
    #   position     10        0        5     10     20        by the words alone
    #   sent         10      400      405    410     20        up to the next absolute place
    position, named = position.copy(), named.copy()
    for block in there:
        later = named[block + 1 :].nonzero()[0]
        stop = len(position)
        absolute = later[:1]
        if len(absolute):
            stop = block + 1 + int(absolute[0])
        position[block:stop] += place - position[block]
        named[block] = True
    return position, named


def _reference(b: Batch, number: int, letter: str, drop: np.ndarray) -> None:
    """G28 with axis words sends those axes away, without any all of them."""
    block = b.single[number]
    mine = np.zeros(b.n, bool)
    for axis, place in _axis_words(b):
        if axis == letter:
            mine[b.words.block[place]] = True
    drop[block] = mine[block] | _bare(b, number)[block]


def _bare(b: Batch, number: int) -> np.ndarray:
    """(B,) bool: blocks with G28 or G30 that name no axis."""
    bare = np.zeros(b.n, bool)
    bare[b.single[number]] = True
    for _, place in _axis_words(b):
        bare[b.words.block[place]] = False
    return bare


def _axis_words(b: Batch) -> Iterator[tuple[str, np.ndarray]]:
    """Axes, and the words that name each, as a place, an increment or a letter alone."""
    reverse = {u: b.setup.axes[row] for u, row in b.control.increment_rows.items()}
    for other, place in b.places.items():
        if ord(other) >= BARE:
            other = AXES[ord(other) - BARE]
        if other in b.rows or other in reverse:
            yield reverse.get(other, other), place
