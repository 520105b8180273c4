"""`gcomp simulate`: runs a program, or a test that it writes itself, on a machine with errors, and
gives the recording."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postproc import intake, marks, ports, standing
from postproc.commands import as_json, expansion, reading
from postproc.commands.simulate_options import FORMAT
from postproc.commands.simulate_options import arguments as arguments
from postproc.errors import GcompError, Notice, Place, UsageError

if TYPE_CHECKING:
    from postproc.filter import Filter
    from postproc.machine.model import Machine
    from postproc.recordings import Recording
    from postproc.simulate.actual import Term
    from postproc.simulate.instruments import Settings, Signal
    from postproc.simulate.limits import Limits
    from postproc.simulate.program import Steps
    from postproc.simulate.timeline import Timeline

HELP = (
    "run a program on a machine with all its errors and write what an instrument would have"
    " recorded"
)
EXAMPLE = "gcomp simulate --test positioning:Z --machine studer-s36 --noise 0.5 --seed 1 -o z.csv"
NOT_HERE = (
    "tolerance", "hole_tolerance", "hysteresis", "reversal", "ramp", "outside", "cut_rapids",
    "orientation", "temperatures",
)  # fmt: skip


def run(options: argparse.Namespace) -> int:
    from postproc.commands import simulate_named
    from postproc.recordings.contract import write
    from postproc.simulate import actual, instruments
    from postproc.simulate import limits as bounds

    _refuse(options)
    machine = reading.machine_of(options)
    text, name, own = _program(options, machine)
    _spares(options, text if own else b"()")
    if own and _is_all(options, text):
        as_json.put(options.json, _report(options, machine, name))
        return 0
    instrument = _instrument(options, own)
    module = instruments.load(instrument)
    given = dict(options.settings)
    if given.pop("help", None):
        print("\n".join(map(": ".join, module.SETTINGS.items())))
        return 0
    of_test = own.settings if own and own.instrument == instrument else {}
    settings = instruments.Settings(instrument, module.SETTINGS, of_test | given)
    limits = bounds.of(machine, _stated(options.machine))
    run_, notices, corrected = _timeline(options, machine, limits, text, name)
    notices += _assumed(options, machine, limits, corrected)
    said = [simulate_named.term(word, machine) for word in options.terms]
    terms = (*actual.terms_of(machine), *said)
    before = _nominal(options, machine, limits, corrected) if options.nominal else None
    signal = _signal(module, settings, run_, before, terms)
    notices += _held(machine, signal.state.position)
    noise = instruments.Noise(
        options.noise, options.tails, options.resolution, options.zero, options.seed,
        options.sensor_noise,
    )  # fmt: skip
    head = _head(options, machine, name, corrected)
    recording = instruments.recorded(
        signal, noise, head, simulate_named.without(options.without, signal.state.channels)
    )
    _write(options.output or "-", write(recording).encode())
    rows = f"gcomp: {len(recording)} rows of {module.TITLE}"
    _say(options, notices, f"{rows}, {run_.duration:.1f} s of machine time")
    found = {
        "instrument": instrument, "title": module.TITLE, "corrected": corrected,
        "rows": len(recording), "seconds": round(run_.duration, 3), "columns": _ranges(recording),
        "notices": _facts(notices),
    }  # fmt: skip
    as_json.put(options.json, _report(options, machine, name) | found)
    return 0


def _instrument(options: argparse.Namespace, own: Any) -> str:
    """The instrument that is named, or that belongs to the test. Raises UsageError."""
    from postproc.simulate import instruments

    if name := options.instrument or (own.instrument if own else ""):
        return name
    raise UsageError("which instrument?", f"--instrument {' or '.join(instruments.names())}")


def _facts(notices: list[Notice]) -> list[dict[str, Any]]:
    """Notices for other programs."""
    return [{"message": n.message, "line": n.line or None} for n in notices]


def _ranges(recording: Recording) -> dict[str, dict[str, float]]:
    return {
        name: {"least": float(column.min()), "largest": float(column.max())}
        for name, column in recording.columns.items()
        if column.dtype.kind == "f"
    }


def _refuse(options: argparse.Namespace) -> None:
    """Raises UsageError for two outputs in one place, or an option of corrections."""
    if options.json == "-" and options.output in (None, "-"):
        raise UsageError("the recording goes to standard output, and --json - too", "-o FILE.csv")
    for name in NOT_HERE:
        if getattr(options, name) not in (None, False):
            raise UsageError(
                f"--{name.replace('_', '-')} is for corrections, and nothing is corrected here",
                "gcomp corrects: gcomp --machine NAME FILE",
            )


def _assumed(
    options: argparse.Namespace, machine: Machine, limits: Limits, corrected: bool
) -> Iterator[Notice]:
    """What was taken for granted: the play of a corrected program, limits that are not stated."""
    from postproc.simulate import limits as bounds

    if options.play is None and corrected:
        yield Notice(
            "play",
            "this program is corrected: an axis that goes back by less than"
            f" {machine.limits.hysteresis * 1e3:g} um (hysteresis_um) has not turned (--play)",
        )
    if limits.assumed:
        yield Notice(
            "limits",
            f"{machine.name} states no velocity and acceleration of {' '.join(limits.assumed)}:"
            f" taken as {bounds.VELOCITY * 60:g} mm/min and {bounds.ACCELERATION:g} mm/s2",
        )


def _signal(
    module: Any,
    settings: Settings,
    run_: Timeline,
    before: Timeline | None,
    terms: tuple[Term, ...],
) -> Signal:
    """What the instrument reads: against the targets of the nominal program, where there is one."""
    from postproc.simulate import actual, nominal

    if before is None:
        return module.measure(actual.Reality(run_, terms), settings)
    #     nominal program   -> targets, and the readings that they are taken against
    #     corrected program -> readings of the same targets
    # A corrected program commands other places; an instrument is set up for those of the drawing.
    wanted = module.measure(actual.Reality(before, terms), settings)
    aim = nominal.aimed(settings, wanted)
    return nominal.against(module.measure(actual.Reality(run_, terms), aim), wanted)


def _head(
    options: argparse.Namespace, machine: Machine, name: str, corrected: bool
) -> dict[str, Any]:
    """What the recording says of itself."""
    head: dict[str, Any] = {
        "machine": machine.name,
        "program": Path(name).name,
        "corner_mm": options.corner,
    }
    if corrected:
        head |= {"compensated": True, "against": "nominal" if options.nominal else "commanded"}
    if options.terms:
        head["with"] = list(options.terms)
    return head


def _say(options: argparse.Namespace, notices: list[Notice], last: str) -> None:
    """Notices and a last line for a person, unless --quiet."""
    if options.quiet:
        return
    for notice in notices:
        where = f" (line {notice.line})" if notice.line else ""
        print(f"gcomp: notice: {notice.message}{where}", file=sys.stderr)
    print(last, file=sys.stderr)


def _report(options: argparse.Namespace, machine: Machine, name: str) -> dict[str, Any]:
    """What was run, and where what came of it stands."""
    return {
        "format": FORMAT, "machine": machine.name, "program": name, "with": list(options.terms),
        "seed": options.seed, "recording": options.output, "program_written": options.program_out,
    }  # fmt: skip


def _timeline(
    options: argparse.Namespace, machine: Machine, limits: Limits, text: bytes, name: str
):
    """A program in time, notices, and whether gcomp has corrected it. Raises GcompError beyond a
    travel."""
    from postproc.commands import simulate_named
    from postproc.simulate import timeline
    from postproc.simulate.history import Heat

    steps, letters, notices, corrected = _read(options, machine, text, name)
    # by less a correction lets an axis creep back unturned
    play = machine.limits.hysteresis if corrected else 0.0
    conditions = timeline.Conditions(
        corner=options.corner,
        cycle=options.cycle,
        play=play if options.play is None else options.play,
        heat=Heat(options.air, options.air_drift, options.screw_gain, max(options.screw_time, 1.0)),
        begin=options.begin,
        force=simulate_named.forces(options.force, machine),
    )
    run_ = timeline.of(steps, machine, limits, conditions, letters)
    if wrong := run_.outside():
        line, axis, at = wrong
        low, high = machine.axes[axis].travel
        raise GcompError(
            f"the program takes {axis} to {at:.4f} mm, beyond its travel ({low:g} to {high:g} mm)",
            "is the work offset right? --offset, --offsets",
            Place(name, line),
        )
    return run_, notices, corrected


def _nominal(
    options: argparse.Namespace, machine: Machine, limits: Limits, corrected: bool
) -> Timeline:
    """The nominal program in time, for its targets. Raises UsageError where it is not the nominal
    one."""
    if not corrected:
        raise UsageError(
            "--nominal is for a program that gcomp has corrected, and this one has no mark of it",
            "without --nominal readings are against the program's own targets",
        )
    with ports.opened(options.nominal) as (source, name, _):
        text = source.read(intake.PROGRAM + 1)
    run_, _, marked = _timeline(options, machine, limits, text, name)
    if marked:
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
        text = source.read(intake.PROGRAM + 1)
    if len(text) > intake.PROGRAM:
        raise UsageError(f"{name} has more than {intake.PROGRAM:,} bytes")
    return text, name, None


def _read(options: argparse.Namespace, machine: Machine, text: bytes, name: str):
    """Steps of all parts, the axes of their rows, notices, and whether gcomp has corrected the
    program."""
    from postproc.simulate.program import Reader

    def make(bare: Machine, start: dict[str, float]) -> Filter:
        own = argparse.Namespace(
            **(vars(options) | {"start": options.start | start, "temperatures": None})
        )
        return reading.filter_of(own, bare, text[: ports.HEAD])

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
    return dict(reading.stated(name)["axes"])


def _held(machine: Machine, position: dict) -> Iterator[Notice]:
    """A notice for every axis that is read where its table does not reach."""
    for x, table in machine.tables.items():
        low, high = float(table.nodes[0]), float(table.nodes[-1])
        if x in position and not (
            position[x].min() >= low - 1e-6 and position[x].max() <= high + 1e-6
        ):
            yield Notice(
                f"table {x}",
                f"{x} is read beyond its table ({low:g} to {high:g}): its end values are held"
                " there",
            )


def _spares(options: argparse.Namespace, text: bytes) -> None:
    """Raises UsageError for a recording that was not simulated, or a program of another test: the
    comment that it begins with says which."""
    if options.output:
        standing.result(options.output, marks.SIMULATED, "another name")
    if options.program_out:
        comment = next(x for x in text.splitlines() if x[:1] in (b"(", b";"))
        standing.result(options.program_out, marks.comment(comment), "another name")


def _is_all(options: argparse.Namespace, text: bytes) -> bool:
    """Writes the program of a test where it is asked for; whether nothing else is."""
    if options.program_out:
        _write(options.program_out, text)
    return bool(options.program_out) and not options.output


def _write(name: str, data: bytes) -> None:
    if name == "-":
        ports.write_standard(data)
        return
    ports.write_whole(name, data)
