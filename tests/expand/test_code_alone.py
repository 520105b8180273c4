"""Comments, strings and the times of dwells are no words of the program where it is written out,
and no limits of the spindle are its speed."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup

EDGES = {"T1D2": {"R": 2.0}, "T2D1": {"R": 5.0}, "T2D2": {"R": 1.0}}
POCKET = "POCKET4(10,0,2,-6,12,75,40,3,0,0,400,150,0,1,6,,,3,2)"
BORE = "CYCLE85(10,0,2,-6,,0,100,300)"
TAP = "CYCLE84(10,0,2,-6,,0,3,,1,0,200,300)"
START = "G17 G90 G94 G0 X0 Y0 Z50"


def written(text: str, dialect: str = "siemens", offsets: dict | None = None) -> list[str]:
    """A program with | between its lines, written out."""
    axes = ("X", "Y", "Z")
    setup = Setup(
        axes, least_increment=dict.fromkeys(axes, 1e-3), offsets={"G54": {}, **(offsets or {})}
    )
    program = Program("A", text.replace("|", "\n").encode() + b"\n")
    lines = Written(program, Interpreter(dialects.load(dialect), setup), Limits(steps=99, depth=8))
    return b"".join(lines).decode().splitlines()


@pytest.mark.parametrize(
    ("tools", "radius"),
    [
        ("T1 D2|G1 X1 F9|T2", 5.0),  # a new tool comes with D1
        ("T1 D2|G1 X1 F9|T2 D2", 1.0),
        ("T1 D2 M6|G1 X1 F9|T2 M6", 5.0),
        ("T1 D2 M6|G1 X1 F9|T2", 2.0),  # made ready alone
    ],
)
def test_the_radius_of_a_pocket_is_that_of_the_tool_in_use(tools, radius):
    """By hand: the outer ring is at X75 less the pocket's 12 mm and the tool's radius."""
    lines = written(f"{START}|{tools}|{START}|S9 M3 F77|{POCKET}|M30", offsets=EDGES)
    x = [float(w[1:]) for line in lines[5:] for w in line.split() if w[0] == "X"]
    assert max(x) == pytest.approx(75 + 12 - radius, abs=1e-3)


def test_a_pocket_without_a_tool_is_refused():
    with pytest.raises(ProgramError, match="POCKET4 with D0"):
        written(f"T1|{START}|S9 M3 F77 D0|{POCKET}|M30", offsets={"D1": {"R": 1.0}})


@pytest.mark.parametrize(
    "before",
    [
        "F500|G4 F2",
        "F500|G04 F2 ; F3",
        "F20|F500",
        'F500|MSG("SCHLICHTEN F20")',
        "F500 ; F20",
        "F=500|G4 F=2",
        "F500|G26 S3000",
        'F500|T="F20"',
        'F500|MSG("A;B") ; F20',
    ],
)
def test_the_feed_behind_a_cycle_is_the_one_before_it(before):
    """CYCLE85 feeds by 100 and 300 mm/min; behind it the feed of the program holds again."""
    assert "F500" in written(f"{START}|{before}|{BORE}|X9|M30")[-3].split()


@pytest.mark.parametrize(
    "before",
    [
        "S1500 M3|G4 S3",
        "S1500 M3|G26 S3000",
        "S1500 M3|G25 S30",
        "S1500 M3|LIMS=2000",
        'S1500 M3|MSG("S2 = 80 S1")',
        "S1=1500 M1=3",
        "S1500 M3|S2=800 M2=4",
        "S1500 M3 ; S20",
    ],
)
def test_the_speed_behind_a_tapped_hole_is_the_one_before_it(before):
    assert "S1500 M3" in written(f"{START}|{before}|{TAP}|X9|M30")[-3:][0]


@pytest.mark.parametrize(
    ("turns", "code"),
    [("M3", "G3"), ("M4", "G2"), ("M1=4", "G2"), ("M1=3 M2=4", "G3"), ("M3|G4 S2", "G3")],
)
def test_the_sense_of_a_pocket_is_by_the_main_spindle(turns, code):
    """_CDIR 0 with M3 runs counter-clockwise inside, with M4 the other way round."""
    lines = written(f"{START}|T2 D1 S900 F77 {turns}|{POCKET}|M30", offsets=EDGES)
    found, other = {line[:2] for line in lines}, {"G2": "G3", "G3": "G2"}[code]
    assert (code in found, other in found) == (True, False)


@pytest.mark.parametrize(
    "line",
    ['MSG("LOCH 2: X20")', "; X20", "G4 F2", 'MSG("A ; X1")', "G26 X200 Y100", "S3 M3", "G58 X5"],
)
def test_a_line_that_moves_nothing_calls_no_hole(line):
    hole = "MCALL CYCLE81(10,0,2,-6)"
    lines = written(f"{START}|F9|{hole}|X5|{line}|MCALL|X9|M30")
    assert sum("Z-6" in text for text in lines) == 1


@pytest.mark.parametrize("motion", ["G0 AP=90 RP=20", "G3 I5 J0", "G3 AR=90 I5 J0", "X=IC(3)"])
def test_a_motion_without_an_axis_calls_the_hole(motion):
    """MCALL: behind every block with a motion ("Modal subroutine call"), whatever says its end."""
    lines = written(f"{START}|F9|G111 X0 Y0|MCALL CYCLE81(10,0,2,-6)|{motion}|MCALL|M30")
    assert sum("Z-6" in text for text in lines) == 1


def test_a_deleted_block_says_no_feed_and_calls_no_hole():
    setup = Setup(("X", "Y", "Z"), offsets={"G54": {}}, block_delete=True)
    text = f"{START}\nF500\n/F20\nMCALL {BORE}\nX5\n/X8\nMCALL\nM30\n"
    program = Program("A", text.encode())
    found = Written(
        program, Interpreter(dialects.load("siemens"), setup), Limits(steps=99, depth=8)
    )
    lines = b"".join(found).decode().splitlines()
    assert sum("F100" in line for line in lines) == 1 and "F20" not in lines[-4:]


@pytest.mark.parametrize(
    "name", ["TAP M2", "M30 TAP", "A;B", "Q5 X", "R=Q1", "1,5 X", "M30 ; Q1", "X+Q1"]
)
def test_a_tool_by_name_is_a_name(name):
    """Klartext: what stands between quotation marks ends no program and is no Q parameter."""
    lines = [f'TOOL CALL "{name}" Z S500', f'L Z+50 R0 FMAX ; "{name}" M30', "L X+1 F9"]
    text = "|".join(["BEGIN PGM A MM", *lines, "END PGM A MM"])
    assert written(text, "heidenhain")[1:-1] == lines


def test_a_comment_behind_a_name_keeps_its_text():
    text = 'BEGIN PGM A MM|Q5=+7|TOOL CALL "A;Q5" Z S+Q5 ; Q5 "x|L X+1,5 F9|END PGM A MM'
    assert written(text, "heidenhain")[2:4] == ['TOOL CALL "A;Q5" Z S+7 ; Q5 "x', "L X+1.5 F9"]


@pytest.mark.parametrize("remark", ["(cool) ", "(a) (b; c) ", "(M9) (S900)"])
def test_words_behind_a_comment_come_back(remark):
    """M72 brings speed and coolant back, wherever a comment stands."""
    found = [
        written(f"S800 M3|F9|M70|G1 X1|{word}|M72|G1 X2|M2", "linuxcnc")
        for word in (f"{remark}M8", "M8", f"{remark}S900 M4", "S900 M4")
    ]
    behind = [lines[lines.index("G1 X1") + 2 :] for lines in found]
    assert behind[0] == behind[1] != behind[2] == behind[3]


def test_a_comment_touches_nothing():
    assert written("M70|(costs $5) M8|M72|M2", "linuxcnc")[-2:] == ["M9", "M2"]


@pytest.mark.parametrize(
    ("modes", "factor"),
    [("DIAMON G90", 2), ("DIAMON G91", 2), ("DIAM90 G90", 2), ("DIAM90 G91", 1), ("DIAMOF", 1)],
)
def test_diam90_means_diameters_of_places_alone(modes, factor):
    """Sinumerik 808D, turning (6FC5398-5DP10-0BA0), page 26."""
    tracker = Tracker(Interpreter(dialects.load("siemens"), Setup(("X", "Z"), start={"X": 7.0})))
    tracker.take(modes.encode())
    assert tracker.is_diameter("X") == (factor == 2)
    assert tracker.work("X") == 7.0 * (2 if "DIAMOF" not in modes else 1)


TEXTS = [
    "X10 RND=5",
    "CIP I1=3 X5",
    "POLY PO[X]=(1,2)",
    "TRANS X10",
    "ROT RPL=90",
    "BSPLINE",
    "M30",
]


@pytest.mark.parametrize(
    "text", [*TEXTS, "AP=10 RP=5", "CYCLE81(1,2,3,4)", "GOTOF A", "G91", "R1=5"]
)
@pytest.mark.parametrize("form", ['MSG("{}")', "; {}", 'MSG("A;B {}") ; {}'])
def test_a_remark_changes_nothing(text, form):
    """Every other line is written as without it."""
    body = f"{START}|G1 X1 F100|{{}}|X2 Y1|G2 X5 Y4 CR=2|G1 X6 RND=1|Y9|M30"
    line = form.replace("{}", text)
    found = written(body.replace("{}", line))
    assert [t for t in found if t != line] == written(body.replace("|{}", ""))


@pytest.mark.parametrize("name", ["TAP M4", "A;B", "M5", "DR3", "A ; M4"])
def test_a_bore_by_a_named_tool_is_that_of_its_number(name):
    """Cycle 208: the tool's radius with the DR of its call, the sense by M3: no name says it."""
    data = "Q200=+2 ~|Q201=-10 ~|Q206=+90 ~|Q334=+2.5 ~|Q203=+1 ~|Q204=+30 ~|Q335=+20 ~|Q342=+0 ~"
    text = (
        "BEGIN PGM A MM|L Z+60 R0 FMAX M3|TOOL CALL {} Z S900 DR+1|L X+40 Y+25 Z+60 R0 FMAX|"
        f"CYCL DEF 208 ~|{data}|Q351=+1|L X+50 FMAX M99|END PGM A MM"
    )
    radii = {"T9999": {"R": 3.0}, "T5": {"R": 3.0}}
    named, numbered = (
        written(text.format(tool), "heidenhain", radii) for tool in (f'"{name}"', "5")
    )
    assert named[3:] == numbered[3:] and len(named) > 15


@pytest.mark.parametrize(
    ("turns", "again"), [("M3", "M3"), ("M4", "M4"), ("M13", "M3"), ("M14", "M4")]
)
def test_a_bored_hole_starts_the_spindle_as_it_turned(turns, again):
    """G86 of a Fanuc mill stops the spindle at the bottom; M13 and M14 turn it with the coolant."""
    lines = written(f"G90 G17 G0 X0 Y0 Z9|S900 {turns}|G86 X1 Z-1 R1 F9|G80|M30", "fanuc-mill")
    assert lines[lines.index("M5") + 2 :][:1] == [again]
