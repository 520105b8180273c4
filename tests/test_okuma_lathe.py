"""Okuma lathes: their own words, shapes (LAP) and arcs, by the pages of manual 5238-E."""

from __future__ import annotations

import math
import random

import pytest

from postproc.errors import BlockFault, ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Line, Program
from postproc.nc.expand.resolve import Resolver
from postproc.nc.expand.tracker import Tracker
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.nc.state import Setup
from postproc.units import TICKS_PER_MM

SETUP = Setup(
    axes=("X", "Z"),
    least_increment=dict.fromkeys("XZ", 1e-4),
    start={"X": 0.0, "Z": 0.0},
    diameter=("X",),
    offsets={"T0101": {}, "T0202": {"X": 7.0, "Z": 50.0}},
)
SHAPE = "NAT01 G81|G00 X20 Z2|G01 Z-20 F0.1|X40 Z-30|Z-45|X60|G80|"


def motions(text: str, name: str = "okuma-lathe"):
    """What a program does, in place."""
    dialect = dialects.load(name)
    interpreter = Interpreter(dialect, SETUP)
    words = lex(text.replace("|", "\n").encode() + b"\n", dialect.grammar, False)
    assert words.fault is None, words.fault
    found, _, _ = interpreter.run(words, interpreter.initial())
    return found


def follow(text: str):
    """Ends of the motions (mm, radius), and why they can not be followed."""
    found = motions(text)
    return (found.target / TICKS_PER_MM).T.tolist(), [found.reasons[r][0] for r in found.reason]


def written(text: str) -> str:
    program = text.replace("|", "\n") + "\n"
    tracker = Tracker(Interpreter(dialects.load("okuma-lathe"), SETUP))
    resolver = Resolver(Program("part", program.encode()), tracker)
    resolver.texts[""] = lines = program.encode().split(b"\n")
    found = [x for n, one in enumerate(lines, 1) for x in resolver.take(Line(one, n))]
    return "\n".join(line.text.decode() for line in found)


def ends(text: str) -> list[list[float]]:
    """Ends of the motions of what a program is written out as: (x radius, z)."""
    found, reasons = follow(written(text).replace("\n", "|"))
    assert not any(reasons), reasons
    return found


def test_six_digits_of_t_are_nose_tool_and_offset():
    """P-76: T010101; the offset is the last two digits of the tool's four."""
    six, _ = follow("T030202|G0 X10 Z1")
    four, _ = follow("T0202|G0 X10 Z1")
    assert six == four == [pytest.approx([12.0, 51.0])]


def test_the_head_names_of_blocks_and_live_tools_are_no_words():
    found, reasons = follow("$SHAFT-A.MIN%|O12AB|NAT1 G0 X10 Z1|SB=2000 M13|NEND M2")
    assert found == [pytest.approx([5.0, 1.0])] and not any(reasons)


def test_home_leads_to_where_nobody_knows():
    _, reasons = follow("G0 X10 Z1|G20 HP=1|G1 X5 F.1")
    assert [bool(r) for r in reasons] != [False, False, False]


@pytest.mark.parametrize(
    "text",
    [
        "G1 X5 F.1|$ Z9",
        "CALL O1000",
        "X=V1+2",
        "G50 X100 Z100",
        "G14|G1 X5 F.1",
        "G137|G1 X5 F.1",
        "G1 Z-5 F.1|G3 X5 Z-6 L2",
    ],
)
def test_what_is_not_followed_in_place_is_refused(text):
    _, reasons = follow("G0 X10 Z1|" + text + "|G1 X9")
    assert any(reasons)


def test_an_arc_by_its_radius_gets_its_centre():
    """From X20 Z0 to X30 Z-5 about X20 Z-5, counter-clockwise in ZX: I is a radius."""
    lines = written("G0 X20 Z0|G3 X30 Z-5 L5 F0.1").split("\n")
    assert lines[1] == "G3 X30 Z-5 K-5. I0. F0.1"
    assert ends("G0 X20 Z0|G1 F.1|G2 X30 Z-5 L5")[-1] == pytest.approx([15.0, -5.0])


