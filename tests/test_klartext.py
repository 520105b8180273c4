"""Heidenhain Klartext in place: what its statements are read as, and that any cut of a program,
corrected, gives the same bytes and keeps the tolerance.

By hand from HEIDENHAIN's TNC 640 and iTNC 530 user's manuals, Klartext programming.
"""

from __future__ import annotations

import random
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from postproc.nc.interpreter import Interpreter
from postproc.nc.klartext import respelled
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM
from postproc.verify import Verifier
from tests.small_machines import write_mill

ROOT = Path(__file__).resolve().parents[1]
DIALECT = dialects.load("heidenhain")
SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    start=dict.fromkeys("XYZ", 0.0),
    offsets={"G54": {}, "T1": {}, "T5": {"Z": 50.0}, "G247 P2": {"X": 100.0}},
)
PART = """0 BEGIN PGM PART MM
1 BLK FORM 0.1 Z X+0 Y+0 Z-40
2 BLK FORM 0.2 X+100 Y+100 Z+0
3 * - SLOT
4 TOOL CALL 5 Z S3000 F500 DL+0.1 DR-0.05
5 L M140 MB MAX
6 L X+10 Y+5 R0 FMAX M3
7 L Z-20 FMAX M8
8 CYCL DEF 32.0 TOLERANCE
9 CYCL DEF 32.1 T0.01
10 L Z-80 F200
11 L X+150 Y-3.5
12 L IX-50.25 IZ+10 F AUTO M9
/ 13 L Y+40
14 CYCL DEF 7.0 DATUM SHIFT
15 CYCL DEF 7.1 X+5
16 L X+0 Y+0 Z-60 FMAX
17 TRANS DATUM RESET
18 L X+20 ; a remark, (L X+500)
19 L Z-1 R0 FMAX M91
20 L X+100 M30
21 END PGM PART MM
"""


def follow(text: str):
    """Ends of the motions (mm, machine coordinates), and why they can not be followed."""
    interpreter = Interpreter(DIALECT, SETUP)
    words = lex(text.replace("|", "\n").encode() + b"\n", DIALECT.grammar, False)
    assert words.fault is None, words.fault
    motions, _, _ = interpreter.run(words, interpreter.initial())
    ends = (motions.target.T / TICKS_PER_MM).round(9).tolist()
    return ends, [" ".join(motions.reasons[r]).strip() for r in motions.reason]


def corrected(folder: Path, text: bytes, cuts: list[int]) -> tuple[bytes, Verifier]:
    machine = read_machine(folder)
    offsets = {"G54": {"X": 10.0}, "T5": {"Z": 50.0}}
    filter_ = Filter(machine, DIALECT, setup_of(machine, offsets=offsets, block_delete=False))
    verifier = Verifier(filter_)
    edges = [0, *sorted(cuts), len(text)]
    out = b"".join(filter_.feed(text[a:b]) for a, b in zip(edges, edges[1:], strict=False))
    return out + filter_.finish(), verifier


