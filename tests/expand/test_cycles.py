"""Canned cycles written out: LinuxCNC's against its own interpreter, Fanuc's and Haas' against the
manuals' figures.

The oracle runs the original program; our interpreter runs the plain text. Numbers are written with
ten decimals there, so that the comparison is as sharp as for plain programs.
"""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles.block import Block, blocks
from postproc.nc.expand import Limits, Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import CLOSE, plain, setup_for

CORPUS = Path(__file__).resolve().parents[3] / "shared" / "corpus" / "fanuc"
MILL = setup_for({})
LATHE = Setup(
    axes=("X", "Z", "C"), diameter=frozenset("X"), least_increment=dict.fromkeys("XZC", 1e-3),
    start={"X": 0.0, "Z": 0.0, "C": 0.0},
)  # fmt: skip


class Exact(Tracker):
    """A tracker whose numbers are written to a tick."""

    def decimals(self, letter: str) -> int:
        return 12 if self.inch else 10


def expand(
    text: str, dialect: str = "linuxcnc", setup: Setup = MILL, tracker=Tracker, **options
) -> list[Line]:
    """The plain lines of a program, one source line after the other (no language stage before)."""
    resolver = Resolver(
        Program("part", text.encode()),
        tracker(Interpreter(dialects.load(dialect), setup)),
        **options,
    )
    return [
        plain
        for n, one in enumerate(text.split("\n"), 1)
        for plain in resolver.take(Line(one.encode(), n))
    ]


def text_of(program: str, dialect: str, setup: Setup = MILL) -> list[str]:
    """The plain text of a program written with | between its lines."""
    return [line.text.decode() for line in expand(program.replace("|", "\n"), dialect, setup)]


def motions(lines: list[Line], dialect: str = "linuxcnc", setup: Setup = MILL) -> list[dict]:
    """What our interpreter makes of plain lines."""
    interpreter = Interpreter(dialects.load(dialect), setup)
    words = lex(b"\n".join(line.text for line in lines) + b"\n", interpreter.dialect.grammar)
    assert words.fault is None, words.fault
    return plain(interpreter.run(words, interpreter.initial())[0], words, 0)


def same_motions(text: str, theirs: list[oracle.Motion], source: str | None = None) -> None:
    """Assert that the text written out moves as LinuxCNC does when it runs the original. `source`:
    what the language stage hands on, where that is not the text itself."""
    program = Program("part", text.encode())
    resolver = Resolver(
        program, Exact(Interpreter(dialects.load("linuxcnc"), MILL)), synchronised=True
    )
    lines = [
        plain
        for n, one in enumerate((source or text).split("\n"), 1)
        for plain in resolver.take(Line(one.encode(), n))
    ]
    mine = motions(lines)
    moved = [m for m in theirs if m.kind == "arc" or (m.kind != "dwell" and _length(m) > CLOSE)]
    written = "\n".join(line.text.decode() for line in lines)
    assert [(lines[a["line"] - 1].source, a["kind"]) for a in mine] == [
        (b.line, b.kind) for b in moved
    ], written
    for a, b in zip(mine, moved, strict=True):
        assert not a["reason"][0], (a, written)
        assert a["end"] == pytest.approx(list(b.end), abs=CLOSE), (a, b, written)
        if b.kind == "arc":
            assert a["centre"] == pytest.approx(b.centre, abs=CLOSE), (a, b, written)
            assert (a["sweep"] > 0) == (b.turns > 0)
    dwells = [m.seconds for m in theirs if m.kind == "dwell" and m.seconds]
    assert [float(p) for p in re.findall(r"G4 ?P([\d.]+)", written)] == dwells


def _length(motion: oracle.Motion) -> float:
    return max(abs(a - b) for a, b in zip(motion.start, motion.end, strict=True))


def needs_oracle():
    return pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))


# -- LinuxCNC: holes -------------------------------------------------------------------------------

HOLES = [
    "G81 X1 Y1 Z-3 R1|X2|G98 X3|G0 Z7|G81 X4 Z-3 R1|X5|G99 X6|G98 X7",
    "G98 G81 X1 Z-3 R1|G81 X2 Z-3 R6|X3|X4 R2",
    "G91 G98 G81 X1 Z-3 R-2 L3|X2",
    "G91 G99 G81 X1 Z-3 R-2 L3|X2",
    "G91 G98 G81 X1 Z-3 R2 L2|X2",
    "G98 G82 X1 Z-3 R1 P.5|X2|G83 X3 Z-3 R1 Q1.5|G73 X4 Z-3 R1 Q1.5|Q2 X5",
    "G98|G85 X1 Z-3 R1|G86 X1 Z-3 R1 P1|G89 X4 Z-3 R1 P2",
    "M4|G98 G86 X1 Z-3 R1 P1|X2 P.2",
    "G98|G84 X1 Z-3 R1|X3 Y3|G91 X2",
    "M4|G74 X1 Z-3 R1|X3",
    "G98|G81 X1 Z-3 R1|Z-5|X2 L2|M8|F40|X4",
    "G18 G81 X1 Z3 Y-3 R1|X2",
    "G18 G98 G0 Y4|G83 X1 Z3 Y-3 R1 Q.9|G91 X2 L2",
    "G19 G81 X-1 Z3 Y3 R1|Y4",
    "G19 G99 G73 X-1 Z3 Y3 R4 Q.7|Y4 L2",
    "G20 G98|G0 X2|G73 X1 Z-.3 R.1 Q.15|G83 X1 Z-.3 R.1 Q.15",
    "G98 G81 X1 Z-3 R1|G99 X2|G80|G98 G81 X3 Z-3 R1",
    "G98 G81 X1 Z-3 R1|G99 X2|G4 P1|G98 X3",
    "G98 G81 X1 Z-3 R1|G99 X2|G0|G98 G81 X3 Z-3 R1",
    "G98 G81 X1 Z-3 R1|G99 X2|G18|G98 X3",
    "G98 G81 X1 Z-3 R1|G99 X2|G20|G98 X.1",
    "G98 G81 X1 Z-3 R1|G99 X2|G91|G98 X3",
    "G98 G81 X1 Z-3 R1|G99 X2|G53 G0 Z3|G98 G81 X3 Z-3 R1",
    (
        "G98 G81 X1 Z-3 R1|G99 X2|G53 G0 Z0|G98 G81 X3 Z-3 R1|G99 X2 R2|R3 X3|G98 R4 X4|R2 X5|G91"
        " R1 X5|G99 R-2 X5|G98 X3"
    ),
    (
        "G98 G81 X1 Z-3 R1|G99 X2|R3 X3|G98 R4 X4|R2 X5|G91 R1 X5|G99 R-2 X5|R-1 Y3|G98 X3|G90 R7"
        " X3|G99 R3 X4|R8 X4|R5 X2"
    ),
    "G7 G19 G81 X-2 R12 Z1",
    "G7 G98 G19 G91 G81 X-2 R-2 Z1",
    "G7 G19 G98 G83 X-2 R12 Z1 Q1.5",
    "G7 G19 G98 G73 X-2 R12 Z1 Q1.5",
    "G7 G81 X12 R2 Z-1|X14",
    "G91 G98 G73 X2 R-2 Z-3 Q1 L2",
    "G91 G99 G82 X2 R-2 Z-3 P1 L2",
    "G91 G99 G83 X2 R-2 Z-3.2 Q1.1 L2|X1",
    "G90 G98 G83 X2 R2 Z-3.2 Q1.1 L2|X1",
    "G98 G81 X2 R2 Z-3|R4 X3|Z-4",
    "G98 G81 X2 R2 Z-3|G91 X3|Z-4 X1|R-1 X1|G90 X0",
    "G98 G91 G81 X2 R-2 Z-3|X3|Z-4 X1|R-1 X1|G90 X0",
    "G81 G80 X1 Z-1 R0",
    "G81 X1 Z-1 R0|G1 X5|X6 Z2",
    "G98 G83 X1 Y0 Z0 R1 Q.1",
    "G20 G98 G83 X.1 Y0 Z0 R.1 Q.01",
    "G8 1 X 1 Z - 1 R 2|g81x2z-1r2|G081 X3|G81. X4",
    "/G81 X1 Z-1 R2|/X4",
    "N5 G81 X1 Z-1 R2 F200 S300 M8 (a hole)|N6 X2 (another)",
    "G98 G81 X1 Z-1 R2|G10 L2 P1 Z2|X4",
    "G98 G81 X1 Z-1 R2|G92 Z3|X4 R2 Z-1",
    "G98 G81 X1 Z-3 R1|G92 Z0|X4 R2 Z-1|G99 X2|G98 X2|G92 Z2|X3|G92 Z-2|X3",
    "G98 G81 X1 Z-1 R2|G55|X4",
    "G10 L2 P2 X3 Z1|G55 G98 G81 X1 Z-1 R2|X4",
    "G20 G98 G81 X1 Z-1 R2|X4",
    "G91 G20 G98 G81 X1 Z-1 R-.02|X4",
]
BEGIN = "F100|S100 M3|G0 X5 Z5|"


