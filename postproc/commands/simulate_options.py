"""The options of `gcomp simulate`, and how their words are read."""

from __future__ import annotations

import argparse
import math

from postproc.commands import option_text, reading_options, values
from postproc.simulate import instruments

FORMAT = "gcomp-simulate/1"


OPTIONS = f"""
file? PROGRAM  the program; - is standard input
--json FILE  all of it as JSON ({FORMAT}); - for standard output
[what is run and read]
--test NAME:AXES,...  a test of gcomp's own in place of PROGRAM: positioning:Z period:Z arms:Z
    straightness:Z angle:Z diagonal:XZ steps:XYZ ballbar:XY staircase:X feeds:X soak:Z rest:Z
    volume:XYZ; like positioning:Z,step=30,even=1,runs=3,dwell=2,feed=1000
--program-out FILE  write the test's program there; - is standard output
--instrument NAME  {", ".join(instruments.names())} (a test brings its own)
--set KEY=VALUE ...  how the instrument is set; --set help=1 lists
--nominal FILE  the program that PROGRAM was corrected from: readings against its targets, as an
    instrument at the machine takes them
-o, --output REC  write the recording there (standard output)
--parts PARTS  how often the program runs, one behind the other (1)
--with EFFECT:AXIS:KEY=VALUE,... ...  a further effect, like backlash:X:size_um=9 or
    laser_air::ppm_K=0.93
--quiet  no notices, no summary
[what a reading suffers from; um, of angles urad]
--noise UM  standard deviation of a reading (0)
--tails N  Student's t with so many degrees of freedom instead of Gaussian
--seed SEED  of all that is drawn (0)
--resolution UM  step of a reading (0: none)
--zero UM  zero of the set-up, or first (the first reading is zero), or random
--sensor-noise K  standard deviation of temperatures
--without COLUMN,...  channels to leave out of the recording, like T_screw_Z_C; T: all temperatures
[how the control and the room are]
--corner LENGTH  by how much corners between feeds are cut (0.01mm; 0: not at all)
--feed MM_MIN  of motions before the first F, mm/min
--cycle S  in corners that are not cut an axis may change its speed by what it can do in so long
    (0.001)
--play LENGTH  an axis that goes back by less has not turned (0; of a program that gcomp corrected
    the machine's hysteresis_um)
--air C  temperature of the air (20)
--air-drift K_H  its change, K per hour (0)
--screw-gain K  what a screw warms by at a steady 1 m/min, K (0.8)
--screw-time S  and how long it takes, s (1800)
--force X=0:300 ...  N on an axis, in each run in turn
--begin S  time of the experiment at which the program starts, s
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    reading_options.arguments(parser)
    option_text.add(
        parser, OPTIONS, **{"with": {"dest": "terms"}}, set={"type": pair, "dest": "settings"},
        parts=(values.count, 1), noise=(values.size, 0.0), tails=(tails, 0.0),
        seed=(values.seed, 0), resolution=(values.size, 0.0), zero=(zero, 0.0),
        sensor_noise=(values.size, 0.0), without="", corner=(length, 0.01),
        feed=(values.size, math.nan), cycle=(values.size, 0.001), play=length,
        air=(values.number, 20.0), air_drift=(values.number, 0.0), screw_gain=(values.size, 0.8),
        screw_time=(values.size, 1800.0), force=force, begin=(values.size, 0.0),
    )  # fmt: skip


def pair(word: str) -> tuple[str, str]:
    key, sign, value = word.partition("=")
    if not sign or not key:
        raise argparse.ArgumentTypeError(f"{word!r} is not like rate=500")
    return key, value


def length(word: str) -> float:
    """mm, as values.length; 0 is one, too. Raises ArgumentTypeError, as all here."""
    return 0.0 if word.strip() in ("0", "0.0", "0mm", "0um") else values.length(word)


def tails(word: str) -> float:
    """Degrees of freedom of Student's t, more than 2."""
    value = values.number(word)
    if value <= 2:
        raise argparse.ArgumentTypeError(
            f"{word}: with 2 degrees of freedom or less there is no standard deviation"
        )
    return value


def zero(word: str) -> float | str:
    """um, or the word that says where the zero is."""
    return word if word in ("first", "random") else values.number(word)


def force(word: str) -> tuple[str, tuple[float, ...]]:
    """Axis, and N of each run in turn."""
    axis, sign, text = word.partition("=")
    if axis not in ("X", "Y", "Z") or not sign:
        raise argparse.ArgumentTypeError(f"{word!r} is not like X=0:300 (N, in each run in turn)")
    return axis, tuple(values.number(part) for part in text.split(":"))
