"""gcomp iso as it is called: table, JSON, figure, and one sentence for what can not be done."""

from __future__ import annotations

import json
import re
import sys

import numpy as np
import pytest
from iso_made import along, both_ways, seed, targets

from postproc.cli import main
from postproc.iso import Parameter, Result, figure, report
from postproc.recordings import contract


@pytest.fixture
def written(tmp_path):
    """Writes a recording, returns its path."""

    def write(recording, name="r.csv"):
        path = tmp_path / name
        path.write_text(contract.write(recording))
        return str(path)

    return write


@pytest.fixture
def z_axis():
    position, means = seed("dzz")
    return along("Z", position, means * 1e3, axes="XZ")


def test_table_of_an_axis(written, z_axis, capsys):
    assert main(["iso", written(z_axis), "--lead", "10", "--drift", "1"]) == 0
    out = capsys.readouterr().out
    lines = out.splitlines()
    assert lines[0] == "ISO 230-2  positioning  EZZ, X 0"
    assert lines[2].strip() == "Z moves, displacement is read along it"
    row = {
        line.split()[0]: line.split()
        for line in lines
        if line.startswith("  ") and len(line.split()) > 3
    }
    # E 11.6 by the design notes; U = 2 * 1 / (2 sqrt 3) = 0.58; nothing comes from the single runs.
    assert row["E"][1:4] == ["11.60", "0.58", "-"]
    assert row["M"][1] == "9.55" and row["A"][1:4] == ["-", "-", "-"]
    assert (
        "note: error with the period 10 mm (the lead of 10 mm): invisible: all targets lie at the"
        " same phase" in out
    )
    assert "note: one run: s, R and A are not defined" in out
    assert "device, misalignment, temperature, expansion" in out


def test_json_has_null_where_nothing_is_defined(written, z_axis, tmp_path, capfd):
    path = tmp_path / "out.json"
    assert main(["iso", written(z_axis), "--json", str(path)]) == 0
    data = json.loads(path.read_text())
    assert data["format"] == "gcomp-iso/1" and data["left_out"] == []
    (result,) = data["results"]
    assert (result["test"], result["standard"], result["unit"]) == (
        "positioning",
        "ISO 230-2",
        "um",
    )
    assert (
        result["parameters"]["E"]["value"] == pytest.approx(11.6)
        and result["parameters"]["E"]["U"] is None
    )
    assert result["parameters"]["R"]["value"] is None and result["columns"]["s + um"] == [None] * 18
    assert result["columns"]["target"] == list(range(0, 511, 30))
    capfd.readouterr()
    assert main(["iso", written(z_axis), "--json", "-"]) == 0
    captured = capfd.readouterr()
    assert json.loads(captured.out) == data and "ISO 230-2  positioning" in captured.err


def test_squareness_and_circles_are_printed(written, capsys):
    x = np.arange(0.0, 401, 50)
    one = along("X", x, np.tile(0.01 * x, (2, 1)), {"Y": 1.0}, "straightness")
    two = along("Y", x, np.tile(-0.05 * x, (2, 1)), {"X": 1.0}, "straightness")
    ball = both_ways(lambda t, w: 2.5 * np.sin(2 * t))
    assert (
        main(
            [
                "iso",
                written(one, "1.csv"),
                written(two, "2.csv"),
                written(ball, "3.csv"),
                "--u-square",
                "2",
            ]
        )
        == 0
    )
    out = capsys.readouterr().out
    assert "ISO 230-1  squareness  C0Y" in out and "90 degrees +40.0 urad" in out
    assert "ISO 230-4  circle  XY, radius 100 mm" in out and "one sense" not in out


