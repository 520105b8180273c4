"""A machine: what its folder states, and the one deviation that all of it adds up to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property

import numpy as np

from postproc.machine import dependence, rotary
from postproc.machine.axis import Axis
from postproc.machine.bounds import Bounds
from postproc.machine.cells import Value
from postproc.machine.chain import (
    ROTARY,
    XYZ,
    Parts,
    Position,
    Share,
    along,
    shares,
    summed,
    tip_deviation,
)
from postproc.machine.stated import Stated
from postproc.machine.tables import ALONG, PORTION, AxisTable
from postproc.records import record

FEW = 2  # places that are looked at one by one, in numbers, which is faster than columns


def _together(n: int, rotary: bool = False) -> Iterable[slice | int]:
    """Which of N places are looked at together: portions of many; each of few by itself, but for
    chains with rotary axes, which are followed in columns alone."""
    if n <= FEW and not rotary:
        return range(n)
    return [slice(first, first + PORTION) for first in range(0, n, PORTION)]


def _told(columns: np.ndarray, at: slice | int) -> Iterable[Value]:
    """The rows of (A, N) at such places: columns of some, numbers of one."""
    return columns[:, at].tolist() if isinstance(at, int) else columns[:, at]


@record
class Machine(Stated):
    """One machine, as its folder states it."""

    @cached_property
    def bare(self) -> Machine:
        """The machine without its errors: no tables, squareness, heat or effects."""
        axes = {x: axis.bare for x, axis in self.axes.items()}
        return replace(self, axes=axes, square={}, effects=())

    @cached_property
    def depends(self) -> np.ndarray:
        """(A, A) bool: [i, j], whether the correction of axis i needs the position of axis j."""
        return dependence.closed(dependence.direct(self))

    @cached_property
    def lateral(self) -> float:
        """mm: by how much the sides of all axes together can move the others: straightness and
        angles measured both ways."""
        return self._of_sides(own=False)

    @cached_property
    def reversals(self) -> float:
        """mm: by how much the sides of all axes together can move the tip."""
        return self._of_sides(own=True)

    def _of_sides(self, own: bool) -> float:
        """mm that the sides of all axes together can do; own: along themselves as well."""
        tables = [(x, t.half) for x, t in self.every_table]
        tables += [(grid.letter, grid.half.reshape(6, -1)) for grid in self.grids]
        # A rotation of the slide counts with its longest arm (at_tip). What all axes can do is
        # added up, since they may all change sides in one block.
        total = 0.0
        for x, half in tables:
            size = 2 * np.abs(half).max(axis=1)
            if not own:  # `least_play` is about that
                size[3 + ROTARY.index(x) if x in ROTARY else along(x)] = 0.0
            total += self.bounds.at_tip(x, size)
        return total

    @property
    def least_play(self) -> np.ndarray:
        """(A,) mm: the smallest lost motion of each axis anywhere; below zero where forward lies
        beyond reverse."""
        least: np.ndarray = self._plays[0]
        return least

    @property
    def widest_play(self) -> np.ndarray:
        """(A,) mm: how far the sides of each axis lie apart at most, either way round."""
        widest: np.ndarray = np.abs(self._plays).max(axis=0)
        return widest

    @cached_property
    def _plays(self) -> np.ndarray:
        """(2, A) mm: the smallest and the largest lost motion of each axis, 0 among them."""
        plays = np.zeros((2, len(self.letters)))
        for letter in (x for x in XYZ if x in self.letters):
            own, grids = XYZ.index(letter), self.grids_of[letter]
            nodes = np.concatenate(self.knots.get(letter, [np.zeros(1)]))
            play = np.zeros((2, len(nodes)))
            for table in self._playing[letter]:
                play -= 2 * table.half_of(own, nodes)
            # Play is linear between nodes, by either axis of a grid too, so it is least at some of
            # them. Second axes stand where they like, each where its own grids take the most.
            for other in {grid.other for grid in grids}:
                same = [grid for grid in grids if grid.other == other]
                places = np.concatenate([grid.others for grid in same])
                by = np.zeros((len(nodes), len(places)))
                for grid in same:
                    by -= 2 * grid.half_of(own, nodes[:, None], places)
                play += by.min(axis=1), by.max(axis=1)
            row = self.letters.index(letter)
            plays[:, row] = play[0].min(initial=0.0), play[1].max(initial=0.0)
        return plays

    def lost_motion(self, position: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(R, N) mm: the play of the axes `rows` (R,) at commanded slide positions (A, N): the
        deviation of an axis along itself when it was approached in - less that in +. Angles and
        straightness measured both ways are not in it."""
        result = np.zeros((len(rows), position.shape[1]))
        for at in _together(position.shape[1]):
            q = dict(zip(self.letters, _told(position, at), strict=True))
            for k, row in enumerate(rows.tolist()):
                result[k, at] = self._play(self.letters[row], q)
        return result

    def _play(self, letter: str, q: Position) -> Value:
        """(N,) mm or one number: the play of an axis at these places."""
        total: Value = 0.0
        if letter not in XYZ:  # no slide makes up for it, so its own motion is wanted as it is
            return total
        own = XYZ.index(letter)
        # A table is mean + approach * half (postproc.machine.tables): that at -1 less that at +1 is
        # -2 half. A slide with lost motion stops short both ways, so half is below zero.
        for table in self._playing[letter]:
            total = total - 2 * table.half_of(own, q[letter])
        for grid in self.grids_of[letter]:
            total = total - 2 * grid.half_of(own, q[letter], q[grid.other])
        return total

    def carrying(self, letters: tuple[str, ...]) -> Machine:
        """The same machine with axes that are no slides, carried along: a printer's E."""
        more = {
            x: Axis(x, (-np.inf, np.inf), 1e-5, np.zeros(3)) for x in letters if x not in self.axes
        }
        return replace(self, axes={**self.axes, **more}) if more else self

    def with_tool(self, length: tuple[float, float, float]) -> Machine:
        """The same machine with a tool of this length, mm along X Y Z: the tip lies as much before
        the point that the slides carry."""
        # `tool` is the point that cuts, from the last carriage. A length counts from the tip to
        # where the tool is held (G43 H of a mill: towards +Z), so the tip lies that much on the
        # other side.
        return replace(self, tool=self.tool - np.array(length))

    def at_temperatures(self, celsius: dict[str, float]) -> Machine:
        """The same machine with other temperatures of its scales (by axis) and of the workpiece
        ("work")."""
        axes = dict(self.axes)
        for x, axis in self.axes.items():
            if axis.expansion is not None:
                e = axis.expansion
                warm = replace(
                    e, scale_at=celsius.get(x, e.scale_at), work_at=celsius.get("work", e.work_at)
                )
                axes[x] = replace(axis, expansion=warm)
        return replace(self, axes=axes)

    def deviation(
        self, position: np.ndarray, approach: np.ndarray, direction: int | None = None
    ) -> np.ndarray:
        """(A, N) mm: actual - commanded of each linear axis, at commanded slide positions (A, N)
        mm; whole at least along `direction`, 0 to 2 for X Y Z.

        approach (A, N): -1 to +1, in which direction each axis last moved; 0 is the mean. Axes that
        the chain does not name have none. A deviation along a direction that the machine has no
        axis for is left out.
        """
        result = np.zeros(position.shape)
        for at in _together(position.shape[1], self._rotary):
            if self._rotary:
                q, each = self._at(position[:, at], approach[:, at])
                parts = rotary.tip_deviation(self.geometry, each, q)
            else:
                q, each = self._at(_told(position, at), _told(approach, at), direction)
                parts = tip_deviation(self._shares[isinstance(at, int), direction], each, q)
            # `direction` leaves out components that can not act there (tables.ALONG); what the two
            # other directions hold then is a part of their sum only, and the caller does not look
            # at it.
            for row, own in self._ways:
                if parts[own] is not None:
                    result[row, at] = parts[own]
        return result

    @cached_property
    def _shares(self) -> dict[tuple[bool, int | None], list[Share]]:
        """What each axis adds to the deviation, whole and along X, Y and Z: in columns, and in
        numbers."""
        found = {}
        for direction in (None, 0, 1, 2):
            live = {x: self._there(x, direction) for x in self.letters}
            # In numbers and in columns there are the same terms in the same order, so a place has
            # the same bits whichever way it is looked at: output may not depend on how many places
            # came together.
            found[False, direction] = each = shares(self.arms, live, self.leaning)
            found[True, direction] = [share.in_numbers for share in each]
        return found

    def _there(self, letter: str, direction: int | None) -> set[int]:
        """The components of an axis that `_parts` gives, 0 to 5."""
        tables = {i for t in self._live[letter] for i in t.rows}
        # a table leaves out what can not act along `direction`; growth and grids are always whole
        if direction is not None:
            tables &= set(ALONG[direction])
        grown = {along(letter)} if letter in self.expansions else set()
        return tables | grown | {i for grid in self.grids_of[letter] for i in grid.rows}

    @cached_property
    def _rotary(self) -> bool:
        return bool(self.chain.rotary)

    @cached_property
    def _ways(self) -> list[tuple[int, int]]:
        """Rows of the corrected axes, and the direction, 0 to 2, of each."""
        return [(row, XYZ.index(self.letters[row])) for row in self.corrected]

    def carried(self, position: np.ndarray, approach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(3, N) mm by which the tip is off and (3, N) rad by which the tool leans, both in the
        frame of the workpiece, which turns with it. A chain with rotary axes."""
        q, each = self._at(position, approach)
        return rotary.carried(self.geometry, each, q)

    def _at(
        self, position: Iterable[Value], approach: Iterable[Value], direction: int | None = None
    ) -> tuple[Position, dict[str, Parts]]:
        """Axis to its position, and to its deviations there, or those that count along one."""
        q = dict(zip(self.letters, position, strict=True))
        s = dict(zip(self.letters, approach, strict=True))
        each = {}
        for x in self.chain.axes:
            if (part := self._parts(x, q, s, direction)) is not None:
                each[x] = part
        return q, each

    def _parts(self, letter: str, q: Position, s: Position, direction: int | None) -> Parts | None:
        """Six (N,) deviations of one axis: its table, what depends on a second axis, its growth
        with temperature."""
        part: Parts | None = None
        for table in self._live[letter]:
            part = summed(part, table.evaluate(q[letter], s[letter], direction))
        for grid in self.grids_of[letter]:
            part = summed(part, grid.evaluate(q[letter], q[grid.other], s[letter]))
        if (growth := self.expansions.get(letter)) is not None:
            more: Parts = [None] * 6
            # the scale is held at `fixed`, and grows to both sides of it
            more[ROTARY.index(letter) if letter in ROTARY else along(letter)] = growth.rate * (
                q[letter] - growth.fixed
            )
            part = summed(part, more)
        return part

    @cached_property
    def _live(self) -> dict[str, list[AxisTable]]:
        """Axis to its table, if anything in it is not zero, and to those that effects add."""
        return {
            x: [
                *([a.table] if a.table is not None and a.table.rows else []),
                *self.added.get(x, ()),
            ]
            for x, a in self.axes.items()
        }

    @cached_property
    def _playing(self) -> dict[str, list[AxisTable]]:
        """Slide to its tables that say how much play it has."""
        every = {x: [*self.added.get(x, ()), self.tables.get(x)] for x in self.letters if x in XYZ}
        return {
            x: [t for t in tables if t is not None and np.any(t.half[XYZ.index(x)])]
            for x, tables in every.items()
        }

    @cached_property
    def bounds(self) -> Bounds:
        """How far the deviation can bend and change."""
        return Bounds(self)
