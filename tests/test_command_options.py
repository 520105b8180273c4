"""Options of the command: how they may be written, what they change in the program, and what is
said."""

# ruff: noqa: F811 (fixtures are imported and named again as arguments)

from __future__ import annotations

import re
import shutil

import pytest

from postproc.cli import main
from tests.command_process import (
    GRINDER,
    PROGRAM,
    ROOT,
    Ran,
    corrected,  # noqa: F401
    gcomp,
    place,  # noqa: F401
    refused,
    surroundings,
    zigzag,
)


@pytest.fixture
def here(place, monkeypatch, capfd):
    """The command within this process: how a value may be written is the parser's alone."""
    monkeypatch.chdir(place)
    for name, value in surroundings(place).items():
        monkeypatch.setenv(name, value)

    def run(*arguments: str) -> Ran:
        status, (out, err) = main([*arguments]), capfd.readouterr()
        return Ran(status, out.encode(), err.encode())

    return run


# -- how it is corrected ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text, um",
    [("0.5um", "0.5"), ("0.001mm", "1"), ("0.001", "1"), ("5\u00b5m", "5"), (".0001in", "2.54")],
)
def test_a_tolerance_may_be_written_so(here, text, um):
    ran = here(*GRINDER, "--dry-run", "--tolerance", text, "part.nc")
    assert ran.status == 0
    assert f"tolerance {um} um" in ran.out.decode()


@pytest.mark.parametrize(
    "text", ["abc", "0", "-1um", "nan", "1e999um", "0,5um", "5", "20mm", "1m", ""]
)
def test_a_tolerance_may_not_be_written_so(here, text):
    ran = here(*GRINDER, f"--tolerance={text}", "part.nc")
    assert (ran.status, ran.out) == (2, b"")
    last = ran.err.splitlines()[0]
    assert len(ran.err.splitlines()) == 2, "the sentence, and where the options are listed"
    assert f"argument --tolerance: {text!r}" in last
    assert "um" in last
    assert ("is that meant in um?" in last) == (text == "20mm")


def test_offsets_may_be_stated(place):
    program = b"G55\nG0 X20. Z10.\n"
    refused(gcomp(place, *GRINDER, input=program), "G55 is not stated", "--offset G55=X0,Z0")
    at_zero = gcomp(place, *GRINDER, "--offset", "G55=X0,Z0", input=program)
    assert at_zero.status == 0
    assert (
        at_zero.out.split(b"\n")[-2]
        == gcomp(place, *GRINDER, input=b"G0 X20. Z10.\n").out.split(b"\n")[-2]
    )
    elsewhere = gcomp(place, *GRINDER, "--offset", "g55 = x1, z-2.5", input=program)
    assert elsewhere.status == 0
    assert elsewhere.out != at_zero.out


@pytest.mark.parametrize(
    "option",
    [
        "--offset=G54",
        "--offset=G99=X1",
        "--offset=G54=X",
        "--offset=G54=X1,X2",
        "--offset=G504=X1",
        "--offset=G54.1=X1",
        "--start=Q1",
        "--start=X1;Z2",
        "--block-delete=yes",
        "--reversal=jump",
        "--outside=ignore",
    ],
)
def test_options_with_a_wrong_value_show_the_right_form(here, option):
    ran = here(*GRINDER, option, "part.nc")
    assert (ran.status, ran.out) == (2, b"")
    last = ran.err.splitlines()[0]
    assert len(ran.err.splitlines()) == 2, "the sentence, and where the options are listed"
    assert option.split("=")[0] in last
    assert re.search(r"like (G54=X1|X1)|choose from", last)


@pytest.mark.parametrize("option", ["--offset=G54=X0,Y1", "--start=Y1"])
def test_an_axis_that_the_machine_has_not_is_named(here, option):
    refused(here(*GRINDER, option, "part.nc"), "names Y", "studer-s36", "X Z")


