"""What the words of a tool's length take into force, where no other test asks: H0, and a tool that
nobody named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.nc import dialects
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import ours

MILL = str(Path(__file__).resolve().parents[1] / "machines" / "example-mill")
BODY = "G0 X10. Y10. Z10.\n{}\nG1 X20. Z5. F100\n"
LENGTHS = {"H1": {"Z": 30.0}, "H2": {"Z": 55.0}}


def corrected(text: str, dialect: str, lengths: dict | None = None) -> tuple[str, list[str]]:
    machine = places.load(MILL)
    zero = "G54" if dialect != "siemens" else "G500"
    offsets = {zero: {"X": 0.0, "Y": 0.0, "Z": -200.0}, **(LENGTHS if lengths is None else lengths)}
    filter_ = Filter(machine, dialects.load(dialect), setup_of(machine, offsets))
    out = filter_.feed(text.encode()) + filter_.finish()
    return out.decode(), [n.message for n in filter_.notices]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas", "mach3"])
@pytest.mark.parametrize("before", ["", "G43 H1\n", "T2 M6\nG43 H2\n"])
def test_h0_is_no_length(dialect, before):
    """Fanuc B-64304EN-2, tool length compensation: the value of H0 is always 0; it cancels as G49
    does."""
    head = "G90 G54\n"
    zero, none = (corrected(head + before + BODY.format(w), dialect)[0] for w in ("G43 H0", "G49"))
    assert zero == none.replace("G49", "G43 H0")


def test_d0_and_t0_are_no_length():
    assert (
        corrected("G90 G500\nD1\n" + BODY.format("D0"), "siemens", {"D1": {"Z": 30.0}})[0].count(
            "D0"
        )
        == 1
    )


def test_h0_of_linuxcnc_before_any_tool_is_no_length_and_is_said():
    zero, notices = corrected("G90 G54\n" + BODY.format("G43 H0"), "linuxcnc")
    none, quiet = corrected("G90 G54\n" + BODY.format("G49"), "linuxcnc")
    assert zero == none.replace("G49", "G43 H0")
    assert any("taken as no length" in n and "--offset H0=Z" in n for n in notices) and quiet == []


def test_h0_of_linuxcnc_can_be_stated():
    one, notices = corrected("G90 G54\n" + BODY.format("G43 H0"), "linuxcnc", {"H0": {"Z": 30.0}})
    same, _ = corrected("G90 G54\n" + BODY.format("G43 H1"), "linuxcnc")
    assert one == same.replace("G43 H1", "G43 H0") and notices == []


def test_g43_alone_with_no_tool_known_names_a_way_out_that_works():
    with pytest.raises(ProgramError) as error:
        corrected("G90 G54\n" + BODY.format("G43"), "linuxcnc")
    assert "which that is is not known" in error.value.message
    corrected("G90 G54\nT1 M6\n" + BODY.format("G43"), "linuxcnc")
    corrected("G90 G54\n" + BODY.format("G43 H1"), "linuxcnc")


@pytest.mark.skipif(oracle.available() is not None, reason=str(oracle.available()))
@pytest.mark.parametrize(
    "text",
    [
        "G43 H0\nG0 Z5\n",
        "T1 M6\nG0 X1\nG43 H0\nG0 Z5\n",
        "T1 M6\nG0 X1\nG43 H2\nG0 Z5\nG43 H0\nG0 Z6\n",
        "T1 M6\nG0 X1\nG43 H0\nG0 Z5\nT0 M6\nG0 X2\nG43 H0\nG0 Z7\n",
        "T2 M6\nG0 X1\nG43 H1\nG43.2 H0\nG0 Z5\n",
        "T1 M6\nG0 X1\nT2 M6 G43.2 H0\nG0 X2 Z5\nG43.2 H0\nG0 X3 Z5\n",
    ],
)
def test_h0_against_linuxcnc(text):
    """H0 takes the length of the tool in the spindle; G43.2 H0 adds it."""
    program = "G21 G90\n" + text + "M2\n"
    tools = {1: {"Z": 10.0}, 2: {"Z": 20.0}}
    theirs = [m.end[:3] for m in oracle.motions(program, tools=tools) if m.end != m.start]
    found = [tuple(m["end"][:3]) for m in ours(program, {"tools": tools})]
    assert found == [pytest.approx(e, abs=1e-9) for e in theirs]


@pytest.mark.parametrize(
    ("block", "radius"),
    [
        ("G10 L12 P1 R5.", 5.0),
        ("G10 L12 P1 R10.", 5.0),  # parameter 5004#2, Haas setting 40: a diameter
        ("G10 L12 P1 R4.", None),
        ("G20 G10 L12 P1 R.19685039", 5.0),  # 5 mm to 1e-7 mm
        ("G91 G10 L12 P1 R5.", None),
        ("G10 L13 P1 R0", 5.0),
        ("G10 L13 P1 R-.02", None),
        ("G10 L13 P2 R-.02", 5.0),
    ],
)
@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas"])
def test_a_radius_that_the_program_writes_is_known_where_it_is_as_stated(block, radius, dialect):
    """By hand: R 5 mm is stated for D1."""
    setup = Setup(("X", "Y", "Z"), offsets={"D1": {"R": 5.0}})
    tracker = Tracker(Interpreter(dialects.load(dialect), setup))
    tracker.take(block.encode())
    place = tracker.state.offsets.get("D1", setup.offsets["D1"])
    assert place.get("R") == radius
    assert not tracker.state.frame.unknown


@pytest.mark.parametrize("word", ["T1=2", "T1 = 2"])
def test_the_tool_of_the_main_spindle_is_a_tool(word):
    """Sinumerik's extended address: T1=2 is tool 2 of spindle 1."""
    both = {"T1D1": {"Z": 30.0}, "T2D1": {"Z": 55.0}}
    text = "G90 G500\nT1 M6\nD1\nG0 X0 Y0 Z9.\n{} M6\nD1\n" + BODY.format("M8")
    named, plain, other = (
        corrected(text.replace("{}", w, 1), "siemens", both)[0].split(" M6")[2]
        for w in (word, "T2", "T1")
    )
    assert named == plain != other


