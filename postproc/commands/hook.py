"""`gcomp hook install PROGRAM --machine M`: what a CAM program or slicer needs to run gcomp on what
it writes."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from postproc import hooks, intake, ports, standing
from postproc.commands import as_json, option_text, reading
from postproc.errors import UsageError
from postproc.machine import places

HELP = (
    "write what a slicer, CAM program or LinuxCNC needs to correct its programs: gcomp hook install"
    " prusaslicer"
)
FORMAT = "gcomp-hook/1"
HANDS_ON = True  # behind --: options of gcomp
EXAMPLE = "gcomp hook install prusaslicer --machine my-printer -- --tolerance 5um"


OPTIONS = f"""
what (list|install)  list the programs, or install a hook for one
program? PROGRAM  which one
--machine NAME  a machine by name (gcomp machines) or by the path of its folder
-o, --output FOLDER  where to write (default: the folder hooks in gcomp's own)
--keep  let the nominal program stay beside the corrected one as FILE.bak
--post NAME  FreeCAD's own post that is corrected (linuxcnc)
--force  write over a hook that is there
--json FILE  all of it as JSON ({FORMAT}); - for standard output
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, post="")


def run(options: argparse.Namespace) -> int:
    if options.what == "list":
        print(listed(), file=as_json.beside(options.json))
        found = [_fact(name) for name in hooks.names()]
        as_json.put(options.json, {"format": FORMAT, "hooks": found})
        return 0
    if not options.program:
        raise UsageError(
            "for which program?", f"gcomp hook install {'|'.join(hooks.names())} --machine NAME"
        )
    module = hooks.load(options.program)
    _checked(options)
    call = _call(options)
    installed = module.install(call)
    for path in installed.files:
        standing.kept(path, options.force, "--force writes over it, -o names another folder")
    for path, (text, runs) in installed.files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        ports.write_whole(path, text.encode("utf-8"))
        if runs:
            path.chmod(path.stat().st_mode | 0o111)
        print(f"gcomp: written: {path}", file=sys.stderr)
    print(installed.setting, file=as_json.beside(options.json))
    facts: dict[str, Any] = {**_fact(module.__name__.rpartition(".")[2]), "machine": call.machine}
    facts |= {"options": list(call.options), "written": [str(path) for path in installed.files]}
    as_json.put(options.json, {"format": FORMAT, **facts, "setting": installed.setting})
    return 0


def _fact(name: str) -> dict[str, str]:
    module = hooks.load(name)
    return {"program": name, "title": module.TITLE, "tried": module.TRIED}


def _call(options: argparse.Namespace) -> hooks.Call:
    from platformdirs import user_config_path

    folder = places.folder_of(options.machine).resolve()
    target = (
        Path(options.output)
        if options.output
        else user_config_path("gcomp", appauthor=False) / "hooks"
    )
    root = Path(__file__).resolve().parents[2]
    # The environment's own python, not what it is a link to: that one knows no numpy.
    return hooks.Call(
        os.path.abspath(sys.executable), str(root), str(folder), intake.label(folder.name),
        Path(os.path.abspath(target)), tuple(options.handed_on), options.keep, options.post,
        os.name == "nt",
    )  # fmt: skip


def _checked(options: argparse.Namespace) -> None:
    """Refuse now what would be refused each time the hook runs."""
    from postproc.commands import compensate

    parser = argparse.ArgumentParser(prog="gcomp", add_help=False, exit_on_error=False)
    compensate.arguments(parser)
    try:
        known, unknown = parser.parse_known_args(
            [*options.handed_on, "--machine", options.machine or ""]
        )
    except (argparse.ArgumentError, argparse.ArgumentTypeError) as error:
        raise UsageError(
            f"{' '.join(options.handed_on)}: {error}", "gcomp compensate --help lists the options"
        ) from None
    if unknown or known.file:
        raise UsageError(
            f"gcomp has no option {(unknown or [known.file])[0]}",
            "gcomp compensate --help lists the options",
        )
    if known.output or known.in_place or known.unbuffered or known.dry_run:
        raise UsageError("the hook says where the program goes", "--keep lets the nominal one stay")
    reading.machine_of(known)


def listed() -> str:
    """The programs, and with what each was tried."""
    width = max(map(len, hooks.names()))
    lines = []
    for name in hooks.names():
        module = hooks.load(name)
        lines += [f"{name:<{width}}  {module.TITLE}", f"{'':<{width}}  tried: {module.TRIED}"]
    return "\n".join(lines)
