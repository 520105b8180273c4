"""What the numbers of a machine folder mean: the measured values of the grinder's thesis, and the
deviation by the formula of the format, by hand."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.units import UM
from tests.machine_folders import TOML, correct, folder, swap

ROOT = Path(__file__).resolve().parents[1]
SEED = ROOT / "proof" / "seed" / "tables"
NANOMETRE = 1e-6  # mm


def columns(path: Path) -> dict[str, list[float]]:
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def between(nodes: list[float], values: list[float], at: float) -> float:
    """The straight line between two nodes, by hand."""
    for a, b, u, v in zip(nodes, nodes[1:], values, values[1:]):
        if a <= at <= b:
            return u + (v - u) * (at - a) / (b - a)
    raise AssertionError(f"{at} lies outside")


def test_the_grinder_has_the_measured_values():
    """M. Asad Ullah, NUST 2013, tables 6.1 and 6.2; the yaw in mm/m is 1000 urad."""
    machine = read_machine(ROOT / "machines" / "studer-s36")
    for letter, file, parts in (
        (
            "Z",
            "table_6_1_studer_s36_z_axis.csv",
            {2: ("dzz", 1.0), 0: ("dxz", 1.0), 4: ("eyz", 1e-3)},
        ),
        ("X", "table_6_2_studer_s36_x_axis.csv", {0: ("dxx", 1.0), 2: ("dzx", 1.0)}),
    ):
        seed, table = columns(SEED / file), machine.tables[letter]
        assert table.nodes == approx(seed[f"{letter.lower()}_mm"], abs=0)
        for row in range(6):
            name, scale = parts.get(row, (None, 0.0))
            for way, mine in (("forward", table.forward[row]), ("reverse", table.reverse[row])):
                ending = f"_{way}_mm" if scale == 1.0 else f"_{way}"
                theirs = (
                    np.array(seed[name + ending]) * scale if name else np.zeros(len(table.nodes))
                )
                assert mine == approx(theirs, abs=1e-12)
    assert machine.square["X"][1] == approx(-0.065 / 170, abs=1e-12)


POINTS = [
    (0.0, 0.0),
    (10.0, 30.0),
    (4.0, 17.0),
    (85.5, 255.25),
    (170.0, 510.0),
    (123.456, 7.89),
    (0.001, 509.999),
]


@pytest.mark.parametrize("x, z", POINTS)
@pytest.mark.parametrize("way_x", [1, 0, -1])
@pytest.mark.parametrize("way_z", [1, 0, -1])
def test_the_grinders_deviation_is_the_formula_of_the_format(x, z, way_x, way_z):
    """e_Z = EZZ + EZX - S x - b x, e_X = EXX + EXZ (tool and place of measurement are zero); 0 is
    the mean."""
    machine = read_machine(ROOT / "machines" / "studer-s36")
    on_z, on_x = (
        columns(SEED / "table_6_1_studer_s36_z_axis.csv"),
        columns(SEED / "table_6_2_studer_s36_x_axis.csv"),
    )

    def value(seed, nodes, name, at, way, unit):
        forward, reverse = (
            between(seed[nodes], seed[f"{name}_{w}{unit}"], at) for w in ("forward", "reverse")
        )
        return {1: forward, -1: reverse, 0: (forward + reverse) / 2}[way]

    yaw = value(on_z, "z_mm", "eyz", z, way_z, "") * 1e-3
    lean = -382.352941e-6
    e_z = (
        value(on_z, "z_mm", "dzz", z, way_z, "_mm")
        + value(on_x, "x_mm", "dzx", x, way_x, "_mm")
        - lean * x
        - yaw * x
    )
    e_x = value(on_x, "x_mm", "dxx", x, way_x, "_mm") + value(on_z, "z_mm", "dxz", z, way_z, "_mm")
    found = machine.deviation(np.array([[x], [z]]), np.array([[float(way_x)], [float(way_z)]]))
    assert found[:, 0] == approx([e_x, e_z], abs=NANOMETRE)


def test_the_arm_is_counted_from_where_it_was_measured(tmp_path):
    """e_Z gets -b (x + tool.X - measured_at.X), e_X gets b tool.Z: at z = 50 the yaw is 15 urad, by
    hand."""
    toml = swap(TOML, "[tool]\nX = 0.0\nZ = 0.0", "[tool]\nX = 30.0\nZ = 200.0")
    toml = swap(
        swap(toml, "measured_at = { X = 0.0 }", "measured_at = { X = 12.0 }"),
        "size_um = 9.0",
        "size_um = 0.0",
    )
    machine = read_machine(folder(tmp_path, toml=toml))
    found = machine.deviation(np.array([[50.0], [50.0]]), np.array([[0.0], [1.0]]))[:, 0]
    arm = 50.0 + 30.0 - 12.0
    e_z = 2 * UM + -1 * UM + 382.352941e-6 * 50 - 15e-6 * arm
    e_x = 5 * UM + 1.5 * UM + 15e-6 * 200
    assert found == approx([e_x, e_z], abs=NANOMETRE)


@pytest.mark.parametrize("way, part", [(1.0, -4.5), (-1.0, 4.5), (0.0, 0.0)])
def test_backlash_lags_behind_by_half_on_either_side(tmp_path, way, part):
    """9 um of lost motion in X: 4.5 um short of the target, from wherever it came."""
    machine = read_machine(folder(tmp_path))
    without = read_machine(folder(tmp_path, toml=swap(TOML, "size_um = 9.0", "size_um = 0.0")))
    place, approach = np.array([[20.0], [60.0]]), np.array([[way], [1.0]])
    difference = machine.deviation(place, approach) - without.deviation(place, approach)
    assert difference[:, 0] == approx([part * UM, 0.0], abs=NANOMETRE)


def test_before_an_axis_has_moved_the_mean_of_both_ways_holds():
    """X20 (radius 10) Z10 on the grinder, from nowhere. e_X = (7.6 - 0.6) / 2 + mean EXZ(10), e_Z =
    EZZ + EZX - S x - b x."""
    third = 10.0 / 30.0
    exz = -0.25 + (-0.2 + 0.25) * third
    ezz = 1.35 + (0.5 - 1.35) * third
    yaw = 2.65 + (0.45 - 2.65) * third
    e_x = 3.5 + exz
    e_z = ezz - 3.6 + 382.352941e-3 * 10 - yaw * 1e-3 * 10
    text = (
        correct(read_machine(ROOT / "machines" / "studer-s36"), b"G0 X20. Z10.\n")
        .split(b"\n")[1]
        .decode()
    )
    x, z = (float(word[1:]) for word in text.split()[1:])
    assert x == approx(20.0 - 2 * e_x * UM, abs=0.00006)
    assert z == approx(10.0 - e_z * UM, abs=0.00006)


def test_a_machine_without_squareness_cuts_arcs(tmp_path):
    machine = read_machine(
        folder(
            tmp_path, toml=swap(TOML, "[squareness]\nB0X = -382.352941                  # urad", "")
        )
    )
    out = correct(machine, b"G0 X20. Z10.\nG1 X30. F100\nG3 X40. Z15. R5.\nG2 X50. Z20. K5.\n")
    assert b"\nG3" in out
    assert b"\nG2" in out


def test_a_reversal_is_the_difference_of_the_two_ways(tmp_path):
    """EZZ at 100 mm is 3 um from below and 0 um from above, and nothing else: 3 um between the two
    commands."""
    z = "Z_mm,EZZ_um_fwd,EZZ_um_rev\n0,3,0\n250,3,0\n"
    toml = swap(swap(TOML, "size_um = 9.0", "size_um = 0.0"), "B0X = -382.352941", "B0X = 0.0")
    machine = read_machine(folder(tmp_path, toml=toml, z=z, x="X_mm,EXX_um\n0,0\n170,0\n"))
    out = correct(machine, b"G0 X20. Z10.\nG1 Z100. F100\nZ150.\nZ100.\n").decode().split("\n")
    ends = [
        float(line.split("Z")[1].split()[0])
        for line in out
        if "Z" in line and not line.startswith("(")
    ]
    assert 99.997 in ends
    assert ends[-1] == 100.0


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_what_counts_along_one_direction_is_what_all_components_give_there(direction):
    """A shift along it and the two rotations about the other axes: the third moves nothing that
    way."""
    rng = np.random.default_rng(2)
    axes = {
        x: Axis(x, (0.0, 100.0), 1e-4, np.zeros(3), AxisTable(x, np.linspace(0, 100, 5), *both))
        for x, both in zip("XYZ", rng.normal(0, 1e-3, (3, 2, 6, 5)), strict=True)
    }
    m = Machine("m", "", "", parse("w-X-Y-b-Z-t"), axes, square={}, tool=np.array([7.0, 8.0, 9.0]))
    q, way = rng.uniform(0, 100, (3, 50)), rng.choice([-1.0, 0.0, 1.0], (3, 50))
    every, alone = m.deviation(q, way), m.deviation(q, way, direction)
    assert alone[direction] == approx(every[direction], rel=1e-12)