@pytest.fixture(scope="module")
def holes():
    if oracle.available():
        pytest.skip(oracle.available())
    return dict(zip(HOLES, oracle.motions_of_many([(_program(h), {}) for h in HOLES]), strict=True))


def _program(holes: str) -> str:
    return (BEGIN + holes + "|M2|").replace("|", "\n")


def test_there_are_enough_programs():
    assert len(HOLES) >= 40


@pytest.mark.parametrize("program", HOLES)
def test_holes_are_those_of_linuxcnc(program, holes):
    assert isinstance(holes[program], list), holes[program]
    same_motions(_program(program), holes[program])


def _random_holes(draw: random.Random) -> str:
    """A program of holes in all modes; LinuxCNC moves wrongly in G84 outside the XY plane, so that
    is left out."""
    lines = [
        "F100",
        "M3 S100",
        draw.choice(["G0 X5 Z5", "G0 X-3 Y2 Z9 G98", "G20 G0 Z1", "G0 Z5 G18", "G7 G0 X20 Z5"]),
    ]
    flat = "G18" not in lines[2]
    modes = [
        "G98",
        "G99",
        "G91",
        "G90",
        "G80",
        "G0 Z4",
        "G4 P1",
        "G20",
        "G21",
        "M8",
        "G92 Z1",
        "G92.1",
        "G55",
        "G54",
    ]
    for _ in range(draw.randint(2, 7)):
        if draw.random() < 0.3:
            lines.append(draw.choice(modes + modes[:4]))
        words = [f"{x}{draw.uniform(-5, 5):.2f}" for x in "XYZ" if draw.random() < 0.5] or ["X1"]
        if draw.random() < 0.4:
            cycles = ["73 Q1.3", "81", "82 P.1", "83 Q.7", "85", "86 P.2", "89 P.3"] + ["84"] * flat
            words = ["G" + draw.choice(cycles), *(f"{x}{draw.uniform(-5, 1):.2f}" for x in "XYZ")]
            words.append(f"R{draw.uniform(1, 7):.1f}")
        elif draw.random() < 0.3:
            words.append(f"R{draw.uniform(-2, 7):.1f}")
        if draw.random() < 0.2:
            words.append(f"L{draw.randint(1, 3)}")
        lines.append(
            " ".join(
                ([draw.choice(["G98", "G99", "G90", "G91"])] if draw.random() < 0.2 else []) + words
            )
        )
    return "\n".join([*lines, "M2", ""])


@needs_oracle()
def test_random_holes_are_those_of_linuxcnc():
    draw = random.Random(5)
    programs = [_random_holes(draw) for _ in range(250)]
    compared = 0
    for text, theirs in zip(
        programs, oracle.motions_of_many([(text, {}) for text in programs]), strict=True
    ):
        if isinstance(theirs, list):
            same_motions(text, theirs)
            compared += 1
    assert compared >= 60


REFUSED = {
    "G81 G82 X1 Z-3 R1 P1": "G81 and G82 in one block",
    "G81 X1 Z-3 R1|R3": "R in a block within G81",
    "G81 X1 Z-3 R1|A4": "A in a block within G81",
    "G81 X1 Z3 R1": "below the bottom",
    "G81 X1 R1": "without Z",
    "G81 Z1 X1": "without R",
    "G83 X1 Z-1 R2": "without Q",
    "G82 X1 Z-1 R2": "without P",
    "G81 X1 Z-1 R2 A4": "A in a drilling cycle",
    "G81 X1 Z-1 R2 L0": "no number of holes",
    "G81 X1 Z-1 R2 L1.5": "no number of holes",
    "G81 X1 Z-1 R2|G81": "without X, Y or Z",
    "G83 X1 Z-1 R2 Q-1": "no peck",
    "G83 X1 Z-1 R2 Q.00001": "pecks",
    "G82 X1 Z-1 R2 P-1": "dwell",
    "G93 G81 X1 Z-1 R2 F10": "inverse time",
    "M5|G86 X1 Z-1 R2 P1": "does not turn",
    "G87 X1 Z-1 R1 I1 J1 K1": "undefined",
    "G88 X1 Z-1 R1 P1": "undefined",
    "G81 X1 Z-1 R2|G82 X2 P1": "without R and Z",
    "G28 G81 X1 Z-1 R2": "in one block",
}


