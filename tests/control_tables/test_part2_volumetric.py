"""ISG CSV and Etalon exchange hold a whole machine: what is read back deviates as the machine does,
and the control takes it out."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations
from pathlib import Path

import models_part2 as models
import numpy as np
import pytest
from pytest import approx

from postproc.control_tables import ErrorTable, ExportOptions, TableError, etalon, isg_csv
from postproc.errors import MachineError
from postproc.machine.axis import Axis
from postproc.machine.chain import Chain
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable, GridTable
from postproc.machine.volumetric import VolumetricMap
from postproc.recordings import Source

ROOT = Path(__file__).resolve().parents[2]
NANOMETRE = 1e-6  # mm
CHAINS = [(order, side) for order in permutations("XYZ") for side in range(4)]
FORMATS = [isg_csv, etalon]


def machine(
    seed: int, order=("X", "Y", "Z"), side: int = 2, two_way: bool = False, optics=("", "", "")
) -> Machine:
    """A three-axis machine of random errors: tens of um, tens of urad, measured somewhere, with a
    tool."""
    rng = np.random.default_rng(seed)
    size = np.array([0.02, 0.02, 0.02, 5e-5, 5e-5, 5e-5])[:, None]
    axes, square = {}, {}
    for x, optic in zip("XYZ", optics, strict=True):
        low = float(rng.uniform(-300, 50))
        nodes = np.cumsum(np.concatenate([[low], rng.uniform(5, 80, rng.integers(2, 9))]))
        forward = rng.uniform(-1, 1, (6, len(nodes))) * size
        reverse = forward + rng.uniform(-0.2, 0.2, forward.shape) * size if two_way else forward
        table = AxisTable(x, nodes, forward, reverse)
        axes[x] = Axis(
            x, (nodes[0], nodes[-1]), 1e-4, rng.uniform(-100, 100, 3), table, optic=optic
        )
        square[x] = rng.uniform(-1e-4, 1e-4, 3) * (np.arange(3) != "XYZ".index(x))
    chain = Chain(tuple(order), side)
    return Machine(
        "random", "", "linuxcnc", chain, axes, square=square, tool=rng.uniform(-100, 100, 3)
    )


def with_grid(base: Machine, seed: int = 5) -> Machine:
    """The same machine, whose X also depends on Z, and Z on Y."""
    rng = np.random.default_rng(seed)
    axes = dict(base.axes)
    for x, other in (("X", "Z"), ("Z", "Y")):
        nodes, others = (np.linspace(*base.axes[a].travel, n) for a, n in ((x, 4), (other, 3)))
        values = rng.uniform(-1, 1, (6, 4, 3)) * np.array([0.01] * 3 + [2e-5] * 3)[:, None, None]
        axes[x] = replace(axes[x], grids=(GridTable(x, other, nodes, others, values, values),))
    return replace(base, axes=axes)


def places(m: Machine, n: int = 40, beyond: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(1)
    low, high = np.array([m.axes[x].travel for x in "XYZ"]).T
    return (low - beyond)[:, None] + rng.random((3, n)) * (high - low + 2 * beyond)[:, None]


def back(form, m: Machine) -> Machine:
    """The machine that is read from what was written of this one."""
    export = form.write_machine(m, ExportOptions())
    name = next(n for n in export.files if not n.endswith(".lis"))
    extra = {"chain": "".join(m.chain.axes), "workpiece_axes": str(m.chain.workpiece_side)}
    return form.read_machine(Source(name, export.files[name]), ExportOptions(extra=extra)).machine()


def control(form, m: Machine, chain: str | None = None, side: int | None = None):
    """The control's model with the written files loaded."""
    files = form.write_machine(m, ExportOptions()).files
    if form is isg_csv:
        told = models.listing(files["gcomp.lis"].decode())
        assert (told["interpolation"], told["file[0]"], told["file_format[0]"]) == (
            "GRID",
            "gcomp.csv",
            "ISG_CSV",
        )
        return models.volcomp(
            models.isg_parameters(files["gcomp.csv"].decode()),
            told["chain"],
            int(told["workpiece_axes"]),
        )
    parameters = models.etalon_parameters(files["gcomp.txt"].decode())
    return models.volcomp(parameters, "".join(m.chain.axes), m.chain.workpiece_side)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("order, side", CHAINS)
def test_what_is_read_back_deviates_as_the_machine_does(form, order, side):
    """In all 24 orders of a chain, measured anywhere, with any tool; also where tables are held
    beyond their ends."""
    m = machine(7 + side, order, side)
    p, still = places(m, beyond=30.0), np.zeros((3, 40))
    assert back(form, m).deviation(p, still) == approx(m.deviation(p, still), abs=NANOMETRE / 100)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("order, side", CHAINS)
