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
import importlib.metadata
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp"
LINUXCNC = CACHE / "linuxcnc"
# Peers of PyPI: the tool, and on how many lines of a file it runs; they would take minutes or
# gigabytes on a whole one, and their rates do not depend on the length.
PYPI = {"pygcode 0.2.1": 10_000, "nc-gcode-interpreter 0.1.9": 200_000, "gcodeparser 0.3.0": 50_000}
TWO_WAY = "gcomp, two-way tables"
STARTS = 10
TIME_LIMIT = 900.0  # s, for one process

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


# ---- measuring -----------------------------------------------------------------------------------


def run(command: Command) -> Usage:
    """Run a command through child.py; Absent, with what it complained of last, if it fails."""
    watched = [sys.executable, "-I", "-S", str(HERE / "child.py"), *command.arguments]
    process = subprocess.Popen(
        watched,
        env={**os.environ, **command.environment},
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


# ---- the tools -----------------------------------------------------------------------------------


class Bench:
    """The folder with the programs and machines, and how each tool is called on one of them."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.mill, self.mill_two_way = folder / "mill", folder / "mill-two-way"
        self.home = folder / "home"
        self.home.mkdir(exist_ok=True)
        (folder / "tool.tbl").write_text("T1 P1\n", encoding="ascii")
        python(HERE / "machine.py", self.mill)
        python(HERE / "machine.py", self.mill_two_way, "--two-way")
        self.tools = {
            "gcomp": self.gcomp,
            TWO_WAY: self.gcomp_two_way,
            "LinuxCNC gcode.parse": self.gcode_parse,
            "LinuxCNC rs274 -g": self.rs274,
        }
        self.tools |= {tool: partial(self.of_pypi, tool) for tool in PYPI}

    def write(self, name: str, lines: int) -> Path:
        """The program `name` of that length; it is kept, as its bytes depend on nothing else."""
        folder = self.folder / str(lines)
        path = folder / f"{name}.nc"
        if not path.exists():
            python(HERE / "files.py", folder, "--lines", lines, "--only", name)
        return path

    def gcomp(self, program: Path) -> Command:
        machine = [str(self.mill)]
        if program.stem == "b":
            machine = [str(ROOT / "machines" / "studer-s36"), "--dialect", "linuxcnc"]
        return Command(
            [
                sys.executable,
                "-m",
                "postproc",
                "--machine",
                *machine,
                str(program),
                "-o",
                os.devnull,
            ]
        )

    def gcomp_two_way(self, program: Path) -> Command:
        if program.stem == "b":
            raise Absent("the tables of studer-s36 are two-way already")
        command = self.gcomp(program)
        command.arguments[4] = str(self.mill_two_way)
        return command

    def gcode_parse(self, program: Path) -> Command:
        interpreter = sys.executable
        if sys.version_info[:2] != (3, 11):
            interpreter = shutil.which("python3.11")
            if interpreter is None:
                raise Absent("the module is built for Python 3.11, which is not here")
        environment = self.linuxcnc()
        environment["PYTHONPATH"] = str(LINUXCNC / "usr/lib/python3/dist-packages")
        return Command([interpreter, str(HERE / "peer_gcode_parse.py"), str(program)], environment)

    def rs274(self, program: Path) -> Command:
        binary, tools = LINUXCNC / "usr/bin/rs274", self.folder / "tool.tbl"
        return Command([str(binary), "-g", "-t", str(tools), str(program)], self.linuxcnc())

    def linuxcnc(self) -> dict[str, str]:
        if not (LINUXCNC / "usr/bin/rs274").exists():
            raise Absent(f"not in {LINUXCNC}; --fetch gets it (Debian 12)")
        libraries = [
            LINUXCNC / "usr/lib",
            *LINUXCNC.glob("usr/lib/*-linux-gnu"),
            *LINUXCNC.glob("lib/*-linux-gnu"),
        ]
        return {"LD_LIBRARY_PATH": os.pathsep.join(map(str, libraries)), "HOME": str(self.home)}

    def of_pypi(self, tool: str, program: Path) -> Command:
        name, version = tool.split()
        environment = {}
        if place_of(tool).is_dir():
            environment["PYTHONPATH"] = str(place_of(tool))
        elif installed(name) != version:
            raise Absent(f"not installed; --fetch gets it, or pip install {name}=={version}")
        peer = HERE / f"peer_{name.replace('-', '_')}.py"
        return Command([sys.executable, str(peer), str(program)], environment)


def place_of(tool: str) -> Path:
    """Where --fetch puts a peer of PyPI."""
    return CACHE / tool.replace(" ", "-")


def python(*arguments: object) -> None:
    subprocess.run([sys.executable, *map(str, arguments)], check=True)


def installed(package: str) -> str:
    """Its version, or nothing; the package is not imported."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


def fetch() -> None:
    """Get the peers that are not here. What fails is told and shows as absent in the tables."""
    wanted = []
    if not (LINUXCNC / "usr/bin/rs274").exists():
        wanted.append(["sh", str(ROOT / "tests/linuxcnc/fetch.sh"), str(LINUXCNC)])
    for tool in PYPI:
        name, version = tool.split()
        if not place_of(tool).is_dir() and installed(name) != version:
            pip = [
                sys.executable,
                "-m",
                "pip",
                "install",
                "--quiet",
                "--target",
                str(place_of(tool)),
            ]
            wanted.append([*pip, f"{name}=={version}"])
    for command in wanted:
        if subprocess.run(command, stdout=sys.stderr).returncode:
            print("failed:", " ".join(command), file=sys.stderr)


# ---- what is measured ----------------------------------------------------------------------------


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


# ---- tables --------------------------------------------------------------------------------------


def note(text: str) -> None:
    print(text, "...", file=sys.stderr, flush=True)


def table(heads: list[str], lines: list[list[str]]) -> str:
    rule = ["---" if at < 2 else "---:" for at in range(len(heads))]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (heads, rule, *lines)) + "\n"


