"""What GRBL and grblHAL answer to `$#`: `[G54:0.000,0.000,0.000]`, `[G92:...]`, `[TLO:...]`, one in
a line.

The axes come in the order X Y Z A B C U V W. Three decimals are mm and four inches ($13), unless
the user says it. X is a radius; grblHAL writes it doubled while G7 is in force, which the report
does not tell: then say that X is a diameter. A place is program word + offset + G92 + tool length.
The tool length is one for all, as G43.1 sets it: "G43.1".

Source: GRBL 1.1, grbl/report.c (report_ngc_parameters, report_realtime_status), config.h
(N_DECIMAL_COORDVALUE_MM, _INCH).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from postproc.offsets import AXES, ROTARY, Offsets, Source
from postproc.units import MM_PER_INCH

TITLE = "GRBL's answer to $#"
LOOK = re.compile(r"\[G5[4-9](\.[1-3])?:[^\]]*\]")
ENTRY = re.compile(r"\[([A-Z][A-Z0-9.]*)(?::([^\]]*))?\]", re.IGNORECASE)
WORK = re.compile(r"G5[4-9]|G59\.[1-3]|G92|TLO")
TALK = re.compile(r"ok|>+|<.*>|>*\s*\$.*|Grbl .*", re.IGNORECASE)
TOOL = "G43.1"
ADVICE = "a line is like: [G54:0.000,0.000,0.000]"


def recognises(source: Source) -> bool:
    """Whether a line is the answer for a work offset."""
    return any(LOOK.fullmatch(line) for _, line in source.lines())


def read(source: Source) -> Offsets:
    """Work offsets, "G92", and the tool length as tool "G43.1". G28, G30 and the probe are no
    offsets.

    Raises UsageError.
    """
    offsets = Offsets()
    entries = list(_entries(source))
    # the first value is X, a length: angles of rotary axes have three decimals in either unit
    scale = _scale(source, [values[0] for *_, values in entries], offsets)
    for number, name, texts in entries:
        # GRBL reports one tool length, along Z; grblHAL one for each axis
        axes = "Z" if name == "TLO" and len(texts) == 1 else AXES
        place = _place(source, number, axes, texts, scale)
        into, key = (offsets.tools, TOOL) if name == "TLO" else (offsets.work, name)
        if key in into:
            raise source.fault(
                number, f"{name} stands twice", "give one answer of the control, the latest"
            )
        into[key] = place
    return offsets


def _entries(source: Source) -> Iterator[tuple[int, str, list[str]]]:
    """Line, name and values of every offset. Raises UsageError."""
    for number, line in source.lines():
        entry = ENTRY.fullmatch(line)
        if entry and WORK.fullmatch(entry[1].upper()):
            yield number, entry[1].upper(), (entry[2] or "").split(",")
        elif not entry and not TALK.fullmatch(line):
            raise source.fault(number, "this is no line of GRBL's answer to $#", ADVICE)


def _place(
    source: Source, number: int, axes: str, texts: list[str], scale: float
) -> dict[str, float]:
    """mm by axis; scale: mm of a number. Raises UsageError."""
    if len(texts) > len(axes):
        raise source.fault(number, f"{len(texts)} values, for {len(axes)} axes at most", ADVICE)
    place = {}
    for axis, text in zip(axes, texts, strict=False):
        value = source.number(number, text.strip()) * (1.0 if axis in ROTARY else scale)
        place[axis] = value / 2 if axis == "X" and source.diameter else value
    return place


def _scale(source: Source, texts: list[str], offsets: Offsets) -> float:
    """mm per unit, as the user or the decimals of the first axis say (angles have three always)."""
    if source.inch is None:
        # $13 is not in the answer, but the decimals are fixed by it: 3 of mm, 4 of inches
        # (config.h)
        decimals = {len(text.strip().partition(".")[2]) for text in texts}
        if decimals == {4}:
            offsets.notices.append(
                "four decimals: lengths are read as inches, as GRBL writes them with $13=1"
            )
            return MM_PER_INCH
        if decimals != {3}:
            offsets.notices.extend(source.unit_notice())
    return source.scale()
