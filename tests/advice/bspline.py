"""Sentences on control points of B-splines (Sinumerik)."""

from __future__ import annotations

from tests.advice.follow import NOWHERE, WRITE, Case

FIVE = {"machine": "example-five-axis"}
LED = "G90 G17 G0 X0 Y0 Z5|G1 X5 Y5 F100|"
POINTS = "BSPLINE X6 Y6 PL=1|X7 Y8 PL=1|X8 Y9 PL=1"
TURNS = "BSPLINE X6 Y4 PL=1|X7 Y6 PL=1|X8 Y4 PL=1|X9 Y6 PL=1"
OPEN = TURNS.replace("X7 Y6 PL=1", "X7 Y6 PL=2")  # where the knots are
TIP = "G90 G0 X100 Y100 Z0 A0 C0|TRAORI|"


def spline(before: str, after: str, then: str = "", **options) -> Case:
    return Case("siemens", before, after, then, **options)


ALL = [
    spline("G90 G17 G0 Z5|" + POINTS, LED + POINTS, how={"start": NOWHERE}),
    spline(
        "G90 G0 X100 Y100 Z0 A0 C0|BSPLINE X110 C10 F9",
        "G90 G0 X100 Y100 Z0 A0 C0|G1 X105 C5 F9|X110 C10",
        how=FIVE,
    ),
    spline(LED + "BSPLINE X6 Y4|X7 Y6", LED + "G1 X6 Y4|X7 Y6"),
    spline(LED + "G0 X6 Y7|" + POINTS, LED + "G0 X4 Y3|G1 X5 Y5|" + POINTS),
    spline(LED + TURNS, LED + TURNS, also=WRITE),
    spline(LED + OPEN, LED + OPEN, "is not written out, because its PL leave open", also=WRITE),
    spline(LED + OPEN, LED + TURNS, how=WRITE),
    spline(LED + "ASPLINE X6 Y6|X7 Y8|X8 Y9", LED + POINTS),
    spline(LED + "CSPLINE X6 Y6|X7 Y8|X8 Y9", LED + "G1 X6 Y6|X7 Y8|X8 Y9"),
    spline(LED + POINTS + " RND=1", LED + POINTS),
    spline(TIP + "BSPLINE X101 Y101 F9", TIP + "G1 X101 Y101 F9", how=FIVE),
    spline(LED + "G41 X5.5|" + POINTS, LED + "G40 X5.5|" + POINTS),
    spline(LED + POINTS + "|SUPA X9", LED + POINTS + "|X9 PL=1"),
]