def test_statements_are_words_of_the_same_length():
    code = respelled(PART.encode())
    assert len(code) == len(PART)
    assert [len(a) for a in code.split(b"\n")] == [len(a) for a in PART.encode().split(b"\n")]


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("L X+10 Y-5 Z+2 R0 F100 M3", [[10, -5, 2]]),
        ("7 L X10 FMAX|8 L IX-4 IY+.5 F200", [[10, 0, 0], [6, 0.5, 0]]),
        ("TOOL CALL 5 Z S100|L Z+1 FMAX", [[0, 0, 51]]),
        ("TOOL CALL 5 Z S100 DL+0.25 DR-1|L Z+1 FMAX", [[0, 0, 51.25]]),
        ("TOOL CALL 5 Z S100 DL+0.25|TOOL CALL 1 Z|L Z+1 FMAX", [[0, 0, 1]]),
        ("TOOL CALL 5 Z|L Z+1|L Z-2 R0 FMAX M91|L Z+3", [[0, 0, 51], [0, 0, -2], [0, 0, 53]]),
        ("BEGIN PGM A INCH|L X+1 FMAX", [[25.4, 0, 0]]),
        ("CYCL DEF 7.0 DATUM|CYCL DEF 7.1 X+5|CYCL DEF 7.2 Y+1|L X+1 Y+1", [[6, 2, 0]]),
        ("TRANS DATUM AXIS X+5 Z-1|L X+1 Z+1|TRANS DATUM RESET|L X+1", [[6, 0, 0], [1, 0, 0]]),
        ("CYCL DEF 247 PRESET ~|  Q339=+2 ;NUMBER|L X+1 Y+1", [[101, 1, 0]]),
        ("CYCL DEF 10.0 ROT|CYCL DEF 10.1 ROT+0|CYCL DEF 11.1 SCL 1|L X+1", [[1, 0, 0]]),
        ("FN 0: Q5 = +3|Q6 = Q5 * 2|LBL 1|L X+1 FQ5|LBL 0", [[1, 0, 0]]),
        ("PLANE RESET STAY|FUNCTION RESET TCPM|M129|L X+1", [[1, 0, 0]]),
        ("L Z+1|L Z+0 X+0 R0 FMAX M92|L X+2 Y+1 Z+3", [[0, 0, 1], [2, 1, 3]]),
        ("CYCL DEF9 .0 DWELL|CYCL DEF9.1 DWELL5|L X+1", [[1, 0, 0]]),
        ("STOP M8|M126|L M3|L X+1 R FMAX", [[1, 0, 0]]),
        ("TOOL CALL 5 Z SQ3 FQ4|L X+1", [[1, 0, 0]]),
        ("L X+1,5 Y-0,25 F90,5|L IX+0,125 FMAX", [[1.5, -0.25, 0], [1.625, -0.25, 0]]),
        # words whose question was passed over, in listings of TNC 151 to 355
        (
            "L X+20 Y+30 R F M|L R F M9|L Z-5 R0 F M3|L Z+1 F MAX M",
            [[20, 30, 0], [20, 30, -5], [20, 30, 1]],
        ),
        # the manual's examples: to the first point of the contour, from its last one
        (
            "L X+40 Y9|APPR LT X+20 Y+20 Z-10 LEN15 RR F1|L X+35 Y+35|DEP LCT X+10 Y+12 R+8 F1",
            [[40, 9, 0], [20, 20, -10], [35, 35, -10], [10, 12, -10]],
        ),
        (
            "APPR CT X+10 Y+20 CCA180 R+10 RR F100|L Y+35|DEP LN LEN+20 F100|L X+1 Y+2",
            [[10, 20, 0], [10, 35, 0], [1, 2, 0]],
        ),
        (
            "APPR LN IX+10 IY+20 LENQ3 RL FMAX|DEP CT CCA 180 R+8 Z+5|L X+1 Y+2 Z+3",
            [[10, 20, 0], [1, 2, 3]],
        ),
    ],
)
def test_places(text, ends):
    found, reasons = follow(text)
    assert found == ends
    assert not any(reasons)


