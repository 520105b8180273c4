"""`gcomp batch PROGRAM... --machine M -o DIR`: many programs, in many processes; one that can not
be corrected stops no other."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from postproc import colour, ports
from postproc.commands import as_json, option_text, reading, reading_options
from postproc.errors import UsageError

HELP = "correct many programs or whole folders, in several processes or on a Dask cluster"
EXAMPLE = "gcomp batch jobs/ --machine studer-s36 -o corrected/ -j 4"
FORMAT = "gcomp-batch/1"
TABLE = "gcomp-batch.csv"
SHOWN = 40  # rows: of more, those that went wrong are printed, and all stand in the table
COLUMNS = (
    "program", "machine", "status", "changed", "added", "correction_um", "before_um", "after_um",
    "seconds", "message",
)  # fmt: skip


OPTIONS = f"""
programs+ PROGRAM  programs, or folders of them
-o, --output DIR  the folder of results; with several machines one folder for each in it
-j, --jobs N  processes (default: one for each core)
--scheduler ADDRESS  a Dask scheduler, like tcp://host:8786, in place of processes here; its
    workers must see the same files
--retries N  how often a program is tried again whose process was killed (2)
--pattern GLOB ...  which files of folders are programs: '*.nc' (default: the usual endings)
--force  do again what is done, and write over files that gcomp batch did not write
--verify  replay each result on its machine's model; the table has the deviations
--report  a page beside each result (verifies too)
--json FILE  all of it as JSON ({FORMAT}); - for standard output
--quiet  no progress, no table; refusals are still told
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(
        parser, OPTIONS, output={"required": True}, jobs=(_count, os.cpu_count() or 1),
        retries=(int, 2),
    )  # fmt: skip
    reading_options.arguments(parser, several=True)


def run(options: argparse.Namespace) -> int:
    from postproc.batch.jobs import PATTERNS, jobs
    from postproc.batch.ledger import Ledger

    if not options.machine:
        reading.machine_of(options)  # refuses with the machines that there are
    for name in dict.fromkeys(options.machine):
        reading.machine_of(
            argparse.Namespace(machine=name, temperature=options.temperature, only=options.only)
        )
    folder = Path(options.output)
    todo = jobs(
        options.programs, list(dict.fromkeys(options.machine)), folder, options.pattern or PATTERNS
    )
    results: list[dict[str, Any]] = []
    with contextlib.closing(Ledger(folder)) as ledger, _progress(len(todo), options) as step:
        try:
            for one in _results(todo, options, ledger):
                results.append(one)
                step(one)
                if one.get("result", {}).get("motions") == 0 and not one.get("before"):
                    print(f"gcomp: warning: {one['program']}: no axis moves in it", file=sys.stderr)
        finally:
            results.sort(key=lambda one: one["number"])
            _table(folder / TABLE, results)
    return _report(results, folder, options)


def _results(todo: list, options: argparse.Namespace, ledger) -> Iterator[dict[str, Any]]:
    """What comes of every job: of those that are done already what was told then."""
    from postproc.batch import pool
    from postproc.batch.jobs import key_of, repeats

    keys: dict[int, str] = {}
    standing: list[dict[str, Any]] = []
    repeat = options.force or repeats(options)

    def open_jobs() -> Iterator:
        for job in todo:
            try:
                key = keys[job.number] = key_of(job, options)
            except UsageError as error:
                standing.append(_refused(job, str(error)))
                continue
            known = None if repeat else ledger.done(job.output, key)
            if known:
                # The generator runs inside the pool's loop: what needs no process waits here for
                # its turn.
                standing.append({**known, **job.named, "before": True, "number": job.number})
            elif not options.force and Path(job.output).exists() and not ledger.wrote(job.output):
                standing.append(
                    _refused(
                        job, f"{job.output} exists, and gcomp batch did not write it; --force does"
                    )
                )
            else:
                ledger.begin(job.output)
                yield job

    for job, outcome in _pool(pool, open_jobs(), options):
        yield from _drained(standing)
        own = todo[job.number]  # as it was named here
        outcome |= {**own.named, "number": job.number}
        ledger.write(keys[job.number], {k: v for k, v in outcome.items() if k != "number"})
        yield outcome
    yield from _drained(standing)


def _pool(pool, open_jobs: Iterator, options: argparse.Namespace):
    # what goes to other processes is pickled: nothing that only this one needs
    plain = argparse.Namespace(
        **{k: v for k, v in vars(options).items() if k not in ("programs", "json")}
    )
    if options.scheduler:
        for name in ("library", "offsets"):
            setattr(plain, name, [str(Path(path).resolve()) for path in getattr(plain, name)])
        if plain.temperatures:
            plain.temperatures = str(Path(plain.temperatures).resolve())
        return pool.cluster(map(_absolute, open_jobs), plain, options.scheduler, options.retries)
    if options.jobs == 1:
        return pool.alone(open_jobs, plain)
    return pool.local(open_jobs, plain, options.jobs, options.retries)


