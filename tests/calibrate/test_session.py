"""measurement.toml: one file says what each recording is, and every command that reads recordings
takes it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc import cli
from postproc.commands import session
from postproc.commands.recording_files import read_files
from postproc.machine.file import read_machine
from postproc.recordings import ReadingOptions, contract
from tests.calibrate.simulation import recording, two_axes

REST = {"X": 80.0, "Z": 200.0}
HEAD = 'format = "gcomp-measurement/1"\n'


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


@pytest.fixture
def place(tmp_path):
    """Four recordings of a grinder; two of them as tables that say neither component nor places."""
    rng = np.random.default_rng(4)
    machine = two_axes(rng)
    for name in ("EZZ", "EXZ", "EXX", "EZX"):
        one = recording(
            rng, machine[name[2]], name, {x: v for x, v in REST.items() if x != name[2]}, file=name
        )
        (tmp_path / f"{name}.csv").write_text(contract.write(one))
        moving = name[2]
        rows = zip(
            one.columns["run"],
            one.position(moving),
            one.approach(moving),
            one.columns["reading_um"],
        )
        lines = [
            "Target,Run,Direction,Deviation",
            *(f"{q:g},{r:g},{'+' if a > 0 else '-'},{v / 1e3:.6f}" for r, q, a, v in rows),
        ]
        (tmp_path / f"{name}_bare.csv").write_text("\n".join(lines) + "\n")
    return tmp_path


SESSION = (
    HEAD
    + """
[options]
like = "studer-s36"
squareness = ["B0X=-120.5,3"]
keep-all = true
u-random = true
max-slope = 50

[all]
others = { X = 80.0, Z = 200.0 }
temperature = { machine = 21.5 }

[[file]]
name = "EZZ_bare.csv"
component = "EZZ"
unit = "mm"

[[file]]
name = "EXX_bare.csv"
component = "EXX"
unit = "mm"
others = { Z = 150.0 }
sign = -1
head = { u_um = 0.3 }

