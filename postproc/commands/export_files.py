"""The files of an export: where they go, what they hold and leave, and how it is told."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from postproc import control_tables, ports, standing
from postproc.control_tables import ErrorTable, Export
from postproc.errors import UsageError
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.units import UM

FORMAT = "gcomp-export/1"


def known_of(machine: Machine, table: ErrorTable) -> np.ndarray | None:
    """(K,) mm: U (95 %) of a table at its nodes, of the component itself and of squareness and lost
    motion that stand in it; None where the folder states none of it."""
    axis, row = machine.axes[table.moving], XYZ.index(table.along)
    parts = []
    if axis.uncertainty is not None and row in axis.uncertainty.stated:
        parts.append(_along(axis.uncertainty.table, row, table.nodes))
    parts += [*_of_squareness(machine, table), *_of_effects(machine, table, row)]
    # of independent causes the squares add (GUM): the component's own, squareness, lost motion
    return np.sqrt(sum(np.square(p) for p in parts)) if parts else None


def _of_effects(machine: Machine, table: ErrorTable, row: int) -> Iterator[np.ndarray]:
    """(K,) mm: U (95 %) of each effect that stands in the table."""
    spread = (t for term in machine.effects for one in term.spread for t in one.tables)
    for t in spread:
        if t.letter == table.moving and row in t.rows:
            yield _along(t, row, table.nodes)


def _of_squareness(machine: Machine, table: ErrorTable) -> Iterator[np.ndarray]:
    """(K,) mm: U (95 %) of each squareness that stands in the table as a line."""
    for name, angle in machine.square_u.items():
        # C0Y is a turn about Z: it acts between X and Y
        across = {x for x, r in zip(XYZ, "ABC", strict=True) if r != name[0]}
        if name[2] == table.moving and across == {table.moving, table.along}:
            # a leaning axis is off by its angle times the way from zero
            yield angle * np.abs(table.nodes)


def _along(table: AxisTable, row: int, nodes: np.ndarray) -> np.ndarray:
    """(K,) the larger size of both directions of a component at nodes."""
    both = np.abs(np.stack([table.forward, table.reverse])[:, row])
    return np.interp(nodes, table.nodes, both.max(axis=0))


def held(table: ErrorTable, export: Export) -> bool:
    """Whether the files take anything of a table out, be it that there is nothing to take."""
    size = max(np.abs(table.forward).max(), np.abs(table.reverse).max())
    left = export.remainder.get(table.name, np.inf)
    return bool(left < size or left == 0)


def places_of(
    files: dict[str, bytes], output: Path, force: bool, folder: bool
) -> dict[Path, bytes]:
    """Where files go: the folder `output`, or for one file `output` itself. Raises UsageError where
    a file is there and `force` is not set, or none can be."""
    into = len(files) > 1 or output.is_dir() or folder
    if into and output.exists() and not output.is_dir():
        raise UsageError(
            f"{len(files)} files are to be written, and {output} is a file", "-o FOLDER"
        )
    paths = {output / name if into else output: data for name, data in files.items()}
    for path in paths:
        standing.kept(path, force, "--force writes over it, or another -o")
        there = path.parent.absolute()
        ports.writable((_existing(there) if into else there) / path.name)
    return paths


def _existing(folder: Path) -> Path:
    """The nearest folder above that is there: those below it are made."""
    return next(p for p in (folder, *folder.parents) if p.exists())


def write_files(files: dict[Path, bytes]) -> None:
    """Each whole, in a folder that is made if need be."""
    for path, data in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        ports.write_whole(path, data)


def components(
    tables: list[ErrorTable], export: Export, known: dict[str, np.ndarray | None]
) -> list[dict[str, Any]]:
    """What became of each component, um. nodes, largest_um: of the map; left_um: what the written
    table leaves of it, None where it was not written; u_um: U (95 %), None where none is stated."""

    def um(value: float | None) -> float | None:
        return None if value is None else round(float(value) / UM, 6)

    rows = []
    by_name = {t.name: t for t in tables}
    for name in [*by_name, *(n for n in export.remainder if n not in by_name)]:
        table, u = by_name.get(name), known.get(name)
        size = None
        if table is not None:
            size = max(np.abs(table.forward).max(), np.abs(table.reverse).max())
        rows.append({
            "name": name, "nodes": None if table is None else len(table.nodes),
            "largest_um": um(size), "left_um": um(export.remainder.get(name)),
            "u_um": um(None if u is None else u.max()),
        })  # fmt: skip
    return rows


def split_notices(module: Any, notices: list[str]) -> tuple[list[str], list[str]]:
    """What is not verified, and the other notices."""
    loud = [n for n in notices if n.startswith("unverified")]
    said = [n for n in notices if n not in loud]
    if module.UNVERIFIED and not loud:
        return [module.UNVERIFIED], said
    return [n.split(":", 1)[1].strip() for n in loud], said


def report(
    control: str,
    module: Any,
    machine: Machine,
    rows: list[dict[str, Any]],
    notices: list[str],
    unverified: list[str],
    paths: list[Path],
) -> str:
    """What was written, for a person: component, points, largest correction, what is left; notices;
    what is unverified."""
    lines = [
        f"{machine.name} (map {machine.digest}) for {control}: {module.TITLE}",
        f"sign: {module.SIGN}",
        "",
        f"{'component':<10}{'nodes':>7}{'largest correction':>21}{'left by the table':>20}"
        f"{'U (95 %)':>13}",
    ]
    for row in rows:
        size = stated = ""
        if row["nodes"] is not None:
            size = f"{row['largest_um']:.2f} um"
            stated = "not stated" if row["u_um"] is None else f"{row['u_um']:.2f} um"
        rest = "not written" if row["left_um"] is None else f"{row['left_um']:.3f} um"
        nodes = row["nodes"] or ""
        lines.append(f"{row['name']:<10}{nodes:>7}{size:>21}{rest:>20}{stated:>13}".rstrip())
    lines += ["", *(f"note: {n}" for n in notices)]
    lines += [""] * bool(unverified) + [f"UNVERIFIED: {n}" for n in unverified]
    lines += ["", *(f"wrote {path}" for path in paths)]
    return "\n".join(lines)


def of_control(name: str, module: Any) -> dict[str, Any]:
    """A control's table in general."""
    return {
        "control": name,
        "title": module.TITLE,
        "sign": module.SIGN,
        "known": control_tables.label(module),
    }


