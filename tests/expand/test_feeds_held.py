"""F and S that are named again behind what is written out: those of the program, and not the time
of a dwell, the percentage of M103, or what stands in a string.

Siemens, NC Programming Manual, "Dwell time (G4)"; HEIDENHAIN TNC 640 user's manual, ISO
programming, "Dwell time" (G04 F in seconds), "Feed rate factor for plunging movements: M103".
"""

from __future__ import annotations

import pytest

from tests.expand import test_klartext, test_pole
from tests.expand.plain_lines import text_of
from tests.expand.test_siemens_drilling import holes

DATA = "Q200=+2 Q201=-5 Q206=+100 Q202=+5 Q210=+0 Q203=+0 Q204=+20 Q211=+0"
ISO = "G00 G90 X+0 Y+0 Z+10|G01 X+1 F200|"
NOT_FEEDS = ("G04 F2", "M103 F20", "M128 F3000")


@pytest.mark.parametrize(
    ("program", "lines"),
    [
        ("G1 X1 F200|G4 F2|X20 FB=50|X30", "G1 X1 F200|G4 F2|X20 F50|F200|X30"),
        ("G1 X1 F200|X20 FB=50|G4 F2|X30", "G1 X1 F200|X20 F50|F200|G4 F2|X30"),
        ('G1 X1 F200|MSG("F9")|X20 FB=50|X30', 'G1 X1 F200|MSG("F9")|X20 F50|F200|X30'),
        ('G1 X1 F200|X20 FB=50|MSG("F9")|X30', 'G1 X1 F200|X20 F50|F200|MSG("F9")|X30'),
        ('G1 X1 F200|MSG("FB=5")|X30', 'G1 X1 F200|MSG("FB=5")|X30'),
        ('MSG("A;B") G1 X1 F200|X20 FB=50|X30', 'MSG("A;B") G1 X1 F200|X20 F50|F200|X30'),
        ("G1 X1 F200.|X20 FB=50|X30", "G1 X1 F200.|X20 F50|F200.|X30"),
    ],
)
def test_the_feed_behind_fb_is_that_of_the_program(program, lines):
    assert text_of(program, "siemens") == lines.split("|")


@pytest.mark.parametrize("between", ["G4 F2", 'MSG("F9 X3 S7")', "G4 S30", "S2=500"])
def test_a_cycle_of_sinumerik_names_the_feed_of_the_program(between):
    """CYCLE85 with FFR 90 and RFF 80 leaves another feed than F200 behind it."""
    lines = holes(f"S100 M3\n{between}\nCYCLE85(10,0,2,-5,,,90,80)\nG1 X5\n")
    assert lines[2:] == ["G0 Z2.", "G1 F90. Z-5.", "G1 F80. Z2.", "G0 Z10.", "F200", "G1 X5"]


@pytest.mark.parametrize("between", ["G4 S30", "S2=500", 'MSG("S7")'])
def test_the_spindle_turns_on_with_the_speed_of_the_program(between):
    lines = holes(f"S100 M3\n{between}\nCYCLE84(10,0,2,-5,,,3,,1.5,0,500,600)\n")
    assert "S100 M3" in lines[-2:]


def test_a_message_with_an_axis_letter_is_no_place_of_a_modal_hole():
    text = 'MCALL CYCLE81(10,0,2,-5)\nMSG("X5")\nX20\nMCALL\n'
    assert holes(text) == ['MSG("X5")', "X20", "G0 Z2.", "G1 Z-5.", "G0 Z10."]


@pytest.mark.parametrize("between", NOT_FEEDS)
def test_behind_a_hole_of_din_iso(between):
    lines = test_pole.plain(f"{ISO}G200 {DATA}|{between}|G01 X+10 Y+10 M99")
    assert lines[-1] == "G01 F200*"


@pytest.mark.parametrize("between", NOT_FEEDS)
def test_behind_a_corner_of_din_iso(between):
    lines = test_pole.plain(f"{ISO}{between}|G01 X+10 Y+0|G25 R2 F50|X+10 Y+20 M103 F30|X+20")
    assert lines[-2:] == ["X+10 Y+20 F200 M103 F30*", "X+20*"]


@pytest.mark.parametrize("between", [*NOT_FEEDS[1:], "L M140 MB MAX F750"])
def test_behind_a_hole_of_klartext(between):
    data = DATA.replace(" ", " ~|")
    lines = test_klartext.plain(
        f"L X+0 Y+0 Z+10 R0 F200|{between}|CYCL DEF 200 ~|{data}|L X+10 Y+10 M99|L X+20 M103 F30"
    )
    assert lines[-1] == "L X+20 F200 M103 F30"
