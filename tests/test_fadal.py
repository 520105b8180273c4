"""Fadal format 1: fixture offsets by E, lengths by H, subroutines; and Z behind M6."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import lines_of
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.offsets import canonical
from postproc.units import TICKS_PER_MM

SETUP = Setup(
    axes=("X", "Y", "Z"),
    least_increment=dict.fromkeys("XYZ", 1e-4),
    start=dict.fromkeys("XYZ", 0.0),
    offsets={
        "E1": {"X": 100.0},
        "E2": {"X": 7.0, "Z": -1.0},
        "H3": {"Z": 9.0},
        "G54": {"X": 500.0},
    },
)
SUBS = "N1 O1 (PLATE)\nL100\nX1. Y2.\nX3. Y4.\nM17\nL200\nL101\nX5. Y6.\nM17\nM30\nG0 X0. Y0.\n"


def follow(text: str, name: str = "fadal"):
    """Ends of the motions (mm, machine coordinates), whether they are known, and why not."""
    dialect = dialects.load(name)
    interpreter = Interpreter(dialect, SETUP)
    words = lex(text.replace("|", "\n").encode() + b"\n", dialect.grammar, False)
    assert words.fault is None, words.fault
    motions, _, _ = interpreter.run(words, interpreter.initial())
    ends = (motions.target / TICKS_PER_MM).T.tolist()
    return ends, motions.target_known.T.tolist(), [motions.reasons[r][0] for r in motions.reason]


def run(text: str) -> list[str]:
    """The lines as the control executes them."""
    tracker = Tracker(Interpreter(dialects.load("fadal"), SETUP))
    program = Program("part.nc", text.encode())
    return [line.text.decode() for line in lines_of("fadal", program, tracker, Limits())]


def test_e_moves_the_zero_and_h_the_length_at_once():
    """E0 and H0 are none; in format 2 G55 is E2 (fadal.cps, onlyENumbers)."""
    ends, _, reasons = follow(
        "G90 G0 X1. Y2. Z3.|E1 X1.|H3 Z5.|E2 X1. Z5.|G0 G90 H0 E0 Z0.|G55 X1.|G56 E1 X2."
    )
    assert not any(reasons)
    assert ends[0] == [1.0, 2.0, 3.0], "before any E the machine's own zero"
    assert ends[1][0] == 101.0
    assert ends[2][2] == 14.0
    assert (ends[3][0], ends[3][2]) == (8.0, 13.0)
    assert ends[4][2] == 0.0
    assert ends[5][0] == 8.0
    assert ends[6][0] == 102.0


def test_an_offset_that_nobody_stated_is_asked_for_by_its_name():
    _, _, reasons = follow("G90 G0 E7 X1.")
    assert reasons == ["the work offset E7 is not stated"]
    assert canonical("E7") == "E7"


@pytest.mark.parametrize("r", ["R0+2.", "R+2.", "R2."])
def test_r0_with_a_sign_is_the_level(r):
    ends, _, reasons = follow(f"G90 G0 X0. Y0. Z9.|G98 G81 X1. Y1. Z-3. {r} F90.|G80")
    assert not any(reasons)
    assert ends[-1][2] == 9.0


def test_p_and_q_of_a_cycle_that_has_no_use_for_them_do_nothing():
    ends, _, reasons = follow("G90 G0 X0. Y0. Z9.|G99 G81 X1. Z-3. R2. F90. Q2. P0.5|G83 Z-3.|G80")
    assert not any(reasons)
    assert ends[-1] == [1.0, 0.0, 2.0]


def test_subroutines_run_where_they_are_called():
    lines = run(SUBS + "L102\nL201\nM2\n")
    holes = ["X1. Y2.", "X3. Y4."]
    assert lines == ["N1 O1 (PLATE)", "G0 X0. Y0.", *holes, *holes, *holes, "X5. Y6.", "M2"]


def test_holes_of_a_subroutine_have_the_words_of_the_cycle_before():
    lines = run(SUBS + "G0 Z9.\nN8 G98 G81 X0 Y0 Z-3. R2. F90. L0\nL101\nG80\nM2\n")
    assert lines[2:-1] == ["G0 Z9.", "N8 G98 G81 Z-3. R2. F90. X1. Y2.", "X3. Y4.", "G80"]
    ends, _, reasons = follow("E0|" + "|".join(lines[1:]))
    assert not any(reasons)
    assert [end[:2] for end in ends][-2:] == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize("name", ["haas", "fadal", "fanuc-mill"])
def test_behind_a_tool_change_nobody_knows_z(name):
    """M6 takes Z up (Haas 96-8210, "M06"; a Fanuc's macro): a Z that is put into the next block in
    X and Y would take the new tool down before its length holds."""
    _, known, _ = follow("G90 G54 G0 X1. Y1. Z9.|T2 M6|G0 X5. Y5.|G43 H3 Z5.|X6.", name)
    assert [row[2] for row in known] == [True, False, True, True]
    assert all(row[0] for row in known)


@pytest.mark.parametrize(
    "name",
    ["centroid", "fagor", "heidenhain-iso", "linuxcnc-pathpilot", "okuma", "siemens"],
)
def test_behind_a_tool_change_that_the_machine_defines_nobody_knows_z(name):
    """What M6 does is a macro or cycle of the machine (PathPilot's remap, the builder's elsewhere).
    NIST RS274/NGC 3.6.3 takes the axes back, as LinuxCNC does as delivered; those need not."""
    _, known, _ = follow("G90 G0 X1. Y1. Z9.|T2 M6|G0 X5. Y5.|Z5.|X6.", name)
    assert [row[2] for row in known] == [True, False, True, True]
    assert all(row[0] for row in known)


@pytest.mark.parametrize("name", ["haas", "fadal", "fanuc-mill"])
def test_a_distance_behind_a_tool_change_counts_from_where_z_stood(name):
    """A program that goes on in G91 means that the change takes Z back there; behind G91 G28 Z0 and
    M6 the mode alone says nothing, and a place is awaited."""
    ends, known, _ = follow("G90 G54 G0 X1. Y1. Z9.|G91|T2 M6|X5. Y5.|Z-3.|X6.", name)
    assert all(row[2] for row in known)
    assert ends[-1][2] == ends[0][2] - 3.0
    _, known, _ = follow("G90 G54 G0 X1. Y1. Z9.|G91 G28 Z0|T2 M6|G90 X5. Y5.|G43 H3 Z5.", name)
    assert [row[2] for row in known][-2:] == [False, True]


def test_a_repeated_block_is_refused():
    with pytest.raises(Exception, match="the control runs the block several times"):
        follow("G90 G0 X0. Y0.|G91 G3 I-1. Z-.3 L10")


def test_a_routine_that_the_text_has_not_is_refused():
    with pytest.raises(ProgramError, match="there is no subroutine L9300 "):
        run(SUBS + "L9304\nM2\n")