def controls(only: str | None) -> list[dict[str, Any]]:
    """The controls that there are, or the one of this name, each with the keys of --set."""
    return [
        {**of_control(name, module), "keys": dict(getattr(module, "EXTRA", {}))}
        for name in ([only] if only else control_tables.names())
        for module in [control_tables.load(name)]
    ]


def listing(control: str | None) -> str:
    """The controls that there are; with a name what that one alone wants."""
    found = controls(control)
    if control:
        one = found[0]
        width = max((len(k) for k in one["keys"]), default=0)
        head = [f"{control}: {one['title']}", f"sign: {one['sign']}", one["known"]]
        return "\n".join([*head, *(f"  --set {k:<{width}}  {v}" for k, v in one["keys"].items())])
    width = max(len(one["control"]) for one in found)
    rows = []
    for one in found:
        rows += [
            f"{one['control']:<{width}}  {one['title']}",
            f"{'':<{width}}  {one['known']}; sign: {one['sign']}",
        ]
    return "\n".join(rows)


def of_tables(tables: list[ErrorTable]) -> list[dict[str, Any]]:
    """What a table of a control takes out, um over mm."""
    return [
        {
            "name": t.name,
            "nodes_mm": [float(v) for v in t.nodes],
            "forward_um": [round(float(v) / UM, 6) for v in t.forward],
            "reverse_um": [round(float(v) / UM, 6) for v in t.reverse],
        }
        for t in tables
    ]


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


def axis_files(tables: list[ErrorTable], file: str, control: str) -> dict[str, str]:
    """What a control's table takes out: moving axis to its axis table (deviation, um)."""
    parts = {}
    for moving in dict.fromkeys(t.moving for t in tables):
        group = [t for t in tables if t.moving == moving]
        head = f"# deviation that the table in {file} ({control}) takes out\n"
        parts[moving] = axis_csv(moving, group, head)
    return parts
