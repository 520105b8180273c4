"""The page of a diagnosis: the noise band is the noise, rings lie where the residual file says,
names have probabilities, and what would be written is drawn as the written machine has it."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gcomp
from postproc.cli import main
from postproc.diagnose.findings import probable
from postproc.pages import diagnosis, left
from tests.api.schemas import held
from tests.pages import drawn

RECORDINGS = Path(__file__).resolve().parents[2] / "sample_recordings"

BAR = [
    "simulate",
    "--test",
    "ballbar:XZ",
    "--machine",
    "studer-s36",
    "--with",
    "backlash:Z:size_um=7",
    "--set",
    "rate=4",
]
SOAK = [
    "simulate", "--test", "soak:Z,hours=1,feed=6000", "--machine", "example-lathe",
    "--with", "screw_heat:Z:alpha_ppm_K=0,grown_ppm=60,fixed_um_K=0,tau_s=900,by_travel=1",
]  # fmt: skip


class Answer:
    """What `gcomp diagnose` wrote."""

    def __init__(self, folder: Path, line: list[str], machine: str):
        self.folder, recording = folder, folder / "r.csv"
        assert main([*line, "--noise", "0.4", "--seed", "5", "--quiet", "-o", str(recording)]) == 0
        words = [
            "--report",
            "p.html",
            "--json",
            "a.json",
            "--residuals",
            "left.csv",
            "--write-machine",
            "written",
        ]
        told = [str(folder / w) if not w.startswith("--") else w for w in words]
        assert main(["diagnose", str(recording), "--machine", machine, "--quiet", *told]) == 0
        self.page = folder / "p.html"
        self.html = self.page.read_text("utf-8")
        self.json = json.loads((folder / "a.json").read_text())
        self.rows = list(csv.DictReader((folder / "left.csv").open()))

    def column(self, name: str) -> np.ndarray:
        return np.array([float(r[name]) for r in self.rows])


@pytest.fixture(scope="module")
def bar(tmp_path_factory) -> Answer:
    return Answer(tmp_path_factory.mktemp("bar"), BAR, "studer-s36")


@pytest.fixture(scope="module")
def soak(tmp_path_factory) -> Answer:
    return Answer(tmp_path_factory.mktemp("soak"), SOAK, "example-lathe")


def test_the_figure_comes_first_and_nothing_is_asked_for(bar):
    assert drawn.outside(bar.html) == [] and len(bar.html) < 3_000_000
    assert (
        bar.html.index('id="circle-0"')
        < bar.html.index('id="left-0-place"')
        < bar.html.index("What was found")
    )


def test_the_json_fits_its_schema(bar, soak):
    held(bar.json)
    held(soak.json)


def test_the_noise_band_is_the_noise(bar):
    """White noise of 0.4 um: 1.96 times that, and nineteen of twenty readings within it where
    nothing is left."""
    band = drawn.curves(bar.html, "left-0-place")["95 % of the noise"]
    half = max(band["y"])
    assert half == pytest.approx(1.96 * 0.4, rel=0.2)
    within = np.abs(bar.column("after_um")) <= half
    assert 0.92 <= within.mean() <= 0.985


def test_noise_that_differs_is_drawn_piece_by_piece():
    x, noise = np.linspace(0, 100, 400), np.where(np.arange(400) < 200, 1.0, 3.0)
    at, half = left.noise_band(x, noise)
    assert (
        half[0] == pytest.approx(1.96)
        and half[-1] == pytest.approx(5.88)
        and len(at) == len(half) > 10
    )
    assert left.noise_band(x, np.ones(400)) == ([0.0, 100.0], [1.96, 1.96])


@pytest.mark.parametrize("case", ["bar", "soak"])
def test_it_stands_out_where_the_residual_file_says_it_does(case, request):
    """Rings are rows of the file: their mismatch is the one that is reported, many times the noise
    of 0.4 um, and farther off to one side than as many readings in a row are anywhere."""
    answer = request.getfixturevalue(case)
    rings = drawn.curves(answer.html, "left-0-place")["stands out"]
    before = answer.column("before_um")
    # both are rounded to a thousandth, halves one way or the other
    ringed = np.abs(before[:, None] - np.array(rings["y"])).min(axis=1) < 0.6e-3
    assert ringed.sum() >= len(rings["y"]) > 5
    (place,) = answer.json["mismatch"]
    assert np.sqrt(np.mean(np.square(rings["y"]))) == pytest.approx(place["rms_um"], rel=1e-3)
    assert np.abs(rings["y"]).max() == pytest.approx(place["peak_um"], rel=1e-3)
    assert place["rms_um"] > 4 * 0.4
    in_a_row = np.convolve(before, np.full(len(rings["y"]), 1 / len(rings["y"])), "valid")
    assert abs(np.mean(rings["y"])) > np.abs(in_a_row).max()


def test_what_warms_up_stands_out_when_it_is_warm_and_no_reading_is_an_outlier(soak):
    """60 um/m over 569 mm: 34 um at the far place, with a time constant of 900 s; the near place
    moves by 2 um."""
    where = soak.json["mismatch"][0]["where"]
    assert soak.json["data_faults"] == []
    assert where["to_mm"] == pytest.approx(-569.1, abs=0.1) and where["from_mm"] == where["to_mm"]
    assert soak.json["effects"][0]["effect"] == "screw_heat"
    low, high = soak.json["effects"][0]["parameters"]["grown_ppm"]["ci95"]
    assert low < 60 < high


def test_names_have_probabilities(bar):
    """By hand: no worse at all, and worse by 2 ln 9: 9, 9 and 1 of 19."""
    named = probable("a", {"b": 0.0, "c": 2 * np.log(9.0)})
    assert named == pytest.approx({"a": 9 / 19, "b": 9 / 19, "c": 1 / 19})
    effect = bar.json["effects"][0]
    assert sum(effect["names"].values()) == pytest.approx(1.0, abs=0.01)
    assert set(effect["names"]) == {"backlash:Z", *effect["equivalent"]}
    figure = drawn.curves(bar.html, "names")["probability"]
    assert sum(figure["x"]) == pytest.approx(100, abs=1)


def test_a_machine_that_was_written_is_not_advised_again(bar):
    """What is to be done next names its folder, not the option."""
    assert f"{bar.folder / 'written'} holds a machine with the accepted effects" in bar.html
    assert "--write-machine FOLDER writes a machine" not in bar.html


def test_the_written_machine_is_drawn_as_it_is_written(bar):
    made, own = (gcomp.load_machine(m) for m in (bar.folder / "written", "studer-s36"))
    curves = drawn.curves(bar.html, "written-Z")
    for sign, side in (("+", 1.0), ("-", -1.0)):
        for machine, what in ((own, "as it is"), (made, "as written")):
            curve = curves[f"Z {what}, from {sign}"]
            place = np.stack([np.full(len(curve["x"]), 85.0), np.array(curve["x"])])
            off = (
                machine.deviation(place, np.full_like(place, side))[machine.letters.index("Z")]
                * 1000.0
            )
            np.testing.assert_allclose(curve["y"], off, atol=2e-3)


def test_what_is_accepted_by_name_is_drawn_as_written(bar):
    """An effect that a fault of the instrument explains as well goes into a machine by --accept
    alone: the page draws the machine with it then, and without it else."""
    found = gcomp.diagnose([bar.folder / "r.csv"], "studer-s36").details
    (name,) = [f.block.key for f in found.findings if f.status == "accepted"]
    unsure = replace(
        found, findings=tuple(replace(f, equivalent=("sensor_drift:Z",)) for f in found.findings)
    )
    without, accepted = diagnosis.page(unsure).html(), diagnosis.page(unsure, accept=(name,)).html()
    assert f"{name} is NOT written" in without and "written-Z" not in without
    assert f"{name} is written" in accepted and drawn.curves(accepted, "written-Z")


def test_a_wave_is_folded_over_its_period(tmp_path):
    line = [
        "simulate",
        "--test",
        "period:X,way=40,step=0.9",
        "--machine",
        "example-mill",
        "--with",
        "cyclic:X:amplitude_um=3,phase_deg=0,period_mm=5",
    ]
    answer = Answer(tmp_path, line, "example-mill")
    k = next(k for k, e in enumerate(answer.json["effects"]) if e["effect"] == "cyclic")
    figure = next(f for f in drawn.data(answer.html)["figures"] if f["id"] == f"effect-{k}")
    assert "in its period of" in figure["layout"]["xaxis"]["title"]["text"]
    x = [v for curve in figure["data"] for v in curve["x"]]
    assert 4.0 < max(x) <= 5.1
    # What would be written holds the wave as it is: 161 places over 700 mm drew another one.
    curves = drawn.curves(answer.html, "written-X")
    (before, after) = (np.array(curves[f"X as {w}, from +"]["y"]) for w in ("it is", "written"))
    wave = after - before
    assert np.ptp(wave) == pytest.approx(6.0, rel=0.1)
    turns = np.flatnonzero(np.diff(np.sign(wave - wave.mean())))
    assert np.median(np.diff(np.array(curves["X as written, from +"]["x"])[turns])) == (
        pytest.approx(2.5, abs=0.2)
    )


@pytest.mark.parametrize("width, scheme", [(1400, "light"), (400, "dark")])
def test_in_the_browser(opened, soak, width, scheme):
    with opened(soak.page, width, scheme) as page:
        boxes = [
            page.locator(f"#left-0-{part}").bounding_box() for part in ("place", "side", "time")
        ]
        beside = boxes[0]["y"] == boxes[1]["y"] == boxes[2]["y"]
        assert beside == (width > 1000)
        assert page.evaluate("document.getElementById('left-0-time').data.length") >= 4


def test_on_a_phone_no_word_of_a_figure_is_cut_off(bar, opened, tmp_path):
    """+X beside the circle, and the number behind the longest bar, stood out at the side."""
    page = tmp_path / "bar.html"
    page.write_text(bar.html, "utf-8")
    with opened(page, 390) as drawn_page:
        assert drawn_page.evaluate(drawn.CUT) == []


def test_of_readings_at_rest_no_place_and_no_side_is_drawn(tmp_path, capsys):
    """A spindle that warms up: X Y Z stand; two figures of one place each said nothing."""
    page = tmp_path / "rest.html"
    words = ["diagnose", str(RECORDINGS / "spindle_z.csv")]
    assert main([*words, "--machine", "example-mill", "--report", str(page)]) == 0
    assert "WHERE: spindle_z.csv, reading_um: X at 250.0 mm, at rest, from " in (
        capsys.readouterr().out
    )
    found = [f["id"] for f in drawn.data(page.read_text("utf-8"))["figures"]]
    assert "left-0-time" in found
    assert "left-0-place" not in found and "left-0-side" not in found
    assert "at rest: measured - model in time" in page.read_text("utf-8")
