"""What the tables of all axes say at a place, looked up at once, and how it adds up at the tool.

The components of each table that are not zero everywhere stand behind one another, and the
intervals of all tables side by side, so that one `take` serves all axes:

    base, rise   (K, intervals of X | intervals of Y | ...)   row k: the k-th component of each axis
    interval     (T N)                                        of every table, at every place
    value        (K, T, N) = base + rise * share

What they add up to along X Y Z (postproc.machine.chain) is a list of steps: one of these values, or
its product with an arm or an angle, is added or taken away.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from postproc.machine.chain import ROTARY, Parts, along
from postproc.machine.stated import Stated
from postproc.machine.tables import AxisTable

CROSS = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
# components that count along X, Y or Z: the shift, and both rotations about the others
COUNTS = {None: tuple(range(6)), 0: (0, 4, 5), 1: (1, 3, 5), 2: (2, 3, 4)}


class Lookup:
    """The tables of a machine, or what of them counts along a direction, 0 to 2. `columns`: axis
    and component, as a row of COMPONENTS, of each of the `values`."""

    def __init__(self, machine: Stated, direction: int | None = None):
        self.letters, wanted = machine.letters, COUNTS[direction]
        self.columns: list[tuple[str, int]] = []
        self._add_tables([(x, t) for x in machine.chain.axes for t in machine.live[x]], wanted)
        self._add_others(machine, wanted)
        self.arms: list[tuple[np.ndarray, list[int]]] = []
        self.steps: list[tuple[int, int, int, bool]] = []
        if not machine.chain.rotary:
            self._add_steps(machine, direction)

    def _row(self, letter: str) -> int:
        return self.letters.index(letter)

    def _add_others(self, machine: Stated, wanted: Collection[int]) -> None:
        """`grids`: row of the axis, of the second one, grid, and components; `growth`: row of the
        axis and how its scale grows."""
        self.grids = [
            (self._row(x), self._row(grid.other), grid, [i for i in grid.rows if i in wanted])
            for x in machine.chain.axes
            for grid in machine.grids_of[x]
        ]
        self.columns += [(grid.letter, i) for _, _, grid, rows in self.grids for i in rows]
        own = {x: 3 + ROTARY.index(x) if x in ROTARY else along(x) for x in machine.expansions}
        warm = [x for x in machine.chain.axes if own.get(x) in wanted]
        self.growth = [(self._row(x), machine.expansions[x]) for x in warm]
        self.columns += [(x, own[x]) for x in warm]

    def _add_tables(self, tables: list[tuple[str, AxisTable]], wanted: Collection[int]) -> None:
        """`tables`: row of the axis, table, and intervals before its own; `base`, `rise`; `order`:
        which value each column is; `halves`: a column, the value that is half of both directions'
        difference there, and the axis' row."""
        self.tables: list[tuple[int, AxisTable, np.ndarray]] = []
        self.order: list[int] = []
        self.halves: list[tuple[int, int, int]] = []
        tables = [(x, table) for x, table in tables if set(table.rows) & set(wanted)]
        values, before, count = [], 0, len(tables)
        for k, (x, table) in enumerate(tables):
            rows = [i for i in table.rows if i in wanted]
            both = [i for i in rows if np.any(table.half[i])]
            values.append(np.concatenate([table.mean[rows], table.half[both]]))
            for n, i in enumerate(both, len(rows)):
                self.halves.append((len(self.order) + rows.index(i), n * count + k, self._row(x)))
            self.order += [n * count + k for n in range(len(rows))]
            self.columns += [(x, i) for i in rows]
            self.tables.append((self._row(x), table, np.array(before)))
            before += len(table.nodes) - 1
        depth = max(map(len, values), default=0)
        full = [np.pad(value, ((0, depth - len(value)), (0, 0))) for value in values]
        self.base = np.concatenate([np.zeros((depth, 0)), *(v[:, :-1] for v in full)], axis=1)
        self.rise = np.concatenate([np.zeros((depth, 0)), *(np.diff(v) for v in full)], axis=1)

    def _add_steps(self, machine: Stated, direction: int | None) -> None:
        """`steps`: to which direction, which value (behind the columns: the positions), times which
        of `arms`, -1: none, and whether it is taken away; `arms`: what stays, mm, or an angle, rad,
        and the rows of the slides that add to it."""
        for x in machine.chain.axes:
            for i, rate in machine.leaning.get(x, ()):
                self._step(i, len(self.columns) + self._row(x), (rate, []))
            own = [(k, i) for k, (y, i) in enumerate(self.columns) if y == x]
            arm = [(stays, [self._row(y) for y in slides]) for stays, slides in machine.arms[x]]
            for k, i in own:
                if i < 3:
                    self._step(i, k)
            self._turn(own, arm)
        self.steps = [s for s in self.steps if direction in (None, s[0])]

    def _turn(self, own: list[tuple[int, int]], arm: list[tuple[np.ndarray, list[int]]]) -> None:
        """Steps of eps x arm, whose i-th component is eps_j arm_k - eps_k arm_j."""
        for i, j, k in CROSS:
            for turn, across, minus in ((j, k, False), (k, j, True)):
                for column in (column for column, component in own if component == 3 + turn):
                    self._step(i, column, arm[across], minus)

    def _step(
        self,
        i: int,
        column: int,
        arm: tuple[np.ndarray, list[int]] | None = None,
        minus: bool = False,
    ) -> None:
        if arm is None:
            self.steps.append((i, column, -1, minus))
        elif arm[0] or arm[1]:
            if arm not in self.arms:
                self.arms.append(arm)
            self.steps.append((i, column, self.arms.index(arm), minus))

    def values(self, position: np.ndarray, approach: np.ndarray) -> list[np.ndarray]:
        """(N,) mm or rad for each of `columns`, at commanded positions (A, N), approached from -1
        to +1 (A, N)."""
        n, found = position.shape[1], []
        if self.tables:
            places = [table.place(position[row]) for row, table, _ in self.tables]
            interval = np.concatenate(
                [at + t[2] for (at, _), t in zip(places, self.tables, strict=True)]
            )
            value = self.rise.take(interval, axis=1)
            value *= np.concatenate([share for _, share in places])
            value += self.base.take(interval, axis=1)
            each = value.reshape(-1, n)
            found = [each[k] for k in self.order]
            for k, half, row in self.halves:
                found[k] = found[k] + approach[row] * each[half]
        for row, other, grid, rows in self.grids:
            parts = grid.evaluate(position[row], position[other], approach[row])
            found += [parts[i] for i in rows]
        return found + [g.rate * (position[row] - g.fixed) for row, g in self.growth]

    def parts(self, values: list[np.ndarray]) -> dict[str, Parts]:
        """Axis to its six deviations, None: zero everywhere."""
        found: dict[str, Parts] = {}
        for (x, i), value in zip(self.columns, values, strict=True):
            had = found.setdefault(x, [None] * 6)
            had[i] = value if had[i] is None else had[i] + value
        return found

    def tip(self, values: list[np.ndarray], position: np.ndarray) -> list[np.ndarray]:
        """Three (N,) columns X Y Z of mm of a chain without rotary axes. Nothing is added in place:
        that takes three times as long where N is 1."""
        arms = []
        for stays, slides in self.arms:
            arm = position[slides[0]] if slides else stays
            arm = arm + stays if slides and stays else arm
            for row in slides[1:]:
                arm = arm + position[row]
            arms.append(arm)
        values = [*values, *position]
        total: list[np.ndarray | None] = [None, None, None]
        for i, column, arm, minus in self.steps:
            term = values[column] if arm < 0 else values[column] * arms[arm]
            if total[i] is None:
                total[i] = -term if minus else term
            else:
                total[i] = total[i] - term if minus else total[i] + term
        return [np.zeros(position.shape[1]) if column is None else column for column in total]
