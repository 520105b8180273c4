"""Sinumerik programs written out: values by hand, real programs by the tables beside them,
refusals, limits, anything at all."""

from __future__ import annotations

import csv
import math
import re
from itertools import groupby
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc.errors import BlockFault, ProgramError
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.siemens import lines

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT.parent / "shared" / "corpus" / "sinumerik"
AXES = ("X", "Y", "Z", "A", "B", "C", "E", "ELX")


class Follower:
    """Stands in for the tracker: follows plain absolute words, IC( ), TRANS and ATRANS, and nothing
    else."""

    inch = False
    WORD = re.compile(r"([A-Z]+)\s*=?\s*(IC\()?\s*([+-]?(?:\d+\.?\d*|\.\d+))(?![A-Z])")

    def __init__(self, axes=AXES, block_delete=False):
        self.setup = SimpleNamespace(axes=axes, block_delete=block_delete)
        self.dialect = SimpleNamespace(carried=())
        self.local, self.trans, self.place = {}, {}, {}
        self.rows = []

    def take(self, line: bytes) -> None:
        text = line.decode("latin-1").split(";")[0].upper()
        words = [
            (a, bool(ic), float(v)) for a, ic, v in self.WORD.findall(text) if a in self.setup.axes
        ]
        frame = re.search(r"\b(TRANS|ATRANS|ROT)\b", text)
        if frame:
            old = self.trans if frame[1] == "ATRANS" else {}
            self.trans = {**old, **{a: old.get(a, 0) + v for a, _, v in words}}
            return
        for axis, by, value in words:
            self.local[axis] = value + (self.local.get(axis, 0) if by else 0)
            self.place[axis] = self.local[axis] + self.trans.get(axis, 0)
        if words:
            self.rows.append(dict(self.place))

    def work(self, axis):
        return self.place[axis] - self.trans.get(axis, 0) if axis in self.place else None

    def machine(self, axis):
        return self.place.get(axis)

    def code(self, group):
        return -1

    def decimals(self, letter):
        return 5 if letter in "XYZABCUVWIJKRE" else 6


def run(text, library=None, tracker=None, limits=Limits(steps=100_000, depth=20), name="MAIN.MPF"):
    """The lines, as the driver takes them."""
    tracker = tracker or Follower()
    program = Program(
        name, text.encode("latin-1") if isinstance(text, str) else text, (library or {}).get
    )
    found = []
    for line in lines(program, tracker, limits):
        found.append(line)
        tracker.take(line.text)
    return found


def texts(text, **more):
    return [line.text.decode("latin-1") for line in run(text, **more)]


def value(expression, before=""):
    """What an expression is, by what stands behind X (5 decimals)."""
    last = texts(f"{before}\nX={expression}")[-1]
    assert last.startswith("X="), last
    return float(last[2:])


def refused(text, message, advice="", **more):
    """The refusal, with parts of its sentences."""
    with pytest.raises(ProgramError) as e:
        run(text, **more)
    assert re.search(message, e.value.message), e.value.message
    assert e.value.advice and re.search(advice, e.value.advice), e.value.advice
    assert e.value.place is not None and e.value.place.line >= 1
    return e.value


# -- expressions -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "expression, expected",
    [
        ("2+3*4", 14),
        ("(2+3)*4", 20),
        ("10-6/2", 7),
        ("2+6 DIV 4", 3),
        ("1+7 MOD 4", 4),
        ("10-3-2", 5),
        ("2*-3", -6),
        ("8/4/2", 1),
        ("3/4", 0.75),
        ("7 DIV 3", 2),
        ("7 MOD 3", 1),
        ("3 MOD 4", 3),
        ("7 MOD 4.1", 2.9),
        ("7 DIV 0.4", 17),
        ("-7 DIV 2", -3),
        ("-7 MOD 2", -1),
        ("1+1-1+-1", 0),
        ("--2", 2),
        ("+3", 3),
        ("1.5EX2", 150),
        ("-0.5EX-1", -0.05),
        ("'H0F'", 15),
        ("'hff'+1", 256),
        ("'B101'", 5),
        (".5+1.", 1.5),
        ("0.1+0.2", 0.3),
        ("SIN(30)", 0.5),
        ("COS(60)", 0.5),
        ("TAN(45)", 1),
        ("TAN(225)", 1),
        ("ASIN(0.5)", 30),
        ("ACOS(0.5)", 60),
        ("ATAN2(30.5, 80.1)", 20.84553),
        ("ATAN2(1,-1)", 135),
        ("ATAN2(-1,-1)", -135),
        ("SQRT(POT(3)+POT(4))", 5),
        ("ABS(-2.5)", 2.5),
        ("TRUNC(2.9)", 2),
        ("TRUNC(-2.9)", -2),
        ("ROUND(2.5)", 3),
        ("ROUND(2.49)", 2),
        ("ROUND(-2.4)", -2),
        ("ROUND(-2.6)", -3),
        ("LN(EXP(2))", 2),
        ("EXP(0)", 1),
        ("MINVAL(3,-1)", -1),
        ("MAXVAL(3,-1)", 3),
        ("BOUND(0,10,12)", 10),
        ("BOUND(0,10,-2)", 0),
        ("BOUND(0,10,5)", 5),
        ("$PI", 3.14159),
        ("sin (90)", 1),
        ("TRUE+TRUE", 2),
        ("FALSE", 0),
        ("NOT 0", 1),
        ("NOT 5", 0),
        ("6 B_AND 3", 2),
        ("6 B_OR 3", 7),
        ("6 B_XOR 3", 5),
        ("B_NOT 5", -6),
        ("1 OR 0 AND 0", 1),
        ("1 XOR 1 OR 0", 0),
        ("0 AND 1 XOR 1", 1),
        ("3==3", 1),
        ("3<>3", 0),
        ("2<3", 1),
        ("3<=3", 1),
        ("3>3", 0),
        ("4>=5", 0),
        ("3 B_OR 4+1", 7),
        ("(5>3)*2+(2>3)", 2),
        ('"A"=="A"', 1),
        ("0.1+0.2==0.3", 1),
        ("0.1+0.2>0.3", 0),
        ("0.3<0.1+0.2", 0),
        ("1.00000000001==1", 0),
    ],
)
def test_expressions_by_hand(expression, expected):
    assert value(expression) == pytest.approx(expected, abs=6e-6)


