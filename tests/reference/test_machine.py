"""The reference's machine against sums done by hand: what judges the product is judged here."""

import csv
import itertools
import math

import numpy as np
import pytest
from pytest import approx

from .samples import NANOMETRE, SECOND_ORDER, SEED, flat, make, seed_machine


def test_a_machine_without_errors_does_what_it_is_told(tmp_path):
    machine = make(tmp_path, "w-b-Z-X-t", flat("ZX"), tool={"X": 3.0, "Z": -80.0})
    assert list(machine.actual({"X": 12.5, "Z": 7.0}, {"X": 1, "Z": -1})) == [15.5, 0.0, -73.0]
    assert list(machine.deviation({"X": 12.5, "Z": 7.0}, {})) == [0.0, 0.0, 0.0]


def test_a_constant_shift_is_that_shift_everywhere(tmp_path):
    machine = make(
        tmp_path, "w-Y-b-X-Z-t", flat("XYZ", EXX_um=3.0, EZX_um=-2.0, EYY_um=7.0, EXZ_um=1.0)
    )
    for command in ({"X": 0, "Y": 0, "Z": 0}, {"X": 41.7, "Y": -3.3, "Z": 210.0}):
        assert machine.deviation(command, {"X": 1, "Y": -1, "Z": 0}) == approx(
            [0.004, 0.007, -0.002], abs=1e-12
        )


@pytest.mark.parametrize("approach, um", [(1, 8.0), (-1, 2.0), (0, 5.0)])
def test_each_direction_has_its_column_and_the_mean_holds_before(tmp_path, approach, um):
    tables = flat("ZX")
    tables["X"].update(EXX_um_fwd=[8.0, 8.0], EXX_um_rev=[2.0, 2.0])
    machine = make(tmp_path, "w-b-Z-X-t", tables)
    assert machine.deviation({"X": 10, "Z": 10}, {"X": approach, "Z": -approach})[0] == approx(
        um / 1000, abs=1e-12
    )


def test_between_nodes_linear_and_outside_refused_or_held(tmp_path):
    tables = {
        "X": {"nodes": [0.0, 10.0, 30.0], "EXX_um": [0.0, 4.0, -4.0]},
        "Z": {"nodes": [0.0, 100.0]},
    }
    machine = make(tmp_path, "w-b-Z-X-t", tables)
    at = lambda x, **how: 1000 * machine.deviation({"X": x, "Z": 50}, {}, **how)[0]
    assert [at(2.5), at(10), at(25), at(30)] == approx([1.0, 4.0, -2.0, -4.0], abs=NANOMETRE)
    with pytest.raises(ValueError, match="X = 30.1 mm is outside its table, 0.0 to 30.0"):
        at(30.1)
    assert at(35.0, clamp=True) == approx(-4.0, abs=NANOMETRE)
    assert at(30.1, margin=0.2) == approx(-4.0, abs=NANOMETRE)


def test_pure_yaw_is_an_exact_rotation_about_the_measured_point(tmp_path):
    """0.1 rad of Z yaw, tool 200 mm out in X and 30 in Z, measured at X = 50: (150, 30) turns about
    Y."""
    machine = make(
        tmp_path,
        "w-b-Z-X-t",
        flat("ZX", EBZ_urad=1e5),
        tool={"X": 120.0, "Z": 30.0},
        measured_at={"Z": {"X": 50.0}},
    )
    x, z, b = 150.0, 30.0, 0.1
    hand = [
        50.0 + x * math.cos(b) + z * math.sin(b),
        0.0,
        400.0 - x * math.sin(b) + z * math.cos(b),
    ]
    assert machine.actual({"X": 80.0, "Z": 400.0}, {}) == approx(hand, abs=1e-11)


def test_a_yawing_table_turns_about_itself_own_travel_included(tmp_path):
    """w-Z-b-X-t, the part rides on Z: e_X gets b (z + tool.Z) too, e_Z gets -b (x + tool.X)."""
    machine = make(tmp_path, "w-Z-b-X-t", flat("ZX", EBZ_urad=1e5), tool={"Z": 30.0})
    x, z, b = 80.0, 430.0, 0.1
    hand = [x * math.cos(b) + z * math.sin(b), 0.0, -x * math.sin(b) + z * math.cos(b)]
    assert machine.actual({"X": 80.0, "Z": 400.0}, {}) == approx(hand, abs=1e-11)


