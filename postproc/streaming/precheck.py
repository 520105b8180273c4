"""What a controller would refuse, or could not reach, in the middle of a job: found in its lines
before the first of them leaves.

GRBL (gnea/grbl): a target beyond 0 .. -$130.. stops the job in an alarm where $20 is on (system.c,
system_check_travel_limits; homing puts zero at the far end of each axis, and where it was built
with HOMING_FORCE_SET_ORIGIN, Z in its $I, an axis that homes in the negative direction, $23, goes
from 0 to +$130); a feed without F gives error:22, M6, M98 and O words error:20 (gcode.c).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from postproc.errors import Notice, Place, ProgramError, UsageError
from postproc.streaming.lines import Unsendable, WireLine
from postproc.streaming.protocols import Controller

PAUSE, IGNORE, REFUSE = "pause", "ignore", "refuse"
EPS = 0.0005  # mm: a place is rounded to that when it is sent
MOTION = re.compile(rb"G0*(?:[0-3]|38\.[2-5]|80)(?![0-9.])", re.IGNORECASE)
SPEED = re.compile(rb"S *[0-9.]", re.IGNORECASE)
TURNS = re.compile(rb"M0*[34](?![0-9.])", re.IGNORECASE)
M6 = re.compile(rb"M0*6(?![0-9.])", re.IGNORECASE)
CALL = re.compile(rb"M0*9[89](?![0-9.])|O *(?:[0-9<])", re.IGNORECASE)
FEEDS = re.compile(rb"G0*[123](?![0-9.])", re.IGNORECASE)
ENDS_FEED = re.compile(rb"G(?:0*0|0*38\.[2-5]|80)(?![0-9.])", re.IGNORECASE)
MODES = re.compile(rb"G9[34](?![0-9.])", re.IGNORECASE)
FEED = re.compile(rb"F *[0-9.]", re.IGNORECASE)
AXIS = re.compile(rb"[XYZABC] *[-+.0-9]", re.IGNORECASE)
NO_AXES = re.compile(rb"G0*(?:4|10|28|30|92|43)(?![0-9])", re.IGNORECASE)
EEPROM = re.compile(rb"G0*10(?![0-9])|G0*(?:28|30)\.1|^\$", re.IGNORECASE)
NOTHING, NO_MORE = "nothing was sent", "nothing more was sent behind this tool change"
# What a reset leaves (gcode.c, gc_init): these, G0, and neither feed nor speed.
PLAIN_START = {"G54", "G17", "G21", "G90", "G94"}
RUNNING = {"M3", "M4", "M7", "M8"}  # what it switches off


def tool_change(how: str, prepare: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """What becomes of M6 on a controller without it: PAUSE: M5 stands there as a pause of the
    program (M0), IGNORE: it is left out,
    REFUSE: Unsendable. prepare: the protocol's."""

    def prepared(text: bytes) -> bytes:
        line = prepare(text)
        if not M6.search(line):
            return line
        if how == REFUSE:
            raise Unsendable(
                "M6 changes the tool, and this controller has no tool change: it would stop the job"
                " there",
                "--tool-change pause waits there for a person, --tool-change ignore leaves M6 out",
            )
        return M6.sub(b"M0" if how == PAUSE else b"", line).strip()

    return prepared


