"""A sheet of an .xlsx workbook as tab-separated text, so that every reader of tables reads it.

Row n of the sheet is line n of the text: messages name the row that a person sees. Numbers stay as
the file holds them, dates and times become ISO 8601 (ECMA-376: shared strings, cell types s,
inlineStr, str, n; number formats 14 to 22 and 45 to 47, and own ones with d, y, h or s, are times).
Formulas are read by the values that the spreadsheet has saved beside them.
"""

from __future__ import annotations

import datetime
import io
import re
import zipfile
import zlib
from collections.abc import Iterator
from xml.etree import ElementTree

from postproc import intake
from postproc.errors import GcompError, Place, UsageError

# What of the archive is read:
#
#     xl/workbook.xml             sheet: name, r:id; date1904
#     xl/_rels/workbook.xml.rels  r:id -> xl/worksheets/sheet1.xml
#     xl/worksheets/sheet1.xml    worksheet > sheetData > row r="3" > c r="B3" t="s" s="1" > v
#     xl/sharedStrings.xml        sst > si: t="s" counts them from 0
#     xl/styles.xml               cellXfs: s counts them from 0, numFmtId says whether it is a time
MAGIC = b"PK\x03\x04"
MOST_ROWS = 1 << 20  # rows of a sheet, by the format
WIDEST = 1 << 14  # columns
MOST_ELEMENTS = 8 * WIDEST  # of a row: a cell holds a value, or a text of a few runs
MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
RELATION = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
BROKEN = (  # what zipfile, zlib and the XML parser say of damage, and what a part says that is none
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    ElementTree.ParseError,
    KeyError,
    ValueError,
    IndexError,
    OverflowError,
    NotImplementedError,
    RuntimeError,
)
TIMES = {*range(14, 23), 45, 46, 47}
LONG = re.compile(r"-?[0-9.]+[eE][-+]?[0-9]+|-?[0-9]+\.[0-9]{12,}")
CELL = re.compile(r"([A-Z]{1,3})([0-9]{1,7})")


def is_workbook(data: bytes) -> bool:
    """Whether the bytes are a zip archive that names parts of a workbook."""
    return data.startswith(MAGIC) and b"xl/" in data


def as_text(data: bytes, name: str, sheet: str, error: type[GcompError]) -> str:
    """The sheet that is named, or the only one that holds numbers. name: of the file, in messages.
    Raises `error` for damage, UsageError for a sheet that is not there."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as book:
            every = _sheets(book)
            if sheet and sheet not in every:
                raise UsageError(
                    f"{name} has no sheet {sheet!r}", f"its sheets: {', '.join(every)}"
                )
            parts = {sheet: every[sheet]} if sheet else every
            strings, times, first = _strings(book), _times(book), _first_day(book)
            texts = {k: _text(book, part, strings, times, first) for k, part in parts.items()}
    except BROKEN as fault:
        raise error(
            f"this is no workbook that can be read ({fault})",
            "save it as .xlsx again, or as CSV",
            Place(name, 1),
        ) from None
    return texts[sheet] if sheet else _only_filled(texts, name, error)


def _only_filled(texts: dict[str, str], name: str, error: type[GcompError]) -> str:
    """The one sheet that holds numbers. Raises `error` for none, or several."""
    filled = {name: t for name, t in texts.items() if re.search(r"(?m)(^|\t)-?[0-9.]+(\t|$)", t)}
    if len(filled) != 1:
        what = "no sheet holds numbers" if not filled else f"{len(filled)} sheets hold numbers"
        advice = f"say which: --sheet {next(iter(filled or texts))!r}" if texts else ""
        raise error(what, advice, Place(name, 1))
    return next(iter(filled.values()))


def _bytes(book: zipfile.ZipFile, name: str, most: int) -> bytes:
    """A part, unpacked. Raises ValueError for one of more than `most` bytes, or with entities."""
    # The size is what the archive says; zipfile unpacks no more than that.
    if book.getinfo(name).file_size > most:
        raise ValueError(f"{name} has more than {most:,} bytes")
    data = book.read(name)
    # Entities that hold each other grow a few bytes to gigabytes when they are read.
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise ValueError(f"{name} declares entities, which no spreadsheet does")
    return data


def _part(book: zipfile.ZipFile, name: str) -> ElementTree.Element:
    return ElementTree.fromstring(_bytes(book, name, intake.WORKBOOK_PART))


def _each(book: zipfile.ZipFile, name: str, tag: str, depth: int) -> Iterator[ElementTree.Element]:
    """The elements called `tag`, below `depth` others, of a long part, one by one: memory holds one
    of them. Raises ValueError for one with more elements in it than a row has."""
    data, above, held = io.BytesIO(_bytes(book, name, intake.WORKBOOK)), [], 0
    for event, element in ElementTree.iterparse(data, ("start", "end")):
        if event == "start":
            above.append(element)
            held += 1
            if held > MOST_ELEMENTS:
                raise ValueError(f"a row of {name} has more than {MOST_ELEMENTS:,} elements")
            continue
        above.pop()
        if element.tag == MAIN + tag:
            yield element
        # What is read is forgotten with its row: all elements of a long sheet fill the memory.
        if len(above) <= depth:
            held = 0
            for parent in above:
                parent.clear()


def _sheets(book: zipfile.ZipFile) -> dict[str, str]:
    """Name of each worksheet to its part."""
    relations = {
        r.get("Id"): str(r.get("Target")) for r in _part(book, "xl/_rels/workbook.xml.rels")
    }
    found = {}
    for sheet in _part(book, "xl/workbook.xml").iter(f"{MAIN}sheet"):
        target = relations[sheet.get(RELATION)]
        part = target.lstrip("/") if target.startswith("/") else f"xl/{target}"
        if "chartsheet" not in part:
            found[str(sheet.get("name"))] = part
    return found


def _strings(book: zipfile.ZipFile) -> list[str]:
    if "xl/sharedStrings.xml" not in book.namelist():
        return []
    return [_joined(item) for item in _each(book, "xl/sharedStrings.xml", "si", 1)]


def _joined(item: ElementTree.Element) -> str:
    """The text of a string, without its phonetic runs."""
    texts = item.findall(f"{MAIN}t") + item.findall(f"{MAIN}r/{MAIN}t")
    return "".join(t.text or "" for t in texts)


def _times(book: zipfile.ZipFile) -> list[bool]:
    """Whether each cell style shows a number as a date or time."""
    if "xl/styles.xml" not in book.namelist():
        return []
    root = _part(book, "xl/styles.xml")
    own = {
        int(f.get("numFmtId", "0")): re.sub(
            r'"[^"]*"|\\.|\[(?!h|m|s)[^\]]*\]', "", str(f.get("formatCode", ""))
        )
        for f in root.iter(f"{MAIN}numFmt")
    }
    cells = root.find(f"{MAIN}cellXfs")
    kinds = [int(xf.get("numFmtId", "0")) for xf in cells] if cells is not None else []
    return [k in TIMES or bool(re.search(r"[dyhs]", own.get(k, ""), re.I)) for k in kinds]


def _first_day(book: zipfile.ZipFile) -> datetime.datetime:
    """Day 0 of the workbook's dates: 30 December 1899 makes all days from March 1900 right."""
    setting = _part(book, "xl/workbook.xml").find(f"{MAIN}workbookPr")
    since_1904 = setting is not None and setting.get("date1904") in ("1", "true")
    return datetime.datetime(1904, 1, 1) if since_1904 else datetime.datetime(1899, 12, 30)


