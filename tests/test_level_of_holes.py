"""R of a drilling cycle where the tool stands, and the place of a tool that taps in step."""

from __future__ import annotations

import pytest
from fuzz.cases import Case, filter_of
from fuzz.laws import broken, outcome

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.nc import dialects
from postproc.verify import Verifier
from tests.corpus.machines import FAR, write_zero

HEAD = "G21 G17 G90|M3 S500|G0 X0 Y0 Z5.|G0 Z3.|"
ZEROS = {"G54": dict.fromkeys("XYZ", 0.0)}


@pytest.fixture(scope="module")
def high(tmp_path_factory) -> Machine:
    """A mill whose Z stands 6 um too high everywhere, so that it is sent lower."""
    folder = write_zero(tmp_path_factory.mktemp("mill") / "mill")
    (folder / "Z.csv").write_text(f"Z_mm,EZZ_um\n{-FAR},6\n{FAR},6\n")
    return read_machine(folder)


def sent(machine: Machine, text: str, dialect: str, cut: int = 0) -> list[str]:
    """The program's lines without gcomp's mark, verified: fed whole, or cut at a line."""
    filter_ = Filter(machine, dialects.load(dialect), setup_of(machine, offsets=ZEROS))
    verifier = Verifier(filter_)
    data = [(line + "\n").encode() for line in text.split("|")]
    out = filter_.feed(b"".join(data[:cut])) + filter_.feed(b"".join(data[cut:]))
    lines = (out + filter_.finish()).decode().splitlines()
    assert verifier.passed, verifier.report()
    return [line for line in lines if "GCOMP" not in line]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas", "centroid", "smoothie"])
@pytest.mark.parametrize("cut", range(5, 11))
def test_r_where_the_tool_stands_goes_down_with_it(high, dialect, cut):
    """Left above the tool, no manual of these says where G98 goes back to."""
    text = HEAD + "G98 G81 X1. Y1. Z-5. R3. F100|X2.|X3. R3.|G99 X4. R3.|G98 X5.|G80|M30"
    lines = sent(high, text, dialect, cut)
    assert lines[3] == "G0 Z2.9940"
    assert [x.split("R")[1].split()[0] for x in lines if "R" in x] == ["2.9940"] * 3


@pytest.mark.parametrize("cut", range(4, 8))
def test_r_goes_down_with_the_tool_only_where_the_tool_stands_at_it(high, cut):
    """Behind a hole that ended at R2. it stands there: R3., the level before the cycle, is higher
    and stays (it became R2.). Where G98 goes back to then is not said."""
    text = HEAD + "G99 G81 X1. Y1. Z-5. R2. F100|{}X2. R3.|G80|M30"
    lines = sent(high, text.format(""), "fanuc-mill", cut)
    assert [x.split("R")[1].split()[0] for x in lines if "R" in x] == ["2.", "3."]
    with pytest.raises(ProgramError, match=":6: a cycle in G98 whose R lies above the level"):
        sent(high, text.format("G98 "), "fanuc-mill", cut)


@pytest.mark.parametrize("cut", range(4, 9))
def test_g98_at_an_r_that_did_not_go_down_with_the_tool_is_refused(high, cut):
    """R3. was named where the tool stood at R2., and stays; a hole later Z3. comes to lie below it.
    It was called an error of gcomp, by --verify alone."""
    text = HEAD + "G99 G81 X1. Y1. Z-5. R2. F100|X2. R3.|{}|G80|M30"
    lines = sent(high, text.format("X4."), "fanuc-mill", cut)
    assert [x.split("R")[1].split()[0] for x in lines if "R" in x] == ["2.", "3."]
    with pytest.raises(ProgramError, match=":7: a cycle in G98 whose R lies above the level"):
        sent(high, text.format("G98 X4."), "fanuc-mill", cut)


