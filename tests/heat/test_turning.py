"""Heat over time on machines with rotary axes: slides, scales and spindles grow, whatever turns."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from postproc import cli

TOML = """format = "gcomp-machine/1"
name = "warm5"
control = "fanuc-mill"
chain = "w-C-b-X-Y-Z-t"
[axes.X]
travel = [-400.0, 400.0]
least_increment = 0.0001
max_velocity = 60000.0
heat = { scale_um_m_K = 10.0, fixed_mm = -100.0, work_um_m_K = 11.5 }
[axes.Y]
travel = [-400.0, 400.0]
least_increment = 0.0001
max_velocity = 60000.0
[axes.Z]
travel = [-400.0, 400.0]
least_increment = 0.0001
max_velocity = 60000.0
[axes.C]
travel = [-7200.0, 7200.0]
least_increment = 0.0001
centre = { X = 0.0, Y = 0.0 }
heat = { scale_um_m_K = 10.0 }
[tool]
Z = -100.0
[offsets]
G54 = { X = 0.0, Y = 0.0, Z = 0.0 }
"""
LOG = "t_s,T_scale_X_C,T_work_C\n0,40,20\n99999,40,60\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("warm5").mkdir()
    Path("warm5/machine.toml").write_text(TOML)
    Path("log.csv").write_text(LOG)
    return tmp_path


def corrected(text: str, *more: str) -> list[dict[str, float]]:
    """Words of each block of the output."""
    Path("a.nc").write_text(text)
    words = ("a.nc", "--machine", "warm5", "--temperatures", "log.csv", "--verify", *more)
    assert cli.main([*words, "-o", "b.nc"]) == 0
    blocks = [x for x in Path("b.nc").read_text().splitlines() if not x.startswith("(")]
    return [{w: float(v) for w, v in re.findall(r"([XYZC])(-?[\d.]+)", x)} for x in blocks]


def test_places_of_the_slides_by_hand(place, capsys):
    """X 200 of a scale at 40 C whose fixed point is at -100: 10e-6 * 20 * 300 = 60 um too far; at
    0 it is 20 um. However C turns, X of the slide is what grew."""
    out = corrected("G21 G90 G54\nG0 X0. Y0. Z0. C0.\nG1 X200. C90. F9000.\nG1 X0. C180.\nM30\n")
    ends = {round(b["X"]): b["X"] for b in out if "X" in b and "C" in b and b["C"] in (90, 180)}
    assert ends[200] == pytest.approx(199.94, abs=2e-4)
    assert ends[0] == pytest.approx(-0.02, abs=2e-4)
    assert all(abs(b.get("Y", 0.0)) < 2e-4 for b in out)
    said = capsys.readouterr().err
    assert "C turns the work: along X it stays at 20 C" in said
    assert "growth of C, which turns, is not followed" in said and "verified" in said


def test_places_of_the_tip_by_hand(place, capsys):
    """Under G43.4 words are of the part. With C at 90 the tool that stands at part X 0, Y 200 is at
    the slide's X 200 (or -200, as the turn goes): 60 um (or 20 um the other way) along X of the
    machine are along Y of the part."""
    text = "G21 G90 G54\nG0 X0. Y0. Z0. C0.\nG43.4 H1\nG1 X0. Y200. Z0. C90. F9000.\nG49\nM30\n"
    out = corrected(text, "--offset", "H1=Z0")
    last = [b for b in out if b.get("C") == 90][-1]
    assert abs(last.get("X", 0.0)) < 3e-4
    off = last["Y"] - 200.0
    assert off == pytest.approx(-0.060, abs=3e-4) or off == pytest.approx(-0.020, abs=3e-4)
    err = capsys.readouterr().err
    assert float(re.search(r"nominal path ([\d.]+) um", err)[1]) < 1.5


def test_a_spindle_grows_along_its_own_slide(place):
    """5 um for each 1000 turns a minute after a long time: at 8000 Z stands 40 um too high."""
    with open("warm5/machine.toml", "a") as file:
        file.write(
            '[[effect]]\nname = "spindle_growth"\naxis = "Z"\ntau_s = 60.0\n'
            "um_per_1000_rpm = 5.0\num_per_K = 0.0\n"
        )
    text = "G21 G90 G54\nS8000 M3\nG0 X-100. Y0. Z0. C0.\nG4 X3600.\nG1 Z-10. C90. F9000.\nM30\n"
    last = [b for b in corrected(text) if "Z" in b][-1]
    assert last["Z"] == pytest.approx(-10.04, abs=3e-4)
