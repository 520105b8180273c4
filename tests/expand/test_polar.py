"""@ and ^ against LinuxCNC's interpreter."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import ours
from tests.linuxcnc.test_expanded import written_out

PROGRAMS = {
    "one after another": "F100 G1 X3 Y4|@10 ^90|^0|@2 (at @3)|^[2*45] ; ^5",
    "G91": "F100 G1 X3 Y4|G91 @5 ^90|@1|^-90|X1|@-1 ^-5",
    "G91 in the line, spaces": "F100 G1 X3 Y4|G91 G1 @ 5 ^ 9 0|G90 @1.5^5Z2",
    "diameter": "G7 F100 G1 X6 Y4|@5 ^10|^20|G91 ^20|X2|G8 G90 @3 ^1",
    "an arc": "F100 G0 @5 ^45 Z3|G2 @5 ^90 I-3.5355339 J-3.5355339",
    "G92": "G92 X1 Y1|G0 @5 ^45|^90|G52 X3|@2",
    "a cycle": "S100 M3 F100 G81 @5 ^45 Z-1 R1|^90|G80 G0 @1",
    "turned, both named": "G10 L2 P1 R30|G0 @5 ^0|@5 ^10",
    "inch, both named": "G0 X1 Y5|G20 @3 ^5|^10",
    "a radius below 0": "G0 X1 Y5|@-3 ^5|^0",
    "a loop": "#1=0|F100|O1 while [#1 LT 360]|G1 @[5+#1/100] ^#1|#1=[#1+40]|O1 endwhile",
}


def text_of(program: str) -> str:
    return program.replace("|", "\n") + "\nM2\n"


@pytest.mark.parametrize("name", PROGRAMS)
def test_places_are_linuxcncs(name):
    if reason := oracle.available():
        pytest.skip(reason)
    text = text_of(PROGRAMS[name])
    theirs = [
        m
        for m in oracle.motions(text)
        if max(abs(a - b) for a, b in zip(m.start, m.end, strict=True)) > 1e-9
    ]
    mine = ours(written_out(text, {}), {})
    assert not any(m["reason"][0] for m in mine)
    assert [m["end"][:3] for m in mine] == [pytest.approx(m.end[:3], abs=1e-8) for m in theirs]


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("G1 X1 @5 F100", "@ or ^ beside X or Y"),
        ("G18|G0 @5 ^10", "outside of G17"),
        ("G53 G0 @5 ^0", "or with G53"),
        ("G92 @5 ^0", "no motion"),
        ("G0 X0 Y0|@1", "@ without ^, and the tool stands at the zero"),
        ("G10 L2 P1 R30|G0 @5 ^0|^10", "a turned zero"),
        ("G0 @5 @6 ^1", "stands twice"),
    ],
)
def test_what_linuxcnc_refuses_is_refused(program, says):
    with pytest.raises(ProgramError, match=says.replace("^", r"\^")):
        written_out(text_of(program), {})