@pytest.mark.parametrize("program", REFUSED)
def test_what_is_no_hole_is_refused_with_the_reason(program):
    with pytest.raises(ProgramError, match=REFUSED[program]) as caught:
        expand(_program(program))
    assert caught.value.advice and caught.value.place.line >= 4


# -- LinuxCNC: threads and turning -----------------------------------------------------------------

THREADS = [
    "G18 G76 Z-10 P1 I-.5 J.3 K1",
    "G18 G76 Z-10 P1 I-.5 J.3 K1 R2 Q29.5 H2",
    "G18 G76 Z-10 P1 I-.5 J.3 K1 R1.5 Q29.5 H1 E2 L1",
    "G18 G76 Z-10 P1 I.5 J.3 K1 R1.5 Q29.5 H1 E2 L3",
    "G18 G76 Z-10 P1 I-.5 J.3 K1 E2 L2",
    "G91 G18 G76 Z-10 P1 I-.5 J.3 K1",
    "G18 G76 Z10 P1 I-.5 J.3 K1 R1.5 Q20 E1 L3",
    "G18 G76 X4 Z-10 P1 I-.5 J.3 K1 R1.5 Q20",
    "G76 Z-10 P1 I-.5 J.3 K1 R.5",
    "G20 G0 X1 Z.1|G76 Z-1 P.05 I-.1 J.01 K.05 E.1 L3 R2 Q29.5",
    "M4|G18 G33 Z-10 K1|G0 X2",
]


@needs_oracle()
@pytest.mark.parametrize("program", THREADS)
def test_every_pass_of_a_thread_is_linuxcncs(program):
    same_motions(_program(program), oracle.motions(_program(program)))


def test_a_thread_is_written_as_synchronised_passes():
    lines = text_of(BEGIN + "G18 G76 Z-10 P1.5 I-.5 J.6 K1 E2 L3", "linuxcnc")
    cuts = [line for line in lines if "K" in line]
    along = 1.5 * (2**2 + 1) ** 0.5 / 2
    assert len(cuts) == 8 and cuts[0] == f"G33 X4.9 K{round(along, 8):.8f}".rstrip("0")
    assert cuts[2] == "Z-8. K1.5" and cuts[3].startswith("X4.9 Z-10. K1.67")


def test_a_thread_in_diameters_stays():
    assert text_of(BEGIN + "G7 G18 G76 Z-10 P1 I-.5 J.3 K1", "linuxcnc")[-2:] == [
        "G7",
        "G18 G76 Z-10 P1 I-.5 J.3 K1",
    ]


SHAPES = [
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|G2 X5 Z-7 I1|G1 X7|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G71"
        " Q100 I2.5 R.3|M2|"
    ),
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|G2 X5 Z-7 I1|G1 X12|O100 ENDSUB|F100|S100 M3|G18 G0 X10"
        " Z1|G71 Q100|M2|"
    ),
    (
        "O100 SUB|G0 X20|G1 Z-4|X15 Z-6|G1 X8|O100 ENDSUB|F100|S100 M3|G18 G0 X5 Z1|G71 Q100 I4"
        " R.3|M2|"
    ),
    "O100 SUB|G0 X20|G1 Z6|X15 Z8|O100 ENDSUB|F100|S100 M3|G18 G0 X5 Z1|G71 Q100 I4 R.3|M2|",
    (
        "O100 SUB|G0 Z-10|G1 X8|X6 Z-5|G3 X4 Z-3 R2|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G72 Q100"
        " I2.5 R.3|M2|"
    ),
    "O100 SUB|G0 X3|G1 Z-4|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G71 Q100 I2.5 R5|M2|",
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|G2 X5 Z-7 I1|G1 X7|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G70"
        " Q100|M2|"
    ),
    (
        "O100 SUB|G0 X4|G1 Z-4|X8 Z-6|X12|O100 ENDSUB|F100|S100 M3|G18 G7 G0 X20 Z1|G71 Q100 I2.5"
        " R.3|M2|"
    ),
    (
        "O100 SUB|G0 X2|G1 Z-4|X4 Z-6|X6|O100 ENDSUB|F100|S100 M3|G18 G0 X10 Z1|G71 Q100 X20 Z3"
        " I2.5 R.3|M2|"
    ),
]


@needs_oracle()
@pytest.mark.parametrize("program", SHAPES)
def test_turning_without_pockets_is_linuxcncs(program):
    text = program.replace("|", "\n")
    reached = re.sub(r"(?s)O100 SUB.*?ENDSUB\n", lambda m: "\n" * m[0].count("\n"), text)
    same_motions(text, oracle.motions(text), reached)


@pytest.mark.parametrize(
    ("cycle", "why"),
    [
        ("G71.1", "without the subroutine"),
        ("G71", "without the subroutine"),
        ("G72.2 Q100", "never ends"),
        ("G71 Q101", "no subroutine"),
        ("G91 G71 Q100", "wants G90"),
        ("G17 G71 Q100", "ZX plane"),
    ],
)
def test_other_turning_of_linuxcnc_is_refused(cycle, why):
    program = Program("part", b"O100 SUB\nG0 X2\nG1 Z-4\nX4 Z-6\nO100 ENDSUB\n")
    resolver = Resolver(program, Tracker(Interpreter(dialects.load("linuxcnc"), MILL)))
    resolver.take(Line(b"G18 G0 X10 Z1 F100", 6))
    with pytest.raises(ProgramError, match=why):
        resolver.take(Line(cycle.encode(), 7))


# -- Fanuc and Haas mills --------------------------------------------------------------------------


def test_fanuc_g81_goes_to_the_initial_level_in_g98_and_to_r_in_g99():
    """B-64304EN-2, G81: positioning, rapid to point R, feed to Z, rapid to R (G99) or the initial
    level (G98)."""
    assert text_of(
        "G0 X0 Y0 Z50|N10 G99 G81 X10. Y20. Z-5. R2. F100 (hole)|G98 X30. M8|G80|X5.", "fanuc-mill"
    ) == [
        "G0 X0 Y0 Z50",
        "N10 G99 G0 X10. Y20. F100 (hole)",
        "Z2.",
        "G1 Z-5.",
        "G0 Z2.",
        "G98 G0 X30. M8",
        "G1 Z-5.",
        "G0 Z50.",
        "G80",
        "G0 X5.",
    ]


def test_behind_g80_the_motion_code_from_before_the_cycle_holds():
    lines = text_of(
        "G0 Z50|G1 X1 F100|G81 X10. Z-5. R2.|G80|M8|X5.|G81 X1. Z-5. R2.|G80 G0 X3", "fanuc-mill"
    )
    assert lines[lines.index("M8") + 1] == "G1 X5." and lines[-1] == "G80 G0 X3"


