"""[tool_point] of machine.toml: what the control's tool centre point mode is set to on this
machine."""

from __future__ import annotations

import re
from dataclasses import field

from postproc.machine.toml_file import Section, TomlFile
from postproc.records import record

KEYS = {"frame", "planes", "on", "off", "at_start"}
FRAMES = ("zero", "call")


@record
class ToolPoint:
    """frame: where the tables stand while the axes of the program's frame are the machine's:
    "zero", at zero; "call", where they stand when the mode is called; "": as the control does.
    planes: the same of tilted planes. codes: M numbers that switch the mode on (True) and off;
    at_start: whether it is on when a program begins."""

    frame: str = ""
    planes: str = ""
    codes: dict[int, bool] = field(default_factory=dict)
    at_start: bool = False


def read_tool_point(toml: TomlFile) -> ToolPoint:
    """The section, or what holds without it."""
    section = toml.section("tool_point")
    section.check_keys(KEYS)
    frames = {key: section.string(key, "") for key in ("frame", "planes")}
    for key in (key for key, frame in frames.items() if frame not in ("", *FRAMES)):
        raise section.fault(
            key,
            f"{key} = {frames[key]!r}",
            "where the tables stand while X Y Z of the program are "
            'the machine\'s: "zero", or "call", as they stand when the mode is called',
        )
    codes = dict.fromkeys(_codes(section, "on"), True)
    codes |= dict.fromkeys(_codes(section, "off"), False)
    return ToolPoint(**frames, codes=codes, at_start=section.flag("at_start"))


def _codes(section: Section, key: str) -> list[int]:
    """The M codes of a key. Raises MachineError for what is none."""
    words = section.get(key, [])
    found = []
    for word in words if isinstance(words, list) else [words]:
        if not isinstance(word, str) or not re.fullmatch(r"M\d{1,4}", word):
            raise section.fault(key, f"{key} = {words!r}", f'M codes, like {key} = ["M428"]')
        found.append(int(word[1:]))
    return found
