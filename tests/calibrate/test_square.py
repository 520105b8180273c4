"""Squareness: signs by rotation matrices, and every source of it from readings of a machine that is
known."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import CalibrationError, Options, square
from postproc.calibrate.first import u_of_diagonals
from postproc.calibrate.run import calibrate
from postproc.machine.chain import parse
from postproc.recordings import Recording
from tests.calibrate.simulation import everything, recording, three_axes, two_axes

UM, URAD = 1e-3, 1e-6
XYZ = "XYZ"
REST = {"X": 80.0, "Z": 200.0}
GRINDER, MILL = parse("w-b-Z-X-t"), parse("w-X-Y-b-Z-t")


def turned(rotation: str, angle: float) -> np.ndarray:
    """Right-handed rotation matrix about an axis."""
    i = "ABC".index(rotation)
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix = np.eye(3)
    matrix[j, j] = matrix[k, k] = np.cos(angle)
    matrix[j, k], matrix[k, j] = -np.sin(angle), np.sin(angle)
    return matrix


@pytest.mark.parametrize("name", square.NAMES)
def test_the_sign_is_that_of_a_right_handed_rotation(name):
    """The leaning axis, turned by 100 urad: its point at 200 mm moves along the other axis by sign
    * 0.02 mm."""
    point = 200.0 * turned(name[0], 100e-6) @ np.eye(3)[XYZ.index(name[2])]
    other = XYZ.index(square.other_of(name))
    assert point[other] == approx(square.sign(name) * 0.02, abs=1e-9)
    assert name[0] not in square.pair_of(name)


@pytest.mark.parametrize(
    "name, leans, more_than_90",
    [
        ("C0Y", "-X", True),
        ("A0Z", "-Y", True),
        ("B0X", "-Z", True),
        ("B0Z", "+X", False),
        ("C0X", "+Y", False),
        ("A0Y", "+Z", False),
    ],
)
def test_leaning_and_the_angle_between_the_axes(name, leans, more_than_90):
    """compensation.md 3.3: C0Y = +S leans Y to -X, A0Z = +S leans Z to -Y, B0X = +S leans X to -Z,
    and B0Z = -S."""
    assert square.other_of(name) == leans[1]
    assert square.sign(name) == (-1 if leans[0] == "-" else 1)
    axis = turned(name[0], 1e-4) @ np.eye(3)[XYZ.index(name[2])]
    cosine = axis @ np.eye(3)[XYZ.index(leans[1])]
    assert (cosine < 0) == more_than_90


@pytest.mark.parametrize("name", square.NAMES)
@pytest.mark.parametrize("tilt", [0.0, 250e-6])
@pytest.mark.parametrize("over", [0.0, 40e-6])
def test_two_straightnesses_give_it_however_the_square_lies(name, tilt, over):
    """A machine with one axis leaning by 120 urad reads a square of 90 degrees + over that lies
    turned by tilt."""
    value = 120e-6
    leaning, other = XYZ.index(name[2]), XYZ.index(square.other_of(name))
    axes = {leaning: turned(name[0], value)[:, leaning], other: np.eye(3)[other]}
    # The square's arm along `leaning` opens away from the arm along `other` by `over`.
    arm = np.eye(3)[leaning] * np.cos(over) - np.eye(3)[other] * np.sin(over)
    arms = {leaning: turned(name[0], tilt) @ arm, other: turned(name[0], tilt)[:, other]}
    slopes = {}
    for moving, across in ((leaning, other), (other, leaning)):
        way = axes[moving] - arms[moving]  # what a sensor on the tool sees of the arm, per mm
        slopes[f"E{XYZ[across]}{XYZ[moving]}"] = way[across]
    found = square.with_square(name, square.from_slopes(name, slopes), over)
    assert found == approx(value, abs=2e-7)


@pytest.mark.parametrize("name", square.NAMES)
def test_two_diagonals_give_it_apart_from_the_scale(name):
    value, scale = 85e-6, 12e-6
    leaning, other = XYZ.index(name[2]), XYZ.index(square.other_of(name))
    matrix = (1 + scale) * np.eye(3)
    matrix[:, leaning] = (1 + scale) * turned(name[0], value)[:, leaning]
    slopes, directions = [], []
    for sign in (1, -1):
        n = np.zeros(3)
        n[leaning], n[other] = sign * 0.6, 0.8
        slopes.append(float(n @ (matrix @ n - n)))
        directions.append(dict(zip(XYZ, n, strict=True)))
    values, _, left = square.from_diagonals(slopes, directions, [0.0, 0.0], [name])
    assert values[name] == approx(value, abs=1e-8)
    assert left == approx(scale, abs=1e-8)


def test_four_diagonals_of_the_space_give_three():
    true = {"C0Y": 30e-6, "A0Z": -55e-6, "B0Z": 80e-6}
    matrix = np.eye(3)
    for name, value in true.items():
        matrix[:, XYZ.index(name[2])] += (
            turned(name[0], value)[:, XYZ.index(name[2])] - np.eye(3)[XYZ.index(name[2])]
        )
    directions = [
        np.array(d) / np.linalg.norm(d) for d in ((4, 3, 2), (-4, 3, 2), (4, -3, 2), (4, 3, -2))
    ]
    slopes = [float(n @ (matrix @ n - n)) for n in directions]
    named = [dict(zip(XYZ, n, strict=True)) for n in directions]
    values, _, _ = square.from_diagonals(slopes, named, [0.0] * 4, list(true))
    assert values == approx(true, abs=1e-8)


def test_one_diagonal_is_not_enough():
    with pytest.raises(CalibrationError, match="1 diagonal can not separate B0X"):
        square.from_diagonals([1e-5], [{"X": 0.6, "Z": 0.8}], [1e-7], ["B0X"])


# -- through a whole calibration -------------------------------------------------------------------


def face_diagonal(rng, machine, value: float, down: bool, runs=5, noise=0.3) -> Recording:
    """The grinder along a diagonal of X and Z, there and back: B0X = value urad."""
    share = np.tile(np.r_[np.linspace(0, 1, 15), np.linspace(1, 0, 15)], runs)
    way = np.tile(np.repeat([1, -1], 15), runs)
    x, z = 160.0 * share, 480.0 * (1 - share if down else share)
    e = np.zeros((3, len(x)))
    for i, (a, b) in enumerate(zip(x, z, strict=True)):
        one = machine["X"].lateral(way[i], np.array([a]), {})[:, 0]
        # The yaw's arm is counted from where X stood while Z was measured; here X stands at a.
        two = machine["Z"].lateral(-way[i] if down else way[i], np.array([b]), {"X": a})[:, 0]
        e[:, i] = one + two
    e[2] -= value * URAD * x
    n = np.array([160.0, 0.0, -480.0 if down else 480.0])
    n /= np.linalg.norm(n)
    reading = n @ e / UM + rng.normal(0, noise, len(x)) + rng.normal(0, 30)
    columns = {
        "X_mm": x,
        "Z_mm": z,
        "approach_X": 1.0 * way,
        "approach_Z": 1.0 * (-way if down else way),
        "reading_um": reading,
    }
    head = {"quantity": "displacement", "sensitive": {"X": n[0], "Z": n[2]}}
    return Recording("targets", head, columns, f"{'np' if down else 'pp'}.csv", np.arange(len(x)))


def without_line(machine):
    """Straightnesses whose lines are zero, so that squareness is all there is between the axes."""
    for axis in machine.values():
        for name in axis.forward:
            if name[1] in XYZ and name[1] != axis.letter:
                line = np.polyfit(axis.targets, (axis.forward[name] + axis.reverse[name]) / 2, 1)
                for side in (axis.forward, axis.reverse):
                    side[name] = side[name] - np.polyval(line, axis.targets)
    machine["Z"].measured_at = {"X": REST["X"]}
    angle = machine["Z"].forward["EBZ"], machine["Z"].reverse["EBZ"]
    at = (angle[0][0] + angle[1][0]) / 2
    machine["Z"].forward["EBZ"], machine["Z"].reverse["EBZ"] = angle[0] - at, angle[1] - at
    return machine


@pytest.mark.parametrize("trial", range(6))
def test_face_diagonals_of_a_simulated_grinder_give_its_squareness(trial):
    rng = np.random.default_rng(40 + trial)
    machine, value = without_line(two_axes(rng)), rng.normal(0, 200)
    recordings = everything(rng, machine, REST) + [
        face_diagonal(rng, machine, value, down) for down in (False, True)
    ]
    result = calibrate(recordings, Options(GRINDER))
    assert list(result.squareness) == ["B0X"]
    found = result.squareness["B0X"]
    assert found.source.startswith("diagonals")
    assert found.value / URAD == approx(value, abs=max(4 * found.u / URAD, 1.5))
    assert found.u / URAD < 1.0


def test_one_face_diagonal_says_why_it_gives_nothing():
    rng = np.random.default_rng(1)
    machine = without_line(two_axes(rng))
    recordings = [*everything(rng, machine, REST), face_diagonal(rng, machine, 50.0, False)]
    result = calibrate(recordings, Options(GRINDER))
    assert not result.squareness
    assert any("1 diagonal can not separate B0X" in f.message for f in result.findings)
    with pytest.raises(CalibrationError, match="can not be had from diagonals"):
        calibrate(recordings, Options(GRINDER, squareness={"B0X": "diagonals"}))


def on_a_square(
    rng, machine, value: float, over: float, tilt: float, turned_over: bool, **head
) -> list[Recording]:
    """Both straightnesses of the grinder against the arms of one square, as test_two_straightnesses
    has them."""
    over = -over if turned_over else over
    result = []
    for name, slope in (("EZX", -value + tilt + over), ("EXZ", -tilt)):
        axis = machine[name[2]]
        rest = {x: at for x, at in REST.items() if x != axis.letter}
        file = f"{name}{'_over' if turned_over else ''}.csv"
        one = recording(rng, axis, name, rest, aligned=True, file=file, **head)
        one.columns["reading_um"] += slope * 1e-3 * one.columns[f"{axis.letter}_mm"]
        result.append(one)
    return result


def test_a_square_that_is_turned_over_drops_out():
    rng = np.random.default_rng(9)
    machine = without_line(two_axes(rng))
    first = on_a_square(rng, machine, 120.0, 35.0, 200.0, False, reference="square 7")
    second = on_a_square(
        rng, machine, 120.0, 35.0, -80.0, True, reference="square 7", reversed=True
    )
    both = calibrate(first + second, Options(GRINDER)).squareness["B0X"]
    assert both.value / URAD == approx(120.0, abs=2.0)
    assert "+35" in both.remark or "+34" in both.remark or "+36" in both.remark
    alone = calibrate(first, Options(GRINDER)).squareness["B0X"]
    assert alone.u is None
    assert alone.value / URAD == approx(120.0 - 35.0, abs=3.0)
    known = calibrate(first, Options(GRINDER, square_error=(35e-6, 5e-6))).squareness["B0X"]
    assert known.value / URAD == approx(120.0, abs=3.0)
    assert known.u / URAD == approx(5.0, abs=1.0)


def test_straightnesses_on_different_references_say_nothing_of_squareness():
    rng = np.random.default_rng(9)
    machine = without_line(two_axes(rng))
    parts = on_a_square(rng, machine, 120.0, 0.0, 0.0, False)
    assert not calibrate(parts, Options(GRINDER)).squareness
    assert calibrate(parts, Options(GRINDER, squareness={"B0X": "straightness"})).squareness


def test_a_stated_value_goes_before_the_others_which_are_compared_with_it():
    rng = np.random.default_rng(3)
    machine = without_line(two_axes(rng))
    recordings = everything(rng, machine, REST) + [
        face_diagonal(rng, machine, 100.0, down) for down in (False, True)
    ]
    # u of what they differ by is 5 urad, the stated one's: 2 u are between 8 and 13
    for stated, level in ((100.0, "note"), (108.0, "note"), (113.0, "doubt"), (160.0, "doubt")):
        result = calibrate(
            recordings, Options(GRINDER, squareness={"B0X": (stated * URAD, 5 * URAD)})
        )
        assert result.squareness["B0X"].value == stated * URAD
        told = [f for f in result.findings if f.check == "squareness"]
        assert [f.level for f in told] == [level]
        assert told[0].numbers["apart_urad"] == approx(100.0 - stated, abs=3.0)


def test_axes_of_a_mill_are_named_as_usual_and_as_the_user_wants():
    assert [square.name_for(p, {}, ("X", "Y", "Z")) for p in ("XY", "YZ", "XZ")] == [
        "C0Y",
        "A0Z",
        "B0Z",
    ]
    assert square.name_for("XZ", {}, ("Z", "X")) == "B0X"
    assert square.name_for("XY", {"C0X": 1}, ("X", "Y", "Z")) == "C0X"
    rng = np.random.default_rng(3)
    machine = three_axes(rng)
    parts = [
        recording(rng, machine[n[2]], n, {x: 0.0 for x in XYZ if x != n[2]}, reference="s")
        for n in ("EXY", "EYX")
    ]
    assert list(calibrate(parts, Options(MILL)).squareness) == ["C0Y"]


def test_u_of_two_diagonals_is_that_of_their_formula_by_differences():
    """JCGM 100, 5.1.2, of a frame so oblique that the sides count, too."""
    lengths, step = np.array([520.0, 480.0, 400.0, 300.0]), 1e-3

    def skew(x):
        return (x[0] ** 2 - x[1] ** 2) / (4 * x[2] * x[3])

    slopes = [(skew(lengths + d) - skew(lengths - d)) / (2 * step) for d in step * np.eye(4)]
    found = u_of_diagonals(520.0, 480.0, (400.0, 300.0), 0.01)
    assert found == approx(0.01 * np.linalg.norm(slopes), rel=1e-6)


def test_the_square_of_single_readings_has_no_u():
    """One run and no u_um: nothing says how far either line may be off, and 0 is no answer."""
    rng = np.random.default_rng(9)
    machine = without_line(two_axes(rng))
    parts = on_a_square(rng, machine, 120.0, 35.0, 200.0, False, reference="square 7", runs=1)
    options = Options(GRINDER, square_error=(35e-6, 5e-6))
    found = calibrate(parts, options).squareness["B0X"]
    assert found.value / URAD == approx(120.0, abs=3.0) and found.u is None


def test_diagonals_of_two_places_have_no_u():
    """A height and a slope go through two readings: none is left to tell how well."""
    rng = np.random.default_rng(3)
    machine = without_line(two_axes(rng))
    diagonals = []
    for down in (False, True):
        one = face_diagonal(rng, machine, 100.0, down, runs=1)
        up = np.flatnonzero(one.approach("X") > 0)
        diagonals.append(one.pick(up[[0, -1]]))
    found = calibrate(everything(rng, machine, REST) + diagonals, Options(GRINDER))
    assert found.squareness["B0X"].value / URAD == approx(100.0, abs=10.0)
    assert found.squareness["B0X"].u is None