def test_fanuc_g91_repeats_and_counts_r_from_the_initial_level_and_z_from_r():
    lines = motions(
        expand("G0 X0 Y0 Z50\nG91 G81 X10. Z-12. R-48. K3\nG80\n", "fanuc-mill"), "fanuc-mill"
    )
    assert [m["end"][:3] for m in lines][1:5] == [
        [10, 0, 50],
        [10, 0, 2],
        [10, 0, -10],
        [10, 0, 50],
    ]
    assert [m["end"][0] for m in lines[1:]] == [10] * 4 + [20] * 4 + [30] * 4


def test_fanuc_data_hold_from_cycle_to_cycle_and_through_g90():
    lines = text_of(
        "G0 Z50|G91 G81 X1. Z-12. R-48.|G90 X5.|G82 X6. P500|G99 G85 X7.|X8. K0|G80", "fanuc-mill"
    )
    assert lines[5:] == [
        "G90 G0 X5.", "Z2.", "G1 Z-10.", "G0 Z50.",
        "G0 X6.", "Z2.", "G1 Z-10.", "G4 P500", "G0 Z50.",
        "G99 G0 X7.", "Z2.", "G1 Z-10.", "Z2.", "G80",
    ]  # fmt: skip


def test_fanuc_pecks_reach_q_each_and_the_bottom_exactly():
    """B-64304EN-2, G83: q each, out to R, back to d above the last depth; G73: back by d. d is 0.5
    mm here."""
    deep = text_of("G0 Z50|G99 G83 X1. Z-5. R1. Q2.5", "fanuc-mill")[1:]
    assert deep == [
        "G99 G0 X1.",
        "Z1.",
        "G1 Z-1.5",
        "G0 Z1.",
        "Z-1.",
        "G1 Z-4.",
        "G0 Z1.",
        "Z-3.5",
        "G1 Z-5.",
        "G0 Z1.",
    ]
    chips = text_of("G0 Z50|G99 G73 X1. Z-5. R1. Q2.5", "fanuc-mill")[1:]
    assert chips == [
        "G99 G0 X1.",
        "Z1.",
        "G1 Z-1.5",
        "G0 Z-1.",
        "G1 Z-4.",
        "G0 Z-3.5",
        "G1 Z-5.",
        "G0 Z1.",
    ]


def test_fanuc_g86_stops_the_spindle_and_g89_dwells_before_the_feed_back():
    assert text_of("G0 Z9|M3|G99 G86 Z-1. R2.", "fanuc-mill")[2:] == [
        "G99 G0 Z2.",
        "G1 Z-1.",
        "M5",
        "G0 Z2.",
        "M3",
    ]
    assert text_of("G0 Z9|G99 G89 Z-1. R2. P50", "fanuc-mill")[1:] == [
        "G99 G0 Z2.",
        "G1 Z-1.",
        "G4 P50",
        "Z2.",
    ]


def test_tapping_stays_and_gets_the_words_that_the_control_would_have_held():
    lines = text_of("G0 Z50|G99 G81 X1. Z-5. R2.|G98 G84 X2.|X3.|G80 G0 X9", "fanuc-mill")
    assert lines[5:] == ["G0 Z50.", "G98 G84 X2. R2. Z-5.", "X3.", "G80 G0 X9"]


def test_of_a_cycle_and_another_motion_code_in_a_block_the_last_holds():
    assert text_of("G0 Z50|G81 G1 X5. Z3. F1", "fanuc-mill")[-1] == "G81 G1 X5. Z3. F1"
    assert text_of("G0 Z50|G99 G1 G81 X5. Z-3. R1. F1", "fanuc-mill")[1] == "G99 G0 X5. F1"


def test_haas_pecks_that_grow_less():
    """Haas mill operator's manual, G83 with I J K: first peck I, each less by J, none below K."""
    lines = text_of("G0 Z2.|G99 G83 X1. Z-2. R0. I1. J.4 K.5", "haas")
    assert [float(line[4:]) for line in lines if line.startswith("G1")] == [-1, -1.6, -2]


@pytest.mark.parametrize("code", ["G76", "G87", "G88"])
def test_what_a_parameter_or_the_operator_shapes_is_refused(code):
    with pytest.raises(ProgramError, match="can not be written out"):
        expand(f"G0 Z50\n{code} X1. Z-5. R2. Q.1\n", "fanuc-mill")


def test_an_unknown_place_is_asked_for_and_only_where_it_matters():
    nowhere = replace(MILL, start={}, offsets={})
    with pytest.raises(ProgramError, match="where Z stands") as caught:
        expand("G81 X1. Y1. Z-1. R2.\n", "fanuc-mill", nowhere)
    assert "--start Z0" in caught.value.advice
    assert len(expand("G99 G81 X1. Y1. Z-1. R2.\n", "fanuc-mill", nowhere)) == 5
    with pytest.raises(ProgramError, match="initial level is where Z stood"):
        expand("G99 G81 X1. Y1. Z-1. R2.\nG98 X2.\n", "fanuc-mill", nowhere)
    with pytest.raises(ProgramError, match="an offset in force is not stated"):
        expand(
            "G0 Z50\nG43 H1\nG81 X1. Y1. Z-1. R2.\n",
            "fanuc-mill",
            replace(nowhere, start={"Z": 0.0}),
        )
    assert expand("G0 G43 H1 Z50\nG81 X1. Y1. Z-1. R2.\n", "fanuc-mill", nowhere)


# -- Fanuc lathes ----------------------------------------------------------------------------------


def lathe(program: str, dialect: str = "fanuc-lathe-a") -> list[str]:
    return text_of(program, dialect, LATHE)


def test_g90_of_system_a_is_g77_of_b_and_g20_of_c():
    """B-64304EN-1, "Outer diameter/internal diameter cutting cycle": rapid in, cut, feed out, rapid
    back; X holds."""
    for code, dialect in (
        ("G90", "fanuc-lathe-a"),
        ("G77", "fanuc-lathe"),
        ("G20", "fanuc-lathe-c"),
    ):
        assert lathe(f"G0 X60. Z2.|{code} X50. Z-30. F.2|X45. M8|G0 X100.", dialect) == [
            "G0 X60. Z2.",
            "G0 X50. F.2", "G1 Z-30.", "X60.", "G0 Z2.",
            "G0 X45. M8", "G1 Z-30.", "X60.", "G0 Z2.", "G0 X100.",
        ]  # fmt: skip


