"""`gcomp machines` lists the machines; `show NAME` says what one is, `new NAME` makes one, `check
NAME` doubts it."""

from __future__ import annotations

import argparse

from postproc import ports
from postproc.commands import as_json, machine_facts, machine_new, option_text
from postproc.commands.machine_shown import show
from postproc.errors import GcompError, UsageError
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.machine.lacks import lacks
from postproc.machine.model import Machine
from postproc.machine.plausibility import implausible

HELP = "list the machines, show one, make a new one, or check one: gcomp machines show NAME"
EXAMPLE = (
    "gcomp machines new my-router --kind router --control grbl --travel X=0,600 --travel Y=0,400"
    " --travel Z=-80,0 --diagonals XY=500.3,499.8,400,300"
)
DOUBTFUL = 1  # exit status of check where something is in doubt


OPTIONS = f"""
what? (list|show|new|check)
name? NAME
--report FILE.html  with show: a page with every table, the squareness and the volume
--json FILE  all of it as JSON ({machine_facts.FORMAT}); - for standard output
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, what="list")
    machine_new.arguments(parser)


def run(options: argparse.Namespace) -> int:
    if options.what == "new":
        return _new(options)
    if options.what in ("show", "check"):
        if not options.name:
            raise UsageError("which machine?", f"gcomp machines {options.what} NAME")
        machine = places.load(options.name)
        return (_show if options.what == "show" else _check)(machine, options)
    if options.report:
        raise UsageError(
            "--report draws one machine", "gcomp machines show NAME --report FILE.html"
        )
    return _list(options)


def _list(options: argparse.Namespace) -> int:
    found = places.every()
    width = max((len(name) for name in found), default=0)
    rows = []
    for name, path in found.items():
        fault = None
        try:
            title = read_machine(path).title
        except GcompError as error:
            title, fault = f"can not be used: {error.message}", error.message
        rows.append(
            {"name": name, "title": None if fault else title, "path": str(path), "fault": fault}
        )
        print(f"{name:<{width}}  {title}  [{path}]", file=as_json.beside(options.json))
    as_json.put(options.json, machine_facts.document(rows))
    return 0


def _show(machine: Machine, options: argparse.Namespace) -> int:
    if options.report:
        from postproc.pages import machine as pages

        ports.write_whole(options.report, pages.page(machine).html().encode("utf-8"))
    print(show(machine), file=as_json.beside(options.json))
    as_json.put(options.json, machine_facts.document([machine_facts.of(machine)]))
    return 0


def _new(options: argparse.Namespace) -> int:
    from postproc.commands.calibrate import write_folder

    path, texts = machine_new.made(options)
    kept = write_folder(path, texts, options.force)
    machine = read_machine(path)
    out = as_json.beside(options.json)
    print(show(machine), file=out)
    as_json.put(options.json, machine_facts.document([machine_facts.of(machine)]))
    print(
        f"\nwritten: {path}{kept}; next: gcomp job.nc --machine"
        f" {path if options.output else options.name} --verify",
        file=out,
    )
    return 0


def _check(machine: Machine, options: argparse.Namespace) -> int:
    """What is doubtful, then what is not measured. Returns DOUBTFUL where something is in doubt."""
    as_json.put(options.json, machine_facts.document([machine_facts.of(machine)]))
    out = as_json.beside(options.json)
    findings = implausible(machine)
    for text in findings:
        print(f"in doubt: {text}", file=out)
    for text in lacks(machine):
        print(f"not in this map: {text}", file=out)
    if not machine.offsets:
        print(
            "to know: no work offsets are stated: --offset G54=X..,Y..,Z.. says them, or [offsets]"
            " in machine.toml",
            file=out,
        )
    if not findings:
        print(f"{machine.name}: nothing in it is doubtful", file=out)
    return DOUBTFUL if findings else 0
