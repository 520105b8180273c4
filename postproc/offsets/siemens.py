"""SINUMERIK's data files: frames and tool offsets as assignments to system variables, as the
control's archive has them.

    $P_UIFR[1]=CTRANS(X,10,Y,20):CFINE(X,0.01):CROT(Z,30)     G54; 0 is G500, 1 to 4 G54 to G57, 5
                                                              to 99 G505 to G599
    $P_UIFR[1,X,TR]=10    FI the fine part, RT rotation, SC scale, MI mirror
    $P_CHBFR[0], $P_UBFR (the same), $P_NCBFR[0]              basic frames, all chained: "EXT"
    $TC_DP3[t,d]=120.5    tool t, edge d: "T1D1"; 1 type, 3 to 5 length 1 to 3, 6 radius, 12 to 15
                          wear, 21 to 23 base

Coarse and fine, and geometry, wear and base, are added. Lengths are given to axes as in the basic
planes: length 1 2 3 is Z Y X in G17 for mills and drills, X Z Y in G18 for types 400 to 599,
turning and grinding. A frame that scales, mirrors or turns about X or Y can not be said as an
offset: it is left out with a notice (a basic frame is refused), so that a program that selects it
is refused too. X is a radius; where the user says diameter, X of turning tools is halved, as
MD20360 bit 0 and 1 have it. The unit is that of the control (MD10240), which the file does not
tell.

Sources: Siemens 840D programming guide advanced (PGA) 04.00, 6 and 8.1 ($P_UIFR, $TC_DP), SINUMERIK
ONE 6FC5398-2EP40 3.8.2.2 (TR FI RT SC MI) and 3.13.3.4 (lengths), 828D function manual K2 10.5.5.3
(basic frames), 802D sl W1 25.5.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from postproc.offsets import AXES, LINEAR, Offsets, Source

TITLE = "SINUMERIK data with $P_UIFR or $TC_DP"
LOOK = re.compile(r"\$(P_UIFR|P_CHBFR|P_NCBFR|P_UBFR|TC_DP[0-9]+)\b")
BLOCK = r"(?:N[0-9]+\s*)?"
ASSIGNMENT = re.compile(
    BLOCK + r"\$(P_UIFR|P_CHBFR|P_NCBFR|P_UBFR|TC_DP[0-9]{1,3})\s*(?:\[([^\]]*)\])?\s*=\s*(.*)"
)
OTHER = re.compile(BLOCK + r"(\$[A-Z].*=.*|%.*|M0*(2|17|30)|RET)")
CHANNEL = re.compile(BLOCK + r"CHANDATA\s*\(\s*([0-9]+)\s*\)")
FUNCTION = re.compile(r"(CTRANS|CFINE|CROT|CSCALE|CMIRROR)\s*\(([^()]*)\)")
COMPONENTS = {"CTRANS": "TR", "CFINE": "FI", "CROT": "RT", "CSCALE": "SC", "CMIRROR": "MI"}
NEUTRAL = {"SC": 1.0}
MILL, TURN = "ZYX", "XZY"  # axes of length 1 2 3 in G17 and G18
TURNING = range(400, 600)
# numbers of $TC_DP: geometry, wear and base of each length; of the radius geometry and wear
TYPE, RADII, LENGTHS = 1, (6, 15), ((3, 12, 21), (4, 13, 22), (5, 14, 23))
USED = {TYPE, *RADII, *(number for numbers in LENGTHS for number in numbers)}
ADVICE = "numbers only: a file that the control's archive holds, not a program that computes them"


@dataclass
class Frame:
    """The parts of a frame: component to axis to value, and the line that last wrote it."""

    parts: dict[str, dict[str, float]] = field(default_factory=dict)
    line: int = 0
    turned_first: bool = False  # whether a translation follows a rotation, scale or mirror

    def strange(self) -> bool:
        """Whether it is more than a translation and a turn about Z."""
        turn = {axis for axis, angle in self.parts.get("RT", {}).items() if angle}
        scale = any(
            v != NEUTRAL.get(c, 0.0) for c in ("SC", "MI") for v in self.parts.get(c, {}).values()
        )
        # a turn about Z alone is an offset with a rotation, unless the shift comes behind it
        return bool(turn - {"Z"}) or scale or (self.turned_first and bool(turn))


def recognises(source: Source) -> bool:
    """Whether a variable of a frame or of a tool's edge stands somewhere."""
    return any(LOOK.search(line.upper().partition(";")[0]) for _, line in source.lines())


