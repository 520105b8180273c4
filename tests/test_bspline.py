"""BSPLINE of Sinumerik: what the control makes of the corrected control points, whatever its knots
and weights are, stays within the tolerance of the curve that was programmed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import BSpline

from postproc.compensate import Options, splines
from postproc.compensate.settings import Course
from postproc.errors import GcompError, ProgramError
from postproc.filter import Filter, setup_of
from postproc.machine.axis import Axis
from postproc.machine.chain import parse
from postproc.machine.file import read_machine
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from postproc.motions import SPLINE
from postproc.nc import dialects
from postproc.records import replace
from postproc.simulate.program import Reader
from postproc.units import TICKS_PER_MM, UM
from postproc.verify import Verifier
from tests.expand.test_splines import plain
from tests.small_machines import write_mill

HEAD = "G17 G90 G0 X20 Y5 Z3\nG1 X21 Y6 Z3 F500\n"
TAIL = "\nG1 X60\nM30\n"
SAMPLES = np.linspace(0.0, 1.0, 401)


@pytest.fixture(scope="module", params=[False, True], ids=["one way", "two ways"])
def mill(request, tmp_path_factory) -> Machine:
    return read_machine(write_mill(tmp_path_factory.mktemp("mills") / "mill", request.param))


def corrected(machine: Machine, text: str, tolerance: float = 1.0, cut: int = 0, **options):
    """Text, the motions of both programs that are control points with the place before them, and
    the verifier. cut: bytes that are handed over at once."""
    filter_ = Filter(
        machine, dialects.load("siemens"), setup_of(machine, {"G54": dict.fromkeys("XYZ", 0.0)}),
        Options(tolerance * UM, **options), "part.mpf",
    )  # fmt: skip
    seen = []
    filter_.watchers.append(lambda words, motions, pieces, *_: seen.append((motions, pieces)))
    verifier = Verifier(filter_)
    data = text.encode()
    size = cut or len(data)
    out = b"".join(filter_.feed(data[i : i + size]) for i in range(0, len(data), size))
    return (out + filter_.finish()).decode(), seen, verifier


def polygons(seen) -> tuple[np.ndarray, np.ndarray]:
    """Two (3, n) mm: the control points of the one spline, as programmed and as written."""
    ((motions, pieces),) = seen
    points = np.flatnonzero(pieces.code == SPLINE)
    assert (np.diff(points) == 1).all()
    motion = pieces.motion[points]
    wanted = np.concatenate([motions.start[:, motion[:1]], motions.target[:, motion]], axis=1)
    written = np.concatenate([pieces.start[:, points[:1]], pieces.end[:, points]], axis=1)
    return wanted / TICKS_PER_MM, written / TICKS_PER_MM


def curve(points: np.ndarray, weights: np.ndarray, knots: np.ndarray, degree: int) -> np.ndarray:
    """(3, K) of a NURBS."""
    both = np.vstack([points * weights, weights]).T
    found = BSpline(knots, both, degree)(SAMPLES * (1 - 1e-12) * knots[-1]).T
    return found[:3] / found[3]


def clamped(steps: np.ndarray, degree: int) -> np.ndarray:
    inner = np.concatenate([[0.0], np.cumsum(steps)])
    return np.concatenate([np.zeros(degree), inner, np.full(degree, inner[-1])])


def actual(machine: Machine, command: np.ndarray) -> np.ndarray:
    """(3, K) where the machine goes: each slide bears on the side in which it moved last."""
    way = np.sign(np.gradient(command, axis=1))
    for column in range(1, way.shape[1]):
        way[:, column] = np.where(way[:, column] == 0, way[:, column - 1], way[:, column])
    return command + machine.deviation(command, way)


def away(points: np.ndarray, path: np.ndarray) -> float:
    """mm, the largest distance of points (3, K) from a chain of lines (3, M)."""
    start, way = path[:, :-1], np.diff(path, axis=1)
    length = np.maximum((way**2).sum(axis=0), 1e-30)
    worst = 0.0
    for p in points.T:
        share = np.clip(((p[:, None] - start) * way).sum(axis=0) / length, 0.0, 1.0)
        off = np.linalg.norm(p[:, None] - start - way * share, axis=0).min()
        worst = max(worst, float(off))
    return worst


def blocks(rng: np.random.Generator, count: int, spaced: bool, monotone: bool) -> str:
    """Random control points, from X21 Y6 Z3 on."""
    steps = rng.uniform(0.4, 2.5, (count, 3)) * [1.0, 0.8, 0.5]
    steps *= float(rng.choice([1.0, 1.0, 28.0 / count]))
    steps *= 1.0 if monotone else rng.choice([-1.0, 1.0], (count, 3), p=[0.2, 0.8])
    places = np.array([21.0, 6.0, 3.0]) + np.cumsum(steps, axis=0)
    places = np.clip(places, [5, -55, -35], [195, 55, 35])
    lines = []
    for x, y, z in places:
        lines.append(f"X{x:.3f} Y{y:.3f} Z{z:.3f}" + (" PL=1.5" if spaced else ""))
    return "BSPLINE " + "\n".join(lines)


def law(machine: Machine, seed: int, spaced: bool) -> bool:
    """One random spline; whether it was accepted."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 14))
    text = HEAD + blocks(rng, count, spaced, bool(seed % 2)) + TAIL
    tolerance = float(rng.choice([0.8, 1.5, 4.0]))
    try:
        _, seen, verifier = corrected(machine, text, tolerance)
    except ProgramError as error:
        assert "B-spline" in error.message, error
        return False
    assert verifier.passed, verifier.report()
    wanted, written = polygons(seen)
    for _ in range(4):
        degree = min(int(rng.integers(2, 4)), count)
        n = wanted.shape[1]
        weights = rng.uniform(0.0001, 3.0, n)
        if spaced:
            steps = rng.uniform(0.0, 1.0, n - degree) ** 3 + 1e-6
            one = two = clamped(steps, degree)
        else:
            power = rng.uniform(0.0, 1.0)
            one, two = (spaced_by(points, degree, power) for points in (wanted, written))
        nominal = curve(wanted, weights, one, degree)
        there = actual(machine, curve(written, weights, two, degree))
        fine = float(verifier.allowed) + 1e-5  # chords of the samples
        off = (
            np.linalg.norm(there - nominal, axis=0).max()
            if spaced
            else away(there[:, ::8], nominal)
        )
        assert off <= fine, (seed, off / UM, fine / UM)
    return True


