"""A reversal that builds up with the way after a turn is taken up over that way, not at the
turn."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

from postproc.compensate import Compensator, Options
from postproc.effects import State, windup
from postproc.machine.file import read_machine
from postproc.units import TICKS_PER_MM, UM
from tests.test_lost_motion import backlash
from tests.test_lost_motion import machine as bent_machine
from tests.test_verify import verified

ROOT = Path(__file__).parent.parent
WINDUP = '[[effect]]\nname = "windup"\naxis = "X"\nsize_um = {}\nlength_mm = 0.2\n'


def machine(tmp_path, size_um: float, stated: str = ""):
    folder = tmp_path / f"m{size_um:g}"
    shutil.copytree(ROOT / "machines" / "studer-s36", folder)
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(stated + text + "\n" + WINDUP.format(size_um))
    return read_machine(folder)


def test_the_largest_reversal_of_an_axis_says_how_it_is_taken_up(tmp_path):
    """The S-36's tables of X differ by up to 9.8 um: a windup of 30 um is larger, one of 2 um is
    not."""
    large, small = machine(tmp_path, 30.0), machine(tmp_path, 2.0)
    assert large.pretravel == {"X": approx(0.6)} and small.pretravel == {}
    x, z = Compensator(large).reach / TICKS_PER_MM
    assert x == approx(0.3) and z == 0.0, "half of it to either side; Z is taken up at the turn"
    assert not Compensator(small).reach.any()


def test_a_ramp_that_is_asked_for_is_for_every_axis(tmp_path):
    wound = machine(tmp_path, 30.0)
    both = Compensator(wound, Options(reversal="ramp", ramp=2.0)).reach
    assert (both / TICKS_PER_MM == 1.0).all()
    own = Compensator(wound, Options(reversal="ramp")).reach
    assert own[0] / TICKS_PER_MM == approx(0.3) and own[1] / TICKS_PER_MM == approx(0.25)


def test_lost_motion_that_builds_up_over_a_few_micrometres_is_taken_up_over_them(tmp_path):
    """9 um that a nut takes up over 16 um of command: its slide goes 7 um meanwhile."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    with open(folder / "machine.toml", "a") as file:
        file.write('\n[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 9.0\nplay_mm = 0.016\n')
    assert read_machine(folder).pretravel == {"X": approx(0.007)}


@pytest.mark.parametrize("spread", [-1, 0, 1])
def test_where_it_turns_back_before_all_has_built_up_the_verifier_asks_for_what_has(
    tmp_path, spread
):
    """Ways of 0.5 and 0.3 mm behind a turn, of 0.8 to 4 mm over which 9 um are taken up: all of it
    was asked for at the turn (3.4 to 7.9 um left, and an error of gcomp)."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    effect = 'name = "windup"\naxis = "X"\nsize_um = 9.0\nlength_mm = 0.8\n'
    with open(folder / "machine.toml", "a") as file:
        file.write(f"\n[[effect]]\n{effect}spread = {spread}\n")
    program = "G0 X0 Y0 Z0\nG1 X50 F500\nX20 Y5\nX20.5\nX20.2\nX40\nX10 Y9\nM2\n"
    verifier = verified(read_machine(folder), program)
    assert verifier.passed and verifier.corrected.deviation < 0.6 * UM
    assert verifier.uncorrected.rest > 4 * UM > verifier.allowed
    wrong = verified(read_machine(folder), program, b"X9.9955", b"X9.9920")
    assert not wrong.passed and wrong.corrected.deviation == approx(3.5 * UM, rel=0.1)


@pytest.mark.parametrize("spread,lengths", [(0.0, (1.0,)), (1.0, (0.2, 0.45, 1.0, 2.25, 5.0))])
def test_a_compensator_takes_it_up_over_the_way_in_which_most_has_come(spread, lengths):
    """0.9 or more of what builds up, by hand."""
    ramp = windup.ramp_mm(size_um=5.0, length_mm=0.7, spread=spread)
    share = np.mean([1 - np.exp(-ramp / (0.7 * v)) for v in lengths])
    assert 0.9 <= share < 0.96


@pytest.mark.parametrize("spread", [-1.0, -0.5, 0.0, 0.5, 1.0])
def test_at_the_end_of_that_way_as_much_has_come_as_the_effect_says(spread):
    """0.9 to 0.96 of it, and all where it lets go at once: there a shorter way leaves some of it,
    however `spread` is written."""
    ramp = windup.ramp_mm(size_um=5.0, length_mm=0.7, spread=spread)
    at = State({"X": np.zeros(2)}, {"X": np.ones(2)}, {"X": (-1.0, 1.0)})
    at = replace(at, distance={"X": np.array([ramp, 0.99 * ramp])})
    came = 0.5 - windup.columns(at, "X", 0.7, spread=spread)[0, 0] * 1e3
    if spread < 0:
        assert came == pytest.approx([1.0, 0.99])
    else:
        assert (came >= 0.89).all() and (came < 0.96).all()


@pytest.mark.parametrize("lean_urad", [-60.0, 60.0])
def test_an_axis_that_rests_follows_the_others_whichever_way_it_has_wound_up(tmp_path, lean_urad):
    """X rests while Y goes 240 mm in steps, and has to give way by 14 um: it was held where it
    turned, since what keeps its side is not moved back (13 um off, and to and fro in each block
    where the map bends)."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    with open(folder / "machine.toml", "a") as file:
        file.write(f"\n[squareness]\nC0Y = {lean_urad}\n" + WINDUP.format(6.0))
    steps = "\n".join(f"Y{y}" for y in range(10, 250, 10))
    verifier = verified(read_machine(folder), f"G0 X0 Y0 Z0\nG1 X20 F500\nX10\nX30\n{steps}\nM2\n")
    assert verifier.corrected.deviation < 1.0 * UM


