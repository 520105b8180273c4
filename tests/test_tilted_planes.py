"""Tilted planes: G68.2 with Euler angles, G53.1, on machines that err in every component."""

from __future__ import annotations

import re

import numpy as np
import pytest

from postproc.cli import main
from postproc.errors import ProgramError
from postproc.machine import chain, places
from postproc.machine.poses import Poses
from postproc.records import replace
from postproc.units import TICKS_PER_MM
from tests.reference.tool_point import CHAINS, TURN, Truth, random_truth
from tests.test_tool_point import (
    LENGTH,
    TOLERANCE,
    a_filter,
    corrected,
    in_pieces,
    load,
    plain,
    words,
)

OFFSETS = {"H1": {"Z": LENGTH}}


def about(axis: int, degrees: float) -> np.ndarray:
    """Rodrigues' formula."""
    k = np.cross(np.eye(3), np.eye(3)[axis])
    return np.eye(3) + np.sin(np.radians(degrees)) * k + (1 - np.cos(np.radians(degrees))) * k @ k


def euler_of(normal: np.ndarray, spin: float) -> tuple[float, float, float]:
    """I J K of G68.2 for a plane across `normal`: about Z, about the new X, about the new Z by
    `spin`."""
    j = np.degrees(np.arccos(np.clip(normal[2], -1, 1)))
    i = np.degrees(np.arctan2(normal[0], -normal[1]))
    return float(i), float(j), spin


def test_euler_angles_by_hand():
    """I 0, J 90: the plane's Z is where Y pointed backwards, -Y; its Y is Z."""
    turn = about(2, 0) @ about(0, 90) @ about(2, 0)
    assert np.allclose(turn @ [0, 0, 1], [0, -1, 0])
    assert np.allclose(turn @ [0, 1, 0], [0, 0, 1])
    i, j, k = euler_of(np.array([0.6, 0.0, 0.8]), 25.0)
    assert np.allclose((about(2, i) @ about(0, j) @ about(2, k))[:, 2], [0.6, 0, 0.8])


class Plane:
    """A random plane on a random machine: the pose that stands across it is drawn first, its angles
    follow."""

    def __init__(self, seed: int, chain: str):
        rng = np.random.default_rng(seed)
        self.truth: Truth = random_truth(rng, chain)
        self.angles = {x: round(float(rng.uniform(15, 60)), 3) for x in self.truth.rotary}
        # The axis farther from the part tilts; its travel leaves one of the two ways to stand
        # across a plane.
        self.truth.travel[self.truth.rotary[-1]] = (-10.0, 110.0)
        self.truth.travel[self.truth.rotary[0]] = (-170.0, 170.0)
        for x in self.truth.rotary:
            nodes = np.linspace(*self.truth.travel[x], len(self.truth.table[x][0]))
            self.truth.table[x] = (nodes, *self.truth.table[x][1:])
        normal = self.truth.axis({**dict.fromkeys("XYZ", 0.0), **self.angles}, 0.0)
        self.zero = rng.uniform(-20, 20, 3).round(3)
        self.euler = tuple(round(a, 9) for a in euler_of(normal, float(rng.uniform(-90, 90))))
        i, j, k = self.euler
        self.turn = about(2, i) @ about(0, j) @ about(2, k)
        x, y, z = self.zero
        start = " ".join(f"{x}0." for x in self.truth.rotary)
        self.head = (
            f"G90 G54 G17\nG0 X0. Y0. Z80. {start}\nG68.2 X{x:.3f} Y{y:.3f} Z{z:.3f} I{i:.9f}"
            f" J{j:.9f} K{k:.9f}\nG53.1\nG43 H1\nG0 X0. Y0. Z30.\n"
        )

    def off(self, word: np.ndarray) -> np.ndarray:
        """(3,) mm, in the plane: where the tip is less where the words (3,) are."""
        place = self.zero + self.turn @ word + self.truth.tool
        pose = self.truth.slides(place, self.angles, LENGTH)
        return self.turn.T @ (self.truth.actual(pose, LENGTH) - place)


