"""One run: what is written out without being asked for, what is not, and hints that are tried
before they are given."""

from __future__ import annotations

import io
import os
import re
from pathlib import Path

import pytest

from postproc import ports
from postproc.cli import main

GRINDER = ("--machine", "studer-s36")  # fanuc-lathe
HEAD = "%\nO1000 (MAIN)\nG90 G21 G18\nG0 X20. Z10.\n"
SUB = "O2000\nG1 X30. Z20. F100\nM99\n%\n"
CALL = HEAD + "M98 P2000\nG1 X40. Z50. F100\nM98 P2000\nM30\n" + SUB
LOOP = HEAD + "#1=1\nWHILE[#1 LE 3]DO1\nG1 X[20+#1*5.] Z[10+#1*10.] F100\n#1=#1+1\nEND1\nM30\n%\n"
MACRO = HEAD + "G65 P2000 A30. B20.\nM30\nO2000\nG1 X#1 Z#2 F100\nM99\n%\n"
TURNING = HEAD + "G0 X60. Z5.\nG77 X40. Z1. F.2\nX36.\nG0 X60. Z10.\nM30\n%\n"
NEEDS = {"subprogram": CALL, "loop": LOOP, "macro": MACRO, "cycle": TURNING}

# What only the machine knows while it runs decides the text: nothing of it is ever given a value.
DECIDED = {
    "probe": HEAD + "G31 Z5. F50\nIF[#5062 GT 3.]GOTO 10\nG1 X40. Z50. F100\nN10 M30\n%\n",
    "operator's variable": HEAD + "IF[#500 EQ 1]GOTO 10\nG1 X40. Z50. F100\nN10 M30\n%\n",
    "signal": HEAD + "IF[#1000 EQ 1]GOTO 10\nG1 X40. Z50. F100\nN10 M30\n%\n",
    "block delete before a call": HEAD + "/M98 P2000\nM98 P2000\nM30\n" + SUB,
    "block delete before a jump": HEAD + "#1=1\n/GOTO 10\nG1 X40. Z50. F100\nN10 M30\n%\n",
    "block delete before a variable": HEAD + "#1=30.\n/#1=40.\nG1 X#1 F100\nM30\n%\n",
}


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(place: Path, text: str, *options: str, capfd) -> tuple[int, str, str]:
    (place / "part.nc").write_text(text)
    status = main([*GRINDER, *options, "part.nc"])
    out, err = capfd.readouterr()
    return status, out, err


@pytest.mark.parametrize("name", NEEDS)
def test_what_nothing_else_corrects_is_written_out_and_that_is_said_in_one_line(place, capfd, name):
    asked = run(place, NEEDS[name], "--expand", "--verify", capfd=capfd)
    alone = run(place, NEEDS[name], "--verify", capfd=capfd)
    assert (alone[0], alone[1]) == (asked[0], asked[1]) == (0, asked[1])
    said = set(alone[2].splitlines()) - set(asked[2].splitlines())
    assert len(said) == 1
    assert re.match(
        r"gcomp: written out as plain blocks, \d+ lines, because .*\(line \d+: .*--no-expand",
        said.pop(),
    )


@pytest.mark.parametrize("name", NEEDS)
def test_it_is_said_even_where_nothing_else_is(place, capfd, name):
    assert run(place, NEEDS[name], "--quiet", capfd=capfd)[2].startswith(
        "gcomp: written out as plain blocks"
    )


@pytest.mark.parametrize("options", [("--no-expand",), ("--in-place",)])
@pytest.mark.parametrize("name", NEEDS)
def test_where_it_must_not_be_it_is_asked_for(place, capfd, name, options):
    status, out, err = run(place, NEEDS[name], *options, capfd=capfd)
    assert (status, out) == (2, "")
    assert "--expand" in err.splitlines()[-1]
    assert (place / "part.nc").read_text() == NEEDS[name]


@pytest.mark.parametrize("name", DECIDED)
def test_what_is_decided_at_the_machine_is_never_written_out(place, capfd, name):
    status, out, err = run(place, DECIDED[name], capfd=capfd)
    assert (status, out) == (2, "")
    assert "written out" not in err


def test_a_stated_switch_decides_nothing_at_the_machine(place, capfd):
    text = DECIDED["block delete before a call"]
    for switch, times in (("off", 2), ("on", 1)):
        status, out, err = run(
            place, text, "--block-delete", switch, "--reversal", "off", capfd=capfd
        )
        assert (status, "written out" in err) == (0, True)
        assert len(re.findall(r"^/?G1 X", out, re.MULTILINE)) == times, out


def test_a_subprogram_in_another_file_is_taken_only_when_asked_for(place, capfd):
    (place / "O2000.nc").write_text("%\n" + SUB)
    main_program = CALL.replace(SUB, "%\n")
    status, out, err = run(place, main_program, capfd=capfd)
    assert (status, out) == (2, "")
    assert err.splitlines()[-1].strip().endswith("--expand writes it out as plain blocks")
    asked = run(place, main_program, "--expand", capfd=capfd)
    assert asked[0] == 0
    assert "is read from" in asked[2]
    (place / "subs").mkdir()
    (place / "O2000.nc").rename(place / "subs" / "O2000.nc")
    named = run(place, main_program, "--library", "subs", capfd=capfd)
    assert (named[0], named[1]) == (0, asked[1])


