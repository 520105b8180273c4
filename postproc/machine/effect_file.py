"""The [[effect]] sections of a machine.toml: physics beyond the tables, with how well its
parameters are known.

Reads strictly, as file.py does.
"""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType
from typing import Any, TypeVar

import numpy as np

from postproc import effects
from postproc.machine.axis import Axis
from postproc.machine.chain import XYZ
from postproc.machine.stated import EffectTerm
from postproc.machine.tables import COMPONENTS, AxisTable, GridTable
from postproc.machine.toml_file import Section, TomlFile

KEYS = {"name", "axis", "source", "measured_mm"}
Table = TypeVar("Table", AxisTable, GridTable)


def read_effects(toml: TomlFile, axes: dict[str, Axis]) -> tuple[EffectTerm, ...]:
    """All effects of a machine.toml. Raises MachineError with file and line."""
    terms = []
    for entry in toml.sections("effect", "effects"):
        name = entry.string("name")
        try:
            module = effects.load(name)
        except KeyError:
            known = f"effects: {', '.join(effects.names())}"
            raise entry.fault("name", f"there is no effect {name!r}", known) from None
        axis = _effect_axis(entry, module, axes)
        sizes = effects.sizes(module)
        entry.check_keys(KEYS | set(module.PARAMETERS) | {f"u_{p}" for p in sizes})
        # a parameter that is not optional has no default, and `number` refuses its absence
        optional = getattr(module, "OPTIONAL", {})
        parameters = {p: entry.number(p, optional.get(p)) for p in module.PARAMETERS}
        for key, value in parameters.items():
            if high := effects.too_high(module, key, value):
                raise entry.fault(key, high, module.PARAMETERS[key])
            if (ways := effects.of_axes(module, key)) and value not in ways:
                raise entry.fault(
                    key, f"{key} = {value:g} is no number of an axis", module.PARAMETERS[key]
                )
        made = term(name, axis, parameters, axes, _measured(entry))
        spread = [_spread(entry, made, axes, p) for p in sizes if f"u_{p}" in entry]
        terms.append(replace(made, spread=tuple(spread)))
    return tuple(terms)


def term(
    name: str,
    axis: str,
    parameters: dict[str, float],
    axes: dict[str, Axis],
    measured: tuple[float, float] | None,
) -> EffectTerm:
    """An effect with the tables that it adds to a machine with these axes; its U is not stated.
    measured mm: where it was read."""
    module = effects.load(name)
    tables, grids = _applied(module, axis, axes, parameters, measured)
    return EffectTerm(name, axis, parameters, module, tables, grids, measured=measured)


def _effect_axis(entry: Section, module: ModuleType, axes: dict[str, Axis]) -> str:
    """The axis of an effect, a pair of them, or "" for one of the whole machine."""
    axis = entry.string("axis", "" if module.PER == "all" else None)
    if module.PER == "all" and not axis:
        return ""
    wanted = 2 if module.PER == "pair" else 1
    if len(axis) != wanted or len(set(axis) & set(axes) & set(XYZ)) != wanted:
        what = "not a pair of linear axes, like XZ," if wanted == 2 else "no linear axis"
        message = f"effect {entry['name']}: {axis!r} is {what} of the machine"
        raise entry.fault("axis", message)
    return axis


def _spread(entry: Section, term: EffectTerm, axes: dict[str, Axis], name: str) -> EffectTerm:
    """By how much the U of a parameter changes the effect's tables: half of what lies between both
    ends of the interval."""
    key = f"u_{name}"
    u = entry.number(key)
    if u < 0:
        message = f"{key} = {entry[key]!r} is below zero"
        raise entry.fault(key, message, "U (95 %) is zero or more")
    ends: list[AxisTable] = []
    grids: list[GridTable] = []
    # (f(p + U) - f(p - U)) / 2, a central difference: of an effect that is linear in p U times the
    # slope, of one that bends (a period, an exponent) the mean of both sides. Its sign means
    # nothing, since U counts squared.
    for share in (0.5, -0.5):
        there = term.parameters | {name: term.parameters[name] + 2 * share * u}
        try:
            # a period of zero, a root of less: there the effect has no meaning
            with np.errstate(all="raise", under="ignore"):
                found = _applied(term.module, term.axis, axes, there, term.measured)
        except (ArithmeticError, ValueError):
            raise entry.fault(
                key,
                f"{key} = {u:g}: effect {term.name} has no meaning at {name} = {there[name]:g}",
                "U (95 %) must leave the parameter what it is",
            ) from None
        ends += [_times(table, share) for table in found[0]]
        grids += [_times(grid, share) for grid in found[1]]
    return EffectTerm(name, term.axis, {name: u}, None, tuple(ends), tuple(grids))


