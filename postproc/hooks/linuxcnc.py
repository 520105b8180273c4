"""LinuxCNC: a filter that the screen runs when a program is opened. It shows standard error where the filter fails."""

from __future__ import annotations

from postproc.hooks import Call, Installed, _script

TITLE = "LinuxCNC (AXIS, QtDragon, gmoccapy): [FILTER]"
TRIED = "the filter's contract, by tests/hooks: program on standard output, FILTER_PROGRESS on standard error, status 2 and a message"
ENDINGS = ("ngc", "nc", "tap")


def install(call: Call) -> Installed:
    """A script, and lines for the machine's INI file."""
    path = call.folder / f"linuxcnc-{call.name}.sh"
    lines = [
        "[FILTER]",
        f"PROGRAM_EXTENSION = {','.join('.' + e for e in ENDINGS)} Program, corrected for {call.name} by gcomp",
        *(f"{ending} = {path}" for ending in ENDINGS),
    ]
    return Installed(
        {path: (_script.to_output(call, "--filter-progress"), True)},
        "the machine's INI file:\n" + "\n".join(lines),
    )
