"""gcomp and the interpreters that others have written: how each is called on a program, and how
those that are missing are fetched."""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

from watched import HERE, ROOT, Absent, Command

CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp"
LINUXCNC = CACHE / "linuxcnc"
# Peers of PyPI: the tool, and on how many lines of a file it runs; they would take minutes or
# gigabytes on a whole one, and their rates do not depend on the length.
PYPI = {"pygcode 0.2.1": 10_000, "nc-gcode-interpreter 0.1.9": 200_000, "gcodeparser 0.3.0": 50_000}
TWO_WAY = "gcomp, two-way tables"


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
