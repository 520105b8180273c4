"""The options of `gcomp calibrate`, and how their words are read."""

from __future__ import annotations

import argparse
from typing import Any

from postproc.calibrate import LINES, STEEL, report, square
from postproc.commands import option_text, values
from postproc.commands.machine_values import axis, parts, travel
from postproc.commands.recording_files import reading_arguments
from postproc.errors import UsageError
from postproc.units import URAD

SOURCES = ("straightness", "diagonals", "ballbar")


OPTIONS = f"""
recordings+ REC  recordings of one axis moving, of diagonals, of circles; or a session,
    measurement.toml
-o, --output FOLDER  the machine folder to write; without it nothing is
--force  write over a machine folder; the old one stays as .bak
--json FILE  all of it as JSON ({report.FORMAT}); - for standard output
--figure FILE  draw the components with their uncertainty (.png .svg .pdf)
--report FILE.html  a page with the machine that was found, and what looks wrong
[the machine]
--like MACHINE  take from it what machines of a kind share: control, chain, travels, limits
--title TITLE  what the machine is, in words
--control CONTROL  dialect of its control
--chain CHAIN  who carries whom: w-b-Z-X-t
--diameter AXES  axes whose words are diameters: X
--travel Z=-5,520 ...  mm an axis reaches
--least-increment LENGTH  of the programmed word: 0.001mm
--max-slope UM_PER_MM  limit of a table's slope (5)
--accept-slope  a steeper table is true
--outside (error|clamp)  beyond the targets: refuse, or hold the end value
[how to reckon]
--datum Z=0|none ...  where deviations are zero; none: zeros as recorded
--line ({"|".join(LINES)})  reference line of a straightness
--keep-lines  leave the lines of straightnesses in
--squareness B0X=-382.4,2 ...  urad and its u, or from what: B0X=straightness, B0X=diagonals,
    B0X=ballbar
--square-error URAD,U  angle of the square over 90 degrees, and its u: --square-error=-3,2
--square-at X200,Y150  mm, where the axes stood when the --squareness was measured
--drop-outliers  leave outliers out
--keep-all  write components within their uncertainty too
--mean  one column for both directions: the control takes up the play
--lead Z=5 ...  mm of a turn of the screw
--point X0,Z120  mm, the measured point from the last carriage
--u-random  u_um of the recordings is noise and averages out
--u-temperature K  standard uncertainty of the scale's temperature
--expansion UM_M_K  expansion ({STEEL * 1e6:g} um/(m K))
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(
        parser, OPTIONS, travel=travel, least_increment=values.length, max_slope=float,
        line=LINES[0], squareness=squareness, square_error=_two, square_at=(values.place, {}),
        lead=_length_of, point=(values.place, {}), u_temperature=(float, 0.0),
        expansion=(float, STEEL * 1e6),
    )  # fmt: skip
    reading_arguments(parser)


def _float(text: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} in {whole!r} is not a number")
    return value


def _length_of(text: str) -> tuple[str, float]:
    name, (value,) = parts(text, "Z=5", 1)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r}: a lead is above zero, mm")
    return axis(name, text), value


def _two(text: str) -> tuple[float, float]:
    first, _, second = text.partition(",")
    return _float(first, text) * URAD, abs(_float(second or "0", text)) * URAD


def squareness(text: str) -> tuple[str, Any]:
    name, _, rest = (part.strip() for part in text.partition("="))
    name = name.upper()
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
            name, (place,) = parts(text, "Z=0", 1)
            places[axis(name, text)] = place
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--datum {error}", "--datum Z=0, or --datum none") from None
    return places, "none" in texts
