"""Where zero lies: work and tool offsets by name, shifts that the program has set, and what a block
says of them.

What is not stated and not known becomes a reason beside the motions: it matters only where a
correction depends on the place.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from postproc.flags import any_of
from postproc.motions import Presets
from postproc.nc.batch import AxisWords, Batch
from postproc.nc.columns import changes
from postproc.nc.control import ALSO
from postproc.nc.dialects import Dialect
from postproc.nc.queries import at_first, unit_at_first
from postproc.nc.rows import SECOND_REFERENCE
from postproc.nc.state import NONE, Frame, ticks_of
from postproc.records import columns, replace

EXTERNAL = "EXT"
MOST_NAMES = 8  # of offsets that are stated, in a sentence


@columns
class Zero:
    """Where the zero of absolute words lies, `offset` (A, 1) ticks, as worked out last: for this
    frame and these offsets of the program, the code of the work offset and the tool's name."""

    frame: Frame
    offsets: dict[str, dict[str, float]]
    work: int
    tool: str
    offset: np.ndarray

    def holds(self, b: Batch, work: int) -> bool:
        """Whether it does throughout a batch, in which this work offset holds."""
        same = self.frame is b.frame and self.offsets is b.offsets
        return same and (self.work, self.tool) == (work, b.tool)


def _work_out(b: Batch) -> None:
    """The same for any batch."""
    # what `work_columns` finds not stated it writes into `reason` itself: the last block tells
    before = int(b.reason[-1]) if b.n else 0
    b.offset = work_columns(b) + b.frame.shift[:, None]
    b.zero_known = not b.frame.unknown and not (b.n and b.reason[-1] != before)
    for reason in b.frame.unknown.values():
        b.reason[:] = b.because(*reason)


def offset_columns(b: Batch) -> None:
    """`offset` (A, B) or (A, 1) ticks: where the zero of absolute words lies; unknown parts become
    reasons."""
    # Line by line the zero is mostly that of the line before: it is worked out again only where the
    # frame, the offsets, the code or the tool is another one. A zero with a reason is not kept, for
    # reasons are numbered in their own batch.
    work, tools = b.held("work offset"), b.dialect.tool_offsets and "T" in b.places
    if tools or not isinstance(work, int):
        _work_out(b)
    elif not (b.control.zero and b.control.zero.holds(b, work)):
        count = len(b.reasons)
        _work_out(b)
        known = len(b.reasons) == count
        b.control.zero = Zero(b.frame, b.offsets, work, b.tool, b.offset) if known else None
    else:
        b.offset = b.control.zero.offset
    if (
        b.dialect.local_is_preset
        and any_of(b.machine)
        and b.frame.length[[row for x, row in b.rows.items() if x in "ABC"]].any()
    ):
        b.blame(
            np.flatnonzero(b.machine), "G53 while the tool has a length along a rotary axis",
            "this control takes the rotary axis along by the offset, as measured: write G49 before",
        )  # fmt: skip


def _work_offset(b: Batch, number: int) -> str:
    """The work offset that a code calls, "" for none: G54.1, and some controls' G54, the additional
    one in force; where a letter chooses it, what that chose."""
    if b.dialect.offset_letter:
        return b.frame.extended or f"{b.dialect.offset_letter}0"
    if number == NONE:
        return ""
    extended = b.frame.extended
    if extended and (number == 541 or (extended.startswith("G54") and number == 540)):
        return extended
    return b.dialect.by_number[number].word


