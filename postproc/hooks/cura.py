"""Cura: a script of its post-processing plugin, which gives the layers of a program as texts.

Cura goes on with the program as it was where a script raises an error
(PostProcessingPlugin.execute): so a program that is refused is replaced by the message, as
comments, and printed by no printer.
"""

from __future__ import annotations

from postproc.hooks import Call, Installed, _script

TITLE = "Cura: a script of Modify G-Code"
TRIED = "the script itself, by tests/hooks, with stand-ins for Cura's two classes; not in Cura"

SCRIPT = '''"""Corrects a program for the machine {name}. Written by gcomp hook install."""

import json
import os
import subprocess

from ..Script import Script

COMMAND = {command!r}
ROOT = {root!r}


class Gcomp(Script):
    """Last in the list: what comes after it is not corrected."""

    def getSettingDataString(self):
        return json.dumps(
            {{"name": "gcomp: correct for {name}", "key": "Gcomp", "metadata": {{}}, "version": 2, "settings": {{}}}}
        )

    def execute(self, data):
        environment = {{k: v for k, v in os.environ.items() if k not in {unset!r}}}
        environment["PYTHONPATH"] = ROOT
        hidden = {{"creationflags": 0x08000000}} if os.name == "nt" else {{}}
        text = "".join(data).encode("utf-8")
        done = subprocess.run(COMMAND, input=text, capture_output=True, env=environment, **hidden)
        if done.returncode:
            said = done.stderr.decode("utf-8", "replace").strip()
            self.tell(said)
            return ["".join("; " + line + "\\n" for line in ["NOT CORRECTED, NOTHING TO PRINT", *said.splitlines()])]
        return [done.stdout.decode("utf-8")]

    def tell(self, said):
        """Show the message in Cura's window."""
        try:
            from UM.Message import Message
        except ImportError:
            return
        Message(said, title="gcomp: the program is refused").show()
'''  # noqa: E501


def install(call: Call) -> Installed:
    """A script, and where it goes."""
    text = SCRIPT.format(
        name=call.name,
        command=_script.command(call, "--quiet"),
        root=call.root,
        unset=_script.UNSET,
    )
    # Cura looks for a class that is called as the file
    path = call.folder / "Gcomp.py"
    return Installed(
        {path: (text, False)},
        f"copy {path} into the folder scripts of Cura's configuration folder (Help > Show"
        " Configuration Folder), start Cura again;\nExtensions > Post Processing > Modify G-Code >"
        " Add a script: gcomp, as the last one",
    )
