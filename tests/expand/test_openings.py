"""AR= of Sinumerik: the same arc as by its radius CR=, and by its end."""

from __future__ import annotations

import math
import random

import pytest

from tests.expand.plain_lines import expand, motions

PLANES = {17: "XY", 18: "ZX", 19: "YZ"}
CENTRES = {"X": "I", "Y": "J", "Z": "K"}


def arc(program: str) -> dict:
    found = motions(expand(program.replace("|", "\n"), "siemens"), "siemens")[-1]
    assert found["kind"] == "arc" and not found["reason"][0], (program, found["reason"])
    return found


def same(one: dict, other: dict) -> None:
    for what in ("end", "centre"):
        assert list(map(float, one[what])) == pytest.approx(list(map(float, other[what])), abs=1e-4)
    assert one["sweep"] == pytest.approx(other["sweep"], abs=1e-4)


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("distance", ["G90", "G91"])
@pytest.mark.parametrize("beside", [True, False], ids=["in its block", "before"])
def test_an_opening_is_a_radius_and_a_centre(plane, distance, beside):
    """The radius is the chord by twice the sine of half the angle; a plane, and G91, hold in the
    block that names them too."""
    pick, (a, b) = random.Random(plane), PLANES[plane]
    for _ in range(8):
        start = {x: round(pick.uniform(-9, 9), 3) for x in "XYZ"}
        way = [round(pick.uniform(4, 20) * pick.choice([-1, 1]), 3) for _ in range(2)]
        angle = pick.choice([pick.uniform(10, 170), pick.uniform(190, 350)])
        turn = pick.choice([2, 3])
        words = [
            f"{x}{w if distance == 'G91' else w + start[x]:.3f}"
            for x, w in zip((a, b), way, strict=True)
        ]
        radius = math.hypot(*way) / 2 / math.sin(math.radians(angle) / 2)
        begin = "G71 G90 G94 G0 " + " ".join(f"{x}{v}" for x, v in start.items())
        codes = f"G{plane} {distance}"
        head = f"{begin}|{codes} " if beside else f"{begin}|{codes}|"
        arc_of = f"{head}G{turn} {' '.join(words)} F100 "
        by_angle = arc(f"{arc_of}AR={angle:.7f}")
        same(by_angle, arc(f"{arc_of}CR={radius if angle < 180 else -radius:.7f}"))
        # By its centre, from the start, the end is the same.
        k = ["XYZ".index(x) for x in (a, b)]
        by_end = [float(c) - start[x] for c, x in zip(by_angle["centre"], (a, b), strict=True)]
        words = [f"{CENTRES[x]}{v:.6f}" for x, v in zip((a, b), by_end, strict=True)]
        by_centre = arc(f"{head}G{turn} {' '.join(words)} AR={angle:.7f} F100")
        assert [float(by_centre["end"][i]) for i in k] == pytest.approx(
            [start[x] + w for x, w in zip((a, b), way, strict=True)], abs=1e-3
        )
