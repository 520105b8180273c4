"""What a machine's map does not hold: what was not measured is zero in it, and looks like a machine
without that error."""

from __future__ import annotations

import itertools

from postproc.machine.chain import ROTARY, XYZ
from postproc.machine.model import Machine
from postproc.machine.tables import COMPONENTS
from postproc.units import UM, URAD

SQUARE = 100 * URAD  # what a squareness that is not known is imagined as: 0.1 mm on a metre


def lacks(machine: Machine) -> list[str]:
    """Sentences: squareness and components without a measurement, travel beyond the tables, signs
    that no second measurement has shown. Empty for a machine without any error, which lacks
    nothing, unless it says that its signs are unverified: then its errors are still to be measured.
    """
    if machine.is_zero and not machine.square and machine.signs != "unverified":
        return []
    return [
        *_square(machine), *_lines(machine), *_components(machine), *_beyond(machine),
        *_signs(machine),
    ]  # fmt: skip


def sentence(machine: Machine) -> str:
    """The same in one line; empty where nothing is lacking."""
    found = lacks(machine)
    return f"not in the map: {'; '.join(found)}" if found else ""


def _slides(machine: Machine) -> list[str]:
    return [x for x in XYZ if x in machine.chain.axes]


def _stated_pairs(machine: Machine) -> set[frozenset[str]]:
    """Pairs of slides whose squareness is stated, or is an effect of its own."""
    stated = {
        # B0X turns about Y: it is the angle between the other two, X and Z
        frozenset(XYZ) - {XYZ[ROTARY.index(name[0])]}
        for name in machine.square_stated
        if name[2] in XYZ
    }
    return stated | {frozenset(t.axis) for t in machine.effects if t.name == "squareness"}


def _square(machine: Machine) -> list[str]:
    """Pairs of slides without a squareness, and what 100 urad would be at the far corner: the
    longer of both travels leans."""
    stated = _stated_pairs(machine)
    pairs = [p for p in itertools.combinations(_slides(machine), 2) if frozenset(p) not in stated]
    if not pairs:
        return []
    way = {x: high - low for x, (low, high) in ((x, a.travel) for x, a in machine.axes.items())}
    lengths = [max(way[a], way[b]) for a, b in pairs]
    return [
        f"squareness of {', '.join(map(''.join, pairs))}, not measured: 100 urad would be "
        f"{', '.join(f'{SQUARE * v / UM:.1f}' for v in lengths)} um at the far corner"
    ]


def _lines(machine: Machine) -> list[str]:
    """Rotary axes of which nothing says how their line lies (ISO 230-7: X0C, A0C and so on)."""
    stated = {name[2] for name in machine.square_stated}
    bare = [
        x for x in machine.chain.rotary if x not in stated and not machine.axes[x].location.any()
    ]
    return [f"how the line of {', '.join(bare)} lies, which was not measured"] if bare else []


def _components(machine: Machine) -> list[str]:
    """Components that act on a slide's direction and stand in no table; "all of Y" for all of an
    axis."""
    found = []
    for x in machine.chain.axes:
        wanted = [f"{COMPONENTS[row]}{x}" for row in _acting(machine)]
        missing = [name for name in wanted if name not in _known(machine, x)]
        if missing and len(missing) == len(wanted):
            found.append(f"all of {x}")
        else:
            found += missing
    return [f"{', '.join(found)}: never measured"] if found else []


def _acting(machine: Machine) -> list[int]:
    """Rows of COMPONENTS: translations along a slide, and rotations that turn one slide's direction
    into another's, which an arm makes a deviation."""
    slides = {XYZ.index(x) for x in _slides(machine)}
    # Of a lathe with X and Z: EB turns X into Z and counts; EA and EC turn one of them into Y,
    # where nothing can be corrected, and nobody need measure them.
    turning = [r for r in range(3) if set(range(3)) - {r} <= slides]
    return [*sorted(slides), *(3 + r for r in turning)]


def _known(machine: Machine, letter: str) -> set[str]:
    """Components of an axis that anything states."""
    axis = machine.axes[letter]
    rows = set(axis.table.stated) if axis.table is not None else set()
    for grid in machine.grids_of[letter]:
        rows |= set(grid.rows)
    for term in machine.effects:
        for table in term.tables:
            rows |= set(table.rows) if table.letter == letter else set()
    return {f"{COMPONENTS[row]}{letter}" for row in rows} | set(axis.left_out)


def _beyond(machine: Machine) -> list[str]:
    """Travels that go beyond their table by more than a correction may leave it."""
    limits, found = machine.limits, []
    for x, table in machine.tables.items():
        (low, high), first, last = machine.axes[x].travel, table.nodes[0], table.nodes[-1]
        far = max(first - low, high - last)
        if x in XYZ and far > limits.max_correction:
            held = (
                "its end values hold there"
                if limits.outside == "clamp"
                else "places there are refused"
            )
            found.append(
                f"{x} beyond {first:g} to {last:g} mm, where it was measured; the travel goes"
                f" {far:g} mm beyond it: {held}"
            )
    return found


def _signs(machine: Machine) -> list[str]:
    if machine.signs != "unverified":
        return []
    return [
        "a proof of its signs (unverified): measure again with a corrected program, gcomp accept"
        " judges it"
    ]