def spaced_by(points: np.ndarray, degree: int, power: float) -> np.ndarray:
    """Knots by a power of the chord length, averaged (The NURBS Book, 9.5 to 9.8)."""
    length = np.linalg.norm(np.diff(points, axis=1), axis=0) ** power
    at = np.concatenate([[0.0], np.cumsum(length)])
    n = len(at)
    inner = [at[k + 1 : k + 1 + degree].mean() for k in range(n - degree - 1)]
    return np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, at[-1])])


@pytest.mark.parametrize("spaced", [True, False], ids=["PL", "own knots"])
def test_any_knots_and_weights_stay_within_the_tolerance(mill, spaced):
    accepted = sum(law(mill, seed, spaced) for seed in range(40))
    assert accepted >= 7, accepted


@pytest.mark.parametrize("seed", range(12))
def test_any_cut_of_the_input_gives_the_same_bytes(mill, seed):
    rng = np.random.default_rng(seed)
    text = HEAD + blocks(rng, 9, bool(seed % 2), True) + TAIL

    def answer(cut: int) -> str:
        try:
            return corrected(mill, text, 1.5, cut)[0]
        except ProgramError as error:
            return f"{error.place.line} {error.message}"

    whole = answer(0)
    assert all(answer(cut) == whole for cut in (1, 17, 40))


# -- by hand ---------------------------------------------------------------------------------------


def even(slope: float, gap: float = 0.0, kink: float = 0.0) -> Machine:
    """A mill whose X goes `slope` mm/mm too far and Y loses `gap` mm when it turns; kink: mm/mm by
    which EYX rises behind X 50."""
    nodes = np.array([0.0, 50.0, 100.0])
    rows = np.zeros((6, 3))
    rows[0] = slope * nodes
    rows[1, 2] = kink * 50.0
    none = np.zeros((6, 3))
    back = none.copy()
    back[1] = gap
    tables = {
        "X": AxisTable("X", nodes, rows, rows),
        "Y": AxisTable("Y", nodes, none, back),
        "Z": AxisTable("Z", nodes, none, none),
    }
    axes = {x: Axis(x, (-10.0, 110.0), 1e-4, np.zeros(3), tables[x]) for x in "XYZ"}
    return Machine("m", "", "linuxcnc", parse("w-X-Y-b-Z-t"), axes)


