"""Which of Heidenhain's cycles is written out by what: the one that is defined, where it is called.

Holes: klartext_holes.py, bores: klartext_bore.py, pockets and slots: klartext_pocket.py, studs:
klartext_stud.py, faces: klartext_face.py.
"""

from __future__ import annotations

from postproc.nc.cycles.klartext_bore import Tool, bore
from postproc.nc.cycles.klartext_face import FACE, face
from postproc.nc.cycles.klartext_holes import Holes, signed
from postproc.nc.cycles.klartext_pocket import POCKETS, pocket
from postproc.nc.cycles.klartext_stud import STUDS, stud
from postproc.nc.cycles.scene import Scene

BORE = 208


def called(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """The cycle where the tool stands, as L. Raises ProgramError."""
    if data.cycle in POCKETS:
        return pocket(scene, tool, data)
    if data.cycle == FACE:
        return face(scene, tool, data)
    if data.cycle in STUDS:
        return stud(scene, tool, data.cycle, data.value, data.feed)
    return _bored(scene, tool, data) if data.cycle == BORE else data.lines()


def _bored(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """Cycle 208, and the second clearance behind it."""
    values = {n: data.value(n) for n in (200, 201, 203, 334, 335)}
    values[351] = data.value(351, 0.0)
    lines = bore(scene, tool, values, data.feed(206))
    second = data.value(204, values[200])
    if second > values[200]:
        lines.append(b"L " + signed(scene, "Z", values[203] + second) + b" FMAX")
    return lines
