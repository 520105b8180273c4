"""Offsets as controls and people keep them in files: where work zeros lie and how long tools are.

A format is a module here, found by its name: TITLE says what it is, recognises(source) whether a
text looks like it, read(source) reads it. Readers get text and open nothing. They refuse a line
that they can not read, and whatever a file leaves open (its unit, whether X is a diameter) comes
back as a notice.
"""

from __future__ import annotations

import importlib
import math
import pkgutil
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from types import ModuleType

from postproc.errors import Place, UsageError
from postproc.units import LARGEST_WORD_MM, MM_PER_INCH

LINEAR, ROTARY = "XYZUVW", "ABC"
AXES = "XYZABCUVW"  # in the order in which LinuxCNC and grblHAL write them
NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]{1,3})?")
WORK_NAME = re.compile(r"G5[4-9]|G59\.[1-3]|G500|G50[5-9]|G5[1-9][0-9]|G92|G52|G30|EXT|E[0-9]{1,2}")
EXTENDED_NAME = re.compile(r"(G54\.1\s*P|G15\s*H|G247\s*P)\s*0*([1-9][0-9]{0,2})")
TOOL_NAME = re.compile(r"([HD])0*([1-9][0-9]{0,3})|T[0-9]{1,6}(D[0-9]{1,4})?")
KNOWN_NAMES = (
    "G54 to G59, G59.1 to G59.3, G54.1 P1, G15 H1, G247 P1, G505 to G599, G92, G52, G30, EXT,"
    " E1; tools: T0101, T1, T1D1, H1, D1"
)
NO_UNIT = "the file does not say its unit: lengths are read as mm"
BINARY = "give the file that the control punched or saved as text"