def path(text: str) -> list[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Code, start, end and centre (from the start) of every motion behind G43."""
    here, code, found = np.full(3, np.nan), "0", []
    for line in re.sub(r"\([^)]*\)", "", text.split("G43 H1")[1].split("G49")[0]).splitlines():
        codes = re.findall(r"G0*([0-3])(?![\d.])", line)
        code = codes[-1] if codes else code
        value = {
            x: float(v)
            for x, v in re.findall(r"([XYZIJ])([-+]?\d*\.?\d+)", re.sub(r"G\d+", "", line))
        }
        if value:
            end = np.array([value.get(x, here[k]) for k, x in enumerate("XYZ")])
            found.append((code, here, end, np.array([value.get("I", 0.0), value.get("J", 0.0)])))
            here = end
    return found


def samples(motion) -> np.ndarray:
    """(7, 3) places of a line or an arc in the plane."""
    code, start, end, centre = motion
    t = np.array([0.0, 0.17, 0.34, 0.5, 0.68, 0.83, 1.0])[:, None]
    if code == "1":
        return start + (end - start) * t
    middle = start[:2] + centre
    first, last = (np.arctan2(*(p[:2] - middle)[::-1]) for p in (start, end))
    sweep = (last - first) % (2 * np.pi) if code == "3" else -((first - last) % (2 * np.pi))
    radius = np.hypot(*centre) + (np.hypot(*(end[:2] - middle)) - np.hypot(*centre)) * t
    angle = first + (sweep if abs(sweep) > 1e-9 else 2 * np.pi) * t
    return np.hstack(
        [
            middle + radius * np.hstack([np.cos(angle), np.sin(angle)]),
            start[2] + (end[2] - start[2]) * t,
        ]
    )


def distance(place: np.ndarray, motion) -> float:
    """From a place to a nominal line or arc."""
    code, start, end, centre = motion
    if code == "1":
        way = end - start
        t = np.clip((place - start) @ way / max(way @ way, 1e-30), 0, 1)
        return float(np.linalg.norm(place - start - way * t))
    arm = place[:2] - start[:2] - centre
    return float(np.hypot(np.hypot(*arm) - np.hypot(*centre), place[2] - start[2]))


@pytest.mark.parametrize("chain", CHAINS)
def test_lines_and_arcs_in_a_plane(chain, tmp_path):
    """The tip's path in the part, by exact transforms: within tolerance of the nominal one."""
    plane = Plane(200 + CHAINS.index(chain), chain)
    machine = load(plane.truth, tmp_path)
    text = (
        plane.head
        + "G1 X20. Y-15. Z-3. F500.\nX-25. Y10.\nG2 X-5. Y30. I20. J0.\nG3 X-5. Y30. I10. J-10.\nG1"
        " X30. Z5.\nG0 Z50.\nG49\nG69\nM30\n"
    )
    output, verifier = corrected(machine, "fanuc-mill", text, OFFSETS)
    assert verifier.passed, verifier.report()
    nominal, written = path(text), path(output)
    worst = before = 0.0
    for motion in (m for m in written if m[0] != "0" and np.isfinite(m[1]).all()):
        for word in samples(motion):
            actual = word + plane.off(word)
            worst = max(
                worst,
                min(
                    distance(actual, m) for m in nominal if m[0] != "0" and np.isfinite(m[1]).all()
                ),
            )
    for motion in (m for m in nominal if m[0] != "0" and np.isfinite(m[1]).all()):
        before = max(before, max(distance(w + plane.off(w), motion) for w in samples(motion)))
    assert before > 0.004
    assert worst < TOLERANCE + 0.0001 + machine.bounds.second_order


@pytest.mark.parametrize("chain", CHAINS[::3])
def test_holes_in_a_plane(chain, tmp_path):
    """A canned cycle drills along the plane's Z: its middle and its bottom are where they are
    wanted."""
    plane = Plane(300 + CHAINS.index(chain), chain)
    machine = load(plane.truth, tmp_path)
    text = plane.head + "G98 G81 X12. Y-8. Z-10. R2. F100.\nX-20. Y5.\nG80\nG49\nG69\nM30\n"
    output, _ = corrected(machine, "fanuc-mill", text, OFFSETS)
    blocks = output.split("G81")[1].split("G80")[0].splitlines()
    z = -10.0
    for block, wanted in zip(blocks, ((12.0, -8.0), (-20.0, 5.0)), strict=False):
        word = {x: float(v) for x, v in re.findall(r"([XYZ])([-+]?\d*\.?\d+)", block)}
        z = word.get("Z", z)
        for depth, axes in (((2 + z) / 2, (0, 1)), (z, (2,))):
            place = np.array([word["X"], word["Y"], depth])
            off = (place + plane.off(place) - [*wanted, -10.0])[list(axes)]
            assert np.abs(off).max() < TOLERANCE


def test_a_plane_by_hand(tmp_path):
    """J90 I90: Rz(90) Rx(90), the plane's X is the part's Y, its Y the part's Z, its Z the part's
    X. B of the table turns the part's X up: the tool stands along it at B90, and what X of the
    machine errs by (EXX 10 um) lies along the part's -Z then (a positive turn about Y takes X to
    -Z): Y of the plane is 10 um less than wanted, and becomes 10 um more."""
    machine = load(plain("w-B-b-X-Y-Z-t", EXX=0.010), tmp_path)
    text = (
        "N10 G90 G54 G0 X0. Y0. Z0. B0.\nN20 G68.2 X0. Y0. Z0. I90. J90. K0.\nN30 G53.1\nN40 G0 X5."
        " Y6. Z7.\nN50 G69\nM30\n"
    )
    output, _ = corrected(machine, "fanuc-mill", text)
    assert words(output, 40) == "G0 X5. Y6.0100 Z7."


@pytest.mark.parametrize("frame, z", [("zero", "6.9910"), ("call", "6.9820")])
def test_from_where_a_plane_counts_that_is_called_beside_zero(frame, z, tmp_path):
    """That plane, called with the table at B90. Counted from the table at zero B stands across it
    already, and errs by 9 um along Z; counted from where it stands it turns by another 90 degrees,
    to 18 um (EZB: 0.1 um a degree)."""
    truth = plain("w-B-b-X-Y-Z-t")
    nodes, mean, _ = truth.table["B"]
    mean[2] = nodes * 1e-4
    machine = load(truth, tmp_path / "m", "fanuc-mill", f'[tool_point]\nplanes = "{frame}"')
    text = (
        "N10 G90 G54 G0 X0. Y0. Z0. B90.\nN20 G68.2 X0. Y0. Z0. I90. J90. K0.\nN30 G53.1\nN40 G0"
        " X5. Y6. Z7.\nN50 G69\nM30\n"
    )
    output, _ = corrected(machine, "fanuc-mill", text)
    assert words(output, 40) == f"G0 X5. Y6. Z{z}"


def test_orientation_turns_nothing_in_a_plane(tmp_path):
    """There a rotary word would take the tip along: it stays, and that is said."""
    plane = Plane(5, "w-C-A-b-X-Y-Z-t")
    machine = load(plane.truth, tmp_path)
    text = plane.head + "G1 X20. Y-15. F500.\nG49\nG69\nM30\n"
    output, verifier = corrected(machine, "fanuc-mill", text, OFFSETS, orientation=True)
    assert output == corrected(machine, "fanuc-mill", text, OFFSETS)[0]
    assert verifier.passed


def test_a_machine_without_errors_changes_no_byte(tmp_path):
    text = (
        Plane(1, "w-C-A-b-X-Y-Z-t").head + "G1 X20. Y-15. F500.\nG2 X30. I5. J0.\nG49\nG69\nM30\n"
    )
    assert (
        corrected(load(plain("w-C-A-b-X-Y-Z-t"), tmp_path), "fanuc-mill", text, OFFSETS)[0] == text
    )


def test_any_cut_of_the_input_gives_the_same_bytes(tmp_path):
    plane = Plane(5, "w-C-A-b-X-Y-Z-t")
    machine = load(plane.truth, tmp_path)
    text = plane.head + "G1 X20. Y-15. F500.\nG2 X30. I5. J0.\nG49\nG69\nG0 X0. Y0. Z80.\nM30\n"
    whole = corrected(machine, "fanuc-mill", text, OFFSETS)[0]
    for cut in (1, 33, 90):
        filter_ = a_filter(machine, "fanuc-mill", OFFSETS)
        assert in_pieces(filter_, text, cut) == whole


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("G53.1\n", "", "the tool does not stand across the tilted plane"),
        ("G43 H1\n", "G43 H1\nG1 X1. A10. F100.\n", "a rotary axis moves in a tilted plane"),
        ("G43 H1\n", "G55\nG43 H1\nG1 X1. F100.\n", "a work offset called while a tilted plane"),
        (
            "G43 H1\n",
            "G28 Z0.\nG43 H1\nG1 X1. F100.\n",
            "a reference point while X Y Z are coordinates of a tilted plane",
        ),
        ("G68.2", "G0 C30.\nG68.2", "while C does not stand at zero"),
        ("G68.2", "G68.2 P1", "otherwise than by Euler angles"),
        ("I", "J91. (", "no pose of the rotary axes"),
    ],
)
def test_what_can_not_be_followed_is_said(before, after, message, tmp_path):
    plane = Plane(5, "w-C-A-b-X-Y-Z-t")
    if before == "I":
        plane.truth.travel["A"] = (-10.0, 30.0)
        plane.angles["A"] = 0.0
    machine = load(plane.truth, tmp_path)
    head = plane.head
    if before == "G53.1\n":
        machine = load(
            plane.truth, tmp_path / "zero", "fanuc-mill", '[tool_point]\nplanes = "zero"'
        )
        head = head.replace("G0 X0. Y0. Z80. C0. A0.", "G0 X0. Y0. Z80. C0. A20.")
    if before == "I":
        head, before, after = re.sub(r"I\S+ J\S+ K\S+", "I0. J80. K0.", head), "#", ""
    text = head.replace(before, after) + "G1 X20. Y-15. F500.\n"
    with pytest.raises(ProgramError, match=message):
        corrected(machine, "fanuc-mill", text, OFFSETS | {"G55": {"X": 1.0}})


