"""BSPLINE of Sinumerik whose knots are known, as straight lines within the tolerance.

Siemens, "NC programming" 12/2019, page 594, and "5-axis machining", page 99: the points of the
blocks are those of the control polygon, the one before is where the axes stand; SD is the degree, 3
where it is not written; PW a weight of 0 to 3, of which 1 attracts neither more nor less; PL the
"parameter interval length", the distance between two knots. How the intervals are counted among
the blocks is not published. That the path goes on from where the axes stand to the last point,
whatever the polygon, leaves no other knots at the ends than degree + 1 equal ones: n points behind
the first have n + 1 - degree intervals between, and degree - 1 of n values of PL are left over.
Which, programs that write such blocks differ about: the first interval stands with the first block
(genua, polysplinecurve.cpp), or with the second one (DK in CATIA, "NURBS Formats in APT Output").
So every run of values is looked at, and those that would jump are none; a spline is followed where
all the others say the same knots, as equal values do, and values of 0 that fill up both ends. Taken
for granted is that values follow one another as the intervals do, and that points whose blocks say
no PW, and the first, have the weight 1.
"""

from __future__ import annotations

import re

import numpy as np

from postproc.errors import BlockFault
from postproc.motions import SPLINE, Motions
from postproc.nc.codes import code_number
from postproc.nc.comments import code_alone
from postproc.nc.cycles.block import Block
from postproc.nc.cycles.curve import Curve
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import CHORD_MM, Scene
from postproc.nc.expand import Line
from postproc.nc.expand.tracker import Tracker
from postproc.nc.lexer import lex
from postproc.units import TICKS_PER_INCH, TICKS_PER_MM

WORD = "BSPLINE"
BEGINS = re.compile(rb"(?<![A-Za-z0-9_$])BSPLINE(?![A-Za-z0-9_])", re.IGNORECASE)
AXES, WORDS = "XYZ", ("PL", "PW", "SD")
DEGREES, DEGREE, HEAVIEST = (2, 3), 3, 3.0
ENDS = (2, 17, 30)
# groups whose codes may stand in the first block; in the others the motion code alone
QUIET = ("motion", "distance", "path")
ALIKE = 1e-9  # of intervals against their sum
NO_POINTS = np.zeros((0, 3))


class Unsure(Exception):
    """Why a spline is not written out, and the way out."""

    def __init__(self, why: str, out: str):
        super().__init__(why)
        self.why, self.out = why, out


UNREAD = Unsure("what its blocks say is not followed", "correct it")