def test_the_control_reaches_what_was_commanded(form, order, side):
    """The model of the control, by homogeneous transforms, sends the slides to command - deviation;
    the machine is there within what a deviation changes along itself. With the sign turned the
    error is twice as large."""
    m = machine(70 + side, order, side)
    deviation = control(form, m)
    p = places(m, 12)
    still = np.zeros_like(p)
    model = np.array([deviation(q) for q in p.T]).T
    own = m.deviation(p, still)
    assert model == approx(own, abs=NANOMETRE)
    sent, turned = p - model, p + model
    assert np.abs(sent + m.deviation(sent, still) - p).max() < 0.004 * np.abs(own).max()
    assert (
        np.abs(turned + m.deviation(turned, still) - p - 2 * own).max() < 0.01 * np.abs(own).max()
    )


def test_the_example_mill_goes_through_both_formats():
    """All 21 components of the example machine, through text and back, at 1000 places."""
    m = read_machine(ROOT / "machines" / "example-mill")
    m = replace(m, effects=())
    p = np.random.default_rng(3).uniform(-1, 1, (3, 1000)) * np.array([[350], [200], [200]]) - [
        [0],
        [0],
        [200],
    ]
    still = np.zeros_like(p)
    for form in FORMATS:
        export = form.write_machine(m, ExportOptions())
        off = np.abs(back(form, m).deviation(p, still) - m.deviation(p, still)).max()
        assert off <= sum(export.remainder.values()) + NANOMETRE / 100
    assert (
        len(
            models.isg_parameters(
                isg_csv.write_machine(m, ExportOptions()).files["gcomp.csv"].decode()
            )
        )
        == 21
    )


@pytest.mark.parametrize("form", FORMATS)
def test_one_value_for_both_directions_leaves_what_is_reported(form):
    m = machine(11, two_way=True)
    export = form.write_machine(m, ExportOptions())
    p = places(m, 200)
    for way in (1.0, -1.0):
        off = m.deviation(p, np.full_like(p, way)) - back(form, m).deviation(p, np.zeros_like(p))
        assert 1e-4 < np.abs(off).max() <= sum(export.remainder.values())
    assert any("both directions" in notice for notice in export.notices)
    assert back(form, m).deviation(p, np.zeros_like(p)) == approx(
        m.deviation(p, np.zeros_like(p)), abs=NANOMETRE
    )


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("side", range(4))
def test_a_point_that_went_along_with_the_other_side_is_exact_at_nodes_only(form, side):
    """A rotation times the axis' own position bends between nodes: at the nodes it is exact,
    between it is told."""
    m = machine(13, side=side, optics=("tool", "workpiece", "tool"))
    export = form.write_machine(m, ExportOptions())
    p = places(m, 300)
    off = np.abs(
        back(form, m).deviation(p, np.zeros_like(p)) - m.deviation(p, np.zeros_like(p))
    ).max()
    assert NANOMETRE < off <= sum(export.remainder.values())
    nodes = np.array([[m.tables[x].nodes[1]] for x in "XYZ"])
    assert back(form, m).deviation(nodes, 0 * nodes) == approx(
        m.deviation(nodes, 0 * nodes), abs=NANOMETRE
    )


def test_errors_that_depend_on_a_second_axis_are_exact_in_isg_csv():
    m = with_grid(machine(17))
    p = places(m, 200, beyond=20.0)
    assert back(isg_csv, m).deviation(p, 0 * p) == approx(
        m.deviation(p, 0 * p), abs=NANOMETRE / 100
    )
    deviation = control(isg_csv, m)
    assert np.array([deviation(q) for q in p.T[:20]]).T == approx(
        m.deviation(p, 0 * p)[:, :20], abs=NANOMETRE
    )


def test_etalon_holds_the_middle_of_what_depends_on_a_second_axis():
    m = with_grid(machine(17))
    export = etalon.write_machine(m, ExportOptions())
    p = places(m, 300)
    off = np.abs(back(etalon, m).deviation(p, 0 * p) - m.deviation(p, 0 * p)).max()
    assert 1e-3 < off <= sum(export.remainder.values())
    assert any("over Z are written as their middle" in notice for notice in export.notices)


@pytest.mark.parametrize(
    "name, along, sign",
    [
        ("B0X", (1, 0, 0), (0, 0, -1)),
        ("C0Y", (0, 1, 0), (-1, 0, 0)),
        ("B0Z", (0, 0, 1), (1, 0, 0)),
        ("A0Z", (0, 0, 1), (0, -1, 0)),
    ],
)
def test_squareness_leans_as_the_names_say(name, along, sign):
    """By hand: 100 urad over 200 mm are 20 um, towards -Z for B0X, -X for C0Y, +X for B0Z, -Y for
    A0Z."""
    for form, text in ((isg_csv, f"{name}\n0.0001\n"), (etalon, f"[{name}]\nVALUE = 0.0001\n")):
        found = form.read_machine(Source("f", text.encode()), ExportOptions())
        place = 200.0 * np.array(along)[:, None]
        assert found.machine().deviation(place, 0 * place)[:, 0] == approx(
            0.02 * np.array(sign), abs=1e-12
        )


