"""The page of a program as a file: whole, small, asking nobody, with the numbers of --verify in
it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from postproc import style
from postproc.cli import main
from postproc.pages.program import magnified, views
from tests.pages import drawn

ROOT = Path(__file__).resolve().parents[2]
SHAFT = ROOT / "sample_programs" / "shaft.nc"
LARGEST = 3_000_000  # bytes of a page


def page(tmp_path: Path, program: Path, machine: str, *words: str) -> str:
    out = tmp_path / "page.html"
    assert main(["show", str(program), "--machine", machine, "-o", str(out), *words]) == 0
    return out.read_text("utf-8")


def test_the_page_holds_the_numbers_of_verify_and_asks_for_nothing(tmp_path, capfd):
    out, told = tmp_path / "page.html", tmp_path / "told.json"
    line = ["--machine", "studer-s36", str(SHAFT), "-o", str(tmp_path / "c.nc")]
    assert main([*line, "--report", str(out), "--json", str(told), "--quiet"]) == 0
    assert capfd.readouterr().err == ""  # the page is asked for, the sentence of --verify is not
    html, verified = out.read_text("utf-8"), json.loads(told.read_text())["verified"]
    curves = drawn.curves(html, "along")
    assert max(curves["corrected"]["y"]) == pytest.approx(verified["deviation_um"], abs=1e-3)
    assert max(curves["not corrected"]["y"]) == pytest.approx(verified["uncorrected_um"], abs=1e-3)
    assert f"{verified['deviation_um']:.2f} um" in html and "17 times less" in html
    assert drawn.outside(html) == []
    assert len(html) < LARGEST
    assert drawn.data(html)["path"]["text"]["17"][0] == "N120 Z190. F80."
    assert b"plotly.js" in drawn.packed(html, "library")[:200]


def test_the_same_program_gives_the_same_page(tmp_path):
    assert page(tmp_path, SHAFT, "studer-s36") == page(tmp_path, SHAFT, "studer-s36")


def test_text_of_a_program_is_never_code_of_the_page(tmp_path):
    evil = tmp_path / "<b>&'\".nc"
    evil.write_text(
        "G21 G90 (</script><script>alert 1</script>)\nG0 X1 Y1 Z1\nG1 X2 F100 (<img src=x"
        " onerror=alert>)\n"
    )
    html = page(tmp_path, evil, "example-mill", "--offset", "G54=X100,Y100,Z-100")
    plain = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)
    assert "<img" not in plain and "alert 1" not in plain and "<b>&'" not in plain
    assert "&lt;img src=x onerror=alert&gt;" in html


@pytest.mark.parametrize(
    "text, says",
    [
        ("", "nothing to draw"),
        ("(only a comment)\n", "nothing to draw"),
        ("M30\n", "nothing to draw"),
        ("G21 G90 G0 X1\n", "nothing is changed"),
    ],
)
def test_a_program_with_next_to_nothing_in_it_has_a_page(tmp_path, text, says):
    program = tmp_path / "p.nc"
    program.write_text(text)
    assert says in page(tmp_path, program, "perfect", "--quiet")


def test_where_no_place_is_known_the_page_does_not_say_that_all_is_well(tmp_path):
    """X and Y are corrected, and Z is nowhere stated: it said that the map has no error there."""
    flat = tmp_path / "flat.nc"
    flat.write_text("G90 G21\nG1 X100. Y100. F500\nX200.\n")
    html = page(tmp_path, flat, "example-router", "--dialect", "linuxcnc")
    assert "Nothing was compared: no place of the path is known" in html
    assert "not known" in html and "The map has no error where" not in html


def test_a_machine_without_errors_and_one_of_each_are_said_as_they_are(tmp_path, capfd):
    """It said that no place was known to the map, and "line 0"; and "1 take-ups"."""
    program = tmp_path / "p.nc"
    program.write_text("G21 G90\nG0 X10 Z10\nG1 X20 Z40 F100\nM2\n")
    zero = page(tmp_path, program, "perfect", "--quiet")
    zero = zero[: zero.index("<script")]
    assert "zero everywhere" in zero and "line 0" not in zero and "is known to the map" not in zero
    shaft = page(tmp_path, program, "studer-s36", "--quiet")
    assert "1 take-up of lost motion, 1 cut<" in shaft
    assert "um are allowed where lost motion is taken up" in shaft


def test_a_written_out_program_is_reported_by_the_lines_of_its_author(tmp_path):
    program = tmp_path / "loop.nc"
    program.write_text(
        "%\nO1\nG90 G21 G18\nG0 X20. Z10.\n#1=1\nWHILE[#1 LE 3]DO1\nG1 X[20+#1*5.] Z[10+#1*10.]"
        " F100\n#1=#1+1\nEND1\nM30\n%\n"
    )
    html = page(tmp_path, program, "studer-s36")
    assert "written out as plain blocks" in html
    path = drawn.data(html)["path"]
    assert set(path["after"]["line"]) == {4, 7}
    assert path["text"][str(path["after"]["plain"][-1])][0].startswith("G1 X35")


def test_a_refused_program_leaves_no_page(tmp_path, capfd):
    program, out = tmp_path / "p.nc", tmp_path / "page.html"
    program.write_text("G21 G90 G0 X20. Z0.\nG1 X900. F100\n")
    assert main(["show", str(program), "--machine", "studer-s36", "-o", str(out)]) == 2
    assert main([str(program), "--machine", "studer-s36", "--report", str(out)]) == 2
    assert not out.exists()
    capfd.readouterr()


def test_a_page_and_a_program_do_not_go_to_one_place(tmp_path, capfd):
    program = tmp_path / "p.nc"
    program.write_bytes(SHAFT.read_bytes())
    line = [str(program), "--machine", "studer-s36"]
    assert main([*line, "--report", str(program)]) == 2
    assert main([*line, "--report", "a.html", "--unbuffered"]) == 2
    assert "nothing in it says that gcomp made it" in capfd.readouterr().err
    assert program.read_bytes() == SHAFT.read_bytes()


def test_show_opens_the_browser_on_a_page_that_stays(monkeypatch, capfd):
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    assert main(["show", str(SHAFT), "--machine", "studer-s36"]) == 0
    path = Path(opened[0].removeprefix("file://"))
    assert path.name == "shaft-nc.html" and "shaft.nc on studer-s36" in path.read_text("utf-8")
    assert f"opened: {path}" in capfd.readouterr().err
    path.unlink()
    path.parent.rmdir()


def test_views_and_magnification_by_hand():
    import numpy as np

    flat = np.array([[0.0, 100.0], [0.0, 50.0], [0.0, 1.0]])
    assert views(("X", "Y", "Z"), flat, False) == ["X Y", "X Z", "Y Z", "3D"]
    assert views(("X", "Y", "Z"), flat * np.array([[1], [1], [60]]), False)[0] == "3D"
    assert views(("X", "Z"), flat[:2], True) == ["Z X"]
    assert views(("Z",), flat[:1], False) == ["Z Z"]
    assert magnified(100.0, 0.006) == 9  # 0.06 * 100 / 0.006 = 1000


def test_both_themes_have_every_role_and_scripts_name_no_other():
    assert set(style.LIGHT) == set(style.DARK)
    pages = ROOT / "postproc" / "pages"
    text = "".join(
        p.read_text("utf-8")
        for p in [*pages.rglob("*.py"), *pages.rglob("*.js")]
        if p.name != "style.py"
    )
    named = set(re.findall(r'"@([a-z-]+)"', text)) | set(
        re.findall(r'gcomp\.colour\("([a-z-]+)"\)', text)
    )
    assert named - set(style.LIGHT) - {"font", "sequential"} == set()
    assert not re.search(r"#[0-9a-f]{6}\b", text), "colours stand in style.py"


def test_nothing_that_draws_is_imported_where_no_page_is_asked_for():
    code = (
        "import sys, gcomp; from postproc.cli import main; main(['machines']);"
        " print(sorted({m.split('.')[0] for m in sys.modules} & {'jinja2', 'plotly', 'matplotlib',"
        " 'dask'}), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert done.stderr.strip() == "[]"
