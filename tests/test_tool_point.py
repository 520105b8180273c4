"""Programs of the tool tip: G43.4, G234, TRAORI, M128 and switchable kinematics, on machines that
err in every component."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from postproc.cli import main
from postproc.compensate import Options, turning
from postproc.errors import ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine import places
from postproc.machine.seen import seen_in
from postproc.machine.tables import GridTable
from postproc.machine.tip import TipMachine, tool_directions
from postproc.motions import FEED, FREE
from postproc.nc import dialects
from postproc.spaces import Space
from postproc.verify import Verifier
from tests.reference import tool_point
from tests.reference.tool_point import CHAINS, Truth, random_program, random_truth

TOLERANCE = 0.001
LENGTH = 80.0
CALLS = {
    "fanuc-mill": ("G43.4", "G43.4 H1", "G49", {"H1": {"Z": LENGTH}}, ""),
    "haas": ("G234", "G234 H1", "G49", {"H1": {"Z": LENGTH}}, ""),
    "siemens": ("TRAORI", "T1 D1\nTRAORI", "TRAFOOF", {"D1": {"Z": LENGTH}}, ""),
    "linuxcnc": (
        "M428",
        "G43 H1\nM428",
        "M429",
        {"H1": {"Z": LENGTH}},
        '[tool_point]\non = "M428"\noff = ["M429"]',
    ),
}


def load(truth: Truth, folder, dialect: str = "fanuc-mill", more: str = ""):
    return places.load(str(truth.write(folder, dialect, more)))


def corrected(
    machine, dialect, text, offsets=None, tolerance=TOLERANCE, **options
) -> tuple[str, Verifier]:
    filter_ = a_filter(machine, dialect, offsets, tolerance=tolerance, **options)
    verifier = Verifier(filter_)
    return in_pieces(filter_, text, len(text)), verifier


def a_filter(machine, dialect, offsets=None, tolerance=TOLERANCE, **options) -> Filter:
    options = Options(tolerance=tolerance, **options)
    return Filter(machine, dialects.load(dialect), setup_of(machine, offsets or {}), options)


def in_pieces(filter_: Filter, text: str, cut: int) -> str:
    """The output where the text comes in pieces of `cut` bytes."""
    data = text.encode()
    parts = [data[i : i + cut] for i in range(0, len(data), cut)]
    return b"".join([*(filter_.feed(p) for p in parts), filter_.finish()]).decode()


@pytest.mark.parametrize(
    ("chain", "dialect"),
    [
        *((chain, "fanuc-mill") for chain in CHAINS),
        *((CHAINS[k + 1], dialect) for k, dialect in enumerate(CALLS) if k),
    ],
)
def test_the_tip_stays_on_its_path(chain, dialect, tmp_path):
    """Random machines and programs, judged by exact transforms of the whole chain and a control of
    their own: the tip is within tolerance, rounding, and the products of two errors, which nobody
    takes out."""
    on, call, off, offsets, more = CALLS[dialect]
    seed = CHAINS.index(chain) * 10 + list(CALLS).index(dialect)
    rng = np.random.default_rng(seed)
    truth = random_truth(rng, chain)
    machine = load(truth, tmp_path, dialect, more)
    text = random_program(rng, truth.rotary, call, off)
    output, verifier = corrected(machine, dialect, text, offsets)
    judged = tool_point.judge(truth, text, output, on, off, LENGTH)
    assert judged.tip_before > 0.005
    assert judged.tip < TOLERANCE + 0.0001 + machine.bounds.second_order
    assert verifier.passed
    assert verifier.uncorrected.deviation > 0.005


def test_many_random_machines(tmp_path):
    """The same in one dialect, more of them, in two tolerances."""
    for seed in range(100, 107):
        rng = np.random.default_rng(seed)
        truth = random_truth(rng, CHAINS[seed % len(CHAINS)], size=2.0)
        machine = load(truth, tmp_path / str(seed))
        text = random_program(rng, truth.rotary, "G43.4 H1", "G49", blocks=4)
        tolerance = (0.002, 0.005)[seed % 2]
        output, verifier = corrected(machine, "fanuc-mill", text, {"H1": {"Z": LENGTH}}, tolerance)
        judged = tool_point.judge(truth, text, output, "G43.4", "G49", LENGTH)
        assert judged.tip < tolerance + 0.0001 + machine.bounds.second_order, seed
        assert verifier.passed, seed


@pytest.mark.parametrize("chain", CHAINS)
def test_orientation_is_corrected_where_it_is_asked_for(chain, tmp_path):
    """The same with --orientation: the tip as before, and the tool within half as many degrees as
    the tolerance has millimetres, wherever the rotary axes can turn it any way (not nearer to a
    pole than 0.1 rad)."""
    rng = np.random.default_rng(40 + CHAINS.index(chain))
    truth = random_truth(rng, chain)
    machine = load(truth, tmp_path)
    text = random_program(rng, truth.rotary, "G43.4 H1", "G49")
    output, verifier = corrected(
        machine, "fanuc-mill", text, {"H1": {"Z": LENGTH}}, orientation=True
    )
    judged = tool_point.judge(truth, text, output, "G43.4", "G49", LENGTH, turned=True)
    assert judged.tip < TOLERANCE + 0.0001 + machine.bounds.second_order
    assert judged.lean < np.radians(TOLERANCE / 2)
    assert judged.lean < judged.lean_before / 3
    assert verifier.passed
    assert f"uncorrected {verifier.uncorrected.lean * 1e6:.0f}" in verifier.report()


def test_a_leaning_table_by_hand(tmp_path):
    """A of the table errs by 100 urad about X (EAA) everywhere: the part leans with it, and A is
    corrected by as much, 100 urad being 0.0057 degrees. The tip stands on A's line, so nothing else
    changes."""
    truth = plain("w-C-A-b-X-Y-Z-t")
    truth.table["A"][1][3] = 100e-6
    machine = load(truth, tmp_path)
    text = (
        "N10 G90 G54 G0 X0. Y0. Z0. A10. C0.\nN20 G43.4 H1\nN30 G0 X0. Y0. Z0. A30.\nN40 G49\nM30\n"
    )
    offsets = {"H1": {"Z": 0.0}}
    assert words(corrected(machine, "fanuc-mill", text, offsets)[0], 30) == "G0 X0. Y0. Z0. A30."
    output, verifier = corrected(machine, "fanuc-mill", text, offsets, orientation=True)
    assert words(output, 30) == "G0 X0. Y0. Z0. A29.9943"
    assert "the tool leans by" in verifier.report()


@pytest.mark.parametrize("chain", CHAINS[::3])
def test_lost_motion_is_taken_up_where_the_slides_turn(chain, tmp_path):
    """A path of short blocks on a machine with 20 um of play, each slide led through its play from
    the first block on by a judge of its own: the mean of both directions leaves the play, and the
    sides by the slides' own way take it out, at the call too, where the tool's length changes the
    corrections. The verifier says the same."""
    truth = random_truth(np.random.default_rng(1), chain, play=0.02)
    machine = load(truth, tmp_path)
    one, other = truth.rotary
    t = np.linspace(0, 2 * np.pi, 120)
    path = [
        f"G1 X{40 * np.cos(a):.3f} Y{40 * np.sin(a):.3f} Z{2 * a:.3f} "
        f"{one}{20 * np.sin(a / 1.7):.3f} {other}{30 * np.sin(a / 1.3):.3f}"
        for a in t
    ]
    lines = [
        "G90 G54",
        f"G0 X40. Y0. Z0. {one}0. {other}0.",
        "G43.4 H1",
        "G0 X40. Y0. Z0.",
        path[0] + " F500.",
        *path[1:],
        "G49",
        "M30",
    ]
    text = "\n".join(f"N{k} {line}" for k, line in enumerate(lines, 1)) + "\n"
    off = {}
    for reversal in ("mean", "step"):
        output, verifier = corrected(
            machine, "fanuc-mill", text, {"H1": {"Z": LENGTH}}, reversal=reversal
        )
        off[reversal] = tool_point.played(truth, text, output, "G43.4", "G49", LENGTH)
        filter_ = a_filter(machine, "fanuc-mill", {"H1": {"Z": LENGTH}}, reversal=reversal)
        assert in_pieces(filter_, text, 50) == output
    assert np.median(off["mean"]) > 0.005
    assert off["step"].max() < verifier.allowed
    assert verifier.passed
    assert verifier.corrected.slide < verifier.allowed
    assert len(output.splitlines()) < 1.3 * len(text.splitlines())


# -- by hand ---------------------------------------------------------------------------------------


def plain(chain: str, **errors) -> Truth:
    """A machine without errors but those named: EXX in mm, X0C in mm, tool at the gauge line."""
    axes = [x for x in chain.split("-") if x in "XYZABC"]
    table, zero = {}, np.zeros(3)
    for x in axes:
        nodes = np.linspace(-400.0, 400.0, 3)
        mean = np.zeros((6, 3))
        for k, c in enumerate("XYZ"):
            mean[k] = errors.get(f"E{c}{x}", 0.0)
        table[x] = nodes, mean, np.zeros_like(mean)
    shift = {x: np.array([errors.get(f"{d}0{x}", 0.0) for d in "XYZ"]) for x in axes}
    travel = {x: (-400.0, 400.0) for x in axes}
    return Truth(
        chain,
        zero.copy(),
        dict.fromkeys(axes, zero),
        table,
        dict.fromkeys(axes, zero),
        shift,
        travel,
    )


def words(output: str, number: int) -> str:
    """The block N.. of an output, without its number and spaces."""
    return next(line for line in output.splitlines() if line.startswith(f"N{number} ")).split(
        " ", 1
    )[1]


def test_a_table_beside_its_place_by_hand(tmp_path):
    """The line of C lies 10 um in X beside where the control believes it. At C0 nothing is wrong
    (there the part was set up). At C90 the tool stands in the part where it was turned by 90
    degrees about the wrong centre: s - R(90) s with s = (10, 0) um is (10, -10) um, so the words
    become X 100 - 0.010, Y 0 + 0.010."""
    machine = load(plain("w-C-b-X-Y-Z-t", X0C=0.010), tmp_path)
    text = (
        "N10 G90 G54 G0 X100. Y0. Z0. C0.\nN20 G43.4 H1\nN30 G0 X100. Y0. Z0. C0.\nN40 G0 C90.\nN50"
        " X50. Y0.\nN60 G49\nM30\n"
    )
    output, _ = corrected(machine, "fanuc-mill", text, {"H1": {"Z": 0.0}})
    assert words(output, 30) == "G0 X100. Y0. Z0. C0."
    assert words(output, 40) == "G0 C90. X99.9900 Y0.0100"
    assert words(output, 50) == "X49.9900 Y0.0100"


def test_the_frame_of_the_call_by_hand(tmp_path):
    """X is 10 um off wherever it stands. Fanuc's frame is that of the table at the call: with C at
    90 there, X is still the machine's X, and X becomes 99.990. A quarter turn later the machine's X
    lies along Y of the frame, and Y becomes -0.010. Siemens' frame is that of the table at zero: a
    quarter turn already lies between them."""
    machine = load(plain("w-C-b-X-Y-Z-t", EXX=0.010), tmp_path)
    text = (
        "N10 G90 G54 G0 X100. Y0. Z0. C90.\nN20 G43.4 H1\nN30 X100. Y0.\nN40 X100. Y0. C180.\nN50"
        " G49\nM30\n"
    )
    output, _ = corrected(machine, "fanuc-mill", text, {"H1": {"Z": 0.0}})
    assert (words(output, 30), words(output, 40)) == ("X99.9900 Y0.", "X100. Y-0.0100 C180.")
    text = text.replace("G43.4 H1", "TRAORI").replace("G49", "TRAFOOF")
    output, _ = corrected(machine, "siemens", text)
    assert (words(output, 30), words(output, 40)) == ("X100. Y-0.0100", "X100.0100 Y0. C180.")


def test_a_head_swings_the_errors_of_its_own_side_by_hand(tmp_path):
    """B of a head errs by 10 um in X in the frame that does not turn (EXB): the tip in the part is
    off by it, at every angle. The part does not turn, so X becomes 10 um less."""
    machine = load(plain("w-b-X-Y-Z-B-t", EXB=0.010), tmp_path)
    text = (
        "N10 G90 G54 G0 X0. Y0. Z0. B0.\nN20 G43.4 H1 Z100.\nN30 G0 X10. B30.\nN40 B-45.\nN50"
        " G49\nM30\n"
    )
    output, _ = corrected(machine, "fanuc-mill", text, {"H1": {"Z": 100.0}})
    assert words(output, 20) == "G43.4 H1 Z100."
    assert (words(output, 30), words(output, 40)) == ("G0 X9.9900 B30.", "B-45.")


def test_without_take_ups_the_play_that_stays_is_said_by_hand(tmp_path):
    """3 um to either side in the table of X, 4 um in Y's of X and Y: sqrt(3^2 + 4^2) um."""
    truth = plain("w-C-A-b-X-Y-Z-t")
    truth.table["X"][2][0] = -0.003
    machine = load(truth, tmp_path)
    nodes, forward = np.array([-400.0, 400.0]), np.zeros((6, 2, 2))
    reverse = forward.copy()
    reverse[1] = 0.008
    grid = GridTable("Y", "X", nodes, nodes, forward, reverse)
    axes = {**machine.axes, "Y": dataclasses.replace(machine.axes["Y"], grids=(grid,))}
    machine = dataclasses.replace(machine, axes=axes)
    filter_ = a_filter(machine, "fanuc-mill", {"H1": {"Z": LENGTH}}, reversal="off")
    in_pieces(filter_, "G90 G54\nG0 X40. Y0. Z0. A0. C0.\nG43.4 H1\nG1 X0. F500.\n", 1000)
    (said,) = (n.message for n in filter_.notices if n.message.startswith("lost motion of X Y is"))
    assert said.endswith("up to 5.0 um of it stay")


