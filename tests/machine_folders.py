"""A machine folder made of texts, and what is said of a faulty one: what the tests of machine
folders share."""

from __future__ import annotations

from pathlib import Path

import pytest

from postproc.errors import MachineError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects

TOML = """\
format  = "gcomp-machine/1"
name    = "example-grinder"
title   = "Two-axis cylindrical grinder"
control = "fanuc-lathe"            # dialect
chain   = "w-b-Z-X-t"              # workpiece, bed, then who carries whom, to the tool
diameter = ["X"]
source  = "where the numbers come from"

[axes.Z]
travel = [-5.0, 520.0]             # mm, slide positions
least_increment = 0.0001
table  = "Z.csv"
measured_at = { X = 0.0 }
max_velocity = 10000.0             # mm/min
max_acceleration = 1500.0          # mm/s2

[axes.X]
travel = [-5.0, 175.0]
least_increment = 0.0001
table  = "X.csv"

[squareness]
B0X = -382.352941                  # urad

[tool]
X = 0.0
Z = 0.0

[offsets]
G54 = { X = 0.0, Z = 0.0 }

[limits]
max_correction = 0.5               # mm
max_slope = 0.005                  # mm per mm
outside = "error"

[[effect]]
name = "backlash"
axis = "X"
size_um = 9.0
source = "diagnosed from a recording on 2026-11-30"
"""
Z_CSV = """\
# made up
Z_mm,EZZ_um_fwd,EZZ_um_rev,EXZ_um,EBZ_urad
0,1,-1,2,10
100,3,0,1,20
250,2,1,0,-5
"""
X_CSV = """\
X_mm,EXX_um,EZX_um
0,0,0
50,5,-1
170,2,3
"""


def folder(path: Path, toml=TOML, z=Z_CSV, x=X_CSV) -> Path:
    """A machine folder of these texts (str or bytes; None: no such file)."""
    for name, text in (("machine.toml", toml), ("Z.csv", z), ("X.csv", x)):
        if text is not None:
            (path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def swap(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
    return text.replace(old, new)


def refusal(path: Path) -> MachineError:
    with pytest.raises(MachineError) as caught:
        read_machine(path)
    return caught.value


def line_of(text: str, part: str) -> int:
    """Line, from 1, in which `part` ends: with `part` = a key, that of the key."""
    assert text.count(part) == 1, f"{part!r} stands {text.count(part)} times"
    return text.count("\n", 0, text.index(part) + len(part.rstrip("\n"))) + 1


def check(error: MachineError, file: Path, line: int, says: tuple[str, ...]) -> None:
    assert error.place is not None
    assert (error.place.file, error.place.line) == (str(file), line), str(error)
    assert str(error).startswith(f"{file}:{line}: ")
    for part in says:
        assert part in str(error)
    assert "None" not in str(error), "a key that is missing is called so"


def correct(machine, program: bytes) -> bytes:
    filter_ = Filter(machine, dialects.load(machine.control), setup_of(machine))
    return filter_.feed(program) + filter_.finish()
