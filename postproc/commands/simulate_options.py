"""The options of `gcomp simulate`, and how their words are read."""

from __future__ import annotations

import argparse
import math

from postproc.commands import as_json, reading_options, values
from postproc.simulate import instruments

FORMAT = "gcomp-simulate/1"


def arguments(parser: argparse.ArgumentParser) -> None:
    reading_options.arguments(parser)
    parser.add_argument(
        "file", nargs="?", metavar="PROGRAM", help="the program; - is standard input"
    )
    what = parser.add_argument_group("what is run and read")
    what.add_argument(
        "--test",
        metavar="NAME:AXES,...",
        help=(
            "a test of gcomp's own in place of PROGRAM: positioning:Z period:Z arms:Z"
            " straightness:Z angle:Z diagonal:XZ steps:XYZ ballbar:XY staircase:X feeds:X soak:Z"
            " rest:Z volume:XYZ; like positioning:Z,step=30,even=1,runs=3,dwell=2,feed=1000"
        ),
    )
    what.add_argument(
        "--program-out", metavar="FILE", help="write the test's program there; - is standard output"
    )
    what.add_argument(
        "--instrument",
        metavar="NAME",
        help=f"{', '.join(instruments.names())} (a test brings its own)",
    )
    values.repeated(
        what,
        "--set",
        metavar="KEY=VALUE",
        type=pair,
        dest="settings",
        help="how the instrument is set; --set help=1 lists",
    )
    what.add_argument(
        "--nominal",
        metavar="FILE",
        help=(
            "the program that PROGRAM was corrected from: readings against its targets, as an"
            " instrument at the machine takes them"
        ),
    )
    what.add_argument(
        "-o", "--output", metavar="REC", help="write the recording there (standard output)"
    )
    as_json.argument(parser, FORMAT)
    what.add_argument(
        "--parts",
        type=values.count,
        default=1,
        help="how often the program runs, one behind the other (1)",
    )
    values.repeated(
        what,
        "--with",
        metavar="EFFECT:AXIS:KEY=VALUE,...",
        dest="terms",
        help="a further effect, like backlash:X:size_um=9 or laser_air::ppm_K=0.93",
    )
    what.add_argument("--quiet", action="store_true", help="no notices, no summary")
    noise = parser.add_argument_group("what a reading suffers from; um, of angles urad")
    noise.add_argument(
        "--noise",
        metavar="UM",
        type=values.size,
        default=0.0,
        help="standard deviation of a reading (0)",
    )
    noise.add_argument(
        "--tails",
        metavar="N",
        type=tails,
        default=0.0,
        help="Student's t with so many degrees of freedom instead of Gaussian",
    )
    noise.add_argument("--seed", type=values.seed, default=0, help="of all that is drawn (0)")
    noise.add_argument(
        "--resolution",
        metavar="UM",
        type=values.size,
        default=0.0,
        help="step of a reading (0: none)",
    )
    noise.add_argument(
        "--zero",
        metavar="UM",
        type=zero,
        default=0.0,
        help="zero of the set-up, or first (the first reading is zero), or random",
    )
    noise.add_argument(
        "--sensor-noise",
        metavar="K",
        type=values.size,
        default=0.0,
        help="standard deviation of temperatures",
    )
    noise.add_argument(
        "--without",
        metavar="COLUMN,...",
        default="",
        help="channels that nobody recorded, like T_screw_Z_C; T: all temperatures",
    )
    control = parser.add_argument_group("how the control and the room are")
    control.add_argument(
        "--corner",
        metavar="LENGTH",
        type=length,
        default=0.01,
        help="by how much corners between feeds are cut (0.01mm; 0: not at all)",
    )
    control.add_argument(
        "--feed",
        metavar="MM_MIN",
        type=values.size,
        default=math.nan,
        help="of motions before the first F, mm/min",
    )
    control.add_argument(
        "--cycle",
        metavar="S",
        type=values.size,
        default=0.001,
        help=(
            "in corners that are not cut an axis may change its speed by what it can do in so long"
            " (0.001)"
        ),
    )
    control.add_argument(
        "--play",
        metavar="LENGTH",
        type=length,
        help=(
            "an axis that goes back by less has not turned (0; of a program that gcomp corrected"
            " the machine's hysteresis_um)"
        ),
    )
    control.add_argument(
        "--air", metavar="C", type=values.number, default=20.0, help="temperature of the air (20)"
    )
    control.add_argument(
        "--air-drift",
        metavar="K_H",
        type=values.number,
        default=0.0,
        help="its change, K per hour (0)",
    )
    control.add_argument(
        "--screw-gain",
        metavar="K",
        type=values.size,
        default=0.8,
        help="what a screw warms by at a steady 1 m/min, K (0.8)",
    )
    control.add_argument(
        "--screw-time",
        metavar="S",
        type=values.size,
        default=1800.0,
        help="and how long it takes, s (1800)",
    )
    values.repeated(
        control,
        "--force",
        metavar="X=0:300",
        type=force,
        help="N on an axis, in each run in turn",
    )
    control.add_argument(
        "--begin",
        metavar="S",
        type=values.size,
        default=0.0,
        help="time of the experiment at which the program starts, s",
    )


def pair(word: str) -> tuple[str, str]:
    key, sign, value = word.partition("=")
    if not sign or not key:
        raise argparse.ArgumentTypeError(f"{word!r} is not like rate=500")
    return key, value


def length(word: str) -> float:
    return 0.0 if word.strip() in ("0", "0.0", "0mm", "0um") else values.length(word)


def tails(word: str) -> float:
    value = values.number(word)
    if value <= 2:
        raise argparse.ArgumentTypeError(
            f"{word}: with 2 degrees of freedom or less there is no standard deviation"
        )
    return value


def zero(word: str) -> float | str:
    return word if word in ("first", "random") else values.number(word)


def force(word: str) -> tuple[str, tuple[float, ...]]:
    axis, sign, text = word.partition("=")
    if axis not in ("X", "Y", "Z") or not sign:
        raise argparse.ArgumentTypeError(f"{word!r} is not like X=0:300 (N, in each run in turn)")
    return axis, tuple(values.number(part) for part in text.split(":"))
