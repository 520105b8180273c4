"""Machines beyond three tables: what depends on a second axis, heat, rotary axes, where the
measured point was fixed."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc.compensate import Options
from postproc.errors import GcompError, MachineError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.plausibility import implausible
from postproc.nc import dialects
from postproc.verify import Verifier

HEAD = """format = "gcomp-machine/1"
name = "m"
control = "linuxcnc"
chain = "{chain}"
[offsets]
G54 = {{}}
[limits]
max_slope = 0.05
"""
X, Y, Z = (f"[axes.{x}]\ntravel = [-200.0, 200.0]\nleast_increment = 0.0001\n" for x in "XYZ")
C = "[axes.C]\ntravel = [-720.0, 720.0]\nleast_increment = 0.0001\n"


def machine(folder: Path, text: str, **files: str):
    folder.mkdir(exist_ok=True)
    (folder / "machine.toml").write_text(text)
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content)
    return read_machine(folder)


def deviation(m, **place):
    position = np.array([[float(place.get(x, 0.0))] for x in m.letters])
    return dict(zip(m.letters, m.deviation(position, np.zeros_like(position))[:, 0], strict=True))


# -- tables of two axes ----------------------------------------------------------------------------

GRID = "Z_mm,X_mm,EXZ_um,EBZ_urad\n0,0,0,0\n0,100,10,0\n100,0,20,0\n100,100,50,100\n"


def test_a_table_of_two_axes_is_bilinear(tmp_path):
    """By hand at Z = 50, X = 25: (0 + 10/4) / 2 + (20 + 30/4) / 2 = 15 um; the yaw is 100 urad *
    0.5 * 0.25 = 12.5 urad,
    and turns an arm of 25 mm: e_Z = -12.5e-6 * 25 mm."""
    m = machine(
        tmp_path,
        HEAD.format(chain="w-b-Z-X-t")
        + X
        + Z
        + 'by = { X = "Z_by_X" }\n'.replace("Z_by_X", "g.csv"),
        g=GRID,
    )
    e = deviation(m, X=25, Z=50)
    assert e["X"] == approx(0.015, abs=1e-12)
    assert e["Z"] == approx(-12.5e-6 * 25, abs=1e-12)
    assert deviation(m, X=900, Z=900)["X"] == approx(0.050)  # held beyond


@pytest.mark.parametrize(
    "text, line, why",
    [
        ("Z_mm,EXZ_um\n0,1\n1,2\n", 1, "the second column is 'EXZ_um', not 'X_mm'"),
        ("X_mm,Z_mm,EXZ_um\n0,1,2\n", 1, "the first column is 'X_mm', not 'Z_mm'"),
        ("Z_mm,X_mm,EXZ_um\n0,0,1\n0,1,1\n1,0,1\n", 4, "Z = 1, X = 1 is missing: 1 of 4 pairs are"),
        (
            "Z_mm,X_mm,EXZ_um\n0,0,1\n0,1,1\n1,0,1\n1,1,1\n0,1,2\n",
            6,
            "this pair of positions stands twice",
        ),
        ("Z_mm,X_mm,EXZ_um\n0,0,1\n0,1,1\n", 1, "1 by 2 nodes"),
        ("Z_mm,X_mm,EXZ_um\n0,0,1\n0,1,900\n1,0,1\n1,1,900\n", 2, "899.00 um/mm along X"),
        ("Z_mm,X_mm,EXZ_um\n", 1, "0 nodes"),
        ("Z_mm,X_mm,EXZ_um\n0,0,a\n", 2, "'a' is not a number"),
    ],
)
def test_a_faulty_table_of_two_axes_is_refused(tmp_path, text, line, why):
    with pytest.raises(MachineError) as told:
        machine(tmp_path, HEAD.format(chain="w-b-Z-X-t") + X + Z + 'by = { X = "g.csv" }\n', g=text)
    assert why in str(told.value)
    assert f"g.csv:{line}:" in str(told.value)


def test_no_cell_between_nodes_is_steeper_than_its_bound(tmp_path):
    """Tables that are steep in one cell and flat in the next, of lines and angles, with squareness
    and arms: the deviation changes by no more than the bound of the cell says."""
    tables = {
        "x": "X_mm,EXX_um,EBX_urad\n-200,0,0\n-100,50,0\n0,50,90\n150,0,90\n200,0,0\n",
        "z": "Z_mm,EXZ_um,EBZ_urad\n-200,0,10\n-50,0,10\n-40,40,10\n200,40,-60\n",
    }
    text = HEAD.format(chain="w-b-Z-X-t")
    for axis in (X, Z):
        text += axis + f'table = "{axis[6].lower()}.csv"\n'
    m = machine(tmp_path, text, **tables)
    rng = np.random.default_rng(1)
    place = rng.uniform(-200, 200, (2, 3000))
    for row, letter in enumerate(m.letters):
        nodes, slopes = m.bounds.cells[letter]
        beside = place.copy()
        beside[row] += 1e-4
        moved = m.deviation(beside, np.zeros_like(place)) - m.deviation(place, np.zeros_like(place))
        steep = np.linalg.norm(moved, axis=0) / 1e-4
        cell = np.searchsorted(nodes, place[row])
        whole = cell == np.searchsorted(nodes, beside[row])
        assert (steep <= slopes[cell] + m.bounds.even + 1e-9)[whole].all()
        assert max(slopes) > 4 * min(slopes), "which tells a steep cell from a flat one"


def test_a_corner_that_will_be_refused_is_named_by_its_slides(tmp_path):
    """How far C is turned says nothing of it."""
    text = HEAD.format(chain="w-C-b-Z-X-t") + C + Z + X + 'table = "x.csv"\n'
    m = machine(tmp_path, text, x="X_mm,EXX_um\n-200,0\n200,900\n")
    (said,) = (line for line in implausible(m) if "refuses it" in line)
    assert re.match(r"at (X200 Z-?200|Z-?200 X200) the correction of X is 0\.900 mm", said)


@pytest.mark.parametrize(("um", "odd"), [(0.0, False), (0.019, True), (0.021, False), (1.0, False)])
def test_errors_below_what_is_ever_measured_are_odd(um, odd, tmp_path):
    text = HEAD.format(chain="w-b-Z-X-t") + Z + X + 'table = "x.csv"\n'
    m = machine(tmp_path, text, x=f"X_mm,EXX_um\n-200,0\n200,{um}\n")
    assert any("less than is ever measured" in line for line in implausible(m)) is odd


# -- heat ------------------------------------------------------------------------------------------


def test_heat_by_hand(tmp_path):
    """A scale of 10 um/(m K) at 23 C on a part of 11.5 um/(m K) at 22 C: 30 - 23 = +7 um/m from 50
    mm; at 150 mm 0.7 um."""
    heat = (
        "heat = { scale_um_m_K = 10.0, scale_C = 23.0, work_um_m_K = 11.5, work_C = 22.0, fixed_mm"
        " = 50.0 }\n"
    )
    m = machine(tmp_path, HEAD.format(chain="w-b-Z-X-t") + X + Z + heat)
    assert deviation(m, Z=150)["Z"] == approx(0.0007, abs=1e-12)
    assert deviation(m, Z=50)["Z"] == 0.0
    assert deviation(m.at_temperatures({"Z": 20.0}), Z=150)["Z"] == approx(-0.0023, abs=1e-12)
    assert m.at_temperatures({"Z": 20.0, "work": 20.0}).is_zero and not m.is_zero


def test_of_heat_that_is_not_stated_there_is_none(tmp_path):
    """Scale and part without a figure grow by nothing, from a fixed point at zero."""
    lathe = HEAD.format(chain="w-b-Z-X-t") + X + Z
    growth = machine(tmp_path, lathe + "heat = {}\n").axes["Z"].expansion
    assert (growth.scale, growth.work, growth.fixed) == (0.0, 0.0, 0.0)
    assert (growth.scale_at, growth.work_at) == (20.0, 20.0)


# -- arms ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "chain, optic, arm",
    [
        ("w-b-Z-X-t", "", 0.0),
        ("w-b-Z-X-t", "workpiece", 80.0),
        ("w-Z-b-X-t", "", 80.0),
        ("w-Z-b-X-t", "tool", 0.0),
    ],
)
def test_whether_the_own_travel_is_an_arm(tmp_path, chain, optic, arm):
    """EBZ = 100 urad at Z = 80: e_X = +EBZ * (Z arm). A measured point that goes along leaves the
    travel out (compensation theory: a table that carries the part, measured at the part, has it
    in)."""
    fixed = f'optic = "{optic}"\n' if optic else ""
    m = machine(
        tmp_path,
        HEAD.format(chain=chain) + X + Z + 'table = "t.csv"\n' + fixed,
        t="Z_mm,EBZ_urad\n0,100\n100,100\n",
    )
    assert deviation(m, Z=80)["X"] == approx(100e-6 * arm, abs=1e-12)


# -- rotary axes -----------------------------------------------------------------------------------


def test_a_table_of_one_turn_is_repeated(tmp_path):
    table = "C_deg,EXC_um\n0,1\n90,5\n360,1\n"
    m = machine(
        tmp_path, HEAD.format(chain="w-C-b-X-Y-t") + X + Y + C + 'table = "c.csv"\n', c=table
    )
    for c in (45, 405, -315, 700, -720):
        at = c % 360
        wanted = np.interp(at, [0, 90, 360], [1, 5, 1]) * 1e-3
        assert deviation(m, C=c)["X"] == approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    "text, why",
    [
        (C + 'table = "c.csv"\n', "ends a full turn of C with another value than it began"),
        (C.replace("C", "C") + "centre = { X = 1.0, U = 2.0 }\n", "centre ="),
        (C + "[location]\nX0C = 5.0\n", "'X0C' is not a key of [location]"),
        (C + "[location]\nZ0C_um = 5.0\n", "'Z0C_um' is not a key"),
        (C + "[squareness]\nC0C = 5.0\n", "'C0C' is not a squareness of this machine"),
        (X.replace("X", "X") + "centre = { X = 1.0 }\n", "linear axis and has no centre"),
    ],
)
def test_a_faulty_rotary_axis_is_refused(tmp_path, text, why):
    chain = "w-C-b-X-Y-t" if "[axes.C]" in text else "w-b-X-Y-t"
    more = X + Y if "[axes.C]" in text else Y
    with pytest.raises(MachineError) as told:
        machine(
            tmp_path, HEAD.format(chain=chain) + more + text, c="C_deg,EXC_um\n0,1\n90,5\n360,2\n"
        )
    assert why in str(told.value)
    assert "machine.toml:" in str(told.value) or "c.csv:" in str(told.value)


@pytest.mark.parametrize(
    "chain, why",
    [
        ("w-A-B-C-b-X-t", "more than two rotary axes"),
        ("w-C-C-b-X-t", "names an axis twice"),
        ("w-D-b-X-t", "'D' is not one of"),
        ("w-W-b-X-t", "W is a second slide along Z, which it does not name"),
        ("w-C-b-X-Y-Z-W-t", "second slides and rotary axes, which are not followed together"),
    ],
)
def test_a_faulty_chain_is_refused(tmp_path, chain, why):
    with pytest.raises(MachineError, match=why):
        machine(tmp_path, HEAD.format(chain=chain) + X)


# -- all of them through the filter ----------------------------------------------------------------


def random_machine(folder: Path, seed: int):
    """Any chain, tables of any kind, of the size of real machines."""
    rng = np.random.default_rng(seed)
    rotary = [[], ["C"], ["B"], ["C", "A"]][int(rng.integers(4))]
    linear = [["X", "Y", "Z"], ["X", "Z"], ["Y", "X", "Z"]][int(rng.integers(3))]
    first = bool(rng.integers(2))
    order = [*rotary, *linear] if first else [*linear, *rotary]
    bed = int(rng.integers(len(order) + 1))
    text = HEAD.format(chain="-".join(["w", *order[:bed], "b", *order[bed:], "t"]))
    files = {}
    for x in order:
        turn = x in "ABC"
        low, high = (-180.0, 180.0) if turn else (-200.0, 200.0)
        text += (
            f"[axes.{x}]\ntravel = [{low}, {high}]\nleast_increment = 0.0001\n"
            + f'table = "{x}.csv"\n'
        )
        if turn:
            text += (
                f"centre = {{ X = {rng.uniform(-40, 40):.1f}, Y = {rng.uniform(-40, 40):.1f}, Z ="
                f" {rng.uniform(-40, 40):.1f} }}\n"
            )
        nodes = np.linspace(low, high, int(rng.integers(2, 7)))
        names = [
            f"E{c}{x}_um{d}" for c in "XYZ" for d in (("_fwd", "_rev") if c == x else ("",))
        ] + [f"E{c}{x}_urad" for c in "ABC"]
        table = [np.round(np.cumsum(rng.normal(size=len(nodes))) * 6, 2) for _ in names]
        own = [names.index(f"E{x}{x}_um{way}") for way in ("_fwd", "_rev")] if not turn else []
        for one, two in [own] if own else []:  # a slide lags behind
            table[one], table[two] = (
                np.minimum(table[one], table[two]),
                np.maximum(table[one], table[two]),
            )
        files[x] = f"{x}_{'deg' if turn else 'mm'}," + ",".join(names) + "\n"
        files[x] += "".join(
            ",".join(f"{v:g}" for v in row) + "\n" for row in zip(nodes, *table, strict=True)
        )
        if rng.random() < 0.4 and not turn:
            other = str(rng.choice([o for o in order if o != x]))
            text += f'by = {{ {other} = "{x}_by.csv" }}\n'
            ends = (-180.0, 180.0) if other in "ABC" else (-200.0, 200.0)
            grid = [(a, b) for a in np.linspace(-200, 200, 3) for b in np.linspace(*ends, 4)]
            unit = "deg" if other in "ABC" else "mm"
            files[f"{x}_by"] = f"{x}_mm,{other}_{unit},EX{x}_um,EA{x}_urad\n"
            files[f"{x}_by"] += "".join(
                f"{a:g},{b:g},{rng.normal() * 6:.2f},{rng.normal() * 10:.2f}\n" for a, b in grid
            )
    return machine(folder, text, **files), order


def random_program(rng: random.Random, axes: list[str]) -> str:
    def word(x: str) -> str:
        return f"{x}{rng.uniform(-150, 150):.{rng.choice((0, 1, 3))}f}"

    lines = ["G21 G90 G54", "G0 " + " ".join(word(x) for x in axes), "F300"]
    for _ in range(12):
        some = rng.sample(axes, rng.randint(1, len(axes)))
        lines.append(rng.choice(("G1 ", "G1 ", "G0 ")) + " ".join(word(x) for x in some))
    return "\n".join(lines) + "\nM2\n"


@pytest.mark.parametrize("seed", range(40))
def test_any_machine_keeps_the_tolerance(tmp_path, seed):
    """The places where to cut are found from bounds; the Verifier samples between them, and knows
    none of the bounds."""
    m, axes = random_machine(tmp_path, seed)
    rng = random.Random(seed)
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
    verifier = Verifier(filter_)
    text = random_program(rng, axes).encode()
    filter_.feed(text)
    filter_.finish()
    slides = m.two_way[list(m.corrected)].sum()
    limit = (
        0.001 + 0.00005 * np.sqrt(3) + 1.5 * 0.001 * np.sqrt(slides)
    )  # each held back by the hysteresis and half of it
    assert max(verifier.corrected.deviation, verifier.corrected.slide) <= limit
    assert verifier.uncorrected.deviation > 0.005
    cut = rng.randrange(len(text))
    again = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
    whole = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=0.001))
    parts = again.feed(text[:cut]) + again.feed(text[cut:]) + again.finish()
    assert parts == whole.feed(text) + whole.finish()


def test_random_machines_are_machines(tmp_path):
    kinds = set()
    for seed in range(40):
        try:
            m, _ = random_machine(tmp_path / str(seed), seed)
        except GcompError as error:  # a slip in this file, not in the product
            raise AssertionError(str(error)) from None
        kinds.add((len(m.chain.rotary), len(m.corrected), bool(m.grids)))
    assert len(kinds) >= 8


def wide(machine: Machine, travel: float) -> Machine:
    """The same machine, said to travel much farther than its tables reach."""
    axes = {x: replace(a, travel=(-travel, travel)) for x, a in machine.axes.items()}
    return replace(machine, axes=axes)


def test_a_travel_far_wider_than_the_tables_lengthens_no_arm():
    """Places outside the tables are an error, so no arm is longer than they are: within 0.5 mm of a
    correction."""
    from postproc.machine import places

    machine = places.load(str(Path(__file__).resolve().parents[1] / "machines" / "example-mill"))
    far = wide(machine, 5000.0)
    for name in ("steepest", "kink", "second_order"):
        assert getattr(far.bounds, name) == pytest.approx(getattr(machine.bounds, name), rel=2e-3)
    clamped = replace(far, limits=replace(far.limits, outside="clamp"))
    assert clamped.bounds.steepest > 4 * machine.bounds.steepest  # there the arm may be 5 m long
