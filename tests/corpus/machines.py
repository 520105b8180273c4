"""Made-up machines for the real programs: one without errors, and some with smooth maps; all work
and tool offsets stated as zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from tests.corpus.programs import ROTARY, XYZ

FAR = 3000.0  # mm: tables reach from -FAR to FAR

TOML = """\
format  = "gcomp-machine/1"
name    = "{name}"
control = "linuxcnc"
chain   = "w-X-Y-b-Z-t"
source  = "made up for the tests"
"""
LATHE_LINES = {
    '"w-X-Y-b-Z-t"': '"w-b-Z-X-t"\ndiameter = ["X"]',
    "C0Y = 12.0\n": "",
    "A0Z = -9.0\n": "",
}
LIVE_CHAINS = {"": "w-b-Z-X-t", "C": "w-C-b-Z-X-t", "YC": "w-C-b-Z-X-Y-t"}
SQUARE = """
[squareness]
C0Y = 12.0
A0Z = -9.0
B0Z = 7.0
"""
AXIS = """
[axes.{axis}]
travel = [-{far}, {far}]
least_increment = {least}
"""
WAVES = {  # component: um or urad, mm of a wave, phase
    "XX": (8.0, 410.0, 0.3),
    "YX": (5.0, 230.0, 1.1),
    "ZX": (6.0, 310.0, 2.0),
    "AX": (2.0, 900.0, 0.5),
    "BX": (1.5, 700.0, 1.0),
    "CX": (2.0, 800.0, 0.1),
    "XY": (6.0, 260.0, 1.7),
    "YY": (9.0, 380.0, 0.9),
    "ZY": (4.0, 170.0, 0.2),
    "AY": (1.5, 650.0, 1.4),
    "BY": (2.0, 950.0, 0.7),
    "CY": (1.0, 500.0, 2.2),
    "XZ": (5.0, 210.0, 0.8),
    "YZ": (7.0, 290.0, 1.9),
    "ZZ": (8.0, 350.0, 0.6),
    "AZ": (2.0, 850.0, 0.9),
    "BZ": (1.5, 750.0, 1.8),
    "CZ": (1.0, 600.0, 0.4),
}
GAP_UM = 3.0  # half of it each way


@dataclass(frozen=True)
class Variant:
    """How a program is run on the machine with a map."""

    two_way: bool = True
    least: float = 0.0001
    tolerance_um: float = 1.0

    def __str__(self) -> str:
        ways = "both directions" if self.two_way else "one direction"
        return f"{ways}, least increment {self.least:g} mm, tolerance {self.tolerance_um:g} um"


MAIN = Variant()
VARIANTS = (
    MAIN,
    Variant(False),
    Variant(True, 0.0001, 5.0),
    Variant(False, 0.0001, 5.0),
    Variant(True, 0.001),
    Variant(True, 0.001, 5.0),
)


def write_zero(folder: Path, lathe: bool = False) -> Path:
    """X Y Z A B C (a lathe: X and Z) without errors."""
    folder.mkdir(parents=True)
    text = TOML.format(name=folder.name)
    for axis in "XZ" if lathe else XYZ + ROTARY:
        text += AXIS.format(axis=axis, far=FAR + 100 if axis in XYZ else 1e6, least=0.0001)
        if axis in XYZ:
            text += f'table = "{axis}.csv"\n'
            rows = [f"{axis}_mm,E{axis}{axis}_um", f"{-FAR},0.0", f"{FAR},0.0"]
            (folder / f"{axis}.csv").write_text("\n".join(rows) + "\n")
    return _written(folder, text, lathe)


def write_smooth(
    folder: Path, two_way: bool, least: float, lathe: bool = False, live: str = ""
) -> Path:
    """X Y Z with all errors of their slides as smooth waves of a few um, and A B C without tables;
    a lathe: X and Z; `live`: "C" or "YC", its further axes."""
    folder.mkdir(parents=True)
    text = TOML.format(name=folder.name) + SQUARE
    nodes = np.arange(-FAR, FAR + 1, 25.0)
    for axis in f"XZ{live}" if lathe else XYZ + ROTARY:
        text += AXIS.format(axis=axis, far=FAR + 100 if axis in XYZ else 1e6, least=least)
        if axis not in XYZ:
            continue
        text += f'table = "{axis}.csv"\n'
        columns = {f"{axis}_mm": nodes}
        for direction, unit in ((d, u) for u, ds in (("um", XYZ), ("urad", ROTARY)) for d in ds):
            size, length, phase = WAVES[direction + axis]
            values = size * np.sin(2 * np.pi * nodes / length + phase)
            name = f"E{direction}{axis}_{unit}"
            if two_way and direction == axis:
                gap = GAP_UM * (0.8 + 0.2 * np.sin(nodes / 500.0))
                columns |= {name + "_fwd": values - gap / 2, name + "_rev": values + gap / 2}
            else:
                columns[name] = values
        rows = [
            ",".join(columns),
            *(",".join(f"{v:.4f}" for v in row) for row in zip(*columns.values(), strict=True)),
        ]
        (folder / f"{axis}.csv").write_text("\n".join(rows) + "\n")
    return _written(folder, text, lathe, live)


def _written(folder: Path, text: str, lathe: bool, live: str = "") -> Path:
    for old, new in LATHE_LINES.items() if lathe else ():
        text = text.replace(old, new)
    text = text.replace("w-b-Z-X-t", LIVE_CHAINS[live])
    (folder / "machine.toml").write_text(text)
    return folder


class Machines:
    """The machines, written once into a folder."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._read: dict[str, Machine] = {}

    def zero(self, lathe: bool = False) -> Machine:
        return self._machine("zero", lathe, lambda path: write_zero(path, lathe))

    def smooth(self, variant: Variant, lathe: bool = False) -> Machine:
        name = f"{'two' if variant.two_way else 'one'}-way-{variant.least:g}"
        return self._machine(
            name, lathe, lambda path: write_smooth(path, variant.two_way, variant.least, lathe)
        )

    def _machine(self, name: str, lathe: bool, write: Callable[[Path], Path]) -> Machine:
        name += "-lathe" if lathe else ""
        if name not in self._read:
            path = self.folder / name
            self._read[name] = read_machine(path if path.exists() else write(path))
        return self._read[name]


@lru_cache
def offsets() -> dict[str, dict[str, float]]:
    """Every work and tool offset that a program could name, zero."""
    zero = dict.fromkeys(XYZ + ROTARY, 0.0)
    names = (
        [f"G{n}" for n in range(54, 60)]
        + ["G59.1", "G59.2", "G59.3"]
        + [f"G{n}" for n in range(505, 600)]
    )
    names += [f"G54.1 P{n}" for n in range(1, 49)] + [f"T{n:02d}{n:02d}" for n in range(1, 100)]
    names += [f"T{n:04d}" for n in range(1, 100)]
    names += [f"{letter}{n}" for letter in "HDT" for n in range(100)] + [
        f"T{n}D1" for n in range(100)
    ]
    return {name: dict(zero, R=0.0) if name[0] in "DT" else zero for name in names}
