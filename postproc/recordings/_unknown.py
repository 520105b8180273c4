"""What to say of a file that looks like no recording: of what it nearly is, and of what it is
instead."""

from __future__ import annotations

import re

from postproc import intake
from postproc.recordings import RecordingError, Source, _sheet, contract
from postproc.recordings import _text as text

# A file's first bytes, what else it holds, and what it is.
OTHERS = (
    (b"PK\x03\x04", b"opendocument", "an OpenDocument file"),
    (b"PK\x03\x04", b"", "an archive, and no .xlsx workbook"),
    (b"\xd0\xcf\x11\xe0", b"", "a workbook of an old kind (.xls)"),
    (b"%PDF", b"", "a PDF"),
)
ERRORS = re.compile(r"E[XYZABC][XYZABC](?:_um|_urad)?(?:_fwd|_rev)?")  # of a machine's own table
TIME = re.compile(r"t|t_s|(?:time|zeit|date|datum|stamp)\b.*|timestamp.*", re.I)
OWN = re.compile(r"(?:reading_um|reading_urad|radial_um|[XYZABC]_(?:cmd_)?(?:mm|deg))")


def fault(source: Source, formats: list[str]) -> RecordingError:
    """What to raise. formats: names of those that there are."""
    for begin, holds, what in OTHERS:
        if source.data.startswith(begin) and holds in source.data:
            return source.fault(1, f"this is {what}", "save the table as CSV, or as .xlsx")
    try:
        content, _ = text.decoded(source)
        found = _near_own(source, content) or _a_sheet(source, content)
    except RecordingError:
        found = None
    return found or source.fault(
        1,
        "this looks like no recording that gcomp knows",
        f"formats: {', '.join(formats)}; a table of your own needs its columns named, like --column"
        " Z_mm=NAME --column reading_um=NAME",
    )


def _near_own(source: Source, content: str) -> RecordingError | None:
    """Of gcomp's own formats: a recording with its head changed or gone, a table of errors."""
    lines = intake.lines_of(content)
    names = [name.strip() for name in re.split(r"[,;\t]", lines[0])]
    if errors := [name for name in names if ERRORS.fullmatch(name)]:
        return source.fault(
            1,
            f"a table of a machine's errors ({', '.join(errors[:6])}), and no recording",
            "gcomp machines show FOLDER draws it; a recording is what an instrument has read",
        )
    for number, line in enumerate(lines[:200], 1):
        if contract.FORMAT in line:
            if source.data.startswith(tuple(text.BOMS)):
                return source.fault(
                    number, "a gcomp recording, stored as UTF-16", "save it as UTF-8"
                )
            return source.fault(
                number,
                f"{contract.FORMAT} is named here, and the head is not one",
                f'it begins with # format = "{contract.FORMAT}", as UTF-8, and each of its lines'
                " with #: no quotes around a line, no cells behind it",
            )
    own = [name for name in names if OWN.fullmatch(name)]
    if len(own) < 2:
        return None
    return source.fault(
        1,
        f"{', '.join(own)} are columns of gcomp's own format, and its head is missing",
        f'above them: # format = "{contract.FORMAT}", # kind = "targets", # sensitive ='
        " { Z = 1.0 } (docs/RECORDING.md)",
    )


def _a_sheet(source: Source, content: str) -> RecordingError | None:
    """A table of targets and readings whose headings leave the directions open."""
    sheet = _sheet.find(source, text.table(source, content))
    if len(sheet.columns) < 2 or len(sheet.rows) < 2:
        return None
    if any(TIME.fullmatch(title) for title in sheet.headings):  # the log of something
        return None
    titles = ", ".join(column.title for column in sheet.columns[:6])
    return source.fault(
        sheet.line,
        f"a table of targets and of {len(sheet.columns)} columns of readings ({titles}), whose"
        " headings do not say which way each went",
        "--layout interleaved (up 1, down 1, up 2 ...) or --layout blocks, with --axis and --unit;"
        " or by name: --column Z_mm=NAME --column forward1_um=NAME --column reverse1_um=NAME",
    )
