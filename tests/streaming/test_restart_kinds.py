"""The way back on lathes and printers (A11 of design/streaming.md)."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from postproc.errors import GcompError, UsageError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects, pace
from postproc.nc.lexer import lex
from postproc.streaming import restart, resumable

LATHE = b"""G21 G90 G18 G40 G94
G54
T0101
G97 S800 M3
M8
G0 X60 Z5
G0 X40
G1 Z-30 F120
G1 X48
G0 X60
G0 Z5
G0 X36
G1 Z-30 F100
G1 X40
G0 X60 Z20
M5
M30
"""
ZERO = {"G54": {"X": 0.0, "Z": -500.0}, "T0101": {}}
PRINT = b"""M140 S60
M109 S210
G21
G90
M83
G28
G92 E0
G1 X10 Y10 Z0.3 F3000
M106 S128
M82
G92 E0
G1 X60 E2.5 F1200
G1 Y60 E5
G1 X10 E7.5
G1 Y10 E10
"""


def filter_(machine: str, dialect: str, offsets: dict | None = None) -> Filter:
    language = dialects.load(dialect)
    loaded = places.load(machine).carrying(language.carried)
    stated = {"G54": {"X": 0.0, "Y": 0.0, "Z": -200.0}} if offsets is None else offsets
    return Filter(loaded, language, setup_of(loaded, stated))


def blocks(
    program: bytes,
    line: int,
    machine: str,
    dialect: str,
    safe: dict[str, float] | None = None,
    **how,
) -> list[str]:
    filter = filter_(machine, dialect, **how)
    before, rest = restart.read_before(filter, program.splitlines(keepends=True), line)
    resumable.refuse(filter, rest, line)
    lines = restart.preamble(filter, before, safe)
    filter_(machine, dialect, **how).feed(
        b"\n".join(lines) + b"\n"
    )  # the control's own words: its dialect takes them all
    return [x.decode() for x in lines]


def on_lathe(line: int, program: bytes = LATHE, dialect: str = "fanuc-lathe") -> list[str]:
    return blocks(program, line, "example-lathe", dialect, offsets=ZERO)


def test_A11_a_lathe_goes_out_along_X_first_in_diameters():
    assert on_lathe(14) == [
        "G21 G90 G18 G94",
        "G54",
        "G53 G0 X60.0000",
        "T0101",
        "G0 Z-30.0000",
        "M3 S800",
        "G4 X4.",
        "M8",
        "G1 X36.0000 F100",
        "G18 G21 G90 G94",
        "F100",
        "G1",
    ]


def test_A11_a_lathe_in_feed_per_turn_gets_its_F_behind_G95():
    lines = on_lathe(
        14, LATHE.replace(b"G94", b"G95").replace(b"F120", b"F0.2").replace(b"F100", b"F0.15")
    )
    assert lines[-4:] == ["G1 X36.0000 F200", "G18 G21 G90 G95", "F0.15", "G1"]


@pytest.mark.parametrize(
    ("program", "line", "says"),
    [
        (LATHE, 9, "not at all yet"),
        (LATHE.replace(b"G1 X48\nG0 X60\n", b"G1 X30\nG0 X20\n"), 14, "it cuts a bore"),
        (LATHE.replace(b"G1 X48\nG0 X60\n", b""), 12, "along Z alone"),
        (LATHE.replace(b"G0 X36\n", b"T0202\nG0 X36\n"), 14, "not at all yet"),
        (LATHE.replace(b"G97 S800", b"G96 S200"), 14, "constant surface speed"),
    ],
)
def test_A11_a_lathe_is_refused_where_the_way_out_is_not_known(program, line, says):
    with pytest.raises(GcompError) as error:
        blocks(program, line, "example-lathe", "fanuc-lathe", offsets={**ZERO, "T0202": {}})
    assert says in str(error.value) and error.value.advice


def test_A11_a_safe_Z_says_nothing_of_a_lathe_and_a_safe_X_nothing_of_a_mill():
    with pytest.raises(UsageError, match="out along X first"):
        blocks(LATHE, 14, "example-lathe", "fanuc-lathe", {"Z": 0.0}, offsets=ZERO)
    with pytest.raises(UsageError, match="mill goes out along Z first"):
        blocks(
            b"G21 G90\nG54\nG0 X0 Y0 Z20\nG1 Z2 F200\nG1 X40\n",
            5,
            "example-mill",
            "grbl",
            {"X": 50.0},
        )


def test_A11_a_safe_X_in_radius_lifts_the_refusals_of_a_tool_that_cuts_outside():
    not_yet = blocks(LATHE, 9, "example-lathe", "fanuc-lathe", {"X": 40.0}, offsets=ZERO)
    along = LATHE.replace(b"G1 X48\nG0 X60\n", b"")
    assert "G53 G0 X80.0000" in not_yet
    assert "G53 G0 X80.0000" in blocks(
        along, 12, "example-lathe", "fanuc-lathe", {"X": 40.0}, offsets=ZERO
    )
    bore = LATHE.replace(b"G1 X48\nG0 X60\n", b"G1 X30\nG0 X20\n")
    with pytest.raises(UsageError, match="cuts a bore"):
        blocks(bore, 14, "example-lathe", "fanuc-lathe", {"X": 40.0}, offsets=ZERO)
    with pytest.raises(UsageError, match="in radius"):
        blocks(LATHE, 14, "example-lathe", "fanuc-lathe", {"X": 10.0}, offsets=ZERO)


def test_A11_a_machine_that_is_no_mill_lathe_or_printer_is_refused():
    filter = filter_("example-mill", "linuxcnc")
    filter.setup = type(filter.setup)(axes=("X", "Y"))
    with pytest.raises(UsageError, match="which way is safe"):
        restart.read_before(filter, [b"G0 X1\n"], 1)


# -- printers --------------------------------------------------------------------------------------

RAPID = PRINT.replace(b"G28\n", b"G28\nG0 X0 Y0 Z40\n")


def on_printer(line: int, program: bytes = RAPID, **how) -> list[str]:
    return blocks(program, line, "perfect", "marlin", offsets={}, **how)


def test_A11_a_printer_heats_lifts_and_is_told_where_its_filament_stands():
    assert on_printer(15) == [
        "G21",
        "G90",
        "M190 S60",
        "M109 S210",
        "M106 S128",
        "G0 Z40.0000",
        "G0 X60.0000 Y60.0000",
        "G1 Z0.3000 F200",
        "G1 F1200",
        "G21",
        "G90",
        "M82",
        "G92 E5.00000",
    ]


def test_A11_relative_filament_stays_relative():
    lines = on_printer(15, RAPID.replace(b"M82\n", b""))
    assert lines[-2] == "M83" and lines.index("G90") < lines.index("M83")


@pytest.mark.parametrize(
    ("program", "line", "says"),
    [
        (RAPID.replace(b"G92 E0\nG1 X60", b"G28\nG1 X60"), 14, "not known"),
        (RAPID.replace(b"G92 E0\nG1 X60", b"G92 X0\nG1 X60"), 14, "shifted its zero"),
        (RAPID.replace(b"M82\n", b"G91\n"), 14, "counts E by it too"),
        (PRINT, 14, "which Z is safe"),
    ],
)
def test_A11_a_printer_is_refused_where_it_can_not_be_known(program, line, says):
    with pytest.raises(GcompError) as error:
        on_printer(line, program)
    assert says in str(error.value) and error.value.advice


@pytest.mark.parametrize(
    ("dialect", "wait"),
    [
        ("grbl", "G4 P4"),
        ("linuxcnc", "G4 P4"),
        ("haas", "G4 P4."),
        ("fanuc-mill", "G4 P4000"),
        ("siemens", "G4 F4"),
    ],
)
def test_A11_the_spindle_gets_four_seconds_in_every_controls_unit(dialect, wait):
    program = b"G21 G90 G17 G94\nG54\nG0 X0 Y0 Z20\nM3 S8000\nG1 Z2 F200\nG1 X40\n"
    program = program.replace(b"G21", b"G71") if dialect == "siemens" else program
    assert wait in blocks(program, 6, "example-mill", dialect)


MILLED = b"""G21 G90 G17 G94
G54
G0 X0. Y0. Z20.
S8000 M3 M8
G0 X10. Y10.
G1 Z2. F200.
G1 X40. F600.
G1 Y50.
M30
"""


def milled(dialect: str, offset: str = "G54", *changes: tuple[bytes, bytes]) -> list[str]:
    program = MILLED.replace(b"G54", offset.encode())
    for old, new in changes:
        program = program.replace(old, new)
    at = {offset: {"X": 0.0, "Y": 0.0, "Z": -200.0}}
    return blocks(program, 8, "example-mill", dialect, offsets=at)


def test_A11_a_speed_beside_coolant_comes_back():
    """S8000 M3 M8 in one block: M8 says nothing of the S."""
    assert "M3 S8000" in milled("grbl") and "M8" in milled("grbl")


@pytest.mark.parametrize("dialect", [x for x in dialects.names() if x != "mach3"])
def test_A11_the_wait_is_four_seconds_by_the_dialects_own_units(dialect):
    """nc/pace.py says what a dwell's letters count; on a Mach3 a setting does."""
    language = dialects.load(dialect)
    for kind in (restart.MILL, restart.LATHE):
        text = restart.Preamble.wait(SimpleNamespace(dialect=language, kind=kind))
        words = lex(text.encode() + b"\n", language.grammar)
        assert [pace.seconds(words, b, language) for b in pace.dwells(words)] == [4.0]


