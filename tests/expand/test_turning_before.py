"""Lathes' repetitive cycles and what stands before them: nose radius compensation, numbers that
stand twice, variables in the shape, words that say nothing."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.expand.written import lines_of
from postproc.nc.interpreter import Interpreter
from tests.expand.plain_lines import LATHE

SHAPE = "N10 G0 X40.|G1 Z-20.|N20 X100. Z-50."


def written(program: str, dialect: str = "fanuc-lathe-a") -> tuple[list[str], list[str]]:
    """The plain lines of a program with | between its lines, run by its language, and the
    notices."""
    text = Program("part", program.replace("|", "\n").encode())
    tracker = Tracker(Interpreter(dialects.load(dialect), LATHE))
    resolver = Resolver(text, tracker)
    plain = []
    for line in lines_of("fanuc", text, tracker, Limits()):
        for new in resolver.take(line):
            plain.append(new.text.decode().strip())
            tracker.take(new.text)
    return [line for line in plain if line], [n.message for n in resolver.scene.notices]


def test_g42_before_g70_goes_on_through_the_shape_and_rests_on_the_way_back():
    """B-64304EN-1, "Multiple repetitive cycle": named before the cycle; "offset is temporarily
    canceled" at the return to the start point, "start-up is performed again" behind it."""
    begin = f"G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20 U1. W.5|{SHAPE}|"
    lines, notices = written(begin + "G42 G0 X100. Z2.|G70 P10 Q20 F.1|G40 G0 X110. Z5.")
    assert lines[-7:] == [
        "F.1",
        *SHAPE.split("|"),
        "G0 G40 X100. Z2.",
        "G42",
        "G40 G0 X110. Z5.",
    ]
    assert not notices
    assert lines[:-8] == written(begin)[0]


def test_g42_before_g71_holds_in_the_last_cut_which_a_notice_says():
    """The same place: the figure is the compensated one. Here the last cut has it."""
    begin = "G0 X100. Z2.|{}|G71 U4. R1.|G71 P10 Q20 U1. W.5 F.3|" + SHAPE
    lines, notices = written(begin.format("G42 G0 X110."))
    bare, _ = written(begin.format("G0 X110."))
    assert lines[2] == "G40 F.3" and lines[-1] == "G42" and lines[-2] == "G0 G40 X110. Z2."
    last = next(i for i, x in enumerate(lines) if "G42" in x and i > 1)
    assert lines[last] == "G0 G42 X41."
    bare_words = [x.removeprefix("G0 ") for x in bare[2:]]
    without = [x.replace(" G42", "").replace(" G40", "").removeprefix("G0 ") for x in lines[3:-1]]
    assert without == [bare_words[0].replace(" F.3", ""), *bare_words[1:]]
    [said] = notices
    assert said.startswith("G42 before G71 holds in the cut along the shape: those before it end")


def test_g41_before_g73_holds_in_each_cut():
    lines, notices = written(
        "G0 X10. Z2.|G41 G0 X11.|G73 U-1. R2|G73 P10 Q20 U-.4|N10 G0 X40.|N20 G1 Z-20.|G40 G0 X9."
    )
    assert lines[2:] == [
        "G40", "G0 X8.6",
        "G0 G41 X37.6", "G1 Z-20.", "G0 G40 X8.6 Z2.",
        "G0 X10.6", "G0 G41 X39.6", "G1 Z-20.", "G0 G40 X10.6 Z2.",
        "G0 X11.", "G41", "G40 G0 X9.",
    ]  # fmt: skip
    assert len(notices) == 1


@pytest.mark.parametrize(
    ("program", "dialect", "said"),
    [
        ("G42 G0 X9.|G70 P1 Q2|N1 G0 G42 X5.|N2 G1 G40 Z-5.", "fanuc-lathe-a", "the control stops"),
        ("G42 G0 X9.|G70 P1 Q2|N1 G0 X5.|N2 G1 Z-5.", "haas-lathe", "G42 in the first block of"),
        ("G71 P1 Q2 D1.|N1 G0 X5.|N2 G1 Z-5.|G70 P1 Q2 U.1", "haas-lathe", "no word of it"),
        ("G71 P1 Q2 D1.|N1 G0 X#1|#2=5|N2 G1 Z-5.", "fanuc-lathe-a", "more than words"),
    ],
)
def test_what_is_refused(program, dialect, said):
    with pytest.raises(ProgramError) as refused:
        written("G0 X20. Z2.|" + program, dialect)
    assert said in f"{refused.value.message}; {refused.value.advice}"


def test_a_shape_is_the_one_behind_the_cycle_and_g70_means_the_same_one():
    """B-64304EN-1, "Storing P and Q blocks": the addresses found by the roughing are G70's."""
    program = (
        "N10 T0101|G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20|{}|N20 X100. Z-50.|G70 P10 Q20|N10 M30"
    )
    lines, notices = written(program.format("N10 G0 X40.|G1 Z-20."))
    once = program.replace("N10 T", "T").replace("N10 M30", "M30")
    bare, none = written(once.format("N10 G0 X40.|G1 Z-20."))
    assert [lines[0][4:], *lines[1:-1], lines[-1][4:]] == bare and not none
    assert notices == [
        "N10 stands in line 1, 9 too: the shape is the one behind the cycle, in line 5"
    ]


def test_variables_of_a_shape_have_the_value_that_they_have_at_the_cycle():
    """Hand calculation: X 40, Z -20, then a cone to X 100, Z -50."""
    shape = "N10 G0 X#1|G1 Z[-#1/2]|N20 X[#1+60.] Z-#2"
    begin = "#1=40.|#2=50.|G0 X100. Z2.|G71 U4. R1.|G71 P10 Q20|{}|#1=7.|G0 X101."
    assert written(begin.format(shape))[0] == written(begin.format(SHAPE))[0]


def test_words_of_a_haas_that_say_nothing_in_g70():
    begin = "G0 X100. Z2.|G71 P10 Q20 D4. F.2|N10 G0 X40.|N20 G1 Z-20.|G70 P10 Q20{} F.1"
    lines, notices = written(begin.format(" U0 W0 D0.01"), "haas-lathe")
    assert lines == written(begin.format(""), "haas-lathe")[0]
    assert notices == ["D in G70 is passed over: the cut along the shape has no depth"]
