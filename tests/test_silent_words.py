"""Words that were read in silence as something else: offsets of T, diameters of DIAM90, commands of
a sender, holes below R, numbers of many digits."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.file import read_machine
from postproc.nc import dialects
from tests.corpus.machines import FAR, write_zero
from tests.test_okuma_lathe import follow as of_okuma
from tests.test_okuma_lathe import motions

HEAD = "G21 G17 G90|G0 X0 Y0 Z5.|"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A program's lines without gcomp's mark, and its notices, on a mill whose Z stands 30 um too
    low everywhere."""
    folder = write_zero(tmp_path_factory.mktemp("mill") / "mill")
    (folder / "Z.csv").write_text(f"Z_mm,EZZ_um\n{-FAR},-30\n{FAR},-30\n")
    machine = read_machine(folder)
    zeros = {"G54": dict.fromkeys("XYZ", 0.0)}

    def run(text: str, dialect: str, cut: int = 0, offsets=zeros, block_delete: bool = False):
        setup = setup_of(machine, offsets=offsets, block_delete=block_delete)
        filter_ = Filter(machine, dialects.load(dialect), setup)
        data = [(line + "\n").encode() for line in text.split("|")]
        out = filter_.feed(b"".join(data[:cut])) + filter_.feed(b"".join(data[cut:]))
        lines = (out + filter_.finish()).decode().splitlines()
        return [line for line in lines if "GCOMP" not in line], filter_.notices

    return run


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "fanuc-lathe-a", "haas-lathe"])
def test_a_whole_number_alone_with_t_may_be_an_offset(dialect):
    """T2W202: tool 2, offset 202 on lathes whose posts write it; an increment of 202 mm in the
    manuals of these controls."""

    def why(block: str) -> str:
        found = motions(f"G0 X50. Z10.|{block}|G1 Z-20. F.1", dialect)
        return " ".join(found.reasons[r][0] for r in found.reason)

    said = "W without a decimal point alone with T"
    assert said in why("T202W202")
    assert said in why("N5 T202 W202 (TOOL)")
    for plain in ("T0202 W2.", "T0202 U2 W2", "G0 T0202 W2", "T0202 Z2", "T0202", "T202W0", "W2"):
        assert said not in why(plain), plain


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "fanuc-lathe-a", "haas-lathe", "okuma-lathe"])
@pytest.mark.parametrize(
    ("tool", "name"),
    [("T2", "T0002"), ("T02", "T0002"), ("T303", "T0303"), ("T200", ""), ("T0", "")],
)
def test_the_last_two_digits_of_a_lathe_t_are_an_offset(dialect, tool, name):
    """Fanuc B-64304EN-1, "Tool function": T2 is T0002, and was read as no offset."""
    found = motions(f"{tool}|G0 X5. Z5.", dialect)
    reasons = [found.reasons[r][0] for r in found.reason]
    assert (f"offset {name} is not stated" in reasons[-1]) == bool(name) == bool(reasons[-1])


@pytest.mark.parametrize(("tool", "name"), [("T01010", "T1010"), ("T01100", "T01100")])
def test_a_lathe_t_of_five_digits_may_have_an_offset_of_three(tool, name):
    """Fanuc B-63943EN-1, 12: parameter 5028 may be 3; T01100 was read as no offset."""
    found = motions(f"{tool}|G0 X5. Z5.", "fanuc-lathe")
    assert f"offset {name} is not stated" in found.reasons[found.reason[-1]][0]
    assert not any(motions("T01000|G0 X5. Z5.", "fanuc-lathe").reason)


def test_ac_and_ic_say_under_diam90_whether_a_word_is_a_diameter():
    """Sinumerik 840D sl, DIAM90: places are diameters, distances radii; they went by G90 G91."""
    text = "DIAM90|G90 G18 G0 X40 Z5|X=IC(2)|X=AC(50)|G91 X3|X=AC(60)|X=IC(-1)|DIAMON|X=IC(4)"
    found = motions(text, "siemens")
    assert (found.target[0] / 1e10).tolist() == [20, 22, 25, 28, 30, 29, 31]


def test_okuma_t_takes_its_last_four_digits():
    assert of_okuma("T010101|G0 X5. Z5.")[1] == [""]
    assert "T0007 is not stated" in of_okuma("T010007|G0 X5. Z5.")[1][0]


@pytest.mark.parametrize("dialect", ["grbl", "grblhal", "fluidnc"])
def test_variables_and_waits_of_a_sender_do_not_end_the_program(run, dialect):
    """CNCjs: %wait, %X0=posx. The second "%" ended the program, and nothing behind it moved."""
    text = f"{HEAD}%X0 = posx|G1 Z-40. F100|%wait ; for the tool|G1 Z-39.|M2"
    lines, notices = run(text, dialect)
    assert [x for x in lines if x.startswith("G1")] == ["G1 Z-39.9700 F100", "G1 Z-38.9700"]
    assert lines[2] == "%X0 = posx" and not notices
    with pytest.raises(ProgramError, match="'%' begins a command of the sender"):
        run(f"{HEAD}%update|G1 Z-40. F100|M2", dialect)


@pytest.mark.parametrize("end", ["M30", "M2", "%"])
@pytest.mark.parametrize("cut", [0, 1, 2, 3, 4, 5])
def test_blocks_behind_the_end_of_a_sent_program_are_reported(run, end, cut):
    lines, notices = run(f"%|{HEAD}{end}|(X1)|G1 Z-40. F100|Z-39.", "grbl", cut)
    (told,) = [n for n in notices if n.code == "behind"]
    assert lines[-2:] == ["G1 Z-40. F100", "Z-39."]
    assert told.line == len(lines) - 1
    assert "stay as they are" in told.message


