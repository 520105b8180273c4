"""G47 of Haas mills under --expand: it stays, but within turned coordinates the letters would have
to be turned as well.

Haas Mill Operator's Manual, "G47 Text Engraving": the built-in program that it runs turns and
scales the coordinates by itself (manual 96-8000 rev R, page 159: "G68 R#4", "G51 P").
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form


class Engraving(Cycle):
    """G47."""

    codes = (470,)
    form = Form("an engraving", stays=True)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The block as it is. Raises ProgramError within a frame."""
        if scene.turned:
            raise scene.fault(
                "G47 (engraving) within a frame that is written out",
                "its letters would stand as without it: let the CAM program write the text out",
            )
        return Outcome([block.text], stays=True)
