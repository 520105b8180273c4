"""G41 and G42 with tool diameters in LinuxCNC's table: what it accepts it accepts corrected, and
the centre goes right.

The judge is LinuxCNC's interpreter (oracle.py): it shifts the contours by the tools of its own
table. What the corrected program makes of the centre is carried through the machine's deviation and
compared with the nominal centre's path.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import GcompError, ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.motions import ENTRY, FREE, RAPID
from postproc.nc import dialects
from postproc.nc.beside_refusals import block_of, follower
from postproc.nc.lexer import lex
from postproc.nc.shifted import Gouge
from postproc.verify import Verifier
from tests.linuxcnc import cutter_judge as judge
from tests.linuxcnc import cutter_programs, oracle

AXES = "XYZABC"
TOLERANCE, ROUNDING = 1.0, 0.5  # um, of example-mill's default and of half its least increment
# um: the largest of example-mill's tables; it is spread over a block, in two axes at worst
REVERSAL = 6.0
# Where the map is steep at a corner (0.3 um per mm at a node), the centre swings around it by 6 or
# 10 mm; and Z steps of 120 mm inside, along which X and Y are held. Both are told, with their
# bounds.
CORNERS = {
    "rectangle_outside": 1.0,
    "rectangle_outside_large_tool": 1.5,
    "pocket_large": 0.5,
    "star_outside": 1.0,
    "z_steps": 1.0,
    "dynamic_mm": 1.5,
    "z_steps_far_down": 13.0,
}
ACCEPTED = {**cutter_programs.stored(), **cutter_programs.made()}
REFUSED = cutter_programs.refused()
CASES = [(way, stated) for way in ("one way", "two ways") for stated in (True, False)]


def mean(table):
    """The same in both directions."""
    both = (table.forward + table.reverse) / 2
    return replace(table, forward=both, reverse=both)


def machines():
    mill = places.load("example-mill").carrying(("A", "B", "C"))
    axes = {
        x: replace(axis, table=axis.table and mean(axis.table)) for x, axis in mill.axes.items()
    }
    return {"two ways": mill, "one way": replace(mill, axes=axes)}


def offsets(tools, stated):
    """LinuxCNC's tool table as gcomp's readers give it, with or without radii."""
    found = {"G54": {"X": 0.0, "Y": 0.0, "Z": -250.0}}
    for number, words in tools.items():
        found[f"T{number}"] = {axis: words.get(axis, 0.0) for axis in AXES}
        if stated and "D" in words:
            found[f"T{number}"] |= {"R": words["D"] / 2, "Q": words.get("Q", 0)}
    return found


def corrected(text, tools, machine, stated=True, pieces=1):
    """The program behind gcomp, its verifier and its filter."""
    setup = setup_of(machine, offsets=offsets(tools, stated), start=dict.fromkeys(AXES, 0.0))
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup)
    filter_.modal = replace(filter_.modal, tool_number=0, next_tool=0)
    verifier = Verifier(filter_)
    filter_.seen = []
    filter_.watchers.append(
        lambda words, motions, pieces, output, line: filter_.seen.append((motions, pieces))
    )
    data = text.encode()
    cuts = np.linspace(0, len(data), pieces + 1).astype(int)
    out = (
        b"".join(filter_.feed(data[a:b]) for a, b in zip(cuts[:-1], cuts[1:], strict=True))
        + filter_.finish()
    )
    return out.decode(), verifier, filter_


def asked(programs):
    """LinuxCNC's motions of (text, tools); skips where it is not there."""
    if reason := oracle.available():
        pytest.skip(reason)
    keywords = [dict(tools=tools, parameters=cutter_programs.PARAMETERS) for _, tools in programs]
    return oracle.motions_of_many(
        [(text, kw) for (text, _), kw in zip(programs, keywords, strict=True)]
    )


@pytest.fixture(scope="module")
def nominal():
    return dict(zip(ACCEPTED, asked(list(ACCEPTED.values())), strict=True))


@pytest.fixture(scope="module")
def runs(nominal):
    """Machine, whether radii are stated -> name -> (text, verifier, filter, LinuxCNC's motions of
    it)."""
    found = {}
    for way, stated in CASES:
        machine = machines()[way]
        outs = {
            name: corrected(text, tools, machine, stated)
            for name, (text, tools) in ACCEPTED.items()
        }
        made = asked([(outs[name][0], ACCEPTED[name][1]) for name in outs])
        found[way, stated] = {
            name: (*outs[name], motions) for name, motions in zip(outs, made, strict=True)
        }
    return found