def test_comparisons_bind_least():
    """The manual's priority 11: A==1 AND B==1 is (A==(1 AND B))==1, with A=1 B=2 (1==1)==1, with
    A=2 B=0 (2==0)==1."""
    assert value("A_A==1 AND B_B==1", "DEF INT A_A=1, B_B=2") == 1
    assert value("(A_A==1) AND (B_B==1)", "DEF INT A_A=1, B_B=2") == 0
    assert value("A_A==1 AND B_B==0", "DEF INT A_A=0, B_B=0") == 0  # (0==(1 AND 0))==0 is TRUE==0


def test_comparison_example_of_the_manual():
    """61.02-61.01 is more than 0.01 by 5e-13 of it: equal to the control, and with TRUNC to
    everybody."""
    jump = "{}\nIF {} GOTOF ERROR\nX1\nM30\nERROR: X2\nM30"
    assert texts(jump.format("R1=61.01 R2=61.02 R3=0.01", "ABS(R2-R1) > R3"))[0] == "X1"
    by_thousand = (
        "R1=61.01 R2=61.02 R3=0.01\nR11=TRUNC(R1*1000) R12=TRUNC(R2*1000)\nR13=TRUNC(R3*1000)"
    )
    assert texts(jump.format(by_thousand, "ABS(R12-R11) > R13"))[0] == "X1"


PRIORITY = {"+": 1, "-": 1, "*": 2}


@st.composite
def trees(draw, depth=4):
    """Text, value and priority of an expression of whole numbers that has parentheses only where it
    needs them."""
    if depth == 0 or draw(st.integers(0, 3)) == 0:
        n = draw(st.integers(0, 9))
        return str(n), n, 3
    operator = draw(st.sampled_from("+-*"))
    (a, x, p), (b, y, q) = draw(trees(depth - 1)), draw(trees(depth - 1))
    own = PRIORITY[operator]
    a, b = a if p >= own else f"({a})", b if q > own else f"( {b} )"
    return f"{a} {operator}{b}", {"+": x + y, "-": x - y, "*": x * y}[operator], own


@given(trees())
def test_expressions_are_what_their_trees_are(tree):
    assert value(tree[0]) == tree[1]


@pytest.mark.parametrize(
    "expression, message",
    [
        ("1/0", "division of 1 by zero"),
        ("1 MOD 0", "division of 1 by zero"),
        ("5 DIV (2-2)", "division of 5 by zero"),
        ("SQRT(-1)", "SQRT of -1 does not exist"),
        ("LN(0)", "LN of 0"),
        ("ASIN(1.01)", "ASIN of 1.01"),
        ("TAN(90)", "TAN of 90"),
        ("EXP(1000)", "EXP of 1000"),
        ("1EX400", "beyond what REAL holds"),
        ("1EX300*1EX300", "beyond what REAL holds"),
        ("ROUND(-2.5)", "half way between"),
        ("R7", "R7 has no value"),
        ("QQ", "QQ is not defined"),
        ("Y+1", "Y is an axis"),
        ("(1+2", r"'\)' is missing"),
        ("1+", "a value is missing"),
        ("SIN(1,2)", "SIN takes 1 values, here are 2"),
        ("FOO(1)", "can not calculate the function FOO"),
        ("$P_UIFR[1,X,TR]", r"system variable \$P_UIFR"),
        ("$AA_IW[X]", "where X stands is not known"),
        ("$AA_IM[Q]", "Q is none of the machine's axes"),
        ('"A"+1', "a string stands"),
        ("ACC[X]", "ACC is an instruction"),
        ("((" * 40 + "1" + "))" * 40, "more than 30 parentheses"),
        ("R[-1]", "0 to 99999"),
        ("TRUE AND", "a value is missing"),
        ("AND", "a value is missing before AND"),
        ('"A"<<"B"', "string"),
    ],
)
def test_expressions_that_have_no_value(expression, message):
    e = refused(f"X={expression}", message)
    if e.place.stop or "system" in message:
        assert e.place.text[e.place.start - 1 : e.place.stop - 1].strip()


