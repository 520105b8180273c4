"""For a program that shows nothing of what a script says: a script for the file that it has posted,
and a line for the folder that it posts into."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

from postproc.hooks import Call, Installed, _script

REFUSED = "A file that is refused becomes FILE.not-corrected, and FILE.refused.txt says why.\n"


def install(call: Call, name: str, where: Callable[[Path], str], shows: bool = False) -> Installed:
    """A script `name` that corrects files in place, and the line that corrects a whole folder.
    where(path of the script): what to do in the program; shows: whether it shows a message."""
    path = call.folder / f"{name}-{call.name}{'.bat' if call.windows else '.sh'}"
    batch = [call.python, "-m", "postproc", "batch", "POSTED", "--machine", call.machine]
    batch += [*call.options, "-o", "CORRECTED"]
    # A program that shows no message would leave the nominal file there as if it had been
    # corrected.
    script = _script.in_place(call) if shows else _script.in_place_or_away(call)
    return Installed(
        {path: (script, True)},
        f"{where(path)}\n{'' if shows else REFUSED}or let it post into the folder POSTED, and"
        f" correct what is new there into the folder CORRECTED with:\n{shlex.join(batch)}",
    )
