"""Work that ends its own process, as running out of memory does; found by the workers under this
name."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from postproc.batch import work as true


def dies_once(job, options):
    """Kill the process that comes to program 3 first; do the work else."""
    mark = Path(job.output).parent.parent / f"died-{Path(job.program).stem}"
    if job.program.endswith("p03.nc") and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return true.work(job, options)


def dies_always(job, options):
    """Program 3 ends every process that takes it."""
    if job.program.endswith("p03.nc"):
        os.kill(os.getpid(), signal.SIGKILL)
    return true.work(job, options)
