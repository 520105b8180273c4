"""Autodesk Fusion: its post-processors write a file and show it; a script is run on that file, or on the folder of the NC program."""

from __future__ import annotations

from postproc.hooks import Call, Installed, _posted

TITLE = "Autodesk Fusion"
TRIED = "the script, by tests/hooks; Fusion itself was not tried, and no setting of it that runs a script on the posted file is known to us"


def install(call: Call) -> Installed:
    """A script that corrects the posted file, and the line for the folder that NC programs are posted into."""
    return _posted.install(
        call,
        "fusion",
        "drop the file that Fusion has posted onto this script, or run the script on it",
    )