def test_the_datum_in_force_is_g54_until_a_preset_is_chosen():
    interpreter = Interpreter(
        DIALECT, replace(SETUP, offsets={"G54": {"X": 30.0}, "G247 P2": {"X": 100.0}})
    )
    text = b"L X+1\nL X+2 FMAX M91\nL X+3\nCYCL DEF 247 PRESET ~\n  Q339=+2\nL X+4\nL X+5 M91\n"
    motions, _, _ = interpreter.run(lex(text, DIALECT.grammar, False), interpreter.initial())
    assert (motions.target[0] / TICKS_PER_MM).tolist() == [31.0, 2.0, 33.0, 104.0, 5.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("C X+5 Y+5 DR-", "--expand"),
        ("CP IPA+90 DR+", "--expand"),
        ("CALL LBL 5", "--expand"),
        ("CYCL CALL M3", "--expand"),
        ("L X+2 FMAX M99", "--expand"),
        ("FN 9: IF +Q1 EQU +2 GOTO LBL 1", "--expand"),
        ("CYCL DEF 7.1 IX+5", "--expand"),
        ("CYCL DEF 7.1 #3", "datum"),
        ("CYCL DEF 10.1 ROT+35", "turns"),
        ("CYCL DEF 8.1 X", "mirrors"),
        ("CYCL DEF 19.1 A+20 C+0", "tilted"),
        ("PLANE SPATIAL SPA+10 SPB+0 SPC+0 TURN", "tilted"),
        ("CYCL DEF 220 POLAR PATTERN ~", "--expand"),
        ("CYCL DEF 224 CODES ~", "the control's own"),
        ("TCH PROBE 411 DATUM ~", "measuring"),
        ("RND R5", "--expand"),
        ("APPR PLCT PR+1 PA+2 R5 RL", "--expand"),
        ("APPR LT X+1 Y+2 LEN5 R0", "write it out as L and CR"),
        ("APPR LT X+1 Y+2 LEN5", "write it out as L and CR"),
        ("APPR LN X+Q1 Y+2 LEN5 RL", "--expand"),
        ("APPR KL X+1 Y+2 RL", "the control's own"),
        ("HEAD OF THE TABLE", "--expand"),
        ("X+20 F100", "write L"),
        ("IZ-5", "write L"),
        ("FUNCTION TCPM F TCP", "moves the slides"),
        ("FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS", "moves the slides"),
        ("FUNCTION TCPM F CONT AXIS POS PATHCTRL AXIS", "moves the slides"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR", "moves the slides"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-CENTER", "moves the slides"),
        ("TOOL CALL 5 Y S100", "tool axis"),
        ("TOOL CALL S100 DL+1", "DL"),
        ("TOOL CALL 5 Z DL+Q3", "--expand"),
        ("L X+Q3 FMAX", "--expand"),
        ("CYCL DEF 7.1 X+Q3", "--expand"),
    ],
)
def test_what_moves_otherwise_is_refused_by_name(text, said):
    _, reasons = follow(f"L X+1|{text}|L X+9 Y+9 Z+9|L X+9.5")
    assert said in " ".join(reasons)
    assert text.split()[0] in " ".join(reasons) or "M99" in text


@pytest.mark.parametrize("two_way", [False, True])
def test_any_cut_gives_the_same_bytes_and_keeps_the_tolerance(tmp_path, two_way):
    folder, text = write_mill(tmp_path / "mill", two_way), PART.encode()
    whole, verifier = corrected(folder, text, [])
    assert verifier.passed, verifier.report()
    rng = random.Random(5)
    for _ in range(20):
        cuts = [rng.randrange(len(text)) for _ in range(rng.randint(1, 9))]
        assert corrected(folder, text, cuts)[0] == whole
    by_line = [m.end() for m in re.finditer(rb"\n", text)]
    assert corrected(folder, text, by_line)[0] == whole


@pytest.mark.parametrize("two_way", [False, True])
def test_the_corrections_are_those_of_the_same_program_of_linuxcnc(tmp_path, two_way):
    """Word for word, block for block: lines, rapids, a datum shift, M91."""
    klartext = (
        "L X+10 Y+5 Z-10 R0 FMAX|L Z-20 F200|L X+150 Y-3.5|L X+99.75|L Z-1 R0 FMAX M91|"
        "L X+20 Z-30 F100|CYCL DEF 7.1 X+5|L X+0 Y+0 FMAX|L X+80 F100|M30"
    )
    gcode = (
        "G0 X10 Y5 Z-10|G1 Z-20 F200|X150 Y-3.5|X99.75|G53 G0 Z-1|G1 X20 Z-30 F100|G52 X5|"
        "G0 X0 Y0|G1 X80 F100|M30"
    )
    machine = read_machine(write_mill(tmp_path / "mill", two_way))
    outputs = []
    for name, text in (("heidenhain", klartext), ("linuxcnc", gcode)):
        setup = setup_of(machine, offsets={"G54": {"X": 10.0, "Z": 2.0}})
        filter_ = Filter(machine, dialects.load(name), setup)
        out = filter_.feed(text.replace("|", "\n").encode() + b"\n") + filter_.finish()
        blocks = [
            {x: float(v) for x, v in re.findall(r"([XYZ])([-+]?[\d.]+)", line)}
            for line in out.decode().split("\n")
            if re.match("L |[GXYZ]", line) and "G52" not in line
        ]
        outputs.append(blocks)
    assert len(outputs[0]) > 15
    assert outputs[0] == outputs[1]


