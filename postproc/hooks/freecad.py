"""FreeCAD (Path, CAM): a post-processor that runs one of FreeCAD's own and corrects what it wrote.

FreeCAD finds posts by their name in the folder of macros. Up to 0.21 a post writes the file itself,
later ones are asked with "-" for the text alone: both come out corrected, or an error is raised and
no file is left.
"""

from __future__ import annotations

from postproc.hooks import Call, Installed, _script

TITLE = "FreeCAD: a post-processor beside its own"
TRIED = "tests/hooks run Debian's FreeCAD 0.20 with it"

POST = '''"""Corrects what FreeCAD's {post} post writes, for the machine {name}. Written by gcomp hook install."""

import importlib
import os
import subprocess

import FreeCAD

for home in ("Path.Post.scripts", "PathScripts.post"):
    try:
        own = importlib.import_module(home + ".{post}_post")
        break
    except ImportError:
        own = None
if own is None:
    raise ImportError("FreeCAD has no post called {post}")

COMMAND = {command!r}
ROOT = {root!r}
TOOLTIP = "The {post} post, corrected for {name} by gcomp"
TOOLTIP_ARGS = getattr(own, "TOOLTIP_ARGS", "")


def corrected(text):
    """The corrected program; raises with gcomp's message where there is none."""
    environment = {{k: v for k, v in os.environ.items() if k not in {unset!r}}}
    environment["PYTHONPATH"] = ROOT
    done = subprocess.run(COMMAND, input=text.encode("utf-8"), capture_output=True, env=environment)
    said = done.stderr.decode("utf-8", "replace").strip()
    if done.returncode:
        FreeCAD.Console.PrintError(said + "\\n")
        raise RuntimeError(said)
    if said:
        FreeCAD.Console.PrintMessage(said + "\\n")
    return done.stdout.decode("utf-8")


def export(objectslist, filename, argstring):
    """What FreeCAD calls."""
    text = own.export(objectslist, filename, argstring)
    if filename == "-":
        return corrected(text)
    with open(filename, encoding="utf-8", newline="") as file:
        nominal = file.read()
    os.remove(filename)
    text = corrected(nominal)
    with open(filename, "w", encoding="utf-8", newline="") as file:
        file.write(text)
{keep}    return text
'''  # noqa: E501
KEEP = """    with open(filename + ".bak", "w", encoding="utf-8", newline="") as file:
        file.write(nominal)
"""


def install(call: Call) -> Installed:
    """A post-processor, and where it goes."""
    post = call.post or "linuxcnc"
    text = POST.format(
        post=post, name=call.name, command=_script.command(call), root=call.root,
        unset=_script.UNSET, keep=KEEP if call.keep else "",
    )  # fmt: skip
    # FreeCAD lists a post by a file name that ends in _post.py
    path = call.folder / f"gcomp_{post}_post.py"
    return Installed(
        {path: (text, False)},
        f"copy {path} into FreeCAD's folder of macros (Edit > Preferences > General > Macro), or"
        f" install with -o THAT_FOLDER;\nin the job's Output choose the processor: gcomp_{post}",
    )
