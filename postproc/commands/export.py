"""`gcomp export` writes a machine's map as the control's own compensation table, and reads one back."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from postproc import control_tables, ports
from postproc.commands import residual
from postproc.control_tables import ErrorTable, Export, ExportOptions
from postproc.errors import UsageError
from postproc.machine import overshoot, places
from postproc.machine.chain import XYZ
from postproc.machine.marginals import marginals, pose_of
from postproc.machine.model import Machine
from postproc.recordings import Source
from postproc.units import UM

HELP = "write a machine's map as the control's own compensation table, or read such a table"
EXAMPLE = "gcomp export --machine studer-s36 --control linuxcnc -o tables/"
LARGEST_FILE = 1 << 24
FROM_OPTIONS = {
    "axis",
    "axes",
    "template",
    "settings",
    "settings_name",
}  # keys of `extra` that have an option of their own
PAIR = re.compile(r"\s*([A-Z])\s*=\s*([-+]?[0-9]+\.?[0-9]*|[-+]?\.[0-9]+)\s*")


def arguments(parser: argparse.ArgumentParser) -> None:
    what = parser.add_argument_group("what")
    what.add_argument(
        "--list",
        action="store_true",
        help="the controls, their sign, and what is unverified; with --control its own keys",
    )
    what.add_argument("--control", metavar="NAME", help="whose table: gcomp export --list")
    what.add_argument(
        "--machine", metavar="M", help="name or folder of the machine whose map is written"
    )
    what.add_argument(
        "--read",
        metavar="FILE",
        help="the opposite: say what a control's table takes out, as CSV (-o writes a file for each axis)",
    )
    what.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        help="where to write: a folder, or a file where it is only one",
    )
    what.add_argument(
        "--residual",
        metavar="FOLDER",
        help="a machine folder too, for what the control can not hold: gcomp corrects the rest",
    )
    what.add_argument("--force", action="store_true", help="overwrite files that are there")
    which = parser.add_argument_group("which part of the map")
    which.add_argument(
        "--axis",
        metavar="Z",
        action="append",
        default=[],
        help="only this moving axis; may be repeated",
    )
    which.add_argument(
        "--component",
        metavar="EXZ",
        action="append",
        default=[],
        help="only this component; may be repeated",
    )
    which.add_argument(
        "--only",
        metavar="EXX,EZZ",
        type=lambda text: text.split(","),
        default=[],
        help="as --component, several at once",
    )
    which.add_argument(
        "--at",
        metavar="X=0,Y=100",
        type=_numbers,
        default={},
        help="mm: where the other axes stand (rotations times arms)",
    )
    which.add_argument(
        "--one-way",
        action="store_true",
        help="the mean of both directions, also where the control knows both",
    )
    how = parser.add_argument_group("how the control is set up")
    how.add_argument(
        "--unit", choices=("mm", "inch"), default="mm", help="of the control's basic system (mm)"
    )
    how.add_argument(
        "--spacing",
        metavar="MM",
        type=_positive,
        default=0.0,
        help="mm between points, where they are even",
    )
    how.add_argument(
        "--reference",
        metavar="X=0,Z=0",
        type=_numbers,
        default={},
        help="mm: reference (home) position of the axes",
    )
    how.add_argument(
        "--first",
        metavar="X=1",
        type=_numbers,
        default={},
        help="number of the first or the reference point",
    )
    how.add_argument(
        "--step",
        metavar="MM",
        type=_positive,
        default=0.001,
        help="mm of one detection unit (0.001)",
    )
    how.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        dest="extra",
        help="what one control alone wants; may be repeated",
    )
    how.add_argument(
        "--uncertainty", metavar="FILE.csv", help="write the U (95 %%) of what the tables hold beside them, node by node: no control has a place for it"
    )  # fmt: skip
    how.add_argument(
        "--template",
        metavar="FILE",
        help="an empty table that the control has exported, to be filled",
    )
    how.add_argument(
        "--settings",
        metavar="FILE",
        help="with --read: the control's parameters, where they are in a file of their own",
    )


def _numbers(text: str) -> dict[str, float]:
    """Axis to number, from "X=0,Z=12.5"."""
    result: dict[str, float] = {}
    for part in text.split(","):
        found = PAIR.fullmatch(part)
        if not found or found[1] in result:
            raise argparse.ArgumentTypeError(f"{text!r} is not like X=0,Z=12.5: {part.strip()!r}")
        result[found[1]] = float(found[2])
    return result


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value <= 1e5:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of mm above zero")
    return value


def run(options: argparse.Namespace) -> int:
    options.component = [
        *options.component,
        *(name.strip() for name in options.only if name.strip()),
    ]
    if options.list:
        print(listing(options.control))
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
    machine = places.load(options.machine)
    tables, notices = _chosen(options, machine)
    told = told_of(options, module, machine)
    whole = (
        getattr(module, "write_machine", None) if not (options.axis or options.component) else None
    )
    if options.residual and whole:
        raise UsageError(f"{options.control} takes the whole map, so nothing is left for --residual", "leave --residual out, or --axis")  # fmt: skip
    export = whole(machine, told) if whole else module.write(tables, told)
    rest = (
        residual.held(options.control, machine, export, told, tables)
        if options.residual
        else ([], [])
    )
    known = {} if whole else {t.name: known_of(machine, t) for t in tables}
    if options.uncertainty:
        _beside(options, machine, tables, known)
    paths = write_files(
        export.files, Path(options.output), options.force, options.output.endswith(("/", "\\"))
    )
    doubts = overshoot.found(machine, "" if whole else "".join(t.moving for t in tables))
    notices = doubts if whole else doubts + notices
    print(
        report(
            options.control, module, machine, export, [] if whole else tables, notices, paths, known
        )
    )
    if options.residual:
        print(
            residual.write(
                options.control,
                machine,
                options.machine,
                Path(options.residual),
                export,
                rest,
                options.force,
            )
        )
    return 0


def known_of(machine: Machine, table: ErrorTable) -> np.ndarray | None:
    """(K,) mm: U (95 %) of a table at its nodes, of the component itself and of squareness and lost motion that stand in it; None where
    the folder states none of it."""
    axis, row = machine.axes[table.moving], XYZ.index(table.along)
    parts = []
    if axis.uncertainty is not None and row in axis.uncertainty.stated:
        both = np.stack([axis.uncertainty.table.forward, axis.uncertainty.table.reverse])[:, row]
        parts.append(np.interp(table.nodes, axis.uncertainty.table.nodes, both.max(axis=0)))
    for name, angle in machine.square_u.items():
        across = {x for x, r in zip(XYZ, "ABC", strict=True) if r != name[0]}
        if name[2] == table.moving and across == {table.moving, table.along}:
            parts.append(angle * np.abs(table.nodes))
    for term in machine.effects:
        for one in term.spread:
            parts += [
                np.interp(
                    table.nodes,
                    t.nodes,
                    np.abs(np.stack([t.forward, t.reverse])[:, row]).max(axis=0),
                )
                for t in one.tables
                if t.letter == table.moving and row in t.rows
            ]
    return np.sqrt(sum(np.square(p) for p in parts)) if parts else None


def _beside(
    options: argparse.Namespace,
    machine: Machine,
    tables: list[ErrorTable],
    known: dict[str, np.ndarray | None],
) -> None:
    """The U of what is written, as a file. Raises UsageError where the folder states none, or the file is there."""
    rows = [
        f"{t.name},{node:g},{value / UM:.4f}"
        for t in tables
        if (u := known.get(t.name)) is not None
        for node, value in zip(t.nodes, u, strict=True)
    ]
    if not rows:
        raise UsageError(
            f"--uncertainty: {machine.name} states no uncertainty of what is written",
            "gcomp machines show says what it states",
        )
    text = f"# U, 95 % (k = 2), of the tables for {options.control}; map {machine.digest}\ncomponent,position_mm,U_um\n"
    write_files(
        {"U": (text + "\n".join(rows) + "\n").encode()},
        Path(options.uncertainty),
        options.force,
        False,
    )


def _chosen(options: argparse.Namespace, machine: Machine) -> tuple[list[ErrorTable], list[str]]:
    """The machine's one-axis tables that were asked for, and notices about them."""
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
    tables = [
        t
        for t in tables
        if (not options.axis or t.moving in options.axis)
        and (not options.component or t.name in options.component)
    ]
    notices = []
    for x in sorted({t.moving for t in tables}):
        stand = {
            o: p
            for o, p in pose_of(machine, x, options.at).items()
            if o != x and o in machine.chain.axes
        }
        if stand:
            notices.append(
                f"over {x}: the other axes stand at {' '.join(f'{o} = {p:g}' for o, p in stand.items())} (--at)"
            )
        for o in range(3):
            if (
                any(t.name == f"E{XYZ[o]}{x}" for t in tables)
                and x in machine.square
                and machine.square[x].any()
                and XYZ[o] != x
            ):
                notices.append(f"E{XYZ[o]}{x} holds the squareness of {x} as a line")
        if x in machine.diameter:
            notices.append(
                f"words of {x} are diameters; positions and values here are slide positions, radius: make sure that the table of the control is too"
            )
    kept = {t.name for t in tables}
    wanted = [
        n
        for n in left
        if not re.match(r"E[XYZ][XYZ] ", n)
        or n[:3] in kept
        or not (options.axis or options.component)
    ]
    return tables, notices + wanted


