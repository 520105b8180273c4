"""`gcomp simulate`: runs a program, or a test that it writes itself, on a machine with errors, and gives the recording."""

from __future__ import annotations

import argparse
import io
import math
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postproc import ports
from postproc.commands import expansion, reading, values
from postproc.errors import GcompError, Notice, Place, UsageError

if TYPE_CHECKING:
    from postproc.filter import Filter
    from postproc.machine.model import Machine
    from postproc.simulate.actual import Term
    from postproc.simulate.limits import Limits
    from postproc.simulate.program import Steps
    from postproc.simulate.timeline import Timeline

HELP = "run a program on a machine with all its errors and write what an instrument would have recorded"
EXAMPLE = "gcomp simulate --test positioning:Z --machine studer-s36 --noise 0.5 --seed 1 -o z.csv"
LARGEST = 100_000_000  # bytes
NOT_HERE = (
    "tolerance",
    "hole_tolerance",
    "hysteresis",
    "reversal",
    "ramp",
    "outside",
    "cut_rapids",
    "orientation",
    "temperatures",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    reading.arguments(parser)
    parser.add_argument(
        "file", nargs="?", metavar="PROGRAM", help="the program; - is standard input"
    )
    what = parser.add_argument_group("what is run and read")
    what.add_argument("--test", metavar="NAME:AXES,...", help="a test of gcomp's own in place of PROGRAM: positioning:Z period:Z arms:Z straightness:Z angle:Z diagonal:XZ ballbar:XY staircase:X feeds:X soak:Z rest:Z volume:XYZ; like positioning:Z,step=30,even=1,runs=3,dwell=2,feed=1000")  # fmt: skip
    what.add_argument(
        "--program-out", metavar="FILE", help="write the test's program there; - is standard output"
    )
    what.add_argument("--instrument", metavar="NAME", help="laser, straightness, angle, ballbar, tracker, log or probe (a test brings its own)")  # fmt: skip
    what.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], type=_pair, dest="settings", help="how the instrument is set; --set help=1 lists")  # fmt: skip
    what.add_argument("--nominal", metavar="FILE", help="the program that PROGRAM was corrected from: readings against its targets, as an instrument at the machine takes them")  # fmt: skip
    what.add_argument(
        "-o", "--output", metavar="REC", help="write the recording there (standard output)"
    )
    what.add_argument(
        "--parts",
        type=values.count,
        default=1,
        help="how often the program runs, one behind the other (1)",
    )
    what.add_argument("--with", metavar="EFFECT:AXIS:KEY=VALUE,...", action="append", default=[], dest="terms", help="a further effect, like backlash:X:size_um=9 or laser_air::ppm_K=0.93")  # fmt: skip
    what.add_argument("--quiet", action="store_true", help="no notices, no summary")
    noise = parser.add_argument_group("what a reading suffers from; um, of angles urad")
    noise.add_argument(
        "--noise",
        metavar="UM",
        type=values.size,
        default=0.0,
        help="standard deviation of a reading (0)",
    )
    noise.add_argument("--tails", metavar="N", type=_tails, default=0.0, help="Student's t with so many degrees of freedom instead of Gaussian")  # fmt: skip
    noise.add_argument("--seed", type=values.seed, default=0, help="of all that is drawn (0)")
    noise.add_argument(
        "--resolution",
        metavar="UM",
        type=values.size,
        default=0.0,
        help="step of a reading (0: none)",
    )
    noise.add_argument("--zero", metavar="UM", type=_zero, default=0.0, help="zero of the set-up, or first (the first reading is zero), or random")  # fmt: skip
    noise.add_argument(
        "--sensor-noise",
        metavar="K",
        type=values.size,
        default=0.0,
        help="standard deviation of temperatures",
    )
    noise.add_argument("--without", metavar="COLUMN,...", default="", help="channels that nobody recorded, like T_screw_Z_C; T: all temperatures")  # fmt: skip
    control = parser.add_argument_group("how the control and the room are")
    control.add_argument("--corner", metavar="LENGTH", type=_length, default=0.01, help="by how much corners between feeds are cut (0.01mm; 0: not at all)")  # fmt: skip
    control.add_argument("--feed", metavar="MM_MIN", type=values.size, default=math.nan, help="of motions before the first F, mm/min")  # fmt: skip
    control.add_argument("--cycle", metavar="S", type=values.size, default=0.001, help="in corners that are not cut an axis may change its speed by what it can do in so long (0.001)")  # fmt: skip
    control.add_argument("--play", metavar="LENGTH", type=_length, help="an axis that goes back by less has not turned (0; of a program that gcomp corrected the machine's hysteresis_um)")  # fmt: skip
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
    control.add_argument("--screw-gain", metavar="K", type=values.size, default=0.8, help="what a screw warms by at a steady 1 m/min, K (0.8)")  # fmt: skip
    control.add_argument(
        "--screw-time",
        metavar="S",
        type=values.size,
        default=1800.0,
        help="and how long it takes, s (1800)",
    )
    control.add_argument("--force", metavar="X=0:300", action="append", default=[], type=_force, help="N on an axis, in each run in turn")  # fmt: skip
    control.add_argument("--begin", metavar="S", type=values.size, default=0.0, help="time of the experiment at which the program starts, s")  # fmt: skip


