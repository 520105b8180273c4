"""Sentences on what is written out: LinuxCNC's cycles, splines, O-words and expressions; grblHAL
and Marlin beside it."""

from __future__ import annotations

from tests.advice.follow import NOWHERE, WRITE, Case

C = "linuxcnc"


def mill(before: str, after: str, then: str = "", **options) -> Case:
    head = "G90 G0 X1 Y2 Z5|F100|S100 M3|"
    how = {**WRITE, **options.pop("how", {})}
    return Case(C, head + before, head + after, then, how=how, **options)


SHAPE = "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|O100 ENDSUB|"


def turn(before: str, after: str, shape: str = SHAPE, shape_after: str = "", **options) -> Case:
    head = "G18 G8 G90|G0 X10 Z1 F9|"
    return Case(
        C,
        shape + head + before,
        (shape_after or shape) + head + after,
        how={**WRITE, "lathe": True},
        **options,
    )


POLES = "G5.2 X1 Y1 P1 L3|X2 Y2 P1|X3 Y1 P1|G5.3"
CYCLES = [
    mill("G81 X1 Z-1 R2 E5", "G81 X1 Z-1 R2|G80"),
    mill("G81 X1 Z-1 R2 L0", "G81 X1 Z-1 R2 L1|G80"),
    mill("G81 X1 R2", "G81 X1 Z-1 R2|G80"),
    mill("G5.2 X1 Y1 P1|G5.1 X1 Y1 I1 J1", POLES),
    mill("G18|G5.1 X1 Y1 I1 J1", "G17|G5.1 X1 Y1 I1 J1"),
    mill("G93 G5.1 X1 Y1 I1 J1 F2", "G94 G5.1 X1 Y1 I1 J1 F2"),
    mill("G0 X1 Y1|G10 L2 P1 R30|G28 X3", "G0 X1 Y1|G10 L2 P1 R30|G28|G0 X1 Y1 Z1"),
    mill("G10 L2 P1 R30|G10 L20 P1 X3", "G10 L2 P1 R30 X3|G0 X1 Y1"),
    mill("G5 X1 Y1 I1 J1", "G5 X1 Y1 I1 J1 P0 Q1"),
    mill("G5.1 X1 Y1 I1", "G5.1 X1 Y1 I1 J1"),
    mill("G5.3", POLES),
    mill("M5|G86 X1 Z-1 R2 P1", "M3|G86 X1 Z-1 R2 P1|G80"),
    mill("G92 X3|G10 L2 P1 R30|G0 X2 Y1", "G92 X3|G92.1|G10 L2 P1 R30|G0 X2 Y1"),
    mill("G10 L2 P1 R30|G0 X1 Y1|G92 X3", "G10 L2 P1 R30 X3|G0 X1 Y1"),
    mill("G83 X1 Z-1 R2 Q-1", "G83 X1 Z-1 R2 Q1|G80"),
    mill("G81 X1 Z3 R1", "G81 X1 Z-3 R1|G80"),
    mill("G5.2 X1 Y1 P1|G5.3", POLES),
    mill("G5.2 X1 P1 L3", POLES),
    mill("G5.2 X1 Y1 L3", POLES),
    mill("G93 G81 X1 Z-1 R2 F10", "G94 G81 X1 Z-1 R2 F10|G80"),
    mill("G73", "G73 X1 Z-1 R2 Q1|G80"),
    mill("G82 X1 Z-1 R2 P-1", "G82 X1 Z-1 R2 P1|G80"),
    mill("G5.2 X1 Y1 P1|G1 X2", POLES + "|G1 X2"),
    mill(
        "G10 L2 P1 R30|G0 X1 Y1 Z1|G18 G2 X1 Z1 I3 K0 P2",
        "G10 L2 P1 R30|G0 X1 Y1 Z1|G18 G1 X4 Z3|X7 Z1|X4 Z-1|X1 Z1",
    ),
    mill(
        "G10 L2 P1 R30|G0 X1 Y1 Z1|G93 G18 G2 X3 Z3 R5 F9",
        "G10 L2 P1 R30|G0 X1 Y1 Z1|G93 G18 G1 X2 Z1.5 F9|X3 Z3 F9",
    ),
    mill("G10 L2 P1 R30|G0 X1 Y1 Z1|G18 G2 X3 Z3", "G10 L2 P1 R30|G0 X1 Y1 Z1|G18 G2 X3 Z3 R5"),
    mill("G5.1 X1 Y1 I1 J1|X2", "G5.1 X1 Y1 I1 J1|G1 X2"),
    mill("G5.2 X1 Y1 P1|G92 X5|X2 Y1 P1|X3 Y3 P1|G5.3", POLES),
    mill("G41.1 D1 G1 X5|G81 X1 Z-1 R2", "G41.1 D1 G1 X9|X20|G40 G1 X25|G81 X1 Z-1 R2|G80"),
    mill("G41.1 D1 G1 X9|G5.1 X11 Y1 I1 J1", "G5.1 X11 Y1 I1 J1"),
    mill("G5.1 I1 J1", "G5.1 X1 Y1 I1 J1"),
    mill("G5.2 X1 Y1 P1 L3.5", POLES),
    mill("G5.2 X1 Y1 P1 L3|L4|G5.3", POLES),
    mill("G85 G10 L2 P1 X1|X1", "G10 L2 P1 X1|G85 X1 Z-1 R2|G80"),
    mill("G81 X1 G83 Z-1 R2 Q1", "G83 X1 Z-1 R2 Q1|G80"),
    mill("G4 P1 G81 X1 Z-1 R2", "G4 P1|G81 X1 Z-1 R2|G80"),
    mill("G10 L2 P1 R30|G90.1 G2 X3 Y3 I1 J1", "G10 L2 P1 R30|G91.1 G0 X1 Y2|G2 X3 Y2 I1 J0"),
    turn("G91 G71 Q100 D1 I1", "G90 G71 Q100 D1 I1"),
    turn("G17 G71 Q100 D1 I1", "G18 G71 Q100 D1 I1"),
    turn("G71 D1 I1", "G71 Q100 D1 I1"),
    turn("G71 Q101 D1 I1", "G71 Q100 D1 I1"),
    turn("G71 Q100 I0", "G71 Q100 I1 R.5"),
    turn(
        "G71 Q100 I1",
        "G71 Q100 I1",
        shape=SHAPE.replace("X4 Z-6", "X4 Z-6 F5 M8"),
        shape_after=SHAPE,
    ),
    turn(
        "G71 Q100 I1", "G71 Q100 I1", shape=SHAPE.replace("X4 Z-6", "G2 X4 Z-6"), shape_after=SHAPE
    ),
    turn(
        "G71 Q100 I1",
        "G71 Q100 I1",
        shape=SHAPE.replace("X4 Z-6", "G2 X4 Z-6 R.1"),
        shape_after=SHAPE,
    ),
    turn(
        "G71 Q100 I1",
        "G71 Q100 I1",
        shape=SHAPE.replace("X4 Z-6", "G2 X4 Z-6 I1 K-5"),
        shape_after=SHAPE,
    ),
    turn(
        "G71 Q100 I1",
        "G71 Q100 I1",
        shape=SHAPE.replace("X4 Z-6", "G2 X4 Z-6 R2|X5 Z-7 R1"),
        shape_after=SHAPE,
    ),
    turn(
        "G71 Q100 I1", "G71 Q100 I1", shape=SHAPE.replace("G1 Z-4|X4 Z-6|", ""), shape_after=SHAPE
    ),
    turn(
        "G71 Q100 I1 D.1",
        "G71 Q100 I1 D.1",
        shape=SHAPE.replace("X4 Z-6", "G2 X4 Z-6 I2 K.01"),
        shape_after=SHAPE,
    ),
    turn("G71 Q100 I1 D50", "G71 Q100 I1 D.1"),
    turn("G70 Q100 P1.5", "G70 Q100 P1"),
    turn("G91 G70 Q100", "G90 G70 Q100"),
    turn("G41.1 D1 G1 X20|G71 Q100 I1", "G71 Q100 I1"),
    turn("M3 S9|G76 P1 Z-5 I-1 J.2 K1 H1.5", "M3 S9|G76 P1 Z-5 I-1 J.2 K1 H1"),
    turn("M3 S9|G76 P1 Z-5 I0 J.2 K1", "M3 S9|G76 P1 Z-5 I-1 J.2 K1"),
    turn("M3 S9|G76 P1 Z-5 I-1 J.000001 K1", "M3 S9|G76 P1 Z-5 I-1 J.2 K1"),
    turn("M3 S9|G76 Z-5 I-1 J.2 K1", "M3 S9|G76 P1 Z-5 I-1 J.2 K1"),
    turn("M3 S9|G76 P1 I-1 J.2 K1", "M3 S9|G76 P1 Z-5 I-1 J.2 K1"),
    turn("G76 P1 Z-5 I-1 J.2 K1", "M3 S9|G76 P1 Z-5 I-1 J.2 K1"),
    turn("M3 S9|G41.1 D1 G1 X20|G76 P1 Z-5 I-1 J.2 K1", "M3 S9|G76 P1 Z-5 I-1 J.2 K1"),
]


