"""LinuxCNC's tool table (`tool.tbl`): `T1 P1 Z+0.511 D0.125 ;1/8 end mill`, a tool in a line.

T the number, P the pocket, X to W the offset per axis, D the diameter, I J Q angles and orientation
of a lathe tool, a remark behind `;`. Lengths are machine units: [TRAJ]LINEAR_UNITS of the INI file.
X is a radius, on lathes too: the interpreter halves a diameter before it stores it.

Source: LinuxCNC, src/emc/tooldata/tooldata_common.cc (tooldata_read_entry);
docs/src/gcode/tool-compensation.adoc.
"""

from __future__ import annotations

import re

from postproc.offsets import AXES, ROTARY, Offsets, Source

TITLE = "LinuxCNC tool table"
LOOK = re.compile(r"T[0-9]+\s+P[0-9]+(\s+[A-Z][-+.0-9]+)*\s*(;.*)?", re.IGNORECASE)
WORD = re.compile(r"([TPXYZABCUVWDIJQ])(\S+)", re.IGNORECASE)
ADVICE = "a line is like: T1 P1 X0 Z+0.511 D0.125 ;remark"


def recognises(source: Source) -> bool:
    """Whether a line begins with a tool and its pocket and has only words behind them."""
    return any(LOOK.fullmatch(line) for _, line in source.lines())


def _words(source: Source, number: int, line: str) -> dict[str, str]:
    """The words of a line by letter. Raises UsageError."""
    values: dict[str, str] = {}
    for text in line.split():
        word = WORD.fullmatch(text)
        if not word:
            raise source.fault(number, f"{text[:40]!r} is no word of a tool table", ADVICE)
        letter = word[1].upper()
        if letter in values:
            raise source.fault(number, f"{letter} stands twice", ADVICE)
        values[letter] = word[2]
    return values


def read(source: Source) -> Offsets:
    """Tools by number, "T1" with the axes that stand there R, half of D, and Q. Raises
    UsageError."""
    offsets = Offsets(notices=source.unit_notice())
    if source.diameter:
        offsets.notices.append("LinuxCNC stores X as a radius: it is read as one")
    for number, line in source.lines():
        values = _words(source, number, line.partition(";")[0])
        if not values:
            continue
        tool = values.get("T", "")
        if not re.fullmatch(r"[0-9]{1,6}", tool):
            raise source.fault(number, "the tool's number is missing", ADVICE)
        name = f"T{int(tool)}"
        if name in offsets.tools:
            raise source.fault(number, f"tool {name} stands twice", "keep the one that is true")
        offsets.tools[name] = _place(source, number, values)
    return offsets


def _place(source: Source, number: int, words: dict[str, str]) -> dict[str, float]:
    """mm by axis, R and Q, of the words of a line. Raises UsageError."""
    values = {letter: source.number(number, text) for letter, text in words.items()}
    place = {
        axis: values[axis] * (1.0 if axis in ROTARY else source.scale())
        for axis in AXES
        if axis in values
    }
    if "D" in values:
        # D is a diameter in every table of LinuxCNC; R of Offsets is a radius
        place["R"] = values["D"] * source.scale() / 2
    if values.get("Q"):
        place["Q"] = values["Q"]
    return place
