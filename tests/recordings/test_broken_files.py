"""Every broken file is refused with its name, the line and the reason, and never with a traceback;
so is every mutation."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from postproc.commands.recordings import show
from postproc.errors import GcompError
from postproc.recordings import ReadingOptions, Recording, contract, names, read_all
from tests.recordings import samples
from tests.recordings.broken import (
    BALL,
    CASES,
    COMP,
    CSV,
    DYNAMIC,
    LASER,
    LONG,
    MAP,
    OWN,
    RTL,
    RTX,
    SHEET,
    TYPE0,
)
from tests.recordings.samples import source, taken

TABLE = samples.readings(4)
CIRCLE = {
    "columns": {"angle_deg": "angle", "radial_um": "dev", "sense": "dir"},
    "head": {"radius_mm": 150.0, "centre": {"X": 400.0, "Y": 300.0}},
}
FEATURES = {
    "columns": {
        "feature": "name",
        "kind": "what",
        "axis": "ax",
        "nominal_mm": "nom",
        "measured_mm": "meas",
    }
}
VALID: list[tuple[str, str | bytes, dict]] = [
    ("a.csv", OWN, {}),
    ("a.csv", BALL, {}),
    ("z.rtl", RTL, {}),
    (
        "z.rtl",
        samples.renishaw(TABLE, comma=True, environment=("Air temp : 20,5",)),
        {"first": -1, "strict": False},
    ),
    ("z.rta", RTL, {"component": "EBZ"}),
    ("x.rtx", RTX, DYNAMIC),
    ("s.csv", SHEET, {}),
    ("s.csv", samples.interleaved(TABLE), {"strict": False}),
    ("s.csv", samples.blocks(TABLE, headed=False), {"layout": "blocks", "axis": "Z", "unit": "um"}),
    ("s.csv", samples.long(TABLE), {"axis": "Z"}),
    ("z.txt", LASER, {}),
    ("a.csv", LONG, {}),
    (
        "a.csv",
        samples.canonical({"EZZ": (TABLE, "um"), "EBZ": (TABLE, "arcsec")}),
        {"strict": False},
    ),
    ("Z.comp", COMP, TYPE0),
    ("a.csv", CSV, MAP),
    ("c.csv", "angle;dev;dir\n0;1,5;CCW\n90;-2,5;CCW\n180;0;CW\n", CIRCLE),
    (
        "f.csv",
        "name,what,ax,nom,meas\nX1,centre_distance,X,80,79.983\nX2,step,X,80,79.985\n",
        FEATURES,
    ),
    (
        "t.csv",
        "t|c|a\n0|1.0|1.001\n0.1|2.0|2.002\n",
        {"columns": {"t_s": "t", "X_cmd_mm": "c", "X_act_mm": "a"}},
    ),
    (
        "w.csv",
        "z,up,dn\n0,1.5,2.5\n10,1.5,-2.5\n",
        {"columns": {"Z_mm": "z", "forward_um": "up", "reverse_um": "dn"}},
    ),
]
BITS = [
    b"",
    b",",
    b";",
    b"\t",
    b"\n",
    b"\r",
    b'"',
    b"::",
    b"nan",
    b"1e400",
    b"-",
    b"\x00",
    b"\xff",
    b"\xe2\x86\x91",
    b"0",
    b"9" * 30,
    b"#",
    b"= {",
    b".",
]


def options(given_: dict) -> tuple[str, ReadingOptions]:
    rest = dict(given_)
    return rest.pop("format", ""), ReadingOptions(**rest)


@pytest.mark.parametrize("case", CASES, ids=[c[0] for c in CASES])
def test_a_broken_file_is_refused_with_its_line_and_reason(case):
    _, name, data, how, sentence, line = case
    with pytest.raises(GcompError) as caught:
        taken(name, data, **how)
    error = caught.value
    assert sentence in error.message
    if line:
        assert error.place is not None and (error.place.file, error.place.line) == (
            name,
            line,
        ), str(error)


def test_there_is_a_broken_file_for_every_reader_and_its_words_are_plain():
    assert len(CASES) >= 40
    for _, name, data, how, *_ in CASES:
        with pytest.raises(GcompError) as caught:
            taken(name, data, **how)
        text = caught.value.message + caught.value.advice
        assert "None" not in text and "Error" not in text and "  " not in text.replace("2   5", "")
        assert not caught.value.message.endswith(".")


@pytest.mark.parametrize(
    ("name", "data", "how"), VALID, ids=[f"{v[0]}-{i}" for i, v in enumerate(VALID)]
)
def test_what_is_mutated_below_reads(name, data, how):
    format, how_ = options(how)
    assert all(len(r) for r in read_all(source(name, data), format, how_))


def sound(recording: Recording) -> None:
    """What a reader lets through can be used: finite numbers, signs, equal lengths, and the writer
    takes it."""
    assert len(recording) and all(len(c) == len(recording) for c in recording.columns.values())
    assert len(recording.lines) == len(recording)
    if recording.kind == "targets":
        assert np.all(np.isfinite(recording.reading)) and recording.axes
        for letter in recording.axes:
            assert np.all(np.isfinite(recording.position(letter)))
            assert np.all(np.isin(recording.approach(letter), (-1, 0, 1)))
    assert show(recording, "any").startswith(recording.file)
    back = contract.read(source("again.csv", contract.write(recording)), ReadingOptions())
    assert len(back) == len(recording)


def survives(name: str, data: bytes, how: dict) -> None:
    format, how_ = options(how)
    try:
        for recording in read_all(source(name, data), format, how_):
            sound(recording)
    except GcompError as error:
        assert error.message
        assert (
            error.place is None
            or 1 <= error.place.line <= data.count(b"\n") + data.count(b"\r") + 1
        )


@settings(max_examples=600, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, len(VALID) - 1), st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_mutations_end_in_a_recording_or_a_sentence(which, seed, changes):
    name, data, how = VALID[which]
    draw = random.Random(seed)
    content = bytearray(data if isinstance(data, bytes) else data.encode())
    for _ in range(changes):
        at = draw.randrange(len(content) + 1)
        length = draw.choice((0, 1, 1, 2, 5, 40))
        kind = draw.randrange(4)
        if kind == 0:
            content[at : at + length] = draw.choice(BITS)
        elif kind == 1:
            content[at : at + length] = bytes(draw.randrange(256) for _ in range(length or 1))
        elif kind == 2:
            content[at:at] = content[draw.randrange(len(content) + 1) :][:length]
        else:
            content = content[: max(at, 1)] if draw.random() < 0.2 else content
    survives(name, bytes(content), how)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(names()), st.binary(max_size=300), st.integers(0, len(VALID) - 1))
def test_any_bytes_in_any_reader_end_in_a_recording_or_a_sentence(format, data, which):
    survives("any.csv", data, {**VALID[which][2], "format": format, "extra": {}})


HEAD_AWAY = "\n".join(line for line in OWN.splitlines() if not line.startswith("#"))


@pytest.mark.parametrize(
    ("data", "says", "way"),
    [
        (OWN.replace("# ", '"# ', 1), "the head is not one", "each of its lines with #"),
        (OWN.encode("utf-16"), "stored as UTF-16", "save it as UTF-8"),
        (HEAD_AWAY, "are columns of gcomp's own format", '# kind = "targets"'),
        (b"PK\x03\x04..mimetypeapplication/vnd.oasis.opendocument", "OpenDocument", ".xlsx"),
        (b"PK\x03\x04" + bytes(40), "an archive", ".xlsx"),
        (b"\xd0\xcf\x11\xe0" + bytes(40), "(.xls)", ".xlsx"),
        (
            "Target;Run 1;Run 2\n0;0,3;-5,5\n25;4,1;-2,0\n",
            "2 columns of readings (Run 1, Run 2), whose",
            "--layout interleaved",
        ),
    ],
)
def test_what_is_nearly_a_recording_is_told_what_it_lacks(data, says, way):
    with pytest.raises(GcompError) as caught:
        read_all(source("a.csv", data))
    assert says in caught.value.message and way in caught.value.advice
    assert "formats: " not in caught.value.advice


def test_columns_parted_by_semicolons_are_named_as_such():
    head, rows = OWN.split("run,", 1)
    for delimiter, name in ((";", "semicolons"), ("\t", "tabs")):
        text = head + ("run," + rows).replace(",", delimiter)
        with pytest.raises(GcompError, match=f"the columns are parted by {name}"):
            read_all(source("a.csv", text))


def test_a_german_sheet_whose_headings_name_the_directions_is_read():
    text = "Position [mm];Lauf 1 +;Lauf 1 -\n0,0;0,3;5,5\n25,0;4,1;9,0\n50,0;1,1;7,0\n"
    (recording,) = read_all(source("a.csv", text), options=ReadingOptions(axis="X", unit="um"))
    assert recording.columns["approach_X"].tolist() == [1, 1, 1, -1, -1, -1]
    assert recording.columns["reading_um"].tolist() == [0.3, 4.1, 1.1, 7.0, 9.0, 5.5]


def test_a_halscope_log_of_a_byte_order_mark_alone_is_refused():
    with pytest.raises(GcompError, match="the first line is not the sampling period"):
        read_all(source("a.log", b"\xef\xbb\xbf"), "halscope")


RUNS = "Target;Run 1;Run 2;Remark\n0;0.3;5.5;x\n25;4.1;9.0;y\n"


def test_a_run_that_no_column_names_is_not_left_out_in_silence():
    named = {"X_mm": "Target", "forward1_um": "Run 1"}
    (recording,) = read_all(source("a.csv", RUNS), options=ReadingOptions(columns=named))
    assert "columns that no --column names: 'Run 2'" in recording.notices
    named["reverse1_um"] = "Run 2"
    (recording,) = read_all(source("a.csv", RUNS), options=ReadingOptions(columns=named))
    assert len(recording) == 4 and not any("--column" in n for n in recording.notices)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ("time,position,current\n0,1,2\n1,2,3\n2,3,4\n", "no recording that gcomp knows"),
        ("t;x;y\n0;1;2\n1;2;3\n2;3;4\n", "no recording that gcomp knows"),
        (
            "X_mm,EXX_um_fwd,EXX_um_rev,EYX_um\n0,1,2,0\n20,2,3,0\n",
            "errors (EXX_um_fwd, EXX_um_rev",
        ),
        ("X_mm,Y_mm,EXX_um\n0,0,2\n20,0,3\n", "a table of a machine's errors (EXX_um)"),
    ],
)
def test_what_is_no_recording_is_not_called_a_sheet_of_one(data, says):
    """The log of a drive, and a machine's own table, whose headings do name directions."""
    with pytest.raises(GcompError) as caught:
        read_all(source("a.csv", data))
    assert says in caught.value.message and "--layout" not in caught.value.advice
