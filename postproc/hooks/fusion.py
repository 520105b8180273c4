"""Autodesk Fusion: its posts are JavaScript, and a post may run a program on the file that it has
written.

onTerminate() is called when the file is closed; getOutputPath() names it, and execute(path,
arguments, hide, folder) runs a program and waits: so Autodesk's own posts start their setup sheets
and simulations (hsmworks-posts, redirect.cps; the posts for NCSIMUL and Visual Studio Code).
"""

from __future__ import annotations

import json
from pathlib import Path

from postproc.hooks import Call, Installed, _posted

TITLE = "Autodesk Fusion"
TRIED = (
    "untried in Fusion itself; the script was run by tests/hooks; the lines for its post follow"
    " posts of Autodesk's own (hsmworks-posts, redirect.cps)"
)
POST = """In a copy of your post (Manufacture > Manage > Post Library), at its end:
function onTerminate() {{
  execute({path}, "\\"" + getOutputPath() + "\\"", true, "");
}}
If it has an onTerminate already, put the line with execute there. Without it: drop the posted file
onto {plain}, or run that on it."""


def install(call: Call) -> Installed:
    """A script that corrects the posted file, and the lines that let a post run it."""

    def where(path: Path) -> str:
        # a JSON string is a JavaScript one: backslashes of a Windows path are doubled
        return POST.format(path=json.dumps(str(path)), plain=path)

    return _posted.install(call, "fusion", where)