STEEP = 5e-4
ZIGZAG = """G90 G17 G1 X10 Y10 Z10 F900
BSPLINE SD=2 X20 Y20 PW=2{0}
X30{0} Y40 ; up
N7 X50{0} Y20
G91 X10 Y20{0} F300
M8
X=AC(70) Y=IC(-10){0}
G90 G1 X80
M30
"""


def test_control_points_are_moved_by_their_own_correction():
    """X' = X / (1 + 5e-4); words that need no change, PW, SD, PL, F and comments stay."""
    out, seen, _ = corrected(even(STEEP), ZIGZAG.format(" PL=2"))
    wanted, written = polygons(seen)
    assert written[0] == pytest.approx(wanted[0] / (1 + STEEP), abs=6e-5)
    assert (written[1:] == wanted[1:]).all()
    lines = out.splitlines()
    assert lines[2:] == [
        "BSPLINE SD=2 X19.9900 Y20 PW=2 PL=2",
        "X29.9850 PL=2 Y40 ; up",
        "N7 X49.9750 PL=2 Y20",
        "G91 X9.9950 Y20 PL=2 F300",
        "M8",
        "X=AC(69.9650) Y=IC(-10) PL=2",
        "G90 G1 X79.9600",
        "M30",
    ]


def test_knots_that_the_control_calculates_count():
    """The map is linear, so only the knots move the curve: by 0.04 um by chord length, and by at
    most 3.2 um by any rule that spreads the intervals as the legs are strained."""
    with pytest.raises(
        ProgramError, match=r"off by 3\.2 um .*the control spaces its knots"
    ) as raised:
        corrected(even(STEEP), ZIGZAG.format(""))
    assert "write PL in each of its blocks" in raised.value.advice
    _, seen, _ = corrected(even(STEEP), ZIGZAG.format(""), 10.0)
    wanted, written = polygons(seen)
    one, two = (curve(p, np.ones(6), spaced_by(p, 3, 1.0), 3) for p in (wanted, written))
    assert away(two * np.array([[1 + STEEP], [1], [1]]), one) / UM == pytest.approx(0.04, abs=0.01)


@pytest.mark.parametrize("seed", range(20))
def test_the_bound_of_knots_holds_for_any_spacing(seed):
    """Intervals that change at random by up to a factor, as some legs have."""
    rng = np.random.default_rng(seed)
    degree, n = int(rng.integers(2, 4)), 7
    wanted = np.cumsum(rng.uniform(-9, 9, (3, n)) * [[1], [1], [0.2]], axis=1)
    legs = np.diff(wanted, axis=1) * np.where(np.arange(n - 1) == 1, 1.001, 1.0)
    written = wanted[:, :1] + np.concatenate([np.zeros((3, 1)), np.cumsum(legs, axis=1)], axis=1)
    course = Course(wanted=wanted, written=written, side=0 * wanted, spaced=np.zeros(n, bool))
    most = splines._knots(course, np.arange(degree, n)).max()
    steps, weights = rng.uniform(0.01, 1.0, n - degree), rng.uniform(0.1, 3.0, n)
    one = curve(wanted, weights, clamped(steps, degree), degree)
    for _ in range(4):
        other = steps * rng.choice([1.0, 1.001], n - degree)
        two = curve(wanted, weights, clamped(other, degree), degree)
        assert away(two[:, ::8], one) <= most + 1e-5


def test_with_weights_the_bound_of_knots_is_nearly_reached():
    """The worst that a search over turns, weights and intervals has found: 0.69 / 0.75 of it.
    Without weights no more than 0.08 / 0.75 was."""
    wanted = np.array([[0.0, 1.0, 0.971, 0.067], [0.0, 0.0, 1.0, 1.427], np.zeros(4)])
    weights = np.array([3.0, 1.66e-3, 1.36e-4, 0.67])
    steps, share, d = np.array([0.135, 0.0067, 148.0, 200.0, 59874.0]), 0.9677, 1e-4

    def point(steps: np.ndarray, at: float) -> np.ndarray:
        knots = np.concatenate([[-1.0, 0.0], np.cumsum(steps), [1e6]])
        both = np.vstack([wanted * weights, weights]).T
        found = BSpline(knots, both, 3)(knots[3] + at * steps[2])
        return found[:2] / found[3]

    here = point(steps, share)
    along = point(steps, share - 1e-6) - here
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    each = [across @ (point(steps * (1 + d * row), share) - here) for row in np.eye(5)]
    moved = max(sum(x for x in each if x > 0), -sum(x for x in each if x < 0))
    written = wanted + np.where(np.arange(4) == 0, 0.0, [[d], [0.0], [0.0]])
    course = Course(wanted=wanted, written=written, side=0 * wanted, spaced=np.zeros(4, bool))
    bound = splines._knots(course, np.array([3]))[0]
    assert 0.85 * bound < moved <= bound