@pytest.mark.parametrize(
    "name, axis, moves",
    [
        ("C0Y", "Y", (-1, 0, 0)),
        ("B0Z", "Z", (1, 0, 0)),
        ("A0Z", "Z", (0, -1, 0)),
        ("B0X", "X", (0, 0, -1)),
    ],
)
def test_squareness_leans_the_axis_as_the_notation_map_says(tmp_path, name, axis, moves):
    machine = make(tmp_path, "w-X-b-Y-Z-t", flat("XYZ"), squareness={name: 100.0})
    command = dict({"X": 0.0, "Y": 0.0, "Z": 0.0}, **{axis: 200.0})
    assert machine.deviation(command, {}) == approx(0.02 * np.array(moves), abs=2e-6)


def test_the_grinder_by_hand(tmp_path):
    """z = 300, x = 100, nodes of both tables, added up from the printed columns."""
    machine = seed_machine(tmp_path)
    forward = machine.deviation({"X": 100, "Z": 300}, {"X": 1, "Z": 1})
    assert forward[2] == approx(-0.0023 - 0.0368 + 0.0382352941 + 5.0e-6 * 100, abs=SECOND_ORDER)
    assert forward[0] == approx(0.0086 + 0.0011, abs=SECOND_ORDER)
    mixed = machine.deviation({"X": 100, "Z": 300}, {"X": -1, "Z": 1})
    assert mixed[2] == approx(-0.0023 - 0.0382 + 0.0382352941 + 5.0e-6 * 100, abs=SECOND_ORDER)
    assert mixed[0] == approx(-0.0010 + 0.0011, abs=SECOND_ORDER)
    between = machine.deviation({"X": 5, "Z": 15}, {"X": -1, "Z": -1})
    yaw = (2.3e-6 + 0.2e-6) / 2
    assert between[2] == approx(0.00115 - 0.00195 + 0.0003823529 * 5 - yaw * 5, abs=SECOND_ORDER)
    assert between[0] == approx(-0.0005 - 0.0013, abs=SECOND_ORDER)


def test_the_grinder_with_a_tool_and_a_measured_point(tmp_path):
    """e_Z = ... - b (x + tool.X - measured_at.X), e_X = ... + b tool.Z."""
    machine = seed_machine(tmp_path, tool={"X": 20.0, "Z": -150.0}, measured_at={"Z": {"X": 70.0}})
    e = machine.deviation({"X": 100, "Z": 300}, {"X": 1, "Z": 1})
    assert e[2] == approx(
        -0.0023 - 0.0368 + 0.0382352941 + 5.0e-6 * (100 + 20 - 70), abs=SECOND_ORDER
    )
    assert e[0] == approx(0.0086 + 0.0011 + -5.0e-6 * -150, abs=SECOND_ORDER)


def test_the_printed_program_of_table_6_3_lands_within_rounding(tmp_path):
    """The geometric half, which has no yaw: nominal - deviation, 0.1 µm in radius (the table has
    0.1 µm digits)."""
    machine = seed_machine(tmp_path)
    for direction in machine.axes["Z"].components["B"]:
        direction[:] = [0.0] * len(direction)
    for row in csv.DictReader(open(SEED / "table_6_3_compensated_diagonal.csv")):
        z, x = float(row["z_nominal_mm"]), float(row["x_nominal_diameter_mm"]) / 2
        for name, sign in (("fwd", 1), ("rev", -1)):
            e = machine.deviation({"X": x, "Z": z}, {"X": sign, "Z": sign})
            assert float(row[f"geo_{name}_z"]) == approx(z - e[2], abs=1.01e-4)
            assert float(row[f"geo_{name}_x"]) / 2 == approx(x - e[0], abs=1.01e-4)


def chains():
    for order in itertools.permutations("XYZ"):
        for bed in range(4):
            yield "-".join(["w", *order[:bed], "b", *order[bed:], "t"])


def random_tables(rng):
    tables = {}
    for axis in "XYZ":
        tables[axis] = {"nodes": [-300.0, -80.0, 40.0, 300.0]}
        for direction in "XYZ":
            tables[axis][f"E{direction}{axis}_um"] = rng.uniform(-50, 50, 4)
        for direction in "ABC":
            tables[axis][f"E{direction}{axis}_urad"] = rng.uniform(-60, 60, 4)
    return tables