def test_explain_tells_tips_from_slides(tmp_path, capsys):
    """A tool of 80 mm under G43.4: the tip at Z0 is the slide at Z80, and each is called what it
    is."""
    load(plain("w-C-A-b-X-Y-Z-t", EXX=0.010), tmp_path / "m")
    program = tmp_path / "part.nc"
    program.write_text("G90 G54\nG0 X40. Y0. Z0. A0. C0.\nG43.4 H1\nG0 X40. Y0. Z0.\nG49\nM30\n")
    assert (
        main(["explain", str(program), "--machine", str(tmp_path / "m"), "--offset", "H1=Z80"]) == 0
    )
    said = capsys.readouterr().out
    assert "to X 40.0000 Y 0.0000 Z 0.0000 A 0.0000 C 0.0000 (slide position, mm)" in said
    assert (
        "Z 0.0000 A 0.0000 C 0.0000 (tool tip, mm); slides to X 40.0000 Y 0.0000 Z 80.0000 A"
        in said
    )
    assert said.count("without correction X would be off by +10.0 um") == 2


# -- laws ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dialect", CALLS)
def test_a_machine_without_errors_changes_no_byte(dialect, tmp_path):
    _, call, off, offsets, more = CALLS[dialect]
    machine = load(plain("w-C-A-b-X-Y-Z-t"), tmp_path, dialect, more)
    text = random_program(np.random.default_rng(5), ["C", "A"], call, off)
    assert corrected(machine, dialect, text, offsets)[0] == text