def test_deep_expressions_are_no_recursion():
    worst = "1==1 OR 1 XOR 1 AND 1 B_OR 1 B_XOR 1 B_AND 1+1*("
    with pytest.raises(ProgramError):
        run("X=" + worst * 31 + "1" + ")" * 31)
    run("R1=" + worst * 29 + "1" + ")" * 29)
    assert value("+".join(["1"] * 20_000)) == 20_000


# -- variables -------------------------------------------------------------------------------------


def test_variables_of_every_type():
    text = """DEF REAL a_1=1.5, b_1
DEF INT whole=2.5
DEF BOOL yes=7, no
DEF CHAR letter="A"
DEF STRING[20] text="abc", none
DEF AXIS turned=Y
X=A_1+b_1 Y=WHOLE Z=yes+no A=letter
T=text
AX[turned]=IC(WHOLE) POS[turned]=A_1"""
    assert texts(text) == ["X=1.5 Y=3. Z=1. A=65.", 'T="abc"', "Y=IC(3.) POS[Y]=1.5"]


def test_names_and_r_parameters_without_regard_to_case_and_zeros():
    assert texts("r01=3\nR[2]=r1+1\nX=R2 Y=R[R1-1] Z=R02") == ["X=4. Y=4. Z=4."]


def test_assignments_stand_beside_words_and_hold_from_left_to_right():
    assert texts("N5 R1=1 X=R1 R1=R1+1 Y=R1 ;two") == ["N5 X=1. Y=2. ;two"]
    assert texts("N5 X1 R1=1 R2=2") == ["N5 X1"]
    assert texts("/ N5 R1=1 ;nothing is left") == []


def test_arrays():
    text = """DEF REAL f_[2,3]=SET(0,,2,3), g_[4]=REP(7), h_[2,2,2]=REP(1,3)
f_[1,1]=SET(8,9) g_[1]=REP(5,2)
X=f_[0,0] Y=f_[0,1] Z=f_[0,2] A=f_[1,0] B=f_[1,1] C=f_[1,2]
X=g_[0] Y=g_[1] Z=g_[2] A=g_[3] B=h_[0,1,0] C=h_[0,1,1]"""
    assert texts(text) == ["X=0. Y=0. Z=2. A=3. B=8. C=9.", "X=7. Y=5. Z=5. A=7. B=1. C=0."]
    refused("DEF REAL f_[2,3]\nX=f_[2,0]", "index 2 of F_ is outside 0 to 1")
    refused("DEF REAL f_[2,3]\nX=f_[1]", "F_ has 2 indices, here are 1")
    refused("DEF REAL f_[2]=SET(1,2,3)", "longer than the 2 elements")
    refused("DEF REAL f_[10000000]", "array of 10000000 elements")
    refused("DEF REAL f_[2,2,2,2]", "3 dimensions at most")


@pytest.mark.parametrize(
    "text, message",
    [
        ("DEF FRAME f1", "frames as variables"),
        ("DEF REAL X", "X is an address"),
        ("DEF INT a1a=1", "A1 is an address"),
        ("DEF INT big=3000000000", "outside -2147483648 to 2147483647"),
        ("DEF STRING[5] ss=5", "type STRING"),
        ("DEF AXIS ax1\nAX[ax1]=5", "AX1 has no value"),
        ("aa=5", "AA is not defined"),
        ("$P_UIFR[1]=5", r"\$P_UIFR changes"),
        ("$AC_MARKER[0]=1", r"\$AC_MARKER changes"),
        ("DEF INT ii\nii=IC(5)", "takes one value"),
        ('T="A" X="A"<<1', "string"),
        ("M=1.5", "M takes a whole number"),
        ("DEF CHAR cc=300", "outside 0 to 255"),
        ("R1=SET(1,2)", "no array"),
        ("DEF LENGTH aa", "a type is missing"),
        ("M=R1/2", "R1 has no value"),
    ],
)
def test_variables_that_are_refused(text, message):
    if text == "M=1.5":
        text = "R1=1.5\nM=R1"
    refused(text, message)


