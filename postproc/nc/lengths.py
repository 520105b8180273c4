"""Tool lengths: G43 and its kin, D and T where they act at once, and G10 where it writes them.

     slide  o-----  = coordinate + work offset and other shifts + length      (G44: - length)
            |
            | length: of a mill along Z, of a turning tool X and Z
            |
       tip  v-----  = coordinate + work offset and other shifts

The slide is what motions tell of, for its place is what the machine's tables are about. A length
moves nothing by itself: it says where the next word leads, but where a control travels it at once.
"""

from __future__ import annotations

import numpy as np

from postproc.nc.batch import AxisWords, Batch
from postproc.nc.queries import at_first, tell, unit_at_first, words_of
from postproc.nc.state import NONE, UNSAID, ticks_of
from postproc.nc.zeros import (
    changed,
    note_presets,
    number_of,
    stated,
    stated_tool,
    values_of,
    with_known,
    work_columns,
)
from postproc.records import replace
from postproc.units import TICKS_PER_MM

KEPT = (
    "G43 without H takes the offset number that the control has kept, and which that is is not"
    " known",
    "write G43 H with its number",
)
UNNAMED = (
    "G43 without H takes the length of the tool in the spindle, and which that is is not known",
    "write the tool's number with T and M6 before it, or G43 H with its number",
)
IN_MACHINE = (
    "SUPA, G53 or G153 with a tool length in force: whether the slide or the tool's tip goes to the"
    " place is a setting (MD10760), so where the axis stands then is not known: write D0 beside it"
)


def set_tool(
    b: Batch, axis_words: AxisWords, p: int, line: int, values: dict[str, tuple[int, bool]]
) -> None:
    """G10 L1 L10 L11 P: the offsets of a tool; what G43 has in force stays until the next G43."""
    if b.dialect.tool_offsets:
        b.frame = with_known(
            b.frame,
            "data",
            (
                "G10 sets a tool offset",
                "state the tool offsets with --offset T0101=X..,Z.., and take the block out",
            ),
        )
        return
    name = f"H{p}"
    radius = number_of(b, "R")
    if not values and b.dialect.extended_by_p and radius is not None and line in (10, 11):
        values = {"Z": (round(radius * unit_at_first(b)), False)} if "Z" in b.rows else {}
    # what the block does not name of the tool stays as it was stated
    place = dict(stated_tool(b, "H", p) or {})
    if radius is not None:  # LinuxCNC: of the tool
        place["R"] = radius * unit_at_first(b) / TICKS_PER_MM
    by_place = line in (10, 11) and not b.dialect.extended_by_p
    if by_place:
        note_presets(b, axis_words, values)
    for letter, (value, _) in values.items():
        if by_place:
            value = _length_here(b, b.rows[letter], value, line)
        place[letter] = value / TICKS_PER_MM
    b.offsets = {**b.offsets, name: place}


def _length_here(b: Batch, row: int, value: int, line: int) -> int:
    """Ticks of a length with which the axis stands at the coordinate `value`: L10 in the work
    offset in force, L11 in G59.3 without G92."""
    # coordinate = position - base - length, solved for the length; `shift` has the length in force
    if line == 10:
        base = work_columns(b)[row, 0] + b.frame.shift[row] - b.frame.length[row]
    else:
        base = ticks_of(b.setup, stated(b, "G59.3") or {})[row]
    return int(b.state.position[row]) - value - int(base)


def lines_of_data(b: Batch) -> tuple[int, ...]:
    """The L of G10 that are followed: 12 and 13 are a cutter's radius and its wear (Fanuc mills
    B-64304EN-2, "Tool compensation values", G10; Haas 96-8210, "G10")."""
    mill = b.dialect.extended_by_p and not b.dialect.tool_offsets
    return (1, 2, 10, 11, 20, *((12, 13) if mill else ()))