@pytest.mark.parametrize("dialect", CALLS)
def test_any_cut_of_the_input_gives_the_same_bytes(dialect, tmp_path):
    _, call, off, offsets, more = CALLS[dialect]
    rng = np.random.default_rng(7)
    truth = random_truth(rng, "w-C-b-X-Y-Z-B-t")
    machine = load(truth, tmp_path, dialect, more)
    text = random_program(rng, truth.rotary, call, off)
    text = text.replace(
        "M30",
        f"G0 X1. Y2. Z40. C0.\nG1 X5. B10. F300.\n{call}\nG1 X7. C10.\n{off}\nG1 X9. C0.\nM30",
    )
    whole = corrected(machine, dialect, text, offsets)[0]
    assert whole != text
    for cut in (1, 17, 60, 200):
        assert in_pieces(a_filter(machine, dialect, offsets), text, cut) == whole


def test_short_blocks_stay_whole(tmp_path):
    """A simultaneous path as CAM systems write it: no block is cut where its own chord is good
    enough."""
    rng = np.random.default_rng(11)
    truth = random_truth(rng, "w-C-A-b-X-Y-Z-t")
    machine = load(truth, tmp_path)
    t = np.linspace(0, 2 * np.pi, 400)
    path = [
        f"G1 X{40 * np.cos(a):.3f} Y{40 * np.sin(a):.3f} Z{5 * a:.3f} A{20 * np.sin(a):.3f}"
        f" C{30 * a:.3f}"
        for a in t
    ]
    numbered = [
        f"N{k} {line}"
        for k, line in enumerate(
            [
                "G21 G90 G54",
                "G0 X40 Y0 Z0 A0 C0",
                "G43.4 H1",
                "G0 X40 Y0 Z0",
                path[0] + " F500",
                *path[1:],
                "G49",
                "M30",
            ],
            1,
        )
    ]
    text = "\n".join(numbered) + "\n"
    output, verifier = corrected(machine, "fanuc-mill", text, {"H1": {"Z": LENGTH}})
    judged = tool_point.judge(truth, text, output, "G43.4", "G49", LENGTH)
    assert judged.tip < TOLERANCE + 0.0001 + machine.bounds.second_order
    assert verifier.passed
    assert len(output.splitlines()) < 1.3 * len(text.splitlines())


