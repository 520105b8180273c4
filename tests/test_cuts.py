"""Where straight motions are cut, and on which increments the cuts lie: judged by the reference's
own interpreter and machine, and by hand."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from postproc.compensate import Options, cut, nodes
from postproc.compensate.columns import Columns
from postproc.compensate.settings import Settings
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.tables import MANY, AxisTable
from postproc.nc import dialects
from postproc.units import TICKS_PER_MM
from postproc.verify import Verifier
from tests.reference.evaluate import residual
from tests.reference.machine import Machine as Reference
from tests.small_machines import write_mill

by_the_kernel_too = pytest.mark.usefixtures("both_ways")  # where arcs are cut

UM = 1e-3  # mm
MACHINE = """format = "gcomp-machine/1"
name = "two-slides"
control = "linuxcnc"
chain = "w-b-X-Z-t"
[axes.X]
travel = [-10.0, 400.0]
least_increment = {step}
table = "X.csv"
measured_at = {{ X = 0.0, Z = 0.0 }}
[axes.Z]
travel = [-10.0, 900.0]
least_increment = {step}
table = "Z.csv"
measured_at = {{ X = 0.0, Z = 0.0 }}
[limits]
max_slope = 0.05
max_correction = 5.0
[offsets]
G54 = {{}}
"""
NOTHING = "Z_mm,EZZ_um\n-10,0\n900,0\n"
KINK = "Z_mm,EZZ_um\n-10,0\n100,0\n200,20\n900,20\n"


def machine(folder: Path, x: str, z: str = NOTHING, step: float = 0.00001) -> Path:
    folder.mkdir()
    (folder / "machine.toml").write_text(MACHINE.format(step=step))
    (folder / "X.csv").write_text(x)
    (folder / "Z.csv").write_text(z)
    return folder


def corrected(folder: Path, text: str, tolerance: float) -> str:
    m = read_machine(folder)
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), Options(tolerance=tolerance))
    return (filter_.feed(text.encode()) + filter_.finish()).decode()


def left(folder: Path, text: str, out: str) -> float:
    """mm: the largest residual that the reference finds."""
    return residual(text, out, "linuxcnc", Reference.load(folder), samples_per_mm=4).largest_mm


def test_the_command_passes_a_node_where_it_is_cut(tmp_path):
    """The slide is 1 mm off at X = 100 mm, where the slope of its error turns by 20 um/mm: it
    stands at the node while its command does, 1 mm before the nominal place. A cut at the nominal
    100 mm misses it by up to 14 um."""
    folder = machine(tmp_path / "m", "X_mm,EXX_um\n-10,-100\n0,0\n100,1000\n200,0\n400,0\n")
    text = "G21 G90\nG1 X0 Z0 F500\nX190 Z190\nM2\n"
    out = corrected(folder, text, 0.5 * UM)
    assert left(folder, text, out) < 0.5 * UM + 0.02 * UM
    assert left(folder, text, text) > 600 * UM
    assert len(out.splitlines()) <= len(text.splitlines()) + 2  # the remark, and one cut


def test_an_angle_and_its_arm_are_followed_in_as_many_parts_as_the_bend_asks_for(tmp_path):
    """By hand: EBX rises by 1 urad/mm and its arm is Z, so e_X = 1e-6 x z, which over X 100 mm and
    Z 800 mm bends by 1e-6 * 100 * 800 / 4 = 20 um away from its chord. An eighth of 2 um of
    tolerance is left to bends: sqrt(20 / 0.25) = 9 parts; in 3 parts 2.2 um would be left."""
    folder = machine(tmp_path / "m", "X_mm,EBX_urad\n-10,-10\n400,400\n")
    text = "G21 G90\nG1 X0 Z0 F500\nX100 Z800\nM2\n"
    out = corrected(folder, text, 2 * UM)
    assert left(folder, text, out) < 2 * UM + 0.02 * UM
    assert left(folder, text, text) > 70 * UM
    assert len(out.splitlines()) <= len(text.splitlines()) + 8


def test_cuts_of_incremental_blocks_are_whole_increments_from_where_the_block_begins(tmp_path):
    """X0.00005 lies between two increments of 0.0001 mm. Differences counted from there must be
    whole increments, else the control rounds every one of them."""
    folder = machine(tmp_path / "m", "X_mm,EXX_um\n-10,0\n100,0\n200,20\n400,20\n", step=0.0001)
    out = corrected(folder, "G21 G90\nG1 X0.00005 Z0 F500\nG91 X200\nM2\n", 0.5 * UM)
    words = [w[1:] for row in out.splitlines()[2:] for w in row.split() if w[0] == "X"]
    assert len(words) == 2, out
    assert all(len(w.partition(".")[2]) <= 4 for w in words), out
    assert sum(map(float, words)) == pytest.approx(200 - 0.020, abs=0.00006)


def test_a_resting_axis_between_two_increments_stays_there(tmp_path):
    """X has no error where it rests; the cuts that Z needs give it no word."""
    x = "X_mm,EXX_um\n-10,0\n100,0\n200,20\n400,20\n"
    folder = machine(tmp_path / "m", x, KINK, step=0.0001)
    out = corrected(folder, "G21 G90\nG1 X50.00005 Z0 F500\nZ300\nM2\n", 0.5 * UM)
    body = [row for row in out.splitlines()[2:] if row[0] != "("]
    assert len(body) == 4 and not any("X" in row for row in body), out


@pytest.mark.parametrize("um", [0.6, -0.6])
def test_a_node_off_the_chord_by_more_than_the_tolerance_is_a_cut(tmp_path, um):
    """X is out by 0.6 um at Z = 100 and by nothing at both ends; the tolerance is 0.5 um."""
    x = "X_mm,EXX_um\n-10,0\n400,0\n"
    z = f"Z_mm,EXZ_um\n-10,0\n0,0\n100,{um}\n200,0\n900,0\n"
    folder = machine(tmp_path / "m", x, z)
    text = "G21 G90\nG1 X50 Z0 F500\nX51 Z200\nM2\n"
    out = corrected(folder, text, 0.5 * UM)
    assert left(folder, text, text) > 0.55 * UM
    assert left(folder, text, out) < 0.1 * UM


BY = "X_mm,Z_mm,EXX_um\n" + "".join(
    f"{x},{z},{um}\n" for x, um in ((-10, 0), (100, 0), (200, 20), (400, 20)) for z in (-10, 900)
)


def by_two(folder: Path, rows: str) -> Path:
    """EXX by X and Z."""
    machine(folder, "", NOTHING)
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(text.replace('table = "X.csv"', 'by = { Z = "XZ.csv" }'))
    (folder / "X.csv").unlink()
    (folder / "XZ.csv").write_text(rows)
    return folder


def test_a_table_of_two_axes_bends_within_a_cell(tmp_path):
    """By hand: 20 um at one corner of a cell of 400 mm and nothing at the others: on its diagonal
    20 t^2, which its chord misses by 20 / 4 = 5 um in the middle."""
    rows = "X_mm,Z_mm,EXX_um\n0,0,0\n0,400,0\n400,0,0\n400,400,20\n"
    folder = by_two(tmp_path / "m", rows)
    out = corrected(folder, "G21 G90\nG1 X0 Z0 F500\nX390 Z390\nM2\n", 0.5 * UM)
    ends = [(0.0, 0.0)]
    for row in out.splitlines()[2:]:
        if row[0] == "X":
            x, z = row[1:].split("Z")
            ends.append((float(x), float(z)))
    begin, end = np.array(ends[:-1]), np.array(ends[1:])
    x, z = (begin[:, None] + (end - begin)[:, None] * np.linspace(0, 1, 50)[:, None]).T
    off = x + 0.020 * (x / 400) * (z / 400) - z  # from the line X = Z, times the root of 2
    assert np.abs(off).max() / math.sqrt(2) < 0.5 * UM + 0.02 * UM
    assert 3 < len(ends) < 20


def test_a_node_of_a_table_of_two_axes_is_a_cut_where_nothing_else_bends(tmp_path):
    """EXX by X and Z, the same for every Z: it rises from X = 100 to X = 200 by 20 um, so the chord
    from 50 to 190 misses it by 20 * 0.9 * 50 / 140 = 6.4 um at X = 100."""
    folder = by_two(tmp_path / "m", BY)
    text = "G21 G90\nG1 X50 Z0 F500\nX190 Z140\nM2\n"
    out = corrected(folder, text, 0.5 * UM)
    lines = [row for row in out.splitlines() if row[0] == "X"]
    assert len(lines) == 2 and "X100.0" in lines[0], out


@by_the_kernel_too
def test_between_two_candidates_products_bend_by_the_slack_at_most(tmp_path):
    """By hand: an angle of 5 urad/mm along X turns the arm Z, so X is off by 1.8 t^2 mm on the way
    from 0, 0 to 400, 900; equal parts of 1 / n miss it by 0.45 / n^2, 0.1 um with n = 68."""
    folder = machine(tmp_path / "m", "X_mm,EBX_urad\n-10,-50\n400,2000\n")
    m = read_machine(folder)
    start, target = np.zeros((2, 1)), np.array([[400.0], [900.0]])
    _, t, axis = nodes.candidates(m, start, target, 0.1 * UM)
    assert len(t) == 67 and (axis == -1).all()
    t = np.concatenate([[0.0], np.sort(t), [1.0]])
    off = m.deviation(target * t, np.zeros((2, len(t))))
    middle = m.deviation(target * (t[1:] + t[:-1]) / 2, np.zeros((2, len(t) - 1)))
    bend = np.abs(middle - (off[:, 1:] + off[:, :-1]) / 2).max()
    assert 0.09 * UM < bend <= 0.1 * UM


@by_the_kernel_too
@pytest.mark.parametrize("code", ["G2", "G3"])
@pytest.mark.parametrize("um", [0.5, 1.0, 2.0])
def test_an_arc_over_a_steep_map_is_cut_until_it_can_be_judged(tmp_path, code, um):
    """X errs by 40 um/mm to and fro, so that between a few samples more may hide than the tolerance
    allows: no long arc is taken for near enough (one was off by 33 um)."""
    rows = "".join(f"{x},{40 * (x % 2)}\n" for x in range(13))
    folder = machine(tmp_path / "m", f"X_mm,EXX_um\n-10,0\n{rows}400,0\n", step=0.0001)
    text = f"G21 G90 G18\nG1 X0 Z0 F500\n{code} X10 Z10 I10 K0\nM2\n"
    assert left(folder, text, corrected(folder, text, um * UM)) < um * UM + 0.0001


@pytest.mark.parametrize("before", ["", "G53 G0 X0 Z0\n", "G1 X10 F500\nG53 G1 X0\n"])
def test_a_feed_from_a_place_that_was_not_corrected_begins_with_its_correction(tmp_path, before):
    """X errs by 20 um everywhere, measured one way, and the slide stands at 0, by --start or by
    G53: it goes to -0.02 first, so that the whole line is in its place."""
    m = read_machine(machine(tmp_path / "m", "X_mm,EXX_um\n-10,20\n400,20\n", step=0.001))
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}, {"X": 0.0, "Z": 0.0}))
    text = f"G21 G90\n{before}G1 Z50 F500\nX30\nM2\n"
    lines = (filter_.feed(text.encode()) + filter_.finish()).decode().splitlines()
    assert lines[-4:-1] == ["G1 Z0.000 X-0.020 F500", "Z50.000", "X29.980"]


@by_the_kernel_too
@pytest.mark.parametrize(("size", "um"), [(3, 0.5), (4, 1.0), (8, 1.0)])
def test_chords_within_an_arc_are_written(tmp_path, size, um):
    """A map that turns by 64 um/mm at X = 5 mm, in steps of 10 um: near the node some pieces are
    too short for an arc to be proven and become lines, the next arc beginning at their ends.
    Without these lines it would begin up to 50 um away; steps leave 7 um aside."""
    folder = machine(tmp_path / "m", "X_mm,EXX_um\n-10,0\n0,0\n5,160\n10,0\n400,0\n", step=0.01)
    text = f"G21 G90 G18\nG1 X0 Z0 F500\nG2 X{size} Z{size} I{size} K0\nM2\n"
    out = corrected(folder, text, um * UM)
    lines = out.split("G2 ")[1].splitlines()[1:]
    assert any("G1 " in line for line in lines)
    assert left(folder, text, out) < um * UM + math.hypot(5 * UM, 5 * UM)


@by_the_kernel_too
@pytest.mark.parametrize(
    ("um", "helix"),
    [(1.0, "G1 X100 Y0 Z30 F500\nG3 X110 Y10 Z-30 I0 J10"),
     (2.0, "G1 X20 Y0 Z-30 F500\nG3 X20.5 Y0.5 Z35 I0 J.5")],
)  # fmt: skip
def test_a_helix_is_cut_where_its_third_axis_passes_nodes(tmp_path, um, helix):
    """Seven nodes of Z lie on its way, upwards or downwards."""
    m = read_machine(write_mill(tmp_path / "mill", two_way=False))
    zero = {"G54": dict.fromkeys("XYZ", 0.0)}
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, zero), Options(tolerance=um * UM))
    verifier = Verifier(filter_)
    filter_.feed(f"G90 G21 G54 G17\nG0 X0 Y0 Z0\n{helix}\nM2\n".encode())
    filter_.finish()
    assert verifier.passed, verifier.report()


def test_a_slide_does_not_turn_back_inside_its_play(tmp_path):
    """The straightness of X leads Z by 0.8 um up and down along a block that rises by 1 um, within
    the hysteresis of 1 um: Z goes on or rests, since back it would move within its play alone."""
    folder = machine(
        tmp_path / "m",
        "X_mm,EZX_um\n-10,0\n0,0\n100,-0.8\n200,-0.1\n300,-0.9\n400,-0.2\n",
        "Z_mm,EZZ_um_fwd,EZZ_um_rev\n-10,-3,3\n900,-3,3\n",
    )
    text = "G21 G90\nG1 X0 Z-5 F500\nZ0\nX400 Z0.001\nM2\n"
    out = corrected(folder, text, 0.2 * UM)
    behind = out.splitlines()[4:-1]
    z = [float(row.split("Z")[1]) for row in behind if "Z" in row]
    assert len(behind) > 1 and len(z) > 1, out
    assert z == sorted(z), out


def test_without_take_ups_the_reversal_fades_along_the_block(tmp_path):
    """By hand, on the way back: Z stands 6 um beside the command that its other side needs, 4 um of
    it after a third of the way, 2 um after two thirds; so the command 200, which stands for 200.023
    from above, belongs to 200.019, and 100, which stands for 100.003, to 100.001."""
    table = "Z_mm,EZZ_um_fwd,EZZ_um_rev\n-10,-3,3\n100,-3,3\n200,17,23\n900,17,23\n"
    m = read_machine(machine(tmp_path / "m", "X_mm,EXX_um\n-10,0\n400,0\n", table))
    options = Options(tolerance=0.2 * UM, reversal="off")
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m, {}), options)
    text = b"G21 G90\nG1 X0 Z0 F500\nX300 Z300\nX0 Z0\nM2\n"
    out = (filter_.feed(text) + filter_.finish()).decode().splitlines()
    assert out[5:] == [
        "X300.00000Z299.98300",
        "X200.01900 Z200.00000",
        "X100.00100Z100.00000",
        "X0.00000Z-0.00300",
        "M2",
    ]


def test_a_code_before_an_assigned_word_is_set_off(tmp_path):
    """Sinumerik: G64X=200 would be no code and its word."""
    m = read_machine(machine(tmp_path / "m", "X_mm,EXX_um\n-10,0\n100,0\n200,20\n400,20\n"))
    filter_ = Filter(m, dialects.load("siemens"), setup_of(m, {}), Options(tolerance=0.2 * UM))
    text = b"G71G90\nG1X0Z0F500\nG60X300\nX=0\nM30\n"
    assert b"\nG64 X=200.0" in filter_.feed(text) + filter_.finish()


@pytest.mark.parametrize(
    "block, first",
    [("G9 X300", "X200.0"), ("N7 G9 X300", "N7 X200.0"), ("X300 G9 F90", "X200.0"),
     ("N7G9X300", "N7X200.0"), ("N7  G9  X300", "N7   X200.0")],
)  # fmt: skip
def test_a_code_that_goes_takes_one_blank_along(tmp_path, block, first):
    """Only the last piece stops exactly; a line keeps no blank before its
    first word, and the blanks between two others stay but for one."""
    m = read_machine(machine(tmp_path / "m", "X_mm,EXX_um\n-10,0\n100,0\n200,20\n400,20\n"))
    filter_ = Filter(m, dialects.load("fanuc-mill"), setup_of(m, {}), Options(tolerance=0.2 * UM))
    text = f"G21G90\nG1X150.Z0F500\n{block.replace('300', '300.')}\nM30\n"
    lines = (filter_.feed(text.encode()) + filter_.finish()).decode().split("\n")
    at = next(i for i, line in enumerate(lines) if line.startswith(first))
    assert "G9" not in lines[at] and "G9" in lines[at + 1], lines


def test_the_code_of_the_block_behind_a_cut_one_stays(tmp_path):
    """Both stop exactly; only the first is cut, and gives its G9 to its last piece."""
    m = read_machine(machine(tmp_path / "m", "X_mm,EXX_um\n-10,0\n100,0\n200,20\n400,20\n"))
    filter_ = Filter(m, dialects.load("fanuc-mill"), setup_of(m, {}), Options(tolerance=0.2 * UM))
    text = b"G21G90\nG1X150.Z0F500\nG9 X300.\nG9 X310.\nM30\n"
    lines = (filter_.feed(text) + filter_.finish()).decode().split("\n")
    assert [line.startswith("G9") for line in lines[-6:]] == [
        False,
        False,
        True,
        True,
        False,
        False,
    ]


@pytest.mark.parametrize("um, moves", [(0.30, False), (0.32, True)])
def test_an_axis_that_rests_moves_for_more_than_half_its_share(tmp_path, um, moves):
    """By hand: of 1 um an eighth pays for products, the rest is shared by two axes: 0.875 / sqrt 2
    = 0.619 um for each, and half of it is 0.309."""
    x = f"X_mm,EZX_um\n-10,0\n0,0\n100,{um}\n400,{um}\n"
    out = corrected(machine(tmp_path / "m", x), "G21 G90\nG1 X0 Z0 F500\nX300\nM2\n", 1.0 * UM)
    assert (f"X300Z-{um * UM:.5f}" in out) is moves and ("Z-" in out) is moves


@pytest.mark.parametrize(
    "nodes", [np.arange(5.0) * 25, np.array([0.0, 25, 50, 75, 90]), np.array([0.0, 1, 40, 41, 99])]
)
def test_the_interval_of_a_place_does_not_depend_on_how_many_are_asked_for(nodes):
    """Evenly spaced nodes, all but the last, and uneven ones; at nodes, between, and beyond."""
    table = AxisTable("X", nodes, np.zeros((6, 5)), np.zeros((6, 5)))
    place = np.concatenate([nodes, nodes[:-1] + np.diff(nodes) / 3, [-5.0, 120.0]])
    many = np.tile(place, MANY)
    alone = [int(table.interval(place[k : k + 1])[0]) for k in range(len(place))]
    assert table.interval(many)[: len(place)].tolist() == alone
    assert table.place(place)[0].tolist() == alone
    assert alone == np.clip(np.searchsorted(nodes, place, side="right") - 1, 0, 3).tolist()


def test_of_places_that_are_as_good_as_one_a_cut_is_made_at_one():
    """Closer than a millionth of the motion: the first stays, at the end of a motion the end."""
    owner = np.array([1, 0, 0, 0, 0, 0, 1])
    t = np.array([0.0, 1.0, 0.5, 0.0, 0.5 + 1e-7, 1.0 - 1e-7, 1.0])
    order = nodes.tidy(owner, t)
    assert [(int(owner[k]), float(t[k])) for k in order] == [
        (0, 0.0), (0, 0.5), (0, 1.0), (1, 0.0), (1, 1.0),
    ]  # fmt: skip


def test_the_tolerance_is_shared_out(tmp_path):
    """An eighth is left to the approach; of the rest two corrected axes may miss by a part of
    sqrt 2 each, and in the plane of an arc by all of it, since both lie there. Of three, two do."""
    m = read_machine(machine(tmp_path / "m", KINK.replace("Z", "X"), KINK, step=0.000001))
    shares = Settings(m, Options(tolerance=0.008))
    assert shares.slack == pytest.approx(0.001, rel=1e-4)
    assert shares.chord == pytest.approx(0.007 / math.sqrt(2), rel=1e-4)
    assert shares.plane == pytest.approx(0.007, rel=1e-4)
    three = Settings(read_machine(write_mill(tmp_path / "mill", two_way=False)))
    assert three.plane == pytest.approx(three.chord * math.sqrt(2))


def test_ends_of_motions_are_those_of_the_program_to_the_bit():
    """Also where other places are asked for beside them: a batch may end anywhere."""
    rng = np.random.default_rng(1)
    start, target = rng.integers(-(10**13), 10**13, (2, 3, 1000))
    m = SimpleNamespace(start=start, target=target)
    b = SimpleNamespace(m=m, arc_of=np.full(1000, -1))
    motion, t = np.repeat(np.arange(1000), 3), np.tile([0.0, 0.3, 1.0], 1000)
    found = Columns.nominal(b, motion, t)
    assert (found[:, ::3] == start / TICKS_PER_MM).all()
    assert (found[:, 2::3] == target / TICKS_PER_MM).all()
    assert found[:, 1::3] * TICKS_PER_MM == pytest.approx(start + (target - start) * 0.3)


def test_a_cut_that_comes_to_an_end_of_its_stroke_is_none(monkeypatch):
    """Cuts lie on whole increments of the axis that turns, here of 1 over 4: at 0.1, 0.3 and 0.9
    of the way these are 0, 1 and 4. Two that come to the same place are one."""
    monkeypatch.setattr(cut, "_along", lambda b, chosen, owner, t: t)
    b = SimpleNamespace(
        machine=SimpleNamespace(turning=(0,)),
        begin_nominal=np.zeros((1, 1)),
        end_nominal=np.full((1, 1), 4.0),
        motion=np.zeros(1, int),
        m=SimpleNamespace(grid=np.full((1, 1), TICKS_PER_MM)),
    )
    t = np.array([0.1, 0.2, 0.3, 0.7, 0.9])
    owner, at, _ = cut._on_increments(b, np.zeros(1, int), np.zeros(5, int), t)
    assert at.tolist() == [0.25, 0.75] and owner.tolist() == [0, 0]
