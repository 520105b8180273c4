"""Mastercam: a script that is run on the posted file, or on the folder that it is posted into."""

from __future__ import annotations

from postproc.hooks import Call, Installed, _posted

TITLE = "Mastercam"
TRIED = (
    "untried in Mastercam itself; the script was run by tests/hooks; no setting of it that runs a"
    " script on the posted file is known to us"
)


def install(call: Call) -> Installed:
    """A script that corrects the posted file, and the line for the folder that it is posted
    into."""
    where = "Drop the file that Mastercam has posted onto {0}, or run that on it."
    return _posted.install(call, "mastercam", lambda path: where.format(path))