def _text(book, part: str, strings: list[str], times: list[bool], first: datetime.datetime) -> str:
    lines: list[str] = []
    for number, cells in _rows(_each(book, part, "row", 2)):
        if number > MOST_ROWS or number <= len(lines):
            raise ValueError(f"row {number} is out of order")
        lines += [""] * (number - len(lines) - 1)
        row: list[str] = []
        for k, (reference, cell) in enumerate(cells):
            at = _column(reference) if reference else k
            if not len(row) <= at < WIDEST:
                raise ValueError(f"the cell {reference} is out of order")
            row += [""] * (at - len(row))
            row.append(" ".join(_value(cell, strings, times, first).split()))
        lines.append("\t".join(row))
    return "\n".join(lines) + "\n"


def _rows(
    rows: Iterator[ElementTree.Element],
) -> Iterator[tuple[int, list[tuple[str, ElementTree.Element]]]]:
    number = 0
    for row in rows:
        number = int(row.get("r", str(number + 1)))
        yield number, [(str(c.get("r", "")), c) for c in row.iter(f"{MAIN}c")]


def _column(reference: str) -> int:
    found = CELL.fullmatch(reference)
    if not found:
        raise ValueError(f"{reference!r} is no cell")
    at = 0
    for letter in found[1]:
        at = at * 26 + ord(letter) - 64
    return at - 1


def _value(
    cell: ElementTree.Element, strings: list[str], times: list[bool], first: datetime.datetime
) -> str:
    kind = cell.get("t", "n")
    if kind == "inlineStr":
        inline = cell.find(f"{MAIN}is")
        return "" if inline is None else _joined(inline)
    value = cell.findtext(f"{MAIN}v", "")
    if kind == "s" and value:
        return strings[int(value)]
    if kind != "n" or not value:
        return value
    style = int(cell.get("s", "0"))
    if any(times[style : style + 1]):
        # days since day 0, of which a float64 holds about a microsecond: rounded to a millisecond
        moment = first + datetime.timedelta(milliseconds=round(float(value) * 86_400_000))
        return moment.isoformat(timespec="milliseconds" if moment.microsecond else "auto")
    if LONG.fullmatch(value):
        return f"{float(value):.12g}"  # binary fractions are saved with all their digits
    return value
