"""`gcomp machines new` and `check`: what a tape, a square and a dial gauge tell becomes the machine
that they were read on."""

from __future__ import annotations

import io
import itertools
import re
import sys

import numpy as np
import pytest
from pytest import approx

from postproc import cli
from postproc.machine.file import read_machine
from postproc.machine.model import Machine

TRAVEL = ("--travel", "X=0,600", "--travel", "Y=0,400", "--travel", "Z=-80,0")
ROUTER = ("--kind", "router", "--control", "grbl", *TRAVEL)


def gcomp(*words) -> int:
    return cli.main([*map(str, words)])


def new(folder, *words) -> Machine:
    assert gcomp("machines", "new", "m", *ROUTER, *words, "-o", folder) == 0
    return read_machine(folder)


def actual(machine: Machine, *places, approach=0.0) -> list[np.ndarray]:
    """(3,) mm: where the tool is on the work, commanded to each of some places X Y Z."""
    q = np.array(places, float).T
    return list((q + machine.deviation(q, np.full_like(q, approach))).T)


@pytest.mark.parametrize("pair", ["XY", "XZ", "YZ"])
@pytest.mark.parametrize("value", [950.0, -420.0])
def test_a_rectangle_measured_on_the_machine_gives_the_machine(tmp_path, pair, value):
    """Four corners by the machine that is stated; its diagonals, given to a new one, make the same
    machine."""
    name = {"XY": "C0Y", "XZ": "B0Z", "YZ": "A0Z"}[pair]
    true = new(tmp_path / "true", "--squareness", f"{name}={value}")
    i, j = ("XYZ".index(x) for x in pair)
    corners = []
    for a, b in ((0, 0), (300, 60), (300, 0), (0, 60)):
        place = np.array([100.0, 100.0, -70.0])
        place[i] += a
        place[j] += b
        corners.append(place)
    low, high, right, up = actual(true, *corners)
    rising, falling = np.linalg.norm(high - low), np.linalg.norm(up - right)
    found = new(tmp_path / "found", "--diagonals", f"{pair}={rising:.6f},{falling:.6f},300,60")
    for x in true.square:
        assert found.square[x] == approx(true.square[x], abs=2e-6)


@pytest.mark.parametrize("drifts, moving", list(itertools.permutations("XYZ", 2)))
def test_beside_a_square_the_tool_drifts_as_it_was_read(tmp_path, drifts, moving):
    m = new(tmp_path / "m", "--drift", f"{drifts}/{moving}=0.05,50")
    begin, end = np.array([100.0, 100.0, -70.0]), np.array([100.0, 100.0, -70.0])
    end["XYZ".index(moving)] += 50
    first, last = actual(m, begin, end)
    assert (last - first)["XYZ".index(drifts)] == approx(0.05, abs=1e-6)
    assert (last - first)["XYZ".index(moving)] == approx(50.0, abs=1e-6)


def test_by_hand(tmp_path):
    """Diagonals 500.3 and 499.8 of 400 by 300: (500.3^2 - 499.8^2) / (4 * 400 * 300) = 0.0010418 to
    +X, C0Y = -1041.8 urad. Lost motion of 0.06 stops 30 um short from either side; 300.2 for 300 is
    0.2 mm at 300."""
    m = new(
        tmp_path / "m",
        "--diagonals",
        "XY=500.3,499.8,400,300",
        "--backlash",
        "X=0.06",
        "--scale",
        "Y=300,300.2",
        "--home",
        "X0,Y0,Z0",
    )
    assert m.square["Y"][2] == approx(-1041.771e-6, abs=1e-9)
    ahead, back = (actual(m, (300, 0, 0), approach=s)[0] for s in (1.0, -1.0))
    assert ahead[0] == approx(300 - 0.03) and back[0] == approx(300 + 0.03)
    assert actual(m, (0, 300, 0))[0] == approx([0.0010418 * 300, 300.2, 0.0], abs=1e-4)
    assert m.home == {"X": 0.0, "Y": 0.0, "Z": 0.0} and m.signs == "unverified"
    assert m.limits.max_correction == approx(0.5)  # 0.417 and 0.03 of X, 0.267 of Y


def test_a_limit_grows_with_what_is_stated_and_not_with_a_slip(tmp_path, capsys):
    small = new(tmp_path / "a", "--squareness", "C0Y=1000")
    assert small.limits.max_correction == 0.5
    # 0.8 mm at Y 400, a fifth more, to the next tenth
    large = new(tmp_path / "b", "--squareness", "C0Y=2000")
    assert large.limits.max_correction == approx(1.0)
    slip = new(tmp_path / "c", "--squareness", "C0Y=45000")
    assert slip.limits.max_correction == 0.5
    capsys.readouterr()
    assert gcomp("machines", "check", tmp_path / "a") == 0
    assert "nothing in it is doubtful" in capsys.readouterr().out
    assert gcomp("machines", "check", tmp_path / "c") == 1
    out = capsys.readouterr().out
    assert "13.50 mm on 300 mm" in out and "correction of X is 18.000 mm" in out