@pytest.mark.parametrize("chain", list(chains()))
def test_all_24_chains_agree_with_the_sum_to_first_order(tmp_path, chain):
    """e = sum of d + eps x (r - m) + c x (q u); what is left is of second order, and a quarter for
    half the errors."""
    rng = np.random.default_rng(list(chain.encode()))
    tables, unit = random_tables(rng), dict(zip("XYZ", np.eye(3)))
    squareness = {"C0Y": 120.0, "B0Z": -90.0, "A0Z": 70.0}
    lean = {"X": np.zeros(3), "Y": np.array([0, 0, 120e-6]), "Z": np.array([70e-6, -90e-6, 0])}
    tool = dict(zip("XYZ", rng.uniform(-150, 150, 3)))
    measured_at = {axis: dict(zip("XYZ", rng.uniform(-200, 200, 3))) for axis in "XYZ"}
    names = [link for link in chain.split("-") if link in "XYZ"]
    bed = chain.split("-").index("b") - 1
    for _ in range(5):
        q = dict(zip("XYZ", rng.uniform(-290, 290, 3)))
        left = []
        for scale in (1.0, 0.5):
            scaled = {
                axis: {
                    name: [v * (1.0 if name == "nodes" else scale) for v in column]
                    for name, column in table.items()
                }
                for axis, table in tables.items()
            }
            machine = make(
                tmp_path / str(scale),
                chain,
                scaled,
                tool=tool,
                measured_at=measured_at,
                squareness={name: value * scale for name, value in squareness.items()},
            )
            total = np.zeros(3)
            for k, axis in enumerate(names):
                value = {
                    name[1]: np.interp(q[axis], table["nodes"], table[name])
                    for table in [scaled[axis]]
                    for name in table
                    if name != "nodes"
                }
                d = 1e-3 * np.array([value["X"], value["Y"], value["Z"]])
                eps = 1e-6 * np.array([value["A"], value["B"], value["C"]])
                # The tool's side leaves its own travel out, the workpiece's side has it in.
                carried = names[k + 1 :] if k >= bed else names[k:]
                r = np.array([tool[a] for a in "XYZ"]) + sum(
                    (q[a] * unit[a] for a in carried), np.zeros(3)
                )
                m = np.array([measured_at[axis][a] if a in names[k + 1 :] else 0.0 for a in "XYZ"])
                total += (
                    d + np.cross(eps, r - m) + np.cross(scale * lean[axis], q[axis] * unit[axis])
                )
            left.append(np.abs(machine.deviation(q, {}) - total).max())
        # 3 x 100 µrad (and the lean) turn 600 mm once more, and 3 x 87 µm: 6e-4 * (6e-4 * 1000 +
        # 0.3) mm
        assert left[0] < 5e-4, "larger than second order"
        assert left[1] < 0.3 * left[0] + 1e-9, "not of second order"


def test_measured_at_of_an_axis_that_gives_no_arm(tmp_path):
    """w-b-Z-X-t: Z is below X, so where Z stood while X was measured is no arm, if the numbers are
    positions."""
    point = make(
        tmp_path,
        "w-b-Z-X-t",
        flat("ZX", EBX_urad=100.0),
        measured_at={"X": {"Z": 250.0}},
        literal="point",
    )
    stood = make(tmp_path, "w-b-Z-X-t", flat("ZX", EBX_urad=100.0), measured_at={"X": {"Z": 250.0}})
    assert point.deviation({"X": 0, "Z": 0}, {})[0] == approx(-0.025, abs=2e-6)
    assert stood.deviation({"X": 0, "Z": 0}, {})[0] == 0.0


@pytest.mark.parametrize(
    "change, why",
    [
        (dict(chain="w-Z-X-t"), "run from w over b to t"),
        (dict(chain="w-b-Z-Y-t"), "do not fit"),
        (dict(squareness={"B0B": 1.0}), "no such squareness"),
        (dict(squareness={"A0X": 1.0}), "no such squareness"),
        (dict(tool={"W": 1.0}), "names"),
        (
            dict(tables={"X": {"nodes": [0, 1], "EXX_urad": [0, 0]}, "Z": {"nodes": [0, 1]}}),
            "no such column",
        ),
        (
            dict(tables={"X": {"nodes": [0, 1], "EXX_um_fwd": [0, 0]}, "Z": {"nodes": [0, 1]}}),
            "_fwd and _rev",
        ),
        (dict(tables={"X": {"nodes": [1, 0]}, "Z": {"nodes": [0, 1]}}), "must ascend"),
    ],
)
def test_a_faulty_machine_is_refused(tmp_path, change, why):
    settings = dict({"chain": "w-b-Z-X-t", "tables": flat("ZX")}, **change)
    with pytest.raises(ValueError, match=why):
        make(tmp_path, settings.pop("chain"), settings.pop("tables"), **settings)