def test_the_way_g53_1_takes_is_said_where_there_are_two(tmp_path):
    """A from -120 to 120: two poses stand across a plane; the shorter way of C is taken, and both
    are named."""
    truth = random_truth(np.random.default_rng(3), "w-C-A-b-X-Y-Z-t")
    truth.travel |= {"A": (-120.0, 120.0), "C": (-180.0, 180.0)}
    machine = load(truth, tmp_path)
    text = (
        "G90 G54\nG0 X0. Y0. Z80. C0. A0.\nG68.2 X0. Y0. Z0. I0. J30. K0.\nG53.1\nG43 H1\nG0 X0."
        " Y0. Z30.\nG1 X10. F100.\nG49\nG69\nM30\n"
    )
    from postproc.compensate import Options
    from postproc.filter import Filter, setup_of
    from postproc.nc import dialects

    filter_ = Filter(machine, dialects.load("fanuc-mill"), setup_of(machine, OFFSETS), Options())
    filter_.feed(text.encode())
    said = [n.message for n in filter_.notices if n.code == "G53.1"]
    assert len(said) == 1
    assert (
        "C0.000 A30.000" in said[0]
        and "C180.000 A-30.000" in said[0]
        or "C-180.000 A-30.000" in said[0]
    )
    assert TURN["A"] == 0


