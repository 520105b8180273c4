"""M70 to M73: what comes back, and what is refused because it is not known how."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import ours
from tests.linuxcnc.test_expanded import written_out

PROGRAMS = {
    "inches and back": "F100|G1 X1|M70|G20 F5|G1 X1|M72|G1 X2|#1=#<_feed>|G1 Y[#1/100]",
    "plane and arc centres": "F100|M70|G18 G90.1|G2 X2 Z0 I1 K0|M72|G2 X4 Y0 I1",
    "two levels": (
        "O1 sub|M70|G91 X1|O2 call|X1|M72|X9|O1 endsub|O2 sub|M73|G90 G20|X1|O2 endsub|F100 G1"
        " X5|O1 call|X2"
    ),
    "M73 and return": (
        "O1 sub|M73|G91|X1|O2 if [1]|O1 return|O2 endif|X5|O1 endsub|F100|G1 X5|O1 call|X1"
    ),
    "a sub leaves no M70": "O1 sub|M70|G91|O1 endsub|F100|G1 X5|O1 call|X1|G90 X1",
    "M71 forgets": "F100|M70|G91|G1 X1|M71|X1",
    "diameters": "F100|M70|G7|G1 X4|M72|G1 X4",
    "cycles return": "F100 S100 M3|G98|G0 Z9|M70|G99|G81 X1 Y1 Z-1 R1|M72|G81 X2 Y2 Z-1 R1|X3",
}


def text_of(program: str) -> str:
    return program.replace("|", "\n") + "\nM2\n"


@pytest.mark.parametrize("name", PROGRAMS)
def test_modes_come_back_as_on_linuxcnc(name):
    if reason := oracle.available():
        pytest.skip(reason)
    text = text_of(PROGRAMS[name])
    theirs = [m for m in oracle.motions(text) if m.start != m.end or m.kind == "arc"]
    mine = [m for m in ours(written_out(text, {}), {}) if not m["reason"][0]]
    assert [m["end"][:3] for m in mine] == [pytest.approx(m.end[:3], abs=1e-9) for m in theirs]


@pytest.mark.parametrize(
    ("program", "says"),
    [
        (
            "M70|M3 S500|M72",
            "M72 brings back what (S500|M3) has changed, and nothing said before what held",
        ),
        ("S9 M3|M70|S6 $0|M72", "M72 brings back what S6 has changed"),
        ("M70|G64 P.1|M72", "M72 brings back what G64 has changed"),
        ("M70|G92 Z5|M72", "M72 brings G92 or the tool length back"),
        ("M72", "M72, and no state is kept at this level of calls"),
        ("M70|M71|M72", "M72, and no state is kept at this level of calls"),
        ("M70 G91", "M70 beside other words"),
    ],
)
def test_what_is_not_known_to_come_back_is_refused(program, says):
    with pytest.raises(ProgramError, match=says):
        written_out(text_of(program), {})


@pytest.mark.parametrize(
    ("program", "back"),
    [
        ("S2500 M3 M8|M70|S300 M4|M9|M72", ["S2500", "M3", "M9", "M8"]),
        ("S2500|O1 sub|M73|S300|O1 endsub|O1 call", ["S2500"]),
        ("S2500 M3|M70|M5|M72|S9|M72", ["M3", "S9", "S2500"]),
        ("S 2 5 M03 M07 M08|M70|M9 M5 (S7)|M72", ["M3", "M9", "M7", "M8"]),
        ("S9 M3|M70|S9 M3|M72", []),
    ],
)
def test_speed_spindle_and_coolant_come_back_where_they_were_named(program, back):
    """LinuxCNC documentation, "M70 Save Modal State": F and S, M3 M4 M5, M7, M8 are among what is
    kept."""
    text = written_out(text_of(program), {})
    lines = [line for line in text.splitlines() if line.strip()]
    assert lines[-1 - len(back) : -1] == back