@dataclass
class Offsets:
    """What a file says. All lengths mm, X a radius, angles degrees, as the control adds them to
    programmed places.

    work: name to axis to mm ("G54", "G59.1", "G54.1 P3", "G505", "G92" where in force; "EXT": the
    offset common to all).
    tools: name to axis to mm, "R" the radius and "Q" the number of a lathe tool's
    orientation ("H1": {"Z": length}, "D1": {"R": radius}, "T1", "T0101", "T1D1").
    rotation: work offset to degrees about Z. notices: what was assumed or left out. format: the
    reader's name.
    """

    work: dict[str, dict[str, float]] = field(default_factory=dict)
    tools: dict[str, dict[str, float]] = field(default_factory=dict)
    rotation: dict[str, float] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)
    format: str = ""

    def of(self, axes: Collection[str]) -> Offsets:
        """The same for a machine that has only these axes; what is dropped and not zero is said in
        a notice."""
        notices = list(self.notices)

        def kept(places: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
            for name, place in places.items():
                notices.extend(
                    f"{name} states {axis} = {value:g}, an axis that the machine has not: left out"
                    for axis, value in place.items()
                    if value and axis not in "RQ" and axis not in axes
                )
            return {
                n: {a: v for a, v in place.items() if a in "RQ" or a in axes}
                for n, place in places.items()
            }

        return Offsets(kept(self.work), kept(self.tools), dict(self.rotation), notices, self.format)


@dataclass(frozen=True)
class Source:
    """A file's text, and what its user says of it.

    inch: whether its lengths are inches, diameter: whether the control stores X as diameters; None:
    not said.
    """

    name: str
    text: str
    inch: bool | None = None
    diameter: bool | None = None

    def lines(self) -> Iterator[tuple[int, str]]:
        """Number (from 1) and text of every line that is not blank, without the blanks around
        it."""
        # by \n alone: splitlines() would also cut at form feeds, and lines would count otherwise
        # than in an editor
        for number, line in enumerate(self.text.split("\n"), 1):
            if stripped := line.strip():
                yield number, stripped

    def fault(self, line: int, message: str, advice: str) -> UsageError:
        """The error to raise at a line."""
        text = self.text.split("\n")[line - 1].strip()[:1000]
        return UsageError(message, advice, Place(self.name, line, text))

    def number(self, line: int, text: str) -> float:
        """A finite number. Raises UsageError."""
        # float() would take nan, inf and 1_0
        value = float(text) if NUMBER.fullmatch(text) else math.nan
        if not abs(value) <= LARGEST_WORD_MM:
            raise self.fault(
                line,
                f"{text[:40]!r} is not a number, or too large for a machine",
                "correct or drop it",
            )
        return value

    def scale(self) -> float:
        """mm per unit of length, where the file itself does not say it."""
        return MM_PER_INCH if self.inch else 1.0

    def unit_notice(self) -> list[str]:
        """What to tell where the unit was not named."""
        return [NO_UNIT] if self.inch is None else []


def canonical(name: str) -> str | None:
    """An offset's name as Offsets writes it ("g54.1p03" is "G54.1 P3"), or None where there is no
    such offset."""
    name = name.strip().upper()
    if extended := EXTENDED_NAME.fullmatch(name):
        return f"{extended[1][:-1].strip()} {extended[1][-1]}{extended[2]}"
    if WORK_NAME.fullmatch(name):
        return name
    if tool := TOOL_NAME.fullmatch(name):
        return f"{tool[1]}{tool[2]}" if tool[1] else name
    return None


def names() -> list[str]:
    """Names of the formats that there are."""
    return sorted(module.name.replace("_", "-") for module in pkgutil.iter_modules(__path__))


def load(name: str) -> ModuleType:
    """The reader called `name`. Raises UsageError with the names that there are."""
    if name not in names():
        raise UsageError(
            f"there is no offset file format {name!r}", f"formats: {', '.join(names())}"
        )
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")


def read(
    text: bytes,
    name: str,
    format: str | None = None,
    inch: bool | None = None,
    diameter: bool | None = None,
) -> Offsets:
    """Read an offset file's bytes; `name` is what errors call it.

    format: one of names(), None: recognised by what stands in the text. inch: whether lengths are
    inches where the file does not say it itself; None: mm, with a notice. diameter: whether the
    control stores X of these offsets as a diameter (not whether programs are written so); None: as
    the format's module says, with a notice where it matters. Raises UsageError, with the line where
    there is one, for anything that is not such a file.
    """
    source = Source(name, _decoded(text, name), inch, diameter)
    if format is None:
        format = _recognised(source)
    offsets: Offsets = load(format).read(source)
    offsets.format = format
    # a file without any offset is the wrong file: read as none it would put every zero at the
    # machine's
    if not offsets.work and not offsets.tools:
        raise UsageError(
            f"{name}: no offset stands in this {load(format).TITLE}", f"formats: {_titles()}"
        )
    return offsets


def _recognised(source: Source) -> str:
    found = [name for name in names() if load(name).recognises(source)]
    if len(found) == 1:
        return found[0]
    # two readers that both see themselves in it: guessing would put zeros into the wrong register
    if found:
        raise UsageError(f"{source.name} may be {' or '.join(found)}", "name the format")
    raise UsageError(
        f"{source.name} is not an offset file that gcomp knows", f"formats: {_titles()}"
    )


def _titles() -> str:
    return "; ".join(f"{name} ({load(name).TITLE})" for name in names())


def _decoded(data: bytes, name: str) -> str:
    """Text of a file that a control, an editor or a serial line wrote. Raises UsageError for what
    is none."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        try:
            text = data.decode("utf-16")
        except UnicodeDecodeError:
            raise UsageError(f"{name} is not text", BINARY) from None
    else:
        # Reader control codes (DC1 to DC4), the end mark of DOS, and a tape's leader are no text
        # and say nothing.
        # a control that punched to a tape sends leader and reader codes along
        data = data.strip(b"\0").translate(None, b"\x11\x12\x13\x14\x1a")
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")  # comments in an old code page
    if strange := re.search(r"[^\t\n\r\x20-\x7e\x80-\U0010ffff]", text):
        line = text.count("\n", 0, strange.start()) + 1
        raise UsageError(f"character {ord(strange[0])} is not text", BINARY, Place(name, line))
    return text
