"""What is refused, where, and in which words: a refusal is a place, a fact and a way out."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from postproc.compensate import Options, limits
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects

ROOT = Path(__file__).resolve().parents[1]
GRINDER = read_machine(ROOT / "machines" / "studer-s36")
PERFECT = read_machine(ROOT / "machines" / "perfect")
LATHE, LINUXCNC = "fanuc-lathe", "linuxcnc"
HEAD = "(a part)\n\nG90 G21 G18\nG0 X20. Z10.\n"  # four lines that are fine


@dataclass(frozen=True)
class Case:
    """`text` after HEAD is refused with `says` in its line `line` (from 1), `marked` under the
    pointer ("": the block).

    by_map: only because the correction depends on it; a machine without errors passes it.
    """

    text: str
    says: str
    line: int = 1
    marked: str = ""
    dialect: str = LATHE
    by_map: bool = False
    outside: str | None = None

    def __str__(self) -> str:
        return f"{self.text!r} {self.dialect}"


MAP = True
CASES = [
    # letters and codes that mean nothing, or two things at once
    Case("@5", "'@'", 1, "@"),
    Case("G1 X30. e5. F100", "the letter E has no meaning", 1, "e5."),
    Case("G1 X1e5", "the letter E has no meaning", 1, "e5"),
    Case("G1 X30. E5", "the letter E has no meaning", 1, "E5", LINUXCNC),
    Case("G1 X30. U2.", "no axis U", 1, "U2.", LINUXCNC),
    Case("N7 G38 X3.", "G38 is not a code", 1, "G38"),
    Case("G999", "G999 is not a code", 1, "G999", LINUXCNC),
    Case("G1.55 X3.", "G1.55 is not a code", 1, "G1.55"),
    Case("G-1 X3.", "G-1 is not a code", 1, "G-1"),
    Case("G4 X1.", "no P", 1, "", LINUXCNC, MAP),
    Case("G1 X20. X30.", "two X words", 1, "X30."),
    Case("G1 X20. X30.", "two X words", 1, "X30.", LINUXCNC),
    Case("G1 X20. F1 F2", "two F words", 1, "F2"),
    Case("G1 X20. U3.", "X and its increment", 1, "U3."),
    Case("G1 W1. Z3.", "Z and its increment", 1, "W1."),
    Case("G0 G1 X20.", "two codes of the modal group 'motion'", 1, "G1", LINUXCNC),
    Case("G1 X9999999.", "beyond 1e+06 mm", 1, "X9999999."),
    Case("G1 Z1000000.0000001", "beyond 1e+06 mm", 1, "Z1000000.0000001"),
    Case("T1 M6\nG1 X F10", "the letter X has no number", 2, "X", LINUXCNC),
    # arcs
    Case("G3 X40. Z30. I0. K10. F100", "the arc misses its own end point by", by_map=MAP),
    Case("G3 X40. Z30. I0. K10. F100", "the arc misses its own end point by", 1, "", LINUXCNC, MAP),
    Case(
        "G3 X40. Z30. R5. F100", "R 5.0000 is too short: the end lies 22.3607 mm away", by_map=MAP
    ),
    Case("G3 X40. Z30. F100", "an arc without its centre words", by_map=MAP),
    Case("G2 X40. Z30. F100", "an arc without its centre words", 1, "", LINUXCNC, MAP),
    Case("G3 X20. Z10. I0. K0.", "an arc of radius 0", by_map=MAP),
    Case("G3 X20. Z10. R5.", "ends where it begins", by_map=MAP),
    Case("G3 X40. Z30. I0. K20. R5.", "a centre and with R", by_map=MAP),
    Case("G3 X30. Z20. J3. K2.", "does not belong to the ZX plane", by_map=MAP),
    Case("G17 G3 X30. I3.", "machine has no such axes", 1, "", LATHE),
    Case("G3 Z30. X20. K10. P1.5", "turns of an arc are not a whole number", 1, "", LINUXCNC, MAP),
    Case("G3 Z30. X20. K10. P2", "P in an arc", by_map=MAP),
    # motions that can not be followed
    Case("G1 Z30. I5.", "I in a straight motion", by_map=MAP),
    Case("G1 X30. R5. F10", "R in a straight motion", by_map=MAP),
    Case(
        "G1 X400. F10",
        "X = 200.0000 mm lies outside the error table of X (0 to 170 mm)",
        by_map=MAP,
    ),
    Case(
        "G1 Z-0.1 F10", "Z = -0.1000 mm lies outside the error table of Z (0 to 510 mm)", by_map=MAP
    ),
    Case("G91 G1 Z501. F10", "Z = 511.0000 mm lies outside", by_map=MAP),
    Case("G20\nG1 X20. F10", "X = 254.0000 mm lies outside", 2, by_map=MAP),
    Case("G1 X352. F10", "is beyond the travel of X (-5 to 175 mm)", 1, "", LATHE, MAP, "clamp"),
    Case("G1 Z-5.1 F10", "is beyond the travel of Z (-5 to 520 mm)", 1, "", LATHE, MAP, "clamp"),
    Case("G28 U0 W0\nG1 Z30. F10", "where X stands is not known", 2, by_map=MAP),
    Case("G91 G53 X0", "G53 under G91", by_map=MAP),
    Case(
        "G81 Z20. F10", "a canned cycle across Y, which can not be followed", 1, "", LINUXCNC, MAP
    ),
    Case(
        "G17 G81 X30. Z20. R30. F10\nG18\nX40.",
        "a hole of a canned cycle in another plane than the cycle was called in",
        3,
        "",
        LINUXCNC,
        MAP,
    ),
    Case("G1 X30. F10\nG82 X10. Z20.", "G82 (drilling with dwell)", 2, by_map=MAP),
    Case("G43 H1\nG1 Z30. F10", "the tool length H1 is not stated", 2, "", LINUXCNC, MAP),
    Case(
        "G28 U0\nG92 X0 Z0\nG1 Z30. F10",
        "G92 gives X a new zero where the machine stands, and that is not known",
        3,
        by_map=MAP,
    ),
    Case("G10 P1 X1.\nG1 Z30. F10", "G10", 2, by_map=MAP),
    Case("G10 L2 P9 R3.\nG1 Z30. F10", "G10", 2, "", LINUXCNC, MAP),
    Case("G51 P2.\nG1 Z30. F10", "G51 (scaling)", 2, by_map=MAP),
    Case("M98 P1000", "M98 (subprogram call)", by_map=MAP),
    Case("M98 P1000", "M98 (subprogram call)", 1, "", LINUXCNC, MAP),
    Case("G1 X30.\rG1 Z30. F10", "a carriage return without a line feed", 1, "\r"),
    Case("G65 P1000", "G65 (macro call)", by_map=MAP),
    Case("G55\nG1 Z30. F10", "the work offset G55 is not stated", 2, by_map=MAP),
    Case("G55 G1 Z30. F10", "--offset G55=X0,Z0", by_map=MAP),
    Case("T0101\nG1 Z30. F10", "the tool offset T0101 is not stated", 2, by_map=MAP),
    # what is no plain block
    Case("#1=2", "'#'", 1, "#"),
    Case("[1+2]", "'['", 1, "["),
    Case("G1 X[1+2]", "the letter X has no number", 1, "X"),
    Case("G1 X#1", "the letter X has no number", 1, "X", LINUXCNC),
    Case("o100 sub", "'sub' is a statement", 1, "s", LINUXCNC),
    Case("IF [#1 EQ 2] GOTO 5", "'IF' is a statement", 1, "I"),
    Case("G1 X", "the letter X has no number", 1, "X"),
    Case("G1 X-", "the letter X has no number", 1, "X"),
    Case("N10 G1 X30. F10\n\n(c)\nN20 G1 Z.", "the letter Z has no number", 4, "Z"),
    Case("G1 X1.2.3", "'.' does not belong to a number", 1, "."),
    Case("G1 X+-3", "the letter X has no number", 1, "X"),
    Case("17", "a number without a letter", 1, "1"),
    Case("G1 X1,R2", "','", 1, ","),
    Case("G1 X30. $", "'$'", 1, "$"),
    Case("G1 X1234567890123456789", "19 digits (limit 18)", 1, "X"),
    Case("G1 Z30. (open", "a comment is opened and not closed", 1, "("),
    Case("G1 Z3(c)0.", "breaks a number in two", 1, "("),
    Case("G1 Z30. )", "')' closes a comment that was not opened", 1, ")"),
    Case("G1 Z30./F10", "'/' is block delete only as the first character", 1, "/"),
    Case("G1 Z3\u00e9", "byte 233 is not ASCII", 1, "\u00e9"),
    Case("G1 Z3\x00", "byte 0 is not text", 1, "\x00"),
    Case("G1 X30. %", "'%' stands inside a block"),
    Case("(GCOMP 0.1.0 STUDER-S36 MAP 78639B0E TOL 0.5 UM)\nG1 X30. F1", "corrected already"),
]


def filter_for(machine, case: Case) -> Filter:
    return Filter(
        machine,
        dialects.load(case.dialect),
        setup_of(machine),
        Options(outside=case.outside),
        name="part.nc",
    )


def refusal(machine, case: Case, text: str) -> ProgramError:
    filter_ = filter_for(machine, case)
    with pytest.raises(ProgramError) as caught:
        filter_.feed(text.encode("latin-1"))
        filter_.finish()
    return caught.value


@pytest.mark.parametrize("case", CASES, ids=str)
def test_is_refused_in_its_line_and_column(case):
    line = HEAD.count("\n") + case.line
    text = HEAD + case.text + "\nM30\n"
    error = refusal(GRINDER, case, text)
    assert case.says in str(error)
    assert (error.place.file, error.place.line) == ("part.nc", line)
    assert str(error).startswith(f"part.nc:{line}: ")
    assert error.place.text.rstrip() == text.split("\n")[line - 1].rstrip()
    assert (
        error.place.text[max(error.place.start - 1, 0) : max(error.place.stop - 1, 0)]
        == case.marked
    )
    if case.marked:
        below = str(error).split("\n")[2]
        assert below.index("^") == 4 + error.place.start - 1
        assert below.count("^") == len(case.marked)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_says_a_way_out(case):
    error = refusal(GRINDER, case, HEAD + case.text)
    assert error.advice
    assert len(error.message) < 200


@pytest.mark.parametrize("case", CASES, ids=str)
def test_what_precedes_the_fault_is_delivered(case):
    before = HEAD + "".join(case.text.splitlines(keepends=True)[: case.line - 1])
    error = refusal(GRINDER, case, HEAD + case.text + "\nM30\n")
    filter_ = filter_for(GRINDER, case)
    assert error.delivered == filter_.feed(before.encode()) + filter_.finish()


@pytest.mark.parametrize("case", CASES, ids=str)
def test_how_the_text_is_cut_does_not_matter(case):
    """Line by line the same refusal, and the same text before it."""
    text = HEAD + case.text + "\nM30\n"
    whole = refusal(GRINDER, case, text)
    filter_, out = filter_for(GRINDER, case), b""
    with pytest.raises(ProgramError) as caught:
        for line in text.encode("latin-1").splitlines(keepends=True):
            out += filter_.feed(line)
        filter_.finish()
    assert str(caught.value) == str(whole)
    assert out + caught.value.delivered == whole.delivered


@pytest.mark.parametrize("case", CASES, ids=str)
def test_line_ends_and_what_follows_do_not_matter(case):
    plain = refusal(GRINDER, case, HEAD + case.text + "\nM30\n")
    for text in (HEAD + case.text, (HEAD + case.text + "\nM30\n").replace("\n", "\r\n")):
        error = refusal(GRINDER, case, text)
        assert (error.message, error.advice) == (plain.message, plain.advice)
        assert (error.place.line, error.place.start, error.place.stop) == (
            plain.place.line,
            plain.place.start,
            plain.place.stop,
        )
        assert str(error) == str(plain)


@pytest.mark.parametrize("after", ["G1 X22. Z12. F10", "X22. Z12."])
@pytest.mark.parametrize("case", [c for c in CASES if c.by_map], ids=str)
def test_without_errors_what_only_the_map_forbids_passes(case, after):
    text = (HEAD + case.text + f"\n{after}\nM30\n").encode("latin-1")
    filter_ = filter_for(PERFECT, case)
    assert filter_.feed(text) + filter_.finish() == text


ELSEWHERE = ("no axis", "no such axes")  # the perfect machine has these axes


@pytest.mark.parametrize(
    "case", [c for c in CASES if not c.by_map and not any(e in c.says for e in ELSEWHERE)], ids=str
)
def test_without_errors_what_can_not_be_read_is_still_refused(case):
    error = refusal(PERFECT, case, HEAD + case.text + "\nM30\n")
    assert case.says in str(error)
    assert error.place.line == HEAD.count("\n") + case.line


# -- single ones -----------------------------------------------------------------------------------


@pytest.mark.parametrize("letter, text", [("Y", "Y5."), ("A", "A5."), ("C", "C5.")])
def test_an_axis_that_the_machine_has_not(letter, text):
    error = refusal(GRINDER, Case("", ""), f"{HEAD}G1 Z30. {text}\n")
    assert f"no axis {letter}" in error.message
    assert "X Z" in error.advice


@pytest.mark.parametrize("dialect", dialects.names())
@pytest.mark.parametrize("text", ["X20. Z5.", "N5\nX20."])
def test_no_motion_code_is_in_force(dialect, text):
    if dialects.load(dialect).motion >= 0:
        return  # a control that starts with G0 or G1
    if dialect in ("marlin", "klipper"):
        return  # such a line is no command there: tests/test_beginnings.py
    error = refusal(GRINDER, Case("", "", dialect=dialect), text + "\n")
    if dialect == "heidenhain":  # a statement of its own there
        assert "X20. can not be followed" in error.message
        assert error.advice.endswith("write L before it")
        return
    assert "no motion code (G0 G1 G2 G3) is in force" in error.message
    assert error.place.line == text.count("\n") + 1


def test_a_feed_while_an_axis_has_no_place():
    error = refusal(GRINDER, Case("", ""), "G1 X20. F100\n")
    assert "where Z stands is not known" in error.message
    assert "--start Z" in error.advice


def test_a_correction_that_is_too_large(tmp_path):
    """The deviation of X at 10 mm is a few um; a machine that allows 1 um refuses it, with both
    numbers."""
    folder = shutil.copytree(ROOT / "machines" / "studer-s36", tmp_path / "strict")
    toml = (folder / "machine.toml").read_text()
    assert "max_correction = 0.5" in toml
    (folder / "machine.toml").write_text(
        toml.replace("max_correction = 0.5", "max_correction = 0.001")
    )
    error = refusal(read_machine(folder), Case("", ""), "G90\nG0 X20. Z10.\n")
    assert re.fullmatch(
        r"the correction of X is 0\.003[23] mm \(limit max_correction = 0\.001 mm\)", error.message
    )
    assert error.place.line == 2
    assert "machine.toml" in error.advice


@pytest.mark.parametrize("mode", ["mean", "step", "ramp", "off"])
def test_an_axis_whose_place_is_not_known_has_no_correction_that_is_too_large(tmp_path, mode):
    """The map moves X by 1 mm at X0, more than the limit of 0.5; Z is led, and where X stands is
    not known: it may stand at X500, where the map moves nothing."""
    folder = shutil.copytree(ROOT / "machines" / "perfect", tmp_path / "machine")
    (folder / "X.csv").write_text("X_mm,EXX_um\n0,1000\n500,0\n")
    (folder / "Z.csv").write_text("Z_mm,EZZ_um\n0,3\n500,3\n")
    machine, options = read_machine(folder), Options(reversal=mode)
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup_of(machine), options)
    out = filter_.feed(b"G21 G90\nG0 Z10\nX500 Y5\n") + filter_.finish()
    assert out.decode().splitlines()[2:] == ["G0 Z9.9970", "X500 Y5"]
    case = Case("", "")
    assert "the correction of X is 1.0000 mm" in refusal(machine, case, "G90\nG0 X0\n").message


def test_in_a_line_of_several_blocks_the_right_one_is_marked():
    error = refusal(GRINDER, Case("", ""), HEAD + "G1 X30. F10; Z20.; X30. X31.; Z30.\n")
    assert error.place.line == 5
    assert error.place.text[error.place.start - 1 : error.place.stop - 1] == "X31."


def test_the_line_that_opens_the_tape_is_delivered_too():
    error = refusal(GRINDER, Case("", ""), "%\n" + HEAD + "G1 X400. F10\n")
    assert error.place.line == 6
    assert error.delivered.startswith(b"%\n(a part)\n")
    assert refusal(GRINDER, Case("", ""), "%\nG1 X\n").delivered == b"%\n"


def test_the_first_of_several_faults_is_reported():
    error = refusal(GRINDER, Case("", ""), HEAD + "G1 X30. F10\nG1 X400.\nX1 X2\nG999\n#1=1\n")
    assert error.place.line == 6
    assert "outside the error table" in error.message


def test_nothing_is_refused_behind_the_end_of_the_program():
    text = (HEAD + "G1 X30. F10\nM30\n#1 is not read $\nX1 X2\n").encode()
    filter_ = filter_for(GRINDER, Case("", ""))
    assert (filter_.feed(text) + filter_.finish()).endswith(b"M30\n#1 is not read $\nX1 X2\n")


def test_a_line_without_end_is_refused_however_it_comes():
    line = b"(" + b"a" * 2_000_000 + b")\n"
    for step in (len(line), 1 << 19):
        filter_ = filter_for(GRINDER, Case("", ""))
        with pytest.raises(ProgramError, match="1,000,000 characters"):
            for i in range(0, len(line), step):
                filter_.feed(line[i : i + step])


def test_own_output_behind_a_nominal_program_is_refused_however_it_comes():
    """Line by line or at once: the mark counts wherever it stands."""
    case = Case("", "")
    text = (
        HEAD + "G1 X30. F10\n(GCOMP 0.1.0 STUDER-S36 MAP 78639B0E TOL 0.5 UM)\nG1 X31. F10\n"
    ).encode()
    for parts in ([text], text.splitlines(keepends=True)):
        filter_ = filter_for(GRINDER, case)
        with pytest.raises(ProgramError, match="corrected already"):
            for part in parts:
                filter_.feed(part)


def test_feed_as_inverse_time_without_a_feed_is_refused():
    error = refusal(GRINDER, Case("", ""), "G0 X20. Z10.\nG93 G1 X30. Z60.\n")
    assert error.place.line == 2
    assert "F" in error.message


@pytest.mark.parametrize("block", ["/ G31 Z-5. F100.", "/G31 Z-5. F100."])
def test_a_refused_block_that_a_switch_leaves_out_says_so(block):
    """Probing is often marked with /: with --block-delete on such a program is corrected."""
    machine = read_machine(Path(__file__).parents[1] / "machines" / "mv-1060")
    text = f"G21 G90 G17\nG0 X-400. Y-200. Z-100.\n{block}\nG1 X-410. F100.\nM30\n".encode()

    def run(block_delete: bool) -> bytes:
        setup = setup_of(machine, {"G54": {}}, block_delete=block_delete)
        filter_ = Filter(machine, dialects.load("fanuc-mill"), setup)
        return filter_.feed(text) + filter_.finish()

    with pytest.raises(ProgramError) as caught:
        run(False)
    assert caught.value.advice.endswith("--block-delete on")
    assert block.encode() in run(True)


ZEROS = {"G54": {"X": 0.0, "Z": 0.5}, "T1": {"Z": 3.0}}


@pytest.mark.parametrize(
    ("offsets", "dialect", "says"),
    [
        ({}, LATHE, "; no work offset is stated: --offset G54=X0,Z0 says where the part's zero"),
        ({}, "grbl", "; no work offset is stated: "),
        ({}, "marlin", ""),
        (ZEROS, LATHE, "; stated: G54 = X0 Z0.5"),
    ],
)
@pytest.mark.parametrize("outside", ["error", "clamp"])
def test_a_place_out_of_reach_is_told_with_where_the_zeros_were_said_to_lie(
    offsets, dialect, says, outside
):
    of = dialects.load(dialect)
    way = limits.BEYOND_TABLE if outside == "error" else limits.BEYOND_TRAVEL
    machine = replace(GRINDER, offsets={}).carrying(of.carried)
    filter_ = Filter(machine, of, setup_of(machine, offsets), Options(outside=outside))
    with pytest.raises(ProgramError) as caught:
        filter_.feed(b"G90\nG21\nG0 X20. Z10.\nG1 Z600. F100\n")
    advice = caught.value.advice
    assert advice.startswith(way + says) and (says or advice == way)


@pytest.mark.parametrize(
    "name",
    ["G54", "G59.3", "G54.1 P3", "G505", "G599", "G110", "G129", "G154 P2", "G15 H1", "G247 P1"],
)
def test_every_control_s_work_offset_counts_as_stated(name):
    said = limits.with_zeros(limits.BEYOND_TRAVEL, {name: {"X": 2.0}, "T1": {"Z": 3.0}}, "XZ")
    assert said == f"{limits.BEYOND_TRAVEL}; stated: {name} = X2"
