"""G150 of Haas mills: a pocket of any shape, which a subprogram draws.

Haas Mill Operator's Manual (2017, next generation control), "G150 General Purpose Pocket Milling":
the tool goes to the start place X Y and down by Q from the R plane, again and again until Z; at
each depth it "will first make a pass around pocket geometry, leaving stock with K, then doing
passes of I or J roughing out inside"; with K a finish pass follows around the wall, at Z alone. The
subprogram (P: an N number of this program, or a program) begins with the motion from the start
place to the wall, is closed, and has no variables and 40 motions at most. G41 or G42 with D in the
block stays on behind it: the finish pass is that contour under compensation.

Assumed: I are steps along X, with strokes along Y between them, J the other way round; strokes
begin at the side nearer to the first place of the shape, and ways between them lie along the pass
around it. Whatever the control does there lies within the same pocket. Without K the last pass at Z
cuts nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from postproc.errors import ProgramError
from postproc.nc.cycles import pocket_path
from postproc.nc.cycles.block import Block, Word, blocks
from postproc.nc.cycles.cycle import Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.pocket_path import DoesNotFit, Piece, Point
from postproc.nc.cycles.pole_arc import centre_of
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER, Scene
from postproc.nc.cycles.words import Form

CODE = 1500
LEFT, RIGHT = 410, 420
MOST_MOTIONS, MOST_DEPTHS = 40, 1000
WORDS: Mapping[str, str] = MappingProxyType({
    "P": "the subprogram with its shape",
    "X": "start place",
    "Y": "start place",
    "Z": "depth",
    "R": "level to which it goes in rapid",
    "Q": "how much deeper each pass lies",
    "I": "steps along X",
    "J": "steps along Y",
    "K": "stock for the finish pass",
    "D": "the tool's radius",
})  # fmt: skip
NEAR = 1e-4  # of the program's unit: a closed shape
MOTIONS = {0: 0, 10: 0, CLOCKWISE: -1, COUNTER: 1}
WRITE = "write it as G1, G2 and G3 with numbers"


class Pocket(Cycle):
    """G150."""

    codes = (CODE,)
    form = Form("a pocketing cycle", WORDS)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The plain lines of a pocket. Raises ProgramError."""
        _modes(scene)
        side = {LEFT: 1, RIGHT: -1}[_side(scene, block)]
        radius, stock = self._radius(scene, block), scene.length_in(block, "K", "X")
        axis, step = self._step(scene, block, radius)
        start = _start(scene, block)
        shape = _shape(scene, block, start)
        #  .--------------.    Outside the shape, which the finish pass cuts under G41 or G42;
        #  | .----------. |    within it the contour, where the tool's centre goes around, its
        #  | | |--.  .->| |    radius and the stock K from the wall; across it the strokes of the
        #  | | |  '--'  | |    clearing, a step of I or J apart, joined along the contour.
        #  | '----------' |
        #  '--------------'
        contour, clearing = self._way(scene, shape, start, radius + stock, side, axis, step)
        m = Moves(scene, own_words(block, "".join(WORDS), {CODE, LEFT, RIGHT}))
        m.move("G0", dict(zip("XY", start, strict=True)))
        plane, depths = self._depths(scene, block)
        m.move("G0", {"Z": plane})
        for depth in depths:
            m.move("G1", {"Z": depth})
            m.move("G1", dict(zip("XY", contour[0].start, strict=True)))
            for piece in [*contour, *clearing]:
                _write(scene, m, piece)
            m.move("G1", dict(zip("XY", start, strict=True)))
        # G41 and D stand in the block onto the wall, and stay on behind the cycle as the block's
        # own would.
        first = [m.word(a, v) for a, v in zip("XY", shape[0].start, strict=True)]
        d = block.word("D")
        assert d is not None
        m.words("G1", b"G41" if side > 0 else b"G42", block.text[d.start : d.stop], *first)
        for piece in shape:
            _write(scene, m, piece)
        return Outcome(m.finish())

    def _way(
        self,
        scene: Scene,
        shape: list[Piece],
        start: Point,
        distance: float,
        side: int,
        axis: int,
        step: float,
    ) -> tuple[list[Piece], list[Piece]]:
        """The pass around, and what clears the rest."""
        # An area above 0 runs counter-clockwise: its inside is on the left, where G41 has the tool.
        if pocket_path.area(shape) * side <= 0:
            raise scene.fault(
                "the tool of G150 would run outside of its shape",
                "G41 goes with a shape that runs counter-clockwise, G42 with a clockwise one",
            )
        try:
            contour = pocket_path.beside(shape, distance, side)
            # The start place may lie anywhere in the pocket, but not so that the way in passes the
            # wall.
            way_in = Piece(0, start, contour[0].start)
            pocket_path.keeps_away(pocket_path.walls(shape, side), [way_in], distance)
            return contour, pocket_path.clearing(contour, axis, step)
        except DoesNotFit:
            raise scene.fault(
                f"the tool of G150, {distance:g} from the wall with its stock, does not reach along"
                " all of the shape",
                "check the tool's radius (--offset D1=R5, in mm), K and the shape",
            ) from None

    @staticmethod
    def _depths(scene: Scene, block: Block) -> tuple[float, list[float]]:
        """The R plane, and each depth."""
        for letter in "RZQ":
            if block.word(letter) is None:
                raise scene.fault(f"G150 without {letter}", f"write {letter}: {WORDS[letter]}")
        plane, bottom, down = (scene.length_in(block, x, "Z") for x in "RZQ")
        if down <= 0 or bottom >= plane or (plane - bottom) / down > MOST_DEPTHS:
            raise scene.fault(
                f"G150 from R{plane:g} to Z{bottom:g} by Q{down:g}",
                f"Z lies below R, and Q, above 0, takes {MOST_DEPTHS:,} passes at most",
            )
        count = math.ceil((plane - bottom) / down - 1e-6)
        return plane, [max(plane - k * down, bottom) for k in range(1, count + 1)]

    @staticmethod
    def _step(scene: Scene, block: Block, radius: float) -> tuple[int, float]:
        """The coordinate along which strokes lie apart (0: x), and how far."""
        named = [x for x in "IJ" if block.word(x)]
        if len(named) != 1:
            raise scene.fault(
                f"G150 with {'I and J' if named else 'neither I nor J'}",
                "write I for steps along X, or J for steps along Y",
            )
        step = scene.length_in(block, named[0], "X")
        # A step wider than the tool would leave ridges standing.
        if not 0 < step <= 2 * radius:
            raise scene.fault(
                f"{named[0]}{step:g} of G150, and the tool is {2 * radius:g} wide",
                "a step lies above 0, and is no wider than the tool",
                block.word(named[0]),
            )
        return "IJ".index(named[0]), step

    @staticmethod
    def _radius(scene: Scene, block: Block) -> float:
        """The radius that D names, program's unit."""
        if not block.get("D"):
            raise scene.fault("the tool of G150 has no radius", "name it by D")
        radius = scene.tool_radius("G150", block)
        if not radius:
            raise scene.not_stated("G150", block)
        return radius