def test_tapers_of_g90_and_g94():
    """The same, "Taper cutting cycle": with U<0 W<0 R<0 the cut begins on a smaller radius, by R,
    than it ends on."""
    assert lathe("G0 X60. Z2.|G90 U-10. W-32. R-5.")[1:] == [
        "G0 X40.",
        "G1 X50. Z-30.",
        "X60.",
        "G0 Z2.",
    ]
    assert lathe("G0 X60. Z2.|G94 X20. Z-5. R-1.")[1:] == [
        "G0 Z-6.",
        "G1 X20. Z-5.",
        "Z2.",
        "G0 X60.",
    ]


def test_g71_cuts_by_d_down_to_the_shape_and_then_along_it():
    """B-64304EN-1, "Stock removal in turning (G71)", type I: C is A moved by du/2 and dw, cuts dd
    apart, escape e at 45 degrees, the last cut along the shape, and back to A. Levels: radius 50.5
    - 4 n above 20.5."""
    lines = lathe(
        "G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5 F.3|N10 G0 X40.|G1 Z-20. F.1|N20 X100."
        " Z-50.|G0 X200."
    )
    assert lines[1] == "G0 X101. Z2.5 F.3"
    levels = [2 * (50.5 - 4 * n) for n in range(1, 8)]
    assert [line for line in lines if re.fullmatch(r"X[\d.]+", line)][:-1] == [
        f"X{x:g}." for x in levels
    ]
    ends = [-19.5 - (x - 41) / 2 for x in levels]  # the shape falls by 30 mm in radius over 30 mm
    assert [float(line[4:]) for line in lines if line.startswith("G1 Z")][:-1] == pytest.approx(
        ends
    )
    assert lines[4] == f"G0 X{levels[0] + 2:g}. Z{ends[0] + 1:g}"
    assert lines[-5:] == ["X41.", "G1 Z-19.5", "X101. Z-49.5", "G0 X100. Z2.", "G0 X200."]


def test_g71_ends_its_cuts_on_arcs():
    """The fillet is a circle about (Z-30, X80), radius 10; level radius 38.5: Z = -30 - sqrt(100 -
    2^2) + 0.5."""
    lines = lathe(
        "G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5|"
        "N10 G0 X40.|G1 Z-20.|X60. Z-30.|G2 X80. Z-40. R10.|N20 G1 X100.|G0 Z9."
    )
    assert lines[lines.index("X77.") + 1] == f"G1 Z{-30 - (100 - 2**2) ** 0.5 + 0.5:.3f}"
    assert "G2 X81. Z-39.5 R10." in lines


def test_g72_is_g71_with_the_axes_changed_over_and_g70_follows():
    lines = lathe(
        "G0 X100. Z2.|G72 W4. R1.|G72 P10 Q20|N10 G0 Z-9.|G1 X80.|N20 X60. Z1.|G70 P10 Q20"
        " F.1|G0 Z9."
    )
    assert lines[1:5] == ["G0 Z-2.", "G1 X66.", "G0 X68. Z-1.", "X100."]
    assert lines[-10:] == [
        "Z-9.", "G1 X80.", "X60. Z1.", "G0 X100. Z2.",
        "F.1", "N10 G0 Z-9.", "G1 X80.", "N20 X60. Z1.", "G0 X100. Z2.", "G0 Z9.",
    ]  # fmt: skip


def test_one_block_form_and_internal_shapes():
    lines = lathe(
        "G0 X20. Z2.|G71 P10 Q20 U-1. W.5 D3000|N10 G1 X60.|Z-20.|X40. Z-30.|N20 X20.|G0 Z9."
    )
    assert lines[1:6] == ["G0 X19. Z2.5", "G1 X25.", "Z-29.5", "G0 X24. Z-29.", "Z2.5"]


def test_g73_repeats_the_shape_nearer_each_time():
    """B-64304EN-1, "Pattern repeating (G73)": di, dk shared over d cuts, the last one du/2 and dw
    off."""
    lines = lathe(
        "G0 X100. Z2.|G73 U6. W3. R3|G73 P10 Q20 U1. W.5|N10 G0 X40. Z0.|N20 G1 Z-20.|G0 Z9."
    )
    assert lines[1:-1] == [
        "G0 X113. Z5.5",
        "X53. Z3.5",
        "G1 Z-16.5",
        "G0 X107. Z4.",
        "X47. Z2.",
        "G1 Z-18.",
        "G0 X101. Z2.5",
        "X41. Z0.5",
        "G1 Z-19.5",
        "G0 X100. Z2.",
    ]


def test_g74_and_g75_peck_by_least_increments():
    """B-64304EN-1, "End face peck drilling (G74)", "Outer diameter drilling (G75)": P, Q count
    0.001 mm, radius."""
    lines = lathe("G0 X100. Z2.|G74 R1.|G74 X88. Z-6. P6000 Q5000|X20.")
    one = ["G1 Z-3.", "G0 Z-2.", "G1 Z-6.", "G0 Z2."]
    assert lines[1:] == [*one, "X88.", *one, "X100.", "G0 X20."]
    lines = lathe("G0 X100. Z2.|G75 R.5|G75 X90. Z-2. P3000 Q4000|G0 X120.")
    one = ["G1 X94.", "G0 X95.", "G1 X90.", "G0 X100."]
    assert lines[1:] == [*one, "Z-2.", *one, "Z2.", "G0 X120."]


def test_g12_and_g13_of_haas_are_circles_about_where_the_tool_stands():
    """Manual: I is the finished radius, less the tool's, 5: 10. I 8 by Q 5 to K 15 is 8, 13, 15: 3,
    8, 10. All arcs; the last circle is gone round in two halves, and half a circle leads in and
    out."""
    setup = replace(MILL, offsets={"D1": {"R": 5.0}}, start=dict.fromkeys("XYZABC", 0.0))
    lines = text_of("G90 G17 G0 X10. Y20. Z1.|G13 I15. D1 Z-2. F100.|G0 Z9.", "haas", setup)
    ring = [
        "G3 X20. Y20. I5. J0.",
        "X0. Y20. I-10. J0.",
        "X20. Y20. I10. J0.",
        "X10. Y20. I-5. J0.",
    ]
    assert lines[1:] == ["G1 Z-2. F100.", *ring, "G0 Z9."]
    lines = text_of("G90 G17 G0 X10. Y20. Z1.|G12 I8. K15. Q5. D1|G0 Z9.", "haas", setup)
    ends = [float(re.search(r"X(-?[0-9.]+)", line)[1]) - 10.0 for line in lines[1:-1]]
    assert ends == [3.0, -3.0, 3.0, -8.0, 8.0, -8.0, 10.0, -10.0, 10.0, 0.0]
    assert lines[1].startswith("G2 ") and not any("Z" in line for line in lines[1:-1])
    lines = text_of("G17 G0 X0. Y0. Z0.|G91 G13 I8. D0 Z-1. L2|G90 G0 Z9.", "haas", setup)
    assert (
        lines.count("G1 Z-1.") + lines.count("G91 G1 Z-1.") == 2
        and lines[2] == "G3 X8. Y0. I4. J0."
    )


