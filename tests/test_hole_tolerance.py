"""Holes and taps have a tolerance of their own: how far an axis may bend while its cycle holds X
and Y."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.nc import dialects
from postproc.verify import Verifier
from tests.small_machines import write_mill

UM = 1e-3
NODES = np.array([-60.0, -20.0, 0.0, 60.0])


def mill(bend_um: float) -> Machine:
    """X is off by nothing at z = 0 and -60, and by twice `bend_um` at -20: half of it from the
    middle either way."""
    rows = np.zeros((6, len(NODES)))
    rows[0] = [0.0, 2 * bend_um * UM, 0.0, 0.0]
    axes = {x: Axis(x, (-300.0, 300.0), 1e-4, np.zeros(3)) for x in "XYZ"}
    axes["Z"] = Axis("Z", (-60.0, 60.0), 1e-4, np.zeros(3), AxisTable("Z", NODES, rows, rows))
    return Machine("m", "", "fanuc-mill", parse("w-X-Y-b-Z-t"), axes)


def corrected(bend_um: float, cycle: str, dialect: str = "fanuc-mill", **options):
    text = (
        f"G21 G90 G17\nM3 S500\nG0 X0. Y0. Z50.\n{cycle} X10. Y10. Z-40. R2. F100\nX20.\nG80\nG0"
        " Z50.\n"
    )
    machine = mill(bend_um)
    filter_ = Filter(
        machine, dialects.load(dialect), setup_of(machine), Options(tolerance=0.0005, **options)
    )
    verifier = Verifier(filter_)
    out = (filter_.feed(text.encode()) + filter_.finish()).decode()
    return out, filter_.notices, verifier


@pytest.mark.parametrize("cycle", ["G81", "G83 Q5.", "G73 Q5.", "G84", "G74"])
def test_a_hole_that_bends_within_its_tolerance_keeps_its_cycle(cycle):
    out, notices, verifier = corrected(4.0, cycle)
    assert f"{cycle} X9.9960 Y10. Z-40." in out and "X19.9960\n" in out
    assert [(n.code, n.line) for n in notices] == [("hole", 4)] and "4.00 um" in notices[0].message
    assert verifier.passed and verifier.holes.deviation + verifier.taps.deviation == pytest.approx(
        0.004, abs=2e-5
    )
    assert (
        "um aside (line " in verifier.report() and "tolerance of holes 5 um)" in verifier.report()
    )


def test_a_hole_within_the_tolerance_of_paths_says_nothing():
    _, notices, verifier = corrected(0.4, "G81")
    assert notices == [] and "aside" not in verifier.report()


@pytest.mark.parametrize("cycle", ["G81", "G83 Q5."])
def test_a_hole_that_bends_more_is_refused_and_both_ways_out_work(cycle):
    with pytest.raises(ProgramError) as error:
        corrected(7.0, cycle)
    assert (
        "bends by 7.00 um between Z = 2.000 and -40.000 mm (tolerance of holes 5 um)"
        in error.value.message
    )
    assert "--expand" in error.value.advice and "--hole-tolerance 7um" in error.value.advice
    _, _, verifier = corrected(7.0, cycle, hole_tolerance=0.007)
    assert verifier.passed and "tolerance of holes 7 um" in verifier.report()


@pytest.mark.parametrize(
    "cycle, dialect",
    [("G84", "fanuc-mill"), ("G74", "fanuc-mill"), ("G84", "haas"), ("G84", "linuxcnc")],
)
def test_a_tap_is_corrected_for_the_middle_and_said(cycle, dialect):
    """It can not be written out, so --expand would say the same again."""
    out, notices, verifier = corrected(7.0, cycle, dialect)
    assert f"{cycle} X9.9930 " in out
    said = [n for n in notices if n.code == "tap"]
    assert len(said) == 1 and "7.00 um" in said[0].message and "--expand" not in said[0].message
    assert verifier.passed and verifier.taps.deviation == pytest.approx(0.007, abs=5e-5)
    assert "taps, which hold their place" in verifier.report()


def test_the_tolerance_of_paths_is_the_least():
    machine = mill(1.0)
    filter_ = Filter(
        machine,
        dialects.load("haas"),
        setup_of(machine),
        Options(tolerance=0.02, hole_tolerance=0.001),
    )
    assert filter_.compensator.hole_tolerance == 0.02


def test_g33_1_goes_straight_down_from_where_the_axes_stand():
    """No X or Y word may come into a rigid tap of G33.1, which would slant it; its bend from there
    is said, at z = -20: 14 um."""
    machine = mill(7.0)
    filter_ = Filter(
        machine, dialects.load("linuxcnc"), setup_of(machine), Options(tolerance=0.0005)
    )
    verifier = Verifier(filter_)
    text = (
        "G21 G90 G17\nM3 S500\nG0 X10. Y10. Z0.\nG33.1 Z-40. K1.\nG91 G33.1 Z-30. K1.\nG90 G0"
        " Z50.\nM2\n"
    )
    out = (filter_.feed(text.encode()) + filter_.finish()).decode()
    assert "\nG33.1 Z-40. K1.\nG91 G33.1 Z-30. K1.\n" in out
    assert [n.code for n in filter_.notices] == ["tap"] and "bends by 14.00 um" in filter_.notices[
        0
    ].message
    assert verifier.passed and verifier.taps.deviation == pytest.approx(0.014, abs=2e-4)
    with pytest.raises(ProgramError, match="a rigid tap with a word of X"):
        filter_ = Filter(
            machine, dialects.load("linuxcnc"), setup_of(machine), Options(tolerance=0.0005)
        )
        filter_.feed(b"G21 G90 G17\nM3 S500\nG0 X10. Y10. Z0.\nG33.1 X11. Z-40. K1.\n")


@pytest.mark.parametrize("way", [-1, 1])
def test_a_hole_where_a_rapid_stands_already_is_corrected_for_its_own_middle(way):
    """X is 17 um off at z = 50 and 0 to 4 um in the hole; with 2 um of lost motion it must move,
    though that is against its side."""
    rows = np.zeros((6, 4))
    rows[0] = np.array([0.0, 4.0, 4.0, -20.0]) * UM
    lost = np.zeros((6, 2))
    lost[0] = 1 * UM
    axes = {x: Axis(x, (-300.0, 300.0), 1e-4, np.zeros(3)) for x in "XYZ"}
    axes["X"] = Axis(
        "X",
        (-300.0, 300.0),
        1e-4,
        np.zeros(3),
        AxisTable("X", np.array([-300.0, 300.0]), -lost, lost),
    )
    axes["Z"] = Axis("Z", (-60.0, 60.0), 1e-4, np.zeros(3), AxisTable("Z", NODES, rows, rows))
    machine = Machine("m", "", "fanuc-mill", parse("w-X-Y-b-Z-t"), axes)
    filter_ = Filter(
        machine, dialects.load("fanuc-mill"), setup_of(machine), Options(tolerance=0.0005)
    )
    verifier = Verifier(filter_)
    text = (
        f"G21 G90 G17\nM3 S500\nG0 X0. Y0. Z50.\nG0 X{way * 10}.\nG81 X{way * 10}. Y0. Z-40. R2."
        " F100\nG80\n"
    )
    filter_.feed(text.encode())
    assert verifier.passed and verifier.holes.deviation < 0.005, verifier.report()


@pytest.mark.parametrize("back", ["G98", "G99"])
def test_a_hole_from_the_level_at_which_the_tool_stands_ends_at_r(tmp_path, back):
    """Z neither moves on the whole nor rests: it goes down from R and back there, and R is written
    as it stands. What follows it is corrected from R, not from where Z stood before."""
    machine = read_machine(write_mill(tmp_path / "mill", True))
    filter_ = Filter(
        machine, dialects.load("haas"), setup_of(machine, {"G54": {}}), Options(hole_tolerance=0.1)
    )
    verifier = Verifier(filter_)
    text = (
        "G21 G90 G54 G0 X5. Y0. Z30.\nG1 Z-30. F99.\nZ20.\nX9.\n"
        f"{back} G81 Z-35. R20. F99.\nG80\nG1 X150. F99.\nG0 Z30.\n"
    )
    filter_.feed(text.encode())
    filter_.finish()
    assert verifier.passed, verifier.report()


@pytest.mark.parametrize("size", [1, 1000])
def test_distances_behind_g98_count_from_the_level_before_the_cycle(tmp_path, size):
    """G98 goes back to where the axis stood before the first hole, also behind holes that ended at
    R (B-63944EN, "Canned cycle for drilling"): 30 here, and 20 in the second cycle, behind G80."""
    machine = read_machine(write_mill(tmp_path / "mill", True))
    filter_ = Filter(
        machine, dialects.load("haas"), setup_of(machine, {"G54": {}}), Options(hole_tolerance=0.1)
    )
    verifier = Verifier(filter_)
    text = (
        "G21 G90 G54 G0 X5. Y0. Z30.\nG99 G81 X9. Z-35. R20. F99.\nX19.\nG98 X50.\nX60.\nG80\n"
        "G91 G1 Z-2. F99.\nX9.\nZ2.\nG90 G99 G81 X9. Z-35. R20. F99.\nG80\n"
        "G98 G81 X9. Z-35. R15. F99.\nG80\nG91 G1 Z-2. F99.\n"
    )
    for i in range(0, len(text), size):
        filter_.feed(text[i : i + size].encode())
    filter_.finish()
    assert verifier.passed, verifier.report()


def test_distances_behind_a_hole_without_r_count_from_where_the_tool_stood(tmp_path):
    """R level is the place where the tool stands then (B-63534EN, "Canned cycle cancel"), as it was
    commanded: 30 and its correction."""
    machine = read_machine(write_mill(tmp_path / "mill", True))
    filter_ = Filter(
        machine, dialects.load("haas"), setup_of(machine, {"G54": {}}), Options(hole_tolerance=0.1)
    )
    verifier = Verifier(filter_)
    text = "G21 G90 G54 G0 X5. Y0. Z30.\nG98 G81 X9. Z-35. F99.\nX150.\nG80\nG91 G1 Z-2. F99.\n"
    filter_.feed(text.encode())
    filter_.finish()
    assert verifier.passed, verifier.report()


def judged(bend_um: float, cycle: str, wrong: bytes) -> Verifier:
    """The verifier of two holes, the first of which X came to `wrong`."""
    m = mill(bend_um)
    filter_ = Filter(m, dialects.load("fanuc-mill"), setup_of(m), Options(tolerance=0.0005))
    verifier = Verifier(filter_)
    right = f"X{10 - bend_um / 1000:.4f}".encode()

    def damaged(words, motions, pieces, output, line):
        assert output.count(right) == 1
        verifier.check(words, motions, pieces, output.replace(right, wrong), line)

    filter_.watchers[:] = [damaged]
    filter_.feed(
        f"G21 G90 G17\nM3 S500\nG0 X0. Y0. Z50.\n{cycle} X10. Y10. Z-40. R2. F100\nX20.\nG80\n"
        "G0 Z50.\n".encode()
    )
    filter_.finish()
    return verifier


@pytest.mark.parametrize(
    "bend_um,cycle,wrong",
    [
        (0.2, "G81", b"X9.9950"),  # 4.8 um off, within the tolerance of holes
        (4.0, "G84", b"X9.9000"),  # 96 um off: a tap has no tolerance
        (40.0, "G84", b"X9.9580"),
    ],
)
def test_no_hole_may_be_farther_off_than_its_axis_bends(bend_um, cycle, wrong):
    right = f"X{10 - bend_um / 1000:.4f}".encode()
    assert judged(bend_um, cycle, right).passed
    assert not judged(bend_um, cycle, wrong).passed