# -- what is refused, and what is asked for --------------------------------------------------------

FIVE = "G21 G90 G54 G17\nG0 X0. Y0. Z50. C0. A0.\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "G43.4 H1\nG28 Z0.\nG1 X1. F100\n",
            "a reference point while X Y Z are places of the tool tip",
        ),
        ("G43.4 H1\nG53 G0 Z0.\n", "G53 while X Y Z are places of the tool tip"),
        (
            "G43.4 H1\nG41 D1 G1 X10. F100\n",
            "cutter radius compensation while the tool point is on",
        ),
        ("G43.4 H1\nG99 G81 X10. Z-5. R2. F100\n", "a drilling cycle while the tool point is on"),
        ("G43.4 H1\nG92 X0.\nG1 X1. F100\n", "a new zero while X Y Z are places of the tool tip"),
        ("G43.4 H2\nG1 X1. F100\n", "the tool length H2 is not stated"),
        ("G43.5 H1\nG1 X1. F100\n", "G43.5"),
        ("G43.4 H1 C10.\nG1 X1. F100\n", "G43.4 and C in one block"),
        ("G43.4 H1\nG1 X5. F100 C10.\nG2 X15. I5. C20.\n", "an arc while C A turns"),
        ("G43.4 H1\nG1 X1000. F100\n", "to hold the tip there"),
    ],
)
def test_what_can_not_be_followed_is_said(text, message, tmp_path):
    machine = load(random_truth(np.random.default_rng(1), "w-C-A-b-X-Y-Z-t"), tmp_path)
    with pytest.raises(ProgramError, match=message):
        corrected(machine, "fanuc-mill", FIVE + text, {"H1": {"Z": LENGTH}})