@pytest.mark.parametrize("seed", range(40))
def test_a_random_arc_by_its_radius_is_the_one_by_r_of_fanuc(seed):
    rng = random.Random(seed)
    x, z = rng.uniform(-20, 20), rng.uniform(-20, 20)
    chord = math.hypot(x, z)
    radius, code = chord / 2 * rng.uniform(1.01, 4), rng.choice((2, 3))
    text = f"G0 X0 Z0|G{code} X{2 * x:.4f} Z{z:.4f} L{radius:.4f} F.1"
    ours = motions(written(text).replace("\n", "|")).arcs
    by_r = motions(text.replace("L", "R"), "fanuc-lathe").arcs
    assert ours.centre[:, 0] == pytest.approx(by_r.centre[:, 0], abs=2e-4)


def test_a_roughing_by_hand():
    """D4 (diameter), U0.4, W0.1 from X64 Z5: cuts at X60, 56 ... 24; the shape is moved by (0.2,
    0.1); the cut at X38 (radius 19) meets the taper X20 to X40, Z-20 to Z-30."""
    found = ends("G0 X64 Z5|" + SHAPE + "G85 NAT01 D4 F0.3 U0.4 W0.1")
    cuts = [(x, z) for (x, z), (before, _) in zip(found[1:], found, strict=False) if x == before]
    assert [x for x, z in cuts if z < 0][:10] == pytest.approx(
        [30, 28, 26, 24, 22, 20, 18, 16, 14, 12]
    )
    taper = next(z for x, z in cuts if x == 18 and z < 0)
    assert taper == pytest.approx(-20 + 0.1 - (18 - 10 - 0.2), abs=1e-4)
    assert found[-7:] == [
        pytest.approx(p)
        for p in (
            [10.2, 2.1], [10.2, -19.9], [20.2, -29.9], [20.2, -44.9], [30.2, -44.9],
            [30.2, 5.0], [32.0, 5.0],
        )
    ]  # fmt: skip


def test_other_depths_hold_beyond_their_place():
    """XA=40: the cuts at 60, 56, 52, 48, 44, 40 go by 4, those behind by DA=2."""
    found = ends("G0 X64 Z5|" + SHAPE + "G85 NAT01 D4 F0.3|$ G84 XA=40 DA=2 FA=0.2")
    deep = [
        2 * x
        for (x, z), (before, _) in zip(found[1:], found, strict=False)
        if z < 0 and x == before
    ]
    assert deep[:15] == pytest.approx([60, 56, 52, 48, 44, 40, 38, 36, 34, 32, 30, 28, 26, 24, 22])
    assert "F0.2" in written("G0 X64 Z5|" + SHAPE + "G85 NAT01 D4 F0.3|$ G84 XA=40 DA=2 FA=0.2")


def test_copying_is_the_formula_of_the_manual():
    """P-195, Xs 64, Zs 5, Xa 20, Za 2, D 10, U 2, W 1: XOFF = (Xs - Xa - U) - N D, and ZOFF the
    same share of Zs - Za - W; cuts N = 1 to 4, then one at U and W."""
    found = ends("G0 X64 Z5|" + SHAPE + "G86 NAT01 D10 U2 W1")
    firsts = [
        (2 * x, z)
        for (x, z), after in zip(found, found[1:], strict=False)
        if after[0] == x and after[1] < z and z > 0
    ]
    expected = [(20 + 2 + (42 - 10 * n), 2 + 1 + 2 * (1 - 10 * n / 42)) for n in (1, 2, 3, 4)] + [
        (22, 3)
    ]
    assert firsts == [pytest.approx(p, abs=2e-4) for p in expected]
    assert found[-1] == pytest.approx([32.0, 5.0])


def test_finishing_goes_along_the_shape_with_its_own_words():
    lines = written("G0 X64 Z5|" + SHAPE + "G87 NAT01").split("\n")
    assert lines[1:] == [
        "G0 X20. Z2.", "F0.1", "G1 Z-20.", "X40. Z-30.", "Z-45.", "X60.", "G0 Z5.", "X64.", "",
    ]  # fmt: skip