[[file]]
name = "EZX.csv"
"""
)


def test_a_session_is_the_command_line_that_it_stands_for(place, capsys, monkeypatch):
    monkeypatch.chdir(Path(__file__).resolve().parents[2])
    (place / "m.toml").write_text(SESSION)
    assert (
        gcomp("calibrate", place / "m.toml", "--output", place / "a", "--json", place / "a.json")
        == 0
    )
    options = (
        "--like",
        "studer-s36",
        "--squareness",
        "B0X=-120.5,3",
        "--keep-all",
        "--u-random",
        "--max-slope",
        50,
    )
    flipped = (place / "EXX_bare.csv").read_text().splitlines()
    flipped[1:] = [
        ",".join([*line.split(",")[:3], str(-float(line.split(",")[3]))]) for line in flipped[1:]
    ]
    (place / "flipped.csv").write_text("\n".join(flipped))
    for name, component, others in (("EZZ_bare", "EZZ", "X80"), ("flipped", "EXX", "Z150")):
        more = ("--head", "u_um=0.3") if component == "EXX" else ()
        words = ("--component", component, "--unit", "mm", "--others", others, *more)
        assert (
            gcomp("recordings", place / f"{name}.csv", *words, "--as", place / f"_{component}.csv")
            == 0
        )
    files = [place / n for n in ("_EZZ.csv", "_EXX.csv", "EZX.csv")]
    assert gcomp("calibrate", *files, *options, "-o", place / "b") == 0
    capsys.readouterr()
    one, other = (read_machine(place / n) for n in ("a", "b"))
    for x in "XZ":
        assert np.abs(one.tables[x].forward - other.tables[x].forward).max() < 1e-9
        assert np.abs(one.tables[x].reverse - other.tables[x].reverse).max() < 1e-9
        assert (one.axes[x].measured_at == other.axes[x].measured_at).all()
    assert one.square["X"] == approx(other.square["X"])
    assert len(json.loads((place / "a.json").read_text())["sha256"]) == 3


def test_what_the_command_line_says_goes_before_the_session(place, capsys, monkeypatch):
    monkeypatch.chdir(Path(__file__).resolve().parents[2])
    (place / "m.toml").write_text(SESSION)
    words = (
        "calibrate",
        place / "m.toml",
        "--max-slope",
        "40",
        "-o",
        place / "a",
        "--title",
        "mine",
    )
    assert gcomp(*words) == 0
    made = read_machine(place / "a")
    assert made.title == "mine" and made.limits.max_slope == approx(0.04)
    capsys.readouterr()


def test_every_entry_is_heeded(place):
    (place / "m.toml").write_text(SESSION)
    first, second, third = read_files([str(place / "m.toml")], "", ReadingOptions())
    assert first.position("X").tolist() == [80.0] * len(first) and set(
        first.columns["T_machine_C"]
    ) == {21.5}
    assert not any("where the other axes stood" in text for text in first.notices)
    assert set(second.position("Z")) == {150.0} and second.u == approx(0.3e-3)
    raw = np.loadtxt(place / "EXX_bare.csv", delimiter=",", skiprows=1, usecols=3)
    assert np.sort(second.reading) == approx(np.sort(-raw))
    assert "the readings' sign is turned" in second.notices[-1]
    assert set(third.position("Z")) == {200.0}  # the file's own


def test_iso_and_recordings_take_it_too(place, capsys):
    (place / "m.toml").write_text(SESSION)
    assert gcomp("iso", place / "m.toml") == 0
    assert gcomp("recordings", place / "m.toml") == 0
    out = capsys.readouterr().out
    assert "stood at 150 mm" in out and "as " + str(place / "m.toml") + " says" in out


@pytest.mark.parametrize(
    "was, now, line, says",
    [
        ('name = "EZX.csv"', 'name = "gone.csv"', 28, "there is no file"),
        ("sign = -1", "sign = 3", 24, "sign = 3"),
        ("sign = -1", "sing = 3", 24, "'sing' is not a key of [file]"),
        ('unit = "mm"', "unit = 3", 17, "unit = 3 is not a text"),
        ("others = { X = 80.0,", "others = { Q = 80.0,", 11, "others names 'Q'"),
        ('format = "gcomp-measurement/1"', 'format = "x"', 1, "no session of a measurement"),
        ("keep-all = true", "keep-all = false", 6, "keep-all = False"),
        ("keep-all", "keep-al", 0, "unrecognized arguments: --keep-al"),
        ("[[file]]", "[[fil]]", 14, "'fil' is not a key"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(place, capsys, was, now, line, says):
    (place / "m.toml").write_text(
        SESSION.replace(was, now, 1) if was != "[[file]]" else SESSION.replace(was, now)
    )
    assert gcomp("calibrate", place / "m.toml", "--like", "perfect") == 2
    err = capsys.readouterr().err
    assert says in err and (f"m.toml:{line}:" in err or not line), err


def test_places_that_contradict_the_file_are_refused(place, capsys):
    (place / "m.toml").write_text(HEAD + '[[file]]\nname = "EZX.csv"\nothers = { Z = 10.0 }\n')
    assert gcomp("calibrate", place / "m.toml", "--like", "studer-s36") == 2
    assert "says that Z stood at 10" in capsys.readouterr().err


def test_a_first_session_is_written_from_files(place, capsys, monkeypatch):
    """What can be read stands in it, what can not with the reason; completed it calibrates."""
    monkeypatch.chdir(place)
    assert gcomp("recordings", "EZZ.csv", "EXX_bare.csv", "--session", "first.toml") == 0
    assert "1 of them can not be read yet" in capsys.readouterr().out
    text = (place / "first.toml").read_text()
    assert "# Z moves, displacement along Z: " in text and "# can not be read yet: " in text
    assert gcomp("recordings", "EZZ.csv", "--session", "first.toml") == 2
    assert "first.toml is there already" in capsys.readouterr().err
    done = text.replace('# component = "EXX"\n# unit = "um"', 'component = "EXX"\nunit = "mm"')
    (place / "first.toml").write_text(
        done.replace('# like = "example-mill"', 'like = "studer-s36"')
    )
    assert gcomp("calibrate", "first.toml", "--max-slope", "50") == 0
    assert len(session.entries("first.toml", ReadingOptions(), "")) == 2
    capsys.readouterr()