def _measured(entry: Section) -> tuple[float, float] | None:
    """mm: from where to where of the axis the readings were that an effect was found in; None where
    nobody said."""
    # of a machine that somebody wrote by hand nothing is said: its curve is taken to hold all over
    # the travel
    value = entry.get("measured_mm")
    return None if value is None else entry.span("measured_mm", value)


def _held(table: AxisTable, measured: tuple[float, float] | None) -> AxisTable:
    """A table that stays, beyond what was measured, what it was at the last reading: a curve
    predicts nothing there."""
    if measured is None:
        return table
    low, high = measured
    #    curve   '.   .---.   .'     Beyond the last reading a fitted curve is a guess, and grows
    #    held    ---.'     '.---     fastest: it stays what it was where somebody has read it.
    #              low     high
    inside = table.nodes[(table.nodes > low) & (table.nodes < high)]
    nodes = np.unique(np.concatenate([[table.nodes[0], low], inside, [high, table.nodes[-1]]]))
    at = np.clip(nodes, low, high)

    def of(values: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(at, table.nodes, row) for row in values])

    return replace(table, nodes=nodes, forward=of(table.forward), reverse=of(table.reverse))


def _times(table: Table, share: float) -> Table:
    return replace(table, forward=share * table.forward, reverse=share * table.reverse)


def _table(
    component: str, letter: str, nodes: np.ndarray, forward: np.ndarray, reverse: np.ndarray
) -> AxisTable:
    both = np.zeros((2, 6, len(nodes)))
    both[:, COMPONENTS.index(component)] = forward, reverse
    return AxisTable(letter, nodes, both[0], both[1])


def _applied(
    module: Any,
    axis: str,
    axes: dict[str, Axis],
    parameters: dict[str, float],
    measured: tuple[float, float] | None,
) -> tuple[tuple[AxisTable, ...], tuple[GridTable, ...]]:
    """What an effect adds where the slides stand, for a compensator; its tables stay, beyond what
    was measured, what they were there."""
    # what time, speed or force decides is kept as stated and changes no place
    if module.USE != "compensate":
        return (), ()
    rows, own = [], []
    if hasattr(module, "tables"):
        # of a pair "XZ" either may be the one whose place counts
        moving = module.moving(axis, **parameters) if module.PER == "pair" else axis
        rows += module.tables(axis, axes[moving].travel, **parameters)
    if hasattr(module, "arm_tables"):
        own += module.arm_tables(axis, axes[axis].travel, measured, **parameters)
    if hasattr(module, "by_angle") and (map_ := axes[axis].table) is not None:
        rows += module.by_angle(axis, map_.nodes, map_.forward[3:], map_.reverse[3:], **parameters)
    # tables() follow a curve that may leave the readings; by_angle() is as wide as the map,
    # arm_tables() is told `measured` and holds by itself.
    tables = [_held(_table(*row), measured) for row in rows] + [_table(*row) for row in own]
    grids = []
    if hasattr(module, "grids"):
        travel = {x: a.travel for x, a in axes.items()}
        for component, letter, other, nodes, others, value in module.grids(
            axis, travel, **parameters
        ):
            whole = np.zeros((6, len(nodes), len(others)))
            whole[COMPONENTS.index(component)] = value
            grids.append(GridTable(letter, other, nodes, others, whole, whole))
    return tuple(tables), tuple(grids)
