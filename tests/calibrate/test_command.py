"""`gcomp calibrate` as a user meets it: recordings on disk, a machine folder, what is printed and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc import cli
from postproc.machine.file import read_machine
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
        capsys, *names, *ASKED, "--squareness", "B0X=-120.5,3", "-o", place / "mine", "--json", place / "r.json"
    )
    assert (status, err) == (0, "")
    written = read_machine(place / "mine")
    assert (written.name, written.control, written.chain.axes) == ("mine", "fanuc-lathe", ("Z", "X"))
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
    lines = [x for x in (place / "mine" / "Z_runs.csv").read_text().splitlines() if not x.startswith("#")]
    assert lines[0] == "Z_mm,component,approach,unit,runs,mean,s,value,u,U95"
    assert len(lines) == 1 + 3 * 2 * 18
    for line in lines[1:]:
        cells = line.split(",")
        assert cells[4] == "5"
        assert 0.05 < float(cells[8]) < 0.4
        assert float(cells[9]) == approx(2 * float(cells[8]), abs=1.1e-4)


def test_what_is_written_of_the_uncertainty_is_read_back(made, capsys):
    """U = 2 u of every node and direction, as the file of the runs tells it; the squareness was stated with u = 3 urad."""
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
    assert run(capsys, *names, *ASKED, "--squareness", "B0X=-120.5", "-o", tmp_path / "mine")[0] == 0
    assert not list((tmp_path / "mine").glob("*_uncertainty.csv"))
    assert AlongPath(read_machine(tmp_path / "mine")).report() == "the map's own uncertainty is not stated"


def test_everything_else_comes_from_a_machine_that_is_alike(made, capsys):
    _, names, place = made
    status, out, _ = run(capsys, *names, "--like", "studer-s36", "-o", place / "mine")
    assert status == 0
    machine = read_machine(place / "mine")
    assert machine.axes["Z"].travel == (-5.0, 520.0)
    assert machine.diameter == ("X",)
    assert machine.offsets == {"G54": {"X": 0.0, "Z": 0.0}}
    assert not machine.square, "its squareness is not ours"
    assert "calibrated by gcomp from" in machine.source


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


@pytest.mark.parametrize("missing, option", [(0, "--chain"), (2, "--control"), (4, "--least-increment")])
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


@pytest.mark.parametrize("arguments", [
    ("--squareness", "X0B=3"), ("--squareness", "B0X=abc"), ("--squareness", "B0X"), ("--travel", "Z=5"), ("--travel", "Z=9,5"),
    ("--lead", "Z=0"), ("--lead", "Q=5"), ("--datum", "Z"), ("--datum", "Z=x"), ("--chain", "w-t"), ("--control", "none-such"),
    ("--like", "none-such"), ("--column", "abc"), ("--figure", "picture.bmp"), ("--travel", "Y=0,5"), ("--datum", "Z=9999"),
])  # fmt: skip
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
        [str(place / "part.nc"), "--machine", str(place / "mine"), "--verify", "-o", str(place / "out.nc")]
    )
    out, err = capsys.readouterr()
    assert status == 0, err
    assert (place / "out.nc").read_text() != (place / "part.nc").read_text()
