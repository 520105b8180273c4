"""The way back into a program that was interrupted: what is in force before a line, and the blocks that bring it about.

The lines before are read again by the filter itself (nothing of them is sent), so what is in force is what the control would
hold. Then: safe Z in machine coordinates first, over the place, spindle and coolant on and up to speed, down at a feed, the
program's own modal state, and on with the line. What can not be brought back so is refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from postproc.errors import Place, ProgramError, UsageError
from postproc.filter import Filter
from postproc.motions import RAPID, Motions
from postproc.nc.lexer import Words
from postproc.nc.state import NONE
from postproc.units import MM_PER_INCH, TICKS_PER_MM

PLUNGE = 200.0  # mm/min at most, down to where the cut begins
SPIN_UP = 4.0  # s
FIRST_CYCLE = 730
MOTION_CODE = re.compile(rb"G0*[0-3](?![0-9.])", re.IGNORECASE)
MOVES = re.compile(rb"[XYZABCUVWIJKR] *[-+.0-9]", re.IGNORECASE)
COMMENT = re.compile(rb"\([^()\n]*\)|;[^\n]*")


@dataclass
class Before:
    """What holds before the line: spindle, coolant, tool as words; feed: mm/min of the last F, which stays what it was when the
    units change; inch: whether words are inches; highest: mm, the highest Z of a rapid so far."""

    spindle: str = "M5"
    speed: str = ""
    coolant: list[str] = field(default_factory=list)
    tool: str = ""
    feed: float = 0.0
    inch: bool = False
    highest: float | None = None

    def watch(self, words: Words, motions: Motions, axis: int) -> None:
        """Take a batch's M, S and T words, and where its rapids end along the axis that lifts the tool."""
        values = [int(m) / 10 ** int(d) for m, d in zip(words.mantissa, words.decimals, strict=True)]
        named = list(zip(words.block.tolist(), map(chr, words.letter), values, strict=True))
        units = {block: value == 20 for block, name, value in named if name == "G" and value in (20, 21)}
        for block, name, value in named:
            self.inch = units.get(block, self.inch)
            if name == "F":
                self.feed = value * (MM_PER_INCH if self.inch else 1.0)
            elif name == "S":
                self.speed = f"S{value:g}"
            elif name == "T":
                self.tool = f"T{value:g}"
            elif name == "M" and value in (3, 4, 5):
                self.spindle = f"M{value:g}"
            elif name == "M" and value in (7, 8):
                self.coolant = sorted({*self.coolant, f"M{value:g}"})
            elif name == "M" and value == 9:
                self.coolant = []
        rapid = (motions.code == RAPID) & motions.target_known[axis]
        if rapid.any():
            top = float(motions.target[axis][rapid].max()) / TICKS_PER_MM
            self.highest = top if self.highest is None else max(self.highest, top)


def read_before(filter_: Filter, lines: Iterable[bytes], line: int) -> tuple[Before, bytes]:
    """Let a fresh filter read the lines before `line`; gives what holds there, and the line itself with what follows up to
    the next motion. Raises UsageError, ProgramError."""
    if "Z" not in filter_.setup.axes or "Y" not in filter_.setup.axes:
        raise UsageError(
            f"{filter_.machine.name} is no mill with X, Y and Z: gcomp does not know which way is safe there",
            "bring the tool to a safe place by hand, and send the rest as a program of its own",
        )
    axis = filter_.setup.axes.index("Z")
    before = Before(inch=filter_.modal.codes.get("units") == 200)
    filter_.watchers.append(lambda words, motions, *_: before.watch(words, motions, axis))
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
        raise UsageError(f"line {line} is beyond the program's {number} lines", "name an earlier line")
    return before, b"".join(rest)


