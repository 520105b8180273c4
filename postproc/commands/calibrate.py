"""`gcomp calibrate REC... -o machines/NAME`: recordings of single axes to a machine folder."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import os
import shutil
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from postproc import ports
from postproc.calibrate import (
    LINES,
    STEEL,
    CalibrationError,
    Options,
    figure,
    folder,
    report,
    square,
)
from postproc.calibrate.calibration import Calibration, calibrate
from postproc.commands import as_json, session, values
from postproc.commands.recordings import files_of, read_files, reading_arguments, reading_options
from postproc.errors import MachineError, UsageError
from postproc.machine import chain as chains
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.recordings import Recording
from postproc.units import URAD

HELP = "make a machine folder of recordings, with its uncertainty and what looks wrong in them"
EXAMPLE = "gcomp calibrate z.csv x.csv --like studer-s36 --squareness B0X=-382.4,2 -o machines/mine"
LARGEST = 1 << 28
TAKEN = ("control", "diameter", "reversal", "limits")  # of --like, beside the chain and the axes
ITS_OWN = {
    "squareness": "measured on it",
    "location": "measured on it",
    "tool": "say where yours ends, [tool] in machine.toml, or in the program",
    "offsets": "say where your zeros lie: --offset, --offsets, or [offsets] in machine.toml",
}
SOURCES = ("straightness", "diagonals", "ballbar")


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recordings",
        nargs="+",
        metavar="REC",
        help="recordings of one axis moving, of diagonals, of circles; or a session, measurement.toml",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        help="the machine folder to write; without it nothing is",
    )
    parser.add_argument(
        "--force",
        action="store_true",
        help="write over a machine folder; the old one stays as .bak",
    )
    as_json.argument(parser, report.FORMAT)
    parser.add_argument(
        "--figure",
        metavar="FILE",
        help="draw the components with their uncertainty (.png .svg .pdf)",
    )

    parser.add_argument(
        "--report",
        metavar="FILE.html",
        help="a page with the machine that was found, and what looks wrong",
    )

    machine = parser.add_argument_group("the machine")
    machine.add_argument(
        "--like",
        metavar="MACHINE",
        help="take from it what machines of a kind share: control, chain, travels, limits",
    )
    machine.add_argument("--title", help="what the machine is, in words")
    machine.add_argument("--control", help="dialect of its control")
    machine.add_argument("--chain", help="who carries whom: w-b-Z-X-t")
    machine.add_argument("--diameter", metavar="AXES", help="axes whose words are diameters: X")
    machine.add_argument(
        "--travel",
        type=_range,
        action="append",
        default=[],
        metavar="Z=-5,520",
        help="mm an axis reaches",
    )
    machine.add_argument(
        "--least-increment",
        type=values.length,
        metavar="LENGTH",
        help="of the programmed word: 0.001mm",
    )
    machine.add_argument(
        "--max-slope", type=float, metavar="UM_PER_MM", help="limit of a table's slope (5)"
    )
    machine.add_argument("--accept-slope", action="store_true", help="a steeper table is true")
    machine.add_argument(
        "--outside",
        choices=("error", "clamp"),
        help="beyond the targets: refuse, or hold the end value",
    )

    how = parser.add_argument_group("how to reckon")
    how.add_argument(
        "--datum",
        metavar="Z=0|none",
        action="append",
        default=[],
        help="where deviations are zero; none: zeros as recorded",
    )
    how.add_argument(
        "--line", choices=LINES, default=LINES[0], help="reference line of a straightness"
    )
    how.add_argument(
        "--keep-lines", action="store_true", help="leave the lines of straightnesses in"
    )
    how.add_argument(
        "--squareness", type=_squareness, action="append", default=[], metavar="B0X=-382.4,2",
        help="urad and its u, or from what: B0X=straightness, B0X=diagonals, B0X=ballbar",
    )  # fmt: skip
    how.add_argument(
        "--square-error",
        type=_two,
        metavar="URAD,U",
        help="angle of the square over 90 degrees, and its u: --square-error=-3,2",
    )
    how.add_argument(
        "--square-at",
        type=values.place,
        default={},
        metavar="X200,Y150",
        help="mm, where the axes stood when the --squareness was measured",
    )
    how.add_argument("--drop-outliers", action="store_true", help="leave outliers out")
    how.add_argument(
        "--keep-all", action="store_true", help="write components within their uncertainty too"
    )
    how.add_argument(
        "--mean",
        action="store_true",
        help="one column for both directions: the control takes up the play",
    )
    how.add_argument(
        "--lead",
        type=_length_of,
        action="append",
        default=[],
        metavar="Z=5",
        help="mm of a turn of the screw",
    )
    how.add_argument(
        "--point",
        type=values.place,
        default={},
        metavar="X0,Z120",
        help="mm, the measured point from the last carriage",
    )
    how.add_argument(
        "--u-random", action="store_true", help="u_um of the recordings is noise and averages out"
    )
    how.add_argument(
        "--u-temperature",
        type=float,
        default=0.0,
        metavar="K",
        help="standard uncertainty of the scale's temperature",
    )
    how.add_argument(
        "--expansion",
        type=float,
        default=STEEL * 1e6,
        metavar="UM_M_K",
        help=f"expansion ({STEEL * 1e6:g} um/(m K))",
    )

    reading_arguments(parser)


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
        _page(options.report, calibration, str(head["name"]))
    told = as_json.beside(options.json)
    print(report.table(calibration), file=told)
    for fault in [f"{r.file}:{f.line}: left out: {f.message}" for r in read for f in r.faults]:
        print(fault, file=told)
    for text in _not_taken(like):
        print(f"\nnot taken from {options.like}: {text}", file=told)
    if options.output:
        backup = write_folder(Path(options.output), texts, options.force)
        print(
            f"\nwritten: {options.output}" + (f" (the old one is {backup})" if backup else ""),
            file=told,
        )
    else:
        print("\nnothing is written: -o machines/NAME names the folder", file=told)
    as_json.put(options.json, report.data(calibration) | {"sha256": digests})
    return 0


def _not_taken(like: dict[str, Any]) -> list[str]:
    """What of the machine that is copied is its own."""
    told = [f"{key}: {why}" for key, why in ITS_OWN.items() if key in like]
    warm = [x for x, section in like.get("axes", {}).items() if "heat" in section]
    if warm:
        told.append(f"heat of {', '.join(warm)}: growth and temperatures are its own")
    if like.get("effect"):
        names = ", ".join(f"{e.get('name')} of {e.get('axis')}" for e in like["effect"])
        told.append(
            f"effects ({names}): they were found against its own tables, and a two-way table has the play in it"
        )
    if "control_table" in like:
        told.append(
            "control_table: state anew which of the control's tables work, and in which state this was measured"
        )
    return told


# -- what the user says ------------------------------------------------------------------------------------------------


def _named(text: str) -> tuple[str, str]:
    name, equals, rest = text.partition("=")
    if not equals or not name.strip() or not rest.strip():
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip().upper() if len(name.strip()) < 4 else name.strip(), rest.strip()


def _float(text: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} in {whole!r} is not a number")
    return value


def _axis(name: str, whole: str) -> str:
    if name not in tuple("XYZABC"):
        raise argparse.ArgumentTypeError(f"{whole!r}: {name!r} is not one of X Y Z A B C")
    return name


def _range(text: str) -> tuple[str, tuple[float, float]]:
    name, rest = _named(text)
    low, _, high = rest.partition(",")
    result = _float(low, text), _float(high, text)
    if result[0] >= result[1]:
        raise argparse.ArgumentTypeError(f"{text!r} must be two ascending numbers, mm: Z=-5,520")
    return _axis(name, text), result


def _length_of(text: str) -> tuple[str, float]:
    name, rest = _named(text)
    value = _float(rest, text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r}: a lead is above zero, mm")
    return _axis(name, text), value


def _two(text: str) -> tuple[float, float]:
    first, _, second = text.partition(",")
    return _float(first, text) * URAD, abs(_float(second or "0", text)) * URAD


def _squareness(text: str) -> tuple[str, Any]:
    name, rest = _named(text)
    if name not in square.NAMES:
        raise argparse.ArgumentTypeError(
            f"{text!r}: {name!r} is not one of {', '.join(square.NAMES)}"
        )
    if rest in SOURCES:
        return name, rest
    first, comma, second = rest.partition(",")
    return name, (_float(first, text) * URAD, abs(_float(second, text)) * URAD if comma else None)


def _datum(texts: list[str]) -> tuple[dict[str, float], bool]:
    """Positions by axis, and whether zeros stay as recorded."""
    places: dict[str, float] = {}
    for text in texts:
        if text == "none":
            continue
        try:
            name, rest = _named(text)
            places[_axis(name, text)] = _float(rest, text)
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--datum {error}", "--datum Z=0, or --datum none") from None
    return places, "none" in texts


# -- what is read ------------------------------------------------------------------------------------------------------


def like_of(name: str | None) -> dict[str, Any]:
    """machine.toml of the machine that is copied, empty where none is."""
    if not name:
        return {}
    places.load(name)  # refuses with file and line what is no machine
    path = Path(name)
    if not (path / "machine.toml").is_file() or (
        len(path.parts) == 1 and not path.is_absolute() and name in places.every()
    ):
        path = places.every().get(name, path)
    return tomllib.loads(ports.read_whole(path / "machine.toml", LARGEST).decode("utf-8-sig"))


def machine_of(
    options: argparse.Namespace, like: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any], Options]:
    """Keys of machine.toml, those of its axes, and how to reckon. Raises UsageError naming the option that is missing."""
    head = {k: like[k] for k in TAKEN if k in like}
    said = {
        "control": options.control or head.get("control"),
        "chain": options.chain or like.get("chain"),
    }
    for key, advice in (
        ("chain", "w-b-Z-X-t, who carries whom"),
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
            raise UsageError(f"--travel names {x}, and the chain {said['chain']} has none")
        axes[x]["travel"] = [low, high]
    limits = dict(head.get("limits", {}))
    if options.max_slope:
        limits["max_slope"] = options.max_slope * 1e-3
    if options.accept_slope:
        limits["accept_slope"] = True
    if options.outside:
        limits["outside"] = options.outside
    if limits:
        head["limits"] = limits
    if options.diameter is not None:
        head["diameter"] = [x for x in options.diameter.upper() if x.isalpha()]
    name = Path(options.output).resolve().name if options.output else "unnamed"
    head |= {"name": name, "title": options.title or name, "control": control}
    datum, keep_zero = _datum(options.datum)
    decided = Options(
        chain=chain, datum=datum, keep_zero=keep_zero, line=options.line, keep_lines=options.keep_lines,
        squareness=dict(options.squareness), square_error=options.square_error,
        square_at=options.square_at, leads=dict(options.lead),
        travel={x: (float(s["travel"][0]), float(s["travel"][1])) for x, s in axes.items() if "travel" in s},
        max_slope=limits.get("max_slope", Options.max_slope), outside=limits.get("outside", "error"),
        point=tuple(options.point.get(x, 0.0) for x in "XYZ"), u_random=options.u_random,
        u_temperature=options.u_temperature, expansion=options.expansion * 1e-6, drop_outliers=options.drop_outliers,
        keep_all=options.keep_all, mean=options.mean, diameter=tuple(head.get("diameter", ())),
    )  # fmt: skip
    return head, axes, decided


def _recordings(
    names: list[str], options: argparse.Namespace
) -> tuple[list[Recording], dict[str, str]]:
    """All recordings, and the SHA-256 of each file by its name. Raises UsageError for a file that is named twice."""
    digests: dict[str, str] = {}
    for name in files_of(names):
        digest = hashlib.sha256(ports.read_whole(Path(name), LARGEST)).hexdigest()
        if digest in digests.values():
            first = next(n for n, d in digests.items() if d == digest)
            raise UsageError(f"{name} and {first} are the same file", "name each once")
        digests[name] = digest
    return read_files(names, options.format, reading_options(options)), digests


# -- what is written ---------------------------------------------------------------------------------------------------


def write_folder(path: Path, texts: dict[str, str], force: bool) -> Path | None:
    """The folder in one step: whole and readable as a machine before it has its name. Returns where the old one went.

    Raises UsageError where a folder is there already (unless `force`), CalibrationError where the machine would be refused.
    """
    path = Path(os.path.abspath(path))
    if path.exists() and not force:
        raise UsageError(
            f"{path} is there already", "--force writes over it and keeps the old one beside it"
        )
    if path.exists() and not (path / "machine.toml").is_file():
        raise UsageError(f"{path} is no machine folder: it is not written over")
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        for name, text in texts.items():
            with open(temporary / name, "w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        _accept(temporary)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o777 & ~mask)
        backup = None
        if path.exists():
            backup = next(
                b
                for n in range(1, 1000)
                if not (b := path.with_name(f"{path.name}.bak{n if n > 1 else ''}")).exists()
            )
            os.rename(path, backup)
        try:
            os.rename(temporary, path)
        except OSError:
            if backup is not None:
                os.rename(backup, path)
            raise
        return backup
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


def _page(name: str, calibration: Calibration, machine: str) -> None:
    from postproc.pages import machine as pages

    html = pages.calibrated_html(calibration.machine, machine, calibration.findings)
    ports.replace_file(Path(name), io.BytesIO(html.encode("utf-8")), backup=False)


def _figure(name: str, calibration: Calibration) -> None:
    kind = Path(name).suffix.lower().lstrip(".")
    if kind not in figure.FORMATS:
        raise UsageError(f"--figure {name}: a picture ends in one of {', '.join(figure.FORMATS)}")
    ports.replace_file(Path(name), io.BytesIO(figure.draw(calibration, kind)), backup=False)
