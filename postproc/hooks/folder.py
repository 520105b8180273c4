"""Any program that runs another one on its file, or none at all (Fusion, Mastercam): a script, and a folder to be watched over."""

from __future__ import annotations

import shlex

from postproc.hooks import Call, Installed, _script

TITLE = "any other program: Fusion, Mastercam, SolidCAM, VCarve"
TRIED = "the script, by tests/hooks; no setting of these programs that runs it is known to us"


def install(call: Call) -> Installed:
    """A script that corrects a file in place, and the line that corrects a whole folder."""
    path = call.folder / f"gcomp-{call.name}{'.bat' if call.windows else '.sh'}"
    batch = [
        call.python,
        "-m",
        "postproc",
        "batch",
        "POSTED",
        "--machine",
        call.machine,
        *call.options,
        "-o",
        "CORRECTED",
    ]
    return Installed(
        {path: (_script.in_place(call), True)},
        f"where the program can run a script on the file that it has written:\n{path}\n"
        f"where it can not, let it write into a folder, and correct what is new there with:\n{shlex.join(batch)}",
    )
