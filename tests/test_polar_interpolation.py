"""Polar interpolation of turning centres: G12.1 of Fanuc lathes, G112 of Haas lathes."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.compensate import Options
from postproc.compensate.inverse import CLOSE, command
from postproc.errors import GcompError
from postproc.filter import Filter, setup_of
from postproc.machine import face, places
from postproc.machine.polar import PolarBounds, PolarMachine
from postproc.machine.seen import seen_in
from postproc.nc import dialects
from postproc.spaces import Space
from postproc.verify import Verifier
from tests.reference import polar
from tests.reference.tool_point import Truth, random_truth
from tests.test_tool_point import plain

TOLERANCE = 0.001
FANUC, HAAS = ("fanuc-lathe", "C", "G12.1", "G13.1"), ("haas-lathe", "Y", "G112", "G113")
CHAINS = ("w-C-b-Z-X-t", "w-C-b-Z-X-Y-t")
DIAMETER = 'diameter = ["X"]\n'


def load(truth: Truth, folder, dialect: str):
    truth.write(folder, dialect)
    path = folder / "machine.toml"
    text = path.read_text().replace("chain ", DIAMETER + "chain ", 1)
    zeros = ", ".join(f"{x} = 0.0" for x in "XYZ" if x in truth.axes)
    path.write_text(re.sub(r"G54 = \{.*\}", f"G54 = {{ {zeros} }}", text))
    return places.load(str(folder))


def corrected(machine, dialect: str, text: str, cut: int | None = None, **options):
    offsets = options.pop("offsets", {})
    setup = setup_of(machine, offsets, start=options.pop("start", {}))
    filter_ = Filter(
        machine, dialects.load(dialect), setup, Options(tolerance=TOLERANCE, **options)
    )
    verifier = Verifier(filter_)
    data = text.encode()
    parts = [data] if cut is None else [data[i : i + cut] for i in range(0, len(data), cut)]
    return b"".join([*(filter_.feed(p) for p in parts), filter_.finish()]).decode(), verifier


def program(lines: list[str], which=FANUC, before: str = "G0 X60. Z5. C0.", y: bool = False) -> str:
    _, _, on, off = which
    head = ["G21", "G98 G40", *(["G0 Y0."] if y else []), before, "G17", on]
    every = [*head, *lines, off, "G0 X80.", "M30"]
    return "\n".join(f"N{10 * k} {line}" for k, line in enumerate(every, 1)) + "\n"


def last_of(text: str, number: int, which) -> tuple[float, float]:
    """The place of the face (mm, radius) at which what stands for a block ends."""
    strokes = [s for s in polar.strokes(text, *which[1:]) if s[0] == str(number)]
    return float(strokes[-1][3][0]), float(strokes[-1][3][1])


def line_of(text: str, number: int) -> str:
    return next(x for x in text.splitlines() if x.startswith(f"N{number} ")).partition(" ")[2]


# -- by hand ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("which", "half"), [(FANUC, 2), (HAAS, 1)])
def test_what_x_misses_by_lies_away_from_the_line_of_c(which, half, tmp_path):
    """EXX = +10 um everywhere: at (20, 0) of the face the tip is 10 um too far along the first
    coordinate, at (0, 20) along the second, at (-20, 0) along the first the other way. Beside C the
    first coordinate is a diameter, beside Y a radius."""
    machine = load(plain(CHAINS[0], EXX=0.010), tmp_path, which[0])
    second = which[1]
    lines = [f"X{20 * half}. {second}0. F100.", f"X0. {second}20.", f"X{-20 * half}. {second}0."]
    text = program([f"G1 {line}" for line in lines], which)
    output, verifier = corrected(machine, which[0], text)
    ends = [(19.99, 0.0), (0.0, 19.99), (-19.99, 0.0)]  # the last piece of each line
    found = [last_of(output, k, which) for k in (60, 70, 80)]
    assert np.allclose(found, ends, atol=1e-9)
    assert verifier.passed


def test_what_goes_across_is_reported_along_the_second_coordinate(tmp_path):
    """EYX = +10 um everywhere, along which no slide goes: at (20, 0) C is turned back by as much,
    10 um at 20 mm."""
    machine = load(plain(CHAINS[0], EYX=0.010), tmp_path, "fanuc-lathe")
    output, _ = corrected(machine, "fanuc-lathe", program(["G1 X40. C0. F100.", "G1 Z0."]))
    assert last_of(output, 60, FANUC) == (20.0, -0.01)


def test_the_frame_begins_where_c_stands(tmp_path):
    """EXZ = +10 um everywhere lies along X of the machine, away from C's line, however C stands at
    the call: the words are the same."""
    machine = load(plain(CHAINS[0], EXZ=0.010), tmp_path, "fanuc-lathe")
    lines = ["G1 X40. C0. F100.", "G1 X30. C15."]
    outputs = [
        corrected(machine, "fanuc-lathe", program(lines, before=f"G0 X60. Z5. C{c}"))[0]
        for c in ("0.", "90.", "-45.")
    ]
    ends = [out.partition("G12.1")[2] for out in outputs]
    assert ends[0] == ends[1] == ends[2]
    assert last_of(outputs[0], 60, FANUC) == (19.99, 0.0)


def test_increments_and_inches(tmp_path):
    """U and H are increments of the face, H in inches under G20: 0.5 in of H is 12.7 mm."""
    machine = load(plain(CHAINS[0], EXX=0.010), tmp_path, "fanuc-lathe")
    text = "G20 G98\nG0 X2. Z.2 C0.\nG12.1\nG1 X1. C0. F4.\nG1 U1. H.5\nG1 H-.5 U-1.\nG13.1\nM30\n"
    output, verifier = corrected(machine, "fanuc-lathe", text)
    assert verifier.passed
    moved = [float(x) for x in re.findall(r"H(-?[\d.]+)", output)]
    first = next(k for k, x in enumerate(moved) if x < 0)
    # (1, 0.5) in of the face, 1.118 in from its middle: 10 um less
    assert sum(moved[:first]) == pytest.approx(0.5 - 0.01 / 25.4 * 0.5 / np.hypot(1, 0.5), abs=3e-5)


def test_y_stays_where_its_correction_has_led_it(tmp_path):
    """EYY = +10 um of a machine with Y: its word before the call takes it 10 um back, nothing moves
    it on the face, and there nothing of it is left to be told."""
    machine = load(plain(CHAINS[1], EYY=0.010), tmp_path, "haas-lathe")
    text = program(["G1 X20. Y0. F100.", "G1 Y10."], HAAS, y=True)
    output, verifier = corrected(machine, "haas-lathe", text)
    assert line_of(output, 40) == "G0 X60. Z5. C0. Y-0.0100"
    assert "G1 X20. Y0. F100." in output and "G1 Y10." in output
    assert verifier.passed


def test_a_machine_without_errors_changes_nothing(tmp_path):
    machine = load(plain(CHAINS[0]), tmp_path, "haas-lathe")
    text = program(["G1 X20. Y0. F100.", "G2 X0. Y-20. R20.", "G1 Y-25."], HAAS)
    assert corrected(machine, "haas-lathe", text)[0] == text


# -- judged ----------------------------------------------------------------------------------------


def contour(rng: np.random.Generator, which) -> list[str]:
    """Lines and arcs of a face, beyond 8 mm from its middle."""
    second, half = which[1], 2.0 if which[1] == "C" else 1.0
    here, lines = 30.0 + 0j, [f"G1 X{30 * half:.3f} {second}0. Z-1. F200."]
    for _ in range(12):
        turn = rng.uniform(0.2, 0.9) * rng.choice([-1, 1])
        there = rng.uniform(20, 45) * np.exp(1j * (np.angle(here) + turn))
        there = complex(round(there.real, 3), round(there.imag, 3))
        words = f"X{there.real * half:.3f} {second}{there.imag:.3f}"
        kind = rng.integers(0, 3)
        if kind == 0 or abs(there - here) < 1:
            lines.append(f"G1 {words}")
        else:
            radius = round(abs(there - here) * rng.uniform(0.8, 2.0), 3)
            lines.append(f"G{2 if turn < 0 else 3} {words} R{radius}")
        if rng.integers(0, 4) == 0:
            lines.append(f"G1 Z{rng.uniform(-5, -1):.3f}")
        here = there
    return lines


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("which", [FANUC, HAAS])
def test_the_tip_stays_on_its_path(which, seed, tmp_path):
    """Random lathes and contours of the face, judged by exact transforms of the whole chain and a
    control of their own: the tip is within tolerance, rounding, and the products of two errors."""
    rng = np.random.default_rng(1000 + seed)
    chain = CHAINS[seed % 2]
    truth = random_truth(rng, chain)
    truth.centre["C"] = np.zeros(3)
    machine = load(truth, tmp_path, which[0])
    y = "Y" in truth.axes
    before = f"G0 X60. Z5. C{rng.integers(-90, 90)}."
    text = program(contour(rng, which), which, before, y)
    output, verifier = corrected(machine, which[0], text)
    tip, tip_before = polar.judge(truth, text, output, *which[1:])
    assert tip_before > 0.005
    assert tip < TOLERANCE + 0.0002 + machine.bounds.second_order
    assert verifier.passed
    if seed < 2:  # one of each chain
        assert corrected(machine, which[0], text, cut=37)[0] == output


def test_zero_of_x_is_the_line_of_c(tmp_path):
    """A work offset of X beside the machine's zero: the face is counted from C's line all the
    same."""
    rng = np.random.default_rng(5)
    truth = random_truth(rng, CHAINS[0])
    truth.centre["C"] = np.zeros(3)
    truth.tool[0] = -130.0
    machine = load(truth, tmp_path, "fanuc-lathe")
    text = program(contour(rng, FANUC)).replace("G98 G40", "G98 G40 G54")
    offsets = {"G54": {"X": 130.0, "Z": 0.0, "C": 0.0}}
    output, verifier = corrected(machine, "fanuc-lathe", text, offsets=offsets)
    tip, tip_before = polar.judge(truth, text, output, *FANUC[1:], zero=130.0)
    assert tip < TOLERANCE + 0.0002 + machine.bounds.second_order < tip_before
    assert verifier.passed


def test_lost_motion_is_taken_up_where_x_turns(tmp_path):
    """20 um of play: a straight cut across the face leads X in and out again, and X is sent over
    its play where it turns."""
    truth = plain(CHAINS[0])
    truth.table["X"][2][0] = -0.010
    machine = load(truth, tmp_path, "fanuc-lathe")
    lines = ["G1 X40. C-20. F100.", "G1 C20.", "G3 X-40. C20. I-20. J-20.", "G1 C-20."]
    output, verifier = corrected(machine, "fanuc-lathe", program(lines), reversal="step")
    assert verifier.passed
    assert verifier.uncorrected.slide > 0.009 > 0.003 > verifier.corrected.slide
    assert len(output.splitlines()) > len(program(lines).splitlines())


@pytest.mark.parametrize("seed", range(8))
def test_lost_motion_of_every_slide(seed, tmp_path):
    """6 um of play in X, Y and Z: slides that rest follow the errors of X, and are sent over their
    play where those turn; Y, which nothing moves, keeps its side. A verifier that follows every
    command finds what the sides leave, by direction and with the play as such."""
    rng = np.random.default_rng(2000 + seed)
    truth = random_truth(rng, CHAINS[seed % 2], play=0.006)
    truth.centre["C"] = np.zeros(3)
    nodes, mean, half = truth.table["C"]  # the same after a whole turn
    truth.table["C"] = nodes, np.repeat(mean[:, :1], mean.shape[1], axis=1), half
    machine = load(truth, tmp_path, "fanuc-lathe")
    text = program(contour(rng, FANUC), FANUC, "G0 X60. Z5. C10.", "Y" in truth.axes)
    output, verifier = corrected(machine, "fanuc-lathe", text, reversal="step")
    assert verifier.uncorrected.slide > 0.008
    assert verifier.corrected.slide < verifier.allowed
    assert verifier.passed
    assert corrected(machine, "fanuc-lathe", text, cut=41, reversal="step")[0] == output


def test_cutter_radius_compensation_goes_along(tmp_path):
    """G41 on the face: what is read is the map at the tool's centre, and the centre stays on its
    way."""
    rng = np.random.default_rng(7)
    truth = random_truth(rng, CHAINS[0])
    truth.centre["C"] = np.zeros(3)
    for which in (FANUC, HAAS):
        machine = load(truth, tmp_path / which[0], which[0])
        s, k = which[1], 2 if which[1] == "C" else 1
        lines = [
            f"G41 G1 X{40 * k}. {s}0. F100.",
            f"G1 X{30 * k}. {s}20.",
            f"G3 X{-10 * k}. {s}25. R30.",
            f"G40 G1 X{-10 * k}. {s}40.",
        ]
        text = program(lines, which).replace("G98 G40", "T0101 G98 G40")
        offsets = {"T0101": {"X": 0.0, "Z": 0.0, "R": 4.0}}
        _, verifier = corrected(machine, which[0], text, offsets=offsets)
        assert verifier.passed
        assert verifier.centre.corrected.deviation < 0.5 * verifier.centre.uncorrected.deviation


def test_behind_it_words_are_slides_again(tmp_path):
    """X and C stand where the face has left them: an increment of U counts from there."""
    machine = load(plain(CHAINS[0], EXX=0.010), tmp_path, "fanuc-lathe")
    text = program(["G1 X0. C40. F100."]).replace("G0 X80.", "G0 U20.\nG0 X100. C30.")
    output, verifier = corrected(machine, "fanuc-lathe", text)
    assert re.search(r"^G0 X99.980* C30\.$", output, re.MULTILINE)
    assert verifier.passed


# -- refused ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "before", "said"),
    [
        (["G0 X40. C0."], "G0 X60. Z5. C0.", "G0 in polar interpolation"),
        (["G1 X40. C0. F9.", "G28 U0.", "G1 C5."], "G0 X60. Z5. C0.", "a reference point in polar"),
        (["G1 X40. C0. F9.", "G92 X50.", "G1 C5."], "G0 X60. Z5. C0.", "a new zero of X"),
        (["G1 X40. Y0. F9."], "G0 X60. Z5. C0.", "machine has no axis Y"),
        (["G1 X40. C0. F9.", "G83 Z-5. R2."], "G0 X60. Z5. C0.", "cycle|drilling"),
        (["G1 X40. C0. F9."], "G0 X60. Z5.", "where C stands is not known"),
        (["G1 X40. C0. F9."], "G0 X0. Z5. C0.", "does not stand outside"),
        (["G1 X40. C0. F9.", "G1 X-40. C1."], "G0 X60. Z5. C0.", "nearer than 1 mm"),
        (["G1 X40. C0. F9."], "G0 X60. Z5. C0.\nG42", "with cutter radius compensation on"),
    ],
)
def test_what_is_refused(lines, before, said, tmp_path):
    machine = load(plain(CHAINS[0], EXX=0.010), tmp_path, "fanuc-lathe")
    with pytest.raises(GcompError, match=said):
        corrected(machine, "fanuc-lathe", program(lines, before=before))


@pytest.mark.parametrize(("diameter", "goes"), [("2.", True), ("1.998", False)])
def test_from_a_millimetre_on_it_may_come_to_the_line_of_c(diameter, goes, tmp_path):
    machine = load(plain(CHAINS[0], EXX=0.010), tmp_path, "fanuc-lathe")
    text = program(["G1 X40. C0. F9.", f"G1 X{diameter}", "G1 X40."])
    if goes:
        assert corrected(machine, "fanuc-lathe", text)[1].passed
    else:
        with pytest.raises(GcompError, match="nearer than 1 mm"):
            corrected(machine, "fanuc-lathe", text)


def test_a_way_to_the_middle_is_reported_as_such(tmp_path):
    """And not as a map too steep: what is off across the way turns half around there."""
    truth = plain(CHAINS[0], EXX=0.010, EYX=0.008)
    truth.table["X"][2][0] = -0.010
    machine = load(truth, tmp_path, "fanuc-lathe")
    with pytest.raises(GcompError, match="nearer than 1 mm"):
        corrected(machine, "fanuc-lathe", program(["G1 X40. C0. F9.", "X0."]), reversal="step")


def test_near_the_line_of_c_the_inverse_goes_on_until_it_is_settled(tmp_path):
    """50 um, 1.5 mm from it, turn by 0.03 rad with each round: two rounds leave 27 nm open."""
    machine = load(plain(CHAINS[0], EXX=0.030, EYX=0.040), tmp_path, "fanuc-lathe")
    seen = seen_in(machine, np.zeros(3), Space(polar="C"), False)
    target = np.array([[1.2, 1.5, 3.0], [5.0] * 3, [0.9, 1.5, -2.0]])
    found = command(seen, target, np.zeros((3, 3)))
    assert found + seen.deviation(found, np.zeros((3, 3))) == pytest.approx(target, abs=CLOSE)


def test_a_machine_without_c(tmp_path):
    machine = load(plain("w-b-Z-X-t", EXX=0.010), tmp_path, "haas-lathe")
    with pytest.raises(GcompError, match="no C in the machine's chain"):
        corrected(machine, "haas-lathe", program(["G1 X20. F9."], HAAS, before="G0 X60. Z5."))


def test_what_turns_around_the_line_of_c_is_looked_at_in_the_middle_of_the_way_too():
    """40 mm from C's line, 20 um at Z50 and none at Z0 and Z100: it may be half as much again, and
    turns by that over the radius: 0.03 / 40 beside the slides' own."""
    machine = SimpleNamespace(
        letters="XCZ",
        base=SimpleNamespace(bounds=SimpleNamespace(kink=0.001, steepest=0.002)),
        deviation=lambda place, still: np.stack(
            [np.where(np.abs(place[2] - 50) < 1, 0.02, 0.0), *still[1:]]
        ),
    )
    low, high = np.array([[40.0], [0.0], [0.0]]), np.array([[40.0], [0.0], [100.0]])
    kink, steep = PolarBounds(cast(Any, machine)).local(low, high)
    turns = 0.02 * 1.5 / 40
    assert kink == pytest.approx([0.001 + 2 * turns])
    assert steep == pytest.approx([0.002 + turns])