@pytest.mark.parametrize("chain", CHAINS[::2])
def test_cycle800_turns_axis_by_axis(chain, tmp_path):
    """Mode 57: about X, the new Y, the new Z, with a zero before and a shift behind; D brings the
    tool's length. The angles are those whose plane lies across a pose that was drawn."""
    plane = Plane(400 + CHAINS.index(chain), chain)
    machine = load(plane.truth, tmp_path, "siemens")
    n = plane.turn[:, 2]
    b = np.degrees(np.arcsin(n[0]))
    a = np.degrees(np.arctan2(-n[1], n[2]))
    a, b, c = round(float(a), 9), round(float(b), 9), 20.0
    plane.turn = about(0, a) @ about(1, b) @ about(2, c)
    assert np.allclose(plane.turn[:, 2], n, atol=1e-7)
    zero, shift = plane.zero, np.array([1.5, -2.0, 0.75])
    rotary = " ".join(f"{x}0" for x in plane.truth.rotary)
    call = ",".join(f"{v:.9f}" for v in (*zero, a, b, c, *shift))
    text = (
        f'G90 G54 G17\nT1 D1\nG0 X0 Y0 Z80 {rotary}\nCYCLE800(0,"TABLE",0,57,{call},1,0,0)\n; G43'
        " H1\nG0 X0 Y0 Z30\nG1 X20 Y-15 Z-3 F500\nX-25 Y10\nG2 X-5 Y30 I20 J0\nG1 X30 Z5\n;"
        " G49\nCYCLE800()\nM30\n"
    )
    plane.zero = zero + plane.turn @ shift
    output, verifier = corrected(machine, "siemens", text, {"D1": {"Z": LENGTH}})
    assert verifier.passed, verifier.report()
    nominal = [m for m in path(text) if m[0] != "0" and np.isfinite(m[1]).all()]
    worst = 0.0
    for motion in (m for m in path(output) if m[0] != "0" and np.isfinite(m[1]).all()):
        for word in samples(motion):
            worst = max(worst, min(distance(word + plane.off(word), m) for m in nominal))
    assert worst < TOLERANCE + 0.0001 + machine.bounds.second_order
    assert verifier.uncorrected.deviation > 0.004


