"""G70 G71 (holes on a circle, on an arc) and G101 of Haas mills, by the operator's manual."""

from __future__ import annotations

import pytest

from postproc.errors import ProgramError
from tests.expand.plain_lines import expand as lines_of

HEAD = "G17 G90 G0 X1. Y2. Z5.\nF100.\n"


def expand(text, dialect):
    """The texts of the plain lines."""
    return [line.text.decode() for line in lines_of(text.rstrip(), dialect)]


L0 = "G81 Z-5. R2. L0\n"


def holes(text):
    """Where the holes are, X and Y as places."""
    at, found = {"X": 1.0, "Y": 2.0}, []
    for line in expand(HEAD + text, "haas"):
        words = {w[0]: float(w[1:]) for w in line.split() if w[0] in "XYZ"}
        if "G91" in line:
            raise AssertionError("the places below are read as G90's")
        at |= {x: words[x] for x in "XY" if x in words}
        if line.startswith("G1") and words.get("Z") == -5:
            found.append((at["X"], at["Y"]))
    return found


@pytest.mark.parametrize(
    ("text", "places"),
    [
        (f"{L0}G70 I20. J0. L4\n", [(21, 2), (1, 22), (-19, 2), (1, -18)]),
        (f"{L0}G71 I20. J30. K60. L2\n", [(18.3205, 12), (1, 22)]),
        (f"{L0}G71 I20. J90. K-90. L2\n", [(1, 22), (21, 2)]),
        (f"{L0}G70 X10. Y10. I5. J90. L2\n", [(10, 15), (10, 5)]),
        ("G81 Z-5. R2. G70 I20. J0. L2\n", [(21, 2), (-19, 2)]),
        (f"{L0}G70 I20. J0. L1\nX50. Y50.\nG70 I5. J0. L1\n", [(21, 2), (50, 50), (55, 50)]),
        (f"G101 X0\n{L0}G70 I20. J0. L2\n", [(-19, 2), (21, 2)]),
    ],
)  # fmt: skip
def test_a_hole_at_each_place(text, places):
    assert holes(text) == [pytest.approx(place, abs=1e-3) for place in places]


def test_distances_lead_to_the_same_places():
    """G91 in the block of G70 counts there: X2 moves the centre, and each place is a distance."""
    made = [
        line
        for line in expand(f"{HEAD}{L0}G91 G70 X2. I20. J0. L2\nG90 G80\n", "haas")
        if "X" in line
    ][1:]
    steps = [[float(w[1:]) for w in line.split() if w[0] in "XY"] for line in made]
    assert steps == [[22, 0], [-40, 0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G70 I20. J0. L4\n", "G70 without a canned cycle"),
        (f"{L0}G70 J0. L4\n", "G70 without I"),
        (f"{L0}G71 I20. J0. L4\n", "G71 without K"),
        (f"{L0}G70 I20. J0. L1.5\n", "L1.5 of G70"),
        (f"{L0}G70 I20. J30 L4\n", "the angle J30 has no decimal point"),
        ("G83 Z-5. R2. Q1. G70 I20. J0. L4\n", "G83 in the block of G70"),
        (f"{L0}G18\nG70 I20. J0. L4\n", "outside the XY plane"),
        (f"{L0}X9. L0\nG70 I20. J0. L4\n", "X9 stands in a block with L0"),
    ],
)
def test_what_is_not_certain_is_refused(text, message):
    with pytest.raises(ProgramError, match=message):
        expand(HEAD + text + "G80\nG0 X0\n", "haas")


@pytest.mark.parametrize(
    ("text", "last"),
    [
        ("G101 X0\nG0 X3. Y4.", "X-3."),
        ("G101 X0 Y0\nG100 X0\nG0 X3. Y4.", "X3."),
        ("G101 X0\nG100 X0 Y0\nG0 X3. Y4.", "X3."),
    ],
)
def test_g101_mirrors_about_the_work_zero(text, last):
    assert last in expand(HEAD + text + "\n", "haas")[-1]


def test_a_mirrored_arc_turns_the_other_way():
    made = expand(f"{HEAD}G101 X0\nG2 X11. Y12. I10. J0.\n", "haas")
    assert made[-1].split()[0] == "G3"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G101 X5.\n", "X5. in G101"),
        ("G101\n", "G101 without an axis"),
        ("G101 X0\nG100\n", "G100 without an axis"),
        ("G101 X0\nG68 X0 Y0 R30.\n", "together with a mirror"),
    ],
)
def test_mirrors_that_are_refused(text, message):
    with pytest.raises(ProgramError, match=message):
        expand(HEAD + text + "G0 X0 Y0\n", "haas")
