"""The options, what follows from them on one machine, and what one batch hands to the next."""

from __future__ import annotations

import numpy as np

from postproc.compensate import approach
from postproc.machine import tip
from postproc.machine.chain import LINEAR, XYZ
from postproc.machine.model import Machine
from postproc.records import columns, record, replace
from postproc.spaces import Space
from postproc.units import TICKS_PER_MM

# mm: half of what the closest positional tolerance in common use, a zone of 0.02 mm diameter
# (ISO 5458), leaves to one side.
HOLE_TOLERANCE = 0.005
# of the tolerance, which whole steps of heat may leave, and heat within one spell (heat/follow.py)
HEAT_SHARE = 1 / 4
EDGE = 1e-6  # mm: how far outside a table or a travel counts as on its end
BESIDE = np.array([-EDGE, EDGE]).reshape(2, 1, 1)


@record
class Options:
    """tolerance: mm that the actual path may miss the nominal one (None: one least increment, 0.5
    um at least);
    outside: "error" or "clamp"; reversal: a mode of approach.py; ramp: mm of travel; cut_rapids:
    cut G0 too;
    holes_written_out: whether --expand writes a canned cycle of this control out;
    arc_mismatch: mm that radii of start and end may come to differ by; hole_tolerance: mm that a
    hole's axis may bend while its cycle holds its place (None: HOLE_TOLERANCE; the tolerance at
    least); hysteresis: mm that the wanted place of a slide may turn back before its lost motion is
    taken up (None: as the machine says); orientation: whether rotary words are corrected for the
    tool's lean; heat_step (D,): unit of the whole steps in which heat is told, of machines that
    grow; passes_unknown: whether feeds whose place can not be known are left as they are, and
    counted, rather than refused."""

    tolerance: float | None = None
    outside: str | None = None
    reversal: str | None = None
    ramp: float | None = None
    cut_rapids: bool = False
    arc_mismatch: float = 0.005
    holes_written_out: bool = True
    hole_tolerance: float | None = None
    hysteresis: float | None = None
    orientation: bool = False
    passes_unknown: bool = False
    heat_step: tuple[float, ...] = ()


@columns
class Course:
    """The K last control points of a spline. wanted, written (A, K) mm; side (A, K) of the leg
    before each; spaced (K,): whether its block says its interval of knots."""

    wanted: np.ndarray
    written: np.ndarray
    side: np.ndarray
    spaced: np.ndarray


@columns
class Carry:
    """sides: of the lost motion; issued (A,): ticks last commanded; way (A,): sign of the last
    command's motion; sure: whether `issued` is where the machine stands and is what the nominal
    position needs; heading: unit tangent, in the plane of cutter radius compensation, in which the
    last motion inside it ended; level (A,): ticks commanded before the holes that ended at R, to
    which their cycle goes back; largest: mm, the largest correction so far; frame: the space and
    the tool's length (A,) ticks in which `issued` counts; heat (D,): steps of the machine's growth
    for which it was; spline: of the one that goes on, None: none does; threading: whether the last
    motion was a thread."""

    sides: approach.Sides
    issued: np.ndarray
    way: np.ndarray
    level: np.ndarray
    sure: bool = False
    heading: tuple[float, float] = (0.0, 0.0)
    largest: float = 0.0
    frame: tuple[Space | None, tuple[int, ...]] = (None, ())
    heat: tuple[int, ...] = ()
    spline: Course | None = None
    threading: bool = False