# -- text ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    [
        "N10 G1 X10 Y-2.5 F1000 ; (R1) \xe4",
        "  g1x1y2",
        "",
        "   ",
        "; only a comment IF X",
        "X=1 Y = -2. A3=0.5 CR=20",
        "X=IC(5) Y=AC(-.5)",
        "I=AC(3) J=IC( 4 )",
        'T="BALL_MILL" M6',
        "TRANS X10 Y=5",
        "TRANS",
        "G2 X0 Y0 I5 J0 TURN=3",
        'MSG("a;b=R1")',
        "MSG()",
        "SETAL(12345)",
        "G64 SOFT FFWON",
        "FGROUP(X,Y)",
        "SPOS=90 SPOS[2]=DC(45)",
        "BSPLINE X1 PW=2",
        "POS[U]=10 FA[U]=100",
        "TRAORI(1)",
        "S1=500 M1=3 H5",
        "G4 F1",
        "ACC[X]=50",
        "X1\t Y2 ;\tz",
        "LIMS=3000",
        "N5 SUPA G0 Z0 D0",
        ":5 X1",
        "%_N_MAIN_MPF",
        'WORKPIECE(,,,"BOX",112,0,-20)',
        "CYCLE832(0.01,_ROUGH,1)",
        "PO[X]=(1,2.5)",
        "M30",
        "G1 X5 M17",
    ],
)
def test_plain_lines_stay_as_they_are(line):
    assert [part.text for part in run(line + "\r\n" if line else "\n")] == (
        [line.encode("latin-1")]
    )


@given(
    st.lists(
        st.lists(
            st.sampled_from("G0 G1 X1 Y-2.5 Z.5 x=3 N7 F100. M3 CR=5 A3=-0.1 TRANS SOFT D1".split())
        ),
        max_size=9,
    )
)
def test_plain_programs_stay_as_they_are(words):
    text = "".join(" ".join(line) + "\n" for line in words)
    found = run(text)
    assert b"".join(line.text + b"\n" for line in found).decode() == text
    assert [line.source for line in found] == list(range(1, len(words) + 1))


@pytest.mark.parametrize(
    "line, written",
    [
        ("N1 X = R1*2 ;c", "N1 X = 3. ;c"),
        ("X=IC(R1) Y=AC( R1 + 1 )", "X=IC(1.5) Y=AC( 2.5 )"),
        ("CR=R1 TURN=R2", "CR=1.5 TURN=2"),
        ("G=R2 M=R2 T=R2 D=R2", "G=2 M=2 T=2 D=2"),
        ("F=R1*1000 S1=R2", "F=1500. S1=2."),
        ("TRANS X=R1 Y10", "TRANS X=1.5 Y10"),
        ("G2 X=R1Y=R2 I=AC(R1)", "G2 X=1.5Y=2. I=AC(1.5)"),
        ("X1.5EX1 Y1", "X15. Y1"),
        ("X=1.5EX1", "X=15."),
        ("M=QU(R2)", "M=QU(2)"),
        ('MSG("R1 is "<<R1)', 'MSG("R1 is 1.5")'),
        ("SETAL(65000+R2)", "SETAL(65002)"),
        ("POS[X]=R1 ACC[X]=R2", "POS[X]=1.5 ACC[X]=2."),
        ("SPOS[R2]=DC(R1)", "SPOS[2]=DC(1.5)"),
        ("N5 LA1: X1", "N5 X1"),
        ("LA1:X=R1", "X=1.5"),
        ("X=-R1", "X=-1.5"),
        ("X=0*-R1", "X=0."),
        ("X=1/3", "X=0.33333"),
        ("F=1/3", "F=0.333333"),
    ],
)
def test_numbers_stand_where_expressions_stood(line, written):
    assert texts(f"R1=1.5 R2=2\n{line}") == [written]


def test_a_program_of_nothing():
    assert run("") == [] and run("\n") == run("; ")[:0] + run("\n")
    assert [part.text for part in run("X1\r\nX2")] == [b"X1", b"X2"]


# -- control ---------------------------------------------------------------------------------------

