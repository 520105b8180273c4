"""The options of a command as the text that its users read: one entry is the option, and all its
help.

    [how it is corrected]                   a group, and its description
    -o, --output FILE  where it is written  an option with a value
    --offset G54=X1 ...  where zeros are    one that may stand several times: its value is a list
    --quiet  no notices                     one without a value
    --ends (error|hold)  beyond a table     one of these words
    file? FILE  the program                 a place; ? none or one, * any number, + one or more

A line that begins with blanks goes on with the help above it."""

from __future__ import annotations

import argparse
import re
from typing import Any

ENTRY = re.compile(r"((?:--?\w+, )?--[\w-]+|\w+)([?*+]?)(?: (\S+))?( \.\.\.)?(?:  (.*))?")


def add(parser: argparse.ArgumentParser, text: str, **how: Any) -> None:
    """Give a parser the options of `text`. how: by the name of an option its type (a callable), its
    default, both as a tuple, or any keywords of argparse as a dictionary."""
    group: argparse._ActionsContainer = parser
    for line in re.sub(r"\n +", " ", text).splitlines():
        if line.startswith("["):
            title, _, description = line[1:].partition("]")
            group = parser.add_argument_group(title, description.strip() or None)
        elif line:
            _add(group, line, how)


def _add(group: argparse._ActionsContainer, line: str, how: dict[str, Any]) -> None:
    found = ENTRY.fullmatch(line)
    if found is None:
        raise ValueError(f"{line!r} is no option")
    heads, many, value, several, help = found.groups()
    names = heads.split(", ")
    given = how.get(names[-1].lstrip("-").replace("-", "_"), {})
    more = dict(given) if isinstance(given, dict) else _typed(given)
    if many:
        more["nargs"] = many
    if value and value.startswith("("):
        more["choices"] = tuple(value.strip("()").split("|"))
    elif value:
        more["metavar"] = value
    elif names[0].startswith("-") and not more.keys() & {"choices", "action"}:
        more["action"] = "store_true"
    if several:
        more |= {"action": "append", "default": []}
        help = f"{help}; repeatable"
    group.add_argument(*names, help=help, **more)


def _typed(given: Any) -> dict[str, Any]:
    if isinstance(given, tuple):
        return {"type": given[0], "default": given[1]}
    return {"type" if callable(given) else "default": given}
