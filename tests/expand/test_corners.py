"""RND, CHF, CHR and RNDM of Sinumerik: arcs that touch both lines, chamfers of the length that
their words say."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from postproc.errors import ProgramError
from postproc.nc import dialects
from postproc.nc.expand import Limits, Program
from postproc.nc.expand.written import Written
from postproc.nc.interpreter import Interpreter
from postproc.nc.state import Setup


def turn(a: np.ndarray, b: np.ndarray) -> float:
    """The sine of the angle from one direction to another, times their lengths; + to the left."""
    return a[0] * b[1] - a[1] * b[0]


def plain(program: str, diameter: frozenset[str] = frozenset()) -> list[str]:
    setup = Setup(
        axes=("X", "Y", "Z"), least_increment=dict.fromkeys("XYZ", 1e-4), offsets={"G54": {}},
        start=dict.fromkeys("XYZ", 0.0), diameter=diameter,
    )  # fmt: skip
    text = (program + "|M30|").replace("|", "\n").encode()
    written = Written(
        Program("part.mpf", text), Interpreter(dialects.load("siemens"), setup), Limits()
    )
    return b"".join(written).decode().split("\n")[:-2]


@pytest.mark.parametrize(
    ("program", "lines"),
    [
        # A right angle: 5 before the corner and behind it.
        ("G1 X50 RND=5 F100|Y40", ["G1 X45. F100", "G3 X50. Y5. I0. J5.", "G1 Y40."]),
        ("G1 X50 RND=5 F100|Y-40", ["G1 X45. F100", "G2 X50. Y-5. I0. J-5.", "G1 Y-40."]),
        # CHR counts from the corner, CHF is the chamfer's own length: 4 sqrt(2) long, 4 from the
        # corner.
        ("G1 X50 CHR=4|Y40", ["G1 X46.", "G1 X50. Y4.", "Y40."]),
        (f"G1 X50 CHF={4 * math.sqrt(2)}|Y40", ["G1 X46.", "G1 X50. Y4.", "Y40."]),
        # What only switches stands behind the corner; a comment stays where it is.
        (
            "N1 G1 X50 RND=5 ; round|N2 M8|N3 Y40",
            ["N1 G1 X45. ; round", "G3 X50. Y5. I0. J5.", "N2 M8", "N3 G1 Y40."],
        ),
        # Distances, places among them, and an axis word with "=".
        ("G91 G1 X50 RND=5|Y40", ["G91 G1 X45.", "G3 X5. Y5. I0. J5.", "G1 Y35."]),
        ("G1 X=50 CHR=4|Y=IC(40)", ["G1 X=46.", "G1 X50. Y4.", "Y=IC(36.)"]),
        # RNDM holds until 0, and none is made where a line goes straight on or the program ends.
        (
            "G1 X10 RNDM=1|X20|Y10|X30 RNDM=0|Y20",
            [
                "G1 X10",
                "X19.",
                "G3 X20. Y1. I0. J1.",
                "G1 Y9.",
                "G2 X21. Y10. I1. J0.",
                "G1 X30.",
                "Y20",
            ],
        ),
        ("G1 X50 RND=5", ["G1 X50"]),
        # ANG: from the first axis of the plane, 30 degrees up over 20 and 120 degrees over -10
        ("G1 X20 ANG=30|ANG=120 X10", ["G1 X20 Y11.547005", "Y28.867513 X10"]),
        ("G91 G1 Y5 ANG=135|X5 ANG=0", ["G91 G1 Y5 X-5.", "X5 Y0."]),
        ("G1 X10 ANG=0 RND=2|Y10 ANG=90", ["G1 X8. Y0.", "G3 X10. Y2. I0. J2.", "G1 Y10. X10."]),
        ("G18|G1 X10 ANG=150", ["G18", "G1 X10 Z-8.660254"]),
        # G18 of a lathe: the plane is Z X, X a diameter, from Z to X is against the clock.
        (
            "G18|G1 Z-20 RND=2|X30",
            ["G18", "G1 Z-18.", "G2 Z-20. X4. K0. I2.", "G1 X30."],
        ),
    ],
)
def test_a_corner_is_what_its_words_say(program, lines):
    found = plain(program, frozenset("X") if "G18" in program else frozenset())
    assert found == lines


@pytest.mark.parametrize("seed", range(20))
def test_arcs_touch_both_lines_and_chamfers_have_their_length(seed):
    random = np.random.default_rng(seed)
    kind = ["RND", "CHF", "CHR"][seed % 3]
    size = float(random.uniform(0.2, 1.0))
    angles = np.cumsum(random.uniform(0.1, 2.8, 8) * random.choice([-1, 1], 8))
    ways = np.column_stack([np.cos(angles), np.sin(angles)]) * random.uniform(15, 30, (8, 1))
    places = np.cumsum(ways, axis=0)
    texts = [f"X{x:.6f} Y{y:.6f}" for x, y in places]
    lines = plain(
        "G1 F100|" + "|".join(t + f" {kind}={size:.6f}" for t in texts[:-1]) + "|" + texts[-1]
    )[1:]
    assert len(lines) == 2 * len(places) - 1
    here, ends = np.zeros(2), []
    for line in lines:
        word = {m[0]: float(m[1]) for m in re.findall(r"([XYIJG])(-?[\d.]+)", line)}
        to = np.array([word.get("X", here[0]), word.get("Y", here[1])])
        ends.append(
            (word.get("G"), here, to, np.array([word.get("I", 0.0), word.get("J", 0.0)]) + here)
        )
        here = to
    for k, (code, start, stop, centre) in enumerate(ends):
        if k % 2 == 0:
            continue
        corner = places[k // 2]
        before, behind = corner - ends[k - 1][1], ends[k + 1][2] - corner
        before, behind = before / np.linalg.norm(before), behind / np.linalg.norm(behind)
        assert np.linalg.norm(corner - start) == pytest.approx(
            np.linalg.norm(corner - stop), abs=1e-4
        )
        assert turn(before, corner - start) == pytest.approx(0, abs=1e-3)
        assert turn(behind, stop - corner) == pytest.approx(0, abs=1e-3)
        if kind == "RND":
            assert np.linalg.norm(start - centre) == pytest.approx(size, abs=1e-4)
            assert np.linalg.norm(stop - centre) == pytest.approx(size, abs=1e-4)
            assert (centre - start) @ before == pytest.approx(0, abs=1e-3)
            assert (centre - stop) @ behind == pytest.approx(0, abs=1e-3)
            assert code == (3 if turn(before, behind) > 0 else 2)
        elif kind == "CHF":
            assert np.linalg.norm(stop - start) == pytest.approx(size, abs=1e-4)
        else:
            assert np.linalg.norm(corner - start) == pytest.approx(size, abs=1e-4)


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("G1 X50 RND=60|Y40", "RND=60 begins 60 before the corner, and a line there has 40"),
        ("G1 X50 RND=5|G2 X60 Y10 CR=10", "RND at a motion that is no straight feed"),
        ("G1 X50 RND=5|G0 Y9", "RND at a motion that is no straight feed"),
        ("G1 X50 RND=5|Z9", "RND between this block and another one that is no straight feed"),
        ("G1 X50 RND=5|X60 Z9", "RND at a line that leaves the plane"),
        ("G1 X50 RND=5 FRC=50|Y9", "FRC beside corners"),
        ("G1 X50 RND=5 CHF=1|Y9", "RND and CHF in one block"),
        ("G1 X50 CHF=0|Y9", "CHF=0"),
        ("G1 X50 RND=5|X40", "RND where the line runs back"),
        ("G1 X50 RND=5|TRANS X5|Y9", "TRANS at a line with RND"),
        ("G1 X50 RND=5|G41 Y9", "G41 at a line with RND"),
        ("G1 X50 RND=5|G111 X0 Y0|AP=5 RP=9", "RND between this block|beside polar|G111"),
        ("DIAM90|G91 G2 X10 Y9 AR=90", "AR= under DIAM90"),
        ("G1 X50 RNDM=5|RNDM=0|Y50", "RNDM changes behind a line that it rounds"),
        ("SCALE X2 Y2|G1 X50 Y9 RND=5|X0 Y40", "a corner does not keep its size|RND or CHF within"),
    ],
)
def test_what_is_no_corner_between_two_lines_is_refused(program, says):
    with pytest.raises(ProgramError, match=says):
        plain("G1 F100|" + program)