def set_radius(b: Batch, p: int, line: int) -> None:
    """G10 L12 L13 P R: the radius of D. Whether R is a radius or a diameter (parameter 5004#2,
    Haas setting 40), and the other part of the sum, the program does not say. So the radius that
    is stated holds where R of L12 is that or twice that, or L13 takes the wear away; else it is
    not known."""
    place, value = stated_tool(b, "D", p), number_of(b, "R")
    if value is None:
        return
    unit = unit_at_first(b) / TICKS_PER_MM
    adds = line == 13 or at_first(b, "distance") == 910
    # nan where nothing is stated: it is close to no number
    expected = [0.0] if adds else [k * (place or {}).get("R", np.nan) for k in (1, 2)]
    if not np.isclose(value * unit, expected, rtol=0, atol=1e-6).any():
        b.offsets = {**b.offsets, f"D{p}": {}}


def _not_stated(number: int) -> tuple[str, str]:
    return (
        f"the tool length H{number} is not stated",
        f"say it in mm: --offset H{number}=Z0 or --offsets FILE with the control's tool table",
    )


def length_of(
    b: Batch, axis_words: AxisWords, word: str, sign: int = 1, add: bool = False, bare: str = ""
) -> None:
    """G43 H: the tool's length shifts the coordinates; H0 is no length (Fanuc B-64304EN-2: "the
    offset value of H0 is always 0"; Haas likewise).

    bare: what G43 without H takes: "tool": as with H0 the length of the tool in the spindle
    (LinuxCNC as measured; grblHAL, gcode.c, ToolLengthOffset_Enable); "none": no length, "omitting
    H has the same effect as a zero value" (Using Mach3Mill, G43); "": the number kept by H."""
    number = _number(b, add, bare)
    if _units_changed(b):
        return
    place = stated_tool(b, "H", int(number)) if number >= 0 else None
    if number == 0 and (place is None or bare != "tool"):
        place = {}
    # (A,) of all axes: a mill's table has Z alone, a turning tool's X and Z
    length = None if place is None else sign * ticks_of(b.setup, place)
    if length is None:
        unnamed = UNNAMED if bare == "tool" else KEPT
        b.frame = with_known(b.frame, "length", _not_stated(int(number)) if number > 0 else unnamed)
        return
    if add and "length" in b.frame.unknown:
        return  # a further length upon one that is not known
    units = at_first(b, "units")
    length = b.frame.length + length if add else length
    b.frame = with_known(replace(b.frame, length=length, length_units=units, lapsed=()), "length")


def left_open(b: Batch, axis_words: AxisWords, before: np.ndarray) -> None:
    """Forget where the axes stand whose length is another one than before, unless the block says
    their place. Fanuc adds the length to the end of the block "regardless of whether the absolute
    or incremental mode is selected", and moves the axis where the block does not name it, or shifts
    the coordinates under a distance that stays as written (parameter 5006#6 TOS; B-64304EN-2,
    "Tool length compensation", "Shift types"): which, the program does not say. LinuxCNC moves
    nothing, as measured."""
    # the same length again leaves every axis where it stands
    changes = b.frame.length != before
    if not b.dialect.length_left_open or b.frame.space is not None or not changes.any():
        return
    if at_first(b, "distance") != 910:
        named = (x for x, (_, is_inc) in values_of(b, axis_words).items() if not is_inc)
        changes[[b.rows[x] for x in named]] = False
    b.state = replace(b.state, known=b.state.known & ~changes)


def sign_of_h(b: Batch) -> int:
    """1 or -1 where H stands by itself, while G43 or G44 is in force, and so names another length;
    0 where it does not. Fanuc 0i-MB B-63844EN, 14.1.2 ("independent specification of the H
    command"; H0 is no length); Centroid M-series operator's manual 11-2 ("H is modal"). Haas was
    not seen: H works with G43 there as on a Fanuc."""
    if not b.dialect.length_modal or not b.live[0]:
        return 0
    if b.given.get("tool length", (NONE,))[0] != NONE:
        return 0
    return {430: 1, 440: -1}.get(at_first(b, "tool length"), 0)


def may_lapse(b: Batch) -> bool:
    """Whether this control takes lengths back behind G28, G30 or G53, or may do so."""
    return bool(b.dialect.length_lapses) or b.dialect.length_in_machine


