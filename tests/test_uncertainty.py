"""How well the map is known: what a folder states, and what becomes of it at a place and along a
path, by hand."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from pytest import approx

from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.stated import EffectTerm
from postproc.machine.uncertainty import AlongPath, MapUncertainty
from postproc.nc import dialects
from postproc.verify import Verifier
from tests.stated_machines import AXIS, EFFECT, HEAD, MILL, UM, URAD, known, machine

# -- by hand ---------------------------------------------------------------------------------------


def test_one_axis_between_its_nodes_and_by_direction(tmp_path):
    m = machine(
        tmp_path, X_uncertainty="X_mm,EXX_um_fwd,EXX_um_rev\n-500,1,2\n0,1,2\n100,3,8\n500,3,8\n"
    )
    assert known(m, +1, X=50) == approx({"X": 2.0, "Y": 0.0, "Z": 0.0})
    assert known(m, -1, X=50)["X"] == approx(5.0)
    assert known(m, 0, X=50)["X"] == approx(3.5), "both directions at once, as if wrong alike"


def test_an_angle_times_its_arm(tmp_path):
    """w-b-Z-X-t, yaw of Z known to 10 urad, X measured from 20, tool at Z = -50: at X = 120 e_Z =
    -b 100 mm, 1 um; e_X = b (-50 mm), 0.5 um."""
    text = (
        HEAD.format(chain="w-b-Z-X-t")
        + AXIS.format("X")
        + AXIS.format("Z")
        + "measured_at = { X = 20.0 }\n"
    )
    m = machine(
        tmp_path, text + "[tool]\nZ = -50.0\n", Z_uncertainty="Z_mm,EBZ_urad\n-500,10\n500,10\n"
    )
    assert known(m, X=120) == approx({"X": 0.5, "Z": 1.0})
    assert known(m, X=20)["Z"] == approx(0.0)
    longer = MapUncertainty(m).with_tool((0.0, 0.0, 30.0))
    assert longer.expanded(np.zeros((2, 1)), np.zeros((2, 1)))[0, 0] == approx(0.8 * UM)


def test_squareness_at_the_far_corner(tmp_path):
    """C0Y known to 3 urad: 1.2 um along X at Y = 400. B0Z, 4 urad, 400 mm up: 1.6 um along X too;
    together 2 um."""
    m = machine(tmp_path, MILL + "[squareness]\nC0Y = 20.0\n[squareness.u]\nC0Y = 3.0\nB0Z = 4.0\n")
    assert known(m, Y=400) == approx({"X": 1.2, "Y": 0.0, "Z": 0.0})
    assert known(m, Y=-400, Z=400)["X"] == approx(2.0)
    assert m.square_u == approx({"C0Y": 3 * URAD, "B0Z": 4 * URAD})


def test_independent_components_add_in_quadrature_and_the_same_one_does_not_count_twice(tmp_path):
    m = machine(
        tmp_path,
        X_uncertainty="X_mm,EXX_um\n-500,3\n500,3\n",
        Y_uncertainty="Y_mm,EXY_um,EZY_um\n-500,4,12\n500,4,12\n",
    )
    assert known(m) == approx({"X": 5.0, "Y": 0.0, "Z": 12.0})
    assert MapUncertainty(m).length(np.zeros((3, 1)), np.zeros((3, 1)))[0] == approx(13 * UM)


def test_parameters_of_effects(tmp_path):
    """Lost motion known to 4 um: 2 um on either side, none in the mean. A wave of 5 +- 1 um of 10
    mm, phase 90 +- 10 degrees: at its crossing the phase counts, 5 sin(10 deg) um; at its crest the
    amplitude."""
    text = MILL + '[[effect]]\nname = "backlash"\naxis = "Y"\nsize_um = 9.0\nu_size_um = 4.0\n'
    text += (
        '[[effect]]\nname = "cyclic"\naxis = "X"\nperiod_mm = 10.0\namplitude_um = 5.0\nphase_deg ='
        " 90.0\n"
    )
    m = machine(tmp_path, text + "u_amplitude_um = 1.0\nu_phase_deg = 10.0\n")
    assert MapUncertainty(m).missing == ("EXX", "EYY", "EZZ"), "of both effects it is stated"
    assert known(m, 1)["Y"] == known(m, -1)["Y"] == approx(2.0)
    assert known(m, 0)["Y"] == approx(0.0)
    each = np.array([known(m, X=x)["X"] for x in np.arange(0, 10, 0.1)])
    assert each.max() == approx(1.0, abs=0.03) and each.min() == approx(
        5 * np.sin(np.radians(10)), abs=0.03
    )


def test_what_is_not_stated_has_no_part_and_is_named(tmp_path):
    text = MILL + "[squareness]\nC0Y = 20.0\nB0Z = 1.0\n[squareness.u]\nB0Z = 0.0\n"
    text += '[[effect]]\nname = "backlash"\naxis = "Y"\nsize_um = 9.0\n'
    m = machine(tmp_path, text, X_uncertainty="X_mm,EXX_um,EYX_um\n-500,3,0\n500,3,0\n")
    assert MapUncertainty(m).missing == ("EYY", "EZZ", "C0Y", "backlash Y")
    assert known(m, X=100, Y=100, Z=100) == approx({"X": 3.0, "Y": 0.0, "Z": 0.0})


def test_the_shipped_machines_state_none():
    """Neither the thesis nor the made-up ones say how well their numbers are known."""
    for folder in sorted((Path(__file__).resolve().parents[1] / "machines").glob("*/machine.toml")):
        assert (
            AlongPath(read_machine(folder.parent)).report()
            == "the map's own uncertainty is not stated"
        )


def test_the_correction_does_not_depend_on_it(tmp_path):
    text = b"G0 X0 Y0 Z0\nG1 X100 Y50 F500\n"
    plain = machine(tmp_path / "a")
    sure = machine(tmp_path / "b", X_uncertainty="X_mm,EXX_um\n-500,3\n500,3\n")
    outputs = [corrected(replace(m, digest=""), [text])[0] for m in (plain, sure)]
    assert outputs[0] == outputs[1] != text


# -- along a program -------------------------------------------------------------------------------


def corrected(m: Machine, portions: list[bytes]) -> tuple[bytes, Verifier]:
    dialect = dialects.load(m.control)
    filter_ = Filter(m, dialect, setup_of(m))
    verifier = Verifier(filter_)
    out = b"".join(filter_.feed(data) for data in portions) + filter_.finish()
    return out, verifier


SLOPE = "X_mm,EXX_um\n-500,0\n500,10\n"  # U = 5 + X / 100 um


def test_verify_says_it_with_the_line(tmp_path):
    """U of X is 5 + X / 100 um: 7 um at X = 200, which line 3 reaches; the rest of the map has
    none."""
    m = machine(tmp_path, X_uncertainty=SLOPE)
    _, verifier = corrected(m, [b"G0 X0 Y0 Z0\nG1 X100 F500\nG1 X200\nG1 X50\n"])
    assert (
        "; the map itself is known to +- 7.0 um (95 %, line 3); no uncertainty is stated of"
        " EYY, EZZ" in verifier.report()
    )
    assert verifier.map.largest == approx(7 * UM, abs=1e-6)


def test_verify_says_when_nothing_is_stated(tmp_path):
    _, verifier = corrected(machine(tmp_path), [b"G0 X0 Y0 Z0\nG1 X100 F500\n"])
    assert verifier.report().endswith("; the map's own uncertainty is not stated")


def test_a_program_that_goes_nowhere_has_no_number(tmp_path):
    _, verifier = corrected(machine(tmp_path, X_uncertainty=SLOPE), [b"(nothing)\n"])
    assert "no place of the path is known" in verifier.report() and "+-" not in verifier.report()


def test_the_tool_and_the_hole_count(tmp_path):
    """A yaw of the spindle's slide known to 10 urad: e_X = b (tool): a tool of 80 mm, 0.8 um. A
    hole's bottom is on the way."""
    m = machine(tmp_path, Z_uncertainty="Z_mm,EBZ_urad\n-500,10\n500,10\n")
    assert corrected(m, [b"G0 X0 Y0 Z0\nG1 X10 F500\n"])[1].map.largest == approx(0.0, abs=1e-9)
    long = replace(m, tool=np.array([0.0, 0.0, -80.0]))
    assert corrected(long, [b"G0 X0 Y0 Z0\nG1 X10 F500\n"])[1].map.largest == approx(0.8 * UM)
    deep = machine(tmp_path, Z_uncertainty="Z_mm,EZZ_um\n-500,50\n0,0\n500,0\n")
    _, verifier = corrected(deep, [b"G0 X0 Y0 Z10\nG81 X10 Y10 R2 Z-20 F100\nG80\n"])
    assert verifier.map.largest == approx(2 * UM, rel=0.01) and verifier.map.line == 2