def ratio(row: Row, rows: list[Row]) -> str:
    """The rate of gcomp on the same file as a multiple of this row's."""
    own = next(other for other in rows if other.file == row.file and other.tool == "gcomp")
    return f"{own.rate / row.rate:.2f}" if own.rate and row.rate else "-"


def speed_table(rows: list[Row]) -> str:
    heads = [
        "file",
        "tool",
        "lines",
        "CPU s",
        "lines per CPU s",
        "wall s",
        "peak MB",
        "gcomp is x times as fast",
    ]
    lines = []
    for row in rows:
        if row.usage is None:
            lines.append([row.file, f"{row.tool}: {row.problem.replace('|', '/')}", *["-"] * 6])
            continue
        used = row.usage
        figures = f"{row.lines:,} {used.cpu_s:.2f} {row.rate:,.0f} {used.wall_s:.2f} {used.peak_mb:.0f}".split()  # noqa: E501
        lines.append([row.file, row.tool, *figures, ratio(row, rows)])
    return table(heads, lines)


def start_table(rows: list[Row]) -> str:
    lines = []
    for row in rows:
        what = f"{row.tool}, {row.lines} lines" if row.lines else row.tool
        if row.usage is None:
            lines.append([what, row.problem.replace("|", "/"), "-", "-"])
        else:
            used = row.usage
            lines.append([what, "", f"{used.wall_s * 1000:.0f}", f"{used.peak_mb:.0f}"])
    return table(["start-up", f"best of {STARTS}", "wall ms", "peak MB"], lines)


def memory_table(rows: list[Row]) -> str:
    lines = []
    for row in rows:
        peak = f"{row.usage.peak_mb:.1f}" if row.usage else "-"
        tool = row.tool if row.usage else f"{row.tool}: {row.problem.replace('|', '/')}"
        lines.append([row.file, tool, f"{row.lines:,}", peak])
    return table(["file", "tool", "lines", "peak MB"], lines)


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