def _modes(scene: Scene) -> None:
    if scene.code("plane") != 170:
        raise scene.fault("G150 outside the XY plane", "write G17 before it")
    if scene.incremental:
        raise scene.fault("G150 in G91", "write G90 before it; its shape may be in G91")
    # Of the tracker, not of the scene, which counts the block's own G41 in already.
    if scene.tracker.code("cutter") in (LEFT, RIGHT):
        raise scene.fault(
            "G150 with cutter radius compensation on", "write G40 before it: its own G41 says it"
        )


def _side(scene: Scene, block: Block) -> int:
    own = [c for c in block.codes if c in (LEFT, RIGHT)]
    if len(own) != 1:
        raise scene.fault(
            "G150 without G41 or G42",
            "write the side of the tool in its block: G41 where the shape runs counter-clockwise",
        )
    return own[0]


def _start(scene: Scene, block: Block) -> Point:
    """The start place: where the tool stands, but for what the block names."""
    x, y = (scene.at(a) if (w := block.word(a)) is None else scene.length(w, a) for a in "XY")
    return x, y


def _write(scene: Scene, m: Moves, piece: Piece) -> None:
    """One piece as a line."""
    to = dict(zip("XY", piece.end, strict=True))
    if not piece.turn:
        m.move("G1", to)
        return
    centre = [
        scene.text(c, middle - scene.rounded(a, scene.at(a)))
        for c, a, middle in zip("IJ", "XY", piece.centre, strict=True)
    ]
    m.move("G2" if piece.turn < 0 else "G3", to, *centre)


# -- the shape -------------------------------------------------------------------------------------