def test_a_slide_that_holds_the_tip_may_stand_at_the_end_of_its_travel(tmp_path):
    """And not beyond it, by 1 um."""
    machine = load(plain("w-B-b-X-Y-Z-t", EXX=0.010), tmp_path)
    head = "G90 G54 G0 X0. Y0. Z0. B0.\nG43.4 H1\n"
    output, _ = corrected(machine, "fanuc-mill", head + "N1 G1 X400. F500.\n", {"H1": {"Z": 0.0}})
    assert words(output, 1) == "G1 X399.9900 F500."
    with pytest.raises(ProgramError, match="to hold the tip there X goes to 400.0010 mm, beyond"):
        corrected(machine, "fanuc-mill", head + "G1 X400.001 F500.\n", {"H1": {"Z": 0.0}})


def test_nor_does_its_correction_lead_it_beyond(tmp_path):
    machine = load(plain("w-B-b-X-Y-Z-t", EXX=0.010), tmp_path)
    text = "G90 G54 G0 X0. Y0. Z0. B0.\nG43.4 H1\nG1 X-400. F500.\n"
    with pytest.raises(ProgramError, match=r"X goes to -400.0100 mm \(nominal and correction\)"):
        corrected(machine, "fanuc-mill", text, {"H1": {"Z": 0.0}})


