"""LinuxCNC's interpreter as a witness: what a program makes the machine do, in mm and machine
coordinates.

Nothing of gcomp is imported here, and nothing of LinuxCNC: the interpreter runs in a subprocess
(canon.py). tests/linuxcnc/README.md says how, and what was found about it.
"""

import functools
import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp" / "linuxcnc"
PROGRAMS = HERE / "programs"
REFUSED = HERE / "refused"
SECONDS_PER_BATCH = 300.0


@dataclass(frozen=True)
class Motion:
    """One canonical motion. `start` and `end` are X Y Z (mm) A B C (degrees) in machine
    coordinates."""

    line: int  # in the source, from 1
    kind: str  # "rapid", "feed", "arc", "dwell" or "probe"
    start: tuple[float, ...]
    end: tuple[float, ...]
    plane: str | None = None  # arc: "XY", "ZX" or "YZ"
    centre: tuple[float, float] | None = None  # arc: along the plane's first and second letter
    turns: int | None = None  # arc: 1 ccw, -1 cw, 2 ccw with one more full turn ...
    seconds: float | None = None  # dwell


class ProgramError(Exception):
    """LinuxCNC refuses the program. `before` holds the motions it had made by then."""

    def __init__(self, line, message, before=()):
        super().__init__(f"line {line}: {message}")
        self.line, self.message, self.before = line, message, list(before)


def available():
    """None if the oracle can be used, else why not (for pytest.skip). Fetches nothing by itself."""
    if not (CACHE / "complete").exists():
        return f"LinuxCNC's interpreter is not in {CACHE}: run tests/linuxcnc/fetch.sh"
    if python() is None:
        return "no Python 3.11 that can load LinuxCNC's gcode module was found"
    return None


def motions(text, *, block_delete=False, parameters=None, tools=None):
    """What `text` makes the machine do: a list of Motion, or ProgramError.

    parameters: {5221: 1.0, ...} as LinuxCNC keeps them, lengths in mm; tools: {1: {"Z": 10.0, "D":
    6.0}} in mm. The machine is metric, starts at zero in G21 G90 G17 G54 and has the axes X Y Z A B
    C.
    """
    [result] = motions_of_many(
        [(text, dict(block_delete=block_delete, parameters=parameters, tools=tools))]
    )
    if isinstance(result, ProgramError):
        raise result
    return result


def motions_of_many(programs):
    """`motions` for a list of (text, keywords), in one subprocess. A refused program's result is
    its ProgramError."""
    if (reason := available()) is not None:
        raise RuntimeError(reason)
    with tempfile.TemporaryDirectory(prefix="gcomp-linuxcnc-") as home:
        results = Path(home) / "results"
        done = subprocess.run(
            [python(), str(HERE / "canon.py"), str(results), str(CACHE / "usr/bin/rs274")],
            input=json.dumps([_job(text, **keywords) for text, keywords in programs]),
            env=_environment(home),
            cwd=home,
            text=True,
            capture_output=True,
            timeout=SECONDS_PER_BATCH,
        )
        if done.returncode:
            raise RuntimeError(f"canon.py failed:\n{done.stderr}")
        return [_result(json.loads(line)) for line in results.read_text().splitlines()]


def load(path):
    """A program file and its sidecar NAME.toml, as `motions` and `motions_of_many` take them:
    (text, keywords)."""
    sidecar = path.with_suffix(".toml")
    keywords = tomllib.loads(sidecar.read_text()) if sidecar.exists() else {}
    if "parameters" in keywords:
        keywords["parameters"] = {
            int(number): value for number, value in keywords["parameters"].items()
        }
    return path.read_bytes().decode("ascii"), keywords


@functools.cache
def python():
    """The path of a Python 3.11 that loads the module; Debian's own is tried first."""
    candidates = ["/usr/bin/python3.11", shutil.which("python3.11"), sys.executable]
    for candidate in filter(None, candidates):
        try:
            tried = subprocess.run(
                [candidate, "-c", "import gcode"],
                env=_environment("/nonexistent"),
                capture_output=True,
                timeout=60.0,
            )
        except OSError:
            continue
        if tried.returncode == 0:
            return candidate
    return None


def _environment(home):
    libraries = [CACHE / "usr/lib", *sorted((CACHE / "usr/lib").glob("*-linux-gnu"))]
    modules = CACHE / "usr/lib/python3/dist-packages"
    return {
        "HOME": str(home),
        "PATH": os.environ.get("PATH", ""),
        "PYTHONPATH": str(modules),
        "LD_LIBRARY_PATH": ":".join(map(str, libraries)),
        "PYTHONDONTWRITEBYTECODE": "1",
        "LC_ALL": "C.UTF-8",
        # new memory is zero: LinuxCNC leaves a field or two unset, and crashes at random
        "MALLOC_PERTURB_": "255",
    }


def _job(text, block_delete=False, parameters=None, tools=None):
    parameters = [(int(number), float(value)) for number, value in (parameters or {}).items()]
    return {
        "text": text,
        "block_delete": bool(block_delete),
        "parameters": parameters,
        "tools": tools or {},
    }


def _result(answer):
    made = [
        Motion(
            **{
                key: tuple(value) if isinstance(value, list) else value
                for key, value in motion.items()
            }
        )
        for motion in answer["motions"]
    ]
    return ProgramError(answer["line"], answer["error"], made) if "error" in answer else made
