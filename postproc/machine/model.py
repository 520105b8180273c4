"""A machine: its axes, its chain, its measured errors and effects, and the one deviation that they add up to."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from types import ModuleType

import numpy as np

from postproc import effects
from postproc.machine.chain import XYZ, Chain, tip_deviation
from postproc.machine.tables import COMPONENTS, AxisTable


@dataclass(frozen=True)
class Axis:
    """travel: mm that the slide can reach; least_increment: mm of the programmed word; measured_at (3,): mm, where the
    other axes stood."""

    letter: str
    travel: tuple[float, float]
    least_increment: float
    measured_at: np.ndarray
    table: AxisTable | None = None


@dataclass(frozen=True)
class EffectTerm:
    """One accepted effect with its parameters."""

    name: str
    axis: str
    parameters: dict[str, float]
    module: ModuleType


@dataclass(frozen=True)
class Limits:
    """max_correction: mm; max_slope: mm/mm; outside: "error" or "clamp"."""

    max_correction: float = 0.5
    max_slope: float = 0.005
    outside: str = "error"


@dataclass(frozen=True)
class Machine:
    """One machine as its folder states it. square: axis to (3,) rad; tool (3,) mm; offsets: name to axis to mm."""

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
    source: str = ""
    digest: str = ""
    reversal: str = "step"

    @cached_property
    def letters(self) -> tuple[str, ...]:
        """Axis letters in the order of the columns."""
        return tuple(self.axes)

    @cached_property
    def tables(self) -> dict[str, AxisTable]:
        return {x: axis.table for x, axis in self.axes.items() if axis.table is not None}

    @cached_property
    def corrected(self) -> tuple[int, ...]:
        """Rows of the axes that a correction can move: the linear ones of the chain."""
        return tuple(i for i, x in enumerate(self.letters) if x in self.chain.axes)

    @cached_property
    def is_zero(self) -> bool:
        """Whether no correction can ever be needed."""
        return not self.effects and not self.square and all(t.is_zero for t in self.tables.values())

    @cached_property
    def two_way(self) -> np.ndarray:
        """(A,) bool: axes whose direction of approach matters."""
        by_effect = {e.axis for e in self.effects if getattr(e.module, "TWO_WAY", False)}
        return np.array([x in by_effect or (x in self.tables and self.tables[x].two_way) for x in self.letters])

    @cached_property
    def turns(self) -> bool:
        """Whether any axis has a rotation, so that the tool's length matters."""
        return any(max(t.rows, default=0) >= 3 for t in self.tables.values())

    def carrying(self, letters: tuple[str, ...]) -> Machine:
        """The same machine with axes that are no slides, carried along: a printer's E."""
        more = {x: Axis(x, (-np.inf, np.inf), 1e-5, np.zeros(3)) for x in letters if x not in self.axes}
        return replace(self, axes={**self.axes, **more}) if more else self

    def with_tool(self, length: tuple[float, float, float]) -> Machine:
        """The same machine with a tool of this length, mm along X Y Z: the tip lies as much before the point that the
        slides carry."""
        return replace(self, tool=self.tool - np.array(length))

    def deviation(self, position: np.ndarray, approach: np.ndarray) -> np.ndarray:
        """(A, N) mm: actual - commanded of each linear axis, at commanded slide positions (A, N) mm.

        approach (A, N): -1 to +1, in which direction each axis last moved; 0 is the mean. Axes that the chain does not
        name have none. A deviation along a direction that the machine has no axis for is left out.
        """
        q = {x: position[i] for i, x in enumerate(self.letters)}
        s = {x: approach[i] for i, x in enumerate(self.letters)}
        measured = {x: axis.measured_at for x, axis in self.axes.items()}
        parts = tip_deviation(self.chain, self.tables, self.square, self.tool, measured, q, s)
        if self.effects:
            pose = effects.Pose(q, s)
            for term in self.effects:
                extra = term.module.deviation(pose, term.axis, **term.parameters)
                parts = [a + b for a, b in zip(parts, extra, strict=True)]
        result = np.zeros_like(position)
        for row in self.corrected:
            result[row] = parts[XYZ.index(self.letters[row])]
        return result

    def contributions(self, position: np.ndarray, approach: np.ndarray) -> list[tuple[str, np.ndarray]]:
        """Name and (A, N) mm of every part of the deviation by itself: components, squareness, effects."""
        result = []
        bare = {x: replace(axis, table=None) for x, axis in self.axes.items()}
        for x, table in self.tables.items():
            for i in table.rows:
                only = np.arange(6)[:, None] == i
                one = replace(
                    table, forward=np.where(only, table.forward, 0.0), reverse=np.where(only, table.reverse, 0.0)
                )
                part = replace(self, axes={**bare, x: replace(self.axes[x], table=one)}, square={}, effects=())
                result.append((f"{COMPONENTS[i]}{x}", part.deviation(position, approach)))
        for x, lean in self.square.items():
            for i in map(int, np.flatnonzero(lean)):
                part = replace(self, axes=bare, square={x: np.where(np.arange(3) == i, lean, 0.0)}, effects=())
                result.append((f"{'ABC'[i]}0{x}", part.deviation(position, approach)))
        for term in self.effects:
            part = replace(self, axes=bare, square={}, effects=(term,))
            result.append((term.name, part.deviation(position, approach)))
        return result

    @cached_property
    def kink(self) -> float:
        """mm/mm: how much the slope of the deviation can differ between two places, at most. The chord of any path of
        length s misses the deviation by at most kink * s / 4 (product terms apart)."""
        total = 0.0
        for letter, table in self.tables.items():
            low, high = table.slopes.min(axis=(1, 2)), table.slopes.max(axis=(1, 2))
            spread = high - low
            total += float(np.linalg.norm(spread[:3]) + np.linalg.norm(spread[3:]) * self._reach(letter))
        return total

    def local(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) kink and (N,) steepness, mm/mm, within boxes from low to high (A, N) mm; see `kink` and `steepest`."""
        kink, steep = (
            np.zeros(low.shape[1]),
            np.full(low.shape[1], sum((float(np.linalg.norm(lean)) for lean in self.square.values()), 0.0)),
        )
        for row, letter in enumerate(self.letters):
            table = self.tables.get(letter)
            if table is None or table.is_zero:
                continue
            spread, slope = table.slope_range(low[row], high[row])
            reach = self._reach(letter)
            kink += np.linalg.norm(spread[:3], axis=0) + np.linalg.norm(spread[3:], axis=0) * reach
            angle = np.abs(np.stack([table.forward, table.reverse]))[:, 3:].max(axis=(0, 2))
            steep += (
                np.linalg.norm(slope[:3], axis=0)
                + np.linalg.norm(slope[3:], axis=0) * reach
                + float(np.linalg.norm(angle))
            )
        return kink, steep

    @cached_property
    def steepest(self) -> float:
        """mm/mm: bound of the deviation's change over the way travelled."""
        total = 0.0
        for letter, table in self.tables.items():
            slope = np.abs(table.slopes).max(axis=(1, 2))
            angle = np.abs(np.stack([table.forward, table.reverse]))[:, 3:].max(axis=(0, 2))
            total += float(
                np.linalg.norm(slope[:3]) + np.linalg.norm(slope[3:]) * self._reach(letter) + np.linalg.norm(angle)
            )
        return total + float(sum(np.linalg.norm(lean) for lean in self.square.values()))

    def _reach(self, letter: str) -> float:
        """mm: the longest arm of an axis."""
        arm = np.abs(self.tool - self.axes[letter].measured_at)
        for other in self.chain.arm(letter):
            arm[XYZ.index(other)] += max(abs(t) for t in self.axes[other].travel)
        return float(np.linalg.norm(arm))

    @cached_property
    def twist(self) -> np.ndarray:
        """(A, A) 1/mm: bound of the product terms; moving axis i by a and j by b bends the deviation by twist * a * b / 4."""
        result = np.zeros((len(self.letters),) * 2)
        for letter, table in self.tables.items():
            steep = float(np.linalg.norm(np.abs(table.slopes[3:]).max(axis=(1, 2))))
            for other in self.chain.arm(letter):
                result[self.letters.index(letter), self.letters.index(other)] = steep
        return result
