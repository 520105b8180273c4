"""Words and modal state in, motions out.

Follows the program as the control would, up to where the tool shall be; knows nothing of errors. Each modal group is a
column over the blocks, filled down from the last code given; a group that no block names stays a single number. Absolute
words set a position, incremental words add to it; both in whole ticks, so any cut of the input gives the same positions.

Not followed here, and handed on as motions with a reason (postproc.nc.codes): cycles, cutter radius, tool length,
shifts of the coordinates, subprograms.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from postproc.errors import BlockFault, Notice
from postproc.motions import FOREIGN, Motions
from postproc.nc import codes
from postproc.nc.arcs import Circle, arcs_of
from postproc.nc.dialects import NO_GROUP, UNKNOWN, Dialect
from postproc.nc.lexer import Words
from postproc.units import LARGEST_WORD_MM, TICKS_PER_INCH, TICKS_PER_MM

LINEAR = "XYZUVW"
PARAMETERS = "NOGMFSTDHLPQ"
CENTRE_OF = {"X": "I", "Y": "J", "Z": "K"}
NONE = -1  # no code of that group yet


@dataclass(frozen=True)
class Setup:
    """What the text must be told of the machine: its axes, which words are diameters, least increments (mm), work and
    tool offsets (mm by axis, by name "G54", "T0101"), where it stands at the start (mm, machine coordinates), and how
    block delete and arc centres are read (None: as the dialect does)."""

    axes: tuple[str, ...]
    diameter: frozenset[str] = frozenset()
    least_increment: dict[str, float] = field(default_factory=dict)
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)
    start: dict[str, float] = field(default_factory=dict)
    block_delete: bool = False
    arc_centre: str = "incremental"


@dataclass(frozen=True)
class ModalState:
    """All that one batch hands to the next: a code per modal group, position (A,) ticks and whether it is known, the
    tool offset and F in force, why positions were lost, whether the program has ended, and whether a motion code was
    named since the last motion."""

    codes: dict[str, int]
    position: np.ndarray
    known: np.ndarray
    tool: str = ""
    feed: float = float("nan")
    lost: str = "the start of the program"
    ended: bool = False
    renamed: bool = False


class Interpreter:
    """One dialect on one machine. Holds no state: `run` takes it and gives the next."""

    def __init__(self, dialect: Dialect, setup: Setup):
        self.dialect, self.setup = dialect, setup
        self.rows = {letter: i for i, letter in enumerate(setup.axes)}
        self.increment_rows = {u: self.rows[x] for u, x in dialect.increments.items() if x in self.rows and u not in self.rows}
        centres = {CENTRE_OF[x] for x in setup.axes if x in CENTRE_OF}
        self.letters = set(PARAMETERS) | set(self.rows) | set(self.increment_rows) | {"I", "J", "K", "R"} | centres

    def initial(self) -> ModalState:
        """The state before the first block."""
        setup = self.setup
        modal = dict.fromkeys(self.dialect.groups, NONE)
        modal.update({"plane": self.dialect.plane, "distance": 900, "units": 210, "feed mode": 940})
        modal["arc centre"] = 901 if setup.arc_centre == "absolute" else 911
        modal["work offset"] = 540 if "G54" in setup.offsets else NONE
        start = [round(setup.start.get(x, 0.0) * TICKS_PER_MM) for x in setup.axes]
        return ModalState(modal, np.array(start, np.int64), np.array([x in setup.start for x in setup.axes]))

    def run(self, words: Words, state: ModalState) -> tuple[Motions, ModalState, list[Notice]]:
        """Motions of a batch. Raises BlockFault for the first block that can not be followed; nothing is changed then."""
        return _Batch(self, words, state).motions()


class _Batch:
    """The columns of one batch while they are worked out."""

    def __init__(self, interpreter: Interpreter, words: Words, state: ModalState):
        self.dialect, self.setup, self.rows = interpreter.dialect, interpreter.setup, interpreter.rows
        self.interpreter, self.words, self.state = interpreter, words, state
        self.notices: list[Notice] = []
        self.reasons: list[tuple[str, str]] = [("", "")]
        self.n = words.blocks
        present = np.flatnonzero(np.bincount(words.letter, minlength=128))
        self.places = {chr(c): np.flatnonzero(words.letter == c) for c in present}
        self.live = self._live()

    # -- words ---------------------------------------------------------------------------------------------------------

    def fault(self, word: int, message: str, advice: str = "") -> BlockFault:
        w = self.words
        return BlockFault(int(w.block[word]), message, advice, int(w.start[word]), int(w.stop[word]))

    def _live(self) -> np.ndarray:
        """(B,) bool: blocks that the control reads; none after the end of the program, none that block delete drops."""
        w, live = self.words, np.ones(self.n, dtype=bool)
        if self.setup.block_delete:
            live &= ~w.skip
        self.ended = self.state.ended
        if self.ended:
            live[:] = False
        for place in self.places.get("M", ())[:] if not self.ended else ():
            if w.mantissa[place] in codes.END_OF_PROGRAM and w.decimals[place] == 0 and live[w.block[place]]:
                live[w.block[place] + 1 :] = False
                self.ended = True
                break
        if not live.all():
            self.places = {letter: p[live[w.block[p]]] for letter, p in self.places.items()}
            self.places = {letter: p for letter, p in self.places.items() if len(p)}
        return live

    def once(self, letter: str) -> np.ndarray:
        """Word indices of a letter that may stand once in a block."""
        place = self.places.get(letter)
        if place is None:
            return np.zeros(0, np.int64)
        block = self.words.block[place]
        twice = np.flatnonzero(block[1:] == block[:-1])
        if len(twice):
            raise self.fault(place[twice[0] + 1], f"two {letter} words in one block", "which one the control obeys differs: keep one")
        return place

    def numbers(self, place: np.ndarray) -> np.ndarray:
        """(n,) float64 values of words."""
        return self.words.mantissa[place] / 10.0 ** self.words.decimals[place]

    def ticks(self, place: np.ndarray, scale) -> np.ndarray:
        """(n,) int64 words in ticks; `scale` ticks a unit. Exact to nine decimals, rounded to the tick beyond."""
        mantissa, decimals = self.words.mantissa[place], self.words.decimals[place]
        scale = np.broadcast_to(np.asarray(scale, np.int64), mantissa.shape)
        size = np.abs(mantissa) * (scale / 10.0**decimals)
        far = np.flatnonzero(size > LARGEST_WORD_MM * TICKS_PER_MM)
        if len(far):
            text = self.words.text[self.words.start[place[far[0]]] : self.words.stop[place[far[0]]]].decode("ascii", "replace")
            raise self.fault(place[far[0]], f"{text} is beyond {LARGEST_WORD_MM:g} mm", "is a decimal point missing?")
        value = mantissa * (scale // 10 ** np.minimum(decimals, 9))
        for i in np.flatnonzero(decimals > 9):
            over = 10 ** int(decimals[i])
            value[i] = (2 * int(mantissa[i]) * int(scale[i]) + over) // (2 * over)
        return value

    # -- modal groups --------------------------------------------------------------------------------------------------

    def read_codes(self) -> None:
        """Sort the G words into their modal groups: `given` maps a group to a (B,) column, NONE where not named."""
        place = self.places.get("G", np.zeros(0, np.int64))
        w = self.words
        number = w.mantissa[place] * 10
        fraction = w.decimals[place] > 0
        number = np.where(fraction, w.mantissa[place] * 10 // 10 ** np.minimum(w.decimals[place], 17), number)
        valid = (number >= 0) & (number < len(self.dialect.group_of)) & (w.decimals[place] < 18)
        valid &= number * 10 ** np.minimum(w.decimals[place], 17) == w.mantissa[place] * 10
        group = np.where(valid, self.dialect.group_of[np.where(valid, number, 0)], UNKNOWN)
        bad = np.flatnonzero(group == UNKNOWN)
        if len(bad):
            text = w.text[w.start[place[bad[0]]] : w.stop[place[bad[0]]]].decode("ascii", "replace")
            raise self.fault(place[bad[0]], f"{text} is not a code of {self.dialect.title}", "it could move an axis: use another --dialect, or take it out")
        self.given: dict[str, np.ndarray] = {}
        self.code_word = np.full(self.n, -1, np.int64)
        block = w.block[place]
        for g in np.flatnonzero(np.bincount(group[group >= 0], minlength=len(self.dialect.groups))):
            name, of = self.dialect.groups[g], group == g
            if name == "motion" and (number[of] == 800).any():
                others = np.bincount(block[of & (number != 800)], minlength=self.n)
                of &= (number != 800) | (others[block] == 0)  # G80 G1: G1 holds
            column = np.full(self.n, NONE, np.int64)
            column[block[of]] = number[of]
            self.given[name] = column
            twice = np.flatnonzero(block[of][1:] == block[of][:-1])
            if len(twice) and self.dialect.one_code_per_group:
                raise self.fault(place[of][twice[0] + 1], f"two codes of the modal group '{name}' in one block", "keep one")
            if name == "motion":
                self.code_word[block[of]] = place[of]
        self.single: dict[int, np.ndarray] = {}
        for code in sorted(set(number[group == NO_GROUP].tolist())):
            self.single[int(code)] = block[number == code]

    def held(self, group: str):
        """The code of a group in force at each block: (B,) where the batch names it, else one number."""
        if group not in self.given:
            return self.state.codes.get(group, NONE)
        return hold_last(self.given[group], self.state.codes.get(group, NONE))

    def after(self) -> dict[str, int]:
        """The codes in force behind the batch."""
        result = dict(self.state.codes)
        for group, column in self.given.items():
            named = np.flatnonzero(column != NONE)
            if len(named):
                result[group] = int(column[named[-1]])
        return result

    def because(self, message: str, advice: str) -> int:
        """The number of a reason, for the `reason` column."""
        self.reasons.append((message, advice))
        return len(self.reasons) - 1

    # -- the batch -----------------------------------------------------------------------------------------------------

    def motions(self) -> tuple[Motions, ModalState, list[Notice]]:
        w, setup, n = self.words, self.setup, self.n
        self.check_letters()
        self.read_codes()
        self.reason = np.zeros(n, np.int64)
        self.lost = self.state.lost
        taken = np.zeros(n, dtype=bool)
        loses = np.zeros(n, dtype=bool)
        foreign = np.zeros(n, dtype=bool)
        machine = np.zeros(n, dtype=bool)
        axis_words = {x: (self.once(x), self.once(u) if u else np.zeros(0, np.int64)) for x, u in self._axis_letters()}
        has_axis = np.zeros(n, dtype=bool)
        for absolute, increment in axis_words.values():
            has_axis[w.block[absolute]] = True
            has_axis[w.block[increment]] = True
        for number, block in self.single.items():
            code = self.dialect.by_number[number]
            if code.takes:
                taken[block] = True
                if not code.refuses:
                    loses[block] = True
                    self.lost = f"{code.word}"
            if code.refuses:
                foreign[block] = True
                self.reason[block] = self.because(f"{code.word} ({code.meaning})", code.refuses)
            if number == 530:
                machine[block] = True
                wrong = block[np.broadcast_to(self.held("distance"), n)[block] == 910]
                if len(wrong):
                    self.reason[wrong] = self.because("G53 under G91", "controls disagree on what that means: write G90 G53")
            if number == 40 and self.dialect.dwell != "P":
                taken[block] = True  # X and U are seconds here
            elif number == 40:
                timed = np.zeros(n, bool)
                timed[w.block[self.once("P")]] = True
                wrong = block[has_axis[block] & ~timed[block]]
                if len(wrong):
                    self.reason[wrong] = self.because("G4 with an axis word and no P", "this control's dwell time is P; for X or U in seconds use another --dialect")
        self.refused_groups(taken, has_axis)
        self.m_codes(foreign)
        self.check_points(taken)
        motion = self.held("motion")
        centre_words = {c: self.once(c) for c in "IJKR" if c in self.places}
        moving = has_axis & ~taken
        arc_code = (motion == 20) | (motion == 30)
        for place in centre_words.values():
            block = w.block[place]
            moving[block] |= np.broadcast_to(arc_code, n)[block] & ~taken[block]
        if "motion" in self.given:
            refused_motion = self.dialect.is_refused[np.maximum(motion, 0)] & (motion >= 0) & moving
            refused_motion |= self.dialect.is_refused[np.maximum(self.given["motion"], 0)] & (self.given["motion"] >= 0)
        else:
            refused_motion = moving & bool(motion >= 0 and self.dialect.is_refused[max(motion, 0)])
        if refused_motion.any():
            self.refuse_motions(refused_motion, np.broadcast_to(motion, n))
            foreign |= refused_motion
        no_mode = moving & ~foreign & ((motion == NONE) | (motion == 800))
        if no_mode.any():
            self.reason[no_mode] = self.because("axis words, but no motion code (G0 G1 G2 G3) is in force", "begin the program with the motion code it means")
            foreign |= no_mode
        if not isinstance(motion, int) or motion in (0, 10):
            self.stray_words(centre_words, moving, arc_code)
        moving |= foreign
        block = np.flatnonzero(moving)
        self.position(block, axis_words, taken, loses, foreign, machine)
        motions = self.columns(block, motion, foreign, machine, centre_words, axis_words)
        return motions, self.next_state(), self.notices

    def _axis_letters(self):
        reverse = {row: u for u, row in self.interpreter.increment_rows.items()}
        return [(x, reverse.get(row)) for x, row in self.rows.items()]

    def check_letters(self) -> None:
        """Refuse letters that mean nothing to the dialect or name an axis that the machine has not."""
        for letter, place in self.places.items():
            if letter in self.interpreter.letters:
                continue
            if letter in "ABCUVWXYZ":
                raise self.fault(place[0], f"the machine has no axis {letter}", f"its axes are {' '.join(self.setup.axes)}; choose the right --machine")
            raise self.fault(place[0], f"the letter {letter} has no meaning in {self.dialect.title}", "it could move an axis: use another --dialect, or take it out")
        if self.words.skip.any() and not self.state.ended:
            how = "left alone, as with the switch on" if self.setup.block_delete else "read as executed, as with the switch off"
            self.notices.append(
                Notice("block delete", f"blocks that begin with / are {how}; with the switch the other way the output is "
                       "not right (--block-delete on|off)", int(self.words.line[np.flatnonzero(self.words.skip)[0]]))
            )  # fmt: skip

    def check_points(self, taken: np.ndarray) -> None:
        """Say once that coordinates without a decimal point mean different things to different controls."""
        if self.dialect.integer_notice:
            for letter in self.rows:
                place = self.places.get(letter, np.zeros(0, np.int64))
                bare = place[~self.words.pointed[place] & (self.words.mantissa[place] != 0) & ~taken[self.words.block[place]]]
                if len(bare):
                    self.notices.append(Notice("integer", self.dialect.integer_notice, int(self.words.line[self.words.block[bare[0]]])))
                    return

    def refused_groups(self, taken: np.ndarray, has_axis: np.ndarray) -> None:
        """Fill `reason` wherever a modal code that can not be followed is in force."""
        for group in self.dialect.groups:
            if group == "motion":
                continue
            before = self.state.codes.get(group, NONE)
            if group in self.given:
                column = self.given[group]
                for number in sorted(set(column[column != NONE].tolist())):
                    code = self.dialect.by_number[int(number)]
                    if code.takes:
                        taken |= column == number
                        harmless = (column == number) & ~has_axis & (number != 100)
                        column[harmless] = NONE  # G92 S: a speed limit, no position
                held = hold_last(column, before)
                refused = self.dialect.is_refused[np.maximum(held, 0)] & (held >= 0)
                for number in np.unique(held[refused]):
                    self.reason[held == number] = self._in_force(int(number))
            elif before >= 0 and self.dialect.is_refused[before]:
                self.reason[:] = self._in_force(before)
        self.offset_columns()

    def _in_force(self, number: int) -> int:
        code = self.dialect.by_number[number]
        return self.because(f"{code.word} ({code.meaning}) is in force", code.refuses)

    def offset_columns(self) -> None:
        """`offset` (A, B) or (A, 1) ticks: where the zero of absolute words lies; unknown ones become reasons."""
        work = self.held("work offset")
        self.offset = np.zeros((len(self.rows), 1), np.int64)
        for number in sorted(set(np.asarray(work).ravel()[_changes(work)].tolist())):
            name = "" if number == NONE else self.dialect.by_number[int(number)].word
            self._add_offset(name, work == number)
        tool_place = self.places.get("T") if self.dialect.tool_offsets else None
        self.tool = self.state.tool
        if tool_place is None:
            self._add_offset(self.tool, True)
            return
        edges = [0, *self.words.block[tool_place].tolist(), self.n]
        names = [self.state.tool] + [self._tool_name(int(p)) for p in tool_place]
        for name, a, b in zip(names, edges[:-1], edges[1:], strict=True):
            within = np.zeros(self.n, dtype=bool)
            within[a:b] = True
            self._add_offset(name, within)
        self.tool = names[-1]

    def _tool_name(self, place: int) -> str:
        number = int(self.words.mantissa[place])
        return f"T{number:04d}" if number >= 100 and number % 100 else ""

    def _add_offset(self, name: str, where) -> None:
        if not name or not np.any(where):
            return
        if name not in self.setup.offsets:
            kind = "work" if name.startswith("G") else "tool"
            stated = ", ".join(sorted(self.setup.offsets)) or "none"
            number = self.because(
                f"the {kind} offset {name} is not stated",
                f"say where its zero lies in machine coordinates, mm and radius: --offset {name}="
                f"{','.join(x + '0' for x in self.rows)} (stated: {stated})",
            )
            self.reason = np.where(where, number, self.reason)
            return
        shift = [round(self.setup.offsets[name].get(x, 0.0) * TICKS_PER_MM) for x in self.rows]
        self.offset = self.offset + np.array(shift, np.int64)[:, None] * np.atleast_1d(np.asarray(where, np.int64))

    def m_codes(self, foreign: np.ndarray) -> None:
        """M codes that call other text are foreign; ones that nobody knows are passed with a notice."""
        place = self.places.get("M")
        if place is None:
            return
        for number in sorted(set(self.words.mantissa[place].tolist())):
            of = place[self.words.mantissa[place] == number]
            block = self.words.block[of]
            if number in self.dialect.m_refuses:
                foreign[block] = True
                self.reason[block] = self.because(f"M{number}", self.dialect.m_refuses[int(number)])
            elif number not in self.dialect.m_codes:
                self.notices.append(Notice(f"M{number}", f"M{number} is not a code of {self.dialect.title}: passed as it is", int(self.words.line[block[0]])))

    def refuse_motions(self, where: np.ndarray, motion: np.ndarray) -> None:
        for number in np.unique(motion[where]):
            code = self.dialect.by_number[int(number)]
            if code.refuses:
                self.reason[where & (motion == number)] = self.because(f"{code.word} ({code.meaning})", code.refuses)

    def stray_words(self, centre_words, moving, arc_code) -> None:
        """I J K R in a block that is no arc round a corner on some controls, and are an error on others."""
        straight = moving & ~np.broadcast_to(arc_code, self.n)
        for letter, place in centre_words.items():
            block = self.words.block[place]
            stray = block[straight[block]]
            if len(stray):
                self.reason[stray] = self.because(f"{letter} in a straight motion", "corner rounding and chamfers are not followed: write the corner out")

    # -- positions -----------------------------------------------------------------------------------------------------

    def unit_scale(self, letter: str):
        """Ticks of one unit of an axis word, and of one least increment: (B,) or a number each."""
        lii = self.setup.least_increment.get(letter, 1e-4)
        units = self.held("units")
        scale = np.where(units == 200, TICKS_PER_INCH, TICKS_PER_MM)
        # A control with 0.0001 mm has 0.00001 inch.
        grid = np.where(units == 200, round(lii / 10 * TICKS_PER_INCH), round(lii * TICKS_PER_MM))
        if letter not in LINEAR:
            scale, grid = np.asarray(TICKS_PER_MM), np.asarray(round(lii * TICKS_PER_MM))
        return scale, grid

    def halves(self, letter: str):
        """(B,) or number: 2 where words of this axis are diameters, else 1."""
        if letter == "X" and "diameter" in self.dialect.groups:
            mode = self.held("diameter")
            default = 2 if letter in self.setup.diameter else 1
            return np.where(mode == 70, 2, np.where(mode == 80, 1, default))
        return np.asarray(2 if letter in self.setup.diameter else 1)

    def position(self, block, axis_words, taken, loses, foreign, machine) -> None:
        """Work out (A, N) start, target, what is known, and the words' scales, at the moving blocks."""
        w, n = self.words, self.n
        distance = self.held("distance")
        shape = (len(self.rows), len(block))
        self.start, self.target = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
        self.start_known, self.target_known = np.zeros(shape, bool), np.zeros(shape, bool)
        self.word = np.full(shape, -1, np.int64)
        self.incremental = np.zeros(shape, bool)
        self.grid, self.scale, self.origin, self.least = (np.zeros(shape, np.int64) for _ in range(4))
        self.end_position, self.end_known = self.state.position.copy(), self.state.known.copy()
        forget = loses | foreign
        for letter, row in self.rows.items():
            scale, grid = self.unit_scale(letter)
            half = self.halves(letter)
            least = -round(np.log10(self.setup.least_increment.get(letter, 1e-4)))
            least = least + ((self.held("units") == 200) if letter in LINEAR else 0)
            scale, grid = scale // half, grid // half
            offset = self.offset[row]
            offset = offset if len(offset) == 1 else np.where(machine, 0, offset)
            if len(offset) == 1 and machine.any():
                offset = np.where(machine, 0, offset)
            position, known = np.full(n, self.state.position[row]), np.full(n, self.state.known[row])
            absolute, increment = axis_words[letter]
            both = np.intersect1d(w.block[absolute], w.block[increment]) if len(increment) else increment
            if len(both):
                raise self.fault(increment[w.block[increment] == both[0]][0], f"{letter} and its increment in one block", "keep one of them")
            place = absolute if not len(increment) else np.sort(np.concatenate([absolute, increment]))
            if taken.any():
                place = place[~taken[w.block[place]]]
            by = w.block[place]
            is_inc = at(distance == 910, by) & ~machine[by]
            if len(increment):
                is_inc |= w.letter[place] != ord(letter)
            value = self.ticks(place, at(scale, by))
            named = np.zeros(n, bool)
            if len(by):
                run: np.ndarray | int = 0
                here, set_to = by, value
                if is_inc.any():
                    moved = np.zeros(n, np.int64)
                    moved[by[is_inc]] = value[is_inc]
                    run = np.cumsum(moved)
                    here, set_to = by[~is_inc], value[~is_inc]
                base = np.zeros(n, np.int64)
                base[here] = set_to + at(offset, here) - (run[here] if isinstance(run, np.ndarray) else 0)
                named[here] = True
                last = hold_index(named)
                position = base[last]
                position[: np.searchsorted(last, 0)] = self.state.position[row]
                position += run
            drop = forget.copy()
            for number in (280, 300):
                if number in self.single:
                    self._reference(number, letter, drop)
            if named.any() or drop.any():
                event = np.where(drop, 0, np.where(named, 1, -1))
                known = hold_last(event, int(self.state.known[row])).astype(bool)
            before = np.concatenate([[self.state.position[row]], position[:-1]])
            before_known = np.concatenate([[self.state.known[row]], known[:-1]])
            self.start[row], self.target[row] = before[block], position[block]
            self.start_known[row], self.target_known[row] = before_known[block], known[block]
            word = np.full(n, -1, np.int64)
            word[by] = place
            self.word[row] = word[block]
            if is_inc.any() or np.any(distance == 910):
                inc = np.broadcast_to(distance == 910, n).copy()
                inc[by] = is_inc
                self.incremental[row] = inc[block]
            self.grid[row] = at(grid, block)
            self.least[row] = at(least, block)
            self.scale[row] = at(scale, block)
            self.origin[row] = at(offset, block)
            if n:
                self.end_position[row], self.end_known[row] = position[-1], known[-1]

    def held_absolute(self, block: int) -> bool:
        """Whether arc centres are absolute at a block."""
        return bool(np.broadcast_to(self.held("arc centre"), self.n)[block] == 901)

    def _reference(self, number: int, letter: str, drop: np.ndarray) -> None:
        """G28 with axis words sends those axes away, without any all of them."""
        block = self.single[number]
        named = np.zeros(self.n, bool)
        mine = np.zeros(self.n, bool)
        reverse = {u: self.setup.axes[row] for u, row in self.interpreter.increment_rows.items()}
        for other, place in self.places.items():
            if other in self.rows or other in reverse:
                named[self.words.block[place]] = True
                if reverse.get(other, other) == letter:
                    mine[self.words.block[place]] = True
        drop[block] = mine[block] | ~named[block]

    def columns(self, block, motion, foreign, machine, centre_words, axis_words) -> Motions:
        """Gather the columns of the moving blocks, and the arcs among them."""
        n = self.n
        motion = np.broadcast_to(motion, n)[block]
        code = np.where(foreign[block], FOREIGN, motion // 10).astype(np.int8)
        feed_place = self.once("F")
        feed_mode = np.broadcast_to(self.held("feed mode"), n)[block]
        feed = np.full(n, np.nan)
        feed[self.words.block[feed_place]] = self.numbers(feed_place)
        feed_word = np.full(n, -1, np.int64)
        feed_word[self.words.block[feed_place]] = feed_place
        if len(feed_place):
            feed = hold_last_float(feed, self.state.feed)
            self.feed = float(feed[-1])
        else:
            feed[:] = self.state.feed
            self.feed = self.state.feed
        named = np.cumsum(self.code_word >= 0)
        until: np.ndarray = named - (self.code_word >= 0)  # codes named before each block
        since = np.concatenate([[0], named[block[:-1]]]) if len(block) else named[:0]
        renamed = until[block] > since
        if len(block):
            renamed[0] |= self.state.renamed
            self.renamed = bool(named[-1] > named[block[-1]])
        else:
            self.renamed = self.state.renamed or bool(len(named) and named[-1])
        circle = Circle(
            block=block, code=code, plane=np.broadcast_to(self.held("plane"), n)[block],
            absolute=np.broadcast_to(self.held("arc centre"), n)[block] == 901, alone=machine[block],
        )  # fmt: skip
        arcs = arcs_of(self, circle, centre_words)
        return Motions(
            block=block, code=code, start=self.start, target=self.target, start_known=self.start_known,
            target_known=self.target_known, word=self.word, incremental=self.incremental, grid=self.grid,
            scale=self.scale, origin=self.origin, places=self.least, alone=machine[block], inverse=feed_mode == 930, feed=feed[block],
            feed_word=feed_word[block], code_word=self.code_word[block], reason=self.reason[block], renamed=renamed, arcs=arcs,
            reasons=self.reasons,
        )  # fmt: skip

    def next_state(self) -> ModalState:
        return replace(
            self.state, codes=self.after(), position=self.end_position, known=self.end_known, tool=self.tool,
            feed=self.feed, lost=self.lost, ended=self.ended, renamed=self.renamed,
        )  # fmt: skip


def at(column, index: np.ndarray):
    """A column at some blocks; a single number stays one."""
    column = np.asarray(column)
    return column.ravel()[0] if column.size == 1 else column[index]


def _changes(column) -> np.ndarray:
    """Indices at which a column takes another value, the first one among them."""
    column = np.asarray(column).ravel()
    return np.concatenate([[0], np.flatnonzero(column[1:] != column[:-1]) + 1]) if len(column) else np.zeros(0, np.int64)


def hold_index(named: np.ndarray) -> np.ndarray:
    """(B,) index of the last named block up to each block, -1 before the first."""
    return np.maximum.accumulate(np.where(named, np.arange(len(named)), -1))


def hold_last(column: np.ndarray, carry: int) -> np.ndarray:
    """Fill the gaps (-1) of a column with the last value given before them, or with `carry`."""
    last = hold_index(column != NONE)
    return np.where(last >= 0, column[np.maximum(last, 0)], carry)


def hold_last_float(column: np.ndarray, carry: float) -> np.ndarray:
    """The same with nan for the gaps."""
    last = hold_index(~np.isnan(column))
    return np.where(last >= 0, column[np.maximum(last, 0)], carry)