class Settings:
    """A machine and the options, and how the tolerance is shared out. Of the tolerance T:

        |<------------------------- tolerance T ------------------------->|
        | kept: heat | beyond: rounding of several axes |      inner      |
                                                        | slack |  chord  |

    slack: what the approach to a wanted place may leave; chord: mm that each corrected axis may
    miss its straight way by; plane: the same in the plane of an arc; rows, fixed: the axes that are
    corrected, and those that are not."""

    # Whole: one budget: each share of the tolerance needs those taken before.
    def __init__(self, machine: Machine, options: Options = Options()):
        # what can be reached, and so every bound
        if options.outside and options.outside != machine.limits.outside:
            machine = replace(machine, limits=replace(machine.limits, outside=options.outside))
        self.machine, self.options = machine, options
        least = [axis.least_increment for axis in machine.axes.values()]
        rounding = np.array(
            [
                a.least_increment / (2 if x in machine.diameter else 1)
                for x, a in machine.axes.items()
            ]
        )
        self.tolerance = (
            options.tolerance if options.tolerance is not None else max(max(least), 0.0005)
        )
        asked = options.hole_tolerance if options.hole_tolerance is not None else HOLE_TOLERANCE
        self.hole_tolerance = max(asked, self.tolerance)
        self.straightness = self.hole_tolerance if options.hole_tolerance is None else asked
        # Where no table and no effect asks for it, there is no direction to follow.
        self.mode = (options.reversal or machine.reversal) if machine.two_way.any() else "mean"
        self.outside = options.outside or machine.limits.outside
        n = max(1, len(machine.corrected))
        # Rounding may take half a least increment in one axis beyond the tolerance; several axes
        # together take more.
        beyond = (
            max(0.0, float(np.linalg.norm(rounding[list(machine.corrected)] / 2)) - max(least) / 2)
            if machine.corrected
            else 0.0
        )
        # What heat does between two of its whole steps is paid for out of the tolerance too.
        kept = HEAT_SHARE * self.tolerance if options.heat_step else 0.0
        inner = max(self.tolerance - beyond, self.tolerance / 2) - kept
        self.slack = inner / 8
        self.chord = (inner - self.slack) / np.sqrt(n)
        self.plane = (inner - self.slack) * np.sqrt(2 / n)
        self.hold, self.inner = self.chord / 2, inner
        self.hysteresis = (
            machine.limits.hysteresis if options.hysteresis is None else options.hysteresis
        )
        self.rows = list(machine.corrected)
        self.at = np.array(self.rows, np.int64)
        # rows of the slides of the chain
        self.slides = [row for row in machine.chained if machine.letters[row] in LINEAR]
        self.fixed = [i for i in range(len(machine.axes)) if i not in self.rows]
        # (R, 1) mm, lowest and highest place of each corrected axis
        travel = np.array([machine.axes[machine.letters[i]].travel for i in self.rows])
        self.travel = travel.reshape(-1, 2).T[:, :, None] + BESIDE
        # (A, 1) mm, lowest and highest place of each axis that its tables cover
        all_of = (-np.inf, np.inf)
        covered = np.array([machine.ranges.get(x, all_of) for x in machine.letters])
        self.covered = covered.reshape(-1, 2).T[:, :, None] + BESIDE
        self._directions()

    def allowed(self, grid: np.ndarray) -> np.ndarray:
        """mm that may be left at most, where one least increment is `grid` mm: the tolerance and
        half an increment; where sides are followed, what each two-way axis may be held back by: the
        hysteresis at the ends of strokes and half of it along them. What an axis that turns back
        moves the others by comes on top (verify/turning.py)."""
        beyond = 0.0
        if self.follows:
            axes = int(self.machine.two_way[self.rows].sum())
            beyond = 1.5 * self.hysteresis * float(np.sqrt(axes))
        return self.tolerance + beyond + grid / 2 + 1e-9

    def _directions(self) -> None:
        """Whether sides are followed at all; (A,) ticks of hysteresis and of ramps, and mm/mm how
        steeply lost motion builds up along these at most; rows of axes that never turn back within
        a stroke but by a take-up."""
        m = self.machine
        # sides by the slides' own way, block by block (sides.of_slides)
        if isinstance(m, tip.TipMachine):
            self.mode = "step" if self.mode in ("step", "ramp") else "mean"
        self.follows = self.mode != "mean"
        self.two_way = np.flatnonzero(m.two_way)
        slides = np.array([x in XYZ for x in m.letters]) & m.two_way
        self.band = np.where(slides, 2 * round(self.hysteresis / 2 * TICKS_PER_MM), 0)
        ramps = {x: self.options.ramp or m.pretravel.get(x, 0.0) for x in m.letters}
        if self.mode == "ramp":
            ramps = {x: way or self._ramp() for x, way in ramps.items()}
        elif self.mode != "step":
            ramps = {}
        self.reach = np.array([round(ramps.get(x, 0.0) / 2 * TICKS_PER_MM) for x in m.letters])
        self.reach[~slides] = 0
        self.ramped = bool(np.any(self.reach))
        self.builds = np.zeros(len(self.reach))
        if self.ramped:
            way = np.where(self.reach > 0, 2 * self.reach / TICKS_PER_MM, np.inf)
            self.builds = (m.widest_play + m.lateral) / way
        self.overshoots = slides & (m.least_play < -self.chord)
        self.followed = (
            np.flatnonzero(slides & (self.reach == 0))
            if self.mode == "step"
            else np.zeros(0, np.int64)
        )
        if isinstance(m, tip.TipMachine):
            self.overshoots = np.zeros_like(slides)
            self.followed = self.followed[m.direct[self.followed]]

    def _ramp(self) -> float:
        """mm: ten times the largest reversal, half a millimetre at least."""
        largest = 0.0
        for _, table in self.machine.every_table:
            largest = max(largest, 2 * float(np.abs(table.half[:3]).max()))
        for grid in self.machine.grids:
            largest = max(largest, float(np.abs(grid.forward - grid.reverse)[:3].max()))
        return max(10 * largest, 0.5)
