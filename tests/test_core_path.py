"""What users of single controls write on the plain path, and was read as something else: ends of
programs beside a motion, G92 without a word, the way round of a rotary axis, machine coordinates
under a tool length."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.nc.spellings import respelled
from postproc.units import TICKS_PER_MM
from tests.test_unknown_places import mill

ROOT = Path(__file__).resolve().parents[1]
ALL = [f"E{c}{x}" for x in "XYZ" for c in "XYZABC"]
ZEROS = {
    **{name: dict.fromkeys("XYZ", 0.0) for name in ("G54", "G55")},
    "D1": {"Z": 20.0},
    "T1": {"Z": 7.0},
    "T2": {"Z": 3.0},
}


def filtered(text: str, dialect: str, machine=None, start=None, cut: bool = False):
    """The filter, and its lines without gcomp's mark. cut: fed line by line."""
    of = dialects.load(dialect)
    machine = (machine or mill(*ALL)).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine, ZEROS, start))
    parts = text.encode().splitlines(keepends=True) if cut else [text.encode()]
    out = b"".join(filter_.feed(part) for part in parts) + filter_.finish()
    return filter_, [line for line in out.decode().splitlines() if "GCOMP" not in line]


def lines(text: str, dialect: str, **more) -> list[str]:
    return filtered(text, dialect, **more)[1]


def refused(text: str, dialect: str, **more) -> str:
    with pytest.raises(ProgramError) as error:
        filtered(text, dialect, **more)
    return str(error.value)


def five_axis():
    return places.load(str(ROOT / "machines" / "example-five-axis"))


# -- the end of a program beside a motion ----------------------------------------------------------


@pytest.mark.parametrize(
    ("dialect", "end"),
    [
        ("fanuc-mill", "M99"), ("haas", "M99"), ("centroid", "M99"), ("siemens", "M17"),
        ("siemens", "M2"), ("fanuc-mill", "M30"),
    ],
)  # fmt: skip
def test_the_end_of_the_program_stands_behind_all_pieces(dialect, end):
    """M99 takes the control back to the first block: behind the first piece it left out the
    rest of the way."""
    out = lines(f"G90 G54 G0 X0. Y0. Z0.\nG1 X400. F100 {end}\n", dialect)
    assert len(out) > 2
    assert [end in line for line in out] == [False] * (len(out) - 1) + [True]


# -- G92 -------------------------------------------------------------------------------------------


def test_g92_of_one_axis_says_nothing_of_the_others():
    """As printers have it: G92 E0 behind G92 X0 Y0 Z0 where nobody says where the slides stand."""
    head = "G90\nG92 X0 Y0 Z0\n"
    wanted = "G92 gives X, Y, Z a new zero where the machine stands"
    assert wanted in refused(head + "G1 X10 Y10 Z1 F100\n", "marlin")
    assert wanted in refused(head + "G92 E0\nG1 X10 Y10 Z1 F100\n", "marlin")
    where = "G92 gives X a new zero"
    assert where in refused("G92 X0\nG52 Y5\nG0 X10 Y10 Z1\n", "linuxcnc", start={"Y": 0, "Z": 0})
    # taken back, it is known
    assert lines("G92 X0 Y0 Z0\nG92.1\nG0 X10 Y0 Z0\n", "linuxcnc")


def test_an_offset_set_at_an_unknown_place_stays_unknown_until_all_axes_are_named():
    head = "G90\nG10 L20 P1 X0 Y0\nG10 L20 P1 Z0\nG54\n"
    where = "G10 L20 sets G54 from where Y stands"
    assert where in refused(head + "G0 X1 Y1 Z1\n", "linuxcnc", start={"Z": 0.0})
    assert lines(head + "G10 L2 P1 X0 Y0 Z0\nG0 X1 Y1 Z1\n", "linuxcnc", start={"Z": 0.0})