def lapses(b: Batch, letter: str, away: np.ndarray, by: np.ndarray) -> np.ndarray:
    """(B,) bool: blocks that send an axis away and take its length back. `away` (B,): blocks of
    G28 and G30 that do send it away; `by`: blocks whose words are absolute places of it.

    Where it stands there in the program's coordinates, no word may say: "When G53, G28, or G30 is
    specified in tool length offset mode, tool length offset vectors are canceled" (Fanuc 0i-MB
    B-63844EN, 14.1.2; whether the next block or the next H puts them back is parameter 5001#6 EVO,
    which the program does not say). "G28 cancels tool length offsets for the following lines of
    code" (Haas 96-8000, G28)."""
    codes, frame, row = b.dialect.length_lapses, b.frame, b.rows[letter]
    gone = np.zeros(b.n, bool)
    if b.dialect.length_in_machine and frame.length[row]:
        # SUPA Z0 with D1: the slide goes to 0, or the tool's tip does (MD10760 $MN_G53_TOOLCORR)
        gone[by] = b.machine[by]
        if gone.any():
            tell(b, "machine length", IN_MACHINE, int(gone.argmax()))
        return gone
    if not codes or not frame.length[row] or frame.space is not None:
        return gone
    for number in (280, 300):
        if number in codes and number in b.single:
            gone[b.single[number]] = away[b.single[number]]
    if 530 in codes:
        gone[by[b.machine[by]]] = True
    # above 0 from the block of the G28 on, up to the next G43, which begins a segment and clears
    # lapsed
    since = gone.cumsum() + (letter in frame.lapsed)
    b.blame(
        by[(since[by] > 0) & ~b.machine[by] & ~gone[by]],
        f"{letter} behind a G28, G30 or G53 that has taken back its tool length",
        "whether the length holds here, the program does not say: write G43 H with its number"
        " again, or G49",
    )
    if gone.any() and letter not in frame.lapsed:
        b.frame = replace(frame, lapsed=(*frame.lapsed, letter))
    return gone


def _number(b: Batch, add: bool, bare: str) -> float:
    """The number whose length G43 takes; -1: no tool has it, as before any M6."""
    number = number_of(b, "H")
    if number is None:
        return {"tool": float(_tool_in_spindle(b)), "none": 0.0}.get(bare, -1.0)
    return _of_h0(b, add) if number == 0 and bare == "tool" else number


def _of_h0(b: Batch, add: bool) -> float:
    """The tool whose length H0 of LinuxCNC and grblHAL takes: the one in the spindle (G43.2: before
    the block's own M6, as measured); before any M6 none, which is said."""
    number = b.state.tool_number if add else _tool_in_spindle(b)
    if number >= 0:
        return float(number)
    if stated_tool(b, "H", 0) is None:
        said = (
            "G43 H0 takes the length of the tool in the spindle, and no M6 says which that is: "
            "taken as no length; else --offset H0=Z.. in mm"
        )
        tell(b, "H0", said, 0)
    return 0.0


def _changes(b: Batch) -> bool:
    """Whether the first block has M6."""
    change = words_of(b, "M")
    return bool((b.words.block[change[b.words.mantissa[change] == 6]] == 0).any())


def _tool_in_spindle(b: Batch) -> int:
    """The tool that the first block's M6 brings, or that is there already."""
    called = number_of(b, "T")
    if _changes(b):
        return int(called) if called is not None else b.state.next_tool
    return b.state.tool_number


