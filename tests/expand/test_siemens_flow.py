"""Control structures, jumps and subprograms of Sinumerik: the lines in the order of execution, by
hand; what is refused, and limits."""

from __future__ import annotations

import re

import pytest

from postproc.nc.expand import Limits
from tests.expand.siemens_lines import Follower, refused, run, texts

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
    (
        "CALL BLOCK LA TO LZ\nX9\nCALL BLOCK LB TO LZ\nM30\nLA: X1\nX2\nLZ:\nLB: X3\nLZ: X4",
        ["X1", "X2", "X9", "X3", "X4", "M30"],
    ),
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
    refused("X1\nGOTOS", "more than 100 lines were executed", limits=Limits(100, 5))


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
        ("MCALL CYCLE93(1)", "MCALL can not be written out", 1),
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
        "more than 1,000 lines were executed",
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
    refused(
        "NIL P=9999",
        "more than 50 lines were executed",
        library={"NIL": b"X1"},
        limits=Limits(50, 5),
    )


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
        ("CYCLE93(10,0,2,-5)", "CYCLE93 is a cycle of the control"),
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
