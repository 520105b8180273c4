"""Broken files: each is refused with the file, the line and the reason, never read in part."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from postproc.control_tables import ErrorTable, ExportOptions, load
from postproc.errors import GcompError
from postproc.recordings import Source

LSEC = """kopf.log_achs_name X
kw.ssfk.interval 0
kw.ssfk.kw_nr_max 2
kw.ssfk.unit 1
kw.ssfk.bilateral 0
kw.ssfk.table[0].setpoint 0
kw.ssfk.table[1].setpoint 1000
kw.ssfk.table[0].pos 3
kw.ssfk.table[1].pos 4
"""
SHEET = (
    "axis = X\nunit = mm\nstart = 0\nlength = 10\npoints = 2\nposition, error_positive\n0, 0.1\n10,"
    " 0.2\n"
)
ONE = {"version": "1", "counts_per_mm": "1000", "axis": "X"}


def swap(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


BROKEN = [
    ("isg-csv", "", 1, "empty"),
    ("isg-csv", "// only a comment\n", 1, "no table"),
    ("isg-csv", "X EXX EQX\n0 0 0\n", 1, "'EQX' is not an argument"),
    ("isg-csv", "X EXX EXX\n0 0 0\n", 1, "heads two columns"),
    ("isg-csv", "0 1 2\n", 1, "'0' is not an argument"),
    ("isg-csv", "X EXX\n0 0\n10 0.1 3\n", 3, "3 values under 2 columns"),
    ("isg-csv", "X EXX\n0 0\n10 0,1\n", 3, "'0,1' is not a number"),
    ("isg-csv", "X EXX\n0 0\n10 nan\n", 3, "'nan' is not a number"),
    ("isg-csv", "X EXX\n0 0\n10 2000000\n", 3, "too large"),
    ("isg-csv", "X EXX\n0 0\n1 1\n#\nX EXX EYX\n0 0 0\n1 1 1\n", 5, "EXX has been given in line 1"),
    ("isg-csv", "X EXX\n#\nY EYY\n0 0\n1 1\n", 1, "a header without rows"),
    ("isg-csv", "Y EXX\n0 0\n1 1\n", 1, "stands without its argument X"),
    ("isg-csv", "X EXX\n0 0\n0 1\n", 3, "twice at the same place"),
    ("isg-csv", "Z X EXX\n0 0 0\n0 1 0\n9 0 0\n", 1, "3 rows are no grid of 2 by 2"),
    ("isg-csv", "Z Y X EXX\n0 0 0 0\n1 1 1 1\n", 1, "depends on Z and Y"),
    ("isg-csv", "X EXX\n0 0\n", 1, "one row"),
    ("isg-csv", "X B0Z\n0 0.1\n1 0.2\n", 1, "only a constant"),
    ("isg-csv", "X EXX\n0 0\n1 1\n# Y EYY\n0 0\n", 4, "text behind #"),
    ("isg-csv", b"X EXX\n0 0\n1 \xff\n", 3, "not UTF-8"),
    ("etalon", "\n\n", 1, "empty"),
    ("etalon", "// nothing\n", 1, "no parameter"),
    ("etalon", "VALUE = 1\n", 1, "outside of a section"),
    ("etalon", "[EXQ]\nVALUE = 1\n", 1, "'EXQ' is not a parameter"),
    ("etalon", "[EXX]\nVALUE = 1\n", 2, "a component needs Gridpoints"),
    ("etalon", "[B0Z]\n[A0Z]\nVALUE = 0\n", 2, "[B0Z] has neither"),
    ("etalon", "[B0Z]\nVALUE = 0.1mrad\n", 2, "is not a number"),
    ("etalon", "[B0Z]\nVALUE = 0\n[B0Z]\nVALUE = 0\n", 3, "given in line 1"),
    ("etalon", "[EXX]\nGridpoints = {\n0 1\n5 2\n", 4, "ends inside"),
    ("etalon", "[EXX]\nGridpoints = {\n0 1\n5 2 3\n}\n", 4, "3 words"),
    ("etalon", "[EXX]\nGridpoints = {\n5 1\n0 2\n}\n", 4, "does not ascend"),
    ("etalon", "[EXX]\nGridpoints = {\n5 1\n}\n", 1, "1 points"),
    ("etalon", "[EXX]\nPoints = {\n", 2, "neither VALUE"),
    ("etalon", "[EXX]\n", 1, "neither VALUE nor Gridpoints"),
    ("beckhoff-lsec", swap(LSEC, "unit 1", "unit 0"), 4, "encoder increments"),
    ("beckhoff-lsec", swap(LSEC, "kw.ssfk.unit 1\n", ""), 8, "kw.ssfk.unit is missing"),
    ("beckhoff-lsec", swap(LSEC, "nr_max 2", "nr_max 3"), 9, "table[2].setpoint is missing"),
    ("beckhoff-lsec", swap(LSEC, "bilateral 0", "bilateral 1"), 9, "table[0].neg is missing"),
    ("beckhoff-lsec", swap(LSEC, "setpoint 1000", "setpoint 0"), 9, "do not ascend"),
    ("beckhoff-lsec", swap(LSEC, "pos 4", "pos four"), 9, "is not a number"),
    ("beckhoff-lsec", swap(LSEC, "[1].pos", "[0].pos"), 9, "given twice"),
    ("beckhoff-lsec", swap(LSEC, "kw.ssfk.unit 1", "kw.ssfk.unit"), 4, "not an entry"),
    ("beckhoff-lsec", swap(LSEC, "name X", "name SPINDLE"), 1, "no linear axis"),
    ("marlin", "M852 I0.001\nM104 S200\n", 2, "M104 is neither"),
    ("marlin", "G20\nM852 I0.001\n", 1, "inches"),
    ("marlin", "M852 I0.5\n", 1, "is no machine's"),
    ("marlin", "M425 X0.1 X0.2\n", 1, "stands twice"),
    ("marlin", "; nothing\n", 1, "neither M852 nor M425"),
    ("klipper", "SET_SKEW XY=140,141\n", 1, "2 lengths"),
    ("klipper", "SET_SKEW XY=10,141,300\n", 1, "no parallelogram"),
    ("klipper", "SET_SKEW XW=140,141,100\n", 1, "'XW' is no plane"),
    ("klipper", "G28\n", 1, "G28 is not SET_SKEW"),
    ("reprapfirmware", "M556 S5 X0.1\n", 1, "ignores the block"),
    ("reprapfirmware", "M556 S100 X0.1 P1\n", 1, "P1 takes"),
    ("reprapfirmware", "M556 S100 X0.1\nM425 X-0.1\n", 2, "never negative"),
    ("reprapfirmware", "M556 S100 X9O\n", 1, "is not a number"),
    ("nc-studio", "[X]\n0, 0, 0\n", 1, "before the unit"),
    ("nc-studio", "unit = inch\n", 1, "only mm"),
    ("nc-studio", "unit = mm\n0, 0, 0\n", 2, "outside of an axis"),
    ("nc-studio", "unit = mm\n[X]\n0, 0\n", 3, "2 numbers"),
    ("nc-studio", "unit = mm\n[X]\n5, 0, 0\n0, 0, 0\n", 4, "does not ascend"),
    ("nc-studio", "unit = mm\n[X]\n5, 0, 0\n", 3, "two rows"),
    ("mach4", swap(SHEET, "points = 2", "points = 3"), 8, "2 rows, and points = 3"),
    ("mach4", swap(SHEET, "error_positive", "error"), 6, "not the heading"),
    ("mach4", swap(SHEET, "length = 10", "length = 11"), 1, "do not agree"),
    ("mach4", swap(SHEET, "unit = mm", "units = mm"), 2, "'units' is not known"),
    ("mach4", swap(SHEET, "10, 0.2", "10"), 8, "1 values under 2"),
    ("centroid", "24 -1448819 X\n0\n", 1, "not a header"),
    ("centroid", "3 -5000\n0\n-1\n", 3, "2 corrections"),
    ("centroid", "2 -5000\n0\n-1 2\n", 3, "is not a number"),
    ("centroid", "2 0\n0\n0\n", 1, "stands at home"),
]  # fmt: skip


@pytest.mark.parametrize(
    "control, text, line, says", BROKEN, ids=[f"{c}-{i}" for i, (c, *_) in enumerate(BROKEN)]
)
def test_a_broken_file_is_refused_with_file_line_and_reason(control, text, line, says):
    module = load(control)
    reader = getattr(module, "read_machine", module.read)
    options = ExportOptions(extra=ONE if control == "centroid" else {})
    data = text if isinstance(text, bytes) else text.encode()
    with pytest.raises(GcompError) as caught:
        reader(Source("broken.txt", data), options)
    error = caught.value
    assert error.place is not None and (error.place.file, error.place.line) == (
        "broken.txt",
        line,
    ), str(error)
    assert says in str(error)


@pytest.mark.parametrize(
    "control",
    [
        "isg-csv",
        "etalon",
        "beckhoff-lsec",
        "marlin",
        "klipper",
        "reprapfirmware",
        "nc-studio",
        "mach4",
        "centroid",
    ],
)
@given(data=st.data())
def test_a_file_with_a_slip_is_read_or_refused_and_nothing_else(control, data):
    """A written file with a few bytes changed, cut or doubled ends in tables or in one sentence,
    never in a traceback."""
    module = load(control)
    nodes = np.array([-40.0, -20.0, 0.0])
    table = ErrorTable("X", "X", nodes, np.array([0.0, 0.01, 0.0]), np.array([0.02, 0.03, 0.02]))
    options = ExportOptions(extra=ONE if control == "centroid" else {}, reference={"X": 0.0})
    text = bytearray(
        next(
            iter(
                module.write(
                    [table, ErrorTable("Y", "X", nodes, nodes * 1e-3, nodes * 1e-3)], options
                ).files.values()
            )
        )
    )
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        until = min(len(text), at + data.draw(st.integers(0, 6)))
        text[at:until] = data.draw(
            st.sampled_from(
                [
                    b"",
                    b"-",
                    b"9",
                    b"e",
                    b"\n",
                    b",",
                    b"[",
                    b"}",
                    b" ",
                    b"=",
                    b"#",
                    b"\xff",
                    b"M852 I",
                ]
            )
        )
    reader = getattr(module, "read_machine", module.read)
    try:
        reader(Source("f", bytes(text)), options)
    except GcompError as error:
        assert str(error)
