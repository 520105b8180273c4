"""Which programs, for which machines, and where each result goes."""

from __future__ import annotations

import argparse
import fnmatch
import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from postproc import __version__, intake, ports
from postproc.commands.expansion import ENDINGS
from postproc.errors import UsageError
from postproc.machine import places

# What programs in a folder are called, beside the names that --expand knows.
KNOWN = {f"*{ending.lower()}" for ending in ENDINGS if ending.lower() not in ("", ".txt")}
PATTERNS = (*sorted(KNOWN), "*.gcode", "*.gco", "*.g", "*.iso", "*.eia", "*.pim")
OWN = (
    "output", "jobs", "scheduler", "retries", "programs", "pattern", "force", "json", "quiet",
    "machine", "file",
)  # fmt: skip


@dataclass(frozen=True)
class Job:
    """A program for a machine. machine: its name or path, as it was given; output: where the
    corrected program goes."""

    program: str
    machine: str
    output: str
    number: int = 0

    @property
    def named(self) -> dict[str, str]:
        """What a result says first."""
        return {"program": self.program, "machine": self.machine, "output": self.output}


def jobs(
    programs: Sequence[str], machines: Sequence[str], folder: Path, patterns: Sequence[str]
) -> list[Job]:
    """All that is to be done, in order. Raises UsageError where nothing is found, or two results
    would be one file."""
    found = [
        (source, relative)
        for name in programs
        for source, relative in _programs(Path(name), folder, patterns)
    ]
    if not found:
        raise UsageError(
            f"there is no program in {', '.join(programs)}",
            f"--pattern '*.nc'; looked for {' '.join(patterns)}",
        )
    result: list[Job] = []
    taken: dict[Path, str] = {}
    for machine in machines:
        #     -o out, one machine      out/part.nc          out/sub/part.nc
        #     -o out, machines a, b    out/a/part.nc        out/b/part.nc
        root = folder / places.folder_of(machine).resolve().name if len(machines) > 1 else folder
        for source, relative in found:
            output = root / relative
            if output in taken:
                raise UsageError(
                    f"{source} and {taken[output]} would both be written to {output}",
                    "run them with two folders -o",
                )
            if output.resolve() == source.resolve():
                raise UsageError(f"{output} is the program itself", "-o names another folder")
            taken[output] = str(source)
            result.append(Job(str(source), machine, str(output), len(result)))
    return result


def _programs(path: Path, output: Path, patterns: Sequence[str]) -> Iterator[tuple[Path, Path]]:
    """A file, or the programs in a folder and those below it, each with its name below the folder
    of results."""
    if path.is_file():
        yield path, Path(path.name)
        return
    if not path.is_dir():
        raise UsageError(f"there is no program {path}")
    inside = output.resolve()
    if inside == path.resolve():
        raise UsageError(
            f"the results would be written among the programs in {path}", "-o names another folder"
        )
    for file in sorted(path.rglob("*")):
        if not file.is_file() or file.name.startswith(".") or inside in file.resolve().parents:
            continue  # a link to itself is no file
        if any(fnmatch.fnmatch(file.name.lower(), pattern.lower()) for pattern in patterns):
            yield file, file.relative_to(path)


def key_of(job: Job, options: argparse.Namespace) -> str:
    """What the result depends on: program, machine's folder, offsets, options, version. The same
    key: the same bytes."""
    # The version, for other code may give other bytes; the machine's files and not its name, for a
    # map that was measured anew has the same name.
    sha = hashlib.sha256(f"{__version__} {_folder(job.machine)} {_settings(options)}".encode())
    sha.update(ports.read_whole(Path(job.program), intake.PROGRAM))
    return sha.hexdigest()


def repeats(options: argparse.Namespace) -> bool:
    """Whether a key says all: subprograms in other files have a part in what --expand and --library
    write, and in no key."""
    return bool(options.expand or options.library)


def _settings(options: argparse.Namespace) -> str:
    # what does not change a byte of the result stays out (OWN): another -j does nothing again
    own = {k: v for k, v in sorted(vars(options).items()) if k not in OWN and not callable(v)}
    own["offsets"] = [_digest(name) for name in options.offsets]
    own["temperatures"] = options.temperatures and _digest(options.temperatures)
    return json.dumps(own, sort_keys=True, default=str)


@cache
def _folder(machine: str) -> str:
    """All files of a machine's folder as one digest."""
    files = sorted(p for p in places.folder_of(machine).rglob("*") if p.is_file())
    return hashlib.sha256(
        "".join(f"{p.name} {_digest(str(p))}" for p in files).encode()
    ).hexdigest()


@cache
def _digest(name: str) -> str:
    return hashlib.sha256(ports.read_whole(Path(name), intake.PROGRAM)).hexdigest()
