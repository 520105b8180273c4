"""`gcomp show PROGRAM --machine M`: the program's path and what is off on it, as a page in the
browser."""

from __future__ import annotations

import argparse
import sys
import tempfile
import webbrowser
from pathlib import Path

from postproc import intake, marks, ports, standing
from postproc.commands import attempts, compensate, option_text, reading, reading_options

HELP = "show a program's path and its deviation before and after correction, in the browser"
EXAMPLE = "gcomp show part.nc --machine studer-s36"


OPTIONS = """
-o, --output FILE.html  write the page there, and open nothing
--quiet  do not say where the page is
file? FILE  the program; standard input if missing
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    reading_options.arguments(parser)
    option_text.add(parser, OPTIONS)


def run(options: argparse.Namespace) -> int:
    options.verify, options.in_place, options.unbuffered, options.filter_progress = (
        True, False, False, False,
    )  # fmt: skip
    options.report = options.output or "browser"
    if options.output:
        standing.result(options.output, marks.PAGE, "another name")
    machine = reading.machine_of(options)
    with (
        ports.opened(options.file) as (source, name, size),
        compensate.progress(size, options) as step,
    ):
        done = attempts.Tries(
            options, machine, ports.Kept(source, intake.PROGRAM), name, ports.head(source), step
        ).best()
    done.spool.close()
    compensate.warn_of_nothing(done.filter, name)
    page = done.page()
    path = Path(options.output) if options.output else _place(name)
    ports.write_whole(path, page.html().encode("utf-8"))
    opened = not options.output and webbrowser.open(path.resolve().as_uri())
    if not options.quiet:
        print(f"gcomp: {'opened' if opened else 'written'}: {path}", file=sys.stderr)
    return 0


def _place(name: str) -> Path:
    """A file that stays, for the browser reads it when gcomp has ended."""
    stem = (
        "".join(c if c.isalnum() or c in "-_" else "-" for c in Path(name).name).strip("-")
        or "program"
    )
    return Path(tempfile.mkdtemp(prefix="gcomp-")) / f"{stem}.html"
