"""Workbooks (.xlsx) as a spreadsheet saves them, written here part by part from ECMA-376;
halscope's logs; long tables."""

from __future__ import annotations

import io
import zipfile
from xml.sax.saxutils import escape

import numpy as np
import pytest
from pytest import approx

from postproc.errors import GcompError
from postproc.recordings import ReadingOptions, Source, contract, format_of, read

MAIN = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
LONG = [["Target (mm)", "Run", "Direction", "Deviation (µm)", "Time"]]
START = 45429.4381944444444  # 17 May 2024, 10:31, as a spreadsheet counts days
ROWS = [
    (1, "+", (0, 100, 200.1)),
    (1, "-", (200.1, 100, 0)),
    (2, "+", (0, 100, 200.1)),
    (2, "-", (200.1, 100, 0)),
]
FLAT = [(run, way, q) for run, way, qs in ROWS for q in qs]


def value(run, way, q) -> float:
    return round(0.01 * q - 0.3 * (way == "-") + 0.05 * run, 3)


def cell(at: str, what, strings: list[str], time: bool = False) -> str:
    if isinstance(what, str):
        strings.append(what)
        return f'<c r="{at}" t="s"><v>{len(strings) - 1}</v></c>'
    return f'<c r="{at}" s="1"><v>{what!r}</v></c>' if time else f'<c r="{at}"><v>{what!r}</v></c>'


def workbook(sheets: dict[str, list[list]], time: int = -1, **other: str) -> bytes:
    """An .xlsx; an empty row is not written, as spreadsheets do. time: the column that is shown as
    a time."""
    strings: list[str] = []
    parts = {}
    for k, rows in enumerate(sheets.values(), 1):
        lines = [
            f'<row r="{r}">'
            + "".join(
                cell(f"{chr(65 + j)}{r}", v, strings, j == time)
                for j, v in enumerate(row)
                if v is not None
            )
            + "</row>"
            for r, row in enumerate(rows, 1)
            if row
        ]
        parts[f"xl/worksheets/sheet{k}.xml"] = (
            f"<worksheet {MAIN}><sheetData>{''.join(lines)}</sheetData></worksheet>"
        )
    names = "".join(
        f'<sheet name="{n}" sheetId="{k}" r:id="r{k}"/>' for k, n in enumerate(sheets, 1)
    )
    parts["xl/workbook.xml"] = (
        f'<workbook {MAIN} xmlns:r="{OFFICE}"><sheets>{names}</sheets></workbook>'
    )
    relations = "".join(
        f'<Relationship Id="r{k}" Target="worksheets/sheet{k}.xml"/>'
        for k in range(1, len(sheets) + 1)
    )
    parts["xl/_rels/workbook.xml.rels"] = f"<Relationships>{relations}</Relationships>"
    items = "".join(f"<si><t>{escape(s)}</t></si>" for s in strings)
    parts["xl/sharedStrings.xml"] = f"<sst {MAIN}>{items}</sst>"
    formats = '<numFmts><numFmt numFmtId="170" formatCode="yyyy\\-mm\\-dd\\ hh:mm:ss"/></numFmts>'
    parts["xl/styles.xml"] = (
        f'<styleSheet {MAIN}>{formats}<cellXfs><xf numFmtId="0"/><xf'
        ' numFmtId="170"/></cellXfs></styleSheet>'
    )
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as book:
        for name, text in (parts | other).items():
            book.writestr(name, text)
    return file.getvalue()


def long_sheet() -> list[list]:
    rows = [
        [q, run, way, value(run, way, q), START + 7.5 * k / 86400]
        for k, (run, way, q) in enumerate(FLAT)
    ]
    return [["machine", "mill 7"], [], *LONG, *rows]


def test_a_long_sheet_with_dates():
    """Order and times as in the sheet; binary fractions come back as the decimals that were
    typed."""
    got = read(
        Source("z.xlsx", workbook({"Z": long_sheet()}, time=4)), options=ReadingOptions(axis="Z")
    )
    assert got.reading == approx([value(*row) * 1e-3 for row in FLAT], abs=1e-12)
    assert got.position("Z").tolist() == [q for *_, q in FLAT]
    assert got.approach("Z").tolist() == [1.0 if way == "+" else -1.0 for _, way, _ in FLAT]
    assert got.columns["t_s"] == approx(7.5 * np.arange(12), abs=1e-3)
    assert got.lines.tolist() == list(range(4, 16)) and got.head["machine"] == "mill 7"


