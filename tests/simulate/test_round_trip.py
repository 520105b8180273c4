"""What instruments read on a known machine is what that machine's file says, computed here by hand
or by its own formula."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc import effects
from postproc.simulate import experiments
from postproc.simulate.timeline import Conditions

from .samples import MILL, STRICT, STUDER, exact, limits, read, real, term, timed, without_tables

UM = 1e-3
NANOMETRE = 1e-6


def trial(name: str, machine, *terms, bounds=None, **given):
    """A test that gcomp writes, run on a machine and read by the instrument that it is for."""
    own = experiments.write(name, machine, machine.control)
    return read(
        own.instrument,
        real(timed(own.text, machine, Conditions(), bounds), *terms),
        **(own.settings | given),
    )


@pytest.mark.parametrize(("axis", "other", "step"), [("Z", "X", 30), ("X", "Z", 10)])
def test_a_laser_reads_the_tables_of_the_studer_by_direction(axis, other, step):
    """Z with X at zero, where nothing of X and no arm adds: EZZ of the folder's CSV. X: EXX, and
    what Z adds at rest."""
    place = 0 if axis == "Z" else 255
    found = trial(f"positioning:{axis},step={step},even=1,runs=2,at_{other}={place}", STUDER)
    table, row = STUDER.axes[axis].table, "XYZ".index(axis)
    still = STUDER.axes[other].table.forward[row]
    add = float(np.interp(place, STUDER.axes[other].table.nodes, still))
    at, side = found.position(axis), found.approach(axis)
    for sign, values in ((1, table.forward[row]), (-1, table.reverse[row])):
        of = side == sign
        assert at[of].min() == table.nodes[0] and at[of].max() == table.nodes[-1]
        assert found.reading[of] == approx(
            np.interp(at[of], table.nodes, values) + add, abs=1e-3 * UM
        )
    assert (
        found.columns["run"].tolist() == sorted(found.columns["run"].tolist())
        and found.columns["run"].max() == 2
    )


def test_straightness_and_angle_are_the_tables_too():
    table = STUDER.axes["Z"].table
    bent = trial("straightness:Z,step=30,even=1,runs=1,at_X=50", STUDER)
    x = STUDER.axes["X"].table
    add = float(np.interp(50.0, x.nodes, x.forward[0]))
    up = bent.approach("Z") > 0
    assert bent.sensitive == {"X": 1.0, "Z": 0.0} and bent.quantity == "straightness"
    assert bent.reading[up] == approx(table.forward[0] + add, abs=1e-3 * UM)
    turned = trial("angle:Z,step=30,even=1,runs=1", STUDER)
    assert turned.reading[turned.approach("Z") < 0] == approx(table.reverse[4][::-1], abs=1e-9)


def test_a_diagonal_is_the_deviation_along_it():
    found = trial("diagonal:XYZ,runs=1", MILL)
    place = np.stack([found.position(x) for x in "XYZ"])
    side = np.stack([found.approach(x) for x in "XYZ"])
    vector = np.array([found.sensitive[x] for x in "XYZ"])
    assert np.linalg.norm(vector) == approx(1.0)
    assert found.reading == approx(vector @ MILL.deviation(place, side), abs=1e-3 * UM)


def test_a_ballbar_on_a_machine_with_squareness_alone():
    """S (R / 2) sin 2t: the deviation is (-S y, 0), S = -40 urad, R = 100 mm, so +2 um sin 2t; both
    senses alike."""
    machine = replace(exact("XY", 300.0), square={"Y": np.array([0.0, 0.0, 40e-6])})
    found = trial("ballbar:XY,radius=100,runs=1", machine)
    x, y = found.position("X"), found.position("Y")
    t = np.arctan2(y, x)
    slope = machine.deviation(np.array([[0.0], [1.0]]), np.zeros((2, 1)))[0, 0]
    assert abs(slope) == approx(40e-6)
    assert found.reading == approx(slope * 50 * np.sin(2 * t), abs=1e-3 * UM)
    assert sorted(set(found.columns["sense"])) == [-1, 1]


def test_a_ballbar_keeps_the_middle_turn_and_leaves_out_what_leads_in():
    found = trial("ballbar:XZ,radius=50,runs=1,at_X=85,at_Z=255", without_tables(STUDER))
    assert found.head["radius_mm"] == 50 and found.head["centre"] == {"X": 85.0, "Z": 255.0}
    assert np.hypot(found.position("X") - 85, found.position("Z") - 255) == approx(
        50, abs=NANOMETRE
    )
    for run, sense in ((1, 1), (2, -1)):
        of = found.columns["run"] == run
        angle = np.unwrap(np.arctan2(found.position("Z")[of] - 255, found.position("X")[of] - 85))
        assert angle[-1] - angle[0] == approx(sense * 2 * np.pi, abs=0.01)
        # half a turn of overshoot is gone
        assert abs(angle[0] - np.pi) % (2 * np.pi) == approx(0.0, abs=0.01)
    assert found.reading == approx(0.0, abs=NANOMETRE)


def test_servo_lag_is_minus_tau_v_in_a_log():
    """8 ms at 3000 mm/min are 0.4 mm."""
    machine = exact()
    t = timed("G0 X0\nG4 P1\nG1 X100 F3000\nG4 P1\nM2\n", machine, STRICT)
    found = read("log", real(t, term("servo_lag", "X", tau_ms=8.0)), rate="500")
    off = found.columns["X_act_mm"] - found.position("X")
    v = t.state(found.columns["t_s"]).velocity["X"]
    assert off == approx(-0.008 * v, abs=NANOMETRE)
    assert off.min() == approx(-0.4, abs=NANOMETRE) and found.head["sees"] == "scale"
    assert found.columns["Y_act_mm"] == approx(found.position("Y"))


def test_backlash_is_a_step_at_every_reversal():
    found = trial("staircase:X,runs=1", without_tables(STUDER), term("backlash", "X", size_um=9.0))
    assert set(np.round(found.columns["reading_um"], 6)) == {-4.5, 4.5}
    assert (np.sign(found.reading) == -found.approach("X")).all()


def test_windup_builds_up_with_the_way_after_the_turn():
    """Dahl: -s (w / 2) (1 - 2 exp(-way / length)) over the ways of the staircase: 0.01 to 5 mm."""
    found = trial(
        "staircase:X,runs=1",
        without_tables(STUDER),
        term("windup", "X", size_um=10.0, length_mm=0.5),
    )
    place, side = found.position("X"), found.approach("X")
    back = np.flatnonzero((side == -1) & (place < 85 - 1e-6) & (np.append(0, side[:-1]) == 1))
    way = 85 - place[back]
    assert len(back) > 5 and way.min() == approx(0.01) and way.max() == approx(5.0)
    assert found.columns["reading_um"][back] == approx(5.0 * (1 - 2 * np.exp(-way / 0.5)), abs=1e-3)


def test_windup_may_differ_along_the_travel():
    """Long behind its turn, at the middle of the travel half of 10 um, at its high end half of 10 +
    4."""
    plain = without_tables(STUDER)
    low, high = plain.axes["X"].travel
    place, far = np.array([(low + high) / 2, high]), np.full(2, 99.0)
    state = effects.State({"X": place}, {"X": np.ones(2)}, {"X": (low, high)}, distance={"X": far})
    windup = effects.load("windup")
    found = effects.deviation(
        windup, state, "X", size_um=10.0, length_mm=0.5, grows_um=4.0, grows=1.0
    )
    assert found[0] * 1e3 == approx([-5.0, -7.0])
    _, _, nodes, forward, backward = windup.tables(
        "X", (low, high), size_um=10.0, length_mm=0.5, grows_um=4.0
    )[0]
    assert (
        list(nodes) == [low, high]
        and forward * 1e3 == approx([-3.0, -7.0])
        and backward == approx(-forward)
    )


def test_inertia_shows_the_acceleration():
    t = timed("G0 X0\nG4 P0.5\nG1 X100 F6000\nG4 P0.5\nM2\n", exact(), STRICT)
    found = read("log", real(t, term("inertia", "X", um_per_mm_s2=0.002)), rate="1000")
    off = (found.columns["X_act_mm"] - found.position("X")) * 1e3
    assert sorted(set(np.round(off, 6))) == [-2.0, 0.0, 2.0]


def test_screw_heat_needs_the_way_gone_before():
    """11 ppm/K at 400 mm times the kelvins that the recording states."""
    machine = without_tables(STUDER)
    heat = term("screw_heat", "Z", alpha_ppm_K=11.0, fixed_um_K=0.0, tau_s=0.0)
    found = trial("soak:Z,hours=0.2,feed=6000", machine, heat)
    warm = found.columns["T_screw_Z_C"] - 20.0
    assert warm.max() > 0.5
    assert found.columns["reading_um"] == approx(11e-3 * warm * found.position("Z"), abs=1e-6)


def test_a_recording_that_begins_late_knows_the_heat_from_before():
    """The same log in one piece and as its second half."""
    text = "G0 X0\n" + "G1 X100 F6000\nG1 X0\n" * 20 + "M2\n"
    t = timed(text, exact(), STRICT)
    works = real(t, term("screw_heat", "X", alpha_ppm_K=11.0, fixed_um_K=1.0, tau_s=0.0))
    whole, half = (
        read("log", works, rate="100"),
        read("log", works, **{"rate": "100", "from": "20"}),
    )
    n = len(half)
    assert n > 500 and half.columns["X_act_mm"] == approx(whole.columns["X_act_mm"][-n:], abs=1e-12)


def test_spindle_growth_follows_the_spindle_between_two_captures():
    """First order, 10 um a 1000 rpm and 600 s: on for 600 s, off for 600 s, captured only at the
    end."""
    text = "G0 Z0\nG1 Z1 F600\nM3 S2000\nG4 P600\nM5\nG4 P600\nM2\n"
    t = timed(text, exact(), STRICT)
    growth = term("spindle_growth", "Z", um_per_1000_rpm=10.0, tau_s=600.0)
    found = read("laser", real(t, growth), dwell="500", along="Z")
    top = 20 * (1 - np.exp(-1))
    assert found.columns["reading_um"] == approx([top, top * np.exp(-1)], rel=1e-2)


def test_a_spindle_shifts_at_once_and_its_housing_follows():
    """At 600 s of 2000 rpm, fastest 4000: the shift is a quarter of 8 um; of the heat 1 - 2/e has
    come to the housing, as slow as the spindle."""
    text = "G0 Z0\nG1 Z1 F600\nM3 S2000\nG4 P600\nM5\nG4 P600\nM2\n"
    t = timed(text, exact(), STRICT)
    late = {"tau_s": 600.0, "housing_s": 600.0, "fastest_rpm": 4000.0}
    growth = term("spindle_growth", "Z", um_per_1000_rpm=0.0, housing_um=10.0, shift_um=8.0, **late)
    found = read("laser", real(t, growth), dwell="500", along="Z")
    # 1 - (1 + t / tau) exp(-t / tau), of two equal time constants at t = tau
    follows = 20 * (1 - 2 * np.exp(-1))
    assert found.columns["reading_um"][0] == approx(follows + 8.0 / 4, rel=2e-2)
    # Off for as long again: 20 [(1 + 1) e^-1 - (1 + 2) e^-2] of the step's end, and no shift.
    assert found.columns["reading_um"][1] == approx(
        20 * (2 * np.exp(-1) - 3 * np.exp(-2)), rel=2e-2
    )


def test_the_machines_own_effects_act_once_and_an_instruments_only_when_asked():
    plain = without_tables(STUDER)
    heavy = term("backlash", "X", size_um=6.0)
    from postproc.machine.stated import EffectTerm

    tables = tuple(
        _table(*row) for row in heavy.module.tables("X", plain.axes["X"].travel, size_um=6.0)
    )  # as the machine's file gives it to the compensator
    laser = term("laser_air", "", ppm_K=0.93)
    stated = (
        EffectTerm("backlash", "X", {"size_um": 6.0}, heavy.module, tables),
        EffectTerm("laser_air", "", {"ppm_K": 0.93}, laser.module),
    )
    machine = replace(plain, effects=stated)
    own = experiments.write("positioning:X,runs=1", machine, machine.control)
    from postproc.simulate.history import Heat

    t = timed(own.text, machine, Conditions(heat=Heat(drift=10.0)))
    quiet = read("laser", real(t), **own.settings)
    assert set(np.round(quiet.columns["reading_um"], 6)) == {-3.0, 3.0}
    loud = read("laser", real(t, laser), **own.settings)
    more = loud.columns["reading_um"] - quiet.columns["reading_um"]
    air = quiet.columns["T_air_C"] - 20.0
    assert (
        more == approx(0.93e-3 * air * (quiet.position("X") - quiet.position("X").min()), abs=1e-6)
        and np.ptp(more) > 0.01
    )


def _table(component, letter, nodes, forward, reverse):
    from postproc.machine.tables import COMPONENTS, AxisTable

    both = np.zeros((2, 6, len(nodes)))
    both[:, COMPONENTS.index(component)] = forward, reverse
    return AxisTable(letter, nodes, both[0], both[1])


def test_force_bends_in_the_runs_that_have_it():
    own = experiments.write("positioning:X,runs=2", without_tables(STUDER), "fanuc-lathe")
    t = timed(own.text, without_tables(STUDER), Conditions(force={"X": (0.0, 300.0)}))
    found = read("laser", real(t, term("force_compliance", "X", um_per_N=0.02)), **own.settings)
    assert found.columns["reading_um"] == approx(np.where(found.columns["run"] == 2, 6.0, 0.0))
    assert set(found.columns["force_X_N"]) == {0.0, 300.0}


def test_features_of_parts_show_scale_and_tool():
    """50 ppm of 100 mm are 5 um; a tool 8 um too large makes a pocket 8 um larger, a boss smaller,
    and no distance other."""
    t = timed("G0 X0\nG1 X100 F6000\nM2\n", exact(), STRICT, parts=2)
    works = real(t, term("scale", "X", ppm=50.0), term("tool_size", "", diameter_um=8.0))
    found = read(
        "probe", works, features="X:100,X:pocket_size:100,X:boss_diameter:100", readings="2"
    )
    off = (found.columns["measured_mm"] - 100) * 1e3
    for kind, um in (("centre_distance", 5.0), ("pocket_size", 13.0), ("boss_diameter", -3.0)):
        assert off[found.columns["kind"] == kind] == approx([um] * 4, abs=1e-6)


def test_slides_on_a_tool_of_other_length_swing_with_it():
    """G43.1 Z50 on the mill: the deviation of the machine with that tool, not of the bare one."""
    t = timed(
        "G21 G90 G94 G54\nG43.1 Z50\nG0 X100 Y50 Z0\nG1 X150 F600\nG4 P3\nM2\n", MILL, Conditions()
    )
    found = read("laser", real(t), along="X")
    place = np.array([[150.0], [50.0], [found.position("Z")[0]]])
    side = np.array([[found.approach(x)[0]] for x in "XYZ"])
    long, short = MILL.with_tool((0.0, 0.0, 50.0)), MILL
    assert found.reading[0] == approx(long.deviation(place, side)[0, 0], abs=1e-3 * UM)
    assert abs(long.deviation(place, side)[0, 0] - short.deviation(place, side)[0, 0]) > 0.1 * UM


def test_a_million_samples_are_as_good_as_a_hundred():
    t = timed("G0 X0\nG1 X100 F600\nM2\n", exact(), STRICT, limits(exact()))
    dense, thin = (read("log", real(t), rate=str(r)) for r in (100_000, 100))
    assert len(dense) > 1_000_000
    assert dense.columns["X_cmd_mm"][::1000] == approx(thin.columns["X_cmd_mm"], abs=1e-9)
