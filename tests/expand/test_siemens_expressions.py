"""Expressions and variables of Sinumerik programs: values by hand, priorities as the manual has
them, and those that have no value refused."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from postproc.errors import ProgramError
from tests.expand.siemens_lines import refused, run, texts, value

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


def test_pi_is_pi():
    assert value("SIN($PI*180/$PI+30)") == pytest.approx(math.sin(math.radians(210)), abs=1e-5)
