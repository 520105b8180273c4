"""The variables of Fanuc's custom macro B: local, common, and of the system variables those that
the program itself decides.

What only the machine knows (timers, signals, tool offsets, what #500 and up kept from an earlier
day) is refused and never guessed, where something depends on it: a variable that it is written into
is as unknown from there on. Lengths are in the unit that the program is in, X of a lathe in
diameter. Sources: B-64304EN and B-64484EN, "Custom macro", "System variables"; groups of G codes:
the G code lists of B-64304EN-1 (lathe) and -2 (mill); Haas 96-8000, "Macros".
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NoReturn

from postproc.nc.expand import Refusal
from postproc.nc.expand.fanuc_functions import Unknown, Value
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.tracker import number as text_of

LETTERS = "XYZABCUVW"  # axes in the order in which controls number them
MILL = {
    1: "motion", 2: "plane", 3: "distance", 5: "feed mode", 6: "units", 7: "cutter",
    8: "tool length", 10: "return", 11: "scaling", 13: "spindle mode", 14: "work offset",
    16: "rotation",
}  # fmt: skip
LATHE = {
    1: "motion", 2: "spindle mode", 3: "distance", 5: "feed mode", 6: "units", 7: "cutter",
    11: "return", 14: "work offset", 16: "plane",
}  # fmt: skip
HAAS = {**{n: group for n, group in MILL.items() if n < 12}, 12: "work offset", 16: "rotation"}
ADDRESSES = {
    4102: "B", 4107: "D", 4108: "E", 4111: "H", 4113: "M", 4114: "N", 4130: "P",
}  # fmt: skip
CYCLES = re.compile(rb"[Gg][ \t0]*(?:7[ \t]*[3-9]|8[ \t]*[1-9])(?![ \t]*[0-9])")
TURNS = re.compile(rb"[Gg][ \t0]*(?:1[ \t]*6|5[ \t]*1|6[ \t]*8)(?![ \t]*[0-9])")
KEPT = "is read but never set here: only the control knows what it kept from before"
SIGNAL = "an interface signal: only the machine knows it"
MACHINE = "only the machine knows it"
SAY = "write the number itself, or set a common variable (#100) to it at the top of the program"
COUNTS = (3001, 3002, 3901, 3902)
FOREIGN = (  # first, last, what it is
    (1000, 1999, SIGNAL),
    (2000, 2999, "a tool offset: " + MACHINE),
    (3001, 3002, "a timer: " + MACHINE),
    (3003, 3099, "a state of the control: " + MACHINE),
    (3901, 3902, "a count of parts: " + MACHINE),
    (5061, 5080, "a place found by a probe: " + MACHINE),
    (5081, 5120, "a tool offset: " + MACHINE),
    (10001, 13999, "a tool offset: " + MACHINE),
)


def _foreign(number: int, otherwise: str) -> str:
    """What a variable is that a program does not decide."""
    return next((what for first, last, what in FOREIGN if first <= number <= last), otherwise)


def _value(value: Value | Unknown) -> Value:
    """Raises Unknown for what is not known, as where it was read first."""
    if isinstance(value, Unknown):
        raise Unknown(value.message, value.advice)
    return value


class Variables:
    """Memory of a program while it runs. local: #1 to #33 of the level in force; program: number of
    the one that runs;
    mentions: whether a block of the texts matches (canned cycles and turned coordinates are written
    out behind this, so the tracker does not hear of them); modal: whether a modal macro call is in
    force; spare: decimals more than the unit so far needs."""

    def __init__(self, tracker: Tracker):
        self.tracker = tracker
        self.haas = tracker.dialect.name.startswith("haas")
        self.local: dict[int, Value | Unknown] = {}
        self.common: dict[int, Value | Unknown] = {}
        self.program, self.modal, self.spare = 0, False, 0
        self.mentions: Callable[[re.Pattern[bytes]], bool] = lambda what: False
        self._decimals: dict[str, int] = {}
        self._places: dict[str, int] = {}
        axes = tracker.setup.axes
        # #5001 is the first axis of the control, which on a lathe is X and the second Z
        self.axes = (
            list("XYZABC") if self.haas else sorted(axes, key=lambda x: (LETTERS + x).index(x))
        )
        lathe = bool(tracker.dialect.increments) or tracker.dialect.tool_offsets
        self.groups = HAAS if self.haas else LATHE if lathe else MILL

    # -- what the letters of words resolve ---------------------------------------------------------

    def forget_units(self) -> None:
        """The program may have changed its unit."""
        self._decimals, self._places = {}, {}

    def decimals(self, letter: str) -> int:
        """Decimals that a number behind this letter is written with; asked for once, because the
        tracker must catch up."""
        if letter not in self._decimals:
            self._decimals[letter] = self.tracker.decimals(letter)
        return self._decimals[letter] + self.spare

    def places(self, letter: str) -> int:
        """Decimals of the least increment of an address; 0 for one that counts (M, T, D)."""
        if letter not in self._places:
            setup, dialect = self.tracker.setup, self.tracker.dialect
            axis = dialect.increments.get(letter, letter) if letter not in setup.axes else letter
            resolved = setup.least_increment
            least = dialect.counts or resolved.get(axis) or min(resolved.values(), default=1e-4)
            found = round(-math.log10(least)) + (self.tracker.inch and axis not in "ABC")
            self._places[letter] = (
                found if axis in setup.axes or letter in "XYZABCUVWIJKRQEF" else 0
            )
        return self._places[letter]

    # -- reading and writing -----------------------------------------------------------------------

    def read(self, number: int) -> Value:
        """The value of a variable, None: vacant. Raises Refusal where only the machine knows it."""
        #   1..33     of each call         2000..  tool offsets         5001..  end of last block
        #   100..199  common               3000..  alarms, clocks       5021..  place, machine
        #   500..999  common, kept by      4001..  G codes by group     5041..  place, program
        #             the control          4102..  last B D E F H ..    5201..  work offsets
        if number == 0:
            return None
        if number <= 33:
            return _value(self.local.get(number))
        if number in self.common:
            return _value(self.common[number])
        if 100 <= number <= 199:
            return None
        if self._is_common(number):
            raise Unknown(f"#{number} {KEPT}", SAY)
        return self._known(number)

    def write(self, number: int, value: Value | Unknown) -> None:
        """Set a variable, or say that its value is not known from here on. Raises Refusal for one
        that a program can not set, or whose setting would be lost."""
        if number and number <= 33:
            self.local[number] = value
        elif self._is_common(number):
            self.common[number] = value
        elif number in COUNTS:
            return  # what counts times or parts moves nothing, and reading it is refused
        elif number == 0:
            raise Refusal("#0 is always vacant and can not be set", "use another variable")
        else:
            what = _foreign(number, "no variable of a program")
            raise Refusal(
                f"#{number} is set: {what}",
                "this has no plain block: take it out, or do it before the program",
            )

    def data_block(self, number: int, value: Value | Unknown) -> str | None:
        """The G10 that writes a work offset as setting this variable does; None: it is none. In
        force from the next block on, as of G10 (B-64484EN, "System variables", "Workpiece zero
        point offset values"). Raises Refusal where G10 would not say the same."""
        index = (number - 1) % 20
        if not self._offset_of(number):
            return None
        if self.haas and number < 5221:
            raise Refusal(
                f"#{number} is set: the shift of G52, which is taken differently by setting 33",
                "write the shift into G54 itself: #5221, or G10 L2 P1 X..",
            )
        if self.tracker.code("distance") == 910:
            raise Refusal(
                f"#{number} is set under G91, where G10, which stands for it, adds to the offset",
                "write G90 before this block, and G91 again behind it",
            )
        axes = self.axes[index : index + 1]
        if not axes or axes[0] not in self.tracker.setup.axes:
            raise Refusal(
                f"#{number} is set: this machine has no axis number {index + 1}",
                "take the block out: it moves nothing here",
            )
        if _value(value) is None:
            raise Refusal(f"#{number} would be vacant", f"write the number: #{number}=0")
        # #5221 is X of G54, G10 L2 P1; #7001 and #14001 X of G54.1 P1, G10 L20 P1; 20 numbers an
        # offset
        length = text_of(float(_value(value) or 0.0), self.decimals(axes[0]))
        first = max(n for n in (5201, 7001, 14001) if n <= number)
        place, more = (number - first) // 20, first != 5201
        return f"G10 L{20 if more else 2} P{place + more} {axes[0]}{length}"

    def _is_common(self, number: int) -> bool:
        return (
            100 <= number <= 199 or 500 <= number <= 999 or (self.haas and 10000 <= number <= 10999)
        )

    def _unknown(self, number: int, why: str, advice: str = SAY) -> NoReturn:
        raise Unknown(f"#{number} is read: {why}", advice)

    def _known(self, number: int) -> float:
        """The value of a system variable."""
        if 4001 <= number <= 4021:
            return self._code(number)
        if 5001 <= number <= 5060:
            return self._place(number)
        if self._offset_of(number):
            return self._offset(number)
        if number == 4109:
            feed = self.tracker.state.feed
            return feed if math.isfinite(feed) else self._unknown(number, "no F has been given yet")
        if number == 4115:
            return (
                float(self.program)
                if self.program
                else self._unknown(number, "the program has no O number")
            )
        if number == 4119:
            return self._speed(number)
        if number == 4120:
            tool = self.tracker.state.next_tool
            return float(tool) if tool >= 0 else self._unknown(number, "no T has been given yet")
        if number in ADDRESSES:
            self._unknown(number, f"the last {ADDRESSES[number]} is not followed here")
        self._unknown(number, _foreign(number, "it is not known here"))

    def _speed(self, number: int) -> float:
        """#4119: the last S of the blocks before."""
        speed = self.tracker.speed
        if speed is None:
            self._unknown(number, "no S has been given yet: only the control knows the one before")
        if math.isnan(speed):
            self._unknown(number, "the last S stands beside G50 or G92, where it is a limit")
        return speed

    def _code(self, number: int) -> float:
        """#4001 to #4021: the G code in force in a group."""
        if number == 4012 and not self.haas:
            return 66.0 if self.modal else 67.0
        group = self.groups.get(number - 4000, "")
        if not group or (group not in self.tracker.dialect.groups):
            self._unknown(number, "that group of G codes is not followed here")
        code = self.tracker.code(group)
        if code < 0:
            self._unknown(
                number,
                f"no G code for {group!r} has been given yet",
                "give it at the top of the program",
            )
        if group == "motion" and (code > 330 or self.mentions(CYCLES)):
            self._unknown(
                number, "canned cycles, which are in this text, are written out and change it"
            )
        known = self.tracker.dialect.by_number.get(code)
        return float(known.word[1:]) if known else code / 10

    def _axis(self, number: int, index: int) -> str:
        if index >= len(self.axes) or self.axes[index] not in self.tracker.setup.axes:
            self._unknown(number, f"this machine has no axis number {index + 1}")
        return self.axes[index]

    def _place(self, number: int) -> float:
        """#5001 the end of the last block, #5021 the machine's coordinates, #5041 the place now;
        one per axis."""
        row, index = divmod(number - 5001, 20)
        axis, tracker = self._axis(number, index), self.tracker
        if row != 1 and self.mentions(TURNS):
            self._unknown(
                number, "turned, scaled or polar coordinates are in this text, and are written out"
            )
        if row == 1:
            machine = tracker.machine(axis) if self._settled(axis) else None
            place = None if machine is None else self._length(machine, axis)
        else:
            place = tracker.work(axis)
        if place is None:
            advice = (
                f"say where it stands and the offsets in force: --start {axis}0, --offset"
                f" G54={axis}0 (mm, radius)"
            )
            self._unknown(number, f"where {axis} stands is not known", advice)
        if row == 2 and self._tool_shifts(axis):
            why = "a tool's length is in force, and controls differ on whether it counts here"
            self._unknown(number, why, f"read #{number - 40}, which leaves it out")
        return place

    def _settled(self, axis: str) -> bool:
        """Whether all that lies between the program's coordinates and the machine's is known."""
        tracker, state = self.tracker, self.tracker.state
        # The tracker counts what is not stated as 0: only where all offsets in force are stated is
        # its place one of the machine.
        code = tracker.code("work offset")
        known = tracker.dialect.by_number.get(code)
        name = (
            state.frame.extended
            if state.frame and state.frame.extended
            else known.word
            if known
            else ""
        )
        stated = not name or tracker.offset(name, axis) is not None
        tool = not state.tool or tracker.offset(state.tool, axis) is not None
        return stated and tool and not (state.frame and state.frame.unknown)

    def _tool_shifts(self, axis: str) -> bool:
        state = self.tracker.state
        row = self.tracker.setup.axes.index(axis)
        length = state.frame is not None and (
            state.frame.length[row] != 0 or "length" in state.frame.unknown
        )
        return bool(length or (state.tool and self.tracker.offset(state.tool, axis) != 0))

    def _length(self, value: float, axis: str) -> float:
        """mm and radius in the unit of the program, in diameter where it is."""
        if self.tracker.inch and axis in "XYZUVW":
            value /= 25.4
        return value * 2 if self.tracker.is_diameter(axis) else value

    def _offset_of(self, number: int) -> tuple[str, ...]:
        """The names of the work offset that a variable belongs to, () if it is none."""
        if 5201 <= number <= 5339 and (number - 5201) % 20 < 9:
            n = (number - 5201) // 20
            return (f"G{53 + n}",) if n else ("G52" if self.haas else "EXT",)
        for first, last in ((7001, 7959), (14001, 19999)):
            if first <= number <= last and (number - first) % 20 < 9:
                n = (number - first) // 20 + 1
                return f"G54.1 P{n}", f"G{109 + n}"
        return ()

    def _offset(self, number: int) -> float:
        axis = self._axis(number, (number - 1) % 20)
        names = self._offset_of(number)
        for name in names:
            offset = self.tracker.offset(name, axis)
            if offset is not None:
                return self._length(offset, axis)
        self._unknown(
            number,
            f"the offset {names[0]} is not stated",
            f"say it: --offset {names[0]}={axis}0 (mm, radius)",
        )
