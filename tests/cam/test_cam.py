"""Programs that PrusaSlicer and FreeCAD wrote, on a made-up machine with errors: all corrected and
verified, no filament lost; on a machine without errors byte for byte what they were."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import XYZ, parse
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.nc.recognise import between
from postproc.verify import Verifier

HERE = Path(__file__).parent
NODES = np.arange(-60.0, 421.0, 30.0)
OTHERS = {
    "voron-v2": "klipper",
    "ratrig-v-core-3": "klipper",
    "jubilee": "reprap",
    "deltiq-2": "reprap",
    "freecad-linuxcnc": "linuxcnc",
    "freecad-mach3": "mach3",
    "freecad-grbl": "grbl",
    "freecad-grblhal": "grblhal",
    "freecad-centroid": "centroid",
    "freecad-smoothie": "smoothie",
}
FILES = sorted([*HERE.glob("*.gcode"), *HERE.glob("*.nc")])
STATED = {"G54": {"X": 100.0, "Y": 100.0, "Z": 50.0}, "H1": {}}
HOME = {"X": 0.0, "Y": 0.0, "Z": 0.0}
# Motions behind G29, G80, START_PRINT and the like, where the place of the printer is unknown:
# none but these is left.
MOST_LEFT = 4


@cache
def machine(size: float = 1.0, home: bool = True) -> Machine:
    """Three axes with all errors, tens of um and urad, in both directions; none where size is 0."""
    axes = {}
    for k, letter in enumerate(XYZ):
        waves = np.stack([(18 - 2 * j) * np.sin(NODES / 57.0 + j + k) for j in range(6)]) * 1e-3
        waves[3:] *= 1e-3
        play = 0.0015 * np.cos(np.arange(6) + k)[:, None] * np.array([1, 1, 1, 0, 0, 0])[:, None]
        table = AxisTable(letter, NODES, size * (waves + play), size * (waves - play))
        axes[letter] = Axis(letter, (-60.0, 420.0), 1e-3, np.zeros(3), table)
    square = {"Y": np.array([0.0, 0.0, 40e-6]) * size} if size else {}
    tool = np.array([0.0, 0.0, -30.0 * size])
    return Machine(
        "made-up",
        "",
        "marlin",
        parse("w-Y-b-Z-X-t"),
        axes,
        square=square,
        tool=tool,
        home=HOME if home else {},
    )


def run(path: Path, on: Machine, chunk: int = 0) -> tuple[Filter, Verifier, bytes]:
    dialect = dialects.load(OTHERS.get(path.stem, "marlin"))
    on = on.carrying(dialect.carried)
    filter_ = Filter(on, dialect, setup_of(on, STATED if path.suffix == ".nc" else None))
    verifier = Verifier(filter_)
    text = path.read_bytes()
    step = chunk or len(text)
    out = (
        b"".join(filter_.feed(text[k : k + step]) for k in range(0, len(text), step))
        + filter_.finish()
    )
    return filter_, verifier, out


def left(filter_: Filter) -> int:
    """Motions that nothing corrects, as the notice counts them."""
    found = [
        re.search(r"left as they are: (\d+)", n.message)
        for n in filter_.notices
        if n.code == "unknown"
    ]
    return int(found[0][1]) if found and found[0] else 0


def filament(text: bytes, relative_with_distance: bool) -> float:
    """The sum of all E, counted by this file's own reading: G90 G91 and M82 M83 as Marlin or
    Klipper have them."""
    absolute, e_absolute, place, total = True, True, 0.0, 0.0
    for line in text.decode("latin-1").splitlines():
        code = re.sub(r"\([^)]*\)", "", line.split(";")[0]).upper()
        word = re.match(r"\s*([GM]\d+)(?![\d.])", code)
        if not word:
            continue
        if word[1] in ("G90", "G91"):
            absolute = word[1] == "G90"
            e_absolute = e_absolute if relative_with_distance else absolute
        elif word[1] in ("M82", "M83"):
            e_absolute = word[1] == "M82"
        found = re.search(r"E\s*(-?\d*\.?\d+)", code)
        if word[1] == "G92" and found:
            place = float(found[1])
        elif word[1] in ("G0", "G1", "G2", "G3") and found:
            if e_absolute and (absolute or not relative_with_distance):
                total, place = total + float(found[1]) - place, float(found[1])
            else:
                total, place = total + float(found[1]), place + float(found[1])
    return total


def test_there_is_what_was_promised():
    assert len([f for f in FILES if f.suffix == ".gcode"]) >= 15
    assert {f.stem for f in FILES if f.suffix == ".nc"} >= {
        f"freecad-{post}"
        for post in ("linuxcnc", "grbl", "mach3", "centroid", "marlin", "smoothie")
    }
    told = (HERE / "README.md").read_text()
    assert all(f"| {f.name} |" in told for f in FILES), (
        "README.md says of each what it came from: make.py prints it"
    )


@pytest.mark.parametrize("path", [f for f in FILES if f.suffix == ".gcode"], ids=lambda p: p.stem)
def test_a_print_is_recognised(path):
    """By the names that its start code calls: a slicer's own remarks are the same for every
    firmware."""
    assert between(path.read_bytes()) == [OTHERS.get(path.stem, "marlin")]


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_it_is_corrected_and_verified(path):
    filter_, verifier, out = run(path, machine())
    assert verifier.passed, verifier.report()
    assert verifier.uncorrected.deviation > 0.03 > 4 * verifier.corrected.deviation
    assert left(filter_) <= MOST_LEFT
    assert filter_.summary.changed >= 0.9 * (filter_.summary.motions - still(path, filter_))
    way = filter_.dialect.relative_with_distance
    assert filament(out, way) == pytest.approx(filament(path.read_bytes(), way), abs=1e-5)


def still(path: Path, filter_: Filter) -> int:
    """Motions that name no axis but E: nothing of them can change."""
    lines = (line.split(";")[0] for line in path.read_text("latin-1").splitlines())
    moves = [line for line in lines if re.match(r"G0?[01]\b", line)]
    return sum(not re.search(r"[XYZ]", line) for line in moves)


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_a_machine_without_errors_changes_no_byte(path):
    assert run(path, machine(0.0))[2] == path.read_bytes()


@pytest.mark.parametrize("path", FILES[::4], ids=lambda p: p.stem)
def test_any_cut_of_the_input_gives_the_same_bytes(path):
    whole, _, out = run(path, machine())
    cut, _, again = run(path, machine(), 997)
    assert again == out
    assert sorted(n.message for n in cut.notices) == sorted(n.message for n in whole.notices)


@pytest.mark.parametrize("path", [f for f in FILES if f.suffix == ".gcode"], ids=lambda p: p.stem)
def test_without_a_stated_home_what_is_not_known_is_left_and_counted(path):
    filter_, verifier, out = run(path, machine(home=False))
    assert verifier.passed, verifier.report()
    with_home = left(run(path, machine())[0])
    assert with_home <= left(filter_) <= 60
    way = filter_.dialect.relative_with_distance
    assert filament(out, way) == pytest.approx(filament(path.read_bytes(), way), abs=1e-5)


def test_filament_is_counted_through_arcs():
    """A spiral of four arcs, absolute and incremental E: arcs that are cut share their filament
    out."""
    arcs = (
        "G2 X80 Y60 I10 J0 E{0} F1200\nG3 X100 Y60 I10 J0 E{1}\nG2 X60 Y60 I-20 J0 Z.4 E{2}\nG3 X61"
        " Y61 I0 J1 E{3}\n"
    )
    for head, values in (("M83\n", (0.8, 0.7, 2.5, 0.05)), ("M82\n", (0.8, 1.5, 4.0, 4.05))):
        text = ("G28\n" + head + "G92 E0\nG1 X60 Y60 Z.2 F6000\n" + arcs.format(*values)).encode()
        dialect = dialects.load("marlin")
        on = machine().carrying(("E",))
        filter_ = Filter(on, dialect, setup_of(on))
        verifier = Verifier(filter_)
        out = filter_.feed(text) + filter_.finish()
        assert verifier.passed
        assert filament(out, False) == pytest.approx(4.05, abs=1e-5)
        assert re.search(rb"\nG[23] ", out)


def test_home_makes_the_places_behind_g28_known():
    on = machine().carrying(("E",))
    for home, changed in ((HOME, True), ({}, False)):
        here = replace(on, home=home)
        filter_ = Filter(here, dialects.load("marlin"), setup_of(here))
        text = b"G28\nG1 Z10 F600\nG1 X100 E5\n"
        assert (filter_.feed(text) != text) == changed
        assert left(filter_) == (0 if changed else 2)