def edge_of(b: Batch) -> int | None:
    """The edge (D) that the first block brings into force, None: none. Sets `tool`, `offset` and
    `waits` of b.beside.

    T brings a tool with the edge beside it, or its first one (MD20270 as delivered). Where M6
    changes tools (MD22550) T only makes the next one ready, and D stays an edge of the tool in use
    (Sinumerik W1, 6FC5397-0BP10-2BA0, 2.1.1 and 2.2.5): the program says so by its first M6. That
    the D beside such a T waits with it is said of Fagor's 8055 (NXTOD, 13.2.2 of its programming
    manual), and read so of Sinumerik.
    """
    tool, d, changes, held = number_of(b, "T"), number_of(b, "D"), _changes(b), b.beside
    if tool is not None and d is None:
        d = min(tool, 1)
    if changes:
        held = replace(held, by_m6=True)
        if tool is None and held.waits != NONE:
            tool, d = b.state.next_tool, held.waits if d is None else d
    elif tool is not None and held.by_m6:
        b.beside = replace(held, waits=int(d or 0))
        return None
    if tool is not None:
        held = replace(held, tool=int(tool), waits=NONE)
    b.beside = held if d is None else replace(held, offset=int(d))
    return None if d is None else int(d)


def _units_changed(b: Batch) -> bool:
    """LinuxCNC keeps the number of a length when G20 or G21 changes its unit, and so thinks that it
    stands elsewhere when the length changes next: the next motion goes astray, as measured."""
    if not b.dialect.local_is_preset or not b.frame.length.any():
        return False
    units = at_first(b, "units")
    if units == b.frame.length_units:
        return False
    reason = (
        "the tool length changes in other units than it was set in",
        "this control then takes every axis to a wrong place: write G49 before G20 or G21",
    )
    b.frame = with_known(b.frame, "units", reason)
    return True


def length_by(b: Batch, axis_words: AxisWords, letter: str, number: int) -> None:
    """D of Siemens, T elsewhere: the number names the length, which holds at once; 0 is none, and
    so is less. The next increment of an axis travels a length that has changed, or not (Siemens
    SD42442)."""
    name = f"{letter}{number}"
    place = stated_tool(b, letter, number) if number > 0 else {}  # T-1: no tool at all
    reason = None
    if place is None and b.dialect.homes:
        said = (
            f"{name}: no offset is stated for it, and it is taken as none, as with one nozzle; "
            f"else --offset {name}=X..,Y..,Z.. in mm"
        )
        tell(b, name, said, 0)
    elif place is None:
        reason = (
            f"the tool length {name} is not stated",
            f"say it in mm: --offset {name}=Z0, or --offsets FILE with the control's tool table",
        )
    # Where the slides stand does not change by it, only the zero of the next words does; of that
    # zero `zeros` keeps what the next increment may travel (positions.py, _due_of).
    before, length = b.frame.length, ticks_of(b.setup, place or {}) + _delta(b)
    zeros = b.frame.zeros
    if b.frame.space is not None:  # increments of the tool tip do not travel it
        zeros = np.where(zeros == UNSAID, zeros, zeros + length - before)
    b.frame = with_known(replace(b.frame, length=length, zeros=zeros), "length", reason)
    left_open(b, axis_words, before)


def _delta(b: Batch) -> np.ndarray | int:
    """(A,) ticks by which DL of a TOOL CALL (read as Q) makes the tool longer than its table says,
    along Z."""
    more = number_of(b, "Q") if b.dialect.grammar.klartext else None
    if more is None or "Z" not in b.rows:
        return 0
    unit = unit_at_first(b)
    return np.array([round(more * unit) if x == "Z" else 0 for x in b.setup.axes], np.int64)


def length_words(b: Batch, axis_words: AxisWords, word: str) -> None:
    """G43.1: the words are the offset; axes without a word keep theirs."""
    values = {b.rows[x]: value for x, (value, _) in values_of(b, axis_words).items()}
    if values and b.code_word[0] >= 0:
        b.blame(
            np.zeros(1, np.int64),
            f"{word} and a motion code in one block: its words are the length and the target too",
            "write the motion in a block of its own",
        )
    if _units_changed(b):
        return
    units = at_first(b, "units")
    b.frame = with_known(
        replace(b.frame, length=changed(b.frame.length, values), length_units=units), "length"
    )


def no_length(b: Batch, axis_words: AxisWords, word: str) -> None:
    if not _units_changed(b):
        none = np.zeros_like(b.frame.length)
        b.frame = with_known(replace(b.frame, length=none, lapsed=()), "length")