JOINED = """TOOL CALL 5 Z S3000
L X+4 Y+5 Z-20 R0 FMAX M3
APPR LT X+10 Y-20 LEN15 RL F200 M8
L X+10 Y+40
L X+170 Y+20
DEP LCT X+180 Y+5 R+16 F500
APPR LCT X+10 Y-20 R+5 RR F200
L X+10 Y+9
L X+170
DEP CT CCA90 R+8
L Z-35 FMAX
L X+4 Y+5 FMAX M30
"""


@pytest.mark.parametrize("two_way", [False, True])
def test_the_ways_to_and_from_a_contour_stay_whole(tmp_path, two_way):
    """No block of its own comes between a contour and APPR or DEP, however the map bends, and where
    DEP ends beside the contour by a radius nothing is made of X and Y."""
    folder, text = write_mill(tmp_path / "mill", two_way), JOINED.encode()
    whole, verifier = corrected(folder, text, [])
    assert verifier.passed, verifier.report()
    assert corrected(folder, text, [m.end() for m in re.finditer(rb"\n", text)])[0] == whole
    lines = [x for x in whole.decode().split("\n") if not x.startswith(";")]
    begin = next(i for i, x in enumerate(lines) if x.startswith("APPR"))
    own = [re.sub(r" ?[XYZ][-+][\d.]+", "", line) for line in lines[begin : begin + 8]]
    assert own == [
        *("APPR LT LEN15 RL F200 M8", "L", "L", "DEP LCT R+16 F500"),
        *("APPR LCT R+5 RR F200", "L", "L", "DEP CT CCA90 R+8"),
    ]
    assert "APPR LT X+10 Y-20 LEN15" not in lines[begin]


def test_a_decimal_comma_is_a_point_where_a_number_is_written(tmp_path):
    folder = write_mill(tmp_path / "mill", True)
    comma = b"L X+4,5 Y+5,25 Z-20 R0 FMAX ; 1,5\nL X+60,25 F90,5\n"
    with_commas, verifier = corrected(folder, comma, [])
    assert verifier.passed, verifier.report()
    with_points = corrected(folder, comma.replace(b",", b".").replace(b"; 1.5", b"; 1,5"), [])[0]
    assert with_commas.replace(b"F90,5", b"F90.5") == with_points
    assert b"; 1,5" in with_commas


def test_new_blocks_are_statements(tmp_path):
    """L, a sign before every number, FMAX for rapids; M9 at the last piece."""
    out = corrected(write_mill(tmp_path / "mill", True), PART.encode(), [])[0].decode()
    added = [line for line in out.split("\n") if re.match("/? ?L", line)]
    assert len(added) > 3
    for line in added:
        assert re.fullmatch(r"(/ )?L( [XYZ][-+]\d+\.\d+)+( FMAX)?( M9| M30)?", line), line
    assert not re.search(r"[XYZ]\d", "\n".join(out.split("\n")[3:])), "a number without its sign"
    assert "19 L Z-1 R0 FMAX M91" in out
    pieces = out[out.index("12 L") : out.index("/ 13")]
    assert pieces.count("M9") == 1
    assert pieces.rstrip().endswith("M9")


def test_new_words_are_set_off_where_the_program_writes_without_blanks(tmp_path):
    """LY+4.98 would be no statement: L stands alone."""
    text = b"L X+64 Y+5 Z+20 R0 FMAX\nL F100X+20\nM30\n"
    lines = corrected(write_mill(tmp_path / "mill", True), text, [])[0].split(b"\n")
    assert lines[2].startswith(b"L F100X+63.98") and b" Z+20.0" in lines[2]
    assert [line[:4] for line in lines[3:-2]] == [b"L X+", b"L Y+", b"L X+"]


