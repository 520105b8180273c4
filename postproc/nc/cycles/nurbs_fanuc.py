"""Fanuc's G06.2: a NURBS by its control points, their weights R and the knots K, as straight lines.

Fanuc Series 15i/150i-MA, Programming, "NURBS interpolation": P is the rank, 2 to 4, 4 where it is
left out; every block has a knot, as many blocks with a knot alone follow as the rank says; the
first and the last knots are as many times the same. The first control point is where the tool
stands, also where the first block names none; its knot is then the next one's. Mitsubishi's M700V
has the same words ("NURBS Interpolation"). Knots and weights without a point count least increments
on the one and units on the other: only their ratios matter, so one way or the other throughout is
understood, a mixture not.
"""

from __future__ import annotations

import numpy as np

from postproc.nc.cycles.block import Block, Word
from postproc.nc.cycles.curve import Curve
from postproc.nc.cycles.cycle import UNDEFINED, Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.splines import lines_along
from postproc.nc.cycles.words import Form

AXES = "XYZ"
RANKS, RANK = (2, 3, 4), 4
FORM = Form(
    "a NURBS", {**dict.fromkeys(AXES, "control point"), "P": "rank", "K": "knot", "R": "weight"}
)
PROGRAM = "let the CAM program write it again, or write lines and arcs"