def test_a_bore_is_roughed_outwards():
    """U and W lie towards the starting point: X10 is inside of the shape at X30."""
    shape = "NB G81|G0 X30 Z2|G1 Z-10 F.1|X12|G80|"
    found = ends("G0 X10 Z5|" + shape + "G85 NB D8 U0.4 W0.1")
    assert [14.8, 2.1] in [pytest.approx(p) for p in found]
    assert max(x for x, _ in found) == pytest.approx(14.8)


def test_rapids_that_draw_the_tool_out_of_a_bore_are_no_part_of_what_is_roughed():
    """As a shop's own programs end: G1 X18. | G0 Z2. One cut at X22., one along the shape."""
    head, shape = "G0 X20 Z5|G85 NB D2 U1 F0.2|", "NB G81|G0 X24 Z3|G1 Z-30 F0.1|"
    plain = ends(f"{head}{shape}G80|")
    at = ends(f"{head}{shape}G0 X18|Z2|G80|")
    assert [12 - 0.5, 3.0] in plain and [9 - 0.5, 2.0] in at
    cut = at.index([12 - 0.5, 3.0])
    assert at[: cut + 2] == plain[: cut + 2]  # roughed as without them
    assert at[cut + 2 :] == [[8.5, -30.0], [8.5, 2.0], [8.5, 5.0], [10.0, 5.0]]
    with pytest.raises(ProgramError, match="takes Z back"):
        ends(f"{head}{shape}G0 X25|Z2|G80|")  # deeper than the bore
    with pytest.raises(ProgramError, match="takes Z back"):
        ends(f"{head}{shape}G1 X18|Z2|G80|")  # that cuts


def test_corners_of_a_shape():
    """G75 L2 chamfers, G76 L3 rounds, at the end of their block."""
    shape = "NC G81|G0 X20 Z2|G75 G1 Z-10 L2 F.1|G76 X40 L3|Z-30|X60|G80|"
    found = ends("G0 X64 Z5|" + shape + "G87 NC")
    assert found[2:7] == [
        pytest.approx(p) for p in ([10, -8], [12, -10], [17, -10], [20, -13], [20, -30])
    ]


def test_no_way_back_behind_a_roughing_with_m85():
    found = ends("G0 X64 Z5|" + SHAPE + "G85 NAT01 D4 F0.3 M85")
    assert found[-1] == pytest.approx([30.0, -45.0])


def test_a_shape_is_stepped_over_and_lines_are_joined():
    text = written("G0 X34 Z8|" + SHAPE + "G71 X27.5 Z-30 B60 D0.7|$ H2.4 L2 F2 M23|G0 X60")
    assert text == "G0 X34 Z8\nG71 X27.5 Z-30 B60 D0.7 H2.4 L2 F2 M23\nG0 X60\n"


def test_threads_stay():
    """P-97: a pass of G33 goes there and back; P-114: so does G71."""
    found, reasons = follow("G0 X34 Z8|G33 X29.4 Z-30 F2|X28.9|G71 X27 Z-3 B60 D.7 H2 F2|G0 X40")
    assert not any(reasons) and found[-1] == pytest.approx([20.0, 8.0])


def test_a_call_within_compensation_is_refused():
    with pytest.raises(ProgramError, match="G85 with nose radius compensation on"):
        written("G0 X64 Z5|G42|" + SHAPE + "G85 NAT01 D4 F0.3")


def test_holes_of_a_live_tool_in_the_face_and_in_the_side():
    """P-139: on to the place, on by K (I, a diameter), in with feed, back to where it stood."""
    face = ends("G0 X60 Z5|G181 X40 Z-10 K3 F0.1|X20 E0.5|G180|G0 X100")
    hole = [[30, 5], [20, 5], [20, 2], [20, -10], [20, 5]]
    assert face == [*hole, [10, 5], [10, 2], [10, -10], [10, 5], [50, 5]]
    side = ends("G0 X60 Z5|G181 Z-10 X40 I4 F0.1|G180|G0 Z9")
    assert side == [[30, 5], [30, -10], [28, -10], [20, -10], [30, -10], [30, 9]]
    assert "G4 F0.5" in written("G0 X60 Z5|G181 X40 Z-10 K3 E0.5 F0.1|G180")


