"""`gcomp man`: the manual page, made of the commands' own options. `gcomp man | man -l -` shows
it."""

from __future__ import annotations

import argparse
import importlib

from postproc import __version__
from postproc.commands import completion

HELP = "write the manual page: gcomp man | man -l -"
EXAMPLE = "gcomp man > ~/.local/share/man/man1/gcomp.1"
STATUS = (
    ("0", "done"),
    (
        "1",
        (
            "the surroundings failed (a full disk, a file that can not be read), or machines check"
            " found a doubt"
        ),
    ),
    ("2", "refused: the message says where, what, and the way out; nothing was written"),
    ("10 to 17", "a streamed job ended early: see docs/STREAMING.md"),
    ("130", "interrupted"),
    ("141", "the reader of the output is gone"),
)
ENVIRONMENT = (
    ("NO_COLOR", "no colour on a terminal"),
    ("XDG_CONFIG_HOME", "where the folder gcomp/machines of the user's own machines lies"),
    ("TMPDIR", "where what is not yet whole waits, if it is larger than 4 MB"),
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """It has none."""


def run(options: argparse.Namespace) -> int:
    print(page(), end="")
    return 0


def page() -> str:
    """The page in troff's man macros."""
    from postproc.cli import DEFAULT

    lines = [
        f'.TH GCOMP 1 "" "gcomp {__version__}" "User Commands"',
        ".SH NAME",
        "gcomp \\- make an inaccurate CNC machine cut accurately, by rewriting its programs",
        ".SH SYNOPSIS",
        ".B gcomp",
        "[\\fIoptions\\fR] [\\fIFILE\\fR]",
        ".br",
        ".B gcomp",
        "\\fICOMMAND\\fR [\\fIoptions\\fR] ...",
        ".SH DESCRIPTION",
        _text(
            "Reads an NC program, follows it as the control would, looks every point up in the"
            " machine's measured error map, and writes a corrected program. Nothing leaves before"
            " the whole program is accepted. Without a command it corrects: standard input, or"
            " FILE, to standard output."
        ),
    ]
    for name, (help_, parser) in completion.parsers().items():
        lines += [
            f'.SH "{"GCOMP" if name == DEFAULT else f"GCOMP {name.upper()}"}"',
            _text(help_ + "."),
        ]
        lines += [part for action in parser._actions for part in _option(action)]
        example = getattr(importlib.import_module(f"postproc.commands.{name}"), "EXAMPLE", "")
        if example:
            lines += [".PP", "Example:", ".PP", ".RS", ".nf", _text(example), ".fi", ".RE"]
    for title, rows in (("EXIT STATUS", STATUS), ("ENVIRONMENT", ENVIRONMENT)):
        lines.append(f'.SH "{title}"')
        lines += [
            part for key, text in rows for part in (".TP", f"\\fB{_text(key)}\\fR", _text(text))
        ]
    lines += [
        ".SH FILES",
        ".TP",
        "\\fImachines/NAME/machine.toml\\fR",
        _text(
            "a machine, in the working folder, in the user's configuration, or installed with gcomp"
        ),
    ]
    return "\n".join(lines) + "\n"


def _value(action: argparse.Action) -> str:
    """What an option takes: its name, or what can be chosen."""
    if isinstance(action.metavar, str):
        return action.metavar
    return "|".join(map(str, action.choices or ())) or action.dest.upper()


def _option(action: argparse.Action) -> list[str]:
    if action.help == argparse.SUPPRESS or "--help" in action.option_strings:
        return []
    value = _value(action)
    takes = "" if action.nargs == 0 else f" \\fI{_text(value)}\\fR"
    if not action.option_strings:
        head = f"\\fI{_text(value)}\\fR"
    else:
        head = ", ".join(f"\\fB{_text(o)}\\fR" for o in action.option_strings) + takes
    said = (action.help or "").replace("%%", "%") or (
        f"one of {', '.join(map(str, action.choices))}" if action.choices else ""
    )
    return [".TP", head, _text(said) or "\\&"]


def _text(text: str) -> str:
    """For troff: a backslash, a minus and a dot at the begin of a line are no commands."""
    plain = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{plain}" if plain.startswith((".", "'")) else plain