def test_blocks_behind_m30_of_a_control_that_ends_there_are_not_reported(run):
    assert not run(f"{HEAD}M30|G1 Z-40. F100", "fanuc-mill")[1]


@pytest.mark.parametrize(
    "dialect", ["fanuc-mill", "haas", "centroid", "linuxcnc", "mach3", "grblhal"]
)
def test_g98_with_r_above_the_tool_goes_where_a_manual_says_or_nowhere(run, dialect):
    """NIST RS274/NGC 3.5.16: never below R. The others say "the initial level" alone."""
    text = HEAD + "G98 G81 X1. Y1. Z-5. R{}. F100|G80|G91 G1 Z-45.|M30"
    if dialect in ("linuxcnc", "mach3", "grblhal"):
        found = run(text.format(8), dialect)[0]
        assert [x for x in found if "G91" in x] == ["G91 G1 Z0.0300"]  # from R
    else:
        with pytest.raises(ProgramError, match="whose R lies above the level"):
            run(text.format(8), dialect)
    run(text.format(5), dialect)


def test_a_slash_within_a_block_of_a_haas(run):
    """Haas 96-8210, "Block Delete": what stands behind it is skipped where the switch is on."""
    said = [("block delete", 3)]
    lines, notices = run(HEAD + "G1 Z4. F99. / X2. M8|Z3./M9|X3.", "haas")
    assert lines[2:] == ["G1 Z4.0300 F99. / X2. M8", "Z3.0300/M9", "X3."]
    assert [(n.code, n.line) for n in notices if n.code == "block delete"] == said
    twice = HEAD + "G1 Z4. F99. / Z2. M8|Z3./M9|X3."
    with pytest.raises(ProgramError, match="two Z words"):
        run(twice, "haas")
    lines, notices = run(twice, "haas", block_delete=True)
    assert lines[2:] == ["G1 Z4.0300 F99. / Z2. M8", "Z3.0300/M9", "X3."]
    assert [(n.code, n.line) for n in notices if n.code == "block delete"] == said
    assert "block delete" not in [n.code for n in run(HEAD, "haas")[1]]


def test_k_of_a_haas_cycle_repeats_nothing(run):
    """Haas mill operator's manual: L repeats; K is the least peck of G73 and G83 alone."""
    text = HEAD + "{} X1. Y1. Z-5. R2. F100 {}|G80|M30"
    with pytest.raises(ProgramError, match="K in a cycle that has none"):
        run(text.format("G81", "K3"), "haas")
    run(text.format("G83", "I2. J.5 K1."), "haas")
    run(text.format("G81", "K1"), "fanuc-mill")


def test_decimals_beyond_the_eighteenth_digit_are_dropped(run):
    """JavaScript and Python write as many; read_float of GRBL drops them too."""
    lines, _ = run(HEAD + "G1 Z-40.053299492385786795 X0.053299492385786795 F100|M2", "grbl")
    assert lines[2] == "G1 Z-40.023299492 X0.053299492385786795 F100"
    with pytest.raises(ProgramError, match="digits"):
        run(HEAD + "G1 X1234567890.123456789|M2", "grbl")


@pytest.mark.parametrize(
    ("dialect", "block", "way_out"),
    [
        ("fagor", "(P1=5)", "write the numbers"),
        ("fagor", "(IF P1 EQ 2 GOTO N10)", "write the blocks as they run"),
        ("fagor", "(PROBE 1,P5)", "keep measuring in a program of its own"),
        ("fagor", "(ORGX54=3)", "program in G54 to G57"),
        ("fagor", "(CALL 1)", "write it out in line"),
        ("fagor", "G33 Z-5 L1", "cut threads and taps in a program of their own"),
        ("centroid", "G81 X1 Y1 Z-5 R2 L3", "write the hole out as G0 and G1"),
        ("centroid", "#100=5", "let the CAM program write plain blocks"),
    ],
)
def test_advice_names_what_this_control_has(run, dialect, block, way_out):
    """No O-words, no G32 and no --expand, which these two have not."""
    with pytest.raises(ProgramError) as caught:
        run(f"G90 G17|G0 X0 Y0 Z5|F100|{block}|G1 X9|M30", dialect)
    assert way_out in caught.value.advice
    assert not any(x in caught.value.advice for x in ("O-word", "--expand", "G32"))


@pytest.mark.parametrize("code", ["G110", "G154 P1", "G129", "G154 P20"])
def test_g110_of_a_haas_is_g154_p1(run, code):
    """Mill operator's manual 96-8210, "G110-G129": its offset could not be stated."""
    number = 20 if "2" in code else 1
    with pytest.raises(ProgramError) as caught:
        run(f"G21 G90 {code}|G0 X1. Y1. Z5.|M30", "haas")
    assert f"--offset G54.1P{number}=X0,Y0,Z0" in caught.value.advice
    stated = {f"G54.1 P{number}": {"X": 0.0, "Y": 0.0, "Z": -2.0}}
    lines, _ = run(f"G21 G90 {code}|G0 X1. Y1. Z5.|M30", "haas", offsets=stated)
    assert lines[1] == "G0 X1. Y1. Z5.0300"


@pytest.mark.parametrize(("block", "comma"), [("X5,5", True), ("$TC_DP1[1,1]=5", False)])
def test_a_comma_in_a_list_is_no_decimal_comma(run, block, comma):
    with pytest.raises(ProgramError) as caught:
        run(f"G17 G90|G0 X0 Y0 Z5|{block}|M30", "siemens")
    assert ("not a comma" in caught.value.advice) == comma
