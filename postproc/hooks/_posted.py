"""For a program that runs nothing on what it writes: a script for the file, and a line for the folder that it posts into."""

from __future__ import annotations

import shlex

from postproc.hooks import Call, Installed, _script


def install(call: Call, name: str, where: str) -> Installed:
    """A script `name` that corrects files in place, and the line that corrects a whole folder. where: what to do in the program."""
    path = call.folder / f"{name}-{call.name}{'.bat' if call.windows else '.sh'}"
    batch = [
        call.python, "-m", "postproc", "batch", "POSTED", "--machine", call.machine, *call.options, "-o", "CORRECTED",
    ]  # fmt: skip
    return Installed(
        {path: (_script.in_place(call), True)},
        f"{where}:\n{path}\nor let it post into the folder POSTED, and correct what is new there into the folder CORRECTED with:\n"
        f"{shlex.join(batch)}",
    )