def told_of(
    options: argparse.Namespace, module: Any, machine: Machine | None = None
) -> ExportOptions:
    """What the command line says, for the control's module. Raises UsageError for a --set that the control does not know."""
    extra: dict[str, str] = {}
    known = getattr(module, "EXTRA", {})
    patterns = [re.sub(r"_[A-Z]$", "_[A-Z]", key) for key in known]
    for pair in options.extra:
        key, sign, value = pair.partition("=")
        if not sign or not any(re.fullmatch(p, key) for p in patterns):
            raise UsageError(
                f"--set {pair}: {options.control} has no such key",
                f"keys: {', '.join(known) or 'none'} (gcomp export --list --control {options.control})",
            )
        extra[key] = value
    for key, why in getattr(module, "STATED", {}).items():
        if key not in extra:
            raise UsageError(f"--set {key}=... is not said, and {options.control} needs it", why)
    if machine is not None:
        slides = "".join(x for x in machine.letters if x in XYZ)
        extra.setdefault("axes", slides)
    if options.template:
        extra["template"] = _text(options.template)
    if options.settings:
        extra["settings"], extra["settings_name"] = _text(options.settings), options.settings
    if machine is None and options.axis:
        extra["axis"] = options.axis[0]
    first = {x: int(v) for x, v in options.first.items() if v == int(v)}
    if len(first) < len(options.first):
        raise UsageError("--first is the number of a point, without a fraction", "--first X=1")
    return ExportOptions(
        unit=options.unit, spacing=options.spacing, reference=options.reference, first=first, step=options.step,
        two_way=not options.one_way, program=machine.name if machine else "gcomp", extra=extra,
    )  # fmt: skip


