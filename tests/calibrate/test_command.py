"""`gcomp calibrate` as a user meets it: recordings on disk, a machine folder, what is printed and
what is refused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc import cli
from postproc.commands import calibrate as command
from postproc.errors import MachineError
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.machine.lacks import lacks, sentence
from postproc.machine.uncertainty import AlongPath, MapUncertainty
from postproc.recordings import contract
from tests.calibrate.simulation import everything, recording, truth, two_axes

REST = {"X": 80.0, "Z": 200.0}
ASKED = ("--chain", "w-b-Z-X-t", "--control", "fanuc-lathe", "--least-increment", "0.0001mm")


@pytest.fixture
def made(tmp_path):
    """A grinder, its recordings on disk, and their names."""
    rng = np.random.default_rng(21)
    machine = two_axes(rng)
    names = []
    for part in everything(rng, machine, REST, u=0.05):
        path = tmp_path / part.file
        path.write_text(contract.write(part))
        names.append(str(path))
    return machine, names, tmp_path


def run(capsys, *arguments) -> tuple[int, str, str]:
    status = cli.main(["calibrate", *map(str, arguments)])
    out, err = capsys.readouterr()
    return status, out, err


def test_recordings_become_a_machine_that_every_command_reads(made, capsys):
    machine, names, place = made
    status, out, err = run(
        capsys,
        *names,
        *ASKED,
        "--squareness",
        "B0X=-120.5,3",
        "-o",
        place / "mine",
        "--json",
        place / "r.json",
    )
    assert (status, err) == (0, "")
    written = read_machine(place / "mine")
    assert (written.name, written.control, written.chain.axes) == (
        "mine",
        "fanuc-lathe",
        ("Z", "X"),
    )
    assert written.square["X"][1] == approx(-120.5e-6)
    assert list(written.axes["Z"].measured_at) == [80.0, 0, 0]
    assert written.axes["Z"].travel == (0.0, 510.0)
    for name in ("EZZ", "EXZ", "EXX", "EZX"):
        table = written.tables[name[2]]
        expected = truth(machine[name[2]], name, REST)
        assert table.forward["XYZ".index(name[1])] * 1e3 == approx(expected[0], abs=0.6)
        assert table.reverse["XYZ".index(name[1])] * 1e3 == approx(expected[1], abs=0.6)
    text = (place / "mine" / "machine.toml").read_text()
    assert "B0X = -120.5" in text and "u = 3, k = 1; stated" in text
    assert "not stated" in text  # the travels
    assert cli.main(["machines", "show", str(place / "mine")]) == 0
    assert "EBZ" in capsys.readouterr().out
    for name in names:
        assert Path(name).stem in out
    data = json.loads((place / "r.json").read_text())
    assert [c["component"] for c in data["components"]] == ["EXX", "EZX", "EBZ", "EXZ", "EZZ"]
    assert data["squareness"][0]["u_urad"] == approx(3.0)
    assert len(data["sha256"]) == 5


def test_the_runs_stand_beside_the_table(made, capsys):
    _, names, place = made
    run(capsys, *names, *ASKED, "-o", place / "mine")
    lines = [
        x for x in (place / "mine" / "Z_runs.csv").read_text().splitlines() if not x.startswith("#")
    ]
    assert lines[0] == "Z_mm,component,approach,unit,runs,mean,s,value,u,U95"
    assert len(lines) == 1 + 3 * 2 * 18
    for line in lines[1:]:
        cells = line.split(",")
        assert cells[4] == "5"
        assert 0.05 < float(cells[8]) < 0.4
        assert float(cells[9]) == approx(2 * float(cells[8]), abs=1.1e-4)


def test_what_is_written_of_the_uncertainty_is_read_back(made, capsys):
    """U = 2 u of every node and direction, as the file of the runs tells it; the squareness was
    stated with u = 3 urad."""
    _, names, place = made
    run(capsys, *names, *ASKED, "--squareness", "B0X=-120.5,3", "-o", place / "mine")
    written = read_machine(place / "mine")
    assert written.square_u == approx({"B0X": 6e-6})
    assert MapUncertainty(written).missing == ()
    for letter in "XZ":
        u, table = written.axes[letter].uncertainty.table, written.tables[letter]
        assert u.nodes == approx(table.nodes)
        text = (place / "mine" / f"{letter}_runs.csv").read_text()
        rows = [line.split(",") for line in text.splitlines() if line[0] not in "#XZ"]
        assert rows
        for node, component, approach, *_, u95 in rows:
            values = u.forward if approach == "+" else u.reverse
            row = [f"E{d}{letter}" for d in "XYZABC"].index(component)
            size = values[row, np.flatnonzero(u.nodes == float(node))[0]]
            assert size == approx(float(u95) * (1e-3 if row < 3 else 1e-6), abs=1e-9)
    text = (place / "mine" / "machine.toml").read_text()
    assert "[squareness.u]\nB0X = 6.0" in text


def test_the_mean_of_both_directions_is_known_as_well_as_they_are_in_the_mean(made, capsys):
    _, names, place = made
    for name, more in (("two", ()), ("one", ("--mean",))):
        assert run(capsys, *names, *ASKED, *more, "-o", place / name)[0] == 0
    two, one = (read_machine(place / name).axes["Z"].uncertainty.table for name in ("two", "one"))
    assert (one.forward == one.reverse).all() and two.mean[2].any()
    assert one.forward == approx(two.mean, abs=2e-7)


def test_an_uncertainty_that_is_not_known_is_not_written(tmp_path, capsys):
    """One run of an instrument that states none; what others state is read all the same."""
    rng = np.random.default_rng(3)
    machine = two_axes(rng)
    names = []
    for part in everything(rng, machine, REST, runs=1, u=None):
        path = tmp_path / part.file
        path.write_text(contract.write(part))
        names.append(path)
    assert (
        run(capsys, *names, *ASKED, "--squareness", "B0X=-120.5", "-o", tmp_path / "mine")[0] == 0
    )
    assert not list((tmp_path / "mine").glob("*_uncertainty.csv"))
    assert (
        AlongPath(read_machine(tmp_path / "mine")).report()
        == "the map's own uncertainty is not stated"
    )


def test_without_a_chain_those_of_the_usual_kinds_are_offered(made, capsys):
    status, _, err = run(capsys, *made[1], "--control", "haas")
    assert status == 2 and "w-X-Y-b-Z-t mill" in err and "or --like MACHINE" in err


def test_what_machines_of_a_kind_share_comes_from_one_that_is_alike(made, capsys):
    """Control, chain, travels and limits; what is the other's own is not taken, and that is
    said."""
    _, names, place = made
    status, out, _ = run(capsys, *names, "--like", "studer-s36", "-o", place / "mine")
    assert status == 0
    assert {p.name for p in (place / "mine").iterdir()}.isdisjoint({"README.md"})
    text = (place / "mine" / "machine.toml").read_text()
    assert "[offsets]" not in text and "[tool]" not in text and "Studer" not in text
    for section in ("offsets", "tool", "squareness"):
        assert f"not taken from studer-s36: {section}: " in out
    machine = read_machine(place / "mine")
    assert machine.axes["Z"].travel == (-5.0, 520.0)
    assert machine.diameter == ("X",)
    assert machine.control == "fanuc-lathe" and machine.chain.axes == ("Z", "X")
    assert machine.limits.max_correction == 0.5
    assert (machine.title, machine.offsets, machine.tool.any()) == ("mine", {}, False)
    assert not machine.square, "its squareness is not ours"
    assert "calibrated by gcomp from" in machine.source


def test_no_zero_is_invented(made, capsys):
    """A program in G54 would cut at the machine's zero, and nobody said that the part lies
    there."""
    _, names, place = made
    assert run(capsys, *names, *ASKED, "-o", place / "mine")[0] == 0
    assert read_machine(place / "mine").offsets == {}
    (place / "part.nc").write_text("G90 G21 G54\nG1 X200. Z400. F100\nM30\n")
    assert cli.main([str(place / "part.nc"), "--machine", str(place / "mine")]) == 2
    assert "G54 is not stated" in capsys.readouterr().err


def test_what_the_map_lacks_is_said_in_the_output_in_the_file_and_when_it_is_shown(made, capsys):
    """100 urad over the longer travel, 510 mm of Z: 51 um. EBX is not among the recordings."""
    _, names, place = made
    says = [
        "squareness of XZ, not measured: 100 urad would be 51.0 um at the far corner",
        "EBX: never measured",
        (
            "Z beyond 0 to 510 mm, where it was measured; the travel goes 40 mm beyond it: places"
            " there are refused"
        ),
        "a proof of its signs (unverified)",
    ]
    wider = ("--travel", "Z=-10,550")
    _, out, _ = run(
        capsys, *names, *ASKED, *wider, "-o", place / "mine", "--json", place / "r.json"
    )
    told = out.split("not in this map:")[1]
    text = (place / "mine" / "machine.toml").read_text()
    capsys.readouterr()
    assert cli.main(["machines", "show", str(place / "mine")]) == 0
    shown = capsys.readouterr().out
    says[0] = says[0].replace("51.0", "56.0")  # of the travel that is stated
    for one in says:
        assert one in told
        assert f"# Not in this map: {one}" in text
        assert f"not in this map: {one}" in shown
    assert len(json.loads((place / "r.json").read_text())["not_in_this_map"]) == 4
    square = ("--squareness", "B0X=0")  # zero, and stated
    _, out, _ = run(capsys, *names, *ASKED, *square, "-o", place / "square")
    assert "squareness of XZ" not in out
    assert not any("squareness" in one for one in lacks(read_machine(place / "square")))


def test_what_was_measured_and_left_out_is_not_called_unmeasured(made, capsys):
    machine, names, place = made
    rng = np.random.default_rng(4)
    axis = machine["X"]
    quiet = recording(rng, axis, "EBX", {"Z": 200.0}, noise=0.5, u=0.2)
    quiet.columns["reading_urad"][:] = rng.normal(0, 0.5, len(quiet))
    (place / "EBX.csv").write_text(contract.write(quiet))
    assert run(capsys, *names, place / "EBX.csv", *ASKED, "-o", place / "mine")[0] == 0
    written = read_machine(place / "mine")
    assert written.axes["X"].left_out == ("EBX",)
    assert not any("EBX" in one for one in lacks(written))
    assert not any("never measured" in one for one in lacks(written))


def test_a_perfect_machine_lacks_nothing_and_a_verified_one_its_proof_no_more(made, capsys):
    _, names, place = made
    assert sentence(places.load("perfect")) == ""
    assert sentence(places.load("example-mill")) == ""
    run(capsys, *names, *ASKED, "-o", place / "mine")
    toml = place / "mine" / "machine.toml"
    assert "unverified" in sentence(read_machine(place / "mine"))
    toml.write_text(toml.read_text().replace('signs = "unverified"', 'signs = "verified"'))
    assert "unverified" not in sentence(read_machine(place / "mine"))
    toml.write_text(toml.read_text().replace('signs = "verified"', 'signs = "good"'))
    with pytest.raises(MachineError, match="signs = 'good'"):
        read_machine(place / "mine")


def test_the_play_is_not_counted_twice(made, capsys):
    """Backlash of the machine that is copied would be added to two-way tables that contain it."""
    _, names, place = made
    assert run(capsys, *names, *ASKED, "-o", place / "first")[0] == 0
    with open(place / "first" / "machine.toml", "a") as file:
        file.write('\n[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 9.0\n')
    status, out, _ = run(capsys, *names, "--like", place / "first", "-o", place / "second")
    assert status == 0
    assert "not taken" in out and "backlash of X" in out
    assert not read_machine(place / "second").effects


@pytest.mark.parametrize(
    "missing, option", [(0, "--chain"), (2, "--control"), (4, "--least-increment")]
)
def test_what_is_not_said_is_asked_for_by_its_option(made, capsys, missing, option):
    _, names, place = made
    asked = [a for i, a in enumerate(ASKED) if i not in (missing, missing + 1)]
    status, _, err = run(capsys, *names, *asked, "-o", place / "mine")
    assert status == 2
    assert option in err and "--like" in err
    assert not (place / "mine").exists()


def test_a_folder_is_not_written_over_without_force(made, capsys):
    _, names, place = made
    target = place / "mine"
    assert run(capsys, *names, *ASKED, "-o", target)[0] == 0
    (target / "README.md").write_text("mine")
    status, _, err = run(capsys, *names, *ASKED, "-o", target)
    assert status == 2 and "--force" in err
    status, out, _ = run(capsys, *names, *ASKED, "-o", target, "--force")
    assert status == 0 and "mine.bak" in out
    assert (place / "mine.bak" / "README.md").read_text() == "mine"
    assert not (target / "README.md").exists()
    (place / "other").mkdir()
    status, _, err = run(capsys, *names, *ASKED, "-o", place / "other", "--force")
    assert status == 2 and "no machine folder" in err
    assert not [p for p in place.iterdir() if p.name.startswith(".")], "nothing is left behind"


def test_a_machine_that_would_be_refused_is_not_written(made, capsys):
    machine, names, place = made
    rng = np.random.default_rng(1)
    axis = machine["X"]
    for side in (axis.forward, axis.reverse):
        side["EXX"] = side["EXX"] + np.where(axis.targets > 80, 100.0, 0.0)
    (place / "EXX.csv").write_text(contract.write(recording(rng, axis, "EXX", {"Z": 200.0})))
    status, _, err = run(capsys, *names, *ASKED, "-o", place / "mine")
    assert status == 2
    assert "um/mm" in err and "X.csv" in err
    assert not (place / "mine").exists()
    assert run(capsys, *names, *ASKED, "-o", place / "mine", "--accept-slope")[0] == 0
    assert read_machine(place / "mine").tables["X"].nodes[0] == -10


def test_an_outlier_is_shown_and_left_out_when_asked(made, capsys):
    _, names, place = made
    lines = (place / "EZZ.csv").read_text().splitlines()
    row = next(i for i, x in enumerate(lines) if not x.startswith("#")) + 12
    cells = lines[row].split(",")
    at = lines[row - 12].split(",").index("reading_um")
    cells[at] = f"{float(cells[at]) + 4:.4f}"
    lines[row] = ",".join(cells)
    (place / "EZZ.csv").write_text("\n".join(lines) + "\n")
    _, out, _ = run(capsys, *names, *ASKED)
    assert f"EZZ.csv:{row + 1}: EZZ at Z = 330, approached in +" in out
    assert "1 outlier, kept" in out and "nothing is written" in out
    _, out, _ = run(capsys, *names, *ASKED, "--drop-outliers")
    assert "1 outlier, left out" in out


def test_a_recording_twice_is_refused(made, capsys):
    _, names, _ = made
    status, _, err = run(capsys, names[0], names[0], *ASKED)
    assert status == 2 and "the same file" in err


@pytest.mark.parametrize(
    "arguments",
    [
        ("--squareness", "X0B=3"),
        ("--squareness", "B0X=abc"),
        ("--squareness", "B0X"),
        ("--travel", "Z=5"),
        ("--travel", "Z=9,5"),
        ("--lead", "Z=0"),
        ("--lead", "Q=5"),
        ("--datum", "Z"),
        ("--datum", "Z=x"),
        ("--chain", "w-t"),
        ("--control", "none-such"),
        ("--like", "none-such"),
        ("--column", "abc"),
        ("--figure", "picture.bmp"),
        ("--travel", "Y=0,5"),
        ("--datum", "Z=9999"),
    ],
)
def test_what_can_not_be_meant_is_refused_in_a_sentence(made, capsys, arguments):
    _, names, place = made
    status, _, err = run(capsys, *names, *ASKED, *arguments, "-o", place / "mine")
    assert status == 2
    assert len(err.strip()) > 20 and "Traceback" not in err
    assert not (place / "mine").exists()


def test_json_on_standard_output_is_nothing_but_json(made, capfd):
    _, names, _ = made
    assert cli.main(["calibrate", *names, *ASKED, "--json", "-"]) == 0
    out, err = capfd.readouterr()
    assert json.loads(out)["format"] == "gcomp-calibration/1"
    assert "EZZ" in err


def test_a_figure(made, capsys):
    pytest.importorskip("matplotlib", reason="the optional extra `figures`")
    _, names, place = made
    assert run(capsys, *names, *ASKED, "--figure", place / "c.png")[0] == 0
    assert (place / "c.png").read_bytes().startswith(b"\x89PNG")


def test_a_program_is_corrected_with_the_calibrated_machine(made, capsys):
    _, names, place = made
    run(capsys, *names, *ASKED, "--diameter", "X", "-o", place / "mine")
    (place / "part.nc").write_text("G90 G21 G54\nG0 X20. Z10.\nG1 X200. Z400. F100\nZ50.\nM30\n")
    status = cli.main(
        [
            str(place / "part.nc"),
            "--machine",
            str(place / "mine"),
            "--verify",
            "--offset",
            "G54=X0,Z0",
            "-o",
            str(place / "out.nc"),
        ]
    )
    out, err = capsys.readouterr()
    assert status == 0, err
    line = next(x for x in err.splitlines() if x.startswith("gcomp: not in the map: "))
    assert "squareness of XZ" in line and "EBX: never measured" in line and "unverified" in line
    assert (place / "out.nc").read_text() != (place / "part.nc").read_text()


def test_like_takes_the_folder_that_is_checked(tmp_path, monkeypatch):
    """A machine's folder that stands here goes before one of this name that comes with gcomp."""
    mill = places.folder_of("example-mill").resolve()
    monkeypatch.chdir(tmp_path)
    shutil.copytree(mill, "studer-s36")
    assert command.like_of("studer-s36")["chain"] == command.like_of(str(mill))["chain"]
