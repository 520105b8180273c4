"""A command as a watched process of its own: its CPU time, wall time and peak memory."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
TIME_LIMIT = 900.0  # s, for one process


class Absent(Exception):
    """A tool that can not be run here, and why."""


@dataclass
class Usage:
    """What one command used: of several runs the least CPU and wall time and the highest peak."""

    cpu_s: float
    wall_s: float
    peak_mb: float

    def best(self, other: Usage | None) -> Usage:
        if other is None:
            return self
        cpu, wall = min(self.cpu_s, other.cpu_s), min(self.wall_s, other.wall_s)
        return Usage(cpu, wall, max(self.peak_mb, other.peak_mb))


@dataclass
class Command:
    arguments: list[str]
    environment: dict[str, str] = field(default_factory=dict)


@dataclass
class Row:
    """A line of a table. `problem` says why there are no figures."""

    file: str
    tool: str
    lines: int = 0
    usage: Usage | None = None
    problem: str = ""

    @property
    def rate(self) -> float:
        """Lines per CPU second, 0 where there is none."""
        return self.lines / self.usage.cpu_s if self.usage and self.usage.cpu_s else 0.0


def run(command: Command) -> Usage:
    """Run a command through child.py; Absent, with what it complained of last, if it fails."""
    watched = [sys.executable, "-I", "-S", str(HERE / "child.py"), *command.arguments]
    environment = {**os.environ, **command.environment}
    # what is installed has its bytecode
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    process = subprocess.Popen(
        watched,
        env=environment,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        output, complaint = process.communicate(timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise Absent(f"stopped after {TIME_LIMIT:g} s") from None
    # indented: details
    said = [line for line in complaint.splitlines() if line and not line[0].isspace()]
    last = said[-1].strip() if said else "no message"
    if process.returncode:
        raise Absent(last)
    status, cpu, wall, peak = output.split()
    if status != "0":
        raise Absent(f"exit status {status}: {last}")
    return Usage(float(cpu), float(wall), float(peak))


def measure(rows: list[Row], commands: dict[str, Command], repeat: int) -> None:
    """Fill in the rows, a round of all tools at a time, so that a slow minute of the computer meets
    them all."""
    for _ in range(repeat):
        for row in rows:
            if row.problem or row.tool not in commands:
                continue
            try:
                row.usage = run(commands[row.tool]).best(row.usage)
            except Absent as absent:
                row.usage, row.problem = None, str(absent)
