"""Pages of ISO 230 tests and of calibrations hold the numbers of their commands, drawn where they
belong."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import gcomp
from postproc.cli import main
from tests.pages import drawn

ROOT = Path(__file__).resolve().parents[2]
RECORDINGS = ROOT / "sample_recordings"


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> str:
    out = tmp_path_factory.mktemp("iso") / "iso.html"
    files = [
        str(RECORDINGS / f"{n}.csv") for n in ("z_positioning", "z_straightness", "ballbar_xz")
    ]
    assert main(["iso", *files, "--report", str(out), "--json", str(out.with_suffix(".json"))]) == 0
    return out.read_text("utf-8")


def test_every_parameter_of_the_table_stands_on_the_page(page):
    evaluated = gcomp.evaluate([gcomp.read_recording(RECORDINGS / "z_positioning.csv")])
    table = re.findall(
        r"^  (\S+) +(-?\d+\.\d+) +(\d+\.\d+) +(\d+\.\d+)  (.*)$", evaluated.text, re.MULTILINE
    )
    assert len(table) > 8
    for name, *numbers, means in table:
        row = "".join(f"<td[^>]*>{re.escape(cell)}</td>" for cell in (name, *numbers, means))
        assert re.search(row, page), name


def test_means_and_widths_are_the_results_to_the_digit(page):
    curves = drawn.curves(page, "test-0")
    result = gcomp.evaluate([gcomp.read_recording(RECORDINGS / "z_positioning.csv")]).details[0]
    np.testing.assert_allclose(
        curves["mean, approached in +"]["y"], result.detail.mean[0] * 1000.0, atol=6e-4
    )
    for letter in "EA":
        low, high = curves[letter]["y"]
        assert high - low == pytest.approx(result[letter].value * 1000.0, abs=2e-3)


def test_the_axis_ends_where_the_travel_ends_and_nothing_is_written_over_curves(page):
    figure = next(f for f in drawn.data(page)["figures"] if f["id"] == "test-0")
    low, high = figure["layout"]["xaxis"]["range"]
    assert low == pytest.approx(-599.0, abs=10) and high == pytest.approx(-1.0, abs=10)
    assert all(note["xref"] == "x2" for note in figure["layout"]["annotations"])


def test_a_circle_is_drawn_about_its_centre_with_the_deviation_told(page):
    curves = drawn.curves(page, "test-2")
    ways = [c for name, c in curves.items() if name.startswith("from +")]
    assert len(ways) == 2 and all(c["type"] == "scatterpolar" for c in ways)
    # Gxz: the range of the radii about the least-squares centre, of the run with the largest.
    largest = np.ptp(
        np.array(next(c for n, c in curves.items() if n == "from +X to +Z")["customdata"], float)
    )
    assert 30.0 < largest < 40.0
    assert drawn.outside(page) == []


def test_a_calibration_has_the_page_of_its_machine_with_doubts_first(tmp_path, capfd):
    out = tmp_path / "cal.html"
    files = [str(p) for p in sorted(RECORDINGS.glob("?_*.csv"))]
    assert main(["calibrate", *files, "--like", "example-lathe", "--report", str(out)]) == 0
    html = out.read_text("utf-8")
    assert html.index("In doubt") < html.index("Axis X") and "sign of EBX" in html
    capfd.readouterr()


@pytest.mark.parametrize("command", ["iso", "calibrate", "diagnose", "accept"])
def test_two_things_do_not_go_to_one_place(tmp_path, capfd, command):
    one, page = str(tmp_path / "one"), "--page" if command == "accept" else "--report"
    file = str(RECORDINGS / "z_positioning.csv")
    assert main([command, file, page, one, "--json", f"{tmp_path}/./one"]) == 2
    assert "two things are to be written to" in capfd.readouterr().err


def test_slides_at_rest_are_drawn_over_the_time_with_their_range(tmp_path, capfd):
    """The page of a warming spindle had no figure at all."""
    out, figure = tmp_path / "s.html", tmp_path / "s.svg"
    recording = str(RECORDINGS / "spindle_z.csv")
    assert main(["iso", recording, "--report", str(out), "--figure", str(figure)]) == 0
    html = out.read_text("utf-8")
    curves = drawn.curves(html, "test-0")
    reading = np.array(curves["reading along Z"]["y"])
    assert np.ptp(reading) == pytest.approx(24.84, abs=0.01)
    assert curves["reading along Z"]["x"][-1] == pytest.approx(3.0, abs=0.1)
    assert "dZ: 24.84 um" in curves and "range over 3.0 h (dZ) 24.84 +- 0.57 um" in html
    assert figure.stat().st_size > 5000
    capfd.readouterr()


def test_rings_have_names_only_where_no_curve_runs(page):
    figure = next(f for f in drawn.data(page)["figures"] if f["id"] == "test-2")
    axis = figure["layout"]["polar"]["radialaxis"]
    named = [(r, text) for r, text in zip(axis["tickvals"], axis["ticktext"], strict=True) if text]
    assert [text for _, text in named] == ["-40 um", "+40 um"]
    radii = [r for c in figure["data"] if c["name"].startswith("from") for r in c["r"]]
    assert named[0][0] < min(radii) and max(radii) < named[1][0]


def test_on_a_phone_widths_beside_the_travel_have_letters_alone(opened, tmp_path, page):
    out = tmp_path / "iso.html"
    out.write_text(page, "utf-8")
    said = "document.getElementById('test-0').layout.annotations.map(a => a.text)"
    with opened(out, 400, "dark") as narrow:
        assert narrow.evaluate(said) == ["M", "E", "A"]
    with opened(out) as wide:
        assert [text.split("<br>")[::2] for text in wide.evaluate(said)] == [
            [letter, "um"] for letter in "MEA"
        ]


def test_on_a_phone_no_word_of_a_figure_is_cut_off(page, opened, tmp_path):
    place = tmp_path / "iso.html"
    place.write_text(page, "utf-8")
    with opened(place, 390) as shown:
        assert shown.evaluate(drawn.CUT) == []