def test_the_batch_does_not_matter(tmp_path):
    rng = np.random.default_rng(2)
    m = machine(
        tmp_path,
        X_uncertainty="X_mm,EXX_um,ECX_urad\n-500,5,9\n20,1,3\n500,5,4\n",
        Y_uncertainty="Y_mm,EYY_um_fwd,EYY_um_rev\n-500,2,4\n500,2,4\n",
    )
    lines = [b"G0 X0 Y0 Z0\n", b"G43.1 Z60\n"]
    lines += [b"G1 X%.3f Y%.3f Z%.3f F500\n" % tuple(rng.uniform(-90, 90, 3)) for _ in range(40)]
    for k in (20, 30):
        lines[k : k + 2] = [b"G1 X80 Y0\n", b"G2 X80 Y0 I-40 J0\n"]
    whole = corrected(m, [b"".join(lines)])[1].report()
    assert "line" in whole
    for cuts in (
        [b"".join(lines[:7]), b"".join(lines[7:])],
        lines,
        [bytes([c]) for c in b"".join(lines)],
    ):
        assert corrected(m, cuts)[1].report() == whole


def test_of_equal_places_the_first_line_counts(tmp_path):
    m = machine(tmp_path, X_uncertainty="X_mm,EXX_um\n-500,2\n500,2\n")
    lines = [b"G0 X0 Y0 Z0\n", b"G1 X10 F100\n", b"G1 X0\n"]
    for portions in (lines, [b"".join(lines)]):
        assert corrected(m, portions)[1].map.line == 1