class KnownKnots:
    """Holds a B-spline back until it ends, and hands its lines on: straight ones where its knots
    are known, else the blocks as they are, and in `kept` by file and line why. tolerance: mm."""

    def __init__(self, tracker: Tracker, tolerance: float = CHORD_MM):
        self.tracker, self.scene = tracker, Scene(tracker)
        self.scene.tolerance = tolerance
        self.number = code_number(WORD)
        self.held: list[tuple[Line, Block]] = []
        self.kept: dict[tuple[str, int], Unsure] = {}

    def take(self, line: Line) -> list[Line]:
        """The lines that can leave now."""
        if not self.held and not (BEGINS.search(line.text) and self._begins(line)):
            return self._tracked([line])
        block = Block.of(line.text, self.scene.dialect.grammar)
        motions = self.scene.own_codes(block, "motion")
        goes_on = all(c == self.number for c in motions) and not set(ENDS) & set(block.m_codes())
        if goes_on or block.skip:  # the operator's switch says whether that one ends it
            self.held.append((line, block))
            return []
        return [*self.finish(), *self._tracked([line])]

    def _begins(self, line: Line) -> bool:
        """Whether the control reads BSPLINE there."""
        code = code_alone(line.text, self.scene.dialect.grammar)
        return not self.scene.passes(line.text) and BEGINS.search(code) is not None

    def finish(self) -> list[Line]:
        """What is still held where the program ends."""
        held, self.held = self.held, []
        if not held:
            return []
        self.scene.forget()
        count = max((k for k, (_, block) in enumerate(held, 1) if self._is_point(block)), default=0)
        plain = [line for line, _ in held]
        try:
            if count:
                plain[:count] = self._written(held[:count])
        except Unsure as reason:
            self.kept |= {(line.file, line.source): reason for line in plain[:count]}
        return self._tracked(plain)

    def _is_point(self, block: Block) -> bool:
        """Whether its axis words are a control point."""
        own = any(w.letter in self.tracker.setup.axes for w in block.words)
        return own and all(self.scene.group_of(c) in QUIET for c in block.codes)

    def _tracked(self, lines: list[Line]) -> list[Line]:
        for line in lines:
            self.tracker.take(line.text, line)
        return lines

    def _written(self, held: list[tuple[Line, Block]]) -> list[Line]:
        """The lines of a spline. Raises Unsure."""
        rows, poles = self._polygon(held)
        points = [held[row][1] for row in rows]
        degree = _degree([block for _, block in held])
        weights = _weights(points)
        steps = intervals([block.get("PL") for block in points], degree)
        if steps is None:
            raise Unsure(
                "its PL leave open where its knots are",
                "let the CAM program write a uniform one, PL alike in each of its blocks",
            )
        inner = np.concatenate([[0.0], np.cumsum(steps)])
        # degree + 1 equal knots at both ends: the curve begins and ends at the first and last point
        knots = np.concatenate([np.zeros(degree), inner, np.full(degree, inner[-1])])
        curve = Curve(poles, weights, knots, degree + 1)
        spans = curve.spans(self.scene.tolerance, poles.shape[1])
        return self._lines(held, dict(zip(rows[degree - 1 :], spans, strict=True)))

    def _polygon(self, held: list[tuple[Line, Block]]) -> tuple[list[int], np.ndarray]:
        """The number of each point's line, and the poles (K, 3) in mm, the first where the axes
        stand. Raises Unsure."""
        if any(self._strange(block, not k) for k, (_, block) in enumerate(held)):
            raise Unsure(
                "its blocks hold more than control points, PL and PW",
                "let none but its first block hold F, S, M, G90 or G91, and no other word",
            )
        motions, lines = self._motions([line for line, _ in held])
        scene = self.scene
        if scene.code("feed mode") == 930 or scene.diameter_in_g90 or not self._followed(motions):
            raise Unsure(
                "it begins at an unknown place, or other axes move too, or G93 or DIAM90 is on",
                "write it under G94, and move X Y Z alone to an absolute position before",
            )
        used = [k for k, x in enumerate(self.tracker.setup.axes) if x in AXES]
        ticks = np.column_stack([motions.start[used, :1], motions.target[used]])
        if (np.diff(ticks, axis=1) == 0).all(axis=0).any():
            raise Unsure("a control point stands twice, or where the axes are", "write it once")
        return lines, ticks.T / TICKS_PER_MM

    def _motions(self, lines: list[Line]) -> tuple[Motions, list[int]]:
        """What the blocks of a spline are to the filter, and the number of each one's line. Raises
        Unsure."""
        text = b"".join(line.text + b"\n" for line in lines)
        setup, state = self.tracker.setup, self.tracker.state
        words = lex(text, self.scene.dialect.grammar, setup.block_delete)
        if words.fault or state.origin is None:
            raise UNREAD
        try:
            motions = self.tracker.interpreter.run(words, state)[0]
        except BlockFault:
            raise UNREAD from None
        return motions, words.line[motions.block].tolist()

    def _strange(self, block: Block, first: bool) -> bool:
        """Whether more stands in a block than a control point, and in the first one what switches
        something."""
        scene, axes = self.scene, self.tracker.setup.axes
        if not block.plain or block.skip:
            return True
        groups = QUIET if first else QUIET[:1]
        takes = {*axes, *WORDS, *("NGFSM" if first else "NG")}
        return any(scene.group_of(c) not in groups for c in block.codes) or any(
            w.value is not None and w.letter not in takes for w in block.words
        )

    def _followed(self, motions: Motions) -> bool:
        """Whether every motion is a control point that the compensation would follow."""
        other = [k for k, x in enumerate(self.tracker.setup.axes) if x not in AXES]
        return bool(
            len(motions.code)
            and (motions.code == SPLINE).all()
            and (motions.reason == 0).all()
            and (motions.space == 0).all()
            and motions.start_known[:, 0].all()
            and motions.target_known.all()
            and (motions.start[other] == motions.target[other]).all()
        )

    def _lines(self, held: list[tuple[Line, Block]], spans: dict[int, np.ndarray]) -> list[Line]:
        """Each line without its control point, and at that of a span's last one the straight lines
        of the span."""
        scene, out = self.scene, []
        for row, (line, block) in enumerate(held):
            scene.block = block
            scene.note(block)
            moves = Moves(scene, own_words(block, (*AXES, *WORDS), {self.number}))
            for point in spans.get(row, NO_POINTS):
                moves.move("G1", self._words(point))
            texts = [text for text in moves.finish() if text.strip() or not line.text.strip()]
            out += [line._replace(text=text) for text in texts]
        return out

    def _words(self, point: np.ndarray) -> dict[str, float]:
        """The coordinates of a point (K,), mm, as the program writes them."""
        scene, state, axes = self.scene, self.tracker.state, self.tracker.setup.axes
        assert state.origin is not None
        unit = TICKS_PER_INCH if scene.inch else TICKS_PER_MM
        names = [x for x in axes if x in AXES]
        zeros = [state.origin[axes.index(x)] for x in names]
        return {
            x: float((value * TICKS_PER_MM - zero) / unit * scene.double(x))
            for x, value, zero in zip(names, point, zeros, strict=True)
        }


