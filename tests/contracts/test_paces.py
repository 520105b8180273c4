"""Rows that are found by the first word of a dialect's name: every dialect has those that it needs,
or stands here with the reason. Without its row a dialect loses something that no other test shows:
dwells that take no time, G96 without a limit, no programs of tests, cycles that stay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from postproc.errors import UsageError
from postproc.machine.file import read_machine
from postproc.nc import dialects, pace
from postproc.nc.cycles import FAMILIES, family
from postproc.nc.dialects import Dialect
from postproc.nc.lexer import lex
from postproc.records import replace
from postproc.simulate import experiments
from postproc.simulate.writer import DWELL, Writer

MACHINES = Path(__file__).parents[2] / "machines"
NAMES = dialects.names()
UNLIMITED = {"mach3": "no code is in its manual by which a program limits what G96 turns"}
NO_TESTS = {
    "fadal": "its work offset is E, which the program of a test does not name",
    "fagor": "K of a dwell in whole seconds is hundredths of a second on the 8055",
    "mach3": "P of a dwell is seconds or milliseconds by a setting",
    "okuma": "its work offset is G15 H, which the program of a test does not name",
}
SENTENCE = 20  # characters that a reason has at least


def lacking(dialect: Dialect) -> list[str]:
    """The rows that this dialect needs and has not."""
    word, found = pace.first_word(dialect), []
    timed = set(pace.SECONDS.get(word, {}))
    if 40 in dialect.by_number and not timed & set(dialect.dwell) and word not in pace.UNTIMED:
        found.append("SECONDS or UNTIMED in nc/pace.py")
    if 40 in dialect.by_number and set(dialect.dwell) - timed and word not in pace.UNTIMED:
        found.append("each letter of its dwell in SECONDS, or UNTIMED, in nc/pace.py")
    if 960 in dialect.by_number and word not in pace.LIMITS and word not in UNLIMITED:
        found.append("LIMITS in nc/pace.py")
    if word not in DWELL and word not in NO_TESTS:
        found.append("DWELL in simulate/writer.py")
    drills = np.flatnonzero(dialect.is_hole & ~dialect.is_tap).tolist()
    if dialect.holes_written_out and set(drills) - family(dialect).codes:
        found.append("FAMILIES in nc/cycles, or holes_written_out=False")
    return found


@pytest.mark.parametrize("name", NAMES)
def test_every_dialect_has_the_rows_that_it_needs(name):
    assert lacking(dialects.load(name)) == [], "a row, or the reason here why there is none"


def test_a_new_dialect_without_rows_is_missed():
    """Of its own first word, and nothing else written: all four tables miss it. As a variant of
    another it has that one's rows."""
    whole = dialects.load("fanuc-mill")
    missed = " ".join(lacking(replace(whole, name="newcomer")))
    assert all(x in missed for x in ("SECONDS", "LIMITS", "DWELL in", "FAMILIES")), missed
    assert lacking(replace(whole, name="fanuc-newcomer")) == []
    assert lacking(replace(whole, dwell="PQX")) != []


def test_no_row_is_of_nobody():
    """A row whose dialect is gone, or a reason beside a row, misleads who reads it."""
    words = {pace.first_word(dialects.load(name)) for name in NAMES}
    for rows in (pace.SECONDS, pace.UNTIMED, pace.LIMITS, DWELL, UNLIMITED, NO_TESTS):
        assert set(rows) <= words
    assert {*pace.POINTED, *pace.WHOLE} <= set(pace.SECONDS)
    assert not set(UNLIMITED) & set(pace.LIMITS)
    assert not set(NO_TESTS) & set(DWELL)
    assert all(any(name.startswith(word) for name in NAMES) for word in FAMILIES)
    for reasons in (pace.UNTIMED, UNLIMITED, NO_TESTS):
        assert all(len(reason) > SENTENCE for reason in reasons.values())


@pytest.mark.parametrize(
    "name", [n for n in NAMES if pace.first_word(dialects.load(n)) in DWELL and n != "heidenhain"]
)
@pytest.mark.parametrize("seconds", [2.0, 2.5])
def test_a_dwell_that_a_test_writes_is_read_as_long(name, seconds):
    """2 s as 2 s; 2.5 s too, and as 3 s where only whole seconds are known."""
    dialect = dialects.load(name)
    write = Writer(read_machine(MACHINES / "example-mill"), name)
    write.wait(seconds)
    words = lex(f"{write.lines[0]}{dialect.block_end}\n".encode(), dialect.grammar)
    whole = pace.first_word(dialect) in pace.WHOLE
    assert pace.dwells(words) == [0]
    assert pace.seconds(words, 0, dialect) == (np.ceil(seconds) if whole else seconds)


HAND = [
    ("centroid", "G4 P2.5", 2.5),
    ("fadal", "G4 P1500", 1.5),
    ("fagor", "G4 K2.", 2.0),
    ("fagor", "G4 K0.25", 0.25),
    ("fagor", "G4 K50", None),
    ("klipper", "G4 P1500", 1.5),
    ("klipper", "G4 S2", None),
    ("mach3", "G4 P2", None),
    ("marlin", "G4 P500 S2", 2.0),
    ("marlin", "G4 P500", 0.5),
    ("okuma", "G4 F2", 2.0),
    ("okuma-lathe", "G4 F0.5", 0.5),
    ("siemens", "G4 S30", None),
    ("smoothie", "G4 S2", 2.0),
    ("smoothie", "G4 S2.9", 2.0),
    ("smoothie", "G4 P500", None),
    ("smoothie", "G4 P500 S2", None),
    ("haas", "G4 P1500", 1.5),
    ("haas", "G4 P1.5", 1.5),
    ("heidenhain", "CYCL DEF 9.1 DWELL 2.5", 2.5),
    ("heidenhain", "17 CYCL DEF 9.1 V.ZEIT 0,5", 0.5),
    ("heidenhain", "CYCL DEF 9.1 DWELL Q5", None),
    ("heidenhain", "FUNCTION DWELL TIME10", 10.0),
    ("heidenhain", "FUNCTION DWELL REV5.8", None),
]


