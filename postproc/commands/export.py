"""`gcomp export` writes a machine's map as the control's own compensation table, and reads one
back."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from postproc import control_tables, intake, ports
from postproc.commands import as_json, residual
from postproc.commands.export_files import (
    FORMAT,
    axis_files,
    components,
    controls,
    held,
    known_of,
    listing,
    of_control,
    of_tables,
    places_of,
    report,
    split_notices,
    write_files,
)
from postproc.commands.export_options import arguments as arguments
from postproc.control_tables import ErrorTable, ExportOptions
from postproc.errors import UsageError
from postproc.machine import overshoot, places
from postproc.machine.chain import XYZ
from postproc.machine.marginals import marginals, pose_of
from postproc.machine.model import Machine
from postproc.recordings import Source
from postproc.units import UM

HELP = "write a machine's map as the control's own compensation table, or read such a table"
EXAMPLE = "gcomp export --machine studer-s36 --control linuxcnc -o tables/"


def run(options: argparse.Namespace) -> int:
    options.component = [
        *options.component,
        *(name.strip() for name in options.only if name.strip()),
    ]
    if options.list:
        print(listing(options.control), file=as_json.beside(options.json))
        as_json.put(options.json, {"format": FORMAT, "controls": controls(options.control)})
        return 0
    if not options.control:
        raise UsageError(
            "--control is missing: whose table?", f"controls: {', '.join(control_tables.names())}"
        )
    module = control_tables.load(options.control)
    if bool(options.read) == bool(options.machine):
        raise UsageError("either --machine M is written, or --read FILE is read", EXAMPLE)
    if options.read:
        return _read(options, module)
    if not options.output:
        raise UsageError(
            "-o is missing: where to write?", "-o FOLDER, or -o FILE where it is only one"
        )
    return _write(options, module, places.load(options.machine))


def _takes_whole(options: argparse.Namespace, module: Any) -> bool:
    """Whether the control takes the map as one. Raises UsageError where a rest of it is asked
    for."""
    whole = hasattr(module, "write_machine") and not (options.axis or options.component)
    if options.residual and whole:
        raise UsageError(
            f"{options.control} takes the whole map, so nothing is left for --residual",
            "leave --residual out, or --axis",
        )
    return whole


def _write(options: argparse.Namespace, module: Any, machine: Machine) -> int:
    """A map as the control's table, with what it leaves and its U where they are asked for."""
    tables, notices = _chosen(options, machine)
    how = what_to_write(options, module, machine)
    whole = _takes_whole(options, module)
    export = module.write_machine(machine, how) if whole else module.write(tables, how)
    if options.residual:
        rest = residual.held(options.control, machine, export, how, tables)
    # Places of all files are looked at before the first is written: none or all of them.
    beside = _uncertainty(options, machine, [t for t in tables if whole or held(t, export)])
    paths = places_of(
        export.files, Path(options.output), options.force, options.output.endswith(("/", "\\"))
    )
    said_of_rest = []
    if options.residual:
        said_of_rest = [
            residual.write(
                options.control,
                machine,
                options.machine,
                Path(options.residual),
                export,
                rest,
                options.force,
            )
        ]
    write_files(paths)
    write_files(beside)
    if whole:  # it is not written component by component
        tables, notices = [], []
    doubts = overshoot.found(machine, "".join(t.moving for t in tables))
    loud, said = split_notices(module, [*doubts, *notices, *export.notices])
    rows = components(tables, export, {t.name: known_of(machine, t) for t in tables})
    out = as_json.beside(options.json)
    text = report(options.control, module, machine, rows, said, loud, list(paths))
    print(text, *said_of_rest, sep="\n", file=out)
    found = {
        **of_control(options.control, module), "machine": machine.name, "map": machine.digest,
        "components": rows, "notices": said, "unverified": loud,
        "written": list(map(str, (*paths, *beside))), "residual": options.residual,
    }  # fmt: skip
    as_json.put(options.json, {"format": FORMAT, **found})
    return 0


def _uncertainty(
    options: argparse.Namespace, machine: Machine, tables: list[ErrorTable]
) -> dict[Path, bytes]:
    """The file of the U of what is written, none where it is not asked for. Raises UsageError where
    the folder states none, or the file is there."""
    if not options.uncertainty:
        return {}
    rows = [
        f"{t.name},{node:g},{value / UM:.4f}"
        for t in tables
        if (u := known_of(machine, t)) is not None
        for node, value in zip(t.nodes, u, strict=True)
    ]
    if not rows:
        raise UsageError(
            f"--uncertainty: {machine.name} states no uncertainty of what is written",
            "gcomp machines show says what it states",
        )
    text = (
        f"# U, 95 % (k = 2), of the tables for {options.control}; map"
        f" {machine.digest}\ncomponent,position_mm,U_um\n"
    )
    data = (text + "\n".join(rows) + "\n").encode()
    return places_of({"U": data}, Path(options.uncertainty), options.force, False)


def _chosen(options: argparse.Namespace, machine: Machine) -> tuple[list[ErrorTable], list[str]]:
    """The machine's one-axis tables that were asked for, and notices about them."""
    tables, left = _tables(options, machine)
    kept = {t.name for t in tables}
    notices = [
        notice
        for x in sorted({t.moving for t in tables})
        for notice in _notices(options, machine, x, kept)
    ]
    if options.axis or options.component:
        left = [n for n in left if not re.match(r"E[XYZ][XYZ] ", n) or n[:3] in kept]
    return tables, [*notices, *left]