def test_lathe_drilling_counts_r_from_where_it_stands():
    """B-64304EN-1, "Front drilling cycle (G83)", "Side drilling (G87)": R is a distance from the
    initial level."""
    assert lathe("G0 X0 Z5.|G83 Z-4. R-3. F.1", "fanuc-lathe")[1:] == [
        "G0 Z2. F.1",
        "G1 Z-4.",
        "G0 Z5.",
    ]
    lines = lathe("G0 X50. Z5.|G99 G87 X20. Z-3. R-5. Q6000 P100", "fanuc-lathe")
    assert lines[1:] == [
        "G99 G0 Z-3.",
        "X40.",
        "G1 X28.",
        "G0 X40.",
        "X29.",
        "G1 X20.",
        "G4 P100",
        "G0 X40.",
    ]


def test_holes_of_a_haas_lathe_go_to_r_as_a_place_and_back_to_where_they_began():
    """Haas lathe operator's manual, G83, G85, G243; written as Autodesk's `haas lathe.cps` writes a
    hole: to the clearance, then X Z R F, G80. R of a radial hole is a diameter, pecks are radii: X
    46 less 2 x 2 is 42, and 40 is the bottom."""
    lines = lathe("G18|G0 X0. Z5.|G0 Z5.|G83 X0. Z-4. R2. Q4. P500 F.1|G80|G0 Z5.", "haas-lathe")
    assert lines[3:] == [
        "G0 X0. F.1",
        "Z2.",
        "G1 Z-2.",
        "G0 Z2.",
        "Z-1.5",
        "G1 Z-4.",
        "G4 P500",
        "G0 Z5.",
        "G80",
        "G0 Z5.",
    ]
    lines = lathe("G19|G0 X50. Z-10.|G243 X40. Z-10. R46. Q2. F.1|G80|G0 X60.", "haas-lathe")
    assert lines[2:-2] == [
        "G0 Z-10. F.1",
        "X46.",
        "G1 X42.",
        "G0 X46.",
        "X43.",
        "G1 X40.",
        "G0 X50.",
    ]
    lines = lathe("G0 X20. Z5.|G85 X20. Z-8. R2. F.1|U4.|G80", "haas-lathe")
    assert lines[1:-1] == [
        "G0 X20. F.1",
        "Z2.",
        "G1 Z-8.",
        "Z2.",
        "G0 Z5.",
        "G0 U4.",
        "Z2.",
        "G1 Z-8.",
        "Z2.",
        "G0 Z5.",
    ]


def test_a_haas_lathes_hole_without_r_begins_where_the_tool_stands():
    assert lathe("G0 X0. Z2.|G81 Z-8. F.1|G80", "haas-lathe")[1:] == [
        "G1 Z-8. F.1",
        "G0 Z2.",
        "G80",
    ]


def test_where_a_haas_lathe_ends_behind_a_hole_is_said_and_nothing_counts_from_there():
    resolver = Resolver(
        Program("part", b""), Tracker(Interpreter(dialects.load("haas-lathe"), LATHE))
    )
    for n, one in enumerate(["G0 X20. Z5.", "G81 Z-8. R2. F.1", "G80", "G0 X30."], 1):
        resolver.take(Line(one.encode(), n))
    (notice,) = resolver.scene.notices
    assert (
        "goes back to Z5." in notice.message and "at R, Z2." in notice.message and notice.line == 2
    )
    with pytest.raises(ProgramError, match="W1. counts from where the cycle left Z"):
        resolver.take(Line(b"W1.", 5))
    assert resolver.take(Line(b"Z9.", 6))[0].text == b"Z9."
    assert resolver.take(Line(b"W1.", 7))[0].text == b"W1."


def test_threads_of_a_lathe_stay_and_end_where_they_began():
    program = (
        "G0 X30. Z2.|G92 X29. Z-20. F1.5|X28.5|G0 X40.|G76 P011060 Q100 R.05|G76 X28. Z-20. P900"
        " Q300 F1.5|G90 U-2. Z-5."
    )
    assert lathe(program)[:6] == program.split("|")[:6] and lathe(program)[6] == "G0 X38."


def test_g74_and_g75_in_one_block_have_i_along_x_and_k_along_z():
    """Haas lathe operator's manual, G74, G75; Fanuc's Series 10/11 format: I steps or pecks along
    X, a radius, K along Z.
    X 100 to 88 by a radius of 3: 94 and 88; Z 2 to -6 by 5: -3 and -6, each 0.5 mm back in place of
    setting 22."""
    one = ["G1 Z-3.", "G0 Z-2.5", "G1 Z-6.", "G0 Z2."]
    over = ["G1 X94.", "G0 X95.", "G1 X88.", "G0 X100."]
    for dialect in ("haas-lathe", "fanuc-lathe-a"):
        lines = lathe("G0 X100. Z2.|G74 X88. Z-6. I3. K5. F.1|G0 X120.", dialect)
        first = ["G1 Z-3. F.1", *one[1:]]
        assert lines[1:] == [*first, "X94.", *one, "X88.", *one, "X100.", "G0 X120."]
        lines = lathe("G0 X100. Z2.|G75 U-12. W-8. I3. K5. D0|G0 X120.", dialect)
        assert lines[1:] == [*over, "Z-3.", *over, "Z-6.", *over, "Z2.", "G0 X120."]


def test_the_taper_of_g90_and_g94_is_i_and_k_in_one_block_formats():
    """Series 10/11 format, and Haas: I and K are what R is above."""
    for dialect in ("haas-lathe", "fanuc-lathe-a"):
        lines = lathe("G0 X60. Z2.|G90 U-10. W-32. I-5.", dialect)
        assert lines[1:] == ["G0 X40.", "G1 X50. Z-30.", "X60.", "G0 Z2."]
        lines = lathe("G0 X60. Z2.|G94 X20. Z-5. K-1.", dialect)
        assert lines[1:] == ["G0 Z-6.", "G1 X20. Z-5.", "Z2.", "G0 X60."]


NOSE = (
    "G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5|N10 G0 G42 X40.|G1 Z-20.|N20 G40 X100. Z-50.|G70"
    " P10 Q20|G0 X200."
)


