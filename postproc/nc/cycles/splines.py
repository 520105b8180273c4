"""LinuxCNC's splines in the XY plane, G5 (cubic), G5.1 (quadratic) and G5.2 to G5.3 (NURBS), as
straight lines.

convert_spline and convert_nurbs of its interpreter (src/emc/rs274ngc/interp_convert.cc), and
measured on 2.9: a control point of G5.2 counts from where the spline began in G91, L below 4 is 3,
I J P Q are not halved in G7, and none holds for the next block but G5.2. The control itself cuts
the curve into arcs through points of it (emccanon.cc, NURBS_FEED), so lines within the tolerance of
the curve are as near to what it does as these. grblHAL's G5 and G5.1 are the same curves
(motion_control.c, mc_cubic_b_spline; gcode.c makes a cubic one of G5.1).
"""

from __future__ import annotations

import numpy as np

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.curve import Curve, bezier, uniform
from postproc.nc.cycles.cycle import UNDEFINED, Cycle, Outcome
from postproc.nc.cycles.moves import Moves, own_words
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form

CUBIC, QUADRATIC, NURBS, NURBS_END = 50, 51, 52, 53
PLACE = {"X": "end", "Y": "end"}
NEAR = 1e-9
LEAST_ORDER, MOST_ORDER = 3, 30
FORMS = {
    CUBIC: Form(
        "a cubic spline",
        {
            **PLACE,
            "I": "first pole, from the start",
            "J": "first pole, from the start",
            "P": "second pole, from the end",
            "Q": "second pole, from the end",
        },
    ),
    QUADRATIC: Form(
        "a quadratic spline", {**PLACE, "I": "pole, from the start", "J": "pole, from the start"}
    ),
    NURBS: Form("a NURBS", {"X": "pole", "Y": "pole", "P": "weight of the pole", "L": "order"}),
    NURBS_END: Form("the end of a NURBS"),
}