@pytest.fixture(scope="module")
def missed(nominal, runs):
    """Machine and name -> kind of block -> um, where the radii are stated."""
    result = {}
    for way, machine in machines().items():
        for name, (_, _, _, made) in runs[way, True].items():
            kinds, worst = judge.kinds(ACCEPTED[name][0]), {}
            for line, distance in judge.missed(nominal[name], made, machine).items():
                worst[kinds[line]] = max(worst.get(kinds[line], 0.0), distance * 1000)
            result[way, name] = worst
    return result


def test_there_are_enough_programs(nominal):
    assert len(ACCEPTED) >= 40
    assert len(REFUSED) >= 10
    assert not [name for name, motions in nominal.items() if isinstance(motions, Exception)]


@pytest.mark.parametrize(
    "case", CASES, ids=lambda c: f"{c[0]}, radius {'stated' if c[1] else 'not stated'}"
)
def test_linuxcnc_accepts_what_it_accepted(runs, case):
    refused = {
        name: str(run[3]) for name, run in runs[case].items() if isinstance(run[3], Exception)
    }
    assert not refused


@pytest.mark.parametrize("name", ACCEPTED)
def test_the_centre_keeps_the_tolerance(missed, name):
    worst = missed["one way", name]
    assert worst.get("inside", 0.0) <= TOLERANCE + ROUNDING + CORNERS.get(name, 0.0)
    assert max(worst.get("entry", 0.0), worst.get("exit", 0.0)) <= TOLERANCE + ROUNDING


@pytest.mark.parametrize("name", ACCEPTED)
def test_two_way_tables_cost_their_reversal_and_no_more(missed, name):
    allowed = TOLERANCE + ROUNDING + np.sqrt(2) * REVERSAL + CORNERS.get(name, 0.0)
    assert missed["two ways", name].get("inside", 0.0) <= allowed


@pytest.mark.parametrize("name", ACCEPTED)
def test_verify_says_what_linuxcnc_says(missed, runs, name):
    """Its own follower of the centre against LinuxCNC's motions: the same distance, within its
    coarser samples."""
    _, verifier, _, _ = runs["one way", True][name]
    inside = [um for kind, um in missed["one way", name].items() if kind != "free"]
    if verifier.centre.uncorrected.deviation:
        assert verifier.centre.corrected.deviation * 1000 == pytest.approx(max(inside), abs=0.35)
    assert verifier.passed


@pytest.mark.parametrize("name", ACCEPTED)
@pytest.mark.parametrize("case", CASES, ids=str)
def test_blocks_that_rest_in_the_plane_stay_at_rest(runs, name, case):
    """One block, without a move in the plane: no word of it is put in. The ways in and out stay one
    block too."""
    for motions, pieces in runs[case][name][2].seen:
        for i in np.flatnonzero(motions.cutter != FREE):
            mine = pieces.motion == i
            plane = motions.plane[:, i]
            rests = (motions.start[plane, i] == motions.target[plane, i]).all() and not (
                motions.arcs.motion == i
            ).any()
            if rests or motions.cutter[i] == ENTRY:
                assert mine.sum() == 1
            if rests:
                assert (pieces.start[plane][:, mine] == pieces.end[plane][:, mine]).all()
            assert not pieces.take_up[mine].any()


@pytest.mark.parametrize(
    "name", ["z_steps_far_down", "pocket_tangent", "helix_inside", "lathe_nose", "cutter_inch"]
)
def test_any_cut_of_the_input_gives_the_same_bytes(name):
    text, tools = ACCEPTED[name]
    machine = machines()["two ways"]
    whole = corrected(text, tools, machine)[0]
    for pieces in (2, 3, 7, len(text)):
        assert corrected(text, tools, machine, pieces=pieces)[0] == whole


@pytest.mark.parametrize("side", ["G41", "G42"])
def test_the_map_is_read_at_the_driven_point_of_a_large_nose(side):
    """X errs by 1 um a mm, and the driven point of a nose of 8 mm lies 8 mm in X and Z from its
    centre (orientation 2): read on the other side of the centre, X would be 16 um off."""
    mill = machines()["one way"]
    table = mill.axes["X"].table
    steep = np.zeros_like(table.forward)
    steep[0] = 1e-3 * table.nodes
    axis = replace(mill.axes["X"], table=replace(table, forward=steep, reverse=steep))
    machine = replace(mill, axes={**mill.axes, "X": axis})
    text = f"G21 G90 G18 G54\nG0 X60 Z5\n{side} D6 G1 X20 Z2 F200\nZ-60\nX60\nG40 X80 Z5\nM2\n"
    _, verifier, _ = corrected(text, {6: {"D": 16.0, "Q": 2}}, machine)
    assert verifier.passed
    assert verifier.centre.corrected.deviation < 0.010, "16 um more with the nose on the other side"