def refuse(filter_: Filter, rest: bytes, line: int) -> None:
    """Raises ProgramError where a job can not safely begin with this line. `filter_` has read all before it."""
    modal = filter_.modal
    frame = modal.frame

    def no(message: str, advice: str) -> ProgramError:
        text = rest.split(b"\n", 1)[0].decode("latin-1")
        return ProgramError(f"the job can not begin again here: {message}", advice, Place(filter_.name, line, text))

    earlier = "name an earlier line, before that begins"
    if modal.ended:
        raise no("the program has ended before this line", "name an earlier line")
    if modal.cutting_beside or modal.codes.get("cutter", NONE) in filter_.dialect.beside:
        raise no("cutter radius compensation (G41, G42) is on", earlier)
    if modal.cycle is not None or (modal.codes.get("motion", NONE) >= FIRST_CYCLE and modal.codes["motion"] != 800):
        raise no("a canned cycle is in force", earlier)
    moving = [i for i, x in enumerate(filter_.setup.axes) if x in "XYZ"]
    unknown = [filter_.setup.axes[i] for i in moving if not modal.known[i]]
    if unknown:
        relative = " in incremental distance (G91)" if modal.codes.get("distance") == 910 else ""
        raise no(
            f"where {', '.join(unknown)} stands before it is not known{relative}",
            "name a line behind a block that says it",
        )
    if not modal.zero_known:
        raise no("where the program's zero lies is not known", "state it: --offset, --start")
    if frame is not None and ((frame.preset_on and frame.preset.any()) or frame.local.any() or frame.trans.any()):
        raise no("the program has shifted its zero (G92, G52) by where the machine stood", earlier)
    if modal.offsets:
        raise no(
            f"the program has written offsets ({', '.join(modal.offsets)}) that may not be what the controller has now",
            earlier,
        )
    motion = modal.codes.get("motion", NONE)
    first = next((t for t in rest.split(b"\n") if MOVES.search(COMMENT.sub(b"", t))), b"")
    if motion in (20, 30) and not MOTION_CODE.search(COMMENT.sub(b"", first)):
        raise no("it goes on with an arc whose G2 or G3 stands in a line before", "name the line that has the G code")


def preamble(filter_: Filter, before: Before, safe_z: float | None = None) -> list[bytes]:
    """The blocks that bring it about, in the program's language. safe_z: mm, machine coordinates; None: the highest place
    that a rapid of the program has reached. Raises UsageError."""
    modal, dialect, setup = filter_.modal, filter_.dialect, filter_.setup
    top = before.highest if safe_z is None else safe_z
    if top is None:
        raise UsageError(
            "no rapid before this line says which Z is safe", "say it: --safe-z 0, mm, machine coordinates"
        )
    origin = modal.origin if modal.origin is not None else np.zeros_like(modal.position)
    place = {x: (modal.position[i] - origin[i]) / TICKS_PER_MM for i, x in enumerate(setup.axes)}
    stands = modal.position[setup.axes.index("Z")] / TICKS_PER_MM
    if stands > top + 1e-9:
        raise UsageError(
            f"safe Z {top:g} is below where the program stands, Z {stands:.3f} (mm, machine coordinates)",
            "--safe-z higher",
        )

    def word(group: str, default: str = "") -> str:
        number = modal.codes.get(group, NONE)
        return dialect.by_number[number].word if number in dialect.by_number else default

    lines = ["G21 G90 G17 G94"]
    if word("work offset"):
        lines.append(word("work offset"))
    length = modal.frame.length if modal.frame is not None else np.zeros(0, np.int64)
    if length.any():
        others = [x for i, x in enumerate(setup.axes) if length[i] and x != "Z"]
        if others or 431 not in dialect.by_number:
            raise UsageError("a tool length is in force that gcomp can not restore", "name a line before it is called")
        lines.append(f"G43.1 Z{length[setup.axes.index('Z')] / TICKS_PER_MM:.4f}")
    lines.append(f"G53 G0 Z{top:.4f}")
    across = [x for x in setup.axes if x != "Z"]
    lines.append("G0 " + " ".join(f"{x}{place[x]:.4f}" for x in across))
    if before.tool:
        lines.append(before.tool)
    if before.spindle != "M5":
        lines += [f"{before.spindle} {before.speed}".strip(), f"G4 P{SPIN_UP:g}"]
    lines += before.coolant
    feed = before.feed
    per_minute = modal.codes.get("feed mode", 940) == 940
    down = min(PLUNGE, feed) if feed and per_minute else PLUNGE
    lines.append(f"G1 Z{place['Z']:.4f} F{down:g}")
    if feed and per_minute and feed != down:
        lines.append(f"F{feed:g}")
    lines.append(f"{word('plane', 'G17')} {word('units', 'G21')} {word('distance', 'G90')} {word('feed mode', 'G94')}")
    if modal.codes.get("motion", NONE) in (0, 10):
        lines.append(word("motion"))
    return [line.encode() for line in lines]
