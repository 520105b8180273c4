"""A wide table of a six-degree-of-freedom instrument: one axis moves, and all of its errors are
read at once.

Header X_mm, then any of EXX_um EYX_um EZX_um EAX_urad EBX_urad ECX_urad (also _arcsec), and where
known run, approach (+1, -1), t_s, the other axes' places (Y_mm) and temperatures (T_screw_X_C).
Each component becomes a recording. A column that is none of these is named in a notice.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from postproc import intake
from postproc.errors import Place, UsageError
from postproc.recordings import ReadingOptions, Recording, RecordingError, Source
from postproc.recordings import _text as text
from postproc.units import URAD

TITLE = "six degrees of freedom (X_mm,EXX_um,EYX_um,EZX_um,EAX_urad,EBX_urad,ECX_urad)"
TAKES = ("component", "others", "machine", "head")
EXTRA = {"decimal": ". or ,: the decimal sign, where it is not clear"}
#     X_mm | EXX_um        EYX_um EZX_um    EAX_urad  EBX_urad  ECX_urad
#            positioning   straightness     roll      pitch     yaw
COMPONENT = re.compile(r"E([XYZABC])([XYZ])_(um|urad|arcsec)")
# Names that would be components in a unit that is not read
LIKE = re.compile(r"E[XYZABC][XYZABC](_.*)?", re.IGNORECASE)
OTHER = re.compile(r"run|t_s|setup|approach(_[XYZABC])?|[XYZ]_mm|[ABC]_deg|T_\w+_C")
FEWEST = 3  # components in one table: fewer are tables of other kinds
ARCSEC = np.pi / 648000 / URAD


def recognises(source: Source) -> bool:
    first = next(
        (
            line
            for line in source.data.lstrip(b"\xef\xbb\xbf").split(b"\n")
            if line.strip() and not line.startswith(b"#")
        ),
        b"",
    )
    cells = [c.strip().strip('"') for c in re.split(r"[,;\t]", first.decode("utf-8", "replace"))]
    return (
        sum(bool(COMPONENT.fullmatch(c)) for c in cells) >= FEWEST
        and f"{cells[0][:1]}_mm" == cells[0]
    )


def read(source: Source, options: ReadingOptions) -> Recording:
    """The component that --component names. Raises RecordingError where none is named, UsageError
    where there is none."""
    every = read_all(source, options)
    if len(every) == 1:
        return every[0]
    raise source.fault(1, f"the file holds {len(every)} components", "say which: --component EXX")


def _shared(
    names: list[str], values: np.ndarray, letter: str, options: ReadingOptions
) -> dict[str, np.ndarray]:
    """The columns that all components have. letter: of the axis that moves."""
    shared = {n: values[:, k] for k, n in enumerate(names) if not COMPONENT.fullmatch(n)}
    if "approach" in shared:
        shared[f"approach_{letter}"] = shared.pop("approach")
    return shared | {
        f"{x}_mm": np.full(len(values), v)
        for x, v in options.others.items()
        if x in "XYZ" and f"{x}_mm" not in shared
    }


def read_all(source: Source, options: ReadingOptions) -> list[Recording]:
    """A recording for each component, only one where --component names it."""
    names, values, lines, head_line = _table(source, options)
    letter, idle = names[0][0], _idle(names, Place(source.name, head_line))
    found = [(m, k) for k, n in enumerate(names) if (m := COMPONENT.fullmatch(n))]
    for column, _ in found:
        # EYX over Z_mm would be read as straightness of Z
        if column[2] != letter:
            raise source.fault(
                head_line,
                f"{column[0]} is no error of {letter}, which moves",
                "one axis in each file",
            )
    shared = _shared(names, values, letter, options)
    wanted = options.component.upper()
    out = []
    for m, k in found:
        if wanted in ("", f"E{m[1]}{letter}"):
            head, reading = _component(source, options, m, head_line, values[:, k])
            columns = shared | reading
            out.append(Recording("targets", head, columns, source.name, lines, notices=idle))
    if not out:
        raise UsageError(
            f"{source.name} holds no {options.component}",
            f"it holds {', '.join(f'E{m[1]}{letter}' for m, _ in found)}",
        )
    return out


def _component(
    source: Source, options: ReadingOptions, column: re.Match[str], line: int, values: np.ndarray
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Head and reading of one component: direction, axis and unit are those of its column."""
    direction, letter, unit = column.groups()
    name, angle = f"E{direction}{letter}", direction in "ABC"
    if angle == (unit == "um"):
        raise source.fault(
            line,
            f"{column[0]}: {name} is {'an angle' if angle else 'a length'}",
            "urad, arcsec, or um",
        )
    quantity = "angle" if angle else "displacement" if direction == letter else "straightness"
    head = {
        "instrument": "six degrees of freedom",
        "quantity": quantity,
        # an angle's is the axis that it is about
        "sensitive": {"XYZ"["ABC".index(direction)] if angle else direction: 1.0},
        **options.head,
    }
    if options.machine:
        head["machine"] = options.machine
    scaled = values * (ARCSEC if unit == "arcsec" else 1.0)
    return head, {"reading_urad" if angle else "reading_um": scaled}


def _idle(names: list[str], place: Place) -> tuple[str, ...]:
    """A notice for columns that say nothing here. Raises RecordingError for a name that stands
    twice, and for a component that is not in a unit of these."""
    for name in names:
        if names.count(name) > 1:
            raise RecordingError(f"the column {name!r} stands twice", "one of them", place)
        if LIKE.fullmatch(name) and not COMPONENT.fullmatch(name):
            raise RecordingError(
                f"{name} is no column of a six-degree-of-freedom table",
                "lengths like EYX_um, angles like EAX_urad or EAX_arcsec: the unit stands behind",
                place,
            )
    idle = [n for n in names if not COMPONENT.fullmatch(n) and not OTHER.fullmatch(n)]
    return (f"columns that nothing here reads: {', '.join(idle)}",) if idle else ()


def _table(
    source: Source, options: ReadingOptions
) -> tuple[list[str], np.ndarray, np.ndarray, int]:
    """Names, (N, C) numbers, (N,) the line of each row, and that of the names. Raises
    RecordingError with the line."""
    content, _ = text.decoded(source)
    kept = "\n".join("" if line.startswith("#") else line for line in intake.lines_of(content))
    table = text.table(source, kept, text.stated_decimal(options.extra))
    head_line, names = table.rows[0]
    rows, lines = [], []
    for number, cells in table.rows[1:]:
        place = Place(source.name, number, table.delimiter.join(cells))
        if len(cells) != len(names):
            raise RecordingError(
                f"{len(cells)} cells under {len(names)} columns",
                "a value is missing or one too many",
                place,
            )
        row = [text.number(cell, table.decimal) for cell in cells]
        if None in row:
            raise RecordingError(
                f"{names[row.index(None)]} {cells[row.index(None)]!r} is not a number",
                "a number in every cell",
                place,
            )
        rows.append([float(v) for v in row if v is not None])
        lines.append(number)
    if not rows:
        raise source.fault(1, "there are no rows")
    return names, np.array(rows), np.array(lines), head_line