STRUCTURES = [
    ("IF R1==1\nX1\nELSE\nX2\nENDIF\nX3", ["X1", "X3"]),
    ("IF R1<>1\nX1\nELSE\nX2\nENDIF\nX3", ["X2", "X3"]),
    ("IF R1==2\nX1\nENDIF\nX3", ["X3"]),
    ("IF (R1==1)\nIF R1>5\nX1\nELSE ;no\nX2\nENDIF\nELSE\nX4\nENDIF", ["X2"]),
    ("WHILE R1<4\nX=R1\nR1=R1+1\nENDWHILE\nX9", ["X=1.", "X=2.", "X=3.", "X9"]),
    ("WHILE R1>4\nX=R1\nENDWHILE\nX9", ["X9"]),
    ("REPEAT\nX=R1\nR1=R1+1\nUNTIL R1>3\nX9", ["X=1.", "X=2.", "X=3.", "X9"]),
    ("REPEAT\nX=R1\nUNTIL TRUE", ["X=1."]),
    ("LOOP\nX=R1\nR1=R1+1\nIF R1>2 GOTOF OUT\nENDLOOP\nOUT: X9", ["X=1.", "X=2.", "X9"]),
    ("FOR R2=R1 TO 3\nX=R2\nENDFOR\nX=R2", ["X=1.", "X=2.", "X=3.", "X=4."]),
    ("FOR R2=3 TO 1\nX=R2\nENDFOR\nX9", ["X9"]),
    (
        "N5 FOR R2=1 TO 2\nFOR R3=1 TO 2\nX=10*R2+R3\nENDFOR\nENDFOR",
        ["X=11.", "X=12.", "X=21.", "X=22."],
    ),
    ("FOR R2=0.5 TO 2\nX=R2\nENDFOR", ["X=0.5", "X=1.5"]),
    ("GOTOF LL\nX1\nLL: X2", ["X2"]),
    ("GOTO N20\nX1\nN20 X2", ["N20 X2"]),
    ("GOTO 20\nX1\nN0020 X2", ["N0020 X2"]),
    ('GOTOF "L"<<"L"\nX1\nLL: X2', ["X2"]),
    ('DEF STRING[9] WHERE="LL"\nGOTOF WHERE\nX1\nLL: X2', ["X2"]),
    ('GOTOF "N"<<R1*20\nX1\nN20 X2', ["N20 X2"]),
    ("GOTOC NOWHERE\nX1", ["X1"]),
    ("LL: X=R1 R1=R1+1\nIF R1<3 GOTOB LL\nX9", ["X=1.", "X=2.", "X9"]),
    ("X5 IF R1==1 GOTOF LL\nX1\nLL: X2", ["X5", "X2"]),
    ("IF R1==2 GOTOF L2 IF R1==1 GOTOF L3\nX1\nL2: X2\nL3: X3", ["X3"]),
    ("LL: X1\nGOTOF LL\nX2\nLL: X3", ["X1", "X3"]),
    ("LL: X1\nLL: X2\nIF R1>2 GOTOF LE\nR1=R1+1\nGOTOB LL\nLE: X3", ["X1", "X2", "X2", "X2", "X3"]),
    (
        "CASE R1 OF 1 GOTOF L1 2 GOTOF L2 DEFAULT GOTOF L3\nL1: X1\nL2: X2\nL3: X3",
        ["X1", "X2", "X3"],
    ),
    ("CASE(R1+1)OF 1 GOTOF L1 2 GOTOF L2 DEFAULT GOTOF L3\nL1: X1\nL2: X2\nL3: X3", ["X2", "X3"]),
    ("CASE R1 OF 5 GOTOF L1 DEFAULT GOTOF L3\nL1: X1\nL3: X3", ["X3"]),
    ("CASE R1 OF 5 GOTOF L1\nX0\nL1: X1", ["X0", "X1"]),
    ("LL: X1\nX2\nREPEAT LL P=2\nX9", ["X1", "X2"] * 3 + ["X9"]),
    ("LL: X1\nX2\nREPEAT LL\nX9", ["X1", "X2"] * 2 + ["X9"]),
    ("LL: X1\nX2\nREPEATB LL P3\nX9", ["X1", "X2"] + ["X1"] * 3 + ["X9"]),
    ("LA: X1\nLE: X2\nX3\nREPEAT LA LE P=R1+1\nX9", ["X1", "X2", "X3"] + ["X1", "X2"] * 2 + ["X9"]),
    ("LA: X1\nENDLABEL: X2\nX3\nREPEAT LA\nX9", ["X1", "X2", "X3", "X1", "X2", "X9"]),
    ("REPEAT LA\nGOTOF LE\nLA: X1\nENDLABEL: X2\nLE: X9", ["X1", "X2", "X9"]),
    ("LL: X1\nREPEAT LL P=0\nX9", ["X1", "X9"]),
    ("L1: X1\nL2: X2\nREPEAT L2 P=1\nREPEAT L1 L2 P1", ["X1", "X2", "X2", "X1", "X2"]),
    ("L1: X1\nREPEATB L1\nREPEAT L1 P1\nX9", ["X1", "X1", "X1", "X1", "X9"]),
    (
        "LL: X=R1 R1=R1+1\nIF R1>3 GOTOF LE\nREPEAT LL P=9\nX8\nLE: X9",
        ["X=1.", "X=2.", "X=3.", "X9"],
    ),
    ("X1\nM2\nX2", ["X1", "M2"]),
    ("X1\nX3 M30\nX2", ["X1", "X3 M30"]),
    ("X1\nM17\nX2", ["X1", "M17"]),
    ("X1\nRET\nX2", ["X1"]),
    ("EXTERN SUB1(REAL,INT)\nX1", ["X1"]),
    ("PROC MAIN\nX1", ["X1"]),
]