@pytest.mark.parametrize(
    "words, says",
    [
        (("--kind", "router"), "its control is not said"),
        (("--control", "grbl"), "the kind of machine is not said"),
        (
            ("--kind", "router", "--control", "grbl", "--travel", "X=0,1"),
            "the travel of Y is not said",
        ),
        ((*ROUTER, "--travel", "A=0,1"), "--travel names A"),
        (
            (*ROUTER, "--squareness", "C0Y=1", "--drift", "X/Y=0.1,300"),
            "the squareness of XY is said twice",
        ),
        ((*ROUTER, "--scale", "X=300,310"), "set the control's steps per mm to 0.967742"),
        (
            (
                "--kind",
                "lathe",
                "--control",
                "fanuc-lathe",
                *TRAVEL[:2],
                *TRAVEL[4:],
                "--squareness",
                "C0Y=1",
            ),
            "C0Y is between X and Y",
        ),
        (("--chain", "w-X-t", "--control", "grbl"), "--chain"),
    ],
)
def test_what_is_missing_or_contradicts_is_named(tmp_path, capsys, words, says):
    assert gcomp("machines", "new", "m", *words, "-o", tmp_path / "m") == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "m").exists()


@pytest.mark.parametrize(
    "word, says",
    [
        (("--diagonals", "XY=5,100,3,4"), "has diagonals of 5.00 mm"),
        (("--diagonals", "XY=5,5"), "is not like XY=565.9"),
        (("--backlash", "X=60"), "X=0.05 is 50 um"),
        (("--travel", "X=4,1"), "the lower end comes first"),
        (("--drift", "X/X=1,2"), "is not like X/Y=0.05,300"),
        (("--squareness", "D0Y=1"), "is not one of C0X"),
    ],
)
def test_a_word_that_can_not_be_read_is_named(tmp_path, capsys, word, says):
    assert gcomp("machines", "new", "m", *ROUTER, *word, "-o", tmp_path / "m") == 2
    assert says in capsys.readouterr().err


def test_it_asks_what_it_must_know(tmp_path, capsys, monkeypatch):
    """A wrong answer is asked again, an empty one leaves a measurement out. XY by diagonals, XZ
    not, YZ by a square: Y drifts by -0.03 mm while Z goes 150, so Z leans towards -Y, by hand A0Z
    is +200 urad."""
    answers = (
        "printer\n\n0,200\n5\n0,210\n0,250\n141.62,141.22,100,100\n\n\n\n-0.03,150\n\n0.04\n\n"
    )
    monkeypatch.setattr(sys, "stdin", io.StringIO(answers))
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    assert gcomp("machines", "new", "p", "-o", tmp_path / "p") == 0
    m = read_machine(tmp_path / "p")
    assert m.control == "marlin" and m.axes["Y"].travel == (0.0, 210.0)
    assert m.square["Y"][2] == approx(-2828.4e-6) and [e.axis for e in m.effects] == ["Y"]
    assert m.square["Z"] == approx([200e-6, 0.0, 0.0])
    assert "'Y=5' is not like X=0,400" in capsys.readouterr().out
    monkeypatch.setattr(sys, "stdin", io.StringIO("mill\n"))
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    assert gcomp("machines", "new", "q", "-o", tmp_path / "q") == 2
    assert "not answered to the end" in capsys.readouterr().err


@pytest.mark.parametrize(
    "was, now, says",
    [
        ("EYY_um\n0,0\n400,266", "EYY_um\n0,0\n400,2660", "E"),
        ("400,266.6667", "400,0.0003", "less than is ever measured: are its values mm?"),
    ],
)
def test_sizes_that_no_machine_has_are_doubted(tmp_path, capsys, was, now, says):
    new(tmp_path / "m", "--scale", "Y=300,300.2")
    file = tmp_path / "m" / "Y.csv"
    file.write_text(file.read_text().replace(was, now))
    if now.endswith("2660"):
        text = (tmp_path / "m" / "machine.toml").read_text()
        (tmp_path / "m" / "machine.toml").write_text(text + "\n[limits]\nmax_slope = 0.05\n")
        says = "EYY reaches 2661 um, more than a machine strays"
    capsys.readouterr()
    assert gcomp("machines", "check", tmp_path / "m") == 1
    assert says in capsys.readouterr().out


@pytest.mark.parametrize("name", ["example-router", "example-printer"])
def test_the_examples_hold_nothing_doubtful_and_correct_a_program(name, tmp_path, capsys):
    assert gcomp("machines", "check", name) == 0
    assert "nothing in it is doubtful" in capsys.readouterr().out
    program = tmp_path / "a.nc"
    start = "G28\n" if name == "example-printer" else "G54\n"
    program.write_text(f"G21\nG90\n{start}G0 X50 Y50\nG1 X150 F1200\nG1 Y150\nG1 X50\nG1 Y50\n")
    assert (
        gcomp(program, "--machine", name, "--start", "Z0", "--verify", "-o", tmp_path / "b.nc") == 0
    )
    assert "verified: largest deviation" in capsys.readouterr().err


