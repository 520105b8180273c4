"""What comes from outside and is too large, too deep, or leads elsewhere: one message, status 2,
and nothing written. docs/SECURITY.md has the same rows."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import pytest

from postproc import intake
from postproc.cli import main

ROOT = Path(__file__).resolve().parents[2]
LATHE = ROOT / "machines" / "example-lathe"
PROGRAM = "G21 G90 G18 G0 X40. Z100. T0000\nG1 Z80. F0.2\n"
DIGITS = "9" * 400
NESTED = "[" * 100_000 + "]" * 100_000
MAIN = b'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
OFFICE = b"http://schemas.openxmlformats.org/officeDocument/2006/relationships"


@pytest.fixture
def lathe(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("a.nc").write_text(PROGRAM)
    shutil.copytree(LATHE, "lathe")
    return Path("lathe")


def refused(capfd, *line: str) -> str:
    assert main(list(line)) == 2
    said = capfd.readouterr().err
    assert said.startswith("gcomp: ") and "Traceback" not in said and len(said.splitlines()) <= 4
    return said


def corrected(capfd, *more: str) -> str:
    said = refused(capfd, "a.nc", "--machine", "./lathe", "-o", "out.nc", *more)
    assert not Path("out.nc").exists()
    return said


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("B0X = -60.0", "B0X = 1e999", "machine.toml:25: B0X = inf"),
        ("B0X = -60.0", f"B0X = {DIGITS}", "machine.toml:25: not valid TOML: an integer is beyond"),
        ("B0X = -60.0", f"B0X = {DIGITS * 20}", "an integer has too many digits"),
        ("B0X = -60.0", "B0X = 0x" + "f" * 400, "an integer is beyond 64 bits"),
        ("B0X = -60.0", "B0X = -60.0\nx = " + NESTED, "it nests too deep"),
        ("B0X = -60.0", "B0X = -60.0\n" + "a." * 20_000 + "a = 1", "a key of more than 32 parts"),
        ("B0X = -60.0", "B0X = -60.0\0", "not valid TOML"),
        ("200.0]", "1e300]", "two ascending numbers"),
        ('"Z.csv"', '"../../Z.csv"', "leads out of the machine's folder"),
        ('"Z.csv"', '"/etc/passwd"', "leads out of the machine's folder"),
    ],
    ids="inf digits more_digits hex deep dotted nul far up absolute".split(),
)
def test_a_machine_file_that_is_none(lathe, capfd, old, new, says):
    toml = lathe / "machine.toml"
    toml.write_text(toml.read_text().replace(old, new))
    assert says in corrected(capfd)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Z_mm" + ",EZZ_um" * 1_000_000 + "\n", "stands twice"),
        ("Z_mm,EZZ_um\n1" + ",0" * 1_000_000 + "\n", "1000001 values under 2 columns"),
        ("Z_mm,EZZ_um\n-600,1e999\n0,0\n", "not finite"),
        (f"Z_mm,EZZ_um\n-600,{DIGITS}\n0,0\n", "beyond any machine"),
        ("Z_mm,EZZ_um\n-600,\0\n0,0\n", "is not a number"),
        ('Z_mm,EZZ_um\n-600,"0\n0,0\n', "not a line of a CSV table"),
    ],
    ids="columns cells inf digits nul quote".split(),
)
def test_a_table_that_is_none(lathe, capfd, text, says):
    (lathe / "Z.csv").write_text(text)
    assert says in corrected(capfd)


@pytest.mark.parametrize("name", ["Z.csv", "Z_uncertainty.csv"])
def test_no_link_leads_out_of_a_machines_folder(lathe, capfd, name):
    (lathe / name).unlink(missing_ok=True)
    (lathe / name).symlink_to(LATHE / "Z.csv")
    assert "leads out of the machine's folder" in corrected(capfd)


def test_a_control_table_stays_in_the_folder(lathe, capfd):
    toml = lathe / "machine.toml"
    toml.write_text(
        toml.read_text() + '\n[[control_table]]\ncontrol = "linuxcnc"\nfile = "../a.nc"\n'
        'measured = "on"\nactive = false\n'
    )
    assert "leads out of the machine's folder" in corrected(capfd)


@pytest.mark.parametrize(
    ("limit", "path", "line"),
    [
        ("MACHINE", "lathe/machine.toml", ("a.nc", "--machine", "./lathe", "-o", "out.nc")),
        ("TABLE", "lathe/Z.csv", ("a.nc", "--machine", "./lathe", "-o", "out.nc")),
        ("RECORDING", "r.csv", ("recordings", "r.csv")),
        ("RECORDING", "r.csv", ("iso", "r.csv")),
        ("RECORDING", "r.csv", ("diagnose", "r.csv", "--machine", "./lathe")),
        ("RECORDING", "r.csv", ("calibrate", "r.csv", "--like", "./lathe")),
        ("CONTROL_TABLE", "t.comp", ("export", "--control", "linuxcnc", "--read", "t.comp")),
        ("OFFSETS", "o.csv", ("a.nc", "--machine", "./lathe", "--offsets", "o.csv")),
        ("LOG", "l.csv", ("a.nc", "--machine", "./lathe", "--temperatures", "l.csv")),
        ("PROGRAM", "a.nc", ("a.nc", "--machine", "./lathe", "--expand", "-o", "out.nc")),
        (
            "JOURNAL",
            "out/.gcomp-batch.jsonl",
            ("batch", "a.nc", "--machine", "./lathe", "-o", "out"),
        ),
        ("PROGRAM", "a.nc", ("simulate", "a.nc", "--machine", "./lathe", "--instrument", "log")),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else str(value),
)
def test_a_file_that_is_too_large(lathe, capfd, monkeypatch, limit, path, line):
    """The limit is lowered: files of hundreds of megabytes show no more."""
    Path(path).parent.mkdir(exist_ok=True)
    Path(path).write_text("x" * 1001)
    monkeypatch.setattr(intake, limit, 1000)
    if limit == "TABLE":  # a default argument
        monkeypatch.setattr("postproc.machine.axis_file.text_of.__defaults__", (1000,))
    assert "more than 1,000 bytes" in refused(capfd, *line)


@pytest.mark.parametrize(
    "inside", [b"<a>" * 200_000, b"<sheetData><row>" + b"<c/>" * 200_000], ids=["deep", "wide"]
)
def test_a_workbook_whose_rows_have_no_end_is_not_held_in_memory(lathe, capfd, inside):
    """A file of 7 kB with two million elements, one within the other, took 600 MB."""
    sheets = b'<sheets><sheet name="S" xmlns:r="%s" r:id="r1"/></sheets>' % OFFICE
    with zipfile.ZipFile("r.xlsx", "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("xl/workbook.xml", b"<workbook %s>" % MAIN + sheets + b"</workbook>")
        book.writestr("xl/_rels/workbook.xml.rels", '<R><R Id="r1" Target="s.xml"/></R>')
        book.writestr("xl/s.xml", b"<worksheet %s>" % MAIN + inside)
    assert "xl/s.xml has more than 131,072 elements" in refused(capfd, "iso", "r.xlsx")


def test_a_machines_name_is_no_block(lathe, capfd):
    toml = lathe / "machine.toml"
    toml.write_text(toml.read_text().replace('"example-lathe"', r'"mill)\nG0 Z-100 (x<\u00fc"'))
    assert main(["a.nc", "--machine", "./lathe", "-o", "out.nc", "--quiet"]) == 0
    lines = Path("out.nc").read_text().splitlines()
    assert any(line.startswith("(GCOMP 0.1.0 MILL__G0 Z-100 _X__ MAP ") for line in lines)
    assert not any(line.startswith("G0 Z-100") for line in lines)
    capfd.readouterr()


def test_a_long_comment_without_an_end_is_refused_at_once(lathe, capfd):
    """It took 98 s: a pattern of the recogniser went over it again from every letter."""
    Path("a.nc").write_text("(" + "x" * 3_000_000 + ")\n")
    assert "a line of more than 1,000,000 characters" in corrected(capfd)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--with", "backlash:Z:size_um=abc"), "size_um: 'abc' is not a number"),
        (("--with", "backlash:Z:size_um=1e308"), "size_um: '1e308' is not a number"),
        (("--set", "rate=1e308"), "rate=1e308 is not a number"),
        (("--set", "rate=1e11"), "samples are more than 5,000,000"),
        (("--test", "positioning:Z,step=1e-12"), "steps of 1e-12 mm are more than 100,000 targets"),
        (("--test", "positioning:Z,step=1e-320"), "are more than 100,000 targets"),
    ],
    ids="word huge rate samples targets infinite".split(),
)
def test_a_simulation_without_end_is_refused_before_it_begins(lathe, capfd, words, says):
    test = () if "--test" in words else ("--test", "ballbar:XZ")
    line = ("simulate", *test, "--machine", "./lathe", *words, "-o", "out.csv")
    assert says in refused(capfd, *line)
    assert not Path("out.csv").exists()


def test_a_link_to_itself_is_no_program_of_a_batch(lathe, capfd):
    Path("in").mkdir()
    shutil.copy("a.nc", "in/a.nc")
    Path("in/loop.nc").symlink_to("loop.nc")
    assert main(["batch", "in", "--machine", "./lathe", "-o", "out", "-j", "1", "--quiet"]) == 0
    assert [p.name for p in Path("out").rglob("*.nc")] == ["a.nc"]


def test_rows_that_belong_to_no_run_are_refused(lathe, capfd):
    text = (ROOT / "sample_recordings" / "z_positioning.csv").read_text().splitlines()
    at = next(i for i, line in enumerate(text) if line.startswith("run,")) + 2
    text[at] = text[at][text[at].index(",") :]
    Path("r.csv").write_text("\n".join(text) + "\n")
    assert f"r.csv:{at + 1}: run" in refused(capfd, "iso", "r.csv")


def test_the_page_names_every_limit():
    text = (ROOT / "docs" / "SECURITY.md").read_text("utf-8")
    names = "PROGRAM LINE RECORDING WORKBOOK LOG MACHINE TABLE CONTROL_TABLE OFFSETS JOURNAL"
    for name in (*names.split(), "WORKBOOK_PART", "MACRO", "RECEIVED"):
        assert f"{getattr(intake, name):,}" in text, name
    assert f"keys of {intake.PARTS} parts" in text