@pytest.mark.parametrize(("sign", "ends"), [("1", (0.0, 0.5)), ("-1", (180.0, -0.5))])
def test_the_direction_of_cycle800_is_the_sign_of_the_axis_nearest_to_the_tool(
    sign, ends, tmp_path
):
    """Half a degree about X by hand: A0.5, or C turned round and A-0.5."""
    truth = random_truth(np.random.default_rng(3), "w-C-A-b-X-Y-Z-t")
    truth.travel |= {"A": (-120.0, 120.0), "C": (-180.0, 180.0)}
    filter_ = a_filter(load(truth, tmp_path, "siemens"), "siemens", {"D1": {"Z": LENGTH}})
    call = f'CYCLE800(0,"",0,57,0,0,0,0.5,0,0,0,0,0,{sign})'
    filter_.feed(f"G90 G54 G17\nT1 D1\nG0 X0 Y0 Z80 C0 A0\n{call}\n".encode())
    place = filter_.modal.position / TICKS_PER_MM
    rows = [filter_.machine.letters.index(x) for x in "CA"]
    assert np.abs(place[rows[0]]) == pytest.approx(ends[0], abs=1e-6)
    assert place[rows[1]] == pytest.approx(ends[1], abs=1e-6)


def test_cycle800_takes_the_other_way_where_its_direction_lies_beyond_the_travel(tmp_path):
    """The control takes the alternative whatever _DIR is (828D operating manual, "Direction"): A
    may tilt from -10 to 110, so that the tilt of 30 has one way."""
    truth = random_truth(np.random.default_rng(3), "w-C-A-b-X-Y-Z-t")
    truth.travel |= {"A": (-10.0, 110.0), "C": (-170.0, 170.0)}
    machine = load(truth, tmp_path, "siemens")
    outputs = []
    for sign in ("1", "-1"):
        call = f'CYCLE800(0,"",0,57,0,0,0,30,0,0,0,0,0,{sign})'
        text = (
            f"G90 G54 G17\nT1 D1\nG0 X0 Y0 Z80 C0 A0\n{call}\nG0 X0 Y0 Z30\nG1 X20 Y-15 Z-3"
            " F500\nCYCLE800()\nM30\n"
        )
        output, verifier = corrected(machine, "siemens", text, {"D1": {"Z": LENGTH}})
        assert verifier.passed, verifier.report()
        outputs.append(output.replace(call, "CYCLE800"))
    assert outputs[0] == outputs[1]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("0,,0,192,0,0,0,10,20,0,0,0,0,1", "its mode 192 does not turn axis by axis"),
        ("0,,1,57,0,0,0,10,20,0,0,0,0,1", "it adds to the plane before"),
        ("0,,0,57,0,0,0,R1,20,0,0,0,0,1", "its arguments are not plain numbers"),
        ("0,,0,57,0,0,0,10,20,0,0,0,0,0", "the tool does not stand across|turn"),
        ("1,,0,57,0,0,0,10,20,0,0,0,0,1", "where [XYZ ]+ stands? is not known"),
    ],
)
def test_cycle800_that_can_not_be_followed_is_said(call, message, tmp_path):
    plane = Plane(5, "w-C-A-b-X-Y-Z-t")
    machine = load(plane.truth, tmp_path, "siemens")
    text = f"G90 G54 G17\nT1 D1\nG0 X0 Y0 Z80 C0 A5\nCYCLE800({call})\nG1 X20 F500\n"
    with pytest.raises(ProgramError, match=message):
        corrected(machine, "siemens", text, {"D1": {"Z": LENGTH}})


def klartext_path(text: str):
    """`path` of Klartext: L and FMAX as G1 and G0, from the line G43 on."""
    text = re.sub(r"^L (.*) FMAX", r"G0 \1", text, flags=re.M)
    text = re.sub(r"^L ", "G1 ", text, flags=re.M)
    return path(text.replace("+", ""))


