"""`gcomp simulate --nominal`: a corrected program read against the targets of the nominal one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc import cli
from postproc.recordings import Source, read

ROOT = Path(__file__).resolve().parents[2]


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def load(path: Path):
    return read(Source(str(path), path.read_bytes()))


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """The grinder's diagonal and its Z, nominal and corrected by its own map, without noise."""
    place = tmp_path_factory.mktemp("nominal")
    for test in (
        "diagonal:XZ,runs=2",
        "positioning:Z,runs=2",
        "straightness:Z,runs=2",
        "ballbar:XZ,runs=1",
    ):
        name = test[:4]
        simulate = ("simulate", "--machine", "studer-s36", "--quiet", "--test", test)
        assert (
            gcomp(*simulate, "--program-out", place / f"{name}.nc", "-o", place / f"{name}1.csv")
            == 0
        )
        words = (place / f"{name}.nc", "--machine", "studer-s36", "--outside", "clamp", "--quiet")
        assert gcomp("compensate", *words, "-o", place / f"{name}_c.nc") == 0
    lines = (place / "posi.nc").read_text().splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if line.startswith("G4"))
    (place / "part.nc").write_text("".join(lines[:first] + lines[first + 1 :]))
    return place


def again(place: Path, name: str, instrument: str, *more) -> int:
    words = (
        "simulate",
        place / f"{name}_c.nc",
        "--machine",
        "studer-s36",
        "--instrument",
        instrument,
        "--quiet",
    )
    return gcomp(*words, "--nominal", place / f"{name}.nc", "-o", place / f"{name}2.csv", *more)


@pytest.mark.parametrize(
    "name, instrument", [("diag", "laser"), ("posi", "laser"), ("stra", "straightness")]
)
def test_a_corrected_line_reads_nothing_on_the_nominal_targets(place, name, instrument):
    """The tool stands within the tolerance (0.5 um) of every target, an axis that rests within its
    hysteresis (1 um); targets, sides of approach, runs and direction are the nominal ones."""
    assert again(place, name, instrument) == 0
    before, after = (load(place / f"{name}{k}.csv") for k in (1, 2))
    for x in before.axes:
        assert (after.position(x) == before.position(x)).all()
        assert (after.approach(x) == before.approach(x)).all()
    assert after.sensitive == approx(before.sensitive, abs=1e-9)
    assert np.ptp(before.reading) > 5e-3
    assert np.abs(after.reading).max() < (1.0e-3 if name == "stra" else 0.5e-3)
    assert after.head["against"] == "nominal" and after.head["compensated"] is True


def test_against_the_commanded_targets_it_differs_by_the_correction(place):
    """actual - nominal = (actual - commanded) + (commanded - nominal), along the beam."""
    assert again(place, "posi", "laser") == 0
    out = place / "commanded.csv"
    words = (
        "simulate",
        place / "posi_c.nc",
        "--machine",
        "studer-s36",
        "--instrument",
        "laser",
        "--quiet",
        "-o",
        out,
    )
    assert gcomp(*words) == 0
    nominal, commanded = load(place / "posi2.csv"), load(out)
    shift = commanded.position("Z") - nominal.position("Z")
    assert np.abs(shift).max() > 1e-3
    assert nominal.reading == approx(commanded.reading + shift, abs=2e-7)


def test_diagnose_judges_it_beside_a_machine_without_errors(place, capsys):
    assert again(place, "diag", "laser", "--noise", "0.2") == 0
    capsys.readouterr()
    assert gcomp("diagnose", place / "diag2.csv", "--machine", "studer-s36") == 0
    told = capsys.readouterr()
    assert told.out.startswith("Nothing is left out")
    assert "what is found is what the map of studer-s36 left" in told.err
    assert (
        gcomp("diagnose", place / "diag1.csv", place / "diag2.csv", "--machine", "studer-s36") == 2
    )
    assert "diagnose each state by itself" in capsys.readouterr().err


@pytest.mark.parametrize(
    "program, nominal, instrument, says",
    [
        ("posi.nc", "posi.nc", "laser", "this one has no mark of it"),
        ("posi_c.nc", "posi_c.nc", "laser", "is corrected too"),
        ("posi_c.nc", "diag.nc", "laser", "beside the nominal one in X"),
        (
            "posi_c.nc",
            "part.nc",
            "laser",
            "the program rests at 68 targets, and the nominal one at 67",
        ),
        ("ball_c.nc", "ball.nc", "ballbar", "a ballbar has no targets of its own"),
    ],
)
def test_what_can_not_be_paired_is_refused(place, capsys, program, nominal, instrument, says):
    words = (
        "simulate",
        place / program,
        "--machine",
        "studer-s36",
        "--instrument",
        instrument,
        "--quiet",
    )
    assert gcomp(*words, "--nominal", place / nominal, "-o", place / "x.csv") == 2
    assert says in capsys.readouterr().err
    assert not (place / "x.csv").exists()