def test_only_a_feed_of_a_rotary_axis_asks_where_it_came_from(tmp_path):
    """EZB is 9 um at B90, so Z moves with B: of a feed that changes the time, of a rapid not."""
    truth = plain("w-B-b-X-Y-Z-t")
    nodes, mean, _ = truth.table["B"]
    mean[2] = nodes * 1e-4
    machine, head = load(truth, tmp_path, "linuxcnc"), "G90 G54 G0 X0. Y0. Z0.\n"
    output, _ = corrected(machine, "linuxcnc", head + "N1 G0 B90.\n")
    assert words(output, 1) == "G0 B90. Z-0.0090"
    with pytest.raises(ProgramError, match="where B stands before this feed is not known"):
        corrected(machine, "linuxcnc", head + "N1 G1 B90. F360\n")


def test_haas_is_asked_which_frame_it_takes(tmp_path):
    """Nothing says whether G234 counts X Y Z with the table at zero or as it stands: asked for, and
    then followed."""
    truth = random_truth(np.random.default_rng(1), "w-C-A-b-X-Y-Z-t")
    text = (
        "G21 G90 G54\nG0 X0. Y0. Z50. C45. A0.\nG234 H1\nG1 X10. Y0. Z0. A0. C45. F100.\nG49\nM30\n"
    )
    offsets = {"H1": {"Z": LENGTH}}
    with pytest.raises(ProgramError, match="while C does not stand at zero") as error:
        corrected(load(truth, tmp_path / "a"), "haas", text, offsets)
    assert 'frame = "zero"' in error.value.advice
    zero, call = (
        corrected(
            load(truth, tmp_path / frame, "haas", f'[tool_point]\nframe = "{frame}"'),
            "haas",
            text,
            offsets,
        )[0]
        for frame in ("zero", "call")
    )
    assert zero != call


@pytest.mark.parametrize(
    ("chain", "drop", "asked"),
    [
        ("w-C-A-b-X-Y-Z-t", "centre_stated", r"where the line of C lies"),
        ("w-b-X-Y-Z-C-B-t", "tool_stated", r"how far the spindle's nose stands"),
    ],
)
def test_what_the_folder_does_not_state_is_asked_for(chain, drop, asked, tmp_path):
    machine = load(random_truth(np.random.default_rng(1), chain), tmp_path)
    if drop == "tool_stated":
        machine = dataclasses.replace(machine, tool_stated=False)
    else:
        bare = {x: dataclasses.replace(a, centre_stated=()) for x, a in machine.axes.items()}
        machine = dataclasses.replace(machine, axes=bare)
    rotary = " ".join(f"{x}0." for x in machine.chain.rotary)
    text = f"G21 G90 G54\nG0 X0. Y0. Z50. {rotary}\nG43.4 H1\nG1 X10. F100.\n"
    with pytest.raises(ProgramError, match=asked):
        corrected(machine, "fanuc-mill", text, {"H1": {"Z": LENGTH}})


def test_a_machine_that_starts_with_its_tool_point_on(tmp_path):
    """LinuxCNC's five-axis kinematics are on from the start; M429 takes them back."""
    truth = random_truth(np.random.default_rng(3), "w-C-A-b-X-Y-Z-t")
    machine = load(
        truth, tmp_path, "linuxcnc", '[tool_point]\non = "M428"\noff = "M429"\nat_start = true'
    )
    text = (
        "N1 G21 G90 G54\nN2 G0 X0 Y0 Z50 A0 C0\nN3 G1 X30 Y10 A30 C60 F500\nN4 X10 Z20 A-20 C10\nN5"
        " M429\nN6 G0 X0 Y0 Z50\nM2\n"
    )
    output, verifier = corrected(machine, "linuxcnc", text)
    assert verifier.passed
    marked = text.replace("N2 ", "N2 M428 ")  # the judge's reader wants the word
    judged = tool_point.judge(truth, marked, output.replace("N2 ", "N2 M428 "), "M428", "M429")
    assert judged.tip < TOLERANCE + 0.0001 + machine.bounds.second_order < judged.tip_before


