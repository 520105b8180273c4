"""Fagor and Okuma mills: their own words, by the pages of their manuals and by what Autodesk's
posts write."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.offsets import canonical
from postproc.units import TICKS_PER_MM
from tests.expand.plain_lines import text_of

SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    start=dict.fromkeys("XYZ", 0.0),
    offsets={
        "G54": {"X": 100.0},
        "D1": {},
        "D2": {"Z": 50.0},
        "G15 H1": {"X": 100.0},
        "G15 H12": {"X": 7.0},
        "H3": {"Z": 9.0},
    },
)


def follow(text: str, name: str):
    """Ends of the motions (mm, machine coordinates), and why they can not be followed."""
    dialect = dialects.load(name)
    interpreter = Interpreter(dialect, SETUP)
    words = lex(text.replace("|", "\n").encode() + b"\n", dialect.grammar, False)
    assert words.fault is None, words.fault
    motions, _, _ = interpreter.run(words, interpreter.initial())
    return (motions.target / TICKS_PER_MM).tolist(), [motions.reasons[r][0] for r in motions.reason]


def test_fagor_has_inches_by_g70_and_lengths_by_d():
    ends, reasons = follow(
        "%PART,MX--,|; A PART|G70 G90 G54 D1|G0 X1 Y0 Z1|G71 X5 (M30 here)|T2 D2 M6|G0 Z1", "fagor"
    )
    assert not any(reasons)
    assert ends[0] == pytest.approx([125.4, 105.0, 105.0])
    assert ends[2] == pytest.approx([25.4, 25.4, 51.0])


def test_fagors_mcs_is_a_block_in_machine_coordinates():
    ends, reasons = follow("G71 G90 G54 D2|G0 X1 Y2 Z3|#MCS G0 X5|#MCS OFF|G0 X1", "fagor")
    assert not any(reasons)
    assert ends[0] == pytest.approx([101.0, 5.0, 101.0])


def test_fagors_arcs_are_those_of_its_manual():
    """CNC 8055 M & EN programming manual, page 90: from X60 Y40, by I J and by R; with G54 at
    X100."""
    dialect = dialects.load("fagor")
    interpreter = Interpreter(dialect, SETUP)
    both = []
    for arcs in (
        "G90 G17 G03 X110 Y90 I0 J50\nX160 Y40 I50 J0\n",
        "G90 G17 G03 X110 Y90 R50\nX160 Y40 R50\n",
    ):
        words = lex(b"G71 G0 X60 Y40 Z0\n" + arcs.encode(), dialect.grammar, False)
        motions, _, _ = interpreter.run(words, interpreter.initial())
        assert not motions.reason.any()
        both.append(motions.arcs)
    assert both[0].centre == pytest.approx(both[1].centre, abs=1e-6)
    assert both[0].centre[:2].T.tolist() == [
        pytest.approx([160.0, 90.0]),
        pytest.approx([260.0, 90.0]),
    ]


@pytest.mark.parametrize(
    "line",
    [
        "G1 R10 Q30",
        "Q30",
        "(P1=3)",
        "(RPT N1,N2)",
        "#RTCP ON",
        "#CS X0 Y0 Z0 RX10 RY0 RZ0",
        "P100=500",
        "$IF P1 EQ 2",
        "#CALL L100",
        "#MCS ON",
        "#FOO 3",
        "G2 G6 X1 Y1 I3 J4",
        "G1 G36 R5 X10",
        "G8 X5 Y5",
        "G58",
        "G159 N3",
        "G82 X1 Z2 I-3",
    ],
)
def test_what_fagor_has_of_its_own_is_refused(line):
    _, reasons = follow(f"G71 G90 G54 D1|G0 X1 Y1 Z1|{line}|G1 X5 Y5 Z5", "fagor")
    assert any(reasons[1:])


def test_what_moves_nothing_on_fagor_passes():
    lines = (
        '#MSG["X5"]|#HSC ON [CONTERROR 0.01]|#HSC OFF|#KIN ID[1]|#RTCP OFF|#CS OFF|G51 A45'
        " E0.002|G61|; X5 (RPT N1,N2)"
    )
    ends, reasons = follow(f"G71 G90 G54 D1|G0 X1 Y1 Z1|{lines}|G1 X5", "fagor")
    assert not any(reasons) and len(ends[0]) == 2


def test_fagors_holes_have_z_as_reference_plane_and_i_as_bottom():
    """Page 162: G98 to the initial plane, G99 to the reference plane; without Z that is where the
    tool stands; in G91 Z counts from the initial plane and I from the reference plane."""
    lines = text_of("G90 G17 G0 X0 Y0 Z15|G98 G81 X10 Y5 Z2 I-10 K0.5 F100|X20|G80|G0 Z9", "fagor")
    hole = ["Z2.", "G1 Z-10.", "G4 K0.5", "G0 Z15."]
    assert lines[1:] == ["G98 G0 X10 Y5 F100", *hole, "G0 X20", *hole, "G80", "G0 Z9"]
    assert text_of("G0 Z15|G99 G85 X1 I-10|G80", "fagor")[1:] == [
        "G99 G0 X1",
        "G1 Z-10.",
        "Z15.",
        "G80",
    ]
    lines = text_of("G0 Z15|G91 G98 G81 X1 Z-13 I-12|G80", "fagor")
    assert lines[1:] == ["G91 G98 G0 X1", "Z-13.", "G1 Z-12.", "G0 Z25.", "G80"]


def test_fagors_g83_makes_j_pecks_of_i():
    """As `fagor.cps` writes it: (retract - bottom) / plunges, with a minus, in G90."""
    lines = text_of("G90 G0 Z15|G98 G83 X1 Z2 I-3 J2|G80", "fagor")
    assert lines[1:] == [
        "G98 G0 X1",
        "Z2.",
        "G1 Z-1.",
        "G0 Z2.",
        "Z-0.5",
        "G1 Z-4.",
        "G0 Z15.",
        "G80",
    ]


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("G83 X1 Z2 I-3|G80", "G83 without J"),
        ("G81 X1 Z2 I-3|X2 Z3|G80", "Z3 in a block within G81 that does not name it"),
        ("G81 X1 Z2 I-3|G0 X2", "a motion code within a cycle"),
        ("G81 X1 Z2 I-3|G80|X5", "no motion code is named behind the cycle"),
        ("G81 X1 Z2 R1|G80", "R1 in|R in a drilling cycle"),
    ],
)
def test_what_is_not_certain_of_fagors_holes_is_refused(program, message):
    with pytest.raises(ProgramError, match=message):
        text_of("G90 G0 Z15|" + program, "fagor")


def test_okuma_has_its_work_offsets_by_g15_h_and_lengths_by_g56_h():
    ends, reasons = follow(
        "OPART1|N1 G21 G90 G15 H01|G0 X1 Y2|G56 H3 Z5|G15 H12 G0 X1|G53 G0 Z5", "okuma"
    )
    assert not any(reasons)
    assert ends[0] == pytest.approx([101.0, 101.0, 8.0, 8.0])
    assert ends[2] == pytest.approx([0.0, 14.0, 14.0, 5.0])
    assert [canonical(x) for x in ("G15H1", "g15 h012", "G54.1 P3")] == [
        "G15 H1",
        "G15 H12",
        "G54.1 P3",
    ]


def test_to_the_end_of_its_travel_okumas_axes_go_unknown():
    _, reasons = follow("G21 G15 H1 G90|N12 G00 Z9999.|G0 X1|X9999. Y9999.|N7 Z400.", "okuma")
    dialect = dialects.load("okuma")
    interpreter = Interpreter(dialect, SETUP)
    words = lex(b"G21 G15 H1\nN12 G00 Z9999.\nG0 X1\n", dialect.grammar, False)
    _, state, _ = interpreter.run(words, interpreter.initial())
    assert state.known.tolist() == [True, False, False] and not any(reasons)


@pytest.mark.parametrize(
    "line",
    [
        "VC1=5",
        "CALL O123",
        "CALL OO88 HH=1",
        "PF1=200",
        "G16 H0",
        "G11 X0 Y0 P30",
        "G169 X0 Y0 Z0 H1",
        "G605 X1",
        "G92 X0",
        "G54 H1",
        "GOTO N5",
        "VZOFX[20]=0.",
    ],
)
def test_what_okuma_has_of_its_own_is_refused(line):
    _, reasons = follow(f"G21 G90 G15 H1|G0 X1 Y1 Z1|{line}|G1 X5 Y5 Z5", "okuma")
    assert any(reasons[1:])


def test_okumas_holes_go_back_to_the_level_of_g71_by_m53_and_to_r_by_m54():
    """As `okuma.cps` writes them: G71 Z, M53 in the cycle's block, P in milliseconds where F of G4
    is seconds."""
    head = "G90 G0 X0 Y0 Z50.|"
    lines = text_of(head + "G71 Z15.|G82 X10. Z-9. R2. P500 F300. M53|X20.|G94|G0 Z15.", "okuma")
    assert lines[1:] == [
        "G0 X10. F300.",
        "Z2.",
        "G1 Z-9.",
        "G4 F0.5",
        "G0 Z15.",
        "G0 X20.",
        "Z2.",
        "G1 Z-9.",
        "G4 F0.5",
        "G0 Z15.",
        "G94",
        "G0 Z15.",
    ]
    assert text_of(head + "G81 X10. Z-9. R2. M54|G0 X1.", "okuma")[1:] == [
        "G0 X10.",
        "Z2.",
        "G1 Z-9.",
        "G0 Z2.",
        "G0 X1.",
    ]
    lines = text_of(head + "G73 X10. Z-9. R1. I3. J6. M54|G0 X1.", "okuma")
    assert lines[1:] == [
        "G0 X10.",
        "Z1.",
        "G1 Z-2.",
        "G0 Z-1.5",
        "G1 Z-5.",
        "G0 Z1.",
        "Z-4.5",
        "G1 Z-8.",
        "G0 Z-7.5",
        "G1 Z-9.",
        "G0 Z1.",
        "G0 X1.",
    ]


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("G81 X1. Z-9. R2.", "G81 without M53 or M54"),
        ("G81 X1. Z-9. R2. M52", "G81 without M53 or M54"),
        ("G81 X1. Z-9. R2. M53", "none was named"),
        ("G71", "G71 without Z"),
        ("G91 G71 Z5.", "G71 Z in G91"),
    ],
)
def test_where_an_okuma_goes_back_must_stand_in_the_program(program, message):
    with pytest.raises(ProgramError, match=message):
        text_of("G90 G0 Z50.|" + program, "okuma")


@pytest.mark.parametrize(
    ("text", "name"), [('name = "warm"', "name"), ("NAME = 5", "NAME"), ("= 5", "="), ("= ", "=")]
)
def test_a_text_behind_an_equals_sign_is_refused_by_its_name(text, name):
    interpreter = Interpreter(dialects.load("okuma"), SETUP)
    words = lex(f"G21 G90 G15 H1\n{text}\nG0 X1\n".encode(), interpreter.dialect.grammar, False)
    motions, _, _ = interpreter.run(words, interpreter.initial())
    assert [r[0] for r in motions.reasons if r[0]] == [f"{name} can not be followed"]
