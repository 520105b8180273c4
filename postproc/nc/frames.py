"""Shifts of the coordinates: G52, G92 and its kin, G10, G43 and its kin, G54.1, TRANS.

A block that changes a shift begins a segment of its own, so that within a segment every shift is one number per axis and
all else stays columns. What a shift depends on and nobody has said becomes a reason beside the motions: it matters only
where a correction depends on the place.

Sources: NIST RS274/NGC 3.2, 3.5.5-3.5.17; LinuxCNC as measured (tests/linuxcnc/README.md); Fanuc B-63944EN, chapter
"Coordinate system"; Siemens 840D Programming Guide Fundamentals, "Frame instructions".
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from postproc.motions import Presets
from postproc.nc.batch import Batch
from postproc.nc.columns import changes
from postproc.nc.state import NONE, Frame
from postproc.units import TICKS_PER_MM

WORK_OF_P = ("", "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
EXTERNAL = "EXT"
EXPAND = "--expand writes the program out in plain coordinates"


def event(b: Batch, axis_words: dict[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """Let the first block of a segment change the shifts, if it does; sets b.frame and b.offsets."""
    for number, does in b.dialect.frame_codes.items():
        code = b.dialect.by_number[number]
        named = b.given[code.group][:1] == number if code.group in b.given else np.zeros(0, bool)
        if code.group and not named.any():
            continue
        if not code.group and not (b.single.get(number, np.ones(1))[:1] == 0).any():
            continue
        if not b.live[0]:
            continue
        ACTIONS[does](b, axis_words, code.word)
    if b.dialect.length_letter != "H" and _number(b, b.dialect.length_letter) is not None:
        _length_by(b, b.dialect.length_letter)
    if b.dialect.extended_by_p and "work offset" in b.given and b.given["work offset"][0] == 540 and _number(b, "P"):
        _extended(b, axis_words, "G54")


def offset_columns(b: Batch) -> None:
    """`offset` (A, B) or (A, 1) ticks: where the zero of absolute words lies; unknown parts become reasons."""
    before = b.reason.copy()
    b.offset = work_columns(b) + b.frame.shift[:, None]
    b.zero_known = not b.frame.unknown and not (b.n and b.reason[-1] != before[-1])
    for reason in b.frame.unknown.values():
        b.reason[:] = b.because(*reason)


def work_columns(b: Batch) -> np.ndarray:
    """(A, B) or (A, 1) ticks of work and tool offsets alone."""
    total = np.zeros((len(b.rows), 1), np.int64)
    if EXTERNAL in b.setup.offsets or EXTERNAL in b.offsets:
        total = total + _offset(b, EXTERNAL, True)
    work = b.held("work offset")
    for number in sorted(set(np.asarray(work).ravel()[changes(work)].tolist())):
        name = "" if number == NONE else b.dialect.by_number[int(number)].word
        if (
            b.frame.extended
            and number != NONE
            and (name == "G54.1" or (b.frame.extended.startswith("G54") and number == 540))
        ):
            name = b.frame.extended
        total = total + _offset(b, name, work == number)
    tool_place = b.places.get("T") if b.dialect.tool_offsets else None
    if tool_place is None:
        return total + _offset(b, b.tool, True)
    edges = [0, *b.words.block[tool_place].tolist(), b.n]
    names = [b.tool] + [_tool_name(b, int(p)) for p in tool_place]
    for name, first, stop in zip(names, edges[:-1], edges[1:], strict=True):
        within = np.zeros(b.n, dtype=bool)
        within[first:stop] = True
        total = total + _offset(b, name, within)
    b.tool_after = names[-1]
    return total


def _tool_name(b: Batch, place: int) -> str:
    number = int(b.words.mantissa[place])
    return f"T{number:04d}" if number >= 100 and number % 100 else ""


def stated(b: Batch, name: str) -> dict[str, float] | None:
    """mm by axis: an offset as the program has set it, or as it was stated; None: neither."""
    found = b.offsets.get(name)
    return b.setup.offsets.get(name) if found is None else found


def stated_tool(b: Batch, letter: str, number: int) -> dict[str, float] | None:
    """mm by axis: the length that H, D or T names; a tool table knows tools by T."""
    for name in (f"{letter}{number}", f"T{b.state.next_tool}D{number}" if letter == "D" else f"T{number}"):
        place = stated(b, name)
        if place is not None:
            return place
    return None


def ask_for(b: Batch, name: str, kind: str) -> tuple[str, str]:
    """The reason that asks for an offset by its name."""
    known = ", ".join(sorted({*b.setup.offsets, *b.offsets})) or "none"
    axes = ",".join(x + "0" for x in b.setup.axes if x in "XYZ") or "X0"
    return (
        f"the {kind} offset {name} is not stated",
        f"say where its zero lies in machine coordinates, mm and radius: --offset {name}={axes} (stated: {known})",
    )


def _offset(b: Batch, name: str, where) -> np.ndarray:
    """(A, B) or (A, 1) ticks of one offset where it holds."""
    if not name or not np.any(where):
        return np.zeros((len(b.rows), 1), np.int64)
    place = stated(b, name)
    if place is None and name == "G500":
        place = {}  # no work offset, unless one is stated for it
    if place is None:
        number = b.because(*ask_for(b, name, "tool" if name.startswith("T") else "work"))
        b.reason = np.where(where, number, b.reason)
        return np.zeros((len(b.rows), 1), np.int64)
    shift = ticks_of(b, place)
    return shift[:, None] * np.atleast_1d(np.asarray(where, np.int64))


def ticks_of(b: Batch, place: dict[str, float]) -> np.ndarray:
    """(A,) ticks of mm by axis."""
    return np.array([round(place.get(x, 0.0) * TICKS_PER_MM) for x in b.setup.axes], np.int64)


# -- what the first block says -------------------------------------------------------------------------------------------


def _values(b: Batch, axis_words) -> dict[str, tuple[int, bool]]:
    """Axis to its word's ticks in the first block, and whether it is an incremental letter."""
    result = {}
    for letter, words in axis_words.items():
        for is_inc, place in enumerate(words):
            if len(place) and b.words.block[place[0]] == 0:
                scale = np.broadcast_to(b.unit_scale(letter)[0], b.n)[0] // np.broadcast_to(b.halves(letter), b.n)[0]
                result[letter] = (int(b.ticks(place[:1], np.array([scale]))[0]), bool(is_inc))
    return result