@pytest.mark.parametrize("text, expected", STRUCTURES)
def test_control_structures(text, expected):
    label_l = re.sub(r"\bL(\d)\b", r"LX\1", text)  # L1 is a subprogram
    assert texts("R1=1\n" + label_l) == expected


def test_gotos_leads_to_the_first_line():
    tracker = Follower()
    assert texts("X=IC(1)\nIF $AA_IW[X]<3 GOTOS\nX9", tracker=tracker) == ["X=IC(1)"] * 3 + ["X9"]
    refused("X1\nGOTOS", "not at its end after 100 lines", limits=Limits(100, 5))


@pytest.mark.parametrize(
    "text, message, line",
    [
        ("X1\nENDIF", "ENDIF without IF", 2),
        ("IF TRUE\nX1", "IF without ENDIF", 1),
        ("ELSE\nENDIF", "ELSE without IF", 1),
        ("WHILE TRUE\nX1\nENDFOR", "WHILE without ENDWHILE", 1),
        ("UNTIL TRUE", "UNTIL without REPEAT", 1),
        ("LOOP\nX1", "LOOP without ENDLOOP", 1),
        ("REPEAT\nX1", "REPEAT without UNTIL", 1),
        ("FOR R1=1 TO 2", "FOR without ENDFOR", 1),
        ("IF FALSE\nELSE\nELSE\nENDIF", "ELSE without IF", 3),
        ("X1\nGOTOF NEXT", "there is no NEXT behind this line", 2),
        ("NEXT: X1\nGOTOF NEXT", "no NEXT behind", 2),
        ("GOTOB NEXT\nNEXT: X1", "no NEXT before this line", 1),
        ("GOTO 5", "there is no 5 in this program", 1),
        ("IF TRUE X5", "behind a condition", 1),
        ("REPEAT AA P=2", "there is no AA", 1),
        ("AA: X1\nREPEAT AA BB", "no BB behind AA", 2),
        ("ENDIF X1", "does not belong behind ENDIF", 1),
        ("FOR R1=1 TO 3\nGOTOF LL\nENDFOR\nLL: GOTOB LB", "no LB before", 4),
        ("R9=2\nFOR R1=1 TO R9\nR9=R9+1\nENDFOR", "the end value of FOR changes", 4),
        ("R1=0\nGOTOF LL\nFOR R1=1 TO 3\nLL: X1\nENDFOR", "a jump leads into the loop", 5),
        ("MCALL CYCLE86(1)", "MCALL can not be written out", 1),
        ("WHEN TRUE DO X=1", "WHEN can not", 1),
        ("ID=1 DO M8", "ID can not", 1),
        ("DEFINE A AS G1", "DEFINE can not", 1),
        ("X10 # 5", "'#' does not belong", 1),
        ("X1 Y", "Y stands here without a value", 1),
        ("RET(1)", "RET with a destination", 1),
        ("X10 NAME1(5)", "NAME1 is no word", 1),
        ("X=", "a value is missing", 1),
    ],
)
def test_control_that_is_refused(text, message, line):
    assert refused(text, message).place.line == line


def test_block_delete():
    text = "/X1\n/ N5 R1=5 X2\n/3 GOTOF LL\nX3\nLL: X4"
    assert texts(text) == ["/X1", "/ N5 X2", "X4"]
    skipped = texts(text, tracker=Follower(block_delete=True))
    assert skipped == ["/X1", "/ N5 R1=5 X2", "/3 GOTOF LL", "X3", "X4"]


def test_limits():
    e = refused(
        "R1=0\nWHILE TRUE\nR1=R1+1\nENDWHILE",
        "not at its end after 1000 lines",
        limits=Limits(1000, 5),
    )
    assert "loop" in e.advice
    refused(
        "SELF",
        "more than 5 calls are nested",
        library={"SELF": b"X1\nSELF\nM17"},
        limits=Limits(1000, 5),
    )
    refused("LL: X1\nREPEATB LL P=9\nREPEAT LL P=9", "", limits=Limits(5, 5))
    refused("NIL P=9999", "not at its end after 50", library={"NIL": b"X1"}, limits=Limits(50, 5))


# -- subprograms -----------------------------------------------------------------------------------


