"""gcomp beside the interpreters that others have written: speed, start-up and memory, on the same
files in one run.

    python benchmarks/speed.py [--lines N] [--only a,c] [--repeat 2] [--memory] [--fetch] [--json
    FILE]

Every measurement is a process of its own; what counts is its CPU time (user + system), which moves
by a few per cent between runs where wall time moves by half. Nothing here passes or fails: the
tables are the result.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import asdict
from itertools import islice
from pathlib import Path

from peers import PYPI, TWO_WAY, Bench, fetch, installed
from speed_tables import STARTS, memory_table, speed_table, start_table
from watched import ROOT, Absent, Command, Row, measure

SHORT_PROGRAM = """\
%
G21 G90 G17 G54 G94
S8000 M3 F600
G0 X10 Y10 Z-5
G1 X50 Y10
X50 Y50
X10 Y50 Z-6
X10 Y10
G2 X30 Y30 I20 J0
G3 X50 Y50 I0 J20
G1 X60 Y60 Z-10
G0 Z0
M30
%
"""


def count_lines(path: Path) -> int:
    with path.open("rb") as file:
        return sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 20), b""))


def head(path: Path, lines: int) -> Path:
    """The first lines of a program, in a file of the same stem."""
    short = path.parent / f"head-{lines}" / path.name
    short.parent.mkdir(exist_ok=True)
    with path.open("rb") as source, short.open("wb") as target:
        target.writelines(islice(source, lines))
    return short


def measure_speed(bench: Bench, names: list[str], lines: int, repeat: int) -> list[Row]:
    rows = []
    for name in names:
        program = bench.write(name, lines)
        here, commands = [], {}
        for tool, command in bench.tools.items():
            part = head(program, PYPI[tool]) if tool in PYPI else program
            row = Row(name, tool, count_lines(part))
            here.append(row)
            try:
                commands[tool] = command(part)
            except Absent as absent:
                row.problem = str(absent)
        note(f"file {name}")
        measure(here, commands, repeat)
        rows += here
    return rows


def measure_start(bench: Bench) -> list[Row]:
    program = bench.folder / "short.nc"
    program.write_text(SHORT_PROGRAM, encoding="ascii")
    commands = {
        "python -c pass": Command([sys.executable, "-c", "pass"]),
        'python -c "import numpy"': Command([sys.executable, "-c", "import numpy"]),
    }
    rows = []
    for tool, command in bench.tools.items():
        if tool == TWO_WAY:
            continue
        row = Row("short", tool, SHORT_PROGRAM.count("\n"))
        rows.append(row)
        try:
            commands[tool] = command(program)
        except Absent as absent:
            row.problem = str(absent)
    rows += [Row("", tool) for tool in commands if tool not in bench.tools]
    note("start-up")
    measure(rows, commands, STARTS)
    return rows


def measure_memory(bench: Bench, lines: int) -> list[Row]:
    rows = []
    for times in (1, 5):
        program = bench.write("a", times * lines)
        note(f"memory, {times} x file a")
        for tool, command in bench.tools.items():
            if tool == TWO_WAY or tool in PYPI:
                continue
            row = Row(f"a x {times}", tool, count_lines(program))
            rows.append(row)
            try:
                measure([row], {tool: command(program)}, 1)
            except Absent as absent:
                row.problem = str(absent)
    return rows


def computer() -> dict[str, object]:
    try:
        model = re.search(
            r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE
        )
    except OSError:
        model = None
    describe = ["git", "-C", str(ROOT), "describe", "--always", "--dirty"]
    git = subprocess.run(describe, capture_output=True, text=True) if shutil.which("git") else None
    return {
        "cpu": model.group(1).strip() if model else platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "numpy": installed("numpy"),
        "gcomp": git.stdout.strip() if git and git.stdout else "of no known version",
    }


def note(text: str) -> None:
    print(text, "...", file=sys.stderr, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure gcomp beside its peers.")
    parser.add_argument(
        "--lines",
        type=int,
        default=1_000_000,
        help="lines of motion per file (default %(default)s)",
    )
    parser.add_argument(
        "--only", default="a,a2,b,c", metavar="a,c", help="only these files (default %(default)s)"
    )
    parser.add_argument(
        "--repeat", type=int, default=2, help="runs of each, the best counts (default %(default)s)"
    )
    parser.add_argument(
        "--memory",
        action="store_true",
        help="also peak memory on file a and on one 5 times as long",
    )
    parser.add_argument(
        "--fetch", action="store_true", help="first get the peers that are missing (apt, pip)"
    )
    parser.add_argument(
        "--dir", type=Path, help="keep the programs in this folder (default: a temporary one)"
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="also write all figures to this file"
    )
    options = parser.parse_args()
    names = options.only.split(",")
    if unknown := [name for name in names if name not in ("a", "a2", "b", "c")]:
        parser.error(f"--only: {unknown[0]!r} is not one of a, a2, b, c")
    if options.fetch:
        fetch()
    with tempfile.TemporaryDirectory(prefix="gcomp-speed-") as temporary:
        folder = options.dir.resolve() if options.dir else Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        bench = Bench(folder)
        about = computer()
        speed = measure_speed(bench, names, options.lines, max(1, options.repeat))
        start = measure_start(bench)
        memory = measure_memory(bench, options.lines) if options.memory else []
    machine = (
        "{cpu}, {cores} cores, {system}, Python {python}, numpy {numpy}, gcomp {gcomp}".format(
            **about
        )
    )
    print(f"{machine}; best of {options.repeat}\n")
    print(speed_table(speed))
    print(start_table(start))
    if memory:
        print(memory_table(memory))
    if options.json:
        figures = {"computer": about, "lines": options.lines, "repeat": options.repeat}
        for title, rows in (("speed", speed), ("start", start), ("memory", memory)):
            figures[title] = [{**asdict(row), "lines_per_cpu_s": row.rate} for row in rows]
        options.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