def test_of_several_sheets_one_is_named():
    wide = [
        ["Position [mm]", "Up 1 [µm]", "Down 1 [µm]"],
        *([q, 0.02 * q, 0.02 * q - 1] for q in (0, 50, 100)),
    ]
    source = Source(
        "all.xlsx",
        workbook({"Z": long_sheet(), "notes": [["nothing", "here"]], "X axis": wide}, time=4),
    )
    got = read(source, options=ReadingOptions(axis="X", sheet="X axis"))
    assert format_of(source, ReadingOptions(sheet="X axis")) == "iso-spreadsheet"
    assert got.reading == approx([0, 1e-3, 2e-3, 1e-3, 0, -1e-3], abs=1e-12)
    for sheet, says in (("", "2 sheets hold numbers"), ("Y axis", "has no sheet 'Y axis'")):
        with pytest.raises(GcompError, match=says):
            read(source, options=ReadingOptions(axis="X", sheet=sheet))
    with pytest.raises(GcompError, match="is no workbook"):
        read(Source("z.csv", b"a,b\n1,2\n"), options=ReadingOptions(sheet="Z"))


def test_any_damage_ends_in_one_sentence():
    whole = workbook({"Z": long_sheet()}, time=4)
    rng = np.random.default_rng(3)
    damaged = [whole[:n] for n in (4, 40, 400, len(whole) - 10)]
    for _ in range(60):
        data = bytearray(whole)
        for at in rng.integers(0, len(data), 6):
            data[at] = rng.integers(0, 256)
        damaged.append(bytes(data))
    bombs = '<!DOCTYPE a [<!ENTITY b "c">]><worksheet/>'
    sheet = "xl/worksheets/sheet1.xml"
    damaged += [workbook({"Z": long_sheet()}, **{sheet: bombs})]
    damaged += [
        workbook(
            {"Z": long_sheet()},
            **{sheet: f'<worksheet {MAIN}><row r="{r}"><c r="{c}"><v>1</v></c></row></worksheet>'},
        )
        for r, c in (("9999999", "A1"), ("1", "ZZZ1"), ("1", "1A"), ("x", "A1"))
    ]
    refused = 0
    for data in damaged:
        try:
            read(Source("z.xlsx", data), options=ReadingOptions(axis="Z"))
        except GcompError:
            refused += 1
    assert refused > 20


# -- halscope --------------------------------------------------------------------------------------

LOG = "Sampling period is 1000000 ns \n" + "".join(
    f"\njoint.0.pos-cmd {1 + 0.1 * k:+.14f} joint.0.pos-fb {0.999 + 0.1 * k:+.14f}"
    " joint.1.motor-pos-cmd +2.00000000000000 joint.1.motor-pos-fb +2.00100000000000 spindle.0.on"
    " +1.00000000000000 "
    for k in range(5)
)
COMMA = LOG.replace("+1.", "+1,").replace("+0.", "+0,").replace("+2.", "+2,")


@pytest.mark.parametrize("text", [LOG, COMMA, LOG + "\njoint.0.pos-cmd +9.90000000000000 "])
def test_a_halscope_log_is_a_trace(text):
    """src/hal/utils/scope_files.c: period in ns, then a line a sample; the last one may stop short;
    a decimal comma."""
    source = Source("scope.log", text.encode())
    assert format_of(source) == "halscope"
    got = read(source, options=ReadingOptions(extra={"joints": "XZ"}))
    assert got.kind == "trace" and got.head["sees"] == "scale"
    assert got.columns["t_s"] == approx([0, 1e-3, 2e-3, 3e-3, 4e-3])
    assert got.columns["X_cmd_mm"] == approx([1.0, 1.1, 1.2, 1.3, 1.4])
    assert got.columns["X_act_mm"] == approx(got.columns["X_cmd_mm"] - 1e-3)
    assert got.columns["Z_act_mm"] == approx(2.001)
    back = contract.read(Source("again.csv", contract.write(got).encode()), ReadingOptions())
    assert back.columns["X_act_mm"] == approx(got.columns["X_act_mm"])