def test_a_ballbar_gives_squareness_and_lost_motion(tmp_path, capsys):
    """Circles on example-router (C0Y -1041.8 urad, 60 and 40 um of lost motion), by the simulator:
    the same come back."""
    circle = tmp_path / "xy.csv"
    words = (
        "--test",
        "ballbar:XY,radius=100,feed=600",
        "--machine",
        "example-router",
        "--noise",
        "0.5",
        "--quiet",
    )
    assert gcomp("simulate", *words, "-o", circle) == 0
    m = new(tmp_path / "m", "--ballbar", circle, "--backlash", "Y=0.041")
    assert m.square["Y"][2] == approx(-1041.8e-6, abs=2e-6)
    sizes = {e.axis: e.parameters["size_um"] for e in m.effects}
    assert sizes["X"] == approx(60, abs=1.0) and sizes["Y"] == 41.0  # what is stated goes first
    assert "ballbar" in (tmp_path / "m" / "machine.toml").read_text()
    words = (*ROUTER, "--ballbar", circle, "--drift", "X/Y=0.1,300", "-o", tmp_path / "n")
    assert gcomp("machines", "new", "n", *words) == 2
    assert "the squareness of XY is said twice" in capsys.readouterr().err


def test_what_lengths_are_worth_is_carried_to_the_path(tmp_path, capsys):
    """A rectangle 400 by 300 with diagonals known to 0.2 mm each: by the formula s = (d1^2 - d2^2)
    / (4 a b), u(s) = 0.2 * sqrt(d1^2 + d2^2) / (2 a b) = 589 urad, U 1179; a gauge to 5 um is read
    twice: U of the lost motion 14.1 um. Both reach --verify, and the export."""
    words = [
        "machines",
        "new",
        "r",
        "--kind",
        "router",
        "--control",
        "linuxcnc",
        "--travel",
        "X=0,600",
        "--travel",
        "Y=0,400",
        "--travel",
        "Z=-80,0",
    ]
    words += [
        "--diagonals",
        "XY=500.3,499.8,400,300",
        "--backlash",
        "X=0.06",
        "--scale",
        "Y=300,300.1",
        "--u-length",
        "0.2mm",
        "--u-gauge",
        "5um",
    ]
    assert cli.main([*words, "-o", str(tmp_path / "r")]) == 0
    machine = read_machine(tmp_path / "r")
    assert machine.square_u["C0Y"] == pytest.approx(
        0.4 * np.hypot(500.3, 499.8) / (2 * 400 * 300), rel=1e-3
    )
    (term,) = machine.effects
    assert term.spread[0].parameters == {"size_um": pytest.approx(2 * 5 * np.sqrt(2), abs=1e-3)}
    table = machine.axes["Y"].uncertainty.table
    assert table.forward[1, -1] == pytest.approx(2 * 0.2 * np.sqrt(2) / 300 * 400, rel=1e-4)
    (tmp_path / "a.nc").write_text("G21 G90\nG0 G53 X0 Y0 Z-10\nG54\nG1 X500 Y300 F900\nM2\n")
    program = [
        str(tmp_path / "a.nc"),
        "--machine",
        str(tmp_path / "r"),
        "--offset",
        "G54=X0,Y0,Z0",
        "--verify",
        "-o",
        str(tmp_path / "b.nc"),
    ]
    assert cli.main(program) == 0
    said = capsys.readouterr().err
    known = float(said.split("map itself is known to +- ")[1].split(" um")[0])
    across, along = (
        1.1785 * 300,
        np.hypot(0.4 * np.sqrt(2) / 300 * 300 * 1e3, 0),
    )  # C0Y moves X by 300 mm of Y; the scale of Y
    assert known == pytest.approx(np.hypot(np.hypot(across, 7.07), along), rel=0.01)
    out = [
        "export",
        "--machine",
        str(tmp_path / "r"),
        "--control",
        "linuxcnc",
        "--axis",
        "Y",
        "--component",
        "EYY",
        "-o",
        str(tmp_path / "y.comp"),
    ]
    assert cli.main([*out, "--uncertainty", str(tmp_path / "u.csv")]) == 0
    assert "U (95 %)" in capsys.readouterr().out
    last = (tmp_path / "u.csv").read_text().splitlines()[-1].split(",")
    assert last[0] == "EYY" and float(last[2]) == pytest.approx(
        0.4 * np.sqrt(2) / 300 * 400 * 1e3, rel=1e-3
    )


def test_what_leans_is_reported_with_its_size_at_the_far_end(tmp_path, capfd):
    """A machine of a lean alone has no nodes: 2,828 urad over 210 mm were "0.0 um"."""
    words = "--kind printer --control marlin --travel X=0,250 --travel Y=0,210 --travel Z=0,210"
    line = ["machines", "new", "bed", *words.split(), "-o", tmp_path / "bed"]
    assert gcomp(*line, "--diagonals", "XY=141.62,141.22,100,100") == 0
    said = capfd.readouterr().out
    size = float(re.search(r"largest deviation in its travel: (\S+) um", said)[1])
    assert size == approx(2828.4e-6 * 210 * 1000, abs=0.1)
