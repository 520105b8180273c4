"""What a program has said before a line, beyond what the filter keeps: spindle, coolant, tool,
feed, heaters, and how the tool went in and out.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from postproc.motions import CLOCKWISE, COUNTER, FEED, RAPID, SPLINE, Motions
from postproc.nc.lexer import Words
from postproc.units import MM_PER_INCH, TICKS_PER_MM

HEATERS = {104: "nozzle", 109: "nozzle", 140: "bed", 190: "bed", 141: "chamber", 191: "chamber"}
# Firmware whose M words take what stands behind them: those parameters are no words of a block.
COMMAND = re.compile(
    rb"^[ \t]*(?:N[0-9]+[ \t]*)?M0*(3|4|5|104|109|140|190|141|191|106|107)(?![0-9])([^\n;*]*)",
    re.MULTILINE | re.IGNORECASE,
)
PARAMETER = re.compile(rb"[SR][ \t]*([0-9.]+)", re.IGNORECASE)
# G70 and G71 are cycles on some lathes: whether a code is one of units the dialect knows
UNITS = {20, 21, 70, 71, 700, 710}
OUT, IN, ALONG = "out", "in", "along"


def _spelt(words: Words, letter: str) -> dict[int, str]:
    """Block to its word of a letter, as it is written, without blanks."""
    of = np.flatnonzero(words.letter == ord(letter))
    places = zip(words.block[of], words.start[of], words.stop[of], strict=True)
    return {
        int(block): words.text[first:stop].decode("ascii", "replace").replace(" ", "").upper()
        for block, first, stop in places
    }


@dataclass
class Before:
    """What holds before the line: spindle, coolant, tool as words; loaded: the tool that M6 has put
    in; feed: mm/min or mm a turn of the last F, which stays what it was when the units change;
    fed: that word as it is written (F200 and F200. are two feeds on some controls), and whether it
    was in inches;
    inch: whether words are inches; units: the code that was written last for them;
    path: G64 with its P, mm;
    heat: temperature by heater; fan: its word; highest: mm, the highest place of a rapid so far
    along the axis that lifts the tool; left: how the present tool last left a cut by a rapid along
    that axis: OUT (to +), IN, ALONG, "": it has not.
    moved: whether anything has."""

    spindle: str = "M5"
    speed: str = ""
    coolant: list[str] = field(default_factory=list)
    tool: str = ""
    loaded: str = ""
    feed: float = 0.0
    fed: tuple[str, bool] = ("", False)
    inch: bool = False
    units: str = ""
    path: str = ""
    heat: dict[str, float] = field(default_factory=dict)
    fan: str = ""
    highest: float | None = None
    left: str = ""
    cuts: bool = False
    surface: bool = False
    moved: bool = False

    def watch(self, words: Words, motions: Motions, axis: int) -> None:
        """Take a batch's words, and what its motions do along the axis that lifts the tool."""
        values = [
            int(m) / 10 ** int(d) for m, d in zip(words.mantissa, words.decimals, strict=True)
        ]
        blocks: dict[int, list[tuple[str, float]]] = {}
        for block, name, value in zip(
            words.block.tolist(), map(chr, words.letter), values, strict=True
        ):
            blocks.setdefault(block, []).append((name, value))
        tools, feeds = _spelt(words, "T"), _spelt(words, "F")
        for block, named in blocks.items():
            self.tool = tools.get(block, self.tool)
            self._block(named, feeds.get(block, ""))
        self._ways(motions, axis, sorted(tools))

    def _block(self, named: list[tuple[str, float]], feed: str) -> None:
        """feed: its F as it is written."""
        word, codes = dict(named), {value for name, value in named if name == "G"}
        commands = [value for name, value in named if name == "M"]
        self._feed(codes, word, feed)
        self._spindle(codes, word, max(commands, default=0))
        for value in commands:
            self._command(value)

    def _spindle(self, codes: set[float], word: dict[str, float], command: float) -> None:
        """Surface speed and S; command: the largest M of the block."""
        # M100 and on are a shop's own: what their S means is not known.
        self.surface = (self.surface or 96 in codes) and 97 not in codes
        # S beside G4 counts turns, beside G10 sets data, with G50 and G92 limits the speed.
        if "S" in word and command < 100 and codes.isdisjoint((4, 10, 50, 92)):
            self.speed = f"S{word['S']:g}"

    def _feed(self, codes: set[float], word: dict[str, float], feed: str) -> None:
        """Units, feed and path tolerance."""
        if codes & {20, 21}:
            self.inch = 20 in codes
        for code in codes & UNITS:
            self.units = f"G{code:g}"
        scale = MM_PER_INCH if self.inch else 1.0
        if "F" in word and 4 not in codes:
            self.feed, self.fed = word["F"] * scale, (feed, self.inch)
        if 64 in codes:
            self.path = f"G64 P{word['P'] * scale:g}" if "P" in word else "G64"

    def _command(self, value: float) -> None:
        if value in (3, 4, 5):
            self.spindle = f"M{value:g}"
        elif value == 6:
            # T chooses, M6 puts in: a T behind the last M6 only waits in the changer
            self.loaded = self.tool
        elif value in (7, 8):
            self.coolant = sorted({*self.coolant, f"M{value:g}"})
        elif value == 9:
            self.coolant = []

    def printed(self, text: bytes) -> None:
        """Take the heaters, fan and spindle of a printer's lines."""
        for command in COMMAND.finditer(text):
            number, found = int(command[1]), PARAMETER.search(command[2])
            value = float(found[1]) if found else None
            if number in HEATERS:
                self.heat[HEATERS[number]] = value or 0.0
            elif number in (106, 107):
                self.fan = f"M106 S{255 if value is None else value:g}" if number == 106 else ""
            elif value is not None and number != 5:
                self.speed = f"S{value:g}"

    def _rise(self, motions: Motions, axis: int) -> None:
        """Where rapids went highest."""
        rapid = (motions.code == RAPID) & motions.target_known[axis]
        if rapid.any():
            top = float(motions.target[axis][rapid].max()) / TICKS_PER_MM
            self.highest = top if self.highest is None else max(self.highest, top)

    def _ways(self, motions: Motions, axis: int, called: list[int]) -> None:
        self.moved = self.moved or len(motions.code) > 0
        self._rise(motions, axis)
        way = np.where(
            motions.start_known[axis] & motions.target_known[axis],
            motions.target[axis] - motions.start[axis],
            0,
        )
        # How a rapid along the axis leads away from a cut tells on which side the work is open: OUT
        # of a mill's pocket or off a turned diameter, IN from the wall of a bore.
        calls = iter([*called, 1 << 62])  # the last one stands behind all blocks
        call = next(calls)
        for block, code, step in zip(
            motions.block.tolist(), motions.code.tolist(), way.tolist(), strict=True
        ):
            while block >= call:  # another tool: what the one before did says nothing
                self.left, self.cuts, call = "", False, next(calls)
            if code in (FEED, CLOCKWISE, COUNTER, SPLINE):
                self.cuts = True
            elif code == RAPID and self.cuts:
                self.left, self.cuts = OUT if step > 0 else IN if step < 0 else ALONG, False
        if call < 1 << 62:
            self.left, self.cuts = "", False
