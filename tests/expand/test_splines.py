"""Splines and NURBS written out as straight lines: LinuxCNC's on its own interpreter, which samples
the curve itself; the curves themselves against scipy's B-splines."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.cycles.curve import Curve, uniform
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import ours
from tests.linuxcnc.test_expanded import written_out

TOLERANCE = 0.001  # mm, of the resolver when nobody says it
NURBS = "G0 X1 Y2|G5.2 P1 L3|X0 Y1 P1|X2 Y2 P1|X3 Y0 P2|X5 Y5 P1|G5.3|G1 X6 Y6"
PROGRAMS = {
    "cubic": "G5 X10 Y10 I3 J0 P0 Q-3|G5 X20 Y5 I0 J3 P-3 Q0|G1 X0",
    "cubic goes on": (
        "G5 X10 Y10 I3 J0 P0 Q-3|G5 X20 Y5 P-3 Q0|G0 X0 Y0|G5 X9 Y9 P1 Q1|G5 Y12 P1 Q1|G1 X3"
    ),
    "quadratic": "G5.1 X10 Y0 I5 J5|G5.1 X20 Y5 I5 J-5|G1 X0 Y0",
    "inch": "G20 G0 X1|G5.1 X2 Y1 I.5 J.5|G5 X3 Y3 I0 J1 P0 Q-1",
    "incremental": "G91 G0 X1 Y1|G5.1 X2 Y1 I.5 J.5|G5 X3 Y3 I0 J1 P0 Q-1",
    "diameter": (
        "G7 G0 X4 Y1|G5.1 X12 Y1 I1.5 J4|G5 X3 Y3 I0 J1 P0 Q-1|G90|G5.2 X8 Y2 P1 L3|X6 Y9 P2|X-4 Y2"
        " P1|G5.3"
    ),
    "incremental nurbs": "G91 G0 X1 Y1|G5.2 X0 Y1 P1 L3|X2 Y0 P1|X1 Y1 P1|G5.3|G1 X1 Y1",
    "nurbs": NURBS,
    "nurbs, code in each line": (
        "G5.2 X0 Y1 P1 L3|G5.2 X2 Y2 P1 L4|F90|G5.2 X3 Y0 P1|G5.2 X4 Y0 P2|G5.3"
    ),
    "order below 3": "G5.2 P2 L2|X0 Y1 P1|X2 Y2 P1|X3 Y0 P2|G5.3",
    "order 5": "G5.2 P2 L5|X0 Y1 P1|X2 Y2 P1|X3 Y0 P2|X4 Y4 P1|X7 Y2 P.5|X9 Y9 P3|G5.3",
    "turned": (
        "G10 L2 P1 R30|G0 X2 Y1|G5.1 X10 Y0 I5 J5|G5.2 X12 Y1 P1 L3|X16 Y2 P1|X19 Y-4 P1|G5.3"
    ),
    "shifted": "G10 L2 P2 X5 Y7 Z1|G55|G0 X2 Y1 Z3|G92 X1|G5.1 X10 Y0 I5 J5|G1 X0",
}


@pytest.fixture(scope="module")
def theirs():
    if reason := oracle.available():
        pytest.skip(reason)
    texts = [text_of(program) for program in PROGRAMS.values()]
    return dict(zip(PROGRAMS, oracle.motions_of_many([(text, {}) for text in texts]), strict=True))


def text_of(program: str) -> str:
    return "F100\n" + program.replace("|", "\n") + "\nM2\n"


def away(points: np.ndarray, path: np.ndarray) -> float:
    """The largest distance of points from a chain of lines."""
    starts, ways = path[:-1], np.diff(path, axis=0)
    lengths = (ways**2).sum(axis=1)
    worst = 0.0
    for p in points:
        share = np.clip(
            ((p - starts) * ways).sum(axis=1) / np.where(lengths > 0, lengths, 1.0), 0.0, 1.0
        )
        worst = max(worst, float(np.linalg.norm(p - starts - share[:, None] * ways, axis=1).min()))
    return worst


@pytest.mark.parametrize("name", PROGRAMS)
def test_lines_lie_on_linuxcncs_own_curve(name, theirs):
    made = theirs[name]
    assert isinstance(made, list), made
    mine = ours(written_out(text_of(PROGRAMS[name]), {}), {})
    assert all(m["kind"] in ("feed", "rapid") and not m["reason"][0] for m in mine)
    path = np.array([[0.0, 0, 0], *[m["end"][:3] for m in mine]])
    points = np.array([m.end[:3] for m in made])
    assert away(points, path) <= TOLERANCE  # its points lie on the curve
    sampled = np.vstack([np.zeros(3), points])
    # and ours near its chords, which are long: of 60 samples a curve
    assert away(path, sampled) <= 0.2
    assert path[-1] == pytest.approx(points[-1], abs=1e-8)


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("G18|G5.1 X1 Y1 I1 J1", "G5.1 outside the XY plane"),
        ("G5 X1 Y1 I1 P1 Q1", "G5 without its poles"),
        ("G5 X1 Y1 I1 J1", "G5 without its poles"),
        ("G5.1 X1 Y1 I1", "G5.1 without I and J"),
        ("G5.1 X1 Y1 I1 J1|X2", "no motion code is named behind the cycle"),
        ("G5.1 X1 Y1 Z2 I1 J1", "Z in a quadratic spline (G5.1): that is no word of it"),
        ("G5.2 X1 Y1 L3", "a control point without a weight P above 0"),
        ("G5.2 X1 P1 L3", "a control point with one of X and Y"),
        ("G5.2 X1 Y1 P1|G1 X2", "a motion code between G5.2 and G5.3"),
        ("G5.2 X1 Y1 P1|G5.3", "a NURBS of order 3 with 2 control points"),
        ("G5.2 X1 Y1 P1|G5.1 X1 Y1 I1 J1", "G5.1 between G5.2 and G5.3"),
        ("G5.2 X1 Y1 P1|G92 X5|X2 Y1 P1|X3 Y3 P1|G5.3", "moved between G5.2 and G5.3"),
        ("G5.3", "G5.3 without G5.2"),
        ("G93 G5.1 X1 Y1 I1 J1 F2", "with inverse time feed"),
    ],
)
def test_what_is_no_spline_is_refused(program, says):
    with pytest.raises(ProgramError, match=says.replace("(", r"\(").replace(")", r"\)")):
        written_out(text_of(program), {})


@pytest.mark.parametrize("order", [2, 3, 4, 5])
@pytest.mark.parametrize("more", [0, 1, 4])
def test_lines_stay_within_the_tolerance_of_the_curve(order, more):
    random = np.random.default_rng(order * 10 + more)
    count = order + more
    poles, weights = random.normal(size=(count, 3)) * 10, random.uniform(0.3, 3.0, count)
    inner = np.sort(random.uniform(1.0, 4.0, more))
    inner[1:2] = inner[0:1] if order > 2 else inner[1:2]  # a double knot
    knots = np.concatenate([np.zeros(order), inner, np.full(order, 5.0)])
    for curve in (Curve(poles, weights, knots, order), uniform(poles, weights, order)):
        spline = BSpline(
            curve.knots, np.column_stack([poles * weights[:, None], weights]), order - 1
        )
        places = spline(np.linspace(0.0, curve.knots[-1] - 1e-12, 2000))
        places = places[:, :3] / places[:, 3:]
        lines = np.vstack([poles[0], curve.points(1e-3, 3)])
        assert away(places, lines) <= 1e-3
        assert away(lines, places) <= 5e-2  # the samples' own chords
        assert lines[-1] == pytest.approx(poles[-1])


# -- other controls: the curve's own formula -------------------------------------------------------


def plain(name: str, program: str, axes: str = "XYZ") -> list[str]:
    """The lines that a program becomes, of a machine that stands at zero."""
    setup = Setup(
        axes=tuple(axes), least_increment=dict.fromkeys(axes, 1e-3), offsets={"G54": {}},
        start=dict.fromkeys(axes, 0.0),
    )  # fmt: skip
    written = Written(
        Program("part", program.replace("|", "\n").encode()),
        Interpreter(dialects.load(name), setup),
        Limits(),
    )
    return b"".join(written).decode().split("\n")


def ends(lines: list[str], letters: str, at: tuple[float, ...]) -> np.ndarray:
    """Where each line ends, all of them absolute."""
    places, here = [at], dict(zip(letters, at, strict=True))
    for line in lines:
        for word in line.split():
            if word[0] in here:
                here[word[0]] = float(word[1:])
        places.append(tuple(here.values()))
    return np.array(places)


def cubic(t: np.ndarray, *poles: tuple[float, ...]) -> np.ndarray:
    """Bernstein's form."""
    a, b, c, d = (np.array(p)[:, None] for p in poles)
    return ((1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d).T


def test_marlins_curve_with_filament():
    lines = plain(
        "marlin", "M82|G0 X1 Y1 Z1|G5 X10 Y9 Z3 I3 J1 Q-3 E1.5 F1000 ; curve|G1 X0", "XYZE"
    )
    assert lines[2].endswith("F1000 ; curve") and all(x.startswith("G1 ") for x in lines[2:])
    path = ends(lines[2:-1], "XYZE", (1.0, 1.0, 1.0, 0.0))
    t = np.linspace(0.0, 1.0, 500)
    wanted = cubic(t, (1, 1, 1), (4, 2, 1 + 2 / 3), (10, 6, 1 + 4 / 3), (10, 9, 3))
    # the tolerance, and the numbers' last digit
    assert away(wanted, path[:, :3]) <= TOLERANCE + 0.001
    assert path[-1] == pytest.approx((10, 9, 3, 1.5), abs=1e-9)
    share = (path[:, 2] - 1) / 2  # Z goes evenly with the parameter, and so does E
    assert path[:, 3] == pytest.approx(1.5 * share, abs=0.0005)


@pytest.mark.parametrize("mode", ["M83", "G91"])
def test_filament_as_distances_adds_up(mode):
    lines = plain("marlin", f"G0 X0 Y0|{mode}|G5 X10 Y9 I3 J1 Q-3 E.12345|G5 X4 Y9 E.2", "XYZE")
    fed = [float(x.split("E")[1]) for x in lines if "E" in x]
    assert len(fed) > 50 and sum(fed) == pytest.approx(0.32345, abs=1e-9)


CONIC = "G6.2 P3 K0. X0. Y0. R1. F500.|K0. X5. Y0. R.70710678|K0. X5. Y5. R1.|K1.|K1.|K1.|G1 X9."


def test_fanucs_nurbs_makes_an_exact_quarter_of_a_circle():
    """Weights 1, sqrt(1/2), 1 over a right angle make a circle (L. Piegl, W. Tiller: The NURBS
    Book, 7.3)."""
    lines = plain("fanuc-mill", "G90 G0 X0. Y0.|" + CONIC)
    path = ends([x for x in lines if x and x != "F500."][1:-1], "XY", (0.0, 0.0))
    assert np.hypot(*(path - [0.0, 5.0]).T) == pytest.approx(5.0, abs=0.001)
    assert path[-1] == pytest.approx((5.0, 5.0)) and lines[-1] == "G1 X9."
    assert len(path) > 20


def test_fanucs_knots_and_weights_against_the_formula():
    """The definition of the manual: the basis functions of de Boor and Cox."""
    knots = [0.0, 0, 0, 0, 1, 2.5, 4, 4, 4, 4]
    poles = np.array([(0, 0, 0), (5, 0, 1), (9, 7, 2), (2, 9, 0), (0, 4, -1), (-6, -2, 3)], float)
    weights = np.array([1, 2, 0.5, 1, 3, 1.0])
    points = [
        f"K{k:.1f} X{p[0]} Y{p[1]} Z{p[2]} R{w}"
        for k, p, w in zip(knots, poles, weights, strict=False)
    ]
    program = "|".join(
        ["G90 G0 X0. Y0. Z0.", "G6.2 " + points[0], *points[1:], *(f"K{k:.1f}" for k in knots[6:])]
    )
    lines = plain("fanuc-mill", program)
    path = ends(lines[1:], "XYZ", (0.0, 0.0, 0.0))
    spline = BSpline(knots, np.column_stack([poles * weights[:, None], weights]), 3)
    wanted = spline(np.linspace(0.0, 4.0 - 1e-12, 1000))
    assert away(wanted[:, :3] / wanted[:, 3:], path) <= TOLERANCE + 0.001
    # the start and its knot left out
    shorter = program.replace("G6.2 K0.0 X0.0 Y0.0 Z0.0 R1.0", "G6.2 R1.0")
    assert plain("fanuc-mill", shorter) == lines


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            ("X0. Y0. R1.", "X1. Y0. R1."),
            "the first control point has X1, and the tool stands at X0",
        ),
        (("K0. X5. Y0.", "X5. Y0."), "a block of a NURBS without a knot K"),
        (
            ("K0. X5. Y0. R.70710678", "K0. X5. Y0."),
            "some control points have a weight R and others have none",
        ),
        (("|K1.|K1.|K1.", "|K1.|K1."), "the NURBS ends with 3 control points and 5 knots"),
        (("|K1.|K1.|K1.", "|K1.|K1|K1."), "some knots K have a decimal point and others have none"),
        (
            ("|K1.|K1.|K1.", "|K1.|K1.|K2."),
            "the knots of the NURBS do not go up from 3 equal ones to 3 equal ones",
        ),
        (("P3", "P5"), "P5 is no rank of a NURBS"),
        (("G6.2", "G91 G6.2"), "G6.2 in G91"),
        (("X5. Y5. R1.", "X5. Z5. R1."), "a control point that names other axes"),
        (("G1 X9.", "X9."), "no motion code is named behind the cycle"),
        (("R.70710678", "R-1."), "a weight R that is not above 0"),
    ],
)
def test_what_is_no_nurbs_is_refused(change, says):
    with pytest.raises(ProgramError, match=says):
        plain("fanuc-mill", "G90 G0 X0. Y0.|" + CONIC.replace(*change))
