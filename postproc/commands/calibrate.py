"""`gcomp calibrate REC... -o machines/NAME`: recordings of single axes to a machine folder."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

from postproc import intake, ports, standing
from postproc.calibrate import CalibrationError, Options, figure, folder, report
from postproc.calibrate.calibration import Calibration
from postproc.calibrate.first import KINDS
from postproc.calibrate.run import calibrate
from postproc.commands import as_json, reading, session
from postproc.commands.calibrate_options import arguments, datum_of
from postproc.commands.recording_files import files_of, read_files, reading_options
from postproc.errors import MachineError, UsageError
from postproc.machine import chain as chains
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.recordings import Recording

HELP = "make a machine folder of recordings, with its uncertainty and what looks wrong in them"
EXAMPLE = "gcomp calibrate z.csv x.csv --like studer-s36 --squareness B0X=-382.4,2 -o machines/mine"
TAKEN = ("control", "diameter", "reversal", "limits")  # of --like, beside the chain and the axes
ITS_OWN = {
    "squareness": "measured on it",
    "location": "measured on it",
    "tool": "say where yours ends, [tool] in machine.toml, or in the program",
    "offsets": "say where your zeros lie: --offset, --offsets, or [offsets] in machine.toml",
}


def run(options: argparse.Namespace) -> int:
    options = session.merged(options, arguments)
    like = like_of(options.like)
    head, axes, decided = machine_of(options, like)
    read, digests = _recordings(options.recordings, options)
    calibration = calibrate(read, decided)
    texts = folder.folder(calibration, head, axes)
    if options.figure:
        _figure(options.figure, calibration)
    if options.report:
        _page(options.report, calibration, texts, str(head["name"]))
    out = as_json.beside(options.json)
    print(report.table(calibration), file=out)
    for fault in [f"{r.file}:{f.line}: left out: {f.message}" for r in read for f in r.faults]:
        print(fault, file=out)
    for text in _not_taken(like):
        print(f"\nnot taken from {options.like}: {text}", file=out)
    if options.output:
        kept = write_folder(Path(options.output), texts, options.force)
        print(f"\nwritten: {options.output}{kept}", file=out)
    else:
        print("\nnothing is written: -o machines/NAME names the folder", file=out)
    as_json.put(options.json, report.data(calibration) | {"sha256": digests})
    return 0


def _not_taken(like: dict[str, Any]) -> list[str]:
    """What of the machine that is copied is its own."""
    left = [f"{key}: {why}" for key, why in ITS_OWN.items() if key in like]
    if warm := [x for x, section in like.get("axes", {}).items() if "heat" in section]:
        left.append(f"heat of {', '.join(warm)}: growth and temperatures are its own")
    if like.get("effect"):
        names = ", ".join(f"{e.get('name')} of {e.get('axis')}" for e in like["effect"])
        left.append(
            f"effects ({names}): they were found against its own tables, and a two-way table has"
            " the play in it"
        )
    if "control_table" in like:
        left.append(
            "control_table: state anew which of the control's tables work, and in which state this"
            " was measured"
        )
    return left


# -- what is read ----------------------------------------------------------------------------------


def like_of(name: str | None) -> dict[str, Any]:
    """machine.toml of the machine that is copied, empty where none is."""
    if not name:
        return {}
    places.load(name)  # refuses with file and line what is no machine
    return reading.stated(name)


def of_single_slides(chain: chains.Chain, command: str) -> None:
    """Raises UsageError for a chain with second slides: recordings do not say where these stood,
    and the machine that is written would lose the errors that were measured of them."""
    if second := [x for x in chain.axes if x in "UVW"]:
        raise UsageError(
            f"{command} measures X Y Z and rotary axes, and this machine has second slides too"
            f" ({', '.join(second)})",
            "take the machine without them (--like, --chain), and write their sections and tables"
            " into the folder afterwards",
        )


def machine_of(
    options: argparse.Namespace, like: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any], Options]:
    """Keys of machine.toml, those of its axes, and how to reckon. Raises UsageError naming the
    option that is missing."""
    control, chain, written = _control_and_chain(options, like)
    axes = _axes(options, like, chain, written)
    name = Path(options.output).resolve().name if options.output else "unnamed"
    head = _head(options, like) | {"name": name, "title": options.title or name, "control": control}
    limits = head.get("limits", {})
    datum, keep_zero = datum_of(options.datum)
    decided = Options(
        chain=chain,
        datum=datum,
        keep_zero=keep_zero,
        line=options.line,
        keep_lines=options.keep_lines,
        squareness=dict(options.squareness),
        square_error=options.square_error,
        square_at=options.square_at,
        leads=dict(options.lead),
        travel={
            x: (float(s["travel"][0]), float(s["travel"][1]))
            for x, s in axes.items()
            if "travel" in s
        },
        max_slope=limits.get("max_slope", Options.max_slope),
        outside=limits.get("outside", "error"),
        point=tuple(options.point.get(x, 0.0) for x in "XYZ"),
        u_random=options.u_random,
        u_temperature=options.u_temperature,
        expansion=options.expansion * 1e-6,
        drop_outliers=options.drop_outliers,
        keep_all=options.keep_all,
        mean=options.mean,
        diameter=tuple(head.get("diameter", ())),
    )
    return head, axes, decided


def _control_and_chain(
    options: argparse.Namespace, like: dict[str, Any]
) -> tuple[str, chains.Chain, str]:
    """The control, and the chain parsed and as it is written. Raises UsageError."""
    said = {
        "control": options.control or like.get("control"),
        "chain": options.chain or like.get("chain"),
    }
    for key, advice in (
        ("chain", f"who carries whom: {', '.join(f'{k.chain} {n}' for n, k in KINDS.items())}"),
        ("control", f"one of {', '.join(dialects.names())}"),
    ):
        if not said[key]:
            raise UsageError(
                f"the machine's {key} is not said", f"--{key} ({advice}), or --like MACHINE"
            )
    control = dialects.load(str(said["control"])).name
    try:
        chain = chains.parse(str(said["chain"]))
    except ValueError as error:
        raise UsageError(f"--chain: {error}") from None
    of_single_slides(chain, "gcomp calibrate")
    return control, chain, str(said["chain"])


def _axes(
    options: argparse.Namespace, like: dict[str, Any], chain: chains.Chain, written: str
) -> dict[str, Any]:
    """The sections of the axes, with least increments and travels. Raises UsageError."""
    axes = {x: dict(section) for x, section in like.get("axes", {}).items()}
    for x in chain.axes:
        section = axes.setdefault(x, {})
        if options.least_increment:
            section["least_increment"] = options.least_increment
        if "least_increment" not in section:
            raise UsageError(
                f"the least increment of {x} is not said",
                "--least-increment 0.001mm, or --like MACHINE",
            )
    for x, (low, high) in options.travel:
        if x not in chain.axes:
            raise UsageError(f"--travel names {x}, and the chain {written} has none")
        axes[x]["travel"] = [low, high]
    return axes


def _head(options: argparse.Namespace, like: dict[str, Any]) -> dict[str, Any]:
    """What stands above the axes in machine.toml, but for the names."""
    head = {k: like[k] for k in TAKEN if k in like}
    given = {
        "max_slope": (options.max_slope or 0.0) * 1e-3,
        "accept_slope": options.accept_slope,
        "outside": options.outside,
    }
    limits = dict(head.get("limits", {})) | {k: v for k, v in given.items() if v}
    if limits:
        head["limits"] = limits
    if options.diameter is not None:
        head["diameter"] = [x for x in options.diameter.upper() if x.isalpha()]
    return head


def _recordings(
    names: list[str], options: argparse.Namespace
) -> tuple[list[Recording], dict[str, str]]:
    """All recordings, and the SHA-256 of each file by its name. Raises UsageError for a file that
    is named twice."""
    digests: dict[str, str] = {}
    for name in files_of(names):
        digest = hashlib.sha256(ports.read_whole(Path(name), intake.RECORDING)).hexdigest()
        # by content: the same readings under two names would count twice
        if digest in digests.values():
            first = next(n for n, d in digests.items() if d == digest)
            raise UsageError(f"{name} and {first} are the same file", "name each once")
        digests[name] = digest
    return read_files(names, options.format, reading_options(options)), digests


# -- what is written -------------------------------------------------------------------------------


def write_folder(path: Path, texts: dict[str, str], force: bool) -> str:
    """The folder in one step: whole and readable as a machine before it has its name. Returns where
    the old one went, for a person.

    Raises UsageError where a folder is there already (unless `force`), CalibrationError where the
    machine would be refused.
    """
    path = Path(os.path.abspath(path))
    standing.kept(path, force, "--force writes over it and keeps the old one beside it")
    if path.exists() and not (path / "machine.toml").is_file():
        raise UsageError(f"{path} is no machine folder: it is not written over")
    path.parent.mkdir(parents=True, exist_ok=True)
    #     .NAME.xxxx written, synced, read as a machine
    #     NAME       -> NAME.bak   where one stood there
    #     .NAME.xxxx -> NAME       a rename within one folder: whole or not at all
    temporary = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        for name, text in texts.items():
            with open(temporary / name, "w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        _accept(temporary)
        # mkdtemp gives 0o700, for nobody else; a machine's folder is as any other that the user
        # makes
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o777 & ~mask)
        backup = None
        if path.exists():
            backup = ports.beside(path)
            os.rename(path, backup)
        try:
            os.rename(temporary, path)
        except OSError:
            if backup is not None:
                os.rename(backup, path)
            raise
        return f" (the old one is {backup})" if backup else ""
    except BaseException:
        with contextlib.suppress(OSError):
            shutil.rmtree(temporary)
        raise


def _accept(written: Path) -> None:
    """Read it as every other command will."""
    try:
        read_machine(written)
    except MachineError as error:
        place = f"{Path(error.place.file).name}:{error.place.line}: " if error.place else ""
        raise CalibrationError(
            f"the machine would be refused, so it is not written: {place}{error.message}",
            error.advice,
        ) from None


def _page(name: str, calibration: Calibration, texts: dict[str, str], machine: str) -> None:
    """The page of the machine as its folder would be read, with U of every component."""
    from postproc.pages import machine as pages

    with tempfile.TemporaryDirectory() as place:
        folder_ = Path(place) / "machine"
        folder_.mkdir()
        for file, text in texts.items():
            (folder_ / file).write_text(text, "utf-8")
        try:
            found = read_machine(folder_)
        except MachineError:  # said where the folder is written
            found = calibration.machine
    page = pages.calibrated(found, machine, calibration.findings)
    ports.write_whole(name, page.html().encode("utf-8"))


def _figure(name: str, calibration: Calibration) -> None:
    kind = Path(name).suffix.lower().lstrip(".")
    if kind not in figure.FORMATS:
        raise UsageError(f"--figure {name}: a picture ends in one of {', '.join(figure.FORMATS)}")
    ports.write_whole(name, figure.draw(calibration, kind))
