"""Colour on a terminal: messages by what they are, and the help. None elsewhere, nor where NO_COLOR is set (no-color.org)."""

from __future__ import annotations

import argparse
import os
import re
from typing import Any, TextIO

RED, YELLOW, GREEN, CYAN, PLAIN = "\x1b[1;31m", "\x1b[33m", "\x1b[32m", "\x1b[36m", "\x1b[0m"
# The first that fits a line decides; what fits none is the message of an error.
KINDS = (
    (re.compile(r"gcomp: (?:warning|in doubt|NOT WITHIN|verified: NOT)"), YELLOW),
    (re.compile(r"gcomp: (?:verified|written|opened|\d+ motions)"), GREEN),
    (re.compile(r"gcomp: (?:notice|not in the map|\d+ of \d+)"), CYAN),
)


def wanted(stream: TextIO | None) -> bool:
    """Whether a stream is a terminal that shows colours, and nobody asked for none."""
    if stream is None or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    return stream.isatty()


class Painted:
    """A text stream whose lines that begin with "gcomp:" have that word in a colour."""

    def __init__(self, stream: TextIO):
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        self._stream.write("".join(_line(line) for line in text.splitlines(keepends=True)))
        return len(text)


def _line(line: str) -> str:
    if not line.startswith("gcomp: "):
        return line
    colour = next((colour for kind, colour in KINDS if kind.match(line)), RED)
    return f"{colour}gcomp:{PLAIN}{line[6:]}"


def formatter(stream: TextIO | None) -> type[argparse.HelpFormatter]:
    """What writes the help to a stream."""
    if not wanted(stream):
        return argparse.HelpFormatter
    from rich_argparse import RichHelpFormatter

    return RichHelpFormatter