@pytest.mark.parametrize("kind", ["SPATIAL", "EULER"])
@pytest.mark.parametrize("chain", CHAINS[1::2])
def test_plane_of_klartext(chain, kind, tmp_path):
    """By spatial angles, about X, Y and Z of the machine one after the other, and by Euler angles;
    the angles are those whose plane lies across a pose that was drawn."""
    plane = Plane(500 + CHAINS.index(chain), chain)
    machine = load(plane.truth, tmp_path, "heidenhain")
    n = plane.turn[:, 2]
    if kind == "EULER":
        i, j, k = plane.euler
        angles = f"EULPR{i:+.9f} EULNU{j:+.9f} EULROT{k:+.9f}"
    else:
        c = 20.0
        before = about(2, c).T @ n  # Ry Rx Z
        a = round(float(np.degrees(np.arcsin(-before[1]))), 9)
        b = round(float(np.degrees(np.arctan2(before[0], before[2]))), 9)
        plane.turn = about(2, c) @ about(1, b) @ about(0, a)
        assert np.allclose(plane.turn[:, 2], n, atol=1e-7)
        angles = f"SPA{a:+.9f} SPB{b:+.9f} SPC{c:+.9f}"
    rotary = " ".join(f"{x}+0" for x in plane.truth.rotary)
    x, y, z = plane.zero
    text = (
        f"L X+0 Y+0 Z+80 {rotary} R0 FMAX\nTRANS DATUM AXIS X{x:+.3f} Y{y:+.3f} Z{z:+.3f}\n"
        f"PLANE {kind} {angles} TURN FMAX SEQ+\nTOOL CALL 1 Z S900; G43 H1\n"
        "L X+0 Y+0 Z+30 FMAX\nL X+20 Y-15 Z-3 F500\nL X-25 Y+10\nL X+30 Z+5\n; G49\n"
        "PLANE RESET TURN FMAX\nM30\n"
    )
    output, verifier = corrected(machine, "heidenhain", text, {"T1": {"Z": LENGTH}})
    assert verifier.passed, verifier.report()
    nominal = [m for m in klartext_path(text) if m[0] != "0" and np.isfinite(m[1]).all()]
    worst = 0.0
    for motion in (m for m in klartext_path(output) if m[0] != "0" and np.isfinite(m[1]).all()):
        for word in samples(motion):
            worst = max(worst, min(distance(word + plane.off(word), m) for m in nominal))
    assert worst < TOLERANCE + 0.0001 + machine.bounds.second_order
    assert verifier.uncorrected.deviation > 0.004


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("PLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY+0 NZ+1 TURN", "otherwise than by three angles"),
        ("PLANE SPATIAL SPA+5 SPB+0 TURN", "otherwise than by three angles"),
        ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 STAY", "does not stand across"),
        ("PLANE SPATIAL SPA+0 SPB+0 SPC+9 TURN TABLE ROT", "turns the table"),
        ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 TURN MB MAX SEQ+", "where [XYZ ]+ stands? is not known"),
        ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 MOVE SEQ+", "where [XYZ ]+ stands? is not known"),
        ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 TURN SEQ+|CYCL DEF 7.1 X+5", "a datum shift while"),
        ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 TURN SEQ+|L X+5 FMAX M91", "G53 while|M91 while"),
    ],
)
def test_plane_of_klartext_that_can_not_be_followed_is_said(lines, message, tmp_path):
    plane = Plane(5, "w-C-A-b-X-Y-Z-t")
    machine = load(plane.truth, tmp_path, "heidenhain")
    text = f"TOOL CALL 1 Z S9|L X+0 Y+0 Z+80 C+0 A+5 R0 FMAX|{lines}|L IX+20 F500|"
    with pytest.raises(ProgramError, match=message):
        corrected(machine, "heidenhain", text.replace("|", "\n"), {"T1": {"Z": LENGTH}})


def test_plane_reset_turns_the_rotary_axes_to_zero(tmp_path):
    """Behind it the program goes on as if there had been no plane: the same corrections."""
    plane = Plane(7, "w-C-A-b-X-Y-Z-t")
    machine = load(plane.truth, tmp_path, "heidenhain")
    head = "TOOL CALL 1 Z S9\nL X+0 Y+0 Z+80 C+0 A+0 R0 FMAX\n"
    tilted = "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX SEQ+\nL X+9 Y+9 Z+60 FMAX\n"
    tail = "PLANE RESET TURN FMAX\nL X+0 Y+0 Z+30 FMAX\nL X+20 Y-15 Z-3 F500\nM30\n"
    ends = []
    for text in (head + tilted + tail, head + tail):
        output, verifier = corrected(machine, "heidenhain", text, {"T1": {"Z": LENGTH}})
        assert verifier.passed, verifier.report()
        ends.append(output.split("RESET TURN FMAX\n")[1])
    assert ends[0] == ends[1]


