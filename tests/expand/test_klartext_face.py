"""Cycle 232 of Heidenhain Klartext by "Face milling (cycle 232)" of the TNC 640's Cycle Programming
manual, page 236; every figure by hand, and what the tool passes measured on its ways."""

from __future__ import annotations

import random

import numpy as np
import pytest

from postproc.errors import ProgramError
from tests.expand.test_klartext import places, plain

FACE = (
    "TOOL DEF 5 L+0 R+9|TOOL CALL 5 Z S1000 DR+1|L X+50 Y+20 Z+90 R0 F900 M3|CYCL DEF 232 FACE ~|"
    "Q389=+2 ~|Q225=+10 ~|Q226=+20 ~|Q227=+3 ~|Q386=-1.5 ~|Q218=+100 ~|Q219=+40 ~|Q202=+2 ~|"
    "Q369=+0.5 ~|Q370=+1.5 ~|Q207=+500 ~|Q385=+800 ~|Q253=+750 ~|Q200=+2 ~|Q357=+3 ~|Q204=+50|"
    "CYCL CALL|L X+90"
)


def lines_of(program: str) -> list[str]:
    """What stands for the call."""
    lines = plain(program)
    at = max(i for i, line in enumerate(lines) if line.strip().startswith(("Q204", "CYCL")))
    return lines[at + 1 :]


def test_line_by_line_by_hand():
    """Radius 10: the lines begin 13 outside of 10 and 110; 40 in strips of 15 at most are three of
    13.333, whose middles are 26.667, 40 and 53.333. 4 less 0.5 in depths of 2: 1 and -1, then -1.5
    at the finishing feed; each next depth in reverse."""
    first = [
        "L X-3 Y+26.6667 FMAX", "L Z+53 FMAX",
        "L Z+1 F750", "L X+123 Y+26.6667 F500",
        "L Z+3 F750", "L X-3 Y+40", "L Z+1", "L X+123 Y+40 F500",
        "L Z+3 F750", "L X-3 Y+53.3333", "L Z+1", "L X+123 Y+53.3333 F500",
    ]  # fmt: skip
    second = [
        "L Z-1 F750", "L X-3 Y+53.3333 F500",
        "L Z+1 F750", "L X+123 Y+40", "L Z-1", "L X-3 Y+40 F500",
        "L Z+1 F750", "L X+123 Y+26.6667", "L Z-1", "L X-3 Y+26.6667 F500",
    ]  # fmt: skip
    found = lines_of(FACE)
    assert found[:12] == first
    assert found[12:22] == second
    assert found[22:24] == ["L Z-1.5 F750", "L X+123 Y+26.6667 F800"]
    assert found[-2:] == ["L Z+53 FMAX", "L X+90 F900"]


def test_to_and_fro_by_hand():
    """Over to the next line in the plane, beside the surface; below the second clearance the tool
    goes up first."""
    program = (
        FACE.replace("Q389=+2", "Q389=+0").replace("Z+90", "Z+20").replace("Q369=+0.5", "Q369=+0")
    )
    found = lines_of(program)
    assert found[:9] == [
        "L Z+53 FMAX", "L X-3 Y+26.6667 FMAX", "L Z+1.5 F750",
        "L X+123 Y+26.6667 F500", "L X+123 Y+40 F750",
        "L X-3 Y+40 F500", "L X-3 Y+53.3333 F750", "L X+123 Y+53.3333 F500",
        "L Z+0 F750",
    ]  # fmt: skip
    assert found[14:16] == ["L Z-1.5 F750", "L X+123 Y+26.6667 F800"]


@pytest.mark.parametrize("seed", range(12))
def test_the_tool_passes_all_of_the_surface_and_stays_beside_it(seed):
    rng = random.Random(seed)
    radius, factor = rng.uniform(2, 20), rng.uniform(0.4, 2.0)
    x, y = rng.uniform(-50, 50), rng.uniform(-50, 50)
    long, wide = rng.choice([-1, 1]) * rng.uniform(5, 90), rng.choice([-1, 1]) * rng.uniform(5, 90)
    program = FACE
    for number, value in (
        (389, rng.choice([0, 2])), (225, x), (226, y), (218, long), (219, wide), (370, factor),
    ):  # fmt: skip
        at = program.index(f"Q{number}=")
        program = program[:at] + f"Q{number}={value:+.4f}" + program[program.index(" ~", at) :]
    program = program.replace("R+9", f"R+{radius - 1:.4f}")
    found = [p for p in places(lines_of(program), (50.0, 20.0, 90.0)) if p[2] < 2.5]
    assert min(p[2] for p in found) == -1.5
    low = np.array([p[:2] for p in found if p[2] == -1.5])
    way = np.vstack([np.linspace(a, b, 400) for a, b in zip(low, low[1:], strict=False)])
    u, v = np.random.default_rng(seed).uniform(0, 1, (2, 300))
    surface = np.c_[x + u * long, y + v * wide]
    away = [np.hypot(*(way - p).T).min() for p in surface]
    assert max(away) < radius + 0.2
    edge = radius + 3 + 1e-3
    assert abs(low[:, 0] - x - long / 2).max() <= abs(long) / 2 + edge
    assert abs(low[:, 1] - y - wide / 2).max() <= max(abs(wide) / 2, 0) + 1e-3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Q389=+2", "Q389=+1", "with Q389 1"),
        ("Q386=-1.5", "Q386=+9", "with Q386 above Q227"),
        ("Q202=+2", "Q202=+0", "takes too many depths"),
        ("Q218=+100", "Q218=+0", "without the sizes"),
        ("TOOL DEF 5 L+0 R+9|", "", "the radius of the tool of cycle 232 is not stated"),
    ],
)
def test_what_is_not_followed_is_refused(old, new, message):
    with pytest.raises(ProgramError, match=message):
        plain(FACE.replace(old, new))
