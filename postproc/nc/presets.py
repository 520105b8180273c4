"""Coordinates that a block gives the place where the axes stand: G92 and its kin."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from postproc.nc.batch import AxisWords, Batch
from postproc.nc.state import Frame
from postproc.nc.zeros import changed, note_presets, values_of, with_known, work_columns
from postproc.records import replace

LOST = (
    "a block between the start and here (homing, a macro) leads it nowhere known: run the program"
    " up to here by itself, and the rest with its own --start"
)
PART = "preset "  # of what is unknown of a frame, with the axis behind it


def known_again(frame: Frame, letters: Iterable[str] | None = None) -> Frame:
    """The frame with the presets of these axes known again, of all where none are named."""
    parts = None if letters is None else {PART + x for x in letters}
    rest = {
        part: reason
        for part, reason in frame.unknown.items()
        if not (part.startswith(PART) if parts is None else part in parts)
    }
    return replace(frame, unknown=rest)


def set_place(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G92: the place where the axes stand gets these coordinates."""
    values = values_of(b, axis_words)
    if not values:
        return
    frame = b.frame
    if b.dialect.extended_by_p:
        frame = _without_local(b, values)
    others = work_columns(b)[:, 0] + frame.shift - (frame.preset if frame.preset_on else 0)
    if not frame.preset_on:
        frame = replace(frame, preset=np.zeros_like(frame.preset))
    # coordinate = position - preset - others, so that the preset follows from the place named
    preset, named, missing = {}, [], ""
    for letter, (value, is_inc) in values.items():
        row = b.rows[letter]
        if is_inc:
            preset[row] = int(frame.preset[row] - value)  # G92 U5: the coordinate grows by 5
            continue
        named.append(letter)
        preset[row] = int(b.state.position[row] - value - others[row])
        if not b.state.known[row]:
            missing += letter
    # An axis that is not named keeps what is known of it: G92 E0 behind G92 X0 at an unknown place
    # says nothing of X.
    frame = known_again(replace(frame, preset=changed(frame.preset, preset), preset_on=True), named)
    if missing:
        reason = (
            f"{word} gives {', '.join(missing)} a new zero where the machine stands, and that"
            " is not known",
            f"say where it stands before the program, mm, radius, machine coordinates: --start"
            f" {','.join(x + '0' for x in missing)}"
            if not all(x in b.setup.start for x in missing)
            else LOST,
        )
        for letter in missing:
            frame = with_known(frame, PART + letter, reason)
    b.frame = frame
    note_presets(b, axis_words, named)


def set_or_off(b: Batch, axis_words: AxisWords, word: str) -> None:
    """The same; without a word it takes the shift back."""
    (set_place if values_of(b, axis_words) else set_zero)(b, axis_words, word)


def set_or_all(b: Batch, axis_words: AxisWords, word: str) -> None:
    """The same; without a word every axis gets 0 where it stands, and so a zero that lies beside
    the nominal one by the correction: there is no word that could take it up."""
    if values_of(b, axis_words):
        set_place(b, axis_words, word)
        return
    every = " ".join(x + "0" for x in b.setup.axes)
    reason = (f"{word} without a word gives every axis the coordinate 0", f"write {word} {every}")
    for letter in b.setup.axes:
        b.frame = with_known(b.frame, PART + letter, reason)


def _without_local(b: Batch, letters: Iterable[str]) -> Frame:
    """The frame without what G52 has set of these axes: G92 of an axis takes its local coordinates
    back (Fanuc B-64484EN-2, "Local coordinate system", notes; NCT 99M, 9.2.4, says the same)."""
    return replace(b.frame, local=changed(b.frame.local, {b.rows[x]: 0 for x in letters}))


def set_zero(b: Batch, axis_words: AxisWords, word: str) -> None:
    """No shift by G92; where axes are named (G92.1 X0 of Fanuc), none of theirs alone, by G52
    neither."""
    named = values_of(b, axis_words) if b.dialect.extended_by_p else {}
    if named:
        frame = _without_local(b, named)
        preset = changed(frame.preset, {b.rows[x]: 0 for x in named})
        b.frame = known_again(replace(frame, preset=preset), named)
        return
    frame = replace(b.frame, preset=np.zeros_like(b.frame.preset), preset_on=True)
    if b.dialect.local_is_preset:
        frame = replace(frame, local=np.zeros_like(frame.local))
    b.frame = known_again(frame)


def set_off(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G92.2: the shift is kept, and not in force."""
    b.frame = known_again(replace(b.frame, preset_on=False))


def set_back(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G92.3: it is what it was before G92.2."""
    b.frame = replace(b.frame, preset_on=True)
