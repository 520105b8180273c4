"""`gcomp machines` lists the machines; `show NAME` says what one is, `new NAME` makes one, `check
NAME` doubts it."""

from __future__ import annotations

import argparse
import io
from pathlib import Path
from typing import TextIO

import numpy as np

from postproc import ports
from postproc.commands import as_json, machine_facts, machine_new
from postproc.errors import GcompError, UsageError
from postproc.machine import places
from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.doubts import doubts
from postproc.machine.file import read_machine
from postproc.machine.lacks import lacks
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS
from postproc.machine.uncertainty import micrometres
from postproc.units import UM, URAD

HELP = "list the machines, show one, make a new one, or check one: gcomp machines show NAME"
EXAMPLE = (
    "gcomp machines new my-router --kind router --control grbl --travel X=0,600 --travel Y=0,400"
    " --travel Z=-80,0 --diagonals XY=500.3,499.8,400,300"
)
DOUBTFUL = 1  # exit status of check where something is in doubt


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", nargs="?", choices=("list", "show", "new", "check"), default="list")
    parser.add_argument("name", nargs="?", metavar="NAME")
    parser.add_argument(
        "--report",
        metavar="FILE.html",
        help="with show: a page with every table, the squareness and the volume",
    )
    as_json.argument(parser, machine_facts.FORMAT)
    machine_new.arguments(parser)


def run(options: argparse.Namespace) -> int:
    if options.what == "new":
        return _new(options)
    if options.what == "show":
        if not options.name:
            raise UsageError("which machine?", "gcomp machines show NAME")
        machine = places.load(options.name)
        if options.report:
            from postproc.pages import machine as page

            ports.replace_file(
                Path(options.report), io.BytesIO(page.html(machine).encode("utf-8")), backup=False
            )
        print(show(machine), file=as_json.beside(options.json))
        as_json.put(options.json, machine_facts.document([machine_facts.of(machine)]))
        return 0
    if options.what == "check":
        if not options.name:
            raise UsageError("which machine?", "gcomp machines check NAME")
        machine = places.load(options.name)
        as_json.put(options.json, machine_facts.document([machine_facts.of(machine)]))
        return _check(machine, as_json.beside(options.json))
    if options.report:
        raise UsageError(
            "--report draws one machine", "gcomp machines show NAME --report FILE.html"
        )
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


def _new(options: argparse.Namespace) -> int:
    from postproc.commands.calibrate import write_folder

    path, texts = machine_new.made(options)
    backup = write_folder(path, texts, options.force)
    machine = read_machine(path)
    out = as_json.beside(options.json)
    print(show(machine), file=out)
    as_json.put(options.json, machine_facts.document([machine_facts.of(machine)]))
    kept = f" (the old one is {backup})" if backup else ""
    print(
        f"\nwritten: {path}{kept}; next: gcomp job.nc --machine"
        f" {path if options.output else options.name} --verify",
        file=out,
    )
    return 0


def _check(machine: Machine, out: TextIO) -> int:
    """What is doubtful, then what nobody measured. Returns DOUBTFUL where something is in doubt."""
    doubtful = doubts(machine)
    for text in doubtful:
        print(f"in doubt: {text}", file=out)
    for text in lacks(machine):
        print(f"not in this map: {text}", file=out)
    if not machine.offsets:
        print(
            "to know: no work offsets are stated: --offset G54=X..,Y..,Z.. says them, or [offsets]"
            " in machine.toml",
            file=out,
        )
    if not doubtful:
        print(f"{machine.name}: nothing in it is doubtful", file=out)
    return DOUBTFUL if doubtful else 0


