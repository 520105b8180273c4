"""CYCLE81 to CYCLE89 and MCALL of Sinumerik, by the sequences of the Programming
Guide Cycles."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

HEAD = "G17 G90 G0 X0 Y0 Z50\nF200\n"


def holes(text: str) -> list[str]:
    """What is written for a program, behind its head."""
    axes = tuple("XYZ")
    interpreter = Interpreter(
        dialects.load("siemens"), Setup(axes, least_increment=dict.fromkeys(axes, 0.001))
    )
    program = Program("MAIN.MPF", (HEAD + text).encode())
    return (
        b"".join(Written(program, interpreter, Limits(steps=1000, depth=8)))
        .decode()
        .splitlines()[2:]
    )


def test_a_call_alone_drills_where_it_stands():
    """Rapid to the reference plane and the safety clearance, feed to the depth, dwell, rapid to the
    retraction plane; G0 G1 are what they were."""
    assert holes("CYCLE81(10,0,2,-20)\nX5\n") == ["G0 Z2.", "G1 Z-20.", "G0 Z10.", "X5"]
    assert holes("G1 X1\nCYCLE82(10,0,2,,20,0.5)\nX5\n") == [
        "G1 X1", "G0 Z2.", "G1 Z-20.", "G4 F0.5", "G0 Z10.", "G1", "X5",
    ]  # fmt: skip
    assert holes("R1=-7\nG91\nCYCLE81(10,0,2,R1)\n")[1:] == [
        "G0 Z=AC(2.)",
        "G1 Z=AC(-7.)",
        "G0 Z=AC(10.)",
    ]


def test_a_modal_call_drills_behind_every_motion():
    text = "MCALL CYCLE81(10,0,2,-5)\nX10 Y10\nM8\nX20\nTRANS Z0\nMCALL\nX30\n"
    hole = ["G0 Z2.", "G1 Z-5.", "G0 Z10."]
    assert holes(text) == ["X10 Y10", *hole, "M8", "X20", *hole, "TRANS Z0", "X30"]


def test_deep_holes_go_in_strokes():
    """FDPR 5, then less by DAM 2 while that leaves more than DAM, then DAM; by VARI 1 out of the
    hole, and back to 0.6 mm above the bottom that was reached; by VARI 0 back by 1 mm to break the
    chip."""
    depths = [
        line for line in holes("CYCLE83(10,0,2,-12,,,5,2,0,0,1,1)\n") if line.startswith("G1")
    ]
    assert depths == ["G1 Z-5.", "G1 Z-8.", "G1 Z-10.", "G1 Z-12."]
    assert holes("CYCLE83(10,0,2,-12,,,7,0,0,0,1,1)\n") == [
        "G0 Z2.", "G1 Z-7.", "G0 Z2.", "G0 Z-6.4", "G1 Z-12.", "G0 Z10.",
    ]  # fmt: skip
    assert holes("CYCLE83(10,0,2,-12,,-7,,0,0,0,1,0)\n") == [
        "G0 Z2.",
        "G1 Z-7.",
        "G1 Z-6.",
        "G1 Z-12.",
        "G0 Z10.",
    ]


def test_reaming_has_feeds_of_its_own():
    assert holes("CYCLE85(10,0,2,-6,,0.5,100,300)\n") == [
        "G0 Z2.", "G1 F100. Z-6.", "G4 F0.5", "G1 F300. Z2.", "G0 Z10.", "F200",
    ]  # fmt: skip


def test_a_rigid_tap_is_g331_and_g332():
    """CYCLE84: the spindle stands at POSS, in by SST, dwell, out by SST1 (0: as in), and turns
    again as before, the way of SDAC. A lead below 0 turns to the left."""
    tap = ["G0 Z2.", "SPOS=90.", "G331 Z-10. K1.25 S500.", "G332 Z2. K1.25 S600.", "G0 Z5."]
    assert holes("S300 M3\nMCALL CYCLE84(5,0,2,-10,,,3,,1.25,90,500,600)\nX10\nMCALL\n")[1:] == [
        "X10", *tap, "S300 M3",
    ]  # fmt: skip
    assert holes("S300 M3\nG1 X1\nCYCLE84(5,0,2,,10,0.5,5,-8,,0,500,0,3,0,0,0,0,0)\n")[2:] == [
        "G0 Z2.", "SPOS=0.", "G331 Z-10. K-1.25 S500.", "G4 F0.5", "G332 Z2. K-1.25 S500.",
        "G0 Z5.", "M5", "G1",
    ]  # fmt: skip


def test_a_deep_tap_turns_back_on_its_own_helix():
    """CYCLE84, VARI 1: DAM 4 deeper each time, back by VRT 1.1 (0: 1 mm, not above RFP + SDIS);
    VARI 2: back to RFP + SDIS. All on one lead, so the thread is that of one stroke."""
    call = "S300 M3\nCYCLE84(5,0,2,-10,,0.5,3,,1.25,90,500,600,0,1,0,{})\n"
    assert holes(call.format("1,4,1.1"))[1:] == [
        "G0 Z2.", "SPOS=90.",
        "G331 Z-4. K1.25 S500.", "G4 F0.5", "G332 Z-2.9 K1.25 S600.",
        "G331 Z-8. K1.25 S500.", "G4 F0.5", "G332 Z-6.9 K1.25 S600.",
        "G331 Z-10. K1.25 S500.", "G4 F0.5", "G332 Z2. K1.25 S600.",
        "G0 Z5.", "S300 M3",
    ]  # fmt: skip
    back = [x.split()[1] for x in holes(call.format("2,5,")) if x.startswith("G33")]
    assert back == ["Z-5.", "Z2.", "Z-10.", "Z2."]
    back = [x.split()[1] for x in holes(call.format("1,8,")) if x.startswith("G33")]
    assert back == ["Z-8.", "Z-7.", "Z-10.", "Z2."]
    back = [x.split()[1] for x in holes(call.format("1,8,20")) if x.startswith("G33")]
    assert back == ["Z-8.", "Z2.", "Z-10.", "Z2."]


def test_the_extended_cycles_of_autodesk_are_the_plain_ones():
    """siemens-840d.cps, "Extended cycles" (on by default in newer ones): the same holes as its
    shorter calls; a left-hand tap by AMODE, its lead positive too; PITA 1 is mm, 3 is inches."""
    for long, short in (
        ("CYCLE81(10,0,2,-20,,0,0,10)", "CYCLE81(10,0,2,-20)"),
        ("CYCLE82(10,0,2,-20,,0.5,0,0,10)", "CYCLE82(10,0,2,-20,,0.5)"),
        (
            "CYCLE83(10,0,2,-12,,-5,,0,0.5,0,1,1,,5,0,0,0,0,0,1001110)",
            "CYCLE83(10,0,2,-12,,-5,,0,0.5,0,1,1)",
        ),
        (
            "CYCLE83(10,1,2,-12,,-4,,0,,0,1,0,,5,0.4,0.5,0,0,0,1001110)",
            "CYCLE83(10,1,2,-12,,-4,,0,0,0,1,0,,,0.4,0.5)",
        ),
    ):
        assert holes(long + "\n") == holes(short + "\n") != []
    tap = "S300 M3\nCYCLE84(5,0,2,-10,,0,3,,1.25,0,500,500,0,1,,0,,,,,,0,0,{})\n"
    right, left = (holes(tap.format(mode)) for mode in (1001002, 1002002))
    assert right == holes("S300 M3\nCYCLE84(5,0,2,-10,,0,3,,1.25,0,500,500)\n")
    assert left == [x.replace("K1.25", "K-1.25") for x in right] != right
    inch = "G70\n" + tap.format(1001002).replace("0,1,,0", "0,3,,0").replace("1.25", ".05")
    assert [x for x in holes(inch) if x.startswith("G331")] == ["G331 Z-10. K0.05 S500."]


def test_a_boring_bar_is_lifted_off_and_comes_back_above_the_hole():
    """CYCLE86: RPA along X, RPO along Y, RPAP along Z, as distances."""
    assert holes("CYCLE86(5,0,2,-10,,0.5,3,-0.2,0.1,0.3,45)\n") == [
        "G0 Z2.", "M3", "G1 Z-10.", "G4 F0.5", "SPOS=45.", "G0 X=IC(-0.2) Y=IC(0.1) Z=IC(0.3)",
        "G0 Z2.", "G0 X=IC(0.2) Y=IC(-0.1) Z5.",
    ]  # fmt: skip


def test_holes_out_by_hand_and_by_feed():
    assert holes("CYCLE87(5,0,2,-10,,4)\n") == [
        "G0 Z2.", "M4", "G1 Z-10.", "M5", "M0", "G0 Z5.",
    ]  # fmt: skip
    assert holes("CYCLE88(5,0,2,-10,,0.5,3)\n") == [
        "G0 Z2.", "M3", "G1 Z-10.", "G4 F0.5", "M5", "M0", "G0 Z5.",
    ]  # fmt: skip
    assert holes("CYCLE89(5,0,2,-10,,0.5)\n") == [
        "G0 Z2.", "G1 Z-10.", "G4 F0.5", "G1 Z2.", "G0 Z5.",
    ]  # fmt: skip


def test_a_factor_of_deep_holes_goes_down_to_the_least_stroke():
    """FDPR 5, then 0.8 of the stroke before, 3 at least: 5, 9, 12.2, 15.2 and the bottom; FRF is a
    part of F200 for the first one, DTD the dwell at the bottom in the place of DTB."""
    made = holes("CYCLE83(10,0,2,-16,,,5,-0.8,1,0,0.5,1,3,3,,2)\n")
    assert [x for x in made if x[:2] in ("G1", "F2")] == [
        "G1 F100. Z-5.", "F200", "G1 Z-9.", "G1 Z-12.2", "G1 Z-15.2", "G1 Z-16.",
    ]  # fmt: skip
    assert [x for x in made if x.startswith("G4")] == ["G4 F1."] * 4 + ["G4 F2."]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("CYCLE84(5,0,2,-10,,,3,,1,0,500)", "no S is in force"),
        ("CYCLE84(5,0,2,-10,,,,,1,0,500)", "without SDAC"),
        ("CYCLE84(5,0,2,-10,,,3,,,0,500)", "without PIT or SST"),
        ("CYCLE84(5,0,2,-10,,,3,13,,0,500)", "no metric thread"),
        ("CYCLE83(10,0,2,-12,,-5,,1,0,0,1,1,,2,0,0,0,0,0,1001110)", "in a way that is not"),
        ("CYCLE83(10,0,2,-12,,-5,,0,0,0,1,1,,5,0,0,0,0,0,1011110)", "in a way that is not"),
        ("CYCLE81(10,0,2,-20,,0,0,10,2)", "in a way that is not written out"),
        ("CYCLE84(5,0,2,-10,,0,3,,1,0,500,500,0,3,,0)", "in a way that is not written out"),
        ("CYCLE84(5,0,2,-10,,,3,,1,0,500,,,0,1)", "in a way that is not written out"),
        ("CYCLE84(5,0,2,-10,,,3,,1,0,500,,,0,0,1,0.0001)", "more than 10000 strokes"),
        ("CYCLE86(5,0,2,-10,,,7)", "by SDIR = 7"),
        ("CYCLE83(10,0,2,-5,,,2,,,,2)", "FRF of CYCLE83"),
        ("CYCLE81(10,0,2)", "without DP and DPR"),
        ("CYCLE81(,0,2,-5)", "without RTP"),
        ("CYCLE81(1,0,2,-5)", "not in order"),
        ("CYCLE82(10,0,2,-5,,,1)", "in a way that is not written out"),
        ("CYCLE83(10,0,2,-5,,,9)", "not within the hole"),
        ("CYCLE83(10,0,2,-5,,,2,-0.5)", "the factor DAM"),
        ("CYCLE81(1,2,3,4,5,6,7,8,9,10)", "takes 9 values"),
        ('CYCLE81("A")', "is no number"),
        ("MCALL POCKET4(1)", "MCALL can not be written out"),
    ],
)
def test_what_can_not_be_written_out_is_said(call, message):
    with pytest.raises(ProgramError, match=message):
        holes(call + "\nX1\n")


def test_a_hole_within_a_frame_is_drilled_in_its_coordinates():
    """SCALE doubles the clearance 2 and the depth -20; ROT X30 leans the way down by Y sin 30 and Z
    cos 30 of the 22 mm."""
    made = holes("SCALE X2 Y2 Z2\nG1 X1 Y1 Z20\nCYCLE81(10,0,2,-20)\n")
    assert made[-4:] == ["G0 Z4.", "G1 Z-40.", "G0 Z20.", "G1"]
    down = holes("ROT X30\nG1 X1 Y1 Z20\nCYCLE81(10,0,2,-20)\n")[-4:-2]
    (y, z), (deep_y, deep_z) = ([float(w[1:]) for w in line.split()[1:]] for line in down)
    assert (deep_y - y, deep_z - z) == pytest.approx((11.0, -22 * 3**0.5 / 2), abs=1e-5)


def patterns(call, before="MCALL CYCLE81(10,0,2,-5)\n"):
    """The places at which the holes of a pattern are drilled."""
    return [line for line in holes(f"{before}{call}\n") if line.startswith("G0 X")]


@pytest.mark.parametrize(
    ("call", "places"),
    [
        # 5, 15 and 25 mm from (10, 20) along 30 degrees, sin 30 = 0.5: the tool stands nearer to
        # the first hole
        ("HOLES1(10,20,30,5,10,3)", [(14.3301, 22.5), (22.9904, 27.5), (31.6506, 32.5)]),
        ("HOLES1(90,0,180,10,20,3)", [(40, 0), (60, 0), (80, 0)]),  # from its nearer end
        ("HOLES2(50,60,20,0,0,4)", [(70, 60), (50, 80), (30, 60), (50, 40)]),
        ("HOLES2(50,60,20,90,-45,2)", [(50, 80), (64.1421, 74.1421)]),
        ("CYCLE801(1,2,90,10,20,2,2)", [(1, 2), (1, 12), (-19, 12), (-19, 2)]),
        ("CYCLE802(111111111,111111111,1,2,3,4)", [(1, 2), (3, 4)]),
    ],
)  # fmt: skip
def test_patterns_drill_at_their_places(call, places):
    found = [tuple(float(w[1:]) for w in line.split()[1:]) for line in patterns(call)]
    assert found == [pytest.approx(place, abs=1e-3) for place in places]


def test_a_pattern_gives_back_the_motion_code():
    made = holes(
        "G1 X1\nMCALL CYCLE81(10,0,2,-5)\nHOLES2(0,0,10,0,0,2)\nG91\nHOLES2(5,0,9,0,0,1)\n"
    )
    hole = ["G0 Z2.", "G1 Z-5.", "G0 Z10."]
    assert [line for line in made if line != "G0"] == [
        "G1 X1", "G0 X10. Y0.", *hole, "G0 X-10. Y0.", *hole, "G1", "G91", "G0 X=AC(14.) Y=AC(0.)",
        *("G0 Z=AC(2.)", "G1 Z=AC(-5.)", "G0 Z=AC(10.)", "G1"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("HOLES1(0,0,0,5,10)", "HOLES1 without NUM"),
        ("HOLES1(0,0,0,5,10,2.5)", "NUM of HOLES1 is 2.5"),
        ("HOLES1(0,0,0,5,10,99999)", "NUM of HOLES1 is 99999"),
        ("HOLES1(1,2,3,4,5,6,7,8,9,10,11,12)", "takes 11 values"),
        ('HOLES2(0,0,"A",0,0,2)', "is no number"),
        ("HOLES2(0,0,-5,0,0,2)", "RAD of HOLES2 is -5"),
        ("HOLES2(0,0,5,0,0,2,10)", "in a way that is not written out"),
        ("CYCLE801(0,0,0,1,1,500,500)", "250000 holes in CYCLE801"),
        ("CYCLE801(0,0,0,1,1,2,2,1)", "in a way that is not written out"),
        ("CYCLE802(111111112,111111111,1,2)", "in a way that is not written out"),
        ("CYCLE802(111111111,111111111,1)", "has one coordinate"),
        ("CYCLE802(111111111,111111111)", "without a place"),
        ("DIAM90\nHOLES1(0,0,0,5,10,2)", "in diameters"),
        ("MCALL\nHOLES1(0,0,0,5,10,2)", "no MCALL is in force here"),
    ],
)
def test_patterns_that_are_not_written_out(call, message):
    with pytest.raises(ProgramError, match=message):
        patterns(call)


def test_a_tap_with_a_chuck_stays_at_its_place():
    """CYCLE840 begins and ends at RTP: written before and behind it, where its axis stands is
    known; the values of its call are numbers."""
    tap = ["G0 Z10.", "CYCLE840(10,0,2,-15,,0.5,4,3,1,,1.25)", "G0 Z10."]
    call = "CYCLE840(10,0,2,R1,,0.5,4,3,1,,1.25)"
    assert holes(f"R1=-15\nG1 X1\n{call}\nX5\n") == ["G1 X1", *tap, "G1", "X5"]
    assert holes(f"R1=-15\nMCALL {call}\nX5\nX6\nMCALL\n") == ["X5", *tap, "X6", *tap]
    with pytest.raises(ProgramError, match="not in order"):
        holes("CYCLE840(10,0,2,15)")


@pytest.mark.parametrize("code", ["G0", "G1", "G91 G1"])
@pytest.mark.parametrize("call", ["{}|X5", "MCALL {}|X5|X6|MCALL"])
def test_a_tap_that_was_written_out_stays_as_it_is(code, call):
    """CYCLE840 between its own two levels gets no others; with one of them alone it does."""
    tap = "CYCLE840(10,0,2,-15,,0.5,4,3,1,,1.25)"
    once = holes(f"{code} X1|Z3|{call}|X7|".format(tap).replace("|", "\n"))
    assert tap in once
    assert holes("\n".join(once) + "\n") == once
    high = "G0 Z10."
    assert holes(f"{high}\n{tap}\nX5\n") == [high, high, tap, high, "X5"]
    assert holes(f"{tap}\n{high}\nX5\n") == [high, tap, high, high, "X5"]
    assert holes(f"{high}\n{tap}\n{high}\nX5\n") == [high, tap, high, "X5"]


@pytest.mark.parametrize(
    "call", ["CYCLE840(10,0,2,-15)", "CYCLE81(10,0,2,-15)", "MCALL CYCLE81(10,0,2,-15)"]
)
def test_a_hole_behind_a_line_that_can_not_be_followed_names_it(call):
    with pytest.raises(ProgramError, match="a line before this one can not be followed: two codes"):
        holes(f"G1 X1 F100\nDIAMOF DIAMON\n{call}\nX5\n")


def test_a_threading_cycle_stays():
    text = 'R1=2\nCYCLE97(R1,,-3.5,-31.708,40,40,4,0,1.227,0,30,0,10,1,3,1)\nCYCLE99(,"A",3)\nX5\n'
    assert holes(text) == [
        "CYCLE97(2,,-3.5,-31.708,40,40,4,0,1.227,0,30,0,10,1,3,1)", 'CYCLE99(,"A",3)', "X5",
    ]  # fmt: skip


COARSE = [  # ISO 261, coarse pitches of the first choice and those of M7, M9, M11, M14 and so on
    (3, "0.5"), (4, "0.7"), (5, "0.8"), (6, "1."), (7, "1."), (8, "1.25"), (9, "1.25"), (10, "1.5"),
    (11, "1.5"), (12, "1.75"), (14, "2."), (16, "2."), (18, "2.5"), (20, "2.5"), (22, "2.5"),
    (24, "3."), (27, "3."), (30, "3.5"), (33, "3.5"), (36, "4."), (39, "4."), (42, "4.5"),
    (45, "4.5"), (48, "5."),
]  # fmt: skip


@pytest.mark.parametrize(("size", "pitch"), COARSE)
def test_a_thread_by_its_size_has_the_coarse_pitch(size, pitch):
    """CYCLE84, MPIT: the nominal diameter of a metric thread, 3 to 48."""
    made = holes(f"S300 M3\nG1 X1\nCYCLE84(5,0,2,-10,,0,3,{size},,0,500,500)\n")
    assert f"G331 Z-10. K{pitch} S500." in made


@pytest.mark.parametrize("call", ["CYCLE81(60,40,2,20)", "CYCLE84(60,40,2,20,,,3,,1.5,0,500,600)"])
@pytest.mark.parametrize("mode", ["DIAMON", "DIAM90"])
def test_holes_along_a_diameter_are_refused(mode, call):
    """Whether SDIS and the planes are diameters then is in no manual that was found."""
    with pytest.raises(ProgramError, match="along X in diameters"):
        holes(f"S100 M3\nG19\n{mode}\n{call}\n")
    assert "G0 X42." in holes("S100 M3\nG19\nCYCLE81(60,40,2,20)\n")