def test_pins_are_named_and_inches_are_said():
    source = Source("scope.log", LOG.encode())
    pins = {
        "Y_cmd_mm": "joint.0.pos-cmd",
        "Y_act_mm": "joint.0.pos-fb",
        "spindle_rpm": "spindle.0.on",
    }
    got = read(source, options=ReadingOptions(columns=pins, unit="inch"))
    assert got.columns["Y_cmd_mm"][0] == approx(25.4) and got.columns["spindle_rpm"][0] == 1.0
    assert not got.notices


@pytest.mark.parametrize(
    "options, says",
    [
        ({}, "is not said"),
        ({"extra": {"joints": "X?"}}, "is not like XYZ"),
        ({"columns": {"X_cmd_mm": "joint.7.pos-cmd"}}, "has no pin joint.7.pos-cmd"),
        ({"columns": {"X_cmd_mm": "joint.0.pos-cmd"}}, "an axis' command and its scale"),
        ({"extra": {"joints": "X"}, "unit": "urad"}, "no unit of lengths"),
    ],
)
def test_what_a_halscope_log_leaves_open_is_asked(options, says):
    with pytest.raises(GcompError, match=says):
        read(Source("scope.log", LOG.encode()), options=ReadingOptions(**options))


# -- long tables -----------------------------------------------------------------------------------


@pytest.mark.parametrize("clock", [False, True])
def test_a_long_table_keeps_the_order_of_the_axis(clock):
    """Both directions in one run: without times its rows were interleaved, with an ISO time they
    were refused."""
    lines = [
        (
            'Target (mm);Run;Direction;Pitch (");Time'
            if clock
            else 'Target (mm);Run;Direction;Pitch (")'
        )
    ]
    for k, (run, way, q) in enumerate(FLAT):
        lines.append(
            f"{q};{run};{way};{value(run, way, q)}"
            + (f";2024-05-17T10:31:{k:02d}" if clock else "")
        )
    source = Source("long.csv", "\n".join(lines).replace(".", ",").encode())
    got = read(source, options=ReadingOptions(component="EAZ"))
    assert got.position("Z").tolist() == [q for *_, q in FLAT]
    assert got.columns["t_s"].tolist() == list(range(12))
    assert got.reading == approx([value(*row) * np.radians(1 / 3600) for row in FLAT], abs=1e-12)
    again = read(Source("again.csv", contract.write(got).encode()))
    assert again.reading == approx(got.reading, abs=1e-10)


def test_a_table_in_another_order_is_brought_into_that_of_the_axis():
    """Sorted by target, each row with its run and direction: run by run, there before back."""
    rows = sorted(FLAT, key=lambda row: (row[0], row[2], row[1]))
    text = "Target (mm),Run,Direction,Deviation (um)\n" + "\n".join(
        f"{q},{r},{w},{value(r, w, q)}" for r, w, q in rows
    )
    got = read(Source("sorted.csv", text.encode()), options=ReadingOptions(axis="Z"))
    assert got.position("Z").tolist() == [q for *_, q in FLAT]
    assert got.reading == approx([value(*row) * 1e-3 for row in FLAT])


def test_dates_by_a_column_mapping():
    text = "when,pos,way,dev\n" + "\n".join(
        f"2024-05-17T10:3{k}:00,{q},{w},{q}"
        for k, (q, w) in enumerate(((0, "up"), (5, "up"), (5, "down"), (0, "down")))
    )
    columns = {"Z_mm": "pos", "direction": "way", "reading_um": "dev", "t_s": "when"}
    got = read(Source("m.csv", text.encode()), options=ReadingOptions(columns=columns))
    assert got.columns["t_s"].tolist() == [0, 60, 120, 180]
    with pytest.raises(GcompError, match="neither seconds nor a date"):
        read(
            Source("m.csv", text.replace("2024-05-17T10:32:00", "noon").encode()),
            options=ReadingOptions(columns=columns),
        )
