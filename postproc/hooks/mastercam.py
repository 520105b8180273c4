"""Mastercam: a script that is run on the posted file, or on the folder that it is posted into."""

from __future__ import annotations

from postproc.hooks import Call, Installed, _posted

TITLE = "Mastercam"
TRIED = "the script, by tests/hooks; Mastercam itself was not tried, and no setting of it that runs a script on the posted file is known to us"


def install(call: Call) -> Installed:
    """A script that corrects the posted file, and the line for the folder that it is posted into."""
    return _posted.install(
        call,
        "mastercam",
        "drop the file that Mastercam has posted onto this script, or run the script on it",
    )
