"""LinuxCNC's screw compensation file (COMP_FILE) as a recording of what it says the axis' deviation
is.

Three numbers a line: nominal, forward, reverse. COMP_FILE_TYPE 0: forward and reverse are actual
positions; other types: trims, which are minus the deviation. Reading stops at the first line
without three numbers. Units are the machine's. Neither type nor unit is in the file. Source:
LinuxCNC's usrmotintf.
"""

from __future__ import annotations

from collections.abc import Iterator

from postproc import intake
from postproc.errors import Place, UsageError
from postproc.recordings import ReadingOptions, Recording, RecordingError, Source
from postproc.recordings import _components as components
from postproc.recordings import _targets as targets
from postproc.recordings import _text as text
from postproc.recordings import _units as units
from postproc.units import MM_PER_INCH

TITLE = "LinuxCNC screw compensation (COMP_FILE, types 0 and 1)"
TAKES = ("axis", "component", "unit", "others", "machine", "head")
EXTRA = {"type": "0: actual positions, 1: trims, as COMP_FILE_TYPE in the INI file says"}
ENTRIES = 256
FARTHEST = 5.0  # mm: a larger deviation is a file of the other type or unit
UNITS = {"mm": 1.0, "inch": MM_PER_INCH}


def recognises(source: Source) -> bool:
    lines = [line.split() for line in source.data[:4000].split(b"\n")[:20] if line.strip()]
    whole = lines if len(source.data) <= 4000 else lines[:-1]
    return len(whole) > 1 and all(
        len(words) == 3
        and all(text.number(w.decode("ascii", "replace")) is not None for w in words)
        for words in whole
    )


def read(source: Source, options: ReadingOptions) -> Recording:
    """Run 1 forward, run 2 reverse. Raises RecordingError where LinuxCNC would stop reading, and
    where type, unit or axis are open."""
    kind = options.extra.get("type", "")
    if kind not in ("", "0", "1"):
        raise UsageError(f"--set type={kind} is not known", "0 or 1, as COMP_FILE_TYPE says")
    rows = _rows(source)
    first = Place(source.name, 1)
    if not kind:
        # over the whole table: actual positions go with the nominal ones, trims do not
        slope = abs(rows[-1][2] - rows[0][2]) / max(abs(rows[-1][1] - rows[0][1]), 1e-9)
        hint = (
            "the columns follow the nominal one: they look like type 0"
            if abs(slope - 1) < 0.1
            else "they look like type 1"
        )
        raise RecordingError(
            "the file does not say of which type it is",
            f"say --set type=0 or --set type=1 ({hint})",
            first,
        )
    component = components.component_of(options, source, _axis(source), "displacement")
    if component.axis not in "XYZ":
        raise UsageError(f"{component.axis} is a rotary axis", "COMP_FILE is read for X, Y and Z")
    if not options.unit:
        raise RecordingError(
            "the file does not say its unit, which is the machine's",
            "say --unit mm or --unit inch",
            first,
        )
    unit = units.named(options.unit)
    if unit.name not in UNITS:
        raise UsageError(f"--unit {options.unit}: a machine's unit is mm or inch")
    readings = targets.Readings.of(_readings(source, rows, kind, UNITS[unit.name]))
    notices = [
        "these are a control's corrections, not readings: their scatter and their zero are not"
        " known"
    ]
    head = {"instrument": f"LinuxCNC compensation file, type {kind}"}
    return targets.recording(source, options, component, unit, readings, head=head, notices=notices)


def _axis(source: Source) -> str:
    """The letter of a file named like Z.comp, or nothing."""
    stem = source.name.replace("\\", "/").rpartition("/")[2].partition(".")[0]
    return stem.upper() if len(stem) == 1 and stem.upper() in "XYZ" else ""


def _readings(
    source: Source, rows: list[tuple[int, float, float, float]], kind: str, scale: float
) -> Iterator[tuple[int, float, float, int, int]]:
    """Run, target in mm, deviation in the file's unit, line and direction. scale: mm of a unit.
    Raises RecordingError for what is no deviation of a screw."""
    #     nominal  forward  reverse
    #     100.0    100.012  100.009      type 0: deviation = entry - nominal = +0.012
    #     100.0    -0.012   -0.009       type 1: deviation = -entry
    for run, sign, column in ((1, 1, 2), (2, -1, 3)):
        for row in rows:
            line, nominal, entry = int(row[0]), row[1], row[column]
            deviation = entry - nominal if kind == "0" else -entry
            if abs(deviation) * scale > FARTHEST:
                raise source.fault(
                    line,
                    f"a deviation of {deviation * scale:g} mm is no screw's: is this type"
                    f" {1 - int(kind)}, or another unit?",
                    f"--set type={1 - int(kind)}",
                )
            yield run, nominal * scale, deviation, line, sign


def _rows(source: Source) -> list[tuple[int, float, float, float]]:
    """Line, nominal, forward, reverse."""
    content, _ = text.decoded(source)
    lines = intake.lines_of(content.rstrip())
    rows: list[tuple[int, float, float, float]] = []
    for i, line in enumerate(lines, 1):
        values = [v for v in map(text.number, line.split()[:3]) if v is not None]
        if len(values) < 3:
            raise source.fault(
                i,
                f"this line has no three numbers: LinuxCNC stops reading here, and {len(lines) - i}"
                " lines below are never used",
                "take out headings, comments and blank lines",
                line,
            )
        nominal, forward, reverse = values
        if rows and nominal <= rows[-1][1]:
            raise source.fault(
                i,
                f"nominal {nominal:g} comes after {rows[-1][1]:g}: LinuxCNC refuses it",
                "order them, each once",
                line,
            )
        if len(rows) == ENTRIES:
            raise source.fault(
                i, f"this is entry {ENTRIES + 1}: LinuxCNC holds {ENTRIES}", "", line
            )
        rows.append((i, nominal, forward, reverse))
    if len(rows) < 2:
        raise source.fault(1, f"there are {len(rows)} entries", "two at least make a table")
    return rows
