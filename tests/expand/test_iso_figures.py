"""Bores, pockets, slots, studs and faces of Heidenhain's DIN/ISO go the ways of their Klartext,
whose figures are by hand (test_klartext*.py)."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from tests.expand import test_klartext, test_klartext_face, test_pole
from tests.expand.test_klartext import places

DEPTHS = "Q201=-9 Q202=+6 Q206=+150 Q200=+2 Q203=+1 Q204=+30"
DATA = {
    208: f"Q335=+30 Q334=+2 Q351=+1 {DEPTHS}",
    251: f"Q215=+0 Q218=+60 Q219=+40 Q220=+8 Q224=+20 Q367=+1 Q368=+0.3 Q369=+0.2 Q338=+5 "
    f"Q207=+500 Q351=+1 Q370=+1 Q366=+1 Q385=+400 {DEPTHS}",
    252: f"Q215=+1 Q223=+40 Q368=+0.3 Q369=+0 Q207=+500 Q351=-1 Q370=+1 Q366=+0 {DEPTHS}",
    253: f"Q215=+1 Q218=+60 Q219=+20 Q374=+30 Q367=+0 Q368=+0 Q369=+0 Q207=+500 Q351=+1 Q366=+2 "
    f"{DEPTHS}",
    256: f"Q218=+20 Q424=+26 Q219=+10 Q425=+16 Q220=+2 Q368=+0 Q224=+15 Q367=+0 Q207=+500 Q351=+1 "
    f"Q370=+1 Q437=+0 {DEPTHS}",
    257: f"Q223=+20 Q222=+30 Q368=+0 Q376=+0 Q207=+500 Q351=+1 Q370=+1 {DEPTHS}",
}
HEAD = "TOOL DEF 5 L+0 R+4|TOOL CALL 5 Z S1000|L X+50 Y+20 Z+40 R0 F900 M3|"
ISO = "G99 T5 L+0 R+4|T5 G17 S1000|G01 G40 G90 X+50 Y+20 Z+40 F900 M3|"


@pytest.mark.parametrize("cycle", DATA)
def test_the_ways_are_those_of_klartext(cycle):
    data = DATA[cycle].replace(" ", " ~|")
    klartext = test_klartext.plain(f"{HEAD}CYCL DEF {cycle} A ~|{data}|L X+60 Y+30 M99|L X+90")
    iso = test_pole.plain(f"{ISO}G{cycle} {DATA[cycle]}|G01 X+60 Y+30 M99|X+90")
    one, two = places(klartext[2:]), places(iso[2:])
    assert len(one) > 12
    assert one == two
    assert [line for line in iso if line.startswith("G01") and "F900" in line][-1] == "G01 F900*"


def test_a_face_is_that_of_klartext():
    head, _, data = test_klartext_face.FACE.partition("CYCL DEF 232 FACE ~|")
    data = data.partition("|CYCL CALL")[0].replace(" ~|", " ")
    klartext = test_klartext.plain(test_klartext_face.FACE.replace(" DR+1", ""))
    iso = test_pole.plain(
        f"G99 T5 L+0 R+9|T5 G17 S1000|G01 G40 G90 X+50 Y+20 Z+90 F900 M3|G232 {data}|G79|X+90"
    )
    assert places(klartext[2:]) == places(iso[2:])


def test_without_a_radius_it_is_asked_for():
    with pytest.raises(ProgramError, match="radius of the tool of cycle 252 is not stated"):
        test_pole.plain(ISO.replace(" R+4", "") + f"G252 {DATA[252]}|G79")
