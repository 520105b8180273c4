"""A controller that runs programs from files: the corrected program as a file that both can see."""

from __future__ import annotations

import argparse
import ipaddress
import os
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from postproc.commands.stream.job import Job, is_file
from postproc.commands.stream.legs import lines
from postproc.errors import UsageError

SUFFIX = ".handed.ngc"


def wanted(protocol: Any) -> bool:
    """Whether this controller takes its program as a file."""
    return bool(getattr(protocol, "handed", False))


def near(url: str) -> bool:
    """Whether the port leads to this computer."""
    host = urlsplit(url).hostname or ""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def place(options: argparse.Namespace) -> Path:
    """Where the file goes. Raises UsageError where the controller could not see it."""
    if options.hand_over:
        return Path(options.hand_over)
    if not near(options.port):
        raise UsageError(
            "LinuxCNC opens the corrected program by itself, and runs on another computer",
            "--hand-over FILE, by a path under which both see it (a shared folder)",
        )
    name = Path(options.file).name if is_file(options.file) else "stream"
    return Path(os.path.abspath(name + SUFFIX))


def write(options: argparse.Namespace, job: Job, protocol: Any) -> None:
    """Write it, whole, before the controller hears of it."""
    where = place(options)
    part = where.with_name(where.name + ".part")
    try:
        with open(part, "wb") as file:
            file.writelines(protocol.file_of(line.text for batch in lines(job) for line in batch))
        # LinuxCNC must never see half a program under that name
        os.replace(part, where)
    except OSError as error:
        what = f"{where} can not be written: {error.strerror}"
        raise UsageError(what, "--hand-over FILE") from None
    finally:
        part.unlink(missing_ok=True)  # of a program that was refused half way
    protocol.hand_over(str(where))
