"""BSPLINE of Sinumerik written out as straight lines: the curve of scipy's B-splines, by the knots
that PL leaves no doubt of."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.interpolate import BSpline

from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.knots_siemens import intervals
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup
from tests.expand.test_splines import away

TOLERANCE = 1e-3  # mm, of the resolver when nobody says it
START = "G90 G17 G0 X1 Y2 Z3|G1 X1 Y2 F100|"


def written_out(program: str, axes: str = "XYZ", **options) -> tuple[list[str], Written]:
    """Plain lines of a program on a machine that stands at zero, and what wrote them."""
    setup = Setup(
        axes=tuple(axes), least_increment=dict.fromkeys(axes, 1e-4), offsets={"G54": {}},
        start=dict.fromkeys(axes, 0.0), **options,
    )  # fmt: skip
    text = (program + "|").replace("|", "\n").encode()
    written = Written(
        Program("part.mpf", text), Interpreter(dialects.load("siemens"), setup), Limits()
    )
    return b"".join(written).decode().split("\n")[:-1], written


def places(lines: list[str], axes: str = "XYZ") -> np.ndarray:
    """(N, A) where the motions of plain lines end, X of a diameter as it is written."""
    here, found, by = dict.fromkeys(axes, 0.0), [], False
    for line in lines:
        by = "G91" in line if re.search("G9[01]", line) else by
        words = re.findall(r"([XYZ])(-?[0-9.]+)", line)
        here |= {x: float(v) + here[x] * by for x, v in words}
        found += [list(here.values())] * bool(words)
    return np.array(found)


def curve(poles: np.ndarray, weights: np.ndarray, steps: np.ndarray, degree: int) -> np.ndarray:
    """(K, D) of a NURBS that begins and ends in its first and last pole."""
    inner = np.concatenate([[0.0], np.cumsum(steps)])
    knots = np.concatenate([np.zeros(degree), inner, np.full(degree, inner[-1])])
    both = np.column_stack([poles * weights[:, None], weights])
    found = BSpline(knots, both, degree)(np.linspace(0.0, inner[-1] * (1 - 1e-12), 1501))
    return found[:, :-1] / found[:, -1:]


# -- by hand ---------------------------------------------------------------------------------------


def test_three_points_of_degree_2_are_a_parabola():
    """From X0 Y0 by X10 Y10 to X20 Y0: Y = X (20 - X) / 20."""
    lines, _ = written_out(
        "G90 G1 X0 Y0 F9|N1 BSPLINE SD=2 X10 Y10 PL=7 F50|N2 X20 Y0 PL=7 ; end|G1 X9"
    )
    assert lines[1] == "N1 F50" and lines[2].startswith("N2 G1 X") and lines[2].endswith(" ; end")
    assert lines[-1] == "G1 X9" and not any("PL" in x or "SPLINE" in x for x in lines)
    x, y, _ = places(lines[2:-1]).T
    assert y == pytest.approx(x * (20 - x) / 20, abs=3e-6) and x[-1] == 20 and len(x) > 20


def test_the_middle_of_a_uniform_cubic_is_a_quarter_a_half_and_a_quarter():
    """Of five points with two equal intervals it is (P1 + 2 P2 + P3) / 4 = X30 Y15."""
    polygon = "BSPLINE X20 Y20 PL=1|X30 Y10 PL=1|X40 Y20 PL=1|X60 Y0 PL=1"
    lines, _ = written_out("G90 G1 X0 Y0 F9|" + polygon)
    assert [30.0, 15.0, 0.0] in places(lines).tolist()


# -- laws ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(24))
def test_the_lines_leave_the_curve_by_the_tolerance_at_most(seed):
    """Random points, weights and intervals; the values of PL that are left over are 0 at either
    end, or all are alike."""
    rng = np.random.default_rng(seed)
    degree = int(rng.integers(2, 4))
    count = int(rng.integers(degree, 9))
    poles = np.array([1.0, 2.0, 3.0]) + np.vstack(
        [np.zeros(3), np.cumsum(rng.uniform(-9, 9, (count, 3)).round(3), axis=0)]
    )
    weights = np.ones(count + 1)
    spans = count + 1 - degree
    steps = np.full(spans, 2.0) if seed % 4 == 0 else rng.uniform(0.2, 5.0, spans).round(3)
    first = int(rng.integers(0, degree))
    lengths = np.concatenate([np.zeros(first), steps, np.zeros(degree - 1 - first)])
    if seed % 4 == 0:
        lengths[:] = 2.0
    if seed % 3 == 0:
        weights[1:] = rng.uniform(0.3, 3.0, count).round(3)
    mode = "G91 " if seed % 5 == 0 else ""
    words = np.diff(poles, axis=0) if mode else poles[1:]
    blocks = [
        f"X{x:.3f} Y{y:.3f} Z{z:.3f} PL={length:g}" + (f" PW={w:g}" if seed % 3 == 0 else "")
        for (x, y, z), length, w in zip(words, lengths, weights[1:], strict=True)
    ]
    text = f"{START}{mode}BSPLINE SD={degree} " + "|".join(blocks) + "|G90 G1 X0"
    lines, written = written_out(text)
    assert not written.splines.kept, written.splines.kept
    path = places(lines)[1:-1]
    assert away(curve(poles, weights, steps, degree), path) <= TOLERANCE + 1e-6
    assert path[-1] == pytest.approx(poles[-1], abs=1e-6)


@pytest.mark.parametrize(
    ("lengths", "degree", "shares"),
    [
        ([1, 1, 1, 1], 3, [0.5, 0.5]),
        ([1, 1, 1, 1], 2, [1 / 3, 1 / 3, 1 / 3]),
        ([3, 7, 5], 3, [1.0]),  # one interval: any
        ([0, 30, 0], 3, [1.0]),  # CATIA's example
        ([1, 3, 0, 0], 3, [0.25, 0.75]),
        ([0, 1, 3, 0], 3, [0.25, 0.75]),
        ([0, 0, 1, 3], 3, [0.25, 0.75]),
        ([1, 3, 0], 2, [0.25, 0.75]),
        ([1, 2, 1, 2], 3, None),  # 1 to 2, or 2 to 1
        ([1, 2, 4, 8], 3, [1 / 3, 2 / 3]),  # all runs alike
        ([1, 1, 1, 2], 3, None),
        ([1, 0, 1, 0, 0], 3, None),  # a knot that stands twice
        ([0, 0, 0, 0], 3, None),
        ([1, None, 1, 1], 3, None),
        ([1, -1, 1, 1], 3, None),
    ],
)
def test_which_intervals_leave_no_doubt(lengths, degree, shares):
    found = intervals(lengths, degree)
    assert found is None if shares is None else found == pytest.approx(shares)


# -- modes -----------------------------------------------------------------------------------------


def test_inches_and_diameters():
    """The same parabola in inch, and with X as a diameter on a lathe."""
    program = "G90 G1 X0 Y0 F9|BSPLINE SD=2 X10 Y10 PL=7|X20 Y0 PL=7"
    inch, _ = written_out("G70 " + program.replace("G1", "G1 Z0"))
    x, y, _ = places(inch[1:]).T
    assert y == pytest.approx(x * (20 - x) / 20, abs=3e-6)
    assert len(inch) > 3 * len(written_out(program)[0])  # of 25.4 times its size
    turned, _ = written_out(
        "DIAMON G18 G90 G1 X0 Z0 F9|BSPLINE SD=2 X20 Z10 PL=7|X40 Z0 PL=7", "XZ"
    )
    x, z = places(turned[1:], "XZ").T
    assert z == pytest.approx(x / 2 * (20 - x / 2) / 20, abs=3e-6) and x[-1] == 40


def test_a_frame_turns_the_points_first():
    """ROT by 90 degrees: X to Y, Y to -X."""
    program = "G90 G1 X0 Y0 F9|ROT RPL=90|BSPLINE SD=2 X10 Y10 PL=7|X20 Y0 PL=7|ROT|G1 X1"
    lines, written = written_out(program)
    assert not written.splines.kept
    x, y, _ = places(lines[:-1]).T
    assert -x == pytest.approx(y * (20 - y) / 20, abs=3e-6) and y[-1] == 20


def test_expressions_and_loops_come_first():
    program = (
        "R1=7|G90 G1 X0 Y0 F9|BSPLINE SD=2|FOR R2=1 TO 2|X=R2*10 Y=20-R2*10 PL=R1|ENDFOR|G1 X1"
    )
    lines, written = written_out(program)
    assert not written.splines.kept
    x, y, _ = places(lines[:-1]).T
    assert y == pytest.approx(x * (20 - x) / 20, abs=3e-6) and x[-1] == 20


# -- what stays as it is ---------------------------------------------------------------------------

POLYGON = "BSPLINE X10 Y10 PL=1|X20 Y0 PL=1|X30 Y5 PL=1|X40 Y0 PL=1"


@pytest.mark.parametrize(
    ("polygon", "why"),
    [
        (POLYGON.replace("Y0 PL=1", "Y0 PL=2", 1), "its PL leave open where"),
        (POLYGON.replace("Y0 PL=1", "Y0", 1), "its PL leave open where"),
        (POLYGON.replace("PL=1", "PL=1 PW=2", 1), "PW stands in some"),
        (POLYGON.replace("PL=1", "PL=1 PW=0"), "PW stands in some"),
        (POLYGON.replace("X10", "SD=4 X10"), "SD is not 2 or 3"),
        ("BSPLINE X10 Y10 PL=1|X20 Y0 PL=1", "its PL leave open where"),
        (POLYGON.replace("X20 Y0", "X10 Y10"), "a control point stands twice"),
        (POLYGON.replace("X10 Y10", "X1 Y2"), "a control point stands twice"),
        (POLYGON.replace("|X40", "|M8|X40"), "more than control points"),
        (POLYGON.replace("|X20", "|G64 X20"), "more than control points"),
        (POLYGON.replace("|X20", "|/X20"), "more than control points"),
        (POLYGON.replace("|X20", "|SUPA X20"), "more than control points"),
        (POLYGON.replace("|X40", "|TRANS X9|X40"), "more than control points"),
        ("G93|" + POLYGON.replace("X10", "F3 X10"), "G93 or DIAM90"),
        ("DIAM90|" + POLYGON, "G93 or DIAM90"),
    ],
)
def test_a_spline_that_leaves_a_doubt_stays(polygon, why):
    lines, written = written_out(START + polygon + "|G1 X0")
    assert "|".join(lines) == START + polygon + "|G1 X0"
    reasons = {reason.why for reason in written.splines.kept.values()}
    assert len(reasons) == 1 and why in reasons.pop()
    assert len(written.splines.kept) == polygon.count("|") + 1 - polygon.startswith(
        ("G93", "DIAM90")
    )


@pytest.mark.parametrize("delete", [True, False])
@pytest.mark.parametrize("block", ["/G1 X5", "/X5"])
def test_a_block_that_may_be_stepped_over_ends_no_spline(block, delete):
    """With block delete on "/G1 X5" is no block: what comes behind it is a control point."""
    program = START + POLYGON.replace("|X40", f"|{block}|X40") + "|G1 X0"
    lines, written = written_out(program, block_delete=delete)
    assert "|".join(lines) == program and len(written.splines.kept) == 5
    lines, _ = written_out(START + "/" + POLYGON + "|G1 X0", block_delete=True)
    assert "X20 Y0 PL=1" in lines


def test_without_known_start_it_stays():
    program = "G90 G54 G1 F9 SUPA X5|" + POLYGON
    setup = Setup(axes=("X", "Y"), least_increment={"X": 1e-4, "Y": 1e-4}, offsets={"G54": {}})
    written = Written(
        Program("part.mpf", program.replace("|", "\n").encode()),
        Interpreter(dialects.load("siemens"), setup),
        Limits(),
    )
    assert b"".join(written).decode().split("\n") == program.split("|")
    assert all("an unknown place" in x.why for x in written.splines.kept.values())


def test_what_ends_a_spline():
    """Another motion code, the end of the program, and the end of its text."""
    for end in ("|G1 X0", "|M30", "|M8|X0 G0 Y0|BSPLINE X1 Y1|G0 X9", "", "|TRANS|; end"):
        lines, _ = written_out(START + POLYGON + end)
        assert "|".join(lines).endswith("X40. Y0." + end), lines[-3:]


def test_lines_come_from_the_block_of_the_last_control_point_of_their_span():
    lines, written = written_out(START + POLYGON + "|G1 X0")
    own = [written.source(n)[0] for n in range(1, len(lines) + 1)]
    assert own == sorted(own) and set(own) == {1, 2, 5, 6, 7}