def test_what_can_not_be_written_out_says_why_at_its_own_line(place, capfd):
    status, out, err = run(place, CALL.replace("X30. Z20.", "X30. Z[1/0]"), capfd=capfd)
    assert (status, out) == (2, "")
    assert re.match(r"gcomp: part\.nc:10: division of 1 by zero", err)


@pytest.mark.parametrize("cuts", [1, 7, 100, 10**6])
def test_a_pipe_is_read_as_a_file_is_however_it_comes(cuts):
    """The text of a pipe is kept while it is read; one that is longer than what is kept can not be
    read again."""

    class Pipe(io.BytesIO):
        def seekable(self):
            return False

    text = os.urandom(5000)
    kept = ports.Kept(Pipe(text), 5000)
    assert b"".join(iter(lambda: kept.read(cuts), b"")) == text
    assert kept.again()
    assert kept.read(10) == text[:10]
    assert kept.again()
    assert b"".join(iter(lambda: kept.read(cuts), b"")) == text
    part = ports.Kept(Pipe(text), 5000)
    part.read(100)
    assert part.again()
    assert b"".join(iter(lambda: part.read(cuts), b"")) == text
    long = ports.Kept(Pipe(text), 4999)
    assert b"".join(iter(lambda: long.read(cuts), b"")) == text
    assert not long.again()


# -- hints -----------------------------------------------------------------------------------------

MILL = "%\nO1000\nG21 G90 G17\nG0 X1. Y1. Z1.\n"


def test_a_hint_is_given_where_following_it_is_shown_to_help(place, capfd):
    text = "G71 G90 G18\nG0 X20 Z10\nG1 X30 F100\nG1 X34 Z20 RND=2\nX=IC(4) Z=IC(2)\nM30\n"
    status, _, err = run(place, text.replace("RND=2", ""), capfd=capfd)
    assert status == 2
    assert (
        err.splitlines()[-1].strip()
        == "--dialect siemens corrects the whole program (X=IC(4) in line 5)"
    )
    assert len(err.splitlines()) <= 4
    assert run(place, text.replace("RND=2", ""), "--dialect", "siemens", capfd=capfd)[0] == 0


def test_a_dialect_that_only_passes_an_unknown_m_code_is_no_hint(place, capfd):
    """M46 of Haas jumps; fanuc-mill, whose sign the O number is, does not know it."""
    text = MILL + "G1 X5. F100.\nM46 P5\nM30\n%\n"
    options = ("--machine", "example-mill", "--dialect", "haas")
    status, _, err = run(place, text, *options, capfd=capfd)
    assert status == 2 and "fanuc-mill" not in err
    assert "M46 can not be followed" in err and "write it out in line" in err


def test_it_says_how_far_the_other_dialect_comes(place, capfd):
    text = "G71 G90 G18\nG0 X20 Z10\nG1 X=IC(4) Z=IC(2) F100\nX1 X2\n"
    _, _, err = run(place, text, capfd=capfd)
    assert (
        err.splitlines()[-1].strip() == "--dialect siemens follows it to line 4 (X=IC(4) in line 3)"
    )


def test_no_hint_where_the_other_dialect_stops_there_too(place, capfd):
    text = "O0007\nG50 S2000\nT0101\nG99 F.2\nG0 X20. Z10.\nG1 X30. X31.\nM30\n"
    _, _, err = run(place, text, "--offset", "T0101=X0,Z0", capfd=capfd)
    assert "--dialect" not in err
    assert "two X words" in err


def test_a_haas_lathe_is_never_told_to_be_a_fanuc(place, capfd):
    text = (
        "%\nO60311 (G71 ROUGHING)\nT101\nG00 G18 G20 G40 G80 G99\nG50 S1000\nG97 S500 M03\nG00 G54"
        " X2.1 Z0.1\nM08\nG96 S200\nG71 P1 Q2 D0.05 U0.02 W0.005 F0.014\nN1 G00 X1.\nN2 G01 Z-1."
        " F.01\nG92 X1. Z-1. F.1\nM30\n%\n"
    )
    _, _, err = run(place, text, "--dialect", "haas-lathe", capfd=capfd)
    assert "fanuc" not in err


def test_what_is_quoted_is_quoted_whole_and_as_it_stands():
    from postproc.nc.recognise import recognise

    text = (
        b"%\nO00010\ng0 g90 g154 p12 x0. y0.\nm97p1000\nG54.1P48\nM98P200L2\n#101=-25.5\nM30\n%\n"
    )
    said = {e for _, evidence in recognise(text) for e in evidence}
    assert {"g154 p12 in line 3", "m97p1000 in line 4"} <= said
    assert any(e.startswith("G54.1P48 ") for e in said) or "G54.1P48" not in str(said)
    assert not any(re.search(r"P1 |P4 |P20? |=-2 ", e) for e in said)
