"""Colour on a terminal: messages by what they are, and the help. None elsewhere, nor where NO_COLOR
is set (no-color.org)."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any, TextIO

from postproc.expressions import expression

RED, YELLOW, GREEN, CYAN, PLAIN = "\x1b[1;31m", "\x1b[33m", "\x1b[32m", "\x1b[36m", "\x1b[0m"
# The first that fits a line decides; what fits none stays as it is.
KINDS = (
    (expression(r"gcomp: warning"), YELLOW),
    (expression(r"gcomp: (?:verified|written|opened|\d+ motions)"), GREEN),
    (expression(r"gcomp: (?:notice|not in the map|\d+ of \d+)"), CYAN),
)


def wanted(stream: TextIO | None) -> bool:
    """Whether a stream is a terminal that shows colours, and nobody asked for none."""
    if stream is None or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    # a file, a pipe and a page of CI get the plain text, which other programs read
    return stream.isatty()


class Painted:
    """A text stream whose lines that begin with "gcomp:" have that word in a colour."""

    def __init__(self, stream: TextIO):
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """The text, line by line; how many characters of it."""
        self._stream.write("".join(_line(line) for line in text.splitlines(keepends=True)))
        return len(text)

    def fault(self, text: str) -> None:
        """The message of an error."""
        self._stream.write(f"{RED}gcomp:{PLAIN} {text}\n")


def _line(line: str) -> str:
    colour = next((colour for kind, colour in KINDS if kind.match(line)), "")
    return f"{colour}gcomp:{PLAIN}{line[6:]}" if colour else line


def fault(text: str) -> None:
    """The message of an error to standard error: gcomp, and its text."""
    if isinstance(sys.stderr, Painted):
        sys.stderr.fault(text)
    elif sys.stderr is not None:
        sys.stderr.write(f"gcomp: {text}\n")


class Unseen(argparse.HelpFormatter):
    """Where no help is asked for: of any width, so that nothing is loaded to find out which."""

    def __init__(self, prog: str):
        super().__init__(prog, width=80)


def formatter(stream: TextIO | None) -> type[argparse.HelpFormatter]:
    """What writes the help to a stream."""
    if not wanted(stream):
        return argparse.HelpFormatter
    # for help in colour alone: it loads rich
    from rich_argparse import RichHelpFormatter

    return RichHelpFormatter
