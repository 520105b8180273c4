"""Fanuc's pitch error compensation and the list of straightness, read back."""

from __future__ import annotations

import numpy as np

from postproc.control_tables import ErrorTable, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _fanuc_listing as listings
from postproc.recordings import Source

NEEDED = (3620, 3621, 3622, 3623, 3624)


def pitch_table(
    listing: listings.Listing, axis: str, options: ExportOptions, used: set[int]
) -> ErrorTable | None:
    known = listing.settings[axis]
    step = _interval(listing, axis, options)
    columns = _columns(listing, axis, options, used)
    play = known.get(1851, 0.0) * options.step
    filled = [points for points, _ in columns if len(points)]
    if not filled and not play and 3627 not in known:
        return None
    points = np.unique(np.concatenate(filled)) if filled else np.zeros(1)
    # what the control adds to the command; a deviation is minus that
    added = [np.interp(points, p, v) if len(p) else np.full(len(points), v[0]) for p, v in columns]
    # 1851 is added once at a reversal: taken half and half, the mean stays where the table has it
    up, down = added[0] + play / 2, added[-1] - play / 2
    home = options.reference.get(axis, 0.0)
    return ErrorTable(axis, axis, np.round(home + points * step, 9), -up, -down)


def _columns(
    listing: listings.Listing, axis: str, options: ExportOptions, used: set[int]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Points and what is added there, of both directions or of each."""
    known = listing.settings[axis]
    first, low, high, magnification = (int(known[n]) for n in NEEDED[:4])
    starts = [(low, 0.0)]
    if 3626 in known and int(known.get(3605, 1)) & 1:
        turned = known.get(3627, 0.0) * options.step
        forth = common.setting(options, "return", "+", ("+", "-")) == "+"
        # The direction of the reference return has zero at the reference, the other one 3627
        # (turned).
        starts = [(low, 0.0 if forth else turned), (int(known[3626]), turned if forth else 0.0)]
    columns = []
    for start, offset in starts:
        numbers = _numbers(listing, axis, range(start, start + high - low + 1), used)
        used.update(numbers)
        increments = [listing.pitch[n] for n in numbers]
        unit = magnification * options.step
        columns.append(_sums(numbers, increments, start + first - low, unit, offset))
    return columns


def _interval(listing: listings.Listing, axis: str, options: ExportOptions) -> float:
    """mm from point to point, by 3624. Raises TableError where the parameters make no table of a
    linear axis."""
    known, source = listing.settings[axis], listing.source
    for number in NEEDED:
        if number not in known:
            raise TableError(
                f"{source.name}: parameter {number} of {axis} is missing",
                "3620 to 3624 say where the numbers stand",
            )
    length = (axis, 3624) in listing.lengths
    unit = common.mm_per_unit(options) if length else listings.increment(options)
    step = known[3624] * unit
    low, high = int(known[3621]), int(known[3622])
    if step <= 0 or high < low:
        raise TableError(
            f"{source.name}: 3624 = {known[3624]:g}, 3621 = {low}, 3622 = {high} of {axis} make no"
            " table"
        )
    if known.get(3625, 0):
        raise TableError(
            f"{source.name}: 3625 of {axis} is {known[3625]:g}: a rotary axis, not read"
        )
    return step


def _numbers(listing: listings.Listing, axis: str, span: range, used: set[int]) -> list[int]:
    """The compensation numbers of an axis in a range, one after the other. Raises TableError for a
    gap, and for one that another axis has."""
    numbers = [n for n in sorted(listing.pitch) if n in span]
    for n in numbers:
        if listing.owner.get(n, axis) != axis or n in used:
            raise common.fault(
                listing.source,
                listing.line[n],
                f"compensation number {n} lies in the range of {axis} and of another axis",
            )
    whole = range(numbers[0], numbers[-1]) if numbers else range(0)
    for gap in (n for n in whole if n not in listing.pitch):
        raise common.fault(
            listing.source,
            listing.line[numbers[0]],
            f"{axis}: compensation number {gap} is missing between {numbers[0]} and {numbers[-1]}",
        )
    return numbers


def _sums(
    numbers: list[int], increments: list[int], first: int, unit: float, offset: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points counted from the reference, and what is added there, mm: the running sum, `offset` at
    the reference."""
    if not numbers:
        return np.zeros(0), np.array([offset])
    #     point     n-1          n         n+1
    #     number         K_n        K_n+1            the increment between the points n-1 and n
    # One point more than there are numbers; 0 is the reference.
    points = np.arange(numbers[0] - 1, numbers[-1] + 1) - first
    total = np.concatenate([[0.0], np.cumsum(increments)])
    return points.astype(float), (total - np.interp(0.0, points, total)) * unit + offset


def straightness(source: Source, options: ExportOptions) -> list[ErrorTable]:
    rows: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for at in common.numbered(source)[1:]:
        cells = [c.strip() for c in at.text.split(",")]
        if len(cells) != 4 or not all(map(common.is_letter, cells[:2])):
            raise at.fault("not moving, compensated, position and increment", "Z,X,20,-1")
        place, count = (at.finite(c, "the value") for c in cells[2:])
        known = rows.setdefault((cells[0].upper(), cells[1].upper()), [])
        if known and place <= known[-1][0]:
            raise at.fault(f"position {place:g} does not ascend after {known[-1][0]:g}")
        known.append((place, count))
    tables = []
    for (moving, along), pairs in rows.items():
        nodes, counts = np.array(pairs).T
        total = np.cumsum(counts)
        total -= np.interp(options.reference.get(moving, 0.0), nodes, total)
        tables.append(
            ErrorTable(moving, along, nodes, -total * options.step, -total * options.step)
        )
    return tables