def run(options: argparse.Namespace) -> int:
    from postproc.simulate import actual, instruments, nominal
    from postproc.simulate import limits as bounds

    for name in NOT_HERE:
        if getattr(options, name) not in (None, False):
            raise UsageError(f"--{name.replace('_', '-')} is for corrections, and nothing is corrected here", "gcomp corrects: gcomp --machine NAME FILE")  # fmt: skip
    machine = reading.machine_of(options)
    given = dict(options.settings)
    text, name, own = _program(options, machine)
    instrument = options.instrument or (own.instrument if own else "")
    if own and options.program_out:
        _write(options.program_out, text)
        if not options.output:
            return 0
    if not instrument:
        raise UsageError("which instrument?", f"--instrument {' or '.join(instruments.names())}")
    module = instruments.load(instrument)
    if given.pop("help", None):
        print("\n".join(f"{key}: {meaning}" for key, meaning in module.SETTINGS.items()))
        return 0
    if own and own.instrument == instrument:
        given = own.settings | given
    settings = instruments.Settings(instrument, module.SETTINGS, given)
    limits = bounds.of(machine, _stated(options.machine))
    run_, notices, corrected = _timeline(options, machine, limits, text, name)
    if options.play is None and corrected:
        notices.append(Notice("play", f"this program is corrected: an axis that goes back by less than {machine.limits.hysteresis * 1e3:g} um (hysteresis_um) has not turned (--play)"))  # fmt: skip
    if limits.assumed:
        notices.append(Notice("limits", f"{machine.name} states no velocity and acceleration of {' '.join(limits.assumed)}: taken as {bounds.VELOCITY * 60:g} mm/min and {bounds.ACCELERATION:g} mm/s2"))  # fmt: skip
    extra = [_term(word, machine) for word in options.terms]
    terms = (*actual.terms_of(machine), *extra)
    if options.nominal:
        before = _nominal(options, machine, limits, corrected)
        wanted = module.measure(actual.Reality(before, terms), settings)
        aim = nominal.aimed(settings, wanted)
        signal = nominal.against(module.measure(actual.Reality(run_, terms), aim), wanted)
    else:
        signal = module.measure(actual.Reality(run_, terms), settings)
    notices += _held(machine, signal.state.position)
    noise = instruments.Noise(options.noise, options.tails, options.resolution, options.zero, options.seed, options.sensor_noise)  # fmt: skip
    head: dict[str, Any] = {
        "machine": machine.name,
        "program": Path(name).name,
        "corner_mm": options.corner,
    }
    if corrected:
        head |= {"compensated": True, "against": "nominal" if options.nominal else "commanded"}
    if extra:
        head["with"] = list(options.terms)
    recording = instruments.recorded(
        signal, noise, head, _without(options.without, signal.state.channels)
    )
    from postproc.recordings.contract import write

    _write(options.output or "-", write(recording).encode())
    if not options.quiet:
        for notice in notices:
            print(
                f"gcomp: notice: {notice.message}"
                + (f" (line {notice.line})" if notice.line else ""),
                file=sys.stderr,
            )
        print(
            f"gcomp: {len(recording)} rows of {module.TITLE}, {run_.duration:.1f} s of machine time",
            file=sys.stderr,
        )
    return 0