def _text(path: str) -> str:
    return Source(path, ports.read_whole(Path(path), LARGEST_FILE)).text


def write_files(files: dict[str, bytes], output: Path, force: bool, folder: bool) -> list[Path]:
    """Write all files or none that would overwrite one. Raises UsageError where a file is there and `force` is not set."""
    if len(files) > 1 or output.is_dir() or folder:
        if output.exists() and not output.is_dir():
            raise UsageError(
                f"{len(files)} files are to be written, and {output} is a file", "-o FOLDER"
            )
        paths = [output / name for name in files]
    else:
        paths = [output]
    for path in paths:
        if path.exists() and not force:
            raise UsageError(f"{path} is there already", "--force overwrites it, or another -o")
    if len(files) > 1 or folder:
        output.mkdir(parents=True, exist_ok=True)
    for path, data in zip(paths, files.values(), strict=True):
        with ports.spool() as spool:
            spool.write(data)
            ports.replace_file(path, spool, backup=False)
    return paths


def report(
    control: str,
    module: Any,
    machine: Machine,
    export: Export,
    tables: list[ErrorTable],
    notices: list[str],
    paths: list[Path],
    known: dict[str, np.ndarray | None],
) -> str:
    """What was written, for a person: component, points, largest correction, what is left; notices; what is unverified."""
    lines = [
        f"{machine.name} (map {machine.digest}) for {control}: {module.TITLE}",
        f"sign: {getattr(module, 'SIGN', 'see its description')}",
        "",
    ]
    by_name = {t.name: t for t in tables}
    lines.append(
        f"{'component':<10}{'nodes':>7}{'largest correction':>21}{'left by the table':>20}{'U (95 %)':>13}"
    )
    for name in [*by_name, *(n for n in export.remainder if n not in by_name)]:
        table = by_name.get(name)
        size = (
            f"{max(np.abs(table.forward).max(), np.abs(table.reverse).max()) / UM:.2f} um"
            if table
            else ""
        )
        rest = (
            f"{export.remainder[name] / UM:.3f} um" if name in export.remainder else "not written"
        )
        u = known.get(name)
        stated = (
            "" if table is None else "not stated" if u is None else f"{float(u.max()) / UM:.2f} um"
        )
        lines.append(
            f"{name:<10}{len(table.nodes) if table else '':>7}{size:>21}{rest:>20}{stated:>13}".rstrip()
        )
    said = [*notices, *export.notices]
    loud = [n for n in said if n.startswith("unverified")]
    if module.UNVERIFIED and not loud:
        loud = [f"unverified: {module.UNVERIFIED}"]
    lines += ["", *(f"note: {n}" for n in said if n not in loud)]
    lines += ["", *(f"UNVERIFIED: {n.split(':', 1)[1].strip()}" for n in loud)] if loud else []
    lines += ["", *(f"wrote {path}" for path in paths)]
    return "\n".join(lines)


