"""G71 and G72 of LinuxCNC over shapes with pockets, whole, without them and of them alone: random
ones on its interpreter."""

from __future__ import annotations

import random

import pytest

from postproc.errors import ProgramError
from tests.campaigns import cases
from tests.linuxcnc import oracle
from tests.linuxcnc.test_against_linuxcnc import ours
from tests.linuxcnc.test_expanded import written_out

MANY = cases(40, 80)


def shape(choose: random.Random, face: bool) -> list[str]:
    """A chain of lines and arcs that goes towards -Z (of G72: towards -X) and rises and falls."""
    along, deep = choose.uniform(-1, 0), choose.uniform(2, 6)
    letters = "ZX" if not face else "XZ"
    start = (lambda a, d: (a, d)) if not face else (lambda a, d: (a + 20, d - 10))  # noqa: E731
    a, d = start(along, deep)
    lines = [f"G0 {letters[1]}{d:.3f}" + f" {letters[0]}{a:.3f}" * choose.randint(0, 1)]
    for _ in range(choose.randint(2, 6)):
        step, rise = choose.uniform(0.5, 4), choose.uniform(-3, 4) * (choose.random() < 0.7)
        along, deep = along - step, max(0.5, deep + rise)
        a, d = start(along, deep)
        code, more = "G1", ""
        if choose.random() < 0.3:
            code, more = choose.choice(["G2", "G3"]), f" R{choose.uniform(20, 40):.3f}"
        lines.append(f"{code} {letters[0]}{a:.3f} {letters[1]}{d:.3f}{more}")
    return lines


def program(seed: int) -> str:
    choose = random.Random(seed)
    face = choose.random() < 0.4
    # G72.2 never ends on LinuxCNC
    code = choose.choice(["72", "72.1"] if face else ["71", "71.1", "71.2"])
    distance = f" D{choose.uniform(0.05, 0.3):.3f}" * (choose.random() < 0.3)
    words = f"I{choose.uniform(0.7, 3):.3f} R{choose.uniform(0.1, 1):.3f}{distance}"
    begin = "G0 X24 Z2" if face else "G0 X12 Z2"
    body = "\n".join(shape(choose, face))
    diameter = "G7 " * (choose.random() < 0.2)
    return (
        f"O100 SUB\n{body}\nO100 ENDSUB\nF100\nG18 {diameter}{begin}\nG{code} Q100 {words}\nG0"
        " X30\nM2\n"
    )


@pytest.fixture(scope="module")
def theirs():
    if reason := oracle.available():
        pytest.skip(reason)
    return oracle.motions_of_many([(program(seed), {}) for seed in range(MANY)])


def test_pockets_are_roughed_as_linuxcnc_does(theirs):
    same = 0
    for seed, made in enumerate(theirs):
        text = program(seed)
        try:
            mine = ours(written_out(text, {}), {})
        except ProgramError:
            continue  # it must be no other motion; how often is counted below
        assert isinstance(made, list), (text, made)
        made = [
            m
            for m in made
            if m.kind == "arc"
            or max(abs(a - b) for a, b in zip(m.start, m.end, strict=True)) > 1e-9
        ]
        assert [m["kind"] for m in mine] == [m.kind for m in made], text
        for a, b in zip(mine, made, strict=True):
            assert a["end"][:3] == pytest.approx(b.end[:3], abs=1e-6), text
            if b.kind == "arc":
                assert a["centre"] == pytest.approx(b.centre, abs=1e-6), text
                assert (a["sweep"] > 0) == (b.turns > 0), text
        same += 1
    legal = sum(isinstance(made, list) for made in theirs)
    assert legal >= MANY * 0.5 and same >= legal * 0.85, (same, legal)
