"""Whole programs on machines with more than two axes, judged by evaluators that share nothing with
the filter."""

from __future__ import annotations

import csv
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from tests.reference.evaluate import residual
from tests.reference.kinematics import Link, tip
from tests.reference.machine import Machine as ReferenceMachine

ROOT = Path(__file__).resolve().parents[2]
UM, URAD = 1e-3, 1e-6
HELD_BACK = 1.5 * UM * 3**0.5  # three slides, each by the hysteresis and half of it inside a block

MILL = """G21 G90 G54 G17
G0 X0 Y0 Z40
G1 X150 Y80 Z-20 F500
G2 X50 Y-20 I-50 J-50
G1 Z-40
G3 X70 Y-20 Z-45 I10 J0
G1 X-100 Y-90 Z10
G91 G1 X30.5 Y12.25 Z-3.3
G90 G18 G2 X-20 Z0 R60
G19 G3 Y-60 Z20 J10 K5
G17 G1 X0 Y0 Z50
M2
"""
FIVE = """G21 G90 G54
G0 X0 Y0 Z50 A0 C0
G1 X50 Y20 Z-20 A30 C90 F500
X10 C-120 A-45
X-80 Y80 C-60
A10 Z30 C45
C400 A11
X10 Y10 Z10 A0 C410
M2
"""


def corrected(name: str, text: str, tolerance: float) -> str:
    machine = places.load(str(ROOT / "machines" / name))
    filter_ = Filter(
        machine, dialects.load("linuxcnc"), setup_of(machine, {}), Options(tolerance=tolerance)
    )
    return b"".join([filter_.feed(text.encode()), filter_.finish()]).decode()


@pytest.mark.parametrize(
    "text",
    [MILL.split("G18")[0] + "\nM2\n", (ROOT / "sample_programs" / "pocket_mill.ngc").read_text()],
)
def test_a_mill_with_all_21_components_cuts_within_tolerance(text):
    """The reference machine turns every axis by exact transforms: products of two errors are left
    in."""
    machine = ReferenceMachine.load(ROOT / "machines" / "example-mill")
    report = residual(
        text,
        corrected("example-mill", text, 0.001),
        "linuxcnc",
        machine,
        offsets={"G54": {"X": 0, "Y": 0, "Z": -250.0}},
    )
    second_order = places.load(str(ROOT / "machines" / "example-mill")).bounds.second_order
    assert report.uncompensated_mm > 0.02
    assert report.largest_mm < 0.001 + 0.0005 + second_order + HELD_BACK
    assert second_order < 0.0003


def test_a_mill_with_50_um_errors(tmp_path):
    """The same with every translation scaled so that the largest deviation of the program is 50
    um."""
    for file in (ROOT / "machines" / "example-mill").iterdir():
        text = file.read_text()
        if file.suffix == ".csv":
            lines = text.splitlines()
            rows = [line.split(",") for line in lines[2:]]
            lines[2:] = [
                ",".join([row[0], *(f"{2 * float(v):.2f}" for v in row[1:])]) for row in rows
            ]
            text = "\n".join(lines) + "\n"
        (tmp_path / file.name).write_text(text)
    machine = places.load(str(tmp_path))
    filter_ = Filter(
        machine, dialects.load("linuxcnc"), setup_of(machine, {}), Options(tolerance=0.001)
    )
    text = MILL.split("G18")[0] + "\nM2\n"
    output = b"".join([filter_.feed(text.encode()), filter_.finish()]).decode()
    report = residual(
        text,
        output,
        "linuxcnc",
        ReferenceMachine.load(tmp_path),
        offsets={"G54": {"X": 0, "Y": 0, "Z": -250.0}},
    )
    assert report.uncompensated_mm > 0.05
    assert report.largest_mm < 0.001 + 0.0005 + machine.bounds.second_order


# -- five axes -------------------------------------------------------------------------------------