def test_A11_G90_and_G94_of_a_lathe_in_system_A_are_cycles_and_do_not_come():
    program = LATHE.replace(b"G21 G90 G18 G40 G94", b"G21 G40 G98")
    lines = on_lathe(14, program, "fanuc-lathe-a")
    assert lines[0] == "G21 G18 G98" and lines[-3:] == ["G18 G21 G98", "F100", "G1"]


@pytest.mark.parametrize(
    ("dialect", "offset", "has"),
    [
        ("fanuc-mill", "G54.1 P3", ("G54.1 P3", "G53 G0 Z-180.0000")),
        ("fadal", "E1", ("E1", "G53 G0 Z-180.0000")),
        # G53 of an Okuma takes the tool's length off, and Z-180 would be one of the work
        ("okuma", "G15 H3", ("G15 H3", "G0 Z20.0000")),
    ],
)
def test_A11_the_work_offset_and_the_way_out_are_the_controls_own(dialect, offset, has):
    lines = milled(dialect, offset)
    assert list(has) == lines[1:3] and lines[0] == "G21 G90 G17 G94"


def test_A11_inches_of_a_Siemens_come_back_as_they_were_written():
    """Under G700 an F600 would be 600 inch/min: 25.4 times as fast as under G70."""
    small = ((b"G21", b"G70"), (b"20.", b".7"), (b"10.", b".4"), (b"Z2.", b"Z.1"))
    lines = milled("siemens", "G54", *small, (b"40.", b"1.5"), (b"50.", b"2."))
    assert lines[0] == "G710 G90 G17 G94" and lines[-3:] == ["G17 G70 G90 G94", "F600.", "G1"]


def test_A11_an_F_comes_back_with_its_point():
    """An integer F of a Haas counts steps of its last digit (setting 77), F600. does not."""
    lines = milled("haas")
    assert "G1 Z2.0000 F200." in lines and "F600." in lines
    assert "F600" in milled("grbl", "G54", (b"F600.", b"F600"))


def test_homing_leaves_the_filament_where_it_is():
    """Slicers write G28 and then G92 E0: the map does not care where E stands, but an
    unknown zero was refused."""
    filter = filter_("example-mill", "marlin", {})
    filter.feed(b"G21\nG90\nM83\nG28\nG92 E0\nG1 X10 Y10 Z-100 F3000\nG1 X60 E2.5\n")
    assert filter.modal.known.all() and filter.modal.zero_known and filter.summary.changed == 2