def test_nose_radius_compensation_in_the_shape_holds_in_g70_and_a_notice_says_so():
    """The roughing is the one without it; G70 runs the blocks as they stand, and goes back without
    it."""
    resolver = Resolver(
        Program("part", b""), Tracker(Interpreter(dialects.load("fanuc-lathe-a"), LATHE))
    )
    program = NOSE.split("|")
    resolver.program = Program("part", NOSE.replace("|", "\n").encode())
    lines = [
        x.text.decode()
        for n, one in enumerate(program, 1)
        for x in resolver.take(Line(one.encode(), n))
    ]
    assert lines[-5:] == [
        "N10 G0 G42 X40.",
        "G1 Z-20.",
        "N20 G40 X100. Z-50.",
        "G0 X100. Z2.",
        "G0 X200.",
    ]
    assert lines[:-5] == lathe(NOSE.replace("G42 ", "").replace("G40 ", ""))[:-5]
    [notice] = resolver.scene.notices
    assert notice.line == 3 and notice.message.startswith(
        "G42 in the shape of G71 holds in G70 alone"
    )


def test_the_nose_of_a_haas_is_led_along_the_shape_of_the_roughing_too():
    """Haas lathe manual, "TNC with a G71 Roughing Canned Cycle": the last cut has G42; the rapid
    with G40 is no shape."""
    program = (
        "G0 X100. Z2.|G71 P10 Q20 U1. W.5 D4.|N10 G0 G42 X40. Z2.|G1 Z-20.|X100. Z-50.|N20 G0 G40"
        " Z2.|G0 X200."
    )
    lines = text_of(program, "haas-lathe", LATHE)
    assert lines[-5:] == [
        "G0 G42 X41.",
        "G1 Z-19.5",
        "X101. Z-49.5",
        "G0 G40 X100. Z2.",
        "G0 X200.",
    ]
    bare = program.replace("G42 ", "").replace("|X100. Z-50.|N20 G0 G40 Z2.", "|N20 X100. Z-50.")
    assert [x.replace("G0 G42 ", "").replace(" G40", "") for x in lines[:-1]] == text_of(
        bare, "haas-lathe", LATHE
    )[:-1]


def test_a_mill_drills_without_r_from_where_it_stands():
    """B-63534EN, "Canned cycle cancel": G80 leaves R = 0 and Z = 0 in incremental command."""
    assert text_of("G0 Z9.|G98 G81 X5. Z-1.", "haas")[1:] == ["G98 G0 X5.", "G1 Z-1.", "G0 Z9."]
    assert text_of("G0 Z9.|G98 G81 X5. Z-1.|X6. R2.", "haas")[-4:] == [
        "G0 X6.",
        "Z2.",
        "G1 Z-1.",
        "G0 Z9.",
    ]
    assert text_of("G0 Z9.|G91 G98 G81 X5. Z-3.", "fanuc-mill")[-2:] == ["G1 Z-3.", "G0 Z3."]


def test_haas_dwells_behind_the_last_peck():
    """Haas mill operator's manual, G73, G83: P is a dwell behind the last peck."""
    for code in ("G73", "G83"):
        assert text_of(f"G0 Z9.|G99 {code} Z-1. R2. Q3. P.5", "haas")[-3:] == [
            "G1 Z-1.",
            "G4 P.5",
            "G0 Z2.",
        ]


HAAS_REFUSED = {
    "haas": {
        "G83 Z-9. R2. Q2. I1.": "Q and I of G83 together",
        "G73 Z-9. R2. Q2. K6.": "Q and K of G73 together",
        "G83 Z-9. R2. I2. J.5": "I and J of G83 together",
        "G81 Z-9. R2. P500": "P in a drilling cycle",
        "G12 I8. X5. D0": "X in a pocket cycle .G12.: that is no word of it",
        "G13 I8. D7": "the tool's radius D7 of G13 is not stated",
    },
    "haas-lathe": {
        "G71 P10 Q20 D2. R1|N10 G0 X40.|G1 Z-5.|X30.|N20 Z-9.": "X turns back|goes deeper",
        "G71 P10 Q20 D2. I.5|N10 G0 X40.|N20 G1 Z-5.": (
            "I.5 in a turning cycle .G71.: the allowance of a rough"
        ),
        "G73 P10 Q20 D2 I1.|N10 G0 G42 X40.|N20 G1 G40 Z-5.": "G42 in the shape of G73",
        "G74 X50. Z-5. K1. D.2": "draws the tool aside",
        "G74 Z-5. Q1000": "Q in a grooving cycle .G74.: that is no word of it",
        "G81 X50. W-5. R2.": (
            "W-5. in a drilling cycle .G81.: from where it counts the bottom is not certain"
        ),
        "G241 Z-5. U-5. R2.": (
            "U-5. in a drilling cycle .G241.: from where it counts the bottom is not certain"
        ),
        "G83 Z-9. R2. Q2. K1.": "Q and K of G83 together",
        "G87 Z-9. R2.": "G87 can not be written out: the operator draws the tool out by hand",
    },
}


@pytest.mark.parametrize(
    ("dialect", "program"), [(d, p) for d, programs in HAAS_REFUSED.items() for p in programs]
)
def test_what_haas_means_otherwise_is_refused(dialect, program):
    with pytest.raises(ProgramError, match=HAAS_REFUSED[dialect][program]):
        text_of("G0 X100. Z12.|" + program, dialect, MILL if dialect == "haas" else LATHE)


LATHE_REFUSED = {
    "G71 U2. R1.|G71 P10 Q20 R1.|N10 G0 X40.|N20 G1 Z-5.": "type II",
    "G71 U2. R1.|G71 P10 U1.|N10 G0 X40.|N20 G1 Z-5.": "number of a block in Q",
    "G71 U2. R1.|G71 P10 Q20.5|N10 G0 X40.|N20 G1 Z-5.": "number of a block in Q",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G1 Z-5.|N20 G0 X100. Z2.": (
        "last block of the shape takes Z back"
    ),
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G1 Z-5.|N20 X30. Z-9.": "goes deeper in X",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40. M8|N20 G1 Z-5.": (
        "M8 in the shape of a cycle, in 'N10 G0 X40. M8'"
    ),
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5. R2.": "behind its last line",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|G4 X1.|N20 G1 Z-5.": "G4 in the shape",
    "G70 P10 Q20|N10 G0 G42 X40.|N20 G1 Z-5.": "G42 is still on at the end",
    "G42 G1 X90.|G90 X80. Z-5.": "compensation on",
    "G71": "without its words",
    "G74 R1. Z-5.": "draws the tool aside",
    "G74 Z-5. Q1000 K1.": "Q and K both",
    "G90 X50. Z-5. R1. I1.": "both say the taper",
    "G90 X50. U-5. Z-5.": "X is named twice",
    "G90 X50. Z-5.|C9.": "C in a block within G90",
    "G83 Z-5. R-1. K2 L2": "both say how often",
    "G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5.": "depth of cut is not in the program",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 Z0.|N20 G1 Z-5.": "does not go to its depth in X",
    "G71 U2. R1.|G71 P10 Q30|N10 G0 X40.|N20 G1 Z-5.": "no block N30",
    "G71 U2. R1.|G71 P11 Q20|N10 G0 X40.|N20 G1 Z-5.": "no block N11",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|Z-5.|X30. Z-9.|N20 X100.": "turns back",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5. ,R2.": "behind its last line",
    "G71 U2. R1.|G71 P10 Q20|N10 G0 X40.|N20 G1 Z-5.|X1.": "no motion code is named",
    "G73 U2.|G73 P10 Q20|N10 G0 X40.|N20 G1 Z-5.": "how often",
    "G74 X50. Z-5. P1000 Q1000 R.2": "draws the tool aside",
    "G83 Z-5. C90. M31": "clamps",
    "G90 X50.": "without Z",
}