def test_a_tap_loses_the_tool_axis_alone(tmp_path):
    """Its place is corrected, and what comes behind it; its depth is not, which a notice says."""
    text = PART.replace("16 L X+0", "CYCL DEF 207 TAP ~\n Q200=+2\n16 L X+0").replace(
        "17 TRANS", "CYCL CALL M8\n17 TRANS"
    ).replace("18 L X+20", "L Z-60 FMAX\n18 L X+20")  # fmt: skip
    filter_ = Filter(
        read_machine(write_mill(tmp_path / "mill", True)),
        DIALECT,
        setup_of(read_machine(tmp_path / "mill"), offsets={"G54": {"X": 10.0}, "T5": {"Z": 50.0}}),
    )
    verifier = Verifier(filter_)
    out = (filter_.feed(text.encode()) + filter_.finish()).decode()
    assert verifier.passed, verifier.report()
    assert "CYCL CALL M8\n" in out
    assert any("depth is not" in notice.message for notice in filter_.notices)


@pytest.mark.parametrize("cycle", ["", "CYCL DEF 200 DRILL ~|", "CYCL DEF 1.0 PECKING|"])
def test_a_call_of_another_cycle_is_refused(cycle):
    _, reasons = follow(f"L X+1|{cycle}CYCL CALL|L X+9 Y+9 Z+9")
    assert "CYCL CALL can not be followed" in " ".join(reasons)
    assert "--expand" in " ".join(reasons)


def test_nothing_changes_on_a_machine_without_errors():
    machine = read_machine(ROOT / "machines" / "perfect")
    offsets = {"G54": {}, "T5": {"Z": 50.0}}
    filter_ = Filter(machine, DIALECT, setup_of(machine, offsets=offsets))
    assert filter_.feed(PART.encode()) + filter_.finish() == PART.encode()


def test_a_number_that_is_corrected_to_zero_has_its_sign(tmp_path):
    """The manuals write X+0, and so does the program: 10 um of deviation at 0.01 mm leave zero."""
    folder = tmp_path / "m"
    shutil.copytree(ROOT / "machines" / "perfect", folder)
    (folder / "X.csv").write_text("X_mm,EXX_um\n-100,10\n100,10\n")
    machine = read_machine(folder)
    start = dict.fromkeys("XYZ", 0.0)
    filter_ = Filter(machine, DIALECT, setup_of(machine, offsets={"G54": {}}, start=start))
    text = b"0 BEGIN PGM A MM\n1 L X+5 Y+5 Z+0 R0 F500\n2 L X+0.01\n3 END PGM A MM\n"
    out = filter_.feed(text) + filter_.finish()
    assert re.search(rb"2 L X\+0(\.0+)?\n", out), out


@pytest.mark.parametrize("words", ["M103 F20", "M103F.5", "M128 F3000"])
@pytest.mark.parametrize("dialect", ["heidenhain", "heidenhain-iso"])
def test_the_feed_of_an_m_function_is_none_of_a_path(dialect, words):
    """L X+20 Y+20 RL F500 M103 F20, of the manuals ("Feed rate factor for plunging movements")."""
    one = "L X+20 R0 F500 {}|L X+30|{}|L X+40|L X+50 F90"
    two = "N10 G01 G90 X+20 F500 {} *|N20 X+30 *|N30 {} *|N40 X+40 *|N50 X+50 F90 *"
    text = (one if dialect == "heidenhain" else "%A G71 *|" + two).format(words, words)
    interpreter = Interpreter(dialects.load(dialect), SETUP)
    read = lex(text.replace("|", "\n").encode() + b"\n", interpreter.dialect.grammar, False)
    motions, state, _ = interpreter.run(read, interpreter.initial())
    assert not motions.reason.any()
    assert motions.feed.tolist() == [500.0, 500.0, 500.0, 90.0] and state.feed == 90.0