LEFT_OPEN = ["fanuc-mill", "haas", "centroid"]
HEAD = "G90 G54 G0 X10. Y10. Z10.\n"


@pytest.mark.parametrize("dialect", LEFT_OPEN)
@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("G91 G43 H1 Z-3.\nX6.\nG90 Z5.\nX7.\n", [True, False, False, True, True]),
        ("G43 H1\nX6.\nZ5.\nX7.\n", [True, False, True, True]),
        ("G43 H1 Z5.\nG91 Z-1.\nX1.\nG49 Z-1.\nX1.\n", [True, True, True, True, False, False]),
        ("G43 H1 Z5.\nG49\nX6.\nG53 Z0\nX7.\n", [True, True, False, True, True]),
        ("G43 H1 Z5.\nG49 Z5.\nX7.\n", [True, True, True, True]),
        ("G91 G43 H0 Z-3.\nX6.\n", [True, True, True]),  # no length, none before
        ("G43 H1 Z5.\nG43 H1\nX6.\n", [True, True, True]),  # the same again
    ],
)
def test_z_is_not_known_where_its_length_changes_and_no_place_is_named(text, known, dialect):
    """Fanuc B-64304EN-2, "Tool length compensation": the length is added to the end of the block in
    G91 too, and moves Z where the block does not name it; with shift types (parameter 5006#6) an
    increment stays as it is written. LinuxCNC moves nothing."""
    setup = Setup(("X", "Y", "Z"), offsets={"G54": {}, **LENGTHS}, start=dict.fromkeys("XYZ", 0.0))
    for name, expected in ((dialect, known), ("linuxcnc", [True] * len(known))):
        interpreter = Interpreter(dialects.load(name), setup)
        words = lex((HEAD + text).encode(), dialects.load(name).grammar, False)
        motions, _, _ = interpreter.run(words, interpreter.initial())
        assert motions.target_known[2].tolist() == expected


@pytest.mark.parametrize("dialect", [*LEFT_OPEN, "linuxcnc"])
def test_an_increment_behind_another_length_is_not_corrected_at_a_guessed_height(dialect):
    """H1 is 30 mm: Z stands at 7 or at 37 behind G91 G43 Z-3, and the map is not the same there.
    LinuxCNC stands at 7."""
    text = HEAD + "G91 {}Z-3.\nG1 X20. F100\n"
    plain = corrected(text.format(""), dialect)[0]
    assert corrected(text.format("G43 H0 "), dialect)[0].replace("G43 H0 ", "") == plain
    if dialect == "linuxcnc":
        corrected(text.format("G43 H1 "), dialect)
        return
    with pytest.raises(ProgramError, match="where Z stands is not known"):
        corrected(text.format("G43 H1 "), dialect)
    corrected(text.replace("G91 {}Z-3.", "G43 H1 Z7.\nG91"), dialect)  # as the advice says


def test_an_increment_behind_another_edge_travels_it_or_not():
    """Sinumerik SD42442: so no correction may depend on it; without another length, or behind an
    absolute Z, it is sure."""
    head = "G90 G500 G0 X10 Y10 Z50\nG91\n{}Z-3\nG1 X20 F100\n"
    lengths = {"D1": {"Z": 30.0}, "D2": {}}
    plain, other = (corrected(head.format(w), "siemens", lengths)[0] for w in ("", "D2\n"))
    assert other.replace("D2\n", "") == plain
    with pytest.raises(ProgramError, match="zero or its tool length was changed"):
        corrected(head.format("D1\n"), "siemens", lengths)
    corrected(head.format("D1\nZ=AC(20)\n"), "siemens", lengths)