def test_subprograms():
    library = {
        "SUB1": (
            b"PROC SUB1(REAL DEPTH, INT TIMES=2, VAR REAL BACK) DISPLOF SBLOF\nDEF INT II\nFOR II=1"
            b" TO TIMES\nZ=DEPTH*II\nENDFOR\nBACK=II\nRET\nX999"
        ),
        "L100": b"X=IC(R1)\nM17",
        "PLAIN": b"G0 X5\nY6 M17\n",
        "OUTER": b"DEF REAL AA=3\nSUB1(AA)\nX=AA",
        "SUMS": b"PROC SUMS(REAL F_[3], VAR REAL S_)\nS_=F_[0]+F_[1]+F_[2]\nM17",
    }
    found = run(
        "DEF REAL AA=7\nR1=4\nSUB1(-2.5,,AA)\nX=AA\nN50 L100 P2 ;twice\nPLAIN", library=library
    )
    assert [(line.text.decode(), line.source, line.file) for line in found] == [
        ("Z=-2.5", 4, "SUB1"),
        ("Z=-5.", 4, "SUB1"),
        ("X=3.", 4, ""),
        ("X=IC(4.)", 1, "L100"),
        ("X=IC(4.)", 1, "L100"),
        ("G0 X5", 1, "PLAIN"),
        ("Y6", 2, "PLAIN"),
    ]
    numbered = {"L140": b"PROC L140(REAL AA, INT BB=3)\nX=AA Y=BB\nM17", "L6": b"PROC L6\nX1"}
    assert texts("L140(2)\nL6\nl140 (4+1)", library=numbered) == ["X=2. Y=3.", "X1", "X=5. Y=3."]
    assert texts("OUTER\nX9", library=library) == ["Z=3.", "Z=6.", "X=3.", "X9"]
    assert texts("DEF REAL FF[3]=SET(1,2,3), SS\nSUMS(FF,SS)\nX=SS", library=library) == ["X=6."]
    assert (
        texts(
            'CALL "PLAIN"\nCALL "/_N_SPF_DIR/_N_PLAIN_SPF"\nEXTCALL("PLAIN.SPF")\nPCALL'
            " /_N_X/PLAIN",
            library=library,
        )
        == ["G0 X5", "Y6"] * 4
    )
    assert texts("R5=2\nPLAIN P=R5-1", library=library) == ["G0 X5", "Y6"]
    assert texts("PLAIN P0", library=library) == []


def test_variables_of_a_program_are_its_own_and_r_parameters_are_not():
    library = {"SETS": b"DEF REAL AA=1\nR5=AA+1\nM17", "ASKS": b"X=AA\nM17"}
    assert texts("DEF REAL AA=9\nSETS\nX=R5 Y=AA", library=library) == ["X=2. Y=9."]
    e = refused("DEF REAL AA=9\nASKS", "AA is not defined", library=library)
    assert (e.place.file, e.place.line) == ("ASKS", 1)


@pytest.mark.parametrize(
    "call, message",
    [
        ("MATERIAL_UPDATE", "MATERIAL_UPDATE is neither"),
        ("CYCLE86(10,0,2,-5)", "CYCLE86 is a cycle of the control"),
        ("L7", "L7 is neither"),
        ('CALL "NOWHERE"', "NOWHERE is neither"),
        ("CALL 5", "as a string"),
        ("NONE1(5)", "takes 0 values, here are 1"),
        ("TAKES(5)", "takes a variable of type REAL"),
        ("SAVES", "SAVE"),
        ("ENDS", "M30 stands in a subprogram"),
        ("NONE1 P=-1", "P -1"),
    ],
)
def test_calls_that_are_refused(call, message):
    library = {
        "NONE1": b"X1",
        "TAKES": b"PROC TAKES(VAR REAL AA)\nM17",
        "SAVES": b"PROC SAVES SAVE\nM17",
        "ENDS": b"X1\nM30",
    }
    refused(call, message, library=library)


# -- positions -------------------------------------------------------------------------------------


def test_positions_come_from_the_tracker():
    text = "X10 Y5\nTRANS X100\nX1\nR1=$AA_IW[X] R2=$AA_IM[x] R3=$P_EP[Y]\nZ=R1 A=R2 B=R3"
    assert texts(text)[-1] == "Z=1. A=101. B=5."


def test_a_line_that_the_tracker_can_not_follow_is_said_where_it_is_asked():
    tracker = Follower()

    def work(axis):
        raise BlockFault(0, "two X words", "write one")

    tracker.work = work
    refused(
        "X1 X2\nR1=$AA_IW[X]",
        "a line before this one can not be followed: two X words",
        "write one",
        tracker=tracker,
    )


def test_decimals_are_asked_for_again_when_the_unit_may_have_changed():
    tracker = Follower()
    tracker.decimals = lambda letter: 2 if not tracker.inch else 4
    tracker.take = lambda line: setattr(tracker, "inch", tracker.inch or b"G70" in line)
    assert texts("X=1/3\nG70\nX=1/3", tracker=tracker) == ["X=0.33", "G70", "X=0.3333"]


# -- real programs ---------------------------------------------------------------------------------