def work_columns(b: Batch) -> np.ndarray:
    """(A, B) or (A, 1) ticks of work and tool offsets alone."""
    total = np.zeros((len(b.rows), 1), np.int64)
    if EXTERNAL in b.setup.offsets or EXTERNAL in b.offsets:
        total = total + offset_of(b, EXTERNAL, True)
    work = b.held("work offset")
    # each work offset that holds anywhere in the batch, once, where it holds
    for number in [work] if isinstance(work, int) else sorted(set(work[changes(work)].tolist())):
        total = total + offset_of(b, _work_offset(b, int(number)), work == number)
    tool_place = b.places.get("T") if b.dialect.tool_offsets else None
    if tool_place is None:
        work_columns: np.ndarray = total + offset_of(b, b.tool, True)
        return work_columns
    # of a lathe: T0101 holds from its own block to the next T
    edges = [0, *b.words.block[tool_place].tolist(), b.n]
    names = [b.tool] + [tool_named(b, int(p)) for p in tool_place]
    for name, first, stop in zip(names, edges[:-1], edges[1:], strict=True):
        within = np.zeros(b.n, dtype=bool)
        within[first:stop] = True
        total = total + offset_of(b, name, within)
    b.tool_after = names[-1]
    return total


def tool_named(b: Batch, place: int) -> str:
    """The offset that a lathe's T word names, "": none. Written with five digits it is that of
    three where parameter 5028 says so (T01100: offset 100 of tool 1, or none of tool 11): its name
    is asked for."""
    number = int(b.words.mantissa[place])
    five = b.words.stop[place] - b.words.number[place] == 5 and number % 1000
    return lathe_tool(b.dialect, number) or (f"T{number:05d}" if five else "")


def lathe_tool(dialect: Dialect, number: int) -> str:
    """The offset that the number of a lathe's T word names, "": none.

    Its last two digits are the offset's number, with leading zeros left out as in any word: T2 is
    T0002, offset 2 of no tool (Fanuc Series 30i B-63943EN-1, 12 "Tool functions": the lowest one to
    three digits, as many as parameter 5028 says; in B-64304EN-1, "Tool function", two).
    """
    if dialect.nose_in_tool:
        number %= 10_000
    return f"T{number:04d}" if number % 100 else ""


def stated(b: Batch, name: str) -> dict[str, float] | None:
    """mm by axis: an offset as the program has set it, or as it was stated; None: neither."""
    found = b.offsets.get(name)
    return b.setup.offsets.get(name) if found is None else found


def homed(b: Batch) -> dict[str, float] | None:
    """mm by axis: where G28 takes the axes: the reference point that the program or the user
    states, else the places after homing, else, on printers and routers, where the machine is said
    to have stood. None: not stated."""
    found = b.offsets.get("G28")  # G28.1 of the program
    if found is not None:
        return found
    first = b.setup.start if b.dialect.homes else {}
    return {**first, **b.setup.home, **b.setup.offsets.get("G28", {})} or b.setup.offsets.get("G28")


def second_home(b: Batch) -> dict[str, float] | None:
    """mm by axis: where G30 takes the axes, where it means the second reference point; None: nobody
    says."""
    if b.dialect.by_number[300].meaning != SECOND_REFERENCE:
        return None
    return stated(b, "G30")


def stated_tool(b: Batch, letter: str, number: int) -> dict[str, float] | None:
    """mm by axis: the length that H, D or T names; a tool table knows tools by T, and the edges of
    the one in use by D."""
    for name in (
        f"{letter}{number}",
        f"T{b.beside.tool}D{number}" if letter == "D" else f"T{number}",
    ):
        place = stated(b, name)
        if place is not None:
            return place
    return None


def ask_for(b: Batch, name: str, kind: str) -> tuple[str, str]:
    """The reason that asks for an offset by its name."""
    name = ALSO.get(name, name)
    option = name.replace(" ", "")  # as one word of the command line
    names = sorted({*b.setup.offsets, *b.offsets}) or ["none"]
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    known = ", ".join(names[:MOST_NAMES]) + more
    axes = ",".join(x + "0" for x in b.setup.axes if x in "XYZ") or "X0"
    return (
        (
            f"the offset {name} is not stated: T with two digits or fewer is an offset's number"
            if name.startswith("T00")
            else f"the {kind} offset {name} is not stated"
        ),
        (
            "say where its zero lies in machine coordinates, mm and radius: --offset"
            f" {option}={axes} (stated: {known})"
        ),
    )