def show(machine: Machine) -> str:
    """What a machine is, for a person."""
    lines = [
        f"{machine.name}: {machine.title}",
        (
            f"control {machine.control}, chain {'-'.join(machine_facts.chain(machine))}, map"
            f" {machine.digest}"
        ),
    ]
    if machine.diameter:
        lines.append(
            f"words of {' '.join(machine.diameter)} are diameters; everything below is slide"
            " position, radius"
        )
    if machine.source:
        lines.append(f"source: {machine.source}")
    for letter, axis in machine.axes.items():
        unit = "degrees" if letter in ROTARY else "mm"
        lines.append(
            f"\naxis {letter}  travel {axis.travel[0]:g} to {axis.travel[1]:g} {unit}, least"
            f" increment {axis.least_increment:g} {unit}"
        )
        if letter in machine.chain.rotary:
            lines.append(
                "  centre line through "
                + " ".join(f"{x}{v:g}" for x, v in zip(XYZ, axis.centre, strict=True))
                + " mm"
            )
        lines += [
            f"  {(XYZ + ROTARY)[i]}0{letter}  {axis.location[i] / UM:+.1f} um"
            for i in map(int, np.flatnonzero(axis.location))
        ]
        lines += [
            f"  by {g.other} too: {len(g.nodes)} by {len(g.others)} nodes" for g in axis.grids
        ]
        if axis.expansion is not None:
            lines.append(
                f"  heat: {axis.expansion.rate * 1e6:+.2f} um/m from {axis.expansion.fixed:g} mm"
            )
        lines += _largest_u(axis)
        if axis.table is None:
            lines.append("  no error table")
            continue
        table = axis.table
        lines.append(
            f"  table {table.nodes[0]:g} to {table.nodes[-1]:g} {unit}, {len(table.nodes)} nodes"
        )
        for row in range(6):
            forward, reverse = table.forward[row], table.reverse[row]
            if not (np.any(forward) or np.any(reverse)):
                continue
            scale, size = (UM, "um") if row < 3 else (URAD, "urad")
            both = np.stack([forward, reverse]) / scale
            worst = np.unravel_index(np.argmax(np.abs(both)), both.shape)
            ways = (
                f", reversal up to {np.abs(both[0] - both[1]).max():.1f}"
                if np.any(forward != reverse)
                else ""
            )
            lines.append(
                f"  {COMPONENTS[row]}{letter}  {both.min():+.1f} to {both.max():+.1f} {size},"
                f" largest {both[worst]:+.1f} at {table.nodes[worst[1]]:g} {unit}{ways}"
            )
        if table.is_zero:
            lines.append("  all zero")
        if axis.left_out:
            lines.append(f"  measured, and within the uncertainty: {', '.join(axis.left_out)}")
    for letter, lean in machine.square.items():
        for i, value in enumerate(lean):
            if value:
                lines.append(f"\nsquareness {'ABC'[i]}0{letter}  {value / URAD:+.1f} urad")
    for name, u in machine.square_u.items():
        lines.append(f"squareness {name} is known to +- {u / URAD:.1f} urad (95 %)")
    for term in machine.effects:
        lines.append(
            f"\neffect {term.name} on {term.axis}: "
            + ", ".join(f"{k} = {v:g}" for k, v in term.parameters.items())
        )
        if term.spread:
            sizes = [f"{k} +- {v:g}" for one in term.spread for k, v in one.parameters.items()]
            lines.append(f"  known to {', '.join(sizes)} (95 %)")
    for own in machine.control_tables:
        lines.append(
            f"table of the control ({own.control}): {'on' if own.active else 'off'} at work, the"
            f" map was measured with it {'on' if own.measured else 'off'}"
        )
    for name, zero in machine.offsets.items():
        lines.append(f"offset {name}: " + " ".join(f"{x}{v:g}" for x, v in zero.items()))
    limits = machine.limits
    lines.append(
        f"\nlargest correction allowed {limits.max_correction:g} mm, outside the tables:"
        f" {limits.outside}, reversal: {machine.reversal}, hysteresis {limits.hysteresis / UM:g} um"
    )
    if not machine.is_zero:
        lines.append(
            f"largest deviation in its travel: {machine_facts.largest(machine) / UM:.1f} um"
        )
        lines.append(
            f"products of two errors, which are left out: {machine.bounds.second_order / UM:.2f} um"
            " at most"
        )
    lines.append(machine_facts.known(machine))
    lines += [f"in doubt: {text}" for text in doubts(machine)]
    lines += [f"not in this map: {text}" for text in lacks(machine)]
    return "\n".join(lines)


def _largest_u(axis: Axis) -> list[str]:
    """The largest U of each component of an axis, in one line; none where nothing is stated."""
    if axis.uncertainty is None or not axis.uncertainty.stated:
        return []
    u = axis.uncertainty.table
    sizes = [(i, max(u.forward[i].max(), u.reverse[i].max())) for i in axis.uncertainty.stated]
    says = [
        (
            f"{COMPONENTS[i]}{axis.letter} {micrometres(v)} um"
            if i < 3
            else f"{COMPONENTS[i]}{axis.letter} {v / URAD:.1f} urad"
        )
        for i, v in sizes
    ]
    return [f"  known to +- (95 %, at most): {', '.join(says)}"]