def _timeline(
    options: argparse.Namespace, machine: Machine, limits: Limits, text: bytes, name: str
):
    """A program in time, notices, and whether gcomp has corrected it. Raises GcompError beyond a travel."""
    from postproc.simulate import timeline
    from postproc.simulate.history import Heat

    steps, letters, notices, corrected = _read(options, machine, text, name)
    play = (
        machine.limits.hysteresis if corrected else 0.0
    )  # by less a correction lets an axis creep back unturned
    conditions = timeline.Conditions(
        corner=options.corner, cycle=options.cycle, play=play if options.play is None else options.play,
        heat=Heat(options.air, options.air_drift, options.screw_gain, max(options.screw_time, 1.0)), begin=options.begin,
        force=_forces(options.force, machine),
    )  # fmt: skip
    run_ = timeline.of(steps, machine, limits, conditions, letters)
    wrong = run_.outside()
    if wrong:
        line, axis, at = wrong
        low, high = machine.axes[axis].travel
        raise GcompError(f"the program takes {axis} to {at:.4f} mm, beyond its travel ({low:g} to {high:g} mm)", "is the work offset right? --offset, --offsets", Place(name, line))  # fmt: skip
    return run_, notices, corrected


def _nominal(
    options: argparse.Namespace, machine: Machine, limits: Limits, corrected: bool
) -> Timeline:
    """The nominal program in time, for its targets. Raises UsageError where it is not the nominal one."""
    if not corrected:
        raise UsageError("--nominal is for a program that gcomp has corrected, and this one has no mark of it", "without --nominal readings are against the program's own targets")  # fmt: skip
    with ports.opened(options.nominal) as (source, name, _):
        text = source.read(LARGEST + 1)
    run_, _, again = _timeline(options, machine, limits, text, name)
    if again:
        raise UsageError(
            f"{name} is corrected too", "--nominal names the program that was given to gcomp"
        )
    return run_


def _program(options: argparse.Namespace, machine: Machine):
    """The program's text, its name, and the test that it is, if any."""
    if options.test:
        from postproc.simulate import experiments

        if options.file:
            raise UsageError("a test brings its own program: --test or PROGRAM, not both")
        own = experiments.write(options.test, machine, options.dialect or machine.control)
        return own.text.encode(), options.test, own
    if options.program_out:
        raise UsageError("--program-out writes the program of a --test")
    with ports.opened(options.file) as (source, name, _):
        text = source.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise UsageError(f"{name} has more than {LARGEST:,} bytes")
    return text, name, None


def _read(options: argparse.Namespace, machine: Machine, text: bytes, name: str):
    """Steps of all parts, the axes of their rows, notices, and whether gcomp has corrected the program."""
    from postproc.simulate.program import Reader

    def make(bare: Machine, start: dict[str, float]) -> Filter:
        again = argparse.Namespace(
            **(vars(options) | {"start": options.start | start, "temperatures": None})
        )
        return reading.filter_of(again, bare, text[: ports.HEAD])

    reader = Reader(machine, make, name, options.feed / 60.0)
    start: dict[str, float] = {}
    for part in range(1, options.parts + 1):
        portions: Iterable[bytes] = (text,)
        if options.expand:
            portions = expansion.written_out(
                make(reader.machine, start), io.BytesIO(text), options, keeps=False
            )
        start = reader.read(portions, part, start)
    rest = {x: min(max(0.0, a.travel[0]), a.travel[1]) for x, a in machine.axes.items()}
    steps: Steps = reader.steps(rest)
    return steps, reader.letters, reader.notices, reader.corrected


def _stated(name: str) -> dict[str, Any]:
    """The [axes.X] sections of a machine's file, which has been read and found good."""
    from postproc.machine import places

    path = Path(name)
    known = places.every()
    folder = (
        path
        if len(path.parts) > 1 or path.is_absolute() or (path / "machine.toml").is_file()
        else known[name]
    )
    return dict(tomllib.loads((folder / "machine.toml").read_text("utf-8-sig"))["axes"])


