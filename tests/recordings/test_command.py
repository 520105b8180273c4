"""`gcomp recordings`: what it shows of a file, what it writes, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from postproc.cli import main
from postproc.recordings import Source, names, read
from tests.recordings import samples

TABLE = samples.readings(6)


@pytest.fixture
def rtl(tmp_path):
    path = tmp_path / "z.rtl"
    path.write_text(
        samples.renishaw(TABLE, skip=((2, 3),), environment=("Air temp : 20.5 C",)), newline=""
    )
    return path


def test_it_shows_what_the_file_is(rtl, capsys):
    assert main(["recordings", str(rtl)]) == 0
    shown = capsys.readouterr().out
    for piece in (
        "z.rtl: renishaw",
        "targets: EZZ, displacement along Z",
        "mill-7",
        "10 targets, 0 to 450 mm",
        "6 (+ 1, 3, 5; - 2, 4, 6)",
        "59, ",
        " um, plausible",
        "20.5 C",
        "run 2 target 3: the reading is missing",
        "notice: the unit is not in the file",
    ):
        assert piece in shown, piece


def test_an_implausible_range_is_shown_with_its_slip(rtl, capsys):
    assert main(["recordings", str(rtl), "--unit", "inch"]) == 0
    shown = capsys.readouterr().out
    assert "NOT PLAUSIBLE" in shown and "um read as inch?" in shown


def test_it_writes_a_gcomp_recording(rtl, tmp_path, capsys):
    out = tmp_path / "z.csv"
    command = [
        "recordings",
        str(rtl),
        "--first",
        "-",
        "--bidirectional",
        "yes",
        "--others",
        "X12.5",
        "--head",
        "u_um=0.2",
    ]
    assert main([*command, "--as", str(out)]) == 0
    assert "written" in capsys.readouterr().out
    back = read(Source("z.csv", out.read_bytes()))
    assert back.u == pytest.approx(0.0002) and len(back) == 59
    assert_allclose(back.columns["X_mm"], 12.5)
    assert np.all(back.approach("Z")[back.columns["run"] == 1] == -1)
    before = out.read_bytes()
    assert main([*command[:2], "--as", str(out)]) == 2
    assert "--force to write over it" in capsys.readouterr().err and out.read_bytes() == before
    assert main([*command[:2], "--as", str(out), "--force"]) == 0
    assert out.read_bytes() != before
    assert main(["recordings", str(out)]) == 0


def test_it_does_not_write_over_what_it_reads(rtl, capsys):
    before = rtl.read_bytes()
    assert main(["recordings", str(rtl), "--as", str(rtl)]) == 2
    assert "is the file that is read" in capsys.readouterr().err and rtl.read_bytes() == before


def test_several_components_need_a_choice_to_be_written(tmp_path, capsys):
    path, out = tmp_path / "set.csv", tmp_path / "one.csv"
    path.write_text(samples.canonical({"EZZ": (TABLE, "um"), "EBZ": (TABLE, "arcsec")}))
    assert main(["recordings", str(path), "--as", str(out)]) == 2
    assert "EZZ, EBZ" in capsys.readouterr().err and not out.exists()
    assert main(["recordings", str(path), "--component", "EBZ", "--as", str(out)]) == 0
    assert read(Source("one.csv", out.read_bytes())).quantity == "angle"


def test_one_broken_file_among_several_is_reported_and_the_others_are_shown(rtl, tmp_path, capsys):
    bad = tmp_path / "bad.txt"
    bad.write_text("hello\n")
    assert main(["recordings", str(bad), str(rtl)]) == 2
    captured = capsys.readouterr()
    assert (
        "looks like no recording" in captured.err
        and "bad.txt:1" in captured.err
        and "z.rtl: renishaw" in captured.out
    )


def test_the_list_names_every_format(capsys):
    assert main(["recordings", "--list"]) == 0
    shown = capsys.readouterr().out
    assert all(f"{name} " in shown for name in names()) and "--set type=..." in shown


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "which file?"),
        (["FILE", "--column", "Z_mm"], "is no NAME=VALUE"),
        (["FILE", "--column", "Z_mm=1", "--column", "Z_mm=2"], "given twice: 1 and 2"),
        (["FILE", "--set", "colour=red"], "has no setting 'colour'"),
        (["FILE", "--format", "excel"], "there is no recording format 'excel'"),
        (["FILE", "--unit", "furlong"], "this is no unit of readings"),
        (["FILE", "--axis", "Q"], "--axis Q is no axis letter"),
        (["FILE", "--axis", "X", "--component", "EZZ"], "contradict each other"),
        (["FILE", "--component", "EBZ"], "EBZ is an angle, and"),
        (["FILE", "--others", "Z3"], "which is the axis that moved"),
        (["FILE", "--others", "U3"], "which is no axis of a recording"),
        (["FILE", "--head", "kind=trace"], "is not for you to say"),
        (["FILE", "--head", "centre={"], "is not TOML"),
        (["MISSING"], "can not be read"),
    ],
)
def test_refusals(rtl, capsys, arguments, message):
    words = [{"FILE": str(rtl), "MISSING": str(rtl) + "x"}.get(a, a) for a in arguments]
    assert main(["recordings", *words]) == 2
    assert message in capsys.readouterr().err