@pytest.mark.parametrize("lean_urad", [-60.0, 60.0])
def test_an_axis_that_rests_follows_the_others_where_a_reversal_is_spread(tmp_path, lean_urad):
    """The same with 6 um of backlash and --reversal off: X was held as far on as it had come while
    it had to give way by 14 um (14 um left where the program alone says the side, which passed)."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    effect = '[[effect]]\nname = "backlash"\naxis = "X"\nsize_um = 6.0\n'
    with open(folder / "machine.toml", "a") as file:
        file.write(f"\n[squareness]\nC0Y = {lean_urad}\n{effect}")
    for steps in (["Y240"], [f"Y{y}" for y in range(10, 250, 10)]):
        for way in (("X10", "X30"), ("X50", "X30")):
            text = "\n".join(["G0 X0 Y0 Z0", "G1 X20 F500", *way, *steps, "M2"]) + "\n"
            verifier = verified(read_machine(folder), text, reversal="off")
            assert verifier.passed and verifier.corrected.deviation < 6.1 * UM


@pytest.mark.parametrize("reversal", ["step", "off", "ramp", "mean"])
def test_a_cut_behind_a_hole_begins_where_it_belongs(tmp_path, reversal):
    """Behind the holes Z stands where it was sent at X 0, 20 um beside its place at X 100: with
    --reversal off it was led from there along the whole cut (20 um left at its begin)."""
    bent = "X_mm,EZX_um\n-400,0\n0,0\n100,20\n400,20\n"
    m = bent_machine(tmp_path / "m", backlash("X", 3), X=bent)
    text = "G0 X0 Y0 Z20\nG81 X50 Z1 R10 F500\nX100\nG80\nG1 X90\nX0\nM2\n"
    verifier = verified(m, text, reversal=reversal, hole_tolerance=0.05)
    assert verifier.passed and verifier.corrected.deviation < 3.1 * UM


@pytest.mark.parametrize("end", ["X-104.164 Y47.58 I-36.145 J23.79", "X-31.874 Y0 I-36.145 J23.79"])
@pytest.mark.parametrize("code", ["G2", "G3"])
def test_an_arc_is_cut_where_lost_motion_has_built_up(tmp_path, code, end):
    """X turns back where the arc begins, and 18 um build up over the first 0.6 mm of its way: no
    sample lay there, and a first piece of 1.6 mm took them up over all of it (7 um left)."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    with open(folder / "machine.toml", "a") as file:
        file.write("\n" + WINDUP.format(18.0))
    for before in (-20, -50):
        text = f"G0 X0 Y0 Z0\nG1 X{before} F500\nX-31.874\n{code} {end}\nM2\n"
        verifier = verified(read_machine(folder), text)
        assert verifier.passed and verifier.corrected.deviation < 1.0 * UM