def read(source: Source) -> Offsets:
    """Work offsets, their rotations about Z, "EXT", and tools by edge. Raises UsageError."""
    frames: dict[tuple[str, int], Frame] = {}
    edges: dict[tuple[int, int], dict[int, float]] = {}
    channel = ""
    for number, line in source.lines():
        text = line.upper().partition(";")[0].strip()
        # one channel's data: of two the same frame would stand twice, with other axes
        found, chandata = ASSIGNMENT.fullmatch(text), CHANNEL.fullmatch(text)
        if found and found[1].startswith("TC_DP"):
            _edge(source, number, int(found[1][5:]), found[2], found[3], edges)
        elif found:
            _frame(source, number, found[1], found[2], found[3], frames)
        elif chandata:
            if channel not in ("", chandata[1]):
                second = "offsets of a second channel begin here"
                raise source.fault(number, second, "keep the lines of one channel")
            channel = chandata[1]
        elif text and not OTHER.fullmatch(text):
            raise source.fault(number, "this is no assignment of offsets", ADVICE)
    offsets = Offsets(notices=source.unit_notice())
    _places(source, frames, offsets)
    _tools(source, edges, offsets)
    return offsets


def _indices(source: Source, number: int, text: str | None, count: int) -> list[int]:
    parts = [part.strip() for part in (text or "").split(",")]
    if len(parts) != count or not all(re.fullmatch(r"[0-9]{1,6}", part) for part in parts):
        raise source.fault(number, f"[{text or ''}] should be {count} whole numbers", ADVICE)
    return [int(part) for part in parts]


def _value(source: Source, number: int, text: str) -> float:
    # 1.5EX-3 is 1.5e-3 in this language
    return source.number(number, re.sub(r"(?<=[0-9.])EX(?=[-+0-9])", "E", text.strip()))


def _edge(
    source: Source,
    number: int,
    parameter: int,
    index: str | None,
    text: str,
    edges: dict[tuple[int, int], dict[int, float]],
) -> None:
    if parameter in USED:
        tool, edge = _indices(source, number, index, 2)
        edges.setdefault((tool, edge), {})[parameter] = _value(source, number, text)


def _frame(
    source: Source, number: int, variable: str, index: str | None, text: str, frames: dict[Any, Any]
) -> None:
    """A whole frame, or one component of one."""
    parts = [part.strip() for part in index.split(",")] if index is not None else []
    # $P_UBFR is $P_CHBFR[0]
    if variable == "P_UBFR":
        variable, parts = "P_CHBFR", ["0", *parts]
    which = _indices(source, number, ",".join(parts[:1]), 1)[0]
    if which > 99:
        raise source.fault(number, f"there is no frame {which}", ADVICE)
    if len(parts) == 1:
        frames[variable, which] = _whole(source, number, text)
        return
    if len(parts) != 3 or parts[2] not in COMPONENTS.values():
        raise source.fault(number, f"[{index}] is not a component like [1,X,TR]", ADVICE)
    frame = frames.setdefault((variable, which), Frame())
    frame.parts.setdefault(parts[2], {})[parts[1]] = _value(source, number, text)
    frame.line = number


def _whole(source: Source, number: int, text: str) -> Frame:
    """CTRANS(...):CFINE(...):CROT(...) and so on."""
    frame = Frame(line=number)
    for part in text.split(":"):
        function = FUNCTION.fullmatch(part.strip())
        if not function or COMPONENTS[function[1]] in frame.parts:
            raise source.fault(
                number, f"{part.strip()[:40]!r} can not be read, or stands twice", ADVICE
            )
        component = COMPONENTS[function[1]]
        # CROT before CTRANS: the shift would be along turned axes, which an offset can not say
        frame.turned_first |= component in ("TR", "FI") and bool(set(frame.parts) - {"TR", "FI"})
        frame.parts[component] = dict(_pairs(source, number, component, function[2]))
    return frame