def test_the_start_may_be_stated(place):
    program = b"G1 X20. F100\n"
    refused(
        gcomp(place, *GRINDER, input=program), "<stdin>:1: where Z stands is not known", "--start"
    )
    ran = gcomp(place, *GRINDER, "--start", "X5,Z10", input=program)
    assert ran.status == 0
    assert b"Z9.99" in ran.out


def test_the_tool_at_the_start_may_be_stated(place):
    """What LinuxCNC's #<_current_tool> reads before any M6."""
    program = b"G8 G18\no1 if [#<_current_tool> NE 2]\nG0 X150 Z100\no1 endif\nG0 X10 Z10\n"
    command = (*GRINDER, "--dialect", "linuxcnc", "--expand")
    refused(gcomp(place, *command, input=program), "#<_current_tool> is not known", "--start T1")
    ran = gcomp(place, *command, "--start", "T2", input=program)
    assert ran.status == 0 and b"X149" not in ran.out and b"X150" not in ran.out
    refused(gcomp(place, *command, "--start", "T1.5", input=program), "the number of a tool", "")


def test_block_delete_on_leaves_the_block_alone(place):
    program = b"G0 X20. Z10.\n/G1 X30. F100\nG1 X40. F100\n"
    on, off = (
        gcomp(place, *GRINDER, "--block-delete", way, input=program) for way in ("on", "off")
    )
    assert (on.status, off.status) == (0, 0)
    assert b"\n/G1 X30. F100\n" in on.out
    assert b"\n/G1 X30. F100\n" not in off.out
    assert "notice: " in on.err
    assert "line 2" in on.err


def test_beyond_the_table_the_end_value_may_be_held(place):
    program = b"G0 X20. Z10.\nG1 X345. F100\n"
    refused(gcomp(place, *GRINDER, input=program), "X = 172.5000 mm")
    assert gcomp(place, *GRINDER, "--outside", "clamp", input=program).status == 0
    beyond = gcomp(place, *GRINDER, "--outside", "clamp", input=b"G0 X20. Z10.\nG1 X352. F100\n")
    refused(beyond, "<stdin>:2: ", "beyond the travel of X (-5 to 175 mm)")


def test_the_ways_to_treat_a_reversal_are_accepted_and_differ(place):
    program = b"G0 X20. Z10.\nG1 X40. Z50. F100\nX20. Z90.\nX40. Z40.\n"
    outs = []
    for how in (["mean"], ["step"], ["ramp", "--ramp", "5mm"], ["off"]):
        ran = gcomp(place, *GRINDER, "--reversal", *how, input=program)
        assert ran.status == 0
        outs.append(ran.out)
    assert len(set(outs)) >= 3


def test_arc_centres_may_be_absolute(place):
    program = b"G0 X20. Z30.\nG3 X40. Z20. I10. K20. F100\n"
    refused(
        gcomp(place, *GRINDER, input=program),
        "misses its own end point",
        "incremental",
        "--arc-centre",
    )
    assert gcomp(place, *GRINDER, "--arc-centre", "absolute", input=program).status == 0


# -- what it says ----------------------------------------------------------------------------------


def test_verify_says_what_is_left(place, corrected):
    ran = gcomp(place, *GRINDER, "--verify", "part.nc")
    assert (ran.status, ran.out) == (0, corrected)
    left, without = re.search(
        r"nominal path ([\d.]+) um .*uncorrected ([\d.]+) um", ran.err
    ).groups()
    assert float(left) <= 0.55 < float(without)
    assert "2 motions in" in ran.err


def test_progress_is_reported_as_linuxcnc_reads_it(place):
    (place / "long.nc").write_bytes(zigzag(60_000))
    ran = gcomp(place, "--machine", "perfect", "--filter-progress", "long.nc", "-o", "out.nc")
    assert ran.status == 0
    told = [int(n) for n in re.findall(r"^FILTER_PROGRESS=(\d+)$", ran.err, re.MULTILINE)]
    assert told == sorted(told)
    assert told[-1] == 100
    assert len(told) >= 3


