"""LinuxCNC: a filter that the screen runs when a program is opened. It shows standard error where
the filter fails."""

from __future__ import annotations

from postproc.hooks import Call, Installed, _script

TITLE = "LinuxCNC (AXIS, QtDragon, gmoccapy): [FILTER]"
TRIED = (
    "tests/hooks run LinuxCNC 2.9's AXIS with it, under Xvfb: it opens the corrected program, and"
    " shows why a program is refused; QtDragon and gmoccapy were not tried"
)
ENDINGS = ("ngc", "nc", "tap")


def install(call: Call) -> Installed:
    """A script, and lines for the machine's INI file."""
    path = call.folder / f"linuxcnc-{call.name}.sh"
    lines = [
        "[FILTER]",
        (
            f"PROGRAM_EXTENSION = {','.join('.' + e for e in ENDINGS)} Program, corrected for"
            f" {call.name} by gcomp"
        ),
        *(f"{ending} = {path}" for ending in ENDINGS),
    ]
    return Installed(
        # [FILTER] runs the script with the file's name, and opens what it writes to standard output
        {path: (_script.to_output(call, "--filter-progress"), True)},
        "the machine's INI file:\n" + "\n".join(lines),
    )