def _absolute(job):
    """The same job for a process that was begun in another folder."""
    from dataclasses import replace

    from postproc.machine import places

    machine = str(places.folder_of(job.machine).resolve())
    return replace(
        job,
        program=str(Path(job.program).resolve()),
        output=str(Path(job.output).resolve()),
        machine=machine,
    )


def _refused(job, text: str) -> dict[str, Any]:
    return {
        **job.named, "status": "refused", "message": text, "text": text, "seconds": 0.0,
        "number": job.number,
    }  # fmt: skip


def _drained(results: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    while results:
        yield results.pop(0)


def _count(word: str) -> int:
    if not word.isdigit() or not 1 <= int(word) <= 512:
        raise argparse.ArgumentTypeError(f"{word!r} is not a number of processes like 4")
    return int(word)


# -- what is said ----------------------------------------------------------------------------------


def row(outcome: dict[str, Any]) -> tuple[str, ...]:
    """One job as a row of the table; what is not known is empty."""
    result = outcome.get("result") or {}
    verified = result.get("verified") or {}
    if not verified.get("compared", True):  # a ledger of before has no such key
        verified = {}

    def number(value: float | None, digits: int) -> str:
        return "" if value is None else f"{value:.{digits}f}"

    return (
        outcome["program"], Path(outcome["machine"]).name, outcome["status"],
        str(result.get("changed", "")), str(result.get("added", "")),
        number(result.get("largest_correction_um"), 1), number(verified.get("uncorrected_um"), 2),
        number(verified.get("deviation_um"), 2), number(outcome.get("seconds"), 2),
        outcome.get("message", ""),
    )  # fmt: skip


def _table(path: Path, results: list[dict[str, Any]]) -> None:
    import csv

    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([COLUMNS, *map(row, results)])
    ports.write_whole(path, text.getvalue().encode("utf-8"))


def _report(results: list[dict[str, Any]], folder: Path, options: argparse.Namespace) -> int:
    """The table and the sum; returns the exit status: 0 all done, 2 some refused, 1 some failed for
    another reason."""
    counts = {s: sum(one["status"] == s for one in results) for s in ("done", "refused", "failed")}
    out = as_json.beside(options.json)
    wrong = [one for one in results if one["status"] != "done"]
    rows = _rows(results if len(results) <= SHOWN else wrong)
    if not options.quiet:
        print("\n".join([*rows, ""]), end="", file=out)
    for one in wrong:
        colour.fault(one["text"])
    if not options.quiet:
        print(f"{_sum(results, counts)}; all in {folder / TABLE}", file=out)
    programs = [_public(one) for one in results]
    as_json.put(options.json, {"format": FORMAT, "counts": counts, "programs": programs})
    return _status(counts)


def _status(counts: dict[str, int]) -> int:
    if counts["failed"]:
        return 1
    return 2 if counts["refused"] else 0


def _public(one: dict[str, Any]) -> dict[str, Any]:
    """What is said of a program to other programs."""
    return {k: v for k, v in one.items() if k not in ("number", "text", "pid")}


def _rows(shown: list[dict[str, Any]]) -> list[str]:
    """Jobs as a table with its head, none where there is no job."""
    if not shown:
        return []
    rows = [("", *COLUMNS[1:-1]), *(row(one)[:-1] for one in shown)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            c.ljust(w) if k < 3 else c.rjust(w)
            for k, (c, w) in enumerate(zip(r, widths, strict=True))
        ).rstrip()
        for r in rows
    ]


def _sum(results: list[dict[str, Any]], counts: dict[str, int]) -> str:
    before = sum(bool(one.get("before")) for one in results)
    earlier = f" ({before} of them in an earlier run)" if before else ""
    others = "".join(f", {n} {name}" for name, n in counts.items() if n and name != "done")
    return f"{counts['done']} of {len(results)} corrected{earlier}{others}"


@contextlib.contextmanager
def _progress(count: int, options: argparse.Namespace):
    """A callable that takes what came of a job: a bar with the time left on a terminal, a line for
    each tenth elsewhere."""
    if options.quiet:
        yield lambda outcome: None
        return
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
            TimeElapsedColumn(), TimeRemainingColumn(),
        )  # fmt: skip
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("correcting", total=count)

            def advance(outcome: dict[str, Any]) -> None:
                bar.update(task, advance=1, description=Path(outcome["program"]).name[:30])

            yield advance
        return
    started, done, said = time.monotonic(), 0, 0

    def tell(outcome: dict[str, Any]) -> None:
        nonlocal done, said
        done += 1
        tenth = done * 10 // count
        if tenth > said and count >= 20:
            said = tenth
            left = (time.monotonic() - started) / done * (count - done)
            print(f"gcomp: {done} of {count}, about {left:.0f} s left", file=sys.stderr, flush=True)

    yield tell