def _shape(scene: Scene, block: Block, start: Point) -> list[Piece]:
    """The closed shape that the subprogram draws, behind its first motion. Raises ProgramError."""
    number = block.get("P")
    if number is None:
        raise scene.fault("G150 without P", f"write P: {WORDS['P']}")
    texts = scene.tracker.program(int(number))
    if texts is None:
        raise scene.fault(
            f"there is no N{number:g} and no program O{number:g} with the shape of G150",
            f"add it: O{number:g} before its first block, M99 behind the last",
            block.word("P"),
        )
    # The subprogram is read, not run: variables and jumps in it are refused (`_codes`).
    pieces, here = [], start
    motion, incremental = 10, False
    for part in (
        Block.of(b, scene.dialect.grammar) for t in texts for b in blocks(t, scene.dialect.grammar)
    ):
        motion, incremental = _codes(scene, part, motion, incremental)
        letters = "XYIJR" if motion in (CLOCKWISE, COUNTER) else "XY"
        if not any(part.word(x) for x in letters):
            continue
        x, y = (
            scene.goes(part.word(a), a, at, incremental) for a, at in zip("XY", here, strict=True)
        )
        pieces.append(_piece(scene, part, motion, here, (x, y)))
        here = pieces[-1].end
    if incremental:
        raise scene.fault(
            "the shape of G150 leaves G91 in force", "write G90 before its M99", block.word("P")
        )
    _closed(scene, pieces)
    return [p for p in pieces[1:] if p.turn or math.dist(p.start, p.end) > 0]


def _codes(scene: Scene, part: Block, motion: int, incremental: bool) -> tuple[int, bool]:
    """The motion code and the distance mode in a block of the shape. Raises ProgramError at what is
    none of it."""
    strange = next((w for w in part.words if w.letter not in "NOGXYIJRM"), None)
    if not part.plain or strange is not None:
        raise _strange(scene, part)
    for code in part.codes:
        if code in (900, 910):
            incremental = code == 910
        elif code in MOTIONS:
            motion = code
        else:
            raise _strange(scene, part)
    return motion, incremental


def _strange(scene: Scene, part: Block) -> ProgramError:
    text = part.text.strip().decode("latin-1")[:40]
    return scene.fault(f"{text!r} in the shape of G150 can not be followed", WRITE)


def _piece(scene: Scene, part: Block, motion: int, start: Point, end: Point) -> Piece:
    turn = MOTIONS[motion]
    if not turn:
        return Piece(0, start, end)
    radius, i, j = (part.word(x) for x in "RIJ")
    if radius is None:
        if i is None and j is None:
            raise _strange(scene, part)
        by = [0.0 if w is None else scene.length(w, "X") for w in (i, j)]
        centre = start[0] + by[0], start[1] + by[1]
    else:
        centre = _by_radius(scene, part, radius, turn, start, end)
    miss = abs(math.dist(start, centre) - math.dist(end, centre))
    if miss > min(10 * NEAR, scene.dialect.arc_tolerance_mm / scene.unit):
        raise scene.fault(
            "an arc in the shape of G150 misses its own end",
            f"check {part.text.strip().decode('latin-1')[:40]!r}",
        )
    return Piece(turn, start, end, centre)


def _by_radius(scene: Scene, part: Block, word: Word, turn: int, start: Point, end: Point) -> Point:
    r, chord = scene.length(word, "X"), math.dist(start, end)
    if not 0 < chord / 2 <= abs(r) + scene.dialect.radius_tolerance_mm / scene.unit:
        raise _strange(scene, part)
    return centre_of(start, end, r, turn)


def _closed(scene: Scene, pieces: list[Piece]) -> None:
    """Raises ProgramError where the shape is none that the control takes."""
    if len(pieces) > MOST_MOTIONS:
        raise scene.fault(
            f"{len(pieces)} motions in the shape of G150", f"the control takes {MOST_MOTIONS}"
        )
    if len(pieces) < 2 or pieces[0].turn or math.dist(pieces[0].end, pieces[-1].end) > NEAR:
        raise scene.fault(
            "the shape of G150 is not closed",
            "G1 from the start place to the wall, then around it, back to that place",
        )
    around = pieces[1:]
    if abs(pocket_path.corner(around[-1], around[0])) > 1e-3:
        raise scene.fault(
            "the shape of G150 begins in a corner",
            "begin it on a line: where the compensation comes on there, the manual leaves open",
        )
