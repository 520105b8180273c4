"""Shifts of the coordinates: G52, G92 and its kin, G10, G43 and its kin, G54.1, TRANS.

Within a segment, which a block that changes a shift begins, every shift is one number per axis.
What a shift depends on and is not stated becomes a reason beside the motions: it matters only where
a correction depends on the place.

NIST RS274/NGC 3.2, 3.5.5-3.5.17; LinuxCNC as measured (tests/linuxcnc/README.md); Fanuc B-63944EN,
"Coordinate system"; Siemens 840D Programming Guide Fundamentals, "Frame instructions".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from postproc.nc import face, planes, presets, spatial, swivel, tips
from postproc.nc.batch import AxisWords, Batch
from postproc.nc.codes import code_number
from postproc.nc.grammar import KEYWORD_LETTER
from postproc.nc.lengths import (
    edge_of,
    left_open,
    length_by,
    length_of,
    length_words,
    lines_of_data,
    no_length,
    set_radius,
    set_tool,
    sign_of_h,
)
from postproc.nc.queries import at_first, lose
from postproc.nc.state import NONE
from postproc.nc.zeros import (
    EXTERNAL,
    ask_for,
    changed,
    chosen,
    goes_on,
    note_presets,
    number_of,
    stated,
    values_of,
    with_known,
)
from postproc.records import replace
from postproc.units import TICKS_PER_MM

WORK_OF_P = ("", "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
EXPAND = "--expand writes the program out in plain coordinates"


# Whole: what shifts coordinates, in the order in which the control lets it hold.
def event(b: Batch, axis_words: AxisWords) -> None:
    """Let the first block of a segment change the shifts, if it does; sets b.frame and
    b.offsets."""
    # only the first block can hold such a code, for it begins a segment (Interpreter._segments)
    first_codes = {int(column[0]) for column in b.given.values()}
    first_codes |= {number for number in b.single if begins_with(b, number)}
    for number, does in b.dialect.frame_codes.items() if first_codes else ():
        if number in first_codes and b.live[0]:
            ACTIONS[does](b, axis_words, b.dialect.by_number[number].word)  # DOES of codes.py
    _edge(b, axis_words)
    chosen(b)
    if b.dialect.extended_by_p and b.given.get("work offset", (NONE,))[0] == 540 and b.live[0]:
        if number_of(b, "P"):
            _extended(b, axis_words, "G54")
        else:  # a plain G54 takes the additional one back
            b.frame = with_known(replace(b.frame, extended=""), "extended")
    tips.switched(b, axis_words)
    tips.settle(b)
    if not b.single:
        return
    for number in _first_codes(b, "plane align"):
        planes.plane_align(b, b.dialect.by_number[number].word)
    for _ in _first_codes(b, "swivel"):
        _swivelled(b)
    for _ in _first_codes(b, "spatial"):
        spatial.turned_in(b)


def _edge(b: Batch, axis_words: AxisWords) -> None:
    """A length by its number alone, where the control has no G43."""
    letter = b.dialect.length_letter
    number = edge_of(b) if letter == "D" else number_of(b, letter)
    if number is not None and (letter != "H" or b.dialect.length_at_once):
        length_by(b, axis_words, letter, int(number))
    elif number is not None and (sign := sign_of_h(b)):
        _length(b, axis_words, "H", sign=sign)


def begins_with(b: Batch, number: int) -> bool:
    """Whether a code without a group stands in the first block."""
    return number in b.single and 0 in b.single[number][:1]


def _first_codes(b: Batch, does: str) -> list[int]:
    """The codes that do this, without a group, of the first block."""
    every = b.dialect.frame_codes.items()
    return [n for n, own in every if own == does and b.live[0] and begins_with(b, n)]


def _local(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G52: a zero within the work offset. LinuxCNC keeps it where it keeps G92's."""
    values = {b.rows[x]: value for x, (value, _) in values_of(b, axis_words).items()}
    if b.dialect.local_is_preset:
        base = b.frame.preset if b.frame.preset_on else np.zeros_like(b.frame.preset)
        frame = replace(b.frame, preset=changed(base, values), preset_on=True)
        b.frame = presets.known_again(frame, [b.setup.axes[row] for row in values])
    else:
        b.frame = replace(b.frame, local=changed(b.frame.local, values))
    planes.shifted_within(b, word)


