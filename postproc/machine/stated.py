"""What a machine's folder states: axes, chain, measured errors, effects; and what follows from them
whatever the place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from functools import cached_property
from pathlib import Path
from types import ModuleType

import numpy as np

from postproc.machine import rotary
from postproc.machine.axis import Axis, Driver, Expansion
from postproc.machine.chain import LINEAR, ROTARY, XYZ, Arms, Chain, leans
from postproc.machine.chain import arms as chain_arms
from postproc.machine.tables import AxisTable, GridTable
from postproc.machine.tool_point import ToolPoint
from postproc.records import record


@record
class EffectTerm:
    """One accepted effect with its parameters. tables, grids: the errors that it adds where the
    slides stand, none for an effect that a place alone does not decide. spread: for each parameter
    whose U (95 %, k = 2) is stated a term of the parameter's name, with U as its only parameter and
    by how much U changes the tables. measured mm: from where to where readings told it; its tables
    stay beyond what they are at the ends; None where not stated."""

    name: str
    axis: str
    parameters: dict[str, float]
    module: ModuleType | None
    tables: tuple[AxisTable, ...] = ()
    grids: tuple[GridTable, ...] = ()
    spread: tuple[EffectTerm, ...] = ()
    measured: tuple[float, float] | None = None


@record
class ControlTable:
    """A table with which the control corrects by itself. file, settings: where it stands; measured:
    whether the map was measured with it; active: whether it is on at work; axis: the one it is for,
    where the file does not say; more: what its reader must be told."""

    control: str
    file: Path | None
    settings: Path | None
    measured: bool
    active: bool
    axis: str
    more: dict[str, str]


@record
class Limits:
    """max_correction: mm; max_slope: mm/mm; outside: "error" or "clamp"; hysteresis: mm that the
    wanted place of a slide may turn back before its lost motion is taken up."""

    max_correction: float = 0.5
    max_slope: float = 0.005
    outside: str = "error"
    hysteresis: float = 0.001


@record
class Stated:
    """One machine as its folder states it. square: axis to (3,) rad; square_u: name ("B0X") to its
    U (95 %, k = 2), rad; square_stated: the names that the folder states, zero or not; tool (3,)
    mm; offsets: name to axis to mm; home: mm, slide positions after homing, of the axes for which
    they are stated; signs: "verified" where a measurement after compensation has shown them,
    "unverified" where it is said that none has, "" where nothing is said; tool_stated: whether the
    folder states the tool's point; tool_point: how the control follows it; growth: what moves it
    from moment to moment (growth.py), empty where its temperatures are not followed."""

    name: str
    title: str
    control: str
    chain: Chain
    axes: dict[str, Axis]
    diameter: tuple[str, ...] = ()
    square: dict[str, np.ndarray] = field(default_factory=dict)
    tool: np.ndarray = field(default_factory=lambda: np.zeros(3))
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)
    limits: Limits = Limits()
    effects: tuple[EffectTerm, ...] = ()
    control_tables: tuple[ControlTable, ...] = ()
    source: str = ""
    digest: str = ""
    reversal: str = "step"
    square_u: dict[str, float] = field(default_factory=dict)
    square_stated: tuple[str, ...] = ()
    signs: str = ""
    tool_stated: bool = False
    tool_point: ToolPoint = field(default_factory=ToolPoint)
    home: dict[str, float] = field(default_factory=dict)
    growth: tuple[Driver, ...] = ()

    @cached_property
    def letters(self) -> tuple[str, ...]:
        """Axis letters in the order of the columns."""
        return tuple(self.axes)

    def at(self, places: Mapping[str, np.ndarray | float], count: int) -> np.ndarray:
        """(A, N) of axis to its places, or to its one; 0 of an axis that is not named, and of what
        is no axis of this machine nothing."""
        rows = np.zeros((len(self.letters), count))
        for x, place in places.items():
            if x in self.letters:
                rows[self.letters.index(x)] = place
        return rows

    def xyz(self, rows: np.ndarray) -> np.ndarray:
        """(3, ...) along X Y Z of (A, ...); 0 along a direction that this machine has no axis
        for."""
        none = np.zeros(rows.shape[1:])
        return np.stack([rows[self.letters.index(x)] if x in self.letters else none for x in XYZ])

    @cached_property
    def tables(self) -> dict[str, AxisTable]:
        """Axis to its measured table, of those that have one; effects' are in `added`."""
        return {x: axis.table for x, axis in self.axes.items() if axis.table is not None}

    @cached_property
    def corrected(self) -> tuple[int, ...]:
        """Rows of the axes that a correction can move: the slides X Y Z of the chain."""
        return tuple(i for i, x in enumerate(self.letters) if x in self.chain.axes and x in XYZ)

    @cached_property
    def chained(self) -> tuple[int, ...]:
        """Rows of the axes on whose positions the deviation depends: all that the chain names."""
        return tuple(i for i, x in enumerate(self.letters) if x in self.chain.axes)

    @cached_property
    def turning(self) -> tuple[int, ...]:
        """Rows of the axes whose positions are angles: the rotary ones of the chain."""
        return tuple(self.letters.index(x) for x in self.chain.rotary)

    @cached_property
    def grids(self) -> tuple[GridTable, ...]:
        """What depends on a second axis too: measured, then of effects."""
        own = tuple(grid for axis in self.axes.values() for grid in axis.grids)
        return own + tuple(grid for term in self.effects for grid in term.grids)

    @cached_property
    def grids_of(self) -> dict[str, list[GridTable]]:
        """Axis to what depends on a second one too, measured or an effect's."""
        return {x: [grid for grid in self.grids if grid.letter == x] for x in self.axes}

    @cached_property
    def knots(self) -> dict[str, list[np.ndarray]]:
        """Axis to the nodes at which a deviation bends."""
        found: dict[str, list[np.ndarray]] = {}
        for x, table in self.every_table:
            found.setdefault(x, []).append(table.nodes)
        for grid in self.grids:
            found.setdefault(grid.letter, []).append(grid.nodes)
            found.setdefault(grid.other, []).append(grid.others)
        return found

    @cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Axis to the range, mm or degrees, that all its tables cover; none without tables."""
        # Of measured tables alone: those of effects reach over all of the travel. Where several
        # reach unlike far, only what all of them cover is known.
        covered = {x: [table.nodes] for x, table in self.tables.items()}
        for grid in (grid for axis in self.axes.values() for grid in axis.grids):
            covered.setdefault(grid.letter, []).append(grid.nodes)
            covered.setdefault(grid.other, []).append(grid.others)
        return {
            x: (float(max(n[0] for n in c)), float(min(n[-1] for n in c)))
            for x, c in covered.items()
        }

    @cached_property
    def reached(self) -> dict[str, tuple[float, float]]:
        """Axis to where a nominal program can take it: its travel, within tables that end it; the
        first above the second where they leave nothing, and a program that names it is
        refused."""
        found = {}
        for x, axis in self.axes.items():
            low, high = axis.travel
            # Only of linear axes: a table of a full turn repeats, and one of less is held beyond
            # its ends.
            if self.limits.outside == "error" and x in self.ranges and x in LINEAR:
                first, last = self.ranges[x]
                low, high = max(low, first), min(high, last)
            found[x] = low, high
        return found

    @cached_property
    def expansions(self) -> dict[str, Expansion]:
        """Axis to its growth, of those that grow at the stated temperatures."""
        return {
            x: a.expansion
            for x, a in self.axes.items()
            if a.expansion is not None and a.expansion.rate
        }

    @cached_property
    def locations(self) -> dict[str, np.ndarray]:
        """Axis to (6,) mm and rad: how the line of a rotary axis lies, and how a linear one
        leans."""
        found = {x: axis.location.copy() for x, axis in self.axes.items() if axis.location.any()}
        for x, lean in self.square.items():
            # Squareness is the rotation part of a location: how a rotary axis' line leans is stated
            # under [squareness] as well (A0C), where it lies beside its place under [location]
            # (X0C).
            found.setdefault(x, np.zeros(6))[3:] += lean
        return found

    @cached_property
    def angles(self) -> dict[str, float]:
        """rad: each squareness that is not zero, by its name: C0Y."""
        return {
            f"{ROTARY[i]}0{x}": float(value)
            for x, lean in self.square.items()
            for i, value in enumerate(lean)
            if value
        }

    @cached_property
    def is_zero(self) -> bool:
        """Whether no correction can ever be needed."""
        exact = all(t.is_zero for t in self.tables.values()) and not any(
            grid.rows for grid in self.grids
        )
        # Angles alone, without an arm or another error, still move the tip: they are in the tables'
        # rows, so `exact` has looked at them.
        still = exact and not self.locations and not self.expansions and not self.growth
        return still and not any(e.tables for e in self.effects)

    @cached_property
    def two_way(self) -> np.ndarray:
        """(A,) bool: axes whose direction of approach matters."""
        # a grid counts for the axis whose approach it goes by, not for the one it depends on too
        by_effect = {table.letter for e in self.effects for table in e.tables if table.two_way}
        by_effect |= {grid.letter for grid in self.grids if grid.two_way}
        return np.array(
            [x in by_effect or (x in self.tables and self.tables[x].two_way) for x in self.letters]
        )

    @cached_property
    def pretravel(self) -> dict[str, float]:
        """Axis to mm of its own travel behind a turn over which its largest reversal builds up
        beyond its own size, where an effect says so."""
        # Several things may reverse on one axis: measured tables (at once, way 0), backlash (at
        # once), windup (over its way). One way stands for all of them: that of the largest.
        sizes = {x: [(2 * float(np.abs(t.half[:3]).max()), 0.0)] for x, t in self.tables.items()}
        for grid in self.grids:
            sizes.setdefault(grid.letter, []).append((2 * float(np.abs(grid.half[:3]).max()), 0.0))
        for term in self.effects:
            way = getattr(term.module, "ramp_mm", lambda **named: 0.0)(**term.parameters)
            for t in term.tables:
                size = 2 * float(np.abs(t.half[:3]).max())
                sizes.setdefault(t.letter, []).append((size, way))
        largest = {x: max(of)[1] for x, of in sizes.items()}
        return {x: way for x, way in largest.items() if way > 0}

    @cached_property
    def turns(self) -> bool:
        """Whether any axis has a rotation, so that the tool's length matters."""
        rows = [row for axis in self.axes.values() for t in axis.tables for row in t.rows]
        rows += [row for e in self.effects for t in (*e.tables, *e.grids) for row in t.rows]
        # rows 3 to 5 are rotations: what they do to the tip is as long as the arm, the tool in it
        return bool(self.chain.rotary) or any(row >= 3 for row in rows)

    @cached_property
    def measured(self) -> dict[str, np.ndarray]:
        """Axis to (3,) mm: where the axes of its arm stood while it was measured; 0 for those that
        are none of it."""
        return {x: self.chain.counted(x, axis.measured_at) for x, axis in self.axes.items()}

    @cached_property
    def arms(self) -> Arms:
        """Axis to the part of its arm that stays and the slide that adds to it, per direction."""
        return chain_arms(
            self.chain, self.tool, self.measured, {x: axis.optic for x, axis in self.axes.items()}
        )

    def arm_at(self, letter: str, position: Mapping[str, np.ndarray]) -> np.ndarray:
        """(3, N) mm: on what the rotations of an axis act, at positions of the slides, axis to (N,)
        mm; those that are not told stand at zero. Rotary axes are not followed."""
        n = len(next(iter(position.values())))
        return np.stack(
            [
                np.full(n, stays) + sum(position[x] for x in slides if x in position)
                for stays, slides in self.arms[letter]
            ]
        )

    def on_own_arm(self, letter: str) -> bool:
        """Whether an axis' own position is part of its arm."""
        return any(letter in slides for _, slides in self.arms[letter])

    @cached_property
    def leaning(self) -> dict[str, list[tuple[int, np.ndarray]]]:
        """Axis to direction (0 to 2) and rad, mm it drifts there per mm of its own way
        (chain.leans)."""
        return {x: leans(x, lean) for x, lean in self.square.items()}

    @cached_property
    def geometry(self) -> rotary.Geometry:
        """What of the machine does not move, as rotary chains need it."""
        a = self.axes
        return rotary.Geometry(
            self.chain, self.locations, self.tool, {x: a[x].centre for x in a}, self.measured,
            {x: a[x].optic for x in a},
        )  # fmt: skip

    @cached_property
    def added(self) -> dict[str, list[AxisTable]]:
        """Axis to the tables that effects add."""
        found: dict[str, list[AxisTable]] = {}
        for term in self.effects:
            for table in term.tables:
                found.setdefault(table.letter, []).append(table)
        return found

    @cached_property
    def every_table(self) -> list[tuple[str, AxisTable]]:
        """Axis and table: measured ones that are not zero, and what effects add."""
        own = [(x, table) for x, table in self.tables.items() if not table.is_zero]
        return own + [(x, table) for x, tables in self.added.items() for table in tables]