def _term(word: str, machine: Machine) -> Term:
    """An effect from "backlash:X:size_um=9"."""
    from postproc import effects
    from postproc.simulate.actual import Term

    name, _, rest = word.partition(":")
    axis, _, text = rest.partition(":")
    if name not in effects.names():
        raise UsageError(f"there is no effect {name!r}", f"effects: {', '.join(effects.names())}")
    module = effects.load(name)
    number = {"all": 0, "axis": 1, "pair": 2}[module.PER]
    good = (
        len(axis) == number
        and len(set(axis)) == number
        and all(x in machine.axes and x in "XYZ" for x in axis)
    )
    if not good:
        like = {0: "", 1: "X", 2: "XZ"}[number]
        raise UsageError(f"--with {word}: {axis!r} is not what {name} acts on", f"like {name}:{like}:...; axes: {' '.join(machine.letters)}")  # fmt: skip
    parameters = dict(getattr(module, "OPTIONAL", {}))
    for item in filter(None, text.split(",")):
        key, _, value = item.partition("=")
        if key not in module.PARAMETERS:
            told = "; ".join(f"{k} ({v})" for k, v in module.PARAMETERS.items())
            raise UsageError(f"--with {word}: {name} has no {key!r}", f"its parameters: {told}")
        parameters[key] = values.number(value)
    missing = [key for key in module.PARAMETERS if key not in parameters]
    if missing:
        raise UsageError(f"--with {word}: {missing[0]} is missing", module.PARAMETERS[missing[0]])
    return Term(module, axis, parameters)


def _held(machine: Machine, position: dict) -> list[Notice]:
    """A notice for every axis that is read where its table does not reach."""
    result = []
    for x, table in machine.tables.items():
        low, high = float(table.nodes[0]), float(table.nodes[-1])
        if x in position and not (
            position[x].min() >= low - 1e-6 and position[x].max() <= high + 1e-6
        ):
            result.append(Notice(f"table {x}", f"{x} is read beyond its table ({low:g} to {high:g}): its end values are held there"))  # fmt: skip
    return result


def _forces(
    given: list[tuple[str, tuple[float, ...]]], machine: Machine
) -> dict[str, tuple[float, ...]]:
    for axis, _ in given:
        if axis not in machine.axes:
            raise UsageError(f"--force names {axis}, which is no axis of {machine.name}", f"its axes are {' '.join(machine.letters)}")  # fmt: skip
    return dict(given)


def _without(text: str, channels: dict) -> tuple[str, ...]:
    wanted = [word.strip() for word in text.split(",") if word.strip()]
    found: list[str] = []
    for word in wanted:
        some = [c for c in channels if c == word or (word == "T" and c.startswith("T_"))]
        if not some:
            raise UsageError(
                f"--without {word}: there is no such channel", f"channels: {', '.join(channels)}"
            )
        found += some
    return tuple(found)


def _write(name: str, data: bytes) -> None:
    if name == "-":
        ports.write_standard(data)
        return
    ports.replace_file(Path(name), io.BytesIO(data), backup=False)


def _pair(word: str) -> tuple[str, str]:
    key, sign, value = word.partition("=")
    if not sign or not key:
        raise argparse.ArgumentTypeError(f"{word!r} is not like rate=500")
    return key, value


def _length(word: str) -> float:
    return 0.0 if word.strip() in ("0", "0.0", "0mm", "0um") else values.length(word)


def _tails(word: str) -> float:
    value = values.number(word)
    if value <= 2:
        raise argparse.ArgumentTypeError(
            f"{word}: with 2 degrees of freedom or less there is no standard deviation"
        )
    return value


def _zero(word: str) -> float | str:
    return word if word in ("first", "random") else values.number(word)


def _force(word: str) -> tuple[str, tuple[float, ...]]:
    axis, sign, text = word.partition("=")
    if axis not in ("X", "Y", "Z") or not sign:
        raise argparse.ArgumentTypeError(f"{word!r} is not like X=0:300 (N, in each run in turn)")
    return axis, tuple(values.number(part) for part in text.split(":"))