class FiveAxis:
    """machines/example-five-axis, read here anew: exact transforms of a pose."""

    def __init__(self, folder: Path):
        facts = tomllib.loads((folder / "machine.toml").read_text())
        self.links = [x for x in facts["chain"].split("-") if x in "XYZABC"]
        self.bed = facts["chain"].split("-").index("b") - 1
        self.tool = np.array([facts["tool"].get(x, 0.0) for x in "XYZ"])
        self.centre = {
            x: np.array([facts["axes"][x].get("centre", {}).get(y, 0.0) for y in "XYZ"])
            for x in self.links
        }
        self.lean = {
            x: np.array([facts["squareness"].get(f"{r}0{x}", 0.0) * URAD for r in "ABC"])
            for x in self.links
        }
        self.shift = {
            x: np.array([facts["location"].get(f"{d}0{x}_um", 0.0) * UM for d in "XYZ"])
            for x in self.links
        }
        self.table = {x: self._table(folder / f"{x}.csv", x) for x in self.links}

    @staticmethod
    def _table(path, axis):
        lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
        rows = list(csv.DictReader(lines))
        unit = "deg" if axis in "ABC" else "mm"
        nodes = np.array([float(row[f"{axis}_{unit}"]) for row in rows])
        columns = {}
        for c in "XYZABC":
            size, name = (UM, "um") if c in "XYZ" else (URAD, "urad")
            key = f"E{c}{axis}_{name}"
            both = [key, key] if key in rows[0] else [key + "_fwd", key + "_rev"]
            columns[c] = [size * np.array([float(row[k]) for row in rows]) for k in both]
        return nodes, columns

    def tip(self, pose: dict[str, float], sense: dict[str, int], scale: float) -> np.ndarray:
        links = []
        for k, x in enumerate(self.links):
            nodes, columns = self.table[x]
            q = pose[x]
            at = q - 360.0 * np.floor(q / 360.0) if x == "C" else q
            value = []
            for c in "XYZABC":
                up, down = (float(np.interp(at, nodes, v)) for v in columns[c])
                value.append({1: up, -1: down, 0: (up + down) / 2}[sense[x]])
            side = "workpiece" if k < self.bed else "tool"
            links.append(
                Link(
                    x,
                    side,
                    q,
                    np.array(value[:3]),
                    np.array(value[3:]),
                    self.shift[x],
                    self.lean[x],
                    np.zeros(3),
                    self.centre[x],
                )
            )
        return tip(links, self.tool, scale)


def poses(text: str) -> list[tuple[bool, dict[str, float]]]:
    """Whether each block is a feed, and the slide positions at its end; G54 lies 280 mm below in
    Z."""
    here, feed, result = dict.fromkeys("XYZAC", 0.0), False, []
    for line in re.sub(r"\([^)]*\)", "", text).splitlines():
        codes = re.findall(r"G0*([01])(?![0-9.])", line)
        feed = {"0": False, "1": True}[codes[-1]] if codes else feed
        words = re.findall(r"([XYZAC])(-?[0-9.]+)", line)
        if words:
            here = {**here, **{x: float(v) - (280.0 if x == "Z" else 0.0) for x, v in words}}
            result.append((feed, here))
    return result


def test_five_axes_at_once_stay_within_tolerance():
    """Every block turns C, so C tells how far the nominal program is: there the tool must be at the
    nominal place of the part, by exact transforms of the whole chain."""
    machine = FiveAxis(ROOT / "machines" / "example-five-axis")
    tolerance = 0.002
    nominal = poses(FIVE)
    output = poses(corrected("example-five-axis", FIVE, tolerance))
    worst = before = 0.0
    k, begin, sense = 0, output[0][1], dict.fromkeys("XYZAC", 0)
    for _, end in output[1:]:
        while abs(end["C"] - nominal[k][1]["C"]) > 1e-9 and not between(
            end["C"], nominal[k][1]["C"], nominal[k + 1][1]["C"]
        ):
            k += 1
        low, high = nominal[k][1], nominal[k + 1][1]
        if end["C"] == begin["C"] and end["A"] == begin["A"]:
            begin = end  # a take-up
            continue
        sense = {x: int(np.sign(high[x] - low[x])) or sense[x] for x in sense}
        for share in np.linspace(0.07, 1.0, 9):
            pose = {x: begin[x] + (end[x] - begin[x]) * share for x in begin}
            t = (pose["C"] - low["C"]) / (high["C"] - low["C"])
            should = {x: low[x] + (high[x] - low[x]) * t for x in low}
            place = machine.tip(should, sense, 0.0)
            worst = max(worst, float(np.linalg.norm(machine.tip(pose, sense, 1.0) - place)))
            before = max(before, float(np.linalg.norm(machine.tip(should, sense, 1.0) - place)))
        begin = end
        if abs(end["C"] - high["C"]) < 1e-9 and k + 2 < len(nominal):
            k += 1
    assert before > 0.02
    # Slides and A end on increments of 1 um and 0.001 degrees: A's half increment is 2 um at 250
    # mm.
    assert worst < tolerance + 0.0005 * np.sqrt(3) + np.radians(0.0005) * 300


def between(value, low, high):
    return min(low, high) - 1e-9 <= value <= max(low, high) + 1e-9


def test_a_rotary_axis_nobody_has_placed_is_asked_for():
    with pytest.raises(ProgramError, match="where A C stands is not known"):
        corrected("example-five-axis", "G21 G90 G54\nG0 X0 Y0 Z0\nG1 X10 F100\n", 0.001)


def test_an_arc_while_a_rotary_axis_turns_is_refused():
    with pytest.raises(ProgramError, match="an arc while C A turns"):
        corrected(
            "example-five-axis", "G21 G90 G54 G17\nG0 X0 Y0 Z0 A0 C0\nG2 X20 I10 C45 F100\n", 0.001
        )