def test_a_face_is_pecked():
    """G74 X0 Z-12 D5 E0.5 from Z5: to 0, -5, -10, -12, back by 0.1 mm behind each peck but the last
    one, a dwell, and out."""
    found = ends("G0 X0 Z5|G74 X0 Z-12 D5 E0.5 F0.1|G0 X100")
    assert found[1:-1] == [
        [0, 0], [0, pytest.approx(0.1)], [0, -5], [0, pytest.approx(-4.9)], [0, -10],
        [0, pytest.approx(-9.9)], [0, -12], [0, 5],
    ]  # fmt: skip
    assert "G4 F0.5" in written("G0 X0 Z5|G74 X0 Z-12 D5 E0.5 F0.1")


def test_a_groove_is_cut_step_by_step():
    """G73 X30 Z-9 K2 D4 (diameters) from X40 Z-4: at Z-4, -6, -8, -9 down by 2 mm to X15, out to
    X20, and back to Z-4; L4: behind 4 (a diameter, one peck here) it goes out all the way."""
    found = ends("G0 X40 Z-4|G73 X30 Z-9 K2 D4 F0.1|G0 X60")
    cuts = [z for (x, z) in found if x == 15]
    assert cuts == [-4, -6, -8, -9]
    assert found[1:7] == [
        [18, -4], [pytest.approx(18.1), -4], [16, -4], [pytest.approx(16.1), -4], [15, -4],
        [20, -4],
    ]  # fmt: skip
    assert found[-2:] == [[20, -4], [30, -4]]
    out = ends("G0 X40 Z-4|G73 X30 Z-4 D4 L4 F0.1|G0 X60")
    assert out[1:4] == [[18, -4], [20, -4], [pytest.approx(18.1), -4]]


@pytest.mark.parametrize(
    "words",
    [
        "X30 Z-9 D4",
        "X40 Z-9 K2 D4",
        "X30 Z-9 I2 D4",
        "X30 Z-4 D4 T0202",
        "X30 Z-4 D.0001",
        "X30 Z-4 D4 T0909",
    ],
)
def test_grooves_that_are_refused(words):
    """No step, no depth, the other cycle's step, an offset of another place, too many pecks."""
    with pytest.raises(ProgramError):
        written(f"T0101|G0 X40 Z-4|G73 {words} F0.1")


def test_the_offset_at_the_end_may_be_one_of_the_same_place():
    text = "T0101|G0 X40 Z-4|G73 X30 Z-4 D4 F0.1"
    assert written(text + " T0101") == written(text)


def test_a_tap_by_the_live_tool_stays():
    """P-139: it goes back to where it stood, but C does not."""
    found, reasons = follow("G0 X50 Z5|G184 X50 Z-10 K3 F750|G180|G1 X40 F.1")
    assert not any(reasons) and found == [[25, 5], [20, 5]]


@pytest.mark.parametrize(
    "words",
    ["X40 Z-9 K1 Q4", "X40 Z-9 C0 K1 Q2.5", "X40 Z-9 K1 R2", "X40 Z-9 K1 I1", "X40 Z-9"],
)
def test_holes_that_are_refused(words):
    with pytest.raises(ProgramError):
        written(f"G0 X60 Z5|G181 {words} F0.1")


@pytest.mark.parametrize(
    "words", ["G81 X20 Z-1", "NLAP1 G81|G1 X20", "G80", "G85 X20 Z-1", "G84", "G86", "G87"]
)
def test_what_belongs_to_no_shape_is_refused(words):
    """Holes of another control's G81 are never stepped over in silence."""
    with pytest.raises(ProgramError):
        written(f"G0 X60 Z5|{words}|G1 X5 F0.1|G0 Z5")


def test_an_error_behind_two_offsets_names_its_own_line():
    """The tracker is asked by the cycles and by itself, and tells its lines either way."""
    with pytest.raises(ProgramError) as caught:
        written("(A)|(B)|T0101|G0 X20 Z2|T0202|G0 X60 Z5|G0 X40 B5|G181 X40 Z-9 K1 F120")
    assert caught.value.place.line == 7 and "B" in caught.value.message


