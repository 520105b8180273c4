"""What `gcomp machines show` says of a machine, for a person."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.commands import machine_facts
from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.lacks import lacks
from postproc.machine.model import Machine
from postproc.machine.plausibility import implausible
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.machine.uncertainty import micrometres
from postproc.units import UM, URAD


def show(machine: Machine) -> str:
    """Its control and chain, each axis, what acts between axes, its limits, and what is doubtful or
    missing."""
    lines = _head(machine)
    for letter, axis in machine.axes.items():
        lines += _axis(machine, letter, axis)
    lines += [*_squareness(machine), *_effects(machine), *_control(machine), *_limits(machine)]
    lines.append(machine_facts.known(machine))
    lines += [f"in doubt: {text}" for text in implausible(machine)]
    lines += [f"not in this map: {text}" for text in lacks(machine)]
    return "\n".join(lines)


def _head(machine: Machine) -> list[str]:
    lines = [
        f"{machine.name}: {machine.title}",
        (f"control {machine.control}, chain {'-'.join(machine.chain.links)}, map {machine.digest}"),
    ]
    if machine.diameter:
        lines.append(
            f"words of {' '.join(machine.diameter)} are diameters; everything below is slide"
            " position, radius"
        )
    if machine.source:
        lines.append(f"source: {machine.source}")
    return lines


def _axis(machine: Machine, letter: str, axis: Axis) -> list[str]:
    unit = "degrees" if letter in ROTARY else "mm"
    lines = [
        f"\naxis {letter}  travel {axis.travel[0]:g} to {axis.travel[1]:g} {unit}, least"
        f" increment {axis.least_increment:g} {unit}"
    ]
    if letter in machine.chain.rotary:
        centre = " ".join(f"{x}{v:g}" for x, v in zip(XYZ, axis.centre, strict=True))
        lines.append(f"  centre line through {centre} mm")
    lines += [
        f"  {(XYZ + ROTARY)[i]}0{letter}  {axis.location[i] / UM:+.1f} um"
        for i in map(int, np.flatnonzero(axis.location))
    ]
    lines += [f"  by {g.other} too: {len(g.nodes)} by {len(g.others)} nodes" for g in axis.grids]
    if axis.expansion is not None:
        lines.append(
            f"  heat: {axis.expansion.rate * 1e6:+.2f} um/m from {axis.expansion.fixed:g} mm"
        )
    lines += _largest_u(axis)
    if axis.table is None:
        return [*lines, "  no error table"]
    return lines + _table(axis, axis.table, letter, unit)


def _table(axis: Axis, table: AxisTable, letter: str, unit: str) -> list[str]:
    """The table's reach, its components, and those that were left out of it."""
    lines = [f"  table {table.nodes[0]:g} to {table.nodes[-1]:g} {unit}, {len(table.nodes)} nodes"]
    lines += [_component(table, row, letter, unit) for row in table.rows]
    if table.is_zero:
        lines.append("  all zero")
    if axis.left_out:
        lines.append(f"  measured, and within the uncertainty: {', '.join(axis.left_out)}")
    return lines


def _component(table: AxisTable, row: int, letter: str, unit: str) -> str:
    forward, reverse = table.forward[row], table.reverse[row]
    scale, size = (UM, "um") if row < 3 else (URAD, "urad")
    both = np.stack([forward, reverse]) / scale
    worst = np.unravel_index(np.argmax(np.abs(both)), both.shape)
    ways = (
        f", reversal up to {np.abs(both[0] - both[1]).max():.1f}"
        if np.any(forward != reverse)
        else ""
    )
    return (
        f"  {COMPONENTS[row]}{letter}  {both.min():+.1f} to {both.max():+.1f} {size},"
        f" largest {both[worst]:+.1f} at {table.nodes[worst[1]]:g} {unit}{ways}"
    )


def _squareness(machine: Machine) -> list[str]:
    return [
        f"\nsquareness {name}  {value / URAD:+.1f} urad" for name, value in machine.angles.items()
    ] + [
        f"squareness {name} is known to +- {u / URAD:.1f} urad (95 %)"
        for name, u in machine.square_u.items()
    ]


def _effects(machine: Machine) -> Iterator[str]:
    for term in machine.effects:
        sizes = ", ".join(f"{k} = {v:g}" for k, v in term.parameters.items())
        yield f"\neffect {term.name} on {term.axis}: {sizes}"
        if term.spread:
            spread = [f"{k} +- {v:g}" for one in term.spread for k, v in one.parameters.items()]
            yield f"  known to {', '.join(spread)} (95 %)"


def _control(machine: Machine) -> list[str]:
    """The control's own tables, and the work offsets."""
    return [
        f"table of the control ({own.control}): {'on' if own.active else 'off'} at work, the"
        f" map was measured with it {'on' if own.measured else 'off'}"
        for own in machine.control_tables
    ] + [
        f"offset {name}: " + " ".join(f"{x}{v:g}" for x, v in zero.items())
        for name, zero in machine.offsets.items()
    ]


def _limits(machine: Machine) -> list[str]:
    limits = machine.limits
    lines = [
        f"\nlargest correction allowed {limits.max_correction:g} mm, outside the tables:"
        f" {limits.outside}, reversal: {machine.reversal}, hysteresis {limits.hysteresis / UM:g} um"
    ]
    if not machine.is_zero:
        lines += [
            f"largest deviation in its travel: {machine_facts.largest(machine) / UM:.1f} um",
            f"products of two errors, which are left out: {machine.bounds.second_order / UM:.2f} um"
            " at most",
        ]
    return lines


def _largest_u(axis: Axis) -> list[str]:
    """The largest U of each component of an axis, in one line; none where nothing is stated."""
    if axis.uncertainty is None or not axis.uncertainty.stated:
        return []
    u = axis.uncertainty.table
    sizes = [(i, max(u.forward[i].max(), u.reverse[i].max())) for i in axis.uncertainty.stated]
    says = [
        (
            f"{COMPONENTS[i]}{axis.letter} {micrometres(v)} um"
            if i < 3
            else f"{COMPONENTS[i]}{axis.letter} {v / URAD:.1f} urad"
        )
        for i, v in sizes
    ]
    return [f"  known to +- (95 %, at most): {', '.join(says)}"]
