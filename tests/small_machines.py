"""Small machines for random programs, and the sites on them: a mill with all errors of its slides,
the grinder, and one with lost motion."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from tests.programs import Site

TOML = """\
format  = "gcomp-machine/1"
name    = "{name}"
control = "linuxcnc"
chain   = "w-X-Y-b-Z-t"
source  = "made up for the tests"
[squareness]
C0Y = 25.0
A0Z = -15.0
B0Z = 20.0
"""
AXIS = """
[axes.{axis}]
travel = [{low}, {high}]
least_increment = 0.0001
table  = "{axis}.csv"
measured_at = {{ {others} }}
"""
MILL_RANGES = {"X": (0.0, 200.0), "Y": (-60.0, 60.0), "Z": (-40.0, 40.0)}
MILL_NODES = {
    axis: tuple(np.linspace(low, high, 9).tolist()) for axis, (low, high) in MILL_RANGES.items()
}


def write_mill(folder: Path, two_way: bool) -> Path:
    """A machine of three axes with all errors of their slides, 10-20 um and urad; two_way:
    positioning by direction."""
    folder.mkdir()
    text = [TOML.format(name=folder.name)]
    for axis, nodes in MILL_NODES.items():
        others = ", ".join(f"{other} = 0.0" for other in MILL_NODES if other != axis)
        text.append(AXIS.format(axis=axis, low=nodes[0] - 5, high=nodes[-1] + 5, others=others))
        rng = np.random.default_rng(ord(axis))
        columns = {f"{axis}_mm": np.array(nodes)}
        for kind, unit in (("XYZ", "um"), ("ABC", "urad")):
            for direction in kind:
                name, values = (
                    f"E{direction}{axis}_{unit}",
                    np.cumsum(rng.normal(0.0, 5.0, len(nodes))),
                )
                if two_way and direction == axis:
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


STUDER_RANGES = {"X": (0.0, 170.0), "Z": (0.0, 510.0)}
STUDER_NODES = {
    "X": tuple(np.arange(0.0, 171.0, 10.0).tolist()),
    "Z": tuple(np.arange(0.0, 511.0, 30.0).tolist()),
}
STUDER_FANUC = Site("fanuc-lathe", STUDER_RANGES, STUDER_NODES, ("X",))
STUDER_LINUXCNC = Site("linuxcnc", STUDER_RANGES, STUDER_NODES, ("X",))
MILL = Site("linuxcnc", MILL_RANGES, MILL_NODES)
OFFSETS = {
    "G54": {"X": 0.0, "Z": 0.0},
    "G55": {"X": 12.5, "Z": 100.0},
    "G59": {"X": -3.0001, "Z": 77.7},
}


def write_lagging(source: Path, folder: Path) -> Path:
    """The machine of a folder with the reversal of its positioning as real lost motion: forward
    never beyond reverse."""
    shutil.copytree(source, folder)
    for path in folder.glob("?.csv"):
        lines = path.read_text().splitlines()
        head = next(i for i, line in enumerate(lines) if not line.startswith("#"))
        columns, own = lines[head].split(","), f"E{path.stem}{path.stem}_um"
        if own + "_fwd" not in columns:
            continue
        one, two = columns.index(own + "_fwd"), columns.index(own + "_rev")
        for i in range(head + 1, len(lines)):
            row = lines[i].split(",")
            row[one], row[two] = sorted((row[one], row[two]), key=float)
            lines[i] = ",".join(row)
        path.write_text("\n".join(lines) + "\n")
    return folder