def _pairs(source: Source, number: int, component: str, text: str) -> Iterator[tuple[str, float]]:
    """Axis and value; an axis of CMIRROR may stand alone."""
    words = [word.strip() for word in text.split(",")] if text.strip() else []
    i = 0
    while i < len(words):
        axis = words[i]
        if not re.fullmatch(r"[A-Z][A-Z0-9_]*", axis):
            raise source.fault(number, f"{axis[:40]!r} is not an axis", ADVICE)
        values = words[i + 1 : i + 2]
        # CMIRROR(X) has no value: the axis alone says that it is mirrored
        if component == "MI" and not (values and not re.match("[A-Z]", values[0])):
            yield axis, 1.0
            i += 1
            continue
        if not values:
            raise source.fault(number, f"the value of {axis} is missing", ADVICE)
        yield axis, _value(source, number, values[0])
        i += 2


def _places(source: Source, frames: dict[tuple[str, int], Frame], offsets: Offsets) -> None:
    """Frames to work offsets."""
    if source.diameter and frames:
        offsets.notices.append(
            "X of frames is read as a radius; MD20360 makes a diameter of tool lengths only"
        )
    for (variable, n), frame in frames.items():
        name = _name(variable, n)
        turn = frame.parts.get("RT", {}).get("Z", 0.0)
        if frame.strange() or (turn and name == "EXT"):
            if name == "EXT":
                raise source.fault(
                    frame.line,
                    "a basic frame scales, mirrors or turns",
                    "gcomp follows shifts of it only",
                )
            offsets.notices.append(f"{name} scales, mirrors or turns about X or Y: left out")
            continue
        _shift(source, name, frame, offsets)
        if turn:
            offsets.rotation[name] = turn


def _name(variable: str, n: int) -> str:
    """The work offset of a frame, as programs say it."""
    if variable != "P_UIFR":
        return "EXT"
    if not n:
        return "G500"
    return f"G{53 + n}" if n < 5 else f"G{500 + n}"


def _shift(source: Source, name: str, frame: Frame, offsets: Offsets) -> None:
    """Coarse and fine shifts of a frame into the offset of this name."""
    place = offsets.work.setdefault(name, {})
    for component in ("TR", "FI"):
        for axis, value in frame.parts.get(component, {}).items():
            if axis in AXES:
                one = source.scale() if axis in LINEAR else 1.0
                place[axis] = place.get(axis, 0.0) + value * one
            elif value:
                offsets.notices.append(
                    f"{name} shifts {axis} by {value:g}, no axis that gcomp knows: left out"
                )


def _tools(
    source: Source, edges: dict[tuple[int, int], dict[int, float]], offsets: Offsets
) -> None:
    """Edges to tools."""
    if any(TYPE not in edge for edge in edges.values()):
        offsets.notices.append("tools without a type ($TC_DP1) are read as mills: length 1 is Z")
    if edges:
        offsets.notices.append(
            "tool lengths are given to axes as in G17 for mills, G18 for turning tools"
        )
    for (tool, number), edge in edges.items():
        offsets.tools[f"T{tool}D{number}"] = _tool(source, edge)


def _tool(source: Source, edge: dict[int, float]) -> dict[str, float]:
    """mm: lengths by axis, and R, the radius."""
    turning = int(edge.get(TYPE, 0)) in TURNING
    # length 1 2 3 by axis: Z Y X in G17 of a mill, X Z Y in G18 of a lathe; each of geometry, wear
    # and base
    parts = zip((*(TURN if turning else MILL), "R"), (*LENGTHS, RADII), strict=True)
    place = {
        axis: sum(edge.get(n, 0.0) for n in numbers) * source.scale()
        for axis, numbers in parts
        if not edge.keys().isdisjoint(numbers)
    }
    if turning and source.diameter and "X" in place:
        place["X"] /= 2
    return place