@pytest.mark.parametrize("name", REFUSED)
def test_what_linuxcnc_refuses_is_refused_or_left(name):
    """A motion behind the faulty block, that a correction would depend on, is refused; without one
    nothing is changed."""
    text, tools = REFUSED[name]
    body = text.replace("\nM2", "\nG0 X1.5 Y2.5\nM2")
    with pytest.raises(ProgramError):
        corrected(body, tools, machines()["one way"])
    assert corrected(body, tools, places.load("perfect").carrying(("A", "B", "C")))[0] == body


@pytest.mark.parametrize("name", {**ACCEPTED, **REFUSED})
def test_the_follower_makes_linuxcncs_ways(name):
    """Every end of a way of the centre is one of LinuxCNC's ends, and it gouges where LinuxCNC says
    so."""
    text, tools = {**ACCEPTED, **REFUSED}[name]
    [theirs] = asked([(text, tools)])
    machine = places.load("perfect").carrying(("A", "B", "C"))
    setup = setup_of(machine, offsets=offsets(tools, True), start=dict.fromkeys(AXES, 0.0))
    filter_ = Filter(machine, dialects.load("linuxcnc"), setup)
    state = replace(filter_.modal, tool_number=0, next_tool=0)
    motions, _, _ = filter_.interpreter.run(
        lex(text.encode(), filter_.dialect.grammar, False), state
    )
    try:
        ways = followed(motions)
    except Gouge as gouge:
        assert str(gouge) == theirs.message
        return
    if isinstance(theirs, Exception):
        assert "goug" not in theirs.message and "entry" not in theirs.message
        return
    ends = np.array([motion.end[:3] for motion in theirs])
    for way in ways:
        assert np.abs(ends - way.end[:3]).max(axis=1).min() < 1e-9


def followed(motions):
    shifted, ways = None, []
    for i in np.flatnonzero(motions.cutter != FREE).tolist():
        block = block_of(motions, i, i)
        if motions.cutter[i] == ENTRY and motions.radius[i]:
            shifted = follower(motions, i)
            if shifted is not None:
                shifted.enter(motions.start[:, i] / 1e10, block)
        elif shifted is not None:
            shifted.leave(block) if motions.cutter[i] == ENTRY else shifted.follow(block)
        if shifted is not None:
            ways, shifted.done = ways + shifted.done, []
    return ways


def test_a_step_down_inside_moves_nothing_sideways():
    """The example of the fault: Z alone inside G41 got X and Y words of 1 um, and the control swung
    by the radius."""
    text = "G0 Z5 X-20 Y-10\nG1 Z-1 F300\nG41 D4 G1 X0 Y-10 F500\nY50\nZ-60\nY80\nG40 X-40\nM2\n"
    machine = machines()["one way"]
    out, _, filter_ = corrected(text, cutter_programs.TOOLS, machine)
    line = next(
        line for line in out.split("\n") if line.startswith("Z-60") or line.startswith("Z-59")
    )
    assert set(re.findall("[XYZ]", line)) == {"Z"}
    motions, _, _ = filter_.interpreter.run(
        lex(out.encode(), filter_.dialect.grammar, False), filter_.interpreter.initial()
    )
    assert not ((motions.code == RAPID) & (motions.cutter != FREE)).any()


def test_a_radius_that_is_stated_is_read_at_the_centre():
    """A map of EXX alone, 1 um per mm: 5 mm beside the contour the correction along X differs by 5
    um."""
    machine = machines()["one way"]
    bare = {x: replace(axis, table=None) for x, axis in machine.axes.items()}
    table = machine.axes["X"].table
    rise = np.zeros((6, len(table.nodes)))
    rise[0] = 1e-3 * table.nodes
    bare["X"] = replace(machine.axes["X"], table=replace(table, forward=rise, reverse=rise))
    machine = replace(machine, axes=bare, square={})
    text = "G0 X-50 Y-20 Z0\nG42 D4 G1 X50 Y-20 F500\nY60\nG40 X90\nM2\n"
    # 55 mm: the centre's place
    assert "X49.945" in corrected(text, cutter_programs.TOOLS, machine)[0]
    # 50 mm: the contour's
    assert "X49.950" in corrected(text, cutter_programs.TOOLS, machine, stated=False)[0]