def test_g92_without_a_word():
    """Klipper sets all four to 0 (gcode_move.py, cmd_G92), Smoothieware takes G92 back (Robot.cpp);
    elsewhere it does nothing."""
    head = "G90\nG1 X10 Y10 Z0 F1000\nG92 X0 Y0\n"
    out = lines(head + "G92\nG1 X10 Y10\n", "smoothie")
    assert out[-1] == lines(head + "G92.1\nG1 X10 Y10\n", "smoothie")[-1]
    assert out[-1] == lines(head + "G92.2\nG1 X10 Y10\n", "smoothie")[-1]
    assert out[1].removeprefix("G1 ").split()[:2] == out[-1].removeprefix("G1 ").split()[:2]
    assert "every axis the coordinate 0" in refused(head + "G92\nG1 X10 Y10\n", "klipper")
    behind = lines(head + "G92\nG92 X0 Y0 Z0 E0\nG1 X10 Y10\n", "klipper")
    assert behind[-1] == lines(head + "G92 X0 Y0 Z0 E0\nG1 X10 Y10\n", "klipper")[-1]
    assert (
        lines(head + "G92\nG1 X10 Y10\n", "marlin")[4:]
        == (lines(head + "M400\nG1 X10 Y10\n", "marlin")[4:])
    )


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_g92_of_an_axis_takes_its_local_coordinates_back(dialect):
    """G52 X0 behind it shifts nothing: X5 is 15 from where G54 has its zero, Y5 is 5."""
    text = "G90 G54 G0 X0. Y0. Z0.\nG52 X10. Y10.\nG0 X0. Y0.\nG92 X0.\nG52 X0. Y0.\n"
    out = lines(text + "G0 X5. Y5.\nG28 X0. Y0.\n", dialect)
    plain = lines("G90 G54 G0 X15. Y5. Z0.\n", dialect)
    x, y = (float(word[1:]) for word in plain[0].split()[3:5])
    assert out[5].split()[1:3] == [f"X{x - 10:.4f}", f"Y{y:.4f}"]


def test_g92_1_of_fanuc_means_the_axes_that_it_names():
    text = "G90 G54 G0 X0. Y0. Z0.\nG92 X10. Y10.\nG92.1 X0\nG0 X15. Y15.\n"
    plain = lines("G90 G54 G0 X15. Y5. Z0.\n", "fanuc-mill")[0].split()[3:5]
    out = lines(text, "fanuc-mill")[3].split()[1:3]
    assert out == [plain[0], f"Y{float(plain[1][1:]) + 10:.4f}"]


# -- tools, endstops -------------------------------------------------------------------------------


def test_m61_says_which_tool_g43_means():
    """LinuxCNC: M61 Q sets the tool in the spindle without a change. T2 is 4 mm shorter than T1."""
    head = "T1 M6\nG43\n"
    at = "G0 X0 Y0 Z10\n"
    assert (
        lines(head + "M61 Q2\nG43\n" + at, "linuxcnc")[-1]
        == (lines("T2 M6\nG43\n" + at, "linuxcnc")[-1])
    )
    assert (
        lines(head + "M61 Q2\nT1 M6\nG43\n" + at, "linuxcnc")[-1]
        == (lines(head + at, "linuxcnc")[-1])
    )


def test_g43_without_h():
    """The tool in the spindle on LinuxCNC and grblHAL, no length on Mach3; elsewhere the number
    that the control has kept."""
    at = "G0 X0 Y0 Z10\n"
    for dialect in ("linuxcnc", "linuxcnc-pathpilot", "grblhal"):
        named = lines("T1 M6\nG43 H1\n" + at, dialect)[-1]
        for g43 in ("G43", "G43 H0", "G43 H00"):
            assert lines(f"T1 M6\n{g43}\n" + at, dialect)[-1] == named
        assert lines("T1.0 M6\nG43\n" + at, dialect)[-1] == named
    for g43 in ("G43", "G43 H0"):
        assert lines(f"T1 M6\n{g43}\n" + at, "mach3")[-1] == lines("G49\n" + at, "mach3")[-1]
    for dialect in ("fanuc-mill", "haas", "centroid"):
        assert "the control has kept" in refused("T1 M6\nG54 G43 Z5.\nG0 X0. Y0.\n", dialect)


def test_a_further_length_upon_one_that_is_not_known():
    assert "H9 is not stated" in refused("G43 H9\nG43.2 H1\nG0 X0 Y0 Z0\n", "linuxcnc")


@pytest.mark.parametrize("word", ["H1", "H2", "h4"])
def test_a_move_to_an_endstop_is_no_place(word):
    """RepRapFirmware: G1 H1 X-200 ends where the endstop is."""
    head = "G90\nG1 X10 Y10 Z0 F1000\n"
    out = lines(head + f"G1 {word} X-200 F1000\nG91\nG1 X5 Y5\nG90\nG1 X10 Y10 Z0\n", "reprap")
    assert f"G1 {word} X-200 F1000" in out and "G1 X5 Y5" in out
    assert out[-1] == lines(head, "reprap")[1].replace(" F1000", "")
    assert "G1 H0" in lines(head + "G1 H0 X50\n", "reprap")[2]


