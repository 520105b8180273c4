"""What is kept of a job: the recording of the reported positions, and the journal."""

from __future__ import annotations

import argparse

from postproc.commands.stream import job as jobs
from postproc.commands.stream.journal_file import JournalFile
from postproc.commands.stream.outlets import Outlet
from postproc.errors import UsageError
from postproc.streaming import journal as journals
from postproc.streaming.trace import Trace


def recording(
    options: argparse.Namespace,
    machine,
    job: jobs.Job,
    order: tuple[int, ...],
    reported: int,
    stack,
):
    """The trace and where it is written; None twice where none is asked for."""
    if not options.record:
        return None, None
    name = job.protocol.controller.name
    if any(i >= reported for i in order):
        raise UsageError(
            f"{name} does not report all axes of {machine.name}: there is nothing to record"
        )
    start = tuple(job.live.place.get(x, float("nan")) for x in machine.letters)
    trace = Trace(machine.name, machine.letters, name, start)
    file = stack.enter_context(open(options.record, "w", encoding="utf-8"))  # noqa: SIM115
    file.write(trace.head())
    record = Outlet(file)
    stack.callback(record.close)
    return trace, record


def journal_of(options: argparse.Namespace, machine, job: jobs.Job, holds: int):
    """The journal, begun; None where none is kept."""
    place = jobs.journal_path(options)
    if place is None or options.check:
        return None
    sha = job.copy.digest if job.copy else ""
    place_now = [job.live.place.get(x) for x in machine.letters]
    head = journals.head(
        job.name, sha, machine.name, machine.digest, holds, job.begin, options.expand,
        jobs.zero_done(options), job.live.work, place_now,
    )  # fmt: skip
    return JournalFile(place, head)
