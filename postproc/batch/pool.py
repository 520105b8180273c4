"""Who does the jobs: processes of this computer, or a Dask cluster. Either may lose a worker at any
moment.

Jobs are handed out a few at a time, so that what waits can be taken back, and results come as they
are ready. Where a worker is killed, the jobs that were handed out are done again, each in a process
of its own; one that ends these too, as often as `--retries` says, is given up and told as failed.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import signal
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from postproc.batch.jobs import Job
from postproc.batch.work import FAILED, work
from postproc.errors import UsageError

PR_SET_PDEATHSIG = 1  # <sys/prctl.h>
ANSWERS = 10  # s, in which a scheduler has to
AHEAD = 3  # jobs that wait at each worker
Told = tuple[Job, dict[str, Any]]


def alone(jobs: Iterable[Job], options: argparse.Namespace) -> Iterator[Told]:
    """One after the other, in this process."""
    for job in jobs:
        yield job, work(job, options)


def local(
    jobs: Iterable[Job], options: argparse.Namespace, workers: int, retries: int
) -> Iterator[Told]:
    """So many processes of this computer."""
    importlib.import_module("postproc.api.programs")  # once, before processes are forked
    waiting = iter(jobs)
    pool = _pool(workers)
    at_work: dict[Future, Job] = {}
    try:
        while True:
            suspects = _hand_out(pool, waiting, at_work, options, workers * AHEAD)
            if not at_work and not suspects:
                break
            finished = wait(at_work, return_when=FIRST_COMPLETED)[0] if at_work else set()
            for future in finished:
                job = at_work.pop(future)
                try:
                    yield job, future.result()
                except BrokenProcessPool:
                    suspects.append(job)
            if suspects:  # a worker has ended: any job that was handed out may have done it
                # The pool can not say which job ended its process: every one at work is looked at
                # alone.
                suspects += at_work.values()
                at_work.clear()
                pool.shutdown(wait=False, cancel_futures=True)
                pool = _pool(workers)
                yield from _one_by_one(suspects, options, retries)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _hand_out(
    pool: ProcessPoolExecutor,
    waiting: Iterator[Job],
    at_work: dict[Future, Job],
    options: argparse.Namespace,
    most: int,
) -> list[Job]:
    """Give out jobs until so many are at work; returns the one that could not be, since a worker
    has ended meanwhile."""
    while len(at_work) < most:
        job = next(waiting, None)
        if job is None:
            break
        try:
            at_work[pool.submit(work, job, options)] = job
        except BrokenProcessPool:
            return [job]
    return []


def _one_by_one(jobs: Iterable[Job], options: argparse.Namespace, retries: int) -> Iterator[Told]:
    """Jobs of which one may end its process: each alone, so that no other is held for it."""
    for job in jobs:
        most = max(1, retries)  # beside the time when it may have been another's fault
        for attempt in range(1, most + 1):
            with _pool(1) as pool:
                try:
                    yield job, pool.submit(work, job, options).result()
                    break
                except BrokenProcessPool:
                    if attempt == most:
                        yield job, _given_up(job, attempt + 1)


def _given_up(job: Job, attempts: int) -> dict[str, Any]:
    message = (
        f"{job.program}: the process that corrected it ended {attempts} times (out of memory, or"
        " killed)"
    )
    return {**job.named, "status": FAILED, "message": message, "text": message, "seconds": 0.0}


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, initializer=_quiet)


def _quiet() -> None:
    """A worker is ended by the process that began it: Ctrl-C and TERM reach that one. It does not
    outlive it (Linux)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with contextlib.suppress(OSError, AttributeError, ImportError):
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def cluster(
    jobs: Iterable[Job], options: argparse.Namespace, address: str, retries: int
) -> Iterator[Told]:
    """The workers of a Dask scheduler; they must see the same files and have the same gcomp."""
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError:
        raise UsageError(
            "--scheduler needs Dask, which is not installed here", "pip install 'gcomp[cluster]'"
        ) from None
    try:
        client = Client(address, timeout=ANSWERS)
    except (OSError, ValueError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {address}: {str(error) or type(error).__name__}"
        ) from None
    with client:
        waiting = iter(jobs)
        at_work: dict[Any, Job] = {}
        ready = as_completed()

        def hand_out() -> None:
            room = max(1, sum(client.nthreads().values())) * AHEAD
            while len(at_work) < room and (job := next(waiting, None)) is not None:
                future = client.submit(work, job, options, pure=False, retries=retries)
                at_work[future.key] = job
                ready.add(future)

        hand_out()
        for future in ready:
            job = at_work.pop(future.key)
            try:
                yield job, future.result()
            except KilledWorker:
                yield job, _given_up(job, retries + 1)
            future.release()
            hand_out()