def _number(b: Batch, letter: str) -> float | None:
    """The value of a letter in the first block."""
    place = b.places.get(letter)
    if place is None or not len(place) or b.words.block[place[0]] != 0:
        return None
    return float(b.numbers(place[:1])[0])


def _presets(b: Batch, axis_words, letters) -> None:
    """Note the words that name the place where the machine stands: it stands beside it by the correction."""
    rows, words, scales, places = [], [], [], []
    for letter in letters:
        place = axis_words[letter][0]
        half = np.broadcast_to(b.halves(letter), b.n)[0]
        unit, grid = (np.broadcast_to(x, b.n)[0] // half for x in b.unit_scale(letter))
        rows.append(b.rows[letter])
        words.append(int(place[0]))
        scales.append(int(unit))
        places.append(round(float(np.log10(unit / grid))))
    b.presets = Presets(np.zeros(len(rows), np.int64), *(np.array(c, np.int64) for c in (rows, words, scales, places)))


def _changed(part: np.ndarray, values: dict[int, int]) -> np.ndarray:
    part = part.copy()
    for row, value in values.items():
        part[row] = value
    return part


def _known(frame: Frame, part: str, reason: tuple[str, str] | None = None) -> Frame:
    """The frame with a part known again, or unknown for a reason."""
    rest = {k: v for k, v in frame.unknown.items() if k != part}
    return replace(frame, unknown=rest if reason is None else {**rest, part: reason})


def _set(b: Batch, axis_words, word: str) -> None:
    """G92: the place where the axes stand gets these coordinates."""
    values = _values(b, axis_words)
    if not values:
        return
    frame = b.frame
    others = work_columns(b)[:, 0] + frame.shift - (frame.preset if frame.preset_on else 0)
    if not frame.preset_on:
        frame = replace(frame, preset=np.zeros_like(frame.preset))
    preset, missing = {}, ""
    for letter, (value, is_inc) in values.items():
        row = b.rows[letter]
        if is_inc:
            preset[row] = int(frame.preset[row] - value)
            continue
        preset[row] = int(b.state.position[row] - value - others[row])
        if not b.state.known[row]:
            missing += letter
    reason = None
    if missing:
        reason = (
            f"{word} gives {', '.join(missing)} a new zero where the machine stands, and that is not known",
            f"say where it stands before the program, mm, radius, machine coordinates: --start "
            f"{','.join(x + '0' for x in missing)}",
        )
    b.frame = _known(replace(frame, preset=_changed(frame.preset, preset), preset_on=True), "preset", reason)
    _presets(b, axis_words, [x for x, (_, is_inc) in values.items() if not is_inc])


def _set_zero(b: Batch, axis_words, word: str) -> None:
    frame = replace(b.frame, preset=np.zeros_like(b.frame.preset), preset_on=True)
    if b.dialect.local_is_preset:
        frame = replace(frame, local=np.zeros_like(frame.local))
    b.frame = _known(frame, "preset")


def _set_off(b: Batch, axis_words, word: str) -> None:
    b.frame = _known(replace(b.frame, preset_on=False), "preset")


def _set_back(b: Batch, axis_words, word: str) -> None:
    b.frame = replace(b.frame, preset_on=True)


def _local(b: Batch, axis_words, word: str) -> None:
    """G52: a zero within the work offset. LinuxCNC keeps it where it keeps G92's."""
    values = {b.rows[x]: value for x, (value, _) in _values(b, axis_words).items()}
    if b.dialect.local_is_preset:
        base = b.frame.preset if b.frame.preset_on else np.zeros_like(b.frame.preset)
        b.frame = _known(replace(b.frame, preset=_changed(base, values), preset_on=True), "preset")
    else:
        b.frame = replace(b.frame, local=_changed(b.frame.local, values))


def _data(b: Batch, axis_words, word: str) -> None:
    """G10: the program writes offsets. L2 a work offset, L20 so that the axes stand at these coordinates (Fanuc: an
    additional work offset), L1 L10 L11 a tool's."""
    line, number = _number(b, "L"), _number(b, "P")
    values = _values(b, axis_words)
    if not values and _number(b, "R") is None:
        return
    if line is None and b.dialect.tool_offsets and number is not None:
        line = 10.0
    if line not in (1, 2, 10, 11, 20) or number is None or number != int(number) or number < 0:
        b.frame = _known(b.frame, "data", (f"G10 L{line:g} is not followed" if line is not None else "G10 without L",
            "it sets data of the control: set them before the program, and take the block out"))  # fmt: skip
        return
    p = int(number)
    if line in (1, 10, 11):
        _tool_data(b, axis_words, p, int(line), values)
        return
    by_place = line == 20 and not b.dialect.extended_by_p
    if line == 20 and not by_place:
        name = f"G54.1 P{p}"
    elif p == 0 and b.dialect.extended_by_p:
        name = EXTERNAL
    elif p == 0:
        held = int(np.broadcast_to(b.held("work offset"), b.n)[0])
        name = b.dialect.by_number[held].word if held != NONE else "G54"
    else:
        name = WORK_OF_P[p] if p < len(WORK_OF_P) else ""
    if not name:
        b.frame = _known(b.frame, "data", (f"G10 P{p} names no work offset", "P1 is G54, P2 is G55 and so on"))
        return
    if _number(b, "R") is not None and not b.dialect.tool_offsets and not b.dialect.extended_by_p:
        b.frame = _known(b.frame, "data", ("G10 R turns the coordinates", EXPAND))
        return
    old = stated(b, name)
    reason = None
    place = dict(old or {})
    incremental = b.dialect.extended_by_p and int(np.broadcast_to(b.held("distance"), b.n)[0]) == 910
    for letter, (value, is_inc) in values.items():
        row = b.rows[letter]
        if by_place:
            if not b.state.known[row]:
                reason = (f"G10 L20 sets {name} from where {letter} stands, and that is not known",
                          f"say where it stands: --start {letter}0")  # fmt: skip
            value = int(b.state.position[row]) - value - int(b.frame.shift[row])
        elif incremental or is_inc:
            value = value + round(place.get(letter, 0.0) * TICKS_PER_MM)
        place[letter] = value / TICKS_PER_MM
    if by_place:
        _presets(b, axis_words, values)
    if old is None and (set(values) < set(b.setup.axes) & set("XYZ") or incremental):
        reason = ask_for(b, name, "work")
    b.offsets = {**b.offsets, name: place}
    b.frame = _known(b.frame, f"data {name}", reason)


def _tool_data(b: Batch, axis_words, p: int, line: int, values: dict[str, tuple[int, bool]]) -> None:
    """G10 L1 L10 L11 P: the offsets of a tool; what G43 has in force stays until the next G43."""
    if b.dialect.tool_offsets:
        b.frame = _known(b.frame, "data", ("G10 sets a tool offset", "state the tool offsets with --offset T0101=X..,Z.., "
                         "and take the block out"))  # fmt: skip
        return
    name = f"H{p}"
    radius = _number(b, "R")
    if not values and b.dialect.extended_by_p and radius is not None and line in (10, 11):
        unit = np.broadcast_to(b.unit_scale("Z")[0], b.n)[0]
        values = {"Z": (round(radius * int(unit)), False)} if "Z" in b.rows else {}
    place = dict(stated_tool(b, "H", p) or {})
    if line in (10, 11) and not b.dialect.extended_by_p:
        _presets(b, axis_words, values)
    for letter, (value, _) in values.items():
        row = b.rows[letter]
        if line in (10, 11) and not b.dialect.extended_by_p:  # so that the axis stands at this coordinate
            if line == 10:
                base = work_columns(b)[row, 0] + b.frame.shift[row] - b.frame.length[row]
            else:  # in G59.3, without G92
                base = ticks_of(b, stated(b, "G59.3") or {})[row]
            value = int(b.state.position[row]) - value - int(base)
        place[letter] = value / TICKS_PER_MM
    b.offsets = {**b.offsets, name: place}


def _length(b: Batch, axis_words, word: str, sign: int = 1, add: bool = False) -> None:
    """G43 H: the tool's length shifts the coordinates. Without H: the tool in use, or no tool at all."""
    number = _number(b, "H")
    if number is None or (number == 0 and b.dialect.local_is_preset and not add):
        number = float(_tool_in_spindle(b))
    if _units_changed(b):
        return
    if number == 0:
        length: np.ndarray | None = np.zeros_like(b.frame.length)
    else:
        place = stated_tool(b, "H", int(number)) if number > 0 else None
        length = None if place is None else sign * ticks_of(b, place)
    if length is None:
        name = f"H{int(number)}" if number > 0 else "H"
        reason = (f"the tool length {name} is not stated", f"say it in mm: --offset {name if number > 0 else 'H1'}=Z0 "
                  "or --offsets FILE with the control's tool table")  # fmt: skip
        b.frame = _known(b.frame, "length", reason)
        return
    units = int(np.broadcast_to(b.held("units"), b.n)[0])
    length = b.frame.length + length if add else length
    b.frame = _known(replace(b.frame, length=length, length_units=units), "length")


def _tool_in_spindle(b: Batch) -> int:
    """The tool that the first block's M6 brings, or that is there already."""
    change = b.places.get("M", np.zeros(0, np.int64))
    called = _number(b, "T")
    if (b.words.block[change[b.words.mantissa[change] == 6]] == 0).any():
        return int(called) if called is not None else b.state.next_tool
    return b.state.tool_number


def _units_changed(b: Batch) -> bool:
    """LinuxCNC keeps the number of a length when G20 or G21 changes its unit, and so thinks that it stands elsewhere when
    the length changes next: the next motion goes astray, as measured."""
    if not b.dialect.local_is_preset or not b.frame.length.any():
        return False
    units = int(np.broadcast_to(b.held("units"), b.n)[0])
    if units == b.frame.length_units:
        return False
    reason = ("the tool length changes in other units than it was set in", "this control then takes every axis to a wrong "
              "place: write G49 before G20 or G21")  # fmt: skip
    b.frame = _known(b.frame, "units", reason)
    return True


def _length_by(b: Batch, letter: str) -> None:
    """D of Siemens, T elsewhere: the number names the length, which holds at once; 0 is none."""
    number = int(_number(b, letter) or 0)
    name = f"{letter}{number}"
    place = stated_tool(b, letter, number) if number else {}
    reason = None
    if place is None:
        reason = (f"the tool length {name} is not stated", f"say it in mm: --offset {name}=Z0, or --offsets FILE with the control's tool table")
    b.frame = _known(replace(b.frame, length=ticks_of(b, place or {})), "length", reason)


def _length_words(b: Batch, axis_words, word: str) -> None:
    """G43.1: the words are the offset; axes without a word keep theirs."""
    values = {b.rows[x]: value for x, (value, _) in _values(b, axis_words).items()}
    if _units_changed(b):
        return
    units = int(np.broadcast_to(b.held("units"), b.n)[0])
    b.frame = _known(replace(b.frame, length=_changed(b.frame.length, values), length_units=units), "length")


def _no_length(b: Batch, axis_words, word: str) -> None:
    if not _units_changed(b):
        b.frame = _known(replace(b.frame, length=np.zeros_like(b.frame.length)), "length")


def _store(b: Batch, axis_words, word: str) -> None:
    """G28.1: the place where the machine stands becomes the reference point."""
    name = word.split(".")[0]
    if b.state.known.all():
        place = {x: int(b.state.position[row]) / TICKS_PER_MM for x, row in b.rows.items()}
        b.offsets = {**b.offsets, name: place}
    else:
        b.offsets = {k: v for k, v in b.offsets.items() if k != name}


def _extended(b: Batch, axis_words, word: str) -> None:
    """G54.1 P: one of many work offsets."""
    number = _number(b, "P")
    if number is None or number != int(number) or number < 1:
        b.frame = _known(b.frame, "extended", ("G54.1 without a whole P", "P1 to P300 choose the offset"))
        return
    b.frame = _known(replace(b.frame, extended=f"G54.1 P{int(number)}"), "extended")


def _trans(b: Batch, axis_words, word: str, add: bool = False) -> None:
    """TRANS: the shift is replaced, of axes that are not named by none; ATRANS adds."""
    start = b.frame.trans if add else np.zeros_like(b.frame.trans)
    values = {b.rows[x]: int(start[b.rows[x]]) + value for x, (value, _) in _values(b, axis_words).items()}
    trans = _changed(start, values)
    due = b.frame.due + trans - b.frame.trans if b.dialect.increments_travel_shifts else b.frame.due
    b.frame = replace(b.frame, trans=trans, due=due)


ACTIONS = {
    "local": _local, "set": _set, "set zero": _set_zero, "set off": _set_off, "set back": _set_back, "data": _data,
    "length": _length, "length words": _length_words, "length more": lambda b, a, w: _length(b, a, w, add=True),
    "length minus": lambda b, a, w: _length(b, a, w, sign=-1), "no length": _no_length, "extended": _extended,
    "trans": _trans, "atrans": lambda b, a, w: _trans(b, a, w, add=True), "no frame": _set_zero,
    "store": _store,
}  # fmt: skip
