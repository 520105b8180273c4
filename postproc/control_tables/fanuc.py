"""Fanuc stored pitch error compensation: parameters 3620 to 3627, 1851, and the numbered
increments.

Number n is the increment between the points n-1 and n; point n stands at reference + (n - 3620) *
3624. Read from the - side to the +: what is added at a point is the running sum, zero at the
reference. Unit: detection unit times 3623. A positive increment is more travel in +, so -deviation
is written, by carry: K_n = round(c_n) - round(c_n-1), which keeps the running sum within half a
unit. 3621 = number of the reference - stroke in - / 3624 + 1. With 3605#0 the numbers from 3626 on
are for travel in -, and 3627 is what is added at the reference when it is reached from the other
side; without it 1851 is the backlash: added once at a reversal.

Source: 0i-PB parameter manual B-63980EN page 100 (numbering, increments, its example 33 to 49 is a
test), technical report A-77810E (both directions). General knowledge, so unverified in the output:
the sign (it agrees with one machine's table), the G10 lines, that the increments for travel in -
are read from the - side too, straightness.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from postproc.control_tables import ErrorTable, Export, ExportOptions, TableError
from postproc.control_tables import _common as common
from postproc.control_tables import _fanuc_listing as listings
from postproc.control_tables._fanuc_reading import pitch_table, straightness
from postproc.errors import UsageError
from postproc.recordings import Source
from postproc.units import UM

TITLE = "Fanuc stored pitch error compensation (3620-3627, 1851), and straightness as a list"
VERIFIED = True
UNVERIFIED = "the sign, and the lines of G10"
SIGN = "-deviation, as increments (sign unverified: from one machine's table)"
EXTRA = {
    "form": "l50 (G10 L50), l52 (G10 L52 and L50), records (N..P..) or csv; l50",
    "axes": "letters of the control's axes 1, 2, 3 in order, XYZ",
    "range_X": "3621:3622 of an axis, like 1:101",
    "negative_X": "3626 of an axis",
    "largest": "largest increment, 7 (127 at most)",
    "points": "points of one axis, 128",
    "return": "direction of the reference return, + or -; +",
    "span": "range (all numbers of 3621 to 3622) or map (only those that the map reaches); range",
    "rapid_backlash": "1852 in detection units, or same",
    "increment_mm": "mm of the unit of 3624",
    "program_number": "O number of the program, 7900",
}
LARGEST_NUMBER = 1023


def write(tables: list[ErrorTable], options: ExportOptions) -> Export:
    """Pitch tables in the form asked for, straightness beside it. Raises TableError where numbers
    do not suffice or an increment can not be held by any magnification."""
    form = common.setting(options, "form", "l50", ("l50", "l52", "records", "csv"))
    tables = common.checked(tables)
    notices: list[str] = []
    settings: dict[str, dict[int, float]] = {}
    pitch: dict[str, dict[int, int]] = {}
    shifts: dict[str, float] = {}
    free = 1
    # Numbers are shared by all axes, each its own range of them; `free` is the next that none has.
    for table in (t for t in tables if t.moving == t.along):
        known, numbers, shifts[table.name] = _axis(table, options, free, notices)
        settings[table.moving], pitch[table.moving] = known, numbers
        free = max(free, int(known[3622]), *numbers, 0) + 1
    files: dict[str, bytes] = {}
    back: list[ErrorTable] = []
    if settings:
        files, back = _files(settings, pitch, form, options, notices)
        _advice(settings, options, notices)
    if cross := [t for t in tables if t.moving != t.along]:
        name = f"{options.program}_straightness.csv"
        data = _straightness(cross, options, notices, shifts)
        files[name] = data
        back += straightness(Source(name, data), options)
    return Export(files, tuple(notices), common.remainder(tables, back, shifts))


@dataclass(frozen=True)
class _Points:
    """One axis on its even points. table: zero at the reference; by: mm that were taken off; step:
    mm between points; below: intervals on the - side of the reference; up, down: increments for
    travel in + and in -; opposite: 3627, detection units."""

    table: ErrorTable
    by: float
    step: float
    below: int
    magnification: int
    up: np.ndarray
    down: np.ndarray
    opposite: int


def _axis(
    table: ErrorTable, options: ExportOptions, free: int, notices: list[str]
) -> tuple[dict[int, float], dict[int, int], float]:
    """Parameters, compensation numbers, and the constant in mm that was taken off one axis."""
    axis = table.moving
    both = options.two_way and table.two_way
    points = _points(table, options, both, notices)
    #     number     free ... first | first+1 ...
    #     interval   below the      | above the reference, which is the point `first` (3620)
    first = options.first.get(axis, free + points.below - 1)
    number = first - points.below + 1
    low, high = _span(axis, options, first, range(number, number + len(points.up)), notices)
    zeros = range(0) if options.extra.get("span", "range") == "map" else range(low, high + 1)
    numbers = _numbered(zeros, number, points.up)
    known: dict[int, float] = {
        3620: first,
        3621: low,
        3622: high,
        3623: points.magnification,
        3624: round(points.step / listings.increment(options)),
        3625: 0,
        1851: 0 if both else round(common.play(table) / options.step),
    }
    if both and (not np.array_equal(points.up, points.down) or points.opposite):
        start = _reverse_start(axis, options, low, high)
        numbers |= _numbered(zeros, number, points.down, start - low)
        known |= {3605: 1, 3626: start, 3627: points.opposite}
        if points.magnification > 1:
            notices.append(
                f"unverified: 3627 of {axis} is written in detection units, not times 3623"
            )
    if options.extra.get("rapid_backlash") == "same":
        known[1852] = known[1851]
    elif "rapid_backlash" in options.extra:
        known[1852] = common.whole(options, "rapid_backlash", 0, -9999, 9999)
    return known, numbers, points.by


def _numbered(zeros: range, number: int, increments: np.ndarray, shift: int = 0) -> dict[int, int]:
    """Compensation numbers with their increments, the first at `number` + `shift`, and 0 elsewhere
    in the range."""
    filled = {number + shift + i: int(k) for i, k in enumerate(increments)}
    return {n + shift: 0 for n in zeros} | filled


def _reverse_start(axis: str, options: ExportOptions, low: int, high: int) -> int:
    """3626. Raises TableError where the numbers for travel in - do not fit beside those for +."""
    start = common.whole(options, f"negative_{axis}", high + 1, 0, LARGEST_NUMBER)
    if start + high - low > LARGEST_NUMBER or low <= start <= high:
        raise TableError(
            f"{axis}: numbers from {start} on for travel in - overlap, or end beyond"
            f" {LARGEST_NUMBER}",
            f"--set negative_{axis}=N",
        )
    return start


def _points(table: ErrorTable, options: ExportOptions, both: bool, notices: list[str]) -> _Points:
    """The axis on even points. Where no spacing is asked for, it is halved before a magnification
    is used: that halves the increments, and keeps the running sum within half a detection unit."""
    home = common.reference(table, options, notices)
    way = common.sign(options, "return", "+") if both else 0.0
    whole = common.sampled(table, np.union1d(table.nodes, [home]))
    chosen = whole if both else common.mean(whole)
    most = common.whole(options, "points", 128, 2, LARGEST_NUMBER)
    small = listings.increment(options)
    spacing = options.spacing
    # The spacing that the nodes ask for; where that needs a magnification, half of it, as long as
    # the points suffice and the step is a whole number of increments.
    while True:
        even = common.even(chosen, replace(options, spacing=spacing), home, most + 1, small)
        noticed: list[str] = []
        even, by = common.zeroed(even, home, way, noticed)
        step = _step(even, options)
        magnification, up, down = _increments(even, options, home, way)
        spacing = step / 2
        halves = abs(spacing / small - round(spacing / small)) <= 1e-6 and 2 * len(up) <= most
        if magnification == 1 or options.spacing or not halves:
            break
    notices += noticed
    if magnification > 1:
        notices.append(
            f"{even.name}: 3623 = {magnification} keeps the increments within"
            f" {options.extra.get('largest', '7')}, so the table is in steps of"
            f" {options.step * magnification / UM:g} um; --set largest=127 if the control takes"
            " that, or a smaller --spacing"
        )
    below = round((home - float(even.nodes[0])) / step)
    opposite = _opposite(even, options, home, way)
    return _Points(even, by, step, below, magnification, up, down, opposite)


def _step(even: ErrorTable, options: ExportOptions) -> float:
    """mm from point to point; of a lone one what was asked for."""
    if len(even.nodes) > 1:
        return float(even.nodes[1] - even.nodes[0])
    return options.spacing or 20.0


def _increments(
    even: ErrorTable, options: ExportOptions, home: float, way: float
) -> tuple[int, np.ndarray, np.ndarray]:
    """The magnification, and the increments for travel in + and in -: the differences of rounded
    running sums, each counted from what is added at the reference (0, or 3627)."""
    starts = [
        0.0 if direction * way >= 0 else _opposite(even, options, home, way) * options.step
        for direction in (1.0, -1.0)
    ]
    bound = common.whole(options, "largest", 7, 1, 127)
    for magnification in range(1, 101):
        unit = options.step * magnification
        # Sums are rounded and then differenced: rounded increments would add up their errors along
        # the travel.
        added = (-even.forward - starts[0], -even.reverse - starts[1])
        up, down = (np.diff(np.rint(v / unit)).astype(int) for v in added)
        worst = max(np.abs(up).max(initial=0), np.abs(down).max(initial=0))
        if worst <= bound:
            return magnification, up, down
    raise TableError(
        f"{even.name} changes by more than {bound} x 100 detection units between two points",
        "a smaller --spacing, or --step",
    )


def _opposite(even: ErrorTable, options: ExportOptions, home: float, way: float) -> int:
    """3627 in detection units: what is added at the reference when it is reached from the other
    side."""
    # by the other side's curve, whose own sum does not begin at zero there
    return round(-float(even.at(np.array([home]), -way)[0]) / options.step)


def _span(
    axis: str, options: ExportOptions, first: int, needed: range, notices: list[str]
) -> tuple[int, int]:
    """3621 and 3622 of an axis that needs a range of numbers; first: 3620. Raises TableError where
    there are none such."""
    low, high = needed.start, needed.stop - 1
    if f"range_{axis}" in options.extra:
        low, high = _range(axis, options, low, high)
    elif axis not in options.first:
        notices.append(
            f"{axis}: numbers {low} to {high} were chosen, the reference is {first}: make sure they"
            f" are free (--first {axis}={first})"
        )
    if low < 0 or high > LARGEST_NUMBER:
        raise TableError(
            f"{axis} needs the numbers {low} to {high}, and there are 0 to {LARGEST_NUMBER}",
            f"--first {axis}=N for another reference number",
        )
    return low, high


def _range(axis: str, options: ExportOptions, low: int, high: int) -> tuple[int, int]:
    words = options.extra[f"range_{axis}"].split(":")
    if len(words) != 2 or not all(w.isdigit() for w in words):
        raise UsageError(
            f"range_{axis} = {options.extra[f'range_{axis}']!r} is not two numbers",
            f"--set range_{axis}={low}:{high}",
        )
    first, last = int(words[0]), int(words[1])
    if high >= low and not (first <= low and high <= last):
        raise TableError(
            f"{axis} needs the numbers {low} to {high}, and range_{axis} is {first} to {last}",
            f"--set range_{axis}={low}:{high}",
        )
    return first, last


def _files(
    settings: dict[str, dict[int, float]],
    pitch: dict[str, dict[int, int]],
    form: str,
    options: ExportOptions,
    notices: list[str],
) -> tuple[dict[str, bytes], list[ErrorTable]]:
    """The files of a form, and what their numbers do when read back."""
    name = options.program
    said = {t.split(":", 1)[1].strip() for t in notices if t.startswith("unverified")}
    notices.append(
        "unverified: the sign (a positive number is more travel in +); enter one number, and look"
        " with a gauge"
    )
    if form == "csv":
        files = listings.csv_files(settings, pitch, name)
        noticed = replace(
            options, extra={**options.extra, "settings": files[f"{name}_settings.csv"].decode()}
        )
        return files, read(Source(f"{name}_pitch.csv", files[f"{name}_pitch.csv"]), noticed)
    if missing := [axis for axis in settings if axis not in listings.axis_order(options)]:
        raise UsageError(
            f"which axis number has {missing[0]}?",
            "--set axes=XZ: the letters in the control's order",
        )
    if form == "records":
        file, data = f"{name}_fanuc.txt", listings.records(settings, pitch, options)
    else:
        notices.append(
            "unverified: G10 L50 and L52 lines are from general knowledge; axes are numbered"
            f" {listings.axis_order(options)}"
        )
        comments = [
            "gcomp pitch error compensation",
            "unverified: sign, and the lines of G10",
            *sorted(said),
        ]
        file, data = f"{name}_fanuc.nc", listings.g10(settings, pitch, comments, options, form)
    return {file: data}, read(Source(file, data), options)


def _advice(
    settings: dict[str, dict[int, float]], options: ExportOptions, notices: list[str]
) -> None:
    if any(3605 in known for known in settings.values()):
        notices.append(
            "set 3605#0 = 1 by hand (its other bits are not known here); it is an option of the"
            " control; then 1851 is 0"
        )
        notices.append(
            "unverified: increments for travel in - are taken as read from the - side, like those"
            " for travel in +"
        )
    if any(known[1851] for known in settings.values()):
        notices.append(
            "1851 is the backlash; 1852 (rapid) counts where 1800#4 is 1: --set rapid_backlash=same"
            " writes it too"
        )
    spacing = min(known[3624] for known in settings.values()) * listings.increment(options)
    notices.append(
        f"an interval of {spacing:g} mm is enough up to about {spacing * 7500:g} mm/min (general"
        " knowledge)"
    )
    notices.append(
        "clear what stood in these numbers, write, switch the control off and on, and return to the"
        " reference"
    )


def read(source: Source, options: ExportOptions) -> list[ErrorTable]:
    """What the numbers take out: a table per axis. CSV needs its settings in
    options.extra["settings"], or in the same file.

    Raises TableError with file and line for numbers outside the ranges of all axes, gaps, or
    missing parameters.
    """
    if source.data.lstrip().lower().startswith(b"moving,"):
        return straightness(source, options)
    listing = listings.parse(source, options)
    if not listing.settings:
        raise TableError(
            f"{source.name} has no parameters 3620 to 3624",
            "they are in another file: --settings FILE (parameter_no,meaning,x,y,z)",
        )
    used: set[int] = set()
    tables = [
        t
        for axis in listing.settings
        if (t := pitch_table(listing, axis, options, used)) is not None
    ]
    for number, line in listing.line.items():
        if number not in used:
            ranges = ", ".join(
                f"{a} {s.get(3621, 0):g} to {s.get(3622, 0):g}" for a, s in listing.settings.items()
            )
            raise common.fault(
                source,
                line,
                f"compensation number {number} is of no axis",
                f"ranges by 3621 and 3622: {ranges}",
            )
    return tables


def _straightness(
    cross: list[ErrorTable], options: ExportOptions, notices: list[str], shifts: dict[str, float]
) -> bytes:
    """moving,compensated,position_mm,increment: increments like those of a pitch table, zero at the
    reference."""
    notices.append(
        "unverified: straightness is written as a list; where the control holds it (5711 on, or its"
        " 128 points) is yours to enter"
    )
    lines = ["moving,compensated,position_mm,increment"]
    for table in cross:
        most = common.whole(options, "points", 128, 2, 1023) + 1
        even, shifts[table.name] = common.even_mean(table, options, most, notices)
        counts = np.rint(-even.forward / options.step).astype(int)
        rows = zip(even.nodes, np.diff(counts, prepend=counts[0]), strict=True)
        lines += [f"{table.moving},{table.along},{position:.10g},{k}" for position, k in rows]
        if table.two_way:
            notices.append(f"{table.name}: the mean of both directions is written")
    return common.text_of(lines)