@pytest.mark.parametrize("ending", ["svg", "png", "pdf"])
def test_figures(written, z_axis, tmp_path, capsys, ending):
    pytest.importorskip("matplotlib")
    path = tmp_path / f"out.{ending}"
    assert (
        main(
            [
                "iso",
                written(z_axis),
                written(both_ways(lambda t, w: w + np.cos(2 * t)), "b.csv"),
                "--figure",
                str(path),
            ]
        )
        == 0
    )
    data = path.read_bytes()
    assert data.startswith({"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[ending])
    assert (
        main(
            [
                "iso",
                written(z_axis),
                written(both_ways(lambda t, w: w + np.cos(2 * t)), "b.csv"),
                "--figure",
                str(path),
            ]
        )
        == 0
    )
    assert path.read_bytes() == data


def test_a_figure_holds_what_the_table_says(written, z_axis, tmp_path, capsys, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    monkeypatch.setitem(matplotlib.rcParams, "svg.fonttype", "none")
    path = tmp_path / "out.svg"
    main(
        [
            "iso",
            written(z_axis),
            written(both_ways(lambda t, w: 2.5 * np.sin(2 * t)), "b.csv"),
            "--figure",
            str(path),
        ]
    )
    drawn = path.read_text()
    for text in (
        "EZZ, X 0",
        "11.60",
        "9.55",
        "B 5.10",
        "mean, approached in +",
        "XY, radius 100 mm",
        "magnified",
        "+Y",
    ):
        assert text in drawn, text


def test_no_arrow_of_a_reversal_is_drawn_where_it_would_hide_the_curves(
    written, tmp_path, monkeypatch
):
    """0.4 um of 20 um are the width of the curves themselves; 4 um are an arrow."""
    matplotlib = pytest.importorskip("matplotlib")
    monkeypatch.setitem(matplotlib.rcParams, "svg.fonttype", "none")
    x = np.arange(0.0, 401, 50)
    for lost, arrow in ((0.4, False), (4.0, True)):
        recording = along("X", x, np.stack([x / 20, x / 20 - lost]))
        path = tmp_path / "out.svg"
        assert main(["iso", written(recording), "--figure", str(path)]) == 0
        assert bool(re.search(r"B \d", path.read_text())) == arrow


def test_figures_of_one_direction_and_of_other_kinds(written, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    x = np.arange(0.0, 401, 50)
    kinds = {
        "up": targets(
            {"X": np.tile(x, 3)},
            np.random.default_rng(1).normal(size=27),
            1.0 * np.ones(27),
            {"X": 1.0},
        ),
        "straight": along("X", x, np.sin(np.stack([x, x])), {"Y": 1.0}, "straightness"),
        "angle": along("X", x, np.stack([x, x]), {"Z": 1.0}, "angle"),
        "rotary": along("C", x[:7], np.stack([x[:7], x[:7]]), {"C": 1.0}, "angle"),
        "flat": along("X", x, np.zeros((2, 9))),
        "arc": both_ways(lambda t, w: 0.0).pick(np.arange(300)),
    }
    for name, recording in kinds.items():
        path = tmp_path / f"{name}.png"
        assert main(["iso", written(recording), "--figure", str(path)]) == 0, name
        assert path.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--figure", "out.jpg"], "a figure can not be written as out.jpg"),
        (["--lead", "0"], "a lead is above zero"),
        (["--lead", "Q=3"], "is not a number"),
        (["--drift", "-1"], "is below zero"),
        (["--temperature", "nan"], "is not a number"),
        (["--line", "best"], "invalid choice"),
    ],
)
def test_bad_options_are_one_sentence(written, z_axis, capsys, words, message):
    assert main(["iso", written(z_axis), *words]) == 2
    assert message in capsys.readouterr().err


def test_one_name_for_two_outputs_is_refused_before_anything_is_written(
    written, z_axis, tmp_path, capsys
):
    pytest.importorskip("matplotlib")
    name = str(tmp_path / "out.svg")
    assert main(["iso", written(z_axis), "--figure", name, "--json", name]) == 2
    assert not (tmp_path / "out.svg").exists()


def test_without_matplotlib_the_way_to_it_is_said(written, z_axis, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["iso", written(z_axis), "--figure", str(tmp_path / "a.png")]) == 2
    assert "pip install 'gcomp[figures]'" in capsys.readouterr().err
    assert not (tmp_path / "a.png").exists()


def test_a_set_without_a_figure_is_refused(written, capsys):
    result = Result("squareness", "ISO 230-1", "C0Y", "", "urad", (), ())
    pytest.importorskip("matplotlib")
    with pytest.raises(Exception, match="none of these results has a figure"):
        figure.draw([result], "png")


@pytest.mark.parametrize(
    ("noise_um", "digits"),
    [(3.0, 1), (1.0, 1), (0.99, 2), (0.3, 2), (0.05, 3), (30.0, 0), (0.0, 4)],
)
def test_one_more_digit_than_the_noise(noise_um, digits):
    result = Result(
        "positioning",
        "ISO 230-2",
        "EXX",
        "",
        "um",
        (),
        (Parameter("E", 1.23456e-3, ""),),
        noise=noise_um * 1e-3,
    )
    assert report.decimals(result) == digits
    (row,) = [
        line.split() for line in report.text([result]).splitlines() if line.startswith("  E ")
    ]
    assert row[1] == f"{1.23456:.{digits}f}"


def test_numbers_have_no_negative_zero():
    assert [report.number(v, 1) for v in (-0.04, 0.0, None, float("nan"), -0.06)] == [
        "0.0",
        "0.0",
        "-",
        "-",
        "-0.1",
    ]
