"""What `--verify` counts, and what not: its figures on outputs that are right, and on outputs into
which a wrong number was put."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.commands.outcome import verified_by
from postproc.compensate import Options
from postproc.errors import GcompError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.shifted import Way
from postproc.units import UM
from postproc.verify import Verifier
from postproc.verify.cutter import CentreVerifier
from postproc.verify.distance import _from_arc
from tests.small_machines import write_lagging
from tests.test_lost_motion import backlash, corrected, machine
from tests.test_unknown_places import mill

ROOT = Path(__file__).resolve().parents[1]


def verified(m, program: str, old: bytes = b"", new: bytes = b"", **options) -> Verifier:
    """The verifier of a program in whose output `old`, which stands there once, became `new`."""
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m), Options(**options))
    verifier = Verifier(filter_)

    def damaged(words, motions, pieces, output, line):
        assert not old or output.count(old) == 1, output
        verifier.check(words, motions, pieces, output.replace(old, new), line)

    filter_.watchers[:] = [damaged]
    filter_.feed(program.encode())
    filter_.finish()
    return verifier


# X stands 20 um too far at 50 mm, and right at 0 and at 100 mm
BENT = "X_mm,EXX_um\n-400,0\n0,0\n50,20\n100,0\n400,0\n"


def test_of_a_rapid_that_was_cut_the_last_end_counts(tmp_path):
    """--cut-rapids: X50 on the way to X100 is no end of the program's rapid, and not 50 mm off; a
    last end that is 30 um off is."""
    m = machine(tmp_path / "m", "", X=BENT)
    program = "G0 X0 Y0 Z0\nG0 X100\nM2\n"
    verifier = verified(m, program, cut_rapids=True)
    assert verifier.motions_out > verifier.motions_in and verifier.passed
    verifier = verified(m, program, b"X100.0000", b"X100.0300", cut_rapids=True)
    assert abs(verifier.corrected.deviation - 30 * UM) < 0.1 * UM and not verifier.passed


def test_what_a_reversal_moves_another_axis_by_is_allowed_where_it_turns(tmp_path):
    """X turns back on a circle, and its slide moves Y by 12 um in that moment: a take-up can bring
    Y there only behind it."""
    two_way = "X_mm,EXX_um_fwd,EXX_um_rev,EYX_um_fwd,EYX_um_rev\n-500,0,0,0,12\n500,0,0,0,12\n"
    leaning = "[squareness]\nC0Y = 400\n" + backlash("X", 5) + backlash("Y", 5)
    across = "Y_mm,EXY_um_fwd,EXY_um_rev\n-500,0,12\n500,0,12\n"
    m = machine(tmp_path / "m", leaning, X=two_way, Y=across)
    circle = "G0 X0 Y0 Z0\nG1 X40 F500\nG91 G2 X0 Y0 I-19 J-3\nG90 G1 X3\nM2\n"
    verifier = verified(m, circle)
    assert m.lateral == 24 * UM and verifier.passed
    assert verifier.allowed < verifier.corrected.deviation < 12.1 * UM < verifier.let_pass


def test_where_no_axis_turns_back_what_a_reversal_would_move_is_not_let_pass(tmp_path):
    """X is 12 um aside where it comes in -, and goes on in +: an end that is 10 um aside is
    refused; where it has come back it would pass."""
    two_way = "X_mm,EXX_um_fwd,EXX_um_rev,EYX_um_fwd,EYX_um_rev\n-500,0,0,0,12\n500,0,0,0,12\n"
    m = machine(tmp_path / "m", backlash("X", 5), X=two_way)
    on, back = (f"G0 X0 Y0 Z0\nG1 X40 F500\nX{x}\nM2\n" for x in (80, 20))
    assert verified(m, on).passed and not verified(m, on, b"X80.0025", b"X80.0025 Y0.0100").passed
    verifier = verified(m, back, b"X19.9975", b"X19.9975 Y-0.0020")
    assert verifier.passed and verifier.corrected.deviation > verifier.allowed
    assert (
        f"(let pass, where slides turn back and by rounding: {verifier.let_pass / UM:.2f} um)"
        in (verifier.report())
    )


TURNING = "G90\nG0 X20. Z-10.\nG1 X40. F300\nX60. Z-30.\nX20. Z-12.\nG0 X50. Z-20.\nX30.\n"
PROGRAMS = {
    "example-lathe": "G0 X50. Z-20.\nG1 X120. Z-150. F100\nX60. Z-60.\nZ-20.\n",
    "example-mill": TURNING,
    "example-five-axis": "G0 A0 C0\n" + TURNING.replace("Z-", "Z"),
    "example-printer": "G28\n" + TURNING.replace("Z-", "Z"),
    "example-router": TURNING,
    "mv-1060": "G90\nG0 X-900. Y-500. Z-50.\nG1 X-100. F300\nX-700. Y-100. Z-400.\nX-950.\n",
    "studer-s36": (ROOT / "sample_programs" / "shaft.nc").read_text(),
    "studer-s36-thesis": (ROOT / "sample_programs" / "shaft.nc").read_text(),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_on_every_machine_the_uncorrected_program_would_be_refused(name):
    """Judged like its correction, which passes."""
    m = places.load(str(ROOT / "machines" / name))
    dialect = dialects.load(m.control)
    m = m.carrying(dialect.carried)
    filter_ = Filter(m, dialect, setup_of(m, {"G54": {}}, dict.fromkeys("XYZ", 0.0)))
    verifier = Verifier(filter_)
    filter_.feed(PROGRAMS[name].encode())
    filter_.finish()
    assert verifier.passed and verifier.uncorrected.rest > verifier.allowed, verifier.report()


def test_where_more_than_the_tolerance_is_left_the_line_says_what_is_let_pass(tmp_path):
    """The tolerance, half an increment, and one and a half of hysteresis."""
    m = machine(tmp_path / "m", backlash("X", 50))
    program = "G0 X0 Y0 Z0\nG1 X100 F500\nX50\nM2\n"
    said = " um (let pass, where slides turn back and by rounding: "
    assert said not in verified(m, program).report()
    verifier = verified(m, program, b"X49.9750", b"X49.9767")
    assert verifier.passed and f"{said}{verifier.allowed / UM:.2f} um); 3 motions" in (
        verifier.report()
    )
    assert not verified(m, program, b"X49.9750", b"X49.9950").passed


def test_where_no_place_is_known_it_says_that_nothing_was_compared(tmp_path):
    m = machine(tmp_path / "m", "", X=BENT)
    verifier = verified(m, "G1 X10 Y10 F500\nX50\nM2\n")
    assert verifier.report() == (
        "nothing: no place of the path is known in all of X Y Z, and none was compared (--start"
        " says where the program begins); 2 motions in, 2 out"
    )
    assert not verified_by(verifier).compared
    assert verified(m, "G0 Z0\nG1 X10 Y10 F500\nX50\n").report().startswith("largest deviation")


def test_a_block_behind_a_reversal_begins_in_its_own_direction(tmp_path):
    """A map turned round (a control that takes up 8 um too much), a circle whose X turns back where
    a block of the output begins: its first place has the side of the way ahead, not behind."""
    m = machine(tmp_path / "m", backlash("X", -8.0))
    _, verifier = corrected(m, "G0 X0 Y0 Z0\nG1 X40 F500\nG2 X40 Y0 I-20 J0\nM2\n")
    assert verifier.corrected.deviation < 0.1 * UM and verifier.corrected.slide < 0.1 * UM


def test_a_take_up_that_goes_too_far_is_off_along_the_path_too(tmp_path):
    """X turns at 40 mm with 20 um of play, and the take-up ends at 39.96 instead of 39.99: the tool
    stands 30 um ahead of the place where the path turns. By the direction last commanded, where
    take-ups do not count, nothing is off."""
    m = machine(tmp_path / "m", backlash("X", 20.0))
    program = "G0 X0 Y0 Z0\nG1 X40 F500\nX20\nM2\n"
    assert verified(m, program).corrected.slide < 0.1 * UM
    verifier = verified(m, program, b"X39.9900", b"X39.9600")
    assert abs(verifier.corrected.slide - 30 * UM) < 0.1 * UM
    assert verifier.corrected.deviation < 0.1 * UM


@pytest.mark.parametrize(
    ("dialect", "arc"),
    [
        ("grbl", "G1 X145.0 Y267.0 F500\nG3 X137.0 Y263.0 I-3.0 J-4.0\n"),
        ("fanuc-mill", "G1 X264.0 Y52.0 F500\nG3 X244.0 Y52.0 I-10.0 J0.0\n"),
    ],
)
def test_an_arc_in_coarse_increments_is_one_that_the_control_accepts(dialect, arc):
    """At 0.01 mm the rounded words of an arc may differ in radius by more than the control takes
    (GRBL: 0.005 mm, else error 33, in the middle of the job): lines come out instead."""
    m = mill("EXX", "EYX", "EXY", "EYY")
    coarse = {x: replace(axis, least_increment=0.01) for x, axis in m.axes.items()}
    m = replace(m, axes=coarse)
    start = dict.fromkeys("XYZ", 0.0)
    filter_ = Filter(m, dialects.load(dialect), setup_of(m, {"G54": {}}, start))
    verifier = Verifier(filter_)
    filter_.feed(f"G21 G90 G17\nG0 X0. Y0. Z0.\n{arc}".encode())
    filter_.finish()
    assert verifier.passed and verifier.corrected.deviation > 0


def test_every_piece_of_a_feed_counts(tmp_path):
    """Cut at two nodes, the end of the first piece 30 um aside: neither that piece nor the one
    behind it ends where the block does."""
    m = machine(tmp_path / "m", "", X="X_mm,EXX_um\n-400,0\n0,0\n30,20\n60,0\n100,20\n400,20\n")
    program = "G0 X0 Y0 Z0\nG1 X100 F500\nM2\n"
    assert verified(m, program).passed
    verifier = verified(m, program, b"X30.0000", b"X30.0000 Y0.0300")
    assert abs(verifier.corrected.deviation - 30 * UM) < 0.1 * UM and not verifier.passed


def on_helix(actual, t: float) -> float:
    """mm of a place from a helix of 10 mm around the origin, 1 rad from X = 10 mm, Z0 to Z5."""
    one = np.ones(1)
    arcs = SimpleNamespace(
        first=np.array([0]), second=np.array([1]), centre=np.zeros((2, 1)), angle=0 * one,
        sweep=one, radius=10 * one, radius_end=10 * one,
    )  # fmt: skip
    start, target = np.array([[10.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [5.0]])
    found = _from_arc(
        cast(Any, SimpleNamespace(corrected=(0, 1, 2))), cast(Any, SimpleNamespace(arcs=arcs)),
        np.array([0]), np.array([t]), np.array(actual)[:, None], start, target,
    )  # fmt: skip
    return float(found[0])


def test_beside_an_arc_is_across_it_in_and_out_of_its_plane():
    """Half way: 10 um outwards; 10 um above, of which the part across the helix counts, 10 mm/rad
    against 5. Behind its end nothing is off along its own direction."""
    c, s = math.cos(0.5), math.sin(0.5)
    assert on_helix([10 * c, 10 * s, 2.5], 0.5) == pytest.approx(0.0, abs=1e-9)
    assert on_helix([10.01 * c, 10.01 * s, 2.5], 0.5) == pytest.approx(0.01)
    assert on_helix([10 * c, 10 * s, 2.51], 0.5) == pytest.approx(0.01 * 10 / math.hypot(10, 5))
    ahead = 1.001
    place = [10 * math.cos(ahead), 10 * math.sin(ahead), 5 * ahead]
    assert on_helix(place, 1.0) == pytest.approx(0.0, abs=1e-6)


def test_at_its_end_an_arc_has_the_direction_in_which_it_came():
    """A quarter about the origin with the clock, to its top: X and Y go up all the way, and behind
    it both have that side."""
    way = Way(
        0, np.array([-10.0, 0.0]), np.array([0.0, 10.0]), (0, 1), (0.0, 0.0), sweep=-np.pi / 2
    )
    contour = SimpleNamespace(approach=np.zeros(2))
    judge = SimpleNamespace(at_work=None, directed=True)
    side = CentreVerifier._approach(
        cast(Any, judge), cast(Any, contour), way, np.array([0.0, 0.5, 1.0])
    )
    assert side.tolist() == [[1.0] * 3] * 2 and contour.approach.tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    "program",
    [
        # X goes back by 0.6 um, which says no side (8.6 um were left)
        "G0 X260. Z390.27\nG1 X259.9988 Z180. F100\n",
        # it goes on by 0.05 um, and its command back by 1 um (9.9 um)
        "G0 X117.126 Z311.4139\nG1 X117.1261 Z368.9353 F100\n",
        # the command of the rapid goes back by 2 um where Z goes on (4.7 um)
        "G0 X33.378 Z335.3929\nG1 Z335.805 F100\nG0 Z212.7734\nG1 Z212.7739\n"
        "G0 X31.6171 Z212.7754\nG1 X45.9351 Z212.7761\n",
        # Z turns, which takes X back by all that it goes on by, and an increment more (9.7 um)
        "G0 X233.29 Z292.2616\nX218.6495 Z303.9184\nG1 X218.645 Z245.9643 F100\n",
    ],
)
def test_where_forward_lies_beyond_reverse_a_feed_begins_on_its_side(program):
    """On the S-36 the sides of X lie up to 9.8 um apart the other way round: it is led beyond the
    place where a block begins, and back, where the block does not say the side by itself."""
    m = places.load(str(ROOT / "machines" / "studer-s36"))
    dialect = dialects.load(m.control)
    m = m.carrying(dialect.carried)
    filter_ = Filter(m, dialect, setup_of(m, {"G54": {}}))
    verifier = Verifier(filter_)
    filter_.feed(b"G21 G90\n" + program.encode() + b"M2\n")
    filter_.finish()
    assert verifier.passed and verifier.corrected.deviation < 1.0 * UM, verifier.report()


def test_where_forward_lies_beyond_reverse_a_turn_in_a_rapid_is_let_pass_and_said():
    """X of the S-36 goes back by 0.15 um, and the sides lie 9.8 um apart the other way round: no
    motion takes that up in a rapid."""
    m = places.load(str(ROOT / "machines" / "studer-s36"))
    filter_ = Filter(m, dialects.load(m.control), setup_of(m, {"G54": {}}))
    verifier = Verifier(filter_)
    filter_.feed(b"G21 G90\nG0 X160. Z313.2\nG1 X160.0021 Z313.2004 F100\nG0 X160.0018\nM2\n")
    filter_.finish()
    assert verifier.passed and verifier.corrected.deviation > verifier.allowed
    assert "let pass, where slides turn back" in verifier.report()


@pytest.mark.parametrize(
    "program",
    [
        # X goes back by 1.66 um and turns Z, which turns X on again (1.8 um left with lost motion)
        "G0 X0.8441\nZ3.808305\nG1 X58.96651 Z96.7946 F100\nX172.720506\nG0 X172.717188\n",
        # of neither axis is known on which side it bears where both move by micrometres (4.5 um)
        "G0 X339.998\nG1 Z219.0030 F100\nG0 X340.000 Z218.9989\n",
    ],
)
def test_a_turn_of_a_slide_that_lags_in_a_rapid_of_micrometres_is_let_pass(tmp_path, program):
    """It was refused as an error of gcomp: nothing is cut at the end of a rapid, and the next feed
    begins on its side."""
    m = places.load(str(write_lagging(ROOT / "machines" / "studer-s36", tmp_path / "m")))
    filter_ = Filter(m, dialects.load(m.control), setup_of(m, {"G54": {}}))
    verifier = Verifier(filter_)
    filter_.feed(b"G21 G90\n" + program.encode() + b"M2\n")
    filter_.finish()
    assert verifier.passed and verifier.corrected.deviation > verifier.allowed, verifier.report()


def test_where_forward_lies_beyond_reverse_the_last_command_says_the_side():
    """X is led beyond, and back to its place; 0.2 um forward again, and it stands 10 um away."""
    m = places.load(str(ROOT / "machines" / "studer-s36"))
    filter_ = Filter(m, dialects.load(m.control), setup_of(m, {"G54": {}}))
    verifier, old = Verifier(filter_), b"Z140.0002"

    def damaged(words, motions, pieces, output, line):
        verifier.check(words, motions, pieces, output.replace(old, old + b" X60.0025"), line)

    filter_.watchers[:] = [damaged]
    filter_.feed(b"G21 G90\nG0 X40. Z100.\nG1 X60. F100\nZ140.\nM2\n")
    filter_.finish()
    assert 9 * UM < verifier.corrected.deviation < 11 * UM, verifier.report()


@pytest.mark.parametrize("wrong", [b"C35", b"C30.002", b"C-30"])
def test_a_rotary_axis_that_is_sent_elsewhere_is_an_error(wrong):
    """Nothing corrects C, so no distance from the path tells of it: 5 degrees passed."""
    m = read_machine(ROOT / "machines" / "example-five-axis")
    program = "G21 G90 G54\nG0 X0 Y0 Z0 A0 C0\nG1 X20 C10 F500\nX40 C30\nX41 C40\nM2\n"
    assert verified(m, program, b"C30", b"C30.000").passed
    with pytest.raises(GcompError, match=f":4: the output sends C to {wrong.decode()[1:]}, and"):
        verified(m, program, b"C30", wrong)


@pytest.mark.parametrize("reversal", ["off", "ramp"])
def test_a_spread_reversal_lets_no_more_pass_than_the_reversal(tmp_path, reversal):
    """5 um of backlash, and a place 1 mm off: it passed, as these modes were only measured."""
    m = machine(tmp_path / "m", backlash("X", 5), X=BENT)
    program = "G0 X0 Y0 Z0\nG1 X50 F500\nX100\nX20\nM2\n"
    assert verified(m, program, reversal=reversal).passed
    for wrong in (b"X101.0000", b"X100.0100"):
        verifier = verified(m, program, b"X100.0025", wrong, reversal=reversal)
        assert not verifier.passed and verifier.let_pass < 7.1 * UM


@pytest.mark.parametrize("on", ["G41 D1", "G41.1 D6"])
def test_at_a_contour_whose_centre_is_not_followed_it_must_not_get_worse(tmp_path, on):
    """Where the radius or the place of an axis is not known: 1 mm off passed. The map is off by up
    to 106 um there."""
    m = machine(tmp_path / "m", "[squareness]\nC0Y = 300\n", X="X_mm,EXX_um\n-500,0\n500,200\n")
    program = f"G0 X-20 Y-20 Z0\n{on}\nG1 X0 Y0 F500\nY30\nX30\nY0\nX0\nG40 G1 X-20 Y-20\nM2\n"
    right = b"Y0X29.8940" if on == "G41 D1" else b"Y0X29.8934"
    assert verified(m, program).passed and verified(m, program, right, right).passed
    wrong = verified(m, program, right, b"Y0X30.9000")
    assert not wrong.passed and 0.1 < wrong.as_written.deviation < wrong.at_contour.deviation
