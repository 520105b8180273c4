"""Files that are there already: gcomp replaces what it made, and every command keeps to that."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from postproc import cli
from postproc.errors import UsageError

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = "G90 G21 G18\nG0 X20. Z0.\nG1 X40. Z80. F100\nM30\n"
STUDER = ("--machine", "studer-s36")
Z = str(ROOT / "sample_recordings" / "z_positioning.csv")
MINE = "what a person wrote or measured\n"
# Commands and the file that each writes: what gcomp made is replaced.
RESULTS = {
    "program": (("a.nc", *STUDER, "-o", "out.nc"), "out.nc"),
    "page": (("a.nc", *STUDER, "-o", "o.nc", "--report", "out.html"), "out.html"),
    "show": (("show", "a.nc", *STUDER, "-o", "out.html"), "out.html"),
    "json": (("iso", Z, "--json", "out.json"), "out.json"),
    "svg": (("iso", Z, "--figure", "out.svg"), "out.svg"),
    "png": (("iso", Z, "--figure", "out.png"), "out.png"),
    "pdf": (("iso", Z, "--figure", "out.pdf"), "out.pdf"),
    "calibrate": (("calibrate", Z, "--like", "example-lathe", "--figure", "out.png"), "out.png"),
    "machine": (("machines", "show", "studer-s36", "--report", "out.html"), "out.html"),
    "simulated": (
        ("simulate", "--test", "positioning:Z,runs=1", *STUDER, "-o", "out.csv"),
        "out.csv",
    ),
    "test": (
        ("simulate", "--test", "straightness:Z,runs=1", *STUDER, "--program-out", "out.nc"),
        "out.nc",
    ),
}
# Commands that write what people measure and set up: nothing there is written over without --force.
KEPT = {
    "machine folder": (("calibrate", Z, "--like", "example-lathe", "-o", "out"), "out"),
    "new machine": (
        ("machines", "new", "out", "--kind", "router", "--control", "grbl", "--travel", "X=0,600",
         "--travel", "Y=0,400", "--travel", "Z=-80,0", "--backlash", "X=0.06", "-o", "."),
        "out",
    ),
    "tables": (("export", *STUDER, "--control", "linuxcnc", "-o", "out/"), "out/X.comp"),
    "hook": (("hook", "install", "folder", *STUDER, "-o", "out"), "out/gcomp-studer-s36.sh"),
}  # fmt: skip


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.nc").write_text(PROGRAM)
    return tmp_path


@pytest.mark.parametrize("kind", RESULTS)
def test_what_gcomp_made_is_replaced_and_nothing_else(place, capfd, kind):
    words, name = RESULTS[kind]
    for _ in range(2):  # the second time it is there
        assert cli.main([*words]) == 0
    made = Path(name).read_bytes()
    Path(name).write_text(MINE)
    capfd.readouterr()
    assert cli.main([*words]) == 2
    assert (
        f"{name} is there already, and nothing in it says that gcomp made it"
        in capfd.readouterr().err
    )
    assert Path(name).read_text() == MINE
    Path(name).write_text("")  # nothing is lost
    assert cli.main([*words]) == 0
    assert len(Path(name).read_bytes()) == len(made)


@pytest.mark.parametrize("kind", KEPT)
def test_what_people_measure_and_set_up_is_written_over_by_force_alone(place, capfd, kind):
    words, name = KEPT[kind]
    if kind == "new machine":
        words, name = words[:-2], "machines/out"
    assert cli.main([*words]) == 0
    own = Path(name) / "machine.toml" if Path(name).is_dir() else Path(name)
    own.write_text(own.read_text() + "# mine\n")
    capfd.readouterr()
    assert cli.main([*words]) == 2
    said = capfd.readouterr().err
    assert "is there already" in said and "--force" in said
    assert own.read_text().endswith("# mine\n")
    assert cli.main([*words, "--force"]) == 0
    assert not own.read_text().endswith("# mine\n")
    if Path(name).is_dir():
        assert Path(f"{name}.bak/machine.toml").read_text().endswith("# mine\n")


def test_a_recording_is_not_written_over_by_one_of_another_kind(place, capfd):
    shutil.copy(ROOT / "sample_recordings" / "x_laser.rtl", "x.rtl")
    Path("mine.csv").write_text(Path(Z).read_text().replace("simulated = true", "measured = true"))
    for words in (
        ("recordings", "x.rtl", "--as", "mine.csv"),
        ("simulate", "--test", "positioning:Z,runs=1", *STUDER, "-o", "mine.csv"),
        ("simulate", "--test", "angle:Z,runs=1", *STUDER, "--program-out", "a.nc"),
        ("recordings", "x.rtl", "--session", "s.toml"),
        ("recordings", "x.rtl", "--session", "s.toml"),
    ):
        if words[-1] == "s.toml" and not Path("s.toml").exists():
            assert cli.main([*words]) == 0
            continue
        assert cli.main([*words]) == 2, words
        assert "is there already" in capfd.readouterr().err
    assert "measured = true" in Path("mine.csv").read_text()


def test_a_program_is_not_written_over_itself_without_force(place, capfd):
    Path("link.nc").symlink_to("a.nc")
    for name in ("a.nc", "./a.nc", "link.nc"):
        assert cli.main(["a.nc", *STUDER, "-o", name]) == 2
        assert "would be lost" in capfd.readouterr().err
    assert Path("a.nc").read_text() == PROGRAM
    assert cli.main(["a.nc", *STUDER, "-o", "a.nc", "--force"]) == 0
    assert "GCOMP" in Path("a.nc").read_text()


def test_a_mark_is_found_wherever_it_stands(place):
    """The mark of a corrected program stands before the first block that was changed: behind two
    chunks here, and across their edge."""
    from postproc import marks, standing

    for blocks in (standing.CHUNK - 3, 2 * standing.CHUNK + 5):
        Path("long.nc").write_bytes(b"\n" * blocks + b"(GCOMP 0.1.0 M MAP 0 TOL 1 UM)\n")
        standing.result("long.nc", marks.PROGRAM, "")
    for special in ("-", "/dev/null", "nothing/there.nc"):
        standing.result(special, marks.PROGRAM, "")


@pytest.mark.parametrize(
    ("name", "words", "text"),
    [
        ("mine.nc", ("a.nc", *STUDER, "-o"), "(FOR GCOMP USE: G54 AT THE FACE)\n" + PROGRAM),
        ("mine.nc", ("a.nc", *STUDER, "-o"), "(GCOMP PART)\n" + PROGRAM),
        ("mine.svg", ("iso", Z, "--figure"), '<svg inkscape:export-filename="/gcomp/a.png"/>'),
    ],
)
def test_a_file_that_only_names_gcomp_is_a_persons(place, name, words, text):
    Path(name).write_text(text)
    assert cli.main([*words, name]) == 2
    assert Path(name).read_text() == text


def test_a_program_in_which_nothing_is_changed_is_written_twice(place):
    """It holds no mark, and is the program itself to the byte: nothing is lost."""
    words = ("a.nc", "--machine", "perfect", "-o", "out.nc")
    for _ in range(2):
        assert cli.main([*words]) == 0
        assert Path("out.nc").read_text() == PROGRAM


def test_what_holds_nothing_is_kept_for_nobody(place):
    from postproc import standing

    os.mkfifo("pipe")
    Path("empty").touch()
    Path("full").write_text("mine")
    Path("lost").symlink_to("nowhere")
    for path in ("-", os.devnull, "pipe", "empty", "nothing"):
        standing.kept(path, False)
    for path in ("full", "lost", "."):
        with pytest.raises(UsageError, match="is there already"):
            standing.kept(path, False)


EMPTY = {"empty": ("", "it is empty"), "comment": ("(no more than this)\n", "no axis moves in it")}


@pytest.mark.parametrize("kind", EMPTY)
def test_a_program_without_a_motion_is_warned_of(place, capfd, kind):
    text, says = EMPTY[kind]
    Path("b.nc").write_text(text)
    for words in (
        ("b.nc", *STUDER, "-o", "c.nc"),
        ("b.nc", *STUDER, "-o", "d.nc", "--quiet"),
        ("b.nc", "--machine", "perfect", "-o", "e.nc"),
        ("b.nc", *STUDER, "--dry-run"),
        ("b.nc", *STUDER, "--unbuffered"),
        ("explain", "b.nc", *STUDER),
        ("show", "b.nc", *STUDER, "-o", "b.html"),
    ):
        assert cli.main([*words]) == 0, words
        assert f"gcomp: warning: b.nc: {says}" in capfd.readouterr().err, words
    assert cli.main(["batch", "b.nc", *STUDER, "-o", "out", "-j", "1"]) == 0
    assert "gcomp: warning: b.nc: no axis moves in it" in capfd.readouterr().err
    assert cli.main(["a.nc", *STUDER, "-o", "f.nc"]) == 0
    assert "warning" not in capfd.readouterr().err