STARTS = {"increment": {"Y": 900.0}}  # where the tables' producer stands before the first line
TABLES = {"flatten_demo": "flatten_demo_raw"}
REFUSED = {
    "custom_vars": "AA is not defined in this program",
    "arrays": "NN is not defined in this program",
    "axis_index_assignment": "ACC is an instruction: the value that it has can not be read",
    "edge_cases": "E_MULTIPLIER is not defined in this program",
}
# The same programs with what a control would need to run them: definitions, and a subprogram that
# the table passes over.
COMPLETED = {
    "custom_vars": lambda text: b"DEF INT aa=15, bb=9\n" + text,
    "arrays": lambda text: re.sub(
        rb"\b([mo])\b(?=[=,*;\n\] +])", rb"\1\1", b"DEF INT nn, mm, oo\n" + text
    ),
    "edge_cases": lambda text: b"DEF REAL E_MULTIPLIER, F_MULTI\n" + text,
}
LIBRARY = {"MATERIAL_UPDATE": b"M17"}


def corpus():
    return sorted(path.stem for path in CORPUS.glob("*.mpf")) if CORPUS.is_dir() else []


def table(name):
    """Axes and positions by row, rows without a change left out."""
    with open(CORPUS / f"{TABLES.get(name, name)}.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    axes = [axis for axis in AXES if rows and axis in rows[0]]
    places = [tuple(float(row[a]) if row[a] else None for a in axes) for row in rows]
    return axes, [key for key, _ in groupby(places) if any(v is not None for v in key)]


def followed(name, text):
    tracker = Follower()
    tracker.local.update(STARTS.get(name, {}))
    run(text, library=LIBRARY, tracker=tracker, name=name)
    axes, expected = table(name)
    places = [tuple(row.get(axis) for axis in axes) for row in tracker.rows]
    return [key for key, _ in groupby(places)], expected


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus is not here")
@pytest.mark.parametrize("name", corpus())
def test_real_programs_reach_the_positions_of_their_tables(name):
    text = (CORPUS / f"{name}.mpf").read_bytes()
    if name in REFUSED:
        refused(text, REFUSED[name], name=name)
        if name not in COMPLETED:
            return
        text = COMPLETED[name](text)
    found, expected = followed(name, text)
    assert len(found) == len(expected)
    for place, wanted in zip(found, expected, strict=True):
        assert [v is None for v in place] == [v is None for v in wanted]
        assert [v for v in place if v is not None] == pytest.approx(
            [v for v in wanted if v is not None], abs=1e-3
        )


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus is not here")
def test_an_unknown_subprogram_is_refused_and_not_passed_over():
    text = COMPLETED["edge_cases"]((CORPUS / "edge_cases.mpf").read_bytes())
    refused(
        text,
        "MATERIAL_UPDATE is neither a command that gcomp knows nor a subprogram",
        "could move an axis",
    )


# -- anything at all -------------------------------------------------------------------------------

SOUP = """IF ELSE ENDIF LOOP ENDLOOP WHILE ENDWHILE FOR ENDFOR REPEAT UNTIL REPEATB GOTOF GOTOB GOTO GOTOC GOTOS CASE OF DEFAULT DEF REAL INT BOOL
CHAR STRING AXIS PROC EXTERN RET CALL PCALL MCALL M17 M30 R1 R2 R[ ] ( ) , = == <> < > <= >= << + - * / DIV MOD AND OR XOR NOT B_AND B_OR B_NOT
SIN( ATAN2( ROUND( BOUND( SET( REP( TRUE $PI $AA_IW[X] $P_UIFR 1 2.5 -3 1EX5 1EX999 'H0F' "A" " ; X= Y=IC( CR= X1 N10 LA: LB: LA LB P=2 L10 SUB
SUB( AA BB[2] AA= AX[ TO VAR TRANS MSG( SAVE / % : . # \xff \x00 \xb2 \t . 99999999999999999999 T= G71 FOR""".split(  # noqa: E501
    " "
)
SOUP = [word for part in SOUP for word in part.split("\n")]
FUZZED = {"SUB": b"PROC SUB(REAL AA, VAR REAL BB)\nX=AA\nSUB(AA)\nM17", "L10": b"X1\nR1=R1+1"}


def only_refusals(text):
    try:
        run(text, library=FUZZED, limits=Limits(300, 4))
    except ProgramError as e:
        assert e.message and e.advice and str(e) and e.place.line >= 1


@settings(max_examples=400)
@given(
    st.lists(st.lists(st.sampled_from(SOUP), max_size=8), max_size=10), st.sampled_from(["", " "])
)
def test_words_in_any_order_are_run_or_refused(soup, between):
    only_refusals(
        "DEF REAL AA=1, BB[3]\nR1=1 R2=2\n" + "\n".join(between.join(line) for line in soup)
    )


@settings(max_examples=300)
@given(st.binary(max_size=60))
def test_any_bytes_are_run_or_refused(data):
    only_refusals(data)
    only_refusals(b"X=" + data)
    only_refusals(b"IF " + data + b"\nENDIF")


def test_pi_is_pi():
    assert value("SIN($PI*180/$PI+30)") == pytest.approx(math.sin(math.radians(210)), abs=1e-5)
