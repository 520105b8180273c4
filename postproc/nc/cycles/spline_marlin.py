"""Marlin's G5, a cubic Bezier curve in XY, as straight lines.

Marlin/src/gcode/motion/G5.cpp: I J count from the start, P Q from the end, one that is left out is
0, and nothing is kept from curve to curve. planner_bezier.cpp, cubic_b_spline: Z and E go evenly
with the curve's parameter. The firmware itself leaves the curve by as much as 0.1 mm (SIGMA); the
lines here lie nearer to it.
"""

from __future__ import annotations

from collections.abc import Mapping

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.curve import bezier
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form
from postproc.nc.expand.tracker import number

E_DECIMALS = 5  # as slicers write it
WORDS = {
    "X": "end",
    "Y": "end",
    "Z": "end",
    "E": "filament",
    "I": "first pole, from the start",
    "J": "first pole, from the start",
    "P": "second pole, from the end",
    "Q": "second pole, from the end",
}


class MarlinSpline(Cycle):
    """G5."""

    codes = (50,)
    form = Form("a Bezier curve", WORDS)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The lines of the curve. Raises ProgramError."""
        if scene.code("plane") not in (170, -1):
            raise scene.fault("G5 outside the XY plane", "Marlin refuses it: write G17 before")
        start = {x: scene.at(x) for x in "XYZ" if x in "XY" or block.get(x) is not None}
        end = dict(start)
        for axis, here in start.items():
            value = block.get(axis)
            if value is not None:
                end[axis] = here + value if scene.incremental else value
        fed = self._fed(scene, block)
        poles = _poles(block, start, end)
        m = Moves(scene, own_words(block, "".join(WORDS), {code}))
        axes, last = tuple(start), 0.0
        # The share of the parameter is a fourth coordinate: the first three decide where lines end,
        # E goes along.
        for x, y, height, share in bezier(*poles).points(scene.chord, 3):
            place = dict(zip("XYZ", map(float, (x, y, height)), strict=True))
            words = [m.word(axis, place[axis]) for axis in axes if scene.differs(axis, place[axis])]
            if fed is not None:
                begin, by, relative = fed
                now = round(begin + by * float(share), E_DECIMALS)
                words.append(b"E" + number(now - last if relative else now, E_DECIMALS).encode())
                last = now
            m.words("G1", *words)
        # M83: E stands for itself, and no place of it is known.
        if fed is not None and not fed[2]:
            scene.moved("E", fed[0] + fed[1])
        return Outcome(m.finish())

    @staticmethod
    def _fed(scene: Scene, block: Block) -> tuple[float, float, bool] | None:
        """Where E begins (0 where its words are distances), by how much it goes, and whether they
        are; None: no E."""
        value = block.get("E")
        if value is None:
            return None
        # M83, or G91: E words are distances.
        if scene.tracker.code("carried") == 910:
            return 0.0, value, True
        begin = scene.at("E")
        return begin, value - begin, False


def _poles(
    block: Block, start: Mapping[str, float], end: Mapping[str, float]
) -> list[tuple[float, ...]]:
    """X Y, and Z and the share of the way, which grow evenly, of the four control points."""
    z, dz = start.get("Z", 0.0), end.get("Z", 0.0) - start.get("Z", 0.0)
    i, j, p, q = (block.get(x) or 0.0 for x in "IJPQ")
    return [
        (start["X"], start["Y"], z, 0.0),
        (start["X"] + i, start["Y"] + j, z + dz / 3, 1 / 3),
        (end["X"] + p, end["Y"] + q, z + dz * 2 / 3, 2 / 3),
        (end["X"], end["Y"], z + dz, 1.0),
    ]