@pytest.mark.parametrize("level", ["2.", "3.0001"])
def test_another_r_stays_as_written(high, level):
    if float(level) > 3:
        with pytest.raises(ProgramError, match="whose R lies above the level"):
            sent(high, HEAD + f"G98 G81 X1. Y1. Z-5. R{level} F100|G80|M30", "fanuc-mill")
    else:
        lines = sent(high, HEAD + f"G98 G81 X1. Y1. Z-5. R{level} F100|G80|M30", "fanuc-mill")
        assert f"R{level} " in lines[4]


@pytest.mark.parametrize("dialect", ["linuxcnc", "mach3", "grblhal"])
def test_r_stays_where_the_control_goes_back_to_r(high, dialect):
    """NIST RS274/NGC 3.5.16."""
    lines = sent(high, HEAD + "G98 G81 X1. Y1. Z-5. R3. F100|G80|M30", dialect)
    assert "R3. " in lines[4]


@pytest.mark.parametrize("cut", range(3, 7))
def test_g33_1_names_the_place_where_it_stands(high, cut):
    """LinuxCNC G-codes, "G33.1 X- Y- Z- K-": it goes there in step. A word of the place where it
    stands moves nothing, and names the corrected one."""
    text = (
        "G21 G17 G90|M3 S500|G0 X1. Y1. Z5.|G33.1 X1. Z-5. K1.|G91 G33.1 Y0 Z-8. K1.|G90 G0 X2.|M2"
    )
    lines = sent(high, text, "linuxcnc", cut)
    assert lines[3:5] == ["G33.1 X1. Z-5.0060 K1.", "G91 G33.1 Y0 Z-8. K1."]


@pytest.mark.parametrize("block", ["G33.1 X1.0001 Z-5. K1.", "G91 G33.1 Y0.0001 Z-5. K1."])
def test_g33_1_to_a_place_beside_it_is_refused(high, block):
    with pytest.raises(ProgramError, match="a rigid tap with a word of [XY], where it does not"):
        sent(high, f"G21 G17 G90|M3 S500|G0 X1. Y1. Z5.|{block}|G90 G0 Z5.|M2", "linuxcnc")


def test_g33_1_with_a_word_of_an_axis_that_stands_nobody_knows_where_is_refused(high):
    with pytest.raises(ProgramError, match="a rigid tap with a word of Y, where it does not"):
        sent(high, "G21 G17 G90|M3 S500|G0 X1. Z5.|G33.1 Y1. Z-5. K1.|M2", "linuxcnc")


@pytest.mark.parametrize(
    "block", ["M109/1/2", "N5 M109 /2", "m108/1/2 (ON)", "M109/1/2 G84 Z-5. R2. F1."]
)
def test_slashes_of_a_centroids_overrides_are_no_block_delete(high, block):
    """Centroid, "M108/M109 Enable/Disable Override Controls": of the feed (1), the spindle (2)."""
    lines = sent(high, f"{HEAD}{block}|G80|G1 Z-4. F100|M99", "centroid")
    assert lines[4] == block.replace("-5.", "-5.0060") and lines[6] == "G1 Z-4.0060 F100"


@pytest.mark.parametrize("block", ["M109/3", "M3/1/2", "M109/1/2/1", "M109 Z4./1", "M109"])
def test_other_slashes_of_a_centroid_stay_what_they_are(high, block):
    text = f"{HEAD}{block}|G1 Z-4. F100|M99"
    if "/" not in block:
        assert sent(high, text, "centroid")[5] == "G1 Z-4.0060 F100"
        return
    with pytest.raises(ProgramError, match="'/' is block delete only"):
        sent(high, text, "centroid")


@pytest.mark.parametrize("plane", ["G17", "G18", "G19"])
@pytest.mark.parametrize("cut", [0, 3, 4])
def test_g33_1_goes_to_its_words_in_every_plane(high, plane, cut):
    """LinuxCNC G-codes, "G33.1 X- Y- Z- K-": it takes no axis from the plane. G18 is a lathe's."""
    text = f"G21 {plane} G90|M3 S500|G0 X1. Y1. Z5.|G33.1 Z-5. K1.|G0 Z6.|M2"
    assert sent(high, text, "linuxcnc", cut)[3:5] == ["G33.1 Z-5.0060 K1.", "G0 Z5.9940"]


