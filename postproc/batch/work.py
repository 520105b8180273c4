"""One job, done in whatever process: a program read, corrected, written, and what came of it as
plain data."""

from __future__ import annotations

import argparse
import copy
import hashlib
import os
import time
from functools import lru_cache
from pathlib import Path
from typing import Any

from postproc import ports
from postproc.batch.jobs import Job
from postproc.errors import GcompError

DONE, REFUSED, FAILED = "done", "refused", "failed"


def work(job: Job, options: argparse.Namespace) -> dict[str, Any]:
    """Correct a program and write it whole, or not at all. Never raises for what a program or a
    file is: that is told."""
    started = time.monotonic()
    result: dict[str, Any] = {**job.named, "pid": os.getpid()}
    try:
        result |= _corrected(job, options)
    except GcompError as error:
        place = error.place
        result |= {
            "status": REFUSED, "message": error.message, "advice": error.advice,
            "line": place.line if place else None, "text": str(error),
        }  # fmt: skip
    except (OSError, MemoryError) as error:
        what = (
            f"{getattr(error, 'filename', '') or job.program}:"
            f" {getattr(error, 'strerror', '') or 'out of memory'}"
        )
        result |= {"status": FAILED, "message": what, "text": what}
    result["seconds"] = round(time.monotonic() - started, 3)
    return result


def _corrected(job: Job, options: argparse.Namespace) -> dict[str, Any]:
    from postproc.api import programs
    from postproc.commands import outcome

    own = copy.copy(options)
    own.file, own.machine = job.program, job.machine
    # of a copy: all jobs of a process share the options
    own.in_place = own.unbuffered = own.filter_progress = False
    own.verify = bool(options.verify or options.report)
    done = programs.attempt(
        Path(job.program),
        _machine(job.machine, tuple(sorted(options.temperature.items())), options.only),
        own,
    )
    with done.spool as spool:
        spool.seek(0)
        sha, data = hashlib.sha256(), b""
        while data := spool.read(ports.CHUNK):
            sha.update(data)
        target = Path(job.output)
        target.parent.mkdir(parents=True, exist_ok=True)
        # The digest is of what was written, so that a ledger tells a result from what a person made
        # of it.
        ports.replace_file(target, spool, backup=False)
    if options.report:
        ports.write_whole(
            target.with_name(target.name + ".html"), done.page().html().encode("utf-8")
        )
    return {"status": DONE, "sha256": sha.hexdigest(), "result": outcome.of(done, b"").as_dict()}


@lru_cache(maxsize=64)
def _machine(name: str, temperatures: tuple[tuple[str, float], ...], only: tuple[str, ...]):
    """A machine is read once in each process."""
    from postproc.api.machines import load_machine

    return load_machine(name, dict(temperatures), only)
