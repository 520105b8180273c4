"""What looks like a slip in a machine's file: sizes that no machine has, lost motion of the wrong
sign, corrections that its own limits refuse. What was not measured is no slip: lacks.py."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from postproc.machine import overshoot
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS
from postproc.units import UM, URAD

# The cheapest screws stray 0.5 mm in 300 mm (ISO 3408-3, class 10: 0.21 mm); a slide that turned by
# 2 mrad would rattle. 10 mrad are 3 mm on 300 mm, which the eye sees beside a square; mrad or mm/m
# entered for urad are a thousand times off.
LARGEST_UM, LARGEST_URAD, LARGEST_SQUARE = 2000.0, 2000.0, 10_000.0
LEAST = 0.02  # um or urad: no instrument that is used at machine tools resolves less
LARGEST_PLAY_UM = 1000.0  # an old router's plastic nut


def implausible(machine: Machine) -> list[str]:
    """Sentences, each with its number and the way out; empty where nothing is odd."""
    return [
        *overshoot.found(machine), *_sizes(machine), *_square(machine), *_play(machine),
        *_refused(machine),
    ]  # fmt: skip


def _sizes(machine: Machine) -> Iterator[str]:
    for x, table in machine.tables.items():
        for row in table.rows:
            unit, one, most = ("um", UM, LARGEST_UM) if row < 3 else ("urad", URAD, LARGEST_URAD)
            values = np.concatenate([table.forward[row], table.reverse[row]]) / one
            size, name = float(np.abs(values).max()), f"{COMPONENTS[row]}{x}"
            if size > most:
                likely = "nm" if row < 3 else "nrad, or mrad as urad times a thousand"
                yield (
                    f"{name} reaches {size:.4g} {unit}, more than a machine strays: are its values"
                    f" {likely}?"
                )
            elif 0 < size < LEAST:
                likely = "mm" if row < 3 else "mrad (mm/m)"
                yield (
                    f"{name} is {size:.2g} {unit} at most, less than is ever measured: are its"
                    f" values {likely}?"
                )


def _square(machine: Machine) -> Iterator[str]:
    for name, angle in machine.angles.items():
        value = angle / URAD
        if abs(value) > LARGEST_SQUARE:
            yield (
                f"squareness {name} = {value:g} urad is {abs(value) * 0.3e-3:.2f} mm on 300 mm,"
                f" which the eye sees: are these {value / 1e3:g} urad, or nrad? urad are wanted"
                " (1 mm/m = 1000)"
            )


def _play(machine: Machine) -> Iterator[str]:
    for term in machine.effects:
        size = term.parameters.get("size_um", 0.0)
        if term.name == "backlash" and abs(size) > LARGEST_PLAY_UM:
            yield (
                f"backlash of {term.axis} is {size:g} um, {abs(size) / 1e3:g} mm: is its unit"
                " right? um are wanted"
            )


def _reach(machine: Machine, letter: str) -> tuple[float, float]:
    """mm: how far an axis goes with its table; a rotary axis without one stays at zero."""
    table = machine.tables.get(letter)
    if machine.limits.outside != "clamp" and table is not None:
        return float(table.nodes[0]), float(table.nodes[-1])
    return machine.axes[letter].travel if letter in XYZ else (0.0, 0.0)


def _refused(machine: Machine) -> list[str]:
    """Corners of the travel whose correction is larger than the limit."""
    if machine.is_zero:
        return []
    slides = [x for x in machine.letters if x in XYZ]
    ends = [_reach(machine, x) for x in machine.letters]
    corners = np.stack([g.ravel() for g in np.meshgrid(*ends, indexing="ij")])
    off = np.abs(machine.deviation(corners, np.zeros_like(corners)))
    row, at = np.unravel_index(int(off.argmax()), off.shape)
    if off[row, at] <= machine.limits.max_correction:
        return []
    where = " ".join(f"{x}{corners[i, at]:g}" for i, x in enumerate(machine.letters) if x in slides)
    return [
        f"at {where} the correction of {machine.letters[row]} is {off[row, at]:.3f} mm, and"
        f" max_correction = {machine.limits.max_correction:g} mm refuses it: mend the machine, or"
        " raise [limits] max_correction"
    ]
