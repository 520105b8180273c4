"""How far a machine's deviation can bend between two places, and how fast it can change: what makes
cuts and samples safe.

Tables are linear between nodes. What bends in between are products: an angle times an arm that
grows (twist), a table of two axes, and everything that a rotary axis turns. All bounds hold for any
tool and any place that a program can reach (`Machine.reached`).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from postproc.machine.chain import LINEAR, XYZ, along
from postproc.machine.stated import Stated

FARTHEST = 1e5  # mm: travels that are stated without end


class Bounds:
    """Bounds of one machine's deviation."""

    def __init__(self, machine: Stated):
        self.machine = machine

    @cached_property
    def kink(self) -> float:
        """mm/mm: how much the slope of the deviation can differ between two places, at most. The
        chord of any path of length s misses the deviation by at most kink * s / 4 (product terms
        apart)."""
        #                   o      The slope lies between a and a + k. The worst path has a on one
        #              .   /       half of s and a + k on the other. Its chord has a + k / 2, so the
        #         .       /        corner lies s / 2 * k / 2 = k s / 4 beside it.
        #    o-----------+
        #      a          a + k
        total = self._grid_kink
        for letter, table in self.machine.every_table:
            low, high = table.slopes.min(axis=(1, 2)), table.slopes.max(axis=(1, 2))
            first, last = self.machine.reached[letter]
            if first < table.nodes[0] or last > table.nodes[-1]:  # flat beyond the ends
                low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
            total += self.at_tip(letter, high - low)
        return total

    def local(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) kink and (N,) steepness, mm/mm, within boxes from low to high (A, N) mm; see `kink`
        and `steepest`."""
        machine, n = self.machine, low.shape[1]
        kink, steep = np.full(n, self._grid_kink), np.full(n, self._constant)
        for letter, table in machine.every_table:
            row = machine.letters.index(letter)
            spread, slope = table.slope_range(low[row], high[row])
            # An angle's value acts as a slope where its arm grows. It changes without a jump, which
            # `bend` bounds, and so counts for the steepness alone.
            kink += self.at_tip(letter, spread)
            steep += self.at_tip(letter, slope) + float(np.linalg.norm(table.sizes[3:]))
        return kink, steep

    @cached_property
    def cells(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Axis to (K,) mm the nodes of all that bends along it, and (K + 1,) mm/mm by how much the
        deviation changes per mm of its way at most: before the first node, between two, beyond the
        last. What every place has is in `even`."""
        found = {}
        for letter, nodes in self.machine.knots.items():
            every = np.array(sorted({float(node) for table in nodes for node in table}))
            middle = np.concatenate(
                [[every[0] - 1.0], (every[1:] + every[:-1]) / 2, [every[-1] + 1.0]]
            )
            total = np.zeros(len(middle))
            for table in (table for x, table in self.machine.every_table if x == letter):
                # Within a cell, and beyond the ends, slopes are constant, so that one place in its
                # middle tells them.
                total += self.at_tip(letter, table.slope_range(middle, middle)[1])
            found[letter] = every, total
        return found

    @cached_property
    def _kinks(self) -> list[tuple[int, np.ndarray, np.ndarray]]:
        """Row of an axis, (K,) mm the nodes of all that bends along it, and (K + 1,) mm/mm by how
        much the slope of the deviation turns at the nodes before each cell, one after the other."""
        machine, found = self.machine, []
        for letter, every in self.machine.knots.items():
            nodes = np.array(sorted({float(node) for table in every for node in table}))
            total = np.zeros(len(nodes))
            for table in (table for x, table in machine.every_table if x == letter):
                # flat beyond the ends
                # A node turns the slope by the step between the cells beside it; the larger of
                # forward and reverse counts, since the side does not matter to a bound.
                slopes = np.pad(table.slopes, ((0, 0), (0, 0), (1, 1)))
                turns = np.abs(np.diff(slopes, axis=2)).max(axis=1)
                total[np.searchsorted(nodes, table.nodes)] += self.at_tip(letter, turns)
            for grid in machine.grids:
                for x, own, slope in zip(
                    (grid.letter, grid.other), (grid.nodes, grid.others), grid.slopes, strict=True
                ):
                    if x == letter:
                        total[np.searchsorted(nodes, own)] += self.at_tip(grid.letter, 2 * slope)
            row = machine.letters.index(letter)
            # cumulated, so that what lies between two places is a difference of two entries
            found.append((row, nodes, np.concatenate([[0.0], np.cumsum(total)])))
        return found

    def bow(self, start: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(N,) mm: how far nodes and products can bend the deviation of straight motions (A, N)
        away from its chord, and by how much it can turn back beside that."""
        low, high = np.minimum(start, target), np.maximum(start, target)
        result = self.bend(target - start)
        for row, nodes, turned in self._kinks:
            # The picture of `kink`, with what the nodes within this motion turn the slope by in the
            # place of the largest difference anywhere. A node where the motion begins or ends turns
            # nothing within it.
            first, last = nodes.searchsorted(low[row], "right"), nodes.searchsorted(high[row])
            result = result + (turned[last] - turned[first]) * (high[row] - low[row]) / 4
        return result

    @cached_property
    def even(self) -> float:
        """mm/mm: by how much the deviation changes per mm of way everywhere, at most, whichever
        cell the place is in: squareness, heat, tables of two axes, and every angle times the arm
        that grows."""
        angles = (table.sizes[3:] for _, table in self.machine.every_table)
        return self._constant + sum(float(np.linalg.norm(angle)) for angle in angles)

    @cached_property
    def steepest(self) -> float:
        """mm/mm: bound of the deviation's change over the way travelled."""
        total = self._constant
        for letter, table in self.machine.every_table:
            angle = float(np.linalg.norm(table.sizes[3:]))
            total += self.at_tip(letter, table.steepest) + angle
        return total

    @cached_property
    def _constant(self) -> float:
        """mm/mm: what squareness, location, heat and tables of two axes add to the steepness
        everywhere."""
        m = self.machine
        total = sum(
            float(np.linalg.norm(stands[3:])) * (1 if x in LINEAR else 2)
            for x, stands in m.locations.items()
        )
        total += sum(abs(growth.rate) for growth in m.expansions.values())
        return (
            total
            + self._grid_slopes()
            + sum(float(np.linalg.norm(grid.sizes[3:])) for grid in m.grids)
        )

    @property
    def _grid_kink(self) -> float:
        """mm/mm: a slope of a grid may be its steepest up here and down there."""
        return 2 * self._grid_slopes()

    def _grid_slopes(self) -> float:
        grids = self.machine.grids
        return float(
            sum(self.at_tip(grid.letter, slope) for grid in grids for slope in grid.slopes)
        )

    def at_tip(self, letter: str, errors: np.ndarray) -> Any:
        """(...) mm: how much errors (6, ...) of an axis, mm and rad, move the tool at most."""
        moves, turns = (np.linalg.norm(part, axis=0) for part in (errors[:3], errors[3:]))
        return moves + turns * self.reach(letter)

    def reach(self, letter: str) -> float:
        """mm: the longest arm of an axis."""
        m = self.machine
        axis = m.axes[letter]
        arm = np.abs(m.tool - m.measured[letter])
        # Without rotary axes: the vector from where the axis was measured to the tip, each of its
        # directions made as long as the slides of that direction can. With them lengths are added,
        # whatever their directions: too long, never too short.
        if m.chain.rotary:  # turned about, every part of the arm may point anywhere
            slides = sum(self._travel(x) for x in m.chain.axes if x in XYZ)
            centres = sum(2 * float(np.linalg.norm(m.axes[x].centre)) for x in m.chain.rotary)
            return (
                float(np.linalg.norm(m.tool) + np.linalg.norm(m.measured[letter]))
                + slides
                + centres
            )
        if letter in m.chain.axes:
            for other in m.chain.arm(letter, axis.optic):
                arm[along(other)] += self._travel(other)
        return float(np.linalg.norm(arm))

    def _travel(self, letter: str) -> float:
        m = self.machine
        farthest = max(abs(t) for t in m.reached[letter]) + m.limits.max_correction
        # A corrected command may leave the tables by a correction, never the travel (contract of a
        # machine, "Meaning").
        return min(farthest, max(abs(t) for t in m.axes[letter].travel), FARTHEST)

    @cached_property
    def second_order(self) -> float:
        """mm: bound of what a sum of first order leaves out, the products of two errors: every
        angle turns every other error and its arm. Sizes are those of the tables' nodes."""
        m = self.machine
        # Each angle at its largest, all of one sign, times the sum of all that they can turn.
        angle = shift = 0.0
        for x in m.chain.axes:
            size, lean, _, _ = self._sizes(x, np.zeros(1))
            if x in m.expansions:
                size += abs(m.expansions[x].rate) * 2 * self._travel(x)
            # left out of a sum of first order: every angle times every shift, and times the arm of
            # every other angle
            angle += lean
            shift += size + lean * (
                self.reach(x) + self._travel(x) if x in LINEAR else self.reach(x)
            )
        return angle * shift

    @cached_property
    def twist(self) -> np.ndarray:
        """(A, A) 1/mm: bound of the product terms; moving axis i by a and j by b bends the
        deviation by twist * a * b / 4: along a line x y leaves its chord by a b t (1 - t), t from 0
        to 1, which is most in the middle. An angle is such a term: its table's value, which rises
        along its own axis, times an arm that another axis makes longer."""
        m = self.machine
        result = np.zeros((len(m.letters),) * 2)

        def add(one: str, other: str, size: float) -> None:
            result[m.letters.index(one), m.letters.index(other)] += size

        for letter, table in m.every_table:
            steep = float(np.linalg.norm(table.steepest[3:]))
            if letter in m.chain.axes:
                # angle(q of its own axis) * arm(q of another): a product of two straight lines
                for other in m.chain.arm(letter, m.axes[letter].optic):
                    add(letter, other, steep)
        for grid in m.grids:
            # A grid bends by itself where both its axes move, and its angles times the arm as those
            # of a table do, by either axis.
            add(grid.letter, grid.other, self.at_tip(grid.letter, grid.twist))
            along, across = (float(np.linalg.norm(slope[3:])) for slope in grid.slopes)
            for other in m.chain.arm(grid.letter, m.axes[grid.letter].optic):
                add(grid.letter, other, along)
                add(grid.other, other, across)
        return result

    @cached_property
    def _quarters(self) -> list[tuple[int, int, np.ndarray]]:
        """Rows of two axes, and a quarter of their twist where there is any."""
        some = np.argwhere(self.twist).tolist()
        return [(i, j, np.array(self.twist[i, j] / 4)) for i, j in some]

    def bend(self, way: np.ndarray) -> np.ndarray:
        """(N,) mm: how far products can bend the deviation of straight motions away from its chord;
        way (A, N) mm and degrees. It goes with the square of the length: cut in n parts, n * n
        times less."""
        size = np.abs(way)
        parts = [twist * (size[i] * size[j]) for i, j, twist in self._quarters]
        result: np.ndarray = sum(parts[1:], parts[0]) if parts else np.zeros(way.shape[1])
        if self.machine.chain.rotary:
            # what curves by f'' at most leaves its chord by f'' t (1 - t) / 2 at most
            result = result + self._turning(way) / 8
        return result

    def bends(self, start: np.ndarray, target: np.ndarray, slack: float) -> np.ndarray:
        """(M,) bool: straight motions (A, M) that must be cut in more than one of `parts`."""
        return self.bend(target - start) > slack

    def parts(self, start: np.ndarray, target: np.ndarray, slack: float) -> np.ndarray:
        """(M,) into how many equal parts straight motions (A, M) must be cut, so that products bend
        the deviation by `slack` mm at most within one; nodes apart. 1: not at all."""
        return np.maximum(np.ceil(np.sqrt(self.bend(target - start) / slack)), 1).astype(np.int64)

    def _turning(self, way: np.ndarray) -> np.ndarray:
        """(N,) mm: bound of the second derivative over the whole motion of everything that a rotary
        axis turns.

        A product f R r of a table's value, nominal rotations and an arm has 2 f' R' r + 2 f' R r' +
        2 f R' r' + f R'' r + f R r''; every rotation adds its angle a to |R'| and a^2 to |R''|, and
        turns arms too.
        """
        m = self.machine
        rows = {x: i for i, x in enumerate(m.letters)}
        angle = sum(
            (np.radians(np.abs(way[rows[x]])) for x in m.chain.rotary), np.zeros(way.shape[1])
        )
        slide = np.sqrt(
            sum((way[rows[x]] ** 2 for x in m.chain.axes if x in XYZ), np.zeros(way.shape[1]))
        )
        total = np.zeros(way.shape[1])
        for x in m.chain.axes:
            arm = self.reach(x)
            shift, lean, shift_rise, lean_rise = self._sizes(x, np.abs(way[rows[x]]))
            if x in m.expansions:
                rate = abs(m.expansions[x].rate)
                shift = shift + rate * self._travel(x)
                shift_rise = shift_rise + rate * np.abs(way[rows[x]])
            total += 2 * shift_rise * angle + shift * angle**2
            total += lean_rise * (4 * angle * arm + 2 * slide) + lean * (
                4 * angle**2 * arm + 4 * angle * slide
            )
        return np.where(angle > 0, total, 0.0)

    def _sizes(self, letter: str, way: np.ndarray) -> tuple[float, float, np.ndarray, np.ndarray]:
        """Largest translation mm and rotation rad of an axis, twice what its line lies off in it,
        and (N,) how much they change over a way (N,)."""
        shift = lean = 0.0
        shift_rise, lean_rise = np.zeros(len(way)), np.zeros(len(way))
        for table in (t for x, t in self.machine.every_table if x == letter):
            more, turn = _halves(table.sizes)
            steep, steep_turn = _halves(table.steepest)
            shift, lean = shift + more, lean + turn
            shift_rise = shift_rise + np.minimum(steep * way, 2 * more)
            lean_rise = lean_rise + np.minimum(steep_turn * way, 2 * turn)
        for grid in self.machine.grids_of[letter]:
            more, turn = _halves(grid.sizes)
            shift, lean = shift + more, lean + turn
            shift_rise, lean_rise = shift_rise + 2 * more, lean_rise + 2 * turn
        if (stands := self.machine.locations.get(letter)) is not None:
            more, turn = _halves(stands)
            # It acts twice, on what comes to the axis and on what leaves it: B R B^-1.
            shift, lean = shift + 2 * more, lean + 2 * turn
        return shift, lean, shift_rise, lean_rise


def _halves(errors: np.ndarray) -> tuple[float, float]:
    """Lengths of translation mm and rotation rad of errors (6,)."""
    return float(np.linalg.norm(errors[:3])), float(np.linalg.norm(errors[3:]))