def test_a_line_by_its_angle_makes_the_chamfer_of_a_bar():
    """A135: out at 45 degrees towards -Z; A315: in, towards +Z: 1.56 to 1.5 over Z 0.03."""
    assert ends("T0101|G0 X1.403 Z0|G1 X1.503 A135 F.01|Z-1.3")[1:] == [
        pytest.approx([0.7515, -0.05]),
        pytest.approx([0.7515, -1.3]),
    ]
    assert ends("T0101|G0 X1.56 Z-.03|G1 Z0 A315 F.01")[1] == pytest.approx([0.75, 0.0])


def test_an_angle_in_a_shape_is_no_radial_line():
    """It was passed over, and the line ended where it began in Z."""
    shape = "NAT01 G81|G00 X1.403 Z.03|G01 Z0|X1.503 A135|Z-1.3|X1.6|G80|"
    path = ends(shape + "T0101|G0 X1.6 Z.06|G87 NAT01")
    assert pytest.approx([0.7515, -0.05]) in path and pytest.approx([0.7515, 0.0]) not in path


@pytest.mark.parametrize("word", ["B30", "D2", "C5"])
def test_a_word_of_a_shape_that_nobody_reads_is_refused(word):
    with pytest.raises(ProgramError, match="no word of it"):
        written(SHAPE.replace("X40 Z-30", f"X40 Z-30 {word}") + "T0101|G0 X62 Z5|G87 NAT01")


def test_corners_of_plain_blocks():
    """G75 X60 L2: 2 mm before the corner, and 2 mm behind it; G76 the arc that touches both."""
    path = ends("T0101|G0 X20 Z0|G1 Z-20 F.1|G75 X60 L2|Z-50")
    assert path[2:] == [
        pytest.approx([28, -20]),
        pytest.approx([30, -22]),
        pytest.approx([30, -50]),
    ]
    path = ends("T0101|G0 X20 Z0|G1 Z-20 F.1|G76 X60 L2|Z-50")
    assert path[2:4] == [pytest.approx([28, -20]), pytest.approx([30, -22])]


def test_x_is_a_radius_while_the_y_axis_is_on():
    """G138: as the post of NC-PB/gEdit writes it, X52.5 where its Fanuc writes X105."""
    found, reasons = follow("G0 X20 Z1|G138|X52.5|G136|X52.5")
    assert not any(reasons) and [x for x, _ in found] == [10.0, 52.5, 26.25]


def test_what_draws_the_blank_moves_nothing():
    head = "CLEAR|DEF WORK|PS LC,[-400,0],[400,19]|END|DRAW|"
    assert follow(head + "G0 X10 Z1") == follow("G0 X10 Z1")


LIVE = Setup(
    axes=("X", "Z", "C", "Y"),
    least_increment=dict.fromkeys("XZCY", 1e-4),
    start=dict.fromkeys("XZCY", 0.0),
    diameter=("X",),
    offsets={"T0101": {}},
)


def test_holes_evenly_round_stand_at_the_angles_one_by_one(monkeypatch):
    """Q4 from C10 on are holes at 10, 100, 190 and 280 degrees; Y where it stands says nothing."""
    monkeypatch.setattr(f"{__name__}.SETUP", LIVE)
    each = "|".join(f"{'G181 X50 Z-12 K3 F120' * (not k)} C{10 + 90 * k}" for k in range(4))
    before = "T0101|G0 X50 Z5 Y0|"
    assert ends(f"{before}G181 X50 Y0 Z-12 C10 K3 F120 Q4") == ends(before + each)
    assert [round(place[2]) for place in ends(before + each)[1::4]] == [10, 100, 190, 280]


def test_an_arc_of_the_y_axis_has_its_centre_by_j_and_k(monkeypatch):
    monkeypatch.setattr(f"{__name__}.SETUP", LIVE)
    found, reasons = follow("G19|G0 X20 Y0 Z0|G3 Y10 Z10 J0 K10 F.1")
    assert not any(reasons) and found[-1] == [10.0, 10.0, 0.0, 10.0]
    monkeypatch.undo()
    with pytest.raises(BlockFault, match="J has no meaning"):
        follow("G18|G0 X20 Z0|G3 X30 Z-5 J0 K5 F.1")
