"""The script that a program with windows runs: this gcomp, this machine, and nothing of that
program's own Python."""

from __future__ import annotations

import shlex
from collections.abc import Callable

from postproc.errors import UsageError
from postproc.hooks import Call, Installed

# AppImages set both for themselves, and another Python does not start with them.
UNSET = ("PYTHONHOME", "LD_LIBRARY_PATH")


def command(call: Call, *more: str) -> list[str]:
    """gcomp with its machine and options."""
    return [call.python, "-m", "postproc", "--machine", call.machine, *call.options, *more]


def in_place(call: Call) -> str:
    """A script that corrects the file which is named last, or leaves it as it is and ends with a
    message."""
    if call.windows:
        goes = "--in-place" if call.keep else '--force -o "%~1"'
        words = " ".join(f'"{word}"' for word in command(call, "--quiet"))
        return (
            f"@echo off\r\nrem gcomp for {call.name}: corrects the file that is named.\r\nset"
            " PYTHONHOME=\r\n"
            f'set "PYTHONPATH={call.root}"\r\n{words} {goes} -- "%~1"\r\n'
        )
    goes = "--in-place" if call.keep else '--force -o "$file"'
    return _shell(
        call,
        "corrects the file that is named last; a file that is refused stays as it is",
        # "for file; do :; done" leaves the last argument in $file: slicers put theirs before it
        '[ $# -gt 0 ] || { echo "which file?" >&2; exit 2; }\nfor file; do :; done\n',
        f'{shlex.join(command(call, "--quiet"))} {goes} -- "$file"',
    )


def in_place_or_away(call: Call) -> str:
    """As `in_place`, for a program that shows nothing: a file that is refused goes out of the way,
    as FILE.not-corrected, with the message in FILE.refused.txt, so that nobody runs it unaware."""
    words = command(call, "--quiet")
    if call.windows:
        line = " ".join(f'"{word}"' for word in words)
        goes = "--in-place" if call.keep else '--force -o "%~1"'
        return "\r\n".join(
            [
                "@echo off",
                f"rem gcomp for {call.name}: corrects the file that is named, or moves it away.",
                "set PYTHONHOME=",
                f'set "PYTHONPATH={call.root}"',
                f'{line} {goes} -- "%~1" 2> "%~1.refused.txt"',
                "if errorlevel 1 (",
                '  move /Y "%~1" "%~1.not-corrected" > nul',
                '  type "%~1.refused.txt" 1>&2',
                "  exit /b 2",
                ")",
                'del "%~1.refused.txt"',
                "",
            ]
        )
    goes = "--in-place" if call.keep else '--force -o "$file"'
    return (
        f"#!/bin/sh\n# gcomp for {call.name}: corrects the file that is named last, or moves it"
        " away. Written by gcomp hook install.\n"
        '[ $# -gt 0 ] || { echo "which file?" >&2; exit 2; }\nfor file; do :; done\n'
        f"unset {' '.join(UNSET)}\nPYTHONPATH={shlex.quote(call.root)}\nexport PYTHONPATH\n"
        f'said=$({shlex.join(words)} {goes} -- "$file" 2>&1) && exit 0\nstatus=$?\n'
        # away first: whatever fails below, the uncorrected program is no longer where it is looked
        # for
        'mv -- "$file" "$file.not-corrected"\n'
        'printf "%s\\n" "$said" | tee "$file.refused.txt" >&2\nexit $status\n'
    )


def to_output(call: Call, *more: str) -> str:
    """A script that writes the corrected program to standard output."""
    return _shell(
        call,
        "writes the corrected program to standard output",
        "",
        f'{shlex.join(command(call, *more))} -- "$@"',
    )


def _shell(call: Call, what: str, before: str, line: str) -> str:
    return (
        f"#!/bin/sh\n# gcomp for {call.name}: {what}. Written by gcomp hook install.\n{before}unset"
        f" {' '.join(UNSET)}\nPYTHONPATH={shlex.quote(call.root)}\nexport PYTHONPATH\nexec {line}\n"
    )


def at_a_setting(program: str, where: str) -> Callable[[Call], Installed]:
    """install() of a slicer with a setting for scripts. Some versions take the whole line for the
    name of one program (PrusaSlicer's PostProcessor.cpp asked whether a file of that name exists),
    others take it apart at spaces: a script without arguments and without spaces suits both."""

    def install(call: Call) -> Installed:
        path = call.folder / f"{program}-{call.name}{'.bat' if call.windows else '.sh'}"
        return Installed({path: (in_place(call), True)}, f"{where}:\n{one_word(path)}")

    return install


def one_word(path: object) -> str:
    """A path that a program takes apart at spaces. Raises UsageError for one with spaces in it."""
    if any(c.isspace() for c in str(path)):
        raise UsageError(
            f"{path} has a space in it, and the slicer takes a command apart there",
            "-o names a folder without one",
        )
    return str(path)
