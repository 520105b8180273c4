"""Words that a control reads over, or whose value only it knows: centres outside the plane, F and S
by a variable, the first of two F words."""

from __future__ import annotations

import re

import pytest

from tests.test_printers import HOME, refused, written


@pytest.mark.parametrize(
    "dialect", ["grbl", "grblhal", "fluidnc", "marlin", "reprap", "klipper", "smoothie"]
)
def test_a_zero_centre_word_outside_the_plane_is_nothing(dialect):
    """gnea/grbl gcode.c clears I J K together; Marlin G2_G3.cpp, Klipper gcode_arcs.py,
    RepRapFirmware DoArcMove and Smoothieware compute_arc read the plane's own."""
    text = "G28\nG1 X60 Y50 Z1 F600\nG2 X80 Y50 I10 J0{}\nG3 X80.03 Y50.02 I0.015 J0.01{}\n"
    plain = written(text.format("", ""), dialect, HOME)
    strange = written(text.format(" K0", " K0.000"), dialect, HOME)
    assert [line.replace(" K0.000", "").replace(" K0", "") for line in strange] == plain
    assert not any(re.match(r"(G1 ?)?X.*K", line) and "I" not in line for line in strange), (
        "a chord has no centre"
    )
    assert "does not belong" in refused(text.format(" K1", ""), dialect, HOME).message


def test_a_zero_centre_word_outside_the_plane_is_nothing_on_fanuc():
    text = "G0 X60. Y50. Z1.\nG2 X80. Y50. I10. J0{} F600.\n"
    strange = written(text.format(" K0."), "fanuc-mill", HOME)
    assert [x.replace(" K0.", "") for x in strange] == written(text.format(""), "fanuc-mill", HOME)
    assert "does not belong" in refused(text.format(" K1."), "fanuc-mill", HOME).message


def test_linuxcnc_refuses_a_centre_word_outside_the_plane():
    """Its interpreter: "K word given for arc in XY-plane"."""
    assert (
        "does not belong" in refused("G0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 K0 F100\n", "linuxcnc").message
    )


@pytest.mark.parametrize(
    ("dialect", "code"), [("fanuc-mill", "G50.1"), ("haas", "G100"), ("fadal", "G50.1")]
)
def test_the_axes_of_a_mirror_that_ends_are_no_place(dialect, code):
    """B-64304EN-2, "Programmable mirror image": G50.1 names the axes; Haas mill operator's manual,
    G100: "at least one is required". Neither moves one."""
    text = "G90\nG0 X60. Y50. Z1.\n{}G1 X80. F600.\nY20.\n"
    lines = written(text.format(f"{code} X0 Y0\n"), dialect, HOME)
    assert f"{code} X0 Y0" in lines
    assert [x for x in lines if code not in x] == written(text.format(""), dialect, HOME)


@pytest.mark.parametrize("dialect", ["linuxcnc", "grblhal", "fluidnc", "fanuc-mill", "haas"])
@pytest.mark.parametrize(
    "word", ["F#<_hal[motion.feed]> ", "S#5 ", "F[#<_f>*2.] ", "S[#101+[#102*2]] ", "f#101 "]
)
def test_f_and_s_that_only_the_machine_knows(dialect, word):
    text = "G0 X60. Y50. Z1.\nG1 {}X120. Y80.\nX150.\n"
    lines = written(text.format(word), dialect)
    assert [line.replace(word, "") for line in lines] == written(text.format(""), dialect)
    assert sum(word.strip() in line for line in lines) == 1


def test_g93_needs_the_number_of_every_f():
    assert "only the machine knows" in refused("G0 X0 Y0 Z0\nG93 G1 X90 F#5\n", "linuxcnc").message


def test_words_that_are_no_f_or_s_still_need_a_number():
    assert refused("G0 X0 Y0 Z0\nG1 X#5 F#6\n", "linuxcnc").place.line == 2


@pytest.mark.parametrize("dialect", ["marlin", "klipper"])
def test_the_last_of_two_feeds_holds(dialect):
    """As pcb2gcode's output stands for such printers: G1 F300 X1 F600. Both words stay."""
    begin = "G1 F3000 X0 Y0 Z3\n"
    twice = written(begin + "G1 F300 X80 Y10 F600\nG1 X10 Y80\n", dialect, HOME)
    once = written(begin + "G1 X80 Y10 F600\nG1 X10 Y80\n", dialect, HOME)
    assert [line.replace("F300 ", "") for line in twice] == once
    assert sum("F300" in line and "F600" in line for line in twice) == 1


def test_two_feeds_stay_an_error_where_a_control_calls_them_one():
    assert refused("G1 F300 X80 Y10 F600\n", "grbl", HOME).message.startswith("two F words")
    assert refused("G1 X80 Y10 X60 F600\n", "marlin", HOME).message.startswith("two X words")


def test_a_new_word_has_the_decimals_that_the_nominal_place_has():
    """X stands at 10.00005 mm, finer than the least increment of 0.0001: the words that corrections
    put in count their increments from there, so that no half of one is lost."""
    lines = written("G21 G90 G17\nG0 X10.00005 Y10. Z5.\nG1 Y20. F100.\nY30.\nM2\n", "linuxcnc")
    new = [re.search(r"X([-0-9.]+)", line)[1] for line in lines[2:4]]
    assert all(len(x.partition(".")[2]) == 5 and x.endswith("5") for x in new), lines


@pytest.mark.parametrize(("dialect", "digits"), [("fanuc-mill", 8), ("haas", 8), ("linuxcnc", 10)])
def test_a_new_word_has_no_more_digits_than_the_control_reads(dialect, digits):
    """X stands at 13 mm, 0.511811024 inches: a Fanuc 0i reads eight digits, leading zeros too
    (cnccode.com, "CNC macro: display of variables"); Haas was not seen."""
    text = "G21 G90 G17\nG0 X13. Y10. Z5.\nG20\nG1 Y2. F10.\nY3.\nM2\n"
    lines = written(text, dialect, HOME if dialect != "linuxcnc" else None)
    new = [x[1] for line in lines[3:5] if (x := re.search(r"X([-0-9.]+)", line))]
    assert new and {len(x.replace(".", "")) for x in new} == {digits}, lines


@pytest.mark.parametrize(("units", "whole", "pointed"), [("G21", 20000, 20.0), ("G20", 20000, 2.0)])
def test_a_whole_number_of_a_haas_counts_what_its_setting_162_says(units, whole, pointed):
    """0.001 mm and 0.0001 inch, whatever the machine resolves (0.0001 mm here): Haas, "Help with
    the decimal points"; helmancnc.com, "Haas CNC alphabetical address codes"."""
    text = f"{units} G90 G17\nG0 X0. Y0. Z5.\nG1 X{{}} F10.\nG2 X0. I-{{}} J0.\nM2\n"
    counted = written(text.format(whole, whole // 2), "haas", HOME)
    assert counted == written(text.format(pointed, pointed / 2), "haas", HOME)