def read(dialect: str, text: str):
    """The motions of a text on a mill whose zeros are the machine's."""
    machine = places.load(MILL)
    setup = replace(
        setup_of(machine, {"G54": dict.fromkeys("XYZ", 0.0), **LENGTHS}), home={"Z": 200.0}
    )
    interpreter = Interpreter(dialects.load(dialect), setup)
    words = lex(
        ("G90 G54\nG0 X0 Y0 Z300.\n" + text).encode(), dialects.load(dialect).grammar, False
    )
    return interpreter.run(words, interpreter.initial())[0]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas", "centroid"])
@pytest.mark.parametrize(
    "text, z",
    [
        ("G43 H1 Z5.\nH2 Z6.\n", [35.0, 61.0]),
        ("G43 H1 Z5.\nH0 Z6.\n", [35.0, 6.0]),
        ("G43 H1 Z5.\nH2\nZ6.\n", [35.0, 61.0]),
        ("G43 H1 Z5.\nG49\nH2 Z6.\n", [35.0, 6.0]),
        ("G43 H1 Z5.\nG44 H2 Z6.\nH1 Z6.\n", [35.0, -49.0, -24.0]),
    ],
)
def test_h_by_itself_names_another_length(dialect, text, z):
    """By hand: lengths of 30 and 55 mm. Fanuc 0i-MB B-63844EN, 14.1.2, "independent specification
    of the H command"; Centroid M-series, 11-2: "H3 ; Selects offset corresponding to H3"."""
    if dialect == "centroid" and "G44" in text:
        return  # not one of its codes
    motions = read(dialect, text)
    assert (motions.target[2, 1:] / TICKS_PER_MM).tolist() == z and motions.target_known[2].all()


TAKEN_BACK = [
    *((d, c) for d in ("fanuc-mill", "haas") for c in ("G91 G28 Z0\nG90", "G28 Z9.")),
    *(("fanuc-mill", c) for c in ("G30 Z9.", "G53 Z150.")),
]


@pytest.mark.parametrize("dialect, away", TAKEN_BACK)
def test_g28_takes_the_length_back(dialect, away):
    """Fanuc 0i-MB B-63844EN, 14.1.2: "tool length offset vectors are canceled"; Haas 96-8000, G28:
    "cancels tool length offsets for the following lines of code". So no Z may be put in behind it
    (30 mm too low by the shortest of these tools), and none be read, until H names it again."""
    head = f"G43 H1 Z5.\n{away}\nX10.\n"
    assert not read(dialect, head).target_known[2, -1]
    assert any("taken back" in m for m, _ in read(dialect, head + "Z5.\n").reasons)
    assert any("taken back" in m for m, _ in read(dialect, head + "F9\nG81 Z-5. R2.\n").reasons)
    for again in ("G43 H2 Z5.", "H2 Z5.", "G49 Z5."):
        motions = read(dialect, head + again + "\nX11. Z6.\n")
        assert motions.target_known[2, -1] and not motions.reason.any()
    alone = read(dialect, f"{away}\nX10.\nZ5.\n")  # no length, none taken back
    assert not alone.reason.any() and alone.target_known[2, -1]


@pytest.mark.parametrize(
    ("change", "sure"), [("G54", False), ("SUPA G0 Z0", False), ("G505", True), ("G54\nG500", True)]
)
def test_an_increment_behind_another_zero_travels_it_or_not(change, sure):
    """Sinumerik SD42440, as delivered: the change of the zero is travelled; so no correction may
    depend on it, unless the zero lies where it was, or Z has been said since."""
    zeros = {"G54": {"X": 0.0, "Y": 0.0, "Z": -180.0}, "G505": {"X": 0.0, "Y": 0.0, "Z": -200.0}}
    text = "G90 G500 G0 X10 Y10 Z50\n{}\n{}G91\nG1 Z-3 F100\nX20\n"
    if not sure:
        with pytest.raises(ProgramError, match="zero or its tool length was changed"):
            corrected(text.format(change, ""), "siemens", zeros)
    else:
        plain = corrected(text.replace("{}\n{}", ""), "siemens", zeros)[0]
        assert corrected(text.format(change, ""), "siemens", zeros)[0] == plain.replace(
            "G91", f"{change}\nG91"
        )
    corrected(text.format(change, "G0 Z40\n"), "siemens", zeros)