class FanucNurbs(Cycle):
    """`knots`, `poles` and `weights` so far; `axes`: those that the control points name."""

    codes = (62,)
    form = FORM

    def __init__(self) -> None:
        self.scene: Scene | None = None
        self._clear()

    def _clear(self) -> None:
        self.knots: list[Word] = []
        self.poles: list[tuple[float, ...]] = []
        self.weights: list[Word | None] = []
        self.axes: tuple[str, ...] = ()
        self.rank, self.started = RANK, False

    @property
    def modal(self) -> bool:
        return self.started

    def wants(self, scene: Scene, block: Block) -> bool:
        """A block with a knot or a place goes on with the curve."""
        return any(block.word(x) for x in (*AXES, "K", "R", "P"))

    def end(self) -> None:
        """Another motion code came before the last knot. Raises ProgramError."""
        if self.started and self.scene is not None:
            raise self.scene.fault(
                f"the NURBS ends with {len(self.poles)} control points and {len(self.knots)} knots",
                f"it needs as many knots as control points and {self.rank} more",
            )

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The lines of the curve at its last knot, none before. Raises ProgramError."""
        self.scene = scene
        m = Moves(scene, own_words(block, "".join(FORM.takes), {code}))
        if not self.started:
            self._begin(scene, block)
        elif block.word("P"):
            raise scene.fault("P behind the first block of a NURBS", PROGRAM, block.word("P"))
        self._block(scene, block)
        #  G6.2 P4 X0. Y0. R1. K0.    A pole and a knot in each block, then P times a knot alone: n
        #  X1. Y2. R1. K0.            poles take n + P knots. The lines of the curve are written at
        #  ...                        the last one.
        #  K1.
        if len(self.knots) < len(self.poles) + self.rank:
            return Outcome(m.finish())
        curve, axes = self._curve(scene), self.axes
        self._clear()
        lines_along(m, curve, axes)
        return Outcome(m.finish(), then=UNDEFINED)

    def _begin(self, scene: Scene, block: Block) -> None:
        if scene.incremental:
            raise scene.fault("G6.2 in G91", "control points are places here: write G90")
        if scene.code("cutter") in (410, 420):
            raise scene.fault("G6.2 with cutter radius compensation on", "end it before: G40")
        if scene.code("feed mode") == 930:
            raise scene.fault("G6.2 with inverse time feed (G93)", "write G94 before")
        rank = block.get("P")
        if rank is not None and rank not in RANKS:
            raise scene.fault(f"P{rank:g} is no rank of a NURBS", "P2, P3 or P4", block.word("P"))
        self._clear()
        self.started, self.rank = True, RANK if rank is None else int(rank)

    # Whole: a list of refusals between the steps that they guard.
    def _block(self, scene: Scene, block: Block) -> None:
        """A control point, or a knot alone."""
        knot, weight = block.word("K"), block.word("R")
        axes = tuple(x for x in AXES if block.word(x))
        # A knot alone has come, so the poles are over.
        bare = len(self.knots) > len(self.poles)
        if not axes and not self.poles and not self.axes:
            # where the tool stands; the next block says which axes take part
            self.weights.append(weight)
            if knot is not None:
                self.knots.append(knot)
            return
        if knot is None:
            raise scene.fault("a block of a NURBS without a knot K", PROGRAM)
        if not self.axes and axes:
            self._first(scene, axes, knot)
        if axes and (bare or axes != self.axes):
            raise scene.fault(
                "a control point that names other axes, or stands behind the last one", PROGRAM
            )
        self.knots.append(knot)
        if axes:
            self.poles.append(tuple(self._value(scene, block, x) for x in axes))
            self.weights.append(weight)
            if len(self.poles) == 1:
                self._starts(scene)
        elif weight is not None:
            raise scene.fault("a weight without a control point", PROGRAM, weight)

    def _first(self, scene: Scene, axes: tuple[str, ...], knot: Word) -> None:
        """The first block that names axes; behind one that named none it is the second control
        point."""
        self.axes = axes
        if self.weights:
            # X as a radius, so that the tolerance is one of the slides.
            self.poles.append(tuple(scene.at(x) / scene.double(x) for x in axes))
            if not self.knots:
                self.knots.append(knot)

    def _starts(self, scene: Scene) -> None:
        for axis, value in zip(self.axes, self.poles[0], strict=True):
            if scene.differs(axis, value * scene.double(axis)):
                raise scene.fault(
                    f"the first control point has {axis}{value:g}, and the tool stands at"
                    f" {axis}{scene.at(axis):g}",
                    "the curve begins where the tool stands: write it there",
                )

    def _value(self, scene: Scene, block: Block, axis: str) -> float:
        word = block.word(axis)
        assert word is not None
        return scene.length(word, axis) / scene.double(axis)

    def _curve(self, scene: Scene) -> Curve:
        knots = self._ratios(scene, self.knots, "knots K")
        given = [w for w in self.weights if w is not None]
        if given and len(given) < len(self.weights):
            raise scene.fault(
                "some control points have a weight R and others have none", "name R in each of them"
            )
        weights = self._ratios(scene, given, "weights R") if given else np.ones(len(self.poles))
        if (weights <= 0).any():
            raise scene.fault("a weight R that is not above 0", PROGRAM)
        self._check_knots(scene, knots)
        return Curve(np.array(self.poles), weights, knots, self.rank)

    def _check_knots(self, scene: Scene, knots: np.ndarray) -> None:
        """Raises ProgramError for knots that no curve of this rank has."""
        k = self.rank
        steps = np.diff(knots)
        # Of a knot as often as the rank the curve would fall apart into two.
        inner = knots[k : len(self.poles)]
        clamped = (knots[:k] == knots[0]).all() and (knots[-k:] == knots[-1]).all()
        if len(self.poles) < k or (steps < 0).any() or not clamped or knots[0] == knots[-1]:
            raise scene.fault(
                f"the knots of the NURBS do not go up from {k} equal ones to {k} equal ones",
                PROGRAM,
            )
        if (
            any((inner == value).sum() >= k for value in inner)
            or (inner == knots[0]).any()
            or (inner == knots[-1]).any()
        ):
            raise scene.fault(
                f"a knot of the NURBS stands there more often than its rank, {k}, allows", PROGRAM
            )

    @staticmethod
    def _ratios(scene: Scene, words: list[Word], what: str) -> np.ndarray:
        """Numbers of which only the ratios matter."""
        pointed = {"." in w.raw for w in words if w.value}
        if len(pointed) > 1:
            raise scene.fault(
                f"some {what} have a decimal point and others have none", "write all of them alike"
            )
        return np.array([w.value or 0.0 for w in words])
