"""The main job: a program in, the corrected program out."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from postproc import ports
from postproc.commands import values
from postproc.errors import GcompError, Notice, UsageError

if TYPE_CHECKING:
    from postproc.filter import Filter

HELP = "correct a program for a machine (the default: gcomp --machine NAME FILE)"
EXAMPLE = "cat job.nc | gcomp --machine studer-s36 > job_comp.nc"


def arguments(parser: argparse.ArgumentParser) -> None:
    reading(parser)
    out = parser.add_argument_group("where it goes")
    out.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="write here instead of to standard output; in one step, when all is accepted",
    )
    out.add_argument(
        "--in-place", action="store_true", help="correct FILE itself; its old content stays beside it as FILE.bak"
    )
    out.add_argument(
        "--unbuffered",
        action="store_true",
        help="pass block by block, for live pipes; a refusal then comes after what is already out",
    )
    out.add_argument("--dry-run", action="store_true", help="write no program: say what would change")
    say = parser.add_argument_group("what it says")
    say.add_argument(
        "--verify",
        action="store_true",
        help="replay the output on the machine's model and report the largest deviation left; refuse the output if it is over the tolerance",
    )
    say.add_argument("--quiet", action="store_true", help="no notices, no summary")
    say.add_argument(
        "--filter-progress",
        action="store_true",
        help="print FILTER_PROGRESS=nn on standard error, as LinuxCNC's filters do",
    )
    parser.add_argument("file", nargs="?", metavar="FILE", help="the program; standard input if missing")


def reading(parser: argparse.ArgumentParser) -> None:
    """The options that say for which machine, how, and in which language: shared by all that read programs."""
    parser.add_argument(
        "--machine",
        metavar="NAME",
        required=True,
        help="a machine by name (gcomp machines) or by the path of its folder",
    )
    how = parser.add_argument_group("how it is corrected")
    how.add_argument(
        "--tolerance",
        metavar="LENGTH",
        type=values.length,
        help="how far the path may stay off: 0.5um, 0.001mm (default: one least increment, 0.5um at least)",
    )
    how.add_argument(
        "--reversal",
        choices=("mean", "step", "ramp", "off"),
        help="what to do where an axis turns back (default: the machine's, or step)",
    )
    how.add_argument(
        "--ramp", metavar="LENGTH", type=values.length, help="travel over which --reversal ramp takes up the difference"
    )
    how.add_argument(
        "--outside", choices=("error", "clamp"), help="points outside the error tables: refuse, or hold the end value"
    )
    how.add_argument("--cut-rapids", action="store_true", help="cut G0 at the map's nodes too")
    program = parser.add_argument_group("how the program is read")
    program.add_argument("--dialect", metavar="NAME", help="the control's language, if not the machine's own")
    program.add_argument(
        "--offset",
        metavar="G54=X1,Z2",
        action="append",
        default=[],
        type=values.offset,
        help="where a work or tool offset's zero lies, mm, radius, machine coordinates; repeatable",
    )
    program.add_argument(
        "--start",
        metavar="X0,Z0",
        type=values.place,
        default={},
        help="where the machine stands before the program, mm, radius, machine coordinates",
    )
    program.add_argument(
        "--block-delete",
        choices=("on", "off"),
        default="off",
        help="whether blocks that begin with / are skipped at the machine",
    )
    program.add_argument(
        "--arc-centre",
        choices=("incremental", "absolute"),
        default="incremental",
        help="what I J K mean when no G90.1 or G91.1 says so",
    )


def run(options: argparse.Namespace) -> int:
    filter_ = filter_of(options)
    if options.in_place and (options.output or options.file in (None, "-")):
        raise UsageError("--in-place corrects FILE itself: it needs a FILE and no --output")
    if options.unbuffered and (options.output or options.in_place or options.dry_run):
        raise UsageError(
            "--unbuffered writes to standard output as it goes: not with --output, --in-place or --dry-run"
        )
    with ports.opened(options.file) as (source, name, size):
        filter_.name = name
        verifier = None
        if options.verify:
            from postproc.verify import Verifier

            verifier = Verifier(filter_)
        if options.unbuffered:
            _live(filter_, source)
        else:
            _whole(filter_, source, size, options, verifier)
    if verifier:
        print(f"gcomp: verified: {verifier.report()}", file=sys.stderr)
    if not options.quiet:
        _say(filter_.notices)
        if not options.dry_run:
            print(f"gcomp: {summary(filter_)}", file=sys.stderr)
    return 0


def filter_of(options: argparse.Namespace) -> Filter:
    """A filter as the options want it."""
    from postproc.compensate import Options
    from postproc.filter import Filter, setup_of
    from postproc.machine import places
    from postproc.nc import dialects

    machine = places.load(options.machine)
    dialect = dialects.load(options.dialect or machine.control)
    for name, place in [*options.offset, ("--start", options.start)]:
        for axis in place:
            if axis not in machine.axes:
                raise UsageError(
                    f"{name} names {axis}, which is no axis of {machine.name}",
                    f"its axes are {' '.join(machine.letters)}",
                )
    setup = setup_of(machine, dict(options.offset), options.start, options.block_delete == "on", options.arc_centre)
    how = Options(options.tolerance, options.outside, options.reversal, options.ramp, options.cut_rapids)
    return Filter(machine, dialect, setup, how)


def _live(filter_: Filter, source) -> None:
    """Block by block; on a fault what came before it is out already."""
    try:
        for data in ports.chunks(source, live=True):
            ports.write_standard(filter_.feed(data))
        ports.write_standard(filter_.finish())
    except GcompError as error:
        ports.write_standard(getattr(error, "delivered", b""))
        raise


def _whole(filter_: Filter, source, size: int, options: argparse.Namespace, verifier) -> None:
    """Everything accepted first, then everything written."""
    with ports.spool() as spool, _progress(size, options) as step:
        for data in ports.chunks(source, live=False):
            spool.write(filter_.feed(data))
            step(len(data))
        spool.write(filter_.finish())
        if verifier and not verifier.passed:
            raise GcompError(
                f"verification failed: {verifier.report()}",
                "nothing was written; this is an error of gcomp: please report the program",
            )
        if options.dry_run:
            print(summary(filter_))
        elif options.in_place:
            kept = ports.replace_file(Path(options.file), spool, backup=True)
            if not options.quiet:
                print(f"gcomp: the nominal program is kept as {kept}", file=sys.stderr)
        elif options.output and options.output != "-":
            ports.replace_file(Path(options.output), spool, backup=False)
        else:
            ports.copy_out(spool, ports.write_standard)


def summary(filter_: Filter) -> str:
    """What was done, in one line."""
    s = filter_.summary
    if filter_.machine.is_zero:
        return f"{s.lines} lines, {s.motions} motions; the map of {filter_.machine.name} is zero: nothing to change"
    return f"{s.changed} of {s.motions} motions changed, {s.added} blocks added, largest correction {s.largest * 1000:.1f} um, tolerance {filter_.compensator.tolerance * 1000:g} um"


def _say(notices: list[Notice]) -> None:
    for notice in notices:
        where = f" (first in line {notice.line})" if notice.line else ""
        print(f"gcomp: notice: {notice.message}{where}", file=sys.stderr)


@contextlib.contextmanager
def _progress(size: int, options: argparse.Namespace):
    """A callable that takes bytes done: LinuxCNC's lines, a bar on a terminal when it takes long, or nothing."""
    if options.filter_progress:
        done = [0, -1]

        def tell(n: int) -> None:
            done[0] += n
            percent = min(99, done[0] * 100 // size) if size else 0
            if percent != done[1]:
                done[1] = percent
                print(f"FILTER_PROGRESS={percent}", file=sys.stderr, flush=True)

        yield tell
        print("FILTER_PROGRESS=100", file=sys.stderr, flush=True)
        return
    if options.quiet or not sys.stderr.isatty():
        yield lambda n: None
        return
    begun = time.monotonic()
    bar = None
    seen = 0

    def step(n: int) -> None:
        nonlocal bar, seen
        seen += n
        if bar is None and time.monotonic() - begun > 1.0:
            from rich.console import Console
            from rich.progress import Progress

            bar = Progress(console=Console(stderr=True), transient=True)
            bar.start()
            bar.add_task("correcting", total=size or None)
        if bar is not None:
            bar.update(bar.task_ids[0], completed=seen)

    try:
        yield step
    finally:
        if bar is not None:
            bar.stop()