@pytest.mark.parametrize("program", LATHE_REFUSED)
def test_lathe_cycles_that_can_not_be_vouched_for_are_refused(program):
    with pytest.raises(ProgramError, match=LATHE_REFUSED[program]) as caught:
        lathe("G0 X100. Z2.|" + program)
    assert caught.value.advice


# -- laws ------------------------------------------------------------------------------------------

CONTROLS = [
    "linuxcnc",
    "fanuc-mill",
    "haas",
    "fanuc-lathe",
    "fanuc-lathe-a",
    "fanuc-lathe-c",
    "siemens",
    "grbl",
]


@pytest.mark.parametrize("dialect", CONTROLS)
def test_a_program_without_cycles_and_frames_comes_out_unchanged(dialect):
    text = (
        "%\n(a)\nN10 G0 X1. Y2. Z5 ; b\n/G1X3.Y-.5F100\n\tG2 X4 Y1 I0.5 J.5\r\nM3 S100\nG4"
        " P1\nM5\n\nM30\n%\n"
    )
    lines = expand(text, dialect)
    assert [line.text for line in lines] == [line.encode() for line in text.split("\n")]
    assert [line.source for line in lines] == list(range(1, len(lines) + 1))


def test_several_blocks_in_a_line_become_several_lines():
    assert blocks(b"G1 X1 (;) ; X2;", dialects.load("fanuc-mill").grammar) == [
        b"G1 X1 (;) ",
        b" X2",
    ]
    lines = expand("G0 Z9; G99 G81 X1. Z-1. R2.; X2.; G80", "fanuc-mill")
    assert [line.source for line in lines] == [1] * len(lines)
    assert [line.text for line in lines][1:] == [
        b" G99 G0 X1.", b"Z2.", b"G1 Z-1.", b"G0 Z2.", b" G0 X2.", b"G1 Z-1.", b"G0 Z2.", b" G80",
    ]  # fmt: skip


def test_comments_stay_and_end_a_number():
    block = Block.of(b"N1 G81 X1 (hole 1) Y2(b)Z-3 R1", dialects.load("linuxcnc").grammar)
    assert [w.raw for w in block.words] == ["1", "81", "1", "2", "-3", "1"]
    assert block.written({1, 4, 5}, b"G0") == b"N1 G0 X1 (hole 1) Y2(b)"


def test_block_delete_marks_every_line_that_a_marked_block_becomes():
    lines = text_of("G0 Z9|/G99 G81 X1. Z-1. R2.|G80", "fanuc-mill")
    assert lines == ["G0 Z9", "/G99 G0 X1.", "/Z2.", "/G1 Z-1.", "/G0 Z2.", "G80"]
    skipped = replace(MILL, block_delete=True)
    assert (
        text_of("G0 Z9|/G99 G81 X1. Z-1. R2.|G80", "fanuc-mill", skipped)[1]
        == "/G99 G81 X1. Z-1. R2."
    )


@pytest.mark.skipif(not CORPUS.exists(), reason="no corpus of real programs here")
@pytest.mark.parametrize("name", ["G81", "G81_G91", "G82", "G83"])
def test_real_programs_are_written_out_hole_by_hole(name):
    text = (CORPUS / f"{name}.NC").read_bytes()
    interpreter = Interpreter(dialects.load("fanuc-mill"), replace(MILL, start={}, offsets={}))
    out = b"".join(Written(Program(name, text), interpreter, Limits()))
    assert not re.search(rb"G8[1-9]", out)
    # G91: Z counts from R, 2 mm above zero
    bottom = rb"G1\s*Z-(118|120)\." if name == "G81_G91" else rb"G1\s*Z-20\."
    assert len(re.findall(bottom, out)) == 12


WORDS = """G81 G82 G83 G73 G84 G85 G86 G89 G76 G70 G71 G72 G74 G75 G77 G78 G79 G90 G91 G92 G94 G98 G99 G80 G0 G1 G2 G3
G17 G18 G19 G20 G21 G24 G68 G69 G51 G50 G51.1 G50.1 G15 G16 G10 L2 P1 P10 Q20 N10 N20 G54 G55 G43 H1 G49 G4 G28 G53 M3
M5 M30 T1 T0101 ROT AROT TRANS ATRANS MIRROR SCALE ASCALE AMIRROR G110 G111 AP=30 RP=5 RPL=30 CR=3 X=IC(3) I=AC(2) G7
G90.1 G41 G40 G93 (c) ;x / % ( $1 #1 [ * " \x00 \xe9 1e5 X99999999999999999999""".split()  # noqa: E501


@pytest.mark.parametrize("seed", range(8))
def test_no_bytes_make_it_stumble(seed):
    """Only sentences for the user may come out, whatever goes in."""
    draw = random.Random(seed)
    for _ in range(150):
        dialect = draw.choice(CONTROLS)
        text = draw.choice(["", "G90 G0 X50 Y1 Z5\n", "G0 X50. Z5.\nM3 S100\nF10\n"])
        for _ in range(draw.randint(1, 12)):
            words = [
                (
                    draw.choice(WORDS)
                    if draw.random() < 0.5
                    else draw.choice("XYZXYZUWIJKRQPFDEHLC")
                    + draw.choice([f"{draw.uniform(-20, 20):.3f}", ".5", "0", "", "-1"])
                )
                for _ in range(draw.choice([0, 1, 2, 3, 3, 4, 6]))
            ]
            text += draw.choice([" ", ""]).join(words) + "\n"
        try:
            expand(text, dialect, draw.choice([MILL, LATHE]))
        except ProgramError as error:
            assert error.message and error.place is not None, text
