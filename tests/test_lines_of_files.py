"""Lines of files end at line feed and carriage return alone: a form feed, U+0085 and U+2028 stand
in a remark, and the lines behind it keep their numbers."""

from __future__ import annotations

import numpy as np
import pytest

from postproc import control_tables, intake
from postproc.control_tables import ErrorTable, ExportOptions, heidenhain
from postproc.errors import GcompError
from postproc.heat import log
from postproc.recordings import ReadingOptions, Source, six_degrees
from tests.control_tables.test_broken_files import COM, ENC, MITSUBISHI, OPTIONS
from tests.machine_folders import TOML, X_CSV, Z_CSV, folder, line_of, refusal, swap

SIGNS = ("\f", "\v", "\x1c", "\x85", "\u2028", "\u2029")


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("", [""]),
        ("a", ["a"]),
        ("a\n", ["a"]),
        ("a\r\nb\rc\n\n", ["a", "b", "c", ""]),
        ("a\n\r\nb\r\n", ["a", "", "b"]),
        *((f"a{sign}b\nc\n", [f"a{sign}b", "c"]) for sign in SIGNS),
    ],
)
def test_lines_of_a_text(text, lines):
    assert intake.lines_of(text) == lines


@pytest.mark.parametrize("sign", SIGNS)
@pytest.mark.parametrize(
    ("control", "name", "text", "line"),
    [
        (
            "heidenhain",
            "AXIS_X.COM",
            COM.replace("A.COM", "A{}.COM").replace("0.0020", "0,0020"),
            4,
        ),
        ("siemens-enc-comp", "a.ini", ";A{}\n" + ENC.replace("=0.001", "=0,001"), 5),
        ("mitsubishi", "m.csv", "#{}\n" + MITSUBISHI.replace("10,3", "10,3.5"), 4),
    ],
)
def test_a_fault_of_a_control_table_stands_in_its_line(control, name, text, line, sign):
    with pytest.raises(GcompError) as caught:
        control_tables.load(control).read(Source(name, text.format(sign).encode()), OPTIONS)
    assert caught.value.place is not None and caught.value.place.line == line


@pytest.mark.parametrize("sign", SIGNS)
def test_a_template_of_heidenhain_keeps_its_remark(sign):
    text = f"BEGIN ACHSE{sign}1.COM MM\r\nNR      AXISPOS    X         \r\n[END]\r\n"
    options = ExportOptions(reference={"X": 0.0}, extra={"template": text})
    values = np.array([0.001, 0.002])
    table = ErrorTable("X", "X", np.array([0.0, 10.0]), values, values)
    export = heidenhain.write([table], options)
    lines = export.files["AXIS_X.COM"].decode().split("\r\n")
    assert lines[0] == f"BEGIN ACHSE{sign}1.COM MM" and lines[-2:] == ["[END]", ""]
    assert len(lines) == 6


@pytest.mark.parametrize("sign", SIGNS)
def test_a_remark_above_six_degrees_is_no_row(sign):
    head = "X_mm,EXX_um,EYX_um,EZX_um"
    text = f"# made{sign}up\n{head}\n0,1,2,3\n10,2,3,4\n"
    found = six_degrees.read_all(Source("a.csv", text.encode()), ReadingOptions())
    assert [len(r.columns["X_mm"]) for r in found] == [2, 2, 2]
    assert found[0].lines.tolist() == [3, 4]


@pytest.mark.parametrize("sign", SIGNS)
def test_a_fault_of_a_machine_stands_in_its_line(tmp_path, sign):
    z = swap(Z_CSV, "made up", f"made{sign}up")
    toml = TOML.replace("# dialect", "# dialect, of the\u2028shop")
    wrong = swap(z, "100,3", "100,nan")
    assert refusal(folder(tmp_path, toml, wrong)).place.line == 4
    back = swap(z, "100,3", "300,3")
    assert refusal(folder(tmp_path, toml, back)).place.line == 5
    wrong = swap(toml, "max_slope = 0.005", 'max_slope = "a"')
    error = refusal(folder(tmp_path, wrong, z, X_CSV))
    assert error.place.line == line_of(wrong, "max_slope")


@pytest.mark.parametrize("sign", SIGNS)
def test_a_fault_of_a_log_stands_in_its_line(sign):
    text = f'# a{sign}b\nt_s,T_a_C\n0,20\n1,"21\n2,22\n'
    with pytest.raises(log.LogError) as refused:
        log.read("l.csv", text.encode())
    assert refused.value.place.line == 4
