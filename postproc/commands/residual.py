"""`gcomp export --residual FOLDER`: the control holds what it can, and a copy of the machine is
corrected for the rest.

The copy is the machine's folder with a section [[control_table]] for each file that was written,
measured "off", active. What such a section makes of the file is compared with what was written,
before the folder has its name: a setting that the section can not hold would correct a program for
a table that the control does not have.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from postproc import control_tables, ports
from postproc.control_tables import ErrorTable, Export, ExportOptions
from postproc.errors import GcompError, UsageError
from postproc.machine import edit, places
from postproc.machine.model import Machine
from postproc.recordings import Source
from postproc.units import UM

NOTE = (
    "What the control takes out by itself: the map was measured without it, and a program is"
    " corrected for the rest."
)
ALIKE = 0.01 * UM  # a nanometre of rounding in either direction, of several tables


# sections and what they hold; means
Held = tuple[list[tuple[dict[str, Any], list[ErrorTable]]], list[str]]


def held(
    control: str, machine: Machine, export: Export, how: ExportOptions, tables: list[ErrorTable]
) -> Held:
    """What the files hold. Raises UsageError where they do not read back, before anything is
    written."""
    if machine.control_tables:
        raise UsageError(
            f"{machine.name} states tables of its control already",
            "export from the machine without [[control_table]]",
        )
    sections = _sections(control, export, how, machine)
    return sections, _compare(control, sections, export, tables)


def write(
    control: str,
    machine: Machine,
    folder: str,
    target: Path,
    export: Export,
    found: Held,
    force: bool,
) -> str:
    """Writes the folder; returns what it is, for a person. Raises UsageError for a file that has
    its name already."""
    sections, means = found

    def change(toml: str) -> str:
        return edit.with_sections(
            toml, target.name, "control_table", [(section, "") for section, _ in sections], NOTE
        )

    files = {section["file"]: export.files[section["file"]] for section, _ in sections}
    if taken := [n for n in files if (places.folder_of(folder) / n).exists()]:
        raise UsageError(
            f"{machine.name} has a file {taken[0]} of its own",
            "rename it there, or export under another name",
        )
    ports.copy_folder(places.folder_of(folder), target, force, change, files)
    play = (
        f"; leave the control's own backlash of {', '.join(n[1] for n in means)} as it was while"
        " the map was measured: the reversal stays in the program"
        if means
        else ""
    )
    return (
        f"wrote {target}: {machine.name} with what {control} takes out; put {', '.join(files)} into"
        f" the control, then: gcomp job.nc --machine {target} --verify{play}"
    )


def _settings(control: str, more: dict[str, str]) -> dict[str, dict[str, str]]:
    """The key `set` of a section, where something is set."""
    kept = {k: v for k, v in more.items() if k != "axes" or control == "fanuc"}
    return {"set": kept} if kept else {}


def _sections(
    control: str, export: Export, how: ExportOptions, machine: Machine
) -> list[tuple[dict[str, Any], list[ErrorTable]]]:
    """A section for each file that is a table, and what it holds."""
    module = control_tables.load(control)
    more = dict(how.extra)
    for of_export in ("template", "settings", "settings_name"):
        more.pop(of_export, None)
    settings = _settings(control, more)
    found = []
    for name, data in export.files.items():
        # Some files name no axis (a .comp of LinuxCNC under another name): each is tried, the first
        # that reads is stated in the section.
        for of_axis in ({}, *({"axis": x} for x in machine.letters)):
            try:
                read = module.read(Source(name, data), ExportOptions(extra=more | of_axis))
            except GcompError:
                continue
            section = {"control": control, "file": name, "measured": "off", "active": True}
            found.append((section | of_axis | settings, read))
            break
    if not found:
        raise UsageError(
            f"none of the files for {control} is a table that gcomp reads back:"
            f" {', '.join(export.files)}",
            "--residual is for controls whose table holds its own positions and units (linuxcnc,"
            " siemens-enc-comp, heidenhain ...)",
        )
    return found


def _beside(table: ErrorTable, held: list[ErrorTable]) -> np.ndarray:
    """(2, K) mm: what is held less what was to be, at the table's nodes, towards minus and plus."""
    return np.stack(
        [
            sum((t.at(table.nodes, way) for t in held), np.zeros(len(table.nodes)))
            - table.at(table.nodes, way)
            for way in (-1.0, 1.0)
        ]
    )


def _compare(control: str, sections: list, export: Export, tables: list[ErrorTable]) -> list[str]:
    """What is read back must be what was written, to what the export says is left, but for a shift
    of the whole axis.

    Returns the components of which only the mean of both directions is held.
    """
    held: dict[str, list[ErrorTable]] = {}
    for _, read in sections:
        for table in read:
            held.setdefault(table.name, []).append(table)
    means = []
    for table in tables:
        if table.name not in export.remainder:
            continue
        limit = export.remainder[table.name] + ALIKE
        mine = held.get(table.name, [])
        off = _beside(table, mine)
        # half of the range: a constant is a zero of the axis, which no table of deviations holds
        if np.ptp(off) / 2 <= limit:
            continue
        apart = float(np.ptp(off.mean(axis=0)) / 2)
        if apart > limit or any(t.two_way for t in mine):
            raise UsageError(
                f"{table.name} reads back from the files for {control} {apart / UM:.2f} um beside"
                " what was written",
                "a unit, a reference or a step that [[control_table]] does not hold (export in mm,"
                " without --reference, --first, --step), or a part that the control is told by"
                " hand: --component chooses others",
            )
        means.append(table.name)
    return means
