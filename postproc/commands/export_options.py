"""The options of `gcomp export`, and how their words are read."""

from __future__ import annotations

import argparse
import math
import re

from postproc.commands import as_json, values
from postproc.commands.export_files import (
    FORMAT,
)

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
        help=(
            "the opposite: say what a control's table takes out, as CSV (-o writes a file for each"
            " axis)"
        ),
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
    as_json.argument(what, FORMAT)
    which = parser.add_argument_group("which part of the map")
    values.repeated(
        which,
        "--axis",
        metavar="Z",
        help="only this moving axis",
    )
    values.repeated(
        which,
        "--component",
        metavar="EXZ",
        help="only this component",
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
    values.repeated(
        how,
        "--set",
        metavar="KEY=VALUE",
        dest="extra",
        help="what one control alone wants",
    )
    how.add_argument(
        "--uncertainty",
        metavar="FILE.csv",
        help=(
            "write the U (95 %%) of what the tables hold beside them, node by node: no control has"
            " a place for it"
        ),
    )
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
