"""The way back into a program that was interrupted: what is in force before a line, and the blocks
that bring it about.

The lines before are read again by the filter itself (nothing of them is sent), so what is in force
is what the control would hold. Then: out to a safe place first (mills and printers along Z, lathes
along X), tool, over the place, spindle and coolant on and up to speed, down at a feed, the
program's own modal state, and on with the line. What can not be brought back so is refused.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

import numpy as np

from postproc.errors import UsageError
from postproc.filter import Filter
from postproc.nc import pace
from postproc.nc.state import NONE
from postproc.streaming.before import ALONG, IN, OUT, Before
from postproc.units import MM_PER_INCH, TICKS_PER_MM

PLUNGE = 200.0  # mm/min at most, down to where the cut begins
SPIN_UP = 4.0  # s
MOVES = re.compile(rb"[XYZABCUVWIJKR] *[-+.0-9]", re.IGNORECASE)
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*")
UNWRITTEN = ("G998", "G999")  # stand for a parameter of the control (nc/dialects/okuma_lathe.py)
MILL, LATHE, PRINTER = "mill", "lathe", "printer"


def kind_of(filter_: Filter) -> str:
    """MILL, LATHE or PRINTER. Raises UsageError where the machine is none of them."""
    setup = filter_.setup
    axes = set(setup.axes)
    if {"X", "Y", "Z"} <= axes and not setup.diameter:
        return PRINTER if filter_.dialect.one_command else MILL
    if {"X", "Z"} <= axes and "Y" not in axes and not filter_.dialect.one_command:
        return LATHE
    raise UsageError(
        f"{filter_.machine.name} has the axes {' '.join(setup.axes)}: gcomp does not know which way"
        " is safe there",
        "bring the tool to a safe place by hand, and send the rest as a program of its own",
    )


def lifts(filter_: Filter) -> str:
    """The axis that takes the tool out of the part: Z, on a lathe X."""
    return "X" if kind_of(filter_) == LATHE else "Z"


def read_before(filter_: Filter, lines: Iterable[bytes], line: int) -> tuple[Before, bytes]:
    """Let a fresh filter read the lines before `line`; gives what holds there, and the line itself
    with what follows up to the next motion. Raises UsageError, ProgramError."""
    axis = filter_.setup.axes.index(lifts(filter_))
    before = Before(inch=filter_.modal.codes.get("units") == 200)
    filter_.watchers.append(lambda words, motions, *_: before.watch(words, motions, axis))
    if filter_.dialect.m_takes:
        filter_.watchers.append(lambda words, *_: before.printed(words.text))
    rest: list[bytes] = []
    batch: list[bytes] = []
    number = 0
    for number, text in enumerate(lines, 1):
        if number < line:
            batch.append(text)
            if len(batch) >= 256:
                filter_.feed(b"".join(batch))
                batch.clear()
        else:
            rest.append(text)
            if MOVES.search(COMMENT.sub(b"", text)) or len(rest) > 1000:
                break
    filter_.feed(b"".join(batch))
    if not rest:
        raise UsageError(
            f"line {line} is beyond the program's {number} lines", "name an earlier line"
        )
    return before, b"".join(rest)


def digits(value: float) -> str:
    """A place with as many decimals as it has, four at least: a program in inches or increments
    counts on from it."""
    whole, _, part = f"{value:.7f}".partition(".")
    return f"{whole}.{part.rstrip('0').ljust(4, '0')}"


class Preamble:
    """The blocks of one restart, in the program's language."""

    def __init__(
        self,
        filter_: Filter,
        before: Before,
        safe: dict[str, float],
        stands: dict[str, float],
        stays: bool = False,
    ):
        self.filter, self.before, self.stays = filter_, before, stays
        self.modal, self.dialect, self.setup = filter_.modal, filter_.dialect, filter_.setup
        self.kind, self.lift = kind_of(filter_), lifts(filter_)
        self.row = self.setup.axes.index(self.lift)
        modal = self.modal
        origin = modal.origin if modal.origin is not None else np.zeros_like(modal.position)
        # The preamble is written in the program's own frame: machine coordinates less the origin,
        # mm, on a diameter axis doubled (half is 2 there, what a radius is multiplied by).
        self.origin = origin
        self.half = {x: 2 if x in self.setup.diameter else 1 for x in self.setup.axes}
        if "diameter" in self.dialect.groups and modal.codes.get("diameter") in (70, 80):
            self.half["X"] = 2 if modal.codes["diameter"] == 70 else 1
        self.place = {
            x: (modal.position[i] - origin[i]) / TICKS_PER_MM * self.half[x]
            for i, x in enumerate(self.setup.axes)
        }
        # Never back in: where it stands farther out than that already, it goes across from there.
        self.top = max(-math.inf if stays else self._top(safe), stands.get(self.lift, -math.inf))

    def _top(self, safe: dict[str, float]) -> float:
        """mm, machine coordinates: where the tool is taken first along the axis that lifts it."""
        top = safe.get(self.lift, self.before.highest)
        if other := next((x for x in safe if x != self.lift), None):
            raise UsageError(
                f"a {self.kind} goes out along {self.lift} first, and --safe-{other.lower()} says"
                " nothing of it",
                f"say --safe-{self.lift.lower()}",
            )
        if self.kind == LATHE and self.before.left != OUT:
            self._refuse_bore(stated=self.lift in safe)
        if top is None:
            raise UsageError(
                f"no rapid before this line says which {self.lift} is safe",
                f"say it: --safe-{self.lift.lower()}, mm, machine coordinates",
            )
        stands = self.modal.position[self.row] / TICKS_PER_MM
        # going "out" would go in, across the part
        if stands > top + 1e-9:
            raise UsageError(
                f"safe {self.lift} {top:g} is below where the program stands, {self.lift}"
                f" {stands:.3f} (mm, machine"
                f" coordinates{', in radius' if self.kind == LATHE else ''})",
                f"--safe-{self.lift.lower()} higher, or name a line where the tool is farther in",
            )
        return top

    def _refuse_bore(self, stated: bool) -> None:
        """A lathe's tool that has not left the part outwards. stated: a safe X is."""
        if self.before.left == IN or not stated:
            how = {
                IN: "towards the axis: it cuts a bore",
                ALONG: "along Z alone",
                "": "not at all yet",
            }
            by_hand = "bring the tool out by hand and send the rest as a program of its own"
            say = (
                ""
                if self.before.left == IN
                else "if it cuts outside, say --safe-x, mm in radius, machine coordinates; or "
            )
            raise UsageError(
                "which way of X leads out of the part can not be told: with this tool the program"
                f" left its last cut {how[self.before.left]}",
                f"{say}name a line behind a rapid to a larger X, or {by_hand}",
            )

    def spelt(self, group: str, number: int) -> str:
        """How the control writes a mode, by its group and its number ("units", 210: G21, of a
        Siemens G71); "" where it has none. By the number alone G90 of a lathe would be a cycle."""
        code = self.dialect.by_number.get(number)
        own = [x.word for x in self.dialect.codes if x.group == group and x.number == number]
        word = code.word if code is not None and code.word in own else "".join(own[:1])
        return "" if word in UNWRITTEN else word

    def word(self, group: str, default: int = NONE) -> str:
        """The code in force of a group, as it is written; "" where the control has no such code."""
        return self.spelt(group, self.modal.codes.get(group, NONE)) or self.spelt(group, default)

    def _own_units(self) -> str:
        """The program's own units as it wrote them: G70 and G700 of a Siemens are both inches, and
        only under the latter an F is."""
        own = [x.word for x in self.dialect.codes if x.group == "units"]
        return self.before.units if self.before.units in own else self.word("units", 210)

    def _offset(self) -> str:
        """The work offset in force, with the number that chooses one of many (G54.1 P3)."""
        word, frame = self.word("work offset"), self.modal.frame
        code = self.dialect.by_number.get(self.modal.codes.get("work offset", NONE))
        if frame is not None and self.dialect.offset_letter:  # E1 of a Fadal: no code, a word
            return frame.extended or f"{self.dialect.offset_letter}0"
        if frame is None or code is None or code.does != "extended":
            return word
        return f"{word} {frame.extended.rpartition(' ')[2]}"

    def joined(self, words: list[str]) -> list[str]:
        """Codes in one block, or one in each where a line is one command."""
        return words if self.dialect.one_command else [" ".join(words)] if words else []

    def lines(self) -> list[str]:
        """All blocks."""
        #   safe Z     +---------------->+      out in rapid, the tool, across in rapid, spindle
        #              |                 |      and coolant on, and a wait for the spindle
        #   stands at  o                 v      down at PLUNGE at most: what is below may be uncut
        #                                o      the program's own modes and feed, then the line
        first_feed, feed = self._feeds()
        lines = [
            *self._units(),
            *self._heat(),
            *self._zeros(),
            "" if self.stays else self._out(),
            *self._tool(),
            "" if self.stays else self._across(),
            *self._spindle(),
            "" if self.stays else self._down(),
            first_feed,
            self.before.path,
            *self.joined(self._modes()),
            *self._carried(),  # behind G90, which counts for E too
            feed,
        ]
        if self.modal.codes.get("motion", NONE) in (0, 10) and self.dialect.modal_motion:
            lines.append(self.word("motion"))
        return [line for line in lines if line]

    def _units(self) -> list[str]:
        """The modal state of the preamble itself: mm, absolute, the plane, feed per minute."""
        modes = [("units", 210), ("distance", 900), ("feed mode", 940)]
        if self.kind != PRINTER:
            modes.insert(2, ("plane", 180 if self.kind == LATHE else 170))
        return self.joined([word for mode in modes if (word := self.spelt(*mode))])

    def _zeros(self) -> list[str]:
        """Diameter or radius, and the work offset."""
        diameter = self.modal.codes.get("diameter") in (70, 80)
        offset = self._offset()
        needless = self.kind == PRINTER and offset == "G54"
        return [self.word("diameter") if diameter else "", "" if needless else offset]

    def _across(self) -> str:
        """Over the place, in all axes but the one that lifts."""
        still = {self.lift, *self.dialect.carried}
        known = zip(self.setup.axes, self.modal.known, strict=True)
        words = [f"{x}{digits(self.place[x])}" for x, is_known in known if is_known]
        words = [word for word in words if word[0] not in still]
        return " ".join(["G0", *words]) if words else ""

    def _feeds(self) -> tuple[str, str]:
        """The feed where a line is one command, and else in the program's own units: behind G94
        and G95, for LinuxCNC sets F to zero there."""
        feed = self.before.feed
        if not feed:
            return "", ""
        if self.dialect.one_command:
            return f"G1 F{feed:g}", ""
        if self.modal.codes.get("feed mode") == 930:
            return "", ""
        written, inch = self.before.fed
        if inch == self.before.inch:
            return "", written
        return "", self._per(feed / (MM_PER_INCH if self.before.inch else 1.0))

    def _per(self, feed: float) -> str:
        """An F; with a point where a number without one counts increments."""
        counts = (self.setup.integers or self.dialect.integers) == "least increments"
        text = f"F{feed:.7g}"
        return text + "." * (counts and "." not in text)

    def _down(self) -> str:
        """Down to where the cut begins; by a rapid where the program has come here by rapids."""
        to = f"{self.lift}{digits(self.place[self.lift])}"
        per_minute = self.modal.codes.get("feed mode", 940) == 940
        feed = min(PLUNGE, self.before.feed) if per_minute else PLUNGE
        return f"G1 {to} {self._per(feed)}" if self.before.feed else f"G0 {to}"

    def _modes(self) -> list[str]:
        """The program's own modal state."""
        codes = self.modal.codes
        modes = [
            "" if self.kind == PRINTER and codes.get("plane") == 170 else self.word("plane", 170),
            self._own_units(),
            self.word("distance", 900),
            self.word("feed mode", 940),
            "" if self.before.path else self.word("path"),
            "" if codes.get("arc centre", 911) == 911 else self.word("arc centre"),
        ]
        return [mode for mode in modes if mode]

    def _out(self) -> str:
        """Out of the part: in machine coordinates where the control has G53, else in the
        program's."""
        # #MCS of a Fagor; G53 of an Okuma takes the tool's length off, and is of another group
        machine = self.spelt("", 530)
        if machine and self.kind != PRINTER:
            return f"{machine} G0 {self.lift}{self.top * self.half[self.lift]:.4f}"
        return f"G0 {self.lift}{(self.top - self.origin[self.row] / TICKS_PER_MM) * self.half[self.lift]:.4f}"  # noqa: E501

    def _tool(self) -> list[str]:
        """The tool, and its length."""
        before, frame = self.before, self.modal.frame
        lines = [f"{before.loaded} M6"] if before.loaded else []
        if before.tool and before.tool != before.loaded:
            lines.append(before.tool)
        length = dict(zip(self.setup.axes, frame.length, strict=True)) if frame is not None else {}
        if any(length.values()):
            # 431 is G43.1, a length stated in the block: G43 H would take what the control's table
            # has now
            if any(v for x, v in length.items() if x != "Z") or 431 not in self.dialect.by_number:
                raise UsageError(
                    "a tool length is in force that gcomp can not restore",
                    "name a line before it is called",
                )
            lines.append(f"G43.1 Z{digits(length['Z'] / TICKS_PER_MM)}")
        return lines

    def _spindle(self) -> list[str]:
        """Speed, direction and coolant; a wait for the spindle in the control's own unit of
        time."""
        before = self.before
        if before.spindle == "M5":
            return (
                [before.speed] if before.speed and not self.dialect.one_command else []
            ) + before.coolant
        if before.surface:
            raise UsageError(
                "constant surface speed (G96) is in force, and the limit of the spindle's speed is"
                " not followed",
                "name an earlier line, before G96",
            )
        return [f"{before.spindle} {before.speed}".strip(), self.wait(), *before.coolant]

    def wait(self) -> str:
        """G4 for the spindle, behind G94, in the letters and units of nc/pace.py. Sinumerik in ISO
        mode: X seconds with a point, P whole milliseconds, both turns of the spindle under G95 (ISO
        Milling 04.07, 3.3.1); Fanuc likewise: unverified."""
        units = pace.letters_of_dwell(self.dialect) or dict.fromkeys(self.dialect.dwell, 1.0)
        letter = next(x for x in "XFSPK" if x in units)
        # X in a G4 would be an axis to whoever reads over it
        letter = "P" if letter == "X" and self.kind == MILL and "P" in units else letter
        counts = letter == "X" or pace.without_a_point(self.dialect, letter) != 1.0
        return f"G4 {letter}{SPIN_UP / units[letter]:g}{'.' * counts}"

    def _heat(self) -> list[str]:
        """A printer's heaters, each waited for, before anything moves: a cold nozzle sticks to the
        part."""
        codes = {"bed": "M190", "chamber": "M191", "nozzle": "M109"}
        warm = [
            f"{code} S{self.before.heat[x]:g}"
            for x, code in codes.items()
            if self.before.heat.get(x)
        ]
        return warm + ([self.before.fan] if self.before.fan else [])

    def _carried(self) -> list[str]:
        """Where the filament stands: the firmware is told so, nothing is pushed."""
        if "E" not in self.dialect.carried or "E" not in self.setup.axes:
            return []
        absolute = self.modal.codes.get("carried", 900) == 900
        return ["M82" if absolute else "M83", f"G92 E{self.place['E']:.5f}"]


def preamble(
    filter_: Filter,
    before: Before,
    safe: dict[str, float] | None = None,
    stands: dict[str, float] | None = None,
    stays: bool = False,
) -> list[bytes]:
    """The blocks that bring it about, in the program's language. safe: of the axis that takes the
    tool out (Z, on a lathe X in radius), mm, machine coordinates; left out: the highest place that
    a rapid of the program has reached. stands: where the controller stands, by axis, mm, machine
    coordinates. stays: nothing shall move, only modes come back. Raises UsageError."""
    return [
        line.encode() for line in Preamble(filter_, before, safe or {}, stands or {}, stays).lines()
    ]