def words(before: str, after: str, then: str = "", **options) -> Case:
    head = "G90 G0 X1 Y2 Z5 F9|"
    how = {**WRITE, **options.pop("how", {})}
    return Case(C, head + before, head + after, then, how=how, **options)


O_WORDS = [
    words("#5061=1", "#1=1"),
    words("X#5061", "X1"),
    words("#<_x>=1", "#<_own>=1"),
    words("X#<a>", "#<a>=1|X#<a>"),
    words("o1 sub|o1 endsub [1/0]|X#<_value>", "o1 sub|o1 endsub [1]|o1 call|X#<_value>|M2"),
    words("X#<_rpm>", "X1"),
    words(
        "X#<_current_tool>",
        "X#<_current_tool>",
        also={"start": {"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "C": 0, "T": 1}},
    ),
    words("X#<_selected_tool>", "T3|X#<_selected_tool>"),
    Case(C, "%|o<a> sub|G0 X1|%", "%|o<a> sub|G0 X1|o<a> endsub|%", how=WRITE),
    words("o1 if 1", "o1 if [1]|o1 endif"),
    words("X[[-8]**[1/3]]", "X[8**[1/3]]"),
    words("X[5 MOD 0]", "X[5 MOD 2]"),
    words("X[1/0]", "X[1/2]"),
    words("o100 return", "o100 sub|o100 return|o100 endsub|o100 call"),
    words("o1 sub|M99|o1 endsub|o1 call|M2", "o1 sub|o1 endsub|o1 call|M2"),
    words("o1 endif", "o1 if [1]|o1 endif"),
    words("X1 @", "X1"),
    words("#1", "#1=2"),
    words("X[LN[0]]", "X[LN[1]]"),
    words("o1 if [1] X1", "o1 if [1]|X1|o1 endif"),
    words("X[TAN[90]]", "X[TAN[9]]"),
    words("#1.5=3", "#1=3"),
    words("G28.1|X#5161", "X1"),
    words("X1 X2|X#5420", "X2|X#5420"),
    words("X#5210", "X1", how={"start": NOWHERE}),
    words("G[90.55]", "G[90]"),
    words("X1 M98 P5|M2|O5|M99", "X1|M98 P5|M2|O5|M99"),
    words("M98 P5 X1|M2|O5|M99", "M98 P5|X1|M2|O5|M99"),
    words("M98|M2|O5|M99", "M98 P5|M2|O5|M99"),
    words("M98 P5 L-1|M2|O5|M99", "M98 P5 L1|M2|O5|M99"),
    words("M99", "M2"),
    words("(X1", "(X1)"),
    words("X[" + "9" * 500 + "]", "X[9]"),
    words("o1 repeat [9999999999]|o1 endrepeat", "o1 repeat [9]|o1 endrepeat"),
    words("X[1+]", "X[1+1]"),
    words("o1 sub|o1 call|o1 endsub|o1 call", "o1 sub|o1 endsub|o1 call"),
    words("X" + "-" * 60 + "1", "X1"),
    words(
        "o1 call" + "[1]" * 31 + "|M2|o1 sub|o1 endsub|M2",
        "#31=1|o1 call" + "[1]" * 30 + "|M2|o1 sub|o1 endsub|M2",
    ),
    words("o1 while [1]|o1 endwhile", "o1 while [0]|o1 endwhile"),
    words("o1 if [0]", "o1 if [0]|o1 endif"),
    words("o1 sub|o2 sub|o2 endsub|o1 endsub|M2", "o1 sub|o1 endsub|o2 sub|o2 endsub|M2"),
    words("o1 do|o1 while [0]|o1 do|o1 while [0]", "o1 do|o1 while [0]|o2 do|o2 while [0]"),
    words("o1 call|M2|O1|M99|M2", "M98 P1|M2|O1|M99|M2"),
    words(
        "o<a> call|M2|o<a> sub|o<b> sub|o<b> endsub|o<a> endsub",
        "o<a> call|M2|o<a> sub|o<a> endsub|o<b> sub|o<b> endsub",
    ),
    words("o100 call|o100 sub|o100 endsub|M2", "o100 call|M2|o100 sub|o100 endsub|M2"),
    words("o<a> call|M2|o<a> sub|X1", "o<a> call|M2|o<a> sub|X1|o<a> endsub"),
    words("o<a", "o<a> sub|o<a> endsub"),
    words("G41.1 D3|X#5420", "G41.1 D3|G1 X20|X40|G40 G1 X60|X#5420"),
    words("(abort, no tool)", "(no tool)"),
    words("o<gone> call", "o<gone> call|M2|o<gone> sub|o<gone> endsub"),
    words(
        "o<gone> call", "o<gone> call", also={"library": {"gone": "o<gone> sub|o<gone> endsub|M2"}}
    ),
    words("X##1", "#1=5|#5=1|X##1"),
    words("o1 foo", "o1 sub|o1 endsub"),
    words(";py,x=1|X1", "X1"),
    words("X[1+2", "X[1+2]"),
    words("X#<_vmajor_of_none>", "X1"),
    words("X[EXP[800]]", "X[EXP[1]]"),
    words("#1=[10**300]|X[#1*#1]", "X[10]"),
    words("#<_task>=1|X#<_task>", "X1"),
    words("X#<_ini[TRAJ]AXES>", "X1"),
    words("G1 X1 X2|o1 if [#5420 GT 1]|o1 endif", "G1 X2|o1 if [#5420 GT 1]|o1 endif"),
    words("G1 X1 X2|#1=#<_feed>", "G1 X2|#1=#<_feed>"),
    words("X[2**2000]", "X[2**2]"),
    words("#<_task>=1", "#<_own>=1"),
    words("X1 X2|o1 if [#<_metric> EQ 1]|o1 endif", "X2|o1 if [#<_metric> EQ 1]|o1 endif"),
]
STATES = [
    words("M72", "M70|M72"),
    words("M70 X1", "M70|X1"),
    words("G93 F#<_hal[a]>|G1 X1", "G94|G1 X1"),
    words("@5 ^30 X1", "@5 ^30"),
    words("G18|@5 ^30", "G17|@5 ^30"),
    words("@5 @6 ^30", "@6 ^30"),
    words("G0 X0 Y0|@5", "G0 X0 Y0|@5 ^30"),
    words("G4 P1 @5 ^30", "G4 P1|X1 Y1"),
    words("G53 @5 ^30", "G53 X1 Y1"),
    words("G20 @5", "G20 G90 @.5 ^30"),
    words("M70|G92 X5|M72", "M70|G92 X5|G92.1|M72"),
    words("M73|G43 H1|M72", "G43 H1"),
    words("M70|M3 S500|M72", "M5 S100|M70|M3 S500|M72"),
    words("G92 X5|M70|G92.1|M72", "G92 X5|G92.1"),
    words("o1 sub|M73|G92 X5|o1 endsub|o1 call", "o1 sub|G92 X5|o1 endsub|o1 call"),
    Case(C, "@5", "G0 X1 Y1 Z1|@5 ^30", how={**WRITE, "start": NOWHERE}),
]
OTHERS = [
    Case(
        "marlin",
        "G90|G1 X1 Y1 Z1|G18|G5 X9 Y9 P1 Q1",
        "G90|G1 X1 Y1 Z1|G17|G5 X9 Y9 I1 J1 P1 Q1",
        how=WRITE,
    ),
]
ALL = [*CYCLES, *O_WORDS, *STATES, *OTHERS]
