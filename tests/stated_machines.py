"""Machines that state how well they are known: what the tests of uncertainty share."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.uncertainty import MapUncertainty

UM, URAD = 1e-3, 1e-6
HEAD = """format = "gcomp-machine/1"
name = "m"
control = "linuxcnc"
chain = "{chain}"
[offsets]
G54 = {{}}
"""
AXIS = '[axes.{0}]\ntravel = [-500.0, 500.0]\nleast_increment = 0.0001\ntable = "{0}.csv"\n'
MILL = HEAD.format(chain="w-X-Y-b-Z-t") + "".join(map(AXIS.format, "XYZ"))
FLAT = {x: f"{x}_mm,E{x}{x}_um\n-500,10\n500,10\n" for x in "XYZ"}


def machine(folder: Path, text: str = MILL, **files: str) -> Machine:
    folder.mkdir(exist_ok=True)
    (folder / "machine.toml").write_text(text)
    for name, content in (FLAT | files).items():
        (folder / f"{name}.csv").write_text(content)
    return read_machine(folder)


def known(m: Machine, way: float = 0.0, **place: float) -> dict[str, float]:
    """U of the deviation at one place, um by axis."""
    position = np.array([[float(place.get(x, 0.0))] for x in m.letters])
    u = MapUncertainty(m).expanded(position, np.full_like(position, way))
    return dict(zip(m.letters, u[:, 0] / UM, strict=True))


EFFECT = (
    '[[effect]]\nname = "cyclic"\naxis = "X"\nperiod_mm = 10.0\namplitude_um = 5.0\nphase_deg ='
    " 0.0\n"
)
