"""What is refused, and what is handed on with a reason because it can not be followed.

A reason is kept beside the motion: it matters only where a correction depends on the place.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from postproc.nc import codes
from postproc.nc.batch import Batch
from postproc.nc.columns import hold_last, spread
from postproc.nc.grammar import (
    ABSOLUTE,
    AXES,
    BARE,
    HOMING,
    KEYWORD_LETTER,
    MACRO,
    PARAMETER,
    RELATIVE,
    UNKNOWN_FEED,
)
from postproc.nc.queries import names, tell, words_of
from postproc.nc.state import NONE
from postproc.nc.tips import tip_codes

TOOL_CHANGE = 6
ARC = 20  # ten times G2, the first of the arcs
CYCLE_CALL, TAPPING = 790, 2070  # of Klartext
CENTRES = range(AXES.index("I"), len(AXES))


def drop_arguments(b: Batch) -> None:
    """What stands in a block that calls a macro is handed over to it: no axis, no feed, and I J K
    may stand there ten times. A of a thread in many passes (G76) is the angle of its tool (Haas
    lathe operator's manual, G76; Fanuc B-64304EN-1, the same with the format of series 10/11)."""
    if "G" not in b.places:
        return
    threads = [n for n, code in b.dialect.stays.items() if not code.group]
    _drop(b, b.dialect.calls, [x for x in b.places if x not in "GMNOP"])
    _drop(b, threads, [x for x in b.places if x == "A"])


def _drop(b: Batch, numbers: Sequence[int], letters: list[str]) -> None:
    """Take words with these letters out of blocks with these codes."""
    place = b.places.get("G")
    if place is None or not numbers or not letters:
        return
    # before the codes are read (Batch.read_codes): what is dropped must be seen by nothing else
    number = b.words.mantissa[place] * 10 // 10 ** np.minimum(b.words.decimals[place], 6)
    calls = b.words.block[place[np.isin(number, numbers)]]
    if not len(calls):
        return
    for letter in letters:
        kept = b.places[letter]
        kept = kept[~np.isin(b.words.block[kept], calls)]
        b.places[letter] = kept
    b.places = {letter: kept for letter, kept in b.places.items() if len(kept)}


def _letter(written: str) -> str:
    """The letter of an axis for which a code of the lexer's own stands; "" where it stands for no
    letter."""
    code = ord(written)
    if (
        code in (KEYWORD_LETTER, PARAMETER, MACRO, UNKNOWN_FEED, HOMING)
        or code >= BARE
        or code - RELATIVE in CENTRES
        or code - ABSOLUTE in CENTRES
    ):
        return ""
    # the second half of the byte is the place in AXES: 0x90 is X=IC(), 0xC0 X=AC(), of X both
    if code >= RELATIVE:
        return AXES[code - (ABSOLUTE if code >= ABSOLUTE else RELATIVE)]
    return written


AXES_OF_ANY = "ABCUVWXYZ"


def check_letters(b: Batch) -> None:
    """Refuse letters that mean nothing to the dialect or name an axis that the machine has not."""
    for written in (x for x in b.places if x not in b.control.letters):
        # An unknown letter stops every program, also on a machine without errors: it may name an
        # axis, and nothing could be said of where the tool is.
        letter, place = _letter(written), b.places[written]
        if not letter or letter in b.control.letters:
            continue
        axes = {*AXES_OF_ANY, *b.dialect.carried, *("E" if b.dialect.grammar.assigns else "")}
        if letter in axes:
            raise b.fault(place[0], f"the machine has no axis {letter}", _no_axis(b, letter, place))
        raise b.fault(
            place[0],
            f"the letter {letter} has no meaning in {b.dialect.title}",
            "it could move an axis: use another --dialect, or take it out",
        )
    if (slashed := b.words.slashed) < b.n and slashed <= b.end and not b.state.ended:
        how = (
            "left alone, as with the switch on"
            if b.setup.block_delete
            else "read as executed, as with the switch off"
        )
        said = (
            f"blocks that begin with / are {how}; with the switch the other way the output is "
            "not right (--block-delete on|off)"
        )
        tell(b, "block delete", said, slashed)


def check_second(b: Batch) -> None:
    """Refuse Y on a machine without it where it is not the second coordinate of a face."""
    if b.dialect.polar != "Y" or b.polar or "Y" in b.rows:
        return
    for letter in (x for x in "YV" if x in b.places):
        place = b.places[letter]
        raise b.fault(place[0], f"the machine has no axis {letter}", _no_axis(b, letter, place))


def _no_axis(b: Batch, letter: str, place: np.ndarray) -> str:
    """The way out of a word of an axis that is not there: beside X or Z a lathe's may be a corner
    (C) or the angle of the line (A), which --expand writes out."""
    axes = f"its axes are {' '.join(b.setup.axes)}; choose the right --machine"
    block = b.words.block[place[0]]
    beside = any(np.any(b.words.block[b.places[x]] == block) for x in "XZUW" if x in b.places)
    if not beside or letter not in b.dialect.drawn:
        return axes
    meant = "the angle of a line" if letter == "A" else "a chamfer"
    return f"{axes}; {codes.IF_IT_IS} {meant}: --expand writes it out"


def check_points(b: Batch) -> None:
    """Say once that coordinates without a decimal point mean different things to different
    controls."""
    if b.dialect.tool_offsets and "T" in b.places:
        _refuse_numbers(b)
    if b.dialect.integer_notice:
        place = np.concatenate([words_of(b, letter) for letter in b.rows])
        whole = ~b.words.pointed[place] & (b.words.mantissa[place] != 0)
        bare = place[whole & ~b.taken[b.words.block[place]]]
        if len(bare):
            tell(b, "integer", b.dialect.integer_notice, b.words.block[bare.min()])


def refused_groups(b: Batch) -> None:
    """Fill `reason` wherever a modal code that can not be followed is in force."""
    for group in b.dialect.refusing_groups:
        before = b.state.codes.get(group, NONE)
        if group in b.given:
            column = b.given[group]
            for number in sorted(set(column[column != NONE].tolist())):
                code = b.dialect.by_number[int(number)]
                # G92 X0: its words are coordinates of the place where it stands, no target
                if code.takes:
                    # G43.1 with a motion code in its block shifts by its words and then moves by
                    # them.
                    both = (b.code_word >= 0) & (code.does == "length words")
                    b.taken |= (column == number) & ~both
                    harmless = (column == number) & ~b.has_axis & (number != 100) & (not code.does)
                    column[harmless] = NONE  # G92 S: a speed limit, no position
                    b.filled.pop(group, None)
            held = hold_last(column, before)
            refused = b.dialect.is_refused[np.maximum(held, 0)] & (held >= 0)
            for number in sorted(set(held[refused].tolist())):
                b.reason[held == number] = _in_force(b, int(number))
        elif before >= 0 and b.dialect.is_refused[before]:
            b.reason[:] = _in_force(b, before)


def _in_force(b: Batch, number: int) -> int:
    code = b.dialect.by_number[number]
    return b.because(f"{code.word} ({code.meaning}) is in force", code.refuses)


def m_codes(b: Batch) -> None:
    """M codes that call other text are foreign; unknown ones are passed with a notice."""
    place = b.places.get("M")
    if place is None:
        return
    every = b.numbers(place)  # M201.1 of RepRapFirmware is no M2011
    for number in sorted(set(every.tolist())):
        of = place[every == number]
        of = of[[not b.restarts_at(int(i)) for i in of]] if number in b.dialect.restarts else of
        if not len(of):
            continue
        block = b.words.block[of]
        if number == TOOL_CHANGE:
            _tool_change(b, block)
        if number in b.dialect.m_refuses:
            b.foreign[block] = True
            b.reason[block] = b.because(_called(b, int(number)), b.dialect.m_refuses[int(number)])
        elif number not in b.dialect.m_codes and number not in tip_codes(b.dialect, b.setup):
            said = f"M{number:.12g} is not a code of {b.dialect.title}: passed as it is"
            tell(b, f"M{number:.12g}", said, block[0])


def _tool_change(b: Batch, block: np.ndarray) -> None:
    """Axes that a tool change in some blocks takes away."""
    for letter in b.dialect.change_takes + b.dialect.change_returns:
        b.changed[letter] = np.isin(np.arange(b.n), block) | b.changed.get(letter, False)


def macros(b: Batch) -> None:
    """Text that only the machine has: it may move every axis, so no place is known behind it; what
    shifts the coordinates or brings modes back can not be followed."""
    if b.dialect.tools_move and "T" in b.places:
        b.loses[b.words.block[b.places["T"]]] = True
    if b.dialect.length_letter == "T" and "T" in b.places:
        _tool_change(b, b.words.block[b.places["T"]])
    place = b.places.get(chr(MACRO))
    if place is None:
        return
    # the number of the word, from 1, says which sentence; without a number only the places are lost
    block = b.words.block[place]
    b.loses[block] = b.taken[block] = True
    number = np.where(b.words.number[place] < b.words.stop[place], b.words.mantissa[place], 0)
    for i in np.flatnonzero(number):
        b.foreign[block[i]] = True
        name, why = _name_of(b, int(place[i])), b.dialect.macro_refuses[number[i] - 1]
        b.reason[block[i]] = b.because(f"{name} can not be followed", why)
    if not number.all():
        first = int(place[number == 0][0])
        said = (
            f"{_name_of(b, first)} runs text that only the machine has: it passes, modes are"
            " taken to be behind it what they were, and no axis has a known place until the"
            " program names one"
        )
        tell(b, "macro", said, b.words.block[first])


def cycle_calls(b: Batch) -> None:
    """CYCL CALL of Klartext: what goes by the spindle stays, from the place that is corrected
    before it; other cycles can not be followed."""
    block = b.single.get(CYCLE_CALL)
    if block is None or not b.dialect.grammar.klartext:
        return
    # CYCL DEF becomes a modal code (G200, or G207 of what stays), so that a call knows what it
    # calls
    tapped = spread(b.held("defined cycle"), b.n)[block] == TAPPING
    for i in block[~tapped]:
        b.foreign[i] = True
        b.reason[i] = b.because("CYCL CALL can not be followed", codes.CYCLE)
    if tapped.any():
        said = (
            "cycles that tap, mill threads, or bore and drill by the spindle's angle or speed"
            " stay as they are: their place is corrected at the clearance above the hole, their"
            " depth is not"
        )
        tell(b, "tapping cycle", said, block[tapped][0])


def _name_of(b: Batch, place: int) -> str:
    """The first word of the text that a macro's word stands for; where that begins with its equals
    sign, the word before it."""
    start, text = int(b.words.start[place]), b.words.text
    before = text[text.rfind(b"\n", 0, start) + 1 : start].decode("latin-1").split()[-1:]
    line = text[start : start + 60].decode("latin-1").partition("\n")[0].strip()
    names = line.partition("=")[0].split() or before or ["="]
    return names[0].rstrip(";")


def _called(b: Batch, number: int) -> str:
    calls = b.dialect.m_refuses.get(number) in (codes.CALL, codes.INLINE)
    meaning = codes.CALLS.get(number, "") if calls else b.dialect.m_codes.get(number, "")
    return f"M{number} ({meaning})" if meaning else f"M{number} can not be followed"


def refuse_motions(b: Batch, motion: np.ndarray, moving: np.ndarray) -> None:
    """Motions whose code can not be followed, or that have none. motion (B,): the code in force."""
    if "motion" not in b.given:
        # no code named here, and the one that holds can be followed: there is nothing to look for
        number = b.state.codes.get("motion", NONE)
        if number not in (NONE, 800) and not b.dialect.is_refused[number]:
            return
    refused = b.dialect.is_refused[np.maximum(motion, 0)] & (motion >= 0) & moving
    if "motion" in b.given and not (b.polar and b.dialect.contour):
        given = b.given["motion"]
        refused |= b.dialect.is_refused[np.maximum(given, 0)] & (given >= 0)
    for number in sorted(set(motion[refused].tolist())):
        code = b.dialect.by_number[int(number)]
        b.reason[refused & (motion == number)] = b.because(
            f"{code.word} ({code.meaning})", code.refuses
        )
    # A control that is known to begin in a motion has it as Dialect.motion; of the others it is not
    # known whether they would go in rapid or at a feed.
    bare = moving & ~b.foreign & ~refused & ((motion == NONE) | (motion == 800))
    b.blame(
        bare.nonzero()[0],
        "axis words, but no motion code (G0 G1 G2 G3) is in force",
        "begin the program with the motion code it means",
    )
    b.foreign |= refused | bare


def unnamed_motions(b: Batch, moving: np.ndarray) -> None:
    """Controls on which every block names its motion code do not know a block without."""
    bare = moving & (b.code_word < 0) & ~b.foreign
    b.blame(
        bare.nonzero()[0],
        "axis words without a motion code in the block",
        "this control wants G0 or G1 in every line",
    )


def single_commands(b: Batch) -> None:
    """Firmware that obeys one command a line would pass over the second one."""
    # Refused on every machine, not only where it is corrected: what the output says would not be
    # done.
    commands = np.sort(np.concatenate([words_of(b, x) for x in "GMT"]))
    block = b.words.block[commands]
    twice = (block[1:] == block[:-1]).nonzero()[0]
    if len(twice):
        raise b.fault(
            commands[twice[0] + 1],
            "two commands in one line, and this control obeys only the first",
            "write each in a line of its own",
        )


def idle_letters(b: Batch, motion: np.ndarray, moving: np.ndarray) -> None:
    """Letters that belong to a code (E of M67, of a thread) and stand in a plain motion without
    one."""
    own = b.dialect.offset_letter
    letters = [x for x in b.dialect.letters if x in b.places and x != own]
    if not letters:
        return
    plain = moving & (motion >= 0) & (motion <= 30) & ~names(b, "M")
    for letter in letters:
        place = b.places[letter]
        centre = letter == "J" and "Y" in b.rows  # of an arc, where it is no other parameter
        idle = plain & (motion < ARC) if centre else plain
        place = place[idle[b.words.block[place]]]
        if len(place) and letter in b.dialect.repeats:
            raise b.fault(
                place[0],
                f"{letter} in a motion: the control runs the block several times",
                "write it as often as it runs",
            )
        if len(place):
            raise b.fault(
                place[0], f"the letter {letter} has no meaning in a motion of {b.dialect.title}",
                "it could move an axis: use another --dialect, or take it out",
            )  # fmt: skip


def stray_words(b: Batch, centre_words: dict[str, np.ndarray], straight: np.ndarray) -> None:
    """I J K R in a block that is no arc: round a corner on some controls, an error on others.
    straight (B,) bool."""
    for letter, place in centre_words.items():
        block = b.words.block[place]
        b.blame(
            block[straight[block]],
            f"{letter} in a straight motion",
            (
                "corner rounding, chamfers and angles: --expand writes RND, CHF, CHR and ANG out"
                if b.dialect.grammar.assigns
                else "corner rounding and chamfers: --expand writes them out"
                if b.dialect.tool_offsets and b.dialect.language
                else "corner rounding and chamfers are not followed: write the corner out"
            ),
        )


def refuse_dwells(b: Batch, moving: np.ndarray, centre_words: dict[str, np.ndarray]) -> None:
    """G4 beside an arc: whose words are they?"""
    turning = np.zeros(b.n, bool)
    for place in centre_words.values():
        turning[b.words.block[place]] = True
    both = b.single[40]
    b.blame(
        both[turning[both] & moving[both]],
        "G4 and an arc in one block",
        "write them in blocks of their own",
    )


def _refuse_numbers(b: Batch) -> None:
    """T2W202 in a block of its own: W is the offset's number on lathes that call tools so, and on
    others the slide moves by it; the text does not say which."""
    block = b.words.block
    number = np.isin(np.arange(len(block)), words_of(b, "N"))
    # two words but for N, one of them a T: with more in the block it is a motion
    pair = np.bincount(block[~number], minlength=b.n) == 2
    pair &= np.bincount(block[b.places["T"]], minlength=b.n) == 1
    for letter in (x for x in b.dialect.increments if x in b.places):
        place = b.places[letter]
        bare = place[~b.words.pointed[place] & (b.words.mantissa[place] != 0)]
        b.blame(
            block[bare][pair[block[bare]]],
            f"{letter} without a decimal point alone with T: an offset's number on some lathes",
            "where the slide shall move, write a point; where it is a number, give it as T0202",
        )
