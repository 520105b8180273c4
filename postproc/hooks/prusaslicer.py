"""PrusaSlicer: runs a script on the file before it is saved or sent, and shows its message where it
fails.

Some versions take the whole line for the name of one program (PrusaSlicer's PostProcessor.cpp asked
whether a file of that name exists), others take it apart at spaces: a script without arguments and
without spaces suits both.
"""

from __future__ import annotations

from postproc.hooks import Call, Installed, _script

TITLE = "PrusaSlicer"
TRIED = "tests/hooks run Debian's PrusaSlicer 2.5 with it"
WHERE = "Print Settings > Output options > Post-processing scripts (expert mode)"


def install(call: Call) -> Installed:
    """A script, and its path to be entered."""
    path = call.folder / f"prusaslicer-{call.name}{'.bat' if call.windows else '.sh'}"
    return Installed({path: (_script.in_place(call), True)}, f"{WHERE}:\n{_script.one_word(path)}")
