"""Any program that runs another one on its file, or none at all: a script, and a folder to be
watched over."""

from __future__ import annotations

from postproc.hooks import Call, Installed, _posted

TITLE = "any other program: SolidCAM, VCarve"
TRIED = "the script, by tests/hooks"

WHERE = "where the program can run a script on the file that it has written"


def install(call: Call) -> Installed:
    """A script that corrects a file in place, and the line that corrects a whole folder."""
    return _posted.install(call, "gcomp", lambda path: f"{WHERE}:\n{path}", shows=True)
