"""`gcomp export` as a user does it: files, the table of what is left, what is unverified, and
nothing overwritten."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from pytest import approx

from postproc import control_tables
from postproc.cli import main
from postproc.machine import overshoot
from postproc.machine.file import read_machine

ROOT = Path(__file__).resolve().parents[1]
STUDER = ROOT / "machines" / "studer-s36"
SEED = ROOT.parent / "shared" / "seed"


def gcomp(*words: str) -> int:
    return main(["export", *map(str, words)])


def export(out: Path, control: str, *more: str) -> int:
    stated = [
        w
        for key in getattr(control_tables.load(control), "STATED", {})
        for w in ("--set", f"{key}=-")
    ]
    return gcomp("--machine", STUDER, "--control", control, "-o", out, *stated, *more)


def test_the_table_says_component_nodes_correction_and_what_is_left(tmp_path, capsys):
    assert export(tmp_path, "linuxcnc") == 0
    out = capsys.readouterr().out
    rows = {line.split()[0]: line for line in out.splitlines() if line.startswith("E")}
    assert rows["EXX"].split() == ["EXX", "18", "30.50", "um", "0.000", "um", "not", "stated"]
    assert "not written" in rows["EZX"] and "80.71" in rows["EZX"]
    assert (
        "ignores BACKLASH" in out
        and "a table of one axis can not hold" in out
        and "diameters" in out
    )
    assert sorted(p.name for p in tmp_path.iterdir()) == ["X.comp", "Z.comp"]
    assert (tmp_path / "X.comp").read_text().startswith("0.000000 0.008400 -0.000400\n")


@pytest.mark.parametrize(
    "control", [n for n in control_tables.names() if not control_tables.load(n).VERIFIED]
)
def test_what_is_unverified_is_said_loudly(control, tmp_path, capsys):
    assert export(tmp_path / "out", control, "--reference", "X=180,Z=520") == 0
    assert "UNVERIFIED: " in capsys.readouterr().out


def test_nothing_is_overwritten_without_force_and_then_no_file_is_touched(tmp_path, capsys):
    (tmp_path / "Z.comp").write_text("mine")
    assert export(tmp_path, "linuxcnc") == 2
    assert "Z.comp is there already" in capsys.readouterr().err
    assert (tmp_path / "Z.comp").read_text() == "mine" and not (tmp_path / "X.comp").exists()
    assert export(tmp_path, "linuxcnc", "--force") == 0
    assert (tmp_path / "Z.comp").read_text() != "mine"
    # no half-written file beside them
    assert sorted(p.name for p in tmp_path.iterdir()) == ["X.comp", "Z.comp"]


def stated(folder: Path) -> Path:
    """A machine whose folder states U of all it states."""
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    for x in "XYZ":
        components = [f"E{along}{x}" for along in "XYZ"]
        head = ",".join([f"{x}_mm", *(f"{c}_um" for c in components)])
        (folder / f"{x}.csv").write_text(f"{head}\n-10000,5,6,7\n10000,8,9,10\n")
        (folder / f"{x}_uncertainty.csv").write_text(f"{head}\n-10000,1,2,3\n10000,1,2,3\n")
    return folder


@pytest.mark.parametrize(
    ("control", "components"),
    [
        ("linuxcnc", ["EXX", "EYY", "EZZ"]),
        ("heidenhain", [f"E{a}{b}" for b in "XYZ" for a in "XYZ"]),
        ("isg-csv", [f"E{a}{b}" for b in "XYZ" for a in "XYZ"]),
    ],
)
def test_the_uncertainty_is_of_what_is_written(tmp_path, control, components):
    """LinuxCNC has no table of Y that corrects X, the others have."""
    machine = stated(tmp_path / "m")
    words = ("-o", f"{tmp_path / 'out'}/", "--uncertainty", tmp_path / "U.csv")
    assert gcomp("--machine", machine, "--control", control, *words) == 0
    rows = [line.split(",") for line in (tmp_path / "U.csv").read_text().splitlines()[2:]]
    assert list(dict.fromkeys(name for name, *_ in rows)) == components
    of = dict(zip("XYZ", (1.0, 2.0, 3.0), strict=True))
    assert all(float(u) == approx(of[name[1]]) for name, _, u in rows)


@pytest.mark.parametrize(
    ("there", "says"),
    [
        ("out/X.comp", "X.comp is there already"),
        ("U.csv", "U.csv is there already"),
        ("rest/a", "rest is there already"),
    ],
)
def test_of_tables_uncertainty_and_residual_all_are_written_or_none(tmp_path, capsys, there, says):
    machine = stated(tmp_path / "m")
    (tmp_path / there).parent.mkdir(exist_ok=True)
    (tmp_path / there).write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    words = ("-o", f"{tmp_path / 'out'}/", "--uncertainty", tmp_path / "U.csv")
    more = (*words, "--residual", tmp_path / "rest")
    assert gcomp("--machine", machine, "--control", "linuxcnc", *more) == 2
    assert says in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_nothing_is_written_where_the_folder_of_the_tables_can_not_be_made(tmp_path, capsys):
    (tmp_path / "taken").write_text("mine")
    words = ("-o", f"{tmp_path / 'taken' / 'out'}/", "--residual", tmp_path / "rest")
    assert gcomp("--machine", stated(tmp_path / "m"), "--control", "linuxcnc", *words) == 2
    assert "can not be written" in capsys.readouterr().err
    assert not (tmp_path / "rest").exists()


def test_a_single_file_may_be_named_and_several_need_a_folder(tmp_path, capsys):
    assert export(tmp_path / "EEC.INI", "siemens-enc-comp") == 0
    assert (tmp_path / "EEC.INI").is_file()
    (tmp_path / "file").write_text("")
    assert export(tmp_path / "file", "linuxcnc") == 2
    assert "-o FOLDER" in capsys.readouterr().err


def test_only_an_axis_or_a_component_is_written_when_asked_for(tmp_path, capsys):
    assert export(tmp_path / "z", "siemens-cec", "--axis", "Z") == 0
    text = (tmp_path / "z").read_text()
    assert (
        "INPUT_AXIS[0]=(AX3)" in text
        and "(AX1)\n$AN_CEC_STEP" in text
        and "INPUT_AXIS[0]=(AX1)" not in text
    )
    assert export(tmp_path / "c", "siemens-cec", "--component", "EZX") == 0
    assert (tmp_path / "c").read_text().count("OUTPUT_AXIS") == 2
    capsys.readouterr()
    assert export(tmp_path / "d", "siemens-cec", "--component", "EYX") == 2
    assert "components: EXX, EZX, EXZ, EZZ" in capsys.readouterr().err
    assert export(tmp_path / "d", "siemens-cec", "--axis", "Y") == 2


def test_what_a_table_takes_out_reads_as_an_axis_table_of_a_machine(tmp_path, capsys):
    """Written for LinuxCNC, read back, put in the machine's place: the same positioning errors, to
    the nanometre."""
    assert export(tmp_path, "linuxcnc") == 0
    capsys.readouterr()
    assert gcomp("--read", tmp_path / "Z.comp", "--control", "linuxcnc") == 0
    copy = tmp_path / "copy"
    shutil.copytree(STUDER, copy)
    (copy / "Z.csv").write_text(capsys.readouterr().out)
    mine, other = read_machine(STUDER).tables["Z"], read_machine(copy).tables["Z"]
    assert other.forward[2] == approx(mine.forward[2], abs=1e-6)
    assert other.reverse[2] == approx(mine.reverse[2], abs=1e-6)
    assert not other.forward[0].any()  # straightness was not in it


@pytest.mark.skipif(not SEED.exists(), reason="the seed's tables are not here")
def test_fanucs_numbers_are_read_with_their_settings(capsys):
    pitch, settings = (
        SEED / "table_7_2_mv1060_fanuc_pitch.csv",
        SEED / "table_7_2_mv1060_fanuc_settings.csv",
    )
    assert gcomp("--read", pitch, "--settings", settings, "--control", "fanuc", "--axis", "Y") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1:3] == ["Y_mm,EYY_um_fwd,EYY_um_rev", "-600,11,13"]
    assert gcomp("--read", pitch, "--control", "fanuc") == 2
    assert "--settings FILE" in capsys.readouterr().err


def test_table_7_2_goes_through_the_machine_by_the_commands_of_its_readme(tmp_path, capsys):
    """Read into a file for each axis, and written again from the machine: the same 82 numbers, byte
    for byte."""
    folder = Path(__file__).resolve().parents[1] / "machines" / "mv-1060"
    pitch, settings = folder / "fanuc_pitch.csv", folder / "fanuc_settings.csv"
    assert (
        gcomp("--read", pitch, "--settings", settings, "--control", "fanuc", "-o", f"{tmp_path}/t/")
        == 0
    )
    assert sorted(p.name for p in (tmp_path / "t").iterdir()) == ["X.csv", "Y.csv", "Z.csv"]
    assert "-600,11,13" in (tmp_path / "t" / "Y.csv").read_text().splitlines()
    words = [
        w
        for w in (
            (folder / "README.md")
            .read_text()
            .split("gcomp export --machine mv-1060")[1]
            .split("numbers/")[0]
            .split()
        )
        if w != "\\"
    ]
    assert gcomp("--machine", folder, *words, f"{tmp_path}/n/") == 0
    assert (tmp_path / "n" / "mv-1060_pitch.csv").read_bytes() == pitch.read_bytes()
    assert pitch.read_bytes().count(b"\n") == 83
    assert (
        gcomp("--read", pitch, "--settings", settings, "--control", "fanuc", "-o", f"{tmp_path}/t/")
        == 2
    )
    assert "is there already" in capsys.readouterr().err


def test_a_sign_that_no_source_gives_has_to_be_said(tmp_path, capsys):
    assert gcomp("--machine", STUDER, "--control", "siemens-cec", "-o", f"{tmp_path}/c/") == 2
    assert "is in no source that we know" in capsys.readouterr().err
    assert not (tmp_path / "c").exists()
    for sign in "-+":
        assert (
            gcomp(
                "--machine",
                STUDER,
                "--control",
                "siemens-cec",
                "-o",
                f"{tmp_path}/c{sign}/",
                "--set",
                f"cec_sign={sign}",
            )
            == 0
        )
    one, other = ((tmp_path / f"c{s}" / "NC_CEC.INI").read_text() for s in "-+")
    assert one != other and len(one.splitlines()) == len(other.splitlines())


def test_a_broken_table_names_file_and_line(tmp_path, capsys):
    (tmp_path / "X.comp").write_text("; nominal\n0 0 0\n")
    assert gcomp("--read", tmp_path / "X.comp", "--control", "linuxcnc") == 2
    assert f"{tmp_path}/X.comp:1: not three numbers" in capsys.readouterr().err


def test_the_list_shows_every_control_with_its_sign(capsys):
    assert gcomp("--list") == 0
    out = capsys.readouterr().out
    for name in control_tables.names():
        assert f"\n{name}" in f"\n{out}"
    assert out.count("sign: ") == len(control_tables.names()) and "UNVERIFIED" in out
    assert gcomp("--list", "--control", "fanuc") == 0
    assert "--set range_X" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--control", "linuxcnc"], "either --machine M is written, or --read FILE is read"),
        (["--machine", str(STUDER)], "--control is missing"),
        (
            ["--machine", str(STUDER), "--control", "nope", "-o", "x"],
            "there are no tables of a control 'nope'",
        ),
        (["--machine", str(STUDER), "--control", "linuxcnc"], "-o is missing"),
        (
            ["--machine", str(STUDER), "--control", "linuxcnc", "-o", "x", "--set", "typ=1"],
            "has no such key",
        ),
        (
            ["--machine", str(STUDER), "--control", "linuxcnc", "-o", "x", "--set", "type=7"],
            "type = '7' is not known",
        ),
        (
            ["--machine", str(STUDER), "--control", "fanuc", "-o", "x", "--first", "X=1.5"],
            "without a fraction",
        ),
        (
            ["--machine", str(STUDER), "--control", "fanuc", "-o", "x", "--reference", "X:1"],
            "is not like X=0",
        ),
        (["--machine", str(STUDER), "--control", "fanuc", "-o", "x", "--step", "-1"], "above zero"),
    ],
)
def test_a_command_line_that_can_not_be_is_one_sentence(words, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert gcomp(*words) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_template_is_filled(tmp_path):
    (tmp_path / "empty.com").write_text(
        "BEGIN A.COM MM\nNR      AXISPOS     X           Z           BACKLASH\n[END]\n"
    )
    assert (
        export(
            tmp_path / "t", "heidenhain", "--template", str(tmp_path / "empty.com"), "--axis", "Z"
        )
        == 0
    )
    lines = (tmp_path / "t").read_text().splitlines()
    assert lines[0] == "BEGIN A.COM MM" and lines[2].split() == [
        "0",
        "0.00000",
        "-0.00025",
        "0.00070",
        "0.00200",
    ]


def test_a_map_that_overshoots_is_named_with_its_numbers(tmp_path, capsys):
    """X of the grinder as its source states it: EXX forward 8.4 um and reverse -0.4 um at the first
    node, and so on."""
    assert export(tmp_path, "linuxcnc", "--axis", "X") == 0
    out = capsys.readouterr().out
    assert (
        "EXX goes beyond its command" in out
        and "-9.8 to +1.9 um, -9.6 in the median" in out
        and "EZZ goes" not in out
    )
    assert main(["machines", "show", "studer-s36"]) == 0
    assert "in doubt: EXX goes beyond its command" in capsys.readouterr().out


@pytest.mark.parametrize(
    "name", ["mv-1060", "example-mill", "example-lathe", "example-five-axis", "perfect"]
)
def test_a_map_that_lags_is_not(name):
    assert overshoot.found(read_machine(ROOT / "machines" / name)) == []


def test_effects_and_the_table_are_judged_together(tmp_path):
    """The mill's X lags by 5.2 um and more (its first node -2.50 and +2.50 um); a backlash of -20
    um on top turns that."""
    shutil.copytree(ROOT / "machines" / "example-mill", tmp_path / "mill")
    with open(tmp_path / "mill" / "machine.toml", "a") as file:
        file.write('\n[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = -20.0\n')
    (said,) = overshoot.found(read_machine(tmp_path / "mill"))
    assert said.startswith("EXX goes beyond its command")
    assert overshoot.found(read_machine(tmp_path / "mill"), "Y") == []