def test_quiet_says_nothing(place, corrected):
    ran = gcomp(place, *GRINDER, "--quiet", input=b"M777\n" + PROGRAM)
    assert (ran.status, ran.err) == (0, "")
    assert gcomp(place, *GRINDER, "--quiet", "--dry-run", "part.nc").err == ""


def test_the_machines_are_listed_and_shown(place):
    ran = gcomp(place, "machines")
    assert ran.status == 0
    listed = [line.split()[0] for line in ran.out.decode().splitlines()]
    assert listed == sorted(listed) and {
        "perfect",
        "studer-s36",
        "studer-s36-thesis",
        "example-mill",
    } <= set(listed)
    text = gcomp(place, "machines", "show", "studer-s36").out.decode()
    for part in (
        "Studer S-36",
        "w-b-Z-X-t",
        "diameter",
        "travel -5 to 175 mm",
        "18 nodes",
        "EXX",
        "urad",
        "B0X  -382.4",
        "offset G54",
    ):
        assert part in text
    refused(gcomp(place, "machines", "show"), "which machine?")
    refused(gcomp(place, "machines", "show", "none"), "'none'", "studer-s36")


def test_machines_beside_the_work_come_first_and_a_broken_one_is_listed_as_such(place):
    own = place / "machines"
    shutil.copytree(ROOT / "machines" / "studer-s36", own / "perfect")
    (own / "broken").mkdir()
    (own / "broken" / "machine.toml").write_text("format = 1\n")
    lines = {line.split()[0]: line for line in gcomp(place, "machines").out.decode().splitlines()}
    assert "cylindrical grinder" in lines["perfect"]
    assert "can not be used" in lines["broken"]
    assert "studer-s36" in lines
    refused(gcomp(place, "--machine", "broken", "part.nc"), "broken/machine.toml:1: ")


def test_explain_says_what_the_second_opinion_can_not_read(place):
    (place / "named.gcode").write_bytes(b"OPLATE\nG1 X20 Y20 Z5 F600\n")
    ran = gcomp(place, "explain", "--machine", "example-printer", "named.gcode")
    assert ran.status == 0
    assert b"pygcode can not read this block (ValueError)" in ran.out


def test_explain_names_every_code(place):
    """pygcode's own words of G54 and G40 begin without and with the code."""
    (place / "modes.nc").write_bytes(b"G40 G54 G90\nG0 X20. Z10.\n")
    ran = gcomp(place, "explain", *GRINDER, "modes.nc")
    assert b"G40: Cutter" in ran.out and b"; G54: Select Coordinate System 1; G90: " in ran.out


def test_what_is_said_of_places_beyond_the_table_is_what_this_run_does(place):
    for more, says in (
        ((), "places there are refused"),
        (("--outside", "clamp"), "its end values hold there"),
    ):
        ran = gcomp(place, *GRINDER, "--verify", *more, "part.nc")
        assert f"the travel goes 10 mm beyond it: {says}" in ran.err


def test_help_and_version(place):
    version = gcomp(place, "--version")
    assert version.status == 0
    assert re.fullmatch(rb"gcomp \d+\.\d+\.\d+\n", version.out)
    general = gcomp(place, "--help")
    assert general.status == 0
    for part in (b"compensate", b"machines", b"explain", b"example: "):
        assert part in general.out
    special = gcomp(place, "compensate", "--help")
    assert special.status == 0
    for part in (b"--machine", b"--tolerance", b"--in-place", b"example: cat job.nc | gcomp"):
        assert part in special.out
    alone = gcomp(place)
    assert (alone.status, alone.out) == (2, b"")
    assert "usage: gcomp" in alone.err


def test_without_a_machine_it_says_which_option_is_missing(place):
    ran = gcomp(place, "part.nc")
    assert (ran.status, ran.out) == (2, b"")
    assert "--machine is missing" in ran.err.splitlines()[0]
    assert "studer-s36" in ran.err