@pytest.mark.parametrize(
    ("known", "c"), [((-180.0, 180.0), -90.0), ((0.0, 360.0), 270.0), ((-500.0, -120.0), -450.0)]
)
def test_c_is_taken_by_a_whole_turn_into_what_its_tables_know(known, c):
    """At (0, -10) of the face C stands at -90 degrees, or a turn from there."""
    place = np.array([[0.0], [-10.0], [5.0]])
    slides = face.slides_of(("X", "C", "Z"), Space(polar="C"), place, known)
    assert slides[:, 0] == pytest.approx([10.0, c, 5.0])


def test_an_axis_that_the_chain_does_not_hold_is_not_corrected_on_the_face():
    machine = SimpleNamespace(letters="XYZC", chain=SimpleNamespace(axes=("C", "X")))
    assert PolarMachine.corrected.func(cast(Any, machine)) == (0, 3)


def test_y_elsewhere_is_no_axis(tmp_path):
    machine = load(plain(CHAINS[0], EXX=0.010), tmp_path, "haas-lathe")
    with pytest.raises(GcompError, match="the machine has no axis Y"):
        corrected(machine, "haas-lathe", "G0 X60. Z5. C0.\nG1 X50. Y2. F9.\n")


def test_half_a_circle_about_the_line_of_c_beside_a_y_slide(tmp_path):
    """The middle of both its ends is C's line, where no direction lies across."""
    machine = load(random_truth(np.random.default_rng(3), CHAINS[1]), tmp_path, "fanuc-lathe")
    lines = ["G1 X0. C-20. F100.", "G3 X0. C20. I0. J20.", "G1 X4. C20."]
    _, verifier = corrected(machine, "fanuc-lathe", program(lines, y=True))
    assert verifier.passed
    seen = seen_in(machine, np.zeros(3), Space(polar="C"), False)
    box = np.array([[20.0, 20.0, 20.0, 5.0]]).T
    assert all(np.isfinite(bound).all() for bound in seen.bounds.local(-box, box))