class Splines(Cycle):
    """`poles`: of the NURBS that was begun, x (radius), y and weight."""

    def __init__(self, nurbs: bool = True):
        self.codes = (CUBIC, QUADRATIC, *((NURBS, NURBS_END) if nurbs else ()))
        self.poles: list[tuple[float, float, float]] = []
        self.order = LEAST_ORDER
        # I J of a G5 that does not name them: -P -Q of the last one
        self.last: tuple[float, float] = (0.0, 0.0)
        self.scene: Scene | None = None

    @property
    def modal(self) -> bool:
        return bool(self.poles)

    def forms(self, code: int) -> tuple[Form, ...]:
        """The words of a spline."""
        return (FORMS[code],)

    def wants(self, scene: Scene, block: Block) -> bool:
        """Between G5.2 and G5.3 blocks of words alone are further control points."""
        return any(block.word(x) for x in "XYPL")

    def end(self) -> None:
        """Another motion code behind G5.2: LinuxCNC drops the control points without a word. Raises
        ProgramError."""
        if self.poles and self.scene is not None:
            raise self.scene.fault(
                "a motion code between G5.2 and G5.3", "end the NURBS by G5.3 before"
            )

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        """The lines of a spline, or none before it is complete. Raises ProgramError."""
        self.scene = scene
        name = f"G{code / 10:g}"
        self._check(scene, name)
        m = Moves(scene, own_words(block, "".join(FORMS[code].takes), {code}))
        if code == NURBS:
            self._pole(scene, block)
            return Outcome(m.finish())
        if self.poles and code != NURBS_END:
            raise scene.fault(f"{name} between G5.2 and G5.3", "end the NURBS by G5.3 before")
        curve = self._nurbs(scene) if code == NURBS_END else self._bezier(scene, block, code)
        lines_along(m, curve, ("X", "Y"))
        return Outcome(m.finish(), then=UNDEFINED)

    @staticmethod
    def _check(scene: Scene, name: str) -> None:
        if scene.code("plane") != 170:
            raise scene.fault(f"{name} outside the XY plane", "write G17 before")
        if scene.compensated:
            raise scene.fault(f"{name} with cutter radius compensation on", "end it before: G40")
        if scene.code("feed mode") == 930:
            raise scene.fault(f"{name} with inverse time feed (G93)", "write G94 before")

    # -- G5, G5.1 ----------------------------------------------------------------------------------

    def _bezier(self, scene: Scene, block: Block, code: int) -> Curve:
        name = f"G{code / 10:g}"
        if block.get("X") is None and block.get("Y") is None:
            raise scene.fault(f"{name} without X and Y", "name where the spline ends")
        (x, y), (ex, ey) = _start(scene), _place(scene, block)
        i, j, p, q = (block.get(letter) for letter in "IJPQ")
        if code == QUADRATIC:
            if i is None or j is None:
                raise scene.fault("G5.1 without I and J", "both say where its pole lies")
            return bezier((x, y), (x + i, y + j), (ex, ey))
        if (i is None) != (j is None) or p is None or q is None:
            raise scene.fault("G5 without its poles", "write I and J, or neither, and P and Q")
        if i is None or j is None:
            # So the curve goes on along the tangent of the one before.
            i, j = self.last
        self.last = -p, -q
        return bezier((x, y), (x + i, y + j), (ex + p, ey + q), (ex, ey))

    # -- G5.2, G5.3 --------------------------------------------------------------------------------

    def _pole(self, scene: Scene, block: Block) -> None:
        """A further control point; the start is the first one."""
        self._check_pole(scene, block)
        weight, order = block.get("P"), block.get("L")
        placed = block.get("X") is not None
        if not self.poles:
            self.order = LEAST_ORDER
            # The start is a pole too. P without X and Y in the first block is its weight.
            self.poles = [(*_start(scene), 1.0 if placed or weight is None else weight)]
        # 2.9 takes L below 4 for 3 (docstring above), so 3 or less changes nothing.
        if order is not None and order > LEAST_ORDER:
            self.order = int(order)
        # A first block with P alone has set the weight of the start, and adds no pole.
        if placed and weight is not None:
            self.poles.append((*_place(scene, block), weight))

    def _check_pole(self, scene: Scene, block: Block) -> None:
        """Raises ProgramError where LinuxCNC refuses a control point."""
        weight, order = block.get("P"), block.get("L")
        named = [block.get(x) is not None for x in "XY"]
        placed = any(named)
        if placed != all(named):
            raise scene.fault("a control point with one of X and Y", "LinuxCNC wants both")
        if not placed and (self.poles or not weight):
            raise scene.fault(
                "a block of G5.2 without a control point", "only the first one may name P alone"
            )
        if placed and (weight or 0.0) <= 0:
            raise scene.fault(
                "a control point without a weight P above 0", "LinuxCNC takes a missing one for 0"
            )
        if weight is not None and weight <= 0:
            raise scene.fault(f"a weight of {weight:g}", "weights are above 0")
        if order is not None and (order != int(order) or not 1 <= order <= MOST_ORDER):
            raise scene.fault(
                f"L{order:g} is no order of a NURBS",
                "it is a whole number: 3 (quadratic), 4 (cubic)",
            )

    def _nurbs(self, scene: Scene) -> Curve:
        poles, self.poles = self.poles, []
        if not poles:
            raise scene.fault("G5.3 without G5.2", "G5.2 and its control points begin a NURBS")
        if len(poles) < self.order:
            raise scene.fault(
                f"a NURBS of order {self.order} with {len(poles)} control points",
                "it needs as many as its order L",
            )
        # Poles in G90 are places: a shift between them would tear the curve apart.
        if any(abs(a - b) > NEAR for a, b in zip(_start(scene), poles[0], strict=False)):
            raise scene.fault(
                "the coordinates or the axes moved between G5.2 and G5.3", "move them before G5.2"
            )
        places = np.array(poles)
        return uniform(places[:, :2], places[:, 2], self.order)


def lines_along(m: Moves, curve: Curve, axes: tuple[str, ...]) -> None:
    """Straight lines along a curve whose coordinates are those of `axes` (X as a radius), within
    the scene's tolerance."""
    scene = m.scene
    # The tolerance is one of the slides: X as a radius while the curve is cut, a diameter when
    # written.
    factor = np.array([scene.double(x) if x == "X" else 1.0 for x in axes])
    for point in curve.points(scene.chord, len(axes)) * factor:
        m.move("G1", dict(zip(axes, map(float, point), strict=True)))


def _start(scene: Scene) -> tuple[float, float]:
    return scene.at("X") / scene.double("X"), scene.at("Y")


def _place(scene: Scene, block: Block) -> tuple[float, float]:
    """The place that X and Y name."""
    start, half = _start(scene), scene.double("X")
    place = []
    for letter, here, by in zip("XY", start, (half, 1.0), strict=True):
        value = block.get(letter)
        place.append(here if value is None else (here if scene.incremental else 0.0) + value / by)
    return place[0], place[1]