def test_the_commands_say_it(tmp_path):
    text = (
        MILL + '[squareness.u]\nC0Y = 3.0\n[[effect]]\nname = "backlash"\naxis = "Y"\nsize_um ='
        " 9.0\nu_size_um = 4.0\n"
    )
    machine(tmp_path / "m", text, X_uncertainty="X_mm,EXX_um,EBX_urad\n-500,3,1\n500,1,2\n")
    program = tmp_path / "p.nc"
    program.write_text("G0 X0 Y0 Z0\nG1 X100 Y10 F500\n")

    def said(*arguments: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "postproc", *arguments],
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout + done.stderr

    shown = said("machines", "show", str(tmp_path / "m"))
    assert "known to +- (95 %, at most): EXX 3.0 um, EBX 2.0 urad" in shown
    assert "squareness C0Y is known to +- 3.0 urad (95 %)" in shown
    assert "known to size_um +- 4 (95 %)" in shown
    assert (
        "the map itself is known to +- " in shown
        and "no uncertainty is stated of EYY, EZZ" in shown
    )
    assert "the map itself is known to +- 2.7 um (95 %) there" in said(
        "explain", str(program), "--machine", str(tmp_path / "m")
    )
    verified = said(str(program), "--machine", str(tmp_path / "m"), "--verify")
    assert "the map itself is known to +- 2.8 um (95 %, line 2)" in verified


# -- as the folder states it -----------------------------------------------------------------------


def test_the_uncertainties_of_one_turn_are_repeated(tmp_path):
    turning = '[axes.C]\ntravel = [-720.0, 720.0]\nleast_increment = 0.001\ntable = "C.csv"\n'
    text = HEAD.format(chain="w-C-b-X-Y-t") + AXIS.format("X") + AXIS.format("Y") + turning
    m = machine(
        tmp_path,
        text,
        C="C_deg,EXC_um\n0,1\n90,5\n360,1\n",
        C_uncertainty="C_deg,EXC_um\n0,1\n180,3\n360,1\n",
    )
    for c in (90, 450, -270, 630):
        u = MapUncertainty(m).length(np.array([[0.0], [0.0], [float(c)]]), np.zeros((3, 1)))
        assert u[0] == approx(2 * UM), c


def test_hysteresis_is_read_in_um(tmp_path):
    assert machine(tmp_path).limits.hysteresis == approx(1 * UM)
    assert machine(tmp_path, MILL + "[limits]\nhysteresis_um = 2.5\n").limits.hysteresis == approx(
        2.5 * UM
    )
    assert machine(tmp_path, MILL + "[limits]\nhysteresis_um = 0\n").limits.hysteresis == 0.0


def test_two_effects_of_one_name_are_distinguished(tmp_path):
    wave = EFFECT.replace("10.0", "{}")
    m = machine(
        tmp_path, MILL + wave.format("10.0") + "u_amplitude_um = 1.0\n" + wave.format("4.0")
    )
    assert list(MapUncertainty(m).parts) == ["cyclic X #1 (amplitude_um)"]
    assert MapUncertainty(m).missing[-1] == "cyclic X #2"
    assert isinstance(m.effects[0].spread[0], EffectTerm)
