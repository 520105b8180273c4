"""Which side of its play a slide bears on, and what is commanded for it: laws of the scan, and
programs worked out by hand."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.compensate import Options, sides, turning
from postproc.compensate.approach import FAR, FEW, Sides, bear, initial, resting, scan
from postproc.compensate.turning import _pivots
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.tip import TipMachine
from postproc.nc import dialects
from postproc.units import TICKS_PER_MM, UM
from postproc.verify import Verifier
from tests.small_machines import write_lagging

ROOT = Path(__file__).resolve().parents[1]
TICKS_PER_UM = round(TICKS_PER_MM * UM)


def machine(folder: Path, more: str, **tables: str):
    """`perfect` with what is written behind its machine.toml, and with other tables."""
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    with open(folder / "machine.toml", "a") as file:
        file.write("\n" + more)
    for letter, text in tables.items():
        (folder / f"{letter}.csv").write_text(text)
    return read_machine(folder)


def backlash(axis: str, size_um: float) -> str:
    return f'[[effect]]\nname = "backlash"\naxis = "{axis}"\nsize_um = {size_um}\n'


def corrected(m, text: str, pieces: int = 1, **options) -> tuple[list[dict[str, float]], Verifier]:
    """The axis words of every block that comes out, and the verifier."""
    filter_ = Filter(m, dialects.load("linuxcnc"), setup_of(m), Options(**options))
    verifier = Verifier(filter_)
    cuts = [len(text) * k // pieces for k in range(pieces + 1)]
    out = b"".join(filter_.feed(text[a:b].encode()) for a, b in zip(cuts, cuts[1:], strict=False))
    out += filter_.finish()
    blocks = [
        dict(re.findall(r"([XYZ])(-?[\d.]+)", re.sub(r"\(.*\)", "", line)))
        for line in out.decode().split("\n")
    ]
    return [{x: float(v) for x, v in b.items()} for b in blocks if b], verifier


# -- the play operator -----------------------------------------------------------------------------


def one_by_one(place, half, begin):
    """The operator as the textbook has it, a place at a time."""
    r, side, found = begin, 0, []
    for w in place:
        now = min(max(r, w - half), w + half)
        side = (now > r) - (now < r) or side
        r = now
        found.append((side, r))
    return found


places = st.lists(st.integers(-(10**12), 10**12), min_size=1, max_size=60)


@given(place=places, half=st.integers(0, 10**11), cut=st.integers(0, 60))
@settings(deadline=None, max_examples=200)
def test_the_scan_is_the_operator_and_may_be_cut_anywhere(place, half, cut):
    def run(part, carry):
        w = np.array([part], np.int64)
        no = np.zeros(w.shape, bool)
        return bear(w, np.array([2 * half]), np.zeros_like(w), no, no, carry)

    first = initial(1)
    side, middle = run(place, first)
    assert list(zip(side[0].tolist(), middle[0].tolist(), strict=True)) == one_by_one(
        place, half, 0
    )
    cut = min(cut, len(place) - 1)
    if cut:
        one = run(place[:cut], first)
        carry = Sides(one[0][:, -1], one[1][:, -1], first.taken, np.array([True]))
        two = run(place[cut:], carry)
        assert np.array_equal(np.concatenate([one[0], two[0]], axis=1), side)
        assert np.array_equal(np.concatenate([one[1], two[1]], axis=1), middle)


@pytest.mark.parametrize("number", [FEW, 400])
@pytest.mark.parametrize("hold", [3, 40])
def test_an_axis_rests_where_it_was_left_as_one_place_after_the_other_says(number, hold):
    """Many strokes are settled without a look at the ones before, a few one by one; an own place
    may lie beyond what is held."""
    rng = np.random.default_rng(number + hold)
    own = rng.integers(-20, 20, number).cumsum()
    low = own - rng.integers(-2, hold, number)
    high = low + rng.integers(0, 2 * hold, number)
    start, goes_on = own + rng.integers(-9, 9, number), rng.random(number) < 0.9
    goes_on[0] = False
    here, found = 0, []
    for k in range(number):
        here = here if goes_on[k] else start[k]
        here = here if low[k] <= here <= high[k] else own[k]
        found.append(here)
    assert resting(goes_on, start, own, low.astype(float), high.astype(float)).tolist() == found
    assert number > sum(own == found) > 0


@given(
    st.lists(st.tuples(st.integers(-100, 100), st.integers(0, 50)), min_size=1, max_size=40),
    st.integers(-200, 200),
)
def test_clamps_compose_into_clamps(clamps, carry):
    low = np.array([[a for a, _ in clamps]], np.int64)
    high = low + np.array([[b for _, b in clamps]], np.int64)
    state, found = carry, []
    for a, b in zip(low[0].tolist(), high[0].tolist(), strict=True):
        state = min(max(state, a), b)
        found.append(state)
    assert scan(low, high, np.array([carry]))[0].tolist() == found


def test_a_slide_that_is_not_moved_keeps_its_side():
    w = np.array([[10, -500, 20]], np.int64)
    stays = np.array([[False, True, False]])
    side, middle = bear(w, np.array([4]), 0 * w, np.zeros(w.shape, bool), stays, initial(1))
    assert side.tolist() == [[1, 1, 1]] and middle.tolist() == [[8, 8, 18]]
    assert FAR > 10**18


def test_turning_places_are_those_behind_which_it_turns_back_far_enough():
    """Up 5, down 3, up 1 (too little to count against 2), down 4, up 6: pivots at the top and at
    the bottom. Back by 2 is not by more than 2."""
    course = np.array([0, 5, 2, 3, -1, 5])
    assert _pivots(course.tolist(), 0, 2.0) == [1, 4]
    assert _pivots([0, 1, -4], 0, 3.0) == [], "it has not gone up before by half as much"
    assert _pivots([0, 4, 2, 6], 0, 2.0) == _pivots([0, -4, -2, -6], 0, 2.0) == []


def test_the_side_of_a_stroke_by_itself_is_that_of_its_last_turn():
    """A play of 4: out of the middle by 10, but it stays; within the play; out and back, of which
    the way out counts where a begin is told; and where the side is given."""
    course = SimpleNamespace(
        band=np.array([4]),
        begin=np.array([[sides.NOWHERE] * 3 + [10, sides.NOWHERE, sides.NOWHERE]], np.int64),
        end=np.array([[10, 10, 1, 7, -10, 10]]),
        stays=np.array([[False, True, False, False, False, False]]),
        given=np.array([[False] * 5 + [True]]),
        sense=np.array([[0, 0, 0, 0, 0, -1]]),
        anew=np.zeros((1, 6), bool),
    )
    before, middle = np.full((1, 6), -1), np.zeros((1, 6), np.int64)
    before[0, 4] = 1
    found = sides.Course.once(course, np.arange(6), before, middle)
    assert found.tolist() == [[1, -1, -1, 1, -1, -1]]
    # the fifth goes on from where something else took it: 1 beyond its end, within the play
    course.anew, course.start = (np.arange(6) == 4)[None], np.full((1, 6), -9)
    assert sides.Course.once(course, np.arange(6), before, middle).tolist() == [
        [1, -1, -1, 1, 0, -1]
    ]


def test_a_slide_behind_the_tip_has_no_side_where_it_came_from_nowhere(monkeypatch):
    """Nor where its stroke ends nowhere, nor behind a jump."""
    monkeypatch.setattr(sides, "commands", lambda b, at, t, nominal, weight: nominal)
    machine = Mock(spec=TipMachine)
    machine.slides, machine.two_way = (lambda place: place), np.array([True])
    ends = np.arange(10.0, 70.0, 10.0)[None]
    b = SimpleNamespace(
        machine=machine,
        known=np.array([True, False, True, True, True, True]),
        known_before=np.array([True, True, False, True, True, True]),
        jumps=np.array([[False] * 4 + [True, False]]),
        motion=np.arange(6),
        travel=np.zeros((1, 6), np.int64),
        begin_nominal=ends - 10,
        end_nominal=ends,
        t1=np.ones(6),
        c=SimpleNamespace(band=np.array([4])),
        carry=SimpleNamespace(sides=initial(1)),
    )
    side, after = sides.of_slides(b)
    assert side.tolist() == [[1, 0, 0, 1, 0, 1]]
    assert after.side.tolist() == [1] and after.located.all()


def test_a_way_back_as_long_as_the_hysteresis_does_not_turn_a_slide():
    """From where it turned the window comes to its other end, and carries nothing yet: 2 ticks
    are the hysteresis, 3 turn. What stays where it is is not turned; a hole says its side."""
    course = sides.Course.__new__(sides.Course)
    course.travel = np.array([[2, 3, -2, -3, 3, -2]])
    course.band = np.array([2])
    course.stays = np.array([[False, False, False, False, True, False]])
    course.given, course.sense = np.zeros((1, 6), bool), np.zeros((1, 6), np.int64)
    course.given[0, 5], course.sense[0, 5] = True, 1
    sign, leads = course.leads
    assert leads[0].tolist() == [False, True, False, True, False, True]
    assert sign[leads].tolist() == [1, -1, 1]
    place = np.array([[10, 8, 7]])
    no = np.zeros(place.shape, bool)
    side, _ = bear(place, course.band, np.zeros_like(place), no, no, initial(1))
    assert side[0].tolist() == [1, 1, -1]


# -- by hand ---------------------------------------------------------------------------------------

LEANING = "G21 G90\nG0 X0 Y0 Z5\nG1 Z-1 F300\nG1 X100 F800\nG1 X20\nG1 Y100\nM2\n"


def test_a_slide_that_corrections_alone_turn_is_taken_over_its_play(tmp_path):
    """Y leans by 400 urad: X must go 40 um in + while Y goes 100 mm, with 40 um of play, and has
    come in -."""
    m = machine(tmp_path / "m", "[squareness]\nC0Y = 400\n" + backlash("X", 40.0))
    blocks, verifier = corrected(m, LEANING)
    assert [b.get("X") for b in blocks[2:]] == [0.02, 100.02, 99.98, 19.98, 20.02, 20.06]
    assert blocks[-2:] == [{"X": 20.02, "Y": 0.0}, {"X": 20.06, "Y": 100.0}]
    assert verifier.corrected.slide < 0.01 * UM


def test_what_turns_back_within_the_hysteresis_is_held(tmp_path):
    """The straightness of X takes Y 0.8 um up and down again: it is taken up at first (the side
    before is unknown), and then held at the top. With a hysteresis of 0.4 um its 12 um of play
    are taken up where it turns."""
    table = "X_mm,EYX_um\n-400,0\n0,0\n50,-0.8\n100,0\n400,0\n"
    text = "G0 X0 Y0 Z0\nG1 Y1 F500\nX100\nX120\nM2\n"
    m = machine(tmp_path / "m", backlash("Y", 12.0), X=table)
    calm, verifier = corrected(m, text)
    assert [b["Y"] for b in calm if "Y" in b] == [0.0, 0.006, 1.006, 1.0068]
    assert verifier.corrected.slide == pytest.approx(0.8 * UM, abs=0.06 * UM)
    keen, verifier = corrected(m, text, hysteresis=0.4 * UM)
    assert [b["Y"] for b in keen if "Y" in b] == [0.0, 0.006, 1.006, 1.0068, 0.9948, 0.994]
    assert verifier.corrected.slide < 0.2 * UM


def test_a_resting_slide_is_looked_at_along_all_of_an_arc(tmp_path, monkeypatch):
    """At equal parts, both ends of the arc among them: Z follows the straightness of X, and may
    turn anywhere."""
    looks, on_arcs = [], turning._on_arcs

    def seen(b, chosen, most, least):
        looks.append((chosen, *on_arcs(b, chosen, most, least)))
        return looks[-1][1:]

    monkeypatch.setattr(turning, "_on_arcs", seen)
    table = "X_mm,EZX_um\n-400,0\n0,0\n50,-8\n100,0\n400,0\n"
    m = machine(tmp_path / "m", backlash("Z", 12.0), X=table)
    corrected(m, "G17 G0 X0 Y0 Z0\nG1 Z-1 F500\nG2 X100 I50\nG3 X50 Y50 J50\nM2\n")
    arcs = [
        (t[owner == k], place[:, owner == k]) for found, owner, t, place in looks for k in found
    ]
    assert len(arcs) == 2
    for (t, place), end in zip(arcs, ([100, 0, -1], [50, 50, -1]), strict=True):
        assert 9 <= len(t) <= 65 and (t == np.linspace(0, 1, len(t))).all()
        assert place[:3, -1] == pytest.approx(end)


def test_a_small_take_up_is_left_out_where_the_tolerance_allows(tmp_path):
    """An eighth of 5 um is kept for what follows, and three axes share the rest: 2.53 um each."""
    m = machine(tmp_path / "m", backlash("X", 2.4))
    text = "G0 X0 Y0\nG1 X10 F500\nX0\nX10\n"
    fine, coarse = (corrected(m, text, tolerance=t)[0] for t in (0.5 * UM, 5 * UM))
    assert len(fine) == 7 and len(coarse) == 4


def test_the_side_before_an_axis_has_moved_is_nobodys(tmp_path):
    m = machine(tmp_path / "m", backlash("X", 10.0))
    blocks, _ = corrected(m, "G0 X0 Y0\nG1 Y10 F500\nX5\n")
    assert blocks[:2] == [{"X": 0.0, "Y": 0.0}, {"Y": 10.0}], "the mean of both directions"
    assert blocks[2:] == [{"X": 0.005}, {"X": 5.005}]


def test_a_block_that_goes_nowhere_turns_nothing(tmp_path):
    m = machine(
        tmp_path / "m", "[squareness]\nC0Y = 400\n" + backlash("X", 40.0) + backlash("Y", 40.0)
    )
    text = "G0 X0 Y0\nG1 X50 F500\nX20\nY30\n"
    assert len(corrected(m, text + "X20 Y30\n" * 3)[0]) == len(corrected(m, text)[0]) + 3


def test_a_move_in_machine_coordinates_to_the_same_place_is_one(tmp_path):
    """G53 leaves Z uncorrected, 7 um beside: the feed behind it takes it back."""
    m = machine(tmp_path / "m", backlash("Z", 4.0), X="X_mm,EZX_um\n0,-7\n100,-7\n")
    blocks, _ = corrected(m, "G0 X10 Y0 Z0\nG53 G0 Z0\nG1 Y5 F500\n")
    assert blocks[0]["Z"] == 0.007 and blocks[2]["Z"] == 0.009


@pytest.mark.parametrize("mode", ["step", "ramp", "off", "mean"])
def test_any_cut_gives_the_same(tmp_path, mode):
    m = machine(
        tmp_path / "m", "[squareness]\nC0Y = 400\n" + backlash("X", 12.0) + backlash("Y", 40.0)
    )
    text = LEANING.replace(
        "M2", "G2 X40 Y100 I10 J5\nG1 X39.999\nX40\nY3\nX38 Y3.001\nG0 X0 Y0\nG1 Y-40\nM2"
    )
    whole = corrected(m, text, reversal=mode)[0]
    assert all(
        corrected(m, text, pieces, reversal=mode)[0] == whole for pieces in (2, 3, 7, 29, len(text))
    )


def test_a_map_turned_round_is_led_beyond_and_back(tmp_path):
    """Forward beyond reverse by 8 um (a control that takes up too much): where X rests, its side is
    the direction of the last command, so that it is led past its place and comes back in the
    direction that is wanted."""
    m = machine(tmp_path / "m", "[squareness]\nC0Y = -400\n" + backlash("X", -8.0))
    blocks, verifier = corrected(m, LEANING.replace("G1 X20\n", ""))
    last = [b["X"] for b in blocks if "X" in b][-4:]
    assert last == [
        99.996,
        100.0061,
        100.004,
        99.964,
    ], "beyond by twice the hysteresis and an increment, back, and on"
    assert verifier.corrected.deviation < 0.1 * UM


def test_a_map_turned_round_is_not_led_about_in_rapids(tmp_path):
    """Y leans by 400 urad, and X, which rests in the rapid, is wanted 40 um beside its place there:
    the rapid takes it there, since nothing must keep it on one side, and its side stays what the
    feed before it left. A feed along X alone says its own side."""
    m = machine(tmp_path / "m", "[squareness]\nC0Y = -400\n" + backlash("X", -8.0))
    text = "G21 G90\nG0 X0 Y0 Z5\nG1 Z-1 F300\nG1 X100 F800\nG0 Y100\nG1 X110\nG0 Y0\nG1 X90\nM2\n"
    blocks, verifier = corrected(m, text)
    assert [b["X"] for b in blocks[2:]] == [99.996, 99.956, 109.956, 109.996, 90.004]
    assert verifier.corrected.deviation < 0.1 * UM


@pytest.mark.parametrize("mode", ["ramp", "off"])
def test_a_reversal_that_is_spread_by_choice_is_measured_and_passes(tmp_path, mode):
    """12 um of lost motion spread over the next block leave more than the tolerance there, as was
    asked for: the figure says so, and the verification does not fail."""
    m = machine(tmp_path / "m", backlash("X", 12.0))
    _, verifier = corrected(m, "G0 X0 Y0 Z0\nG1 X40 Y40 F500\nX0 Y80\nM2\n", reversal=mode)
    assert verifier.corrected.deviation > verifier.allowed and verifier.passed


def test_a_last_block_without_a_line_end_is_written_before_what_follows_it(tmp_path):
    """Its new word and its further blocks stand at one place, the end of the text: the word belongs
    to the block, as where a line end follows."""
    m = machine(tmp_path / "m", "[squareness]\nC0Y = 400\n" + backlash("X", 40.0))
    ended = LEANING.replace("M2\n", "")
    assert corrected(m, ended.rstrip("\n"))[0] == corrected(m, ended)[0]
    assert corrected(m, ended.rstrip("\n"))[0][-2:] == [
        {"X": 20.02, "Y": 0.0},
        {"X": 20.06, "Y": 100.0},
    ]


def test_a_number_of_more_than_nine_decimals_is_cut_as_one_of_nine(tmp_path):
    """A CAM program writes X20.123456789012: every block that it becomes has nine decimals, a
    picometre, and the place is the same."""
    m = machine(tmp_path / "m", "", X="X_mm,EYX_um\n-400,0\n0,0\n10,40\n20,0\n400,0\n")
    text = "G0 X0 Y0 Z0\nG1 X20.123456789{0} Y5.123456789{0} F100\nM2\n"
    assert corrected(m, text.format("012"))[0] == corrected(m, text.format(""))[0]
    assert corrected(m, text.format("012"))[0][-1] == {"X": 20.123456789, "Y": 5.123456789}


def test_a_motion_is_divided_once_where_its_slides_turn_together(monkeypatch):
    """Two turns at the middle, one of them a rounding later, and one at three quarters."""
    at = (np.array([0, 0]), np.array([0.5, 0.75])), (np.array([0]), np.array([0.5 + 1e-12]))
    monkeypatch.setattr(turning, "_quadrants", lambda b: at[0])
    monkeypatch.setattr(turning, "_induced", lambda b: [at[1]])
    whole = SimpleNamespace(machine=None, motion=np.array([0]), t0=np.zeros(1), t1=np.ones(1))
    motion, t0, t1 = turning.divided(whole)
    assert motion.tolist() == [0, 0, 0]
    assert t0.tolist() == [0.0, 0.5, 0.75] and t1.tolist() == [0.5, 0.75, 1.0]


@pytest.mark.parametrize("turns", ["", "P2", "P3"])
@pytest.mark.parametrize("way", ["G2 X40 Y-20 I0 J-20", "G3 X0 Y-20 I0 J-20"])
def test_an_arc_of_several_turns_turns_back_in_each(tmp_path, turns, way):
    """From a quadrant to another one: the first time round it passes the place where it ends, and
    turns back there like elsewhere (it was led straight on, 20 mm aside)."""
    m = machine(tmp_path / "m", backlash("X", 6.0) + backlash("Y", 6.0))
    _, verifier = corrected(m, f"G0 X0 Y0 Z0\nG1 X20 F500\n{way} {turns}\nG1 X60\nM2\n", 3)
    assert verifier.passed and verifier.corrected.slide < 1.5 * UM


TAKEN_BACK = "G1 Z30 X80.6803 F100\nG0 X150.8988\nX169.86 G1 Z168.404 F250\nX138.0329 Z162.4977\n"


@pytest.mark.parametrize("fed", [[TAKEN_BACK], TAKEN_BACK.splitlines(keepends=True)])
def test_a_slide_that_another_one_takes_back_is_led_beyond_and_back(tmp_path, fed):
    """Z turns where the third block begins, and its straightness takes X back by 3.9 um, which goes
    on: X is led over its play of 9.7 um and back (3.8 um were left there, and faded along it)."""
    m = read_machine(write_lagging(ROOT / "machines" / "studer-s36", tmp_path / "m"))
    filter_ = Filter(m, dialects.load("fanuc-lathe"), setup_of(m))
    verifier = Verifier(filter_)
    out = b"".join([filter_.feed(text.encode()) for text in fed] + [filter_.finish()]).decode()
    assert "\nX150.8784 G1 Z29.9990 F250\nX150.8979\nX155." in out
    assert verifier.passed and verifier.corrected.slide < 1.0 * UM


def on_lathe(m, text: str) -> tuple[str, Verifier]:
    """What comes out on a lathe, and the verifier."""
    filter_ = Filter(m, dialects.load("fanuc-lathe"), setup_of(m))
    verifier = Verifier(filter_)
    return (filter_.feed(text.encode()) + filter_.finish()).decode(), verifier


def test_an_axis_that_moves_on_waits_for_its_place_instead_of_going_back():
    """Z turns, and takes X back by 2.5 um, which goes on: moved back it would say its other side.
    It waits along 7 um of the way (the 2.5 um faded along 1.7 mm)."""
    m = read_machine(ROOT / "machines" / "studer-s36")
    program = "G0 X316.5 Z14.\nG1 X316.5523 Z39.6929 F100\nG0 Z39.6907\nG1 X339. Z50.7566\nM2\n"
    out, verifier = on_lathe(m, program)
    assert "\nG1 X316.5138 Z39.6414\nZ39.6449\nX320.0000" in out
    assert verifier.passed


def test_a_slide_is_led_over_its_play_only_where_it_would_be_beside_its_way(tmp_path):
    """X turns, and takes Y back by 6 um, which goes on: that is beside the way where the block goes
    along X, and on it where the block goes along Y."""
    two_way = "X_mm,EXX_um_fwd,EXX_um_rev,EYX_um_fwd,EYX_um_rev\n-400,0,9,0,6\n400,0,9,0,6\n"
    m = machine(tmp_path / "m", backlash("Y", 9), X=two_way)
    turns = "G0 X0 Y0 Z0\nG1 X9 Y20 F500\n{}\nM2\n"
    beside, verifier = corrected(m, turns.format("X-11 Y20.01"))
    assert [block.get("Y") for block in beside[2:]] == [20.0045, 19.9895, 19.9985, 20.0085]
    assert verifier.corrected.slide < 0.5 * UM
    assert [block.get("Y") for block in corrected(m, turns.format("X8.99 Y40"))[0][3:]] == [
        20.0045,
        39.9985,
    ]


def test_no_axis_is_led_beyond_its_travel(tmp_path):
    """X, of which forward lies 11 um beyond reverse, rests 1 um before the end of its travel, and
    Y's straightness turns it back: led by 2.1 um it would say its side."""
    rising = "Y_mm,EXY_um\n-400,-80\n400,80\n"
    beyond = "X_mm,EXX_um_fwd,EXX_um_rev\n-500,12,1\n500,12,1\n"
    machine(tmp_path / "m", "", X=beyond, Y=rising)
    text = (tmp_path / "m" / "machine.toml").read_text()
    ended = text.replace("[axes.X]\ntravel = [-10000.0, 10000.0]", "[axes.X]\ntravel = [-500, 500]")
    (tmp_path / "m" / "machine.toml").write_text(ended)
    m = read_machine(tmp_path / "m")
    for place, led in ((499.0, 499.0011), (500.0, 499.999)):
        blocks, _ = corrected(m, f"G0 X0 Y0 Z0\nG1 X{place} F500\nY100\nM2\n")
        assert max(block.get("X", 0.0) for block in blocks) == led


