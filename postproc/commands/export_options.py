"""The options of `gcomp export`, and how their words are read."""

from __future__ import annotations

import argparse
import math
import re

from postproc.commands import option_text
from postproc.commands.export_files import FORMAT

PAIR = re.compile(r"\s*([A-Z])\s*=\s*([-+]?[0-9]+\.?[0-9]*|[-+]?\.[0-9]+)\s*")


OPTIONS = f"""
[what]
--list  the controls, their sign, and what is unverified; with --control its own keys
--control NAME  whose table: gcomp export --list
--machine M  name or folder of the machine whose map is written
--read FILE  the opposite: say what a control's table takes out, as CSV (-o writes a file for each
    axis)
-o, --output FOLDER  where to write: a folder, or a file where it is only one
--residual FOLDER  a machine folder too, for what the control can not hold: gcomp corrects the rest
--force  overwrite files that are there
--json FILE  all of it as JSON ({FORMAT}); - for standard output
[which part of the map]
--axis Z ...  only this moving axis
--component EXZ ...  only this component
--only EXX,EZZ  as --component, several at once
--at X=0,Y=100  mm: where the other axes stand (rotations times arms)
--one-way  the mean of both directions, also where the control knows both
[how the control is set up]
--unit (mm|inch)  of the control's basic system (mm)
--spacing MM  mm between points, where they are even
--reference X=0,Z=0  mm: reference (home) position of the axes
--first X=1  number of the first or the reference point
--step MM  mm of one detection unit (0.001)
--set KEY=VALUE ...  what one control alone wants
--uncertainty FILE.csv  write the U (95 %%) of what the tables hold beside them, node by node: no
    control has a place for it
--template FILE  an empty table that the control has exported, to be filled
--settings FILE  with --read: the control's parameters, where they are in a file of their own
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(
        parser, OPTIONS, only=(lambda text: text.split(","), []), at=(_numbers, {}), unit="mm",
        spacing=(_positive, 0.0), reference=(_numbers, {}), first=(_numbers, {}),
        step=(_positive, 0.001), set={"dest": "extra"},
    )  # fmt: skip


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
