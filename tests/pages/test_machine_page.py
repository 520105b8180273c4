"""The page of a machine shows what its folder states: curves, U, squareness with its sign, the
volume."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gcomp
from postproc.cli import main
from postproc.pages import machine as pages
from tests.pages import drawn

ROOT = Path(__file__).resolve().parents[2]
MACHINES = sorted(p.name for p in (ROOT / "machines").iterdir() if p.is_dir())


@pytest.mark.parametrize("name", MACHINES)
def test_every_machine_has_a_page_that_asks_for_nothing(name, tmp_path, capfd):
    out = tmp_path / "m.html"
    assert main(["machines", "show", name, "--report", str(out)]) == 0
    html = out.read_text("utf-8")
    assert drawn.outside(html) == [] and gcomp.load_machine(name).digest in html
    assert capfd.readouterr().out.startswith(f"{name}: ")


def test_curves_are_the_tables_to_the_digit():
    machine = gcomp.load_machine("studer-s36")
    html = pages.page(machine).html()
    table = machine.tables["Z"]
    for way, values in (("+", table.forward), ("-", table.reverse)):
        curve = drawn.curves(html, "axis-Z-translations")[f"EZZ, approached in {way}"]
        np.testing.assert_allclose(curve["x"], table.nodes)
        np.testing.assert_allclose(curve["y"], values[2] * 1000.0, atol=6e-4)


def test_squareness_leans_to_the_side_that_it_leans_to():
    """B0X = -382 urad: turned about Y by that, +X goes towards +Z by 0.065 mm at 170 mm (thesis,
    6.3.4)."""
    machine = gcomp.load_machine("studer-s36")
    curve = drawn.curves(pages.page(machine).html(), "square")["B0X"]
    place = np.array([[170.0], [0.0]])  # of X and Z; there EZZ is zero, and EZX joins in
    assert curve["x"][1] > curve["x"][0]
    row = machine.letters.index("Z")
    lean = machine.deviation(place, np.ones((2, 1)))[row, 0] - machine.tables["X"].forward[2, -1]
    assert lean == pytest.approx(0.065, abs=2e-4)


def test_the_volume_holds_the_deviation_of_the_machine():
    machine = gcomp.load_machine("example-mill")
    found = next(
        f for f in drawn.data(pages.page(machine).html())["figures"] if f["id"] == "volume"
    )
    heat = found["steps"]["data"][-1][0]
    place = np.array([[heat["x"][0]], [heat["y"][-1]], [float(found["steps"]["values"][-1])]])
    off = (
        machine.deviation(place, np.ones((3, 1))) + machine.deviation(place, -np.ones((3, 1)))
    ) / 2
    assert heat["z"][-1][0] == pytest.approx(float(np.linalg.norm(off)) * 1000.0, abs=0.01)


def test_a_machine_without_errors_says_so_and_draws_none():
    html = pages.page(gcomp.load_machine("perfect")).html()
    assert "The map of this machine is zero" in html and drawn.data(html)["figures"] == []


def test_a_page_is_of_one_machine(tmp_path, capfd):
    assert main(["machines", "--report", str(tmp_path / "m.html")]) == 2
    assert "draws one machine" in capfd.readouterr().err


def test_in_the_browser_a_slider_shows_another_level(opened, tmp_path):
    out = tmp_path / "m.html"
    out.write_text(pages.page(gcomp.load_machine("mv-1060")).html(), "utf-8")
    with opened(out, 400) as page:
        assert page.inner_text(".steps output") == "0"
        page.evaluate(
            "const s = document.querySelector('.steps input'); s.value = 0; s.dispatchEvent(new"
            " Event('input'))"
        )
        assert page.inner_text(".steps output") == "-600"


def test_an_axis_whose_errors_are_effects_or_heat_is_not_called_without_errors():
    """A router with 60 um of backlash on X had "No error is stated along this axis"; a mill that is
    corrected for its heat was one of which no program is changed."""
    router = pages.page(gcomp.load_machine("example-router")).html()
    assert router.count("what is stated of it (below): backlash") == 2
    warm = pages.page(gcomp.load_machine("example-warm-mill")).html()
    assert "no program is changed but for its heat, where --temperatures" in warm
    assert "X, Y: growth with temperature is stated" in warm


def test_names_of_axes_stand_beside_the_leaning_line():
    figures = drawn.data(pages.page(gcomp.load_machine("example-mill")).html())["figures"]
    figure = next(f for f in figures if f["id"] == "square")
    leaning = [c for c in figure["data"] if c["name"] in ("C0Y", "A0Z", "B0Z")]
    names = [n for n in figure["layout"]["annotations"] if n["y"] == 0.9]
    assert len(leaning) == len(names) == 3
    for line, name in zip(leaning, names, strict=True):
        left = line["x"][1] < line["x"][0]
        assert name["xanchor"] == ("left" if left else "right")
        assert (name["x"] > line["x"][0]) is left


def test_arrows_have_a_scale_with_a_unit_and_the_map_ends_where_it_was_measured():
    machine = gcomp.load_machine("studer-s36")
    figure = next(
        f for f in drawn.data(pages.page(machine).html())["figures"] if f["id"] == "volume"
    )
    curves = {c.get("name", c["type"]): c for c in figure["data"]}
    low, high = curves["scale"]["x"]
    assert curves["scale"]["text"] == ["", "50 um"]
    assert curves["contour"]["x"][0] == 0 and curves["contour"]["x"][-1] == 510
    # The arrow at Z 0, X 170 beside the deviation there, by the same scale.
    k = next(
        i
        for i in range(0, len(curves["deviation"]["x"]), 3)
        if curves["deviation"]["x"][i] == 0 and curves["deviation"]["y"][i] == 170
    )
    place = np.array([[170.0], [0.0]])
    off = (
        machine.deviation(place, np.ones((2, 1))) + machine.deviation(place, -np.ones((2, 1)))
    ) / 2
    along = curves["deviation"]["x"][k + 1] - curves["deviation"]["x"][k]
    row = machine.letters.index("Z")
    assert along / (high - low) == pytest.approx(float(off[row, 0]) / 0.050, abs=0.01)