@pytest.mark.parametrize(("name", "text", "seconds"), HAND)
def test_dwells_by_hand(name, text, seconds):
    """As the manuals count them (nc/pace.py names them); None: nobody says how long."""
    dialect = dialects.load(name)
    words = lex(text.encode() + b"\n", dialect.grammar)
    assert words.fault is None
    found = pace.seconds(words, 0, dialect)
    assert pace.dwells(words) == [0]
    assert np.isnan(found) if seconds is None else found == pytest.approx(seconds, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "text", "rpm"),
    [
        ("linuxcnc", "S2000 M3 G4 P1", 2000.0),
        ("haas", "M3 S900|G4 P1. S800", 800.0),
        ("fanuc-lathe-a", "M3 S900|G4 U1. S800", 800.0),
        ("fanuc-lathe-a", "M3 S900|G50 S2000", 900.0),
        ("okuma", "M3 S900|G4 F1 S800", 800.0),
        ("heidenhain-iso", "M3 S900*|G04 F1*", 900.0),
        ("fanuc-mill", "S900 M13", 900.0),  # with the coolant
        ("heidenhain-iso", "S900 M14*", 900.0),
        ("heidenhain", "TOOL CALL 1 Z S900|L X+1 M13", 900.0),
        ("heidenhain", "TOOL CALL 1 Z S900|L X+1 M13|M5", 0.0),
        ("haas-lathe", "S900 M14", 0.0),  # it clamps the spindle
        ("siemens", "S1500 M3|G4 S3", 1500.0),
        ("siemens", "S1500 M3|G4 F3", 1500.0),
        ("siemens", "S1=1500 M1=3", 1500.0),
        ("siemens", "S1=1500 M1=3|S2=800 M2=5", 1500.0),
        ("siemens", "S1=1500 M1=3|M1=5", 0.0),
        ("siemens", "S1500 M3|G25 S30", 1500.0),
        ("siemens", "S1500 M3|G26 S3000", 1500.0),
        ("siemens", 'S1500 M3|MSG("S2; S3")', 1500.0),
    ],
)
def test_the_spindle_turns_as_the_program_says(name, text, rpm):
    """By hand: S beside a dwell is a time where the control's dwells may name it; S1= is the main
    spindle's; G25 and G26 are limits."""
    dialect = dialects.load(name)
    words = lex(text.replace("|", "\n").encode() + b"\n", dialect.grammar)
    assert words.fault is None
    assert pace.spindle(words, dialect, pace.Spoken())[0].rpm[-1] == rpm


def test_okuma_counts_time_as_it_counts_lengths():
    """OSP-P200L 2-3, UNIT: 1 s where X1 is 1 mm; 0.01 s or 0.1 s where it is a least increment."""
    okuma = replace(dialects.load("okuma"), integers="least increments")
    words = lex(b"G4 F200\n", okuma.grammar)
    assert np.isnan(pace.seconds(words, 0, okuma))


CAPS = [
    ("fanuc-lathe", "G50 S2500", 2500.0),
    ("fanuc-mill", "G92 S2500", 2500.0),
    ("okuma-lathe", "G50 S2500", 2500.0),
    ("fagor", "G92 S2500", 2500.0),
    ("fagor", "G50 S2500", np.inf),  # a corner, and a speed
    ("linuxcnc", "G96 D2500 S100", 2500.0),
    ("grblhal", "G96 D2500 S100", 2500.0),
    ("siemens", "G26 S2500", 2500.0),
    ("siemens", "LIMS=2500", 2500.0),
    ("mach3", "G50 S2500", np.inf),
]


@pytest.mark.parametrize(("name", "text", "cap"), CAPS)
def test_the_fastest_that_surface_speed_turns(name, text, cap):
    dialect = dialects.load(name)
    words = lex(text.encode() + b"\n", dialect.grammar)
    spindle, after = pace.spindle(words, dialect, pace.Spoken())
    assert spindle.cap.tolist() == [cap]
    assert after.cap == cap
    assert after.rpm == (100.0 if "S100" in text else 0.0 if np.isfinite(cap) else 2500.0)


def test_a_control_without_tests_is_told_which_have_them():
    site = read_machine(MACHINES / "example-mill")
    for name in NO_TESTS:
        with pytest.raises(UsageError, match="tests are not written"):
            experiments.write("positioning:X", site, name)


@pytest.mark.parametrize(
    ("name", "end"), [("linuxcnc", "M30"), ("smoothie", "M2"), ("reprap", "M2"), ("marlin", "")]
)
def test_a_test_ends_with_a_code_that_ends_programs(name, end):
    """M30 deletes a file on printers: none is written there."""
    write = Writer(read_machine(MACHINES / "example-mill"), name)
    write.begin("end")
    last = write.text().splitlines()[-1]
    assert last == end if end else last.startswith("G0 ")