@pytest.mark.parametrize(
    "dialect, text, radius, nose",
    [
        ("linuxcnc", "G41 D4", 5.0, (0.0, 0.0)),
        ("linuxcnc", "G42 D4", -5.0, (0.0, 0.0)),
        ("linuxcnc", "G42.1 D3", -1.5, (0.0, 0.0)),
        ("linuxcnc", "G18 G42.1 D0.8 L2", -0.4, (-0.4, -0.4)),
        ("linuxcnc", "G18 G41 D6", 0.4, (-0.4, -0.4)),
        ("fanuc-mill", "G41 D7", 3.0, (0.0, 0.0)),
        ("fanuc-mill", "G42 D8", np.nan, (0.0, 0.0)),
    ],
)
def test_which_radius_is_in_force(dialect, text, radius, nose):
    machine = places.load("example-mill")
    known = {**offsets(cutter_programs.TOOLS, True), "D7": {"R": 3.0}}
    filter_ = Filter(
        machine,
        dialects.load(dialect),
        setup_of(machine, offsets=known, start=dict.fromkeys("XYZ", 0.0)),
    )
    program = f"{text}\nG1 X20 Z-20 Y1 F100\n"
    words = lex(program.encode(), filter_.dialect.grammar, False)
    motions, _, _ = filter_.interpreter.run(words, filter_.modal)
    assert motions.cutter[-1] == ENTRY
    assert motions.radius[-1] == pytest.approx(radius, nan_ok=True)
    assert motions.nose[:, -1] == pytest.approx(nose)


def test_a_contour_that_the_control_would_refuse_is_no_error_of_gcomp():
    text, tools = REFUSED["cutter_gouge"]
    with pytest.raises(GcompError) as error:
        corrected(text, tools, machines()["one way"])
    assert "goug" in error.value.message
    assert "error of gcomp" not in error.value.message


def test_a_sharp_corner_is_cut_so_that_it_can_be_followed_or_refused():
    """A corner of 20 degrees between two lines: the cut six millimetres before it lies behind where
    the centre turns."""
    text = """G0 X100 Y-70
G1 Z-2 F300
G41 D2 G1 X114.9279 Y-52.9630 F500
X127.5065 Y-55.7587
X168.8124 Y-64.9394
X143.3806 Y-48.4815
G40 X118
M2
"""
    assert not isinstance(asked([(text, cutter_programs.TOOLS)])[0], Exception)
    try:
        out = corrected(text, cutter_programs.TOOLS, machines()["one way"])[0]
    except ProgramError as error:
        assert (
            "the corrected contour can not be followed" in error.message and error.place.line == 6
        )
    else:
        assert not isinstance(asked([(out, cutter_programs.TOOLS)])[0], Exception)


def test_a_line_that_turns_right_back_behind_an_arc_is_not_cut_where_it_would_run_backwards():
    """The centre turns ten millimetres from such a corner; a piece of two would have led it 10 mm
    astray."""
    text = """G0 X31 Y58
G1 Z-2 F300
G41 D2 G1 X53.651 Y105.572 F500
X53.832 Y105.960
G2 X64.610 Y116.013 I17.859 J-8.343
G1 X40.175 Y105.929
X30.707 Y99.600
G40 X0 Y99
M2
"""
    machine = machines()["one way"]
    [nominal] = asked([(text, cutter_programs.TOOLS)])
    out, verifier, _ = corrected(text, cutter_programs.TOOLS, machine)
    [made] = asked([(out, cutter_programs.TOOLS)])
    # um of the corner, 80 times as far at its end
    assert max(judge.missed(nominal, made, machine).values()) < 0.15
    assert verifier.passed


def test_verify_fails_where_the_centre_gets_worse():
    text, tools = ACCEPTED["rectangle_outside"]
    _, verifier, _ = corrected(text, tools, machines()["one way"])
    assert verifier.passed
    verifier.centre.corrected.deviation = 2 * verifier.centre.uncorrected.deviation
    assert not verifier.passed


@pytest.mark.parametrize("way", ["one way", "two ways"])
def test_where_the_tool_is_not_known_no_arc_becomes_narrower(way):
    """It may fit to the last digit. Fitted to the map, arcs of 10.5 and 30 mm would be 3 um and 6
    um less."""
    text, tools = ACCEPTED["pocket_large"]
    out, _, _ = corrected(text, tools, machines()[way], stated=False)
    radii = [
        np.hypot(*(float(n) if n else 0.0 for n in words))
        for words in (
            [(re.findall(rf"{letter}(-?[\d.]+)", line) or [""])[0] for letter in "IJ"]
            for line in out.split("\n")
            if re.match(r"G[23]\b", line)
        )
    ]
    assert len(radii) == 6
    assert np.all(np.array(radii) > np.array([30, 10.5, 10.5, 10.5, 10.5, 30]) - 0.0005)


def test_arcs_stay_arcs(runs):
    """Of a pocket: no chord in place of an arc, and no more arcs than it had."""
    for name in ("pocket_tangent", "pocket_corner_as_the_tool", "pocket_small_tool"):
        _, _, _, made = runs["one way", True][name]
        text, tools = ACCEPTED[name]
        arcs = [line for line in text.split("\n") if re.match(r"G[23]\b", line)]
        out = [
            line
            for line in runs["one way", True][name][0].split("\n")
            if re.match(r"G[23]\b", line)
        ]
        assert len(out) == len(arcs)
