"""The options of `gcomp calibrate`, and how their words are read."""

from __future__ import annotations

import argparse
from typing import Any

from postproc.calibrate import (
    LINES,
    STEEL,
    report,
    square,
)
from postproc.commands import as_json, values
from postproc.commands.recording_files import reading_arguments
from postproc.errors import UsageError
from postproc.units import URAD

SOURCES = ("straightness", "diagonals", "ballbar")


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recordings",
        nargs="+",
        metavar="REC",
        help=(
            "recordings of one axis moving, of diagonals, of circles; or a session,"
            " measurement.toml"
        ),
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
    values.repeated(
        machine,
        "--travel",
        type=_range,
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
    values.repeated(
        how,
        "--datum",
        metavar="Z=0|none",
        help="where deviations are zero; none: zeros as recorded",
    )
    how.add_argument(
        "--line", choices=LINES, default=LINES[0], help="reference line of a straightness"
    )
    how.add_argument(
        "--keep-lines", action="store_true", help="leave the lines of straightnesses in"
    )
    values.repeated(
        how,
        "--squareness",
        type=squareness,
        metavar="B0X=-382.4,2",
        help="urad and its u, or from what: B0X=straightness, B0X=diagonals, B0X=ballbar",
    )
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
    values.repeated(
        how,
        "--lead",
        type=_length_of,
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


def named(text: str) -> tuple[str, str]:
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
    name, rest = named(text)
    low, _, high = rest.partition(",")
    result = _float(low, text), _float(high, text)
    if result[0] >= result[1]:
        raise argparse.ArgumentTypeError(f"{text!r} must be two ascending numbers, mm: Z=-5,520")
    return _axis(name, text), result


def _length_of(text: str) -> tuple[str, float]:
    name, rest = named(text)
    value = _float(rest, text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r}: a lead is above zero, mm")
    return _axis(name, text), value


def _two(text: str) -> tuple[float, float]:
    first, _, second = text.partition(",")
    return _float(first, text) * URAD, abs(_float(second or "0", text)) * URAD


def squareness(text: str) -> tuple[str, Any]:
    name, rest = named(text)
    if name not in square.NAMES:
        raise argparse.ArgumentTypeError(
            f"{text!r}: {name!r} is not one of {', '.join(square.NAMES)}"
        )
    if rest in SOURCES:
        return name, rest
    first, comma, second = rest.partition(",")
    return name, (_float(first, text) * URAD, abs(_float(second, text)) * URAD if comma else None)


def datum_of(texts: list[str]) -> tuple[dict[str, float], bool]:
    """Positions by axis, and whether zeros stay as recorded."""
    places: dict[str, float] = {}
    for text in texts:
        if text == "none":
            continue
        try:
            name, rest = named(text)
            places[_axis(name, text)] = _float(rest, text)
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--datum {error}", "--datum Z=0, or --datum none") from None
    return places, "none" in texts