def test_the_bound_of_knots_looks_at_one_span_at_a_time():
    """Where it turns by a right angle the legs are 1 mm, before they are 20: 1e-3 more of one leg
    is worth 1e-3 / 4 * 3 * 1 mm, not 20 times that."""
    way = np.array([[20.0, 20, 20, 1, 1, 1, 0], [0.0, 0, 0, 0, 0, 0, 1], np.zeros(7)])
    wanted = np.concatenate([np.zeros((3, 1)), np.cumsum(way, axis=1)], axis=1)
    written = wanted + [[0, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02], [0.0] * 8, [0.0] * 8]
    course = Course(wanted=wanted, written=written, side=0 * wanted, spaced=np.zeros(8, bool))
    assert splines._knots(course, np.arange(1, 8)) == pytest.approx([0.0] * 6 + [0.75e-3])


def test_a_kink_of_the_map_between_control_points():
    """EYX rises by 1e-3 behind X 50: a mean of X 40 and X 60 misses Y by 5 um, a mean of points
    1 mm apart by 0.25 um."""

    def text(*places: float) -> str:
        points = "\n".join(f"X{x:g} Y20 PL=1" for x in places)
        return f"G90 G17 G1 X{places[0] - 1:g} Y20 Z10 F900\nBSPLINE {points}\n{TAIL}"

    machine = even(0.0, kink=1e-3)
    with pytest.raises(ProgramError, match=r"off by 5\.\d um .*the map bends between") as raised:
        corrected(machine, text(40, 60))
    assert "more of them" in raised.value.advice
    _, seen, _ = corrected(machine, text(*np.arange(48.0, 53.0, 0.5)))
    assert polygons(seen)[1][1, -1] == pytest.approx(20 - 2.5e-3, abs=1e-4)


START = "G90 G17 G1 X10 Y10 Z10 F900\n"


def turning(lead: str) -> str:
    """A spline whose Y goes up."""
    return f"{START}{lead}\nBSPLINE X31 Y21 PL=1\nX32 Y23 PL=1\nX33 Y24 PL=1{TAIL}"


def test_lost_motion_where_an_axis_turns():
    machine = even(0.0, gap=0.004)
    with pytest.raises(ProgramError, match="a slide turns back within it or at its start") as e:
        corrected(machine, turning("G1 X30 Y20\nG1 Y19"))
    assert "lead up to it in the direction of its first leg" in e.value.advice
    corrected(machine, turning("G1 X30 Y20"))
    corrected(machine, turning("G1 X30 Y20\nG1 Y19"), reversal="mean")
    zigzag = turning("G1 X30 Y20").replace("Y23", "Y20")
    with pytest.raises(ProgramError, match="off by 4.* um .*a slide turns back"):
        corrected(machine, zigzag)
    assert "BSPLINE X31" in corrected(machine, zigzag, 5.0)[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (START + "G41 G1 X11\nBSPLINE X12 Y11\n", "with cutter radius compensation on"),
        (START + "BSPLINE X12 Y11 RND=2\n", "a corner in a block of a B-spline"),
        (START + "BSPLINE X12 Y11 I3\n", "I in a block of a B-spline"),
        (START + "BSPLINE X12 Y11\nSUPA X13\n", "a control point in machine coordinates"),
        ("G90 G17\nBSPLINE X12 Y11 Z9\n", "a B-spline that begins at an unknown place"),
        (START + "ASPLINE X12 Y11\n", "ASPLINE"),
        (START + "CSPLINE X12 Y11\n", "CSPLINE"),
    ],
)
def test_what_is_not_followed_is_refused(text, says):
    with pytest.raises(ProgramError, match=says):
        corrected(even(STEEP), text)


