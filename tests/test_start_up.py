"""What a run on a short program loads: each module costs its time before the first line is read.

Every package outside the standard library that may be loaded is named here, and of the standard
library what is dear and not needed. Who needs one more says so by adding it, with its milliseconds
(`python -X importtime`).
"""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from postproc import __version__, entry

ROOT = Path(__file__).resolve().parents[1]  # here lies ./machines, the first folder that is asked
ALLOWED = {"numpy", "postproc"}
INSTALLED = {"_distutils_hack", "sitecustomize"}  # of the interpreter's own start, not of gcomp
# numpy.ma: 15 ms, which numpy.unique loads; the others 2 to 20 ms each.
FORBIDDEN = {
    "numpy.ma",
    "numpy.random",
    "numpy.polynomial",
    "numpy.typing",
    "numpy.fft",
    "asyncio",
    "concurrent.futures",
    "ctypes.util",
    "decimal",
    "difflib",
    "email",
    "encodings.utf_8_sig",
    "filecmp",
    "fractions",
    "http",
    "importlib.metadata",
    "json",
    "logging",
    "multiprocessing",
    "pkgutil",
    "socket",
    "sqlite3",
    "ssl",
    "subprocess",
    "unittest",
    "xml",
}
# Parts of the package that only an option, or a section of a machine, asks for: 2 to 16 ms each.
ASKED_FOR = {
    *("control_tables", "effects", "heat", "machine.effect_file", "offsets", "pages", "recordings"),
    *("trace", "verify"),
}
PROGRAM = """%
G21 G90 G17 G54 G94
G0 X10 Y10 Z-5
G1 X50 Y10 F600
G2 X90 Y50 I40 J0
G0 Z0
M30
%
"""
RUN = """
import sys
from postproc.cli import main
status = main(["--machine", sys.argv[1], sys.argv[2], "-o", sys.argv[3]])
print(status, *sorted(sys.modules))
"""


def loaded(tmp_path, machine: str, text: str = PROGRAM) -> set[str]:
    """Names of the modules after a run of its own."""
    program = tmp_path / "short.nc"
    program.write_text(text)
    command = [sys.executable, "-c", RUN, machine, str(program), str(tmp_path / "out.nc")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    status, *modules = done.stdout.split()
    assert status == "0", done.stderr
    return set(modules)


def test_a_run_loads_no_more_than_it_needs(tmp_path):
    modules = loaded(tmp_path, "example-mill")
    packages = {name.partition(".")[0] for name in modules}
    foreign = packages - set(sys.stdlib_module_names) - ALLOWED - INSTALLED - {"__main__"}
    assert not {name for name in foreign if not name.startswith("_")}
    assert not modules & FORBIDDEN
    assert not modules & {f"postproc.{name}" for name in ASKED_FOR}
    commands = {name for name in modules if name.startswith("postproc.commands.")}
    needed = "attempts compensate expansion option_text reading reading_options values".split()
    assert commands == {f"postproc.commands.{name}" for name in needed}


def test_an_arc_loads_nothing_more(tmp_path):
    """On a lathe, where centre words outside of the plane are looked for."""
    lines = (ROOT / "sample_programs" / "shaft.nc").read_text().splitlines()[:14]
    text = "\n".join(lines) + "\n"
    assert not loaded(tmp_path, "studer-s36", text) & FORBIDDEN


VERSION = """
import sys
from postproc.cli import main
main(["--version"])
print("numpy" in sys.modules)
"""


def test_a_look_at_the_version_loads_no_numpy():
    command = [sys.executable, "-c", VERSION]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split()[-1] == "False"


BEGUN = """
import gc, inspect, sys
from postproc import entry

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name in ("numpy", "postproc.cli", "postproc.filter"):
            told.append((name, gc.isenabled(), len(inspect.stack(0))))

told = []
sys.meta_path.insert(0, Watch())
sys.argv = ["gcomp", "--machine", "example-mill", sys.argv[1], "-o", sys.argv[2]]
status = entry.begin()
print(status, gc.isenabled(), *sys.modules)
for line in told:
    print(*line)
"""


def test_it_begins_shallow_and_without_the_collector(tmp_path):
    """Deep in a chain of imports each call may ask for memory anew, and numpy compiles expressions:
    3 ms. The collector is on while programs are corrected."""
    program = tmp_path / "short.nc"
    program.write_text(PROGRAM)
    command = [sys.executable, "-c", BEGUN, str(program), str(tmp_path / "out.nc")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    end, *told = done.stdout.splitlines()
    status, collects, *modules = end.split()
    assert (status, collects) == ("0", "True"), done.stderr
    assert "threading" not in modules  # with it the console script would not end at once
    found = {name: (on, int(depth)) for name, on, depth in map(str.split, told)}
    assert {on for on, _ in found.values()} == {"False"}
    assert found["numpy"][1] <= found["postproc.cli"][1] + 20
    assert list(found) == ["postproc.cli", "numpy", "postproc.filter"]


ENDED = """
import atexit, sys
from postproc import entry
atexit.register(print, "at the end")
sys.argv = ["gcomp", "--version"]
entry.program()
"""


@pytest.mark.parametrize("first, after", [("", ""), ("import threading", "at the end\n")])
def test_the_console_script_ends_at_once_where_no_threads_were(first, after):
    command = [sys.executable, "-c", f"{first}\n{ENDED}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout == f"gcomp {__version__}\n{after}"


def test_the_console_script_is_that_one():
    script = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]["gcomp"]
    assert script == f"{entry.program.__module__}:{entry.program.__name__}"