def _tables(options: argparse.Namespace, machine: Machine) -> tuple[list[ErrorTable], list[str]]:
    """Those that were asked for, and what no table of one axis holds. Raises UsageError for an axis
    or a component that there is not."""
    for x in [*options.axis, *options.at]:
        if x not in machine.axes:
            raise UsageError(
                f"{machine.name} has no axis {x}", f"axes: {' '.join(machine.letters)}"
            )
    found, left = marginals(machine, options.at)
    tables = [ErrorTable(*m) for m in found]
    have = [t.name for t in tables]
    for name in options.component:
        if name not in have:
            raise UsageError(
                f"{machine.name} has no component {name} along a single axis",
                f"components: {', '.join(have) or 'none'}",
            )
    return _asked(options, tables), left


def _asked(options: argparse.Namespace, tables: list[ErrorTable]) -> list[ErrorTable]:
    """Those of the axes and components that are named; where none is named all."""
    return [
        t
        for t in tables
        if (not options.axis or t.moving in options.axis)
        and (not options.component or t.name in options.component)
    ]


def _notices(
    options: argparse.Namespace, machine: Machine, x: str, names: set[str]
) -> Iterator[str]:
    """Of the tables over axis x: where the others stand, what squareness they hold, and what the
    words of x are. names: of the tables."""
    pose, others = pose_of(machine, x, options.at), {*machine.chain.axes} - {x}
    if stand := [f"{o} = {p:g}" for o, p in pose.items() if o in others]:
        yield f"over {x}: the other axes stand at {' '.join(stand)} (--at)"
    if x in machine.square and machine.square[x].any():
        across = names.intersection(f"E{o}{x}" for o in XYZ if o != x)
        yield from (f"{name} holds the squareness of {x} as a line" for name in sorted(across))
    if x in machine.diameter:
        yield (
            f"words of {x} are diameters; positions and values here are slide positions,"
            " radius: make sure that the table of the control is too"
        )


def _extra(options: argparse.Namespace, module: Any, machine: Machine | None) -> dict[str, Any]:
    """What one control alone asks for. Raises UsageError."""
    extra = _settings(options, module)
    if machine is not None:
        extra.setdefault("axes", "".join(x for x in machine.letters if x in XYZ))
    if options.template:
        extra["template"] = _text(options.template)
    if options.settings:
        extra["settings"], extra["settings_name"] = _text(options.settings), options.settings
    if machine is None and options.axis:
        extra["axis"] = options.axis[0]
    return extra


def what_to_write(
    options: argparse.Namespace, module: Any, machine: Machine | None = None
) -> ExportOptions:
    """What the command line says, for the control's module. Raises UsageError for a --set that the
    control does not know."""
    extra = _extra(options, module, machine)
    if any(v != int(v) for v in options.first.values()):
        raise UsageError("--first is the number of a point, without a fraction", "--first X=1")
    return ExportOptions(
        unit=options.unit, spacing=options.spacing, reference=options.reference,
        first={x: int(v) for x, v in options.first.items()}, step=options.step,
        two_way=not options.one_way, program=intake.label(machine.name) if machine else "gcomp",
        rest=bool(options.residual), extra=extra,
    )  # fmt: skip


def _settings(options: argparse.Namespace, module: Any) -> dict[str, str]:
    """What --set says. Raises UsageError for a key that the control does not know, or needs and is
    not told."""
    found: dict[str, str] = {}
    known = getattr(module, "EXTRA", {})
    patterns = [re.sub(r"_[A-Z]$", "_[A-Z]", key) for key in known]
    for pair in options.extra:
        key, sign, value = pair.partition("=")
        if not sign or not any(re.fullmatch(p, key) for p in patterns):
            raise UsageError(
                f"--set {pair}: {options.control} has no such key",
                f"keys: {', '.join(known) or 'none'} (gcomp export --list --control"
                f" {options.control})",
            )
        found[key] = value
    for key, why in getattr(module, "STATED", {}).items():
        if key not in found:
            raise UsageError(f"--set {key}=... is not said, and {options.control} needs it", why)
    return found


def _text(path: str) -> str:
    return Source(path, ports.read_whole(Path(path), intake.CONTROL_TABLE)).text


def _read(options: argparse.Namespace, module: Any) -> int:
    """What a control's table takes out, to standard output, or to a file for each axis."""
    tables = read(options, module)
    found = axis_files(tables, options.read, options.control)
    out, paths = as_json.beside(options.json), {}
    if options.output:
        folder = options.output.endswith(("/", "\\"))
        files = {f"{moving}.csv": text.encode() for moving, text in found.items()}
        paths = places_of(files, Path(options.output), options.force, folder)
        write_files(paths)
        print("\n".join(f"wrote {path}" for path in paths), file=out)
    else:
        print("\n".join(found.values()), end="", file=out)
    how = {**of_control(options.control, module), "read": options.read}
    how |= {"tables": of_tables(tables), "written": [str(path) for path in paths]}
    as_json.put(options.json, {"format": FORMAT, **how})
    return 0


def read(options: argparse.Namespace, module: Any) -> list[ErrorTable]:
    """What a control's table takes out. Raises UsageError where it is nothing that was asked
    for."""
    source = Source(options.read, ports.read_whole(Path(options.read), intake.CONTROL_TABLE))
    tables = _asked(options, module.read(source, what_to_write(options, module)))
    if not tables:
        raise UsageError(
            f"{options.read} has no table of"
            f" {' '.join([*options.axis, *options.component]) or 'any axis'}"
        )
    return tables