def test_g33_1_along_x(high):
    text = "G21 G19 G90|M3 S500|G0 X1. Y1. Z5.|G33.1 X-5. K1.|G0 Z6.|M2"
    assert sent(high, text, "linuxcnc")[3:5] == ["G33.1 X-5. K1.", "G0 Z5.9940"]


HOLES = {
    "the initial level": "X40. Y40. Z5.|G98 {} X20. Y-10. Z-5. R3.|G80|G0 X20. Y20.",
    "a feed behind it": "X120. Y10. Z5.|G98 {} X0. Y-10. Z-5. R3.|G80|G1 X160. Y20.",
    "from above": "X40. Y40. Z12.|Z5.|G98 {} X20. Y-10. Z-5. R3.|G80|G0 X20. Y20.",
    "R": "X60. Y-10. Z5.|G99 {} X20. Y10. Z-5. R3.|G80|G0 X140. Y-30.",
    "several": "X10. Y0. Z5.|G98 {} X150. Y40. Z-5. R3.|X20.|X80. Y-30.|X199.|G80|G0 X100.",
    "R at last": "X60. Y-10. Z5.|G98 {} X20. Y10. Z-5. R3.|G99 X80. Y-30.|G80|G0 X140.",
    "R before": "X40. Y40. Z5.|G99 {} X20. Y-10. Z-5. R3.|X20.|G98 X80. Y-30.|G80|G0 X20. Y20.",
    "at R again": "X60. Y-10. Z5.|G99 {} X20. Y10. Z-5. R3.|G80|G98 {} X20. Y-20. Z-8. R2.|G80"
    "|G0 X140. Y-30.",
}


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "haas", "grblhal"])
@pytest.mark.parametrize("block", HOLES.values(), ids=HOLES)
@pytest.mark.parametrize("code", ["G81", "G73 Q1."])
def test_behind_holes_z_bears_as_the_way_from_where_the_control_goes_back_to_leads_it(
    dialect, block, code
):
    """The control goes back to the command before the cycle, which was corrected for another place
    and another side, or to R as written. Taken as corrected there, Z was 4 um of play off behind
    each of these. Whole, line by line, and replayed."""
    text = f"G21 G17 G90 F100|M3 S500|G0 {block.format(code, code)}|G1 Z-5.|"
    assert broken(Case(text.replace("|", "\n").encode(), dialect, "two-way")) == ""


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas", "centroid", "smoothie"])
def test_behind_holes_whose_r_is_the_initial_level_z_stands_there_as_written(dialect):
    """Z5.0 was sent higher than R5.: G98 goes back there, not to R (4 um of play)."""
    text = (
        "G21 G17 G90|M3 S500|G0 X180. Y40. Z5.|G98 G81 X180. Y-50. Z-9. R5. F100|G80|G1 X0. Y20.|"
    )
    assert broken(Case(text.replace("|", "\n").encode(), dialect, "two-way")) == ""


@pytest.mark.parametrize("dialect", ["linuxcnc", "mach3", "grblhal"])
@pytest.mark.parametrize("block", ["G80", "X67. Y-8.|X79.|G80", "G99 X30.|G98 X50. R2.|G80"])
def test_where_r_is_the_initial_level_these_go_back_to_the_higher_one(dialect, block):
    """NIST RS274/NGC 3.5.16: no lower than R. Z3. was sent higher than R3., and taken to stand at
    R (4.3 um of play left)."""
    text = f"G0 X100. Y20. Z3.|G98 G81 X20. Y-14. Z-9. R3. F100|{block}|G1 X25. F100|Z2.9|X30.|"
    case = Case(("G21 G17 G90|M3 S500|" + text).replace("|", "\n").encode(), dialect, "two-way")
    assert broken(case) == ""


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "centroid", "smoothie"])
def test_behind_holes_at_r_g98_goes_back_to_where_the_cycle_began(dialect):
    """As high as R, and not where the hole before it ended (4.3 um of play left)."""
    text = "G0 X100. Y20. Z3.|G98 G81 X20. Y-14. Z-9. R3. F100|G99 X30.|G98 X50.|G80|G1 X25.|"
    text = f"G21 G17 G90|M3 S500|{text}Z2.9|X30.|"
    assert broken(Case(text.replace("|", "\n").encode(), dialect, "two-way")) == ""