def test_machine_coordinates_under_a_tool_length():
    """Sinumerik: SUPA Z0 leads the slide to 0, or the tool's tip, by MD10760."""
    head = "G90 G54 T2 D1\nG0 X0 Y0 Z0\n"
    filter_, _ = filtered(head + "SUPA G0 Z-10 D0\nG1 X50 F100\n", "siemens")
    assert not any(n.code == "machine length" for n in filter_.notices)
    assert "where Z stands is not known" in refused(head + "SUPA G0 Z-10\nG1 X50 F100\n", "siemens")
    filter_, _ = filtered(head + "SUPA G0 Z-10\nG1 X50 Z5 F100\n", "siemens")
    assert any(n.code == "machine length" for n in filter_.notices)


# -- the way round ---------------------------------------------------------------------------------

TURNED = "L X+10 Y+10 Z+0 C+350 A+0 R0 FMAX\n"


def test_m126_goes_the_shorter_way():
    """From 350 to 10 degrees it is +20; what was cut led the table back by -340, in 12 pieces."""
    head = "BEGIN PGM A MM\n" + TURNED
    turn = "L X+20 C+10 F100\n"
    for cut in (False, True):
        said = refused(head + "M126\n" + turn, "heidenhain", machine=five_axis(), cut=cut)
        assert "C turns by more than 180 degrees under M126" in said
        assert lines(head + "M126\nM127\n" + turn, "heidenhain", machine=five_axis(), cut=cut)
        short = "M126\nL X+20 IC+20 F100\nL X+10 C+350\nL C+10 FMAX\n"
        assert lines(head + short, "heidenhain", machine=five_axis(), cut=cut)
    iso = "%A G71 *\nN1 G17 G90 *\nN2 G00 X+10 Y+10 Z+0 C+350 A+0 *\nN3 M126 *\n"
    said = refused(iso + "N4 G01 X+20 C+10 F100 *\n", "heidenhain-iso", machine=five_axis())
    assert "under M126" in said


@pytest.mark.parametrize(
    ("start", "word", "told"),
    [
        ("350", "DC(10)", True), ("10", "DC(100)", False), ("10", "DC(350)", True),
        ("350", "ACP(5)", True), ("5", "ACP(350)", False),
        ("350", "ACN(5)", False), ("5", "ACN(350)", True), ("350", "IC(20)", False),
    ],
)  # fmt: skip
def test_dc_acp_acn_say_the_way(start, word, told):
    text = f"G90 G54 G0 X10 Y1 Z-5 A0 C{start}\nG1 X20 C={word} F100\n"
    if told:
        assert "goes round the other way" in refused(text, "siemens", machine=five_axis())
    else:
        assert lines(text, "siemens", machine=five_axis())
    # a rapid is one block whatever the way is
    assert lines(text.replace("G1 X20", "G0 X20"), "siemens", machine=five_axis())


# -- what is told ----------------------------------------------------------------------------------


@pytest.mark.parametrize("cut", [False, True])
def test_a_slash_behind_the_end_is_not_told(cut):
    text = "G90 G54 G0 X0. Y0. Z0.\nM30\n/G1 X5. F100\n"
    assert not any(n.code == "block delete" for n in filtered(text, "haas", cut=cut)[0].notices)
    text = "G90 G54 G0 X0. Y0. Z0.\n/M30\n"
    assert any(n.code == "block delete" for n in filtered(text, "haas", cut=cut)[0].notices)


def test_a_code_with_a_decimal_is_told_as_it_stands():
    told = {n.code for n in filtered("M201.1 X500\nM3.0\n", "reprap")[0].notices}
    assert "M201.1" in told and not {"M2011", "M3", "M30"} & told


def test_h_of_a_lathe_counts_degrees_in_inches_too():
    """Haas: 0.001 degrees and 0.0001 inch; H90000 turned C by 9 degrees under G20."""
    machine = five_axis()
    setup = setup_of(machine, start=dict.fromkeys(machine.letters, 0.0))
    filter_ = Filter(machine, dialects.load("haas-lathe"), setup)
    seen = []
    filter_.watchers.append(lambda words, motions, *_: seen.append(motions.target))
    filter_.feed(b"G20 G0 X0. Z0.\nH90000\nC45000\nW10000\n")
    goes = {x: seen[0][k] / TICKS_PER_MM for k, x in enumerate(machine.letters)}
    assert goes["C"].tolist() == [0.0, 90.0, 45.0, 45.0]
    assert np.diff(goes["Z"]).round(6).tolist() == [0.0, 0.0, 25.4]


