"""M70 to M73 of LinuxCNC: modes that are kept, and the plain codes that bring them back.

LinuxCNC documentation, "M70 Save Modal State" and on; measured on 2.9 (tests/linuxcnc/README.md).
What M72 brings back: plane, units, distances, feed mode and F, work offset, arc centres, diameters,
return of cycles; not the motion code. M73 does it at the end of its sub. Each call has one state of
its own. Speed, spindle and coolant come back where the program has named them before (the
documentation's list of M70). What else it touches (tool length, G92, cutter radius, path mode,
overrides) must stand as it stood: which codes say that is not certain.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from postproc.nc.codes import RESTORED
from postproc.nc.comments import code_alone
from postproc.nc.expand import Refusal
from postproc.nc.expand.tracker import Tracker, number
from postproc.nc.state import ModalState

# Modal groups that come back, with the code in force where none was named.
GROUPS = {
    "plane": 170, "units": 210, "distance": 900, "feed mode": 940, "arc centre": 911,
    "diameter": 80, "return": 990, "work offset": -1,
}  # fmt: skip
STILL = {
    "cutter": "cutter radius compensation",
    "tool length": "the tool length",
    "spindle mode": "G96 or G97",
}
TOUCHES = re.compile(
    rb"M[ \t0]*(?P<m>[345789]|4[ \t]*[89]|5[ \t]*[0-3])(?![ \t]*\d)|(?<![A-Za-z<_])S["
    rb" \t]*(?P<s>[-+\d. \t]*[\d.]|(?=[\[#]))"
    rb"|G[ \t0]*6[ \t]*[14]",
    re.IGNORECASE,
)
TURNS = {b"3": "spindle", b"4": "spindle", b"5": "spindle", b"7": "mist", b"8": "flood"}
# a program that keeps modes
BEGINS = re.compile(rb"(?<![A-Za-z<_])M[ \t0]*7[ \t]*[0-3](?![ \t]*\d)", re.IGNORECASE)
WRITE = "write the codes that hold, and those that come back"


@dataclass
class Kept:
    """A state: codes by group, the feed, shifts; what spindle and coolant were told; `own`: M73, so
    it comes back with its sub; `touched`: what was named since that is not brought back here."""

    codes: dict[str, int]
    feed: float
    shifts: list[np.ndarray]
    machine: dict[str, bytes]
    own: bool
    touched: set[bytes] = field(default_factory=set)


class States:
    """One state for each level of calls, None: none is kept."""

    def __init__(self, tracker: Tracker, text: bytes = b""):
        self.tracker = tracker
        self.levels: list[Kept | None] = [None]
        # The words named last; coolant is off where none was, as M2 leaves it.
        self.machine: dict[str, bytes] = {"mist": b"M9", "flood": b"M9"}
        self.uses = BEGINS.search(text) is not None

    @property
    def watching(self) -> bool:
        """Whether lines must be looked at."""
        return self.uses or any(kept is not None for kept in self.levels)

    def watch(self, text: bytes) -> None:
        """A line that is executed."""
        text = code_alone(text, self.tracker.dialect.grammar)
        for found in TOUCHES.finditer(text):
            number = (found["m"] or b"").replace(b" ", b"").replace(b"\t", b"")
            if (
                b"$" in text
                or found["s"] == b""
                or not (found["s"] or number in TURNS or number == b"9")
            ):
                # a spindle of several, a speed that is worked out, or what does not come back
                for kept in self.levels:
                    if kept is not None:
                        kept.touched.add(found[0].strip().upper())
            elif found["s"]:
                self.machine["speed"] = b"S" + found["s"].replace(b" ", b"").replace(b"\t", b"")
            elif number == b"9":
                self.machine |= {"mist": b"M9", "flood": b"M9"}
            else:
                self.machine[TURNS[number]] = b"M" + number

    def called(self, depth: int) -> list[bytes]:
        """The level of calls behind a line: the lines that bring back what M73 has kept. Raises
        Refusal."""
        lines: list[bytes] = []
        #   o1 call    levels [main, None]     a level for each call that runs
        #   M73        levels [main, kept]     one state at each, the last one that was kept
        #   o1 endsub  levels [main]           kept by M73: it comes back here
        while len(self.levels) <= depth:
            self.levels.append(None)
        while len(self.levels) > depth + 1:
            kept = self.levels.pop()
            if kept is not None and kept.own:
                lines += self._back(kept, "M73")
        return lines

    def take(self, code: int) -> list[bytes]:
        """M70, M71, M72 or M73: the lines that stand for it. Raises Refusal."""
        if code in (72, 73) and self.tracker.dialect.m_refuses.get(code) == RESTORED:
            raise Refusal(
                f"M{code} of {self.tracker.dialect.title}: what it brings back is not measured",
                WRITE,
            )
        if code == 71:
            self.levels[-1] = None
        elif code == 72:
            kept = self.levels[-1]
            if kept is None:
                raise Refusal(
                    "M72, and no state is kept at this level of calls",
                    "M70 before it, in the same sub",
                )
            return self._back(kept, "M72")
        else:
            state = self.tracker.state
            codes = {group: self._code(state, group) for group in (*GROUPS, *STILL)}
            self.levels[-1] = Kept(
                codes, state.feed, _shifts(state), dict(self.machine), code == 73
            )
        return []

    @staticmethod
    def _code(state: ModalState, group: str) -> int:
        held = int(state.codes.get(group, -1))
        return GROUPS.get(group, -1) if held < 0 else held

    def _check(self, kept: Kept, word: str) -> None:
        """Raises Refusal where a state differs from now in what is not brought back here."""
        state = self.tracker.state
        if kept.touched:
            what = b" ".join(sorted(kept.touched)).decode("latin-1")
            raise Refusal(
                f"{word} brings back what {what} has changed, which is not followed", WRITE
            )
        for group, name in STILL.items():
            if kept.codes[group] != self._code(state, group):
                raise Refusal(f"{word} brings {name} back, which is not followed", WRITE)
        if any(not np.array_equal(a, b) for a, b in zip(kept.shifts, _shifts(state), strict=True)):
            raise Refusal(
                f"{word} brings G92 or the tool length back, which is not followed", WRITE
            )

    def _back(self, kept: Kept, word: str) -> list[bytes]:
        self._check(kept, word)
        state, words = self.tracker.state, []
        for group in GROUPS:
            if kept.codes[group] == self._code(state, group):
                continue
            if kept.codes[group] < 0:
                raise Refusal(f"{word} brings the {group} back, and none was named before", WRITE)
            words.append(self.tracker.dialect.by_number[kept.codes[group]].word.encode())
        lines = ([b" ".join(words)] if words else []) + self._turned(kept, word)
        same = kept.feed == state.feed or (math.isnan(kept.feed) and math.isnan(state.feed))
        if (
            same
            and kept.codes["units"] == self._code(state, "units")
            and kept.codes["feed mode"] != 930
        ):
            return lines
        if kept.codes["feed mode"] != 930:  # under G93 every block names its own
            lines.append(b"F0" if math.isnan(kept.feed) else b"F" + number(kept.feed, 6).encode())
        return lines

    def _turned(self, kept: Kept, word: str) -> list[bytes]:
        """The lines that bring speed, spindle and coolant back. Raises Refusal where nothing was
        named before."""
        changed = [name for name, now in self.machine.items() if kept.machine.get(name) != now]
        new = next((self.machine[name] for name in changed if name not in kept.machine), None)
        if new is not None:
            what = new.decode("latin-1")
            raise Refusal(
                f"{word} brings back what {what} has changed, and nothing said before what held",
                WRITE,
            )
        # M9 ends both kinds of coolant: it is written first, then those that were on
        self.machine = dict(kept.machine)
        lines = [kept.machine[name] for name in ("speed", "spindle") if name in changed]
        if not {"mist", "flood"} & set(changed):
            return lines
        on = [
            kept.machine[name]
            for name in ("mist", "flood")
            if kept.machine.get(name, b"M9") != b"M9"
        ]
        return [*lines, b"M9", *on]


def _shifts(state: ModalState) -> list[np.ndarray]:
    """What shifts the coordinates beside the work offset."""
    frame = state.frame
    return [] if frame is None else [frame.preset, np.array([frame.preset_on]), frame.length]