def test_the_examples_of_the_manual_are_read():
    """TF5280: X components for Z = 0 and Z = 100; two rows of EXY, C0B of a rotary axis and A0Z."""
    text = """// The argument "Z" in the header
Z      X      EXX    EYX    EZX    EAX    EBX    ECX
0.0    0.0    0.02   0.01   0.07   0.00   0.0042 0.003
0.0    10.0   0.00   -0.1   0.01   0.00   0.0011 0.002
100.0  0.0    0.01   0.02   0.03   0.07   0.0040 0.003
100.0  10.0   0.03   -0.09  0.03   0.06   0.0015 0.000
#
Y0A Z0A X0B
0.1 0.2 0.11
"""
    found = isg_csv.read_machine(Source("m.csv", text.encode()), ExportOptions())
    (exx,) = (g for g in found.grids if g.rows == [0])
    assert (exx.letter, exx.other) == ("X", "Z")
    # mean of the four
    assert exx.evaluate(np.array([5.0]), np.array([50.0]), np.zeros(1))[0] == approx(0.015)
    assert len(found.grids) == 6 and sum("is not read" in n for n in found.notices) == 3
    text = (
        "[C0B]\nVALUE = 0.000022355737\n[A0Z]\nVALUE = 0.0000476\n[EXY]\nGridpoints = {\n-280.0"
        " -0.001358635132\n-270.0 -0.000240680764 // c\n}  // end of EXY\n"
    )
    found = etalon.read_machine(Source("m.txt", text.encode()), ExportOptions())
    assert found.square == {"A0Z": 0.0000476} and "C0B" in found.notices[0]
    assert found.axes["Y"].evaluate(np.array([-275.0]), np.zeros(1))[0] == approx(-0.000799657948)


@pytest.mark.parametrize("form", FORMATS)
def test_one_axis_tables_go_there_and_back(form):
    rng = np.random.default_rng(2)
    tables = [
        ErrorTable(
            moving, along, np.array([0.0, 10.0, 35.5, 80.0]), v := rng.uniform(-0.05, 0.05, 4), v
        )
        for moving, along in (("X", "X"), ("X", "Z"), ("Z", "Z"))
    ]
    export = form.write(tables, ExportOptions(program="p"))
    name = next(n for n in export.files if not n.endswith(".lis"))
    read = {t.name: t for t in form.read(Source(name, export.files[name]), ExportOptions())}
    assert sorted(read) == ["EXX", "EZX", "EZZ"] and not export.remainder
    for table in tables:
        assert read[table.name].nodes == approx(table.nodes) and read[table.name].forward == approx(
            table.forward, abs=1e-12
        )
    with pytest.raises(TableError, match="given twice"):
        form.write([tables[0], tables[0]], ExportOptions())


@pytest.mark.parametrize("form", FORMATS)
def test_a_whole_machine_is_no_list_of_one_axis_tables(form):
    export = form.write_machine(machine(1), ExportOptions())
    name = next(n for n in export.files if not n.endswith(".lis"))
    with pytest.raises(TableError, match="whole machine"):
        form.read(Source(name, export.files[name]), ExportOptions())


def test_what_can_not_be_written_is_refused():
    with pytest.raises(MachineError, match="rotary axes"):
        isg_csv.write_machine(
            read_machine(ROOT / "machines" / "example-five-axis"), ExportOptions()
        )
    with pytest.raises(TableError, match="has no axis Y"):
        isg_csv.write_machine(read_machine(ROOT / "machines" / "studer-s36"), ExportOptions())
    for form in FORMATS:
        with pytest.raises(TableError, match="no deviation"):
            form.write_machine(read_machine(ROOT / "machines" / "perfect"), ExportOptions())
    m = with_grid(machine(1))
    twice = (*m.axes["X"].grids, replace(m.axes["X"].grids[0], other="Y"))
    with pytest.raises(TableError, match="depends on Z and on Y"):
        isg_csv.write_machine(
            replace(m, axes={**m.axes, "X": replace(m.axes["X"], grids=twice)}), ExportOptions()
        )


def test_a_two_axis_machine_is_written_for_etalon():
    m = replace(read_machine(ROOT / "machines" / "studer-s36"), effects=())
    p = np.random.default_rng(4).uniform(0, 160, (2, 100))
    read = back(etalon, m)
    assert read.deviation(p, 0 * p) == approx(m.deviation(p, 0 * p), abs=NANOMETRE)


def test_the_mean_of_both_directions_holds_for_grids_too():
    """By hand: 4 um one way and 2 um the other are 3 um either way."""
    both = np.full((6, 2, 2), 0.004), np.full((6, 2, 2), 0.002)
    grid = GridTable("X", "Z", np.array([0.0, 1.0]), np.array([0.0, 1.0]), *both)
    found = VolumetricMap({}, (grid,)).one_way()
    assert not found.two_way
    for values in (found.grids[0].forward, found.grids[0].reverse):
        assert values == pytest.approx(np.full((6, 2, 2), 0.003))