def test_m128_of_heidenhain(tmp_path):
    """DIN/ISO: `*` ends a block, the tool comes with T."""
    truth = random_truth(np.random.default_rng(4), "w-C-b-X-Y-Z-B-t")
    machine = load(truth, tmp_path, "heidenhain-iso")
    lines = [
        "%T G71 *",
        "N10 T1 G17 S5000 *",
        "N20 G00 G40 G90 X+0 Y+0 Z+50 C+0 B+0 *",
        "N30 M128 *",
        "N40 G00 X+0 Y+0 Z+50 *",
        "N50 G01 X+30 Y-20 Z+10 B+25 C+40 F500 *",
        "N60 G01 X-10 B-30 C-35 *",
        "N70 M129 *",
        "N99999999 %T G71 *",
    ]
    text = "\n".join(lines) + "\n"
    output, verifier = corrected(machine, "heidenhain-iso", text, {"T1": {"Z": LENGTH}})
    assert verifier.passed
    judged = tool_point.judge(truth, text, output.replace("+", ""), "M128", "M129", LENGTH)
    assert judged.tip < TOLERANCE + 0.0001 + machine.bounds.second_order < judged.tip_before


@pytest.mark.parametrize(
    "call",
    [
        "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS",
        "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-TIP F1000",
    ],
)
def test_function_tcpm_is_m128(call):
    """TNC 640, TNC 620, "FUNCTION TCPM": F TCP is the speed of the tip, AXIS POS takes rotary words
    as places of the axes, PATHCTRL AXIS leads the tip straight. Programs move as under M128."""
    machine = places.load("example-five-axis")
    text = (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z-300 A+0 C+0 R0 FMAX M3\n{}\n"
        "L X+10 Y+10 A-10 C+20 F500\nL X+20 Y+10 A-20 C+40\n{}\nL Z-200 FMAX\nEND PGM A MM\n"
    )
    offsets = {"T1": {"Z": 100.0}, "G54": {}}
    old = corrected(machine, "heidenhain", text.format("M128", "M129"), offsets)[0]
    new, verifier = corrected(
        machine, "heidenhain", text.format(call, "FUNCTION RESET TCPM"), offsets
    )
    assert new.replace(call, "M128").replace("FUNCTION RESET TCPM", "M129") == old
    assert verifier.passed and verifier.uncorrected.deviation > 0.005


class Sliding(TipMachine):
    """One slide, two-way, whose place is told at each t of a motion."""

    two_way, turning = np.array([True]), ()

    def __init__(self, course):
        object.__setattr__(self, "slides", course)


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("turns", [0.03, 0.37, 0.5])
def test_a_slide_turns_at_the_vertex_of_its_parabola(way, turns):
    """Found by three of 17 places, to the last digits. To and fro by less than the hysteresis is
    no turn."""
    one = np.zeros(1)
    for size, found in ((1.0, [turns]), (0.0001, [])):
        b = SimpleNamespace(
            machine=Sliding(lambda place: way * size * (place - turns) ** 2),
            m=SimpleNamespace(code=one + FEED, cutter=one + FREE),
            free=one == 0,
            start_known=one == 0,
            c=SimpleNamespace(hysteresis=0.0005),
            nominal=lambda motion, t: t[None],
        )
        motion, t = map(np.concatenate, zip(*turning._of_slides(b)))
        assert t == pytest.approx(found, abs=1e-12) and not motion.any()


@pytest.mark.parametrize("chain", CHAINS)
def test_the_tool_points_where_the_whole_chain_turns_it(chain, tmp_path):
    """Judged by exact transforms; products of two angles of 20 urad are left out."""
    rng = np.random.default_rng(CHAINS.index(chain))
    truth = random_truth(rng, chain)
    machine = load(truth, tmp_path)
    for _ in range(3):
        pose = {x: float(rng.uniform(-80, 80)) for x in machine.letters}
        place = np.array([[pose[x]] for x in machine.letters])
        actual = tool_directions(machine, place, np.zeros(place.shape))[:, 0]
        assert actual == pytest.approx(truth.axis(pose, 1.0), abs=2e-8)
        assert np.abs(actual - truth.axis(pose, 0.0)).max() > 5e-7


def test_in_a_space_no_axis_has_errors_of_its_own():
    """They are those of the slides behind it, which the machine with that tool has."""
    five = places.load("example-five-axis")
    found = seen_in(five, np.zeros(5), Space(), False)
    assert {(x, a.travel) for x, a in found.axes.items()} == {
        *((x, (-np.inf, np.inf)) for x in "XYZ"),
        *((x, five.axes[x].travel) for x in "AC"),
    }
    assert not any(a.table or a.grids or a.location.any() for a in found.axes.values())
    assert found.square == {} and found.effects == () and found.base.square == five.square
