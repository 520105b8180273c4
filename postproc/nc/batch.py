"""The words of one batch by letter, and its modal groups as columns over its blocks."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from postproc.errors import BlockFault, Notice
from postproc.flags import any_of
from postproc.motions import no_presets
from postproc.nc import codes, faults
from postproc.nc.coded import Coded, written_codes
from postproc.nc.columns import hold_last
from postproc.nc.control import Control
from postproc.nc.dialects import NO_GROUP, UNKNOWN
from postproc.nc.grammar import HOMING, KEYWORD_LETTER
from postproc.nc.lexer import POWERS, Words
from postproc.nc.state import NONE, InCycle, ModalState, no_frame
from postproc.units import LARGEST_WORD_MM, TICKS_PER_INCH, TICKS_PER_MM

LINEAR = "XYZUVW"
ANY = bytes(range(256))
LETTERS = [np.array(c, np.uint8) for c in ANY]  # without axes: postproc.units
# not a group of the tables: the last of G0 to G3, which a canned cycle leaves as it is
UNDER = "under cycles"
# ticks, and decimals that are exact in ticks; without axes: postproc.units
LARGEST_WORD, EXACT = np.array(int(LARGEST_WORD_MM) * TICKS_PER_MM), np.array(9)
AxisWords = dict[str, tuple[np.ndarray, np.ndarray]]  # axis to its words, its incremental words
NO_WORDS = np.zeros(0, np.int64)
NO_WORDS.flags.writeable = False
DIAM90 = codes.code_number("DIAM90")  # X is a diameter under G90, a radius under G91


@lru_cache
def _scales(inch: bool, least: float) -> tuple[np.int64, np.int64]:
    """Ticks of one unit and of one least increment (mm)."""
    if inch:  # a control with 0.0001 mm has 0.00001 inch
        return np.int64(TICKS_PER_INCH), np.int64(round(least / 10 * TICKS_PER_INCH))
    return np.int64(TICKS_PER_MM), np.int64(round(least * TICKS_PER_MM))


@lru_cache
def _last_digit(scale: int) -> tuple[np.ndarray, np.ndarray]:
    """(10,) ticks of the last digit of a word with 0 to 9 decimals, `scale` ticks a unit, and (10,)
    the largest of all its digits as one number."""
    digit = scale // POWERS[:10]
    return digit, LARGEST_WORD // np.maximum(digit, 1)


class Batch:
    """The columns of one batch while they are worked out."""

    def __init__(
        self, control: Control, words: Words, state: ModalState, coded: Coded | None = None
    ):
        """coded: the words of all codes and what `written_codes` says of them, if that is known."""
        self.coded = coded
        self.dialect, self.setup, self.rows = control.dialect, control.setup, control.rows
        self.control, self.words, self.state = control, words, state
        self.notices: list[Notice] = []
        self.reasons: list[tuple[str, str]] = [("", "")]
        self.n = words.blocks
        # deleted twice: in order, and faster than a set of all letters
        present = ANY.translate(None, ANY.translate(None, words.letter.tobytes()))
        # letter to its words
        self.places = {chr(c): (words.letter == LETTERS[c]).nonzero()[0] for c in present}
        self.ended = state.ended
        self.end = self.n  # the block that ends the program, the number of blocks where none does
        self.live = self._live()
        self.given: dict[str, np.ndarray] = {}  # modal group to (B,) codes, NONE where not named
        self.filled: dict[str, np.ndarray] = {}  # the same without gaps, once they were asked for
        self.single: dict[int, np.ndarray] = {}  # code without a group to its blocks
        self.code_word = np.full(self.n, -1, np.int64)  # (B,) word of the motion code
        self.reason = np.zeros(self.n, np.int64)  # (B,) index into reasons
        self.has_axis = np.zeros(self.n, bool)  # (B,) names an axis
        self.taken = np.zeros(self.n, bool)  # (B,) its axis words are no motion
        self.loses = np.zeros(self.n, bool)  # (B,) sends axes to places that are not known
        self.gone: dict[str, np.ndarray] = {}  # (B,) the same of single axes
        self.changed: dict[str, np.ndarray] = {}  # (B,) a tool change moves an axis
        self.foreign = np.zeros(self.n, bool)  # (B,) moves, or may, in a way that is not followed
        self.machine = np.zeros(self.n, bool)  # (B,) G53
        # (A, B) or (A, 1) ticks, zero of absolute words
        self.offset = np.zeros((len(self.rows), 1), np.int64)
        self.tool, self.feed, self.renamed = state.tool, state.feed, state.renamed
        self.feed_words = NO_WORDS  # the words that say an F
        self.tool_after, self.next_tool = state.tool, state.next_tool
        self.beside = state.beside
        # block and number of tools that no table states
        self.beside_missing: list[tuple[int, int]] = []
        self.cycle: InCycle | None = None
        self.loose: tuple[str, ...] = ()
        self.as_written = np.zeros(self.n, bool)  # (B,) moves from a place that is not certain
        self.presets = no_presets()
        self.zero_known = True
        self.condition = int(state.codes.get("condition", NONE))
        self.axes: Any = None  # what has read its axis words (positions.py), if anything has
        self.polar = ""  # letter of the second coordinate of polar interpolation (face.py)
        self.integers = self.setup.integers or self.dialect.integers
        self.frame, self.offsets = state.frame or no_frame(len(self.rows)), state.offsets

    def fault(self, word: int, message: str, advice: str = "") -> BlockFault:
        w = self.words
        return BlockFault(
            int(w.block[word]), message, advice, int(w.start[word]), int(w.stop[word])
        )

    def _is_end(self, place: int) -> bool:
        """Whether the program ends with this M word."""
        w = self.words
        if w.decimals[place] != 0:
            return False
        if w.mantissa[place] in self.dialect.ends:
            return True
        return self.restarts_at(place) and not w.skip[w.block[place]]

    def _live(self) -> np.ndarray:
        """(B,) bool: blocks that the control reads; none after the end of the program, none that
        block delete drops."""
        w, live = self.words, np.empty(self.n, bool)
        live.fill(True)
        if self.setup.block_delete:
            live &= ~w.skip
        if self.ended:
            live[:] = False
        elif not self.setup.block_delete and "M" not in self.places:
            return live
        for place in self.places.get("M", ())[:] if not self.ended else ():
            if self._is_end(place) and live[w.block[place]]:
                live[w.block[place] + 1 :] = False
                self.ended, self.end = True, int(w.block[place])
                self._tell_behind(w.block[place])
                break
        if np.count_nonzero(live) < self.n:
            self.places = {letter: p[live[w.block[p]]] for letter, p in self.places.items()}
            self.places = {letter: p for letter, p in self.places.items() if len(p)}
        return live

    def _tell_behind(self, end: int) -> None:
        """Say that axes are named behind the end, where that is not the end for a sender."""
        named = [self.places[x] for x in self.rows if x in self.places]
        block = np.concatenate([NO_WORDS, *(self.words.block[place] for place in named)])
        if self.dialect.homes and (block > end).any():
            line = int(self.words.line[block[block > end].min()])
            self.notices.append(Notice("behind", faults.BEHIND_END, line))

    def restarts_at(self, place: int) -> bool:
        """Whether an M word takes the control back to the first block (M99 without P)."""
        w = self.words
        p = self.places.get("P", NO_WORDS)
        return w.mantissa[place] in self.dialect.restarts and w.block[place] not in w.block[p]

    def once(self, letter: str) -> np.ndarray:
        """Word indices of a letter that may stand once in a block, or of which the last holds."""
        place: np.ndarray = self.places.get(letter, NO_WORDS)
        if len(place) < 2:
            return place
        block = self.words.block[place]
        twice = (block[1:] == block[:-1]).nonzero()[0]
        if len(twice) and letter in self.dialect.last_holds:
            return np.delete(place, twice)
        if len(twice):
            raise self.fault(
                place[twice[0] + 1],
                f"two {letter} words in one block",
                "which one the control obeys differs: keep one",
            )
        return place

    def one_of(self, *letters: str) -> np.ndarray:
        """Word indices of letters of which one may stand once in a block."""
        some = [self.once(letter) for letter in letters if letter in self.places]
        if len(some) < 2:
            return some[0] if some else NO_WORDS
        place = np.sort(np.concatenate(some))
        block = self.words.block[place]
        twice = (block[1:] == block[:-1]).nonzero()[0]
        if len(twice):
            raise self.fault(
                place[twice[0] + 1], f"two words for {letters[0]} in one block", "keep one"
            )
        return place

    def numbers(self, place: np.ndarray) -> np.ndarray:
        """(n,) float64 values of words."""
        value: np.ndarray = self.words.mantissa[place] / 10.0 ** self.words.decimals[place]
        return value

    def ticks(self, place: np.ndarray, scale: Any) -> np.ndarray:
        """(n,) int64 words in ticks; `scale` ticks a unit. Exact to nine decimals, rounded to the
        tick beyond."""
        mantissa, decimals = self.words.mantissa[place], self.words.decimals[place]
        # one unit for all: look the ticks of a last digit up by the number of decimals
        if scale.size == 1:
            digit, largest = _last_digit(scale.item())
            per, most = (table.take(decimals, mode="clip") for table in (digit, largest))
        else:
            per = scale // POWERS[np.minimum(decimals, 9)]  # beyond nine: below, one by one
            most = LARGEST_WORD // np.maximum(per, 1)
        far, fine = np.abs(mantissa) > most, decimals > EXACT
        for word in place[far & ~fine] if any_of(far) else ():
            text = self.words.text[self.words.start[word] : self.words.stop[word]]
            raise self.fault(
                word,
                f"{text.decode('ascii', 'replace')} is beyond {LARGEST_WORD_MM:g} mm",
                "is a decimal point missing?",
            )
        value: np.ndarray = mantissa * per
        for i in fine.nonzero()[0] if any_of(fine) else ():
            # a tick has no whole share in such a digit: Python's numbers of any size, half a tick
            # goes up
            over = 10 ** int(decimals[i])
            unit = int(scale.ravel()[0] if scale.size == 1 else scale[i])
            value[i] = (2 * int(mantissa[i]) * unit + over) // (2 * over)
        return value

    def _no_code(self, place: int) -> BlockFault:
        """What is said of a G word that the dialect has not."""
        w = self.words
        text = w.text[w.start[place] : w.stop[place]].decode("ascii", "replace")
        return self.fault(
            place,
            f"{text} is not a code of {self.dialect.title}",
            "it could move an axis: use another --dialect, or take it out",
        )

    def _end_cycles(self, cancels: np.ndarray) -> None:
        """G0 to G3, and G80 of any group, in the blocks `cancels`, end a cycle of a group of its
        own."""
        cycle = self.given.setdefault("cycle", np.full(self.n, NONE, np.int64))
        ends = self.given.get("motion", np.full(self.n, NONE)) != NONE
        ends[cancels] = True
        cycle[ends & (cycle == NONE)] = 800

    def read_codes(self) -> None:
        """Sort the G words into their modal groups: `given` maps a group to a (B,) column, NONE
        where not named."""
        place = self.places.get("G", NO_WORDS)
        keyword = self.places.get(chr(KEYWORD_LETTER))
        if keyword is not None:
            place = np.sort(np.concatenate([place, keyword]))
        if not len(place):
            if self.dialect.carried:
                self._carried_mode()
            return
        w = self.words
        number = written_codes(w, place, self.coded)
        valid, number = number >= 0, self.dialect.meant[np.maximum(number, 0)]
        group = np.where(valid, self.dialect.group_of[number], UNKNOWN)
        bad = (group == UNKNOWN).nonzero()[0]
        if len(bad):
            raise self._no_code(place[bad[0]])
        block = w.block[place]
        was = number  # before G80 becomes the code that holds behind it
        for g in (np.bincount(group[group >= 0], minlength=len(self.dialect.groups))).nonzero()[0]:
            name, of = self.dialect.groups[g], group == g
            if name == "motion":
                if any_of(number == 800):
                    others = np.bincount(block[of & (number != 800)], minlength=self.n)
                    of &= (number != 800) | (others[block] == 0)  # G80 G1: G1 holds
                number = self._back_from_cycles(number, block, of)
            column, named = np.full(self.n, NONE, np.int64), block[of]
            column[named] = number[of]
            self.given[name] = column
            twice = (named[1:] == named[:-1]).nonzero()[0]
            if len(twice) and self.dialect.one_code_per_group:
                raise self.fault(
                    place[of][twice[0] + 1],
                    f"two codes of the modal group '{name}' in one block",
                    "keep one",
                )
            if name == "motion":
                # G80 names no other code
                written = of & (was == number)
                self.code_word[block[written]] = place[written]
            elif name == "cycle":
                tap = of & self.dialect.is_hole[np.maximum(number, 0)]
                self.code_word[block[tap]] = place[tap]
        if "cycle" in self.dialect.groups:
            self._end_cycles(block[was == 800])
        for code in sorted(set(number[group == NO_GROUP].tolist())):
            self.single[int(code)] = block[number == code]
        if self.dialect.carried:
            self._carried_mode()

    def _back_from_cycles(
        self, number: np.ndarray, block: np.ndarray, of: np.ndarray
    ) -> np.ndarray:
        """(K,) the numbers, G80 as the code of G0 to G3 that holds behind it, on controls that have
        cycles in a group of their own: "group 01 G codes are not affected by a canned cycle" (Fanuc
        B-64304EN-2, "Canned cycle for drilling")."""
        if self.dialect.language != "fanuc":
            return number
        plain = of & np.isin(number, (0, 10, 20, 30))
        column = np.full(self.n, NONE, np.int64)
        column[block[plain]] = number[plain]
        self.given[UNDER] = column
        under = hold_last(column, self.state.codes.get(UNDER, self.dialect.motion))[block]
        return np.where(of & (number == 800) & (under != NONE), under, number)

    def read_homing(self) -> None:
        """$H of GRBL takes all axes where homing takes them: like G28, unless that has a place of
        its own."""
        place = self.places.get(chr(HOMING))
        if place is None:
            return
        block = self.words.block[place]
        if "G28" in self.offsets or "G28" in self.setup.offsets:
            self.loses[block] = self.taken[block] = True
            return
        self.single[280] = np.sort(np.concatenate([self.single.get(280, NO_WORDS), block]))

    def _carried_mode(self) -> None:
        """Whether words of carried axes are absolute (900) or increments (910): M82 M83, and G90
        G91 where they count."""
        column = np.full(self.n, NONE, np.int64)
        if self.dialect.carried_by_distance and "distance" in self.given:
            column = self.given["distance"].copy()
        place = self.places.get("M", np.zeros(0, np.int64))
        for number, mode in zip(self.dialect.carried_codes, (900, 910), strict=False):
            column[self.words.block[place[self.words.mantissa[place] == number]]] = mode
        self.given["carried"] = column

    def held(self, group: str) -> Any:
        """The code of a group in force at each block: (B,), not to be written to, where the batch
        names it, else one number."""
        if group not in self.given:
            return self.state.codes.get(group, NONE)
        if group not in self.filled:
            self.filled[group] = hold_last(self.given[group], self.state.codes.get(group, NONE))
            self.filled[group].flags.writeable = False
        return self.filled[group]

    def after(self) -> dict[str, int]:
        """The codes in force behind the batch."""
        result = dict(self.state.codes)
        if self.condition != result.get("condition", NONE):
            result["condition"] = self.condition
        for group, column in self.given.items():
            named = (column != NONE).nonzero()[0]
            if len(named):
                result[group] = int(column[named[-1]])
        return result

    def because(self, message: str, advice: str) -> int:
        """The number of a reason, for the `reason` column."""
        self.reasons.append((message, advice))
        return len(self.reasons) - 1

    def blame(self, blocks: np.ndarray, message: str, advice: str) -> None:
        """Give blocks a reason, unless they have one."""
        free = blocks[self.reason[blocks] == 0]
        if len(free):
            self.reason[free] = self.because(message, advice)

    def held_absolute(self, block: int) -> bool:
        """Whether arc centres are absolute at a block."""
        return bool(np.broadcast_to(self.held("arc centre"), self.n)[block] == 901)

    def measured(self, letter: str) -> str:
        """The axis by which words of one are measured: C by X as a coordinate of the face."""
        return "X" if self.polar and letter == "C" else letter

    def unit_scale(self, letter: str) -> tuple[Any, Any]:
        """Ticks of one unit of an axis word, and of one least increment: (B,) or a number each."""
        letter = self.measured(letter)
        least = self.setup.least_increment.get(letter, 1e-4)
        inch = letter in LINEAR and self.held("units") == 200
        if not isinstance(inch, np.ndarray):
            return _scales(inch, least)
        unit, increment = zip(_scales(True, least), _scales(False, least), strict=True)
        return np.where(inch, *unit), np.where(inch, *increment)

    def halves(self, letter: str, distances: np.ndarray | None = None) -> Any:
        """(B,) or number: 2 where words of this axis are diameters, else 1.

        distances (B,) bool: where its words are distances, by G91 unless given. Under DIAM90 places
        are diameters and distances radii: Sinumerik 808D, turning (6FC5398-5DP10-0BA0), page 26,
        says so of G90 and G91, and that AC() and IC() set a word apart from these. That IC() is a
        radius follows from both, and is in no text that was found; two viewers read it so.
        """
        if self.polar and (letter != "X" or self.polar == "Y"):
            return np.int64(1)
        if letter == "X" and "diameter" in self.dialect.groups:
            mode = self.held("diameter")
            default = 2 if letter in self.setup.diameter else 1
            if isinstance(mode, int) and mode != DIAM90:
                return np.int64({70: 2, 80: 1}.get(mode, default))
            if DIAM90 in self.dialect.by_number:
                if distances is None:
                    distances = np.broadcast_to(self.held("distance"), self.n) == 910
                return np.where(
                    mode == DIAM90,
                    np.where(distances, 1, 2),
                    np.where(mode == 70, 2, np.where(mode == 80, 1, default)),
                )
            return np.where(mode == 70, 2, np.where(mode == 80, 1, default))
        return np.int64(2 if letter in self.setup.diameter else 1)