@pytest.mark.parametrize("cut", [False, True])
def test_what_is_said_of_a_feed_of_rotary_axes_names_its_line(cut):
    """It named the line of another block where lines without a motion stand before it."""
    head = "G90 G0 X10 Y1 Z-5 A0 C5\n(one)\nM8\n"
    said = refused(head + "G1 A50\n", "linuxcnc", machine=five_axis(), cut=cut)
    assert "<stdin>:4: a feed of rotary axes whose F is not known" in said
    head = "G90 G0 X10 Y1 Z-5 C5\n(one)\nM8\n"
    said = refused(head + "G1 A50 F100\n", "linuxcnc", machine=five_axis(), cut=cut)
    assert said.startswith("<stdin>:4: ")


@pytest.mark.parametrize("cut", [False, True])
def test_a_rotary_axis_that_moves_in_a_tilted_plane_is_told_behind_it_too(cut):
    """Fed line by line, the blocks behind it were followed in a plane that no longer held."""
    start = dict.fromkeys("XYZAC", 0.0)
    plane = "G90 G54 G0 X10. Y1. Z-5. A0. C0.\nG68.2 X5. Y5. Z0. I0. J0. K30.\n"
    text = plane + "G0 C30.\nG0 X20.\nG69\n"
    said = refused(text, "fanuc-mill", machine=five_axis(), start=start, cut=cut)
    assert "a rotary axis moves in a tilted plane" in said
    # a word that is none of the motion's says nothing
    plane = plane.replace("K30.", "K30. A-18.")
    behind = plane + "G1 X20. F100\nG69\n"
    whole = outcome(behind, cut)
    assert whole == outcome(behind, not cut)


def outcome(text: str, cut: bool) -> list[str] | str:
    try:
        return lines(text, "fanuc-mill", machine=five_axis(), start=None, cut=cut)
    except ProgramError as error:
        return str(error)


@pytest.mark.parametrize("cut", [False, True])
def test_numbers_without_a_point_are_told_at_the_first(cut):
    """Y stands before X in the program, and behind it among the axes."""
    text = "G90 G54 G0 X0. Y5 Z0.\nX20. Y0.\nX30\n"
    told = [n.line for n in filtered(text, "fanuc-mill", cut=cut)[0].notices if n.code == "integer"]
    assert told == [1]


@pytest.mark.parametrize("cut", [False, True])
def test_a_cycle_without_r_is_told_and_goes_back_however_the_input_is_cut(cut):
    """The level where the tool stands was kept as an R that nobody wrote, where a block with the
    cycle's code alone ended a batch."""
    text = "G90 G54 G0 X0. Y0. Z5.\nG86 Q3.9 F50\nX10. Z-2.\nG99 X20.\nG80\n"
    filter_, out = filtered(text, "fanuc-mill", cut=cut)
    assert [n.line for n in filter_.notices if n.code == "without R"] == [3]
    assert out == lines(text, "fanuc-mill", cut=not cut)


@pytest.mark.parametrize("word", ["OSD", "OST", "RMB", "PON", "CFC", "SOFT"])
def test_short_keywords_keep_every_byte_in_its_place(word):
    """OSD was read as one character and three digits: what stood behind it in the batch was
    written one character late, X549.999 for X50."""
    text = "G90 G54 G0 X0 Y0 Z0\n{}\nG1 X50 F100\nX60 Y=IC(5)\n"
    out = lines(text.format(word), "siemens")
    assert out.pop(1) == word
    assert out == lines(text.format("N1"), "siemens")[:1] + lines(text.format("N1"), "siemens")[2:]


@pytest.mark.parametrize("dialect", dialects.names())
def test_every_spelling_of_a_keyword_is_as_long_as_it_is(dialect):
    grammar = dialects.load(dialect).grammar
    for word in grammar.keywords:
        text = word.encode() + b" X5\n"
        assert len(respelled(text, grammar)) == len(text), word


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("siemens", 'T=""'), ("okuma-lathe", "$"), ("okuma", "="), ("fagor", "#"), ("fagor", "$"),
        ("heidenhain", "C"), ("heidenhain", "B"), ("heidenhain", "7 CY"), ("heidenhain", "IF"),
    ],
)  # fmt: skip
def test_what_is_too_short_for_its_word_keeps_every_byte_in_its_place(dialect, text):
    code = f"{text}\n".encode()
    assert len(respelled(code, dialects.load(dialect).grammar)) == len(code)


def test_a_fault_behind_a_motion_at_a_stop_names_its_own_line():
    """Line 5: it was told of line 2, and nothing before it was delivered."""
    machine = places.load("example-router")
    filter_ = Filter(machine, dialects.load("marlin"), setup_of(machine))
    text = b"G28\nG1 Y46.836\nG1 X50.31\n;A\nG0 Y-18\n"
    with pytest.raises(ProgramError) as told:
        filter_.feed(text)
        filter_.finish()
    assert told.value.place.line == 5
