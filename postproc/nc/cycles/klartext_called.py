"""Which of Heidenhain's cycles is written out by what: the one that is defined, where it is called.

Holes: klartext_holes.py, bores: klartext_bore.py, pockets and slots: klartext_pocket.py, studs:
klartext_stud.py, faces: klartext_face.py.
"""

from __future__ import annotations

from postproc.nc.cycles.klartext_bore import BORE, Tool, bore
from postproc.nc.cycles.klartext_face import FACE, face
from postproc.nc.cycles.klartext_holes import Holes
from postproc.nc.cycles.klartext_pocket import POCKETS, pocket
from postproc.nc.cycles.klartext_stud import STUDS, stud
from postproc.nc.cycles.scene import Scene

WRITERS = {
    BORE: bore, FACE: face, **dict.fromkeys(POCKETS, pocket), **dict.fromkeys(STUDS, stud)
}  # fmt: skip


def called(scene: Scene, tool: Tool, data: Holes) -> list[bytes]:
    """The cycle where the tool stands, as L. Raises ProgramError."""
    writer = WRITERS.get(data.cycle)
    return writer(scene, tool, data) if writer else data.lines()