class Precheck:
    """look() at every line of a job, in order. Raises ProgramError for what the controller would
    refuse; `notices` tell the rest.

    letters: the machine's axes; order: where each stands in the controller's settings. grbl:
    whether it is GRBL itself, whose rules are known to the letter; a relative may do more. sent:
    what was, when this is looked at."""

    def __init__(
        self,
        controller: Controller,
        letters: tuple[str, ...],
        order: tuple[int, ...],
        name: str,
        grbl: bool,
        sent: str = NOTHING,
    ):
        self.sent = sent
        self.controller = controller
        self.letters = letters
        self.order = order
        self.name = name
        self.grbl = grbl
        self.travel = [controller.setting(130 + k, math.inf) for k in order]
        self.soft = controller.setting(20) != 0.0
        mask = controller.setting(23)
        # $23: bit k set, axis k homes towards minus
        homes = int(mask) if "Z" in controller.flags else 0
        self.reach = [
            (0.0, t) if homes >> k & 1 else (-t, 0.0)
            for k, t in zip(order, self.travel, strict=True)
        ]
        self._feed = _value("F", controller.modal) > 0
        self._inverse = "G93" in controller.modal
        # Words that a reset would change, and that the program has not said yet; in_force: which of
        # them it goes by.
        self._unsaid = {"F"} if self._feed else set()
        self._unsaid |= {"S"} if _value("S", controller.modal) > 0 else set()
        self._unsaid |= {"G"} if "G0" not in controller.modal else set()
        self.in_force: set[str] = set()
        self._feeds = any(word in ("G1", "G2", "G3") for word in controller.modal)
        self._least = [math.inf] * len(letters)
        self._most = [-math.inf] * len(letters)
        self.stores = False

    def look(self, line: WireLine) -> None:
        text = line.text
        if EEPROM.search(text):
            self.stores = True
        if ENDS_FEED.search(text):
            self._feeds = False
        elif FEEDS.search(text):
            self._feeds = True
        if self._unsaid:
            self._goes_by(text)
        if self.grbl:
            self._words(line)
        # an arc between two ends in reach may bulge beyond the travel
        for place in (*line.points, line.end):
            self._place(place, line)

    def _words(self, line: WireLine) -> None:
        text = line.text
        if CALL.search(text):
            raise self._no(
                line,
                "this controller knows no subprograms: it would refuse the call in the middle of"
                " the job",
                "write the program out: --expand, with the --dialect that it was written for",
            )
        self._feed = self._fed(text)
        if self._feeds and not self._feed and AXIS.search(text) and not NO_AXES.search(text):
            lacks = "without its F under G93" if self._inverse else "before any F"
            raise self._no(
                line,
                f"a feed (G1, G2, G3) {lacks}: the controller would refuse it with error:22",
                "put an F word into this block or one before it",
            )

    def _fed(self, text: bytes) -> bool:
        """Whether a feed holds in this line. Under G93, where F is one over minutes, each line
        wants its own, and G94 behind it forgets them all (gcode.c)."""
        if MODES.search(text):
            before, self._inverse = self._inverse, b"G93" in text.upper()
            self._feed = self._feed and self._inverse == before
        here = bool(FEED.search(text))
        return here if self._inverse else self._feed or here

    def _goes_by(self, text: bytes) -> None:
        """Whether this line goes by a motion, a feed or a speed from before the program."""
        said = {"G": MOTION, "F": FEED, "S": SPEED}
        self._unsaid -= {word for word in self._unsaid if said[word].search(text)}
        moves = bool(AXIS.search(text)) and not NO_AXES.search(text)
        uses = {"G": moves, "F": moves and self._feeds, "S": bool(TURNS.search(text))}
        self.in_force |= {word for word in self._unsaid if uses[word]}

    def _place(self, place: tuple[float, ...], line: WireLine) -> None:
        for k, value in enumerate(place[: len(self.letters)]):
            if math.isnan(value):
                continue
            self._least[k], self._most[k] = min(self._least[k], value), max(self._most[k], value)
            low, high = self.reach[k]
            if self.grbl and self.soft and not (low - EPS <= value <= high + EPS):
                axis, number = self.letters[k], 130 + self.order[k]
                raise self._no(
                    line,
                    f"{axis} {value:.3f} (machine coordinates) is beyond the controller's travel,"
                    f" {low:g} to {high:g} mm (${number}), and its soft limits are on ($20): it"
                    " would stop in an alarm there",
                    "set the work zero elsewhere, or move the part; the other end of the program"
                    " may be in reach then",
                )

    def notices(self) -> list[Notice]:
        """What is worth looking at before the first line: more way than the machine has."""
        found = []
        for k, axis in enumerate(self.letters):
            way = self._most[k] - self._least[k]
            if math.isfinite(way) and way > self.travel[k] + EPS:
                found.append(
                    Notice(
                        f"travel {axis}",
                        f"the program moves {axis} over {way:.1f} mm, and the controller has"
                        f" {self.travel[k]:g} mm (${130 + self.order[k]})",
                    )
                )
        return found

    def checkable(self) -> bool:
        """Whether a pass in check mode changes nothing that the program goes by: it ends in a
        reset, which brings back GRBL's own modes and switches the spindle off; and settings are
        stored in it as ever (gcode.c)."""
        modal = set(self.controller.modal)
        plain = modal >= PLAIN_START and not modal & RUNNING
        return plain and not self.in_force and not self.stores

    def _no(self, line: WireLine, message: str, advice: str) -> ProgramError | UsageError:
        text = line.text.decode("latin-1")
        if not line.source:
            return UsageError(f"{self.sent}: {text}: {message}", advice)
        return ProgramError(
            f"{self.sent}: {message}", advice, Place(line.file or self.name, line.source, text)
        )


def _value(letter: str, words: list[str]) -> float:
    """Of a word in force; 0 where there is none."""
    word = next((word for word in words if word.startswith(letter)), "")
    return float(re.sub(r"[^0-9.]", "", word) or 0)
