"""Uncertainties of a folder that are wrong: refused with their line."""

from __future__ import annotations

import pytest

from postproc.errors import MachineError
from tests.stated_machines import EFFECT, MILL, machine

BAD_TABLES = {
    "below zero": ("X_mm,EXX_um\n-500,1\n0,-2\n500,1\n", 3, "U of EXX is -2 at X = 0"),
    "an angle below zero": ("X_mm,EBX_urad\n-500,1\n500,-3\n", 3, "U of EBX is -3 at X = 500"),
    "begins late": (
        "X_mm,EXX_um\n0,1\n500,1\n",
        2,
        "go from X = 0 to 500, the table from -500 to 500",
    ),
    "ends early": (
        "X_mm,EXX_um\n-500,1\n0,1\n",
        3,
        "go from X = -500 to 0, the table from -500 to 500",
    ),
    "no number": ("X_mm,EXX_um\n-500,1\n500,\n", 3, "'' is not a number"),
    "not finite": ("X_mm,EXX_um\n-500,nan\n500,1\n", 2, "not finite"),
    "another axis": ("X_mm,EYY_um\n-500,1\n500,1\n", 1, "'EYY_um' is not a component of axis X"),
    "another unit": ("X_mm,EXX_mm\n-500,1\n500,1\n", 1, "'EXX_mm' is not a component of axis X"),
    "the runs of a calibration": (
        "X_mm,component,u\n0,EXX,1\n",
        1,
        "'component' is not a component of axis X",
    ),
    "one direction": (
        "X_mm,EXX_um_fwd\n-500,1\n500,1\n",
        1,
        "give one column, or both _fwd and _rev",
    ),
    "no order": ("X_mm,EXX_um\n500,1\n-500,1\n", 3, "does not ascend"),
    "one node": ("X_mm,EXX_um\n0,1\n", 1, "1 nodes: a table needs two at least"),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_a_faulty_table_of_uncertainties_is_refused_with_its_line(tmp_path, name):
    text, line, why = BAD_TABLES[name]
    with pytest.raises(MachineError) as told:
        machine(tmp_path, X_uncertainty=text)
    assert f"X_uncertainty.csv:{line}: " in str(told.value) and why in str(told.value)


BOW = '[[effect]]\nname = "bow"\naxis = "X"\nacross = 2\nsize_um = 5.0\n'
BAD_TOML = {
    "no section": ("[squareness]\nC0Y = 1.0\nu = 3.0\n", "u = 3.0", "[squareness.u]"),
    "no squareness": (
        "[squareness.u]\nX0C = 1.0\n",
        "X0C",
        "'X0C' is not a squareness of this machine",
    ),
    "squareness of itself": (
        "[squareness.u]\nC0Z = 1.0\n",
        "C0Z",
        "'C0Z' is not a squareness of this machine",
    ),
    "squareness below zero": (
        "[squareness]\nC0Y = 1.0\n[squareness.u]\nC0Y = -2.0\n",
        "C0Y = -2.0",
        "is below zero",
    ),
    "squareness no number": ('[squareness.u]\nC0Y = "3"\n', "C0Y", "'3' is not a number"),
    "inline": (
        "[squareness]\nC0Y = 1.0\nu = { C0Y = -2.0 }\n",
        "u = {",
        "C0Y = -2.0 is below zero",
    ),
    "of no parameter": (
        EFFECT + "u_size_um = 1.0\n",
        "u_size_um",
        "'u_size_um' is not a key of [effect]",
    ),
    "of a choice": (BOW + "u_across = 1.0\n", "u_across", "'u_across' is not a key of [effect]"),
    "parameter below zero": (
        EFFECT + "u_amplitude_um = -1.0\n",
        "u_amp",
        "u_amplitude_um = -1.0 is below zero",
    ),
    "parameter no number": (
        EFFECT + 'u_amplitude_um = "1 um"\n',
        "u_amp",
        "'1 um' is not a number",
    ),
    "no meaning": (
        EFFECT + "u_period_mm = 10.0\n",
        "u_period",
        "effect cyclic has no meaning at period_mm = 0",
    ),
    "hysteresis below zero": (
        "[limits]\nhysteresis_um = -0.5\n",
        "hysteresis_um",
        "hysteresis_um = -0.5 is below zero",
    ),
    "hysteresis no number": (
        "[limits]\nhysteresis_um = true\n",
        "hysteresis_um",
        "True is not a number",
    ),
}


@pytest.mark.parametrize("name", BAD_TOML)
def test_faulty_uncertainties_in_machine_toml_are_refused_with_their_line(tmp_path, name):
    text, where, why = BAD_TOML[name]
    with pytest.raises(MachineError) as told:
        machine(tmp_path, MILL + text)
    line = next(i for i, x in enumerate((MILL + text).splitlines(), 1) if x.startswith(where))
    assert f"machine.toml:{line}: " in str(told.value) and why in str(told.value)


def test_uncertainties_of_an_axis_that_there_is_not_are_refused(tmp_path):
    with pytest.raises(
        MachineError, match=r"Q_uncertainty.csv is of no axis of the machine[\s\S]*axes: X Y Z"
    ):
        machine(tmp_path, Q_uncertainty="Q_mm,EXQ_um\n0,1\n1,1\n")


def test_an_uncertainty_far_from_a_worn_stretch_is_none_that_has_no_meaning(tmp_path):
    """exp of -5000 is 0, which is no reason to refuse the machine that gcomp wrote itself."""
    worn = (
        '[[effect]]\nname = "backlash_position"\naxis = "X"\nb0_um = 0.0126\nb1_um = 0\nb2_um = 0\n'
        "play_mm = 0\ndegree = 0\nworn_um = 3.3\nworn_mm = -400.0\nwide_mm = 10.0\nflank = 0\n"
        "u_b0_um = 0.0657\nu_worn_um = 1.2\nu_wide_mm = 1.0\n"
    )
    assert machine(tmp_path / "m", MILL + worn).effects[0].spread
