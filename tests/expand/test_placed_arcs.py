"""CIP and CT of Sinumerik: the same arcs as by their centres."""

from __future__ import annotations

import cmath
import math
import random

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import expand, motions, text_of

PLANES = {17: "XY", 18: "ZX", 19: "YZ"}
CENTRES = {"X": "I", "Y": "J", "Z": "K"}
WITHIN = {"X": "I1", "Y": "J1", "Z": "K1"}
HEAD = "G71 G90 G94 DIAMOF F100"


def arcs(program: str) -> list[dict]:
    found = motions(expand(program.replace("|", "\n"), "siemens"), "siemens")
    assert not any(m["reason"][0] for m in found), program
    return [m for m in found if m["kind"] == "arc"]


def same(one: list[dict], other: list[dict]) -> None:
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        for what in ("end", "centre"):
            assert list(map(float, a[what])) == pytest.approx(list(map(float, b[what])), abs=2e-3)
        assert a["sweep"] == pytest.approx(b["sweep"], abs=1e-3)


def words(names: str, letters: dict[str, str], point: complex, form: str = "{}") -> str:
    """Two words of a plane's point; `form` wraps each number."""
    pairs = zip(names, (point.real, point.imag), strict=True)
    return " ".join(
        f"{letters.get(x, x)}{'=' if letters or form != '{}' else ''}{form.format(f'{v:.5f}')}"
        for x, v in pairs
    )


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("how", ["G90", "G91", "IC", "AC under G91"])
def test_an_arc_through_a_point(plane, how):
    """The three points lie on the circle, and the middle one says which way round."""
    pick, names = random.Random(f"{plane}{how}"), PLANES[plane]
    form = {"IC": "IC({})", "AC under G91": "AC({})"}.get(how, "{}")
    code = "G91" if "G91" in how else "G90"
    for _ in range(3):
        centre = complex(pick.uniform(-20, 20), pick.uniform(-20, 20))
        spoke = cmath.rect(pick.uniform(3, 30), pick.uniform(0, math.tau))
        turn = pick.choice([-1, 1]) * pick.uniform(0.5, 5.5)
        inner = centre + spoke * cmath.exp(1j * turn * pick.uniform(0.2, 0.8))
        start, end = centre + spoke, centre + spoke * cmath.exp(1j * turn)
        off = start if how in ("G91", "IC") else 0j
        begin = f"{HEAD} G{plane}|G0 X0 Y0 Z0|G0 {words(names, {}, start)}|"
        cip = f"CIP {words(names, {}, end - off, form)} {words(names, WITHIN, inner - off, form)}"
        g = f"G{3 if turn > 0 else 2} {words(names, {}, end)} "
        g += words(names, CENTRES, centre - start).replace("=", "")
        same(arcs(f"{begin}{code}|{cip}"), arcs(begin + g))


def test_the_manuals_arc_through_a_point():
    """SINUMERIK 808D ADVANCED (Milling), page 98: N5 G90 X30 Y40, N10 CIP X50 Y40 I1=40 J1=45; by
    hand: the centre lies at X40 Y32.5."""
    assert text_of("G71 G17 G0 Z0 F100|N5 G90 X30 Y40|N10 CIP X50 Y40 I1=40 J1=45", "siemens")[
        -1
    ] == ("N10 G2 I10. J-7.5 X50 Y40")


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("distance", ["G90", "G91"])
@pytest.mark.parametrize("before", ["line", "arc by its centre", "arc by its radius", "CT"])
def test_an_arc_along_the_tangent(plane, distance, before):
    """It leaves along the way of the segment before it, and ends where it should."""
    pick, names = random.Random(f"{plane}{distance}{before}"), PLANES[plane]
    for _ in range(3):
        first = complex(pick.uniform(-9, 9), pick.uniform(-9, 9))
        way = cmath.rect(1.0, pick.uniform(0, math.tau))
        start = first + way * pick.uniform(2, 9)
        segment = f"G1 {words(names, {}, start)}"
        if before != "line":  # a half turn of an arc
            middle = (first + start) / 2
            turn, large = pick.choice([2, 3]), pick.choice([-1, 1])
            if before == "arc by its radius":
                radius = abs(start - first) * 0.8
                segment = f"G{turn} {words(names, {}, start)} CR={large * radius:.6f}"
                height = math.sqrt(radius**2 - abs(start - first) ** 2 / 4)
                middle += 1j * way * height * large * (1 if turn == 3 else -1)
            else:
                centre = words(names, CENTRES, middle - first).replace("=", "")
                segment = f"G{turn} {words(names, {}, start)} {centre}"
            way = (start - middle) * (1j if turn == 3 else -1j)
            way /= abs(way)
        chords = [cmath.rect(7, pick.choice([-1, 1]) * pick.uniform(0.3, 2.6)) for _ in range(2)]
        begin = f"{HEAD} G{plane}|G0 X0 Y0 Z0|G0 {words(names, {}, first)}|{segment}|"
        theirs, mine, at = [], [], start
        for k, chord in enumerate(chords[: 2 if before == "CT" else 1]):
            chord *= way  # so that it bends off the tangent
            end = at + chord
            radius = abs(chord) ** 2 / (2 * (chord * (1j * way).conjugate()).real)
            g = f"G{3 if radius > 0 else 2} {words(names, {}, end)} "
            theirs.append(g + words(names, CENTRES, 1j * way * radius).replace("=", ""))
            place = words(names, {}, end - at if distance == "G91" else end)
            mine.append(("CT " if not k else "") + place)  # it holds until another code
            way = (end - at - 1j * way * radius) * (1j if radius > 0 else -1j)
            way, at = way / abs(way), end
        same(arcs(begin + f"M8|{distance}|" + "|".join(mine)), arcs(begin + "|".join(theirs)))


def test_a_diameter_is_the_way_of_an_arc_along_the_tangent():
    text = text_of("G71 G90 G18 DIAMON F1|G0 X20 Z0|G1 Z-5|CT X30 Z-10", "siemens")
    assert text[-1] == "G2 K0. I5. X30 Z-10"


@pytest.mark.parametrize(
    ("blocks", "said"),
    [
        ("CIP X9 Y0 I1=5 J1=0", "one straight line"),
        ("CIP X0 Y0 I1=5 J1=5", "twice through one"),
        ("CIP X9 Y0 I1=5", "without both"),
        ("CIP X9 Y0 Z3 I1=5 J1=3", "leaves the plane"),
        ("CIP X9 Y0 I1=5 J1=3 K1=2", "leaves the plane"),
        ("CIP X9 Y0 I1=5 J1=3 CR=9", "CR beside CIP"),
        ("G18 DIAMON|CIP X9 Z0 I1=5 K1=3", "X is a diameter"),
        ("CT X9 Y5", "not known"),
        ("G1 X9|Z5|CT X12 Y3", "not known"),
        ("G1 X9|G18|CT X12 Z3", "not known"),
        ("G1 X9|TRANS X5|CT X12 Y3", "not known"),
        ("G1 X9|ROT RPL=90|CT X12 Y3", "not stated|not known"),
        ("G1 X9|T2 M6|CT X12 Y3", "not known"),
        ("G1 X9|CT X12 Y0", "straight ahead"),
        ("G1 X9|CT X5 Y0", "straight ahead"),
        ("G1 X9|CT X12 Y3 RND=2", "RND beside CT"),
    ],
)
def test_what_stays_refused(blocks, said):
    with pytest.raises(ProgramError, match=said):
        text_of("G71 G90 G17 DIAMOF F100|G0 X0 Y0 Z0|M8|G4 F1|" + blocks, "siemens")
