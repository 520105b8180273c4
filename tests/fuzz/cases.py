"""Cases of a fuzz: a program with the options that decide what becomes of it, and the machines they
are tried on."""

from __future__ import annotations

import random
import tempfile
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from postproc.compensate import Options
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects

MODES = ("mean", "step", "ramp", "off")
MAPS = ("zero", "one-way", "two-way")
LATHES = ("fanuc-lathe", "fanuc-lathe-a", "fanuc-lathe-c", "haas-lathe", "okuma-lathe")

WIDE = {
    "mill": {"X": (0.0, 200.0), "Y": (-60.0, 60.0), "Z": (-40.0, 40.0)},
    "lathe": {"X": (0.0, 170.0), "Z": (0.0, 500.0)},
}
OFFSETS = {
    **{f"G{n}": {"X": 5.0 * n - 270, "Z": 1.0} for n in range(54, 60)},
    "G59.1": {"X": 3.0},
    "G59.3": {},
    "G54.1 P1": {"X": 1.5, "Z": 2.0},
    "G54.1 P2": {},
    "G505": {"X": 2.0},
    "G110": {"X": 1.0},
    "H1": {"Z": 12.5},
    "H2": {"Z": -3.0},
    "T1": {"Z": 7.25},
    "T2": {"X": 1.0, "Z": 3.0},
    "D1": {"Z": 20.0},
    "D2": {},
    "T0101": {"X": 1.0, "Z": -2.0},
    "T0202": {},
    "G15 H1": {"X": 1.5, "Z": 2.0},
    "G15 H2": {},
    "G247 P1": {"X": 1.5, "Z": 2.0},
}


@dataclass(frozen=True)
class Case:
    """A program with all that decides what becomes of it. cuts: where the batches end; stated:
    whether the offsets and the place before the program are known."""

    text: bytes
    dialect: str = "linuxcnc"
    map: str = "one-way"
    mode: str = "step"
    expand: bool = False
    delete: bool = False
    stated: bool = True
    clamp: bool = True
    cuts: tuple[int, ...] = ()

    def options(self) -> str:
        """All but the text, in one line that `case_of` reads."""
        return (
            f"dialect={self.dialect} map={self.map} mode={self.mode} expand={self.expand:d}"
            f" delete={self.delete:d} stated={self.stated:d} clamp={self.clamp:d}"
            f" cuts={','.join(map(str, self.cuts)) or '-'}"
        )


def case_of(text: bytes, options: str) -> Case:
    """The case that a line of options makes of a text."""
    found = dict(part.split("=", 1) for part in options.split() if "=" in part)
    case = Case(text, found.pop("dialect"), found.pop("map"), found.pop("mode"))
    cuts = found.pop("cuts", "-")
    flags = {name: value == "1" for name, value in found.items()}
    return replace(case, **flags, cuts=() if cuts == "-" else tuple(map(int, cuts.split(","))))


def random_case(rng: random.Random, text: bytes, dialect: str) -> Case:
    """A text under options of chance."""
    cuts = sorted(rng.randrange(len(text) + 1) for _ in range(rng.choice((1, 2, 5))))
    return Case(
        text,
        dialect,
        rng.choice(("zero", "one-way", "one-way", "two-way", "two-way", "two-way")),
        rng.choice((*MODES, "mean", "step")),
        rng.random() < 0.4,
        rng.random() < 0.2,
        rng.random() < 0.85,
        rng.random() < 0.8,
        tuple(cuts),
    )


# -- machines --------------------------------------------------------------------------------------

HEAD = """\
format  = "gcomp-machine/1"
name    = "{name}"
control = "linuxcnc"
chain   = "{chain}"
source  = "made up for the tests"
{diameter}
[limits]
max_correction = 0.5
max_slope = 0.005
{square}"""
SQUARE = {
    "mill": "[squareness]\nC0Y = 25.0\nA0Z = -15.0\nB0Z = 20.0\n",
    "lathe": "[squareness]\nB0X = -90.0\n",
}
AXIS = """
[axes.{axis}]
travel = [-3000.0, 3000.0]
least_increment = 0.0001
table  = "{axis}.csv"
measured_at = {{ {others} }}
"""


def _write(folder: Path, shape: str, kind: str) -> Path:
    """A machine with all errors of its slides, 10-20 um and urad, or with none; two-way: its place
    depends on direction."""
    folder.mkdir()
    ranges = WIDE[shape]
    chain, diameter = ("w-X-Y-b-Z-t", "") if shape == "mill" else ("w-b-Z-X-t", 'diameter = ["X"]')
    square = "" if kind == "zero" else SQUARE[shape]
    text = [HEAD.format(name=f"{shape}-{kind}", chain=chain, diameter=diameter, square=square)]
    for axis, (low, high) in ranges.items():
        nodes = np.linspace(low, high, 9)
        text.append(
            AXIS.format(axis=axis, others=", ".join(f"{o} = 0.0" for o in ranges if o != axis))
        )
        rng = np.random.default_rng(ord(axis))
        columns = {f"{axis}_mm": nodes}
        for kinds, unit in (("XYZ", "um"), ("ABC", "urad")):
            for direction in kinds:
                name, values = (
                    f"E{direction}{axis}_{unit}",
                    np.cumsum(rng.normal(0.0, 5.0, len(nodes))),
                )
                values = values * (kind != "zero")
                if kind == "two-way" and direction == axis:
                    columns |= {
                        name + "_rev": values + 2.0,
                        name + "_fwd": values - 2.0 - 0.5 * rng.random(len(nodes)),
                    }
                else:
                    columns[name] = values
        rows = [
            ",".join(columns),
            *(",".join(f"{v:.3f}" for v in row) for row in zip(*columns.values(), strict=True)),
        ]
        (folder / f"{axis}.csv").write_text("\n".join(rows) + "\n")
    (folder / "machine.toml").write_text("".join(text))
    return folder


@cache
def machine(shape: str, kind: str):
    """ "mill" or "lathe", of one of MAPS."""
    with tempfile.TemporaryDirectory() as folder:
        return places.load(str(_write(Path(folder) / f"{shape}-{kind}", shape, kind)))


@cache
def dialect(name: str):
    return dialects.load(name)


def filter_of(case: Case) -> Filter:
    """The filter that the case asks for."""
    shape = "lathe" if case.dialect in LATHES else "mill"
    spoken = dialect(case.dialect)
    built = machine(shape, case.map).carrying(spoken.carried)
    letters = set(built.letters)
    offsets = (
        {n: {x: v for x, v in place.items() if x in letters} for n, place in OFFSETS.items()}
        if case.stated
        else {}
    )
    start = dict.fromkeys(WIDE[shape], 0.0) if case.stated else {}
    setup = setup_of(built, offsets, start, case.delete)
    return Filter(
        built,
        spoken,
        setup,
        Options(None, "clamp" if case.clamp else "error", case.mode),
        name="program",
    )