def test_r_goes_down_to_where_the_tool_comes_to_stand_in_any_cut():
    """It rests at X27.; R of the second hole went where it would stand if it did not (0.3 um)."""
    text = (
        "G21 G17 G90|M3 S500|G0 X170. Y-55. Z7.|G0 Z4. F100|G99 G81 X91. Y40. Z-6. R4. F100|G0"
        " X176.|G0 X27.|G99 G81 X34. Y0. Z-6. R4. F100|X136. Y-12. R4.|G80|G0 Z4.|G1 Z-12.|"
    )
    assert broken(Case(text.replace("|", "\n").encode(), "smoothie", "one-way")) == ""


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "haas", "centroid"])
def test_behind_a_hole_that_bends_the_others_bear_as_they_were_held(dialect):
    """X and Y are held for the middle of what corrects them down the hole, not for what corrects
    them at its middle: where the two lay apart, X turned back unseen (5.2 um left)."""
    hole = "G98 G81 X170. Y23. Z-25. R2. F100|G80|G0 Z11.|X57.|G1 Z-17.|"
    text = f"G21 G17 G90|M3 S500|G0 X83. Y27. Z27.|{hole}"
    assert broken(Case(text.replace("|", "\n").encode(), dialect, "two-way")) == ""


# blocks with a G33.1, and the line at which they are refused
TAPS = {
    "G33.1 Z-3. K1.|G19|X0": 6,
    "G33.1 Z-3. K1.|G19 X0": 5,
    "G33.1 Z-3. K1.|G18|X0|Z-4.": 6,
    "G19 G33.1 X-3. K1.|Z-4.": 5,
}


@pytest.mark.parametrize("blocks", TAPS)
def test_g33_1_keeps_its_axis_until_it_is_called_again(blocks):
    """Another plane does not turn it: refused alike, whole, line by line and byte by byte."""
    text = f"G21 G17 G90|M3 S500|G0 X0 Y0 Z5.|{blocks}|M2|".replace("|", "\n").encode()
    case = Case(text, "linuxcnc")
    assert broken(case) == ""
    assert outcome(filter_of(case), [text])[1].startswith(f"program:{TAPS[blocks]}:")


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "haas", "grblhal"])
@pytest.mark.parametrize("block", ["G91 X5.", "G91|X5.", "G91 G81 X5."])
def test_a_hole_in_g91_of_words_in_g90_is_refused_in_any_cut(dialect, block):
    """Whether Z and R count as distances now is not said. Line by line, and where the code stands
    in the block, they were taken as places (33 um left)."""
    text = f"G21 G17 G90 F100|M3 S500|G0 X90. Y0. Z5.|G98 G81 X50. Z-5. R3.|{block}|G80|"
    case = Case(text.replace("|", "\n").encode(), dialect)
    assert broken(case) == ""
    assert "a cycle that returns to R under G91" in outcome(filter_of(case), [case.text])[1]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas", "linuxcnc", "mach3"])
@pytest.mark.parametrize("kind", ["one-way", "two-way"])
def test_l0_beside_a_place_is_refused(dialect, kind):
    """The words count as the place from then on, and the tool does not go there: a way there was
    put in front of the next block."""
    text = "G98 G81 X10. Y5. Z-5. R3. F100|X50. Y-9. L0|G80|G91 G1 X1. Y1.|G90 X3.|M30"
    case = Case((HEAD + text).replace("|", "\n").encode(), dialect, kind)
    assert broken(case) == ""
    assert ":6: L0 beside a place stores words" in outcome(filter_of(case), [case.text])[1]
