"""The main job: a program in, the corrected program out."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

# Before all that asks for it: deep in a chain of imports it takes 3 ms more.
import numpy  # noqa: F401

from postproc import intake, marks, ports, standing
from postproc.commands import attempts, option_text, reading, reading_options
from postproc.errors import GcompError, Notice, UsageError
from postproc.machine import lacks

if TYPE_CHECKING:
    from postproc.filter import Filter

HELP = "correct a program for a machine (the default: gcomp --machine NAME FILE)"
EXAMPLE = "cat job.nc | gcomp --machine studer-s36 > job_comp.nc"


OPTIONS = """
file? FILE  the program; standard input if missing
[where it goes]
-o, --output FILE  write here instead of to standard output; in one step, when all is accepted
--in-place  correct FILE itself; its old content stays beside it as FILE.bak
--force  write over a file that gcomp did not make, FILE itself too
--unbuffered  pass block by block, for live pipes; a refusal then comes after what is already out
--dry-run  write no program: say what would change
[what it says]
--verify  replay the output on the machine's model and report the largest deviation left; refuse
    the output if that is more than the tolerance and what turning slides and rounding add
--json FILE  what was done as JSON (gcomp-program/1); - for standard output, with -o
--report FILE.html  a page: the path, its deviation before and after, where and in which lines
    (verifies too)
--quiet  no notices, no summary
--filter-progress  print FILTER_PROGRESS=nn on standard error, as LinuxCNC's filters do
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    reading_options.arguments(parser)
    option_text.add(parser, OPTIONS)


def run(options: argparse.Namespace) -> int:
    _one_place_each(options)
    _spares(options)
    asked = options.verify
    options.verify = asked or bool(options.report)
    machine = reading.machine_of(options)
    with ports.opened(options.file) as (source, name, size):
        if options.unbuffered:
            done = attempts.Attempt.fresh(options, machine, name)
            _live(done.filter, source)
        else:
            kept = ports.Kept(source, intake.PROGRAM)
            with progress(size, options) as step:
                done = attempts.Tries(options, machine, kept, name, ports.head(source), step).best()
            _put(done, options)
    if options.report:
        ports.write_whole(options.report, done.page().html().encode("utf-8"))
    if asked:
        _say_verified(done, options)
    if left := reading.left_by_only(options):
        print(f"gcomp: {left}", file=sys.stderr)
    if options.json:
        _put_json(done, options.json)
    if done.why:
        print(f"gcomp: {done.why}", file=sys.stderr)
    warn_of_nothing(done.filter, name)
    if not options.quiet:
        _say(done.filter.notices)
        if not options.dry_run:
            print(f"gcomp: {done.summary}", file=sys.stderr)
    return 0


def _say_verified(done: attempts.Attempt, options: argparse.Namespace) -> None:
    if done.verifier:
        part = f" for {', '.join(options.only)} alone" if options.only else ""
        print(f"gcomp: verified{part}: {done.verifier.report()}", file=sys.stderr)
        if lacking := lacks.sentence(done.verifier.settings.machine):
            print(f"gcomp: {lacking}", file=sys.stderr)


def _spares(options: argparse.Namespace) -> None:
    """Raises UsageError where the output would be written over what gcomp did not make."""
    if not options.output or options.force:
        return
    if options.file and standing.same(options.output, options.file):
        raise UsageError(
            f"{options.output} is the program itself, and would be lost",
            "--in-place corrects it and keeps it as FILE.bak; -o another name; --force",
        )
    # a program in which nothing was to be changed holds no mark
    if not options.file or not standing.copy(options.output, options.file):
        standing.result(options.output, marks.PROGRAM, "another name, or --force to write over it")


def _one_place_each(options: argparse.Namespace) -> None:
    """Raises UsageError where the corrected program has no place, or goes to one with what is told
    of it."""
    if options.in_place and (options.output or options.file in (None, "-")):
        raise UsageError("--in-place corrects FILE itself: it needs a FILE and no --output")
    if options.output == "":
        raise UsageError("--output names no file", "-o FILE, or leave it out for standard output")
    elsewhere = [options.in_place, options.dry_run]
    if options.unbuffered:
        _as_it_goes(options)
    if options.json == "-" and not any([options.output not in (None, "-"), *elsewhere]):
        raise UsageError(
            "the program and --json - are both for standard output", "-o FILE for the program"
        )


def _as_it_goes(options: argparse.Namespace) -> None:
    """Raises UsageError for what does not go with --unbuffered."""
    if any([options.output, options.expand, options.in_place, options.dry_run]):
        raise UsageError(
            "--unbuffered writes to standard output as it goes: not with --output, --in-place,"
            " --dry-run or --expand"
        )
    for value, what in ((options.json, "--json is known"), (options.report, "--report is drawn")):
        if value:
            raise UsageError(
                f"{what} at the end of a program, and --unbuffered has none", "without --unbuffered"
            )


def _live(filter_: Filter, source) -> None:
    """Block by block; on a fault what came before it is out already."""
    try:
        for data in ports.chunks(source, live=True):
            ports.write_standard(filter_.feed(data))
        ports.write_standard(filter_.finish())
    except GcompError as error:
        # of the batch that failed, what came before the faulty block
        ports.write_standard(getattr(error, "delivered", b""))
        raise


def _put(done: attempts.Attempt, options: argparse.Namespace) -> None:
    """Everything is accepted: write it."""
    with contextlib.closing(done.spool) as spool:
        if options.dry_run:
            print(done.summary)
        elif options.in_place:
            kept = ports.replace_file(Path(options.file), spool, backup=True)
            if not options.quiet:
                print(f"gcomp: the nominal program is kept as {kept}", file=sys.stderr)
        elif options.output and options.output != "-":
            ports.replace_file(Path(options.output), spool, backup=False)
        else:
            ports.copy_out(spool, ports.write_standard)


def _put_json(done: attempts.Attempt, name: str) -> None:
    from postproc.commands import as_json, outcome

    as_json.put(name, outcome.of(done, b"").as_dict())


def warn_of_nothing(filter_: Filter, name: str) -> None:
    """Said even with --quiet: a pipe whose begin has failed brings nothing."""
    if filter_.summary.motions:
        return
    what = "no axis moves in it: nothing to correct" if filter_.summary.lines else "it is empty"
    print(f"gcomp: warning: {name}: {what}", file=sys.stderr)


def _say(notices: list[Notice]) -> None:
    for notice in notices:
        where = f" (first in line {notice.line})" if notice.line else ""
        print(f"gcomp: notice: {notice.message}{where}", file=sys.stderr)


@contextlib.contextmanager
def progress(size: int, options: argparse.Namespace):
    """A callable that takes bytes done: LinuxCNC's lines, a bar on a terminal when it takes long,
    or nothing."""
    if options.filter_progress:
        done = [0, -1]

        def tell(n: int) -> None:
            done[0] += n
            # 100 is said when all has been written, not when all has been read
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
    started = time.monotonic()
    bar = None
    seen = 0

    def step(n: int) -> None:
        nonlocal bar, seen
        seen += n
        if bar is None and time.monotonic() - started > 1.0:
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