def listing(control: str | None) -> str:
    """The controls that there are; with a name what that one alone wants."""
    if control:
        module = control_tables.load(control)
        keys = getattr(module, "EXTRA", {})
        width = max((len(k) for k in keys), default=0)
        head = [
            f"{control}: {module.TITLE}",
            f"sign: {getattr(module, 'SIGN', 'see its description')}",
            control_tables.label(module),
        ]
        return "\n".join([*head, *(f"  --set {k:<{width}}  {v}" for k, v in keys.items())])
    width = max(len(n) for n in control_tables.names())
    rows = []
    for name in control_tables.names():
        module = control_tables.load(name)
        rows += [
            f"{name:<{width}}  {module.TITLE}",
            f"{'':<{width}}  {control_tables.label(module)}; sign: {getattr(module, 'SIGN', 'see its description')}",
        ]
    return "\n".join(rows)


def _read(options: argparse.Namespace, module: Any) -> int:
    """What a control's table takes out, to standard output, or to a file for each axis."""
    found = read(options, module)
    if not options.output:
        print("\n".join(found.values()), end="")
        return 0
    folder = options.output.endswith(("/", "\\"))
    files = {f"{moving}.csv": text.encode() for moving, text in found.items()}
    for path in write_files(files, Path(options.output), options.force, folder):
        print(f"wrote {path}")
    return 0


def read(options: argparse.Namespace, module: Any) -> dict[str, str]:
    """What a control's table takes out: moving axis to its axis table (deviation, um)."""
    source = Source(options.read, ports.read_whole(Path(options.read), LARGEST_FILE))
    tables = module.read(source, told_of(options, module))
    if options.axis:
        tables = [t for t in tables if t.moving in options.axis]
    if options.component:
        tables = [t for t in tables if t.name in options.component]
    if not tables:
        raise UsageError(
            f"{options.read} has no table of {' '.join([*options.axis, *options.component]) or 'any axis'}"
        )
    parts = {}
    for moving in dict.fromkeys(t.moving for t in tables):
        group = [t for t in tables if t.moving == moving]
        head = f"# deviation that the table in {options.read} ({options.control}) takes out\n"
        parts[moving] = axis_csv(moving, group, head)
    return parts


def axis_csv(moving: str, tables: list[ErrorTable], head: str = "") -> str:
    """Tables of one axis in the form of a machine's axis table, on all their nodes."""
    nodes = np.unique(np.concatenate([t.nodes for t in tables]))
    names, columns = [f"{moving}_mm"], [nodes]
    for table in tables:
        ways = (("_fwd", 1.0), ("_rev", -1.0)) if table.two_way else (("", 0.0),)
        for suffix, way in ways:
            names.append(f"{table.name}_um{suffix}")
            columns.append(table.at(nodes, way) / UM)
    rows = [
        ",".join(
            f"{v + 0.0:.10g}" if i == 0 else f"{round(v, 6) + 0.0:.10g}" for i, v in enumerate(row)
        )
        for row in zip(*columns, strict=True)
    ]
    return head + "\n".join([",".join(names), *rows]) + "\n"