def _data(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G10: the program writes offsets. L2 a work offset, L20 so that the axes stand at these
    coordinates (Fanuc: an additional work offset), L1 L10 L11 a tool's."""
    line, number = number_of(b, "L"), number_of(b, "P")
    values = values_of(b, axis_words)
    # G10 P0 S200 R150: temperatures of a tool
    if not values and (number_of(b, "R") is None or b.dialect.carried):
        return
    if line is None and b.dialect.tool_offsets and number is not None:
        line = 10.0
    if line not in lines_of_data(b) or number is None or number != int(number) or number < 0:
        b.frame = with_known(
            b.frame,
            "data",
            (
                f"G10 L{line:g} is not followed" if line is not None else "G10 without L",
                "it sets data of the control: set them before the program, and take the block out",
            ),
        )
        return
    p = int(number)
    if line in (12, 13):
        set_radius(b, p, int(line))
        return
    if line in (1, 10, 11):
        set_tool(b, axis_words, p, int(line), values)
        return
    _work_offset(b, axis_words, p, int(line), values)


def _name(b: Batch, p: int, line: int) -> str:
    """The work offset that L2 or L20 with this P writes; "": none."""
    if line == 20 and b.dialect.extended_by_p:
        return f"G54.1 P{p}"
    if p:
        return WORK_OF_P[p] if p < len(WORK_OF_P) else ""
    if b.dialect.extended_by_p:
        return EXTERNAL
    held = at_first(b, "work offset")
    return b.dialect.by_number[held].word if held != NONE else "G54"


# Whole: the forms of G10 L2 and L20, with a refusal to each.
def _work_offset(
    b: Batch, axis_words: AxisWords, p: int, line: int, values: dict[str, tuple[int, bool]]
) -> None:
    by_place = line == 20 and not b.dialect.extended_by_p
    name = _name(b, p, line)
    if not name:
        b.frame = with_known(
            b.frame, "data", (f"G10 P{p} names no work offset", "P1 is G54, P2 is G55 and so on")
        )
        return
    if number_of(b, "R") is not None and not b.dialect.tool_offsets and not b.dialect.extended_by_p:
        b.frame = with_known(b.frame, "data", ("G10 R turns the coordinates", EXPAND))
        return
    also = _named_too(b, name, p)
    old = next((place for x in (name, *also) if (place := stated(b, x)) is not None), None)
    reason, part, frame = None, f"data {name}", b.frame
    every = set(b.setup.axes) & set("XYZ")
    place = dict(old or {})
    incremental = b.dialect.extended_by_p and at_first(b, "distance") == 910
    for letter, (value, is_inc) in values.items():
        row, lost = b.rows[letter], None
        # position = work + shift + coordinate, solved for the work offset
        if by_place:
            if not b.state.known[row]:
                lost = (f"G10 L20 sets {name} from where {letter} stands, and that is not known",
                        f"say where it stands: --start {letter}0")  # fmt: skip
            value = int(b.state.position[row]) - value - int(b.frame.shift[row])
        elif incremental or is_inc:  # Fanuc: under G91 the words are added
            value = value + round(place.get(letter, 0.0) * TICKS_PER_MM)
        place[letter] = value / TICKS_PER_MM
        frame = with_known(frame, f"{part} {letter}", lost)  # of this axis alone
    if by_place:
        note_presets(b, axis_words, values)
    if old is None and (set(values) < every or incremental):  # the rest
        reason = ask_for(b, name, "work")
    elif not every <= set(place):
        reason = frame.unknown.get(part)
    b.offsets = {**b.offsets, **dict.fromkeys((name, *also), place)}
    b.frame = with_known(frame, part, reason)


def _named_too(b: Batch, name: str, p: int) -> tuple[str, ...]:
    """Haas: G110 to G129 are G154 P1 to P20 (96-8210, "G110-G129", "G154")."""
    code = b.dialect.by_number.get((109 + p) * 10)
    own = name.startswith("G54.1") and code is not None and code.group == "work offset"
    return (code.word,) if own and code is not None else ()


def _turned(b: Batch, axis_words: AxisWords, word: str) -> None:
    """ROT SCALE MIRROR of Siemens: alone they take the whole programmable frame back, with words
    they turn or scale it."""
    low, high = np.searchsorted(b.words.block, [0, 1])
    bare = not any(b.words.letter[k] not in (ord("N"), KEYWORD_LETTER) for k in range(low, high))
    if bare:
        reason = None
    else:
        reason = (
            f"{word} turns, scales or mirrors the coordinates",
            b.dialect.by_number[code_number(word)].refuses,
        )
    if word in ("ROT", "SCALE", "MIRROR", "ROTS"):
        b.frame = replace(b.frame, trans=np.zeros_like(b.frame.trans), added=False)
    b.frame = with_known(b.frame, "turned", reason)


def _store(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G28.1: the place where the machine stands becomes the reference point. It stands beside the
    nominal place by the correction, so from here on it is unknown where G28 goes, to the last
    micrometre."""
    b.offsets = {**b.offsets, word.split(".")[0]: {}}  # a place not known


def _extended(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G54.1 P, G15 H of Okuma: one of many work offsets."""
    name = b.dialect.extended_name
    letter, code = name[-1], name[:-2]
    number = number_of(b, letter)
    if number is None or number != int(number) or number < 1:
        reason = (f"{code} without a whole {letter}", f"{letter}1 to {letter}300 choose the offset")
        b.frame = with_known(b.frame, "extended", reason)
        return
    b.frame = with_known(replace(b.frame, extended=f"{name}{int(number)}"), "extended")


def _numbered(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G59 of Mach3: with P one of 254 work offsets, which no --offset names."""
    number = number_of(b, "P")
    if number is None or number == 6:
        b.frame = with_known(b.frame, "numbered")
        return
    reason = (
        f"G59 P{number:g} is one of the control's further work offsets",
        "write the program in G54 to G59",
    )
    b.frame = with_known(b.frame, "numbered", reason)


def _trans(b: Batch, axis_words: AxisWords, word: str, add: bool = False) -> None:
    """TRANS: the shift is replaced, of axes that are not named by none; ATRANS adds."""
    start = b.frame.trans if add else np.zeros_like(b.frame.trans)
    values = {
        b.rows[x]: int(start[b.rows[x]]) + value
        for x, (value, _) in values_of(b, axis_words).items()
    }
    frame = replace(b.frame, trans=changed(start, values))
    if add:
        b.frame = replace(frame, added=frame.added or bool(values))
    else:
        b.frame = with_known(replace(frame, added=False), "turned")


def _axis_shift(b: Batch, axis_words: AxisWords, word: str, add: bool = False) -> None:
    """G58, G59 of Siemens: of the shift of the axes that are named, G58 replaces what TRANS gave,
    G59 what ATRANS added; the two are told apart as long as nothing was added ("Axial work offset",
    NC programming manual)."""
    if b.frame.added:
        reason = (
            f"{word} behind a shift that was added: which part of it {word} replaces is not told"
            " apart",
            "write TRANS and ATRANS",
        )
        b.frame = with_known(b.frame, "turned", reason)
        return
    values = {
        b.rows[x]: value + (int(b.frame.trans[b.rows[x]]) if add else 0)
        for x, (value, _) in values_of(b, axis_words).items()
    }
    b.frame = replace(b.frame, trans=changed(b.frame.trans, values), added=add)


def _swivelled(b: Batch) -> None:
    """CYCLE800 turns the rotary axes itself."""
    if swivel.retracts(b):
        lose(b, "XYZ")
    if does := swivel.direction(b):
        planes.plane_align(b, swivel.WORD, does)


def _length(
    b: Batch, axis_words: AxisWords, word: str, then: Callable[..., None] = length_of, **how: Any
) -> None:
    """A length, or none; where one code of the group calls the tool point, it takes that back."""
    before, tip = b.frame.length, b.frame.tip
    if "tip" in b.dialect.frame_codes.values():
        tips.tip_off(b, axis_words, word)
    then(b, axis_words, word, **how)
    if tip is None:
        left_open(b, axis_words, before)


ACTIONS = {
    "local": _local,
    "datum shift": lambda b, a, w: None if goes_on(b, w) else _local(b, a, w),
    "set": presets.set_place,
    "set or off": presets.set_or_off,
    "set or all": presets.set_or_all,
    "set zero": presets.set_zero,
    "set off": presets.set_off,
    "set back": presets.set_back,
    "data": _data,
    "length": _length,
    "length by tool": lambda b, a, w: _length(b, a, w, bare="tool"),
    "length or none": lambda b, a, w: _length(b, a, w, bare="none"),
    "length words": length_words,
    "length more": lambda b, a, w: length_of(b, a, w, add=True, bare="tool"),
    "length minus": lambda b, a, w: _length(b, a, w, sign=-1),
    "no length": lambda b, a, w: _length(b, a, w, then=no_length),
    "extended": _extended,
    "fixture": chosen,
    "numbered": _numbered,
    "tip": tips.tip_by_length,
    "tip on": tips.tip_on,
    "tip off": tips.tip_off,
    "plane": planes.plane_on,
    "plane off": planes.plane_off,
    "plane align": lambda b, a, w: None,  # behind the rest
    "swivel": swivel.swivel,
    "spatial": spatial.spatial,
    "polar on": face.polar_on,
    "polar off": face.polar_off,
    "trans": _trans,
    "atrans": lambda b, a, w: _trans(b, a, w, add=True),
    "axis shift": _axis_shift,
    "further axis shift": lambda b, a, w: _axis_shift(b, a, w, add=True),
    "no frame": presets.set_zero,
    "store": _store,
    "frame": _turned,
}
