"""Where a process begins and ends: the console script `gcomp`, and `python -m postproc`."""

from __future__ import annotations

import gc
import os
import sys


def begin() -> int:
    """Run gcomp; the exit status of `cli.main`."""
    gc.disable()  # nothing of what loads is garbage; cli turns it on when the command is loaded
    from postproc import cli

    return cli.main()


def program() -> None:
    """Run gcomp as the console script, and end the process with its exit status.

    At once, where no threads were at work: both streams are written and all files are closed, and
    taking 300 modules apart takes a thirtieth of the time of a short program. Whoever measures or
    traces the interpreter to its end runs `python -m postproc`.
    """
    status = begin()
    if "threading" not in sys.modules:
        os._exit(status)
    sys.exit(status)