def offset_of(b: Batch, name: str, where: bool | np.ndarray) -> np.ndarray:
    """(A, B) or (A, 1) ticks of one offset where it holds."""
    everywhere = isinstance(where, bool)
    if not name or not (where if everywhere else np.count_nonzero(where)):
        return np.zeros((len(b.rows), 1), np.int64)
    place = stated(b, name)
    if place is None and name in ("G500", f"{b.dialect.offset_letter}0"):
        place = {}  # no work offset, unless one is stated for it
    if place is None:
        number = b.because(*ask_for(b, name, "tool" if name.startswith("T") else "work"))
        b.reason = np.where(where, number, b.reason)
        return np.zeros((len(b.rows), 1), np.int64)
    # (A, 1) where it holds throughout, (A, B) with zeros elsewhere where it does not
    shift = ticks_of(b.setup, place)[:, None]
    return shift if everywhere else shift * where


# -- what the first block says ---------------------------------------------------------------------


def values_of(b: Batch, axis_words: AxisWords) -> dict[str, tuple[int, bool]]:
    """Axis to its word's ticks in the first block, and whether it is an incremental letter."""
    result = {}
    for letter, words in axis_words.items():
        for is_inc, place in enumerate(words):
            if len(place) and b.words.block[place[0]] == 0:
                scale = unit_at_first(b, letter) // np.broadcast_to(b.halves(letter), b.n)[0]
                result[letter] = (int(b.ticks(place[:1], np.array([scale]))[0]), bool(is_inc))
    return result


def number_of(b: Batch, letter: str) -> float | None:
    """The value of a letter in the first block."""
    place = b.places.get(letter)
    if place is None or not len(place) or b.words.block[place[0]] != 0:
        return None
    return float(b.numbers(place[:1])[0])


def chosen(b: Batch, axis_words: AxisWords | None = None, word: str = "") -> None:
    """E of Fadal: the number names the work offset; its G54 is E1, G59 E6."""
    letter = b.dialect.offset_letter
    number = int(word[1:]) - 53 if word else number_of(b, letter) if letter else None
    if number is not None:
        b.frame = replace(b.frame, extended=f"{letter}{number:g}")


def note_presets(b: Batch, axis_words: AxisWords, letters: Iterable[str]) -> None:
    """Note the words that name the place where the machine stands: it stands beside it by the
    correction."""
    rows, words, scales, places = [], [], [], []
    for letter in letters:
        place = axis_words[letter][0]
        half = np.broadcast_to(b.halves(letter), b.n)[0]
        unit, grid = (np.broadcast_to(x, b.n)[0] // half for x in b.unit_scale(letter))
        rows.append(b.rows[letter])
        words.append(int(place[0]))
        scales.append(int(unit))
        # decimals of a least increment: 1 mm over 0.001 mm is 3
        places.append(round(float(np.log10(unit / grid))))
    row, word, scale, least = (np.array(c, np.int64) for c in (rows, words, scales, places))
    b.presets = Presets(np.zeros(len(rows), np.int64), row, word, scale, least, _sent(b, rows))


def _sent(b: Batch, rows: list[int]) -> np.ndarray:
    return b.state.sent[rows] if b.state.sent is not None else np.zeros(len(rows), bool)


def changed(part: np.ndarray, values: dict[int, int]) -> np.ndarray:
    part = part.copy()
    for row, value in values.items():
        part[row] = value
    return part


def with_known(frame: Frame, part: str, reason: tuple[str, str] | None = None) -> Frame:
    """The frame with a part known again, or unknown for a reason."""
    rest = {k: v for k, v in frame.unknown.items() if k != part}
    return replace(frame, unknown=rest if reason is None else {**rest, part: reason})


def goes_on(b: Batch, word: str) -> bool:
    """Whether a shift in G91 counts from the one in force, which is not followed."""
    if at_first(b, "distance") != 910:
        return False
    reason = (f"{word} in G91 counts from the datum in force", f"write {word} in G90")
    b.frame = with_known(b.frame, "turned", reason)
    return True