def test_planes_stay_where_programs_are_written_out(tmp_path, capfdbinary):
    """--expand: G69 of a tilted plane stays, that of a rotation goes; CYCLE800 gets numbers for its
    variables."""
    truth = plain("w-C-A-b-X-Y-Z-t")
    fanuc = (
        "G90 G54\nG0 X0. Y0. Z50. C0. A0.\n#1=30.\nG68.2 X0. Y0. Z0. I0. J#1 K0.\nG53.1\nG1 X5."
        " F100.\nG68 X0. Y0. R90.\nX5. Y0.\nG69\nG0 A0.\nG68 X0. Y0. R90.\nX5. Y0.\nG69\nM30\n"
    )
    siemens = (
        'R1=30\nG0 X0 Y0 Z50 C0 A0\nCYCLE800(0,"T",0,57,,,,R1,,0,,,,1)\nG1 X5'
        " F100\nCYCLE800()\nM30\n"
    )
    out = {}
    for control, text in (("fanuc-mill", fanuc), ("siemens", siemens)):
        folder = truth.write(tmp_path / control, control)
        (tmp_path / "p.nc").write_text(text)
        assert main(["--machine", str(folder), "--expand", str(tmp_path / "p.nc")]) == 0
        out[control] = capfdbinary.readouterr().out.decode()
    assert out["fanuc-mill"].count("G69") == 1
    assert "J30" in out["fanuc-mill"].split("G68.2")[1].split("\n")[0]
    assert 'CYCLE800(0,"T",0,57,,,,30,,0,,,,1)' in out["siemens"]


@pytest.mark.parametrize(
    "at, turned",
    [(0.0, [(-90, -45), (90, 45), (270, -45)]), (300.0, [(270, -45), (450, 45), (90, 45)])],
)
def test_the_shortest_way_of_the_axis_nearest_to_the_part_comes_first(at, turned):
    """X + Z of the part upright: A at 45 with C at 90, or A at -45 with C at -90, and whole turns.
    From C300 the ways of C are 30, 150 and 210; from C0 two are as long, and A's decide nothing."""
    five = places.load("example-five-axis")
    position = np.zeros(5)
    position[five.letters.index("C")] = at
    found = Poses(five).aligned(np.array([1.0, 0.0, 1.0]) / np.sqrt(2), position)
    c, a = (five.letters.index(x) for x in "CA")
    assert [(round(p[c], 6), round(p[a], 6)) for p in found[:3]] == turned


def test_the_shortest_way_is_found_however_far_the_axis_has_wound():
    """0.3 0.1 0.9 lies at C 108.43 or -71.57 and whole turns, of which 3528.43 is 81.57 degrees
    from C3610 and 3708.43 is 98.43; at the end of the travel, C7200, 7128.43 lies 71.57 back and
    none beyond."""
    five = places.load("example-five-axis")
    c, position = five.letters.index("C"), np.zeros(5)
    for at, nearest in ((3610.0, [3528.435, 3708.435]), (7200.0, [7128.435, 6948.435])):
        position[c] = at
        found = Poses(five).aligned(np.array([0.3, 0.1, 0.9]) / np.sqrt(0.91), position)
        assert [round(pose[c], 3) for pose in found[:2]] == nearest


@pytest.mark.parametrize("tilt", [30.0, -75.0, 0.0])
def test_a_table_that_turns_about_the_tool_stays_and_the_other_one_tilts(tilt):
    """Of w-A-C-b-X-Y-Z-t the line of C is the tool's whatever A is, so that A alone tilts."""
    two = replace(places.load("example-five-axis"), chain=chain.parse("w-A-C-b-X-Y-Z-t"))
    position = np.zeros(5)
    a, c = (two.letters.index(x) for x in "AC")
    position[a] = tilt
    found = Poses(two).aligned(Poses(two).tool_axis(position), 0 * position)
    assert round(found[0][a], 9) == tilt and found[0][c] == 0
    assert not Poses(two).aligned(np.array([0.6, 0.0, 0.8]), 0 * position)  # A leans along Y alone
