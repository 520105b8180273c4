"""`gcomp iso` evaluates recordings as the ISO 230 series does, and says which test it took them
for."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path

from postproc import ports
from postproc.commands import as_json, option_text, values
from postproc.commands.recording_files import read_files, reading_arguments, reading_options
from postproc.iso import Options, Stated, choose, figure, report
from postproc.iso.lines import LINES
from postproc.units import UM, URAD

HELP = (
    "evaluate recordings by ISO 230: positioning, straightness, squareness, diagonals, circles,"
    " drift at rest, with uncertainty"
)
EXAMPLE = "gcomp iso z_axis.csv --lead 10 --alpha 11.5 --u-temperature 0.5 --figure z_axis.svg"


OPTIONS = f"""
files+ REC  recordings of any format that gcomp knows
--json FILE  all of it as JSON ({report.FORMAT}); - for standard output
--figure FILE  draw the results (.svg .png .pdf); needs matplotlib
--report FILE.html  a page with every result drawn
--line ({"|".join(LINES)})  reference line of straightness and squareness (least-squares)
--lead MM ...  lead of the screw, of all axes or Z=10
[uncertainty (ISO/TR 230-9)] Standard uncertainties, k = 1. What is not stated is not in U, and is
    named.
--device UM  of one reading, um; default: u_um of the recording
--device-angle URAD  of one reading of an angle, urad
--misalignment MRAD  largest angle between beam and axis, mrad
--alpha UM_M_K  expansion coefficient, um/m/K
--u-alpha UM_M_K  its standard uncertainty, um/m/K
--temperature C  mean temperature in the test, degrees Celsius
--u-temperature K  its standard uncertainty, K
--drift UM  whole range of an EVE test of the same duration, um
--u-square URAD  of the square that a squareness rests on, urad
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(
        parser, OPTIONS, line="least-squares", lead=_lead, device=values.size,
        device_angle=values.size, misalignment=values.size, alpha=values.size, u_alpha=values.size,
        temperature=values.number, u_temperature=values.size, drift=values.size,
        u_square=values.size,
    )  # fmt: skip
    reading_arguments(parser)


def run(options: argparse.Namespace) -> int:
    if options.figure:
        figure.check(options.figure)
    read = read_files(options.files, options.format, reading_options(options))
    results, left = choose.results(
        read, Options(options.line, dict(options.lead), _stated(options))
    )
    picture = (
        figure.draw(results, Path(options.figure).suffix[1:].lower()) if options.figure else b""
    )
    print(report.text(results, left), file=as_json.beside(options.json))
    if options.report:
        from postproc.pages import measured

        ports.write_whole(options.report, measured.page(results, left).html().encode("utf-8"))
    if options.figure:
        ports.write_whole(options.figure, picture)
    as_json.put(options.json, report.as_json(results, left))
    return 0


def _stated(options: argparse.Namespace) -> Stated:
    def sized(value: float | None, unit: float) -> float | None:
        return None if value is None else value * unit

    return Stated(
        device=sized(options.device, UM), device_angle=sized(options.device_angle, URAD),
        misalignment=sized(options.misalignment, 1e-3), alpha=sized(options.alpha, 1e-6),
        u_alpha=sized(options.u_alpha, 1e-6), temperature=options.temperature,
        u_temperature=options.u_temperature, drift=sized(options.drift, UM),
        square=sized(options.u_square, URAD),
    )  # fmt: skip


def _lead(word: str) -> tuple[str, float]:
    found = re.fullmatch(r"(?:([XYZ])=)?(.+)", word)
    value = values.number(found[2]) if found else math.nan
    if not found or not value > 0:
        raise argparse.ArgumentTypeError(f"{word!r}: a lead is above zero, like 10 or Z=10")
    return found[1] or "", value