def test_a_word_put_in_does_not_travel_the_change_of_the_zero():
    """X20 in G91 needs a word of Z, whose zero G54 has moved by 20 mm: written as a distance, it
    would travel them."""
    zeros = {"G54": {"X": 0.0, "Y": 0.0, "Z": -180.0}}
    text = "G90 G500 G0 X10 Y10 Z50\nG54\nX11 Y11\nG91\nG1 X200 F100\n"
    out = corrected(text, "siemens", zeros)[0]
    assert "Z=AC(29.9" in out or "Z=AC(30.0" in out


EDGES = {
    "T1D1": {"Z": 30.0, "R": 4.0},
    "T1D2": {"Z": 20.0, "R": 1.0},
    "T2D1": {"Z": 150.0, "R": 5.0},
    "T2D2": {"Z": 90.0, "R": 2.0},
}
TOOLS = "G0 X0 Y0 Z9.\n{}\nG0 X10. Y10. Z10.\nG1 X20. Z5. F100\n"


def driven(dialect: str, text: str) -> tuple[float, float]:
    """Length and radius in force behind a text, read in one piece and line by line."""
    setup = Setup(("X", "Y", "Z"), offsets={"G54": {}, "G500": {}, **EDGES})
    interpreter = Interpreter(loaded := dialects.load(dialect), setup)
    whole = f"G90\n{text}\nG41 X1 Y1\n".encode()
    found = []
    for parts in ([whole], whole.splitlines(keepends=True)):
        state = interpreter.initial()
        for part in parts:
            motions, state, _ = interpreter.run(lex(part, loaded.grammar), state)
        found.append((float(state.frame.length[2]) / TICKS_PER_MM, abs(state.beside.radius)))
    assert found[0] == found[1]
    return found[0]


@pytest.mark.parametrize("dialect", ["siemens", "fagor"])
@pytest.mark.parametrize(
    ("text", "edge"),
    [
        # no M6 in the program: T brings the tool, with its first edge (MD22550 = 0, a turret)
        ("T1 D1", "T1D1"),
        ("T1 D1\nG1 X2 F9\nT2 D1", "T2D1"),
        ("T1 D2\nG1 X2 F9\nT2", "T2D1"),
        ("T1 D2\nT2 D2", "T2D2"),
        ("T1\nD2", "T1D2"),
        ("T2", "T2D1"),
        ("T1\nT2\nD2\nT1\nD2", "T1D2"),
        # M6 brings it
        ("T1 M6\nD1\nT2 M6\nD1", "T2D1"),
        ("T1 M6\nD1\nT2 M6 D1", "T2D1"),
        ("T1 M6\nD1\nT2 D1 M6", "T2D1"),
        ("T1 M6\nD2\nT2 M6", "T2D1"),
        ("T2\nM6\nD2", "T2D2"),
        ("T2\nM6", "T2D1"),
        ("T2 D2\nM6", "T2D2"),
        # once it has, T alone makes the next tool ready (MD22550 = 1; Fagor 8055: NXTOOL, NXTOD)
        ("T1 M6\nT2\nD1", "T1D1"),
        ("T1 M6\nD2\nT2", "T1D2"),
        ("T1 M6\nD2\nT2\nX1\nM6", "T2D1"),
        ("T1 M6\nT2\nD1\nM6\nD2", "T2D2"),
        ("T1 M6\nD1\nT2\nM6\nT1\nD2", "T2D2"),
        ("T1 M6\nD1\nT2\nM6 D2", "T2D2"),
        ("T1 M6 D2\nM6", "T1D2"),
    ],
)
def test_d_is_an_edge_of_the_tool_that_is_in_use(text, edge, dialect):
    """Siemens W1 (6FC5397-0BP10-2BA0), "Selection of the cutting edge when changing tool" and 2.2.5
    "Programming M6"; Fagor 8055, 13.2.2 "Variables associated with tools"."""
    place = EDGES[edge]
    assert driven(dialect, text) == pytest.approx((place["Z"], place["R"]))


def test_d_is_an_edge_of_the_tool_that_is_stated_at_the_start():
    setup = Setup(("X", "Y", "Z"), offsets=EDGES, tool=2)
    tracker = Tracker(Interpreter(dialects.load("siemens"), setup))
    tracker.take(b"D1")
    assert tracker.state.frame.length[2] == 150 * TICKS_PER_MM


@pytest.mark.parametrize("words", ["T2 M6\nD1", "T2 M6 D1", "T2 D1 M6", "T2 D1\nM6", "T2\nM6"])
def test_the_length_of_a_new_tool_is_its_own(words):
    """By hand: Z of the slides is 120 mm higher with T2D1, wherever D stands."""
    head = "G90 G500\nT1 M6\nD1\n"
    texts = [corrected(head + TOOLS.format(w), "siemens", EDGES)[0] for w in (words, "T2 M6\nD1")]
    assert texts[0].split("\n")[-3:] == texts[1].split("\n")[-3:]