def intervals(written: list[float | None], degree: int) -> np.ndarray | None:
    """(M,) the intervals between the knots that the values of PL of n blocks say, n + 1 - degree of
    them, as shares of their sum; None: they leave it open."""
    lengths = np.array([np.nan if x is None else x for x in written])
    #   six blocks, degree 3: four intervals, and six values of PL. Which four they are is not said:
    #   PL    1   2   3   4   5   6
    #   runs  |-----------|
    #             |-----------|
    #                 |-----------|     as many as the degree; the spline is followed where all of
    #                                   them that can be one (_jumps) say the same intervals
    count = len(lengths) + 1 - degree
    if count < 1:
        return None
    runs = np.array([lengths[k : k + count] for k in range(degree)])
    if not (lengths >= 0).all():
        return None
    runs = np.array([run / run.sum() for run in runs if not _jumps(run, degree)])
    if not len(runs) or (runs[0] == 0).any() or np.ptp(runs, axis=0).max() > ALIKE:
        return None
    found: np.ndarray = runs[0]
    return found


def _jumps(run: np.ndarray, degree: int) -> bool:
    """Whether a curve with these intervals (M,) would leave an end by a jump, or jump between."""
    if run[0] == 0 or run[-1] == 0:
        return True
    # n intervals of 0 in a row are n + 1 equal knots: `degree` of these make a corner, one more a
    # jump
    rows = "".join("0" if x == 0 else "1" for x in run).split("1")
    return max(map(len, rows)) >= degree


def _degree(blocks: list[Block]) -> int:
    """What SD says. Raises Unsure."""
    found = {value for block in blocks if (value := block.get("SD")) is not None} or {DEGREE}
    if len(found) > 1 or not found <= set(DEGREES):
        raise Unsure("its degree SD is not 2 or 3", "write SD=2 or SD=3 once")
    return int(found.pop())


def _weights(points: list[Block]) -> np.ndarray:
    """(K,) of all points, the first one's is 1. Raises Unsure where not all blocks say theirs."""
    found = [value for block in points if (value := block.get("PW")) is not None]
    if not found:
        return np.ones(len(points) + 1)
    if len(found) < len(points) or not all(0 < value <= HEAVIEST for value in found):
        raise Unsure(
            "PW stands in some of its blocks alone, or is not above 0 up to 3",
            "write PW in each of its blocks, or in none",
        )
    return np.array([1.0, *found])