@pytest.mark.parametrize("lags", [False, True])
def test_an_axis_that_rests_along_a_thread_keeps_its_side_or_is_led_to_it(tmp_path, lags):
    """Z's straightness asks X to turn along the thread. Nothing is put in before one that does not
    name its code: turned along the way X was 9.85 um off on the S-36 (4.84 uncorrected)."""
    folder = ROOT / "machines" / "studer-s36"
    m = read_machine(write_lagging(folder, tmp_path / "m") if lags else folder)
    text = "G21 G90\nG0 X70. Z200.\nX60.0\nG32{}Z150.0 F1.5\nM2\n"
    out, verifier = on_lathe(m, text.format("\n"))
    assert verifier.passed, verifier.report()
    largest = max(verifier.corrected.deviation, verifier.corrected.slide)
    assert largest < 2.1 * UM < verifier.uncorrected.deviation
    assert "\nG32\nZ180.0000 F1.5\nZ1" in out  # and not a word of X
    out, verifier = on_lathe(m, text.format(" "))
    assert verifier.corrected.deviation < 0.5 * UM
    assert "\nG0 Z" in out and "\nG32 Z180.0000 F1.5\nX" in out


@pytest.mark.parametrize(
    "program",
    [
        # X goes on by 0.04 um, and Z turns, which takes X back by 2.5 um (5.5 um along all of it)
        "G0 X240. Z50.\nG1 X278. Z40. F100\nX263.2 Z27.3\nG0 X288.833\nG1 X288.832924 Z112.7\n",
        # Z goes on by 1.02 um, and X turns, which takes Z back by 6.6 um (4.4 um behind it too)
        "G0 X89.24 Z357.8802\nG1 X249.671 Z357.8792 F100\nX305.50484\nZ357.88022\nX305.410748\n",
    ],
)
def test_an_axis_that_hardly_goes_on_is_led_to_its_side(tmp_path, program):
    m = read_machine(write_lagging(ROOT / "machines" / "studer-s36", tmp_path / "m"))
    _, verifier = on_lathe(m, program)
    assert verifier.passed and verifier.corrected.deviation < 0.5 * UM, verifier.report()


def test_an_arc_says_the_side_by_its_last_way_however_short():
    """It goes 0.3 um up from its lowest X, less than the hysteresis, to which its corrected end is
    held: the S-36 takes that for the side, and X is led back to the other one (9.8 um along all of
    the feed behind)."""
    m = read_machine(ROOT / "machines" / "studer-s36")
    arc = "G0 X80. Z170.\nG1 X73.44 Z181.515 F100\nG3 X72.8806 Z182.0183 R0.56\nG1 Z390.\nM2\n"
    out, _ = on_lathe(m, arc)
    assert "\nX72.8802 Z182.0185 R0.56\nG1 Z182.0185 X72.8843\nX72.8802\nZ210" in out
