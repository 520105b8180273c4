"""`gcomp diagnose` says where recordings and the machine's model differ, what physics was left out,
and how the fit improves."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postproc import intake, ports, standing
from postproc.commands import as_json, option_text, reading
from postproc.errors import UsageError

if TYPE_CHECKING:
    from postproc.diagnose.answer import Diagnosis
    from postproc.recordings import Recording, Source

HELP = "say what physics the machine's model leaves out, from recordings"
EXAMPLE = "gcomp diagnose r1.csv r2.csv --machine studer-s36 --json answer.json"


OPTIONS = """
recordings+ REC  recordings of one experiment (gcomp recordings --list: formats)
--machine NAME  the machine whose model is to be judged
--json FILE  all of it as JSON (gcomp-diagnosis/1); - for standard output
--residuals FILE  every reading before and after, as CSV
--write-machine FOLDER  a copy of the machine with the accepted effects
--report FILE  the answer as a page with figures, HTML
--holdout run=N  the run that takes no part (default: the middle one of three or more)
--accept EFFECT:AXIS ...  write this effect although another name explains the readings as well
    (with --write-machine)
--compensated  recorded with a corrected program, readings against its nominal targets: what is
    left is looked at (a head that says compensated = true does without)
--force  write over what is there; an old machine folder stays as .bak
--quiet  no progress on standard error
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, holdout="")


def run(options: argparse.Namespace) -> int:
    from postproc import recordings as formats
    from postproc.diagnose import report
    from postproc.diagnose.analysis import Options, diagnose
    from postproc.simulate.program import without_errors

    options.temperature = {}
    machine = reading.machine_of(options)
    if options.write_machine:
        standing.kept(options.write_machine, options.force)
    sources = [_source(path) for path in options.recordings]
    digests = {source.name: source.sha256 for source in sources}
    lenient = formats.ReadingOptions(strict=False)
    progress = _Progress(options.quiet)
    read = []
    try:
        while sources:  # none is kept: beside the rows of a long one its text is a lot
            progress(f"reading {sources[0].name}")
            read.append(formats.read(sources.pop(0), options=lenient))
        left = corrected(read, options.compensated)
        found = diagnose(
            read,
            without_errors(machine) if left else machine,
            Options(held_out=options.holdout, progress=progress),
        )
    finally:
        progress("")  # a refusal has its line to itself
    answer = report.of_files(found, digests)
    _write_files(options, found, progress)
    if options.json:
        as_json.put(options.json, answer)
    else:
        print(report.as_text(found, options.write_machine or ""))
    if left and not options.quiet:
        print(
            "gcomp: notice: measured after compensation, against nominal targets: judged beside a"
            f" machine without errors, so what is found is what the map of {machine.name} left"
            " (gcomp accept compares with the measurement before)",
            file=sys.stderr,
        )
    return 0


def _source(path: str) -> Source:
    from postproc.recordings import Source

    file = Path(path)
    if file.is_dir():
        raise UsageError(f"{path} is a folder", f"name the recordings in it: {path}/*.csv")
    if not file.exists():
        raise UsageError(f"there is no recording {path}")
    return Source(path, ports.read_whole(file, intake.RECORDING))


def _write_files(options: argparse.Namespace, found: Diagnosis, progress: _Progress) -> None:
    """Residuals, machine and page, where they are asked for."""
    from postproc.diagnose import report

    if options.residuals:
        _write(options.residuals, "\n".join(report.residual_rows(found)) + "\n")
    if options.write_machine:
        _write_machine(options, found)
    if options.report:
        from postproc.pages import diagnosis

        progress("drawing")
        page = diagnosis.page(found, options.write_machine or "", tuple(options.accept))
        ports.write_whole(options.report, page.html().encode("utf-8"))
        progress("")


def _write_machine(options: argparse.Namespace, found: Diagnosis) -> None:
    """A copy of the machine with the effects that were found, and what is left of them unknown."""
    from postproc.diagnose import machine_effects, report
    from postproc.machine import places

    target, accepted = Path(options.write_machine), tuple(options.accept)
    ports.copy_folder(
        places.folder_of(options.machine),
        target,
        options.force,
        machine_effects.effects_toml(found, target.name, accepted),
    )
    if not options.quiet:
        for text in machine_effects.not_told_apart(found, accepted):
            print(f"gcomp: {text}", file=sys.stderr)
    if found.unknown:
        _write(str(target / f"{report.map_name(found)}.csv"), report.unknown_csv(found))


def corrected(read: list[Recording], said: bool) -> bool:
    """Whether the readings hold what a correction has left, so that no map is in them. Raises
    UsageError where some do."""
    left = [
        said or (r.head.get("compensated") is True and r.head.get("against") != "commanded")
        for r in read
    ]
    if any(left) and not all(left):
        raise UsageError(
            f"{read[left.index(True)].file} was measured after compensation,"
            f" {read[left.index(False)].file} was not, or against what the corrected program"
            " commands",
            "diagnose each state by itself; gcomp accept compares both",
        )
    return all(left)


def _write(path: str, text: str) -> None:
    """A whole file or none."""
    ports.write_whole(path, text.encode())


class _Progress:
    """Says on standard error what is being done, where a person looks on."""

    def __init__(self, quiet: bool):
        self.live = not quiet and sys.stderr is not None and sys.stderr.isatty()

    def __call__(self, word: Any) -> None:
        if self.live:
            print(f"\r\x1b[K{word}", end="", file=sys.stderr, flush=True)
