"""`gcomp volumetric REC... --like MACHINE -o FOLDER`: readings all over the volume to a map of all
errors at once."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from postproc import intake, ports
from postproc.commands import as_json, option_text
from postproc.commands.calibrate import like_of, of_single_slides, write_folder
from postproc.commands.recording_files import read_files, reading_arguments, reading_options
from postproc.errors import UsageError
from postproc.machine import places
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine

HELP = (
    "make a machine folder of readings all over the volume: a laser tracker's points, lengths,"
    " diagonals, circles, spheres"
)
EXAMPLE = "gcomp volumetric cloud.csv --like example-mill -o machines/mine"
SHARE = 0.1  # of the readings of either direction, so that lost motion is told


OPTIONS = """
recordings+ REC  recordings of points, lengths, spheres, diagonals, lines; six-degree-of-freedom
    files
--like MACHINE  the machine that was measured: its chain, axes, travels, control
-o, --output FOLDER  the machine folder to write; without it nothing is
--force  write over a machine folder; the old one stays as .bak
--json FILE  all of it as JSON (gcomp-volumetric/1); - for standard output
--zero NAME,... ...  errors that are taken as zero, like EYX,C0Y
--nodes N  nodes of each axis (default: of each component the places that were read, 11 where they
    are more than 15)
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, like={"required": True}, nodes=int)
    reading_arguments(parser)


def run(options: argparse.Namespace) -> int:
    from postproc.volumetric import solve, written
    from postproc.volumetric.observations import rows_of
    from postproc.volumetric.unknowns import Unknowns

    machine = places.load(options.like)
    of_single_slides(machine.chain, "gcomp volumetric")
    if options.nodes is not None and not 2 <= options.nodes <= 200:
        raise UsageError(f"--nodes {options.nodes}: a component has 2 to 200 nodes")
    read = read_files(options.recordings, options.format, reading_options(options))
    known = written.without_errors(machine)
    rows = [part for r in read for part in rows_of(r, known, dict(options.others))]
    turned = _turned(machine, rows)
    every = _errors(options, machine, rows, known, turned)
    zero = _zero(options, [g.name for g in every])
    groups = tuple(g for g in every if g.name not in zero)
    base = _slides(machine) if turned else known
    fit = solve.fit(rows, Unknowns(groups, known, base))
    out = as_json.beside(options.json)
    print(written.report(fit, rows[0].tool, frozenset(zero)), file=out)
    print(*_notices(read), sep="", end="", file=out)
    print(_write(options, fit, turned, read), file=out)
    as_json.put(options.json, written.as_json(fit))
    return 0


def _write(options: argparse.Namespace, fit, turned: bool, read) -> str:
    """The folder, where one is named; returns where it is, for a person."""
    if not options.output:
        return "\nnothing is written: -o machines/NAME names the folder"
    texts = _folder(options, fit, turned, read)
    kept = write_folder(Path(options.output), texts, options.force)
    return f"\nwritten: {options.output}{kept}"


def _errors(options: argparse.Namespace, machine: Machine, rows, known, turned: bool):
    """What is looked for: how rotary axes that turn lie, else the errors of the slides."""
    from postproc.volumetric import nodes as placed
    from postproc.volumetric.unknowns import components, locations

    if turned:
        _of_slides_only([r.kind for r in rows])
        return locations(machine, frozenset())
    nodes = placed.of_axes(rows, machine, options.nodes)
    if not nodes:
        raise UsageError("no slide moves in these recordings")
    if options.nodes is None:
        nodes |= placed.of_components(rows, known, nodes)
    return components(machine, nodes, frozenset(), _two_way(rows, machine))


def _notices(read) -> list[str]:
    """A line for each notice of the recordings."""
    out = dict.fromkeys(f"{r.file}: {n}" for r in read for n in r.notices)
    return [f"notice: {text}\n" for text in out]


def _turned(machine: Machine, rows) -> bool:
    """Whether a rotary axis turns in these observations."""
    rotary = [machine.letters.index(x) for x in machine.chain.rotary]
    return any(np.ptp(r.q[k]) > 1e-3 for r in rows for k in rotary)


def _zero(options: argparse.Namespace, names: list[str]) -> set[str]:
    """The errors that --zero names. Raises UsageError for a name that is none of them."""
    zero = {n.strip() for n in ",".join(options.zero).split(",")} - {""}
    if wrong := sorted(zero - set(names)):
        raise UsageError(
            f"--zero {wrong[0]}: there is no such error here", f"errors: {', '.join(names)}"
        )
    return zero


def _folder(options: argparse.Namespace, fit, turned: bool, read) -> dict[str, str]:
    """File name to text of the machine that was found."""
    from postproc.volumetric import written

    name = Path(options.output).resolve().name
    head = {"name": name, "title": f"{name}, measured in its volume"}
    files, like = [r.file for r in read], like_of(options.like)
    if turned:
        return written.turned(fit, like, head, _tables(options.like), files)
    return written.folder(fit, like, head, fit.rows[0].tool, files)


def _tables(name: str) -> dict[str, str]:
    """The tables of a machine's folder, as they are."""
    folder = places.folder_of(name)
    return {
        p.name: ports.read_whole(p, intake.TABLE).decode() for p in sorted(folder.glob("*.csv"))
    }


def _of_slides_only(kinds: list[str]) -> None:
    if set(kinds) - {"sphere", "shift", "length"}:
        raise UsageError(
            "rotary axes turn in these recordings: they are read with a sphere, an R-test or a"
            " ballbar",
            'kind = "sphere", or points with dx_um dy_um dz_um',
        )


def _slides(machine: Machine) -> Machine:
    """The machine with the errors that its slides are known to have; how its rotary axes lie is
    asked for."""
    # location (6,): EX EY EZ EA EB EC of a rotary axis' line; zero, for that is what is asked for
    axes = {x: a if x in XYZ else replace(a, location=np.zeros(6)) for x, a in machine.axes.items()}
    square = {x: lean for x, lean in machine.square.items() if x in XYZ}
    return replace(machine, axes=axes, square=square)


def _two_way(rows, machine: Machine) -> frozenset[str]:
    """Axes that were read from both sides."""
    found = set()
    for x in (x for x in XYZ if x in machine.chain.axes):
        way = np.concatenate([r.approach[machine.letters.index(x)] for r in rows])
        if min((way > 0).mean(), (way < 0).mean()) > SHARE:
            found.add(x)
    return frozenset(found)