def test_a_spline_that_begins_where_nothing_was_corrected():
    machine = even(STEEP)
    text = "G90 G17 SUPA G0 X50 Y10 Z10\nBSPLINE X51 Y11 PL=1 F900\nX53 Y12 PL=1\n"
    with pytest.raises(ProgramError, match="it begins where no motion was corrected before"):
        corrected(machine, text)
    corrected(machine, text.replace("BSPLINE", "G1 X50 Y10 F900\nBSPLINE"))


def test_without_errors_no_byte_changes():
    assert corrected(even(0.0), ZIGZAG.format(""))[0] == ZIGZAG.format("")


def test_turned_control_points_are_written_out():
    """ROT by 90 degrees: X to Y, Y to -X; a factor may change how the control spaces knots."""
    text = "G90 G0 X0 Y0 Z5|ROT RPL=90|G1 X1 Y1 F9|BSPLINE SD=2|X2 Y1 PW=2 PL=1|G91 X1 Y2|G90 G1 X9"
    lines = plain("siemens", text)
    assert lines[3:] == [
        "BSPLINE SD=2",
        "X-1. Y2. PW=2 PL=1",
        "G91 X-2. Y1.",
        "G90 G1 X-3. Y9.",
    ]
    mirrored = plain("siemens", text.replace("ROT RPL=90", "MIRROR X0"))
    assert mirrored[4:6] == ["X-2. Y1 PW=2 PL=1", "G91 X-1. Y2"]
    with pytest.raises(ProgramError, match="BSPLINE within the programmed frame"):
        plain("siemens", text.replace("ROT RPL=90", "SCALE X2"))


def test_a_spline_is_not_simulated():
    """The simulator moves slides along lines and arcs; a control point is no place of theirs."""

    def make(machine: Machine, start: dict[str, float]) -> Filter:
        return Filter(
            machine,
            dialects.load("siemens"),
            setup_of(machine, {"G54": dict.fromkeys("XYZ", 0.0)}, start),
            Options(),
        )

    with pytest.raises(GcompError, match="where its knots are, the control knows"):
        Reader(even(STEEP), make, "part.mpf").read([ZIGZAG.format("").encode()])


def test_a_lathe_in_diameters():
    machine = even(STEEP)
    machine = replace(machine, diameter=("X",))
    out, seen, _ = corrected(machine, ZIGZAG.replace("G1 X10", "DIAMON G1 X10").format(" PL=2"))
    wanted, written = polygons(seen)
    assert wanted[0, 1] == 10.0 and written[0] == pytest.approx(wanted[0] / (1 + STEEP), abs=6e-5)
    assert "BSPLINE SD=2 X19.9900 Y20 PW=2 PL=2\n" in out


def test_a_cycle_behind_a_spline_leaves_its_code_in_force():
    """The control's motion code is modal: it was written as G1000 behind the cycle."""
    lines = plain("siemens", "G90 G17 G1 X1 Y1 Z20 F9|BSPLINE X2 Y2|CYCLE81(10,0,2,-5)|X3 Y3|G1 X9")
    assert lines[-4:] == ["G0 Z10.", "BSPLINE", "X3 Y3", "G1 X9"], lines


@pytest.mark.parametrize("first, side", [(0, -1.0), (1, 1.0), (2, 0.5)])
def test_a_spline_begins_on_the_side_of_what_was_before_it(first, side):
    """The stroke before it, or the last one of the batch before."""
    ends, spaced = np.arange(4.0)[None], [False, True, True, False]
    b = SimpleNamespace(
        carry=SimpleNamespace(sides=SimpleNamespace(side=np.array([-1]))),
        weight_end=np.array([[1.0, 0.5, -0.5, -1.0]]),
        begin_nominal=ends - 1,
        end_nominal=ends,
        begin=(ends - 1) * TICKS_PER_MM,
        end=ends * TICKS_PER_MM,
        motion=np.arange(4),
        m=SimpleNamespace(spaced=np.array(spaced)),
    )
    course = splines._joined(b, first, 4, None)
    assert course.side[0].tolist() == [side, *b.weight_end[0, first:]]
    assert course.wanted[0].tolist() == course.written[0].tolist() == [*range(first - 1, 4)]
    assert course.spaced.tolist() == [True, *spaced[first:]]
